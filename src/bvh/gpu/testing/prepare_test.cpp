// SPDX-License-Identifier: Apache-2.0
// Builder::prepare() loads every kernel that a build and later calls launch: these calls must not
// compile or load, because a driver may then wait for the GPU. No kernel runs here.
#include "bvh/gpu/build/plan.h"
#include "bvh/gpu/testing/device.h"

#include <gtest/gtest.h>

#include <set>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;
using device::cuda::Driver;
using device::cuda::KernelSource;

// A store without machine code that counts requests.
struct Requests : device::cuda::MachineCodeSource {
    std::set<std::string> kernels;
    int calls = 0;

    std::vector<std::string> machineCode(std::span<const KernelSource* const> asked,
                                         bool) override {
        ++calls;
        for (const KernelSource* kernel : asked)
            EXPECT_TRUE(kernels.insert(kernel->id).second) << kernel->id << " is made twice";
        return std::vector<std::string>(asked.size());
    }
};

std::set<std::string> launched;

void expectPrepared(const BuildInputs& inputs, BuildOptions options, const char* what) {
    SCOPED_TRACE(what);
    Driver driver = Device::get().driver();
    driver.launchKernel = [](CUfunction, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned,
                             unsigned, CUstream, void**, void**) { return CUDA_SUCCESS; };
    Requests requests;
    Builder builder(driver, &requests);
    builder.observe([](void*, const char* kernel) { launched.insert(kernel); }, nullptr);
    EXPECT_EQ(requests.calls, 0);
    builder.prepare(inputs, options);
    EXPECT_EQ(requests.calls, 1) << "all at a time";
    launched.clear();
    const MemoryUsage usage = Builder::computeMemoryUsage(inputs, options);
    Buffer temp(std::max(usage.temp, usage.tempUpdate)), output(usage.output), size(64);
    builder.build(nullptr, inputs, options, temp.address(), temp.size(), output.address(),
                  output.size());
    builder.emitCompactedSize(nullptr, output.address(), size.address());
    builder.emitBounds(nullptr, output.address(), size.address());
    builder.compact(nullptr, output.address(), output.address(), output.size());
    builder.relocate(nullptr, {}, output.address(), 0, 0);
    builder.relocateMicromaps(nullptr, output.address(), 0, output.address());
    if (options.allowUpdate) {
        // The header as the kernels would have written it.
        const Uploads uploads(inputs, options, Plan(inputs, options), 0);
        std::memcpy(output.data(), uploads.output.data(), uploads.output.size());
        static_cast<BlockHeader*>(output.data())->magic = kGpuBlockMagic;
        static_cast<BlockHeader*>(output.data())->usedSize = output.size();
        builder.update(nullptr, inputs, options, temp.address(), temp.size(), output.address(),
                       output.size());
    }
    EXPECT_EQ(requests.calls, 1);
    for (const std::string& kernel : launched)
        EXPECT_TRUE(requests.kernels.contains(kernel)) << kernel;
}

TEST(GpuPrepare, LaterCallsOnlyQueue) {
    const auto mesh = icosphere(2); // enough triangles that splits are possible
    const TriangleInput still = mesh.input();
    const void* const keys[] = {mesh.vertices.data(), mesh.vertices.data()};
    TriangleInput moving = still;
    moving.keyVertices = keys;
    const float spheres[8] = {0, 0, 0, 1, 1, 1, 2, 2};
    const void* const keySpheres[] = {spheres, spheres};
    SphereInput ball, movingBall;
    ball.centres = ball.radii = spheres;
    ball.numSpheres = 2;
    movingBall = ball;
    movingBall.keyCentres = movingBall.keyRadii = keySpheres;
    std::vector<InstanceDesc> none(3);
    InstanceInput instances;
    instances.instances = none.data();
    instances.numInstances = 3;

    for (const bool update : {false, true})
        for (const bool motion : {false, true}) {
            BuildOptions options;
            options.allowCompaction = true;
            options.allowUpdate = update;
            if (motion)
                options.motion = {2, 0, 0, 1};
            BuildInputs inputs;
            inputs.triangles = {motion ? &moving : &still, 1};
            expectPrepared(inputs, options, "triangles");
            options.preferFastBuild = true;
            expectPrepared(inputs, options, "triangles, fast build");
            options.preferFastBuild = false;
            options.preferFastTrace = true;
            expectPrepared(inputs, options, "triangles, fast trace");
            EXPECT_EQ(launched.contains("sunstone_split"), !update && !motion);
            options.preferFastTrace = false;
            inputs.triangles = {};
            inputs.spheres = {motion ? &movingBall : &ball, 1};
            expectPrepared(inputs, options, "spheres");
            inputs.spheres = {};
            inputs.instances = &instances;
            expectPrepared(inputs, options, "instances");
        }
}

} // namespace
} // namespace sunstone::bvh::gpu
