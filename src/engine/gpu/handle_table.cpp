// SPDX-License-Identifier: Apache-2.0
// See handle_table.h.
#include "engine/gpu/handle_table.h"

#include "bvh/gpu/known_handles.h"
#include "device/cuda/driver.h"
#include "devlib/abi.h"

#include <algorithm>
#include <bit>

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

// Whether a handle may be valid although its address is in another allocation now. Transforms
// belong to the caller: the same address gives the same handle, without a call. Memory that the
// caller maps again may hold a structure that it kept elsewhere meanwhile.
bool mayBeBack(uint64_t handle) {
    return !isStructure(handle) || isMappedByApplication(driver(), devlib::addressOf(handle));
}

} // namespace

void GpuHandleTable::note(uint64_t handle, bool moves) {
    const uint64_t allocation = allocationOf(handle); // throws before anything has changed
    const devlib::HandleTag tag = devlib::tagOf(handle);
    graphs_.any = true;
    graphs_.instances |= tag != devlib::kTagGas;
    graphs_.deep |= !isStructure(handle);
    graphs_.keys |= moves;
    graphs_.motion |= moves || tag == devlib::kTagMatrixMotion || tag == devlib::kTagSrtMotion;
    if (!graphs_.deep && tag == devlib::kTagIas &&
        std::ranges::find(instanceStructures_, handle) == instanceStructures_.end())
        instanceStructures_.push_back(handle);
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

void GpuHandleTable::look(size_t count) {
    for (size_t asked = 0, seen = 0; asked < count && seen < order_.size(); ++seen) {
        next_ = (next_ + 1) % order_.size();
        asked += look(entries_.find(order_[next_])->second);
    }
}

uint64_t GpuHandleTable::usual(uint64_t handle) {
    for (const uint64_t each : {handle, newest_})
        if (const auto found = entries_.find(each); found != entries_.end()) {
            look(found->second);
            if (found->second.isThere)
                return each;
        }
    return 0;
}

const GpuGraphs& GpuHandleTable::graphs() {
    if (graphs_.deep || instanceStructures_.size() < 2)
        return graphs_;
    std::erase_if(instanceStructures_, [this](uint64_t handle) {
        const auto found = entries_.find(handle);
        if (found == entries_.end())
            return true;
        look(found->second);
        return !found->second.isThere;
    });
    graphs_.deep = instanceStructures_.size() >= 2;
    return graphs_;
}

void GpuHandleTable::tidy() {
    if (slots.empty() || writes.size() > 4 * slots.size())
        lay();
}

unsigned GpuHandleTable::shift() const {
    return 32 - unsigned(std::countr_zero(slots.size()));
}

// Returns whether it queried the driver.
bool GpuHandleTable::look(Entry& entry) {
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

void GpuHandleTable::set(Entry& entry, bool isThere) {
    if (entry.isThere == isThere)
        return;
    entry.isThere = isThere;
    slots[entry.place] = isThere ? entry.handle : goneEntry(entry.place, shift());
    writes.push_back(entry.place);
}

void GpuHandleTable::enter(Entry& entry) {
    uint32_t place = placeOfHandle(entry.handle, shift());
    while (slots[place] != kFreeEntry)
        place = (place + 1) % uint32_t(slots.size());
    entry.place = place;
    slots[place] = entry.handle;
}

// Lays out another table, without removed handles.
void GpuHandleTable::lay() {
    std::erase_if(entries_, [](const auto& each) { return !each.second.isThere; });
    std::erase_if(order_, [&](uint64_t handle) { return !entries_.contains(handle); });
    constexpr size_t kLeast = 256;
    slots.assign(std::bit_ceil(std::max(kLeast, 4 * order_.size())), kFreeEntry);
    writes.clear();
    ++layout;
    for (auto& [handle, entry] : entries_)
        enter(entry);
}

} // namespace sunstone::engine
