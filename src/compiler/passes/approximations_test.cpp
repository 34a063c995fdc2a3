// SPDX-License-Identifier: Apache-2.0
// sin, cos, ex2, lg2, tanh against double precision: dense ranges, edges, both forms, and within
// code that runs in flush mode. The limits are Sunstone's; PTX allows larger errors.
#include "compiler/testing.h"

#include <random>

namespace sunstone::compiler::testing {
namespace {

using Function = double (*)(double);

// out[i] = op(in[i]) for `count` numbers.
std::unique_ptr<KernelCode> loopOf(const std::string& instruction, bool flushed) {
    return compileKernels(
        parse(std::string(kHeader) +
              ".visible .entry k(.param .u64 p0, .param .u64 p1, .param .u32 p2) {\n"
              ".reg .f32 %f<20>; .reg .b64 %in, %out; .reg .b32 %n; .reg .pred %p;\n"
              "ld.param.u64 %in, [p0]; ld.param.u64 %out, [p1]; ld.param.u32 %n, [p2];\n"
              "LOOP: ld.f32 %f1, [%in]; mov.f32 %f2, %f1;\n" +
              (flushed ? manyFlushes() : "") + instruction +
              " %f3, %f1; st.f32 [%out], %f3;\n"
              "add.u64 %in, %in, 4; add.u64 %out, %out, 4; sub.u32 %n, %n, 1;\n"
              "setp.ne.u32 %p, %n, 0; @%p bra LOOP; ret; }\n"));
}

std::vector<float> apply(const std::string& instruction, const std::vector<float>& in,
                         bool flushed = false) {
    const auto code = loopOf(instruction, flushed);
    std::vector<float> out(in.size() + 4); // manyFlushes() writes past the results
    struct {
        const void* in;
        void* out;
        uint32_t count;
    } parameters = {in.data(), out.data(), uint32_t(in.size())};
    devlib::KernelThread thread{};
    reinterpret_cast<devlib::KernelFn>(const_cast<void*>(code->kernels()[0].address))(&thread,
                                                                                      &parameters);
    out.resize(in.size());
    return out;
}

double ulp(double exact) {
    return std::ldexp(1.0, std::max(-126, std::ilogb(exact)) - 23);
}

// Evenly spaced numbers, 200,000 of them.
std::vector<float> range(double low, double high) {
    std::vector<float> numbers;
    for (unsigned i = 0; i < 200000; ++i)
        numbers.push_back(float(low + (high - low) * i / 199999.0));
    return numbers;
}

// Largest error in units of the last place; absolute errors below `absolute` count as 0.
double worst(const std::string& instruction, Function exact, const std::vector<float>& in,
             double absolute = 0.0) {
    double most = 0;
    for (const bool flushed : {false, true}) {
        const std::vector<float> out = apply(instruction, in, flushed);
        for (size_t i = 0; i < in.size(); ++i) {
            const double want = exact(in[i]);
            if (std::fabs(out[i] - want) <= absolute)
                continue;
            const double error = std::fabs(out[i] - want) / ulp(want);
            if (!(error <= most))
                most = error;
            EXPECT_TRUE(error < 1e6) << instruction << " " << in[i] << ": " << out[i];
            if (!(error < 1e6))
                return error;
        }
    }
    return most;
}

TEST(Approximation, SineAndCosine) {
    for (const char* form : {"sin.approx.f32", "sin.approx.ftz.f32"}) {
        EXPECT_LT(worst(form, std::sin, range(-6.3, 6.3)), 2.0) << form;
        EXPECT_LT(worst(form, std::sin, range(-65536, 65536)), 2.0) << form;
        EXPECT_LT(worst(form, std::sin, range(65536, 1e9)), 2.0) << form;
    }
    for (const char* form : {"cos.approx.f32", "cos.approx.ftz.f32"}) {
        EXPECT_LT(worst(form, std::cos, range(-6.3, 6.3)), 2.0) << form;
        EXPECT_LT(worst(form, std::cos, range(-65536, 65536)), 2.0) << form;
        EXPECT_LT(worst(form, std::cos, range(65536, 1e9)), 2.0) << form;
    }
}

TEST(Approximation, Exponential) {
    EXPECT_LT(worst("ex2.approx.f32", std::exp2, range(-149, 127.99)), 1.5);
    EXPECT_LT(worst("ex2.approx.ftz.f32", std::exp2, range(-126, 127.99)), 1.5);
    EXPECT_LT(worst("ex2.approx.f32", std::exp2, range(-1, 1)), 1.5);
}

TEST(Approximation, Logarithm) {
    for (const char* form : {"lg2.approx.f32", "lg2.approx.ftz.f32"}) {
        EXPECT_LT(worst(form, std::log2, range(0.5, 2.0)), 2.5) << form;
        EXPECT_LT(worst(form, std::log2, range(2.0, 1e6)), 1.5) << form;
        EXPECT_LT(worst(form, std::log2, range(0x1p-126, 0x1p-100)), 1.5) << form;
        EXPECT_LT(worst(form, std::log2, range(1e37, 3.4e38)), 1.5) << form;
    }
    EXPECT_LT(worst("lg2.approx.f32", std::log2, range(0x1p-149, 0x1p-126)), 1.5);
}

TEST(Approximation, HyperbolicTangent) {
    EXPECT_LT(worst("tanh.approx.f32", std::tanh, range(-1.0, 1.0)), 4.0);
    EXPECT_LT(worst("tanh.approx.f32", std::tanh, range(-12.0, 12.0)), 4.0);
}

TEST(Approximation, Edges) {
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float tiny = 0x1p-149f, subnormal = 0x1.8p-127f, normal = 0x1p-126f;
    const std::vector<float> in = {
        0.0f,      -0.0f, tiny,  -subnormal,      normal,          1.0f, -normal, infinity,
        -infinity, nan,   -1.0f, 0x1.fffffep127f, -0x1.fffffep127f};
    const auto expect = [&](const std::string& instruction, std::vector<float> want) {
        for (const bool flushed : {false, true}) {
            const std::vector<float> out = apply(instruction, in, flushed);
            for (size_t i = 0; i < want.size(); ++i)
                if (std::isnan(want[i]))
                    EXPECT_TRUE(std::isnan(out[i])) << instruction << " " << in[i];
                else
                    EXPECT_EQ(bits(out[i]), bits(want[i]))
                        << instruction << " " << in[i] << " " << out[i] << " " << want[i];
        }
    };
    const float sin1 = apply("sin.approx.f32", {1.0f})[0];
    const float cos1 = apply("cos.approx.f32", {1.0f})[0];
    const float tanh1 = apply("tanh.approx.f32", {1.0f})[0];
    expect("sin.approx.f32", {0.0f, -0.0f, tiny, -subnormal, normal, sin1, -normal, nan, nan, nan});
    expect("sin.approx.ftz.f32", {0.0f, -0.0f, 0.0f, -0.0f, normal, sin1, -normal, nan, nan, nan});
    expect("cos.approx.ftz.f32", {1, 1, 1, 1, 1, cos1, 1, nan, nan, nan, cos1});
    expect("cos.approx.f32", {1, 1, 1, 1, 1, cos1, 1, nan, nan, nan, cos1});
    expect("ex2.approx.f32", {1, 1, 1, 1, 1, 2, 1, infinity, 0.0f, nan, 0.5f, infinity, 0.0f});
    expect("ex2.approx.ftz.f32", {1, 1, 1, 1, 1, 2, 1, infinity, 0.0f, nan, 0.5f, infinity, 0.0f});
    expect("lg2.approx.f32",
           {-infinity, -infinity, -149, nan, -126, 0.0f, nan, infinity, nan, nan, nan, 128, nan});
    expect("lg2.approx.ftz.f32", {-infinity, -infinity, -infinity, -infinity, -126, 0.0f, nan,
                                  infinity, nan, nan, nan, 128, nan});
    expect("tanh.approx.f32",
           {0.0f, -0.0f, tiny, -subnormal, normal, tanh1, -normal, 1, -1, nan, -tanh1, 1, -1});
    // Inputs around the largest result that ex2 flushes.
    EXPECT_EQ(apply("ex2.approx.ftz.f32", {-126.0f, -126.00001f, -149.0f}),
              (std::vector<float>{normal, 0.0f, 0.0f}));
    EXPECT_EQ(apply("ex2.approx.f32", {-127.0f, -149.0f, -150.0f}, true),
              (std::vector<float>{normal / 2, tiny, 0.0f}));
}

} // namespace
} // namespace sunstone::compiler::testing
