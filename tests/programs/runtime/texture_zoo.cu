// SPDX-License-Identifier: Apache-2.0
// An image library's textures: two dimensions with borders, layers, cubes with layers, mip levels
// that a kernel writes through surfaces, volumes, and a view of linear memory with a pitch.
#include "device.h"

#include <cmath>
#include <cstring>
#include <vector>

#define LAUNCH(n) <<<((n) + 63) / 64, 64>>>

__global__ void sampleFlat(cudaTextureObject_t texture, float* out, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        out[i] = tex2D<float>(texture, i * 0.25f - 2.0f, i * 0.125f - 1.0f);
}
__global__ void sampleLayers(cudaTextureObject_t texture, uchar4* out, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        out[i] = tex2DLayered<uchar4>(texture, i % 8 + 0.5f, 0.5f, i / 8);
}
__global__ void sampleCube(cudaTextureObject_t texture, float2* out, const float3* ways, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        out[i] = texCubemapLayered<float2>(texture, ways[i].x, ways[i].y, ways[i].z, i & 1);
}
__global__ void writeLevel(cudaSurfaceObject_t level, int side, float base) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x, y = blockIdx.y * blockDim.y + threadIdx.y;
    if (x < side && y < side)
        surf2Dwrite(base + x, level, x * int(sizeof(float)), y, cudaBoundaryModeTrap);
}
__global__ void sampleLevels(cudaTextureObject_t texture, float* out, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        out[i] = tex2DLod<float>(texture, 0.5f, 0.5f, i * 0.25f);
}
__global__ void copyVolume(cudaTextureObject_t from, cudaSurfaceObject_t to, int side) {
    const int x = threadIdx.x, y = threadIdx.y, z = blockIdx.x;
    const short value = tex3D<short>(from, x + 0.5f, y + 0.5f, z + 0.5f);
    surf3Dwrite(short(value + surf3Dread<short>(to, (side - 1 - x) * 2, y, z)), to, x * 2,
                side - 1 - y, z);
}
__global__ void samplePitched(cudaTextureObject_t texture, float* out, int width, int height) {
    const int x = threadIdx.x, y = blockIdx.x;
    if (x < width && y < height)
        out[y * width + x] = tex2D<float>(texture, x + 0.5f, y + 0.5f);
}

static cudaResourceDesc resource(cudaArray_t array) {
    cudaResourceDesc description = {};
    description.resType = cudaResourceTypeArray;
    description.res.array.array = array;
    return description;
}
static cudaTextureObject_t texture(const cudaResourceDesc& from, cudaTextureDesc how) {
    cudaTextureObject_t made = 0;
    CUDA(cudaCreateTextureObject(&made, &from, &how, nullptr));
    return made;
}
template <class T>
struct Out {
    explicit Out(int n) : values(n) { CUDA(cudaMalloc(&memory, n * sizeof(T))); }
    ~Out() { cudaFree(memory); }
    std::vector<T>& get() {
        CUDA(cudaMemcpy(values.data(), memory, values.size() * sizeof(T), cudaMemcpyDeviceToHost));
        return values;
    }
    T* memory = nullptr;
    std::vector<T> values;
};
static int wrong(const char* what, int count) {
    if (count)
        std::printf("%s: %d wrong\n", what, count);
    return count;
}

static int flat() {
    constexpr int kWide = 16, kHigh = 8, n = 120;
    std::vector<float> texels(kWide * kHigh);
    for (int i = 0; i < kWide * kHigh; ++i)
        texels[i] = float(i % kWide + 100 * (i / kWide));
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<float>();
    cudaArray_t array;
    CUDA(cudaMallocArray(&array, &format, kWide, kHigh));
    CUDA(cudaMemcpy2DToArray(array, 0, 0, texels.data(), kWide * 4, kWide * 4, kHigh,
                             cudaMemcpyHostToDevice));
    cudaTextureDesc how = {};
    how.addressMode[0] = how.addressMode[1] = cudaAddressModeBorder;
    how.borderColor[0] = -5;
    how.filterMode = cudaFilterModePoint;
    Out<float> out(n);
    sampleFlat LAUNCH(n)(texture(resource(array), how), out.memory, n);
    int bad = 0;
    for (int i = 0; i < n; ++i) {
        const int x = int(std::floor(i * .25f - 2)), y = int(std::floor(i * .125f - 1));
        const bool inside = x >= 0 && y >= 0 && x < kWide && y < kHigh;
        bad += out.get()[i] != (inside ? texels[y * kWide + x] : -5);
    }
    return wrong("border", bad);
}

static int layered() {
    constexpr int kLayers = 5;
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<uchar4>();
    cudaArray_t array;
    CUDA(cudaMalloc3DArray(&array, &format, make_cudaExtent(8, 1, kLayers), cudaArrayLayered));
    std::vector<uchar4> texels(8 * kLayers);
    for (int i = 0; i < 8 * kLayers; ++i)
        texels[i] = make_uchar4(i, 2 * i, 255 - i, 7);
    cudaMemcpy3DParms copy = {};
    copy.srcPtr = make_cudaPitchedPtr(texels.data(), 8 * sizeof(uchar4), 8, 1);
    copy.dstArray = array;
    copy.extent = make_cudaExtent(8, 1, kLayers);
    copy.kind = cudaMemcpyDefault;
    CUDA(cudaMemcpy3D(&copy));
    Out<uchar4> out(8 * kLayers);
    sampleLayers LAUNCH(8 * kLayers)(texture(resource(array), {}), out.memory, 8 * kLayers);
    return wrong("layers", std::memcmp(out.get().data(), texels.data(), texels.size() * 4) != 0);
}

static int cubes() {
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<float2>();
    cudaArray_t array;
    CUDA(cudaMalloc3DArray(&array, &format, make_cudaExtent(4, 4, 12),
                           cudaArrayCubemap | cudaArrayLayered));
    std::vector<float2> texels(16 * 12);
    for (int i = 0; i < 16 * 12; ++i)
        texels[i] = {float(i / 16), float(i / 16) * 2}; // the face's number
    cudaMemcpy3DParms copy = {};
    copy.srcPtr = make_cudaPitchedPtr(texels.data(), 4 * sizeof(float2), 4, 4);
    copy.dstArray = array;
    copy.extent = make_cudaExtent(4, 4, 12);
    copy.kind = cudaMemcpyHostToDevice;
    CUDA(cudaMemcpy3D(&copy));
    cudaTextureDesc how = {};
    how.filterMode = cudaFilterModeLinear;
    how.normalizedCoords = 1;
    for (auto& mode : how.addressMode)
        mode = cudaAddressModeClamp;
    const std::vector<float3> ways = {{2, .1f, .2f}, {-2, .1f, .2f}, {.3f, 3, 1}, {.3f, -3, 1},
                                      {.1f, .2f, 1}, {.1f, .2f, -1}, {9, 1, 1},   {-9, 1, 1},
                                      {1, 9, 1},     {1, -9, 1},     {1, 1, 9},   {1, 1, -9}};
    float3* device;
    CUDA(cudaMalloc(&device, ways.size() * sizeof(float3)));
    CUDA(cudaMemcpy(device, ways.data(), ways.size() * sizeof(float3), cudaMemcpyHostToDevice));
    Out<float2> out(int(ways.size()));
    sampleCube LAUNCH(12)(texture(resource(array), how), out.memory, device, 12);
    int bad = 0;
    for (int i = 0; i < 12; ++i) {
        const float face = float(i % 6 + 6 * (i & 1));
        bad += out.get()[i].x != face || out.get()[i].y != 2 * face;
    }
    return wrong("cubes", bad);
}

static int levels() {
    constexpr int kLevels = 5, n = 17;
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<float>();
    cudaMipmappedArray_t mips;
    CUDA(cudaMallocMipmappedArray(&mips, &format, make_cudaExtent(16, 16, 0), kLevels,
                                  cudaArraySurfaceLoadStore));
    for (int level = 0; level < kLevels; ++level) {
        cudaArray_t array;
        CUDA(cudaGetMipmappedArrayLevel(&array, mips, level));
        cudaExtent extent;
        unsigned flags;
        CUDA(cudaArrayGetInfo(nullptr, &extent, &flags, array));
        cudaSurfaceObject_t surface;
        const cudaResourceDesc from = resource(array);
        CUDA(cudaCreateSurfaceObject(&surface, &from));
        writeLevel<<<dim3(2, 2), dim3(8, 8)>>>(surface, int(extent.width),
                                               1000.0f * level - extent.width / 2.0f + .5f);
        CUDA(cudaDestroySurfaceObject(surface));
        if (extent.width != size_t(16 >> level))
            return wrong("extent of a level", 1);
    }
    cudaResourceDesc from = {};
    from.resType = cudaResourceTypeMipmappedArray;
    from.res.mipmap.mipmap = mips;
    cudaTextureDesc how = {};
    how.normalizedCoords = 1;
    how.filterMode = how.mipmapFilterMode = cudaFilterModeLinear;
    how.maxMipmapLevelClamp = 3;
    for (auto& mode : how.addressMode)
        mode = cudaAddressModeClamp;
    Out<float> out(n);
    sampleLevels LAUNCH(n)(texture(from, how), out.memory, n);
    int bad = 0;
    for (int i = 0; i < n; ++i) // in the middle of a level is its number times 1000
        bad += std::fabs(out.get()[i] - 1000 * std::fmin(3.0f, i * .25f)) > 4;
    CUDA(cudaFreeMipmappedArray(mips));
    return wrong("levels", bad);
}

static int volume() {
    constexpr int kSide = 8;
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<short>();
    const cudaExtent extent = make_cudaExtent(kSide, kSide, kSide);
    cudaArray_t from, to;
    CUDA(cudaMalloc3DArray(&from, &format, extent));
    CUDA(cudaMalloc3DArray(&to, &format, extent, cudaArraySurfaceLoadStore));
    std::vector<short> texels(kSide * kSide * kSide), zero(texels.size()), result(texels.size());
    for (size_t i = 0; i < texels.size(); ++i)
        texels[i] = short(i * 37 % 1000 - 500);
    cudaMemcpy3DParms copy = {};
    copy.extent = extent;
    copy.kind = cudaMemcpyDefault;
    copy.srcPtr = make_cudaPitchedPtr(texels.data(), kSide * 2, kSide, kSide);
    copy.dstArray = from;
    CUDA(cudaMemcpy3D(&copy));
    copy.srcPtr.ptr = zero.data();
    copy.dstArray = to;
    CUDA(cudaMemcpy3D(&copy));
    cudaSurfaceObject_t surface;
    const cudaResourceDesc target = resource(to);
    CUDA(cudaCreateSurfaceObject(&surface, &target));
    // Rows that a block reads are written by another thread only in the upper half.
    copyVolume<<<kSide, dim3(kSide, kSide / 2)>>>(texture(resource(from), {}), surface, kSide);
    copy = {};
    copy.extent = extent;
    copy.kind = cudaMemcpyDefault;
    copy.srcArray = to;
    copy.dstPtr = make_cudaPitchedPtr(result.data(), kSide * 2, kSide, kSide);
    CUDA(cudaMemcpy3D(&copy));
    int bad = 0;
    for (int z = 0; z < kSide; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const short right =
                    y < kSide / 2 ? 0 : texels[(z * kSide + kSide - 1 - y) * kSide + x];
                bad += result[(z * kSide + y) * kSide + x] != right;
            }
    return wrong("volume", bad);
}

static int pitched() {
    constexpr int kWide = 37, kHigh = 9;
    unsigned char* memory;
    size_t pitch;
    CUDA(cudaMallocPitch(&memory, &pitch, kWide, kHigh));
    std::vector<unsigned char> bytes(kWide * kHigh);
    for (int i = 0; i < kWide * kHigh; ++i)
        bytes[i] = (unsigned char)(i * 7);
    CUDA(cudaMemcpy2D(memory, pitch, bytes.data(), kWide, kWide, kHigh, cudaMemcpyHostToDevice));
    cudaResourceDesc from = {};
    from.resType = cudaResourceTypePitch2D;
    from.res.pitch2D.devPtr = memory;
    from.res.pitch2D.desc = cudaCreateChannelDesc<unsigned char>();
    from.res.pitch2D.width = kWide;
    from.res.pitch2D.height = kHigh;
    from.res.pitch2D.pitchInBytes = pitch;
    cudaTextureDesc how = {};
    how.readMode = cudaReadModeNormalizedFloat;
    Out<float> out(kWide * kHigh);
    samplePitched<<<kHigh, 64>>>(texture(from, how), out.memory, kWide, kHigh);
    int bad = 0;
    for (int i = 0; i < kWide * kHigh; ++i)
        bad += std::fabs(out.get()[i] - bytes[i] / 255.0f) > 1e-6f;
    return wrong("pitched", bad);
}

int main() {
    const int bad = flat() + layered() + cubes() + levels() + volume() + pitched();
    CUDA(cudaDeviceSynchronize());
    return finish(bad == 0);
}
