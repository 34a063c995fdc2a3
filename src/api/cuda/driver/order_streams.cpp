// SPDX-License-Identifier: Apache-2.0
// What is asked of and queued on a given stream besides copies and launches. Compiled twice, see
// shell.h.
#include "api/cuda/driver/shell.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

CUresult recordEvent(const char* function, CUevent event, CUstream stream) {
    return guarded(function, Needs::kContext, [&] {
        std::shared_ptr<cpu::Event> found = eventOf(event);
        found->record(resolveStream(stream));
    });
}

} // namespace

SUNSTONE_EXPORT CUresult cuStreamGetPriority(CUstream stream, int* priority) {
    return guarded("cuStreamGetPriority", Needs::kContext, [&] {
        require(priority, "priority is null");
        *priority = resolveStream(stream)->priority();
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetFlags(CUstream stream, unsigned int* flags) {
    return guarded("cuStreamGetFlags", Needs::kContext, [&] {
        require(flags, "flags is null");
        *flags = resolveStream(stream)->flags();
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetId(CUstream stream, unsigned long long* id) {
    return guarded("cuStreamGetId", Needs::kContext, [&] {
        require(id, "id is null");
        *id = resolveStream(stream)->id();
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetCtx(CUstream stream, CUcontext* context) {
    return guarded("cuStreamGetCtx", Needs::kContext, [&] {
        require(context, "context is null");
        const void* owner = resolveStream(stream)->owner();
        if (uintptr_t(stream) <= 2)
            owner = cpu::contexts().current();
        *context = static_cast<CUcontext>(const_cast<void*>(owner));
    });
}
SUNSTONE_EXPORT CUresult cuStreamWaitEvent(CUstream stream, CUevent event, unsigned int flags) {
    return guarded("cuStreamWaitEvent", Needs::kContext, [&] {
        require(flags <= CU_EVENT_WAIT_EXTERNAL, "unknown flags");
        cpu::StreamPtr target = resolveStream(stream);
        if (cpu::CompletionPtr mark = eventOf(event)->mark())
            cpu::streams().submit(target, nullptr, {mark});
    });
}
SUNSTONE_EXPORT CUresult cuStreamAddCallback(CUstream stream, CUstreamCallback callback,
                                             void* userData, unsigned int flags) {
    return guarded("cuStreamAddCallback", Needs::kContext, [&] {
        require(callback && flags == 0, "callback is null or flags not 0");
        cpu::streams().submit(resolveStream(stream),
                              [=] { callback(stream, CUDA_SUCCESS, userData); });
    });
}
SUNSTONE_EXPORT CUresult cuLaunchHostFunc(CUstream stream, CUhostFn function, void* userData) {
    return guarded("cuLaunchHostFunc", Needs::kContext, [&] {
        require(function, "function is null");
        cpu::streams().submit(resolveStream(stream), [=] { function(userData); });
    });
}
SUNSTONE_EXPORT CUresult cuStreamQuery(CUstream stream) {
    return guarded("cuStreamQuery", Needs::kContext, [&] {
        cpu::StreamPtr target = resolveStream(stream);
        if (!cpu::streams().idle(target))
            return CUDA_ERROR_NOT_READY;
        cpu::streams().throwError(target);
        return CUDA_SUCCESS;
    });
}
SUNSTONE_EXPORT CUresult cuStreamSynchronize(CUstream stream) {
    return guarded("cuStreamSynchronize", Needs::kContext,
                   [&] { cpu::streams().synchronize(resolveStream(stream)); });
}
SUNSTONE_EXPORT CUresult cuStreamIsCapturing(CUstream stream, CUstreamCaptureStatus* status) {
    return guarded("cuStreamIsCapturing", Needs::kContext, [&] {
        require(status, "status is null");
        resolveStream(stream);
        *status = CU_STREAM_CAPTURE_STATUS_NONE; // capture cannot be begun
    });
}
SUNSTONE_EXPORT CUresult cuStreamAttachMemAsync(CUstream stream, CUdeviceptr address, size_t length,
                                                unsigned int flags) {
    return guarded("cuStreamAttachMemAsync", Needs::kContext, [&] {
        require(flags == CU_MEM_ATTACH_GLOBAL || flags == CU_MEM_ATTACH_HOST ||
                    flags == CU_MEM_ATTACH_SINGLE,
                "unknown flags");
        auto memory = cpu::memory().find(reinterpret_cast<void*>(address));
        require(memory && memory->kind == cpu::MemoryKind::kManaged &&
                    (length == 0 || length == memory->size),
                "not managed memory as a whole");
        resolveStream(stream); // host and device share it whatever it is attached to
    });
}
SUNSTONE_EXPORT CUresult cuEventRecord(CUevent event, CUstream stream) {
    return recordEvent("cuEventRecord", event, stream);
}
SUNSTONE_EXPORT CUresult cuEventRecordWithFlags(CUevent event, CUstream stream,
                                                unsigned int flags) {
    if (flags > CU_EVENT_RECORD_EXTERNAL)
        return guarded("cuEventRecordWithFlags", Needs::kContext,
                       [] { require(false, "unknown flags"); });
    return recordEvent("cuEventRecordWithFlags", event, stream);
}
