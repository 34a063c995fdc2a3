// SPDX-License-Identifier: Apache-2.0
// Device contexts (OptiX 7.4, section 3.4): creation, properties, log, destruction.
#include "fixture.h"

#include <algorithm>

namespace tests::api {
namespace {

constexpr unsigned kUntouched = 0xABABABABu;

// Creates a module from an invalid PTX text, which logs one error line.
OptixResult makeNoise(OptixDeviceContext context) {
    OptixModuleCompileOptions moduleOptions{};
    OptixPipelineCompileOptions options = compileOptions();
    OptixModule module = nullptr;
    return optixModuleCreateFromPTX(context, &moduleOptions, &options, nullptr, 0, nullptr, nullptr,
                                    &module);
}

class Context : public ApiTest {};

TEST_F(Context, NeedsAnOutput) {
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixDeviceContextCreate(nullptr, nullptr, nullptr));
    OptixDeviceContextOptions options{};
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixDeviceContextCreate(nullptr, &options, nullptr));
}

TEST_F(Context, OptionsMayBeNull) {
    OptixDeviceContext context = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, nullptr, &context));
    EXPECT_NE(nullptr, context);
    EXPECT_NE(context_, context);
    EXPECT_OK(optixDeviceContextDestroy(context));
}

TEST_F(Context, ValidationModes) {
    for (unsigned mode : {0u, 0xFFFFFFFFu}) {
        OptixDeviceContextOptions options{};
        options.validationMode = OptixDeviceContextValidationMode(mode);
        OptixDeviceContext context = nullptr;
        ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context)) << mode;
        EXPECT_OK(optixDeviceContextDestroy(context));
    }
    for (unsigned mode : {1u, 2u, 0xFFFFFFFEu, 0x7FFFFFFFu}) {
        OptixDeviceContextOptions options{};
        std::memcpy(&options.validationMode, &mode, sizeof(mode));
        auto context = reinterpret_cast<OptixDeviceContext>(&options);
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixDeviceContextCreate(nullptr, &options, &context))
            << mode;
        EXPECT_EQ(nullptr, context) << "a failed call leaves no handle";
    }
}

TEST_F(Context, ForeignCudaContextIsRefused) {
    // No CUDA library is loaded here, so no value can be a CUDA context.
    for (void* garbage : garbageHandles()) {
        OptixDeviceContextOptions options{};
        options.logCallbackFunction = LogRecord::callback;
        options.logCallbackData = &log_;
        options.logCallbackLevel = 4;
        auto context = reinterpret_cast<OptixDeviceContext>(1);
        EXPECT_REJECTED(OPTIX_ERROR_CUDA_ERROR, "optixDeviceContextCreate", "fromContext",
                        optixDeviceContextCreate(static_cast<CUcontext>(garbage), &options, &context));
        EXPECT_EQ(nullptr, context);
    }
}

TEST_F(Context, PropertiesHaveTheValuesOfTheLimitsTable) {
    struct {
        OptixDeviceProperty property;
        unsigned value;
    } const expected[] = {
        {OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH, 31},
        {OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRAVERSABLE_GRAPH_DEPTH, 31},
        {OPTIX_DEVICE_PROPERTY_LIMIT_MAX_PRIMITIVES_PER_GAS, 80000000},
        {OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCES_PER_IAS, 1u << 26},
        {OPTIX_DEVICE_PROPERTY_RTCORE_VERSION, 0},
        {OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCE_ID, (1u << 28) - 1},
        {OPTIX_DEVICE_PROPERTY_LIMIT_NUM_BITS_INSTANCE_VISIBILITY_MASK, 8},
        {OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_RECORDS_PER_GAS, 1u << 24},
        {OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_OFFSET, (1u << 28) - 1},
    };
    for (const auto& entry : expected) {
        unsigned value[2] = {kUntouched, kUntouched};
        EXPECT_OK(optixDeviceContextGetProperty(context_, entry.property, value, sizeof(unsigned)));
        EXPECT_EQ(entry.value, value[0]) << std::hex << entry.property;
        EXPECT_EQ(kUntouched, value[1]);
    }
}

TEST_F(Context, PropertyErrors) {
    const char* function = "optixDeviceContextGetProperty";
    unsigned value[4] = {kUntouched, kUntouched, kUntouched, kUntouched};
    auto property = OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH;
    for (size_t size : {size_t(0), size_t(1), size_t(3), size_t(5), size_t(8), ~size_t(0)})
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "sizeInBytes",
                        optixDeviceContextGetProperty(context_, property, value, size));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "value",
                    optixDeviceContextGetProperty(context_, property, nullptr, 4));
    for (unsigned unknown : {0u, 1u, 0x2000u, 0x200Au, 0x2010u, 0xFFFFFFFFu})
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "property",
                        optixDeviceContextGetProperty(context_, OptixDeviceProperty(unknown), value,
                                                      4));
    for (unsigned word : value)
        EXPECT_EQ(kUntouched, word) << "written by a refused call";
    EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
              optixDeviceContextGetProperty(nullptr, property, value, 4));
}

TEST_F(Context, LogLinesAreWellFormed) {
    EXPECT_NE(OPTIX_SUCCESS, makeNoise(context_));
    ASSERT_FALSE(log_.lines().empty());
    for (const LogLine& line : log_.lines()) {
        EXPECT_GE(line.level, 1u);
        EXPECT_LE(line.level, 4u);
        EXPECT_FALSE(line.tag.empty());
        ASSERT_FALSE(line.text.empty());
        EXPECT_NE('\n', line.text.back());
    }
    EXPECT_TRUE(log_.hasError("optixModuleCreateFromPTX", "PTX"));
}

TEST_F(Context, LogLevelLimitsWhatIsDelivered) {
    for (unsigned level = 0; level <= 4; ++level) {
        ASSERT_OK(optixDeviceContextSetLogCallback(context_, LogRecord::callback, &log_, level));
        log_.clear();
        makeNoise(context_);
        std::vector<LogLine> lines = log_.lines();
        for (const LogLine& line : lines)
            EXPECT_LE(line.level, level);
        EXPECT_EQ(level >= 2, !lines.empty()) << "level " << level << ": errors are level 2";
    }
}

TEST_F(Context, LevelsAboveTheHighestAreAccepted) {
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, LogRecord::callback, &log_, 0xFFFFFFFFu));
    log_.clear();
    makeNoise(context_);
    EXPECT_FALSE(log_.lines().empty());
}

TEST_F(Context, NegativeLevelInOptionsDeliversNothing) {
    OptixDeviceContextOptions options{};
    options.logCallbackFunction = LogRecord::callback;
    options.logCallbackData = &log_;
    options.logCallbackLevel = -1;
    OptixDeviceContext context = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context));
    log_.clear();
    makeNoise(context);
    EXPECT_TRUE(log_.lines().empty()) << log_.all();
    EXPECT_OK(optixDeviceContextDestroy(context));
}

TEST_F(Context, CallbackCanBeReplacedAndRemoved) {
    LogRecord other;
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, LogRecord::callback, &other, 4));
    log_.clear();
    makeNoise(context_);
    EXPECT_TRUE(log_.lines().empty());
    EXPECT_FALSE(other.lines().empty());

    ASSERT_OK(optixDeviceContextSetLogCallback(context_, nullptr, &other, 4));
    other.clear();
    makeNoise(context_);
    EXPECT_TRUE(other.lines().empty());
    EXPECT_TRUE(log_.lines().empty());
}

void countCalls(unsigned, const char*, const char*, void* data) {
    if (data)
        ++*static_cast<int*>(data);
}

TEST_F(Context, CallbackDataMayBeNull) {
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, countCalls, nullptr, 4));
    makeNoise(context_);
    int calls = 0;
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, countCalls, &calls, 4));
    makeNoise(context_);
    EXPECT_GT(calls, 0);
}

TEST_F(Context, CallbackMayCallBack) {
    static OptixDeviceContext reentered;
    reentered = context_;
    auto reenter = [](unsigned, const char*, const char*, void* data) {
        unsigned depth = 0;
        optixDeviceContextGetProperty(reentered, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                      &depth, sizeof(depth));
        *static_cast<unsigned*>(data) = depth;
    };
    unsigned depth = 0;
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, reenter, &depth, 4));
    makeNoise(context_);
    EXPECT_EQ(31u, depth);
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, nullptr, nullptr, 0));
}

TEST_F(Context, LogsOfTwoContextsAreSeparate) {
    LogRecord other;
    OptixDeviceContextOptions options{};
    options.logCallbackFunction = LogRecord::callback;
    options.logCallbackData = &other;
    options.logCallbackLevel = 4;
    OptixDeviceContext context = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context));
    other.clear();
    log_.clear();
    makeNoise(context);
    EXPECT_TRUE(log_.lines().empty());
    EXPECT_FALSE(other.lines().empty());
    EXPECT_OK(optixDeviceContextDestroy(context));
}

TEST_F(Context, SetLogCallbackNeedsAContext) {
    EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
              optixDeviceContextSetLogCallback(nullptr, LogRecord::callback, &log_, 4));
}

TEST_F(Context, DestroyErrors) {
    EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT, optixDeviceContextDestroy(nullptr));
    OptixDeviceContext context = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, nullptr, &context));
    ASSERT_OK(optixDeviceContextDestroy(context));
    EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT, optixDeviceContextDestroy(context));
    unsigned value = 0;
    EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
              optixDeviceContextGetProperty(context, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                            &value, sizeof(value)));
}

TEST_F(Context, DestroyTakesItsObjectsAlong) {
    OptixDeviceContext context = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, nullptr, &context));
    std::string text = ptxModule(".visible .entry __raygen__a() { ret; }\n");
    OptixModuleCompileOptions moduleOptions{};
    OptixPipelineCompileOptions options = compileOptions();
    OptixModule module = nullptr;
    ASSERT_OK(optixModuleCreateFromPTX(context, &moduleOptions, &options, text.data(), text.size(),
                                       nullptr, nullptr, &module));
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    desc.raygen = {module, "__raygen__a"};
    OptixProgramGroupOptions groupOptions{};
    OptixProgramGroup group = nullptr;
    ASSERT_OK(optixProgramGroupCreate(context, &desc, 1, &groupOptions, nullptr, nullptr, &group));
    OptixPipelineLinkOptions link{1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
    OptixPipeline pipeline = nullptr;
    ASSERT_OK(optixPipelineCreate(context, &options, &link, &group, 1, nullptr, nullptr, &pipeline));
    ASSERT_OK(optixDeviceContextDestroy(context));

    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixModuleDestroy(module));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixProgramGroupDestroy(group));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixPipelineDestroy(pipeline));
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixSbtRecordPackHeader(group, header));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixPipelineSetStackSize(pipeline, 0, 0, 1024, 1));
}

TEST_F(Context, DestroyLeavesOtherContextsAlone) {
    std::string text = ptxModule(".visible .entry __raygen__a() { ret; }\n");
    OptixModuleCompileOptions moduleOptions{};
    OptixPipelineCompileOptions options = compileOptions();
    OptixModule module = nullptr;
    ASSERT_OK(optixModuleCreateFromPTX(context_, &moduleOptions, &options, text.data(), text.size(),
                                       nullptr, nullptr, &module));
    OptixDeviceContext other = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, nullptr, &other));
    ASSERT_OK(optixDeviceContextDestroy(other));
    EXPECT_OK(optixModuleDestroy(module));
}

} // namespace
} // namespace tests::api
