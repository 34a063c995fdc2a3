// SPDX-License-Identifier: Apache-2.0
// The declarations come with cuda.h.
#ifndef SUNSTONE_CUDAPROFILER_H
#define SUNSTONE_CUDAPROFILER_H

#include "cuda.h"

#endif
