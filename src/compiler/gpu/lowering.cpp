// SPDX-License-Identifier: Apache-2.0
// See lowering.h.
#include "compiler/gpu/lowering.h"

#include "compiler/passes/flush.h"

#include <llvm/IR/InlineAsm.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/Transforms/Utils/Cloning.h>

#include <map>

namespace sunstone::compiler {

namespace {

// The function that the lowering calls for optixReportIntersection, and the run-time's function.
constexpr const char *kReportHere = "sunstone_gpu_report", *kReport = "sunstone_gpu_reportTo";

llvm::Function* withCandidates(Unit& unit, llvm::Function& program, llvm::Function* report) {
    llvm::IRBuilder<> builder(unit.context());
    llvm::Type *pointer = builder.getPtrTy(), *word = builder.getInt32Ty();
    auto* function = llvm::Function::Create(
        llvm::FunctionType::get(program.getReturnType(), {pointer, pointer}, false),
        program.getLinkage(), program.getName() + ".report", unit.module());
    llvm::ValueToValueMapTy map;
    map[program.getArg(0)] = function->getArg(0);
    llvm::SmallVector<llvm::ReturnInst*> returns;
    llvm::CloneFunctionInto(function, &program, map,
                            llvm::CloneFunctionChangeType::LocalChangesOnly, returns);
    auto* type =
        llvm::FunctionType::get(word, {pointer, pointer, builder.getFloatTy(), word}, false);
    for (llvm::Instruction& each : llvm::make_early_inc_range(llvm::instructions(*function))) {
        auto* call = llvm::dyn_cast<llvm::CallInst>(&each);
        if (!call || !report || call->getCalledOperand() != report)
            continue;
        builder.SetInsertPoint(call);
        call->replaceAllUsesWith(
            builder.CreateCall(unit.module().getOrInsertFunction(kReport, type),
                               {call->getArgOperand(0), function->getArg(1), call->getArgOperand(1),
                                call->getArgOperand(2)}));
        call->eraseFromParent();
    }
    return function;
}

} // namespace

void passCandidates(Unit& unit, std::vector<llvm::Function*>& programs) {
    llvm::Function* report = unit.module().getFunction(kReportHere);
    std::map<llvm::Function*, llvm::Function*> changed;
    for (llvm::Function*& program : programs) {
        if (unit.kinds()[program] != ProgramKind::kIntersection)
            continue;
        llvm::Function*& with = changed[program];
        if (!with)
            with = withCandidates(unit, *program, report);
        program = with;
    }
    for (const auto& [program, with] : changed) {
        unit.kinds().erase(program);
        unit.kinds()[with] = ProgramKind::kIntersection;
        program->deleteBody(); // its address may still be in use
        if (program->use_empty())
            program->eraseFromParent();
    }
}

void lowerFlushes(llvm::Module& module) {
    llvm::Function* marker = module.getFunction(kFlushName);
    if (!marker)
        return;
    for (llvm::User* user : llvm::make_early_inc_range(marker->users())) {
        auto* call = llvm::cast<llvm::CallInst>(user);
        auto* type = llvm::FunctionType::get(call->getType(), {call->getType()}, false);
        auto* code =
            llvm::InlineAsm::get(type, "add.rn.ftz.f32 $0, $1, 0f80000000;", "=f,f", false);
        llvm::CallInst* flushed =
            llvm::CallInst::Create(type, code, {call->getArgOperand(0)}, "", call->getIterator());
        flushed->setMemoryEffects(llvm::MemoryEffects::none());
        call->replaceAllUsesWith(flushed);
        call->eraseFromParent();
    }
    marker->eraseFromParent();
}

} // namespace sunstone::compiler
