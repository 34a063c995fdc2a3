// SPDX-License-Identifier: Apache-2.0
// Reports switches between the scheduler's stack and the stacks of fibers to the sanitizers; empty
// in other builds.
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

namespace sunstone {

class SanitizerFibers {
public:
#if defined(SUNSTONE_ASAN_FIBERS) || defined(SUNSTONE_TSAN_FIBERS)
    static constexpr bool kActive = true; // fibers may switch to the scheduler alone
#else
    static constexpr bool kActive = false;
#endif
    SanitizerFibers() = default;
    SanitizerFibers(const SanitizerFibers&) = delete;
    SanitizerFibers& operator=(const SanitizerFibers&) = delete;
    ~SanitizerFibers() { restart(0); }

#if defined(SUNSTONE_ASAN_FIBERS)
    // Forgets all fibers: abandoned fibers have left frames open in the sanitizer.
    void restart(size_t count) { fakes_.assign(count, nullptr); }
    // Sets the caller as the target of `leave`.
    void begin() {}
    // Called on the scheduler, before and after it runs a fiber.
    void enter(size_t index, const void* stackTop, size_t size) {
        running_ = index;
        __sanitizer_start_switch_fiber(&schedulerFake_, static_cast<const char*>(stackTop) - size,
                                       size);
    }
    void left() { __sanitizer_finish_switch_fiber(schedulerFake_, nullptr, nullptr); }
    // Called on a fiber, when it starts or resumes and before it switches back.
    void entered() {
        __sanitizer_finish_switch_fiber(fakes_[running_], &schedulerBottom_, &schedulerSize_);
    }
    void leave(bool forever) {
        __sanitizer_start_switch_fiber(forever ? nullptr : &fakes_[running_], schedulerBottom_,
                                       schedulerSize_);
    }
    // Called on the scheduler after a jump out of a fiber.
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
    void begin() { scheduler_ = __tsan_get_current_fiber(); }
    void enter(size_t index, const void*, size_t) { __tsan_switch_to_fiber(fibers_[index], 0); }
    void left() {}
    void entered() {}
    void leave(bool) { __tsan_switch_to_fiber(scheduler_, 0); }
    void abandoned() { leave(true); }

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

} // namespace sunstone
