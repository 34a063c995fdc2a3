// SPDX-License-Identifier: Apache-2.0
// rtTextureSampler<T, Dim, ReadMode>: textures that the host binds to variables, read with tex1D,
// tex2D and similar functions. Compilers before CUDA 12 have the type `texture`; this header
// defines it for later ones and for clang. Source: OptiX 6.0 Programming Guide, "Textures"; CUDA C
// Programming Guide 11, "Texture reference API".
#ifndef SUNSTONE_OPTIX6_TEXTURE_REFERENCES_H
#define SUNSTONE_OPTIX6_TEXTURE_REFERENCES_H

#if defined(__CUDACC_VER_MAJOR__) && __CUDACC_VER_MAJOR__ < 12

#define rtTextureSampler texture

#else

#define rtTextureSampler __device__ texture

#ifndef cudaTextureType1D
#define cudaTextureType1D 0x01
#define cudaTextureType2D 0x02
#define cudaTextureType3D 0x03
#define cudaTextureTypeCubemap 0x0C
#define cudaTextureType1DLayered 0xF1
#define cudaTextureType2DLayered 0xF2
#define cudaTextureTypeCubemapLayered 0xFC
#endif

// A variable of this type represents a sampler that the host assigns. The library recognises the
// type by its size and alignment of 128 bytes; at run time the variable takes no memory. Dim is a
// cudaTextureType, Mode a cudaTextureReadMode; run-time compilers may lack these names.
template <class T, int Dim = cudaTextureType1D, int Mode = 0>
struct __align__(128) texture {
    unsigned long long handle;
};

namespace optix {
namespace sunstone {

// Result of a read: the element, or its components as numbers from 0 or -1 to 1.
template <class T, int Mode>
struct Read {
    typedef T Type;
};
#define SUNSTONE_NORMALIZED(element)                                                               \
    template <>                                                                                    \
    struct Read<element, 1> {                                                                      \
        typedef float Type;                                                                        \
    };                                                                                             \
    template <>                                                                                    \
    struct Read<element##1, 1> {                                                                   \
        typedef float1 Type;                                                                       \
    };                                                                                             \
    template <>                                                                                    \
    struct Read<element##2, 1> {                                                                   \
        typedef float2 Type;                                                                       \
    };                                                                                             \
    template <>                                                                                    \
    struct Read<element##4, 1> {                                                                   \
        typedef float4 Type;                                                                       \
    };
typedef unsigned char uchar;
typedef unsigned short ushort;
SUNSTONE_NORMALIZED(char)
SUNSTONE_NORMALIZED(uchar)
SUNSTONE_NORMALIZED(short)
SUNSTONE_NORMALIZED(ushort)
#undef SUNSTONE_NORMALIZED

} // namespace sunstone
} // namespace optix

// name(reference, parameters) for references of a dimension, by the function `fetch`.
#define SUNSTONE_READ(name, fetch, parameters, arguments)                                          \
    template <class T, int Mode>                                                                   \
    static __forceinline__ __device__                                                              \
        typename optix::sunstone::Read<T, Mode>::Type name parameters {                            \
        typedef typename optix::sunstone::Read<T, Mode>::Type Result;                              \
        typename optix::sunstone::Fetched<Result>::Wide v;                                         \
        optix::sunstone::fetch arguments;                                                          \
        return optix::sunstone::Fetched<Result>::from(v);                                          \
    }
#define SUNSTONE_REFERENCE(dim) const texture<T, dim, Mode>& r

SUNSTONE_READ(tex1D, fetch1D, (SUNSTONE_REFERENCE(1), float x), (v, r.handle, x))
SUNSTONE_READ(tex2D, fetch2D, (SUNSTONE_REFERENCE(2), float x, float y), (v, r.handle, x, y))
SUNSTONE_READ(tex3D, fetch3D, (SUNSTONE_REFERENCE(3), float x, float y, float z),
              (v, r.handle, x, y, z))
SUNSTONE_READ(tex1Dfetch, fetch1DFetch, (SUNSTONE_REFERENCE(1), int x), (v, r.handle, x))
SUNSTONE_READ(tex1DLayered, fetch1DLayered, (SUNSTONE_REFERENCE(0xF1), float x, int layer),
              (v, r.handle, x, layer))
SUNSTONE_READ(tex2DLayered, fetch2DLayered, (SUNSTONE_REFERENCE(0xF2), float x, float y, int layer),
              (v, r.handle, x, y, layer))
SUNSTONE_READ(texCubemap, fetchCubemap, (SUNSTONE_REFERENCE(0x0C), float x, float y, float z),
              (v, r.handle, x, y, z))
SUNSTONE_READ(texCubemapLayered, fetchCubemapLayered,
              (SUNSTONE_REFERENCE(0xFC), float x, float y, float z, int layer),
              (v, r.handle, x, y, z, layer))
SUNSTONE_READ(tex2Dgather, fetch2DGather,
              (SUNSTONE_REFERENCE(2), float x, float y, int component = 0),
              (v, r.handle, x, y, component))
SUNSTONE_READ(tex1DLod, fetch1DLod, (SUNSTONE_REFERENCE(1), float x, float level),
              (v, r.handle, x, level))
SUNSTONE_READ(tex2DLod, fetch2DLod, (SUNSTONE_REFERENCE(2), float x, float y, float level),
              (v, r.handle, x, y, level))
SUNSTONE_READ(tex3DLod, fetch3DLod, (SUNSTONE_REFERENCE(3), float x, float y, float z, float level),
              (v, r.handle, x, y, z, level))
SUNSTONE_READ(tex1DLayeredLod, fetch1DLayeredLod,
              (SUNSTONE_REFERENCE(0xF1), float x, int layer, float level),
              (v, r.handle, x, layer, level))
SUNSTONE_READ(tex2DLayeredLod, fetch2DLayeredLod,
              (SUNSTONE_REFERENCE(0xF2), float x, float y, int layer, float level),
              (v, r.handle, x, y, layer, level))
SUNSTONE_READ(texCubemapLod, fetchCubemapLod,
              (SUNSTONE_REFERENCE(0x0C), float x, float y, float z, float level),
              (v, r.handle, x, y, z, level))
SUNSTONE_READ(texCubemapLayeredLod, fetchCubemapLayeredLod,
              (SUNSTONE_REFERENCE(0xFC), float x, float y, float z, int layer, float level),
              (v, r.handle, x, y, z, layer, level))
SUNSTONE_READ(tex1DGrad, fetch1DGrad, (SUNSTONE_REFERENCE(1), float x, float dx, float dy),
              (v, r.handle, x, dx, dy))
SUNSTONE_READ(tex2DGrad, fetch2DGrad,
              (SUNSTONE_REFERENCE(2), float x, float y, float2 dx, float2 dy),
              (v, r.handle, x, y, dx, dy))
SUNSTONE_READ(tex3DGrad, fetch3DGrad,
              (SUNSTONE_REFERENCE(3), float x, float y, float z, float4 dx, float4 dy),
              (v, r.handle, x, y, z, dx, dy))
SUNSTONE_READ(tex1DLayeredGrad, fetch1DLayeredGrad,
              (SUNSTONE_REFERENCE(0xF1), float x, int layer, float dx, float dy),
              (v, r.handle, x, layer, dx, dy))
SUNSTONE_READ(tex2DLayeredGrad, fetch2DLayeredGrad,
              (SUNSTONE_REFERENCE(0xF2), float x, float y, int layer, float2 dx, float2 dy),
              (v, r.handle, x, y, layer, dx, dy))

#undef SUNSTONE_READ
#undef SUNSTONE_REFERENCE

#endif
#endif
