// SPDX-License-Identifier: Apache-2.0
// What test programs call, written down while they run: each host function with the results it
// gave, and the device programs (.cu files) of pipelines that were launched.
// tests/coverage/symbols.cpp turns the records into docs/symbols.md.
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
