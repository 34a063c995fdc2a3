// SPDX-License-Identifier: Apache-2.0
// ../optix7/optix_7_device.h, read as OptiX 7.6.
#include "internal/optix_76_api.h"

#include "../optix7/optix_7_device.h"
