// SPDX-License-Identifier: Apache-2.0
// Direct callables: arguments and results of several shapes, called from every program kind that
// may call them, and callables that call others.
#include <optix.h>

#include "callables.h"

extern "C" {
__constant__ CallableParams params;
}

struct CallableData {
    unsigned value;
};

static __forceinline__ __device__ unsigned recordValue() {
    return reinterpret_cast<const CallableData*>(optixGetSbtDataPointer())->value;
}

extern "C" __device__ unsigned __direct_callable__add(unsigned a, unsigned b) { return a + b; }

extern "C" __device__ float __direct_callable__mixed(float a, int b, double c, unsigned long long d,
                                                     short e, char f, bool g) {
    return a + static_cast<float>(b) + static_cast<float>(c) + static_cast<float>(d) +
           static_cast<float>(e) + static_cast<float>(f) + (g ? 0.5f : 0.25f);
}

extern "C" __device__ Pair __direct_callable__swap(Pair pair) {
    Pair out;
    out.first = pair.second;
    out.second = pair.first + 1.0f;
    return out;
}

extern "C" __device__ Large __direct_callable__large(Large in, unsigned scale) {
    Large out;
    for (int i = 0; i < 12; ++i)
        out.words[i] = in.words[11 - i] * scale;
    out.sum = in.sum + 0.5;
    return out;
}

extern "C" __device__ void __direct_callable__store(unsigned* where, unsigned value) {
    *where = value + recordValue();
}

extern "C" __device__ unsigned __direct_callable__launch() {
    return optixGetLaunchIndex().x * 10 + optixGetLaunchDimensions().x + recordValue() * 1000;
}

extern "C" __device__ double __direct_callable__wide(double a, double b) { return a * b; }

// Calls the callable `index` levels down: 1 + f(n - 1).
extern "C" __device__ unsigned __direct_callable__nested(unsigned n) {
    if (n == 0)
        return optixDirectCall<unsigned, unsigned, unsigned>(kCallAdd, 40u, 2u);
    return 1 + optixDirectCall<unsigned, unsigned>(kCallNested, n - 1);
}

// A callable must see its own record, and the caller its own after the call.
extern "C" __device__ unsigned __direct_callable__outer() {
    const unsigned before = recordValue();
    const unsigned inner = optixDirectCall<unsigned>(kCallLaunch);
    return before * 1000000 + inner + (recordValue() == before ? 0 : 1);
}

extern "C" __global__ void __raygen__callables() {
    const unsigned i = optixGetLaunchIndex().x;
    CallableResult& r = params.results[i];
    r.sum = optixDirectCall<unsigned, unsigned, unsigned>(kCallAdd, i, 0xFFFFFFF0u);
    r.mixed = optixDirectCall<float, float, int, double, unsigned long long, short, char, bool>(
        kCallMixed, 0.5f, -3, 2.25, 1ull << 20, static_cast<short>(-7), static_cast<char>(5),
        (i & 1) != 0);
    Pair pair;
    pair.first = static_cast<float>(i);
    pair.second = 100.0f;
    r.pair = optixDirectCall<Pair, Pair>(kCallSwap, pair);
    Large large;
    for (unsigned k = 0; k < 12; ++k)
        large.words[k] = i + k;
    large.sum = 0.125;
    r.large = optixDirectCall<Large, Large, unsigned>(kCallLarge, large, 3u);
    optixDirectCall<void, unsigned*, unsigned>(kCallStore, &r.stored, i);
    r.launch = optixDirectCall<unsigned>(kCallLaunch);
    r.wide = optixDirectCall<double, double, double>(kCallWide, 1.5, static_cast<double>(i));
    r.nested = optixDirectCall<unsigned, unsigned>(kCallNested, i % 5);
    r.outer = optixDirectCall<unsigned>(kCallOuter);
    // The index may differ from launch index to launch index.
    r.varying = optixDirectCall<unsigned, unsigned, unsigned>(i % 2 ? kCallAdd : kCallSubtract, 50u, i);
    r.raygenRecord = recordValue();
    optixTrace(params.handle, make_float3(0.0f, 0.0f, -1.0f), make_float3(0.0f, 0.0f, i % 2 ? 1.0f : -1.0f),
               0.0f, 10.0f, 0.0f, 255, 0, 0, 0, 0);
}

extern "C" __device__ unsigned __direct_callable__subtract(unsigned a, unsigned b) { return a - b; }

static __forceinline__ __device__ void callFrom(unsigned slot) {
    const unsigned i = optixGetLaunchIndex().x;
    const unsigned before = recordValue();
    params.results[i].from[slot] =
        optixDirectCall<unsigned, unsigned, unsigned>(kCallAdd, slot * 100, i);
    params.results[i].recordFrom[slot] = recordValue() == before ? before : ~0u;
}

extern "C" __global__ void __closesthit__callables() { callFrom(0); }
extern "C" __global__ void __miss__callables() { callFrom(1); }
extern "C" __global__ void __anyhit__callables() { callFrom(2); }
extern "C" __global__ void __intersection__callables() {
    callFrom(3);
    optixReportIntersection(1.0f, 0);
}
