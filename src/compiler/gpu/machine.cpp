// SPDX-License-Identifier: Apache-2.0
// See gpu/machine.h.
#include "compiler/gpu/machine.h"

#include "base/error.h"
#include "compiler/gpu/header.h"
#include "compiler/passes/optimizer.h"
#include "compiler/translate/unit.h"

#include <llvm/IR/LegacyPassManager.h>
#include <llvm/MC/TargetRegistry.h>
#include <llvm/Passes/PassBuilder.h>
#include <llvm/Support/TargetSelect.h>

// LLVM declares these in a header that lists all targets it was built with.
extern "C" void LLVMInitializeNVPTXTargetInfo();
extern "C" void LLVMInitializeNVPTXTarget();
extern "C" void LLVMInitializeNVPTXTargetMC();
extern "C" void LLVMInitializeNVPTXAsmPrinter();

namespace sunstone::compiler {

std::unique_ptr<llvm::TargetMachine> createGpuMachine(const GpuTarget& target) {
    static const bool initialized = [] {
        LLVMInitializeNVPTXTargetInfo();
        LLVMInitializeNVPTXTarget();
        LLVMInitializeNVPTXTargetMC();
        LLVMInitializeNVPTXAsmPrinter();
        return true;
    }();
    (void)initialized;
    const std::string triple = "nvptx64-nvidia-cuda";
    std::string error;
    const llvm::Target* found = llvm::TargetRegistry::lookupTarget(triple, error);
    if (!found)
        fail(ErrorCode::kInternal, "no code generator for ", triple, ": ", error);
    const GpuHeader header = plainHeader(target);
    llvm::TargetOptions options;
    options.AllowFPOpFusion = llvm::FPOpFusion::Strict;
    return std::unique_ptr<llvm::TargetMachine>(found->createTargetMachine(
        triple, header.target, message("+ptx", header.version), options, llvm::Reloc::PIC_,
        llvm::CodeModel::Small, llvm::CodeGenOptLevel::Default, false));
}

namespace {

// LLVM's optimiser.
struct Pipeline {
    explicit Pipeline(llvm::TargetMachine& machine) : builder(&machine, tuning()) {
        machine.registerPassBuilderCallbacks(builder);
        builder.registerModuleAnalyses(modules);
        builder.registerCGSCCAnalyses(components);
        builder.registerFunctionAnalyses(functions);
        builder.registerLoopAnalyses(loops);
        builder.crossRegisterProxies(loops, functions, components, modules);
    }
    static llvm::PipelineTuningOptions tuning() {
        llvm::PipelineTuningOptions tuning;
        tuning.LoopVectorization = false;
        tuning.SLPVectorization = false;
        tuning.MergeFunctions = false;
        return tuning;
    }

    llvm::PassBuilder builder;
    llvm::LoopAnalysisManager loops;
    llvm::FunctionAnalysisManager functions;
    llvm::CGSCCAnalysisManager components;
    llvm::ModuleAnalysisManager modules;
};

// Programs come from an optimising compiler, the run-time is optimised when it is built, and the
// driver's compiler optimises again. With O3 the pipelines of 33 programs take 1.17 times as long
// to make as with O1, and their frames 1.006 times as long (docs/notes/programs-gpu.md).
const llvm::OptimizationLevel& levelOf(GpuEffort effort) {
    return effort == GpuEffort::kMuch ? llvm::OptimizationLevel::O3 : llvm::OptimizationLevel::O1;
}

} // namespace

void optimizeForGpu(llvm::Module& module, llvm::TargetMachine& machine, GpuEffort effort) {
    keepNullAccesses(module);
    Pipeline pipeline(machine);
    pipeline.builder.buildPerModuleDefaultPipeline(levelOf(effort)).run(module, pipeline.modules);
}

void simplifyForGpu(llvm::Function& function, llvm::TargetMachine& machine, GpuEffort effort) {
    keepNullAccesses(*function.getParent());
    Pipeline pipeline(machine);
    pipeline.builder
        .buildFunctionSimplificationPipeline(levelOf(effort), llvm::ThinOrFullLTOPhase::None)
        .run(function, pipeline.functions);
}

std::string emitGpuText(llvm::Module& module, llvm::TargetMachine& machine) {
    llvm::SmallVector<char, 0> text;
    llvm::raw_svector_ostream stream(text);
    llvm::legacy::PassManager passes;
    if (machine.addPassesToEmitFile(passes, stream, nullptr, llvm::CodeGenFileType::AssemblyFile,
                                    true))
        fail(ErrorCode::kInternal, "the code generator cannot write PTX");
    passes.run(module);
    return std::string(text.begin(), text.end());
}

} // namespace sunstone::compiler
