// SPDX-License-Identifier: Apache-2.0
// See matrix.h. The positions of elements in lanes, and the instructions except their sums. Source:
// PTX ISA manual, "Matrix Fragments for mma" and the sections around it; fragments of wmma, which
// the manual leaves open, are those of an H100.
#include "compiler/runtime/matrix.h"

#include "base/error.h"

#include <bit>
#include <cstring>
#include <utility>
#include <xmmintrin.h>

namespace sunstone::compiler {

namespace {

constexpr unsigned kLanes = 32;
constexpr unsigned kMostFactors = 16 * 64, kMostSums = 256; // numbers of elements of A or B, of C
                                                            // or D

// Bits of element `i` of a lane's registers.
uint64_t readElement(const uint32_t* words, unsigned bits, unsigned i) {
    if (bits == 64)
        return uint64_t(words[2 * i + 1]) << 32 | words[2 * i];
    const unsigned perWord = 32 / bits;
    const uint32_t word = words[i / perWord] >> (i % perWord * bits);
    return bits == 32 ? word : word & ((1u << bits) - 1);
}

void writeElement(uint32_t* words, unsigned bits, unsigned i, uint64_t value) {
    if (bits == 64) {
        words[2 * i] = uint32_t(value);
        words[2 * i + 1] = uint32_t(value >> 32);
    } else if (bits == 32) {
        words[i] = uint32_t(value);
    } else {
        std::memcpy(reinterpret_cast<char*>(words) + i * bits / 8, &value, bits / 8);
    }
}

unsigned rowsOf(const MatrixOperation& operation, MatrixOperand operand) {
    return operand == MatrixOperand::kB ? operation.k : operation.m;
}
unsigned columnsOf(const MatrixOperation& operation, MatrixOperand operand) {
    return operand == MatrixOperand::kA ? operation.k : operation.n;
}

// m8n8k4 of halves: lanes l and l + 16, for l = 4 q to 4 q + 3, make product q.
MatrixPlace quadPlace(const MatrixOperation& operation, MatrixOperand operand, unsigned lane,
                      unsigned i) {
    const unsigned low = lane % 4, half = lane / 16 * 4;
    switch (operand) {
    case MatrixOperand::kA:
        return operation.has(kMatrixColumnsA) ? MatrixPlace{i + half, low}
                                              : MatrixPlace{low + half, i};
    case MatrixOperand::kB:
        return operation.has(kMatrixRowsB) ? MatrixPlace{low, i + half}
                                           : MatrixPlace{i, low + half};
    default:
        if (typeOfOperand(operation, operand) == MatrixType::kF16)
            return {low + half, i};
        return {(lane & 1) + (i & 2) + half, (i & 4) + (lane & 2) + (i & 1)};
    }
}

} // namespace

unsigned bitsOfElement(MatrixType type) {
    switch (type) {
    case MatrixType::kF64:
        return 64;
    case MatrixType::kF16:
    case MatrixType::kBF16:
        return 16;
    case MatrixType::kE4M3:
    case MatrixType::kE5M2:
    case MatrixType::kS8:
    case MatrixType::kU8:
        return 8;
    case MatrixType::kS4:
    case MatrixType::kU4:
        return 4;
    default:
        return 32;
    }
}

MatrixType typeOfOperand(const MatrixOperation& operation, MatrixOperand operand) {
    switch (operand) {
    case MatrixOperand::kA:
        return operation.a;
    case MatrixOperand::kB:
        return operation.b;
    case MatrixOperand::kC:
        return operation.c;
    default:
        return operation.d;
    }
}

unsigned elementsOf(const MatrixOperation& operation, MatrixOperand operand) {
    const unsigned all = rowsOf(operation, operand) * columnsOf(operation, operand);
    if (operation.isQuad())
        return all * 4 / kLanes;
    // A fragment of halves always has eight registers.
    if (operation.has(kMatrixWide) && typeOfOperand(operation, operand) == MatrixType::kF16 &&
        (operand == MatrixOperand::kA || operand == MatrixOperand::kB))
        return 16;
    return all / kLanes;
}

unsigned wordsOf(const MatrixOperation& operation, MatrixOperand operand) {
    return elementsOf(operation, operand) * bitsOfElement(typeOfOperand(operation, operand)) / 32;
}

MatrixPlace placeOf(const MatrixOperation& operation, MatrixOperand operand, unsigned lane,
                    unsigned element) {
    if (operation.isQuad())
        return quadPlace(operation, operand, lane, element);
    // Lane 4 g + t has elements of row g, g + 8, ... of A, C and D and of column g, g + 8, ... of
    // B; of each row or column `run` neighbours in every run of 4 `run`.
    const unsigned g = lane / 4, t = lane % 4;
    const bool isSum = operand == MatrixOperand::kC || operand == MatrixOperand::kD;
    const unsigned bits = bitsOfElement(typeOfOperand(operation, operand));
    const unsigned run = isSum ? 2 : bits >= 32 ? 1 : 32 / bits;
    // Products of 8 by 32 are those of 32 by 8 with A and B exchanged.
    const bool isExchanged = operation.has(kMatrixWide) && operation.m == 8 && operation.n == 32;
    const bool byColumns = isSum ? isExchanged : operand == MatrixOperand::kB;
    const unsigned across = byColumns ? columnsOf(operation, operand) : rowsOf(operation, operand);
    const unsigned along = byColumns ? rowsOf(operation, operand) : columnsOf(operation, operand);
    const unsigned bands = across / 8, runs = along / (4 * run);
    const unsigned part = element % run, block = element / run % (bands * runs);
    unsigned band = 0, far = 0;
    if (isSum) {
        band = block % bands;
        far = block / bands;
    } else if (bands == 1 || (operand == MatrixOperand::kB && bands == 2)) {
        far = block % runs;
        band = block / runs;
    } else { // two bands, then the next run of them
        band = block % 2 + block / (2 * runs) * 2;
        far = block / 2 % runs;
    }
    const unsigned near = g + band * 8, distance = t * run + part + far * 4 * run;
    return byColumns ? MatrixPlace{distance, near} : MatrixPlace{near, distance};
}

namespace {

// Collects the bits of a matrix's elements from the blocks.
void gather(const MatrixOperation& operation, MatrixOperand operand, unsigned firstWord,
            MatrixBlock* const blocks[32], uint32_t present, unsigned quad, bool transposes,
            uint64_t* matrix) {
    const unsigned count = elementsOf(operation, operand);
    const unsigned bits = bitsOfElement(typeOfOperand(operation, operand));
    const unsigned rows = rowsOf(operation, operand), columns = columnsOf(operation, operand);
    for (unsigned lane = 0; lane < kLanes; ++lane) {
        if (operation.isQuad() && lane % 16 / 4 != quad)
            continue;
        for (unsigned i = 0; i < count; ++i) {
            const MatrixPlace place = placeOf(operation, operand, lane, i);
            SUNSTONE_CHECK(place.row < rows && place.column < columns);
            matrix[transposes ? place.column * rows + place.row
                              : place.row * columns + place.column] =
                (present >> lane & 1) ? readElement(blocks[lane]->in + firstWord, bits, i) : 0;
        }
    }
}

void multiply(const MatrixOperation& operation, MatrixBlock* const blocks[32], uint32_t present) {
    const unsigned wordsA = wordsOf(operation, MatrixOperand::kA);
    const unsigned wordsB = wordsOf(operation, MatrixOperand::kB);
    for (unsigned quad = 0; quad < (operation.isQuad() ? 4 : 1); ++quad) {
        uint64_t a[kMostFactors], b[kMostFactors], c[kMostSums], d[kMostSums];
        gather(operation, MatrixOperand::kA, 0, blocks, present, quad, false, a);
        gather(operation, MatrixOperand::kB, wordsA, blocks, present, quad, true, b);
        gather(operation, MatrixOperand::kC, wordsA + wordsB, blocks, present, quad, false, c);
        prepareFactors(operation, operation.a, a, operation.m * operation.k);
        prepareFactors(operation, operation.b, b, operation.n * operation.k);
        for (unsigned row = 0; row < operation.m; ++row)
            for (unsigned column = 0; column < operation.n; ++column)
                d[row * operation.n + column] =
                    sumProducts(operation, a + row * operation.k, b + column * operation.k,
                                operation.k, c[row * operation.n + column]);
        const unsigned count = elementsOf(operation, MatrixOperand::kD);
        const unsigned bits = bitsOfElement(operation.d);
        for (unsigned lane = 0; lane < kLanes; ++lane) {
            if (!(present >> lane & 1) || (operation.isQuad() && lane % 16 / 4 != quad))
                continue;
            for (unsigned i = 0; i < count; ++i) {
                const MatrixPlace place = placeOf(operation, MatrixOperand::kD, lane, i);
                writeElement(blocks[lane]->out, bits, i, d[place.row * operation.n + place.column]);
            }
        }
    }
}

char* addressOf(const MatrixBlock& block) {
    return reinterpret_cast<char*>(uintptr_t(block.in[1]) << 32 | block.in[0]);
}

// ldmatrix and stmatrix: lane 8 q + r has the address of row r of matrix q; lane 4 r + t holds
// elements 2 t and 2 t + 1 of the row, or, transposed, of the column.
void moveRows(const MatrixOperation& operation, MatrixBlock* const blocks[32], uint32_t present) {
    const bool loads = operation.kind == MatrixKind::kLoadRows;
    for (unsigned matrix = 0; matrix < operation.k; ++matrix)
        for (unsigned lane = 0; lane < kLanes; ++lane) {
            if (!(present >> lane & 1))
                continue;
            uint16_t halves[2] = {};
            if (!loads)
                std::memcpy(halves, &blocks[lane]->in[2 + matrix], sizeof halves);
            for (unsigned i = 0; i < 2; ++i) {
                unsigned row = lane / 4, column = lane % 4 * 2 + i;
                if (operation.has(kMatrixTransposes))
                    std::swap(row, column);
                const unsigned owner = matrix * 8 + row;
                if (!(present >> owner & 1))
                    continue;
                char* at = addressOf(*blocks[owner]) + column * 2;
                if (loads)
                    std::memcpy(&halves[i], at, 2);
                else
                    std::memcpy(at, &halves[i], 2);
            }
            if (loads)
                std::memcpy(&blocks[lane]->out[matrix], halves, sizeof halves);
        }
}

void transpose(MatrixBlock* const blocks[32], uint32_t present) {
    uint16_t elements[8][8] = {};
    for (unsigned lane = 0; lane < kLanes; ++lane)
        if (present >> lane & 1)
            std::memcpy(&elements[lane / 4][lane % 4 * 2], blocks[lane]->in, 4);
    for (unsigned lane = 0; lane < kLanes; ++lane)
        if (present >> lane & 1)
            blocks[lane]->out[0] = uint32_t(elements[lane % 4 * 2 + 1][lane / 4]) << 16 |
                                   elements[lane % 4 * 2][lane / 4];
}

} // namespace

void computeMatrix(const uint64_t addresses[32], uint32_t present) {
    MatrixBlock* blocks[kLanes] = {};
    for (unsigned lane = 0; lane < kLanes; ++lane)
        if (present >> lane & 1)
            blocks[lane] = reinterpret_cast<MatrixBlock*>(addresses[lane]);
    const MatrixOperation operation = blocks[std::countr_zero(present)]->operation;
    // The kernel may have set the processor to flush subnormals, which must not affect sums here.
    constexpr unsigned kDefaultMode = 0x1f80;
    const unsigned mode = _mm_getcsr();
    _mm_setcsr(kDefaultMode);
    switch (operation.kind) {
    case MatrixKind::kMultiply:
        multiply(operation, blocks, present);
        break;
    case MatrixKind::kTranspose:
        transpose(blocks, present);
        break;
    default:
        moveRows(operation, blocks, present);
    }
    _mm_setcsr(mode);
}

} // namespace sunstone::compiler
