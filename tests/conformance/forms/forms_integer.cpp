// SPDX-License-Identifier: Apache-2.0
// Forms of integer arithmetic and of bits.
#include "forms/forms.h"

namespace conformance {

namespace {

struct IntType {
    const char *name, *in, *out, *wide; // wide: output of twice the width
};
const IntType kInts[] = {{"u16", "i16", "b16", "b32"}, {"s16", "i16", "b16", "b32"},
                         {"u32", "i32", "b32", "b64"}, {"s32", "i32", "b32", "b64"},
                         {"u64", "i64", "b64", ""},    {"s64", "i64", "b64", ""}};

// Instructions of the carry chain: the flag is set from an operand before, and read after.
void addCarryForms(Forms& forms, const IntType& t) {
    const std::string type = t.name;
    const std::string flagOut =
        type.ends_with("64") ? " addc.u64 d1, 0, 0;" : " addc.u32 d1, 0, 0;";
    const std::string borrowOut =
        type.ends_with("64") ? " subc.u64 d1, 0, 0;" : " subc.u32 d1, 0, 0;";
    const std::string flagIn = "add.cc.u32 t0, a2, 0xffffffff; "; // set unless a2 is 0
    const std::string borrowIn = "sub.cc.u32 t0, 0, a2; ";        // likewise
    forms.add("add.cc." + type, {t.in, t.in}, {t.out, t.out}, "@ d0, a0, a1;" + flagOut);
    forms.add("sub.cc." + type, {t.in, t.in}, {t.out, t.out}, "@ d0, a0, a1;" + borrowOut);
    forms.add("addc." + type, {t.in, t.in, "i32"}, {t.out}, flagIn + "@ d0, a0, a1;");
    forms.add("subc." + type, {t.in, t.in, "i32"}, {t.out}, borrowIn + "@ d0, a0, a1;");
    forms.add("addc.cc." + type, {t.in, t.in, "i32"}, {t.out, t.out},
              flagIn + "@ d0, a0, a1;" + flagOut);
    forms.add("subc.cc." + type, {t.in, t.in, "i32"}, {t.out, t.out},
              borrowIn + "@ d0, a0, a1;" + borrowOut);
    forms.add("mad.{lo|hi}.cc." + type, {t.in, t.in, t.in}, {t.out, t.out},
              "@ d0, a0, a1, a2;" + flagOut);
    const std::string flagIn3 = "add.cc.u32 t0, a3, 0xffffffff; ";
    forms.add("madc.{lo|hi}." + type, {t.in, t.in, t.in, "i32"}, {t.out},
              flagIn3 + "@ d0, a0, a1, a2;");
    forms.add("madc.{lo|hi}.cc." + type, {t.in, t.in, t.in, "i32"}, {t.out, t.out},
              flagIn3 + "@ d0, a0, a1, a2;" + flagOut);
}

} // namespace

void addIntegerForms(Forms& forms) {
    for (const IntType& t : kInts) {
        const std::string type = t.name;
        const bool isSigned = type[0] == 's';
        forms.add("{add|sub|div|rem|min|max|mul.lo|mul.hi}." + type, {t.in, t.in}, {t.out});
        forms.add("{mad.lo|mad.hi|sad}." + type, {t.in, t.in, t.in}, {t.out});
        if (t.wide[0]) {
            const char* wideIn = type.ends_with("16") ? "i32" : "i64";
            forms.add("mul.wide." + type, {t.in, t.in}, {t.wide});
            forms.add("mad.wide." + type, {t.in, t.in, wideIn}, {t.wide});
        }
        if (isSigned)
            forms.add("{abs|neg}." + type, {t.in}, {t.out});
        if (!type.ends_with("16"))
            addCarryForms(forms, t);
    }
    forms.add("{add|sub}.sat.s32", {"i32", "i32"}, {"b32"});
    forms.add("{min|max}.relu.s32", {"i32", "i32"}, {"b32"});
    forms.add("{add|min|max}.{u16x2|s16x2}", {"i32", "i32"}, {"b32"});
    forms.add("{min|max}.relu.s16x2", {"i32", "i32"}, {"b32"});
    forms.add("mad.hi.sat.s32", {"i32", "i32", "i32"}, {"b32"});
    forms.add("mul24.{lo|hi}.{u32|s32}", {"i32", "i32"}, {"b32"});
    forms.add("mad24.{lo|hi}.{u32|s32}", {"i32", "i32", "i32"}, {"b32"});
    forms.add("mad24.hi.sat.s32", {"i32", "i32", "i32"}, {"b32"});
    forms.add("dp4a.{u32|s32}.{u32|s32}", {"i32", "i32", "i32"}, {"b32"});
    forms.add("dp2a.{lo|hi}.{u32|s32}.{u32|s32}", {"i32", "i32", "i32"}, {"b32"});
    // With a number in the instruction.
    for (const char* value : {"0", "1", "-1", "7", "-2147483648", "2147483647"})
        for (const char* opcode : {"add.s32", "mul.lo.u32", "div.s32", "rem.s32", "div.u32",
                                   "min.s32", "max.u32", "mul.hi.s32"})
            if (std::string(value) != "0" || std::string(opcode).find(".s32") != 3)
                forms.add(opcode, {"i32"}, {"b32"}, std::string("@ d0, a0, ") + value + ";",
                          std::string("by ") + value);
    // 128-bit sums through the carry chain.
    forms.add("add.cc.u64", {"i64", "i64", "i64", "i64"}, {"b64", "b64"},
              "@ d0, a0, a2; addc.u64 d1, a1, a3;", "of 128 bits");
    forms.add("sub.cc.u64", {"i64", "i64", "i64", "i64"}, {"b64", "b64"},
              "@ d0, a0, a2; subc.u64 d1, a1, a3;", "of 128 bits");
}

void addBitForms(Forms& forms) {
    const struct {
        const char *bits, *in, *out;
    } kBits[] = {{"b16", "i16", "b16"}, {"b32", "i32", "b32"}, {"b64", "i64", "b64"}};
    for (const auto& t : kBits) {
        const std::string type = t.bits, digits = type.substr(1);
        forms.add("{and|or|xor}." + type, {t.in, t.in}, {t.out});
        forms.add("{not|cnot}." + type, {t.in}, {t.out});
        forms.add("{shl.b|shr.b|shr.u|shr.s}" + digits, {t.in, "sh"}, {t.out});
        if (digits == "16")
            continue;
        forms.add("{popc|clz}." + type, {t.in}, {"b32"});
        forms.add("brev." + type, {t.in}, {t.out});
        forms.add("bfind{|.shiftamt}.{u|s}" + digits, {t.in}, {"b32"});
        forms.add("bfe.{u|s}" + digits, {t.in, "len", "len"}, {t.out});
        forms.add("bfi." + type, {t.in, t.in, "len", "len"}, {t.out});
    }
    forms.add("{and|or|xor}.pred", {"p", "p"}, {"p"});
    forms.add("not.pred", {"p"}, {"p"});
    for (const unsigned table : {0x00u, 0x01u, 0x0fu, 0x1bu, 0x33u, 0x3cu, 0x55u, 0x69u, 0x80u,
                                 0x96u, 0xaau, 0xcau, 0xe8u, 0xf0u, 0xfeu, 0xffu}) {
        const std::string text = std::to_string(table);
        forms.add("lop3.b32", {"i32", "i32", "i32"}, {"b32"}, "@ d0, a0, a1, a2, " + text + ";",
                  "table " + text);
        if (table % 2)
            forms.add("lop3.{and|or}.b32", {"i32", "i32", "i32", "p"}, {"b32", "p"},
                      "@ d0|d1, a0, a1, a2, " + text + ", a3;", "table " + text);
    }
    forms.add("shf.{l|r}.{clamp|wrap}.b32", {"i32", "i32", "sh"}, {"b32"});
    forms.add("prmt.b32{|.f4e|.b4e|.rc8|.ecl|.ecr|.rc16}", {"i32", "i32", "i32"}, {"b32"});
    for (const char* selector : {"0x3210", "0x5410", "0x7632", "0x0123", "0x89ab", "0xfedc", "0x4"})
        forms.add("prmt.b32", {"i32", "i32"}, {"b32"},
                  std::string("@ d0, a0, a1, ") + selector + ";", std::string("by ") + selector);
    forms.add("fns.b32", {"i32", "lane", "nth"}, {"b32"},
              "and.b32 t0, a1, 31; @ d0, a0, t0, a2;"); // base is at most 31
    forms.add("bmsk.{clamp|wrap}.b32", {"len", "len"}, {"b32"});
    forms.add("szext.{clamp|wrap}.{u32|s32}", {"i32", "len"}, {"b32"});
    for (const char* amount : {"0", "1", "31", "32", "33", "255"}) {
        forms.add("{shl.b32|shr.u32|shr.s32}", {"i32"}, {"b32"},
                  std::string("@ d0, a0, ") + amount + ";", std::string("by ") + amount);
        if (std::string(amount).size() == 1 ||
            std::string(amount) == "31") // drivers fold others oddly
            forms.add("bfe.{u|s}32", {"i32"}, {"b32"}, std::string("@ d0, a0, ") + amount + ", 8;",
                      std::string("from ") + amount);
    }
}

} // namespace conformance
