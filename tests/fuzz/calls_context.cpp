// SPDX-License-Identifier: Apache-2.0
// Fuzzing of contexts: creation, properties, log, cache.
#include "world.h"

#include <cstdlib>

namespace fuzz {
namespace {

void onLog(unsigned, const char*, const char*, void* world) {
    __atomic_add_fetch(static_cast<unsigned*>(world), 1, __ATOMIC_RELAXED);
}

// The count outlives every sequence: queued work may log late.
unsigned gLogLines = 0;

void create(World& w) {
    if (w.contexts.live.size() > 2)
        return;
    OptixDeviceContextOptions options{};
    if (w.chance(70))
        options.logCallbackFunction = onLog;
    options.logCallbackData = &gLogLines;
    options.logCallbackLevel = int(w.chance(80) ? 4 : w.any32());
    options.validationMode = w.enumerator({OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_OFF,
                                           OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_OFF,
                                           OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL});
    OptixDeviceContext context = nullptr;
    CUcontext from = w.chance(95) ? nullptr : CUcontext(w.anySize());
    OptixResult result = optixDeviceContextCreate(from, w.chance(80) ? &options : nullptr,
                                                  w.chance(97) ? &context : nullptr);
    if (result == OPTIX_SUCCESS)
        w.contexts.live.push_back(context);
    w.done("optixDeviceContextCreate", result);
}
const Call kCreate{"optixDeviceContextCreate", 2, create};

// Objects made from a context may outlive it.
void destroy(World& w) {
    OptixDeviceContext context = w.context();
    OptixResult result = optixDeviceContextDestroy(context);
    if (result == OPTIX_SUCCESS)
        w.contexts.died(context);
    w.done("optixDeviceContextDestroy", result);
}
const Call kDestroy{"optixDeviceContextDestroy", 1, destroy};

void getProperty(World& w) {
    uint64_t value[2] = {};
    auto property = w.enumerator({OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                  OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRAVERSABLE_GRAPH_DEPTH,
                                  OPTIX_DEVICE_PROPERTY_LIMIT_MAX_PRIMITIVES_PER_GAS,
                                  OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCES_PER_IAS,
                                  OPTIX_DEVICE_PROPERTY_RTCORE_VERSION,
                                  OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCE_ID,
                                  OPTIX_DEVICE_PROPERTY_LIMIT_NUM_BITS_INSTANCE_VISIBILITY_MASK,
                                  OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_RECORDS_PER_GAS,
                                  OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_OFFSET});
    // All properties have 32 bits: a larger size must be refused.
    size_t size = w.chance(80) ? 4 : w.anySize();
    w.done(
        "optixDeviceContextGetProperty",
        optixDeviceContextGetProperty(w.context(), property, w.chance(95) ? value : nullptr, size));
}
const Call kGetProperty{"optixDeviceContextGetProperty", 2, getProperty};

void setLog(World& w) {
    w.done("optixDeviceContextSetLogCallback",
           optixDeviceContextSetLogCallback(w.context(), w.chance(60) ? onLog : nullptr, &gLogLines,
                                            w.any32()));
}
const Call kSetLog{"optixDeviceContextSetLogCallback", 1, setLog};

void cache(World& w) {
    OptixDeviceContext context = w.context();
    char text[64];
    size_t low = 0, high = 0;
    int enabled = 0;
    switch (w.below(6)) {
    case 0: {
        w.done("optixDeviceContextSetCacheEnabled",
               optixDeviceContextSetCacheEnabled(context, w.chance(80) ? 0 : int(w.any32())));
        break;
    }
    case 1: {
        const std::string own = getenv("OPTIX_CACHE_PATH") ? getenv("OPTIX_CACHE_PATH") : "";
        const std::string folder =
            w.oneOf<std::string>({own, own + "/other", "", "/proc/nowhere/x", "/dev/null"});
        const char* path = folder.c_str();
        w.done("optixDeviceContextSetCacheLocation",
               optixDeviceContextSetCacheLocation(context, w.chance(90) ? path : nullptr), path);
        break;
    }
    case 2:
        w.done("optixDeviceContextSetCacheDatabaseSizes",
               optixDeviceContextSetCacheDatabaseSizes(context, w.anySize(), w.anySize()));
        break;
    case 3:
        w.done("optixDeviceContextGetCacheEnabled",
               optixDeviceContextGetCacheEnabled(context, w.chance(90) ? &enabled : nullptr));
        break;
    case 4:
        w.done("optixDeviceContextGetCacheLocation",
               optixDeviceContextGetCacheLocation(context, w.chance(90) ? text : nullptr,
                                                  w.below(sizeof(text) + 1)));
        break;
    default:
        w.done("optixDeviceContextGetCacheDatabaseSizes",
               optixDeviceContextGetCacheDatabaseSizes(context, w.chance(90) ? &low : nullptr,
                                                       w.chance(90) ? &high : nullptr));
    }
}
const Call kCache{"optixDeviceContext*Cache*", 2, cache};

void errorTexts(World& w) {
    auto code = OptixResult(w.chance(50) ? 7000 + w.below(1000) : w.any32());
    const char* name = optixGetErrorName(code);
    const char* text = optixGetErrorString(code);
    w.done(name && text && *name && *text ? "optixGetErrorName" : "a null text", OPTIX_SUCCESS);
}
const Call kErrorTexts{"optixGetErrorString", 1, errorTexts};

} // namespace
} // namespace fuzz
