// SPDX-License-Identifier: Apache-2.0
// Leaves whose outlines are in a texture: with only an any-hit program, and with opacity micromaps.
#include "scene.h"

#include "foliage.h"

std::string_view bench_leaves_ptx();

namespace bench {
namespace {

constexpr unsigned kMaskSide = 256, kLevel = 5;

// The mask of a leaf in alpha, with veins.
std::vector<unsigned char> leafTexels(const std::vector<unsigned char>& mask) {
    std::vector<unsigned char> texels(mask.size() * 4);
    for (size_t i = 0; i < mask.size(); ++i) {
        const float vein = randomOf(unsigned(i / kMaskSide / 8), 1);
        texels[4 * i] = (unsigned char)(60 + 60 * vein);
        texels[4 * i + 1] = (unsigned char)(120 + 60 * vein);
        texels[4 * i + 2] = 40;
        texels[4 * i + 3] = mask[i];
    }
    return texels;
}

// An array with the micromaps of a leaf's two triangles.
DeviceBuffer buildMicromaps(OptixDeviceContext context, const std::vector<unsigned char>& mask) {
    std::vector<unsigned char> states;
    std::vector<OptixOpacityMicromapDesc> descriptions;
    for (unsigned triangle = 0; triangle < 2; ++triangle) {
        descriptions.push_back({unsigned(states.size()), (unsigned short)kLevel,
                                OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE});
        const auto bytes = packStates(leafStates({mask.data(), kMaskSide}, triangle, kLevel));
        states.insert(states.end(), bytes.begin(), bytes.end());
    }
    DeviceBuffer deviceStates, deviceDescriptions;
    deviceStates.upload(states);
    deviceDescriptions.upload(descriptions);
    const OptixOpacityMicromapHistogramEntry histogram = {2, kLevel,
                                                          OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE};
    OptixOpacityMicromapArrayBuildInput input = {};
    input.flags = OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_TRACE;
    input.inputBuffer = deviceStates.address();
    input.perMicromapDescBuffer = deviceDescriptions.address();
    input.numMicromapHistogramEntries = 1;
    input.micromapHistogramEntries = &histogram;
    OptixMicromapBufferSizes sizes = {};
    OPTIX_CHECK(optixOpacityMicromapArrayComputeMemoryUsage(context, &input, &sizes));
    DeviceBuffer array(sizes.outputSizeInBytes), temporary(sizes.tempSizeInBytes);
    const OptixMicromapBuffers buffers = {array.address(), array.size(), temporary.address(),
                                          temporary.size()};
    OPTIX_CHECK(optixOpacityMicromapArrayBuild(context, nullptr, &input, &buffers));
    CUDA_CHECK(cudaDeviceSynchronize());
    return array;
}

Job leaves(OptixDeviceContext context, const JobSettings& settings, bool hasMicromaps) {
    Job job;
    job.ptx = bench_leaves_ptx();
    job.micromaps = hasMicromaps;
    job.traceDepth = 2;
    job.raygen = "__raygen__camera";
    job.misses = {"__miss__sky", "__miss__sun"};
    job.hits = {{"__closesthit__leaf", "__anyhit__mask"}, {nullptr, "__anyhit__mask"}};
    const Mesh mesh = makeLeaves(settings.some(2e5, 400));
    const Triangles uploaded = uploadTriangles(job, mesh);
    const std::vector<unsigned char> mask = makeLeafMask(kMaskSide);
    const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
    OptixBuildInput input = inputOf(uploaded, flags);
    DeviceBuffer indices;
    const OptixOpacityMicromapUsageCount usage = {uploaded.triangleCount, kLevel,
                                                  OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE};
    if (hasMicromaps) {
        job.buffers.push_back(buildMicromaps(context, mask));
        std::vector<short> micromapOf(uploaded.triangleCount);
        for (size_t i = 0; i < micromapOf.size(); ++i)
            micromapOf[i] = short(i & 1);
        indices.upload(micromapOf);
        OptixBuildInputOpacityMicromap& o = input.triangleArray.opacityMicromap;
        o.indexingMode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED;
        o.opacityMicromapArray = job.buffers.back().address();
        o.indexBuffer = indices.address();
        o.indexSizeInBytes = sizeof(short);
        o.numMicromapUsageCounts = 1;
        o.micromapUsageCounts = &usage;
    }
    job.structures.push_back(buildAccel(context, input));
    job.params.scene = job.structures.back().handle;
    job.textures.emplace_back(leafTexels(mask), kMaskSide);
    Look look = materialOf(uploaded, vec(1.0f));
    look.textures[0] = job.textures.back().object();
    job.records = {{0, look}, {1, look}};
    lightOutside(job, mesh, settings);
    job.params.samples = 4;
    job.allocatePicture(settings.width, settings.height);
    return job;
}
Job alpha(OptixDeviceContext context, const JobSettings& settings) {
    return leaves(context, settings, false);
}
Job micromaps(OptixDeviceContext context, const JobSettings& settings) {
    return leaves(context, settings, true);
}

} // namespace

std::vector<JobKind> leafJobs() {
    return {
        {"alpha", "any-hit programs read alpha textures", alpha, 0.002, 0.02},
        {"micromaps", "the same leaves with opacity micromaps", micromaps, 0.002, 0.02},
    };
}

} // namespace bench
