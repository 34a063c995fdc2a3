// SPDX-License-Identifier: Apache-2.0
// Opaque handles given to C callers. A handle is a number that the process issues once: the
// object's slot in its table (24 bits, from 1) and a serial number across all tables (40 bits). A
// table therefore refuses garbage, handles of other kinds, and handles of destroyed objects, even
// if a new object has their memory. Lookups return shared ownership: destroying a handle while
// another thread uses the object is safe.
#pragma once

#include "base/error.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <type_traits>
#include <utility>
#include <vector>

namespace sunstone {

constexpr unsigned kHandleSlotBits = 24;

// Counts from one, in the whole process.
uint64_t newSerial();

// A number that no other handle has, for the slot (0: of no table).
uint64_t newHandle(uint64_t slot = 0);

// Base of objects that store their handle.
class Handled {
public:
    Handled() = default; // null until a table has the object
    // Of no table: for owners that keep a list of their own.
    explicit Handled(uint64_t handle) : handle_(reinterpret_cast<void*>(handle)) {}
    void* handle() const { return handle_; }

private:
    template <class T>
    friend class HandleTable;
    void* handle_ = nullptr;
};

// The handle of an object that may be null.
inline void* handleOrNull(const std::shared_ptr<Handled>& object) {
    return object ? object->handle() : nullptr;
}

template <class T>
class HandleTable {
public:
    HandleTable() = default;
    HandleTable(const HandleTable&) = delete;
    ~HandleTable() {
        for (std::atomic<Slot*>& block : blocks_)
            delete[] block.load();
    }

    // Registers an object and returns its handle. Throws kOutOfMemory if the table is full.
    void* add(std::shared_ptr<T> object) {
        std::unique_lock lock(mutex_);
        const uint32_t number = freeSlot();
        Slot& slot = *slotAt(number);
        const uint64_t handle = newHandle(number + 1);
        if constexpr (std::is_base_of_v<Handled, T>)
            object->handle_ = reinterpret_cast<void*>(handle);
        slot.object = std::move(object);
        slot.handle.store(handle, std::memory_order_release);
        return reinterpret_cast<void*>(handle);
    }

    // The live object of this handle, or null.
    std::shared_ptr<T> find(const void* handle) const {
        std::shared_lock lock(mutex_);
        const Slot* slot = live(reinterpret_cast<uint64_t>(handle));
        return slot ? slot->object : nullptr;
    }

    // Whether the handle's object is in the table; takes no lock.
    bool isAlive(const void* handle) const { return live(reinterpret_cast<uint64_t>(handle)); }

    // The object without a lock and without ownership, for device code: the application must not
    // destroy what a running launch uses.
    T* peek(uint64_t handle) const {
        const Slot* slot = live(handle);
        return slot ? slot->object.get() : nullptr;
    }

    // A live object for which `predicate(object)` holds, or null.
    template <class Predicate>
    std::shared_ptr<T> findIf(Predicate predicate) const {
        std::shared_lock lock(mutex_);
        for (uint32_t i = 0; i < used_; ++i)
            if (const Slot& slot = *slotAt(i); slot.object && predicate(*slot.object))
                return slot.object;
        return nullptr;
    }

    // Removes the handle and returns its object, or null if it is not alive.
    std::shared_ptr<T> remove(const void* handle) {
        std::unique_lock lock(mutex_);
        Slot* slot = const_cast<Slot*>(live(reinterpret_cast<uint64_t>(handle)));
        return slot ? release(*slot) : nullptr;
    }

    // Removes every object for which `predicate(object)` holds, e.g. those of a destroyed context.
    template <class Predicate>
    std::vector<std::shared_ptr<T>> removeIf(Predicate predicate) {
        std::vector<std::shared_ptr<T>> removed;
        std::unique_lock lock(mutex_);
        for (uint32_t i = 0; i < used_; ++i)
            if (Slot& slot = *slotAt(i); slot.object && predicate(*slot.object))
                removed.push_back(release(slot));
        return removed;
    }

private:
    // Slots are in blocks that never move, so that peek() needs no lock.
    static constexpr uint32_t kBlockSlots = 1024, kMaxBlocks = 4096;
    static_assert(uint64_t(kBlockSlots) * kMaxBlocks < 1u << kHandleSlotBits);

    struct Slot {
        std::atomic<uint64_t> handle{0}; // 0: free
        std::shared_ptr<T> object;
    };

    Slot* slotAt(uint32_t number) const {
        Slot* block = blocks_[number / kBlockSlots].load(std::memory_order_acquire);
        return block ? block + number % kBlockSlots : nullptr;
    }

    const Slot* live(uint64_t handle) const {
        const uint32_t number = uint32_t(handle & ((1u << kHandleSlotBits) - 1)) - 1;
        if (number >= kBlockSlots * kMaxBlocks)
            return nullptr;
        const Slot* slot = slotAt(number);
        return slot && slot->handle.load(std::memory_order_acquire) == handle ? slot : nullptr;
    }

    uint32_t freeSlot() {
        if (!free_.empty()) {
            const uint32_t number = free_.back();
            free_.pop_back();
            return number;
        }
        if (used_ == kBlockSlots * kMaxBlocks)
            fail(Code::kOutOfMemory, "more than ", used_, " objects of one kind are alive");
        if (used_ % kBlockSlots == 0)
            blocks_[used_ / kBlockSlots].store(new Slot[kBlockSlots], std::memory_order_release);
        return used_++;
    }

    std::shared_ptr<T> release(Slot& slot) {
        free_.push_back(uint32_t(slot.handle.load() & ((1u << kHandleSlotBits) - 1)) - 1);
        slot.handle.store(0, std::memory_order_release);
        return std::move(slot.object);
    }

    mutable std::shared_mutex mutex_;
    std::atomic<Slot*> blocks_[kMaxBlocks] = {};
    std::vector<uint32_t> free_;
    uint32_t used_ = 0;
};

} // namespace sunstone
