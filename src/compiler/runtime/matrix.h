// SPDX-License-Identifier: Apache-2.0
// Instructions that the 32 lanes of a warp execute together on matrices spread over their registers
// (mma, wmma, ldmatrix, stmatrix, movmatrix). Each lane stores its operands in a block of its
// frame. When all lanes have stored theirs, one lane computes the results of all
// (runtime/matrix_calls.cpp). matrix.cpp has the positions of elements, matrix_sums.cpp the sums of
// products.
#pragma once

#include <cstdint>

namespace sunstone::compiler {

enum class MatrixKind : uint8_t {
    kMultiply,  // in: A, B, C; out: D
    kLoadRows,  // ldmatrix. in: an address of two words; out: a word for each matrix
    kStoreRows, // stmatrix. in: an address of two words, a word for each matrix
    kTranspose, // movmatrix. in: a word; out: a word
};

enum class MatrixType : uint8_t {
    kF16,
    kBF16,
    kTF32,
    kF32,
    kF64,
    kE4M3,
    kE5M2,
    kS8,
    kU8,
    kS4,
    kU4,
    kB1, // 32 of them: a word is an element, and k counts words
    kS32,
    kNone,
};

unsigned bitsOfElement(MatrixType type);
inline bool isFloat(MatrixType type) {
    return type <= MatrixType::kE5M2;
}

enum MatrixFlag : uint8_t {
    kMatrixSaturates = 1, // sums of integers
    kMatrixAnd = 2,       // of bits; else exclusive or
    kMatrixTransposes = 4,
    kMatrixWide = 8,      // wmma: fragments as made by wmma.load
    kMatrixColumnsA = 16, // layouts of the fragments of m8n8k4 with halves
    kMatrixRowsB = 32,
};

// The operation; compiled code writes it into the block as three words.
struct MatrixOperation {
    MatrixKind kind = MatrixKind::kMultiply;
    uint8_t m = 0, n = 0;
    uint8_t flags = 0;
    uint16_t k = 0; // kLoadRows, kStoreRows: matrices
    MatrixType a = MatrixType::kNone, b = MatrixType::kNone;
    MatrixType c = MatrixType::kNone, d = MatrixType::kNone;
    uint8_t rounding = 0; // of f64: compiler::Rounding
    uint8_t reserved = 0;

    bool has(MatrixFlag flag) const { return flags & flag; }
    // Four products at once, one for each eight lanes.
    bool isQuad() const { return a == MatrixType::kF16 && k == 4; }
};
static_assert(sizeof(MatrixOperation) == 12);

constexpr unsigned kMatrixInputs = 32, kMatrixOutputs = 8;
struct MatrixBlock {
    MatrixOperation operation;
    uint32_t reserved;
    uint32_t in[kMatrixInputs];
    uint32_t out[kMatrixOutputs];
};

enum class MatrixOperand : uint8_t { kA, kB, kC, kD };
MatrixType typeOfOperand(const MatrixOperation& operation, MatrixOperand operand);
// Elements in the registers of one lane.
unsigned elementsOf(const MatrixOperation& operation, MatrixOperand operand);
// 32-bit words that they take.
unsigned wordsOf(const MatrixOperation& operation, MatrixOperand operand);

// The position of a lane's element in its matrix.
struct MatrixPlace {
    unsigned row, column;
};
MatrixPlace placeOf(const MatrixOperation& operation, MatrixOperand operand, unsigned lane,
                    unsigned element);

// Converts bits of elements of A or B, in place, to the form that sumProducts takes.
void prepareFactors(const MatrixOperation& operation, MatrixType type, uint64_t* values,
                    unsigned count);
// The bits of the sum of the products a[i] * b[i], i below `count`, and of c, as an H100 gives
// them. Computes in the processor's default mode.
uint64_t sumProducts(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                     unsigned count, uint64_t c);

// Fills the results in the blocks of all lanes of `present`; `addresses` are the blocks'. Absent
// lanes count as zeros.
void computeMatrix(const uint64_t addresses[32], uint32_t present);

} // namespace sunstone::compiler
