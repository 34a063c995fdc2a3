// SPDX-License-Identifier: Apache-2.0
// The declarations come with host_defines.h.
#ifndef SUNSTONE_HOST_CONFIG_H
#define SUNSTONE_HOST_CONFIG_H

#include "host_defines.h"

#endif
