// SPDX-License-Identifier: Apache-2.0
// The end of test processes on a GPU before their last test. A fault is reported with the running
// test and the backtrace, as file and offset (addr2line -e FILE PLACE names them). A test that
// breaks the CUDA context ends the process: later tests could not succeed, and the host must not
// access managed memory of such a context. scripts/gpu-check runs the remaining tests in another
// process.
#pragma once

namespace tests::api {

// Exit status of a process that ends because its CUDA context is lost.
constexpr int kContextLost = 70;

// After this call, faults of this process are reported before they end it.
void tellFaults();

// After this call, a test that takes more seconds than the environment variable SUNSTONE_TEST_LIMIT
// is reported like a fault, and the process ends with the status of timeout(1).
void limitTests();
constexpr int kTestHangs = 124;

// The running test deliberately loses the context on a GPU.
void mayLoseContext();

// After this call, the process ends after a test if `isLost` returns true: the context is lost.
void endWithContext(bool (*isLost)());

} // namespace tests::api
