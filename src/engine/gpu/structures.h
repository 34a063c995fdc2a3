// SPDX-License-Identifier: Apache-2.0
// Which handles lead somewhere on GPUs: to where an acceleration structure was put, by any context of
// this process, and to transforms. A GPU's kernel cannot find out whether there is memory at an
// address, and a fault would end the CUDA context, so that kernels look handles up before they follow
// them (bvh/gpu/known_handles.h).
#pragma once

#include "device/cuda/driver.h"

#include <cstdint>
#include <mutex>

namespace sunstone::engine {

// A structure was built, compacted or relocated, or a transform was made a traversable, of this
// handle.
void noteGpuHandle(uint64_t handle);

// The table of known handles in the memory of a CUDA context. Any thread may call; the context is
// current, and idle when the table dies.
class GpuKnownHandles {
public:
    GpuKnownHandles() = default;
    ~GpuKnownHandles();
    GpuKnownHandles(const GpuKnownHandles&) = delete;
    GpuKnownHandles& operator=(const GpuKnownHandles&) = delete;

    // Of how many structures the driver is asked whether their memory is still allocated, in turn;
    // of the usual one it is always.
    static constexpr size_t kSome = 8, kAll = ~size_t(0);
    struct View {
        uint64_t known; // see bvh/gpu/known_handles.h
        uint64_t usual; // that of the caller if it is known, else the newest structure's, or 0
    };
    // Brings the table up to date, for work on this stream. What is captured gets a number that leads
    // to the table of the time when its graph runs: from then on every handle that is noted goes
    // there at once.
    View update(size_t asked, uint64_t usual, CUstream stream);

private:
    friend void noteGpuHandle(uint64_t handle);

    struct Followers;
    static Followers& followers();
    void follow();
    bool tryRefresh();
    View refresh(size_t asked, uint64_t usual);
    void makeRoom(size_t entries);

    std::mutex mutex_;
    CUstream stream_ = nullptr; // waits for no other
    CUdeviceptr table_ = 0, replaced_ = 0;
    uint64_t layout_ = 0, written_ = 0; // what the table holds of the process's
    // For graphs: what stands for the table, in memory of this context; 0: none was captured yet.
    CUdeviceptr cell_ = 0;
    CUcontext context_ = nullptr;
    uint64_t told_ = 0; // what is in the cell
};

} // namespace sunstone::engine
