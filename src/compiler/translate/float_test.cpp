// SPDX-License-Identifier: Apache-2.0
// Floating point instructions: rounding, flushing, saturation, NaN, zeros of both signs.
#include "compiler/testing.h"

#include <cfenv>
#include <limits>
#include <random>

namespace sunstone::compiler::testing {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
const float kNan = std::numeric_limits<float>::quiet_NaN();
const double kNan64 = std::numeric_limits<double>::quiet_NaN();
constexpr float kTiny = 0x1p-149f;  // smallest subnormal
constexpr float kSub = 0x1.8p-127f; // a subnormal
constexpr float kMinNormal = 0x1p-126f;

uint64_t f(float value) {
    return bits(value);
}
uint64_t d(double value) {
    return bits(value);
}

TEST(Float, NearestAndFlush) {
    run({
        {"add.f32 %f0, %f1, %f2;", {f(1.0f), f(0x1p-24f)}, 'f', f(1.0f)},
        {"add.f32 %f0, %f1, %f2;", {f(kSub), f(0.0f)}, 'f', f(kSub)},
        {"add.ftz.f32 %f0, %f1, %f2;", {f(kSub), f(0.0f)}, 'f', f(0.0f)},
        {"add.ftz.f32 %f0, %f1, %f2;", {f(kSub), f(kSub)}, 'f', f(0.0f)}, // inputs flush first
        {"add.ftz.f32 %f0, %f1, %f2;", {f(-kSub), f(-0.0f)}, 'f', f(-0.0f)},
        {"sub.ftz.f32 %f0, %f1, %f2;", {f(0x1.8p-126f), f(kMinNormal)}, 'f', f(0.0f)},
        {"sub.ftz.f32 %f0, %f1, %f2;", {f(kMinNormal), f(0x1.8p-126f)}, 'f', f(-0.0f)},
        {"mul.ftz.f32 %f0, %f1, %f2;", {f(kMinNormal), f(-0.5f)}, 'f', f(-0.0f)},
        {"mul.f32 %f0, %f1, %f2;", {f(kMinNormal), f(0.5f)}, 'f', f(0x1p-127f)},
        {"mul.ftz.sat.f32 %f0, %f1, %f2;", {f(3.0f), f(3.0f)}, 'f', f(1.0f)},
        {"add.sat.f32 %f0, %f1, %f2;", {f(kNan), f(1.0f)}, 'f', f(0.0f)},
        {"add.sat.f32 %f0, %f1, %f2;", {f(-3.0f), f(1.0f)}, 'f', f(0.0f)},
        {"add.f32 %f0, %f1, %f2;", {f(kInf), f(-kInf)}, 'f', f(kNan)},
        // one rounding, never a contracted pair
        {"fma.rn.f32 %f0, %f1, %f2, %f3;",
         {f(1.0f + 0x1p-12f), f(1.0f + 0x1p-12f), f(-1.0f)},
         'f',
         f(0x1p-11f + 0x1p-24f)},
        {"mul.f32 %f5, %f1, %f2; add.f32 %f0, %f5, %f3;",
         {f(1.0f + 0x1p-12f), f(1.0f + 0x1p-12f), f(-1.0f)},
         'f',
         f(0x1p-11f)},
        {"fma.rn.ftz.f32 %f0, %f1, %f2, %f3;", {f(1.0f), f(0.0f), f(kSub)}, 'f', f(0.0f)},
        {"fma.rn.sat.f32 %f0, %f1, %f2, %f3;", {f(1.0f), f(0.5f), f(4.0f)}, 'f', f(1.0f)},
        {"add.f64 %fd0, %fd1, %fd2;", {d(1.0), d(0x1p-1074)}, 'F', d(1.0)},
        {"fma.rn.f64 %fd0, %fd1, %fd2, %fd3;",
         {d(1.0 + 0x1p-30), d(1.0 + 0x1p-30), d(-1.0)},
         'F',
         d(0x1p-29 + 0x1p-60)},
        {"add.ftz.f32 %f5, %f1, %f2; add.ftz.f32 %f0, %f5, %f3;",
         {f(0x1.8p-126f), f(-kMinNormal), f(0.0f)},
         'f',
         f(0.0f)},
        {"mad.rn.f32 %f0, %f1, %f2, %f3;", {f(2), f(3), f(4)}, 'f', f(10)},
    });
}

TEST(Float, DivideAndRoots) {
    run({
        {"div.rn.f32 %f0, %f1, %f2;", {f(1.0f), f(3.0f)}, 'f', f(1.0f / 3.0f)},
        {"div.rn.f32 %f0, %f1, %f2;", {f(1.0f), f(-0.0f)}, 'f', f(-kInf)},
        {"div.approx.ftz.f32 %f0, %f1, %f2;", {f(1.0f), f(kSub)}, 'f', f(kInf)},
        {"div.full.f32 %f0, %f1, %f2;", {f(7.0f), f(2.0f)}, 'f', f(3.5f)},
        {"div.rn.f64 %fd0, %fd1, %fd2;", {d(1.0), d(3.0)}, 'F', d(1.0 / 3.0)},
        {"rcp.rn.f32 %f0, %f1;", {f(3.0f)}, 'f', f(1.0f / 3.0f)},
        {"rcp.approx.ftz.f32 %f0, %f1;", {f(-kTiny)}, 'f', f(-kInf)},
        {"rcp.rn.f64 %fd0, %fd1;", {d(3.0)}, 'F', d(1.0 / 3.0)},
        {"sqrt.rn.f32 %f0, %f1;", {f(2.0f)}, 'f', f(std::sqrt(2.0f))},
        {"sqrt.rn.f32 %f0, %f1;", {f(-0.0f)}, 'f', f(-0.0f)},
        {"sqrt.rn.f32 %f0, %f1;", {f(-1.0f)}, 'f', f(kNan)},
        {"sqrt.approx.ftz.f32 %f0, %f1;", {f(kSub)}, 'f', f(0.0f)},
        {"sqrt.rn.f64 %fd0, %fd1;", {d(2.0)}, 'F', d(std::sqrt(2.0))},
        {"rsqrt.approx.ftz.f32 %f0, %f1;", {f(4.0f)}, 'f', f(0.5f)},
        {"rsqrt.approx.f32 %f0, %f1;", {f(-0.0f)}, 'f', f(-kInf)},
        {"rsqrt.approx.f32 %f0, %f1;", {f(kInf)}, 'f', f(0.0f)},
        {"sin.approx.ftz.f32 %f0, %f1;", {f(0x1p-20f)}, 'f', f(0x1p-20f)},
        {"sin.approx.ftz.f32 %f0, %f1;", {f(-kSub)}, 'f', f(-0.0f)},
        {"cos.approx.f32 %f0, %f1;", {f(-0.0f)}, 'f', f(1.0f)},
        {"cos.approx.f32 %f0, %f1;", {f(kInf)}, 'f', f(kNan)},
        {"ex2.approx.ftz.f32 %f0, %f1;", {f(3.0f)}, 'f', f(8.0f)},
        {"ex2.approx.ftz.f32 %f0, %f1;", {f(-127.0f)}, 'f', f(0.0f)},
        {"ex2.approx.f32 %f0, %f1;", {f(-127.0f)}, 'f', f(0x1p-127f)},
        {"lg2.approx.f32 %f0, %f1;", {f(8.0f)}, 'f', f(3.0f)},
        {"lg2.approx.ftz.f32 %f0, %f1;", {f(kSub)}, 'f', f(-kInf)},
        {"tanh.approx.f32 %f0, %f1;", {f(kInf)}, 'f', f(1.0f)},
    });
}

TEST(Float, MinimumAndSigns) {
    run({
        {"min.f32 %f0, %f1, %f2;", {f(kNan), f(2.0f)}, 'f', f(2.0f)},
        {"min.f32 %f0, %f1, %f2;", {f(2.0f), f(kNan)}, 'f', f(2.0f)},
        {"max.f32 %f0, %f1, %f2;", {f(kNan), f(kNan)}, 'f', f(kNan)},
        {"min.NaN.f32 %f0, %f1, %f2;", {f(2.0f), f(kNan)}, 'f', f(kNan)},
        {"max.NaN.f32 %f0, %f1, %f2;", {f(2.0f), f(3.0f)}, 'f', f(3.0f)},
        {"min.f32 %f0, %f1, %f2;", {f(0.0f), f(-0.0f)}, 'f', f(-0.0f)},
        {"min.f32 %f0, %f1, %f2;", {f(-0.0f), f(0.0f)}, 'f', f(-0.0f)},
        {"max.f32 %f0, %f1, %f2;", {f(0.0f), f(-0.0f)}, 'f', f(0.0f)},
        {"max.f32 %f0, %f1, %f2;", {f(-0.0f), f(0.0f)}, 'f', f(0.0f)},
        {"max.f32 %f0, %f1, 0f00000000;", {f(-0.0f)}, 'f', f(0.0f)},
        {"max.f32 %f0, 0f80000000, %f1;", {f(0.0f)}, 'f', f(0.0f)},
        {"max.f32 %f0, 0f80000000, %f1;", {f(-0.0f)}, 'f', f(-0.0f)},
        {"min.f32 %f0, %f1, 0f00000000;", {f(-0.0f)}, 'f', f(-0.0f)},
        {"min.f32 %f0, %f1, 0f80000000;", {f(0.0f)}, 'f', f(-0.0f)},
        {"min.f32 %f0, %f1, 0f3F800000;", {f(kNan)}, 'f', f(1.0f)},
        {"min.f32 %f0, %f1, %f2;", {f(-kInf), f(5.0f)}, 'f', f(-kInf)},
        {"max.ftz.f32 %f0, %f1, %f2;", {f(kSub), f(-1.0f)}, 'f', f(0.0f)},
        {"min.xorsign.abs.f32 %f0, %f1, %f2;", {f(-3.0f), f(2.0f)}, 'f', f(-2.0f)},
        {"max.xorsign.abs.f32 %f0, %f1, %f2;", {f(-3.0f), f(-2.0f)}, 'f', f(3.0f)},
        {"min.f64 %fd0, %fd1, %fd2;", {d(0.0), d(-0.0)}, 'F', d(-0.0)},
        {"max.f64 %fd0, %fd1, %fd2;", {d(kNan64), d(1.0)}, 'F', d(1.0)},
        {"neg.f32 %f0, %f1;", {f(0.0f)}, 'f', f(-0.0f)},
        {"neg.ftz.f32 %f0, %f1;", {f(kSub)}, 'f', f(-0.0f)},
        {"abs.f32 %f0, %f1;", {f(-kSub)}, 'f', f(kSub)},
        {"abs.ftz.f32 %f0, %f1;", {f(-kSub)}, 'f', f(0.0f)},
        {"abs.f64 %fd0, %fd1;", {d(-2.5)}, 'F', d(2.5)},
        {"copysign.f32 %f0, %f1, %f2;", {f(-1.0f), f(5.0f)}, 'f', f(-5.0f)},
        {"copysign.f64 %fd0, %fd1, %fd2;", {d(1.0), d(-5.0)}, 'F', d(5.0)},
        {"testp.finite.f32 %p0, %f1;", {f(kInf)}, 'p', 0},
        {"testp.infinite.f32 %p0, %f1;", {f(-kInf)}, 'p', 1},
        {"testp.number.f32 %p0, %f1;", {f(kNan)}, 'p', 0},
        {"testp.notanumber.f64 %p0, %fd1;", {d(kNan64)}, 'p', 1},
        {"testp.normal.f32 %p0, %f1;", {f(kSub)}, 'p', 0},
        {"testp.subnormal.f32 %p0, %f1;", {f(kSub)}, 'p', 1},
        {"testp.subnormal.f32 %p0, %f1;", {f(0.0f)}, 'p', 0},
    });
}

// Every operation in every direction against the processor's own rounding modes.
TEST(Float, DirectedRounding) {
    const std::pair<const char*, int> modes[] = {
        {"rz", FE_TOWARDZERO}, {"rm", FE_DOWNWARD}, {"rp", FE_UPWARD}, {"rn", FE_TONEAREST}};
    std::mt19937 random(20240601);
    std::uniform_real_distribution<float> uniform(-100.0f, 100.0f);
    std::vector<std::string> texts;
    std::vector<Case> cases;
    texts.reserve(1000);
    for (const auto& [mode, direction] : modes) {
        for (int repeat = 0; repeat < 4; ++repeat) {
            volatile float a = uniform(random), b = uniform(random), c = uniform(random);
            volatile double x = a * 1.1, y = b * 1.1, z = c * 1.1;
            volatile int32_t wide32 = 0x7fffff81;
            volatile uint64_t wide64 = 0xffffff7fffffffffull;
            std::fesetround(direction);
            volatile float sum = a + b, difference = a - b, product = a * b, quotient = a / b;
            volatile float fused = std::fma(a, b, c), root = std::sqrt(std::fabs(a));
            volatile float inverse = 1.0f / a;
            volatile double sum64 = x + y, product64 = x * y, quotient64 = x / y;
            volatile double fused64 = std::fma(x, y, z);
            volatile float narrowed = float(x);
            volatile float converted = float(wide32);
            volatile float unsigned64 = float(wide64);
            std::fesetround(FE_TONEAREST);
            const auto add = [&](const std::string& text, std::vector<uint64_t> in, char type,
                                 uint64_t expected) {
                texts.push_back(text);
                cases.push_back({texts.back().c_str(), std::move(in), type, expected});
            };
            const std::string m = mode;
            add("add." + m + ".f32 %f0, %f1, %f2;", {f(a), f(b)}, 'f', f(sum));
            add("sub." + m + ".f32 %f0, %f1, %f2;", {f(a), f(b)}, 'f', f(difference));
            add("mul." + m + ".f32 %f0, %f1, %f2;", {f(a), f(b)}, 'f', f(product));
            add("div." + m + ".f32 %f0, %f1, %f2;", {f(a), f(b)}, 'f', f(quotient));
            add("rcp." + m + ".f32 %f0, %f1;", {f(a)}, 'f', f(inverse));
            add("fma." + m + ".f32 %f0, %f1, %f2, %f3;", {f(a), f(b), f(c)}, 'f', f(fused));
            add("sqrt." + m + ".f32 %f0, %f1;", {f(std::fabs(a))}, 'f', f(root));
            add("add." + m + ".f64 %fd0, %fd1, %fd2;", {d(x), d(y)}, 'F', d(sum64));
            add("mul." + m + ".f64 %fd0, %fd1, %fd2;", {d(x), d(y)}, 'F', d(product64));
            add("div." + m + ".f64 %fd0, %fd1, %fd2;", {d(x), d(y)}, 'F', d(quotient64));
            add("fma." + m + ".f64 %fd0, %fd1, %fd2, %fd3;", {d(x), d(y), d(z)}, 'F', d(fused64));
            add("cvt." + m + ".f32.f64 %f0, %fd1;", {d(x)}, 'f', f(narrowed));
            add("cvt." + m + ".f32.s32 %f0, %r1;", {0x7fffff81}, 'f', f(converted));
            add("cvt." + m + ".f32.u64 %f0, %rd1;", {0xffffff7fffffffffull}, 'f', f(unsigned64));
        }
    }
    run(cases);
}

TEST(Float, DirectedRoundingIsNotFolded) {
    run({
        {"add.rp.f32 %f0, 0f3F800000, 0f2F800000;", {}, 'f', f(1.0f + 0x1p-23f)},
        {"add.rm.f32 %f0, 0f3F800000, 0f2F800000;", {}, 'f', f(1.0f)},
        {"mul.rz.f32 %f0, 0f3F800001, 0f3F800001;", {}, 'f', f(1.0f + 0x1p-22f)},
        {"add.rm.f32 %f0, %f1, %f2;", {f(1.0f), f(-1.0f)}, 'f', f(-0.0f)},
        {"add.rp.ftz.f32 %f0, %f1, %f2;", {f(kSub), f(1.0f)}, 'f', f(1.0f)},
    });
}

TEST(Float, Half) {
    // 1 = 0x3c00, 2 = 0x4000, 1.5 = 0x3e00, largest 0x7bff, smallest subnormal 0x0001
    run({
        {"add.f16 %rs0, %rs1, %rs2;", {0x3c00, 0x3e00}, 's', 0x4100},
        {"mul.f16 %rs0, %rs1, %rs2;", {0x7bff, 0x4000}, 's', 0x7c00},
        {"sub.f16 %rs0, %rs1, %rs2;", {0x3c00, 0x3c00}, 's', 0},
        {"fma.rn.f16 %rs0, %rs1, %rs2, %rs3;", {0x3c01, 0x3c01, 0xbc00}, 's', 0x1800},
        {"add.ftz.f16 %rs0, %rs1, %rs2;", {1, 0}, 's', 0},
        {"add.f16 %rs0, %rs1, %rs2;", {1, 0}, 's', 1},
        {"neg.f16 %rs0, %rs1;", {0x3c00}, 's', 0xbc00},
        {"abs.f16 %rs0, %rs1;", {0xbc00}, 's', 0x3c00},
        {"min.f16 %rs0, %rs1, %rs2;", {0x7e00, 0x3c00}, 's', 0x3c00},
        {"max.f16 %rs0, %rs1, %rs2;", {0x8000, 0x0000}, 's', 0},
        {"add.f16x2 %r0, %r1, %r2;", {0x3c003c00, 0x40003c00}, 'r', 0x42004000},
        {"fma.rn.f16x2 %r0, %r1, %r2, %r3;", {0x3c003c00, 0x40003c00, 0}, 'r', 0x40003c00},
        {"min.f16x2 %r0, %r1, %r2;", {0x3c007e00, 0x40003c00}, 'r', 0x3c003c00},
        {"setp.lt.f16 %p0, %rs1, %rs2;", {0x3c00, 0x4000}, 'p', 1},
        {"ex2.approx.f16 %rs0, %rs1;", {0x4000}, 's', 0x4400},
    });
}

// The code generator may call library functions for these.
TEST(Float, HalfAndAConstant) {
    run({
        {"mov.b16 %rs5, 0x3c00; min.f16 %rs0, %rs1, %rs5;", {0x4000}, 's', 0x3c00},
        {"mov.b16 %rs5, 0x3c00; min.f16 %rs0, %rs1, %rs5;", {0x7e00}, 's', 0x3c00},
        {"mov.b16 %rs5, 0x3c00; min.NaN.f16 %rs0, %rs1, %rs5;", {0x7e00}, 's', 0x7fff},
        {"mov.b16 %rs5, 0x3c00; max.f16 %rs0, %rs5, %rs1;", {0x4000}, 's', 0x4000},
        {"mov.b16 %rs5, 0x3c00; max.ftz.f16 %rs0, %rs1, %rs5;", {0x0001}, 's', 0x3c00},
        {"mov.b16 %rs5, 0x3f80; max.bf16 %rs0, %rs1, %rs5;", {0x4000}, 's', 0x4000},
        {"mov.b16 %rs5, 0x3f80; min.NaN.bf16 %rs0, %rs1, %rs5;", {0x7fc1}, 's', 0x7fff},
        {"mov.b32 %r5, 0x3c004000; min.f16x2 %r0, %r1, %r5;", {0x40003c00}, 'r', 0x3c003c00},
        {"mov.b32 %r5, 0x3c004000; max.ftz.NaN.f16x2 %r0, %r1, %r5;",
         {0x7e013c00},
         'r',
         0x7fff4000},
        {"mov.b32 %r5, 0x3f804000; max.bf16x2 %r0, %r1, %r5;", {0x40003f80}, 'r', 0x40004000},
    });
}

} // namespace
} // namespace sunstone::compiler::testing
