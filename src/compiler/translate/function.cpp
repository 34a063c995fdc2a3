// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: set-up, the walk over the body, guards.
#include "compiler/translate/function_translator.h"

#include "compiler/translate/visit_registers.h"

namespace sunstone::compiler {

namespace {

llvm::StringRef toRef(std::string_view text) {
    return {text.data(), text.size()};
}

} // namespace

FunctionTranslator::FunctionTranslator(Unit& unit, llvm::Function& function, FunctionFacts& facts)
    : unit_(unit), function_(function), facts_(facts), module_(*facts.module),
      source_(*facts.function), builder_(unit.context()) {}

void FunctionTranslator::reject(const ptx::Instruction& instruction, ErrorCode code,
                                const std::string& why) const {
    failAt(code, instruction.location, instruction.fullOpcode(), ": ", why, " (in function \"",
           source_.name, "\")");
}

void FunctionTranslator::rejectForm(const ptx::Instruction& instruction) const {
    reject(instruction, ErrorCode::kInvalidPtx, "this form of the instruction is not known");
}

void FunctionTranslator::operandCount(const ptx::Instruction& instruction, size_t least,
                                      size_t most) const {
    if (instruction.operands.size() < least || instruction.operands.size() > most)
        reject(instruction, ErrorCode::kInvalidPtx,
               message("has ", instruction.operands.size(), " operands, needs ", least));
}

void FunctionTranslator::translate() {
    entry_ = llvm::BasicBlock::Create(unit_.context(), "entry", &function_);
    builder_.SetInsertPoint(entry_);
    for (std::string_view label : source_.labels)
        labels_.push_back(llvm::BasicBlock::Create(unit_.context(), toRef(label), &function_));

    beginDebug();
    classifyRegisters();
    createRegisters();
    declareParameters();
    declareVariables();
    if (debug_)
        for (const auto& [name, memory] : locals_)
            if (llvm::isa<llvm::AllocaInst>(memory))
                debug_->atMemory(name, memory, entry_);
    // Allocas stay together at the top; code starts in a block of its own.
    llvm::BasicBlock* start = llvm::BasicBlock::Create(unit_.context(), "start", &function_);
    builder_.CreateBr(start);
    builder_.SetInsertPoint(start);

    for (const ptx::Statement& statement : source_.body) {
        if (statement.kind == ptx::StatementKind::kInstruction) {
            translateInstruction(statement.instruction);
            continue;
        }
        startRegion(labels_[statement.label]);
        if (debug_)
            for (const uint32_t reg : debug_->atLabel(source_.labels[statement.label]))
                debug_->atValue(builder_, reg, readSlot(firstSlot_[reg]));
    }
    if (!terminated())
        emitReturn();
    for (llvm::BasicBlock* label : labels_) // labels that no statement carries
        if (label->empty())
            new llvm::UnreachableInst(unit_.context(), label);
}

void FunctionTranslator::beginDebug() {
    if (!unit_.hasLineInfo(module_))
        return;
    debug_ = std::make_unique<FunctionDebug>(unit_.debugInfo(), module_, source_, function_);
    if (!function_.getSubprogram()) {
        debug_ = nullptr;
        return;
    }
    debug_->setLocation(builder_, {}, 0);
    for (uint32_t i = 0; debug_->hasVariables() && i < source_.registers.size(); ++i)
        registerOfSlot_.resize(registerOfSlot_.size() + std::max(1u, source_.registers[i].vector),
                               i);
}

void FunctionTranslator::startRegion(llvm::BasicBlock* block) {
    if (!terminated())
        builder_.CreateBr(block);
    builder_.SetInsertPoint(block);
    ++region_;
}

// Decides for each register component whether it needs memory, and whether its bits are mostly used
// as floating point numbers.
void FunctionTranslator::classifyRegisters() {
    uint32_t count = 0;
    for (const ptx::Register& reg : source_.registers) {
        firstSlot_.push_back(count);
        count += std::max(1u, reg.vector);
    }
    carrySlot_ = count;
    slots_.resize(count + 1);

    constexpr uint32_t kNowhere = ~0u, kSeveral = ~0u - 1;
    std::vector<uint32_t> regionOf(count + 1, kNowhere);
    std::vector<int> floatVotes(count + 1, 0);
    const auto use = [&](uint32_t slot, uint32_t region) {
        uint32_t& where = regionOf[slot];
        where = where == kNowhere || where == region ? region : kSeveral;
    };
    for (uint32_t index : source_.parameterRegisters)
        if (index < firstSlot_.size())
            use(firstSlot_[index], 0);
    for (uint32_t index : source_.resultRegisters)
        if (index < firstSlot_.size())
            regionOf[firstSlot_[index]] = kSeveral;

    uint32_t region = 0;
    for (const ptx::Statement& statement : source_.body) {
        if (statement.kind == ptx::StatementKind::kLabel) {
            ++region;
            continue;
        }
        const ptx::Instruction& instruction = statement.instruction;
        visitRegisters(instruction, [&](const ptx::Operand& operand, size_t position,
                                        bool isAddress) {
            const ptx::Register& reg = source_.registers[operand.index];
            // Components above 3 are bytes and halves that video instructions pick.
            const int element = operand.component < 4 ? operand.component : -1;
            const uint32_t width = element >= 0 ? 1 : std::max(1u, reg.vector);
            const uint32_t first = firstSlot_[operand.index] + uint32_t(std::max(0, element));
            int vote = 0;
            if (!isAddress && !instruction.types.empty()) {
                const bool isResult = position == 0;
                const ptx::Type type =
                    isResult ? instruction.types.front() : instruction.types.back();
                vote = ptx::isFloat(type) && ptx::sizeOf(type) == ptx::sizeOf(reg.type) ? 1 : -1;
                if (instruction.facts->isCopy())
                    vote = vote > 0 ? 1 : 0; // copies count only if they are of floats
            }
            for (uint32_t slot = first; slot < first + width && slot < count; ++slot) {
                use(slot, region);
                floatVotes[slot] += vote;
            }
        });
    }
    for (size_t i = 0; i < source_.registers.size(); ++i) {
        const ptx::Register& reg = source_.registers[i];
        for (uint32_t k = 0; k < std::max(1u, reg.vector); ++k) {
            const uint32_t slot = firstSlot_[i] + k;
            const unsigned bits = bitsOf(reg.type);
            const bool declaredFloat = reg.type == ptx::Type::kF32 || reg.type == ptx::Type::kF64;
            const bool asFloat =
                (declaredFloat || floatVotes[slot] > 0) && (bits == 32 || bits == 64);
            if (regionOf[slot] == kNowhere)
                continue; // never used: declared ranges are often larger
            slots_[slot].type = asFloat
                                    ? (bits == 32 ? builder_.getFloatTy() : builder_.getDoubleTy())
                                    : static_cast<llvm::Type*>(intType(bits));
            slots_[slot].region = regionOf[slot] == kSeveral ? 1 : 0;
        }
    }
    slots_[carrySlot_].type = builder_.getInt1Ty();
    slots_[carrySlot_].region = 1;
}

void FunctionTranslator::createRegisters() {
    for (Slot& slot : slots_) {
        if (!slot.type)
            continue;
        if (slot.region == 1) {
            slot.memory = builder_.CreateAlloca(slot.type);
            builder_.CreateStore(llvm::Constant::getNullValue(slot.type), slot.memory);
        }
        slot.region = ~0u;
    }
}

void FunctionTranslator::declareParameters() {
    if (source_.isEntry && !isKernel()) {
        const auto known = unit_.kinds().find(&function_);
        for (size_t i = 0; i < source_.parameters.size(); ++i) {
            const auto offset = known == unit_.kinds().end()
                                    ? std::nullopt
                                    : unit_.flavor().parameterAt(known->second, i,
                                                                  source_.parameters.size());
            if (!offset)
                failAt(ErrorCode::kInvalidPtx, source_.location, "program \"", source_.name,
                       "\" has ", source_.parameters.size(),
                       " parameters; programs of its kind take ", i);
            const ptx::Variable& parameter = source_.parameters[i];
            locals_[parameter.name] = offsetPointer(state(), int64_t(*offset));
            localVariables_[parameter.name] = &parameter;
        }
        return;
    }
    if (source_.isEntry) {
        uint64_t offset = 0;
        for (const ptx::Variable& parameter : source_.parameters) {
            const uint64_t alignment = std::max(1u, parameter.alignment);
            offset = (offset + alignment - 1) / alignment * alignment;
            Value* memory = offsetPointer(function_.getArg(1), int64_t(offset));
            if (debug_ && debug_->hasVariables()) { // debuggers look for variables in the frame
                auto* copy = builder_.CreateAlloca(
                    llvm::ArrayType::get(builder_.getInt8Ty(),
                                         std::max<uint64_t>(1, parameter.size)),
                    nullptr, toRef(parameter.name));
                copy->setAlignment(llvm::Align(alignment));
                builder_.CreateMemCpy(copy, llvm::Align(alignment), memory, llvm::Align(1),
                                      parameter.size);
                memory = copy;
            }
            locals_[parameter.name] = memory;
            localVariables_[parameter.name] = &parameter;
            offset += parameter.size;
        }
        return;
    }
    const auto makeMemory = [&](const ptx::Variable& variable) {
        auto* memory = builder_.CreateAlloca(
            llvm::ArrayType::get(builder_.getInt8Ty(), std::max<uint64_t>(1, variable.size)),
            nullptr, toRef(variable.name));
        memory->setAlignment(llvm::Align(std::max(1u, variable.alignment)));
        locals_[variable.name] = memory;
        return memory;
    };
    const Signature signature = unit_.signature(source_.results, source_.parameters);
    unsigned argument = 1;
    for (size_t i = 0; i < source_.results.size(); ++i) {
        const ptx::Variable& result = source_.results[i];
        localVariables_[result.name] = &result;
        if (!signature.returnsValue)
            locals_[result.name] = function_.getArg(argument++);
        else if (source_.resultRegisters[i] == ~0u)
            builder_.CreateStore(llvm::Constant::getNullValue(intType(unsigned(result.size) * 8)),
                                 makeMemory(result));
    }
    for (size_t i = 0; i < source_.parameters.size(); ++i) {
        const ptx::Variable& parameter = source_.parameters[i];
        localVariables_[parameter.name] = &parameter;
        llvm::Argument* value = function_.getArg(argument++);
        if (source_.parameterRegisters[i] != ~0u)
            writeSlot(firstSlot_[source_.parameterRegisters[i]], value, false);
        else if (value->getType()->isPointerTy())
            locals_[parameter.name] = value; // the caller's copy is ours
        else
            builder_.CreateAlignedStore(value, makeMemory(parameter), llvm::Align(1));
    }
}

void FunctionTranslator::declareVariables() {
    for (const ptx::Variable& variable : source_.variables) {
        localVariables_[variable.name] = &variable;
        switch (variable.space) {
        case ptx::Space::kLocal:
            facts_.localBytes += variable.size;
            [[fallthrough]];
        case ptx::Space::kParam: {
            auto* memory = builder_.CreateAlloca(
                llvm::ArrayType::get(builder_.getInt8Ty(), std::max<uint64_t>(1, variable.size)),
                nullptr, toRef(variable.name));
            memory->setAlignment(llvm::Align(std::max(1u, variable.alignment)));
            locals_[variable.name] = memory;
            break;
        }
        case ptx::Space::kGlobal:
        case ptx::Space::kConst:
            locals_[variable.name] = unit_.addVariable(module_, variable);
            break;
        case ptx::Space::kShared: // symbolAddress finds these in localVariables_
            break;
        default:
            failAt(ErrorCode::kInvalidPtx, variable.location, "variable \"", variable.name,
                   "\" has no state space that a function can hold");
        }
    }
}

void FunctionTranslator::emitReturn() {
    if (source_.isEntry) {
        if (isKernel())
            builder_.CreateRetVoid();
        else
            builder_.CreateRet(builder_.getInt32(devlib::kAccept));
        return;
    }
    const Signature signature = unit_.signature(source_.results, source_.parameters);
    for (size_t i = 0; i < source_.results.size(); ++i) {
        const uint32_t reg = source_.resultRegisters[i];
        const ptx::Variable& result = source_.results[i];
        if (signature.returnsValue) {
            llvm::Type* type = signature.type->getReturnType();
            Value* value =
                reg != ~0u ? coerce(readSlot(firstSlot_[reg]), type)
                           : builder_.CreateAlignedLoad(type, locals_[result.name], llvm::Align(1));
            builder_.CreateRet(value);
            return;
        }
        if (reg != ~0u)
            builder_.CreateAlignedStore(readSlot(firstSlot_[reg]), locals_[result.name],
                                        llvm::Align(1));
    }
    builder_.CreateRetVoid();
}

void FunctionTranslator::translateInstruction(const ptx::Instruction& instruction) {
    current_ = &instruction;
    if (debug_)
        debug_->setLocation(builder_, instruction.source, instruction.location.line);
    if (terminated()) // unreachable code after a jump
        builder_.SetInsertPoint(llvm::BasicBlock::Create(unit_.context(), "", &function_));
    if (instruction.guard >= 0 && !instruction.facts->isJump())
        translateGuarded(instruction);
    else
        dispatch(instruction);
}

void FunctionTranslator::translateGuarded(const ptx::Instruction& instruction) {
    // Operands and the old values of results are read before the branch, so that the known values
    // hold on both sides of it.
    visitRegisters(instruction, [&](const ptx::Operand& operand, size_t, bool) {
        const ptx::Register& reg = source_.registers[operand.index];
        for (uint32_t k = 0; k < std::max(1u, reg.vector); ++k)
            readSlot(firstSlot_[operand.index] + k);
    });
    readSlot(carrySlot_);
    Value* guard = coerce(readSlot(firstSlot_[size_t(instruction.guard)]), builder_.getInt1Ty());
    if (instruction.guardNegated)
        guard = builder_.CreateNot(guard);

    llvm::BasicBlock* then = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    llvm::BasicBlock* join = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    llvm::BasicBlock* before = builder_.GetInsertBlock();
    builder_.CreateCondBr(guard, then, join);
    builder_.SetInsertPoint(then);
    std::vector<std::pair<uint32_t, Value*>> log;
    guardLog_ = &log;
    dispatch(instruction);
    guardLog_ = nullptr;
    llvm::BasicBlock* after = builder_.GetInsertBlock();
    const bool falls = !after->getTerminator();
    if (falls)
        builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
    for (const auto& [slot, old] : log) {
        Value* fresh = slots_[slot].current;
        if (!falls) {
            slots_[slot].current = old;
            continue;
        }
        if (fresh == old)
            continue;
        llvm::PHINode* merged = builder_.CreatePHI(slots_[slot].type, 2);
        merged->addIncoming(old, before);
        merged->addIncoming(fresh, after);
        slots_[slot].current = merged;
    }
}

} // namespace sunstone::compiler
