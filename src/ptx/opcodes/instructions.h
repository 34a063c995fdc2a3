// SPDX-License-Identifier: Apache-2.0
// The forms of instructions: the modifiers, types and operands that each takes. Their table is
// instruction_table.h; opcode.h has the forms of an opcode. Source: PTX ISA manual, and ptxas for
// forms that the manual does not define.
//
// The order of modifiers is not checked, because several orders are in use. Types are checked only
// by width: a 32-bit register serves every 32-bit type, regardless of its declaration.
#pragma once

#include "ptx/ast.h"

#include <string>
#include <string_view>
#include <vector>

namespace sunstone::ptx {

enum class OperandRuleKind : uint8_t {
    kTyped, // value of types[type]; of .vN instructions a vector of such values if vectorised
    kWide,  // value of twice the width of types[0]
    kFixed, // integer value of `bytes` bytes
    kPredicate,
    kAddress,
    kTexture, // [texture, coordinates]
    kLabel,
    kTargets,  // name of a .branchtargets list
    kConstant, // integer literal
    kMove,     // operand of mov: scalar, vector, symbol
    kAny,
};

struct OperandRule {
    OperandRuleKind kind = OperandRuleKind::kAny;
    uint8_t type = 0;
    uint8_t bytes = 0;
    bool destination = false;
    bool optional = false;
    bool wider = false; // registers may be wider than the type
    bool vectorised = false;
    bool predicateToo = false; // destination may be value|predicate
    bool pair = false;         // destination may be predicate|predicate
    bool sink = false;         // destination may be _
    bool symbol = false;       // source may be a symbol's address
};

struct ModifierGroup {
    std::vector<std::string_view> choices; // one of these
    bool optional = false;
};

struct Form {
    std::vector<ModifierGroup> groups;
    std::vector<uint32_t> types; // bits, one per Type: the types allowed at each position
    std::vector<OperandRule> operands;
    bool loose = false; // any modifiers and operands: the back end decides
    size_t minimumOperands = 0;
};

// A row of instruction_table.h as a form.
struct FormText;
Form readForm(const FormText& text);

// The non-empty pieces between separators.
std::vector<std::string_view> split(std::string_view text, char separator);

// Whether the modifiers of `instruction` fit `form`. If not, *problem has the reason. Among the
// problems of several forms, the one with the highest rank is the most specific.
struct FormProblem {
    enum Rank : uint8_t { kNone, kUnknownModifier, kWrongType, kConflict, kMissing };
    Rank rank = kNone;
    std::string text;
};
bool matches(const Form& form, const Instruction& instruction, FormProblem* problem);

} // namespace sunstone::ptx
