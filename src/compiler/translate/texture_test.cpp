// SPDX-License-Identifier: Apache-2.0
// Texture and surface instructions: each form finds its operands and its results.
#include "compiler/testing.h"
#include "texture/texture.h"

namespace sunstone::compiler::testing {
namespace {

using namespace sunstone::texture;

// Texel (x, y, z) of channel c is x + 10 y + 100 z + 1000 c.
std::shared_ptr<Array> numbered(Shape shape) {
    auto array = std::make_shared<Array>(Format{Channel::kF32, 4}, shape);
    auto* texel = reinterpret_cast<float*>(array->data());
    for (uint32_t z = 0; z < shape.slices(); ++z)
        for (uint32_t y = 0; y < shape.rows(); ++y)
            for (uint32_t x = 0; x < shape.width; ++x)
                for (uint32_t c = 0; c < 4; ++c)
                    *texel++ = float(x + 10 * y + 100 * z + 1000 * c);
    return array;
}

uint64_t textureOf(const std::shared_ptr<Array>& array) {
    auto texture = std::make_unique<Texture>();
    texture->format = array->format();
    texture->images[0] = array->image();
    texture->layered = array->shape().layered;
    texture->cube = array->shape().cube;
    texture->is3D = array->shape().depth && !texture->layered && !texture->cube;
    texture->normalizedCoordinates = texture->cube;
    texture->arrays = {array};
    return texture::add(std::move(texture));
}
uint64_t surfaceOf(const std::shared_ptr<Array>& array) {
    auto surface = std::make_unique<Surface>();
    surface->array = array;
    return texture::add(std::move(surface));
}

TEST(Textures, EveryGeometry) {
    const uint64_t line = textureOf(numbered({8})), flat = textureOf(numbered({8, 8})),
                   volume = textureOf(numbered({4, 4, 4})),
                   lines = textureOf(numbered({8, 0, 4, true})),
                   flats = textureOf(numbered({8, 8, 4, true})),
                   cube = textureOf(numbered({4, 4, 6, false, true}));
    const uint64_t x = bits(3.5f), y = bits(2.5f), z = bits(1.5f);
    run({
        {"tex.1d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f2}];", {line, x}, 'f', bits(3.0f)},
        {"tex.1d.v4.f32.f32 {_, _, _, %f0}, [%rd1, {%f2}];", {line, x}, 'f', bits(3003.0f)},
        {"tex.1d.v4.u32.s32 {%r0, _, _, _}, [%rd1, {%r2}];", {line, 5}, 'r', bits(5.0f)},
        {"tex.2d.v4.f32.f32 {_, %f0, _, _}, [%rd1, {%f2, %f3}];", {flat, x, y}, 'f', bits(1023.0f)},
        {"tex.2d.v4.s32.f32 {%r0, _, _, _}, [%rd1, {%f2, %f3}];", {flat, x, y}, 'r', bits(23.0f)},
        {"tex.2d.v4.f16.f32 {%rs0, _, _, _}, [%rd1, {%f2, %f3}];", {flat, x, y}, 's', 0x4DC0},
        {"tex.2d.v4.f32.s32 {%f0, _, _, _}, [%rd1, {%r2, %r3}];", {flat, 6, 7}, 'f', bits(76.0f)},
        {"tex.3d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f2, %f3, %f4, %f4}];",
         {volume, x, y, z},
         'f',
         bits(123.0f)},
        {"tex.a1d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%r2, %f3}];",
         {lines, 2, x},
         'f',
         bits(203.0f)},
        {"tex.a2d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%r2, %f3, %f4, %f4}];",
         {flats, 3, x, y},
         'f',
         bits(323.0f)},
        {"tex.cube.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f2, %f3, %f4, %f4}];",
         {cube, bits(0.1f), bits(-1.0f), bits(0.1f)},
         'f',
         bits(312.0f)},
        {"tex.level.2d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f2, %f3}], %f4;",
         {flat, x, y, z},
         'f',
         bits(23.0f)},
        {"tex.grad.2d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f2, %f3}], {%f4, %f4}, {%f4, %f4};",
         {flat, x, y, z},
         'f',
         bits(23.0f)},
        {"tld4.b.2d.v4.f32.f32 {_, _, %f0, _}, [%rd1, {%f2, %f3}];",
         {flat, x, y},
         'f',
         bits(2024.0f)},
        {"tex.2d.v4.f32.f32 {%f0, _, _, _}|%p5, [%rd1, {%f2, %f3}]; selp.f32 %f0, %f0, 0f00000000, "
         "%p5;",
         {flat, x, y},
         'f',
         bits(23.0f)},
        {"txq.width.b32 %r0, [%rd1];", {flat}, 'r', 8},
        {"txq.depth.b32 %r0, [%rd1];", {volume}, 'r', 4},
        {"tex.2d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f2, %f3}];", {0x1234567890, x, y}, 'f', 0},
        // under a guard
        {"mov.f32 %f0, 0f3F800000; @%p2 tex.2d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f3, %f4}];",
         {flat, 0, x, y},
         'f',
         bits(1.0f)},
        {"mov.f32 %f0, 0f3F800000; @%p2 tex.2d.v4.f32.f32 {%f0, _, _, _}, [%rd1, {%f3, %f4}];",
         {flat, 1, x, y},
         'f',
         bits(23.0f)},
    });
    for (const uint64_t handle : {line, flat, volume, lines, flats, cube})
        EXPECT_TRUE(removeTexture(handle));
}

TEST(Surfaces, LoadStoreReduce) {
    auto array = std::make_shared<Array>(Format{Channel::kU32, 2}, Shape{8, 4});
    auto* texels = reinterpret_cast<uint32_t*>(array->data());
    for (uint32_t i = 0; i < 64; ++i)
        texels[i] = i * 3;
    const uint64_t surface = surfaceOf(array);
    const uint32_t third = texels[(2 * 8 + 3) * 2];
    run({
        {"suld.b.2d.v2.b32.trap {%r0, %r9}, [%rd1, {%r2, %r3}];", {surface, 24, 2}, 'r', third},
        {"suld.b.2d.v2.b32.trap {%r9, %r0}, [%rd1, {%r2, %r3}];", {surface, 24, 2}, 'r', third + 3},
        {"suld.b.2d.b8.clamp {%rs0}, [%rd1, {%r2, %r3}];", {surface, 24, 2}, 's', third & 255},
        {"suld.b.2d.b64.zero %rd0, [%rd1, {%r2, %r3}];", {surface, 64, 2}, 'd', 0},
        {"suld.b.2d.b32.clamp %r0, [%rd1, {%r2, %r3}];", {surface, 4000, 50}, 'r', 63 * 3},
        {"suq.width.b32 %r0, [%rd1];", {surface}, 'r', 8},
        {"sust.b.2d.b32.zero [%rd1, {%r2, %r3}], %r4; suld.b.2d.b32.trap %r0, [%rd1, {%r2, %r3}];",
         {surface, 8, 1, 77},
         'r',
         77},
        {"sust.b.2d.v2.b32.zero [%rd1, {%r2, %r3}], {%r4, %r4}; mov.u32 %r0, 5;",
         {surface, 64, 1, 77},
         'r',
         5},
        {"sured.b.max.2d.u32.trap [%rd1, {%r2, %r3}], %r4; suld.b.2d.b32.trap %r0, [%rd1, {%r2, "
         "%r3}];",
         {surface, 0, 3, 1000},
         'r',
         1000},
    });
    EXPECT_EQ(texels[18], 77u);
    EXPECT_EQ(texels[32], 96u); // no write outside
    EXPECT_TRUE(removeSurface(surface));
}

TEST(Textures, ReferencesHoldHandles) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.visible .global .texref picture;
.visible .entry k(.param .u64 out) { .reg .f32 %f<9>; .reg .b64 %rd<3>; ld.param.u64 %rd1, [out];
  mov.f32 %f5, 0f40200000; mov.u64 %rd2, picture;
  tex.2d.v4.f32.f32 {%f1, _, _, _}, [picture, {%f5, %f5}];
  tex.2d.v4.f32.f32 {%f2, _, _, _}, [%rd2, {%f5, %f5}];
  st.f32 [%rd1], %f1; st.f32 [%rd1+4], %f2; ret; }
)"));
    void* variable = nullptr;
    uint64_t size = 0;
    ASSERT_TRUE(code->variable("picture", &variable, &size));
    ASSERT_EQ(size, 8u);
    const uint64_t handle = textureOf(numbered({8, 8}));
    std::memcpy(variable, &handle, sizeof handle);
    float out[2] = {};
    const void* parameters[1] = {out};
    devlib::KernelThread thread{};
    ASSERT_TRUE(code->kernels()[0].address) << code->kernels()[0].unsupported;
    reinterpret_cast<devlib::KernelFn>(const_cast<void*>(code->kernels()[0].address))(&thread,
                                                                                      parameters);
    EXPECT_EQ(out[0], 22);
    EXPECT_EQ(out[1], 22);
    EXPECT_TRUE(removeTexture(handle));
}

int32_t thrown;

TEST(Textures, OptixPrograms) {
    PipelineRequest request;
    request.rules.launchParams = "params";
    request.programs.push_back({source(std::string(kHeader) + R"(
.visible .const .align 8 .b8 params[24];
.visible .entry __raygen__sample() { .reg .f32 %f<9>; .reg .b32 %r<3>; .reg .b64 %rd<4>;
  ld.const.u64 %rd1, [params]; ld.const.u64 %rd2, [params+8]; ld.const.u64 %rd3, [params+16];
  mov.f32 %f5, 0f40200000; mov.u32 %r1, 4096;
  tex.2d.v4.f32.f32 {%f1, %f2, %f3, %f4}, [%rd1, {%f5, %f5}];
  st.f32 [%rd3], %f2;
  suld.b.2d.b32.trap %r2, [%rd2, {%r1, %r1}];
  st.u32 [%rd3], %r2; ret; }
)"),
                                "__raygen__sample", ProgramKind::kRaygen});
    const auto code = compilePipeline(request);
    const uint64_t texture = textureOf(numbered({8, 8})), surface = surfaceOf(numbered({8, 8}));
    float out = 0;
    float* const address = &out;
    uint8_t params[24];
    std::memcpy(params, &texture, 8);
    std::memcpy(params + 8, &surface, 8);
    std::memcpy(params + 16, &address, 8);
    devlib::LaunchState launch{};
    launch.params = params;
    thrown = 0;
    launch.throwException = [](devlib::RayState*, int32_t kind, uint32_t, const uint32_t*) {
        thrown = kind;
    };
    devlib::ThreadState thread{};
    devlib::RayState ray{};
    ray.launch = &launch;
    ray.thread = &thread;
    reinterpret_cast<devlib::ProgramFn>(const_cast<void*>(code->programs()[0].address))(&ray);
    EXPECT_EQ(out, 1022);
    EXPECT_EQ(thrown, devlib::kExceptionTrap); // the address was outside the surface
    EXPECT_TRUE(removeTexture(texture));
    EXPECT_TRUE(removeSurface(surface));
}

TEST(Textures, FormsThatAreMissingSaySo) {
    for (const char* text : {"tex.2d.v4.f32.f32 {%f1, %f2, %f3, %f4}, [%rd1, %rd1, {%f1, %f2}];",
                             "tld4.r.2d.v4.f32.f32 {%f1, %f2, %f3, %f4}, [%rd1, {%f1, %f2}], "
                             "{%r1, %r2};"}) {
        const auto code = compileKernels(
            parse(std::string(kHeader) +
                  ".visible .entry k() { .reg .f32 %f<9>; .reg .b32 %r<3>; .reg .b64 %rd<3>; " +
                  text + " ret; }"));
        EXPECT_FALSE(code->kernels()[0].address) << text;
        EXPECT_NE(code->kernels()[0].unsupported.find("not available"), std::string::npos)
            << code->kernels()[0].unsupported;
    }
}

} // namespace
} // namespace sunstone::compiler::testing
