// SPDX-License-Identifier: Apache-2.0
// Shared by programs that try one call of the driver API after another and print the outcome of
// each: names of results, blocks of memory of every kind with sums of their contents, arrays of
// every sort.
#pragma once

#include <cuda.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

inline std::string nameOf(CUresult result) {
    const char* name = nullptr;
    if (cuGetErrorName(result, &name) != CUDA_SUCCESS)
        return "code " + std::to_string(int(result));
    return std::strncmp(name, "CUDA_", 5) == 0 ? name + 5 : name;
}

#define MUST(call)                                                                                 \
    do {                                                                                           \
        const CUresult checked = (call);                                                           \
        if (checked != CUDA_SUCCESS) {                                                             \
            std::printf("line %d: %s: %s\n", __LINE__, #call, nameOf(checked).c_str());            \
            std::exit(1);                                                                          \
        }                                                                                          \
    } while (0)

constexpr size_t kBytes = 8192;

inline std::vector<unsigned char> pattern(size_t bytes, unsigned seed) {
    std::vector<unsigned char> result(bytes);
    for (size_t i = 0; i < bytes; ++i)
        result[i] = static_cast<unsigned char>(i * 7 + (i >> 8) * 13 + seed * 31);
    return result;
}
inline uint32_t sumOf(const void* data, size_t bytes) {
    uint32_t sum = 2166136261u;
    for (size_t i = 0; i < bytes; ++i)
        sum = (sum ^ static_cast<const unsigned char*>(data)[i]) * 16777619u;
    return sum;
}

// A block of kBytes, or an array.
struct Place {
    std::string name;
    unsigned char* bytes = nullptr;
    bool onDevice = false;
    CUarray array = nullptr;
    CUDA_ARRAY3D_DESCRIPTOR shape = {};
    size_t element = 0;

    CUdeviceptr address() const { return CUdeviceptr(bytes); }
    size_t rows() const { return shape.Height ? shape.Height : 1; }
    size_t slices() const { return shape.Depth ? shape.Depth : 1; }
    size_t size() const { return array ? shape.Width * element * rows() * slices() : kBytes; }
    CUDA_MEMCPY3D whole(void* host, bool toArray) const {
        CUDA_MEMCPY3D copy = {};
        copy.srcMemoryType = toArray ? CU_MEMORYTYPE_HOST : CU_MEMORYTYPE_ARRAY;
        copy.dstMemoryType = toArray ? CU_MEMORYTYPE_ARRAY : CU_MEMORYTYPE_HOST;
        copy.srcHost = copy.dstHost = host;
        copy.srcArray = copy.dstArray = array;
        copy.WidthInBytes = copy.srcPitch = copy.dstPitch = shape.Width * element;
        copy.Height = copy.srcHeight = copy.dstHeight = rows();
        copy.Depth = slices();
        return copy;
    }
    void fill(unsigned seed) const {
        const std::vector<unsigned char> data = pattern(size(), seed);
        const CUDA_MEMCPY3D copy = whole(const_cast<unsigned char*>(data.data()), true);
        if (array)
            MUST(cuMemcpy3D(&copy));
        else if (onDevice)
            MUST(cuMemcpyHtoD(address(), data.data(), kBytes));
        else
            std::memcpy(bytes, data.data(), kBytes);
    }
    uint32_t sum() const {
        std::vector<unsigned char> data(size());
        const CUDA_MEMCPY3D copy = whole(data.data(), false);
        if (array)
            MUST(cuMemcpy3D(&copy));
        else if (onDevice)
            MUST(cuMemcpyDtoH(data.data(), address(), kBytes));
        else
            std::memcpy(data.data(), bytes, kBytes);
        return sumOf(data.data(), data.size());
    }
};

inline Place arrayPlace(const char* name, CUarray array, size_t element) {
    Place place;
    place.name = name;
    place.array = array;
    MUST(cuArray3DGetDescriptor(&place.shape, array));
    place.element = element;
    return place;
}
inline Place makeArray(const char* name, size_t width, size_t height, size_t depth,
                       unsigned flags = 0, CUarray_format format = CU_AD_FORMAT_UNSIGNED_INT8,
                       unsigned channels = 4, size_t element = 4) {
    const CUDA_ARRAY3D_DESCRIPTOR shape = {width, height, depth, format, channels, flags};
    CUarray array = nullptr;
    MUST(cuArray3DCreate(&array, &shape));
    return arrayPlace(name, array, element);
}
inline Place makeLevel(const char* name, size_t width, size_t height, size_t depth, unsigned flags,
                       unsigned level) {
    const CUDA_ARRAY3D_DESCRIPTOR shape = {width, height, depth, CU_AD_FORMAT_UNSIGNED_INT8,
                                           4,     flags};
    CUmipmappedArray mipmap = nullptr;
    CUarray array = nullptr;
    MUST(cuMipmappedArrayCreate(&mipmap, &shape, 4));
    MUST(cuMipmappedArrayGetLevel(&array, mipmap, level));
    return arrayPlace(name, array, 4);
}

// Blocks of kBytes; on the device a large unmapped range follows them.
struct Blocks {
    Place pageable, pinned, device, other, managed;

    Blocks() {
        static unsigned char memory[kBytes * 4];
        pageable = {"pageable", memory + kBytes};
        void* host = nullptr;
        MUST(cuMemHostAlloc(&host, kBytes, 0));
        pinned = {"pinned", static_cast<unsigned char*>(host)};
        device = {"device", onDevice(), true};
        other = {"other", onDevice(), true};
        CUdeviceptr address = 0;
        MUST(cuMemAllocManaged(&address, kBytes, CU_MEM_ATTACH_GLOBAL));
        managed = {"managed", reinterpret_cast<unsigned char*>(address), true};
    }
    static unsigned char* onDevice() {
        CUdeviceptr address = 0;
        MUST(cuMemAlloc(&address, kBytes));
        return reinterpret_cast<unsigned char*>(address);
    }
};

struct Cases {
    CUstream stream = nullptr; // for asynchronous forms

    // Prints the result of each form of a call, and the sum of the bytes it wrote; one if all
    // agree.
    template <class Call>
    void run(const std::string& name, const Place* changed, int forms, Call&& call) {
        std::string text;
        bool same = true;
        std::string first;
        for (int form = 0; form < forms; ++form) {
            uint32_t before = 0;
            if (changed) {
                changed->fill(2);
                before = changed->sum();
            }
            CUresult result = call(form);
            const CUresult after = cuCtxSynchronize();
            std::string said = nameOf(result);
            if (after)
                said += ", then " + nameOf(after);
            else if (changed) {
                const uint32_t sum = changed->sum();
                char number[16];
                std::snprintf(number, sizeof number, " %08x", unsigned(sum));
                if (sum != before)
                    said += number;
            }
            if (form == 0)
                first = said;
            same = same && said == first;
            text += (form ? " | " : "") + said;
        }
        std::printf("%s: %s\n", name.c_str(), (same ? first : text).c_str());
        std::fflush(stdout);
        if (cuCtxSynchronize() != CUDA_SUCCESS)
            std::exit(1); // the context is lost
    }
};
