// SPDX-License-Identifier: Apache-2.0
// Texture functions that also tell whether the texels lie in memory, which those of ordinary arrays
// do. The values are those of the functions without.
#include <cuda_runtime.h>

#include "check.h"

#if !__CUDACC__
#error "__CUDACC__ has no value"
#endif

struct Answer {
    float4 with, without;
    bool resident;
};

__global__ void plane(cudaTextureObject_t t, Answer* out) {
    const float x = 1.3f, y = 2.6f;
    const float2 dx = make_float2(0.5f, 0), dy = make_float2(0, 0.5f);
    bool* const r[] = {&out[0].resident, &out[1].resident, &out[2].resident, &out[3].resident,
                       &out[4].resident};
    out[0].with = tex2D<float4>(t, x, y, r[0]);
    out[0].without = tex2D<float4>(t, x, y);
    out[1].with = tex2DLod<float4>(t, x, y, 0, r[1]);
    out[1].without = tex2DLod<float4>(t, x, y, 0);
    out[2].with = tex2DGrad<float4>(t, x, y, dx, dy, r[2]);
    out[2].without = tex2DGrad<float4>(t, x, y, dx, dy);
    out[3].with = tex2Dgather<float4>(t, x, y, r[3], 1);
    out[3].without = tex2Dgather<float4>(t, x, y, 1);
    tex2D(&out[4].with, t, x, y, r[4]);
    tex2D(&out[4].without, t, x, y);
}

__global__ void volume(cudaTextureObject_t t, Answer* out) {
    const float x = 1.3f, y = 2.6f, z = 1.1f;
    const float4 d = make_float4(0.5f, 0.25f, 0.125f, 0);
    out[0].with = tex3D<float4>(t, x, y, z, &out[0].resident);
    out[0].without = tex3D<float4>(t, x, y, z);
    out[1].with = tex3DLod<float4>(t, x, y, z, 0, &out[1].resident);
    out[1].without = tex3DLod<float4>(t, x, y, z, 0);
    out[2].with = tex3DGrad<float4>(t, x, y, z, d, d, &out[2].resident);
    out[2].without = tex3DGrad<float4>(t, x, y, z, d, d);
}

__global__ void layers(cudaTextureObject_t t, Answer* out) {
    const float x = 1.3f, y = 2.6f;
    const float2 d = make_float2(0.5f, 0.25f);
    out[0].with = tex2DLayered<float4>(t, x, y, 1, &out[0].resident);
    out[0].without = tex2DLayered<float4>(t, x, y, 1);
    out[1].with = tex2DLayeredLod<float4>(t, x, y, 1, 0, &out[1].resident);
    out[1].without = tex2DLayeredLod<float4>(t, x, y, 1, 0);
    out[2].with = tex2DLayeredGrad<float4>(t, x, y, 1, d, d, &out[2].resident);
    out[2].without = tex2DLayeredGrad<float4>(t, x, y, 1, d, d);
}

static void run(const char* name, void (*kernel)(cudaTextureObject_t, Answer*), int count,
                int depth, unsigned flags) {
    const int n = 4;
    const cudaExtent extent = make_cudaExtent(n, n, size_t(depth));
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<float4>();
    cudaArray_t array;
    CHECK(cudaMalloc3DArray(&array, &format, extent, flags));
    float4 texels[n * n * 2];
    for (int i = 0; i < n * n * 2; ++i)
        texels[i] = make_float4(float(i), float(i * i), 1.0f / float(i + 1), -float(i));
    cudaMemcpy3DParms copy = {};
    copy.srcPtr = make_cudaPitchedPtr(texels, n * sizeof(float4), n, n);
    copy.dstArray = array;
    copy.extent = make_cudaExtent(n, n, depth ? size_t(depth) : 1);
    copy.kind = cudaMemcpyHostToDevice;
    CHECK(cudaMemcpy3D(&copy));
    cudaResourceDesc resource = {};
    resource.resType = cudaResourceTypeArray;
    resource.res.array.array = array;
    cudaTextureDesc sampling = {};
    cudaTextureObject_t texture = 0;
    CHECK(cudaCreateTextureObject(&texture, &resource, &sampling, nullptr));
    Answer* answers;
    CHECK(cudaMallocManaged(&answers, size_t(count) * sizeof(Answer)));
    for (int i = 0; i < count; ++i)
        answers[i] = Answer();
    kernel<<<1, 1>>>(texture, answers);
    CHECK(cudaDeviceSynchronize());
    for (int i = 0; i < count; ++i) {
        const float4 a = answers[i].with, b = answers[i].without;
        std::printf("%s %d: %s, %s, %g\n", name, i, answers[i].resident ? "resident" : "absent",
                    a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w ? "alike" : "different",
                    double(a.y));
    }
    CHECK(cudaFree(answers));
    CHECK(cudaDestroyTextureObject(texture));
    CHECK(cudaFreeArray(array));
}

int main() {
    run("plane", plane, 5, 0, cudaArrayTextureGather);
    run("volume", volume, 3, 2, 0);
    run("layers", layers, 3, 2, cudaArrayLayered);
    return 0;
}
