// SPDX-License-Identifier: Apache-2.0
// Arrays of opacity micromaps (OptiX 7.6, optixOpacityMicromapArray...).
#include "engine/micromap.h"
#include "api/optix7/build_inputs.h"
#include "api/optix7/entry_points.h"
#include "api/optix7/relocation.h"

namespace sunstone::optix7 {
namespace {

constexpr unsigned kArrayAlignment = OPTIX_OPACITY_MICROMAP_ARRAY_BUFFER_BYTE_ALIGNMENT;
static_assert(kArrayAlignment == bvh::kMicromapArrayAlignment);
static_assert(sizeof(OptixOpacityMicromapDesc) == sizeof(bvh::MicromapDesc));

// Copies the histogram; throws an Error naming the field.
std::vector<bvh::MicromapHistogramEntry>
checkHistogram(const OptixOpacityMicromapArrayBuildInput* input, const ApiCall& call) {
    requireNonNull(input, "buildInput");
    constexpr unsigned kBoth = OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_TRACE |
                               OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_BUILD;
    if (input->flags & ~kBoth)
        fail(Code::kInvalidValue, "buildInput->flags = ", input->flags, " has unknown bits");
    if (input->flags == kBoth)
        tolerate(call, "both are ignored", "buildInput->flags = ", input->flags,
                 " has both PREFER_FAST_TRACE and PREFER_FAST_BUILD");
    if (input->numMicromapHistogramEntries != 0)
        requireNonNull(input->micromapHistogramEntries, "buildInput->micromapHistogramEntries");
    std::vector<bvh::MicromapHistogramEntry> histogram;
    for (unsigned i = 0; i < input->numMicromapHistogramEntries; ++i) {
        const OptixOpacityMicromapHistogramEntry& entry = input->micromapHistogramEntries[i];
        checkMicromapKind(entry.subdivisionLevel, entry.format,
                          message("buildInput->micromapHistogramEntries[", i, "]."));
        histogram.push_back(
            {entry.count, entry.subdivisionLevel, bvh::MicromapFormat(entry.format)});
    }
    return histogram;
}

void checkDescriptions(device::Device& device, const OptixOpacityMicromapArrayBuildInput& input,
                       uint64_t count) {
    constexpr unsigned kAlignment = OPTIX_OPACITY_MICROMAP_DESC_BUFFER_BYTE_ALIGNMENT;
    constexpr unsigned kSize = sizeof(OptixOpacityMicromapDesc);
    const unsigned stride = input.perMicromapDescStrideInBytes;
    if (stride != 0 && (stride < kSize || stride % kAlignment != 0))
        fail(Code::kInvalidValue, "buildInput->perMicromapDescStrideInBytes = ", stride,
             " is neither 0 nor a multiple of ", kAlignment);
    if (count == 0)
        return;
    requireDeviceMemory(device, "buildInput->perMicromapDescBuffer", input.perMicromapDescBuffer,
                        (count - 1) * (stride ? stride : kSize) + kSize, kAlignment);
    // The size of the states is known only after reading the descriptions, so check only the start.
    requireDeviceMemory(device, "buildInput->inputBuffer", input.inputBuffer, 1, kArrayAlignment);
}

void checkBuffers(device::Device& device, const OptixMicromapBuffers& buffers,
                  const bvh::MicromapArraySizes& sizes) {
    const auto check = [&](const char* name, CUdeviceptr buffer, size_t size, size_t needed) {
        if (size < needed)
            fail(Code::kInvalidValue, name, "SizeInBytes = ", size, ", but ", needed,
                 " bytes are needed");
        requireDeviceMemory(device, name, buffer, size, kArrayAlignment);
    };
    check("buffers->output", buffers.output, buffers.outputSizeInBytes, sizes.output);
    check("buffers->temp", buffers.temp, buffers.tempSizeInBytes, sizes.temp);
}

} // namespace

OptixResult
opacityMicromapArrayComputeMemoryUsage(OptixDeviceContext context,
                                       const OptixOpacityMicromapArrayBuildInput* buildInput,
                                       OptixMicromapBufferSizes* bufferSizes) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixOpacityMicromapArrayComputeMemoryUsage", [&] {
        contextOf(context);
        const bvh::MicromapArraySizes sizes = bvh::micromapArraySizes(
            checkHistogram(buildInput, {*owner, "optixOpacityMicromapArrayComputeMemoryUsage"}));
        requireNonNull(bufferSizes, "bufferSizes");
        bufferSizes->outputSizeInBytes = sizes.output;
        bufferSizes->tempSizeInBytes = sizes.temp;
    });
}

OptixResult opacityMicromapArrayBuild(OptixDeviceContext context, CUstream stream,
                                      const OptixOpacityMicromapArrayBuildInput* buildInput,
                                      const OptixMicromapBuffers* buffers) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixOpacityMicromapArrayBuild", [&] {
        contextOf(context);
        device::Device& device = *owner->engine->device;
        engine::MicromapArrayBuild request;
        request.histogram = checkHistogram(buildInput, {*owner, "optixOpacityMicromapArrayBuild"});
        requireNonNull(buffers, "buffers");
        const bvh::MicromapArraySizes sizes = bvh::micromapArraySizes(request.histogram);
        checkDescriptions(device, *buildInput, bvh::micromapCount(request.histogram));
        checkBuffers(device, *buffers, sizes);
        request.states = reinterpret_cast<const void*>(buildInput->inputBuffer);
        request.descriptions = reinterpret_cast<const void*>(buildInput->perMicromapDescBuffer);
        request.descriptionStride = buildInput->perMicromapDescStrideInBytes;
        request.output = reinterpret_cast<void*>(buffers->output);
        request.outputSize = buffers->outputSizeInBytes;
        request.stream = stream;
        engine::buildMicromapArray(owner->engine, std::move(request));
    });
}

OptixResult opacityMicromapArrayGetRelocationInfo(OptixDeviceContext context,
                                                  CUdeviceptr opacityMicromapArray,
                                                  OptixRelocationInfo* info) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixOpacityMicromapArrayGetRelocationInfo", [&] {
        contextOf(context);
        requireNonNull(info, "info");
        const bvh::RelocationInfo found = engine::micromapRelocationInfo(
            owner->engine, reinterpret_cast<const void*>(opacityMicromapArray));
        std::memcpy(info, &found, sizeof(found));
    });
}

OptixResult opacityMicromapArrayRelocate(OptixDeviceContext context, CUstream stream,
                                         const OptixRelocationInfo* info,
                                         CUdeviceptr targetOpacityMicromapArray,
                                         size_t targetOpacityMicromapArraySizeInBytes) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixOpacityMicromapArrayRelocate", [&] {
        contextOf(context);
        requireNonNull(info, "info");
        const bvh::RelocationInfo translated = translate(*info);
        if (!bvh::isRelocatable(translated) || !bvh::holdsMicromaps(translated))
            fail(Code::kInvalidValue,
                 "info was not filled by "
                 "optixOpacityMicromapArrayGetRelocationInfo of a compatible version");
        const uint64_t size = bvh::relocatedSize(translated);
        if (targetOpacityMicromapArraySizeInBytes < size)
            fail(Code::kInvalidValue,
                 "targetOpacityMicromapArraySizeInBytes = ", targetOpacityMicromapArraySizeInBytes,
                 " is less than the ", size, " bytes of the array");
        requireDeviceMemory(*owner->engine->device, "targetOpacityMicromapArray",
                            targetOpacityMicromapArray, targetOpacityMicromapArraySizeInBytes,
                            kArrayAlignment);
        engine::relocateMicromapArray(owner->engine, stream, translated,
                                      reinterpret_cast<void*>(targetOpacityMicromapArray));
    });
}

} // namespace sunstone::optix7
