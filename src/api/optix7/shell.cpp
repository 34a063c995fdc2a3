// SPDX-License-Identifier: Apache-2.0
// See shell.h.
#include "api/optix7/shell.h"

#include <algorithm>

namespace sunstone::optix7 {

// Never destroyed: clients may call from their own exit handlers.
HandleTable<DeviceContext>& contexts() {
    static auto* table = new HandleTable<DeviceContext>;
    return *table;
}
HandleTable<ModuleObject>& modules() {
    static auto* table = new HandleTable<ModuleObject>;
    return *table;
}
HandleTable<TaskObject>& tasks() {
    static auto* table = new HandleTable<TaskObject>;
    return *table;
}
HandleTable<GroupObject>& groups() {
    static auto* table = new HandleTable<GroupObject>;
    return *table;
}
HandleTable<PipelineObject>& pipelines() {
    static auto* table = new HandleTable<PipelineObject>;
    return *table;
}

namespace {

template <class T>
std::shared_ptr<T> require(HandleTable<T>& table, const void* handle, const char* parameter,
                           const char* kind) {
    if (!handle)
        fail(Code::kInvalidValue, parameter, " is null");
    std::shared_ptr<T> object = table.find(handle);
    if (!object)
        fail(Code::kInvalidValue, parameter, " = ", handle, " is not a live ", kind);
    return object;
}

} // namespace

std::shared_ptr<DeviceContext> contextOf(OptixDeviceContext handle) {
    std::shared_ptr<DeviceContext> context = handle ? contexts().find(handle) : nullptr;
    if (!context)
        fail(Code::kInvalidContext, "context = ", static_cast<const void*>(handle),
             " is not a live device context");
    return context;
}
std::shared_ptr<ModuleObject> moduleOf(OptixModule handle, const char* parameter) {
    return require(modules(), handle, parameter, "module");
}
std::shared_ptr<engine::Module> completedModule(const ModuleObject& object, const char* parameter) {
    std::shared_ptr<engine::Module> module = object.tasks ? object.tasks->module() : object.module;
    if (!module)
        fail(Code::kInvalidOperation, parameter, ": the module's tasks have not completed it");
    return module;
}
std::shared_ptr<GroupObject> groupOf(OptixProgramGroup handle, const char* parameter) {
    return require(groups(), handle, parameter, "program group");
}
std::shared_ptr<PipelineObject> pipelineOf(OptixPipeline handle) {
    return require(pipelines(), handle, "pipeline", "pipeline");
}

void DeviceContext::setCallback(OptixLogCallback function, void* data, unsigned level) {
    std::lock_guard lock(mutex_);
    callback_ = function;
    callbackData_ = data;
    level_ = level;
}

void DeviceContext::log(LogLevel level, std::string_view tag, std::string_view text) {
    sunstone::log(level, "optix7", text);
    if (unsigned(level) > level_)
        return;
    OptixLogCallback function;
    void* data;
    {
        std::lock_guard lock(mutex_);
        function = callback_;
        data = callbackData_;
    }
    if (function)
        function(unsigned(level), std::string(tag).c_str(), std::string(text).c_str(), data);
}

void DeviceContext::logQueued(LogLevel level, std::string_view tag, std::string_view text) {
    const auto isHeard = [&] {
        std::lock_guard lock(mutex_);
        return callback_ && unsigned(level) <= level_;
    };
    if (level > LogLevel::kError || logEnabled(level, "optix7") || isHeard() ||
        hasPrinted_.exchange(true))
        return log(level, tag, text);
    sunstone::log(LogLevel::kFatal, "optix7",
                  message(tag, ": ", text,
                          " (later errors of this device context: with a log callback, or "
                          "SUNSTONE_LOG=error)"));
}

bool CompileOptions::operator==(const CompileOptions& other) const {
    const OptixPipelineCompileOptions &a = values, &b = other.values;
    return a.usesMotionBlur == b.usesMotionBlur &&
           a.traversableGraphFlags == b.traversableGraphFlags &&
           a.numPayloadValues == b.numPayloadValues &&
           a.numAttributeValues == b.numAttributeValues && a.exceptionFlags == b.exceptionFlags &&
           a.usesPrimitiveTypeFlags == b.usesPrimitiveTypeFlags &&
           a.allowOpacityMicromaps == b.allowOpacityMicromaps &&
           launchParams == other.launchParams;
}

compiler::PipelineRules CompileOptions::rules() const {
    compiler::PipelineRules rules;
    rules.launchParams = launchParams;
    rules.optix7.numPayloadValues = unsigned(values.numPayloadValues);
    rules.optix7.numAttributeValues = unsigned(values.numAttributeValues);
    rules.exceptionFlags = values.exceptionFlags;
    rules.primitiveTypeFlags = values.usesPrimitiveTypeFlags;
    rules.traversableGraphFlags = values.traversableGraphFlags;
    rules.motionBlur = values.usesMotionBlur != 0;
    return rules;
}

compiler::PipelineRules DeviceContext::rulesOf(const CompileOptions& options) const {
    compiler::PipelineRules rules = options.rules();
    if (engine->validation)
        rules.exceptionFlags |= OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW |
                                OPTIX_EXCEPTION_FLAG_TRACE_DEPTH | OPTIX_EXCEPTION_FLAG_DEBUG;
    return rules;
}

OptixResult guarded(const std::shared_ptr<DeviceContext>& context, const char* function,
                    const std::function<void()>& body, std::string* feedback) {
    OptixResult result = OPTIX_SUCCESS;
    std::string cause;
    try {
        body();
        return OPTIX_SUCCESS;
    } catch (const ResultError& error) {
        result = error.result;
        cause = error.what();
    } catch (const Error& error) {
        result = resultOf(error.code());
        cause = error.what();
    } catch (const std::bad_alloc&) {
        result = OPTIX_ERROR_HOST_OUT_OF_MEMORY;
        cause = "out of host memory";
    } catch (const std::exception& error) {
        result = OPTIX_ERROR_INTERNAL_ERROR;
        cause = error.what();
    }
    // Inner newlines of a message stay (diagnostics); only the last one is removed.
    while (!cause.empty() && cause.back() == '\n')
        cause.pop_back();
    std::string line = message(function, ": ", cause, " [",
                               resultName(result, context ? context->abi : kNewestAbi), "]");
    if (context)
        context->log(LogLevel::kError, "ERROR", line);
    else
        sunstone::log(LogLevel::kError, "optix7", line);
    if (feedback)
        *feedback += line;
    return result;
}

void writeLogString(const std::string& text, char* logString, size_t* logStringSize) {
    if (!logStringSize)
        return;
    size_t capacity = *logStringSize;
    *logStringSize = text.size() + 1;
    if (!logString || capacity == 0)
        return;
    size_t length = std::min(text.size(), capacity - 1);
    std::memcpy(logString, text.data(), length);
    logString[length] = 0;
}

} // namespace sunstone::optix7
