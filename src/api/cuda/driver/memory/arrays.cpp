// SPDX-License-Identifier: Apache-2.0
// Arrays and mipmapped arrays. See arrays.h.
#include "api/cuda/driver/memory/arrays.h"

#include "base/handles.h"

#include <algorithm>

using namespace sunstone;
using namespace sunstone::api::cuda;
using texture::Channel;

namespace sunstone::api::cuda {

namespace {

constexpr size_t kMaxWidth = 131072, kMaxDepth = 32768, kMaxLayers = 2048;

HandleTable<MipmapHandle>& mipmaps();

HandleTable<ArrayHandle>& arrays() {
    static auto* table = [] {
        cpu::contexts().onDestroy([](cpu::Context* context) {
            mipmaps().removeIf([&](const MipmapHandle& m) { return m.owner == context; });
            arrays().removeIf([&](const ArrayHandle& a) { return a.owner == context; });
        });
        return new HandleTable<ArrayHandle>;
    }();
    return *table;
}
HandleTable<MipmapHandle>& mipmaps() {
    static auto* table = new HandleTable<MipmapHandle>;
    return *table;
}

// Formats whose value includes the number of channels.
struct NamedFormat {
    unsigned value;
    Channel channel;
    unsigned channels;
    bool srgb;
};
constexpr NamedFormat kNamedFormats[] = {
    {0x91, Channel::kBC1, 4, false},  {0x92, Channel::kBC1, 4, true},
    {0x93, Channel::kBC2, 4, false},  {0x94, Channel::kBC2, 4, true},
    {0x95, Channel::kBC3, 4, false},  {0x96, Channel::kBC3, 4, true},
    {0x97, Channel::kBC4U, 1, false}, {0x98, Channel::kBC4S, 1, false},
    {0x99, Channel::kBC5U, 2, false}, {0x9A, Channel::kBC5S, 2, false},
    {0x9B, Channel::kBC6U, 3, false}, {0x9C, Channel::kBC6S, 3, false},
    {0x9D, Channel::kBC7, 4, false},  {0x9E, Channel::kBC7, 4, true},
    {0xC0, Channel::kU8, 1, false},   {0xC1, Channel::kU8, 2, false},
    {0xC2, Channel::kU8, 4, false},   {0xC3, Channel::kU16, 1, false},
    {0xC4, Channel::kU16, 2, false},  {0xC5, Channel::kU16, 4, false},
    {0xC6, Channel::kS8, 1, false},   {0xC7, Channel::kS8, 2, false},
    {0xC8, Channel::kS8, 4, false},   {0xC9, Channel::kS16, 1, false},
    {0xCA, Channel::kS16, 2, false},  {0xCB, Channel::kS16, 4, false},
};

texture::Shape shapeOf(const CUDA_ARRAY3D_DESCRIPTOR& d) {
    texture::Shape shape;
    shape.layered = d.Flags & CUDA_ARRAY3D_LAYERED;
    shape.cube = d.Flags & CUDA_ARRAY3D_CUBEMAP;
    require(d.Width >= 1 && d.Width <= kMaxWidth && d.Height <= kMaxWidth,
            "the width must be 1 to 131072, the height at most 131072");
    const size_t most = shape.layered || shape.cube ? kMaxLayers * 6 : kMaxDepth;
    require(d.Depth <= most, "the depth is too large");
    if (shape.cube) {
        require(d.Width == d.Height, "faces of a cube map must be square");
        require(shape.layered ? d.Depth != 0 && d.Depth % 6 == 0 : d.Depth == 6,
                "the depth of a cube map must be 6, or a multiple of it with layers");
    } else if (shape.layered) {
        require(d.Depth != 0, "a layered array needs layers: the depth is 0");
    } else {
        require(d.Depth == 0 || d.Height != 0, "a depth needs a height");
    }
    shape.width = uint32_t(d.Width);
    shape.height = uint32_t(d.Height);
    shape.depth = uint32_t(d.Depth);
    return shape;
}

void checkFlags(unsigned flags) {
    constexpr unsigned kKnown = CUDA_ARRAY3D_LAYERED | CUDA_ARRAY3D_SURFACE_LDST |
                                CUDA_ARRAY3D_CUBEMAP | CUDA_ARRAY3D_TEXTURE_GATHER |
                                CUDA_ARRAY3D_DEPTH_TEXTURE | CUDA_ARRAY3D_COLOR_ATTACHMENT;
    if (flags & (CUDA_ARRAY3D_SPARSE | CUDA_ARRAY3D_DEFERRED_MAPPING))
        refuse(CUDA_ERROR_NOT_SUPPORTED, "sparse and deferred arrays");
    require((flags & ~kKnown) == 0, "unknown array flags");
}

// Arrays outlive their context if a texture of another one uses them, so they have no owner.
constexpr texture::ArrayMemory kDeviceMemory = {
    [](size_t bytes) {
        return cpu::memory().allocateZeroed(bytes, cpu::MemoryKind::kArray, 0, nullptr);
    },
    [](void* data) { cpu::memory().release(data, {cpu::MemoryKind::kArray}); }};

std::shared_ptr<ArrayHandle> makeArray(const CUDA_ARRAY3D_DESCRIPTOR& descriptor,
                                       const texture::Shape& shape, bool isLevel) {
    auto handle = std::make_shared<ArrayHandle>();
    handle->array = std::make_shared<texture::Array>(
        formatOf(descriptor.Format, descriptor.NumChannels), shape, kDeviceMemory);
    handle->descriptor = descriptor;
    handle->descriptor.Width = shape.width;
    handle->descriptor.Height = shape.height;
    handle->descriptor.Depth = shape.depth;
    handle->owner = cpu::contexts().current();
    handle->isLevel = isLevel;
    return handle;
}

CUarray create(const CUDA_ARRAY3D_DESCRIPTOR& descriptor) {
    checkFlags(descriptor.Flags);
    return static_cast<CUarray>(arrays().add(makeArray(descriptor, shapeOf(descriptor), false)));
}

} // namespace

std::shared_ptr<ArrayHandle> arrayOf(CUarray array) {
    auto found = arrays().find(array);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(array), " is not a live array");
    return found;
}

std::shared_ptr<MipmapHandle> mipmapOf(CUmipmappedArray mipmap) {
    auto found = mipmaps().find(mipmap);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(mipmap),
               " is not a live mipmapped array");
    return found;
}

texture::Format formatOf(CUarray_format format, unsigned channels) {
    texture::Format result;
    for (const NamedFormat& named : kNamedFormats) {
        if (unsigned(format) != named.value)
            continue;
        require(channels == named.channels, "the format has another number of channels");
        result.channel = named.channel;
        result.channels = uint8_t(channels);
        result.normalized = named.value >= 0xC0;
        result.srgb = named.srgb;
        return result;
    }
    switch (unsigned(format)) {
    case CU_AD_FORMAT_UNSIGNED_INT8:
        result.channel = Channel::kU8;
        break;
    case CU_AD_FORMAT_UNSIGNED_INT16:
        result.channel = Channel::kU16;
        break;
    case CU_AD_FORMAT_UNSIGNED_INT32:
        result.channel = Channel::kU32;
        break;
    case CU_AD_FORMAT_SIGNED_INT8:
        result.channel = Channel::kS8;
        break;
    case CU_AD_FORMAT_SIGNED_INT16:
        result.channel = Channel::kS16;
        break;
    case CU_AD_FORMAT_SIGNED_INT32:
        result.channel = Channel::kS32;
        break;
    case CU_AD_FORMAT_HALF:
        result.channel = Channel::kF16;
        break;
    case CU_AD_FORMAT_FLOAT:
        result.channel = Channel::kF32;
        break;
    case 0x9B:
    case 0x9C: // BC6H
    case 0x9D:
    case 0x9E: // BC7
    case 0xB0: // NV12
        refuse(CUDA_ERROR_NOT_SUPPORTED, "array format ", unsigned(format));
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "array format ", unsigned(format), " is unknown");
    }
    require(channels == 1 || channels == 2 || channels == 4, "channels must be 1, 2 or 4");
    result.channels = uint8_t(channels);
    return result;
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuArrayCreate(CUarray* array, const CUDA_ARRAY_DESCRIPTOR* descriptor) {
    return guarded("cuArrayCreate", Needs::kContext, [&] {
        require(array && descriptor, "array or descriptor is null");
        *array = create({descriptor->Width, descriptor->Height, 0, descriptor->Format,
                         descriptor->NumChannels, 0});
    });
}
SUNSTONE_EXPORT CUresult cuArray3DCreate(CUarray* array,
                                         const CUDA_ARRAY3D_DESCRIPTOR* descriptor) {
    return guarded("cuArray3DCreate", Needs::kContext, [&] {
        require(array && descriptor, "array or descriptor is null");
        *array = create(*descriptor);
    });
}
SUNSTONE_EXPORT CUresult cuArrayGetDescriptor(CUDA_ARRAY_DESCRIPTOR* descriptor, CUarray array) {
    return guarded("cuArrayGetDescriptor", Needs::kObject, [&] {
        require(descriptor, "descriptor is null");
        const CUDA_ARRAY3D_DESCRIPTOR d = arrayOf(array)->descriptor;
        *descriptor = {d.Width, d.Height, d.Format, d.NumChannels};
    });
}
SUNSTONE_EXPORT CUresult cuArray3DGetDescriptor(CUDA_ARRAY3D_DESCRIPTOR* descriptor,
                                                CUarray array) {
    return guarded("cuArray3DGetDescriptor", Needs::kObject, [&] {
        require(descriptor, "descriptor is null");
        *descriptor = arrayOf(array)->descriptor;
    });
}
SUNSTONE_EXPORT CUresult cuArrayDestroy(CUarray array) {
    return guarded("cuArrayDestroy", Needs::kObject, [&] {
        require(!arrayOf(array)->isLevel, "a level goes with its mipmapped array");
        cpu::streams().synchronizeAll(); // queued work may use the array
        arrays().remove(array);
    });
}

SUNSTONE_EXPORT CUresult cuMipmappedArrayCreate(CUmipmappedArray* mipmap,
                                                const CUDA_ARRAY3D_DESCRIPTOR* descriptor,
                                                unsigned int levels) {
    return guarded("cuMipmappedArrayCreate", Needs::kContext, [&] {
        require(mipmap && descriptor, "mipmap or descriptor is null");
        checkFlags(descriptor->Flags);
        const texture::Shape shape = shapeOf(*descriptor);
        auto handle = std::make_shared<MipmapHandle>();
        handle->owner = cpu::contexts().current();
        // Levels beyond the size's are dropped and 0 means one, as in CUDA.
        const unsigned count = std::clamp(levels, 1u, texture::mostLevels(shape));
        for (unsigned level = 0; level < count; ++level)
            handle->levels.push_back(
                makeArray(*descriptor, texture::shapeOfLevel(shape, level), true));
        for (const auto& level : handle->levels)
            arrays().add(level);
        *mipmap = static_cast<CUmipmappedArray>(mipmaps().add(std::move(handle)));
    });
}
SUNSTONE_EXPORT CUresult cuMipmappedArrayGetLevel(CUarray* array, CUmipmappedArray mipmap,
                                                  unsigned int level) {
    return guarded("cuMipmappedArrayGetLevel", Needs::kObject, [&] {
        require(array, "array is null");
        const auto handle = mipmapOf(mipmap);
        require(level < handle->levels.size(), "the array has fewer levels");
        *array = static_cast<CUarray>(handle->levels[level]->handle());
    });
}
SUNSTONE_EXPORT CUresult cuMipmappedArrayDestroy(CUmipmappedArray mipmap) {
    return guarded("cuMipmappedArrayDestroy", Needs::kObject, [&] {
        mipmapOf(mipmap);
        cpu::streams().synchronizeAll();
        if (const auto handle = mipmaps().remove(mipmap))
            for (const auto& level : handle->levels)
                arrays().remove(level->handle());
    });
}
