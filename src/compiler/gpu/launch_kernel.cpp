// SPDX-License-Identifier: Apache-2.0
// See launch_kernel.h.
#include "compiler/gpu/launch_kernel.h"

#include "compiler/gpu/dispatchers.h"
#include "compiler/gpu/machine.h"
#include "compiler/gpu/tracing_callables.h"
#include "devlib/abi.h"
#include "devlib/lockstep.h"

#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/IntrinsicsNVPTX.h>

namespace sunstone::compiler {

namespace {

// Functions of LaunchConstants (devlib/gpu/programs.h), in the order of its members.
constexpr const char* kConstantNames[] = {"sunstone_gpu_usual", "sunstone_gpu_known",
                                          "sunstone_gpu_maxGraphDepth"};
static_assert(std::size(kConstantNames) == devlib::LaunchConstants::kCount);

constexpr const char *kHasLaneMemory = "sunstone_gpu_hasLaneMemory",
                     *kClaimLaneMemory = "sunstone_gpu_claimLaneMemory",
                     *kFreeLaneMemory = "sunstone_gpu_freeLaneMemory",
                     *kLeaveLaneMemory = "sunstone_gpu_leaveLaneMemory";

// States of a lane's rays in local memory: all of them if they are at most kMostNear, else
// kNearDepths. docs/notes/programs-gpu.md has figures.
constexpr uint64_t kMostNear = 6;

// Inlines a function that the kernel calls once. LLVM would not inline large functions, and the
// driver's compiler would give them frames of their own (docs/notes/compile-time.md has figures).
void inlineIntoKernel(llvm::Function& function) {
    function.removeFnAttr(llvm::Attribute::NoInline);
    function.addFnAttr(llvm::Attribute::AlwaysInline);
}

} // namespace

const char* LaunchKernel::entry() const {
    return isDeepPart()             ? "sunstone_gpu_runNestedDeep"
           : kind_ == Kind::kNested ? "sunstone_gpu_runNested"
           : kind_ == Kind::kLoop   ? "sunstone_gpu_runLoop"
                                    : "sunstone_gpu_run";
}

bool LaunchKernel::walksInStep() const {
    return kind_ == Kind::kNested && (raysTrace_ || request_.part == GpuPart::kKernel) &&
           mayWalkInStep(request_);
}

bool LaunchKernel::isApart() const {
    return request_.part != GpuPart::kWhole && request_.part != GpuPart::kKernel;
}

bool LaunchKernel::isDeepPart() const {
    return request_.part != GpuPart::kWhole && request_.maxTraceDepth > kReadyDepth;
}

bool LaunchKernel::isOfKernel(llvm::StringRef name) {
    return name == kLeaveLaneMemory;
}

std::string LaunchKernel::choose() {
    if (isApart())
        return cutApart();
    if (request_.part == GpuPart::kKernel) {
        kind_ = Kind::kNested;
        cuts_.frameBytes = kReadyFrameBytes;
        return {};
    }
    std::string inlined, obstacle;
    if (mayNest())
        inlined = inlineTracingCallables(unit_);
    std::vector<llvm::Function*> cut = programsToNest(!inlined.empty(), obstacle);
    if (cut.empty())
        return inlined + obstacle + chooseSimple();
    kind_ = Kind::kNested;
    cuts_ = cutAtTraces(unit_.module(), machine_, cut);
    return inlined +
           message("kernel: rays of all depths take turns, and warps take new launch indices; ",
                   cuts_.frameBytes, " bytes live across a trace, at each depth\n");
}

std::string LaunchKernel::cutApart() {
    const std::string inlined = inlineTracingCallables(unit_); // in all parts alike
    const std::vector<llvm::Function*> tracing = tracingFunctions(unit_.module());
    std::string obstacle;
    for (llvm::Function* function : tracing)
        if (obstacle.empty())
            obstacle = obstacleIn(*function);
    if (obstacle.empty() && !tracing.empty()) {
        cuts_ = cutAtTraces(unit_.module(), machine_, tracing);
        if (cuts_.frameBytes > kReadyFrameBytes)
            obstacle = message(cuts_.frameBytes, " bytes live across a trace");
    }
    refuses_ = !obstacle.empty();
    return refuses_ ? obstacle : inlined;
}

std::string LaunchKernel::obstacleIn(llvm::Function& program) const {
    const auto known = unit_.kinds().find(&program);
    const ProgramKind kind = known == unit_.kinds().end() ? ProgramKind::kNone : known->second;
    return kind == ProgramKind::kRaygen || kind == ProgramKind::kClosestHit ||
                   kind == ProgramKind::kMiss
               ? obstacleToCut(program)
               : "a callable or a function that calls itself traces";
}

bool LaunchKernel::overflows() const {
    return request_.pipeline.rules.exceptionFlags & devlib::kFlagStackOverflow;
}
bool LaunchKernel::mayNest() const {
    return request_.maxTraceDepth != 0 && !overflows();
}

std::vector<llvm::Function*> LaunchKernel::programsToNest(bool nests, std::string& reason) {
    const std::vector<llvm::Function*> tracing = tracingFunctions(unit_.module());
    const auto isRaygen = [&](llvm::Function* function) {
        const auto known = unit_.kinds().find(function);
        return known != unit_.kinds().end() && known->second == ProgramKind::kRaygen;
    };
    // With instances, ray generation programs that trace several rays are faster in the kernel with
    // one place for all rays (docs/notes/programs-gpu.md).
    const bool nestsRaygen = constantOf(request_, kGraphConstant) != 0 && // maybe instances
                             request_.maxTraceDepth != 0;
    std::string obstacle;
    for (llvm::Function* function : tracing) {
        raysTrace_ |= !isRaygen(function);
        nests |= !isRaygen(function) || (nestsRaygen && !tracesOnce(*function));
        if (obstacle.empty())
            obstacle = obstacleIn(*function);
    }
    if (!nests)
        return {};
    if (request_.maxTraceDepth == 0)
        obstacle = "the depth of traces is not known";
    if (overflows())
        obstacle = "the pipeline has stack overflow exceptions";
    if (obstacle.empty())
        return tracing;
    reason = message("programs keep their place while a ray is traced, because ", obstacle, "\n");
    return {};
}

// A ray generation program that traces in a loop, at one place, gets the kernel with persistent
// threads of devlib/gpu/loop.h. With several such places, lanes would wait at different places, and
// the code between them would run for few lanes at a time (docs/notes/ray-kernels-gpu.md has
// figures).
std::string LaunchKernel::chooseSimple() {
    std::vector<llvm::Function*> cut;
    std::string reason = "no ray generation program traces in a loop at one place";
    // Motion, curves and spheres make the traversal too large for several inlined copies; two
    // copies with motion are as large as the called functions. The checks of debug and stack
    // overflow exceptions read stacks and the addresses of states.
    constexpr unsigned kLooks = devlib::kFlagDebug | devlib::kFlagStackOverflow;
    const bool mayInline = !constantOf(request_, "sunstone_gpu_shapes") &&
                           !(request_.pipeline.rules.exceptionFlags & kLooks);
    const bool moves = constantOf(request_, "sunstone_gpu_motion"), small = mayInline && !moves;
    if (!small)
        reason = "the pipeline has motion blur, debug or stack overflow exceptions, or its "
                 "rays may meet curves or spheres";
    for (llvm::Function* program : programs_.mainsOf(devlib::kGroupRaygen))
        if (small && tracesInLoop(*program)) {
            const std::string obstacle = obstacleToCut(*program);
            if (obstacle.empty())
                cut.push_back(program);
            else
                reason = obstacle;
        }
    if (!cut.empty()) {
        kind_ = Kind::kLoop;
        cuts_ = cutAtTraces(unit_.module(), machine_, cut);
    }
    if (mayInline)
        traceInline(programs_.mainsOf(devlib::kGroupRaygen), moves ? 2 : 4);
    return kind_ == Kind::kLoop
               ? message("kernel: warps take new launch indices as their rays end; ",
                         cuts_.frameBytes, " bytes live across a trace\n")
               : message("kernel: one thread for each launch index, because ", reason, "\n");
}

void LaunchKernel::make() {
    llvm::LLVMContext& context = unit_.context();
    llvm::IRBuilder<> builder(context);
    std::vector<llvm::Type*> parameters(1 + std::size(kConstantNames), builder.getInt64Ty());
    parameters[0] = builder.getPtrTy();
    auto* kernel =
        llvm::Function::Create(llvm::FunctionType::get(builder.getVoidTy(), parameters, false),
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
    if (kind_ == Kind::kLoop)
        addMemory(frame, kFrameAlignment);
    if (kind_ == Kind::kNested) {
        const uint64_t states = depths + 1; // a ray beyond the depth limit needs one, too
        const bool isReady = request_.part == GpuPart::kKernel;
        const bool isNear = isReady ? !isDeepPart() : states <= kMostNear;
        const uint64_t near = isNear ? states : kNearDepths;
        const auto addPart = [&](uint64_t first, uint64_t end) {
            addMemory((end - first) * sizeof(devlib::RayState), alignof(devlib::RayState));
            states_.emplace_back(arguments.back());
            addMemory((std::min(end, depths) - first) * frame, kFrameAlignment);
            frames_.emplace_back(arguments.back());
        };
        addPart(0, near);
        if (near != states && !isReady)
            addPart(near, states);
        else if (!isDeepPart())
            arguments.insert(arguments.end(), 2,
                             llvm::ConstantPointerNull::get(builder.getPtrTy()));
        arguments.push_back(builder.getInt32(uint32_t(near)));
        arguments.push_back(builder.getInt32(uint32_t(frame)));
    }
    std::vector<llvm::Type*> types;
    for (const llvm::Value* argument : arguments)
        types.push_back(argument->getType());
    if (kind_ == Kind::kNested) { // linked; placeStates() removes them if unused
        unit_.module().getOrInsertFunction(kClaimLaneMemory, builder.getPtrTy(),
                                           builder.getPtrTy());
        unit_.module().getOrInsertFunction(kFreeLaneMemory, builder.getVoidTy());
    }
    builder.CreateCall(unit_.module().getOrInsertFunction(
                           entry(), llvm::FunctionType::get(builder.getVoidTy(), types, false)),
                       arguments);
    builder.CreateRetVoid();
}

void LaunchKernel::defineConstants() {
    llvm::Function* const kernel = unit_.module().getFunction(kGpuKernel);
    for (unsigned i = 0; i < std::size(kConstantNames); ++i) {
        llvm::Function* const function = unit_.module().getFunction(kConstantNames[i]);
        if (!function)
            continue;
        for (llvm::User* user : llvm::make_early_inc_range(function->users())) {
            auto* call = llvm::cast<llvm::CallInst>(user);
            llvm::Value* value = nullptr;
            if (kernel && call->getFunction() == kernel) {
                value = kernel->getArg(1 + i);
            } else {
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

StateUses::Arrays LaunchKernel::states() const {
    StateUses::Arrays arrays;
    for (const llvm::WeakTrackingVH& each : states_)
        if (llvm::Value* const value = each; value && llvm::isa<llvm::AllocaInst>(value))
            arrays.push_back(llvm::cast<llvm::AllocaInst>(value));
    return arrays.size() == states_.size() ? arrays : StateUses::Arrays();
}

void LaunchKernel::foldStates() {
    constexpr int kRounds = 2; // the first removes code that blocks the second
    for (int round = 0; round < kRounds; ++round) {
        const StateUses::Arrays arrays = states();
        if (arrays.empty() || !foldRayStates(arrays))
            return;
        simplifyForGpu(*arrays.front()->getFunction(), machine_, effort());
    }
}

void LaunchKernel::decideLaneMemory(bool has) {
    llvm::Module& module = unit_.module();
    if (llvm::Function* asked = module.getFunction(kHasLaneMemory)) {
        for (llvm::User* user : llvm::make_early_inc_range(asked->users())) {
            user->replaceAllUsesWith(llvm::ConstantInt::get(user->getType(), has ? 1 : 0));
            llvm::cast<llvm::Instruction>(user)->eraseFromParent();
        }
        asked->eraseFromParent();
    }
    for (const char* name : {kClaimLaneMemory, kFreeLaneMemory})
        if (llvm::Function* function = module.getFunction(name); function && !has)
            function->eraseFromParent();
}

uint64_t LaunchKernel::placeStates() {
    if (kind_ != Kind::kNested)
        return 0;
    if (request_.part == GpuPart::kKernel) { // programs of other parts read the states
        decideLaneMemory(isDeepPart());
        return 0;
    }
    const StateUses::Arrays arrays = states();
    const std::optional<uint64_t> bytes = arrays.empty() ? std::nullopt : packRayStates(arrays);
    decideLaneMemory(bytes && arrays.size() > 1);
    if (!bytes)
        return 0;
    const auto statesIn = [&](const llvm::AllocaInst& array) {
        return array.getAllocationSize(unit_.module().getDataLayout())->getFixedValue() /
               sizeof(devlib::RayState);
    };
    llvm::IRBuilder<> builder(arrays[0]);
    llvm::AllocaInst* const near = builder.CreateAlloca(
        llvm::ArrayType::get(builder.getInt8Ty(), statesIn(*arrays[0]) * *bytes));
    near->setAlignment(llvm::Align(kStateAlignment));
    arrays[0]->replaceAllUsesWith(near);
    arrays[0]->eraseFromParent();
    return arrays.size() == 1 ? 0 : claimLaneMemory(*arrays[1], statesIn(*arrays[1]), *bytes);
}

uint64_t LaunchKernel::claimLaneMemory(llvm::AllocaInst& states, uint64_t count, uint64_t bytes) {
    constexpr unsigned kLanes = devlib::kWarpLanes;
    llvm::Function& kernel = *states.getFunction();
    llvm::IRBuilder<> builder(&*kernel.getEntryBlock().getFirstInsertionPt());
    llvm::Value* const own =
        builder.CreateCall(unit_.module().getFunction(kClaimLaneMemory), {kernel.getArg(0)});
    // The casts tell LLVM that this is global memory.
    llvm::Value* const slot = builder.CreateAddrSpaceCast(
        builder.CreateAddrSpaceCast(own, builder.getPtrTy(1)), builder.getPtrTy());
    llvm::Value* const lane = builder.CreateZExt(
        builder.CreateIntrinsic(llvm::Intrinsic::nvvm_read_ptx_sreg_laneid, {}, {}),
        builder.getInt64Ty());
    uint64_t end = 0;
    const auto place = [&](llvm::AllocaInst& array, uint64_t laneBytes) {
        array.replaceAllUsesWith(builder.CreateGEP(
            builder.getInt8Ty(), slot,
            builder.CreateAdd(builder.getInt64(end),
                              builder.CreateMul(lane, builder.getInt64(laneBytes)))));
        array.eraseFromParent();
        end += laneBytes * kLanes;
    };
    place(states, count * bytes);
    llvm::Value* const frames = frames_.back();
    if (auto* array = frames ? llvm::dyn_cast<llvm::AllocaInst>(frames) : nullptr)
        place(*array, llvm::alignTo(
                          array->getAllocationSize(unit_.module().getDataLayout())->getFixedValue(),
                          kStateAlignment));
    std::vector<llvm::Instruction*> ends;
    for (llvm::BasicBlock& block : kernel)
        if (llvm::isa<llvm::ReturnInst>(block.getTerminator()))
            ends.push_back(block.getTerminator());
    for (llvm::Instruction* each : ends) {
        builder.SetInsertPoint(each);
        builder.CreateCall(unit_.module().getFunction(kFreeLaneMemory));
    }
    return end;
}

void LaunchKernel::hideOthers() {
    if (!isApart())
        inlineIntoKernel(*unit_.module().getFunction(entry()));
    for (llvm::Function* program : programs_.mainsOf(devlib::kGroupRaygen))
        if (program->hasOneUse())
            inlineIntoKernel(*program);
    llvm::Function* const leave = unit_.module().getFunction(kLeaveLaneMemory);
    if (leave && isApart() && isDeepPart())
        leave->deleteBody(); // the kernel's part has it, with the slots of the block's warps
    if (leave && leave->isDeclaration())
        leave->removeFnAttr(llvm::Attribute::AlwaysInline);
    for (llvm::GlobalValue& value : unit_.module().global_values()) {
        if (value.isDeclaration() || value.getName() == kGpuKernel ||
            value.getName() == kClaimLaneMemory || value.getName() == kFreeLaneMemory ||
            (&value == leave && isDeepPart()))
            continue;
        if (isApart() && isDispatcher(value.getName()))
            llvm::cast<llvm::Function>(value).removeFnAttr(llvm::Attribute::AlwaysInline);
        else
            value.setLinkage(llvm::GlobalValue::InternalLinkage);
    }
    if (kind_ != Kind::kNested) // before LLVM optimises the code that asks
        decideLaneMemory(isApart() && isDeepPart());
}

} // namespace sunstone::compiler
