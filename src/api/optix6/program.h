// SPDX-License-Identifier: Apache-2.0
// Programs and the code behind them. Programs with the same text and name share one ProgramCode,
// and those with the same text one module.
#pragma once

#include "api/optix6/variable.h"
#include "compiler/optix6/variables.h"
#include "engine/pipeline.h"

#include <map>

namespace sunstone::optix6 {

struct ProgramCode {
    std::shared_ptr<const engine::Module> module;
    std::shared_ptr<const std::string> text; // of the module
    std::string function;                    // symbol in the PTX
    std::string name;                        // in the source
    bool isEntry = false;
    unsigned parameters = 0;
    compiler::optix6::ProgramVariables variables;
};

struct ModuleText {
    std::shared_ptr<engine::Module> module;
    std::shared_ptr<const std::string> text;
    std::map<std::string, std::shared_ptr<ProgramCode>> programs; // by symbol
};

class Program : public Scoped {
public:
    static constexpr Kind kKind = Kind::kProgram;
    Program(const std::shared_ptr<Context>& context, std::shared_ptr<ProgramCode> code_)
        : Scoped(kKind, context), code(std::move(code_)) {}
    const std::shared_ptr<ProgramCode> code;
    int id = 0; // 0: not requested yet
};

// Throws RT_ERROR_TYPE_MISMATCH if a program cannot have this kind.
void checkKind(const Program& program, compiler::ProgramKind kind, const char* parameter);

} // namespace sunstone::optix6
