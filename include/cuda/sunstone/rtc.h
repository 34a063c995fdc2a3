// SPDX-License-Identifier: Apache-2.0
// Names that NVRTC predefines, beyond cuda_runtime.h: assert and the conditions of <nv/target>.
#ifndef SUNSTONE_RTC_H
#define SUNSTONE_RTC_H

#include "target.h"

#include <assert.h>

// No host code of the source reads the variable.
#undef __managed__
#define __managed__ __attribute__((device))

#endif
