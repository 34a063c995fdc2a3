// SPDX-License-Identifier: Apache-2.0
// See opcode.h.
#include "ptx/opcodes/opcode.h"

#include "base/error.h"
#include "ptx/opcodes/instruction_table.h"
#include "ptx/opcodes/opcode_table.h"

namespace sunstone::ptx {

constinit const Opcode kUnknownOpcode;

OpcodeTable::OpcodeTable(std::span<const OpcodeText> rows, std::span<const FormText> forms) {
    std::unordered_map<std::string_view, Opcode*> places;
    for (const OpcodeText& row : rows)
        for (const std::string_view name : split(row.opcodes, '|')) {
            Opcode& opcode = opcodes_.emplace_back();
            opcode.name = name;
            opcode.operation = row.operation;
            opcode.native = row.native;
            opcode.age = row.age;
            opcode.lockstep = row.lockstep;
            opcode.syntax = row.syntax;
            opcode.flags = row.flags;
            places[name] = &opcode;
        }
    for (const FormText& text : forms)
        for (const std::string_view name : split(text.opcodes, '|')) {
            const auto found = places.find(name);
            if (found == places.end())
                fail(Code::kInternal, "the table of opcodes has no row for \"", name, "\"");
            Opcode& opcode = *found->second;
            const Form& form = opcode.forms.emplace_back(readForm(text));
            opcode.hasResult |= !form.operands.empty() && form.operands[0].destination;
        }
    index_.insert(places.begin(), places.end());
}

const OpcodeTable& opcodeTable() {
    static const OpcodeTable& table = *new OpcodeTable(opcodeRows(), formRows());
    return table;
}

std::span<const OpcodeText> opcodeRows() {
    return kOpcodeTexts;
}

std::span<const FormText> formRows() {
    return kFormTexts;
}

} // namespace sunstone::ptx
