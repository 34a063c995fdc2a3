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

// From now on faults of this process are reported, then end it as before.
void tellFaults();

// From now on a test that takes more seconds than the variable SUNSTONE_TEST_LIMIT of the
// environment says is reported like a fault, and the process ends with the status of timeout(1).
void limitTests();
constexpr int kTestHangs = 124;

// The running test deliberately loses the context on a GPU.
void mayLoseContext();

// From now on `isLost` is called after each test: whether the context is lost.
void endWithContext(bool (*isLost)());

} // namespace tests::api
