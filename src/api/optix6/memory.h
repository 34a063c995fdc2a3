// SPDX-License-Identifier: Apache-2.0
// Memory that the host and a context's programs share (engine::Backend::allocateShared): single
// blocks, and containers of records.
#pragma once

#include "base/config.h"
#include "engine/backend.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace sunstone::optix6 {

// A block of zeros, aligned to 128 bytes.
class SharedMemory {
public:
    SharedMemory() = default;
    SharedMemory(std::shared_ptr<engine::Backend> backend, size_t bytes)
        : backend_(std::move(backend)), memory_(backend_->allocateShared(bytes)), size_(bytes) {}
    ~SharedMemory() {
        if (memory_)
            backend_->freeShared(memory_);
    }
    SharedMemory(SharedMemory&& other) noexcept { *this = std::move(other); }
    SharedMemory& operator=(SharedMemory&& other) noexcept {
        std::swap(backend_, other.backend_);
        std::swap(memory_, other.memory_);
        std::swap(size_, other.size_);
        return *this;
    }
    void* get() const { return memory_; }
    size_t size() const { return size_; }

private:
    std::shared_ptr<engine::Backend> backend_;
    void* memory_ = nullptr;
    size_t size_ = 0;
};

// Memory of many small objects that are freed together, because single allocations would take
// longer than all other work on them. Zeros, aligned to 64 bytes.
class SharedPool {
public:
    uint8_t* take(const std::shared_ptr<engine::Backend>& backend, size_t bytes) {
        // The memory checker only knows whole allocations.
        static const size_t chunk = checks("memory") ? 0 : size_t(64) << 10;
        bytes = (bytes + 63) / 64 * 64;
        if (chunks_.empty() || bytes > chunks_.back().size() - used_) {
            chunks_.emplace_back(backend, std::max(bytes, chunk));
            used_ = 0;
        }
        used_ += bytes;
        return static_cast<uint8_t*>(chunks_.back().get()) + used_ - bytes;
    }
    void clear() { chunks_.clear(); }

private:
    std::vector<SharedMemory> chunks_;
    size_t used_ = 0; // bytes of the last chunk
};

// Of the standard containers.
template <class T>
struct SharedAllocator {
    using value_type = T;
    using propagate_on_container_move_assignment = std::true_type;
    using propagate_on_container_copy_assignment = std::true_type;
    using propagate_on_container_swap = std::true_type;
    explicit SharedAllocator(std::shared_ptr<engine::Backend> b) : backend(std::move(b)) {}
    template <class U>
    SharedAllocator(const SharedAllocator<U>& other) : backend(other.backend) {}
    T* allocate(size_t count) {
        return static_cast<T*>(backend->allocateShared(count * sizeof(T)));
    }
    void deallocate(T* memory, size_t) noexcept { backend->freeShared(memory); }
    bool operator==(const SharedAllocator& other) const { return backend == other.backend; }
    std::shared_ptr<engine::Backend> backend;
};

template <class T>
using SharedVector = std::vector<T, SharedAllocator<T>>;

} // namespace sunstone::optix6
