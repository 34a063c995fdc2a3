// SPDX-License-Identifier: Apache-2.0
// The path tracer as programs of the classic API.
#include <optix_world.h>

#include "tracer_math.h"

using namespace twin;

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(twin::Camera, camera, , );
rtDeclareVariable(unsigned int, samples, , );
rtBuffer<float4, 2> picture;

rtDeclareVariable(twin::Path, path, rtRayPayload, );
rtDeclareVariable(int, blocked, rtRayPayload, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(float3, normal_attribute, attribute normal_attribute, );
rtDeclareVariable(float3, albedo, , );
rtBuffer<float3> vertices;
rtBuffer<uint3> indices;
rtBuffer<float4> spheres;

RT_PROGRAM void trace_paths() {
    unsigned seed = hash(launch_index.x + launch_dim.x * launch_index.y);
    V3 sum = vec(0, 0, 0);
    for (unsigned i = 0; i < samples; ++i) {
        Path p =
            cameraPath(camera, seed, launch_index.x, launch_index.y, launch_dim.x, launch_dim.y);
        for (unsigned depth = 0; depth < kSegments && !p.done; ++depth) {
            optix::Ray next(make_float3(p.origin.x, p.origin.y, p.origin.z),
                            make_float3(p.direction.x, p.direction.y, p.direction.z), kPathRay,
                            kEpsilon, kFar);
            rtTrace(top_object, next, p);
        }
        sum = sum + p.light;
        seed = p.seed;
    }
    picture[launch_index] = make_float4(sum.x / samples, sum.y / samples, sum.z / samples, 1.0f);
}

RT_PROGRAM void miss_path() {
    meetSky(path);
}

RT_PROGRAM void hit_path() {
    const float3 world = rtTransformNormal(RT_OBJECT_TO_WORLD, normal_attribute);
    const V3 normal = facing(normalize(vec(world.x, world.y, world.z)), path.direction);
    const V3 point = path.origin + path.direction * hit_distance;
    path.weight = path.weight * vec(albedo.x, albedo.y, albedo.z);
    const float cosine = sunCosine(normal);
    if (cosine > 0) {
        int payload = 0;
        const V3 sun = toSun();
        optix::Ray shadow(make_float3(point.x, point.y, point.z), make_float3(sun.x, sun.y, sun.z),
                          kShadowRay, kEpsilon, kFar);
        rtTrace(top_object, shadow, payload);
        if (!payload)
            addSun(path, cosine);
    }
    scatter(path, point, normal);
}

RT_PROGRAM void block_light() {
    blocked = 1;
    rtTerminateRay();
}

RT_PROGRAM void mesh_attributes() {
    const V3 n = triangleNormal(&vertices[0].x, &indices[0].x, rtGetPrimitiveIndex());
    normal_attribute = make_float3(n.x, n.y, n.z);
}

RT_PROGRAM void intersect_sphere(int primitive) {
    const float4 s = spheres[primitive];
    const float sphere[4] = {s.x, s.y, s.z, s.w};
    const V3 origin = vec(ray.origin.x, ray.origin.y, ray.origin.z);
    const V3 direction = vec(ray.direction.x, ray.direction.y, ray.direction.z);
    const float t = meetSphere(origin, direction, sphere, ray.tmin, hit_distance);
    if (t > ray.tmin && rtPotentialIntersection(t)) {
        const V3 n = origin + direction * t - vec(sphere);
        normal_attribute = make_float3(n.x, n.y, n.z);
        rtReportIntersection(0);
    }
}

RT_PROGRAM void bound_sphere(int primitive, float box[6]) {
    const float4 s = spheres[primitive];
    box[0] = s.x - s.w, box[1] = s.y - s.w, box[2] = s.z - s.w;
    box[3] = s.x + s.w, box[4] = s.y + s.w, box[5] = s.z + s.w;
}
