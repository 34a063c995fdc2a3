// SPDX-License-Identifier: Apache-2.0
// Memory of buffers on CUDA devices, for the host. Devices are ordinals of this API. Source: OptiX
// API reference 6.0, sections 5.14, 8.10.
#ifndef SUNSTONE_OPTIX6_CUDA_INTEROP_H
#define SUNSTONE_OPTIX6_CUDA_INTEROP_H

#include "optix_host.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The same as rtBufferCreate. */
RTresult RTAPI rtBufferCreateForCUDA(RTcontext context, unsigned int bufferdesc, RTbuffer* buffer);
/* The address of the buffer's memory on a device. */
RTresult RTAPI rtBufferGetDevicePointer(RTbuffer buffer, int optix_device_ordinal,
                                        void** device_pointer);
/* Reports that device code of the application has changed the buffer. */
RTresult RTAPI rtBufferMarkDirty(RTbuffer buffer);
/* Makes memory of the application the buffer's memory on a device. */
RTresult RTAPI rtBufferSetDevicePointer(RTbuffer buffer, int optix_device_ordinal,
                                        void* device_pointer);

#ifdef __cplusplus
}
#endif

#endif
