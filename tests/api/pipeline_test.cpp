// SPDX-License-Identifier: Apache-2.0
// optixPipelineCreate, -Destroy and -SetStackSize (OptiX 7.4, sections 3.5, 5.31, 5.32).
#include "rig.h"

namespace tests::api {
namespace {

constexpr const char* kFunction = "optixPipelineCreate";

class Pipeline : public ApiTest {
protected:
    // A module made with these options.
    OptixModule module(const std::string& text, const OptixPipelineCompileOptions& options) {
        OptixModuleCompileOptions moduleOptions{};
        OptixModule module = nullptr;
        EXPECT_OK(optixModuleCreateFromPTX(context_, &moduleOptions, &options, text.data(),
                                           text.size(), nullptr, nullptr, &module));
        return module;
    }
    OptixProgramGroup group(OptixProgramGroupKind kind, OptixModule module, const char* name) {
        OptixProgramGroupDesc desc{};
        desc.kind = kind;
        desc.raygen = {module, name};
        if (kind == OPTIX_PROGRAM_GROUP_KIND_CALLABLES)
            desc.callables = {module, name, nullptr, nullptr};
        OptixProgramGroupOptions groupOptions{};
        OptixProgramGroup group = nullptr;
        EXPECT_OK(optixProgramGroupCreate(context_, &desc, 1, &groupOptions, nullptr, nullptr,
                                          &group));
        return group;
    }
    OptixProgramGroup raygen(const std::string& text, const OptixPipelineCompileOptions& options) {
        return group(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, module(text, options), "__raygen__a");
    }
    OptixResult create(const std::vector<OptixProgramGroup>& groups) {
        pipeline_ = reinterpret_cast<OptixPipeline>(1);
        return optixPipelineCreate(context_, &options_, &link_, groups.data(),
                                   unsigned(groups.size()), nullptr, nullptr, &pipeline_);
    }
    void expectGood(const std::vector<OptixProgramGroup>& groups) {
        ASSERT_OK(create(groups));
        ASSERT_NE(nullptr, pipeline_);
        EXPECT_OK(optixPipelineDestroy(pipeline_));
    }

    const std::string simple_ = ptxModule(".visible .entry __raygen__a() { ret; }\n"
                                          ".visible .entry __miss__a() { ret; }\n");
    OptixPipelineCompileOptions options_ = compileOptions(2);
    OptixPipelineLinkOptions link_{1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
    OptixPipeline pipeline_ = nullptr;
};

TEST_F(Pipeline, GoodArguments) {
    OptixProgramGroup a = raygen(simple_, options_);
    OptixModule m = module(simple_, options_);
    OptixProgramGroup miss = group(OPTIX_PROGRAM_GROUP_KIND_MISS, m, "__miss__a");
    OptixProgramGroup nothing = group(OPTIX_PROGRAM_GROUP_KIND_MISS, nullptr, nullptr);
    expectGood({a});
    expectGood({a, miss, nothing});
    expectGood({a, a, a}); // the same group several times
    expectGood({miss});    // no raygen program: it could never be launched, but that is no error
    expectGood({nothing});
}

TEST_F(Pipeline, NullAndZeroArguments) {
    OptixProgramGroup a = raygen(simple_, options_);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "pipelineCompileOptions",
                    optixPipelineCreate(context_, nullptr, &link_, &a, 1, nullptr, nullptr,
                                        &pipeline_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "pipelineLinkOptions",
                    optixPipelineCreate(context_, &options_, nullptr, &a, 1, nullptr, nullptr,
                                        &pipeline_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "programGroups",
                    optixPipelineCreate(context_, &options_, &link_, nullptr, 1, nullptr, nullptr,
                                        &pipeline_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "numProgramGroups",
                    optixPipelineCreate(context_, &options_, &link_, &a, 0, nullptr, nullptr,
                                        &pipeline_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "pipeline",
                    optixPipelineCreate(context_, &options_, &link_, &a, 1, nullptr, nullptr,
                                        nullptr));
    EXPECT_EQ(nullptr, pipeline_);
}

TEST_F(Pipeline, TraceDepthBounds) {
    OptixProgramGroup a = raygen(simple_, options_);
    for (unsigned depth : {0u, 1u, 2u, 31u}) {
        link_.maxTraceDepth = depth;
        expectGood({a});
    }
    for (unsigned depth : {32u, 100u, ~0u}) {
        link_.maxTraceDepth = depth;
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "maxTraceDepth", create({a}));
        EXPECT_EQ(nullptr, pipeline_);
    }
}

TEST_F(Pipeline, DebugLevels) {
    OptixProgramGroup a = raygen(simple_, options_);
    for (unsigned level : {0u, 0x2350u, 0x2351u, 0x2352u, 0x2353u}) {
        std::memcpy(&link_.debugLevel, &level, sizeof(level));
        expectGood({a});
    }
    for (unsigned level : {1u, 0x2354u, ~0u}) {
        std::memcpy(&link_.debugLevel, &level, sizeof(level));
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "debugLevel", create({a}));
    }
}

TEST_F(Pipeline, CompileOptionsAreCheckedHereToo) {
    OptixProgramGroup a = raygen(simple_, options_);
    options_.numPayloadValues = 33;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "numPayloadValues", create({a}));
    EXPECT_EQ(nullptr, pipeline_);
}

TEST_F(Pipeline, ModulesOfOtherCompileOptions) {
    OptixProgramGroup same = raygen(simple_, options_);
    auto expectMismatch = [&](const OptixPipelineCompileOptions& other) {
        OptixProgramGroup different = raygen(simple_, other);
        EXPECT_REJECTED(OPTIX_ERROR_PIPELINE_LINK_ERROR, kFunction, "programGroups[1]",
                        create({same, different}));
        EXPECT_EQ(nullptr, pipeline_);
    };
    OptixPipelineCompileOptions other = options_;
    other.numPayloadValues = 3;
    expectMismatch(other);
    other = options_;
    other.numAttributeValues = 3;
    expectMismatch(other);
    other = options_;
    other.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
    expectMismatch(other);
    other = options_;
    other.exceptionFlags = OPTIX_EXCEPTION_FLAG_USER;
    expectMismatch(other);
    other = options_;
    other.usesMotionBlur = 1;
    expectMismatch(other);
    other = options_;
    other.usesPrimitiveTypeFlags = OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE;
    expectMismatch(other);
    other = options_;
    other.pipelineLaunchParamsVariableName = "parameters";
    expectMismatch(other);
    other = options_;
    other.pipelineLaunchParamsVariableName = nullptr;
    expectMismatch(other);
}

TEST_F(Pipeline, OptionsThatMeanTheSameMatch) {
    std::vector<OptixProgramGroup> groups;
    // Fewer than two attributes mean two; no primitive type means triangles and custom ones; any
    // non-zero value means motion blur; the name may be elsewhere in memory.
    options_.usesMotionBlur = 1;
    options_.usesPrimitiveTypeFlags = 0;
    options_.numAttributeValues = 2;
    std::string name = "params";
    for (int attributes : {0, 1, 2})
        for (unsigned types : {0u, 0x80000001u}) {
            OptixPipelineCompileOptions other = options_;
            other.numAttributeValues = attributes;
            other.usesPrimitiveTypeFlags = types;
            other.usesMotionBlur = attributes + 1;
            other.pipelineLaunchParamsVariableName = name.c_str();
            groups.push_back(raygen(simple_, other));
        }
    expectGood(groups);
}

TEST_F(Pipeline, OptLevelsMayDiffer) {
    std::vector<OptixProgramGroup> groups;
    for (unsigned level : {0x2340u, 0x2341u, 0x2342u, 0x2343u}) {
        OptixModuleCompileOptions moduleOptions{};
        moduleOptions.optLevel = OptixCompileOptimizationLevel(level);
        moduleOptions.maxRegisterCount = int(level % 7);
        OptixModule m = nullptr;
        ASSERT_OK(optixModuleCreateFromPTX(context_, &moduleOptions, &options_, simple_.data(),
                                           simple_.size(), nullptr, nullptr, &m));
        groups.push_back(group(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, m, "__raygen__a"));
    }
    expectGood(groups);
}

// ---- Symbols across modules ----------------------------------------------------------------------

const std::string& caller() {
    static const std::string text = ptxModule(R"(
.extern .func (.param .b32 r) twice(.param .b32 a);
.extern .const .align 8 .b8 params[16];
.visible .entry __raygen__a()
{
    .reg .b32 %r<4>;
    .reg .b64 %rd<3>;
    ld.const.u64 %rd1, [params];
    cvta.to.global.u64 %rd2, %rd1;
    ld.const.u32 %r1, [params+8];
    {
    .param .b32 a;
    .param .b32 r;
    st.param.b32 [a], %r1;
    call.uni (r), twice, (a);
    ld.param.b32 %r2, [r];
    }
    st.global.u32 [%rd2], %r2;
    ret;
}
)");
    return text;
}

// Defines twice() and the launch parameters, and has a program so that a group can be made of it.
std::string callee(const char* parameters) {
    return ptxModule(std::string(parameters) + R"(
.visible .func (.param .b32 r) twice(.param .b32 a)
{
    .reg .b32 %r<4>;
    ld.param.b32 %r1, [a];
    ld.const.u32 %r3, [params+12];
    add.s32 %r2, %r1, %r1;
    add.s32 %r2, %r2, %r3;
    st.param.b32 [r], %r2;
    ret;
}
.visible .entry __miss__a()
{
    .reg .b32 %r<2>;
    ld.const.u32 %r1, [params+8];
    ret;
}
)");
}
const char* const kParameters = ".visible .const .align 8 .b8 params[16];";

TEST_F(Pipeline, ModulesMayCallEachOther) {
    OptixModule a = module(caller(), options_);
    OptixModule b = module(callee(kParameters), options_);
    OptixProgramGroup first = group(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, a, "__raygen__a");
    OptixProgramGroup second = group(OPTIX_PROGRAM_GROUP_KIND_MISS, b, "__miss__a");
    ASSERT_OK(create({first, second}));

    // Modules and groups may be destroyed before the launch, because the pipeline owns its code.
    Buffer record(OPTIX_SBT_RECORD_HEADER_SIZE, OPTIX_SBT_RECORD_ALIGNMENT);
    ASSERT_OK(optixSbtRecordPackHeader(first, record.as<void>()));
    EXPECT_OK(optixModuleDestroy(a));
    EXPECT_OK(optixModuleDestroy(b));
    EXPECT_OK(optixProgramGroupDestroy(first));
    EXPECT_OK(optixProgramGroupDestroy(second));
    Buffer out(4);
    struct {
        CUdeviceptr out;
        uint32_t value, more;
    } const values{out.address(), 21, 1000};
    Buffer params(sizeof(values));
    std::memcpy(params.as<void>(), &values, sizeof(values));
    OptixShaderBindingTable sbt{};
    sbt.raygenRecord = record.address();
    ASSERT_OK(optixLaunch(pipeline_, nullptr, params.address(), params.size(), &sbt, 1, 1, 1));
    waitForDevice();
    EXPECT_EQ(1042u, *out.as<uint32_t>());
}

TEST_F(Pipeline, UnresolvedSymbols) {
    OptixProgramGroup a = raygen(caller(), options_);
    EXPECT_REJECTED(OPTIX_ERROR_PIPELINE_LINK_ERROR, kFunction, "twice", create({a}));
    EXPECT_EQ(nullptr, pipeline_);
    std::string text = ptxModule(".extern .global .align 4 .u32 elsewhere;\n"
                                 ".visible .entry __raygen__a() { .reg .b32 %r<2>;\n"
                                 "ld.global.u32 %r1, [elsewhere];\n"
                                 "st.global.u32 [elsewhere], %r1;\nret; }\n");
    EXPECT_REJECTED(OPTIX_ERROR_PIPELINE_LINK_ERROR, kFunction, "elsewhere",
                    create({raygen(text, options_)}));
}

TEST_F(Pipeline, DuplicateSymbols) {
    OptixProgramGroup a = raygen(caller(), options_);
    std::vector<OptixProgramGroup> groups{a};
    for (int i = 0; i < 2; ++i)
        groups.push_back(group(OPTIX_PROGRAM_GROUP_KIND_MISS,
                               module(callee(kParameters), options_), "__miss__a"));
    EXPECT_REJECTED(OPTIX_ERROR_PIPELINE_LINK_ERROR, kFunction, "twice", create(groups));
    EXPECT_EQ(nullptr, pipeline_);
}

TEST_F(Pipeline, LaunchParametersOfDifferentSize) {
    OptixModule a = module(caller(), options_);
    OptixModule b = module(callee(".visible .const .align 8 .b8 params[24];"), options_);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_LAUNCH_PARAMETER, kFunction, "params",
                    create({group(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, a, "__raygen__a"),
                            group(OPTIX_PROGRAM_GROUP_KIND_MISS, b, "__miss__a")}));
    EXPECT_EQ(nullptr, pipeline_);
}

// All .const variables share 64 KiB; the launch parameters count once.
TEST_F(Pipeline, ConstantMemory) {
    const auto text = [](const char* program, unsigned bytes) {
        return ptxModule(std::string(kParameters) + "\n.const .align 4 .b8 table_" + program + "[" +
                         std::to_string(bytes) + "];\n.visible .entry __" + program +
                         "__a() { ret; }\n");
    };
    OptixProgramGroup first = group(OPTIX_PROGRAM_GROUP_KIND_RAYGEN,
                                    module(text("raygen", 40000), options_), "__raygen__a");
    ASSERT_OK(create({first}));
    const unsigned rest = 65536 - 40000 - 16;
    const auto miss = [&](unsigned bytes) {
        return group(OPTIX_PROGRAM_GROUP_KIND_MISS, module(text("miss", bytes), options_),
                     "__miss__a");
    };
    EXPECT_OK(create({first, miss(rest)}));
    EXPECT_REJECTED(OPTIX_ERROR_PIPELINE_OUT_OF_CONSTANT_MEMORY, kFunction, "65537 bytes",
                    create({first, miss(rest + 1)}));
    EXPECT_EQ(nullptr, pipeline_);
}

TEST_F(Pipeline, LogString) {
    OptixProgramGroup a = raygen(caller(), options_);
    char text[1024];
    size_t size = sizeof(text);
    EXPECT_EQ(OPTIX_ERROR_PIPELINE_LINK_ERROR,
              optixPipelineCreate(context_, &options_, &link_, &a, 1, text, &size, &pipeline_));
    EXPECT_EQ(std::strlen(text) + 1, size);
    EXPECT_NE(nullptr, std::strstr(text, "twice")) << text;
    size_t small = 6;
    char cut[8] = {0, 0, 0, 0, 0, 'x', 'y', 'z'};
    EXPECT_EQ(OPTIX_ERROR_PIPELINE_LINK_ERROR,
              optixPipelineCreate(context_, &options_, &link_, &a, 1, cut, &small, &pipeline_));
    EXPECT_EQ(size, small);
    EXPECT_EQ('\0', cut[5]);
    EXPECT_EQ('y', cut[6]);
    EXPECT_EQ(std::string(text, 5), cut);
    OptixProgramGroup good = raygen(simple_, options_);
    size = sizeof(text);
    ASSERT_OK(optixPipelineCreate(context_, &options_, &link_, &good, 1, text, &size, &pipeline_));
    EXPECT_EQ(std::strlen(text) + 1, size);
}

// ---- Stack sizes ---------------------------------------------------------------------------------

TEST_F(Pipeline, StackSizeBounds) {
    ASSERT_OK(create({raygen(simple_, options_)}));
    for (unsigned depth : {1u, 2u, 31u})
        EXPECT_OK(optixPipelineSetStackSize(pipeline_, 0, 0, 0, depth)) << depth;
    EXPECT_OK(optixPipelineSetStackSize(pipeline_, 1024, 1 << 16, 1 << 16, 2));
    for (unsigned depth : {0u, 32u, ~0u})
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixPipelineSetStackSize",
                        "maxTraversableGraphDepth",
                        optixPipelineSetStackSize(pipeline_, 1024, 1024, 1024, depth));
}

TEST_F(Pipeline, DestroyedOnlyOnce) {
    ASSERT_OK(create({raygen(simple_, options_)}));
    EXPECT_OK(optixPipelineDestroy(pipeline_));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixPipelineDestroy(pipeline_));
}

} // namespace
} // namespace tests::api
