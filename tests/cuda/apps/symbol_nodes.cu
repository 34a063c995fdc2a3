// SPDX-License-Identifier: Apache-2.0
// Nodes that copy to and from variables, attributes of kernel nodes, graphs as text, and typed
// forms of functions that toolkits declare in cuda_runtime.h.
#include <cuda_runtime.h>

#include "check.h"

#include <unistd.h>

#include <string>

__device__ int table[4];
__constant__ int scale[2] = {1, 1};

__global__ void scaleTable() {
    table[threadIdx.x] *= scale[threadIdx.x & 1];
}
__global__ void sumOfList(int* to) {
    for (int each : {1, 2, 3}) // needs <initializer_list>, which the program does not include
        *to += each;
}

static const int kFirst[] = {1, 2, 3, 4}, kSecond[] = {5, 6}, kScale[] = {10, 100},
                 kOther[] = {2, 3};

static void print(const char* what, const int* values) {
    std::printf("%s: %d %d %d %d\n", what, values[0], values[1], values[2], values[3]);
}

static void printText(cudaGraph_t graph) {
    char path[] = "/tmp/graph_XXXXXX";
    close(mkstemp(path));
    CHECK(cudaGraphDebugDotPrint(graph, path, cudaGraphDebugDotFlagsVerbose));
    std::string text(10000, 0);
    FILE* file = std::fopen(path, "r");
    text.resize(std::fread(&text[0], 1, text.size(), file));
    std::fclose(file);
    unlink(path);
    int edges = 0;
    for (size_t at = 0; (at = text.find("->", at)) != std::string::npos; ++at)
        ++edges;
    const bool hasKernel = text.find("scaleTable") != std::string::npos;
    std::printf("text: %s, %d edges, %s\n", text.substr(0, 7).c_str(), edges,
                hasKernel ? "kernel" : "no kernel");
    std::printf("no folder: %s\n",
                cudaGetErrorName(cudaGraphDebugDotPrint(graph, "/nonexistent/graph", 0)));
}

static void runGraph(cudaStream_t stream) {
    cudaGraph_t graph;
    cudaGraphNode_t fill, factors, kernel, read;
    int result[4] = {};
    CHECK(cudaGraphCreate(&graph, 0));
    CHECK(cudaGraphAddMemcpyNodeToSymbol(&fill, graph, nullptr, 0, table, kFirst, sizeof kFirst, 0,
                                         cudaMemcpyHostToDevice));
    CHECK(cudaGraphAddMemcpyNodeToSymbol(&factors, graph, &fill, 1, scale, kOther, sizeof kOther, 0,
                                         cudaMemcpyDefault));
    cudaKernelNodeParams params = {};
    params.func = (void*)scaleTable;
    params.gridDim = dim3(1);
    params.blockDim = dim3(4);
    CHECK(cudaGraphAddKernelNode(&kernel, graph, &factors, 1, &params));
    CHECK(cudaGraphAddMemcpyNodeFromSymbol(&read, graph, &kernel, 1, result, table, sizeof result,
                                           0, cudaMemcpyDeviceToHost));
    CHECK(cudaGraphMemcpyNodeSetParamsToSymbol(factors, scale, kScale, sizeof kScale, 0,
                                               cudaMemcpyHostToDevice));
    cudaGraphExec_t exec;
    CHECK(cudaGraphInstantiate(&exec, graph, 0));
    CHECK(cudaGraphLaunch(exec, stream));
    CHECK(cudaStreamSynchronize(stream));
    print("graph", result);
    CHECK(cudaGraphExecMemcpyNodeSetParamsToSymbol(exec, fill, table, kSecond, sizeof kSecond, 8,
                                                   cudaMemcpyHostToDevice));
    CHECK(cudaGraphLaunch(exec, stream));
    CHECK(cudaStreamSynchronize(stream));
    print("changed", result);
    int* beyond = result;
    std::printf("beyond the end: %s\n",
                cudaGetErrorName(cudaGraphAddMemcpyNodeFromSymbol(
                    &read, graph, &kernel, 1, beyond, table, 12, 8, cudaMemcpyDeviceToHost)));
    std::printf("direction: %s\n", cudaGetErrorName(cudaGraphMemcpyNodeSetParamsFromSymbol(
                                       read, beyond, table, 4, 0, cudaMemcpyHostToDevice)));

    printText(graph);
    cudaLaunchAttributeValue value = {};
    value.cooperative = 1;
    CHECK(cudaGraphKernelNodeSetAttribute(kernel, cudaLaunchAttributeCooperative, &value));
    cudaGraphNode_t second;
    CHECK(cudaGraphAddKernelNode(&second, graph, &kernel, 1, &params));
    CHECK(cudaGraphKernelNodeCopyAttributes(second, kernel));
    value = {};
    CHECK(cudaGraphKernelNodeGetAttribute(second, cudaLaunchAttributeCooperative, &value));
    std::printf("cooperative: %d\n", value.cooperative);
    CHECK(cudaGraphExecDestroy(exec));
    CHECK(cudaGraphDestroy(graph));
}

int main() {
    cudaStream_t stream;
    CHECK(cudaStreamCreate(&stream));
    runGraph(stream);
    cudaMemPool_t pool;
    CHECK(cudaDeviceGetDefaultMemPool(&pool, 0));
    int *sum, host = 0;
    CHECK(cudaMallocFromPoolAsync(&sum, sizeof *sum, pool, stream));
    CHECK(cudaMemsetAsync(sum, 0, sizeof *sum, stream));
    sumOfList<<<1, 1, 0, stream>>>(sum);
    CHECK(cudaMemcpyAsync(&host, sum, sizeof host, cudaMemcpyDeviceToHost, stream));
    CHECK(cudaFreeAsync(sum, stream));
    CHECK(cudaStreamSynchronize(stream));
    std::printf("sum: %d\n", host);
    const cudaChannelFormatDesc one = cudaCreateChannelDescHalf();
    const cudaChannelFormatDesc four = cudaCreateChannelDescHalf4();
    std::printf("half: %d %d %d, %d %d %d\n", one.x, one.w, one.f, four.x, four.w, four.f);
    return 0;
}
