// SPDX-License-Identifier: Apache-2.0
// Matrices of transform lists: loads the transforms behind handles, interpolates motion keys, and
// multiplies a list. Part of optix_7_device.h, used by the public functions at the end of
// optix_7_device_impl.h. Source: OptiX API reference 7.4, sections 4.1, 6.5.
//
// A matrix is three rows m0, m1, m2 of a 3x4 affine matrix (the fourth row is 0 0 0 1). Motion: key
// k of n is at begin + k * (end - begin) / (n - 1). Between keys matrices are interpolated element
// by element, SRT keys number by number with the quaternion normalised after. Outside the range the
// nearest key applies. Only IEEE operations are used, so that all devices agree.
#if !defined(SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_H)
#include "optix_7_device.h" /* included by itself: comes back here in the right order */
#elif !defined(SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_TRANSFORMATIONS_H)
#define SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_TRANSFORMATIONS_H

namespace optix_impl {

static __forceinline__ __device__ float4 optixAddFloat4(const float4& a, const float4& b) {
    return make_float4(a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w);
}

static __forceinline__ __device__ float4 optixMulFloat4(const float4& a, float b) {
    return make_float4(a.x * b, a.y * b, a.z * b, a.w * b);
}

/** Reads 16 bytes of global memory at a generic, 16-byte aligned address. */
static __forceinline__ __device__ uint4 optixLdg(unsigned long long addr) {
    unsigned long long global;
    uint4 value;
    asm("cvta.to.global.u64 %0, %1;" : "=l"(global) : "l"(addr));
    asm("ld.global.v4.u32 {%0, %1, %2, %3}, [%4];"
        : "=r"(value.x), "=r"(value.y), "=r"(value.z), "=r"(value.w)
        : "l"(global));
    return value;
}

/** Reads a plain struct of global memory whose size and alignment are multiples of 16. */
template <class T>
static __forceinline__ __device__ T optixLoadReadOnlyAlign16(const T* ptr) {
    static_assert(sizeof(T) % sizeof(uint4) == 0, "read in pieces of 16 bytes");
    union Pieces {
        uint4 piece[sizeof(T) / sizeof(uint4)];
        T value;
    } pieces;
    for (unsigned int i = 0; i < sizeof(T) / sizeof(uint4); ++i)
        pieces.piece[i] = optixLdg((unsigned long long)ptr + i * sizeof(uint4));
    return pieces.value;
}

/** vec as a row times the matrix, with the implied fourth row. */
static __forceinline__ __device__ float4 optixMultiplyRowMatrix(const float4 vec, const float4 m0,
                                                                const float4 m1, const float4 m2) {
    return make_float4(vec.x * m0.x + vec.y * m1.x + vec.z * m2.x,
                       vec.x * m0.y + vec.y * m1.y + vec.z * m2.y,
                       vec.x * m0.z + vec.y * m1.z + vec.z * m2.z,
                       vec.x * m0.w + vec.y * m1.w + vec.z * m2.w + vec.w);
}

/** T * R * S of an SRT key with a unit quaternion. */
static __forceinline__ __device__ void optixGetMatrixFromSrt(float4& m0, float4& m1, float4& m2,
                                                             const OptixSRTData& srt) {
    const float xx = srt.qx * srt.qx, yy = srt.qy * srt.qy, zz = srt.qz * srt.qz;
    const float ww = srt.qw * srt.qw;
    const float xy = srt.qx * srt.qy, xz = srt.qx * srt.qz, yz = srt.qy * srt.qz;
    const float wx = srt.qw * srt.qx, wy = srt.qw * srt.qy, wz = srt.qw * srt.qz;
    const float4 s0 = make_float4(srt.sx, srt.a, srt.b, srt.pvx);
    const float4 s1 = make_float4(0.0f, srt.sy, srt.c, srt.pvy);
    const float4 s2 = make_float4(0.0f, 0.0f, srt.sz, srt.pvz);
    const float4 r0 = make_float4(ww + xx - yy - zz, 2.0f * (xy - wz), 2.0f * (xz + wy), srt.tx);
    const float4 r1 = make_float4(2.0f * (xy + wz), ww - xx + yy - zz, 2.0f * (yz - wx), srt.ty);
    const float4 r2 = make_float4(2.0f * (xz - wy), 2.0f * (yz + wx), ww - xx - yy + zz, srt.tz);
    m0 = optixMultiplyRowMatrix(r0, s0, s1, s2);
    m1 = optixMultiplyRowMatrix(r1, s0, s1, s2);
    m2 = optixMultiplyRowMatrix(r2, s0, s1, s2);
}

/** Replaces an affine matrix by its inverse: adjugate over determinant, then the translation. */
static __forceinline__ __device__ void optixInvertMatrix(float4& m0, float4& m1, float4& m2) {
    const float c00 = m1.y * m2.z - m1.z * m2.y;
    const float c10 = m1.z * m2.x - m1.x * m2.z;
    const float c20 = m1.x * m2.y - m1.y * m2.x;
    const float scale = 1.0f / (m0.x * c00 + m0.y * c10 + m0.z * c20);
    const float4 t = make_float4(m0.w, m1.w, m2.w, 0.0f);
    float4 r0 = make_float4(c00, m0.z * m2.y - m0.y * m2.z, m0.y * m1.z - m0.z * m1.y, 0.0f);
    float4 r1 = make_float4(c10, m0.x * m2.z - m0.z * m2.x, m0.z * m1.x - m0.x * m1.z, 0.0f);
    float4 r2 = make_float4(c20, m0.y * m2.x - m0.x * m2.y, m0.x * m1.y - m0.y * m1.x, 0.0f);
    r0 = optixMulFloat4(r0, scale);
    r1 = optixMulFloat4(r1, scale);
    r2 = optixMulFloat4(r2, scale);
    r0.w = -(r0.x * t.x + r0.y * t.y + r0.z * t.z);
    r1.w = -(r1.x * t.x + r1.y * t.y + r1.z * t.z);
    r2.w = -(r2.x * t.x + r2.y * t.y + r2.z * t.z);
    m0 = r0;
    m1 = r1;
    m2 = r2;
}

/** (1 - t) * a + t * b. */
static __forceinline__ __device__ float4 optixLerpFloat4(const float4& a, const float4& b,
                                                         float t) {
    return optixAddFloat4(optixMulFloat4(a, 1.0f - t), optixMulFloat4(b, t));
}

/** The matrix at fraction t1 between the keys at matrix and matrix + 3; t1 = 0 reads the first
 * only. */
static __forceinline__ __device__ void optixLoadInterpolatedMatrixKey(float4& m0, float4& m1,
                                                                      float4& m2,
                                                                      const float4* matrix,
                                                                      const float t1) {
    m0 = optixLoadReadOnlyAlign16(matrix);
    m1 = optixLoadReadOnlyAlign16(matrix + 1);
    m2 = optixLoadReadOnlyAlign16(matrix + 2);
    if (t1 > 0.0f) {
        m0 = optixLerpFloat4(m0, optixLoadReadOnlyAlign16(matrix + 3), t1);
        m1 = optixLerpFloat4(m1, optixLoadReadOnlyAlign16(matrix + 4), t1);
        m2 = optixLerpFloat4(m2, optixLoadReadOnlyAlign16(matrix + 5), t1);
    }
}

/** The same for SRT keys of four float4 each; the quaternion comes out normalised. */
static __forceinline__ __device__ void optixLoadInterpolatedSrtKey(float4& srt0, float4& srt1,
                                                                   float4& srt2, float4& srt3,
                                                                   const float4* srt,
                                                                   const float t1) {
    srt0 = optixLoadReadOnlyAlign16(srt);
    srt1 = optixLoadReadOnlyAlign16(srt + 1);
    srt2 = optixLoadReadOnlyAlign16(srt + 2);
    srt3 = optixLoadReadOnlyAlign16(srt + 3);
    if (t1 > 0.0f) {
        srt0 = optixLerpFloat4(srt0, optixLoadReadOnlyAlign16(srt + 4), t1);
        srt1 = optixLerpFloat4(srt1, optixLoadReadOnlyAlign16(srt + 5), t1);
        srt2 = optixLerpFloat4(srt2, optixLoadReadOnlyAlign16(srt + 6), t1);
        srt3 = optixLerpFloat4(srt3, optixLoadReadOnlyAlign16(srt + 7), t1);
    }
    /* Floats 9 to 12 of the key: qx, qy, qz, qw. */
    float length;
    asm("sqrt.rn.f32 %0, %1;"
        : "=f"(length)
        : "f"(srt2.y * srt2.y + srt2.z * srt2.z + srt2.w * srt2.w + srt3.x * srt3.x));
    const float scale = 1.0f / length;
    srt2.y *= scale;
    srt2.z *= scale;
    srt2.w *= scale;
    srt3.x *= scale;
}

/** Splits a time into a key and the fraction of the way to the next key; the fraction is 0 at the
    last key, after which no memory may be read. */
static __forceinline__ __device__ void optixResolveMotionKey(float& localt, int& key,
                                                             const OptixMotionOptions& options,
                                                             const float globalt) {
    const float last = (float)options.numKeys - 1.0f;
    const float t = (globalt - options.timeBegin) * last / (options.timeEnd - options.timeBegin);
    /* The order of comparisons sends NaN, the result of an empty time range, to the first key. */
    const float clamped = t > 0.0f ? (t < last ? t : last) : 0.0f;
    key = last > 0.0f ? (int)clamped : 0;
    localt = last > 0.0f ? clamped - (float)key : 0.0f;
}

/** Object to world of a matrix motion transform at a time. */
static __forceinline__ __device__ void
optixGetInterpolatedTransformation(float4& trf0, float4& trf1, float4& trf2,
                                   const OptixMatrixMotionTransform* transformData,
                                   const float time) {
    float fraction;
    int key;
    optixResolveMotionKey(fraction, key, transformData->motionOptions, time);
    const float4* keys = (const float4*)&transformData->transform[0][0];
    optixLoadInterpolatedMatrixKey(trf0, trf1, trf2, keys + 3 * key, fraction);
}

/** Object to world of an SRT motion transform at a time. */
static __forceinline__ __device__ void
optixGetInterpolatedTransformation(float4& trf0, float4& trf1, float4& trf2,
                                   const OptixSRTMotionTransform* transformData, const float time) {
    float fraction;
    int key;
    float4 k0, k1, k2, k3;
    optixResolveMotionKey(fraction, key, transformData->motionOptions, time);
    optixLoadInterpolatedSrtKey(k0, k1, k2, k3, (const float4*)transformData->srtData + 4 * key,
                                fraction);
    const OptixSRTData srt = {k0.x, k0.y, k0.z, k0.w, k1.x, k1.y, k1.z, k1.w,
                              k2.x, k2.y, k2.z, k2.w, k3.x, k3.y, k3.z, k3.w};
    optixGetMatrixFromSrt(trf0, trf1, trf2, srt);
}

/** Matrix of one entry of a transform list at a time; identity for other handles. */
static __forceinline__ __device__ void
optixGetInterpolatedTransformationFromHandle(float4& trf0, float4& trf1, float4& trf2,
                                             const OptixTraversableHandle handle, const float time,
                                             const bool objectToWorld) {
    const OptixTransformType type = optixGetTransformTypeFromHandle(handle);
    if (type == OPTIX_TRANSFORM_TYPE_MATRIX_MOTION_TRANSFORM ||
        type == OPTIX_TRANSFORM_TYPE_SRT_MOTION_TRANSFORM) {
        if (type == OPTIX_TRANSFORM_TYPE_MATRIX_MOTION_TRANSFORM)
            optixGetInterpolatedTransformation(
                trf0, trf1, trf2, optixGetMatrixMotionTransformFromHandle(handle), time);
        else
            optixGetInterpolatedTransformation(trf0, trf1, trf2,
                                               optixGetSRTMotionTransformFromHandle(handle), time);
        if (!objectToWorld)
            optixInvertMatrix(trf0, trf1, trf2);
        return;
    }
    const float4* rows;
    if (type == OPTIX_TRANSFORM_TYPE_INSTANCE) {
        rows = objectToWorld ? optixGetInstanceTransformFromHandle(handle)
                             : optixGetInstanceInverseTransformFromHandle(handle);
    } else if (type == OPTIX_TRANSFORM_TYPE_STATIC_TRANSFORM) {
        const OptixStaticTransform* fixed = optixGetStaticTransformFromHandle(handle);
        rows = (const float4*)(objectToWorld ? fixed->transform : fixed->invTransform);
    } else {
        trf0 = make_float4(1.0f, 0.0f, 0.0f, 0.0f);
        trf1 = make_float4(0.0f, 1.0f, 0.0f, 0.0f);
        trf2 = make_float4(0.0f, 0.0f, 1.0f, 0.0f);
        return;
    }
    trf0 = optixLoadReadOnlyAlign16(rows);
    trf1 = optixLoadReadOnlyAlign16(rows + 1);
    trf2 = optixLoadReadOnlyAlign16(rows + 2);
}

/** Matrix of the whole list. The list starts at the root: world to object applies the first entry's
    inverse first, object to world the last entry's matrix first. */
static __forceinline__ __device__ void optixGetListMatrix(float4& m0, float4& m1, float4& m2,
                                                          const bool objectToWorld) {
    const unsigned int size = optixGetTransformListSize();
    const float time = optixGetRayTime();
    m0 = make_float4(1.0f, 0.0f, 0.0f, 0.0f);
    m1 = make_float4(0.0f, 1.0f, 0.0f, 0.0f);
    m2 = make_float4(0.0f, 0.0f, 1.0f, 0.0f);
    for (unsigned int i = 0; i < size; ++i) {
        const OptixTraversableHandle handle =
            optixGetTransformListHandle(objectToWorld ? size - 1 - i : i);
        float4 t0, t1, t2;
        optixGetInterpolatedTransformationFromHandle(t0, t1, t2, handle, time, objectToWorld);
        if (i == 0) { /* the usual single instance: its rows as they are */
            m0 = t0;
            m1 = t1;
            m2 = t2;
            continue;
        }
        const float4 p0 = m0, p1 = m1, p2 = m2;
        m0 = optixMultiplyRowMatrix(t0, p0, p1, p2);
        m1 = optixMultiplyRowMatrix(t1, p0, p1, p2);
        m2 = optixMultiplyRowMatrix(t2, p0, p1, p2);
    }
}

static __forceinline__ __device__ void optixGetWorldToObjectTransformMatrix(float4& m0, float4& m1,
                                                                            float4& m2) {
    optixGetListMatrix(m0, m1, m2, false);
}

static __forceinline__ __device__ void optixGetObjectToWorldTransformMatrix(float4& m0, float4& m1,
                                                                            float4& m2) {
    optixGetListMatrix(m0, m1, m2, true);
}

static __forceinline__ __device__ float3 optixTransformPoint(const float4& m0, const float4& m1,
                                                             const float4& m2, const float3& p) {
    return make_float3(m0.x * p.x + m0.y * p.y + m0.z * p.z + m0.w,
                       m1.x * p.x + m1.y * p.y + m1.z * p.z + m1.w,
                       m2.x * p.x + m2.y * p.y + m2.z * p.z + m2.w);
}

static __forceinline__ __device__ float3 optixTransformVector(const float4& m0, const float4& m1,
                                                              const float4& m2, const float3& v) {
    return make_float3(m0.x * v.x + m0.y * v.y + m0.z * v.z, m1.x * v.x + m1.y * v.y + m1.z * v.z,
                       m2.x * v.x + m2.y * v.y + m2.z * v.z);
}

/** Transforms a normal by the transpose of the given matrix, the inverse of the one for points. */
static __forceinline__ __device__ float3 optixTransformNormal(const float4& m0, const float4& m1,
                                                              const float4& m2, const float3& n) {
    return make_float3(m0.x * n.x + m1.x * n.y + m2.x * n.z, m0.y * n.x + m1.y * n.y + m2.y * n.z,
                       m0.z * n.x + m1.z * n.y + m2.z * n.z);
}

} // namespace optix_impl

#endif
