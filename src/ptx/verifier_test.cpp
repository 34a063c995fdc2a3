// SPDX-License-Identifier: Apache-2.0
// Accepted and refused instruction forms, and the messages.
#include "ptx/test_support.h"

#include "ptx/opcodes/special_registers.h"
#include "ptx/printer.h"

namespace sunstone::ptx::testing {
namespace {

TEST(Accepted, WidthsAgreeWhateverTheDeclaredType) {
    mustParseBody("add.f32 %f1, %r1, %f2;\nadd.s32 %r1, %f1, %r2;\nmov.b32 %f1, %r1;\n"
                  "mov.u64 %d1, %rd1;\nld.global.f32 %r1, [%rd1];\nadd.f16 %h1, %h2, %h3;\n"
                  "setp.lt.f32 %p1, %r1, %f2;\nshl.b64 %rd1, %rd1, %f1;");
}

TEST(Accepted, LoadsStoresAndConversionsTakeWiderRegisters) {
    mustParseBody("ld.global.u8 %rd2, [%rd1];\nld.u16 %r1, [%rd1];\nst.global.u8 [%rd1], %rd2;\n"
                  "ld.global.v2.u8 {%r1, %r2}, [%rd1];\nst.v4.u8 [%rd1], {%h1, %h2, %h3, %h4};\n"
                  "cvt.u8.u32 %r1, %r2;\ncvt.s64.s8 %rd1, %rd1;\ncvt.rn.f16.f32 %r1, %f1;\n"
                  "cvt.f32.f16 %f1, %r1;\nld.u8 %b1, [%rd1];");
}

TEST(Accepted, BothOrdersOfModifiers) {
    mustParseBody(
        "vote.sync.ballot.b32 %r1, %p1, -1;\nvote.ballot.sync.b32 %r1, %p1, -1;\n"
        "atom.add.relaxed.gpu.s32 %r1, [%rd1], 1;\natom.relaxed.gpu.global.add.u32 %r1, "
        "[%rd1], 1;\nld.volatile.shared.u32 %r1, [%r2];\nld.shared.volatile.u32 %r1, [%r2];");
}

TEST(Accepted, PacksAndVectors) {
    mustParseBody("mov.b64 %rd1, {%r1, %f1};\nmov.b64 {%r1, _}, %rd1;\nmov.b32 %r1, {%h1, %h2};\n"
                  "mov.b64 {%h1, %h2, %h3, %h4}, %d1;\nmov.b64 %rd1, {1, 2};\n"
                  "mov.v4.f32 {%f1,%f2,%f3,%f4}, {%f5,%f6,%f7,0f00000000};\nmov.v4.f32 %v1, %v2;\n"
                  "st.v4.f32 [%rd1], %v1;\nmov.b64 %rd1, %w;\nld.v2.b32 %w, [%rd1];");
}

TEST(Accepted, UndefinedRegistersAreLegal) {
    mustParseBody("add.u32 %r1, %r50, %r51;\n@%p7 mov.u32 %r2, %r52;");
}

TEST(Accepted, HardwareInstructionsAreNotChecked) {
    mustParseBody("mma.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 {%f1,%f2,%f3,%f4}, "
                  "{%r1,%r2,%r3,%r4}, {%r5,%r6}, {%f1,%f2,%f3,%f4};\n"
                  "cp.async.cg.shared.global.L2::128B [%r1], [%rd1], 16;\n"
                  "vadd.s32.u32.s32.sat %r1, %r2.b0, %r3.h1;\n"
                  "mbarrier.try_wait.shared::cta.b64 %p1, [%r1], %rd1;");
}

TEST(Accepted, WhatAJudgeKnows) {
    const std::string text = kernel("frob.b32 %r1, [numbers];\n@%p1 frob.b32 %r2, [tile+4];\n"
                                    "add.f32x9 %rd1, %rd2, %rd3;\nadd.f32 %f1, %f2, %f3;\n"
                                    "frob.b32 %r1, [numbers];");
    std::vector<std::string> asked;
    Diagnostics diagnostics;
    const auto module = parse(text, diagnostics, [&](const Module& each) {
        asked.push_back(print(each));
        return true;
    });
    ASSERT_TRUE(module) << diagnostics.format();
    EXPECT_EQ(asked.size(), 3u) << "once for each text";
    std::string foreign;
    for (const Statement& statement : kernelOf(*module).body)
        foreign += statement.instruction.isForeign ? 'f' : '.';
    EXPECT_EQ(foreign, "fff.f");
    mustParse(asked[0].substr(0, asked[0].find("frob")) + "}"); // a module with only that
                                                                // instruction
    Diagnostics refused;
    EXPECT_FALSE(parse(text, refused, [&](const Module& each) {
        return print(each).find("tile") != std::string::npos;
    }));
    EXPECT_EQ(refused.errorCount(), 3u) << refused.format();
}

struct Case {
    const char* text;
    const char* error; // without place, which is 5:1 unless `column`
    unsigned column = 1;
};

void check(const std::vector<Case>& cases) {
    for (const Case& c : cases)
        EXPECT_EQ(errorOfBody(c.text), "5:" + std::to_string(c.column) + ": " + c.error) << c.text;
}

TEST(Refused, OpcodesAndModifiers) {
    check({
        {"adds.u32 %r1, %r2, %r3;", "unknown instruction 'adds' (did you mean 'add'?)"},
        {"frobnicate;", "unknown instruction 'frobnicate'"},
        {"add.rnn.f32 %f1, %f2, %f3;",
         "'add.rnn.f32': unknown modifier '.rnn' for 'add' (did you mean '.rn'?)"},
        {"ld.globl.u32 %r1, [%rd1];",
         "'ld.globl.u32': unknown modifier '.globl' for 'ld' (did you mean '.global'?)"},
        {"add.u33 %r1, %r2, %r3;",
         "'add.u33': unknown modifier '.u33' for 'add' (did you mean '.u32'?)"},
        {"mov.rn.u32 %r1, %r2;", "'mov.rn.u32': unknown modifier '.rn' for 'mov'"},
        {"setp.foo.u32 %p1, %r1, %r2;", "'setp.foo.u32': unknown modifier '.foo' for 'setp'"},
        {"div.f32 %f1, %f2, %f3;", "'div.f32' lacks a modifier: one of .approx, .full"},
        {"cvt.u32.f32 %r1, %f1;", "'cvt.u32.f32' lacks a modifier: one of .rni, .rzi, .rmi, .rpi"},
        {"sin.f32 %f1, %f2;", "'sin.f32' lacks a modifier: .approx"},
        {"mul.s32 %r1, %r2, %r3;", "'mul.s32' lacks a modifier: one of .lo, .hi"},
        {"add %r1, %r2, %r3;", "'add' lacks a type: one of .u16, .u32, .u64, .s16, .s64"},
        {"cvt.u32 %r1, %r2;",
         "'cvt.u32' lacks a type in second place: one of .u8, .u16, .u32, .u64, .s8, .s16, .s32, "
         ".s64"},
        {"ret.foo;", "'ret.foo': unknown modifier '.foo' for 'ret'"},
    });
    EXPECT_NE(errorOfBody("add.rn.u32 %r1, %r2, %r3;"), "");
    EXPECT_NE(errorOfBody("add.rn.rz.f32 %f1, %f2, %f3;"), "");
    EXPECT_NE(errorOfBody("add.ftz.s32 %r1, %r2, %r3;"), "");
    EXPECT_NE(errorOfBody("setp.ltu.s32 %p1, %r1, %r2;"), "");
    EXPECT_NE(errorOfBody("setp.lo.s32 %p1, %r1, %r2;"), "");
    EXPECT_NE(errorOfBody("setp.lt.b32 %p1, %r1, %r2;"), "");
    EXPECT_NE(errorOfBody("and.u32 %r1, %r2, %r3;"), "");
    EXPECT_NE(errorOfBody("st.const.u32 [%rd1], %r1;"), "");
    EXPECT_NE(errorOfBody("mov.b8 %b1, %b2;"), "");
    EXPECT_NE(errorOfBody("atom.add.s64 %rd1, [%rd2], %rd3;"), "");
}

TEST(Refused, OperandCounts) {
    check({
        {"add.u32 %r1, %r2;", "'add.u32' takes 3 operands, not 2"},
        {"add.u32 %r1, %r2, %r3, %r4;", "'add.u32' takes 3 operands, not 4"},
        {"mov.b32 %r1;", "'mov.b32' takes 2 operands, not 1"},
        {"ret 5;", "'ret' takes 0 operands, not 1"},
        {"bar.sync;", "'bar.sync' takes 1 or 2 operands, not 0"},
        {"bar.red.popc.u32 %r1, 0;", "'bar.red.popc.u32' takes 3 or 4 operands, not 2"},
        {"shfl.sync.up.b32 %r1, %r2, 1, 0;", "'shfl.sync.up.b32' takes 5 operands, not 4"},
    });
}

TEST(Refused, Widths) {
    check({
        {"add.u32 %r1, %rd1, %r3;", "'add.u32': '%rd1' is 64-bit (.b64), this operand needs 32-bit",
         14},
        {"add.u32 %r1, %r2, %h3;", "'add.u32': '%h3' is 16-bit (.b16), this operand needs 32-bit",
         19},
        {"add.u64 %r1, %rd2, %rd3;", "'add.u64': '%r1' is 32-bit (.b32), this operand needs 64-bit",
         9},
        {"mul.wide.u32 %r1, %r2, %r3;",
         "'mul.wide.u32': '%r1' is 32-bit (.b32), this operand needs 64-bit", 14},
        {"mad.wide.u16 %r1, %h1, %h2, %h3;",
         "'mad.wide.u16': '%h3' is 16-bit (.b16), this operand needs 32-bit", 29},
        {"ld.u64 %r1, [%rd1];",
         "'ld.u64': '%r1' is 32-bit (.b32), this operand needs 64-bit or more", 8},
        {"cvt.u64.u32 %r1, %r2;",
         "'cvt.u64.u32': '%r1' is 32-bit (.b32), this operand needs 64-bit or more", 13},
        {"shl.b32 %r1, %r2, %rd1;", "'shl.b32': '%rd1' is 64-bit (.b64), this operand needs 32-bit",
         19},
        {"mov.u64 %rd1, %tid.x;", "'mov.u64': '%tid.x' is 32-bit (.u32), this operand needs 64-bit",
         15},
        {"mov.u32 %r1, %clock64;",
         "'mov.u32': '%clock64' is 64-bit (.u64), this operand needs 32-bit", 14},
        {"mov.u32 %r1, %tid;", "'mov.u32': '%tid' is a vector: one of .x, .y, .z must follow", 14},
        {"mov.f32 %f1, %v1;", "'mov.f32': 4 parts do not make up a value of type .f32", 14},
        {"add.f32 %f1, %v1, %f2;",
         "'add.f32': register '%v1' is a vector of 4: one of its parts is needed here", 14},
        {"mov.b64 %rd1, {%r1, %h1};",
         "'mov.b64': '%h1' is 16-bit (.b16), this operand needs 32-bit", 21},
        {"mov.b64 %rd1, {%r1, %r2, %r3};", "'mov.b64': 3 parts do not make up a value of type .b64",
         15},
        {"mov.u64 {%r1, %r2}, %rd1;", "'mov.u64': 2 parts do not make up a value of type .u64", 9},
    });
}

TEST(Refused, Predicates) {
    check({
        {"setp.eq.s32 %r1, %r2, %r3;",
         "'setp.eq.s32': expected a predicate, found '%r1' of type .b32", 13},
        {"add.u32 %r1, %p1, %r2;",
         "'add.u32': predicate '%p1' stands where a value of 32-bit is needed", 14},
        {"selp.b32 %r1, %r2, %r3, %r4;",
         "'selp.b32': expected a predicate, found '%r4' of type .b32", 25},
        {"and.pred %p1, %r1, %p2;", "'and.pred': expected a predicate, found '%r1' of type .b32",
         15},
        {"add.u32 %r1, !%r2, %r3;", "'add.u32': only predicates can be negated here", 14},
        {"add.u32 %r1, %r2, -%r3;", "'add.u32': only predicates can be negated here", 19},
        {"selp.f32 %f1, 1.0, 0.0, 0.5;",
         "'selp.f32': a floating point literal stands where a predicate is needed", 25},
        {"mov.pred !%p1, %p2;", "'mov.pred': a result cannot be negated", 10},
        {"add.u32 %r1|%p1, %r2, %r3;", "'add.u32': takes no pair of destinations", 9},
        {"shfl.sync.up.b32 %r1|%r2, %r3, 1, 0, -1;",
         "'shfl.sync.up.b32': expected a predicate, found '%r2' of type .b32", 22},
    });
}

TEST(Refused, Literals) {
    check({
        {"mov.f32 %f1, 0;",
         "'mov.f32': an integer literal stands where a .f32 is needed (write 1.0 or 0f3F800000)",
         14},
        {"add.f64 %d1, %d1, 1;",
         "'add.f64': an integer literal stands where a .f64 is needed (write 1.0 or 0f3F800000)",
         19},
        {"mov.u32 %r1, 0f3F800000;",
         "'mov.u32': a 32-bit floating point literal does not fit an operand of type .u32", 14},
        {"mov.b32 %r1, 1.5;",
         "'mov.b32': a 64-bit floating point literal does not fit an operand of type .b32", 14},
        {"add.f16 %h1, %h1, 1.0;", "'add.f16': there are no literals of type .f16: use a register",
         19},
        {"lop3.b32 %r1, %r2, %r3, %r4, %r5;",
         "'lop3.b32': expected an integer literal, found '%r5'", 30},
    });
    mustParseBody("mov.b32 %r1, 0f3F800000;\nmov.b64 %rd1, 1.0;\nadd.f32 %f1, %f1, 0.1;\n"
                  "add.f64 %d1, %d1, 0f3F800000;\nadd.f32 %f1, %f1, 0d3FF0000000000000;");
}

TEST(Refused, DestinationsAndPlaces) {
    check({
        {"add.u32 5, %r1, %r2;", "'add.u32': the result must go to a register, found a literal", 9},
        {"add.u32 _, %r1, %r2;", "'add.u32': the result must go to a register, found '_'", 9},
        {"mov.u32 %tid.x, %r1;", "'mov.u32': the result must go to a register, found '%tid.x'", 9},
        {"mov.u64 numbers, %rd1;", "'mov.u64': the result must go to a register, found 'numbers'",
         9},
        {"add.u64 %rd1, numbers, 4;",
         "'add.u64': the address of 'numbers' cannot stand here: take it with mov first", 15},
        {"mov.u16 %h1, numbers;", "'mov.u16': the address of 'numbers' does not fit type .u16", 14},
        {"mov.u32 %r1, [%rd1];", "'mov.u32': mov takes no memory operand: use ld", 14},
        {"ld.u32 %r1, %rd1;", "'ld.u32': expected an address in brackets, found '%rd1'", 13},
        {"ld.u32 %r1, numbers;", "'ld.u32': the address 'numbers' needs brackets: [numbers]", 13},
        {"ld.u32 %r1, [%h1];",
         "'ld.u32': an address register has 64 bits (or 32 in .shared, .local and .const), this "
         "one "
         "is of type .b16",
         13},
        {"ld.global.u32 %r1, [%r2];",
         "'ld.global.u32': register '%r2' has 32 bits, an address in generic or .global space has "
         "64",
         20},
        {"add.u32 %r1, {%r2, %r3}, %r4;",
         "'add.u32': a vector stands where a register or literal is needed", 14},
        {"ld.v4.u32 {%r1, %r2}, [%rd1];",
         "'ld.v4.u32': the vector has 2 elements, the instruction takes 4", 11},
        {"ld.v4.u32 %r1, [%rd1];", "'ld.v4.u32': '%r1' is not a vector of 4 elements", 11},
        {"ld.u32 {%r1}, [%rd1]; ld.u32 {%r1, %r2}, [%rd1];",
         "'ld.u32': the vector has 2 elements, the instruction takes 1", 30},
        {"tex.2d.v4.f32.f32 {%f1,%f2,%f3,%f4}, [%rd1];",
         "'tex.2d.v4.f32.f32': expected [texture, coordinates], found an address", 38},
        {"mov.b64 {%r1, %r2}, {%r3, %r4};",
         "'mov.b64': packs and unpacks at once: one side must be a single register (or write "
         "mov.v2, "
         "mov.v4)",
         9},
        {"mov.b64 {%r1, 5}, %rd1;", "'mov.b64': each part must be a register", 15},
    });
}

TEST(Refused, OneMessagePerFaultySpelling) {
    Diagnostics diagnostics;
    std::string body;
    for (int i = 0; i < 100; ++i)
        body += "adds.u32 %r1, %r2, %r3;\n";
    parse(kernel(body + "subs.u32 %r1, %r2;"), diagnostics);
    EXPECT_EQ(diagnostics.errorCount(), 2u) << diagnostics.format();
}

TEST(SpecialRegisters, NamesAndWidths) {
    ASSERT_TRUE(findSpecialRegister("%tid"));
    EXPECT_TRUE(findSpecialRegister("%tid")->vector);
    EXPECT_EQ(findSpecialRegister("%clock64")->type, Type::kU64);
    EXPECT_EQ(findSpecialRegister("%is_explicit_cluster")->type, Type::kPred);
    EXPECT_EQ(findSpecialRegister("%warpid")->vector, false);
    for (const char* name : {"%", "%t", "%tid.x", "%tidd", "%envreg", "%envreg32", "%envreg01",
                             "%pm8", "%pm_64", "%pm1_32", "tid", ""})
        EXPECT_EQ(findSpecialRegister(name), nullptr) << name;
}

} // namespace
} // namespace sunstone::ptx::testing
