// SPDX-License-Identifier: Apache-2.0
// Device mathematics in double precision against the host's: the largest error of each function in
// units of the last place, over many ranges. float_mathematics.cu has single precision.
#include <cuda_runtime.h>

#include "check.h"

#include <cmath>
#include <vector>

enum { kFunctions = 24 };

__device__ double evaluate(int f, double x) {
    switch (f) {
    case 0:
        return sin(x);
    case 1:
        return cos(x);
    case 2:
        return tan(x);
    case 3:
        return exp(x);
    case 4:
        return log(x);
    case 5:
        return log2(x);
    case 6:
        return log10(x);
    case 7:
        return exp2(x);
    case 8:
        return expm1(x);
    case 9:
        return log1p(x);
    case 10:
        return asin(x);
    case 11:
        return acos(x);
    case 12:
        return atan(x);
    case 13:
        return sinh(x);
    case 14:
        return cosh(x);
    case 15:
        return tanh(x);
    case 16:
        return cbrt(x);
    case 17:
        return erf(x);
    case 18:
        return erfc(x);
    case 19:
        return tgamma(x);
    case 20:
        return pow(x, 1.7);
    case 21:
        return fmod(x, 0.37);
    case 22:
        return atan2(x, -2.5);
    default:
        return hypot(x, 3.0);
    }
}
static double reference(int f, double x) {
    switch (f) {
    case 0:
        return std::sin(x);
    case 1:
        return std::cos(x);
    case 2:
        return std::tan(x);
    case 3:
        return std::exp(x);
    case 4:
        return std::log(x);
    case 5:
        return std::log2(x);
    case 6:
        return std::log10(x);
    case 7:
        return std::exp2(x);
    case 8:
        return std::expm1(x);
    case 9:
        return std::log1p(x);
    case 10:
        return std::asin(x);
    case 11:
        return std::acos(x);
    case 12:
        return std::atan(x);
    case 13:
        return std::sinh(x);
    case 14:
        return std::cosh(x);
    case 15:
        return std::tanh(x);
    case 16:
        return std::cbrt(x);
    case 17:
        return std::erf(x);
    case 18:
        return std::erfc(x);
    case 19:
        return std::tgamma(x);
    case 20:
        return std::pow(x, 1.7);
    case 21:
        return std::fmod(x, 0.37);
    case 22:
        return std::atan2(x, -2.5);
    default:
        return std::hypot(x, 3.0);
    }
}
static const char* const kNames[kFunctions] = {
    "sin",   "cos",   "tan",  "exp",    "log",  "log2", "log10", "exp2",
    "expm1", "log1p", "asin", "acos",   "atan", "sinh", "cosh",  "tanh",
    "cbrt",  "erf",   "erfc", "tgamma", "pow",  "fmod", "atan2", "hypot"};

__global__ void run(int f, const double* in, double* out, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        out[i] = evaluate(f, in[i]);
}

static double ulps(double a, double b) {
    if (a == b || (std::isnan(a) && std::isnan(b)))
        return 0;
    if (!std::isfinite(a) || !std::isfinite(b))
        return 1e9;
    int e;
    std::frexp(b, &e);
    return std::fabs(a - b) / std::ldexp(1.0, std::max(e, -1021) - 53);
}

int main() {
    // Powers of many sizes, both signs, and the special values.
    std::vector<double> in = {0.0,  -0.0, INFINITY, -INFINITY, NAN,  1.0,
                              -1.0, 0.5,  2.0,      5e-324,    1e308};
    unsigned long long seed = 12345;
    for (int i = 0; i < 40000; ++i) {
        seed = seed * 6364136223846793005ull + 1442695040888963407ull;
        const double unit = double(seed >> 11) * 0x1p-53;
        const double scale = i % 4 == 0 ? 1.0 : i % 4 == 1 ? 30.0 : i % 4 == 2 ? 1e-3 : 1e6;
        in.push_back((i & 8 ? -1 : 1) * unit * scale);
        if (i % 16 == 0)
            in.push_back(std::ldexp(unit, i % 2000 - 1000));
    }
    const int n = int(in.size());
    double *din, *dout;
    CHECK(cudaMallocManaged(&din, n * sizeof(double)));
    CHECK(cudaMallocManaged(&dout, n * sizeof(double)));
    for (int i = 0; i < n; ++i)
        din[i] = in[i];
    int bad = 0;
    for (int f = 0; f < kFunctions; ++f) {
        run<<<(n + 127) / 128, 128>>>(f, din, dout, n);
        CHECK(cudaDeviceSynchronize());
        double worst = 0, at = 0;
        for (int i = 0; i < n; ++i) {
            const double u = ulps(dout[i], reference(f, in[i]));
            if (u > worst) {
                worst = u;
                at = in[i];
            }
        }
        const double limit = f == 19 ? 40 : f == 18 || f == 17 ? 16 : 4;
        if (worst > limit) {
            std::printf("%s: %.2f ulp at %.17g\n", kNames[f], worst, at);
            ++bad;
        }
    }
    std::printf("%d functions out of bounds\n", bad);
    return bad;
}
