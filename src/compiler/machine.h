// SPDX-License-Identifier: Apache-2.0
// LLVM IR to machine code in memory, for the processor we run on. One linking session per process;
// target machines are kept and lent out, since making one costs more than a small program.
#pragma once

#include "compiler/unit.h"

#include <llvm/Target/TargetMachine.h>

namespace sunstone::compiler {

// A target machine for the time of one compilation.
class LentMachine {
public:
    explicit LentMachine(OptLevel level);
    ~LentMachine();
    LentMachine(const LentMachine&) = delete;
    LentMachine& operator=(const LentMachine&) = delete;
    llvm::TargetMachine& operator*() { return *machine_; }
    llvm::TargetMachine* operator->() { return machine_.get(); }
    // Whether fma is an instruction.
    bool hasFma() const;

private:
    std::unique_ptr<llvm::TargetMachine> machine_;
};

// Loaded code; its memory goes with it.
class LoadedCode {
public:
    virtual ~LoadedCode() = default;
    // Null if there is no such symbol.
    virtual void* address(const std::string& name) const = 0;
    // Frame size of a function, 0 if unknown or empty.
    virtual unsigned stackSize(const std::string& name) const = 0;
};

// Generates and links; takes `symbols` (functions and variables) to be looked up.
std::unique_ptr<LoadedCode> loadModule(Unit& unit, LentMachine& machine,
                                       const std::vector<std::string>& symbols);

} // namespace sunstone::compiler
