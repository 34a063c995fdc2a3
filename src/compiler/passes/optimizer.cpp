// SPDX-License-Identifier: Apache-2.0
// See optimizer.h.
#include "compiler/passes/optimizer.h"

#include "base/config.h"
#include "base/log.h"
#include "compiler/passes/check_accesses.h"
#include "compiler/passes/passes.h"

#include <llvm/Passes/PassBuilder.h>
#include <llvm/Support/FileSystem.h>
#include <llvm/Support/raw_ostream.h>
#include <llvm/Transforms/IPO/AlwaysInliner.h>
#include <llvm/Transforms/IPO/GlobalDCE.h>
#include <llvm/Transforms/IPO/Inliner.h>
#include <llvm/Transforms/InstCombine/InstCombine.h>
#include <llvm/Transforms/Scalar/ADCE.h>
#include <llvm/Transforms/Scalar/CorrelatedValuePropagation.h>
#include <llvm/Transforms/Scalar/DeadStoreElimination.h>
#include <llvm/Transforms/Scalar/EarlyCSE.h>
#include <llvm/Transforms/Scalar/GVN.h>
#include <llvm/Transforms/Scalar/IndVarSimplify.h>
#include <llvm/Transforms/Scalar/JumpThreading.h>
#include <llvm/Transforms/Scalar/LICM.h>
#include <llvm/Transforms/Scalar/LoopDeletion.h>
#include <llvm/Transforms/Scalar/LoopPassManager.h>
#include <llvm/Transforms/Scalar/LoopRotation.h>
#include <llvm/Transforms/Scalar/LoopUnrollPass.h>
#include <llvm/Transforms/Scalar/SROA.h>
#include <llvm/Transforms/Scalar/SimplifyCFG.h>
#include <llvm/Transforms/Utils/FixIrreducible.h>
#include <llvm/Transforms/Utils/LoopSimplify.h>
#include <llvm/Transforms/Utils/LowerSwitch.h>
#include <llvm/Transforms/Utils/UnifyFunctionExitNodes.h>

#include <atomic>

namespace sunstone::compiler {

namespace {

class UnlessManyLoops : public llvm::PassInfoMixin<UnlessManyLoops> {
public:
    explicit UnlessManyLoops(llvm::LoopPassManager passes)
        : passes_(llvm::createFunctionToLoopPassAdaptor(std::move(passes), false, false)) {}
    llvm::PreservedAnalyses run(llvm::Function& function, llvm::FunctionAnalysisManager& analyses) {
        const auto& loops = analyses.getResult<llvm::LoopAnalysis>(function);
        return loops.getLoopsInPreorder().size() > kManyLoops ? llvm::PreservedAnalyses::all()
                                                              : passes_.run(function, analyses);
    }

private:
    llvm::FunctionToLoopPassAdaptor passes_;
};

} // namespace

struct Optimizer::Managers {
    llvm::LoopAnalysisManager loops;
    llvm::FunctionAnalysisManager functions;
    llvm::CGSCCAnalysisManager components;
    llvm::ModuleAnalysisManager modules;
};

Optimizer::Optimizer(Unit& unit, llvm::TargetMachine& machine, OptLevel level)
    : unit_(unit), level_(level), managers_(std::make_unique<Managers>()) {
    static std::atomic<unsigned> count{0};
    number_ = ++count;
    llvm::PipelineTuningOptions tuning;
    tuning.LoopVectorization = false;
    tuning.SLPVectorization = false;
    llvm::PassBuilder builder(&machine, tuning);
    builder.registerModuleAnalyses(managers_->modules);
    builder.registerCGSCCAnalyses(managers_->components);
    builder.registerFunctionAnalyses(managers_->functions);
    builder.registerLoopAnalyses(managers_->loops);
    builder.crossRegisterProxies(managers_->loops, managers_->functions, managers_->components,
                                 managers_->modules);
}

Optimizer::~Optimizer() = default;

void Optimizer::dump(const char* stage) {
    const std::string& folder = config(Setting::kDump);
    if (folder.empty())
        return;
    char name[64];
    std::snprintf(name, sizeof name, "/%03u_%02u_%s.ll", number_, stage_++, stage);
    std::error_code error;
    llvm::raw_fd_ostream out(folder + name, error, llvm::sys::fs::OF_Text);
    if (error) {
        logOnce(LogLevel::kWarning, "compiler",
                "cannot write to SUNSTONE_DUMP folder " + folder + ": " + error.message());
        return;
    }
    unit_.module().print(out, nullptr);
}

void keepNullAccesses(llvm::Module& module) {
    for (llvm::Function& function : module)
        if (!function.isDeclaration())
            function.addFnAttr(llvm::Attribute::NullPointerIsValid);
}

void Optimizer::begin() {
    managers_->loops.clear();
    managers_->functions.clear();
    managers_->components.clear();
    managers_->modules.clear();
    keepNullAccesses(unit_.module());
}

void Optimizer::promote() {
    begin();
    llvm::FunctionPassManager functions;
    functions.addPass(RegisterPass());
    functions.addPass(llvm::SROAPass(llvm::SROAOptions::PreserveCFG));
    functions.addPass(PointerPass());
    functions.addPass(llvm::SROAPass(llvm::SROAOptions::PreserveCFG));
    llvm::ModulePassManager passes;
    if (checks("memory")) { // before loads are merged, which loses marks
        passes.addPass(llvm::createModuleToFunctionPassAdaptor(std::move(functions)));
        passes.addPass(CheckAccessesPass(unit_.flavor().isKernels()));
        functions = llvm::FunctionPassManager();
    }
    functions.addPass(llvm::EarlyCSEPass(false));
    functions.addPass(llvm::SimplifyCFGPass());
    passes.addPass(llvm::createModuleToFunctionPassAdaptor(std::move(functions)));
    passes.run(unit_.module(), managers_->modules);
    dump("promoted");
}

void Optimizer::forwardStores() {
    begin();
    llvm::ModulePassManager passes;
    passes.addPass(llvm::createModuleToFunctionPassAdaptor(llvm::EarlyCSEPass(true)));
    passes.run(unit_.module(), managers_->modules);
    dump("forwarded");
}

void Optimizer::inlineAlways() {
    begin();
    llvm::ModulePassManager passes;
    passes.addPass(llvm::AlwaysInlinerPass(false));
    passes.addPass(llvm::GlobalDCEPass());
    passes.run(unit_.module(), managers_->modules);
    dump("inlined");
}

void Optimizer::optimize() {
    if (level_ == OptLevel::k0)
        return dump("optimized");
    begin();
    llvm::ModulePassManager passes;
    llvm::InlineParams inlining = llvm::getInlineParams(level_ == OptLevel::k1 ? 50 : 225);
    llvm::ModuleInlinerWrapperPass inliner(inlining);
    llvm::FunctionPassManager early;
    early.addPass(llvm::SROAPass(llvm::SROAOptions::ModifyCFG));
    early.addPass(llvm::EarlyCSEPass(true));
    early.addPass(llvm::InstCombinePass());
    early.addPass(llvm::SimplifyCFGPass());
    inliner.getPM().addPass(llvm::createCGSCCToFunctionPassAdaptor(std::move(early)));
    passes.addPass(std::move(inliner));
    passes.addPass(llvm::GlobalDCEPass());

    llvm::FunctionPassManager main;
    llvm::LoopPassManager loops;
    loops.addPass(llvm::LoopRotatePass());
    loops.addPass(llvm::LICMPass(llvm::LICMOptions()));
    llvm::LoopPassManager loopsLate;
    // Lanes of kernels compute with vectors, and 64-bit numbers take twice as many vectors.
    const bool widensIndices = !unit_.flavor().isKernels();
    loopsLate.addPass(llvm::IndVarSimplifyPass(widensIndices));
    loopsLate.addPass(llvm::LoopDeletionPass());
    if (level_ >= OptLevel::k2)
        loopsLate.addPass(llvm::LoopFullUnrollPass(2));
    main.addPass(llvm::createFunctionToLoopPassAdaptor(std::move(loops), true, false));
    if (level_ >= OptLevel::k2) {
        main.addPass(UnlessManyLoops(std::move(loopsLate)));
        main.addPass(PointerPass()); // unrolling makes indices constant
        main.addPass(llvm::SROAPass(llvm::SROAOptions::ModifyCFG));
    }
    main.addPass(llvm::GVNPass());
    main.addPass(llvm::DSEPass());
    main.addPass(llvm::InstCombinePass());
    main.addPass(llvm::SimplifyCFGPass(llvm::SimplifyCFGOptions()
                                           .convertSwitchRangeToICmp(true)
                                           .hoistCommonInsts(true)
                                           .sinkCommonInsts(true)));
    main.addPass(llvm::ADCEPass());
    passes.addPass(llvm::createModuleToFunctionPassAdaptor(std::move(main)));
    passes.run(unit_.module(), managers_->modules);
    dump("optimized");
}

void Optimizer::simplifyControl(llvm::Function& function) {
    llvm::FunctionPassManager passes;
    passes.addPass(llvm::LowerSwitchPass());
    passes.addPass(llvm::UnifyFunctionExitNodesPass());
    passes.addPass(llvm::FixIrreduciblePass());
    passes.addPass(llvm::LowerSwitchPass());
    passes.addPass(llvm::LoopSimplifyPass());
    passes.run(function, managers_->functions);
}

void Optimizer::finishLockstep(llvm::Function& function, bool isLong) {
    llvm::FunctionPassManager passes;
    passes.addPass(llvm::SROAPass(llvm::SROAOptions::PreserveCFG));
    passes.addPass(llvm::EarlyCSEPass(false));
    passes.addPass(llvm::InstCombinePass());
    passes.addPass(llvm::SimplifyCFGPass());
    if (!isLong) {
        llvm::LoopPassManager loops;
        loops.addPass(llvm::LICMPass(llvm::LICMOptions()));
        passes.addPass(llvm::createFunctionToLoopPassAdaptor(std::move(loops), true, false));
        passes.addPass(llvm::EarlyCSEPass(true));
        passes.addPass(llvm::InstCombinePass());
    }
    passes.addPass(llvm::ADCEPass());
    passes.run(function, managers_->functions);
}

void Optimizer::forget(llvm::Function& function) {
    managers_->functions.clear(function, function.getName());
}

} // namespace sunstone::compiler
