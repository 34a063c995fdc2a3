// SPDX-License-Identifier: Apache-2.0
// Random numbers in device code: XORWOW, Philox 4x32-10, MRG32k3a, Sobol and scrambled Sobol of 32
// and 64 bits, each with uniform, normal, log-normal and Poisson numbers. Integers and uniform
// numbers have the bits of CUDA's own header. Normal numbers differ by rounding. Poisson numbers
// have the same distribution but other values. Unsupported: MTGP32, discrete distributions and the
// host library.
#ifndef SUNSTONE_CURAND_KERNEL_H
#define SUNSTONE_CURAND_KERNEL_H

#include "sunstone/random_distributions.h"

#endif
