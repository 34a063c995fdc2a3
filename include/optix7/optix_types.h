// SPDX-License-Identifier: Apache-2.0
// Types of the OptiX API under their version-independent header name. Read next: optix_7_types.h.
// __OPTIX_INCLUDE_INTERNAL_HEADERS__ is set while a versioned header is read through a public one;
// the second macro records that this file set it, so that a client's own definition survives.
// Source: OptiX API reference 7.4, section 6.15.
#ifndef SUNSTONE_OPTIX7_OPTIX_TYPES_H
#define SUNSTONE_OPTIX7_OPTIX_TYPES_H

#ifndef __OPTIX_INCLUDE_INTERNAL_HEADERS__
#define __OPTIX_INCLUDE_INTERNAL_HEADERS__
#define __UNDEF_OPTIX_INCLUDE_INTERNAL_HEADERS_OPTIX_TYPES_H__
#endif

#include "optix_7_types.h"

#ifdef __UNDEF_OPTIX_INCLUDE_INTERNAL_HEADERS_OPTIX_TYPES_H__
#undef __OPTIX_INCLUDE_INTERNAL_HEADERS__
#undef __UNDEF_OPTIX_INCLUDE_INTERNAL_HEADERS_OPTIX_TYPES_H__
#endif

#endif
