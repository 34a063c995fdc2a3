// SPDX-License-Identifier: Apache-2.0
// Compares kernels that run a warp at a time with the same kernels thread by thread.
#include <cuda.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace {

struct Shape {
    unsigned block[3];
    unsigned grid[3];
};

// Whole and partial warps, one and many, in one to three dimensions.
constexpr Shape kShapes[] = {
    {{256, 1, 1}, {4, 1, 1}}, {{1024, 1, 1}, {2, 1, 1}}, {{33, 1, 1}, {3, 1, 1}},
    {{16, 16, 1}, {2, 2, 1}}, {{8, 4, 3}, {2, 1, 2}},    {{7, 1, 1}, {5, 1, 1}},
    {{100, 3, 1}, {1, 2, 1}}, {{32, 2, 1}, {3, 1, 1}},
};

const char* const kKernels[] = {
    "rotateThroughShared",
    "treeInShared",
    "endBeforeTheBarrier",
    "nestedLoops",
    "barrierInUniformBranch",
    "barriersThatCount",
    "shuffles",
    "divergentShuffles",
    "shufflesFromTwoPlaces",
    "tiles",
    "votes",
    "matches",
    "differentRounds",
    "exchangesOfThoseLeft",
    "oneOfTheRounds",
    "breaksAndContinues",
    "localMemory",
    "numbers",
    "bytesAndPairs",
    "someWrite",
    "indirections",
    "atomics",
    "locks",
    "waitsForTheLast",
    "waitsInRounds",
    "namedBarriers",
    "arrivals",
    "sumsInFunctions",
    "matrix",
    "wideSteps",
    "farSteps",
    "unevenSteps",
    "products",
    "barrierObjects",
};

class Lockstep : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context_, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context_), CUDA_SUCCESS);
    }
    void TearDown() override {
        unsetenv("SUNSTONE_KERNELS");
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    CUmodule load(const std::string& text) {
        CUmodule module = nullptr;
        EXPECT_EQ(cuModuleLoadData(&module, text.c_str()), CUDA_SUCCESS);
        return module;
    }
    CUfunction find(CUmodule module, const char* name) {
        CUfunction function = nullptr;
        EXPECT_EQ(cuModuleGetFunction(&function, module, name), CUDA_SUCCESS) << name;
        return function;
    }
    static std::vector<unsigned> input() {
        std::vector<unsigned> words(6000);
        unsigned state = 12345;
        for (unsigned& word : words) {
            state = state * 1664525 + 1013904223;
            word = state >> 3;
        }
        return words;
    }
    // The kernel's output; `result` its error.
    std::vector<unsigned> run(CUfunction function, const Shape& shape, const char* way,
                              CUresult* result) {
        setenv("SUNSTONE_KERNELS", way, 1);
        const auto& [block, grid] = shape;
        const unsigned perBlock = block[0] * block[1] * block[2];
        std::vector<unsigned> in = input(), out(perBlock * grid[0] * grid[1] * grid[2], 0xabababab);
        int n = int(in.size());
        in.resize(in.size() + 1024, 5); // searches in `in` end here at the latest
        const unsigned* from = in.data();
        unsigned* to = out.data();
        void* params[] = {&from, &to, &n};
        *result = cuLaunchKernel(function, grid[0], grid[1], grid[2], block[0], block[1], block[2],
                                 perBlock * 4, nullptr, params, nullptr);
        if (*result == CUDA_SUCCESS)
            *result = cuCtxSynchronize();
        return out;
    }
    // Runs all kernels of a file both ways, in the first shapes. way: "lockstep" or "runs", the
    // form of compilation.
    void compareBoth(const char* path, const char* way, size_t shapes = std::size(kShapes)) {
        setenv("SUNSTONE_KERNELS", way, 1);
        std::ifstream file(path);
        const std::string text((std::istreambuf_iterator<char>(file)),
                               std::istreambuf_iterator<char>());
        ASSERT_FALSE(text.empty());
        CUmodule module = load(text);
        for (const char* name : kKernels) {
            CUfunction function = find(module, name);
            for (const Shape& shape : std::span(kShapes).first(shapes)) {
                SCOPED_TRACE(testing::Message()
                             << name << " in blocks of " << shape.block[0] << " x "
                             << shape.block[1] << " x " << shape.block[2]);
                CUresult single = CUDA_SUCCESS, together = CUDA_SUCCESS;
                const std::vector<unsigned> seen = run(function, shape, way, &together);
                const std::vector<unsigned> expected = run(function, shape, "single", &single);
                EXPECT_EQ(single, CUDA_SUCCESS);
                ASSERT_EQ(together, CUDA_SUCCESS);
                size_t different = 0, first = 0;
                for (size_t i = seen.size(); i-- > 0;)
                    if (seen[i] != expected[i]) {
                        ++different;
                        first = i;
                    }
                EXPECT_EQ(different, 0u)
                    << "first " << first << ": " << seen[first] << " not " << expected[first];
            }
        }
        EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    }

    CUcontext context_ = nullptr;
};

TEST_F(Lockstep, LeavesWhatSingleThreadsLeave) {
    compareBoth(LOCKSTEP_PTX, "lockstep");
}

TEST_F(Lockstep, LeavesTheSameByRuns) {
    compareBoth(LOCKSTEP_PTX, "runs");
}

TEST_F(Lockstep, LeavesTheSameWhereSubnormalsAreFlushed) {
    compareBoth(FLUSHED_PTX, "lockstep", 2);
    compareBoth(FLUSHED_PTX, "runs", 2);
}

// Indices that are consecutive except for a jump by 2^32 do not count as neighbours.
TEST_F(Lockstep, IndicesMayWrap) {
    std::ifstream file(LOCKSTEP_PTX);
    const std::string text((std::istreambuf_iterator<char>(file)),
                           std::istreambuf_iterator<char>());
    CUmodule module = load(text);
    constexpr size_t kSpan = size_t(1) << 32, kEdge = 65536;
    void* memory = mmap(nullptr, kSpan + kEdge, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    ASSERT_NE(memory, MAP_FAILED);
    auto* bytes = static_cast<unsigned char*>(memory);
    for (const bool isSigned : {false, true}) {
        // The elements with the largest indices are at the end of the mapping, 0 or the smallest at
        // its beginning.
        unsigned char* base = isSigned ? bytes + kSpan / 2 : bytes;
        const unsigned start = (isSigned ? 0x7fffffffu : 0xffffffffu) - 20;
        const auto at = [&](unsigned i) -> unsigned char& {
            const unsigned index = start + i;
            return isSigned ? base[int(index)] : base[index];
        };
        for (unsigned i = 0; i < 64; ++i)
            at(i) = static_cast<unsigned char>(3 * i);
        void* params[] = {&base, &base, const_cast<unsigned*>(&start)};
        CUfunction function = find(module, isSigned ? "wrappedSignedIndices" : "wrappedIndices");
        ASSERT_EQ(cuLaunchKernel(function, 1, 1, 1, 64, 1, 1, 0, nullptr, params, nullptr),
                  CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
        for (unsigned i = 0; i < 64; ++i)
            EXPECT_EQ(at(i), static_cast<unsigned char>(3 * i + 1)) << i << isSigned;
    }
    munmap(memory, kSpan + kEdge);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
}

std::string kernelText(const std::string& name, const std::string& body) {
    return std::string(".version 7.0\n.target sm_70\n.address_size 64\n.visible .entry ") + name +
           "(.param .u64 in, .param .u64 out, .param .u32 n) {\n"
           ".reg .b32 %r<16>; .reg .b64 %rd<6>; .reg .pred %p<6>;\n"
           "mov.u32 %r1, %tid.x;\n" +
           body + "ret;\n}\n";
}

// Loops that lanes leave at different times. Each thread's result is %r9.
std::string loopText(const std::string& loop) {
    return kernelText("loops",
                      "ld.param.u64 %rd1, [in]; ld.param.u64 %rd2, [out];\n"
                      "ld.param.u32 %r2, [n]; mov.u32 %r9, 0;\n"
                      "vote.sync.ballot.b32 %r3, 1, -1;\n" + // so that it is a kernel of warps
                          loop +
                          "mov.u32 %r3, %ctaid.x; mov.u32 %r4, %ntid.x;\n"
                          "mad.lo.u32 %r3, %r3, %r4, %r1; mad.wide.u32 %rd3, %r3, 4, %rd2;\n"
                          "st.global.u32 [%rd3], %r9;\n");
}

TEST_F(Lockstep, WhatLanesTakeOutOfLoops) {
    std::string longHead;
    for (int i = 0; i < 12; ++i)
        longHead += "mad.lo.u32 %r11, %r11, 5, %r5; xor.b32 %r11, %r11, 77;\n";
    const std::string loops[] = {
        // The values that lanes read in their last round, which differs between lanes.
        "and.b32 %r5, %r1, 15; mov.u64 %rd3, %rd1; mov.u32 %r6, 0;\n"
        "A: ld.global.u32 %r9, [%rd3]; add.u64 %rd3, %rd3, 4; add.u32 %r6, %r6, 1;\n"
        "and.b32 %r7, %r9, 15; setp.ne.u32 %p1, %r7, %r5; setp.lt.u32 %p2, %r6, 500;\n"
        "and.pred %p1, %p1, %p2; @%p1 bra A;\n",
        // Found or not: lanes that end the inner loop together, in different iterations of the
        // outer loop, reach one place by two paths. Computations in their heads prevent the
        // rotation of the loops.
        "and.b32 %r5, %r1, 7; mov.u32 %r6, 0; mov.u32 %r11, 1;\n"
        "A: " +
            longHead +
            "setp.eq.u32 %p1, %r6, 12; mov.u32 %r9, 77; @%p1 bra D; mov.u32 %r7, 0;\n"
            "B: " +
            longHead +
            "setp.eq.u32 %p1, %r7, 3; mov.u32 %r9, 55; @%p1 bra D;\n"
            "mad.lo.u32 %r8, %r6, 3, %r7; mad.wide.u32 %rd3, %r8, 4, %rd1; ld.global.u32 %r10, "
            "[%rd3];\n"
            "add.u32 %r7, %r7, 1; and.b32 %r10, %r10, 7; setp.gt.u32 %p1, %r10, %r5; @!%p1 bra B;\n"
            "add.u32 %r6, %r6, 1; bra A;\n"
            "D: xor.b32 %r9, %r9, %r11;\n",
        // Two ways out of one block, which reads for each lane.
        "mov.u32 %r11, 1; mov.u32 %r6, 0;\n"
        "A: mad.lo.u32 %r5, %r6, 32, %r1; mad.wide.u32 %rd3, %r5, 4, %rd1;\n"
        "ld.global.u32 %r7, [%rd3]; mad.lo.u32 %r11, %r11, 3, %r7;\n"
        "and.b32 %r8, %r7, 31; setp.eq.u32 %p1, %r8, 5; setp.lt.u32 %p2, %r8, 3;\n"
        "selp.u32 %r9, 1, 2, %p2; add.u32 %r6, %r6, %r9; @%p1 bra B; @!%p2 bra A;\n"
        "mad.lo.u32 %r9, %r11, 7, %r9; bra C;\n"
        "B: add.u32 %r9, %r11, %r6; C: xor.b32 %r9, %r9, %r6;\n",
        // Threads enter a loop again in each iteration of an outer loop, and meet in it. Its
        // iterations are counted in memory.
        "mov.u32 %r5, %ctaid.x; mov.u32 %r6, %ntid.x; mad.lo.u32 %r5, %r5, %r6, %r1;\n"
        "mad.wide.u32 %rd4, %r5, 4, %rd2; mov.u32 %r6, 0; st.global.u32 [%rd4], %r6;\n"
        "A: mad.wide.u32 %rd3, %r6, 4, %rd1; ld.global.u32 %r7, [%rd3]; and.b32 %r7, %r7, 1;\n"
        "setp.eq.u32 %p1, %r7, 0; @%p1 bra C; mov.u32 %r10, 1;\n"
        "B: ld.global.u32 %r11, [%rd4]; add.u32 %r11, %r11, 1; st.global.u32 [%rd4], %r11;\n"
        "bar.sync 0; mad.lo.u32 %r10, %r10, 3, %r1;\n"
        "and.b32 %r11, %r11, 3; setp.ne.u32 %p2, %r11, 3; @%p2 bra B; add.u32 %r9, %r9, %r10;\n"
        "C: add.u32 %r6, %r6, 1; setp.lt.u32 %p1, %r6, 9; @%p1 bra A;\n",
    };
    for (const std::string& loop : loops) {
        SCOPED_TRACE(loop);
        for (const char* way : {"lockstep", "runs"}) {
            SCOPED_TRACE(way);
            CUmodule module = load(loopText(loop));
            CUfunction function = find(module, "loops");
            const Shape shape = {{96, 1, 1}, {2, 1, 1}};
            CUresult single = CUDA_SUCCESS, together = CUDA_SUCCESS;
            const std::vector<unsigned> seen = run(function, shape, way, &together);
            EXPECT_EQ(seen, run(function, shape, "single", &single));
            EXPECT_EQ(single, CUDA_SUCCESS);
            EXPECT_EQ(together, CUDA_SUCCESS);
            EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
        }
    }
}

TEST_F(Lockstep, LanesThatHaveEndedAreReported) {
    const std::string ends = "setp.ge.u32 %p1, %r1, 20; @%p1 ret;\n";
    struct Case {
        const char* name;
        std::string body;
        bool isReported;
    };
    const Case cases[] = {
        {"named", ends + "shfl.sync.bfly.b32 %r2, %r1, 1, 31, -1;\n", true},
        {"votes", ends + "vote.sync.ballot.b32 %r2, 1, -1;\n", true},
        {"alone", ends + "shfl.sync.bfly.b32 %r2, %r1, 1, 31, 0xfffff;\n", false},
        {"partial", "vote.sync.ballot.b32 %r2, 1, -1;\n", false}, // lanes that never were
    };
    for (const char* way : {"lockstep", "single", "runs"})
        for (const Case& one : cases) {
            // The log has the report once per name.
            const std::string name = one.name + std::string(way);
            SCOPED_TRACE(name);
            CUmodule module = load(kernelText(name, one.body));
            CUresult result = CUDA_SUCCESS;
            testing::internal::CaptureStderr();
            run(find(module, name.c_str()), {{24, 1, 1}, {1, 1, 1}}, way, &result);
            const std::string log = testing::internal::GetCapturedStderr();
            EXPECT_EQ(result, CUDA_SUCCESS);
            EXPECT_EQ(log.find("kernel " + name +
                               ": a shuffle or vote names lanes that have ended") != log.npos,
                      one.isReported)
                << log;
            EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
        }
}

// Programs that rely on lockstep without warp functions. Each thread's result is %r9.
TEST_F(Lockstep, KernelsThatCountOnStepsHaveThem) {
    struct Case {
        const char* name;
        std::string body;
        unsigned (*expected)(unsigned thread);
    };
    std::string longWork = "mov.u32 %r15, %r1;\n"; // which the optimiser has to keep
    for (int i = 0; i < 400; ++i)
        longWork += "mad.lo.u32 %r15, %r15, %r15, %r1; xor.b32 %r15, %r15, 3;\n";
    const std::string afterwards =
        "setp.eq.u32 %p5, %r15, 123456789; @%p5 st.global.u32 [%rd3], %r15;\n";
    const std::string counter = "ld.param.u64 %rd4, [in]; ld.global.u32 %r9, [%rd4];\n"
                                "setp.ne.u32 %p1, %r1, 0; @%p1 bra A;\n"
                                "atom.global.add.u32 %r6, [%rd4], 100;\nA:\n";
    const Case cases[] = {
        // All lanes read a counter before lane 0 increments it.
        {"counter", counter, [](unsigned) { return 7u; }},
        // Lane 31 clears a word before all lanes set bits of it.
        {"cleared",
         "ld.param.u64 %rd4, [in]; setp.ne.u32 %p1, %r1, 31; @%p1 bra A;\n"
         "mov.u32 %r6, 0; st.global.u32 [%rd4], %r6;\nA: mov.u32 %r6, 1; shl.b32 %r6, %r6, %r1;\n"
         "atom.global.or.b32 %r7, [%rd4], %r6; ld.global.u32 %r9, [%rd4];\n",
         [](unsigned) { return ~0u; }},
        // Neighbours exchange values through memory, volatile and shared.
        {"volatileNeighbours",
         "ld.param.u64 %rd4, [in]; mad.wide.u32 %rd4, %r1, 4, %rd4; st.volatile.global.u32 [%rd4], "
         "%r1;\nsetp.eq.u32 %p1, %r1, 31; mov.u32 %r9, 0; @%p1 bra A;\n"
         "ld.volatile.global.u32 %r9, [%rd4+4];\nA:\n",
         [](unsigned thread) { return thread == 31 ? 0 : thread + 1; }},
        {"sharedNeighbours",
         "{ .shared .align 4 .b8 words[128]; mov.u32 %r4, words; mad.lo.u32 %r4, %r1, 4, %r4;\n"
         "st.shared.u32 [%r4], %r1; xor.b32 %r5, %r1, 31; mov.u32 %r4, words;\n"
         "mad.lo.u32 %r4, %r5, 4, %r4; ld.shared.u32 %r9, [%r4]; }\n",
         [](unsigned thread) { return thread ^ 31; }},
    };
    for (const char* way : {"lockstep", "runs", "long"})
        for (const Case& one : cases) {
            SCOPED_TRACE(testing::Message() << one.name << " " << way);
            const bool isLong = std::string(way) == "long";
            setenv("SUNSTONE_KERNELS", isLong ? "lockstep" : way, 1);
            CUmodule module = load(kernelText(
                one.name, "mov.u32 %r9, 0;\n" + (isLong ? longWork : "") + one.body +
                              "ld.param.u64 %rd2, [out]; mad.wide.u32 %rd3, %r1, 4, %rd2;\n"
                              "st.global.u32 [%rd3], %r9;\n" +
                              (isLong ? afterwards : "")));
            std::vector<unsigned> words(64, 7), out(32, 0xabababab);
            unsigned *in = words.data(), *to = out.data();
            unsigned n = 32;
            void* params[] = {&in, &to, &n};
            ASSERT_EQ(cuLaunchKernel(find(module, one.name), 1, 1, 1, 32, 1, 1, 0, nullptr, params,
                                     nullptr),
                      CUDA_SUCCESS);
            ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
            for (unsigned thread = 0; thread < 32; ++thread)
                EXPECT_EQ(out[thread], one.expected(thread)) << thread;
            EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
        }
}

TEST_F(Lockstep, KernelsOfWarpsThatRunByThreadAreReported) {
    const std::string vote = "vote.sync.ballot.b32 %r2, 1, -1;\n";
    std::string debugged = kernelText("debugged", vote);
    debugged.replace(debugged.find("sm_"), 5, "sm_70, debug");
    const std::pair<std::string, std::string> cases[] = {
        {debugged, "kernel debugged runs thread by thread: it was compiled for debugging"},
        {kernelText("usual", vote), ""}};
    for (const auto& [text, expected] : cases) {
        CUmodule module = load(text);
        CUresult result = CUDA_SUCCESS;
        testing::internal::CaptureStderr();
        run(find(module, expected.empty() ? "usual" : "debugged"), {{32, 1, 1}, {1, 1, 1}},
            "lockstep", &result);
        const std::string log = testing::internal::GetCapturedStderr();
        EXPECT_EQ(result, CUDA_SUCCESS);
        EXPECT_EQ(log.find("thread by thread") == log.npos, expected.empty()) << log;
        EXPECT_NE(log.find(expected), log.npos) << log;
        EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    }
}

// Code for a debugger runs in lockstep if lanes exchange values through memory: volatile, in a
// function that the kernel calls; by atomics; shared. With single threads, a warning names the
// kernel. Other kernels keep their code for the debugger.
TEST_F(Lockstep, KernelsForDebuggersKeepStepWhereLanesExchangeValues) {
    struct Case {
        const char* name;
        std::string body;
        unsigned (*expected)(unsigned thread);
        bool countsOnSteps;
    };
    const Case cases[] = {
        {"volatileWords",
         "ld.param.u64 %rd4, [in]; mad.wide.u32 %rd4, %r1, 4, %rd4;\n"
         "{ .param .b64 a; .param .b32 r; st.param.b64 [a], %rd4;\n"
         "call.uni (r), exchange, (a); ld.param.b32 %r9, [r]; }\n",
         [](unsigned thread) { return thread == 31 ? 7 : thread + 1; }, true},
        {"counter",
         "ld.param.u64 %rd4, [in]; ld.global.u32 %r9, [%rd4];\n"
         "{ .param .b64 a; st.param.b64 [a], %rd4; setp.ne.u32 %p1, %r1, 0; @%p1 bra A;\n"
         "call.uni raise, (a); }\nA:\n",
         [](unsigned) { return 7u; }, true},
        {"sharedWords",
         "{ .shared .align 4 .b8 words[128]; mov.u32 %r4, words; mad.lo.u32 %r4, %r1, 4, %r4;\n"
         "st.shared.u32 [%r4], %r1; xor.b32 %r5, %r1, 31; mov.u32 %r4, words;\n"
         "mad.lo.u32 %r4, %r5, 4, %r4; ld.shared.u32 %r9, [%r4]; }\n",
         [](unsigned thread) { return thread ^ 31; }, true},
        {"histogram",
         "ld.param.u64 %rd4, [in]; and.b32 %r5, %r1, 3; mad.wide.u32 %rd4, %r5, 4, %rd4;\n"
         "red.global.add.u32 [%rd4], 1; mov.u32 %r9, %r1;\n",
         [](unsigned thread) { return thread; }, false},
    };
    const std::string functions =
        ".func (.param .b32 r) exchange(.param .b64 a) {\n"
        ".reg .b64 %p; .reg .b32 %t; ld.param.b64 %p, [a]; mov.u32 %t, %laneid;\n"
        "st.volatile.u32 [%p], %t; ld.volatile.u32 %t, [%p+4];\n"
        "st.param.b32 [r], %t; ret; }\n"
        ".func raise(.param .b64 a) {\n"
        ".reg .b64 %p; .reg .b32 %t; ld.param.b64 %p, [a];\n"
        "atom.add.u32 %t, [%p], 100; ret; }\n";
    for (const Case& one : cases)
        for (const bool inStep : {true, false}) {
            SCOPED_TRACE(testing::Message() << one.name << " in step " << inStep);
            std::string text = kernelText(
                one.name, one.body + "ld.param.u64 %rd2, [out]; mad.wide.u32 %rd3, %r1, 4, %rd2;\n"
                                     "st.global.u32 [%rd3], %r9;\n");
            text.replace(text.find("sm_"), 5, "sm_70, debug");
            text.insert(text.find(".visible"), functions);
            setenv("SUNSTONE_KERNELS", inStep ? "lockstep" : "single", 1);
            testing::internal::CaptureStderr();
            CUmodule module = load(text);
            std::vector<unsigned> words(64, 7), out(32, 0xabababab);
            unsigned *in = words.data(), *to = out.data();
            unsigned n = 32;
            void* params[] = {&in, &to, &n};
            EXPECT_EQ(cuLaunchKernel(find(module, one.name), 1, 1, 1, 32, 1, 1, 0, nullptr, params,
                                     nullptr),
                      CUDA_SUCCESS);
            EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
            const std::string log = testing::internal::GetCapturedStderr();
            EXPECT_EQ(log.find("thread by thread") != log.npos, one.countsOnSteps && !inStep)
                << log;
            for (unsigned thread = 0; thread < 32 && (inStep || !one.countsOnSteps); ++thread)
                EXPECT_EQ(out[thread], one.expected(thread)) << thread;
            EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
        }
}

TEST_F(Lockstep, ActiveLanesOfTheLastRound) {
    for (const char* way : {"lockstep", "runs"}) {
        CUmodule module =
            load(loopText("and.b32 %r5, %r1, 7; mov.u32 %r6, 0; mov.u32 %r7, 0;\n"
                          "A: activemask.b32 %r9; add.u32 %r6, %r6, 1; xor.b32 %r7, %r7, %r9;\n"
                          "setp.le.u32 %p1, %r6, %r5; @%p1 bra A; st.global.u32 [%rd2], %r7;\n"));
        CUresult result = CUDA_SUCCESS;
        const std::vector<unsigned> masks =
            run(find(module, "loops"), {{64, 1, 1}, {2, 1, 1}}, way, &result);
        ASSERT_EQ(result, CUDA_SUCCESS);
        for (size_t i = 0; i < masks.size(); ++i)
            EXPECT_TRUE(masks[i] >> i % 32 & 1) << way << " " << i << " " << masks[i];
        EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    }
}

// Lanes at different instructions do not run together. Otherwise votes among active lanes, of which
// some are at another vote, may never agree.
TEST_F(Lockstep, ActiveLanesAreAtOneInstruction) {
    for (const char* way : {"single", "lockstep", "runs"}) {
        CUmodule module =
            load(loopText("and.b32 %r5, %r1, 1; setp.eq.u32 %p1, %r5, 0; @%p1 bra A;\n"
                          "activemask.b32 %r9; add.u32 %r9, %r9, 1; bra B;\n"
                          "A: activemask.b32 %r9; add.u32 %r9, %r9, 2; B:\n"));
        CUresult result = CUDA_SUCCESS;
        const std::vector<unsigned> masks =
            run(find(module, "loops"), {{64, 1, 1}, {2, 1, 1}}, way, &result);
        ASSERT_EQ(result, CUDA_SUCCESS);
        for (size_t i = 0; i < masks.size(); ++i)
            EXPECT_EQ(masks[i], i % 2 ? 0xAAAAAAABu : 0x55555557u) << way << " " << i;
        EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    }
}

// Errors end a launch in both forms of the kernel.
TEST_F(Lockstep, ErrorsAreTheSame) {
    struct Bad {
        const char* body;
        CUresult result;
    };
    const Bad cases[] = {
        // Half of the threads wait at a point that the others never reach.
        {"setp.lt.u32 %p1, %r1, 16; @%p1 bra A; bar.sync 1; bra B; A: bar.sync 2; B:\n",
         CUDA_ERROR_LAUNCH_FAILED},
        // A barrier of more threads than there are.
        {"setp.lt.u32 %p1, %r1, 4; @%p1 bar.sync 3, 64; bar.sync 0;\n", CUDA_ERROR_LAUNCH_FAILED},
        // One thread traps before a barrier.
        {"setp.ne.u32 %p1, %r1, 37; @%p1 bra A; trap; A: bar.sync 0;\n", CUDA_ERROR_LAUNCH_FAILED},
        // One thread traps, the others wait for it in memory.
        {"ld.param.u64 %rd1, [out]; setp.ne.u32 %p1, %r1, 63; @%p1 bra A; trap;\n"
         "A: ld.volatile.global.u32 %r2, [%rd1]; setp.ne.u32 %p2, %r2, 1; @%p2 bra A;\n",
         CUDA_ERROR_LAUNCH_FAILED},
        {"bar.sync 0; mov.u64 %rd1, 16; st.global.u32 [%rd1], %r1;\n", CUDA_ERROR_ILLEGAL_ADDRESS},
        // Null, as the compiler knows: no path may vanish.
        {"bar.sync 0; mov.u64 %rd1, 0; st.global.u32 [%rd1], %r1;\n", CUDA_ERROR_ILLEGAL_ADDRESS},
        {"bar.sync 0; mov.u64 %rd1, 0; setp.gt.u32 %p1, %r1, 999; @%p1 ld.param.u64 %rd1, [in];\n"
         "ld.global.u32 %r2, [%rd1]; ld.param.u64 %rd2, [out]; st.global.u32 [%rd2], %r2;\n",
         CUDA_ERROR_ILLEGAL_ADDRESS},
        {"bar.sync 0; mov.u64 %rd1, 0; proto: .callprototype ()_ (); call %rd1, (), proto;\n",
         CUDA_ERROR_ILLEGAL_ADDRESS},
    };
    for (const char* way : {"single", "lockstep", "runs"}) {
        for (const Bad& bad : cases) {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
            if (bad.result == CUDA_ERROR_ILLEGAL_ADDRESS)
                continue; // a sanitizer reports faults
#endif
#endif
            // The loop of single threads waits for the first of them.
            const bool spins = std::string(bad.body).find("volatile") != std::string::npos;
            if (spins && std::string(way) == "single")
                continue;
            SCOPED_TRACE(testing::Message() << way << ": " << bad.body);
            CUmodule module = load(kernelText("bad", spins ? std::string("bar.sync 0;\n") + bad.body
                                                           : std::string(bad.body)));
            CUfunction function = find(module, "bad");
            CUresult result = CUDA_SUCCESS;
            run(function, {{64, 1, 1}, {3, 1, 1}}, way, &result);
            EXPECT_EQ(result, bad.result);
            ASSERT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
            ASSERT_EQ(cuDevicePrimaryCtxReset(0), CUDA_SUCCESS);
            ASSERT_EQ(cuDevicePrimaryCtxRetain(&context_, 0), CUDA_SUCCESS);
            ASSERT_EQ(cuCtxSetCurrent(context_), CUDA_SUCCESS);
        }
    }
}

// Strong and volatile vectors of up to 16 bytes are whole: a value beside its state (CUB).
TEST_F(Lockstep, StrongVectorsAreWhole) {
    struct Access {
        const char* kind;
        const char *stored, *loaded, *differ;
    };
    const Access accesses[] = {
        {".v2.u32", "{%r4, %r4}", "{%r5, %r6}", "setp.ne.u32 %p3, %r5, %r6;"},
        {".v4.u32", "{%r4, %r4, %r4, %r4}", "{%r5, %r7, %r8, %r6}", "setp.ne.u32 %p3, %r5, %r6;"},
        {".v2.u64", "{%rd2, %rd2}", "{%rd3, %rd4}", "setp.ne.u64 %p3, %rd3, %rd4;"},
    };
    for (const char* way : {"single", "lockstep", "runs"})
        for (const std::string strength : {"relaxed.gpu", "volatile"})
            for (const Access& access : accesses) {
                SCOPED_TRACE(testing::Message() << way << " " << strength << access.kind);
                const std::string kind = strength + ".global" + access.kind;
                const std::string body =
                    "ld.param.u64 %rd1, [out]; mov.u32 %r2, %ctaid.x; mov.u32 %r3, 0;\n"
                    "bar.sync 0; setp.ne.u32 %p1, %r2, 0; @%p1 bra READ;\n"
                    "WRITE: add.u32 %r4, %r1, %r3; mov.b64 %rd2, {%r4, %r4};\n"
                    "st." +
                    kind + " [%rd1], " + access.stored +
                    ";\n"
                    "add.u32 %r3, %r3, 1; setp.lt.u32 %p2, %r3, 5000; @%p2 bra WRITE; bra END;\n"
                    "READ: ld." +
                    kind + " " + access.loaded + ", [%rd1];\n" + access.differ +
                    "@%p3 red.global.add.u32 [%rd1 + 32], 1;\n"
                    "add.u32 %r3, %r3, 1; setp.lt.u32 %p2, %r3, 5000; @%p2 bra READ;\n"
                    "END:\n";
                CUmodule module = load(kernelText("pairs", body));
                CUresult result = CUDA_SUCCESS;
                const auto words =
                    run(find(module, "pairs"), {{32, 1, 1}, {8, 1, 1}}, way, &result);
                EXPECT_EQ(result, CUDA_SUCCESS);
                EXPECT_EQ(words[8], 0xabababab) << "torn pairs: " << words[8] - 0xabababab;
                EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
            }
}

// Blocks that wait in memory for one that has trapped give up.
TEST_F(Lockstep, LoopsThatWaitEndWithTheLaunch) {
    const std::string body = "ld.param.u64 %rd1, [out]; mov.u32 %r3, %ctaid.x;\n"
                             "setp.ne.u32 %p1, %r3, 1; @%p1 bra A; trap;\n"
                             "A: ld.volatile.global.u32 %r2, [%rd1]; setp.eq.u32 %p2, %r2, 1;\n"
                             "@!%p2 bra A;\n";
    CUmodule module = load(kernelText("waits", body));
    CUfunction function = find(module, "waits");
    CUresult result = CUDA_SUCCESS;
    int processors = 0;
    ASSERT_EQ(cuDeviceGetAttribute(&processors, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, 0),
              CUDA_SUCCESS);
    if (processors < 2)
        GTEST_SKIP() << "the block that traps never runs";
    run(function, {{1024, 1, 1}, {unsigned(processors) * 8, 1, 1}}, "single", &result);
    EXPECT_EQ(result, CUDA_ERROR_LAUNCH_FAILED);
}

} // namespace
