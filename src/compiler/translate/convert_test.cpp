// SPDX-License-Identifier: Apache-2.0
// cvt, setp, set, selp, slct and mov.
#include "compiler/testing.h"

#include <limits>

namespace sunstone::compiler::testing {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
const float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr uint64_t kAll32 = 0xffffffffu;
uint64_t f(float value) {
    return bits(value);
}
uint64_t d(double value) {
    return bits(value);
}

TEST(Convert, FloatToInteger) {
    run({
        {"cvt.rzi.s32.f32 %r0, %f1;", {f(-2.9f)}, 'r', uint32_t(-2)},
        {"cvt.rni.s32.f32 %r0, %f1;", {f(2.5f)}, 'r', 2},
        {"cvt.rni.s32.f32 %r0, %f1;", {f(3.5f)}, 'r', 4},
        {"cvt.rmi.s32.f32 %r0, %f1;", {f(-2.1f)}, 'r', uint32_t(-3)},
        {"cvt.rpi.s32.f32 %r0, %f1;", {f(2.1f)}, 'r', 3},
        {"cvt.rzi.s32.f32 %r0, %f1;", {f(kNan)}, 'r', 0},
        {"cvt.rzi.s32.f32 %r0, %f1;", {f(kInf)}, 'r', 0x7fffffff},
        {"cvt.rzi.s32.f32 %r0, %f1;", {f(-kInf)}, 'r', 0x80000000},
        {"cvt.rzi.u32.f32 %r0, %f1;", {f(-5.0f)}, 'r', 0},
        {"cvt.rzi.u32.f32 %r0, %f1;", {f(5e9f)}, 'r', kAll32},
        {"cvt.rzi.u64.f32 %rd0, %f1;", {f(1e19f)}, 'd', 9999999980506447872ull},
        {"cvt.rzi.s64.f64 %rd0, %fd1;", {d(1e30)}, 'd', 0x7fffffffffffffff},
        {"cvt.rzi.s8.f32 %r0, %f1;", {f(-1000.0f)}, 'r', uint32_t(-128)},
        {"cvt.rzi.u8.f32 %r0, %f1;", {f(1000.0f)}, 'r', 255},
        {"cvt.rzi.u16.f32 %rs0, %f1;", {f(70000.0f)}, 's', 65535},
        {"cvt.rni.ftz.s32.f32 %r0, %f1;", {f(-0.75f)}, 'r', uint32_t(-1)},
        {"cvt.rpi.ftz.s32.f32 %r0, %f1;", {f(0x1p-130f)}, 'r', 0},
        {"cvt.rpi.s32.f32 %r0, %f1;", {f(0x1p-130f)}, 'r', 1},
    });
}

TEST(Convert, FloatToFloat) {
    run({
        {"cvt.rzi.f32.f32 %f0, %f1;", {f(-2.9f)}, 'f', f(-2.0f)},
        {"cvt.rmi.ftz.f32.f32 %f0, %f1;", {f(-0x1p-130f)}, 'f', f(-0.0f)},
        {"cvt.rmi.f32.f32 %f0, %f1;", {f(-0x1p-130f)}, 'f', f(-1.0f)},
        {"cvt.rni.f32.f32 %f0, %f1;", {f(0.5f)}, 'f', f(0.0f)},
        {"cvt.rpi.f32.f32 %f0, %f1;", {f(1.25f)}, 'f', f(2.0f)},
        {"cvt.sat.f32.f32 %f0, %f1;", {f(-0.5f)}, 'f', f(0.0f)},
        {"cvt.ftz.sat.f32.f32 %f0, %f1;", {f(kNan)}, 'f', f(0.0f)},
        {"cvt.f64.f32 %fd0, %f1;", {f(0x1p-140f)}, 'F', d(0x1p-140)},
        {"cvt.ftz.f64.f32 %fd0, %f1;", {f(0x1p-140f)}, 'F', d(0.0)},
        {"cvt.rn.f32.f64 %f0, %fd1;", {d(0x1p-140)}, 'f', f(0x1p-140f)},
        {"cvt.rn.ftz.f32.f64 %f0, %fd1;", {d(-0x1p-140)}, 'f', f(-0.0f)},
        {"cvt.rn.f32.f64 %f0, %fd1;", {d(1e300)}, 'f', f(kInf)},
        {"cvt.rz.f32.f64 %f0, %fd1;", {d(1e300)}, 'f', f(std::numeric_limits<float>::max())},
        {"cvt.rn.f16.f32 %rs0, %f1;", {f(1.0f)}, 's', 0x3c00},
        {"cvt.rn.f16.f32 %rs0, %f1;", {f(65520.0f)}, 's', 0x7c00},
        {"cvt.rz.f16.f32 %rs0, %f1;", {f(1e6f)}, 's', 0x7bff},
        {"cvt.rp.f16.f32 %rs0, %f1;", {f(0x1p-30f)}, 's', 1},
        {"cvt.rm.f16.f32 %rs0, %f1;", {f(1.0f + 0x1p-11f)}, 's', 0x3c00},
        {"cvt.rn.f16.f64 %rs0, %fd1;", {d(1.0 + 0x1p-11 + 0x1p-40)}, 's', 0x3c01},
        {"cvt.f32.f16 %f0, %rs1;", {0x0001}, 'f', f(0x1p-24f)},
        {"cvt.f64.f16 %fd0, %rs1;", {0xfbff}, 'F', d(-65504.0)},
        {"cvt.rn.f16x2.f32 %r0, %f1, %f2;", {f(1.0f), f(2.0f)}, 'r', 0x3c004000},
        {"cvt.rn.bf16.f32 %rs0, %f1;", {0x3f808000}, 's', 0x3f80},
        {"cvt.rn.bf16.f32 %rs0, %f1;", {0x3f818000}, 's', 0x3f82},
        {"cvt.f32.bf16 %f0, %rs1;", {0x3fc0}, 'f', f(1.5f)},
    });
}

TEST(Convert, Integers) {
    run({
        {"cvt.rn.f32.s32 %f0, %r1;", {uint32_t(-16777217)}, 'f', f(-16777216.0f)},
        {"cvt.rn.f32.u32 %f0, %r1;", {kAll32}, 'f', f(4294967296.0f)},
        {"cvt.rn.f32.u64 %f0, %rd1;", {~0ull}, 'f', f(0x1p64f)},
        {"cvt.rn.f64.s64 %fd0, %rd1;", {uint64_t(-3)}, 'F', d(-3.0)},
        {"cvt.rn.f32.u8 %f0, %r1;", {0x1ff}, 'f', f(255.0f)},
        {"cvt.rn.f32.s16 %f0, %rs1;", {0x8000}, 'f', f(-32768.0f)},
        {"cvt.rn.f16.s32 %rs0, %r1;", {uint32_t(-2049)}, 's', 0xe800},
        {"cvt.s32.s8 %r0, %r1;", {0x80}, 'r', uint32_t(-128)},
        {"cvt.u32.u8 %r0, %r1;", {0x180}, 'r', 0x80},
        {"cvt.s64.s32 %rd0, %r1;", {0x80000000}, 'd', 0xffffffff80000000},
        {"cvt.u64.u32 %rd0, %r1;", {0x80000000}, 'd', 0x80000000},
        {"cvt.u16.u32 %rs0, %r1;", {0x12345678}, 's', 0x5678},
        {"cvt.s16.s8 %rs0, %rs1;", {0x00ff}, 's', 0xffff},
        {"cvt.sat.u8.s32 %r0, %r1;", {uint32_t(-5)}, 'r', 0},
        {"cvt.sat.s8.s32 %r0, %r1;", {1000}, 'r', 127},
        {"cvt.sat.s32.u32 %r0, %r1;", {kAll32}, 'r', 0x7fffffff},
        {"cvt.sat.u32.s64 %r0, %rd1;", {1ull << 40}, 'r', kAll32},
        {"cvt.u8.u32 %r0, %r1;", {0x12345678}, 'r', 0x78},
    });
}

TEST(Compare, Predicates) {
    run({
        {"setp.lt.f32 %p0, %f1, %f2;", {f(kNan), f(1.0f)}, 'p', 0},
        {"setp.ltu.f32 %p0, %f1, %f2;", {f(kNan), f(1.0f)}, 'p', 1},
        {"setp.ne.f32 %p0, %f1, %f2;", {f(kNan), f(kNan)}, 'p', 0},
        {"setp.neu.f32 %p0, %f1, %f2;", {f(kNan), f(kNan)}, 'p', 1},
        {"setp.equ.f32 %p0, %f1, %f2;", {f(kNan), f(1.0f)}, 'p', 1},
        {"setp.num.f32 %p0, %f1, %f2;", {f(1.0f), f(kNan)}, 'p', 0},
        {"setp.nan.f32 %p0, %f1, %f2;", {f(1.0f), f(kNan)}, 'p', 1},
        {"setp.eq.f32 %p0, %f1, %f2;", {f(0.0f), f(-0.0f)}, 'p', 1},
        {"setp.gt.ftz.f32 %p0, %f1, 0f00000000;", {f(0x1p-130f)}, 'p', 0},
        {"setp.gt.f32 %p0, %f1, 0f00000000;", {f(0x1p-130f)}, 'p', 1},
        {"setp.geu.f64 %p0, %fd1, %fd2;", {d(1.0), d(2.0)}, 'p', 0},
        {"setp.lt.s32 %p0, %r1, %r2;", {kAll32, 0}, 'p', 1},
        {"setp.lt.u32 %p0, %r1, %r2;", {kAll32, 0}, 'p', 0},
        {"setp.lo.u32 %p0, %r1, %r2;", {0, kAll32}, 'p', 1},
        {"setp.hs.u32 %p0, %r1, %r2;", {5, 5}, 'p', 1},
        {"setp.eq.b64 %p0, %rd1, %rd2;", {~0ull, ~0ull}, 'p', 1},
        {"setp.gt.s16 %p0, %rs1, %rs2;", {0x8000, 1}, 'p', 0},
        {"setp.lt.and.s32 %p0, %r1, %r2, %p3;", {1, 2, 0}, 'p', 0},
        {"setp.lt.and.s32 %p0, %r1, %r2, !%p3;", {1, 2, 0}, 'p', 1},
        {"setp.lt.or.s32 %p5|%p0, %r1, %r2, %p3;", {1, 2, 0}, 'p', 0},
        {"setp.lt.xor.s32 %p0|%p5, %r1, %r2, %p3;", {1, 2, 1}, 'p', 0},
        {"setp.lt.s32 %p5|%p0, %r1, %r2;", {1, 2}, 'p', 0},
        {"set.lt.u32.f32 %r0, %f1, %f2;", {f(1.0f), f(2.0f)}, 'r', kAll32},
        {"set.lt.f32.f32 %f0, %f1, %f2;", {f(1.0f), f(2.0f)}, 'f', f(1.0f)},
        {"set.ge.and.s32.s32 %r0, %r1, %r2, %p3;", {2, 1, 0}, 'r', 0},
        {"selp.f32 %f0, %f1, %f2, %p3;", {f(1.0f), f(2.0f), 0}, 'f', f(2.0f)},
        {"selp.b64 %rd0, %rd1, %rd2, !%p3;", {7, 8, 0}, 'd', 7},
        {"slct.f32.s32 %f0, %f1, %f2, %r3;", {f(1.0f), f(2.0f), uint32_t(-1)}, 'f', f(2.0f)},
        {"slct.u32.f32 %r0, %r1, %r2, %f3;", {5, 6, f(-0.0f)}, 'r', 5},
        {"slct.u32.f32 %r0, %r1, %r2, %f3;", {5, 6, f(kNan)}, 'r', 6},
    });
}

TEST(Move, PackAndUnpack) {
    run({
        {"mov.b64 %rd0, {%r1, %r2};", {1, 2}, 'd', 0x200000001},
        {"mov.b64 {%r5, %r0}, %rd1;", {0x200000001}, 'r', 2},
        {"mov.b64 {_, %r0}, %rd1;", {0x700000001}, 'r', 7},
        {"mov.b32 %r0, {%rs1, %rs2};", {0x1111, 0x2222}, 'r', 0x22221111},
        {"mov.b32 {%rs0, %rs5}, %r1;", {0x22221111}, 's', 0x1111},
        {"mov.b64 %rd0, {%rs1, %rs2, %rs3, %rs4};", {1, 2, 3, 4}, 'd', 0x0004000300020001},
        {"mov.b32 %f5, %r1; mov.b32 %r0, %f5;", {0x7fa00001}, 'r', 0x7fa00001},
        {"mov.u32 %r0, 0xdeadbeef;", {}, 'r', 0xdeadbeef},
        {"mov.s32 %r0, -7;", {}, 'r', uint32_t(-7)},
        {"mov.f32 %f0, 0f3F800000;", {}, 'f', f(1.0f)},
        {"mov.f32 %f0, 1.5;", {}, 'f', f(1.5f)},
        {"mov.f64 %fd0, 0d3FF8000000000000;", {}, 'F', d(1.5)},
        {"mov.pred %p0, %p1;", {3}, 'p', 1},
        {"mov.u32 %r0, %r9;", {}, 'r', 0}, // never written
        {".reg .v4 .f32 %v; mov.v4.f32 %v, {%f1, %f2, %f3, %f4}; add.f32 %f0, %v.x, %v.w;",
         {f(1), f(2), f(3), f(4)},
         'f',
         f(5)},
    });
}

} // namespace
} // namespace sunstone::compiler::testing
