// SPDX-License-Identifier: Apache-2.0
// The handle table of texture.h: slots in blocks that never move, read without locks. A handle's
// low half is its slot's number plus one, the high half the slot's generation, so old handles of a
// reused slot are invalid.
#include "texture/texture.h"

#include "base/error.h"
#include "texture/device_functions.h"

#include <atomic>
#include <mutex>

namespace sunstone::texture {

namespace {

constexpr uint32_t kBlockSlots = 1024, kMaxBlocks = 4096;

struct Slot {
    std::atomic<uint64_t> handle{0}; // 0: free
    std::atomic<const Texture*> texture{nullptr};
    std::atomic<const Surface*> surface{nullptr};
    uint32_t generation = 0;
};

class Table {
public:
    uint64_t add(const Texture* texture, const Surface* surface) {
        std::lock_guard lock(mutex_);
        uint32_t number = used_;
        if (!free_.empty()) {
            number = free_.back();
            free_.pop_back();
        } else {
            if (used_ == kBlockSlots * kMaxBlocks)
                fail(Code::kOutOfMemory, "too many textures and surfaces");
            if (used_ % kBlockSlots == 0)
                blocks_[used_ / kBlockSlots].store(new Slot[kBlockSlots],
                                                   std::memory_order_release);
            ++used_;
        }
        Slot& slot = *find(number);
        slot.generation = (slot.generation + 1) & 0xFFFFFF;
        slot.texture.store(texture, std::memory_order_relaxed);
        slot.surface.store(surface, std::memory_order_relaxed);
        const uint64_t handle = uint64_t(slot.generation) << 32 | (number + 1);
        slot.handle.store(handle, std::memory_order_release);
        return handle;
    }

    // The slot of a live handle, or null.
    const Slot* live(uint64_t handle) const {
        const uint32_t number = uint32_t(handle) - 1;
        if (number >= kBlockSlots * kMaxBlocks)
            return nullptr;
        const Slot* slot = find(number);
        return slot && slot->handle.load(std::memory_order_acquire) == handle ? slot : nullptr;
    }

    bool remove(uint64_t handle, bool isTexture) {
        const Texture* texture = nullptr;
        const Surface* surface = nullptr;
        {
            std::lock_guard lock(mutex_);
            Slot* slot = const_cast<Slot*>(live(handle));
            if (!handle || !slot || (slot->texture.load() != nullptr) != isTexture)
                return false;
            slot->handle.store(0, std::memory_order_release);
            texture = slot->texture.exchange(nullptr);
            surface = slot->surface.exchange(nullptr);
            free_.push_back(uint32_t(handle) - 1);
        }
        delete texture;
        delete surface;
        return true;
    }

private:
    Slot* find(uint32_t number) const {
        Slot* block = blocks_[number / kBlockSlots].load(std::memory_order_acquire);
        return block ? block + number % kBlockSlots : nullptr;
    }

    std::atomic<Slot*> blocks_[kMaxBlocks] = {};
    std::mutex mutex_;
    uint32_t used_ = 0;
    std::vector<uint32_t> free_;
};

Table& table() {
    static Table* instance = new Table; // never destroyed: device code may run until the process
                                        // ends
    return *instance;
}

} // namespace

uint64_t add(std::unique_ptr<Texture> texture) {
    const uint64_t handle = table().add(texture.get(), nullptr);
    texture.release();
    return handle;
}
uint64_t add(std::unique_ptr<Surface> surface) {
    const uint64_t handle = table().add(nullptr, surface.get());
    surface.release();
    return handle;
}
const Texture* findTexture(uint64_t handle) {
    const Slot* slot = table().live(handle);
    return slot ? slot->texture.load(std::memory_order_relaxed) : nullptr;
}
const Surface* findSurface(uint64_t handle) {
    const Slot* slot = table().live(handle);
    return slot ? slot->surface.load(std::memory_order_relaxed) : nullptr;
}
const void* linearMemory(uint64_t handle) {
    const Texture* texture = findTexture(handle);
    return texture && texture->arrays.empty() ? texture->images[0].data : nullptr;
}
bool removeTexture(uint64_t handle) {
    return table().remove(handle, true);
}
bool removeSurface(uint64_t handle) {
    return table().remove(handle, false);
}

} // namespace sunstone::texture
