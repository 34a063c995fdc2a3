// SPDX-License-Identifier: Apache-2.0
// Replaces the `_optix_*` calls of programs by loads, stores and calls on RayState. Functions that
// reach such a call are inlined by then (markIntrinsicUsers), and operands that must be constants
// (payload slots, counts, types) are constants, or the program is at fault.
#pragma once

#include "compiler/optix7/intrinsics.h"
#include "compiler/optix7/payload.h"
#include "compiler/translate/unit.h"

namespace sunstone::compiler {

void lowerIntrinsics(Unit& unit, const ProgramPayloads& payloads);

} // namespace sunstone::compiler
