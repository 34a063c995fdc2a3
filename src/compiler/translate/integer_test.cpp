// SPDX-License-Identifier: Apache-2.0
// Integer instructions with edge values.
#include "compiler/testing.h"

namespace sunstone::compiler::testing {
namespace {

constexpr uint64_t kMin32 = 0x80000000u, kMax32 = 0x7fffffffu, kAll32 = 0xffffffffu;
constexpr uint64_t kMin64 = 1ull << 63, kAll64 = ~0ull;

TEST(Integer, AddAndSubtract) {
    run({
        {"add.s32 %r0, %r1, %r2;", {kMax32, 1}, 'r', kMin32},
        {"add.sat.s32 %r0, %r1, %r2;", {kMax32, 1}, 'r', kMax32},
        {"add.sat.s32 %r0, %r1, %r2;", {kMin32, kAll32}, 'r', kMin32},
        {"sub.sat.s32 %r0, %r1, %r2;", {kMin32, 1}, 'r', kMin32},
        {"sub.s32 %r0, %r1, %r2;", {0, 1}, 'r', kAll32},
        {"add.u64 %rd0, %rd1, %rd2;", {kAll64, 2}, 'd', 1},
        {"add.s16 %rs0, %rs1, %rs2;", {0x7fff, 1}, 's', 0x8000},
        {"add.cc.u32 %r5, %r1, %r2; addc.u32 %r0, %r3, %r4;", {kAll32, 1, 5, 7}, 'r', 13},
        {"add.cc.u32 %r5, %r1, %r2; addc.cc.u32 %r6, %r3, %r4; addc.u32 %r0, 0, 0;",
         {kAll32, 1, kAll32, 0},
         'r',
         1},
        {"sub.cc.u32 %r5, %r1, %r2; subc.u32 %r0, %r3, %r4;", {0, 1, 5, 2}, 'r', 2},
        {"sub.cc.u64 %rd5, %rd1, %rd2; subc.u64 %rd0, %rd3, %rd4;", {1, 1, 5, 2}, 'd', 3},
        {"mad.lo.cc.u32 %r5, %r1, %r2, %r3; madc.hi.u32 %r0, %r1, %r2, 0;", {kAll32, 2, 2}, 'r', 2},
    });
}

TEST(Integer, Multiply) {
    run({
        {"mul.lo.s32 %r0, %r1, %r2;", {kMin32, kAll32}, 'r', kMin32},
        {"mul.hi.s32 %r0, %r1, %r2;", {kMin32, kMin32}, 'r', 0x40000000},
        {"mul.hi.u32 %r0, %r1, %r2;", {kAll32, kAll32}, 'r', 0xfffffffe},
        {"mul.hi.s64 %rd0, %rd1, %rd2;", {kAll64, kAll64}, 'd', 0},
        {"mul.hi.u64 %rd0, %rd1, %rd2;", {kAll64, kAll64}, 'd', kAll64 - 1},
        {"mul.wide.s32 %rd0, %r1, %r2;", {kAll32, 5}, 'd', uint64_t(-5)},
        {"mul.wide.u32 %rd0, %r1, %r2;", {kAll32, 5}, 'd', 5 * kAll32},
        {"mul.wide.u16 %r0, %rs1, %rs2;", {0xffff, 0xffff}, 'r', 0xfffe0001},
        {"mul.wide.s16 %r0, %rs1, %rs2;", {0xffff, 3}, 'r', uint32_t(-3)},
        {"mad.lo.s32 %r0, %r1, %r2, %r3;", {3, 4, 5}, 'r', 17},
        {"mad.hi.s32 %r0, %r1, %r2, %r3;", {kMin32, 4, 5}, 'r', 3},
        {"mad.hi.sat.s32 %r0, %r1, %r2, %r3;", {kMax32, kMax32, kMax32}, 'r', kMax32},
        {"mad.wide.u32 %rd0, %r1, %r2, %rd3;", {kAll32, 2, 1}, 'd', 2 * kAll32 + 1},
        {"mad.wide.s32 %rd0, %r1, %r2, %rd3;", {kAll32, 2, 1}, 'd', kAll64},
        {"mul24.lo.s32 %r0, %r1, %r2;", {0x00ffffff, 2}, 'r', uint32_t(-2)},
        {"mul24.lo.u32 %r0, %r1, %r2;", {0xff000003, 5}, 'r', 15},
        {"mul24.hi.u32 %r0, %r1, %r2;", {0xffffff, 0xffffff}, 'r', 0xfffffe00},
        {"mad24.lo.u32 %r0, %r1, %r2, %r3;", {7, 6, 5}, 'r', 47},
    });
}

TEST(Integer, Divide) {
    run({
        {"div.s32 %r0, %r1, %r2;", {uint32_t(-7), 2}, 'r', uint32_t(-3)},
        {"div.s32 %r0, %r1, %r2;", {kMin32, kAll32}, 'r', kMin32},
        {"div.u32 %r0, %r1, %r2;", {5, 0}, 'r', kAll32},
        {"div.u16 %rs0, %rs1, %rs2;", {100, 7}, 's', 14},
        {"div.s64 %rd0, %rd1, %rd2;", {kMin64, kAll64}, 'd', kMin64},
        {"rem.s32 %r0, %r1, %r2;", {uint32_t(-7), 2}, 'r', kAll32},
        {"rem.s32 %r0, %r1, %r2;", {kMin32, kAll32}, 'r', 0},
        {"rem.u32 %r0, %r1, %r2;", {17, 5}, 'r', 2},
        {"rem.u32 %r0, %r1, %r2;", {17, 0}, 'r', kAll32},
        {"rem.u64 %rd0, %rd1, %rd2;", {kAll64, 10}, 'd', 5},
    });
}

TEST(Integer, SignsAndOrder) {
    run({
        {"neg.s32 %r0, %r1;", {kMin32}, 'r', kMin32},
        {"abs.s32 %r0, %r1;", {kMin32}, 'r', kMin32},
        {"abs.s64 %rd0, %rd1;", {uint64_t(-9)}, 'd', 9},
        {"abs.s16 %rs0, %rs1;", {0xfff7}, 's', 9},
        {"min.s32 %r0, %r1, %r2;", {kAll32, 1}, 'r', kAll32},
        {"min.u32 %r0, %r1, %r2;", {kAll32, 1}, 'r', 1},
        {"max.s32 %r0, %r1, %r2;", {kAll32, 1}, 'r', 1},
        {"max.u64 %rd0, %rd1, %rd2;", {kAll64, 1}, 'd', kAll64},
        {"min.s64 %rd0, %rd1, %rd2;", {kMin64, 1}, 'd', kMin64},
        {"sad.s32 %r0, %r1, %r2, %r3;", {uint32_t(-5), 3, 10}, 'r', 18},
        {"sad.u32 %r0, %r1, %r2, %r3;", {3, 8, 10}, 'r', 15},
    });
}

TEST(Integer, Shifts) {
    run({
        {"shl.b32 %r0, %r1, %r2;", {1, 31}, 'r', kMin32},
        {"shl.b32 %r0, %r1, %r2;", {1, 32}, 'r', 0},
        {"shl.b32 %r0, %r1, %r2;", {1, kAll32}, 'r', 0},
        {"shr.u32 %r0, %r1, %r2;", {kMin32, 33}, 'r', 0},
        {"shr.s32 %r0, %r1, %r2;", {kMin32, 33}, 'r', kAll32},
        {"shr.s32 %r0, %r1, %r2;", {kMax32, 100}, 'r', 0},
        {"shl.b64 %rd0, %rd1, %r2;", {1, 63}, 'd', kMin64},
        {"shl.b64 %rd0, %rd1, %r2;", {1, 64}, 'd', 0},
        {"shr.s64 %rd0, %rd1, %r2;", {kMin64, 64}, 'd', kAll64},
        {"shr.u16 %rs0, %rs1, %r2;", {0x8000, 15}, 's', 1},
        {"shr.s16 %rs0, %rs1, %r2;", {0x8000, 20}, 's', 0xffff},
        {"shl.b16 %rs0, %rs1, %r2;", {1, 16}, 's', 0},
        {"shf.l.wrap.b32 %r0, %r1, %r2, %r3;", {kMin32, 1, 33}, 'r', 3},
        {"shf.l.clamp.b32 %r0, %r1, %r2, %r3;", {0xabcd, 1, 40}, 'r', 0xabcd},
        {"shf.r.wrap.b32 %r0, %r1, %r2, %r3;", {0x10, 1, 4}, 'r', 0x10000001},
        {"shf.r.clamp.b32 %r0, %r1, %r2, %r3;", {0x10, 7, 32}, 'r', 7},
        {"shf.r.wrap.b32 %r0, %r1, %r2, %r3;", {0x10, 7, 32}, 'r', 0x10},
    });
}

TEST(Integer, Fields) {
    run({
        {"bfe.u32 %r0, %r1, %r2, %r3;", {0xabcdef12, 8, 8}, 'r', 0xef},
        {"bfe.s32 %r0, %r1, %r2, %r3;", {0xabcdef12, 8, 8}, 'r', 0xffffffef},
        {"bfe.s32 %r0, %r1, %r2, %r3;", {kMin32, 28, 8}, 'r', 0xfffffff8},
        {"bfe.u32 %r0, %r1, %r2, %r3;", {kAll32, 40, 8}, 'r', 0},
        {"bfe.s32 %r0, %r1, %r2, %r3;", {kMin32, 40, 8}, 'r', kAll32},
        {"bfe.s32 %r0, %r1, %r2, %r3;", {kAll32, 4, 0}, 'r', 0},
        {"bfe.u32 %r0, %r1, %r2, %r3;", {kAll32, 0, 32}, 'r', kAll32},
        {"bfe.u64 %rd0, %rd1, %r2, %r3;", {kAll64, 60, 8}, 'd', 15},
        {"bfi.b32 %r0, %r1, %r2, %r3, %r4;", {0xff, 0, 8, 4}, 'r', 0xf00},
        {"bfi.b32 %r0, %r1, %r2, %r3, %r4;", {kAll32, 0x1234, 32, 4}, 'r', 0x1234},
        {"bfi.b32 %r0, %r1, %r2, %r3, %r4;", {kAll32, 0x1234, 4, 0}, 'r', 0x1234},
        {"bfi.b32 %r0, %r1, %r2, %r3, %r4;", {kAll32, 0, 28, 32}, 'r', 0xf0000000},
        {"bfi.b64 %rd0, %rd1, %rd2, %r3, %r4;", {5, 0, 62, 4}, 'd', kMin64 >> 1},
        {"bmsk.clamp.b32 %r0, %r1, %r2;", {4, 8}, 'r', 0xff0},
        {"bmsk.clamp.b32 %r0, %r1, %r2;", {4, 100}, 'r', 0xfffffff0},
        {"bmsk.clamp.b32 %r0, %r1, %r2;", {40, 4}, 'r', 0},
        {"bmsk.wrap.b32 %r0, %r1, %r2;", {36, 40}, 'r', 0xff0},
    });
}

TEST(Integer, Counting) {
    run({
        {"clz.b32 %r0, %r1;", {0}, 'r', 32},
        {"clz.b32 %r0, %r1;", {1}, 'r', 31},
        {"clz.b64 %r0, %rd1;", {0}, 'r', 64},
        {"clz.b64 %r0, %rd1;", {1}, 'r', 63},
        {"popc.b32 %r0, %r1;", {0xf0f0}, 'r', 8},
        {"popc.b64 %r0, %rd1;", {kAll64}, 'r', 64},
        {"brev.b32 %r0, %r1;", {1}, 'r', kMin32},
        {"brev.b64 %rd0, %rd1;", {1}, 'd', kMin64},
        {"bfind.u32 %r0, %r1;", {0}, 'r', kAll32},
        {"bfind.u32 %r0, %r1;", {0x100}, 'r', 8},
        {"bfind.s32 %r0, %r1;", {kAll32}, 'r', kAll32},
        {"bfind.s32 %r0, %r1;", {uint32_t(-256)}, 'r', 7},
        {"bfind.shiftamt.u32 %r0, %r1;", {0x100}, 'r', 23},
        {"bfind.shiftamt.u32 %r0, %r1;", {0}, 'r', kAll32},
        {"bfind.u64 %r0, %rd1;", {kMin64}, 'r', 63},
        {"fns.b32 %r0, %r1, %r2, %r3;", {0xaaaaaaaa, 3, 1}, 'r', 3},
        {"fns.b32 %r0, %r1, %r2, %r3;", {0xaaaaaaaa, 3, 3}, 'r', 7},
        {"fns.b32 %r0, %r1, %r2, %r3;", {0xaaaaaaaa, 3, uint32_t(-2)}, 'r', 1},
        {"fns.b32 %r0, %r1, %r2, %r3;", {0, 3, 1}, 'r', kAll32},
    });
}

TEST(Integer, Logic) {
    run({
        {"and.b32 %r0, %r1, %r2;", {0xff00, 0x0ff0}, 'r', 0x0f00},
        {"or.b64 %rd0, %rd1, %rd2;", {kMin64, 1}, 'd', kMin64 | 1},
        {"xor.b16 %rs0, %rs1, %rs2;", {0xffff, 0x0f0f}, 's', 0xf0f0},
        {"not.b32 %r0, %r1;", {0}, 'r', kAll32},
        {"cnot.b32 %r0, %r1;", {0}, 'r', 1},
        {"cnot.b32 %r0, %r1;", {7}, 'r', 0},
        {"lop3.b32 %r0, %r1, %r2, %r3, 0x96;", {0xff, 0x0f, 0x33}, 'r', 0xff ^ 0x0f ^ 0x33},
        {"lop3.b32 %r0, %r1, %r2, %r3, 0x80;", {0xff, 0x0f, 0x33}, 'r', 3},
        {"lop3.b32 %r0, %r1, %r2, %r3, 0xca;", {0xf0, 0xaa, 0x55}, 'r', 0xa5},
        {"and.pred %p0, %p1, %p2;", {1, 0}, 'p', 0},
        {"xor.pred %p0, %p1, %p2;", {1, 0}, 'p', 1},
        {"not.pred %p0, %p1;", {1}, 'p', 0},
        {"prmt.b32 %r0, %r1, %r2, %r3;", {0x33221100, 0x77665544, 0x7531}, 'r', 0x77553311},
        {"prmt.b32 %r0, %r1, %r2, %r3;", {0x80, 0, 0x0008}, 'r', 0x808080ff},
        {"prmt.b32.f4e %r0, %r1, %r2, %r3;", {0x33221100, 0x77665544, 2}, 'r', 0x55443322},
        {"prmt.b32.b4e %r0, %r1, %r2, %r3;", {0x33221100, 0x77665544, 1}, 'r', 0x66770011},
        {"prmt.b32.rc8 %r0, %r1, %r2, %r3;", {0x33221100, 0, 2}, 'r', 0x22222222},
        {"prmt.b32.ecl %r0, %r1, %r2, %r3;", {0x33221100, 0, 2}, 'r', 0x33222222},
        {"prmt.b32.ecr %r0, %r1, %r2, %r3;", {0x33221100, 0, 2}, 'r', 0x22221100},
        {"prmt.b32.rc16 %r0, %r1, %r2, %r3;", {0x33221100, 0, 1}, 'r', 0x33223322},
        {"dp4a.s32.s32 %r0, %r1, %r2, %r3;", {0xff010203, 0x01010101, 10}, 'r', 15},
        {"dp4a.u32.u32 %r0, %r1, %r2, %r3;", {0xff010203, 0x01010101, 10}, 'r', 271},
        {"dp2a.lo.u32.u32 %r0, %r1, %r2, %r3;", {0x00020003, 0x0504, 1}, 'r', 23},
    });
}

} // namespace
} // namespace sunstone::compiler::testing
