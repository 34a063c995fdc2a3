// SPDX-License-Identifier: Apache-2.0
// See shared_layout.h. A function that several kernels call is compiled once, so a variable that
// several kernels use has one offset in all of them; such variables come first. Variables of one
// kernel follow and may overlap those of other kernels. Dynamic shared memory starts after the
// largest kernel that uses it, also at one offset for all.
#include "compiler/kernels/shared_layout.h"

#include "base/error.h"

#include <llvm/IR/InstIterator.h>

#include <algorithm>

namespace sunstone::compiler {

namespace {

using FunctionSet = std::set<llvm::Function*>;

void addReachable(llvm::Function* function, const FunctionSet& addressTaken, FunctionSet& reached) {
    if (function->isDeclaration() || !reached.insert(function).second)
        return;
    for (llvm::Instruction& instruction : llvm::instructions(*function)) {
        auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction);
        if (!call)
            continue;
        if (llvm::Function* callee = call->getCalledFunction())
            addReachable(callee, addressTaken, reached);
        else if (!call->isInlineAsm())
            for (llvm::Function* target : addressTaken)
                addReachable(target, addressTaken, reached);
    }
}

uint64_t placeVariables(std::vector<SharedVariable*>& variables, uint64_t offset,
                        std::map<SharedVariable*, uint64_t>& places) {
    for (SharedVariable* shared : variables) {
        const uint64_t alignment = std::max(1u, shared->variable->alignment);
        offset = (offset + alignment - 1) / alignment * alignment;
        places[shared] = offset;
        offset += shared->variable->size;
    }
    return offset;
}

} // namespace

void limitBytes(KernelInfo& kernel, uint64_t bytes, const char* what) {
    if (bytes > kMostKernelBytes && kernel.unsupported.empty())
        kernel.unsupported =
            message(bytes, " bytes of ", what, " are more than the limit of ", kMostKernelBytes);
}

void describeThreads(Unit& unit, const std::vector<llvm::Function*>& functions,
                     std::vector<KernelInfo>& kernels) {
    FunctionSet addressTaken;
    for (llvm::Function& function : unit.module())
        if (!function.isDeclaration() && function.hasAddressTaken())
            addressTaken.insert(&function);

    std::map<SharedVariable*, std::vector<size_t>> usersOf;
    for (size_t i = 0; i < functions.size(); ++i) {
        if (!functions[i])
            continue;
        FunctionSet reached;
        addReachable(functions[i], addressTaken, reached);
        uint64_t localBytes = 0;
        for (llvm::Function* function : reached) {
            const auto facts = unit.facts().find(function);
            if (facts == unit.facts().end())
                continue;
            kernels[i].usesBarriers |= facts->second.barriers;
            kernels[i].usesWarpFunctions |= facts->second.warp;
            localBytes += facts->second.localBytes;
        }
        kernels[i].localBytes = uint32_t(localBytes);
        limitBytes(kernels[i], localBytes, "local memory");
        for (SharedVariable& shared : unit.shared())
            if (std::any_of(shared.users.begin(), shared.users.end(),
                            [&](llvm::Function* user) { return reached.count(user) != 0; }))
                usersOf[&shared].push_back(i);
    }

    std::map<SharedVariable*, uint64_t> places;
    std::vector<SharedVariable*> common;
    std::map<size_t, std::vector<SharedVariable*>> own;
    for (auto& [shared, users] : usersOf) {
        if (shared->dynamic)
            continue;
        if (users.size() == 1)
            own[users[0]].push_back(shared);
        else
            common.push_back(shared);
    }
    const uint64_t commonEnd = placeVariables(common, 0, places);
    uint64_t dynamicStart = 0;
    std::vector<bool> usesDynamic(functions.size(), false);
    for (auto& [shared, users] : usersOf)
        if (shared->dynamic)
            for (size_t user : users)
                usesDynamic[user] = true;
    for (size_t i = 0; i < functions.size(); ++i) {
        bool usesCommon = false;
        for (SharedVariable* shared : common)
            for (size_t user : usersOf[shared])
                usesCommon |= user == i;
        uint64_t end = usesCommon || own.count(i) || usesDynamic[i] ? commonEnd : 0;
        if (own.count(i))
            end = placeVariables(own[i], end, places);
        kernels[i].staticSharedBytes = uint32_t(end);
        limitBytes(kernels[i], end, "shared memory");
        if (usesDynamic[i])
            dynamicStart = std::max(dynamicStart, end);
    }
    dynamicStart = (dynamicStart + 15) / 16 * 16;
    for (size_t i = 0; i < functions.size(); ++i)
        if (usesDynamic[i]) {
            kernels[i].staticSharedBytes = uint32_t(dynamicStart);
            limitBytes(kernels[i], dynamicStart, "shared memory");
        }

    llvm::Type* word = llvm::Type::getInt64Ty(unit.context());
    for (SharedVariable& shared : unit.shared()) {
        const uint64_t offset = shared.dynamic ? dynamicStart : places[&shared];
        shared.placeholder->replaceAllUsesWith(llvm::ConstantExpr::getIntToPtr(
            llvm::ConstantInt::get(word, offset), shared.placeholder->getType()));
        shared.placeholder->eraseFromParent();
    }
}

} // namespace sunstone::compiler
