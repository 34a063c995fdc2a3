// SPDX-License-Identifier: Apache-2.0
// Compiles if the host headers of the classic API agree with symbols.tsv.
#include <optix_world.h>

#include <optix_cuda_interop.h>
#include <optix_gl_interop.h>
#include <optix_prime/optix_primepp.h>
#include <optixu/optixu.h>
#include <optixu/optixu_math_stream_namespace.h>
#include <optixu/optixu_quaternion_namespace.h>

#include "host_checks.inc"
