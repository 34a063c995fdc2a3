// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: asynchronous copies (cp.async) and barriers in shared memory (mbarrier). The
// CPU copies at once, so waiting for groups of copies does nothing, and an arrival "when my copies
// are done" is immediate. A thread block is its own cluster. Source: PTX ISA manual, "Asynchronous
// copy" and "mbarrier".
#include "compiler/translate/function_translator.h"

#include "base/config.h"

namespace sunstone::compiler {

void FunctionTranslator::copyAsync(const ptx::Instruction& instruction) {
    if (!instruction.has("async") || instruction.has("tensor"))
        rejectForm(instruction);
    if (!isKernel())
        reject(instruction, ErrorCode::kInvalidPtx,
               "asynchronous copies are not allowed in OptiX programs");
    if (instruction.has("commit_group") || instruction.has("wait_group") ||
        instruction.has("wait_all") || instruction.has("prefetch"))
        return;
    if (instruction.has("bulk"))
        return copyBulk(instruction);
    const bool arrives = instruction.has("mbarrier");
    operandCount(instruction, arrives ? 1 : 3, arrives ? 1 : 5);
    if (arrives) {
        // Without .noinc one more arrival is expected, namely this one.
        if (instruction.has("noinc"))
            arriveAt(instruction.operands[0], builder_.getInt32(1), builder_.getInt32(0), false);
        return;
    }
    const ptx::Operand& size = instruction.operands[2];
    if (size.kind != ptx::OperandKind::kInteger ||
        (size.integer != 4 && size.integer != 8 && size.integer != 16))
        reject(instruction, ErrorCode::kInvalidPtx, "4, 8 or 16 bytes are copied at a time");
    const unsigned bytes = unsigned(size.integer);
    // Operand 3: the number of bytes from the source, or whether to copy none; the rest is zero.
    Value* from = nullptr;
    if (instruction.operands.size() > 3 && !isPolicy(instruction, 3)) {
        const ptx::Operand& limit = instruction.operands[3];
        if (limit.kind == ptx::OperandKind::kRegister &&
            source_.registers[limit.index].type == ptx::Type::kPred)
            from = builder_.CreateSelect(readInt(limit, 1), builder_.getInt32(0),
                                         builder_.getInt32(bytes));
        else if (limit.kind != ptx::OperandKind::kInteger || limit.integer < bytes)
            from = readInt(limit, 32);
    }
    Value* const to = place(instruction.operands[0]).pointer;
    Value* const source = place(instruction.operands[1]).pointer;
    const auto copyWhole = [&] {
        llvm::Type* type = intType(bytes * 8);
        auto* loaded = builder_.CreateAlignedLoad(type, source, llvm::Align(1));
        mark(*loaded, instruction.operands[1], devlib::kAccessLoad, 0, bytes);
        auto* stored = builder_.CreateAlignedStore(loaded, to, llvm::Align(1));
        mark(*stored, instruction.operands[0], devlib::kAccessStore, 0, bytes);
    };
    if (!from)
        return copyWhole();
    const auto block = [&] { return llvm::BasicBlock::Create(unit_.context(), "", &function_); };
    llvm::BasicBlock *whole = block(), *part = block(), *join = block();
    builder_.CreateCondBr(builder_.CreateICmpUGE(from, builder_.getInt32(bytes)), whole, part);
    builder_.SetInsertPoint(whole);
    copyWhole();
    builder_.CreateBr(join);
    builder_.SetInsertPoint(part);
    auto* cleared = builder_.CreateAlignedStore(llvm::ConstantInt::get(intType(bytes * 8), 0), to,
                                                llvm::Align(1));
    mark(*cleared, instruction.operands[0], devlib::kAccessStore, 0, bytes);
    copyBytes(instruction, to, source, from);
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
}

// The last operand is a cache policy.
bool FunctionTranslator::isPolicy(const ptx::Instruction& instruction, size_t operand) const {
    return instruction.has("L2::cache_hint") && operand + 1 == instruction.operands.size();
}

void FunctionTranslator::copyBytes(const ptx::Instruction& instruction, Value* to, Value* from,
                                   Value* bytes) {
    llvm::BasicBlock* before = builder_.GetInsertBlock();
    const auto block = [&] { return llvm::BasicBlock::Create(unit_.context(), "", &function_); };
    llvm::BasicBlock *head = block(), *body = block(), *behind = block();
    builder_.CreateBr(head);
    builder_.SetInsertPoint(head);
    auto* at = builder_.CreatePHI(intType(32), 2);
    at->addIncoming(builder_.getInt32(0), before);
    builder_.CreateCondBr(builder_.CreateICmpULT(at, bytes), body, behind);
    builder_.SetInsertPoint(body);
    llvm::Type* byte = builder_.getInt8Ty();
    Value* offset = builder_.CreateZExt(at, intType(64));
    auto* loaded =
        builder_.CreateAlignedLoad(byte, builder_.CreateGEP(byte, from, offset), llvm::Align(1));
    mark(*loaded, instruction.operands[1], devlib::kAccessLoad, 0, 1);
    auto* stored =
        builder_.CreateAlignedStore(loaded, builder_.CreateGEP(byte, to, offset), llvm::Align(1));
    mark(*stored, instruction.operands[0], devlib::kAccessStore, 0, 1);
    at->addIncoming(builder_.CreateAdd(at, builder_.getInt32(1)), builder_.GetInsertBlock());
    builder_.CreateBr(head);
    builder_.SetInsertPoint(behind);
}

// cp.async.bulk [to], [from], bytes, [mbarrier]; without mbarrier it is part of a group.
void FunctionTranslator::copyBulk(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 6);
    Value* const bytes = readInt(instruction.operands[2], 32);
    copyBytes(instruction, place(instruction.operands[0]).pointer,
              place(instruction.operands[1]).pointer, bytes);
    if (instruction.has("mbarrier::complete_tx::bytes")) {
        operandCount(instruction, 4, 6);
        arriveAt(instruction.operands[3], builder_.getInt32(0), builder_.CreateNeg(bytes), false);
    }
}

void FunctionTranslator::barrierObject(const ptx::Instruction& instruction) {
    if (!isKernel())
        reject(instruction, ErrorCode::kInvalidPtx, "barriers are not allowed in OptiX programs");
    const auto& operands = instruction.operands;
    if (instruction.has("init") || instruction.has("inval")) {
        const bool init = instruction.has("init");
        operandCount(instruction, init ? 2 : 1, init ? 2 : 1);
        Value* const count =
            init ? readInt(operands[1], 32) : static_cast<Value*>(builder_.getInt32(0));
        auto* stored = builder_.CreateAlignedStore(
            builder_.CreateCall(
                unit_.helper("sunstone_mbarrier_init", intType(64), {intType(32)}, false), {count}),
            place(operands[0]).pointer, llvm::Align(8));
        mark(*stored, operands[0], devlib::kAccessStore, 0, 8);
        return;
    }
    if (instruction.has("test_wait") || instruction.has("try_wait"))
        return waitAt(instruction);
    if (instruction.has("pending_count")) {
        operandCount(instruction, 2, 2);
        return write(operands[0],
                     builder_.CreateCall(unit_.helper("sunstone_mbarrier_pending", intType(32),
                                                      {intType(64)}, false),
                                         {readInt(operands[1], 64)}));
    }
    if (instruction.has("expect_tx") && !instruction.has("arrive") &&
        !instruction.has("arrive_drop")) {
        operandCount(instruction, 2, 2);
        arriveAt(operands[0], builder_.getInt32(0), readInt(operands[1], 32), false);
        return;
    }
    if (instruction.has("complete_tx")) {
        operandCount(instruction, 2, 2);
        arriveAt(operands[0], builder_.getInt32(0), builder_.CreateNeg(readInt(operands[1], 32)),
                 false);
        return;
    }
    operandCount(instruction, 2, 3);
    Value* const number =
        operands.size() > 2 ? readInt(operands[2], 32) : static_cast<Value*>(builder_.getInt32(1));
    const bool expects = instruction.has("expect_tx");
    Value* const before = arriveAt(operands[1],
                                   expects ? static_cast<Value*>(builder_.getInt32(1)) : number,
                                   expects ? number : static_cast<Value*>(builder_.getInt32(0)),
                                   instruction.has("arrive_drop"));
    write(operands[0], before);
}

// Adds arrivals and bytes to wait for in one step; returns the object's previous value.
Value* FunctionTranslator::arriveAt(const ptx::Operand& object, Value* count, Value* bytes,
                                    bool drop) {
    Value* const pointer = place(object).pointer;
    checkObject(pointer, object);
    llvm::Type* word = intType(32);
    return builder_.CreateCall(unit_.helper("sunstone_mbarrier_arrive", intType(64),
                                            {builder_.getPtrTy(), word, word, word}, false),
                               {pointer, count, bytes, builder_.getInt32(drop)});
}

// The thread yields if the phase has not ended yet.
void FunctionTranslator::waitAt(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 4);
    const bool parity = instruction.has("parity");
    Value* const pointer = place(instruction.operands[1]).pointer;
    checkObject(pointer, instruction.operands[1]);
    Value* const phase =
        parity ? builder_.CreateZExt(readInt(instruction.operands[2], 32), intType(64))
               : readInt(instruction.operands[2], 64);
    Value* const ended =
        meet(instruction.facts->lockstep, intType(32), {pointer, phase, builder_.getInt32(parity)});
    write(instruction.operands[0], builder_.CreateIsNotNull(ended));
}

// The memory checker sees accesses of compiled code only, so objects passed to the run-time are
// checked here.
void FunctionTranslator::checkObject(Value* pointer, const ptx::Operand& object) {
    static const bool isOn = checks("memory");
    if (!isOn)
        return;
    auto* access = builder_.CreateAlignedLoad(intType(64), pointer, llvm::Align(8), true);
    mark(*access, object, devlib::kAccessAtomic, 0, 8);
}

} // namespace sunstone::compiler
