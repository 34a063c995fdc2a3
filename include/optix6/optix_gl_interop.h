// SPDX-License-Identifier: Apache-2.0
// Buffers and textures that share memory with objects of OpenGL, for the host. A registered object
// belongs to this API; OpenGL may change it while it is unregistered. Source: OptiX API reference
// 6.0, sections 5.14, 5.15, 5.38, 8.16.
#ifndef SUNSTONE_OPTIX6_GL_INTEROP_H
#define SUNSTONE_OPTIX6_GL_INTEROP_H

#include "optix_host.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A GPU handle of WGL_NV_gpu_affinity. */
typedef void* HGPUNV;

RTresult RTAPI rtBufferCreateFromGLBO(RTcontext context, unsigned int bufferdesc, unsigned int glId,
                                      RTbuffer* buffer);
RTresult RTAPI rtTextureSamplerCreateFromGLImage(RTcontext context, unsigned int glId,
                                                 RTgltarget target,
                                                 RTtexturesampler* textureSampler);
RTresult RTAPI rtBufferGetGLBOId(RTbuffer buffer, unsigned int* glId);
RTresult RTAPI rtTextureSamplerGetGLImageId(RTtexturesampler textureSampler, unsigned int* glId);
RTresult RTAPI rtBufferGLRegister(RTbuffer buffer);
RTresult RTAPI rtBufferGLUnregister(RTbuffer buffer);
RTresult RTAPI rtTextureSamplerGLRegister(RTtexturesampler textureSampler);
RTresult RTAPI rtTextureSamplerGLUnregister(RTtexturesampler textureSampler);
/* Windows only. */
RTresult RTAPI rtDeviceGetWGLDevice(int* device, HGPUNV gpu);

#ifdef __cplusplus
}
#endif

#endif
