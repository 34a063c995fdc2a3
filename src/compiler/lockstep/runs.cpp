// SPDX-License-Identifier: Apache-2.0
// LockstepEmitter: code by runs, for long kernels.
//
// Vectors of 32 take several times as long to compile as code for one thread. Code by runs contains
// each instruction once: a run of instructions of a block executes for one lane after the other.
// The lanes stay in step at memory that other lanes may access: a run only reads such memory, or
// accesses it in a single instruction, which may write. Values used outside their run are arrays of
// 32 in memory.
#include "compiler/lockstep/emit.h"

#include <llvm/Analysis/ValueTracking.h>
#include <llvm/IR/IntrinsicInst.h>

#include <map>

namespace sunstone::compiler {

using devlib::LockstepWarp;
using llvm::BasicBlock;
using llvm::cast;
using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;
using llvm::Value;

namespace {

bool isLocal(const Value* address) {
    return isa<llvm::AllocaInst>(llvm::getUnderlyingObject(address, 0));
}

bool isLocalAccess(const Instruction& instruction) {
    if (const auto* load = dyn_cast<llvm::LoadInst>(&instruction))
        return load->isSimple() && isLocal(load->getPointerOperand());
    const auto* store = dyn_cast<llvm::StoreInst>(&instruction);
    return store && store->isSimple() && isLocal(store->getPointerOperand());
}

} // namespace

bool LockstepEmitter::Run::admits(const Instruction& instruction) const {
    if (isLocalAccess(instruction))
        return true;
    if (instruction.mayWriteToMemory() || instruction.isVolatile())
        return !reads && !writes;
    return !instruction.mayReadFromMemory() || !writes;
}

void LockstepEmitter::Run::note(const Instruction& instruction) {
    if (isLocalAccess(instruction))
        return;
    writes |= instruction.mayWriteToMemory() || instruction.isVolatile();
    reads |= instruction.mayReadFromMemory();
}

// Uniform values that live across points have places of 8 bytes in one array.
void LockstepEmitter::beginRuns() {
    size_t most = 0;
    for (const MeetingPoint& point : plan_.points()) {
        size_t count = 0;
        for (const Instruction* value : point.live)
            if (isUniform(value)) {
                shared_.try_emplace(value, shared_.size());
                ++count;
            }
        most = std::max(most, count);
    }
    keptPlace_ = frameBytes_;
    frameBytes_ += uint32_t(most * kLanes * sizeof(uint64_t));
    sharedPlace_ = temporary(llvm::ArrayType::get(builder_.getInt64Ty(), shared_.size()));
    top_.CreateMemSet(sharedPlace_, builder_.getInt8(0), shared_.size() * sizeof(uint64_t),
                      llvm::Align(64)); // smaller values leave bytes unset
    scratch_ = top_.CreateAlloca(builder_.getInt8Ty(), builder_.getInt64(0)); // grows
    scratch_->setAlignment(llvm::Align(64));
}

void LockstepEmitter::emitRuns(BasicBlock& block) {
    findSlots(block);
    Run run;
    for (Instruction& instruction : block) {
        if (isa<llvm::PHINode, llvm::AllocaInst>(instruction) || instruction.isTerminator() ||
            instruction.isDebugOrPseudoInst() || plan_.isInPrologue(&instruction) ||
            isFieldAddress(instruction))
            continue;
        if (const auto* intrinsic = dyn_cast<llvm::IntrinsicInst>(&instruction);
            intrinsic && intrinsic->isAssumeLikeIntrinsic())
            continue;
        if (!run.admits(instruction))
            emitRun(run);
        run.note(instruction);
        if (!isUniform(&instruction) && !asksForLanes(instruction)) {
            run.members.push_back(&instruction);
            continue;
        }
        builder_.SetCurrentDebugLocation(instruction.getDebugLoc());
        if (isUniform(&instruction))
            emitInstruction(instruction);
        else
            forEachLane([&](Value* lane) { setLane(instruction, mask_, lane); });
    }
    emitRun(run);
}

// Values used only by the block's own runs share memory: a place is free after the last use. The
// lanes of a run use a place one after another, so all its values have the same size.
void LockstepEmitter::findSlots(BasicBlock& block) {
    slots_.clear();
    llvm::DenseMap<const Instruction*, unsigned> order;
    for (const Instruction& instruction : block)
        order.try_emplace(&instruction, order.size());
    struct Place {
        uint64_t bytes = 0, offset = 0;
    };
    std::vector<std::vector<Place>> freed(block.size() + 2); // by the number of an instruction
    std::map<uint64_t, std::vector<uint64_t>> free;          // by the size of an element
    uint64_t end = 0;
    for (const Instruction& instruction : block) {
        const unsigned number = order.lookup(&instruction);
        for (const Place& place : freed[number])
            free[place.bytes].push_back(place.offset);
        if (!instruction.getType()->isSingleValueType() || isUniform(&instruction) ||
            isa<llvm::AllocaInst, llvm::PHINode>(instruction) || !isOfBlock(instruction))
            continue;
        unsigned last = number;
        for (const llvm::User* user : instruction.users())
            last = std::max(last, order.lookup(cast<Instruction>(user)));
        Place place{layout_.getTypeAllocSize(storedType(instruction.getType())), end};
        std::vector<uint64_t>& known = free[place.bytes];
        if (known.empty()) {
            end += llvm::alignTo(place.bytes * kLanes, 64);
        } else {
            place.offset = known.back();
            known.pop_back();
        }
        slots_[&instruction] = place.offset;
        freed[last + 1].push_back(place);
    }
    scratchBytes_ = std::max(scratchBytes_, end);
}

bool LockstepEmitter::isOfBlock(const Instruction& instruction) const {
    return llvm::all_of(instruction.users(), [&](const llvm::User* user) {
        const auto* other = cast<Instruction>(user);
        return other->getParent() == instruction.getParent() && !isa<llvm::PHINode>(other);
    });
}

// The array of a value that differs between lanes.
Value* LockstepEmitter::arrayOf(const Instruction& value) {
    const auto slot = slots_.find(&value);
    if (slot == slots_.end())
        return framePlace(value);
    return builder_.CreateInBoundsGEP(builder_.getInt8Ty(), scratch_,
                                      builder_.getInt64(slot->second));
}

// One lane's value.
Value* LockstepEmitter::ofLane(Value* value, Value* lane) {
    if (isUniform(value))
        return scalar(value);
    if (value == source_.getArg(0))
        return threadOf(lane);
    auto* instruction = cast<Instruction>(value);
    if (const auto* memory = dyn_cast<llvm::AllocaInst>(instruction)) {
        const uint64_t bytes =
            llvm::alignTo(memory->getAllocationSize(layout_)->getFixedValue(), memory->getAlign());
        return builder_.CreateGEP(builder_.getInt8Ty(), framePlace(*memory),
                                  builder_.CreateMul(lane, builder_.getInt64(bytes)));
    }
    if (plan_.isInPrologue(instruction))
        return builder_.CreateLoad(
            instruction->getType(),
            builder_.CreateGEP(instruction->getType(), field(arrayOfField(*instruction)), lane));
    llvm::Type* stored = storedType(value->getType());
    return fromStored(
        builder_.CreateLoad(stored, builder_.CreateGEP(stored, arrayOf(*instruction), lane)),
        value->getType());
}

void LockstepEmitter::setLane(const Instruction& value, Value* made, Value* lane) {
    llvm::Type* stored = storedType(value.getType());
    Value* array = arrayOf(value);
    builder_.CreateStore(toStored(made), builder_.CreateGEP(stored, array, lane));
}

void LockstepEmitter::emitRun(Run& run) {
    if (run.members.empty()) {
        run = {};
        return;
    }
    const llvm::SmallPtrSet<const Instruction*, 16> members(run.members.begin(), run.members.end());
    const auto isNeeded = [&](const Instruction& value) {
        return value.getType()->isSingleValueType() &&
               llvm::any_of(value.users(), [&](const llvm::User* user) {
                   const auto* other = cast<Instruction>(user);
                   return isa<llvm::PHINode>(other) || !members.contains(other);
               });
    };
    for (const Instruction* member : run.members) // before the loop, which runs for each lane
        for (Value* used : member->operands())
            if (isUniform(used))
                scalar(used);
    builder_.SetCurrentDebugLocation(run.members.front()->getDebugLoc());
    forEachLane([&](Value* lane) {
        llvm::DenseMap<const Value*, Value*> known;
        for (Instruction* member : run.members) {
            builder_.SetCurrentDebugLocation(member->getDebugLoc());
            Instruction* copy = member->clone();
            for (llvm::Use& use : copy->operands()) {
                Value*& made = known[use.get()];
                if (!made)
                    made = ofLane(use.get(), lane);
                use.set(made);
            }
            known[member] = builder_.Insert(copy);
            if (isNeeded(*member))
                setLane(*member, copy, lane);
        }
    });
    run = {};
}

// ---- points -----------------------------------------------------------------------------------

Value* LockstepEmitter::callRunTime(const char* name, llvm::Type* result,
                                    llvm::ArrayRef<Value*> arguments) {
    std::vector<llvm::Type*> types;
    for (const Value* argument : arguments)
        types.push_back(argument->getType());
    llvm::FunctionCallee function = result_.getParent()->getOrInsertFunction(
        name, llvm::FunctionType::get(result, types, false));
    cast<llvm::Function>(function.getCallee())->addFnAttr(llvm::Attribute::NoUnwind);
    return builder_.CreateCall(function, arguments);
}

// The run-time computes a warp function if all its lanes are here. Otherwise the lanes leave:
// values that differ between them stay in their arrays, uniform values are stored in the frame.
void LockstepEmitter::meetByLane(const MeetingPoint& point, uint32_t what) {
    if (point.kind == devlib::kMeetPause && point.mode == 0) // warps need not stay together
        return emitEdge(*point.call->getParent(), *point.next, mask_, nullptr);
    storeOperandsByLane(point);
    Value* met = callRunTime("sunstone_lockstep_meet", builder_.getInt32Ty(),
                             {warp_, builder_.getInt32(what), mask_});
    auto* leave = BasicBlock::Create(context_, "leave", &result_);
    auto* join = BasicBlock::Create(context_, "", &result_);
    const bool mayAnswer = point.kind != devlib::kMeetBarrier && point.kind != devlib::kMeetPlain;
    if (mayAnswer) {
        auto* answered = BasicBlock::Create(context_, "answered", &result_);
        builder_.CreateCondBr(builder_.CreateIsNotNull(met), answered, leave);
        builder_.SetInsertPoint(answered);
        takeResults(point);
        emitEdge(*point.call->getParent(), *point.next, mask_, nullptr);
        builder_.CreateBr(join);
    } else {
        builder_.CreateBr(leave);
    }
    builder_.SetInsertPoint(leave);
    moveShared(point, "sunstone_lockstep_keep", builder_.getVoidTy(), mask_);
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
}

void LockstepEmitter::storeOperandsByLane(const MeetingPoint& point) {
    const std::vector<Operand> operands = operandsOf(point);
    if (operands.empty())
        return;
    for (const Operand& operand : operands)
        if (isUniform(operand.value))
            scalar(operand.value);
    forEachLane([&](Value* lane) {
        for (const Operand& operand : operands)
            builder_.CreateStore(
                builder_.CreateZExtOrTrunc(ofLane(operand.value, lane), operand.type),
                builder_.CreateGEP(operand.type, field(operand.offset), lane));
    });
}

void LockstepEmitter::takeResults(const MeetingPoint& point) {
    if (point.call->use_empty())
        return;
    forEachLane([&](Value* lane) {
        llvm::Type* type = builder_.getInt64Ty();
        Value* results = field(offsetof(LockstepWarp, result));
        Value* result = builder_.CreateLoad(type, builder_.CreateGEP(type, results, lane));
        setLane(*point.call, builder_.CreateTrunc(result, point.call->getType()), lane);
    });
}

// The lanes that have the same uniform values go on; the others run in a later call.
void LockstepEmitter::resumeByLane(const MeetingPoint& point) {
    mask_ = result_.getArg(3);
    if (Value* alike = moveShared(point, "sunstone_lockstep_take", builder_.getInt32Ty(), mask_))
        mask_ = alike;
    takeResults(point);
    goOn(point, mask_);
}

// Returns null if there are no such values.
Value* LockstepEmitter::moveShared(const MeetingPoint& point, const char* function,
                                   llvm::Type* result, Value* bits) {
    std::vector<uint16_t> which;
    for (const Instruction* value : point.live)
        if (isUniform(value))
            which.push_back(uint16_t(shared_.lookup(value)));
    if (which.empty())
        return nullptr;
    llvm::Constant* table = llvm::ConstantDataArray::get(context_, which);
    auto* indices = new llvm::GlobalVariable(*result_.getParent(), table->getType(), true,
                                             llvm::GlobalValue::PrivateLinkage, table);
    return callRunTime(function, result,
                       {builder_.CreateConstGEP1_64(builder_.getInt8Ty(), frame_, keptPlace_),
                        sharedPlace_, indices, builder_.getInt32(uint32_t(which.size())), bits});
}

// ---- edges ------------------------------------------------------------------------------------

// Parallel assignments: all values are read before one is written.
void LockstepEmitter::moveByLane(const std::vector<std::pair<llvm::PHINode*, Value*>>& moves,
                                 Value* mask) {
    if (moves.empty())
        return;
    for (const auto& [phi, incoming] : moves)
        if (isUniform(incoming))
            scalar(incoming);
    auto* copy = BasicBlock::Create(context_, "move", &result_);
    auto* moved = BasicBlock::Create(context_, "", &result_);
    builder_.CreateCondBr(any(mask), copy, moved);
    builder_.SetInsertPoint(copy);
    Value* own = mask_;
    mask_ = mask;
    forEachLane([&](Value* lane) {
        std::vector<Value*> made;
        for (const auto& [phi, incoming] : moves)
            made.push_back(ofLane(incoming, lane));
        for (size_t i = 0; i < moves.size(); ++i)
            setLane(*moves[i].first, made[i], lane);
    });
    mask_ = own;
    builder_.CreateBr(moved);
    builder_.SetInsertPoint(moved);
}

} // namespace sunstone::compiler
