// SPDX-License-Identifier: Apache-2.0
// Work of the host in the order of a GPU's stream: what it needs is copied to page-locked memory, a
// callback of the stream runs it there, what it wrote is copied back. The denoiser's filter runs
// so.
#pragma once

#include "base/error.h"
#include "device/cuda/driver.h"
#include "engine/context.h"

#include <map>
#include <mutex>
#include <vector>

namespace sunstone::engine {

class GpuHostWork {
public:
    explicit GpuHostWork(CUcontext context) : context_(context) {}
    ~GpuHostWork();

    // Returns when all is queued. Throws what has gone wrong in earlier work of the stream.
    void run(const ContextPtr& context, CUstream stream, const char* tag, HostWork work);

    // The first failure of each stream; tasks in flight share it.
    struct Failures {
        std::mutex mutex;
        std::map<CUstream, Error> first;
    };

private:
    struct Block { // used again once `done`
        uint8_t* memory = nullptr;
        size_t capacity = 0;
        CUevent done = nullptr;
    };
    Block& take(size_t size); // mutex_ is held
    void queue(const ContextPtr& context, CUstream stream, const char* tag, HostWork work);
    static CUresult endUse(Block& block, CUstream stream);

    CUcontext context_;
    std::shared_ptr<Failures> failures_ = std::make_shared<Failures>();
    std::mutex mutex_;
    std::vector<std::unique_ptr<Block>> blocks_;
};

} // namespace sunstone::engine
