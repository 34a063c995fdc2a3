// SPDX-License-Identifier: Apache-2.0
// Functions that are not available yet: each fails with RT_ERROR_NOT_SUPPORTED and names itself.
#include "api/optix6/call.h"

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

RTresult unsupported(const char* function) {
    return guarded(nullptr, function,
                   [] { refuse(RT_ERROR_NOT_SUPPORTED, "the function is not available yet"); });
}

// The same for functions of a context, which rtContextGetErrorString then explains.
RTresult unsupportedOf(const char* function, RTcontext handle) {
    return callContext(
        function, handle,
        [](Context&) { refuse(RT_ERROR_NOT_SUPPORTED, "the function is not available yet"); },
        RT_ERROR_INVALID_CONTEXT);
}

} // namespace

SUNSTONE_API RTresult rtBufferCreateFromGLBO(RTcontext context, unsigned int, unsigned int,
                                             RTbuffer*) {
    return unsupportedOf(__func__, context);
}
SUNSTONE_API RTresult rtTextureSamplerCreateFromGLImage(RTcontext context, unsigned int, RTgltarget,
                                                        RTtexturesampler*) {
    return unsupportedOf(__func__, context);
}
SUNSTONE_API RTresult rtBufferGetGLBOId(RTbuffer, unsigned int*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtTextureSamplerGetGLImageId(RTtexturesampler, unsigned int*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtBufferGLRegister(RTbuffer) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtBufferGLUnregister(RTbuffer) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtTextureSamplerGLRegister(RTtexturesampler) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtTextureSamplerGLUnregister(RTtexturesampler) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtDeviceGetWGLDevice(int*, void*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtPostProcessingStageCreateBuiltin(RTcontext context, const char*,
                                                         RTpostprocessingstage*) {
    return unsupportedOf(__func__, context);
}
SUNSTONE_API RTresult rtPostProcessingStageDestroy(RTpostprocessingstage) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtPostProcessingStageDeclareVariable(RTpostprocessingstage, const char*,
                                                           RTvariable*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtPostProcessingStageGetContext(RTpostprocessingstage, RTcontext*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtPostProcessingStageQueryVariable(RTpostprocessingstage, const char*,
                                                         RTvariable*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtPostProcessingStageGetVariableCount(RTpostprocessingstage, unsigned int*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtPostProcessingStageGetVariable(RTpostprocessingstage, unsigned int,
                                                       RTvariable*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtCommandListCreate(RTcontext context, RTcommandlist*) {
    return unsupportedOf(__func__, context);
}
SUNSTONE_API RTresult rtCommandListDestroy(RTcommandlist) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtCommandListAppendPostprocessingStage(RTcommandlist, RTpostprocessingstage,
                                                             RTsize, RTsize) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtCommandListAppendLaunch2D(RTcommandlist, unsigned int, RTsize, RTsize) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtCommandListFinalize(RTcommandlist) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtCommandListExecute(RTcommandlist) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtCommandListGetContext(RTcommandlist, RTcontext*) {
    return unsupported(__func__);
}
