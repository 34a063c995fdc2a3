// SPDX-License-Identifier: Apache-2.0
// Path tracers that differ in the payload between ray generation and closest-hit programs. PAYLOAD
// 8: only the hit, shading in the ray generation program; 16: the path; 32: the path and further
// outputs; 2: the address of a struct. TYPED: payload types for paths and for shadow rays.
#include "common.h"

struct Path {
    float3 origin, direction, throughput, radiance;
    unsigned random, depth, done;
    float reach; // of the ray
#if PAYLOAD == 32
    float3 albedo, normal, position, absorption;
    unsigned surface, primitive, bounces;
    float distance;
#endif
};

#if TYPED
#define PATH_TYPE OPTIX_PAYLOAD_TYPE_ID_0,
#define SHADOW_TYPE OPTIX_PAYLOAD_TYPE_ID_1,
#define IS_PATH optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_0)
#define IS_SHADOW optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_1)
#else
#define PATH_TYPE
#define SHADOW_TYPE
#define IS_PATH
#define IS_SHADOW
#endif

DEVICE bool sees(float3 origin, float3 direction, float distance) {
    unsigned hidden = 1;
    optixTrace(SHADOW_TYPE params.scene, origin, direction, 0.0f, distance, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               1, 2, 1, hidden);
    return hidden == 0;
}

// One bounce: adds light to the path and sets its next direction.
DEVICE void shade(Path& path, const Look& m, float3 point, float3 normal, bool back) {
    if (m.surface == kLamp) {
        if (path.depth == 0 || path.reach > 0.0f)
            path.radiance += path.throughput * params.emission;
        path.done = 1;
        return;
    }
    const Bounce b = bounce(m, path.direction, normal, back, path.random);
    const float3 above = point + normal * params.epsilon;
    path.throughput = path.throughput * b.color;
    if (m.surface == kMatt) {
        const LampSample lamp = sampleLamp(point, normal, path.random);
        if (maxComponent(lamp.light) > 0.0f &&
            sees(above, lamp.direction, lamp.distance - 2 * params.epsilon))
            path.radiance += path.throughput * lamp.light;
    }
    path.reach = m.surface == kMatt ? 0.0f : 1.0f; // whether the lamp counts if the path meets it
    path.origin = b.passes ? point - normal * params.epsilon : above;
    path.direction = b.direction;
    ++path.depth;
    if (path.depth > 3) { // Russian roulette
        const float stay = minOf(maxComponent(path.throughput), 0.95f);
        if (nextFloat(path.random) >= stay)
            path.done = 1;
        else
            path.throughput = path.throughput / stay;
    }
}

#define WORD(i) unsigned(optixGetPayload_##i())
#define REAL(i) __uint_as_float(WORD(i))
#define REALS(i, j, k) vec(REAL(i), REAL(j), REAL(k))
#define SET(i, x) optixSetPayload_##i(x)
#define SET_REAL(i, x) SET(i, __float_as_uint(x))
#define SET_REALS(i, j, k, v) (SET_REAL(i, (v).x), SET_REAL(j, (v).y), SET_REAL(k, (v).z))

#if PAYLOAD == 2
DEVICE Path& pathOf() {
    return *reinterpret_cast<Path*>((unsigned long long)(WORD(1)) << 32 | WORD(0));
}
DEVICE Path loadPath() {
    return pathOf();
}
DEVICE void storePath(const Path& path) {
    pathOf() = path;
}
DEVICE void tracePath(Path& path) {
    const unsigned long long address = reinterpret_cast<unsigned long long>(&path);
    unsigned low = unsigned(address), high = unsigned(address >> 32);
    optixTrace(params.scene, path.origin, path.direction, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 2, 0, low, high);
}
#elif PAYLOAD >= 16
DEVICE Path loadPath() {
    Path p;
    p.origin = REALS(0, 1, 2);
    p.direction = REALS(3, 4, 5);
    p.throughput = REALS(6, 7, 8);
    p.radiance = REALS(9, 10, 11);
    p.random = WORD(12);
    p.depth = WORD(13);
    p.done = WORD(14);
    p.reach = REAL(15);
#if PAYLOAD == 32
    p.albedo = REALS(16, 17, 18);
    p.normal = REALS(19, 20, 21);
    p.position = REALS(22, 23, 24);
    p.absorption = REALS(25, 26, 27);
    p.surface = WORD(28);
    p.primitive = WORD(29);
    p.bounces = WORD(30);
    p.distance = REAL(31);
#endif
    return p;
}
DEVICE void storePath(const Path& p) {
    SET_REALS(0, 1, 2, p.origin);
    SET_REALS(3, 4, 5, p.direction);
    SET_REALS(6, 7, 8, p.throughput);
    SET_REALS(9, 10, 11, p.radiance);
    SET(12, p.random);
    SET(13, p.depth);
    SET(14, p.done);
    SET_REAL(15, p.reach);
#if PAYLOAD == 32
    SET_REALS(16, 17, 18, p.albedo);
    SET_REALS(19, 20, 21, p.normal);
    SET_REALS(22, 23, 24, p.position);
    SET_REALS(25, 26, 27, p.absorption);
    SET(28, p.surface);
    SET(29, p.primitive);
    SET(30, p.bounces);
    SET_REAL(31, p.distance);
#endif
}
// A struct as payload words: a union, as programs write it.
union Words {
    Path path;
    unsigned w[PAYLOAD];
    __device__ Words() {}
};
DEVICE void tracePath(Path& path) {
    Words words;
    words.path = path;
    unsigned* const w = words.w;
    optixTrace(PATH_TYPE params.scene, path.origin, path.direction, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 2, 0, w[0], w[1], w[2],
               w[3], w[4], w[5], w[6], w[7], w[8], w[9], w[10], w[11], w[12], w[13], w[14], w[15]
#if PAYLOAD == 32
               ,
               w[16], w[17], w[18], w[19], w[20], w[21], w[22], w[23], w[24], w[25], w[26], w[27],
               w[28], w[29], w[30], w[31]
#endif
    );
    path = words.path;
}
#endif

#if PAYLOAD == 8
// The hit in eight words; the ray generation program shades.
DEVICE void tracePath(Path& path) {
    unsigned px = 0, py = 0, pz = 0, nx = 0, ny = 0, nz = 0, low = 0, high = 0;
    optixTrace(params.scene, path.origin, path.direction, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 2, 0, px, py, pz, nx, ny,
               nz, low, high);
    const unsigned long long address = (unsigned long long)(high) << 32 | low;
    if (!address) {
        path.radiance += path.throughput * skyColor(path.direction);
        path.done = 1;
        return;
    }
    const bool back = high >> 31;
    const auto* m = reinterpret_cast<const Look*>(address & ~(1ull << 63));
    shade(path, *m, asFloats(px, py, pz), asFloats(nx, ny, nz), back);
}
extern "C" __global__ void __closesthit__surface() {
    bool back;
    const float3 normal = facing(triangleNormal(), back);
    const unsigned long long address = optixGetSbtDataPointer() | (unsigned long long)(back) << 63;
    SET_REALS(0, 1, 2, hitPoint());
    SET_REALS(3, 4, 5, normal);
    SET(6, unsigned(address));
    SET(7, unsigned(address >> 32));
}
extern "C" __global__ void __miss__sky() {
    SET(6, 0);
    SET(7, 0);
}
#else
extern "C" __global__ void __closesthit__surface() {
    IS_PATH;
    Path path = loadPath();
    bool back;
    const float3 normal = facing(triangleNormal(), back), point = hitPoint();
    const Look& m = material();
#if PAYLOAD == 32
    path.bounces += 1;
    path.distance += optixGetRayTmax();
    if (back && m.surface == kGlass)
        path.throughput = path.throughput * vec(expf(-path.absorption.x * optixGetRayTmax()),
                                                expf(-path.absorption.y * optixGetRayTmax()),
                                                expf(-path.absorption.z * optixGetRayTmax()));
    if (path.depth == 0) {
        path.albedo = m.color;
        path.normal = normal;
        path.position = point;
        path.surface = m.surface;
        path.primitive = optixGetPrimitiveIndex();
    }
    if (m.surface == kGlass)
        path.absorption = vec(0.3f, 0.1f, 0.2f);
#endif
    shade(path, m, point, normal, back);
    storePath(path);
}
extern "C" __global__ void __miss__sky() {
    IS_PATH;
    Path path = loadPath();
    path.radiance += path.throughput * skyColor(optixGetWorldRayDirection());
    path.done = 1;
    storePath(path);
}
#endif

extern "C" __global__ void __miss__lamp() {
    IS_SHADOW;
    SET(0, 0);
}

extern "C" __global__ void __raygen__paths() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i) {
        Path path = {};
        path.origin = params.camera.eye;
        path.direction = cameraRay(random);
        path.throughput = vec(1.0f);
        path.random = random;
        for (unsigned depth = 0; depth < params.depth && !path.done; ++depth)
            tracePath(path);
        sum += path.radiance;
        random = path.random + 1;
#if PAYLOAD == 32
        const unsigned pixel = pixelIndex();
        params.extra[pixel] = make_float4(
            path.albedo.x + path.normal.x, path.albedo.y + path.normal.y,
            path.albedo.z + path.position.z,
            path.distance + float(path.bounces + path.surface) + float(path.primitive & 1));
#endif
    }
    store(sum / float(params.samples));
}
