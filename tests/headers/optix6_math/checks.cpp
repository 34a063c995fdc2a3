// SPDX-License-Identifier: Apache-2.0
// Compiles only if the mathematical headers of the classic API have every name and signature of
// symbols.tsv. Host and device compilers read it; NVRTC gets the headers without a toolkit's.
#include <optix_math.h>
#ifndef __CUDACC__
#include <optixu/optixu_math_stream.h>
#endif

template <typename A, typename B>
struct SameType {
    static const bool value = false;
};
template <typename A>
struct SameType<A, A> {
    static const bool value = true;
};

// Constants that programs take from the headers; NVRTC has no C library with them.
static_assert(SameType<decltype(M_PIf + M_PI_2f + M_1_PIf), float>::value, "constants are floats");
static_assert(M_PIf > 3.14159f && M_PI_2f < 1.5708f && M_1_PIf < 0.31831f, "values of constants");

template <typename T>
RT_HOSTDEVICE T value();

#include "checks.inc"
#ifndef __CUDACC__
#include "host_checks.inc"
#endif

// The names outside namespace optix, from a namespace with operators of its own.
namespace application {

struct Spectrum {
    float power;
};
RT_HOSTDEVICE inline Spectrum operator*(Spectrum a, Spectrum b) {
    Spectrum product = {a.power * b.power};
    return product;
}

RT_HOSTDEVICE inline float names(const float3& a, const float3& b) {
    const Spectrum square = Spectrum{2.0f} * Spectrum{2.0f};
    const Matrix4x4 turn = Matrix4x4::rotate(1.0f, a);
    const Aabb box(a, b);
    const Ray ray = make_Ray(a, normalize(b), 0u, 0.0f, RT_DEFAULT_MAX);
    const float4 p = turn * make_float4(a + 2 * b, 1.0f);
    return square.power + dot(make_float3(p), cross(a, b)) + fminf(box.extent()) + ray.tmin +
           fmaxf(1.0f, 2.0f) + static_cast<float>(max(1, 2)) + (Quaternion() * b).x;
}

} // namespace application

// A using directive beside the declarations above changes nothing.
using namespace optix;

RT_HOSTDEVICE inline float directive(const float3& a) {
    const uint count = max(1u, 2u);
    return length(make_float3(0.5f) * a) + floor(make_float2(a)).x + expf(a).y +
           static_cast<float>(count);
}

#ifdef __CUDACC__
extern "C" __global__ void use(float* out, float3 a, float3 b) {
    *out = application::names(a, b) + directive(a);
}
#else
int main() {
    const float3 a = make_float3(1.0f, 2.0f, 3.0f);
    return application::names(a, a) + directive(a) > 0.0f ? 0 : 1;
}
#endif
