// SPDX-License-Identifier: Apache-2.0
// Graphs and stream capture through the driver API: success, documented errors, null and garbage.
#include <cuda.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace {

template <class T>
T garbage() {
    return reinterpret_cast<T>(uintptr_t(0xdeadbeefdeadbee8));
}

void CUDA_CB increment(void* data) {
    ++*static_cast<std::atomic<int>*>(data);
}

class Graphs : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&second, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAlloc(&memory, 4096), CUDA_SUCCESS);
        ASSERT_EQ(cuMemsetD8(memory, 0, 4096), CUDA_SUCCESS);
        params.fn = increment;
        params.userData = &calls;
    }
    void TearDown() override {
        EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
        EXPECT_EQ(cuStreamDestroy(second), CUDA_SUCCESS);
        EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    CUstreamCaptureStatus status(CUstream of) {
        CUstreamCaptureStatus status = CU_STREAM_CAPTURE_STATUS_NONE;
        EXPECT_EQ(cuStreamIsCapturing(of, &status), CUDA_SUCCESS);
        return status;
    }
    // Ends a capture on `stream` that must be invalid by now.
    void endInvalid() {
        CUgraph graph = garbage<CUgraph>();
        EXPECT_EQ(status(stream), CU_STREAM_CAPTURE_STATUS_INVALIDATED);
        EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_ERROR_STREAM_CAPTURE_INVALIDATED);
        EXPECT_EQ(graph, nullptr);
        EXPECT_EQ(status(stream), CU_STREAM_CAPTURE_STATUS_NONE);
    }
    uint32_t word(size_t i) {
        uint32_t value = 0;
        EXPECT_EQ(cuMemcpyDtoH(&value, memory + 4 * i, 4), CUDA_SUCCESS);
        return value;
    }

    CUcontext context = nullptr;
    CUstream stream = nullptr, second = nullptr;
    CUdeviceptr memory = 0;
    std::atomic<int> calls{0};
    CUDA_HOST_NODE_PARAMS params = {};
};

TEST_F(Graphs, CaptureRunsOnlyWhenLaunched) {
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    EXPECT_EQ(status(stream), CU_STREAM_CAPTURE_STATUS_ACTIVE);
    EXPECT_EQ(status(second), CU_STREAM_CAPTURE_STATUS_NONE);
    EXPECT_EQ(cuMemsetD32Async(memory, 7, 16, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoDAsync(memory + 64, memory, 64, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(stream, increment, &calls), CUDA_SUCCESS);
    CUstreamCaptureStatus now;
    cuuint64_t id = 0;
    CUgraph inProgress = nullptr;
    const CUgraphNode* tips = nullptr;
    size_t count = 0;
    EXPECT_EQ(cuStreamGetCaptureInfo(stream, &now, &id, &inProgress, &tips, nullptr, &count),
              CUDA_SUCCESS);
    EXPECT_EQ(now, CU_STREAM_CAPTURE_STATUS_ACTIVE);
    EXPECT_NE(id, 0u);
    ASSERT_EQ(count, 1u);
    CUgraphNodeType type;
    EXPECT_EQ(cuGraphNodeGetType(tips[0], &type), CUDA_SUCCESS);
    EXPECT_EQ(type, CU_GRAPH_NODE_TYPE_HOST);
    CUgraph graph = nullptr;
    ASSERT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
    EXPECT_EQ(graph, inProgress);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(calls, 0);
    EXPECT_EQ(word(0), 0u);
    CUgraphExec exec = nullptr;
    ASSERT_EQ(cuGraphInstantiate(&exec, graph, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS); // the executable graph needs it no longer
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(cuGraphLaunch(exec, i % 2 ? stream : second), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(calls, 3);
    EXPECT_EQ(word(31), 7u);
    EXPECT_EQ(word(32), 0u);
    EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphLaunch(exec, stream), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_ERROR_INVALID_VALUE);
}

TEST_F(Graphs, WhatCapturesForbid) {
    const auto begin = [&](CUstreamCaptureMode mode = CU_STREAM_CAPTURE_MODE_GLOBAL) {
        ASSERT_EQ(cuStreamBeginCapture(stream, mode), CUDA_SUCCESS);
    };
    begin();
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_ERROR_STREAM_CAPTURE_UNSUPPORTED);
    EXPECT_EQ(cuLaunchHostFunc(stream, increment, &calls), CUDA_ERROR_STREAM_CAPTURE_INVALIDATED);
    endInvalid();
    begin();
    EXPECT_EQ(cuStreamQuery(stream), CUDA_ERROR_STREAM_CAPTURE_UNSUPPORTED);
    endInvalid();
    begin();
    CUdeviceptr more = 0;
    EXPECT_EQ(cuMemAlloc(&more, 64), CUDA_ERROR_STREAM_CAPTURE_UNSUPPORTED);
    endInvalid();
    begin(CU_STREAM_CAPTURE_MODE_RELAXED);
    EXPECT_EQ(cuMemAlloc(&more, 64), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(more), CUDA_SUCCESS);
    CUgraph graph = nullptr;
    EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);

    // A global capture also restrains other threads, unless they opt out.
    begin();
    std::thread([&] {
        CUdeviceptr other = 0;
        EXPECT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        CUstreamCaptureMode mode = CU_STREAM_CAPTURE_MODE_RELAXED;
        EXPECT_EQ(cuThreadExchangeStreamCaptureMode(&mode), CUDA_SUCCESS);
        EXPECT_EQ(mode, CU_STREAM_CAPTURE_MODE_GLOBAL);
        EXPECT_EQ(cuMemAlloc(&other, 64), CUDA_SUCCESS);
        EXPECT_EQ(cuMemFreeAsync(other, second), CUDA_SUCCESS);
        EXPECT_EQ(cuThreadExchangeStreamCaptureMode(&mode), CUDA_SUCCESS);
        EXPECT_EQ(cuMemAlloc(&other, 64), CUDA_ERROR_STREAM_CAPTURE_UNSUPPORTED);
    }).join();
    endInvalid();

    begin();
    std::thread([&] {
        EXPECT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        CUgraph graph = nullptr;
        EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_ERROR_STREAM_CAPTURE_WRONG_THREAD);
    }).join();
    EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);

    EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_ERROR_ILLEGAL_STATE);
    EXPECT_EQ(cuStreamBeginCapture(nullptr, CU_STREAM_CAPTURE_MODE_GLOBAL),
              CUDA_ERROR_STREAM_CAPTURE_UNSUPPORTED);
    EXPECT_EQ(cuStreamBeginCapture(stream, CUstreamCaptureMode(7)), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamBeginCapture(garbage<CUstream>(), CU_STREAM_CAPTURE_MODE_GLOBAL),
              CUDA_ERROR_INVALID_HANDLE);
    begin();
    EXPECT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL),
              CUDA_ERROR_ILLEGAL_STATE);
    EXPECT_EQ(cuStreamEndCapture(stream, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);
}

TEST_F(Graphs, LegacyStreamAndBlockingCapture) {
    CUstream blocking = nullptr;
    ASSERT_EQ(cuStreamCreate(&blocking, CU_STREAM_DEFAULT), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamBeginCapture(blocking, CU_STREAM_CAPTURE_MODE_RELAXED), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD8Async(memory, 1, 16, nullptr), CUDA_ERROR_STREAM_CAPTURE_IMPLICIT);
    EXPECT_EQ(status(blocking), CU_STREAM_CAPTURE_STATUS_INVALIDATED);
    CUgraph graph = nullptr;
    EXPECT_EQ(cuStreamEndCapture(blocking, &graph), CUDA_ERROR_STREAM_CAPTURE_INVALIDATED);
    // Destroying a stream ends its capture.
    ASSERT_EQ(cuStreamBeginCapture(blocking, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamDestroy(blocking), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(nullptr), CUDA_SUCCESS);
    CUdeviceptr more = 0;
    EXPECT_EQ(cuMemAlloc(&more, 64), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(more), CUDA_SUCCESS);
}

TEST_F(Graphs, EventsForkAndJoin) {
    CUevent event = nullptr, outside = nullptr;
    ASSERT_EQ(cuEventCreate(&event, CU_EVENT_DEFAULT), CUDA_SUCCESS);
    ASSERT_EQ(cuEventCreate(&outside, CU_EVENT_DEFAULT), CUDA_SUCCESS);
    ASSERT_EQ(cuEventRecord(outside, second), CUDA_SUCCESS);
    CUgraph graph = nullptr;

    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(stream, increment, &calls), CUDA_SUCCESS);
    EXPECT_EQ(cuEventRecord(event, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamWaitEvent(second, event, 0), CUDA_SUCCESS);
    EXPECT_EQ(status(second), CU_STREAM_CAPTURE_STATUS_ACTIVE);
    EXPECT_EQ(cuLaunchHostFunc(second, increment, &calls), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamEndCapture(second, &graph), CUDA_ERROR_STREAM_CAPTURE_UNMATCHED);
    endInvalid();

    // Not joined again.
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    EXPECT_EQ(cuEventRecord(event, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamWaitEvent(second, event, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(second, increment, &calls), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_ERROR_STREAM_CAPTURE_UNJOINED);
    EXPECT_EQ(status(second), CU_STREAM_CAPTURE_STATUS_NONE);

    // The event has no time.
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    EXPECT_EQ(cuEventRecord(event, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuEventQuery(event), CUDA_ERROR_CAPTURED_EVENT);
    endInvalid();
    EXPECT_EQ(cuEventSynchronize(event), CUDA_ERROR_CAPTURED_EVENT);
    EXPECT_EQ(cuStreamWaitEvent(second, event, 0), CUDA_ERROR_CAPTURED_EVENT);

    // Work outside of the capture must stay outside.
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamWaitEvent(stream, outside, 0), CUDA_ERROR_STREAM_CAPTURE_ISOLATION);
    endInvalid();

    // Two captures stay two.
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_RELAXED), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamBeginCapture(second, CU_STREAM_CAPTURE_MODE_RELAXED), CUDA_SUCCESS);
    EXPECT_EQ(cuEventRecord(event, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamWaitEvent(second, event, 0), CUDA_ERROR_STREAM_CAPTURE_MERGE);
    EXPECT_EQ(cuStreamEndCapture(second, &graph), CUDA_ERROR_STREAM_CAPTURE_INVALIDATED);
    endInvalid();

    // External events are nodes; a launch records them.
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamWaitEvent(stream, outside, CU_EVENT_WAIT_EXTERNAL), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(stream, increment, &calls), CUDA_SUCCESS);
    EXPECT_EQ(cuEventRecordWithFlags(event, stream, CU_EVENT_RECORD_EXTERNAL), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
    CUgraphExec exec = nullptr;
    ASSERT_EQ(cuGraphInstantiate(&exec, graph, 0), CUDA_SUCCESS);
    calls = 0;
    EXPECT_EQ(cuGraphLaunch(exec, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuEventSynchronize(event), CUDA_SUCCESS);
    EXPECT_EQ(calls, 1);
    EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);
    EXPECT_EQ(cuEventDestroy(event), CUDA_SUCCESS);
    EXPECT_EQ(cuEventDestroy(outside), CUDA_SUCCESS);
}

TEST_F(Graphs, BuiltByHand) {
    CUgraph graph = nullptr;
    EXPECT_EQ(cuGraphCreate(nullptr, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphCreate(&graph, 1), CUDA_ERROR_INVALID_VALUE);
    ASSERT_EQ(cuGraphCreate(&graph, 0), CUDA_SUCCESS);
    CUDA_MEMSET_NODE_PARAMS set = {memory, 0, 5, 4, 8, 1};
    CUgraphNode first = nullptr, copyNode = nullptr, host = nullptr, empty = nullptr;
    ASSERT_EQ(cuGraphAddMemsetNode(&first, graph, nullptr, 0, &set, context), CUDA_SUCCESS);
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.srcDevice = memory;
    copy.dstDevice = memory + 1024;
    copy.WidthInBytes = 32;
    copy.Height = copy.Depth = 1;
    ASSERT_EQ(cuGraphAddMemcpyNode(&copyNode, graph, &first, 1, &copy, context), CUDA_SUCCESS);
    ASSERT_EQ(cuGraphAddHostNode(&host, graph, &copyNode, 1, &params), CUDA_SUCCESS);
    ASSERT_EQ(cuGraphAddEmptyNode(&empty, graph, nullptr, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphAddDependencies(graph, &host, &empty, nullptr, 1), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphAddDependencies(graph, &host, &empty, nullptr, 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphAddDependencies(graph, &empty, &first, nullptr, 1), CUDA_ERROR_INVALID_VALUE);
    size_t count = 0;
    EXPECT_EQ(cuGraphGetEdges(graph, nullptr, nullptr, nullptr, &count), CUDA_SUCCESS);
    EXPECT_EQ(count, 3u);
    CUgraphNode nodes[8] = {};
    count = 8;
    EXPECT_EQ(cuGraphGetNodes(graph, nodes, &count), CUDA_SUCCESS);
    EXPECT_EQ(count, 4u);
    EXPECT_EQ(nodes[0], first);
    EXPECT_EQ(nodes[4], nullptr);
    count = 8;
    EXPECT_EQ(cuGraphNodeGetDependencies(host, nodes, nullptr, &count), CUDA_SUCCESS);
    ASSERT_EQ(count, 1u);
    EXPECT_EQ(nodes[0], copyNode);
    count = 8;
    EXPECT_EQ(cuGraphNodeGetDependentNodes(first, nodes, nullptr, &count), CUDA_SUCCESS);
    ASSERT_EQ(count, 1u);
    EXPECT_EQ(nodes[0], copyNode);

    CUgraph outer = nullptr;
    CUgraphNode child = nullptr;
    ASSERT_EQ(cuGraphCreate(&outer, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuGraphAddChildGraphNode(&child, outer, nullptr, 0, graph), CUDA_SUCCESS);
    CUgraphExec exec = nullptr;
    CUDA_GRAPH_INSTANTIATE_PARAMS options = {};
    ASSERT_EQ(cuGraphInstantiateWithParams(&exec, outer, &options), CUDA_SUCCESS);
    EXPECT_EQ(options.result_out, CUDA_GRAPH_INSTANTIATE_SUCCESS);
    EXPECT_EQ(cuGraphUpload(exec, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphLaunch(exec, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(word(256 + 7), 5u);
    EXPECT_EQ(calls, 1);

    // Nodes of the outer graph's copy of the child can be changed and disabled.
    CUgraph inner = nullptr;
    ASSERT_EQ(cuGraphChildGraphNodeGetGraph(child, &inner), CUDA_SUCCESS);
    count = 8;
    ASSERT_EQ(cuGraphGetNodes(inner, nodes, &count), CUDA_SUCCESS);
    set.value = 9;
    EXPECT_EQ(cuGraphExecMemsetNodeSetParams(exec, nodes[0], &set, context), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphExecMemsetNodeSetParams(exec, nodes[1], &set, context),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphNodeSetEnabled(exec, nodes[2], 0), CUDA_SUCCESS);
    unsigned enabled = 1;
    EXPECT_EQ(cuGraphNodeGetEnabled(exec, nodes[2], &enabled), CUDA_SUCCESS);
    EXPECT_EQ(enabled, 0u);
    EXPECT_EQ(cuGraphLaunch(exec, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(word(256 + 7), 9u);
    EXPECT_EQ(calls, 1);

    // An update with another shape is refused.
    CUgraphExecUpdateResultInfo info = {};
    EXPECT_EQ(cuGraphExecUpdate(exec, graph, &info), CUDA_ERROR_GRAPH_EXEC_UPDATE_FAILURE);
    EXPECT_EQ(info.result, CU_GRAPH_EXEC_UPDATE_ERROR_TOPOLOGY_CHANGED);
    EXPECT_EQ(cuGraphExecUpdate(exec, outer, &info), CUDA_SUCCESS);

    CUgraph clone = nullptr;
    CUgraphNode twin = nullptr;
    ASSERT_EQ(cuGraphClone(&clone, graph), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphNodeFindInClone(&twin, first, clone), CUDA_SUCCESS);
    CUDA_MEMSET_NODE_PARAMS read = {};
    EXPECT_EQ(cuGraphMemsetNodeGetParams(twin, &read), CUDA_SUCCESS);
    EXPECT_EQ(read.value, 5u);
    EXPECT_EQ(cuGraphNodeFindInClone(&twin, child, clone), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphDestroyNode(first), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroyNode(first), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphGetRootNodes(graph, nullptr, &count), CUDA_SUCCESS);
    EXPECT_EQ(count, 1u);
    EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
    for (CUgraph each : {graph, outer, clone})
        EXPECT_EQ(cuGraphDestroy(each), CUDA_SUCCESS);
}

TEST_F(Graphs, MemoryOfACapture) {
    CUdeviceptr scratch = 0;
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAllocAsync(&scratch, 256, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD32Async(scratch, 3, 64, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoDAsync(memory, scratch, 256, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFreeAsync(scratch, stream), CUDA_SUCCESS);
    CUevent event = nullptr; // outlives the graph
    ASSERT_EQ(cuEventCreate(&event, CU_EVENT_DISABLE_TIMING), CUDA_SUCCESS);
    EXPECT_EQ(cuEventRecord(event, stream), CUDA_SUCCESS);
    CUgraph graph = nullptr;
    ASSERT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
    CUgraphExec exec = nullptr;
    ASSERT_EQ(cuGraphInstantiate(&exec, graph, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(cuGraphLaunch(exec, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(word(63), 3u);
    EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD8(scratch, 0, 1), CUDA_ERROR_INVALID_VALUE); // destroyed with its graph
    EXPECT_EQ(cuEventDestroy(event), CUDA_SUCCESS);
}

// Failing device code in a graph breaks its context; the executable graph can still be destroyed,
// and graphs created after a reset run.
TEST_F(Graphs, Faults) {
    const char* const text = R"(.version 7.0
.target sm_60
.address_size 64
.visible .entry stop(.param .u64 word)
{
    .reg .pred %p;
    .reg .b32 %r<2>;
    .reg .b64 %rd;
    ld.param.u64 %rd, [word];
    ld.global.u32 %r0, [%rd];
    setp.eq.u32 %p, %r0, 1;
    @%p trap;
    st.global.u32 [%rd+4], 8;
    ret;
}
)";
    for (const bool fails : {true, false}) {
        CUmodule module = nullptr;
        CUfunction stop = nullptr;
        ASSERT_EQ(cuModuleLoadData(&module, text), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleGetFunction(&stop, module, "stop"), CUDA_SUCCESS);
        void* arguments[] = {&memory};
        CUDA_KERNEL_NODE_PARAMS kernel = {stop, 1, 1,         1,       1,       1,
                                          1,    0, arguments, nullptr, nullptr, nullptr};
        CUgraph graph = nullptr;
        CUgraphNode node = nullptr;
        CUgraphExec exec = nullptr;
        ASSERT_EQ(cuGraphCreate(&graph, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuGraphAddKernelNode(&node, graph, nullptr, 0, &kernel), CUDA_SUCCESS);
        CUDA_KERNEL_NODE_PARAMS read = {};
        EXPECT_EQ(cuGraphKernelNodeGetParams(node, &read), CUDA_SUCCESS);
        EXPECT_EQ(read.func, stop);
        EXPECT_EQ(*static_cast<CUdeviceptr*>(read.kernelParams[0]), memory);
        ASSERT_EQ(cuGraphInstantiate(&exec, graph, 0), CUDA_SUCCESS);
        EXPECT_EQ(cuMemsetD32(memory, fails, 1), CUDA_SUCCESS);
        EXPECT_EQ(cuGraphLaunch(exec, stream), CUDA_SUCCESS);
        if (!fails) {
            EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
            EXPECT_EQ(word(1), 8u);
        } else {
            EXPECT_EQ(cuStreamSynchronize(stream), CUDA_ERROR_LAUNCH_FAILED);
            EXPECT_EQ(cuGraphLaunch(exec, stream), CUDA_ERROR_LAUNCH_FAILED);
            ASSERT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
            ASSERT_EQ(cuDevicePrimaryCtxReset(0), CUDA_SUCCESS);
            SetUp();
        }
        EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
        EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);
        EXPECT_EQ(cuModuleUnload(module), fails ? CUDA_ERROR_INVALID_HANDLE : CUDA_SUCCESS);
    }
}

TEST_F(Graphs, NullAndGarbage) {
    CUgraph graph = nullptr;
    CUgraphNode node = nullptr;
    CUgraphExec exec = nullptr;
    size_t count = 0;
    ASSERT_EQ(cuGraphCreate(&graph, 0), CUDA_SUCCESS);
    const auto bad = CUDA_ERROR_INVALID_VALUE;
    for (CUgraph wrong : {CUgraph(nullptr), garbage<CUgraph>()}) {
        EXPECT_EQ(cuGraphDestroy(wrong), bad);
        EXPECT_EQ(cuGraphClone(&graph, wrong), bad);
        EXPECT_EQ(cuGraphAddEmptyNode(&node, wrong, nullptr, 0), bad);
        EXPECT_EQ(cuGraphGetNodes(wrong, nullptr, &count), bad);
        EXPECT_EQ(cuGraphGetEdges(wrong, nullptr, nullptr, nullptr, &count), bad);
        EXPECT_EQ(cuGraphInstantiate(&exec, wrong, 0), bad);
        EXPECT_EQ(cuGraphAddChildGraphNode(&node, graph, nullptr, 0, wrong), bad);
    }
    for (CUgraphNode wrong : {CUgraphNode(nullptr), garbage<CUgraphNode>()}) {
        CUgraphNodeType type;
        EXPECT_EQ(cuGraphNodeGetType(wrong, &type), bad);
        EXPECT_EQ(cuGraphDestroyNode(wrong), bad);
        EXPECT_EQ(cuGraphAddEmptyNode(&node, graph, &wrong, 1), bad);
        EXPECT_EQ(cuGraphNodeGetDependencies(wrong, nullptr, nullptr, &count), bad);
        EXPECT_EQ(cuGraphAddDependencies(graph, &wrong, &wrong, nullptr, 1), bad);
        EXPECT_EQ(cuGraphHostNodeSetParams(wrong, &params), bad);
    }
    EXPECT_EQ(cuGraphAddEmptyNode(&node, graph, nullptr, 1), bad);
    EXPECT_EQ(cuGraphAddEmptyNode(nullptr, graph, nullptr, 0), bad);
    EXPECT_EQ(cuGraphAddHostNode(&node, graph, nullptr, 0, nullptr), bad);
    EXPECT_EQ(cuGraphAddKernelNode(&node, graph, nullptr, 0, nullptr), bad);
    CUDA_KERNEL_NODE_PARAMS kernel = {};
    EXPECT_EQ(cuGraphAddKernelNode(&node, graph, nullptr, 0, &kernel), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuGraphAddMemcpyNode(&node, graph, nullptr, 0, nullptr, context), bad);
    CUDA_MEMSET_NODE_PARAMS set = {memory, 0, 0, 3, 8, 1};
    EXPECT_EQ(cuGraphAddMemsetNode(&node, graph, nullptr, 0, &set, context), bad);
    set.elementSize = 4;
    set.width = 4096;
    EXPECT_EQ(cuGraphAddMemsetNode(&node, graph, nullptr, 0, &set, context), bad);
    set.width = 1;
    EXPECT_EQ(cuGraphAddMemsetNode(&node, graph, nullptr, 0, &set, garbage<CUcontext>()),
              CUDA_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(cuGraphAddEventRecordNode(&node, graph, nullptr, 0, garbage<CUevent>()),
              CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuGraphGetNodes(graph, nullptr, nullptr), bad);
    EXPECT_EQ(cuGraphInstantiate(nullptr, graph, 0), bad);
    EXPECT_EQ(cuGraphInstantiate(&exec, graph, 1 << 20), bad);
    EXPECT_EQ(cuGraphInstantiate(&exec, graph, CUDA_GRAPH_INSTANTIATE_FLAG_DEVICE_LAUNCH),
              CUDA_ERROR_NOT_SUPPORTED);
    EXPECT_EQ(cuGraphLaunch(nullptr, stream), bad);
    EXPECT_EQ(cuGraphExecUpdate(garbage<CUgraphExec>(), graph, nullptr), bad);
    EXPECT_EQ(cuStreamIsCapturing(stream, nullptr), bad);
    EXPECT_EQ(cuThreadExchangeStreamCaptureMode(nullptr), bad);
    EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);
}

} // namespace
