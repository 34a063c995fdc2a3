// SPDX-License-Identifier: Apache-2.0
// ../../optix7/internal/optix_7_device_impl.h, read as OptiX 7.6.
#include "optix_76_api.h"

#include "../../optix7/internal/optix_7_device_impl.h"
