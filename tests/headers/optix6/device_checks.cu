// SPDX-License-Identifier: Apache-2.0
// Compiles if the device headers of the classic API agree with symbols.tsv.
#include <optix_world.h>

#include "device_checks.inc"
