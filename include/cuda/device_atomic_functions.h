// SPDX-License-Identifier: Apache-2.0
// The declarations come with cuda_runtime.h.
#ifndef SUNSTONE_DEVICE_ATOMIC_FUNCTIONS_H
#define SUNSTONE_DEVICE_ATOMIC_FUNCTIONS_H

#include "cuda_runtime.h"

#endif
