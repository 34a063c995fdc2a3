// SPDX-License-Identifier: Apache-2.0
// Stacks for fibers: threads of a block, and launch indices whose rays are in flight.
#pragma once

#include <cstddef>

namespace sunstone {

// Stacks of equal size in one mapping, each with a guard page below. Kept per thread and reused.
class FiberStacks {
public:
    FiberStacks() = default;
    ~FiberStacks();
    FiberStacks(const FiberStacks&) = delete;
    FiberStacks& operator=(const FiberStacks&) = delete;

    // Provides `count` stacks of at least `size` bytes. Throws Error(kOutOfMemory).
    void reserve(size_t count, size_t size);
    void* top(size_t index) const { return base_ + (index + 1) * stride_; }
    size_t size() const { return stride_ - kGuard; }

private:
    static constexpr size_t kGuard = 4096;
    std::byte* base_ = nullptr;
    size_t count_ = 0, stride_ = 0;
};

} // namespace sunstone
