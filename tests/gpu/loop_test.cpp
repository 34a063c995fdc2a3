// SPDX-License-Identifier: Apache-2.0
// Programs that are cut at their traces (compiler/gpu/resumable.h, devlib/gpu/loop.h, nested.h), on
// the CPU device: in any order of a warp's lanes, each launch index gets the values it gets when it
// runs alone.
#include "bvh/walk/kernels.h"
#include "gpu/kernel.h"
#include "gpu/loop.h"

#include <fstream>
#include <sstream>
#include <vector>

namespace sunstone {
namespace {

using namespace gpu_tests;

std::string textOf(const char* path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

Options oneHitGroup(unsigned maxTraceDepth = 0) {
    Options options;
    options.oneHitGroup = true;
    options.maxTraceDepth = maxTraceDepth;
    return options;
}

struct Job {
    unsigned width = 1, height = 1, depth = 1;
    unsigned flags = 1; // DISABLE_ANYHIT
    unsigned most = 6, throwAt = 5, throwBelow = 5;
    unsigned patience = 3, maxTraceDepth = 3;
    unsigned blockThreads = devlib::kGpuBlockThreads; // of kernels whose warps take launch indices
    bool hasExceptionRecord = true;
};

std::vector<TestRay> someRays() {
    std::vector<TestRay> rays;
    uint32_t state = 5;
    const auto number = [&] {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) * 0x1p-23f - 1;
    };
    for (uint32_t i = 0; i < 97; ++i) {
        TestRay ray{{number() * 3, number() * 3, number() * 3}, 0, {}, 1e16f};
        for (int k = 0; k < 3; ++k)
            ray.direction[k] = number() * 0.9f - ray.origin[k];
        rays.push_back(ray);
    }
    return rays;
}

class GpuLoop : public testing::Test {
protected:
    GpuLoop()
        : structure_(bvh::gpu::testing::buildOnDevice(bvh::testing::roughSphere(3, 7).input())) {}

    static Kernel& cut() {
        static Kernel kernel(textOf(TEST_LOOP_PTX), oneHitGroup());
        return kernel;
    }
    static Kernel& whole() {
        static Kernel kernel(textOf(TEST_LOOP_TWO_PTX), oneHitGroup());
        return kernel;
    }

    // Closest-hit programs are cut too.
    static constexpr unsigned kMostDepth = 3;
    static Kernel& nested() {
        static Kernel kernel(textOf(TEST_LOOP_TWO_PTX), oneHitGroup(kMostDepth));
        return kernel;
    }
    // Closest-hit programs are also called by address.
    static Options apartOptions() {
        Options options = oneHitGroup(kMostDepth);
        options.mostInlined = 0;
        return options;
    }
    static Kernel& apart() {
        static Kernel kernel(textOf(TEST_LOOP_TWO_PTX), apartOptions());
        return kernel;
    }

    // Linked with a kernel that serves many pipelines.
    static Kernel& ready() {
        static Kernel kernel(textOf(TEST_LOOP_TWO_PTX), readyOptions());
        return kernel;
    }
    static Options readyOptions() {
        Options options = oneHitGroup(kMostDepth);
        options.ready = true;
        return options;
    }

    // Callables trace the rays: inlined into programs that are cut, or called by address.
    static Kernel& callables() {
        static Kernel kernel(textOf(TEST_LOOP_CALLABLES_PTX), oneHitGroup(kMostDepth));
        return kernel;
    }
    static Kernel& readyCallables() {
        static Kernel kernel(textOf(TEST_LOOP_CALLABLES_PTX), readyOptions());
        return kernel;
    }
    // The callables have one parameter more than the calls pass.
    static Kernel& otherTypes() {
        static Kernel kernel(
            [] {
                std::string text = textOf(TEST_LOOP_CALLABLES_PTX);
                for (const std::string name : {"once", "twice"}) {
                    const size_t last = text.find("__continuation_callable__" + name + "_param_3");
                    text.insert(text.find('\n', last), ", .param .b32 unused");
                }
                return text;
            }(),
            oneHitGroup(kMostDepth));
        return kernel;
    }
    static Kernel& wholeCallables() {
        static Kernel kernel(textOf(TEST_LOOP_CALLABLES_PTX), oneHitGroup());
        return kernel;
    }

    std::vector<LoopResult> run(Kernel& kernel, const Job& job,
                                devlib::LaunchReport* report) const {
        const std::vector<TestRay> rays = someRays();
        const size_t count = size_t(job.width) * job.height * job.depth;
        // One element more, which must stay unchanged.
        Buffer rayMemory(rays.size() * sizeof(TestRay)),
            results((count + 1) * sizeof(LoopResult), 0xAB), params(sizeof(LoopParams)),
            records(6 * sizeof(Record));
        std::memcpy(rayMemory.data(), rays.data(), rayMemory.size());
        const LoopParams values = {static_cast<const TestRay*>(rayMemory.data()),
                                   static_cast<LoopResult*>(results.data()),
                                   structure_.handle(),
                                   unsigned(rays.size()),
                                   job.flags,
                                   job.most,
                                   job.throwAt,
                                   job.throwBelow};
        std::memcpy(params.data(), &values, sizeof(values));
        // The programs' numbers are their places in the file.
        Record all[] = {recordOf(kFirstGroup, devlib::kGroupRaygen),
                        recordOf(kFirstGroup + 1, devlib::kGroupMiss),
                        recordOf(kFirstGroup + 2, devlib::kGroupHit),
                        recordOf(kFirstGroup + 4, devlib::kGroupException),
                        recordOf(kFirstGroup + 5, devlib::kGroupCallables),
                        recordOf(kFirstGroup + 6, devlib::kGroupCallables)};
        all[4].data[0] = 1000;
        all[5].data[0] = 2000;
        std::memcpy(records.data(), all, sizeof(all));
        devlib::LaunchBlock block{};
        block.launch.params = params.data();
        devlib::SbtView& sbt = block.launch.sbt;
        sbt.entryRecord = records.address();
        sbt.missBase = sbt.entryRecord + sizeof(Record);
        sbt.hitBase = sbt.missBase + sizeof(Record);
        sbt.exceptionRecord = job.hasExceptionRecord ? sbt.hitBase + sizeof(Record) : 0;
        sbt.callableBase = sbt.hitBase + 2 * sizeof(Record);
        sbt.missStride = sbt.hitStride = sbt.callableStride = sizeof(Record);
        sbt.missCount = sbt.hitCount = 1;
        sbt.callableCount = 2;
        kernel.patience = job.patience;
        if (kernel.feedback.find("kernel: one thread for each launch index") == std::string::npos)
            kernel.blockThreads = job.blockThreads;
        kernel.maxTraceDepth = job.maxTraceDepth;
        *report = kernel.launch(block, job.width, job.height, job.depth);
        const auto* found = static_cast<const LoopResult*>(results.data());
        EXPECT_EQ(found[count].hits, 0xABABABABu);
        return {found, found + count};
    }

    // Runs all kernels, expects equal results, and returns them for further checks.
    std::vector<LoopResult> same(const Job& job, devlib::LaunchReport* report = nullptr) const {
        devlib::LaunchReport wantedReport, foundReport;
        const std::vector<LoopResult> wanted = run(whole(), job, &wantedReport);
        for (Kernel* kernel : {&cut(), &nested(), &apart(), &ready(), &callables(),
                               &readyCallables(), &wholeCallables(), &otherTypes()}) {
            SCOPED_TRACE(kernel->feedback);
            const std::vector<LoopResult> found = run(*kernel, job, &foundReport);
            for (size_t i = 0; i < wanted.size(); ++i) {
                EXPECT_EQ(found[i].traces, wanted[i].traces) << i;
                EXPECT_EQ(found[i].hits, wanted[i].hits) << i;
                EXPECT_EQ(found[i].checksum, wanted[i].checksum) << i;
                EXPECT_EQ(found[i].thrown, wanted[i].thrown) << i;
                if (testing::Test::HasFailure())
                    break;
            }
            EXPECT_EQ(foundReport.fatal, wantedReport.fatal);
            EXPECT_EQ(foundReport.unseen, wantedReport.unseen);
            EXPECT_EQ(foundReport.raised, wantedReport.raised);
        }
        if (report)
            *report = foundReport;
        return wanted;
    }

    bvh::gpu::testing::GpuStructure structure_;
};

TEST_F(GpuLoop, FeedbackTellsTheKernel) {
    EXPECT_NE(cut().feedback.find("warps take new launch indices"), std::string::npos)
        << cut().feedback;
    EXPECT_NE(whole().feedback.find("one thread for each launch index, because no ray generation"),
              std::string::npos)
        << whole().feedback;
    EXPECT_NE(
        whole().feedback.find("while a ray is traced, because the depth of traces is not known"),
        std::string::npos)
        << whole().feedback;
    EXPECT_NE(nested().feedback.find("rays of all depths take turns"), std::string::npos)
        << nested().feedback;
    EXPECT_NE(ready().feedback.find("kernel: ready, optix7, graph 0, shapes 0, motion 0, depth 6"),
              std::string::npos)
        << ready().feedback;
    EXPECT_NE(callables().feedback.find("callables that trace are part of their callers, at 2 "
                                        "calls\nkernel: rays of all depths take turns"),
              std::string::npos)
        << callables().feedback;
    EXPECT_NE(readyCallables().feedback.find("callables that trace are part of their callers, at 2 "
                                             "calls\nkernel: ready, optix7, graph 0"),
              std::string::npos)
        << readyCallables().feedback;
    for (const Kernel* kernel : {&wholeCallables(), &otherTypes()})
        EXPECT_EQ(kernel->feedback.find("callables that trace"), std::string::npos)
            << kernel->feedback;
    // In a cut program a lane may be elsewhere while others wait for it at a barrier.
    std::string text = textOf(TEST_LOOP_PTX);
    const size_t entry = text.find(".entry __raygen__loop"), brace = text.find("ret;", entry);
    text.insert(brace, "bar.warp.sync -1;\n");
    EXPECT_NE(compileCode(text, oneHitGroup()).feedback.find("lanes of a warp meet"),
              std::string::npos);
    EXPECT_NE(
        compileCode(text, oneHitGroup(kMostDepth))
            .feedback.find(
                "while a ray is traced, because a program has instructions at which the lanes"),
        std::string::npos);
}

TEST_F(GpuLoop, LongProgramsAreCalledByAddress) {
    const auto parts = [](const Options& options) {
        const std::string text = compile(textOf(TEST_LOOP_TWO_PTX), options);
        size_t count = 0;
        for (size_t at = text.find("_$_apart("); at != text.npos;
             at = text.find("_$_apart(", at + 1))
            ++count;
        return count;
    };
    EXPECT_GE(parts(apartOptions()), 2u);
    EXPECT_EQ(parts(oneHitGroup(kMostDepth)), 0u);
}

// Some lanes throw, and warps end before others of their block.
TEST_F(GpuLoop, WarpsOfABlockWaitForEachOther) {
    for (const unsigned patience : {devlib::kTilePatience, devlib::kDepthPatience})
        for (const unsigned threads : {64u, 128u, 512u}) {
            SCOPED_TRACE(threads);
            Job job;
            job.width = 1000;
            job.patience = patience | devlib::kWithBlock;
            job.blockThreads = threads;
            job.throwAt = 3;
            size_t hits = 0, thrown = 0;
            for (const LoopResult& result : same(job)) {
                hits += result.hits;
                thrown += result.thrown != 0;
            }
            EXPECT_GT(hits, 500u);
            EXPECT_GT(thrown, 0u);
        }
}

TEST_F(GpuLoop, TripCountsThatDiffer) {
    for (unsigned patience : {1u, 60u, 1000000u, devlib::kTilePatience, devlib::kDepthPatience}) {
        Job job;
        job.width = 150;
        job.patience = patience;
        const std::vector<LoopResult> results = same(job);
        size_t traces = 0, hits = 0, left = 0;
        for (const LoopResult& result : results) {
            traces += result.traces;
            hits += result.hits;
            left += result.hits == 4;
        }
        EXPECT_GT(traces, 200u);
        EXPECT_GT(hits, 50u);
        EXPECT_GT(left, 0u);
        EXPECT_EQ(results[0].traces, 0u); // never traces
        EXPECT_EQ(results[13].traces, 1u);
    }
}

TEST_F(GpuLoop, Shapes) {
    const unsigned shapes[][3] = {{1, 1, 1}, {3, 1, 1}, {33, 1, 1}, {13, 7, 1},
                                  {9, 5, 3}, {5, 1, 9}, {1, 9, 2}};
    for (const auto& shape : shapes) {
        Job job;
        job.width = shape[0];
        job.height = shape[1];
        job.depth = shape[2];
        same(job);
    }
}

TEST_F(GpuLoop, AnyHitProgramsEndRays) {
    Job job;
    job.width = 90;
    job.flags = 0;
    const std::vector<LoopResult> filtered = same(job);
    job.flags = 4; // TERMINATE_ON_FIRST_HIT
    same(job);
    job.flags = 1 | 8; // DISABLE_ANYHIT, DISABLE_CLOSESTHIT
    for (const LoopResult& result : same(job))
        EXPECT_EQ(result.hits, 0u);
    size_t hits = 0;
    for (const LoopResult& result : filtered)
        hits += result.hits;
    EXPECT_GT(hits, 0u);
}

TEST_F(GpuLoop, TraceDepth) {
    for (unsigned depth = 0; depth <= kMostDepth; ++depth) {
        Job job;
        job.width = 70;
        job.maxTraceDepth = depth;
        size_t hits = 0;
        for (const LoopResult& result : same(job))
            hits += result.hits;
        EXPECT_EQ(hits == 0, depth == 0);
    }
}

TEST_F(GpuLoop, ExceptionsEndTheirIndexAlone) {
    for (unsigned throwAt : {0u, 3u}) {
        Job job;
        job.width = 40;
        job.height = 6;
        job.throwAt = throwAt;
        const std::vector<LoopResult> results = same(job);
        for (unsigned i = 0; i < results.size(); ++i)
            if (i % 5 == throwAt && i % job.most != 0)
                EXPECT_EQ(results[i].thrown, 1 + i);
            else
                EXPECT_LE(results[i].traces, 5u) << i;
    }
}

// A trace from a closest-hit program while another one waits for its ray.
TEST_F(GpuLoop, ExceptionsBelowWaitingPrograms) {
    Job job;
    job.width = 200;
    job.throwBelow = 2;
    size_t thrown = 0;
    const std::vector<LoopResult> results = same(job);
    for (unsigned i = 0; i < results.size(); ++i) {
        if (results[i].thrown == 0)
            continue;
        EXPECT_EQ(i % 5, 2u);
        EXPECT_EQ(results[i].thrown, 1001u);
        ++thrown;
    }
    EXPECT_GT(thrown, 5u);
}

TEST_F(GpuLoop, ExceptionsNobodySees) {
    Job job;
    job.width = 100;
    job.throwAt = 3;
    job.hasExceptionRecord = false;
    devlib::LaunchReport report;
    same(job, &report);
    EXPECT_EQ(report.unseen, uint64_t(3) << 32 | 3); // of launch index 3, with its number as code
}

TEST_F(GpuLoop, RecordsOfOtherGroupsAreReported) {
    Buffer records(sizeof(Record));
    const Record record = recordOf(kFirstGroup + 1, devlib::kGroupMiss);
    std::memcpy(records.data(), &record, sizeof(record));
    devlib::LaunchBlock block{};
    block.launch.sbt.entryRecord = records.address();
    for (Kernel* kernel : {&cut(), &nested(), &apart(), &ready()})
        EXPECT_EQ(kernel->launch(block, 40, 3, 1).fatal,
                  uint64_t(uint32_t(devlib::kFatalRaygenRecord)));
}

} // namespace
} // namespace sunstone
