// SPDX-License-Identifier: Apache-2.0
// Names of the toolkit's headers that programs use beside the common ones.
#include <cuda_pipeline.h>
#include <cuda_runtime.h>
#include <device_launch_parameters.h>
#include <sm_20_atomic_functions.h>

#include "check.h"

__device__ unsigned volumeOf(dim3 size) {
    return size.x * size.y * size.z;
}

__global__ void places(unsigned* out) {
    const dim3 block = blockIdx;
    dim3 thread(threadIdx);
    thread = blockDim;
    const uint3 size = gridDim;
    atomicAdd(out, volumeOf(gridDim) * 100 + volumeOf(thread) + block.x * 1000 + size.y);
}

__global__ void __launch_bounds__(64) reversed(const int* in, int* out) {
    __shared__ int4 staged[16];
    int* const words = reinterpret_cast<int*>(staged);
    const unsigned t = threadIdx.x;
    if (t < 8)
        __pipeline_memcpy_async(&staged[t], reinterpret_cast<const int4*>(in) + t, 16);
    else if (t < 16)
        __pipeline_memcpy_async(&staged[t], reinterpret_cast<const int4*>(in) + t, 16, 6);
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncthreads();
    out[t] = words[63 - t];
}

template <class T>
__global__ void fill(T* out, T value) {
    out[threadIdx.x] = value;
}

struct Counted {
    int& deleted;
    ~Counted() { ++deleted; }
};

// Functions that take the kernel, the variable's pointer or the object itself.
void typedArguments() {
    cudaKernel_t kernel;
    const char* name = nullptr;
    int blocks = 0, deleted = 0, *out;
    CHECK(cudaGetKernel(&kernel, fill<int>));
    CHECK(cudaFuncGetName(&name, fill<int>));
    CHECK(cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(&blocks, fill<int>, 64, 0,
                                                                 cudaOccupancyDefault));
    CHECK(cudaMallocManaged(&out, sizeof(int)));
    cudaLaunchAttribute attributes[2] = {};
    attributes[0].id = cudaLaunchAttributeMemSyncDomain;
    attributes[0].val.memSyncDomain = cudaLaunchMemSyncDomainDefault;
    attributes[1].id = cudaLaunchAttributeMemSyncDomainMap;
    attributes[1].val.memSyncDomainMap.default_ = 0;
    attributes[1].val.memSyncDomainMap.remote = 1;
    cudaLaunchConfig_t config = {};
    config.gridDim = config.blockDim = 1;
    config.attrs = attributes;
    config.numAttrs = 2;
    CHECK(cudaLaunchKernelEx(&config, fill<int>, out, 7));
    CHECK(cudaDeviceSynchronize());

    cudaUserObject_t object;
    CHECK(cudaUserObjectCreate(&object, new Counted{deleted}, 1, cudaUserObjectNoDestructorSync));
    CHECK(cudaUserObjectRelease(object, 1));
    CHECK(cudaDeviceSynchronize());
    while (*static_cast<volatile int*>(&deleted) == 0) // another thread may delete the object
        continue;
    std::printf("%s, %d, filled with %d, deleted %d\n", name, blocks > 0, *out, deleted);

    cudaLibrary_t library;
    int* variable;
    const char* ptx = ".version 6.0\n.target sm_70\n.address_size 64\n.visible .global .u32 v;\n";
    size_t bytes = 0;
    CHECK(cudaLibraryLoadData(&library, ptx, nullptr, nullptr, 0, nullptr, nullptr, 0));
    CHECK(cudaLibraryGetGlobal(&variable, &bytes, library, "v"));
    std::printf("%zu bytes\n", bytes);
    CHECK(cudaLibraryUnload(library));
}

int main() {
    unsigned* sum;
    int *in, *out;
    CHECK(cudaMallocManaged(&sum, sizeof(unsigned)));
    CHECK(cudaMallocManaged(&in, 64 * sizeof(int)));
    CHECK(cudaMallocManaged(&out, 64 * sizeof(int)));
    *sum = 0;
    places<<<dim3(2, 3), dim3(4, 2)>>>(sum);
    for (int i = 0; i < 64; ++i)
        in[i] = 0x10101 * i;
    reversed<<<1, 64>>>(in, out);
    CHECK(cudaDeviceSynchronize());
    std::printf("places %u; reversed %x %x %x %x\n", *sum, out[63], out[2], out[1], out[0]);

    double sine, cosine;
    sincospi(0.25, &sine, &cosine);
    std::printf("host: %.3f %.3f %.3f %.3f %.3f\n", sinpi(1e6 + 0.5), cospi(3.0), rcbrt(8.0), sine,
                cosine);

    cudaStream_t stream;
    CHECK(cudaStreamCreate(&stream));
    cudaStreamAttrValue value = {};
    value.accessPolicyWindow.hitRatio = 0.5f;
    value.accessPolicyWindow.hitProp = cudaAccessPropertyPersisting;
    value.accessPolicyWindow.missProp = cudaAccessPropertyStreaming;
    CHECK(cudaStreamSetAttribute(stream, cudaStreamAttributeAccessPolicyWindow, &value));
    cudaGraph_t graph;
    cudaGraphExec_t exec;
    CHECK(cudaGraphCreate(&graph, 0));
    CHECK(cudaGraphInstantiate(&exec, graph, nullptr, nullptr, 0));
    std::printf("%s\n", cudaGetErrorName(cudaErrorSyncDepthExceeded));
    typedArguments();
    return 0;
}
