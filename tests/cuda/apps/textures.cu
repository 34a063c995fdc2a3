// SPDX-License-Identifier: Apache-2.0
// Samples textures of every geometry, address, filter and read mode. The expected output was
// recorded on a GPU (textures.expected): weights of the filters, borders, seams of cubes, levels.
// Numbers are compared with a tolerance of one weight of the filter.
#include "check.h"

#include <cmath>
#include <cstring>
#include <vector>

enum Kind {
    k1D,
    k2D,
    k3D,
    k1DLayered,
    k2DLayered,
    kCube,
    kCubeLayered,
    k2DLod,
    k2DGrad,
    kGather0,
    kGather3,
    kFetch,
    k1DLod,
    k3DLod
};

__global__ void sampleFloat(cudaTextureObject_t t, int kind, const float* c, int n, float4* out) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= n)
        return;
    const float x = c[4 * i], y = c[4 * i + 1], z = c[4 * i + 2], w = c[4 * i + 3];
    float4 r = make_float4(0, 0, 0, 0);
    switch (kind) {
    case k1D: r = tex1D<float4>(t, x); break;
    case k2D: r = tex2D<float4>(t, x, y); break;
    case k3D: r = tex3D<float4>(t, x, y, z); break;
    case k1DLayered: r = tex1DLayered<float4>(t, x, int(w)); break;
    case k2DLayered: r = tex2DLayered<float4>(t, x, y, int(w)); break;
    case kCube: r = texCubemap<float4>(t, x, y, z); break;
    case kCubeLayered: r = texCubemapLayered<float4>(t, x, y, z, int(w)); break;
    case k2DLod: r = tex2DLod<float4>(t, x, y, w); break;
    case k1DLod: r = tex1DLod<float4>(t, x, w); break;
    case k3DLod: r = tex3DLod<float4>(t, x, y, z, w); break;
    case k2DGrad: r = tex2DGrad<float4>(t, x, y, make_float2(z, 0), make_float2(0, w)); break;
    case kGather0: r = tex2Dgather<float4>(t, x, y, 0); break;
    case kGather3: r = tex2Dgather<float4>(t, x, y, 3); break;
    case kFetch: r = tex1Dfetch<float4>(t, int(x)); break;
    }
    out[i] = r;
}

__global__ void sampleInt(cudaTextureObject_t t, int kind, const float* c, int n, uint4* out) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= n)
        return;
    const float x = c[4 * i], y = c[4 * i + 1];
    out[i] = kind == kFetch ? tex1Dfetch<uint4>(t, int(x))
             : kind == kGather0 ? tex2Dgather<uint4>(t, x, y, 0)
                                : tex2D<uint4>(t, x, y);
}

static float* deviceCoordinates;
static float4* deviceResults;
static float4 results[256];

static void sample(const char* name, cudaTextureObject_t t, int kind, const std::vector<float4>& c,
                   int channels = 1) {
    const int n = int(c.size());
    CHECK(cudaMemcpy(deviceCoordinates, c.data(), n * sizeof(float4), cudaMemcpyHostToDevice));
    sampleFloat<<<(n + 63) / 64, 64>>>(t, kind, deviceCoordinates, n, deviceResults);
    CHECK(cudaMemcpy(results, deviceResults, n * sizeof(float4), cudaMemcpyDeviceToHost));
    std::printf("%s", name);
    for (int i = 0; i < n; ++i) {
        const float v[4] = {results[i].x, results[i].y, results[i].z, results[i].w};
        for (int k = 0; k < channels; ++k)
            std::printf("%c%.9g", k ? ',' : ' ', v[k]);
    }
    std::printf("\n");
}

static void sampleBits(const char* name, cudaTextureObject_t t, int kind,
                       const std::vector<float4>& c) {
    const int n = int(c.size());
    CHECK(cudaMemcpy(deviceCoordinates, c.data(), n * sizeof(float4), cudaMemcpyHostToDevice));
    sampleInt<<<(n + 63) / 64, 64>>>(t, kind, deviceCoordinates, n,
                                     reinterpret_cast<uint4*>(deviceResults));
    CHECK(cudaMemcpy(results, deviceResults, n * sizeof(float4), cudaMemcpyDeviceToHost));
    std::printf("%s", name);
    const uint4* bits = reinterpret_cast<const uint4*>(results);
    for (int i = 0; i < n; ++i)
        std::printf(" %x,%x,%x,%x", bits[i].x, bits[i].y, bits[i].z, bits[i].w);
    std::printf("\n");
}

static cudaTextureDesc description(cudaTextureAddressMode address, cudaTextureFilterMode filter,
                                   bool normalized, cudaTextureReadMode read) {
    cudaTextureDesc d;
    std::memset(&d, 0, sizeof d);
    d.addressMode[0] = d.addressMode[1] = d.addressMode[2] = address;
    d.filterMode = filter;
    d.normalizedCoords = normalized;
    d.readMode = read;
    d.borderColor[0] = 0.25f;
    d.borderColor[3] = 0.75f;
    d.mipmapFilterMode = cudaFilterModePoint;
    d.maxMipmapLevelClamp = 20;
    return d;
}

static cudaTextureObject_t textureOf(cudaArray_t array, const cudaTextureDesc& d) {
    cudaResourceDesc r;
    std::memset(&r, 0, sizeof r);
    r.resType = cudaResourceTypeArray;
    r.res.array.array = array;
    cudaTextureObject_t t = 0;
    CHECK(cudaCreateTextureObject(&t, &r, &d, nullptr));
    return t;
}

template <class T>
static cudaArray_t make3D(const std::vector<T>& data, cudaChannelFormatDesc format, cudaExtent extent,
                          unsigned flags = 0) {
    cudaArray_t array = nullptr;
    CHECK(cudaMalloc3DArray(&array, &format, extent, flags));
    cudaMemcpy3DParms copy;
    std::memset(&copy, 0, sizeof copy);
    const size_t rows = extent.height ? extent.height : 1, slices = extent.depth ? extent.depth : 1;
    copy.srcPtr = make_cudaPitchedPtr(const_cast<T*>(data.data()), extent.width * sizeof(T),
                                      extent.width, rows);
    copy.dstArray = array;
    copy.extent = make_cudaExtent(extent.width, rows, slices);
    copy.kind = cudaMemcpyHostToDevice;
    CHECK(cudaMemcpy3D(&copy));
    return array;
}

template <class T>
static cudaArray_t make2D(const std::vector<T>& data, cudaChannelFormatDesc format, size_t width,
                          size_t height, unsigned flags = 0) {
    cudaArray_t array = nullptr;
    CHECK(cudaMallocArray(&array, &format, width, height, flags));
    const size_t rows = height ? height : 1;
    CHECK(cudaMemcpy2DToArray(array, 0, 0, data.data(), width * sizeof(T), width * sizeof(T), rows,
                              cudaMemcpyHostToDevice));
    return array;
}

static const char* const kAddressNames[] = {"wrap", "clamp", "mirror", "border"};
static const cudaTextureAddressMode kAddress[] = {cudaAddressModeWrap, cudaAddressModeClamp,
                                                  cudaAddressModeMirror, cudaAddressModeBorder};

static std::vector<float> numbers(size_t count) {
    std::vector<float> data(count);
    for (size_t i = 0; i < count; ++i)
        data[i] = float((i * 37 + 11) % 101);
    return data;
}

static void addressModes() {
    const cudaArray_t array = make2D(numbers(35), cudaCreateChannelDesc<float>(), 5, 7);
    std::vector<float4> c;
    for (int i = 0; i < 24; ++i)
        c.push_back(make_float4(-1.3f + 0.131f * i, 1.9f - 0.127f * i, 0, 0));
    for (float v : {0.0f, 1.0f, -1.0f, 0.5f, 0.1f, 0.999999f, -1e-9f, 1e6f, -1e6f, 1e30f})
        c.push_back(make_float4(v, 0.5f, 0, 0));
    std::vector<float4> whole = c;
    for (float4& v : whole)
        v.x *= 5, v.y *= 7;
    for (int a = 0; a < 4; ++a)
        for (int filter = 0; filter < 2; ++filter)
            for (int normalized = 0; normalized < 2; ++normalized) {
                char name[64];
                std::snprintf(name, sizeof name, "%s %s %s", kAddressNames[a],
                              filter ? "linear" : "point", normalized ? "normalized" : "whole");
                const cudaTextureObject_t t = textureOf(
                    array, description(kAddress[a], cudaTextureFilterMode(filter), normalized,
                                       cudaReadModeElementType));
                sample(name, t, k2D, normalized ? c : whole);
                CHECK(cudaDestroyTextureObject(t));
            }
    CHECK(cudaFreeArray(array));
}

// The weights of the linear filter: two texels 0 and 1.
static void weights() {
    const cudaArray_t two = make2D(std::vector<float>{0, 1}, cudaCreateChannelDesc<float>(), 2, 0);
    std::vector<float4> c;
    for (int i = -3; i < 60; ++i)
        c.push_back(make_float4(0.5f + i / 2048.0f, 0, 0, 0));
    for (int i = 0; i < 20; ++i)
        c.push_back(make_float4(0.5f + i * 0.0517f, 0, 0, 0));
    cudaTextureObject_t t = textureOf(two, description(cudaAddressModeClamp, cudaFilterModeLinear,
                                                       false, cudaReadModeElementType));
    sample("weights whole", t, k1D, c);
    CHECK(cudaDestroyTextureObject(t));
    for (float4& v : c)
        v.x *= 0.5f;
    t = textureOf(two, description(cudaAddressModeWrap, cudaFilterModeLinear, true,
                                   cudaReadModeElementType));
    sample("weights normalized", t, k1D, c);
    CHECK(cudaDestroyTextureObject(t));
    CHECK(cudaFreeArray(two));
    const cudaArray_t three =
        make2D(std::vector<float>{0, 1, 0}, cudaCreateChannelDesc<float>(), 3, 0);
    for (float4& v : c)
        v.x *= 2.0f / 3.0f;
    t = textureOf(three, description(cudaAddressModeMirror, cudaFilterModeLinear, true,
                                     cudaReadModeElementType));
    sample("weights of three", t, k1D, c);
    CHECK(cudaDestroyTextureObject(t));
    CHECK(cudaFreeArray(three));
}

template <class T>
static void format(const char* name, cudaChannelFormatDesc desc, const std::vector<T>& texels,
                   bool isFloat) {
    const cudaArray_t array = make2D(texels, desc, texels.size() / 2, 2);
    std::vector<float4> c;
    for (int i = 0; i < 6; ++i)
        c.push_back(make_float4(0.5f + (i % 3) * 1.0f, 0.5f + i / 3, 0, 0));
    c.push_back(make_float4(-2, 0.5f, 0, 0));
    if (!isFloat) {
        const cudaTextureObject_t t = textureOf(
            array,
            description(cudaAddressModeBorder, cudaFilterModePoint, false, cudaReadModeElementType));
        sampleBits(name, t, k2D, c);
        CHECK(cudaDestroyTextureObject(t));
    }
    if (isFloat || desc.x < 32) {
        const cudaTextureReadMode read =
            isFloat ? cudaReadModeElementType : cudaReadModeNormalizedFloat;
        for (int filter = 0; filter < 2; ++filter) {
            for (float4& v : c)
                v.x += filter * 0.3f, v.y += filter * 0.2f;
            const cudaTextureObject_t t = textureOf(
                array,
                description(cudaAddressModeBorder, cudaTextureFilterMode(filter), false, read));
            sample(name, t, k2D, c, 4);
            CHECK(cudaDestroyTextureObject(t));
        }
    }
    CHECK(cudaFreeArray(array));
}

static void formats() {
    std::vector<uchar4> bytes;
    std::vector<ushort4> words;
    std::vector<unsigned char> single;
    std::vector<short2> pairs;
    std::vector<int> ints;
    std::vector<uint2> longs;
    for (unsigned i = 0; i < 6; ++i) {
        bytes.push_back(make_uchar4(i * 50, 255 - i * 50, i == 3 ? 128 : 127, i * 3));
        words.push_back(make_ushort4(i * 13107, 65535 - i, 32768 - i, i));
        single.push_back((unsigned char)(i * 51));
        pairs.push_back(make_short2(short(i * 13107), short(i == 0 ? -32768 : -int(i) * 100)));
        ints.push_back(i % 2 ? int(i * 1000000007u) : -int(i));
        longs.push_back(make_uint2(i, ~i));
    }
    format("uchar4", cudaCreateChannelDesc<uchar4>(), bytes, false);
    format("char4", cudaCreateChannelDesc<char4>(), bytes, false);
    format("ushort4", cudaCreateChannelDesc<ushort4>(), words, false);
    format("uchar", cudaCreateChannelDesc<unsigned char>(), single, false);
    format("short2", cudaCreateChannelDesc<short2>(), pairs, false);
    format("int", cudaCreateChannelDesc<int>(), ints, false);
    format("uint2", cudaCreateChannelDesc<uint2>(), longs, false);
    // 1, 0.5, -2, 65504, 2^-24, 1/3
    const std::vector<unsigned short> halves = {0x3C00, 0x3800, 0xC000, 0x7BFF, 0x0001, 0x3555};
    format("half", cudaCreateChannelDesc(16, 0, 0, 0, cudaChannelFormatKindFloat), halves, true);

    // sRGB: every 5th value; the last channel is linear
    std::vector<uchar4> ramp;
    for (unsigned i = 0; i < 52; ++i)
        ramp.push_back(make_uchar4(i * 5, 255 - i * 5, i, i * 5));
    const cudaArray_t array = make2D(ramp, cudaCreateChannelDesc<uchar4>(), 52, 0);
    cudaTextureDesc d = description(cudaAddressModeClamp, cudaFilterModePoint, false,
                                    cudaReadModeNormalizedFloat);
    d.sRGB = 1;
    std::vector<float4> c;
    for (int i = 0; i < 52; ++i)
        c.push_back(make_float4(i + 0.5f, 0, 0, 0));
    cudaTextureObject_t t = textureOf(array, d);
    sample("srgb", t, k1D, c, 4);
    CHECK(cudaDestroyTextureObject(t));
    d.filterMode = cudaFilterModeLinear;
    for (float4& v : c)
        v.x += 0.25f;
    t = textureOf(array, d);
    sample("srgb linear", t, k1D, c, 4);
    CHECK(cudaDestroyTextureObject(t));
    CHECK(cudaFreeArray(array));
}

static void shapes() {
    std::vector<float4> c;
    for (int i = 0; i < 24; ++i)
        c.push_back(make_float4(0.045f * i - 0.02f, 1.03f - 0.044f * i, 0.041f * i, float(i % 6) - 1));
    const cudaTextureDesc linear = description(cudaAddressModeClamp, cudaFilterModeLinear, true,
                                               cudaReadModeElementType);
    const cudaTextureDesc point = description(cudaAddressModeWrap, cudaFilterModePoint, true,
                                              cudaReadModeElementType);
    struct Shape {
        const char* name;
        int kind;
        cudaExtent extent;
        unsigned flags;
    };
    const Shape all[] = {
        {"3d", k3D, make_cudaExtent(4, 3, 5), 0},
        {"1d layered", k1DLayered, make_cudaExtent(6, 0, 4), cudaArrayLayered},
        {"2d layered", k2DLayered, make_cudaExtent(4, 3, 4), cudaArrayLayered},
    };
    for (const Shape& s : all) {
        const size_t count = s.extent.width * (s.extent.height ? s.extent.height : 1) * s.extent.depth;
        const cudaArray_t array =
            make3D(numbers(count), cudaCreateChannelDesc<float>(), s.extent, s.flags);
        for (const cudaTextureDesc* d : {&point, &linear}) {
            const cudaTextureObject_t t = textureOf(array, *d);
            sample(s.name, t, s.kind, c);
            CHECK(cudaDestroyTextureObject(t));
        }
        CHECK(cudaFreeArray(array));
    }
    // Directions over all faces, near edges and corners.
    std::vector<float4> directions;
    for (int i = 0; i < 64; ++i) {
        const float a = i * 0.41f, b = i * 0.173f;
        directions.push_back(make_float4(cosf(a) * cosf(b), sinf(b), sinf(a) * cosf(b), float(i % 3)));
    }
    for (float s : {1.0f, -1.0f})
        for (float e : {0.97f, 1.0f, -0.98f}) {
            directions.push_back(make_float4(s, e, 0.1f, 0));
            directions.push_back(make_float4(0.2f, s, e, 0));
            directions.push_back(make_float4(e, -0.3f, s, 0));
            directions.push_back(make_float4(s, e, e * 0.99f, 0));
        }
    for (unsigned flags : {unsigned(cudaArrayCubemap), unsigned(cudaArrayCubemap | cudaArrayLayered)}) {
        const bool layered = flags & cudaArrayLayered;
        const cudaExtent extent = make_cudaExtent(4, 4, layered ? 12 : 6);
        const cudaArray_t array = make3D(numbers(16 * extent.depth), cudaCreateChannelDesc<float>(),
                                         extent, flags);
        for (const cudaTextureDesc* d : {&point, &linear}) {
            const cudaTextureObject_t t = textureOf(array, *d);
            sample(layered ? "cube layered" : "cube", t, layered ? kCubeLayered : kCube, directions);
            CHECK(cudaDestroyTextureObject(t));
            if (!layered) {
                cudaTextureDesc seamless = *d;
                seamless.seamlessCubemap = 1;
                const cudaTextureObject_t t2 = textureOf(array, seamless);
                sample("cube seamless", t2, kCube, directions);
                CHECK(cudaDestroyTextureObject(t2));
            }
        }
        CHECK(cudaFreeArray(array));
    }
}

static void levels() {
    cudaMipmappedArray_t mips = nullptr;
    const cudaChannelFormatDesc desc = cudaCreateChannelDesc<float>();
    CHECK(cudaMallocMipmappedArray(&mips, &desc, make_cudaExtent(16, 8, 0), 5));
    for (unsigned level = 0; level < 5; ++level) {
        cudaArray_t array = nullptr;
        CHECK(cudaGetMipmappedArrayLevel(&array, mips, level));
        const size_t width = 16 >> level, height = (8 >> level) ? 8 >> level : 1;
        std::vector<float> data(width * height);
        for (size_t i = 0; i < data.size(); ++i)
            data[i] = float(level * 32 + i % 7);
        CHECK(cudaMemcpy2DToArray(array, 0, 0, data.data(), width * 4, width * 4, height,
                                  cudaMemcpyHostToDevice));
    }
    cudaResourceDesc r;
    std::memset(&r, 0, sizeof r);
    r.resType = cudaResourceTypeMipmappedArray;
    r.res.mipmap.mipmap = mips;
    std::vector<float4> c;
    for (int i = -3; i < 40; ++i)
        c.push_back(make_float4(0.41f + 0.011f * i, 0.6f, 0, i * 0.137f));
    for (int i = 0; i < 12; ++i)
        c.push_back(make_float4(0.5f, 0.5f, 0, 1 + i / 1024.0f));
    std::vector<float4> gradients;
    for (int i = 0; i < 24; ++i)
        gradients.push_back(make_float4(0.31f, 0.6f, 0.02f * i, 0.013f * (24 - i)));
    for (int filter = 0; filter < 2; ++filter)
        for (int mip = 0; mip < 2; ++mip)
            for (int variant = 0; variant < 3; ++variant) {
                if (variant == 2 && mip == 1) // devices sharpen the filter between levels
                    continue;
                cudaTextureDesc d =
                    description(cudaAddressModeWrap, cudaTextureFilterMode(filter), true,
                                cudaReadModeElementType);
                d.mipmapFilterMode = cudaTextureFilterMode(mip);
                if (variant == 1) {
                    d.mipmapLevelBias = 0.7f;
                    d.minMipmapLevelClamp = 0.9f;
                    d.maxMipmapLevelClamp = 2.3f;
                }
                if (variant == 2)
                    d.maxAnisotropy = 8;
                char name[64];
                std::snprintf(name, sizeof name, "levels filter%d mip%d variant%d", filter, mip, variant);
                cudaTextureObject_t t = 0;
                CHECK(cudaCreateTextureObject(&t, &r, &d, nullptr));
                sample(name, t, k2DLod, c);
                std::snprintf(name, sizeof name, "gradients filter%d mip%d variant%d", filter, mip, variant);
                // Each device spreads an anisotropic footprint differently.
                if (variant != 2)
                    sample(name, t, k2DGrad, gradients);
                CHECK(cudaDestroyTextureObject(t));
            }
    CHECK(cudaFreeMipmappedArray(mips));
}

static void gathersAndFetches() {
    std::vector<uchar4> bytes;
    for (unsigned i = 0; i < 20; ++i)
        bytes.push_back(make_uchar4(i, i + 40, i + 80, i + 120));
    const cudaArray_t array =
        make2D(bytes, cudaCreateChannelDesc<uchar4>(), 5, 4, cudaArrayTextureGather);
    std::vector<float4> c;
    for (int i = 0; i < 12; ++i)
        c.push_back(make_float4(0.49f + 0.4f * i, 3.2f - 0.3f * i, 0, 0));
    cudaTextureObject_t t = textureOf(array, description(cudaAddressModeClamp, cudaFilterModePoint,
                                                         false, cudaReadModeNormalizedFloat));
    sample("gather", t, kGather0, c, 4);
    sample("gather", t, kGather3, c, 4);
    CHECK(cudaDestroyTextureObject(t));
    t = textureOf(array, description(cudaAddressModeBorder, cudaFilterModePoint, false,
                                     cudaReadModeElementType));
    sampleBits("gather bits", t, kGather0, c);
    CHECK(cudaDestroyTextureObject(t));
    CHECK(cudaFreeArray(array));

    float* memory = nullptr;
    CHECK(cudaMalloc((void**)&memory, 64 * 512));
    const std::vector<float> data = numbers(64);
    CHECK(cudaMemcpy(memory, data.data(), 64 * 4, cudaMemcpyHostToDevice));
    cudaResourceDesc r;
    std::memset(&r, 0, sizeof r);
    r.resType = cudaResourceTypeLinear;
    r.res.linear.devPtr = memory;
    r.res.linear.desc = cudaCreateChannelDesc<float2>();
    r.res.linear.sizeInBytes = 64 * 4;
    cudaTextureDesc d = description(cudaAddressModeClamp, cudaFilterModePoint, false,
                                    cudaReadModeElementType);
    CHECK(cudaCreateTextureObject(&t, &r, &d, nullptr));
    std::vector<float4> indices;
    for (int i = -2; i < 36; i += 3)
        indices.push_back(make_float4(float(i), 0, 0, 0));
    sample("fetch", t, kFetch, indices, 4);
    CHECK(cudaDestroyTextureObject(t));

    for (int y = 0; y < 4; ++y)
        CHECK(cudaMemcpy((char*)memory + y * 512, data.data() + y * 6, 24, cudaMemcpyHostToDevice));
    std::memset(&r, 0, sizeof r);
    r.resType = cudaResourceTypePitch2D;
    r.res.pitch2D.devPtr = memory;
    r.res.pitch2D.desc = cudaCreateChannelDesc<float>();
    r.res.pitch2D.width = 6;
    r.res.pitch2D.height = 4;
    r.res.pitch2D.pitchInBytes = 512;
    d.filterMode = cudaFilterModeLinear;
    CHECK(cudaCreateTextureObject(&t, &r, &d, nullptr));
    sample("pitched", t, k2D, c);
    CHECK(cudaDestroyTextureObject(t));
    CHECK(cudaFree(memory));
}

int main() {
    CHECK(cudaMalloc((void**)&deviceCoordinates, sizeof results));
    CHECK(cudaMalloc((void**)&deviceResults, sizeof results));
    addressModes();
    weights();
    formats();
    shapes();
    levels();
    gathersAndFetches();
    std::printf("done\n");
    return 0;
}
