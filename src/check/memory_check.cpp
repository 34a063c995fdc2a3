// SPDX-License-Identifier: Apache-2.0
// See memory_check.h: which accesses are allowed. report.cpp writes the reports.
#include "check/memory_check.h"

#include "base/config.h"
#include "base/threads/threads.h"
#include "check/report.h"
#include "compiler/compiler.h"
#include "device/cpu/memory.h"

#include <bit>

namespace sunstone::check {

namespace {

namespace cpu = device::cpu;

// Whether the range lies in one live allocation. Threads mostly stay within a few allocations.
bool inAllocation(uint64_t address, uint64_t bytes, bool isWritten) {
    struct Known {
        uint64_t version = 0;
        Range range;
    };
    constexpr size_t kKnown = 4;
    thread_local Known known[kKnown];
    thread_local size_t next = 0;
    const uint64_t version = cpu::memory().version();
    for (const Known& entry : known)
        if (entry.version == version && entry.range.holds(address, bytes) && entry.range.end != 0)
            return true;
    const auto found = cpu::memory().find(reinterpret_cast<const void*>(address));
    if (!found)
        return false;
    const Range range{found->base, found->base + found->size};
    if (found->kind == cpu::MemoryKind::kMapped && found->flags != 3)
        return !isWritten && found->flags != 0 && range.holds(address, bytes);
    known[next++ % kKnown] = {version, range};
    return range.holds(address, bytes);
}

bool isFreed(uint64_t address) {
    for (const cpu::FreedAllocation& freed : cpu::memory().freed())
        if (Range{freed.base, freed.base + freed.size}.holds(address, 1))
            return true;
    return false;
}

bool isAllowed(uint64_t address, const devlib::AccessPlace& place, const Scene& scene) {
    const uint64_t bytes = place.bytes;
    if (place.space == devlib::kSpaceGeneric && scene.shared.holds(address, bytes))
        return true;
    if (place.space != devlib::kSpaceGlobal &&
        (scene.stack.holds(address, bytes) || scene.params.holds(address, bytes)))
        return true;
    const auto* pointer = reinterpret_cast<const void*>(address);
    if (inAllocation(address, bytes, place.kind != devlib::kAccessLoad) || compiler::inDeviceData(pointer, bytes))
        return true;
    // The launch's constant parameters may be addressed as global memory.
    for (const Range& range : {scene.params, scene.launchIndex, scene.launchDimensions})
        if (range.holds(address, bytes) && place.kind == devlib::kAccessLoad)
            return true;
    static const bool hostAllowed = checks("host");
    return hostAllowed && cpu::isMapped(pointer, bytes) && !isFreed(address) &&
           !cpu::memory().find(pointer);
}

} // namespace

bool enabled() {
    static const bool on = checks("memory");
    return on;
}

Fault examine(const devlib::CheckedAccess& access, const Scene& scene) {
    const devlib::AccessPlace& place = *access.place;
    Fault fault = Fault::kNone;
    if (access.address % std::bit_floor(std::max(1u, place.bytes)) != 0)
        fault = Fault::kAlignment;
    else if (access.objectBytes != 0)
        fault = Range{access.object, access.object + access.objectBytes}.holds(access.address,
                                                                               place.bytes)
                    ? Fault::kNone
                    : Fault::kAddress;
    else if (place.space == devlib::kSpaceShared)
        fault = scene.shared.holds(access.address, place.bytes) ? Fault::kNone : Fault::kShared;
    else if (!isAllowed(access.address, place, scene))
        fault = Fault::kAddress;
    if (fault != Fault::kNone)
        report(fault, access, scene);
    return fault;
}

Range stackOfThread() {
    return {reinterpret_cast<uint64_t>(__builtin_frame_address(0)), sunstone::stackOfThread().end};
}

} // namespace sunstone::check
