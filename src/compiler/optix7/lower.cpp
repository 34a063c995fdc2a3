// SPDX-License-Identifier: Apache-2.0
// See optix7/lower.h. Offsets come from the structs of devlib/abi.h.
#include "compiler/optix7/lower.h"

#include "base/error.h"
#include "compiler/optix7/program_kind.h"
#include "compiler/translate/callable.h"
#include "compiler/translate/lowering.h"
#include "compiler/translate/stored_constant.h"
#include "texture/device_functions.h"

namespace sunstone::compiler {

namespace {

using devlib::Hit;
using devlib::InstanceRecord;
using devlib::LaunchState;
using devlib::RayState;
using devlib::ThreadState;
using llvm::Value;

// Lowers the calls of one function.
class Lowering : public ProgramLowering {
public:
    Lowering(Unit& unit, llvm::Function& function, ProgramKind kind, const PayloadType* payload)
        : ProgramLowering(unit, function, kind, kIntrinsicPrefix), payload_(payload) {}

    void run() {
        lowerAll();
        if (unit_.debugExceptions() && hasPayload(kind_))
            checkPayload();
    }

private:
    // Calls a function of the run-time that looks into structures. On a GPU it takes the launch,
    // too, as it has to find out whether there is memory at all.
    Value* callAccessor(size_t offset, const char* name, llvm::Type* result,
                        std::vector<Value*> operands) {
        if (unit_.isGpu())
            operands.insert(operands.begin(), launch());
        std::vector<llvm::Type*> types;
        for (const Value* operand : operands)
            types.push_back(operand->getType());
        auto* signature = llvm::FunctionType::get(result, types, false);
        return builder_.CreateCall(signature, launchFunction(offset, name, signature), operands);
    }

    // The constant value of an operand; faults where it is not constant.
    uint32_t constant(unsigned index, const char* what) const {
        const llvm::ConstantInt* value = storedConstant(call_->getArgOperand(index + 1));
        if (!value)
            fault(ErrorCode::kInvalidFunctionArguments,
                  message("the ", what, " is not a constant"));
        return uint32_t(value->getZExtValue());
    }

    // The payload slot of an access, checked against the program's payload type.
    unsigned payloadSlot(bool fromOperand, PayloadAccess access) const {
        const uint32_t slot =
            fromOperand ? constant(0, "payload slot") : uint32_t(intrinsic_->number);
        const std::string problem =
            payloadProblem(kind_, slot, access, payload_, unit_.rules().optix7.numPayloadValues);
        if (!problem.empty())
            fault(ErrorCode::kInvalidPayloadAccess, problem);
        return slot;
    }

    // Programs check on entry that the trace call had the payload they are compiled for.
    void checkPayload() {
        builder_.SetInsertPoint(&*function_.getEntryBlock().getFirstNonPHIOrDbgOrAlloca());
        auto* type = llvm::FunctionType::get(builder_.getVoidTy(), {pointer(), word()}, false);
        Value* target = launchFunction(offsetof(LaunchState, checkPayload), "checkPayload", type);
        const uint32_t number = payload_ ? payloadNumber(*payload_) : 0;
        builder_.CreateCall(type, target, {state(), builder_.getInt32(number)});
    }

    // With debug exceptions: raises where the getter that follows has no answer.
    void checkAccess(devlib::AccessKind access, Value* handle, Value* first, Value* second) {
        if (!unit_.debugExceptions())
            return;
        auto* type = llvm::FunctionType::get(
            builder_.getVoidTy(), {pointer(), word(), builder_.getInt64Ty(), word(), word()},
            false);
        Value* target = launchFunction(offsetof(LaunchState, checkAccess), "checkAccess", type);
        builder_.CreateCall(type, target,
                            {state(), builder_.getInt32(access), handle, first, second});
    }

    // The place of the current call in the program's source as a C string, or null.
    Value* sourceLine() {
        const llvm::StringRef source = callSite(unit_, *call_).source;
        if (source.empty())
            return llvm::ConstantPointerNull::get(builder_.getPtrTy());
        return builder_.CreateGlobalString(source);
    }

    void lower() override {
        if (kind_ != ProgramKind::kNone && !(intrinsic_->kinds & kindBit(kind_)))
            fault(ErrorCode::kInvalidFunctionUse,
                  message("cannot be used in a ", prefixOf(kind_), " program"));
        switch (opOf(*intrinsic_)) {
        case IntrinsicOp::kTrace:
            return trace();
        case IntrinsicOp::kReport:
            return report();
        case IntrinsicOp::kFootprint:
            return footprint();
        case IntrinsicOp::kThrow:
            return throwException();
        case IntrinsicOp::kTerminate:
            return endProgram(devlib::kTerminate);
        case IntrinsicOp::kIgnore:
            return endProgram(devlib::kIgnore);
        case IntrinsicOp::kSetPayloadTypes: { // inspect has seen to the rest
            const std::string problem =
                unknownTypes(constant(0, "payload type mask"), *callSite(unit_, *call_).rules);
            if (!problem.empty())
                fault(ErrorCode::kPayloadTypeId, problem);
            call_->eraseFromParent();
            return;
        }
        case IntrinsicOp::kSetPayload: {
            const bool bySlot = intrinsic_->number < 0;
            const unsigned slot = payloadSlot(bySlot, PayloadAccess::kWrite);
            store(state(), offsetof(RayState, payload) + slot * 4u, argument(bySlot ? 1 : 0));
            call_->eraseFromParent();
            return;
        }
        default:
            return replace(getter());
        }
    }

    Value* getter() {
        llvm::Type* type = call_->getType();
        switch (opOf(*intrinsic_)) {
        case IntrinsicOp::kGetPayload:
            return load(state(),
                        offsetof(RayState, payload) +
                            payloadSlot(intrinsic_->number < 0, PayloadAccess::kRead) * 4u,
                        word());
        case IntrinsicOp::kUndefined:
            return builder_.getInt32(0);
        case IntrinsicOp::kRayField:
            return rayField(type);
        case IntrinsicOp::kLaunchIndex:
            return loadInvariant(thread(), offsetof(ThreadState, index) + number() * 4, type);
        case IntrinsicOp::kLaunchDimension:
            return loadOfLaunch(launch(), offsetof(LaunchState, dimensions) + number() * 4, type);
        case IntrinsicOp::kBarycentrics: {
            const size_t at = offsetof(RayState, hit) + offsetof(Hit, attributes);
            Value* pair = llvm::PoisonValue::get(type);
            for (unsigned i = 0; i < 2; ++i)
                pair = builder_.CreateInsertValue(
                    pair, loadInvariant(state(), at + i * 4, builder_.getFloatTy()), i);
            return pair;
        }
        case IntrinsicOp::kSbtData:
            return builder_.CreatePtrToInt(sbtData(), type);
        case IntrinsicOp::kExceptionCode:
            return load(thread(), offsetof(ThreadState, exceptionCode), type);
        case IntrinsicOp::kExceptionDetail:
            return load(thread(), offsetof(ThreadState, exceptionDetails) + number() * 4, type);
        case IntrinsicOp::kExceptionInfo:
            return exceptionInfo(type);
        case IntrinsicOp::kPrimitiveTypeOfKind:
            return primitiveType();
        case IntrinsicOp::kBackfaceOfKind:
            return builder_.CreateZExt(isBackface(argument(0)), type);
        case IntrinsicOp::kGasMotion:
            checkAccess(devlib::kAccessMotion, argument(0), builder_.getInt32(0),
                        builder_.getInt32(0));
            return gasMotion(type);
        case IntrinsicOp::kCallable:
            return callable();
        case IntrinsicOp::kTriangleVertices:
            return triangleVertices(type);
        case IntrinsicOp::kShapePoints:
            return shapePoints(type);
        case IntrinsicOp::kInstanceHandle: {
            checkAccess(devlib::kAccessInstance, argument(0), argument(1), builder_.getInt32(0));
            return callAccessor(offsetof(LaunchState, instanceHandle), "instanceHandle", type,
                                {argument(0), argument(1)});
        }
        default:
            return transformGetter(type);
        }
    }

    // Loads one field, or several that stand behind one another.
    Value* exceptionInfo(llvm::Type* type) {
        size_t offset = offsetof(ThreadState, exception) + number();
        if (!type->isStructTy())
            return load(thread(), offset, type);
        Value* all = llvm::PoisonValue::get(type);
        for (unsigned i = 0; i < type->getStructNumElements(); ++i) {
            llvm::Type* element = type->getStructElementType(i);
            const size_t size = element->isIntegerTy(64) ? 8 : 4;
            offset = (offset + size - 1) / size * size;
            all = builder_.CreateInsertValue(all, load(thread(), offset, element), i);
            offset += size;
        }
        return all;
    }

    // A member of GasMotion.
    Value* gasMotion(llvm::Type* type) {
        Value* memory = entryAlloca(
            llvm::ArrayType::get(word(), sizeof(devlib::GasMotion) / sizeof(uint32_t)), 4);
        callAccessor(offsetof(LaunchState, gasMotion), "gasMotion", builder_.getVoidTy(),
                     {argument(0), memory});
        return load(memory, number(), type);
    }

    // The program's time if the pipeline has motion blur, else 0.
    Value* timeOf(Value* time) {
        return unit_.rules().motionBlur ? time : llvm::ConstantFP::get(builder_.getFloatTy(), 0.0);
    }

    Value* shapePoints(llvm::Type* type) {
        checkAccess(devlib::kAccessVertices, argument(0), argument(1), argument(2));
        llvm::Type* number = builder_.getFloatTy();
        const unsigned count = llvm::cast<llvm::StructType>(type)->getNumElements();
        Value* memory = entryAlloca(llvm::ArrayType::get(number, count), 4);
        callAccessor(offsetof(LaunchState, shapePoints), "shapePoints", builder_.getVoidTy(),
                     {argument(0), builder_.getInt32(this->number()), argument(1), argument(2),
                      argument(3), memory});
        Value* all = llvm::PoisonValue::get(type);
        for (unsigned i = 0; i < count; ++i)
            all = builder_.CreateInsertValue(all, load(memory, i * 4u, number), i);
        return all;
    }

    Value* triangleVertices(llvm::Type* type) {
        checkAccess(devlib::kAccessVertices, argument(0), argument(1), argument(2));
        llvm::Type* number = builder_.getFloatTy();
        Value* memory = entryAlloca(llvm::ArrayType::get(number, 9), 4);
        callAccessor(offsetof(LaunchState, triangleVertices), "triangleVertices",
                     builder_.getVoidTy(),
                     {argument(0), argument(1), argument(2), timeOf(argument(3)), memory});
        Value* all = llvm::PoisonValue::get(type);
        for (unsigned i = 0; i < 9; ++i)
            all = builder_.CreateInsertValue(all, load(memory, i * 4u, number), i);
        return all;
    }

    size_t number() const { return size_t(intrinsic_->number); }

    Value* rayField(llvm::Type* type) {
        constexpr size_t kAttributes = offsetof(RayState, hit) + offsetof(Hit, attributes);
        if (number() >= kAttributes && number() < kAttributes + sizeof(Hit::attributes)) {
            const unsigned index = unsigned(number() - kAttributes) / 4;
            const unsigned limit = std::max(2u, unit_.rules().optix7.numAttributeValues);
            if (index >= limit)
                fault(ErrorCode::kInvalidAttributeAccess,
                      message("attribute ", index, " of ", limit,
                              " (numAttributeValues of the pipeline compile options)"));
        }
        // The only field that moves: reports shrink the interval.
        return number() == offsetof(RayState, tmax) ? load(state(), number(), type)
                                                    : loadInvariant(state(), number(), type);
    }

    // A callable's data is read on entry, because the callable's own calls overwrite the field.
    Value* sbtData() {
        const bool callable =
            kind_ == ProgramKind::kDirectCallable || kind_ == ProgramKind::kContinuationCallable;
        if (!callable)
            return loadInvariant(state(), offsetof(RayState, sbtData), pointer());
        if (!callableData_) {
            llvm::IRBuilder<>::InsertPointGuard guard(builder_);
            builder_.SetInsertPoint(&*function_.getEntryBlock().getFirstNonPHIOrDbgOrAlloca());
            callableData_ = load(state(), offsetof(RayState, callableData), pointer());
        }
        return callableData_;
    }

    Value* primitiveType() {
        Value* kind = argument(0);
        Value* isTriangle = builder_.CreateICmpEQ(builder_.CreateOr(kind, builder_.getInt32(1)),
                                                  builder_.getInt32(devlib::kHitTriangleBack));
        Value* isCustom = builder_.CreateICmpULT(kind, builder_.getInt32(128));
        Value* shape = builder_.CreateOr(builder_.CreateAnd(kind, 15u),
                                         builder_.getInt32(devlib::kPrimitiveCustom));
        return builder_.CreateSelect(
            isTriangle, builder_.getInt32(devlib::kPrimitiveTriangle),
            builder_.CreateSelect(isCustom, builder_.getInt32(devlib::kPrimitiveCustom), shape));
    }

    // For custom primitives, the lowest bit of the hit kind decides, as in the driver's library.
    Value* isBackface(Value* kind) {
        const uint32_t bits = devlib::kHitShape | devlib::kHitShapeBack;
        Value* isBackOfShape = builder_.CreateICmpEQ(
            builder_.CreateAnd(kind, builder_.getInt32(0xF0)), builder_.getInt32(bits));
        Value* isBackOfCustom = builder_.CreateICmpEQ(
            builder_.CreateAnd(kind, builder_.getInt32(~0x7Eu)), builder_.getInt32(1));
        return builder_.CreateOr(
            builder_.CreateOr(isBackOfShape, isBackOfCustom),
            builder_.CreateICmpEQ(kind, builder_.getInt32(devlib::kHitTriangleBack)));
    }

    Value* hasTag(Value* handle, uint64_t tag) {
        return builder_.CreateICmpEQ(builder_.CreateAnd(handle, uint64_t(devlib::kTagMask)),
                                     builder_.getInt64(tag));
    }
    Value* withoutTag(Value* handle) {
        return builder_.CreateAnd(handle, ~uint64_t(devlib::kTagMask));
    }

    Value* transformGetter(llvm::Type* type) {
        Value* operand = argument(0);
        switch (opOf(*intrinsic_)) {
        case IntrinsicOp::kTransformHandle: {
            checkAccess(devlib::kAccessTransformList, builder_.getInt64(0), operand,
                        builder_.getInt32(0));
            // The list has kMaxGraphDepth entries; an index past it stays inside the state.
            Value* index = builder_.CreateBinaryIntrinsic(
                llvm::Intrinsic::umin, operand, builder_.getInt32(devlib::kMaxGraphDepth - 1));
            Value* list = address(state(), offsetof(RayState, hit) + offsetof(Hit, transforms));
            return builder_.CreateAlignedLoad(
                type,
                builder_.CreateInBoundsGEP(type, list,
                                           builder_.CreateZExt(index, builder_.getInt64Ty())),
                llvm::Align(8));
        }
        case IntrinsicOp::kTransformType: {
            // Tags 3 to 6 are static, matrix, SRT, instance in the order of the API's 1 to 4.
            Value* tag = builder_.CreateTrunc(
                builder_.CreateAnd(operand, uint64_t(devlib::kTagMask)), word());
            Value* number = builder_.CreateSub(tag, builder_.getInt32(devlib::kTagStatic - 1));
            Value* known = builder_.CreateICmpULT(builder_.CreateSub(number, builder_.getInt32(1)),
                                                  builder_.getInt32(4));
            return builder_.CreateSelect(known, number, builder_.getInt32(0));
        }
        case IntrinsicOp::kTransformPointer:
            return builder_.CreateSelect(hasTag(operand, number()), withoutTag(operand),
                                         builder_.getInt64(0));
        case IntrinsicOp::kInstanceMatrix:
            return builder_.CreateSelect(
                hasTag(operand, devlib::kTagInstance),
                builder_.CreateAdd(withoutTag(operand), builder_.getInt64(number())),
                builder_.getInt64(0));
        case IntrinsicOp::kInstanceField: {
            Value* record = builder_.CreateSelect(
                hasTag(operand, devlib::kTagInstance),
                builder_.CreateIntToPtr(withoutTag(operand), pointer()), emptyInstance());
            return load(record, number(), type);
        }
        default:
            fault(ErrorCode::kInternal, "not lowered");
        }
    }

    // The record to read if the handle is not an instance.
    llvm::Constant* emptyInstance() {
        constexpr const char* kName = "sunstone.empty.instance";
        if (llvm::GlobalVariable* existing = unit_.module().getNamedGlobal(kName))
            return existing;
        llvm::Type* type = llvm::ArrayType::get(builder_.getInt8Ty(), sizeof(InstanceRecord));
        auto* variable =
            new llvm::GlobalVariable(unit_.module(), type, true, llvm::GlobalValue::InternalLinkage,
                                     llvm::Constant::getNullValue(type), kName);
        variable->setAlignment(llvm::Align(alignof(InstanceRecord)));
        return variable;
    }

    // The look-up of a callable is arithmetic only; see callable.h.
    Value* callable() {
        Value* index = builder_.CreateShl(builder_.CreateZExt(argument(0), call_->getType()),
                                          kCallableIndexShift);
        return builder_.CreateOr(index, number() ? kCallableTag | kContinuationTag : kCallableTag);
    }

    void report() {
        const unsigned count = unsigned(intrinsic_->number);
        const unsigned limit = std::max(2u, unit_.rules().optix7.numAttributeValues);
        if (count > limit)
            fault(ErrorCode::kInvalidAttributeAccess,
                  message(count, " attributes of ", limit,
                          " (numAttributeValues of the pipeline compile options)"));
        for (unsigned i = 0; i < count; ++i)
            store(state(), offsetof(RayState, reportAttributes) + i * 4u, argument(2 + i));
        replace(callReport(argument(0), argument(1)));
    }

    // Operands: texture, info, x, y, [level | 4 x gradient, coarse,] &singleMipLevel, &result.
    void footprint() {
        using texture::SampleOperands;
        const unsigned count = unsigned(intrinsic_->operands.size());
        auto* bytes = llvm::ArrayType::get(builder_.getInt8Ty(), sizeof(SampleOperands));
        Value* operands = entryAlloca(bytes, alignof(SampleOperands));
        builder_.CreateMemSet(operands, builder_.getInt8(0), sizeof(SampleOperands),
                              llvm::MaybeAlign(4));
        const auto put = [&](size_t offset, unsigned index) {
            store(operands, offset, argument(index));
        };
        put(offsetof(SampleOperands, position), 2);
        put(offsetof(SampleOperands, position) + 4, 3);
        Value* coarse = count > 6 ? argument(count - 3) : builder_.getInt32(0);
        if (number() & texture::kWithLevel)
            put(offsetof(SampleOperands, level), 4);
        if (number() & texture::kWithGradient)
            for (unsigned i = 0; i < 2; ++i) {
                put(offsetof(SampleOperands, dx) + i * 4, 4 + i);
                put(offsetof(SampleOperands, dy) + i * 4, 6 + i);
            }
        llvm::Type* wide = builder_.getInt64Ty();
        builder_.CreateCall(
            unit_.helper("sunstone_footprint", builder_.getVoidTy(),
                         {wide, word(), word(), pointer(), word(), pointer(), pointer()}, false),
            {argument(0), argument(1), builder_.getInt32(uint32_t(number())), operands, coarse,
             builder_.CreateIntToPtr(argument(count - 2), pointer()),
             builder_.CreateIntToPtr(argument(count - 1), pointer())});
        call_->eraseFromParent();
    }

    void throwException() {
        const unsigned count = unsigned(intrinsic_->number);
        Value* details = llvm::ConstantPointerNull::get(builder_.getPtrTy());
        if (count > 0) {
            details = entryAlloca(llvm::ArrayType::get(word(), 8), 4);
            for (unsigned i = 0; i < count; ++i)
                store(details, i * 4u, argument(1 + i));
        }
        auto* type = llvm::FunctionType::get(builder_.getVoidTy(),
                                             {pointer(), word(), word(), pointer()}, false);
        store(thread(), offsetof(ThreadState, line), sourceLine());
        Value* target =
            launchFunction(offsetof(LaunchState, throwException), "throwException", type);
        builder_.CreateCall(type, target,
                            {state(), argument(0), builder_.getInt32(count), details});
        finishBlock(function_.getReturnType()->isVoidTy()
                        ? nullptr
                        : llvm::Constant::getNullValue(function_.getReturnType()));
    }

    void trace() {
        const bool typed = intrinsic_->number < 0;
        // Operands: [type] handle 9×f mask flags sbtOffset sbtStride missIndex [count] payload...
        const unsigned base = typed ? 1 : 0;
        const uint32_t mask = typed ? constant(0, "payload type") : 0;
        const uint32_t count =
            typed ? constant(base + 15, "payload count") : uint32_t(intrinsic_->number);
        const unsigned firstPayload = base + 15 + (typed ? 1 : 0);
        const TracePayload payload =
            payloadOfTrace(mask, count, *callSite(unit_, *call_).rules, unit_.rules());
        if (payload.code != ErrorCode::kOk)
            fault(payload.code, payload.problem);
        // Words that no program reads or writes are not passed.
        const auto carried = [&](unsigned i, PayloadAccess access) {
            return !payload.type || allows(payload.type->words[i], ProgramKind::kNone, access);
        };
        Value* ray = rayMemory();
        const auto bits8 = [&](unsigned index) {
            return builder_.CreateAnd(argument(base + index), builder_.getInt32(255));
        };
        for (unsigned i = 0; i < 3; ++i) {
            store(ray, offsetof(RayState, worldOrigin) + i * 4u, argument(base + 1 + i));
            store(ray, offsetof(RayState, worldDirection) + i * 4u, argument(base + 4 + i));
        }
        store(ray, offsetof(RayState, tmin), argument(base + 7));
        store(ray, offsetof(RayState, tmax), argument(base + 8));
        store(ray, offsetof(RayState, time), timeOf(argument(base + 9)));
        store(ray, offsetof(RayState, visibilityMask), bits8(10));
        store(ray, offsetof(RayState, rayFlags),
              builder_.CreateAnd(argument(base + 11), builder_.getInt32(0xffff)));
        store(ray, offsetof(RayState, sbtOffset), bits8(12));
        store(ray, offsetof(RayState, sbtStride), bits8(13));
        store(ray, offsetof(RayState, missIndex), argument(base + 14));
        store(ray, offsetof(RayState, handle), argument(base));
        Value* launchPointer = launch();
        store(ray, offsetof(RayState, launch), launchPointer);
        store(ray, offsetof(RayState, thread), thread());
        store(ray, offsetof(RayState, depth),
              builder_.CreateAdd(loadInvariant(state(), offsetof(RayState, depth), word()),
                                 builder_.getInt32(1)));
        store(ray, offsetof(RayState, payloadType),
              builder_.getInt32(payload.type ? payloadNumber(*payload.type) : 0));
        store(ray, offsetof(RayState, payloadCount), builder_.getInt32(count));
        for (unsigned i = 0; i < count; ++i)
            if (carried(i, PayloadAccess::kWrite))
                store(ray, offsetof(RayState, payload) + i * 4u, argument(firstPayload + i));
        if (unit_.debugExceptions())
            store(ray, offsetof(RayState, line), sourceLine());

        auto* traceType = llvm::FunctionType::get(builder_.getVoidTy(), {pointer()}, false);
        Value* target = unit_.launchFunction(builder_, launchPointer, offsetof(LaunchState, trace),
                                             "trace", traceType);
        builder_.CreateCall(traceType, target, {ray});

        std::vector<Value*> results(count);
        for (unsigned i = 0; i < count; ++i)
            results[i] = carried(i, PayloadAccess::kRead)
                             ? load(ray, offsetof(RayState, payload) + i * 4u, word())
                             : argument(firstPayload + i);
        finishTrace(results);
    }

    // Returns the payload to the caller of the trace; words past the count read as zero.
    void finishTrace(const std::vector<Value*>& results) {
        const auto valueOf = [&](unsigned index) {
            return index < results.size() ? results[index]
                                          : static_cast<Value*>(builder_.getInt32(0));
        };
        if (call_->getType()->isIntegerTy()) {
            call_->replaceAllUsesWith(valueOf(0));
        } else if (!call_->getType()->isVoidTy()) {
            for (llvm::User* user : llvm::make_early_inc_range(call_->users())) {
                auto* extract = llvm::dyn_cast<llvm::ExtractValueInst>(user);
                if (!extract)
                    continue;
                extract->replaceAllUsesWith(valueOf(extract->getIndices()[0]));
                extract->eraseFromParent();
            }
            if (!call_->use_empty()) { // passed on as a whole, after merging of blocks
                Value* all = llvm::PoisonValue::get(call_->getType());
                for (unsigned i = 0; i < call_->getType()->getStructNumElements(); ++i)
                    all = builder_.CreateInsertValue(all, valueOf(i), i);
                call_->replaceAllUsesWith(all);
            }
        }
        call_->eraseFromParent();
    }

    const PayloadType* payload_; // that the program is compiled for; null: untyped
    Value* callableData_ = nullptr;
};

} // namespace

void lowerIntrinsics(Unit& unit, const ProgramPayloads& payloads) {
    const ProgramKinds& programs = unit.kinds();
    for (llvm::Function& function : unit.module()) {
        if (function.isDeclaration())
            continue;
        const auto program = programs.find(&function);
        const auto payload = payloads.find(&function);
        Lowering(unit, function, program == programs.end() ? ProgramKind::kNone : program->second,
                 payload == payloads.end() ? nullptr : payload->second)
            .run();
    }
}

} // namespace sunstone::compiler
