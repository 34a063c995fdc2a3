// SPDX-License-Identifier: Apache-2.0
// Spheres and parallelograms for all classic samples, each with an intersection and a bounding box
// program. The attributes are a normal of length one, in object space, and texture coordinates.
#include <optix_world.h>

using namespace optix;

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float3, normal, attribute normal, );
rtDeclareVariable(float3, texcoord, attribute texcoord, );

// ---- A sphere ----------------------------------------------------------------------------------

rtDeclareVariable(float4, sphere, , "centre and radius");

static __device__ __forceinline__ bool reportSphere(float t) {
    if (!rtPotentialIntersection(t))
        return false;
    normal = (ray.origin + t * ray.direction - make_float3(sphere)) / sphere.w;
    const float3 turned = cart_to_pol(make_float3(normal.x, normal.z, normal.y));
    texcoord = make_float3(turned.x * 0.5f / M_PIf + 0.5f, turned.y / M_PIf + 0.5f, 0.0f);
    return rtReportIntersection(0);
}

RT_PROGRAM void intersect_sphere(int) {
    const float3 offset = ray.origin - make_float3(sphere);
    const float a = dot(ray.direction, ray.direction);
    const float b = dot(offset, ray.direction);
    // The distance of the line from the centre; b * b - a * c loses digits (Haines et al. 2019).
    const float3 nearest = offset - (b / a) * ray.direction;
    const float discriminant = a * (sphere.w * sphere.w - dot(nearest, nearest));
    if (discriminant <= 0.0f)
        return;
    const float c = dot(offset, offset) - sphere.w * sphere.w;
    const float q = -b - copysignf(sqrtf(discriminant), b);
    const float first = q / a, second = c / q;
    if (!reportSphere(fminf(first, second)))
        reportSphere(fmaxf(first, second));
}

RT_PROGRAM void bound_sphere(int, float result[6]) {
    Aabb* box = (Aabb*)result;
    const float3 centre = make_float3(sphere);
    box->set(centre - sphere.w, centre + sphere.w);
}

// ---- A parallelogram ---------------------------------------------------------------------------

rtDeclareVariable(float3, anchor, , "a corner");
rtDeclareVariable(float3, edge1, , "from the corner to the next one");
rtDeclareVariable(float3, edge2, , "from the corner to the other neighbour");

RT_PROGRAM void intersect_parallelogram(int) {
    const float3 face = cross(edge1, edge2);
    const float slope = dot(ray.direction, face);
    const float t = dot(anchor - ray.origin, face) / slope;
    const float3 inside = ray.origin + t * ray.direction - anchor;
    const float area = dot(face, face);
    const float u = dot(cross(inside, edge2), face) / area;
    const float v = dot(cross(edge1, inside), face) / area;
    if (!(u >= 0.0f && u <= 1.0f && v >= 0.0f && v <= 1.0f) || !rtPotentialIntersection(t))
        return;
    normal = normalize(face);
    texcoord = make_float3(u, v, 0.0f);
    rtReportIntersection(0);
}

RT_PROGRAM void bound_parallelogram(int, float result[6]) {
    Aabb* box = (Aabb*)result;
    box->invalidate();
    box->include(anchor);
    box->include(anchor + edge1);
    box->include(anchor + edge2);
    box->include(anchor + edge1 + edge2);
}
