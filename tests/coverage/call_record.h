// SPDX-License-Identifier: Apache-2.0
// Records the calls of test programs: each host function with its results, and the device programs
// (.cu files) of launched pipelines. tests/coverage/symbols.cpp turns the records into
// docs/symbols.md.
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
// repeated calls are harmless.
void recordCalls();

// Records the source file of a PTX text.
void recordProgram(const std::string& ptx, const std::string& sourceFile);

} // namespace tests
