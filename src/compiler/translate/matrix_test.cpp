// SPDX-License-Identifier: Apache-2.0
// Malformed matrix and stack instructions are errors with the line. Results of well-formed ones:
// tests/conformance, ctest conformance.matrices.
#include "compiler/runtime/matrix.h"
#include "compiler/testing.h"

namespace sunstone::compiler::testing {
namespace {

constexpr unsigned kLine = 7; // line of the instruction
std::string moduleOf(const std::string& instruction) {
    return ".version 8.7\n.target sm_90\n.address_size 64\n.shared .align 16 .b8 sm[64];\n"
           ".visible .entry k() {\n"
           ".reg .b64 %rd<9>; .reg .b32 %r<20>; .reg .f32 %f<20>; .reg .f64 %fd<9>; "
           ".reg .pred %p<3>; .reg .b128 %q<3>;\n" +
           instruction + "\nret;\n}\n";
}

// The error of a kernel with this instruction; empty without an error.
std::string errorOf(const std::string& instruction) {
    ptx::Diagnostics diagnostics;
    const std::shared_ptr<const ptx::Module> module =
        ptx::parse(moduleOf(instruction), diagnostics);
    if (!module)
        return diagnostics.format();
    try {
        const auto code = compileKernels(module);
        return code->kernels().at(0).address ? "" : code->kernels().at(0).unsupported;
    } catch (const Error& error) {
        return error.what();
    }
}

TEST(Matrix, FaultyFormsAreErrors) {
    constexpr const char* kFaulty[] = {
        // shapes, layouts and types that do not go together
        "mma.sync.aligned.m16n8k32.row.col.f32.f16.f16.f32 {%f1,%f2,%f3,%f4}, "
        "{%r1,%r2,%r3,%r4}, {%r5,%r6}, {%f1,%f2,%f3,%f4};",
        "mma.sync.aligned.m16n8k16.col.col.f32.f16.f16.f32 {%f1,%f2,%f3,%f4}, "
        "{%r1,%r2,%r3,%r4}, {%r5,%r6}, {%f1,%f2,%f3,%f4};",
        "mma.sync.aligned.m16n8k16.row.col.f32.f16.bf16.f32 {%f1,%f2,%f3,%f4}, "
        "{%r1,%r2,%r3,%r4}, {%r5,%r6}, {%f1,%f2,%f3,%f4};",
        "mma.sync.aligned.m16n8k16.row.col.satfinite.f32.f16.f16.f32 {%f1,%f2,%f3,%f4}, "
        "{%r1,%r2,%r3,%r4}, {%r5,%r6}, {%f1,%f2,%f3,%f4};",
        "mma.sync.aligned.m8n8k128.row.col.s32.b1.b1.s32 {%r1,%r2}, {%r3}, {%r4}, {%r5,%r6};",
        "mma.sync.m8n8k16.row.col.s32.s8.s8.s32 {%r1,%r2}, {%r3}, {%r4}, {%r5,%r6};",
        "mma.sync.aligned.m99999999999n8k16.row.col.s32.s8.s8.s32 {%r1,%r2}, {%r3}, {%r4}, "
        "{%r5,%r6};",
        "mma;",
        "mma.sp.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 {%f1,%f2,%f3,%f4}, {%r1,%r2}, "
        "{%r3,%r4}, {%f1,%f2,%f3,%f4}, %r5, 0;",
        // registers: too many, too few, none
        "mma.sync.aligned.m8n8k16.row.col.s32.s8.s8.s32 {%r1,%r2}, {%r3,%r4}, {%r4}, {%r5,%r6};",
        "mma.sync.aligned.m8n8k16.row.col.s32.s8.s8.s32 {%r1}, {%r3}, {%r4}, {%r5,%r6};",
        "mma.sync.aligned.m8n8k16.row.col.s32.s8.s8.s32 {%r1,%r2}, {%r3}, {%r4};",
        "mma.sync.aligned.m8n8k16.row.col.s32.s8.s8.s32 {1,2}, {%r3}, {%r4}, {%r5,%r6};",
        "mma.sync.aligned.m8n8k16.row.col.s32.s8.s8.s32 {%r1,%r2}, [sm], {%r4}, {%r5,%r6};",
        "wmma.load.a.sync.aligned.row.m16n16k16.f16 {%r1,%r2,%r3,%r4}, [%rd1];",
        "wmma.load.d.sync.aligned.row.m16n16k16.f16 {%r1,%r2,%r3,%r4}, [%rd1];",
        "wmma.load.a.sync.aligned.col.m8n8k32.s4 {%r1}, [%rd1];",
        "wmma.load.a.sync.aligned.row.m16n16k16.f16 {%r1,%r2,%r3,%r4,%r5,%r6,%r7,%r8}, %rd1;",
        "wmma.store.d.sync.aligned.row.m16n16k16.f64 [%rd1], {%fd1,%fd2};",
        "wmma.mma.xor.popc.sync.aligned.row.col.m16n16k16.f32.f32 {%r1}, {%r1}, {%r1}, {%r1};",
        "wmma.mma.sync.aligned.row.col.m16n16k16.rz.f32.f32 {%r1}, {%r1}, {%r1}, {%r1};",
        "wmma;",
        "ldmatrix.sync.aligned.m8n8.x3.shared.b16 {%r1,%r2,%r3}, [sm];",
        "ldmatrix.sync.aligned.m8n8.x4.shared.b16 {%r1,%r2,%r3}, [sm];",
        "ldmatrix.sync.aligned.m8n8.x1.shared.b16 {%r1}, %r2;",
        "ldmatrix.sync.aligned.m16n16.x1.trans.shared.b8 {%r1,%r2}, [sm];",
        "stmatrix.sync.aligned.m8n8.x2.shared.b16 {%r1,%r2}, [sm];",
        "movmatrix.sync.aligned.m8n8.b16 %r1, %r2;",
        "movmatrix.sync.aligned.m8n8.trans.b16 %r1;",
        // GPU-only hardware
        "wgmma.fence.sync.aligned;",
        "cp.async.bulk.tensor.1d.shared::cluster.global.mbarrier::complete_tx::bytes [sm], "
        "[%rd1, {%r1}], [sm];",
        // the stack
        "alloca.u64 %rd1, %rd2, 3;",
        "alloca.u64 %rd1, %rd2, 256;",
        "alloca.u32 %r1, %r2;",
        "stackrestore.u32 %r1;",
        "atom.add.b128 %q1, [%rd1], %q2;",
        "atom.cas.b128 %rd1, [%rd1], %rd2, %rd3;",
    };
    for (const char* form : kFaulty) {
        const std::string error = errorOf(form);
        EXPECT_NE(error.find(std::to_string(kLine)), std::string::npos)
            << form << ": \"" << error << "\"";
    }
}

// Words of valid instructions dropped, doubled and exchanged: an error with its line, or a kernel.
TEST(Matrix, MangledFormsDoNotCrash) {
    const std::vector<std::vector<std::string>> kGood = {
        {"mma", ".sync", ".aligned", ".m16n8k8", ".row", ".col", ".f32", ".f16", ".f16", ".f32",
         " {%f1,%f2,%f3,%f4}", ", {%r1,%r2}", ", {%r3}", ", {%f5,%f6,%f7,%f8}"},
        {"wmma", ".mma", ".sync", ".aligned", ".row", ".col", ".m8n8k4", ".f64", ".f64", ".f64",
         ".f64", " {%fd1,%fd2}", ", {%fd3}", ", {%fd4}", ", {%fd5,%fd6}"},
        {"wmma", ".load", ".a", ".sync", ".aligned", ".row", ".m16n16k16", ".global", ".s8",
         " {%r1,%r2}", ", [%rd1]", ", %r3"},
        {"ldmatrix", ".sync", ".aligned", ".m8n8", ".x2", ".trans", ".shared", ".b16", " {%r1,%r2}",
         ", [sm+16]"},
        {"stmatrix", ".sync", ".aligned", ".m8n8", ".x1", ".shared", ".b16", " [sm]", ", {%r1}"},
        {"alloca", ".u64", " %rd1", ", %rd2", ", 16"}};
    uint32_t random = 12345;
    const auto next = [&](size_t count) {
        random = random * 1664525 + 1013904223;
        return size_t(random >> 8) % count;
    };
    for (unsigned i = 0; i < 400; ++i) {
        std::vector<std::string> words = kGood[next(kGood.size())];
        for (size_t changes = 1 + next(3); changes > 0; --changes) {
            const size_t at = next(words.size()), other = next(words.size());
            const std::vector<std::string>& donor = kGood[next(kGood.size())];
            switch (next(4)) {
            case 0:
                if (words.size() > 1)
                    words.erase(words.begin() + long(at));
                break;
            case 1:
                words.insert(words.begin() + long(at), words[other]);
                break;
            case 2:
                std::swap(words[at], words[other]);
                break;
            default:
                words[at] = donor[next(donor.size())];
            }
        }
        std::string text;
        for (const std::string& word : words)
            text += word;
        const std::string error = errorOf(text + ";");
        if (!error.empty()) {
            EXPECT_NE(error.find(std::to_string(kLine)), std::string::npos)
                << text << ": \"" << error << "\"";
        }
    }
}

// Memory allocated between stacksave and stackrestore is freed: a thousand times 64 KiB fit a
// stack.
TEST(Stack, MemoryComesBack) {
    run({{"mov.u32 %r2, 0; mov.u32 %r0, 0; AGAIN: stacksave.u64 %rd2; alloca.u64 %rd3, 65536, 64;"
          "st.local.u32 [%rd3+65532], %r2; st.local.u32 [%rd3], %r1; cvta.local.u64 %rd4, %rd3;"
          "ld.u32 %r3, [%rd4+65532]; add.u32 %r0, %r0, %r3; and.b64 %rd5, %rd3, 63;"
          "cvt.u32.u64 %r4, %rd5; add.u32 %r0, %r0, %r4; stackrestore.u64 %rd2;"
          "add.u32 %r2, %r2, 1; setp.lt.u32 %p1, %r2, 1000; @%p1 bra AGAIN;",
          {7},
          'r',
          499500},
         {"alloca.u64 %rd2, %rd1; sub.u64 %rd3, %rd1, 4; add.u64 %rd3, %rd2, %rd3;"
          "mov.u32 %r5, 11; st.u32 [%rd3], %r5; alloca.u64 %rd4, 16; st.u32 [%rd4], %r1;"
          "ld.u32 %r0, [%rd3];",
          {256},
          'r',
          11}});
}

// Each element of a matrix is in some lane: once, or equally often for A and B of halves.
TEST(Matrix, FragmentsHoldAllElements) {
    using enum MatrixType;
    const auto describe = [](unsigned m, unsigned n, unsigned k, MatrixType factor, MatrixType sum,
                             uint8_t flags) {
        MatrixOperation operation;
        operation.m = uint8_t(m);
        operation.n = uint8_t(n);
        operation.k = uint16_t(k);
        operation.a = operation.b = factor;
        operation.c = operation.d = sum;
        operation.flags = flags;
        return operation;
    };
    const MatrixOperation kAll[] = {describe(16, 8, 16, kF16, kF32, 0),
                                    describe(16, 8, 8, kTF32, kF32, 0),
                                    describe(16, 8, 16, kF64, kF64, 0),
                                    describe(16, 8, 64, kS4, kS32, 0),
                                    describe(16, 16, 16, kF16, kF16, kMatrixWide),
                                    describe(8, 32, 16, kF16, kF32, kMatrixWide),
                                    describe(32, 8, 16, kS8, kS32, kMatrixWide),
                                    describe(16, 16, 8, kTF32, kF32, kMatrixWide)};
    for (const MatrixOperation& operation : kAll)
        for (const MatrixOperand operand :
             {MatrixOperand::kA, MatrixOperand::kB, MatrixOperand::kC}) {
            const unsigned rows = operand == MatrixOperand::kB ? operation.k : operation.m;
            const unsigned columns = operand == MatrixOperand::kA ? operation.k : operation.n;
            std::vector<unsigned> counts(rows * columns);
            const unsigned perLane = elementsOf(operation, operand);
            for (unsigned lane = 0; lane < 32; ++lane)
                for (unsigned i = 0; i < perLane; ++i) {
                    const MatrixPlace place = placeOf(operation, operand, lane, i);
                    ASSERT_LT(place.row, rows);
                    ASSERT_LT(place.column, columns);
                    ++counts[place.row * columns + place.column];
                }
            for (const unsigned count : counts)
                EXPECT_EQ(count, perLane * 32 / (rows * columns));
        }
}

} // namespace
} // namespace sunstone::compiler::testing
