// SPDX-License-Identifier: Apache-2.0
// LLVM IR to machine code in memory, for the host processor, in two steps. `generate` makes an
// object file, which any process with the same build can store and load. `loadObject` links it in
// memory. There is one linking session per process. Target machines are pooled, because creating
// one takes longer than compiling a small program.
#pragma once

#include "compiler/store/code_object.h"
#include "compiler/translate/unit.h"

#include <llvm/Target/TargetMachine.h>

namespace sunstone::compiler {

// A target machine, borrowed for one compilation.
class LentMachine {
public:
    explicit LentMachine(OptLevel level);
    ~LentMachine();
    LentMachine(const LentMachine&) = delete;
    LentMachine& operator=(const LentMachine&) = delete;
    llvm::TargetMachine& operator*() { return *machine_; }
    llvm::TargetMachine* operator->() { return machine_.get(); }
    // Whether the processor has an fma instruction.
    bool hasFma() const;

private:
    std::unique_ptr<llvm::TargetMachine> machine_;
};

// The target processor and its features, as text.
const std::string& targetDescription();

// Loaded code; the destructor frees its memory.
class LoadedCode {
public:
    virtual ~LoadedCode() = default;
    // Null if the symbol does not exist.
    virtual void* address(const std::string& name) const = 0;
};

// Generates the object file of a finished unit, with the frame size of each of its functions.
CodeObject generate(Unit& unit, LentMachine& machine);

// Links `object` against the run-time and `externals` (symbol, address) and looks `symbols` up.
std::unique_ptr<LoadedCode> loadObject(const CodeObject& object,
                                       const std::vector<std::string>& symbols,
                                       const std::vector<std::pair<std::string, void*>>& externals);

} // namespace sunstone::compiler
