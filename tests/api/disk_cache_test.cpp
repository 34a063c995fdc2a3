// SPDX-License-Identifier: Apache-2.0
// The disk cache from an application's view (OptiX 7.4, sections 3.4.2.3 to 3.4.2.9).
#include "device_memory.h"
#include "rig.h"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace tests::api {
namespace {

namespace fs = std::filesystem;

// A context whose environment names a fresh folder. Environment variables are read when a context
// is created.
class DiskCacheApi : public ApiTest {
protected:
    void SetUp() override {
        std::string name = testing::TempDir() + "sunstone_api_cache_XXXXXX";
        ASSERT_NE(nullptr, mkdtemp(name.data()));
        root_ = name;
        folder_ = root_ + "/cache";
        for (size_t i = 0; i < kVariables.size(); ++i)
            if (const char* value = std::getenv(kVariables[i]))
                before_[i] = value;
        unsetenv("OPTIX_CACHE_MAXSIZE");
        setenv("OPTIX_CACHE_PATH", folder_.c_str(), 1);
        setenv("SUNSTONE_GPU_CODE", "whole", 1); // else another thread fills the cache later
        ApiTest::SetUp();
    }
    void TearDown() override {
        ApiTest::TearDown();
        for (size_t i = 0; i < kVariables.size(); ++i)
            before_[i] ? setenv(kVariables[i], before_[i]->c_str(), 1) : unsetenv(kVariables[i]);
        unsetenv("SUNSTONE_GPU_CODE");
        fs::remove_all(root_);
    }
    // A new context under an environment; null leaves a variable unset.
    void renew(const char* path, const char* maxSize) {
        EXPECT_OK(optixDeviceContextDestroy(context_));
        log_.clear();
        path ? setenv("OPTIX_CACHE_PATH", path, 1) : unsetenv("OPTIX_CACHE_PATH");
        maxSize ? setenv("OPTIX_CACHE_MAXSIZE", maxSize, 1) : unsetenv("OPTIX_CACHE_MAXSIZE");
        ApiTest::SetUp();
    }
    int enabled() {
        int value = -1;
        EXPECT_OK(optixDeviceContextGetCacheEnabled(context_, &value));
        return value;
    }
    std::string location() {
        char text[4096] = "untouched";
        EXPECT_OK(optixDeviceContextGetCacheLocation(context_, text, sizeof text));
        return text;
    }
    std::pair<size_t, size_t> sizes() {
        size_t low = 77, high = 77;
        EXPECT_OK(optixDeviceContextGetCacheDatabaseSizes(context_, &low, &high));
        return {low, high};
    }
    size_t count(const char* text) {
        size_t found = 0;
        for (const LogLine& line : log_.lines())
            found += line.tag == "DISKCACHE" && line.text.find(text) != std::string::npos;
        return found;
    }
    // Creates a pipeline of one program that stores `number`, launches it and checks the number.
    void compile(unsigned number, bool motion = false) {
        log_.clear();
        OptixPipelineCompileOptions options = compileOptions();
        options.usesMotionBlur = motion;
        // With instances, code for GPUs depends on the graphs that other tests of the process
        // create.
        options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
        Rig rig(context_, log_,
                ptxModule(".const .align 8 .b8 params[8];\n.visible .entry __raygen__a() {\n"
                          ".reg .b32 %r<2>; .reg .b64 %rd<2>;\nld.const.u64 %rd1, [params];\n"
                          "mov.u32 %r1, " +
                          std::to_string(number) + ";\nst.global.u32 [%rd1], %r1;\nret;\n}\n"),
                options);
        const size_t group = rig.raygen("__raygen__a");
        rig.link();
        rig.raygenRecord(group);
        Buffer result(4);
        rig.run(result.address(), 1);
        EXPECT_EQ(number, *result.as<unsigned>());
    }
    static constexpr std::array kVariables = {"OPTIX_CACHE_PATH", "OPTIX_CACHE_MAXSIZE"};
    std::array<std::optional<std::string>, kVariables.size()> before_;
    std::string root_, folder_;
};

TEST_F(DiskCacheApi, OnByDefault) {
    EXPECT_EQ(1, enabled());
    EXPECT_EQ(folder_, location());
    EXPECT_TRUE(fs::is_directory(folder_));
    const auto [low, high] = sizes();
    EXPECT_EQ(size_t(512) << 20, low);
    EXPECT_EQ(size_t(1) << 30, high);
    // Without the variable, the cache is in a folder of the user that differs from that of other
    // implementations.
    renew(nullptr, nullptr);
    EXPECT_NE(std::string::npos, location().find("/tmp/SunstoneCache")) << location();
}

TEST_F(DiskCacheApi, CompiledProgramsAreFoundAgain) {
    compile(1);
    EXPECT_EQ(1u, count("miss for"));
    compile(1);
    EXPECT_EQ(1u, count("hit for")) << "by the same context\n" << log_.all();
    renew(folder_.c_str(), nullptr);
    compile(1);
    EXPECT_EQ(1u, count("hit for")) << "by another context";
    EXPECT_EQ(0u, count("miss for"));
    compile(2);
    EXPECT_EQ(1u, count("miss for")) << "another text";
    compile(1, true);
    EXPECT_EQ(1u, count("miss for")) << "other options";
}

TEST_F(DiskCacheApi, ModulesAreKnownAgain) {
    compile(1);
    EXPECT_EQ(1u, count("module new"));
    compile(1);
    EXPECT_EQ(1u, count("module known"));
    renew(folder_.c_str(), nullptr);
    compile(1);
    EXPECT_EQ(1u, count("module known"));
    compile(1, true);
    EXPECT_EQ(1u, count("module new")) << "other options";
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 0));
    compile(1);
    EXPECT_EQ(0u, count("module "));
}

// A module from the cache has the same log as a newly compiled one.
TEST_F(DiskCacheApi, KnownModulesSayTheSame) {
    const auto create = [&](const std::string& body, std::string& text) {
        const std::string ptx = ptxModule(body);
        const OptixPipelineCompileOptions options = compileOptions();
        const OptixModuleCompileOptions moduleOptions{};
        char log[2000] = "";
        size_t size = sizeof log;
        OptixModule module = nullptr;
        log_.clear();
        const OptixResult result = optixModuleCreateFromPTX(
            context_, &moduleOptions, &options, ptx.c_str(), ptx.size(), log, &size, &module);
        text = log;
        if (module) {
            EXPECT_OK(optixModuleDestroy(module));
        }
        return result;
    };
    std::string first, again;
    const std::string remarkable =
        ".visible .entry __raygen__a() {\n.reg .b32 %r<2>;\nmov.u32 %r1, 5;\n"
        "call _optix_throw_exception_0, (%r1);\nret;\n}\n";
    EXPECT_OK(create(remarkable, first));
    EXPECT_NE(std::string::npos, first.find("lack USER")) << first;
    EXPECT_EQ(1u, count("module new"));
    EXPECT_OK(create(remarkable, again));
    EXPECT_EQ(1u, count("module known"));
    EXPECT_EQ(first, again);
    const std::string faulty = ".visible .entry __raygen__a() { nonsense; }\n";
    EXPECT_EQ(OPTIX_ERROR_INVALID_PTX, create(faulty, first));
    EXPECT_EQ(OPTIX_ERROR_INVALID_PTX, create(faulty, again));
    EXPECT_EQ(1u, count("module new")) << "what is refused is not kept";
    EXPECT_EQ(first, again);
}

TEST_F(DiskCacheApi, ModulesOfOnePipelineMustAgreeThoughTheyAreKnown) {
    const auto text = [](const char* program, const char* function) {
        return ptxModule(std::string(".visible .func ") + function + "() { ret; }\n.visible .entry " +
                         program + "() { ret; }\n");
    };
    const auto link = [&](const char* function) {
        const OptixPipelineCompileOptions options = compileOptions();
        const OptixModuleCompileOptions moduleOptions{};
        OptixModule modules[2] = {};
        OptixProgramGroup groups[2] = {};
        OptixProgramGroupOptions groupOptions{};
        const std::string texts[2] = {text("__raygen__a", "shared"), text("__miss__b", function)};
        for (int i = 0; i < 2; ++i) {
            EXPECT_OK(optixModuleCreateFromPTX(context_, &moduleOptions, &options,
                                               texts[i].c_str(), texts[i].size(), nullptr, nullptr,
                                               &modules[i]));
            OptixProgramGroupDesc description{};
            description.kind =
                i == 0 ? OPTIX_PROGRAM_GROUP_KIND_RAYGEN : OPTIX_PROGRAM_GROUP_KIND_MISS;
            description.raygen = {modules[i], i == 0 ? "__raygen__a" : "__miss__b"};
            EXPECT_OK(optixProgramGroupCreate(context_, &description, 1, &groupOptions, nullptr,
                                              nullptr, &groups[i]));
        }
        OptixPipelineLinkOptions linkOptions{};
        linkOptions.maxTraceDepth = 1;
        OptixPipeline pipeline = nullptr;
        const OptixResult result =
            optixPipelineCreate(context_, &options, &linkOptions, groups, 2, nullptr, nullptr,
                                &pipeline);
        if (pipeline) {
            EXPECT_OK(optixPipelineDestroy(pipeline));
        }
        return result;
    };
    for (int round = 0; round < 2; ++round) {
        EXPECT_OK(link("other"));
        EXPECT_EQ(OPTIX_ERROR_PIPELINE_LINK_ERROR, link("shared")) << log_.all();
        renew(folder_.c_str(), nullptr);
    }
}

TEST_F(DiskCacheApi, DisablingRemovesAllCaching) {
    compile(1);
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 0));
    EXPECT_EQ(0, enabled());
    compile(1);
    EXPECT_EQ(0u, count("hit for") + count("miss for"));
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 1));
    EXPECT_EQ(1, enabled());
    compile(1);
    EXPECT_EQ(1u, count("hit for"));
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 1)) << "twice is once";
}

TEST_F(DiskCacheApi, LocationBySetting) {
    renew(nullptr, nullptr);
    const std::string one = root_ + "/one/deep", two = root_ + "/two";
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, one.c_str()));
    EXPECT_EQ(one, location());
    EXPECT_TRUE(fs::is_directory(one));
    compile(1);
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, two.c_str()));
    compile(1);
    EXPECT_EQ(1u, count("miss for")) << "a database of its own";
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, one.c_str()));
    compile(1);
    EXPECT_EQ(1u, count("hit for"));
}

TEST_F(DiskCacheApi, LocationOfTheEnvironmentGoesFirst) {
    const std::string other = root_ + "/other";
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, other.c_str()));
    EXPECT_EQ(folder_, location());
    EXPECT_FALSE(fs::exists(other));
}

TEST_F(DiskCacheApi, LocationsThatCannotBeUsed) {
    const char* kFunction = "optixDeviceContextSetCacheLocation";
    renew(nullptr, nullptr);
    std::ofstream(root_ + "/file") << "x";
    const std::string bad = root_ + "/file/cache";
    EXPECT_REJECTED(OPTIX_ERROR_DISK_CACHE_INVALID_PATH, kFunction, "file",
                    optixDeviceContextSetCacheLocation(context_, bad.c_str()));
    EXPECT_EQ(0, enabled()) << "caching is off then";
    EXPECT_EQ(bad, location());
    compile(1);
    // Off: no error until the cache is turned on.
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, bad.c_str()));
    EXPECT_REJECTED(OPTIX_ERROR_DISK_CACHE_INVALID_PATH, "optixDeviceContextSetCacheEnabled",
                    "file", optixDeviceContextSetCacheEnabled(context_, 1));
    EXPECT_EQ(0, enabled());
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, folder_.c_str()));
    EXPECT_EQ(0, enabled()) << "a good place does not turn it on";
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 1));
    EXPECT_EQ(1, enabled());

    EXPECT_REJECTED(OPTIX_ERROR_DISK_CACHE_INVALID_PATH, kFunction, "empty",
                    optixDeviceContextSetCacheLocation(context_, ""));
    EXPECT_REJECTED(OPTIX_ERROR_DISK_CACHE_INVALID_PATH, kFunction, "too long",
                    optixDeviceContextSetCacheLocation(context_, std::string(70'000, 'x').c_str()));
    const std::string blocked = root_ + "/blocked";
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 0));
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, blocked.c_str()));
    fs::create_directories(blocked + "/programs1-1.db");
    EXPECT_REJECTED(OPTIX_ERROR_DISK_CACHE_DATABASE_ERROR, "optixDeviceContextSetCacheEnabled",
                    "programs1-1.db", optixDeviceContextSetCacheEnabled(context_, 1));
    if (geteuid() != 0) { // root may write anywhere
        fs::create_directory(root_ + "/closed");
        fs::permissions(root_ + "/closed", fs::perms::owner_read | fs::perms::owner_exec);
        const std::string closed = root_ + "/closed/cache";
        EXPECT_OK(optixDeviceContextSetCacheLocation(context_, closed.c_str()));
        EXPECT_REJECTED(OPTIX_ERROR_DISK_CACHE_PERMISSION_ERROR,
                        "optixDeviceContextSetCacheEnabled", "closed",
                        optixDeviceContextSetCacheEnabled(context_, 1));
    }
}

TEST_F(DiskCacheApi, ContextsAreCreatedWithoutACache) {
    std::ofstream(root_ + "/file") << "x";
    renew((root_ + "/file").c_str(), nullptr);
    EXPECT_EQ(0, enabled());
    bool warned = false;
    for (const LogLine& line : log_.lines())
        warned |= line.level == 3 && line.tag == "DISKCACHE";
    EXPECT_TRUE(warned) << log_.all();
    compile(1);
    EXPECT_REJECTED(OPTIX_ERROR_DISK_CACHE_INVALID_PATH, "optixDeviceContextSetCacheEnabled",
                    "file", optixDeviceContextSetCacheEnabled(context_, 1));
}

TEST_F(DiskCacheApi, DatabaseSizes) {
    EXPECT_OK(optixDeviceContextSetCacheDatabaseSizes(context_, 1000, 1000));
    EXPECT_EQ(std::make_pair(size_t(1000), size_t(1000)), sizes());
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextSetCacheDatabaseSizes",
                    "highWaterMark",
                    optixDeviceContextSetCacheDatabaseSizes(context_, 1001, 1000));
    EXPECT_EQ(std::make_pair(size_t(1000), size_t(1000)), sizes());
    for (const auto& [low, high] : {std::pair<size_t, size_t>{0, 5}, {5, 0}, {0, 0}}) {
        EXPECT_OK(optixDeviceContextSetCacheDatabaseSizes(context_, low, high));
        EXPECT_EQ(std::make_pair(low, high), sizes());
    }
}

TEST_F(DiskCacheApi, CollectionMakesRoom) {
    EXPECT_OK(optixDeviceContextSetCacheDatabaseSizes(context_, 8'000, 16'000));
    for (unsigned i = 0; i < 30; ++i)
        compile(i);
    compile(29);
    EXPECT_EQ(1u, count("hit for")) << "the newest is there";
    compile(0);
    EXPECT_EQ(1u, count("miss for")) << "the oldest went";
    EXPECT_OK(optixDeviceContextSetCacheDatabaseSizes(context_, 10, 20));
    compile(100);
    EXPECT_EQ(2u, count("high water mark")) << "of the module and of its code\n" << log_.all();
    compile(100);
    EXPECT_EQ(1u, count("miss for")) << "too large to store";
}

TEST_F(DiskCacheApi, MaximumOfTheEnvironment) {
    renew(folder_.c_str(), "5000");
    EXPECT_EQ(std::make_pair(size_t(2500), size_t(5000)), sizes());
    EXPECT_OK(optixDeviceContextSetCacheDatabaseSizes(context_, 1, 2));
    EXPECT_EQ(std::make_pair(size_t(2500), size_t(5000)), sizes()) << "goes before the call";
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextSetCacheDatabaseSizes", "high",
                    optixDeviceContextSetCacheDatabaseSizes(context_, 2, 1));
    for (const char* ignored : {"-1", "1.5", "many", "12x", " 7", "99999999999999999999999"}) {
        renew(folder_.c_str(), ignored);
        EXPECT_EQ(size_t(1) << 30, sizes().second) << ignored;
        EXPECT_EQ(1, enabled()) << ignored;
    }
    // The environment cannot enable a cache that the API has disabled.
    renew(folder_.c_str(), "5000");
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 0));
    EXPECT_EQ(0, enabled());
}

TEST_F(DiskCacheApi, ZeroInTheEnvironmentTurnsItOff) {
    compile(1);
    renew(folder_.c_str(), "0");
    EXPECT_EQ(0, enabled());
    EXPECT_EQ("", location());
    EXPECT_EQ(std::make_pair(size_t(0), size_t(0)), sizes());
    EXPECT_OK(optixDeviceContextSetCacheEnabled(context_, 1));
    EXPECT_EQ(0, enabled());
    EXPECT_OK(optixDeviceContextSetCacheLocation(context_, "/nonexistent/\x01"));
    compile(1);
    EXPECT_EQ(0u, count("hit for"));
    renew(folder_.c_str(), nullptr);
    compile(1);
    EXPECT_EQ(1u, count("hit for")) << "the content was left alone";
}

TEST_F(DiskCacheApi, Arguments) {
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextGetCacheEnabled", "enabled",
                    optixDeviceContextGetCacheEnabled(context_, nullptr));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextSetCacheLocation", "location",
                    optixDeviceContextSetCacheLocation(context_, nullptr));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextGetCacheLocation", "location",
                    optixDeviceContextGetCacheLocation(context_, nullptr, 10));
    size_t mark = 0;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextGetCacheDatabaseSizes",
                    "lowWaterMark",
                    optixDeviceContextGetCacheDatabaseSizes(context_, nullptr, &mark));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextGetCacheDatabaseSizes",
                    "highWaterMark",
                    optixDeviceContextGetCacheDatabaseSizes(context_, &mark, nullptr));
    char text[8] = "xxxxxxx";
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextGetCacheLocation",
                    "locationSize", optixDeviceContextGetCacheLocation(context_, text, 0));
    EXPECT_EQ('x', text[0]) << "nothing fits";
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDeviceContextGetCacheLocation", "too small",
                    optixDeviceContextGetCacheLocation(context_, text, 4));
    EXPECT_EQ(folder_.substr(0, 3), text);
    std::vector<char> exact(folder_.size() + 1);
    EXPECT_OK(optixDeviceContextGetCacheLocation(context_, exact.data(), exact.size()));
    EXPECT_EQ(folder_, exact.data());
    for (void* garbage : garbageHandles()) {
        const auto context = static_cast<OptixDeviceContext>(garbage);
        int enabled = 0;
        size_t low = 0, high = 0;
        EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
                  optixDeviceContextSetCacheEnabled(context, 1));
        EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
                  optixDeviceContextSetCacheLocation(context, "/tmp"));
        EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
                  optixDeviceContextSetCacheDatabaseSizes(context, 1, 2));
        EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
                  optixDeviceContextGetCacheEnabled(context, &enabled));
        EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
                  optixDeviceContextGetCacheLocation(context, text, sizeof text));
        EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
                  optixDeviceContextGetCacheDatabaseSizes(context, &low, &high));
    }
}

TEST_F(DiskCacheApi, DamageDoesNoHarm) {
    const unsigned seed = std::random_device()();
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    for (unsigned round = 0; round < 12; ++round) {
        for (unsigned i = 0; i < 3; ++i)
            compile(i);
        for (const auto& entry : fs::directory_iterator(folder_)) {
            if (entry.path().extension() != ".db" || entry.file_size() == 0)
                continue;
            if (round % 3 == 0) {
                fs::resize_file(entry.path(), random() % entry.file_size());
                continue;
            }
            std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
            for (unsigned i = 0; i < (round % 3 == 1 ? 3u : 3000u); ++i) {
                file.seekp(std::streamoff(random() % entry.file_size()));
                file.put(char(random()));
            }
        }
        if (round % 2)
            renew(folder_.c_str(), nullptr);
        for (unsigned i = 0; i < 3; ++i)
            compile(i); // right with any contents of the file
    }
    compile(0);
    EXPECT_EQ(1u, count("hit for")) << "it works again";
}

TEST_F(DiskCacheApi, ManyProcessesUseOneDatabase) {
    std::vector<pid_t> children;
    for (unsigned p = 0; p < 4; ++p) {
        const pid_t child = fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            // Runs in a new process, because a forked child would lack the library's threads.
            unsetenv("GTEST_TOTAL_SHARDS"); // the child's one test may be in another shard
            unsetenv("GTEST_SHARD_INDEX");
            setenv("SUNSTONE_TEST_CHILD", "1", 1);
            setenv("SUNSTONE_TEST_CACHE", folder_.c_str(), 1);
            execl("/proc/self/exe", "test_api", "--gtest_filter=DiskCacheApi.ChildProcess",
                  static_cast<char*>(nullptr));
            _exit(127);
        }
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = -1;
        ASSERT_EQ(child, waitpid(child, &status, 0));
        EXPECT_EQ(0, status);
    }
    for (unsigned i = 0; i < 8; ++i) {
        compile(i);
        EXPECT_EQ(1u, count("hit for")) << i;
    }
}

// Runs in the children of the test above, in the folder that their environment names.
TEST_F(DiskCacheApi, ChildProcess) {
    if (!getenv("SUNSTONE_TEST_CHILD"))
        GTEST_SKIP() << "only as a child";
    const char* shared = getenv("SUNSTONE_TEST_CACHE");
    ASSERT_NE(nullptr, shared);
    renew(shared, nullptr);
    for (unsigned i = 0; i < 8; ++i)
        compile((i * 3) % 8);
    EXPECT_EQ(0u, count("cannot")) << log_.all();
}

TEST_F(DiskCacheApi, ThreadsWithContextsOfTheirOwn) {
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < 4; ++t)
        threads.emplace_back([t] {
            prepareThread();
            LogRecord log;
            OptixDeviceContextOptions options{};
            options.logCallbackFunction = LogRecord::callback;
            options.logCallbackData = &log;
            options.logCallbackLevel = 4;
            OptixDeviceContext context = nullptr;
            ASSERT_EQ(OPTIX_SUCCESS, optixDeviceContextCreate(nullptr, &options, &context));
            for (unsigned i = 0; i < 6; ++i) {
                const std::string name = "__raygen__" + std::to_string((i + t) % 6);
                Rig rig(context, log, ptxModule(".visible .entry " + name + "() { ret; }\n"),
                        compileOptions());
                rig.raygen(name.c_str());
                rig.link();
                if (i == 3) {
                    optixDeviceContextSetCacheEnabled(context, 0);
                    optixDeviceContextSetCacheEnabled(context, 1);
                }
            }
            EXPECT_EQ(OPTIX_SUCCESS, optixDeviceContextDestroy(context));
        });
    for (std::thread& thread : threads)
        thread.join();
}

} // namespace
} // namespace tests::api
