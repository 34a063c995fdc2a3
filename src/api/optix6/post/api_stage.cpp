// SPDX-License-Identifier: Apache-2.0
// Entry points of post-processing stages (section 5.19).
#include "api/optix6/call.h"
#include "api/optix6/post/stage.h"

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

template <class Body>
RTresult callStage(const char* function, RTpostprocessingstage stage, const Body& body) {
    return call<PostProcessingStage>(function, stage, "stage", body);
}

} // namespace

SUNSTONE_API RTresult rtPostProcessingStageCreateBuiltin(RTcontext handle, const char* name,
                                                         RTpostprocessingstage* stage) {
    return callContext(
        __func__, handle,
        [&](Context& context) {
            requireNonNull(stage, "stage");
            *stage = nullptr;
            requireNonNull(name, "builtinName");
            const std::optional<StageKind> kind = PostProcessingStage::kindOf(name);
            if (!kind)
                refuse(RT_ERROR_INVALID_VALUE, "builtinName = \"", name,
                       "\" is none of the stages ", PostProcessingStage::knownNames());
            const auto made = std::make_shared<PostProcessingStage>(context.self(), *kind);
            for (const std::shared_ptr<Variable>& variable : made->scope.list())
                objects().add(variable);
            *stage = static_cast<RTpostprocessingstage>(objects().add(made));
        },
        RT_ERROR_INVALID_CONTEXT);
}

// Command lists with the stage find it destroyed.
SUNSTONE_API RTresult rtPostProcessingStageDestroy(RTpostprocessingstage stage) {
    return callStage(__func__, stage, [&](PostProcessingStage& object) { removeObject(object); });
}

SUNSTONE_API RTresult rtPostProcessingStageGetContext(RTpostprocessingstage stage,
                                                      RTcontext* context) {
    return getContext<PostProcessingStage>(__func__, stage, "stage", context);
}

SUNSTONE_API RTresult rtPostProcessingStageDeclareVariable(RTpostprocessingstage stage,
                                                           const char* name, RTvariable* v) {
    if (v)
        *v = nullptr;
    return callStage(__func__, stage, [&](PostProcessingStage& object) {
        requireNonNull(v, "v");
        requireNonNull(name, "name");
        *v = static_cast<RTvariable>(object.declare(name)->handle());
    });
}

SUNSTONE_API RTresult rtPostProcessingStageQueryVariable(RTpostprocessingstage stage,
                                                         const char* name, RTvariable* variable) {
    return callStage(__func__, stage, [&](PostProcessingStage& object) {
        requireNonNull(variable, "variable");
        *variable = nullptr;
        requireNonNull(name, "name");
        if (const std::shared_ptr<Variable> found = object.scope.find(name))
            *variable = static_cast<RTvariable>(found->handle());
    });
}

SUNSTONE_API RTresult rtPostProcessingStageGetVariableCount(RTpostprocessingstage stage,
                                                            unsigned* count) {
    return callStage(__func__, stage, [&](PostProcessingStage& object) {
        store(count, "count", unsigned(object.scope.list().size()));
    });
}

SUNSTONE_API RTresult rtPostProcessingStageGetVariable(RTpostprocessingstage stage, unsigned index,
                                                       RTvariable* variable) {
    return callStage(__func__, stage, [&](PostProcessingStage& object) {
        requireNonNull(variable, "variable");
        *variable = nullptr;
        const auto& list = object.scope.list();
        if (index >= list.size())
            refuse(RT_ERROR_INVALID_VALUE, "index = ", index, " of ", list.size(), " variables");
        *variable = static_cast<RTvariable>(list[index]->handle());
    });
}
