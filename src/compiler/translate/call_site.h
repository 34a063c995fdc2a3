// SPDX-License-Identifier: Apache-2.0
// The origin of an `_optix_*` call, kept when inlining moves it into other functions: the line in
// the PTX for messages, the place in the program's source for exceptions, and the module for its
// payload types.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

void setCallSite(Unit& unit, llvm::CallInst& call, const FunctionFacts& caller,
                 const ptx::Instruction& instruction, const std::string& source);

struct CallSite {
    uint32_t line = 0;                  // in the PTX; 0: unknown
    llvm::StringRef source;             // "file:line:column"; empty: unknown
    const ModuleRules* rules = nullptr; // never null from callSite
};
CallSite callSite(Unit& unit, const llvm::Instruction& call);

// "file:line:column" of an instruction, or empty if the module has no line information. In inlined
// functions of the device API's headers it is the last earlier place outside them: the line of the
// program with the call.
std::string sourcePlace(Unit& unit, const FunctionFacts& caller,
                        const ptx::Instruction& instruction);

// ", in FUNCTION, at FILE:LINE:COLUMN", as far as known.
std::string placeIn(Unit& unit, const FunctionFacts& function, const ptx::Instruction& instruction);

} // namespace sunstone::compiler
