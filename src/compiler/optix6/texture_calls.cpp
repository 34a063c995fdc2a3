// SPDX-License-Identifier: Apache-2.0
#include "compiler/optix6/texture_calls.h"

namespace sunstone::compiler::optix6 {

namespace {

// Coordinates of a kind of lookup (rtiTexLookupKind), in registers x, y, z and layer. Textures of
// one dimension are rows: `row` is the centre of one, `none` is no gradient across.
struct Lookup {
    unsigned kind;
    const char* geometry;
    const char* coordinates;
    const char* dx; // gradients; null: the kind has none
    const char* dy;
};
constexpr Lookup kLookups[] = {
    {1, "2d", "{x, row}", "{ax, none}", "{bx, none}"},
    {2, "2d", "{x, y}", "{ax, ay}", "{bx, by}"},
    {3, "3d", "{x, y, z, z}", "{ax, ay, az, az}", "{bx, by, bz, bz}"},
    {4, "a1d", "{layer, x}", "{ax}", "{bx}"},
    {5, "a2d", "{layer, x, y, y}", "{ax, ay}", "{bx, by}"},
    {6, "cube", "{x, y, z, z}", nullptr, nullptr},
    {7, "acube", "{layer, x, y, z}", nullptr, nullptr},
};

std::string results(const char* type, unsigned count) {
    std::string list;
    for (unsigned i = 0; i < count; ++i)
        list += std::string(i ? ", " : "") + ".reg ." + type + " r" + std::to_string(i);
    return list;
}

// A function that chooses by `dim` among the lookups up to `last`.
struct Form {
    const char* name;
    const char* result; // type of the four results and of the instruction's
    const char* parameters;
    const char* coordinate; // type
    const char* modifier;   // of the instruction
    unsigned last;
    bool hasLevel, hasGradient;
};

std::string define(const Form& form) {
    std::string text = ".func (" + results(form.result, 4) + ") " +
                       std::string(kTextureCallPrefix) + form.name + "_id (.reg .b32 id, " +
                       ".reg .b32 dim, " + form.parameters + ")\n{\n.reg .b64 h;\n.reg .pred p;\n" +
                       "call (h), _rt_texture_handle, (id);\n" +
                       "mov.b32 r0, 0;\nmov.b32 r1, 0;\nmov.b32 r2, 0;\nmov.b32 r3, 0;\n" +
                       ".reg .b32 row, none;\nmov.b32 none, 0;\nmov.b32 row, " +
                       (form.coordinate == std::string_view("f32") ? "0f3F000000" : "0") + ";\n";
    for (const Lookup& lookup : kLookups) {
        if (lookup.kind > form.last || (form.hasGradient && !lookup.dx))
            continue;
        text += "setp.eq.u32 p, dim, " + std::to_string(lookup.kind) + ";\n@p tex." +
                form.modifier + lookup.geometry + ".v4." + form.result + "." + form.coordinate +
                " {r0, r1, r2, r3}, [h, " + lookup.coordinates + "]" +
                (form.hasLevel ? ", level" : "") +
                (form.hasGradient ? std::string(", ") + lookup.dx + ", " + lookup.dy : "") + ";\n";
    }
    return text + "ret;\n}\n";
}

std::string defineGather() {
    std::string text = ".func (" + results("f32", 4) + ") " + std::string(kTextureCallPrefix) +
                       "gather_id (.reg .b32 id, .reg .f32 x, .reg .f32 y, .reg .b32 comp)\n" +
                       "{\n.reg .b64 h;\n.reg .pred p;\ncall (h), _rt_texture_handle, (id);\n" +
                       "mov.b32 r0, 0;\nmov.b32 r1, 0;\nmov.b32 r2, 0;\nmov.b32 r3, 0;\n";
    constexpr const char* kComponents[] = {"r", "g", "b", "a"};
    for (unsigned i = 0; i < 4; ++i)
        text += "setp.eq.u32 p, comp, " + std::to_string(i) + ";\n@p tld4." + kComponents[i] +
                ".2d.v4.f32.f32 {r0, r1, r2, r3}, [h, {x, y}];\n";
    return text + "ret;\n}\n";
}

std::string defineSize() {
    return ".func (" + results("b32", 3) + ") " + std::string(kTextureCallPrefix) +
           "size_id (.reg .b32 id)\n{\n.reg .b64 h;\ncall (h), _rt_texture_handle, (id);\n" +
           "txq.width.b32 r0, [h];\ntxq.height.b32 r1, [h];\ntxq.depth.b32 r2, [h];\n" +
           // GPUs return 0 for dimensions that the texture lacks.
           "max.u32 r1, r1, 1;\nmax.u32 r2, r2, 1;\nret;\n}\n";
}

constexpr const char* kPosition = ".reg .f32 x, .reg .f32 y, .reg .f32 z, .reg .b32 layer";
constexpr const char* kFourFloats = ".reg .f32 x, .reg .f32 y, .reg .f32 z, .reg .f32 w";

std::string allFunctions() {
    const std::string level = std::string(kPosition) + ", .reg .f32 level";
    const std::string gradient = std::string(kPosition) +
                                 ", .reg .f32 ax, .reg .f32 ay, .reg .f32 az, .reg .f32 bx, "
                                 ".reg .f32 by, .reg .f32 bz";
    const Form forms[] = {
        {"base", "f32", kPosition, "f32", "", 7, false, false},
        {"level", "f32", level.c_str(), "f32", "level.", 7, true, false},
        {"grad", "f32", gradient.c_str(), "f32", "grad.", 5, false, true},
        {"f", "f32", kFourFloats, "f32", "", 3, false, false},
        {"i", "s32", kFourFloats, "f32", "", 3, false, false},
        {"u", "u32", kFourFloats, "f32", "", 3, false, false},
        {"fetch", "f32", ".reg .s32 x, .reg .s32 y, .reg .s32 z, .reg .s32 w", "s32", "", 3, false,
         false},
    };
    std::string text = "\n" + defineSize() + defineGather();
    for (const Form& form : forms)
        text += define(form);
    return text;
}

} // namespace

std::string textureFunctionsFor(std::string_view text) {
    return text.find(kTextureCallPrefix) == std::string_view::npos ? std::string() : allFunctions();
}

} // namespace sunstone::compiler::optix6
