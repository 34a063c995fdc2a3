// SPDX-License-Identifier: Apache-2.0
// Control flow, guards, memory, variables, calls, barriers and printf of kernels.
#include "compiler/testing.h"

#include <cstdio>
#include <map>

namespace sunstone::compiler::testing {
namespace {

using devlib::BlockFunctions;
using devlib::KernelFn;
using devlib::KernelThread;

uint64_t f(float value) {
    return bits(value);
}

KernelFn kernelOf(const KernelCode& code, const std::string& name) {
    for (const KernelInfo& kernel : code.kernels())
        if (kernel.name == name)
            return reinterpret_cast<KernelFn>(const_cast<void*>(kernel.address));
    ADD_FAILURE() << "no kernel " << name;
    return nullptr;
}

TEST(Control, Guards) {
    run({
        {"mov.u32 %r0, 5; @%p1 add.u32 %r0, %r0, 1;", {1}, 'r', 6},
        {"mov.u32 %r0, 5; @!%p1 add.u32 %r0, %r0, 1;", {1}, 'r', 5},
        {"@%p1 bra L; mov.u32 %r0, 1; bra.uni M; L: mov.u32 %r0, 2; M:", {1}, 'r', 2},
        {"@!%p1 bra L; mov.u32 %r0, 1; bra M; L: mov.u32 %r0, 2; M:", {1}, 'r', 1},
        {"mov.u32 %r0, 3; @%p1 st.u32 [%in], 9; @%p1 ld.u32 %r0, [%in];", {1}, 'r', 9},
        {"mov.u32 %r0, 3; @%p1 ld.u32 %r0, [0];", {0}, 'r', 3},
        {"mov.u32 %r0, 1; st.u32 [%out], 77; @%p1 ret; mov.u32 %r0, 2;", {1}, 'r', 77},
        {"mov.u32 %r0, 0; mov.u32 %r5, 0; L: add.u32 %r0, %r0, %r5; add.u32 %r5, %r5, 1; "
         "setp.lt.u32 %p5, %r5, %r1; @%p5 bra L;",
         {10},
         'r',
         45},
        {"@%p1 setp.eq.u32 %p0, %r1, %r1;", {1}, 'p', 1},
        {"mov.u32 %r7, 8; @%p1 mov.b64 {%r0, %r7}, %rd2; add.u32 %r0, %r0, %r7;",
         {1, 3ull << 32 | 4},
         'r',
         7},
        {"ts: .branchtargets A, B, C; brx.idx %r1, ts; A: mov.u32 %r0, 1; bra E; "
         "B: mov.u32 %r0, 2; bra E; C: mov.u32 %r0, 3; E:",
         {1},
         'r',
         2},
    });
}

TEST(Memory, AccessWidths) {
    run({
        {"ld.u8 %r0, [%in];", {0x1ff}, 'r', 0xff},
        {"ld.s8 %r0, [%in];", {0x1ff}, 'r', 0xffffffff},
        {"ld.s16 %r0, [%in];", {0x8000}, 'r', 0xffff8000},
        {"ld.s32 %rd0, [%in];", {0x80000000}, 'd', 0xffffffff80000000},
        {"ld.v2.u32 {%r5, %r0}, [%in];", {0x500000001}, 'r', 5},
        {"ld.v4.u8 {%r5, %r6, %r7, %r0}, [%in];", {0x04030201}, 'r', 4},
        {"ld.v2.u64 {%rd5, %rd0}, [%in];", {1, 2}, 'd', 2},
        {"ld.global.nc.v4.f32 {%f5, %f6, %f7, %f0}, [%in];", {0, f(7.0f) << 32}, 'f', f(7.0f)},
        {"st.v2.u16 [%in+4], {%rs1, %rs2}; ld.u32 %r0, [%in+4];",
         {0x1111, 0x2222},
         'r',
         0x22221111},
        {"add.u64 %rd5, %in, 16; ld.u32 %r0, [%rd5+-8];", {1, 42}, 'r', 42},
        {"st.volatile.u32 [%in], 6; ld.volatile.u32 %r0, [%in];", {}, 'r', 6},
        {"st.release.gpu.u32 [%in], 6; ld.acquire.gpu.u32 %r0, [%in];", {}, 'r', 6},
        {"cvta.to.global.u64 %rd5, %in; ld.global.u32 %r0, [%rd5];", {9}, 'r', 9},
        {".local .align 8 .b8 depot[16]; mov.u64 %rd5, depot; cvta.local.u64 %rd6, %rd5; "
         "st.local.u32 [%rd5+4], %r1; add.u64 %rd6, %rd6, 4; ld.u32 %r0, [%rd6];",
         {12},
         'r',
         12},
        {".local .u32 a[4]; mov.u64 %rd5, a; and.b32 %r5, %r1, 3; mul.wide.u32 %rd6, %r5, 4; "
         "add.u64 %rd5, %rd5, %rd6; st.local.u32 [%rd5], 31; ld.local.u32 %r0, [a+8];",
         {2},
         'r',
         31},
        // Words as addresses.
        {".local .u32 w[4]; mov.u32 %r5, w; add.u32 %r5, %r5, 8; st.local.u32 [%r5+4], %r1; "
         "st.local.u32 [%r5+-8], 5; ld.local.u32 %r6, [w+12]; ld.local.u32 %r7, [w]; "
         "add.u32 %r0, %r6, %r7;",
         {37},
         'r',
         42},
        {".const .u32 c[3] = {7, 8, 9}; mov.u32 %r5, c; ld.const.u32 %r0, [%r5+8];", {}, 'r', 9},
    });
}

TEST(Memory, Atomics) {
    run({
        {"atom.add.u32 %r5, [%in], 3; ld.u32 %r0, [%in];", {4}, 'r', 7},
        {"atom.global.add.f32 %f5, [%in], 0f3F800000; ld.f32 %f0, [%in];", {f(2.0f)}, 'f', f(3.0f)},
        {"atom.add.f64 %fd0, [%in], 0d3FF0000000000000;", {bits(2.0)}, 'F', bits(2.0)},
        {"atom.min.s32 %r5, [%in], -3; ld.u32 %r0, [%in];", {4}, 'r', uint32_t(-3)},
        {"atom.max.u32 %r5, [%in], -3; ld.u32 %r0, [%in];", {4}, 'r', uint32_t(-3)},
        {"atom.inc.u32 %r5, [%in], 4; ld.u32 %r0, [%in];", {4}, 'r', 0},
        {"atom.dec.u32 %r5, [%in], 4; ld.u32 %r0, [%in];", {0}, 'r', 4},
        {"atom.exch.b64 %rd0, [%in], 5;", {9}, 'd', 9},
        {"atom.cas.b32 %r5, [%in], 9, 4; ld.u32 %r0, [%in];", {9}, 'r', 4},
        {"atom.cas.b32 %r0, [%in], 8, 4;", {9}, 'r', 9},
        {"red.global.or.b32 [%in], 6; ld.u32 %r0, [%in];", {1}, 'r', 7},
        {"red.relaxed.gpu.global.add.u64 [%in], 6; ld.u64 %rd0, [%in];", {1}, 'd', 7},
        {"membar.gl; fence.acq_rel.gpu; atom.and.b32 %r5, [%in], 6; ld.u32 %r0, [%in];",
         {3},
         'r',
         2},
    });
}

TEST(Call, FunctionsOfEveryShape) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.func (.param .b32 out) fib(.param .b32 n) {
  .reg .b32 %r<6>; .reg .pred %p;
  ld.param.u32 %r0, [n]; setp.lt.u32 %p, %r0, 2; @%p bra done;
  sub.u32 %r1, %r0, 1;
  { .param .b32 a; .param .b32 b; st.param.b32 [a], %r1; call.uni (b), fib, (a); ld.param.b32 %r2, [b]; }
  sub.u32 %r1, %r0, 2;
  { .param .b32 a; .param .b32 b; st.param.b32 [a], %r1; call.uni (b), fib, (a); ld.param.b32 %r3, [b]; }
  add.u32 %r0, %r2, %r3;
done: st.param.b32 [out], %r0; ret;
}
.func (.param .align 4 .b8 out[8]) swapped(.param .align 4 .b8 pair[8], .param .f32 scale) {
  .reg .f32 %f<4>;
  ld.param.f32 %f0, [pair]; ld.param.f32 %f1, [pair+4]; ld.param.f32 %f2, [scale];
  mul.f32 %f0, %f0, %f2; mul.f32 %f1, %f1, %f2;
  st.param.f32 [out], %f1; st.param.f32 [out+4], %f0; ret;
}
.func (.reg .u32 a, .reg .u64 b) both(.reg .u32 x) {
  add.u32 a, x, 1; cvt.u64.u32 b, x; mul.lo.u64 b, b, 10; ret;
}
.func (.param .b32 r) twice(.param .b32 x) { .reg .b32 %r; ld.param.b32 %r, [x]; shl.b32 %r, %r, 1; st.param.b32 [r], %r; ret; }
.func (.param .b32 r) thrice(.param .b32 x) { .reg .b32 %r; ld.param.b32 %r, [x]; mul.lo.u32 %r, %r, 3; st.param.b32 [r], %r; ret; }
.global .u64 table[2] = {twice, thrice};
.visible .entry k(.param .u64 p) {
  .reg .b64 %rd<9>; .reg .b32 %r<9>; .reg .f32 %f<9>;
  ld.param.u64 %rd1, [p];
  { .param .b32 a; .param .b32 b; st.param.b32 [a], 10; call.uni (b), fib, (a); ld.param.b32 %r1, [b]; }
  st.u32 [%rd1], %r1;
  { .param .align 4 .b8 a[8]; .param .f32 s; .param .align 4 .b8 b[8];
    st.param.f32 [a], 0f3F800000; st.param.f32 [a+4], 0f40000000; st.param.f32 [s], 0f41200000;
    call.uni (b), swapped, (a, s); ld.param.f32 %f1, [b]; ld.param.f32 %f2, [b+4]; }
  st.f32 [%rd1+4], %f1; st.f32 [%rd1+8], %f2;
  call (%r2, %rd2), both, (7);
  st.u32 [%rd1+12], %r2; st.u64 [%rd1+16], %rd2;
  ld.u32 %r3, [%rd1+24]; mul.wide.u32 %rd3, %r3, 8; mov.u64 %rd4, table; add.u64 %rd4, %rd4, %rd3;
  ld.global.u64 %rd5, [%rd4];
  { .param .b32 a; .param .b32 b; st.param.b32 [a], 21;
    prototype_0 : .callprototype (.param .b32 _) _ (.param .b32 _);
    call (b), %rd5, (a), prototype_0; ld.param.b32 %r4, [b]; }
  st.u32 [%rd1+28], %r4;
  ret;
}
)"));
    for (uint32_t which : {0u, 1u}) {
        alignas(8) uint32_t out[8] = {};
        out[6] = which;
        uint32_t* pointer = out;
        KernelThread thread{};
        kernelOf(*code, "k")(&thread, &pointer);
        EXPECT_EQ(out[0], 55u);
        EXPECT_EQ(out[1], f(20.0f));
        EXPECT_EQ(out[2], f(10.0f));
        EXPECT_EQ(out[3], 8u);
        EXPECT_EQ(out[4], 70u);
        EXPECT_EQ(out[7], which ? 63u : 42u);
    }
}

// A block declares the function that it calls; the definition stands before or after the kernel.
TEST(Call, FunctionsDeclaredInBodies) {
    const auto definition = [](const char* name, int factor) {
        return std::string(".func (.reg .u32 r) ") + name +
               "(.param .b64 a) { .reg .b64 %rd; ld.param.u64 %rd, [a]; ld.u32 r, [%rd]; "
               "mul.lo.u32 r, r, " +
               std::to_string(factor) + "; ret; }\n";
    };
    const auto code = compileKernels(parse(kHeader + definition("before", 3) + R"(
.visible .entry k(.param .u64 p) {
  .reg .b64 %rd; .reg .u32 %r<3>; .reg .pred %p;
  ld.param.u64 %rd, [p]; mov.u32 %r2, 0;
again:
  { .func (.reg .u32 r) before(.param .b64 a); call.uni (%r1), before, (%rd); st.u32 [%rd], %r1; }
  { .extern .func (.reg .u32 r) after(.param .b64 a);
    { .func (.reg .u32 r) after(.param .b64 a); call.uni (%r1), after, (%rd); st.u32 [%rd], %r1; } }
  add.u32 %r2, %r2, 1; setp.lt.u32 %p, %r2, 2; @%p bra again;
  ret;
}
)" + definition("after", 5)));
    uint32_t value = 7;
    const uint32_t* pointer = &value;
    KernelThread thread{};
    kernelOf(*code, "k")(&thread, &pointer);
    EXPECT_EQ(value, 7u * 15 * 15);
}

TEST(Variables, InitialisersAndLookUp) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.visible .const .align 4 .b8 short[8] = {1, 2};
.global .align 8 .u64 pointer = generic(target) + 4;
.global .align 4 .u32 target[2] = {5, 6};
.visible .global .align 4 .u32 counter;
.const .f32 numbers[3] = {0f3F800000, 2.5, 0f40400000};
.visible .entry k(.param .u64 p) {
  .reg .b64 %rd<9>; .reg .b32 %r<9>;
  ld.param.u64 %rd1, [p];
  ld.const.u32 %r1, [short]; st.u32 [%rd1], %r1;
  ld.const.u32 %r1, [short+4]; st.u32 [%rd1+4], %r1;
  ld.global.u64 %rd2, [pointer]; ld.u32 %r1, [%rd2]; st.u32 [%rd1+8], %r1;
  ld.const.b32 %r1, [numbers+4]; st.u32 [%rd1+12], %r1;
  atom.global.add.u32 %r1, [counter], 5;
  ret;
}
)"));
    uint32_t out[4] = {9, 9, 9, 9};
    uint32_t* pointer = out;
    KernelThread thread{};
    kernelOf(*code, "k")(&thread, &pointer);
    EXPECT_EQ(out[0], 0x201u);
    EXPECT_EQ(out[1], 0u);
    EXPECT_EQ(out[2], 6u);
    EXPECT_EQ(out[3], f(2.5f));
    void* address = nullptr;
    uint64_t size = 0;
    ASSERT_TRUE(code->variable("counter", &address, &size));
    EXPECT_EQ(size, 4u);
    EXPECT_EQ(*static_cast<uint32_t*>(address), 5u);
    *static_cast<uint32_t*>(address) = 100; // as cudaMemcpyToSymbol does
    kernelOf(*code, "k")(&thread, &pointer);
    EXPECT_EQ(*static_cast<uint32_t*>(address), 105u);
    EXPECT_FALSE(code->variable("nothing", &address, &size));
}

// A launcher that records its calls and acts as a warp whose lanes all contribute `lane * 10`.
struct FakeBlock {
    const BlockFunctions* functions;
    std::vector<uint32_t> calls;
};
FakeBlock* blockOf(KernelThread* thread) {
    return static_cast<FakeBlock*>(thread->block);
}
uint32_t fakeBarrier(KernelThread* thread, uint32_t id, uint32_t threads, uint32_t reduction,
                     uint32_t value) {
    blockOf(thread)->calls.insert(blockOf(thread)->calls.end(), {id, threads, reduction, value});
    return reduction == devlib::kReduceCount ? 17 : 1;
}
void fakeArrive(KernelThread* thread, uint32_t id, uint32_t threads) {
    blockOf(thread)->calls.insert(blockOf(thread)->calls.end(), {100 + id, threads});
}
uint32_t fakeExchange(KernelThread* thread, uint32_t mask, uint64_t value, uint64_t values[32]) {
    for (unsigned lane = 0; lane < 32; ++lane)
        values[lane] = lane == thread->laneid ? value : value == 1 ? lane & 1 : lane * 10;
    return mask;
}
uint32_t fakeActive(KernelThread*, const void*) {
    return 0xf;
}
void fakeExit(KernelThread* thread) {
    blockOf(thread)->calls.push_back(999);
}
void fakeFault(KernelThread* thread, uint32_t kind) {
    blockOf(thread)->calls.insert(blockOf(thread)->calls.end(), {777, kind});
}
void fakeYield(KernelThread*) {}
const BlockFunctions kFunctions = {fakeBarrier, fakeArrive, fakeExchange, fakeActive,
                                   fakeExit,    fakeFault,  fakeYield};

TEST(Threads, BarriersAndWarps) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.shared .align 4 .b8 common[64];
.extern .shared .align 16 .b8 dynamic[];
.func helper() { bar.sync 3; ret; }
.visible .entry barriers(.param .u64 p) {
  .reg .b64 %rd<9>; .reg .b32 %r<9>; .reg .pred %p<4>; .shared .u32 own[4];
  ld.param.u64 %rd1, [p];
  call helper, ();
  barrier.sync 2, 64; bar.arrive 1, 32;
  setp.eq.u32 %p1, %r1, %r1;
  bar.red.popc.u32 %r1, 0, %p1; st.u32 [%rd1], %r1;
  st.shared.u32 [own+4], 11; ld.shared.u32 %r2, [own+4]; st.u32 [%rd1+4], %r2;
  mov.u64 %rd2, dynamic; st.shared.u32 [%rd2], 12;
  st.shared.u32 [common], 13;
  ret;
}
.visible .entry warps(.param .u64 p) {
  .reg .b64 %rd<9>; .reg .b32 %r<9>; .reg .pred %p<4>;
  ld.param.u64 %rd1, [p];
  mov.u32 %r1, 5;
  shfl.sync.down.b32 %r2|%p1, %r1, 2, 31, -1; st.u32 [%rd1], %r2;
  shfl.sync.up.b32 %r2|%p1, %r1, 8, 0, -1; selp.u32 %r2, 1, 0, %p1; st.u32 [%rd1+4], %r2;
  shfl.sync.bfly.b32 %r2, %r1, 1, 31, -1; st.u32 [%rd1+8], %r2;
  shfl.sync.idx.b32 %r2, %r1, 9, 31, -1; st.u32 [%rd1+12], %r2;
  setp.eq.u32 %p1, %r1, %r1;
  vote.sync.ballot.b32 %r2, %p1, -1; st.u32 [%rd1+16], %r2;
  vote.sync.all.pred %p2, %p1, -1; selp.u32 %r2, 1, 0, %p2; st.u32 [%rd1+20], %r2;
  activemask.b32 %r2; st.u32 [%rd1+24], %r2;
  mov.u32 %r3, %laneid; st.u32 [%rd1+28], %r3; mov.u32 %r3, %lanemask_lt; st.u32 [%rd1+32], %r3;
  mov.u32 %r3, 30; match.any.sync.b32 %r2, %r3, -1; st.u32 [%rd1+36], %r2;
  redux.sync.max.u32 %r2, %r3, 0xff; st.u32 [%rd1+40], %r2;
  bar.warp.sync -1;
  ret;
}
.visible .entry plain() { .reg .b32 %r; mov.u32 %r, %ntid.x; ret; }
.visible .entry trapping() { trap; }
)"));
    std::map<std::string, KernelInfo> kernels;
    for (const KernelInfo& kernel : code->kernels())
        kernels[kernel.name] = kernel;
    EXPECT_TRUE(kernels["barriers"].usesBarriers);
    EXPECT_FALSE(kernels["barriers"].usesWarpFunctions);
    EXPECT_TRUE(kernels["warps"].usesWarpFunctions);
    EXPECT_FALSE(kernels["plain"].usesBarriers);
    EXPECT_FALSE(kernels["plain"].usesWarpFunctions);
    EXPECT_EQ(kernels["barriers"].staticSharedBytes, 80u);
    EXPECT_EQ(kernels["plain"].staticSharedBytes, 0u);

    alignas(16) uint8_t shared[128] = {};
    FakeBlock block{&kFunctions, {}};
    KernelThread thread{};
    thread.block = &block;
    thread.shared = shared;
    thread.laneid = 3;
    uint32_t out[16] = {};
    uint32_t* pointer = out;
    kernelOf(*code, "barriers")(&thread, &pointer);
    const std::vector<uint32_t> expected = {3, 0, 0, 0, 2, 64, 0, 0, 101, 32, 0, 0, 3, 1};
    EXPECT_EQ(block.calls, expected);
    EXPECT_EQ(out[0], 17u);
    EXPECT_EQ(out[1], 11u);
    uint32_t dynamic = 0;
    std::memcpy(&dynamic, shared + 80, 4);
    EXPECT_EQ(dynamic, 12u);

    kernelOf(*code, "warps")(&thread, &pointer);
    EXPECT_EQ(out[0], 50u);
    EXPECT_EQ(out[1], 0u);
    EXPECT_EQ(out[2], 20u);
    EXPECT_EQ(out[3], 90u);
    EXPECT_EQ(out[4], 0xaaaaaaaau);
    EXPECT_EQ(out[5], 0u);
    EXPECT_EQ(out[6], 0xfu);
    EXPECT_EQ(out[7], 3u);
    EXPECT_EQ(out[8], 7u);
    EXPECT_EQ(out[9], 8u);
    EXPECT_EQ(out[10], 70u);

    block.calls.clear();
    kernelOf(*code, "trapping")(&thread, nullptr);
    EXPECT_EQ(block.calls, (std::vector<uint32_t>{777, devlib::kFaultTrap}));
}

TEST(Threads, SpacesOfAddresses) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.shared .align 4 .b8 common[64];
.visible .entry k(.param .u64 p, .param .u64 q) {
  .reg .b64 %rd<9>; .reg .b32 %r<9>; .reg .pred %p;
  ld.param.u64 %rd1, [p]; mov.u64 %rd2, common;
  add.u64 %rd3, %rd2, 63; isspacep.shared %p, %rd3; selp.u32 %r1, 1, 0, %p; st.u32 [%rd1], %r1;
  add.u64 %rd3, %rd2, 79; isspacep.shared::cta %p, %rd3; selp.u32 %r1, 1, 0, %p; st.u32 [%rd1+4], %r1;
  add.u64 %rd3, %rd2, 80; isspacep.shared %p, %rd3; selp.u32 %r1, 1, 0, %p; st.u32 [%rd1+8], %r1;
  sub.u64 %rd3, %rd2, 1; isspacep.shared %p, %rd3; selp.u32 %r1, 1, 0, %p; st.u32 [%rd1+12], %r1;
  mov.u64 %rd4, q; add.u64 %rd3, %rd4, 7;
  isspacep.param %p, %rd3; selp.u32 %r1, 1, 0, %p; st.u32 [%rd1+16], %r1;
  isspacep.param %p, %rd2; selp.u32 %r1, 1, 0, %p; st.u32 [%rd1+20], %r1;
  ret;
}
.func (.reg .pred %r) asked(.reg .b64 %a) { isspacep.param %r, %a; ret; }
.visible .entry other(.param .u64 p) {
  .reg .b64 %rd<3>; .reg .pred %p; mov.u64 %rd1, p; call (%p), asked, (%rd1); ret;
}
)"));
    alignas(16) uint8_t shared[128] = {};
    KernelThread thread{};
    thread.shared = shared + 16;
    thread.sharedBytes = 80; // 64 of the variable, the others dynamic
    uint32_t out[6] = {};
    uint32_t* pointers[2] = {out, nullptr};
    kernelOf(*code, "k")(&thread, pointers);
    EXPECT_EQ((std::vector<uint32_t>(out, out + 6)), (std::vector<uint32_t>{1, 1, 0, 0, 1, 0}));
    EXPECT_NE(code->kernels()[1].unsupported.find("space of parameters"), std::string::npos);
}

TEST(Threads, CopiesAndBarrierObjects) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.visible .entry copies(.param .u64 p) {
  .reg .b64 %rd<9>; .reg .b32 %r<9>; .reg .pred %q; .shared .align 16 .b8 to[64];
  ld.param.u64 %rd1, [p];
  cp.async.ca.shared.global [to], [%rd1], 4;
  cp.async.cg.shared.global.L2::128B [to+16], [%rd1], 16;
  mov.u32 %r1, 5;
  cp.async.ca.shared.global [to+32], [%rd1], 8, %r1;
  cp.async.ca.shared.global [to+40], [%rd1], 8, 0;
  cp.async.commit_group; cp.async.wait_group 0; cp.async.wait_all;
  mov.u32 %r2, 12;
  cp.async.bulk.global.shared::cta.bulk_group [%rd1+64], [to+16], %r2;
  cp.async.bulk.commit_group; cp.async.bulk.wait_group.read 0;
  ret;
}
.visible .entry phases(.param .u64 p) {
  .reg .b64 %rd<9>; .reg .b32 %r<9>; .reg .pred %q<9>; .shared .b64 object;
  ld.param.u64 %rd1, [p];
  mbarrier.init.shared.b64 [object], 3;
  mbarrier.arrive.shared.b64 %rd2, [object];
  mbarrier.pending_count.b64 %r1, %rd2; st.u32 [%rd1], %r1;
  mbarrier.test_wait.shared.b64 %q1, [object], %rd2; selp.u32 %r1, 1, 0, %q1; st.u32 [%rd1+4], %r1;
  mbarrier.arrive_drop.shared.b64 %rd3, [object];
  mbarrier.arrive.shared.b64 %rd3, [object], 1;
  mbarrier.pending_count.b64 %r1, %rd3; st.u32 [%rd1+8], %r1;
  mbarrier.try_wait.shared.b64 %q1, [object], %rd2; selp.u32 %r1, 1, 0, %q1; st.u32 [%rd1+12], %r1;
  mbarrier.test_wait.parity.shared.b64 %q1, [object], 1; selp.u32 %r1, 1, 0, %q1; st.u32 [%rd1+16], %r1;
  mbarrier.arrive.expect_tx.shared.b64 %rd2, [object], 32;
  mbarrier.pending_count.b64 %r1, %rd2; st.u32 [%rd1+20], %r1;
  mbarrier.arrive.shared.b64 _, [object];
  mbarrier.test_wait.shared.b64 %q1, [object], %rd2; selp.u32 %r1, 1, 0, %q1; st.u32 [%rd1+24], %r1;
  mov.u32 %r3, 32; mov.u64 %rd4, object;
  cp.async.bulk.shared::cta.global.mbarrier::complete_tx::bytes [%rd4+8], [%rd1+64], %r3, [%rd4];
  mbarrier.test_wait.shared.b64 %q1, [object], %rd2; selp.u32 %r1, 1, 0, %q1; st.u32 [%rd1+28], %r1;
  cp.async.mbarrier.arrive.shared.b64 [object];
  cp.async.mbarrier.arrive.noinc.shared.b64 [object];
  mbarrier.arrive.shared.b64 %rd3, [object];
  mbarrier.pending_count.b64 %r1, %rd3; st.u32 [%rd1+32], %r1;
  mbarrier.inval.shared.b64 [object];
  ret;
}
)"));
    alignas(16) uint8_t shared[128];
    std::memset(shared, 0xEE, sizeof shared);
    FakeBlock block{&kFunctions, {}};
    KernelThread thread{};
    thread.block = &block;
    thread.shared = shared;
    uint8_t bytes[128];
    for (unsigned i = 0; i < sizeof bytes; ++i)
        bytes[i] = uint8_t(i + 1);
    uint8_t* pointer = bytes;
    kernelOf(*code, "copies")(&thread, &pointer);
    EXPECT_EQ(shared[3], 4);
    EXPECT_EQ(shared[4], 0xEE);
    EXPECT_EQ(std::memcmp(shared + 16, bytes, 16), 0);
    const uint8_t partly[16] = {1, 2, 3, 4, 5};
    EXPECT_EQ(std::memcmp(shared + 32, partly, 16), 0);
    EXPECT_EQ(bytes[64 + 11], 12);
    EXPECT_EQ(bytes[64 + 12], 77);

    alignas(8) uint32_t out[64] = {};
    pointer = reinterpret_cast<uint8_t*>(out);
    kernelOf(*code, "phases")(&thread, &pointer);
    const uint32_t expected[9] = {3, 0, 1, 1, 0, 2, 0, 1, 1};
    for (unsigned i = 0; i < 9; ++i)
        EXPECT_EQ(out[i], expected[i]) << i;
}

TEST(Printf, FormatsThePackedBuffer) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.extern .func (.param .b32 r) vprintf (.param .b64 format, .param .b64 arguments);
.global .align 1 .b8 text[40] = {37,100,32,37,53,46,50,102,32,37,115,32,37,108,108,120,32,37,37,32,37,99,10,0};
.global .align 1 .b8 word[4] = {97,98,99,0};
.visible .entry k() {
  .local .align 8 .b8 depot[40]; .reg .b64 %rd<9>; .reg .b32 %r<4>;
  mov.u64 %rd1, depot; cvta.local.u64 %rd2, %rd1;
  st.local.u32 [%rd1], -7; st.local.f64 [%rd1+8], 0d3FF4000000000000;
  mov.u64 %rd3, word; st.local.u64 [%rd1+16], %rd3;
  mov.u64 %rd4, 0xabcdef012345; st.local.u64 [%rd1+24], %rd4; st.local.u32 [%rd1+32], 81;
  mov.u64 %rd5, text;
  { .param .b64 a; .param .b64 b; .param .b32 r; st.param.b64 [a], %rd5; st.param.b64 [b], %rd2;
    call.uni (r), vprintf, (a, b); ld.param.b32 %r1, [r]; }
  ret;
}
)"));
    ::testing::internal::CaptureStdout();
    KernelThread thread{};
    kernelOf(*code, "k")(&thread, nullptr);
    std::fflush(stdout);
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "-7  1.25 abc abcdef012345 % Q\n");
}

TEST(Kernels, ParametersAndUnsupported) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.visible .entry k(.param .u8 a, .param .align 8 .b8 b[12], .param .u64 c) .maxntid 64, 2, 1 { ret; }
.visible .entry t(.param .u64 x) { .reg .f32 %f<9>; .reg .b32 %r<2>; .reg .b64 %rd; ld.param.u64 %rd, [x];
  tex.2dms.v4.f32.s32 {%f1, %f2, %f3, %f4}, [%rd, {%r1, %r1, %r1, %r1}]; ret; }
)"));
    const KernelInfo& kernel = code->kernels()[0];
    EXPECT_EQ(kernel.parameterOffsets, (std::vector<uint32_t>{0, 8, 24}));
    EXPECT_EQ(kernel.parameterSizes, (std::vector<uint32_t>{1, 12, 8}));
    EXPECT_EQ(kernel.parameterBytes, 32u);
    EXPECT_EQ(kernel.maxThreadsPerBlock, 128u);
    EXPECT_TRUE(kernel.address);
    EXPECT_FALSE(code->kernels()[1].address);
    EXPECT_NE(code->kernels()[1].unsupported.find("tex.2dms"), std::string::npos);
    EXPECT_NE(code->kernels()[1].unsupported.find("line 7"), std::string::npos);
}

// Sums of 32 bits would be those of small kernels.
TEST(Kernels, SizesThatNoDeviceHas) {
    const auto code = compileKernels(parse(std::string(kHeader) + R"(
.visible .entry local() { .local .align 4 .b8 a[4294967296]; .local .align 4 .b8 b[64];
  .reg .b32 %r; .reg .b64 %rd; mov.u32 %r, %tid.x; cvt.u64.u32 %rd, %r; mov.u64 %rd, a;
  st.local.u32 [%rd], %r; ret; }
.visible .entry shared() { .shared .align 4 .b8 a[4294967232]; .shared .align 4 .b8 b[4096];
  .reg .b64 %rd; mov.u64 %rd, a; st.shared.u32 [%rd], 1; mov.u64 %rd, b; st.shared.u32 [%rd], 1;
  ret; }
.visible .entry parameters(.param .align 4 .b8 a[4294967296], .param .u32 b) { ret; }
.visible .entry threads() .maxntid 65536, 65536, 1 { ret; }
)"));
    const char* const words[] = {"local memory", "shared memory", "parameters"};
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_FALSE(code->kernels()[i].address);
        EXPECT_NE(code->kernels()[i].unsupported.find(words[i]), std::string::npos)
            << code->kernels()[i].unsupported;
    }
    EXPECT_TRUE(code->kernels()[3].address);
    EXPECT_GE(code->kernels()[3].maxThreadsPerBlock, 1024u);
}

} // namespace
} // namespace sunstone::compiler::testing
