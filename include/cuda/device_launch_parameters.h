// SPDX-License-Identifier: Apache-2.0
// The built-in variables come with cuda_runtime.h.
#ifndef SUNSTONE_DEVICE_LAUNCH_PARAMETERS_H
#define SUNSTONE_DEVICE_LAUNCH_PARAMETERS_H
#ifndef __DEVICE_LAUNCH_PARAMETERS_H__
#define __DEVICE_LAUNCH_PARAMETERS_H__ // disables a toolkit's header
#endif

#include "cuda_runtime.h"

#endif
