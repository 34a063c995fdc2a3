// SPDX-License-Identifier: Apache-2.0
// Which narrow code a pipeline gets, and when.
#include "engine/gpu/code/narrow_code.h"

#include "devlib/flags.h"
#include "engine/gpu/code/code.h"

#include <gtest/gtest.h>

namespace sunstone::engine {
namespace {

using namespace devlib;

TEST(NarrowCode, KindSufficesForTheTraversables) {
    const GpuGraphs none, meshes{true, false, false, false, false},
        moving{true, false, false, true, true}, instances{true, true, false, false, false},
        turning{true, true, true, true, false}, deep{true, true, true, true, true};
    for (const GraphKind graph : {kGraphSingleLevel, kGraphShallow, kGraphAny})
        for (const MotionKind motion : {kMotionNone, kMotionAll}) {
            const GpuCodeKind declared = {graph, motion};
            EXPECT_EQ(declared, narrowed(declared, none)) << "they may come";
            EXPECT_EQ(declared, narrowed(declared, deep));
            EXPECT_EQ((GpuCodeKind{kGraphGas, kMotionNone}), narrowed(declared, meshes));
            EXPECT_EQ((GpuCodeKind{kGraphGas, motion}), narrowed(declared, moving));
            const GraphKind oneLevel = graph == kGraphAny ? kGraphShallow : graph;
            EXPECT_EQ((GpuCodeKind{oneLevel, kMotionNone}), narrowed(declared, instances));
            EXPECT_EQ((GpuCodeKind{graph, motion ? kMotionTransforms : kMotionNone}),
                      narrowed(declared, turning));
        }
    EXPECT_EQ((GpuCodeKind{kGraphGas, kMotionAll}), narrowed({kGraphGas, kMotionAll}, deep));
}

TEST(NarrowCode, StartsAfterLaunchesAndTime) {
    StartsNarrow few, slow;
    const StartsNarrow::Time begin{};
    for (unsigned i = 0; i < 100; ++i)
        EXPECT_FALSE(few.next(begin));
    EXPECT_TRUE(few.next(begin + StartsNarrow::kTime));
    for (unsigned i = 1; i < StartsNarrow::kLaunches; ++i)
        EXPECT_FALSE(slow.next(begin + i * StartsNarrow::kTime));
    EXPECT_TRUE(slow.next(begin + 100 * StartsNarrow::kTime));
}

struct Fake {
    unsigned searches = 0, compilations = 0, loads = 0;
    std::shared_ptr<GpuLaterCode> later = std::make_shared<GpuLaterCode>();
    bool isKept = false, isIdle = true;
    // Never dereferenced.
    std::shared_ptr<GpuCodeObject> loaded{std::make_shared<int>(),
                                          reinterpret_cast<GpuCodeObject*>(this)};
    GpuNarrowCodes codes{[this](GpuCodeKind, bool compiles) {
        ++(compiles ? compilations : searches);
        return isKept || compiles ? later : nullptr;
    }};
    std::shared_ptr<GpuCodeObject> get(uint64_t indices = WaitsForWhole::kLargeLaunch) {
        return codes.get(
            {kGraphGas, kMotionNone}, indices, [this] { return isIdle; },
            [this](const GpuLaterCode&) {
                ++loads;
                return loaded;
            });
    }
};

TEST(NarrowCode, KeptCodeIsLoadedOnceWhenTheStreamIsIdle) {
    Fake fake;
    fake.isKept = true;
    fake.later->code.machineCode = "code";
    fake.later->isReady = true;
    fake.isIdle = false;
    EXPECT_EQ(nullptr, fake.get());
    fake.isIdle = true;
    for (unsigned i = 0; i < 3; ++i)
        EXPECT_EQ(fake.loaded, fake.get(1));
    EXPECT_EQ(1u, fake.loads);
    EXPECT_EQ(1u, fake.searches);
    EXPECT_EQ(0u, fake.compilations);
}

TEST(NarrowCode, SmallLaunchesCompileNone) {
    Fake fake;
    for (unsigned i = 0; i < 1000; ++i)
        EXPECT_EQ(nullptr, fake.get(1));
    EXPECT_EQ(1u, fake.searches);
    EXPECT_EQ(0u, fake.compilations);
}

TEST(NarrowCode, CodeWithVariablesIsRefused) {
    Fake fake;
    fake.isKept = true;
    fake.later->code.machineCode = "code";
    fake.later->code.hasState = true;
    fake.later->isReady = true;
    for (unsigned i = 0; i < 3; ++i)
        EXPECT_EQ(nullptr, fake.get());
    EXPECT_EQ(0u, fake.loads);
}

TEST(NarrowCode, ItsCompilationMayBeginWithThePipeline) {
    Fake fake;
    const GpuCodeKind kind = {kGraphGas, kMotionNone};
    EXPECT_EQ(nullptr, fake.codes.pending(kind));
    fake.codes.begin(kind, fake.later);
    EXPECT_EQ(fake.later.get(), fake.codes.pending(kind));
    EXPECT_EQ(nullptr, fake.codes.pending({kGraphShallow, kMotionNone}));
    EXPECT_EQ(nullptr, fake.get());
    fake.later->code.machineCode = "code";
    fake.later->isReady = true;
    EXPECT_EQ(fake.loaded, fake.get());
    EXPECT_EQ(nullptr, fake.codes.pending(kind));
    EXPECT_EQ(0u, fake.searches);
    EXPECT_EQ(0u, fake.compilations);
}

TEST(NarrowCode, FlagsMayAnnounceInstances) {
    const GpuGraphs none, meshes{true, false, false, false, false},
        instances{true, true, false, false, false};
    EXPECT_FALSE(isSceneComplete(none, 0));
    EXPECT_TRUE(isSceneComplete(meshes, 0));
    EXPECT_TRUE(isSceneComplete(meshes, kAllowSingleGas));
    EXPECT_FALSE(isSceneComplete(meshes, kAllowSingleLevelInstancing));
    EXPECT_TRUE(isSceneComplete(instances, kAllowSingleLevelInstancing));
}

} // namespace
} // namespace sunstone::engine
