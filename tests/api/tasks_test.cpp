// SPDX-License-Identifier: Apache-2.0
// optixModuleCreateFromPTXWithTasks, optixModuleGetCompilationState, optixTaskExecute (OptiX 7.4,
// sections 3.6.2.3, 3.6.2.5, 3.7).
#include "rig.h"

#include <atomic>
#include <deque>
#include <thread>

namespace tests::api {
namespace {

// A module with `count` miss programs, each with some work in it, and one raygen program that
// stores 42 where the launch parameters point.
std::string moduleOf(unsigned count, const std::string& extra = "") {
    std::string text = ".const .align 8 .b8 params[8];\n"
                       ".visible .entry __raygen__a() {\n.reg .b64 %rd<2>;\n"
                       "ld.const.u64 %rd1, [params];\nst.global.u32 [%rd1], 42;\nret;\n}\n";
    for (unsigned i = 0; i < count; ++i) {
        text += ".visible .entry __miss__m" + std::to_string(i) +
                "() {\n.reg .f32 %f<40>;\n.reg .b64 %rd<2>;\nld.const.u64 %rd1, [params];\n"
                "ld.global.f32 %f1, [%rd1];\n";
        for (unsigned k = 2; k < 20 + i; ++k)
            text += "fma.rn.f32 %f" + std::to_string(k) + ", %f" + std::to_string(k - 1) +
                    ", %f1, %f1;\n";
        text += "st.global.f32 [%rd1], %f" + std::to_string(19 + i) + ";\nret;\n}\n";
    }
    return ptxModule(text + extra);
}

class Tasks : public ApiTest {
protected:
    OptixResult create(const std::string& text, char* log = nullptr, size_t* logSize = nullptr) {
        return optixModuleCreateFromPTXWithTasks(context_, &moduleOptions_, &options_, text.data(),
                                                 text.size(), log, logSize, &module_, &task_);
    }
    OptixModuleCompileState state() {
        OptixModuleCompileState state{};
        EXPECT_OK(optixModuleGetCompilationState(module_, &state));
        return state;
    }
    // Executes one task; adds what it creates to `queue`.
    OptixResult execute(OptixTask task, unsigned most, std::deque<OptixTask>& queue) {
        std::vector<OptixTask> created(most + 1, reinterpret_cast<OptixTask>(7));
        unsigned count = 77;
        OptixResult result = optixTaskExecute(task, created.data(), most, &count);
        EXPECT_LE(count, most);
        EXPECT_EQ(reinterpret_cast<OptixTask>(7), created[most]) << "written beyond the array";
        for (unsigned i = 0; i < count && i < most; ++i)
            queue.push_back(created[i]);
        return result;
    }
    OptixProgramGroup group(OptixResult expected = OPTIX_SUCCESS) {
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
        desc.raygen = {module_, "__raygen__a"};
        OptixProgramGroupOptions options{};
        OptixProgramGroup made = nullptr;
        log_.clear();
        EXPECT_EQ(expected, optixProgramGroupCreate(context_, &desc, 1, &options, nullptr, nullptr,
                                                    &made))
            << log_.all();
        return made;
    }
    void useModule() {
        OptixProgramGroup made = group();
        OptixPipelineLinkOptions link{};
        OptixPipeline pipeline = nullptr;
        ASSERT_OK(optixPipelineCreate(context_, &options_, &link, &made, 1, nullptr, nullptr,
                                      &pipeline));
        Buffer record(OPTIX_SBT_RECORD_HEADER_SIZE), result(4);
        Buffer params(std::vector<CUdeviceptr>{result.address()});
        ASSERT_OK(optixSbtRecordPackHeader(made, record.as<void>()));
        OptixShaderBindingTable table{};
        table.raygenRecord = record.address();
        ASSERT_OK(optixLaunch(pipeline, nullptr, params.address(), 8, &table, 1, 1, 1));
        waitForDevice();
        EXPECT_EQ(42u, *result.as<unsigned>());
    }

    OptixModuleCompileOptions moduleOptions_{};
    OptixPipelineCompileOptions options_ = compileOptions();
    OptixModule module_ = nullptr;
    OptixTask task_ = nullptr;
};

TEST_F(Tasks, OneTaskDoesItAll) {
    for (bool withArray : {false, true}) {
        ASSERT_OK(create(moduleOf(3)));
        EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_NOT_STARTED, state());
        OptixTask more[1] = {nullptr};
        unsigned count = 5;
        ASSERT_OK(optixTaskExecute(task_, withArray ? more : nullptr, withArray ? 0 : 9, &count));
        EXPECT_EQ(0u, count);
        EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
        useModule();
    }
}

TEST_F(Tasks, CountMayBeNullWhereNoneIsCreated) {
    ASSERT_OK(create(moduleOf(1)));
    EXPECT_OK(optixTaskExecute(task_, nullptr, 0, nullptr));
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
}

TEST_F(Tasks, WorkIsSharedOutToAsManyTasksAsAskedFor) {
    for (unsigned most : {1u, 2u, 3u, 100u}) {
        ASSERT_OK(create(moduleOf(5)));
        std::deque<OptixTask> queue;
        ASSERT_OK(execute(task_, most, queue));
        EXPECT_EQ(std::min(most, 6u), queue.size()) << "six programs";
        while (!queue.empty()) {
            EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_STARTED, state());
            OptixTask last = queue.back(); // any order
            queue.pop_back();
            ASSERT_OK(execute(last, most, queue));
        }
        EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
        useModule();
        EXPECT_OK(optixModuleDestroy(module_));
    }
}

TEST_F(Tasks, AnyThread) {
    constexpr unsigned kThreads = 4;
    ASSERT_OK(create(moduleOf(12)));
    std::deque<OptixTask> queue;
    ASSERT_OK(execute(task_, 16, queue));
    std::vector<OptixTask> all(queue.begin(), queue.end());
    std::atomic<size_t> next{0};
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < kThreads; ++t)
        threads.emplace_back([&] {
            for (size_t i; (i = next++) < all.size();) {
                unsigned count = 0;
                OptixTask more[4];
                EXPECT_EQ(OPTIX_SUCCESS, optixTaskExecute(all[i], more, 4, &count));
                EXPECT_EQ(0u, count);
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
    useModule();
}

TEST_F(Tasks, TextIsNotNeededAfterTheCall) {
    std::string text = moduleOf(2);
    ASSERT_OK(create(text));
    std::fill(text.begin(), text.end(), 'x');
    EXPECT_OK(optixTaskExecute(task_, nullptr, 0, nullptr));
    useModule();
}

TEST_F(Tasks, ModulesThatNeedOthersAreNotCompiledAhead) {
    options_.pipelineLaunchParamsVariableName = "params";
    ASSERT_OK(create(moduleOf(2, ".extern .global .align 4 .u32 elsewhere;\n")));
    std::deque<OptixTask> queue;
    ASSERT_OK(execute(task_, 8, queue));
    EXPECT_TRUE(queue.empty());
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
    useModule();
}

TEST_F(Tasks, IncompleteModulesCannotBeUsed) {
    ASSERT_OK(create(moduleOf(2)));
    EXPECT_EQ(nullptr, group(OPTIX_ERROR_INVALID_OPERATION));
    EXPECT_TRUE(log_.hasError("optixProgramGroupCreate", "not completed")) << log_.all();
    std::deque<OptixTask> queue;
    ASSERT_OK(execute(task_, 8, queue));
    ASSERT_FALSE(queue.empty());
    EXPECT_EQ(nullptr, group(OPTIX_ERROR_INVALID_OPERATION));
    EXPECT_OK(optixModuleDestroy(module_)) << "no task runs";
}

TEST_F(Tasks, StateOfAModuleMadeAtOnce) {
    std::string text = moduleOf(1);
    ASSERT_OK(optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, text.data(),
                                       text.size(), nullptr, nullptr, &module_));
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
}

TEST_F(Tasks, FaultyTextFailsTheFirstTask) {
    char text[4096] = "untouched";
    size_t size = sizeof text;
    ASSERT_OK(create(ptxModule(".visible .entry __raygen__a() {\nfrobnicate;\nret;\n}\n"), text,
                     &size));
    EXPECT_STREQ("", text);
    EXPECT_EQ(1u, size);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_PTX, "optixTaskExecute", "frobnicate",
                    optixTaskExecute(task_, nullptr, 0, nullptr));
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_FAILED, state());
    EXPECT_NE(nullptr, std::strstr(text, "line 5")) << text;
    EXPECT_NE(nullptr, std::strstr(text, "frobnicate")) << text;
    EXPECT_EQ(1u, size) << "the size is the caller's own again";
    EXPECT_EQ(nullptr, group(OPTIX_ERROR_INVALID_OPERATION));
    EXPECT_OK(optixModuleDestroy(module_));
}

// Only compilation finds recursion through device functions.
const char* const kFaultyProgram =
    ".func helper() {\n.reg .b32 %r<2>;\n.reg .b64 %rd<2>;\n"
    "call (%r1), _optix_get_launch_index_x, ();\nld.const.u64 %rd1, [params];\n"
    "st.global.u32 [%rd1], %r1;\ncall helper;\nret;\n}\n"
    ".visible .entry __miss__faulty() {\ncall helper;\nret;\n}\n";

TEST_F(Tasks, AFailingTaskAmongOthers) {
    char text[4096] = "";
    size_t size = sizeof text;
    ASSERT_OK(create(moduleOf(3, kFaultyProgram), text, &size));
    std::deque<OptixTask> queue;
    ASSERT_OK(execute(task_, 16, queue));
    ASSERT_EQ(5u, queue.size()) << log_.all();
    unsigned failures = 0;
    bool failed = false;
    while (!queue.empty()) {
        OptixTask task = queue.front();
        queue.pop_front();
        const OptixResult result = execute(task, 16, queue);
        failures += result != OPTIX_SUCCESS;
        failed |= result != OPTIX_SUCCESS;
        const auto expected = queue.empty() ? OPTIX_MODULE_COMPILE_STATE_FAILED
                              : failed      ? OPTIX_MODULE_COMPILE_STATE_IMPENDING_FAILURE
                                            : OPTIX_MODULE_COMPILE_STATE_STARTED;
        EXPECT_EQ(expected, state());
    }
    EXPECT_EQ(1u, failures);
    EXPECT_NE(nullptr, std::strstr(text, "recursive")) << text;
    EXPECT_EQ(nullptr, group(OPTIX_ERROR_INVALID_OPERATION));
}

TEST_F(Tasks, LogIsTruncatedToItsCapacity) {
    char text[64];
    std::memset(text, '#', sizeof text);
    size_t size = 10;
    ASSERT_OK(create(ptxModule("rubbish"), text, &size));
    size = 64; // no longer used by the library
    EXPECT_NE(OPTIX_SUCCESS, optixTaskExecute(task_, nullptr, 0, nullptr));
    EXPECT_EQ(9u, std::strlen(text));
    EXPECT_EQ('#', text[10]);
}

TEST_F(Tasks, EachTaskRunsOnce) {
    char text[256] = "";
    size_t size = sizeof text;
    ASSERT_OK(create(moduleOf(1), text, &size));
    EXPECT_OK(optixTaskExecute(task_, nullptr, 0, nullptr));
    std::memset(text, '#', sizeof text); // the caller's own once the module is completed
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_OPERATION, "optixTaskExecute", "has been executed",
                    optixTaskExecute(task_, nullptr, 0, nullptr));
    EXPECT_EQ('#', text[0]);
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
}

TEST_F(Tasks, Arguments) {
    const char* kCreate = "optixModuleCreateFromPTXWithTasks";
    std::string text = moduleOf(1);
    const auto call = [&](const OptixModuleCompileOptions* moduleOptions,
                          const OptixPipelineCompileOptions* options, const char* ptx,
                          OptixModule* module, OptixTask* task) {
        return optixModuleCreateFromPTXWithTasks(context_, moduleOptions, options, ptx,
                                                 text.size(), nullptr, nullptr, module, task);
    };
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kCreate, "moduleCompileOptions",
                    call(nullptr, &options_, text.data(), &module_, &task_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kCreate, "pipelineCompileOptions",
                    call(&moduleOptions_, nullptr, text.data(), &module_, &task_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kCreate, "PTX",
                    call(&moduleOptions_, &options_, nullptr, &module_, &task_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kCreate, "module",
                    call(&moduleOptions_, &options_, text.data(), nullptr, &task_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kCreate, "firstTask",
                    call(&moduleOptions_, &options_, text.data(), &module_, nullptr));
    EXPECT_EQ(nullptr, module_);
    options_.numPayloadValues = 33;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kCreate, "numPayloadValues",
                    call(&moduleOptions_, &options_, text.data(), &module_, &task_));
    options_.numPayloadValues = 0;
    ASSERT_OK(create(text));
    OptixTask more[2];
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixTaskExecute", "numAdditionalTasksCreated",
                    optixTaskExecute(task_, more, 2, nullptr));
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_NOT_STARTED, state()) << "nothing was done";
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixModuleGetCompilationState", "state",
                    optixModuleGetCompilationState(module_, nullptr));
    for (void* garbage : garbageHandles()) {
        unsigned count = 3;
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
                  optixTaskExecute(static_cast<OptixTask>(garbage), more, 2, &count));
        EXPECT_EQ(0u, count);
        OptixModuleCompileState state{};
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
                  optixModuleGetCompilationState(static_cast<OptixModule>(garbage), &state));
    }
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixTaskExecute(nullptr, more, 2, nullptr));
}

TEST_F(Tasks, TasksGoWithTheirModule) {
    ASSERT_OK(create(moduleOf(4)));
    std::deque<OptixTask> queue;
    ASSERT_OK(execute(task_, 3, queue));
    ASSERT_EQ(3u, queue.size());
    ASSERT_OK(optixModuleDestroy(module_));
    for (OptixTask task : queue)
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixTaskExecute(task, nullptr, 0, nullptr));
    // Others go with their context.
    ASSERT_OK(create(moduleOf(4)));
    ASSERT_OK(optixDeviceContextDestroy(context_));
    context_ = nullptr;
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixTaskExecute(task_, nullptr, 0, nullptr));
}

// The log callback runs inside the task.
TEST_F(Tasks, NoDestroyDuringATask) {
    struct Hook {
        OptixModule module = nullptr;
        OptixResult result = OPTIX_SUCCESS;
        OptixModuleCompileState state{};
    } hook;
    ASSERT_OK(create(moduleOf(2)));
    hook.module = module_;
    const auto callback = [](unsigned, const char* tag, const char*, void* data) {
        auto& h = *static_cast<Hook*>(data);
        if (std::string(tag) != "COMPILER")
            return;
        optixModuleGetCompilationState(h.module, &h.state);
        h.result = optixModuleDestroy(h.module);
    };
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, callback, &hook, 4));
    ASSERT_OK(optixTaskExecute(task_, nullptr, 0, nullptr));
    EXPECT_EQ(OPTIX_ERROR_ILLEGAL_DURING_TASK_EXECUTE, hook.result);
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_STARTED, hook.state);
    ASSERT_OK(optixDeviceContextSetLogCallback(context_, LogRecord::callback, &log_, 4));
    EXPECT_EQ(OPTIX_MODULE_COMPILE_STATE_COMPLETED, state());
    EXPECT_OK(optixModuleDestroy(module_));
}

} // namespace
} // namespace tests::api
