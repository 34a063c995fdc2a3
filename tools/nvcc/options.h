// SPDX-License-Identifier: Apache-2.0
// The command line of nvcc.
#pragma once

#include "api/nvrtc/options.h"

#include <string>
#include <vector>

namespace sunstone::nvcc {

enum class Phase {
    kLink,
    kCompile,      // -c, -dc
    kPtx,          // -ptx
    kFatBinary,    // -fatbin, -cubin
    kPreprocess,   // -E
    kDependencies, // -M, -MM
    kDeviceLink,   // -dlink
    kArchive,      // -lib
};

struct CommandLine {
    Phase phase = Phase::kLink;
    nvrtc::Options device;
    int architecture = 0;             // of -arch; 0: not given
    std::vector<int> architectures;   // rising, also that of -arch; PTX for each
    std::vector<std::string> sources; // files to compile
    std::vector<std::string> linked; // objects, archives, -L, -l and words for the linker, in order
    std::vector<std::string> common; // words of the preprocessor, for both sides
    std::vector<std::string> host;   // words for the host's compilation
    std::vector<std::string> dependency; // -MD and its like
    std::string output, language;
    std::string runtime = "static";
    bool isShared = false, perThread = false;
    bool isVerbose = false, isDry = false;
    bool showsVersion = false, showsHelp = false, showsArchitectures = false;
};

// Throws std::runtime_error with nvcc's kind of message.
CommandLine parse(std::vector<std::string> words);

} // namespace sunstone::nvcc
