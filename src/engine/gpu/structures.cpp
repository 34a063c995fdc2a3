// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/structures.h"

#include "bvh/gpu/known_handles.h"
#include "engine/gpu/process.h"

#include <algorithm>

namespace sunstone::engine {

using namespace device::cuda;
using namespace bvh::gpu;

void noteGpuHandle(uint64_t handle, bool moves) {
    {
        GpuHandleTable& all = gpuProcess().handles;
        std::lock_guard lock(all.mutex);
        all.note(handle, moves);
    }
    GpuTableFollowers& them = gpuProcess().followers;
    std::lock_guard lock(them.mutex);
    std::erase_if(them.all, [](GpuKnownHandles* each) { return !each->tryRefresh(); });
}

GpuGraphs gpuGraphs() {
    GpuHandleTable& all = gpuProcess().handles;
    std::lock_guard lock(all.mutex);
    return all.graphs();
}

GpuKnownHandles::~GpuKnownHandles() {
    {
        GpuTableFollowers& them = gpuProcess().followers;
        std::lock_guard lock(them.mutex);
        std::erase(them.all, this);
    }
    if (stream_)
        driver().streamDestroy(stream_);
    for (const CUdeviceptr memory : {table_, replaced_, cell_})
        if (memory)
            driver().memFree(memory);
}

void GpuKnownHandles::abandon() {
    std::lock_guard own(mutex_);
    stream_ = nullptr;
    table_ = replaced_ = cell_ = 0;
}

// The replaced table stays allocated until the next replacement: running launches may read it, and
// freeing waits for them.
void GpuKnownHandles::makeRoom(size_t entries) {
    if (!stream_)
        SUNSTONE_CU(streamCreate, &stream_, CU_STREAM_NON_BLOCKING);
    CUdeviceptr table = 0;
    SUNSTONE_CU(memAlloc, &table, entries * sizeof(uint64_t));
    if (replaced_)
        driver().memFree(replaced_);
    replaced_ = table_;
    table_ = table;
}

GpuKnownHandles::View GpuKnownHandles::update(size_t asked, uint64_t usual, CUstream stream) {
    const bool isCaptured = isCapturing(driver(), stream);
    if (isCaptured)
        follow();
    std::lock_guard own(mutex_);
    const View view = refresh(asked, usual);
    return isCaptured ? View{cell_ | kOfGraph, 0} : view;
}

void GpuKnownHandles::follow() {
    GpuTableFollowers& them = gpuProcess().followers;
    std::lock_guard lock(them.mutex);
    if (std::find(them.all.begin(), them.all.end(), this) != them.all.end())
        return;
    std::lock_guard own(mutex_);
    if (!cell_) {
        SUNSTONE_CU(ctxGetCurrent, &context_);
        SUNSTONE_CU(memAlloc, &cell_, sizeof(uint64_t));
    }
    told_ = ~uint64_t(0); // unset, or outdated
    them.all.push_back(this);
}

// False: from now on graphs accept all handles unchecked, or cannot run any more.
bool GpuKnownHandles::tryRefresh() {
    std::lock_guard own(mutex_);
    try {
        ContextScope scope(context_);
        try {
            refresh(0, 0);
        } catch (const Error&) {
            const uint64_t none = 0;
            SUNSTONE_CU(memcpyHtoD, cell_, &none, sizeof(none));
            throw;
        }
        return true;
    } catch (const Error&) {
        return false;
    }
}

GpuKnownHandles::View GpuKnownHandles::refresh(size_t asked, uint64_t usual) {
    GpuHandleTable& all = gpuProcess().handles;
    std::lock_guard lock(all.mutex);
    all.tidy();
    all.look(asked);
    usual = all.usual(usual);
    const bool isNew = layout_ != all.layout;
    const bool isToBeTold = cell_ && (isNew || told_ != (table_ | all.shift()));
    if (isNew || isToBeTold || written_ != all.writes.size()) {
        constexpr size_t kFew = 16;
        if (isNew)
            makeRoom(all.slots.size());
        const auto write = [&](size_t place, size_t count) {
            SUNSTONE_CU(memcpyHtoDAsync, table_ + place * sizeof(uint64_t), &all.slots[place],
                        count * sizeof(uint64_t), stream_);
        };
        if (isNew || all.writes.size() - written_ > kFew)
            write(0, all.slots.size());
        else
            for (size_t i = written_; i < all.writes.size(); ++i)
                write(all.writes[i], 1);
        const uint64_t known = table_ | all.shift();
        if (isToBeTold)
            SUNSTONE_CU(memcpyHtoDAsync, cell_, &known, sizeof(known), stream_);
        SUNSTONE_CU(streamSynchronize, stream_);
        layout_ = all.layout;
        written_ = all.writes.size();
        if (isToBeTold)
            told_ = known;
    }
    return {table_ | all.shift(), usual};
}

} // namespace sunstone::engine
