// SPDX-License-Identifier: Apache-2.0
#include "engine/micromap.h"

#include "base/error.h"
#include "engine/cpu/backend.h"

namespace sunstone::engine {

void cpu::buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request) {
    void* const stream = request.stream;
    enqueueLogged(context, stream, "MICROMAP", [context, request = std::move(request)] {
        const bvh::MicromapArrayInput input{request.histogram, request.states,
                                            request.descriptions, request.descriptionStride};
        const uint64_t bytes = bvh::checkMicromaps(input);
        if (bytes && !context->device->isAccessible(request.states, bytes))
            fail(Code::kInvalidValue, "inputBuffer = ", request.states, " with ", bytes,
                 " bytes, as far as the descriptions lead, is not device memory");
        bvh::buildMicromapArray(input, request.output, request.outputSize);
    });
}

bvh::RelocationInfo cpu::micromapRelocationInfo(const ContextPtr& context, const void* array) {
    context->device->synchronizeAll();
    if (!context->device->isAccessible(array, sizeof(bvh::MicromapArrayHeader)) ||
        !bvh::isMicromapArray(array))
        fail(Code::kInvalidValue, "opacityMicromapArray = ", array, " is no opacity micromap array");
    return bvh::micromapRelocationInfo(array);
}

void cpu::relocateMicromapArray(const ContextPtr& context, void* stream,
                                const bvh::RelocationInfo& info, void* array) {
    enqueueLogged(context, stream, "MICROMAP",
                  [info, array] { bvh::relocateMicromapArray(info, array); });
}

void buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request) {
    context->backend->buildMicromapArray(context, std::move(request));
}

bvh::RelocationInfo micromapRelocationInfo(const ContextPtr& context, const void* array) {
    return context->backend->micromapRelocationInfo(context, array);
}

void relocateMicromapArray(const ContextPtr& context, void* stream, const bvh::RelocationInfo& info,
                           void* array) {
    context->backend->relocateMicromapArray(context, stream, info, array);
}

} // namespace sunstone::engine
