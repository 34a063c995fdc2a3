// SPDX-License-Identifier: Apache-2.0
// The memory checker of `sunstone run --check`: which addresses a thread of device code may access,
// and the reports on those it may not. Code compiled for it (compiler/passes/check_accesses.h) asks before
// each access; launches bring what only they know of the thread (Scene).
//
// Allowed are allocations of the API (device, managed, pinned, registered, variables of modules),
// what device code allocated, the block's shared memory, the parameters, and the thread's own
// stack, where local variables are. The process's other memory is what a GPU does not reach, and so
// an error, unless SUNSTONE_CHECK has "host". Accesses must be aligned to their size.
//
// A place in the code is reported once, however often and for however many threads it fails. Text
// goes to the standard error stream; with SUNSTONE_CHECK_REPORT also one JSON object a line to that
// file: {"event": "start" | "access" | "leak" | "summary", ...}.
#pragma once

#include "devlib/abi.h"

#include <cstdint>
#include <string>

namespace sunstone::check {

struct Range {
    uint64_t begin = 0, end = 0;
    bool holds(uint64_t address, uint64_t bytes) const {
        return address >= begin && address <= end && bytes <= end - address;
    }
};

// One thread of a kernel, or one launch index.
struct Scene {
    const char* kernel = nullptr;           // null: programs of a ray tracing pipeline
    uint32_t block[3] = {}, thread[3] = {}; // a launch index is in `thread`
    Range shared, params, stack;
};

enum class Fault { kNone, kAddress, kAlignment, kShared };

bool enabled();

// Says once that this process is checked, so that nobody takes silence for health: `sunstone run`
// warns of programs that never came here. Called by the first use of a device.
void start();

// What is wrong with an access, having reported it.
Fault examine(const devlib::CheckedAccess& access, const Scene& scene);

// The calling thread's stack from the caller's frames up.
Range stackOfThread();

} // namespace sunstone::check
