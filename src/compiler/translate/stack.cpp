// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: stack memory of a size known only at run time (alloca), and its release
// (stacksave, stackrestore). Source: PTX ISA manual, "Stack Manipulation Instructions".
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

namespace {

constexpr int64_t kDefaultAlignment = 8, kMostAlignment = 128;

} // namespace

void FunctionTranslator::checkStackType(const ptx::Instruction& instruction) const {
    if (instruction.types.size() != 1 || ptx::sizeOf(instruction.types[0]) != 8)
        reject(instruction, ErrorCode::kNotSupported, "stack addresses have 64 bits: use .u64");
}

// The alignment requested by the instruction.
int64_t FunctionTranslator::checkStack(const ptx::Instruction& instruction) const {
    operandCount(instruction, 2, 3);
    checkStackType(instruction);
    if (instruction.operands.size() == 2)
        return kDefaultAlignment;
    const ptx::Operand& given = instruction.operands[2];
    const int64_t alignment = given.integer;
    if (given.kind != ptx::OperandKind::kInteger || alignment < 1 || alignment > kMostAlignment ||
        (alignment & (alignment - 1)) != 0)
        reject(instruction, ErrorCode::kInvalidPtx,
               "the alignment must be a power of two between 1 and 128");
    return alignment;
}

void FunctionTranslator::allocateStack(const ptx::Instruction& instruction) {
    const int64_t alignment = checkStack(instruction);
    // A large frame must touch the stack's guard page instead of skipping it.
    function_.addFnAttr("probe-stack", "inline-asm");
    llvm::AllocaInst* memory =
        builder_.CreateAlloca(builder_.getInt8Ty(), readInt(instruction.operands[1], 64), "stack");
    memory->setAlignment(llvm::Align(uint64_t(alignment)));
    write(instruction.operands[0], memory);
}

void FunctionTranslator::saveStack(const ptx::Instruction& instruction) {
    operandCount(instruction, 1, 1);
    checkStackType(instruction);
    write(instruction.operands[0],
          builder_.CreateIntrinsic(llvm::Intrinsic::stacksave, {builder_.getPtrTy()}, {}));
}

void FunctionTranslator::restoreStack(const ptx::Instruction& instruction) {
    operandCount(instruction, 1, 1);
    checkStackType(instruction);
    Value* top = builder_.CreateIntToPtr(readInt(instruction.operands[0], 64), builder_.getPtrTy());
    builder_.CreateIntrinsic(llvm::Intrinsic::stackrestore, {builder_.getPtrTy()}, {top});
}

} // namespace sunstone::compiler
