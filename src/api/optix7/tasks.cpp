// SPDX-License-Identifier: Apache-2.0
// Modules made by tasks (OptiX 7.4, sections 3.6.2.3, 3.6.2.5 and 3.7).
#include "api/optix7/entry_points.h"
#include "api/optix7/options.h"

#include <cstring>

namespace sunstone::optix7 {
namespace {

using engine::TaskState;

OptixModuleCompileState stateOf(const ModuleObject& module) {
    if (!module.tasks)
        return OPTIX_MODULE_COMPILE_STATE_COMPLETED;
    switch (module.tasks->state()) {
    case TaskState::kNotStarted: return OPTIX_MODULE_COMPILE_STATE_NOT_STARTED;
    case TaskState::kStarted: return OPTIX_MODULE_COMPILE_STATE_STARTED;
    case TaskState::kImpendingFailure: return OPTIX_MODULE_COMPILE_STATE_IMPENDING_FAILURE;
    case TaskState::kFailed: return OPTIX_MODULE_COMPILE_STATE_FAILED;
    case TaskState::kCompleted: break;
    }
    return OPTIX_MODULE_COMPILE_STATE_COMPLETED;
}

OptixTask addTask(const std::shared_ptr<ModuleObject>& module, size_t number) {
    auto task = std::make_shared<TaskObject>();
    task->context = module->context;
    task->module = module;
    task->number = number;
    return static_cast<OptixTask>(tasks().add(std::move(task)));
}

// Writes the messages of all finished tasks, within the capacity given at the module's creation.
// The size variable of the creating call is no longer used.
void writeTaskLog(ModuleObject& module) {
    std::lock_guard lock(module.logMutex);
    size_t capacity = module.logCapacity;
    writeLogString(module.tasks->feedback(), module.logString, &capacity);
}

} // namespace

OptixResult moduleCreateFromPTXWithTasks(OptixDeviceContext context,
                                         const OptixModuleCompileOptions* moduleOptions,
                                         const OptixPipelineCompileOptions* pipelineOptions,
                                         const char* ptx, size_t ptxSize, char* logString,
                                         size_t* logStringSize, OptixModule* module,
                                         OptixTask* firstTask) {
    std::string feedback;
    std::shared_ptr<DeviceContext> owner = peek(context);
    const size_t capacity = logStringSize ? *logStringSize : 0;
    OptixResult result = guarded(
        owner, "optixModuleCreateFromPTXWithTasks",
        [&] {
            contextOf(context);
            requireNonNull(module, "module");
            *module = nullptr;
            requireNonNull(firstTask, "firstTask");
            *firstTask = nullptr;
            ModuleInput input = checkModuleInput({*owner, "optixModuleCreateFromPTXWithTasks"},
                                                 moduleOptions, pipelineOptions, ptx);
            auto object = std::make_shared<ModuleObject>();
            object->context = owner;
            object->options = input.options;
            object->logString = logStringSize ? logString : nullptr;
            object->logCapacity = capacity;
            // Copied: the client may change the text after this call.
            std::string text(ptx, strnlen(ptx, ptxSize));
            object->tasks = std::make_shared<engine::ModuleTasks>(
                [owner, input = std::move(input), text = std::move(text)](std::string& notes) {
                    return makeModule(owner, input, text, notes);
                });
            *firstTask = addTask(object, engine::ModuleTasks::kFirst);
            *module = static_cast<OptixModule>(modules().add(std::move(object)));
        },
        &feedback);
    writeLogString(feedback, logString, logStringSize);
    return result;
}

OptixResult moduleGetCompilationState(OptixModule module, OptixModuleCompileState* state) {
    std::shared_ptr<ModuleObject> object = modules().find(module);
    return guarded(object ? object->context : nullptr, "optixModuleGetCompilationState", [&] {
        moduleOf(module, "module");
        requireNonNull(state, "state");
        *state = stateOf(*object);
    });
}

OptixResult taskExecute(OptixTask task, OptixTask* additionalTasks, unsigned maxAdditionalTasks,
                        unsigned* numAdditionalTasksCreated) {
    std::shared_ptr<TaskObject> object = tasks().find(task);
    std::shared_ptr<ModuleObject> module = object ? object->module.lock() : nullptr;
    const std::shared_ptr<DeviceContext> owner = object ? object->context : nullptr;
    const unsigned most = additionalTasks ? maxAdditionalTasks : 0;
    if (numAdditionalTasksCreated)
        *numAdditionalTasksCreated = 0;
    OptixResult result = guarded(owner, "optixTaskExecute", [&] {
        if (!task)
            fail(Code::kInvalidValue, "task is null");
        if (!module)
            fail(Code::kInvalidValue, "task = ", static_cast<const void*>(task),
                 " is not a task of a live module");
        if (most != 0)
            requireNonNull(numAdditionalTasksCreated, "numAdditionalTasksCreated");
        module->tasks->start(object->number);
    });
    if (result != OPTIX_SUCCESS)
        return result;
    std::string feedback;
    result = guarded(owner, "optixTaskExecute", [&] {
        const std::vector<size_t> created = module->tasks->run(object->number, most);
        for (size_t i = 0; i < created.size(); ++i)
            additionalTasks[i] = addTask(module, created[i]);
        if (numAdditionalTasksCreated)
            *numAdditionalTasksCreated = unsigned(created.size());
    }, &feedback);
    if (!feedback.empty())
        module->tasks->addError(feedback + "\n");
    writeTaskLog(*module); // before the module counts as done, when the client may free the string
    module->tasks->finish(object->number, result == OPTIX_SUCCESS);
    return result;
}

} // namespace sunstone::optix7
