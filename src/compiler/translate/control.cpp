// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: branches, returns, calls.
#include "compiler/translate/call_site.h"
#include "compiler/translate/callable.h"
#include "compiler/translate/function_translator.h"

#include <llvm/IR/CFG.h>

namespace sunstone::compiler {

void FunctionTranslator::branch(const ptx::Instruction& instruction) {
    operandCount(instruction, 1, 1);
    const ptx::Operand& target = instruction.operands[0];
    if (target.kind != ptx::OperandKind::kLabel || target.index >= labels_.size())
        reject(instruction, ErrorCode::kInvalidPtx, "label expected");
    llvm::BasicBlock* label = labels_[target.index];
    if (instruction.guard < 0) {
        builder_.CreateBr(label);
        return;
    }
    Value* guard = coerce(readSlot(firstSlot_[size_t(instruction.guard)]), builder_.getInt1Ty());
    llvm::BasicBlock* next = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    if (instruction.guardNegated)
        builder_.CreateCondBr(guard, next, label);
    else
        builder_.CreateCondBr(guard, label, next);
    builder_.SetInsertPoint(next);
}

// brx.idx index, list. An index past the list is undefined in PTX; here it goes to the first.
void FunctionTranslator::branchIndexed(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Operand& list = instruction.operands[1];
    const ptx::BranchTargets* targets = nullptr;
    for (const ptx::BranchTargets& candidate : source_.branchTargets)
        if (candidate.name == list.name)
            targets = &candidate;
    if (!targets || targets->labels.empty())
        reject(instruction, ErrorCode::kInvalidPtx,
               message("no .branchtargets \"", list.name, "\" in this function"));
    llvm::BasicBlock* next = nullptr;
    if (instruction.guard >= 0) {
        Value* guard =
            coerce(readSlot(firstSlot_[size_t(instruction.guard)]), builder_.getInt1Ty());
        llvm::BasicBlock* taken = llvm::BasicBlock::Create(unit_.context(), "", &function_);
        next = llvm::BasicBlock::Create(unit_.context(), "", &function_);
        if (instruction.guardNegated)
            guard = builder_.CreateNot(guard);
        readInt(instruction.operands[0], 32);
        builder_.CreateCondBr(guard, taken, next);
        builder_.SetInsertPoint(taken);
    }
    auto* jump =
        builder_.CreateSwitch(readInt(instruction.operands[0], 32), labels_[targets->labels[0]],
                              unsigned(targets->labels.size()));
    for (size_t i = 1; i < targets->labels.size(); ++i)
        jump->addCase(builder_.getInt32(uint32_t(i)), labels_[targets->labels[i]]);
    if (next)
        builder_.SetInsertPoint(next);
}

void FunctionTranslator::returnFrom(const ptx::Instruction&) {
    emitReturn();
}

void FunctionTranslator::exitThread(const ptx::Instruction& instruction) {
    if (!source_.isEntry) {
        // Compilers write exit after calls that do not return, and it is never reached there.
        if (!isKernel())
            return llvm::pred_empty(builder_.GetInsertBlock()) ? emitReturn() : emitTrap();
        meet(instruction.facts->lockstep, builder_.getVoidTy());
    }
    emitReturn();
}

void FunctionTranslator::trap(const ptx::Instruction& instruction) {
    emitTrap(instruction.facts->lockstep);
}

// After a failed assertion has been printed, the thread ends.
void FunctionTranslator::endAfterAssertion() {
    if (!isKernel())
        return emitTrap();
    meet(ptx::Lockstep::kAssertion, builder_.getVoidTy());
    emitReturn();
}

// Ends the thread through its launcher, which normally does not return; if it does, the function
// returns.
//
// No tail call: the return address says where the trap is. On GPUs the text of the place does.
void FunctionTranslator::emitTrap(ptx::Lockstep how) {
    if (isKernel()) {
        llvm::cast<llvm::CallInst>(meet(how, builder_.getVoidTy()))
            ->setTailCallKind(llvm::CallInst::TCK_NoTail);
    } else {
        Value* launch =
            stateField(offsetof(devlib::RayState, launch), builder_.getPtrTy(), "launch");
        auto* type = llvm::FunctionType::get(
            builder_.getVoidTy(),
            {builder_.getPtrTy(), intType(32), intType(32), builder_.getPtrTy()}, false);
        Value* handler =
            unit_.launchFunction(builder_, launch, offsetof(devlib::LaunchState, throwException),
                                 "throwException", type);
        Value* place = llvm::ConstantPointerNull::get(builder_.getPtrTy());
        if (unit_.isGpu())
            place = builder_.CreateGlobalString(placeIn(unit_, facts_, *current_));
        builder_
            .CreateCall(type, handler,
                        {state(), builder_.getInt32(uint32_t(devlib::kExceptionTrap)),
                         builder_.getInt32(0), place})
            ->setTailCallKind(llvm::CallInst::TCK_NoTail);
    }
    emitReturn();
}

void FunctionTranslator::call(const ptx::Instruction& instruction) {
    const ptx::Operand& target = instruction.target;
    if (target.kind == ptx::OperandKind::kSymbol) {
        if (unit_.flavor().isIntrinsicName(target.name))
            return callIntrinsic(instruction, target.name);
        llvm::Function* callee = unit_.function(module_, target.name, instruction.location);
        const ptx::Function* declared = module_.findFunction(target.name);
        if (!declared)
            reject(instruction, ErrorCode::kInvalidPtx, "callee is not declared");
        const Signature signature = unit_.signature(declared->results, declared->parameters);
        if (callee->getFunctionType() != signature.type)
            reject(instruction, ErrorCode::kInvalidPtx,
                   "callee is a program or differs in parameters");
        return callFunction(instruction, callee, signature, declared->results,
                            declared->parameters);
    }
    if (target.kind != ptx::OperandKind::kRegister)
        reject(instruction, ErrorCode::kInvalidPtx, "function name or register expected");
    for (const ptx::CallTargets& targets : source_.callTargets) { // all with the same prototype
        if (targets.name != instruction.prototype || targets.functions.empty())
            continue;
        const ptx::Function* first = module_.findFunction(targets.functions[0]);
        if (!first)
            reject(instruction, ErrorCode::kInvalidPtx, "callee is not declared");
        const ptx::Prototype shape{targets.name, first->results, first->parameters, {}};
        return callFunction(instruction, resolveCallee(instruction, readInt(target, 64), shape),
                            unit_.signature(shape.results, shape.parameters), shape.results,
                            shape.parameters);
    }
    for (const ptx::Prototype& prototype : source_.prototypes) {
        if (prototype.name != instruction.prototype)
            continue;
        return callFunction(instruction, resolveCallee(instruction, readInt(target, 64), prototype),
                            unit_.signature(prototype.results, prototype.parameters),
                            prototype.results, prototype.parameters);
    }
    reject(instruction, ErrorCode::kInvalidPtx, "indirect call without a .callprototype");
}

// The code address for the target of an indirect call. In OptiX modules a tagged value stands for a
// callable (callable.h), whose data the launch makes current.
Value* FunctionTranslator::resolveCallee(const ptx::Instruction& instruction, Value* target,
                                         const ptx::Prototype& prototype) {
    if (isKernel())
        return builder_.CreateIntToPtr(target, builder_.getPtrTy());
    llvm::BasicBlock* tagged = llvm::BasicBlock::Create(unit_.context(), "callable", &function_);
    llvm::BasicBlock* plain = llvm::BasicBlock::Create(unit_.context(), "address", &function_);
    llvm::BasicBlock* join = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    builder_.CreateCondBr(builder_.CreateTrunc(target, intType(1)), tagged, plain);

    builder_.SetInsertPoint(tagged);
    llvm::Type* word = intType(32);
    Value* launch = stateField(offsetof(devlib::RayState, launch), builder_.getPtrTy(), "launch");
    auto* type =
        llvm::FunctionType::get(builder_.getPtrTy(), {builder_.getPtrTy(), word, word}, false);
    Value* resolver = unit_.launchFunction(
        builder_, launch, offsetof(devlib::LaunchState, callable), "callable", type);
    // The callable's kind and the number of words passed (LaunchState::callable).
    Value* call = builder_.CreateAnd(builder_.CreateLShr(target, 1), uint64_t(1));
    call = builder_.CreateOr(call, uint64_t(parameterWords(prototype.parameters)) << 8);
    if (unit_.debugExceptions()) {
        const std::string place = sourcePlace(unit_, facts_, instruction);
        Value* thread =
            stateField(offsetof(devlib::RayState, thread), builder_.getPtrTy(), "thread");
        Value* line = llvm::ConstantPointerNull::get(builder_.getPtrTy());
        if (!place.empty())
            line = builder_.CreateGlobalString(place);
        builder_.CreateStore(line, offsetPointer(thread, offsetof(devlib::ThreadState, line)));
    }
    Value* index = builder_.CreateLShr(target, kCallableIndexShift);
    Value* found = builder_.CreateCall(
        type, resolver,
        {state(), builder_.CreateTrunc(index, word), builder_.CreateTrunc(call, word)});
    // A record without a callable: the call returns zero.
    Value* none = unit_.helper("sunstone_no_callable", word, {}, false).getCallee();
    found = builder_.CreateSelect(builder_.CreateIsNull(found), none, found);
    builder_.CreateBr(join);

    builder_.SetInsertPoint(plain);
    Value* address = builder_.CreateIntToPtr(target, builder_.getPtrTy());
    builder_.CreateBr(join);

    builder_.SetInsertPoint(join);
    llvm::PHINode* code = builder_.CreatePHI(builder_.getPtrTy(), 2);
    code->addIncoming(found, tagged);
    code->addIncoming(address, plain);
    return code;
}

Value* FunctionTranslator::memoryOf(const ptx::Operand& operand) const {
    if (operand.kind != ptx::OperandKind::kSymbol)
        return nullptr;
    const auto found = locals_.find(operand.name);
    return found == locals_.end() ? nullptr : found->second;
}

uint64_t FunctionTranslator::sizeOfMemory(const ptx::Operand& operand) const {
    const auto found = localVariables_.find(operand.name);
    return found == localVariables_.end() ? 0 : found->second->size;
}

Value* FunctionTranslator::readArgument(const ptx::Operand& operand, llvm::Type* type) {
    Value* memory = memoryOf(operand);
    if (!memory)
        return readAs(operand, type);
    if (sizeOfMemory(operand) * 8 < type->getPrimitiveSizeInBits())
        reject(*current_, ErrorCode::kInvalidPtx, "argument variable is too small");
    return builder_.CreateAlignedLoad(type, memory, llvm::Align(1));
}

void FunctionTranslator::writeResult(const ptx::Operand& operand, Value* value) {
    Value* memory = memoryOf(operand);
    if (!memory)
        return write(operand, value);
    if (sizeOfMemory(operand) * 8 < value->getType()->getPrimitiveSizeInBits())
        reject(*current_, ErrorCode::kInvalidPtx, "result variable is too small");
    builder_.CreateAlignedStore(value, memory, llvm::Align(1));
}

Value* FunctionTranslator::memoryForResult(const ptx::Operand& operand, uint64_t bytes) {
    if (Value* memory = memoryOf(operand)) {
        if (sizeOfMemory(operand) < bytes)
            reject(*current_, ErrorCode::kInvalidPtx, "result variable is too small");
        return memory;
    }
    if (bytes > 16)
        reject(*current_, ErrorCode::kInvalidPtx, "aggregate result must be a .param");
    llvm::IRBuilder<> top(entry_, entry_->begin());
    return top.CreateAlloca(intType(unsigned(std::max<uint64_t>(1, bytes)) * 8));
}

void FunctionTranslator::callFunction(const ptx::Instruction& instruction, Value* target,
                                      const Signature& signature,
                                      const std::vector<ptx::Variable>& results,
                                      const std::vector<ptx::Variable>& parameters) {
    if (instruction.arguments.size() != parameters.size() ||
        instruction.results.size() != results.size())
        reject(instruction, ErrorCode::kInvalidPtx,
               message("call with ", instruction.arguments.size(), " arguments and ",
                       instruction.results.size(), " results; the callee has ", parameters.size(),
                       " and ", results.size()));
    std::vector<Value*> arguments = {state()};
    std::vector<std::pair<Value*, const ptx::Operand*>> registerResults;
    if (!signature.returnsValue) {
        for (size_t i = 0; i < results.size(); ++i) {
            const ptx::Operand& place = instruction.results[i];
            arguments.push_back(memoryForResult(place, results[i].size));
            if (!memoryOf(place))
                registerResults.emplace_back(arguments.back(), &place);
        }
    }
    for (size_t i = 0; i < parameters.size(); ++i) {
        llvm::Type* type = signature.type->getParamType(unsigned(arguments.size()));
        Value* memory = memoryOf(instruction.arguments[i]);
        if (memory && sizeOfMemory(instruction.arguments[i]) < parameters[i].size)
            reject(instruction, ErrorCode::kInvalidPtx, "argument variable is too small");
        if (type->isPointerTy()) {
            if (!memory)
                reject(instruction, ErrorCode::kInvalidPtx, "aggregate argument must be a .param");
            arguments.push_back(memory);
        } else {
            arguments.push_back(readArgument(instruction.arguments[i], type));
        }
    }
    llvm::CallInst* result = builder_.CreateCall(signature.type, target, arguments);
    result->addFnAttr(llvm::Attribute::NoUnwind);
    if (signature.returnsValue)
        writeResult(instruction.results[0], result);
    for (const auto& [memory, operand] : registerResults) {
        const ptx::Operand& place = *operand;
        write(place, builder_.CreateLoad(llvm::cast<llvm::AllocaInst>(memory)->getAllocatedType(),
                                         memory));
    }
    if (auto* callee = llvm::dyn_cast<llvm::Function>(target))
        if (callee->getName() == "sunstone_assertfail" ||
            callee->getName() == "sunstone_kernel_assertfail")
            return endAfterAssertion();
    if (instruction.target.kind == ptx::OperandKind::kSymbol)
        if (const ptx::Function* callee = module_.findFunction(instruction.target.name))
            if (callee->noreturn)
                emitReturn();
}

void FunctionTranslator::callIntrinsic(const ptx::Instruction& instruction, std::string_view name) {
    if (isKernel())
        failAt(ErrorCode::kNotSupported, instruction.location, "\"", name,
               "\" can only be called in OptiX programs");
    const Intrinsic* intrinsic = unit_.flavor().find(name);
    if (!intrinsic)
        failAt(ErrorCode::kInvalidPtx, instruction.location, "unknown OptiX function \"", name,
               "\"");
    if (!intrinsic->isAvailable)
        failAt(ErrorCode::kNotSupported, instruction.location, "\"", name, "\" is not available");
    if (instruction.arguments.size() != intrinsic->operands.size() ||
        instruction.results.size() != intrinsic->results.size())
        failAt(ErrorCode::kInvalidPtx, instruction.location, "\"", name, "\" is called with ",
               instruction.arguments.size(), " arguments and ", instruction.results.size(),
               " results; it has ", intrinsic->operands.size(), " and ", intrinsic->results.size());
    llvm::Function* callee = unit_.intrinsic(*intrinsic, name);
    std::vector<Value*> arguments = {state()};
    for (size_t i = 0; i < instruction.arguments.size(); ++i)
        arguments.push_back(readArgument(instruction.arguments[i],
                                         callee->getFunctionType()->getParamType(unsigned(i) + 1)));
    llvm::CallInst* result = builder_.CreateCall(callee, arguments);
    setCallSite(unit_, *result, facts_, instruction,
                intrinsic->namesLine ? sourcePlace(unit_, facts_, instruction) : std::string());
    if (instruction.results.size() == 1)
        writeResult(instruction.results[0], result);
    else
        for (size_t i = 0; i < instruction.results.size(); ++i)
            if (instruction.results[i].kind != ptx::OperandKind::kSink)
                writeResult(instruction.results[i],
                            builder_.CreateExtractValue(result, unsigned(i)));
}

} // namespace sunstone::compiler
