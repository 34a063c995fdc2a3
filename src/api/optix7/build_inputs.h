// SPDX-License-Identifier: Apache-2.0
// Checks and translates the API's build inputs (OptiX 7.4, sections 5.3, 5.6, 5.8 to 5.10).
#pragma once

#include "api/optix7/client_structs.h"
#include "api/optix7/shell.h"
#include "engine/accel.h"

namespace sunstone::optix7 {

// Which parts of the inputs are checked: the memory-usage query must not need valid buffers.
enum class InputCheck { kShape, kBuffers };

// Throws an Error naming the field, prefixed with `where`, if the level or format is invalid.
void checkMicromapKind(unsigned level, OptixOpacityMicromapFormat format, const std::string& where);

// Checks the options; throws an Error naming the field.
bvh::BuildOptions checkBuildOptions(const OptixAccelBuildOptions* options, const ApiCall& call);

// The build flags, without PREFER_FAST_TRACE and PREFER_FAST_BUILD if they contradict one another.
unsigned withOnePreference(unsigned buildFlags);

// Checks and copies `count` build inputs, with buffers for `keys` motion keys; throws an Error naming
// input and field.
std::shared_ptr<engine::AccelInputs> checkBuildInputs(const BuildInputs& inputs, unsigned count,
                                                      unsigned keys, InputCheck check,
                                                      const ApiCall& call);

} // namespace sunstone::optix7
