// SPDX-License-Identifier: Apache-2.0
// A program that never clears its structs: members that a call does not use have arbitrary values.
#include "host.h"

#include <cstring>
#include <vector>

namespace {

template <class T>
T dirty() {
    T value;
    std::memset(&value, 0xCC, sizeof(value));
    return value;
}

} // namespace

int main() {
    CU(cuInit(0));
    CUcontext context;
    CU(cuDevicePrimaryCtxRetain(&context, 0));
    CU(cuCtxSetCurrent(context));
    constexpr unsigned kWidth = 37, kHeight = 5;
    std::vector<unsigned char> from(kWidth * kHeight), to(kWidth * kHeight);
    for (size_t i = 0; i < from.size(); ++i)
        from[i] = (unsigned char)(i * 7);
    CUdeviceptr memory;
    size_t pitch;
    CU(cuMemAllocPitch(&memory, &pitch, kWidth, kHeight, 4));

    CUDA_MEMCPY2D in = dirty<CUDA_MEMCPY2D>(); // no member of the kinds of memory not named
    in.srcXInBytes = in.srcY = in.dstXInBytes = in.dstY = 0;
    in.srcMemoryType = CU_MEMORYTYPE_HOST;
    in.srcHost = from.data();
    in.srcPitch = kWidth;
    in.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    in.dstDevice = memory;
    in.dstPitch = pitch;
    in.WidthInBytes = kWidth;
    in.Height = kHeight;
    CU(cuMemcpy2D(&in));

    CUDA_ARRAY_DESCRIPTOR shape = dirty<CUDA_ARRAY_DESCRIPTOR>();
    shape.Width = kWidth;
    shape.Height = kHeight;
    shape.Format = CU_AD_FORMAT_UNSIGNED_INT8;
    shape.NumChannels = 1;
    CUarray array;
    CU(cuArrayCreate(&array, &shape));
    CUDA_MEMCPY3D across = dirty<CUDA_MEMCPY3D>();
    across.srcXInBytes = across.srcY = across.srcZ = across.srcLOD = 0;
    across.dstXInBytes = across.dstY = across.dstZ = across.dstLOD = 0;
    across.reserved0 = across.reserved1 = nullptr;
    across.srcMemoryType = CU_MEMORYTYPE_DEVICE;
    across.srcDevice = memory;
    across.srcPitch = pitch;
    across.srcHeight = kHeight;
    across.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    across.dstArray = array;
    across.WidthInBytes = kWidth;
    across.Height = kHeight;
    across.Depth = 1;
    CU(cuMemcpy3D(&across));

    CUDA_RESOURCE_DESC resource = dirty<CUDA_RESOURCE_DESC>();
    resource.resType = CU_RESOURCE_TYPE_ARRAY;
    resource.res.array.hArray = array;
    resource.flags = 0;
    CUDA_TEXTURE_DESC texture;
    std::memset(&texture, 0, sizeof(texture));
    CUtexObject object;
    CU(cuTexObjectCreate(&object, &resource, &texture, nullptr));
    CUDA_RESOURCE_DESC back;
    CU(cuTexObjectGetResourceDesc(&back, object));
    bool right = back.resType == CU_RESOURCE_TYPE_ARRAY && back.res.array.hArray == array;
    CU(cuTexObjectDestroy(object));

    CUDA_MEMCPY2D out = dirty<CUDA_MEMCPY2D>();
    out.srcXInBytes = out.srcY = out.dstXInBytes = out.dstY = 0;
    out.srcMemoryType = CU_MEMORYTYPE_ARRAY;
    out.srcArray = array;
    out.dstMemoryType = CU_MEMORYTYPE_HOST;
    out.dstHost = to.data();
    out.dstPitch = kWidth;
    out.WidthInBytes = kWidth;
    out.Height = kHeight;
    CU(cuMemcpy2DUnaligned(&out));
    CU(cuArrayDestroy(array));
    CU(cuMemFree(memory));
    CU(cuDevicePrimaryCtxRelease(0));
    return finish(right && from == to);
}
