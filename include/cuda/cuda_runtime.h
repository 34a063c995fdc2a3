// SPDX-License-Identifier: Apache-2.0
// The header for CUDA sources: vector types, the runtime API, and, in a CUDA compilation, the
// device built-ins. Compilers force-include it for .cu files; README.md has the flags.
#ifndef SUNSTONE_CUDA_RUNTIME_H
#define SUNSTONE_CUDA_RUNTIME_H
#ifndef __CUDA_RUNTIME_H__
#define __CUDA_RUNTIME_H__ // disables a toolkit's header
#endif

#include "host_defines.h"

// Language extensions of clang, without those of nvcc. Our nvcc is clang and also defines __NVCC__.
#if defined(__CUDA__)
#ifndef __CUDACC__
#define __CUDACC__ 1
#endif
#define SUNSTONE_CUDA_COMPILATION
// Before any standard header: see sunstone/math.h.
#include <stddef.h>
#include "sunstone/builtin_variables.h"
#include "sunstone/intrinsics.h"
#include "sunstone/cached_loads.h"
#include "sunstone/math.h"
#include "sunstone/special_functions.h"
#include <cmath>
#include <math.h>
#include "sunstone/library.h"
#ifdef __cplusplus
#include <new> // with clang: operator new and delete of device code, on malloc and free
#ifndef __CUDACC_RTC__
#include <utility> // as in the toolkit's header: loops over braced lists rely on it
#endif
#endif
#include "sunstone/warp.h"
#include "sunstone/simd.h"
#include "sunstone/atomics.h"
#endif

#include "vector_types.h"
#include "vector_functions.h"
#include "driver_types.h"
#include "cuda_runtime_api.h"
#include "channel_descriptor.h"
#include "sunstone/runtime_templates.h"
#ifdef SUNSTONE_CUDA_COMPILATION
#include "sunstone/textures.h"
#endif

#endif
