// SPDX-License-Identifier: Apache-2.0
// Nodes of a graph by one struct of parameters for all types; occupancy and capture by the shorter
// forms of the C++ interface.
#include <cuda_runtime.h>

#include "check.h"

#include <cstring>

__global__ void addTo(int* sum, int by) {
    *sum += by;
}
__global__ void takesShared(int* to) {
    extern __shared__ int memory[];
    memory[threadIdx.x] = threadIdx.x;
    __syncthreads();
    to[threadIdx.x] = memory[blockDim.x - 1 - threadIdx.x];
}

static int* sum;
static int by = 5, hostCalls = 0;
static void* arguments[] = {&sum, &by};

static void CUDART_CB countCall(void* calls) {
    ++*static_cast<int*>(calls);
}

static cudaGraphNodeParams kernelParams() {
    cudaGraphNodeParams params = {};
    params.type = cudaGraphNodeTypeKernel;
    params.kernel.func = (void*)addTo;
    params.kernel.gridDim = dim3(1);
    params.kernel.blockDim = dim3(1);
    params.kernel.kernelParams = arguments;
    return params;
}

// Set to zero, add, copy to the host, count.
static void nodesOfAllKinds(int* result) {
    cudaGraph_t graph, child;
    CHECK(cudaGraphCreate(&graph, 0));
    CHECK(cudaGraphCreate(&child, 0));
    cudaGraphNode_t set, add, copy, host, empty, last;
    cudaGraphNodeParams params = {};
    params.type = cudaGraphNodeTypeMemset;
    params.memset.dst = sum;
    params.memset.elementSize = 4;
    params.memset.value = 100;
    params.memset.width = params.memset.height = 1;
    CHECK(cudaGraphAddNode(&set, graph, nullptr, nullptr, 0, &params));
    cudaGraphNodeParams kernel = kernelParams();
    cudaGraphEdgeData plain = {};
    CHECK(cudaGraphAddNode(&add, graph, &set, &plain, 1, &kernel));
    params = {};
    params.type = cudaGraphNodeTypeHost;
    params.host.fn = countCall;
    params.host.userData = &hostCalls;
    CHECK(cudaGraphAddNode(&host, child, nullptr, nullptr, 0, &params));
    params = {};
    params.type = cudaGraphNodeTypeGraph;
    params.graph.graph = child;
    CHECK(cudaGraphAddNode(&last, graph, &add, nullptr, 1, &params));
    params = {};
    params.type = cudaGraphNodeTypeEmpty;
    CHECK(cudaGraphAddNode(&empty, graph, &last, nullptr, 1, &params));
    params = {};
    params.type = cudaGraphNodeTypeMemcpy;
    params.memcpy.copyParams.srcPtr = make_cudaPitchedPtr(sum, 4, 4, 1);
    params.memcpy.copyParams.dstPtr = make_cudaPitchedPtr(result, 4, 4, 1);
    params.memcpy.copyParams.extent = make_cudaExtent(4, 1, 1);
    params.memcpy.copyParams.kind = cudaMemcpyDeviceToHost;
    CHECK(cudaGraphAddNode(&copy, graph, &empty, nullptr, 1, &params));
    cudaGraphExec_t exec;
    CHECK(cudaGraphInstantiate(&exec, graph, 0));
    CHECK(cudaGraphLaunch(exec, 0));
    CHECK(cudaDeviceSynchronize());
    printf("%d after a launch, %d host call\n", *result, hostCalls);
    by = 7;
    kernel = kernelParams();
    CHECK(cudaGraphNodeSetParams(add, &kernel));
    CHECK(cudaGraphLaunch(exec, 0));
    CHECK(cudaDeviceSynchronize());
    printf("%d after a change of the graph\n", *result);
    CHECK(cudaGraphExecNodeSetParams(exec, add, &kernel));
    CHECK(cudaGraphLaunch(exec, 0));
    CHECK(cudaDeviceSynchronize());
    printf("%d after a change of the executable graph\n", *result);
    CHECK(cudaGraphExecDestroy(exec));
    CHECK(cudaGraphDestroy(graph));
    CHECK(cudaGraphDestroy(child));
}

struct WordPerThread {
    __host__ __device__ size_t operator()(int threads) const { return sizeof(int) * threads; }
};

static void occupancy() {
    size_t bytes = 0;
    CHECK(cudaOccupancyAvailableDynamicSMemPerBlock(&bytes, takesShared, 1, 128));
    int blocks = 0, grid = 0, size = 0;
    CHECK(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, takesShared, 128, bytes));
    printf("a block with all its shared memory fits: %s\n", bytes && blocks >= 1 ? "yes" : "no");
    CHECK(
        cudaOccupancyMaxPotentialBlockSizeVariableSMem(&grid, &size, takesShared, WordPerThread()));
    printf("block size found: %s\n", size >= 32 && size <= 1024 && grid > 0 ? "yes" : "no");
}

static void launchAttributes() {
    cudaLaunchAttribute attribute = {};
    attribute.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    attribute.val.programmaticStreamSerializationAllowed = 1;
    cudaLaunchConfig_t config = {};
    config.gridDim = dim3(1);
    config.blockDim = dim3(1);
    config.attrs = &attribute;
    config.numAttrs = 1;
    CHECK(cudaMemset(sum, 0, 4));
    CHECK(cudaLaunchKernelEx(&config, addTo, sum, 3));
    int value = 0;
    CHECK(cudaMemcpy(&value, sum, 4, cudaMemcpyDeviceToHost));
    printf("%d by a launch with programmatic serialization\n", value);
}

static void captureInfo() {
    cudaStream_t stream;
    CHECK(cudaStreamCreate(&stream));
    CHECK(cudaStreamBeginCapture(stream, cudaStreamCaptureModeGlobal));
    cudaStreamCaptureStatus status;
    unsigned long long id = 0;
    CHECK(cudaStreamGetCaptureInfo(stream, &status, &id));
    printf("captures: %s\n", status == cudaStreamCaptureStatusActive && id ? "yes" : "no");
    cudaGraph_t graph;
    CHECK(cudaStreamEndCapture(stream, &graph));
    CHECK(cudaGraphDestroy(graph));
    CHECK(cudaStreamDestroy(stream));
}

int main() {
    int* result;
    CHECK(cudaMalloc(&sum, 4));
    CHECK(cudaMallocHost(&result, 4));
    nodesOfAllKinds(result);
    occupancy();
    launchAttributes();
    captureInfo();
    return 0;
}
