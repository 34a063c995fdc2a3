// SPDX-License-Identifier: Apache-2.0
// Valid handles on GPUs: those of acceleration structures that any context of this process has
// built or copied, and of transforms. A kernel cannot test whether an address is mapped, and a
// fault would end the CUDA context; kernels therefore look handles up before they follow them
// (bvh/gpu/known_handles.h). Read next: handle_table.h.
#pragma once

#include "device/cuda/driver.h"
#include "engine/gpu/handle_table.h"

#include <cstdint>
#include <mutex>
#include <vector>

namespace sunstone::engine {

// Registers the handle of a structure that was built, compacted or relocated, or of a transform.
// moves: the structure has motion keys.
void noteGpuHandle(uint64_t handle, bool moves = false);

// GpuHandleTable::graphs() for all handles of the process.
GpuGraphs gpuGraphs();

// The table of known handles in the memory of a CUDA context. Any thread may call. The context is
// current, and idle at destruction.
class GpuKnownHandles {
public:
    GpuKnownHandles() = default;
    ~GpuKnownHandles();
    GpuKnownHandles(const GpuKnownHandles&) = delete;
    GpuKnownHandles& operator=(const GpuKnownHandles&) = delete;

    // The number of structures for which a call asks the driver, in turn, whether their memory is
    // still allocated; the usual one is always checked.
    static constexpr size_t kSome = 8, kAll = ~size_t(0);
    struct View {
        uint64_t known; // see bvh/gpu/known_handles.h
        uint64_t usual; // the caller's if it is known, else the newest structure's, or 0
    };
    // Updates the table for work on this stream. A captured launch gets a number that refers to the
    // table at the time when its graph runs: after a capture every new handle is added to the table
    // at once.
    View update(size_t asked, uint64_t usual, CUstream stream);
    // The context was destroyed: the destructor does not call the driver.
    void abandon();

private:
    friend void noteGpuHandle(uint64_t handle, bool moves);

    void follow();
    bool tryRefresh();
    View refresh(size_t asked, uint64_t usual);
    void makeRoom(size_t entries);

    std::mutex mutex_;
    CUstream stream_ = nullptr; // waits for no other
    CUdeviceptr table_ = 0, replaced_ = 0;
    uint64_t layout_ = 0, written_ = 0; // the process's handles in the table
    // For graphs: the table's number, in memory of this context; 0: none was captured yet.
    CUdeviceptr cell_ = 0;
    CUcontext context_ = nullptr;
    uint64_t told_ = 0; // contents of the cell
};

// The tables that graphs may read at any time.
struct GpuTableFollowers {
    std::mutex mutex; // taken before all others
    std::vector<GpuKnownHandles*> all;
};

} // namespace sunstone::engine
