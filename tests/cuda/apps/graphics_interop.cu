// SPDX-License-Identifier: Apache-2.0
// A viewer's choice of its way to the screen: buffers of OpenGL, or host memory where they cannot
// be registered.
#include <cstdio>
#include <cuda_gl_interop.h>
#include <vector>

__global__ void paint(uchar4* pixels, int width, int height) {
    const int x = int(blockIdx.x * blockDim.x + threadIdx.x);
    const int y = int(blockIdx.y * blockDim.y + threadIdx.y);
    if (x < width && y < height)
        pixels[y * width + x] = make_uchar4(x, y, x ^ y, 255);
}

static const char* nameOf(cudaError_t error) {
    cudaGetLastError(); // must not stay
    return cudaGetErrorName(error);
}

int main() {
    constexpr int kWidth = 64, kHeight = 48;
    cudaGraphicsResource_t buffer = nullptr;
    unsigned int count = 0;
    int devices[4];
    std::printf("devices: %s\n", nameOf(cudaGLGetDevices(&count, devices, 4, cudaGLDeviceListAll)));
    const cudaError_t registered =
        cudaGraphicsGLRegisterBuffer(&buffer, 1, cudaGraphicsRegisterFlagsWriteDiscard);
    std::printf("register: %s\n", nameOf(registered));
    std::printf("image: %s\n", nameOf(cudaGraphicsGLRegisterImage(&buffer, 1, 0x0DE1,
                                                                  cudaGraphicsRegisterFlagsNone)));
    std::printf("map: %s\n", nameOf(cudaGraphicsMapResources(1, &buffer)));
    uchar4* pixels;
    size_t size;
    std::printf("pointer: %s\n", nameOf(cudaGraphicsResourceGetMappedPointer(
                                     reinterpret_cast<void**>(&pixels), &size, buffer)));
    std::printf("unmap: %s\n", nameOf(cudaGraphicsUnmapResources(1, &buffer)));
    std::printf("unregister: %s\n", nameOf(cudaGraphicsUnregisterResource(buffer)));
    if (registered == cudaSuccess)
        return 1;
    cudaMalloc(&pixels, kWidth * kHeight * sizeof(uchar4));
    paint<<<dim3(kWidth / 16, kHeight / 16), dim3(16, 16)>>>(pixels, kWidth, kHeight);
    std::vector<uchar4> picture(kWidth * kHeight);
    cudaMemcpy(picture.data(), pixels, picture.size() * sizeof(uchar4), cudaMemcpyDeviceToHost);
    unsigned long long sum = 0;
    for (const uchar4& p : picture)
        sum = sum * 31 + p.x + 3u * p.y + 5u * p.z + 7u * p.w;
    std::printf("picture: %llx, %s\n", sum, cudaGetErrorName(cudaGetLastError()));
    return 0;
}
