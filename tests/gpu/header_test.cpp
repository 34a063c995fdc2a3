// SPDX-License-Identifier: Apache-2.0
// .version and .target of pipelines: LLVM's, unless instructions unknown to it need those of their
// modules.
#include "base/error.h"
#include "compiler/gpu/header.h"
#include "gpu/pipelines.h"
#include "ptx/parse/parser.h"
#include "ptx/printer.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <unistd.h>

namespace sunstone {
namespace {

using namespace gpu_tests;
using compiler::GpuHeader;
using compiler::GpuTarget;

constexpr GpuTarget kHopper = {90, 90}, kOldDriver = {90, 85};

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string withTop(const std::string& version, const std::string& target,
                    const std::string& body) {
    std::string text = raygen(body);
    text.replace(text.find("7.8"), 3, version);
    text.replace(text.find("sm_70"), 5, target);
    return text;
}

std::string pipelineOf(const std::string& text, const GpuTarget& gpu = kHopper) {
    Options options;
    options.target = gpu;
    return compile(text, options);
}

// Whether ptxas of CUDA 13.0, the compiler of that release's driver, compiles it for a GPU.
bool ptxasTakes(const std::string& ptx, const std::string& gpu) {
#ifdef SUNSTONE_PTXAS
    char name[] = "/tmp/sunstone_gpu_XXXXXX";
    const int file = mkstemp(name);
    EXPECT_GE(file, 0);
    close(file);
    std::ofstream(name) << ptx;
    const std::string command =
        SUNSTONE_PTXAS " -arch=" + gpu + " -O0 -o /dev/null " + name + " 2>/dev/null";
    const bool takes = std::system(command.c_str()) == 0;
    unlink(name);
    return takes;
#else
    return (void)ptx, (void)gpu, true;
#endif
}

#ifdef SUNSTONE_PTXAS
constexpr bool kHasPtxas = true;
#else
constexpr bool kHasPtxas = false;
#endif

// An older ptxas refuses newer PTX.
bool readsPtx9() {
    return ptxasTakes(".version 9.0\n.target sm_90\n.address_size 64\n", "sm_90");
}

TEST(GpuHeader, OfLlvm) {
    EXPECT_EQ(compiler::plainHeader(kHopper), (GpuHeader{85, "sm_90"}));
    EXPECT_EQ(compiler::plainHeader({121, 90}), (GpuHeader{85, "sm_90"}));
    EXPECT_EQ(compiler::plainHeader({75, 79}), (GpuHeader{78, "sm_75"}));
}

TEST(GpuHeader, TargetsThatAGpuIs) {
    struct Case {
        const char* target;
        unsigned gpu;
        bool runs;
    };
    for (const auto& [target, gpu, runs] :
         {Case{"sm_90a", 90, true}, {"sm_90a", 100, false}, {"sm_100a", 103, false},
          {"sm_100f", 100, true}, {"sm_100f", 103, true}, {"sm_103f", 100, false},
          {"sm_100f", 120, false}, {"sm_120f", 121, true}, {"sm_90", 75, true}, {"sm_", 90, true},
          {"sm_90x", 90, false}})
        EXPECT_EQ(compiler::runsTarget(target, gpu), runs) << target << " on " << gpu;
}

TEST(GpuHeader, GrowsByWhatModulesDeclare) {
    struct Declared {
        unsigned major, minor;
        const char* target;
    };
    const auto headerOf = [](const GpuTarget& gpu, std::initializer_list<Declared> modules) {
        GpuHeader header = compiler::plainHeader(gpu);
        for (const auto& [major, minor, target] : modules) {
            ptx::Module module;
            module.versionMajor = major;
            module.versionMinor = minor;
            module.target = target;
            compiler::widen(header, module, gpu);
        }
        return header;
    };
    const GpuTarget blackwell = {103, 90};
    EXPECT_EQ(headerOf(kHopper, {{7, 0, "sm_70"}}), (GpuHeader{85, "sm_90"}));
    EXPECT_EQ(headerOf(kHopper, {{8, 6, "sm_90"}}), (GpuHeader{86, "sm_90"}));
    EXPECT_EQ(headerOf(kHopper, {{8, 0, "sm_90a"}}), (GpuHeader{85, "sm_90a"}));
    EXPECT_EQ(headerOf(kHopper, {{8, 7, "sm_90a"}, {9, 0, "sm_80"}}), (GpuHeader{90, "sm_90a"}));
    EXPECT_EQ(headerOf(kOldDriver, {{9, 0, "sm_90a"}}), (GpuHeader{85, "sm_90a"}));
    EXPECT_EQ(headerOf(kHopper, {{12, 34, "sm_90"}}), (GpuHeader{90, "sm_90"}));
    EXPECT_EQ(headerOf(kHopper, {{9, 0, "sm_100"}}), (GpuHeader{90, "sm_90"}));
    EXPECT_EQ(headerOf(blackwell, {{8, 6, "sm_100"}}), (GpuHeader{86, "sm_100"}));
    EXPECT_EQ(headerOf(blackwell, {{8, 8, "sm_100f"}, {8, 8, "sm_103"}}),
              (GpuHeader{88, "sm_103f"}));
    EXPECT_EQ(headerOf(blackwell, {{8, 8, "sm_103a"}, {8, 8, "sm_100f"}}),
              (GpuHeader{88, "sm_103a"}));
    EXPECT_EQ(headerOf(blackwell, {{8, 6, "sm_100a"}}), (GpuHeader{86, "sm_90"})) << "it is not";
}

TEST(GpuHeader, InTheText) {
    const GpuHeader header{90, "sm_90a"};
    EXPECT_EQ(compiler::withHeader("//\n\n.version 8.5\n.target sm_90\n.address_size 64\n", header),
              "//\n\n.version 9.0\n.target sm_90a\n.address_size 64\n");
    EXPECT_EQ(compiler::withHeader(".version 10.25\n.target sm_7, debug\n", header),
              ".version 9.0\n.target sm_90a, debug\n");
    EXPECT_THROW(compiler::withHeader("// .version 7.0\n", header), Error);
}

// Compilers' output for CUDA C++ must not need a newer PTX version than before.
TEST(GpuHeader, StaysWhereNothingNewIsUsed) {
    const std::string body =
        "    sqrt.rn.ftz.f32 %f2, %f1;\n    fma.rn.ftz.f32 %f2, %f2, %f1, %f1;\n"
        "    min.ftz.f32 %f2, %f2, %f1;\n    cvt.rzi.ftz.u32.f32 %r2, %f2;\n"
        "    cvt.rn.f16.f32 %rs1, %f2;\n    setp.lt.ftz.f32 %p1, %f2, %f1;\n"
        "    atom.global.add.u32 %r3, [%rd1], %r2;\n    red.global.max.s32 [%rd1], %r2;\n"
        "    vote.sync.ballot.b32 %r4, %p1, -1;\n    shfl.sync.idx.b32 %r4, %r4, 0, 31, -1;\n"
        "    membar.gl;\n    tex.2d.v4.f32.f32 {%f3, %f4, %f5, %f6}, [%rd1, {%f1, %f2}];\n"
        "    redux.sync.add.u32 %r5, %r4, -1;\n    prmt.b32 %r5, %r5, %r4, 0x123;\n"
        "    st.global.v4.f32 [%rd1+16], {%f3, %f4, %f5, %f6};\n    st.global.u32 [%rd1+8], %r5;\n";
    for (const char* target : {"sm_90", "sm_90a", "sm_100a", "sm_120"}) {
        const std::string text = pipelineOf(withTop("9.0", target, body));
        EXPECT_TRUE(has(text, ".version 8.5\n.target sm_90\n")) << target << text.substr(0, 200);
        EXPECT_TRUE(has(pipelineOf(withTop("9.0", target, body), {90, 78}), ".version 7.8\n"));
    }
}

struct Newer {
    const char* name;
    const char *version, *target, *body;
    const char* header; // of the pipeline
    unsigned gpu = 90;
};

std::string gpuNameOf(const Newer& one) {
    const std::string name = "sm_" + std::to_string(one.gpu);
    return has(one.header, name + "a") ? name + "a" : name;
}

class GpuHeaderOf : public testing::TestWithParam<Newer> {};

// Instructions get the version and target that their module declares, as ptxas requires.
TEST_P(GpuHeaderOf, IsWhatInstructionsNeed) {
    const Newer& one = GetParam();
    const GpuTarget gpu = {one.gpu, 90};
    const std::string text = withTop(one.version, one.target, one.body);
    std::string asked;
    ptx::Diagnostics diagnostics;
    const auto judge = [&](const ptx::Module& alone) {
        GpuHeader header = compiler::plainHeader(gpu);
        compiler::widen(header, alone, gpu);
        asked = compiler::withHeader(ptx::print(alone), header);
        return !kHasPtxas || !readsPtx9() || ptxasTakes(asked, gpuNameOf(one));
    };
    const std::shared_ptr<const ptx::Module> tree = ptx::parse(text, diagnostics, judge);
    ASSERT_TRUE(tree) << diagnostics.format() << asked;
    if (!asked.empty())
        EXPECT_TRUE(has(asked, one.header)) << asked;
    Options options;
    options.target = gpu;
    const std::string pipeline =
        compileGpuPipeline(requestOf(std::make_shared<const compiler::Source>(tree),
                                     compiler::inspect(*tree, rulesOf(options), {}), options))
            .ptx;
    EXPECT_TRUE(has(pipeline, one.header)) << pipeline.substr(0, 200);
    if (!kHasPtxas || !readsPtx9())
        GTEST_SKIP() << "no ptxas here that reads PTX 9.0: only the text was looked at";
    EXPECT_TRUE(ptxasTakes(pipeline, gpuNameOf(one)));
    const std::string plain = compiler::withHeader(pipeline, compiler::plainHeader(gpu));
    EXPECT_FALSE(ptxasTakes(plain, gpuNameOf(one))) << "it is not this that is needed";
}

void PrintTo(const Newer& one, std::ostream* out) {
    *out << one.name;
}

const Newer kNewer[] = {
    {"Fences", "8.6", "sm_80",
     "fence.proxy.async::generic.acquire.sync_restrict::shared::cluster.cluster;\n",
     ".version 8.6\n.target sm_90\n"},
    {"Registers", "8.0", "sm_90a", "setmaxnreg.inc.sync.aligned.u32 80;\n",
     ".version 8.5\n.target sm_90a\n"},
    {"Warpgroups", "9.0", "sm_90a",
     "wgmma.fence.sync.aligned;\n wgmma.mma_async.sync.aligned.m64n8k16.f32.f16.f16 "
     "{%f1, %f2, %f3, %f4}, {%r1, %r2, %r3, %r4}, %rd3, 1, 1, 1, 0;\n"
     "wgmma.commit_group.sync.aligned;\nwgmma.wait_group.sync.aligned 0;\n"
     "st.global.f32 [%rd1+8], %f1;\n",
     ".version 9.0\n.target sm_90a\n"},
    {"TensorMaps", "8.3", "sm_90a",
     "tensormap.replace.tile.global_address.global.b1024.b64 [%rd1], %rd2;\n",
     ".version 8.5\n.target sm_90a\n"},
    {"Least", "8.6", "sm_100a",
     "redux.sync.min.f32 %f2, %f1, -1;\nst.global.f32 [%rd1+8], %f2;\n",
     ".version 8.6\n.target sm_100a\n", 100},
    {"LeastOfAFamily", "8.8", "sm_100f",
     "redux.sync.min.f32 %f2, %f1, -1;\nst.global.f32 [%rd1+8], %f2;\n",
     ".version 8.8\n.target sm_100f\n", 103},
    {"Pairs", "8.6", "sm_100",
     "fma.rn.f32x2 %rd2, %rd3, %rd4, %rd2;\nst.global.u64 [%rd1+8], %rd2;\n",
     ".version 8.6\n.target sm_100\n", 100},
    {"LeastOfThree", "8.8", "sm_100",
     "min.f32 %f2, %f1, %f3, %f4;\nst.global.f32 [%rd1+8], %f2;\n",
     ".version 8.8\n.target sm_100\n", 100},
    {"TensorMemory", "8.6", "sm_100a",
     "tcgen05.ld.sync.aligned.32x32b.x2.b32 {%r2, %r3}, [%r1+4];\n"
     "tcgen05.wait::ld.sync.aligned;\nst.global.u32 [%rd1+8], %r2;\n",
     ".version 8.6\n.target sm_100a\n", 100},
};

INSTANTIATE_TEST_SUITE_P(Newer, GpuHeaderOf, testing::ValuesIn(kNewer),
                         [](const auto& info) { return info.param.name; });

TEST(GpuHeader, OtherArchitecturesAreRefused) {
    const std::string body = "    add.u32 %r1, %r1, 1;\n    tcgen05.wait::ld.sync.aligned;\n";
    for (const char* target : {"sm_100a", "sm_100f", "sm_80a"})
        try {
            pipelineOf(withTop("9.0", target, body));
            ADD_FAILURE() << target;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), Code::kInvalidPtx);
            EXPECT_STREQ(error.what(), (std::string("line 17: tcgen05.wait::ld.sync.aligned: the "
                                                    "module's target is ") +
                                        target + ", this GPU is of sm_90")
                                           .c_str());
        }
}

// PTX 6.4 removed them for newer GPUs; older modules may use them.
TEST(GpuHeader, WarpFunctionsWithoutMembers) {
    const std::string text = pipelineOf(
        withTop("6.0", "sm_60",
                "    vote.ballot.b32 %r2, %p1;\n    vote.any.pred %p2, !%p1;\n"
                "    shfl.idx.b32 %r3|%p3, %r2, 0, 31;\n    selp.u32 %r3, %r3, 1, %p2;\n"
                "    selp.u32 %r3, %r3, 2, %p3;\n    st.global.u32 [%rd1+8], %r3;\n"));
    for (const char* each : {"vote.sync.ballot.b32 ", "vote.sync.any.pred ", "shfl.sync.idx.b32 "})
        EXPECT_TRUE(has(text, each)) << each;
    EXPECT_TRUE(ptxasTakes(text, "sm_90"));
}

// 32-bit addresses, 128-bit accesses, operands of several parts.
TEST(GpuHeader, OddOperandsAreKept) {
    const std::string text = pipelineOf(
        withTop("8.4", "sm_90",
                "    .reg .b128 %q;\n    ld.relaxed.gpu.global.b128 %q, [%rd1];\n"
                "    st.release.sys.global.b128 [%rd1+16], %q;\n"
                "    vadd4.u32.u32.u32.add %r2, %r1.b0123, %r3.b4567, %r4;\n"
                "    vadd2.u32.u32.u32 %r2.h10, %r1.h10, %r3.h32, %r2;\n"
                "    st.global.u32 [%rd1+8], %r2;\n"
                "    cp.async.ca.shared.global [%r1+4], [%rd1], 4;\n"));
    for (const char* each : {"ld.relaxed.gpu.global.b128 %rq", ".b0123", ".b4567", ".h32", ".h10"})
        EXPECT_TRUE(has(text, each)) << each;
    EXPECT_TRUE(ptxasTakes(text, "sm_90"));
}

TEST(GpuHeader, ParametersOfTheKeyTellTextsApart) {
    const std::string body = withTop("9.0", "sm_90a", "    wgmma.fence.sync.aligned;\n");
    const auto keyFor = [&](const GpuTarget& gpu) {
        Options options;
        options.target = gpu;
        return compiler::keyOf(requestOf(body, options));
    };
    EXPECT_NE(keyFor({90, 90, 13000}), keyFor({90, 85, 13000}));
    EXPECT_NE(keyFor({90, 90, 13000}), keyFor({100, 90, 13000}));
    EXPECT_NE(keyFor({90, 90, 13000}), keyFor({90, 90, 13010}));
}

} // namespace
} // namespace sunstone
