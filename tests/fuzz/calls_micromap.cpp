// SPDX-License-Identifier: Apache-2.0
// Fuzzing of arrays of opacity micromaps (OptiX 7.6): sizes, builds, relocation.
#include "world.h"

#if FUZZ_76

#include <algorithm>

namespace fuzz {
namespace {

constexpr unsigned kMostMaps = 12, kMostLevel = 4;

// Descriptions, states and histogram that belong together, as a rule.
OptixOpacityMicromapArrayBuildInput arrayInput(World& w) {
    const unsigned count = w.below(kMostMaps + 1);
    const size_t most = size_t(1) << (2 * kMostLevel - 2); // bytes of the largest map
    std::vector<uint8_t> states(most * (count + 1));
    for (uint8_t& byte : states)
        byte = uint8_t(w.any32());
    const unsigned stride = w.chance(85) ? 0 : w.oneOf({8u, 16u, 24u, 4u, w.below(40)});
    const size_t step = stride ? stride : sizeof(OptixOpacityMicromapDesc);
    std::vector<uint8_t> descriptions(step * count + sizeof(OptixOpacityMicromapDesc));
    std::vector<OptixOpacityMicromapHistogramEntry> histogram;
    for (unsigned i = 0; i < count; ++i) {
        OptixOpacityMicromapDesc desc{};
        desc.byteOffset = w.chance(97) ? w.below(uint32_t(most * count)) : w.any32();
        desc.subdivisionLevel = (unsigned short)(w.chance(97) ? w.below(kMostLevel) : w.any32());
        const auto format = w.enumerator(
            {OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE});
        desc.format = (unsigned short)(format);
        std::memcpy(descriptions.data() + i * step, &desc, sizeof(desc));
        histogram.push_back(
            {w.nearly(1), w.chance(98) ? desc.subdivisionLevel : w.any32(), format});
    }
    if (w.chance(4) && !histogram.empty())
        histogram[0].count = w.any32(); // absurd, or zero
    OptixOpacityMicromapArrayBuildInput input{};
    input.flags = w.chance(95) ? w.below(3) : w.any32();
    input.inputBuffer = w.address(states.size());
    if (w.chance(92)) {
        input.inputBuffer = w.memory(states.size());
        std::memcpy(reinterpret_cast<void*>(input.inputBuffer), states.data(), states.size());
    }
    input.perMicromapDescBuffer =
        w.chance(96) ? w.upload(descriptions) / 8 * 8 : w.address(descriptions.size(), 8);
    input.perMicromapDescStrideInBytes = stride;
    input.numMicromapHistogramEntries = unsigned(histogram.size());
    input.micromapHistogramEntries = w.chance(97) ? w.keep(histogram) : nullptr;
    return input;
}

void build(World& w) {
    if (w.mapped() > (size_t(64) << 20))
        return;
    const OptixOpacityMicromapArrayBuildInput input = arrayInput(w);
    OptixDeviceContext context = w.context();
    OptixMicromapBufferSizes sizes{};
    w.done("optixOpacityMicromapArrayComputeMemoryUsage",
           optixOpacityMicromapArrayComputeMemoryUsage(context, w.chance(97) ? &input : nullptr,
                                                       w.chance(97) ? &sizes : nullptr));
    if (sizes.outputSizeInBytes > (size_t(4) << 20) || sizes.tempSizeInBytes > (size_t(4) << 20))
        return;
    OptixMicromapBuffers buffers{};
    buffers.output = w.address(sizes.outputSizeInBytes);
    buffers.outputSizeInBytes = w.nearlySize(sizes.outputSizeInBytes);
    buffers.temp = w.address(sizes.tempSizeInBytes);
    buffers.tempSizeInBytes = w.nearlySize(sizes.tempSizeInBytes);
    const OptixResult result = optixOpacityMicromapArrayBuild(
        context, w.stream(), w.chance(98) ? &input : nullptr, w.chance(98) ? &buffers : nullptr);
    if (result == OPTIX_SUCCESS)
        w.arrays.push_back({buffers.output, sizes.outputSizeInBytes});
    w.done("optixOpacityMicromapArrayBuild", result);
}
const Call kBuild{"optixOpacityMicromapArrayBuild", 8, build};

void relocate(World& w) {
    OptixDeviceContext context = w.context();
    const MicromapArray from = !w.arrays.empty() && w.chance(90)
                                   ? w.arrays[w.below(uint32_t(w.arrays.size()))]
                                   : MicromapArray{w.address(1 << 10), 1 << 10};
    OptixRelocationInfo info{};
    const OptixResult known = optixOpacityMicromapArrayGetRelocationInfo(
        context, from.address, w.chance(97) ? &info : nullptr);
    w.done("optixOpacityMicromapArrayGetRelocationInfo", known);
    if (w.chance(8))
        w.garble(&info, sizeof(info));
    if (w.chance(4) && !w.structures.empty()) // of another kind
        w.done("optixAccelGetRelocationInfo",
               optixAccelGetRelocationInfo(context, w.traversable(), &info));
    w.wait();
    CUdeviceptr target = w.memory(from.size);
    if (known == OPTIX_SUCCESS && w.chance(95)) // memory that is not an array need not be readable
        std::memcpy(reinterpret_cast<void*>(target), reinterpret_cast<void*>(from.address),
                    from.size);
    target = w.chance(95) ? target : w.address(from.size);
    const OptixResult result = optixOpacityMicromapArrayRelocate(
        context, w.stream(), w.chance(97) ? &info : nullptr, target, w.nearlySize(from.size));
    if (result == OPTIX_SUCCESS)
        w.arrays.push_back({target, from.size});
    w.done("optixOpacityMicromapArrayRelocate", result);
}
const Call kRelocate{"optixOpacityMicromapArrayRelocate", 3, relocate};

} // namespace
} // namespace fuzz

#endif
