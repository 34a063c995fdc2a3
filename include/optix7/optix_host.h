// SPDX-License-Identifier: Apache-2.0
// Host functions under their version-independent header name. Read next: optix_7_host.h.
// optix_types.h explains the two macros. Source: OptiX API reference 7.4, section 6.12.
#ifndef SUNSTONE_OPTIX7_OPTIX_HOST_H
#define SUNSTONE_OPTIX7_OPTIX_HOST_H

#ifndef __OPTIX_INCLUDE_INTERNAL_HEADERS__
#define __OPTIX_INCLUDE_INTERNAL_HEADERS__
#define __UNDEF_OPTIX_INCLUDE_INTERNAL_HEADERS_OPTIX_HOST_H__
#endif

#include "optix_7_host.h"

#ifdef __UNDEF_OPTIX_INCLUDE_INTERNAL_HEADERS_OPTIX_HOST_H__
#undef __OPTIX_INCLUDE_INTERNAL_HEADERS__
#undef __UNDEF_OPTIX_INCLUDE_INTERNAL_HEADERS_OPTIX_HOST_H__
#endif

#endif
