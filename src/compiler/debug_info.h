// SPDX-License-Identifier: Apache-2.0
// Debug information of compiled code, from what the PTX brings: .file and .loc give lines (debug
// level MINIMAL and up), the DWARF sections variables (level FULL).
//
// Variables. Their places in PTX are depots and registers, both of which are promoted to values
// soon after translation, as the compiler needs constants to show. LLVM keeps track of the values
// (debug records); when all is lowered, pinVariables gives each variable memory of its own and
// stores every value there, so that a debugger sees the variable at any stop of its scope.
#pragma once

#include "compiler/dwarf.h"
#include "compiler/unit.h"

#include <llvm/IR/DIBuilder.h>

#include <optional>

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
    llvm::DIBuilder& builder() { return builder_; }
    // Once, when all functions are translated.
    void finish();

private:
    struct ModuleInfo {
        std::map<uint32_t, llvm::DIFile*> files;
        std::map<uint32_t, llvm::DIType*> types;
        std::optional<DwarfInfo> dwarf;
    };
    const DwarfInfo& dwarf(const ptx::Module& module);
    llvm::DIType* makeType(const ptx::Module& module, uint32_t key, const DwarfType& type);

    Unit& unit_;
    llvm::DIBuilder builder_;
    llvm::DICompileUnit* compileUnit_ = nullptr;
    std::map<const ptx::Module*, ModuleInfo> modules_;
};

// The debug information of one function under translation: which scopes are open, where its
// variables are.
class FunctionDebug {
public:
    FunctionDebug(DebugInfo& info, const ptx::Module& module, const ptx::Function& source,
                  llvm::Function& function);

    // Sets the builder's location for what an instruction becomes.
    void setLocation(llvm::IRBuilder<>& builder, const ptx::SourcePosition& source);
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
    void addScope(const DwarfScope& scope, llvm::DILocalScope* parent, unsigned& parameters);

    DebugInfo& info_;
    const ptx::Module& module_;
    llvm::DISubprogram* subprogram_ = nullptr;
    std::map<std::string, std::vector<llvm::DILexicalBlock*>, std::less<>> begins_, ends_;
    std::vector<llvm::DILocalScope*> open_;
    std::vector<Variable> variables_;
    std::map<std::string, uint32_t, std::less<>> registers_; // by full name
};

// See above. For functions that have debug records of variables.
void pinVariables(Unit& unit);

} // namespace sunstone::compiler
