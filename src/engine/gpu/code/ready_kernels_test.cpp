// SPDX-License-Identifier: Apache-2.0
#include "compiler/flavor.h"
#include "devlib/gpu/launch_block.h"
#include "engine/gpu/code/machine_code.h"
#include "engine/gpu/code/ready_code.h"

#include <gtest/gtest.h>

#include <set>

namespace sunstone::engine {
namespace {

compiler::GpuPipelineRequest requestFor(devlib::GraphKind graph, unsigned depth) {
    compiler::GpuPipelineRequest request;
    request.target = {90, 80, 13000};
    request.maxTraceDepth = depth;
    request.constants = {{kGraphConstant, graph}};
    return request;
}
std::string idFor(const compiler::GpuPipelineRequest& request) {
    const auto kernel = readyKernelFor(request);
    return kernel ? readyKernelId(*kernel) : std::string();
}

TEST(ReadyKernels, HaveDifferentNamesAndServeSomePipeline) {
    std::set<std::string> names;
    for (const auto& kernel : readyKernels({90, 80, 13000})) {
        EXPECT_TRUE(names.insert(readyKernelId(kernel)).second) << readyKernelId(kernel);
        EXPECT_EQ(idFor(kernel), readyKernelId(kernel)) << "a kernel serves what it is made for";
        EXPECT_LE(readyKernelRegisters(kernel), kMostRegisters);
    }
    EXPECT_EQ(names.size(), 26u);
}

TEST(ReadyKernels, SuitThePipeline) {
    EXPECT_EQ(idFor(requestFor(devlib::kGraphGas, 1)),
              "ready, optix7, graph 0, shapes 0, motion 0, depth 2");
    EXPECT_EQ(idFor(requestFor(devlib::kGraphSingleLevel, 2)),
              "ready, optix7, graph 3, shapes 0, motion 0, depth 2");
    EXPECT_EQ(idFor(requestFor(devlib::kGraphAny, 3)),
              "ready, optix7, graph 2, shapes 0, motion 0, depth 6");
    compiler::GpuPipelineRequest request = requestFor(devlib::kGraphShallow, 6);
    request.constants.emplace_back("sunstone_gpu_hasIntersection", 1);
    EXPECT_EQ(idFor(request), "ready, optix7, graph 3, shapes 1, motion 0, depth 6");
    request = requestFor(devlib::kGraphGas, 1);
    request.constants.emplace_back("sunstone_gpu_shapes", 2);
    EXPECT_EQ(idFor(request), "ready, optix7, graph 0, shapes 1, motion 0, depth 2");
    request.constants.emplace_back("sunstone_gpu_motion", devlib::kMotionAll);
    EXPECT_EQ(idFor(request), "ready, optix7, graph 0, shapes 1, motion 2, depth 2");
}

TEST(ReadyKernels, ServeTheClassicApi) {
    const auto classic = [](devlib::GraphKind graph, unsigned depth) {
        compiler::GpuPipelineRequest request = requestFor(graph, depth);
        request.pipeline.flavor = &compiler::optix6Flavor();
        return request;
    };
    EXPECT_EQ(idFor(classic(devlib::kGraphSingleLevel, 1)),
              "ready, optix6, graph 3, shapes 1, motion 0, depth 6");
    compiler::GpuPipelineRequest request = classic(devlib::kGraphAny, 16);
    EXPECT_EQ(idFor(request), "ready, optix6, graph 2, shapes 1, motion 0, depth 31");
    request.constants.emplace_back("sunstone_gpu_motion", devlib::kMotionAll);
    EXPECT_EQ(idFor(request), "") << "deep and moving";
    request = classic(devlib::kGraphAny, 5);
    request.constants.emplace_back("sunstone_gpu_motion", devlib::kMotionAll);
    EXPECT_EQ(idFor(request), "ready, optix6, graph 2, shapes 1, motion 2, depth 6");
    request.constants.emplace_back("sunstone_gpu_hasVisits", 1);
    EXPECT_EQ(idFor(request), "") << "visit programs";
}

TEST(ReadyKernels, ServeDeepTraces) {
    compiler::GpuPipelineRequest request = requestFor(devlib::kGraphGas, 7);
    EXPECT_EQ(idFor(request), "ready, optix7, graph 0, shapes 1, motion 0, depth 31");
    request.constants.emplace_back("sunstone_gpu_motion", devlib::kMotionAll);
    EXPECT_EQ(idFor(request), "") << "deep and moving";
}

TEST(ReadyKernels, SomePipelinesHaveNone) {
    EXPECT_EQ(idFor(requestFor(devlib::kGraphGas, 0)), "") << "the depth is not known";
    EXPECT_EQ(idFor(requestFor(devlib::kGraphGas, 32)), "") << "too deep";
    compiler::GpuPipelineRequest request = requestFor(devlib::kGraphGas, 1);
    request.pipeline.rules.exceptionFlags = devlib::kFlagTraceDepth | devlib::kFlagUser;
    EXPECT_NE(idFor(request), "");
    request.pipeline.rules.exceptionFlags |= devlib::kFlagDebug;
    EXPECT_EQ(idFor(request), "");
    request = requestFor(devlib::kGraphGas, 1);
    request.pipeline.programs.resize(48);
    EXPECT_NE(idFor(request), "");
    request.pipeline.programs.resize(49);
    EXPECT_EQ(idFor(request), "") << "many programs";
}

} // namespace
} // namespace sunstone::engine
