// SPDX-License-Identifier: Apache-2.0
// Conformance vectors of matrix instructions (mma, wmma, ldmatrix, stmatrix, movmatrix), which the
// 32 lanes of a warp execute together. A case is one instruction; one warp runs it for each of
// kProblems contents of its matrices. matrix_run.cpp runs and compares cases.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace conformance {

constexpr unsigned kProblems = 16;
// The input of a warp: three areas for A, B and C, filled with elements of their types. Lane l's
// own part of an area is the 64 bytes at 64 * l.
constexpr size_t kAreaBytes = 2048, kProblemBytes = 3 * kAreaBytes;
// Its output: 64 bytes for each lane, or one matrix.
constexpr size_t kMatrixResultBytes = 2048;

struct MatrixCase {
    std::string name; // the instruction, and its use where that is not obvious
    // PTX with the registers in (the areas), own (the lane's part of the first), out (the results),
    // mine (the lane's part of them), row (of 16 bytes in `shared`, another one for each lane).
    std::string code;
    std::string types[3]; // of the elements of each area
    bool usesShared = false;
};

const std::vector<MatrixCase>& allMatrixCases();
// The areas of a problem.
std::vector<uint8_t> matrixContent(const MatrixCase& test, unsigned problem);
// The kernel: (areas of all problems, results of all problems), a block of one warp for each.
std::string matrixKernel(const MatrixCase& test);

} // namespace conformance
