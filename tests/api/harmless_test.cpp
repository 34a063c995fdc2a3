// SPDX-License-Identifier: Apache-2.0
// Harmless violations of rules: calls succeed with a warning in the log, and their results work;
// validation mode refuses the calls.
#include "device/launch.h"
#include "rig.h"
#include "scene.h"

namespace tests::api {
namespace {

class HarmlessFaults : public ApiTest, public testing::WithParamInterface<bool> {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        if (!GetParam())
            return;
        ASSERT_OK(optixDeviceContextDestroy(context_));
        OptixDeviceContextOptions options{};
        options.logCallbackFunction = LogRecord::callback;
        options.logCallbackData = &log_;
        options.logCallbackLevel = 4;
        options.validationMode = OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
        ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context_));
    }

    // Runs a call that breaks a rule.
    template <class Call>
    void expectTolerated(const char* function, const char* mention, Call call) {
        if (GetParam())
            EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, mention, call());
        else
            expectWarning(function, mention, call);
    }
    template <class Call>
    void expectWarning(const char* function, const char* mention, Call call) {
        SCOPED_TRACE(mention);
        log_.clear();
        EXPECT_OK(call());
        unsigned warnings = 0;
        for (const LogLine& line : log_.lines())
            warnings += line.level == 3 && line.text.find(function) != std::string::npos &&
                        line.text.find(mention) != std::string::npos;
        EXPECT_EQ(1u, warnings) << log_.all();
    }

    // Checks that both functions of a build tolerate the input and flags.
    void expectBuildTolerated(const char* mention, const OptixBuildInput& input, unsigned flags = 0,
                              Accel* made = nullptr) {
        const OptixAccelBuildOptions options = buildOptions(flags);
        OptixAccelBufferSizes sizes{1 << 16, 1 << 16, 1 << 16};
        expectTolerated("optixAccelComputeMemoryUsage", mention, [&] {
            return optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes);
        });
        const Buffer temp(sizes.tempSizeInBytes);
        Accel accel{Buffer(sizes.outputSizeInBytes), 0};
        accel.memory.fill(0xCD); // as the helper buildAccel does
        expectTolerated("optixAccelBuild", mention, [&] {
            return optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(),
                                   temp.size(), accel.memory.address(), accel.memory.size(),
                                   &accel.handle, nullptr, 0);
        });
        waitForDevice();
        if (made)
            *made = std::move(accel);
    }
    std::vector<unsigned char> bytesOf(const Accel& accel) {
        return {accel.memory.as<unsigned char>(),
                accel.memory.as<unsigned char>() + accel.memory.size()};
    }
};

INSTANTIATE_TEST_SUITE_P(Mode, HarmlessFaults, testing::Bool(),
                         [](const auto& info) { return info.param ? "validation" : "plain"; });

TEST_P(HarmlessFaults, VerticesAfterTheLastTriangle) {
    TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {7, 7, 7}, {8, 8, 8}}, {0, 1, 2});
    OptixBuildInput input = mesh.input;
    input.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_NONE;
    input.triangleArray.indexBuffer = 0;
    input.triangleArray.numIndexTriplets = 0;
    input.triangleArray.numVertices = 3;
    const Accel whole = buildAccel(context_, log_, {input});
    for (unsigned count : {4u, 5u}) {
        input.triangleArray.numVertices = count;
        Accel made;
        expectBuildTolerated("is not a multiple of 3", input, 0, &made);
        if (!GetParam())
            EXPECT_EQ(bytesOf(whole), bytesOf(made)) << "the rest is ignored";
    }
}

TEST_P(HarmlessFaults, BothBuildPreferences) {
    const unsigned both = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE | OPTIX_BUILD_FLAG_PREFER_FAST_BUILD;
    TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
    const Accel plain = buildAccel(context_, log_, {mesh.input});
    Accel made;
    expectBuildTolerated("PREFER_FAST_TRACE and PREFER_FAST_BUILD", mesh.input, both, &made);
    if (!GetParam())
        EXPECT_EQ(bytesOf(plain), bytesOf(made)) << "both are ignored";

    OptixModuleCompileOptions module{};
    OptixPipelineCompileOptions pipeline = compileOptions(1);
    pipeline.usesPrimitiveTypeFlags = OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE;
    OptixBuiltinISOptions builtin{};
    builtin.builtinISModuleType = OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE;
    builtin.buildFlags = both;
    OptixModule out = nullptr;
    expectTolerated("optixBuiltinISModuleGet", "PREFER_FAST_TRACE and PREFER_FAST_BUILD", [&] {
        return optixBuiltinISModuleGet(context_, &module, &pipeline, &builtin, &out);
    });
}

TEST_P(HarmlessFaults, CompactionWithoutItsFlag) {
    TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
    const Accel source = buildAccel(context_, log_, {mesh.input});
    const Buffer target(source.memory.size());
    OptixTraversableHandle handle = 0;
    expectTolerated(GetParam() ? "optixAccelCompact" : "compaction", "without ALLOW_COMPACTION",
                    [&] {
                        return optixAccelCompact(context_, nullptr, source.handle, target.address(),
                                                 target.size(), &handle);
                    });
    waitForDevice();
    if (GetParam()) {
        EXPECT_EQ(0u, handle);
        return;
    }
    EXPECT_EQ(target.address(), handle & ~OptixTraversableHandle(63));
    OptixAccelRelocationInfo info{};
    EXPECT_OK(optixAccelGetRelocationInfo(context_, handle, &info)) << "a structure lies there";
    // A buffer that is too small is still an error.
    EXPECT_REJECTED(
        OPTIX_ERROR_INVALID_VALUE, "optixAccelCompact", "outputBufferSizeInBytes",
        optixAccelCompact(context_, nullptr, source.handle, target.address(), 128, &handle));
}

TEST_P(HarmlessFaults, FlagsAndNormalsOfCurves) {
    const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}};
    const std::vector<float> widths{0.1f, 0.1f};
    const std::vector<unsigned> first{0};
    const Buffer vertices(points), radii(widths), indices(first);
    const CUdeviceptr vertexAddress = vertices.address(), radiusAddress = radii.address();
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
    OptixBuildInputCurveArray& c = input.curveArray;
    c.curveType = OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR;
    c.numPrimitives = 1;
    c.numVertices = 2;
    c.vertexBuffers = &vertexAddress;
    c.widthBuffers = &radiusAddress;
    c.indexBuffer = indices.address();
    const Accel plain = buildAccel(context_, log_, {input});
    const auto tolerated = [&](const char* mention) {
        Accel made;
        expectBuildTolerated(mention, input, 0, &made);
        if (!GetParam())
            EXPECT_EQ(bytesOf(plain), bytesOf(made)) << mention;
    };
    c.endcapFlags = OPTIX_CURVE_ENDCAP_ON;
    tolerated("endcapFlags");
    c.endcapFlags = OPTIX_CURVE_ENDCAP_DEFAULT;
    c.normalStrideInBytes = 12;
    tolerated("normalBuffers");
    c.normalStrideInBytes = 0;
    c.normalBuffers = &vertexAddress;
    tolerated("normalBuffers");

    OptixModuleCompileOptions module{};
    OptixPipelineCompileOptions pipeline = compileOptions(1);
    pipeline.usesPrimitiveTypeFlags = OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR;
    OptixBuiltinISOptions builtin{};
    builtin.builtinISModuleType = OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR;
    builtin.curveEndcapFlags = OPTIX_CURVE_ENDCAP_ON;
    OptixModule out = nullptr;
    expectTolerated("optixBuiltinISModuleGet", "curveEndcapFlags", [&] {
        return optixBuiltinISModuleGet(context_, &module, &pipeline, &builtin, &out);
    });
}

TEST_P(HarmlessFaults, RegisterCountsAndGroupFlags) {
    const std::string text = ptxModule(".visible .entry __raygen__a() { ret; }\n");
    OptixModuleCompileOptions moduleOptions{};
    const OptixPipelineCompileOptions options = compileOptions(0);
    OptixModule module = nullptr;
    for (int count : {-1, int(0x80000000)}) {
        moduleOptions.maxRegisterCount = count;
        expectTolerated("optixModuleCreateFromPTX", "maxRegisterCount", [&] {
            return optixModuleCreateFromPTX(context_, &moduleOptions, &options, text.data(),
                                            text.size(), nullptr, nullptr, &module);
        });
        OptixTask task = nullptr;
        expectTolerated("optixModuleCreateFromPTXWithTasks", "maxRegisterCount", [&] {
            return optixModuleCreateFromPTXWithTasks(context_, &moduleOptions, &options,
                                                     text.data(), text.size(), nullptr, nullptr,
                                                     &module, &task);
        });
    }
    moduleOptions.maxRegisterCount = 0;
    ASSERT_OK(optixModuleCreateFromPTX(context_, &moduleOptions, &options, text.data(), text.size(),
                                       nullptr, nullptr, &module));
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    desc.raygen = {module, "__raygen__a"};
    OptixProgramGroupOptions groupOptions{};
    for (unsigned flags : {1u, 0x80000000u, 0xDEADBEEFu}) {
        desc.flags = flags;
        OptixProgramGroup group = nullptr;
        expectTolerated("optixProgramGroupCreate", "flags", [&] {
            return optixProgramGroupCreate(context_, &desc, 1, &groupOptions, nullptr, nullptr,
                                           &group);
        });
        EXPECT_EQ(GetParam(), group == nullptr);
    }
}

TEST_P(HarmlessFaults, TablesOfAtMostOneRecord) {
    Rig rig(context_, log_, compiledPtx("launch", "clang"), compileOptions(1));
    rig.raygenRecord(rig.raygen("__raygen__shape"), 9u);
    rig.missRecord(rig.miss("__miss__value"), 1u);
    rig.hitRecord(rig.hit("__closesthit__value"), 3u);
    rig.callableRecord(rig.callables("__direct_callable__value"), 5u);
    rig.link();
    const OptixShaderBindingTable good = rig.table();
    const Buffer seen(sizeof(LaunchSeen) * 4), params(sizeof(LaunchParams));
    params.as<LaunchParams>()->seen = seen.as<LaunchSeen>();
    const auto tolerated = [&](const char* mention, auto change) {
        OptixShaderBindingTable table = good;
        change(table);
        seen.fill(0);
        expectTolerated("optixLaunch", mention, [&] {
            return optixLaunch(rig.pipeline(), nullptr, params.address(), params.size(), &table, 1,
                               1, 1);
        });
        waitForDevice();
        EXPECT_EQ(GetParam() ? 0u : 1u, seen.as<LaunchSeen>()->runs) << mention;
    };
    using Table = OptixShaderBindingTable;
    tolerated("missRecordCount is 0", [](Table& t) { t.missRecordCount = 0; });
    tolerated("hitgroupRecordCount is 0", [](Table& t) { t.hitgroupRecordCount = 0; });
    tolerated("callablesRecordCount is 0", [](Table& t) { t.callablesRecordCount = 0; });
    tolerated("missRecordStride", [](Table& t) { t.missRecordStrideInBytes = 40; });
    tolerated("hitgroupRecordStride", [](Table& t) { t.hitgroupRecordStrideInBytes = 16; });
    tolerated("callablesRecordStride", [](Table& t) { t.callablesRecordStrideInBytes = 0; });
}

} // namespace
} // namespace tests::api
