// SPDX-License-Identifier: Apache-2.0
// Buffers that share their elements with OpenGL (section 5.14), and processes without OpenGL.
#include "gl_support.h"

#include "optix_cuda_interop.h"
#include "optixu/optixpp_namespace.h"

#include <chrono>
#include <thread>

namespace sunstone::api6 {
namespace {

using GlBuffers = Gl;

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

// OpenGL deletes a buffer that no program reads. A launch must not copy it, because the copy would
// fail.
TEST_F(GlBuffers, ThatProgramsCannotReachAreNotCopied) {
    const unsigned glId = glBuffer(std::vector<float>(16, 8.0f)), other = glBuffer<float>({1, 2});
    RTbuffer both = shared(RT_BUFFER_INPUT_OUTPUT, glId, RT_FORMAT_FLOAT4, 2, 2);
    RTbuffer unread = shared(RT_BUFFER_OUTPUT, other, RT_FORMAT_FLOAT, 2, 1);
    setEntries();
    ok(rtVariableSetObject(variable("image"), both));
    ok(rtVariableSetObject(variable("no_program_has_it"), unread));
    ok(rtContextLaunch2D(context_, 1, 2, 2));
    write(other, {3, 4});
    egl().DeleteBuffers(1, &other);
    ok(rtContextLaunch2D(context_, 1, 2, 2));
    EXPECT_EQ(read(glId, 16), std::vector<float>(16, 2.0f));
    // With an id, the buffer is reachable for programs.
    int id = 0;
    ok(rtBufferGetId(unread, &id));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch2D(context_, 1, 2, 2));
}

TEST_F(GlBuffers, ThatGeometryReadsAreCopied) {
    const unsigned glId = glBuffer<float>({0, 0, 5, 1, 0, 5, 0, 1, 5});
    RTbuffer corners = shared(RT_BUFFER_INPUT, glId, RT_FORMAT_FLOAT3, 3, 1);
    RTgeometrytriangles mesh = nullptr;
    ok(rtGeometryTrianglesCreate(context_, &mesh));
    ok(rtGeometryTrianglesSetPrimitiveCount(mesh, 1));
    ok(rtGeometryTrianglesSetVertices(mesh, 3, corners, 0, 12, RT_FORMAT_FLOAT3));
    RTmaterial paint = nullptr;
    ok(rtMaterialCreate(context_, &paint));
    ok(rtMaterialSetClosestHitProgram(paint, 0, program("hit_distance_only")));
    RTgeometryinstance instance = nullptr;
    ok(rtGeometryInstanceCreate(context_, &instance));
    ok(rtGeometryInstanceSetGeometryTriangles(instance, mesh));
    ok(rtGeometryInstanceSetMaterialCount(instance, 1));
    ok(rtGeometryInstanceSetMaterial(instance, 0, paint));
    RTacceleration acceleration = nullptr;
    ok(rtAccelerationCreate(context_, &acceleration));
    ok(rtAccelerationSetBuilder(acceleration, "Trbvh"));
    RTgeometrygroup top = nullptr;
    ok(rtGeometryGroupCreate(context_, &top));
    ok(rtGeometryGroupSetAcceleration(top, acceleration));
    ok(rtGeometryGroupSetChildCount(top, 1));
    ok(rtGeometryGroupSetChild(top, 0, instance));
    ok(rtVariableSetObject(variable("top_object"), top));
    for (const char* name : {"step", "mark"})
        ok(rtVariableSet1f(variable(name), 0));
    for (const char* name : {"ray_type", "flags"})
        ok(rtVariableSet1ui(variable(name), 0));
    EXPECT_EQ(launch("shoot")[3], 5);
    write(glId, {0, 0, 7, 1, 0, 7, 0, 1, 7});
    ok(rtAccelerationMarkDirty(acceleration));
    ok(rtContextLaunch1D(context_, 0, 1));
    EXPECT_EQ(results()[3], 3);
}

TEST_F(GlBuffers, ProgressiveLaunchesReadTheElementsOfOpenGl) {
    const unsigned glId = glBuffer(std::vector<float>(4));
    const auto flat = [&](unsigned type, RTformat format) {
        RTbuffer made = nullptr;
        ok(rtBufferCreate(context_, type, &made));
        ok(rtBufferSetFormat(made, format));
        ok(rtBufferSetSize2D(made, 1, 1));
        return made;
    };
    RTbuffer picture = flat(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4);
    RTbuffer stream = flat(RT_BUFFER_PROGRESSIVE_STREAM, RT_FORMAT_UNSIGNED_BYTE4);
    ok(rtBufferBindProgressiveStream(stream, picture));
    ok(rtVariableSetObject(variable("image"),
                           shared(RT_BUFFER_INPUT, glId, RT_FORMAT_FLOAT4, 1, 1)));
    ok(rtVariableSetObject(variable("picture"), picture));
    setEntry("show_image");
    write(glId, std::vector<float>(4, 1.0f));
    ok(rtContextLaunchProgressive2D(context_, 0, 1, 1, 1));
    int isReady = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!isReady && std::chrono::steady_clock::now() < end)
        ok(rtBufferGetProgressiveUpdateReady(stream, &isReady, nullptr, nullptr));
    void* bytes = nullptr;
    ok(rtBufferMap(stream, &bytes));
    EXPECT_EQ(static_cast<unsigned char*>(bytes)[0], 255);
    ok(rtBufferUnmap(stream));
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

// Runs in a separate process, which has not loaded EGL.
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
