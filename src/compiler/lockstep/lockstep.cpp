// SPDX-License-Identifier: Apache-2.0
// See lockstep.h. Decides which kernels get code for a warp at a time.
#include "compiler/lockstep/lockstep.h"

#include "base/config.h"
#include "base/log.h"
#include "compiler/lockstep/emit.h"
#include "compiler/lockstep/steps.h"
#include "compiler/passes/flush.h"
#include "compiler/passes/optimizer.h"
#include "devlib/lockstep.h"

#include <llvm/ADT/SCCIterator.h>
#include <llvm/Analysis/CallGraph.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/IntrinsicInst.h>
#include <llvm/Transforms/Utils/Cloning.h>

namespace sunstone::compiler {

using llvm::CallInst;
using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;

namespace {

constexpr const char* kWarpFeatures[] = {"+avx512f", "+avx512bw", "+avx512dq", "+avx512vl"};

bool hasMasks(LentMachine& machine) {
    const std::string features = "," + machine->getTargetFeatureString().str() + ",";
    for (const char* feature : kWarpFeatures)
        if (features.find("," + std::string(feature) + ",") == std::string::npos)
            return false;
    return true;
}

constexpr const char* kNoGain = "it would not gain by it";

// Derives the difference of a value between neighbouring lanes, if possible. The result is a guess
// for values that are clamped or wrap around. Assumes blocks at least a warp wide.
class Strides {
public:
    explicit Strides(const LockstepPlan& plan)
        : plan_(plan), layout_(plan.function().getParent()->getDataLayout()) {}

    bool isNear(const llvm::Value* address, const llvm::Type* type) {
        const Stride stride = of(address);
        return stride.isKnown &&
               stride.bytes == int64_t(layout_.getTypeStoreSize(const_cast<llvm::Type*>(type)));
    }

private:
    struct Stride {
        bool isKnown = false;
        int64_t bytes = 0; // or the value's own unit
    };

    Stride of(const llvm::Value* value) {
        if (plan_.isUniform(value))
            return {true, 0};
        const auto* instruction = dyn_cast<Instruction>(value);
        if (!instruction)
            return {};
        // A value that depends on itself is unknown at first; a phi ignores unknown inputs.
        const auto [known, isNew] = known_.try_emplace(instruction);
        if (!isNew)
            return known->second;
        const Stride made = compute(*instruction);
        return known_[instruction] = made;
    }

    static Stride sum(Stride first, Stride second, int64_t factor = 1) {
        return {first.isKnown && second.isKnown, first.bytes + factor * second.bytes};
    }

    Stride compute(const Instruction& instruction) {
        using devlib::KernelThread;
        const auto operand = [&](unsigned i) { return of(instruction.getOperand(i)); };
        const int field = plan_.fieldOf(instruction);
        if (field >= 0)
            return {true, field == 0 || field == offsetof(KernelThread, laneid)};
        if (isa<llvm::CastInst, llvm::FreezeInst>(instruction))
            return operand(0);
        if (const auto* phi = dyn_cast<llvm::PHINode>(&instruction)) {
            return join(*phi);
        }
        if (const auto* choice = dyn_cast<llvm::SelectInst>(&instruction))
            return larger(of(choice->getTrueValue()), of(choice->getFalseValue()));
        if (isa<llvm::MinMaxIntrinsic>(instruction))
            return larger(operand(0), operand(1));
        if (const auto* address = dyn_cast<llvm::GetElementPtrInst>(&instruction)) {
            if (address->getNumIndices() != 1)
                return {};
            const auto size = layout_.getTypeAllocSize(address->getSourceElementType());
            return sum(operand(0), operand(1), int64_t(size.getFixedValue()));
        }
        const auto* binary = dyn_cast<llvm::BinaryOperator>(&instruction);
        if (!binary)
            return {};
        const auto* number = dyn_cast<llvm::ConstantInt>(binary->getOperand(1));
        const int64_t constant =
            number && number->getBitWidth() <= 64 ? number->getSExtValue() : -1;
        switch (binary->getOpcode()) {
        case Instruction::Add:
        case Instruction::Or:
            return sum(operand(0), operand(1));
        case Instruction::Sub:
            return sum(operand(0), operand(1), -1);
        case Instruction::Shl:
            return {number && operand(0).isKnown, operand(0).bytes << (constant & 63)};
        case Instruction::Mul:
            return {number && operand(0).isKnown, operand(0).bytes * constant};
        case Instruction::And: // of lanes
            return {constant >= 31 && operand(0).isKnown, operand(0).bytes};
        default:
            return {};
        }
    }

    // At the head of a loop, use the value from before the loop, because the other inputs depend on
    // it.
    Stride join(const llvm::PHINode& phi) {
        const llvm::Loop* loop = plan_.loops().getLoopFor(phi.getParent());
        const bool isHead = loop && loop->getHeader() == phi.getParent();
        Stride made;
        for (const bool isInner : {false, true}) {
            for (unsigned i = 0; i < phi.getNumIncomingValues(); ++i) {
                if (isInner != (isHead && loop->contains(phi.getIncomingBlock(i))))
                    continue;
                const Stride one = of(phi.getIncomingValue(i));
                if (one.isKnown && made.isKnown && one.bytes != made.bytes)
                    return {};
                made = one.isKnown ? one : made;
            }
            known_[&phi] = made;
        }
        return made;
    }

    static Stride larger(Stride first, Stride second) {
        return {first.isKnown && second.isKnown,
                std::abs(first.bytes) > std::abs(second.bytes) ? first.bytes : second.bytes};
    }

    const LockstepPlan& plan_;
    const llvm::DataLayout& layout_;
    llvm::DenseMap<const Instruction*, Stride> known_;
};

const llvm::Type* accessType(const Instruction& access) {
    if (const auto* store = dyn_cast<llvm::StoreInst>(&access))
        return store->getValueOperand()->getType();
    return access.getType();
}

// Whether the kernel gains from vectors. Without meeting points, running one thread after the other
// is correct, too. Compares estimates in instructions: vector instructions against instructions
// repeated per lane.
bool paysOff(const LockstepPlan& plan) {
    constexpr double kLanesAtOnce = 8; // of 16 in a vector: not all lanes are always active
    constexpr double kRoundOfLane = 6; // around an instruction repeated per lane
    constexpr double kCall = 20, kRounds = 8; // of a function; of a loop
    constexpr double kFar = 6; // an access with addresses that are not consecutive, for each lane
    double single = 0, together = 0;
    Strides strides(plan);
    for (const Instruction& instruction : llvm::instructions(plan.function())) {
        double weight = 1;
        for (unsigned i = std::min(3u, plan.loops().getLoopDepth(instruction.getParent())); i > 0;
             --i)
            weight *= kRounds;
        if (isa<llvm::AllocaInst>(instruction))
            return false; // local memory is laid out per thread
        const auto* call = dyn_cast<CallInst>(&instruction);
        if (call && call->getCalledFunction() &&
            call->getCalledFunction()->getName() == "sunstone_vprintf")
            return false; // threads print in order
        if (call && call->getCalledFunction() && isMeeting(call->getCalledFunction()->getName()))
            continue; // mostly a single comparison
        const bool isCall = call && !call->isInlineAsm() && !isa<llvm::IntrinsicInst>(call);
        const bool isAlone = isCall || isa<llvm::AtomicRMWInst>(instruction) ||
                             isa<llvm::AtomicCmpXchgInst>(instruction);
        const double own = weight * (isCall ? kCall : 1);
        const llvm::Value* address = llvm::getLoadStorePointerOperand(&instruction);
        const bool isFar = address && !plan.isUniform(address) && plan.fieldOf(instruction) < 0 &&
                           !strides.isNear(address, accessType(instruction));
        single += own;
        together += isAlone ? own + weight * kRoundOfLane : isFar ? own * kFar : own / kLanesAtOnce;
    }
    return together < 0.7 * single;
}

llvm::Function* emitCode(const LockstepPlan& plan, llvm::Function& source, bool masks, bool byRuns,
                         KernelInfo& info) {
    llvm::LLVMContext& context = source.getContext();
    llvm::Type* word = llvm::Type::getInt32Ty(context);
    llvm::Type* pointer = llvm::PointerType::getUnqual(context);
    auto* result = llvm::Function::Create(
        llvm::FunctionType::get(word, {pointer, pointer, word, word}, false),
        llvm::GlobalValue::ExternalLinkage, kLockstepPrefix + info.name, source.getParent());
    result->addFnAttr(llvm::Attribute::NoUnwind);
    result->addFnAttr("warn-stack-size", "0");
    result->addFnAttr(llvm::Attribute::NullPointerIsValid); // see keepNullAccesses()
    result->setDSOLocal(true);
    result->addParamAttr(0, llvm::Attribute::NoAlias);
    result->addParamAttr(0, llvm::Attribute::NonNull);
    result->addParamAttr(
        0, llvm::Attribute::getWithDereferenceableBytes(context, sizeof(devlib::LockstepWarp)));
    result->addParamAttr(0, llvm::Attribute::getWithAlignment(context, llvm::Align(64)));
    result->setSubprogram(source.getSubprogram());
    source.setSubprogram(nullptr);
    LockstepEmitter emitter(plan, *result, masks, byRuns);
    emitter.emit();
    info.hasLockstep = true;
    info.lockstepFrameBytes = emitter.frameBytes();
    info.needsThreads = emitter.needsThreads();
    return result;
}

} // namespace

void inlineMeetings(Unit& unit) {
    llvm::Module& module = unit.module();
    for (llvm::Function& function : module)
        if (function.isDeclaration() && isMeeting(function.getName()))
            function.addFnAttr(llvm::Attribute::Convergent); // must not be duplicated
    llvm::CallGraph graph(module);
    std::set<const llvm::Function*> meeting;
    for (auto component = llvm::scc_begin(&graph); !component.isAtEnd(); ++component) {
        bool meets = false;
        for (llvm::CallGraphNode* node : *component)
            for (const auto& call : *node)
                if (const llvm::Function* callee = call.second->getFunction())
                    meets |= meeting.count(callee) != 0 || findLaneFunction(callee->getName());
        if (!meets)
            continue;
        for (llvm::CallGraphNode* node : *component) {
            llvm::Function* function = node->getFunction();
            if (!function || function->isDeclaration())
                continue;
            meeting.insert(function);
            const auto facts = unit.facts().find(function);
            const bool isKernel = facts == unit.facts().end() || facts->second.function->isEntry;
            if (isKernel || component.hasCycle())
                continue;
            function->removeFnAttr(llvm::Attribute::NoInline);
            function->addFnAttr(llvm::Attribute::AlwaysInline);
        }
    }
}

namespace {

// Whether the function or its callees have meeting points, end threads or ask for a thread's own
// frames. If such a function is not inlined into the kernel, a thread could stop inside a frame
// that lockstep code does not manage, and the kernel's memory is not in the thread's frames.
bool callsMeetings(const llvm::Function& function, std::set<const llvm::Function*>& seen) {
    for (const Instruction& instruction : llvm::instructions(function)) {
        const auto* call = dyn_cast<CallInst>(&instruction);
        if (!call || call->isInlineAsm())
            continue;
        const llvm::Function* callee = calleeOf(*call);
        if (!callee)
            return true;
        if (callee->isDeclaration()) {
            if (findLaneFunction(callee->getName()))
                return true;
        } else if (seen.insert(callee).second && callsMeetings(*callee, seen)) {
            return true;
        }
    }
    return false;
}

bool calleesMeet(const llvm::Function& kernel) {
    std::set<const llvm::Function*> seen = {&kernel};
    for (const Instruction& instruction : llvm::instructions(kernel))
        if (const auto* call = dyn_cast<CallInst>(&instruction); call && !call->isInlineAsm())
            if (const llvm::Function* callee = calleeOf(*call))
                if (!callee->isDeclaration() && seen.insert(callee).second &&
                    callsMeetings(*callee, seen))
                    return true;
    return false;
}

// Vectors of 32 take several times as long to compile as code for a thread, about 0.2 ms for each
// instruction of the vector code. Longer kernels get code by runs (lockstep/runs.cpp).
constexpr unsigned kLongKernel = 512, kLongVectorCode = 5000;

// The largest frame of a warp. Values in a larger frame would not stay in the processor's caches.
constexpr uint32_t kMostFrameBytes = 1 << 20;

// Writes the code as vectors or, if those are too many, by runs. Null if its values take too much
// memory.
llvm::Function* writeCode(const LockstepPlan& plan, llvm::Function& source, bool masks,
                          bool& byRuns, KernelInfo& info) {
    llvm::Function* made = emitCode(plan, source, masks, byRuns, info);
    const auto drop = [&] {
        source.setSubprogram(made->getSubprogram());
        made->eraseFromParent();
        info.hasLockstep = false;
        return nullptr;
    };
    if (!byRuns && made->getInstructionCount() > kLongVectorCode) {
        drop();
        byRuns = true;
        made = emitCode(plan, source, masks, byRuns, info);
    }
    return info.lockstepFrameBytes > kMostFrameBytes ? drop() : made;
}

// Generates code from `copy`, a copy of the kernel. Returns the reason if it cannot, else an empty
// text.
std::string addCode(Unit& unit, Optimizer& optimizer, LentMachine& machine, llvm::Function& copy,
                    bool isFlushed, bool needsSteps, bool byRuns, KernelInfo& info) {
    LockstepPlan plan(copy);
    plan.endThreads();
    optimizer.simplifyControl(copy);
    if (!plan.analyze())
        return plan.reason();
    if (!needsSteps && !wantsRuns() && !paysOff(plan))
        return kNoGain;
    llvm::Function* made = writeCode(plan, copy, hasMasks(machine), byRuns, info);
    if (!made)
        return "its values take too much memory";
    if (isFlushed) {
        runFlushed(unit, *made);
        made = &flushedOf(unit, *made);
    }
    optimizer.finishLockstep(*made, byRuns);
    return {};
}

} // namespace

bool wantsRuns() {
    return currentConfig(Setting::kKernels) == "runs";
}

void addLockstep(Unit& unit, Optimizer& optimizer, LentMachine& machine, llvm::Function& kernel,
                 KernelInfo& info) {
    llvm::Function& source = flushedOf(unit, kernel);
    info.countsOnSteps = countsOnSteps(source, info.usesBarriers);
    const bool needsSteps = info.usesBarriers || info.usesWarpFunctions || info.countsOnSteps;
    const bool isLong = source.getInstructionCount() > kLongKernel || wantsRuns();
    if (isLong && !needsSteps && !wantsRuns()) {
        info.singleReason = kNoGain;
        return;
    }
    if (calleesMeet(source)) {
        info.singleReason = "a function that is not part of it depends on the thread's own stack";
        return;
    }
    llvm::ValueToValueMapTy map;
    llvm::Function* copy = llvm::CloneFunction(&source, map);
    copy->setLinkage(llvm::GlobalValue::InternalLinkage);
    info.singleReason =
        addCode(unit, optimizer, machine, *copy, &source != &kernel, needsSteps, isLong, info);
    optimizer.forget(*copy);
    copy->eraseFromParent();
}

} // namespace sunstone::compiler
