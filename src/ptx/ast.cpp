// SPDX-License-Identifier: Apache-2.0
// Type names and sizes, and look-ups in the tree. See ast.h.
#include "ptx/ast.h"

#include <array>

namespace sunstone::ptx {
namespace {

struct TypeInfo {
    const char* name;
    unsigned size;
};

constexpr std::array<TypeInfo, 24> kTypes = {{
    {"none", 0},   {"pred", 1}, {"b8", 1},  {"b16", 2},    {"b32", 4},        {"b64", 8},
    {"b128", 16},  {"u8", 1},   {"u16", 2}, {"u32", 4},    {"u64", 8},        {"s8", 1},
    {"s16", 2},    {"s32", 4},  {"s64", 8}, {"f16", 2},    {"f16x2", 4},      {"bf16", 2},
    {"bf16x2", 4}, {"f32", 4},  {"f64", 8}, {"texref", 8}, {"samplerref", 8}, {"surfref", 8},
}};
static_assert(kTypes.size() == static_cast<size_t>(Type::kSurfref) + 1);

bool integerFromName(std::string_view name, Type b8, Type& type) {
    const std::string_view digits = name.substr(1);
    int step = -1;
    if (digits == "8")
        step = 0;
    else if (digits == "16")
        step = 1;
    else if (digits == "32")
        step = 2;
    else if (digits == "64")
        step = 3;
    else if (digits == "128" && b8 == Type::kB8)
        step = 4;
    if (step < 0)
        return false;
    type = static_cast<Type>(static_cast<int>(b8) + step);
    return true;
}

bool set(Type value, Type& type) {
    type = value;
    return true;
}

} // namespace

unsigned sizeOf(Type type) {
    return kTypes[static_cast<size_t>(type)].size;
}

const char* nameOf(Type type) {
    return kTypes[static_cast<size_t>(type)].name;
}

// The first letter selects the comparisons, because the parser calls this for every modifier.
bool typeFromName(std::string_view name, Type& type) {
    if (name.size() < 2)
        return false;
    switch (name[0]) {
    case 'u':
        return integerFromName(name, Type::kU8, type);
    case 's':
        if (name == "samplerref")
            return set(Type::kSamplerref, type);
        if (name == "surfref")
            return set(Type::kSurfref, type);
        return integerFromName(name, Type::kS8, type);
    case 'b':
        if (name == "bf16")
            return set(Type::kBF16, type);
        if (name == "bf16x2")
            return set(Type::kBF16x2, type);
        return integerFromName(name, Type::kB8, type);
    case 'f':
        if (name == "f32")
            return set(Type::kF32, type);
        if (name == "f64")
            return set(Type::kF64, type);
        if (name == "f16")
            return set(Type::kF16, type);
        return name == "f16x2" && set(Type::kF16x2, type);
    case 'p':
        return name == "pred" && set(Type::kPred, type);
    case 't':
        return name == "texref" && set(Type::kTexref, type);
    default:
        return false;
    }
}

std::string Instruction::fullOpcode() const {
    std::string text(opcode);
    for (std::string_view modifier : modifiers) {
        text += '.';
        text += modifier;
    }
    return text;
}

const Function* Module::findFunction(std::string_view name) const {
    if (!functionIndex.empty()) {
        const auto found = functionIndex.find(name);
        return found == functionIndex.end() ? nullptr : &functions[found->second];
    }
    const Function* declaration = nullptr;
    for (const Function& function : functions) {
        if (function.name != name)
            continue;
        if (function.hasBody)
            return &function;
        if (!declaration)
            declaration = &function;
    }
    return declaration;
}

const Variable* Module::findVariable(std::string_view name) const {
    if (!variableIndex.empty()) {
        const auto found = variableIndex.find(name);
        return found == variableIndex.end() ? nullptr : &variables[found->second];
    }
    const Variable* declaration = nullptr;
    for (const Variable& variable : variables) {
        if (variable.name != name)
            continue;
        if (variable.linkage != Linkage::kExtern)
            return &variable;
        if (!declaration)
            declaration = &variable;
    }
    return declaration;
}

} // namespace sunstone::ptx
