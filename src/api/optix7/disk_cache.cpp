// SPDX-License-Identifier: Apache-2.0
// Settings of a context's disk cache (OptiX 7.4, sections 3.4.2.3 to 3.4.2.9).
#include "api/optix7/entry_points.h"
#include "api/optix7/shell.h"

namespace sunstone::optix7 {
namespace {

engine::CompileCache& cacheOf(OptixDeviceContext context) {
    return *contextOf(context)->engine->cache;
}

} // namespace

OptixResult deviceContextSetCacheEnabled(OptixDeviceContext context, int enabled) {
    return guarded(peek(context), "optixDeviceContextSetCacheEnabled",
                   [&] { cacheOf(context).setEnabled(enabled != 0); });
}

OptixResult deviceContextSetCacheLocation(OptixDeviceContext context, const char* location) {
    return guarded(peek(context), "optixDeviceContextSetCacheLocation", [&] {
        engine::CompileCache& cache = cacheOf(context);
        requireNonNull(location, "location");
        cache.setLocation(location);
    });
}

OptixResult deviceContextSetCacheDatabaseSizes(OptixDeviceContext context, size_t lowWaterMark,
                                               size_t highWaterMark) {
    return guarded(peek(context), "optixDeviceContextSetCacheDatabaseSizes",
                   [&] { cacheOf(context).setMarks({lowWaterMark, highWaterMark}); });
}

OptixResult deviceContextGetCacheEnabled(OptixDeviceContext context, int* enabled) {
    return guarded(peek(context), "optixDeviceContextGetCacheEnabled", [&] {
        engine::CompileCache& cache = cacheOf(context);
        requireNonNull(enabled, "enabled");
        *enabled = cache.enabled() ? 1 : 0;
    });
}

OptixResult deviceContextGetCacheLocation(OptixDeviceContext context, char* location,
                                          size_t locationSize) {
    return guarded(peek(context), "optixDeviceContextGetCacheLocation", [&] {
        const std::string path = cacheOf(context).location();
        requireNonNull(location, "location");
        if (locationSize == 0)
            fail(Code::kInvalidValue, "locationSize is 0; ", path.size() + 1, " bytes are needed");
        const size_t length = std::min(path.size(), locationSize - 1);
        std::memcpy(location, path.data(), length);
        location[length] = 0;
        if (length < path.size())
            fail(Code::kInvalidValue, "locationSize = ", locationSize, " is too small; ",
                 path.size() + 1, " bytes are needed");
    });
}

OptixResult deviceContextGetCacheDatabaseSizes(OptixDeviceContext context, size_t* lowWaterMark,
                                               size_t* highWaterMark) {
    return guarded(peek(context), "optixDeviceContextGetCacheDatabaseSizes", [&] {
        engine::CompileCache& cache = cacheOf(context);
        requireNonNull(lowWaterMark, "lowWaterMark");
        requireNonNull(highWaterMark, "highWaterMark");
        const cache::Marks marks = cache.marks();
        *lowWaterMark = marks.low;
        *highWaterMark = marks.high;
    });
}

} // namespace sunstone::optix7
