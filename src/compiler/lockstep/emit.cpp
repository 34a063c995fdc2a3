// SPDX-License-Identifier: Apache-2.0
// LockstepEmitter: blocks, masks, loops, meeting points.
//
// The code has the blocks in one fixed order. A block's mask holds the lanes that run it next. The
// block takes its mask, runs if the mask has lanes, and adds them to the masks of the next blocks.
// Blocks after a meeting point in a loop can have lanes when the loop is entered; the loop's first
// iteration then runs only for those lanes.
#include "compiler/lockstep/emit.h"

#include <llvm/IR/InlineAsm.h>
#include <llvm/IR/IntrinsicInst.h>

namespace sunstone::compiler {

using devlib::LockstepWarp;
using llvm::BasicBlock;
using llvm::cast;
using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;
using llvm::Value;

LockstepEmitter::LockstepEmitter(const LockstepPlan& plan, llvm::Function& result, bool hasMasks,
                                 bool byRuns)
    : plan_(plan), source_(plan.function()), result_(result), hasMasks_(hasMasks), byRuns_(byRuns),
      context_(result.getContext()), layout_(result.getParent()->getDataLayout()),
      builder_(context_), top_(context_) {}

void LockstepEmitter::emit() {
    begin();
    if (byRuns_)
        beginRuns();
    emitPrologue();
    emitEntry();
    for (const Step& step : plan_.steps()) {
        landAt(step);
        emitSteps({step});
    }
    finish();
}

// Code by runs has no vectors, so its masks are numbers.
llvm::Type* LockstepEmitter::maskType() {
    if (byRuns_)
        return builder_.getInt32Ty();
    return wideType(builder_.getInt1Ty());
}

Value* LockstepEmitter::maskOf(Value* bits) {
    return builder_.CreateBitCast(bits, maskType());
}

Value* LockstepEmitter::maskBits(Value* mask) {
    return builder_.CreateBitCast(mask, builder_.getInt32Ty());
}

Value* LockstepEmitter::any(Value* mask) {
    return builder_.CreateIsNotNull(maskBits(mask));
}

// A mask of a block is a variable that LLVM makes a value. Each is live from the entry to its
// block, so the time for that grows with the square of the number of blocks; functions with many
// blocks keep masks in memory. LLVM does not split memory whose address goes through assembly.
void LockstepEmitter::makeMasks() {
    constexpr size_t kManyBlocks = 250;
    llvm::Type* const bits = builder_.getInt32Ty();
    if (source_.size() <= kManyBlocks)
        return;
    const uint64_t bytes = source_.size() * layout_.getTypeAllocSize(bits);
    llvm::AllocaInst* const memory = top_.CreateAlloca(llvm::ArrayType::get(bits, source_.size()));
    memory->setAlignment(llvm::Align(64));
    auto* type = llvm::FunctionType::get(builder_.getPtrTy(), {builder_.getPtrTy()}, false);
    maskMemory_ = top_.CreateCall(llvm::InlineAsm::get(type, "", "=r,0", false), {memory});
    top_.CreateMemSet(maskMemory_, top_.getInt8(0), bytes, llvm::Align(64));
}

Value* LockstepEmitter::maskPlace(BasicBlock* block) {
    Value*& made = masks_[block];
    if (made)
        return made;
    if (maskMemory_) {
        made = top_.CreateConstInBoundsGEP1_64(top_.getInt32Ty(), maskMemory_, masks_.size() - 1);
    } else {
        made = top_.CreateAlloca(maskType());
        top_.CreateStore(llvm::Constant::getNullValue(maskType()), made);
    }
    return made;
}

Value* LockstepEmitter::loadMask(BasicBlock* block) {
    Value* const place = maskPlace(block);
    return maskMemory_ ? maskOf(builder_.CreateLoad(builder_.getInt32Ty(), place))
                       : builder_.CreateLoad(maskType(), place);
}

void LockstepEmitter::storeMask(BasicBlock* block, Value* mask) {
    builder_.CreateStore(maskMemory_ ? maskBits(mask) : mask, maskPlace(block));
}

void LockstepEmitter::addToMask(BasicBlock* block, Value* mask) {
    storeMask(block, builder_.CreateOr(loadMask(block), mask));
}

void LockstepEmitter::begin() {
    auto* places = BasicBlock::Create(context_, "places", &result_);
    entry_ = BasicBlock::Create(context_, "entry", &result_);
    llvm::BranchInst::Create(entry_, places);
    top_.SetInsertPoint(places->getTerminator());
    builder_.SetInsertPoint(entry_);
    makeMasks();
    warp_ = result_.getArg(0);
    params_ = result_.getArg(1);
    llvm::Type* pointer = builder_.getPtrTy();
    threads_ = builder_.CreateLoad(pointer, field(offsetof(LockstepWarp, threads)));
    frame_ = builder_.CreateLoad(pointer, field(offsetof(LockstepWarp, frame)));
    ran_ = top_.CreateAlloca(builder_.getInt32Ty());
    jumps_ = top_.CreateAlloca(builder_.getInt32Ty());
    top_.CreateStore(builder_.getInt32(0), jumps_);
    spins_ = top_.CreateAlloca(builder_.getInt32Ty());
    top_.CreateStore(builder_.getInt32(0), spins_);
    for (Instruction& instruction : source_.getEntryBlock())
        if (auto* memory = dyn_cast<llvm::AllocaInst>(&instruction)) {
            const uint64_t bytes = llvm::alignTo(
                memory->getAllocationSize(layout_)->getFixedValue(), memory->getAlign());
            always_[memory] = builder_.CreateGEP(builder_.getInt8Ty(), framePlace(*memory),
                                                 lanes(builder_.getInt64Ty(), bytes));
        }
}

void LockstepEmitter::emitPrologue() {
    using devlib::KernelThread;
    for (Instruction* instruction : plan_.prologue()) {
        Value* made = nullptr;
        const int offset = plan_.fieldOf(*instruction);
        if (offset >= 0 && !isUniform(instruction)) {
            made = builder_.CreateAlignedLoad(wideType(instruction->getType()),
                                              field(arrayOfField(*instruction)), llvm::Align(64));
        } else if (offset >= 0) {
            made = builder_.CreateLoad(
                instruction->getType(),
                builder_.CreateInBoundsGEP(builder_.getInt8Ty(), threads_,
                                           builder_.getInt64(uint64_t(offset))));
        } else {
            Instruction* copy = instruction->clone();
            for (llvm::Use& use : copy->operands())
                use.set(scalar(use.get()));
            copy->setDebugLoc(llvm::DebugLoc());
            made = builder_.Insert(copy);
        }
        always_[instruction] = made;
    }
}

size_t LockstepEmitter::arrayOfField(const Instruction& load) const {
    const auto offset = size_t(plan_.fieldOf(load));
    return offset == offsetof(devlib::KernelThread, laneid)
               ? offsetof(LockstepWarp, laneid)
               : offset / 4 * sizeof(LockstepWarp::laneid);
}

// Lanes continue at the point where they stopped.
void LockstepEmitter::emitEntry() {
    auto* fresh = BasicBlock::Create(context_, "start", &result_);
    auto* jump = builder_.CreateSwitch(result_.getArg(2), fresh, unsigned(plan_.points().size()));
    builder_.SetInsertPoint(fresh);
    llvm::Type* bits = builder_.getInt32Ty();
    Value* asked = result_.getArg(3);
    builder_.CreateStore(asked, ran_);
    addToMask(&source_.getEntryBlock(), maskOf(asked));
    for (size_t i = 0; i < plan_.points().size(); ++i) {
        resumes_.push_back(BasicBlock::Create(context_, "resume", &result_));
        jump->addCase(llvm::ConstantInt::get(cast<llvm::IntegerType>(bits), i + 1), resumes_[i]);
        builder_.SetInsertPoint(resumes_[i]);
        resumeAt(i);
        resumes_[i] = builder_.GetInsertBlock();
    }
    builder_.SetInsertPoint(fresh);
}

// Lanes that continue from a point of this step enter here and skip the code before the step.
void LockstepEmitter::landAt(const Step& step) {
    BasicBlock* landing = nullptr;
    for (size_t i = 0; i < resumes_.size(); ++i) {
        BasicBlock* next = plan_.points()[i].next;
        if (step.loop ? !step.loop->contains(next) : step.block != next)
            continue;
        if (!landing) {
            landing = BasicBlock::Create(context_, "landing", &result_);
            builder_.CreateBr(landing);
            builder_.SetInsertPoint(landing);
        }
        llvm::BranchInst::Create(landing, resumes_[i]);
    }
}

void LockstepEmitter::resumeAt(size_t number) {
    const MeetingPoint& point = plan_.points()[number];
    if (byRuns_)
        return resumeByLane(point);
    Value* bits = result_.getArg(3);
    Value* first = nullptr;
    Value* mask = maskOf(bits);
    for (Instruction* value : point.live) {
        llvm::Type* stored = storedType(value->getType());
        Value* kept =
            builder_.CreateAlignedLoad(wideType(stored), framePlace(*value), llvm::Align(64));
        if (!isUniform(value)) {
            builder_.CreateStore(fromStored(kept, value->getType()), place(*value));
            continue;
        }
        // Lanes whose values differ from the first lane's run in a later call.
        if (!first)
            first = builder_.CreateZExt(firstLane(bits), builder_.getInt64Ty());
        Value* one =
            builder_.CreateLoad(stored, builder_.CreateGEP(stored, framePlace(*value), first));
        builder_.CreateStore(fromStored(one, value->getType()), place(*value));
        llvm::Type* number = builder_.getIntNTy(unsigned(layout_.getTypeSizeInBits(stored)));
        const auto asNumber = [&](Value* made, llvm::Type* type) {
            return stored->isPointerTy() ? builder_.CreatePtrToInt(made, type)
                                         : builder_.CreateBitCast(made, type);
        };
        Value* same =
            builder_.CreateICmpEQ(asNumber(kept, wideType(number)), splat(asNumber(one, number)));
        mask = select(mask, same, llvm::Constant::getNullValue(mask->getType()));
    }
    if (!point.call->use_empty()) {
        Value* result =
            builder_.CreateAlignedLoad(wideType(builder_.getInt64Ty()),
                                       field(offsetof(LockstepWarp, result)), llvm::Align(64));
        if (point.call->getType()->isIntegerTy(32))
            result = builder_.CreateTrunc(result, wideType(builder_.getInt32Ty()));
        store(*point.call, result, false, mask);
    }
    goOn(point, mask);
}

void LockstepEmitter::goOn(const MeetingPoint& point, Value* mask) {
    builder_.CreateStore(maskBits(mask), ran_);
    addToMask(point.next, mask);
}

void LockstepEmitter::finish() {
    builder_.SetCurrentDebugLocation(llvm::DebugLoc());
    builder_.CreateRet(builder_.CreateLoad(builder_.getInt32Ty(), ran_));
    if (scratch_)
        scratch_->setOperand(0, builder_.getInt64(scratchBytes_));
}

// ---- blocks -----------------------------------------------------------------------------------

void LockstepEmitter::emitSteps(const std::vector<Step>& steps) {
    for (const Step& step : steps)
        if (step.loop)
            emitLoop(step);
        else
            emitBlock(*step.block);
}

void LockstepEmitter::emitLoop(const Step& step) {
    builder_.SetCurrentDebugLocation(llvm::DebugLoc());
    BasicBlock* const head = step.loop->getHeader();
    Value* mask = loadMask(head);
    for (const MeetingPoint& point : plan_.points())
        if (step.loop->contains(point.next))
            mask = builder_.CreateOr(mask, loadMask(point.next));
    auto* loop = BasicBlock::Create(context_, "loop", &result_);
    auto* after = BasicBlock::Create(context_, "after", &result_);
    builder_.CreateCondBr(any(mask), loop, after);
    builder_.SetInsertPoint(loop);
    if (!byRuns_ && plan_.isSimpleLoop(*step.loop))
        emitSimpleBody(step);
    else
        emitSteps(step.body);
    builder_.SetCurrentDebugLocation(llvm::DebugLoc());
    builder_.CreateCondBr(any(loadMask(head)), loop, after);
    builder_.SetInsertPoint(after);
}

// A loop of one block has a version without masks, for all lanes together. The masked version is
// for fewer lanes, and for the iterations after some lanes have left.
void LockstepEmitter::emitSimpleBody(const Step& step) {
    BasicBlock& head = *step.loop->getHeader();
    auto* whole = BasicBlock::Create(context_, "whole", &result_);
    auto* some = BasicBlock::Create(context_, "part", &result_);
    auto* again = BasicBlock::Create(context_, "again", &result_);
    auto* last = BasicBlock::Create(context_, "last", &result_);
    auto* behind = BasicBlock::Create(context_, "behind", &result_);
    Value* bits = maskBits(loadMask(&head));
    builder_.CreateCondBr(builder_.CreateICmpEQ(bits, builder_.getInt32(~0u)), whole, some);

    builder_.SetInsertPoint(whole);
    here_.clear();
    block_ = &head;
    mask_ = llvm::Constant::getAllOnesValue(maskType());
    storeMask(&head, llvm::Constant::getNullValue(maskType()));
    emitBody(head);
    auto* branch = cast<llvm::BranchInst>(head.getTerminator());
    const bool isFirst = step.loop->contains(branch->getSuccessor(0));
    Value* stays = nullptr;
    if (isUniform(branch->getCondition())) {
        stays = scalar(branch->getCondition());
        if (!isFirst)
            stays = builder_.CreateNot(stays);
    } else {
        stays = builder_.CreateICmpEQ(maskBits(wide(branch->getCondition())),
                                      builder_.getInt32(isFirst ? ~0u : 0));
    }
    stays = builder_.CreateAnd(stays, builder_.CreateNot(hasJumped()));
    builder_.CreateCondBr(stays, again, last);
    const auto known = here_;
    builder_.SetInsertPoint(again);
    emitEdge(*step.loop->getLoopLatch(), head, mask_, nullptr);
    builder_.CreateBr(whole);
    here_ = known;
    builder_.SetInsertPoint(last);
    emitTerminator(head);
    builder_.CreateBr(behind);

    builder_.SetInsertPoint(some);
    isPart_ = true;
    emitSteps({step.body.front()});
    isPart_ = false;
    builder_.CreateBr(behind);
    builder_.SetInsertPoint(behind);
    emitSteps({step.body.begin() + 1, step.body.end()});
}

// Whether the block must be skipped if it has no lanes.
bool LockstepEmitter::needsGuard(BasicBlock& block) const {
    for (Instruction& instruction : block)
        if (!isa<llvm::PHINode, llvm::BranchInst>(instruction) &&
            !instruction.isDebugOrPseudoInst())
            return true;
    for (BasicBlock* successor : llvm::successors(&block)) {
        // A loop head's phi is not blended (emitEdge): lanes that continue inside the loop already
        // have their values.
        const llvm::Loop* loop = plan_.loops().getLoopFor(successor);
        const bool isEntered = loop && loop->getHeader() == successor && !loop->contains(&block);
        for (llvm::PHINode& phi : successor->phis())
            if (isEntered || isUniform(&phi))
                return true;
    }
    return false;
}

void LockstepEmitter::emitBlock(BasicBlock& block) {
    builder_.SetCurrentDebugLocation(llvm::DebugLoc());
    here_.clear();
    block_ = &block;
    mask_ = loadMask(&block);
    storeMask(&block, llvm::Constant::getNullValue(maskType()));
    if (!needsGuard(block)) {
        emitTerminator(block);
        return;
    }
    auto* body = BasicBlock::Create(context_, block.getName(), &result_);
    auto* skip = BasicBlock::Create(context_, "", &result_);
    builder_.CreateCondBr(any(mask_), body, skip);
    builder_.SetInsertPoint(body);
    if (const MeetingPoint* point = plan_.pointAt(&block)) {
        emitPoint(*point);
    } else {
        emitBody(block);
        emitTerminator(block);
    }
    builder_.SetCurrentDebugLocation(llvm::DebugLoc());
    builder_.CreateBr(skip);
    builder_.SetInsertPoint(skip);
}

void LockstepEmitter::emitBody(BasicBlock& block) {
    if (byRuns_)
        return emitRuns(block);
    findAddresses(block);
    for (Instruction& instruction : block) {
        if (isa<llvm::PHINode, llvm::AllocaInst>(instruction) || instruction.isTerminator() ||
            instruction.isDebugOrPseudoInst() || plan_.isInPrologue(&instruction))
            continue;
        builder_.SetCurrentDebugLocation(instruction.getDebugLoc());
        emitInstruction(instruction);
    }
}

void LockstepEmitter::emitTerminator(BasicBlock& block) {
    Instruction* end = block.getTerminator();
    builder_.SetCurrentDebugLocation(end->getDebugLoc());
    auto* branch = dyn_cast<llvm::BranchInst>(end);
    if (!branch) { // the end of these lanes
        Value* address = field(offsetof(LockstepWarp, live));
        Value* live = builder_.CreateLoad(builder_.getInt32Ty(), address);
        Value* left = builder_.CreateAnd(live, builder_.CreateNot(maskBits(mask_)));
        builder_.CreateStore(left, address);
        return;
    }
    if (branch->isUnconditional() || branch->getSuccessor(0) == branch->getSuccessor(1)) {
        emitEdge(block, *branch->getSuccessor(0), mask_, nullptr);
        return;
    }
    Value* none = llvm::Constant::getNullValue(mask_->getType());
    Value* condition = branch->getCondition();
    if (isUniform(condition)) {
        Value* taken = scalar(condition);
        Value* not_ = builder_.CreateNot(taken);
        emitEdge(block, *branch->getSuccessor(0), select(taken, mask_, none), taken);
        emitEdge(block, *branch->getSuccessor(1), select(taken, none, mask_), not_);
        return;
    }
    Value* taken = byRuns_ ? maskBits(wide(condition)) : wide(condition);
    const auto both = [&](Value* lanes) {
        return byRuns_ ? builder_.CreateAnd(mask_, lanes) : select(mask_, lanes, none);
    };
    Value* first = both(taken);
    Value* second = both(builder_.CreateNot(taken));
    emitEdge(block, *branch->getSuccessor(0), first, any(first));
    emitEdge(block, *branch->getSuccessor(1), second, any(second));
}

// taken: whether any lane takes the edge; null: all lanes take it.
void LockstepEmitter::emitEdge(BasicBlock& from, BasicBlock& to, Value* mask, Value* taken) {
    std::vector<std::pair<llvm::PHINode*, Value*>> moves, byLane; // parallel assignments
    for (llvm::PHINode& phi : to.phis()) {
        Value* incoming = phi.getIncomingValueForBlock(&from);
        if (isa<llvm::UndefValue>(incoming))
            continue;
        if (byRuns_ && !isUniform(&phi))
            byLane.emplace_back(&phi, incoming);
        else
            moves.emplace_back(&phi, isUniform(&phi) ? scalar(incoming) : wide(incoming));
    }
    moveByLane(byLane, mask);
    for (auto& [phi, made] : moves) {
        if (isUniform(phi) && taken)
            made = builder_.CreateSelect(taken, made, loadUniform(*phi));
        // All lanes of a loop are in one iteration, so other lanes no longer need the values at its
        // head.
        const bool isHead = plan_.loops().isLoopHeader(&to) && !plan_.outlivesLoop(*phi);
        store(*phi, made, !isHead, mask);
    }
    addToMask(&to, mask);
}

// ---- points -----------------------------------------------------------------------------------

void LockstepEmitter::emitPoint(const MeetingPoint& point) {
    const auto number = uint32_t(&point - plan_.points().data());
    const uint32_t what =
        (number + 1) | point.kind << devlib::kPointBits | point.mode << devlib::kModeShift;
    builder_.SetCurrentDebugLocation(point.call->getDebugLoc());
    if (byRuns_)
        return meetByLane(point, what);
    if (point.kind == devlib::kMeetBarrier || point.kind == devlib::kMeetPlain) {
        leaveAt(point, what);
        return;
    }
    const bool isPause = point.kind == devlib::kMeetPause;
    Value* here =
        isPause ? builder_.CreateNot(isPauseDue(point)) : canAnswer(point, maskBits(mask_));
    auto* answered = BasicBlock::Create(context_, "answered", &result_);
    auto* leave = BasicBlock::Create(context_, "leave", &result_);
    auto* join = BasicBlock::Create(context_, "", &result_);
    builder_.CreateCondBr(here, answered, leave);

    builder_.SetInsertPoint(leave);
    const auto known = here_;
    leaveAt(point, what);
    if (isPause && point.mode == 0) // no lane remains
        builder_.CreateRet(builder_.CreateLoad(builder_.getInt32Ty(), ran_));
    else
        builder_.CreateBr(join);

    here_ = known;
    builder_.SetInsertPoint(answered);
    if (point.kind == devlib::kMeetMatrix)
        answerByHelper(point); // in the lanes' memory
    else if (!point.call->use_empty())
        store(*point.call, answer(point), plan_.outlivesLoop(*point.call), mask_);
    emitEdge(*point.call->getParent(), *point.next, mask_, nullptr);
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
}

Value* LockstepEmitter::isPauseDue(const MeetingPoint& point) {
    constexpr uint32_t kSpins = 64;
    llvm::Type* word = builder_.getInt32Ty();
    if (point.mode == 1) {
        Value* spins = builder_.CreateAdd(builder_.CreateLoad(word, spins_), builder_.getInt32(1));
        builder_.CreateStore(spins, spins_);
        return builder_.CreateICmpUGE(spins, builder_.getInt32(kSpins));
    }
    // Only if all lanes of the warp are here, so that they stay together.
    Value* live = builder_.CreateLoad(word, field(offsetof(LockstepWarp, live)));
    Value* isWhole = builder_.CreateICmpEQ(maskBits(mask_), live);
    return builder_.CreateAnd(hasJumped(), isWhole);
}

// Whether the warp has accessed so many pages that the other warps should catch up.
Value* LockstepEmitter::hasJumped() {
    constexpr uint32_t kJumps = 12;
    return builder_.CreateICmpUGE(builder_.CreateLoad(builder_.getInt32Ty(), jumps_),
                                  builder_.getInt32(kJumps));
}

// Counts an address whose page differs from that of the previous iteration. Prefetches the
// following bytes, which the next warp probably reads soon.
void LockstepEmitter::countJump(Value* address, uint64_t bytes) {
    constexpr uint64_t kLine = 64;
    for (uint64_t offset = 0; offset < bytes * kLanes; offset += kLine)
        builder_.CreateIntrinsic(
            llvm::Intrinsic::prefetch, {builder_.getPtrTy()},
            {builder_.CreateIntToPtr(
                 builder_.CreateAdd(address, builder_.getInt64(bytes * kLanes + offset)),
                 builder_.getPtrTy()),
             builder_.getInt32(0), builder_.getInt32(3), builder_.getInt32(1)});
    constexpr uint64_t kPage = 4096;
    llvm::Type* type = builder_.getInt64Ty();
    llvm::AllocaInst* last = top_.CreateAlloca(type);
    top_.CreateStore(builder_.getInt64(0), last);
    Value* step = builder_.CreateSub(address, builder_.CreateLoad(type, last));
    Value* isFar = builder_.CreateICmpUGT(builder_.CreateAdd(step, builder_.getInt64(kPage)),
                                          builder_.getInt64(2 * kPage));
    Value* count = builder_.CreateLoad(builder_.getInt32Ty(), jumps_);
    builder_.CreateStore(address, last);
    builder_.CreateStore(
        builder_.CreateAdd(count, builder_.CreateZExt(isFar, builder_.getInt32Ty())), jumps_);
}

// The operands of the lanes at a point, with their places in LockstepWarp.
std::vector<LockstepEmitter::Operand> LockstepEmitter::operandsOf(const MeetingPoint& point) {
    const auto operand = [&](unsigned argument, unsigned number) {
        return Operand{point.call->getArgOperand(argument), builder_.getInt32Ty(),
                       offsetof(LockstepWarp, operand) + number * sizeof(LockstepWarp::laneid)};
    };
    const auto value = [&](unsigned argument) {
        return Operand{point.call->getArgOperand(argument), builder_.getInt64Ty(),
                       offsetof(LockstepWarp, value)};
    };
    switch (point.kind) {
    case devlib::kMeetPlain:
    case devlib::kMeetPause:
        return {};
    case devlib::kMeetBarrier:
        return {operand(1, 0), operand(2, 1), value(4)};
    case devlib::kMeetShuffle:
        return {value(2), operand(3, 1), operand(4, 2), operand(5, 0)};
    default:
        return {operand(2, 0), value(3)};
    }
}

void LockstepEmitter::storeOperands(const MeetingPoint& point) {
    for (const Operand& operand : operandsOf(point)) {
        Value* made = wide(operand.value);
        if (made->getType() != wideType(operand.type))
            made = builder_.CreateZExtOrTrunc(made, wideType(operand.type));
        storeMasked(made, field(operand.offset), llvm::Align(64), mask_);
    }
}

// Makes the lanes leave the function: stores their operands and the values needed later in the
// frame.
void LockstepEmitter::leaveAt(const MeetingPoint& point, uint32_t what) {
    // At a pause all live lanes of the warp are here, so the frame holds no values of other lanes.
    const bool isWhole = point.kind == devlib::kMeetPause && point.mode == 0;
    storeOperands(point);
    for (Instruction* value : point.live) {
        Value* made = toStored(wide(value));
        Value* place = framePlace(*value);
        if (isWhole)
            builder_.CreateAlignedStore(made, place, llvm::Align(64));
        else
            storeMasked(made, place, llvm::Align(64), mask_);
    }
    llvm::Type* word = builder_.getInt32Ty();
    if (!isWhole) // otherwise the launcher knows the point
        storeMasked(splat(builder_.getInt32(what)), field(offsetof(LockstepWarp, point)),
                    llvm::Align(64), mask_);
    Value* stops = field(offsetof(LockstepWarp, stops));
    builder_.CreateStore(builder_.CreateAdd(builder_.CreateLoad(word, stops), builder_.getInt32(1)),
                         stops);
    builder_.CreateStore(builder_.getInt32(what), field(offsetof(LockstepWarp, stopPoint)));
    builder_.CreateStore(maskBits(mask_), field(offsetof(LockstepWarp, stopLanes)));
}

} // namespace sunstone::compiler
