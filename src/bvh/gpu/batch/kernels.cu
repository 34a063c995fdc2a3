// SPDX-License-Identifier: Apache-2.0
// Batches of rays on GPUs: persistent warps, whose lanes take a new ray when theirs has ended. One
// kernel for each combination of closest or any hits, triangles or instances, with or without
// masks; batches.cpp launches them.
#include "bvh/gpu/batch/job.h"
#include "bvh/gpu/walk/traversal.h"

using namespace sunstone::bvh;
using namespace sunstone::bvh::gpu;

namespace {

template <bool kAnyHit, bool kGraph, bool kMasked>
struct BatchPrograms : NoShapes, NoMotion, NoDeepGraphs, OneLane {
    static constexpr bool kTriangles = true, kCustoms = false, kInstances = kGraph;
    static constexpr unsigned kLevels = kGraph ? 1 : 0;

    TriangleHit hit;
    uint32_t triangleId = ~0u, instance = ~0u, current = ~0u;
    uint32_t mask = ~0u;
    uint64_t masks = 0; // of the current triangles, kMasked
    uint64_t tables = 0;

    __device__ Visit triangle(gpu::Ray& ray, const TriangleHit& h, uint32_t id, uint32_t) {
        if (kMasked && masks != 0 && !(reinterpret_cast<const uint32_t*>(masks)[id] & mask))
            return Visit::kContinue;
        // `instance` and `triangleId` start with the largest value.
        if (!kAnyHit && !(h.t < ray.tmax || (triangleId == ~0u || current < instance ||
                                             (current == instance && id < triangleId))))
            return Visit::kContinue;
        hit = h;
        ray.tmax = h.t;
        triangleId = id;
        instance = current;
        return kAnyHit ? Visit::kEnd : Visit::kContinue;
    }
    __device__ Visit custom(gpu::Ray&, uint32_t, uint32_t) { return Visit::kContinue; }
    __device__ bool enterInstance(gpu::Ray&, const InstanceRecord& record, uint64_t& child) {
        child = record.child;
        current = record.index;
        if (kMasked)
            masks = tables ? reinterpret_cast<const uint64_t*>(tables)[current] : 0;
        return true;
    }
    __device__ bool enterTransform(gpu::Ray&, uint64_t, uint64_t&, float*) { return false; }
    __device__ void leave(gpu::Ray&, uint32_t = 1) { current = ~0u; }
    __device__ bool nearestFirst() const { return !kAnyHit; }
};

__device__ void loadRay(const BatchJob& job, uint32_t index, gpu::Ray& ray, uint32_t& mask) {
    mask = ~0u;
    if (job.aligned) {
        const U4* const words = reinterpret_cast<const U4*>(job.batch.rays) + 2ull * index;
        const U4 a = loadConstant(words), b = loadConstant(words + 1);
        ray = {{floatOf(a.x), floatOf(a.y), floatOf(a.z)},
               startOf(floatOf(a.w)),
               {floatOf(b.x), floatOf(b.y), floatOf(b.z)},
               floatOf(b.w)};
        if (job.batch.rayFormat == RayFormat::kOriginMaskDirectionTmax) {
            ray.tmin = 0;
            mask = a.w;
        }
        return;
    }
    const BatchRay from = readRay(job.batch, index);
    ray = {{from.origin[0], from.origin[1], from.origin[2]},
           from.tmin,
           {from.direction[0], from.direction[1], from.direction[2]},
           from.tmax};
    mask = from.mask;
}

template <class Programs>
__device__ void store(const BatchJob& job, uint32_t index, const Programs& programs, float t) {
    const bool found = programs.triangleId != ~0u;
    if (job.batch.hitFormat == HitFormat::kBit) {
        reinterpret_cast<uint8_t*>(job.found)[index] = found;
        return;
    }
    BatchHit hit = kNoBatchHit;
    if (found)
        hit = {t, programs.triangleId, programs.instance == ~0u ? 0u : programs.instance,
               divide(programs.hit.v, programs.hit.det), divide(programs.hit.w, programs.hit.det)};
    writeHit(job.batch, index, hit);
}

// Stops as soon as fewer lanes than wanted continue.
struct RunWhileFull {
    uint32_t wanted;
    __device__ bool stop() const { return uint32_t(__popc(int(__activemask()))) < wanted; }
};

template <class Programs>
__device__ void trace(const BatchJob& job) {
    const uint32_t lane = threadIdx.x & 31u;
    const uint32_t count = uint32_t(job.batch.count);
    gpu::Ray ray;
    Programs programs;
    Traversal<Programs> traversal;
    U2 stack[Traversal<Programs>::kStackSize];
    typename Traversal<Programs>::Level levels[Programs::kLevels + 1];
    uint32_t index = 0;
    bool active = false, exhausted = false;
    for (;;) {
        const uint32_t idle = __ballot_sync(~0u, !active);
        if (idle && !exhausted) {
            const uint32_t wanted = uint32_t(__popc(int(idle)));
            uint32_t first = 0;
            if (lane == 0)
                first = atomicAdd(reinterpret_cast<uint32_t*>(job.counter), wanted);
            first = __shfl_sync(~0u, first, 0);
            exhausted = first + wanted >= count;
            if (!active)
                index = first + uint32_t(__popc(int(idle & ((1u << lane) - 1))));
            if (!active && index < count) {
                programs = Programs();
                loadRay(job, index, ray, programs.mask);
                (Programs::kInstances ? programs.tables : programs.masks) = job.batch.masks;
                active = traversal.start(programs, ray, job.batch.handle, levels);
                if (!active)
                    store(job, index, programs, 0);
            }
        }
        if (!__any_sync(~0u, active)) {
            if (exhausted)
                break;
            continue;
        }
        if (active && traversal.run(programs, ray, stack, levels,
                                    RunWhileFull{exhausted ? 0 : job.wantedLanes})) {
            store(job, index, programs, ray.tmax);
            active = false;
        }
        __syncwarp();
    }
}

} // namespace

#define BATCH_KERNEL(name, any, graph, masked, blocks)                                             \
    extern "C" __global__ void __launch_bounds__(128, blocks) name(BatchJob job) {                 \
        trace<BatchPrograms<any, graph, masked>>(job);                                             \
    }

BATCH_KERNEL(batch_closest, false, false, false, 6)
BATCH_KERNEL(batch_any, true, false, false, 6)
BATCH_KERNEL(batch_closest_masked, false, false, true, 6)
BATCH_KERNEL(batch_any_masked, true, false, true, 6)
BATCH_KERNEL(batch_closest_instances, false, true, false, 4)
BATCH_KERNEL(batch_any_instances, true, true, false, 4)
BATCH_KERNEL(batch_closest_instances_masked, false, true, true, 4)
BATCH_KERNEL(batch_any_instances_masked, true, true, true, 4)

// Writes the bits of the rays, one byte per thread. Bits outside the range keep their values.
extern "C" __global__ void batch_bits(BatchJob job) {
    const uint64_t byte = uint64_t(blockIdx.x) * blockDim.x + threadIdx.x;
    const uint64_t end = job.batch.firstBit + job.batch.count;
    if (byte * 8 >= end)
        return;
    uint8_t* const to = reinterpret_cast<uint8_t*>(job.batch.hits) + byte;
    uint32_t bits = *to;
    for (uint32_t i = 0; i < 8; ++i) {
        const uint64_t place = byte * 8 + i;
        if (place < job.batch.firstBit || place >= end)
            continue;
        const uint32_t found =
            reinterpret_cast<const uint8_t*>(job.found)[place - job.batch.firstBit];
        bits = (bits & ~(1u << i)) | found << i;
    }
    *to = uint8_t(bits);
}

// The masks of triangles from indices of four words.
extern "C" __global__ void batch_masks(const uint32_t* indices, uint32_t* masks, uint64_t count) {
    const uint64_t i = uint64_t(blockIdx.x) * blockDim.x + threadIdx.x;
    if (i < count)
        masks[i] = indices[4 * i + 3];
}
