// SPDX-License-Identifier: Apache-2.0
// A 2D grid over a pitched image with a struct parameter; 2D copies in and out.
#include <cuda_runtime.h>

#include "check.h"

#include <vector>

struct Image {
    uchar4* pixels;
    size_t pitch;
    int width, height;
};

__global__ void invert(Image image, float3 weight) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x;
    const int y = blockIdx.y * blockDim.y + threadIdx.y;
    if (x >= image.width || y >= image.height)
        return;
    uchar4* row = (uchar4*)((char*)image.pixels + y * image.pitch);
    uchar4 p = row[x];
    row[x] = make_uchar4((unsigned char)(255 - p.x), (unsigned char)(p.y * weight.y),
                         (unsigned char)(x ^ y), (unsigned char)(blockIdx.x + 16 * blockIdx.y));
}

int main() {
    const int width = 100, height = 37;
    std::vector<uchar4> host(width * height);
    for (int i = 0; i < width * height; ++i)
        host[i] = make_uchar4((unsigned char)i, (unsigned char)(i / 2), 0, 0);
    Image image = {nullptr, 0, width, height};
    CHECK(cudaMallocPitch(&image.pixels, &image.pitch, width * sizeof(uchar4), height));
    CHECK(cudaMemcpy2D(image.pixels, image.pitch, host.data(), width * sizeof(uchar4),
                       width * sizeof(uchar4), height, cudaMemcpyHostToDevice));
    const dim3 block(16, 8), grid((width + 15) / 16, (height + 7) / 8);
    invert<<<grid, block>>>(image, make_float3(1, 0.5f, 0));
    CHECK(cudaMemcpy2D(host.data(), width * sizeof(uchar4), image.pixels, image.pitch,
                       width * sizeof(uchar4), height, cudaMemcpyDeviceToHost));
    unsigned sum = 0;
    for (const uchar4& p : host)
        sum = sum * 31 + p.x + 3u * p.y + 5u * p.z + 7u * p.w;
    const uchar4 last = host.back();
    std::printf("sum %u, last %d %d %d %d\n", sum, last.x, last.y, last.z, last.w);
    return 0;
}
