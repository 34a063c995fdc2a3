// SPDX-License-Identifier: Apache-2.0
// Opcodes that PTX lacks. The parser, the verifier, both translations, the header of GPU code and
// the lockstep code need only a row in the table of opcodes and a row for each form.
#include "compiler/gpu/header.h"
#include "devlib/lockstep.h"
#include "gpu/pipelines.h"
#include "ptx/opcodes/instruction_table.h"
#include "ptx/opcodes/opcode.h"
#include "ptx/parse/parser.h"

#include <gtest/gtest.h>

namespace sunstone {
namespace {

using namespace gpu_tests;
using ptx::Age, ptx::Lockstep, ptx::Native, ptx::Operation, ptx::Syntax;

template <class T, size_t N>
std::vector<T> joined(std::span<const T> all, const T (&more)[N]) {
    std::vector<T> list(all.begin(), all.end());
    list.insert(list.end(), more, more + N);
    return list;
}

const ptx::OpcodeTable& table() {
    static constexpr ptx::OpcodeText kRows[] = {
        {"plus", Operation::kAdd, Native::kInexact, Age::kSingles, Lockstep::kAlone,
         Syntax::kValues, ptx::kPacked},
        {"ask", Operation::kVote, Native::kWarp, Age::kNew, Lockstep::kVote},
        {"go", Operation::kBranch, Native::kNever, Age::kNew, Lockstep::kAlone, Syntax::kLabel},
        {"gone", Operation::kUnknown}};
    static constexpr ptx::FormText kForms[] = {{"plus", "", "u32", "=0 0 0"},
                                               {"plus", "u16x2", "", "=r r r"},
                                               {"plus", "rn|rz?", "f32", "=0 0 0"},
                                               {"ask", "sync ballot", "b32", "=0 p r"},
                                               {"go", "", "", "l"},
                                               {"gone", "", "u32", "=0 0"}};
    static const auto* all =
        new ptx::OpcodeTable(joined(ptx::opcodeRows(), kRows), joined(ptx::formRows(), kForms));
    return *all;
}

std::shared_ptr<const ptx::Module> parse(const std::string& text, std::string& errors,
                                         const ptx::OpcodeTable& opcodes = table()) {
    ptx::Diagnostics diagnostics;
    std::shared_ptr<const ptx::Module> tree = ptx::parse(text, diagnostics, {}, opcodes);
    errors = diagnostics.format();
    return tree;
}

std::string kernel(const std::string& body) {
    return ".version 7.8\n.target sm_75\n.address_size 64\n"
           ".visible .entry k(.param .u64 out) {\n.reg .b32 %r<9>; .reg .pred %p; "
           ".reg .b64 %rd<3>; .reg .f32 %f<3>;\nld.param.u64 %rd1, [out];\n" +
           body + "st.u32 [%rd1], %r1;\nret;\n}\n";
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(OpcodeRow, ParserAndVerifierFollow) {
    std::string errors;
    const std::string good = kernel("go next;\nnext: plus.u32 %r1, %r2, 3;\n");
    EXPECT_TRUE(parse(good, errors)) << errors;
    EXPECT_FALSE(parse(good, errors, ptx::opcodeTable()));
    EXPECT_TRUE(has(errors, "undeclared name 'next'")) << errors; // no label is expected
    EXPECT_FALSE(parse(kernel("plus.u32 %r1, %r2, 3;\n"), errors, ptx::opcodeTable()));
    EXPECT_TRUE(has(errors, "unknown instruction 'plus'")) << errors;
    EXPECT_FALSE(parse(kernel("go nowhere;\n"), errors));
    EXPECT_TRUE(has(errors, "label")) << errors;
    EXPECT_FALSE(parse(kernel("plus.u64 %rd1, %rd1, %rd2;\n"), errors));
    EXPECT_TRUE(has(errors, "unknown modifier '.u64' for 'plus'")) << errors;
    EXPECT_FALSE(parse(kernel("pluss.u32 %r1, %r1, %r2;\n"), errors));
    EXPECT_TRUE(has(errors, "plus")) << errors;
}

TEST(OpcodeRow, TheCpuFollows) {
    std::string errors;
    const auto tree = parse(kernel("go next;\nmov.u32 %r2, 9;\n"
                                   "next: mov.u32 %r3, 0x1ffff; mov.u32 %r4, 0x10001;\n"
                                   "plus.u16x2 %r1, %r3, %r4;\nplus.u32 %r1, %r1, 1;\n"),
                            errors);
    ASSERT_TRUE(tree) << errors;
    const auto code = compiler::compileKernels(tree);
    const compiler::KernelInfo& info = code->kernels().at(0);
    ASSERT_TRUE(info.address) << info.unsupported;
    EXPECT_FALSE(info.usesWarpFunctions);
    uint32_t result = 0, *out = &result;
    devlib::KernelThread thread{};
    reinterpret_cast<devlib::KernelFn>(const_cast<void*>(info.address))(&thread, &out);
    EXPECT_EQ(result, 0x20001u); // no carry into the upper half
}

TEST(OpcodeRow, LockstepFollows) {
    std::string errors;
    const auto tree = parse(kernel("setp.ne.u64 %p, %rd1, 0;\n"
                                   "ask.sync.ballot.b32 %r1, %p, -1;\n"),
                            errors);
    ASSERT_TRUE(tree) << errors;
    const auto code = compiler::compileKernels(tree);
    const compiler::KernelInfo& info = code->kernels().at(0);
    EXPECT_TRUE(info.usesWarpFunctions);
    ASSERT_TRUE(info.lockstep) << info.unsupported;
    uint32_t result = 0, *out = &result;
    alignas(64) uint8_t frame[4096] = {};
    ASSERT_LE(info.lockstepFrameBytes, sizeof frame);
    devlib::LockstepWarp warp{};
    devlib::KernelThread threads[devlib::kWarpLanes]{};
    warp.threads = threads;
    warp.frame = frame;
    const auto run = reinterpret_cast<devlib::LockstepFn>(const_cast<void*>(info.lockstep));
    warp.live = 3; // both are there: the code answers itself
    EXPECT_EQ(run(&warp, &out, 0, 3), 3u);
    EXPECT_EQ(result, 3u);
    warp.live = 7; // one is missing: the lanes wait at the point
    warp.stops = 0;
    EXPECT_EQ(run(&warp, &out, 0, 3), 3u);
    EXPECT_EQ(warp.stops, 1u);
    EXPECT_EQ(warp.point[0] >> devlib::kPointBits & 0xff, uint32_t(devlib::kMeetVote));
    EXPECT_EQ(warp.point[0] >> devlib::kModeShift, 3u); // ballot
}

std::string pipelineOf(const std::string& body) {
    std::string text = raygen(body), errors;
    text.replace(text.find("7.8"), 3, "9.0");
    text.replace(text.find("sm_70"), 5, "sm_90");
    const auto tree = parse(text, errors);
    EXPECT_TRUE(tree) << errors;
    Options options;
    options.target = {90, 90};
    const auto source = std::make_shared<const compiler::Source>(tree);
    return compileGpuPipeline(
               requestOf(source, compiler::inspect(*tree, rulesOf(options), {}), options))
        .ptx;
}

TEST(OpcodeRow, TheGpuFollows) {
    const std::string old =
        pipelineOf("plus.rz.f32 %f2, %f1, %f1;\nplus.u32 %r1, %r1, 3;\n"
                   "st.global.f32 [%rd1+8], %f2;\nst.global.u32 [%rd1], %r1;\n");
    EXPECT_TRUE(has(old, "plus.rz.f32 "));
    EXPECT_FALSE(has(old, "plus.u32"));
    EXPECT_TRUE(has(old, ".version 8.5\n")) << old.substr(0, 200); // LLVM's own
    const std::string fresh = pipelineOf("setp.ne.u32 %p1, %r1, 0;\n"
                                         "ask.sync.ballot.b32 %r2, %p1, -1;\n"
                                         "gone.u32 %r3, %r2;\nst.global.u32 [%rd1], %r3;\n");
    EXPECT_TRUE(has(fresh, "ask.sync.ballot.b32 "));
    EXPECT_TRUE(has(fresh, "gone.u32 "));
    EXPECT_TRUE(has(fresh, ".version 9.0\n")) << fresh.substr(0, 200);
}

} // namespace
} // namespace sunstone
