// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: cvt in all its forms. Source: PTX ISA manual, "cvt".
#include "compiler/runtime/small_floats.h"
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

namespace {

SmallFormat formatOf(ptx::Type type) {
    return type == ptx::Type::kBF16 ? SmallFormat::kBrain : SmallFormat::kHalf;
}

bool isHalf(ptx::Type type) {
    return type == ptx::Type::kF16 || type == ptx::Type::kBF16;
}

} // namespace

void FunctionTranslator::convert(const ptx::Instruction& instruction) {
    if (instruction.has("pack"))
        return packIntegers(instruction);
    if (instruction.types.size() == 1)
        return convertSmall(instruction);
    if (instruction.types.size() < 2)
        rejectForm(instruction);
    if (instruction.operands.size() == 3)
        return convertPacked(instruction);
    operandCount(instruction, 2, 2);
    const ptx::Type to = instruction.types[0], from = instruction.types[1];
    if (instruction.types.size() > 2 || ptx::sizeOf(to) == 0 || isHalfPair(to) || isHalfPair(from))
        rejectForm(instruction);

    Value* value = read(instruction.operands[1], from);
    if (isHalf(from)) // exact, and easier to compute with
        value = widenHalf(value, from);
    const ptx::Type source = isHalf(from) ? ptx::Type::kF32 : from;
    if (instruction.has("ftz") && from == ptx::Type::kF32 && !isHalf(to))
        value = flush(value); // GPUs do not if the result is a half
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
    if (isHalf(to)) {
        if (rounding == Rounding::kNearest && (to == ptx::Type::kF16 || from == ptx::Type::kF32))
            value = narrowHalf(value, to);
        else
            value = encodeSmall(value, uint32_t(formatOf(to)), uint32_t(rounding));
        return limitHalf(instruction, coerce(value, intType(16)), to);
    }
    const unsigned fromBytes = ptx::sizeOf(from), toBytes = ptx::sizeOf(to);
    llvm::Type* target = typeOf(to);
    const bool narrows = toBytes < fromBytes;
    if (toBytes > fromBytes) {
        value = builder_.CreateFPExt(value, target);
    } else if (narrows && rounding == Rounding::kNearest) {
        value = builder_.CreateFPTrunc(value, target);
    } else if (narrows) {
        static const char* const kNames[] = {"", "rz", "rm", "rp"};
        const std::string name = message("sunstone_cvt_", kNames[unsigned(rounding)], "_f32_f64");
        value = builder_.CreateCall(unit_.helper(name.c_str(), target, {typeOf(from)}), {value});
    }
    if (instruction.has("ftz") && to == ptx::Type::kF32)
        value = flush(value);
    if (instruction.has("sat"))
        value = saturate(value);
    if (instruction.has("relu"))
        value = pickMinimum(value, llvm::ConstantFP::get(value->getType(), 0.0), true, true);
    return value;
}

// The 16 bits of a number for a format of runtime/small_floats.h.
Value* FunctionTranslator::encodeSmall(Value* value, uint32_t format, uint32_t how) {
    llvm::Type* wide = builder_.getDoubleTy();
    if (value->getType()->isFloatTy())
        value = builder_.CreateFPExt(value, wide);
    return builder_.CreateCall(
        unit_.helper("sunstone_encode_small", intType(32), {wide, intType(32), intType(32)}),
        {value, builder_.getInt32(format), builder_.getInt32(how)});
}

// .satfinite, .relu and .sat for the bits of a half. The first two make NaNs canonical; .sat makes
// them zero.
Value* FunctionTranslator::limitHalf(const ptx::Instruction& instruction, Value* half,
                                     ptx::Type type) {
    const bool brain = type == ptx::Type::kBF16;
    const auto word = [&](uint64_t bits) { return builder_.getInt16(uint16_t(bits)); };
    const uint64_t infinity = brain ? 0x7f80 : 0x7c00, one = brain ? 0x3f80 : 0x3c00;
    Value* magnitude = builder_.CreateAnd(half, word(0x7fff));
    Value* isNan = builder_.CreateICmpUGT(magnitude, word(infinity));
    Value* negative = builder_.CreateICmpSLT(half, word(0));
    if (instruction.has("satfinite")) {
        Value* finite = builder_.CreateSub(half, word(1)); // one below infinity
        half =
            builder_.CreateSelect(builder_.CreateICmpEQ(magnitude, word(infinity)), finite, half);
    }
    if (instruction.has("relu"))
        half = builder_.CreateSelect(negative, word(0), half);
    if (instruction.has("relu") || instruction.has("satfinite"))
        half = builder_.CreateSelect(isNan, word(0x7fff), half);
    if (instruction.has("sat")) {
        half = builder_.CreateSelect(builder_.CreateOr(isNan, negative), word(0), half);
        half = intrinsicCall(llvm::Intrinsic::umin, {half, word(one)});
    }
    return half;
}

// Out-of-range numbers go to the nearest end of the range. NaN becomes 0, or, if either side has 64
// bits, the number with only the top bit set.
Value* FunctionTranslator::floatToInt(const ptx::Instruction& instruction, Value* value,
                                      ptx::Type to) {
    if (!instruction.has("rzi")) // trunc is part of the conversion
        value = roundToIntegral(value, instruction);
    const unsigned bits = bitsOf(to);
    llvm::Type* target = intType(bits);
    Value* result = builder_.CreateIntrinsic(ptx::isSigned(to) ? llvm::Intrinsic::fptosi_sat
                                                               : llvm::Intrinsic::fptoui_sat,
                                             {target, value->getType()}, {value});
    if (bits < 64 && !value->getType()->isDoubleTy())
        return result;
    return builder_.CreateSelect(
        builder_.CreateFCmpUNO(value, value),
        llvm::ConstantInt::get(target, llvm::APInt::getSignedMinValue(bits)), result);
}

Value* FunctionTranslator::intToFloat(const ptx::Instruction& instruction, Value* value,
                                      ptx::Type from, ptx::Type to) {
    const Rounding rounding = roundingOf(instruction);
    const bool isSigned = ptx::isSigned(from);
    const unsigned bits = bitsOf(from);
    llvm::Type* target = typeOf(to);
    if (isHalf(to))
        return limitHalf(instruction, intToHalf(value, isSigned, to, rounding), to);
    Value* result = nullptr;
    const bool exact =
        (to == ptx::Type::kF64 && bits <= 32) || (to == ptx::Type::kF32 && bits <= 16);
    if (rounding == Rounding::kNearest || exact) {
        result =
            isSigned ? builder_.CreateSIToFP(value, target) : builder_.CreateUIToFP(value, target);
    } else {
        static const char* const kNames[] = {"", "rz", "rm", "rp"};
        const std::string name =
            message("sunstone_cvt_", kNames[unsigned(rounding)],
                    to == ptx::Type::kF32 ? "_f32" : "_f64", isSigned ? "_s64" : "_u64");
        value = coerce(value, intType(64), isSigned);
        result = builder_.CreateCall(unit_.helper(name.c_str(), target, {intType(64)}), {value});
    }
    return instruction.has("sat") ? saturate(result) : result;
}

// Through double: values that it cannot hold are rounded to odd, so the second rounding is exact.
Value* FunctionTranslator::intToHalf(Value* value, bool isSigned, ptx::Type to, Rounding rounding) {
    llvm::Type* wide = builder_.getDoubleTy();
    Value* number = nullptr;
    if (value->getType()->getIntegerBitWidth() == 64)
        number = builder_.CreateCall(
            unit_.helper(isSigned ? "sunstone_odd_s64" : "sunstone_odd_u64", wide, {intType(64)}),
            {value});
    else
        number = isSigned ? builder_.CreateSIToFP(value, wide) : builder_.CreateUIToFP(value, wide);
    Value* half = to == ptx::Type::kF16 && rounding == Rounding::kNearest
                      ? builder_.CreateFPTrunc(number, typeOf(to))
                      : encodeSmall(number, uint32_t(formatOf(to)), uint32_t(rounding));
    return coerce(half, intType(16));
}

Value* FunctionTranslator::intToInt(const ptx::Instruction& instruction, Value* value,
                                    ptx::Type from, ptx::Type to) {
    const unsigned fromBits = bitsOf(from), toBits = bitsOf(to);
    const bool fromSigned = ptx::isSigned(from), toSigned = ptx::isSigned(to);
    if (instruction.has("sat")) {
        // Compares in a width that holds both ranges.
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

// cvt.pack.sat: a and b in the low bits, b lowest; c, if present, above them.
void FunctionTranslator::packIntegers(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 4);
    unsigned bits = 0;
    bool isSigned = false;
    for (const char* name : {"u4", "s4", "u2", "s2"})
        if (instruction.has(name)) {
            bits = unsigned(name[1] - '0');
            isSigned = name[0] == 's';
        }
    if (bits == 0) {
        bits = bitsOf(instruction.types[0]);
        isSigned = ptx::isSigned(instruction.types[0]);
    }
    const size_t sources = instruction.types.size() - (bits >= 8 ? 1 : 0); // a type, or a modifier
    const size_t first = instruction.types.size() - sources;
    const bool merges = sources == 2;
    if (!instruction.has("sat") || bits > 16 || (bits == 16 && merges) || (bits < 8 && !merges) ||
        sources < 1 || sources > 2 || instruction.types[first] != ptx::Type::kS32 ||
        (merges && instruction.types[first + 1] != ptx::Type::kB32) ||
        instruction.operands.size() != (merges ? 4 : 3))
        rejectForm(instruction);
    const llvm::APInt low =
        isSigned ? llvm::APInt::getSignedMinValue(bits).sext(32) : llvm::APInt(32, 0);
    const llvm::APInt high = isSigned ? llvm::APInt::getSignedMaxValue(bits).sext(32)
                                      : llvm::APInt::getMaxValue(bits).zext(32);
    const auto limited = [&](const ptx::Operand& operand) {
        Value* value = readInt(operand, 32);
        value = intrinsicCall(llvm::Intrinsic::smax, {value, builder_.getInt(low)});
        value = intrinsicCall(llvm::Intrinsic::smin, {value, builder_.getInt(high)});
        return builder_.CreateAnd(value, llvm::APInt::getLowBitsSet(32, bits).getZExtValue());
    };
    Value* packed = builder_.CreateOr(builder_.CreateShl(limited(instruction.operands[1]), bits),
                                      limited(instruction.operands[2]));
    if (instruction.operands.size() == 4)
        packed = builder_.CreateOr(
            packed, builder_.CreateShl(readInt(instruction.operands[3], 32), uint64_t(2) * bits));
    write(instruction.operands[0], packed);
}

// cvt to and from formats that are not types of PTX: tf32, e4m3x2, e5m2x2.
void FunctionTranslator::convertSmall(const ptx::Instruction& instruction) {
    const ptx::Type type = lastType(instruction);
    const bool e4m3 = instruction.has("e4m3x2"), e5m2 = instruction.has("e5m2x2");
    const bool tensor = instruction.has("tf32") && type == ptx::Type::kF32;
    if ((!e4m3 && !e5m2 && !tensor) || instruction.has("scaled"))
        reject(instruction, ErrorCode::kNotSupported, "this conversion is not available");
    const SmallFormat format = tensor ? SmallFormat::kTensor32
                               : e4m3 ? SmallFormat::kE4m3
                                      : SmallFormat::kE5m2;
    const unsigned bits = tensor ? 19 : 8;
    const uint32_t how = (instruction.has("rna") ? uint32_t(SmallRounding::kAway)
                                                 : uint32_t(roundingOf(instruction))) |
                         (instruction.has("satfinite") ? kSmallFinite : 0);
    const auto encoded = [&](Value* value) {
        Value* code = encodeSmall(value, uint32_t(format), how);
        if (!instruction.has("relu"))
            return code;
        Value* negative =
            builder_.CreateICmpNE(builder_.CreateLShr(code, bits - 1), builder_.getInt32(0));
        return builder_.CreateSelect(negative, builder_.getInt32(0), code);
    };
    if (tensor) {
        operandCount(instruction, 2, 2);
        Value* value = read(instruction.operands[1], type);
        Value* code = encoded(value);
        if (instruction.has("rna")) { // truncates NaNs like other bits; .satfinite subtracts one
            Value* cut = builder_.CreateLShr(builder_.CreateBitCast(value, intType(32)), 13);
            if (instruction.has("satfinite"))
                cut = builder_.CreateSub(cut, builder_.getInt32(1));
            code = builder_.CreateSelect(builder_.CreateFCmpUNO(value, value), cut, code);
        }
        return write(instruction.operands[0], builder_.CreateShl(code, 13));
    }
    if (!instruction.has("satfinite")) { // from the small format
        operandCount(instruction, 2, 2);
        if (type != ptx::Type::kF16x2)
            rejectForm(instruction);
        return decodeSmallPair(instruction, uint32_t(format));
    }
    Value* low = nullptr;
    Value* high = nullptr;
    if (type == ptx::Type::kF16x2) {
        operandCount(instruction, 2, 2);
        Value* pair = widenHalf(read(instruction.operands[1], type), type);
        low = builder_.CreateExtractElement(pair, uint64_t(0));
        high = builder_.CreateExtractElement(pair, uint64_t(1));
    } else {
        operandCount(instruction, 3, 3);
        high = read(instruction.operands[1], type);
        low = read(instruction.operands[2], type);
    }
    Value* packed = builder_.CreateOr(builder_.CreateShl(encoded(high), 8), encoded(low));
    write(instruction.operands[0], builder_.CreateTrunc(packed, intType(16)));
}

void FunctionTranslator::decodeSmallPair(const ptx::Instruction& instruction, uint32_t format) {
    Value* codes = coerce(readInt(instruction.operands[1], 16), intType(32));
    Value* packed = builder_.getInt32(0);
    for (unsigned i = 0; i < 2; ++i) {
        Value* code = builder_.CreateAnd(builder_.CreateLShr(codes, uint64_t(8) * i), 255);
        Value* number =
            builder_.CreateCall(unit_.helper("sunstone_decode_small", builder_.getFloatTy(),
                                             {intType(32), intType(32)}),
                                {code, builder_.getInt32(format)});
        Value* half = coerce(narrowHalf(number, ptx::Type::kF16), intType(16));
        Value* isNan = builder_.CreateFCmpUNO(number, number);
        half = builder_.CreateSelect(isNan, builder_.getInt16(0x7fff), half);
        half = limitHalf(instruction, half, ptx::Type::kF16);
        packed = builder_.CreateOr(packed,
                                   builder_.CreateShl(coerce(half, intType(32)), uint64_t(16) * i));
    }
    write(instruction.operands[0], packed);
}

} // namespace sunstone::compiler
