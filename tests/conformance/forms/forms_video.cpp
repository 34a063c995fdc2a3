// SPDX-License-Identifier: Apache-2.0
// Forms of the video instructions: scalar ones with their selectors and second operations, and
// those on halves and bytes.
#include "forms/forms.h"

namespace conformance {

namespace {

void addScalar(Forms& forms) {
    const std::string signs = "{u32|s32}";
    forms.add("{vadd|vsub|vabsdiff|vmin|vmax}." + signs + "." + signs + "." + signs + "{|.sat}",
              {"i32", "i32"}, {"b32"});
    const std::vector<std::pair<std::string, std::string>> kSelectors = {
        {".b0", ".b3"}, {".b2", ".h1"}, {".h0", ""}, {"", ".b1"}};
    for (const auto& [a, b] : kSelectors)
        forms.add("{vadd|vsub|vabsdiff|vmin|vmax}.s32." + signs + "." + signs + "{|.sat}",
                  {"i32", "i32"}, {"b32"}, "@ d0, a0" + a + ", a1" + b + ";",
                  "of" + a + " and" + b);
    forms.add("{vadd|vsub|vabsdiff|vmin|vmax}.u32.s32.u32.{add|min|max}", {"i32", "i32", "i32"},
              {"b32"});
    forms.add("{vadd|vsub|vabsdiff|vmin|vmax}.s32.s32.s32.sat.{add|min|max}", {"i32", "i32", "i32"},
              {"b32"});
    for (const std::string part : {".b0", ".b2", ".h0", ".h1"})
        forms.add("{vadd|vsub|vabsdiff}.{u32|s32}.u32.s32{|.sat}", {"i32", "i32", "i32"}, {"b32"},
                  "@ d0" + part + ", a0, a1, a2;", "into " + part);
    forms.add("{vshl|vshr}.{u32|s32}.{u32|s32}.u32{|.sat}.{clamp|wrap}", {"i32", "sh"}, {"b32"});
    forms.add("{vshl|vshr}.u32.u32.u32.{clamp|wrap}.{add|min|max}", {"i32", "sh", "i32"}, {"b32"});
    forms.add("vmad.{u32|s32}.{u32|s32}.{u32|s32}{|.sat}{|.shr7|.shr15}", {"i32", "i32", "i32"},
              {"b32"}, "@ d0, a0.b0, a1.h1, a2;");
    forms.add("vmad.s32.s32.s32{|.sat}{|.shr7|.shr15}", {"i32", "i32", "i32"}, {"b32"},
              "@ d0, a0.h0, a1.h1, -a2;", "less");
    forms.add("vset.{u32|s32}.{u32|s32}.{eq|ne|lt|le|gt|ge}", {"i32", "i32"}, {"b32"});
    forms.add("vset.u32.u32.lt.{add|min|max}", {"i32", "i32", "i32"}, {"b32"});
}

void addPacked(Forms& forms) {
    for (const std::string n : {"2", "4"}) {
        forms.add("{vadd" + n + "|vsub" + n + "|vavrg" + n + "|vabsdiff" + n + "|vmin" + n +
                      "|vmax" + n + "}.{u32|s32}.{u32|s32}.{u32|s32}{|.sat}",
                  {"i32", "i32", "i32"}, {"b32"});
        forms.add("{vadd" + n + "|vsub" + n + "|vavrg" + n + "|vabsdiff" + n + "|vmin" + n +
                      "|vmax" + n + "}.{u32|s32}.{u32|s32}.{u32|s32}.add",
                  {"i32", "i32", "i32"}, {"b32"});
        forms.add("vset" + n + ".{u32|s32}.{u32|s32}.{eq|ne|lt|le|gt|ge}{|.add}",
                  {"i32", "i32", "i32"}, {"b32"});
    }
    forms.add("{vadd2|vsub2}.s32.s32.s32", {"i32", "i32", "i32"}, {"b32"},
              "@ d0.h1, a0.h01, a1.h32, a2;", "picked");
    forms.add("{vadd4|vsub4}.s32.s32.s32", {"i32", "i32", "i32"}, {"b32"},
              "@ d0.b20, a0.b0123, a1.b7654, a2;", "picked");
}

} // namespace

void addVideoForms(Forms& forms) {
    addScalar(forms);
    addPacked(forms);
}

} // namespace conformance
