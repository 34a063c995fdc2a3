// SPDX-License-Identifier: Apache-2.0
// How test processes on a GPU end before their last test. A fault is told with the running test and
// the calls that led to it, as places in the files they are in (addr2line -e FILE PLACE names
// them). A test that leaves the CUDA context broken ends the process: no later test could tell
// anything, and the host must not touch managed memory of such a context. scripts/gpu-check goes on
// with the rest in another process.
#pragma once

namespace tests::api {

// Exit status of a process that ends because its CUDA context is lost.
constexpr int kContextLost = 70;

// Faults of this process are told from now on, then end it as they would have.
void tellFaults();

// The running test is about a context that is lost, as far as the GPU goes.
void mayLoseContext();

// After each test from now on `isLost` is asked whether the context is lost.
void endWithContext(bool (*isLost)());

} // namespace tests::api
