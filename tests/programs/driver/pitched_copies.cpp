// SPDX-License-Identifier: Apache-2.0
// A video pipeline's copies: planes with pitches, boxes of volumes, sets of rectangles, between
// host, device, arrays and the device's own peer functions, on a stream, each checked against a
// model of plain bytes.
#include "host.h"

#include <cstdint>
#include <cstring>
#include <vector>

namespace {

struct Volume {
    size_t pitch, height, depth;
    std::vector<uint8_t> bytes;
    Volume(size_t pitch, size_t height, size_t depth, uint8_t seed)
        : pitch(pitch), height(height), depth(depth), bytes(pitch * height * depth) {
        for (size_t i = 0; i < bytes.size(); ++i)
            bytes[i] = uint8_t(i * 31 + seed + (i >> 8));
    }
    uint8_t& at(size_t x, size_t y, size_t z) { return bytes[(z * height + y) * pitch + x]; }
};

struct Place {
    size_t x, y, z;
};

void modelCopy(Volume& from, Place f, Volume& to, Place t, Place size) {
    for (size_t z = 0; z < size.z; ++z)
        for (size_t y = 0; y < size.y; ++y)
            for (size_t x = 0; x < size.x; ++x)
                to.at(t.x + x, t.y + y, t.z + z) = from.at(f.x + x, f.y + y, f.z + z);
}

CUdeviceptr upload(const Volume& volume) {
    CUdeviceptr memory;
    CU(cuMemAlloc(&memory, volume.bytes.size()));
    CU(cuMemcpyHtoD(memory, volume.bytes.data(), volume.bytes.size()));
    return memory;
}
int difference(CUdeviceptr memory, const Volume& right) {
    std::vector<uint8_t> seen(right.bytes.size());
    CU(cuMemcpyDtoH(seen.data(), memory, seen.size()));
    return std::memcmp(seen.data(), right.bytes.data(), seen.size()) != 0;
}

int boxes(CUstream stream) {
    Volume a(52, 11, 6, 1), b(64, 13, 7, 77);
    const CUdeviceptr da = upload(a), db = upload(b);
    int wrong = 0;
    const Place cases[][3] = {{{0, 0, 0}, {0, 0, 0}, {52, 11, 6}},
                              {{3, 2, 1}, {10, 1, 3}, {17, 6, 4}},
                              {{51, 10, 5}, {63, 12, 6}, {1, 1, 1}},
                              {{4, 0, 2}, {8, 3, 0}, {40, 1, 3}}};
    for (const auto& [from, to, size] : cases) {
        CUDA_MEMCPY3D copy = {};
        copy.srcMemoryType = copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
        copy.srcDevice = da;
        copy.dstDevice = db;
        copy.srcPitch = a.pitch;
        copy.srcHeight = a.height;
        copy.dstPitch = b.pitch;
        copy.dstHeight = b.height;
        copy.srcXInBytes = from.x, copy.srcY = from.y, copy.srcZ = from.z;
        copy.dstXInBytes = to.x, copy.dstY = to.y, copy.dstZ = to.z;
        copy.WidthInBytes = size.x, copy.Height = size.y, copy.Depth = size.z;
        CU(cuMemcpy3DAsync(&copy, stream));
        modelCopy(a, from, b, to, size);
        CU(cuStreamSynchronize(stream));
        wrong += difference(db, b);
    }
    // Unified: the driver determines the memory type of each side.
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = copy.dstMemoryType = CU_MEMORYTYPE_UNIFIED;
    copy.srcDevice = db;
    copy.srcPitch = b.pitch;
    copy.srcHeight = b.height;
    void* pinned;
    CU(cuMemHostAlloc(&pinned, a.bytes.size(), CU_MEMHOSTALLOC_PORTABLE));
    std::memcpy(pinned, a.bytes.data(), a.bytes.size());
    copy.dstDevice = CUdeviceptr(pinned);
    copy.dstPitch = a.pitch;
    copy.dstHeight = a.height;
    copy.srcXInBytes = 5, copy.srcY = 1, copy.srcZ = 2;
    copy.WidthInBytes = 33, copy.Height = 9, copy.Depth = 4;
    CU(cuMemcpy3D(&copy));
    modelCopy(b, {5, 1, 2}, a, {0, 0, 0}, {33, 9, 4});
    wrong += std::memcmp(pinned, a.bytes.data(), a.bytes.size()) != 0;
    CU(cuMemFreeHost(pinned));
    CU(cuMemFree(da));
    CU(cuMemFree(db));
    return wrong;
}

int arrays(CUstream stream) {
    Volume host(40, 6, 4, 9), back(48, 8, 4, 200);
    CUDA_ARRAY3D_DESCRIPTOR description = {10, 6, 4, CU_AD_FORMAT_UNSIGNED_INT16, 2, 0};
    CUarray array;
    CU(cuArray3DCreate(&array, &description));
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_HOST;
    copy.srcHost = host.bytes.data();
    copy.srcPitch = 40;
    copy.srcHeight = 6;
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = array;
    copy.WidthInBytes = 40, copy.Height = 6, copy.Depth = 4;
    CU(cuMemcpy3DAsync(&copy, stream));
    CUDA_MEMCPY3D out = {};
    out.srcMemoryType = CU_MEMORYTYPE_ARRAY;
    out.srcArray = array;
    out.srcXInBytes = 8, out.srcY = 1, out.srcZ = 1;
    out.dstMemoryType = CU_MEMORYTYPE_HOST;
    out.dstHost = back.bytes.data();
    out.dstPitch = 48;
    out.dstHeight = 8;
    out.dstXInBytes = 3, out.dstY = 2;
    out.WidthInBytes = 24, out.Height = 5, out.Depth = 3;
    CU(cuMemcpy3DAsync(&out, stream));
    CU(cuStreamSynchronize(stream));
    Volume right(48, 8, 4, 200);
    modelCopy(host, {8, 1, 1}, right, {3, 2, 0}, {24, 5, 3});
    CU(cuArrayDestroy(array));
    return back.bytes != right.bytes;
}

int planes(CUstream stream) {
    CUdeviceptr plane;
    size_t pitch;
    CU(cuMemAllocPitch(&plane, &pitch, 100, 20, 4));
    Volume model(pitch, 20, 1, 0);
    CU(cuMemcpyHtoD(plane, model.bytes.data(), model.bytes.size()));
    CU(cuMemsetD2D8Async(plane + 7, pitch, 0xab, 13, 4, stream));
    CU(cuMemsetD2D16Async(plane + 5 * pitch + 20, pitch, 0x1234, 9, 3, stream));
    CU(cuMemsetD2D32Async(plane + 9 * pitch + 40, pitch, 0x89abcdef, 11, 6, stream));
    CU(cuMemsetD8Async(plane + 19 * pitch, 0x5a, 100, stream));
    CU(cuStreamSynchronize(stream));
    const auto set = [&](size_t x, size_t y, size_t w, size_t h, uint32_t value, size_t size) {
        for (size_t r = 0; r < h; ++r)
            for (size_t i = 0; i < w; ++i)
                std::memcpy(&model.at(x + i * size, y + r, 0), &value, size);
    };
    set(7, 0, 13, 4, 0xab, 1);
    set(20, 5, 9, 3, 0x1234, 2);
    set(40, 9, 11, 6, 0x89abcdef, 4);
    set(0, 19, 100, 1, 0x5a, 1);
    int wrong = difference(plane, model);
    // Within one plane, between rows that do not overlap; then through the functions for peers.
    CUDA_MEMCPY2D copy = {};
    copy.srcMemoryType = copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.srcDevice = copy.dstDevice = plane;
    copy.srcPitch = copy.dstPitch = pitch;
    copy.dstY = 10;
    copy.srcXInBytes = 2;
    copy.WidthInBytes = 90;
    copy.Height = 8;
    CU(cuMemcpy2DUnaligned(&copy));
    modelCopy(model, {2, 0, 0}, model, {0, 10, 0}, {90, 8, 1});
    wrong += difference(plane, model);
    CUcontext context;
    CU(cuCtxGetCurrent(&context));
    CUdeviceptr other;
    CU(cuMemAlloc(&other, model.bytes.size()));
    CU(cuMemcpyPeerAsync(other, context, plane, context, model.bytes.size(), stream));
    CU(cuStreamSynchronize(stream));
    wrong += difference(other, model);
    CUDA_MEMCPY3D_PEER peer = {};
    peer.srcMemoryType = peer.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    peer.srcContext = peer.dstContext = context;
    peer.srcDevice = plane;
    peer.dstDevice = other;
    peer.srcPitch = peer.dstPitch = pitch;
    peer.srcHeight = peer.dstHeight = 20;
    peer.srcY = 3;
    peer.dstXInBytes = 11;
    peer.WidthInBytes = 50, peer.Height = 6, peer.Depth = 1;
    CU(cuMemcpy3DPeer(&peer));
    Volume moved = model;
    modelCopy(model, {0, 3, 0}, moved, {11, 0, 0}, {50, 6, 1});
    wrong += difference(other, moved);
    CU(cuMemFree(other));
    CU(cuMemFree(plane));
    return wrong;
}

} // namespace

int main() {
    CUdevice device;
    CUcontext context;
    CUstream stream;
    CU(cuInit(0));
    CU(cuDeviceGet(&device, 0));
    CU(cuDevicePrimaryCtxRetain(&context, device));
    CU(cuCtxSetCurrent(context));
    CU(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
    const int wrong[] = {boxes(stream), arrays(stream), planes(stream)};
    std::printf("boxes %d, arrays %d, planes %d wrong\n", wrong[0], wrong[1], wrong[2]);
    CU(cuStreamDestroy(stream));
    return finish(wrong[0] + wrong[1] + wrong[2] == 0);
}
