// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API under its former namespace, optixu. Source: OptiX API
// reference 6.0, section 8.26.
#ifndef SUNSTONE_OPTIXU_OPTIXPP_H
#define SUNSTONE_OPTIXU_OPTIXPP_H

#include "optixpp_namespace.h"

namespace optixu {
using namespace optix;
}

#endif
