// SPDX-License-Identifier: Apache-2.0
// Which functions a call by address may reach: calls of a dispatcher reach its programs, all others
// the callables.
#pragma once

#include <llvm/IR/Function.h>
#include <llvm/IR/InstrTypes.h>

namespace sunstone::compiler {

// Marks programs that a dispatcher calls by address, and its call.
constexpr const char* kPartByAddress = "sunstone-part";

// `function`: one whose address is taken. `call`: one by address.
inline bool mayCall(const llvm::CallBase& call, const llvm::Function& function) {
    return call.hasFnAttr(kPartByAddress) == function.hasFnAttribute(kPartByAddress);
}

} // namespace sunstone::compiler
