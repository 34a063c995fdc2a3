// SPDX-License-Identifier: Apache-2.0
// The whole run-time of device programs on GPUs: compiled by the build to LLVM bitcode for nvptx64,
// which the compiler links into each pipeline's module and optimises together with the programs.
// Read: programs.h, then run.h, loop.h, nested.h, trace.h, exceptions.h.
#include "devlib/gpu/footprint.h"
#include "devlib/gpu/getters.h"
#include "devlib/gpu/loop.h"
#include "devlib/gpu/nested.h"
#include "devlib/gpu/run.h"
#include "devlib/gpu/services.h"
#include "devlib/gpu/trace.h"
