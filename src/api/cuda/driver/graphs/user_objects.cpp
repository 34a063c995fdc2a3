// SPDX-License-Identifier: Apache-2.0
// User objects: resources of the program that graphs own. The program, graphs, their copies and
// executable forms, and launches in progress hold references. The release of the last one frees the
// resource. Source: CUDA driver API, graph management.
#include "api/cuda/driver/graphs/graphs.h"
#include "base/handles.h"

#include <climits>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <unordered_map>

using namespace sunstone::api::cuda;

namespace {

// Calls the program's functions one after another on a separate thread: they may wait for locks of
// the program, and the last reference is often released while a call or a stream holds our lock.
class Destructors {
public:
    void add(CUhostFn function, void* argument) {
        std::lock_guard lock(mutex_);
        if (!isStarted_)
            std::thread([this] { run(); }).detach();
        isStarted_ = true;
        waiting_.push_back({function, argument});
        wake_.notify_one();
    }

private:
    struct Call {
        CUhostFn function;
        void* argument;
    };
    void run() {
        std::unique_lock lock(mutex_);
        for (;;) {
            wake_.wait(lock, [&] { return !waiting_.empty(); });
            const Call call = waiting_.front();
            waiting_.pop_front();
            lock.unlock();
            call.function(call.argument);
            lock.lock();
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<Call> waiting_;
    bool isStarted_ = false;
};

Destructors& destructors() {
    static auto* all = new Destructors; // outlives every graph
    return *all;
}

struct Resource : sunstone::Handled {
    Resource() : Handled(sunstone::newHandle()) {}
    CUhostFn destroy = nullptr;
    void* argument = nullptr;
    ~Resource() {
        if (!destroy)
            return;
        try {
            destructors().add(destroy, argument);
        } catch (const std::exception&) { // no thread, or no memory
            destroy(argument);
        }
    }
};

// The references of the program; guarded by graphMutex().
struct Owned {
    std::shared_ptr<Resource> resource;
    unsigned references;
};
std::unordered_map<CUuserObject, Owned>& objects() {
    static auto* table = new std::unordered_map<CUuserObject, Owned>;
    return *table;
}

Owned& ownedOf(CUuserObject object) {
    const auto found = objects().find(object);
    if (found == objects().end())
        refuse(CUDA_ERROR_INVALID_VALUE, static_cast<void*>(object),
               " is not a user object to which the program has references");
    return found->second;
}

void requireCount(unsigned count) {
    require(count != 0 && count <= INT_MAX, "the number of references is 0 or too large");
}

void release(CUuserObject object, unsigned count) {
    Owned& owned = ownedOf(object);
    require(count <= owned.references, "the program has fewer references");
    owned.references -= count;
    if (owned.references == 0)
        objects().erase(object);
}

} // namespace

SUNSTONE_EXPORT CUresult cuUserObjectCreate(CUuserObject* object, void* argument, CUhostFn destroy,
                                            unsigned int references, unsigned int flags) {
    return guardedGraph("cuUserObjectCreate", Needs::kInit, [&] {
        require(object, "object is null");
        *object = nullptr;
        require(destroy, "destroy is null");
        require(flags == CU_USER_OBJECT_NO_DESTRUCTOR_SYNC,
                "flags must be CU_USER_OBJECT_NO_DESTRUCTOR_SYNC");
        requireCount(references);
        // The destructor of an object that could not be returned is not called.
        auto resource = std::make_shared<Resource>();
        const auto handle = static_cast<CUuserObject>(resource->handle());
        Owned& owned = objects()[handle];
        resource->destroy = destroy;
        resource->argument = argument;
        owned = {std::move(resource), references};
        *object = handle;
    });
}

SUNSTONE_EXPORT CUresult cuUserObjectRetain(CUuserObject object, unsigned int count) {
    return guardedGraph("cuUserObjectRetain", Needs::kInit, [&] {
        requireCount(count);
        Owned& owned = ownedOf(object);
        require(count <= INT_MAX - owned.references, "the number of references is too large");
        owned.references += count;
    });
}

SUNSTONE_EXPORT CUresult cuUserObjectRelease(CUuserObject object, unsigned int count) {
    return guardedGraph("cuUserObjectRelease", Needs::kInit, [&] {
        requireCount(count);
        release(object, count);
    });
}

SUNSTONE_EXPORT CUresult cuGraphRetainUserObject(CUgraph graph, CUuserObject object,
                                                 unsigned int count, unsigned int flags) {
    return guardedGraph("cuGraphRetainUserObject", Needs::kInit, [&] {
        require(flags == 0 || flags == CU_GRAPH_USER_OBJECT_MOVE, "unknown flags");
        requireCount(count);
        const std::shared_ptr<cpu::Graph> owner = graphOf(graph);
        const std::shared_ptr<Resource> resource = ownedOf(object).resource;
        if (flags == CU_GRAPH_USER_OBJECT_MOVE)
            release(object, count);
        owner->keep(resource, object, count);
    });
}

SUNSTONE_EXPORT CUresult cuGraphReleaseUserObject(CUgraph graph, CUuserObject object,
                                                  unsigned int count) {
    return guardedGraph("cuGraphReleaseUserObject", Needs::kInit, [&] {
        requireCount(count);
        require(graphOf(graph)->release(object, count), "the graph has fewer references");
    });
}
