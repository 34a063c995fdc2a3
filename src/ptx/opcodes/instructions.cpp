// SPDX-License-Identifier: Apache-2.0
// Reads rows of instruction_table.h as forms, and matches instructions against them.
#include "ptx/opcodes/instructions.h"

#include "ptx/opcodes/instruction_table.h"

#include <algorithm>

namespace sunstone::ptx {

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    while (!text.empty()) {
        const size_t end = std::min(text.find(separator), text.size());
        if (end != 0)
            parts.push_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return parts;
}

namespace {

ModifierGroup readGroup(std::string_view text) {
    ModifierGroup group;
    if (text.back() == '?') {
        group.optional = true;
        text.remove_suffix(1);
    }
    group.choices = split(text, '|');
    return group;
}

uint32_t readTypes(std::string_view text) {
    uint32_t set = 0;
    for (const std::string_view name : split(text, '|')) {
        Type type = Type::kNone;
        if (typeFromName(name, type))
            set |= 1u << static_cast<unsigned>(type);
    }
    return set;
}

void readKind(char c, OperandRule& rule) {
    const auto fixed = [&](uint8_t bytes) {
        rule.kind = OperandRuleKind::kFixed;
        rule.bytes = bytes;
    };
    switch (c) {
    case '0':
    case '1':
    case '2':
        rule.kind = OperandRuleKind::kTyped;
        rule.type = static_cast<uint8_t>(c - '0');
        return;
    case 'W':
        rule.kind = OperandRuleKind::kWide;
        return;
    case 'h':
        return fixed(2);
    case 'r':
        return fixed(4);
    case 'd':
        return fixed(8);
    case 'P':
        rule.pair = true;
        [[fallthrough]];
    case 'p':
        rule.kind = OperandRuleKind::kPredicate;
        return;
    case 'a':
        rule.kind = OperandRuleKind::kAddress;
        return;
    case 't':
        rule.kind = OperandRuleKind::kTexture;
        return;
    case 'l':
        rule.kind = OperandRuleKind::kLabel;
        return;
    case 'b':
        rule.kind = OperandRuleKind::kTargets;
        return;
    case 'c':
        rule.kind = OperandRuleKind::kConstant;
        return;
    case 'm':
        rule.kind = OperandRuleKind::kMove;
        return;
    default:
        rule.kind = OperandRuleKind::kAny;
    }
}

// See the legend in instruction_table.h.
OperandRule readOperand(std::string_view text) {
    OperandRule rule;
    if (text[0] == '=') {
        rule.destination = true;
        text.remove_prefix(1);
    }
    if (text[0] == 'v') {
        rule.vectorised = true;
        text.remove_prefix(1);
    }
    readKind(text[0], rule);
    for (const char c : text.substr(1)) {
        rule.optional |= c == '?';
        rule.wider |= c == '+';
        rule.predicateToo |= c == '|';
        rule.sink |= c == '_';
        rule.symbol |= c == '&';
    }
    return rule;
}

bool contains(const ModifierGroup& group, std::string_view modifier) {
    return std::find(group.choices.begin(), group.choices.end(), modifier) != group.choices.end();
}

std::string choicesOf(const ModifierGroup& group) {
    std::string text = group.choices.size() > 1 ? "one of " : "";
    for (size_t i = 0; i < group.choices.size(); ++i)
        text += (i ? ", ." : ".") + std::string(group.choices[i]);
    return text;
}

std::string typesOf(uint32_t set) {
    std::string text;
    for (unsigned i = 0; i < 32; ++i)
        if (set >> i & 1)
            text += (text.empty() ? "." : ", .") + std::string(nameOf(static_cast<Type>(i)));
    return text;
}

bool report(FormProblem* problem, FormProblem::Rank rank, const auto& text) {
    if (problem && problem->rank < rank) {
        problem->rank = rank;
        problem->text = text();
    }
    return false;
}

} // namespace

Form readForm(const FormText& text) {
    Form form;
    form.loose = std::string_view(text.modifiers) == "*";
    if (!form.loose)
        for (const std::string_view group : split(text.modifiers, ' '))
            form.groups.push_back(readGroup(group));
    for (const std::string_view types : split(text.types, ' '))
        form.types.push_back(readTypes(types));
    for (const std::string_view operand : split(text.operands, ' ')) {
        form.operands.push_back(readOperand(operand));
        form.minimumOperands += !form.operands.back().optional;
    }
    return form;
}

bool matches(const Form& form, const Instruction& instruction, FormProblem* problem) {
    if (form.loose)
        return true;
    uint64_t used = 0; // groups that have their modifier
    size_t types = 0;
    for (const std::string_view modifier : instruction.modifiers) {
        const std::string shown = "'." + std::string(modifier) + "'";
        size_t group = 0;
        while (group < form.groups.size() &&
               (used >> group & 1 || !contains(form.groups[group], modifier)))
            ++group;
        if (group < form.groups.size()) {
            used |= uint64_t(1) << group;
            continue;
        }
        Type type = Type::kNone;
        if (typeFromName(modifier, type)) {
            if (types >= form.types.size())
                return report(problem, FormProblem::kWrongType,
                              [&] { return "takes no type " + shown + " here"; });
            if (!(form.types[types] >> static_cast<unsigned>(type) & 1))
                return report(problem, FormProblem::kWrongType, [&] {
                    return "does not take type " + shown + " here; it takes " +
                           typesOf(form.types[types]);
                });
            ++types;
            continue;
        }
        const bool known = std::any_of(form.groups.begin(), form.groups.end(),
                                       [&](const auto& g) { return contains(g, modifier); });
        return report(problem, known ? FormProblem::kConflict : FormProblem::kUnknownModifier, [&] {
            return known ? "has modifier " + shown + " next to another that excludes it"
                         : "does not take modifier " + shown + " with its other modifiers";
        });
    }
    if (types < form.types.size())
        return report(problem, FormProblem::kMissing, [&] {
            return "lacks a type" + std::string(types ? " in second place" : "") + ": one of " +
                   typesOf(form.types[types]);
        });
    for (size_t i = 0; i < form.groups.size(); ++i)
        if (!form.groups[i].optional && !(used >> i & 1))
            return report(problem, FormProblem::kMissing,
                          [&] { return "lacks a modifier: " + choicesOf(form.groups[i]); });
    return true;
}

} // namespace sunstone::ptx
