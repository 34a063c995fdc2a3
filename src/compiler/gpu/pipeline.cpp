// SPDX-License-Identifier: Apache-2.0
// See gpu/pipeline.h.
#include "compiler/gpu/pipeline.h"

#include "base/config.h"
#include "base/error.h"
#include "compiler/compile_steps.h"
#include "compiler/gpu/header.h"
#include "compiler/gpu/link.h"
#include "compiler/gpu/machine.h"
#include "compiler/gpu/ray_states.h"
#include "compiler/gpu/resumable.h"
#include "compiler/passes/bound_values.h"
#include "compiler/passes/flush.h"
#include "compiler/passes/optimizer.h"
#include "compiler/passes/stack_checks.h"
#include "compiler/store/build_id.h"
#include "compiler/store/bytes.h"
#include "compiler/store/digest.h"
#include "devlib/abi.h"

#include <llvm/IR/DebugInfo.h>
#include <llvm/IR/InlineAsm.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/Verifier.h>
#include <llvm/Transforms/Utils/Cloning.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <span>

namespace sunstone::compiler {

namespace {

constexpr auto kAnyKind = devlib::GroupKind(0);

struct Dispatcher {
    const char* name;
    devlib::GroupKind kind; // of groups, or kAnyKind
    devlib::Role role;
    enum Form {
        kRun, // (state, group): calls the program
        kAsk, // (state, candidates, group): calls an intersection program
        kStart, // (state, ray, frame, asks, group): calls the first part of it, or all
        kResume, // the same with the part after its traces
        kFind, // (group): whether there is one
        kCode, // (group): its address
    } form;
};

// Whether a dispatcher for groups of kind `wanted` has those of this kind. Ray generation and bounds
// programs are entries of launches alike.
bool serves(devlib::GroupKind wanted, devlib::GroupKind kind) {
    return wanted == kAnyKind || wanted == kind ||
           (wanted == devlib::kGroupRaygen && kind == devlib::kGroupBounds);
}

// What the lowering calls for optixReportIntersection, and the run-time's function.
constexpr const char *kReportHere = "sunstone_gpu_report", *kReport = "sunstone_gpu_reportTo";

// Functions of LaunchConstants (devlib/gpu/programs.h), in the order of its members.
constexpr const char* kConstantNames[] = {"sunstone_gpu_usual", "sunstone_gpu_known",
                                          "sunstone_gpu_maxGraphDepth"};
static_assert(std::size(kConstantNames) == devlib::LaunchConstants::kCount);

// Kernels of devlib/gpu: run.h, loop.h, nested.h.
enum class KernelKind { kPlain, kLoop, kNested };

const char* entryOf(KernelKind kernel) {
    return kernel == KernelKind::kNested ? "sunstone_gpu_runNested"
           : kernel == KernelKind::kLoop ? "sunstone_gpu_runLoop"
                                         : "sunstone_gpu_run";
}

class GpuBuild {
public:
    explicit GpuBuild(const GpuPipelineRequest& request)
        : request_(request), times_("pipeline for a GPU"), modules_(modulesOf(request)),
          machine_(createGpuMachine(request.target)),
          unit_(flavorOf(request), request.pipeline.rules, modules_) {
        unit_.setTarget(Target::kGpu);
        unit_.module().setDataLayout(machine_->createDataLayout());
        unit_.module().setTargetTriple(machine_->getTargetTriple().str());
        for (const ProgramRequest& program : request.pipeline.programs) {
            unit_.setOptions(program.module->tree(), program.moduleRules, DebugLevel::kMinimal);
            level_ = std::max(level_, program.optLevel);
        }
        optimizer_.emplace(unit_, *machine_, level_);
    }

    GpuCode run() {
        declarePrograms();
        unit_.translateQueue();
        const GpuHeader header = headerOfText();
        optimizer_->dump("translated");
        verify(unit_, "translation");
        optimizer_->promote();
        markIntrinsicUsers(unit_);
        optimizer_->inlineAlways();
        optimizer_->promote();
        makeCopies();
        bindValues();
        unit_.flavor().lower(unit_, payloads_);
        passCandidates();
        lowerFlushesNative();
        if (request_.pipeline.rules.exceptionFlags & devlib::kFlagStackOverflow)
            addStackChecks(unit_);
        llvm::StripDebugInfo(unit_.module());
        times_.step("translate");
        chooseKernel();
        makeKernel();
        linkGpuRuntime(unit_.module(), *machine_, request_.runtime, request_.constants);
        for (const Dispatcher& dispatcher : dispatchers())
            define(dispatcher);
        defineGroupFacts();
        hide();
        optimizer_->dump("linked");
        verify(unit_, "linking");
        times_.step("link");
        optimizeForGpu(unit_.module(), *machine_, level_);
        if (kernel_ == KernelKind::kNested)
            foldStates();
        defineLaunchConstants();
        optimizer_->dump("optimized");
        refuseUnresolved();
        times_.step("optimize");
        code_.ptx = withHeader(emitGpuText(unit_.module(), *machine_), header);
        times_.step("generate");
        const GpuCalls calls(unit_.module(), code_.ptx);
        code_.stack = calls.stack();
        code_.calls = calls.text();
        code_.hasState = hasState();
        return std::move(code_);
    }

private:
    static const Flavor& flavorOf(const GpuPipelineRequest& request) {
        return request.pipeline.flavor ? *request.pipeline.flavor : optix7Flavor();
    }

    static std::vector<const ptx::Module*> modulesOf(const GpuPipelineRequest& request) {
        std::vector<const ptx::Module*> modules;
        for (const ProgramRequest& program : request.pipeline.programs)
            if (const ptx::Module* tree = &program.module->tree();
                std::find(modules.begin(), modules.end(), tree) == modules.end())
                modules.push_back(tree);
        return modules;
    }

    static std::span<const Dispatcher> dispatchers() {
        using namespace devlib;
        static const Dispatcher all[] = {
            {"sunstone_gpu_raygen", kGroupRaygen, devlib::kRoleMain, Dispatcher::kRun},
            {"sunstone_gpu_start", kGroupRaygen, devlib::kRoleMain, Dispatcher::kStart},
            {"sunstone_gpu_startHit", kGroupHit, devlib::kRoleMain, Dispatcher::kStart},
            {"sunstone_gpu_startMiss", kGroupMiss, devlib::kRoleMain, Dispatcher::kStart},
            {"sunstone_gpu_resume", kGroupRaygen, devlib::kRoleMain, Dispatcher::kResume},
            {"sunstone_gpu_resumeAny", kAnyKind, devlib::kRoleMain, Dispatcher::kResume},
            {"sunstone_gpu_findRaygen", kGroupRaygen, devlib::kRoleMain, Dispatcher::kFind},
            {"sunstone_gpu_miss", kGroupMiss, devlib::kRoleMain, Dispatcher::kRun},
            {"sunstone_gpu_exception", kGroupException, devlib::kRoleMain, Dispatcher::kRun},
            {"sunstone_gpu_closestHit", kGroupHit, devlib::kRoleMain, Dispatcher::kRun},
            {"sunstone_gpu_anyHit", kGroupHit, devlib::kRoleAnyHit, Dispatcher::kRun},
            {"sunstone_gpu_intersection", kGroupHit, devlib::kRoleIntersection, Dispatcher::kAsk},
            {"sunstone_gpu_direct", kGroupCallables, devlib::kRoleDirect, Dispatcher::kCode},
            {"sunstone_gpu_continuation", kGroupCallables, devlib::kRoleContinuation,
             Dispatcher::kCode},
        };
        return all;
    }

    void declarePrograms() {
        for (const ProgramRequest& program : request_.pipeline.programs) {
            const ptx::Function* source = program.module->tree().findFunction(program.function);
            if (!source || !source->hasBody)
                fail(ErrorCode::kNotFound, "the module has no function \"", program.function, "\"");
            llvm::Function* function = unit_.declare(program.module->tree(), *source);
            const PayloadType* payload =
                program.payloadType < 0
                    ? nullptr
                    : &program.moduleRules->payloadTypes.at(size_t(program.payloadType));
            const auto [known, isNew] = unit_.kinds().emplace(function, ProgramKind::kNone);
            if (payload && isNew)
                payloads_[function] = payload;
            if (!isNew) // for another payload type: lowered in another way
                copies_.push_back({programs_.size(), payload});
            unit_.kinds()[function] = program.kind;
            // Seen from outside until the dispatchers are there.
            function->setLinkage(llvm::GlobalValue::ExternalLinkage);
            programs_.push_back(function);
        }
    }

    // The header for the instructions that pass through LLVM as text.
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

    // Copies programs used with several payload types, before code depends on the type.
    void makeCopies() {
        for (const Copy& copy : copies_) {
            llvm::Function* original = programs_[copy.program];
            llvm::ValueToValueMapTy map;
            llvm::Function* function = llvm::CloneFunction(original, map);
            unit_.kinds()[function] = unit_.kinds()[original];
            if (copy.payload)
                payloads_[function] = copy.payload;
            programs_[copy.program] = function;
        }
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

    // Intersection programs get the state of the traversal as a second parameter and pass it to
    // their reports. Passed through the ray's state, which it refers to, neither could stay in
    // registers.
    void passCandidates() {
        llvm::Function* report = unit_.module().getFunction(kReportHere);
        std::map<llvm::Function*, llvm::Function*> changed;
        for (llvm::Function*& program : programs_) {
            if (unit_.kinds()[program] != ProgramKind::kIntersection)
                continue;
            llvm::Function*& with = changed[program];
            if (!with)
                with = withCandidates(*program, report);
            program = with;
        }
        for (const auto& [program, with] : changed) {
            unit_.kinds().erase(program);
            unit_.kinds()[with] = ProgramKind::kIntersection;
            program->deleteBody(); // its address may be somewhere
            if (program->use_empty())
                program->eraseFromParent();
        }
    }

    llvm::Function* withCandidates(llvm::Function& program, llvm::Function* report) {
        llvm::IRBuilder<> builder(unit_.context());
        llvm::Type *pointer = builder.getPtrTy(), *word = builder.getInt32Ty();
        auto* function = llvm::Function::Create(
            llvm::FunctionType::get(program.getReturnType(), {pointer, pointer}, false),
            program.getLinkage(), program.getName() + ".report", unit_.module());
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
                builder.CreateCall(unit_.module().getOrInsertFunction(kReport, type),
                                   {call->getArgOperand(0), function->getArg(1),
                                    call->getArgOperand(1), call->getArgOperand(2)}));
            call->eraseFromParent();
        }
        return function;
    }

    // Lowers the remaining .ftz: adding -0 flushes and has no other effect.
    void lowerFlushesNative() {
        llvm::Function* marker = unit_.module().getFunction(kFlushName);
        if (!marker)
            return;
        for (llvm::User* user : llvm::make_early_inc_range(marker->users())) {
            auto* call = llvm::cast<llvm::CallInst>(user);
            auto* type = llvm::FunctionType::get(call->getType(), {call->getType()}, false);
            auto* code =
                llvm::InlineAsm::get(type, "add.rn.ftz.f32 $0, $1, 0f80000000;", "=f,f", false);
            llvm::CallInst* flushed = llvm::CallInst::Create(type, code, {call->getArgOperand(0)},
                                                             "", call->getIterator());
            flushed->setMemoryEffects(llvm::MemoryEffects::none());
            call->replaceAllUsesWith(flushed);
            call->eraseFromParent();
        }
        marker->eraseFromParent();
    }

    std::vector<llvm::Function*> programsOf(devlib::GroupKind kind) const {
        std::vector<llvm::Function*> programs;
        for (const GpuGroup& group : request_.groups)
            if (group.kind == kind && group.programs[devlib::kRoleMain] != GpuGroup::kNone &&
                std::find(programs.begin(), programs.end(), programs_[group.programs[devlib::kRoleMain]]) ==
                    programs.end())
                programs.push_back(programs_[group.programs[devlib::kRoleMain]]);
        return programs;
    }
    std::vector<llvm::Function*> raygens() const { return programsOf(devlib::kGroupRaygen); }

    uint32_t constant(std::string_view name) const {
        for (const auto& [each, value] : request_.constants)
            if (each == name)
                return value;
        return 0;
    }

    void chooseKernel() {
        std::string nested;
        std::vector<llvm::Function*> cut = programsToNest(nested);
        if (!cut.empty()) {
            kernel_ = KernelKind::kNested;
            cuts_ = cutAtTraces(unit_.module(), *machine_, cut);
            code_.feedback += message(
                "kernel: rays of all depths take turns, and warps take new launch indices; ",
                cuts_.frameBytes, " bytes live across a trace, at each depth\n");
        } else {
            code_.feedback += nested;
            chooseSimpleKernel();
        }
        optimizer_->dump("cut");
        verify(unit_, "cutting");
        times_.step("cut");
    }

    // All programs that trace, for the kernel of devlib/gpu/nested.h: used if closest-hit or miss
    // programs trace and nothing prevents it; `reason` receives the obstacle.
    std::vector<llvm::Function*> programsToNest(std::string& reason) {
        const std::vector<llvm::Function*> tracing = tracingFunctions(unit_.module());
        const auto kindOf = [&](llvm::Function* function) {
            const auto known = unit_.kinds().find(function);
            return known == unit_.kinds().end() ? ProgramKind::kNone : known->second;
        };
        bool nests = false;
        std::string obstacle;
        for (llvm::Function* function : tracing) {
            const ProgramKind kind = kindOf(function);
            nests |= kind != ProgramKind::kRaygen;
            if (kind != ProgramKind::kRaygen && kind != ProgramKind::kClosestHit &&
                kind != ProgramKind::kMiss)
                obstacle = "a callable traces";
            else if (obstacle.empty())
                obstacle = obstacleToCut(*function);
        }
        if (!nests)
            return {};
        if (request_.maxTraceDepth == 0)
            obstacle = "the depth of traces is not known";
        if (request_.pipeline.rules.exceptionFlags & devlib::kFlagStackOverflow)
            obstacle = "the pipeline has stack overflow exceptions";
        if (obstacle.empty())
            return tracing;
        reason = message("rays of closest-hit and miss programs recurse, because ", obstacle, "\n");
        return {};
    }

    // Rays of a ray generation program that traces in a loop, at one place, take turns in the
    // kernel of devlib/gpu/loop.h. With several such places lanes would wait at different ones, and
    // all that lies between would run for few lanes at a time (docs/notes/ray-kernels-gpu.md has
    // figures).
    void chooseSimpleKernel() {
        std::vector<llvm::Function*> cut;
        std::string reason = "no ray generation program traces in a loop at one place";
        // Motion, curves and spheres make the traversal too large for several inlined copies; two
        // copies with motion are as large as the called functions. Debug and stack overflow
        // exceptions inspect stacks and the addresses of states.
        constexpr unsigned kLooks = devlib::kFlagDebug | devlib::kFlagStackOverflow;
        const bool mayInline = !constant("sunstone_gpu_shapes") &&
                               !(request_.pipeline.rules.exceptionFlags & kLooks);
        const bool moves = constant("sunstone_gpu_motion"), small = mayInline && !moves;
        if (!small)
            reason = "the pipeline has motion blur, debug or stack overflow exceptions, or its "
                     "rays may meet curves or spheres";
        for (llvm::Function* program : raygens())
            if (small && tracesInLoop(*program)) {
                const std::string obstacle = obstacleToCut(*program);
                if (obstacle.empty())
                    cut.push_back(program);
                else
                    reason = obstacle;
            }
        if (!cut.empty()) {
            kernel_ = KernelKind::kLoop;
            cuts_ = cutAtTraces(unit_.module(), *machine_, cut);
        }
        if (mayInline)
            traceInline(raygens(), moves ? 2 : 4);
        code_.feedback +=
            kernel_ == KernelKind::kLoop
                ? message("kernel: warps take new launch indices as their rays end; ",
                          cuts_.frameBytes, " bytes live across a trace\n")
                : message("kernel: one thread for each launch index, because ", reason, "\n");
    }

    // The function that a dispatcher calls for a program; null: none.
    llvm::Function* targetOf(const Dispatcher& dispatcher, llvm::Function* program) const {
        const auto cut = cuts_.cuts.find(program);
        switch (dispatcher.form) {
        case Dispatcher::kStart:
            return cut == cuts_.cuts.end() ? program : cut->second.start;
        case Dispatcher::kResume:
            return cut == cuts_.cuts.end() ? nullptr : cut->second.resume;
        case Dispatcher::kFind:
            return program;
        default:
            return cut == cuts_.cuts.end() ? program : nullptr;
        }
    }

    // switch (group) { case number: return program(state); ... default: return 0; }
    void define(const Dispatcher& dispatcher) {
        llvm::Function* const function = unit_.module().getFunction(dispatcher.name);
        if (!function) // the run-time does not call it
            return;
        llvm::LLVMContext& context = unit_.context();
        llvm::IRBuilder<> builder(context);
        const bool isCode = dispatcher.form == Dispatcher::kCode;
        const unsigned states = unsigned(function->arg_size()) - 1;
        function->addFnAttr(llvm::Attribute::AlwaysInline);
        function->addFnAttr(llvm::Attribute::NoUnwind);
        auto* entry = llvm::BasicBlock::Create(context, "", function);
        auto* other = llvm::BasicBlock::Create(context, "none", function);
        builder.SetInsertPoint(other);
        builder.CreateRet(
            isCode ? static_cast<llvm::Value*>(llvm::ConstantPointerNull::get(builder.getPtrTy()))
                   : builder.getInt32(~0u));
        builder.SetInsertPoint(entry);
        auto* choice = builder.CreateSwitch(function->getArg(states), other);
        std::map<llvm::Function*, llvm::BasicBlock*> calls; // one call per program
        std::set<uint32_t> numbers;                         // a group may be given twice
        for (const GpuGroup& group : request_.groups) {
            const size_t index = group.programs[dispatcher.role];
            if (index == GpuGroup::kNone ||
                !serves(dispatcher.kind, group.kind) ||
                !numbers.insert(group.number).second)
                continue;
            llvm::Function* program = targetOf(dispatcher, programs_[index]);
            if (!program)
                continue;
            llvm::BasicBlock*& block = calls[program];
            if (!block) {
                block = llvm::BasicBlock::Create(context, "", function);
                builder.SetInsertPoint(block);
                if (isCode)
                    builder.CreateRet(program);
                else if (dispatcher.form == Dispatcher::kFind)
                    builder.CreateRet(builder.getInt32(0));
                else
                    builder.CreateRet(callProgram(builder, *function, *program));
            }
            choice->addCase(builder.getInt32(group.number), block);
        }
    }

    // A function of a number: the fact about it, else `none`.
    using Facts = std::map<uint32_t, llvm::Value*>;
    void defineFacts(const char* name, llvm::Value* none, const Facts& facts) {
        llvm::IRBuilder<> builder(unit_.context());
        llvm::Function* const function = unit_.module().getFunction(name);
        if (!function) // the run-time does not call it
            return;
        function->addFnAttr(llvm::Attribute::NoUnwind);
        auto* entry = llvm::BasicBlock::Create(unit_.context(), "", function);
        auto* other = llvm::BasicBlock::Create(unit_.context(), "none", function);
        builder.SetInsertPoint(other);
        builder.CreateRet(none);
        builder.SetInsertPoint(entry);
        auto* choice = builder.CreateSwitch(function->getArg(0), other);
        for (const auto& [number, fact] : facts) {
            auto* block = llvm::BasicBlock::Create(unit_.context(), "", function);
            builder.SetInsertPoint(block);
            builder.CreateRet(fact);
            choice->addCase(builder.getInt32(number), block);
        }
    }

    // For debug exceptions: facts of callables, by 2 * group + continuation, and of built-in
    // intersections.
    void defineGroupFacts() {
        llvm::IRBuilder<> builder(unit_.context());
        Facts words, names, builtins, all; // a group may be given twice
        for (const GpuGroup& group : request_.groups) {
            all.emplace(group.number, builder.getInt32(1));
            for (uint32_t kind = 0; kind < 2; ++kind) {
                const GpuGroup::Callable& callable = group.callables[kind];
                if (callable.name.empty())
                    continue;
                const uint32_t number = 2 * group.number + kind;
                words.emplace(number, builder.getInt32(callable.parameterWords));
                if (!names.contains(number))
                    names[number] = builder.CreateGlobalString(callable.name, "", 0,
                                                               &unit_.module());
            }
            if (group.builtin)
                builtins.emplace(group.number, builder.getInt32(group.builtin));
        }
        defineFacts("sunstone_gpu_callableWords", builder.getInt32(0), words);
        defineFacts("sunstone_gpu_callableName",
                    llvm::ConstantPointerNull::get(builder.getPtrTy()), names);
        defineFacts("sunstone_gpu_builtin", builder.getInt32(0), builtins);
        defineFacts("sunstone_gpu_isGroup", builder.getInt32(0), all);
    }

    // A dispatcher's call of a program, or of a part of it, and the result.
    static llvm::Value* callProgram(llvm::IRBuilder<>& builder, llvm::Function& dispatcher,
                                    llvm::Function& program) {
        std::vector<llvm::Value*> operands = {dispatcher.getArg(0)};
        if (program.arg_size() == 2) // state, candidates
            operands.push_back(dispatcher.getArg(1));
        if (program.arg_size() == 4) // frame, state, ray, asks
            operands = {dispatcher.getArg(2), dispatcher.getArg(0), dispatcher.getArg(1),
                        dispatcher.getArg(3)};
        llvm::CallInst* call = builder.CreateCall(&program, operands);
        return call->getType()->isIntegerTy(32) ? static_cast<llvm::Value*>(call)
                                                : builder.getInt32(devlib::kAccept);
    }

    void makeKernel() {
        llvm::LLVMContext& context = unit_.context();
        llvm::IRBuilder<> builder(context);
        std::vector<llvm::Type*> parameters(1 + std::size(kConstantNames), builder.getInt64Ty());
        parameters[0] = builder.getPtrTy();
        auto* kernel = llvm::Function::Create(
            llvm::FunctionType::get(builder.getVoidTy(), parameters, false),
            llvm::GlobalValue::ExternalLinkage, kGpuKernel, unit_.module());
        kernel->setCallingConv(llvm::CallingConv::PTX_Kernel);
        builder.SetInsertPoint(llvm::BasicBlock::Create(context, "", kernel));
        std::vector<llvm::Value*> arguments = {kernel->getArg(0)};
        const auto addMemory = [&](uint64_t bytes, unsigned alignment) {
            auto* memory = builder.CreateAlloca(
                llvm::ArrayType::get(builder.getInt8Ty(), std::max<uint64_t>(bytes, 1)));
            memory->setAlignment(llvm::Align(alignment));
            arguments.push_back(memory);
            return memory->getAllocatedType();
        };
        const uint64_t frame = llvm::alignTo(cuts_.frameBytes, kFrameAlignment);
        const uint64_t depths = uint64_t(request_.maxTraceDepth) + 1; // of programs
        if (kernel_ == KernelKind::kLoop)
            addMemory(frame, kFrameAlignment);
        if (kernel_ == KernelKind::kNested) {
            // A ray that is too deep has a state, too.
            statesType_ =
                addMemory((depths + 1) * sizeof(devlib::RayState), alignof(devlib::RayState));
            addMemory(depths * frame, kFrameAlignment);
            addMemory(depths * sizeof(uint32_t), alignof(uint32_t));
            arguments.push_back(builder.getInt32(uint32_t(frame)));
        }
        std::vector<llvm::Type*> types;
        for (const llvm::Value* argument : arguments)
            types.push_back(argument->getType());
        builder.CreateCall(
            unit_.module().getOrInsertFunction(
                entryOf(kernel_), llvm::FunctionType::get(builder.getVoidTy(), types, false)),
            arguments);
        builder.CreateRetVoid();
    }

    // In the kernel they are its arguments, which GPUs read without a load.
    void defineLaunchConstants() {
        llvm::Function* const kernel = unit_.module().getFunction(kGpuKernel);
        for (unsigned i = 0; i < std::size(kConstantNames); ++i) {
            llvm::Function* const function = unit_.module().getFunction(kConstantNames[i]);
            if (!function)
                continue;
            for (llvm::User* user : llvm::make_early_inc_range(function->users())) {
                auto* call = llvm::cast<llvm::CallInst>(user);
                llvm::Value* value = kernel->getArg(1 + i);
                if (call->getFunction() != kernel) {
                    llvm::IRBuilder<> builder(call);
                    const uint64_t offset = sizeof(devlib::LaunchState) + 8 * i;
                    value = builder.CreateAlignedLoad(
                        call->getType(),
                        builder.CreateInBoundsGEP(builder.getInt8Ty(), call->getArgOperand(0),
                                                  builder.getInt64(offset)),
                        llvm::Align(8));
                }
                call->replaceAllUsesWith(value);
                call->eraseFromParent();
            }
            function->eraseFromParent();
        }
    }

    void foldStates() {
        constexpr int kRounds = 2; // the first removes code that blocks the second
        llvm::Function& kernel = *unit_.module().getFunction(kGpuKernel);
        for (int round = 0; round < kRounds; ++round) {
            llvm::AllocaInst* states = nullptr;
            for (llvm::Instruction& each : kernel.getEntryBlock())
                if (auto* memory = llvm::dyn_cast<llvm::AllocaInst>(&each))
                    if (memory->getAllocatedType() == statesType_)
                        states = memory;
            if (!states || !foldRayStates(*states))
                return;
            simplifyForGpu(kernel, *machine_, level_);
        }
    }

    // Makes the kernel the only visible function.
    void hide() {
        inlineIntoKernel(*unit_.module().getFunction(entryOf(kernel_)));
        for (llvm::Function* program : raygens())
            if (program->hasOneUse())
                inlineIntoKernel(*program);
        for (llvm::GlobalValue& value : unit_.module().global_values())
            if (!value.isDeclaration() && value.getName() != kGpuKernel)
                value.setLinkage(llvm::GlobalValue::InternalLinkage);
    }

    bool hasState() {
        constexpr unsigned kShared = 3; // address space
        for (const llvm::GlobalVariable& variable : unit_.module().globals())
            if (!variable.isConstant() && variable.getAddressSpace() != kShared)
                return true;
        return false;
    }

    // What runs once in the kernel becomes a part of it. LLVM leaves large functions apart, and the
    // driver's compiler gives those frames of their own (docs/notes/compile-time.md has figures).
    static void inlineIntoKernel(llvm::Function& function) {
        function.removeFnAttr(llvm::Attribute::NoInline);
        function.addFnAttr(llvm::Attribute::AlwaysInline);
    }

    void refuseUnresolved() {
        // Functions that the driver provides to device code.
        constexpr llvm::StringLiteral kProvided[] = {"vprintf", "malloc", "free", "__assertfail"};
        std::string missing;
        for (llvm::Function& function : unit_.module())
            if (function.isDeclaration() && !function.isIntrinsic() && !function.use_empty() &&
                !llvm::is_contained(kProvided, function.getName()))
                missing += (missing.empty() ? "" : ", ") + function.getName().str();
        if (!missing.empty())
            fail(ErrorCode::kNotSupported,
                 "programs need what the GPU back end does not have yet: ", missing);
    }

    const GpuPipelineRequest& request_;
    StepTimes times_;
    std::vector<const ptx::Module*> modules_;
    std::unique_ptr<llvm::TargetMachine> machine_;
    Unit unit_;
    OptLevel level_ = OptLevel::k0;
    std::optional<Optimizer> optimizer_;
    ProgramPayloads payloads_;
    std::vector<llvm::Function*> programs_; // of the request
    struct Copy {
        size_t program;
        const PayloadType* payload;
    };
    std::vector<Copy> copies_;
    KernelKind kernel_ = KernelKind::kPlain;
    llvm::Type* statesType_ = nullptr; // of the memory that keeps the states of rays, if any does
    CutPrograms cuts_;
    GpuCode code_;
};

} // namespace

GpuCode compileGpuPipeline(const GpuPipelineRequest& request) {
    return GpuBuild(request).run();
}

std::string keyOf(const GpuPipelineRequest& request) {
    Digest digest;
    digest.add(buildId()); // the run-time is a part of the build
    digest.add("gpu");
    digest.add(request.pipeline.flavor ? request.pipeline.flavor->name() : optix7Flavor().name());
    digest.add(uint64_t(request.target.computeCapability));
    digest.add(uint64_t(request.target.ptxVersion));
    digest.add(uint64_t(request.target.driverVersion));
    digest.add(uint64_t(request.maxTraceDepth));
    addRules(digest, request.pipeline.rules);
    digest.add(uint64_t(request.pipeline.programs.size()));
    digest.add(uint64_t(request.groups.size()));
    std::vector<const Source*> modules; // equal texts may be several modules
    for (const ProgramRequest& program : request.pipeline.programs) {
        auto found = std::find(modules.begin(), modules.end(), program.module.get());
        digest.add(uint64_t(found - modules.begin()));
        if (found == modules.end())
            modules.push_back(program.module.get());
        digest.add(program.module->digest());
        digest.add(program.function);
        digest.add(uint64_t(program.kind));
        digest.add(uint64_t(program.optLevel));
        digest.add(uint64_t(int64_t(program.payloadType)));
        addRules(digest, program.moduleRules ? *program.moduleRules : ModuleRules());
    }
    for (const GpuGroup& group : request.groups) {
        for (const size_t value : {size_t(group.number), size_t(group.kind), size_t(group.builtin)})
            digest.add(uint64_t(value));
        for (const size_t program : group.programs)
            digest.add(uint64_t(program));
    }
    for (const auto& [name, value] : request.constants) {
        digest.add(name);
        digest.add(uint64_t(value));
    }
    return digest.take();
}

std::string keyOf(const GpuTarget& target, std::string_view kernel) {
    Digest digest;
    digest.add(buildId()); // its text is a part of the build
    digest.add("kernel");
    digest.add(uint64_t(target.computeCapability));
    digest.add(uint64_t(target.driverVersion));
    digest.add(kernel);
    return digest.take();
}

namespace {

constexpr uint32_t kMagic = 0x43555047; // "GPUC"

// The text is kept only if there is no machine code.
std::string serialize(const GpuCode& code) {
    const auto& [ptx, feedback, stack, calls, machineCode, isState] = code; // names every field
    ByteWriter out;
    out.number(kMagic);
    for (const uint64_t value :
         {stack.entry, stack.waiting, stack.other, uint64_t(stack.isMeasured), uint64_t(isState)})
        out.wide(value);
    out.text(feedback);
    out.text(calls);
    out.text(machineCode.empty() ? ptx : std::string());
    out.text(machineCode);
    return out.take();
}

bool deserialize(std::string_view bytes, GpuCode& code) {
    ByteReader in(bytes);
    if (in.number() != kMagic)
        return false;
    code.stack.entry = in.wide();
    code.stack.waiting = in.wide();
    code.stack.other = in.wide();
    code.stack.isMeasured = in.wide() != 0;
    code.hasState = in.wide() != 0;
    code.feedback = in.text();
    code.calls = in.text();
    code.ptx = in.text();
    code.machineCode = in.text();
    return in.finished() && code.ptx.empty() != code.machineCode.empty();
}

} // namespace

bool findGpuPipeline(const std::string& key, ObjectStore& store, GpuCode& code) {
    std::string bytes;
    return store.find(key, bytes) && deserialize(bytes, code);
}

void keepGpuPipeline(const std::string& key, const GpuCode& code, ObjectStore& store) {
    store.insert(key, serialize(code));
}

void measureGpuStack(GpuCode& code, std::string_view log) {
    const GpuCalls::Frames frames = gpuFramesIn(log);
    if (!frames.empty())
        code.stack = GpuCalls::fromText(code.calls).stack(frames);
}

} // namespace sunstone::compiler
