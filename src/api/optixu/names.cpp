// SPDX-License-Identifier: Apache-2.0
// Names of object types and sizes of formats.
#include "api/optixu/guard.h"

#include <optixu/optixu.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace sunstone::optixu {
namespace {

// The first of `count` types that follow each other: FLOAT, FLOAT2, ...
struct TypeFamily {
    unsigned first;
    unsigned count;
    const char* name;
};

constexpr TypeFamily kTypes[] = {
    {RT_OBJECTTYPE_UNKNOWN, 1, "UNKNOWN"},
    {RT_OBJECTTYPE_GROUP, 1, "GROUP"},
    {RT_OBJECTTYPE_GEOMETRY_GROUP, 1, "GEOMETRY_GROUP"},
    {RT_OBJECTTYPE_TRANSFORM, 1, "TRANSFORM"},
    {RT_OBJECTTYPE_SELECTOR, 1, "SELECTOR"},
    {RT_OBJECTTYPE_GEOMETRY_INSTANCE, 1, "GEOMETRY_INSTANCE"},
    {RT_OBJECTTYPE_BUFFER, 1, "BUFFER"},
    {RT_OBJECTTYPE_TEXTURE_SAMPLER, 1, "TEXTURE_SAMPLER"},
    {RT_OBJECTTYPE_OBJECT, 1, "OBJECT"},
    {RT_OBJECTTYPE_MATRIX_FLOAT2x2, 1, "MATRIX_FLOAT2x2"},
    {RT_OBJECTTYPE_MATRIX_FLOAT2x3, 1, "MATRIX_FLOAT2x3"},
    {RT_OBJECTTYPE_MATRIX_FLOAT2x4, 1, "MATRIX_FLOAT2x4"},
    {RT_OBJECTTYPE_MATRIX_FLOAT3x2, 1, "MATRIX_FLOAT3x2"},
    {RT_OBJECTTYPE_MATRIX_FLOAT3x3, 1, "MATRIX_FLOAT3x3"},
    {RT_OBJECTTYPE_MATRIX_FLOAT3x4, 1, "MATRIX_FLOAT3x4"},
    {RT_OBJECTTYPE_MATRIX_FLOAT4x2, 1, "MATRIX_FLOAT4x2"},
    {RT_OBJECTTYPE_MATRIX_FLOAT4x3, 1, "MATRIX_FLOAT4x3"},
    {RT_OBJECTTYPE_MATRIX_FLOAT4x4, 1, "MATRIX_FLOAT4x4"},
    {RT_OBJECTTYPE_FLOAT, 4, "FLOAT"},
    {RT_OBJECTTYPE_INT, 4, "INT"},
    {RT_OBJECTTYPE_UNSIGNED_INT, 4, "UNSIGNED_INT"},
    {RT_OBJECTTYPE_USER, 1, "USER"},
    {RT_OBJECTTYPE_PROGRAM, 1, "PROGRAM"},
    {RT_OBJECTTYPE_COMMANDLIST, 1, "COMMANDLIST"},
    {RT_OBJECTTYPE_POSTPROCESSINGSTAGE, 1, "POSTPROCESSINGSTAGE"},
    {RT_OBJECTTYPE_LONG_LONG, 4, "LONG_LONG"},
    {RT_OBJECTTYPE_UNSIGNED_LONG_LONG, 4, "UNSIGNED_LONG_LONG"},
};

// Consecutive formats: one to `count` components of `bytes` each; in a family of blocks all have
// the same number of bytes.
struct FormatFamily {
    unsigned first;
    unsigned count;
    unsigned bytes;
    bool blocks;
};

constexpr FormatFamily kFormats[] = {
    {RT_FORMAT_UNKNOWN, 1, 0, true},       {RT_FORMAT_FLOAT, 4, 4, false},
    {RT_FORMAT_BYTE, 4, 1, false},         {RT_FORMAT_UNSIGNED_BYTE, 4, 1, false},
    {RT_FORMAT_SHORT, 4, 2, false},        {RT_FORMAT_UNSIGNED_SHORT, 4, 2, false},
    {RT_FORMAT_INT, 4, 4, false},          {RT_FORMAT_UNSIGNED_INT, 4, 4, false},
    {RT_FORMAT_USER, 1, 0, true},          {RT_FORMAT_BUFFER_ID, 1, 4, true},
    {RT_FORMAT_PROGRAM_ID, 1, 4, true},    {RT_FORMAT_HALF, 4, 2, false},
    {RT_FORMAT_LONG_LONG, 4, 8, false},    {RT_FORMAT_UNSIGNED_LONG_LONG, 4, 8, false},
    {RT_FORMAT_UNSIGNED_BC1, 1, 8, true},  {RT_FORMAT_UNSIGNED_BC2, 2, 16, true}, // and BC3
    {RT_FORMAT_UNSIGNED_BC4, 2, 8, true},                                         // and BC4
    {RT_FORMAT_UNSIGNED_BC5, 5, 16, true},                                        // to BC7
};

RTresult nameForType(const char* function, RTobjecttype type, char* buffer, RTsize bufferSize) {
    if (!buffer || bufferSize == 0)
        return refuse(function, RT_ERROR_INVALID_VALUE,
                      !buffer ? "buffer is null" : "bufferSize is 0");
    for (const TypeFamily& family : kTypes) {
        const unsigned index = unsigned(type) - family.first;
        if (index >= family.count)
            continue;
        const std::string name = family.name + (index ? std::to_string(index + 1) : "");
        const size_t length = std::min<size_t>(name.size(), bufferSize - 1);
        std::memcpy(buffer, name.data(), length);
        buffer[length] = '\0';
        return RT_SUCCESS;
    }
    return refuse(function, RT_ERROR_INVALID_VALUE,
                  "type = " + std::to_string(unsigned(type)) + " is no RTobjecttype");
}

RTresult sizeForFormat(const char* function, RTformat format, size_t* size) {
    if (!size)
        return refuse(function, RT_ERROR_INVALID_VALUE, "size is null");
    for (const FormatFamily& family : kFormats) {
        const unsigned index = unsigned(format) - family.first;
        if (index >= family.count)
            continue;
        *size = family.blocks ? family.bytes : family.bytes * (index + 1);
        return RT_SUCCESS;
    }
    return refuse(function, RT_ERROR_INVALID_VALUE,
                  "format = " + std::to_string(unsigned(format)) + " is no RTformat");
}

} // namespace
} // namespace sunstone::optixu

using namespace sunstone::optixu;

SUNSTONE_API RTresult rtuNameForType(RTobjecttype type, char* buffer, RTsize bufferSize) {
    const char* function = __func__;
    return guarded(function, [&] { return nameForType(function, type, buffer, bufferSize); });
}

SUNSTONE_API RTresult rtuGetSizeForRTformat(RTformat format, size_t* size) {
    const char* function = __func__;
    return guarded(function, [&] { return sizeForFormat(function, format, size); });
}
