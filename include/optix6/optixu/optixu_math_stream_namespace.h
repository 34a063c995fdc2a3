// SPDX-License-Identifier: Apache-2.0
// Stream operators of vectors, matrices and boxes, for the host. Output separates numbers by
// blanks: matrices row by row, the minimum of a box before its maximum. Input skips white space.
// Source: OptiX API reference 6.0, section 8.34.
#ifndef SUNSTONE_OPTIXU_MATH_STREAM_NAMESPACE_H
#define SUNSTONE_OPTIXU_MATH_STREAM_NAMESPACE_H

#include "optixu_aabb_namespace.h"
#include "optixu_math_namespace.h"
#include "optixu_matrix_namespace.h"

#include <istream>
#include <ostream>

namespace optix {

namespace internal {

template <typename T>
inline std::ostream& writeNumbers(std::ostream& os, const T* numbers, unsigned int count) {
    for (unsigned int i = 0; i < count; ++i)
        (i == 0 ? os : os << ' ') << numbers[i];
    return os;
}

template <typename T>
inline std::istream& readNumbers(std::istream& is, T* numbers, unsigned int count) {
    for (unsigned int i = 0; i < count; ++i)
        is >> numbers[i];
    return is;
}

} // namespace internal

inline std::ostream& operator<<(std::ostream& os, const optix::Aabb& aabb) {
    internal::writeNumbers(os, &aabb.m_min.x, 3) << ' ';
    return internal::writeNumbers(os, &aabb.m_max.x, 3);
}

#define SUNSTONE_STREAMED(V, N)                                                                    \
    inline std::ostream& operator<<(std::ostream& os, const optix::V##N& v) {                      \
        return internal::writeNumbers(os, &v.x, N);                                                \
    }                                                                                              \
    inline std::istream& operator>>(std::istream& is, optix::V##N& v) {                            \
        return internal::readNumbers(is, &v.x, N);                                                 \
    }
SUNSTONE_STREAMED(float, 4)
SUNSTONE_STREAMED(float, 3)
SUNSTONE_STREAMED(float, 2)
SUNSTONE_STREAMED(int, 4)
SUNSTONE_STREAMED(int, 3)
SUNSTONE_STREAMED(int, 2)
SUNSTONE_STREAMED(uint, 4)
SUNSTONE_STREAMED(uint, 3)
SUNSTONE_STREAMED(uint, 2)
#undef SUNSTONE_STREAMED

template <unsigned int M, unsigned int N>
inline std::ostream& operator<<(std::ostream& os, const optix::Matrix<M, N>& m) {
    return internal::writeNumbers(os, m.getData(), M * N);
}
template <unsigned int M, unsigned int N>
inline std::istream& operator>>(std::istream& is, optix::Matrix<M, N>& m) {
    return internal::readNumbers(is, m.getData(), M * N);
}

} // namespace optix

#endif
