// SPDX-License-Identifier: Apache-2.0
// See texture_run.h.
#include "textures/texture_run.h"

#include "case_processes.h"
#include "driver.h"

#include <cstring>
#include <map>
#include <unistd.h>

namespace conformance {

namespace {

constexpr size_t kWords = size_t(kTextureVectors) * 4;

// The array of a case and the object that reads it.
class Object {
public:
    Object(const Driver& driver, const TextureCase& test) : driver_(driver), test_(test) {
        good_ = makeArrays() && makeObject();
    }
    ~Object() {
        if (handle_)
            test_.isSurface() ? driver_.cuSurfObjectDestroy(handle_)
                              : driver_.cuTexObjectDestroy(handle_);
        if (mipmap_)
            driver_.cuMipmappedArrayDestroy(mipmap_);
        else if (array_)
            driver_.cuArrayDestroy(array_);
    }
    Object(const Object&) = delete;
    Object& operator=(const Object&) = delete;

    bool good() const { return good_; }
    unsigned long long handle() const { return handle_; }

private:
    bool makeArrays() {
        CUDA_ARRAY3D_DESCRIPTOR d = {};
        d.Width = test_.width;
        d.Height = test_.height;
        d.Depth = test_.depth;
        d.Format = CUarray_format(test_.format.value);
        d.NumChannels = test_.format.channels;
        d.Flags = test_.arrayFlags;
        if (test_.levels == 1)
            return driver_.cuArray3DCreate(&array_, &d) == CUDA_SUCCESS && fill(array_, 0);
        if (driver_.cuMipmappedArrayCreate(&mipmap_, &d, test_.levels) != CUDA_SUCCESS)
            return false;
        for (unsigned level = 0; level < test_.levels; ++level)
            if (driver_.cuMipmappedArrayGetLevel(&array_, mipmap_, level) != CUDA_SUCCESS ||
                !fill(array_, level))
                return false;
        return true;
    }

    bool fill(CUarray array, unsigned level) const {
        const std::vector<uint8_t> content = textureContent(test_, level);
        const bool volume = !(test_.arrayFlags & (CUDA_ARRAY3D_LAYERED | CUDA_ARRAY3D_CUBEMAP));
        const unsigned edge = test_.format.kind == 'b' ? 4 : 1;
        const auto smaller = [&](unsigned size, bool scales) -> size_t {
            return !size ? 1 : scales ? std::max(1u, size >> level) : size;
        };
        CUDA_MEMCPY3D copy = {};
        copy.srcMemoryType = CU_MEMORYTYPE_HOST;
        copy.srcHost = content.data();
        copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
        copy.dstArray = array;
        copy.WidthInBytes = (smaller(test_.width, true) + edge - 1) / edge * test_.format.bytes;
        copy.Height = (smaller(test_.height, true) + edge - 1) / edge;
        copy.Depth = smaller(test_.depth, volume);
        copy.srcPitch = copy.WidthInBytes;
        copy.srcHeight = copy.Height;
        return driver_.cuMemcpy3D(&copy) == CUDA_SUCCESS;
    }

    bool makeObject() {
        CUDA_RESOURCE_DESC resource = {};
        if (mipmap_) {
            resource.resType = CU_RESOURCE_TYPE_MIPMAPPED_ARRAY;
            resource.res.mipmap.hMipmappedArray = mipmap_;
        } else {
            resource.resType = CU_RESOURCE_TYPE_ARRAY;
            resource.res.array.hArray = array_;
        }
        if (test_.isSurface())
            return driver_.cuSurfObjectCreate(&handle_, &resource) == CUDA_SUCCESS;
        return driver_.cuTexObjectCreate(&handle_, &resource, &test_.sampling, nullptr) ==
               CUDA_SUCCESS;
    }

    const Driver& driver_;
    const TextureCase& test_;
    CUarray array_ = nullptr;
    CUmipmappedArray mipmap_ = nullptr;
    unsigned long long handle_ = 0;
    bool good_ = false;
};

// The module of a kernel; null if it is refused. Cases share kernels.
CUmodule moduleOf(const Driver& driver, const std::string& ptx) {
    static std::map<std::string, CUmodule> all;
    const auto [found, isNew] = all.emplace(ptx, nullptr);
    if (isNew &&
        driver.cuModuleLoadDataEx(&found->second, ptx.c_str(), 0, nullptr, nullptr) != CUDA_SUCCESS)
        found->second = nullptr;
    return found->second;
}

bool runCase(const Driver& driver, const TextureCase& test, CUdeviceptr in, CUdeviceptr out,
             uint32_t* words) {
    const Object object(driver, test);
    CUmodule module = object.good() ? moduleOf(driver, textureKernel(test)) : nullptr;
    if (!module)
        return false;
    std::vector<TextureVector> vectors;
    for (unsigned i = 0; i < kTextureVectors; ++i)
        vectors.push_back(textureVector(test, i));
    driver.copyIn(in, vectors.data(), vectors.size() * sizeof vectors[0]);
    driver.clear(out, kWords * 4);
    unsigned long long handle = object.handle();
    void* parameters[] = {&handle, &in, &out};
    CUfunction function = nullptr;
    const bool launched = driver.cuModuleGetFunction(&function, module, "k") == CUDA_SUCCESS &&
                          driver.cuLaunchKernel(function, kTextureVectors / 32, 1, 1, 32, 1, 1, 0,
                                                nullptr, parameters, nullptr) == CUDA_SUCCESS;
    if (launched &&
        (driver.cuCtxSynchronize() != CUDA_SUCCESS || !driver.copyOut(words, out, kWords * 4)))
        _exit(3); // the context is lost
    return launched;
}

} // namespace

TextureResults runTextures(const std::string& only) {
    const std::vector<TextureCase>& cases = allTextureCases();
    std::vector<std::string> names;
    for (const TextureCase& test : cases)
        names.push_back(test.name);
    auto* words = share<uint32_t>(cases.size() * kWords);
    const CaseOutcomes outcomes =
        runCases(names, only, 1, "textures", [&](const Driver& driver) {
            const CUdeviceptr in = driver.allocate(kTextureVectors * sizeof(TextureVector));
            const CUdeviceptr out = driver.allocate(kWords * 4);
            return [&, in, out](size_t i) {
                return runCase(driver, cases[i], in, out, words + i * kWords);
            };
        });
    TextureResults results;
    results.device = outcomes.device;
    results.status = outcomes.status;
    for (size_t i = 0; i < cases.size(); ++i) {
        results.words.emplace_back();
        if (outcomes.status[i] == Status::kDone)
            results.words.back().assign(words + i * kWords, words + (i + 1) * kWords);
    }
    return results;
}

} // namespace conformance
