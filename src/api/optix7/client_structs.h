// SPDX-License-Identifier: Apache-2.0
// Structs whose size differs between ABIs, copied between a client's form and ours. Up to ABI 68
// releases only appended members (or used padding), so a client's struct is a prefix of ours. The
// copy has exactly the members of the client's ABI, without padding. Missing members become zero,
// which always means "none". Structs not named here are equal in all ABIs.
#pragma once

#include "api/optix7/abi.h"

#include "optix.h"

#include <cstddef>
#include <cstring>

namespace sunstone::optix7 {

// Bytes of T, from its start, that hold members in an ABI.
template <class T>
constexpr size_t clientBytes(Abi) = delete;

#define SUNSTONE_BYTES_BEFORE(type, member) offsetof(type, member)
#define SUNSTONE_BYTES_UP_TO(type, member) (offsetof(type, member) + sizeof(type::member))

template <>
constexpr size_t clientBytes<OptixDeviceContextOptions>(Abi abi) {
    return abi < kAbi72 ? SUNSTONE_BYTES_BEFORE(OptixDeviceContextOptions, validationMode)
                        : sizeof(OptixDeviceContextOptions);
}
template <>
constexpr size_t clientBytes<OptixModuleCompileOptions>(Abi abi) {
    return abi < kAbi72   ? SUNSTONE_BYTES_UP_TO(OptixModuleCompileOptions, debugLevel)
           : abi < kAbi74 ? SUNSTONE_BYTES_BEFORE(OptixModuleCompileOptions, numPayloadTypes)
                          : sizeof(OptixModuleCompileOptions);
}
template <>
constexpr size_t clientBytes<OptixPipelineCompileOptions>(Abi abi) {
    return abi < kAbi71 ? SUNSTONE_BYTES_BEFORE(OptixPipelineCompileOptions, usesPrimitiveTypeFlags)
           : abi < kAbi76
               ? SUNSTONE_BYTES_BEFORE(OptixPipelineCompileOptions, allowOpacityMicromaps)
               : sizeof(OptixPipelineCompileOptions);
}
// An unused int before 7.4.
template <>
constexpr size_t clientBytes<OptixProgramGroupOptions>(Abi abi) {
    return abi < kAbi74 ? 0 : sizeof(OptixProgramGroupOptions);
}
template <>
constexpr size_t clientBytes<OptixBuiltinISOptions>(Abi abi) {
    return abi < kAbi74 ? SUNSTONE_BYTES_BEFORE(OptixBuiltinISOptions, buildFlags)
                        : sizeof(OptixBuiltinISOptions);
}
template <>
constexpr size_t clientBytes<OptixBuildInputTriangleArray>(Abi abi) {
    return abi < kAbi71   ? SUNSTONE_BYTES_BEFORE(OptixBuildInputTriangleArray, transformFormat)
           : abi < kAbi76 ? SUNSTONE_BYTES_BEFORE(OptixBuildInputTriangleArray, opacityMicromap)
                          : sizeof(OptixBuildInputTriangleArray);
}
template <>
constexpr size_t clientBytes<OptixBuildInputCurveArray>(Abi abi) {
    return abi < kAbi74 ? SUNSTONE_BYTES_BEFORE(OptixBuildInputCurveArray, endcapFlags)
                        : sizeof(OptixBuildInputCurveArray);
}
// 7.0 and 7.1 have further members for the instances' boxes, which were never needed.
template <>
constexpr size_t clientBytes<OptixBuildInputInstanceArray>(Abi abi) {
    return abi < kAbi76 ? SUNSTONE_BYTES_BEFORE(OptixBuildInputInstanceArray, instanceStride)
                        : sizeof(OptixBuildInputInstanceArray);
}
template <>
constexpr size_t clientBytes<OptixDenoiserGuideLayer>(Abi abi) {
    return abi < kAbi75
               ? SUNSTONE_BYTES_BEFORE(OptixDenoiserGuideLayer, previousOutputInternalGuideLayer)
               : sizeof(OptixDenoiserGuideLayer);
}
template <>
constexpr size_t clientBytes<OptixDenoiserParams>(Abi abi) {
    return abi < kAbi72 ? SUNSTONE_BYTES_UP_TO(OptixDenoiserParams, blendFactor)
           : abi < kAbi75
               ? SUNSTONE_BYTES_BEFORE(OptixDenoiserParams, temporalModeUsePreviousLayers)
               : SUNSTONE_BYTES_UP_TO(OptixDenoiserParams, temporalModeUsePreviousLayers);
}
template <>
constexpr size_t clientBytes<OptixDenoiserSizes>(Abi abi) {
    return abi < kAbi75
               ? SUNSTONE_BYTES_UP_TO(OptixDenoiserSizes, overlapWindowSizeInPixels)
               : SUNSTONE_BYTES_UP_TO(OptixDenoiserSizes, internalGuideLayerPixelSizeInBytes);
}
#undef SUNSTONE_BYTES_BEFORE
#undef SUNSTONE_BYTES_UP_TO

// Structs that later releases removed.

struct PipelineLinkOptions70 { // 7.0
    OptixPipelineLinkOptions common;
    int overrideUsesMotionBlur; // rays have a time even if the modules have no motion blur
};
static_assert(sizeof(PipelineLinkOptions70) == 12);

struct DenoiserOptions70 { // 7.0 to 7.2; 7.0 has one more member, a pixel format, as images do
    enum InputKind : int { kColor = 0x2301, kColorAlbedo = 0x2302, kColorAlbedoNormal = 0x2303 };
    int inputKind;
};
static_assert(sizeof(DenoiserOptions70) == 4);

// Whether T differs between ABIs.
template <class T>
concept DiffersBetweenAbis = requires(Abi abi) {
    clientBytes<T>(abi);
};

// A client's struct in our form.
template <DiffersBetweenAbis T>
T fromClient(const void* given, Abi abi) {
    T out{};
    std::memcpy(static_cast<void*>(&out), given, clientBytes<T>(abi));
    return out;
}

// A client's build inputs, each converted when it is read. If the count is wrong, reading stops at
// the first invalid input.
class BuildInputs {
public:
    BuildInputs(const OptixBuildInput* array, Abi abi) : array_(array), abi_(abi) {}
    explicit operator bool() const { return array_ != nullptr; }
    Abi abi() const { return abi_; }
    // For a type that the ABI lacks, only `type` is set.
    OptixBuildInput operator[](unsigned index) const;
    // Whether the ABI has inputs of this type.
    bool hasType(OptixBuildInputType type) const;

private:
    const OptixBuildInput* array_;
    Abi abi_;
};

} // namespace sunstone::optix7
