// SPDX-License-Identifier: Apache-2.0
// Parallel loops on all threads, as plain functions: files compiled for newer instruction sets must
// not instantiate a library's inline functions, because the linker could use these instances for
// other files.
#pragma once

#include <cstddef>

namespace sunstone::bvh {

using BlockBody = void (*)(void* context, size_t begin, size_t end, size_t block);

// Calls body for [0, count) in blocks of blockSize (the last may be shorter). The blocks do not
// depend on the number of threads.
void forEachBlock(size_t count, size_t blockSize, BlockBody body, void* context);

// The same with a callable body(begin, end, block).
template <class Body>
static inline void parallelBlocks(size_t count, size_t blockSize, Body& body) {
    forEachBlock(
        count, blockSize,
        [](void* context, size_t begin, size_t end, size_t block) {
            (*static_cast<Body*>(context))(begin, end, block);
        },
        &body);
}

} // namespace sunstone::bvh
