// SPDX-License-Identifier: Apache-2.0
// Programs of the tests of the classic API.
#include <optix_world.h>

using namespace optix;

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(unsigned, line_index, rtLaunchIndex, );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtBuffer<float, 1> result;

// ---- values
// ---------------------------------------------------------------------------------------

struct User {
    float a;
    int b[3];
};
rtDeclareVariable(float3, some_float3, , "three, \"quoted\" (a, b)");
rtDeclareVariable(long long, some_long, , );
rtDeclareVariable(Matrix3x4, some_matrix, , );
rtDeclareVariable(User, some_user, , );
rtDeclareVariable(int, with_default, , ) = 42;
namespace inner {
rtDeclareVariable(float, nested, , );
}

RT_PROGRAM void write_values() {
    result[0] = some_float3.x + 10 * some_float3.y + 100 * some_float3.z;
    result[1] = float(some_long >> 32);
    const float4 row = some_matrix.getRow(1);
    result[2] = row.x + row.w * 10;
    result[3] = some_user.a + some_user.b[2];
    result[4] = float(with_default);
    result[5] = inner::nested;
    result[6] = float(result.size());
}

rtDeclareVariable(float, scoped, , );
RT_PROGRAM void write_scoped() {
    result[line_index] = scoped;
}
RT_PROGRAM void write_other() {
    result[line_index] = 2 * scoped;
}

// A device function that calls itself and reads a variable.
__device__ __noinline__ float grow(int n) {
    return n < 2 ? scoped : grow(n - 1) + grow(n - 2);
}
RT_PROGRAM void write_grown() {
    result[0] = grow(10);
}
RT_PROGRAM void write_grown_again() {
    result[0] = grow(10);
}

// ---- buffers
// --------------------------------------------------------------------------------------

rtBuffer<rtBufferId<float, 1>, 1> ids;
rtBuffer<int3, 3> volume;
rtDeclareVariable(rtBufferId<float>, one_id, , );
rtDeclareVariable(int, element, , );

RT_PROGRAM void read_ids() {
    result[0] = ids[1][2];
    result[1] = one_id[1];
    result[2] = float(ids[1].size());
    const size_t3 size = volume.size();
    result[3] = float(size.x + 10 * size.y + 100 * size.z);
    result[4] = float(volume[make_uint3(1, 2, 3)].y);
    result[5] = rtBufferId<float>(0)[0];
}
RT_PROGRAM void read_outside() {
    result[0] = 1 + one_id[element];
    one_id[element] = 5;
    result[1] = 1 + one_id[element];
}
RT_PROGRAM void read_size() {
    result[0] = 1 + float(one_id.size());
}

rtBuffer<float4, 2> image;
RT_PROGRAM void paint_image() {
    image[launch_index] = make_float4((launch_index.x + 1.0f) / launch_dim.x,
                                      (launch_index.y + 1.0f) / launch_dim.y, scoped, 0.25f);
}
RT_PROGRAM void halve_image() {
    image[launch_index] = image[launch_index] * 0.5f;
}

rtDeclareVariable(uint3, place_index, rtLaunchIndex, );
rtDeclareVariable(uint3, place_dim, rtLaunchDim, );
rtBuffer<uint3, 3> places;
RT_PROGRAM void write_place() {
    places[place_index] = place_index + 10u * place_dim;
}

template <int N>
RT_PROGRAM void write_number() {
    result[0] = N;
}
template RT_PROGRAM void write_number<7>();
template RT_PROGRAM void write_number<8>();

// ---- exceptions, printing
// ---------------------------------------------------------------------------

RT_PROGRAM void throw_user() {
    result[0] = 1;
    rtThrow(RT_EXCEPTION_USER + 7);
    result[0] = 2;
}
RT_PROGRAM void trap() {
    asm volatile("trap;");
}
RT_PROGRAM void note_exception() {
    result[1] = float(rtGetExceptionCode());
}
RT_PROGRAM void print_exception() {
    rtPrintExceptionDetails();
}
rtDeclareVariable(unsigned, thrown, , );
RT_PROGRAM void throw_code() {
    result[0] = 1;
    rtThrow(thrown);
    result[0] = 2;
}
RT_PROGRAM void print_narrow() {
    rtPrintf("%hd %hhd %hu %hhu %hx %d\n", element, element, element, element, element, element);
}
RT_PROGRAM void print_index() {
    rtPrintf("index %d\n", line_index);
}

// ---- rays
// -----------------------------------------------------------------------------------------

struct Payload {
    float value;
    int calls;
    float3 normal;
    float large[40];
};
rtDeclareVariable(Payload, payload, rtRayPayload, );
rtDeclareVariable(float3, ray_origin, , ) = {0.25f, 0.25f, 10.0f};
rtDeclareVariable(float, step, , );
rtDeclareVariable(unsigned, ray_type, , );
rtDeclareVariable(unsigned, mask, , ) = 255;
rtDeclareVariable(unsigned, flags, , );
rtDeclareVariable(float, mark, , );

RT_PROGRAM void shoot() {
    Payload p;
    p.value = -1;
    p.calls = 0;
    p.normal = make_float3(0);
    p.large[39] = 3;
    const Ray down = make_Ray(ray_origin + make_float3(step * line_index, 0, 0),
                              make_float3(0, 0, -1), ray_type, 0.0f, 100.0f);
    rtTrace(top_object, down, p, mask, RTrayflags(flags));
    result[4 * line_index] = p.value;
    result[4 * line_index + 1] = float(p.calls);
    result[4 * line_index + 2] = p.normal.x;
    result[4 * line_index + 3] = p.large[39];
}
rtBuffer<float, 1> measured;
RT_PROGRAM void measure() {
    result[0] = float(measured.size());
    result[1] = measured[2];
}
// A device function that calls itself and traces rays.
static __device__ __noinline__ float look(int n) {
    Payload p;
    p.value = -1;
    rtTrace(top_object, make_Ray(ray_origin, make_float3(0, 0, -1), ray_type, 0.0f, 100.0f), p);
    return n < 2 ? p.value : p.value + look(n - 1) + look(n - 2);
}
RT_PROGRAM void look_often() {
    result[0] = look(5);
}
// Two functions that call each other, from a closest-hit program that their rays run again.
static __device__ float look_again(int n, int depth);
static __device__ __noinline__ float look_deeper(int n, int depth) {
    Payload p;
    p.value = -1;
    p.calls = depth;
    rtTrace(top_object, make_Ray(ray_origin, make_float3(0, 0, -1), ray_type, 0.0f, 100.0f), p);
    return p.value + look_again(n - 1, depth);
}
static __device__ __noinline__ float look_again(int n, int depth) {
    return n < 1 ? 0 : scoped * look_deeper(n, depth);
}
RT_PROGRAM void hit_looking() {
    payload.value = payload.calls < 3 ? 1 + look_deeper(2, payload.calls + 1) : 1;
}
rtDeclareVariable(float, ray_time, , );
RT_PROGRAM void shoot_at() {
    Payload p;
    p.value = -1;
    const Ray down = make_Ray(ray_origin + make_float3(step * line_index, 0, 0),
                              make_float3(0, 0, -1), ray_type, 0.0f, 100.0f);
    rtTrace(top_object, down, ray_time, p);
    result[4 * line_index] = p.value;
    result[4 * line_index + 2] = p.normal.x;
}
// A selector's program: the chosen child, or the first two.
rtDeclareVariable(int, chosen, , );
RT_PROGRAM void visit_chosen() {
    if (chosen >= 0) {
        rtIntersectChild(chosen);
        return;
    }
    rtIntersectChild(0);
    rtIntersectChild(1);
}
RT_PROGRAM void visit_until_hit() {
    const float before = hit_distance;
    rtIntersectChild(0);
    if (hit_distance < before)
        return;
    rtIntersectChild(1);
}
RT_PROGRAM void missed() {
    payload.value = -2;
    payload.large[39] = ray.tmax;
}

rtDeclareVariable(float3, normal, attribute normal, );
rtDeclareVariable(float2, barycentrics, attribute barycentrics, );
rtDeclareVariable(unsigned, instanceid, attribute instanceid, );
rtDeclareVariable(float, tag, attribute tag, );

RT_PROGRAM void hit_mark() {
    payload.value = mark;
    payload.normal = normal;
    payload.large[39] = hit_distance;
}
RT_PROGRAM void hit_distance_only() {
    payload.large[39] = hit_distance;
}
// Traces the same ray again, which is one level deeper.
RT_PROGRAM void hit_again() {
    payload.calls++;
    if (payload.calls < 50)
        rtTrace(top_object, ray, payload);
}
RT_PROGRAM void hit_head() {
    payload.value = mark;
}
RT_PROGRAM void shoot_small() {
    float p = -1;
    rtTrace(top_object, make_Ray(ray_origin, make_float3(0, 0, -1), ray_type, 0.0f, 100.0f), p);
    result[0] = p;
}
RT_PROGRAM void hit_world() {
    payload.value = rtTransformPoint(RT_OBJECT_TO_WORLD, make_float3(0, 0, 0)).x;
    float m[16];
    rtGetTransform(RT_WORLD_TO_OBJECT, m);
    payload.normal.x = m[3];
    payload.large[39] = ray.origin.x;
}
RT_PROGRAM void hit_triangle() {
    payload.value = float(rtGetPrimitiveIndex()) + 10 * instanceid;
    payload.calls =
        rtIsTriangleHit() + 2 * rtIsTriangleHitFrontFace() + 4 * rtIsTriangleHitBackFace();
    payload.normal.x = barycentrics.x;
    payload.large[39] = barycentrics.y;
}
RT_PROGRAM void hit_tag() {
    payload.value = tag;
}
RT_PROGRAM void attribute_tag() {
    tag = 100 + rtGetTriangleBarycentrics().x;
}
RT_PROGRAM void count_any() {
    payload.calls++;
    payload.large[39] = ray.origin.x; // in object space
}
RT_PROGRAM void ignore_any() {
    payload.calls++;
    rtIgnoreIntersection();
}
RT_PROGRAM void terminate_any() {
    payload.calls++;
    rtTerminateRay();
    payload.calls = 100;
}

// Squares of side 1 in planes of constant z: primitive i is at z = height - i, reported with
// material i % materials.
rtDeclareVariable(float, height, , );
rtDeclareVariable(int, materials, , ) = 1;

// The box of what has no end.
rtDeclareVariable(float, extent, , );
RT_PROGRAM void endless_bounds(int, float box[6]) {
    box[0] = box[1] = box[2] = -extent;
    box[3] = box[4] = box[5] = extent;
}
RT_PROGRAM void square_bounds(int primitive, float box[6]) {
    const float z = height - primitive;
    box[0] = 0, box[1] = 0, box[2] = z - 0.01f;
    box[3] = 1, box[4] = 1, box[5] = z + 0.01f;
}
RT_PROGRAM void square_hit(int primitive) {
    const float z = height - primitive, t = (z - ray.origin.z) / ray.direction.z;
    const float3 p = ray.origin + t * ray.direction;
    if (p.x < 0 || p.x > 1 || p.y < 0 || p.y > 1)
        return;
    if (rtPotentialIntersection(t)) {
        normal = make_float3(primitive + 0.5f, 0, 1);
        rtReportIntersection(primitive % materials);
    }
}
// A square that moves from x = 0 to x = travel.
rtDeclareVariable(float, now, rtCurrentTime, );
rtDeclareVariable(float, motion_begin, , );
rtDeclareVariable(float, motion_end, , );
rtDeclareVariable(float, last_step, , );
rtDeclareVariable(float, travel, , );
rtDeclareVariable(float, lane, , );

RT_PROGRAM void moving_bounds(int, int motion_step, float box[6]) {
    const float x = last_step > 0 ? travel * motion_step / last_step : 0;
    box[0] = x, box[1] = lane, box[2] = 4.99f;
    box[3] = x + 1, box[4] = lane + 1, box[5] = 5.01f;
}
RT_PROGRAM void moving_hit(int) {
    const float part = (now - motion_begin) / (motion_end - motion_begin);
    const float x = travel * fminf(fmaxf(part, 0.0f), 1.0f);
    const float t = (5 - ray.origin.z) / ray.direction.z;
    const float3 p = ray.origin + t * ray.direction;
    if (p.x >= x && p.x <= x + 1 && p.y >= lane && p.y <= lane + 1 && rtPotentialIntersection(t)) {
        normal = make_float3(x, 0, 1);
        rtReportIntersection(0);
    }
}
// Reports the nearer of two hits first, whose attributes must survive.
RT_PROGRAM void two_hits(int) {
    if (rtPotentialIntersection(5)) {
        normal = make_float3(5, 0, 0);
        rtReportIntersection(0);
    }
    if (rtPotentialIntersection(7)) {
        normal = make_float3(7, 0, 0);
        rtReportIntersection(0);
    }
}

// Each hit is nearer than the one before it.
rtDeclareVariable(int, hits, , );
RT_PROGRAM void many_hits(int) {
    for (int i = 1; i <= hits; ++i)
        if (rtPotentialIntersection(9.0f - i)) {
            normal = make_float3(i, 0, 0);
            rtReportIntersection(0);
        }
}

// ---- callables
// --------------------------------------------------------------------------------------

rtDeclareVariable(rtCallableProgramId<float(float, int)>, by_id, , );
rtDeclareVariable(rtCallableProgramX<float(float)>, bound, , );
rtBuffer<rtCallableProgramId<float(float, int)>, 1> list;

RT_PROGRAM void call_programs() {
    result[0] = by_id(1.5f, 2);
    result[1] = bound(4.0f);
    result[2] = list[1](1.0f, 1);
    result[3] = rtMarkedCallableProgramId<float(float, int)>(by_id, "site")(2.0f, 3);
    result[4] = rtCallableProgramId<float(float, int)>(999)(2.0f, 3);
}
RT_CALLABLE_PROGRAM float multiply(float a, int b) {
    return a * b;
}
RT_CALLABLE_PROGRAM float add_scoped(float a, int b) {
    return a + b + scoped;
}
RT_CALLABLE_PROGRAM float scale(float a) {
    return a * scoped;
}
// A chain of callables.
rtDeclareVariable(rtCallableProgramId<float(float)>, next, , );
RT_CALLABLE_PROGRAM float count_down(float n) {
    return n < 2 ? 1 : 1 + next(n - 1);
}
RT_CALLABLE_PROGRAM float grow_after_call(float n) {
    return 1000 * next(1) + grow(int(n));
}
rtDeclareVariable(rtCallableProgramId<float(float)>, grower, , );
RT_PROGRAM void call_grower() {
    result[0] = grower(5);
}
rtDeclareVariable(float, chain, , );
RT_PROGRAM void call_chain() {
    result[0] = next(chain);
    result[2] = next(1);
}
rtDeclareVariable(rtCallableProgramX<float3(float3, float2)>, bound_vectors, , );
RT_PROGRAM void call_vectors() {
    const float3 sum = bound_vectors(make_float3(1, 2, 3), make_float2(10, 20));
    result[0] = sum.x;
    result[1] = sum.y;
    result[2] = sum.z;
}
RT_CALLABLE_PROGRAM float3 add_vectors(float3 a, float2 b) {
    return make_float3(a.x + b.x, a.y + b.y, a.z * scoped);
}

// Programs that call themselves and each other through variables.
rtDeclareVariable(rtCallableProgramX<float(float)>, even, , );
rtDeclareVariable(rtCallableProgramX<float(float)>, odd, , );
RT_CALLABLE_PROGRAM float sum_even(float n) {
    return n < 1 ? scoped : n + odd(n - 1);
}
RT_CALLABLE_PROGRAM float sum_odd(float n) {
    return n < 1 ? scoped : even(n - 1);
}
RT_PROGRAM void call_even() {
    result[0] = even(10);
}
// Eight programs of this function may all call each other.
#define CALLED(number) rtDeclareVariable(rtCallableProgramX<float(float)>, called_##number, , );
CALLED(0) CALLED(1) CALLED(2) CALLED(3) CALLED(4) CALLED(5) CALLED(6) CALLED(7)
RT_CALLABLE_PROGRAM float call_all(float n) {
    if (n < 1)
        return scoped;
    return called_0(n - 1) + called_1(n - 1) + called_2(n - 1) + called_3(n - 1) + called_4(n - 1) +
           called_5(n - 1) + called_6(n - 1) + called_7(n - 1);
}
RT_PROGRAM void call_eight() {
    result[0] = called_0(1);
}

// ---- textures
// ---------------------------------------------------------------------------------------

rtDeclareVariable(int, texture_id, , );
RT_PROGRAM void sample() {
    const float4 texel = rtTex2D<float4>(texture_id, 0.75f, 0.25f);
    result[0] = texel.x;
    result[1] = texel.y;
    result[2] = rtTex2DFetch<uchar4>(texture_id, 0, 1).z;
    const uint3 size = rtTexSize(texture_id);
    result[3] = float(size.x + 10 * size.y);
}

rtTextureSampler<uchar4, 2, cudaReadModeNormalizedFloat> bytes_reference;
rtTextureSampler<float, 2> depth_reference;
RT_PROGRAM void sample_references() {
    const float4 color = tex2D(bytes_reference, 0.75f, 0.25f);
    result[0] = color.x;
    result[1] = color.y;
    result[2] = tex2D(depth_reference, 0.25f, 0.75f);
    result[3] = tex2DLod(depth_reference, 0.75f, 0.75f, 0.0f);
}

rtDeclareVariable(int, gl_target, , "an RTgltarget");
rtDeclareVariable(float3, place, , );
rtDeclareVariable(int, layer, , );
RT_PROGRAM void sample_target() {
    switch (gl_target) {
    case RT_TARGET_GL_TEXTURE_1D:
        result[0] = rtTex1D<float>(texture_id, place.x);
        break;
    case RT_TARGET_GL_TEXTURE_3D:
        result[0] = rtTex3D<float>(texture_id, place.x, place.y, place.z);
        break;
    case RT_TARGET_GL_TEXTURE_1D_ARRAY:
        result[0] = rtTex1DLayered<float>(texture_id, place.x, layer);
        break;
    case RT_TARGET_GL_TEXTURE_2D_ARRAY:
        result[0] = rtTex2DLayered<float>(texture_id, place.x, place.y, layer);
        break;
    case RT_TARGET_GL_TEXTURE_CUBE_MAP:
        result[0] = rtTexCubemap<float>(texture_id, place.x, place.y, place.z);
        break;
    case RT_TARGET_GL_TEXTURE_CUBE_MAP_ARRAY:
        result[0] = rtTexCubemapLayered<float>(texture_id, place.x, place.y, place.z, layer);
        break;
    default:
        result[0] = rtTex2D<float>(texture_id, place.x, place.y);
    }
}
RT_PROGRAM void sample_levels() {
    for (int level = 0; level < 3; ++level)
        result[level] = rtTex2DLod<float>(texture_id, 0.5f, 0.5f, float(level));
}

RT_PROGRAM void sample_colors() {
    for (int level = 0; level < 2; ++level) {
        const float4 color = rtTex2DLod<float4>(texture_id, place.x, place.y, float(level));
        result[4 * level] = color.x;
        result[4 * level + 1] = color.y;
        result[4 * level + 2] = color.z;
    }
}

rtDeclareVariable(int, texel_kind, , "0: float, 1: int, 2: unsigned");
RT_PROGRAM void sample_texel() {
    float4 texel = rtTex2D<float4>(texture_id, 0.75f, 0.25f);
    if (texel_kind == 1) {
        const int4 whole = rtTex2D<int4>(texture_id, 0.75f, 0.25f);
        texel = make_float4(whole.x, whole.y, whole.z, whole.w);
    } else if (texel_kind == 2) {
        const uint4 whole = rtTex2D<uint4>(texture_id, 0.75f, 0.25f);
        texel = make_float4(whole.x, whole.y, whole.z, whole.w);
    }
    result[0] = texel.x;
    result[1] = texel.y;
    result[2] = texel.z;
    result[3] = texel.w;
}

// ---- progressive launches
// ---------------------------------------------------------------------------------------

rtDeclareVariable(unsigned, subframe, rtSubframeIndex, );
rtBuffer<float4, 2> picture;
rtBuffer<float3, 2> small_picture;

static __device__ __forceinline__ float3 subframeColor() {
    return make_float3(subframe % 2 ? 0.0f : 1.0f, 0.25f * subframe,
                       scoped + launch_index.x + 0.5f * launch_index.y);
}
RT_PROGRAM void write_subframe() {
    picture[launch_index] = make_float4(subframeColor(), 7.0f);
}
RT_PROGRAM void show_image() {
    picture[launch_index] = image[launch_index];
}
RT_PROGRAM void write_small_subframe() {
    small_picture[launch_index] = subframeColor();
}
RT_PROGRAM void write_subframe_index() {
    result[line_index] = float(subframe);
}
