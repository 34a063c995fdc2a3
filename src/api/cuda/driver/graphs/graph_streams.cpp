// SPDX-License-Identifier: Apache-2.0
// Graphs and streams: capture and launch. Compiled twice, see shell.h. Source: CUDA driver API,
// stream management and graph management.
#include "api/cuda/driver/graphs/graphs.h"

#include "base/threads/thread_object.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

CUresult beginCapture(const char* function, CUstream stream, CUstreamCaptureMode mode,
                      const std::function<std::shared_ptr<cpu::Graph>()>& graph,
                      const CUgraphNode* after, size_t count) {
    return guardedGraph(function, {Needs::kContext, stream}, [&] {
        require(unsigned(mode) <= CU_STREAM_CAPTURE_MODE_RELAXED, "unknown mode");
        std::shared_ptr<cpu::Graph> into = graph();
        cpu::streams().beginCapture(resolveStream(stream), cpu::Capture::Mode(mode), into,
                                    nodesOf(*into, after, count));
    });
}

CUresult captureInfo(CUstream stream, CUstreamCaptureStatus* status, cuuint64_t* id, CUgraph* graph,
                     const CUgraphNode** dependencies, const CUgraphEdgeData** edges,
                     size_t* count) {
    return guardedGraph("cuStreamGetCaptureInfo", {Needs::kContext, stream}, [&] {
        require(status, "status is null");
        if (edges)
            *edges = nullptr; // edges here have no data
        const cpu::CapturedMark state = cpu::streams().captureState(resolveStream(stream));
        if (!state.capture) {
            *status = CU_STREAM_CAPTURE_STATUS_NONE;
            return;
        }
        *status = state.capture->invalidated ? CU_STREAM_CAPTURE_STATUS_INVALIDATED
                                             : CU_STREAM_CAPTURE_STATUS_ACTIVE;
        if (state.capture->invalidated)
            return;
        if (id)
            *id = state.capture->id;
        if (graph)
            *graph = handleOf(state.graph);
        // Valid until the thread's next call.
        auto& tips = threadObject<std::vector<CUgraphNode>>();
        tips.clear();
        for (const cpu::GraphNode* tip : state.tips)
            tips.push_back(handleOf(tip));
        if (dependencies)
            *dependencies = tips.data();
        if (count)
            *count = tips.size();
    });
}

CUresult updateTips(CUstream stream, CUgraphNode* dependencies, const CUgraphEdgeData* edges,
                    size_t count, unsigned flags) {
    return guardedGraph("cuStreamUpdateCaptureDependencies", {Needs::kContext, stream}, [&] {
        require(flags <= CU_STREAM_SET_CAPTURE_DEPENDENCIES, "unknown flags");
        requirePlainEdges(edges, count);
        cpu::StreamPtr target = resolveStream(stream);
        const cpu::CapturedMark state = cpu::streams().captureState(target);
        if (!state.capture)
            refuse(CUDA_ERROR_ILLEGAL_STATE, "the stream does not capture");
        std::vector<cpu::GraphNode*> tips = nodesOf(*state.graph, dependencies, count);
        if (flags == CU_STREAM_ADD_CAPTURE_DEPENDENCIES)
            tips.insert(tips.end(), state.tips.begin(), state.tips.end());
        cpu::streams().setTips(target, std::move(tips));
    });
}

} // namespace

SUNSTONE_EXPORT CUresult cuStreamBeginCapture(CUstream stream, CUstreamCaptureMode mode) {
    return beginCapture(
        "cuStreamBeginCapture", stream, mode, [] { return std::make_shared<cpu::Graph>(); },
        nullptr, 0);
}
SUNSTONE_EXPORT CUresult cuStreamBeginCaptureToGraph(CUstream stream, CUgraph graph,
                                                     const CUgraphNode* dependencies,
                                                     const CUgraphEdgeData* edgeData, size_t count,
                                                     CUstreamCaptureMode mode) {
    return beginCapture(
        "cuStreamBeginCaptureToGraph", stream, mode,
        [&] {
            requirePlainEdges(edgeData, count);
            return graphOf(graph);
        },
        dependencies, count);
}
SUNSTONE_EXPORT CUresult cuStreamEndCapture(CUstream stream, CUgraph* graph) {
    return guardedGraph("cuStreamEndCapture", {Needs::kContext, stream}, [&] {
        require(graph, "graph is null");
        *graph = nullptr;
        *graph = handleOf(cpu::streams().endCapture(resolveStream(stream)));
    });
}
SUNSTONE_EXPORT CUresult cuStreamIsCapturing(CUstream stream, CUstreamCaptureStatus* status) {
    return guarded("cuStreamIsCapturing", {Needs::kContext, stream}, [&] {
        require(status, "status is null");
        const cpu::CapturedMark state = cpu::streams().captureState(resolveStream(stream));
        *status = !state.capture               ? CU_STREAM_CAPTURE_STATUS_NONE
                  : state.capture->invalidated ? CU_STREAM_CAPTURE_STATUS_INVALIDATED
                                               : CU_STREAM_CAPTURE_STATUS_ACTIVE;
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetCaptureInfo(CUstream stream, CUstreamCaptureStatus* status,
                                                cuuint64_t* id, CUgraph* graph,
                                                const CUgraphNode** dependencies,
                                                const CUgraphEdgeData** edgeData, size_t* count) {
    return captureInfo(stream, status, id, graph, dependencies, edgeData, count);
}
SUNSTONE_EXPORT CUresult cuStreamUpdateCaptureDependencies(CUstream stream,
                                                           CUgraphNode* dependencies,
                                                           const CUgraphEdgeData* edgeData,
                                                           size_t count, unsigned int flags) {
    return updateTips(stream, dependencies, edgeData, count, flags);
}

SUNSTONE_EXPORT CUresult cuGraphInstantiateWithParams(CUgraphExec* exec, CUgraph graph,
                                                      CUDA_GRAPH_INSTANTIATE_PARAMS* params) {
    return instantiateWith(exec, graph, params);
}
SUNSTONE_EXPORT CUresult cuGraphUpload(CUgraphExec exec, CUstream stream) {
    return guardedGraph("cuGraphUpload", {Needs::kQueue, stream}, [&] {
        execOf(exec); // host and device share memory: nothing to upload
        resolveStream(stream);
    });
}
SUNSTONE_EXPORT CUresult cuGraphLaunch(CUgraphExec exec, CUstream stream) {
    return guardedGraph("cuGraphLaunch", {Needs::kQueue, stream},
                        [&] { cpu::ExecutableGraph::launch(execOf(exec), resolveStream(stream)); });
}

// Forms of older versions.
#undef cuStreamBeginCapture
#undef cuStreamGetCaptureInfo
#undef cuStreamUpdateCaptureDependencies
#ifdef CUDA_API_PER_THREAD_DEFAULT_STREAM
#define SUNSTONE_FORM(name) name##_ptsz
#else
#define SUNSTONE_FORM(name) name
SUNSTONE_EXPORT CUresult cuThreadExchangeStreamCaptureMode(CUstreamCaptureMode* mode) {
    return guarded("cuThreadExchangeStreamCaptureMode", Needs::kNothing, [&] {
        require(mode && unsigned(*mode) <= CU_STREAM_CAPTURE_MODE_RELAXED, "mode null or unknown");
        *mode = CUstreamCaptureMode(
            cpu::Streams::exchangeThreadMode(cpu::Capture::Mode(unsigned(*mode))));
    });
}
#endif
SUNSTONE_EXPORT CUresult SUNSTONE_FORM(cuStreamBeginCapture)(CUstream stream) {
    return beginCapture(
        "cuStreamBeginCapture", stream, CU_STREAM_CAPTURE_MODE_GLOBAL,
        [] { return std::make_shared<cpu::Graph>(); }, nullptr, 0);
}
SUNSTONE_EXPORT CUresult SUNSTONE_FORM(cuStreamGetCaptureInfo)(CUstream stream,
                                                               CUstreamCaptureStatus* status,
                                                               cuuint64_t* id) {
    return captureInfo(stream, status, id, nullptr, nullptr, nullptr, nullptr);
}
SUNSTONE_EXPORT CUresult SUNSTONE_FORM(cuStreamGetCaptureInfo_v2)(CUstream stream,
                                                                  CUstreamCaptureStatus* status,
                                                                  cuuint64_t* id, CUgraph* graph,
                                                                  const CUgraphNode** dependencies,
                                                                  size_t* count) {
    return captureInfo(stream, status, id, graph, dependencies, nullptr, count);
}
SUNSTONE_EXPORT CUresult SUNSTONE_FORM(cuStreamUpdateCaptureDependencies)(CUstream stream,
                                                                          CUgraphNode* dependencies,
                                                                          size_t count,
                                                                          unsigned int flags) {
    return updateTips(stream, dependencies, nullptr, count, flags);
}
