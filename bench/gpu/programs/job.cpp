// SPDX-License-Identifier: Apache-2.0
#include "job.h"

namespace bench {

Texture::Texture(const std::vector<unsigned char>& texels, unsigned side) {
    const cudaChannelFormatDesc format = {8, 8, 8, 8, cudaChannelFormatKindUnsigned};
    CUDA_CHECK(cudaMallocArray(&array_, &format, side, side));
    CUDA_CHECK(cudaMemcpy2DToArray(array_, 0, 0, texels.data(), size_t(side) * 4, size_t(side) * 4,
                                   side, cudaMemcpyHostToDevice));
    cudaResourceDesc resource = {};
    resource.resType = cudaResourceTypeArray;
    resource.res.array.array = array_;
    cudaTextureDesc description = {};
    description.addressMode[0] = description.addressMode[1] = cudaAddressModeWrap;
    description.filterMode = cudaFilterModeLinear;
    description.readMode = cudaReadModeNormalizedFloat;
    description.normalizedCoords = 1;
    CUDA_CHECK(cudaCreateTextureObject(&object_, &resource, &description, nullptr));
}
Texture::Texture(Texture&& other) noexcept
    : array_(std::exchange(other.array_, nullptr)), object_(std::exchange(other.object_, 0)) {}
Texture::~Texture() {
    if (object_)
        cudaDestroyTextureObject(object_);
    if (array_)
        cudaFreeArray(array_);
}

void Job::allocatePicture(unsigned width, unsigned height) {
    params.width = launchWidth = width;
    params.height = launchHeight = height;
    const size_t bytes = size_t(width) * height * sizeof(float4);
    image.allocate(bytes);
    extra.allocate(bytes);
    CUDA_CHECK(cudaMemset(image.data(), 0, bytes));
    params.image = image.as<float4>();
    params.extra = extra.as<float4>();
}

const std::vector<JobKind>& jobKinds() {
    static const std::vector<JobKind> kinds = [] {
        std::vector<JobKind> all;
        for (const auto& jobs :
             {pathJobs(), surfaceJobs(), leafJobs(), motionJobs(), outdoorJobs(), shapeJobs(),
              listJobs(), buildJobs(), secondJobs(), thirdJobs(), fourthJobs(), fifthJobs()})
            all.insert(all.end(), jobs.begin(), jobs.end());
        return all;
    }();
    return kinds;
}

} // namespace bench
