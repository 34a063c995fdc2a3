// SPDX-License-Identifier: Apache-2.0
#include "bvh/parallel.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace sunstone::bvh {

void forEachBlock(size_t count, size_t blockSize, BlockBody body, void* context) {
    const size_t blocks = (count + blockSize - 1) / blockSize;
    if (blocks <= 1) {
        if (blocks == 1)
            body(context, 0, count, 0);
        return;
    }
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, blocks, 1),
        [=](const tbb::blocked_range<size_t>& range) {
            for (size_t i = range.begin(); i != range.end(); ++i)
                body(context, i * blockSize, std::min(count, (i + 1) * blockSize), i);
        },
        tbb::simple_partitioner());
}

} // namespace sunstone::bvh
