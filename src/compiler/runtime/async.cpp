// SPDX-License-Identifier: Apache-2.0
// Barrier objects in shared memory. The layout of the 64 bits, which is opaque to programs:
//   0 to 19   arrivals that the current phase still waits for
//   20 to 39  arrivals per phase
//   40 to 60  bytes of copies that it waits for, above kBytesBias
//   61 to 63  number of the phase
// Source: PTX ISA manual, "mbarrier".
#include "compiler/runtime/runtime.h"

#include "devlib/abi.h"

#include <atomic>

namespace sunstone::compiler {
namespace {

constexpr uint64_t kCountMask = 0xFFFFF, kBytesMask = 0x1FFFFF;
constexpr unsigned kExpectedShift = 20, kBytesShift = 40, kPhaseShift = 61;
constexpr uint64_t kBytesBias = 0x100000;

uint64_t pack(uint64_t pending, uint64_t expected, uint64_t bytes, uint64_t phase) {
    return (pending & kCountMask) | (expected & kCountMask) << kExpectedShift |
           (bytes & kBytesMask) << kBytesShift | phase << kPhaseShift;
}

uint64_t initial(uint32_t count) {
    return pack(count, count, kBytesBias, 0);
}

uint32_t pendingOf(uint64_t object) {
    return uint32_t(object & kCountMask);
}

uint64_t arrive(uint64_t* at, uint32_t count, uint32_t moreBytes, uint32_t drop) {
    std::atomic_ref<uint64_t> object(*at);
    uint64_t before = object.load(std::memory_order_relaxed), after;
    do {
        uint64_t expected = before >> kExpectedShift & kCountMask;
        uint64_t pending = pendingOf(before) - uint64_t(count);
        uint64_t phase = before >> kPhaseShift;
        if (drop)
            expected -= count;
        const uint64_t bytes =
            (before >> kBytesShift & kBytesMask) + uint64_t(int64_t(int32_t(moreBytes)));
        if ((pending & kCountMask) == 0 && (bytes & kBytesMask) == kBytesBias) {
            pending = expected;
            ++phase;
        }
        after = pack(pending, expected, bytes, phase);
    } while (!object.compare_exchange_weak(before, after, std::memory_order_acq_rel,
                                           std::memory_order_relaxed));
    return before;
}

// Whether the phase of a token or parity has ended.
uint32_t hasEnded(uint64_t* at, uint64_t phase, uint32_t isParity) {
    const uint64_t now = std::atomic_ref<uint64_t>(*at).load(std::memory_order_acquire);
    const uint64_t current = now >> kPhaseShift;
    return isParity ? (current & 1) != (phase & 1) : current != phase >> kPhaseShift;
}

uint32_t wait(devlib::KernelThread* thread, uint64_t* at, uint64_t phase, uint32_t isParity) {
    if (hasEnded(at, phase, isParity))
        return 1;
    if (thread->block)
        (*static_cast<devlib::BlockFunctions* const*>(thread->block))->yield(thread);
    return hasEnded(at, phase, isParity);
}

template <class Function>
const void* addressOf(Function* function) {
    return reinterpret_cast<const void*>(function);
}

} // namespace

void addAsyncSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        {"sunstone_mbarrier_init", addressOf(initial)},
        {"sunstone_mbarrier_pending", addressOf(pendingOf)},
        {"sunstone_mbarrier_arrive", addressOf(arrive)},
        {"sunstone_mbarrier_wait", addressOf(wait)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

} // namespace sunstone::compiler
