// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: video instructions. The scalar ones take a word, half or byte of each
// operand, compute in more bits than the result has, saturate, and merge the result into a third
// operand or combine it with that. The others do the same with two halves or four bytes at once.
// Source: PTX ISA manual, "Video Instructions".
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

namespace {

// Bits in which sums and shifts of 32-bit operands cannot overflow.
constexpr unsigned kWide = 72;

struct Part {
    unsigned shift = 0, bits = 32;
};

// The part of a word that .b0 to .b3, .h0 or .h1 names.
Part partOf(const ptx::Operand& operand) {
    if (operand.component >= 8 && operand.component < ptx::Operand::kPicked)
        return {unsigned(operand.component - 8) * 16, 16};
    if (operand.component >= 4)
        return {unsigned(operand.component - 4) * 8, 8};
    return {};
}

ptx::Operand wholeOf(ptx::Operand operand) {
    operand.component = -1;
    operand.negated = false;
    return operand;
}

bool hasSecond(const ptx::Instruction& instruction) {
    return instruction.has("add") || instruction.has("min") || instruction.has("max");
}

} // namespace

// A part of an operand, extended.
Value* FunctionTranslator::videoOperand(const ptx::Operand& operand, bool isSigned) {
    const Part part = partOf(operand);
    Value* value = readInt(wholeOf(operand), 32);
    value = builder_.CreateTrunc(builder_.CreateLShr(value, part.shift), intType(part.bits));
    return isSigned ? builder_.CreateSExt(value, intType(kWide))
                    : builder_.CreateZExt(value, intType(kWide));
}

// Clamps to the range of `bits` bits.
Value* FunctionTranslator::videoSaturate(Value* value, unsigned bits, bool isSigned) {
    const llvm::APInt low =
        isSigned ? llvm::APInt::getSignedMinValue(bits).sext(kWide) : llvm::APInt(kWide, 0);
    const llvm::APInt high = isSigned ? llvm::APInt::getSignedMaxValue(bits).sext(kWide)
                                      : llvm::APInt::getMaxValue(bits).zext(kWide);
    value = intrinsicCall(llvm::Intrinsic::smax, {value, builder_.getInt(low)});
    return intrinsicCall(llvm::Intrinsic::smin, {value, builder_.getInt(high)});
}

// The opcode's result for two extended operands.
Value* FunctionTranslator::videoResult(const ptx::Instruction& instruction, Value* a, Value* b,
                                       bool arithmeticShift) {
    const std::string_view name = instruction.opcode;
    if (name.starts_with("vadd"))
        return builder_.CreateAdd(a, b);
    if (name.starts_with("vsub"))
        return builder_.CreateSub(a, b);
    if (name.starts_with("vabsdiff"))
        return intrinsicCall(llvm::Intrinsic::abs, {builder_.CreateSub(a, b), builder_.getFalse()});
    if (name.starts_with("vmin"))
        return intrinsicCall(llvm::Intrinsic::smin, {a, b});
    if (name.starts_with("vmax"))
        return intrinsicCall(llvm::Intrinsic::smax, {a, b});
    if (name.starts_with("vavrg")) { // rounds away from zero
        Value* sum = builder_.CreateAdd(a, b);
        Value* notNegative = builder_.CreateICmpSGE(sum, llvm::ConstantInt::get(sum->getType(), 0));
        return builder_.CreateAShr(
            builder_.CreateAdd(sum, builder_.CreateZExt(notNegative, sum->getType())), uint64_t(1));
    }
    if (name.starts_with("vset")) {
        using C = llvm::CmpInst;
        for (const auto& [comparison, predicate] :
             {std::pair<std::string_view, C::Predicate>{"eq", C::ICMP_EQ},
              {"ne", C::ICMP_NE},
              {"lt", C::ICMP_SLT},
              {"le", C::ICMP_SLE},
              {"gt", C::ICMP_SGT},
              {"ge", C::ICMP_SGE}})
            if (instruction.has(comparison))
                return builder_.CreateZExt(builder_.CreateICmp(predicate, a, b), a->getType());
        rejectForm(instruction);
    }
    if (!name.starts_with("vsh") || instruction.has("clamp") == instruction.has("wrap"))
        rejectForm(instruction);
    // vshl, vshr: the amount is clamped to 32 or wrapped.
    llvm::Constant* limit = llvm::ConstantInt::get(b->getType(), instruction.has("wrap") ? 31 : 32);
    b = instruction.has("wrap") ? builder_.CreateAnd(b, limit)
                                : intrinsicCall(llvm::Intrinsic::umin, {b, limit});
    if (name == "vshl")
        return builder_.CreateShl(a, b);
    return arithmeticShift ? builder_.CreateAShr(a, b) : builder_.CreateLShr(a, b);
}

void FunctionTranslator::videoScalar(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 4);
    const bool compares = instruction.opcode == "vset";
    if (instruction.types.size() != (compares ? 2 : 3))
        rejectForm(instruction);
    const ptx::Type typeA = instruction.types[compares ? 0 : 1];
    const ptx::Type typeB = instruction.types[compares ? 1 : 2];
    const bool isSigned = !compares && ptx::isSigned(instruction.types[0]);
    Value* a = videoOperand(instruction.operands[1], ptx::isSigned(typeA));
    Value* b = videoOperand(instruction.operands[2], ptx::isSigned(typeB));
    Value* result = videoResult(instruction, a, b, ptx::isSigned(typeA));
    const ptx::Operand& target = instruction.operands[0];
    const Part part = partOf(target);
    if (instruction.has("sat"))
        result = videoSaturate(result, part.bits, isSigned);
    result = builder_.CreateTrunc(result, intType(32));
    const bool second = hasSecond(instruction), merges = part.bits < 32;
    if ((second || merges) != (instruction.operands.size() == 4) || (second && merges))
        rejectForm(instruction);
    if (second)
        result = videoSecond(instruction, result, readInt(instruction.operands[3], 32), isSigned);
    if (merges) {
        const uint32_t mask = ((1u << part.bits) - 1) << part.shift;
        result = builder_.CreateOr(builder_.CreateAnd(builder_.CreateShl(result, part.shift), mask),
                                   builder_.CreateAnd(readInt(instruction.operands[3], 32), ~mask));
    }
    write(wholeOf(target), result, isSigned);
}

Value* FunctionTranslator::videoSecond(const ptx::Instruction& instruction, Value* result,
                                       Value* other, bool isSigned) {
    if (instruction.has("add"))
        return builder_.CreateAdd(result, other);
    if (instruction.has("min"))
        return intrinsicCall(isSigned ? llvm::Intrinsic::smin : llvm::Intrinsic::umin,
                             {result, other});
    return intrinsicCall(isSigned ? llvm::Intrinsic::smax : llvm::Intrinsic::umax, {result, other});
}

// vmad: a * b + c, or + 1, shifted and saturated. Negating one of a, b negates the product.
void FunctionTranslator::videoMultiplyAdd(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    if (instruction.types.size() != 3)
        rejectForm(instruction);
    const ptx::Operand& first = instruction.operands[1];
    const ptx::Operand& second = instruction.operands[2];
    const ptx::Operand& addend = instruction.operands[3];
    const bool signedA = ptx::isSigned(instruction.types[1]);
    const bool signedB = ptx::isSigned(instruction.types[2]);
    const bool negates = first.negated != second.negated;
    const bool isSigned = signedA || signedB || negates || addend.negated;
    Value* product =
        builder_.CreateMul(videoOperand(first, signedA), videoOperand(second, signedB));
    if (negates)
        product = builder_.CreateNeg(product);
    Value* c = readInt(wholeOf(addend), 32);
    c = isSigned ? builder_.CreateSExt(c, intType(kWide)) : builder_.CreateZExt(c, intType(kWide));
    if (addend.negated)
        c = builder_.CreateNeg(c);
    Value* result = builder_.CreateAdd(product, c);
    if (instruction.has("po"))
        result = builder_.CreateAdd(result, llvm::ConstantInt::get(result->getType(), 1));
    const unsigned shift = instruction.has("shr7") ? 7 : instruction.has("shr15") ? 15 : 0;
    result = builder_.CreateAShr(result, shift);
    if (instruction.has("sat"))
        result = videoSaturate(result, 32, isSigned);
    write(wholeOf(instruction.operands[0]), builder_.CreateTrunc(result, intType(32)), isSigned);
}

// vadd2, vadd4 and the like: each half or byte; with .add the results are summed onto c.
void FunctionTranslator::videoPacked(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    const bool compares = instruction.opcode.starts_with("vset");
    if (instruction.types.size() != (compares ? 2 : 3) || instruction.has("min") ||
        instruction.has("max"))
        rejectForm(instruction);
    for (const ptx::Operand& operand : instruction.operands)
        if (operand.component >= 0 || operand.negated)
            reject(instruction, ErrorCode::kNotSupported,
                   "picked parts of packed video operands are not available");
    const unsigned bits = instruction.opcode.back() == '2' ? 16 : 8;
    const bool signedA = ptx::isSigned(instruction.types[compares ? 0 : 1]);
    const bool signedB = ptx::isSigned(instruction.types[compares ? 1 : 2]);
    const bool isSigned = !compares && ptx::isSigned(instruction.types[0]);
    Value* a = readInt(instruction.operands[1], 32);
    Value* b = readInt(instruction.operands[2], 32);
    Value* sum = readInt(instruction.operands[3], 32);
    Value* packed = builder_.getInt32(0);
    for (unsigned shift = 0; shift < 32; shift += bits) {
        const auto lane = [&](Value* word, bool extendsSign) {
            Value* part = builder_.CreateTrunc(builder_.CreateLShr(word, shift), intType(bits));
            return extendsSign ? builder_.CreateSExt(part, intType(kWide))
                               : builder_.CreateZExt(part, intType(kWide));
        };
        Value* result = videoResult(instruction, lane(a, signedA), lane(b, signedB), signedA);
        if (instruction.has("sat"))
            result = videoSaturate(result, bits, isSigned);
        Value* part = builder_.CreateTrunc(result, intType(bits));
        sum = builder_.CreateAdd(sum, builder_.CreateTrunc(result, intType(32)));
        packed = builder_.CreateOr(
            packed, builder_.CreateShl(builder_.CreateZExt(part, intType(32)), shift));
    }
    write(instruction.operands[0], instruction.has("add") ? sum : packed);
}

} // namespace sunstone::compiler
