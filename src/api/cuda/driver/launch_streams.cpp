// SPDX-License-Identifier: Apache-2.0
// cuLaunchKernel and its variants. Compiled twice, see shell.h.
#include "api/cuda/driver/launch.h"

using namespace sunstone::api::cuda;

namespace {

// The attributes of cuLaunchKernelEx. Hints about caches and scheduling have no effect;
// programmatic serialization permits an overlap that does not occur here.
void readAttribute(const CUlaunchAttribute& attribute, LaunchRequest& request) {
    switch (attribute.id) {
    case CU_LAUNCH_ATTRIBUTE_IGNORE:
    case CU_LAUNCH_ATTRIBUTE_ACCESS_POLICY_WINDOW:
    case CU_LAUNCH_ATTRIBUTE_SYNCHRONIZATION_POLICY:
    case CU_LAUNCH_ATTRIBUTE_CLUSTER_SCHEDULING_POLICY_PREFERENCE:
    case CU_LAUNCH_ATTRIBUTE_PROGRAMMATIC_STREAM_SERIALIZATION:
    case CU_LAUNCH_ATTRIBUTE_PRIORITY:
    case CU_LAUNCH_ATTRIBUTE_MEM_SYNC_DOMAIN_MAP:
    case CU_LAUNCH_ATTRIBUTE_MEM_SYNC_DOMAIN:
    case CU_LAUNCH_ATTRIBUTE_PREFERRED_SHARED_MEMORY_CARVEOUT:
        return;
    case CU_LAUNCH_ATTRIBUTE_COOPERATIVE:
        request.cooperative = attribute.value.cooperative != 0;
        return;
    case CU_LAUNCH_ATTRIBUTE_CLUSTER_DIMENSION: {
        const auto& size = attribute.value.clusterDim;
        require(size.x && size.y && size.z, "a cluster dimension is 0");
        if (size.x != 1 || size.y != 1 || size.z != 1)
            refuse(CUDA_ERROR_NOT_SUPPORTED, "clusters of ", size.x, " x ", size.y, " x ", size.z,
                   " blocks; the device has none (CU_DEVICE_ATTRIBUTE_CLUSTER_LAUNCH is 0)");
        return;
    }
    default:
        refuse(CUDA_ERROR_NOT_SUPPORTED, "launch attribute ", attribute.id);
    }
}

} // namespace

SUNSTONE_EXPORT CUresult cuLaunchKernel(CUfunction function, unsigned int gridX, unsigned int gridY,
                                        unsigned int gridZ, unsigned int blockX,
                                        unsigned int blockY, unsigned int blockZ,
                                        unsigned int sharedBytes, CUstream stream, void** params,
                                        void** extra) {
    return guarded("cuLaunchKernel", {Needs::kQueue, stream}, [&] {
        launch(
            {function, {gridX, gridY, gridZ}, {blockX, blockY, blockZ}, sharedBytes, params, extra},
            resolveStream(stream));
    });
}

SUNSTONE_EXPORT CUresult cuLaunchKernelEx(const CUlaunchConfig* config, CUfunction function,
                                          void** params, void** extra) {
    return guarded("cuLaunchKernelEx", {Needs::kQueue, config ? config->hStream : nullptr}, [&] {
        require(config, "config is null");
        require(config->numAttrs == 0 || config->attrs, "attrs is null");
        LaunchRequest request{function,
                              {config->gridDimX, config->gridDimY, config->gridDimZ},
                              {config->blockDimX, config->blockDimY, config->blockDimZ},
                              config->sharedMemBytes,
                              params,
                              extra};
        for (unsigned i = 0; i < config->numAttrs; ++i)
            readAttribute(config->attrs[i], request);
        launch(request, resolveStream(config->hStream));
    });
}

SUNSTONE_EXPORT CUresult cuLaunchCooperativeKernel(CUfunction function, unsigned int gridX,
                                                   unsigned int gridY, unsigned int gridZ,
                                                   unsigned int blockX, unsigned int blockY,
                                                   unsigned int blockZ, unsigned int sharedBytes,
                                                   CUstream stream, void** params) {
    return guarded("cuLaunchCooperativeKernel", {Needs::kQueue, stream}, [&] {
        launch({function,
                {gridX, gridY, gridZ},
                {blockX, blockY, blockZ},
                sharedBytes,
                params,
                nullptr,
                true},
               resolveStream(stream));
    });
}
