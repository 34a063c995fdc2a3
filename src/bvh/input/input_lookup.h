// SPDX-License-Identifier: Apache-2.0
// Finds the build input that an SBT index of a structure belongs to.
#pragma once

#include "bvh/layout.h"

namespace sunstone::bvh {

// The input with this index (optixGetSbtGASIndex); null if no input has it.
inline const InputRecord* inputWithSbtIndex(const BlockHeader& header, uint32_t sbtGasIndex) {
    const auto* inputs = reinterpret_cast<const InputRecord*>(
        reinterpret_cast<const uint8_t*>(&header) + header.inputsOffset);
    for (uint32_t i = 0; i < header.numInputs; ++i)
        if (sbtGasIndex - inputs[i].firstSbtIndex < inputs[i].numSbtRecords)
            return &inputs[i];
    return nullptr;
}

// Whether the curves of an input have flat end caps: the lowest bit of the word that
// shape_build.cpp stores.
inline bool hasEndcaps(const InputRecord& curves) {
    return curves.formats & 1;
}

} // namespace sunstone::bvh
