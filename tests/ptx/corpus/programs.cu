// SPDX-License-Identifier: Apache-2.0
// OptiX programs as the 7.x headers compile: entries without parameters, undeclared intrinsics.
struct Parameters {
    float4* image;
    unsigned width, height;
    unsigned long long handle;
};
extern "C" __constant__ Parameters params;

static __forceinline__ __device__ unsigned launchIndex() {
    unsigned x;
    asm("call (%0), _optix_get_launch_index_x, ();" : "=r"(x) :);
    return x;
}

extern "C" __global__ void __raygen__camera() {
    const unsigned i = launchIndex();
    unsigned p0 = i, p1 = 1, p2 = 2, p3 = 3;
    float ox = 0, oy = 1, oz = 2, tmin = 0, tmax = 1e16f;
    asm volatile("call (%0, %1, %2, %3), _optix_trace_4, (%4, %5, %6, %7, %8, %9, %0, %1, %2, %3);"
                 : "+r"(p0), "+r"(p1), "+r"(p2), "+r"(p3)
                 : "l"(params.handle), "f"(ox), "f"(oy), "f"(oz), "f"(tmin), "f"(tmax));
    params.image[i] = make_float4(__uint_as_float(p0), __uint_as_float(p1), __uint_as_float(p2), p3);
}

extern "C" __global__ void __miss__sky() {
    asm volatile("call _optix_set_payload, (%0, %1);" ::"r"(0), "r"(__float_as_int(0.5f)));
}

extern "C" __device__ float3 __direct_callable__shade(float3 normal, int n) {
    return make_float3(normal.x * n, normal.y, sqrtf(normal.z));
}
