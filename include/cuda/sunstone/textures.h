// SPDX-License-Identifier: Apache-2.0
// Device functions on texture and surface objects, as templates on the texel type. Each is one PTX
// instruction, whose words are converted to the texel type.
#ifndef SUNSTONE_TEXTURES_H
#define SUNSTONE_TEXTURES_H

#include "../surface_types.h"
#include "../texture_types.h"
#include "../vector_types.h"

#define SUNSTONE_TEX static __inline__ __device__

// The composition of a texel type from words. `isFloat`: the sampler returns floats.
template <class T> struct sunstone_texel;
#define SUNSTONE_TEXEL1(T, M, isF)                                                                 \
    template <> struct sunstone_texel<T> {                                                         \
        static constexpr bool isFloat = isF;                                                       \
        static __inline__ __device__ T from(const unsigned* w) { return sunstone_word<M>(w[0]); }                  \
    };
#define SUNSTONE_TEXEL2(T, M, isF)                                                                 \
    template <> struct sunstone_texel<T> {                                                         \
        static constexpr bool isFloat = isF;                                                       \
        static __inline__ __device__ T from(const unsigned* w) {                                                   \
            T r;                                                                                   \
            r.x = sunstone_word<M>(w[0]);                                                          \
            r.y = sunstone_word<M>(w[1]);                                                          \
            return r;                                                                              \
        }                                                                                          \
    };
#define SUNSTONE_TEXEL4(T, M, isF)                                                                 \
    template <> struct sunstone_texel<T> {                                                         \
        static constexpr bool isFloat = isF;                                                       \
        static __inline__ __device__ T from(const unsigned* w) {                                                   \
            T r;                                                                                   \
            r.x = sunstone_word<M>(w[0]);                                                          \
            r.y = sunstone_word<M>(w[1]);                                                          \
            r.z = sunstone_word<M>(w[2]);                                                          \
            r.w = sunstone_word<M>(w[3]);                                                          \
            return r;                                                                              \
        }                                                                                          \
    };
// The bytes of one type as another; missing bytes are zero.
template <class To, class From> SUNSTONE_TEX To sunstone_bits(const From& from) {
    To to = To();
    __builtin_memcpy(&to, &from, sizeof(To) < sizeof(From) ? sizeof(To) : sizeof(From));
    return to;
}
template <class M> SUNSTONE_TEX M sunstone_word(unsigned word) {
    return __is_same(M, float) ? (M)sunstone_bits<float>(word) : (M)word;
}
#define SUNSTONE_TEXELS(M, stem, isF)                                                              \
    SUNSTONE_TEXEL1(M, M, isF)                                                                     \
    SUNSTONE_TEXEL2(stem##2, M, isF)                                                               \
    SUNSTONE_TEXEL4(stem##4, M, isF)
SUNSTONE_TEXELS(float, float, true)
SUNSTONE_TEXELS(int, int, false)
SUNSTONE_TEXELS(unsigned int, uint, false)
SUNSTONE_TEXELS(short, short, false)
SUNSTONE_TEXELS(unsigned short, ushort, false)
SUNSTONE_TEXELS(unsigned char, uchar, false)
SUNSTONE_TEXELS(signed char, char, false)
SUNSTONE_TEXEL1(char, char, false)
// Vectors of one component.
#define SUNSTONE_TEXEL_OF_ONE(T, M, isF)                                                           \
    template <> struct sunstone_texel<T> {                                                         \
        static constexpr bool isFloat = isF;                                                       \
        static __inline__ __device__ T from(const unsigned* w) {                                   \
            T r;                                                                                   \
            r.x = sunstone_word<M>(w[0]);                                                          \
            return r;                                                                              \
        }                                                                                          \
    };
SUNSTONE_TEXEL_OF_ONE(float1, float, true)
SUNSTONE_TEXEL_OF_ONE(int1, int, false)
SUNSTONE_TEXEL_OF_ONE(uint1, unsigned int, false)
SUNSTONE_TEXEL_OF_ONE(short1, short, false)
SUNSTONE_TEXEL_OF_ONE(ushort1, unsigned short, false)
SUNSTONE_TEXEL_OF_ONE(char1, signed char, false)
SUNSTONE_TEXEL_OF_ONE(uchar1, unsigned char, false)
#undef SUNSTONE_TEXEL_OF_ONE
#undef SUNSTONE_TEXELS
#undef SUNSTONE_TEXEL1
#undef SUNSTONE_TEXEL2
#undef SUNSTONE_TEXEL4

// name: function; params, args: after the texture; opcode: with geometry; coordinates: the type of
// the coordinates; operands: after the destination; the rest: constraints of the operands.
#define SUNSTONE_SAMPLE(name, params, args, opcode, coordinates, operands, ...)                    \
    template <class T> SUNSTONE_TEX T name params {                                                \
        unsigned w[4];                                                                             \
        if (sunstone_texel<T>::isFloat) {                                                \
            float a, b, c, d;                                                                      \
            asm volatile(opcode ".v4.f32." coordinates " {%0, %1, %2, %3}, " operands ";"          \
                         : "=f"(a), "=f"(b), "=f"(c), "=f"(d)                                      \
                         : "l"(texture), __VA_ARGS__);                                             \
            w[0] = sunstone_bits<unsigned>(a);                                                \
            w[1] = sunstone_bits<unsigned>(b);                                                \
            w[2] = sunstone_bits<unsigned>(c);                                                \
            w[3] = sunstone_bits<unsigned>(d);                                                \
        } else {                                                                                   \
            asm volatile(opcode ".v4.u32." coordinates " {%0, %1, %2, %3}, " operands ";"          \
                         : "=r"(w[0]), "=r"(w[1]), "=r"(w[2]), "=r"(w[3])                          \
                         : "l"(texture), __VA_ARGS__);                                             \
        }                                                                                          \
        return sunstone_texel<T>::from(w);                                                         \
    }                                                                                              \
    /* Whether the texels are in memory; false only for sparse arrays. PTX 7.1. */                 \
    template <class T> SUNSTONE_TEX T name SUNSTONE_AND_RESIDENT params {                          \
        unsigned w[4], resident;                                                                   \
        if (sunstone_texel<T>::isFloat) {                                                          \
            float a, b, c, d;                                                                      \
            asm volatile("{ .reg .pred p; .reg .u32 r;\n" opcode ".v4.f32." coordinates            \
                         " {%0, %1, %2, %3}|p, " operands                                          \
                         ";\nselp.u32 r, 1, 0, p; st.u32 [%[resident]], r; }"                      \
                         : "=f"(a), "=f"(b), "=f"(c), "=f"(d)                                      \
                         : "l"(texture), __VA_ARGS__, [resident] "l"(&resident)                    \
                         : "memory");                                                              \
            w[0] = sunstone_bits<unsigned>(a);                                                     \
            w[1] = sunstone_bits<unsigned>(b);                                                     \
            w[2] = sunstone_bits<unsigned>(c);                                                     \
            w[3] = sunstone_bits<unsigned>(d);                                                     \
        } else {                                                                                   \
            asm volatile("{ .reg .pred p; .reg .u32 r;\n" opcode ".v4.u32." coordinates            \
                         " {%0, %1, %2, %3}|p, " operands                                          \
                         ";\nselp.u32 r, 1, 0, p; st.u32 [%[resident]], r; }"                      \
                         : "=r"(w[0]), "=r"(w[1]), "=r"(w[2]), "=r"(w[3])                          \
                         : "l"(texture), __VA_ARGS__, [resident] "l"(&resident)                    \
                         : "memory");                                                              \
        }                                                                                          \
        *isResident = resident != 0;                                                               \
        return sunstone_texel<T>::from(w);                                                         \
    }

#define SUNSTONE_AND_RESIDENT(...) (__VA_ARGS__, bool* isResident)
#define SUNSTONE_P cudaTextureObject_t texture
SUNSTONE_SAMPLE(tex1Dfetch, (SUNSTONE_P, int x), (x), "tex.1d", "s32", "[%4, {%5}]", "r"(x))
SUNSTONE_SAMPLE(tex1D, (SUNSTONE_P, float x), (x), "tex.1d", "f32", "[%4, {%5}]", "f"(x))
SUNSTONE_SAMPLE(tex2D, (SUNSTONE_P, float x, float y), (x, y), "tex.2d", "f32", "[%4, {%5, %6}]",
                "f"(x), "f"(y))
SUNSTONE_SAMPLE(tex3D, (SUNSTONE_P, float x, float y, float z), (x, y, z), "tex.3d", "f32",
                "[%4, {%5, %6, %7, %7}]", "f"(x), "f"(y), "f"(z))
SUNSTONE_SAMPLE(tex1DLayered, (SUNSTONE_P, float x, int layer), (x, layer), "tex.a1d", "f32",
                "[%4, {%5, %6}]", "r"(layer), "f"(x))
SUNSTONE_SAMPLE(tex2DLayered, (SUNSTONE_P, float x, float y, int layer), (x, y, layer), "tex.a2d",
                "f32", "[%4, {%5, %6, %7, %7}]", "r"(layer), "f"(x), "f"(y))
SUNSTONE_SAMPLE(texCubemap, (SUNSTONE_P, float x, float y, float z), (x, y, z), "tex.cube", "f32",
                "[%4, {%5, %6, %7, %7}]", "f"(x), "f"(y), "f"(z))
SUNSTONE_SAMPLE(texCubemapLayered, (SUNSTONE_P, float x, float y, float z, int layer),
                (x, y, z, layer), "tex.acube", "f32", "[%4, {%5, %6, %7, %8}]", "r"(layer), "f"(x),
                "f"(y), "f"(z))
SUNSTONE_SAMPLE(tex1DLod, (SUNSTONE_P, float x, float level), (x, level), "tex.level.1d", "f32",
                "[%4, {%5}], %6", "f"(x), "f"(level))
SUNSTONE_SAMPLE(tex2DLod, (SUNSTONE_P, float x, float y, float level), (x, y, level),
                "tex.level.2d", "f32", "[%4, {%5, %6}], %7", "f"(x), "f"(y), "f"(level))
SUNSTONE_SAMPLE(tex3DLod, (SUNSTONE_P, float x, float y, float z, float level), (x, y, z, level),
                "tex.level.3d", "f32", "[%4, {%5, %6, %7, %7}], %8", "f"(x), "f"(y), "f"(z),
                "f"(level))
SUNSTONE_SAMPLE(tex1DLayeredLod, (SUNSTONE_P, float x, int layer, float level), (x, layer, level),
                "tex.level.a1d", "f32", "[%4, {%5, %6}], %7", "r"(layer), "f"(x), "f"(level))
SUNSTONE_SAMPLE(tex2DLayeredLod, (SUNSTONE_P, float x, float y, int layer, float level),
                (x, y, layer, level), "tex.level.a2d", "f32", "[%4, {%5, %6, %7, %7}], %8",
                "r"(layer), "f"(x), "f"(y), "f"(level))
SUNSTONE_SAMPLE(texCubemapLod, (SUNSTONE_P, float x, float y, float z, float level),
                (x, y, z, level), "tex.level.cube", "f32", "[%4, {%5, %6, %7, %7}], %8", "f"(x),
                "f"(y), "f"(z), "f"(level))
SUNSTONE_SAMPLE(tex1DGrad, (SUNSTONE_P, float x, float dx, float dy), (x, dx, dy), "tex.grad.1d",
                "f32", "[%4, {%5}], {%6}, {%7}", "f"(x), "f"(dx), "f"(dy))
SUNSTONE_SAMPLE(tex2DGrad, (SUNSTONE_P, float x, float y, float2 dx, float2 dy), (x, y, dx, dy),
                "tex.grad.2d", "f32", "[%4, {%5, %6}], {%7, %8}, {%9, %10}", "f"(x), "f"(y),
                "f"(dx.x), "f"(dx.y), "f"(dy.x), "f"(dy.y))
SUNSTONE_SAMPLE(tex3DGrad, (SUNSTONE_P, float x, float y, float z, float4 dx, float4 dy),
                (x, y, z, dx, dy), "tex.grad.3d", "f32",
                "[%4, {%5, %6, %7, %7}], {%8, %9, %10, %10}, {%11, %12, %13, %13}", "f"(x), "f"(y),
                "f"(z), "f"(dx.x), "f"(dx.y), "f"(dx.z), "f"(dy.x), "f"(dy.y), "f"(dy.z))
SUNSTONE_SAMPLE(tex1DLayeredGrad, (SUNSTONE_P, float x, int layer, float dx, float dy),
                (x, layer, dx, dy), "tex.grad.a1d", "f32", "[%4, {%5, %6}], {%7}, {%8}", "r"(layer),
                "f"(x), "f"(dx), "f"(dy))
SUNSTONE_SAMPLE(tex2DLayeredGrad, (SUNSTONE_P, float x, float y, int layer, float2 dx, float2 dy),
                (x, y, layer, dx, dy), "tex.grad.a2d", "f32",
                "[%4, {%5, %6, %7, %7}], {%8, %9}, {%10, %11}", "r"(layer), "f"(x), "f"(y),
                "f"(dx.x), "f"(dx.y), "f"(dy.x), "f"(dy.y))
SUNSTONE_SAMPLE(texCubemapGrad, (SUNSTONE_P, float x, float y, float z, float4 dx, float4 dy),
                (x, y, z, dx, dy), "tex.grad.cube", "f32",
                "[%4, {%5, %6, %7, %7}], {%8, %9, %10, %10}, {%11, %12, %13, %13}", "f"(x), "f"(y),
                "f"(z), "f"(dx.x), "f"(dx.y), "f"(dx.z), "f"(dy.x), "f"(dy.y), "f"(dy.z))
SUNSTONE_SAMPLE(texCubemapLayeredLod,
                (SUNSTONE_P, float x, float y, float z, int layer, float level),
                (x, y, z, layer, level), "tex.level.acube", "f32", "[%4, {%5, %6, %7, %8}], %9",
                "r"(layer), "f"(x), "f"(y), "f"(z), "f"(level))
SUNSTONE_SAMPLE(texCubemapLayeredGrad,
                (SUNSTONE_P, float x, float y, float z, int layer, float4 dx, float4 dy),
                (x, y, z, layer, dx, dy), "tex.grad.acube", "f32",
                "[%4, {%5, %6, %7, %8}], {%9, %10, %11, %11}, {%12, %13, %14, %14}", "r"(layer),
                "f"(x), "f"(y), "f"(z), "f"(dx.x), "f"(dx.y), "f"(dx.z), "f"(dy.x), "f"(dy.y),
                "f"(dy.z))
SUNSTONE_SAMPLE(sunstone_gather0, (SUNSTONE_P, float x, float y), (x, y), "tld4.r.2d", "f32",
                "[%4, {%5, %6}]", "f"(x), "f"(y))
SUNSTONE_SAMPLE(sunstone_gather1, (SUNSTONE_P, float x, float y), (x, y), "tld4.g.2d", "f32",
                "[%4, {%5, %6}]", "f"(x), "f"(y))
SUNSTONE_SAMPLE(sunstone_gather2, (SUNSTONE_P, float x, float y), (x, y), "tld4.b.2d", "f32",
                "[%4, {%5, %6}]", "f"(x), "f"(y))
SUNSTONE_SAMPLE(sunstone_gather3, (SUNSTONE_P, float x, float y), (x, y), "tld4.a.2d", "f32",
                "[%4, {%5, %6}]", "f"(x), "f"(y))
template <class T>
SUNSTONE_TEX T tex2Dgather(cudaTextureObject_t texture, float x, float y, int component = 0) {
    return component == 1   ? sunstone_gather1<T>(texture, x, y)
           : component == 2 ? sunstone_gather2<T>(texture, x, y)
           : component == 3 ? sunstone_gather3<T>(texture, x, y)
                            : sunstone_gather0<T>(texture, x, y);
}
template <class T>
SUNSTONE_TEX T tex2Dgather(cudaTextureObject_t texture, float x, float y, bool* isResident,
                           int component = 0) {
    return component == 1   ? sunstone_gather1<T>(texture, x, y, isResident)
           : component == 2 ? sunstone_gather2<T>(texture, x, y, isResident)
           : component == 3 ? sunstone_gather3<T>(texture, x, y, isResident)
                            : sunstone_gather0<T>(texture, x, y, isResident);
}
#undef SUNSTONE_SAMPLE
#undef SUNSTONE_AND_RESIDENT
#undef SUNSTONE_P

// The forms that return the result through the first parameter.
#define SUNSTONE_INTO(name)                                                                        \
    template <class T, class... A>                                                                 \
    SUNSTONE_TEX void name(T* result, cudaTextureObject_t texture, A... rest) {                    \
        *result = name<T>(texture, rest...);                                                       \
    }
SUNSTONE_INTO(tex1Dfetch)
SUNSTONE_INTO(tex1D)
SUNSTONE_INTO(tex2D)
SUNSTONE_INTO(tex3D)
SUNSTONE_INTO(tex1DLayered)
SUNSTONE_INTO(tex2DLayered)
SUNSTONE_INTO(texCubemap)
SUNSTONE_INTO(texCubemapLayered)
SUNSTONE_INTO(tex1DLod)
SUNSTONE_INTO(tex2DLod)
SUNSTONE_INTO(tex3DLod)
SUNSTONE_INTO(tex1DLayeredLod)
SUNSTONE_INTO(tex2DLayeredLod)
SUNSTONE_INTO(texCubemapLod)
SUNSTONE_INTO(texCubemapLayeredLod)
SUNSTONE_INTO(tex1DGrad)
SUNSTONE_INTO(tex3DGrad)
SUNSTONE_INTO(tex1DLayeredGrad)
SUNSTONE_INTO(tex2DLayeredGrad)
SUNSTONE_INTO(texCubemapGrad)
SUNSTONE_INTO(texCubemapLayeredGrad)
SUNSTONE_INTO(tex2Dgather)
SUNSTONE_INTO(tex2DGrad)
#undef SUNSTONE_INTO

// ---- surfaces: texels as bytes, in pieces of 1, 2, 4 or 8 ------------------------------------------
// Operand numbers: destination or source words first, then the surface, then x (and y, z, layer).
#define SUNSTONE_SULD(bytes, R, letter, type, geometry, at, mode, ...)                             \
    if (sizeof(T) == bytes) {                                                            \
        R w;                                                                                       \
        asm volatile("suld.b." geometry "." type "." mode " {%0}, [%1, " at "];"                   \
                     : "=" letter(w)                                                               \
                     : "l"(surface), __VA_ARGS__                                                   \
                     : "memory");                                                                  \
        return sunstone_bits<T>(w);                                                        \
    }
#define SUNSTONE_SULD16(geometry, at2, mode, ...)                                                  \
    if (sizeof(T) == 16) {                                                               \
        longlong2 w;                                                                               \
        asm volatile("suld.b." geometry ".v2.b64." mode " {%0, %1}, [%2, " at2 "];"                \
                     : "=l"(w.x), "=l"(w.y)                                                        \
                     : "l"(surface), __VA_ARGS__                                                   \
                     : "memory");                                                                  \
        return sunstone_bits<T>(w);                                                           \
    }
#define SUNSTONE_SUST(bytes, R, letter, type, geometry, at, mode, ...)                             \
    if (sizeof(T) == bytes) {                                                            \
        const R w = sunstone_bits<R>(value);                                               \
        asm volatile("sust.b." geometry "." type "." mode " [%1, " at "], {%0};" ::letter(w),      \
                     "l"(surface), __VA_ARGS__                                                     \
                     : "memory");                                                                  \
    }
#define SUNSTONE_SUST16(geometry, at2, mode, ...)                                                  \
    if (sizeof(T) == 16) {                                                               \
        const longlong2 w = sunstone_bits<longlong2>(value);                                  \
        asm volatile("sust.b." geometry ".v2.b64." mode " [%2, " at2 "], {%0, %1};" ::"l"(w.x),    \
                     "l"(w.y), "l"(surface), __VA_ARGS__                                           \
                     : "memory");                                                                  \
    }
#define SUNSTONE_READ_MODE(geometry, at, at2, mode, ...)                                           \
    SUNSTONE_SULD(1, short, "h", "b8", geometry, at, mode, __VA_ARGS__)                            \
    SUNSTONE_SULD(2, short, "h", "b16", geometry, at, mode, __VA_ARGS__)                           \
    SUNSTONE_SULD(4, int, "r", "b32", geometry, at, mode, __VA_ARGS__)                             \
    SUNSTONE_SULD(8, long long, "l", "b64", geometry, at, mode, __VA_ARGS__)                       \
    SUNSTONE_SULD16(geometry, at2, mode, __VA_ARGS__)
#define SUNSTONE_WRITE_MODE(geometry, at, at2, mode, ...)                                          \
    SUNSTONE_SUST(1, short, "h", "b8", geometry, at, mode, __VA_ARGS__)                            \
    SUNSTONE_SUST(2, short, "h", "b16", geometry, at, mode, __VA_ARGS__)                           \
    SUNSTONE_SUST(4, int, "r", "b32", geometry, at, mode, __VA_ARGS__)                             \
    SUNSTONE_SUST(8, long long, "l", "b64", geometry, at, mode, __VA_ARGS__)                       \
    SUNSTONE_SUST16(geometry, at2, mode, __VA_ARGS__)
// A reading and a writing function for one geometry; params and args follow the surface.
#define SUNSTONE_SURFACE(stem, params, args, geometry, at, at2, ...)                               \
    template <class T>                                                                             \
    SUNSTONE_TEX T stem##read(cudaSurfaceObject_t surface, SUNSTONE_LIST params,                   \
                              cudaSurfaceBoundaryMode mode = cudaBoundaryModeTrap) {               \
        if (mode == cudaBoundaryModeZero) {                                                        \
            SUNSTONE_READ_MODE(geometry, at, at2, "zero", __VA_ARGS__)                             \
        } else if (mode == cudaBoundaryModeClamp) {                                                \
            SUNSTONE_READ_MODE(geometry, at, at2, "clamp", __VA_ARGS__)                            \
        }                                                                                          \
        SUNSTONE_READ_MODE(geometry, at, at2, "trap", __VA_ARGS__)                                 \
        return T();                                                                                \
    }                                                                                              \
    template <class T>                                                                             \
    SUNSTONE_TEX void stem##read(T* result, cudaSurfaceObject_t surface, SUNSTONE_LIST params,     \
                                 cudaSurfaceBoundaryMode mode = cudaBoundaryModeTrap) {            \
        *result = stem##read<T>(surface, SUNSTONE_LIST args, mode);                                \
    }                                                                                              \
    template <class T>                                                                             \
    SUNSTONE_TEX void stem##write(T value, cudaSurfaceObject_t surface, SUNSTONE_LIST params,      \
                                  cudaSurfaceBoundaryMode mode = cudaBoundaryModeTrap) {           \
        if (mode == cudaBoundaryModeZero) {                                                        \
            SUNSTONE_WRITE_MODE(geometry, at, at2, "zero", __VA_ARGS__)                            \
        } else if (mode == cudaBoundaryModeClamp) {                                                \
            SUNSTONE_WRITE_MODE(geometry, at, at2, "clamp", __VA_ARGS__)                           \
        } else {                                                                                   \
            SUNSTONE_WRITE_MODE(geometry, at, at2, "trap", __VA_ARGS__)                            \
        }                                                                                          \
    }
#define SUNSTONE_LIST(...) __VA_ARGS__
SUNSTONE_SURFACE(surf1D, (int x), (x), "1d", "{%2}", "{%3}", "r"(x))
SUNSTONE_SURFACE(surf2D, (int x, int y), (x, y), "2d", "{%2, %3}", "{%3, %4}", "r"(x), "r"(y))
SUNSTONE_SURFACE(surf3D, (int x, int y, int z), (x, y, z), "3d", "{%2, %3, %4, %4}",
                 "{%3, %4, %5, %5}", "r"(x), "r"(y), "r"(z))
SUNSTONE_SURFACE(surf1DLayered, (int x, int layer), (x, layer), "a1d", "{%2, %3}", "{%3, %4}",
                 "r"(layer), "r"(x))
SUNSTONE_SURFACE(surf2DLayered, (int x, int y, int layer), (x, y, layer), "a2d",
                 "{%2, %3, %4, %4}", "{%3, %4, %5, %5}", "r"(layer), "r"(x), "r"(y))
SUNSTONE_SURFACE(surfCubemap, (int x, int y, int face), (x, y, face), "a2d", "{%2, %3, %4, %4}",
                 "{%3, %4, %5, %5}", "r"(face), "r"(x), "r"(y))
SUNSTONE_SURFACE(surfCubemapLayered, (int x, int y, int layerFace), (x, y, layerFace), "a2d",
                 "{%2, %3, %4, %4}", "{%3, %4, %5, %5}", "r"(layerFace), "r"(x), "r"(y))
#undef SUNSTONE_SURFACE
#undef SUNSTONE_LIST
#undef SUNSTONE_READ_MODE
#undef SUNSTONE_WRITE_MODE
#undef SUNSTONE_SULD
#undef SUNSTONE_SULD16
#undef SUNSTONE_SUST
#undef SUNSTONE_SUST16
#undef SUNSTONE_TEX

#endif
