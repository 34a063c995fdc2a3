// SPDX-License-Identifier: Apache-2.0
// The path of nvtx3/nvToolsExtCudaRt.h before NVTX 3.
#ifndef SUNSTONE_TOP_NVTOOLSEXTCUDART_H
#define SUNSTONE_TOP_NVTOOLSEXTCUDART_H

#include "nvtx3/nvToolsExtCudaRt.h"

#endif
