// SPDX-License-Identifier: Apache-2.0
// Every member function of the classes Aabb, Matrix, Onb, Quaternion and Ray, for host and device:
// the results of both must be equal. math_test.cpp has the meaning of each.
#pragma once

#include <optix_math.h>

namespace math {

const int kMemberInputs = 28;
const int kMemberOutputs = 256;

class Outputs {
public:
    RT_HOSTDEVICE explicit Outputs(float* out) : out_(out), count_(0) {}
    RT_HOSTDEVICE void add(float v) {
        if (count_ < kMemberOutputs)
            out_[count_++] = v;
    }
    RT_HOSTDEVICE void add(const float3& v) {
        add(v.x);
        add(v.y);
        add(v.z);
    }
    RT_HOSTDEVICE void add(const float4& v) {
        add(make_float3(v));
        add(v.w);
    }
    RT_HOSTDEVICE void add(const Aabb& box) {
        add(box.m_min);
        add(box.m_max);
    }
    template <unsigned int M, unsigned int N>
    RT_HOSTDEVICE void add(const Matrix<M, N>& m) {
        for (unsigned int i = 0; i < M * N; ++i)
            add(m[i]);
    }

private:
    float* out_;
    int count_;
};

RT_HOSTDEVICE inline void boxes(const float3& a, const float3& b, const float3& c, Outputs& out) {
    Aabb box(a, b, c), other(fminf(a, b), fmaxf(a, b)), empty;
    out.add(empty.valid() ? 1.0f : 0.0f);
    empty.include(a);
    empty.include(other);
    empty.include(b, c);
    out.add(empty);
    out.add(box[0] + box[1]);
    out.add(box == empty ? 1.0f : 0.0f);
    out.add(box.contains(b) && box.contains(other) && box.intersects(other) ? 1.0f : 0.0f);
    out.add(box.center());
    out.add(box.center(1));
    out.add(box.extent());
    out.add(box.extent(2));
    out.add(box.volume() + box.area() + box.halfArea());
    out.add(static_cast<float>(box.longestAxis()) + box.maxExtent());
    out.add(box.isFlat() ? 1.0f : 0.0f);
    box.enlarge(0.5f);
    box.intersection(other);
    out.add(box);
    out.add(box.distance(2.0f * c) + box.distance2(2.0f * c));
    out.add(box.signedDistance(box.center()));
    box.set(a, b);
    box.set(a, b, c);
    out.add(box);
    box.invalidate();
    out.add(box);
}

RT_HOSTDEVICE inline void matrices(const float* data, const float3& a, const float3& b,
                                   const float3& c, Outputs& out) {
    Matrix4x4 m(data);
    out.add(m.inverse());
    out.add(m.transpose());
    out.add(m.det());
    out.add(make_matrix3x3(m).det());
    out.add(Matrix4x4::rotate(0.75f, a));
    out.add(Matrix4x4::translate(b));
    out.add(Matrix4x4::scale(c));
    out.add(Matrix4x4::fromBasis(a, b, c, a));
    out.add(Matrix4x4::identity());
    m.setRow(1, m.getRow(2));
    m.setCol(3, m.getCol(0));
    m[5] += 2.0f * m.getData()[6];
    out.add(m);
    const Matrix4x4 copy = m;
    out.add(copy < m || *copy.getData() != m[0] ? 1.0f : 0.0f);
}

RT_HOSTDEVICE inline void members(const float* in, float* results) {
    Outputs out(results);
    const float3 a = make_float3(in[16], in[17], in[18]);
    const float3 b = make_float3(in[19], in[20], in[21]);
    const float3 c = make_float3(in[22], in[23], in[24]);
    boxes(a, b, c, out);
    matrices(in, a, b, c, out);
    const Onb basis(normalize(a));
    float3 p = b;
    basis.inverse_transform(p);
    out.add(p);
    out.add(basis.m_tangent);
    out.add(basis.m_binormal);
    const Quaternion turn(a, 40.0f), same(turn), parts(turn.m_q), four(0.0f, 0.0f, 0.0f, 1.0f);
    float rows[16];
    same.toMatrix(rows);
    out.add(Matrix4x4(rows));
    out.add(parts * b + four * c + Quaternion() * a);
    const Ray ray(a, b, 3u, 0.5f), made = make_Ray(a, b, 2u, 0.25f, 8.0f), copied(ray);
    out.add(ray.origin + made.direction + copied.direction);
    out.add(ray.tmax * 1e-27f + made.tmax + ray.tmin + made.tmin +
            static_cast<float>(ray.ray_type + made.ray_type));
}

} // namespace math
