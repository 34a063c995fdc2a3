// SPDX-License-Identifier: Apache-2.0
// Stream functions other than copies and launches: queries, events, callbacks. Compiled twice, see
// shell.h.
#include "api/cuda/driver/shell.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

// Adds an event node to the stream's capture.
void captureEvent(const cpu::StreamPtr& stream, cpu::WorkKind kind,
                  const std::shared_ptr<cpu::Event>& event) {
    cpu::streams().submit(stream, nullptr, {}, {kind, nullptr});
    std::lock_guard lock(cpu::graphMutex());
    cpu::streams().captureState(stream).tips.at(0)->event = event;
}

CUresult recordEvent(const char* function, CUevent event, CUstream stream, unsigned flags) {
    return guarded(function, {Needs::kQueue, stream}, [&] {
        require(flags <= CU_EVENT_RECORD_EXTERNAL, "unknown flags");
        std::shared_ptr<cpu::Event> found = eventOf(event);
        cpu::StreamPtr target = resolveStream(stream);
        if (flags & CU_EVENT_RECORD_EXTERNAL && cpu::streams().isCapturing(target))
            captureEvent(target, cpu::WorkKind::kRecordEvent, found);
        else
            found->record(target);
    });
}

void waitForEvent(const cpu::StreamPtr& stream, const std::shared_ptr<cpu::Event>& event,
                  unsigned flags) {
    const bool captures = cpu::streams().isCapturing(stream);
    if (captures && (flags & CU_EVENT_WAIT_EXTERNAL))
        return captureEvent(stream, cpu::WorkKind::kWaitEvent, event);
    if (const cpu::CapturedMark captured = event->capturedMark(); captured.capture)
        return cpu::streams().waitForCaptured(stream, captured);
    cpu::CompletionPtr mark = event->mark();
    if (!mark)
        return;
    if (captures) {
        cpu::streams().captureState(stream).capture->invalidated = true;
        throw cpu::CaptureError(cpu::CaptureError::kIsolation,
                                "the event was recorded outside of the stream's capture");
    }
    cpu::streams().submit(stream, nullptr, {mark});
}

} // namespace

SUNSTONE_EXPORT CUresult cuStreamGetPriority(CUstream stream, int* priority) {
    return guarded("cuStreamGetPriority", {Needs::kContext, stream}, [&] {
        require(priority, "priority is null");
        *priority = resolveStream(stream)->priority();
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetFlags(CUstream stream, unsigned int* flags) {
    return guarded("cuStreamGetFlags", {Needs::kContext, stream}, [&] {
        require(flags, "flags is null");
        *flags = resolveStream(stream)->flags();
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetId(CUstream stream, unsigned long long* id) {
    return guarded("cuStreamGetId", {Needs::kContext, stream}, [&] {
        require(id, "id is null");
        *id = resolveStream(stream)->id();
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetCtx(CUstream stream, CUcontext* context) {
    return guarded("cuStreamGetCtx", {Needs::kContext, stream}, [&] {
        require(context, "context is null");
        const void* owner = resolveStream(stream)->owner();
        if (uintptr_t(stream) <= 2)
            owner = cpu::contexts().current();
        *context = static_cast<CUcontext>(const_cast<void*>(owner));
    });
}
#ifdef CUDA_API_PER_THREAD_DEFAULT_STREAM
#define cuStreamGetCtx_v2 cuStreamGetCtx_v2_ptsz
#endif
// Streams here belong to ordinary contexts only, never to green ones.
SUNSTONE_EXPORT CUresult cuStreamGetCtx_v2(CUstream stream, CUcontext* context, void** green) {
    const CUresult result = cuStreamGetCtx(stream, context);
    if (result == CUDA_SUCCESS && green)
        *green = nullptr;
    return result;
}
SUNSTONE_EXPORT CUresult cuStreamGetDevice(CUstream stream, CUdevice* device) {
    return guarded("cuStreamGetDevice", {Needs::kContext, stream}, [&] {
        require(device, "device is null");
        resolveStream(stream);
        *device = 0;
    });
}
SUNSTONE_EXPORT CUresult cuStreamWaitEvent(CUstream stream, CUevent event, unsigned int flags) {
    return guarded("cuStreamWaitEvent", {Needs::kQueue, stream}, [&] {
        require(flags <= CU_EVENT_WAIT_EXTERNAL, "unknown flags");
        waitForEvent(resolveStream(stream), eventOf(event), flags);
    });
}
SUNSTONE_EXPORT CUresult cuStreamAddCallback(CUstream stream, CUstreamCallback callback,
                                             void* userData, unsigned int flags) {
    return guarded("cuStreamAddCallback", {Needs::kQueue, stream}, [&] {
        require(callback && flags == 0, "callback is null or flags not 0");
        cpu::StreamPtr target = resolveStream(stream);
        if (cpu::streams().isCapturing(target))
            throw cpu::CaptureError(cpu::CaptureError::kUnsupported,
                                    "callbacks cannot be captured, host functions can");
        cpu::streams().submit(target, [=] { callback(stream, CUDA_SUCCESS, userData); });
    });
}
SUNSTONE_EXPORT CUresult cuLaunchHostFunc(CUstream stream, CUhostFn function, void* userData) {
    return guarded("cuLaunchHostFunc", {Needs::kQueue, stream}, [&] {
        require(function, "function is null");
        auto details = std::make_shared<CUDA_HOST_NODE_PARAMS>();
        details->fn = function;
        details->userData = userData;
        cpu::streams().submit(resolveStream(stream), [=] { function(userData); }, {},
                              {cpu::WorkKind::kHost, details});
    });
}
SUNSTONE_EXPORT CUresult cuStreamQuery(CUstream stream) {
    return guarded("cuStreamQuery", {Needs::kContext, stream}, [&] {
        cpu::StreamPtr target = resolveStream(stream);
        if (!cpu::streams().idle(target))
            return CUDA_ERROR_NOT_READY;
        cpu::streams().throwError(target);
        return CUDA_SUCCESS;
    });
}
SUNSTONE_EXPORT CUresult cuStreamSynchronize(CUstream stream) {
    return guarded("cuStreamSynchronize", {Needs::kContext, stream},
                   [&] { cpu::streams().synchronize(resolveStream(stream)); });
}
SUNSTONE_EXPORT CUresult cuStreamAttachMemAsync(CUstream stream, CUdeviceptr address, size_t length,
                                                unsigned int flags) {
    return guarded("cuStreamAttachMemAsync", {Needs::kQueue, stream}, [&] {
        require(flags == CU_MEM_ATTACH_GLOBAL || flags == CU_MEM_ATTACH_HOST ||
                    flags == CU_MEM_ATTACH_SINGLE,
                "unknown flags");
        auto memory = cpu::memory().find(reinterpret_cast<void*>(address));
        require(memory && cpu::isManaged(memory->kind) &&
                    (length == 0 || length == memory->size),
                "not managed memory as a whole");
        resolveStream(stream); // attachment has no effect: host and device share memory
    });
}
SUNSTONE_EXPORT CUresult cuEventRecord(CUevent event, CUstream stream) {
    return recordEvent("cuEventRecord", event, stream, 0);
}
SUNSTONE_EXPORT CUresult cuEventRecordWithFlags(CUevent event, CUstream stream,
                                                unsigned int flags) {
    return recordEvent("cuEventRecordWithFlags", event, stream, flags);
}
