// SPDX-License-Identifier: Apache-2.0
// Looks up shader-binding records; every step is checked, see trace.h.
#pragma once

#include "devlib/abi.h"

namespace sunstone::devlib {

struct ResolvedRecord {
    const void* record = nullptr;      // null: no such record
    const GroupEntry* group = nullptr; // null: no group of the right kind in it
};

[[gnu::always_inline]] static inline const void* dataOf(const void* record) {
    return record ? static_cast<const uint8_t*>(record) + sizeof(SbtHeader) : nullptr;
}

[[gnu::always_inline]] static inline ResolvedRecord
resolveRecord(const LaunchState& launch, uint64_t base, uint32_t stride, uint32_t count,
              uint64_t index, GroupKind kind) {
    ResolvedRecord r;
    if (base == 0 || index >= count)
        return r;
    r.record = reinterpret_cast<const void*>(base + index * stride);
    const SbtHeader& header = *static_cast<const SbtHeader*>(r.record);
    if (header.magic == kSbtMagic && header.kind == kind && header.group < launch.groupCount)
        r.group = &launch.groups[header.group];
    return r;
}

} // namespace sunstone::devlib
