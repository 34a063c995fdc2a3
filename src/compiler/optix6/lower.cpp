// SPDX-License-Identifier: Apache-2.0
// See optix6/lower.h. Offsets come from the structs of devlib/abi.h and devlib/classic.h.
//
// Variables become addresses: a slot of the program's block, a field of the state, or a copy in the
// program's frame. Two kinds have copies. The members of the current ray have another order in the
// state. Attributes in intersection programs change while a program holds their address; a report
// passes the copies on, because it exchanges the attribute blocks.
#include "compiler/optix6/lower.h"

#include "base/error.h"
#include "compiler/optix6/intrinsics.h"
#include "compiler/optix6/variables.h"
#include "compiler/translate/callable.h"
#include "compiler/translate/lowering.h"
#include "compiler/translate/stored_constant.h"
#include "devlib/classic.h"

#include <llvm/IR/MDBuilder.h>
#include <llvm/Transforms/Utils/Cloning.h>

#include <map>

namespace sunstone::compiler::optix6 {

namespace {

using devlib::BufferView;
using devlib::ClassicLaunch;
using devlib::ClassicRecord;

constexpr unsigned kRayBytes = 36;

devlib::ClassicBlock blockOf(ProgramKind kind) {
    return kind == ProgramKind::kAnyHit         ? devlib::kBlockAnyHit
           : kind == ProgramKind::kIntersection ? devlib::kBlockIntersection
           : kind == ProgramKind::kAttribute    ? devlib::kBlockAttribute
                                                : devlib::kBlockMain;
}

const char* describe(ProgramKind kind) {
    switch (kind) {
    case ProgramKind::kRaygen:
        return "ray generation program";
    case ProgramKind::kIntersection:
        return "intersection program";
    case ProgramKind::kAnyHit:
        return "any-hit program";
    case ProgramKind::kClosestHit:
        return "closest-hit program";
    case ProgramKind::kMiss:
        return "miss program";
    case ProgramKind::kException:
        return "exception program";
    case ProgramKind::kBounds:
        return "bounding box program";
    case ProgramKind::kAttribute:
        return "attribute program";
    case ProgramKind::kVisit:
        return "visit program";
    default:
        return "callable program";
    }
}

// Lowers the calls of one program.
class Lowering : public ProgramLowering {
public:
    // `program`: the function itself, or for a recursive function the program that calls it.
    Lowering(Unit& unit, llvm::Function& function, ProgramKind kind, llvm::Function& program)
        : ProgramLowering(unit, function, kind, kPrefix), program_(program),
          isHelper_(&program != &function) {}

    void run() {
        if (kind_ == ProgramKind::kNone &&
            (function_.use_empty() || function_.hasFnAttribute(kRecursive)))
            return dropCalls();
        const FunctionFacts& facts = unit_.facts().at(&function_);
        rules_ = &unit_.moduleRules(unit_.moduleNumber(*facts.module));
        if (kind_ != ProgramKind::kNone) { // as the shell lays them out: modules may share names
            const FunctionFacts& own = unit_.facts().at(&program_);
            variables_ = variablesOf({own.module}, own.function->name);
        }
        if (kind_ == ProgramKind::kDirectCallable)
            passDataToHelpers();
        if (isHelper_)
            return lowerAll();
        if (kind_ == ProgramKind::kIntersection)
            for (const DeviceVariable& variable : variables_.list)
                if (variable.use == VariableUse::kAttribute)
                    addAttributeCopy(variable);
        if (kind_ == ProgramKind::kDirectCallable)
            countCallables();
        if (kind_ == ProgramKind::kRaygen || kind_ == ProgramKind::kException ||
            kind_ == ProgramKind::kBounds)
            startCount();
        if (kind_ == ProgramKind::kBounds)
            endBoxes();
        lowerAll();
    }

private:
    // Removes the intrinsics from a function that has been inlined everywhere, or that has copies
    // for all programs.
    void dropCalls() {
        for (llvm::Instruction& each : llvm::make_early_inc_range(llvm::instructions(function_)))
            if (auto* call = llvm::dyn_cast<llvm::CallInst>(&each))
                if (call->getCalledFunction() && unit_.intrinsicOf(call->getCalledFunction())) {
                    call->replaceAllUsesWith(llvm::PoisonValue::get(call->getType()));
                    call->eraseFromParent();
                }
    }

    // Counts the nested calls of callables below a ray's program. A chain above the limit raises
    // the stack overflow exception.
    static constexpr size_t kCount = offsetof(RayState, payload) + devlib::kWordCallables * 4;
    void startCount() {
        if (unit_.rules().optix6.maxCallableDepth == 0)
            return;
        atEntry();
        store(state(), kCount, builder_.getInt32(0));
    }
    void countCallables() {
        if (unit_.rules().optix6.maxCallableDepth == 0)
            return;
        atEntry();
        Value* before = load(state(), kCount, word());
        store(state(), kCount, builder_.CreateAdd(before, builder_.getInt32(1)));
        Value* limit = builder_.getInt32(unit_.rules().optix6.maxCallableDepth - 1);
        llvm::Instruction* end = llvm::SplitBlockAndInsertIfThen(
            builder_.CreateICmpUGE(before, limit), &*builder_.GetInsertPoint(), false);
        builder_.SetInsertPoint(end);
        raise(builder_.getInt32(devlib::kCodeStackOverflow));
        for (llvm::BasicBlock& each : function_)
            if (auto* leave = llvm::dyn_cast<llvm::ReturnInst>(each.getTerminator())) {
                builder_.SetInsertPoint(leave);
                store(state(), kCount, before);
            }
    }

    // Builders drop primitives whose boxes exceed their number range. Programs return such boxes
    // for unbounded shapes, such as planes, so this clamps boxes to the range. Builders handle
    // inverted boxes and NaN.
    void endBoxes() {
        llvm::Type* type = builder_.getFloatTy();
        for (llvm::BasicBlock& each : function_) {
            auto* leave = llvm::dyn_cast<llvm::ReturnInst>(each.getTerminator());
            if (!leave)
                continue;
            builder_.SetInsertPoint(leave);
            Value* box = load(state(), offsetof(RayState, payloadMemory), pointer());
            Value *planes[6], *isOrdered = builder_.getTrue();
            for (size_t i = 0; i < 6; ++i)
                planes[i] = load(box, i * 4, type);
            for (size_t a = 0; a < 3; ++a)
                isOrdered =
                    builder_.CreateAnd(isOrdered, builder_.CreateFCmpOLE(planes[a], planes[a + 3]));
            Value* const most = llvm::ConstantFP::get(type, 0x1p99);
            Value* const least = llvm::ConstantFP::get(type, -0x1p99);
            for (size_t i = 0; i < 6; ++i) {
                Value* plane =
                    builder_.CreateSelect(builder_.CreateFCmpOLT(planes[i], most), planes[i], most);
                plane = builder_.CreateSelect(builder_.CreateFCmpOGT(plane, least), plane, least);
                store(box, i * 4, builder_.CreateSelect(isOrdered, plane, planes[i]));
            }
        }
    }

    void atEntry() {
        builder_.SetInsertPoint(&*function_.getEntryBlock().getFirstNonPHIOrDbgOrAlloca());
    }

    Value* params() { return loadOfLaunch(launch(), offsetof(LaunchState, params), pointer()); }
    Value* ofParams(size_t offset, llvm::Type* type) {
        return loadOfLaunch(params(), offset, type);
    }
    unsigned exceptions() const { return unit_.rules().optix6.exceptions; }
    Value* number(uint64_t value) { return builder_.getInt64(value); }

    // Loads an element of a table; element 0 is for all invalid indices.
    Value* ofTable(size_t table, size_t count, Value* index, llvm::Type* type) {
        Value* inside = builder_.CreateICmpULT(index, ofParams(count, word()));
        Value* safe = builder_.CreateSelect(inside, index, builder_.getInt32(0));
        Value* base = ofParams(table, pointer());
        Value* place =
            builder_.CreateInBoundsGEP(type, base, builder_.CreateZExt(safe, number(0)->getType()));
        return loadOfLaunch(place, 0, type);
    }

    void lower() override {
        if (kind_ != ProgramKind::kNone && !(intrinsic_->kinds & kindBit(kind_)))
            fault(ErrorCode::kInvalidFunctionUse,
                  message("cannot be used in ", describe(kind_), " \"",
                          sourceName(unit_.facts().at(&program_).function->name), "\""));
        requireProgramItself();
        switch (Op(intrinsic_->op)) {
        case Op::kTrace:
            return trace();
        case Op::kReport:
            return report();
        case Op::kIgnore:
            return endProgram(devlib::kIgnore);
        case Op::kTerminate:
            return endProgram(devlib::kTerminate);
        case Op::kChild:
            return visitChild();
        case Op::kThrow:
            return throwException();
        case Op::kUndefined:
            call_->eraseFromParent();
            return;
        default:
            return replace(value());
        }
    }

    // Recursive functions may not call intrinsics that end a program or use its frame.
    void requireProgramItself() const {
        const Op op = Op(intrinsic_->op);
        if (isHelper_ && (op == Op::kReport || op == Op::kPotential || op == Op::kIgnore ||
                          op == Op::kTerminate || op == Op::kChild))
            fault(ErrorCode::kInvalidFunctionUse, "cannot be used in a recursive function");
    }

    // Stores the program's own data before each call of a recursive function, because callables
    // called in between have overwritten the field.
    void passDataToHelpers() {
        std::vector<llvm::CallInst*> calls;
        for (llvm::Instruction& each : llvm::instructions(function_))
            if (auto* call = llvm::dyn_cast<llvm::CallInst>(&each))
                if (call->getCalledFunction() &&
                    call->getCalledFunction()->hasFnAttribute(kRecursive))
                    calls.push_back(call);
        for (llvm::CallInst* call : calls) {
            Value* own = data();
            builder_.SetInsertPoint(call);
            store(state(), offsetof(RayState, callableData), own);
        }
    }

    Value* value() {
        constexpr size_t kHit = offsetof(RayState, hit);
        llvm::Type* type = call_->getType();
        const size_t component = size_t(intrinsic_->number) * 4;
        switch (Op(intrinsic_->op)) {
        case Op::kVariable:
            return variable();
        case Op::kBuffer:
            return builder_.CreatePtrToInt(element(), type);
        case Op::kBufferSize:
            return bufferSize(type);
        case Op::kCallable:
            return builder_.CreateOr(
                builder_.CreateShl(builder_.CreateZExt(argument(0), type), kCallableIndexShift),
                kCallableTag);
        case Op::kPotential:
            return potential();
        case Op::kTransform:
            return transform(type);
        case Op::kMatrix:
            return matrix(type);
        case Op::kPrimitive:
            return loadInvariant(state(), kHit + offsetof(Hit, primitive), type);
        case Op::kTriangleHit:
            return triangleHit(type);
        case Op::kBarycentrics:
            return pair(kHit + offsetof(Hit, attributes), type);
        case Op::kExceptionCode:
            return exceptionCode();
        case Op::kPrintActive:
            return printActive();
        case Op::kTextureHandle:
            return textureHandle(type);
        case Op::kLaunchIndex:
            return loadInvariant(thread(), offsetof(ThreadState, index) + component, type);
        case Op::kLaunchDimension:
            return loadOfLaunch(launch(), offsetof(LaunchState, dimensions) + component, type);
        default:
            fault(ErrorCode::kInternal, "not lowered");
        }
    }

    Value* pair(size_t offset, llvm::Type* type) {
        Value* both = llvm::PoisonValue::get(type);
        for (unsigned i = 0; i < 2; ++i)
            both = builder_.CreateInsertValue(
                both, loadInvariant(state(), offset + i * 4, builder_.getFloatTy()), i);
        return both;
    }

    // ---- variables ----------------------------------------------------------------------------

    Value* variable() {
        const llvm::StringRef callee = call_->getCalledFunction()->getName();
        const std::string_view symbol(callee.data() + kVariablePrefix.size(),
                                      callee.size() - kVariablePrefix.size());
        const DeviceVariable* found = variables_.find(symbol);
        if (!found)
            failAt(ErrorCode::kInvalidFunctionUse, {}, "variable \"", sourceName(symbol),
                   "\" is used in a function that is called through its address");
        checkUse(*found);
        switch (found->use) {
        case VariableUse::kLaunchIndex:
            return address(thread(), offsetof(ThreadState, index));
        case VariableUse::kLaunchDim:
            return address(launch(), offsetof(LaunchState, dimensions));
        case VariableUse::kRay:
            return currentRay();
        case VariableUse::kDistance:
            return address(state(), offsetof(RayState, tmax));
        case VariableUse::kPayload:
            return payload(found->bytes);
        case VariableUse::kTime:
            return address(state(), offsetof(RayState, time));
        case VariableUse::kSubframe:
            return address(params(), offsetof(ClassicLaunch, subframe));
        case VariableUse::kAttribute:
            for (const AttributeCopy& copy : copies_)
                if (copy.symbol == symbol)
                    return copy.memory;
            if (isHelper_ && kind_ == ProgramKind::kIntersection)
                failAt(ErrorCode::kInvalidFunctionUse, found->declaration->location, "attribute \"",
                       found->name, "\" cannot be set in a recursive function");
            return address(attributeBlock(), placeOf(*found));
        default:
            return address(block(), found->slot);
        }
    }

    // If payload accesses are checked, compares the payload's size with the bytes that the program
    // accesses, because a payload may be smaller than the variable.
    Value* payload(uint32_t bytes) {
        Value* memory = loadInvariant(state(), offsetof(RayState, payloadMemory), pointer());
        if (!(exceptions() & devlib::kClassicPayload))
            return memory;
        Value* reached = builder_.getInt32(reachOf(call_, bytes));
        Value* size = loadInvariant(state(), offsetof(RayState, payloadCount), word());
        return insideOr(builder_.CreateICmpULE(reached, size), memory, reached,
                        [&] { return builder_.getInt32(devlib::kCodePayload); });
    }
    // The number of bytes from an address that loads and stores access; `otherwise` if the address
    // has other uses.
    uint32_t reachOf(const Value* address, uint32_t otherwise) const {
        const llvm::DataLayout& layout = unit_.module().getDataLayout();
        const auto bytesOf = [&](llvm::Type* type) {
            return uint64_t(layout.getTypeStoreSize(type).getFixedValue());
        };
        uint64_t reach = 0;
        for (const llvm::User* user : address->users()) {
            uint64_t offset = 0;
            if (const auto* load = llvm::dyn_cast<llvm::LoadInst>(user))
                reach = std::max(reach, bytesOf(load->getType()));
            else if (const auto* store = llvm::dyn_cast<llvm::StoreInst>(user);
                     store && store->getPointerOperand() == address)
                reach = std::max(reach, bytesOf(store->getValueOperand()->getType()));
            else if (isPlaceBehind(*user, offset) && offset < otherwise)
                reach = std::max(reach, offset + reachOf(user, uint32_t(otherwise - offset)));
            else
                return otherwise;
        }
        return uint32_t(std::min<uint64_t>(reach, otherwise));
    }
    // Whether the user computes an address at a constant offset from its operand.
    bool isPlaceBehind(const llvm::User& user, uint64_t& offset) const {
        if (llvm::isa<llvm::CastInst>(user))
            return user.getType()->isPointerTy() || user.getType()->isIntegerTy(64);
        if (const auto* sum = llvm::dyn_cast<llvm::BinaryOperator>(&user)) {
            const auto* constant = llvm::dyn_cast<llvm::ConstantInt>(sum->getOperand(1));
            if (sum->getOpcode() != llvm::Instruction::Add || !constant)
                return false;
            offset = constant->getZExtValue();
            return true;
        }
        const auto* place = llvm::dyn_cast<llvm::GetElementPtrInst>(&user);
        llvm::APInt bytes(64, 0);
        if (!place || !place->accumulateConstantOffset(unit_.module().getDataLayout(), bytes))
            return false;
        offset = bytes.getZExtValue();
        return true;
    }

    // Faults for a variable that has no value in a program of this kind.
    void checkUse(const DeviceVariable& variable) const {
        constexpr uint32_t kHits = kindBit(ProgramKind::kAnyHit) |
                                   kindBit(ProgramKind::kClosestHit) |
                                   kindBit(ProgramKind::kDirectCallable);
        uint32_t kinds = ~0u;
        if (variable.use == VariableUse::kAttribute)
            kinds = kHits | kindBit(ProgramKind::kIntersection) | kindBit(ProgramKind::kAttribute);
        if (variable.use == VariableUse::kPayload)
            kinds = kHits | kindBit(ProgramKind::kMiss) | kindBit(ProgramKind::kIntersection) |
                    kindBit(ProgramKind::kVisit) | kindBit(ProgramKind::kAttribute);
        if (!(kinds & kindBit(kind_)))
            failAt(ErrorCode::kInvalidFunctionUse, variable.declaration->location, "variable \"",
                   variable.name, "\" has a semantic that programs of this kind do not have");
    }

    // The data of the program's record. It is read on entry, because calls of callables overwrite
    // the field.
    Value* data() {
        if (!data_) {
            llvm::IRBuilder<>::InsertPointGuard guard(builder_);
            atEntry();
            const size_t field = kind_ == ProgramKind::kDirectCallable
                                     ? offsetof(RayState, callableData)
                                     : offsetof(RayState, sbtData);
            data_ = llvm::cast<llvm::Instruction>(load(state(), field, pointer()));
        }
        return data_;
    }
    // The block with the program's variables.
    Value* block() {
        if (!block_) {
            data();
            llvm::IRBuilder<>::InsertPointGuard guard(builder_);
            builder_.SetInsertPoint(data_->getNextNode());
            constexpr size_t kBlocks = offsetof(ClassicRecord, blocks) - sizeof(devlib::SbtHeader);
            block_ = loadOfLaunch(data_, kBlocks + blockOf(kind_) * sizeof(void*), pointer());
        }
        return block_;
    }

    Value* currentRay() {
        if (ray_)
            return ray_;
        ray_ = entryAlloca(llvm::ArrayType::get(builder_.getInt8Ty(), kRayBytes), 4);
        llvm::IRBuilder<>::InsertPointGuard guard(builder_);
        atEntry();
        const bool inObjectSpace = kind_ == ProgramKind::kIntersection ||
                                   kind_ == ProgramKind::kAnyHit || kind_ == ProgramKind::kVisit;
        const size_t origin =
            inObjectSpace ? offsetof(RayState, objectOrigin) : offsetof(RayState, worldOrigin);
        const size_t direction = inObjectSpace ? offsetof(RayState, objectDirection)
                                               : offsetof(RayState, worldDirection);
        const auto copy = [&](size_t to, size_t from) {
            store(ray_, to, loadInvariant(state(), from, word()));
        };
        for (size_t i = 0; i < 12; i += 4) {
            copy(i, origin + i);
            copy(12 + i, direction + i);
        }
        copy(24, offsetof(RayState, sbtOffset));
        copy(28, offsetof(RayState, tmin));
        copy(32, offsetof(RayState, payload) + devlib::kWordTmax * 4);
        return ray_;
    }

    uint32_t placeOf(const DeviceVariable& variable) const {
        for (const AttributePlace& place : rules_->attributes)
            if (place.name == variable.attribute)
                return place.offset;
        fail(ErrorCode::kInternal, "attribute \"", variable.attribute, "\" has no place");
    }

    Value* attributeBlock() {
        return load(state(), offsetof(RayState, attributeBlocks), pointer());
    }

    void addAttributeCopy(const DeviceVariable& variable) {
        auto* type = llvm::ArrayType::get(builder_.getInt8Ty(), variable.bytes);
        Value* memory = entryAlloca(type, 16);
        atEntry();
        builder_.CreateStore(llvm::Constant::getNullValue(type), memory);
        copies_.push_back({variable.symbol, memory, placeOf(variable), variable.bytes});
    }

    // ---- rays and hits ------------------------------------------------------------------------

    Value* attributeMemory() {
        if (!attributeMemory_)
            attributeMemory_ = entryAlloca(
                llvm::ArrayType::get(builder_.getInt8Ty(), 2 * unit_.rules().optix6.attributeBytes),
                16);
        return attributeMemory_;
    }

    // Operands: node, origin, direction, ray type, tmin, tmax, [time,] [mask, flags,] payload,
    // size.
    void trace() {
        const bool hasTime = intrinsic_->number & kTraceTime,
                   hasMask = intrinsic_->number & kTraceMask;
        const unsigned mask = hasTime ? 11 : 10, payload = mask + (hasMask ? 2 : 0);
        Value* ray = rayMemory();
        for (unsigned i = 0; i < 3; ++i) {
            store(ray, offsetof(RayState, worldOrigin) + i * 4u, argument(1 + i));
            store(ray, offsetof(RayState, worldDirection) + i * 4u, argument(4 + i));
        }
        Value* rayType = argument(7);
        Value* rayTypes = ofParams(offsetof(ClassicLaunch, rayTypes), word());
        store(ray, offsetof(RayState, tmin), argument(8));
        store(ray, offsetof(RayState, tmax), argument(9));
        store(ray, offsetof(RayState, payload) + devlib::kWordTmax * 4, argument(9));
        store(ray, offsetof(RayState, time),
              hasTime ? argument(10)
                      : load(state(), offsetof(RayState, time), builder_.getFloatTy()));
        store(ray, offsetof(RayState, visibilityMask),
              hasMask ? builder_.CreateAnd(argument(mask), builder_.getInt32(255))
                      : builder_.getInt32(255));
        store(ray, offsetof(RayState, rayFlags),
              hasMask ? builder_.CreateAnd(argument(mask + 1), builder_.getInt32(255))
                      : builder_.getInt32(0));
        store(ray, offsetof(RayState, sbtOffset), rayType);
        store(ray, offsetof(RayState, missIndex), rayType);
        store(ray, offsetof(RayState, sbtStride), rayTypes);
        store(ray, offsetof(RayState, handle), handleOf(argument(0), rayType, rayTypes));
        store(ray, offsetof(RayState, launch), launch());
        store(ray, offsetof(RayState, thread), thread());
        store(ray, offsetof(RayState, depth),
              builder_.CreateAdd(loadInvariant(state(), offsetof(RayState, depth), word()),
                                 builder_.getInt32(1)));
        if (unit_.rules().optix6.maxCallableDepth != 0)
            store(ray, kCount, builder_.getInt32(0));
        store(ray, offsetof(RayState, payloadType), builder_.getInt32(0));
        store(ray, offsetof(RayState, payloadCount), argument(payload + 1));
        store(ray, offsetof(RayState, payloadMemory),
              builder_.CreateIntToPtr(argument(payload), pointer()));
        Value* blocks = attributeMemory();
        store(ray, offsetof(RayState, attributeBlocks), blocks);
        store(ray, offsetof(RayState, attributeBlocks) + sizeof(void*),
              address(blocks, unit_.rules().optix6.attributeBytes));
        if (exceptions() & devlib::kClassicInvalidRay)
            callShared(offsetof(ClassicLaunch, checkRay), "checkClassicRay", builder_.getVoidTy(),
                       {state(), ray});
        auto* type = llvm::FunctionType::get(builder_.getVoidTy(), {pointer()}, false);
        builder_.CreateCall(type, launchFunction(offsetof(LaunchState, trace), "trace", type),
                            {ray});
        call_->eraseFromParent();
    }

    // The handle of a node id; 0 for an invalid id or ray type.
    Value* handleOf(Value* node, Value* rayType, Value* rayTypes) {
        Value* handle = ofTable(offsetof(ClassicLaunch, nodes), offsetof(ClassicLaunch, nodeCount),
                                node, builder_.getInt64Ty());
        return builder_.CreateSelect(builder_.CreateICmpULT(rayType, rayTypes), handle, number(0));
    }

    // Calls a function of the run-time: on CPUs one of the launch parameters, on GPUs by name.
    Value* callShared(size_t offset, const char* name, llvm::Type* result,
                      std::vector<Value*> operands) {
        std::vector<llvm::Type*> types;
        for (const Value* operand : operands)
            types.push_back(operand->getType());
        auto* type = llvm::FunctionType::get(result, types, false);
        Value* function =
            unit_.isGpu() ? launchFunction(0, name, type) : ofParams(offset, pointer());
        return builder_.CreateCall(type, function, operands);
    }

    Value* potential() {
        Value* t = argument(0);
        builder_.CreateStore(t, distance());
        Value* tmin = loadInvariant(state(), offsetof(RayState, tmin), builder_.getFloatTy());
        Value* tmax = load(state(), offsetof(RayState, tmax), builder_.getFloatTy());
        return builder_.CreateZExt(
            builder_.CreateAnd(builder_.CreateFCmpOGT(t, tmin), builder_.CreateFCmpOLT(t, tmax)),
            word());
    }
    // The distance of the potential hit.
    Value* distance() {
        if (!distance_) {
            distance_ = entryAlloca(builder_.getFloatTy(), 4);
            llvm::IRBuilder<>::InsertPointGuard guard(builder_);
            atEntry();
            builder_.CreateStore(llvm::ConstantFP::getNaN(builder_.getFloatTy()), distance_);
        }
        return distance_;
    }

    void report() {
        for (const AttributeCopy& copy : copies_)
            builder_.CreateMemCpy(address(attributeBlock(), copy.offset), llvm::Align(4),
                                  copy.memory, llvm::Align(16), copy.bytes);
        Value* t = builder_.CreateLoad(builder_.getFloatTy(), distance());
        replace(callReport(t, argument(0)));
    }

    void visitChild() {
        if (exceptions() & devlib::kClassicIndex)
            checkChild();
        auto* type = llvm::FunctionType::get(word(), {pointer(), word()}, false);
        Value* target = launchFunction(offsetof(LaunchState, visitChild), "visitChild", type);
        Value* result = builder_.CreateCall(type, target, {state(), argument(0)});
        endWhere(builder_.CreateICmpEQ(result, builder_.getInt32(devlib::kTerminate)),
                 devlib::kTerminate);
        call_->eraseFromParent();
    }

    // Raises an exception if the selector has no such child.
    void checkChild() {
        Value* node = loadInvariant(state(), offsetof(RayState, visited), pointer());
        Value* count = loadOfLaunch(node, offsetof(devlib::VisitNode, count), word());
        llvm::Instruction* end = llvm::SplitBlockAndInsertIfThen(
            builder_.CreateICmpUGE(argument(0), count), call_, false);
        builder_.SetInsertPoint(end);
        zeros(builder_.getInt32(0), builder_.getInt32(devlib::kCodeIndex));
        builder_.SetInsertPoint(call_);
    }

    // Ends the program with `result` if the condition holds.
    void endWhere(Value* condition, uint32_t result) {
        if (kind_ == ProgramKind::kNone)
            fault(ErrorCode::kInvalidFunctionUse,
                  "cannot be used in a function that is called through its address");
        llvm::Instruction* end = llvm::SplitBlockAndInsertIfThen(condition, call_, true);
        builder_.SetInsertPoint(end);
        llvm::Type* type = function_.getReturnType();
        if (type->isVoidTy())
            builder_.CreateRetVoid();
        else if (kind_ == ProgramKind::kDirectCallable)
            builder_.CreateRet(llvm::Constant::getNullValue(type));
        else
            builder_.CreateRet(builder_.getInt32(result));
        end->eraseFromParent();
        builder_.SetInsertPoint(call_);
    }

    Value* triangleHit(llvm::Type* type) {
        Value* kind = loadInvariant(state(), offsetof(RayState, hit) + offsetof(Hit, kind), word());
        Value* result =
            intrinsic_->number == kIsTriangle
                ? builder_.CreateICmpUGE(kind, builder_.getInt32(devlib::kHitTriangleFront))
                : builder_.CreateICmpEQ(kind, builder_.getInt32(intrinsic_->number == kIsFrontFace
                                                                    ? devlib::kHitTriangleFront
                                                                    : devlib::kHitTriangleBack));
        return builder_.CreateZExt(result, type);
    }

    // ---- buffers ------------------------------------------------------------------------------

    Value* view() {
        if (intrinsic_->number == kBufferId)
            return ofTable(offsetof(ClassicLaunch, buffers), offsetof(ClassicLaunch, bufferCount),
                           argument(0), pointer());
        return builder_.CreateIntToPtr(argument(0), pointer());
    }
    Value* extent(Value* view, unsigned dimension) {
        return loadOfLaunch(view, offsetof(BufferView, size) + dimension * 8,
                            builder_.getInt64Ty());
    }

    // On GPUs this is one load. Of two loads, the second would wait for the test of the first.
    std::pair<Value*, Value*> dataAndWidth(Value* view) {
        static_assert(offsetof(BufferView, data) == 0 && offsetof(BufferView, size) == 8);
        if (!unit_.isGpu())
            return {loadOfLaunch(view, 0, pointer()), extent(view, 0)};
        auto* both = llvm::cast<llvm::LoadInst>(
            loadOfLaunch(view, 0, llvm::FixedVectorType::get(builder_.getInt64Ty(), 2)));
        both->setAlignment(llvm::Align(alignof(BufferView)));
        return {
            builder_.CreateIntToPtr(builder_.CreateExtractElement(both, uint64_t(0)), pointer()),
            builder_.CreateExtractElement(both, uint64_t(1))};
    }

    // Operands: buffer, dimensions, bytes of an element, four indices.
    Value* element() {
        const llvm::ConstantInt* dimensions = storedConstant(argument(1));
        const unsigned count =
            dimensions ? unsigned(std::min<uint64_t>(dimensions->getZExtValue(), 3)) : 3;
        Value* buffer = view();
        Value* linear = argument(3);
        const auto [data, width] = dataAndWidth(buffer);
        Value* inside = builder_.CreateICmpULT(linear, width);
        Value* row = width;
        for (unsigned i = 1; i < count; ++i) {
            Value* index = argument(3 + i);
            inside = builder_.CreateAnd(inside, builder_.CreateICmpULT(index, extent(buffer, i)));
            linear = builder_.CreateAdd(linear, builder_.CreateMul(index, row));
            row = builder_.CreateMul(row, extent(buffer, i));
        }
        const llvm::ConstantInt* size = storedConstant(argument(2));
        Value* bytes = size ? builder_.getInt32(uint32_t(size->getZExtValue())) : argument(2);
        const bool byId = intrinsic_->number == kBufferId;
        if (byId || !hasFittingBuffers() || !size)
            inside = builder_.CreateAnd(
                inside,
                builder_.CreateICmpULE(
                    bytes, loadOfLaunch(buffer, offsetof(BufferView, elementBytes), word())));
        Value* place = builder_.CreateGEP(
            builder_.getInt8Ty(), data,
            builder_.CreateMul(linear, builder_.CreateZExt(bytes, builder_.getInt64Ty())));
        return insideOr(inside, place, bytes, [&]() -> Value* {
            Value* code = builder_.getInt32(devlib::kCodeBufferIndex);
            return byId ? builder_.CreateSelect(isNoBuffer(buffer),
                                                builder_.getInt32(devlib::kCodeBufferId), code)
                        : code;
        });
    }

    // Whether the view is the one for all invalid ids. Views of empty buffers have dimensions, this
    // one has none.
    Value* isNoBuffer(Value* view) {
        return builder_.CreateICmpEQ(loadOfLaunch(view, offsetof(BufferView, dimensions), word()),
                                     builder_.getInt32(0));
    }

    // Whether the elements of all bound buffers have the size that the program accesses. Launches
    // refuse other sizes if the program has one size for each buffer.
    bool hasFittingBuffers() const {
        return std::all_of(variables_.list.begin(), variables_.list.end(), [](const auto& each) {
            return each.use != VariableUse::kBuffer || each.elementBytes != 0;
        });
    }

    // Continues in a block for the rare case that the condition holds.
    llvm::Instruction* splitRarely(Value* condition) {
        llvm::MDNode* rare = llvm::MDBuilder(unit_.context()).createBranchWeights(1, 10000);
        llvm::Instruction* end = llvm::SplitBlockAndInsertIfThen(condition, call_, false, rare);
        builder_.SetInsertPoint(end);
        return end;
    }

    // Returns `place`, or outside the buffer an address of zeros. `code` emits the exception code
    // for that case.
    Value* insideOr(Value* inside, Value* place, Value* bytes, llvm::function_ref<Value*()> code) {
        llvm::BasicBlock* before = builder_.GetInsertBlock();
        llvm::Instruction* end = splitRarely(builder_.CreateNot(inside));
        Value* elsewhere = zeros(bytes, code());
        builder_.SetInsertPoint(call_);
        llvm::PHINode* result = builder_.CreatePHI(pointer(), 2);
        result->addIncoming(place, before);
        result->addIncoming(elsewhere, end->getParent());
        return result;
    }

    // Raises the exception `code` if it is enabled, then returns the address of zeros for one
    // access. On GPUs the zeros are in the frame, because threads have no other memory of their
    // own.
    Value* zeros(Value* bytes, Value* code) {
        if (!unit_.isGpu())
            return callShared(offsetof(ClassicLaunch, outside), "", pointer(),
                              {state(), bytes, code});
        const auto* size = llvm::dyn_cast<llvm::ConstantInt>(bytes);
        if (!size)
            fault(ErrorCode::kNotSupported, "the size of elements must be a constant on GPUs");
        if (exceptions())
            callShared(0, "outside", builder_.getVoidTy(), {state(), code});
        const uint64_t count = std::max<uint64_t>(16, llvm::alignTo(size->getZExtValue(), 16));
        Value*& memory = zeros_[count];
        if (!memory)
            memory = entryAlloca(llvm::ArrayType::get(builder_.getInt8Ty(), count), 16);
        builder_.CreateMemSet(memory, builder_.getInt8(0), count, llvm::Align(16));
        return memory;
    }

    Value* bufferSize(llvm::Type* type) {
        Value* buffer = view();
        if (intrinsic_->number == kBufferId && (exceptions() & devlib::kClassicBufferId)) {
            splitRarely(isNoBuffer(buffer));
            zeros(builder_.getInt32(16), builder_.getInt32(devlib::kCodeBufferId));
            builder_.SetInsertPoint(call_);
        }
        Value* all = llvm::PoisonValue::get(type);
        for (unsigned i = 0; i < 4; ++i)
            all = builder_.CreateInsertValue(all, i < 3 ? extent(buffer, i) : number(1), i);
        return all;
    }

    // ---- textures -----------------------------------------------------------------------------

    // The handle of a texture id; 0, which reads as zeros, for invalid ids.
    Value* textureHandle(llvm::Type* type) {
        Value* handle = ofTable(offsetof(ClassicLaunch, textures),
                                offsetof(ClassicLaunch, textureCount), argument(0), type);
        if (!(exceptions() & devlib::kClassicTextureId))
            return handle;
        splitRarely(builder_.CreateIsNull(handle));
        zeros(builder_.getInt32(16), builder_.getInt32(devlib::kCodeTextureId));
        builder_.SetInsertPoint(call_);
        return handle;
    }

    // ---- transforms ---------------------------------------------------------------------------

    // Rows of the 3x4 matrix of a kind (RT_WORLD_TO_OBJECT, RT_OBJECT_TO_WORLD). On GPUs each call
    // has rows of its own, whose lifetime endRows ends, so that frames do not keep them across
    // traces.
    Value* matrixRows(Value* toWorld) {
        if (!rows_ || unit_.isGpu())
            rows_ = entryAlloca(llvm::ArrayType::get(builder_.getFloatTy(), 12), 4);
        if (unit_.isGpu())
            builder_.CreateLifetimeStart(rows_);
        callShared(offsetof(ClassicLaunch, matrix), "matrix", builder_.getVoidTy(),
                   {state(), toWorld, rows_});
        return rows_;
    }
    void endRows() {
        if (unit_.isGpu())
            builder_.CreateLifetimeEnd(rows_);
    }
    Value* entry(Value* rows, unsigned row, unsigned column) {
        return load(rows, (row * 4 + column) * 4, builder_.getFloatTy());
    }

    Value* matrix(llvm::Type* type) {
        Value* rows = matrixRows(builder_.CreateAnd(argument(0), builder_.getInt32(1)));
        Value* all = llvm::PoisonValue::get(type);
        for (unsigned i = 0; i < 16; ++i)
            all = builder_.CreateInsertValue(all,
                                             i < 12
                                                 ? entry(rows, i / 4, i % 4)
                                                 : static_cast<Value*>(llvm::ConstantFP::get(
                                                       builder_.getFloatTy(), i == 15 ? 1.0 : 0.0)),
                                             i);
        endRows();
        return all;
    }

    // Operands: kind, x, y, z, w. Normals take the transpose of the opposite matrix.
    Value* transform(llvm::Type* type) {
        constexpr uint32_t kInverseTranspose = 0x1000;
        Value* kind = argument(0);
        Value* isNormal = builder_.CreateICmpNE(
            builder_.CreateAnd(kind, builder_.getInt32(kInverseTranspose)), builder_.getInt32(0));
        Value* rows = matrixRows(builder_.CreateAnd(
            builder_.CreateXor(kind, builder_.CreateZExt(isNormal, word())), builder_.getInt32(1)));
        Value* all = llvm::PoisonValue::get(type);
        for (unsigned i = 0; i < 3; ++i) {
            Value* plain = builder_.CreateFMul(entry(rows, i, 3), argument(4));
            Value* normal = llvm::ConstantFP::get(builder_.getFloatTy(), 0.0);
            for (unsigned k = 0; k < 3; ++k) {
                plain = builder_.CreateFAdd(
                    plain, builder_.CreateFMul(entry(rows, i, k), argument(1 + k)));
                normal = builder_.CreateFAdd(
                    normal, builder_.CreateFMul(entry(rows, k, i), argument(1 + k)));
            }
            all =
                builder_.CreateInsertValue(all, builder_.CreateSelect(isNormal, normal, plain), i);
        }
        endRows();
        return builder_.CreateInsertValue(all, argument(4), 3);
    }

    // ---- exceptions and printing --------------------------------------------------------------

    // Does nothing if user exceptions are off. A code outside the range of user exceptions raises
    // an exception of its own, if enabled.
    void throwException() {
        const bool throws = unit_.rules().exceptionFlags & devlib::kFlagUser;
        const bool checks = exceptions() & devlib::kClassicUserCode;
        if (!throws && !checks) {
            call_->eraseFromParent();
            return;
        }
        Value* code = argument(0);
        Value* isUser =
            builder_.CreateICmpULE(builder_.CreateSub(code, builder_.getInt32(devlib::kCodeUser)),
                                   builder_.getInt32(devlib::kCodeUserMax - devlib::kCodeUser));
        Value* raises = throws && checks ? builder_.getTrue()
                        : throws         ? isUser
                                         : builder_.CreateNot(isUser);
        store(thread(), offsetof(ThreadState, line), sourceLine());
        llvm::Instruction* end = llvm::SplitBlockAndInsertIfThen(raises, call_, false);
        builder_.SetInsertPoint(end);
        raise(builder_.CreateSelect(isUser, code, builder_.getInt32(devlib::kCodeUserCode)));
        call_->eraseFromParent();
    }
    void raise(Value* code) {
        auto* type = llvm::FunctionType::get(builder_.getVoidTy(),
                                             {pointer(), word(), word(), pointer()}, false);
        builder_.CreateCall(
            type, launchFunction(offsetof(LaunchState, throwException), "throwException", type),
            {state(), code, builder_.getInt32(0),
             llvm::ConstantPointerNull::get(builder_.getPtrTy())});
    }
    Value* sourceLine() {
        const llvm::StringRef source = callSite(unit_, *call_).source;
        if (source.empty())
            return llvm::ConstantPointerNull::get(builder_.getPtrTy());
        return builder_.CreateGlobalString(source);
    }

    // Converts the run-time's negative codes to those of the classic API.
    Value* exceptionCode() {
        Value* code = load(thread(), offsetof(ThreadState, exceptionCode), word());
        Value* result = builder_.CreateSelect(builder_.CreateICmpSLT(code, builder_.getInt32(0)),
                                              builder_.getInt32(devlib::kCodeInternal), code);
        const std::pair<int32_t, int32_t> pairs[] = {
            {devlib::kExceptionStackOverflow, devlib::kCodeStackOverflow},
            {devlib::kExceptionTraceDepth, devlib::kCodeTraceDepth}};
        for (const auto& [from, to] : pairs)
            result = builder_.CreateSelect(
                builder_.CreateICmpEQ(code, builder_.getInt32(uint32_t(from))),
                builder_.getInt32(uint32_t(to)), result);
        return result;
    }

    Value* printActive() {
        Value* active = builder_.CreateICmpNE(
            ofParams(offsetof(ClassicLaunch, printEnabled), word()), builder_.getInt32(0));
        for (unsigned i = 0; i < 3; ++i) {
            Value* wanted = ofParams(offsetof(ClassicLaunch, printIndex) + i * 4, word());
            Value* index = loadInvariant(thread(), offsetof(ThreadState, index) + i * 4, word());
            active = builder_.CreateAnd(
                active, builder_.CreateOr(builder_.CreateICmpSLT(wanted, builder_.getInt32(0)),
                                          builder_.CreateICmpEQ(wanted, index)));
        }
        return builder_.CreateZExt(active, word());
    }

    struct AttributeCopy {
        std::string_view symbol;
        Value* memory;
        uint32_t offset, bytes;
    };

    llvm::Function& program_;
    const bool isHelper_;
    ProgramVariables variables_;
    const ModuleRules* rules_ = nullptr;
    std::vector<AttributeCopy> copies_; // of an intersection program
    llvm::Instruction* data_ = nullptr;
    Value* block_ = nullptr;
    Value* ray_ = nullptr;
    Value* attributeMemory_ = nullptr;
    Value* distance_ = nullptr;
    Value* rows_ = nullptr;
    std::map<uint64_t, Value*> zeros_; // on GPUs, by bytes
};

// Gives each program its own copies of the recursive functions that it calls, since their variables
// are those of the program.
class Copies {
public:
    explicit Copies(Unit& unit) : unit_(unit), isOnly_(unit.kinds().size() == 1) {
        std::vector<llvm::Function*> programs; // in the module's order
        for (llvm::Function& function : unit.module())
            if (unit.kinds().count(&function) && !function.isDeclaration())
                programs.push_back(&function);
        for (llvm::Function* program : programs)
            addFor(*program);
    }
    // The program for which the function is a copy; null: not a copy.
    llvm::Function* programOf(llvm::Function& function) const {
        const auto found = programs_.find(&function);
        return found == programs_.end() ? nullptr : found->second;
    }

private:
    void addFor(llvm::Function& program) {
        std::map<llvm::Function*, llvm::Function*> copies;
        std::vector<llvm::Function*> queue = {&program};
        while (!queue.empty()) {
            llvm::Function& caller = *queue.back();
            queue.pop_back();
            for (llvm::Instruction& each : llvm::instructions(caller)) {
                auto* call = llvm::dyn_cast<llvm::CallInst>(&each);
                llvm::Function* callee = call ? call->getCalledFunction() : nullptr;
                if (!callee || !callee->hasFnAttribute(kRecursive) || unit_.kinds().count(callee) ||
                    programs_.count(callee))
                    continue;
                llvm::Function*& copy = copies[callee];
                if (!copy) {
                    copy = isOnly_ ? callee : copyOf(*callee);
                    programs_[copy] = &program;
                    queue.push_back(copy);
                }
                call->setCalledFunction(copy);
            }
        }
    }
    llvm::Function* copyOf(llvm::Function& function) {
        llvm::ValueToValueMapTy map;
        llvm::Function* copy = llvm::CloneFunction(&function, map);
        copy->setLinkage(llvm::GlobalValue::InternalLinkage);
        unit_.facts()[copy] = unit_.facts().at(&function);
        return copy;
    }

    Unit& unit_;
    const bool isOnly_; // a piece of code for CPUs has one program, which needs no copies
    std::map<llvm::Function*, llvm::Function*> programs_; // by copy
};

} // namespace

void lowerPrograms(Unit& unit) {
    const ProgramKinds& programs = unit.kinds();
    const Copies copies(unit);
    std::vector<llvm::Function*> functions;
    for (llvm::Function& function : unit.module())
        if (!function.isDeclaration() &&
            unit.facts().count(&function)) // other functions call no intrinsics
            functions.push_back(&function);
    for (llvm::Function* function : functions) {
        llvm::Function* const owner = copies.programOf(*function);
        const auto program = programs.find(owner ? owner : function);
        if (program == programs.end())
            Lowering(unit, *function, ProgramKind::kNone, *function).run();
        else
            Lowering(unit, *function, program->second, *program->first).run();
    }
}

} // namespace sunstone::compiler::optix6
