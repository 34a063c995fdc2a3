// SPDX-License-Identifier: Apache-2.0
// Memory of launches in flight on a GPU: each has a block in device memory with room for launch
// parameters, and an image of the block in page-locked host memory. A slot is reused once its
// launch has ended; its reports are logged then, or by tellOfEnded().
//
// A captured launch stays part of a graph, which may run at any time. Its slot is reused, and the
// report of its last run logged, once the graph and all its copies and executable forms have been
// destroyed: the graph owns a user object, whose destructor signals this. Drivers before CUDA 11.3
// have no user objects; slots are then kept until the CUDA context ends. The report is also logged
// once the pipeline has been destroyed, because no graph may run the launch after that. Until one
// of the two, a run may be writing the report.
#pragma once

#include "device/cuda/driver.h"
#include "devlib/gpu/launch_block.h"
#include "engine/context.h"
#include "engine/gpu/patience.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace sunstone::engine {

class GpuLaunchSlots {
public:
    enum class State {
        kFree,
        kTaken,     // its launch is being queued
        kQueued,    // settled by the first thread that finds it ended
        kAwaited,   // queued, and settled by the thread that waits for it
        kCaptured,  // may be queued by any launch of the graph until the graph is destroyed
        kAbandoned, // queued in part: free once that part has ended, without a report
        kLost,      // the CUDA context failed before the launch was known to have ended
    };
    struct Slot {
        CUdeviceptr memory = 0; // LaunchBlock, then the parameters
        devlib::LaunchBlock* host = nullptr;
        devlib::LaunchReport* report = nullptr; // destination of the launch's report
        std::byte* extra = nullptr;             // page-locked, of `capacity` bytes too
        size_t capacity = 0;                    // bytes of parameters
        CUevent done = nullptr;
        State state = State::kFree;
        bool validation = false;
        std::weak_ptr<Context> context;
        const Wording* wording = nullptr;       // of the context
        std::weak_ptr<LaunchFindings> findings; // of the pipeline
        // Of a captured launch: set when its graph has been destroyed.
        std::shared_ptr<std::atomic<bool>> graphDestroyed;
        uint64_t number = 0; // of the launch, in order
    };
    static constexpr size_t kParameters = (sizeof(devlib::LaunchBlock) + 255) / 256 * 256;

    // The slot of a launch that is being queued; freed unless queued() is reached.
    class Lease {
    public:
        Lease(GpuLaunchSlots& slots, const ContextPtr& context, CUstream stream,
              size_t parameterBytes, bool validation);
        ~Lease();
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;
        Slot* operator->() const { return slot_; }

        // Call it once all work of the launch is queued.
        void queued();
        // Also queues the end, waits for it and returns the cause of a failure, or an empty text.
        std::string finish();

    private:
        void watchGraph();

        GpuLaunchSlots& slots_;
        CUstream stream_;
        bool isCaptured_;
        Slot* slot_ = nullptr;
        bool isQueued_ = false;
    };

    explicit GpuLaunchSlots(CUcontext context) : context_(context) {}
    ~GpuLaunchSlots();

    // Logs the reports of launches that have ended, and launches lost with the CUDA context; stops
    // after finding mostPending running ones. The context is current.
    void tellOfEnded(unsigned mostPending);

private:
    struct Line { // for a context's log
        std::weak_ptr<Context> context;
        LogLevel level;
        std::string text;
    };
    using Lines = std::vector<Line>;

    Slot& take(size_t parameterBytes);
    void makeMemory(Slot& slot, size_t parameterBytes);
    void record(Slot& slot, CUstream stream, State state);
    void tellOfGraphs(Lines& lines);
    // Frees slots whose launches have ended; mutex_ is held.
    void collect(unsigned mostPending, Lines& lines);
    void lose(CUresult reason, Lines& lines);
    static void settle(Slot& slot, Lines& lines);
    static void tell(const Lines& lines); // without mutex_: a log callback may launch
    // withTexts: the pipeline's module, which holds the texts, is loaded.
    static std::string failureOf(const Slot& slot, bool validation, bool withTexts);

    CUcontext context_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Slot>> slots_;
    uint64_t launches_ = 0;
    size_t next_ = 0; // where the search for ended launches starts
};

} // namespace sunstone::engine
