// SPDX-License-Identifier: Apache-2.0
// A compiled piece of a pipeline before it has an address: one program, or the variables of all.
// Pieces are compiled in parallel, stored by tasks and in the disk cache, and linked by
// compilePipeline. A piece refers to run-time functions by name and to variables by VariableId. No
// LLVM here. Read next: compiler/piece.h.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace sunstone::compiler {

// A variable by its position in the trees: module in the unit's list, then module scope or
// function.
struct VariableId {
    static constexpr uint32_t kModuleScope = ~0u;
    uint32_t module = 0;
    uint32_t function = kModuleScope;
    uint32_t index = 0;
    auto operator<=>(const VariableId&) const = default;

    std::string symbol() const; // its name in object code
};

struct CodeObject {
    std::string code;                           // relocatable ELF
    std::map<std::string, uint32_t> stackSizes; // frame of each function, by symbol
    std::vector<VariableId> variables;          // referred to, or defined by the piece of variables
    uint32_t stackNeed = 0;                     // bytes of the program with all it calls by name
    std::vector<uint32_t> boundLoads;           // loads that were replaced by each bound value

    bool forDebugger = false;                   // registered with gdb

    // Serialises all fields, and back; false for malformed bytes.
    std::string serialize() const;
    bool deserialize(std::string_view bytes);
};

} // namespace sunstone::compiler
