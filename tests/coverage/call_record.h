// SPDX-License-Identifier: Apache-2.0
// Records of the calls that test programs make: each host function with its results, and the device
// programs (.cu files) of launched pipelines. tests/coverage/features.cpp turns the records into
// the table of docs/features.md.
//
// With the environment variable SUNSTONE_CALL_RECORD naming a folder, each test leaves one file
// there, named after the test, with lines of
//   call <function> <result, a number>
//   launched <file.cu>
//   source <file of the test>
#pragma once

#include <string>

namespace tests {

// Puts a recording function before each function of g_optixFunctionTable. Call it after optixInit;
// calling it again does no harm.
void recordCalls();

// Names the source file that PTX text was compiled from.
void recordProgram(const std::string& ptx, const std::string& sourceFile);

} // namespace tests
