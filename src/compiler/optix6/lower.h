// SPDX-License-Identifier: Apache-2.0
// Replaces the `_rt_*` calls of classic programs, and the addresses of their variables, by loads,
// stores and calls on RayState and devlib::ClassicLaunch.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler::optix6 {

void lowerPrograms(Unit& unit);

} // namespace sunstone::compiler::optix6
