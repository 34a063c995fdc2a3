// SPDX-License-Identifier: Apache-2.0
// PTX around one sampling or surface instruction. See texture_cases.h.
#include "textures/texture_cases.h"

namespace conformance {

namespace {

std::string coordinatesOf(const TextureCase& test, const char* const names[3]) {
    const std::string x = names[0], y = names[1], z = names[2];
    if (test.has(".acube"))
        return "{layer, " + x + ", " + y + ", " + z + "}";
    if (test.has(".3d") || test.has("cube"))
        return "{" + x + ", " + y + ", " + z + ", " + z + "}";
    if (test.has(".a2d"))
        return "{layer, " + x + ", " + y + ", " + y + "}";
    if (test.has(".a1d"))
        return "{layer, " + x + "}";
    return test.has(".2d") ? "{" + x + ", " + y + "}" : "{" + x + "}";
}

std::string gradient(const TextureCase& test, const std::string& n) {
    if (test.has(".3d") || test.has("cube"))
        return "{g" + n + "x, g" + n + "y, g" + n + "z, g" + n + "z}";
    if (test.has(".2d") || test.has(".a2d"))
        return "{g" + n + "x, g" + n + "y}";
    return "{g" + n + "x}";
}

std::string sampling(const TextureCase& test) {
    const char* const names[3] = {"x", "y", "z"};
    const bool half = test.has(".v4.f16.");
    std::string code = half ? ".reg .b16 r<4>;\n" : "";
    code += test.access + (half ? " {r0, r1, r2, r3}" : " {d0, d1, d2, d3}") + ", [handle, " +
            coordinatesOf(test, names) + "]";
    if (test.has(".level."))
        code += ", level";
    if (test.has(".grad."))
        code += ", " + gradient(test, "a") + ", " + gradient(test, "b");
    code += ";\n";
    for (unsigned i = 0; half && i < 4; ++i)
        code += "cvt.u32.u16 d" + std::to_string(i) + ", r" + std::to_string(i) + ";\n";
    return code;
}

// Registers r0.. of the access, as one operand.
std::string surfaceValues(unsigned count) {
    std::string values = "r0";
    for (unsigned i = 1; i < count; ++i)
        values += ", r" + std::to_string(i);
    return count == 1 ? values : "{" + values + "}";
}

std::string surface(const TextureCase& test) {
    const char* const names[3] = {"x", "y", "z"};
    const std::string place = "[handle, " + coordinatesOf(test, names) + "]";
    if (test.has("sured.p")) { // counts words, the load bytes
        const std::string change = test.has(".b64.") ? ".reg .b64 w;\nmov.b64 w, {level, gax};\n" +
                                                           test.access + " " + place + ", w;\n"
                                                     : test.access + " " + place + ", level;\n";
        return change + "bar.sync 0;\nmul.lo.u32 t, x, " + std::to_string(test.format.bytes) +
               ";\nsuld.b.2d." + (test.has(".b64.") ? "v2.b32.zero {d0, d1}" : "b32.zero d0") +
               ", [handle, {t, y}];\n";
    }
    if (test.has("sured"))
        return test.access + " " + place + ", level;\nbar.sync 0;\nsuld.b.2d.b32.zero d0, " +
               place + ";\n";
    const unsigned count = test.has(".v4.") ? 4 : test.has(".v2.") ? 2 : 1;
    const unsigned bits = test.has("b64") ? 64 : test.has("b32") ? 32 : 16;
    const std::string type = ".b" + std::to_string(bits);
    std::string code = ".reg " + type + " r<4>;\n";
    const std::string words[4] = {"level", "gax", "gay", "gaz"};
    if (test.has("sust")) {
        for (unsigned i = 0; i < count; ++i) {
            const std::string n = std::to_string(i);
            if (bits == 64)
                code += "mov.b64 r" + n + ", {" + words[2 * i] + ", " + words[2 * i + 1] + "};\n";
            else if (bits == 32)
                code += "mov.b32 r" + n + ", " + words[i] + ";\n";
            else
                code += "cvt.u16.u32 r" + n + ", " + words[i] + ";\n";
        }
        code += test.access + " " + place + ", " + surfaceValues(count) + ";\n";
    }
    if (test.has("sust.p")) { // read the texel's bytes
        const unsigned bytes = test.format.bytes;
        std::string load = bytes == 16  ? "v4.b32"
                           : bytes == 8 ? "v2.b32"
                                        : "b" + std::to_string(bytes * 8);
        const std::string at = "[handle, {t, y}]";
        code += "mul.lo.u32 t, x, " + std::to_string(bytes) + ";\n";
        if (bytes >= 4)
            return code + "suld.b.2d." + load + ".zero " +
                   (bytes == 16  ? "{d0, d1, d2, d3}"
                    : bytes == 8 ? "{d0, d1}"
                                 : "d0") +
                   ", " + at + ";\n";
        return code + ".reg .b16 s0;\nsuld.b.2d." + load + ".zero s0, " + at +
               ";\ncvt.u32.u16 d0, s0;\n";
    }
    std::string load = test.access;
    load.replace(0, 4, "suld");
    code += load + " " + surfaceValues(count) + ", " + place + ";\n";
    for (unsigned i = 0; i < count; ++i) {
        const std::string n = std::to_string(i);
        if (bits == 64)
            code += "mov.b64 {d" + std::to_string(2 * i) + ", d" + std::to_string(2 * i + 1) +
                    "}, r" + n + ";\n";
        else if (bits == 32)
            code += "mov.b32 d" + n + ", r" + n + ";\n";
        else
            code += "cvt.u32.u16 d" + n + ", r" + n + ";\n";
    }
    return code;
}

} // namespace

std::string textureKernel(const TextureCase& test) {
    std::string code =
        ".version 8.7\n.target sm_90\n.address_size 64\n"
        ".visible .entry k(.param .u64 p0, .param .u64 p1, .param .u64 p2) {\n"
        ".reg .b64 handle, in, out, wide;\n"
        ".reg .b32 x, y, z, layer, level, gax, gay, gaz, gbx, gby, gbz, d<4>, i, t;\n"
        "ld.param.u64 handle, [p0];\nld.param.u64 in, [p1];\nld.param.u64 out, [p2];\n"
        "mov.u32 i, %ctaid.x;\nshl.b32 i, i, 5;\nmov.u32 t, %tid.x;\nadd.u32 i, i, t;\n"
        "mul.wide.u32 wide, i, 48;\nadd.u64 in, in, wide;\n"
        "mul.wide.u32 wide, i, 16;\nadd.u64 out, out, wide;\n";
    const char* const kWords[] = {"x",   "y",   "z",   "layer", "level", "gax",
                                  "gay", "gaz", "gbx", "gby",   "gbz"};
    for (unsigned k = 0; k < std::size(kWords); ++k)
        code +=
            std::string("ld.global.b32 ") + kWords[k] + ", [in+" + std::to_string(4 * k) + "];\n";
    for (unsigned k = 0; k < 4; ++k)
        code += "mov.b32 d" + std::to_string(k) + ", 0;\n";
    if (test.access.starts_with("txq"))
        code += test.access + " d0, [handle];\n";
    else
        code += test.isSurface() ? surface(test) : sampling(test);
    return code + "st.global.v4.b32 [out], {d0, d1, d2, d3};\nret;\n}\n";
}

} // namespace conformance
