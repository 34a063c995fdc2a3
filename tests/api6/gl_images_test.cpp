// SPDX-License-Identifier: Apache-2.0
// Texture samplers that share their texels with images of OpenGL (section 5.15).
#include "gl_support.h"

namespace sunstone::api6 {
namespace {

using GlImages = Gl;

struct Place {
    float x, y, z;
};

TEST_F(GlImages, ProgramsSampleWhatOpenGlHolds) {
    const unsigned glId = texture(kTexture2D);
    std::vector<float> texels(2 * 2 * 4);
    for (size_t i = 0; i < texels.size(); ++i)
        texels[i] = float(i);
    egl().TexImage2D(kTexture2D, 0, kRgba32F, 2, 2, 0, kRgba, kFloat, texels.data());
    RTtexturesampler made = sampler(glId, RT_TARGET_GL_TEXTURE_2D);
    ok(rtVariableSet1i(variable("texel_kind"), 0));
    std::vector<float> r = launch("sample_texel");
    EXPECT_EQ(std::vector<float>(r.begin(), r.begin() + 4), (std::vector<float>{4, 5, 6, 7}));
    for (float& texel : texels)
        texel += 100;
    egl().TexImage2D(kTexture2D, 0, kRgba32F, 2, 2, 0, kRgba, kFloat, texels.data());
    EXPECT_EQ(launch("sample_texel")[0], 104);
    // OpenGL may change the size between.
    ok(rtTextureSamplerGLUnregister(made));
    fails(RT_ERROR_RESOURCE_NOT_REGISTERED, rtTextureSamplerGLUnregister(made), "not registered");
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "not registered");
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerValidate(made), "not registered");
    texels.assign(4 * 8 * 4, 55);
    egl().TexImage2D(kTexture2D, 0, kRgba32F, 4, 8, 0, kRgba, kFloat, texels.data());
    ok(rtTextureSamplerGLRegister(made));
    fails(RT_ERROR_RESOURCE_ALREADY_REGISTERED, rtTextureSamplerGLRegister(made), "is registered");
    EXPECT_EQ(launch("sample_texel")[0], 55);
    unsigned id = 0;
    ok(rtTextureSamplerGetGLImageId(made, &id));
    EXPECT_EQ(id, glId);
    ok(rtTextureSamplerDestroy(made));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtTextureSamplerGetGLImageId(made, &id));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtTextureSamplerGLRegister(made));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtTextureSamplerGLUnregister(made));
}

TEST_F(GlImages, OfAllTargets) {
    // A texel's value is its number, or that of its face.
    std::vector<float> numbers(4 * 4 * 12);
    for (size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = float(i);
    std::vector<float> faces(2 * 2 * 12);
    for (size_t i = 0; i < faces.size(); ++i)
        faces[i] = float(i / 4);
    const auto expectTexel = [&](unsigned glId, RTgltarget target, Place place, int layer,
                                 float wanted) {
        RTtexturesampler made = sampler(glId, target);
        ok(rtVariableSet1i(variable("gl_target"), int(target)));
        ok(rtVariableSet3f(variable("place"), place.x, place.y, place.z));
        ok(rtVariableSet1i(variable("layer"), layer));
        EXPECT_EQ(launch("sample_target")[0], wanted) << "target " << int(target);
        ok(rtTextureSamplerDestroy(made));
    };
    unsigned glId = texture(kTexture1D);
    egl().TexImage1D(kTexture1D, 0, kR32F, 4, 0, kRed, kFloat, numbers.data());
    expectTexel(glId, RT_TARGET_GL_TEXTURE_1D, {2.5f / 4, 0, 0}, 0, 2);
    glId = texture(kTexture2D);
    egl().TexImage2D(kTexture2D, 0, kR32F, 4, 3, 0, kRed, kFloat, numbers.data());
    expectTexel(glId, RT_TARGET_GL_TEXTURE_2D, {2.5f / 4, 1.5f / 3, 0}, 0, 6);
    glId = texture(kRectangle);
    egl().TexImage2D(kRectangle, 0, kR32F, 3, 4, 0, kRed, kFloat, numbers.data());
    expectTexel(glId, RT_TARGET_GL_TEXTURE_RECTANGLE, {0.5f / 3, 2.5f / 4, 0}, 0, 6);
    glId = texture(kTexture3D);
    egl().TexImage3D(kTexture3D, 0, kR32F, 4, 3, 2, 0, kRed, kFloat, numbers.data());
    expectTexel(glId, RT_TARGET_GL_TEXTURE_3D, {3.5f / 4, 2.5f / 3, 1.5f / 2}, 0, 23);
    glId = texture(kTexture1DArray);
    egl().TexImage2D(kTexture1DArray, 0, kR32F, 4, 3, 0, kRed, kFloat, numbers.data());
    expectTexel(glId, RT_TARGET_GL_TEXTURE_1D_ARRAY, {1.5f / 4, 0, 0}, 2, 9);
    glId = texture(kTexture2DArray);
    egl().TexImage3D(kTexture2DArray, 0, kR32F, 4, 2, 3, 0, kRed, kFloat, numbers.data());
    expectTexel(glId, RT_TARGET_GL_TEXTURE_2D_ARRAY, {1.5f / 4, 1.5f / 2, 0}, 1, 13);
    glId = texture(kCube);
    for (unsigned face = 0; face < 6; ++face)
        egl().TexImage2D(kCubeFace0 + face, 0, kR32F, 2, 2, 0, kRed, kFloat, &faces[4 * face]);
    expectTexel(glId, RT_TARGET_GL_TEXTURE_CUBE_MAP, {0.1f, -1, 0.1f}, 0, 3);
    expectTexel(glId, RT_TARGET_GL_TEXTURE_CUBE_MAP, {0.1f, 0.1f, 1}, 0, 4);
    glId = texture(kCubeArray);
    egl().TexImage3D(kCubeArray, 0, kR32F, 2, 2, 12, 0, kRed, kFloat, faces.data());
    expectTexel(glId, RT_TARGET_GL_TEXTURE_CUBE_MAP_ARRAY, {-1, 0.1f, 0.1f}, 1, 7);
    unsigned framebuffer = 0;
    egl().GenRenderbuffers(1, &glId);
    egl().BindRenderbuffer(kRenderbuffer, glId);
    egl().RenderbufferStorage(kRenderbuffer, unsigned(kR32F), 4, 4);
    egl().GenFramebuffers(1, &framebuffer);
    egl().BindFramebuffer(kFramebuffer, framebuffer);
    egl().FramebufferRenderbuffer(kFramebuffer, kColorAttachment0, kRenderbuffer, glId);
    const float color[4] = {77, 0, 0, 0};
    egl().ClearBufferfv(kColor, 0, color);
    egl().BindFramebuffer(kFramebuffer, 0);
    expectTexel(glId, RT_TARGET_GL_RENDER_BUFFER, {0.5f, 0.5f, 0}, 0, 77);
}

TEST_F(GlImages, OfAllFormats) {
    const struct {
        int internal;
        unsigned format, type;
        int channels, bytes, kind; // 0: float, 1: int, 2: unsigned
    } formats[] = {{0x8231, kRedInteger, kByte, 1, 1, 1},
                   {0x8232, kRedInteger, kUnsignedByte, 1, 1, 2},
                   {0x8237, kRgInteger, kByte, 2, 1, 1},
                   {0x8238, kRgInteger, kUnsignedByte, 2, 1, 2},
                   {kRgba8, kRgba, kUnsignedByte, 4, 1, 2},
                   {int(kRgba), kRgba, kUnsignedByte, 4, 1, 2}, // OpenGL chooses the size
                   {0x8D8E, kRgbaInteger, kByte, 4, 1, 1},
                   {0x8D7C, kRgbaInteger, kUnsignedByte, 4, 1, 2},
                   {0x8233, kRedInteger, kShort, 1, 2, 1},
                   {0x8234, kRedInteger, kUnsignedShort, 1, 2, 2},
                   {0x8239, kRgInteger, kShort, 2, 2, 1},
                   {0x823A, kRgInteger, kUnsignedShort, 2, 2, 2},
                   {0x805B, kRgba, kUnsignedShort, 4, 2, 2},
                   {0x8D88, kRgbaInteger, kShort, 4, 2, 1},
                   {0x8D76, kRgbaInteger, kUnsignedShort, 4, 2, 2},
                   {0x8235, kRedInteger, kInt, 1, 4, 1},
                   {0x8236, kRedInteger, kUnsignedInt, 1, 4, 2},
                   {0x823B, kRgInteger, kInt, 2, 4, 1},
                   {0x823C, kRgInteger, kUnsignedInt, 2, 4, 2},
                   {0x8D82, kRgbaInteger, kInt, 4, 4, 1},
                   {0x8D70, kRgbaInteger, kUnsignedInt, 4, 4, 2},
                   {kR32F, kRed, kFloat, 1, 4, 0},
                   {0x8230, kRg, kFloat, 2, 4, 0},
                   {kRgba32F, kRgba, kFloat, 4, 4, 0}};
    setEntry("sample_texel");
    egl().PixelStorei(0x0CF5, 1); // rows without gaps
    for (const auto& f : formats) {
        // 3 x 2 texels; numbers up to 24 fit into all types.
        std::vector<uint8_t> bytes(size_t(3 * 2 * f.channels * f.bytes));
        for (int i = 0; i < 3 * 2 * f.channels; ++i) {
            const float real = float(i + 1);
            const int whole = f.kind == 1 ? -(i + 1) : i + 1;
            std::memcpy(&bytes[size_t(i * f.bytes)],
                        f.kind == 0 ? static_cast<const void*>(&real) : &whole, size_t(f.bytes));
        }
        const unsigned glId = texture(kTexture2D);
        egl().TexImage2D(kTexture2D, 0, f.internal, 3, 2, 0, f.format, f.type, bytes.data());
        RTtexturesampler made = sampler(glId, RT_TARGET_GL_TEXTURE_2D);
        ok(rtVariableSet1i(variable("texel_kind"), f.kind));
        ok(rtContextLaunch1D(context_, 0, 1));
        const std::vector<float> r = results();
        for (int c = 0; c < f.channels; ++c) {
            const float number = float(2 * f.channels + c + 1); // of texel (2, 0)
            EXPECT_EQ(r[size_t(c)], f.kind == 1 ? -number : number)
                << std::hex << f.internal << " channel " << c;
        }
        ok(rtTextureSamplerDestroy(made));
        egl().DeleteTextures(1, &glId);
    }
    egl().PixelStorei(0x0CF5, 4);
}

TEST_F(GlImages, OfSeveralLevels) {
    const unsigned glId = texture(kTexture2D);
    for (int level = 0; level < 3; ++level) {
        const std::vector<float> texels(size_t(4 >> level) * size_t(4 >> level), float(10 + level));
        egl().TexImage2D(kTexture2D, level, kR32F, 4 >> level, 4 >> level, 0, kRed, kFloat,
                         texels.data());
    }
    RTtexturesampler made = sampler(glId, RT_TARGET_GL_TEXTURE_2D);
    std::vector<float> r = launch("sample_levels");
    EXPECT_EQ(std::vector<float>(r.begin(), r.begin() + 3), (std::vector<float>{10, 10, 10}));
    ok(rtTextureSamplerSetFilteringModes(made, RT_FILTER_NEAREST, RT_FILTER_NEAREST,
                                         RT_FILTER_NEAREST));
    r = launch("sample_levels");
    EXPECT_EQ(std::vector<float>(r.begin(), r.begin() + 3), (std::vector<float>{10, 11, 12}));
}

TEST_F(GlImages, AreCheckedWhenMade) {
    RTtexturesampler made = nullptr;
    const auto failsWith = [&](RTresult result, unsigned glId, RTgltarget target,
                               const char* word) {
        fails(result, rtTextureSamplerCreateFromGLImage(context_, glId, target, &made), word);
        EXPECT_EQ(made, nullptr);
    };
    const unsigned glId = texture(kTexture2D);
    const unsigned char texel[4] = {1, 2, 3, 4};
    failsWith(RT_ERROR_MEMORY_ALLOCATION_FAILED, glId, RT_TARGET_GL_TEXTURE_2D, "the size 0");
    egl().TexImage2D(kTexture2D, 0, kRgba8, 1, 1, 0, kRgba, kUnsignedByte, texel);
    fails(RT_ERROR_INVALID_VALUE,
          rtTextureSamplerCreateFromGLImage(context_, glId, RT_TARGET_GL_TEXTURE_2D, nullptr),
          "textureSampler is null");
    EXPECT_EQ(RT_ERROR_INVALID_CONTEXT,
              rtTextureSamplerCreateFromGLImage(nullptr, glId, RT_TARGET_GL_TEXTURE_2D, &made));
    failsWith(RT_ERROR_INVALID_VALUE, 0, RT_TARGET_GL_TEXTURE_2D, "glId = 0");
    failsWith(RT_ERROR_INVALID_VALUE, 999, RT_TARGET_GL_TEXTURE_2D, "not a texture");
    failsWith(RT_ERROR_INVALID_VALUE, 999, RT_TARGET_GL_RENDER_BUFFER, "not a renderbuffer");
    failsWith(RT_ERROR_INVALID_VALUE, glId, RTgltarget(9), "target = 9");
    failsWith(RT_ERROR_INVALID_VALUE, glId, RTgltarget(-1), "target");
    failsWith(RT_ERROR_INVALID_VALUE, glId, RT_TARGET_GL_TEXTURE_3D, "another target");
    const unsigned depth = texture(kTexture2D);
    egl().TexImage2D(kTexture2D, 0, 0x81A6, 1, 1, 0, kDepthComponent, kUnsignedInt, nullptr);
    failsWith(RT_ERROR_INVALID_VALUE, depth, RT_TARGET_GL_TEXTURE_2D, "internal format 33190");
    const unsigned srgb = texture(kTexture2D);
    egl().TexImage2D(kTexture2D, 0, 0x8C43, 1, 1, 0, kRgba, kUnsignedByte, texel);
    failsWith(RT_ERROR_INVALID_VALUE, srgb, RT_TARGET_GL_TEXTURE_2D, "does not support");
    made = sampler(glId, RT_TARGET_GL_TEXTURE_2D);
    RTbuffer buffer = nullptr;
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerGetBuffer(made, 0, 0, &buffer), "has no buffer");
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetBuffer(made, 0, 0, image(1, 1)),
          "has no buffer");
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerGetGLImageId(made, nullptr), "glId is null");
}

} // namespace
} // namespace sunstone::api6
