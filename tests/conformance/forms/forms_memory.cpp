// SPDX-License-Identifier: Apache-2.0
// Forms of loads, stores and atomics, each on its own thread's memory.
#include "forms/forms.h"

namespace conformance {

namespace {

struct Space {
    const char *name, *address;
};
const Space kSpaces[] = {{".global", "m"}, {".shared", "sm"}, {".local", "lm"}, {"", "m"}};

void addAccesses(Forms& forms) {
    for (const Space& space : kSpaces) {
        const std::string name = space.name, at = std::string("[") + space.address + "]";
        const std::string low = std::string("[") + space.address + "+8]";
        const std::string prepare = "st" + name + ".b64 " + at + ", a0; ";
        forms.add("ld" + name + ".{u8|s8|b8}", {"i64"}, {"b16"}, prepare + "@ d0, " + at + ";");
        forms.add("ld" + name + ".{u8|s8|u16|s16|u32|s32|b32|f32}", {"i64"}, {"b32"},
                  prepare + "@ d0, " + at + ";", "to word");
        forms.add("ld" + name + ".{u8|s8|u16|s16|u32|s32|u64|s64|b64}", {"i64"}, {"b64"},
                  prepare + "@ d0, " + at + ";", "to double word");
        forms.add("ld" + name + ".v2.{u8|s8|u16|s16|u32|b32}", {"i64"}, {"b32", "b32"},
                  prepare + "@ {d0, d1}, " + at + ";");
        forms.add("ld" + name + ".v4.{u8|s8|u16|s16}", {"i64"}, {"b32", "b32", "b32", "b32"},
                  prepare + "@ {d0, d1, d2, d3}, " + at + ";");
        const std::string both =
            "st" + name + ".b64 " + at + ", a0; st" + name + ".b64 " + low + ", a1; ";
        const std::string back =
            "ld" + name + ".b64 d0, " + at + "; ld" + name + ".b64 d1, " + low + ";";
        forms.add("st" + name + ".{u8|u16|u32|b32|f32}", {"i64", "i64", "i32"}, {"b64", "b64"},
                  both + "@ " + at + ", a2; " + back);
        forms.add("st" + name + ".v2.{u8|u16|b32}", {"i64", "i64", "i32", "i32"}, {"b64", "b64"},
                  both + "@ " + at + ", {a2, a3}; " + back);
        forms.add("st" + name + ".v2.{b64|f64}", {"i64", "i64", "i64", "i64"}, {"b64", "b64"},
                  both + "@ " + at + ", {a2, a3}; " + back);
        forms.add("st" + name + ".v4.{u8|b32}", {"i64", "i64", "i32", "i32"}, {"b64", "b64"},
                  both + "@ " + at + ", {a2, a3, a2, a3}; " + back);
    }
    forms.add("ld.{volatile|relaxed.gpu|acquire.gpu|acquire.sys|relaxed.cta}.global.b32", {"i32"},
              {"b32"}, "st.global.b32 [m], a0; @ d0, [m];");
    forms.add("st.{volatile|relaxed.gpu|release.gpu|release.sys|relaxed.cta}.global.b32", {"i32"},
              {"b32"}, "@ [m], a0; ld.global.b32 d0, [m];");
    forms.add("ld.global.{ca|cg|cs|cv|lu}.b32", {"i32"}, {"b32"},
              "st.global.b32 [m], a0; @ d0, [m];");
    forms.add("cvta.shared.u64", {"i32"}, {"b32", "b32"},
              "@ u0, sm; st.b32 [u0], a0; ld.shared.b32 d0, [sm]; cvta.to.shared.u64 u1, u0; "
              "ld.shared.b32 d1, [u1];");
    forms.add("cvta.local.u64", {"i32"}, {"b32", "b32"},
              "@ u0, lm; st.b32 [u0], a0; ld.local.b32 d0, [lm]; cvta.to.local.u64 u1, u0; "
              "ld.local.b32 d1, [u1];");
    forms.add("isspacep.{global|shared|local|const}", {"i32"}, {"p", "p", "p"},
              "cvta.shared.u64 u0, sm; cvta.local.u64 u1, lm; cvta.global.u64 u2, m; "
              "st.global.b32 [m], a0; @ d0, u0; @ d1, u1; @ d2, u2;");
}

void addAtomics(Forms& forms) {
    for (const Space& space : kSpaces) {
        const std::string name = space.name;
        if (name == ".local")
            continue;
        const std::string at = std::string("[") + space.address + "]";
        // The old value and the new contents.
        const auto atomic = [&](const std::string& operation, const char* in, const Output& out,
                                bool reduces) {
            const std::string bits = std::to_string(widthOf(in));
            const std::string before = "st" + name + ".b" + bits + " " + at + ", a0; ";
            const std::string after = " ld.volatile" + name + ".b" + bits;
            forms.add("atom" + name + operation, {in, in}, {out, out},
                      before + "@ d0, " + at + ", a1;" + after + " d1, " + at + ";");
            if (reduces)
                forms.add("red" + name + operation, {in, in}, {out},
                          before + "@ " + at + ", a1;" + after + " d0, " + at + ";");
        };
        atomic(".{add.u32|add.s32|inc.u32|dec.u32|min.u32|max.u32|min.s32|max.s32|and.b32|or.b32|"
               "xor.b32}",
               "i32", "b32", true);
        atomic(".{add.u64|min.u64|max.u64|min.s64|max.s64|and.b64|or.b64|xor.b64}", "i64", "b64",
               true);
        atomic(".exch.b32", "i32", "b32", false);
        atomic(".exch.b64", "i64", "b64", false);
        atomic(".add.f32", "f32", {"f32", number()}, true);
        atomic(".add.f64", "f64", {"f64", number()}, true);
        for (const char* half : {"f16", "bf16", "f16x2", "bf16x2"})
            atomic(std::string(".add.noftz.") + half, half, {half, number()}, true);
        for (const std::string bits : {"16", "32", "64"}) {
            const std::string in = "i" + bits, out = "b" + bits;
            forms.add("atom" + name + ".cas.b" + bits, {in, in, in}, {out, out},
                      "st" + name + ".b" + bits + " " + at + ", a0; @ d0, " + at +
                          ", a1, a2; ld.volatile" + name + ".b" + bits + " d1, " + at + ";");
            forms.add("atom" + name + ".cas.b" + bits, {in, in}, {out, out},
                      "st" + name + ".b" + bits + " " + at + ", a0; @ d0, " + at +
                          ", a0, a1; ld.volatile" + name + ".b" + bits + " d1, " + at + ";",
                      "that hits");
        }
    }
    forms.add("atom.{relaxed|acquire|release|acq_rel}.{cta|gpu|sys}.global.add.u32", {"i32", "i32"},
              {"b32", "b32"},
              "st.global.b32 [m], a0; @ d0, [m], a1; ld.volatile.global.b32 d1, [m];");
    forms.add("atom.global.add.v2.f32", {"f32", "f32"}, {{"f32", number()}, {"f32", number()}},
              "st.global.b32 [m], a0; st.global.b32 [m+4], a1; @ {d0, d1}, [m], {a1, a0}; "
              "ld.volatile.global.b32 d0, [m]; ld.volatile.global.b32 d1, [m+4];");
    for (const char* half : {"f16x2", "bf16x2"})
        forms.add(std::string("atom.global.{add|min|max}.noftz.v2.") + half, {half, half},
                  {{half, number()}, {half, number()}},
                  "st.global.b32 [m], a0; st.global.b32 [m+4], a1; @ {d0, d1}, [m], {a1, a0}; "
                  "ld.volatile.global.b32 d0, [m]; ld.volatile.global.b32 d1, [m+4];");
}

// Numbers of 128 bits, in halves.
void addWideAccesses(Forms& forms) {
    const std::vector<std::string> four = {"i64", "i64", "i64", "i64"};
    const std::string declare = ".reg .b128 w<4>; ";
    forms.add("mov.b128", {"i64", "i64"}, {"b64", "b64"},
              declare + "mov.b128 w0, {a0, a1}; @ w1, w0; mov.b128 {d1, d0}, w1;");
    for (const Space& space : kSpaces) {
        const std::string name = space.name, address = space.address;
        const std::string at = "[" + address + "]", high = "[" + address + "+8]";
        const std::string before =
            declare + "st" + name + ".b64 " + at + ", a0; st" + name + ".b64 " + high + ", a1; ";
        const std::string after = " ld.volatile" + name + ".b64 d0, " + at + "; ld.volatile" +
                                  name + ".b64 d1, " + high + ";";
        forms.add("ld" + name + ".b128", {"i64", "i64"}, {"b64", "b64"},
                  before + "@ w0, " + at + "; mov.b128 {d0, d1}, w0;");
        forms.add("st" + name + ".b128", four, {"b64", "b64"},
                  before + "mov.b128 w0, {a2, a3}; @ " + at + ", w0;" + after);
        if (name == ".local")
            continue;
        const std::vector<Output> results = {"b64", "b64", "b64", "b64"};
        const std::string old = " mov.b128 {d2, d3}, w2;" + after;
        forms.add("atom" + name + ".exch.b128", four, results,
                  before + "mov.b128 w0, {a2, a3}; @ w2, " + at + ", w0;" + old);
        for (const std::string expected : {"{a0, a1}", "{a0, a2}", "{a2, a1}"})
            forms.add("atom" + name + ".cas.b128", four, results,
                      before + "mov.b128 w0, {a2, a3}; mov.b128 w1, " + expected + "; @ w2, " + at +
                          ", w1, w0;" + old,
                      "against " + expected);
    }
}

// Stack memory: its contents, its address, and its release.
void addStack(Forms& forms) {
    forms.add("alloca.u64", {"i32", "i32"}, {"b32", "b32", "b64"},
              "@ u0, 48, 16; @ u1, 16; st.local.b32 [u0+44], a0; st.local.b32 [u1], a1; "
              "st.local.b32 [u1+12], a1; cvta.local.u64 u2, u0; ld.b32 d0, [u2+44]; "
              "ld.local.b32 d1, [u1+12]; and.b64 d2, u0, 15;");
    forms.add("alloca.u64", {"i32", "i32"}, {"b32", "b32"},
              "and.b32 t0, a1, 240; add.u32 t0, t0, 16; cvt.u64.u32 u1, t0; @ u0, u1; "
              "@ u2, u1; add.u64 u3, u0, u1; st.local.b32 [u3+-4], a0; st.local.b32 [u2], a1; "
              "ld.local.b32 d0, [u3+-4]; ld.local.b32 d1, [u2];",
              "of a size in a register");
}

} // namespace

void addMemoryForms(Forms& forms) {
    addAccesses(forms);
    addAtomics(forms);
    addWideAccesses(forms);
    addStack(forms);
}

} // namespace conformance
