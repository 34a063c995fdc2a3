// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/structures.h"

#include "bvh/gpu/known_handles.h"
#include "devlib/abi.h"

#include <algorithm>
#include <bit>
#include <unordered_map>
#include <vector>

namespace sunstone::engine {
namespace {

using namespace device::cuda;
using namespace bvh::gpu;

// The driver's number of the allocation that contains a handle's address; a later allocation there
// has another number; 0: no allocation.
uint64_t allocationOf(uint64_t handle) {
    unsigned long long number = 0;
    const CUresult told = driver().pointerGetAttribute(&number, CU_POINTER_ATTRIBUTE_BUFFER_ID,
                                                       devlib::addressOf(handle));
    if (told == CUDA_ERROR_INVALID_VALUE)
        return 0;
    check(told, DriverNames::pointerGetAttribute);
    return number;
}

bool isStructure(uint64_t handle) {
    const devlib::HandleTag tag = devlib::tagOf(handle);
    return tag == devlib::kTagGas || tag == devlib::kTagIas;
}

// All handles of the process, and the intended table of each context: handles may be used in any of
// them. A handle keeps its place until the layout changes.
class Handles {
public:
    std::mutex mutex;

    void note(uint64_t handle) {
        const uint64_t allocation = allocationOf(handle); // throws before anything has changed
        if (isStructure(handle)) { // the memory held one of the other kind before
            const auto other = entries_.find(handle ^ devlib::kTagGas ^ devlib::kTagIas);
            if (other != entries_.end())
                set(other->second, false);
            newest_ = handle;
        }
        const auto known = entries_.find(handle);
        if (known != entries_.end()) {
            known->second.allocation = allocation;
            return set(known->second, true);
        }
        if (2 * (order_.size() + 1) > slots.size())
            lay();
        order_.push_back(handle);
        Entry& entry = entries_[handle];
        entry.handle = handle;
        entry.allocation = allocation;
        enter(entry);
        writes.push_back(entry.place);
    }

    // Checks this many structures with the driver, continuing after the last call's.
    void look(size_t count) {
        for (size_t asked = 0, seen = 0; asked < count && seen < order_.size(); ++seen) {
            next_ = (next_ + 1) % order_.size();
            asked += look(entries_.find(order_[next_])->second);
        }
    }
    // The one of the two that is valid, or 0.
    uint64_t usual(uint64_t handle) {
        for (const uint64_t each : {handle, newest_})
            if (const auto found = entries_.find(each); found != entries_.end()) {
                look(found->second);
                if (found->second.isThere)
                    return each;
            }
        return 0;
    }

    // There is a table, and it is shorter to write it than all that has changed.
    void tidy() {
        if (slots.empty() || writes.size() > 4 * slots.size())
            lay();
    }

    std::vector<uint64_t> slots;
    uint64_t layout = 0;          // counts changes of all places
    std::vector<uint32_t> writes; // places written to since, in order
    unsigned shift() const { return 32 - unsigned(std::countr_zero(slots.size())); }

private:
    struct Entry {
        uint64_t handle = 0;
        uint32_t place = 0;
        bool isThere = true;
        uint64_t allocation = 0; // of the driver's; 0: none, and not checked
    };

    // Returns whether it queried the driver.
    bool look(Entry& entry) {
        if (entry.allocation == 0)
            return false;
        const uint64_t found = allocationOf(entry.handle);
        if (found == 0) {
            set(entry, false);
        } else if (found == entry.allocation || mayBeBack(entry.handle)) {
            entry.allocation = found;
            set(entry, true);
        } else {
            set(entry, false);
        }
        return true;
    }

    // In other memory. Transforms are the caller's: an address makes the same handle again, without
    // a call. Memory that the caller maps again may hold a structure that was kept elsewhere
    // meanwhile.
    static bool mayBeBack(uint64_t handle) {
        return !isStructure(handle) || isMappedByApplication(driver(), devlib::addressOf(handle));
    }

    void set(Entry& entry, bool isThere) {
        if (entry.isThere == isThere)
            return;
        entry.isThere = isThere;
        slots[entry.place] = isThere ? entry.handle : goneEntry(entry.place, shift());
        writes.push_back(entry.place);
    }

    void enter(Entry& entry) {
        uint32_t place = placeOfHandle(entry.handle, shift());
        while (slots[place] != kFreeEntry)
            place = (place + 1) % uint32_t(slots.size());
        entry.place = place;
        slots[place] = entry.handle;
    }

    // Another table, without removed handles.
    void lay() {
        std::erase_if(entries_, [](const auto& each) { return !each.second.isThere; });
        std::erase_if(order_, [&](uint64_t handle) { return !entries_.contains(handle); });
        constexpr size_t kLeast = 256;
        slots.assign(std::bit_ceil(std::max(kLeast, 4 * order_.size())), kFreeEntry);
        writes.clear();
        ++layout;
        for (auto& [handle, entry] : entries_)
            enter(entry);
    }

    std::unordered_map<uint64_t, Entry> entries_;
    std::vector<uint64_t> order_;
    size_t next_ = 0;
    uint64_t newest_ = 0;
};

Handles& handles() {
    static Handles all;
    return all;
}

} // namespace

// The tables that graphs may read at any time.
struct GpuKnownHandles::Followers {
    std::mutex mutex; // taken before all others
    std::vector<GpuKnownHandles*> all;
};

GpuKnownHandles::Followers& GpuKnownHandles::followers() {
    static Followers them;
    return them;
}

void noteGpuHandle(uint64_t handle) {
    {
        Handles& all = handles();
        std::lock_guard lock(all.mutex);
        all.note(handle);
    }
    GpuKnownHandles::Followers& them = GpuKnownHandles::followers();
    std::lock_guard lock(them.mutex);
    std::erase_if(them.all, [](GpuKnownHandles* each) { return !each->tryRefresh(); });
}

GpuKnownHandles::~GpuKnownHandles() {
    {
        Followers& them = followers();
        std::lock_guard lock(them.mutex);
        std::erase(them.all, this);
    }
    if (stream_)
        driver().streamDestroy(stream_);
    for (const CUdeviceptr memory : {table_, replaced_, cell_})
        if (memory)
            driver().memFree(memory);
}

// The replaced table stays allocated until the next replacement: running launches may read it, and
// freeing waits for them.
void GpuKnownHandles::makeRoom(size_t entries) {
    if (!stream_)
        SUNSTONE_CU(streamCreate, &stream_, CU_STREAM_NON_BLOCKING);
    CUdeviceptr table = 0;
    SUNSTONE_CU(memAlloc, &table, entries * sizeof(uint64_t));
    if (replaced_)
        driver().memFree(replaced_);
    replaced_ = table_;
    table_ = table;
}

GpuKnownHandles::View GpuKnownHandles::update(size_t asked, uint64_t usual, CUstream stream) {
    const bool isCaptured = isCapturing(driver(), stream);
    if (isCaptured)
        follow();
    std::lock_guard own(mutex_);
    const View view = refresh(asked, usual);
    return isCaptured ? View{cell_ | kOfGraph, 0} : view;
}

void GpuKnownHandles::follow() {
    Followers& them = followers();
    std::lock_guard lock(them.mutex);
    if (std::find(them.all.begin(), them.all.end(), this) != them.all.end())
        return;
    std::lock_guard own(mutex_);
    if (!cell_) {
        SUNSTONE_CU(ctxGetCurrent, &context_);
        SUNSTONE_CU(memAlloc, &cell_, sizeof(uint64_t));
    }
    told_ = ~uint64_t(0); // unset, or outdated
    them.all.push_back(this);
}

// False: from now on graphs accept all handles unchecked, or cannot run any more.
bool GpuKnownHandles::tryRefresh() {
    std::lock_guard own(mutex_);
    try {
        ContextScope scope(context_);
        try {
            refresh(0, 0);
        } catch (const Error&) {
            const uint64_t none = 0;
            SUNSTONE_CU(memcpyHtoD, cell_, &none, sizeof(none));
            throw;
        }
        return true;
    } catch (const Error&) {
        return false;
    }
}

GpuKnownHandles::View GpuKnownHandles::refresh(size_t asked, uint64_t usual) {
    Handles& all = handles();
    std::lock_guard lock(all.mutex);
    all.tidy();
    all.look(asked);
    usual = all.usual(usual);
    const bool isNew = layout_ != all.layout;
    const bool isToBeTold = cell_ && (isNew || told_ != (table_ | all.shift()));
    if (isNew || isToBeTold || written_ != all.writes.size()) {
        constexpr size_t kFew = 16;
        if (isNew)
            makeRoom(all.slots.size());
        const auto write = [&](size_t place, size_t count) {
            SUNSTONE_CU(memcpyHtoDAsync, table_ + place * sizeof(uint64_t), &all.slots[place],
                        count * sizeof(uint64_t), stream_);
        };
        if (isNew || all.writes.size() - written_ > kFew)
            write(0, all.slots.size());
        else
            for (size_t i = written_; i < all.writes.size(); ++i)
                write(all.writes[i], 1);
        const uint64_t known = table_ | all.shift();
        if (isToBeTold)
            SUNSTONE_CU(memcpyHtoDAsync, cell_, &known, sizeof(known), stream_);
        SUNSTONE_CU(streamSynchronize, stream_);
        layout_ = all.layout;
        written_ = all.writes.size();
        if (isToBeTold)
            told_ = known;
    }
    return {table_ | all.shift(), usual};
}

} // namespace sunstone::engine
