// SPDX-License-Identifier: Apache-2.0
// Contexts (OptiX 6.0, module 5.31).
#include "api/prime/cuda_library.h"
#include "api/prime/shell.h"
#include "base/forked.h"
#include "base/threads/thread_object.h"
#include "device/cuda/driver.h"

#include <algorithm>

namespace sunstone::prime {
namespace {

// Makes the device the context's primary one, and current on this thread. The CUDA context is never
// released: like that of the CUDA runtime, it stays for the application's memory.
void choosePrimary(Context& context, int device) {
    const CudaFunctions& cu = cuda();
    CUdevice handle = 0;
    CUcontext retained = nullptr;
    check(cu.deviceGet(&handle, device), "cuDeviceGet");
    check(cu.primaryCtxRetain(&retained, handle), "cuDevicePrimaryCtxRetain");
    check(cu.ctxSetCurrent(retained), "cuCtxSetCurrent");
    context.cudaDevice = device;
    context.cudaContext = retained;
    const bool isGpu = device::cuda::loadedDriver() == device::cuda::LoadedDriver::kGpu;
    context.device = isGpu ? engine::gpuQueries(retained) : engine::cpuStreamQueries();
}

void createCudaContext(Context& context) {
    const std::vector<int> devices = cudaDevices();
    if (devices.empty())
        fail(Code::kNotInitialized, "there is no CUDA device of compute capability 3.0 or more");
    choosePrimary(context, devices.front());
}

// Objects of a context, or queries of a model, after their work has ended.
template <class Predicate>
void destroyQueries(Predicate isMine) {
    for (const std::shared_ptr<Query>& query : queries().removeIf(isMine))
        finishQuietly(completionOf(*query));
}

} // namespace

extern "C" RTPresult RTPAPI rtpContextCreate(RTPcontexttype type, RTPcontext* context) {
    return guarded(nullptr, "rtpContextCreate", [&] {
        requireNonNull(context, "context");
        auto object = std::make_shared<Context>();
        object->type = type;
        switch (type) {
        case RTP_CONTEXT_TYPE_CPU:
            object->device = engine::cpuQueries();
            break;
        case RTP_CONTEXT_TYPE_CUDA:
            createCudaContext(*object);
            break;
        default:
            fail(Code::kInvalidValue, "type = 0x", std::hex, unsigned(type),
                 " is neither RTP_CONTEXT_TYPE_CPU nor RTP_CONTEXT_TYPE_CUDA");
        }
        watchForks();
        *context = static_cast<RTPcontext>(contexts().add(object));
    });
}

extern "C" RTPresult RTPAPI rtpContextSetCudaDeviceNumbers(RTPcontext context, unsigned deviceCount,
                                                           const unsigned* deviceNumbers) {
    return guarded(contexts().find(context), "rtpContextSetCudaDeviceNumbers", [&] {
        const ContextPtr object = contextOf(context);
        if (object->type != RTP_CONTEXT_TYPE_CUDA)
            fail(Code::kInvalidValue, "context is not of type RTP_CONTEXT_TYPE_CUDA");
        if (deviceCount != 0)
            requireNonNull(deviceNumbers, "deviceNumbers");
        const std::vector<int> devices = cudaDevices();
        int primary = devices.empty() ? -1 : devices.front();
        size_t best = devices.size();
        for (unsigned i = 0; i < deviceCount; ++i) {
            const auto place = std::find(devices.begin(), devices.end(), int(deviceNumbers[i]));
            if (place == devices.end())
                fail(Code::kInvalidValue, "deviceNumbers[", i, "] = ", deviceNumbers[i],
                     " is no CUDA device of compute capability 3.0 or more");
            best = std::min(best, size_t(place - devices.begin()));
        }
        if (deviceCount != 0)
            primary = devices[best];
        std::lock_guard lock(object->mutex);
        if (primary == object->cudaDevice) {
            check(cuda().ctxSetCurrent(static_cast<CUcontext>(object->cudaContext)),
                  "cuCtxSetCurrent");
            return;
        }
        const auto mine = [&](const auto& other) { return other.context == object; };
        if (models().findIf(mine))
            fail(Code::kInvalidOperation, "the context has models on another device");
        choosePrimary(*object, primary);
    });
}

extern "C" RTPresult RTPAPI rtpContextSetCpuThreads(RTPcontext context, unsigned numThreads) {
    return guarded(contexts().find(context), "rtpContextSetCpuThreads", [&] {
        const ContextPtr object = contextOf(context);
        if (object->type != RTP_CONTEXT_TYPE_CPU)
            fail(Code::kInvalidValue, "context is not of type RTP_CONTEXT_TYPE_CPU");
        std::lock_guard lock(object->mutex);
        object->team = numThreads ? std::make_shared<ThreadTeam>(numThreads) : nullptr;
    });
}

extern "C" RTPresult RTPAPI rtpContextDestroy(RTPcontext context) {
    return guarded(nullptr, "rtpContextDestroy", [&] {
        const ContextPtr object = contextOf(context);
        const auto mine = [&](const auto& other) { return other.context == object; };
        contexts().remove(context);
        object->queue.waitFor(object->queue.ticket());
        destroyQueries(mine);
        models().removeIf(mine);
        descs().removeIf(mine);
    });
}

extern "C" RTPresult RTPAPI rtpContextGetLastErrorString(RTPcontext context,
                                                         const char** return_string) {
    if (isForkedChild() && return_string) {
        *return_string = kForkedChildText;
        return RTP_SUCCESS;
    }
    return guarded(nullptr, "rtpContextGetLastErrorString", [&] {
        const ContextPtr object = contextOf(context);
        requireNonNull(return_string, "return_string");
        // Valid until this thread's next call.
        std::string& text = threadObject<std::string>();
        text = object->lastError();
        *return_string = text.c_str();
    });
}

} // namespace sunstone::prime
