// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: setp, set, selp, slct.
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

namespace {

struct Operator {
    std::string_view name;
    llvm::CmpInst::Predicate ordered; // floats
    llvm::CmpInst::Predicate asSigned;
    llvm::CmpInst::Predicate asUnsigned;
};

using C = llvm::CmpInst;
constexpr Operator kOperators[] = {
    {"eq", C::FCMP_OEQ, C::ICMP_EQ, C::ICMP_EQ},
    {"ne", C::FCMP_ONE, C::ICMP_NE, C::ICMP_NE},
    {"lt", C::FCMP_OLT, C::ICMP_SLT, C::ICMP_ULT},
    {"le", C::FCMP_OLE, C::ICMP_SLE, C::ICMP_ULE},
    {"gt", C::FCMP_OGT, C::ICMP_SGT, C::ICMP_UGT},
    {"ge", C::FCMP_OGE, C::ICMP_SGE, C::ICMP_UGE},
    {"lo", C::BAD_FCMP_PREDICATE, C::ICMP_ULT, C::ICMP_ULT},
    {"ls", C::BAD_FCMP_PREDICATE, C::ICMP_ULE, C::ICMP_ULE},
    {"hi", C::BAD_FCMP_PREDICATE, C::ICMP_UGT, C::ICMP_UGT},
    {"hs", C::BAD_FCMP_PREDICATE, C::ICMP_UGE, C::ICMP_UGE},
    {"equ", C::FCMP_UEQ, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
    {"neu", C::FCMP_UNE, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
    {"ltu", C::FCMP_ULT, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
    {"leu", C::FCMP_ULE, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
    {"gtu", C::FCMP_UGT, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
    {"geu", C::FCMP_UGE, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
    {"num", C::FCMP_ORD, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
    {"nan", C::FCMP_UNO, C::BAD_ICMP_PREDICATE, C::BAD_ICMP_PREDICATE},
};

} // namespace

Value* FunctionTranslator::comparison(const ptx::Instruction& instruction, const ptx::Operand& a,
                                      const ptx::Operand& b, ptx::Type type) {
    if (instruction.modifiers.empty())
        rejectForm(instruction);
    const std::string_view name = instruction.modifiers[0];
    for (const Operator& entry : kOperators) {
        if (entry.name != name)
            continue;
        if (ptx::isFloat(type)) {
            if (entry.ordered == C::BAD_FCMP_PREDICATE)
                rejectForm(instruction);
            return builder_.CreateFCmp(entry.ordered, readFloat(instruction, a, type),
                                       readFloat(instruction, b, type));
        }
        const auto predicate = ptx::isSigned(type) ? entry.asSigned : entry.asUnsigned;
        if (predicate == C::BAD_ICMP_PREDICATE)
            rejectForm(instruction);
        return builder_.CreateICmp(predicate, read(a, type), read(b, type));
    }
    rejectForm(instruction);
}

Value* FunctionTranslator::combine(const ptx::Instruction& instruction, Value* result,
                                   const ptx::Operand* with) {
    if (!with)
        return result;
    Value* other = readInt(*with, 1);
    if (result->getType()->isVectorTy())
        other = builder_.CreateVectorSplat(2, other);
    if (instruction.has("and"))
        return builder_.CreateAnd(result, other);
    if (instruction.has("or"))
        return builder_.CreateOr(result, other);
    if (instruction.has("xor"))
        return builder_.CreateXor(result, other);
    rejectForm(instruction);
}

// setp.cmp.bool p|q, a, b, c: p = (a cmp b) bool c, q = !(a cmp b) bool c. Of pairs of halves p is
// the result of the lower ones and q that of the upper ones.
void FunctionTranslator::setPredicate(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 4);
    const ptx::Operand* with =
        instruction.operands.size() == 4 ? &instruction.operands[3] : nullptr;
    Value* result = comparison(instruction, instruction.operands[1], instruction.operands[2],
                               lastType(instruction));
    const ptx::Operand& target = instruction.operands[0];
    Value* first = combine(instruction, result, with);
    if (target.kind != ptx::OperandKind::kPair) {
        if (isHalfPair(lastType(instruction)))
            rejectForm(instruction);
        write(target, first);
        return;
    }
    Value* second = nullptr;
    if (isHalfPair(lastType(instruction))) {
        second = builder_.CreateExtractElement(first, uint64_t(1));
        first = builder_.CreateExtractElement(first, uint64_t(0));
    } else {
        second = combine(instruction, builder_.CreateNot(result), with);
    }
    write(target.elements[0], first);
    write(target.elements[1], second);
}

void FunctionTranslator::setValue(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 4);
    if (instruction.types.size() != 2)
        rejectForm(instruction);
    const ptx::Operand* with =
        instruction.operands.size() == 4 ? &instruction.operands[3] : nullptr;
    Value* result = combine(instruction,
                            comparison(instruction, instruction.operands[1],
                                       instruction.operands[2], instruction.types[1]),
                            with);
    const ptx::Type to = instruction.types[0];
    const bool pair = result->getType()->isVectorTy();
    // Two results in an integer of 32 bits are one in each half.
    const bool masks = pair && (to == ptx::Type::kU32 || to == ptx::Type::kS32);
    if (isHalfPair(to) != pair && !masks)
        rejectForm(instruction);
    if (isHalfType(to)) {
        llvm::Type* single = builder_.getFloatTy();
        if (isHalfPair(to))
            single = llvm::FixedVectorType::get(single, 2);
        result = narrowHalf(builder_.CreateUIToFP(result, single), to);
    } else if (to == ptx::Type::kF32)
        result = builder_.CreateUIToFP(result, typeOf(to));
    else if (ptx::isFloat(to))
        rejectForm(instruction);
    else if (masks)
        result = builder_.CreateBitCast(
            builder_.CreateSExt(result, llvm::FixedVectorType::get(intType(16), 2)), intType(32));
    else
        result = builder_.CreateSExt(result, intType(bitsOf(to)));
    write(instruction.operands[0], result);
}

void FunctionTranslator::select(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    const ptx::Type type = lastType(instruction);
    write(instruction.operands[0], builder_.CreateSelect(readInt(instruction.operands[3], 1),
                                                         read(instruction.operands[1], type),
                                                         read(instruction.operands[2], type)));
}

// slct d, a, b, c: a where c >= 0 (-0 counts as 0, NaN takes b).
void FunctionTranslator::selectBySign(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    if (instruction.types.size() != 2)
        rejectForm(instruction);
    const ptx::Type type = instruction.types[0];
    Value* chosen = nullptr;
    if (instruction.types[1] == ptx::Type::kF32)
        chosen =
            builder_.CreateFCmpOGE(readFloat(instruction, instruction.operands[3], ptx::Type::kF32),
                                   llvm::ConstantFP::get(builder_.getFloatTy(), 0.0));
    else
        chosen = builder_.CreateICmpSGE(readInt(instruction.operands[3], 32), builder_.getInt32(0));
    write(instruction.operands[0],
          builder_.CreateSelect(chosen, read(instruction.operands[1], type),
                                read(instruction.operands[2], type)));
}

} // namespace sunstone::compiler
