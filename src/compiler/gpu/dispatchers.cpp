// SPDX-License-Identifier: Apache-2.0
// See dispatchers.h.
#include "compiler/gpu/dispatchers.h"

#include "compiler/gpu/calls_by_address.h"

#include <llvm/IR/IRBuilder.h>

#include <algorithm>
#include <map>
#include <set>

namespace sunstone::compiler {

namespace {

constexpr auto kAnyKind = devlib::GroupKind(0);

struct Dispatcher {
    const char* name;
    devlib::GroupKind kind; // of groups, or kAnyKind
    devlib::Role role;
    enum Form {
        kRun,    // (state, group): calls the program
        kAsk,    // (state, candidates, group): calls an intersection program
        kStart,  // (state, ray, frame, asks, group): calls its first part, or all of it
        kResume, // the same for the part after its traces
        kFind,   // (group): whether there is one
        kCode,   // (group): its address
    } form;
};

// Whether a dispatcher for groups of kind `wanted` serves groups of this kind. Bounds programs are
// entries of launches, as ray generation programs are.
bool serves(devlib::GroupKind wanted, devlib::GroupKind kind) {
    return wanted == kAnyKind || wanted == kind ||
           (wanted == devlib::kGroupRaygen && kind == devlib::kGroupBounds);
}

constexpr Dispatcher kDispatchers[] = {
    {"sunstone_gpu_raygen", devlib::kGroupRaygen, devlib::kRoleMain, Dispatcher::kRun},
    {"sunstone_gpu_start", devlib::kGroupRaygen, devlib::kRoleMain, Dispatcher::kStart},
    {"sunstone_gpu_startHit", devlib::kGroupHit, devlib::kRoleMain, Dispatcher::kStart},
    {"sunstone_gpu_startMiss", devlib::kGroupMiss, devlib::kRoleMain, Dispatcher::kStart},
    {"sunstone_gpu_resume", devlib::kGroupRaygen, devlib::kRoleMain, Dispatcher::kResume},
    {"sunstone_gpu_resumeAny", kAnyKind, devlib::kRoleMain, Dispatcher::kResume},
    {"sunstone_gpu_findRaygen", devlib::kGroupRaygen, devlib::kRoleMain, Dispatcher::kFind},
    {"sunstone_gpu_miss", devlib::kGroupMiss, devlib::kRoleMain, Dispatcher::kRun},
    {"sunstone_gpu_exception", devlib::kGroupException, devlib::kRoleMain, Dispatcher::kRun},
    {"sunstone_gpu_closestHit", devlib::kGroupHit, devlib::kRoleMain, Dispatcher::kRun},
    {"sunstone_gpu_anyHit", devlib::kGroupHit, devlib::kRoleAnyHit, Dispatcher::kRun},
    {"sunstone_gpu_intersection", devlib::kGroupHit, devlib::kRoleIntersection, Dispatcher::kAsk},
    {"sunstone_gpu_attribute", devlib::kGroupHit, devlib::kRoleAttribute, Dispatcher::kRun},
    {"sunstone_gpu_visit", devlib::kGroupVisit, devlib::kRoleMain, Dispatcher::kRun},
    {"sunstone_gpu_direct", devlib::kGroupCallables, devlib::kRoleDirect, Dispatcher::kCode},
    {"sunstone_gpu_continuation", devlib::kGroupCallables, devlib::kRoleContinuation,
     Dispatcher::kCode},
};

// The part that has the dispatcher if the kernel is compiled without programs; kWhole: the kernel
// does not call it.
GpuPart partOf(const Dispatcher& dispatcher) {
    const bool isOfRays =
        dispatcher.kind == devlib::kGroupHit || dispatcher.kind == devlib::kGroupMiss;
    switch (dispatcher.form) {
    case Dispatcher::kStart:
        return isOfRays ? GpuPart::kRays : GpuPart::kEntries;
    case Dispatcher::kFind:
        return GpuPart::kEntries;
    case Dispatcher::kAsk:
        return GpuPart::kRays;
    case Dispatcher::kResume:
        return dispatcher.kind == kAnyKind ? GpuPart::kResumes : GpuPart::kWhole;
    default:
        return dispatcher.role == devlib::kRoleAnyHit ||
                       dispatcher.role == devlib::kRoleAttribute ||
                       dispatcher.kind == devlib::kGroupException
                   ? GpuPart::kRays
                   : GpuPart::kWhole;
    }
}

bool isIn(GpuPart part, const Dispatcher& dispatcher) {
    return part == GpuPart::kWhole || part == GpuPart::kPrograms || partOf(dispatcher) == part ||
           partOf(dispatcher) == GpuPart::kWhole;
}

llvm::FunctionType* typeOf(Dispatcher::Form form, llvm::LLVMContext& context) {
    llvm::Type* const pointer = llvm::PointerType::getUnqual(context);
    llvm::Type* const word = llvm::Type::getInt32Ty(context);
    const size_t pointers = form == Dispatcher::kFind  ? 0
                            : form == Dispatcher::kRun ? 1
                            : form == Dispatcher::kAsk ? 2
                                                       : 4;
    std::vector<llvm::Type*> parameters(pointers, pointer);
    parameters.push_back(word);
    return llvm::FunctionType::get(word, parameters, false);
}

// Returns the function that a dispatcher calls for a program; null: none.
llvm::Function* targetOf(const CutPrograms& cutPrograms, Dispatcher::Form form,
                         llvm::Function* program) {
    const auto cut = cutPrograms.cuts.find(program);
    switch (form) {
    case Dispatcher::kStart:
        return cut == cutPrograms.cuts.end() ? program : cut->second.start;
    case Dispatcher::kResume:
        return cut == cutPrograms.cuts.end() ? nullptr : cut->second.resume;
    case Dispatcher::kFind:
        return program;
    default:
        return cut == cutPrograms.cuts.end() ? program : nullptr;
    }
}

// A dispatcher's call of a program, or of a part of it, and the result.
llvm::Value* callProgram(llvm::IRBuilder<>& builder, llvm::Function& dispatcher,
                         llvm::Function& program) {
    std::vector<llvm::Value*> operands = {dispatcher.getArg(0)};
    if (program.arg_size() == 2) // state, candidates
        operands.push_back(dispatcher.getArg(1));
    if (program.arg_size() == 4) // frame, state, ray, asks
        operands = {dispatcher.getArg(2), dispatcher.getArg(0), dispatcher.getArg(1),
                    dispatcher.getArg(3)};
    llvm::CallInst* call = builder.CreateCall(&program, operands);
    return call->getType()->isIntegerTy(32) ? static_cast<llvm::Value*>(call)
                                            : builder.getInt32(devlib::kAccept);
}

// Makes a function that calls the program and has the dispatcher's parameters without the group, so
// that all programs of a dispatcher have one type.
llvm::Function* makePart(llvm::Function& dispatcher, llvm::Function& program) {
    llvm::FunctionType* const type = dispatcher.getFunctionType();
    llvm::Function* const part = llvm::Function::Create(
        llvm::FunctionType::get(type->getReturnType(), type->params().drop_back(), false),
        llvm::GlobalValue::InternalLinkage, program.getName() + ".apart", *program.getParent());
    part->addFnAttr(llvm::Attribute::NoInline);
    part->addFnAttr(llvm::Attribute::NoUnwind);
    part->addFnAttr(kPartByAddress);
    llvm::IRBuilder<> builder(llvm::BasicBlock::Create(program.getContext(), "", part));
    builder.CreateRet(callProgram(builder, *part, program));
    return part;
}

// switch (group) { case number: return program(state); ... default: return 0; }
class Switch {
public:
    // `isApart`: programs are not inlined but called by address, at one place.
    Switch(llvm::Function& function, Dispatcher::Form form, bool isApart)
        : function_(function), form_(form), builder_(function.getContext()) {
        function.addFnAttr(llvm::Attribute::AlwaysInline);
        function.addFnAttr(llvm::Attribute::NoUnwind);
        auto* entry = llvm::BasicBlock::Create(function.getContext(), "", &function);
        auto* other = llvm::BasicBlock::Create(function.getContext(), "none", &function);
        builder_.SetInsertPoint(other);
        builder_.CreateRet(
            form == Dispatcher::kCode
                ? static_cast<llvm::Value*>(llvm::ConstantPointerNull::get(builder_.getPtrTy()))
                : builder_.getInt32(~0u));
        builder_.SetInsertPoint(entry);
        choice_ = builder_.CreateSwitch(function.getArg(unsigned(function.arg_size()) - 1), other);
        if (isApart)
            makeCall();
    }

    void add(uint32_t group, llvm::Function& program) {
        llvm::BasicBlock*& block = calls_[&program];
        if (!block) {
            block = llvm::BasicBlock::Create(function_.getContext(), "", &function_);
            builder_.SetInsertPoint(block);
            if (callee_) {
                callee_->addIncoming(makePart(function_, program), block);
                builder_.CreateBr(callee_->getParent());
            } else {
                builder_.CreateRet(resultOf(program));
            }
        }
        choice_->addCase(builder_.getInt32(group), block);
    }

private:
    void makeCall() {
        llvm::FunctionType* const type = function_.getFunctionType();
        auto* block = llvm::BasicBlock::Create(function_.getContext(), "call", &function_);
        builder_.SetInsertPoint(block);
        callee_ = builder_.CreatePHI(builder_.getPtrTy(), 2);
        std::vector<llvm::Value*> operands;
        for (llvm::Argument& argument : function_.args())
            operands.push_back(&argument);
        operands.pop_back();
        llvm::CallInst* const call = builder_.CreateCall(
            llvm::FunctionType::get(type->getReturnType(), type->params().drop_back(), false),
            callee_, operands);
        call->addFnAttr(llvm::Attribute::get(function_.getContext(), kPartByAddress));
        builder_.CreateRet(call);
    }

    llvm::Value* resultOf(llvm::Function& program) {
        if (form_ == Dispatcher::kCode)
            return &program;
        if (form_ == Dispatcher::kFind)
            return builder_.getInt32(0);
        return callProgram(builder_, function_, program);
    }

    llvm::Function& function_;
    Dispatcher::Form form_;
    llvm::IRBuilder<> builder_;
    llvm::SwitchInst* choice_ = nullptr;
    llvm::PHINode* callee_ = nullptr; // of the one call, if programs are called by address
    std::map<llvm::Function*, llvm::BasicBlock*> calls_; // one call per program
};

// Whether programs, by group, have more instructions than GpuPipelineRequest::mostInlined.
bool areLong(const Dispatcher& dispatcher, const std::map<uint32_t, llvm::Function*>& targets,
             size_t mostInlined) {
    if (dispatcher.role != devlib::kRoleMain || dispatcher.form == Dispatcher::kFind)
        return false;
    std::set<const llvm::Function*> programs;
    size_t instructions = 0;
    for (const auto& [group, program] : targets)
        if (programs.insert(program).second)
            instructions += program->getInstructionCount();
    return programs.size() > 1 && instructions > mostInlined;
}

// Defines a function of a number that returns the fact about the number, or `none`.
using Facts = std::map<uint32_t, llvm::Value*>;
void defineFacts(llvm::Module& module, const char* name, llvm::Value* none, const Facts& facts) {
    llvm::IRBuilder<> builder(module.getContext());
    llvm::Function* const function = module.getFunction(name);
    if (!function) // the run-time does not call it
        return;
    function->addFnAttr(llvm::Attribute::NoUnwind);
    auto* entry = llvm::BasicBlock::Create(module.getContext(), "", function);
    auto* other = llvm::BasicBlock::Create(module.getContext(), "none", function);
    builder.SetInsertPoint(other);
    builder.CreateRet(none);
    builder.SetInsertPoint(entry);
    auto* choice = builder.CreateSwitch(function->getArg(0), other);
    for (const auto& [number, fact] : facts) {
        auto* block = llvm::BasicBlock::Create(module.getContext(), "", function);
        builder.SetInsertPoint(block);
        builder.CreateRet(fact);
        choice->addCase(builder.getInt32(number), block);
    }
}

} // namespace

void declareDispatchers(llvm::Module& module, GpuPart part) {
    for (const Dispatcher& dispatcher : kDispatchers)
        if (partOf(dispatcher) != GpuPart::kWhole && isIn(part, dispatcher))
            module.getOrInsertFunction(dispatcher.name,
                                       typeOf(dispatcher.form, module.getContext()));
}

bool isDispatcher(llvm::StringRef name) {
    return std::ranges::any_of(kDispatchers, [&](const Dispatcher& dispatcher) {
        return partOf(dispatcher) != GpuPart::kWhole && name == dispatcher.name;
    });
}

void defineDispatchers(llvm::Module& module, const GpuPipelineRequest& request,
                       const std::vector<llvm::Function*>& programs, const CutPrograms& cuts) {
    for (const Dispatcher& dispatcher : kDispatchers) {
        llvm::Function* const function = module.getFunction(dispatcher.name);
        if (!function) // the run-time does not call it
            continue;
        if (!isIn(request.part, dispatcher)) // another part has it
            continue;
        std::map<uint32_t, llvm::Function*> targets; // by group; one may be given twice
        for (const GpuGroup& group : request.groups) {
            const size_t index = group.programs[dispatcher.role];
            if (index == GpuGroup::kNone || !serves(dispatcher.kind, group.kind))
                continue;
            if (llvm::Function* program = targetOf(cuts, dispatcher.form, programs[index]))
                targets.emplace(group.number, program);
        }
        Switch choice(*function, dispatcher.form,
                      areLong(dispatcher, targets, request.mostInlined));
        for (const auto& [group, program] : targets)
            choice.add(group, *program);
    }
}

void defineGroupFacts(llvm::Module& module, const std::vector<GpuGroup>& groups) {
    llvm::IRBuilder<> builder(module.getContext());
    Facts words, names, builtins, all; // a group may be given twice
    for (const GpuGroup& group : groups) {
        all.emplace(group.number, builder.getInt32(1));
        for (uint32_t kind = 0; kind < 2; ++kind) {
            const GpuGroup::Callable& callable = group.callables[kind];
            if (callable.name.empty())
                continue;
            const uint32_t number = 2 * group.number + kind;
            words.emplace(number, builder.getInt32(callable.parameterWords));
            if (!names.contains(number))
                names[number] = builder.CreateGlobalString(callable.name, "", 0, &module);
        }
        if (group.builtin)
            builtins.emplace(group.number, builder.getInt32(group.builtin));
    }
    defineFacts(module, "sunstone_gpu_callableWords", builder.getInt32(0), words);
    defineFacts(module, "sunstone_gpu_callableName",
                llvm::ConstantPointerNull::get(builder.getPtrTy()), names);
    defineFacts(module, "sunstone_gpu_builtin", builder.getInt32(0), builtins);
    defineFacts(module, "sunstone_gpu_isGroup", builder.getInt32(0), all);
}

} // namespace sunstone::compiler
