// SPDX-License-Identifier: Apache-2.0
// Relocation on GPUs: a kernel checks that the memory holds a copy of the structure that the
// relocation info describes, and gives instances the handles of their moved children. No other part
// of a block depends on its address (layout.h).
#pragma once

#include "bvh/gpu/build/finish.h"
#include "bvh/gpu/known_handles.h"

namespace sunstone::bvh::gpu {

SUNSTONE_INLINE bool isCopy(const RelocateJob& job) {
    const BlockHeader& is = *at<const BlockHeader>(job.block);
    return is.magic == kGpuBlockMagic && is.version == job.version && is.type == job.type &&
           is.numPrimitives == job.numPrimitives && is.usedSize == job.usedSize;
}

SUNSTONE_INLINE bool isTraversable(const RelocateJob& job, uint64_t handle) {
    const uint64_t tag = handle & devlib::kTagMask;
    return handle == 0 || (tag >= devlib::kTagGas && tag <= devlib::kTagSrtMotion &&
                           handle != tag && isKnownHandle(knownNow(job.known), handle));
}

SUNSTONE_KERNEL sunstone_relocate(RelocateJob job) {
    if (!isCopy(job)) {
        if (globalThread() == 0)
            reportFailure(job.report, job.block, kNoCopy);
        return;
    }
    auto* const records =
        at<InstanceRecord>(job.block + at<const BlockHeader>(job.block)->instancesOffset);
    const uint32_t stride = gridDim.x * blockDim.x;
    for (uint32_t i = globalThread(); i < job.numChildren; i += stride) {
        const uint64_t child = at<const uint64_t>(job.children)[i];
        if (!isTraversable(job, child)) {
            reportFailure(job.report, job.block, kNoChild);
            continue; // keeps its handle
        }
        // An inactive instance stays inactive, because it has no place in the tree.
        records[i].child = child;
    }
}

} // namespace sunstone::bvh::gpu
