// SPDX-License-Identifier: Apache-2.0
// Forms of cvt and of mov between vectors and scalars.
#include "forms/forms.h"

namespace conformance {

namespace {

const char* const kInts[] = {"u8", "s8", "u16", "s16", "u32", "s32", "u64", "s64"};

// The register type of an integer: 8-bit integers are in 16-bit registers.
std::string inputOf(const std::string& type) {
    return type.ends_with("8") ? "i16" : "i" + type.substr(1);
}
std::string outputOf(const std::string& type) {
    return type.ends_with("8") ? "b16" : "b" + type.substr(1);
}

// Whether every number of type `from` is a number of type `to`.
bool holds(const std::string& to, const std::string& from) {
    const int toBits = std::stoi(to.substr(1)), fromBits = std::stoi(from.substr(1));
    return to[0] == from[0] ? toBits >= fromBits : to[0] == 's' && toBits > fromBits;
}

void addScalars(Forms& forms) {
    const std::string roundInt = "{.rni|.rzi|.rmi|.rpi}", round = "{.rn|.rz|.rm|.rp}";
    for (const std::string to : kInts)
        for (const std::string from : kInts) {
            const std::string sat = holds(to, from) ? "" : "{|.sat}";
            forms.add("cvt" + sat + "." + to + "." + from, {inputOf(from)}, {outputOf(to)});
            if (to.ends_with("8") || to.ends_with("16")) // into a wider register
                forms.add("cvt" + sat + "." + to + "." + from, {inputOf(from)}, {"b32"}, "",
                          "widened");
        }
    for (const std::string type : kInts) {
        const std::string in = inputOf(type), out = outputOf(type);
        forms.add("cvt" + roundInt + "{|.ftz}{|.sat}." + type + ".f32", {"f32"}, {out});
        forms.add("cvt" + roundInt + "{|.sat}." + type + ".f64", {"f64"}, {out});
        forms.add("cvt" + roundInt + "{|.sat}." + type + ".f16", {"f16"}, {out});
        if (!type.ends_with("8"))
            forms.add("cvt" + roundInt + "." + type + ".bf16", {"bf16"}, {out});
        for (const char* to : {"f32", "f64", "f16"})
            forms.add("cvt" + round + "{|.sat}." + to + "." + type, {in}, {{to, number()}});
        if (!type.ends_with("8"))
            forms.add("cvt" + round + ".bf16." + type, {in}, {{"bf16", number()}});
    }
    forms.add("cvt" + round + "{|.ftz}{|.sat}.f32.f64", {"f64"}, {{"f32", number()}});
    forms.add("cvt{|.ftz}{|.sat}.f64.f32", {"f32"}, {{"f64", number()}});
    forms.add("cvt" + round + "{|.ftz}{|.sat}.f16.f32", {"f32"}, {{"f16", number()}});
    forms.add("cvt" + round + "{|.sat}.f16.f64", {"f64"}, {{"f16", number()}});
    forms.add("cvt{|.ftz}{|.sat}.f32.f16", {"f16"}, {{"f32", number()}});
    forms.add("cvt{|.sat}.f64.f16", {"f16"}, {{"f64", number()}});
    forms.add("cvt{|.ftz}.f32.bf16", {"bf16"}, {{"f32", number()}});
    forms.add("cvt.f64.bf16", {"bf16"}, {{"f64", number()}});
    forms.add("cvt{.rn|.rz|.rm|.rp}.bf16.f64", {"f64"}, {{"bf16", number()}});
    forms.add("cvt{.rn|.rz|.rm|.rp}.bf16.f16", {"f16"}, {{"bf16", number()}});
    forms.add("cvt{.rn|.rz|.rm|.rp}.f16.bf16", {"bf16"}, {{"f16", number()}});
    forms.add("cvt{|.rni|.rzi|.rmi|.rpi}{|.ftz}{|.sat}.f32.f32", {"f32"}, {{"f32", number()}});
    forms.add("cvt{|.rni|.rzi|.rmi|.rpi}{|.sat}.f64.f64", {"f64"}, {{"f64", number()}});
    forms.add("cvt{.rni|.rzi|.rmi|.rpi}{|.sat}.f16.f16", {"f16"}, {{"f16", number()}});
    forms.add("cvt{.rni|.rzi|.rmi|.rpi}.bf16.bf16", {"bf16"}, {{"bf16", number()}});
    // With .relu and .satfinite the resulting NaN is the canonical one.
    forms.add("cvt{.rn|.rz}{.relu|.satfinite|.relu.satfinite}.{f16|bf16}.f32", {"f32"}, {"b16"});
    forms.add("cvt{.rn|.rz}.bf16.f32", {"f32"}, {"b16"});
}

void addPacked(Forms& forms) {
    forms.add("cvt{.rn|.rz}{.relu|.satfinite|.relu.satfinite}.{f16x2|bf16x2}.f32", {"f32", "f32"},
              {"b32"});
    forms.add("cvt{.rn|.rz}.f16x2.f32", {"f32", "f32"}, {{"f16x2", number()}});
    forms.add("cvt{.rn|.rz}.bf16x2.f32", {"f32", "f32"}, {"b32"});
    forms.add("cvt.rs{|.relu}{|.satfinite}.{f16x2|bf16x2}.f32", {"f32", "f32", "i32"}, {"b32"});
    forms.add("cvt.rna{|.satfinite}.tf32.f32", {"f32"}, {"b32"});
    forms.add("cvt{.rn|.rz}{|.relu}{|.satfinite}.tf32.f32", {"f32"}, {"b32"});
    forms.add("cvt.rn.satfinite{|.relu}.{e4m3x2|e5m2x2}.f32", {"f32", "f32"}, {"b16"});
    forms.add("cvt.rn.satfinite{|.relu}.{e4m3x2|e5m2x2}.f16x2", {"f16x2"}, {"b16"});
    forms.add("cvt.rn{|.relu}.f16x2.{e4m3x2|e5m2x2}", {"i16"}, {"b32"});
    forms.add("cvt.rn.satfinite{|.relu}.{e2m3x2|e3m2x2}.f32", {"f32", "f32"}, {"b16"});
    forms.add("cvt.rn{|.relu}.f16x2.{e2m3x2|e3m2x2}", {"i16"}, {"b32"});
    forms.add("cvt{.rz|.rp}{|.satfinite}.ue8m0x2.f32", {"f32", "f32"}, {"b16"});
    forms.add("cvt{.rz|.rp}{|.satfinite}.ue8m0x2.bf16x2", {"bf16x2"}, {"b16"});
    forms.add("cvt.rn.bf16x2.ue8m0x2", {"i16"}, {"b32"});
    forms.add("cvt.pack.sat.{u16|s16}.s32", {"i32", "i32"}, {"b32"});
    forms.add("cvt.pack.sat.{u8|s8|u4|s4|u2|s2}.s32.b32", {"i32", "i32", "i32"}, {"b32"});
}

void addMoves(Forms& forms) {
    forms.add("mov.b32", {"i16", "i16"}, {"b32"}, "@ d0, {a0, a1};", "of two halves");
    forms.add("mov.b32", {"i32"}, {"b16", "b16"}, "@ {d0, d1}, a0;", "into halves");
    forms.add("mov.b64", {"i32", "i32"}, {"b64"}, "@ d0, {a0, a1};", "of two words");
    forms.add("mov.b64", {"i64"}, {"b32", "b32"}, "@ {d0, d1}, a0;", "into words");
    forms.add("mov.b64", {"i16", "i16", "i16", "i16"}, {"b64"}, "@ d0, {a0, a1, a2, a3};",
              "of four halves");
    forms.add("mov.b64", {"i64"}, {"b16", "b16", "b16", "b16"}, "@ {d0, d1, d2, d3}, a0;",
              "into four halves");
    forms.add("mov.{b16|u16|s16}", {"i16"}, {"b16"});
    forms.add("mov.{b32|u32|s32|f32}", {"i32"}, {"b32"});
    forms.add("mov.{b64|u64|s64|f64}", {"i64"}, {"b64"});
    forms.add("mov.pred", {"p"}, {"p"});
    forms.add("mov.f32", {"i32"}, {"b32"}, "@ t0, 1.5; xor.b32 d0, t0, a0;", "of a decimal");
    forms.add("mov.f64", {"i64"}, {"b64"}, "@ u0, -2.25e3; xor.b64 d0, u0, a0;", "of a decimal");
}

} // namespace

void addConversionForms(Forms& forms) {
    addScalars(forms);
    addPacked(forms);
    addMoves(forms);
}

} // namespace conformance
