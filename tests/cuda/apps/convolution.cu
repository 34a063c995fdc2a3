// SPDX-License-Identifier: Apache-2.0
// Separable convolution of an image: read through textures that clamp and mirror at the edges, with
// weights in constant memory; then again by bilinear taps between texels.
#include <cuda_runtime.h>

#include "check.h"

#include <vector>

constexpr int kRadius = 4, kWidth = 97, kHeight = 61;
__constant__ float weights[2 * kRadius + 1];

__global__ void convolve(cudaTextureObject_t picture, float* out, int dx, int dy) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x, y = blockIdx.y * blockDim.y + threadIdx.y;
    if (x >= kWidth || y >= kHeight)
        return;
    float sum = 0;
    for (int i = -kRadius; i <= kRadius; ++i)
        sum += weights[i + kRadius] * tex2D<float>(picture, x + i * dx + 0.5f, y + i * dy + 0.5f);
    out[y * kWidth + x] = sum;
}

// A box of 2 x 2 texels in one tap, at normalised coordinates.
__global__ void halve(cudaTextureObject_t picture, float* out) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x, y = blockIdx.y * blockDim.y + threadIdx.y;
    if (x < kWidth / 2 && y < kHeight / 2)
        out[y * (kWidth / 2) + x] =
            tex2D<float>(picture, (2 * x + 1) / float(kWidth), (2 * y + 1) / float(kHeight));
}

static cudaArray_t upload(const float* from, cudaMemcpyKind kind) {
    cudaArray_t array;
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<float>();
    CHECK(cudaMallocArray(&array, &format, kWidth, kHeight));
    CHECK(cudaMemcpy2DToArray(array, 0, 0, from, kWidth * 4, kWidth * 4, kHeight, kind));
    return array;
}

static cudaTextureObject_t textureOf(cudaArray_t array, cudaTextureAddressMode mode, bool linear) {
    cudaResourceDesc resource = {};
    resource.resType = cudaResourceTypeArray;
    resource.res.array.array = array;
    cudaTextureDesc description = {};
    description.addressMode[0] = description.addressMode[1] = mode;
    description.filterMode = linear ? cudaFilterModeLinear : cudaFilterModePoint;
    description.readMode = cudaReadModeElementType;
    description.normalizedCoords = linear;
    cudaTextureObject_t texture;
    CHECK(cudaCreateTextureObject(&texture, &resource, &description, nullptr));
    return texture;
}

static void show(const char* name, const float* device, int count) {
    std::vector<float> host(count);
    CHECK(cudaMemcpy(host.data(), device, count * sizeof(float), cudaMemcpyDeviceToHost));
    double sum = 0;
    for (float value : host)
        sum += value;
    std::printf("%s %.2f %.2f %.2f %.1f\n", name, host[0], host[count / 2], host[count - 1], sum);
}

int main() {
    std::vector<float> picture(kWidth * kHeight);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            picture[y * kWidth + x] = float((x * 7 + y * 13) % 50) + (x / 16 + y / 16) % 2 * 20;
    float host[2 * kRadius + 1], total = 0;
    for (int i = -kRadius; i <= kRadius; ++i)
        total += host[i + kRadius] = float(kRadius + 1 - std::abs(i));
    for (float& weight : host)
        weight /= total;
    CHECK(cudaMemcpyToSymbol(weights, host, sizeof host));

    float *rows, *both;
    CHECK(cudaMalloc(&rows, kWidth * kHeight * sizeof(float)));
    CHECK(cudaMalloc(&both, kWidth * kHeight * sizeof(float)));
    const dim3 block(16, 8), grid((kWidth + 15) / 16, (kHeight + 7) / 8);
    cudaArray_t source = upload(picture.data(), cudaMemcpyHostToDevice);
    const cudaTextureObject_t plain = textureOf(source, cudaAddressModeClamp, false);
    convolve<<<grid, block>>>(plain, rows, 1, 0);
    CHECK(cudaGetLastError());
    cudaArray_t between = upload(rows, cudaMemcpyDeviceToDevice);
    const cudaTextureObject_t second = textureOf(between, cudaAddressModeClamp, false);
    convolve<<<grid, block>>>(second, both, 0, 1);
    CHECK(cudaGetLastError());
    show("rows", rows, kWidth * kHeight);
    show("both", both, kWidth * kHeight);
    const cudaTextureObject_t smooth = textureOf(source, cudaAddressModeMirror, true);
    halve<<<grid, block>>>(smooth, rows);
    CHECK(cudaGetLastError());
    show("half", rows, (kWidth / 2) * (kHeight / 2));
    for (cudaTextureObject_t texture : {plain, second, smooth})
        CHECK(cudaDestroyTextureObject(texture));
    CHECK(cudaFreeArray(source));
    CHECK(cudaFreeArray(between));
    return 0;
}
