// SPDX-License-Identifier: Apache-2.0
// OpenGL interoperability of the runtime API, unsupported: programs compile and link, each function
// returns cudaErrorNotSupported, and the first call writes a line to stderr. Programs with a path
// through host memory then take it.
#ifndef SUNSTONE_CUDA_GL_INTEROP_H
#define SUNSTONE_CUDA_GL_INTEROP_H

#include "cuda_runtime_api.h"

// Two types are enough if OpenGL's own header is missing or included later.
#if defined(__has_include)
#if __has_include(<GL/gl.h>)
#include <GL/gl.h>
#define SUNSTONE_HAS_GL_HEADER
#endif
#endif
#if !defined(SUNSTONE_HAS_GL_HEADER)
typedef unsigned int GLenum;
typedef unsigned int GLuint;
#endif

#if defined(__cplusplus)
extern "C" {
#endif

enum cudaGLDeviceList {
    cudaGLDeviceListAll = 1,
    cudaGLDeviceListCurrentFrame = 2,
    cudaGLDeviceListNextFrame = 3
};

cudaError_t cudaGLGetDevices(unsigned int* count, int* devices, unsigned int capacity,
                             enum cudaGLDeviceList list);
cudaError_t cudaGraphicsGLRegisterImage(struct cudaGraphicsResource** resource, GLuint image,
                                        GLenum target, unsigned int flags);
cudaError_t cudaGraphicsGLRegisterBuffer(struct cudaGraphicsResource** resource, GLuint buffer,
                                         unsigned int flags);

#if defined(__cplusplus)
}
#endif

#endif
