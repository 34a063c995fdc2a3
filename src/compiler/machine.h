// SPDX-License-Identifier: Apache-2.0
// LLVM IR to machine code in memory, for the processor we run on, in two steps: `generate` makes an
// object file, which may be kept and loaded again by any process with the same build; `loadObject`
// gives it addresses. One linking session per process; target machines are kept and lent out,
// since making one costs more than a small program.
#pragma once

#include "compiler/store/code_object.h"
#include "compiler/translate/unit.h"

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

// Processor and features that code is generated for, as text.
const std::string& targetDescription();

// Loaded code; its memory goes with it.
class LoadedCode {
public:
    virtual ~LoadedCode() = default;
    // Null if there is no such symbol.
    virtual void* address(const std::string& name) const = 0;
};

// The object file of a finished unit and the frame size of each of its functions.
CodeObject generate(Unit& unit, LentMachine& machine);

// Links `object` against the run-time and `externals` (symbol, address) and looks `symbols` up.
std::unique_ptr<LoadedCode> loadObject(const CodeObject& object,
                                       const std::vector<std::string>& symbols,
                                       const std::vector<std::pair<std::string, void*>>& externals);

} // namespace sunstone::compiler
