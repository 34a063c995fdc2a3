// SPDX-License-Identifier: Apache-2.0
// Selects OptiX 7.6 for the headers of ../optix7 included after this one.
#ifndef SUNSTONE_OPTIX_API
#define SUNSTONE_OPTIX_API 70600
#elif SUNSTONE_OPTIX_API != 70600
#error "headers of OptiX 7.4 and OptiX 7.6 meet in one source file; use one include folder"
#endif
