// SPDX-License-Identifier: Apache-2.0
// Bessel functions, inverses of error functions and lengths of vectors against the host's long
// double results: within the bounds that CUDA's documentation states.
#include "check.h"

#include <cmath>
#include <vector>

namespace {

#define FUNCTIONS(X)                                                                               \
    X(j0) X(j1) X(y0) X(y1) X(cyl_bessel_i0) X(cyl_bessel_i1) X(erfcx) X(erfinv) X(erfcinv)        \
    X(normcdfinv) X(norm3) X(rnorm3) X(norm4) X(j5) X(y5)
enum Which {
#define ENUMERATE(f) k_##f,
    FUNCTIONS(ENUMERATE) kFunctions
};
const char* const kNames[] = {
#define NAME(f) #f,
    FUNCTIONS(NAME)};

__device__ double norm3(double x) { return norm3d(x, 0.5, -2.0); }
__device__ float norm3f(float x) { return norm3df(x, 0.5f, -2.0f); }
__device__ double rnorm3(double x) { return rnorm3d(x, 0.5, -2.0); }
__device__ float rnorm3f(float x) { return rnorm3df(x, 0.5f, -2.0f); }
__device__ double norm4(double x) { return norm4d(x, 0.5, -2.0, 3.0); }
__device__ float norm4f(float x) { return norm4df(x, 0.5f, -2.0f, 3.0f); }
__device__ double j5(double x) { return jn(5, x); }
__device__ float j5f(float x) { return jnf(5, x); }
__device__ double y5(double x) { return yn(5, x); }
__device__ float y5f(float x) { return ynf(5, x); }

__global__ void evaluate(int which, const double* x, double* wide, float* narrow, int count) {
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
    if (i >= count)
        return;
    switch (which) {
#define CASE(F)                                                                                    \
    case k_##F:                                                                                    \
        wide[i] = F(x[i]);                                                                         \
        narrow[i] = F##f((float)x[i]);                                                             \
        break;
        FUNCTIONS(CASE)
    }
}

// y with g(y) = x, by Newton's method from a good start.
template <class G, class D>
long double inverse(long double x, long double start, G g, D derivative) {
    for (int i = 0; i < 4; ++i)
        start -= (g(start) - x) / derivative(start);
    return start;
}
long double besselI(long double x, int order) {
    const long double value = std::cyl_bessel_i((long double)order, std::fabs(x));
    return order == 1 && x < 0 ? -value : value;
}
long double erfcScaled(long double x) {
    if (x < 20)
        return expl(x * x) * erfcl(x);
    long double f = 0;
    for (int k = 60; k > 0; --k)
        f = 0.5L * k / (x + f);
    return 0.564189583547756286948079L / (x + f);
}
long double erfDerivative(long double y) {
    return 1.12837916709551257389616L * expl(-y * y);
}
long double reference(int which, long double x, long double start) {
    switch (which) {
    case k_j0: return j0l(x);
    case k_j1: return j1l(x);
    case k_y0: return y0l(x);
    case k_y1: return y1l(x);
    case k_j5: return jnl(5, x);
    case k_y5: return ynl(5, x);
    case k_cyl_bessel_i0: return besselI(x, 0);
    case k_cyl_bessel_i1: return besselI(x, 1);
    case k_erfcx: return erfcScaled(x);
    case k_erfinv:
        return std::fabs(x) < 0.5L
                   ? inverse(x, start, erfl, erfDerivative)
                   : copysignl(inverse(1 - std::fabs(x), std::fabs(start), erfcl,
                                       [](long double y) { return -erfDerivative(y); }),
                               x);
    case k_erfcinv:
        return inverse(x, start, erfcl, [](long double y) { return -erfDerivative(y); });
    case k_normcdfinv: {
        const long double root = sqrtl(2.0L);
        return -root * inverse(2 * x, -start / root, erfcl,
                               [](long double y) { return -erfDerivative(y); });
    }
    case k_norm3: return sqrtl(x * x + 4.25L);
    case k_rnorm3: return 1 / sqrtl(x * x + 4.25L);
    default: return sqrtl(x * x + 13.25L);
    }
}

struct Bounds {
    double wide, narrow;       // units of the last place
    double wideFar, narrowFar; // absolute, where |x| >= far; 0: the other ones apply
    double least, largest;     // arguments
    double far = 8;
};
Bounds boundsOf(int which) {
    switch (which) {
    case k_j0: return {7, 9, 5e-12, 2.2e-6, -60, 60};
    case k_j1: return {7, 9, 5e-12, 2.2e-6, -60, 60};
    case k_y0: return {7, 9, 5e-12, 2.2e-6, 1e-3, 60};
    case k_y1: return {7, 9, 5e-12, 2.2e-6, 1e-3, 60};
    case k_j5: return {1, 1, 5e-12, 2.2e-6, -60, 60, 0};
    case k_y5: return {40, 15, 5e-12, 2.2e-6, 1e-2, 60, 5};
    case k_cyl_bessel_i0: return {6, 6, 0, 0, -80, 80};
    case k_cyl_bessel_i1: return {6, 6, 0, 0, -80, 80};
    case k_erfcx: return {4, 4, 0, 0, -8, 50};
    case k_erfinv: return {5, 2, 0, 0, -1, 1};
    case k_erfcinv: return {6, 4, 0, 0, 0, 2};
    case k_normcdfinv: return {8, 5, 0, 0, 0, 1};
    case k_norm3: return {2, 3, 0, 0, -20, 20};
    case k_rnorm3: return {1, 2, 0, 0, -20, 20};
    default: return {2, 3, 0, 0, -20, 20};
    }
}

double unitsApart(double got, long double expected, int bits) {
    int exponent = 0;
    std::frexp(double(expected), &exponent);
    return double(std::fabs((long double)got - expected) / ldexpl(1, exponent - bits));
}

} // namespace

int main() {
    constexpr int kCount = 4096;
    double *x, *wide;
    float* narrow;
    CHECK(cudaMallocManaged(&x, kCount * sizeof *x));
    CHECK(cudaMallocManaged(&wide, kCount * sizeof *wide));
    CHECK(cudaMallocManaged(&narrow, kCount * sizeof *narrow));
    int outside = 0;
    for (int which = 0; which < kFunctions; ++which) {
        const Bounds bounds = boundsOf(which);
        unsigned state = 12345u + unsigned(which);
        for (int i = 0; i < kCount; ++i) {
            state = state * 1664525u + 1013904223u;
            const double t = (state >> 8) / 16777216.0;
            x[i] = bounds.least + (bounds.largest - bounds.least) * t;
            // Close to the least argument, or to zero, too.
            if (i % 4 == 0)
                x[i] = bounds.least < 0 ? (i % 8 ? -1 : 1) * std::exp2(-30 * t)
                                        : bounds.least + bounds.largest * 0.25 * std::exp2(-40 * t);
            x[i] = float(x[i]);
            if (x[i] <= bounds.least || x[i] >= bounds.largest)
                x[i] = 0.5 * (bounds.least + bounds.largest) + 0.25;
        }
        evaluate<<<kCount / 128, 128>>>(which, x, wide, narrow, kCount);
        CHECK(cudaDeviceSynchronize());
        double worstWide = 0, worstNarrow = 0, atWide = 0, atNarrow = 0;
        for (int i = 0; i < kCount; ++i) {
            const long double expected = reference(which, x[i], wide[i]);
            const bool isFar = bounds.wideFar > 0 && std::fabs(x[i]) >= bounds.far;
            double apart = isFar ? double(std::fabs(wide[i] - expected)) / bounds.wideFar * bounds.wide
                                 : unitsApart(wide[i], expected, 53);
            if (!(apart <= worstWide)) {
                worstWide = apart;
                atWide = x[i];
            }
            apart = isFar
                        ? double(std::fabs(narrow[i] - expected)) / bounds.narrowFar * bounds.narrow
                        : unitsApart(narrow[i], expected, 24);
            if (!(apart <= worstNarrow)) {
                worstNarrow = apart;
                atNarrow = x[i];
            }
        }
        if (!(worstWide <= bounds.wide) || !(worstNarrow <= bounds.narrow)) {
            ++outside;
            std::printf("%s: double %g units at %.17g, float %g at %.9g; bounds %g and %g\n",
                        kNames[which], worstWide, atWide, worstNarrow, atNarrow, bounds.wide,
                        bounds.narrow);
        }
    }
    std::printf("%d functions out of bounds\n", outside);
    return 0;
}
