// SPDX-License-Identifier: Apache-2.0
// Kernels do not launch kernels here; this name exists for programs that include it.
#ifndef SUNSTONE_CUDA_DEVICE_RUNTIME_API_H
#define SUNSTONE_CUDA_DEVICE_RUNTIME_API_H

#include "cuda_runtime.h"

#endif
