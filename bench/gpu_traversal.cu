// SPDX-License-Identifier: Apache-2.0
// Kernels of bench_gpu_kernels: traversal alone, without user programs. One thread a ray, or
// persistent warps whose lanes take a new ray when theirs has ended.
#include "gpu_traversal.h"

#include "bvh/gpu/walk/traversal.h"

using namespace sunstone::bvh;
using namespace sunstone::bvh::gpu;

namespace {

struct Nearest : NoShapes, NoMotion, OneLane {
    static constexpr bool kTriangles = true, kCustoms = false, kInstances = false;
    static constexpr unsigned kLevels = 0;
    uint32_t primitive = ~0u;

    __device__ Visit triangle(gpu::Ray& ray, const TriangleHit& hit, uint32_t p, uint32_t) {
        if (hit.t < ray.tmax || p < primitive) {
            ray.tmax = hit.t;
            primitive = p;
        }
        return Visit::kContinue;
    }
    __device__ Visit custom(gpu::Ray&, uint32_t, uint32_t) { return Visit::kContinue; }
    __device__ void leave(gpu::Ray&) {}
};

struct Any : Nearest {
    __device__ Visit triangle(gpu::Ray&, const TriangleHit&, uint32_t, uint32_t) {
        primitive = 1;
        return Visit::kEnd;
    }
};

__device__ gpu::Ray loadRay(const GpuBenchJob& job, uint32_t index) {
    const U4* const words = reinterpret_cast<const U4*>(job.rays) + 2ull * index;
    const U4 a = loadConstant(words), b = loadConstant(words + 1);
    return {{floatOf(a.x), floatOf(a.y), floatOf(a.z)},
            floatOf(a.w),
            {floatOf(b.x), floatOf(b.y), floatOf(b.z)},
            floatOf(b.w)};
}

__device__ void store(const GpuBenchJob& job, uint32_t index, uint32_t primitive, float t) {
    reinterpret_cast<U2*>(job.hits)[index] = U2{bitsOf(primitive == ~0u ? -1.0f : t), primitive};
}

template <class Programs>
__device__ void plain(const GpuBenchJob& job) {
    const uint32_t index = blockIdx.x * blockDim.x + threadIdx.x;
    if (index >= job.count)
        return;
    gpu::Ray ray = loadRay(job, index);
    Programs programs;
    Traversal<Programs> traversal;
    U2 stack[Traversal<Programs>::kStackSize];
    if (traversal.start(programs, ray, job.handle, nullptr))
        traversal.run(programs, ray, stack, nullptr, RunToEnd());
    store(job, index, programs.primitive, ray.tmax);
}

// Stops as soon as fewer lanes than wanted continue.
struct RunWhileFull {
    uint32_t wanted;
    __device__ bool stop() const { return uint32_t(__popc(int(__activemask()))) < wanted; }
};

template <class Programs>
__device__ void persistent(const GpuBenchJob& job) {
    const uint32_t lane = threadIdx.x & 31u;
    gpu::Ray ray;
    Programs programs;
    Traversal<Programs> traversal;
    U2 stack[Traversal<Programs>::kStackSize];
    uint32_t index = 0;
    bool active = false, exhausted = false;
    for (;;) {
        const uint32_t idle = __ballot_sync(~0u, !active);
        if (idle && !exhausted) {
            uint32_t first = 0;
            if (lane == 0)
                first = atomicAdd(reinterpret_cast<uint32_t*>(job.counter),
                                  uint32_t(__popc(int(idle))));
            first = __shfl_sync(~0u, first, 0);
            exhausted = first + uint32_t(__popc(int(idle))) >= job.count;
            if (!active) {
                index = first + uint32_t(__popc(int(idle & ((1u << lane) - 1))));
                if (index < job.count) {
                    ray = loadRay(job, index);
                    programs = Programs();
                    active = traversal.start(programs, ray, job.handle, nullptr);
                    if (!active)
                        store(job, index, ~0u, 0);
                }
            }
        }
        if (!__any_sync(~0u, active)) {
            if (exhausted)
                break;
            continue;
        }
        if (active && traversal.run(programs, ray, stack, nullptr,
                                    RunWhileFull{exhausted ? 0 : job.wanted})) {
            store(job, index, programs.primitive, ray.tmax);
            active = false;
        }
        __syncwarp();
    }
}

} // namespace

#define TRACE_KERNEL(name, body, blocks)                                                           \
    extern "C" __global__ void __launch_bounds__(128, blocks) name(GpuBenchJob job) {              \
        body(job);                                                                                 \
    }

TRACE_KERNEL(nearest_plain, plain<Nearest>, 8)
TRACE_KERNEL(any_plain, plain<Any>, 8)
TRACE_KERNEL(nearest_persistent, persistent<Nearest>, 6)
TRACE_KERNEL(any_persistent, persistent<Any>, 6)
TRACE_KERNEL(nearest_persistent_8, persistent<Nearest>, 8)
TRACE_KERNEL(any_persistent_8, persistent<Any>, 8)
