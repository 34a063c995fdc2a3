// SPDX-License-Identifier: Apache-2.0
// Device contexts (OptiX 7.4, section 3.4).
#include "api/optix7/denoiser.h"
#include "api/optix7/entry_points.h"
#include "api/optix7/shell.h"
#include "api/optix7/wording.h"
#include "base/forked.h"
#include "base/readable.h"
#include "device/cuda/driver.h"

#include <algorithm>

namespace sunstone::optix7 {
namespace {

using device::cuda::LoadedDriver;

// The context of a GPU, checked with the process's own libcuda.
void* resolveGpuContext(void* fromContext) {
    if (fromContext) {
        // Drivers read the memory before they check whether it is a context.
        constexpr size_t kLook = 64;
        if (!isReadable(fromContext, kLook))
            throw ResultError(OPTIX_ERROR_CUDA_ERROR,
                              message("fromContext = ", fromContext,
                                      " is no CUDA context: there is no such memory"));
        const auto given = static_cast<CUcontext>(fromContext);
        CUcontext popped = nullptr;
        if (device::cuda::driver().ctxPushCurrent(given) != CUDA_SUCCESS)
            throw ResultError(OPTIX_ERROR_CUDA_ERROR, message("fromContext = ", fromContext,
                                                              " is not a live CUDA context"));
        device::cuda::driver().ctxPopCurrent(&popped);
        return fromContext;
    }
    CUcontext current = nullptr;
    SUNSTONE_CU(ctxGetCurrent, &current);
    if (!current)
        fail(Code::kNotInitialized, "fromContext is 0 and the calling thread has no current "
             "CUDA context (call cudaFree(0) or cuCtxSetCurrent first)");
    return current;
}

void* resolveCpuContext(LoadedDriver driver, void* fromContext) {
    device::Device& device = device::cpuDevice();
    switch (driver) {
    case LoadedDriver::kNone:
        // Without a CUDA library the CPU itself is the device and stream 0 the only stream.
        if (fromContext)
            throw ResultError(OPTIX_ERROR_CUDA_ERROR,
                              message("fromContext = ", fromContext,
                                      " given, but no CUDA driver library is loaded"));
        return nullptr;
    default:
        break;
    }
    if (!fromContext) {
        void* current = device.currentContext();
        if (!current)
            fail(Code::kNotInitialized, "fromContext is 0 and the calling thread has no current "
                 "CUDA context (call cudaFree(0) or cuCtxSetCurrent first)");
        return current;
    }
    if (!device.ownsContext(fromContext))
        throw ResultError(OPTIX_ERROR_CUDA_ERROR, message("fromContext = ", fromContext,
                                                          " is not a live CUDA context"));
    return fromContext;
}

// Chooses the back end: the process's GPU, or the CPU. Without a loaded libcuda it is the CPU.
void chooseDevice(DeviceContext& object, void* fromContext) {
    const LoadedDriver driver = device::cuda::loadedDriver();
    if (driver == LoadedDriver::kGpu) {
        object.cudaContext = resolveGpuContext(fromContext);
        object.engine->backend = engine::createGpuBackend(object.cudaContext);
    } else {
        object.cudaContext = resolveCpuContext(driver, fromContext);
        object.engine->backend = engine::cpuBackend();
    }
    object.engine->device = &object.engine->backend->device();
}

unsigned propertyOf(Abi abi, OptixDeviceProperty property) {
    switch (property) {
    case OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH: return Limits::kTraceDepth;
    case OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRAVERSABLE_GRAPH_DEPTH: return Limits::kGraphDepth;
    case OPTIX_DEVICE_PROPERTY_LIMIT_MAX_PRIMITIVES_PER_GAS: return Limits::kPrimitivesPerGas;
    case OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCES_PER_IAS: return Limits::instancesPerIas(abi);
    case OPTIX_DEVICE_PROPERTY_RTCORE_VERSION: return 0;
    case OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCE_ID: return Limits::instanceId(abi);
    case OPTIX_DEVICE_PROPERTY_LIMIT_NUM_BITS_INSTANCE_VISIBILITY_MASK:
        return Limits::kVisibilityMaskBits;
    case OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_RECORDS_PER_GAS: return Limits::kSbtRecordsPerGas;
    case OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_OFFSET: return Limits::sbtOffset(abi);
    }
    fail(Code::kInvalidValue, "property = ", unsigned(property), " is unknown");
}

} // namespace

OptixResult deviceContextCreate(Abi abi, CUcontext fromContext,
                                const OptixDeviceContextOptions* options,
                                OptixDeviceContext* context) {
    return guarded(nullptr, "optixDeviceContextCreate", [&] {
        requireNonNull(context, "context");
        *context = nullptr;
        OptixDeviceContextOptions given = options ? *options : OptixDeviceContextOptions{};
        if (given.validationMode != OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_OFF &&
            given.validationMode != OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL)
            fail(Code::kInvalidValue, "options->validationMode = ", unsigned(given.validationMode),
                 " is neither OFF nor ALL");
        auto object = std::make_shared<DeviceContext>();
        object->abi = abi;
        object->setCallback(given.logCallbackFunction, given.logCallbackData,
                            unsigned(std::max(0, given.logCallbackLevel)));
        // From here on errors also reach the caller's callback.
        OptixResult result = guarded(object, "optixDeviceContextCreate", [&] {
            object->engine = std::make_shared<engine::Context>();
            object->engine->validation =
                given.validationMode == OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
            object->engine->wording = &wording();
            chooseDevice(*object, fromContext);
        });
        if (result != OPTIX_SUCCESS)
            throw ResultError(result, "no device context was created");
        // The engine's lines go to this context's callback during its lifetime.
        std::weak_ptr<DeviceContext> weak = object;
        object->engine->log = [weak](LogLevel level, std::string_view tag, std::string_view text) {
            if (auto alive = weak.lock())
                alive->logQueued(level, tag, text);
        };
        object->engine->cache = std::make_shared<engine::CompileCache>(
            [weak](LogLevel level, const std::string& text) {
                if (auto alive = weak.lock())
                    alive->log(level, "DISKCACHE", text);
            });
        object->engine->cache->start();
        object->engine->backend->useCache(object->engine->cache);
        watchForks();
        *context = static_cast<OptixDeviceContext>(contexts().add(object));
        if (object->engine->validation)
            object->log(LogLevel::kWarning, "CONTEXT",
                        "validation mode: launches wait, check what they do, and are slow");
        object->log(LogLevel::kInfo, "CONTEXT", message("device: ", object->engine->device->name()));
    });
}

OptixResult deviceContextDestroy(OptixDeviceContext context) {
    std::shared_ptr<DeviceContext> object = contexts().find(context);
    return guarded(object, "optixDeviceContextDestroy", [&] {
        contextOf(context);
        std::string failure; // of pending work; the objects are destroyed anyway
        try {
            object->engine->device->synchronizeAll();
        } catch (const Error& error) {
            failure = error.what();
        }
        auto mine = [&](const auto& other) { return other.context == object; };
        pipelines().removeIf(mine); // before flush: graphs that run them have reports
        object->engine->backend->flush(*object->engine);
        denoisers().removeIf(mine);
        groups().removeIf(mine);
        tasks().removeIf(mine);
        modules().removeIf(mine);
        contexts().remove(context);
        if (!failure.empty())
            fail(Code::kCudaError, failure);
    });
}

OptixResult deviceContextGetProperty(OptixDeviceContext context, OptixDeviceProperty property,
                                     void* value, size_t sizeInBytes) {
    return guarded(peek(context), "optixDeviceContextGetProperty", [&] {
        contextOf(context);
        requireNonNull(value, "value");
        if (sizeInBytes != sizeof(unsigned))
            fail(Code::kInvalidValue, "sizeInBytes = ", sizeInBytes, ", but every property is an "
                 "unsigned int of 4 bytes");
        const unsigned found = propertyOf(contextOf(context)->abi, property);
        std::memcpy(value, &found, sizeof(unsigned));
    });
}

OptixResult deviceContextSetLogCallback(OptixDeviceContext context, OptixLogCallback callback,
                                        void* callbackData, unsigned callbackLevel) {
    return guarded(peek(context), "optixDeviceContextSetLogCallback", [&] {
        const std::shared_ptr<DeviceContext> object = contextOf(context);
        object->engine->backend->flush(*object->engine); // earlier lines go to the old callback
        object->setCallback(callback, callbackData, callbackLevel);
    });
}

} // namespace sunstone::optix7
