// SPDX-License-Identifier: Apache-2.0
// Quaternions as rotations, for host and device. optixu_quaternion.h makes the name visible outside
// namespace optix. Source: OptiX API reference 6.0, sections 7.38, 8.38.
#ifndef SUNSTONE_OPTIXU_QUATERNION_NAMESPACE_H
#define SUNSTONE_OPTIXU_QUATERNION_NAMESPACE_H

#include "optixu_math_namespace.h"

namespace optix {

/** x, y and z are the imaginary parts, w is the real part. A rotation has length 1. */
class Quaternion {
public:
    /** The identity. */
    RT_HOSTDEVICE Quaternion() : m_q(make_float4(0.0f, 0.0f, 0.0f, 1.0f)) {}
    RT_HOSTDEVICE Quaternion(float x, float y, float z, float w) : m_q(make_float4(x, y, z, w)) {}
    RT_HOSTDEVICE Quaternion(float4 v) : m_q(v) {}
    /** A rotation around an axis of any length, by an angle in degrees. */
    RT_HOSTDEVICE Quaternion(const float3& axis, float angle) {
        const float half = angle * 0.0087266462599716479f;
        m_q = make_float4(::sinf(half) * normalize(axis), ::cosf(half));
    }

    /** The rotation as a 4x4 matrix, row by row. */
    RT_HOSTDEVICE void toMatrix(float m[16]) const {
        const float x = m_q.x, y = m_q.y, z = m_q.z, w = m_q.w;
        const float rows[16] = {1.0f - 2.0f * (y * y + z * z),
                                2.0f * (x * y - z * w),
                                2.0f * (x * z + y * w),
                                0.0f,
                                2.0f * (x * y + z * w),
                                1.0f - 2.0f * (x * x + z * z),
                                2.0f * (y * z - x * w),
                                0.0f,
                                2.0f * (x * z - y * w),
                                2.0f * (y * z + x * w),
                                1.0f - 2.0f * (x * x + y * y),
                                0.0f,
                                0.0f,
                                0.0f,
                                0.0f,
                                1.0f};
        for (int i = 0; i < 16; ++i)
            m[i] = rows[i];
    }

    /** x, y, z, w. */
    float4 m_q;
};

/** v, rotated. */
OPTIXU_INLINE RT_HOSTDEVICE float3 operator*(const Quaternion& quat, const float3& v) {
    const float3 axis = make_float3(quat.m_q);
    const float3 across = 2.0f * cross(axis, v);
    return v + quat.m_q.w * across + cross(axis, across);
}
/** The rotated x, y and z of v, and its w. */
OPTIXU_INLINE RT_HOSTDEVICE float4 operator*(const Quaternion& quat, const float4& v) {
    return make_float4(quat * make_float3(v), v.w);
}

/** Interpolates the four numbers and normalises the result. It follows the shorter arc only if the
    dot product of the two is at least 0. */
OPTIXU_INLINE RT_HOSTDEVICE Quaternion nlerp(const Quaternion& quat0, const Quaternion& quat1,
                                             float t) {
    return Quaternion(normalize(lerp(quat0.m_q, quat1.m_q, t)));
}

} // namespace optix

#endif
