// SPDX-License-Identifier: Apache-2.0
// The mathematical functions come with cuda_runtime.h.
#ifndef SUNSTONE_MATH_FUNCTIONS_H
#define SUNSTONE_MATH_FUNCTIONS_H

#include "cuda_runtime.h"

#endif
