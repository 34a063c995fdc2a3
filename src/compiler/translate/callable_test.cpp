// SPDX-License-Identifier: Apache-2.0
// Callables against a launch that has five of them: every call must find its own data, for any
// order of look-ups and calls.
#include "compiler/testing.h"
#include "compiler/optix7/program_kind.h"

namespace sunstone::compiler::testing {
namespace {

using devlib::LaunchState;
using devlib::RayState;

// Callable `i` of the launch has data[i]; all but the last share the code in `code`.
struct Fake {
    const void* code[5] = {};
    uint32_t data[5] = {100, 200, 300, 400, 500};
    std::vector<uint64_t> asked; // index, continuation in the upper half
};
Fake fake;

const char* const kCallees = R"(
.visible .func (.param .b32 r) __direct_callable__data(.param .b32 a) {
  .reg .b32 %r<9>; .reg .b64 %rd<9>;
  ld.param.b32 %r1, [a];
  call (%rd1), _optix_get_sbt_data_ptr_64, (); ld.u32 %r2, [%rd1];
  add.u32 %r3, %r1, %r2; st.param.b32 [r], %r3; ret;
}
.visible .func (.param .b32 r) __direct_callable__nested(.param .b32 a) {
  .reg .b32 %r<9>; .reg .b64 %rd<9>;
  ld.param.b32 %r1, [a];
  mov.u32 %r2, 1;
  call (%rd1), _optix_call_direct_callable, (%r2);
  { .param .b32 x; .param .b32 y; st.param.b32 [x], %r1;
    p0 : .callprototype (.param .b32 _) _ (.param .b32 _);
    call (y), %rd1, (x), p0; ld.param.b32 %r3, [y]; }
  call (%rd2), _optix_get_sbt_data_ptr_64, (); ld.u32 %r4, [%rd2];
  mad.lo.u32 %r5, %r4, 1000, %r3; st.param.b32 [r], %r5; ret;
}
.visible .func (.param .b32 r) plain(.param .b32 a) {
  .reg .b32 %r<3>; ld.param.b32 %r1, [a]; add.u32 %r1, %r1, 7; st.param.b32 [r], %r1; ret;
}
)";

std::string callOf(const char* target, const char* argument, const char* result) {
    static int count = 0;
    const std::string name = "proto" + std::to_string(++count);
    return std::string("{ .param .b32 x; .param .b32 y; st.param.b32 [x], ") + argument + ";\n" +
           name + " : .callprototype (.param .b32 _) _ (.param .b32 _);\ncall (y), " + target +
           ", (x), " + name + "; ld.param.b32 " + result + ", [y]; }\n";
}

class Callables : public ::testing::TestWithParam<OptLevel> {
protected:
    // Runs a body that leaves its results in %r11 and %r12.
    void run(const std::string& body) {
        rules_.launchParams = "params";
        const std::string text =
            std::string(kHeader) + ".const .align 8 .b8 params[16];\n" + kCallees +
            ".visible .entry __raygen__rg() {\n.reg .b32 %r<20>; .reg .b64 %rd<20>; .reg .pred "
            "%p<3>;\n" +
            "mov.u32 %r1, 1; mov.u32 %r2, 2; mov.u32 %r3, 3;\nld.const.u32 %r4, [params+8];\n" +
            body +
            "ld.const.u64 %rd19, [params]; st.u32 [%rd19], %r11; st.u32 [%rd19+4], %r12; ret;\n}\n";
        PipelineRequest request;
        request.rules = rules_;
        const auto module = source(text);
        for (const char* name :
             {"__raygen__rg", "__direct_callable__data", "__direct_callable__nested"})
            request.programs.push_back({module, name, programKind(name), GetParam()});
        code_ = compilePipeline(request);
        fake = Fake{};
        for (const void*& code : fake.code)
            code = code_->programs()[1].address;
        fake.code[4] = code_->programs()[2].address;
        LaunchState launch{};
        launch.callable = [](RayState* ray, uint32_t index, uint32_t continuation) -> const void* {
            fake.asked.push_back(uint64_t(continuation & 1) << 32 | index);
            if (index >= 5)
                return nullptr;
            ray->callableData = &fake.data[index];
            return fake.code[index];
        };
        uint32_t* pointer = out_;
        std::memcpy(params_, &pointer, 8);
        launch.params = params_;
        RayState ray{};
        devlib::ThreadState thread{};
        ray.launch = &launch;
        ray.thread = &thread;
        reinterpret_cast<devlib::ProgramFn>(const_cast<void*>(code_->programs()[0].address))(&ray);
    }

    PipelineRules rules_;
    std::unique_ptr<Code> code_;
    uint32_t out_[2] = {};
    alignas(16) uint8_t params_[16] = {};
};

TEST_P(Callables, TwoLookupsThenTwoCalls) {
    run("call (%rd1), _optix_call_direct_callable, (%r1);\n"
        "call (%rd2), _optix_call_direct_callable, (%r2);\n" +
        callOf("%rd1", "%r1", "%r11") + callOf("%rd2", "%r2", "%r12"));
    EXPECT_EQ(out_[0], 201u);
    EXPECT_EQ(out_[1], 302u);
    EXPECT_EQ(fake.asked, (std::vector<uint64_t>{1, 2})); // once for each call
}

// Compilers that declare the functions of the API pass operands in .param variables.
TEST_P(Callables, IntrinsicWithOperandsInVariables) {
    run("{ .param .b32 x; .param .b64 y; st.param.b32 [x], %r2;\n"
        "call.uni (y), _optix_call_direct_callable, (x); ld.param.b64 %rd1, [y]; }\n" +
        callOf("%rd1", "%r1", "%r11") + "mov.u32 %r12, 0;");
    EXPECT_EQ(out_[0], 301u);
    EXPECT_EQ(fake.asked, (std::vector<uint64_t>{2}));
}

TEST_P(Callables, OneLookupServesCallsAroundAnother) {
    run("call (%rd1), _optix_call_direct_callable, (%r1);\n" + callOf("%rd1", "%r1", "%r11") +
        "call (%rd2), _optix_call_direct_callable, (%r3);\n" + callOf("%rd2", "%r1", "%r12") +
        callOf("%rd1", "%r12", "%r12"));
    EXPECT_EQ(out_[0], 201u);
    EXPECT_EQ(out_[1], 601u);
}

TEST_P(Callables, TargetChosenAtRunTimeAndKeptInMemory) {
    params_[8] = 3;
    run(".local .align 8 .b8 depot[16]; \n"
        "call (%rd1), _optix_call_direct_callable, (%r4);\n st.local.u64 [depot], %rd1;\n"
        "mov.u64 %rd2, plain; st.local.u64 [depot+8], %rd2;\n"
        "setp.eq.u32 %p1, %r4, 3; ld.local.u64 %rd3, [depot]; ld.local.u64 %rd4, [depot+8];\n"
        "selp.b64 %rd5, %rd3, %rd4, %p1; selp.b64 %rd6, %rd4, %rd3, %p1;\n" +
        callOf("%rd5", "%r1", "%r11") + callOf("%rd6", "%r1", "%r12"));
    EXPECT_EQ(out_[0], 401u);
    EXPECT_EQ(out_[1], 8u); // an ordinary function through its address
    EXPECT_EQ(fake.asked, (std::vector<uint64_t>{3}));
}

TEST_P(Callables, AddressOfAFunctionIsCalledAsItIs) {
    run("mov.u64 %rd1, plain;\n" + callOf("%rd1", "%r1", "%r11") + "mov.u32 %r12, 3;\n");
    EXPECT_EQ(out_[0], 8u);
    EXPECT_TRUE(fake.asked.empty());
}

TEST_P(Callables, CallableThatCallsAnotherKeepsItsData) {
    run("mov.u32 %r4, 4; call (%rd1), _optix_call_direct_callable, (%r4);\n" +
        callOf("%rd1", "%r1", "%r11") + callOf("%rd1", "%r11", "%r12"));
    EXPECT_EQ(out_[0], 500u * 1000 + 200 + 1);
    EXPECT_EQ(out_[1], 500u * 1000 + 200 + out_[0]);
}

TEST_P(Callables, GuardedCallRunsOnlyWhereItShould) {
    run("mov.u32 %r11, 5; mov.u32 %r12, 6; setp.eq.u32 %p1, %r4, 77;\n"
        "call (%rd1), _optix_call_direct_callable, (%r1);\n"
        "{ .param .b32 x; .param .b32 y; st.param.b32 [x], %r1; st.param.b32 [y], 9;\n"
        "g0 : .callprototype (.param .b32 _) _ (.param .b32 _);\n"
        "@%p1 call (y), %rd1, (x), g0; ld.param.b32 %r11, [y];\n"
        "@!%p1 call (y), %rd1, (x), g0; ld.param.b32 %r12, [y]; }\n");
    EXPECT_EQ(out_[0], 9u);
    EXPECT_EQ(out_[1], 201u);
}

TEST_P(Callables, MissingCallableGivesZero) {
    run("mov.u32 %r5, -1; call (%rd1), _optix_call_direct_callable, (%r5);\n" +
        callOf("%rd1", "%r1", "%r11") + "mov.u32 %r12, 3;\n");
    EXPECT_EQ(out_[0], 0u);
    EXPECT_EQ(out_[1], 3u);
    EXPECT_EQ(fake.asked, (std::vector<uint64_t>{0xffffffffu}));
}

INSTANTIATE_TEST_SUITE_P(Levels, Callables, ::testing::Values(OptLevel::k0, OptLevel::k3),
                         [](const auto& info) { return info.param == OptLevel::k0 ? "O0" : "O3"; });

} // namespace
} // namespace sunstone::compiler::testing
