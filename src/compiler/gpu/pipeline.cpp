// SPDX-License-Identifier: Apache-2.0
// See gpu/pipeline.h. GpuBuild orders the steps; each step has a file of its own.
#include "compiler/gpu/pipeline.h"

#include "base/config.h"
#include "base/error.h"
#include "compiler/compile_steps.h"
#include "compiler/gpu/dispatchers.h"
#include "compiler/gpu/header.h"
#include "compiler/gpu/launch_kernel.h"
#include "compiler/gpu/link.h"
#include "compiler/gpu/lowering.h"
#include "compiler/gpu/machine.h"
#include "compiler/gpu/programs.h"
#include "compiler/passes/bound_values.h"
#include "compiler/passes/optimizer.h"
#include "compiler/passes/stack_checks.h"

#include <llvm/IR/DebugInfo.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/Operator.h>
#include <llvm/IR/Verifier.h>

#include <algorithm>
#include <optional>

namespace sunstone::compiler {

namespace {

const Flavor& flavorOf(const GpuPipelineRequest& request) {
    return request.pipeline.flavor ? *request.pipeline.flavor : optix7Flavor();
}

std::vector<const ptx::Module*> modulesOf(const GpuPipelineRequest& request) {
    std::vector<const ptx::Module*> modules;
    for (const ProgramRequest& program : request.pipeline.programs)
        if (const ptx::Module* tree = &program.module->tree();
            std::find(modules.begin(), modules.end(), tree) == modules.end())
            modules.push_back(tree);
    return modules;
}

// Whether all uses of an address in an optimised module read.
bool isOnlyRead(const llvm::Value& address, llvm::SmallPtrSetImpl<const llvm::User*>& seen) {
    return llvm::all_of(address.uses(), [&](const llvm::Use& use) {
        const llvm::User* const user = use.getUser();
        if (llvm::isa<llvm::GEPOperator, llvm::AddrSpaceCastOperator, llvm::PHINode,
                      llvm::SelectInst, llvm::ConstantExpr>(user))
            return !seen.insert(user).second || isOnlyRead(*user, seen);
        if (const auto* call = llvm::dyn_cast<llvm::CallBase>(user);
            call && call->isArgOperand(&use)) {
            const unsigned argument = call->getArgOperandNo(&use);
            const llvm::Function* const callee = call->getCalledFunction();
            return (callee && callee->getName() == "vprintf") || // texts
                   (call->onlyReadsMemory(argument) && call->doesNotCapture(argument));
        }
        return llvm::isa<llvm::LoadInst, llvm::ICmpInst>(user);
    });
}

// Whether programs have variables in global memory. Tables of constants are none.
bool hasState(const llvm::Module& module) {
    constexpr unsigned kShared = 3; // address space
    return llvm::any_of(module.globals(), [](const llvm::GlobalVariable& variable) {
        llvm::SmallPtrSet<const llvm::User*, 8> seen;
        return !variable.isConstant() && variable.getAddressSpace() != kShared &&
               !isOnlyRead(variable, seen);
    });
}

void refuseUnresolved(const llvm::Module& module) {
    // Functions that the driver provides to device code.
    constexpr llvm::StringLiteral kProvided[] = {"vprintf", "malloc", "free"};
    std::string missing;
    for (const llvm::Function& function : module)
        if (function.isDeclaration() && !function.isIntrinsic() && !function.use_empty() &&
            !llvm::is_contained(kProvided, function.getName()) &&
            !isDispatcher(function.getName()) && // of another part
            !LaunchKernel::isOfKernel(function.getName()))
            missing += (missing.empty() ? "" : ", ") + function.getName().str();
    if (!missing.empty())
        fail(ErrorCode::kNotSupported,
             "programs need what the GPU back end does not have yet: ", missing);
}

// Whether a function that is called by address calls another by address, or one of the driver. The
// linker computes a kernel's stack and does not know the frames of such calls.
bool nestsCallsByAddress(const llvm::Module& module) {
    std::vector<const llvm::Function*> reached;
    for (const llvm::Function& function : module)
        if (!function.isDeclaration() && function.hasAddressTaken())
            reached.push_back(&function);
    for (size_t i = 0; i < reached.size(); ++i)
        for (const llvm::Instruction& instruction : llvm::instructions(*reached[i])) {
            const auto* call = llvm::dyn_cast<llvm::CallBase>(&instruction);
            if (!call || call->isInlineAsm())
                continue;
            const llvm::Function* const callee = call->getCalledFunction();
            if (!callee || (callee->isDeclaration() && !callee->isIntrinsic()))
                return true;
            if (!callee->isIntrinsic() && !llvm::is_contained(reached, callee))
                reached.push_back(callee);
        }
    return false;
}

class GpuBuild {
public:
    explicit GpuBuild(const GpuPipelineRequest& request)
        : request_(request), times_("pipeline for a GPU"), modules_(modulesOf(request)),
          machine_(createGpuMachine(request.target)),
          unit_(flavorOf(request), request.pipeline.rules, modules_), programs_(request, unit_),
          kernel_(request, unit_, *machine_, programs_) {
        unit_.setTarget(Target::kGpu);
        unit_.module().setDataLayout(machine_->createDataLayout());
        unit_.module().setTargetTriple(machine_->getTargetTriple().str());
        OptLevel level = OptLevel::k0;
        for (const ProgramRequest& program : request.pipeline.programs) {
            unit_.setOptions(program.module->tree(), program.moduleRules, DebugLevel::kMinimal);
            level = std::max(level, program.optLevel);
        }
        optimizer_.emplace(unit_, *machine_, level);
    }

    GpuCode run() {
        const GpuHeader header = translate();
        lower();
        times_.step("translate");
        code_.feedback += kernel_.choose();
        if (kernel_.refuses())
            return std::move(code_);
        if (kernel_.isApart())
            code_.frameBytes = kernel_.cuts().frameBytes;
        code_.takesTurns = kernel_.takesTurns();
        code_.recurses = kernel_.recurses();
        code_.walksInStep = kernel_.walksInStep();
        optimizer_->dump("cut");
        verify(unit_, "cutting");
        times_.step("cut");
        link();
        optimizeForGpu(unit_.module(), *machine_, kernel_.effort());
        kernel_.foldStates();
        code_.laneMemoryBytes = kernel_.placeStates();
        kernel_.defineConstants();
        optimizer_->dump("optimized");
        refuseUnresolved(unit_.module());
        if (kernel_.isApart() && nestsCallsByAddress(unit_.module())) {
            code_.feedback = "callables call functions by address, or functions of the driver";
            return std::move(code_);
        }
        times_.step("optimize");
        code_.ptx = withHeader(emitGpuText(unit_.module(), *machine_), header);
        times_.step("generate");
        if (request_.part == GpuPart::kWhole) { // else the linker adds the frames of all parts
            const GpuCalls calls(unit_.module(), code_.ptx);
            code_.stack = calls.stack();
            code_.calls = calls.text();
        }
        code_.hasState = hasState(unit_.module());
        return std::move(code_);
    }

private:
    // Returns the header that the text needs.
    GpuHeader translate() {
        programs_.declare();
        unit_.translateQueue();
        const GpuHeader header = headerOfText();
        optimizer_->dump("translated");
        verify(unit_, "translation");
        optimizer_->promote();
        markIntrinsicUsers(unit_);
        optimizer_->inlineAlways();
        optimizer_->promote();
        optimizer_->forwardStores();
        return header;
    }

    void lower() {
        programs_.copyShared();
        bindValues();
        hasLongIntersections_ = programs_.haveLongIntersections();
        unit_.flavor().lower(unit_, programs_.payloads());
        passCandidates(unit_, programs_.functions());
        lowerFlushes(unit_.module());
        if (request_.pipeline.rules.exceptionFlags & devlib::kFlagStackOverflow)
            addStackChecks(unit_);
        llvm::StripDebugInfo(unit_.module());
    }

    void link() {
        if (kernel_.isApart())
            declareDispatchers(unit_.module(), request_.part);
        else
            kernel_.make();
        auto constants = request_.constants;
        constants.emplace_back("sunstone_gpu_inStep", kernel_.walksInStep());
        constants.emplace_back("sunstone_gpu_longIntersections", hasLongIntersections_);
        linkGpuRuntime(unit_.module(), *machine_, request_.runtime, constants);
        if (request_.part != GpuPart::kKernel) {
            defineDispatchers(unit_.module(), request_, programs_.functions(), kernel_.cuts());
            defineGroupFacts(unit_.module(), request_.groups);
        }
        kernel_.hideOthers();
        optimizer_->dump("linked");
        verify(unit_, "linking");
        times_.step("link");
    }

    // Returns the header that the instructions passed through LLVM as text need.
    GpuHeader headerOfText() {
        const GpuTarget& gpu = request_.target;
        GpuHeader header = plainHeader(gpu);
        for (const auto& [module, instruction] : unit_.headerNeeds()) {
            if (!runsTarget(module->target, gpu.computeCapability))
                failAt(ErrorCode::kInvalidPtx, instruction->location, instruction->fullOpcode(),
                       ": the module's target is ", module->target, ", this GPU is of sm_",
                       gpu.computeCapability);
            widen(header, *module, gpu);
        }
        if (!(header == plainHeader(gpu)))
            code_.feedback += message("PTX ", header.version / 10, ".", header.version % 10,
                                      " for ", header.target, ", as modules declare\n");
        return header;
    }

    void bindValues() {
        std::vector<BoundValue> values;
        for (uint32_t i = 0; i < modules_.size(); ++i) {
            const auto& own = unit_.moduleRules(i).boundValues;
            values.insert(values.end(), own.begin(), own.end());
        }
        const std::vector<uint32_t> loads = substituteBoundValues(unit_, values);
        for (size_t i = 0; i < values.size() && i < loads.size(); ++i)
            code_.feedback +=
                message("bound value \"", values[i].annotation, "\", bytes ", values[i].offset,
                        " to ", values[i].offset + values[i].bytes.size() - 1, ": ", loads[i],
                        loads[i] == 1 ? " load" : " loads", " specialised\n");
    }

    const GpuPipelineRequest& request_;
    StepTimes times_;
    std::vector<const ptx::Module*> modules_;
    std::unique_ptr<llvm::TargetMachine> machine_;
    Unit unit_;
    GpuPrograms programs_;
    LaunchKernel kernel_;
    bool hasLongIntersections_ = false;
    std::optional<Optimizer> optimizer_;
    GpuCode code_;
};

} // namespace

uint32_t constantOf(const GpuPipelineRequest& request, std::string_view name) {
    const auto found =
        std::ranges::find(request.constants, name, [](const auto& each) { return each.first; });
    return found == request.constants.end() ? 0 : found->second;
}

bool mayWalkInStep(const GpuPipelineRequest& request) {
    return constantOf(request, "sunstone_gpu_motion") &&
           constantOf(request, kGraphConstant) != 0; // there may be instances
}

GpuCode compileGpuPipeline(const GpuPipelineRequest& request) {
    return GpuBuild(request).run();
}

void measureGpuStack(GpuCode& code, std::string_view log) {
    const GpuCalls::Frames frames = gpuFramesIn(log);
    if (!frames.empty())
        code.stack = GpuCalls::fromText(code.calls).stack(frames);
}

} // namespace sunstone::compiler
