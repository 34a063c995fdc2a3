// SPDX-License-Identifier: Apache-2.0
// The device functions come with cuda_runtime.h.
#ifndef SUNSTONE_DEVICE_FUNCTIONS_H
#define SUNSTONE_DEVICE_FUNCTIONS_H

#include "cuda_runtime.h"

#endif
