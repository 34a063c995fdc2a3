// SPDX-License-Identifier: Apache-2.0
// A world of voxels: the intersection program walks through a brick from voxel to voxel and reports
// the first full one. The hit kind is its face. Ray generation follows paths. Payload: distance,
// entry of the palette, face.
#include "tools.h"
#include "voxels.h"

extern "C" {
__constant__ VoxelParams params;
}

struct VoxelHit {
    float distance; // negative: none
    unsigned paint, face;
};

DEVICE float component(float3 v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

// A walk along a ray through the voxels of a brick.
struct Walk {
    int cell[3], step[3], axis; // the axis of the last step
    float next[3], slope[3], t;

    // Begins where the ray enters, not before `tmin`; false if it misses the brick.
    __forceinline__ __device__ bool begin(float3 origin, float3 direction, float tmin) {
        float enter = -1e30f, leave = 1e30f;
        axis = 0;
        for (int k = 0; k < 3; ++k) {
            const float d = component(direction, k), o = component(origin, k);
            slope[k] = 1.0f / (fabsf(d) < 1e-12f ? copysignf(1e-12f, d) : d);
            const float a = -o * slope[k], b = (kBrickSide - o) * slope[k];
            if (fminf(a, b) > enter) {
                enter = fminf(a, b);
                axis = k;
            }
            leave = fminf(leave, fmaxf(a, b));
        }
        t = fmaxf(enter, tmin);
        if (t >= leave)
            return false;
        for (int k = 0; k < 3; ++k) {
            const float at = component(origin, k) + component(direction, k) * t;
            cell[k] = min(max(static_cast<int>(floorf(at)), 0), kBrickSide - 1);
            step[k] = slope[k] < 0.0f ? -1 : 1;
            next[k] = (cell[k] + (step[k] > 0) - component(origin, k)) * slope[k];
            slope[k] = fabsf(slope[k]);
        }
        return true;
    }
    // To the next voxel; false behind the last.
    __forceinline__ __device__ bool advance() {
        axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        t = next[axis];
        cell[axis] += step[axis];
        next[axis] += slope[axis];
        return cell[axis] >= 0 && cell[axis] < kBrickSide;
    }
    __forceinline__ __device__ int index() const {
        return (cell[1] * kBrickSide + cell[2]) * kBrickSide + cell[0];
    }
};

extern "C" __global__ void __intersection__brick() {
    const Brick& brick = params.bricks[optixGetPrimitiveIndex()];
    const float3 corner = vec(brick.x, brick.y, brick.z);
    Walk walk;
    if (!walk.begin(optixGetObjectRayOrigin() - corner, optixGetObjectRayDirection(),
                    optixGetRayTmin()))
        return;
    do {
        if (walk.t >= optixGetRayTmax())
            return;
        const unsigned paint = brick.voxels[walk.index()];
        if (paint) {
            optixReportIntersection(walk.t, 2 * walk.axis + (walk.step[walk.axis] > 0), paint);
            return;
        }
    } while (walk.advance());
}

extern "C" __global__ void __closesthit__voxel() {
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetAttribute_0());
    optixSetPayload_2(optixGetHitKind());
}
extern "C" __global__ void __miss__sky() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}

DEVICE VoxelHit find(float3 origin, float3 direction, unsigned flags) {
    unsigned distance = 0, paint = 0, face = 0;
    optixTrace(params.world, origin, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | flags, 0, 1, 0, distance, paint, face);
    return {__uint_as_float(distance), paint, face};
}
DEVICE float3 normalOf(unsigned face) {
    const float sign = face & 1 ? -1.0f : 1.0f;
    return vec(face / 2 == 0 ? sign : 0.0f, face / 2 == 1 ? sign : 0.0f,
               face / 2 == 2 ? sign : 0.0f);
}

DEVICE float3 follow(float3 origin, float3 direction, unsigned& random) {
    float3 sum = vec(0.0f), weight = vec(1.0f);
    for (unsigned bounce = 0; bounce <= params.bounces; ++bounce) {
        const VoxelHit hit = find(origin, direction, OPTIX_RAY_FLAG_NONE);
        if (hit.distance < 0.0f)
            return sum + weight * blueSky(direction) * 0.8f;
        const VoxelPaint& paint = params.palette[hit.paint];
        const float3 normal = normalOf(hit.face);
        sum += weight * paint.emission;
        weight *= paint.color;
        origin = origin + direction * hit.distance + normal * 2e-3f;
        const float cosine = dot(normal, params.sun);
        if (cosine > 0.0f &&
            find(origin, params.sun, OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT).distance < 0.0f)
            sum += weight * vec(2.2f, 1.9f, 1.4f) * cosine;
        const float u = nextFloat(random), v = nextFloat(random);
        direction = cosineDirection(normal, u, v);
    }
    return sum;
}

extern "C" __global__ void __raygen__world() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        sum += follow(params.camera.eye, cameraDirection(params.camera, x, y), random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
