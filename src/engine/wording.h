// SPDX-License-Identifier: Apache-2.0
// Names of API objects in engine messages: each API generation has its own. The shell passes its
// wording to the contexts that it makes; all members are set and live as long as the process.
#pragma once

#include "devlib/abi.h"

#include <cstdint>
#include <string>

namespace sunstone::engine {

struct Wording {
    // The name of an exception of the run-time (devlib::ExceptionCode); null: the engine's own.
    const char* (*exceptionName)(int32_t code);
    const char* wideRecordOffset; // a ray has a record offset or stride above 15
    const char* excludedGraph;    // a ray met a graph that the pipeline's flags exclude
    const char* excludedMotion;   // a ray without a time met a moving object
    std::string (*deepGraph)(unsigned declared); // a graph has more levels than declared
    std::string (*deepTrace)(unsigned limit);    // a ray was traced below the limit of depth
    // A record (devlib::recordNote) is outside its table, or its header is wrong.
    std::string (*missingRecord)(uint64_t note, const devlib::SbtView& sbt);
    const char* packedBy; // the function that packs headers: "... has no header packed by X"
};

// For contexts without a shell, as tests make them.
const Wording& plainWording();

} // namespace sunstone::engine
