// SPDX-License-Identifier: Apache-2.0
// Arrays and mipmapped arrays. See arrays.h.
#include "api/cuda/runtime/arrays.h"

#include <utility>

using namespace sunstone::cudart;

namespace sunstone::cudart {

namespace {

constexpr unsigned kBlockFormats = 0x91; // BC1; the enumerations of kinds and formats have one
                                         // order
constexpr unsigned kUnitFormats = 0xC0;  // 8-bit fractions of one channel

bool isBlockFormat(CUarray_format format) {
    return unsigned(format) >= kBlockFormats && unsigned(format) <= 0x9E;
}

unsigned channelBytes(CUarray_format format) {
    switch (unsigned(format)) {
    case CU_AD_FORMAT_UNSIGNED_INT8:
    case CU_AD_FORMAT_SIGNED_INT8:
        return 1;
    case CU_AD_FORMAT_UNSIGNED_INT16:
    case CU_AD_FORMAT_SIGNED_INT16:
    case CU_AD_FORMAT_HALF:
        return 2;
    case CU_AD_FORMAT_UNSIGNED_INT32:
    case CU_AD_FORMAT_SIGNED_INT32:
    case CU_AD_FORMAT_FLOAT:
        return 4;
    default:
        return (unsigned(format) - kUnitFormats) / 3 % 2 + 1; // fractions: 8 and 16 bits
    }
}

} // namespace

bool toFormat(const cudaChannelFormatDesc& desc, CUarray_format* format, unsigned* channels) {
    const int bits[4] = {desc.x, desc.y, desc.z, desc.w};
    unsigned count = 0;
    while (count < 4 && bits[count] > 0)
        ++count;
    for (unsigned i = 0; i < 4; ++i)
        if (bits[i] != (i < count ? bits[0] : 0))
            return false;
    *channels = count;
    const auto kind = unsigned(desc.f);
    if (kind >= cudaChannelFormatKindUnsignedNormalized8X1 &&
        kind <= cudaChannelFormatKindSignedNormalized16X4) {
        *format = CUarray_format(kUnitFormats + kind - cudaChannelFormatKindUnsignedNormalized8X1);
        return true;
    }
    if (kind >= cudaChannelFormatKindUnsignedBlockCompressed1 &&
        kind <= cudaChannelFormatKindUnsignedBlockCompressed7SRGB) {
        *format =
            CUarray_format(kBlockFormats + kind - cudaChannelFormatKindUnsignedBlockCompressed1);
        return true;
    }
    if (count != 1 && count != 2 && count != 4)
        return false;
    struct Row {
        cudaChannelFormatKind kind;
        int bits;
        CUarray_format format;
    };
    static const Row rows[] = {
        {cudaChannelFormatKindUnsigned, 8, CU_AD_FORMAT_UNSIGNED_INT8},
        {cudaChannelFormatKindUnsigned, 16, CU_AD_FORMAT_UNSIGNED_INT16},
        {cudaChannelFormatKindUnsigned, 32, CU_AD_FORMAT_UNSIGNED_INT32},
        {cudaChannelFormatKindSigned, 8, CU_AD_FORMAT_SIGNED_INT8},
        {cudaChannelFormatKindSigned, 16, CU_AD_FORMAT_SIGNED_INT16},
        {cudaChannelFormatKindSigned, 32, CU_AD_FORMAT_SIGNED_INT32},
        {cudaChannelFormatKindFloat, 16, CU_AD_FORMAT_HALF},
        {cudaChannelFormatKindFloat, 32, CU_AD_FORMAT_FLOAT},
    };
    for (const Row& row : rows)
        if (row.kind == desc.f && row.bits == bits[0]) {
            *format = row.format;
            return true;
        }
    return false;
}

cudaChannelFormatDesc toChannelDesc(CUarray_format format, unsigned channels) {
    cudaChannelFormatDesc desc = {};
    int bits = 8;
    if (isBlockFormat(format)) {
        desc.f = cudaChannelFormatKind(unsigned(format) - kBlockFormats +
                                       cudaChannelFormatKindUnsignedBlockCompressed1);
    } else {
        bits = int(channelBytes(format)) * 8;
        if (unsigned(format) >= kUnitFormats)
            desc.f = cudaChannelFormatKind(unsigned(format) - kUnitFormats +
                                           cudaChannelFormatKindUnsignedNormalized8X1);
        else
            desc.f = format == CU_AD_FORMAT_HALF || format == CU_AD_FORMAT_FLOAT
                         ? cudaChannelFormatKindFloat
                     : unsigned(format) >= CU_AD_FORMAT_SIGNED_INT8 ? cudaChannelFormatKindSigned
                                                                    : cudaChannelFormatKindUnsigned;
    }
    desc.x = bits;
    desc.y = channels > 1 ? bits : 0;
    desc.z = channels > 2 ? bits : 0;
    desc.w = channels > 3 ? bits : 0;
    return desc;
}

CUresult elementOf(const Driver& driver, cudaArray_const_t array, Element* element) {
    CUDA_ARRAY3D_DESCRIPTOR d = {};
    if (const CUresult result = driver.cuArray3DGetDescriptor(&d, arrayOf(array)))
        return result;
    if (isBlockFormat(d.Format)) {
        const unsigned number = unsigned(d.Format) - kBlockFormats;
        element->bytes = number < 2 || number == 6 || number == 7 ? 8 : 16; // BC1, BC4
        element->edge = 4;
    } else {
        element->bytes = size_t(channelBytes(d.Format)) * d.NumChannels;
    }
    return CUDA_SUCCESS;
}

CUmemorytype typeOf(cudaMemcpyKind kind, bool destination) {
    switch (kind) {
    case cudaMemcpyHostToHost:
        return CU_MEMORYTYPE_HOST;
    case cudaMemcpyHostToDevice:
        return destination ? CU_MEMORYTYPE_DEVICE : CU_MEMORYTYPE_HOST;
    case cudaMemcpyDeviceToHost:
        return destination ? CU_MEMORYTYPE_HOST : CU_MEMORYTYPE_DEVICE;
    case cudaMemcpyDeviceToDevice:
        return CU_MEMORYTYPE_DEVICE;
    default:
        return CU_MEMORYTYPE_UNIFIED;
    }
}

namespace {

// Elements that hold a width or a height; the last one may be used in part.
size_t elementsOf(size_t size, const Element& element) {
    return size / element.edge + (size % element.edge != 0);
}

// Sets what a copy counts in bytes along x. False if a product overflows.
bool setBytes(CUDA_MEMCPY3D& copy, const cudaMemcpy3DParms& parms, const Element& element) {
    const auto toBytes = [&](size_t elements, size_t& bytes) {
        return !__builtin_mul_overflow(elements, element.bytes, &bytes);
    };
    return toBytes(parms.srcPos.x / element.edge, copy.srcXInBytes) &&
           toBytes(parms.dstPos.x / element.edge, copy.dstXInBytes) &&
           toBytes(elementsOf(parms.extent.width, element), copy.WidthInBytes);
}

// One side: an array or a pitched block, not both.
cudaError_t checkSide(const cudaArray* array, const cudaPitchedPtr& block,
                      const cudaExtent& extent) {
    if ((array != nullptr) == (block.ptr != nullptr))
        return cudaErrorInvalidValue;
    const bool isLow = extent.width > block.pitch && extent.height > 1;
    const bool isFlat = extent.height > block.ysize && extent.depth > 1;
    return !array && (isLow || isFlat) ? cudaErrorInvalidPitchValue : cudaSuccess;
}

} // namespace

cudaError_t toDriver(const cudaMemcpy3DParms& parms, CUDA_MEMCPY3D* driverCopy) {
    if (unsigned(parms.kind) > cudaMemcpyDefault)
        return cudaErrorInvalidMemcpyDirection;
    const cudaExtent& extent = parms.extent;
    CUDA_MEMCPY3D& copy = *driverCopy;
    copy = {};
    if (extent.width == 0 || extent.height == 0 || extent.depth == 0)
        return cudaSuccess;
    if (const cudaError_t error = checkSide(parms.srcArray, parms.srcPtr, extent))
        return error;
    if (const cudaError_t error = checkSide(parms.dstArray, parms.dstPtr, extent))
        return error;
    if (parms.srcArray &&
        (parms.kind == cudaMemcpyHostToHost || parms.kind == cudaMemcpyHostToDevice))
        return cudaErrorInvalidValue;
    // In a copy with an array, sizes and positions count its elements, also those of blocks.
    Element srcElement, dstElement;
    for (const auto& [array, element] :
         {std::pair{parms.srcArray, &srcElement}, std::pair{parms.dstArray, &dstElement}})
        if (const CUresult result = array ? elementOf(driver(), array, element) : CUDA_SUCCESS)
            return fromDriver(result);
    const Element element = parms.srcArray ? srcElement : dstElement;
    if (parms.srcArray && parms.dstArray && srcElement.bytes != dstElement.bytes)
        return cudaErrorInvalidValue;
    copy.srcMemoryType = parms.srcArray ? CU_MEMORYTYPE_ARRAY : typeOf(parms.kind, false);
    copy.srcArray = arrayOf(parms.srcArray);
    copy.srcHost = parms.srcPtr.ptr;
    copy.srcDevice = addressOf(parms.srcPtr.ptr);
    copy.srcPitch = parms.srcPtr.pitch;
    copy.srcHeight = parms.srcPtr.ysize;
    copy.srcY = parms.srcPos.y / element.edge;
    copy.srcZ = parms.srcPos.z;
    copy.dstMemoryType = parms.dstArray ? CU_MEMORYTYPE_ARRAY : typeOf(parms.kind, true);
    copy.dstArray = arrayOf(parms.dstArray);
    copy.dstHost = parms.dstPtr.ptr;
    copy.dstDevice = addressOf(parms.dstPtr.ptr);
    copy.dstPitch = parms.dstPtr.pitch;
    copy.dstHeight = parms.dstPtr.ysize;
    copy.dstY = parms.dstPos.y / element.edge;
    copy.dstZ = parms.dstPos.z;
    copy.Height = elementsOf(extent.height, element);
    copy.Depth = extent.depth;
    return setBytes(copy, parms, element) ? cudaSuccess : cudaErrorInvalidValue;
}

} // namespace sunstone::cudart

namespace {

cudaError_t describe(const cudaChannelFormatDesc* desc, cudaExtent extent, unsigned flags,
                     CUDA_ARRAY3D_DESCRIPTOR* out) {
    *out = {extent.width, extent.height, extent.depth, CU_AD_FORMAT_FLOAT, 0, flags};
    if (!desc)
        return cudaErrorInvalidValue;
    return toFormat(*desc, &out->Format, &out->NumChannels) ? cudaSuccess
                                                            : cudaErrorInvalidChannelDescriptor;
}

cudaError_t allocate(cudaArray_t* array, const cudaChannelFormatDesc* desc, cudaExtent extent,
                     unsigned flags) {
    CUDA_ARRAY3D_DESCRIPTOR d;
    if (const cudaError_t error = describe(desc, extent, flags, &d))
        return remember(error);
    return call([&](const Driver& driver) {
        return driver.cuArray3DCreate(reinterpret_cast<CUarray*>(array), &d);
    });
}

} // namespace

SUNSTONE_CUDART struct cudaChannelFormatDesc cudaCreateChannelDesc(int x, int y, int z, int w,
                                                                   enum cudaChannelFormatKind f) {
    return {x, y, z, w, f};
}

SUNSTONE_CUDART cudaError_t cudaMallocArray(cudaArray_t* array,
                                            const struct cudaChannelFormatDesc* desc, size_t width,
                                            size_t height, unsigned int flags) {
    return allocate(array, desc, {width, height, 0}, flags);
}
SUNSTONE_CUDART cudaError_t cudaMalloc3DArray(cudaArray_t* array,
                                              const struct cudaChannelFormatDesc* desc,
                                              struct cudaExtent extent, unsigned int flags) {
    return allocate(array, desc, extent, flags);
}
SUNSTONE_CUDART cudaError_t cudaMallocMipmappedArray(cudaMipmappedArray_t* mipmap,
                                                     const struct cudaChannelFormatDesc* desc,
                                                     struct cudaExtent extent, unsigned int levels,
                                                     unsigned int flags) {
    CUDA_ARRAY3D_DESCRIPTOR d;
    if (const cudaError_t error = describe(desc, extent, flags, &d))
        return remember(error);
    return call([&](const Driver& driver) {
        return driver.cuMipmappedArrayCreate(reinterpret_cast<CUmipmappedArray*>(mipmap), &d,
                                             levels);
    });
}
SUNSTONE_CUDART cudaError_t cudaGetMipmappedArrayLevel(cudaArray_t* array,
                                                       cudaMipmappedArray_const_t mipmap,
                                                       unsigned int level) {
    return call([&](const Driver& driver) {
        return driver.cuMipmappedArrayGetLevel(reinterpret_cast<CUarray*>(array), mipmapOf(mipmap),
                                               level);
    });
}
SUNSTONE_CUDART cudaError_t cudaFreeArray(cudaArray_t array) {
    return call([&](const Driver& driver) {
        return array ? driver.cuArrayDestroy(arrayOf(array)) : CUDA_SUCCESS;
    });
}
SUNSTONE_CUDART cudaError_t cudaFreeMipmappedArray(cudaMipmappedArray_t mipmap) {
    return call([&](const Driver& driver) {
        return mipmap ? driver.cuMipmappedArrayDestroy(mipmapOf(mipmap)) : CUDA_SUCCESS;
    });
}
SUNSTONE_CUDART cudaError_t cudaArrayGetInfo(struct cudaChannelFormatDesc* desc,
                                             struct cudaExtent* extent, unsigned int* flags,
                                             cudaArray_t array) {
    return call([&](const Driver& driver) {
        CUDA_ARRAY3D_DESCRIPTOR d = {};
        const CUresult result = driver.cuArray3DGetDescriptor(&d, arrayOf(array));
        if (result)
            return result;
        if (desc)
            *desc = toChannelDesc(d.Format, d.NumChannels);
        if (extent)
            *extent = {d.Width, d.Height, d.Depth};
        if (flags)
            *flags = d.Flags;
        return CUDA_SUCCESS;
    });
}
SUNSTONE_CUDART cudaError_t cudaGetChannelDesc(struct cudaChannelFormatDesc* desc,
                                               cudaArray_const_t array) {
    if (!desc)
        return remember(cudaErrorInvalidValue);
    return cudaArrayGetInfo(desc, nullptr, nullptr, const_cast<cudaArray_t>(array));
}
