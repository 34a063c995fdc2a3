// SPDX-License-Identifier: Apache-2.0
// Particles follow a flow in short steps. A ray as long as the step finds walls, where particles
// bounce or stick. Payload: triangle, distance (negative: free).
#include "particles.h"
#include "tools.h"

extern "C" {
__constant__ ParticleParams params;
}

constexpr float kStick = 0.15f;

extern "C" __global__ void __closesthit__wall() {
    optixSetPayload_0(optixGetPrimitiveIndex());
    optixSetPayload_1(__float_as_uint(optixGetRayTmax()));
}
extern "C" __global__ void __miss__free() {
    optixSetPayload_1(__float_as_uint(-1.0f));
}
DEVICE float findWall(float3 from, float3 direction, float tmin, float length, unsigned& triangle) {
    unsigned distance = 0;
    optixTrace(params.walls, from, direction, tmin, length, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, triangle, distance);
    return __uint_as_float(distance);
}

extern "C" __global__ void __raygen__emit() {
    const unsigned i = optixGetLaunchIndex().x;
    Particle p = {};
    p.random = hashPcg(i);
    p.position.x = -1.15f + 0.9f * nextFloat(p.random);
    p.position.y = 1.1f * nextFloat(p.random) - 0.55f;
    p.position.z = 1.1f * nextFloat(p.random) - 0.55f;
    p.velocity = vec(1.0f, 0.0f, 0.0f);
    params.particles[i] = p;
}

// Counts the particle in the pixel that shows it, unless a wall hides it.
DEVICE void splat(float3 position) {
    const Camera& c = params.camera;
    const float3 line = position - c.eye;
    const float depth = dot(line, c.forward);
    const float x = dot(line, c.right) / dot(c.right, c.right) / depth;
    const float y = dot(line, c.up) / dot(c.up, c.up) / depth;
    if (depth <= 0.0f || fabsf(x) >= 1.0f || fabsf(y) >= 1.0f)
        return;
    const unsigned column = static_cast<unsigned>((0.5f + 0.5f * x) * params.width);
    const unsigned row = static_cast<unsigned>((0.5f - 0.5f * y) * params.height);
    atomicAdd(&params.density[row * params.width + column], 1u);
}

DEVICE void bounce(Particle& p, float3 direction, float distance, unsigned triangle) {
    p.position += direction * distance;
    float3 normal = normalize(params.mesh.normal(triangle));
    if (dot(normal, direction) > 0.0f)
        normal = -normal;
    if (nextFloat(p.random) < kStick) {
        atomicAdd(&params.deposits[triangle], 1u);
        p.state = 1;
        return;
    }
    const float u = nextFloat(p.random), v = nextFloat(p.random);
    const float3 away = lerp(reflect(direction, normal), cosineDirection(normal, u, v), 0.3f);
    p.velocity = away * (0.6f * length(p.velocity));
    p.position += normal * 1e-4f;
}

extern "C" __global__ void __raygen__advance() {
    const unsigned i = optixGetLaunchIndex().x;
    Particle p = params.particles[i];
    for (unsigned step = 0; step < params.steps && p.state == 0; ++step) {
        const float3 at = p.position * 0.5f + vec(0.5f);
        const float4 flow = tex3D<float4>(params.field, at.x, at.y, at.z);
        p.velocity += (vec(flow.x, flow.y, flow.z) - p.velocity) * 0.25f;
        const float speed = length(p.velocity), distance = speed * params.timeStep;
        const float3 direction = p.velocity / fmaxf(speed, 1e-6f);
        unsigned triangle = 0;
        const float t = findWall(p.position, direction, 0.0f, distance, triangle);
        if (t >= 0.0f)
            bounce(p, direction, t, triangle);
        else
            p.position += direction * distance;
        if (p.position.x > 1.15f)
            p.state = 2;
        splat(p.position);
    }
    params.particles[i] = p;
}

// Walls inside the channel, with their deposits, and the density of particles before them.
extern "C" __global__ void __raygen__draw() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned pixel = index.y * params.width + index.x;
    const float3 direction = cameraDirection(params.camera, (index.x + 0.5f) / params.width,
                                             (index.y + 0.5f) / params.height);
    unsigned triangle = 0;
    float3 color = vec(0.03f, 0.04f, 0.07f);
    const float outer = findWall(params.camera.eye, direction, 0.0f, 1e16f, triangle);
    if (outer >= 0.0f &&
        findWall(params.camera.eye, direction, outer + 1e-3f, 1e16f, triangle) >= 0.0f) {
        const float3 normal = params.mesh.normal(triangle);
        const float area = 0.5f * length(normal);
        const float deposit = params.deposits[triangle] / (area * params.count + 1e-6f);
        const float shade = 0.08f + 0.25f * fabsf(dot(normalize(normal), direction));
        color = vec(shade) + vec(0.5f, 0.12f, 0.02f) * (deposit / (deposit + 0.5f));
    }
    const float density =
        params.density[pixel] * 1e-2f * params.width * params.height / params.count;
    color += vec(0.25f, 0.6f, 1.0f) * (density / (density + 2.0f));
    params.image[pixel] = withWeight(color, 1.0f);
}
