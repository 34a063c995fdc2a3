// SPDX-License-Identifier: Apache-2.0
// Streams of the CPU device: ordered queues, each with a worker thread that starts with the first
// work. Dependencies on Completions alone order work between streams:
//
// - each piece of work has a Completion; a stream remembers its last one;
// - work on the legacy default stream depends on the last work of all blocking streams, and work on
//   a blocking stream on the last work of the legacy stream (CUDA Driver API, "Stream
//   synchronization behavior");
// - waiting for an event is work that depends on the Completion recorded with the event.
//
// Dependencies point only to work submitted earlier, and each stream has its own thread, so there
// is no cycle. One mutex (Streams::order_) makes submissions of all streams one sequence. A
// capturing stream queues nothing: see graph.h. A worker spins for some microseconds before it
// sleeps, which saves the wake-up for programs that alternate launches and waits. Read next:
// event.h, cpu_device.cpp.
#pragma once

#include "base/handles.h"
#include "device/cpu/graph.h"

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace sunstone::device::cpu {

// An event that happens once.
class Completion {
public:
    bool done() const { return done_.load(std::memory_order_acquire) != 0; }
    void wait() const;
    // For API calls: throws ProcessEnds instead of waiting while the process ends.
    void await() const;
    void finish();
    // The time it happened; valid once done.
    std::chrono::steady_clock::time_point time() const { return time_; }

private:
    std::atomic<uint32_t> done_{0};
    std::chrono::steady_clock::time_point time_{};
};

// The kind of a piece of work, for graphs that capture it.
struct WorkInfo {
    WorkKind kind = WorkKind::kKernel;
    std::shared_ptr<const void> details;
};

class Stream : public Handled {
public:
    // `isPerThread`: a default stream, which its thread destroys and which has no handle.
    Stream(unsigned flags, int priority, const void* owner, bool isPerThread = false);
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    bool isBlocking() const { return (flags_ & 1u) == 0; } // CU_STREAM_NON_BLOCKING is 1
    unsigned flags() const { return flags_; }
    int priority() const { return priority_; }
    void setPriority(int priority); // clamped to the range of priorities
    // Stream attributes of the API: stored, without effect.
    using AttributeBytes = std::array<unsigned char, 64>;
    void keepAttribute(int attribute, const AttributeBytes& bytes);
    AttributeBytes attribute(int attribute) const; // zeros if never set
    void copyAttributes(const Stream& from);
    const void* owner() const { return owner_; }
    uint64_t id() const { return id_; }

private:
    friend class Streams;
    struct Item {
        std::function<void()> work;
        std::vector<CompletionPtr> waits;
        CompletionPtr done;
    };
    static void run(std::shared_ptr<Stream> self);
    // If the worker thread cannot be created, throws and leaves the stream as it was.
    void push(std::shared_ptr<Stream> self, Item item);
    void startWorker(std::shared_ptr<Stream> self);
    void close(); // the worker ends when the queue is empty
    void keepError(std::exception_ptr error);
    void throwError(); // and forgets it

    const unsigned flags_;
    std::atomic<int> priority_;
    std::map<int, AttributeBytes> attributes_; // guarded by mutex_
    const void* const owner_;
    const uint64_t id_;
    CompletionPtr last_; // guarded by Streams::order_, like the next two members
    std::shared_ptr<Capture> capture_;
    std::vector<GraphNode*> tips_; // of the capture

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<Item> items_;
    std::atomic<uint32_t> pending_{0}; // items not taken yet, for the spinning worker
    bool started_ = false;
    bool closing_ = false;
    std::exception_ptr error_;
    const bool isPerThread_;
};

// All streams of the process.
class Streams {
public:
    static constexpr int kLeastPriority = 0;
    static constexpr int kGreatestPriority = -5;

    Streams();
    void* create(unsigned flags, int priority, const void* owner);
    // Returns at once; work already queued still runs. False if the handle is not a live stream.
    bool destroy(void* handle);
    void destroyOwner(const void* owner);
    // Drops the pending errors of streams whose owner is one of these.
    void forgetErrors(const std::function<bool(const void* owner)>& isOne);

    // The stream of a handle: null and (void*)1 mean the legacy default stream, (void*)2 that of
    // the calling thread. Throws Error(kInvalidValue) for other values that are not live streams.
    StreamPtr find(void* handle);
    // Null for default streams and for invalid handles.
    StreamPtr findCreated(void* handle);
    bool isDefault(void* handle) const { return uintptr_t(handle) <= 2; }

    // Queues work after all work it must follow. Throws the stream's pending error. On a capturing
    // stream: adds a node to the graph instead; the result is then already done.
    CompletionPtr submit(const StreamPtr& stream, std::function<void()> work,
                         std::vector<CompletionPtr> waits = {}, WorkInfo info = {});
    // The Completions for which the stream waits until it is idle; for the legacy stream including
    // those of blocking streams.
    std::vector<CompletionPtr> outstanding(const StreamPtr& stream);
    bool idle(const StreamPtr& stream);
    void synchronize(const StreamPtr& stream); // throws the stream's pending error
    void waitAll();                            // errors stay with their streams
    void synchronizeAll();                     // throws the first pending error
    void throwError(const StreamPtr& stream) { stream->throwError(); }

    // Capturing; all throw CaptureError. If a graph is given, its nodes `after` are the first tips.
    void beginCapture(const StreamPtr& stream, Capture::Mode mode, std::shared_ptr<Graph> graph,
                      std::vector<GraphNode*> after);
    std::shared_ptr<Graph> endCapture(const StreamPtr& stream);
    bool isCapturing(const StreamPtr& stream);
    // The capture and the nodes that the stream's next work comes after; null if it does not
    // capture.
    CapturedMark captureState(const StreamPtr& stream);
    void setTips(const StreamPtr& stream, std::vector<GraphNode*> tips);
    // Makes the stream's work depend on the mark; a stream that does not capture joins the capture.
    void waitForCaptured(const StreamPtr& stream, const CapturedMark& mark);
    // For calls that may synchronise implicitly: throws while a capture forbids them.
    void refuseDuringCapture();
    // Sets the calling thread's mode for such calls; returns the previous one.
    static Capture::Mode exchangeThreadMode(Capture::Mode mode);

private:
    std::vector<CompletionPtr> collect(const StreamPtr& stream); // under order_
    StreamPtr perThread();
    CompletionPtr capture(const StreamPtr& stream, std::function<void()> work, WorkInfo info);
    // Under order_. A call that waits for a stream is refused while the stream captures, and for
    // the legacy stream while any blocking stream captures. The captures concerned become invalid.
    void refuseCapturing(const StreamPtr& stream);
    // Under order_: the stream's valid capture, or null.
    Capture* validCapture(const StreamPtr& stream);
    void refuseImplicitJoin(const StreamPtr& stream); // under order_
    void dropCapture(const StreamPtr& stream);        // under order_: the stream is being destroyed
    bool remove(const void* stream, bool isPerThread);

    std::mutex order_;
    StreamPtr legacy_;
    std::vector<std::shared_ptr<Capture>> captures_; // in progress
    std::vector<StreamPtr> live_; // without legacy_; per-thread ones included
    // The last work of a destroyed stream, which may not be done yet. It still counts as work of a
    // blocking stream.
    struct Orphan {
        CompletionPtr last;
        bool isBlocking;
    };
    std::vector<Orphan> orphans_;
};

Streams& streams();

} // namespace sunstone::device::cpu
