// SPDX-License-Identifier: Apache-2.0
#include "compiler/flavor.h"

#include "compiler/translate/unit.h"

#include <llvm/IR/InstIterator.h>

#include <set>

namespace sunstone::compiler {

namespace {

// Kernels have no intrinsics. Their module may also contain ray tracing programs, so the flavor
// knows the intrinsic prefixes of all generations and reports calls of them clearly.
class KernelFlavor final : public Flavor {
public:
    const char* name() const override { return "kernel"; }
    bool isKernels() const override { return true; }
    bool isIntrinsicName(std::string_view name) const override {
        return name.starts_with("_optix_") || name.starts_with("_rt_");
    }
    const Intrinsic* find(std::string_view) const override { return nullptr; }
    std::string launchIndex(char) const override { return {}; }
    std::string launchDimension(char) const override { return {}; }
    bool isProgramName(std::string_view) const override { return false; }
    std::optional<size_t> parameterAt(ProgramKind, size_t, size_t) const override { return {}; }
    void lower(Unit&, const ProgramPayloads&) const override {}
};

// Depth-first search for a cycle of calls among the functions that must be inlined.
class RecursionCheck {
public:
    RecursionCheck(Unit& unit, const std::set<llvm::Function*>& functions)
        : unit_(unit), functions_(functions) {}

    void visit(llvm::Function* function) {
        if (!functions_.count(function) || done_.count(function))
            return;
        if (!active_.insert(function).second) {
            const ptx::Function* source = unit_.facts()[function].function;
            failAt(ErrorCode::kInvalidPtx, source->location, "function \"", source->name,
                   "\" calls OptiX device functions and is recursive; such functions are inlined "
                   "into the program and must not be");
        }
        for (llvm::Instruction& instruction : llvm::instructions(*function))
            if (auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction))
                if (call->getCalledFunction())
                    visit(call->getCalledFunction());
        active_.erase(function);
        done_.insert(function);
    }

private:
    Unit& unit_;
    const std::set<llvm::Function*>& functions_;
    std::set<llvm::Function*> active_, done_;
};

// Whether calls among these functions lead from one back to it.
bool callsItself(llvm::Function* function, const std::set<llvm::Function*>& functions) {
    std::set<llvm::Function*> seen;
    std::vector<llvm::Function*> queue = {function};
    while (!queue.empty()) {
        llvm::Function* caller = queue.back();
        queue.pop_back();
        for (llvm::Instruction& instruction : llvm::instructions(*caller)) {
            auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction);
            llvm::Function* callee = call ? call->getCalledFunction() : nullptr;
            if (callee == function)
                return true;
            if (callee && functions.count(callee) && seen.insert(callee).second)
                queue.push_back(callee);
        }
    }
    return false;
}

} // namespace

const Flavor& kernelFlavor() {
    static const KernelFlavor flavor;
    return flavor;
}

void markIntrinsicUsers(Unit& unit) {
    std::set<llvm::Function*> users;
    std::vector<llvm::Function*> queue;
    for (llvm::Function& function : unit.module())
        if (unit.intrinsicOf(&function))
            queue.push_back(&function);
    while (!queue.empty()) {
        llvm::Function* callee = queue.back();
        queue.pop_back();
        for (llvm::User* user : callee->users()) {
            auto* call = llvm::dyn_cast<llvm::CallInst>(user);
            if (!call || call->getCalledOperand() != callee)
                continue;
            if (users.insert(call->getFunction()).second)
                queue.push_back(call->getFunction());
        }
    }
    if (unit.flavor().allowsRecursion()) {
        for (llvm::Function* function : users)
            if (callsItself(function, users)) {
                function->addFnAttr(kRecursive);
                function->addFnAttr(llvm::Attribute::NoInline);
            }
    } else {
        RecursionCheck check(unit, users);
        for (llvm::Function* function : users)
            check.visit(function);
    }
    for (llvm::Function* function : users)
        if (!function->hasFnAttribute(kRecursive) &&
            (!unit.kinds().count(function) || !function->use_empty()))
            function->addFnAttr(llvm::Attribute::AlwaysInline);
}

} // namespace sunstone::compiler
