// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optix_math.h>

using namespace optix;

rtDeclareVariable(uint2, pixel, rtLaunchIndex, );
rtDeclareVariable(uint2, screen, rtLaunchDim, );
rtDeclareVariable(uint3, place, rtLaunchIndex, );
rtDeclareVariable(uint3, room, rtLaunchDim, );
rtDeclareVariable(unsigned int, number, rtLaunchIndex, );
rtDeclareVariable(unsigned int, frame, , );
rtDeclareVariable(float, level, , );
rtDeclareVariable(int, fail_at, , ) = -1;
rtDeclareVariable(float4, bad_color, , );
rtDeclareVariable(rtObject, top_object, , );

rtBuffer<uchar4, 2> output_buffer;
rtBuffer<float4, 2> accum_buffer;
rtBuffer<int, 3> grid;
rtBuffer<float, 1> line;
rtBuffer<int, 1> codes;

rtTextureSampler<float4, 2> mip_texture;
rtTextureSampler<uchar4, 2, cudaReadModeNormalizedFloat> byte_texture;

RT_PROGRAM void draw() {
    if ((int)(pixel.y * screen.x + pixel.x) == fail_at)
        rtThrow(RT_EXCEPTION_USER + 77);
    const float4 texel =
        tex2DLod(mip_texture, (pixel.x + 0.5f) / screen.x, (pixel.y + 0.5f) / screen.y, level);
    const float4 bytes = tex2D(byte_texture, (pixel.x + 0.5f) / screen.x, 0.5f);
    float4 value = texel + bytes * 255.0f + make_float4(frame);
    if (frame > 0)
        value = lerp(accum_buffer[pixel], value, 1.0f / (frame + 1));
    accum_buffer[pixel] = value;
    output_buffer[pixel] = make_uchar4(value.x, value.y, value.z, 255);
}

RT_PROGRAM void fill_grid() {
    grid[place] += place.x + 10 * place.y + 100 * place.z + 1000 * (room.x * room.y * room.z);
}

RT_PROGRAM void fill_line() {
    line[number] = line.size() + number;
    if (fail_at >= 0)
        line[number + 1000] = 1; // far outside
}

struct Hit {
    float value;
};
rtDeclareVariable(Hit, hit, rtPayload, );
RT_PROGRAM void look_into_nothing() {
    Hit none;
    none.value = 5;
    rtTrace(top_object, make_Ray(make_float3(0, 0, 9), make_float3(0, 0, -1), 1, 0, 1e9f), none);
    line[number] = none.value;
}

RT_PROGRAM void on_exception() {
    const unsigned int code = rtGetExceptionCode();
    codes[0] = code;
    output_buffer[pixel] =
        make_uchar4(bad_color.x * 255, bad_color.y * 255, bad_color.z * 255, 255);
}
RT_PROGRAM void on_line_exception() {
    atomicAdd(&codes[1], 1);
    codes[2] = rtGetExceptionCode();
}
