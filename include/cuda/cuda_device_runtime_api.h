// SPDX-License-Identifier: Apache-2.0
// Kernels cannot launch kernels here; this header exists for programs that include it.
#ifndef SUNSTONE_CUDA_DEVICE_RUNTIME_API_H
#define SUNSTONE_CUDA_DEVICE_RUNTIME_API_H

#include "cuda_runtime.h"

#endif
