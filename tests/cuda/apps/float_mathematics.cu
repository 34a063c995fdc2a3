// SPDX-License-Identifier: Apache-2.0
// Device mathematics in single precision against the host's in double precision, for floats of all
// sizes and the special values: the largest error in units of the last place, infinities, NaNs and
// the signs of zeros. The bounds are those of the CUDA C++ Programming Guide, "Mathematical
// Functions", or below; nvcc's coshf has 2.13 on an H100, where the guide says 2.
#include <cuda_runtime.h>

#include "check.h"

#include <cmath>
#include <cstring>
#include <vector>

static double sineOfTurns(double halfTurns) {
    const long double part = fmodl(halfTurns, 2), pi = 3.14159265358979323846264338327950288L;
    if (part == 0 || part == 1 || part == -1)
        return std::copysign(0.0, halfTurns);
    return double(sinl(pi * part));
}
static double cosineOfTurns(double halfTurns) {
    return 0.0 + sineOfTurns(std::fmod(std::fabs(halfTurns), 2.0) + 0.5);
}

// Name, on the device, on the host, bound.
#define FUNCTIONS(F)                                                                               \
    F(sinf, sinf(x), std::sin(d), 2)                                                               \
    F(cosf, cosf(x), std::cos(d), 2)                                                               \
    F(tanf, tanf(x), std::tan(d), 4)                                                               \
    F(sincosf_sine, (sincosf(x, &r, &rest), r), std::sin(d), 2)                                    \
    F(sincosf_cosine, (sincosf(x, &rest, &r), r), std::cos(d), 2)                                  \
    F(sinpif, sinpif(x), sineOfTurns(d), 1)                                                        \
    F(cospif, cospif(x), cosineOfTurns(d), 1)                                                      \
    F(sincospif_sine, (sincospif(x, &r, &rest), r), sineOfTurns(d), 1)                             \
    F(sincospif_cosine, (sincospif(x, &rest, &r), r), cosineOfTurns(d), 1)                         \
    F(expf, expf(x), std::exp(d), 2)                                                               \
    F(exp2f, exp2f(x), std::exp2(d), 2)                                                            \
    F(exp10f, exp10f(x), std::pow(10.0, d), 2)                                                     \
    F(logf, logf(x), std::log(d), 1)                                                               \
    F(log2f, log2f(x), std::log2(d), 1)                                                            \
    F(log10f, log10f(x), std::log10(d), 2)                                                         \
    F(powf_root, powf(x, 0.3f), std::pow(d, double(0.3f)), 4)                                      \
    F(powf_cube, powf(x, -3.0f), std::pow(d, -3.0), 4)                                             \
    F(powf_high, powf(x, 80.3f), std::pow(d, double(80.3f)), 4)                                    \
    F(powf_of_1_3, powf(1.3f, x), std::pow(double(1.3f), d), 4)                                    \
    F(powf_near_1, powf(0.99999f, x), std::pow(double(0.99999f), d), 4)                            \
    F(powf_of_minus_2, powf(-2.0f, x), std::pow(-2.0, d), 4)                                       \
    F(powf_of_0, powf(-0.0f, x), std::pow(-0.0, d), 4)                                             \
    F(powf_of_infinity, powf(-INFINITY, x), std::pow(double(-INFINITY), d), 4)                     \
    F(powf_infinite, powf(x, INFINITY), std::pow(d, double(INFINITY)), 4)                          \
    F(asinf, asinf(x), std::asin(d), 2)                                                            \
    F(acosf, acosf(x), std::acos(d), 2)                                                            \
    F(atanf, atanf(x), std::atan(d), 2)                                                            \
    F(atan2f_right, atan2f(x, 2.5f), std::atan2(d, 2.5), 3)                                        \
    F(atan2f_left, atan2f(x, -2.5f), std::atan2(d, -2.5), 3)                                       \
    F(atan2f_below, atan2f(-3.0f, x), std::atan2(-3.0, d), 3)                                      \
    F(atan2f_axis, atan2f(-0.0f, x), std::atan2(-0.0, d), 3)                                       \
    F(atan2f_infinite, atan2f(x, -INFINITY), std::atan2(d, double(-INFINITY)), 3)                  \
    F(sinhf, sinhf(x), std::sinh(d), 3)                                                            \
    F(coshf, coshf(x), std::cosh(d), 2.25)                                                         \
    F(tanhf, tanhf(x), std::tanh(d), 2)                                                            \
    F(hypotf, hypotf(x, 3.0f), std::hypot(d, 3.0), 3)                                              \
    F(hypotf_small, hypotf(x, 1e-42f), std::hypot(d, double(1e-42f)), 3)                           \
    F(hypotf_large, hypotf(x, 2e38f), std::hypot(d, double(2e38f)), 3)                             \
    F(hypotf_infinite, hypotf(x, -INFINITY), std::hypot(d, double(INFINITY)), 3)                   \
    F(fmodf, fmodf(x, 0.37f), std::fmod(d, double(0.37f)), 0)                                      \
    F(fmodf_small, fmodf(x, -3e-44f), std::fmod(d, double(-3e-44f)), 0)                            \
    F(fmodf_large, fmodf(x, 3e37f), std::fmod(d, double(3e37f)), 0)                                \
    F(fmodf_by, fmodf(-1e30f, x), std::fmod(double(-1e30f), d), 0)                                 \
    F(cbrtf, cbrtf(x), std::cbrt(d), 1)                                                            \
    F(expm1f, expm1f(x), std::expm1(d), 2)                                                         \
    F(log1pf, log1pf(x), std::log1p(d), 1)                                                         \
    F(erff, erff(x), std::erf(d), 2)

#define NUMBER(name, device, host, bound) k_##name,
enum { FUNCTIONS(NUMBER) kFunctions };
#define NAME(name, device, host, bound) {#name, bound},
struct Function {
    const char* name;
    double bound;
};
static const Function kTable[] = {FUNCTIONS(NAME)};

__device__ float evaluate(int f, float x) {
    float r, rest;
    (void)r, (void)rest;
#define DEVICE(name, device, host, bound)                                                          \
    case k_##name: return device;
    switch (f) { FUNCTIONS(DEVICE) }
    return 0;
}
static double reference(int f, double d) {
#define HOST(name, device, host, bound)                                                            \
    case k_##name: return host;
    switch (f) { FUNCTIONS(HOST) }
    return 0;
}

__global__ void run(int f, const float* in, float* out, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        out[i] = evaluate(f, in[i]);
}

// The error in units of the last place; a large number where the kinds differ.
static double errorOf(float got, double exact) {
    const double kWrong = 1e9;
    const float nearest = float(exact);
    if (std::isnan(nearest) || std::isnan(got))
        return std::isnan(nearest) && std::isnan(got) ? 0 : kWrong;
    const double largest = 0x1.fffffep+127, step = 0x1p+104;
    if (std::isinf(nearest) || std::isinf(got)) // the last numbers may be rounded to infinity
        return got == nearest || std::fabs(std::fabs(exact) - largest) < 4 * step ? 0 : kWrong;
    if ((got == 0 || nearest == 0) && std::signbit(got) != std::signbit(nearest))
        return kWrong;
    int e;
    std::frexp(nearest, &e);
    const int place = nearest == 0 || e < -125 ? -149 : e - 24;
    return std::fabs(got - exact) / std::ldexp(1.0, place);
}

static std::vector<float> inputs() {
    std::vector<float> in = {0.0f, -0.0f, 1.0f, -1.0f, 0.5f, -0.5f, INFINITY, -INFINITY, NAN, 2.0f};
    for (unsigned long long bits = 0; bits < 1ull << 32; bits += 32771) {
        const unsigned pattern = unsigned(bits);
        float x;
        std::memcpy(&x, &pattern, 4);
        in.push_back(x);
    }
    for (int i = -6000; i <= 6000; ++i) { // where most functions do most of their work
        in.push_back(float(i) / 512);
        in.push_back(1.0f + float(i) * 0x1p-24f);
    }
    return in;
}

int main() {
    const std::vector<float> in = inputs();
    const int n = int(in.size());
    float *din, *dout;
    CHECK(cudaMallocManaged(&din, in.size() * sizeof(float)));
    CHECK(cudaMallocManaged(&dout, in.size() * sizeof(float)));
    std::memcpy(din, in.data(), in.size() * sizeof(float));
    int bad = 0;
    for (int f = 0; f < kFunctions; ++f) {
        run<<<(n + 127) / 128, 128>>>(f, din, dout, n);
        CHECK(cudaDeviceSynchronize());
        double worst = 0;
        float at = 0, got = 0;
        for (int i = 0; i < n; ++i) {
            const double error = errorOf(dout[i], reference(f, in[i]));
            if (error > worst) {
                worst = error;
                at = in[i];
                got = dout[i];
            }
        }
        if (worst > kTable[f].bound) {
            std::printf("%s: %.2f ulp at %a: %a, not %a\n", kTable[f].name, worst, at, got,
                        reference(f, at));
            ++bad;
        }
    }
    std::printf("%d functions out of bounds\n", bad);
    return bad;
}
