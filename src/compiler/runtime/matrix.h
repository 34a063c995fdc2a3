// SPDX-License-Identifier: Apache-2.0
// Instructions that the 32 lanes of a warp execute together on matrices spread over their registers
// (mma, wmma, ldmatrix, stmatrix, movmatrix). Each lane leaves its operands in a block of its
// frame; when all are there, one of them computes the results of all (runtime/matrix_calls.cpp). Which
// element stands where, and how products are summed, is in matrix.cpp and matrix_sums.cpp.
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
    kMatrixWide = 8,      // wmma: fragments as wmma.load makes them
    kMatrixColumnsA = 16, // how the fragments of m8n8k4 with halves run
    kMatrixRowsB = 32,
};

// What is to be done; compiled code writes it into the block as three words.
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
// Words of 32 bits they take.
unsigned wordsOf(const MatrixOperation& operation, MatrixOperand operand);

// Where an element of a lane stands in its matrix.
struct MatrixPlace {
    unsigned row, column;
};
MatrixPlace placeOf(const MatrixOperation& operation, MatrixOperand operand, unsigned lane,
                    unsigned element);

// Turns bits of elements of A or B into what sumProducts takes, in their places.
void prepareFactors(const MatrixOperation& operation, MatrixType type, uint64_t* values,
                    unsigned count);
// Bits of a sum of products a[i] * b[i], i below `count`, and of c: those of an H100. Computes in
// the processor's default mode.
uint64_t sumProducts(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                     unsigned count, uint64_t c);

// For all lanes of `present`: fills the results of their blocks, whose addresses these are. Lanes
// that are not there bring zeros.
void computeMatrix(const uint64_t addresses[32], uint32_t present);

} // namespace sunstone::compiler
