// SPDX-License-Identifier: Apache-2.0
// Matrices of 2x2 to 4x4 floats, for host and device. optixu_matrix.h makes the names visible
// outside namespace optix. Source: OptiX API reference 6.0, sections 7.31, 7.54 to 7.57, 8.36.
#ifndef SUNSTONE_OPTIXU_MATRIX_NAMESPACE_H
#define SUNSTONE_OPTIXU_MATRIX_NAMESPACE_H

#include "optixu_math_namespace.h"

#define RT_MATRIX_ACCESS(m, i, j) m[i * N + j]
#define RT_MAT_DECL template <unsigned int M, unsigned int N>

namespace optix {

/** The float vector with DIM components. */
template <int DIM>
struct VectorDim {};
template <>
struct VectorDim<2> {
    typedef float2 VectorType;
};
template <>
struct VectorDim<3> {
    typedef float3 VectorType;
};
template <>
struct VectorDim<4> {
    typedef float4 VectorType;
};

/** A matrix with M rows and N columns, stored row by row. It is trivially copyable: the compiler
    generates the copy functions and the destructor. */
RT_MAT_DECL
class Matrix {
public:
    /** A row. */
    typedef typename VectorDim<N>::VectorType floatN;
    /** A column. */
    typedef typename VectorDim<M>::VectorType floatM;

    /** A matrix without values. */
    Matrix() = default;
    /** From M * N elements, row by row. */
    RT_HOSTDEVICE explicit Matrix(const float data[M * N]) {
        for (unsigned int i = 0; i < M * N; ++i)
            m_data[i] = data[i];
    }

    RT_HOSTDEVICE float operator[](unsigned int i) const { return m_data[i]; }
    RT_HOSTDEVICE float& operator[](unsigned int i) { return m_data[i]; }

    /** Row m, below M, and column n, below N. */
    RT_HOSTDEVICE floatN getRow(unsigned int m) const {
        floatN row;
        float* v = &row.x;
        for (unsigned int i = 0; i < N; ++i)
            v[i] = RT_MATRIX_ACCESS(m_data, m, i);
        return row;
    }
    RT_HOSTDEVICE floatM getCol(unsigned int n) const {
        floatM column;
        float* v = &column.x;
        for (unsigned int i = 0; i < M; ++i)
            v[i] = RT_MATRIX_ACCESS(m_data, i, n);
        return column;
    }
    RT_HOSTDEVICE void setRow(unsigned int m, const floatN& r) {
        const float* v = &r.x;
        for (unsigned int i = 0; i < N; ++i)
            RT_MATRIX_ACCESS(m_data, m, i) = v[i];
    }
    RT_HOSTDEVICE void setCol(unsigned int n, const floatM& c) {
        const float* v = &c.x;
        for (unsigned int i = 0; i < M; ++i)
            RT_MATRIX_ACCESS(m_data, i, n) = v[i];
    }

    /** The elements, row by row. */
    RT_HOSTDEVICE float* getData() { return m_data; }
    RT_HOSTDEVICE const float* getData() const { return m_data; }

    RT_HOSTDEVICE Matrix<N, M> transpose() const {
        Matrix<N, M> result;
        for (unsigned int i = 0; i < M; ++i)
            for (unsigned int j = 0; j < N; ++j)
                result[j * M + i] = RT_MATRIX_ACCESS(m_data, i, j);
        return result;
    }

    /** 4x4 only. A matrix with determinant 0 has no inverse: elements become infinite or NaN. */
    RT_HOSTDEVICE Matrix<4, 4> inverse() const;
    /** 3x3 and 4x4 only. */
    RT_HOSTDEVICE float det() const;

    /** 4x4 only: maps of points (x, y, z, 1), as columns. rotate turns counter-clockwise around an
        axis of any length that points to the viewer. */
    static RT_HOSTDEVICE Matrix<4, 4> rotate(const float radians, const float3& axis);
    static RT_HOSTDEVICE Matrix<4, 4> translate(const float3& vec);
    static RT_HOSTDEVICE Matrix<4, 4> scale(const float3& vec);
    /** 4x4 only: the matrix with the columns u, v, w and c. */
    static RT_HOSTDEVICE Matrix<4, 4> fromBasis(const float3& u, const float3& v, const float3& w,
                                                const float3& c);

    static RT_HOSTDEVICE Matrix<N, N> identity() {
        Matrix<N, N> result;
        for (unsigned int i = 0; i < N * N; ++i)
            result[i] = i % (N + 1) == 0 ? 1.0f : 0.0f;
        return result;
    }

    /** An order for containers: compares the first elements that differ. */
    RT_HOSTDEVICE bool operator<(const Matrix<M, N>& rhs) const {
        for (unsigned int i = 0; i < M * N; ++i)
            if (m_data[i] != rhs[i])
                return m_data[i] < rhs[i];
        return false;
    }

private:
    float m_data[M * N];
};

typedef Matrix<2, 2> Matrix2x2;
typedef Matrix<2, 3> Matrix2x3;
typedef Matrix<2, 4> Matrix2x4;
typedef Matrix<3, 2> Matrix3x2;
typedef Matrix<3, 3> Matrix3x3;
typedef Matrix<3, 4> Matrix3x4;
typedef Matrix<4, 2> Matrix4x2;
typedef Matrix<4, 3> Matrix4x3;
typedef Matrix<4, 4> Matrix4x4;

// ---- Operators ----------------------------------------------------------------------------------

RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE bool operator==(const Matrix<M, N>& m1,
                                                        const Matrix<M, N>& m2) {
    for (unsigned int i = 0; i < M * N; ++i)
        if (m1[i] != m2[i])
            return false;
    return true;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE bool operator!=(const Matrix<M, N>& m1,
                                                        const Matrix<M, N>& m2) {
    return !(m1 == m2);
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N>& operator-=(Matrix<M, N>& m1,
                                                                 const Matrix<M, N>& m2) {
    for (unsigned int i = 0; i < M * N; ++i)
        m1[i] -= m2[i];
    return m1;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N>& operator+=(Matrix<M, N>& m1,
                                                                 const Matrix<M, N>& m2) {
    for (unsigned int i = 0; i < M * N; ++i)
        m1[i] += m2[i];
    return m1;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N>& operator*=(Matrix<M, N>& m1, float f) {
    for (unsigned int i = 0; i < M * N; ++i)
        m1[i] *= f;
    return m1;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N>& operator/=(Matrix<M, N>& m1, float f) {
    for (unsigned int i = 0; i < M * N; ++i)
        m1[i] /= f;
    return m1;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N> operator-(const Matrix<M, N>& m1,
                                                               const Matrix<M, N>& m2) {
    Matrix<M, N> result = m1;
    return result -= m2;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N> operator+(const Matrix<M, N>& m1,
                                                               const Matrix<M, N>& m2) {
    Matrix<M, N> result = m1;
    return result += m2;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N> operator/(const Matrix<M, N>& m, float f) {
    Matrix<M, N> result = m;
    return result /= f;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N> operator*(const Matrix<M, N>& m, float f) {
    Matrix<M, N> result = m;
    return result *= f;
}
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, N> operator*(float f, const Matrix<M, N>& m) {
    return m * f;
}

/** Matrix times column; the overloads for two to four rows do the same. */
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE typename Matrix<M, N>::floatM
operator*(const Matrix<M, N>& m, const typename Matrix<M, N>::floatN& v) {
    typename Matrix<M, N>::floatM result;
    float* sums = &result.x;
    for (unsigned int i = 0; i < M; ++i)
        sums[i] = dot(m.getRow(i), v);
    return result;
}
template <unsigned int N>
OPTIXU_INLINE RT_HOSTDEVICE float2 operator*(const Matrix<2, N>& m,
                                             const typename Matrix<2, N>::floatN& vec) {
    return make_float2(dot(m.getRow(0), vec), dot(m.getRow(1), vec));
}
template <unsigned int N>
OPTIXU_INLINE RT_HOSTDEVICE float3 operator*(const Matrix<3, N>& m,
                                             const typename Matrix<3, N>::floatN& vec) {
    return make_float3(dot(m.getRow(0), vec), dot(m.getRow(1), vec), dot(m.getRow(2), vec));
}
template <unsigned int N>
OPTIXU_INLINE RT_HOSTDEVICE float4 operator*(const Matrix<4, N>& m,
                                             const typename Matrix<4, N>::floatN& vec) {
    return make_float4(dot(m.getRow(0), vec), dot(m.getRow(1), vec), dot(m.getRow(2), vec),
                       dot(m.getRow(3), vec));
}
OPTIXU_INLINE RT_HOSTDEVICE float4 operator*(const Matrix<4, 4>& m, const float4& vec) {
    return make_float4(dot(m.getRow(0), vec), dot(m.getRow(1), vec), dot(m.getRow(2), vec),
                       dot(m.getRow(3), vec));
}

/** Row times matrix. */
RT_MAT_DECL OPTIXU_INLINE RT_HOSTDEVICE typename Matrix<M, N>::floatN
operator*(const typename Matrix<M, N>::floatM& v, const Matrix<M, N>& m) {
    typename Matrix<M, N>::floatN result;
    float* sums = &result.x;
    for (unsigned int j = 0; j < N; ++j)
        sums[j] = dot(v, m.getCol(j));
    return result;
}

template <unsigned int M, unsigned int N, unsigned int R>
OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, R> operator*(const Matrix<M, N>& m1, const Matrix<N, R>& m2) {
    Matrix<M, R> result;
    for (unsigned int i = 0; i < M; ++i)
        for (unsigned int k = 0; k < R; ++k) {
            float sum = 0.0f;
            for (unsigned int j = 0; j < N; ++j)
                sum += m1[i * N + j] * m2[j * R + k];
            result[i * R + k] = sum;
        }
    return result;
}
/** m1 = m1 * m2. */
template <unsigned int M>
OPTIXU_INLINE RT_HOSTDEVICE Matrix<M, M>& operator*=(Matrix<M, M>& m1, const Matrix<M, M>& m2) {
    m1 = m1 * m2;
    return m1;
}

// ---- Members of some sizes ----------------------------------------------------------------------

template <>
OPTIXU_INLINE RT_HOSTDEVICE float Matrix<3, 3>::det() const {
    return dot(getRow(0), cross(getRow(1), getRow(2)));
}

namespace internal {

/** The 2x2 minors of a 4x4 matrix's upper two rows, s, and of its lower two, c, in the order of the
    column pairs 01 02 03 12 13 23. Determinant and inverse are sums of their products. */
struct Minors {
    OPTIXU_INLINE RT_HOSTDEVICE explicit Minors(const Matrix<4, 4>& m) {
        unsigned int k = 0;
        for (unsigned int i = 0; i < 3; ++i)
            for (unsigned int j = i + 1; j < 4; ++j, ++k) {
                s[k] = m[i] * m[4 + j] - m[j] * m[4 + i];
                c[k] = m[8 + i] * m[12 + j] - m[8 + j] * m[12 + i];
            }
    }
    OPTIXU_INLINE RT_HOSTDEVICE float det() const {
        return s[0] * c[5] - s[1] * c[4] + s[2] * c[3] + s[3] * c[2] - s[4] * c[1] + s[5] * c[0];
    }

    float s[6];
    float c[6];
};

} // namespace internal

template <>
OPTIXU_INLINE RT_HOSTDEVICE float Matrix<4, 4>::det() const {
    return internal::Minors(*this).det();
}

template <>
OPTIXU_INLINE RT_HOSTDEVICE Matrix<4, 4> Matrix<4, 4>::inverse() const {
    const float* m = m_data;
    const internal::Minors minors(*this);
    const float *s = minors.s, *c = minors.c;
    const float adjugate[16] = {
        m[5] * c[5] - m[6] * c[4] + m[7] * c[3],     -m[1] * c[5] + m[2] * c[4] - m[3] * c[3],
        m[13] * s[5] - m[14] * s[4] + m[15] * s[3],  -m[9] * s[5] + m[10] * s[4] - m[11] * s[3],
        -m[4] * c[5] + m[6] * c[2] - m[7] * c[1],    m[0] * c[5] - m[2] * c[2] + m[3] * c[1],
        -m[12] * s[5] + m[14] * s[2] - m[15] * s[1], m[8] * s[5] - m[10] * s[2] + m[11] * s[1],
        m[4] * c[4] - m[5] * c[2] + m[7] * c[0],     -m[0] * c[4] + m[1] * c[2] - m[3] * c[0],
        m[12] * s[4] - m[13] * s[2] + m[15] * s[0],  -m[8] * s[4] + m[9] * s[2] - m[11] * s[0],
        -m[4] * c[3] + m[5] * c[1] - m[6] * c[0],    m[0] * c[3] - m[1] * c[1] + m[2] * c[0],
        -m[12] * s[3] + m[13] * s[1] - m[14] * s[0], m[8] * s[3] - m[9] * s[1] + m[10] * s[0]};
    return Matrix<4, 4>(adjugate) * (1.0f / minors.det());
}

template <>
OPTIXU_INLINE RT_HOSTDEVICE Matrix<4, 4> Matrix<4, 4>::fromBasis(const float3& u, const float3& v,
                                                                 const float3& w, const float3& c) {
    const float data[16] = {u.x, v.x, w.x, c.x, u.y,  v.y,  w.y,  c.y,
                            u.z, v.z, w.z, c.z, 0.0f, 0.0f, 0.0f, 1.0f};
    return Matrix<4, 4>(data);
}

template <>
OPTIXU_INLINE RT_HOSTDEVICE Matrix<4, 4> Matrix<4, 4>::translate(const float3& vec) {
    return fromBasis(make_float3(1.0f, 0.0f, 0.0f), make_float3(0.0f, 1.0f, 0.0f),
                     make_float3(0.0f, 0.0f, 1.0f), vec);
}

template <>
OPTIXU_INLINE RT_HOSTDEVICE Matrix<4, 4> Matrix<4, 4>::scale(const float3& vec) {
    return fromBasis(make_float3(vec.x, 0.0f, 0.0f), make_float3(0.0f, vec.y, 0.0f),
                     make_float3(0.0f, 0.0f, vec.z), make_float3(0.0f));
}

// Rodrigues' formula: cosine * I + sine * [axis]x + (1 - cosine) * axis * axis^T.
template <>
OPTIXU_INLINE RT_HOSTDEVICE Matrix<4, 4> Matrix<4, 4>::rotate(const float radians,
                                                              const float3& axis) {
    const float3 a = normalize(axis);
    const float sine = ::sinf(radians);
    const float cosine = ::cosf(radians);
    const float3 along = (1.0f - cosine) * a;
    const float3 across = sine * a;
    return fromBasis(along.x * a + make_float3(cosine, across.z, -across.y),
                     along.y * a + make_float3(-across.z, cosine, across.x),
                     along.z * a + make_float3(across.y, -across.x, cosine), make_float3(0.0f));
}

/** The upper left part. */
OPTIXU_INLINE RT_HOSTDEVICE Matrix<3, 3> make_matrix3x3(const Matrix<4, 4>& matrix) {
    Matrix<3, 3> result;
    for (unsigned int i = 0; i < 3; ++i)
        for (unsigned int j = 0; j < 3; ++j)
            result[3 * i + j] = matrix[4 * i + j];
    return result;
}

} // namespace optix

#endif
