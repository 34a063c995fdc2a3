// SPDX-License-Identifier: Apache-2.0
// Intersection programs that report 0 to 8 attributes, and any-hit and closest-hit programs that
// read them back.
#include <optix.h>

struct AttributeParams {
    unsigned long long handle;
    unsigned* seen; // 32 words for each launch index: any-hit 0..7, closest-hit 8..15, kinds 16, 17
};

extern "C" {
__constant__ AttributeParams params;
}

static __forceinline__ __device__ unsigned* seen() {
    return params.seen + 32 * optixGetLaunchIndex().x;
}

extern "C" __global__ void __raygen__attributes() {
    optixTrace(params.handle, make_float3(0.0f, 0.0f, -5.0f), make_float3(0.0f, 0.0f, 1.0f), 0.0f,
               100.0f, 0.0f, 255, 0, optixGetLaunchIndex().x, 0, 0);
}

extern "C" __global__ void __miss__attributes() { seen()[31] = 1; }

// Attribute i of index n is 1000 * n + i + 1; hit kind 10 + n; distance 4.5.
#define VALUE(i) (1000 * optixGetLaunchIndex().x + i + 1)

#define REPORT(n, ...)                                                                             \
    extern "C" __global__ void __intersection__attributes_##n() {                                  \
        seen()[30] = optixReportIntersection(4.5f, 10 + n __VA_ARGS__);                            \
    }

REPORT(0)
REPORT(1, , VALUE(0))
REPORT(2, , VALUE(0), VALUE(1))
REPORT(3, , VALUE(0), VALUE(1), VALUE(2))
REPORT(4, , VALUE(0), VALUE(1), VALUE(2), VALUE(3))
REPORT(5, , VALUE(0), VALUE(1), VALUE(2), VALUE(3), VALUE(4))
REPORT(6, , VALUE(0), VALUE(1), VALUE(2), VALUE(3), VALUE(4), VALUE(5))
REPORT(7, , VALUE(0), VALUE(1), VALUE(2), VALUE(3), VALUE(4), VALUE(5), VALUE(6))
REPORT(8, , VALUE(0), VALUE(1), VALUE(2), VALUE(3), VALUE(4), VALUE(5), VALUE(6), VALUE(7))

// Reads the first n attributes: the others are undefined where fewer were reported.
static __forceinline__ __device__ void readAttributes(unsigned* to, unsigned n) {
    if (n > 0) to[0] = optixGetAttribute_0();
    if (n > 1) to[1] = optixGetAttribute_1();
    if (n > 2) to[2] = optixGetAttribute_2();
    if (n > 3) to[3] = optixGetAttribute_3();
    if (n > 4) to[4] = optixGetAttribute_4();
    if (n > 5) to[5] = optixGetAttribute_5();
    if (n > 6) to[6] = optixGetAttribute_6();
    if (n > 7) to[7] = optixGetAttribute_7();
}

extern "C" __global__ void __anyhit__attributes() {
    unsigned* s = seen();
    readAttributes(s, optixGetLaunchIndex().x);
    s[16] = optixGetHitKind();
    s[18] = __float_as_uint(optixGetRayTmax());
}

extern "C" __global__ void __closesthit__attributes() {
    unsigned* s = seen();
    readAttributes(s + 8, optixGetLaunchIndex().x);
    s[17] = optixGetHitKind();
    s[19] = __float_as_uint(optixGetRayTmax());
}
