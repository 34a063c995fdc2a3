// SPDX-License-Identifier: Apache-2.0
// cudaProfilerStart and cudaProfilerStop are declared with the runtime API.
#ifndef SUNSTONE_CUDA_PROFILER_API_H
#define SUNSTONE_CUDA_PROFILER_API_H

#include "cuda_runtime_api.h"

#endif
