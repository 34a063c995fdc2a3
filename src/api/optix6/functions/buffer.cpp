// SPDX-License-Identifier: Apache-2.0
// Entry points of buffers (section 5.14).
#include "api/optix6/call.h"

#include <algorithm>
#include <cstring>

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

void checkDescription(unsigned description) {
    constexpr unsigned kFlags = RT_BUFFER_GPU_LOCAL | RT_BUFFER_COPY_ON_DIRTY |
                                RT_BUFFER_DISCARD_HOST_MEMORY | RT_BUFFER_LAYERED |
                                RT_BUFFER_CUBEMAP;
    const unsigned type = description & ~kFlags;
    const bool known = type == RT_BUFFER_INPUT || type == RT_BUFFER_OUTPUT ||
                       type == RT_BUFFER_INPUT_OUTPUT || type == RT_BUFFER_PROGRESSIVE_STREAM;
    if (!known)
        refuse(RT_ERROR_INVALID_VALUE, "bufferdesc = ", description,
               " has no type or unknown flags");
    if ((description & RT_BUFFER_GPU_LOCAL) && type != RT_BUFFER_INPUT_OUTPUT)
        refuse(RT_ERROR_INVALID_VALUE, "RT_BUFFER_GPU_LOCAL needs RT_BUFFER_INPUT_OUTPUT");
    if ((description & RT_BUFFER_DISCARD_HOST_MEMORY) && type != RT_BUFFER_INPUT)
        refuse(RT_ERROR_INVALID_VALUE, "RT_BUFFER_DISCARD_HOST_MEMORY needs RT_BUFFER_INPUT");
    if (type == RT_BUFFER_PROGRESSIVE_STREAM && description != type)
        refuse(RT_ERROR_INVALID_VALUE, "RT_BUFFER_PROGRESSIVE_STREAM takes no flags");
}

RTresult createBuffer(const char* function, RTcontext handle, unsigned description,
                      RTbuffer* buffer) {
    return callContext(
        function, handle,
        [&](Context& context) {
            requireNonNull(buffer, "buffer");
            *buffer = nullptr;
            checkDescription(description);
            auto object = std::make_shared<Buffer>(context.self(), description);
            *buffer = static_cast<RTbuffer>(objects().add(object));
            auto& all = context.allBuffers;
            if (all.size() == all.capacity())
                all.erase(std::remove_if(all.begin(), all.end(),
                                         [](const auto& ref) { return ref.expired(); }),
                          all.end());
            all.push_back(object);
        },
        RT_ERROR_INVALID_CONTEXT);
}

// Changes a property of a buffer on which structures and records depend.
template <class Body>
RTresult change(const char* function, RTbuffer buffer, const Body& body) {
    return call<Buffer>(function, buffer, "buffer", body);
}

RTresult setSize(const char* function, RTbuffer buffer, unsigned dimensions, const RTsize* sizes) {
    return change(function, buffer, [&](Buffer& object) {
        if (dimensions < 1 || dimensions > 3)
            refuse(RT_ERROR_INVALID_VALUE, "dimensionality = ", dimensions, " is outside 1..3");
        requireNonNull(sizes, "dims");
        object.setSize(dimensions, sizes);
    });
}

// `level`: of the mip map.
RTresult getSize(const char* function, RTbuffer buffer, unsigned level, unsigned count,
                 RTsize* const* results) {
    return call<Buffer>(function, buffer, "buffer", [&](Buffer& object) {
        for (unsigned i = 0; i < count; ++i)
            requireNonNull(results[i], "a result");
        if (level >= object.mipLevels)
            refuse(RT_ERROR_INVALID_VALUE, "level = ", level, " of a buffer with ",
                   object.mipLevels, " levels");
        for (unsigned i = 0; i < count; ++i)
            *results[i] = object.extent(i, level);
    });
}

} // namespace

SUNSTONE_API RTresult rtBufferCreate(RTcontext context, unsigned description, RTbuffer* buffer) {
    return createBuffer(__func__, context, description, buffer);
}
SUNSTONE_API RTresult rtBufferCreateForCUDA(RTcontext context, unsigned description,
                                            RTbuffer* buffer) {
    return createBuffer(__func__, context, description, buffer);
}
SUNSTONE_API RTresult rtBufferDestroy(RTbuffer buffer) {
    return destroy<Buffer>(__func__, buffer, "buffer");
}
SUNSTONE_API RTresult rtBufferValidate(RTbuffer buffer) {
    return call<Buffer>(__func__, buffer, "buffer", [](Buffer& object) { object.validate(); });
}
SUNSTONE_API RTresult rtBufferGetContext(RTbuffer buffer, RTcontext* context) {
    return getContext<Buffer>(__func__, buffer, "buffer", context);
}
SUNSTONE_API RTresult rtBufferSetFormat(RTbuffer buffer, RTformat format) {
    return change(__func__, buffer, [&](Buffer& object) { object.setFormat(format); });
}
SUNSTONE_API RTresult rtBufferGetFormat(RTbuffer buffer, RTformat* format) {
    return call<Buffer>(__func__, buffer, "buffer",
                        [&](Buffer& object) { store(format, "format", object.format); });
}
SUNSTONE_API RTresult rtBufferSetElementSize(RTbuffer buffer, RTsize size) {
    return change(__func__, buffer, [&](Buffer& object) { object.setElementSize(size); });
}
SUNSTONE_API RTresult rtBufferGetElementSize(RTbuffer buffer, RTsize* size) {
    return call<Buffer>(__func__, buffer, "buffer", [&](Buffer& object) {
        store(size, "elementSize", RTsize(object.view().elementBytes));
    });
}
SUNSTONE_API RTresult rtBufferSetSize1D(RTbuffer buffer, RTsize width) {
    return setSize(__func__, buffer, 1, &width);
}
SUNSTONE_API RTresult rtBufferSetSize2D(RTbuffer buffer, RTsize width, RTsize height) {
    const RTsize sizes[] = {width, height};
    return setSize(__func__, buffer, 2, sizes);
}
SUNSTONE_API RTresult rtBufferSetSize3D(RTbuffer buffer, RTsize width, RTsize height,
                                        RTsize depth) {
    const RTsize sizes[] = {width, height, depth};
    return setSize(__func__, buffer, 3, sizes);
}
SUNSTONE_API RTresult rtBufferSetSizev(RTbuffer buffer, unsigned dimensions, const RTsize* sizes) {
    return setSize(__func__, buffer, dimensions, sizes);
}
SUNSTONE_API RTresult rtBufferGetSize1D(RTbuffer buffer, RTsize* width) {
    RTsize* const results[] = {width};
    return getSize(__func__, buffer, 0, 1, results);
}
SUNSTONE_API RTresult rtBufferGetSize2D(RTbuffer buffer, RTsize* width, RTsize* height) {
    RTsize* const results[] = {width, height};
    return getSize(__func__, buffer, 0, 2, results);
}
SUNSTONE_API RTresult rtBufferGetSize3D(RTbuffer buffer, RTsize* width, RTsize* height,
                                        RTsize* depth) {
    RTsize* const results[] = {width, height, depth};
    return getSize(__func__, buffer, 0, 3, results);
}
SUNSTONE_API RTresult rtBufferGetMipLevelSize1D(RTbuffer buffer, unsigned level, RTsize* width) {
    RTsize* const results[] = {width};
    return getSize(__func__, buffer, level, 1, results);
}
SUNSTONE_API RTresult rtBufferGetMipLevelSize2D(RTbuffer buffer, unsigned level, RTsize* width,
                                                RTsize* height) {
    RTsize* const results[] = {width, height};
    return getSize(__func__, buffer, level, 2, results);
}
SUNSTONE_API RTresult rtBufferGetMipLevelSize3D(RTbuffer buffer, unsigned level, RTsize* width,
                                                RTsize* height, RTsize* depth) {
    RTsize* const results[] = {width, height, depth};
    return getSize(__func__, buffer, level, 3, results);
}
SUNSTONE_API RTresult rtBufferGetSizev(RTbuffer buffer, unsigned dimensions, RTsize* sizes) {
    return call<Buffer>(__func__, buffer, "buffer", [&](Buffer& object) {
        requireNonNull(sizes, "dims");
        if (dimensions < 1 || dimensions > 3)
            refuse(RT_ERROR_INVALID_VALUE, "dimensionality = ", dimensions, " is outside 1..3");
        for (unsigned i = 0; i < dimensions; ++i)
            sizes[i] = object.extent(i, 0);
    });
}
SUNSTONE_API RTresult rtBufferGetDimensionality(RTbuffer buffer, unsigned* dimensions) {
    return call<Buffer>(__func__, buffer, "buffer", [&](Buffer& object) {
        store(dimensions, "dimensionality", std::max(1u, object.dimensions));
    });
}
SUNSTONE_API RTresult rtBufferSetMipLevelCount(RTbuffer buffer, unsigned levels) {
    return change(__func__, buffer, [&](Buffer& object) { object.setMipLevels(levels); });
}
SUNSTONE_API RTresult rtBufferGetMipLevelCount(RTbuffer buffer, unsigned* levels) {
    return call<Buffer>(__func__, buffer, "buffer",
                        [&](Buffer& object) { store(levels, "level", object.mipLevels); });
}

// A progressive launch continues while its pictures are mapped.
static RTresult onMemory(const char* function, RTbuffer buffer,
                         const std::function<void(Buffer&)>& body) {
    return call<Buffer>(function, buffer, "buffer", body,
                        [](const Buffer& object) { return object.stream != nullptr; });
}

SUNSTONE_API RTresult rtBufferMap(RTbuffer buffer, void** pointer) {
    return onMemory(__func__, buffer, [&](Buffer& object) {
        requireNonNull(pointer, "userPointer");
        *pointer = object.map(RT_BUFFER_MAP_READ_WRITE, 0);
    });
}
SUNSTONE_API RTresult rtBufferMapEx(RTbuffer buffer, unsigned flags, unsigned level,
                                    void* userOwned, void** pointer) {
    return onMemory(__func__, buffer, [&](Buffer& object) {
        requireNonNull(pointer, "optixOwned");
        if (userOwned)
            refuse(RT_ERROR_INVALID_VALUE, "userOwned = ", userOwned, " is not null");
        *pointer = object.map(flags, level);
    });
}
SUNSTONE_API RTresult rtBufferUnmap(RTbuffer buffer) {
    return onMemory(__func__, buffer, [](Buffer& object) { object.unmap(0); });
}
SUNSTONE_API RTresult rtBufferUnmapEx(RTbuffer buffer, unsigned level) {
    return onMemory(__func__, buffer, [&](Buffer& object) { object.unmap(level); });
}
SUNSTONE_API RTresult rtBufferGetId(RTbuffer buffer, int* id) {
    return call<Buffer>(__func__, buffer, "buffer", [&](Buffer& object) {
        requireNonNull(id, "bufferId");
        *id = object.context()->idOf(object);
    });
}

static void requireDevice(const Buffer& buffer, int ordinal) {
    if (const int device = buffer.context()->device; ordinal != device)
        refuse(RT_ERROR_INVALID_VALUE, "optix_device_ordinal = ", ordinal,
               ", but the context runs on device ", device);
}

// Launches copy the elements from OpenGL, so writes through a pointer would be lost.
static void requireOwnElements(const Buffer& buffer) {
    if (buffer.glBuffer)
        refuse(RT_ERROR_INVALID_VALUE, "the elements are those of OpenGL buffer ", buffer.glBuffer,
               ": the buffer has no device pointer");
}

SUNSTONE_API RTresult rtBufferGetDevicePointer(RTbuffer buffer, int device, void** pointer) {
    return call<Buffer>(__func__, buffer, "buffer", [&](Buffer& object) {
        requireNonNull(pointer, "device_pointer");
        *pointer = nullptr;
        requireDevice(object, device);
        requireOwnElements(object);
        object.validate();
        *pointer = object.data();
        object.notePointer();
    });
}
SUNSTONE_API RTresult rtBufferSetDevicePointer(RTbuffer buffer, int device, void* pointer) {
    return change(__func__, buffer, [&](Buffer& object) {
        requireDevice(object, device);
        requireOwnElements(object);
        object.validate();
        if (pointer && !object.context()->engine->device->isAccessible(pointer, object.bytes()))
            refuse(RT_ERROR_INVALID_VALUE, "device_pointer = ", pointer,
                   " is not in accessible memory for all ", object.bytes(), " bytes of the buffer");
        object.setMemory(pointer);
    });
}
SUNSTONE_API RTresult rtBufferMarkDirty(RTbuffer buffer) {
    // Launches copy buffers without RT_BUFFER_COPY_ON_DIRTY in any case.
    return call<Buffer>(__func__, buffer, "buffer", [](Buffer& object) { object.noteChange(); });
}
