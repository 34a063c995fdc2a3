// SPDX-License-Identifier: Apache-2.0
// Texture and surface objects of the runtime API.
#include "api/cuda/runtime/arrays.h"

#include <algorithm>

using namespace sunstone::cudart;

namespace {

cudaError_t toDriver(const cudaResourceDesc& from, CUDA_RESOURCE_DESC* to) {
    *to = {};
    to->resType = CUresourcetype(from.resType);
    to->flags = from.flags;
    switch (from.resType) {
    case cudaResourceTypeArray:
        to->res.array.hArray = arrayOf(from.res.array.array);
        break;
    case cudaResourceTypeMipmappedArray:
        to->res.mipmap.hMipmappedArray = mipmapOf(from.res.mipmap.mipmap);
        break;
    case cudaResourceTypeLinear:
        to->res.linear.devPtr = addressOf(from.res.linear.devPtr);
        to->res.linear.sizeInBytes = from.res.linear.sizeInBytes;
        return toFormat(from.res.linear.desc, &to->res.linear.format, &to->res.linear.numChannels)
                   ? cudaSuccess
                   : cudaErrorInvalidChannelDescriptor;
    case cudaResourceTypePitch2D:
        to->res.pitch2D.devPtr = addressOf(from.res.pitch2D.devPtr);
        to->res.pitch2D.width = from.res.pitch2D.width;
        to->res.pitch2D.height = from.res.pitch2D.height;
        to->res.pitch2D.pitchInBytes = from.res.pitch2D.pitchInBytes;
        return toFormat(from.res.pitch2D.desc, &to->res.pitch2D.format,
                        &to->res.pitch2D.numChannels)
                   ? cudaSuccess
                   : cudaErrorInvalidChannelDescriptor;
    default:
        return cudaErrorInvalidValue;
    }
    return cudaSuccess;
}

cudaResourceDesc fromDriver(const CUDA_RESOURCE_DESC& from) {
    cudaResourceDesc to = {};
    to.resType = cudaResourceType(from.resType);
    to.flags = from.flags;
    switch (from.resType) {
    case CU_RESOURCE_TYPE_ARRAY:
        to.res.array.array = reinterpret_cast<cudaArray_t>(from.res.array.hArray);
        break;
    case CU_RESOURCE_TYPE_MIPMAPPED_ARRAY:
        to.res.mipmap.mipmap =
            reinterpret_cast<cudaMipmappedArray_t>(from.res.mipmap.hMipmappedArray);
        break;
    case CU_RESOURCE_TYPE_LINEAR:
        to.res.linear.devPtr = reinterpret_cast<void*>(from.res.linear.devPtr);
        to.res.linear.sizeInBytes = from.res.linear.sizeInBytes;
        to.res.linear.desc = toChannelDesc(from.res.linear.format, from.res.linear.numChannels);
        break;
    default:
        to.res.pitch2D.devPtr = reinterpret_cast<void*>(from.res.pitch2D.devPtr);
        to.res.pitch2D.width = from.res.pitch2D.width;
        to.res.pitch2D.height = from.res.pitch2D.height;
        to.res.pitch2D.pitchInBytes = from.res.pitch2D.pitchInBytes;
        to.res.pitch2D.desc = toChannelDesc(from.res.pitch2D.format, from.res.pitch2D.numChannels);
    }
    return to;
}

CUDA_TEXTURE_DESC toDriver(const cudaTextureDesc& from) {
    CUDA_TEXTURE_DESC to = {};
    for (int i = 0; i < 3; ++i)
        to.addressMode[i] = CUaddress_mode(from.addressMode[i]);
    to.filterMode = CUfilter_mode(from.filterMode);
    to.flags = (from.readMode == cudaReadModeElementType ? CU_TRSF_READ_AS_INTEGER : 0u) |
               (from.normalizedCoords ? CU_TRSF_NORMALIZED_COORDINATES : 0u) |
               (from.sRGB ? CU_TRSF_SRGB : 0u) |
               (from.disableTrilinearOptimization ? CU_TRSF_DISABLE_TRILINEAR_OPTIMIZATION : 0u) |
               (from.seamlessCubemap ? CU_TRSF_SEAMLESS_CUBEMAP : 0u);
    to.maxAnisotropy = from.maxAnisotropy;
    to.mipmapFilterMode = CUfilter_mode(from.mipmapFilterMode);
    to.mipmapLevelBias = from.mipmapLevelBias;
    to.minMipmapLevelClamp = from.minMipmapLevelClamp;
    to.maxMipmapLevelClamp = from.maxMipmapLevelClamp;
    std::copy(from.borderColor, from.borderColor + 4, to.borderColor);
    return to;
}

cudaTextureDesc fromDriver(const CUDA_TEXTURE_DESC& from) {
    cudaTextureDesc to = {};
    for (int i = 0; i < 3; ++i)
        to.addressMode[i] = cudaTextureAddressMode(from.addressMode[i]);
    to.filterMode = cudaTextureFilterMode(from.filterMode);
    to.readMode = from.flags & CU_TRSF_READ_AS_INTEGER ? cudaReadModeElementType
                                                       : cudaReadModeNormalizedFloat;
    to.normalizedCoords = (from.flags & CU_TRSF_NORMALIZED_COORDINATES) != 0;
    to.sRGB = (from.flags & CU_TRSF_SRGB) != 0;
    to.disableTrilinearOptimization = (from.flags & CU_TRSF_DISABLE_TRILINEAR_OPTIMIZATION) != 0;
    to.seamlessCubemap = (from.flags & CU_TRSF_SEAMLESS_CUBEMAP) != 0;
    to.maxAnisotropy = from.maxAnisotropy;
    to.mipmapFilterMode = cudaTextureFilterMode(from.mipmapFilterMode);
    to.mipmapLevelBias = from.mipmapLevelBias;
    to.minMipmapLevelClamp = from.minMipmapLevelClamp;
    to.maxMipmapLevelClamp = from.maxMipmapLevelClamp;
    std::copy(from.borderColor, from.borderColor + 4, to.borderColor);
    return to;
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaCreateTextureObject(cudaTextureObject_t* texture,
                                                    const struct cudaResourceDesc* resource,
                                                    const struct cudaTextureDesc* description,
                                                    const struct cudaResourceViewDesc* view) {
    if (!resource || !description || unsigned(description->readMode) > cudaReadModeNormalizedFloat)
        return remember(cudaErrorInvalidValue);
    CUDA_RESOURCE_DESC driverResource;
    if (const cudaError_t error = toDriver(*resource, &driverResource))
        return remember(error);
    const CUDA_TEXTURE_DESC driverTexture = toDriver(*description);
    CUDA_RESOURCE_VIEW_DESC driverView = {};
    if (view)
        driverView = {CUresourceViewFormat(view->format),
                      view->width,
                      view->height,
                      view->depth,
                      view->firstMipmapLevel,
                      view->lastMipmapLevel,
                      view->firstLayer,
                      view->lastLayer,
                      {}};
    return call([&](const Driver& driver) {
        return driver.cuTexObjectCreate(texture, &driverResource, &driverTexture,
                                        view ? &driverView : nullptr);
    });
}
SUNSTONE_CUDART cudaError_t cudaDestroyTextureObject(cudaTextureObject_t texture) {
    return call([&](const Driver& driver) {
        return texture ? driver.cuTexObjectDestroy(texture) : CUDA_SUCCESS;
    });
}
SUNSTONE_CUDART cudaError_t cudaGetTextureObjectResourceDesc(struct cudaResourceDesc* resource,
                                                             cudaTextureObject_t texture) {
    if (!resource)
        return remember(cudaErrorInvalidValue);
    return call([&](const Driver& driver) {
        CUDA_RESOURCE_DESC d = {};
        const CUresult result = driver.cuTexObjectGetResourceDesc(&d, texture);
        if (!result)
            *resource = fromDriver(d);
        return result;
    });
}
SUNSTONE_CUDART cudaError_t cudaGetTextureObjectTextureDesc(struct cudaTextureDesc* description,
                                                            cudaTextureObject_t texture) {
    if (!description)
        return remember(cudaErrorInvalidValue);
    return call([&](const Driver& driver) {
        CUDA_TEXTURE_DESC d = {};
        const CUresult result = driver.cuTexObjectGetTextureDesc(&d, texture);
        if (!result)
            *description = fromDriver(d);
        return result;
    });
}

SUNSTONE_CUDART cudaError_t cudaGetTextureObjectResourceViewDesc(struct cudaResourceViewDesc* view,
                                                                 cudaTextureObject_t texture) {
    if (!view)
        return remember(cudaErrorInvalidValue);
    return call([&](const Driver& driver) {
        CUDA_RESOURCE_VIEW_DESC d = {};
        const CUresult result = driver.cuTexObjectGetResourceViewDesc
                                    ? driver.cuTexObjectGetResourceViewDesc(&d, texture)
                                    : CUDA_ERROR_NOT_SUPPORTED;
        if (!result)
            *view = {cudaResourceViewFormat(d.format),
                     d.width,
                     d.height,
                     d.depth,
                     d.firstMipmapLevel,
                     d.lastMipmapLevel,
                     d.firstLayer,
                     d.lastLayer,
                     {}};
        return result;
    });
}
SUNSTONE_CUDART cudaError_t cudaCreateSurfaceObject(cudaSurfaceObject_t* surface,
                                                    const struct cudaResourceDesc* resource) {
    if (!resource)
        return remember(cudaErrorInvalidValue);
    CUDA_RESOURCE_DESC driverResource;
    if (const cudaError_t error = toDriver(*resource, &driverResource))
        return remember(error);
    return call(
        [&](const Driver& driver) { return driver.cuSurfObjectCreate(surface, &driverResource); });
}
SUNSTONE_CUDART cudaError_t cudaDestroySurfaceObject(cudaSurfaceObject_t surface) {
    return call([&](const Driver& driver) {
        return surface ? driver.cuSurfObjectDestroy(surface) : CUDA_SUCCESS;
    });
}
SUNSTONE_CUDART cudaError_t cudaGetSurfaceObjectResourceDesc(struct cudaResourceDesc* resource,
                                                             cudaSurfaceObject_t surface) {
    if (!resource)
        return remember(cudaErrorInvalidValue);
    return call([&](const Driver& driver) {
        CUDA_RESOURCE_DESC d = {};
        const CUresult result = driver.cuSurfObjectGetResourceDesc(&d, surface);
        if (!result)
            *resource = fromDriver(d);
        return result;
    });
}
