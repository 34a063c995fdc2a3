// SPDX-License-Identifier: Apache-2.0
// The API with a CUDA driver library: the CUDA context of a device context, device memory, and the
// order of launches and builds on streams. This is a separate program, because the other tests must
// not load a CUDA library.
#include "device/launch.h"
#include "device_memory.h"
#include "rig.h"
#include "scene.h"

#include <atomic>
#include <chrono>
#include <thread>

namespace tests::api {
namespace {

// Keeps a stream busy until it is released.
struct Gate {
    std::atomic<bool> open{false};
    std::atomic<bool> reached{false};
    static void wait(void* self) {
        auto* gate = static_cast<Gate*>(self);
        gate->reached = true;
        while (!gate->open)
            std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
};

class Cuda : public testing::Test {
protected:
    static void SetUpTestSuite() {
        loadLibrary();
        ASSERT_EQ(CUDA_SUCCESS, cuInit(0));
    }
    void SetUp() override {
        ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(nullptr));
        ASSERT_EQ(CUDA_SUCCESS, cuDevicePrimaryCtxRetain(&primary_, 0));
        options_.logCallbackFunction = LogRecord::callback;
        options_.logCallbackData = &log_;
        options_.logCallbackLevel = 4;
    }
    void TearDown() override {
        cuCtxSetCurrent(nullptr);
        EXPECT_EQ(CUDA_SUCCESS, cuDevicePrimaryCtxRelease(0));
    }
    OptixResult create(CUcontext from) {
        context_ = reinterpret_cast<OptixDeviceContext>(1);
        return optixDeviceContextCreate(from, &options_, &context_);
    }

    CUcontext primary_ = nullptr;
    LogRecord log_;
    OptixDeviceContextOptions options_{};
    OptixDeviceContext context_ = nullptr;
};

TEST_F(Cuda, WithoutACurrentContext) {
    EXPECT_EQ(OPTIX_ERROR_CUDA_NOT_INITIALIZED, create(nullptr));
    EXPECT_EQ(nullptr, context_);
    EXPECT_TRUE(log_.hasError("optixDeviceContextCreate", "current")) << log_.all();
}

TEST_F(Cuda, CurrentAndGivenContexts) {
    ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
    ASSERT_OK(create(nullptr));
    EXPECT_OK(optixDeviceContextDestroy(context_));
    CUcontext current = nullptr;
    EXPECT_EQ(CUDA_SUCCESS, cuCtxGetCurrent(&current));
    EXPECT_EQ(primary_, current) << "the current context is left as it was";
    ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(nullptr));
    ASSERT_OK(create(primary_)); // need not be current
    EXPECT_OK(optixDeviceContextDestroy(context_));
}

TEST_F(Cuda, CurrentIsAMatterOfThreads) {
    ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
    std::thread([&] { EXPECT_EQ(OPTIX_ERROR_CUDA_NOT_INITIALIZED, create(nullptr)); }).join();
    EXPECT_OK(create(nullptr));
    EXPECT_OK(optixDeviceContextDestroy(context_));
}

TEST_F(Cuda, ContextsThatAreNone) {
    ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
    for (void* garbage : garbageHandles()) {
        EXPECT_EQ(OPTIX_ERROR_CUDA_ERROR, create(static_cast<CUcontext>(garbage)));
        EXPECT_EQ(nullptr, context_);
    }
    CUcontext own = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, cuCtxCreate_v2(&own, 0, 0));
    ASSERT_OK(create(own));
    EXPECT_OK(optixDeviceContextDestroy(context_));
    ASSERT_EQ(CUDA_SUCCESS, cuCtxDestroy(own));
    EXPECT_EQ(OPTIX_ERROR_CUDA_ERROR, create(own)) << "a destroyed context";
}

// ---- Streams
// -------------------------------------------------------------------------------------

class Streams : public Cuda {
protected:
    void SetUp() override {
        Cuda::SetUp();
        ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
        ASSERT_OK(create(nullptr));
        for (CUstream& stream : streams_)
            ASSERT_EQ(CUDA_SUCCESS, cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
        rig_ = std::make_unique<Rig>(context_, log_, compiledPtx("launch", "clang"),
                                     compileOptions(1));
        rig_->raygenRecord(rig_->raygen("__raygen__trace"), 9u);
        rig_->missRecord(rig_->miss("__miss__value"), 11u);
        rig_->hitRecord(rig_->hit("__closesthit__value"), 22u);
        rig_->link();
        sbt_ = rig_->table();
        ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&seen_, kIndices * sizeof(LaunchSeen)));
        ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&params_, sizeof(LaunchParams)));
        ASSERT_EQ(CUDA_SUCCESS, cuMemsetD8(seen_, 0, kIndices * sizeof(LaunchSeen)));
        // Pinned memory, because copies from pageable memory may wait for the stream.
        ASSERT_EQ(CUDA_SUCCESS, cuMemAllocHost(&pinned_, 4096));
        values_ = new (pinned_) LaunchParams{};
        values_->seen = reinterpret_cast<LaunchSeen*>(seen_);
        waitForDefaultStream();
    }
    void TearDown() override {
        rig_.reset();
        if (context_)
            EXPECT_OK(optixDeviceContextDestroy(context_));
        cuMemFree(seen_);
        cuMemFree(params_);
        cuMemFreeHost(pinned_);
        for (CUstream stream : streams_)
            EXPECT_EQ(CUDA_SUCCESS, cuStreamDestroy(stream));
        Cuda::TearDown();
    }
    // Non-blocking streams could overtake its work (for example cuMemsetD8, which may return before
    // it is done).
    static void waitForDefaultStream() {
        ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(CU_STREAM_LEGACY));
    }
    OptixResult launch(CUstream stream, size_t paramsSize = sizeof(LaunchParams)) {
        return optixLaunch(rig_->pipeline(), stream, params_, paramsSize, &sbt_, kIndices, 1, 1);
    }
    LaunchSeen first() {
        LaunchSeen seen{};
        EXPECT_EQ(CUDA_SUCCESS, cuMemcpyDtoH(&seen, seen_, sizeof(seen)));
        return seen;
    }

    static constexpr unsigned kIndices = 1000;
    CUstream streams_[2] = {};
    std::unique_ptr<Rig> rig_;
    CUdeviceptr seen_ = 0, params_ = 0;
    void* pinned_ = nullptr;
    LaunchParams* values_ = nullptr; // at the start of it
    OptixShaderBindingTable sbt_{};
};

TEST_F(Streams, LaunchesReturnBeforeTheyRun) {
    Gate gate;
    ASSERT_EQ(CUDA_SUCCESS, cuLaunchHostFunc(streams_[0], Gate::wait, &gate));
    // Parameters arrive in stream order, after the call that reads them was made.
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoDAsync(params_, values_, sizeof(*values_), streams_[0]));
    ASSERT_OK(launch(streams_[0]));
    EXPECT_EQ(CUDA_ERROR_NOT_READY, cuStreamQuery(streams_[0]));
    gate.open = true;
    ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(streams_[0]));
    EXPECT_EQ(1u, first().runs);
    EXPECT_EQ(11u, first().record);
}

TEST_F(Streams, StreamsDoNotWaitForEachOther) {
    Gate gate;
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    ASSERT_EQ(CUDA_SUCCESS, cuLaunchHostFunc(streams_[0], Gate::wait, &gate));
    ASSERT_OK(launch(streams_[1]));
    EXPECT_EQ(CUDA_SUCCESS, cuStreamSynchronize(streams_[1])); // would hang otherwise
    gate.open = true;
    ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(streams_[0]));
}

// Launches of two pipelines from four threads, each with its own stream, parameters and results;
// more launches run at once than there are processors.
TEST_F(Streams, ManyStreamsAndPipelines) {
    Rig other(context_, log_, compiledPtx("launch", "clang"), compileOptions(1));
    other.raygenRecord(other.raygen("__raygen__other"), 1u);
    other.link();
    const OptixShaderBindingTable otherTable = other.table();
    constexpr unsigned kThreads = 4, kLaunches = 60;
    std::vector<std::thread> threads;
    std::vector<LaunchSeen> results(kThreads);
    for (unsigned i = 0; i < kThreads; ++i)
        threads.emplace_back([&, i] {
            ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
            CUstream stream = nullptr;
            CUdeviceptr seen = 0, params = 0;
            ASSERT_EQ(CUDA_SUCCESS, cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
            ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&seen, kIndices * sizeof(LaunchSeen)));
            ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&params, sizeof(LaunchParams)));
            ASSERT_EQ(CUDA_SUCCESS, cuMemsetD8(seen, 0, kIndices * sizeof(LaunchSeen)));
            LaunchParams mine = *values_;
            mine.seen = reinterpret_cast<LaunchSeen*>(seen);
            ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params, &mine, sizeof(mine)));
            waitForDefaultStream();
            for (unsigned k = 0; k < kLaunches; ++k) {
                EXPECT_EQ(OPTIX_SUCCESS, optixLaunch(rig_->pipeline(), stream, params,
                                                     sizeof(LaunchParams), &sbt_, kIndices, 1, 1));
                EXPECT_EQ(OPTIX_SUCCESS,
                          optixLaunch(other.pipeline(), stream, params, sizeof(LaunchParams),
                                      &otherTable, kIndices, 1, 1));
            }
            EXPECT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
            std::vector<LaunchSeen> all(kIndices);
            EXPECT_EQ(CUDA_SUCCESS, cuMemcpyDtoH(all.data(), seen, kIndices * sizeof(LaunchSeen)));
            results[i] = all.back();
            EXPECT_EQ(all.front().runs, all.back().runs);
            cuMemFree(seen);
            cuMemFree(params);
            cuStreamDestroy(stream);
        });
    for (std::thread& thread : threads)
        thread.join();
    for (const LaunchSeen& seen : results)
        EXPECT_EQ(101 * kLaunches, seen.runs);
}

// Several threads use one context as an application does: modules, pipelines, builds, launches, and
// settings.
TEST_F(Streams, AllOfTheWorkOnSeveralThreads) {
    constexpr unsigned kThreads = 4, kRounds = 3;
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < kThreads; ++i)
        threads.emplace_back([&, i] {
            ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
            CUstream stream = nullptr;
            CUdeviceptr memory = 0; // seen, params, vertices
            ASSERT_EQ(CUDA_SUCCESS, cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
            ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&memory, 4096));
            const CUdeviceptr params = memory + 1024, vertices = memory + 2048;
            for (unsigned round = 0; round < kRounds; ++round) {
                Rig own(context_, log_, compiledPtx("launch", "clang"), compileOptions(1));
                own.raygenRecord(own.raygen("__raygen__trace"), 9u);
                own.missRecord(own.miss("__miss__value"), 11u);
                own.hitRecord(own.hit("__closesthit__value"), 100 * i + round);
                own.link();
                const OptixShaderBindingTable sbt = own.table();
                TriangleMesh mesh({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2});
                mesh.vertexAddress = vertices;
                const OptixAccelBuildOptions options = buildOptions();
                OptixAccelBufferSizes sizes{};
                EXPECT_EQ(OPTIX_SUCCESS,
                          optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
                CUdeviceptr temp = 0, output = 0;
                ASSERT_EQ(CUDA_SUCCESS, cuMemAllocAsync(&temp, sizes.tempSizeInBytes + 1, stream));
                ASSERT_EQ(CUDA_SUCCESS, cuMemAllocAsync(&output, sizes.outputSizeInBytes, stream));
                ASSERT_EQ(CUDA_SUCCESS, cuMemsetD8Async(memory, 0, 4096, stream));
                ASSERT_EQ(CUDA_SUCCESS,
                          cuMemcpyHtoDAsync(vertices, mesh.points.data(),
                                            mesh.points.size() * sizeof(Vec3), stream));
                LaunchParams values{};
                values.seen = reinterpret_cast<LaunchSeen*>(memory);
                EXPECT_EQ(OPTIX_SUCCESS,
                          optixAccelBuild(context_, stream, &options, &mesh.input, 1, temp,
                                          sizes.tempSizeInBytes, output, sizes.outputSizeInBytes,
                                          &values.handle, nullptr, 0));
                ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoDAsync(params, &values, sizeof(values), stream));
                EXPECT_EQ(OPTIX_SUCCESS, optixLaunch(own.pipeline(), stream, params, sizeof(values),
                                                     &sbt, 1, 1, 1));
                EXPECT_EQ(OPTIX_SUCCESS, optixDeviceContextSetLogCallback(
                                             context_, LogRecord::callback, &log_, 4 - round % 2));
                EXPECT_EQ(OPTIX_SUCCESS, optixDeviceContextSetCacheEnabled(context_, round % 2));
                ASSERT_EQ(CUDA_SUCCESS, cuMemFreeAsync(temp, stream));
                ASSERT_EQ(CUDA_SUCCESS, cuMemFreeAsync(output, stream));
                LaunchSeen seen{};
                ASSERT_EQ(CUDA_SUCCESS, cuMemcpyDtoHAsync(&seen, memory, sizeof(seen), stream));
                ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
                EXPECT_EQ(100 * i + round, seen.record);
            }
            cuMemFree(memory);
            cuStreamDestroy(stream);
        });
    for (std::thread& thread : threads)
        thread.join();
}

TEST_F(Streams, BuildsAndLaunchesInOrder) {
    // Vertices arrive, a structure is built, compacted rays trace it: all queued before any runs.
    TriangleMesh mesh({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2});
    auto* points = reinterpret_cast<Vec3*>(static_cast<char*>(pinned_) + 1024);
    const size_t bytes = mesh.points.size() * sizeof(Vec3);
    std::memcpy(points, mesh.points.data(), bytes);
    OptixAccelBuildOptions options = buildOptions();
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
    CUdeviceptr vertices = 0, temp = 0, output = 0;
    ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&vertices, bytes));
    ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&temp, sizes.tempSizeInBytes + 1));
    ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&output, sizes.outputSizeInBytes));
    ASSERT_EQ(CUDA_SUCCESS, cuMemsetD8(vertices, 0, bytes));
    waitForDefaultStream();
    mesh.vertexAddress = vertices;

    Gate gate;
    CUstream stream = streams_[0];
    ASSERT_EQ(CUDA_SUCCESS, cuLaunchHostFunc(stream, Gate::wait, &gate));
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoDAsync(vertices, points, bytes, stream));
    OptixTraversableHandle handle = 0;
    ASSERT_OK(optixAccelBuild(context_, stream, &options, &mesh.input, 1, temp,
                              sizes.tempSizeInBytes, output, sizes.outputSizeInBytes, &handle,
                              nullptr, 0));
    EXPECT_NE(0u, handle) << "the handle is known at once";
    EXPECT_FALSE(gate.open);
    // Host memory that the description points to may be freed as soon as the call returns.
    mesh.vertexAddress = 0;
    mesh.flags[0] = 0xFFFFFFFF;
    values_->handle = handle;
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoDAsync(params_, values_, sizeof(*values_), stream));
    ASSERT_OK(launch(stream));
    gate.open = true;
    ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
    EXPECT_EQ(22u, first().record) << "the ray met the triangle";
    cuMemFree(vertices);
    cuMemFree(temp);
    cuMemFree(output);
}

// Calls queued behind work do not wait for it, with any amount of data.
TEST_F(Streams, BuildsReturnBeforeTheyRun) {
    constexpr unsigned kInputs = 3000; // more than drivers take at once
    const TriangleMesh mesh({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2}),
        aside({{90, 0, 0}, {91, 0, 0}, {90, 1, 0}}, {0, 1, 2});
    std::vector<OptixBuildInput> inputs(kInputs, aside.input);
    inputs[0] = mesh.input;
    const OptixAccelBuildOptions options =
        buildOptions(OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, inputs.data(), kInputs, &sizes));
    Buffer temp(std::max(sizes.tempSizeInBytes, sizes.tempUpdateSizeInBytes)),
        output(sizes.outputSizeInBytes), compacted(sizes.outputSizeInBytes), size(8, 8);
    CUstream stream = streams_[0];
    OptixTraversableHandle handle = 0, moved = 0;
    const OptixAccelEmitDesc emit = {size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
    const auto build = [&](OptixBuildOperation operation) {
        OptixAccelBuildOptions these = options;
        these.operation = operation;
        return optixAccelBuild(context_, stream, &these, inputs.data(), kInputs, temp.address(),
                               temp.size(), output.address(), output.size(), &handle, &emit, 1);
    };
    for (int round = 0; round < 2; ++round) { // kernels are loaded, memory is allocated
        Gate gate;
        ASSERT_EQ(CUDA_SUCCESS, cuLaunchHostFunc(stream, Gate::wait, &gate));
        std::thread opener([&] { // so that the test fails in place of hanging
            for (int i = 0; i < 100 && !gate.open; ++i)
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
            gate.open = true;
        });
        EXPECT_EQ(OPTIX_SUCCESS, build(OPTIX_BUILD_OPERATION_BUILD)) << log_.all();
        EXPECT_EQ(OPTIX_SUCCESS, build(OPTIX_BUILD_OPERATION_UPDATE)) << log_.all();
        EXPECT_EQ(OPTIX_SUCCESS, optixAccelCompact(context_, stream, handle, compacted.address(),
                                                   compacted.size(), &moved));
        EXPECT_FALSE(gate.open) << "some call has waited";
        gate.open = true;
        opener.join();
        ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
    }
    values_->handle = moved;
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    ASSERT_OK(launch(stream));
    ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
    EXPECT_EQ(22u, first().record) << "the ray met the compacted triangle";

    // If the stream is busy, the error of a wrong call is found when the queued work runs.
    Gate gate;
    ASSERT_EQ(CUDA_SUCCESS, cuLaunchHostFunc(stream, Gate::wait, &gate));
    ASSERT_OK(optixAccelCompact(context_, stream, handle, compacted.address(), 256, &moved));
    gate.open = true;
    // On the CPU the fault is the stream's error.
    ASSERT_EQ(onGpu() ? CUDA_SUCCESS : CUDA_ERROR_INVALID_VALUE, cuStreamSynchronize(stream));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
              optixAccelCompact(context_, stream, handle, compacted.address(), 256, &moved));
    EXPECT_TRUE(log_.hasError("", onGpu() ? "the compaction to outputBuffer"
                                          : "outputBufferSizeInBytes = 256"))
        << log_.all();
}

// In all capture modes builds and launches become parts of a graph, which reads its inputs when it
// runs.
TEST_F(Streams, GraphsHoldBuildsAndLaunches) {
    constexpr unsigned kInputs = 3;
    const TriangleMesh mesh({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2}),
        aside({{90, 0, 0}, {91, 0, 0}, {90, 1, 0}}, {0, 1, 2});
    std::vector<OptixBuildInput> inputs = {mesh.input, aside.input, aside.input};
    const std::vector<OptixBuildInput> kept = inputs;
    const OptixAccelBuildOptions options = buildOptions(OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, inputs.data(), kInputs, &sizes));
    Buffer temp(std::max(sizes.tempSizeInBytes, sizes.tempUpdateSizeInBytes)),
        output(sizes.outputSizeInBytes);
    CUstream stream = streams_[0];
    for (const CUstreamCaptureMode mode :
         {CU_STREAM_CAPTURE_MODE_GLOBAL, CU_STREAM_CAPTURE_MODE_THREAD_LOCAL}) {
        ASSERT_EQ(CUDA_SUCCESS, cuStreamBeginCapture(stream, mode));
        for (const OptixBuildOperation operation :
             {OPTIX_BUILD_OPERATION_BUILD, OPTIX_BUILD_OPERATION_UPDATE}) {
            OptixAccelBuildOptions these = options;
            these.operation = operation;
            EXPECT_EQ(OPTIX_SUCCESS,
                      optixAccelBuild(context_, stream, &these, inputs.data(), kInputs,
                                      temp.address(), temp.size(), output.address(), output.size(),
                                      &values_->handle, nullptr, 0))
                << log_.all();
        }
        for (int i = 0; i < 3; ++i)
            EXPECT_EQ(OPTIX_SUCCESS, launch(stream)) << log_.all();
        CUgraph graph = nullptr;
        ASSERT_EQ(CUDA_SUCCESS, cuStreamEndCapture(stream, &graph));
        CUgraphExec program = nullptr;
        ASSERT_EQ(CUDA_SUCCESS, cuGraphInstantiateWithFlags(&program, graph, 0));
        std::fill(inputs.begin(), inputs.end(), OptixBuildInput{}); // the graph does not read there
        ASSERT_EQ(CUDA_SUCCESS, cuMemsetD8(seen_, 0, kIndices * sizeof(LaunchSeen)));
        ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
        waitForDefaultStream();
        ASSERT_OK(launch(streams_[1])); // others continue
        ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(streams_[1]));
        for (unsigned times = 1; times <= 3; ++times) {
            ASSERT_EQ(CUDA_SUCCESS, cuGraphLaunch(program, stream));
            ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
            EXPECT_EQ(22u, first().record);
            EXPECT_EQ(1 + 3 * times, first().runs);
        }
        EXPECT_EQ(CUDA_SUCCESS, cuGraphExecDestroy(program));
        EXPECT_EQ(CUDA_SUCCESS, cuGraphDestroy(graph));
        inputs = kept;
    }
    EXPECT_FALSE(log_.hasError("", "")) << log_.all();
}

// With debug exceptions, graphs also look handles up, with their state when the graph runs.
TEST_F(Streams, GraphsLookHandlesUp) {
    OptixPipelineCompileOptions options = compileOptions(1);
    options.exceptionFlags = OPTIX_EXCEPTION_FLAG_DEBUG;
    Rig rig(context_, log_, compiledPtx("launch", "clang"), options);
    rig.raygenRecord(rig.raygen("__raygen__trace"), 9u);
    rig.missRecord(rig.miss("__miss__value"), 11u);
    rig.hitRecord(rig.hit("__closesthit__value"), 22u);
    rig.link();
    const OptixShaderBindingTable sbt = rig.table();
    CUstream stream = streams_[0];
    ASSERT_EQ(CUDA_SUCCESS, cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_GLOBAL));
    EXPECT_OK(
        optixLaunch(rig.pipeline(), stream, params_, sizeof(LaunchParams), &sbt, kIndices, 1, 1));
    CUgraph graph = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, cuStreamEndCapture(stream, &graph));
    CUgraphExec program = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, cuGraphInstantiateWithFlags(&program, graph, 0));
    const auto recordOf = [&](OptixTraversableHandle given) {
        LaunchParams values = *values_;
        values.handle = given;
        EXPECT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, &values, sizeof(values)));
        EXPECT_EQ(CUDA_SUCCESS, cuMemsetD8(seen_, 0, kIndices * sizeof(LaunchSeen)));
        waitForDefaultStream();
        EXPECT_EQ(CUDA_SUCCESS, cuGraphLaunch(program, stream));
        EXPECT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
        return first().record;
    };
    const OptixTraversableHandle garbage = 0x12345681;
    const TriangleMesh mesh({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2});
    EXPECT_EQ(0u, recordOf(garbage)) << "an exception ends the index";
    const Accel later = buildAccel(context_, log_, {mesh.input});
    EXPECT_EQ(22u, recordOf(later.handle));
    constexpr size_t kStride = 128;
    static_assert(sizeof(OptixStaticTransform) <= kStride);
    Buffer transforms(200 * kStride, 64); // more than a table has room for
    OptixTraversableHandle handle = 0;
    for (size_t i = 0; i < 200; ++i)
        ASSERT_OK(optixConvertPointerToTraversableHandle(
            context_, transforms.address() + i * kStride, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM,
            &handle));
    EXPECT_EQ(22u, recordOf(later.handle));
    EXPECT_EQ(22u, recordOf(buildAccel(context_, log_, {mesh.input}).handle));
    EXPECT_EQ(0u, recordOf(garbage));
    EXPECT_EQ(CUDA_SUCCESS, cuGraphExecDestroy(program));
    EXPECT_EQ(CUDA_SUCCESS, cuGraphDestroy(graph));
}

TEST_F(Streams, EventsFollowLaunches) {
    Gate gate;
    CUevent event = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, cuEventCreate(&event, 0));
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    ASSERT_EQ(CUDA_SUCCESS, cuLaunchHostFunc(streams_[0], Gate::wait, &gate));
    ASSERT_OK(launch(streams_[0]));
    ASSERT_EQ(CUDA_SUCCESS, cuEventRecord(event, streams_[0]));
    EXPECT_EQ(CUDA_ERROR_NOT_READY, cuEventQuery(event));
    // The other stream's launch waits for the event.
    ASSERT_EQ(CUDA_SUCCESS, cuStreamWaitEvent(streams_[1], event, 0));
    ASSERT_OK(launch(streams_[1]));
    EXPECT_EQ(CUDA_ERROR_NOT_READY, cuStreamQuery(streams_[1]));
    gate.open = true;
    ASSERT_EQ(CUDA_SUCCESS, cuStreamSynchronize(streams_[1]));
    EXPECT_EQ(CUDA_SUCCESS, cuEventQuery(event));
    EXPECT_EQ(2u, first().runs);
    cuEventDestroy(event);
}

TEST_F(Streams, MemoryThatIsNone) {
    auto bad = OPTIX_ERROR_INVALID_VALUE;
    EXPECT_EQ(bad, launch(streams_[0], sizeof(LaunchParams) + 1));
    CUdeviceptr freed = 0;
    ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&freed, 64));
    // Beyond the end of an allocation.
    CUdeviceptr keep = params_;
    params_ = freed + 40;
    EXPECT_EQ(bad, launch(streams_[0])) << log_.all();
    params_ = keep;
    cuMemFree(freed);
}

// Memory that is mapped in pieces is one buffer; its contents may be moved elsewhere and return in
// other pieces.
TEST_F(Streams, BuffersOfSeveralPieces) {
    CUmemAllocationProp properties{};
    properties.type = CU_MEM_ALLOCATION_TYPE_PINNED;
    properties.location.type = CU_MEM_LOCATION_TYPE_DEVICE;
    size_t unit = 0;
    ASSERT_EQ(CUDA_SUCCESS,
              cuMemGetAllocationGranularity(&unit, &properties, CU_MEM_ALLOC_GRANULARITY_MINIMUM));
    CUdeviceptr space = 0;
    ASSERT_EQ(CUDA_SUCCESS, cuMemAddressReserve(&space, 3 * unit, 0, 0, 0));
    const auto mapTwo = [&] {
        CUmemAccessDesc access{};
        access.location = properties.location;
        access.flags = CU_MEM_ACCESS_FLAGS_PROT_READWRITE;
        for (const CUdeviceptr piece : {space, space + unit}) {
            CUmemGenericAllocationHandle memory = 0;
            ASSERT_EQ(CUDA_SUCCESS, cuMemCreate(&memory, unit, &properties, 0));
            ASSERT_EQ(CUDA_SUCCESS, cuMemMap(piece, unit, 0, memory, 0));
            ASSERT_EQ(CUDA_SUCCESS, cuMemRelease(memory)); // mapped memory stays
            ASSERT_EQ(CUDA_SUCCESS, cuMemSetAccess(piece, unit, &access, 1));
        }
    };
    const auto unmapTwo = [&] {
        for (const CUdeviceptr piece : {space, space + unit})
            ASSERT_EQ(CUDA_SUCCESS, cuMemUnmap(piece, unit));
    };
    mapTwo();
    TriangleMesh mesh({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2});
    const OptixAccelBuildOptions options = buildOptions();
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
    const CUdeviceptr structure = space + unit - OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT, own = params_;
    Buffer temp(sizes.tempSizeInBytes);
    ASSERT_OK(optixAccelBuild(context_, streams_[0], &options, &mesh.input, 1, temp.address(),
                              temp.size(), structure, sizes.outputSizeInBytes, &values_->handle,
                              nullptr, 0));
    const auto recordOfHit = [&] {
        EXPECT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
        waitForDefaultStream();
        EXPECT_OK(launch(streams_[0]));
        EXPECT_EQ(CUDA_SUCCESS, cuStreamSynchronize(streams_[0]));
        return first().record;
    };
    EXPECT_EQ(22u, recordOfHit());
    params_ = space + unit - 16; // over the structure, which is not needed for now
    const OptixTraversableHandle handle = values_->handle;
    std::vector<uint8_t> kept(sizes.outputSizeInBytes);
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyDtoH(kept.data(), structure, kept.size()));
    values_->handle = 0;
    EXPECT_EQ(11u, recordOfHit());
    params_ = space + 2 * unit - 16;
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, launch(streams_[0])) << "the third piece is not there";
    unmapTwo();
    params_ = own;
    values_->handle = handle;
    mapTwo();
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(structure, kept.data(), kept.size()));
    waitForDefaultStream();
    EXPECT_EQ(22u, recordOfHit());
    unmapTwo();
    ASSERT_EQ(CUDA_SUCCESS, cuMemAddressFree(space, 3 * unit));
}

TEST_F(Streams, StreamsThatAreNone) {
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    CUstream dead = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, cuStreamCreate(&dead, CU_STREAM_NON_BLOCKING));
    ASSERT_EQ(CUDA_SUCCESS, cuStreamDestroy(dead));
    for (CUstream stream : {dead, reinterpret_cast<CUstream>(0x1230)}) {
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, launch(stream));
        EXPECT_TRUE(log_.hasError("optixLaunch", "stream")) << log_.all();
        log_.clear();
    }
}

// "The stream and pipeline must belong to the same device context."
TEST_F(Streams, StreamsOfAnotherContext) {
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    CUcontext other = nullptr;
    CUstream foreign = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, cuCtxCreate_v2(&other, 0, 0));
    ASSERT_EQ(CUDA_SUCCESS, cuStreamCreate(&foreign, CU_STREAM_NON_BLOCKING));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, launch(foreign));
    EXPECT_TRUE(log_.hasError("optixLaunch", "belongs to CUDA context")) << log_.all();
    ASSERT_EQ(CUDA_SUCCESS, cuStreamDestroy(foreign));
    ASSERT_EQ(CUDA_SUCCESS, cuCtxDestroy(other));
    ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
    EXPECT_OK(launch(streams_[0]));
    EXPECT_EQ(CUDA_SUCCESS, cuStreamSynchronize(streams_[0]));
    EXPECT_EQ(1u, first().runs);
}

TEST_F(Streams, DefaultStreams) {
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    for (CUstream stream : {CUstream(nullptr), CU_STREAM_LEGACY, CU_STREAM_PER_THREAD}) {
        EXPECT_OK(launch(stream));
        EXPECT_EQ(CUDA_SUCCESS, cuStreamSynchronize(stream));
    }
    EXPECT_EQ(3u, first().runs);
}

TEST_F(Streams, LaunchErrorsAppearAtTheStream) {
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    Buffer zeros(64, 16);
    OptixShaderBindingTable sbt{};
    sbt.raygenRecord = zeros.address();
    ASSERT_OK(
        optixLaunch(rig_->pipeline(), streams_[0], params_, sizeof(LaunchParams), &sbt, 1, 1, 1));
    EXPECT_NE(CUDA_SUCCESS, cuStreamSynchronize(streams_[0]));
    EXPECT_TRUE(log_.hasError("record", "")) << log_.all();
}

TEST_F(Streams, DestroyWaits) {
    Gate gate;
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(params_, values_, sizeof(*values_)));
    ASSERT_EQ(CUDA_SUCCESS, cuLaunchHostFunc(streams_[0], Gate::wait, &gate));
    ASSERT_OK(launch(streams_[0]));
    std::thread opener([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        gate.open = true;
    });
    ASSERT_OK(optixDeviceContextDestroy(context_));
    EXPECT_TRUE(gate.open) << "returned before the launch was done";
    EXPECT_EQ(1u, first().runs);
    opener.join();
    context_ = nullptr; // it has destroyed the rig's objects; destroying them again is refused
}

} // namespace
} // namespace tests::api
