// SPDX-License-Identifier: Apache-2.0
// Debug information of compiled code, from what the PTX brings: .file and .loc give lines (debug
// level MINIMAL and up), the DWARF sections variables (level FULL).
//
// Functions that the compiler which wrote the PTX inlined have frames of their own: LLVM's inlined
// locations, made from .loc ... inlined_at or from the scopes of the DWARF sections.
//
// Variables. Their places in PTX are depots and registers, both of which are promoted to values
// soon after translation, as the compiler needs constants to show. LLVM keeps track of the values
// (debug records); when all is lowered, pinVariables gives each variable memory of its own and
// stores every value there, so that a debugger sees the variable at any stop of its scope.
#pragma once

#include "compiler/debug/dwarf.h"
#include "compiler/debug/inlined_calls.h"
#include "compiler/translate/unit.h"

#include <llvm/IR/DIBuilder.h>

#include <optional>
#include <tuple>

namespace sunstone::compiler {

// Of one unit.
class DebugInfo {
public:
    explicit DebugInfo(Unit& unit);

    // Null where the module has no line information or the level forbids it.
    llvm::DISubprogram* describe(const ptx::Module& module, const ptx::Function& source);
    llvm::DIFile* file(const ptx::Module& module, uint32_t number);
    // Null unless the level is FULL and the module says something of the function.
    const DwarfFunction* variablesOf(const ptx::Module& module, const ptx::Function& source);
    llvm::DIType* type(const ptx::Module& module, uint32_t key);
    // A function that only exists inlined; one for all its calls.
    llvm::DISubprogram* inlinedFunction(const ptx::Module& module, const std::string& name,
                                        uint32_t file, uint32_t line);
    const InlinedCalls& inlinedCalls(const ptx::Module& module);
    // The call with this number (inlined_calls.h): its function, and its place within `function`,
    // which has the instruction.
    struct InlinedScope {
        llvm::DISubprogram* function = nullptr;
        llvm::DILocation* at = nullptr;
    };
    InlinedScope inlinedScope(const ptx::Module& module, uint32_t number,
                              const ptx::SourcePosition& within, llvm::DISubprogram* function);
    // A variable of an inlined function; one for all its calls.
    llvm::DILocalVariable*& inlinedVariable(llvm::DISubprogram* function, const std::string& name,
                                            uint32_t line) {
        return inlinedVariables_[{function, name, line}];
    }
    llvm::DIBuilder& builder() { return builder_; }
    // Once, when all functions are translated.
    void finish();

private:
    struct ModuleInfo {
        std::map<uint32_t, llvm::DIFile*> files;
        std::map<uint32_t, llvm::DIType*> types;
        std::map<std::pair<std::string, uint32_t>, llvm::DISubprogram*> inlined; // by name and file
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
    // Calls by number, in the function that has their code.
    std::map<std::pair<llvm::DISubprogram*, uint32_t>, InlinedScope> inlinedScopes_;
    std::map<std::tuple<llvm::DISubprogram*, std::string, uint32_t>, llvm::DILocalVariable*>
        inlinedVariables_;
};

// The debug information of one function under translation: which scopes are open, where its
// variables are.
class FunctionDebug {
public:
    FunctionDebug(DebugInfo& info, const ptx::Module& module, const ptx::Function& source,
                  llvm::Function& function);

    // Sets the builder's location for what an instruction becomes, which stands on a line of the PTX
    // text (0: on none).
    void setLocation(llvm::IRBuilder<>& builder, const ptx::SourcePosition& source,
                     uint32_t textLine);
    // A variable of the function's PTX and the memory it got.
    void atMemory(std::string_view name, llvm::Value* memory, llvm::BasicBlock* block);
    // At a label; returns the registers (by index) that variables now live in.
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
    // Where code belongs: a function or block, and the call that inlined it, if one did.
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

// See above. For functions that have debug records of variables.
void pinVariables(Unit& unit);

} // namespace sunstone::compiler
