// SPDX-License-Identifier: Apache-2.0
// GroupEntry::builtinPrimitive: the number of an OptixPrimitiveType and, from bit 16 on, what the
// built-in intersection was asked for (OptixBuiltinISOptions). 0: the group has none.
#pragma once

#include <cstdint>

namespace sunstone::devlib {

enum BuiltinTrait : uint32_t {
    kBuiltinEndcaps = 1,
    kBuiltinMotion = 2,
    kBuiltinFastTrace = 4, // as bvh::OptionBit; neither: nothing was said
    kBuiltinFastBuild = 8,
};
inline uint32_t packBuiltin(uint32_t primitive, uint32_t traits) {
    return primitive | traits << 16;
}
inline uint32_t primitiveOfBuiltin(uint32_t packed) {
    return packed & 0xFFFF;
}
inline uint32_t traitsOfBuiltin(uint32_t packed) {
    return packed >> 16;
}

} // namespace sunstone::devlib
