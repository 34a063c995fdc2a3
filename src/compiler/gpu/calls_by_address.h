// SPDX-License-Identifier: Apache-2.0
// The possible callees of a call by address: the dispatcher's programs for a call of a dispatcher,
// the callables for all other calls.
#pragma once

#include <llvm/IR/Function.h>
#include <llvm/IR/InstrTypes.h>

namespace sunstone::compiler {

// Attribute of programs that a dispatcher calls by address, and of its call.
constexpr const char* kPartByAddress = "sunstone-part";

// `function`: a function whose address is taken. `call`: a call by address.
inline bool mayCall(const llvm::CallBase& call, const llvm::Function& function) {
    return call.hasFnAttr(kPartByAddress) == function.hasFnAttribute(kPartByAddress);
}

} // namespace sunstone::compiler
