// SPDX-License-Identifier: Apache-2.0
// The primitives of asynchronous copies.
#ifndef SUNSTONE_CUDA_PIPELINE_H
#define SUNSTONE_CUDA_PIPELINE_H
#include "cuda_pipeline_primitives.h"
#endif
