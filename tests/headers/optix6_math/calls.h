// SPDX-License-Identifier: Apache-2.0
// Calls any function of the classic API's mathematics by its place in symbols.tsv, for host and
// device. Arguments and results are sequences of numbers, one for each component.
#pragma once

#include <optix_math.h>

namespace math {

// A component: floating-point types use `real`, integer types and bool `whole`.
struct Number {
    double real;
    long long whole;
};

RT_HOSTDEVICE inline void read(const Number*& in, float& v) {
    v = static_cast<float>((in++)->real);
}
RT_HOSTDEVICE inline void write(Number*& out, float v) {
    (out++)->real = v;
}
#define SUNSTONE_WHOLE(T)                                                                          \
    RT_HOSTDEVICE inline void read(const Number*& in, T& v) {                                      \
        v = static_cast<T>((in++)->whole);                                                         \
    }                                                                                              \
    RT_HOSTDEVICE inline void write(Number*& out, T v) {                                           \
        (out++)->whole = static_cast<long long>(v);                                                \
    }
SUNSTONE_WHOLE(bool)
SUNSTONE_WHOLE(int)
SUNSTONE_WHOLE(unsigned int)
SUNSTONE_WHOLE(long long)
SUNSTONE_WHOLE(unsigned long long)
#undef SUNSTONE_WHOLE

#define SUNSTONE_EACH(N, V, Sequence, function)                                                    \
    RT_HOSTDEVICE inline void function(Sequence*& sequence, V v) {                                 \
        for (int i = 0; i < N; ++i)                                                                \
            function(sequence, (&v.x)[i]);                                                         \
    }
#define SUNSTONE_READ_WRITE(N, V)                                                                  \
    SUNSTONE_EACH(N, V&, const Number, read)                                                       \
    SUNSTONE_EACH(N, const V&, Number, write)
#define SUNSTONE_VECTORS(V)                                                                        \
    SUNSTONE_READ_WRITE(1, V##1)                                                                   \
    SUNSTONE_READ_WRITE(2, V##2)                                                                   \
    SUNSTONE_READ_WRITE(3, V##3)                                                                   \
    SUNSTONE_READ_WRITE(4, V##4)
SUNSTONE_VECTORS(float)
SUNSTONE_VECTORS(int)
SUNSTONE_VECTORS(uint)
SUNSTONE_VECTORS(longlong)
SUNSTONE_VECTORS(ulonglong)
#undef SUNSTONE_VECTORS
#undef SUNSTONE_READ_WRITE
#undef SUNSTONE_EACH

template <unsigned int M, unsigned int N>
RT_HOSTDEVICE inline void read(const Number*& in, optix::Matrix<M, N>& m) {
    for (unsigned int i = 0; i < M * N; ++i)
        read(in, m[i]);
}
template <unsigned int M, unsigned int N>
RT_HOSTDEVICE inline void write(Number*& out, const optix::Matrix<M, N>& m) {
    for (unsigned int i = 0; i < M * N; ++i)
        write(out, m[i]);
}
RT_HOSTDEVICE inline void read(const Number*& in, optix::Quaternion& q) {
    read(in, q.m_q);
}
RT_HOSTDEVICE inline void write(Number*& out, const optix::Quaternion& q) {
    write(out, q.m_q);
}
RT_HOSTDEVICE inline void read(const Number*& in, optix::Ray& ray) {
    read(in, ray.origin);
    read(in, ray.direction);
    read(in, ray.ray_type);
    read(in, ray.tmin);
    read(in, ray.tmax);
}

// Case `index`: arguments from `in`; to `out` the result, then the arguments it changes.
RT_HOSTDEVICE inline void call(int index, const Number* in, Number* out) {
    switch (index) {
#include "calls.inc"
    default:
        break;
    }
}

const int kMostNumbers = 32; // of the arguments or results of a call

} // namespace math
