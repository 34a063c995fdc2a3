// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: integer arithmetic and bits. Handlers of opcodes shared with floating point
// dispatch by type.
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

void FunctionTranslator::add(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return floatArithmetic(instruction);
    const unsigned bits = bitsOf(type);
    addInteger(instruction, readInt(instruction.operands[1], bits),
               readInt(instruction.operands[2], bits), bits, false);
}

void FunctionTranslator::subtract(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return floatArithmetic(instruction);
    const unsigned bits = bitsOf(type);
    addInteger(instruction, readInt(instruction.operands[1], bits),
               readInt(instruction.operands[2], bits), bits, true);
}

// a ± b, with the carry flag where the opcode says so (addc, subc, madc read it; .cc writes it).
// The flag is an adder's carry, as code of nvcc for 128-bit division counts on: a subtraction sets
// it where it does not borrow.
void FunctionTranslator::addInteger(const ptx::Instruction& instruction, Value* a, Value* b,
                                    unsigned bits, bool subtract) {
    const bool readsCarry = instruction.opcode.back() == 'c'; // addc, subc, madc
    const bool writesCarry = instruction.has("cc");
    const ptx::Operand& target = instruction.operands[0];
    const bool isSigned = ptx::isSigned(lastType(instruction));
    if (instruction.has("sat")) {
        write(
            target,
            intrinsicCall(subtract ? llvm::Intrinsic::ssub_sat : llvm::Intrinsic::sadd_sat, {a, b}),
            true);
        return;
    }
    if (!readsCarry && !writesCarry) {
        write(target, subtract ? builder_.CreateSub(a, b) : builder_.CreateAdd(a, b), isSigned);
        return;
    }
    const auto id =
        subtract ? llvm::Intrinsic::usub_with_overflow : llvm::Intrinsic::uadd_with_overflow;
    Value* pair = intrinsicCall(id, {a, b});
    Value* result = builder_.CreateExtractValue(pair, 0);
    Value* carry = builder_.CreateExtractValue(pair, 1);
    if (readsCarry) {
        Value* const flag = subtract ? builder_.CreateNot(readCarry()) : readCarry();
        Value* in = builder_.CreateZExt(flag, intType(bits));
        Value* second = intrinsicCall(id, {result, in});
        result = builder_.CreateExtractValue(second, 0);
        carry = builder_.CreateOr(carry, builder_.CreateExtractValue(second, 1));
    }
    write(target, result, isSigned);
    if (writesCarry)
        writeCarry(subtract ? builder_.CreateNot(carry) : carry);
}

void FunctionTranslator::multiply(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return floatArithmetic(instruction);
    const unsigned bits = bitsOf(type);
    const bool isSigned = ptx::isSigned(type);
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    if (instruction.has("wide") || instruction.has("hi")) {
        llvm::Type* wide = intType(bits * 2);
        Value* product = builder_.CreateMul(
            isSigned ? builder_.CreateSExt(a, wide) : builder_.CreateZExt(a, wide),
            isSigned ? builder_.CreateSExt(b, wide) : builder_.CreateZExt(b, wide));
        if (instruction.has("hi"))
            product = builder_.CreateTrunc(builder_.CreateLShr(product, bits), intType(bits));
        write(instruction.operands[0], product, isSigned);
        return;
    }
    write(instruction.operands[0], builder_.CreateMul(a, b), isSigned);
}

void FunctionTranslator::multiplyAdd(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 5);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return fusedMultiplyAdd(instruction);
    const unsigned bits = bitsOf(type);
    const bool isSigned = ptx::isSigned(type);
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    if (instruction.has("wide")) {
        llvm::Type* wide = intType(bits * 2);
        Value* product = builder_.CreateMul(
            isSigned ? builder_.CreateSExt(a, wide) : builder_.CreateZExt(a, wide),
            isSigned ? builder_.CreateSExt(b, wide) : builder_.CreateZExt(b, wide));
        write(instruction.operands[0],
              builder_.CreateAdd(product, readInt(instruction.operands[3], bits * 2)));
        return;
    }
    Value* product = nullptr;
    if (instruction.has("hi")) {
        llvm::Type* wide = intType(bits * 2);
        product = builder_.CreateMul(
            isSigned ? builder_.CreateSExt(a, wide) : builder_.CreateZExt(a, wide),
            isSigned ? builder_.CreateSExt(b, wide) : builder_.CreateZExt(b, wide));
        product = builder_.CreateTrunc(builder_.CreateLShr(product, bits), intType(bits));
    } else {
        product = builder_.CreateMul(a, b);
    }
    addInteger(instruction, product, readInt(instruction.operands[3], bits), bits, false);
}

// mul24/mad24: the low 24 bits of the operands; .hi takes bits 16 to 47 of the 48-bit product.
void FunctionTranslator::multiply24(const ptx::Instruction& instruction) {
    const bool adds = instruction.opcode == "mad24";
    operandCount(instruction, adds ? 4 : 3, adds ? 4 : 3);
    const bool isSigned = ptx::isSigned(lastType(instruction));
    const auto operand = [&](const ptx::Operand& source) {
        Value* value = builder_.CreateTrunc(readInt(source, 32), intType(24));
        return isSigned ? builder_.CreateSExt(value, intType(64))
                        : builder_.CreateZExt(value, intType(64));
    };
    Value* product =
        builder_.CreateMul(operand(instruction.operands[1]), operand(instruction.operands[2]));
    if (instruction.has("hi"))
        product = builder_.CreateLShr(product, 16);
    Value* result = builder_.CreateTrunc(product, intType(32));
    if (adds) {
        Value* addend = readInt(instruction.operands[3], 32);
        result = instruction.has("sat") ? intrinsicCall(llvm::Intrinsic::sadd_sat, {result, addend})
                                        : builder_.CreateAdd(result, addend);
    }
    write(instruction.operands[0], result, isSigned);
}

// Division by zero must not trap as on x86: quotient and remainder are all ones, as on GPUs.
// INT_MIN / -1 wraps.
void FunctionTranslator::divide(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return floatDivide(instruction);
    const unsigned bits = bitsOf(type);
    const bool isSigned = ptx::isSigned(type);
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    llvm::Constant* one = llvm::ConstantInt::get(intType(bits), 1);
    Value* isZero = builder_.CreateIsNull(b);
    Value* result = nullptr;
    if (isSigned) {
        Value* isMinusOne =
            builder_.CreateICmpEQ(b, llvm::ConstantInt::getSigned(intType(bits), -1));
        Value* unsafe = builder_.CreateOr(isZero, isMinusOne);
        Value* quotient = builder_.CreateSDiv(a, builder_.CreateSelect(unsafe, one, b));
        result = builder_.CreateSelect(isMinusOne, builder_.CreateNeg(a), quotient);
    } else {
        result = builder_.CreateUDiv(a, builder_.CreateSelect(isZero, one, b));
    }
    result = builder_.CreateSelect(isZero, llvm::ConstantInt::getSigned(intType(bits), -1), result);
    write(instruction.operands[0], result, isSigned);
}

void FunctionTranslator::remainder(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = lastType(instruction);
    const unsigned bits = bitsOf(type);
    const bool isSigned = ptx::isSigned(type);
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    llvm::Constant* one = llvm::ConstantInt::get(intType(bits), 1);
    Value* isZero = builder_.CreateIsNull(b);
    Value* unsafe = isZero;
    if (isSigned)
        unsafe = builder_.CreateOr(
            isZero, builder_.CreateICmpEQ(b, llvm::ConstantInt::getSigned(intType(bits), -1)));
    Value* divisor = builder_.CreateSelect(unsafe, one, b);
    Value* result = isSigned ? builder_.CreateSRem(a, divisor) : builder_.CreateURem(a, divisor);
    result = builder_.CreateSelect(isZero, llvm::ConstantInt::getSigned(intType(bits), -1), result);
    write(instruction.operands[0], result, isSigned);
}

void FunctionTranslator::negate(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return floatSign(instruction);
    write(instruction.operands[0],
          builder_.CreateNeg(readInt(instruction.operands[1], bitsOf(type))), true);
}

void FunctionTranslator::absolute(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return floatSign(instruction);
    write(instruction.operands[0],
          intrinsicCall(llvm::Intrinsic::abs,
                        {readInt(instruction.operands[1], bitsOf(type)), builder_.getFalse()}),
          true);
}

void FunctionTranslator::minimum(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 4);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        return floatMinimum(instruction);
    const bool isMin = instruction.opcode == "min";
    const bool isSigned = ptx::isSigned(type);
    const unsigned bits = bitsOf(type);
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    const auto id = isMin ? (isSigned ? llvm::Intrinsic::smin : llvm::Intrinsic::umin)
                          : (isSigned ? llvm::Intrinsic::smax : llvm::Intrinsic::umax);
    Value* result = intrinsicCall(id, {a, b});
    if (instruction.has("relu"))
        result = intrinsicCall(llvm::Intrinsic::smax,
                               {result, llvm::ConstantInt::get(intType(bits), 0)});
    write(instruction.operands[0], result, isSigned);
}

// Two halves of a word at once.
void FunctionTranslator::packedArithmetic(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const bool isSigned = instruction.has("s16x2");
    llvm::Type* pair = llvm::FixedVectorType::get(intType(16), 2);
    Value* a = builder_.CreateBitCast(readInt(instruction.operands[1], 32), pair);
    Value* b = builder_.CreateBitCast(readInt(instruction.operands[2], 32), pair);
    Value* result = nullptr;
    if (instruction.facts->operation == ptx::Operation::kAdd)
        result = builder_.CreateAdd(a, b);
    else if (instruction.opcode == "min")
        result = intrinsicCall(isSigned ? llvm::Intrinsic::smin : llvm::Intrinsic::umin, {a, b});
    else if (instruction.opcode == "max")
        result = intrinsicCall(isSigned ? llvm::Intrinsic::smax : llvm::Intrinsic::umax, {a, b});
    else
        rejectForm(instruction);
    if (instruction.has("relu"))
        result = intrinsicCall(llvm::Intrinsic::smax, {result, llvm::Constant::getNullValue(pair)});
    write(instruction.operands[0], builder_.CreateBitCast(result, intType(32)));
}

void FunctionTranslator::sumAbsoluteDifference(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    const ptx::Type type = lastType(instruction);
    const unsigned bits = bitsOf(type);
    const bool isSigned = ptx::isSigned(type);
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    Value* less = isSigned ? builder_.CreateICmpSLT(a, b) : builder_.CreateICmpULT(a, b);
    Value* difference =
        builder_.CreateSelect(less, builder_.CreateSub(b, a), builder_.CreateSub(a, b));
    write(instruction.operands[0],
          builder_.CreateAdd(difference, readInt(instruction.operands[3], bits)), isSigned);
}

void FunctionTranslator::logic(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const unsigned bits = bitsOf(lastType(instruction));
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    Value* result = instruction.opcode == "and"  ? builder_.CreateAnd(a, b)
                    : instruction.opcode == "or" ? builder_.CreateOr(a, b)
                                                 : builder_.CreateXor(a, b);
    write(instruction.operands[0], result);
}

void FunctionTranslator::logicNot(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const unsigned bits = bitsOf(lastType(instruction));
    Value* a = readInt(instruction.operands[1], bits);
    write(instruction.operands[0],
          instruction.opcode == "not"
              ? builder_.CreateNot(a)
              : builder_.CreateZExt(builder_.CreateIsNull(a), intType(bits)));
}

// lop3: bit k of the table is the result for inputs a,b,c = bits 2,1,0 of k.
void FunctionTranslator::lookup3(const ptx::Instruction& instruction) {
    operandCount(instruction, 5, 6);
    const ptx::Operand& target = instruction.operands[0];
    const bool pair = target.kind == ptx::OperandKind::kPair;
    if (instruction.types.size() != 1 || pair != (instruction.operands.size() == 6))
        rejectForm(instruction);
    const ptx::Operand& table = instruction.operands[4];
    if (table.kind != ptx::OperandKind::kInteger)
        reject(instruction, ErrorCode::kInvalidPtx, "the table must be a number");
    Value* inputs[3];
    for (int i = 0; i < 3; ++i)
        inputs[i] = readInt(instruction.operands[size_t(i) + 1], 32);
    Value* result = builder_.getInt32(0);
    for (int k = 0; k < 8; ++k) {
        if (!((table.integer >> k) & 1))
            continue;
        Value* term = builder_.getInt32(~0u);
        for (int i = 0; i < 3; ++i)
            term = builder_.CreateAnd(term, (k >> (2 - i)) & 1 ? inputs[i]
                                                               : builder_.CreateNot(inputs[i]));
        result = builder_.CreateOr(result, term);
    }
    if (!pair)
        return write(target, result);
    // lop3.and, lop3.or: the second result tells whether the first is nonzero, combined with a
    // predicate.
    write(target.elements[1],
          combine(instruction, builder_.CreateIsNotNull(result), &instruction.operands[5]));
    write(target.elements[0], result);
}

// PTX shifts clamp their amount at the width; LLVM's are undefined there.
Value* FunctionTranslator::shiftLeft(Value* value, Value* amount) {
    const unsigned bits = value->getType()->getIntegerBitWidth();
    Value* inRange =
        builder_.CreateICmpULT(amount, llvm::ConstantInt::get(amount->getType(), bits));
    Value* safe =
        builder_.CreateSelect(inRange, amount, llvm::ConstantInt::get(amount->getType(), 0));
    Value* shifted = builder_.CreateShl(value, builder_.CreateZExtOrTrunc(safe, value->getType()));
    return builder_.CreateSelect(inRange, shifted, llvm::ConstantInt::get(value->getType(), 0));
}

Value* FunctionTranslator::shiftRight(Value* value, Value* amount, bool isSigned) {
    const unsigned bits = value->getType()->getIntegerBitWidth();
    llvm::Type* amountType = amount->getType();
    Value* inRange = builder_.CreateICmpULT(amount, llvm::ConstantInt::get(amountType, bits));
    if (isSigned) {
        Value* safe =
            builder_.CreateSelect(inRange, amount, llvm::ConstantInt::get(amountType, bits - 1));
        return builder_.CreateAShr(value, builder_.CreateZExtOrTrunc(safe, value->getType()));
    }
    Value* safe = builder_.CreateSelect(inRange, amount, llvm::ConstantInt::get(amountType, 0));
    Value* shifted = builder_.CreateLShr(value, builder_.CreateZExtOrTrunc(safe, value->getType()));
    return builder_.CreateSelect(inRange, shifted, llvm::ConstantInt::get(value->getType(), 0));
}

void FunctionTranslator::shift(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = lastType(instruction);
    Value* value = readInt(instruction.operands[1], bitsOf(type));
    Value* amount = readInt(instruction.operands[2], 32);
    const bool isSigned = ptx::isSigned(type);
    write(instruction.operands[0],
          instruction.opcode == "shl" ? shiftLeft(value, amount)
                                      : shiftRight(value, amount, isSigned),
          isSigned);
}

// shf: a is the low, b the high word of the value that is shifted.
void FunctionTranslator::funnelShift(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    Value* low = readInt(instruction.operands[1], 32);
    Value* high = readInt(instruction.operands[2], 32);
    Value* amount = readInt(instruction.operands[3], 32);
    const bool left = instruction.has("l");
    if (instruction.has("clamp")) {
        Value* clamped = intrinsicCall(llvm::Intrinsic::umin, {amount, builder_.getInt32(32)});
        Value* wide =
            builder_.CreateOr(builder_.CreateShl(builder_.CreateZExt(high, intType(64)), 32),
                              builder_.CreateZExt(low, intType(64)));
        Value* distance = builder_.CreateZExt(clamped, intType(64));
        Value* result = left ? builder_.CreateLShr(builder_.CreateShl(wide, distance), 32)
                             : builder_.CreateLShr(wide, distance);
        write(instruction.operands[0], builder_.CreateTrunc(result, intType(32)));
        return;
    }
    write(instruction.operands[0],
          intrinsicCall(left ? llvm::Intrinsic::fshl : llvm::Intrinsic::fshr, {high, low, amount}));
}

// bfe d, a, pos, len: only the low 8 bits of pos and len count. Past the end of the register the
// field is filled with the sign (.s: of the field's highest bit that exists) or zeros.
void FunctionTranslator::extractField(const ptx::Instruction& instruction) {
    const ptx::Type type = lastType(instruction);
    const unsigned bits = bitsOf(type);
    const bool isSigned = ptx::isSigned(type);
    llvm::IntegerType* wide = intType(bits);
    if (instruction.opcode == "szext") { // extend from a bit position, clamped or wrapped
        operandCount(instruction, 3, 3);
        Value* a = readInt(instruction.operands[1], 32);
        Value* width = readInt(instruction.operands[2], 32);
        if (instruction.has("wrap"))
            width = builder_.CreateAnd(width, builder_.getInt32(31));
        else
            width = intrinsicCall(llvm::Intrinsic::umin, {width, builder_.getInt32(32)});
        Value* unused = builder_.CreateSub(builder_.getInt32(32), width);
        write(instruction.operands[0],
              builder_.CreateSelect(builder_.CreateIsNull(width), builder_.getInt32(0),
                                    shiftRight(shiftLeft(a, unused), unused, isSigned)),
              isSigned);
        return;
    }
    operandCount(instruction, 4, 4);
    Value* a = readInt(instruction.operands[1], bits);
    Value* position = builder_.CreateAnd(readInt(instruction.operands[2], 32), 255);
    Value* length = builder_.CreateAnd(readInt(instruction.operands[3], 32), 255);
    Value* shifted = shiftRight(a, position, isSigned);
    // Keep the low `length` bits. The sign is the field's top bit; if the field reaches past the
    // register, it is the register's, which the arithmetic shift has already copied down.
    Value* unused = builder_.CreateSub(builder_.getInt32(bits), length);
    Value* full = builder_.CreateICmpUGE(length, builder_.getInt32(bits));
    Value* part = shiftRight(shiftLeft(shifted, unused), unused, isSigned);
    Value* result = builder_.CreateSelect(full, shifted, part);
    result = builder_.CreateSelect(builder_.CreateIsNull(length), llvm::ConstantInt::get(wide, 0),
                                   result);
    write(instruction.operands[0], result, isSigned);
}

// bfi f, a, b, pos, len: len bits of a into b from pos on.
void FunctionTranslator::insertField(const ptx::Instruction& instruction) {
    operandCount(instruction, 5, 5);
    const unsigned bits = bitsOf(lastType(instruction));
    Value* a = readInt(instruction.operands[1], bits);
    Value* b = readInt(instruction.operands[2], bits);
    Value* position = builder_.CreateAnd(readInt(instruction.operands[3], 32), 255);
    Value* length = builder_.CreateAnd(readInt(instruction.operands[4], 32), 255);
    Value* ones = llvm::ConstantInt::getSigned(intType(bits), -1);
    Value* mask = shiftLeft(builder_.CreateNot(shiftLeft(ones, length)), position);
    Value* inserted = builder_.CreateAnd(shiftLeft(a, position), mask);
    write(instruction.operands[0],
          builder_.CreateOr(inserted, builder_.CreateAnd(b, builder_.CreateNot(mask))));
}

// bfind: position of the highest set bit (of the highest bit unlike the sign for .s), or the
// shift that brings it to the top; all ones without such a bit.
void FunctionTranslator::findBit(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Type type = lastType(instruction);
    const unsigned bits = bitsOf(type);
    Value* a = readInt(instruction.operands[1], bits);
    if (ptx::isSigned(type)) {
        Value* negative = builder_.CreateICmpSLT(a, llvm::ConstantInt::get(intType(bits), 0));
        a = builder_.CreateSelect(negative, builder_.CreateNot(a), a);
    }
    Value* zeros = builder_.CreateZExtOrTrunc(
        intrinsicCall(llvm::Intrinsic::ctlz, {a, builder_.getFalse()}), intType(32));
    Value* result = instruction.has("shiftamt")
                        ? zeros
                        : builder_.CreateSub(builder_.getInt32(bits - 1), zeros);
    write(instruction.operands[0],
          builder_.CreateSelect(builder_.CreateIsNull(a), builder_.getInt32(~0u), result));
}

void FunctionTranslator::countBits(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const unsigned bits = bitsOf(lastType(instruction));
    Value* a = readInt(instruction.operands[1], bits);
    if (instruction.opcode == "brev") {
        write(instruction.operands[0], intrinsicCall(llvm::Intrinsic::bitreverse, {a}));
        return;
    }
    Value* count = instruction.opcode == "clz"
                       ? intrinsicCall(llvm::Intrinsic::ctlz, {a, builder_.getFalse()})
                       : intrinsicCall(llvm::Intrinsic::ctpop, {a});
    write(instruction.operands[0], builder_.CreateZExtOrTrunc(count, intType(32)));
}

void FunctionTranslator::fieldMask(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    Value* position = readInt(instruction.operands[1], 32);
    Value* width = readInt(instruction.operands[2], 32);
    if (instruction.has("wrap")) {
        position = builder_.CreateAnd(position, 31);
        width = builder_.CreateAnd(width, 31);
    }
    Value* ones = builder_.getInt32(~0u);
    Value* mask = builder_.CreateNot(shiftLeft(ones, width));
    write(instruction.operands[0], shiftLeft(mask, position));
}

// prmt: four bytes picked from the eight of {b, a}; selector bit 3 repeats the byte's sign.
void FunctionTranslator::permute(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    Value* a = readInt(instruction.operands[1], 32);
    Value* b = readInt(instruction.operands[2], 32);
    Value* selector = readInt(instruction.operands[3], 32);
    Value* bytes = builder_.CreateOr(builder_.CreateShl(builder_.CreateZExt(b, intType(64)), 32),
                                     builder_.CreateZExt(a, intType(64)));
    const auto byteAt = [&](Value* index) { // index: 0..7, i32
        Value* distance = builder_.CreateShl(builder_.CreateZExt(index, intType(64)), 3);
        return builder_.CreateTrunc(builder_.CreateLShr(bytes, distance), intType(8));
    };
    Value* low = builder_.CreateAnd(selector, 3);
    Value* result = builder_.getInt32(0);
    for (unsigned i = 0; i < 4; ++i) {
        Value* byte = nullptr;
        llvm::Constant* number = builder_.getInt32(i);
        if (instruction.has("f4e")) {
            byte = byteAt(builder_.CreateAdd(low, number));
        } else if (instruction.has("b4e")) {
            byte = byteAt(builder_.CreateAnd(builder_.CreateSub(low, number), 7));
        } else if (instruction.has("rc8")) {
            byte = byteAt(low);
        } else if (instruction.has("ecl")) {
            byte = byteAt(intrinsicCall(llvm::Intrinsic::umax, {low, number}));
        } else if (instruction.has("ecr")) {
            byte = byteAt(intrinsicCall(llvm::Intrinsic::umin, {low, number}));
        } else if (instruction.has("rc16")) {
            byte = byteAt(builder_.CreateOr(builder_.CreateShl(builder_.CreateAnd(low, 1), 1),
                                            builder_.getInt32(i & 1)));
        } else {
            Value* control = builder_.CreateAnd(builder_.CreateLShr(selector, i * 4), 15);
            byte = byteAt(builder_.CreateAnd(control, 7));
            Value* sign = builder_.CreateAShr(byte, 7);
            byte = builder_.CreateSelect(builder_.CreateICmpUGE(control, builder_.getInt32(8)),
                                         sign, byte);
        }
        result = builder_.CreateOr(
            result, builder_.CreateShl(builder_.CreateZExt(byte, intType(32)), i * 8));
    }
    write(instruction.operands[0], result);
}

// dp4a d, a, b, c: four byte products; dp2a: two of a's halves with two bytes of b (.lo/.hi).
void FunctionTranslator::dotProduct(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    if (instruction.types.size() < 2)
        rejectForm(instruction);
    const bool signedA = ptx::isSigned(instruction.types[0]);
    const bool signedB = ptx::isSigned(instruction.types[1]);
    Value* a = readInt(instruction.operands[1], 32);
    Value* b = readInt(instruction.operands[2], 32);
    Value* sum = readInt(instruction.operands[3], 32);
    const auto piece = [&](Value* word, unsigned shift, unsigned bits, bool isSigned) {
        Value* part = builder_.CreateTrunc(builder_.CreateLShr(word, shift), intType(bits));
        return isSigned ? builder_.CreateSExt(part, intType(32))
                        : builder_.CreateZExt(part, intType(32));
    };
    if (instruction.opcode == "dp4a") {
        for (unsigned i = 0; i < 4; ++i)
            sum = builder_.CreateAdd(
                sum, builder_.CreateMul(piece(a, i * 8, 8, signedA), piece(b, i * 8, 8, signedB)));
    } else {
        const unsigned base = instruction.has("hi") ? 16 : 0;
        for (unsigned i = 0; i < 2; ++i)
            sum = builder_.CreateAdd(sum, builder_.CreateMul(piece(a, i * 16, 16, signedA),
                                                             piece(b, base + i * 8, 8, signedB)));
    }
    write(instruction.operands[0], sum);
}

void FunctionTranslator::findNthSet(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 4);
    llvm::Type* word = intType(32);
    write(instruction.operands[0],
          builder_.CreateCall(unit_.helper("sunstone_fns", word, {word, word, word}),
                              {readInt(instruction.operands[1], 32),
                               readInt(instruction.operands[2], 32),
                               readInt(instruction.operands[3], 32)}));
}

} // namespace sunstone::compiler
