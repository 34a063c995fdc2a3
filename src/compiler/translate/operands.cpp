// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: types, registers and operands.
#include "compiler/translate/function_translator.h"

#include "compiler/translate/visit_registers.h"

#include <llvm/ADT/APFloat.h>
#include <llvm/IR/Constants.h>

namespace sunstone::compiler {

llvm::Type* FunctionTranslator::typeOf(ptx::Type type) {
    switch (type) {
    case ptx::Type::kF16:
        return builder_.getHalfTy();
    case ptx::Type::kF16x2:
        return llvm::FixedVectorType::get(builder_.getHalfTy(), 2);
    case ptx::Type::kF32:
        return builder_.getFloatTy();
    case ptx::Type::kF64:
        return builder_.getDoubleTy();
    default:
        return intType(std::max(1u, bitsOf(type)));
    }
}

// The same bits as another type; a different width is truncated or extended.
Value* FunctionTranslator::coerce(Value* value, llvm::Type* type, bool isSigned) {
    llvm::Type* from = value->getType();
    if (from == type)
        return value;
    if (from->isPointerTy()) {
        value = builder_.CreatePtrToInt(value, builder_.getInt64Ty());
        from = value->getType();
    }
    const unsigned fromBits = unsigned(from->getPrimitiveSizeInBits());
    const unsigned toBits = unsigned(type->getPrimitiveSizeInBits());
    if (fromBits == toBits)
        return builder_.CreateBitCast(value, type);
    if (!from->isIntegerTy())
        value = builder_.CreateBitCast(value, intType(fromBits));
    value = isSigned ? builder_.CreateSExtOrTrunc(value, intType(toBits))
                     : builder_.CreateZExtOrTrunc(value, intType(toBits));
    return type->isIntegerTy() ? value : builder_.CreateBitCast(value, type);
}

Value* FunctionTranslator::readSlot(uint32_t index) {
    Slot& slot = slots_[index];
    if (!slot.type)
        return builder_.getInt32(0);
    if (slot.current && slot.region == region_)
        return slot.current;
    slot.current = slot.memory ? static_cast<Value*>(builder_.CreateLoad(slot.type, slot.memory))
                               : llvm::Constant::getNullValue(slot.type);
    slot.region = region_;
    return slot.current;
}

void FunctionTranslator::writeSlot(uint32_t index, Value* value, bool isSigned) {
    Slot& slot = slots_[index];
    if (!slot.type)
        return;
    value = coerce(value, slot.type, isSigned);
    if (guardLog_) {
        bool logged = false;
        for (const auto& [known, old] : *guardLog_)
            logged |= known == index;
        if (!logged)
            guardLog_->emplace_back(index, readSlot(index));
    }
    slot.current = value;
    slot.region = region_;
    if (slot.memory)
        builder_.CreateStore(value, slot.memory);
    if (index < registerOfSlot_.size())
        debug_->atValue(builder_, registerOfSlot_[index], value);
}

Value* FunctionTranslator::readCarry() {
    return readSlot(carrySlot_);
}
void FunctionTranslator::writeCarry(Value* carry) {
    writeSlot(carrySlot_, carry, false);
}

uint32_t FunctionTranslator::slotOf(const ptx::Operand& operand) const {
    SUNSTONE_CHECK(operand.index < firstSlot_.size());
    const unsigned width = std::max(1u, source_.registers[operand.index].vector);
    if (operand.component >= int(width))
        reject(*current_, ErrorCode::kInvalidPtx, "the register has no such component");
    return firstSlot_[operand.index] + uint32_t(std::max<int>(0, operand.component));
}

Value* FunctionTranslator::readImmediate(const ptx::Operand& operand, llvm::Type* type) {
    if (operand.kind == ptx::OperandKind::kInteger) {
        if (type->isIntegerTy())
            return llvm::ConstantInt::get(type, uint64_t(operand.integer), true);
        if (type->isVectorTy())
            return coerce(builder_.getInt32(uint32_t(operand.integer)), type);
        return llvm::ConstantFP::get(type, double(operand.integer));
    }
    const bool isDouble = operand.floatBits == 64;
    const uint64_t bits = uint64_t(operand.integer);
    if (type->isIntegerTy() && type->getIntegerBitWidth() >= operand.floatBits)
        return llvm::ConstantInt::get(type, bits);
    llvm::APFloat number =
        isDouble ? llvm::APFloat(llvm::APFloat::IEEEdouble(), llvm::APInt(64, bits))
                 : llvm::APFloat(llvm::APFloat::IEEEsingle(), llvm::APInt(32, bits & 0xffffffffu));
    llvm::Type* target = type;
    if (type->isIntegerTy()) // a decimal number used with 32 or 16 bits
        target = type->getIntegerBitWidth() == 16 ? builder_.getHalfTy() : builder_.getFloatTy();
    if (type->isVectorTy())
        target = builder_.getHalfTy();
    bool inexact = false;
    number.convert(target->getFltSemantics(), llvm::APFloat::rmNearestTiesToEven, &inexact);
    llvm::Constant* constant = llvm::ConstantFP::get(builder_.getContext(), number);
    if (type->isVectorTy())
        return llvm::ConstantVector::getSplat(llvm::ElementCount::getFixed(2), constant);
    return coerce(constant, type);
}

// The operand's bits as `type`.
Value* FunctionTranslator::readAs(const ptx::Operand& operand, llvm::Type* type) {
    switch (operand.kind) {
    case ptx::OperandKind::kRegister: {
        Value* value = coerce(readSlot(slotOf(operand)), type);
        if (!operand.negated)
            return value;
        return type->isIntegerTy(1)  ? builder_.CreateNot(value)
               : type->isIntegerTy() ? builder_.CreateNeg(value)
                                     : builder_.CreateFNeg(value);
    }
    case ptx::OperandKind::kInteger:
    case ptx::OperandKind::kFloat:
        return readImmediate(operand, type);
    case ptx::OperandKind::kSpecial:
        return coerce(special(operand.name, operand.location), type);
    case ptx::OperandKind::kSymbol: {
        // A texture reference stands for the handle that it holds.
        const ptx::Variable* variable = unit_.findVariable(module_, operand.name);
        if (variable && variable->type >= ptx::Type::kTexref)
            return coerce(textureHandle(operand), type);
        Value* address = builder_.CreatePtrToInt(
            indexedPointer(symbolAddress(operand.name, operand.location), operand),
            builder_.getInt64Ty());
        return coerce(builder_.CreateAdd(address, builder_.getInt64(uint64_t(operand.offset))),
                      type);
    }
    case ptx::OperandKind::kVector: { // packed: first element in the low bits
        const unsigned bits = unsigned(type->getPrimitiveSizeInBits());
        const unsigned count = unsigned(operand.elements.size());
        if (count == 0 || bits % count != 0)
            reject(*current_, ErrorCode::kInvalidPtx, "vector operand does not fit the type");
        Value* packed = llvm::ConstantInt::get(intType(bits), 0);
        for (unsigned i = 0; i < count; ++i) {
            Value* part = coerce(readAs(operand.elements[i], intType(bits / count)), intType(bits));
            packed =
                builder_.CreateOr(packed, builder_.CreateShl(part, uint64_t(i) * bits / count));
        }
        return coerce(packed, type);
    }
    case ptx::OperandKind::kSink: // an unused input may have any value
        return llvm::Constant::getNullValue(type);
    default:
        reject(*current_, ErrorCode::kInvalidPtx, "operand of an unexpected kind");
    }
}

Value* FunctionTranslator::read(const ptx::Operand& operand, ptx::Type type) {
    return readAs(operand, typeOf(type));
}

Value* FunctionTranslator::readInt(const ptx::Operand& operand, unsigned bits) {
    return readAs(operand, intType(bits));
}

void FunctionTranslator::write(const ptx::Operand& operand, Value* value, bool isSigned) {
    switch (operand.kind) {
    case ptx::OperandKind::kSink:
        return;
    case ptx::OperandKind::kRegister: {
        if (operand.component < 0 && source_.registers[operand.index].vector > 1)
            break;
        writeSlot(slotOf(operand), value, isSigned);
        return;
    }
    case ptx::OperandKind::kVector: { // unpack
        const unsigned bits = unsigned(value->getType()->getPrimitiveSizeInBits());
        const unsigned count = unsigned(operand.elements.size());
        if (count == 0 || bits % count != 0)
            break;
        Value* packed = coerce(value, intType(bits));
        for (unsigned i = 0; i < count; ++i)
            write(operand.elements[i],
                  builder_.CreateTrunc(builder_.CreateLShr(packed, uint64_t(i) * bits / count),
                                       intType(bits / count)));
        return;
    }
    default:
        break;
    }
    reject(*current_, ErrorCode::kInvalidPtx, "cannot write to this operand");
}

std::vector<ptx::Operand> FunctionTranslator::elements(const ptx::Operand& operand) const {
    if (operand.kind == ptx::OperandKind::kVector)
        return operand.elements;
    if (operand.kind == ptx::OperandKind::kRegister && operand.component < 0 &&
        operand.index < source_.registers.size() && source_.registers[operand.index].vector > 1) {
        std::vector<ptx::Operand> parts(source_.registers[operand.index].vector, operand);
        for (size_t i = 0; i < parts.size(); ++i)
            parts[i].component = int8_t(i);
        return parts;
    }
    return {operand};
}

} // namespace sunstone::compiler
