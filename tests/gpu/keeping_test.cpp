// SPDX-License-Identifier: Apache-2.0
// Cached machine code, with the CPU device acting as a GPU: when code is compiled and loaded again,
// and which code must not be shared. Calls of the driver are counted.
#include "counted_driver.h"

#include "api/device_memory.h"
#include "api/rig.h"
#include "api/scene.h"

#include "compiler/gpu/pipeline.h"
#include "device/cuda/driver.h"
#include "engine/gpu/code/kernel_code.h"
#include "engine/gpu/code/ready_code.h"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <thread>

namespace tests::api {
namespace {

namespace fs = std::filesystem;
using sunstone::device::cuda::Driver;
using sunstone::device::cuda::driverForTests;
using sunstone::engine::GpuKernelCode;

// Stores `number` at the address in the launch parameters.
std::string stores(unsigned number) {
    return ptxModule(".const .align 8 .b8 params[8];\n.visible .entry __raygen__a() {\n"
                     ".reg .b32 %r<2>; .reg .b64 %rd<2>;\nld.const.u64 %rd1, [params];\n"
                     "mov.u32 %r1, " +
                     std::to_string(number) + ";\nst.global.u32 [%rd1], %r1;\nret;\n}\n");
}
// Counts its launches in a module variable, and stores that number.
const char* const kCounts = ".const .align 8 .b8 params[8];\n.global .align 4 .u32 counter = 0;\n"
                            ".visible .entry __raygen__a() {\n"
                            ".reg .b32 %r<2>; .reg .b64 %rd<2>;\nld.const.u64 %rd1, [params];\n"
                            "ld.global.u32 %r1, [counter];\nadd.u32 %r1, %r1, 1;\n"
                            "st.global.u32 [counter], %r1;\nst.global.u32 [%rd1], %r1;\nret;\n}\n";

class GpuKeeping : public CachedGpuTest {
protected:
    OptixDeviceContext newContext() {
        OptixDeviceContextOptions options{};
        options.logCallbackFunction = LogRecord::callback;
        options.logCallbackData = &log_;
        options.logCallbackLevel = 4;
        OptixDeviceContext context = nullptr;
        EXPECT_OK(optixDeviceContextCreate(nullptr, &options, &context));
        return context;
    }
    std::unique_ptr<Rig> make(OptixDeviceContext context, const std::string& text) {
        auto rig = std::make_unique<Rig>(context, log_, text, compileOptions());
        const size_t group = rig->raygen("__raygen__a");
        rig->link();
        rig->raygenRecord(group);
        return rig;
    }
    static constexpr unsigned kLargeLaunch =
        1 << 16; // waits for the whole, see engine/gpu/code/code.h
    static unsigned run(Rig& rig, unsigned width = 1) {
        Buffer result(4);
        rig.run(result.address(), width);
        return *result.as<unsigned>();
    }
    // Number of look-ups that the disk cache could not answer.
    unsigned missed() const {
        unsigned found = 0;
        for (const LogLine& line : log_.lines())
            found += line.tag == "DISKCACHE" && line.text.starts_with("miss for");
        return found;
    }
};

TEST_F(GpuKeeping, EqualPipelinesShareTheirCode) {
    auto one = make(context_, stores(7));
    auto two = make(context_, stores(7));
    EXPECT_EQ(7u, run(*one));
    EXPECT_EQ(7u, run(*two));
    EXPECT_EQ(1u, loads);
    EXPECT_EQ(1u, missed());
    one.reset();
    EXPECT_EQ(7u, run(*two)) << "outlives the one that was first";
    two.reset();
    EXPECT_EQ(7u, run(*make(context_, stores(7)))) << "with none alive";
    EXPECT_EQ(1u, loads);
    EXPECT_EQ(8u, run(*make(context_, stores(8)))) << "another text";
    EXPECT_EQ(2u, loads);
    EXPECT_EQ(0u, unloads);
}

TEST_F(GpuKeeping, VariablesAreEachPipelinesOwn) {
    auto one = make(context_, ptxModule(kCounts));
    auto two = make(context_, ptxModule(kCounts));
    EXPECT_EQ(1u, run(*one));
    EXPECT_EQ(2u, run(*one));
    EXPECT_EQ(1u, run(*two));
    EXPECT_EQ(3u, run(*one));
    EXPECT_EQ(2u, missed())
        << "code for two levels, given up, and for any depth; kept from then on";
    EXPECT_EQ(2u, loads);
    one.reset();
    two.reset();
    EXPECT_EQ(2u, unloads);
    EXPECT_EQ(1u, run(*make(context_, ptxModule(kCounts)))) << "begins anew";
}

TEST_F(GpuKeeping, OfOtherContextsOnlyTheMachineCodeIsTaken) {
    auto mine = make(context_, stores(7));
    const OptixDeviceContext first = newContext(), second = newContext();
    auto one = make(first, stores(7)), two = make(second, stores(7));
    EXPECT_EQ(1u, missed());
    EXPECT_EQ(3u, loads);
    EXPECT_OK(optixDeviceContextDestroy(first)); // with its pipeline
    EXPECT_EQ(7u, run(*two));
    EXPECT_EQ(7u, run(*mine));
    EXPECT_OK(optixDeviceContextDestroy(second));
    EXPECT_EQ(7u, run(*mine));
    EXPECT_EQ(2u, unloads);
}

TEST_F(GpuKeeping, WithoutACacheNothingIsKept) {
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 0));
    auto one = make(context_, stores(7)), two = make(context_, stores(7));
    EXPECT_EQ(7u, run(*two));
    EXPECT_EQ(2u, loads);
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 1));
    make(context_, stores(7));
    EXPECT_EQ(1u, missed());
    make(context_, stores(7));
    EXPECT_EQ(1u, missed());
    EXPECT_EQ(3u, loads);
    // Another folder is another cache.
    setenv("OPTIX_CACHE_PATH", (folder_ + "/other").c_str(), 1);
    const OptixDeviceContext other = newContext();
    make(other, stores(7));
    EXPECT_EQ(2u, missed());
    EXPECT_OK(optixDeviceContextDestroy(other));
    // Code lost from the disk is compiled again, although it is loaded.
    const std::string third = folder_ + "/third";
    unsetenv("OPTIX_CACHE_PATH");
    const OptixDeviceContext free = newContext();
    EXPECT_OK(optixDeviceContextSetCacheLocation(free, (folder_ + "/other").c_str()));
    make(free, stores(7));
    EXPECT_EQ(2u, missed());
    EXPECT_OK(optixDeviceContextSetCacheLocation(free, third.c_str()));
    make(free, stores(7));
    EXPECT_EQ(3u, missed());
    EXPECT_OK(optixDeviceContextDestroy(free));
}

TEST_F(GpuKeeping, ModulesMayBeGoneBeforeTheirPipeline) {
    make(context_, stores(7));
    const OptixDeviceContext other = newContext();
    Rig rig(other, log_, stores(7), compileOptions());
    const size_t group = rig.raygen("__raygen__a");
    EXPECT_OK(optixModuleDestroy(rig.module()));
    rig.link();
    rig.raygenRecord(group);
    EXPECT_EQ(7u, run(rig));
    EXPECT_EQ(1u, missed());
}

TEST_F(GpuKeeping, OfManyPipelinesTheOldestGo) {
    auto first = make(context_, stores(0));
    for (unsigned i = 1; i < 20; ++i)
        make(context_, stores(i));
    EXPECT_EQ(20u, loads);
    EXPECT_EQ(3u, unloads) << "unused ones beyond 16";
    EXPECT_EQ(0u, run(*first));
    EXPECT_EQ(19u, run(*make(context_, stores(19))));
    EXPECT_EQ(20u, loads);
}

// With a compiler library beside the driver, which returns machine code.
TEST_F(GpuKeeping, MachineCodeThatTheDriverRefusesIsMadeAnew) {
    if (!dlopen("libnvidia-ptxjitcompiler.so.1", RTLD_NOW))
        GTEST_SKIP() << "no compiler beside the driver";
    make(context_, stores(7));
    EXPECT_EQ(1u, loads);
    // Kept code and new code are refused: then the text is compiled.
    for (const unsigned refused : {1u, 0u, 2u, 0u}) {
        const OptixDeviceContext other = newContext();
        refusals = refused;
        EXPECT_EQ(7u, run(*make(other, stores(7)))) << refused;
        EXPECT_EQ(0u, refusals);
        EXPECT_OK(optixDeviceContextDestroy(other));
    }
    EXPECT_EQ(5u, loads);
    EXPECT_EQ(1u, missed());
}

// The machine code may refer to functions of the driver. Then the driver compiles the text.
TEST_F(GpuKeeping, MachineCodeWhoseKernelTheDriverDoesNotFind) {
    if (!dlopen("libnvidia-ptxjitcompiler.so.1", RTLD_NOW))
        GTEST_SKIP() << "no compiler beside the driver";
    lacks = 1;
    EXPECT_EQ(7u, run(*make(context_, stores(7))));
    EXPECT_EQ(0u, lacks);
    EXPECT_EQ(2u, loads);
    EXPECT_EQ(1u, unloads);
    const OptixDeviceContext other = newContext();
    EXPECT_EQ(7u, run(*make(other, stores(7))));
    EXPECT_OK(optixDeviceContextDestroy(other));
    EXPECT_EQ(1u, missed()) << "the text is kept";
}

// ---- code that is ready before the pipeline is compiled ---------------------------------------

class GpuReadyCode : public GpuKeeping {
protected:
    // With the kernels that may serve the tests' pipelines.
    void SetUp() override {
        GpuKeeping::SetUp();
        unsetenv("SUNSTONE_GPU_CODE");
        if (!dlopen("libnvidia-ptxjitcompiler.so.1", RTLD_NOW))
            GTEST_SKIP() << "no compiler beside the driver";
        CUdevice device = 0;
        int major = 0, minor = 0, version = 0;
        const Driver& driver = driverForTests();
        ASSERT_EQ(CUDA_SUCCESS, driver.ctxGetDevice(&device));
        driver.deviceGetAttribute(&major, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, device);
        driver.deviceGetAttribute(&minor, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR, device);
        driver.driverGetVersion(&version);
        const sunstone::compiler::GpuTarget target = {unsigned(10 * major + minor), 80,
                                                      unsigned(version)};
        for (const auto& kernel : sunstone::engine::readyKernels(target))
            if (sunstone::engine::readyKernelId(kernel).find("shapes 0, motion 0, depth 2") !=
                std::string::npos)
                EXPECT_NE(sunstone::engine::compileReadyKernel(kernel, nullptr), "");
    }
    void TearDown() override {
        GpuKernelCode::forgetForTests();
        GpuKeeping::TearDown();
    }
    // Launches until code is loaded.
    static bool isReplaced(Rig& rig, unsigned result, unsigned seconds = 60) {
        const unsigned before = loads;
        const auto start = std::chrono::steady_clock::now();
        while (loads == before) {
            EXPECT_EQ(result, run(rig));
            if (std::chrono::steady_clock::now() - start > std::chrono::seconds(seconds))
                return false;
        }
        return true;
    }
};

TEST_F(GpuReadyCode, IsReplacedWhenTheWholeIsCompiled) {
    auto rig = make(context_, stores(7));
    EXPECT_EQ(1u, loads);
    EXPECT_TRUE(isReplaced(*rig, 7));
    EXPECT_EQ(7u, run(*rig));
    EXPECT_EQ(2u, loads);
    EXPECT_EQ(0u, unloads) << "captured graphs may launch it";
    rig.reset();
    EXPECT_EQ(7u, run(*make(context_, stores(7)))) << "from the disk";
    EXPECT_EQ(3u, loads);
}

// As with a driver that is older than the machine code of the build.
TEST_F(GpuReadyCode, KernelsThatAreMissingAreKeptOnDisk) {
    GpuKernelCode::forgetForTests();
    ASSERT_EQ(7u, run(*make(context_, stores(7))));
    ASSERT_EQ(1u, loads) << "there is no kernel";
    const auto start = std::chrono::steady_clock::now();
    for (unsigned value = 8;; ++value) {
        GpuKernelCode::forgetForTests();
        auto rig = make(context_, stores(value));
        EXPECT_EQ(value, run(*rig));
        if (isReplaced(*rig, value, 5)) // ready code, then the whole
            break;
        ASSERT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(200));
    }
}

TEST_F(GpuReadyCode, TheThirdLaunchWaitsForTheWhole) {
    auto rig = make(context_, stores(7));
    for (unsigned i = 0; i < 3; ++i)
        EXPECT_EQ(7u, run(*rig, kLargeLaunch));
    EXPECT_EQ(2u, loads);
}

// The end of a process waits for the compilation. A compilation that has not begun is not kept, so
// the test repeats.
TEST_F(GpuReadyCode, ShortProcessesKeepTheWhole) {
    constexpr unsigned kMost = 20;
    bool isKept = false;
    for (unsigned value = 100; value < 100 + kMost && !isKept; ++value) {
        EXPECT_EQ(value, run(*make(context_, stores(value))));
        ApiTest::TearDown();
        ApiTest::SetUp();
        loads = 0;
        auto rig = make(context_, stores(value));
        for (unsigned i = 0; i < 3; ++i)
            EXPECT_EQ(value, run(*rig, kLargeLaunch));
        isKept = loads == 1; // else ready code, then the whole
    }
    EXPECT_TRUE(isKept);
}

// A load waits for kernels that run, which may wait for the thread that launches.
TEST_F(GpuReadyCode, BusyStreamsLoadNothing) {
    auto rig = make(context_, stores(7));
    ASSERT_EQ(1u, loads);
    const Driver& driver = driverForTests();
    std::atomic<bool> mayEnd = false;
    const auto wait = [](void* flag) {
        while (!*static_cast<std::atomic<bool>*>(flag))
            std::this_thread::yield();
    };
    Buffer results(4);
    const CUdeviceptr address = results.address();
    const Buffer params(std::vector<CUdeviceptr>{address});
    const OptixShaderBindingTable table = rig->table();
    ASSERT_EQ(CUDA_SUCCESS, driver.launchHostFunc(nullptr, wait, &mayEnd));
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::seconds(3)) {
        ASSERT_OK(optixLaunch(rig->pipeline(), nullptr, params.address(), sizeof(address), &table,
                              1, 1, 1));
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    EXPECT_EQ(1u, loads);
    mayEnd = true;
    ASSERT_EQ(CUDA_SUCCESS, driver.streamSynchronize(nullptr));
    EXPECT_EQ(7u, *results.as<unsigned>());
    EXPECT_TRUE(isReplaced(*rig, 7));
}

// Applications queue events and copies of parameters before their launches.
TEST_F(GpuReadyCode, ShortWorkBeforeALaunchMakesNoStreamBusy) {
    auto rig = make(context_, stores(7));
    ASSERT_EQ(1u, loads);
    const auto work = [](void*) {
        const auto start = std::chrono::steady_clock::now();
        while (std::chrono::steady_clock::now() - start < std::chrono::microseconds(50))
            ;
    };
    for (unsigned i = 0; i < 20; ++i) {
        ASSERT_EQ(CUDA_SUCCESS, driverForTests().launchHostFunc(nullptr, work, nullptr));
        EXPECT_EQ(7u, run(*rig, kLargeLaunch));
    }
    EXPECT_EQ(2u, loads);
}

TEST_F(GpuReadyCode, IsKeptIfTheDriverRefusesTheWhole) {
    auto rig = make(context_, stores(7));
    refusals = 1;
    const auto start = std::chrono::steady_clock::now();
    while (refusals != 0 && std::chrono::steady_clock::now() - start < std::chrono::seconds(60))
        EXPECT_EQ(7u, run(*rig));
    EXPECT_EQ(0u, refusals);
    EXPECT_EQ(7u, run(*rig));
    EXPECT_EQ(1u, loads);
}

TEST_F(GpuReadyCode, TheWholeIsCompiledIfTheDriverRefusesIt) {
    refusals = 1;
    auto rig = make(context_, stores(7));
    EXPECT_EQ(0u, refusals);
    EXPECT_EQ(7u, run(*rig));
    EXPECT_EQ(1u, loads);
    EXPECT_EQ(7u, run(*make(context_, stores(7)))) << "shared";
    EXPECT_EQ(1u, loads);
}

TEST_F(GpuReadyCode, ContextsMayBeDestroyedAtOnce) {
    for (unsigned i = 0; i < 5; ++i) {
        const OptixDeviceContext other = newContext();
        auto first = make(other, stores(10 + i)), second = make(other, stores(20 + i));
        EXPECT_EQ(10 + i, run(*first));
        first.reset();
        EXPECT_OK(optixDeviceContextDestroy(other)); // with the other pipeline
        second->forget();
    }
}

TEST_F(GpuReadyCode, ProgramsWithVariablesCompileAsAWhole) {
    auto one = make(context_, ptxModule(kCounts));
    EXPECT_EQ(1u, run(*one));
    EXPECT_EQ(2u, run(*one));
    EXPECT_EQ(1u, loads);
}

// ---- the library's own kernels ----------------------------------------------------------------

class GpuKernels : public GpuKeeping {
protected:
    void SetUp() override {
        GpuKeeping::SetUp();
        if (!dlopen("libnvidia-ptxjitcompiler.so.1", RTLD_NOW))
            GTEST_SKIP() << "no compiler beside the driver";
        GpuKernelCode::forgetForTests();
    }
    // Queries the sizes of a triangle's structure, which prepares kernels, and may build it.
    void prepare(OptixDeviceContext context, bool builds = false) {
        TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
        const OptixAccelBuildOptions options = buildOptions();
        OptixAccelBufferSizes sizes{};
        EXPECT_OK(optixAccelComputeMemoryUsage(context, &options, &mesh.input, 1, &sizes));
        if (builds)
            EXPECT_NE(buildAccel(context, log_, {mesh.input}).handle, 0u);
    }
    // With a new context; returns the number of kernels missing in the disk cache.
    unsigned prepareAnew(bool inNewProcess) {
        if (inNewProcess)
            GpuKernelCode::forgetForTests();
        loads = 0;
        const unsigned before = missed();
        const OptixDeviceContext context = newContext();
        prepare(context);
        EXPECT_OK(optixDeviceContextDestroy(context));
        return missed() - before;
    }
};

TEST_F(GpuKernels, AreFoundByOtherContextsAndProcesses) {
    const unsigned made = prepareAnew(true);
    EXPECT_GT(made, 8u);
    EXPECT_EQ(made, loads) << "each is a module";
    EXPECT_EQ(0u, prepareAnew(false));
    EXPECT_EQ(made, loads) << "another context loads them again";
    EXPECT_EQ(0u, prepareAnew(true)) << "from the disk";
    EXPECT_EQ(made, loads);
    // A process that has loaded the kernels writes them to a cache that lacks them.
    setenv("OPTIX_CACHE_PATH", (folder_ + "/other").c_str(), 1);
    EXPECT_EQ(made, prepareAnew(false));
    EXPECT_EQ(0u, prepareAnew(true));
}

TEST_F(GpuKernels, WithoutACacheNothingIsWritten) {
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 0));
    prepare(context_);
    EXPECT_EQ(0u, missed());
    EXPECT_GT(prepareAnew(true), 8u);
    setenv("OPTIX_CACHE_MAXSIZE", "0", 1);
    EXPECT_EQ(0u, prepareAnew(true));
    EXPECT_GT(loads, 8u);
    unsetenv("OPTIX_CACHE_MAXSIZE");
}

TEST_F(GpuKernels, RefusedAndDamagedOnesAreMadeAnew) {
    const unsigned made = prepareAnew(true);
    refusals = 2; // one of the disk, and its replacement: then the driver gets the text
    EXPECT_EQ(0u, prepareAnew(true));
    EXPECT_EQ(0u, refusals);
    EXPECT_EQ(made, loads);
    for (const auto& entry : fs::directory_iterator(folder_))
        if (entry.path().extension() == ".db") {
            std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
            for (size_t at = 5000; at < entry.file_size(); at += 1000) {
                file.seekp(std::streamoff(at));
                file.put('?');
            }
        }
    EXPECT_GT(prepareAnew(true), 0u);
    EXPECT_EQ(0u, prepareAnew(true)) << "kept again";
}

TEST_F(GpuKernels, ForeignEntriesAreNoCode) {
    const auto cache = std::make_shared<sunstone::engine::CompileCache>(
        [](sunstone::LogLevel, const std::string&) {});
    cache->start();
    GpuKernelCode codes(90, 13000, nullptr);
    codes.useCache(cache);
    const sunstone::device::cuda::KernelSource kernel{"a", "test a", [] { return "the text"; }};
    const sunstone::device::cuda::KernelSource* const one = &kernel;
    const std::string code = codes.machineCode({&one, 1}, false)[0];
    EXPECT_NE(std::string::npos, code.find("the text"));
    EXPECT_EQ(std::string::npos, code.find("maxrregcount")) << "kernels say themselves";
    const std::string key = sunstone::compiler::keyOf({90, 0, 13000}, "test a");
    std::string kept;
    ASSERT_TRUE(cache->find(key, kept));
    EXPECT_NE(std::string::npos, kept.find("the text"));
    for (const std::string& foreign : {std::string("something else"), kept + "?", std::string()}) {
        cache->insert(key, foreign);
        GpuKernelCode::forgetForTests();
        EXPECT_EQ(code, codes.machineCode({&one, 1}, false)[0]);
        std::string now;
        EXPECT_TRUE(cache->find(key, now));
        EXPECT_EQ(kept, now);
    }
    // Another device or driver has other code.
    EXPECT_NE(key, sunstone::compiler::keyOf({80, 0, 13000}, "test a"));
    EXPECT_NE(key, sunstone::compiler::keyOf({90, 0, 12080}, "test a"));
}

TEST_F(GpuKernels, ManyThreadsMayBuildFirst) {
    const OptixDeviceContext context = newContext();
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&] {
            prepareThread();
            prepare(context, true);
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(missed(), loads) << "each kernel was made and loaded once";
    EXPECT_OK(optixDeviceContextDestroy(context));
}

} // namespace
} // namespace tests::api
