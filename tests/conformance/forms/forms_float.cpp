// SPDX-License-Identifier: Apache-2.0
// Forms of floating point arithmetic. Bounds of the .approx forms are those of the PTX ISA manual
// for one implementation, so two implementations may differ by twice the bound.
#include "forms/forms.h"

#include <cmath>

namespace conformance {

namespace {

const double kPi = 3.14159265358979323846;

const Rule kNumber = number();
const Rule kExact = Rule{};

void addArithmetic(Forms& forms) {
    const std::string round = "{|.rn|.rz|.rm|.rp}", always = "{.rn|.rz|.rm|.rp}";
    for (const std::string flush : {"", ".ftz"}) {
        Rule rule = kNumber;
        rule.flushEdge = !flush.empty();
        forms.add("{add|sub|mul}" + round + flush + "{|.sat}.f32", {"f32", "f32"}, {{"f32", rule}});
        forms.add("{mad|fma}" + always + flush + "{|.sat}.f32", {"f32", "f32", "f32"},
                  {{"f32", rule}});
        forms.add("div{.rn|.rz|.rm|.rp}" + flush + ".f32", {"f32", "f32"}, {{"f32", rule}});
        forms.add("{rcp|sqrt}" + always + flush + ".f32", {"f32"}, {{"f32", rule}});
    }
    forms.add("{add|sub|mul}" + round + ".f64", {"f64", "f64"}, {{"f64", kNumber}});
    forms.add("{mad|fma}" + always + ".f64", {"f64", "f64", "f64"}, {{"f64", kNumber}});
    forms.add("{add|sub|mul}" + round + "{|.ftz}.f32x2", {"i64", "i64"}, {"b64"});
    forms.add("fma" + always + "{|.ftz}.f32x2", {"i64", "i64", "i64"}, {"b64"});
    forms.add("div" + always + ".f64", {"f64", "f64"}, {{"f64", kNumber}});
    forms.add("{rcp|sqrt}" + always + ".f64", {"f64"}, {{"f64", kNumber}});
    for (const char* type : {"f16", "f16x2", "bf16", "bf16x2"}) {
        const bool brain = type[0] == 'b';
        const std::string flush = brain ? "" : "{|.ftz}", sat = brain ? "" : "{|.sat}";
        forms.add("{add|sub|mul}{|.rn}" + flush + sat + "." + type, {type, type},
                  {{type, kNumber}});
        forms.add("fma.rn" + flush + sat + "." + type, {type, type, type}, {{type, kNumber}});
        forms.add("fma.rn" + flush + ".relu." + type, {type, type, type}, {{type, kNumber}});
        forms.add("{abs|neg}" + flush + "." + type, {type}, {{type, kNumber}});
        forms.add("{min|max}" + flush + "{|.NaN}." + type, {type, type}, {{type, kExact}});
        forms.add("{min|max}" + flush + "{|.NaN}.xorsign.abs." + type, {type, type},
                  {{type, kExact}});
    }
}

void addSigns(Forms& forms) {
    forms.add("{abs|neg}{|.ftz}.f32", {"f32"}, {{"f32", kNumber}});
    forms.add("{abs|neg}.f64", {"f64"}, {{"f64", kNumber}});
    // A resulting NaN is the canonical one.
    forms.add("{min|max}{|.ftz}{|.NaN}{|.xorsign.abs}.f32", {"f32", "f32"}, {{"f32", kExact}});
    forms.add("{min|max}{|.ftz}{|.NaN}.f32", {"f32", "f32", "f32"}, {{"f32", kExact}}, "",
              "of three");
    forms.add("{min|max}.f64", {"f64", "f64"}, {{"f64", kNumber}});
    for (const char* value : {"0f00000000", "0f80000000", "0f3f800000", "0f7f800000", "0f7fc00000"})
        forms.add("{min|max}{|.ftz}.f32", {"f32"}, {{"f32", kExact}},
                  std::string("@ d0, a0, ") + value + ";", std::string("with ") + value);
    forms.add("copysign.f32", {"f32", "f32"}, {{"f32", kExact}});
    forms.add("copysign.f64", {"f64", "f64"}, {{"f64", kExact}});
    for (const char* type : {"f32", "f64"})
        forms.add(std::string("testp.{finite|infinite|number|notanumber|normal|subnormal}.") + type,
                  {type}, {"p"});
}

void addApproximations(Forms& forms) {
    const Rule ulp2 = within(Rule::kUlp, 4), ulp1 = within(Rule::kUlp, 2);
    // Past 2^126 a divisor's reciprocal is flushed: no bound is stated there.
    forms.add("div.approx{|.ftz}.f32", {"f32", "f32"},
              {{"f32", within(Rule::kUlp, 4, 1, 0x1p126)}});
    forms.add("div.full{|.ftz}.f32", {"f32", "f32"}, {{"f32", ulp2}});
    forms.add("rcp.approx{|.ftz}.f32", {"f32"}, {{"f32", ulp1}});
    forms.add("sqrt.approx{|.ftz}.f32", {"f32"}, {{"f32", within(Rule::kRelative, 0x1p-22)}});
    forms.add("rsqrt.approx{|.ftz}.f32", {"f32"},
              {{"f32", within(Rule::kRelative, 2 * std::exp2(-22.9))}});
    forms.add("rsqrt.approx{|.ftz}.f64", {"f64"}, {{"f64", within(Rule::kRelative, 0x1p-20)}});
    forms.add("rcp.approx.ftz.f64", {"f64"}, {{"f64", within(Rule::kRelative, 0x1p-19)}});
    forms.add("{sin|cos}.approx{|.ftz}.f32", {"arg"},
              {{"f32", within(Rule::kAbsolute, 2 * std::exp2(-20.5), 0, 2 * kPi)}}, "", "near");
    forms.add("{sin|cos}.approx{|.ftz}.f32", {"arg"},
              {{"f32", within(Rule::kAbsolute, 2 * std::exp2(-14.7), 0, 100 * kPi)}}, "", "far");
    forms.add("ex2.approx{|.ftz}.f32", {"arg"}, {{"f32", within(Rule::kUlp, 4)}});
    forms.add("ex2.approx{|.ftz}.f32", {"f32"}, {{"f32", within(Rule::kUlp, 4)}}, "", "anywhere");
    // Absolute near 1, relative elsewhere.
    forms.add("lg2.approx{|.ftz}.f32", {"f32"}, {{"f32", within(Rule::kMixed, 0x1p-21)}}, "",
              "anywhere");
    forms.add("lg2.approx{|.ftz}.f32", {"arg"}, {{"f32", within(Rule::kMixed, 0x1p-21)}}, "",
              "moderate");
    forms.add("tanh.approx.f32", {"arg"}, {{"f32", within(Rule::kRelative, 0x1p-10)}});
    for (const char* type : {"f16", "f16x2"}) {
        forms.add(std::string("ex2.approx.") + type, {type},
                  {{type, within(Rule::kRelative, 2 * std::exp2(-9.9))}});
        forms.add(std::string("tanh.approx.") + type, {type},
                  {{type, within(Rule::kAbsolute, 2 * std::exp2(-10.987))}});
    }
    for (const char* type : {"bf16", "bf16x2"}) {
        forms.add(std::string("ex2.approx.ftz.") + type, {type},
                  {{type, within(Rule::kRelative, 0x1p-6)}});
        forms.add(std::string("tanh.approx.") + type, {type},
                  {{type, within(Rule::kAbsolute, 0x1p-7)}});
    }
}

} // namespace

void addFloatForms(Forms& forms) {
    addArithmetic(forms);
    addSigns(forms);
    addApproximations(forms);
}

} // namespace conformance
