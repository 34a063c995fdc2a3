// SPDX-License-Identifier: Apache-2.0
// GroupEntry::builtinPrimitive: the number of an OptixPrimitiveType and, from bit 16 on, the
// options of the built-in intersection (OptixBuiltinISOptions). 0: none. CPUs and GPUs share the
// rule that decides whether a group fits a structure.
#pragma once

#include "bvh/input/input_lookup.h"
#include "bvh/shapes/curves.h"
#include "devlib/abi.h"

#include <cstdint>

namespace sunstone::devlib {

enum BuiltinTrait : uint32_t {
    kBuiltinEndcaps = 1,
    kBuiltinMotion = 2,
    kBuiltinFastTrace = 4, // as bvh::OptionBit; neither: not stated
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

// The other options of a built-in intersection of curves or spheres. An unstated preference fits
// all structures, and motion also fits structures without it.
inline bool fitsTraits(uint32_t traits, const bvh::BlockHeader& block, uint32_t sbtGasIndex) {
    constexpr uint32_t kPreferences = kBuiltinFastTrace | kBuiltinFastBuild;
    static_assert(kPreferences == (bvh::kOptionFastTrace | bvh::kOptionFastBuild));
    const uint32_t preference = traits & kPreferences;
    if (preference != 0 && preference != (block.options & kPreferences))
        return false;
    if (bvh::isMoving(block.type) && !(traits & kBuiltinMotion))
        return false;
    const bvh::InputRecord* input = bvh::inputWithSbtIndex(block, sbtGasIndex);
    return !bvh::isCurveBasis(block.shape) || !input ||
           bvh::hasEndcaps(*input) == ((traits & kBuiltinEndcaps) != 0);
}

// Whether a hit group fits the primitives of a structure (or no structure).
inline bool fitsBuiltin(uint32_t packed, const bvh::BlockHeader* block, uint32_t sbtGasIndex) {
    const uint32_t primitive = primitiveOfBuiltin(packed);
    if (!block)
        return true;
    switch (bvh::kindOf(block->type)) {
    case bvh::BlockType::kShapes:
        return primitive == block->shape &&
               fitsTraits(traitsOfBuiltin(packed), *block, sbtGasIndex);
    case bvh::BlockType::kTriangles:
        return primitive == 0 || primitive == kPrimitiveTriangle;
    default:
        return primitive == 0;
    }
}

} // namespace sunstone::devlib
