// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optix_math.h>

using namespace optix;

rtDeclareVariable(uint3, voxel, rtLaunchIndex, );
rtDeclareVariable(uint3, voxels, rtLaunchDim, );
rtDeclareVariable(float, scale, , ) = 1.0f;
rtDeclareVariable(int, volume, , );
rtDeclareVariable(rtObject, top, , );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, found, rtPayload, );
rtBuffer<float4, 3> samples;
rtBuffer<int, 1> volumes; // ids of samplers

RT_PROGRAM void sample() {
    const float3 p = (make_float3(voxel) + make_float3(0.5f)) / make_float3(voxels) * 3.0f - 1.0f;
    const int id = volumes[volume];
    float depth = -1;
    rtTrace(top, make_Ray(make_float3(0, 0, 1), make_float3(0, 0, -1), 0, 0, 1e6f), depth);
    samples[voxel] = make_float4(rtTex3D<float>(id, p.x, p.y, p.z), scale, depth,
                                 rtTex3DFetch<float>(id, 1, 2, 3));
}

rtDeclareVariable(float, height, , );
RT_PROGRAM void plane_bounds(int, float result[6]) {
    for (int i = 0; i < 3; ++i) {
        result[i] = i == 2 ? height : -1;
        result[i + 3] = i == 2 ? height : 1;
    }
}
RT_PROGRAM void plane(int) {
    const float t = (height - ray.origin.z) / ray.direction.z;
    if (rtPotentialIntersection(t))
        rtReportIntersection(0);
}
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
RT_PROGRAM void hit() {
    found = t_hit;
}
