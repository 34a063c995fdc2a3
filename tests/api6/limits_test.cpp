// SPDX-License-Identifier: Apache-2.0
// Depths of rays and callables, and exceptions of payloads and codes of rtThrow.
#include "rays.h"

namespace sunstone::api6 {
namespace {

class Limits : public Rays {
protected:
    void SetUp() override {
        Rays::SetUp();
        ok(rtContextSetExceptionProgram(context_, 0, program("note_exception")));
    }
    RTgeometrygroup square(const char* closest) {
        return group({instance(squares(1), {material(closest)})});
    }
    void enable(RTexception exception) { ok(rtContextSetExceptionEnabled(context_, exception, 1)); }
    void clear() { fill(result_, std::vector<float>(64)); }
};

TEST_F(Limits, RaysBeyondTheDepthEndWithoutAProgramOrRaise) {
    const RTgeometrygroup top = square("hit_again");
    for (const unsigned depth : {1u, 3u, 31u}) {
        ok(rtContextSetMaxTraceDepth(context_, depth));
        EXPECT_EQ(shoot(top)[1], float(depth));
    }
    enable(RT_EXCEPTION_TRACE_DEPTH_EXCEEDED);
    clear();
    EXPECT_EQ(shoot(top)[1], float(RT_EXCEPTION_TRACE_DEPTH_EXCEEDED));
    EXPECT_EQ(results()[0], 0) << "the ray generation program is ended";
    fails(RT_ERROR_INVALID_VALUE, rtContextSetMaxTraceDepth(context_, 32), "maxDepth");
}

TEST_F(Limits, CallablesBeyondTheDepthAreAFullStack) {
    RTprogram link = program("count_down");
    int id = 0;
    ok(rtProgramGetId(link, &id));
    ok(rtVariableSet1i(variable("next"), id));
    ok(rtVariableSet1f(variable("chain"), 12));
    EXPECT_EQ(launch("call_chain")[0], 12) << "without a call there is no limit";
    ok(rtContextSetMaxCallableProgramDepth(context_, 12));
    EXPECT_EQ(launch("call_chain")[0], 12);
    EXPECT_EQ(results()[2], 1) << "a chain that has ended does not count";
    ok(rtContextSetMaxCallableProgramDepth(context_, 11));
    clear();
    EXPECT_EQ(launch("call_chain")[1], float(RT_EXCEPTION_STACK_OVERFLOW));
    EXPECT_EQ(results()[0], 0);
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_STACK_OVERFLOW, 0));
    clear();
    EXPECT_EQ(launch("call_chain")[0], 12) << "the exception is off";
    unsigned depth = 0;
    ok(rtContextGetMaxCallableProgramDepth(context_, &depth));
    EXPECT_EQ(depth, 11u);
}

TEST_F(Limits, RecursiveFunctionsReadVariables) {
    ok(rtVariableSet1f(variable("scoped"), 2));
    ok(rtContextSetEntryPointCount(context_, 2));
    RTprogram other = program("write_grown_again"); // with a variable of its own
    setFloat(other, rtProgramDeclareVariable, "scoped", 5);
    ok(rtContextSetRayGenerationProgram(context_, 1, other));
    EXPECT_EQ(launch("write_grown")[0], 2 * 89);
    ok(rtContextLaunch1D(context_, 1, 1));
    EXPECT_EQ(results()[0], 5 * 89);
    RTprogram link = program("count_down"), grower = program("grow_after_call");
    int id = 0;
    ok(rtProgramGetId(link, &id));
    ok(rtVariableSet1i(variable("next"), id));
    ok(rtProgramGetId(grower, &id));
    ok(rtVariableSet1i(variable("grower"), id));
    setFloat(grower, rtProgramDeclareVariable, "scoped", 3);
    EXPECT_EQ(launch("call_grower")[0], 1000 + 3 * 8) << "the callable's own variable";
}

TEST_F(Limits, RecursiveFunctionsTraceRays) {
    setEntry("look_often");
    EXPECT_EQ(shoot(square("hit_head"))[0], 15) << "the calls for 5, 4, 3, 3, 2, ...";
    ok(rtVariableSet1f(variable("scoped"), 3));
    ok(rtContextSetStackSize(context_, 32 << 10));
    setEntry("shoot");
    float value = 1; // of a ray three deep; each ray above looks once, and three times once more
    for (int depth = 2; depth >= 0; --depth)
        value = 1 + 4 * value;
    EXPECT_EQ(shoot(square("hit_looking"))[0], value);
}

TEST_F(Limits, AccessesBeyondAPayload) {
    setEntry("shoot_small");
    enable(RT_EXCEPTION_PAYLOAD_ACCESS_OUT_OF_BOUNDS);
    EXPECT_EQ(shoot(square("hit_head"))[0], 1) << "the first member is inside";
    clear();
    EXPECT_EQ(shoot(square("hit_mark"))[1], float(RT_EXCEPTION_PAYLOAD_ACCESS_OUT_OF_BOUNDS));
    EXPECT_EQ(results()[0], 0);
    setEntry("shoot");
    EXPECT_EQ(shoot(square("hit_mark"))[0], 1) << "a payload of full size";
}

TEST_F(Limits, CodesThatAreNoneOfAUser) {
    const auto raised = [&](unsigned code) {
        ok(rtVariableSet1ui(variable("thrown"), code));
        clear();
        return launch("throw_code")[1];
    };
    const unsigned wrong = 0x3FF, beyond = RT_EXCEPTION_USER_MAX + 1;
    EXPECT_EQ(raised(RT_EXCEPTION_USER), 0);
    EXPECT_EQ(raised(wrong), 0);
    enable(RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS);
    EXPECT_EQ(raised(RT_EXCEPTION_USER), 0);
    EXPECT_EQ(raised(wrong), float(RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS));
    enable(RT_EXCEPTION_USER);
    EXPECT_EQ(raised(RT_EXCEPTION_USER), float(RT_EXCEPTION_USER));
    EXPECT_EQ(raised(RT_EXCEPTION_USER_MAX), float(RT_EXCEPTION_USER_MAX));
    EXPECT_EQ(raised(beyond), float(RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS));
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS, 0));
    EXPECT_EQ(raised(beyond), 0) << "is ignored";
}

// ---- texts that need each other ---------------------------------------------------------------

const char* const kMain =
    ".version 5.0\n.target sm_30\n.address_size 64\n"
    ".visible .global .align 1 .b8 result[1];\n"
    ".extern .func (.param .b32 sum) add_scoped_twice (.param .b32 a);\n"
    ".visible .entry linked()\n{\n.reg .f32 %f<3>;\n.reg .b64 %rd<5>;\n.reg .b32 %r<3>;\n"
    "mov.f32 %f1, 0f40A00000;\n{\n.param .b32 p;\n.param .b32 s;\nst.param.f32 [p], %f1;\n"
    "call (s), add_scoped_twice, (p);\nld.param.f32 %f2, [s];\n}\n"
    "mov.u64 %rd1, result;\nmov.u32 %r1, 1;\nmov.u32 %r2, 4;\nmov.u64 %rd2, 0;\n"
    "call (%rd3), _rt_buffer_get_64, (%rd1, %r1, %r2, %rd2, %rd2, %rd2, %rd2);\n"
    "st.f32 [%rd3], %f2;\nret;\n}\n";
const char* const kHelper =
    ".version 5.0\n.target sm_30\n.address_size 64\n"
    ".visible .global .align 1 .b8 result[1];\n"
    ".global .align 4 .f32 scoped;\n"
    ".global .align 4 .b8 _ZN21rti_internal_typeinfo6scopedE[8] = {82, 97, 121, 0, 4, 0, 0, 0};\n"
    ".visible .func (.param .b32 sum) add_scoped_twice (.param .b32 a)\n{\n.reg .f32 %f<5>;\n"
    "ld.param.f32 %f1, [a];\nld.global.f32 %f2, [scoped];\nadd.f32 %f3, %f1, %f2;\n"
    "add.f32 %f4, %f3, %f2;\nst.param.f32 [sum], %f4;\nret;\n}\n";

TEST_F(Limits, TextsThatNeedEachOtherAreLinked) {
    ok(rtVariableSet1f(variable("scoped"), 10));
    for (const bool swapped : {false, true}) {
        const char* texts[] = {swapped ? kHelper : kMain, swapped ? kMain : kHelper};
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXStrings(context_, 2, texts, "linked", &made));
        ok(rtContextSetRayGenerationProgram(context_, 0, made));
        clear();
        ok(rtContextLaunch1D(context_, 0, 1));
        EXPECT_EQ(results()[0], 25);
    }
    RTprogram made = nullptr;
    const std::string other =
        std::string(kHelper).replace(std::string(kHelper).find("add.f32"), 3, "sub");
    const char* twice[] = {kMain, kHelper, other.c_str()};
    fails(RT_ERROR_INVALID_SOURCE,
          rtProgramCreateFromPTXStrings(context_, 3, twice, "linked", &made), "add_scoped_twice");
    const char* missing[] = {kMain, kMain};
    fails(RT_ERROR_INVALID_SOURCE,
          rtProgramCreateFromPTXStrings(context_, 2, missing, "linked", &made),
          "none of the texts");
    EXPECT_EQ(made, nullptr);
}

} // namespace
} // namespace sunstone::api6
