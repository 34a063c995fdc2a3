// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: floating point arithmetic. Operations are IEEE and never contracted; no
// fast-math flag is set. The .approx forms of division and roots are computed exactly, which the
// stated error allows. The others are in approximations.cpp.
//
// .ftz is a property of one instruction: flush() marks the place with a call of sunstone.flush,
// which flush.cpp turns into code. A result is flushed before any other step: only then can the
// processor do it.
#include "compiler/translate/function_translator.h"

#include "compiler/passes/approximations.h"
#include "compiler/passes/flush.h"

#include <llvm/IR/Intrinsics.h>

namespace sunstone::compiler {

namespace {

const char* suffixOf(Rounding rounding) {
    switch (rounding) {
    case Rounding::kZero:
        return "rz";
    case Rounding::kDown:
        return "rm";
    case Rounding::kUp:
        return "rp";
    default:
        return "rn";
    }
}

llvm::Type* bitsLike(llvm::Type* type) {
    llvm::Type* scalar = type->getScalarType();
    llvm::Type* bits =
        llvm::IntegerType::get(type->getContext(), unsigned(scalar->getPrimitiveSizeInBits()));
    return type->isVectorTy() ? llvm::FixedVectorType::get(bits, 2) : bits;
}

// All bits set except the sign, as on GPUs.
llvm::Constant* canonicalNan(llvm::Type* type) {
    llvm::Type* scalar = type->getScalarType();
    const llvm::fltSemantics& semantics = scalar->getFltSemantics();
    llvm::APInt bits = llvm::APInt::getAllOnes(unsigned(scalar->getPrimitiveSizeInBits()));
    bits.clearSignBit();
    return llvm::ConstantFP::get(type, llvm::APFloat(semantics, bits));
}

} // namespace

Rounding FunctionTranslator::roundingOf(const ptx::Instruction& instruction) {
    if (instruction.has("rz"))
        return Rounding::kZero;
    if (instruction.has("rm"))
        return Rounding::kDown;
    if (instruction.has("rp"))
        return Rounding::kUp;
    return Rounding::kNearest;
}

ptx::Type FunctionTranslator::floatType(const ptx::Instruction& instruction) const {
    const ptx::Type type = lastType(instruction);
    if (!ptx::isFloat(type) || instruction.types.size() > 1)
        rejectForm(instruction);
    return type;
}

Value* FunctionTranslator::intrinsicCall(llvm::Intrinsic::ID id, llvm::ArrayRef<Value*> operands) {
    return builder_.CreateIntrinsic(id, {operands[0]->getType()}, operands);
}

Value* FunctionTranslator::flush(Value* value) {
    llvm::Type* type = value->getType();
    if (type->isFloatTy()) {
        if (auto* constant = llvm::dyn_cast<llvm::ConstantFP>(value))
            return constant->getValueAPF().isDenormal()
                       ? llvm::ConstantFP::getZero(type, constant->isNegative())
                       : constant;
        return builder_.CreateCall(unit_.helper(kFlushName, type, {type}), {value});
    }
    if (!type->getScalarType()->isHalfTy())
        return value;
    Value* tiny = builder_.CreateFCmpOLT(intrinsicCall(llvm::Intrinsic::fabs, {value}),
                                         llvm::ConstantFP::get(type, 0x1p-14));
    Value* zero =
        intrinsicCall(llvm::Intrinsic::copysign, {llvm::Constant::getNullValue(type), value});
    return builder_.CreateSelect(tiny, zero, value);
}

Value* FunctionTranslator::readFloat(const ptx::Instruction& instruction,
                                     const ptx::Operand& operand, ptx::Type type) {
    Value* value = read(operand, type);
    if (instruction.has("ftz") && !isBrainType(type))
        value = flush(value);
    return isHalfType(type) ? widenHalf(value, type) : value;
}

bool FunctionTranslator::isBrainType(ptx::Type type) {
    return type == ptx::Type::kBF16 || type == ptx::Type::kBF16x2;
}
bool FunctionTranslator::isHalfPair(ptx::Type type) {
    return type == ptx::Type::kF16x2 || type == ptx::Type::kBF16x2;
}
bool FunctionTranslator::isHalfType(ptx::Type type) {
    return type == ptx::Type::kF16 || type == ptx::Type::kBF16 || isHalfPair(type);
}

// f16 and bf16 to float, pairs to a vector of two.
Value* FunctionTranslator::widenHalf(Value* value, ptx::Type type) {
    llvm::Type* single = builder_.getFloatTy();
    if (isHalfPair(type))
        single = llvm::FixedVectorType::get(single, 2);
    if (!isBrainType(type))
        return builder_.CreateFPExt(value, single);
    // A bfloat16 is the upper half of a float.
    if (type == ptx::Type::kBF16)
        return builder_.CreateBitCast(builder_.CreateShl(coerce(value, intType(32)), 16), single);
    Value* pair = llvm::PoisonValue::get(llvm::FixedVectorType::get(intType(32), 2));
    pair = builder_.CreateInsertElement(pair, builder_.CreateShl(value, 16), uint64_t(0));
    pair = builder_.CreateInsertElement(pair, builder_.CreateAnd(value, 0xffff0000u), uint64_t(1));
    return builder_.CreateBitCast(pair, single);
}

// Back to 16 bits, to the nearest even. A NaN becomes the canonical one.
Value* FunctionTranslator::narrowHalf(Value* value, ptx::Type type) {
    if (!isBrainType(type))
        return builder_.CreateFPTrunc(value, typeOf(type));
    llvm::Type* words = bitsLike(value->getType());
    const auto word = [&](uint64_t bits) { return llvm::ConstantInt::get(words, bits); };
    Value* bits = builder_.CreateBitCast(value, words);
    Value* odd = builder_.CreateAnd(builder_.CreateLShr(bits, word(16)), word(1));
    bits = builder_.CreateAdd(bits, builder_.CreateAdd(odd, word(0x7fff)));
    bits = builder_.CreateSelect(builder_.CreateFCmpUNO(value, value), word(0x7fff0000), bits);
    bits = builder_.CreateLShr(bits, word(16));
    if (type == ptx::Type::kBF16)
        return builder_.CreateTrunc(bits, intType(16));
    Value* high = builder_.CreateShl(builder_.CreateExtractElement(bits, uint64_t(1)), 16);
    return builder_.CreateOr(high, builder_.CreateExtractElement(bits, uint64_t(0)));
}

// Into [0, 1]; NaN and -0 become +0.
Value* FunctionTranslator::saturate(Value* value) {
    llvm::Constant* zero = llvm::ConstantFP::get(value->getType(), 0.0);
    llvm::Constant* one = llvm::ConstantFP::get(value->getType(), 1.0);
    value = builder_.CreateSelect(builder_.CreateFCmpOGT(value, zero), value, zero);
    return builder_.CreateSelect(builder_.CreateFCmpOLT(value, one), value, one);
}

void FunctionTranslator::writeFloat(const ptx::Instruction& instruction, Value* value,
                                    bool canBeSubnormal) {
    const ptx::Type type = lastType(instruction);
    if (isHalfType(type)) {
        value = narrowHalf(value, type); // rounds before any other step
        if (instruction.has("ftz") && !isBrainType(type))
            value = flush(value);
        if (!instruction.has("sat") && !instruction.has("relu"))
            return write(instruction.operands[0], value);
        value = widenHalf(value, type);
    } else if (instruction.has("ftz") && canBeSubnormal) {
        value = flush(value);
    }
    if (instruction.has("sat"))
        value = saturate(value);
    if (instruction.has("relu"))
        value = pickMinimum(value, llvm::ConstantFP::get(value->getType(), 0.0), true, true);
    if (isHalfType(type))
        value = narrowHalf(value, type);
    write(instruction.operands[0], value);
}

Value* FunctionTranslator::roundedCall(const char* operation, Rounding rounding,
                                       llvm::ArrayRef<Value*> operands) {
    llvm::Type* type = operands[0]->getType();
    if (!type->isFloatTy() && !type->isDoubleTy())
        reject(*current_, ErrorCode::kInvalidPtx, "directed rounding needs .f32 or .f64");
    const std::string name = message("sunstone_", operation, "_", suffixOf(rounding), "_",
                                     type->isFloatTy() ? "f32" : "f64");
    const std::vector<llvm::Type*> types(operands.size(), type);
    return builder_.CreateCall(unit_.helper(name.c_str(), type, types), operands);
}

void FunctionTranslator::floatArithmetic(const ptx::Instruction& instruction) {
    const ptx::Type type = floatType(instruction);
    const Rounding rounding = roundingOf(instruction);
    Value* a = readFloat(instruction, instruction.operands[1], type);
    Value* b = readFloat(instruction, instruction.operands[2], type);
    const std::string operation(instruction.opcode);
    Value* result = nullptr;
    if (rounding != Rounding::kNearest)
        result = roundedCall(operation.c_str(), rounding, {a, b});
    else if (operation == "add")
        result = builder_.CreateFAdd(a, b);
    else if (operation == "sub")
        result = builder_.CreateFSub(a, b);
    else
        result = builder_.CreateFMul(a, b);
    writeFloat(instruction, result);
}

void FunctionTranslator::fusedMultiplyAdd(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    const ptx::Type type = floatType(instruction);
    const Rounding rounding = roundingOf(instruction);
    Value* a = readFloat(instruction, instruction.operands[1], type);
    Value* b = readFloat(instruction, instruction.operands[2], type);
    Value* c = readFloat(instruction, instruction.operands[3], type);
    Value* result = nullptr;
    if (rounding != Rounding::kNearest) {
        result = roundedCall("fma", rounding, {a, b, c});
    } else if (isHalfType(type)) {
        result = fusedHalf(a, b, c, type);
    } else {
        result = intrinsicCall(llvm::Intrinsic::fma, {a, b, c});
    }
    writeFloat(instruction, result);
}

// a * b + c of 16-bit numbers as a float that rounds to 16 bits like the exact result.
Value* FunctionTranslator::fusedHalf(Value* a, Value* b, Value* c, ptx::Type type) {
    if (!isBrainType(type)) {
        // In double the product is exact, and so is the sum in all cases where its rounding to half
        // could depend on it.
        llvm::Type* wide = builder_.getDoubleTy();
        if (isHalfPair(type))
            wide = llvm::FixedVectorType::get(wide, 2);
        Value* product =
            builder_.CreateFMul(builder_.CreateFPExt(a, wide), builder_.CreateFPExt(b, wide));
        Value* sum = builder_.CreateFAdd(product, builder_.CreateFPExt(c, wide));
        return builder_.CreateFPExt(builder_.CreateFPTrunc(sum, typeOf(type)), a->getType());
    }
    llvm::Type* single = builder_.getFloatTy();
    const llvm::FunctionCallee fused =
        unit_.helper("sunstone_fma_bf16", single, {single, single, single});
    if (type == ptx::Type::kBF16)
        return builder_.CreateCall(fused, {a, b, c});
    Value* result = llvm::PoisonValue::get(a->getType());
    for (uint64_t i = 0; i < 2; ++i)
        result = builder_.CreateInsertElement(
            result,
            builder_.CreateCall(fused, {builder_.CreateExtractElement(a, i),
                                        builder_.CreateExtractElement(b, i),
                                        builder_.CreateExtractElement(c, i)}),
            i);
    return result;
}

void FunctionTranslator::floatDivide(const ptx::Instruction& instruction) {
    const ptx::Type type = floatType(instruction);
    const Rounding rounding = roundingOf(instruction);
    Value* a = readFloat(instruction, instruction.operands[1], type);
    Value* b = readFloat(instruction, instruction.operands[2], type);
    writeFloat(instruction, rounding == Rounding::kNearest ? builder_.CreateFDiv(a, b)
                                                           : roundedCall("div", rounding, {a, b}));
}

void FunctionTranslator::reciprocal(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Type type = floatType(instruction);
    const Rounding rounding = roundingOf(instruction);
    if (type == ptx::Type::kF64 && instruction.has("approx"))
        return approximateDouble(instruction);
    Value* a = readFloat(instruction, instruction.operands[1], type);
    llvm::Constant* one = llvm::ConstantFP::get(a->getType(), 1.0);
    writeFloat(instruction, rounding == Rounding::kNearest
                                ? builder_.CreateFDiv(one, a)
                                : roundedCall("div", rounding, {one, a}));
}

void FunctionTranslator::squareRoot(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Type type = floatType(instruction);
    const Rounding rounding = roundingOf(instruction);
    Value* a = readFloat(instruction, instruction.operands[1], type);
    // The root of a normal number is normal.
    writeFloat(instruction,
               rounding == Rounding::kNearest ? intrinsicCall(llvm::Intrinsic::sqrt, {a})
                                              : roundedCall("sqrt", rounding, {a}),
               !instruction.has("ftz"));
}

void FunctionTranslator::reciprocalSquareRoot(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    if (floatType(instruction) == ptx::Type::kF64 && instruction.has("ftz"))
        return approximateDouble(instruction);
    Value* a = readFloat(instruction, instruction.operands[1], floatType(instruction));
    Value* root = intrinsicCall(llvm::Intrinsic::sqrt, {a});
    writeFloat(instruction, builder_.CreateFDiv(llvm::ConstantFP::get(a->getType(), 1.0), root),
               false);
}

// rcp.approx.ftz.f64 and rsqrt.approx.ftz.f64 read only the upper word of their operand, return
// only an upper word, and flush.
void FunctionTranslator::approximateDouble(const ptx::Instruction& instruction) {
    llvm::Type* wide = builder_.getDoubleTy();
    const auto upper = [&](Value* value) -> Value* {
        Value* bits = builder_.CreateAnd(coerce(value, intType(64)), 0xffffffff00000000ull);
        Value* number = builder_.CreateBitCast(bits, wide);
        Value* tiny = builder_.CreateFCmpOLT(intrinsicCall(llvm::Intrinsic::fabs, {number}),
                                             llvm::ConstantFP::get(wide, 0x1p-1022));
        Value* zero =
            intrinsicCall(llvm::Intrinsic::copysign, {llvm::ConstantFP::get(wide, 0.0), number});
        return builder_.CreateSelect(tiny, zero, number);
    };
    Value* a = upper(readInt(instruction.operands[1], 64));
    if (instruction.opcode == "rsqrt")
        a = intrinsicCall(llvm::Intrinsic::sqrt, {a});
    write(instruction.operands[0], upper(builder_.CreateFDiv(llvm::ConstantFP::get(wide, 1.0), a)));
}

void FunctionTranslator::transcendental(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Type type = floatType(instruction);
    if (type == ptx::Type::kF64)
        reject(instruction, ErrorCode::kNotSupported, "this type is not available");
    Value* a = readFloat(instruction, instruction.operands[1], type);
    // A bfloat16 is subnormal if the same value as a float is.
    const bool flushes = instruction.has("ftz") && (type == ptx::Type::kF32 || isBrainType(type));
    llvm::Function* function = approximation(unit_, instruction.opcode, flushes);
    Value* result = nullptr;
    if (isHalfPair(type)) {
        result = llvm::PoisonValue::get(a->getType());
        for (uint64_t i = 0; i < 2; ++i)
            result = builder_.CreateInsertElement(
                result, builder_.CreateCall(function, {builder_.CreateExtractElement(a, i)}), i);
    } else {
        result = builder_.CreateCall(function, {a});
    }
    writeFloat(instruction, result, false); // the approximation flushes
}

void FunctionTranslator::floatSign(const ptx::Instruction& instruction) {
    const ptx::Type type = floatType(instruction);
    if (isBrainType(type)) { // the sign bits
        const unsigned bits = bitsOf(type);
        const uint64_t signs = bits == 32 ? 0x80008000u : 0x8000u;
        Value* a = readInt(instruction.operands[1], bits);
        write(instruction.operands[0],
              instruction.opcode == "neg"
                  ? builder_.CreateXor(a, llvm::ConstantInt::get(intType(bits), signs))
                  : builder_.CreateAnd(a, llvm::ConstantInt::get(intType(bits), ~signs)));
        return;
    }
    Value* a = read(instruction.operands[1], type);
    if (instruction.has("ftz"))
        a = flush(a);
    Value* result = instruction.opcode == "neg" ? builder_.CreateFNeg(a)
                                                : intrinsicCall(llvm::Intrinsic::fabs, {a});
    write(instruction.operands[0], result);
}

// The smaller (greater) of two numbers, -0 below +0. A NaN loses against a number, or wins if
// propagateNan is set.
Value* FunctionTranslator::pickMinimum(Value* a, Value* b, bool greatest, bool propagateNan) {
    llvm::Type* type = a->getType();
    llvm::Constant* nan = canonicalNan(type);
    if (propagateNan) {
        Value* least = pickMinimum(a, b, greatest, false);
        return builder_.CreateSelect(builder_.CreateFCmpUNO(a, b), nan, least);
    }
    if (llvm::isa<llvm::ConstantFP>(a))
        std::swap(a, b);
    if (auto* constant = llvm::dyn_cast<llvm::ConstantFP>(b)) {
        // One comparison suffices: it fails for a NaN, and <= or < orders a zero.
        const bool zero = constant->isZero();
        const bool negative = constant->isNegative();
        if (constant->isNaN())
            return builder_.CreateSelect(builder_.CreateFCmpUNO(a, a), nan, a);
        Value* takeA = nullptr;
        if (greatest)
            takeA = zero && negative ? builder_.CreateFCmpOGE(a, b) : builder_.CreateFCmpOGT(a, b);
        else
            takeA = zero && !negative ? builder_.CreateFCmpOLE(a, b) : builder_.CreateFCmpOLT(a, b);
        return builder_.CreateSelect(takeA, a, b);
    }
    // first and second differ only for zeros of unlike sign (and NaN, decided afterwards): there
    // the bitwise combination keeps the wanted sign.
    const auto pick = [&](Value* x, Value* y) {
        Value* takeX = greatest ? builder_.CreateFCmpOGT(x, y) : builder_.CreateFCmpOLT(x, y);
        return builder_.CreateSelect(takeX, x, y);
    };
    llvm::Type* bits = bitsLike(type);
    Value* first = builder_.CreateBitCast(pick(a, b), bits);
    Value* second = builder_.CreateBitCast(pick(b, a), bits);
    Value* joined = builder_.CreateBitCast(
        greatest ? builder_.CreateAnd(first, second) : builder_.CreateOr(first, second), type);
    Value* nanA = builder_.CreateFCmpUNO(a, a);
    Value* nanB = builder_.CreateFCmpUNO(b, b);
    Value* other = builder_.CreateSelect(nanB, nan, b); // two NaNs give the canonical one
    return builder_.CreateSelect(nanA, other, builder_.CreateSelect(nanB, a, joined));
}

void FunctionTranslator::floatMinimum(const ptx::Instruction& instruction) {
    const ptx::Type type = floatType(instruction);
    const bool greatest = instruction.opcode == "max";
    Value* result = readFloat(instruction, instruction.operands[1], type);
    Value* sign = nullptr;
    const bool xorSign = instruction.has("xorsign");
    for (size_t i = 2; i < instruction.operands.size(); ++i) {
        Value* other = readFloat(instruction, instruction.operands[i], type);
        if (xorSign) {
            llvm::Type* bits = bitsLike(result->getType());
            sign = builder_.CreateXor(builder_.CreateBitCast(result, bits),
                                      builder_.CreateBitCast(other, bits));
        }
        if (xorSign || instruction.has("abs")) {
            result = intrinsicCall(llvm::Intrinsic::fabs, {result});
            other = intrinsicCall(llvm::Intrinsic::fabs, {other});
        }
        result = pickMinimum(result, other, greatest, instruction.has("NaN"));
        if (sign) {
            Value* signedResult =
                intrinsicCall(llvm::Intrinsic::copysign,
                              {result, builder_.CreateBitCast(sign, result->getType())});
            // A NaN becomes the canonical one, without a sign.
            result =
                builder_.CreateSelect(builder_.CreateFCmpUNO(result, result), result, signedResult);
        }
    }
    write(instruction.operands[0], isHalfType(type) ? narrowHalf(result, type) : result);
}

// The sign of the first, the magnitude of the second operand.
void FunctionTranslator::copySign(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = floatType(instruction);
    write(instruction.operands[0],
          intrinsicCall(llvm::Intrinsic::copysign, {read(instruction.operands[2], type),
                                                    read(instruction.operands[1], type)}));
}

void FunctionTranslator::testProperty(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    Value* a = read(instruction.operands[1], floatType(instruction));
    unsigned classes = 0;
    if (instruction.has("finite"))
        classes = llvm::fcFinite;
    else if (instruction.has("infinite"))
        classes = llvm::fcInf;
    else if (instruction.has("number"))
        classes = llvm::fcAllFlags & ~llvm::fcNan;
    else if (instruction.has("notanumber"))
        classes = llvm::fcNan;
    else if (instruction.has("normal")) // includes zeros, as the manual says
        classes = llvm::fcNormal | llvm::fcZero;
    else if (instruction.has("subnormal"))
        classes = llvm::fcSubnormal;
    else
        rejectForm(instruction);
    write(instruction.operands[0], builder_.createIsFPClass(a, classes));
}

} // namespace sunstone::compiler
