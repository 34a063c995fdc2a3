// SPDX-License-Identifier: Apache-2.0
// Function bodies: operands, scopes, labels, calls, and the places of their errors.
#include "ptx/test_support.h"

#include <bit>
#include <deque>

namespace sunstone::ptx::testing {
namespace {

const Operand& operandOf(const Parsed& parsed, size_t index) {
    static const Operand none;
    EXPECT_LT(index, parsed.instruction.operands.size());
    return index < parsed.instruction.operands.size() ? parsed.instruction.operands[index] : none;
}

TEST(Instructions, OpcodeModifiersTypesGuard) {
    const Parsed p = lastInstruction("@!%p3 ld.global.nc.v4.u32 {%r1, _, %r3, %r4}, [%rd2+16];");
    EXPECT_EQ(p.instruction.opcode, "ld");
    EXPECT_EQ(p.instruction.modifiers,
              (std::vector<std::string_view>{"global", "nc", "v4", "u32"}));
    EXPECT_EQ(p.instruction.types, (std::vector<Type>{Type::kU32}));
    EXPECT_TRUE(p.instruction.has("nc"));
    EXPECT_FALSE(p.instruction.has("n"));
    EXPECT_EQ(p.instruction.fullOpcode(), "ld.global.nc.v4.u32");
    EXPECT_EQ(nameOf(*p.function, p.instruction.guard), "%p3");
    EXPECT_TRUE(p.instruction.guardNegated);
    EXPECT_EQ(p.instruction.location.line, 5u);
    EXPECT_EQ(p.instruction.location.column, 7u);
    ASSERT_EQ(p.instruction.operands.size(), 2u);
    EXPECT_EQ(operandOf(p, 0).kind, OperandKind::kVector);
    EXPECT_EQ(operandOf(p, 0).elements.size(), 4u);
    EXPECT_EQ(operandOf(p, 0).elements[1].kind, OperandKind::kSink);
}

TEST(Instructions, TypesInOrder) {
    EXPECT_EQ(lastInstruction("cvt.rzi.ftz.s32.f32 %r1, %f1;").instruction.types,
              (std::vector<Type>{Type::kS32, Type::kF32}));
    EXPECT_EQ(lastInstruction("@%p1 ret;").instruction.guardNegated, false);
}

TEST(Operands, Literals) {
    const auto integerOf = [](const std::string& text) {
        const Parsed p = lastInstruction("mov.b64 %rd1, " + text + ";");
        EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kInteger) << text;
        return operandOf(p, 1).integer;
    };
    EXPECT_EQ(integerOf("42"), 42);
    EXPECT_EQ(integerOf("-42"), -42);
    EXPECT_EQ(integerOf("0xFFFFFFFFFFFFFFFF"), -1);
    EXPECT_EQ(integerOf("WARP_SZ"), 32);
    EXPECT_EQ(integerOf("(1 + 2) * 3"), 9);
    EXPECT_EQ(integerOf("1 + 2 * 3"), 7);
    EXPECT_EQ(integerOf("-WARP_SZ"), -32);
    EXPECT_EQ(integerOf("~0 >> 1"), -1);
    EXPECT_EQ(integerOf("(.u64)~0 >> 63"), 1);
    EXPECT_EQ(integerOf("!5 + !0"), 1);
    EXPECT_EQ(integerOf("7 % 4 == 3 && 2 <= 2"), 1);
    EXPECT_EQ(integerOf("1 ? 2 : 1 ? 3 : 4"), 2);
    EXPECT_EQ(integerOf("6 & 3 | 8 ^ 1"), 11);
    EXPECT_EQ(integerOf("(-9223372036854775807 - 1) / -1"), INT64_MIN);
    EXPECT_EQ(integerOf("1 << 64"), 0);
}

TEST(Operands, FloatingPointLiterals) {
    Parsed p = lastInstruction("mov.f32 %f1, 0f3F800000;");
    EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kFloat);
    EXPECT_EQ(operandOf(p, 1).floatBits, 32);
    EXPECT_EQ(operandOf(p, 1).integer, 0x3F800000);
    p = lastInstruction("mov.f64 %d1, 0d3FF0000000000000;");
    EXPECT_EQ(operandOf(p, 1).floatBits, 64);
    for (const auto& [text, value] : std::initializer_list<std::pair<const char*, double>>{
             {"0.5", 0.5}, {"-1e-3", -1e-3}, {".25", 0.25}, {"-.5", -0.5}, {"1.5 + 2", 3.5}}) {
        p = lastInstruction(std::string("mov.f32 %f1, ") + text + ";");
        EXPECT_EQ(operandOf(p, 1).floatBits, 64) << text;
        EXPECT_EQ(std::bit_cast<double>(operandOf(p, 1).integer), value) << text;
    }
    p = lastInstruction("mov.f32 %f1, -0f3F800000;");
    EXPECT_EQ(static_cast<uint64_t>(operandOf(p, 1).integer), 0xBF800000u);
}

TEST(Operands, Registers) {
    Parsed p = lastInstruction("mov.f32 %f1, %v2.z;");
    EXPECT_EQ(nameOf(*p.function, operandOf(p, 1).index), "%v2");
    EXPECT_EQ(operandOf(p, 1).component, 2);
    EXPECT_EQ(operandOf(lastInstruction("mov.f32 %f1, %v2.a;"), 1).component, 3);
    p = lastInstruction("selp.b32 %r1, %r2, %r3, !%p1;");
    EXPECT_TRUE(operandOf(p, 3).negated);
    p = lastInstruction("setp.eq.s32 %p1|%p2, %r1, %r2;");
    ASSERT_EQ(operandOf(p, 0).kind, OperandKind::kPair);
    EXPECT_EQ(nameOf(*p.function, operandOf(p, 0).elements[1].index), "%p2");
    p = lastInstruction("shfl.sync.up.b32 _|%p2, %r1, 1, 0, -1;");
    EXPECT_EQ(operandOf(p, 0).elements[0].kind, OperandKind::kSink);
}

TEST(Operands, RangesAreExpandedAsUsed) {
    const Parsed p = lastInstruction("add.u32 %r98, %r0, %r98;");
    EXPECT_EQ(p.instruction.operands[0].index, p.instruction.operands[2].index);
    EXPECT_EQ(p.function->registers.size(), 3u) << "the two of %r and %w";
    mustParseItems(".entry k() { .reg .b32 x0<100000000>; mov.u32 x099999999, x01; ret; }");
}

TEST(Operands, SpecialRegisters) {
    EXPECT_EQ(operandOf(lastInstruction("mov.u32 %r1, %tid.x;"), 1).kind, OperandKind::kSpecial);
    EXPECT_EQ(operandOf(lastInstruction("mov.u32 %r1, %tid.x;"), 1).name, "%tid.x");
    EXPECT_EQ(operandOf(lastInstruction("mov.u32 %r1, %lanemask_lt;"), 1).name, "%lanemask_lt");
    for (const char* name : {"%ntid.y", "%ctaid.z", "%nctaid.w", "%laneid", "%warpid", "%smid",
                             "%clock", "%clock_hi", "%envreg31", "%pm7", "%globaltimer_lo",
                             "%lanemask_ge", "%dynamic_smem_size", "%reserved_smem_offset_1"})
        EXPECT_EQ(operandOf(lastInstruction(std::string("mov.u32 %r1, ") + name + ";"), 1).name,
                  name);
    for (const char* name :
         {"%clock64", "%globaltimer", "%gridid", "%pm3_64", "%current_graph_exec"})
        EXPECT_EQ(operandOf(lastInstruction(std::string("mov.u64 %rd1, ") + name + ";"), 1).name,
                  name);
}

TEST(Operands, Addresses) {
    std::deque<Parsed> kept; // the operands' names live in their modules
    const auto address = [&](const std::string& text) -> const Operand& {
        const Parsed& p = kept.emplace_back(lastInstruction("ld.u32 %r1, " + text + ";"));
        EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kAddress) << text;
        return operandOf(p, 1);
    };
    EXPECT_EQ(address("[%rd1]").offset, 0);
    EXPECT_EQ(address("[%rd1+16]").offset, 16);
    EXPECT_EQ(address("[%rd1+-16]").offset, -16);
    EXPECT_EQ(address("[%rd1-16]").offset, -16);
    EXPECT_EQ(address("[%rd1+4+2*4-1]").offset, 11);
    EXPECT_EQ(address("[%rd1+0x10]").offset, 16);
    EXPECT_EQ(address("[numbers+4]").name, "numbers");
    EXPECT_EQ(address("[numbers+4]").offset, 4);
    EXPECT_EQ(address("[numbers+4]").index, ~0u);
    EXPECT_EQ(address("[4096]").offset, 4096);
    EXPECT_EQ(address("[4096]").index, ~0u);
    EXPECT_TRUE(address("[4096]").name.empty());
}

TEST(Operands, ArraysAreIndexedByElement) {
    Parsed p = lastInstruction("ld.global.u32 %r1, numbers[3];");
    EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kAddress);
    EXPECT_EQ(operandOf(p, 1).name, "numbers");
    EXPECT_EQ(operandOf(p, 1).offset, 12);
    EXPECT_EQ(operandOf(p, 1).scale, 0u);
    p = lastInstruction("ld.global.u32 %r1, numbers[%r2+1];");
    EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kAddress);
    EXPECT_EQ(nameOf(*p.function, operandOf(p, 1).index), "%r2");
    EXPECT_EQ(operandOf(p, 1).scale, 4u);
    EXPECT_EQ(operandOf(p, 1).offset, 4);
    p = lastInstruction("st.local.u8 stack[%r2], %r1;");
    EXPECT_EQ(operandOf(p, 0).scale, 1u);
    p = lastInstruction("mov.u64 %rd1, numbers[3];");
    EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kSymbol);
    EXPECT_EQ(operandOf(p, 1).offset, 12);
    p = lastInstruction("mov.u64 %rd1, numbers+8;");
    EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kSymbol);
    EXPECT_EQ(operandOf(p, 1).offset, 8);
}

TEST(Operands, Textures) {
    const Parsed p = lastInstruction(
        "tex.grad.2d.v4.f32.f32 {%f1,%f2,%f3,%f4}, [%rd1, {%f5, %f6}], {%f1, %f2}, {%f3, %f4};");
    ASSERT_EQ(p.instruction.operands.size(), 4u);
    EXPECT_EQ(operandOf(p, 1).kind, OperandKind::kTexture);
    ASSERT_EQ(operandOf(p, 1).elements.size(), 2u);
    EXPECT_EQ(operandOf(p, 1).elements[0].kind, OperandKind::kRegister);
    EXPECT_EQ(operandOf(p, 1).elements[1].kind, OperandKind::kVector);
    const Parsed q = lastInstruction("tex.2d.v4.f32.f32 {%f1,%f2,%f3,%f4}, [picture, sampler, "
                                     "{%f5, %f6}];}\n.global .samplerref "
                                     "sampler;\n.func f() {");
    const Function* kernel = q.module->findFunction("kernel");
    ASSERT_TRUE(kernel && kernel->body.size() == 1);
    const Operand& texture = kernel->body[0].instruction.operands[1];
    ASSERT_EQ(texture.elements.size(), 3u);
    EXPECT_EQ(texture.elements[0].name, "picture");
    EXPECT_EQ(texture.elements[1].name, "sampler");
}

TEST(OperandErrors, NamesAndForms) {
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %r99;"), "5:14: undeclared register '%r99'");
    EXPECT_EQ(errorOfBody(".reg .b32 %total;\nmov.u32 %r1, %totl;"),
              "6:14: undeclared register '%totl' (did you mean '%total'?)");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %tidd.x;"), "5:14: undeclared register '%tidd'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %envreg32;"), "5:14: undeclared register '%envreg32'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %r01;"),
              "5:14: undeclared register '%r01' (did you mean '%r1'?)");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %tid.q;"), "5:18: expected .x, .y, .z or .w, found '.q'");
    EXPECT_EQ(errorOfBody("mov.u64 %rd1, numbrs;"),
              "5:15: undeclared name 'numbrs' (did you mean 'numbers'?)");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %r2.x;"), "5:17: register has no part '.x'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %w.z;"), "5:16: register has no part '.z'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, !5 + ;"), "5:19: expected a number, found ';'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, -numbers;"), "5:14: '-' must stand before a register");
    EXPECT_EQ(errorOfBody("ld.u32 %r1, [%rd1;"), "5:18: expected ']' after the address, found ';'");
    EXPECT_EQ(errorOfBody("ld.u32 %r1, [%rd1+1.5];"), "5:19: an offset must be a whole number");
    EXPECT_EQ(errorOfBody("ld.u32 %r1, [%tid.x];"),
              "5:14: an address begins with a register or a symbol");
    EXPECT_EQ(errorOfBody("ld.u32 %r1, [];"), "5:14: expected a number, found ']'");
    EXPECT_EQ(errorOfBody("ld.u32 %r1, later[2];"),
              "5:13: 'later' must be declared before it is indexed");
    EXPECT_EQ(errorOfBody("ld.u32 %r1, numbers[99999999999999];"),
              "5:13: index 99999999999999 is out of range");
    EXPECT_EQ(errorOfBody("ld.v2.u32 {%r1, {%r2}}, [%rd1];"),
              "5:17: expected a register or a number in the braces, found '{'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, ;"), "5:14: expected an operand, found ';'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1 %r2;"),
              "5:13: expected ',' or ';' after the operands of mov, found '%r2'");
    EXPECT_EQ(errorOfBody("mov.u32 %r1, %r2\nret;"),
              "6:1: expected ',' or ';' after the operands of mov, found 'ret'");
    EXPECT_EQ(errorOfBody("%r1 = 5;"),
              "5:1: an instruction begins with its opcode, not with register '%r1'");
    EXPECT_EQ(errorOfBody("42;"),
              "5:1: expected an instruction, a label or a directive, found '42'");
    EXPECT_EQ(errorOfBody("@%r1 ret;"), "5:2: the guard must be a .pred register, not a .b32");
    EXPECT_EQ(errorOfBody("@numbers ret;"), "5:2: undeclared name 'numbers'");
    EXPECT_EQ(errorOfBody("@stack ret;"), "5:2: 'stack' is not a register");
}

TEST(OperandErrors, NestingIsLimited) {
    const std::string deep(100000, '(');
    EXPECT_EQ(errorOfBody("mov.u32 %r1, " + deep + "1;").substr(0, 40),
              "5:114: the expression is nested too deep");
    std::string minus(100000, '-');
    EXPECT_NE(errorOfBody("mov.u32 %r1, " + minus + "1;"), "");
    std::string choice;
    for (int i = 0; i < 100000; ++i)
        choice += "1?";
    EXPECT_NE(errorOfBody("mov.u32 %r1, " + choice + "1;"), "");
}

TEST(OperandErrors, AFaultInsideAnExpressionDoesNotCountTowardsTheNext) {
    Diagnostics diagnostics;
    const std::string nested = std::string(60, '(') + "1 / 0" + std::string(60, ')');
    const std::string sound = std::string(60, '(') + "1" + std::string(60, ')');
    parse(kernel("mov.u32 %r1, " + nested + ";\nmov.u32 %r1, " + sound + ";"), diagnostics);
    EXPECT_EQ(diagnostics.errorCount(), 1u) << diagnostics.format();
}

TEST(Scopes, InnerNamesHideOuterOnes) {
    const auto module = mustParseBody("mov.u32 %r1, 1;\n{ .reg .b64 %r1; mov.u64 %r1, 2;\n"
                                      "{ .reg .f32 %r<5>; mov.f32 %r1, 1.0; mov.f32 %r1, 2.0; }\n"
                                      "mov.u64 %r1, 3; }\nmov.u32 %r1, 4;");
    const Function& function = kernelOf(*module);
    std::vector<Type> types;
    std::vector<uint32_t> indices;
    for (const Statement& statement : function.body) {
        indices.push_back(statement.instruction.operands[0].index);
        types.push_back(function.registers[indices.back()].type);
    }
    EXPECT_EQ(types, (std::vector<Type>{Type::kB32, Type::kB64, Type::kF32, Type::kF32, Type::kB64,
                                        Type::kB32}));
    EXPECT_EQ(indices[0], indices[5]);
    EXPECT_EQ(indices[1], indices[4]);
    EXPECT_EQ(indices[2], indices[3]);
}

TEST(Scopes, ARangeRegisterFirstUsedInsideBelongsOutside) {
    const auto module =
        mustParseBody("{{ mov.u32 %r7, 1; }}\n{ mov.u32 %r7, 2; }\nmov.u32 %r7, 3;");
    const Function& function = kernelOf(*module);
    EXPECT_EQ(function.body[0].instruction.operands[0].index,
              function.body[1].instruction.operands[0].index);
    EXPECT_EQ(function.body[0].instruction.operands[0].index,
              function.body[2].instruction.operands[0].index);
}

TEST(Scopes, AnInnerRangeHidesAnOuterRegister) {
    const auto module = mustParseBody(
        "mov.u32 %r1, 0;\n{ .reg .b32 %r<2>; mov.u32 %r1, 1; mov.u32 %r5, 1; }\nmov.u32 %r1, 2;");
    const Function& function = kernelOf(*module);
    const auto index = [&](size_t i) { return function.body[i].instruction.operands[0].index; };
    EXPECT_EQ(index(0), index(3));
    EXPECT_NE(index(0), index(1));
    EXPECT_NE(index(1), index(2));
}

TEST(Scopes, VariablesGetNamesOfTheirOwn) {
    const auto module = mustParseBody(
        "{ .param .b32 param0; st.param.b32 [param0], 1; call f, (param0); }\n"
        "{ .param .b64 param0; st.param.b64 [param0], 2; call g, (param0); }\n"
        "{ .local .b8 numbers[4]; st.local.u8 [numbers+1], 3; }\nst.global.u8 [numbers], 4;\n}\n"
        ".func f(.param .b32 a);\n.func g(.param .b64 a);\n.func h() {");
    const Function& function = kernelOf(*module);
    ASSERT_EQ(function.variables.size(), 4u); // with `stack`
    EXPECT_EQ(function.variables[1].name, "param0");
    EXPECT_EQ(function.variables[2].name, "param0$1");
    EXPECT_EQ(function.variables[3].name, "numbers$1");
    EXPECT_EQ(function.body[2].instruction.operands[0].name, "param0$1");
    EXPECT_EQ(function.body[3].instruction.arguments[0].name, "param0$1");
    EXPECT_EQ(function.body[4].instruction.operands[0].name, "numbers$1");
    EXPECT_EQ(function.body[5].instruction.operands[0].name, "numbers");
}

TEST(Scopes, MidBodyDeclarations) {
    const auto module = mustParseBody(".reg .b32 x, y<3>;\nmov.u32 x, y2;\n.reg .v2 .f32 z;\n"
                                      ".shared .align 8 .f64 s[4], t;\n.global .u32 count = 5;\n"
                                      "mov.f32 z.x, z.y;\nld.shared.f64 %d1, [s+8];");
    EXPECT_EQ(kernelOf(*module).variables.size(), 4u);
    EXPECT_TRUE(kernelOf(*module).variables[3].hasInitializer);
}

TEST(ScopeErrors, Declarations) {
    EXPECT_EQ(errorOfBody(".reg .b32 x;\n.reg .b64 x;"),
              "6:11: register 'x' is declared twice in this scope; first at line 5");
    EXPECT_EQ(errorOfBody(".reg .b32 %r<5>;"),
              "5:11: registers '%r' are declared twice in this scope");
    EXPECT_EQ(errorOfBody(".local .b32 stack;"),
              "5:13: 'stack' is declared twice in this scope; first at line 4");
    EXPECT_EQ(errorOfBody("{ .reg .b32 x; }\nmov.u32 x, 1;\n"), "6:9: undeclared name 'x'");
    EXPECT_EQ(errorOfBody(".reg .b32 x<;"), "5:13: expected a register count, found ';'");
    EXPECT_EQ(errorOfBody(".reg .b32 x<4;"),
              "5:14: expected '>' after the register count, found ';'");
    EXPECT_EQ(errorOfBody(".reg x;"), "5:6: expected a type like .u32, found 'x'");
    EXPECT_EQ(errorOfBody(".regg .b32 x;"),
              "5:1: unknown directive '.regg' in the body of function 'kernel' (did you mean "
              "'.reg'?)");
    EXPECT_EQ(errorOfBody("ret;\n.entry other() { ret; }"),
              "6:1: unknown directive '.entry' in the body of function 'kernel': a '}' may be "
              "missing before it");
    EXPECT_EQ(errorOfBody("ret; }"), "6:1: expected a directive, found '}'");
}

TEST(ScopeErrors, BracesMustNotNestWithoutEnd) {
    EXPECT_EQ(errorOfBody(std::string(100000, '{')),
              "5:999: braces are nested more than 1000 deep");
    mustParseBody(std::string(900, '{') + std::string(900, '}'));
}

TEST(Labels, ForwardBackwardAndInScopes) {
    const auto module = mustParseBody(
        "top: bra bottom;\n{ again: bra again; bra top; bra.uni bottom;\n"
        "{ again: @%p1 bra again; bra inner; inner: } }\nbra again;\nagain:\nbottom: ret;");
    const Function& function = kernelOf(*module);
    EXPECT_EQ(function.labels,
              (std::vector<std::string_view>{"top", "again", "again", "inner", "again", "bottom"}));
    std::vector<uint32_t> targets;
    for (const Statement& statement : function.body)
        if (statement.kind == StatementKind::kInstruction && statement.instruction.opcode == "bra")
            targets.push_back(statement.instruction.operands[0].index);
    EXPECT_EQ(targets, (std::vector<uint32_t>{5, 1, 0, 5, 2, 3, 4}));
}

// Names that look like registers are valid, too.
TEST(Labels, Names) {
    mustParseBody("bra %L1; %L1: bra $L$2; $L$2: bra _L3; _L3: BB0_1: @%p1 bra BB0_1;");
}

TEST(Labels, SameNamesInSeveralFunctions) {
    const auto module =
        mustParseItems(".entry a() { x: bra x; }\n.entry b() { bra x; y: x: ret; }");
    EXPECT_EQ(module->functions[1].body[0].instruction.operands[0].index, 1u);
}

TEST(Labels, BranchTargets) {
    const auto module =
        mustParseBody("table: .branchtargets one, two, one;\n@%p1 brx.idx %r1, table;\n"
                      "one: two: ret;");
    const Function& function = kernelOf(*module);
    ASSERT_EQ(function.branchTargets.size(), 1u);
    EXPECT_EQ(function.branchTargets[0].name, "table");
    EXPECT_EQ(function.branchTargets[0].labels, (std::vector<uint32_t>{0, 1, 0}));
    EXPECT_EQ(function.body[0].instruction.operands[1].kind, OperandKind::kSymbol);
    EXPECT_EQ(function.body[0].instruction.operands[1].name, "table");
}

TEST(LabelErrors, UnknownTwiceAndOfAnotherKind) {
    EXPECT_EQ(errorOfBody("finish: bra finsh;"),
              "5:13: unknown label 'finsh' in function 'kernel' (did you mean 'finish'?)");
    EXPECT_EQ(errorOfBody("{ x: }\nbra x;"),
              "6:5: unknown label 'x' in function 'kernel': the label of this name is in a scope "
              "that cannot be seen from here");
    EXPECT_EQ(errorOfBody("x: ret;\nx: ret;"),
              "6:1: label 'x' is defined twice in this scope; first at line 5");
    EXPECT_EQ(errorOfBody("x: { x: }\n x: ret;"),
              "6:2: label 'x' is defined twice in this scope; first at line 5");
    EXPECT_EQ(errorOfBody("p: .callprototype _ ();\nbra p;"), "6:5: 'p' (line 5) is not a label");
    EXPECT_EQ(errorOfBody("x: brx.idx %r1, x;"), "5:17: 'x' (line 5) is not a .branchtargets list");
    EXPECT_EQ(errorOfBody("x: call %rd1, (), x;"),
              "5:19: 'x' (line 5) is not a .callprototype or .calltargets list");
    EXPECT_EQ(errorOfBody("t: .branchtargets a, b; a: ret;"),
              "5:22: unknown label 'b' in function 'kernel'");
    EXPECT_EQ(errorOfBody("bra %r1;"), "5:5: unknown label '%r1' in function 'kernel'");
    EXPECT_EQ(errorOfBody("bra;"), "5:1: 'bra' takes 1 operand, not 0");
    EXPECT_EQ(errorOfItems(".entry k() { x: ret; }\n.entry j() { bra x; }"),
              "5:18: unknown label 'x' in function 'j'");
}

TEST(Calls, Spellings) {
    std::deque<Parsed> kept; // the names live in the modules
    const auto call = [&](const std::string& text) {
        return kept.emplace_back(lastInstruction(text)).instruction;
    };
    Instruction c = call("call (%r1), _optix_get_launch_index_x, ();");
    EXPECT_EQ(c.target.kind, OperandKind::kSymbol);
    EXPECT_EQ(c.target.name, "_optix_get_launch_index_x");
    EXPECT_EQ(c.results.size(), 1u);
    EXPECT_TRUE(c.arguments.empty() && c.operands.empty());
    c = call("call(%r1,%r2,%r3),_optix_trace_typed_32,(%r4,%f1,7,0f3F800000);");
    EXPECT_EQ(c.results.size(), 3u);
    EXPECT_EQ(c.arguments.size(), 4u);
    EXPECT_EQ(c.arguments[2].kind, OperandKind::kInteger);
    c = call("@%p1 call.uni _rt_terminate_ray, ();");
    EXPECT_TRUE(c.has("uni"));
    EXPECT_TRUE(c.results.empty());
    c = call("call _optix_terminate_ray;");
    EXPECT_EQ(c.target.name, "_optix_terminate_ray");
    c = call(
        "{ .param .b64 param0; .param .b64 param1; .param .b32 retval0;\ncall.uni (retval0), \n"
        "vprintf, \n(\nparam0, \nparam1\n);\nret; }");
    const Parsed p = lastInstruction(
        "{ .param .b64 param0; .param .b64 param1; .param .b32 retval0;\ncall.uni (retval0), \n"
        "vprintf, \n(\nparam0, \nparam1\n); }");
    EXPECT_EQ(p.instruction.results[0].name, "retval0");
    EXPECT_EQ(p.instruction.arguments[1].name, "param1");
}

TEST(Calls, ThroughPointers) {
    Parsed p = lastInstruction("{ .param .align 16 .b8 a[48]; .param .b32 r;\n"
                               "proto: .callprototype (.param .b32 _) _ (.param .align 16 .b8 "
                               "_[48], .reg .u32 _) .noreturn;\n"
                               "call (r), %rd1, (a, %r1), proto; }");
    EXPECT_EQ(p.instruction.target.kind, OperandKind::kRegister);
    EXPECT_EQ(p.instruction.prototype, "proto");
    ASSERT_EQ(p.function->prototypes.size(), 1u);
    const Prototype& prototype = p.function->prototypes[0];
    EXPECT_EQ(prototype.name, "proto");
    EXPECT_EQ(prototype.location.line, 6u);
    ASSERT_EQ(prototype.parameters.size(), 2u);
    EXPECT_EQ(prototype.parameters[0].size, 48u);
    EXPECT_EQ(prototype.parameters[0].alignment, 16u);
    EXPECT_EQ(prototype.parameters[1].space, Space::kReg);
    // A label after its use; the same name in two scopes; a call without arguments.
    p = lastInstruction("{ call %rd1, (), x; x: .callprototype _ (); }\n"
                        "{ x: .callprototype _ (); call %rd1, x; }");
    EXPECT_EQ(p.instruction.prototype, "x$1");
    EXPECT_EQ(p.function->body[0].instruction.prototype, "x");
    p = lastInstruction(
        "t: .calltargets callee, kernel;\n{ .param .b32 r; .param .b64 a; .param .b32 "
        "b; call (r), %rd1, (a, b), t; }");
    EXPECT_EQ(p.instruction.prototype, "t");
    EXPECT_EQ(p.function->callTargets[0].functions,
              (std::vector<std::string_view>{"callee", "kernel"}));
}

TEST(CallErrors, Callees) {
    EXPECT_EQ(
        errorOfBody("call calee, (%rd1, %r1);"),
        "5:6: call of function 'calee', which the module neither declares nor defines (did you "
        "mean 'callee'?)");
    EXPECT_EQ(errorOfBody("call (%r1), sinf, (%f1);"),
              "5:13: call of function 'sinf', which the module neither declares nor defines");
    EXPECT_EQ(errorOfBody("call (%r1), callee, (%rd1);"),
              "5:13: 'call': function 'callee' has 2 parameters, the call 1");
    EXPECT_EQ(errorOfBody("call callee, (%rd1, %r1);"),
              "5:6: 'call': function 'callee' has 1 result, the call 0");
    EXPECT_EQ(
        errorOfBody("call %rd1, (%r1);"),
        "5:6: 'call': a call through a register needs a .callprototype or .calltargets label");
    EXPECT_EQ(errorOfBody("p: .callprototype _ (); call %r1, (), p;"),
              "5:30: 'call': the callee's address must be a 64-bit register");
    EXPECT_EQ(errorOfBody("call %rd1, (), nowhere;"),
              "5:16: unknown label 'nowhere' in function 'kernel'");
    EXPECT_EQ(errorOfBody("call %foo, ();"), "5:6: undeclared register '%foo'");
    EXPECT_EQ(errorOfBody("call (%r1) callee, ();"),
              "5:12: expected ',' between the results and the callee of the call, found 'callee'");
    EXPECT_EQ(errorOfBody("call (%r1, callee;"),
              "5:18: expected ')' after the arguments, found ';'");
    EXPECT_EQ(errorOfBody("call callee, (%r1) %r2;"),
              "5:20: expected ';' after the call, found '%r2'");
    EXPECT_EQ(errorOfBody("call.foo _optix_terminate_ray;"),
              "5:1: 'call.foo': unknown modifier '.foo' for 'call'");
    EXPECT_EQ(errorOfBody("t: .calltargets calle;"),
              "5:17: undeclared name 'calle' (did you mean 'callee'?)");
}

TEST(Calls, ProvidedFunctionsNeedNoDeclaration) {
    mustParseBody("call _optix_whatever_2_float;\ncall (%r1), _rt_trace_64, (%r1);\n"
                  "call (%r1), vprintf, (%rd1, %rd2);\ncall __assertfail, (%rd1);");
}

TEST(Calls, FunctionsDeclaredInBodies) {
    // The definition is before, after or in another module; several blocks declare the function.
    for (const char* linkage : {"", ".extern ", ".visible ", ".weak "}) {
        const std::string declaration =
            std::string(linkage) + ".func (.param .b32 r) f(.param .b64 a, .reg .b32 b) .noreturn;";
        const std::string call = "{ " + declaration + " call.uni (%r1), f, (%rd1, %r2); }\n";
        const std::string definition =
            ".func (.param .b32 r) f(.param .b64 x, .reg .b32 y) { ret; }\n";
        const auto none = mustParseBody(call + call);
        ASSERT_TRUE(none->findFunction("f"));
        EXPECT_FALSE(none->findFunction("f")->hasBody);
        EXPECT_TRUE(none->findFunction("f")->noreturn);
        EXPECT_EQ(none->findFunction("f")->results.size(), 1u);
        EXPECT_EQ(kernelOf(*none).body.size(), 2u);
        const auto after = mustParse(kernel(call) + definition);
        EXPECT_TRUE(after->findFunction("f")->hasBody);
        const auto before = mustParse(kHeader + definition + kKernelHead + call + "}\n");
        EXPECT_TRUE(before->findFunction("f")->hasBody);
    }
    // The function's own name, guards and labels around declarations, no parameters.
    mustParseBody("{ .func g; .func h(); top: call g; @%p1 call h, (); bra top; }");
    mustParse(kHeader + ".func r(.reg .b32 a) { { .func r(.reg .b32 a); call r, (a); } ret; }\n");
}

TEST(CallErrors, FunctionsDeclaredInBodies) {
    const auto against = [](const std::string& declaration) {
        return errorOf(kernel("{ " + declaration + " }") +
                       ".func (.param .b32 r) f(.param .f64 a, .param .b8 b[8]) { ret; }\n");
    };
    EXPECT_EQ(against(".func (.param .s32 r) f(.reg .b64 a, .param .b16 c[4]);"), "");
    EXPECT_EQ(against(".func (.param .b32 r) f(.param .b64 a);"),
              "7:23: function 'f' has 2 parameters here, 1 at line 5");
    EXPECT_EQ(against(".func f(.param .b64 a, .param .b8 b[8]);"),
              "7:23: function 'f' has 1 result here, 0 at line 5");
    EXPECT_EQ(against(".func (.param .b32 r) f(.param .b32 a, .param .b8 b[8]);"),
              "7:23: function 'f' has parameter 1 of 8 bytes here, of 4 bytes at line 5");
    EXPECT_EQ(against(".func (.param .b32 r) f(.param .b64 a, .param .b64 b);"),
              "7:23: function 'f' has parameter 2 of an array of 8 bytes here, of 8 bytes at line "
              "5");
    EXPECT_EQ(against(".func (.reg .pred r) f(.param .b64 a, .param .b8 b[8]);"),
              "7:23: function 'f' has result 1 of 4 bytes here, of type .pred at line 5");
    EXPECT_EQ(errorOfBody(".func kernel(.param .u64 p, .param .u32 n);"),
              "4:183: function 'kernel' has .entry here, .func at line 5");
    EXPECT_EQ(errorOfBody(".func callee(.param .b64 a, .param .b32 b);"),
              "5:7: function 'callee' has 0 results here, 1 at line 4");
    EXPECT_EQ(errorOfBody("{ .func f(.param .b64 a) call f, (%rd1); }"),
              "5:26: expected ';' after the declaration of a function, found 'call'");
    EXPECT_EQ(errorOfBody(".func numbers();"),
              "5:7: function 'numbers' has the name of a variable declared at line 4");
    EXPECT_EQ(errorOfBody("{ .func f(.param .b64 a); call f, (%rd1, %rd2); }"),
              "5:32: 'call': function 'f' has 1 parameter, the call 2");
    EXPECT_EQ(errorOfBody(".visible .func f() { ret; }"),
              "5:16: function 'f' is defined in the body of function 'kernel': a '}' may be "
              "missing before it");
    EXPECT_EQ(errorOfBody(".entry f() { ret; }"),
              "5:1: unknown directive '.entry' in the body of function 'kernel': a '}' may be "
              "missing before it");
}

TEST(Recovery, SeveralFaultsAreReportedAtOnce) {
    Diagnostics diagnostics;
    parse(kernel("mov.u32 %r1, %x1;\nmov.u32 %r1, %x2;\n{ mov.u32 %r1, %x3; }\nbra nowhere;"),
          diagnostics);
    EXPECT_EQ(diagnostics.errorCount(), 4u) << diagnostics.format();
    Diagnostics many;
    std::string body;
    for (int i = 0; i < 1000; ++i)
        body += "mov.u32 %r1, %x;\n";
    parse(kernel(body), many);
    EXPECT_EQ(many.errorCount(), Diagnostics::kMaxErrors);
}

} // namespace
} // namespace sunstone::ptx::testing
