// SPDX-License-Identifier: Apache-2.0
// See stream.h.
#include "device/cpu/stream.h"

#include "base/error.h"
#include "base/float_mode.h"
#include "base/forked.h"
#include "base/process_end.h"
#include "base/threads/thread_object.h"
#include "base/threads/threads.h"
#include "device/cpu/memory.h"
#include "device/device.h"

#include <sched.h>

#include <algorithm>
#include <system_error>

namespace sunstone::device::cpu {

namespace {

constexpr int kWorkerSpins = 2000; // pauses, some 10 to 40 microseconds
constexpr int kWaiterSpins = 1000;

// If all processors are busy, the awaited thread may need this one.
void relax(int turn) {
    constexpr int kTurns = 32; // a microsecond or so
    if (turn % kTurns == kTurns - 1)
        sched_yield();
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

// With one processor a spinning thread blocks the thread that it waits for.
bool hasOneProcessor() {
    cpu_set_t allowed;
    return sched_getaffinity(0, sizeof allowed, &allowed) == 0 && CPU_COUNT(&allowed) == 1;
}
int spins(int most) {
    static const bool pays = !hasOneProcessor();
    return pays ? most : 0;
}

std::atomic<uint64_t> nextStreamId{1};

} // namespace

void Completion::wait() const {
    for (int i = 0; i < spins(kWaiterSpins); ++i) {
        if (done())
            return;
        relax(i);
    }
    done_.wait(0, std::memory_order_acquire);
}

void Completion::await() const {
    if (processEnds() && !done())
        throw ProcessEnds();
    wait();
}

void Completion::finish() {
    time_ = std::chrono::steady_clock::now();
    done_.store(1, std::memory_order_release);
    done_.notify_all();
}

Stream::Stream(unsigned flags, int priority, const void* owner, bool isPerThread)
    : Handled(newHandle()), flags_(flags), priority_(priority), owner_(owner),
      id_(nextStreamId.fetch_add(1, std::memory_order_relaxed)), isPerThread_(isPerThread) {}

void Stream::setPriority(int priority) {
    priority_ = std::min(std::max(priority, Streams::kGreatestPriority), Streams::kLeastPriority);
}

void Stream::keepAttribute(int attribute, const AttributeBytes& bytes) {
    std::lock_guard lock(mutex_);
    attributes_[attribute] = bytes;
}

Stream::AttributeBytes Stream::attribute(int attribute) const {
    std::lock_guard lock(mutex_);
    const auto found = attributes_.find(attribute);
    return found == attributes_.end() ? AttributeBytes{} : found->second;
}

void Stream::copyAttributes(const Stream& from) {
    if (&from == this)
        return;
    std::map<int, AttributeBytes> copied;
    {
        std::lock_guard lock(from.mutex_);
        copied = from.attributes_;
    }
    std::lock_guard lock(mutex_);
    attributes_ = std::move(copied);
    priority_ = from.priority_.load();
}

void Stream::keepError(std::exception_ptr error) {
    std::lock_guard lock(mutex_);
    if (!error_)
        error_ = std::move(error);
}

void Stream::throwError() {
    std::exception_ptr error;
    {
        std::lock_guard lock(mutex_);
        std::swap(error, error_);
    }
    if (error)
        std::rethrow_exception(error);
}

void Stream::push(std::shared_ptr<Stream> self, Item item) {
    std::unique_lock lock(mutex_);
    if (!started_) {
        // Here instead of in the first work, which may still be queued when main has returned.
        startArena();
        startWorker(std::move(self));
        started_ = true;
    }
    items_.push_back(std::move(item));
    pending_.fetch_add(1, std::memory_order_release);
    lock.unlock();
    wake_.notify_one();
}

void Stream::startWorker(std::shared_ptr<Stream> self) {
    try {
        std::thread(&Stream::run, std::move(self)).detach();
    } catch (const std::system_error& error) {
        fail(Code::kOutOfMemory, "cannot create the thread of a stream: ", error.what());
    }
}

void Stream::close() {
    std::lock_guard lock(mutex_);
    closing_ = true;
    wake_.notify_one();
}

void Stream::run(std::shared_ptr<Stream> self) {
    for (;;) {
        for (int i = 0;
             i < spins(kWorkerSpins) && self->pending_.load(std::memory_order_acquire) == 0; ++i)
            relax(i);
        Item item;
        {
            std::unique_lock lock(self->mutex_);
            self->wake_.wait(lock, [&] { return !self->items_.empty() || self->closing_; });
            if (self->items_.empty())
                return;
            item = std::move(self->items_.front());
            self->items_.pop_front();
            self->pending_.fetch_sub(1, std::memory_order_relaxed);
        }
        for (const CompletionPtr& earlier : item.waits)
            earlier->wait();
        memory().sealFreed();
        setDeviceFloatMode(); // a host function may have changed it
        try {
            if (item.work)
                item.work();
        } catch (const ContextFault&) { // the context keeps it
        } catch (...) {
            self->keepError(std::current_exception());
        }
        item.work = nullptr; // frees what the work owns before a waiter sees that it is done
        item.done->finish();
    }
}

Streams::Streams() : legacy_(std::make_shared<Stream>(0, 0, nullptr)) {}

void* Streams::create(unsigned flags, int priority, const void* owner) {
    auto stream = std::make_shared<Stream>(flags, priority, owner);
    std::lock_guard lock(order_);
    live_.push_back(stream);
    return stream->handle();
}

bool Streams::destroy(void* handle) {
    return remove(handle, false);
}

bool Streams::remove(const void* dead, bool isPerThread) {
    StreamPtr stream;
    {
        std::lock_guard lock(order_);
        auto it = std::find_if(live_.begin(), live_.end(), [&](const StreamPtr& s) {
            return s->handle() == dead && s->isPerThread_ == isPerThread;
        });
        if (it == live_.end())
            return false;
        stream = std::move(*it);
        live_.erase(it);
        dropCapture(stream);
        std::erase_if(orphans_, [](const Orphan& orphan) { return orphan.last->done(); });
        if (stream->last_ && !stream->last_->done())
            orphans_.push_back({stream->last_, stream->isBlocking()});
    }
    stream->close();
    return true;
}

void Streams::destroyOwner(const void* owner) {
    std::vector<void*> dead;
    {
        std::lock_guard lock(order_);
        for (const StreamPtr& stream : live_)
            if (stream->owner() == owner)
                dead.push_back(stream->handle());
    }
    for (void* handle : dead)
        destroy(handle);
}

void Streams::forgetErrors(const std::function<bool(const void* owner)>& isOne) {
    std::vector<StreamPtr> all;
    {
        std::lock_guard lock(order_);
        all = live_;
        all.push_back(legacy_);
    }
    for (const StreamPtr& stream : all)
        if (isOne(stream->owner())) {
            std::lock_guard lock(stream->mutex_);
            stream->error_ = nullptr;
        }
}

StreamPtr Streams::perThread() {
    struct Holder {
        StreamPtr stream = std::make_shared<Stream>(0, 0, this, true);
        Streams* streams = nullptr;
        ~Holder() {
            if (streams && !isForkedChild()) // where another thread's lock may never be released
                streams->remove(stream->handle(), true);
        }
    };
    Holder& holder = threadObject<Holder>();
    if (!holder.streams) {
        holder.streams = this;
        std::lock_guard lock(order_);
        live_.push_back(holder.stream);
    }
    return holder.stream;
}

StreamPtr Streams::find(void* handle) {
    if (uintptr_t(handle) <= 1)
        return legacy_;
    if (uintptr_t(handle) == 2)
        return perThread();
    if (StreamPtr stream = findCreated(handle))
        return stream;
    fail(Code::kInvalidValue, "stream ", handle, " is not a live stream");
}

StreamPtr Streams::findCreated(void* handle) {
    if (isDefault(handle))
        return nullptr;
    std::lock_guard lock(order_);
    for (const StreamPtr& stream : live_)
        if (stream->handle() == handle && !stream->isPerThread_)
            return stream;
    return nullptr;
}

std::vector<CompletionPtr> Streams::collect(const StreamPtr& stream) {
    std::vector<CompletionPtr> result;
    auto add = [&](const CompletionPtr& last) {
        if (last && !last->done())
            result.push_back(last);
    };
    if (stream == legacy_) {
        for (const StreamPtr& other : live_)
            if (other->isBlocking())
                add(other->last_);
        for (const Orphan& orphan : orphans_)
            if (orphan.isBlocking)
                add(orphan.last);
    } else if (stream->isBlocking()) {
        add(legacy_->last_);
    }
    return result;
}

CompletionPtr Streams::submit(const StreamPtr& stream, std::function<void()> work,
                              std::vector<CompletionPtr> waits, WorkInfo info) {
    stream->throwError();
    if (isCapturing(stream))
        return capture(stream, std::move(work), std::move(info));
    Stream::Item item;
    item.work = std::move(work);
    item.done = std::make_shared<Completion>();
    CompletionPtr done = item.done;
    std::lock_guard lock(order_);
    refuseImplicitJoin(stream);
    item.waits = collect(stream);
    for (CompletionPtr& earlier : waits)
        if (earlier && !earlier->done())
            item.waits.push_back(std::move(earlier));
    stream->push(stream, std::move(item));
    stream->last_ = done; // after push, which may throw
    return done;
}

std::vector<CompletionPtr> Streams::outstanding(const StreamPtr& stream) {
    std::lock_guard lock(order_);
    refuseCapturing(stream);
    std::vector<CompletionPtr> result;
    if (stream == legacy_)
        result = collect(stream);
    if (stream->last_ && !stream->last_->done())
        result.push_back(stream->last_);
    return result;
}

bool Streams::idle(const StreamPtr& stream) {
    return outstanding(stream).empty();
}

void Streams::synchronize(const StreamPtr& stream) {
    for (const CompletionPtr& completion : outstanding(stream))
        completion->await();
    stream->throwError();
}

void Streams::waitAll() {
    std::vector<CompletionPtr> completions;
    {
        std::lock_guard lock(order_);
        for (const Orphan& orphan : orphans_)
            completions.push_back(orphan.last);
        for (const StreamPtr& stream : live_)
            if (stream->last_)
                completions.push_back(stream->last_);
        if (legacy_->last_)
            completions.push_back(legacy_->last_);
    }
    for (const CompletionPtr& completion : completions)
        completion->await();
}

void Streams::synchronizeAll() {
    refuseDuringCapture();
    waitAll();
    std::vector<StreamPtr> all;
    {
        std::lock_guard lock(order_);
        all = live_;
        all.push_back(legacy_);
    }
    // Throws the first error; the others stay with their streams.
    for (const StreamPtr& stream : all)
        stream->throwError();
}

Streams& streams() {
    static Streams* instance = new Streams; // outlives every worker thread
    return *instance;
}

} // namespace sunstone::device::cpu
