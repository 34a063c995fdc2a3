// SPDX-License-Identifier: Apache-2.0
// Buffers and texture samplers that share data with OpenGL (sections 5.14, 5.15), with a context of
// EGL. Without EGL they are skipped.
#include "egl.h"
#include "post_support.h"

#include "optix_cuda_interop.h"
#include "optix_gl_interop.h"
#include "optixu/optixpp_namespace.h"

#include <thread>

namespace sunstone::api6 {
namespace {

using namespace enums;

Egl& egl() {
    static auto* made = new Egl;
    return *made;
}

class Gl : public Post {
protected:
    void SetUp() override {
        Post::SetUp();
        if (!egl().reason.empty())
            GTEST_SKIP() << egl().reason;
        ASSERT_TRUE(egl().makeCurrent());
    }
    void TearDown() override {
        Post::TearDown();
        if (egl().reason.empty()) {
            EXPECT_EQ(egl().GetError(), 0u) << "an error of OpenGL is left";
            egl().release();
        }
    }

    template <class T>
    unsigned glBuffer(const std::vector<T>& items) {
        unsigned made = 0;
        egl().GenBuffers(1, &made);
        egl().BindBuffer(kArrayBuffer, made);
        egl().BufferData(kArrayBuffer, ptrdiff_t(items.size() * sizeof(T)), items.data(),
                         kStaticDraw);
        egl().BindBuffer(kArrayBuffer, 0);
        return made;
    }
    void write(unsigned buffer, const std::vector<float>& items) {
        egl().BindBuffer(kArrayBuffer, buffer);
        egl().BufferSubData(kArrayBuffer, 0, ptrdiff_t(items.size() * 4), items.data());
        egl().BindBuffer(kArrayBuffer, 0);
    }
    std::vector<float> read(unsigned buffer, size_t count) {
        std::vector<float> items(count);
        egl().BindBuffer(kArrayBuffer, buffer);
        egl().GetBufferSubData(kArrayBuffer, 0, ptrdiff_t(count * 4), items.data());
        egl().BindBuffer(kArrayBuffer, 0);
        return items;
    }
    RTbuffer shared(unsigned type, unsigned glId, RTformat format, RTsize width, RTsize height) {
        RTbuffer made = nullptr;
        ok(rtBufferCreateFromGLBO(context_, type, glId, &made));
        ok(rtBufferSetFormat(made, format));
        ok(rtBufferSetSize2D(made, width, height));
        return made;
    }
    void setEntries() {
        ok(rtVariableSet1f(variable("scoped"), 0.5f));
        ok(rtContextSetEntryPointCount(context_, 2));
        ok(rtContextSetRayGenerationProgram(context_, 0, program("paint_image")));
        ok(rtContextSetRayGenerationProgram(context_, 1, program("halve_image")));
    }
    unsigned texture(unsigned target) {
        unsigned made = 0;
        egl().GenTextures(1, &made);
        egl().BindTexture(target, made);
        return made;
    }
    RTtexturesampler sampler(unsigned glId, RTgltarget target) {
        RTtexturesampler made = nullptr;
        ok(rtTextureSamplerCreateFromGLImage(context_, glId, target, &made));
        ok(rtTextureSamplerSetFilteringModes(made, RT_FILTER_NEAREST, RT_FILTER_NEAREST,
                                             RT_FILTER_NONE));
        ok(rtTextureSamplerSetReadMode(made, RT_TEXTURE_READ_ELEMENT_TYPE));
        for (unsigned i = 0; i < 3; ++i)
            ok(rtTextureSamplerSetWrapMode(made, i, RT_WRAP_CLAMP_TO_EDGE));
        int id = 0;
        ok(rtTextureSamplerGetId(made, &id));
        ok(rtVariableSet1i(variable("texture_id"), id));
        return made;
    }
};
struct Place {
    float x, y, z;
};
using GlBuffers = Gl;
using GlImages = Gl;

// ---- Buffers -----------------------------------------------------------------------------------

TEST_F(GlBuffers, LaunchesReadAndWriteTheElementsOfOpenGl) {
    const unsigned glId = glBuffer(std::vector<float>(2 * 2 * 4, 8.0f));
    RTbuffer both = shared(RT_BUFFER_INPUT_OUTPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    setEntries();
    ok(rtVariableSetObject(variable("image"), both));
    ok(rtContextLaunch2D(context_, 1, 2, 2));
    EXPECT_EQ(read(glId, 16), std::vector<float>(16, 4.0f));
    write(glId, std::vector<float>(16, 3.0f));
    ok(rtContextLaunch2D(context_, 1, 2, 1));
    std::vector<float> wanted(16, 3.0f);
    std::fill_n(wanted.begin(), 8, 1.5f);
    EXPECT_EQ(read(glId, 16), wanted);
}

TEST_F(GlBuffers, OutputKeepsWhatNoLaunchWrites) {
    const unsigned glId = glBuffer(std::vector<float>(16));
    RTbuffer output = shared(RT_BUFFER_OUTPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    setEntries();
    ok(rtVariableSetObject(variable("image"), output));
    ok(rtContextLaunch2D(context_, 0, 2, 2));
    write(glId, std::vector<float>(16, 7.0f));
    ok(rtContextLaunch2D(context_, 0, 1, 1));
    const std::vector<float> now = read(glId, 16);
    EXPECT_EQ(now[0], 1.0f);
    EXPECT_EQ(std::vector<float>(now.begin() + 4, now.end()), std::vector<float>(12, 7.0f));
}

TEST_F(GlBuffers, InputIsNotWrittenByLaunches) {
    const unsigned glId = glBuffer(std::vector<float>(16, 8.0f));
    RTbuffer input = shared(RT_BUFFER_INPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    setEntries();
    ok(rtVariableSetObject(variable("image"), input));
    ok(rtContextLaunch2D(context_, 1, 2, 2));
    EXPECT_EQ(read(glId, 16), std::vector<float>(16, 8.0f));
}

TEST_F(GlBuffers, MapsShowAndChangeThem) {
    const unsigned glId = glBuffer<float>({1, 2, 3, 4});
    RTbuffer both = shared(RT_BUFFER_INPUT_OUTPUT, glId, RT_FORMAT_FLOAT, 4, 1);
    EXPECT_EQ(floats(both), (std::vector<float>{1, 2, 3, 4}));
    void* data = nullptr;
    ok(rtBufferMap(both, &data));
    static_cast<float*>(data)[2] = 30;
    ok(rtBufferUnmap(both));
    EXPECT_EQ(read(glId, 4), (std::vector<float>{1, 2, 30, 4}));
    ok(rtBufferMapEx(both, RT_BUFFER_MAP_READ, 0, nullptr, &data));
    EXPECT_EQ(static_cast<float*>(data)[2], 30);
    write(glId, {9, 9, 9, 9}); // while it is mapped for reading
    ok(rtBufferUnmap(both));
    EXPECT_EQ(read(glId, 4), (std::vector<float>{9, 9, 9, 9}));
    fails(RT_ERROR_INVALID_VALUE, rtBufferUnmap(both), "not mapped");
    ok(rtBufferMapEx(both, RT_BUFFER_MAP_WRITE_DISCARD, 0, nullptr, &data));
    std::fill_n(static_cast<float*>(data), 4, 5.0f);
    EXPECT_EQ(RT_ERROR_ALREADY_MAPPED, rtBufferGLUnregister(both));
    ok(rtBufferUnmap(both));
    EXPECT_EQ(read(glId, 4), std::vector<float>(4, 5.0f));
}

TEST_F(GlBuffers, StagesOfCommandListsFilterThem) {
    const unsigned from = glBuffer(std::vector<float>(16, 0.25f)),
                   to = glBuffer(std::vector<float>(16));
    RTbuffer input = shared(RT_BUFFER_INPUT, from, RT_FORMAT_FLOAT4, 2, 2),
             output = shared(RT_BUFFER_OUTPUT, to, RT_FORMAT_FLOAT4, 2, 2);
    RTpostprocessingstage tones = toneMapper(input, output);
    set(tones, "gamma", 1.0f);
    set(tones, "exposure", 2.0f);
    run(tones);
    EXPECT_EQ(read(to, 5), (std::vector<float>{0.5f, 0.5f, 0.5f, 0.25f, 0.5f}));
}

TEST_F(GlBuffers, ImmutableStorageIsWrittenToo) {
    unsigned glId = 0;
    const std::vector<float> zeros(16);
    egl().GenBuffers(1, &glId);
    egl().BindBuffer(kArrayBuffer, glId);
    egl().BufferStorage(kArrayBuffer, 64, zeros.data(), 0); // takes no data from the host
    egl().BindBuffer(kArrayBuffer, 0);
    RTbuffer output = shared(RT_BUFFER_OUTPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    setEntries();
    ok(rtVariableSetObject(variable("image"), output));
    ok(rtContextLaunch2D(context_, 0, 2, 2));
    EXPECT_EQ(read(glId, 4), (std::vector<float>{0.5f, 0.5f, 0.5f, 0.25f}));
}

TEST_F(GlBuffers, AreCheckedWhenMade) {
    const unsigned glId = glBuffer<float>({1});
    RTbuffer made = nullptr;
    unsigned id = 0;
    fails(RT_ERROR_INVALID_VALUE, rtBufferCreateFromGLBO(context_, RT_BUFFER_INPUT, glId, nullptr),
          "buffer is null");
    EXPECT_EQ(RT_ERROR_INVALID_CONTEXT,
              rtBufferCreateFromGLBO(nullptr, RT_BUFFER_INPUT, glId, &made));
    fails(RT_ERROR_INVALID_VALUE, rtBufferCreateFromGLBO(context_, RT_BUFFER_INPUT, 0, &made),
          "glId = 0");
    fails(RT_ERROR_INVALID_VALUE, rtBufferCreateFromGLBO(context_, RT_BUFFER_INPUT, 12345, &made),
          "glId = 12345 is not a buffer");
    const unsigned flags = unsigned(RT_BUFFER_INPUT_OUTPUT) | unsigned(RT_BUFFER_GPU_LOCAL);
    for (const unsigned description : {0u, flags, unsigned(RT_BUFFER_PROGRESSIVE_STREAM), ~0u})
        fails(RT_ERROR_INVALID_VALUE, rtBufferCreateFromGLBO(context_, description, glId, &made),
              "bufferdesc");
    EXPECT_EQ(made, nullptr);
    ok(rtBufferCreateFromGLBO(context_, RT_BUFFER_INPUT, glId, &made));
    ok(rtBufferGetGLBOId(made, &id));
    EXPECT_EQ(id, glId);
    fails(RT_ERROR_INVALID_VALUE, rtBufferGetGLBOId(made, nullptr), "glId is null");
    void* pointer = nullptr;
    ok(rtBufferSetFormat(made, RT_FORMAT_FLOAT));
    ok(rtBufferSetSize1D(made, 1));
    fails(RT_ERROR_INVALID_VALUE, rtBufferGetDevicePointer(made, 0, &pointer), "device pointer");
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetDevicePointer(made, 0, &id), "device pointer");
    ok(rtBufferDestroy(made));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtBufferGetGLBOId(made, &id));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtBufferGLRegister(made));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtBufferGLUnregister(made));
    EXPECT_EQ(read(glId, 1), std::vector<float>{1}) << "OpenGL's buffer stays";
}

TEST_F(GlBuffers, AreUsedWhileRegistered) {
    const unsigned glId = glBuffer(std::vector<float>(16, 8.0f));
    RTbuffer both = shared(RT_BUFFER_INPUT_OUTPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    setEntries();
    ok(rtVariableSetObject(variable("image"), both));
    fails(RT_ERROR_RESOURCE_ALREADY_REGISTERED, rtBufferGLRegister(both), "is registered");
    ok(rtContextLaunch2D(context_, 1, 2, 2));
    ok(rtBufferGLUnregister(both));
    fails(RT_ERROR_RESOURCE_NOT_REGISTERED, rtBufferGLUnregister(both), "not registered");
    void* data = nullptr;
    fails(RT_ERROR_INVALID_VALUE, rtBufferMap(both, &data), "not registered");
    fails(RT_ERROR_INVALID_VALUE, rtBufferValidate(both), "not registered");
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 1, 2, 2), "not registered");
    egl().BindBuffer(kArrayBuffer, glId); // OpenGL may change its size
    egl().BufferData(kArrayBuffer, 4 * 64, nullptr, kStaticDraw);
    egl().BindBuffer(kArrayBuffer, 0);
    write(glId, std::vector<float>(64, 6.0f));
    ok(rtBufferSetSize2D(both, 4, 4));
    ok(rtBufferGLRegister(both));
    ok(rtContextLaunch2D(context_, 1, 4, 4));
    EXPECT_EQ(read(glId, 64), std::vector<float>(64, 3.0f));
    // A buffer in place of another, and one with an id.
    ok(rtVariableSetObject(variable("image"), image(4, 4)));
    ok(rtContextLaunch2D(context_, 1, 4, 4));
    ok(rtBufferGLUnregister(both));
    ok(rtContextLaunch2D(context_, 1, 4, 4)); // no program refers to it
    ok(rtVariableSetObject(variable("image"), both));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 1, 4, 4), "not registered");
    ok(rtVariableSetObject(variable("image"), image(4, 4)));
    ok(rtContextLaunch2D(context_, 1, 4, 4));
    int id = 0;
    ok(rtBufferGetId(both, &id));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 1, 4, 4), "not registered");
    ok(rtBufferGLRegister(both));
    ok(rtContextLaunch2D(context_, 1, 4, 4));
}

TEST_F(GlBuffers, NeedRoomAndAFreeBufferInOpenGl) {
    const unsigned glId = glBuffer(std::vector<float>(15));
    RTbuffer output = shared(RT_BUFFER_OUTPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    setEntries();
    ok(rtVariableSetObject(variable("image"), output));
    void* data = nullptr;
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 0, 2, 2),
          "has 60 bytes, fewer than the 64");
    fails(RT_ERROR_INVALID_VALUE, rtBufferMap(output, &data), "60 bytes");
    ok(rtBufferSetSize2D(output, 2, 1));
    ok(rtContextLaunch2D(context_, 0, 2, 1));
    egl().BindBuffer(kArrayBuffer, glId);
    egl().MapBuffer(kArrayBuffer, kWriteOnly);
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 0, 2, 1), "mapped by OpenGL");
    egl().UnmapBuffer(kArrayBuffer);
    egl().BindBuffer(kArrayBuffer, 0);
    egl().DeleteBuffers(1, &glId);
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 0, 2, 1), "not a buffer");
    ok(rtBufferDestroy(output));
}

TEST_F(GlBuffers, NeedAContextThatIsCurrent) {
    const unsigned glId = glBuffer(std::vector<float>(16));
    RTbuffer output = shared(RT_BUFFER_OUTPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    setEntries();
    ok(rtVariableSetObject(variable("image"), output));
    std::thread([&] {
        fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 0, 2, 2),
              "no context of OpenGL is current");
    }).join();
    ok(rtContextLaunch2D(context_, 0, 2, 2));
    egl().release();
    RTbuffer other = nullptr;
    fails(RT_ERROR_INVALID_VALUE, rtBufferCreateFromGLBO(context_, RT_BUFFER_INPUT, glId, &other),
          "no context of OpenGL is current");
    egl().makeCurrent();
}

TEST_F(GlBuffers, ContextsOfOpenGlEsHaveNone) {
    RTbuffer made = nullptr;
    const bool isCurrent = egl().enterEs();
    if (isCurrent)
        fails(RT_ERROR_NOT_SUPPORTED, rtBufferCreateFromGLBO(context_, RT_BUFFER_INPUT, 1, &made),
              "\"OpenGL ES");
    egl().leaveEs();
    if (!isCurrent)
        GTEST_SKIP() << "EGL makes no context of OpenGL ES 3";
}

TEST_F(GlBuffers, LeaveTheStateOfOpenGlAlone) {
    const unsigned first = glBuffer(std::vector<float>(16)),
                   other = glBuffer(std::vector<float>(4));
    const unsigned own = texture(kTexture2D);
    const float texel[4] = {1, 2, 3, 4};
    egl().TexImage2D(kTexture2D, 0, kRgba32F, 1, 1, 0, kRgba, kFloat, texel);
    const unsigned bound = texture(kTexture2D);
    unsigned framebuffer = 0, renderbuffer = 0;
    egl().GenRenderbuffers(1, &renderbuffer);
    egl().BindRenderbuffer(kRenderbuffer, renderbuffer);
    egl().RenderbufferStorage(kRenderbuffer, unsigned(kRgba8), 2, 2);
    egl().BindRenderbuffer(kRenderbuffer, 0);
    egl().GenFramebuffers(1, &framebuffer);
    egl().BindFramebuffer(kReadFramebuffer, framebuffer);
    egl().BindBuffer(kArrayBuffer, other);
    egl().BindBuffer(kPixelPackBuffer, other);
    egl().BindBuffer(kCopyReadBuffer, other);
    // Row length, skipped rows and pixels, alignment; bindings of the objects above.
    const struct {
        unsigned name;
        int value;
    } pixels[] = {{0x0D02, 9}, {0x0D03, 1}, {0x0D04, 2}, {0x0D05, 8}},
      bindings[] = {{0x8894, int(other)}, {0x88ED, int(other)},       {0x8F36, int(other)},
                    {0x8069, int(bound)}, {0x8CAA, int(framebuffer)}, {0x8CA7, 0}};
    for (const auto& state : pixels)
        egl().PixelStorei(state.name, state.value);
    RTbuffer output = shared(RT_BUFFER_INPUT_OUTPUT, first, RT_FORMAT_FLOAT4, 2, 2);
    sampler(renderbuffer, RT_TARGET_GL_RENDER_BUFFER);
    sampler(own, RT_TARGET_GL_TEXTURE_2D);
    setEntries();
    ok(rtVariableSetObject(variable("image"), output));
    ok(rtContextLaunch2D(context_, 0, 2, 2));
    for (const auto& state : pixels) {
        EXPECT_EQ(egl().integer(state.name), state.value) << std::hex << state.name;
        egl().PixelStorei(state.name, state.name == 0x0D05 ? 4 : 0);
    }
    for (const auto& state : bindings)
        EXPECT_EQ(egl().integer(state.name), state.value) << std::hex << state.name;
    egl().BindBuffer(kArrayBuffer, 0);
    egl().BindBuffer(kPixelPackBuffer, 0);
    egl().BindBuffer(kCopyReadBuffer, 0);
    egl().BindFramebuffer(kReadFramebuffer, 0);
}

// ---- Images ------------------------------------------------------------------------------------

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

// ---- OptiXpp -----------------------------------------------------------------------------------

TEST_F(Gl, TheWrapperForwards) {
    optix::Context context = optix::Context::create();
    const unsigned glId = glBuffer(std::vector<float>(4, 3.0f)), image = texture(kTexture2D);
    const float texel[4] = {1, 2, 3, 4};
    egl().TexImage2D(kTexture2D, 0, kRgba32F, 1, 1, 0, kRgba, kFloat, texel);
    optix::Buffer buffer = context->createBufferFromGLBO(RT_BUFFER_INPUT, glId);
    buffer->setFormat(RT_FORMAT_FLOAT);
    buffer->setSize(4);
    EXPECT_EQ(buffer->getGLBOId(), glId);
    EXPECT_EQ(static_cast<float*>(buffer->map())[3], 3.0f);
    buffer->unmap();
    buffer->unregisterGLBuffer();
    EXPECT_THROW(buffer->map(), optix::Exception);
    buffer->registerGLBuffer();
    optix::TextureSampler sampler =
        context->createTextureSamplerFromGLImage(image, RT_TARGET_GL_TEXTURE_2D);
    unsigned id = 0;
    ok(rtTextureSamplerGetGLImageId(sampler->get(), &id));
    EXPECT_EQ(id, image);
    sampler->unregisterGLTexture();
    EXPECT_THROW(sampler->unregisterGLTexture(), optix::Exception);
    sampler->registerGLTexture();
    context->destroy();
}

// ---- Without OpenGL ----------------------------------------------------------------------------

class WithoutGl : public Post {};

TEST_F(WithoutGl, OtherObjectsShareNothing) {
    RTbuffer buffer = image(1, 1);
    RTtexturesampler sampler = nullptr;
    unsigned id = 7;
    ok(rtTextureSamplerCreate(context_, &sampler));
    ok(rtBufferGetGLBOId(buffer, &id));
    EXPECT_EQ(id, 0u);
    id = 7;
    ok(rtTextureSamplerGetGLImageId(sampler, &id));
    EXPECT_EQ(id, 0u);
    fails(RT_ERROR_INVALID_VALUE, rtBufferGLRegister(buffer), "shares nothing with OpenGL");
    fails(RT_ERROR_INVALID_VALUE, rtBufferGLUnregister(buffer), "shares nothing");
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerGLRegister(sampler), "shares nothing");
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerGLUnregister(sampler), "shares nothing");
    for (void* none : {static_cast<void*>(nullptr), reinterpret_cast<void*>(uintptr_t(0x1234)),
                       static_cast<void*>(context_)}) {
        const auto noBuffer = static_cast<RTbuffer>(none);
        const auto noSampler = static_cast<RTtexturesampler>(none);
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtBufferGetGLBOId(noBuffer, &id));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtBufferGLRegister(noBuffer));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtBufferGLUnregister(noBuffer));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtTextureSamplerGetGLImageId(noSampler, &id));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtTextureSamplerGLRegister(noSampler));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtTextureSamplerGLUnregister(noSampler));
    }
}

// In a process of its own, which has not loaded EGL.
TEST_F(WithoutGl, CreationSaysSo) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(
        {
            RTbuffer buffer = nullptr;
            RTtexturesampler sampler = nullptr;
            fails(RT_ERROR_NOT_SUPPORTED,
                  rtBufferCreateFromGLBO(context_, RT_BUFFER_INPUT, 1, &buffer),
                  "no library of OpenGL");
            fails(RT_ERROR_NOT_SUPPORTED,
                  rtTextureSamplerCreateFromGLImage(context_, 1, RT_TARGET_GL_TEXTURE_2D, &sampler),
                  "no library of OpenGL");
            std::_Exit(HasFailure() ? 1 : 0);
        },
        testing::ExitedWithCode(0), "");
}

TEST_F(WithoutGl, GpusOfWindowsAreNotSupported) {
    int device = 0, handle = 0;
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtDeviceGetWGLDevice(nullptr, &handle));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtDeviceGetWGLDevice(&device, nullptr));
    EXPECT_EQ(RT_ERROR_NOT_SUPPORTED, rtDeviceGetWGLDevice(&device, &handle));
}

} // namespace
} // namespace sunstone::api6
