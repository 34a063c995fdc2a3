// SPDX-License-Identifier: Apache-2.0
// Copies and sets as values: read from the API's descriptions, checked, and executed any number of
// times.
#pragma once

#include "api/cuda/driver/shell.h"

#include <cstddef>

namespace sunstone::api::cuda {

// One side of a copy: `rows` x `slices` of a pitched block.
struct Side {
    std::byte* base = nullptr;
    size_t pitch = 0;      // between rows
    size_t slicePitch = 0; // between slices
};
struct Shape {
    size_t width = 0, rows = 1, slices = 1; // width in bytes

    bool empty() const { return width == 0 || rows == 0 || slices == 0; }
};

struct Copy {
    Side dst, src;
    Shape shape;
    bool dstDevice = false, srcDevice = false; // must be device memory

    void check() const; // throws Failure unless both ranges are valid
    void run() const;   // throws Failure if a range has become invalid
    // Whether a side is pageable memory of the application, which it may change or free as soon as
    // the call returns. CUDA copies from such memory before the call returns.
    bool touchesPageable() const;
};
Copy linearCopy(const void* dst, const void* src, size_t bytes, bool dstDevice, bool srcDevice);
Copy copyOf(const CUDA_MEMCPY3D& description);
CUDA_MEMCPY3D widen(const CUDA_MEMCPY2D& description);
// A linear copy as graphs show it.
CUDA_MEMCPY3D describe(const Copy& linear);

struct Set {
    Side side;
    size_t width = 0, height = 0; // in elements, rows
    unsigned elementSize = 1, value = 0;

    bool empty() const { return width == 0 || height == 0; }
    void check() const;
    void run() const;
};

} // namespace sunstone::api::cuda
