// SPDX-License-Identifier: Apache-2.0
// See context.h.
#include "device/cpu/context.h"

#include "base/error.h"
#include "base/log.h"
#include "base/process_end.h"
#include "base/threads/thread_object.h"
#include "device/cpu/memory.h"
#include "device/cpu/stream.h"

#include <algorithm>

namespace sunstone::device::cpu {

namespace {

// Weak, so that a context destroyed by another thread leaves an entry that reads as null.
using Stack = std::vector<std::weak_ptr<Context>>;

Stack& contextStack() {
    return threadObject<Stack>();
}

constexpr size_t kDefaultLimits[8] = {1024, 1 << 20, 8 << 20, 2, 2048, 64, 0, 0};

} // namespace

void Context::keepFault(int number, const std::string& text) {
    std::lock_guard lock(faultMutex_);
    if (fault != 0)
        return;
    faultText_ = text;
    fault = number;
}

std::string Context::faultText() const {
    std::lock_guard lock(faultMutex_);
    return faultText_;
}

Context* Contexts::create(unsigned flags) {
    auto context = std::make_shared<Context>();
    context->flags = flags;
    for (int i = 0; i < 8; ++i)
        context->limits[i] = kDefaultLimits[i];
    {
        std::lock_guard lock(mutex_);
        context->id = nextId_++;
        live_.push_back(context);
    }
    contextStack().push_back(context);
    return context.get();
}

void Contexts::tearDown(const ContextPtr& context) {
    streams().waitAll(); // also if a capture makes the next call fail
    try {
        streams().synchronizeAll();
    } catch (const ProcessEnds&) { // device code may still use the context's memory
        throw;
    } catch (const std::exception& error) {
        log(LogLevel::kError, "device",
            message("work of a destroyed context failed: ", error.what()));
    }
    std::vector<std::function<void(Context*)>> hooks;
    {
        std::lock_guard lock(mutex_);
        hooks = hooks_;
    }
    for (auto& hook : hooks)
        hook(context.get());
    streams().forgetErrors([&](const void* owner) {
        return owner == context.get() || !find(owner); // default streams have none
    });
    streams().destroyOwner(context.get());
    memory().releaseOwner(context.get());
}

bool Contexts::destroy(void* handle) {
    ContextPtr context;
    {
        std::lock_guard lock(mutex_);
        auto it = std::find_if(live_.begin(), live_.end(),
                               [&](const ContextPtr& c) { return c.get() == handle; });
        if (it == live_.end() || (*it)->primary)
            return false;
        context = std::move(*it);
        live_.erase(it);
    }
    tearDown(context);
    if (current() == context.get())
        contextStack().pop_back();
    return true;
}

Context* Contexts::retainPrimary() {
    std::lock_guard lock(mutex_);
    if (!primary_) {
        primary_ = std::make_shared<Context>();
        primary_->primary = true;
        primary_->flags = primaryFlags_.load();
        for (int i = 0; i < 8; ++i)
            primary_->limits[i] = kDefaultLimits[i];
        primary_->id = nextId_++;
        live_.push_back(primary_);
    }
    ++primaryCount_;
    return primary_.get();
}

bool Contexts::releasePrimary() {
    {
        std::lock_guard lock(mutex_);
        if (primaryCount_ == 0)
            return false;
        if (--primaryCount_ != 0)
            return true;
    }
    resetPrimary();
    return true;
}

void Contexts::resetPrimary() {
    ContextPtr context;
    {
        std::lock_guard lock(mutex_);
        context = std::move(primary_);
        primary_ = nullptr;
        primaryCount_ = 0;
        if (!context)
            return;
        live_.erase(std::remove(live_.begin(), live_.end(), context), live_.end());
    }
    tearDown(context);
}

bool Contexts::primaryActive() const {
    std::lock_guard lock(mutex_);
    return primary_ != nullptr;
}

void Contexts::setPrimaryFlags(unsigned flags) {
    std::lock_guard lock(mutex_);
    primaryFlags_ = flags;
    if (primary_)
        primary_->flags = flags;
}

ContextPtr Contexts::find(const void* handle) const {
    std::lock_guard lock(mutex_);
    for (const ContextPtr& context : live_)
        if (context.get() == handle)
            return context;
    return nullptr;
}

ContextPtr Contexts::shareCurrent() const {
    return contextStack().empty() ? nullptr : contextStack().back().lock();
}

Context* Contexts::current() const {
    return shareCurrent().get(); // stays alive until the application destroys it
}

void Contexts::setCurrent(Context* context) {
    if (!contextStack().empty())
        contextStack().pop_back();
    if (context)
        contextStack().push_back(find(context));
}

void Contexts::push(Context* context) {
    contextStack().push_back(find(context));
}

Context* Contexts::pop() {
    if (contextStack().empty())
        return nullptr;
    Context* top = current();
    contextStack().pop_back();
    return top;
}

void Contexts::onDestroy(std::function<void(Context*)> hook) {
    std::lock_guard lock(mutex_);
    hooks_.push_back(std::move(hook));
}

Contexts& contexts() {
    static Contexts* instance = new Contexts; // outlives every thread
    return *instance;
}

} // namespace sunstone::device::cpu
