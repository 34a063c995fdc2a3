// SPDX-License-Identifier: Apache-2.0
// The options of nvrtcCompileProgram.
#pragma once

#include <string>
#include <vector>

namespace sunstone::nvrtc {

// The CUDA version of this library.
#ifdef SUNSTONE_NVRTC_12
constexpr int kMajor = 12, kMinor = 9;
#else
constexpr int kMajor = 13, kMinor = 0;
#endif

struct Options {
    int architecture = 0; // 75 for compute_75 and sm_75
    bool isReal = false;  // sm_75: the program asks for an image to load
    bool debug = false, lineInfo = false, relocatable = false;
    bool flush = false, contract = true, preciseDivision = true, preciseRoots = true;
    bool fastFunctions = false;
    bool int128 = false; // requested; clang always has the type
    bool quiet = false, defaultDevice = false, sourceFolder = true, syntaxOnly = false;
    std::string standard = "c++17";
    std::vector<std::string> preprocessor; // clang's, in order

    std::vector<std::string> errors, remarks; // of the options, for the program's log
};

// Options that clang has no counterpart for and that change no result are accepted.
Options parseOptions(const std::vector<std::string>& words, int defaultArchitecture);

// The architectures that clang supports, ascending.
const std::vector<int>& architectures();

// Definitions (-D...) of the macros that NVRTC predefines.
std::vector<std::string> predefinedMacros(const Options& options);

// The arguments of clang for these options, without files.
std::vector<std::string> clangArguments(const Options& options);

} // namespace sunstone::nvrtc
