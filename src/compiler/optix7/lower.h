// SPDX-License-Identifier: Apache-2.0
// Replaces the `_optix_*` calls of programs by loads, stores and calls on RayState. Functions with
// such calls, perhaps through others, have been inlined before (markIntrinsicUsers). Operands that
// must be constant (payload slots, counts, types) are constants, or the program is invalid.
#pragma once

#include "compiler/optix7/intrinsics.h"
#include "compiler/optix7/payload.h"
#include "compiler/translate/unit.h"

namespace sunstone::compiler {

void lowerIntrinsics(Unit& unit, const ProgramPayloads& payloads);

} // namespace sunstone::compiler
