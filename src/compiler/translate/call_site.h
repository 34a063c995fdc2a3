// SPDX-License-Identifier: Apache-2.0
// What the call of an `_optix_*` function has to remember of where it stood, as inlining carries it
// into other functions: the line in the PTX for messages, the place in the program's source for
// exceptions, and the module, whose payload types it names.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

void setCallSite(Unit& unit, llvm::CallInst& call, const FunctionFacts& caller,
                 const ptx::Instruction& instruction, const std::string& source);

struct CallSite {
    uint32_t line = 0;       // in the PTX; 0: not known
    llvm::StringRef source;  // "file:line:column"; empty: not known
    const ModuleRules* rules = nullptr; // never null from callSite
};
CallSite callSite(Unit& unit, const llvm::Instruction& call);

// "file:line:column" of an instruction, or empty if the module has no line information. Where that is
// in a header of the device API, whose functions are inlined, it is the last place before it that is
// not: the line of the program with the call.
std::string sourcePlace(Unit& unit, const FunctionFacts& caller,
                        const ptx::Instruction& instruction);

} // namespace sunstone::compiler
