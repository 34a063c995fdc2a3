// SPDX-License-Identifier: Apache-2.0
// The table of opcodes: every row is complete. tests/gpu/opcode_row_test.cpp tests the effects of a
// row.
#include "ptx/opcodes/opcode.h"

#include "base/error.h"
#include "ptx/opcodes/instruction_table.h"
#include "ptx/test_support.h"

#include <set>

namespace sunstone::ptx::testing {
namespace {

TEST(Opcodes, EveryFormIsSound) {
    std::set<std::string_view> seen;
    for (const Opcode& opcode : opcodeTable().all()) {
        EXPECT_TRUE(seen.insert(opcode.name).second) << opcode.name;
        EXPECT_FALSE(opcode.forms.empty()) << opcode.name;
        EXPECT_EQ(&opcodeTable().find(opcode.name), &opcode);
        for (const Form& form : opcode.forms) {
            EXPECT_LE(form.groups.size(), 64u) << opcode.name;
            for (const ModifierGroup& group : form.groups)
                EXPECT_FALSE(group.choices.empty()) << opcode.name;
            for (const uint32_t types : form.types)
                EXPECT_NE(types, 0u) << opcode.name;
            for (const OperandRule& rule : form.operands) {
                if (rule.kind == OperandRuleKind::kTyped) {
                    EXPECT_LT(rule.type, form.types.size()) << opcode.name;
                }
                if (rule.kind == OperandRuleKind::kWide) {
                    EXPECT_FALSE(form.types.empty()) << opcode.name;
                }
            }
        }
    }
}

// An operation treats the first operand either as a result or as a source.
TEST(Opcodes, TheFormsOfAnOpcodeAgreeOnItsResult) {
    for (const Opcode& opcode : opcodeTable().all()) {
        if (opcode.native == Native::kWarpSync || opcode.native == Native::kEffects)
            continue; // objects have forms of both kinds
        for (const Form& form : opcode.forms)
            EXPECT_EQ(!form.operands.empty() && form.operands[0].destination, opcode.hasResult)
                << opcode.name;
    }
}

TEST(Opcodes, UnknownNamesHaveNoFacts) {
    for (const char* name : {"nothing", "", "ad", "addd", "add|sub"}) {
        EXPECT_EQ(&opcodeTable().find(name), &kUnknownOpcode) << name;
    }
    EXPECT_EQ(Instruction().facts, &kUnknownOpcode);
    EXPECT_TRUE(kUnknownOpcode.forms.empty());
}

TEST(Opcodes, AFormNeedsARow) {
    const FormText form[] = {{"add|nothing", "", "u32", "=0 0 0"}};
    EXPECT_THROW(OpcodeTable(opcodeRows(), form), Error);
}

} // namespace
} // namespace sunstone::ptx::testing
