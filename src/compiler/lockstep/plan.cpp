// SPDX-License-Identifier: Apache-2.0
// See lockstep/plan.h.
//
// A value is uniform if it is computed from uniform values. The thread's indices, loads from
// varying addresses and results of meeting points are not uniform. Lanes diverge at a branch on a
// varying value. Phis at the joins of its paths then vary, and so do values used after a loop that
// lanes leave at different times. Lanes that continue from a point together may have reached it on
// different paths. The code therefore compares the uniform values live there (lockstep/emit.cpp),
// and only lanes with equal values continue together.
#include "compiler/lockstep/plan.h"

#include "compiler/passes/flush.h"
#include "devlib/lockstep.h"

#include <llvm/ADT/BitVector.h>
#include <llvm/ADT/PostOrderIterator.h>
#include <llvm/Analysis/VectorUtils.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/IntrinsicInst.h>
#include <llvm/Transforms/Utils/BasicBlockUtils.h>
#include <llvm/Transforms/Utils/Local.h>

#include <algorithm>

namespace sunstone::compiler {

using llvm::BasicBlock;
using llvm::CallInst;
using llvm::cast;
using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;
using llvm::Value;

llvm::Function* calleeOf(const llvm::CallBase& call) {
    llvm::Function* callee = call.getCalledFunction();
    if (callee && callee->getName().starts_with(kLeavePrefix))
        return dyn_cast<llvm::Function>(call.getArgOperand(0)->stripPointerCasts());
    return callee;
}

bool asksForLanes(const Instruction& instruction) {
    const auto* call = dyn_cast<CallInst>(&instruction);
    const llvm::Function* callee = call && !call->isInlineAsm() ? calleeOf(*call) : nullptr;
    const LaneFunction* function = callee ? findLaneFunction(callee->getName()) : nullptr;
    return function && function->effect == LaneFunction::kAsks;
}

namespace {

constexpr uint32_t kNotConstant = ~uint32_t(0);

uint32_t constantOf(const Value* value) {
    const auto* number = dyn_cast<llvm::ConstantInt>(value);
    return number ? uint32_t(number->getZExtValue()) : kNotConstant;
}

MeetingPoint describe(CallInst* call) {
    using namespace devlib;
    MeetingPoint point;
    point.call = call;
    const LaneFunction& function = *findLaneFunction(call->getCalledFunction()->getName());
    point.kind = function.kind;
    if (function.kind == kMeetPause) {
        point.mode = function.mode;
        return point;
    }
    if (function.kind == kMeetBarrier) {
        const uint32_t id = constantOf(call->getArgOperand(1));
        const bool isPlain = id < 16 && constantOf(call->getArgOperand(2)) == 0 &&
                             constantOf(call->getArgOperand(3)) == kReduceNone;
        point.kind = isPlain ? kMeetPlain : kMeetBarrier;
        point.mode = isPlain ? id : constantOf(call->getArgOperand(3));
        return point;
    }
    point.mode = constantOf(call->getArgOperand(1));
    return point;
}

bool isPure(const llvm::Function* function) {
    return function && function->doesNotAccessMemory() &&
           function->hasFnAttribute(llvm::Attribute::WillReturn);
}

} // namespace

// Makes code after the end of a thread unreachable. A wait at a barrier object returns without a
// result if the launcher cannot switch threads, so a pause after it lets other threads run.
void LockstepPlan::endThreads() {
    std::vector<CallInst*> calls, waits;
    for (Instruction& instruction : llvm::instructions(function_))
        if (auto* call = dyn_cast<CallInst>(&instruction))
            if (llvm::Function* callee = calleeOf(*call)) {
                const LaneFunction* known = findLaneFunction(callee->getName());
                if (known && known->effect == LaneFunction::kWaits)
                    waits.push_back(call);
                else if (known && known->effect != LaneFunction::kAsks &&
                         known->effect != LaneFunction::kFrames)
                    calls.push_back(call);
            }
    llvm::LLVMContext& context = function_.getContext();
    for (CallInst* call : waits) {
        llvm::FunctionCallee spin = function_.getParent()->getOrInsertFunction(
            laneFunction(ptx::Lockstep::kSpin).name, llvm::Type::getVoidTy(context),
            llvm::PointerType::getUnqual(context));
        CallInst::Create(spin, {function_.getArg(0)}, "", call->getNextNode())
            ->setDebugLoc(call->getDebugLoc());
    }
    for (CallInst* call : calls) {
        llvm::Function* callee = calleeOf(*call);
        if (callee != call->getCalledFunction()) {
            // A meeting point does no arithmetic, so the processor's mode does not matter.
            std::vector<Value*> arguments(call->arg_begin() + 1, call->arg_end());
            auto* direct = CallInst::Create(callee->getFunctionType(), callee, arguments, "", call);
            direct->setDebugLoc(call->getDebugLoc());
            call->replaceAllUsesWith(direct);
            call->eraseFromParent();
            call = direct;
        }
        if (!endsThread(callee->getName()))
            continue;
        if (call->getParent()->getTerminator() == call->getNextNode() &&
            isa<llvm::ReturnInst>(call->getNextNode()))
            continue;
        llvm::changeToUnreachable(call->getNextNode());
        Instruction* end = call->getParent()->getTerminator();
        llvm::ReturnInst::Create(function_.getContext(), nullptr, end);
        end->eraseFromParent();
    }
    llvm::EliminateUnreachableBlocks(function_);
}

// A vector of 16 bytes that is loaded or stored as a whole (FunctionTranslator::isWholeVector), and
// its elements.
static bool isPartOfWhole(const Instruction& instruction) {
    if (isa<llvm::LoadInst, llvm::ZExtInst>(instruction) ||
        instruction.getOpcode() == Instruction::Or)
        return true;
    return instruction.isShift() && isa<llvm::ConstantInt>(instruction.getOperand(1));
}

bool LockstepPlan::check() {
    for (Instruction& instruction : llvm::instructions(function_)) {
        if (instruction.getType()->isVectorTy())
            return refuse("it has values that are vectors already");
        if (instruction.getType()->isIntegerTy(128) && !isPartOfWhole(instruction))
            return refuse("it has numbers of 128 bits");
        if (const auto* intrinsic = dyn_cast<llvm::IntrinsicInst>(&instruction);
            intrinsic && (intrinsic->getIntrinsicID() == llvm::Intrinsic::stacksave ||
                          intrinsic->getIntrinsicID() == llvm::Intrinsic::stackrestore))
            return refuse("it moves its stack");
        if (isa<llvm::SwitchInst, llvm::IndirectBrInst, llvm::InvokeInst, llvm::CallBrInst,
                llvm::InsertValueInst, llvm::VAArgInst>(instruction))
            return refuse(std::string("it has the instruction ") + instruction.getOpcodeName());
        for (const Value* operand : instruction.operands())
            if (operand->getType()->isVectorTy())
                return refuse("it has values that are vectors already");
        if (instruction.getType()->isAggregateType()) {
            std::vector<Instruction*> parts;
            for (llvm::User* user : instruction.users())
                parts.push_back(dyn_cast<llvm::ExtractValueInst>(user));
            for (Instruction* part : parts) {
                if (!part || isa<llvm::PHINode>(instruction))
                    return refuse("a structure is more than the result of an instruction");
                part->moveAfter(&instruction); // structures stay within a block
            }
        }
        if (auto* memory = dyn_cast<llvm::AllocaInst>(&instruction))
            if (!memory->isStaticAlloca() || memory->getParent() != &function_.getEntryBlock())
                return refuse("its local memory has no constant size");
        const bool isAsm =
            isa<llvm::CallBase>(instruction) && cast<llvm::CallBase>(instruction).isInlineAsm();
        if (isAsm && instruction.mayHaveSideEffects())
            return refuse("it has assembly with side effects");
        auto* call = dyn_cast<CallInst>(&instruction);
        if (!call || isAsm)
            continue;
        llvm::Function* callee = calleeOf(*call);
        if (!callee)
            return refuse("it calls functions through pointers");
        const LaneFunction* known = findLaneFunction(callee->getName());
        if (known && known->effect == LaneFunction::kFrames)
            return refuse("it asks which addresses are in local memory");
    }
    return true;
}

// Threads often stride through memory by the width of the grid. A warp that runs alone reads a few
// cache lines of each page, and the other warps of the block read the same page much later. Memory
// is fast only if the warps stay together. Innermost loops in which each lane reads memory
// therefore get a point at which a warp that has changed pages several times lets the others catch
// up.
void LockstepPlan::addPauses() {
    llvm::FunctionCallee pause = function_.getParent()->getOrInsertFunction(
        laneFunction(ptx::Lockstep::kPause).name, llvm::Type::getVoidTy(function_.getContext()));
    for (llvm::Loop* loop : loops_.getLoopsInPreorder()) {
        BasicBlock* latch = loop->getLoopLatch();
        if (!latch || !loop->isInnermost())
            continue;
        bool reads = false, meets = false;
        for (BasicBlock* block : loop->blocks())
            for (Instruction& instruction : *block) {
                const auto* call = dyn_cast<CallInst>(&instruction);
                const auto* load = dyn_cast<llvm::LoadInst>(&instruction);
                reads |= load && !isUniform(load->getPointerOperand());
                meets |= call && call->getCalledFunction() &&
                         isMeeting(call->getCalledFunction()->getName());
            }
        if (!reads || meets)
            continue;
        auto* branch = cast<llvm::BranchInst>(latch->getTerminator());
        BasicBlock* last = latch;
        if (branch->isConditional())
            last = llvm::SplitEdge(latch, loop->getHeader());
        CallInst::Create(pause, {}, "", last->getTerminator());
    }
}

bool LockstepPlan::pauses(const BasicBlock& block) const {
    const llvm::Loop* loop = loops_.getLoopFor(&block);
    return loop && std::any_of(points_.begin(), points_.end(), [&](const MeetingPoint& point) {
               return point.kind == devlib::kMeetPause && point.mode == 0 &&
                      loop->contains(point.next);
           });
}

void LockstepPlan::split() {
    std::vector<CallInst*> calls;
    for (BasicBlock& block : function_)
        for (Instruction& instruction : block)
            if (auto* call = dyn_cast<CallInst>(&instruction))
                if (call->getCalledFunction() && isMeeting(call->getCalledFunction()->getName()))
                    calls.push_back(call);
    for (CallInst* call : calls) {
        if (call->getParent()->getFirstNonPHIOrDbg() != call ||
            isa<llvm::PHINode>(call->getParent()->front()))
            call->getParent()->splitBasicBlock(call);
        points_.push_back(describe(call));
        points_.back().next = call->getParent()->splitBasicBlock(call->getNextNode());
    }
    for (const MeetingPoint& point : points_)
        pointOf_[point.call->getParent()] = &point;
}

const MeetingPoint* LockstepPlan::pointAt(const BasicBlock* block) const {
    const auto found = pointOf_.find(block);
    return found == pointOf_.end() ? nullptr : found->second;
}

void LockstepPlan::findStructure() {
    dominators_.recalculate(function_);
    postDominators_.recalculate(function_);
    loops_.releaseMemory();
    loops_.analyze(dominators_);
}

bool LockstepPlan::isSimpleLoop(const llvm::Loop& loop) const {
    const BasicBlock* head = loop.getHeader();
    const auto* branch = dyn_cast<llvm::BranchInst>(head->getTerminator());
    if (!branch || !branch->isConditional() || !pauses(*head) ||
        loop.contains(branch->getSuccessor(0)) == loop.contains(branch->getSuccessor(1)))
        return false;
    return llvm::all_of(loop.blocks(), [&](const BasicBlock* block) {
        const MeetingPoint* point = pointAt(block);
        return block == head || (point && point->kind == devlib::kMeetPause) ||
               (block->sizeWithoutDebug() == 1 && block->getSingleSuccessor());
    });
}

bool LockstepPlan::analyze() {
    if (!check())
        return false;
    findStructure();
    findUniform();
    addPauses();
    split();
    if (points_.size() >= (1u << devlib::kPointBits) / 4)
        return refuse("its threads meet at too many places");
    constexpr uint64_t kMostBits = uint64_t(1) << 29; // of each of the four sets of findLive
    if (uint64_t(function_.size()) * function_.getInstructionCount() > kMostBits)
        return refuse("it has too many branches for its length");
    findStructure();
    order(nullptr, steps_);
    if (!reason_.empty())
        return false;
    findUniform();
    findPrologue();
    findLive();
    return true;
}

// ---- order ------------------------------------------------------------------------------------

// A topological order in which the blocks of a loop follow one another.
void LockstepPlan::order(const llvm::Loop* loop, std::vector<Step>& steps) {
    const auto holds = [&](const BasicBlock* block) { return !loop || loop->contains(block); };
    // The inner loop that contains a block, as a child of `loop`, or null.
    const auto innerOf = [&](const BasicBlock* block) {
        const llvm::Loop* inner = loops_.getLoopFor(block);
        while (inner && inner->getParentLoop() != loop)
            inner = inner->getParentLoop();
        return inner;
    };
    const auto keyOf = [&](BasicBlock* block) {
        const llvm::Loop* inner = innerOf(block);
        return inner ? inner->getHeader() : block;
    };
    const BasicBlock* head = loop ? loop->getHeader() : &function_.getEntryBlock();
    llvm::DenseSet<const BasicBlock*> seen, open;
    std::vector<BasicBlock*> finished;
    struct Visit {
        BasicBlock* key;
        std::vector<BasicBlock*> next;
    };
    std::vector<Visit> stack;
    const auto enter = [&](BasicBlock* key) {
        Visit visit{key, {}};
        const auto add = [&](BasicBlock* from) {
            for (BasicBlock* successor : llvm::successors(from))
                if (holds(successor) && successor != head && keyOf(successor) != key)
                    visit.next.push_back(keyOf(successor));
        };
        if (const llvm::Loop* inner = innerOf(key))
            for (BasicBlock* block : inner->blocks())
                add(block);
        else
            add(key);
        seen.insert(key);
        open.insert(key);
        stack.push_back(std::move(visit));
    };
    enter(const_cast<BasicBlock*>(head));
    while (!stack.empty()) {
        Visit& visit = stack.back();
        if (visit.next.empty()) {
            finished.push_back(visit.key);
            open.erase(visit.key);
            stack.pop_back();
            continue;
        }
        BasicBlock* next = visit.next.back();
        visit.next.pop_back();
        if (open.contains(next))
            refuse("its control flow is irreducible");
        if (!seen.contains(next))
            enter(next);
    }
    for (auto block = finished.rbegin(); block != finished.rend(); ++block) {
        steps.emplace_back();
        if (const llvm::Loop* inner = innerOf(*block)) {
            steps.back().loop = inner;
            std::vector<Step> body;
            order(inner, body);
            steps.back().body = std::move(body);
        } else {
            steps.back().block = *block;
        }
    }
}

// ---- uniform values ---------------------------------------------------------------------------

int LockstepPlan::fieldOf(const Instruction& instruction) const {
    const auto* load = dyn_cast<llvm::LoadInst>(&instruction);
    if (!load)
        return -1;
    llvm::APInt offset(64, 0);
    const Value* base = load->getPointerOperand()->stripAndAccumulateConstantOffsets(
        function_.getParent()->getDataLayout(), offset, true);
    if (base != function_.getArg(0) || offset.uge(sizeof(devlib::KernelThread)))
        return -1;
    return int(offset.getZExtValue());
}

namespace {

bool isOwnField(int offset) {
    using devlib::KernelThread;
    return offset < int(offsetof(KernelThread, ntid)) || offset == offsetof(KernelThread, laneid);
}

} // namespace

bool LockstepPlan::varies(const Instruction& instruction) const {
    const auto operandVaries = [&] {
        return std::any_of(instruction.op_begin(), instruction.op_end(),
                           [&](const Value* operand) { return varying_.contains(operand); });
    };
    if (const int field = fieldOf(instruction); field >= 0)
        return isOwnField(field);
    if (isa<llvm::AllocaInst, llvm::AtomicRMWInst, llvm::AtomicCmpXchgInst>(instruction))
        return true;
    if (const auto* load = dyn_cast<llvm::LoadInst>(&instruction)) {
        if (!load->isSimple() || operandVaries())
            return true;
    } else if (const auto* phi = dyn_cast<llvm::PHINode>(&instruction)) {
        if (operandVaries() || joins_.contains(phi->getParent()))
            return true;
    } else if (const auto* call = dyn_cast<CallInst>(&instruction)) {
        const llvm::Function* callee = call->isInlineAsm() ? nullptr : calleeOf(*call);
        const bool isAlike =
            call->isInlineAsm() || isPure(callee) || isPure(call->getCalledFunction());
        if (!asksForLanes(*call) && (!isAlike || operandVaries()))
            return true;
    } else if (operandVaries()) {
        return true;
    }
    // Used after a loop that lanes leave at different times.
    for (const Value* user : instruction.users()) {
        const BasicBlock* place = cast<Instruction>(user)->getParent();
        for (const llvm::Loop* loop = loops_.getLoopFor(instruction.getParent());
             loop && !loop->contains(place); loop = loop->getParentLoop())
            if (divergentLoops_.contains(loop))
                return true;
    }
    return false;
}

bool LockstepPlan::isDivergentLoop(const llvm::Loop& loop) const {
    llvm::SmallVector<BasicBlock*, 8> exiting;
    loop.getExitingBlocks(exiting);
    for (const BasicBlock* block : loop.blocks()) {
        if (!divergentBranches_.contains(block))
            continue;
        // Whether lanes that diverge here can leave the loop before they reconverge.
        const auto* node = postDominators_.getNode(block);
        const BasicBlock* meeting = node && node->getIDom() ? node->getIDom()->getBlock() : nullptr;
        llvm::DenseSet<const BasicBlock*> seen;
        std::vector<const BasicBlock*> queue = {block};
        while (!queue.empty()) {
            const BasicBlock* at = queue.back();
            queue.pop_back();
            if (std::find(exiting.begin(), exiting.end(), at) != exiting.end())
                return true;
            for (const BasicBlock* successor : llvm::successors(at))
                if (successor != meeting && loop.contains(successor) &&
                    successor != loop.getHeader() && seen.insert(successor).second)
                    queue.push_back(successor);
        }
    }
    return false;
}

// Lanes diverge at the end of this block: marks the blocks where they reconverge.
void LockstepPlan::addDivergence(const BasicBlock& block) {
    const auto* node = postDominators_.getNode(&block);
    const BasicBlock* meeting = node && node->getIDom() ? node->getIDom()->getBlock() : nullptr;
    llvm::DenseSet<const BasicBlock*> seen;
    std::vector<const BasicBlock*> queue = {&block};
    const auto comeTo = [&](const BasicBlock* next) {
        if (!seen.insert(next).second)
            return;
        const auto* place = dominators_.getNode(next);
        const auto* above = place ? place->getIDom() : nullptr;
        if (above && dominators_.dominates(above->getBlock(), &block))
            joins_.insert(next);
        if (next != meeting)
            queue.push_back(next);
    };
    while (!queue.empty()) {
        const BasicBlock* at = queue.back();
        queue.pop_back();
        for (const BasicBlock* successor : llvm::successors(at)) {
            const llvm::Loop* loop = loops_.getLoopFor(successor);
            if (!loop || loop->getHeader() != successor || !loop->contains(at)) {
                comeTo(successor);
                continue;
            }
            // Back edges join no lanes, because all lanes of a loop are in one iteration. But these
            // lanes leave the loop in another iteration than the others, at any of its exits.
            llvm::SmallVector<BasicBlock*, 8> exits;
            loop->getExitBlocks(exits);
            for (const BasicBlock* exit : exits)
                comeTo(exit);
        }
    }
}

void LockstepPlan::findUniform() {
    varying_.clear();
    divergentBranches_.clear();
    joins_.clear();
    divergentLoops_.clear();
    varying_.insert(function_.getArg(0));
    for (bool changed = true; changed;) {
        changed = false;
        for (const BasicBlock& block : function_) {
            for (const Instruction& instruction : block)
                if (!varying_.contains(&instruction) && varies(instruction)) {
                    varying_.insert(&instruction);
                    changed = true;
                }
            const auto* branch = dyn_cast<llvm::BranchInst>(block.getTerminator());
            if (branch && branch->isConditional() && varying_.contains(branch->getCondition()) &&
                divergentBranches_.insert(&block).second) {
                addDivergence(block);
                changed = true;
            }
        }
        for (const llvm::Loop* loop : loops_.getLoopsInPreorder())
            if (!divergentLoops_.contains(loop) && isDivergentLoop(*loop)) {
                divergentLoops_.insert(loop);
                changed = true;
            }
    }
}

bool LockstepPlan::outlivesLoop(const Instruction& instruction) const {
    const llvm::Loop* loop = loops_.getLoopFor(instruction.getParent());
    if (!loop)
        return false;
    return std::any_of(instruction.user_begin(), instruction.user_end(), [&](const Value* user) {
        return !loop->contains(cast<Instruction>(user)->getParent());
    });
}

// ---- values live across points ----------------------------------------------------------------

void LockstepPlan::findPrologue() {
    const auto isReady = [&](const Value* operand) {
        return !isa<Instruction>(operand) || inPrologue_.contains(operand);
    };
    llvm::ReversePostOrderTraversal<llvm::Function*> blocks(&function_);
    for (BasicBlock* block : blocks)
        for (Instruction& instruction : *block) {
            bool fits = false;
            if (fieldOf(instruction) >= 0) {
                fits = true;
            } else if (const auto* load = dyn_cast<llvm::LoadInst>(&instruction)) {
                // Parameters can be read at any time.
                llvm::APInt offset(64, 0);
                fits = load->isSimple() &&
                       load->getPointerOperand()->stripAndAccumulateConstantOffsets(
                           function_.getParent()->getDataLayout(), offset, true) ==
                           function_.getArg(1);
            } else if (isUniform(&instruction)) {
                const bool isSafe =
                    isa<llvm::CastInst, llvm::CmpInst, llvm::SelectInst, llvm::GetElementPtrInst,
                        llvm::FreezeInst>(instruction) ||
                    (isa<llvm::BinaryOperator>(instruction) && !instruction.isIntDivRem());
                fits = isSafe && std::all_of(instruction.op_begin(), instruction.op_end(), isReady);
            }
            if (fits) {
                prologue_.push_back(&instruction);
                inPrologue_.insert(&instruction);
            }
        }
}

void LockstepPlan::findLive() {
    if (points_.empty())
        return;
    llvm::DenseMap<const Instruction*, unsigned> numbers;
    std::vector<Instruction*> values;
    for (Instruction& instruction : llvm::instructions(function_))
        if (!instruction.getType()->isVoidTy() && !inPrologue_.contains(&instruction) &&
            !isa<llvm::AllocaInst>(instruction)) {
            numbers[&instruction] = unsigned(values.size());
            values.push_back(&instruction);
        }
    struct Sets {
        llvm::BitVector in, used, defined, atEnd;
    };
    llvm::DenseMap<const BasicBlock*, Sets> sets;
    for (const BasicBlock& block : function_) {
        const unsigned count = unsigned(values.size());
        sets[&block] = {llvm::BitVector(count), llvm::BitVector(count), llvm::BitVector(count),
                        llvm::BitVector(count)};
    }
    for (const BasicBlock& block : function_)
        for (const Instruction& instruction : block) {
            const auto* phi = dyn_cast<llvm::PHINode>(&instruction);
            for (unsigned i = 0; i < instruction.getNumOperands(); ++i) {
                const auto* operand = dyn_cast<Instruction>(instruction.getOperand(i));
                const auto number = operand ? numbers.find(operand) : numbers.end();
                if (number == numbers.end())
                    continue;
                if (phi)
                    sets[phi->getIncomingBlock(i)].atEnd.set(number->second);
                else if (!sets[&block].defined.test(number->second))
                    sets[&block].used.set(number->second);
            }
            if (const auto own = numbers.find(&instruction); own != numbers.end())
                sets[&block].defined.set(own->second);
        }
    for (bool changed = true; changed;) {
        changed = false;
        for (const BasicBlock* block : llvm::post_order(&function_)) {
            Sets& own = sets[block];
            llvm::BitVector live = own.atEnd;
            for (const BasicBlock* successor : llvm::successors(block))
                live |= sets[successor].in;
            live.reset(own.defined);
            live |= own.used;
            if (live != own.in) {
                own.in = live;
                changed = true;
            }
        }
    }
    for (MeetingPoint& point : points_)
        for (const unsigned number : sets[point.next].in.set_bits())
            if (values[number] != point.call)
                point.live.push_back(values[number]);
}

} // namespace sunstone::compiler
