// SPDX-License-Identifier: Apache-2.0
// The variables of classic programs. rtDeclareVariable leaves a `.global` variable and, beside it,
// variables in namespaces rti_internal_* that hold its type, its semantic and its annotation. A
// program has no memory of its own for these variables: those with a semantic stand for program
// state, the others for a slot of the program's variable block, which the shell fills by the rules
// of scopes. Buffers leave no description: they are one byte without an initialiser.
//
// Layouts depend only on the PTX, so that the compiler and the shell agree. Source: OptiX 6.0 API
// reference, sections 5.22 and 8.14. No LLVM here.
#pragma once

#include "ptx/ast.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sunstone::compiler::optix6 {

enum class VariableUse : uint8_t {
    kNone,    // ordinary device memory
    kValue,   // found through scopes: plain data, graph nodes, program ids
    kBuffer,  // found through scopes: the slot holds a devlib::BufferView
    kTexture, // found through scopes: the slot holds a texture handle
    kLaunchIndex,
    kLaunchDim,
    kRay,
    kDistance,
    kPayload,
    kTime,
    kSubframe,
    kAttribute,
};

// Values of the variables in rti_internal_typeenum.
enum TypeEnum : uint32_t {
    kTypePlain = 0x1337,
    kTypeProgramId = 0x1338,
    kTypeBoundProgram = 0x1339
};

struct DeviceVariable {
    VariableUse use = VariableUse::kNone;
    std::string_view symbol; // in the PTX
    std::string name;        // in the source: "color", "space::color"
    std::string attribute;   // name that hit programs and intersection programs share
    std::string annotation;
    std::string typeName;
    uint32_t typeEnum = kTypePlain;
    uint32_t bytes = 0;
    uint32_t slot = 0; // offset in the program's block, of those found through scopes
    // Size of a buffer's elements and number of its indices in the program's accesses; 0: unknown.
    uint32_t elementBytes = 0, dimensions = 0;
    const ptx::Variable* declaration = nullptr;
    bool isScoped() const {
        return use == VariableUse::kValue || use == VariableUse::kBuffer ||
               use == VariableUse::kTexture;
    }
};

// Describes the variable by the module's declarations. Leaves `slot` unset.
DeviceVariable describe(const ptx::Module& module, const ptx::Variable& variable);

struct ProgramVariables {
    std::vector<DeviceVariable> list; // those that the program's call graph names, but kNone
    uint32_t blockBytes = 0;
    bool callsPrograms = false;   // callable programs, by id or through variables
    bool recurses = false;        // a function of the call graph calls itself, or one that calls it
    bool readsAttributes() const; // its own code does
    const DeviceVariable* find(std::string_view symbol) const;
};

// The variables of a program and of all functions that it may call; the modules are linked.
ProgramVariables variablesOf(const std::vector<const ptx::Module*>& modules,
                             std::string_view function);

// Names of all attributes that the module declares, with their bytes.
struct AttributeDeclaration {
    std::string name;
    uint32_t bytes = 0;
};
std::vector<AttributeDeclaration> attributesOf(const ptx::Module& module);

// A function's name in its source, without parameters; the symbol itself where it is not mangled.
std::string sourceName(std::string_view symbol);

} // namespace sunstone::compiler::optix6
