// SPDX-License-Identifier: Apache-2.0
// Errors of the CUDA driver, with the CPU device acting as a GPU. A function of the driver fails
// once, or permanently from some call on (as after device code has broken the CUDA context): API
// calls return an error and leave no state behind that breaks the next call; all objects can be
// destroyed.
#include "api/device/launch.h"
#include "api/rig.h"
#include "api/scene.h"

#include "device/cuda/driver.h"

#include <dlfcn.h>

#include <atomic>
#include <cstdlib>
#include <functional>
#include <set>

namespace tests::api {
namespace {

using sunstone::device::cuda::Driver;
using sunstone::device::cuda::driverForTests;
using sunstone::device::cuda::DriverNames;

// The driver is chosen before its first use.
[[maybe_unused]] const bool isGpu = [] {
    setenv("SUNSTONE_GPU_BACK_END", "cpu-device", 1);
    setenv("SUNSTONE_TEST_GPU", "1", 1);
    return true;
}();

// Which calls of the driver fail, and the outcome.
struct Plan {
    long calls = 0;       // until now
    long first = -1;      // that fails; negative: none
    bool forGood = false; // and all after it
    CUresult result = CUDA_ERROR_ILLEGAL_ADDRESS;
    long failed = 0;
    const char* name = nullptr; // of the first that failed
};
std::mutex planMutex;
Plan plan;

bool fails(const char* name) {
    std::lock_guard lock(planMutex);
    const long call = plan.calls++;
    if (plan.first < 0 || call < plan.first || (call > plan.first && !plan.forGood))
        return false;
    if (plan.failed++ == 0)
        plan.name = name;
    return true;
}

// A function of the driver that fails where the plan says so.
template <auto Member, const char* const* Name>
struct Wrapped;
template <class... Arguments, CUresult (*Driver::*Member)(Arguments...), const char* const* Name>
struct Wrapped<Member, Name> {
    static inline CUresult (*original)(Arguments...) = nullptr;
    static CUresult call(Arguments... arguments) {
        return fails(*Name) ? plan.result : original(arguments...);
    }
    static void install(Driver& driver) {
        original = driver.*Member;
        driver.*Member = call;
    }
};

// Calls that never fail, with the context in any state.
const std::set<std::string> kSafe = {"cuGetErrorName", "cuGetErrorString", "cuCtxPopCurrent_v2",
                                     "cuDriverGetVersion", "cuStreamIsCapturing",
                                     "cuThreadExchangeStreamCaptureMode"};

void wrapDriver() {
    static const bool isDone = [] {
        Driver& driver = driverForTests();
#define SUNSTONE_WRAP(member, function)                                                            \
    if (!kSafe.contains(DriverNames::member))                                                      \
        Wrapped<&Driver::member, &DriverNames::member>::install(driver);
        SUNSTONE_CUDA_FUNCTIONS(SUNSTONE_WRAP)
        SUNSTONE_WRAP(streamGetCaptureInfo, cuStreamGetCaptureInfo_v2)
        SUNSTONE_WRAP(userObjectCreate, cuUserObjectCreate)
        SUNSTONE_WRAP(graphRetainUserObject, cuGraphRetainUserObject)
#undef SUNSTONE_WRAP
        return true;
    }();
    (void)isDone;
}

class DriverErrors : public ApiTest {
protected:
    void SetUp() override {
        // The kernels of builders take the compiler for the CPU many seconds; they may be cached
        // from earlier runs. The code under test may not.
        unsetenv("OPTIX_CACHE_MAXSIZE");
        ApiTest::SetUp();
        ASSERT_OK(optixDeviceContextSetCacheEnabled(context_, 0));
        wrapDriver();
    }
    void TearDown() override {
        plan = {};
        ApiTest::TearDown();
    }

    // Repeats the call with the first, the second, ... use of the driver failing, until none fails.
    // The call must succeed afterwards; if it takes long, only permanent failures are tried, and
    // success at the end. `tolerated`: functions whose failure need not be the call's.
    void failAtEachCall(const std::function<OptixResult()>& call,
                        const std::set<std::string>& tolerated = {}, bool takesLong = false) {
        ASSERT_EQ(OPTIX_SUCCESS, call()) << log_.all();
        for (const bool forGood : {true, false}) {
            if (takesLong && !forGood)
                break;
            for (long first = 0;; ++first) {
                log_.clear();
                plan = {.first = first, .forGood = forGood};
                const OptixResult result = call();
                const Plan after = plan;
                plan = {};
                if (after.failed == 0)
                    break;
                SCOPED_TRACE(testing::Message() << after.name << ", call " << first
                                                << (forGood ? " and all after it" : ""));
                if (!tolerated.contains(after.name)) {
                    EXPECT_NE(OPTIX_SUCCESS, result);
                    EXPECT_TRUE(log_.hasError("", "")) << log_.all();
                }
                if (!takesLong) {
                    ASSERT_EQ(OPTIX_SUCCESS, call()) << "afterwards\n" << log_.all();
                }
                ASSERT_LT(first, 2000);
            }
        }
        EXPECT_EQ(OPTIX_SUCCESS, call()) << "at the end\n" << log_.all();
    }
};

const TriangleMesh& mesh() {
    static const TriangleMesh one({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2});
    return one;
}

class LaunchErrors : public DriverErrors {
protected:
    void SetUp() override {
        DriverErrors::SetUp();
        rig_ = std::make_unique<Rig>(context_, log_, compiledPtx("launch", "clang"),
                                     compileOptions(1));
        rig_->raygenRecord(rig_->raygen("__raygen__other"), 1u);
        rig_->link();
        *params_.as<LaunchParams>() = {.seen = seen_.as<LaunchSeen>()};
    }
    void TearDown() override {
        rig_.reset();
        DriverErrors::TearDown();
    }
    OptixResult launch() {
        const OptixShaderBindingTable sbt = rig_->table();
        const OptixResult result = optixLaunch(rig_->pipeline(), nullptr, params_.address(),
                                               sizeof(LaunchParams), &sbt, 1, 1, 1);
        return result;
    }
    std::unique_ptr<Rig> rig_;
    Buffer seen_{sizeof(LaunchSeen)}, params_{sizeof(LaunchParams)};
};

TEST_F(LaunchErrors, OfEachCall) {
    // Slots of launches that may still run are not reused; an address without a range is accepted.
    failAtEachCall([this] { return launch(); },
                   {DriverNames::eventQuery, DriverNames::memGetAddressRange});
    waitForDevice();
    seen_.as<LaunchSeen>()->runs = 0;
    EXPECT_OK(launch());
    waitForDevice();
    EXPECT_EQ(100u, seen_.as<LaunchSeen>()->runs);
}

TEST_F(LaunchErrors, OfCapturedLaunches) {
    void* const cuda = dlopen("libcuda.so.1", RTLD_NOW | RTLD_NOLOAD);
    ASSERT_TRUE(cuda);
    const auto begin =
        reinterpret_cast<CUresult (*)(CUstream, CUstreamCaptureMode)>(
            dlsym(cuda, "cuStreamBeginCapture_v2"));
    const auto end =
        reinterpret_cast<decltype(&cuStreamEndCapture)>(dlsym(cuda, "cuStreamEndCapture"));
    const auto destroy =
        reinterpret_cast<decltype(&cuGraphDestroy)>(dlsym(cuda, "cuGraphDestroy"));
    ASSERT_TRUE(begin && end && destroy);
    CUstream stream = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, driverForTests().streamCreate(&stream, CU_STREAM_NON_BLOCKING));
    const OptixShaderBindingTable sbt = rig_->table();
    failAtEachCall(
        [&] {
            CUgraph graph = nullptr;
            EXPECT_EQ(CUDA_SUCCESS, begin(stream, CU_STREAM_CAPTURE_MODE_GLOBAL));
            const OptixResult result = optixLaunch(rig_->pipeline(), stream, params_.address(),
                                                   sizeof(LaunchParams), &sbt, 1, 1, 1);
            end(stream, &graph);
            if (graph)
                destroy(graph);
            return result;
        },
        {DriverNames::eventQuery, DriverNames::memGetAddressRange});
    EXPECT_EQ(CUDA_SUCCESS, driverForTests().streamDestroy(stream));
    dlclose(cuda);
}

TEST_F(LaunchErrors, WhenEverythingIsDestroyedInABrokenContext) {
    for (long first : {0L, 1L, 4L, 9L}) {
        SCOPED_TRACE(first);
        OptixDeviceContextOptions options{};
        options.logCallbackFunction = LogRecord::callback;
        options.logCallbackData = &log_;
        options.logCallbackLevel = 4;
        OptixDeviceContext context = nullptr;
        ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context));
        Rig rig(context, log_, ptxModule(".visible .entry __raygen__none()\n{ ret; }\n"),
                compileOptions(0));
        rig.raygenRecord(rig.raygen("__raygen__none"));
        rig.link();
        const OptixShaderBindingTable sbt = rig.table();
        EXPECT_OK(optixLaunch(rig.pipeline(), nullptr, 0, 0, &sbt, 1, 1, 1));
        plan = {.first = first, .forGood = true};
        const OptixResult result = optixDeviceContextDestroy(context);
        const bool failed = plan.failed != 0;
        plan = {};
        EXPECT_TRUE(failed);
        if (first < 2) { // calls that wait for the context
            EXPECT_EQ(OPTIX_ERROR_CUDA_ERROR, result) << log_.all();
        }
        EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT, optixDeviceContextDestroy(context));
    }
}

TEST_F(DriverErrors, OfContexts) {
    failAtEachCall(
        [this] {
            OptixDeviceContextOptions options{};
            options.logCallbackFunction = LogRecord::callback;
            options.logCallbackData = &log_;
            options.logCallbackLevel = 4;
            OptixDeviceContext context = nullptr;
            const OptixResult result = optixDeviceContextCreate(nullptr, &options, &context);
            EXPECT_EQ(result == OPTIX_SUCCESS, context != nullptr);
            return context ? optixDeviceContextDestroy(context) : result;
        },
        {DriverNames::ctxPushCurrent, DriverNames::ctxSynchronize}); // no object is left to end
}

TEST_F(DriverErrors, OfPipelines) {
    Rig rig(context_, log_, ptxModule(".visible .entry __raygen__none()\n{ ret; }\n"),
            compileOptions(0));
    rig.raygen("__raygen__none");
    failAtEachCall([&] { return rig.tryLink(1); },
                   // destroying earlier objects; unchanged stacks are logged
                   {DriverNames::ctxPushCurrent, DriverNames::ctxSynchronize,
                    DriverNames::moduleUnload, DriverNames::eventQuery},
                   true);
    failAtEachCall([&] { return optixPipelineSetStackSize(rig.pipeline(), 100, 100, 1 << 14, 1); });
}

// A driver that may support one instruction more than this library.
struct NewerDriver {
    static inline bool knows;
    static inline std::vector<std::string> texts;
    static inline decltype(Driver::moduleLoadDataEx) original;

    NewerDriver() {
        original = driverForTests().moduleLoadDataEx;
        driverForTests().moduleLoadDataEx = load;
        texts.clear();
    }
    ~NewerDriver() { driverForTests().moduleLoadDataEx = original; }
    static CUresult load(CUmodule* module, const void* image, unsigned count, CUjit_option* options,
                         void** values) {
        const std::string text = static_cast<const char*>(image);
        if (text.find("frobnicate") == std::string::npos)
            return original(module, image, count, options, values);
        texts.push_back(text);
        const bool isAlone = text.find("sunstone_launch") == std::string::npos;
        return isAlone && knows ? CUDA_SUCCESS : CUDA_ERROR_INVALID_PTX;
    }
};

TEST_F(DriverErrors, InstructionsThatOnlyTheDriverKnows) {
    const std::string text = ptxModule(
        ".global .u32 place;\n.visible .entry __raygen__none()\n{\n.reg .b32 %r<3>;\n"
        ".reg .pred %p;\n@%p frobnicate.sync.b32 {%r1, %r2}, [place], 7;\n"
        "frobnicate.sync.b32 {%r1, %r2}, [place], 8;\nadd.f32x2.oddly %r1, %r2, %r2;\nret; }\n");
    const OptixModuleCompileOptions moduleOptions{};
    const OptixPipelineCompileOptions options = compileOptions(0);
    const auto create = [&] {
        OptixModule module = nullptr;
        const OptixResult result = optixModuleCreateFromPTX(
            context_, &moduleOptions, &options, text.data(), text.size(), nullptr, nullptr, &module);
        if (module)
            EXPECT_OK(optixModuleDestroy(module));
        return result;
    };
    NewerDriver driver;
    NewerDriver::knows = false;
    EXPECT_EQ(OPTIX_ERROR_INVALID_PTX, create());
    EXPECT_TRUE(log_.hasError("optixModuleCreateFromPTX", "unknown instruction 'frobnicate'"));
    EXPECT_TRUE(log_.hasError("optixModuleCreateFromPTX", "driver refuses it")) << log_.all();
    EXPECT_TRUE(log_.hasError("optixModuleCreateFromPTX", ".oddly")) << log_.all();
    // The query: the instruction, with its operands.
    ASSERT_EQ(2u, NewerDriver::texts.size());
    EXPECT_NE(std::string::npos, NewerDriver::texts[0].find("frobnicate.sync.b32 {%r1, %r2}, "));
    EXPECT_NE(std::string::npos, NewerDriver::texts[0].find("place;"));
    EXPECT_EQ(std::string::npos, NewerDriver::texts[0].find("__raygen__"));

    NewerDriver::knows = true;
    NewerDriver::texts.clear();
    EXPECT_EQ(OPTIX_ERROR_INVALID_PTX, create()) << "the other one is still wrong";
    const std::string right = text.substr(0, text.find("add.f32x2")) + "ret; }\n";
    Rig rig(context_, log_, right, options);
    rig.raygen("__raygen__none");
    NewerDriver::texts.clear();
    EXPECT_EQ(OPTIX_ERROR_PIPELINE_LINK_ERROR, rig.tryLink(1)) << "the driver here knows no such";
    ASSERT_EQ(1u, NewerDriver::texts.size());
    EXPECT_NE(std::string::npos, NewerDriver::texts[0].find("frobnicate.sync.b32 {"));
}

TEST_F(DriverErrors, OfBuilds) {
    const OptixAccelBuildOptions options =
        buildOptions(OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_COMPACTION);
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh().input, 1, &sizes));
    Buffer temp(sizes.tempSizeInBytes), output(sizes.outputSizeInBytes), properties(64, 8);
    OptixTraversableHandle handle = 0;
    const auto build = [&](OptixBuildOperation operation) {
        OptixAccelBuildOptions these = options;
        these.operation = operation;
        const OptixAccelEmitDesc emit[] = {
            {properties.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE},
            {properties.address() + 8, OPTIX_PROPERTY_TYPE_AABBS}};
        return optixAccelBuild(context_, nullptr, &these, &mesh().input, 1, temp.address(),
                               temp.size(), output.address(), output.size(), &handle, emit, 2);
    };
    const std::set<std::string> looks = {DriverNames::memGetAddressRange, DriverNames::streamQuery};
    failAtEachCall([&] { return build(OPTIX_BUILD_OPERATION_BUILD); }, looks);
    failAtEachCall([&] { return build(OPTIX_BUILD_OPERATION_UPDATE); }, looks);
    waitForDevice();
    Buffer compacted(output.size());
    failAtEachCall(
        [&] {
            OptixTraversableHandle moved = 0;
            return optixAccelCompact(context_, nullptr, handle, compacted.address(),
                                     compacted.size(), &moved);
        },
        looks);
    OptixAccelRelocationInfo info{};
    failAtEachCall([&] { return optixAccelGetRelocationInfo(context_, handle, &info); }, looks);
    failAtEachCall(
        [&] {
            OptixTraversableHandle moved = 0;
            return optixAccelRelocate(context_, nullptr, &info, 0, 0, output.address(),
                                      output.size(), &moved);
        },
        looks);
}

TEST_F(DriverErrors, OfDenoisers) {
    constexpr unsigned kSide = 16;
    OptixDenoiserOptions options{};
    OptixDenoiser denoiser = nullptr;
    ASSERT_OK(optixDenoiserCreate(context_, OPTIX_DENOISER_MODEL_KIND_HDR, &options, &denoiser));
    OptixDenoiserSizes sizes{};
    ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser, kSide, kSide, &sizes));
    Buffer state(sizes.stateSizeInBytes), scratch(sizes.withOverlapScratchSizeInBytes);
    Buffer input(kSide * kSide * 12), output(kSide * kSide * 12), intensity(4);
    OptixImage2D from{input.address(), kSide, kSide, kSide * 12, 12, OPTIX_PIXEL_FORMAT_FLOAT3};
    OptixImage2D to = from;
    to.data = output.address();
    const std::set<std::string> looks = {DriverNames::memGetAddressRange, DriverNames::eventQuery};
    failAtEachCall(
        [&] {
            return optixDenoiserSetup(denoiser, nullptr, kSide, kSide, state.address(),
                                      state.size(), scratch.address(), scratch.size());
        },
        looks);
    failAtEachCall(
        [&] {
            return optixDenoiserComputeIntensity(denoiser, nullptr, &from, intensity.address(),
                                                 scratch.address(), scratch.size());
        },
        looks);
    const OptixDenoiserLayer layer{from, {}, to};
    failAtEachCall(
        [&] {
            OptixDenoiserParams params{};
            params.hdrIntensity = intensity.address();
            OptixDenoiserGuideLayer guides{};
            return optixDenoiserInvoke(denoiser, nullptr, &params, state.address(), state.size(),
                                       &guides, &layer, 1, 0, 0, scratch.address(), scratch.size());
        },
        looks);
    EXPECT_OK(optixDenoiserDestroy(denoiser));
}

} // namespace
} // namespace tests::api
