// SPDX-License-Identifier: Apache-2.0
// The run-time of runtime.cpp for programs of the classic API.
#define SUNSTONE_RECORDS ClassicRecords
#include "devlib/gpu/classic.h"
#include "devlib/gpu/runtime.cpp"
