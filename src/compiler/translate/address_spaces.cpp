// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: isspacep. All spaces share the host's addresses, so the space of an address
// is that of the range which holds it: the block's shared memory, the variables of constant memory,
// the kernel's parameters, the frames of the thread. All other addresses are global ones. Source:
// PTX ISA manual, "Generic Addressing" and "isspacep".
#include "compiler/runtime/lane_functions.h"
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

Value* FunctionTranslator::isWithin(Value* address, Value* begin, Value* bytes) {
    Value* offset = builder_.CreateSub(address, builder_.CreatePtrToInt(begin, intType(64)));
    return builder_.CreateICmpULT(offset, bytes);
}

Value* FunctionTranslator::isShared(Value* address) {
    if (!isKernel())
        return builder_.getFalse();
    Value* bytes = stateField(offsetof(devlib::KernelThread, sharedBytes), intType(32), "bytes");
    return isWithin(
        address, stateField(offsetof(devlib::KernelThread, shared), builder_.getPtrTy(), "shared"),
        builder_.CreateZExt(bytes, intType(64)));
}

// Small constants of a program's module are copied into each piece: a copy's address is constant
// where programs of its piece ask.
Value* FunctionTranslator::isConstant(Value* address) {
    Value* found = builder_.getFalse();
    for (const auto& [module, variable] : unit_.constants()) {
        Value* begin = unit_.isLaunchParams(*variable) ? launchParams()
                                                       : unit_.addVariable(*module, *variable);
        found =
            builder_.CreateOr(found, isWithin(address, begin, builder_.getInt64(variable->size)));
    }
    return found;
}

Value* FunctionTranslator::isParameter(const ptx::Instruction& instruction, Value* address) {
    if (!isKernel() || !source_.isEntry)
        reject(instruction, ErrorCode::kNotSupported,
               "only kernels can ask for the space of parameters");
    Value* found = builder_.getFalse();
    for (const ptx::Variable& parameter : source_.parameters)
        if (const auto place = locals_.find(parameter.name);
            place != locals_.end() && !llvm::isa<llvm::AllocaInst>(place->second))
            found = builder_.CreateOr(
                found, isWithin(address, place->second, builder_.getInt64(parameter.size)));
    return found;
}

Value* FunctionTranslator::isLocal(Value* address) {
    Value* answer = isKernel()
                        ? builder_.CreateCall(
                              unit_.helper(laneFunction(ptx::Lockstep::kFrames).name, intType(32),
                                           {builder_.getPtrTy(), intType(64)}, false),
                              {state(), address})
                        : builder_.CreateCall(unit_.helper("sunstone_is_local_of_program",
                                                           intType(32), {intType(64)}, false),
                                              {address});
    return builder_.CreateIsNotNull(answer);
}

void FunctionTranslator::testAddressSpace(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    Value* address = readInt(instruction.operands[1], 64);
    Value* result = nullptr;
    if (instruction.has("shared") || instruction.has("shared::cta") ||
        instruction.has("shared::cluster"))
        result = isShared(address);
    else if (instruction.has("const"))
        result = isConstant(address);
    else if (instruction.has("param") || instruction.has("param::entry"))
        result = isParameter(instruction, address);
    else if (instruction.has("local"))
        result = isLocal(address);
    else if (instruction.has("global"))
        result = builder_.CreateNot(builder_.CreateOr(
            builder_.CreateOr(isShared(address), isConstant(address)), isLocal(address)));
    else
        rejectForm(instruction);
    write(instruction.operands[0], result);
}

} // namespace sunstone::compiler
