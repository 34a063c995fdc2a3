// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optixu/optixu_aabb_namespace.h>
#include <optixu/optixu_math_namespace.h>

using namespace optix;

struct PerRayData {
    float height;
    float weight;
    uint3 color;
};

rtDeclareVariable(float3, eye, , );
rtDeclareVariable(float2, extent, , );
rtDeclareVariable(unsigned int, frame, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(float, miss_height, , );
rtDeclareVariable(rtObject, top_object, , );
rtBuffer<uchar4, 2> output_buffer;
rtBuffer<float4, 2> accum_buffer;

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(PerRayData, prd, rtPayload, );
rtDeclareVariable(float3, shading_normal, attribute shading_normal, );
rtDeclareVariable(float3, geometric_normal, attribute geometric_normal, );

static __device__ PerRayData shoot(float2 jitter) {
    const float2 place =
        (make_float2(launch_index) + jitter) / make_float2(launch_dim) * 2.0f - 1.0f;
    const float3 from = eye + make_float3(place.x * extent.x, 0.0f, place.y * extent.y);
    PerRayData data;
    data.color = make_uint3(0u);
    rtTrace(top_object,
            make_Ray(from, make_float3(0.0f, -1.0f, 0.0f), 0, scene_epsilon, RT_DEFAULT_MAX), data);
    return data;
}

RT_PROGRAM void orthographic_camera() {
    const PerRayData data = shoot(make_float2(frame * 7 % 16, frame * 11 % 16) / 16.0f);
    const float4 now = make_float4(data.height, data.height, data.height, data.weight);
    if (frame > 1)
        accum_buffer[launch_index] = lerp(accum_buffer[launch_index], now, 1.0f / float(frame));
    else
        accum_buffer[launch_index] = now;
}

RT_PROGRAM void show_material() {
    const uint3 color = shoot(make_float2(0.5f)).color;
    output_buffer[launch_index] = make_uchar4(color.x, color.y, color.z, 255);
}

RT_PROGRAM void miss() {
    prd.height = miss_height;
    prd.weight = 0.0f;
}

RT_PROGRAM void exception() {
    rtPrintExceptionDetails();
    accum_buffer[launch_index] = make_float4(1e9f);
}

rtDeclareVariable(uint3, Kd, , "diffuse colour");

RT_PROGRAM void closest_hit() {
    const float3 n = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, shading_normal));
    const float3 g = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, geometric_normal));
    prd.height = (ray.origin + t_hit * ray.direction).y;
    // All normals look up, and the smooth ones are near those of the triangles.
    prd.weight = n.y > 0.0f && g.y > 0.0f && dot(n, g) > 0.97f ? 1.0f : -1000.0f;
    prd.color = Kd;
}

// ---- the mesh

rtBuffer<float3> vertex_buffer;
rtBuffer<float3> normal_buffer;
rtBuffer<int3> index_buffer;
rtBuffer<int> material_buffer;

RT_PROGRAM void mesh_intersect(int primIdx) {
    const int3 v_idx = index_buffer[primIdx];
    const float3 p0 = vertex_buffer[v_idx.x], p1 = vertex_buffer[v_idx.y],
                 p2 = vertex_buffer[v_idx.z];
    float3 n;
    float t, beta, gamma;
    if (intersect_triangle(ray, p0, p1, p2, n, t, beta, gamma) && rtPotentialIntersection(t)) {
        geometric_normal = normalize(n);
        shading_normal = normalize(normal_buffer[v_idx.y] * beta + normal_buffer[v_idx.z] * gamma +
                                   normal_buffer[v_idx.x] * (1.0f - beta - gamma));
        rtReportIntersection(material_buffer[primIdx]);
    }
}

RT_PROGRAM void mesh_bounds(int primIdx, float result[6]) {
    const int3 v_idx = index_buffer[primIdx];
    const float3 v0 = vertex_buffer[v_idx.x], v1 = vertex_buffer[v_idx.y],
                 v2 = vertex_buffer[v_idx.z];
    const float area = length(cross(v1 - v0, v2 - v0));
    optix::Aabb* aabb = (optix::Aabb*)result;
    if (area > 0.0f && !isinf(area)) {
        aabb->m_min = fminf(fminf(v0, v1), v2);
        aabb->m_max = fmaxf(fmaxf(v0, v1), v2);
    } else {
        aabb->invalidate();
    }
}

RT_PROGRAM void mesh_attributes() {
    const int3 v_idx = index_buffer[rtGetPrimitiveIndex()];
    const float2 b = rtGetTriangleBarycentrics();
    const float3 p0 = vertex_buffer[v_idx.x];
    geometric_normal = normalize(cross(vertex_buffer[v_idx.y] - p0, vertex_buffer[v_idx.z] - p0));
    shading_normal = normalize(normal_buffer[v_idx.y] * b.x + normal_buffer[v_idx.z] * b.y +
                               normal_buffer[v_idx.x] * (1.0f - b.x - b.y));
}
