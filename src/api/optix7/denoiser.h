// SPDX-License-Identifier: Apache-2.0
// The object behind an OptixDenoiser, and what the functions of all releases share: until 7.2 a
// denoiser got its model after its creation, and Invoke took its images in one array
// (denoiser_70.cpp); since 7.3 both are as in denoiser.cpp.
#pragma once

#include "api/optix7/shell.h"
#include "engine/denoiser.h"

#include <map>

namespace sunstone::optix7 {

struct DenoiserObject {
    std::shared_ptr<DeviceContext> context;
    denoise::Model model;                          // until 7.2 only the guides until it is set
    std::shared_ptr<const denoise::Filter> filter; // null until then

    // What was set up, by the address of the state memory: a client may keep several.
    struct Setup {
        unsigned width, height;
    };
    std::mutex mutex;
    std::map<CUdeviceptr, Setup> setups;
};

HandleTable<DenoiserObject>& denoisers();

// The live denoiser of a handle; throws otherwise.
std::shared_ptr<DenoiserObject> denoiserOf(OptixDenoiser handle);
// The context of a denoiser outside any guard; null if the denoiser is not alive.
std::shared_ptr<DeviceContext> peek(OptixDenoiser handle);

// What a number means in an ABI; throws if it means nothing there.
denoise::Kind checkKind(OptixDenoiserModelKind kind, Abi abi);
// The model in a client's memory; throws if there is none.
denoise::Model checkUserModel(const void* data, size_t size);

// Where optixDenoiserInvoke works, in all releases.
struct InvokePlace {
    CUstream stream;
    CUdeviceptr state;
    size_t stateSize;
    unsigned inputOffsetX, inputOffsetY;
    CUdeviceptr scratch;
    size_t scratchSize;
};
void invoke(DenoiserObject& denoiser, const InvokePlace& place, const OptixDenoiserParams& params,
            const OptixDenoiserGuideLayer& guideLayer, const OptixDenoiserLayer* layers,
            unsigned numLayers);

} // namespace sunstone::optix7
