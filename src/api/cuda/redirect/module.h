// SPDX-License-Identifier: Apache-2.0
// Redirection of one loaded file, before it is relocated and its constructors run.
#pragma once

#include "api/cuda/redirect/entries.h"

namespace sunstone::redirect {

struct LoadedFile {
    const char* path;
    uintptr_t base;    // added to the addresses in the file
    uintptr_t dynamic; // where its dynamic section is in memory
};

// If the file has a static runtime with a symbol table, each of the runtime's public functions
// jumps to ours from now on. Null for other files.
Entries* redirectModule(const LoadedFile& file);

} // namespace sunstone::redirect
