// SPDX-License-Identifier: Apache-2.0
// The list of textures and surfaces, and of the instructions that read them. See texture_cases.h.
#include "textures/texture_cases.h"

namespace conformance {

namespace {

const TextureFormat kInt8x4 = {"u8x4", 1, 4, 'u', 4};
const TextureFormat kFloat4 = {"f32x4", 32, 4, 'f', 16};
const TextureFormat kFloat1 = {"f32", 32, 1, 'f', 4};

std::vector<TextureFormat> plainFormats() {
    return {{"u8", 1, 1, 'u', 1},
            {"u8x2", 1, 2, 'u', 2},
            kInt8x4,
            {"u16", 2, 1, 'u', 2},
            {"u16x2", 2, 2, 'u', 4},
            {"u16x4", 2, 4, 'u', 8},
            {"u32", 3, 1, 'u', 4},
            {"u32x2", 3, 2, 'u', 8},
            {"u32x4", 3, 4, 'u', 16},
            {"s8", 8, 1, 's', 1},
            {"s8x2", 8, 2, 's', 2},
            {"s8x4", 8, 4, 's', 4},
            {"s16", 9, 1, 's', 2},
            {"s16x2", 9, 2, 's', 4},
            {"s16x4", 9, 4, 's', 8},
            {"s32", 10, 1, 's', 4},
            {"s32x2", 10, 2, 's', 8},
            {"s32x4", 10, 4, 's', 16},
            {"f16", 16, 1, 'h', 2},
            {"f16x2", 16, 2, 'h', 4},
            {"f16x4", 16, 4, 'h', 8},
            kFloat1,
            {"f32x2", 32, 2, 'f', 8},
            kFloat4,
            {"unorm8", 0xc0, 1, 'n', 1},
            {"unorm8x2", 0xc1, 2, 'n', 2},
            {"unorm8x4", 0xc2, 4, 'n', 4},
            {"unorm16", 0xc3, 1, 'n', 2},
            {"unorm16x2", 0xc4, 2, 'n', 4},
            {"unorm16x4", 0xc5, 4, 'n', 8},
            {"snorm8", 0xc6, 1, 'm', 1},
            {"snorm8x2", 0xc7, 2, 'm', 2},
            {"snorm8x4", 0xc8, 4, 'm', 4},
            {"snorm16", 0xc9, 1, 'm', 2},
            {"snorm16x2", 0xca, 2, 'm', 4},
            {"snorm16x4", 0xcb, 4, 'm', 8}};
}

std::vector<TextureFormat> blockFormats() {
    return {{"BC1", 0x91, 4, 'b', 8},     {"BC1 sRGB", 0x92, 4, 'b', 8},
            {"BC2", 0x93, 4, 'b', 16},    {"BC2 sRGB", 0x94, 4, 'b', 16},
            {"BC3", 0x95, 4, 'b', 16},    {"BC3 sRGB", 0x96, 4, 'b', 16},
            {"BC4U", 0x97, 1, 'b', 8},    {"BC4S", 0x98, 1, 'b', 8},
            {"BC5U", 0x99, 2, 'b', 16},   {"BC5S", 0x9a, 2, 'b', 16},
            {"BC6H U", 0x9b, 3, 'b', 16}, {"BC6H S", 0x9c, 3, 'b', 16},
            {"BC7", 0x9d, 4, 'b', 16},    {"BC7 sRGB", 0x9e, 4, 'b', 16}};
}

class Cases {
public:
    std::vector<TextureCase> list;

    TextureCase& add(const std::string& what, const TextureFormat& format,
                     const std::string& access) {
        TextureCase test;
        test.format = format;
        test.access = access;
        test.height = has(access, ".1d") || has(access, ".a1d") ? 0 : 8;
        test.depth = has(access, ".3d") ? 6 : 0;
        if (has(access, ".a1d") || has(access, ".a2d")) {
            test.depth = 5;
            test.arrayFlags |= CUDA_ARRAY3D_LAYERED;
        }
        if (has(access, "cube")) {
            test.height = test.width;
            test.depth = has(access, ".acube") ? 18 : 6;
            test.arrayFlags |= CUDA_ARRAY3D_CUBEMAP | (test.depth > 6 ? CUDA_ARRAY3D_LAYERED : 0);
        }
        if (access.starts_with("su"))
            test.arrayFlags |= CUDA_ARRAY3D_SURFACE_LDST;
        if (access.starts_with("tld4"))
            test.arrayFlags |= CUDA_ARRAY3D_TEXTURE_GATHER;
        for (CUaddress_mode& mode : test.sampling.addressMode)
            mode = CU_TR_ADDRESS_MODE_CLAMP;
        test.sampling.maxMipmapLevelClamp = 20;
        const float border[4] = {0.25f, -0.5f, 0.75f, 2.0f};
        std::copy(border, border + 4, test.sampling.borderColor);
        test.name = format.name + (" " + access) + (what.empty() ? "" : " " + what);
        list.push_back(test);
        return list.back();
    }

private:
    static bool has(const std::string& text, const char* part) {
        return text.find(part) != std::string::npos;
    }
};

// GPUs convert sRGB to linear light by a table of about nine bits.
constexpr double kSrgb = 0.004;

// The range of the texels of a format.
double rangeOf(const TextureFormat& format) {
    return format.kind == 'f' || format.kind == 'h'   ? 8
           : format.kind == 's' || format.kind == 'm' ? 2
                                                      : 1;
}

// Filters have weights in 1/256, which floats represent exactly; fractions and blocks are filtered
// with fewer bits.
double bilinear(const TextureFormat& format) {
    if (format.kind == 'f' || format.kind == 'h')
        return 0;
    const bool signedBlock = format.value == 0x98 || format.value == 0x9a;
    return signedBlock ? 5e-5 : format.kind == 's' || format.kind == 'm' ? 2e-5 : 1e-5;
}
// Devices may round products of weights differently: two units.
double blended(const TextureFormat& format) {
    return rangeOf(format) * 2 / 256;
}

void normalize(TextureCase& test) {
    test.sampling.flags |= CU_TRSF_NORMALIZED_COORDINATES;
}
void filter(TextureCase& test, double bound) {
    test.sampling.filterMode = CU_TR_FILTER_MODE_LINEAR;
    test.bound = bound;
}

void addFormats(Cases& cases) {
    for (const TextureFormat& format : plainFormats()) {
        const bool integers = format.kind == 'u' || format.kind == 's';
        const std::string type = format.kind == 's' ? "s32" : "u32";
        if (integers) {
            cases.add("", format, "tex.2d.v4." + type + ".f32").sampling.flags |=
                CU_TRSF_READ_AS_INTEGER;
            cases.add("", format, "tex.2d.v4." + type + ".s32").sampling.flags |=
                CU_TRSF_READ_AS_INTEGER;
        }
        if (integers && format.bytes / format.channels == 4)
            continue;
        cases.add("point", format, "tex.2d.v4.f32.f32");
        filter(cases.add("linear", format, "tex.2d.v4.f32.f32"), bilinear(format));
        TextureCase& border = cases.add("border", format, "tex.2d.v4.f32.f32");
        for (CUaddress_mode& mode : border.sampling.addressMode)
            mode = CU_TR_ADDRESS_MODE_BORDER;
    }
    for (const unsigned channels : {1u, 2u, 4u}) {
        const TextureFormat format = {"u8 sRGB", 1, channels, 'u', channels};
        const std::string note = "of " + std::to_string(channels);
        TextureCase& point = cases.add("point " + note, format, "tex.2d.v4.f32.f32");
        point.sampling.flags |= CU_TRSF_SRGB;
        point.bound = kSrgb;
        TextureCase& linear = cases.add("linear " + note, format, "tex.2d.v4.f32.f32");
        linear.sampling.flags |= CU_TRSF_SRGB;
        filter(linear, 1.5 * kSrgb);
    }
    for (const TextureFormat& format : blockFormats()) {
        TextureCase& point = cases.add("point", format, "tex.2d.v4.f32.s32");
        point.width = point.height = 32;
        TextureCase& linear = cases.add("linear", format, "tex.2d.v4.f32.f32");
        linear.width = linear.height = 32;
        filter(linear, bilinear(format));
        point.bound = format.value == 0x98 || format.value == 0x9a ? 4e-5 : 0;
        if (format.channels == 3) { // halves: sums of large ones of both signs are cut
            linear.share = 0.02;
            linear.most = 8;
        }
    }
    cases.add("half results", kFloat4, "tex.2d.v4.f16.f32");
    cases.add("half results", kInt8x4, "tex.2d.v4.f16.f32");
}

const char* const kModes[] = {"wrap", "clamp", "mirror", "border"};

void addAddressing(Cases& cases) {
    for (const std::string geometry : {"1d", "2d", "3d", "a1d", "a2d"})
        for (int mode = 0; mode < 4; ++mode)
            for (const bool normalized : {true, false}) {
                if (!normalized && mode != 1 && mode != 3)
                    continue; // wrap and mirror need normalised coordinates
                for (const bool linear : {false, true})
                    for (const TextureFormat& format : {kFloat4, kInt8x4}) {
                        TextureCase& test = cases.add(std::string(kModes[mode]) +
                                                          (normalized ? " normalised" : "") +
                                                          (linear ? " linear" : ""),
                                                      format, "tex." + geometry + ".v4.f32.f32");
                        for (CUaddress_mode& axis : test.sampling.addressMode)
                            axis = CUaddress_mode(mode);
                        if (normalized)
                            normalize(test);
                        if (linear)
                            filter(test, geometry == "3d" ? blended(format) : bilinear(format));
                    }
            }
    // Not 1d, because texel numbers of one-dimensional textures apply only to linear memory.
    for (const std::string geometry : {"2d", "3d", "a1d", "a2d"})
        cases.add("texel numbers", kFloat4, "tex." + geometry + ".v4.f32.s32");
}

void addLevels(Cases& cases) {
    for (const std::string geometry : {"1d", "2d", "3d", "a1d", "a2d", "cube", "acube"})
        for (const bool linearLevels : {false, true})
            for (const bool linear : {false, true}) {
                TextureCase& test = cases.add(std::string("levels") + (linear ? " linear" : "") +
                                                  (linearLevels ? " blended" : ""),
                                              kFloat4, "tex.level." + geometry + ".v4.f32.f32");
                test.levels = 4;
                normalize(test);
                if (linear)
                    filter(test, geometry == "3d" ? blended(kFloat4) : 0);
                if (linearLevels) {
                    test.sampling.mipmapFilterMode = CU_TR_FILTER_MODE_LINEAR;
                    test.bound = linear ? blended(kFloat4) : 0;
                }
            }
    const struct {
        const char* name;
        float bias, least, most;
    } kRanges[] = {{"bias 0.7", 0.7f, 0, 20},
                   {"bias -1.3", -1.3f, 0, 20},
                   {"from 1.25", 0, 1.25f, 20},
                   {"to 1.6", 0, 0, 1.6f},
                   {"bias 20", 20, 0, 20}};
    for (const auto& range : kRanges) {
        TextureCase& test =
            cases.add(std::string("blended ") + range.name, kFloat4, "tex.level.2d.v4.f32.f32");
        test.levels = 4;
        normalize(test);
        filter(test, blended(kFloat4));
        test.sampling.mipmapFilterMode = CU_TR_FILTER_MODE_LINEAR;
        test.sampling.mipmapLevelBias = range.bias;
        test.sampling.minMipmapLevelClamp = range.least;
        test.sampling.maxMipmapLevelClamp = range.most;
    }
}

// Floats that vary by up to 8: the bounds below are in these units.
void addGradients(Cases& cases) {
    for (const std::string geometry : {"1d", "2d", "3d", "a2d", "cube"})
        for (const unsigned anisotropy : {0u, 2u, 4u, 16u}) {
            if (anisotropy && geometry != "2d" && geometry != "a2d")
                continue;
            TextureCase& test = cases.add("anisotropy " + std::to_string(anisotropy), kFloat1,
                                          "tex.grad." + geometry + ".v4.f32.f32");
            test.levels = 4;
            normalize(test);
            // Devices choose level and probes: the bound is an eighth of the range, except for a
            // few vectors (three of their four words are always zero).
            const bool plain = geometry != "cube" && anisotropy == 0;
            filter(test, 1.0);
            test.share = plain ? 0.004 : 0.05;
            test.most = plain ? 2 : 5;
            test.sampling.mipmapFilterMode = CU_TR_FILTER_MODE_LINEAR;
            test.sampling.maxAnisotropy = anisotropy;
        }
}

void addGathers(Cases& cases) {
    for (const std::string channel : {"r", "g", "b", "a"})
        for (const std::string geometry : {"2d", "a2d"}) {
            normalize(cases.add("normalised", kFloat4,
                                "tld4." + channel + "." + geometry + ".v4.f32.f32"));
            cases.add("", kFloat4, "tld4." + channel + "." + geometry + ".v4.f32.f32");
            cases.add("", kInt8x4, "tld4." + channel + "." + geometry + ".v4.u32.f32")
                .sampling.flags |= CU_TRSF_READ_AS_INTEGER;
        }
    for (int mode = 0; mode < 4; ++mode) {
        TextureCase& test = cases.add(std::string(kModes[mode]) + " normalised at borders", kFloat4,
                                      "tld4.g.2d.v4.f32.f32");
        for (CUaddress_mode& axis : test.sampling.addressMode)
            axis = CUaddress_mode(mode);
        normalize(test);
    }
}

// Gathers from cubes: arrays need no flag for them.
void addCubeGathers(Cases& cases) {
    for (const std::string geometry : {"cube", "acube"})
        for (const std::string channel : {"r", "g", "b", "a"})
            for (const bool seamless : {false, true}) {
                TextureCase& test = cases.add(seamless ? "seamless" : "seams", kFloat4,
                                              "tld4." + channel + "." + geometry + ".v4.f32.f32");
                test.arrayFlags &= ~unsigned(CUDA_ARRAY3D_TEXTURE_GATHER);
                normalize(test);
                if (seamless)
                    test.sampling.flags |= CU_TRSF_SEAMLESS_CUBEMAP;
            }
    for (const char* flag : {"", "with flag"}) {
        TextureCase& test = cases.add(flag, kInt8x4, "tld4.g.cube.v4.u32.f32");
        if (!*flag)
            test.arrayFlags &= ~unsigned(CUDA_ARRAY3D_TEXTURE_GATHER);
        normalize(test);
        test.sampling.flags |= CU_TRSF_READ_AS_INTEGER;
    }
}

void addCubes(Cases& cases) {
    for (const std::string geometry : {"cube", "acube"})
        for (const bool seamless : {false, true})
            for (const bool linear : {false, true}) {
                TextureCase& test = cases.add(std::string(seamless ? "seamless" : "seams") +
                                                  (linear ? " linear" : ""),
                                              kFloat4, "tex." + geometry + ".v4.f32.f32");
                normalize(test);
                if (seamless)
                    test.sampling.flags |= CU_TRSF_SEAMLESS_CUBEMAP;
                if (linear)
                    filter(test, seamless ? blended(kFloat4) : 0);
            }
}

void addSurfaces(Cases& cases) {
    const struct {
        TextureFormat format;
        const char* access;
    } kAccesses[] = {{{"u8", 1, 1, 'u', 1}, "b8"},
                     {{"u8x2", 1, 2, 'u', 2}, "v2.b8"},
                     {kInt8x4, "v4.b8"},
                     {kInt8x4, "b32"},
                     {{"u16", 2, 1, 'u', 2}, "b16"},
                     {{"u16x4", 2, 4, 'u', 8}, "v4.b16"},
                     {{"u32x2", 3, 2, 'u', 8}, "v2.b32"},
                     {{"u32x2", 3, 2, 'u', 8}, "b64"},
                     {kFloat4, "v4.b32"},
                     {kFloat4, "v2.b64"}};
    for (const std::string geometry : {"1d", "2d", "3d", "a1d", "a2d"})
        for (const auto& a : kAccesses)
            for (const std::string clamp : {"clamp", "zero"}) {
                cases.add("", a.format, "suld.b." + geometry + "." + a.access + "." + clamp);
                if (clamp == "zero" && (geometry == "1d" || geometry == "2d"))
                    cases.add("", a.format, "sust.b." + geometry + "." + a.access + "." + clamp);
            }
    for (const TextureFormat& format : plainFormats())
        if (format.kind != 'n' && format.kind != 'm')
            cases.add("formatted", format, "sust.p.2d.v4.b32.zero");
    const TextureFormat word = {"u32", 3, 1, 'u', 4}, number = {"s32", 10, 1, 's', 4};
    for (const char* operation : {"add", "min", "max", "and", "or"})
        cases.add("", word,
                  std::string("sured.b.") + operation + ".2d." +
                      (operation[0] == 'o' || operation[1] == 'n' ? "b32" : "u32") + ".zero");
    for (const char* operation : {"min", "max"})
        cases.add("", number, std::string("sured.b.") + operation + ".2d.s32.zero");
    // Formatted: the texel's format says whether numbers have a sign.
    const TextureFormat kFormatted[] = {word,
                                        number,
                                        kInt8x4,
                                        {"s8x4", 8, 4, 's', 4},
                                        {"u16x2", 2, 2, 'u', 4},
                                        {"s16x2", 9, 2, 's', 4},
                                        kFloat1};
    for (const TextureFormat& format : kFormatted)
        for (const std::string operation : {"add", "min", "max", "and", "or"})
            cases.add("", format, "sured.p." + operation + ".2d.b32.zero");
    for (const TextureFormat& format :
         {TextureFormat{"u32x2", 3, 2, 'u', 8}, TextureFormat{"s32x2", 10, 2, 's', 8}})
        cases.add("", format, "sured.p.min.2d.b64.zero");
}

void addQueries(Cases& cases) {
    for (const char* query : {"width", "height", "depth", "channel_data_type", "channel_order",
                              "normalized_coords", "filter_mode", "addr_mode_0"}) {
        TextureCase& test = cases.add("", kFloat4, std::string("txq.") + query + ".b32");
        test.height = 8;
        test.depth = 6;
    }
}

} // namespace

const std::vector<TextureCase>& allTextureCases() {
    static const std::vector<TextureCase> all = [] {
        Cases cases;
        addFormats(cases);
        addAddressing(cases);
        addLevels(cases);
        addGradients(cases);
        addGathers(cases);
        addCubeGathers(cases);
        addCubes(cases);
        addSurfaces(cases);
        addQueries(cases);
        return std::move(cases.list);
    }();
    return all;
}

} // namespace conformance
