// SPDX-License-Identifier: Apache-2.0
// The formats of textures that OpenGL may share with this API, a documentation header without
// declarations: R, RG and RGBA with 8I, 8UI, 16I, 16UI, 32I, 32UI and 32F, and RGBA8 and RGBA16.
// Source: OptiX API reference 6.0, sections 5.37 to 5.39.
#ifndef SUNSTONE_OPTIX6_INTEROP_TYPES_H
#define SUNSTONE_OPTIX6_INTEROP_TYPES_H
#endif
