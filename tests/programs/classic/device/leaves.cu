// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optix_math.h>

using namespace optix;

struct Radiance {
    float3 color;
    int tree;
    int crossed; // holes that any-hit programs let the ray through
};
struct Shadow {
    float light;
    int tested;
};

rtDeclareVariable(rtObject, forest, , );
rtDeclareVariable(uint2, pixel, rtLaunchIndex, );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(Radiance, radiance, rtPayload, );
rtDeclareVariable(Shadow, shadow, rtPayload, );
rtDeclareVariable(float, step, , );
rtDeclareVariable(float, extent, , );
rtDeclareVariable(unsigned int, mask, , ) = 255;
rtDeclareVariable(unsigned int, flags, , ) = 0;
rtBuffer<float4, 2> image;

RT_PROGRAM void look_down() {
    Radiance seen;
    seen.color = make_float3(0);
    seen.tree = -1;
    seen.crossed = 0;
    const float x = pixel.x * step - extent, z = pixel.y * step - extent;
    rtTrace(forest, make_Ray(make_float3(x, 10, z), make_float3(0, -1, 0), 0, 0.0f, 100.0f), seen,
            (RTvisibilitymask)mask, (RTrayflags)flags);
    Shadow above;
    above.light = 1;
    above.tested = 0;
    rtTrace(forest, make_Ray(make_float3(x, 0.5f, z), make_float3(0, 1, 0), 1, 0.0f, 100.0f), above,
            (RTvisibilitymask)mask, (RTrayflags)flags);
    image[pixel] = make_float4(seen.color.x, seen.tree, seen.crossed, above.light);
}

// ---- leaves: two triangles each, with a texture whose alpha is a checkerboard
rtBuffer<int3> index_buffer;
rtBuffer<float2> texcoord_buffer;
rtTextureSampler<float4, 2> leaf_texture;
rtDeclareVariable(float2, uv, attribute uv, );
rtDeclareVariable(int, tree, , ) = -5;

RT_PROGRAM void leaf_attributes() {
    const int3 corners = index_buffer[rtGetPrimitiveIndex()];
    const float2 b = rtGetTriangleBarycentrics();
    uv = texcoord_buffer[corners.x] * (1 - b.x - b.y) + texcoord_buffer[corners.y] * b.x +
         texcoord_buffer[corners.z] * b.y;
}
static __device__ float alpha() {
    return tex2D(leaf_texture, uv.x, uv.y).w;
}
RT_PROGRAM void leaf_any_hit() {
    if (alpha() < 0.5f) {
        ++radiance.crossed;
        rtIgnoreIntersection();
    }
}
RT_PROGRAM void leaf_shadow() {
    ++shadow.tested;
    const float a = alpha();
    shadow.light *= 1 - a;
    if (shadow.light < 0.01f)
        rtTerminateRay();
    rtIgnoreIntersection();
}
RT_PROGRAM void leaf_closest() {
    radiance.color = make_float3(t_hit);
    radiance.tree = tree;
}

// ---- the ground is custom geometry of the same group
RT_PROGRAM void ground_bounds(int, float result[6]) {
    result[0] = result[2] = -100;
    result[3] = result[5] = 100;
    result[1] = result[4] = 0;
}
RT_PROGRAM void ground(int) {
    const float t = -ray.origin.y / ray.direction.y;
    if (rtPotentialIntersection(t)) {
        uv = make_float2(-1);
        rtReportIntersection(0);
    }
}
RT_PROGRAM void ground_closest() {
    radiance.color = make_float3(t_hit + (uv.x == -1 ? 0 : 1000));
    radiance.tree = 99;
}
