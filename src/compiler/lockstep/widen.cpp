// SPDX-License-Identifier: Apache-2.0
// LockstepEmitter: single instructions.
//
// Arithmetic has vector forms, which give the scalar result's bits in each lane. A load or store
// accesses memory for all lanes at once if their addresses are consecutive. The code tests this at
// run time, because indices take too many forms for a static answer. All other instructions run for
// one lane after the other, in order.
#include "compiler/lockstep/emit.h"

#include <llvm/Analysis/VectorUtils.h>
#include <llvm/IR/IntrinsicInst.h>

namespace sunstone::compiler {

using llvm::BasicBlock;
using llvm::cast;
using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;
using llvm::Value;

// Whether the instruction is an address in the thread's description whose only uses read fields.
// The prologue has loaded these fields.
bool LockstepEmitter::isFieldAddress(const Instruction& instruction) const {
    const auto* address = dyn_cast<llvm::GetElementPtrInst>(&instruction);
    return address && address->getPointerOperand() == source_.getArg(0) &&
           llvm::all_of(address->users(), [&](const llvm::User* user) {
               const auto* reader = cast<Instruction>(user);
               return plan_.fieldOf(*reader) >= 0 && plan_.isInPrologue(reader);
           });
}

void LockstepEmitter::emitInstruction(Instruction& instruction) {
    if (isFieldAddress(instruction))
        return;
    if (auto* intrinsic = dyn_cast<llvm::IntrinsicInst>(&instruction))
        if (intrinsic->isAssumeLikeIntrinsic())
            return;
    if (asksForLanes(instruction)) {
        Value* lanes = maskBits(mask_);
        return define(instruction, isUniform(&instruction) ? lanes : splat(lanes));
    }
    if (isUniform(&instruction))
        return emitUniform(instruction);
    if (late_.contains(&instruction))
        return;
    if (auto* store = dyn_cast<llvm::StoreInst>(&instruction)) {
        if (!widenStore(*store))
            laneByLane(instruction);
        return;
    }
    Value* made = widen(instruction);
    define(instruction, made ? made : laneByLane(instruction));
}

void LockstepEmitter::emitUniform(Instruction& instruction) {
    Instruction* copy = instruction.clone();
    for (llvm::Use& use : copy->operands())
        use.set(scalar(use.get()));
    define(instruction, builder_.Insert(copy));
}

namespace {

unsigned bitsOf(const llvm::Type* type) {
    return type->isIntegerTy() ? type->getIntegerBitWidth() : 0;
}

// Intrinsics for which the processor has instructions.
bool isSimpleIntrinsic(llvm::Intrinsic::ID id) {
    switch (id) {
    case llvm::Intrinsic::sqrt:
    case llvm::Intrinsic::fma:
    case llvm::Intrinsic::fmuladd:
    case llvm::Intrinsic::fabs:
    case llvm::Intrinsic::copysign:
    case llvm::Intrinsic::floor:
    case llvm::Intrinsic::ceil:
    case llvm::Intrinsic::trunc:
    case llvm::Intrinsic::rint:
    case llvm::Intrinsic::nearbyint:
    case llvm::Intrinsic::roundeven:
    case llvm::Intrinsic::minnum:
    case llvm::Intrinsic::maxnum:
    case llvm::Intrinsic::minimum:
    case llvm::Intrinsic::maximum:
    case llvm::Intrinsic::canonicalize:
    case llvm::Intrinsic::abs:
    case llvm::Intrinsic::smin:
    case llvm::Intrinsic::smax:
    case llvm::Intrinsic::umin:
    case llvm::Intrinsic::umax:
    case llvm::Intrinsic::bswap:
    case llvm::Intrinsic::bitreverse:
    case llvm::Intrinsic::ctpop:
    case llvm::Intrinsic::ctlz:
    case llvm::Intrinsic::cttz:
    case llvm::Intrinsic::fshl:
    case llvm::Intrinsic::fshr:
    case llvm::Intrinsic::sadd_sat:
    case llvm::Intrinsic::ssub_sat:
    case llvm::Intrinsic::uadd_sat:
    case llvm::Intrinsic::usub_sat:
    case llvm::Intrinsic::fptosi_sat:
    case llvm::Intrinsic::fptoui_sat:
        return llvm::isTriviallyVectorizable(id);
    default:
        return false;
    }
}

} // namespace

Value* LockstepEmitter::widen(Instruction& instruction) {
    if (bitsOf(instruction.getType()) > 64)
        return nullptr;
    for (const Value* used : instruction.operands())
        if (bitsOf(used->getType()) > 64)
            return nullptr;
    Value* made = nullptr;
    if (auto* binary = dyn_cast<llvm::BinaryOperator>(&instruction)) {
        if (binary->isIntDivRem() && !isa<llvm::ConstantInt>(binary->getOperand(1)))
            return widenDivision(*binary);
        if (binary->getOpcode() == Instruction::FRem)
            return nullptr;
        made = builder_.CreateBinOp(binary->getOpcode(), wide(binary->getOperand(0)),
                                    wide(binary->getOperand(1)));
    } else if (auto* compare = dyn_cast<llvm::CmpInst>(&instruction)) {
        made = builder_.CreateCmp(compare->getPredicate(), wide(compare->getOperand(0)),
                                  wide(compare->getOperand(1)));
    } else if (auto* conversion = dyn_cast<llvm::CastInst>(&instruction)) {
        made = builder_.CreateCast(conversion->getOpcode(), wide(conversion->getOperand(0)),
                                   wideType(conversion->getType()));
    } else if (auto* choice = dyn_cast<llvm::SelectInst>(&instruction)) {
        made = select(operand(choice->getCondition()), wide(choice->getTrueValue()),
                      wide(choice->getFalseValue()));
    } else if (isa<llvm::UnaryOperator>(instruction)) {
        made = builder_.CreateUnOp(cast<llvm::UnaryOperator>(instruction).getOpcode(),
                                   wide(instruction.getOperand(0)));
    } else if (isa<llvm::FreezeInst>(instruction)) {
        return builder_.CreateFreeze(wide(instruction.getOperand(0)));
    } else if (auto* address = dyn_cast<llvm::GetElementPtrInst>(&instruction)) {
        std::vector<Value*> indices;
        for (Value* index : address->indices())
            indices.push_back(operand(index));
        made = builder_.CreateGEP(address->getSourceElementType(),
                                  operand(address->getPointerOperand()), indices);
        // In each iteration of a loop, all lanes may have one address. After the loop, the lanes
        // have addresses of different iterations.
        return made->getType()->isVectorTy() ? made : splat(made);
    } else if (auto* part = dyn_cast<llvm::ExtractValueInst>(&instruction)) {
        return builder_.CreateExtractValue(here_.lookup(part->getAggregateOperand()),
                                           part->getIndices());
    } else if (auto* load = dyn_cast<llvm::LoadInst>(&instruction)) {
        return widenLoad(*load);
    } else if (auto* call = dyn_cast<llvm::CallInst>(&instruction)) {
        return widenCall(*call);
    } else {
        return nullptr;
    }
    if (auto* result = dyn_cast<Instruction>(made))
        result->copyIRFlags(&instruction);
    return made;
}

Value* LockstepEmitter::widenCall(llvm::CallInst& call) {
    const llvm::Intrinsic::ID id = call.getIntrinsicID();
    if (!isSimpleIntrinsic(id))
        return nullptr;
    std::vector<llvm::Type*> types;
    std::vector<Value*> arguments;
    if (llvm::isVectorIntrinsicWithOverloadTypeAtArg(id, -1))
        types.push_back(wideType(call.getType()));
    for (unsigned i = 0; i < call.arg_size(); ++i) {
        Value* argument = call.getArgOperand(i);
        if (llvm::isVectorIntrinsicWithScalarOpAtArg(id, i)) {
            if (!isUniform(argument))
                return nullptr;
            arguments.push_back(scalar(argument));
        } else {
            arguments.push_back(wide(argument));
        }
        if (llvm::isVectorIntrinsicWithOverloadTypeAtArg(id, int(i)))
            types.push_back(arguments.back()->getType());
    }
    llvm::CallInst* made = builder_.CreateIntrinsic(id, types, arguments);
    made->copyIRFlags(&call);
    return made;
}

// Inactive lanes must not divide by their stale values.
Value* LockstepEmitter::widenDivision(llvm::BinaryOperator& division) {
    if (!hasMasks_ || bitsOf(division.getType()) != 32)
        return nullptr;
    // Processors have no division of integer vectors. In double precision, the quotient of 32-bit
    // numbers is never rounded up to an integer.
    const bool isSigned =
        division.getOpcode() == Instruction::SDiv || division.getOpcode() == Instruction::SRem;
    const bool isQuotient =
        division.getOpcode() == Instruction::SDiv || division.getOpcode() == Instruction::UDiv;
    Value* first = wide(division.getOperand(0));
    Value* second = select(mask_, wide(division.getOperand(1)), splat(builder_.getInt32(1)));
    llvm::Type* real = wideType(builder_.getDoubleTy());
    const auto toReal = [&](Value* value) {
        return isSigned ? builder_.CreateSIToFP(value, real) : builder_.CreateUIToFP(value, real);
    };
    Value* exact = builder_.CreateFDiv(toReal(first), toReal(second));
    Value* quotient = isSigned ? builder_.CreateFPToSI(exact, first->getType())
                               : builder_.CreateFPToUI(exact, first->getType());
    if (isQuotient)
        return quotient;
    return builder_.CreateSub(first, builder_.CreateMul(quotient, second));
}

// ---- memory -----------------------------------------------------------------------------------

namespace {

bool isPlainType(const llvm::Type* type) {
    const unsigned bits = bitsOf(type);
    return type->isFloatTy() || type->isDoubleTy() || type->isHalfTy() || type->isPointerTy() ||
           bits == 8 || bits == 16 || bits == 32 || bits == 64;
}

} // namespace

bool LockstepEmitter::canGather(llvm::Type* type) const {
    return hasMasks_ && layout_.getTypeStoreSize(type) >= 4;
}

// Whether the access can be done for all lanes at once if their addresses are consecutive.
bool LockstepEmitter::isNearPossible(const Instruction& access) const {
    if (const auto* load = dyn_cast<llvm::LoadInst>(&access))
        return load->isSimple() && isPlainType(load->getType());
    const auto* store = dyn_cast<llvm::StoreInst>(&access);
    return store && store->isSimple() && isPlainType(store->getValueOperand()->getType());
}

LockstepEmitter::Nearness LockstepEmitter::nearnessOf(Value* pointer, uint64_t bytes) {
    if (const auto found = indexed_.find(pointer); found != indexed_.end())
        return nearnessOf(found->second, bytes);
    Nearness nearness;
    Value* numbers = builder_.CreatePtrToInt(wide(pointer), wideType(builder_.getInt64Ty()));
    Value* first = builder_.CreateExtractElement(numbers, uint64_t(0));
    Value* expected = builder_.CreateAdd(splat(first), lanes(builder_.getInt64Ty(), bytes));
    nearness.fits = builder_.CreateICmpEQ(numbers, expected);
    nearness.first = builder_.CreateIntToPtr(first, builder_.getPtrTy());
    return nearness;
}

// Emits a path for active lanes with consecutive addresses and one for other addresses. Stores by
// all lanes have a third path, because masked stores are slow.
Value* LockstepEmitter::byNearness(Value* address, uint64_t bytes, bool isWrite, const Near& near,
                                   const std::function<Value*()>& far) {
    const Nearness nearness = nearnessOf(address, bytes);
    if (!nearness.fits)
        return far();
    auto* join = BasicBlock::Create(context_, "", &result_);
    std::vector<std::pair<Value*, BasicBlock*>> ways;
    const auto goOn = [&](Value* made) {
        ways.emplace_back(made, builder_.GetInsertBlock());
        builder_.CreateBr(join);
    };
    const bool isWhole = isa<llvm::Constant>(mask_); // all lanes are known to be active
    const auto split = [&](Value* condition, bool isFull) {
        auto* yes = BasicBlock::Create(context_, isFull ? "full" : "some", &result_);
        auto* other = BasicBlock::Create(context_, "other", &result_);
        if (nearness.bound)
            condition = builder_.CreateAnd(condition, nearness.bound);
        builder_.CreateCondBr(condition, yes, other);
        builder_.SetInsertPoint(yes);
        if (plan_.pauses(*block_))
            countJump(builder_.CreatePtrToInt(nearness.first, builder_.getInt64Ty()), bytes);
        goOn(near(nearness.first, isFull));
        builder_.SetInsertPoint(other);
    };
    Value* all = builder_.getInt32(~0u);
    Value* fit = builder_.CreateICmpEQ(maskBits(nearness.fits), all);
    if (isWhole || !hasMasks_ || (isWrite && !isPart_))
        split(builder_.CreateAnd(fit, builder_.CreateICmpEQ(maskBits(mask_), all)), true);
    const auto known = here_; // values made on only one path are unavailable after the join
    if (hasMasks_ && !isWhole)
        split(builder_.CreateICmpEQ(
                  maskBits(select(mask_, nearness.fits,
                                  llvm::Constant::getAllOnesValue(mask_->getType()))),
                  all),
              false);
    goOn(far());
    here_ = known;
    builder_.SetInsertPoint(join);
    if (!ways[0].first)
        return nullptr;
    llvm::PHINode* made = builder_.CreatePHI(ways[0].first->getType(), unsigned(ways.size()));
    for (const auto& [value, from] : ways)
        made->addIncoming(value, from);
    return made;
}

Value* LockstepEmitter::widenLoad(llvm::LoadInst& load) {
    llvm::Type* type = load.getType();
    if (!isNearPossible(load))
        return nullptr;
    const auto near = [&](Value* first, bool isFull) -> Value* {
        if (isFull)
            return builder_.CreateAlignedLoad(wideType(type), first, load.getAlign());
        return builder_.CreateMaskedLoad(wideType(type), first, load.getAlign(), mask_);
    };
    const auto far = [&]() -> Value* {
        return canGather(type) ? builder_.CreateMaskedGather(wideType(type),
                                                             farAddresses(load.getPointerOperand()),
                                                             load.getAlign(), mask_)
                               : laneByLane(load);
    };
    return byNearness(load.getPointerOperand(), layout_.getTypeStoreSize(type), false, near, far);
}

bool LockstepEmitter::widenStore(llvm::StoreInst& store) {
    llvm::Type* type = store.getValueOperand()->getType();
    if (!isNearPossible(store))
        return false;
    if (isUniform(store.getPointerOperand())) {
        storeUniformAddress(store);
        return true;
    }
    Value* values = wide(store.getValueOperand());
    const auto near = [&](Value* first, bool isFull) -> Value* {
        if (isFull)
            builder_.CreateAlignedStore(values, first, store.getAlign());
        else
            builder_.CreateMaskedStore(values, first, store.getAlign(), mask_);
        return nullptr;
    };
    const auto far = [&]() -> Value* {
        if (canGather(type))
            builder_.CreateMaskedScatter(values, farAddresses(store.getPointerOperand()),
                                         store.getAlign(), mask_);
        else
            laneByLane(store);
        return nullptr;
    };
    byNearness(store.getPointerOperand(), layout_.getTypeStoreSize(type), true, near, far);
    return true;
}

// Stores the last active lane's value, as if the lanes wrote one after the other.
void LockstepEmitter::storeUniformAddress(llvm::StoreInst& store) {
    Value* leading =
        builder_.CreateBinaryIntrinsic(llvm::Intrinsic::ctlz, maskBits(mask_), builder_.getTrue());
    Value* last = builder_.CreateSub(builder_.getInt32(kLanes - 1), leading);
    Value* value = builder_.CreateExtractElement(wide(store.getValueOperand()), last);
    builder_.CreateAlignedStore(value, scalar(store.getPointerOperand()), store.getAlign());
}

// ---- lane by lane -----------------------------------------------------------------------------

void LockstepEmitter::forEachLane(const std::function<void(Value* lane)>& body) {
    Value* bits = maskBits(mask_);
    BasicBlock* before = builder_.GetInsertBlock();
    auto* loop = BasicBlock::Create(context_, "lanes", &result_);
    auto* after = BasicBlock::Create(context_, "", &result_);
    builder_.CreateBr(loop);
    builder_.SetInsertPoint(loop);
    llvm::PHINode* left = builder_.CreatePHI(builder_.getInt32Ty(), 2);
    left->addIncoming(bits, before);
    body(builder_.CreateZExt(firstLane(left), builder_.getInt64Ty()));
    Value* rest = builder_.CreateAnd(left, builder_.CreateSub(left, builder_.getInt32(1)));
    left->addIncoming(rest, builder_.GetInsertBlock());
    builder_.CreateCondBr(builder_.CreateIsNotNull(rest), loop, after);
    builder_.SetInsertPoint(after);
}

Value* LockstepEmitter::threadOf(Value* lane) {
    needsThreads_ = true;
    return builder_.CreateGEP(
        builder_.getInt8Ty(), threads_,
        builder_.CreateMul(lane, builder_.getInt64(sizeof(devlib::KernelThread))));
}

Value* LockstepEmitter::laneByLane(Instruction& instruction) {
    llvm::DenseMap<Value*, Value*> spilled;
    for (Value* used : instruction.operands()) {
        if (isUniform(used) || used == source_.getArg(0) || spilled.count(used))
            continue;
        Value* stored = toStored(wide(used));
        Value* memory = temporary(stored->getType());
        builder_.CreateAlignedStore(stored, memory, llvm::Align(64));
        spilled[used] = memory;
    }
    for (Value* used : instruction.operands()) // before the loop, which may run often
        if (isUniform(used))
            scalar(used);

    llvm::Type* type = instruction.getType();
    std::vector<llvm::Type*> parts;
    if (auto* structure = dyn_cast<llvm::StructType>(type))
        parts.assign(structure->element_begin(), structure->element_end());
    else if (!type->isVoidTy())
        parts.push_back(type);
    std::vector<Value*> results;
    for (llvm::Type* part : parts)
        results.push_back(temporary(wideType(storedType(part))));

    forEachLane([&](Value* lane) {
        Instruction* copy = instruction.clone();
        for (llvm::Use& use : copy->operands()) {
            Value* used = use.get();
            if (used == source_.getArg(0)) {
                use.set(threadOf(lane));
            } else if (isUniform(used)) {
                use.set(scalar(used));
            } else {
                llvm::Type* stored = storedType(used->getType());
                Value* loaded =
                    builder_.CreateLoad(stored, builder_.CreateGEP(stored, spilled[used], lane));
                use.set(fromStored(loaded, used->getType()));
            }
        }
        builder_.Insert(copy);
        for (size_t i = 0; i < parts.size(); ++i) {
            Value* part =
                type->isStructTy() ? builder_.CreateExtractValue(copy, unsigned(i)) : copy;
            llvm::Type* stored = storedType(parts[i]);
            builder_.CreateStore(toStored(part), builder_.CreateGEP(stored, results[i], lane));
        }
    });

    std::vector<Value*> made;
    for (size_t i = 0; i < parts.size(); ++i)
        made.push_back(fromStored(
            builder_.CreateAlignedLoad(wideType(storedType(parts[i])), results[i], llvm::Align(64)),
            parts[i]));
    if (made.empty() || !type->isStructTy())
        return made.empty() ? nullptr : made[0];
    std::vector<llvm::Type*> types;
    for (Value* part : made)
        types.push_back(part->getType());
    Value* all = llvm::PoisonValue::get(llvm::StructType::get(context_, types));
    for (size_t i = 0; i < made.size(); ++i)
        all = builder_.CreateInsertValue(all, made[i], unsigned(i));
    return all;
}

} // namespace sunstone::compiler
