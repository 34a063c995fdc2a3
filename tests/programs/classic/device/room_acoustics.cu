// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optixu/optixu_aabb_namespace.h>
#include <optixu/optixu_math_namespace.h>

using namespace optix;

struct Sound {
    float energy[8]; // by band
    float length;    // of the path
    float3 next_origin, next_direction;
    int wall;
    unsigned seed;
};
struct Wall {
    float4 plane; // normal along an axis, minus its distance
    rtBufferId<float> absorption;
    int padding[3];
};

rtDeclareVariable(uint3, cell, rtLaunchIndex, ); // direction, direction, source
rtDeclareVariable(uint3, cells, rtLaunchDim, );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(Sound, sound, rtPayload, );
rtDeclareVariable(float, chord, attribute chord, ""); // inside a receiver
rtDeclareVariable(int, which, attribute which, "");

rtDeclareVariable(rtObject, room, , );
rtDeclareVariable(rtObject, ears, , );
rtDeclareVariable(float, speed, , "metres per second") = 340.0f;
rtDeclareVariable(float, bin, , "seconds");
rtDeclareVariable(int, order, , "most reflections");
rtDeclareVariable(float3, size, , );
rtBuffer<float3> sources;
rtBuffer<float4> receivers; // balls
rtBuffer<Wall> walls;
rtBuffer<float, 3> arrivals; // by time, band, receiver and source
rtBuffer<int> lost;

static __device__ float random(unsigned& seed) {
    seed = seed * 747796405u + 2891336453u;
    unsigned word = ((seed >> ((seed >> 28) + 4)) ^ seed) * 277803737u;
    return (((word >> 22) ^ word) >> 8) * (1.0f / 16777216.0f);
}

// A ray through the ears for each straight piece of the path.
RT_PROGRAM void emit() {
    Sound s;
    s.seed = cell.x * 9781u + cell.y * 6271u + cell.z * 26699u + 17u;
    random(s.seed);
    const float z = 1 - 2 * (cell.x + random(s.seed)) / cells.x;
    const float angle = 2 * M_PIf * (cell.y + random(s.seed)) / cells.y;
    const float r = sqrtf(fmaxf(0.0f, 1 - z * z));
    float3 origin = sources[cell.z];
    float3 direction = make_float3(r * cosf(angle), r * sinf(angle), z);
    for (int band = 0; band < 8; ++band)
        s.energy[band] = 1.0f / (cells.x * cells.y);
    s.length = 0;
    for (int reflection = 0; reflection <= order; ++reflection) {
        s.wall = -1;
        rtTrace(room, make_Ray(origin, direction, 0, 1e-4f, RT_DEFAULT_MAX), s);
        if (s.wall < 0) {
            atomicAdd(&lost[0], 1);
            return;
        }
        const float far = length(s.next_origin - origin);
        rtTrace(ears, make_Ray(origin, direction, 1, 0, far), s);
        s.length += far;
        for (int band = 0; band < 8; ++band)
            s.energy[band] *= 1 - walls[s.wall].absorption[band];
        origin = s.next_origin;
        direction = s.next_direction;
    }
}

RT_PROGRAM void wall_hit() {
    sound.wall = which;
    sound.next_origin = ray.origin + t_hit * ray.direction;
    sound.next_direction = reflect(ray.direction, make_float3(walls[which].plane));
}
RT_PROGRAM void wall_intersect(int primitive) {
    const float4 plane = walls[primitive].plane;
    const float3 normal = make_float3(plane);
    const float t = -(dot(normal, ray.origin) + plane.w) / dot(normal, ray.direction);
    const float3 p = ray.origin + t * ray.direction;
    const float margin = 1e-3f;
    if (fminf(p) < -margin || fmaxf(p - size) > margin || !rtPotentialIntersection(t))
        return;
    which = primitive;
    rtReportIntersection(0);
}
RT_PROGRAM void wall_bounds(int primitive, float box[6]) {
    const float4 plane = walls[primitive].plane;
    for (int k = 0; k < 3; ++k) {
        const bool across = getByIndex(make_float3(plane), k) != 0;
        box[k] = (across ? -plane.w : 0) - 1e-3f;
        box[k + 3] = (across ? -plane.w : getByIndex(size, k)) + 1e-3f;
    }
}

RT_PROGRAM void ear_intersect(int primitive) {
    const float4 ball = receivers[primitive];
    const float3 o = ray.origin - make_float3(ball);
    const float middle = -dot(o, ray.direction);
    const float square = middle * middle - dot(o, o) + ball.w * ball.w;
    if (square <= 0 || !rtPotentialIntersection(middle))
        return;
    chord = 2 * sqrtf(square);
    which = primitive;
    rtReportIntersection(0);
}
RT_PROGRAM void ear_bounds(int primitive, Aabb* box) {
    const float4 ball = receivers[primitive];
    box->set(make_float3(ball) - ball.w, make_float3(ball) + ball.w);
}
// Receivers do not end the ray.
RT_PROGRAM void ear_heard() {
    const float radius = receivers[which].w;
    const float volume = 4.0f / 3 * M_PIf * radius * radius * radius;
    const unsigned time = unsigned((sound.length + t_hit) / speed / bin);
    const unsigned pair = which + cell.z * unsigned(receivers.size());
    if (time < arrivals.size().x)
        for (unsigned band = 0; band < 8; ++band)
            atomicAdd(&arrivals[make_uint3(time, band, pair)], sound.energy[band] * chord / volume);
    rtIgnoreIntersection();
}
