// SPDX-License-Identifier: Apache-2.0
// The tests' device memory: memory of this process for the CPU device. With SUNSTONE_TEST_GPU in
// the environment the same tests run on a GPU: they load the driver, make its first device's
// context current, and use managed memory, which both sides can access.
#pragma once

#include <cstddef>

namespace tests::api {

// Call before the first use of the library.
void prepareDevice();
bool onGpu();
// The GPU's compute capability, 10 * major + minor, and its driver's version, 1000 * major + 10 *
// minor; 0 on the CPU.
int computeCapability();
int driverVersion();
// Call in a thread that the test has started, before the thread creates a device context.
void prepareThread();

// At least `alignment`-aligned (a power of two); throws std::bad_alloc.
void* allocateDevice(size_t size, size_t alignment);
void freeDevice(void* memory);

} // namespace tests::api
