// SPDX-License-Identifier: Apache-2.0
// A path tracer with one closest-hit program and 83 direct callables: 40 materials that sample and
// evaluate, and three lights. Multiple importance sampling of lights and materials. Payload: the
// address of the path; for shadow rays one word.
#include "bsdf_40.h"

extern "C" {
__constant__ MaterialParams params;
}

struct Path {
    float3 origin, direction, throughput, radiance;
    float pdf; // of the direction; 0: of the camera
    unsigned random, depth;
    bool isDone;
};
DEVICE Path& pathOf() {
    return *reinterpret_cast<Path*>((unsigned long long)(optixGetPayload_0()) |
                                    (unsigned long long)(optixGetPayload_1()) << 32);
}
struct LightSample {
    float3 direction, radiance;
    float distance, pdf;
    bool isBeyondMaterials; // a material's direction never meets the light
};

// ---- The sky ------------------------------------------------------------------------------------

// The last index whose sum is not above x.
DEVICE unsigned findInSums(const float* sums, unsigned count, float x) {
    unsigned low = 0, high = count;
    while (high - low > 1) {
        const unsigned middle = (low + high) / 2;
        if (sums[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    return low;
}
DEVICE float3 skyRadiance(float u, float v) {
    const float4 c = tex2D<float4>(params.sky.texture, u, v);
    return vec(c.x, c.y, c.z);
}
DEVICE float skyPdf(float u, float v, float sine) {
    const SkyMap& s = params.sky;
    const unsigned x = min(unsigned(u * s.width), s.width - 1);
    const unsigned y = min(unsigned(v * s.height), s.height - 1);
    const float* const row = s.columns + y * (s.width + 1);
    const float weight = row[x + 1] - row[x];
    return weight / s.total * s.width * s.height / (2.0f * kPi * kPi * fmaxf(sine, 1e-4f));
}
DEVICE float2 skyCoordinates(float3 d) {
    const float u = atan2f(d.z, d.x) * (0.5f / kPi) + 0.5f;
    return make_float2(u, acosf(fminf(fmaxf(d.y, -1.0f), 1.0f)) / kPi);
}

// ---- Lights -------------------------------------------------------------------------------------

extern "C" __device__ LightSample __direct_callable__light_quad(const Light& l, float3 point,
                                                                float u, float v) {
    const float3 to = l.corner + l.u * u + l.v * v - point;
    const float3 area = cross(l.u, l.v);
    LightSample s = {};
    s.distance = length(to);
    s.direction = to / s.distance;
    const float facing = fabsf(dot(area, s.direction));
    s.pdf = s.distance * s.distance / fmaxf(facing, 1e-6f);
    s.radiance = l.emission;
    return s;
}
extern "C" __device__ LightSample __direct_callable__light_ball(const Light& l, float3 point,
                                                                float u, float v) {
    const float3 middle = l.corner - point;
    const float distance = length(middle), sine = fminf(l.u.x / distance, 0.99f);
    const float3 axis = middle / distance;
    const float edge = sqrtf(1.0f - sine * sine), cosine = 1.0f - u * (1.0f - edge);
    const float2 around = circlePoint(v);
    float3 x, y;
    makeBasis(axis, x, y);
    const float r = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f));
    LightSample s = {};
    s.direction = fromBasis(x, y, axis, vec(r * around.x, r * around.y, cosine));
    s.distance = distance - l.u.x;
    s.pdf = 1.0f / (2.0f * kPi * (1.0f - edge));
    s.radiance = l.emission;
    s.isBeyondMaterials = true;
    return s;
}
extern "C" __device__ LightSample __direct_callable__light_sky(const Light&, float3, float u,
                                                               float v) {
    const SkyMap& sky = params.sky;
    const float target = v * sky.total;
    const unsigned y = findInSums(sky.rows, sky.height, target);
    const float* const row = sky.columns + y * (sky.width + 1);
    const unsigned x = findInSums(row, sky.width, u * row[sky.width]);
    const float inX = (u * row[sky.width] - row[x]) / fmaxf(row[x + 1] - row[x], 1e-12f);
    const float inY = (target - sky.rows[y]) / fmaxf(sky.rows[y + 1] - sky.rows[y], 1e-12f);
    const float s = (x + fminf(inX, 0.999f)) / sky.width, t = (y + fminf(inY, 0.999f)) / sky.height;
    const float theta = t * kPi, phi = (s - 0.5f) * 2.0f * kPi, sine = sinf(theta);
    LightSample sample = {};
    sample.direction = vec(sine * cosf(phi), cosf(theta), sine * sinf(phi));
    sample.distance = 1e16f;
    sample.radiance = skyRadiance(s, t);
    sample.pdf = skyPdf(s, t, sine);
    return sample;
}

// ---- Materials ----------------------------------------------------------------------------------

#define MATERIAL(n)                                                                                \
    extern "C" __device__ MaterialSample __direct_callable__sample_##n(                            \
        const Interaction& at, float u, float v, float w) {                                        \
        return sampleMaterial<n>(at, u, v, w);                                                     \
    }                                                                                              \
    extern "C" __device__ float4 __direct_callable__evaluate_##n(const Interaction& at,            \
                                                                 float3 direction) {               \
        return evaluateMaterial<n>(at, direction);                                                 \
    }
#define FIVE(a, b, c, d, e) MATERIAL(a) MATERIAL(b) MATERIAL(c) MATERIAL(d) MATERIAL(e)
FIVE(0, 1, 2, 3, 4)
FIVE(5, 6, 7, 8, 9)
FIVE(10, 11, 12, 13, 14)
FIVE(15, 16, 17, 18, 19)
FIVE(20, 21, 22, 23, 24)
FIVE(25, 26, 27, 28, 29)
FIVE(30, 31, 32, 33, 34)
FIVE(35, 36, 37, 38, 39)

// ---- Paths --------------------------------------------------------------------------------------

DEVICE float heuristic(float a, float b) {
    return a * a / fmaxf(a * a + b * b, 1e-20f);
}
DEVICE bool isFree(float3 origin, float3 direction, float distance) {
    unsigned hidden = 1, unused = 0;
    optixTrace(params.scene, origin, direction, 1e-3f, distance - 2e-3f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hidden, unused);
    return hidden == 0;
}

DEVICE void addDirectLight(Path& path, const Interaction& at, unsigned material) {
    const unsigned chosen =
        min(unsigned(nextFloat(path.random) * params.numLights), params.numLights - 1);
    const float u = nextFloat(path.random), v = nextFloat(path.random);
    const Light& light = params.lights[chosen];
    const LightSample s = optixDirectCall<LightSample, const Light&, float3, float, float>(
        kLightCallables + light.kind, light, at.point, u, v);
    const float pdf = s.pdf / params.numLights;
    if (!(pdf > 0.0f) || dot(s.direction, at.normal) <= 0.0f)
        return;
    const float4 f = optixDirectCall<float4, const Interaction&, float3>(kEvaluators + material, at,
                                                                         s.direction);
    if (fmaxf(f.x, fmaxf(f.y, f.z)) <= 0.0f || !isFree(at.point, s.direction, s.distance))
        return;
    const float weight = s.isBeyondMaterials ? 1.0f : heuristic(pdf, f.w);
    path.radiance += path.throughput * vec(f.x, f.y, f.z) * s.radiance * (weight / pdf);
}

// Light of a lamp that the path met by chance.
DEVICE void addLamp(Path& path, float3 normal, float distance) {
    float weight = 1.0f;
    const Light& lamp = params.lights[0]; // all lamps have one size
    if (path.pdf > 0.0f) {
        const float facing = fabsf(dot(normal, path.direction)) * length(cross(lamp.u, lamp.v));
        const float pdf = distance * distance / fmaxf(facing, 1e-6f) / params.numLights;
        weight = heuristic(path.pdf, pdf);
    }
    path.radiance += path.throughput * lamp.emission * weight;
    path.isDone = true;
}

extern "C" __global__ void __closesthit__surface() {
    Path& path = pathOf();
    const MeshRecord& mesh = *reinterpret_cast<const MeshRecord*>(optixGetSbtDataPointer());
    const unsigned primitive = optixGetPrimitiveIndex();
    const uint3 t = mesh.triangles[primitive];
    const float3 a = mesh.vertices[t.x];
    Interaction at;
    at.normal = towardsRay(normalize(cross(mesh.vertices[t.y] - a, mesh.vertices[t.z] - a)));
    const unsigned material = mesh.materials[primitive];
    if (material == kLightMaterial)
        return addLamp(path, at.normal, optixGetRayTmax());
    at.point = rayPoint();
    at.outgoing = -path.direction;
    at.uv =
        make_float2(at.point.x * 0.9f + at.point.z * 0.4f, at.point.y * 0.9f + at.point.z * 0.7f);
    at.material = mesh.table + material;
    makeBasis(at.normal, at.x, at.y);
    addDirectLight(path, at, material);
    const float u = nextFloat(path.random), v = nextFloat(path.random), w = nextFloat(path.random);
    const MaterialSample s =
        optixDirectCall<MaterialSample, const Interaction&, float, float, float>(material, at, u, v,
                                                                                 w);
    path.throughput = path.throughput * s.weight;
    path.direction = s.direction;
    path.origin = at.point;
    path.pdf = s.pdf;
    path.isDone = !(s.pdf > 0.0f);
    ++path.depth;
}

extern "C" __global__ void __miss__sky() {
    Path& path = pathOf();
    const float2 c = skyCoordinates(path.direction);
    float weight = 1.0f;
    if (path.pdf > 0.0f) {
        const float sine = sqrtf(fmaxf(1.0f - path.direction.y * path.direction.y, 0.0f));
        weight = heuristic(path.pdf, skyPdf(c.x, c.y, sine) / params.numLights);
    }
    path.radiance += path.throughput * skyRadiance(c.x, c.y) * weight;
    path.isDone = true;
}
extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(0);
}

extern "C" __global__ void __raygen__paths() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        Path path;
        path.random = hashPcg(pixel * 8 + i);
        const float x = (index.x + nextFloat(path.random)) / size.x;
        const float y = (index.y + nextFloat(path.random)) / size.y;
        path.origin = params.camera.eye;
        path.direction = cameraDirection(params.camera, x, y);
        path.throughput = vec(1.0f);
        path.radiance = vec(0.0f);
        path.pdf = 0.0f;
        path.depth = 0;
        path.isDone = false;
        const unsigned long long address = reinterpret_cast<unsigned long long>(&path);
        while (!path.isDone && path.depth < params.maxDepth) {
            unsigned low = unsigned(address), high = unsigned(address >> 32);
            optixTrace(params.scene, path.origin, path.direction, 1e-3f, 1e16f, 0.0f,
                       OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, low, high);
        }
        sum += path.radiance;
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
