// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optix_math.h>

using namespace optix;

struct PerRayData_radiance {
    float3 result;
    int depth;
};
struct PerRayData_shadow {
    float3 attenuation;
};

rtDeclareVariable(float3, eye, , );
rtDeclareVariable(float3, light_pos, , );
rtDeclareVariable(float3, bad_color, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(int, max_depth, , );
rtDeclareVariable(unsigned int, radiance_ray_type, , );
rtDeclareVariable(unsigned int, shadow_ray_type, , );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(rtObject, top_shadower, , );
rtBuffer<uchar4, 2> output_buffer;

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(PerRayData_radiance, prd, rtPayload, );
rtDeclareVariable(PerRayData_shadow, prd_shadow, rtPayload, );
rtDeclareVariable(float3, geometric_normal, attribute geometric_normal, );
rtDeclareVariable(float3, shading_normal, attribute shading_normal, );

__device__ __inline__ uchar4 make_color(const float3& c) {
    return make_uchar4(static_cast<unsigned char>(__saturatef(c.z) * 255.99f),
                       static_cast<unsigned char>(__saturatef(c.y) * 255.99f),
                       static_cast<unsigned char>(__saturatef(c.x) * 255.99f), 255u);
}

RT_PROGRAM void pinhole_camera() {
    float2 d =
        (make_float2(launch_index) + make_float2(0.5f)) / make_float2(launch_dim) * 2.f - 1.f;
    float3 ray_direction = normalize(make_float3(d.x * 0.8f, d.y * 0.6f - 0.2f, -1.0f));
    optix::Ray primary(eye, ray_direction, radiance_ray_type, 0.0f);
    PerRayData_radiance start;
    start.depth = 0;
    rtTrace(top_object, primary, start);
    output_buffer[launch_index] = make_color(start.result);
}

RT_PROGRAM void exception() {
    const unsigned int code = rtGetExceptionCode();
    rtPrintf("Caught exception 0x%X at launch index (%d,%d)\n", code, launch_index.x,
             launch_index.y);
    output_buffer[launch_index] = make_color(bad_color);
}

RT_PROGRAM void gradientbg() {
    prd.result = make_float3(0.2f, 0.3f, 0.6f) * fmaxf(ray.direction.y, 0.0f) + make_float3(0.1f);
}

// ---- materials

rtDeclareVariable(float3, Kd, , );

RT_PROGRAM void any_hit_shadow() {
    prd_shadow.attenuation = make_float3(0);
    rtTerminateRay();
}

static __device__ float3 direct_light() {
    float3 n = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, shading_normal));
    n = faceforward(n, -ray.direction, n);
    const float3 hit_point = ray.origin + t_hit * ray.direction;
    float3 color = Kd * 0.2f;
    const float distance = length(light_pos - hit_point);
    const float3 L = normalize(light_pos - hit_point);
    const float n_dot_l = dot(n, L);
    if (n_dot_l > 0.0f) {
        PerRayData_shadow shadow_prd;
        shadow_prd.attenuation = make_float3(1.0f);
        optix::Ray shadow_ray(hit_point, L, shadow_ray_type, scene_epsilon, distance);
        rtTrace(top_shadower, shadow_ray, shadow_prd);
        if (fmaxf(shadow_prd.attenuation) > 0.0f)
            color += Kd * (0.8f * n_dot_l) * shadow_prd.attenuation;
    }
    return color;
}

RT_PROGRAM void closest_hit_diffuse() {
    prd.result = direct_light();
}

RT_PROGRAM void closest_hit_mirror() {
    float3 color = direct_light();
    if (prd.depth < max_depth) {
        const float3 n = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, geometric_normal));
        PerRayData_radiance refl;
        refl.depth = prd.depth + 1;
        refl.result = make_float3(0.0f);
        optix::Ray refl_ray(ray.origin + t_hit * ray.direction, reflect(ray.direction, n),
                            radiance_ray_type, scene_epsilon);
        rtTrace(top_object, refl_ray, refl);
        color = color * 0.7f + refl.result * 0.3f;
    }
    prd.result = color;
}

// ---- shapes

rtDeclareVariable(float4, plane, , );
rtDeclareVariable(float3, v1, , );
rtDeclareVariable(float3, v2, , );
rtDeclareVariable(float3, anchor, , );

RT_PROGRAM void parallelogram_intersect(int) {
    const float3 n = make_float3(plane);
    const float dt = dot(ray.direction, n);
    const float t = (plane.w - dot(n, ray.origin)) / dt;
    if (t > ray.tmin && t < ray.tmax) {
        const float3 p = ray.origin + ray.direction * t - anchor;
        const float a1 = dot(v1, p) / dot(v1, v1), a2 = dot(v2, p) / dot(v2, v2);
        if (a1 >= 0 && a1 <= 1 && a2 >= 0 && a2 <= 1 && rtPotentialIntersection(t)) {
            shading_normal = geometric_normal = n;
            rtReportIntersection(0);
        }
    }
}
RT_PROGRAM void parallelogram_bounds(int, float result[6]) {
    optix::Aabb* aabb = reinterpret_cast<optix::Aabb*>(result);
    aabb->m_min = fminf(fminf(anchor, anchor + v1), fminf(anchor + v2, anchor + v1 + v2));
    aabb->m_max = fmaxf(fmaxf(anchor, anchor + v1), fmaxf(anchor + v2, anchor + v1 + v2));
}

rtDeclareVariable(float4, sphere, , );

RT_PROGRAM void sphere_intersect(int) {
    const float3 center = make_float3(sphere);
    const float radius = sphere.w;
    const float3 O = ray.origin - center;
    const float b = dot(O, ray.direction), c = dot(O, O) - radius * radius;
    const float disc = b * b - c;
    if (disc <= 0.0f)
        return;
    const float sdisc = sqrtf(disc);
    bool check_second = true;
    const float root1 = -b - sdisc;
    if (rtPotentialIntersection(root1)) {
        shading_normal = geometric_normal = (O + root1 * ray.direction) / radius;
        if (rtReportIntersection(0))
            check_second = false;
    }
    if (check_second) {
        const float root2 = -b + sdisc;
        if (rtPotentialIntersection(root2)) {
            shading_normal = geometric_normal = (O + root2 * ray.direction) / radius;
            rtReportIntersection(0);
        }
    }
}
RT_PROGRAM void sphere_bounds(int, float result[6]) {
    const float3 cen = make_float3(sphere), rad = make_float3(sphere.w);
    optix::Aabb* aabb = (optix::Aabb*)result;
    if (rad.x > 0.0f && !isinf(rad.x)) {
        aabb->m_min = cen - rad;
        aabb->m_max = cen + rad;
    } else {
        aabb->invalidate();
    }
}

rtDeclareVariable(float3, boxmin, , );
rtDeclareVariable(float3, boxmax, , );

static __device__ float3 boxnormal(float t) {
    const float3 t0 = (boxmin - ray.origin) / ray.direction;
    const float3 t1 = (boxmax - ray.origin) / ray.direction;
    const float3 neg = make_float3(t == t0.x ? 1 : 0, t == t0.y ? 1 : 0, t == t0.z ? 1 : 0);
    const float3 pos = make_float3(t == t1.x ? 1 : 0, t == t1.y ? 1 : 0, t == t1.z ? 1 : 0);
    return pos - neg;
}
RT_PROGRAM void box_intersect(int) {
    const float3 t0 = (boxmin - ray.origin) / ray.direction;
    const float3 t1 = (boxmax - ray.origin) / ray.direction;
    const float tmin = fmaxf(fminf(t0, t1)), tmax = fminf(fmaxf(t0, t1));
    if (tmin > tmax)
        return;
    bool check_second = true;
    if (rtPotentialIntersection(tmin)) {
        shading_normal = geometric_normal = boxnormal(tmin);
        if (rtReportIntersection(0))
            check_second = false;
    }
    if (check_second && rtPotentialIntersection(tmax)) {
        shading_normal = geometric_normal = boxnormal(tmax);
        rtReportIntersection(0);
    }
}
RT_PROGRAM void box_bounds(int, float result[6]) {
    optix::Aabb* aabb = (optix::Aabb*)result;
    aabb->set(boxmin, boxmax);
}
