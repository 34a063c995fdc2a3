// SPDX-License-Identifier: Apache-2.0
// Reads and writes surfaces of every geometry, with the boundary modes that do not trap, and
// samples the written texels.
#include "check.h"

#include <cstring>
#include <vector>

__global__ void write2D(cudaSurfaceObject_t s) {
    const int x = int(threadIdx.x) - 1, y = int(threadIdx.y) - 1;
    surf2Dwrite(make_uchar4(x, y, x + y, 7), s, x * 4, y, cudaBoundaryModeZero);
}
__global__ void read2D(cudaSurfaceObject_t s, uchar4* out, bool clamp) {
    const int x = int(threadIdx.x) - 2, y = int(threadIdx.y) - 2;
    uchar4 v = make_uchar4(9, 9, 9, 9);
    if (clamp)
        surf2Dread(&v, s, x * 4, y, cudaBoundaryModeClamp);
    else
        v = surf2Dread<uchar4>(s, x * 4, y, cudaBoundaryModeZero);
    out[threadIdx.y * blockDim.x + threadIdx.x] = v;
}
__global__ void shapes(cudaSurfaceObject_t one, cudaSurfaceObject_t three,
                       cudaSurfaceObject_t layered, cudaSurfaceObject_t cube, float* out) {
    const int i = threadIdx.x;
    surf1Dwrite(make_float2(float(i), float(-i)), one, i * 8);
    surf3Dwrite((unsigned short)(i * 3), three, (i % 4) * 2, i / 4 % 2, i / 8);
    surf2DLayeredwrite(i * 5, layered, (i % 4) * 4, i / 4 % 2, i / 8);
    surfCubemapwrite(float(i % 12), cube, (i % 2) * 4, i / 2 % 2, i % 6, cudaBoundaryModeZero);
    __syncthreads();
    out[i * 4] = surf1Dread<float2>(one, (15 - i) * 8).y;
    out[i * 4 + 1] = float(surf3Dread<unsigned short>(three, (i % 4) * 2, i / 4 % 2, 1 - i / 8));
    out[i * 4 + 2] = float(surf2DLayeredread<int>(layered, (i % 4) * 4, i / 4 % 2, 1 - i / 8));
    out[i * 4 + 3] = i < 2 ? surfCubemapread<float>(cube, i * 4, 0, 0, cudaBoundaryModeZero) : 0;
}
__global__ void sample(cudaTextureObject_t t, float4* out) {
    out[threadIdx.x] = tex2D<float4>(t, threadIdx.x + 1.0f, threadIdx.x * 0.5f + 0.75f);
}

static cudaArray_t makeArray(cudaChannelFormatDesc desc, cudaExtent extent, unsigned flags) {
    cudaArray_t array = nullptr;
    CHECK(cudaMalloc3DArray(&array, &desc, extent, flags | cudaArraySurfaceLoadStore));
    return array;
}
static cudaSurfaceObject_t surfaceOf(cudaArray_t array) {
    cudaResourceDesc r;
    std::memset(&r, 0, sizeof r);
    r.resType = cudaResourceTypeArray;
    r.res.array.array = array;
    cudaSurfaceObject_t s = 0;
    CHECK(cudaCreateSurfaceObject(&s, &r));
    return s;
}

int main() {
    float* memory = nullptr;
    CHECK(cudaMalloc((void**)&memory, 4096));
    const cudaArray_t flat = makeArray(cudaCreateChannelDesc<uchar4>(), make_cudaExtent(6, 5, 0), 0);
    const cudaSurfaceObject_t s = surfaceOf(flat);
    write2D<<<1, dim3(9, 8)>>>(s);
    for (int clamp = 0; clamp < 2; ++clamp) {
        uchar4 seen[80];
        read2D<<<1, dim3(10, 8)>>>(s, (uchar4*)memory, clamp);
        CHECK(cudaMemcpy(seen, memory, sizeof seen, cudaMemcpyDeviceToHost));
        std::printf(clamp ? "clamp" : "zero");
        for (const uchar4& v : seen)
            std::printf(" %d,%d,%d,%d", v.x, v.y, v.z, v.w);
        std::printf("\n");
    }
    cudaResourceDesc r;
    std::memset(&r, 0, sizeof r);
    r.resType = cudaResourceTypeArray;
    r.res.array.array = flat;
    cudaTextureDesc d;
    std::memset(&d, 0, sizeof d);
    d.addressMode[0] = d.addressMode[1] = cudaAddressModeClamp;
    d.filterMode = cudaFilterModeLinear;
    d.readMode = cudaReadModeNormalizedFloat;
    cudaTextureObject_t t = 0;
    CHECK(cudaCreateTextureObject(&t, &r, &d, nullptr));
    float4 sampled[5];
    sample<<<1, 5>>>(t, (float4*)memory);
    CHECK(cudaMemcpy(sampled, memory, sizeof sampled, cudaMemcpyDeviceToHost));
    for (const float4& v : sampled)
        std::printf("%.4f %.4f %.4f %.4f\n", v.x, v.y, v.z, v.w);

    const cudaArray_t one = makeArray(cudaCreateChannelDesc<float2>(), make_cudaExtent(16, 0, 0), 0);
    const cudaArray_t three =
        makeArray(cudaCreateChannelDesc<unsigned short>(), make_cudaExtent(4, 2, 2), 0);
    const cudaArray_t layered =
        makeArray(cudaCreateChannelDesc<int>(), make_cudaExtent(4, 2, 2), cudaArrayLayered);
    const cudaArray_t cube =
        makeArray(cudaCreateChannelDesc<float>(), make_cudaExtent(2, 2, 6), cudaArrayCubemap);
    const cudaSurfaceObject_t all[] = {surfaceOf(one), surfaceOf(three), surfaceOf(layered),
                                       surfaceOf(cube)};
    shapes<<<1, 16>>>(all[0], all[1], all[2], all[3], memory);
    float out[64];
    CHECK(cudaMemcpy(out, memory, sizeof out, cudaMemcpyDeviceToHost));
    for (int i = 0; i < 64; ++i)
        std::printf("%g%c", out[i], i % 16 == 15 ? '\n' : ' ');
    std::vector<unsigned short> back(16);
    cudaMemcpy3DParms copy;
    std::memset(&copy, 0, sizeof copy);
    copy.srcArray = three;
    copy.dstPtr = make_cudaPitchedPtr(back.data(), 8, 4, 2);
    copy.extent = make_cudaExtent(4, 2, 2);
    copy.kind = cudaMemcpyDeviceToHost;
    CHECK(cudaMemcpy3D(&copy));
    for (unsigned short v : back)
        std::printf("%d ", v);
    std::printf("\n");
    for (cudaSurfaceObject_t object : all)
        CHECK(cudaDestroySurfaceObject(object));
    for (cudaArray_t array : {flat, one, three, layered, cube})
        CHECK(cudaFreeArray(array));
    return 0;
}
