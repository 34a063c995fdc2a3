// SPDX-License-Identifier: Apache-2.0
// Texture functions of the classic API. A function becomes the texture instruction of its form,
// with the handle that the library has for the sampler's id. Source: OptiX 6.0 API reference,
// section 5.25.
#ifndef SUNSTONE_OPTIX6_DEVICE_TEXTURES_H
#define SUNSTONE_OPTIX6_DEVICE_TEXTURES_H

#include "optix_internal.h"

#ifndef SUNSTONE_OPTIX_DEVICE
#define SUNSTONE_OPTIX_DEVICE static __forceinline__ __device__
#endif

namespace optix {

typedef int rtTextureId;

SUNSTONE_OPTIX_DEVICE int4 float4AsInt4(float4 f4) {
    int4 result = {__float_as_int(f4.x), __float_as_int(f4.y), __float_as_int(f4.z),
                   __float_as_int(f4.w)};
    return result;
}
SUNSTONE_OPTIX_DEVICE uint4 float4AsUInt4(float4 f4) {
    uint4 result = {(unsigned int)__float_as_int(f4.x), (unsigned int)__float_as_int(f4.y),
                    (unsigned int)__float_as_int(f4.z), (unsigned int)__float_as_int(f4.w)};
    return result;
}

SUNSTONE_OPTIX_DEVICE uint3 rtTexSize(rtTextureId id) {
    const unsigned long long handle = rt_texture_handle(id);
    uint3 size;
    asm("txq.width.b32 %0, [%1];" : "=r"(size.x) : "l"(handle));
    asm("txq.height.b32 %0, [%1];" : "=r"(size.y) : "l"(handle));
    asm("txq.depth.b32 %0, [%1];" : "=r"(size.z) : "l"(handle));
    // GPUs report 0 for missing dimensions.
    size.y = size.y ? size.y : 1;
    size.z = size.z ? size.z : 1;
    return size;
}

namespace sunstone {

// The type that fetches a component type, and the construction of a vector from the components.
template <typename T>
struct Fetched;
template <>
struct Fetched<char> {
    typedef int4 Wide;
    static __device__ __forceinline__ char from(Wide v) { return (char)v.x; }
};
template <>
struct Fetched<char1> {
    typedef int4 Wide;
    static __device__ __forceinline__ char1 from(Wide v) {
        char1 result = {(signed char)v.x};
        return result;
    }
};
template <>
struct Fetched<char2> {
    typedef int4 Wide;
    static __device__ __forceinline__ char2 from(Wide v) {
        char2 result = {(signed char)v.x, (signed char)v.y};
        return result;
    }
};
template <>
struct Fetched<char4> {
    typedef int4 Wide;
    static __device__ __forceinline__ char4 from(Wide v) {
        char4 result = {(signed char)v.x, (signed char)v.y, (signed char)v.z, (signed char)v.w};
        return result;
    }
};
template <>
struct Fetched<unsigned char> {
    typedef uint4 Wide;
    static __device__ __forceinline__ unsigned char from(Wide v) { return (unsigned char)v.x; }
};
template <>
struct Fetched<uchar1> {
    typedef uint4 Wide;
    static __device__ __forceinline__ uchar1 from(Wide v) {
        uchar1 result = {(unsigned char)v.x};
        return result;
    }
};
template <>
struct Fetched<uchar2> {
    typedef uint4 Wide;
    static __device__ __forceinline__ uchar2 from(Wide v) {
        uchar2 result = {(unsigned char)v.x, (unsigned char)v.y};
        return result;
    }
};
template <>
struct Fetched<uchar4> {
    typedef uint4 Wide;
    static __device__ __forceinline__ uchar4 from(Wide v) {
        uchar4 result = {(unsigned char)v.x, (unsigned char)v.y, (unsigned char)v.z,
                         (unsigned char)v.w};
        return result;
    }
};
template <>
struct Fetched<short> {
    typedef int4 Wide;
    static __device__ __forceinline__ short from(Wide v) { return (short)v.x; }
};
template <>
struct Fetched<short1> {
    typedef int4 Wide;
    static __device__ __forceinline__ short1 from(Wide v) {
        short1 result = {(short)v.x};
        return result;
    }
};
template <>
struct Fetched<short2> {
    typedef int4 Wide;
    static __device__ __forceinline__ short2 from(Wide v) {
        short2 result = {(short)v.x, (short)v.y};
        return result;
    }
};
template <>
struct Fetched<short4> {
    typedef int4 Wide;
    static __device__ __forceinline__ short4 from(Wide v) {
        short4 result = {(short)v.x, (short)v.y, (short)v.z, (short)v.w};
        return result;
    }
};
template <>
struct Fetched<unsigned short> {
    typedef uint4 Wide;
    static __device__ __forceinline__ unsigned short from(Wide v) { return (unsigned short)v.x; }
};
template <>
struct Fetched<ushort1> {
    typedef uint4 Wide;
    static __device__ __forceinline__ ushort1 from(Wide v) {
        ushort1 result = {(unsigned short)v.x};
        return result;
    }
};
template <>
struct Fetched<ushort2> {
    typedef uint4 Wide;
    static __device__ __forceinline__ ushort2 from(Wide v) {
        ushort2 result = {(unsigned short)v.x, (unsigned short)v.y};
        return result;
    }
};
template <>
struct Fetched<ushort4> {
    typedef uint4 Wide;
    static __device__ __forceinline__ ushort4 from(Wide v) {
        ushort4 result = {(unsigned short)v.x, (unsigned short)v.y, (unsigned short)v.z,
                          (unsigned short)v.w};
        return result;
    }
};
template <>
struct Fetched<int> {
    typedef int4 Wide;
    static __device__ __forceinline__ int from(Wide v) { return (int)v.x; }
};
template <>
struct Fetched<int1> {
    typedef int4 Wide;
    static __device__ __forceinline__ int1 from(Wide v) {
        int1 result = {(int)v.x};
        return result;
    }
};
template <>
struct Fetched<int2> {
    typedef int4 Wide;
    static __device__ __forceinline__ int2 from(Wide v) {
        int2 result = {(int)v.x, (int)v.y};
        return result;
    }
};
template <>
struct Fetched<int4> {
    typedef int4 Wide;
    static __device__ __forceinline__ int4 from(Wide v) {
        int4 result = {(int)v.x, (int)v.y, (int)v.z, (int)v.w};
        return result;
    }
};
template <>
struct Fetched<unsigned int> {
    typedef uint4 Wide;
    static __device__ __forceinline__ unsigned int from(Wide v) { return (unsigned int)v.x; }
};
template <>
struct Fetched<uint1> {
    typedef uint4 Wide;
    static __device__ __forceinline__ uint1 from(Wide v) {
        uint1 result = {(unsigned int)v.x};
        return result;
    }
};
template <>
struct Fetched<uint2> {
    typedef uint4 Wide;
    static __device__ __forceinline__ uint2 from(Wide v) {
        uint2 result = {(unsigned int)v.x, (unsigned int)v.y};
        return result;
    }
};
template <>
struct Fetched<uint4> {
    typedef uint4 Wide;
    static __device__ __forceinline__ uint4 from(Wide v) {
        uint4 result = {(unsigned int)v.x, (unsigned int)v.y, (unsigned int)v.z, (unsigned int)v.w};
        return result;
    }
};
template <>
struct Fetched<float> {
    typedef float4 Wide;
    static __device__ __forceinline__ float from(Wide v) { return (float)v.x; }
};
template <>
struct Fetched<float1> {
    typedef float4 Wide;
    static __device__ __forceinline__ float1 from(Wide v) {
        float1 result = {(float)v.x};
        return result;
    }
};
template <>
struct Fetched<float2> {
    typedef float4 Wide;
    static __device__ __forceinline__ float2 from(Wide v) {
        float2 result = {(float)v.x, (float)v.y};
        return result;
    }
};
template <>
struct Fetched<float4> {
    typedef float4 Wide;
    static __device__ __forceinline__ float4 from(Wide v) {
        float4 result = {(float)v.x, (float)v.y, (float)v.z, (float)v.w};
        return result;
    }
};

} // namespace sunstone

namespace sunstone {

// One texture instruction for each type of result. A texture of one dimension is a row of one of
// two: arrays of one dimension have no lookups by integers.
__device__ __forceinline__ void fetch1D(float4& v, unsigned long long handle, float x) {
    asm volatile("tex.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x));
}
__device__ __forceinline__ void fetch1D(int4& v, unsigned long long handle, float x) {
    asm volatile("tex.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x));
}
__device__ __forceinline__ void fetch1D(uint4& v, unsigned long long handle, float x) {
    asm volatile("tex.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x));
}
__device__ __forceinline__ void fetch2D(float4& v, unsigned long long handle, float x, float y) {
    asm volatile("tex.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetch2D(int4& v, unsigned long long handle, float x, float y) {
    asm volatile("tex.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetch2D(uint4& v, unsigned long long handle, float x, float y) {
    asm volatile("tex.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetch3D(float4& v, unsigned long long handle, float x, float y,
                                        float z) {
    asm volatile("tex.3d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetch3D(int4& v, unsigned long long handle, float x, float y,
                                        float z) {
    asm volatile("tex.3d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetch3D(uint4& v, unsigned long long handle, float x, float y,
                                        float z) {
    asm volatile("tex.3d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetch1DFetch(float4& v, unsigned long long handle, int x) {
    asm volatile("tex.2d.v4.f32.s32 {%0, %1, %2, %3}, [%4, {%5, 0}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(x));
}
__device__ __forceinline__ void fetch1DFetch(int4& v, unsigned long long handle, int x) {
    asm volatile("tex.2d.v4.s32.s32 {%0, %1, %2, %3}, [%4, {%5, 0}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(x));
}
__device__ __forceinline__ void fetch1DFetch(uint4& v, unsigned long long handle, int x) {
    asm volatile("tex.2d.v4.u32.s32 {%0, %1, %2, %3}, [%4, {%5, 0}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(x));
}
__device__ __forceinline__ void fetch2DFetch(float4& v, unsigned long long handle, int x, int y) {
    asm volatile("tex.2d.v4.f32.s32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(x), "r"(y));
}
__device__ __forceinline__ void fetch2DFetch(int4& v, unsigned long long handle, int x, int y) {
    asm volatile("tex.2d.v4.s32.s32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(x), "r"(y));
}
__device__ __forceinline__ void fetch2DFetch(uint4& v, unsigned long long handle, int x, int y) {
    asm volatile("tex.2d.v4.u32.s32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(x), "r"(y));
}
__device__ __forceinline__ void fetch3DFetch(float4& v, unsigned long long handle, int x, int y,
                                             int z) {
    asm volatile("tex.3d.v4.f32.s32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(x), "r"(y), "r"(z));
}
__device__ __forceinline__ void fetch3DFetch(int4& v, unsigned long long handle, int x, int y,
                                             int z) {
    asm volatile("tex.3d.v4.s32.s32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(x), "r"(y), "r"(z));
}
__device__ __forceinline__ void fetch3DFetch(uint4& v, unsigned long long handle, int x, int y,
                                             int z) {
    asm volatile("tex.3d.v4.u32.s32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(x), "r"(y), "r"(z));
}
__device__ __forceinline__ void fetch1DGrad(float4& v, unsigned long long handle, float x,
                                            float dPdx, float dPdy) {
    asm volatile("tex.grad.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}], {%6, "
                 "0f00000000}, {%7, 0f00000000};"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(dPdx), "f"(dPdy));
}
__device__ __forceinline__ void fetch1DGrad(int4& v, unsigned long long handle, float x, float dPdx,
                                            float dPdy) {
    asm volatile("tex.grad.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}], {%6, "
                 "0f00000000}, {%7, 0f00000000};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(dPdx), "f"(dPdy));
}
__device__ __forceinline__ void fetch1DGrad(uint4& v, unsigned long long handle, float x,
                                            float dPdx, float dPdy) {
    asm volatile("tex.grad.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}], {%6, "
                 "0f00000000}, {%7, 0f00000000};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(dPdx), "f"(dPdy));
}
__device__ __forceinline__ void fetch2DGrad(float4& v, unsigned long long handle, float x, float y,
                                            float2 dPdx, float2 dPdy) {
    asm volatile("tex.grad.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], {%7, %8}, {%9, %10};"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdy.x), "f"(dPdy.y));
}
__device__ __forceinline__ void fetch2DGrad(int4& v, unsigned long long handle, float x, float y,
                                            float2 dPdx, float2 dPdy) {
    asm volatile("tex.grad.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], {%7, %8}, {%9, %10};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdy.x), "f"(dPdy.y));
}
__device__ __forceinline__ void fetch2DGrad(uint4& v, unsigned long long handle, float x, float y,
                                            float2 dPdx, float2 dPdy) {
    asm volatile("tex.grad.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], {%7, %8}, {%9, %10};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdy.x), "f"(dPdy.y));
}
__device__ __forceinline__ void fetch3DGrad(float4& v, unsigned long long handle, float x, float y,
                                            float z, float4 dPdx, float4 dPdy) {
    asm volatile("tex.grad.3d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], {%8, %9, %10, "
                 "%10}, {%11, %12, %13, %13};"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdx.z),
                   "f"(dPdy.x), "f"(dPdy.y), "f"(dPdy.z));
}
__device__ __forceinline__ void fetch3DGrad(int4& v, unsigned long long handle, float x, float y,
                                            float z, float4 dPdx, float4 dPdy) {
    asm volatile("tex.grad.3d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], {%8, %9, %10, "
                 "%10}, {%11, %12, %13, %13};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdx.z),
                   "f"(dPdy.x), "f"(dPdy.y), "f"(dPdy.z));
}
__device__ __forceinline__ void fetch3DGrad(uint4& v, unsigned long long handle, float x, float y,
                                            float z, float4 dPdx, float4 dPdy) {
    asm volatile("tex.grad.3d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], {%8, %9, %10, "
                 "%10}, {%11, %12, %13, %13};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdx.z),
                   "f"(dPdy.x), "f"(dPdy.y), "f"(dPdy.z));
}
__device__ __forceinline__ void fetch1DLayeredGrad(float4& v, unsigned long long handle, float x,
                                                   int layer, float dPdx, float dPdy) {
    asm volatile("tex.grad.a1d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], {%7}, {%8};"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(dPdx), "f"(dPdy));
}
__device__ __forceinline__ void fetch1DLayeredGrad(int4& v, unsigned long long handle, float x,
                                                   int layer, float dPdx, float dPdy) {
    asm volatile("tex.grad.a1d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], {%7}, {%8};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(dPdx), "f"(dPdy));
}
__device__ __forceinline__ void fetch1DLayeredGrad(uint4& v, unsigned long long handle, float x,
                                                   int layer, float dPdx, float dPdy) {
    asm volatile("tex.grad.a1d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], {%7}, {%8};"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(dPdx), "f"(dPdy));
}
__device__ __forceinline__ void fetch2DLayeredGrad(float4& v, unsigned long long handle, float x,
                                                   float y, int layer, float2 dPdx, float2 dPdy) {
    asm volatile(
        "tex.grad.a2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], {%8, %9}, {%10, %11};"
        : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
        : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdy.x),
          "f"(dPdy.y));
}
__device__ __forceinline__ void fetch2DLayeredGrad(int4& v, unsigned long long handle, float x,
                                                   float y, int layer, float2 dPdx, float2 dPdy) {
    asm volatile(
        "tex.grad.a2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], {%8, %9}, {%10, %11};"
        : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
        : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdy.x),
          "f"(dPdy.y));
}
__device__ __forceinline__ void fetch2DLayeredGrad(uint4& v, unsigned long long handle, float x,
                                                   float y, int layer, float2 dPdx, float2 dPdy) {
    asm volatile(
        "tex.grad.a2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], {%8, %9}, {%10, %11};"
        : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
        : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(dPdx.x), "f"(dPdx.y), "f"(dPdy.x),
          "f"(dPdy.y));
}
__device__ __forceinline__ void fetch1DLod(float4& v, unsigned long long handle, float x,
                                           float level) {
    asm volatile("tex.level.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}], %6;"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(level));
}
__device__ __forceinline__ void fetch1DLod(int4& v, unsigned long long handle, float x,
                                           float level) {
    asm volatile("tex.level.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}], %6;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(level));
}
__device__ __forceinline__ void fetch1DLod(uint4& v, unsigned long long handle, float x,
                                           float level) {
    asm volatile("tex.level.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, 0f3F000000}], %6;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(level));
}
__device__ __forceinline__ void fetch2DLod(float4& v, unsigned long long handle, float x, float y,
                                           float level) {
    asm volatile("tex.level.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], %7;"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(level));
}
__device__ __forceinline__ void fetch2DLod(int4& v, unsigned long long handle, float x, float y,
                                           float level) {
    asm volatile("tex.level.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], %7;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(level));
}
__device__ __forceinline__ void fetch2DLod(uint4& v, unsigned long long handle, float x, float y,
                                           float level) {
    asm volatile("tex.level.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], %7;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(level));
}
__device__ __forceinline__ void fetch3DLod(float4& v, unsigned long long handle, float x, float y,
                                           float z, float level) {
    asm volatile("tex.level.3d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetch3DLod(int4& v, unsigned long long handle, float x, float y,
                                           float z, float level) {
    asm volatile("tex.level.3d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetch3DLod(uint4& v, unsigned long long handle, float x, float y,
                                           float z, float level) {
    asm volatile("tex.level.3d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetch1DLayeredLod(float4& v, unsigned long long handle, float x,
                                                  int layer, float level) {
    asm volatile("tex.level.a1d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], %7;"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(level));
}
__device__ __forceinline__ void fetch1DLayeredLod(int4& v, unsigned long long handle, float x,
                                                  int layer, float level) {
    asm volatile("tex.level.a1d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], %7;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(level));
}
__device__ __forceinline__ void fetch1DLayeredLod(uint4& v, unsigned long long handle, float x,
                                                  int layer, float level) {
    asm volatile("tex.level.a1d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}], %7;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(level));
}
__device__ __forceinline__ void fetch2DLayeredLod(float4& v, unsigned long long handle, float x,
                                                  float y, int layer, float level) {
    asm volatile("tex.level.a2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(level));
}
__device__ __forceinline__ void fetch2DLayeredLod(int4& v, unsigned long long handle, float x,
                                                  float y, int layer, float level) {
    asm volatile("tex.level.a2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(level));
}
__device__ __forceinline__ void fetch2DLayeredLod(uint4& v, unsigned long long handle, float x,
                                                  float y, int layer, float level) {
    asm volatile("tex.level.a2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(level));
}
__device__ __forceinline__ void fetch1DLayered(float4& v, unsigned long long handle, float x,
                                               int layer) {
    asm volatile("tex.a1d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(layer), "f"(x));
}
__device__ __forceinline__ void fetch1DLayered(int4& v, unsigned long long handle, float x,
                                               int layer) {
    asm volatile("tex.a1d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x));
}
__device__ __forceinline__ void fetch1DLayered(uint4& v, unsigned long long handle, float x,
                                               int layer) {
    asm volatile("tex.a1d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x));
}
__device__ __forceinline__ void fetch2DLayered(float4& v, unsigned long long handle, float x,
                                               float y, int layer) {
    asm volatile("tex.a2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetch2DLayered(int4& v, unsigned long long handle, float x, float y,
                                               int layer) {
    asm volatile("tex.a2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetch2DLayered(uint4& v, unsigned long long handle, float x,
                                               float y, int layer) {
    asm volatile("tex.a2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetchCubemap(float4& v, unsigned long long handle, float x, float y,
                                             float z) {
    asm volatile("tex.cube.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetchCubemap(int4& v, unsigned long long handle, float x, float y,
                                             float z) {
    asm volatile("tex.cube.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetchCubemap(uint4& v, unsigned long long handle, float x, float y,
                                             float z) {
    asm volatile("tex.cube.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetchCubemapLayered(float4& v, unsigned long long handle, float x,
                                                    float y, float z, int layer) {
    asm volatile("tex.acube.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %8}];"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetchCubemapLayered(int4& v, unsigned long long handle, float x,
                                                    float y, float z, int layer) {
    asm volatile("tex.acube.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %8}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetchCubemapLayered(uint4& v, unsigned long long handle, float x,
                                                    float y, float z, int layer) {
    asm volatile("tex.acube.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %8}];"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(z));
}
__device__ __forceinline__ void fetchCubemapLod(float4& v, unsigned long long handle, float x,
                                                float y, float z, float level) {
    asm volatile("tex.level.cube.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetchCubemapLod(int4& v, unsigned long long handle, float x,
                                                float y, float z, float level) {
    asm volatile("tex.level.cube.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetchCubemapLod(uint4& v, unsigned long long handle, float x,
                                                float y, float z, float level) {
    asm volatile("tex.level.cube.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %7}], %8;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetchCubemapLayeredLod(float4& v, unsigned long long handle,
                                                       float x, float y, float z, int layer,
                                                       float level) {
    asm volatile("tex.level.acube.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %8}], %9;"
                 : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetchCubemapLayeredLod(int4& v, unsigned long long handle, float x,
                                                       float y, float z, int layer, float level) {
    asm volatile("tex.level.acube.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %8}], %9;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetchCubemapLayeredLod(uint4& v, unsigned long long handle, float x,
                                                       float y, float z, int layer, float level) {
    asm volatile("tex.level.acube.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6, %7, %8}], %9;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(handle), "r"(layer), "f"(x), "f"(y), "f"(z), "f"(level));
}
__device__ __forceinline__ void fetch2DGather(float4& v, unsigned long long handle, float x,
                                              float y, int comp) {
    if (comp == 0)
        asm volatile("tld4.r.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else if (comp == 1)
        asm volatile("tld4.g.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else if (comp == 2)
        asm volatile("tld4.b.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else
        asm volatile("tld4.a.2d.v4.f32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetch2DGather(int4& v, unsigned long long handle, float x, float y,
                                              int comp) {
    if (comp == 0)
        asm volatile("tld4.r.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else if (comp == 1)
        asm volatile("tld4.g.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else if (comp == 2)
        asm volatile("tld4.b.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else
        asm volatile("tld4.a.2d.v4.s32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
}
__device__ __forceinline__ void fetch2DGather(uint4& v, unsigned long long handle, float x, float y,
                                              int comp) {
    if (comp == 0)
        asm volatile("tld4.r.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else if (comp == 1)
        asm volatile("tld4.g.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else if (comp == 2)
        asm volatile("tld4.b.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
    else
        asm volatile("tld4.a.2d.v4.u32.f32 {%0, %1, %2, %3}, [%4, {%5, %6}];"
                     : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                     : "l"(handle), "f"(x), "f"(y));
}

} // namespace sunstone

template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex1D(rtTextureId id, float x) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch1D(v, rt_texture_handle(id), x);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex1D(T* retVal, rtTextureId id, float x) {
    *retVal = rtTex1D<T>(id, x);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2D(rtTextureId id, float x, float y) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2D(v, rt_texture_handle(id), x, y);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2D(T* retVal, rtTextureId id, float x, float y) {
    *retVal = rtTex2D<T>(id, x, y);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex3D(rtTextureId id, float x, float y, float z) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch3D(v, rt_texture_handle(id), x, y, z);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex3D(T* retVal, rtTextureId id, float x, float y, float z) {
    *retVal = rtTex3D<T>(id, x, y, z);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex1DFetch(rtTextureId id, int x) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch1DFetch(v, rt_texture_handle(id), x);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex1DFetch(T* retVal, rtTextureId id, int x) {
    *retVal = rtTex1DFetch<T>(id, x);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2DFetch(rtTextureId id, int x, int y) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2DFetch(v, rt_texture_handle(id), x, y);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2DFetch(T* retVal, rtTextureId id, int x, int y) {
    *retVal = rtTex2DFetch<T>(id, x, y);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex3DFetch(rtTextureId id, int x, int y, int z) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch3DFetch(v, rt_texture_handle(id), x, y, z);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex3DFetch(T* retVal, rtTextureId id, int x, int y, int z) {
    *retVal = rtTex3DFetch<T>(id, x, y, z);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex1DGrad(rtTextureId id, float x, float dPdx, float dPdy) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch1DGrad(v, rt_texture_handle(id), x, dPdx, dPdy);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex1DGrad(T* retVal, rtTextureId id, float x, float dPdx, float dPdy) {
    *retVal = rtTex1DGrad<T>(id, x, dPdx, dPdy);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2DGrad(rtTextureId id, float x, float y, float2 dPdx, float2 dPdy) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2DGrad(v, rt_texture_handle(id), x, y, dPdx, dPdy);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2DGrad(T* retVal, rtTextureId id, float x, float y, float2 dPdx,
                                       float2 dPdy) {
    *retVal = rtTex2DGrad<T>(id, x, y, dPdx, dPdy);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex3DGrad(rtTextureId id, float x, float y, float z, float4 dPdx,
                                    float4 dPdy) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch3DGrad(v, rt_texture_handle(id), x, y, z, dPdx, dPdy);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex3DGrad(T* retVal, rtTextureId id, float x, float y, float z,
                                       float4 dPdx, float4 dPdy) {
    *retVal = rtTex3DGrad<T>(id, x, y, z, dPdx, dPdy);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex1DLayeredGrad(rtTextureId id, float x, int layer, float dPdx,
                                           float dPdy) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch1DLayeredGrad(v, rt_texture_handle(id), x, layer, dPdx, dPdy);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex1DLayeredGrad(T* retVal, rtTextureId id, float x, int layer,
                                              float dPdx, float dPdy) {
    *retVal = rtTex1DLayeredGrad<T>(id, x, layer, dPdx, dPdy);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2DLayeredGrad(rtTextureId id, float x, float y, int layer, float2 dPdx,
                                           float2 dPdy) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2DLayeredGrad(v, rt_texture_handle(id), x, y, layer, dPdx, dPdy);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2DLayeredGrad(T* retVal, rtTextureId id, float x, float y,
                                              int layer, float2 dPdx, float2 dPdy) {
    *retVal = rtTex2DLayeredGrad<T>(id, x, y, layer, dPdx, dPdy);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex1DLod(rtTextureId id, float x, float level) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch1DLod(v, rt_texture_handle(id), x, level);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex1DLod(T* retVal, rtTextureId id, float x, float level) {
    *retVal = rtTex1DLod<T>(id, x, level);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2DLod(rtTextureId id, float x, float y, float level) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2DLod(v, rt_texture_handle(id), x, y, level);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2DLod(T* retVal, rtTextureId id, float x, float y, float level) {
    *retVal = rtTex2DLod<T>(id, x, y, level);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex3DLod(rtTextureId id, float x, float y, float z, float level) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch3DLod(v, rt_texture_handle(id), x, y, z, level);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex3DLod(T* retVal, rtTextureId id, float x, float y, float z,
                                      float level) {
    *retVal = rtTex3DLod<T>(id, x, y, z, level);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex1DLayeredLod(rtTextureId id, float x, int layer, float level) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch1DLayeredLod(v, rt_texture_handle(id), x, layer, level);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex1DLayeredLod(T* retVal, rtTextureId id, float x, int layer,
                                             float level) {
    *retVal = rtTex1DLayeredLod<T>(id, x, layer, level);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2DLayeredLod(rtTextureId id, float x, float y, int layer,
                                          float level) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2DLayeredLod(v, rt_texture_handle(id), x, y, layer, level);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2DLayeredLod(T* retVal, rtTextureId id, float x, float y, int layer,
                                             float level) {
    *retVal = rtTex2DLayeredLod<T>(id, x, y, layer, level);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex1DLayered(rtTextureId id, float x, int layer) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch1DLayered(v, rt_texture_handle(id), x, layer);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex1DLayered(T* retVal, rtTextureId id, float x, int layer) {
    *retVal = rtTex1DLayered<T>(id, x, layer);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2DLayered(rtTextureId id, float x, float y, int layer) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2DLayered(v, rt_texture_handle(id), x, y, layer);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2DLayered(T* retVal, rtTextureId id, float x, float y, int layer) {
    *retVal = rtTex2DLayered<T>(id, x, y, layer);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTexCubemap(rtTextureId id, float x, float y, float z) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetchCubemap(v, rt_texture_handle(id), x, y, z);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTexCubemap(T* retVal, rtTextureId id, float x, float y, float z) {
    *retVal = rtTexCubemap<T>(id, x, y, z);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTexCubemapLayered(rtTextureId id, float x, float y, float z, int layer) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetchCubemapLayered(v, rt_texture_handle(id), x, y, z, layer);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTexCubemapLayered(T* retVal, rtTextureId id, float x, float y, float z,
                                               int layer) {
    *retVal = rtTexCubemapLayered<T>(id, x, y, z, layer);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTexCubemapLod(rtTextureId id, float x, float y, float z, float level) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetchCubemapLod(v, rt_texture_handle(id), x, y, z, level);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTexCubemapLod(T* retVal, rtTextureId id, float x, float y, float z,
                                           float level) {
    *retVal = rtTexCubemapLod<T>(id, x, y, z, level);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTexCubemapLayeredLod(rtTextureId id, float x, float y, float z, int layer,
                                               float level) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetchCubemapLayeredLod(v, rt_texture_handle(id), x, y, z, layer, level);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTexCubemapLayeredLod(T* retVal, rtTextureId id, float x, float y,
                                                  float z, int layer, float level) {
    *retVal = rtTexCubemapLayeredLod<T>(id, x, y, z, layer, level);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE T rtTex2DGather(rtTextureId id, float x, float y, int comp = 0) {
    typename sunstone::Fetched<T>::Wide v;
    sunstone::fetch2DGather(v, rt_texture_handle(id), x, y, comp);
    return sunstone::Fetched<T>::from(v);
}
template <typename T>
SUNSTONE_OPTIX_DEVICE void rtTex2DGather(T* retVal, rtTextureId id, float x, float y,
                                         int comp = 0) {
    *retVal = rtTex2DGather<T>(id, x, y, comp);
}

} // namespace optix

#endif
