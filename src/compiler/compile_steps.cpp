// SPDX-License-Identifier: Apache-2.0
// See compile_steps.h.
#include "compiler/compile_steps.h"

#include <llvm/IR/Verifier.h>

namespace sunstone::compiler {

void StepTimes::step(const char* name) {
    const auto now = Clock::now();
    text_ += message(" ", name, " ",
                     std::chrono::duration<double, std::milli>(now - last_).count(), " ms");
    last_ = now;
}

StepTimes::~StepTimes() {
    if (logEnabled(LogLevel::kDebug, "compiler"))
        log(LogLevel::kDebug, "compiler", "compiled " + text_);
}

void verify(Unit& unit, const char* step) {
    std::string text;
    llvm::raw_string_ostream stream(text);
    if (llvm::verifyModule(unit.module(), &stream))
        fail(ErrorCode::kInternal, "faulty intermediate code after ", step, ": ", text);
}

void prepare(Unit& unit, LentMachine& machine) {
    unit.module().setDataLayout(machine->createDataLayout());
    unit.module().setTargetTriple(machine->getTargetTriple().str());
}

void VariableTable::add(const std::vector<const ptx::Module*>& modules, const VariableId& id,
                        void* address) {
    if (id.function != VariableId::kModuleScope)
        return;
    const ptx::Variable& variable = modules[id.module]->variables[id.index];
    entries_.try_emplace(std::string(variable.name), Entry{address, variable.size});
}

bool VariableTable::find(std::string_view name, void** address, uint64_t* size) const {
    const auto found = entries_.find(name);
    if (found == entries_.end())
        return false;
    if (address)
        *address = found->second.address;
    if (size)
        *size = found->second.size;
    return true;
}

} // namespace sunstone::compiler
