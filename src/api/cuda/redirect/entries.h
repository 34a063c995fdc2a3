// SPDX-License-Identifier: Apache-2.0
// The new entries of redirected functions: a table within 2 GiB of the module, the range of a jump
// of five bytes. An entry jumps through its slot. Until the first call the slot leads to the
// resolver, which loads the runtime and stores the address of its function. The layout is that of a
// procedure linkage table.
#pragma once

#include "api/cuda/redirect/runtimes.h"

#include <cstdint>

namespace sunstone::redirect {

struct Entries {
    const Runtime* runtime;
    const uint16_t* names; // of each entry: index into the runtime's names
    void** slots;
    void* resolver;
    uint8_t* code;
    uint8_t* region;
    size_t regionSize;
    Entries* nextFree;
};

// A table of count entries within reach of [low, high); null if no address there is free. The
// names follow with setName.
Entries* makeEntries(const Runtime& runtime, size_t count, uintptr_t low, uintptr_t high);
void setName(Entries& entries, size_t index, uint16_t name);
uintptr_t addressOf(const Entries& entries, size_t index);
// Makes the code executable; only slots may change after that. False if the system refuses.
bool seal(Entries& entries);
// Lets a later table use the memory. Until then the code stays: at process end the loader closes
// files that the destructors of others still call.
void keepForReuse(Entries* entries);

// The address of the entry's function; called by the entry, in the thread of the program.
extern "C" void* sunstoneResolve(Entries* entries, uint64_t index);

} // namespace sunstone::redirect
