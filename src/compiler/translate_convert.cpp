// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: cvt in all its forms. Source: PTX ISA manual, "cvt".
#include "compiler/function_translator.h"

namespace sunstone::compiler {

namespace {

bool isHalf(ptx::Type type) {
    return type == ptx::Type::kF16;
}
bool isBrain(ptx::Type type) {
    return type == ptx::Type::kBF16;
}

} // namespace

void FunctionTranslator::convert(const ptx::Instruction& instruction) {
    if (instruction.types.size() < 2)
        rejectForm(instruction);
    if (instruction.operands.size() == 3)
        return convertPacked(instruction);
    operandCount(instruction, 2, 2);
    const ptx::Type to = instruction.types[0], from = instruction.types[1];
    if (instruction.types.size() > 2 || ptx::sizeOf(to) == 0 || to == ptx::Type::kF16x2 ||
        to == ptx::Type::kBF16x2 || from == ptx::Type::kF16x2 || from == ptx::Type::kBF16x2)
        rejectForm(instruction);

    Value* value = nullptr;
    if (isBrain(from)) { // the upper half of a float
        Value* bits = coerce(readInt(instruction.operands[1], 16), intType(32));
        value = builder_.CreateBitCast(builder_.CreateShl(bits, 16), builder_.getFloatTy());
    } else {
        value = read(instruction.operands[1], from);
    }
    const ptx::Type source = isBrain(from) ? ptx::Type::kF32 : from;
    if (instruction.has("ftz") && from == ptx::Type::kF32)
        value = flush(value);
    Value* result = nullptr;
    if (ptx::isFloat(from) && ptx::isFloat(to))
        result = floatToFloat(instruction, value, source, to);
    else if (ptx::isFloat(from))
        result = floatToInt(instruction, value, to);
    else if (ptx::isFloat(to))
        result = intToFloat(instruction, value, from, to);
    else
        result = intToInt(instruction, value, from, to);
    write(instruction.operands[0], result, ptx::isSigned(to));
}

Value* FunctionTranslator::roundToIntegral(Value* value, const ptx::Instruction& instruction) {
    if (instruction.has("rni"))
        return intrinsicCall(llvm::Intrinsic::roundeven, {value});
    if (instruction.has("rzi"))
        return intrinsicCall(llvm::Intrinsic::trunc, {value});
    if (instruction.has("rmi"))
        return intrinsicCall(llvm::Intrinsic::floor, {value});
    if (instruction.has("rpi"))
        return intrinsicCall(llvm::Intrinsic::ceil, {value});
    return value;
}

Value* FunctionTranslator::floatToFloat(const ptx::Instruction& instruction, Value* value,
                                        ptx::Type from, ptx::Type to) {
    value = roundToIntegral(value, instruction);
    const Rounding rounding = roundingOf(instruction);
    const unsigned fromBytes = ptx::sizeOf(from), toBytes = ptx::sizeOf(to);
    llvm::Type* target = typeOf(to);
    const bool narrows = toBytes < fromBytes;
    if (isBrain(to)) {
        if (instruction.has("sat"))
            value = saturate(value);
        if (instruction.has("relu"))
            value = pickMinimum(value, llvm::ConstantFP::get(value->getType(), 0.0), true, true);
        if (from == ptx::Type::kF64)
            reject(instruction, ErrorCode::kNotSupported, "bfloat16 from .f64 is not available");
        if (isHalf(from))
            value = builder_.CreateFPExt(value, builder_.getFloatTy());
        return builder_.CreateCall(unit_.helper(rounding == Rounding::kZero
                                                    ? "sunstone_bf16_rz_f32"
                                                    : "sunstone_bf16_rn_f32",
                                                intType(16), {builder_.getFloatTy()}),
                                   {value});
    }
    if (toBytes > fromBytes) {
        value = builder_.CreateFPExt(value, target);
    } else if (narrows && rounding == Rounding::kNearest) {
        value = builder_.CreateFPTrunc(value, target);
    } else if (narrows) {
        static const char* const kNames[] = {"", "rz", "rm", "rp"};
        const std::string name =
            message("sunstone_cvt_", kNames[unsigned(rounding)], isHalf(to) ? "_f16" : "_f32",
                    from == ptx::Type::kF64 ? "_f64" : "_f32");
        llvm::Type* returned = isHalf(to) ? intType(16) : target;
        value = coerce(
            builder_.CreateCall(unit_.helper(name.c_str(), returned, {typeOf(from)}), {value}),
            target);
    }
    if (instruction.has("ftz") && to == ptx::Type::kF32)
        value = flush(value);
    if (instruction.has("sat"))
        value = saturate(value);
    if (instruction.has("relu"))
        value = pickMinimum(value, llvm::ConstantFP::get(value->getType(), 0.0), true, true);
    return value;
}

// Out-of-range numbers go to the nearest end of the range, NaN to 0.
Value* FunctionTranslator::floatToInt(const ptx::Instruction& instruction, Value* value,
                                      ptx::Type to) {
    if (!instruction.has("rzi")) // trunc is part of the conversion
        value = roundToIntegral(value, instruction);
    llvm::Type* target = intType(bitsOf(to));
    return builder_.CreateIntrinsic(ptx::isSigned(to) ? llvm::Intrinsic::fptosi_sat
                                                      : llvm::Intrinsic::fptoui_sat,
                                    {target, value->getType()}, {value});
}

Value* FunctionTranslator::intToFloat(const ptx::Instruction& instruction, Value* value,
                                      ptx::Type from, ptx::Type to) {
    if (isBrain(to))
        reject(instruction, ErrorCode::kNotSupported, "bfloat16 from integers is not available");
    const Rounding rounding = roundingOf(instruction);
    const bool isSigned = ptx::isSigned(from);
    const unsigned bits = bitsOf(from);
    llvm::Type* target = typeOf(to);
    Value* result = nullptr;
    const bool exact = (to == ptx::Type::kF64 && bits <= 32) ||
                       (to == ptx::Type::kF32 && bits <= 16) ||
                       (to == ptx::Type::kF16 && bits <= 8);
    if (rounding == Rounding::kNearest || exact) {
        if (isHalf(to) && bits == 64) {
            // Through a wider format would round twice; clamp to where half is infinite instead.
            llvm::Constant* limit = llvm::ConstantInt::get(value->getType(), 1u << 20);
            value = intrinsicCall(isSigned ? llvm::Intrinsic::smin : llvm::Intrinsic::umin,
                                  {value, limit});
            if (isSigned)
                value = intrinsicCall(
                    llvm::Intrinsic::smax,
                    {value, llvm::ConstantInt::getSigned(value->getType(), -(1 << 20))});
        }
        if (isHalf(to)) { // exact in double, then one rounding
            Value* wide = isSigned ? builder_.CreateSIToFP(value, builder_.getDoubleTy())
                                   : builder_.CreateUIToFP(value, builder_.getDoubleTy());
            result = builder_.CreateFPTrunc(wide, target);
        } else {
            result = isSigned ? builder_.CreateSIToFP(value, target)
                              : builder_.CreateUIToFP(value, target);
        }
    } else {
        if (isHalf(to))
            reject(instruction, ErrorCode::kNotSupported,
                   "directed rounding of integers to .f16 is not available");
        static const char* const kNames[] = {"", "rz", "rm", "rp"};
        const std::string name =
            message("sunstone_cvt_", kNames[unsigned(rounding)],
                    to == ptx::Type::kF32 ? "_f32" : "_f64", isSigned ? "_s64" : "_u64");
        value = coerce(value, intType(64), isSigned);
        result = builder_.CreateCall(unit_.helper(name.c_str(), target, {intType(64)}), {value});
    }
    return instruction.has("sat") ? saturate(result) : result;
}

Value* FunctionTranslator::intToInt(const ptx::Instruction& instruction, Value* value,
                                    ptx::Type from, ptx::Type to) {
    const unsigned fromBits = bitsOf(from), toBits = bitsOf(to);
    const bool fromSigned = ptx::isSigned(from), toSigned = ptx::isSigned(to);
    if (instruction.has("sat")) {
        // Compared in a width that holds both ranges.
        llvm::IntegerType* wide = intType(std::max(fromBits, toBits) + 1);
        value = fromSigned ? builder_.CreateSExt(value, wide) : builder_.CreateZExt(value, wide);
        const llvm::APInt low =
            toSigned ? llvm::APInt::getSignedMinValue(toBits).sext(wide->getBitWidth())
                     : llvm::APInt(wide->getBitWidth(), 0);
        const llvm::APInt high =
            toSigned ? llvm::APInt::getSignedMaxValue(toBits).sext(wide->getBitWidth())
                     : llvm::APInt::getMaxValue(toBits).zext(wide->getBitWidth());
        value = intrinsicCall(llvm::Intrinsic::smax, {value, llvm::ConstantInt::get(wide, low)});
        value = intrinsicCall(llvm::Intrinsic::smin, {value, llvm::ConstantInt::get(wide, high)});
        return builder_.CreateTrunc(value, intType(toBits));
    }
    return coerce(value, intType(toBits), fromSigned);
}

// cvt.f16x2.f32 d, a, b and cvt.bf16x2.f32: a goes to the upper half.
void FunctionTranslator::convertPacked(const ptx::Instruction& instruction) {
    const ptx::Type to = instruction.types[0], from = instruction.types[1];
    const bool half = to == ptx::Type::kF16x2;
    if (from != ptx::Type::kF32 || (!half && to != ptx::Type::kBF16x2))
        reject(instruction, ErrorCode::kNotSupported, "this packed conversion is not available");
    Value* packed = builder_.getInt32(0);
    for (unsigned i = 0; i < 2; ++i) {
        Value* value = readFloat(instruction, instruction.operands[2 - i], from);
        Value* part =
            floatToFloat(instruction, value, from, half ? ptx::Type::kF16 : ptx::Type::kBF16);
        packed = builder_.CreateOr(
            packed,
            builder_.CreateShl(coerce(coerce(part, intType(16)), intType(32)), uint64_t(i) * 16));
    }
    write(instruction.operands[0], packed);
}

} // namespace sunstone::compiler
