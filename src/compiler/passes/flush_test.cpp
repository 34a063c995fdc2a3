// SPDX-License-Identifier: Apache-2.0
// Functions that run with results flushed by the processor. run() in testing.h tests single
// instructions in both modes; these tests cover entering and leaving the mode.
#include "compiler/testing.h"

#include <xmmintrin.h>

#include <random>

namespace sunstone::compiler::testing {
namespace {

constexpr unsigned kFlushBit = 1u << 15, kInputBit = 1u << 6;
constexpr float kSubnormal = 0x1.8p-127f, kSmallest = 0x1p-126f;

bool inDefaultMode() {
    return (_mm_getcsr() & (kFlushBit | kInputBit)) == 0;
}

// A kernel with inputs and outputs as `in` and `out` floats.
std::vector<float> runKernel(const std::string& body, std::vector<float> in, size_t outputs) {
    const auto code = compileKernels(parse(
        std::string(kHeader) +
        ".visible .entry k(.param .u64 p0, .param .u64 p1) {\n.reg .b32 %r<20>; .reg .b64 %rd<20>;"
        ".reg .f32 %f<40>; .reg .f64 %fd<20>; .reg .pred %p<9>; .reg .b64 %in, %out;\n"
        "ld.param.u64 %in, [p0]; ld.param.u64 %out, [p1]; ld.f32 %f1, [%in]; ld.f32 %f2, [%in+4];"
        "ld.f32 %f3, [%in+8]; ld.f32 %f4, [%in+12];\n" +
        body + "ret;\n}\n"));
    in.resize(4);
    std::vector<float> out(std::max<size_t>(4, outputs));
    const void* parameters[2] = {in.data(), out.data()};
    devlib::KernelThread thread{};
    reinterpret_cast<devlib::KernelFn>(const_cast<void*>(code->kernels()[0].address))(&thread,
                                                                                      parameters);
    EXPECT_TRUE(inDefaultMode());
    return out;
}

// The two rules differ for the exact product: it is subnormal for the processor, but not if it is
// rounded on the subnormal grid.
TEST(FlushedMode, IsUsedWhereArithmeticIsFlushed) {
    const std::vector<float> in = {0x1.fffffep-1f, kSmallest};
    const std::string product = "mul.ftz.f32 %f5, %f1, %f2; st.f32 [%out], %f5;\n";
    EXPECT_EQ(runKernel(product, in, 3)[0], kSmallest);
    if (!__builtin_cpu_supports("fma"))
        GTEST_SKIP() << "without FMA the mode is not used";
    EXPECT_EQ(runKernel(manyFlushes() + product, in, 3)[0], 0.0f);
}

TEST(FlushedMode, OtherArithmeticKeepsSubnormals) {
    const auto out =
        runKernel(manyFlushes() + "add.f32 %f5, %f1, %f2; st.f32 [%out], %f5;\n"
                                  "cvt.f64.f32 %fd1, %f1; mul.f64 %fd2, %fd1, 0d0010000000000000;"
                                  "mul.f64 %fd2, %fd2, 0d7FD0000000000000;"
                                  "cvt.rn.f32.f64 %f6, %fd2; st.f32 [%out+4], %f6;\n"
                                  "mul.ftz.f32 %f7, %f1, %f3; st.f32 [%out+12], %f7;\n",
                  {kSubnormal, kSubnormal, 1.0f}, 4);
    EXPECT_EQ(out[0], 2 * kSubnormal);
    EXPECT_EQ(out[1], float(double(kSubnormal) * 0x1p-1022 * 0x1p1022));
    EXPECT_EQ(out[3], 0.0f);
}

// A choice between a flushed value and one that is not, either way round, is flushed where it is used.
TEST(FlushedMode, ChoicesOfBothKindsAreFlushed) {
    for (const char* const choice : {"%f5, %f6", "%f6, %f5"}) {
        const auto out = runKernel(
            std::string("mul.ftz.f32 %f5, %f3, %f3; add.f32 %f6, %f1, %f2;"
                        "setp.gt.f32 %p1, %f4, 0f00000000; selp.f32 %f7, ") +
                choice + ", %p1; setp.gt.f32 %p2, %f4, 0f40000000; selp.f32 %f8, " + choice +
                ", %p2; add.ftz.f32 %f9, %f7, %f8; st.f32 [%out], %f9;\n"
                "mul.ftz.f32 %f10, %f7, 0f44800000; st.f32 [%out+4], %f10;"
                "mul.ftz.f32 %f11, %f8, 0f44800000; st.f32 [%out+8], %f11;\n",
            {kSubnormal / 2, kSubnormal / 2, 1.0f, 1.0f}, 4);
        const bool first = choice[2] == '5'; // of the first choice the flushed value is taken
        EXPECT_EQ(out[0], 1.0f);
        EXPECT_EQ(out[1], first ? 1024.0f : 0.0f);
        EXPECT_EQ(out[2], first ? 0.0f : 1024.0f);
    }
}

// Code that the optimiser can fold, with a subnormal difference and subnormal products.
TEST(FlushedMode, NothingIsFoldedAsIfResultsWereKept) {
    const auto out = runKernel(
        manyFlushes() +
            "sub.ftz.f32 %f5, %f1, %f2; setp.gt.f32 %p1, %f5, 0f00000000;"
            "selp.f32 %f6, 0f3F800000, 0f40000000, %p1; st.f32 [%out], %f6;\n" // 0 is not > 0
            "setp.eq.f32 %p2, %f5, 0f00000000; selp.f32 %f6, 0f3F800000, 0f40000000, %p2;"
            "st.f32 [%out+4], %f6;\n"
            "mul.ftz.f32 %f7, %f3, 0f3F800000; st.f32 [%out+12], %f7;\n"
            "add.ftz.f32 %f8, %f3, 0f80000000; st.f32 [%out+16], %f8;\n"
            "div.rn.ftz.f32 %f9, %f3, 0fBF800000; st.f32 [%out+20], %f9;\n"
            "fma.rn.ftz.f32 %f10, %f3, 0f3F800000, 0f80000000; st.f32 [%out+24], %f10;\n"
            "mul.ftz.f32 %f11, %f1, 0f3F000000; mul.ftz.f32 %f12, %f11, 0f40000000;"
            "st.f32 [%out+28], %f12;\n"
            "setp.gt.f32 %p3, %f4, 0f00000000; selp.f32 %f13, 0f3F800000, 0f40000000, %p3;"
            "mul.ftz.f32 %f14, %f3, %f13; st.f32 [%out+32], %f14;\n"
            "neg.ftz.f32 %f15, %f3; st.f32 [%out+36], %f15;\n"
            "neg.f32 %f16, %f3; st.f32 [%out+40], %f16;\n"
            "setp.gt.f32 %p4, %f3, 0f00000000; selp.f32 %f17, 0f3F800000, 0f40000000, %p4;"
            "st.f32 [%out+44], %f17;\n",
        {0x1.8p-126f, kSmallest, kSubnormal, 1.0f}, 12);
    EXPECT_EQ(out[0], 2.0f);
    EXPECT_EQ(out[1], 1.0f);
    EXPECT_EQ(bits(out[3]), bits(0.0f));
    EXPECT_EQ(bits(out[4]), bits(0.0f));
    EXPECT_EQ(bits(out[5]), bits(-0.0f));
    EXPECT_EQ(bits(out[6]), bits(0.0f));
    EXPECT_EQ(bits(out[7]), bits(0.0f)); // 0.75 of the smallest normal, then twice nothing
    EXPECT_EQ(bits(out[8]), bits(0.0f));
    EXPECT_EQ(bits(out[9]), bits(-0.0f));
    EXPECT_EQ(out[10], -kSubnormal);
    EXPECT_EQ(out[11], 1.0f); // a plain comparison sees the subnormal
}

// Random chains of flushed operations on numbers around the limit give the results of single steps.
TEST(FlushedMode, ChainsAgreeWithSteps) {
    std::mt19937 random(7);
    std::string body;
    struct Step {
        unsigned op, a, b;
    };
    std::vector<Step> steps;
    for (unsigned i = 0; i < 200; ++i) {
        steps.push_back(
            {unsigned(random() % 3), 1 + unsigned(random() % 9), 1 + unsigned(random() % 9)});
        const Step& s = steps.back();
        const std::string target = "%f" + std::to_string(5 + i % 5);
        body += std::string(s.op == 0   ? "add.ftz.f32 "
                            : s.op == 1 ? "sub.ftz.f32 "
                                        : "mul.ftz.f32 ") +
                target + ", %f" + std::to_string(s.a) + ", %f" + std::to_string(s.b) + ";\n";
        body += "st.f32 [%out+" + std::to_string(i * 4) + "], " + target + ";\n";
    }
    const auto flushed = [](float x) {
        return std::fabs(x) < kSmallest ? std::copysign(0.0f, x) : x;
    };
    for (unsigned trial = 0; trial < 5; ++trial) {
        std::vector<float> in;
        for (unsigned i = 0; i < 4; ++i)
            in.push_back(std::ldexp(float(int(random() % 4096) - 2048), -136 - int(random() % 4)));
        const auto out = runKernel("mov.f32 %f5, %f1; mov.f32 %f6, %f2; mov.f32 %f7, %f3;"
                                   "mov.f32 %f8, %f4; mov.f32 %f9, %f1;\n" +
                                       body,
                                   in, steps.size());
        float f[10] = {0, in[0], in[1], in[2], in[3], in[0], in[1], in[2], in[3], in[0]};
        for (unsigned i = 0; i < steps.size(); ++i) {
            const float a = flushed(f[steps[i].a]), b = flushed(f[steps[i].b]);
            const float result = flushed(steps[i].op == 0   ? a + b
                                         : steps[i].op == 1 ? a - b
                                                            : a * b);
            f[5 + i % 5] = result;
            ASSERT_EQ(bits(out[i]), bits(result)) << "trial " << trial << " step " << i;
        }
    }
}

// A program in the mode: its callees start in the default mode, and so does code that runs after
// it.
std::vector<bool> seenModes;

TEST(FlushedMode, ProgramsCallInTheDefaultMode) {
    std::string text = std::string(kHeader) + R"(
.const .align 8 .b8 params[8];
.visible .func (.param .b32 r) __direct_callable__dc(.param .b32 a) {
  .reg .f32 %f<20>; .reg .b64 %out; ld.const.u64 %out, [params];
  ld.param.f32 %f1, [a]; mov.f32 %f2, %f1;
)" + manyFlushes() + R"(
  mul.ftz.f32 %f3, %f1, 0f3F000000; add.f32 %f4, %f1, %f3; st.param.f32 [r], %f4; ret;
}
.visible .func (.param .b32 r) plain(.param .b32 a) {
  .reg .f32 %f<9>; ld.param.f32 %f1, [a]; mul.f32 %f2, %f1, 0f3F000000; st.param.f32 [r], %f2; ret;
}
.visible .entry __intersection__is() {
  .reg .f32 %f<20>; .reg .b32 %r<9>; .reg .b64 %rd<9>, %out; ld.const.u64 %out, [params];
  ld.f32 %f1, [%out+16]; mov.f32 %f2, %f1;
)" + manyFlushes() + R"(
  mov.u32 %r1, 3; mov.u32 %r2, 0; mov.u32 %r4, 1;
  call (%r3), _optix_report_intersection_1, (%f1, %r2, %r1);
  call (%rd1), _optix_call_direct_callable, (%r4);
  { .param .b32 x; .param .b32 y; st.param.f32 [x], %f1;
    p0 : .callprototype (.param .b32 _) _ (.param .b32 _);
    call (y), %rd1, (x), p0; ld.param.f32 %f3, [y]; }
  st.f32 [%out], %f3;
  mov.u64 %rd2, plain;
  { .param .b32 x; .param .b32 y; st.param.f32 [x], %f1;
    p1 : .callprototype (.param .b32 _) _ (.param .b32 _);
    call (y), %rd2, (x), p1; ld.param.f32 %f4, [y]; }
  st.f32 [%out+4], %f4; ret;
}
)";
    PipelineRequest request;
    request.rules.launchParams = "params";
    const auto module = source(text);
    request.programs = {{module, "__intersection__is", ProgramKind::kIntersection},
                        {module, "__direct_callable__dc", ProgramKind::kDirectCallable}};
    const auto code = compilePipeline(request);
    static const void* callee = nullptr;
    callee = code->programs()[1].address;
    seenModes.clear();
    devlib::LaunchState launch{};
    launch.report = [](devlib::RayState*, float, uint32_t) -> uint32_t {
        seenModes.push_back(inDefaultMode());
        return devlib::kIgnore;
    };
    launch.callable = [](devlib::RayState*, uint32_t, uint32_t) {
        seenModes.push_back(inDefaultMode());
        return callee;
    };
    float memory[8] = {0, 0, 0, 0, kSmallest};
    float* pointer = memory;
    launch.params = &pointer;
    devlib::ThreadState thread{};
    devlib::RayState ray{};
    ray.launch = &launch;
    ray.thread = &thread;
    reinterpret_cast<devlib::ProgramFn>(const_cast<void*>(code->programs()[0].address))(&ray);
    EXPECT_EQ(seenModes, std::vector<bool>(2, true));
    EXPECT_TRUE(inDefaultMode());
    EXPECT_EQ(memory[0], kSmallest);        // half of it is flushed in the callable
    EXPECT_EQ(memory[1], 0.5f * kSmallest); // and kept in an ordinary function
}

} // namespace
} // namespace sunstone::compiler::testing
