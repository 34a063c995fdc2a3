// SPDX-License-Identifier: Apache-2.0
// Shared by all files of the OptiX 7 shell: the objects behind the opaque handles, the translation
// of engine errors into OptixResult, and the rule for log strings. The shell checks arguments,
// translates types and forwards to src/engine; it computes nothing itself. Source: OptiX 7.4 API
// reference, section named at each function; abi.h and client_structs.h have the differences of
// other releases.
#pragma once

#include "api/optix7/abi.h"
#include "base/error.h"
#include "base/handles.h"
#include "engine/context.h"
#include "engine/module_tasks.h"
#include "engine/pipeline.h"

#include "optix.h"

#include <atomic>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace sunstone::optix7 {

struct CompileOptions;

struct DeviceContext {
    std::shared_ptr<engine::Context> engine;
    void* cudaContext = nullptr;
    Abi abi = kNewestAbi; // of the client that created it

    // Passes a line to the callback, if its level permits, and to the engine's own log.
    void log(LogLevel level, std::string_view tag, std::string_view text);
    // The same for lines of queued work. No call returns errors of queued work with their cause, so
    // the first one goes to stderr if no callback receives it.
    void logQueued(LogLevel level, std::string_view tag, std::string_view text);
    // The rules for the options; validation mode adds all exceptions of the library.
    compiler::PipelineRules rulesOf(const CompileOptions& options) const;
    void setCallback(OptixLogCallback function, void* data, unsigned level);

private:
    std::mutex mutex_;
    OptixLogCallback callback_ = nullptr;
    void* callbackData_ = nullptr;
    std::atomic<unsigned> level_{0};
    std::atomic<bool> hasPrinted_{false}; // an error of queued work, on stderr
};

// Pipeline compile options in a form that can be stored and compared.
struct CompileOptions {
    OptixPipelineCompileOptions values{}; // name pointer cleared
    std::string launchParams;
    bool operator==(const CompileOptions& other) const;
    compiler::PipelineRules rules() const;
};

struct ModuleObject {
    std::shared_ptr<DeviceContext> context;
    // Null if built in, and while tasks make the module: see completedModule.
    std::shared_ptr<engine::Module> module;
    uint32_t builtinPrimitive = 0; // OptixPrimitiveType of a built-in module
    CompileOptions options;
    std::shared_ptr<engine::ModuleTasks> tasks; // null for a module made without tasks
    // Tasks write here; the client keeps the memory alive until they are done.
    char* logString = nullptr;
    size_t logCapacity = 0;
    std::mutex logMutex;
    std::atomic<unsigned> groups{0}; // program groups made from it
};

struct TaskObject {
    std::shared_ptr<DeviceContext> context;
    std::weak_ptr<ModuleObject> module;
    size_t number = 0; // index in the module's tasks
};

struct GroupObject {
    std::shared_ptr<DeviceContext> context;
    std::shared_ptr<engine::ProgramGroup> group;
    std::vector<std::shared_ptr<ModuleObject>> modules;
    std::once_flag stackSizesKnown;
    OptixStackSizes stackSizes{}; // valid after the first query
};

struct PipelineObject {
    std::shared_ptr<DeviceContext> context;
    std::shared_ptr<engine::Pipeline> pipeline;
};

HandleTable<DeviceContext>& contexts();
HandleTable<ModuleObject>& modules();
HandleTable<TaskObject>& tasks();
HandleTable<GroupObject>& groups();
HandleTable<PipelineObject>& pipelines();

// The live object of a handle; throws an Error naming the parameter for other handles.
std::shared_ptr<DeviceContext> contextOf(OptixDeviceContext handle);
std::shared_ptr<ModuleObject> moduleOf(OptixModule handle, const char* parameter);
// The engine's module; throws kInvalidOperation if tasks have not completed it.
std::shared_ptr<engine::Module> completedModule(const ModuleObject& object, const char* parameter);
std::shared_ptr<GroupObject> groupOf(OptixProgramGroup handle, const char* parameter);
std::shared_ptr<PipelineObject> pipelineOf(OptixPipeline handle);

OptixResult resultOf(Code code);
// Name and text of a code; null for codes that the ABI lacks.
const char* resultName(OptixResult result, Abi abi);
const char* resultString(OptixResult result, Abi abi);

// An OptixResult without an engine code.
struct ResultError : std::runtime_error {
    ResultError(OptixResult r, const std::string& text) : std::runtime_error(text), result(r) {}
    OptixResult result;
};

// Runs body; turns its exceptions into a result and a line "function: cause" in the log of
// `context` (null: the engine's log). `feedback`, if given, also receives the line's text.
OptixResult guarded(const std::shared_ptr<DeviceContext>& context, const char* function,
                    const std::function<void()>& body, std::string* feedback = nullptr);

// Finds the context of a handle, for use outside guards; null if it is not alive.
inline std::shared_ptr<DeviceContext> peek(OptixDeviceContext handle) {
    return contexts().find(handle);
}

// The data of a call that checks of its arguments need.
struct ApiCall {
    DeviceContext& context;
    const char* function;
};

// See engine::tolerate.
template <class... Parts>
void tolerate(const ApiCall& call, const char* consequence, const Parts&... parts) {
    engine::tolerate(*call.context.engine, call.function, message(parts...), consequence);
}

// Throws kInvalidValue "NAME is null".
template <class T>
void requireNonNull(const T* pointer, const char* name) {
    if (!pointer)
        fail(Code::kInvalidValue, name, " is null");
}

// The logString rule of module, program group and pipeline creation: writes `text`, truncated to
// the capacity in *size and always terminated; *size becomes the full length with terminator, in
// bytes.
void writeLogString(const std::string& text, char* logString, size_t* logStringSize);

} // namespace sunstone::optix7
