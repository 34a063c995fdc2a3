// SPDX-License-Identifier: Apache-2.0
// Pipelines for CUDA GPUs as PTX text: required and refused contents, and acceptance by ptxas.
#include "base/error.h"
#include "bvh/gpu/build/builder.h"
#include "bvh/gpu/kernels_ptx.h"
#include "bvh/gpu/layout.h"
#include "engine/gpu/code/machine_code.h"
#include "gpu/pipelines.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <unistd.h>

namespace sunstone {
namespace {

using namespace gpu_tests;

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

void expectAccepted(const std::string& ptx) {
#ifdef SUNSTONE_PTXAS
    char name[] = "/tmp/sunstone_gpu_XXXXXX";
    const int file = mkstemp(name);
    ASSERT_GE(file, 0);
    close(file);
    std::ofstream(name) << ptx;
    const std::string command = std::string(SUNSTONE_PTXAS " -arch=sm_90 -O0 -o /dev/null ") + name;
    EXPECT_EQ(std::system(command.c_str()), 0);
    unlink(name);
#else
    (void)ptx;
    std::puts("no ptxas here: only the text was looked at");
#endif
}

TEST(GpuCompile, KernelForTheDevice) {
    const std::string body = raygen("    st.global.u32 [%rd1+8], %r1;\n");
    const std::string newest = compile(body);
    EXPECT_TRUE(has(newest, ".visible .entry sunstone_launch("));
    EXPECT_TRUE(has(newest, ".target sm_90")) << newest.substr(0, 200);
    EXPECT_TRUE(has(newest, ".version 8.0"));
    EXPECT_FALSE(has(newest, ".func sunstone_gpu_run")); // it is a part of the kernel
    expectAccepted(newest);
    Options old;
    old.target = {72, 70};
    EXPECT_TRUE(has(compile(body, old), ".target sm_72"));
    Options future; // devices unknown to LLVM run code for the newest it supports
    future.target = {121, 99};
    EXPECT_TRUE(has(compile(body, future), ".target sm_90"));
}

// LLVM has no equivalent for these instructions, or cannot emit it.
TEST(GpuCompile, WhatLlvmCannotWriteStaysWhatItIs) {
    const std::string kept[] = {
        "ld.acquire.gpu.global.u32 ",
        "st.release.sys.global.u32 ",
        "ld.mmio.relaxed.sys.global.u32 ",
        "createpolicy.fractional.L2::evict_first.b64 ",
        "atom.global.add.L2::cache_hint.u32 ",
        "prefetch.global.L2::evict_last ",
        "discard.global.L2 ",
        "nanosleep.u32 ",
        "atom.relaxed.gpu.global.cas.b128 ",
        "mov.pred ",
        "mov.u64 ",
        "multimem.red.relaxed.sys.global.add.u32 ",
        "cp.async.bulk.prefetch.L2.global ",
    };
    std::string body =
        raygen("    ld.acquire.gpu.global.u32 %r2, [%rd1+8];\n    st.release.sys.global.u32 "
               "[%rd1+8], %r2;\n"
               "    ld.mmio.relaxed.sys.global.u32 %r2, [%rd1+8];\n"
               "    createpolicy.fractional.L2::evict_first.b64 %rd2;\n"
               "    atom.global.add.L2::cache_hint.u32 %r3, [%rd1+8], %r2, %rd2;\n"
               "    prefetch.global.L2::evict_last [%rd1];\n    discard.global.L2 [%rd1], 128;\n"
               "    nanosleep.u32 20;\n    .reg .b128 %q<3>;\n    mov.b128 %q0, {%rd2, %rd2};\n"
               "    atom.relaxed.gpu.global.cas.b128 %q1, [%rd1], %q0, %q0;\n"
               "    mov.b128 {%rd3, %rd4}, %q1;\n    st.global.u64 [%rd1+16], %rd3;\n"
               "    mov.pred %p1, %is_explicit_cluster;\n    selp.u32 %r3, %r3, 7, %p1;\n"
               "    mov.u64 %rd5, %current_graph_exec;\n    st.global.u64 [%rd1+24], %rd5;\n"
               "    multimem.red.relaxed.sys.global.add.u32 [%rd1], %r3;\n"
               "    cp.async.bulk.prefetch.L2.global [%rd1], 16;\n");
    body.replace(body.find("7.8"), 3, "8.3");
    body.replace(body.find("sm_70"), 5, "sm_90");
    Options options;
    options.target = {90, 83};
    const std::string text = compile(body, options);
    for (const std::string& each : kept)
        EXPECT_TRUE(has(text, each)) << each;
    EXPECT_TRUE(has(text, "%is_explicit_cluster") && has(text, "%current_graph_exec"));
    expectAccepted(text);
}

// Instructions that may read their first operand, write it, or both.
TEST(GpuCompile, RegistersOfUnknownInstructionsAreHandedOver) {
    std::string body = raygen("    setmaxnreg.inc.sync.aligned.u32 64;\n"
                              "    wgmma.mma_async.sync.aligned.m64n8k16.f32.f16.f16 "
                              "{%f1, %f2, %f3, %f4}, %rd2, %rd3, 1, 1, 1, 0, 0;\n"
                              "    st.global.f32 [%rd1+8], %f1;\n");
    body.replace(body.find("7.8"), 3, "8.3");
    const std::string text = compile(body, Options());
    const size_t at = text.find("wgmma.mma_async");
    ASSERT_NE(at, std::string::npos);
    // The sum starts from the register's value, which was loaded from memory.
    const std::string first = text.substr(text.find('{', at) + 1, 5); // %r12, for one
    const std::string name = first.substr(0, first.find_first_of(",}"));
    const size_t set = text.rfind(" \t" + name + ", ", at);
    EXPECT_NE(set, std::string::npos) << name;
    EXPECT_TRUE(has(text, "setmaxnreg.inc.sync.aligned.u32 64;"));
}

TEST(GpuCompile, CallsThroughListsOfTargets) {
    std::string body =
        raygen("    mov.u64 %rd2, table;\n    and.b32 %r1, %r1, 1;\n"
               "    mul.wide.u32 %rd3, %r1, 8;\n    add.u64 %rd2, %rd2, %rd3;\n"
               "    ld.global.u64 %rd4, [%rd2];\n    to: .calltargets one, two;\n"
               "    call (%r2), %rd4, (%r1), to;\n    st.global.u32 [%rd1+8], %r2;\n");
    body.insert(body.find(".visible .const"),
                ".func (.reg .u32 r) one(.reg .u32 a) { add.u32 r, a, 1; ret; }\n"
                ".func (.reg .u32 r) two(.reg .u32 a) { add.u32 r, a, 2; ret; }\n"
                ".global .u64 table[2] = {one, two};\n");
    expectAccepted(compile(body));
}

TEST(GpuCompile, BuilderKernels) {
    for (const std::string& text : bvh::gpu::Builder::kernelTexts()) {
        EXPECT_TRUE(has(text, ".visible .entry"));
        EXPECT_TRUE(has(text, ".version 6.5")) << "what drivers of all years read";
        expectAccepted(text);
    }
}

// The contents of the disk cache, in memory.
struct Shelf : compiler::ObjectStore {
    std::map<std::string, std::string> values;
    bool find(const std::string& key, std::string& value) override {
        const auto found = values.find(key);
        if (found != values.end())
            value = found->second;
        return found != values.end();
    }
    void insert(const std::string& key, const std::string& value) override { values[key] = value; }
};

TEST(GpuCompile, TextsAreKept) {
    Shelf shelf;
    const std::string body = raygen("    st.global.u32 [%rd1+8], %r1;\n");
    unsigned compiled = 0;
    const auto make = [&](const Options& options = {}) {
        const compiler::GpuPipelineRequest request = requestOf(body, options);
        compiler::GpuCode code;
        if (findGpuPipeline(keyOf(request), shelf, code))
            return code;
        ++compiled;
        code = compileGpuPipeline(request);
        keepGpuPipeline(keyOf(request), code, shelf);
        return code;
    };
    const compiler::GpuCode first = make(), second = make();
    ASSERT_EQ(shelf.values.size(), 1u);
    EXPECT_EQ(compiled, 1u);
    EXPECT_TRUE(has(first.ptx, ".entry sunstone_launch("));
    EXPECT_EQ(second.ptx, first.ptx);
    EXPECT_EQ(second.feedback, first.feedback);
    EXPECT_EQ(second.stack.entry, first.stack.entry);
    EXPECT_FALSE(second.hasState);
    std::string& kept = shelf.values.begin()->second;
    const std::string whole = kept;
    for (const size_t size : {size_t(0), size_t(3), size_t(20), size_t(40), whole.size() - 1}) {
        kept = whole.substr(0, size); // for example an older form
        EXPECT_TRUE(has(make().ptx, ".entry sunstone_launch(")) << size;
        EXPECT_EQ(shelf.values.size(), 1u);
    }
    EXPECT_EQ(compiled, 6u);
    Options other;
    other.target = {80, 80};
    EXPECT_TRUE(has(make(other).ptx, ".target sm_80"));
    other.motion = true;
    make(other);
    EXPECT_EQ(shelf.values.size(), 3u);
}

TEST(GpuCompile, VariablesThatCanBeWrittenAreTold) {
    const auto hasState = [](const std::string& variable) {
        std::string text = raygen("    ld.global.u32 %r2, [it];\n    add.u32 %r2, %r2, 1;\n"
                                  "    st.global.u32 [it], %r2;\n    st.global.u32 [%rd1], %r2;\n");
        return compileCode(text.insert(text.find(".visible .const"), variable)).hasState;
    };
    EXPECT_TRUE(hasState(".global .align 4 .u32 it = 5;\n"));
    const std::string table =
        raygen("    mov.u64 %rd2, it;\n    and.b32 %r1, %r1, 3;\n"
               "    mul.wide.u32 %rd3, %r1, 4;\n    add.u64 %rd2, %rd2, %rd3;\n"
               "    ld.const.u32 %r2, [%rd2];\n    st.global.u32 [%rd1], %r2;\n");
    std::string text = table;
    EXPECT_FALSE(compileCode(text.insert(text.find(".visible .const"),
                                         ".const .align 4 .u32 it[4] = {1, 2, 3, 4};\n"))
                     .hasState);
}

// A report on a kernel in the format of the driver's compiler.
const char* const kLog = R"(ptxas info    : 0 bytes gmem
ptxas info    : Compiling entry function 'sunstone_launch' for 'sm_90a'
ptxas info    : Function properties for sunstone_launch
ptxas         .     1520 bytes stack frame, 392 bytes spill stores, 348 bytes spill loads
ptxas info    : Used 72 registers, used 0 barriers, 1520 bytes cumulative stack size
ptxas info    : Compile time = 272.637 ms
ptxas info    : Function properties for f_$___closesthit__main
ptxas         .     48 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Function properties for sunstone_gpu_trace
ptxas         .     952 bytes stack frame, 148 bytes spill stores, 148 bytes spill loads
)";

TEST(GpuCompile, FramesAreReadFromTheLog) {
    const compiler::GpuCalls::Frames frames = compiler::gpuFramesIn(kLog);
    EXPECT_EQ(frames, (compiler::GpuCalls::Frames{{"sunstone_launch", 1520},
                                                  {"f_$___closesthit__main", 48},
                                                  {"sunstone_gpu_trace", 952}}));
    EXPECT_TRUE(compiler::gpuFramesIn("").empty());
    EXPECT_EQ(compiler::gpuSpillsIn(kLog), 392u);
    EXPECT_EQ(compiler::gpuSpillsIn(""), 0u);
    EXPECT_EQ(compiler::gpuSpillsIn("Function properties for sunstone_launch\nnothing\n"), 0u);
    const std::string_view log = kLog; // without the kernel's name it belongs to another function
    EXPECT_TRUE(compiler::gpuFramesIn(log.substr(log.find("for f_$"))).empty());
}

// kLog has 392 bytes of spill stores.
TEST(GpuCompile, KernelsThatSpillGetMoreRegisters) {
    const auto better = [](bool intersects, bool takesTurns, bool recurses, unsigned registers) {
        compiler::GpuPipelineRequest request;
        request.constants = {{"sunstone_gpu_hasIntersection", intersects}};
        compiler::GpuCode code;
        code.takesTurns = takesTurns;
        code.recurses = recurses;
        return engine::betterRegisters(kLog, code, request, registers);
    };
    EXPECT_EQ(better(true, false, false, 72), 96u);
    EXPECT_EQ(better(true, false, false, 96), 0u);
    EXPECT_EQ(better(true, true, false, 80), 0u);
    EXPECT_EQ(better(true, true, true, 72), 0u);
    EXPECT_EQ(better(false, false, false, 72), 0u);
}

TEST(GpuCompile, MachineCodeAndMeasuredStacksAreKept) {
    Shelf shelf;
    const compiler::GpuPipelineRequest request = requestOf(raygen(""), {});
    compiler::GpuCode code = compileGpuPipeline(request), kept;
    EXPECT_FALSE(code.stack.isMeasured);
    measureGpuStack(code, ""); // the driver had it in its cache
    EXPECT_FALSE(code.stack.isMeasured);
    measureGpuStack(code, kLog);
    EXPECT_TRUE(code.stack.isMeasured);
    code.machineCode = "machine code";
    code.hasState = true;
    keepGpuPipeline("key", code, shelf);
    ASSERT_TRUE(findGpuPipeline("key", shelf, kept));
    EXPECT_TRUE(kept.stack.isMeasured);
    EXPECT_EQ(kept.stack.entry, code.stack.entry);
    EXPECT_EQ(kept.calls, code.calls);
    EXPECT_EQ(kept.machineCode, "machine code");
    EXPECT_EQ(kept.ptx, "") << "there is no use for it";
    EXPECT_TRUE(kept.hasState);
}

TEST(GpuCompile, InstructionsStayWhatTheyAre) {
    const std::string text = compile(raygen(R"(
    sin.approx.ftz.f32 %f2, %f1;
    add.ftz.f32 %f3, %f2, 0f3F800000;
    fma.rz.f32 %f4, %f3, %f1, %f2;
    lop3.b32 %r2, %r1, 17, %r1, 0x96;
    prmt.b32 %r3, %r2, %r1, 0x3210;
    atom.global.add.u32 %r4, [%rd1+16], %r3;
    cvt.rzi.s32.f32 %r5, %f4;
    shfl.sync.bfly.b32 %r6|%p1, %r5, 1, 31, -1;
    mov.u32 %r7, %laneid;
    add.u32 %r7, %r7, %r6;
    @%p1 st.global.u32 [%rd1+8], %r7;
    st.global.v2.f32 [%rd1+24], {%f4, %f1};
)"));
    for (const char* kept : {"sin.approx.ftz.f32", "add.ftz.f32", "fma.rz.f32", "lop3.b32",
                             "prmt.b32", "atom.global.add.u32", "cvt.rzi.s32.f32",
                             "shfl.sync.bfly.b32", "%laneid", "st.global.v2"})
        EXPECT_TRUE(has(text, kept)) << kept;
    expectAccepted(text);
}

// Instructions that the translator does not know are left to the driver.
TEST(GpuCompile, UnknownInstructionsPass) {
    const std::string text = compile(raygen(R"(
    vadd.u32.u32.u32 %r2, %r1, %r1;
    st.global.u32 [%rd1+8], %r2;
)"));
    EXPECT_TRUE(has(text, "vadd.u32.u32.u32"));
    expectAccepted(text);
}

TEST(GpuCompile, OperandsOfVideoInstructionsKeepSelectorsAndSigns) {
    const std::string text = compile(raygen(R"(
    mov.u32 %r3, 7;
    vadd.s32.u32.s32.sat %r2, %r1.b3, %r3.h1;
    vabsdiff.u32.u32.u32 %r4.b1, %r1.b0, %r3.b2, %r2;
    vmad.s32.s32.s32 %r5, %r1.h0, -%r3.b1, %r4;
    st.global.v2.u32 [%rd1+8], {%r2, %r5};
)"));
    for (const char* kept : {".b3, ", ".h1;", ".b1, ", ".b2, ", ".h0, -", ".s32.sat "})
        EXPECT_TRUE(has(text, kept)) << kept << " in\n" << text;
    expectAccepted(text);
}

TEST(GpuCompile, VertexDataOfShapes) {
    const std::string text = R"(.version 7.8
.target sm_70
.address_size 64
.visible .const .align 8 .b8 params[16];
.visible .entry __raygen__main()
{
    .reg .b64 %rd<4>;
    .reg .f32 %f<12>;
    .reg .b32 %r<4>;
    ld.const.u64 %rd1, [params];
    mov.u32 %r1, 0;
    mov.f32 %f10, 0f00000000;
    call (%f1, %f2, %f3, %f4), _optix_get_sphere_data, (%rd1, %r1, %r1, %f10);
    st.global.f32 [%rd1], %f1;
    ret;
}
)";
    expectAccepted(compile(text));
}

// Size of the kernel's stack frame.
size_t frameOfKernel(const std::string& ptx) {
    constexpr std::string_view kDepot = "__local_depot";
    const std::string_view kernel =
        std::string_view(ptx).substr(ptx.find(".entry sunstone_launch"));
    const size_t depot = kernel.find(kDepot);
    return depot == kernel.npos
               ? 0
               : std::stoul(std::string(kernel.substr(kernel.find('[', depot) + 1)));
}

// The state of the ray and of the traversal stays in registers while intersection programs run: no
// report may take its address. Only stacks, which are indexed, are in memory.
TEST(GpuCompile, ReportsNeedNoStateInMemory) {
    const std::string text = R"(.version 7.8
.target sm_70
.address_size 64
.visible .const .align 8 .b8 params[16];
.visible .entry __raygen__main()
{
    .reg .b64 %rd<3>;
    .reg .b32 %r<5>;
    .reg .f32 %f<3>;
    ld.const.u64 %rd1, [params];
    ld.const.u64 %rd2, [params+8];
    ld.global.f32 %f1, [%rd1];
    mov.u32 %r1, 0;
    mov.u32 %r2, 1;
    mov.u32 %r3, 255;
    mov.f32 %f2, 0f00000000;
    call (%r4), _optix_trace_1, (%rd2, %f1, %f1, %f1, %f1, %f1, %f1, %f2, %f1, %f2, %r3, %r1, %r1,
        %r2, %r1, %r1);
    st.global.u32 [%rd1], %r4;
    ret;
}
.visible .entry __closesthit__main()
{
    .reg .b32 %r<3>;
    call (%r1), _optix_read_primitive_idx, ();
    mov.u32 %r2, 0;
    call _optix_set_payload, (%r2, %r1);
    ret;
}
.visible .entry __intersection__main()
{
    .reg .b64 %rd<2>;
    .reg .b32 %r<5>;
    .reg .f32 %f<4>;
    ld.const.u64 %rd1, [params];
    call (%f1), _optix_get_world_ray_origin_x, ();
    ld.global.f32 %f2, [%rd1+16];
    add.f32 %f3, %f1, %f2;
    mov.u32 %r1, 7;
    mov.b32 %r2, %f1;
    call (%r3), _optix_report_intersection_1, (%f3, %r1, %r2);
    call (%r4), _optix_report_intersection_0, (%f2, %r1);
    ret;
}
)";
    const std::string ptx = compile(text);
    EXPECT_LE(frameOfKernel(ptx), (bvh::gpu::kStackEntries + bvh::gpu::kWaitingLeaves) * 8u);
    expectAccepted(ptx);
}

#ifdef SUNSTONE_SAMPLE_PTX
std::string textOf(const std::string& path) {
    std::ifstream file(path);
    EXPECT_TRUE(file.good()) << path;
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

class GpuCompileSample : public testing::TestWithParam<std::pair<const char*, unsigned>> {};

TEST_P(GpuCompileSample, IsAccepted) {
    const auto [name, flags] = GetParam();
    Options options;
    options.graphFlags = flags;
    if (std::string(name) == "curves")
        options.shapes = bvh::gpu::kMeetsLinear | bvh::gpu::kMeetsCurves;
    options.motion = std::string(name) == "motion_blur";
    const std::string ptx =
        compile(textOf(std::string(SUNSTONE_SAMPLE_PTX "/") + name + ".ptx"), options);
    EXPECT_TRUE(has(ptx, ".visible .entry sunstone_launch("));
    // A ray generation program is inlined into the kernel, however large it is.
    EXPECT_FALSE(has(ptx, ".func f_$___raygen__"));
    expectAccepted(ptx);
}

// Only frames that wait while a ray is traced count at each level: the walk through a structure,
// whose stack takes kilobytes, counts once. A GPU allocates the stack for every resident thread.
TEST(GpuCompile, StackOfTraces) {
    const compiler::GpuStack deep = compileCode(textOf(TEST_RECURSION_PTX)).stack;
    EXPECT_GT(deep.waiting, 0u);
    EXPECT_LT(deep.waiting, 3000u);
    EXPECT_GT(deep.entry, 0u);           // the ray generation program's frame is the kernel's
    EXPECT_GE(deep.other, deep.waiting); // the frames of a trace, to the deepest end
    EXPECT_LT(deep.entry + 32 * deep.waiting + deep.other, 100'000u);
    const compiler::GpuStack measured =
        compiler::GpuCalls::fromText(compileCode(textOf(TEST_RECURSION_PTX)).calls)
            .stack({{"sunstone_launch", 400}, {"sunstone_gpu_trace", 2000}});
    EXPECT_TRUE(measured.isMeasured);
    EXPECT_EQ(measured.waiting, 2000u); // a function without a report is part of its callers
    EXPECT_EQ(measured.other, 2000u);
    // Where programs are cut at their traces, no level has a frame on the stack.
    Options nested;
    nested.maxTraceDepth = 31;
    const compiler::GpuStack none = compileCode(textOf(TEST_RECURSION_PTX), nested).stack;
    EXPECT_EQ(none.waiting, 0u);
    EXPECT_EQ(none.other, 0u);
    const compiler::GpuStack flat = compileCode(textOf(SUNSTONE_SAMPLE_PTX "/hello.ptx")).stack;
    EXPECT_EQ(flat.waiting, 0u);
    EXPECT_EQ(flat.other, 0u);
    EXPECT_GT(flat.entry, 0u);
}

INSTANTIATE_TEST_SUITE_P(Samples, GpuCompileSample,
                         testing::Values(std::pair{"hello", 1u}, std::pair{"triangle", 1u},
                                         std::pair{"spheres", 1u}, std::pair{"instances", 2u},
                                         std::pair{"callables", 0u}, std::pair{"path_tracer", 1u},
                                         std::pair{"curves", 1u}, std::pair{"motion_blur", 0u}),
                         [](const auto& info) { return std::string(info.param.first); });
#endif

} // namespace
} // namespace sunstone
