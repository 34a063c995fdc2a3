// SPDX-License-Identifier: Apache-2.0
// Helpers of the PTX tests: from text to a tree or a message.
#pragma once

#include "ptx/parse/parser.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace sunstone::ptx::testing {

inline const std::string kHeader = ".version 7.4\n.target sm_75\n.address_size 64\n";

// A whole module must parse.
inline std::unique_ptr<Module> mustParse(const std::string& text) {
    Diagnostics diagnostics;
    auto module = parse(text, diagnostics);
    EXPECT_TRUE(module) << diagnostics.format() << "in:\n" << text;
    EXPECT_EQ(module == nullptr, diagnostics.failed());
    return module ? std::move(module) : std::make_unique<Module>();
}

// Items of a module, header added.
inline std::unique_ptr<Module> mustParseItems(const std::string& items) {
    return mustParse(kHeader + items);
}

// Registers and variables of the instruction tests, in one line: text after it begins on line 5 of
// the module.
inline const std::string kKernelHead =
    ".global .align 16 .u32 numbers[10]; .const .b8 bytes[16]; .shared .b8 tile[64]; "
    ".global .texref picture; .func (.param .b32 r) callee (.param .b64 a, .param .b32 b); "
    ".visible .entry kernel(.param .u64 p, .param .u32 n) { "
    ".reg .pred %p<9>; .reg .b8 %b<9>; .reg .b16 %h<9>; .reg .b32 %r<99>; .reg .b64 %rd<99>; "
    ".reg .f32 %f<99>; .reg .f64 %d<9>; .reg .v4 .f32 %v<3>; .reg .v2 .b32 %w; .local .b8 "
    "stack[32];\n";

inline std::string kernel(const std::string& body) {
    return kHeader + kKernelHead + body + "\n}\n";
}

inline std::unique_ptr<Module> mustParseBody(const std::string& body) {
    return mustParse(kernel(body));
}

// The function `kernel` of mustParseBody.
inline const Function& kernelOf(const Module& module) {
    const Function* function = module.findFunction("kernel");
    static const Function none;
    EXPECT_TRUE(function);
    return function ? *function : none;
}

// The last instruction of a body, and its function.
struct Parsed {
    std::unique_ptr<Module> module;
    Function const* function = nullptr;
    Instruction instruction;
};
inline Parsed lastInstruction(const std::string& body) {
    Parsed parsed;
    parsed.module = mustParseBody(body);
    parsed.function = &kernelOf(*parsed.module);
    if (!parsed.function->body.empty())
        parsed.instruction = parsed.function->body.back().instruction;
    return parsed;
}

// The first error of a text as "line:column: message"; "" without errors.
inline std::string errorOf(const std::string& text) {
    Diagnostics diagnostics;
    const auto module = parse(text, diagnostics);
    EXPECT_EQ(module == nullptr, diagnostics.failed());
    for (const Diagnostic& diagnostic : diagnostics.all())
        if (diagnostic.severity == Severity::kError)
            return std::to_string(diagnostic.location.line) + ":" +
                   std::to_string(diagnostic.location.column) + ": " + diagnostic.text;
    return "";
}
inline std::string errorOfItems(const std::string& items) {
    return errorOf(kHeader + items);
}
inline std::string errorOfBody(const std::string& body) {
    return errorOf(kernel(body));
}

inline std::string nameOf(const Function& function, uint32_t reg) {
    if (reg >= function.registers.size())
        return "?";
    std::string name(function.registers[reg].name);
    if (function.registers[reg].number != ~0u)
        name += std::to_string(function.registers[reg].number);
    return name;
}

} // namespace sunstone::ptx::testing
