// SPDX-License-Identifier: Apache-2.0
// See quarantine.h.
#include "device/cpu/quarantine.h"

#include "base/error.h"
#include "base/log.h"
#include "device/cpu/poison.h"

#include <cerrno>
#include <cstring>

namespace sunstone::device::cpu {

void Quarantine::add(FreedAllocation freed, Block block, bool isHuge, bool hasMemory) {
    // Outside the lock, because returning much memory takes long.
    if (hasMemory && !isChecked_ && block.bytes > Pages::kMostReused) {
        Pages::clear(block);
        hasMemory = false;
    }
    std::lock_guard lock(mutex_);
    // The checker counts the bytes that programs requested.
    const size_t bytes = isChecked_ ? freed.size : block.bytes;
    (hasMemory ? open_.bytes : open_.addresses) += bytes;
    open_.entries.push_back({std::move(freed), block, isHuge, hasMemory});
    unsealed_.store(open_.entries.size(), std::memory_order_release);
    if (open_.entries.size() >= kTogether || open_.bytes >= kTogetherBytes)
        close();
}

void Quarantine::sealNow() {
    std::lock_guard lock(mutex_);
    close();
}

void Quarantine::close() {
    if (open_.entries.empty())
        return;
    if (!isChecked_ || allocations_ < kAllocations) {
        std::vector<Block> blocks;
        for (const Entry& entry : open_.entries)
            if (entry.hasMemory)
                blocks.push_back(entry.block);
        open_.sealed = mergedBlocks(std::move(blocks));
        for (const Block& block : open_.sealed)
            if (!setAccess(block, false))
                log(LogLevel::kError, "device",
                    message("late accesses to freed memory stay unseen: mprotect: ",
                            std::strerror(errno)));
    }
    bytes_ += open_.bytes;
    addresses_ += open_.addresses;
    allocations_ += open_.entries.size();
    groups_.push_back(std::move(open_));
    open_ = {};
    unsealed_.store(0, std::memory_order_release);
    while (isOverLimit())
        releaseOldest();
}

bool Quarantine::isOverLimit() const {
    if (isChecked_)
        return bytes_ > kCheckedBytes || addresses_ > kAddresses;
    return groups_.size() > 1 &&
           (bytes_ > kBytes || addresses_ > kAddresses || allocations_ > kAllocations);
}

void Quarantine::releaseOldest() {
    Group group = std::move(groups_.front());
    groups_.pop_front();
    bytes_ -= group.bytes;
    addresses_ -= group.addresses;
    allocations_ -= group.entries.size();
    bool isAccessible = true;
    for (const Block& block : group.sealed)
        isAccessible = setAccess(block, true) && isAccessible;
    for (const Entry& entry : group.entries) {
        if (entry.hasMemory && isAccessible) {
            pages().keepWarm(entry.block, entry.isHuge);
            continue;
        }
        if (entry.hasMemory) {
            Pages::clear(entry.block);
            unpoison(entry.block.begin, entry.block.bytes);
        }
        pages().keepCold(entry.block);
    }
}

void Quarantine::empty() {
    std::lock_guard lock(mutex_);
    close();
    while (!groups_.empty())
        releaseOldest();
}

std::vector<FreedAllocation> Quarantine::list() const {
    std::lock_guard lock(mutex_);
    std::vector<FreedAllocation> all;
    const auto add = [&](const Group& group) {
        for (const Entry& entry : group.entries)
            all.push_back(entry.freed);
    };
    for (const Group& group : groups_)
        add(group);
    add(open_);
    return all;
}

} // namespace sunstone::device::cpu
