// SPDX-License-Identifier: Apache-2.0
// Callables that trace. A program is cut at its own traces only (resumable.h), so that a callable
// would keep its place, and its warp, until its ray has ended. Such callables are therefore inlined
// into the programs that call them.
#pragma once

#include "compiler/translate/unit.h"

#include <string>

namespace sunstone::compiler {

// Inlines the callables that trace into ray generation, closest-hit and miss programs with lowered
// calls, in place of calls by address: behind a comparison of the address with each callable's. The
// callables lose their bodies. Does nothing if other functions may call them, if they call
// functions by address, if a call may reach them with other types, or if the programs would become
// too large. Returns a log line, or nothing.
std::string inlineTracingCallables(Unit& unit);

} // namespace sunstone::compiler
