// SPDX-License-Identifier: Apache-2.0
// Makes the headers of ../optix7 that are included after this one those of OptiX 7.6.
#ifndef SUNSTONE_OPTIX_API
#define SUNSTONE_OPTIX_API 70600
#elif SUNSTONE_OPTIX_API != 70600
#error "headers of OptiX 7.4 and OptiX 7.6 meet in one source file; use one include folder"
#endif
