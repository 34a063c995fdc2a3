// SPDX-License-Identifier: Apache-2.0
// PTX of releases before 6: texture lookups by id are calls with the kind of lookup.
#include "support.h"

namespace sunstone::api6 {
namespace {

// A variable with its description, in the form of the API's headers.
std::string described(const std::string& name, const std::string& type, unsigned bytes) {
    const std::string mangled = std::to_string(name.size()) + name + "E";
    return ".visible .global .align 4 ." + type + " " + name + ";\n" +
           ".visible .global .align 4 .b8 _ZN21rti_internal_typeinfo" + mangled +
           "[8] = {82, 97, 121, 0, " + std::to_string(bytes) + ", 0, 0, 0};\n" +
           ".visible .global .u32 _ZN21rti_internal_typeenum" + mangled + " = 4919;\n" +
           ".visible .global .align 1 .b8 _ZN21rti_internal_semantic" + mangled + "[1] = {0};\n" +
           ".visible .global .align 1 .b8 _ZN23rti_internal_annotation" + mangled + "[1] = {0};\n";
}

// A program that makes the call and stores its results as 32-bit words in `words`.
std::string programOf(const std::string& call, unsigned results, char kind) {
    const std::string reg = kind == 'f' ? "%f" : "%r";
    std::string list;
    for (unsigned i = 0; i < results; ++i)
        list += (i ? ", " : "") + reg + std::to_string(i);
    std::string text = ".version 4.3\n.target sm_20\n.address_size 64\n"
                       ".visible .global .align 1 .b8 words[1];\n" +
                       described("texture_id", "u32", 4) +
                       ".visible .entry lookup()\n{\n.reg .f32 %f<9>;\n.reg .b32 %r<20>;\n"
                       ".reg .b64 %rd<9>;\nld.global.u32 %r9, [texture_id];\n"
                       "mov.u64 %rd1, words;\nmov.u32 %r10, 1;\nmov.u32 %r11, 4;\n"
                       "mov.u64 %rd3, 0;\ncall (" +
                       list + "), _rt_texture_get_" + call + ";\n";
    for (unsigned i = 0; i < results; ++i)
        text += "mov.u64 %rd2, " + std::to_string(i) +
                ";\ncall (%rd4), _rt_buffer_get_64, (%rd1, %r10, %r11, %rd2, %rd3, %rd3, %rd3);\n" +
                (kind == 'f' ? "st.f32" : "st.u32") + " [%rd4], " + reg + std::to_string(i) + ";\n";
    return text + "ret;\n}\n";
}
// A float operand.
std::string f(float value) {
    uint32_t bits = 0;
    std::memcpy(&bits, &value, 4);
    char text[16];
    std::snprintf(text, sizeof text, "0f%08X", bits);
    return text;
}

class OldPtx : public Classic {
protected:
    void SetUp() override {
        Classic::SetUp();
        words_ = buffer(RT_BUFFER_OUTPUT, RT_FORMAT_UNSIGNED_INT, 4);
        ok(rtVariableSetObject(variable("words"), words_));
    }
    // A sampler of elements 0, 1, 2 ... in each component's own hundred.
    template <class T>
    void texture(RTformat format, unsigned flags, RTsize x, RTsize y, RTsize z,
                 unsigned levels = 1) {
        RTbuffer made = nullptr;
        ok(rtBufferCreate(context_, RT_BUFFER_INPUT | flags, &made));
        ok(rtBufferSetFormat(made, format));
        ok(rtBufferSetMipLevelCount(made, levels));
        z   ? ok(rtBufferSetSize3D(made, x, y, z))
        : y ? ok(rtBufferSetSize2D(made, x, y))
            : ok(rtBufferSetSize1D(made, x));
        for (unsigned level = 0; level < levels; ++level) {
            void* data = nullptr;
            ok(rtBufferMapEx(made, RT_BUFFER_MAP_WRITE, level, nullptr, &data));
            const RTsize count = std::max<RTsize>(1, x >> level) *
                                 std::max<RTsize>(1, (y ? y : 1) >> level) * std::max<RTsize>(1, z);
            for (RTsize i = 0; i < count; ++i)
                for (unsigned c = 0; c < 4; ++c)
                    static_cast<T*>(data)[4 * i + c] = T(100 * c + i + 50 * level);
            ok(rtBufferUnmapEx(made, level));
        }
        RTtexturesampler sampler = nullptr;
        ok(rtTextureSamplerCreate(context_, &sampler));
        ok(rtTextureSamplerSetBuffer(sampler, 0, 0, made));
        ok(rtTextureSamplerSetFilteringModes(sampler, RT_FILTER_NEAREST, RT_FILTER_NEAREST,
                                             levels > 1 ? RT_FILTER_NEAREST : RT_FILTER_NONE));
        ok(rtTextureSamplerSetReadMode(sampler, RT_TEXTURE_READ_ELEMENT_TYPE));
        ok(rtTextureSamplerSetIndexingMode(sampler, flags & RT_BUFFER_CUBEMAP
                                                        ? RT_TEXTURE_INDEX_NORMALIZED_COORDINATES
                                                        : RT_TEXTURE_INDEX_ARRAY_INDEX));
        sampler_ = sampler;
        int id = 0;
        ok(rtTextureSamplerGetId(sampler, &id));
        ok(rtVariableSet1i(variable("texture_id"), id));
    }
    template <class T>
    std::vector<T> look(const std::string& call, unsigned results, char kind) {
        RTprogram program = nullptr;
        ok(rtProgramCreateFromPTXString(context_, programOf(call, results, kind).c_str(), "lookup",
                                        &program));
        ok(rtContextSetRayGenerationProgram(context_, 0, program));
        ok(rtContextLaunch1D(context_, 0, 1));
        std::vector<T> values(results);
        void* data = nullptr;
        rtBufferMap(words_, &data);
        std::memcpy(values.data(), data, results * sizeof(T));
        rtBufferUnmap(words_);
        return values;
    }
    std::vector<float> floats(const std::string& call) { return look<float>(call, 4, 'f'); }
    // The texel with this number.
    static std::vector<float> texel(float i) { return {i, 100 + i, 200 + i, 300 + i}; }

    RTbuffer words_ = nullptr;
    RTtexturesampler sampler_ = nullptr; // of the last texture
};

TEST_F(OldPtx, TexturesOfAllShapes) {
    const std::string at = f(1.5f) + ", " + f(2.5f) + ", ";
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 0, 0);
    EXPECT_EQ(floats("base_id, (%r9, 1, " + at + f(0) + ", 0)"), texel(1));
    EXPECT_EQ(floats("f_id, (%r9, 1, " + at + f(0) + ", " + f(0) + ")"), texel(1));
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 4, 0);
    EXPECT_EQ(floats("base_id, (%r9, 2, " + at + f(0) + ", 0)"), texel(9));
    EXPECT_EQ(floats("f_id, (%r9, 2, " + at + f(0) + ", " + f(0) + ")"), texel(9));
    EXPECT_EQ(floats("fetch_id, (%r9, 2, 3, 1, 0, 0)"), texel(7));
    EXPECT_EQ((look<uint32_t>("size_id, (%r9)", 3, 'r')), (std::vector<uint32_t>{4, 4, 1}));
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 4, 4);
    EXPECT_EQ(floats("base_id, (%r9, 3, " + at + f(3.5f) + ", 0)"), texel(57));
    EXPECT_EQ(floats("f_id, (%r9, 3, " + at + f(3.5f) + ", " + f(0) + ")"), texel(57));
    EXPECT_EQ(floats("fetch_id, (%r9, 3, 3, 1, 2, 0)"), texel(39));
    texture<float>(RT_FORMAT_FLOAT4, RT_BUFFER_LAYERED, 4, 1, 3);
    EXPECT_EQ(floats("base_id, (%r9, 4, " + at + f(0) + ", 2)"), texel(9));
    texture<float>(RT_FORMAT_FLOAT4, RT_BUFFER_LAYERED, 4, 4, 3);
    EXPECT_EQ(floats("base_id, (%r9, 5, " + at + f(0) + ", 2)"), texel(41));
    texture<float>(RT_FORMAT_FLOAT4, RT_BUFFER_CUBEMAP, 1, 1, 6);
    const std::string down = f(0.1f) + ", " + f(-1) + ", " + f(0.2f);
    EXPECT_EQ(floats("base_id, (%r9, 6, " + down + ", 0)"), texel(3));
    texture<float>(RT_FORMAT_FLOAT4, RT_BUFFER_CUBEMAP | RT_BUFFER_LAYERED, 1, 1, 12);
    EXPECT_EQ(floats("base_id, (%r9, 7, " + down + ", 1)"), texel(9));
}

// A program "give" that stores the texel or the variable of this name.
std::string giveText(const std::string& declaration, const std::string& read) {
    return ".version 4.3\n.target sm_20\n.address_size 64\n"
           ".visible .global .align 1 .b8 words[1];\n" +
           declaration +
           ".visible .entry give()\n{\n.reg .f32 %f<9>;\n.reg .b32 %r<20>;\n.reg .b64 %rd<9>;\n"
           "mov.u32 %r0, 2;\n" +
           read +
           "mov.u64 %rd1, words;\nmov.u32 %r10, 1;\nmov.u32 %r11, 4;\nmov.u64 %rd3, 0;\n"
           "call (%rd4), _rt_buffer_get_64, (%rd1, %r10, %r11, %rd3, %rd3, %rd3, %rd3);\n"
           "st.f32 [%rd4], %f1;\nret;\n}\n";
}

// .tex is the form of .global .texref before PTX 1.5.
TEST_F(OldPtx, TexturesInTheSpaceOfTextures) {
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 0, 0);
    RTprogram program = nullptr;
    const std::string text = giveText(
        ".tex .u64 picture;\n", "tex.1d.v4.f32.s32 {%f0, %f1, %f2, %f3}, [picture, {%r0}];\n");
    ok(rtProgramCreateFromPTXString(context_, text.c_str(), "give", &program));
    ok(rtContextSetRayGenerationProgram(context_, 0, program));
    fails(RT_ERROR_VARIABLE_NOT_FOUND, rtContextLaunch1D(context_, 0, 1), "picture");
    ok(rtVariableSetObject(variable("picture"), sampler_));
    ok(rtContextLaunch1D(context_, 0, 1));
    void* data = nullptr;
    ok(rtBufferMap(words_, &data));
    EXPECT_EQ(*static_cast<float*>(data), 102);
    ok(rtBufferUnmap(words_));
}

// Each text has its own variables, also if programs of several texts have one name.
TEST_F(OldPtx, ProgramsOfOneNameInSeveralTexts) {
    ok(rtContextSetEntryPointCount(context_, 2));
    const char* const names[] = {"first_value", "second_value"};
    for (unsigned i = 0; i < 2; ++i) {
        RTprogram program = nullptr;
        const std::string text = giveText(described(names[i], "f32", 4),
                                          std::string("ld.global.f32 %f1, [") + names[i] + "];\n");
        ok(rtProgramCreateFromPTXString(context_, text.c_str(), "give", &program));
        ok(rtContextSetRayGenerationProgram(context_, i, program));
        ok(rtVariableSet1f(variable(names[i]), 5.0f + float(i)));
    }
    for (unsigned i = 0; i < 2; ++i) {
        ok(rtContextLaunch1D(context_, i, 1));
        void* data = nullptr;
        ok(rtBufferMap(words_, &data));
        EXPECT_EQ(*static_cast<float*>(data), 5.0f + float(i));
        ok(rtBufferUnmap(words_));
    }
}

TEST_F(OldPtx, TexelsOfOneDimension) {
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 0, 0);
    EXPECT_EQ(floats("fetch_id, (%r9, 1, 3, 0, 0, 0)"), texel(3));
}

TEST_F(OldPtx, LevelsGradientsAndGathers) {
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 4, 0, 3);
    const std::string at = f(0.75f) + ", " + f(0.25f) + ", " + f(0) + ", 0, ";
    RTtexturesampler sampler = nullptr;
    ok(rtContextGetTextureSamplerFromId(context_, 1, &sampler));
    ok(rtTextureSamplerSetIndexingMode(sampler, RT_TEXTURE_INDEX_NORMALIZED_COORDINATES));
    EXPECT_EQ(floats("level_id, (%r9, 2, " + at + f(0) + ")"), texel(7));
    EXPECT_EQ(floats("level_id, (%r9, 2, " + at + f(1) + ")"), texel(51));
    EXPECT_EQ(floats("level_id, (%r9, 2, " + at + f(2) + ")"), texel(100));
    const std::string zero = f(0), half = f(0.5f);
    EXPECT_EQ(floats("grad_id, (%r9, 2, " + at + half + ", " + zero + ", " + zero + ", " + zero +
                     ", " + half + ", " + zero + ")"),
              texel(51));
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 4, 0);
    EXPECT_EQ(floats("gather_id, (%r9, " + f(1) + ", " + f(1) + ", 2)"),
              (std::vector<float>{204, 205, 201, 200}));
}

TEST_F(OldPtx, ElementsOfIntegers) {
    const std::string at = f(1.5f) + ", " + f(0.5f) + ", " + f(0) + ", ";
    texture<int>(RT_FORMAT_INT4, 0, 4, 4, 0);
    EXPECT_EQ((look<int>("i_id, (%r9, 2, " + at + f(0) + ")", 4, 'r')),
              (std::vector<int>{1, 101, 201, 301}));
    EXPECT_EQ((look<int>("base_id, (%r9, 2, " + at + "0)", 4, 'f')),
              (std::vector<int>{1, 101, 201, 301}))
        << "the bits of the elements";
    texture<unsigned char>(RT_FORMAT_UNSIGNED_BYTE4, 0, 4, 4, 0);
    EXPECT_EQ((look<unsigned>("u_id, (%r9, 2, " + at + f(0) + ")", 4, 'r')),
              (std::vector<unsigned>{1, 101, 201, 45}));
}

// PTX of compilers before CUDA 12 has rtTextureSampler variables as references.
class OldReferences : public OldPtx {
protected:
    // The results of a lookup in the texture `picture`.
    std::vector<float> floats(const std::string& lookup) {
        const std::string text =
            ".version 3.2\n.target sm_20\n.address_size 64\n"
            ".visible .global .align 1 .b8 words[1];\n.global .texref picture;\n"
            ".visible .entry lookup()\n{\n.reg .f32 %f<9>;\n.reg .b32 %r<20>;\n"
            ".reg .b64 %rd<9>;\nmov.u64 %rd1, words;\nmov.u32 %r10, 1;\nmov.u32 %r11, 4;\n"
            "mov.u64 %rd3, 0;\nmov.f32 %f5, 0f3FC00000;\nmov.f32 %f6, 0f40200000;\n"
            "mov.f32 %f7, 0f00000000;\nmov.u32 %r1, 3;\nmov.u32 %r2, 1;\n" +
            lookup + "\n" + stores() + "ret;\n}\n";
        RTprogram program = nullptr;
        ok(rtProgramCreateFromPTXString(context_, text.c_str(), "lookup", &program));
        ok(rtContextSetRayGenerationProgram(context_, 0, program));
        int id = 0;
        ok(rtVariableGet1i(variable("texture_id"), &id));
        RTtexturesampler sampler = nullptr;
        ok(rtContextGetTextureSamplerFromId(context_, id, &sampler));
        ok(rtVariableSetObject(variable("picture"), sampler));
        ok(rtContextLaunch1D(context_, 0, 1));
        void* data = nullptr;
        std::vector<float> values(4);
        rtBufferMap(words_, &data);
        std::memcpy(values.data(), data, 16);
        rtBufferUnmap(words_);
        return values;
    }
    // Of %f0 to %f3.
    static std::string stores() {
        std::string text;
        for (unsigned i = 0; i < 4; ++i)
            text += "mov.u64 %rd2, " + std::to_string(i) +
                    ";\ncall (%rd4), _rt_buffer_get_64, (%rd1, %r10, %r11, %rd2, %rd3, %rd3, "
                    "%rd3);\nst.f32 [%rd4], %f" +
                    std::to_string(i) + ";\n";
        return text;
    }
};

TEST_F(OldReferences, AllForms) {
    const std::string results = " {%f0, %f1, %f2, %f3}, [picture, ";
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 4, 0);
    EXPECT_EQ(floats("tex.2d.v4.f32.f32" + results + "{%f5, %f6}];"), texel(9));
    EXPECT_EQ(floats("tex.2d.v4.f32.s32" + results + "{%r1, %r2}];"), texel(7));
    EXPECT_EQ(floats("mov.u64 %rd5, picture;\n"
                     "tex.2d.v4.f32.f32 {%f0, %f1, %f2, %f3}, [%rd5, {%f5, %f6}];"),
              texel(9));
    EXPECT_EQ(floats("txq.width.b32 %r5, [picture];\ntxq.height.b32 %r6, [picture];\n"
                     "cvt.rn.f32.u32 %f0, %r5;\ncvt.rn.f32.u32 %f1, %r6;\n"
                     "mov.f32 %f2, %f0;\nmov.f32 %f3, %f1;"),
              (std::vector<float>{4, 4, 4, 4}));
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 0, 0);
    EXPECT_EQ(floats("tex.1d.v4.f32.f32" + results + "{%f5}];"), texel(1));
    EXPECT_EQ(floats("tex.1d.v4.f32.s32" + results + "{%r1}];"), texel(3));
    EXPECT_EQ(floats("tex.1d.v4.f32.s32" + results + "%r1];"), texel(3));
    EXPECT_EQ(floats("tex.level.1d.v4.f32.f32" + results + "{%f5}], %f7;"), texel(1));
    EXPECT_EQ(floats("tex.grad.1d.v4.f32.f32" + results + "{%f5}], {%f7}, {%f7};"), texel(1));
    texture<float>(RT_FORMAT_FLOAT4, 0, 4, 4, 4);
    EXPECT_EQ(floats("tex.3d.v4.f32.f32" + results + "{%f5, %f6, %f5, %f5}];"), texel(25));
}

TEST_F(OldPtx, UnknownLookupsAreRefused) {
    RTprogram program = nullptr;
    const std::string text = programOf("nothing_id, (%r9)", 4, 'f');
    if (rtProgramCreateFromPTXString(context_, text.c_str(), "lookup", &program) != RT_SUCCESS)
        return;
    ok(rtContextSetRayGenerationProgram(context_, 0, program));
    EXPECT_NE(rtContextLaunch1D(context_, 0, 1), RT_SUCCESS);
}

// Compilers that do not optimise pass operands through memory. The function has more such operands
// than LLVM's EarlyCSE pass forwards, and their memory is known to another function.
TEST_F(OldPtx, OperandsPassThroughMemory) {
    std::string text = R"(.version 4.3
.target sm_20
.address_size 64
.visible .global .align 1 .b8 words[1];
.func touch(.param .b64 place)
{
.reg .b64 %rd<2>;
.reg .b32 %r<2>;
mov.u32 %r1, 0;
ld.param.u64 %rd1, [place];
st.u32 [%rd1], %r1;
ret;
}
.visible .entry count()
{
.local .align 8 .b8 memory[32];
.reg .b64 %rd<9>;
.reg .b32 %r<9>;
mov.u64 %rd7, memory;
cvta.local.u64 %rd8, %rd7;
{
.param .b64 place;
st.param.b64 [place], %rd8;
call touch, (place);
}
mov.u64 %rd1, words;
mov.u64 %rd3, 0;
mov.u32 %r5, 1;
mov.u32 %r6, 4;
)";
    for (unsigned i = 0; i < 300; ++i)
        text += "mov.u64 %rd2, " + std::to_string(i % 4) +
                ";\nst.u32 [%rd8+16], %r5;\nst.u32 [%rd8+20], %r6;\nst.u64 [%rd8+24], %rd2;\n"
                "ld.u32 %r1, [%rd8+16];\nld.u32 %r2, [%rd8+20];\nld.u64 %rd2, [%rd8+24];\n"
                "call (%rd4), _rt_buffer_get_64, (%rd1, %r1, %r2, %rd2, %rd3, %rd3, %rd3);\n"
                "ld.u32 %r3, [%rd4];\nadd.u32 %r3, %r3, 1;\nst.u32 [%rd4], %r3;\n";
    RTprogram made = nullptr;
    ok(rtProgramCreateFromPTXString(context_, (text + "ret;\n}\n").c_str(), "count", &made));
    ok(rtContextSetRayGenerationProgram(context_, 0, made));
    fill(words_, std::vector<unsigned>{0, 10, 20, 30});
    ok(rtContextLaunch1D(context_, 0, 1));
    void* data = nullptr;
    ok(rtBufferMap(words_, &data));
    for (unsigned i = 0; i < 4; ++i)
        EXPECT_EQ(static_cast<unsigned*>(data)[i], 10 * i + 75);
    ok(rtBufferUnmap(words_));
}

} // namespace
} // namespace sunstone::api6
