// SPDX-License-Identifier: Apache-2.0
// The path of nvtx3/nvToolsExt.h before NVTX 3.
#ifndef SUNSTONE_TOP_NVTOOLSEXT_H
#define SUNSTONE_TOP_NVTOOLSEXT_H

#include "nvtx3/nvToolsExt.h"

#endif
