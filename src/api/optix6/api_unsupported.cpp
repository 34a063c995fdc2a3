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

SUNSTONE_API RTresult rtContextGetRunningState(RTcontext context, int*) {
    return unsupportedOf(__func__, context);
}
SUNSTONE_API RTresult rtContextLaunchProgressive2D(RTcontext context, unsigned int, RTsize, RTsize,
                                                   unsigned int) {
    return unsupportedOf(__func__, context);
}
SUNSTONE_API RTresult rtBufferGetProgressiveUpdateReady(RTbuffer, int*, unsigned int*,
                                                        unsigned int*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtBufferBindProgressiveStream(RTbuffer, RTbuffer) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtBufferSetAttribute(RTbuffer, RTbufferattribute, RTsize, const void*) {
    return unsupported(__func__);
}
SUNSTONE_API RTresult rtBufferGetAttribute(RTbuffer, RTbufferattribute, RTsize, void*) {
    return unsupported(__func__);
}
