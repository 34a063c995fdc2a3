// SPDX-License-Identifier: Apache-2.0
// Second name of optix_defines.h.
#include "optix_defines.h"
