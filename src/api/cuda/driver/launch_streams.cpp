// SPDX-License-Identifier: Apache-2.0
// cuLaunchKernel and its like. Compiled twice, see shell.h.
#include "api/cuda/driver/launch.h"

using namespace sunstone::api::cuda;

SUNSTONE_EXPORT CUresult cuLaunchKernel(CUfunction function, unsigned int gridX, unsigned int gridY,
                                        unsigned int gridZ, unsigned int blockX,
                                        unsigned int blockY, unsigned int blockZ,
                                        unsigned int sharedBytes, CUstream stream, void** params,
                                        void** extra) {
    return guarded("cuLaunchKernel", Needs::kContext, [&] {
        launch(
            {function, {gridX, gridY, gridZ}, {blockX, blockY, blockZ}, sharedBytes, params, extra},
            resolveStream(stream));
    });
}

SUNSTONE_EXPORT CUresult cuLaunchKernelEx(const CUlaunchConfig* config, CUfunction function,
                                          void** params, void** extra) {
    return guarded("cuLaunchKernelEx", Needs::kContext, [&] {
        require(config, "config is null");
        require(config->numAttrs == 0 || config->attrs, "attrs is null");
        for (unsigned i = 0; i < config->numAttrs; ++i) {
            constexpr unsigned kIgnore = 0, kPolicyWindow = 1, kPriority = 8;
            const unsigned id = config->attrs[i].id;
            if (id != kIgnore && id != kPolicyWindow && id != kPriority)
                refuse(CUDA_ERROR_NOT_SUPPORTED, "launch attribute ", id);
        }
        launch({function,
                {config->gridDimX, config->gridDimY, config->gridDimZ},
                {config->blockDimX, config->blockDimY, config->blockDimZ},
                config->sharedMemBytes,
                params,
                extra},
               resolveStream(config->hStream));
    });
}
