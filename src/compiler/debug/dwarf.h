// SPDX-License-Identifier: Apache-2.0
// Variables of functions, read from the debug sections of a PTX module. Compilers write DWARF 2
// (clang -g, nvcc -G) as data directives whose addresses are labels and depots of the PTX:
//
//   location of a variable in memory: DW_OP_addr <depot>, DW_OP_plus_uconst <offset>
//   in a register: DW_OP_regx, whose operand holds the characters of the register's name
//   in changing places: a list in .debug_loc with labels as bounds
//
// Inlined functions are scopes with a function of their own (clang, nvcc -G; nvcc -lineinfo writes
// them in .loc instead, with names in .debug_str). Unreadable entries are left out: debug
// information never fails a compilation. No LLVM here. Source: DWARF 2 specification; "PTX Writer's
// Guide to Interoperability", debug information.
#pragma once

#include "ptx/ast.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sunstone::compiler {

struct DwarfType {
    enum class Kind : uint8_t {
        kNone, // void, or not understood
        kBase,
        kPointer,
        kReference,
        kStruct,
        kArray,
        kTypedef,
        kConst,
        kVolatile,
        kEnum,
    };
    struct Member {
        std::string name;
        uint32_t type = 0;   // key in DwarfInfo::types
        uint64_t offset = 0; // bytes
    };
    Kind kind = Kind::kNone;
    std::string name;
    uint64_t size = 0;     // bytes; 0: the size of the aliased type
    uint32_t encoding = 0; // DW_ATE_* of a base type
    uint32_t of = 0;       // pointed to, element, aliased; key in DwarfInfo::types, 0: void
    uint64_t count = 0;    // elements of an array
    std::vector<Member> members;
    std::vector<std::pair<std::string, int64_t>> enumerators;
};

struct DwarfPlace {
    std::string begin, end; // labels; empty: all of the function
    bool isRegister = false;
    std::string name; // of the register, or of the variable that holds this one
    uint64_t offset = 0;
};

struct DwarfVariable {
    std::string name;
    uint32_t line = 0, file = 0;
    uint32_t origin = 0; // identifies a variable of an inlined function; 0: unknown
    uint32_t type = 0;
    bool isParameter = false;
    std::vector<DwarfPlace> places;
};

// An inlined call: the function, and the place of the call.
struct DwarfInlined {
    std::string name; // in the source
    uint32_t line = 0, file = 0;
    uint32_t origin = 0; // identifies the function; 0: unknown
    uint32_t callLine = 0, callFile = 0, callColumn = 0;
};

struct DwarfScope {
    // Labels at its start and end, perhaps several pairs; none for the function itself.
    std::vector<std::pair<std::string, std::string>> ranges;
    std::optional<DwarfInlined> inlined; // none: a block
    std::vector<DwarfVariable> variables;
    std::vector<DwarfScope> scopes;
};

struct DwarfFunction {
    std::string name; // in the source
    uint32_t line = 0, file = 0;
    DwarfScope scope;
};

struct DwarfInfo {
    std::map<std::string, DwarfFunction> functions; // by symbol
    std::map<std::string, DwarfVariable> globals;   // by symbol
    std::map<uint32_t, DwarfType> types;
};

DwarfInfo readDwarf(const ptx::Module& module);

// The string in .debug_str at a label; empty if the label has none.
std::string debugString(const ptx::Module& module, std::string_view label, uint64_t offset);

} // namespace sunstone::compiler
