// SPDX-License-Identifier: Apache-2.0
#include "base/threads/fiber_stacks.h"

#include "base/error.h"

#include <sys/mman.h>

#include <algorithm>

namespace sunstone {

FiberStacks::~FiberStacks() {
    if (base_)
        munmap(base_, count_ * stride_);
}

void FiberStacks::reserve(size_t count, size_t size) {
    const size_t stride = ((size + 4095) & ~size_t(4095)) + kGuard;
    if (count <= count_ && stride <= stride_)
        return;
    if (base_)
        munmap(base_, count_ * stride_);
    base_ = nullptr;
    count_ = std::max(count, count_);
    stride_ = std::max(stride, stride_);
    void* memory = mmap(nullptr, count_ * stride_, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) {
        count_ = stride_ = 0;
        fail(Code::kOutOfMemory, "no memory for the stacks of ", count, " threads");
    }
    base_ = static_cast<std::byte*>(memory);
    for (size_t i = 0; i < count_; ++i)
        mprotect(base_ + i * stride_, kGuard, PROT_NONE);
}

} // namespace sunstone
