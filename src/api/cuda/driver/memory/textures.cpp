// SPDX-License-Identifier: Apache-2.0
// Texture and surface objects. Their descriptions are stored for queries.
#include "api/cuda/driver/memory/textures.h"

#include "api/cuda/driver/modules/image_limits.h"

#include <algorithm>
#include <map>
#include <mutex>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

struct Description {
    CUDA_RESOURCE_DESC resource = {};
    CUDA_TEXTURE_DESC texture = {};
    CUDA_RESOURCE_VIEW_DESC view = {};
    bool hasView = false;
};

class Descriptions {
public:
    void add(uint64_t handle, const Description& description) {
        std::lock_guard lock(mutex_);
        all_[handle] = description;
    }
    void remove(uint64_t handle) {
        std::lock_guard lock(mutex_);
        all_.erase(handle);
    }
    Description find(uint64_t handle) {
        std::lock_guard lock(mutex_);
        const auto found = all_.find(handle);
        if (found == all_.end())
            refuse(CUDA_ERROR_INVALID_VALUE, "no texture or surface ", handle);
        return found->second;
    }

private:
    std::mutex mutex_;
    std::map<uint64_t, Description> all_;
};

Descriptions& descriptions() {
    static auto* instance = new Descriptions;
    return *instance;
}

void useArrays(texture::Texture& texture, std::vector<std::shared_ptr<texture::Array>> arrays) {
    const texture::Array& first = *arrays.front();
    texture.format = first.format();
    texture.layered = first.shape().layered;
    texture.cube = first.shape().cube;
    texture.is3D = first.shape().depth != 0 && !texture.layered && !texture.cube;
    texture.levels = unsigned(std::min<size_t>(arrays.size(), texture::kMaxLevels));
    for (unsigned level = 0; level < texture.levels; ++level)
        texture.images[level] = arrays[level]->image();
    texture.arrays = std::move(arrays);
}

void requireMemory(CUdeviceptr address, size_t bytes, size_t alignment) {
    require(address != 0 && address % alignment == 0, "the address is null or misaligned");
    if (!cpu::memory().contains(reinterpret_cast<const void*>(address), bytes))
        refuse(CUDA_ERROR_INVALID_VALUE, reinterpret_cast<const void*>(address), " + ", bytes,
               " is in no allocation");
}

void useLinear(texture::Texture& texture, const CUDA_RESOURCE_DESC& resource) {
    const auto& linear = resource.res.linear;
    texture.format = formatOf(linear.format, linear.numChannels);
    require(!texture.format.isBlock(), "linear memory cannot hold blocks");
    const size_t element = texture.format.elementBytes();
    require(linear.sizeInBytes / element >= 1 && linear.sizeInBytes / element <= kMaxLinearTexels,
            "linear memory must hold 1 to 2^28 texels");
    requireMemory(linear.devPtr, linear.sizeInBytes, element);
    texture.linearMemory = true;
    texture.images[0] = {reinterpret_cast<const uint8_t*>(linear.devPtr),
                         uint32_t(linear.sizeInBytes / element),
                         1,
                         1,
                         linear.sizeInBytes,
                         linear.sizeInBytes};
}

void usePitched(texture::Texture& texture, const CUDA_RESOURCE_DESC& resource) {
    const auto& pitched = resource.res.pitch2D;
    texture.format = formatOf(pitched.format, pitched.numChannels);
    require(!texture.format.isBlock(), "pitched memory cannot hold blocks");
    const size_t element = texture.format.elementBytes();
    require(pitched.width >= 1 && pitched.width <= 131072 && pitched.height >= 1 &&
                pitched.height <= 131072,
            "width and height must be 1 to 131072");
    require(pitched.pitchInBytes >= pitched.width * element && pitched.pitchInBytes <= kMaxPitch &&
                pitched.pitchInBytes % 32 == 0,
            "the pitch is shorter than a row or no multiple of 32");
    requireMemory(pitched.devPtr,
                  pitched.pitchInBytes * (pitched.height - 1) + pitched.width * element, element);
    texture.images[0] = {reinterpret_cast<const uint8_t*>(pitched.devPtr),
                         uint32_t(pitched.width),
                         uint32_t(pitched.height),
                         1,
                         pitched.pitchInBytes,
                         pitched.pitchInBytes * pitched.height};
}

void useResource(texture::Texture& texture, const CUDA_RESOURCE_DESC& resource) {
    require(resource.flags == 0, "flags of a resource must be 0");
    switch (resource.resType) {
    case CU_RESOURCE_TYPE_ARRAY:
        return useArrays(texture, {arrayOf(resource.res.array.hArray)->array});
    case CU_RESOURCE_TYPE_MIPMAPPED_ARRAY: {
        std::vector<std::shared_ptr<texture::Array>> arrays;
        for (const auto& level : mipmapOf(resource.res.mipmap.hMipmappedArray)->levels)
            arrays.push_back(level->array);
        return useArrays(texture, std::move(arrays));
    }
    case CU_RESOURCE_TYPE_LINEAR:
        return useLinear(texture, resource);
    case CU_RESOURCE_TYPE_PITCH2D:
        return usePitched(texture, resource);
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "resource type ", int(resource.resType));
    }
}

void describe(texture::Texture& texture, const CUDA_TEXTURE_DESC& d) {
    constexpr unsigned kFlags = CU_TRSF_READ_AS_INTEGER | CU_TRSF_NORMALIZED_COORDINATES |
                                CU_TRSF_SRGB | CU_TRSF_DISABLE_TRILINEAR_OPTIMIZATION |
                                CU_TRSF_SEAMLESS_CUBEMAP;
    require((d.flags & ~kFlags) == 0, "unknown texture flags");
    for (unsigned i = 0; i < 3; ++i) {
        require(unsigned(d.addressMode[i]) <= CU_TR_ADDRESS_MODE_BORDER, "unknown address mode");
        texture.address[i] = texture::Address(d.addressMode[i]);
    }
    require(unsigned(d.filterMode) <= CU_TR_FILTER_MODE_LINEAR &&
                unsigned(d.mipmapFilterMode) <= CU_TR_FILTER_MODE_LINEAR,
            "unknown filter mode");
    texture.linear = d.filterMode == CU_TR_FILTER_MODE_LINEAR;
    texture.linearLevels = d.mipmapFilterMode == CU_TR_FILTER_MODE_LINEAR;
    texture.normalizedCoordinates = d.flags & CU_TRSF_NORMALIZED_COORDINATES;
    texture.srgb = d.flags & CU_TRSF_SRGB;
    texture.seamless = d.flags & CU_TRSF_SEAMLESS_CUBEMAP;
    // 32-bit integers are never read as fractions.
    texture.asFloat = !(d.flags & CU_TRSF_READ_AS_INTEGER) && texture.format.channelBytes() < 4;
    const bool integers =
        texture.format.isInteger() && !texture.asFloat && !texture.format.normalized;
    require(!texture.linear || !integers, "the linear filter needs texels that are read as floats");
    texture.levelBias = d.mipmapLevelBias;
    texture.minLevel = d.minMipmapLevelClamp;
    texture.maxLevel = d.maxMipmapLevelClamp;
    texture.anisotropy = std::clamp(d.maxAnisotropy, 1u, 16u);
    std::copy(d.borderColor, d.borderColor + 4, texture.border);
}

// The format in which a view reads texels. A view as blocks needs a resource with texels of two or
// four 32-bit integers.
texture::Format viewedFormat(CUresourceViewFormat format, const texture::Format& own) {
    constexpr CUarray_format kPlain[] = {CU_AD_FORMAT_UNSIGNED_INT8,  CU_AD_FORMAT_SIGNED_INT8,
                                         CU_AD_FORMAT_UNSIGNED_INT16, CU_AD_FORMAT_SIGNED_INT16,
                                         CU_AD_FORMAT_UNSIGNED_INT32, CU_AD_FORMAT_SIGNED_INT32,
                                         CU_AD_FORMAT_HALF,           CU_AD_FORMAT_FLOAT};
    constexpr struct {
        unsigned format, channels;
    } kBlocks[] = {{0x91, 4}, {0x93, 4}, {0x95, 4}, {0x97, 1}, {0x98, 1},
                   {0x99, 2}, {0x9A, 2}, {0x9B, 3}, {0x9C, 3}, {0x9D, 4}};
    const unsigned number = unsigned(format);
    require(number <= CU_RES_VIEW_FORMAT_UNSIGNED_BC7, "unknown format of a view");
    texture::Format viewed;
    if (number < CU_RES_VIEW_FORMAT_UNSIGNED_BC1) {
        viewed = formatOf(kPlain[(number - 1) / 3], 1u << (number - 1) % 3);
    } else {
        const auto& block = kBlocks[number - CU_RES_VIEW_FORMAT_UNSIGNED_BC1];
        viewed = formatOf(CUarray_format(block.format), block.channels);
        require(own.channel == texture::Channel::kU32 && !own.normalized,
                "a view of blocks needs texels of unsigned 32-bit integers");
    }
    require(!own.isBlock() && viewed.elementBytes() == own.elementBytes(),
            "the view's format has another size than the resource's");
    return viewed;
}

// Applies a view's format, levels and layers.
void applyView(texture::Texture& texture, const CUDA_RESOURCE_VIEW_DESC& view) {
    unsigned scale = 1;
    if (view.format != CU_RES_VIEW_FORMAT_NONE) {
        texture.format = viewedFormat(view.format, texture.format);
        scale = texture.format.edge();
        const texture::Image& whole = texture.images[0];
        require(view.width == size_t(whole.width) * scale &&
                    (view.height == size_t(whole.height) * scale ||
                     (whole.height == 1 && view.height == 0)),
                "the view's size must be the resource's, of blocks four times as much");
        for (unsigned level = 0; level < texture.levels; ++level) {
            texture.images[level].width *= scale;
            texture.images[level].height *= scale;
        }
    }
    if (view.firstLayer != 0 || view.lastLayer != 0) {
        const unsigned unit = texture.cube ? 6 : 1;
        require(texture.layered && view.firstLayer <= view.lastLayer &&
                    (size_t(view.lastLayer) + 1) * unit <= texture.images[0].depth,
                "the view has layers that the array has not");
        for (unsigned level = 0; level < texture.levels; ++level) {
            texture::Image& image = texture.images[level];
            image.data += image.slicePitch * view.firstLayer * unit;
            image.depth = (view.lastLayer - view.firstLayer + 1) * unit;
        }
    }
    require(view.firstMipmapLevel <= view.lastMipmapLevel && view.lastMipmapLevel < texture.levels,
            "the view has levels that the array has not");
    texture.levels = view.lastMipmapLevel - view.firstMipmapLevel + 1;
    std::copy(texture.images + view.firstMipmapLevel, texture.images + view.lastMipmapLevel + 1,
              texture.images);
}

void queuedWorkEnds() {
    cpu::streams().synchronizeAll();
}

} // namespace

namespace sunstone::api::cuda {

uint64_t createTexture(const CUDA_RESOURCE_DESC& resource, const CUDA_TEXTURE_DESC& description,
                       const CUDA_RESOURCE_VIEW_DESC* view) {
    auto texture = std::make_unique<texture::Texture>();
    useResource(*texture, resource);
    require(!view || resource.resType == CU_RESOURCE_TYPE_ARRAY ||
                resource.resType == CU_RESOURCE_TYPE_MIPMAPPED_ARRAY,
            "only arrays and mipmapped arrays can have a view");
    if (view)
        applyView(*texture, *view);
    describe(*texture, description);
    return texture::add(std::move(texture));
}

uint64_t createSurface(const CUDA_RESOURCE_DESC& resource) {
    require(resource.flags == 0, "flags of a resource must be 0");
    require(resource.resType == CU_RESOURCE_TYPE_ARRAY, "a surface needs an array");
    const auto array = arrayOf(resource.res.array.hArray);
    require(array->descriptor.Flags & CUDA_ARRAY3D_SURFACE_LDST,
            "the array was not made for surfaces (CUDA_ARRAY3D_SURFACE_LDST)");
    require(!array->array->format().isBlock(), "surfaces cannot hold blocks");
    auto surface = std::make_unique<texture::Surface>();
    surface->array = array->array;
    return texture::add(std::move(surface));
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuTexObjectCreate(CUtexObject* texture, const CUDA_RESOURCE_DESC* resource,
                                           const CUDA_TEXTURE_DESC* description,
                                           const CUDA_RESOURCE_VIEW_DESC* view) {
    return guarded("cuTexObjectCreate", Needs::kContext, [&] {
        require(texture && resource && description, "texture, resource or description is null");
        const uint64_t handle = createTexture(*resource, *description, view);
        descriptions().add(handle, {*resource, *description,
                                    view ? *view : CUDA_RESOURCE_VIEW_DESC{}, view != nullptr});
        *texture = handle;
    });
}
SUNSTONE_EXPORT CUresult cuTexObjectDestroy(CUtexObject texture) {
    return guarded("cuTexObjectDestroy", Needs::kContext, [&] {
        require(texture::findTexture(texture), "not a live texture");
        queuedWorkEnds();
        texture::removeTexture(texture);
        descriptions().remove(texture);
    });
}
SUNSTONE_EXPORT CUresult cuTexObjectGetResourceDesc(CUDA_RESOURCE_DESC* resource,
                                                    CUtexObject texture) {
    return guarded("cuTexObjectGetResourceDesc", Needs::kContext, [&] {
        require(resource && texture::findTexture(texture), "resource is null, or no live texture");
        *resource = descriptions().find(texture).resource;
    });
}
SUNSTONE_EXPORT CUresult cuTexObjectGetTextureDesc(CUDA_TEXTURE_DESC* description,
                                                   CUtexObject texture) {
    return guarded("cuTexObjectGetTextureDesc", Needs::kContext, [&] {
        require(description && texture::findTexture(texture),
                "description is null, or no live texture");
        *description = descriptions().find(texture).texture;
    });
}
SUNSTONE_EXPORT CUresult cuTexObjectGetResourceViewDesc(CUDA_RESOURCE_VIEW_DESC* view,
                                                        CUtexObject texture) {
    return guarded("cuTexObjectGetResourceViewDesc", Needs::kContext, [&] {
        require(view && texture::findTexture(texture), "view is null, or no live texture");
        const Description found = descriptions().find(texture);
        require(found.hasView, "the texture was made without a view");
        *view = found.view;
    });
}

SUNSTONE_EXPORT CUresult cuSurfObjectCreate(CUsurfObject* surface,
                                            const CUDA_RESOURCE_DESC* resource) {
    return guarded("cuSurfObjectCreate", Needs::kContext, [&] {
        require(surface && resource, "surface or resource is null");
        const uint64_t handle = createSurface(*resource);
        descriptions().add(handle, {*resource, {}, {}, false});
        *surface = handle;
    });
}
SUNSTONE_EXPORT CUresult cuSurfObjectDestroy(CUsurfObject surface) {
    return guarded("cuSurfObjectDestroy", Needs::kContext, [&] {
        require(texture::findSurface(surface), "not a live surface");
        queuedWorkEnds();
        texture::removeSurface(surface);
        descriptions().remove(surface);
    });
}
SUNSTONE_EXPORT CUresult cuSurfObjectGetResourceDesc(CUDA_RESOURCE_DESC* resource,
                                                     CUsurfObject surface) {
    return guarded("cuSurfObjectGetResourceDesc", Needs::kContext, [&] {
        require(resource && texture::findSurface(surface), "resource is null, or no live surface");
        *resource = descriptions().find(surface).resource;
    });
}
