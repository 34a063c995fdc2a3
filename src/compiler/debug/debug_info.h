// SPDX-License-Identifier: Apache-2.0
// Debug information of compiled code, from the PTX: .file and .loc give lines (debug level MINIMAL
// and up), the DWARF sections variables (level FULL).
//
// Functions inlined before the PTX was written have frames of their own: LLVM's inlined locations,
// made from .loc ... inlined_at or from the scopes of the DWARF sections.
//
// Variables. PTX keeps them in depots and registers. Both are promoted to values soon after
// translation, because later passes need constants. LLVM tracks the values in debug records. After
// lowering, pinVariables gives each variable memory and stores every value there, so a debugger
// sees the variable at every stop in its scope. The launch parameters are a local variable of each
// function.
#pragma once

#include "compiler/debug/dwarf.h"
#include "compiler/debug/inlined_calls.h"
#include "compiler/translate/unit.h"

#include <llvm/IR/DIBuilder.h>

#include <optional>
#include <tuple>

namespace sunstone::compiler {

// Debug information of one unit.
class DebugInfo {
public:
    explicit DebugInfo(Unit& unit);

    // Null if the module has no line information or the level forbids it.
    llvm::DISubprogram* describe(const ptx::Module& module, const ptx::Function& source);
    llvm::DIFile* file(const ptx::Module& module, uint32_t number);
    // Null unless the level is FULL and the module describes the function.
    const DwarfFunction* variablesOf(const ptx::Module& module, const ptx::Function& source);
    llvm::DIType* type(const ptx::Module& module, uint32_t key);
    // The description of a function that exists only inlined, shared by all its calls. `origin`
    // tells functions of one name apart (DwarfInlined).
    llvm::DISubprogram* inlinedFunction(const ptx::Module& module, const std::string& name,
                                        uint32_t file, uint32_t line, uint32_t origin);
    const InlinedCalls& inlinedCalls(const ptx::Module& module);
    // The inlined call with this number (inlined_calls.h): its function, and its place within
    // `function`, which contains the instruction.
    struct InlinedScope {
        llvm::DISubprogram* function = nullptr;
        llvm::DILocation* at = nullptr;
    };
    InlinedScope inlinedScope(const ptx::Module& module, uint32_t number,
                              const ptx::SourcePosition& within, llvm::DISubprogram* function);
    // The description of a variable of an inlined function, shared by all its calls.
    llvm::DILocalVariable*& inlinedVariable(llvm::DISubprogram* function,
                                            const DwarfVariable& from) {
        return inlinedVariables_[{function, from.name, from.line, from.origin}];
    }
    // The parameters of an inlined function that have a description. Calls may list different
    // parameters, and LLVM fails if two parameters have one number.
    unsigned& inlinedParameters(llvm::DISubprogram* function) {
        return inlinedParameters_[function];
    }
    // Makes the local variable that stands for the launch parameters in a function, if the module
    // describes them.
    void describeLaunchParams(const ptx::Module& module, llvm::DISubprogram* function);
    llvm::DILocalVariable* launchParamsIn(llvm::DISubprogram* function) const {
        const auto found = launchParams_.find(function);
        return found == launchParams_.end() ? nullptr : found->second;
    }
    llvm::DIBuilder& builder() { return builder_; }
    // Call once, after all functions are translated.
    void finish();

private:
    struct ModuleInfo {
        std::map<uint32_t, llvm::DIFile*> files;
        std::map<uint32_t, llvm::DIType*> types;
        // By name, file and origin.
        std::map<std::tuple<std::string, uint32_t, uint32_t>, llvm::DISubprogram*> inlined;
        std::map<uint32_t, std::string> inlinedNames; // by number of the call
        std::optional<DwarfInfo> dwarf;
        std::optional<InlinedCalls> calls;
    };
    const DwarfInfo& dwarf(const ptx::Module& module);
    llvm::DIType* makeType(const ptx::Module& module, uint32_t key, const DwarfType& type);

    Unit& unit_;
    llvm::DIBuilder builder_;
    llvm::DICompileUnit* compileUnit_ = nullptr;
    std::map<const ptx::Module*, ModuleInfo> modules_;
    // Calls by number, in the function that contains their code.
    std::map<std::pair<llvm::DISubprogram*, uint32_t>, InlinedScope> inlinedScopes_;
    std::map<std::tuple<llvm::DISubprogram*, std::string, uint32_t, uint32_t>,
             llvm::DILocalVariable*>
        inlinedVariables_; // by function, name, line and origin
    std::map<llvm::DISubprogram*, unsigned> inlinedParameters_;
    std::map<llvm::DISubprogram*, llvm::DILocalVariable*> launchParams_;
};

// Debug information of one function during translation: its open scopes and the places of its
// variables.
class FunctionDebug {
public:
    FunctionDebug(DebugInfo& info, const ptx::Module& module, const ptx::Function& source,
                  llvm::Function& function);

    // Sets the builder's location for the code of an instruction on line `textLine` of the PTX text
    // (0: unknown).
    void setLocation(llvm::IRBuilder<>& builder, const ptx::SourcePosition& source,
                     uint32_t textLine);
    // The memory of a variable of the function's PTX.
    void atMemory(std::string_view name, llvm::Value* memory, llvm::BasicBlock* block);
    // Call at a label; returns the registers (by index) that hold variables from here on.
    std::vector<uint32_t> atLabel(std::string_view label);
    // A register has this value from here on.
    void atValue(llvm::IRBuilder<>& builder, uint32_t reg, llvm::Value* value);
    bool hasVariables() const { return !variables_.empty(); }

private:
    struct Place {
        const DwarfPlace* dwarf = nullptr;
        uint32_t reg = ~0u;
        bool active = false;
    };
    struct Variable {
        llvm::DILocalVariable* variable = nullptr;
        llvm::DILocation* location = nullptr;
        std::vector<Place> places;
    };
    // The scope of code: a function or block, and the call that inlined it, if any.
    struct Scope {
        llvm::DILocalScope* scope = nullptr;
        llvm::DILocation* inlinedAt = nullptr;
        bool operator==(const Scope&) const = default;
    };
    void addScope(const DwarfScope& scope, Scope parent, unsigned& parameters);
    void addVariable(const DwarfVariable& from, Scope parent, unsigned& parameters);
    Scope enterInlined(const DwarfInlined& inlined, Scope parent);

    DebugInfo& info_;
    const ptx::Module& module_;
    llvm::DISubprogram* subprogram_ = nullptr;
    std::map<std::string, std::vector<Scope>, std::less<>> begins_, ends_;
    std::vector<Scope> open_;
    std::vector<Variable> variables_;
    std::map<std::string, uint32_t, std::less<>> registers_; // by full name
};

// Gives variables with debug records memory of their own; see the head comment.
void pinVariables(Unit& unit);

} // namespace sunstone::compiler
