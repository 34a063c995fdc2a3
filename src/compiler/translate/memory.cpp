// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: addresses, loads, stores, atomics, mov. Accesses claim only the alignment of
// one element, because PTX aligns by other rules, and a vector store is not a single x86 store.
#include "compiler/translate/function_translator.h"

#include "base/config.h"
#include "compiler/passes/check_accesses.h"
#include "compiler/runtime/runtime.h"
#include "compiler/runtime/small_floats.h"
#include "compiler/translate/call_site.h"

#include <algorithm>
#include <bit>

namespace sunstone::compiler {

namespace {

unsigned vectorCount(const ptx::Instruction& instruction) {
    for (std::string_view modifier : instruction.modifiers) {
        if (modifier == "v2")
            return 2;
        if (modifier == "v4")
            return 4;
        if (modifier == "v8")
            return 8;
    }
    return 1;
}

constexpr unsigned kGlobalSpace = 1; // of NVPTX

llvm::AtomicOrdering atLeastMonotonic(llvm::AtomicOrdering ordering) {
    return ordering == llvm::AtomicOrdering::NotAtomic ? llvm::AtomicOrdering::Monotonic : ordering;
}

// The alignment of element i. On a GPU a vector is one access, aligned as a whole.
llvm::Align alignmentOf(bool gpu, unsigned bytes, unsigned count, unsigned i) {
    const llvm::Align element(bytes);
    return gpu ? llvm::commonAlignment(llvm::Align(bytes * count), uint64_t(i) * bytes) : element;
}

// Ordering of an access; NotAtomic for plain ones.
llvm::AtomicOrdering orderingOf(const ptx::Instruction& instruction) {
    if (instruction.has("acquire"))
        return llvm::AtomicOrdering::Acquire;
    if (instruction.has("release"))
        return llvm::AtomicOrdering::Release;
    if (instruction.has("relaxed") || instruction.has("mmio"))
        return llvm::AtomicOrdering::Monotonic;
    return llvm::AtomicOrdering::NotAtomic;
}

devlib::AccessSpace spaceOf(const ptx::Instruction& instruction) {
    // Each operand of an asynchronous copy has its own space.
    if (instruction.facts->operation == ptx::Operation::kCopyAsync)
        return devlib::kSpaceGeneric;
    for (const auto& [name, space] :
         {std::pair<std::string_view, devlib::AccessSpace>{"shared", devlib::kSpaceShared},
          {"shared::cta", devlib::kSpaceShared},
          {"global", devlib::kSpaceGlobal},
          {"const", devlib::kSpaceGlobal},
          {"local", devlib::kSpaceLocal},
          {"param", devlib::kSpaceParam}})
        if (instruction.has(name))
            return space;
    return devlib::kSpaceGeneric;
}

} // namespace

// name or name+offset, in bounds and aligned, so the access cannot fail.
bool FunctionTranslator::isWithinVariable(const ptx::Operand& operand, unsigned bytes) const {
    if (operand.name.empty() || (operand.scale != 0 && operand.index != ~0u) || operand.offset < 0)
        return false;
    const auto local = localVariables_.find(operand.name);
    const ptx::Variable* variable =
        local != localVariables_.end() ? local->second : unit_.findVariable(module_, operand.name);
    const uint64_t alignment = std::bit_floor(std::max(1u, bytes)),
                   offset = uint64_t(operand.offset);
    return variable && offset + bytes <= variable->size && offset % alignment == 0 &&
           variable->alignment % alignment == 0;
}

bool FunctionTranslator::marksAccesses() const {
    static const bool isOn = checks("memory");
    return isOn && !unit_.isGpu();
}

void FunctionTranslator::mark(llvm::Instruction& access, const ptx::Operand& operand, uint8_t kind,
                              unsigned offset, unsigned bytes) {
    if (!marksAccesses() || isWithinVariable(operand, bytes))
        return;
    AccessMark mark;
    mark.number = unit_.nextAccess(offset == 0);
    mark.bytes = bytes;
    mark.kind = kind;
    mark.space = spaceOf(*current_);
    if (mark.space == devlib::kSpaceGlobal && unit_.flavor().hasGlobalsOnStack())
        mark.space = devlib::kSpaceGeneric;
    mark.ptxLine = current_->location.line;
    mark.function = std::string(source_.name);
    mark.place = sourcePlace(unit_, facts_, *current_);
    markAccess(access, mark, offset);
}

Value* FunctionTranslator::offsetPointer(Value* pointer, int64_t offset) {
    if (offset == 0)
        return pointer;
    return builder_.CreateGEP(builder_.getInt8Ty(), pointer, builder_.getInt64(uint64_t(offset)));
}

Value* FunctionTranslator::stateField(size_t offset, llvm::Type* type, const char* name) {
    return builder_.CreateLoad(type, offsetPointer(state(), int64_t(offset)), name);
}

// The launch parameter block; neither pointer changes while a program runs.
Value* FunctionTranslator::launchParams() {
    const auto loadInvariant = [&](Value* pointer, size_t offset) {
        auto* loaded =
            builder_.CreateLoad(builder_.getPtrTy(), offsetPointer(pointer, int64_t(offset)));
        loaded->setMetadata(llvm::LLVMContext::MD_invariant_load,
                            llvm::MDNode::get(unit_.context(), {}));
        return loaded;
    };
    Value* launch = loadInvariant(state(), offsetof(devlib::RayState, launch));
    return loadInvariant(launch, offsetof(devlib::LaunchState, params));
}

Value* FunctionTranslator::symbolAddress(std::string_view name, ptx::Location location,
                                         bool* constant) {
    const auto sharedAddress = [&](const ptx::Variable& variable) -> Value* {
        if (!isKernel())
            failAt(ErrorCode::kInvalidPtx, location, "shared memory (\"", name,
                   "\") is not allowed in OptiX programs");
        Value* base =
            stateField(offsetof(devlib::KernelThread, shared), builder_.getPtrTy(), "shared");
        return builder_.CreateGEP(builder_.getInt8Ty(), base,
                                  unit_.sharedOffset(variable, &function_));
    };
    const auto local = localVariables_.find(name);
    if (local != localVariables_.end()) {
        if (local->second->space == ptx::Space::kShared)
            return sharedAddress(*local->second);
        const auto memory = locals_.find(name);
        if (memory == locals_.end())
            failAt(ErrorCode::kInvalidPtx, location, "\"", name, "\" is a register, not memory");
        if (constant && isKernel() && source_.isEntry &&
            local->second->space == ptx::Space::kParam &&
            !llvm::isa<llvm::AllocaInst>(memory->second))
            *constant = true;
        return memory->second;
    }
    if (const ptx::Variable* variable = unit_.findVariable(module_, name)) {
        if (variable->space == ptx::Space::kShared)
            return sharedAddress(*variable);
        if (constant)
            *constant = variable->space == ptx::Space::kConst;
        if (unit_.isLaunchParams(*variable))
            return launchParams();
        if (const std::string own = unit_.flavor().variableIntrinsic(module_, *variable);
            !own.empty())
            return builder_.CreateCall(unit_.intrinsic(*unit_.flavor().find(own), own), {state()});
        return unit_.variable(module_, name, location);
    }
    if (unit_.knowsFunction(module_, name))
        return unit_.function(module_, name, location);
    failAt(ErrorCode::kInvalidPtx, location, "\"", name, "\" is not declared");
}

// sym[%r]: the register times the element size beside the name.
Value* FunctionTranslator::indexedPointer(Value* base, const ptx::Operand& operand) {
    if (operand.scale == 0 || operand.index == ~0u)
        return base;
    ptx::Operand index;
    index.kind = ptx::OperandKind::kRegister;
    index.index = operand.index;
    const ptx::Type type = source_.registers[index.index].type;
    Value* number = coerce(readInt(index, bitsOf(type)), builder_.getInt64Ty(),
                           type != ptx::Type::kU32 && type != ptx::Type::kU16);
    return builder_.CreateGEP(builder_.getInt8Ty(), base,
                              builder_.CreateMul(number, builder_.getInt64(operand.scale)));
}

// The only .const variable of the module whose address is used as a word. With several, or one in
// the body of another function, the variable for a word would be ambiguous.
Value* FunctionTranslator::addressedConstant() {
    const ptx::Variable* found = nullptr;
    for (const ptx::Function& function : module_.functions)
        for (const ptx::Statement& statement : function.body) {
            const ptx::Instruction& each = statement.instruction;
            if (each.facts->operation != ptx::Operation::kMove || each.types.empty() ||
                ptx::sizeOf(each.types[0]) != 4 || each.operands.size() != 2 ||
                each.operands[1].kind != ptx::OperandKind::kSymbol)
                continue;
            const std::string_view name = each.operands[1].name;
            const auto own =
                std::find_if(function.variables.begin(), function.variables.end(),
                             [&](const ptx::Variable& local) { return local.name == name; });
            const bool isOwn = own != function.variables.end();
            const ptx::Variable* variable = isOwn ? &*own : unit_.findVariable(module_, name);
            if (!variable || variable->space != ptx::Space::kConst || variable == found)
                continue;
            if (found || (isOwn && &function != &source_))
                reject(*current_, ErrorCode::kNotSupported,
                       "addresses of 32 bits are not available for several variables in .const");
            found = variable;
        }
    if (!found)
        reject(*current_, ErrorCode::kNotSupported,
               "no function takes an address of 32 bits in .const");
    return symbolAddress(found->name, current_->location);
}

// Addresses in .local and .const may be 32-bit words: the low halves of host addresses. The high
// half comes from a nearby object, on the thread's stack or the variable itself. That address goes
// through memory, so that the optimiser does not take the result for a pointer into the nearby
// object.
Value* FunctionTranslator::pointerOfWord(const ptx::Operand& reg) {
    llvm::IRBuilder<> top(entry_, entry_->begin());
    Value* const kept = top.CreateAlloca(top.getPtrTy());
    builder_.CreateStore(current_->has("local") ? kept : addressedConstant(), kept, true);
    Value* whole = builder_.CreatePtrToInt(builder_.CreateLoad(builder_.getPtrTy(), kept, true),
                                           builder_.getInt64Ty());
    Value* low = builder_.CreateTrunc(whole, builder_.getInt32Ty());
    Value* distance = builder_.CreateSExt(builder_.CreateSub(readInt(reg, 32), low),
                                          builder_.getInt64Ty());
    return builder_.CreateIntToPtr(builder_.CreateAdd(whole, distance), builder_.getPtrTy());
}

// Whether the instruction's address, which is in a register, is one of a GPU's global memory. Text
// of the classic API declares payloads and attributes, too, as .global variables, and computes with
// their addresses; they are part of a ray's state, in local memory.
bool FunctionTranslator::isGlobalMemory() {
    if (!unit_.isGpu() || !current_->has("global"))
        return false;
    if (!hasOwnVariables_)
        hasOwnVariables_ = std::any_of(
            module_.variables.begin(), module_.variables.end(), [&](const ptx::Variable& each) {
                return !unit_.flavor().variableIntrinsic(module_, each).empty();
            });
    return !*hasOwnVariables_;
}

FunctionTranslator::Place FunctionTranslator::place(const ptx::Operand& operand) {
    Place place;
    if (operand.kind != ptx::OperandKind::kAddress && operand.kind != ptx::OperandKind::kSymbol &&
        operand.kind != ptx::OperandKind::kRegister)
        reject(*current_, ErrorCode::kInvalidPtx, "address expected");
    Value* base = nullptr;
    if (!operand.name.empty()) {
        base = symbolAddress(operand.name, operand.location, &place.constant);
        base = indexedPointer(base, operand);
    } else if (operand.index != ~0u) {
        ptx::Operand reg = operand;
        reg.kind = ptx::OperandKind::kRegister;
        reg.negated = false;
        const bool isWord = bitsOf(source_.registers[operand.index].type) == 32 &&
                            (current_->has("local") || current_->has("const"));
        // A generic address of global memory equals its address in the global space.
        const unsigned space = isGlobalMemory() ? kGlobalSpace : 0;
        base = isWord ? pointerOfWord(reg)
                      : builder_.CreateIntToPtr(readInt(reg, 64), builder_.getPtrTy(space));
    } else {
        base = builder_.CreateIntToPtr(builder_.getInt64(uint64_t(operand.offset)),
                                       builder_.getPtrTy());
        place.pointer = base;
        return place;
    }
    place.pointer = offsetPointer(base, operand.offset);
    return place;
}

// Call after a read by which a kernel's thread may wait for another.
void FunctionTranslator::mayWait() {
    if (isKernel())
        meet(current_->facts->lockstep, builder_.getVoidTy());
}

// Adding zero is a form of read. With a constant operand, only one branch remains.
void FunctionTranslator::mayWaitIfZero(Value* operand) {
    llvm::BasicBlock* zero = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    llvm::BasicBlock* join = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    builder_.CreateCondBr(builder_.CreateIsNull(operand), zero, join);
    builder_.SetInsertPoint(zero);
    mayWait();
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
}

// Whether a vector access is one access of its whole. Threads publish a value beside its state in
// one strong or volatile vector, as CUB's look-back does; devices write up to 16 bytes at once.
bool FunctionTranslator::isWholeVector(const ptx::Instruction& instruction, unsigned bytes) const {
    const bool isStrong =
        orderingOf(instruction) != llvm::AtomicOrdering::NotAtomic || instruction.has("volatile");
    return !unit_.isGpu() && isStrong && vectorCount(instruction) > 1 && bytes <= 16;
}

// The elements of a vector that was loaded as one integer; the first is in the lowest bits.
std::vector<Value*> FunctionTranslator::splitWhole(Value* whole, llvm::Type* type, unsigned count) {
    const unsigned bits = type->getPrimitiveSizeInBits();
    std::vector<Value*> elements;
    for (unsigned i = 0; i < count; ++i)
        elements.push_back(builder_.CreateBitCast(
            builder_.CreateTrunc(builder_.CreateLShr(whole, uint64_t(i) * bits), intType(bits)),
            type));
    return elements;
}

Value* FunctionTranslator::joinWhole(const std::vector<Value*>& elements) {
    const unsigned bits = elements[0]->getType()->getPrimitiveSizeInBits();
    llvm::Type* type = intType(bits * unsigned(elements.size()));
    Value* whole = nullptr;
    for (unsigned i = 0; i < elements.size(); ++i) {
        Value* element =
            builder_.CreateZExt(builder_.CreateBitCast(elements[i], intType(bits)), type);
        element = builder_.CreateShl(element, uint64_t(i) * bits);
        whole = whole ? builder_.CreateOr(whole, element) : element;
    }
    return whole;
}

void FunctionTranslator::load(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 4);
    const ptx::Type type = lastType(instruction);
    const unsigned bytes = ptx::sizeOf(type);
    const Place from = place(instruction.operands[1]);
    const llvm::AtomicOrdering ordering = orderingOf(instruction);
    const bool constant = from.constant || instruction.has("nc") || instruction.opcode == "ldu";
    const bool isFloat = type == ptx::Type::kF32 || type == ptx::Type::kF64;
    llvm::Type* loadType = isFloat ? typeOf(type) : intType(bytes * 8);

    const unsigned count = vectorCount(instruction);
    std::vector<ptx::Operand> targets = {instruction.operands[0]};
    if (count > 1)
        targets = elements(instruction.operands[0]);
    if (targets.size() != count)
        reject(instruction, ErrorCode::kInvalidPtx,
               message("loads ", count, " values into ", targets.size(), " registers"));
    const bool isVolatile = instruction.has("volatile");
    const bool isWhole = isWholeVector(instruction, count * bytes);
    const unsigned parts = isWhole ? 1 : count;
    std::vector<Value*> values;
    for (unsigned i = 0; i < parts; ++i) {
        auto* loaded = builder_.CreateAlignedLoad(
            isWhole ? intType(count * bytes * 8) : loadType,
            offsetPointer(from.pointer, int64_t(i) * bytes),
            isWhole ? llvm::Align(count * bytes) : alignmentOf(unit_.isGpu(), bytes, count, i),
            isVolatile);
        if (ordering != llvm::AtomicOrdering::NotAtomic || isWhole)
            loaded->setAtomic(atLeastMonotonic(ordering));
        else if (constant)
            loaded->setMetadata(llvm::LLVMContext::MD_invariant_load,
                                llvm::MDNode::get(unit_.context(), {}));
        mark(*loaded, instruction.operands[1], devlib::kAccessLoad, i * bytes, count * bytes);
        values.push_back(loaded);
    }
    if (isWhole)
        values = splitWhole(values[0], loadType, count);
    if (ordering != llvm::AtomicOrdering::NotAtomic || isVolatile)
        mayWait();
    for (unsigned i = 0; i < count; ++i)
        write(targets[i], values[i], ptx::isSigned(type));
}

void FunctionTranslator::store(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 3);
    const ptx::Type type = lastType(instruction);
    const unsigned bytes = ptx::sizeOf(type);
    const Place to = place(instruction.operands[0]);
    const llvm::AtomicOrdering ordering = orderingOf(instruction);
    const bool isFloat = type == ptx::Type::kF32 || type == ptx::Type::kF64;
    llvm::Type* storeType = isFloat ? typeOf(type) : intType(bytes * 8);

    const unsigned count = vectorCount(instruction);
    std::vector<ptx::Operand> sources = {instruction.operands[1]};
    if (count > 1)
        sources = elements(instruction.operands[1]);
    if (sources.size() != count)
        reject(instruction, ErrorCode::kInvalidPtx,
               message("stores ", count, " values from ", sources.size(), " registers"));
    std::vector<Value*> values;
    for (const ptx::Operand& source : sources)
        values.push_back(readAs(source, storeType));
    const bool isWhole = isWholeVector(instruction, count * bytes);
    if (isWhole)
        values = {joinWhole(values)};
    for (unsigned i = 0; i < values.size(); ++i) {
        auto* stored = builder_.CreateAlignedStore(
            values[i], offsetPointer(to.pointer, int64_t(i) * bytes),
            isWhole ? llvm::Align(count * bytes) : alignmentOf(unit_.isGpu(), bytes, count, i),
            instruction.has("volatile"));
        if (ordering != llvm::AtomicOrdering::NotAtomic || isWhole)
            stored->setAtomic(atLeastMonotonic(ordering));
        mark(*stored, instruction.operands[0], devlib::kAccessStore, i * bytes, count * bytes);
    }
}

void FunctionTranslator::atomic(const ptx::Instruction& instruction) {
    using Op = llvm::AtomicRMWInst::BinOp;
    const bool returns = instruction.opcode == "atom";
    operandCount(instruction, returns ? 3 : 2, 5);
    const ptx::Type type = lastType(instruction);
    const size_t at = returns ? 1 : 0;
    if (isHalfType(type) || (type == ptx::Type::kF32 && vectorCount(instruction) > 1))
        return atomicNumbers(instruction);
    if (type == ptx::Type::kF32 && instruction.has("add") && !instruction.has("shared") &&
        !instruction.has("shared::cta") && !instruction.has("shared::cluster"))
        return atomicNumbers(instruction);
    if (vectorCount(instruction) > 1)
        reject(instruction, ErrorCode::kNotSupported, "atomics on this type are not available");
    const unsigned bytes = ptx::sizeOf(type);
    const bool isFloat = ptx::isFloat(type);
    const bool isSigned = ptx::isSigned(type);

    llvm::AtomicOrdering ordering = llvm::AtomicOrdering::Monotonic;
    if (instruction.has("acquire"))
        ordering = llvm::AtomicOrdering::Acquire;
    else if (instruction.has("release"))
        ordering = llvm::AtomicOrdering::Release;
    else if (instruction.has("acq_rel"))
        ordering = llvm::AtomicOrdering::AcquireRelease;

    const Place where = place(instruction.operands[at]);
    Value* old = nullptr;
    if (instruction.has("cas")) {
        operandCount(instruction, at + 3, at + 4);
        Value* expected = readInt(instruction.operands[at + 1], bytes * 8);
        Value* desired = readInt(instruction.operands[at + 2], bytes * 8);
        auto* pair = builder_.CreateAtomicCmpXchg(
            where.pointer, expected, desired, llvm::MaybeAlign(bytes), ordering,
            llvm::AtomicCmpXchgInst::getStrongestFailureOrdering(ordering));
        mark(*pair, instruction.operands[at], devlib::kAccessAtomic, 0, bytes);
        old = builder_.CreateExtractValue(pair, 0);
    } else {
        Op op = Op::BAD_BINOP;
        if (instruction.has("add"))
            op = isFloat ? Op::FAdd : Op::Add;
        else if (instruction.has("and"))
            op = Op::And;
        else if (instruction.has("or"))
            op = Op::Or;
        else if (instruction.has("xor"))
            op = Op::Xor;
        else if (instruction.has("exch"))
            op = Op::Xchg;
        else if (instruction.has("inc"))
            op = Op::UIncWrap;
        else if (instruction.has("dec"))
            op = Op::UDecWrap;
        else if (instruction.has("min"))
            op = isSigned ? Op::Min : Op::UMin;
        else if (instruction.has("max"))
            op = isSigned ? Op::Max : Op::UMax;
        if (op == Op::BAD_BINOP || (isFloat && op != Op::FAdd && op != Op::Xchg))
            rejectForm(instruction);
        llvm::Type* valueType = op == Op::FAdd ? typeOf(type) : intType(bytes * 8);
        Value* operand = readAs(instruction.operands[at + 1], valueType);
        auto* changed =
            builder_.CreateAtomicRMW(op, where.pointer, operand, llvm::MaybeAlign(bytes), ordering);
        mark(*changed, instruction.operands[at], devlib::kAccessAtomic, 0, bytes);
        old = changed;
    }
    if (!returns)
        return;
    write(instruction.operands[0], old, isSigned);
    if (instruction.has("cas") || instruction.has("exch"))
        mayWait(); // locks use it
    else if (isKernel() && !isFloat && (instruction.has("add") || instruction.has("or")))
        mayWaitIfZero(readInt(instruction.operands[at + 1], bytes * 8));
}

// Atomics in the run-time: 16-bit numbers, and float sums if GPUs flush them: in global memory, and
// through generic addresses, which are nearly always global. Vectors go element by element, as the
// manual allows.
void FunctionTranslator::atomicNumbers(const ptx::Instruction& instruction) {
    const bool returns = instruction.opcode == "atom";
    const ptx::Type type = lastType(instruction);
    const Place where = place(instruction.operands[returns ? 1 : 0]);
    const std::vector<ptx::Operand> sources = elements(instruction.operands[returns ? 2 : 1]);
    std::vector<ptx::Operand> targets;
    if (returns)
        targets = elements(instruction.operands[0]);
    if (sources.size() != vectorCount(instruction) || (returns && targets.size() != sources.size()))
        rejectForm(instruction);
    std::vector<Value*> old;
    const unsigned bytes = ptx::sizeOf(type), count = unsigned(sources.size());
    for (unsigned i = 0; i < count; ++i) {
        llvm::CallInst* call =
            atomicNumber(instruction, offsetPointer(where.pointer, int64_t(i) * bytes), sources[i]);
        mark(*call, instruction.operands[returns ? 1 : 0], devlib::kAccessAtomic, i * bytes,
             count * bytes);
        old.push_back(call);
    }
    for (size_t i = 0; i < old.size() && isHalfType(type); ++i)
        old[i] = builder_.CreateTrunc(old[i], intType(bytes * 8));
    for (size_t i = 0; i < targets.size(); ++i)
        write(targets[i], old[i]);
}

llvm::CallInst* FunctionTranslator::atomicNumber(const ptx::Instruction& instruction,
                                                 Value* pointer, const ptx::Operand& source) {
    const ptx::Type type = lastType(instruction);
    llvm::Type* word = intType(32);
    if (type == ptx::Type::kF32) {
        if (!instruction.has("add"))
            rejectForm(instruction);
        llvm::Type* single = builder_.getFloatTy();
        return builder_.CreateCall(unit_.helper("sunstone_atomic_add_flushed", single,
                                                {builder_.getPtrTy(), single}, false),
                                   {pointer, read(source, type)});
    }
    AtomicOperation operation{};
    if (instruction.has("add"))
        operation = AtomicOperation::kAdd;
    else if (instruction.has("min"))
        operation = AtomicOperation::kMinimum;
    else if (instruction.has("max"))
        operation = AtomicOperation::kMaximum;
    else
        rejectForm(instruction);
    const SmallFormat format = isBrainType(type) ? SmallFormat::kBrain : SmallFormat::kHalf;
    const unsigned bits = bitsOf(type);
    return builder_.CreateCall(
        unit_.helper(isHalfPair(type) ? "sunstone_atomic_pair" : "sunstone_atomic_half", word,
                     {builder_.getPtrTy(), word, word, word}, false),
        {pointer, coerce(readInt(source, bits), word), builder_.getInt32(uint32_t(format)),
         builder_.getInt32(uint32_t(operation))});
}

void FunctionTranslator::fence(const ptx::Instruction& instruction) {
    if (instruction.has("proxy"))
        return;
    builder_.CreateFence(llvm::AtomicOrdering::SequentiallyConsistent);
}

void FunctionTranslator::move(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Operand& to = instruction.operands[0];
    const ptx::Operand& from = instruction.operands[1];
    const ptx::Type type = lastType(instruction);
    const std::vector<ptx::Operand> targets = elements(to), sources = elements(from);
    if (targets.size() > 1 && targets.size() == sources.size()) {
        std::vector<Value*> values;
        for (const ptx::Operand& source : sources)
            values.push_back(read(source, type));
        for (size_t i = 0; i < targets.size(); ++i)
            write(targets[i], values[i]);
        return;
    }
    // A copy keeps the storage type of its source, which avoids casts.
    if (from.kind == ptx::OperandKind::kRegister && to.kind == ptx::OperandKind::kRegister &&
        !from.negated && slots_[slotOf(from)].type) {
        Value* value = readSlot(slotOf(from));
        if (value->getType()->getPrimitiveSizeInBits() == bitsOf(type)) {
            write(to, value);
            return;
        }
    }
    write(to, read(from, type));
}

void FunctionTranslator::convertAddress(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    write(instruction.operands[0], readInt(instruction.operands[1], bitsOf(lastType(instruction))));
}

} // namespace sunstone::compiler
