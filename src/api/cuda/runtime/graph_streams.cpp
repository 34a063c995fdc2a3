// SPDX-License-Identifier: Apache-2.0
// Graphs and streams: capture and launch. Compiled twice, see runtime.h.
#include "api/cuda/runtime/graphs.h"

using namespace sunstone::cudart;

SUNSTONE_CUDART cudaError_t cudaStreamBeginCapture(cudaStream_t stream,
                                                   enum cudaStreamCaptureMode mode) {
    return graphCall([&](const Driver& d) { return d.cuStreamBeginCapture; }, streamOf(stream),
                     static_cast<CUstreamCaptureMode>(mode));
}
SUNSTONE_CUDART cudaError_t cudaStreamBeginCaptureToGraph(cudaStream_t stream, cudaGraph_t graph,
                                                          const cudaGraphNode_t* dependencies,
                                                          const cudaGraphEdgeData* edges,
                                                          size_t count,
                                                          enum cudaStreamCaptureMode mode) {
    return graphCall([&](const Driver& d) { return d.cuStreamBeginCaptureToGraph; },
                     streamOf(stream), graph, dependencies,
                     reinterpret_cast<const CUgraphEdgeData*>(edges), count,
                     static_cast<CUstreamCaptureMode>(mode));
}
SUNSTONE_CUDART cudaError_t cudaStreamEndCapture(cudaStream_t stream, cudaGraph_t* graph) {
    return graphCall([&](const Driver& d) { return d.cuStreamEndCapture; }, streamOf(stream),
                     graph);
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaStreamGetCaptureInfo,
                                              cudaStreamGetCaptureInfo_v3)(
    cudaStream_t stream, enum cudaStreamCaptureStatus* status, unsigned long long* id,
    cudaGraph_t* graph, const cudaGraphNode_t** dependencies, const cudaGraphEdgeData** edges,
    size_t* count) {
    return graphCall([&](const Driver& d) { return d.cuStreamGetCaptureInfo; }, streamOf(stream),
                     reinterpret_cast<CUstreamCaptureStatus*>(status),
                     reinterpret_cast<cuuint64_t*>(id), graph, dependencies,
                     reinterpret_cast<const CUgraphEdgeData**>(edges), count);
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaStreamUpdateCaptureDependencies,
                                              cudaStreamUpdateCaptureDependencies_v2)(
    cudaStream_t stream, cudaGraphNode_t* dependencies, const cudaGraphEdgeData* edges,
    size_t count, unsigned int flags) {
    return graphCall([&](const Driver& d) { return d.cuStreamUpdateCaptureDependencies; },
                     streamOf(stream), dependencies,
                     reinterpret_cast<const CUgraphEdgeData*>(edges), count, flags);
}
SUNSTONE_CUDART cudaError_t cudaGraphInstantiateWithParams(cudaGraphExec_t* exec, cudaGraph_t graph,
                                                           cudaGraphInstantiateParams* params) {
    return graphCall([&](const Driver& d) { return d.cuGraphInstantiateWithParams; }, exec, graph,
                     reinterpret_cast<CUDA_GRAPH_INSTANTIATE_PARAMS*>(params));
}
SUNSTONE_CUDART cudaError_t cudaGraphUpload(cudaGraphExec_t exec, cudaStream_t stream) {
    return graphCall([&](const Driver& d) { return d.cuGraphUpload; }, exec, streamOf(stream));
}
SUNSTONE_CUDART cudaError_t cudaGraphLaunch(cudaGraphExec_t exec, cudaStream_t stream) {
    return graphCall([&](const Driver& d) { return d.cuGraphLaunch; }, exec, streamOf(stream));
}
