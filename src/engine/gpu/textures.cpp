// SPDX-License-Identifier: Apache-2.0
// Textures of Backend::addTexture: CUDA arrays with copies of the images, and texture objects.
#include "base/error.h"
#include "engine/gpu/backend.h"
#include "texture/texture.h"

namespace sunstone::engine {

using namespace device::cuda;
using texture::Channel;

namespace {

CUarray_format formatOf(const texture::Format& format) {
    switch (format.channel) {
    case Channel::kU8:
        return CU_AD_FORMAT_UNSIGNED_INT8;
    case Channel::kU16:
        return CU_AD_FORMAT_UNSIGNED_INT16;
    case Channel::kS8:
        return CU_AD_FORMAT_SIGNED_INT8;
    case Channel::kS16:
        return CU_AD_FORMAT_SIGNED_INT16;
    case Channel::kS32:
        return CU_AD_FORMAT_SIGNED_INT32;
    case Channel::kF16:
        return CU_AD_FORMAT_HALF;
    case Channel::kF32:
        return CU_AD_FORMAT_FLOAT;
    default: // the words of block formats, too
        return CU_AD_FORMAT_UNSIGNED_INT32;
    }
}

CUresourceViewFormat viewOf(Channel channel) {
    static_assert(CU_RES_VIEW_FORMAT_UNSIGNED_BC7 - CU_RES_VIEW_FORMAT_UNSIGNED_BC1 ==
                  int(Channel::kBC7) - int(Channel::kBC1));
    return CUresourceViewFormat(CU_RES_VIEW_FORMAT_UNSIGNED_BC1 + int(channel) -
                                int(Channel::kBC1));
}

size_t elements(uint32_t texels, const texture::Format& format) {
    return (texels + format.edge() - 1) / format.edge();
}

CUDA_ARRAY3D_DESCRIPTOR arrayOf(const texture::Texture& texture) {
    const texture::Image& image = texture.images[0];
    CUDA_ARRAY3D_DESCRIPTOR array{};
    array.Width = elements(image.width, texture.format);
    array.Height = texture.hasLines ? 0 : elements(image.height, texture.format);
    array.Depth = texture.is3D || texture.layered || texture.cube ? image.depth : 0;
    array.Format = formatOf(texture.format);
    array.NumChannels =
        texture.format.isBlock() ? texture.format.elementBytes() / 4 : texture.format.channels;
    array.Flags =
        (texture.layered ? CUDA_ARRAY3D_LAYERED : 0) | (texture.cube ? CUDA_ARRAY3D_CUBEMAP : 0);
    return array;
}

void copyLevel(CUmipmappedArray array, const texture::Texture& texture, unsigned level) {
    const texture::Image& image = texture.images[level];
    CUarray to = nullptr;
    SUNSTONE_CU(mipmappedArrayGetLevel, &to, array, level);
    CUDA_MEMCPY3D copy{};
    copy.srcMemoryType = CU_MEMORYTYPE_UNIFIED;
    copy.srcDevice = CUdeviceptr(image.data);
    copy.srcPitch = image.rowPitch;
    copy.srcHeight = elements(image.height, texture.format);
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = to;
    copy.WidthInBytes = elements(image.width, texture.format) * texture.format.elementBytes();
    copy.Height = copy.srcHeight;
    copy.Depth = image.depth;
    SUNSTONE_CU(memcpy3D, &copy);
}

CUDA_TEXTURE_DESC samplingOf(const texture::Texture& texture) {
    CUDA_TEXTURE_DESC d{};
    for (unsigned i = 0; i < 3; ++i)
        d.addressMode[i] = CUaddress_mode(unsigned(texture.address[i]));
    d.filterMode = texture.linear ? CU_TR_FILTER_MODE_LINEAR : CU_TR_FILTER_MODE_POINT;
    d.mipmapFilterMode = texture.linearLevels ? CU_TR_FILTER_MODE_LINEAR : CU_TR_FILTER_MODE_POINT;
    const bool asIntegers = texture.format.isInteger() && !texture.asFloat;
    d.flags = (asIntegers ? CU_TRSF_READ_AS_INTEGER : 0) |
              (texture.normalizedCoordinates ? CU_TRSF_NORMALIZED_COORDINATES : 0) |
              (texture.srgb ? CU_TRSF_SRGB : 0) | (texture.seamless ? CU_TRSF_SEAMLESS_CUBEMAP : 0);
    d.maxAnisotropy = texture.anisotropy;
    d.mipmapLevelBias = texture.levelBias;
    d.minMipmapLevelClamp = texture.minLevel;
    d.maxMipmapLevelClamp = texture.maxLevel;
    for (unsigned i = 0; i < 4; ++i)
        d.borderColor[i] = texture.border[i];
    return d;
}

CUDA_RESOURCE_VIEW_DESC blockView(const texture::Texture& texture) {
    const texture::Image& image = texture.images[0];
    CUDA_RESOURCE_VIEW_DESC view{};
    view.format = viewOf(texture.format.channel);
    view.width = elements(image.width, texture.format) * texture.format.edge();
    view.height = elements(image.height, texture.format) * texture.format.edge();
    const bool slices = texture.is3D || texture.layered || texture.cube;
    view.depth = slices ? image.depth : 0;
    view.lastMipmapLevel = texture.levels - 1;
    view.lastLayer = texture.layered || texture.cube ? image.depth - 1 : 0;
    return view;
}

} // namespace

uint64_t GpuBackend::addTexture(std::unique_ptr<texture::Texture> texture) {
    ContextScope scope(device_.context());
    const CUDA_ARRAY3D_DESCRIPTOR description = arrayOf(*texture);
    CUmipmappedArray array = nullptr;
    SUNSTONE_CU(mipmappedArrayCreate, &array, &description, texture->levels);
    try {
        for (unsigned level = 0; level < texture->levels; ++level)
            copyLevel(array, *texture, level);
        CUDA_RESOURCE_DESC resource{};
        resource.resType = CU_RESOURCE_TYPE_MIPMAPPED_ARRAY;
        resource.res.mipmap.hMipmappedArray = array;
        const CUDA_TEXTURE_DESC sampling = samplingOf(*texture);
        const CUDA_RESOURCE_VIEW_DESC view = blockView(*texture);
        CUtexObject object = 0;
        SUNSTONE_CU(texObjectCreate, &object, &resource, &sampling,
                    texture->format.isBlock() ? &view : nullptr);
        std::lock_guard lock(textureMutex_);
        textures_[object] = array;
        return object;
    } catch (...) {
        driver().mipmappedArrayDestroy(array);
        throw;
    }
}

void GpuBackend::removeTexture(uint64_t handle) noexcept {
    try {
        ContextScope scope(device_.context());
        std::lock_guard lock(textureMutex_);
        const auto found = textures_.find(handle);
        if (found == textures_.end())
            return;
        driver().texObjectDestroy(handle);
        driver().mipmappedArrayDestroy(found->second);
        textures_.erase(found);
    } catch (const Error&) { // the application has destroyed its context, and textures with it
    }
}

} // namespace sunstone::engine
