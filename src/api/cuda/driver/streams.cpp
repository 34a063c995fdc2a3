// SPDX-License-Identifier: Apache-2.0
// Streams and events: create, destroy, query.
#include "api/cuda/driver/shell.h"

#include "base/handles.h"
#include "device/device.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

HandleTable<cpu::Event>& events() {
    static HandleTable<cpu::Event>* table = [] {
        cpu::contexts().onDestroy([](cpu::Context* context) {
            events().removeIf([&](const cpu::Event& event) { return event.owner() == context; });
        });
        return new HandleTable<cpu::Event>;
    }();
    return *table;
}

CUresult createStream(const char* function, CUstream* stream, unsigned flags, int priority) {
    return guarded(function, Needs::kContext, [&] {
        require(stream, "stream is null");
        require(flags <= CU_STREAM_NON_BLOCKING, "unknown flags");
        // Clamps priorities to the valid range.
        priority = std::min(std::max(priority, cpu::Streams::kGreatestPriority),
                            cpu::Streams::kLeastPriority);
        *stream = static_cast<CUstream>(
            cpu::streams().create(flags, priority, cpu::contexts().current()));
    });
}

// Throws if device code has failed in the event's context, which may differ from the current one.
void refuseFault(const cpu::Event& event) {
    const cpu::ContextPtr context = cpu::contexts().find(event.owner());
    if (const int fault = context ? context->fault.load() : 0)
        throw device::ContextFault(fault, "device code has failed in the event's context: " +
                                              context->faultText());
}

} // namespace

namespace sunstone::api::cuda {

std::shared_ptr<cpu::Event> eventOf(CUevent event) {
    std::shared_ptr<cpu::Event> found = events().find(event);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(event), " is not a live event");
    return found;
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuStreamCreate(CUstream* stream, unsigned int flags) {
    return createStream("cuStreamCreate", stream, flags, 0);
}
SUNSTONE_EXPORT CUresult cuStreamCreateWithPriority(CUstream* stream, unsigned int flags,
                                                    int priority) {
    return createStream("cuStreamCreateWithPriority", stream, flags, priority);
}
SUNSTONE_EXPORT CUresult cuStreamDestroy(CUstream stream) {
    return guarded("cuStreamDestroy", Needs::kInit, [&] {
        if (cpu::streams().isDefault(stream) || !cpu::streams().destroy(stream))
            refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(stream),
                   " is not a live stream made by cuStreamCreate");
    });
}

SUNSTONE_EXPORT CUresult cuEventCreate(CUevent* event, unsigned int flags) {
    return guarded("cuEventCreate", Needs::kContext, [&] {
        require(event, "event is null");
        require((flags & ~7u) == 0, "unknown flags");
        if (flags & CU_EVENT_INTERPROCESS) {
            require(flags & CU_EVENT_DISABLE_TIMING, "interprocess events cannot be timed");
            refuse(CUDA_ERROR_NOT_SUPPORTED, "events shared between processes");
        }
        *event = static_cast<CUevent>(
            events().add(std::make_shared<cpu::Event>(flags, cpu::contexts().current())));
    });
}
SUNSTONE_EXPORT CUresult cuEventDestroy(CUevent event) {
    return guarded("cuEventDestroy", Needs::kInit, [&] {
        if (!events().remove(event))
            refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(event), " is not a live event");
    });
}
SUNSTONE_EXPORT CUresult cuEventQuery(CUevent event) {
    return guarded("cuEventQuery", Needs::kInit, [&] {
        const std::shared_ptr<cpu::Event> found = eventOf(event);
        const cpu::CompletionPtr mark = found->mark();
        if (mark && !mark->done())
            return CUDA_ERROR_NOT_READY;
        refuseFault(*found);
        return CUDA_SUCCESS;
    });
}
SUNSTONE_EXPORT CUresult cuEventSynchronize(CUevent event) {
    return guarded("cuEventSynchronize", Needs::kInit, [&] {
        const std::shared_ptr<cpu::Event> found = eventOf(event);
        if (const cpu::CompletionPtr mark = found->mark())
            mark->await();
        refuseFault(*found);
    });
}
SUNSTONE_EXPORT CUresult cuEventElapsedTime(float* milliseconds, CUevent start, CUevent end) {
    return guarded("cuEventElapsedTime", Needs::kInit, [&] {
        require(milliseconds, "milliseconds is null");
        const auto first = eventOf(start), last = eventOf(end);
        const cpu::CompletionPtr a = first->mark(), b = last->mark();
        if (!first->timed() || !last->timed() || !a || !b)
            refuse(CUDA_ERROR_INVALID_HANDLE, "an event is not timed or was not recorded");
        if (!a->done() || !b->done())
            return CUDA_ERROR_NOT_READY;
        *milliseconds = std::chrono::duration<float, std::milli>(b->time() - a->time()).count();
        return CUDA_SUCCESS;
    });
}
