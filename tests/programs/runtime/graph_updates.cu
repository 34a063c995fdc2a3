// SPDX-License-Identifier: Apache-2.0
// A solver's steps as a CUDA graph that is built by hand and changed between launches: parameters
// of kernels, sources of copies, values of sets, host functions; a captured part as a child. Events
// give times, and callbacks of streams count.
#include "device.h"

#include <atomic>
#include <cmath>
#include <vector>

__global__ void axpy(float a, const float* x, float* y, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        y[i] += a * x[i];
}
__global__ void power(float* y, int n, int exponent) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= n)
        return;
    float product = 1;
    for (int k = 0; k < exponent; ++k)
        product *= y[i];
    y[i] = product;
}
struct Affine {
    double scale;
    char padding[5];
    float offset;
};
__global__ void affine(float* y, int n, Affine map) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        y[i] = float(map.scale * y[i]) + map.offset;
}

static std::atomic<int> calls{0}, lastRound{-1};
static void CUDART_CB countCall(void* data) {
    calls += *static_cast<int*>(data);
}
static void CUDART_CB note(cudaStream_t, cudaError_t status, void* data) {
    lastRound = status == cudaSuccess ? int(reinterpret_cast<intptr_t>(data)) : -2;
}

int main() {
    constexpr int n = 1000, kRounds = 6;
    float *x, *y, *other, *result;
    CUDA(cudaMalloc(&x, n * 4));
    CUDA(cudaMalloc(&y, n * 4));
    CUDA(cudaMalloc(&other, n * 4));
    CUDA(cudaMallocHost(&result, n * 4));
    std::vector<float> host(n), second(n);
    for (int i = 0; i < n; ++i) {
        host[i] = 0.001f * i;
        second[i] = 1 - 0.002f * i;
    }
    CUDA(cudaMemcpy(x, host.data(), n * 4, cudaMemcpyHostToDevice));
    CUDA(cudaMemcpy(other, second.data(), n * 4, cudaMemcpyHostToDevice));
    cudaStream_t stream, side;
    CUDA(cudaStreamCreate(&stream));
    CUDA(cudaStreamCreate(&side));

    // Captured: y = affine(y), with a fork to a second stream that does nothing that matters.
    Affine map = {2, {}, 0.5f};
    cudaEvent_t forked, joined;
    CUDA(cudaEventCreateWithFlags(&forked, cudaEventDisableTiming));
    CUDA(cudaEventCreateWithFlags(&joined, cudaEventDisableTiming));
    CUDA(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal));
    affine<<<(n + 255) / 256, 256, 0, stream>>>(y, n, map);
    CUDA(cudaEventRecord(forked, stream));
    CUDA(cudaStreamWaitEvent(side, forked, 0));
    axpy<<<(n + 63) / 64, 64, 0, side>>>(0.25f, x, y, n);
    CUDA(cudaEventRecord(joined, side));
    CUDA(cudaStreamWaitEvent(stream, joined, 0));
    cudaGraph_t part;
    CUDA(cudaStreamEndCapture(stream, &part));

    // By hand: y = 0; y += a * x; y = y ^ e; part; result = y; count.
    cudaGraph_t graph;
    CUDA(cudaGraphCreate(&graph, 0));
    cudaGraphNode_t set, add, raise, child, copy, hostNode;
    cudaMemsetParams clear = {};
    clear.dst = y;
    clear.elementSize = 4;
    clear.width = n;
    clear.height = 1;
    CUDA(cudaGraphAddMemsetNode(&set, graph, nullptr, 0, &clear));
    float a = 1;
    int count = n, exponent = 2;
    const float* source = x;
    void* addArguments[] = {&a, &source, &y, &count};
    cudaKernelNodeParams adding = {};
    adding.func = reinterpret_cast<void*>(axpy);
    adding.gridDim = dim3((n + 127) / 128);
    adding.blockDim = dim3(128);
    adding.kernelParams = addArguments;
    CUDA(cudaGraphAddKernelNode(&add, graph, &set, 1, &adding));
    void* powerArguments[] = {&y, &count, &exponent};
    cudaKernelNodeParams raising = adding;
    raising.func = reinterpret_cast<void*>(power);
    raising.kernelParams = powerArguments;
    CUDA(cudaGraphAddKernelNode(&raise, graph, &add, 1, &raising));
    CUDA(cudaGraphAddChildGraphNode(&child, graph, &raise, 1, part));
    CUDA(cudaGraphAddMemcpyNode1D(&copy, graph, &child, 1, result, y, n * 4,
                                  cudaMemcpyDeviceToHost));
    int one = 1, ten = 10;
    cudaHostNodeParams counting = {countCall, &one};
    CUDA(cudaGraphAddHostNode(&hostNode, graph, &copy, 1, &counting));
    size_t nodes = 0, edges = 0;
    CUDA(cudaGraphGetNodes(graph, nullptr, &nodes));
    CUDA(cudaGraphGetEdges(graph, nullptr, nullptr, nullptr, &edges));
    cudaGraphExec_t exec;
    CUDA(cudaGraphInstantiateWithFlags(&exec, graph, 0));

    cudaEvent_t begin, end;
    CUDA(cudaEventCreate(&begin));
    CUDA(cudaEventCreate(&end));
    int wrong = nodes != 6 || edges != 5;
    for (int round = 0; round < kRounds; ++round) {
        a = 1 + 0.5f * round;
        exponent = 1 + round % 3;
        source = round % 2 ? other : x;
        adding.gridDim = dim3(4 + round);
        adding.blockDim = dim3(256);
        CUDA(cudaGraphExecKernelNodeSetParams(exec, add, &adding));
        CUDA(cudaGraphExecKernelNodeSetParams(exec, raise, &raising));
        union {
            float f;
            unsigned u;
        } fill = {0.125f * round};
        clear.value = fill.u;
        CUDA(cudaGraphExecMemsetNodeSetParams(exec, set, &clear));
        if (round == 3) {
            counting.userData = &ten;
            CUDA(cudaGraphExecHostNodeSetParams(exec, hostNode, &counting));
        }
        CUDA(cudaEventRecord(begin, stream));
        CUDA(cudaGraphLaunch(exec, stream));
        CUDA(cudaEventRecord(end, stream));
        CUDA(cudaStreamAddCallback(stream, note, reinterpret_cast<void*>(intptr_t(round)), 0));
        CUDA(cudaStreamSynchronize(stream));
        float milliseconds = -1;
        CUDA(cudaEventElapsedTime(&milliseconds, begin, end));
        wrong += milliseconds < 0 || lastRound != round;
        for (int i = 0; i < n; ++i) {
            const float base = fill.f + a * (round % 2 ? second[i] : host[i]);
            const float right = 2 * std::pow(base, float(exponent)) + 0.5f + 0.25f * host[i];
            wrong += std::fabs(result[i] - right) > 1e-3f * (1 + std::fabs(right));
        }
    }
    std::printf("%d wrong, %d calls\n", wrong, calls.load());
    CUDA(cudaGraphExecDestroy(exec));
    CUDA(cudaGraphDestroy(graph)); // until then its nodes name those of the executable graph
    CUDA(cudaGraphDestroy(part));
    return finish(wrong == 0 && calls == 3 + 30);
}
