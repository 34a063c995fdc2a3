// SPDX-License-Identifier: Apache-2.0
// CUDA contexts on the CPU device: owners of memory, streams, events and modules, with a stack of
// current ones per thread. Handles are checked before use, so garbage ones are harmless.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::device::cpu {

struct Context {
    bool primary = false;
    std::atomic<unsigned> flags{0};
    uint64_t id = 0;
    // What cuCtxSetLimit and its like were given; kept, not acted upon.
    std::atomic<size_t> limits[8] = {};
    std::atomic<unsigned> cacheConfig{0};
    std::atomic<unsigned> sharedConfig{0};
    // The API's number of the error that device code ended with; 0 while there was none.
    std::atomic<int> fault{0};
    void keepFault(int number, const std::string& text); // the first one stays
    std::string faultText() const;

private:
    mutable std::mutex faultMutex_;
    std::string faultText_;
};
using ContextPtr = std::shared_ptr<Context>;

class Contexts {
public:
    Context* create(unsigned flags);
    // Frees what the context owns. False if it is no live context, or the primary one.
    bool destroy(void* handle);

    Context* retainPrimary();
    bool releasePrimary(); // false if not retained
    void resetPrimary();
    bool primaryActive() const;
    unsigned primaryFlags() const { return primaryFlags_; }
    void setPrimaryFlags(unsigned flags);

    ContextPtr find(const void* handle) const; // null if not alive

    // The calling thread's stack.
    Context* current() const;          // null if none
    ContextPtr shareCurrent() const;   // the same, kept alive
    void setCurrent(Context* context); // replaces the top; null pops it
    void push(Context* context);
    Context* pop(); // null if empty

    // Called with a context about to die, after its streams have drained.
    void onDestroy(std::function<void(Context*)> hook);

private:
    void tearDown(const ContextPtr& context);

    mutable std::mutex mutex_;
    std::vector<ContextPtr> live_;
    std::vector<std::function<void(Context*)>> hooks_;
    ContextPtr primary_;
    unsigned primaryCount_ = 0;
    std::atomic<unsigned> primaryFlags_{0};
    uint64_t nextId_ = 1;
};

Contexts& contexts();

} // namespace sunstone::device::cpu
