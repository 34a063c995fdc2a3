// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator::visitRegisters: visits every register that an instruction names, with the
// position of its operand and whether it forms an address. Includes the guard.
#pragma once

#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

template <class Visit>
void visitOperandRegisters(const ptx::Operand& operand, size_t position, bool isAddress,
                           size_t registerCount, Visit& visit) {
    const bool named = operand.index < registerCount;
    if (operand.kind == ptx::OperandKind::kRegister && named)
        visit(operand, position, isAddress);
    if ((operand.kind == ptx::OperandKind::kAddress || operand.kind == ptx::OperandKind::kSymbol) &&
        named)
        visit(operand, position, true);
    for (const ptx::Operand& element : operand.elements)
        visitOperandRegisters(element, position,
                              isAddress || operand.kind == ptx::OperandKind::kTexture,
                              registerCount, visit);
}

template <class Visit>
void FunctionTranslator::visitRegisters(const ptx::Instruction& instruction, Visit visit) const {
    const size_t count = source_.registers.size();
    if (instruction.guard >= 0) {
        ptx::Operand guard;
        guard.kind = ptx::OperandKind::kRegister;
        guard.index = uint32_t(instruction.guard);
        visit(guard, size_t(1), true);
    }
    for (size_t i = 0; i < instruction.operands.size(); ++i)
        visitOperandRegisters(instruction.operands[i], i, false, count, visit);
    for (const ptx::Operand& result : instruction.results)
        visitOperandRegisters(result, 0, false, count, visit);
    for (const ptx::Operand& argument : instruction.arguments)
        visitOperandRegisters(argument, 1, false, count, visit);
    visitOperandRegisters(instruction.target, 1, true, count, visit);
}

} // namespace sunstone::compiler
