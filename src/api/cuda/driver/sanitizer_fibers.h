// SPDX-License-Identifier: Apache-2.0
// What sanitizers must be told of switches between the stack of a scheduler and those of fibers;
// empty in other builds.
#pragma once

#include <cstddef>
#include <vector>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SUNSTONE_ASAN_FIBERS 1
#include <sanitizer/common_interface_defs.h>
#endif
#if __has_feature(thread_sanitizer)
#define SUNSTONE_TSAN_FIBERS 1
#include <sanitizer/tsan_interface.h>
#endif
#endif

namespace sunstone::api::cuda {

class SanitizerFibers {
public:
    SanitizerFibers() = default;
    SanitizerFibers(const SanitizerFibers&) = delete;
    SanitizerFibers& operator=(const SanitizerFibers&) = delete;
    ~SanitizerFibers() { restart(0); }

#if defined(SUNSTONE_ASAN_FIBERS)
    // New ones: fibers that were abandoned leave their frames open in the books.
    void restart(size_t count) {
        fakes_.assign(count, nullptr);
    }
    // The caller is what `leave` goes back to.
    void begin() {}
    // On the scheduler, before a switch to a fiber and after the switch back.
    void enter(size_t index, const void* stackTop, size_t size) {
        running_ = index;
        __sanitizer_start_switch_fiber(&schedulerFake_, static_cast<const char*>(stackTop) - size,
                                       size);
    }
    void left() {
        __sanitizer_finish_switch_fiber(schedulerFake_, nullptr, nullptr);
    }
    // On a fiber, after a switch to it and before the one back.
    void entered() {
        __sanitizer_finish_switch_fiber(fakes_[running_], &schedulerBottom_, &schedulerSize_);
    }
    void leave(bool forever) {
        __sanitizer_start_switch_fiber(forever ? nullptr : &fakes_[running_], schedulerBottom_,
                                       schedulerSize_);
    }
    // On the scheduler, which a jump has come back to from a fiber.
    void abandoned() {
        leave(true);
        left();
    }

private:
    std::vector<void*> fakes_;
    size_t running_ = 0;
    void* schedulerFake_ = nullptr;
    const void* schedulerBottom_ = nullptr;
    size_t schedulerSize_ = 0;
#elif defined(SUNSTONE_TSAN_FIBERS)
    void restart(size_t count) {
        for (void* fiber : fibers_)
            __tsan_destroy_fiber(fiber);
        fibers_.clear();
        for (size_t i = 0; i < count; ++i)
            fibers_.push_back(__tsan_create_fiber(0));
    }
    void begin() {
        scheduler_ = __tsan_get_current_fiber();
    }
    void enter(size_t index, const void*, size_t) {
        __tsan_switch_to_fiber(fibers_[index], 0);
    }
    void left() {}
    void entered() {}
    void leave(bool) {
        __tsan_switch_to_fiber(scheduler_, 0);
    }
    void abandoned() {
        leave(true);
    }

private:
    std::vector<void*> fibers_;
    void* scheduler_ = nullptr;
#else
    void restart(size_t) {}
    void begin() {}
    void enter(size_t, const void*, size_t) {}
    void left() {}
    void entered() {}
    void leave(bool) {}
    void abandoned() {}
#endif
};

} // namespace sunstone::api::cuda
