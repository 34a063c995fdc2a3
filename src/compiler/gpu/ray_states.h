// SPDX-License-Identifier: Apache-2.0
// The states of a lane's rays in the kernel of devlib/gpu/nested.h are arrays, indexed by depth, so
// LLVM keeps them in memory as a whole. These passes consider each field for all depths together.
#pragma once

#include "compiler/gpu/state_uses.h"

#include <optional>

namespace sunstone::compiler {

// `states`: arrays of RayState in an optimised kernel. If every ray gets the same value (the
// launch, a mask, a stride), the value replaces the loads. Stores that no load reads are removed.
// Changes nothing if the arrays' addresses have other uses. Returns whether it changed the kernel.
bool foldRayStates(const StateUses::Arrays& states);

// Changes the layout of the states: a state then has only the fields that are loaded, one after
// another. Returns the bytes of a state, a multiple of kStateAlignment. If the arrays' addresses
// have unknown uses, changes nothing and returns none. The caller replaces the arrays by memory of
// that size.
constexpr uint64_t kStateAlignment = 32; // a sector of the caches
std::optional<uint64_t> packRayStates(const StateUses::Arrays& states);

} // namespace sunstone::compiler
