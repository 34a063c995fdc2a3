// SPDX-License-Identifier: Apache-2.0
// Look-up of a structure's opacity micromaps in traversal, on the CPU and on GPUs.
#pragma once

#include "bvh/layout.h"
#include "bvh/micromap/micromap.h"
#include "bvh/simd.h"

namespace sunstone::bvh::SUNSTONE_ISA {

struct MicromapLookup {
    const uint8_t* block;
    const InputRecord* inputs;
    const MicromapRecord* records;
    uint32_t numInputs;

    SUNSTONE_INLINE_MEMBER explicit MicromapLookup(const BlockHeader* header)
        : block(reinterpret_cast<const uint8_t*>(header)),
          inputs(reinterpret_cast<const InputRecord*>(block + header->inputsOffset)),
          records(reinterpret_cast<const MicromapRecord*>(block + header->micromapsOffset)),
          numInputs(header->numInputs) {}

    // The build input of a triangle: the last one whose SBT indices begin at or before its own.
    SUNSTONE_INLINE_MEMBER uint32_t inputOf(uint32_t sbtWord) const {
        const uint32_t index = sbtWord & kSbtIndexMask;
        uint32_t first = 0, count = numInputs;
        while (count > 1) {
            const uint32_t half = count / 2;
            if (inputs[first + half].firstSbtIndex <= index)
                first += half;
            count -= half;
        }
        return first;
    }

    // MicromapState of a triangle at barycentrics (u, v); primitive and sbtWord as in its leaf.
    SUNSTONE_INLINE_MEMBER uint32_t stateAt(uint32_t primitive, uint32_t sbtWord, float u,
                                            float v) const {
        const uint32_t input = inputOf(sbtWord);
        const MicromapRecord& record = records[input];
        if (!record.refsOffset)
            return kNoMicromap;
        const auto* refs = reinterpret_cast<const MicromapRef*>(block + record.refsOffset);
        return micromapStateAt(reinterpret_cast<const uint8_t*>(record.array),
                               refs[primitive - inputs[input].primitiveIndexOffset], u, v);
    }
};

// False if the triangle is transparent there; else the state replaces its geometry flag
// DISABLE_ANYHIT. Instance and ray flags apply afterwards.
SUNSTONE_INLINE bool throughMicromap(uint32_t state, bool twoStates, uint32_t& sbtWord) {
    if (state == kNoMicromap)
        return true;
    if (twoStates)
        state = forcedToTwoStates(state);
    const uint32_t disabled = 1u << kGeometryFlagShift;
    sbtWord = state == kOpaque ? sbtWord | disabled : sbtWord & ~disabled;
    return state != kTransparent;
}

} // namespace sunstone::bvh::SUNSTONE_ISA
