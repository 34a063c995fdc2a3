// SPDX-License-Identifier: Apache-2.0
// One compilation: the LLVM module under construction and the symbols of all its PTX modules. A
// function or variable is declared and queued when code refers to it, so unreachable code costs no
// time. Read next: function_translator.h.
#pragma once

#include "base/error.h"
#include "compiler/compiler.h"
#include "compiler/flavor.h"
#include "compiler/store/code_object.h"

#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/LLVMContext.h>
#include <llvm/IR/Module.h>

#include <deque>
#include <map>
#include <set>
#include <unordered_map>

namespace sunstone::compiler {

using ErrorCode = sunstone::Code; // next to this folder's class Code

// What the code is for. The LLVM IR for GPUs differs in two points: instructions without an exact
// LLVM equivalent stay PTX, as inline assembly (translate/native.cpp), and the functions of
// LaunchState are linked by name.
enum class Target : uint8_t { kCpu, kGpu };

// Whether the unit defines the variables it uses, or refers to those of another piece of code.
enum class Variables : uint8_t { kDefined, kReferenced };

// User symbols have prefixes, so that they never clash with the run-time's names.
constexpr const char* kFunctionPrefix = "f.";

// Throws Error whose text begins with the PTX line.
template <class... Parts>
[[noreturn]] void failAt(ErrorCode code, ptx::Location location, const Parts&... parts) {
    if (location.line == 0)
        fail(code, parts...);
    fail(code, "line ", location.line, ": ", parts...);
}

// The run-time's symbol for a function that CUDA's driver provides, or null. The function takes the
// hidden state like every other function; isKernels: the state is a KernelThread.
const char* providedFunction(std::string_view name, bool isKernels = false);

// The calling convention of a PTX function or prototype: first the hidden state pointer, then one
// out-pointer per result (unless there is exactly one scalar result), then scalars by value (as
// integers of their width) and aggregates by pointer to the caller's copy.
struct Signature {
    llvm::FunctionType* type = nullptr;
    bool returnsValue = false;
};

// Facts about a translated function, for the call graph pass.
struct FunctionFacts {
    const ptx::Module* module = nullptr;
    const ptx::Function* function = nullptr;
    bool barriers = false;
    bool warp = false;
    uint64_t localBytes = 0;
};

// A .shared variable; its offset is decided when all its users are known.
struct SharedVariable {
    const ptx::Variable* variable = nullptr;
    llvm::GlobalVariable* placeholder = nullptr; // its address stands for the offset
    std::set<llvm::Function*> users;
    bool dynamic = false; // .extern .shared name[]
};

class DebugInfo;

class Unit {
public:
    ~Unit();
    Unit(const Flavor& flavor, PipelineRules rules, std::vector<const ptx::Module*> modules,
         Variables variables = Variables::kDefined);

    const Flavor& flavor() const { return flavor_; }
    const std::vector<const ptx::Module*>& modules() const { return modules_; }
    void setTarget(Target target) { target_ = target; } // before anything is translated
    bool isGpu() const { return target_ == Target::kGpu; }
    const PipelineRules& rules() const { return rules_; }
    llvm::LLVMContext& context() { return *context_; }
    llvm::Module& module() { return *module_; }

    // The function of this name as visible from `from`: its own, or another module's visible one.
    llvm::Function* function(const ptx::Module& from, std::string_view name,
                             ptx::Location location);
    llvm::Function* declare(const ptx::Module& module, const ptx::Function& function);
    // Whether the name resolves to any function.
    bool knowsFunction(const ptx::Module& from, std::string_view name) const;

    bool isLaunchParams(const ptx::Variable& variable) const;
    const ptx::Variable* findVariable(const ptx::Module& from, std::string_view name) const;
    // Global or constant variable; never a shared one or the launch parameters.
    llvm::Constant* variable(const ptx::Module& from, std::string_view name,
                             ptx::Location location);
    llvm::Constant* addVariable(const ptx::Module& module, const ptx::Variable& variable);
    // The variable of an id of this unit; throws kInternal if it does not exist.
    void addVariable(const VariableId& id);
    // The defined variables in constant memory of all modules, the launch parameters too.
    std::vector<std::pair<const ptx::Module*, const ptx::Variable*>> constants() const;
    llvm::Constant* sharedOffset(const ptx::Variable& variable, llvm::Function* user);

    // Translates queued functions and initialisers until the queue is empty.
    void translateQueue();

    Signature signature(const std::vector<ptx::Variable>& results,
                        const std::vector<ptx::Variable>& parameters);
    llvm::Function* intrinsic(const Intrinsic& intrinsic, std::string_view fullName);
    // A function of the run-time (runtime.h). pure: the result depends only on the operands.
    llvm::FunctionCallee helper(const char* name, llvm::Type* result,
                                llvm::ArrayRef<llvm::Type*> operands, bool pure = true);

    // The address of a function of LaunchState: loaded from `launch`, or for a GPU linked by its
    // name in the struct.
    llvm::Value* launchFunction(llvm::IRBuilder<>& builder, llvm::Value* launch, size_t offset,
                                const char* name, llvm::FunctionType* type);

    std::map<llvm::Function*, FunctionFacts>& facts() { return facts_; }
    // The programs among the functions. A program's kind is set before it is translated.
    ProgramKinds& kinds() { return kinds_; }
    std::deque<SharedVariable>& shared() { return shared_; }
    // Variables that have a symbol, in the order they were added.
    const std::vector<VariableId>& variableIds() const { return ids_; }
    const Intrinsic* intrinsicOf(const llvm::Function* function) const;
    // Numbers the accesses of the PTX for the memory checker.
    uint32_t nextAccess(bool isNew) { return isNew ? ++accesses_ : accesses_; }

    // For a GPU: in each module the first instruction that may need the module's header, in the
    // order they were added; see gpu/header.h.
    struct HeaderNeed {
        const ptx::Module* module;
        const ptx::Instruction* instruction;
    };
    void needHeader(const ptx::Module& module, const ptx::Instruction& instruction);
    const std::vector<HeaderNeed>& headerNeeds() const { return headerNeeds_; }

    // Sets the options of a module. By default a module has none, and line information if its PTX
    // does.
    void setOptions(const ptx::Module& module, std::shared_ptr<const ModuleRules> rules,
                    DebugLevel level);
    uint32_t moduleNumber(const ptx::Module& module) const; // from 0
    const ModuleRules& moduleRules(uint32_t moduleNumber) const;
    DebugLevel debugLevel(const ptx::Module& module) const {
        return options_[moduleNumber(module)].level;
    }
    DebugInfo& debugInfo(); // made at the first call
    bool hasLineInfo(const ptx::Module& module) const;
    bool debugExceptions() const { return rules_.exceptionFlags & devlib::kFlagDebug; }

private:
    struct Symbols {
        std::unordered_map<std::string_view, const ptx::Function*> functions;
        std::unordered_map<std::string_view, const ptx::Variable*> variables;
    };
    struct Definition {
        const ptx::Module* module = nullptr;
        const ptx::Function* function = nullptr;
        const ptx::Variable* variable = nullptr;
        bool weak = false;
    };

    void collect(const ptx::Module& module);
    void publish(std::string_view name, Definition definition);
    const Definition* published(std::string_view name) const;
    std::string moduleLabel(const ptx::Module* module) const;
    VariableId idOf(const ptx::Module& module, const ptx::Variable& variable) const;
    llvm::Type* initializerType(const ptx::Variable& variable);
    llvm::Constant* initializer(const ptx::Module& module, const ptx::Variable& variable);
    llvm::Function* runtimeFunction(std::string_view name, const ptx::Module& from);

    const Flavor& flavor_;
    Target target_ = Target::kCpu;
    Variables home_;
    PipelineRules rules_;
    std::vector<const ptx::Module*> modules_;
    std::unique_ptr<llvm::LLVMContext> context_;
    std::unique_ptr<llvm::Module> module_;
    std::unordered_map<const ptx::Module*, Symbols> symbols_;
    std::unordered_map<std::string_view, Definition> published_;
    std::unordered_map<const ptx::Function*, llvm::Function*> functions_;
    std::unordered_map<const ptx::Variable*, llvm::GlobalVariable*> variables_;
    std::unordered_map<const ptx::Variable*, SharedVariable*> sharedIndex_;
    std::unordered_map<const llvm::Function*, const Intrinsic*> intrinsics_;
    std::deque<llvm::Function*> functionQueue_;
    std::deque<std::pair<const ptx::Module*, const ptx::Variable*>> variableQueue_;
    std::map<llvm::Function*, FunctionFacts> facts_;
    ProgramKinds kinds_;
    std::deque<SharedVariable> shared_;
    std::vector<VariableId> ids_;
    uint32_t accesses_ = 0;
    std::vector<HeaderNeed> headerNeeds_;
    std::unique_ptr<DebugInfo> debugInfo_;
    struct Options {
        std::shared_ptr<const ModuleRules> rules;
        DebugLevel level = DebugLevel::kMinimal;
    };
    std::vector<Options> options_; // of modules_
};

} // namespace sunstone::compiler
