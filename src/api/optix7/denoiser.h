// SPDX-License-Identifier: Apache-2.0
// The object behind an OptixDenoiser and its table.
#pragma once

#include "api/optix7/shell.h"
#include "engine/denoiser.h"

#include <map>

namespace sunstone::optix7 {

struct DenoiserObject {
    std::shared_ptr<DeviceContext> context;
    denoise::Model model;
    std::shared_ptr<const denoise::Filter> filter;

    // What was set up, by the address of the state memory: a client may keep several.
    struct Setup {
        unsigned width, height;
    };
    std::mutex mutex;
    std::map<CUdeviceptr, Setup> setups;
};

HandleTable<DenoiserObject>& denoisers();

} // namespace sunstone::optix7
