// SPDX-License-Identifier: Apache-2.0
// A wavefront path tracer: queues of rays, OptiX only finds hits, kernels sort the hits by material
// and shade each material's run. The image does not depend on the order of the queue, as each path
// has its own random numbers: it must be the same in every run, bit for bit. Its mean and the
// number of hits must lie in the range that the scene allows.
#include "common.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cmath>

#include "device/wavefront.h"

#ifndef __CUDA_ARCH__
asm(".pushsection .rodata\n.globl device_ptx, device_ptx_size\ndevice_ptx:\n.incbin \"" DEVICE_PTX
    "\"\n.byte 0\nend_of_device_ptx:\n.balign 8\ndevice_ptx_size: .quad end_of_device_ptx - "
    "device_ptx - 1\n.popsection\n");
#endif

constexpr unsigned kSide = 40, kPaths = kSide * kSide, kBounces = 5;
constexpr int kMaterials = 3; // matt, mirror, lamp

struct Wave {
    PathState* paths;
    HitInfo* hits;
    unsigned *order, *next, *shadowed;
    unsigned* counts; // of each material, of the sky, then the places; the last: the next queue
    float* image;
};

__host__ __device__ inline float uniform(unsigned& seed) {
    seed = seed * 747796405u + 2891336453u;
    unsigned word = ((seed >> ((seed >> 28) + 4)) ^ seed) * 277803737u;
    word = (word >> 22) ^ word;
    return float(word >> 8) * (1.0f / 16777216.0f);
}

__host__ __device__ inline float dot3(float3 a, float3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

__global__ void beginPaths(Wave wave) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= kPaths)
        return;
    PathState path = {};
    path.origin = make_float3(0, 1, 5);
    const float3 d =
        make_float3((i % kSide + 0.5f) / kSide - 0.5f, (i / kSide + 0.5f) / kSide - 0.5f, -1);
    const float scale = 1.0f / sqrtf(dot3(d, d));
    path.direction = make_float3(d.x * scale, d.y * scale, d.z * scale);
    path.throughput = 1;
    path.pixel = i;
    path.seed = i * 9781u + 6271u;
    wave.paths[i] = path;
    wave.order[i] = i;
}

__global__ void countMaterials(Wave wave, unsigned count) {
    __shared__ unsigned local[kMaterials + 1];
    if (threadIdx.x <= kMaterials)
        local[threadIdx.x] = 0;
    __syncthreads();
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < count)
        atomicAdd(&local[wave.hits[wave.order[i]].material + 1], 1u);
    __syncthreads();
    if (threadIdx.x <= kMaterials && local[threadIdx.x])
        atomicAdd(&wave.counts[threadIdx.x], local[threadIdx.x]);
}

__global__ void placeMaterials(Wave wave, unsigned count) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count)
        return;
    const unsigned slot = wave.order[i];
    const int key = wave.hits[slot].material + 1;
    unsigned base = 0;
    for (int k = 0; k < key; ++k)
        base += wave.counts[k];
    wave.next[base + atomicAdd(&wave.counts[kMaterials + 1 + key], 1u)] = slot;
}

__device__ void enqueue(Wave& wave, unsigned slot) {
    // One atomic for each warp.
    const unsigned active = __activemask();
    const int leader = __ffs(active) - 1, lane = threadIdx.x & 31;
    unsigned base = 0;
    if (lane == leader)
        base = atomicAdd(&wave.counts[2 * (kMaterials + 1)], unsigned(__popc(active)));
    base = __shfl_sync(active, base, leader);
    wave.next[base + __popc(active & ((1u << lane) - 1))] = slot;
}

struct Matt {
    static __device__ bool shade(PathState& path, const HitInfo& hit, unsigned shadowed,
                                 float& light) {
        const float facing = fmaxf(0.0f, 0.6f * hit.normal.x + 0.8f * hit.normal.y);
        light = shadowed ? 0 : path.throughput * 0.5f * facing;
        const float z = 2 * uniform(path.seed) - 1, angle = 6.2831853f * uniform(path.seed);
        const float r = sqrtf(fmaxf(0.0f, 1 - z * z));
        float3 d = make_float3(hit.normal.x + r * cosf(angle), hit.normal.y + r * sinf(angle),
                               hit.normal.z + z);
        const float scale = 1.0f / sqrtf(fmaxf(1e-12f, dot3(d, d)));
        path.direction = make_float3(d.x * scale, d.y * scale, d.z * scale);
        path.throughput *= 0.6f;
        return uniform(path.seed) < 0.9f;
    }
};
struct Mirror {
    static __device__ bool shade(PathState& path, const HitInfo& hit, unsigned, float& light) {
        const float twice = 2 * dot3(path.direction, hit.normal);
        path.direction = make_float3(path.direction.x - twice * hit.normal.x,
                                     path.direction.y - twice * hit.normal.y,
                                     path.direction.z - twice * hit.normal.z);
        path.throughput *= 0.95f;
        light = 0;
        return true;
    }
};
struct Lamp {
    static __device__ bool shade(PathState& path, const HitInfo&, unsigned, float& light) {
        light = 4 * path.throughput;
        return false;
    }
};

template <class Material>
__global__ void shade(Wave wave, const unsigned* __restrict__ queue, unsigned count) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count)
        return;
    const unsigned slot = queue[i];
    PathState path = wave.paths[slot];
    const HitInfo hit = wave.hits[slot];
    float light = 0;
    const bool goesOn = Material::shade(path, hit, wave.shadowed[slot], light);
    wave.image[path.pixel] += light; // only this path's
    path.origin = hit.position;
    if (++path.bounce < kBounces && goesOn)
        enqueue(wave, slot);
    wave.paths[slot] = path;
}

__global__ void shadeSky(Wave wave, const unsigned* queue, unsigned count) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < count) {
        const PathState& path = wave.paths[queue[i]];
        wave.image[path.pixel] += path.throughput * (0.3f + 0.2f * path.direction.y);
    }
}

static unsigned blocks(unsigned count) {
    return (count + 127) / 128;
}

struct Tracer {
    OptixPipeline pipeline;
    OptixShaderBindingTable extend, shadow;
    OptixTraversableHandle scene;
    Buffer memory, boxes, table, params{sizeof(TraceParams)};

    explicit Tracer(OptixDeviceContext context) {
        const ShapeData shapes[] = {{0, {0, -100, 0, 100}},
                                    {0, {-1.2f, .8f, 0, .8f}},
                                    {1, {1, 1, .3f, 1}},
                                    {2, {0, 4, 0, 1}}};
        auto options = pipelineOptions(2, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
        OptixModule module = makeModule(context, options);
        const std::vector<OptixProgramGroup> groups = {
            raygenGroup(context, module, "__raygen__extend"),
            raygenGroup(context, module, "__raygen__shadow"),
            missGroup(context, module, "__miss__extend"),
            missGroup(context, module, "__miss__shadow"),
            hitGroup(context, module, "__closesthit__store", nullptr, "__intersection__sphere")};
        pipeline = makePipeline(context, options, groups);
        std::vector<Record<ShapeData>> records;
        for (int i = 0; i < 4; ++i)
            records.push_back(packed(groups[i], ShapeData()));
        for (const ShapeData& shape : shapes)
            records.push_back(packed(groups[4], shape));
        table = Buffer(records);
        constexpr unsigned kStride = sizeof(Record<ShapeData>);
        extend = {};
        extend.raygenRecord = table.ptr();
        extend.missRecordBase = table.ptr() + 2 * kStride;
        extend.hitgroupRecordBase = table.ptr() + 4 * kStride;
        extend.missRecordStrideInBytes = extend.hitgroupRecordStrideInBytes = kStride;
        extend.missRecordCount = 2;
        extend.hitgroupRecordCount = 4;
        shadow = extend;
        shadow.raygenRecord += kStride;

        // One build input for each shape, so that each has a record.
        std::vector<OptixAabb> bounds;
        std::vector<CUdeviceptr> addresses;
        for (const ShapeData& s : shapes)
            bounds.push_back({s.sphere.x - s.sphere.w, s.sphere.y - s.sphere.w,
                              s.sphere.z - s.sphere.w, s.sphere.x + s.sphere.w,
                              s.sphere.y + s.sphere.w, s.sphere.z + s.sphere.w});
        boxes = Buffer(bounds);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        std::vector<OptixBuildInput> inputs(4);
        for (unsigned i = 0; i < 4; ++i)
            addresses.push_back(boxes.ptr() + i * sizeof(OptixAabb));
        for (unsigned i = 0; i < 4; ++i) {
            inputs[i].type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
            inputs[i].customPrimitiveArray.aabbBuffers = &addresses[i];
            inputs[i].customPrimitiveArray.numPrimitives = 1;
            inputs[i].customPrimitiveArray.flags = &flags;
            inputs[i].customPrimitiveArray.numSbtRecords = 1;
        }
        scene = buildAccel(context, inputs, memory);
    }
    void launch(const OptixShaderBindingTable& with, const Wave& wave, const unsigned* queue,
                unsigned count) {
        if (count == 0)
            return;
        const TraceParams values = {scene, wave.paths, queue, wave.hits, wave.shadowed};
        CUDA_TRY(cudaMemcpyAsync(params.data, &values, sizeof values, cudaMemcpyHostToDevice));
        OPTIX_TRY(optixLaunch(pipeline, nullptr, params.ptr(), sizeof values, &with, count, 1, 1));
    }
};

static std::vector<float> render(Tracer& tracer, unsigned* shaded) {
    Buffer paths(kPaths * sizeof(PathState)), hits(kPaths * sizeof(HitInfo)), order(kPaths * 4),
        next(kPaths * 4), shadowed(kPaths * 4), counts((2 * kMaterials + 3) * 4), image(kPaths * 4);
    Wave wave = {paths.as<PathState>(), hits.as<HitInfo>(),      order.as<unsigned>(),
                 next.as<unsigned>(),   shadowed.as<unsigned>(), counts.as<unsigned>(),
                 image.as<float>()};
    CUDA_TRY(cudaMemset(image.data, 0, image.size));
    beginPaths<<<blocks(kPaths), 128>>>(wave);
    for (unsigned count = kPaths; count > 0;) {
        *shaded += count;
        tracer.launch(tracer.extend, wave, wave.order, count);
        CUDA_TRY(cudaMemset(counts.data, 0, counts.size));
        countMaterials<<<blocks(count), 128>>>(wave, count);
        placeMaterials<<<blocks(count), 128>>>(wave, count);
        std::swap(wave.order, wave.next);
        auto numbers = counts.download<unsigned>();
        const unsigned* queue = wave.order;
        tracer.launch(tracer.shadow, wave, queue + numbers[0], numbers[1]);
        auto run = [&](auto kernel, int material) {
            if (numbers[material + 1])
                kernel<<<blocks(numbers[material + 1]), 128>>>(wave, queue, numbers[material + 1]);
            queue += numbers[material + 1];
        };
        run(shadeSky, -1);
        run(shade<Matt>, 0);
        run(shade<Mirror>, 1);
        run(shade<Lamp>, 2);
        CUDA_TRY(cudaGetLastError());
        count = counts.download<unsigned>()[2 * (kMaterials + 1)];
        std::swap(wave.order, wave.next);
    }
    return image.download<float>();
}

int main() {
    return runChecked([] {
        OptixDeviceContext context = makeContext();
        bool right = true;
        {
            Tracer tracer(context);
            unsigned shaded = 0;
            const std::vector<float> first = render(tracer, &shaded);
            const std::vector<float> second = render(tracer, &shaded);
            double mean = 0;
            unsigned different = 0;
            for (unsigned i = 0; i < kPaths; ++i) {
                mean += first[i] / kPaths;
                different += first[i] != second[i];
            }
            std::printf("mean %.3f, %u pixels differ, %u paths shaded\n", mean, different, shaded);
            right = different == 0 && mean > 0.56 && mean < 0.59 && shaded > 3 * kPaths;
        }
        OPTIX_TRY(optixDeviceContextDestroy(context));
        return right;
    });
}
