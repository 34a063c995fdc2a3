// SPDX-License-Identifier: Apache-2.0
// CUDA contexts on the CPU device: they own memory, streams, events and modules; each thread has a
// stack of current ones. Handles are checked before use: an invalid handle is an error, not a
// crash.
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
    // The values of cuCtxSetLimit and cuCtxSetCacheConfig and the like; stored, without effect.
    std::atomic<size_t> limits[8] = {};
    std::atomic<unsigned> cacheConfig{0};
    std::atomic<unsigned> sharedConfig{0};
    // The CUDA API's number of the error that device code ended with; 0: none.
    std::atomic<int> fault{0};
    void keepFault(int number, const std::string& text); // only the first one is stored
    std::string faultText() const;

private:
    mutable std::mutex faultMutex_;
    std::string faultText_;
};
using ContextPtr = std::shared_ptr<Context>;

class Contexts {
public:
    Context* create(unsigned flags);
    // Frees what the context owns. False if it is not a live context, or is the primary one.
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

    // The hook is called for a context about to be destroyed, after its streams have drained.
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
