// SPDX-License-Identifier: Apache-2.0
#include "bvh/batch/batch.h"

#include "base/float_mode.h"
#include "base/threads/threads.h"

namespace sunstone::bvh {

const BatchKernels& batchKernels(Isa isa) {
    switch (isa) {
    case Isa::kAvx512:
        return kBatchAvx512;
    case Isa::kAvx2:
        return kBatchAvx2;
    default:
        return kBatchBaseline;
    }
}

void traceBatch(const RayBatch& batch, bool any) {
    const DeviceFloatMode mode;
    static const BatchKernels& kernels = batchKernels(chosenIsa());
    const auto run = any ? kernels.any : kernels.closest;
    const uint64_t pieces = pieceCount(batch);
    // Waking another thread takes longer than a few pieces.
    constexpr uint64_t kGrain = 16;
    if (pieces <= kGrain)
        run(batch, 0, pieces);
    else
        parallelFor(pieces, kGrain, [&](size_t begin, size_t end) { run(batch, begin, end); });
}

} // namespace sunstone::bvh
