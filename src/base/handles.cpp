// SPDX-License-Identifier: Apache-2.0
#include "base/handles.h"

namespace sunstone {

uint64_t newSerial() {
    static std::atomic<uint64_t> serial{0};
    return serial.fetch_add(1, std::memory_order_relaxed) + 1;
}

uint64_t newHandle(uint64_t slot) {
    return newSerial() << kHandleSlotBits | slot;
}

} // namespace sunstone
