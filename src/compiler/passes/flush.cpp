// SPDX-License-Identifier: Apache-2.0
// See flush.h. There are two ways to flush:
//
// 1. A comparison and a selection at each place (expand), omitted if the value is known to be
// normal or zero. This costs about four instructions.
//
// 2. The processor's own mode, bit 15 of MXCSR: subnormal results become zeros of their sign, at no
// cost. It applies to all instructions while it is set, so a function uses it as a whole, if nearly
// all its arithmetic is .ftz. Inputs are not affected (bit 6 stays clear): values from memory are
// flushed by a product with 1; comparisons, conversions and sign operations mean the same in both
// modes. The mode changes:
//      - single precision arithmetic whose result is only ever flushed, as intended;
//      - any other arithmetic that could round to a subnormal: it moves into a function of its own
//        that runs in the default mode.
// Half precision is never flushed. The processor decides after rounding to 24 bits which results
// are subnormal, whereas way 1 rounds to the subnormal grid first. Results within 2^-150 below
// 2^-126 may therefore become zero with way 2 and 2^-126 with way 1. PTX does not specify either.
//
// No pass may move arithmetic into or out of the mode. LLVM does not know that arithmetic depends
// on MXCSR and may move it past any instruction that sets it, but never into another function that
// is not inlined. So only functions without arithmetic, which are never inlined, change the mode:
//      f            saves MXCSR, sets the bit, calls f.flushed, restores MXCSR
//      f.flushed    the body of f (a copy if f itself is also needed); may inline other flushed
//                   bodies, because the attribute denormal-fp-math-f32 agrees (constants then fold
//                   according to the mode)
//      leave.N      one for each function type: clears the bit, calls its argument, restores MXCSR
// Other code is called, and returns, in the default mode: addresses of functions and programs are
// those of f, and every callee of f.flushed that is not a flushed body (the launch's functions,
// callables, library functions, functions in the default mode) is called through leave.N. An
// exception that jumps out of the launch's function jumps in the default mode.
#include "compiler/passes/flush.h"

#include "compiler/passes/approximations.h"

#include <llvm/ADT/MapVector.h>
#include <llvm/IR/InlineAsm.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/IntrinsicInst.h>
#include <llvm/IR/IntrinsicsX86.h>
#include <llvm/Transforms/Utils/Cloning.h>

#include <algorithm>

namespace sunstone::compiler {

namespace {

using llvm::Value;

// Whether a float is known not to be subnormal.
class FlushedFinder {
public:
    // native: instructions whose results the processor flushes.
    explicit FlushedFinder(const std::set<const llvm::Instruction*>& native) : native_(native) {}

    bool isFlushed(Value* value, unsigned depth = 0) {
        if (depth == 0)
            budget_ = kBudget;
        if (auto* constant = llvm::dyn_cast<llvm::ConstantFP>(value))
            return !constant->getValueAPF().isDenormal();
        const auto known = known_.find(value);
        if (known != known_.end())
            return known->second;
        if (depth > kMaxDepth || --budget_ < 0)
            return false;
        if (auto* instruction = llvm::dyn_cast<llvm::Instruction>(value))
            if (native_.count(instruction) || isReciprocalRoot(*instruction))
                return true;
        if (llvm::isa<llvm::SIToFPInst, llvm::UIToFPInst>(value))
            return true;
        if (auto* extension = llvm::dyn_cast<llvm::FPExtInst>(value))
            return extension->getSrcTy()->isHalfTy();
        if (auto* negation = llvm::dyn_cast<llvm::UnaryOperator>(value))
            return isFlushed(negation->getOperand(0), depth + 1);
        if (auto* select = llvm::dyn_cast<llvm::SelectInst>(value))
            return isFlushed(select->getTrueValue(), depth + 1) &&
                   isFlushed(select->getFalseValue(), depth + 1);
        if (auto* phi = llvm::dyn_cast<llvm::PHINode>(value)) {
            known_[value] = true;
            bool all = true;
            for (Value* incoming : phi->incoming_values())
                all = all && isFlushed(incoming, depth + 1);
            if (!all)
                known_.clear();
            return known_[value] = all;
        }
        auto* call = llvm::dyn_cast<llvm::CallInst>(value);
        if (!call || !call->getCalledFunction())
            return false;
        if (call->getCalledFunction()->getName() == kFlushName)
            return true;
        switch (call->getIntrinsicID()) {
        case llvm::Intrinsic::fabs:
        case llvm::Intrinsic::copysign:
            return isFlushed(call->getArgOperand(0), depth + 1);
        case llvm::Intrinsic::floor:
        case llvm::Intrinsic::ceil:
        case llvm::Intrinsic::trunc:
        case llvm::Intrinsic::roundeven:
        case llvm::Intrinsic::sqrt:
            return true;
        default:
            return false;
        }
    }

private:
    // 1 / sqrt(x) is in [2^-64, 2^75] or 0, infinite, NaN.
    static bool isReciprocalRoot(const llvm::Instruction& instruction) {
        if (instruction.getOpcode() != llvm::Instruction::FDiv)
            return false;
        const auto* one = llvm::dyn_cast<llvm::ConstantFP>(instruction.getOperand(0));
        const auto* root = llvm::dyn_cast<llvm::IntrinsicInst>(instruction.getOperand(1));
        return one && one->isExactlyValue(1.0) && root &&
               root->getIntrinsicID() == llvm::Intrinsic::sqrt;
    }

    const std::set<const llvm::Instruction*>& native_;
    static constexpr unsigned kMaxDepth = 32;
    static constexpr int kBudget = 300; // values visited per query
    int budget_ = 0;
    std::map<Value*, bool> known_;
};

bool isFlushCall(const Value* value) {
    const auto* call = llvm::dyn_cast<llvm::CallInst>(value);
    return call && call->getCalledFunction() && call->getCalledFunction()->getName() == kFlushName;
}

// Arithmetic whose result can be subnormal although its operands are not.
bool isArithmetic(const llvm::Instruction& instruction) {
    if (instruction.getType()->getScalarType()->isHalfTy())
        return false;
    switch (instruction.getOpcode()) {
    case llvm::Instruction::FAdd:
    case llvm::Instruction::FSub:
    case llvm::Instruction::FMul:
    case llvm::Instruction::FDiv:
    case llvm::Instruction::FRem:
    case llvm::Instruction::FPTrunc:
        return true;
    default:
        break;
    }
    const auto* call = llvm::dyn_cast<llvm::IntrinsicInst>(&instruction);
    return call && call->getIntrinsicID() == llvm::Intrinsic::fma;
}

// 1 as a value that the optimiser cannot see.
Value* hiddenOne(llvm::Function& function) {
    llvm::IRBuilder<> builder(&*function.getEntryBlock().getFirstInsertionPt());
    llvm::Type* single = builder.getFloatTy();
    auto* nothing =
        llvm::InlineAsm::get(llvm::FunctionType::get(single, {single}, false), "", "=x,0", false);
    return builder.CreateCall(nothing, {llvm::ConstantFP::get(single, 1.0)});
}

// Removes flushes without effect and expands the others. byProcessor: the function runs in the
// mode, where a product with 1 is a flush.
void expand(llvm::Function& function, const std::set<const llvm::Instruction*>& native,
            bool byProcessor) {
    std::vector<llvm::CallInst*> needed, unneeded;
    FlushedFinder finder(native);
    for (llvm::Instruction& instruction : llvm::instructions(function))
        if (isFlushCall(&instruction)) {
            auto* call = llvm::cast<llvm::CallInst>(&instruction);
            (finder.isFlushed(call->getArgOperand(0)) ? unneeded : needed).push_back(call);
        }
    for (llvm::CallInst* call : unneeded) { // erased after all queries, whose cached results name
                                            // values
        call->replaceAllUsesWith(call->getArgOperand(0));
        call->eraseFromParent();
    }
    llvm::IRBuilder<> builder(function.getContext());
    Value* one = byProcessor && !needed.empty() ? hiddenOne(function) : nullptr;
    for (llvm::CallInst* call : needed) {
        builder.SetInsertPoint(call);
        Value* value = call->getArgOperand(0);
        if (one) {
            call->replaceAllUsesWith(builder.CreateFMul(value, one));
            call->eraseFromParent();
            continue;
        }
        llvm::Type* type = value->getType();
        Value* magnitude = builder.CreateUnaryIntrinsic(llvm::Intrinsic::fabs, value);
        Value* tiny = builder.CreateFCmpOLT(magnitude, llvm::ConstantFP::get(type, 0x1p-126));
        Value* zero = builder.CreateBinaryIntrinsic(llvm::Intrinsic::copysign,
                                                    llvm::ConstantFP::get(type, 0.0), value);
        call->replaceAllUsesWith(builder.CreateSelect(tiny, zero, value));
        call->eraseFromParent();
    }
}

// Properties of a function that decide its mode.
struct Arithmetic {
    std::set<const llvm::Instruction*> flushed; // results are only ever flushed
    std::vector<llvm::Instruction*> other;      // must run in the default mode
    std::vector<llvm::Function*> callees;       // null: unknown
    bool impossible = false;
};

Arithmetic arithmeticOf(llvm::Function& function) {
    Arithmetic found;
    const std::set<const llvm::Instruction*> none;
    FlushedFinder finder(none);
    for (llvm::Instruction& instruction : llvm::instructions(function)) {
        if (auto* atomic = llvm::dyn_cast<llvm::AtomicRMWInst>(&instruction))
            found.impossible |= atomic->isFloatingPointOperation();
        if (auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction))
            if (!llvm::isa<llvm::IntrinsicInst>(call) && !isFlushCall(call))
                found.callees.push_back(call->getCalledFunction());
        if (!isArithmetic(instruction) || finder.isFlushed(&instruction))
            continue;
        if (instruction.getType()->isFloatTy() &&
            std::all_of(instruction.user_begin(), instruction.user_end(), isFlushCall))
            found.flushed.insert(&instruction);
        else
            found.other.push_back(&instruction);
    }
    if (function.hasFnAttribute(kAnyModeAttribute))
        found.other.clear();
    return found;
}

// Creates and finds the functions that change the mode.
class Modes {
public:
    explicit Modes(Unit& unit) : unit_(unit), builder_(unit.context()) {}

    // Splits the function into entry and flushed body.
    llvm::Function* split(llvm::Function& function) {
        auto* body =
            llvm::Function::Create(function.getFunctionType(), llvm::GlobalValue::InternalLinkage,
                                   function.getName() + kFlushedSuffix, unit_.module());
        body->setAttributes(function.getAttributes());
        body->addFnAttr("denormal-fp-math-f32", "preserve-sign,ieee");
        body->splice(body->begin(), &function);
        body->setSubprogram(function.getSubprogram()); // lines move with the instructions
        function.setSubprogram(nullptr);
        for (unsigned i = 0; i < function.arg_size(); ++i)
            function.getArg(i)->replaceAllUsesWith(body->getArg(i));
        function.removeFnAttr(llvm::Attribute::AlwaysInline);
        body->removeFnAttr(llvm::Attribute::AlwaysInline);
        std::vector<Value*> arguments;
        for (llvm::Argument& argument : function.args())
            arguments.push_back(&argument);
        change(
            function, [&](Value* mode) { return builder_.CreateOr(mode, kFlushBit); },
            body->getFunctionType(), body, arguments);
        return body;
    }

    // A copy that runs in the mode, for functions called in both.
    llvm::Function* clone(llvm::Function& function, std::set<const llvm::Instruction*>& native) {
        llvm::ValueToValueMapTy copies;
        llvm::Function* copy = llvm::CloneFunction(&function, copies);
        copy->setLinkage(llvm::GlobalValue::InternalLinkage);
        copy->setName(function.getName() + kFlushedSuffix);
        copy->addFnAttr("denormal-fp-math-f32", "preserve-sign,ieee");
        std::set<const llvm::Instruction*> mapped;
        for (const llvm::Instruction* instruction : native)
            mapped.insert(llvm::cast<llvm::Instruction>(copies[instruction]));
        native = std::move(mapped);
        return copy;
    }

    // Makes a call go through the default mode.
    void leave(llvm::CallInst& call) {
        builder_.SetInsertPoint(&call);
        replace(call, call.getFunctionType(), call.getCalledOperand(),
                std::vector<Value*>(call.arg_begin(), call.arg_end()));
    }

    // Executes an instruction in the default mode.
    void leave(llvm::Instruction& instruction) {
        std::vector<Value*> operands(instruction.op_begin(), instruction.op_end());
        if (llvm::isa<llvm::CallInst>(instruction))
            operands.pop_back(); // the callee
        std::vector<llvm::Type*> types;
        for (Value* operand : operands)
            types.push_back(operand->getType());
        auto* type = llvm::FunctionType::get(instruction.getType(), types, false);
        auto* alone = llvm::Function::Create(type, llvm::GlobalValue::InternalLinkage,
                                             std::string("default.") + instruction.getOpcodeName(),
                                             unit_.module());
        alone->addFnAttr(llvm::Attribute::NoInline);
        alone->addFnAttr(llvm::Attribute::NoUnwind);
        auto* block = llvm::BasicBlock::Create(unit_.context(), "", alone);
        llvm::Instruction* copy = instruction.clone();
        copy->setDebugLoc(llvm::DebugLoc());
        builder_.SetCurrentDebugLocation(llvm::DebugLoc());
        for (unsigned i = 0; i < operands.size(); ++i)
            copy->setOperand(i, alone->getArg(i));
        builder_.SetInsertPoint(block);
        builder_.Insert(copy);
        builder_.CreateRet(copy);
        builder_.SetInsertPoint(&instruction);
        replace(instruction, type, alone, operands);
    }

private:
    static constexpr uint32_t kFlushBit = 1u << 15;

    void replace(llvm::Instruction& instruction, llvm::FunctionType* type, Value* callee,
                 std::vector<Value*> arguments) {
        arguments.insert(arguments.begin(), callee);
        llvm::CallInst* call = builder_.CreateCall(leaving(type), arguments);
        instruction.replaceAllUsesWith(call);
        instruction.eraseFromParent();
    }

    llvm::Function* leaving(llvm::FunctionType* type) {
        llvm::Function*& function = leaving_[type];
        if (function)
            return function;
        std::vector<llvm::Type*> types(type->param_begin(), type->param_end());
        types.insert(types.begin(), builder_.getPtrTy());
        function =
            llvm::Function::Create(llvm::FunctionType::get(type->getReturnType(), types, false),
                                   llvm::GlobalValue::InternalLinkage,
                                   kLeavePrefix + std::to_string(leaving_.size()), unit_.module());
        function->addFnAttr(llvm::Attribute::NoUnwind);
        std::vector<Value*> arguments;
        for (unsigned i = 1; i < function->arg_size(); ++i)
            arguments.push_back(function->getArg(i));
        llvm::IRBuilderBase::InsertPointGuard guard(builder_);
        change(
            *function, [&](Value* mode) { return builder_.CreateAnd(mode, ~kFlushBit); }, type,
            function->getArg(0), arguments);
        return function;
    }

    // Writes the body: changes the mode, calls, restores the mode.
    template <class Change>
    void change(llvm::Function& function, Change changed, llvm::FunctionType* type, Value* callee,
                const std::vector<Value*>& arguments) {
        function.addFnAttr(llvm::Attribute::NoInline);
        builder_.SetInsertPoint(llvm::BasicBlock::Create(unit_.context(), "", &function));
        builder_.SetCurrentDebugLocation(llvm::DebugLoc()); // belongs to no line
        llvm::Type* word = builder_.getInt32Ty();
        Value* saved = builder_.CreateAlloca(word);
        Value* inside = builder_.CreateAlloca(word);
        builder_.CreateIntrinsic(llvm::Intrinsic::x86_sse_stmxcsr, {}, {saved});
        builder_.CreateStore(changed(builder_.CreateLoad(word, saved)), inside);
        builder_.CreateIntrinsic(llvm::Intrinsic::x86_sse_ldmxcsr, {}, {inside});
        llvm::CallInst* result = builder_.CreateCall(type, callee, arguments);
        result->addFnAttr(llvm::Attribute::NoInline);
        result->addFnAttr(llvm::Attribute::NoUnwind);
        builder_.CreateIntrinsic(llvm::Intrinsic::x86_sse_ldmxcsr, {}, {saved});
        if (type->getReturnType()->isVoidTy())
            builder_.CreateRetVoid();
        else
            builder_.CreateRet(result);
    }

    Unit& unit_;
    llvm::IRBuilder<> builder_;
    std::map<llvm::FunctionType*, llvm::Function*> leaving_;
};

// A change of mode costs about as much as this many explicit flushes.
constexpr size_t kFlushesPerChange = 6;

using Analyses = llvm::MapVector<llvm::Function*, Arithmetic>;

// Whether a function can run in the mode without leaving it for its own arithmetic.
bool canStay(const Analyses& all, llvm::Function* function) {
    const auto found = all.find(function);
    return found != all.end() && !found->second.impossible && found->second.other.empty();
}

bool paysOff(const Analyses& all, const Arithmetic& found) {
    const size_t leaving =
        size_t(std::count_if(found.callees.begin(), found.callees.end(),
                             [&](llvm::Function* callee) { return !canStay(all, callee); }));
    const size_t changes = 1 + leaving + found.other.size();
    return !found.impossible && found.flushed.size() >= changes * kFlushesPerChange;
}

// Functions whose arithmetic the mode does not change and whose callers run in the mode get a copy
// that runs in the mode too, so that calls stay direct and can be inlined.
void addCallees(const Analyses& all, std::set<llvm::Function*>& chosen) {
    std::vector<llvm::Function*> queue(chosen.begin(), chosen.end());
    while (!queue.empty()) {
        const Arithmetic& caller = all.find(queue.back())->second;
        queue.pop_back();
        for (llvm::Function* callee : caller.callees)
            if (canStay(all, callee) && chosen.insert(callee).second)
                queue.push_back(callee);
    }
}

} // namespace

llvm::Function& flushedOf(Unit& unit, llvm::Function& function) {
    llvm::Function* moved = unit.module().getFunction((function.getName() + kFlushedSuffix).str());
    return moved ? *moved : function;
}

void runFlushed(Unit& unit, llvm::Function& function) {
    Modes(unit).split(function);
}

void lowerFlushes(Unit& unit, bool hasFma) {
    llvm::Function* flush = unit.module().getFunction(kFlushName);
    if (!flush)
        return;
    Analyses all;
    for (llvm::Function& function : unit.module())
        if (!function.isDeclaration())
            all[&function] = arithmeticOf(function);
    std::set<llvm::Function*> chosen;
    for (const auto& [function, found] : all)
        if (hasFma && paysOff(all, found))
            chosen.insert(function);
    addCallees(all, chosen);

    Modes modes(unit);
    llvm::MapVector<llvm::Function*, llvm::Function*> bodies;
    for (auto& [function, found] : all) {
        if (!chosen.count(function)) {
            expand(*function, {}, false);
            continue;
        }
        if (paysOff(all, found)) {
            expand(*function, found.flushed, true);
            bodies[function] = modes.split(*function);
        } else { // chosen because of its callers
            llvm::Function* copy = modes.clone(*function, found.flushed);
            expand(*function, {}, false);
            expand(*copy, found.flushed, true);
            bodies[function] = copy;
        }
    }
    for (auto& [function, body] : bodies) {
        std::vector<llvm::CallInst*> calls;
        for (llvm::Instruction& instruction : llvm::instructions(*body))
            if (auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction))
                if (!llvm::isa<llvm::IntrinsicInst>(call) && !call->isInlineAsm())
                    calls.push_back(call);
        for (llvm::CallInst* call : calls) {
            const auto other = bodies.find(call->getCalledFunction());
            if (other != bodies.end())
                call->setCalledFunction(other->second);
            else
                modes.leave(*call);
        }
        for (llvm::Instruction* instruction : all[function].other)
            modes.leave(*instruction);
    }
    flush->eraseFromParent();
}

} // namespace sunstone::compiler
