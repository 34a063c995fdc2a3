// SPDX-License-Identifier: Apache-2.0
// A pipeline over two streams captured into a graph, run many times, updated, and built again by
// hand.
#include <cuda_runtime.h>

#include "check.h"

__global__ void fillWith(int* data, int n, int value) {
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < n; i += gridDim.x * blockDim.x)
        data[i] = value + i;
}
__global__ void addTo(const int* a, const int* b, int* sum, int n, int scale) {
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < n; i += gridDim.x * blockDim.x)
        sum[i] += (a[i] + b[i]) * scale;
}

static int hostCalls;
static void CUDART_CB countCalls(void* data) {
    hostCalls += *static_cast<int*>(data);
}

static const int n = 4096;
static int *a, *b, *sum, *result;
static int step = 1;

static cudaGraph_t capture(cudaStream_t first, cudaStream_t second, int scale) {
    cudaEvent_t fork, join;
    CHECK(cudaEventCreateWithFlags(&fork, cudaEventDisableTiming));
    CHECK(cudaEventCreateWithFlags(&join, cudaEventDisableTiming));
    CHECK(cudaStreamBeginCapture(first, cudaStreamCaptureModeGlobal));
    cudaStreamCaptureStatus status;
    CHECK(cudaStreamIsCapturing(first, &status));
    std::printf("capturing: %d\n", status == cudaStreamCaptureStatusActive);
    CHECK(cudaEventRecord(fork, first));
    CHECK(cudaStreamWaitEvent(second, fork, 0));
    fillWith<<<4, 128, 0, first>>>(a, n, 1);
    fillWith<<<4, 128, 0, second>>>(b, n, 100);
    CHECK(cudaEventRecord(join, second));
    CHECK(cudaStreamWaitEvent(first, join, 0));
    addTo<<<4, 128, 0, first>>>(a, b, sum, n, scale);
    CHECK(cudaMemcpyAsync(result, sum, n * sizeof(int), cudaMemcpyDeviceToHost, first));
    CHECK(cudaLaunchHostFunc(first, countCalls, &step));
    cudaGraph_t graph;
    CHECK(cudaStreamEndCapture(first, &graph));
    CHECK(cudaEventDestroy(fork));
    CHECK(cudaEventDestroy(join));
    return graph;
}

static long long total() {
    long long t = 0;
    for (int i = 0; i < n; ++i)
        t += result[i];
    return t;
}

int main() {
    CHECK(cudaMalloc(&a, n * sizeof(int)));
    CHECK(cudaMalloc(&b, n * sizeof(int)));
    CHECK(cudaMalloc(&sum, n * sizeof(int)));
    CHECK(cudaMallocHost(&result, n * sizeof(int)));
    CHECK(cudaMemset(sum, 0, n * sizeof(int)));
    cudaStream_t first, second;
    CHECK(cudaStreamCreateWithFlags(&first, cudaStreamNonBlocking));
    CHECK(cudaStreamCreateWithFlags(&second, cudaStreamNonBlocking));

    cudaGraph_t graph = capture(first, second, 1);
    std::printf("calls while capturing: %d\n", hostCalls);
    size_t nodes = 0, roots = 0;
    CHECK(cudaGraphGetNodes(graph, nullptr, &nodes));
    CHECK(cudaGraphGetRootNodes(graph, nullptr, &roots));
    std::printf("nodes %d, roots %d\n", int(nodes), int(roots));
    cudaGraphNode_t all[16];
    CHECK(cudaGraphGetNodes(graph, all, &nodes));
    int kinds[16] = {};
    for (size_t i = 0; i < nodes; ++i) {
        cudaGraphNodeType type;
        CHECK(cudaGraphNodeGetType(all[i], &type));
        ++kinds[type];
    }
    std::printf("kernels %d, copies %d, host functions %d\n", kinds[cudaGraphNodeTypeKernel],
                kinds[cudaGraphNodeTypeMemcpy], kinds[cudaGraphNodeTypeHost]);

    cudaGraphExec_t exec;
    CHECK(cudaGraphInstantiateWithFlags(&exec, graph, 0));
    for (int i = 0; i < 10; ++i)
        CHECK(cudaGraphLaunch(exec, first));
    CHECK(cudaStreamSynchronize(first));
    std::printf("total %lld after %d runs\n", total(), hostCalls);

    // The same shape with other parameters.
    cudaGraph_t other = capture(first, second, 1000);
    cudaGraphExecUpdateResultInfo info;
    CHECK(cudaGraphExecUpdate(exec, other, &info));
    std::printf("update: %d\n", int(info.result));
    CHECK(cudaGraphLaunch(exec, second));
    CHECK(cudaStreamSynchronize(second));
    std::printf("total %lld after %d runs\n", total(), hostCalls);

    // By hand: set, kernel, copy.
    cudaGraph_t built;
    CHECK(cudaGraphCreate(&built, 0));
    cudaGraphNode_t set, kernel, copy;
    cudaMemsetParams setParams = {};
    setParams.dst = sum;
    setParams.value = 0;
    setParams.elementSize = 4;
    setParams.width = n;
    setParams.height = 1;
    CHECK(cudaGraphAddMemsetNode(&set, built, nullptr, 0, &setParams));
    int count = n, scale = 2;
    void* arguments[] = {&a, &b, &sum, &count, &scale};
    cudaKernelNodeParams params = {};
    params.func = reinterpret_cast<void*>(addTo);
    params.gridDim = dim3(8);
    params.blockDim = dim3(64);
    params.kernelParams = arguments;
    CHECK(cudaGraphAddKernelNode(&kernel, built, &set, 1, &params));
    CHECK(cudaGraphAddMemcpyNode1D(&copy, built, &kernel, 1, result, sum, n * sizeof(int),
                                   cudaMemcpyDeviceToHost));
    cudaGraphExec_t builtExec;
    CHECK(cudaGraphInstantiateWithFlags(&builtExec, built, 0));
    CHECK(cudaGraphLaunch(builtExec, first));
    CHECK(cudaStreamSynchronize(first));
    std::printf("built: total %lld\n", total());
    scale = 3;
    CHECK(cudaGraphExecKernelNodeSetParams(builtExec, kernel, &params));
    CHECK(cudaGraphLaunch(builtExec, first));
    CHECK(cudaStreamSynchronize(first));
    std::printf("changed: total %lld\n", total());

    // A call that a capture does not allow ends it.
    CHECK(cudaStreamBeginCapture(first, cudaStreamCaptureModeGlobal));
    std::printf("synchronize: %s\n", cudaGetErrorName(cudaStreamSynchronize(first)));
    cudaGraph_t none = nullptr;
    std::printf("end: %s\n", cudaGetErrorName(cudaStreamEndCapture(first, &none)));
    std::printf("graph: %s, left over: %s\n", none ? "some" : "none",
                cudaGetErrorName(cudaGetLastError()));

    CHECK(cudaGraphExecDestroy(exec));
    CHECK(cudaGraphExecDestroy(builtExec));
    CHECK(cudaGraphDestroy(graph));
    CHECK(cudaGraphDestroy(other));
    CHECK(cudaGraphDestroy(built));
    CHECK(cudaStreamDestroy(first));
    CHECK(cudaStreamDestroy(second));
    return 0;
}
