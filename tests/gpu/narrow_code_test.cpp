// SPDX-License-Identifier: Apache-2.0
// Code for the traversables of the process alone, with the CPU device acting as a GPU: which
// launches get it, and that they trace right. Loads of the driver are counted.
#include "counted_driver.h"

#include "api/device_memory.h"
#include "api/rig.h"
#include "api/scene.h"

#include <cstdlib>
#include <dlfcn.h>

namespace tests::api {
namespace {

// A function of the driver, which the application need not link.
template <auto& kFunction>
auto call(const char* name) {
    static void* const library = dlopen("libcuda.so.1", RTLD_NOW);
    const auto function = reinterpret_cast<decltype(&kFunction)>(dlsym(library, name));
    EXPECT_NE(nullptr, function) << name;
    return [function](auto... arguments) { EXPECT_EQ(CUDA_SUCCESS, function(arguments...)); };
}
#define CALL(function, ...) call<function>(TEXT_OF(function))(__VA_ARGS__)
#define TEXT_OF(name) TEXT(name)
#define TEXT(name) #name

// As in recursion.cu.
struct RecursionParams {
    unsigned long long handle;
    unsigned long long* results;
    unsigned depth, missTraces;
    const unsigned* table;
};

// Each test runs in a process of its own: the traversables of a process only become more.
class GpuNarrowCode : public CachedGpuTest {
protected:
    void SetUp() override {
        CachedGpuTest::SetUp();
        setenv("SUNSTONE_GPU_CODE", "narrow", 1);
        if (!dlopen("libnvidia-ptxjitcompiler.so.1", RTLD_NOW))
            GTEST_SKIP() << "no compiler beside the driver";
    }
    void TearDown() override {
        rig_.reset();
        CachedGpuTest::TearDown();
    }
    void makePipeline(unsigned graphFlags, bool motion) {
        OptixPipelineCompileOptions options = compileOptions(3);
        options.traversableGraphFlags = graphFlags;
        options.usesMotionBlur = motion;
        rig_ = std::make_unique<Rig>(context_, log_, compiledPtx("recursion", "clang"), options);
        rig_->raygenRecord(rig_->raygen("__raygen__recursion"));
        rig_->missRecord(rig_->miss("__miss__recursion"));
        rig_->hitRecord(rig_->hit("__closesthit__recursion"));
        rig_->link();
    }
    // A wall above the ray, with two motion keys if it moves.
    std::unique_ptr<Accel> wall(float z, bool moves = false) {
        meshes_.push_back(
            std::make_unique<TriangleMesh>(std::vector<Vec3>{{-1, -1, z}, {3, -1, z}, {-1, 3, z}},
                                           std::vector<uint32_t>{0, 1, 2}));
        TriangleMesh& mesh = *meshes_.back();
        const CUdeviceptr keys[] = {mesh.vertexAddress, mesh.vertexAddress};
        OptixBuildInput input = mesh.input;
        OptixAccelBuildOptions options = buildOptions();
        if (moves) {
            input.triangleArray.vertexBuffers = keys;
            options.motionOptions = {2, 0, 0, 1};
        }
        return std::make_unique<Accel>(buildAccel(context_, log_, {input}, options, {}));
    }
    bool isHit(const Accel& accel) { return isHit(accel.handle); }
    bool isHit(OptixTraversableHandle handle) {
        Buffer results(16);
        rig_->run(RecursionParams{handle, results.as<unsigned long long>(), 1, 0, nullptr}, 1);
        const auto value = results.as<unsigned long long>()[0];
        EXPECT_TRUE(value == 1 || value == 7) << value; // hit, miss
        return value == 1;
    }
    std::unique_ptr<Rig> rig_;
    std::vector<std::unique_ptr<TriangleMesh>> meshes_;
};

TEST_F(GpuNarrowCode, FollowsTheTraversables) {
    const auto near = wall(1), far = wall(20);
    loads = 0; // without those of builders
    makePipeline(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, true);
    EXPECT_EQ(1u, loads) << "for all that the pipeline declares";
    EXPECT_TRUE(isHit(*near));
    EXPECT_FALSE(isHit(*far));
    EXPECT_EQ(2u, loads) << "without instances and motion";

    const InstanceList list({instanceOf(far->handle, translation(0, 0, -18))});
    const Accel instances = buildAccel(context_, log_, {list.input});
    loads = 0;
    EXPECT_TRUE(isHit(instances));
    EXPECT_TRUE(isHit(*near));
    EXPECT_EQ(1u, loads) << "without motion";

    const auto moving = wall(1, true);
    loads = 0;
    EXPECT_TRUE(isHit(*moving));
    EXPECT_TRUE(isHit(instances));
    EXPECT_EQ(0u, loads) << "for all that the pipeline declares";
}

TEST_F(GpuNarrowCode, TransformsMoveWithoutMotionKeys) {
    const auto far = wall(20);
    Buffer memory(sizeof(OptixMatrixMotionTransform), 64);
    auto& transform = *memory.as<OptixMatrixMotionTransform>();
    transform = {};
    transform.child = far->handle;
    transform.motionOptions = {2, 0, 0, 1};
    const Matrix nearer = translation(0, 0, -18);
    for (auto& key : transform.transform)
        std::copy(nearer.begin(), nearer.end(), key);
    OptixTraversableHandle handle = 0;
    ASSERT_OK(optixConvertPointerToTraversableHandle(
        context_, memory.address(), OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM, &handle));
    makePipeline(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, true);
    loads = 0;
    EXPECT_TRUE(isHit(handle));
    EXPECT_FALSE(isHit(*far));
    EXPECT_EQ(1u, loads) << "without motion keys";
    const auto moving = wall(1, true);
    loads = 0;
    EXPECT_TRUE(isHit(*moving));
    EXPECT_TRUE(isHit(handle));
    EXPECT_EQ(0u, loads) << "for all that the pipeline declares";
}

TEST_F(GpuNarrowCode, LaterProcessesFindItInTheDiskCache) {
    const auto near = wall(1);
    makePipeline(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, false);
    EXPECT_TRUE(isHit(*near));
    unsetenv("SUNSTONE_GPU_CODE");
    makePipeline(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, false);
    loads = 0;
    EXPECT_TRUE(isHit(*near));
    EXPECT_EQ(1u, loads);
}

TEST_F(GpuNarrowCode, IsNotMadeForFewLaunches) {
    setenv("SUNSTONE_GPU_CODE", "whole", 1);
    const auto near = wall(1);
    makePipeline(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, true);
    loads = 0;
    for (unsigned i = 0; i < 20; ++i)
        EXPECT_TRUE(isHit(*near));
    EXPECT_EQ(0u, loads);
}

// The graph may run after other structures have been built.
TEST_F(GpuNarrowCode, CapturedLaunchesDoNotGetIt) {
    const auto near = wall(1), far = wall(20);
    makePipeline(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, false);
    loads = 0;
    EXPECT_TRUE(isHit(*near));
    EXPECT_EQ(1u, loads);
    Buffer results(16), params(sizeof(RecursionParams));
    const auto set = [&](OptixTraversableHandle handle) {
        *params.as<RecursionParams>() = {handle, results.as<unsigned long long>(), 1, 0, nullptr};
    };
    set(near->handle);
    const OptixShaderBindingTable table = rig_->table();
    CUstream stream = nullptr;
    CALL(cuStreamCreate, &stream, CU_STREAM_NON_BLOCKING);
    CALL(cuStreamBeginCapture, stream, CU_STREAM_CAPTURE_MODE_GLOBAL);
    EXPECT_OK(optixLaunch(rig_->pipeline(), stream, params.address(), sizeof(RecursionParams),
                          &table, 1, 1, 1));
    CUgraph graph = nullptr;
    CUgraphExec exec = nullptr;
    CALL(cuStreamEndCapture, stream, &graph);
    CALL(cuGraphInstantiateWithFlags, &exec, graph, 0);

    const InstanceList list({instanceOf(far->handle, translation(0, 0, -18))});
    const Accel instances = buildAccel(context_, log_, {list.input});
    for (const OptixTraversableHandle handle : {instances.handle, near->handle}) {
        set(handle);
        CALL(cuGraphLaunch, exec, stream);
        CALL(cuStreamSynchronize, stream);
        EXPECT_EQ(1u, results.as<unsigned long long>()[0]);
    }
    CALL(cuGraphExecDestroy, exec);
    CALL(cuGraphDestroy, graph);
    CALL(cuStreamDestroy, stream);
}

} // namespace
} // namespace tests::api
