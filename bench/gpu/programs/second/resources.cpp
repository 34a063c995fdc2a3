// SPDX-License-Identifier: Apache-2.0
// Textures and CUDA kernels of the second set.
#include "kit.h"

#include <string>
#include <utility>

namespace bench {

FloatTexture::FloatTexture(const std::vector<float>& texels, unsigned channels,
                           const TextureShape& shape) {
    const int bits = channels == 4 ? 32 : 0;
    const cudaChannelFormatDesc format = {32, bits, bits, bits, cudaChannelFormatKindFloat};
    const cudaExtent extent = {shape.width, shape.height, shape.depth};
    CUDA_CHECK(cudaMalloc3DArray(&array_, &format, extent, 0));
    cudaMemcpy3DParms copy = {};
    copy.srcPtr = {const_cast<float*>(texels.data()), shape.width * channels * sizeof(float),
                   shape.width, shape.height};
    copy.dstArray = array_;
    copy.extent = {shape.width, shape.height, std::max(shape.depth, 1u)};
    copy.kind = cudaMemcpyHostToDevice;
    CUDA_CHECK(cudaMemcpy3D(&copy));
    cudaResourceDesc resource = {};
    resource.resType = cudaResourceTypeArray;
    resource.res.array.array = array_;
    cudaTextureDesc description = {};
    for (auto& mode : description.addressMode)
        mode = shape.wraps ? cudaAddressModeWrap : cudaAddressModeClamp;
    description.filterMode = cudaFilterModeLinear;
    description.readMode = cudaReadModeElementType;
    description.normalizedCoords = 1;
    CUDA_CHECK(cudaCreateTextureObject(&object_, &resource, &description, nullptr));
}
FloatTexture::FloatTexture(FloatTexture&& other) noexcept
    : array_(std::exchange(other.array_, nullptr)), object_(std::exchange(other.object_, 0)) {}
FloatTexture::~FloatTexture() {
    if (object_)
        cudaDestroyTextureObject(object_);
    if (array_)
        cudaFreeArray(array_);
}

std::vector<unsigned char> spots(unsigned seed, unsigned side) {
    std::vector<unsigned char> texels(size_t(side) * side * 4);
    for (unsigned i = 0; i < side * side; ++i) {
        const unsigned cell = i / side / 16 * (side / 16) + i % side / 16;
        for (unsigned k = 0; k < 4; ++k)
            texels[4 * size_t(i) + k] =
                (unsigned char)(90 + 110 * randomOf(cell + seed, k) + 50 * randomOf(i, k));
    }
    return texels;
}

namespace {

// A function of the driver, which this program does not link.
template <class F>
F* driverFunction(const char* name) {
    void* function = nullptr;
    cudaDriverEntryPointQueryResult result = {};
    CUDA_CHECK(cudaGetDriverEntryPoint(name, &function, cudaEnableDefault, &result));
    if (!function)
        throw std::runtime_error(std::string("the driver has no function ") + name);
    return reinterpret_cast<F*>(function);
}
void checkDriver(CUresult result, const char* call) {
    if (result != CUDA_SUCCESS)
        throw std::runtime_error(std::string(call) + " failed: " + std::to_string(int(result)));
}

} // namespace

Kernels::Kernels(std::string_view ptx) {
    const auto load = driverFunction<decltype(cuModuleLoadData)>("cuModuleLoadData");
    checkDriver(load(&module_, std::string(ptx).c_str()), "cuModuleLoadData");
}
Kernels::~Kernels() {
    driverFunction<decltype(cuModuleUnload)>("cuModuleUnload")(module_);
}

void Kernels::runWith(const char* name, size_t count, void* argument) {
    static const auto get = driverFunction<decltype(cuModuleGetFunction)>("cuModuleGetFunction");
    static const auto launch = driverFunction<decltype(cuLaunchKernel)>("cuLaunchKernel");
    constexpr unsigned kBlock = 128;
    CUfunction function = nullptr;
    checkDriver(get(&function, module_, name), "cuModuleGetFunction");
    void* arguments[] = {argument};
    checkDriver(launch(function, unsigned((count + kBlock - 1) / kBlock), 1, 1, kBlock, 1, 1, 0,
                       nullptr, arguments, nullptr),
                "cuLaunchKernel");
}

} // namespace bench
