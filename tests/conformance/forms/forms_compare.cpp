// SPDX-License-Identifier: Apache-2.0
// Forms of setp, set, selp and slct.
#include "forms/forms.h"

namespace conformance {

namespace {

const char* const kInts[] = {"u16", "s16", "u32", "s32", "u64", "s64"};
const std::string kFloatCompare = "{eq|ne|lt|le|gt|ge|equ|neu|ltu|leu|gtu|geu|num|nan}";
const std::string kBool = "{and|or|xor}";

std::string inputOf(const std::string& type) {
    return "i" + type.substr(1);
}

std::string compareOf(const std::string& type) {
    return type[0] == 'u' ? "{eq|ne|lt|le|gt|ge|lo|ls|hi|hs}" : "{eq|ne|lt|le|gt|ge}";
}

void addIntegers(Forms& forms) {
    for (const std::string type : kInts) {
        const std::string in = inputOf(type), compare = compareOf(type);
        forms.add("setp." + compare + "." + type, {in, in}, {"p", "p"}, "@ d0|d1, a0, a1;");
        forms.add("setp." + compare + "." + kBool + "." + type, {in, in, "p"}, {"p", "p"},
                  "@ d0|d1, a0, a1, a2;");
        for (const std::string to : {"u32", "s32", "f32"})
            forms.add("set." + compare + "." + to + "." + type, {in, in}, {"b32"});
        forms.add("set." + compare + "." + kBool + ".u32." + type, {in, in, "p"}, {"b32"});
        forms.add("set.{eq|ge}." + kBool + ".f32." + type, {in, in, "p"}, {"b32"});
        forms.add("set.{eq|ge}.{f16|bf16}." + type, {in, in}, {"b16"});
    }
    for (const std::string bits : {"16", "32", "64"}) {
        const std::string in = "i" + bits;
        forms.add("setp.{eq|ne}.b" + bits, {in, in}, {"p", "p"}, "@ d0|d1, a0, a1;");
        forms.add("setp.{eq|ne}." + kBool + ".b" + bits, {in, in, "p"}, {"p", "p"},
                  "@ d0|d1, a0, a1, a2;");
        forms.add("set.{eq|ne}.{u32|s32|f32}.b" + bits, {in, in}, {"b32"});
    }
    forms.add("setp.lt.and.s32", {"i32", "i32", "p"}, {"p"}, "@ d0, a0, a1, !a2;", "with not");
}

void addFloats(Forms& forms) {
    for (const std::string type : {"f32", "f64", "f16", "bf16"}) {
        const std::string flush = type == "f32" || type == "f16" ? "{|.ftz}" : "";
        const bool half = type == "f16" || type == "bf16"; // no second predicate
        const std::vector<Output> results =
            half ? std::vector<Output>{"p"} : std::vector<Output>{"p", "p"};
        const std::string target = half ? "@ d0" : "@ d0|d1";
        forms.add("setp." + kFloatCompare + flush + "." + type, {type, type}, results,
                  target + ", a0, a1;");
        forms.add("setp." + kFloatCompare + "." + kBool + flush + "." + type, {type, type, "p"},
                  results, target + ", a0, a1, a2;");
        for (const std::string to : {"u32", "s32"})
            forms.add("set." + kFloatCompare + flush + "." + to + "." + type, {type, type},
                      {"b32"});
        forms.add("set.{lt|geu|nan}." + kBool + flush + ".u32." + type, {type, type, "p"}, {"b32"});
        if (half) {
            forms.add("set." + kFloatCompare + flush + ".{u16|s16|" + type + "}." + type,
                      {type, type}, {"b16"});
        } else {
            forms.add("set." + kFloatCompare + flush + ".f32." + type, {type, type}, {"b32"});
            forms.add("set.{lt|geu}." + kBool + flush + ".f32." + type, {type, type, "p"}, {"b32"});
        }
        if (type == "f16")
            forms.add("set.{eq|lt|geu|num}.bf16.f16", {type, type}, {"b16"});
        else if (!half)
            forms.add("set.{eq|lt|geu|num}.{f16|bf16}." + type, {type, type}, {"b16"});
    }
    for (const std::string type : {"f16x2", "bf16x2"}) {
        const std::string flush = type == "f16x2" ? "{|.ftz}" : "";
        forms.add("setp." + kFloatCompare + flush + "." + type, {type, type}, {"p", "p"},
                  "@ d0|d1, a0, a1;");
        forms.add("setp." + kFloatCompare + "." + kBool + flush + "." + type, {type, type, "p"},
                  {"p", "p"}, "@ d0|d1, a0, a1, a2;");
        forms.add("set." + kFloatCompare + flush + "." + type + "." + type, {type, type}, {"b32"});
        forms.add("set.{eq|lt|geu}." + kBool + flush + "." + type + "." + type, {type, type, "p"},
                  {"b32"});
    }
}

} // namespace

void addComparisonForms(Forms& forms) {
    addIntegers(forms);
    addFloats(forms);
    const struct {
        const char *name, *in, *out;
    } kTypes[] = {{"u16", "i16", "b16"}, {"s16", "i16", "b16"}, {"b16", "i16", "b16"},
                  {"u32", "i32", "b32"}, {"s32", "i32", "b32"}, {"b32", "i32", "b32"},
                  {"u64", "i64", "b64"}, {"s64", "i64", "b64"}, {"b64", "i64", "b64"},
                  {"f32", "f32", "b32"}, {"f64", "f64", "b64"}};
    for (const auto& t : kTypes) {
        const std::string type = t.name;
        forms.add("selp." + type, {t.in, t.in, "p"}, {t.out});
        forms.add("slct." + type + ".s32", {t.in, t.in, "i32"}, {t.out});
        forms.add("slct{|.ftz}." + type + ".f32", {t.in, t.in, "f32"}, {t.out});
    }
}

} // namespace conformance
