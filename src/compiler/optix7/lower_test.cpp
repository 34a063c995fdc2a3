// SPDX-License-Identifier: Apache-2.0
// OptiX programs against a launch with fake trace, report and callable functions.
#include "compiler/optix7/program_kind.h"
#include "compiler/testing.h"

#include <functional>

namespace sunstone::compiler::testing {
namespace {

using devlib::LaunchState;
using devlib::RayState;
using devlib::ThreadState;

// The fakes are plain functions; what they do is set by each test.
std::function<void(RayState*)> onTrace;
std::function<uint32_t(RayState*, float, uint32_t)> onReport;
std::function<const void*(RayState*, uint32_t, uint32_t)> onCallable;
std::function<void(int32_t, std::vector<uint32_t>)> onThrow;

class Optix : public ::testing::Test {
protected:
    Optix() {
        rules_.launchParams = "params";
        rules_.optix7.numPayloadValues = 4;
        rules_.optix7.numAttributeValues = 4;
        launch_.params = paramBlock_;
        launch_.dimensions[0] = 64;
        launch_.dimensions[1] = 32;
        launch_.dimensions[2] = 1;
        launch_.trace = [](RayState* ray) { onTrace(ray); };
        launch_.report = [](RayState* ray, float t, uint32_t kind) {
            return onReport(ray, t, kind);
        };
        launch_.callable = [](RayState* ray, uint32_t index, uint32_t continuation) {
            return onCallable(ray, index, continuation & 1);
        };
        launch_.throwException = [](RayState*, int32_t code, uint32_t count,
                                    const uint32_t* details) {
            onThrow(code, std::vector<uint32_t>(details, details + count));
        };
        thread_.index[0] = 5;
        thread_.index[1] = 6;
        thread_.index[2] = 0;
        ray_.launch = &launch_;
        ray_.thread = &thread_;
    }

    void compile(const std::string& text, std::vector<std::string> names) {
        compileModules({text}, std::move(names));
    }
    void compileModules(const std::vector<std::string>& texts, std::vector<std::string> names) {
        PipelineRequest request;
        request.rules = rules_;
        std::vector<std::shared_ptr<const Source>> modules;
        for (const std::string& text : texts)
            modules.push_back(source(kHeader + text));
        for (const std::string& name : names)
            for (const auto& module : modules)
                if (const ptx::Function* function = module->tree().findFunction(name))
                    if (function->hasBody) {
                        request.programs.push_back({module, name, programKind(name), level_});
                        break;
                    }
        ASSERT_EQ(request.programs.size(), names.size());
        code_ = compilePipeline(request);
    }
    sunstone::Code errorOf(const std::string& text, const std::string& name,
                           std::string* message = nullptr) {
        try {
            PipelineRequest request;
            request.rules = rules_;
            request.programs.push_back({source(kHeader + text), name, programKind(name)});
            compilePipeline(request);
        } catch (const Error& error) {
            if (message)
                *message = error.what();
            return error.code();
        }
        return sunstone::Code::kOk;
    }
    uint32_t runProgram(size_t index = 0) {
        return reinterpret_cast<devlib::ProgramFn>(
            const_cast<void*>(code_->programs()[index].address))(&ray_);
    }

    PipelineRules rules_;
    OptLevel level_ = OptLevel::k3;
    LaunchState launch_{};
    ThreadState thread_{};
    RayState ray_{};
    alignas(16) uint8_t paramBlock_[64] = {};
    std::unique_ptr<Code> code_;
};

// A trace as nvcc writes it: 49 operands, unused payload registers never written.
std::string traceCall(const std::string& count, const std::string& first) {
    std::string text = "call(%t0";
    for (int i = 1; i < 32; ++i)
        text += ",%t" + std::to_string(i);
    text +=
        "),_optix_trace_typed_32,(%type,%handle,%f1,%f2,%f3,%f4,%f5,%f6,%f7,%f8,%f9,%mask,%flags,"
        "%offset,%stride,%miss," +
        count + "," + first;
    for (int i = 1; i < 32; ++i)
        text += ",%u" + std::to_string(i);
    return text + ");\n";
}

TEST_F(Optix, RaygenTracesAndStores) {
    rules_.motionBlur = true; // else times are 0
    compile(R"(
.extern .const .align 8 .b8 params[16];
.visible .entry __raygen__rg() {
  .reg .b32 %r<9>; .reg .b32 %t<32>; .reg .b32 %u<32>; .reg .f32 %f<10>; .reg .b64 %rd<9>, %handle;
  .reg .b32 %type, %mask, %flags, %offset, %stride, %miss, %count;
  call (%r1), _optix_get_launch_index_x, ();
  call (%r2), _optix_get_launch_dimension_y, ();
  mov.f32 %f1, 0f3F800000; mov.f32 %f2, 0f40000000; mov.f32 %f3, 0f40400000;
  mov.f32 %f4, 0f00000000; mov.f32 %f5, 0f00000000; mov.f32 %f6, 0fBF800000;
  mov.f32 %f7, 0f3A83126F; mov.f32 %f8, 0f5A0E1BCA; mov.f32 %f9, 0f3F000000;
  mov.u32 %type, 0; mov.u32 %mask, 511; mov.u32 %flags, 4; mov.u32 %offset, 1; mov.u32 %stride, 2;
  mov.u32 %miss, 3; mov.u32 %count, 2; mov.u32 %r3, 77;
  ld.const.u64 %handle, [params];
)" + traceCall("%count", "%r3") +
                R"(
  ld.const.u64 %rd1, [params+8]; cvta.to.global.u64 %rd2, %rd1;
  st.global.u32 [%rd2], %t0; st.global.u32 [%rd2+4], %t1; st.global.u32 [%rd2+8], %r1;
  st.global.u32 [%rd2+12], %r2; st.global.u32 [%rd2+16], %t5;
  mov.u32 %r4, %tid.y; st.global.u32 [%rd2+20], %r4; mov.u32 %r4, %nctaid.x; st.global.u32 [%rd2+24], %r4;
  ret;
}
)",
            {"__raygen__rg"});
    uint32_t out[8] = {};
    const uint64_t handle = 0x1234561;
    uint32_t* pointer = out;
    std::memcpy(paramBlock_, &handle, 8);
    std::memcpy(paramBlock_ + 8, &pointer, 8);
    RayState seen{};
    onTrace = [&](RayState* ray) {
        seen = *ray;
        EXPECT_EQ(reinterpret_cast<uintptr_t>(ray) % 64, 0u);
        ray->payload[0] = 100;
        ray->payload[1] = 200;
        ray->payload[5] = 300;
    };
    ray_.depth = 1;
    EXPECT_EQ(runProgram(), devlib::kAccept);
    EXPECT_EQ(seen.worldOrigin[2], 3.0f);
    EXPECT_EQ(seen.worldDirection[2], -1.0f);
    EXPECT_EQ(seen.tmin, 0.001f);
    EXPECT_EQ(seen.tmax, 1e16f);
    EXPECT_EQ(seen.time, 0.5f);
    EXPECT_EQ(seen.visibilityMask, 255u);
    EXPECT_EQ(seen.rayFlags, 4u);
    EXPECT_EQ(seen.sbtOffset, 1u);
    EXPECT_EQ(seen.sbtStride, 2u);
    EXPECT_EQ(seen.missIndex, 3u);
    EXPECT_EQ(seen.handle, handle);
    EXPECT_EQ(seen.launch, &launch_);
    EXPECT_EQ(seen.thread, &thread_);
    EXPECT_EQ(seen.depth, 2u);
    EXPECT_EQ(seen.payloadCount, 2u);
    EXPECT_EQ(seen.payload[0], 77u);
    EXPECT_EQ(out[0], 100u);
    EXPECT_EQ(out[1], 200u);
    EXPECT_EQ(out[2], 5u);
    EXPECT_EQ(out[3], 32u);
    EXPECT_EQ(out[4], 0u); // past the count
    EXPECT_EQ(out[5], 6u);
    EXPECT_EQ(out[6], 1u);
    EXPECT_GT(code_->programs()[0].stackSize, sizeof(RayState));
    EXPECT_LT(code_->programs()[0].stackSize, 2048u);
}

TEST_F(Optix, HitProgramsReadTheState) {
    compile(R"(
.visible .entry __closesthit__ch() {
  .reg .b32 %r<20>; .reg .f32 %f<9>; .reg .b64 %rd<9>; .reg .pred %p<4>;
  call (%rd1), _optix_get_sbt_data_ptr_64, ();
  call (%f1, %f2), _optix_get_triangle_barycentrics, ();
  call (%r1), _optix_read_primitive_idx, ();
  call (%r2), _optix_get_hit_kind, ();
  call (%r3), _optix_get_primitive_type_from_hit_kind, (%r2);
  call (%r4), _optix_get_backface_from_hit_kind, (%r2);
  call (%f3), _optix_get_ray_tmax, ();
  call (%r5), _optix_get_transform_list_size, ();
  mov.u32 %r6, 0;
  call (%rd2), _optix_get_transform_list_handle, (%r6);
  call (%r7), _optix_get_transform_type_from_handle, (%rd2);
  call (%rd3), _optix_get_instance_inverse_transform_from_handle, (%rd2);
  call (%r8), _optix_get_instance_id_from_handle, (%rd2);
  call (%rd4), _optix_get_static_transform_from_handle, (%rd2);
  ld.u64 %rd5, [%rd1];
  st.f32 [%rd5], %f1; st.f32 [%rd5+4], %f2; st.u32 [%rd5+8], %r1; st.u32 [%rd5+12], %r3;
  st.u32 [%rd5+16], %r4; st.f32 [%rd5+20], %f3; st.u32 [%rd5+24], %r5; st.u32 [%rd5+28], %r7;
  ld.f32 %f4, [%rd3]; st.f32 [%rd5+32], %f4; st.u32 [%rd5+36], %r8; st.u64 [%rd5+40], %rd4;
  call (%r9), _optix_get_payload, (1);
  add.u32 %r9, %r9, 1;
  call _optix_set_payload, (2, %r9);
  ret;
}
)",
            {"__closesthit__ch"});
    alignas(8) uint32_t out[16] = {};
    uint32_t* pointer = out;
    devlib::InstanceRecord record{};
    record.worldToObject[0] = 4.5f;
    record.instanceId = 321;
    ray_.sbtData = &pointer;
    ray_.hit.attributes[0] = uint32_t(bits(0.25f));
    ray_.hit.attributes[1] = uint32_t(bits(0.5f));
    ray_.hit.primitive = 17;
    ray_.hit.kind = 0xFF;
    ray_.tmax = 9.0f;
    ray_.hit.transformCount = 1;
    ray_.hit.transforms[0] = devlib::makeHandle(&record, devlib::kTagInstance);
    ray_.payload[1] = 41;
    EXPECT_EQ(runProgram(), devlib::kAccept);
    EXPECT_EQ(out[0], bits(0.25f));
    EXPECT_EQ(out[1], bits(0.5f));
    EXPECT_EQ(out[2], 17u);
    EXPECT_EQ(out[3], 0x2531u);
    EXPECT_EQ(out[4], 1u);
    EXPECT_EQ(out[5], bits(9.0f));
    EXPECT_EQ(out[6], 1u);
    EXPECT_EQ(out[7], 4u);
    EXPECT_EQ(out[8], bits(4.5f));
    EXPECT_EQ(out[9], 321u);
    EXPECT_EQ(out[10], 0u); // not a static transform
    EXPECT_EQ(ray_.payload[2], 42u);
}

TEST_F(Optix, AnyHitEndsFromAHelperAtEveryLevel) {
    for (OptLevel level : {OptLevel::k0, OptLevel::k1, OptLevel::k2, OptLevel::k3}) {
        level_ = level;
        compile(R"(
.func helper(.param .b32 x) {
  .reg .b32 %r; .reg .pred %p<3>;
  ld.param.u32 %r, [x];
  setp.eq.u32 %p1, %r, 1; @%p1 bra A;
  setp.eq.u32 %p2, %r, 2; @%p2 bra B;
  ret;
A: call _optix_ignore_intersection, (); ret;
B: call _optix_terminate_ray, (); ret;
}
.visible .entry __anyhit__ah() {
  .reg .b32 %r<4>;
  call (%r1), _optix_get_attribute_2, ();
  { .param .b32 a; st.param.b32 [a], %r1; call.uni helper, (a); }
  call _optix_set_payload, (0, 55);
  ret;
}
)",
                {"__anyhit__ah"});
        for (uint32_t value : {0u, 1u, 2u}) {
            ray_.hit.attributes[2] = value;
            ray_.payload[0] = 0;
            EXPECT_EQ(runProgram(), value);
            EXPECT_EQ(ray_.payload[0], value == 0 ? 55u : 0u);
        }
    }
}

TEST_F(Optix, IntersectionReports) {
    compile(R"(
.visible .entry __intersection__is() {
  .reg .b32 %r<9>; .reg .f32 %f<4>;
  call (%f1), _optix_get_object_ray_origin_y, ();
  mov.u32 %r1, 3; mov.u32 %r2, 11; mov.u32 %r3, 12;
  call (%r4), _optix_report_intersection_2, (%f1, %r1, %r2, %r3);
  call _optix_set_payload, (0, %r4);
  call (%f2), _optix_get_ray_tmax, ();
  call (%r5), _optix_report_intersection_0, (%f2, %r1);
  call _optix_set_payload, (1, %r5);
  ret;
}
)",
            {"__intersection__is"});
    ray_.objectOrigin[1] = 2.5f;
    ray_.tmax = 100.0f;
    std::vector<float> seen;
    onReport = [&](RayState* ray, float t, uint32_t kind) -> uint32_t {
        seen.push_back(t);
        EXPECT_EQ(kind, 3u);
        EXPECT_EQ(ray->reportAttributes[1], 12u);
        ray->tmax = t;
        return seen.size() == 1 ? devlib::kAccept : devlib::kIgnore;
    };
    EXPECT_EQ(runProgram(), devlib::kAccept);
    EXPECT_EQ(seen, (std::vector<float>{2.5f, 2.5f})); // tmax read anew after the report
    EXPECT_EQ(ray_.payload[0], 1u);
    EXPECT_EQ(ray_.payload[1], 0u);
    onReport = [&](RayState*, float, uint32_t) -> uint32_t { return devlib::kTerminate; };
    ray_.payload[0] = 9;
    EXPECT_EQ(runProgram(), devlib::kTerminate);
    EXPECT_EQ(ray_.payload[0], 9u);
}

TEST_F(Optix, DirectCallables) {
    compileModules({R"(
.const .align 8 .b8 params[8];
.visible .entry __raygen__rg() {
  .reg .b32 %r<9>; .reg .b64 %rd<9>;
  mov.u32 %r1, 4;
  call (%rd1), _optix_call_direct_callable, (%r1);
  { .param .b32 a; .param .align 4 .b8 b[8]; .param .align 4 .b8 r[8];
    st.param.b32 [a], 5; st.param.b32 [b], 6; st.param.b32 [b+4], 7;
    prototype_0 : .callprototype (.param .align 4 .b8 _[8]) _ (.param .b32 _, .param .align 4 .b8 _[8]);
    call (r), %rd1, (a, b), prototype_0;
    ld.param.b32 %r2, [r]; ld.param.b32 %r3, [r+4]; }
  ld.const.u64 %rd2, [params]; st.u32 [%rd2], %r2; st.u32 [%rd2+4], %r3;
  ret;
}
)",
                    R"(
.extern .func (.param .b32 r) square(.param .b32 x);
.visible .func (.param .align 4 .b8 r[8]) __direct_callable__dc(.param .b32 a, .param .align 4 .b8 b[8]) {
  .reg .b32 %r<9>; .reg .b64 %rd<9>;
  ld.param.b32 %r1, [a]; ld.param.b32 %r2, [b]; ld.param.b32 %r3, [b+4];
  call (%rd1), _optix_get_sbt_data_ptr_64, (); ld.u32 %r4, [%rd1];
  { .param .b32 x; .param .b32 y; st.param.b32 [x], %r1; call.uni (y), square, (x); ld.param.b32 %r5, [y]; }
  mad.lo.u32 %r5, %r2, %r3, %r5; st.param.b32 [r], %r5; st.param.b32 [r+4], %r4; ret;
}
)",
                    R"(
.visible .func (.param .b32 r) square(.param .b32 x) { .reg .b32 %r; ld.param.b32 %r, [x]; mul.lo.u32 %r, %r, %r; st.param.b32 [r], %r; ret; }
.visible .entry __miss__ms() { ret; }
)"},
                   {"__raygen__rg", "__direct_callable__dc", "__miss__ms"});
    uint32_t out[2] = {};
    uint32_t* pointer = out;
    std::memcpy(paramBlock_, &pointer, 8);
    uint32_t data = 99;
    onCallable = [&](RayState* ray, uint32_t index, uint32_t continuation) {
        EXPECT_EQ(index, 4u);
        EXPECT_EQ(continuation, 0u);
        ray->callableData = &data;
        return code_->programs()[1].address;
    };
    runProgram();
    EXPECT_EQ(out[0], 25u + 42u);
    EXPECT_EQ(out[1], 99u);
    onCallable = [](RayState*, uint32_t, uint32_t) -> const void* { return nullptr; };
    runProgram(); // a record without a callable does no harm
}

TEST_F(Optix, TrapReachesTheLaunch) {
    compile(".visible .entry __miss__ms() { trap; call _optix_set_payload, (0, 1); ret; }",
            {"__miss__ms"});
    int32_t seen = 0;
    onThrow = [&](int32_t code, std::vector<uint32_t>) { seen = code; };
    runProgram();
    EXPECT_EQ(seen, devlib::kExceptionTrap);
    EXPECT_EQ(ray_.payload[0], 0u);
}

TEST_F(Optix, Exceptions) {
    rules_.exceptionFlags = 4;
    compile(R"(
.visible .entry __miss__ms() {
  .reg .b32 %r<4>;
  mov.u32 %r1, 7;
  call _optix_throw_exception_2, (%r1, 8, 9);
  call _optix_set_payload, (0, 1);
  ret;
}
.visible .entry __exception__ex() {
  .reg .b32 %r<4>;
  call (%r1), _optix_get_exception_code, (); call (%r2), _optix_get_exception_detail_1, ();
  add.u32 %r1, %r1, %r2; .reg .b64 %rd1; call (%rd1), _optix_get_sbt_data_ptr_64, (); st.u32 [%rd1], %r1;
  ret;
}
)",
            {"__miss__ms", "__exception__ex"});
    int calls = 0;
    onThrow = [&](int32_t code, std::vector<uint32_t> details) {
        ++calls;
        EXPECT_EQ(code, 7);
        EXPECT_EQ(details, (std::vector<uint32_t>{8, 9}));
    };
    runProgram(0);
    EXPECT_EQ(calls, 1);
    EXPECT_EQ(ray_.payload[0], 0u);
    thread_.exceptionCode = 30;
    thread_.exceptionDetails[1] = 4;
    uint32_t sum = 0;
    ray_.sbtData = &sum;
    runProgram(1);
    EXPECT_EQ(sum, 34u);
}

// The slot reaches the call through local memory, as in code compiled without optimisation.
TEST_F(Optix, ConstantsThroughMemory) {
    compile(R"(
.visible .entry __miss__ms() {
  .local .align 8 .b8 depot[8]; .reg .b64 %SP, %SPL; .reg .b32 %r<4>; .reg .b64 %rd1;
  mov.u64 %SPL, depot; cvta.local.u64 %SP, %SPL; add.u64 %rd1, %SP, 4;
  mov.u32 %r1, 3; st.u32 [%rd1], %r1; ld.u32 %r2, [%SP+4];
  call _optix_set_payload, (%r2, 5);
  ret;
}
)",
            {"__miss__ms"});
    runProgram();
    EXPECT_EQ(ray_.payload[3], 5u);
}

// The same of the types that a program supports, which module creation asks for. Another store
// between hides the number.
TEST_F(Optix, PayloadTypesThroughMemory) {
    const auto typesOf = [](const std::string& between) {
        PipelineRules rules;
        ModuleRules own;
        own.payloadTypes.resize(3);
        const auto module = parse(std::string(kHeader) + R"(
.visible .entry __miss__ms() {
  .local .align 8 .b8 depot[16]; .reg .b64 %SP, %SPL; .reg .b32 %r<4>; .reg .b64 %rd<3>; .reg .pred %p;
  mov.u64 %SPL, depot; cvta.local.u64 %SP, %SPL; add.u64 %rd1, %SP, 8; setp.eq.u32 %p, 1, 2;
  mov.b32 %r1, 5; st.u32 [%SP+8], %r1; st.u32 [%SP+12], 1;
)" + between + R"(
  ld.u32 %r2, [%SP+8];
  call _optix_set_payload_types, (%r2);
  ret;
}
)");
        return inspect(*module, rules, own).programs.at(0).payloadTypes;
    };
    EXPECT_EQ(5u, typesOf(""));
    EXPECT_EQ(5u, typesOf("mov.u32 %r3, 9; st.u32 [%SP+4], %r3; debug:"));
    for (const char* between :
         {"st.u32 [%rd1], 2;", "st.u16 [%SP+10], 0;", "st.u64 [%SP+4], 0;", "again: @%p bra again;",
          "atom.add.u32 %r3, [%SP+8], 1;", "st.v2.u32 [%SP+4], {%r1, %r1};"})
        EXPECT_THROW(typesOf(between), Error) << between;
}

// Of the launch parameters, another constant, a local variable and an address from outside.
TEST_F(Optix, SpacesOfAddresses) {
    compile(R"(
.extern .const .align 8 .b8 params[16];
.const .align 4 .b8 table[8] = {1, 2, 3, 4, 5, 6, 7, 8};
.visible .entry __miss__ms() {
  .local .align 8 .b8 depot[8]; .reg .b32 %r<4>; .reg .b64 %rd<9>; .reg .pred %p;
  mov.u64 %rd1, params; cvta.const.u64 %rd2, %rd1; add.u64 %rd2, %rd2, 15;
  mov.u64 %rd1, table; cvta.const.u64 %rd3, %rd1; add.u64 %rd3, %rd3, 7;
  mov.u64 %rd1, depot; cvta.local.u64 %rd4, %rd1; st.u32 [%rd4], 5;
  ld.const.u64 %rd5, [params];
  mov.u32 %r1, 0;
)" +
                [] {
                    std::string text;
                    for (const std::string address : {"%rd2", "%rd3", "%rd4", "%rd5"})
                        for (const std::string space : {"const", "local", "global", "shared"})
                            text += "isspacep." + space + " %p, " + address +
                                    "; selp.u32 %r2, 1, 0, %p; shl.b32 %r1, %r1, 1; or.b32 %r1, "
                                    "%r1, %r2;\n";
                    return text;
                }() +
                R"(
  st.u32 [%rd5], %r1; ld.u32 %r2, [%rd4]; st.u32 [%rd5+4], %r2;
  ret;
}
)",
            {"__miss__ms"});
    const auto out = std::make_unique<std::array<uint32_t, 2>>();
    uint32_t* pointer = out->data();
    std::memcpy(paramBlock_, &pointer, 8);
    runProgram();
    EXPECT_EQ((*out)[0], 0b1000'1000'0100'0010u);
}

TEST_F(Optix, Errors) {
    using E = sunstone::Code;
    std::string text;
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() {\n call _optix_foo, (); ret; }", "__miss__ms",
                      &text),
              E::kInvalidPtx);
    EXPECT_EQ(text.find("line 5"), 0u) << text;
    EXPECT_NE(text.find("_optix_foo"), std::string::npos);
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { call _optix_set_payload, (4, 0); ret; }",
                      "__miss__ms"),
              E::kInvalidPayloadAccess);
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { .reg .b32 %r1; call (%r1), "
                      "_optix_get_launch_index_x, (); "
                      "call _optix_set_payload, (%r1, 0); ret; }",
                      "__miss__ms"),
              E::kInvalidFunctionArguments);
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { call _optix_terminate_ray, (); ret; }",
                      "__miss__ms"),
              E::kInvalidFunctionUse);
    EXPECT_EQ(errorOf(".visible .entry __closesthit__c() { .reg .b32 %r1; call (%r1), "
                      "_optix_get_attribute_5, (); "
                      "call _optix_set_payload, (0, %r1); ret; }",
                      "__closesthit__c"),
              E::kInvalidAttributeAccess);
    EXPECT_EQ(errorOf(".func f() { call _optix_terminate_ray, (); call f, (); ret; } "
                      ".visible .entry __anyhit__a() { call f, (); ret; }",
                      "__anyhit__a"),
              E::kInvalidPtx);
    EXPECT_EQ(errorOf(".extern .func f(); .visible .entry __anyhit__a() { call f, (); ret; }",
                      "__anyhit__a"),
              E::kLinkError);
    EXPECT_EQ(errorOf(".extern .global .u32 g; .visible .entry __miss__m() { .reg .b32 %r; "
                      "ld.global.u32 %r, [g]; "
                      "st.global.u32 [g], %r; ret; }",
                      "__miss__m"),
              E::kLinkError);
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { bar.sync 0; ret; }", "__miss__ms"),
              E::kInvalidPtx);
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { .reg .f32 %f<8>; "
                      "call (%f0,%f1,%f2,%f3), _optix_get_sphere_data, (); ret; }",
                      "__miss__ms"),
              E::kInvalidPtx); // its operands are missing
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { call _optix_set_payload_types, (1); ret; }",
                      "__miss__ms"),
              E::kPayloadTypeId);
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { call _optix_set_payload, (0); ret; }",
                      "__miss__ms"),
              E::kInvalidPtx);
    EXPECT_EQ(errorOf(".visible .entry __miss__ms() { ret; }", "__miss__other"), E::kNotFound);
    EXPECT_THROW(
        compileModules({".visible .func f() { ret; } .visible .entry __miss__a() { ret; }",
                        ".visible .func f() { ret; } .visible .entry __miss__b() { ret; }"},
                       {"__miss__a", "__miss__b"}),
        Error);
}

TEST_F(Optix, Inspect) {
    const auto module = parse(std::string(kHeader) + R"(
.const .align 8 .b8 params[24];
.visible .entry __raygen__a() { .reg .b32 %r<9>; .reg .b64 %rd1; .reg .f32 %f1;
  call (%r1, %r2), _optix_trace_2, (%rd1, %f1, %f1, %f1, %f1, %f1, %f1, %f1, %f1, %f1, %r1, %r1, %r1, %r1, %r1, %r1, %r2); ret; }
.func helper() { .reg .b32 %r<9>; mov.u32 %r1, 2; call _optix_set_payload, (%r1, 7); ret; }
.visible .entry __miss__b() { call helper, (); ret; }
.visible .func __direct_callable__c() { ret; }
.visible .entry kernel(.param .u64 p) { ret; }
)");
    const ModuleSummary summary = inspect(*module, rules_);
    ASSERT_EQ(summary.programs.size(), 3u);
    EXPECT_EQ(summary.programs[0].kind, ProgramKind::kRaygen);
    EXPECT_TRUE(summary.programs[0].traces);
    EXPECT_EQ(summary.programs[1].name, "__miss__b");
    EXPECT_EQ(summary.programs[1].payloadWords, 3u);
    EXPECT_FALSE(summary.programs[1].traces);
    EXPECT_EQ(summary.programs[2].kind, ProgramKind::kDirectCallable);
    EXPECT_EQ(summary.launchParamsSize, 24u);
    rules_.optix7.numPayloadValues = 2;
    EXPECT_THROW(inspect(*module, rules_), Error);
}

// optixSetPayloadTypes stands before anything that may branch. brev only begins like a branch.
TEST_F(Optix, PayloadTypesAreSetBeforeBranches) {
    ModuleRules moduleRules;
    moduleRules.payloadTypes.resize(1);
    moduleRules.payloadTypes[0].words.resize(1);
    const auto programWith = [&](const std::string& first) {
        const auto module =
            parse(std::string(kHeader) +
                  ".visible .entry __miss__a() { .reg .b32 %r<3>; .reg .pred %p;\n" + first +
                  "\ncall _optix_set_payload_types, (1);\nret; }\n");
        return inspect(*module, rules_, moduleRules).programs.at(0).payloadTypes;
    };
    EXPECT_EQ(programWith("brev.b32 %r1, %r2; brkpt;"), 1u);
    EXPECT_EQ(programWith("bra.uni next; next:"), 1u); // nvcc -G, before what it inlined
    for (const char* branch :
         {"@%p bra next; next:", "bra over; brkpt; over:", "again: bra again;"})
        EXPECT_THROW(programWith(branch), Error) << branch;
}

} // namespace
} // namespace sunstone::compiler::testing
