// SPDX-License-Identifier: Apache-2.0
// The declarations come with driver_types.h.
#ifndef SUNSTONE_BUILTIN_TYPES_H
#define SUNSTONE_BUILTIN_TYPES_H

#include "driver_types.h"

#endif
