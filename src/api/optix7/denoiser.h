// SPDX-License-Identifier: Apache-2.0
// The object behind an OptixDenoiser, and functions shared by all releases. Until 7.2 an
// application set the model after creation, and Invoke took the images in one array
// (denoiser_70.cpp); since 7.3 both are as in denoiser.cpp.
#pragma once

#include "api/optix7/shell.h"
#include "engine/denoiser.h"

#include <map>

namespace sunstone::optix7 {

struct DenoiserObject {
    std::shared_ptr<DeviceContext> context;
    denoise::Model model;                          // until 7.2 only the guides, until the model is
                                                   // set
    std::shared_ptr<const denoise::Filter> filter; // null until the model is set

    // Setups by the address of the state memory: a client may have several.
    struct Setup {
        unsigned width, height;
    };
    std::mutex mutex;
    std::map<CUdeviceptr, Setup> setups;
};

HandleTable<DenoiserObject>& denoisers();

// The live denoiser of a handle; throws for other handles.
std::shared_ptr<DenoiserObject> denoiserOf(OptixDenoiser handle);
// The context of a denoiser, for use outside guards; null if the denoiser is not alive.
std::shared_ptr<DeviceContext> peek(OptixDenoiser handle);

// Converts a number of an ABI; throws if the ABI does not define it.
denoise::Kind checkKind(OptixDenoiserModelKind kind, Abi abi);
// Reads the model from a client's memory; throws if it is invalid.
denoise::Model checkUserModel(const void* data, size_t size);

// The memory and offsets of optixDenoiserInvoke, equal in all releases.
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
