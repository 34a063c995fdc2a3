// SPDX-License-Identifier: Apache-2.0
// The path of nvtx3/nvToolsExtCuda.h before NVTX 3.
#ifndef SUNSTONE_TOP_NVTOOLSEXTCUDA_H
#define SUNSTONE_TOP_NVTOOLSEXTCUDA_H

#include "nvtx3/nvToolsExtCuda.h"

#endif
