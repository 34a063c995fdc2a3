// SPDX-License-Identifier: Apache-2.0
// The declarations come with cuda_runtime.h.
#ifndef SUNSTONE_SM_20_INTRINSICS_H
#define SUNSTONE_SM_20_INTRINSICS_H

#include "cuda_runtime.h"

#endif
