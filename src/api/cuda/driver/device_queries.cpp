// SPDX-License-Identifier: Apache-2.0
// Less common device queries: see cuda.h's sunstone/driver_devices.h.
#include "api/cuda/driver/memory/arrays.h"
#include "api/cuda/driver/modules/image_limits.h"
#include "api/cuda/driver/shell.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

// As with a GPU's driver, an unknown attribute of the pair (0, 0) is the wrong device, too.
SUNSTONE_EXPORT CUresult cuDeviceGetP2PAttribute(int* value, CUdevice_P2PAttribute, CUdevice source,
                                                 CUdevice destination) {
    return guarded("cuDeviceGetP2PAttribute", Needs::kInit, [&] {
        require(value, "value is null");
        requireDevice(source);
        requireDevice(destination);
        refuse(CUDA_ERROR_INVALID_DEVICE, "a device has no link to itself");
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetTexture1DLinearMaxWidth(size_t* texels, CUarray_format format,
                                                            unsigned int channels,
                                                            CUdevice device) {
    return guarded("cuDeviceGetTexture1DLinearMaxWidth", Needs::kInit, [&] {
        require(texels, "texels is null");
        requireDevice(device);
        require(!formatOf(format, channels).isBlock(), "linear memory cannot hold blocks");
        *texels = kMaxLinearTexels;
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetExecAffinitySupport(int* supported, CUexecAffinityType,
                                                        CUdevice device) {
    return guarded("cuDeviceGetExecAffinitySupport", Needs::kInit, [&] {
        require(supported, "supported is null");
        requireDevice(device);
        *supported = 0; // part of the multi-process service
    });
}

// There is nothing to reset: no stream or kernel can make lines persist.
SUNSTONE_EXPORT CUresult cuCtxResetPersistingL2Cache(void) {
    return guarded("cuCtxResetPersistingL2Cache", Needs::kContext, [] {});
}
