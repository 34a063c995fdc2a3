// SPDX-License-Identifier: Apache-2.0
// The memory checker of `sunstone run --check`: decides which addresses a thread of device code may
// access, and reports invalid accesses. Compiled code calls it before each access
// (compiler/passes/check_accesses.h); a launch passes the data that is known only per thread
// (Scene).
//
// A thread may access
//   - allocations of the API: device, managed, pinned, registered, variables of modules;
//   - memory that device code allocated;
//   - the block's shared memory, and the parameters;
//   - its own stack, which holds local variables.
// Other memory of the process is an error, as a GPU cannot reach it, unless SUNSTONE_CHECK contains
// "host". Accesses must be aligned to their size.
//
// Each place in the code is reported once, for all failures and threads. Text goes to the standard
// error stream. SUNSTONE_CHECK_REPORT names a file that also receives one JSON object a line:
// {"event": "start" | "access" | "leak" | "summary", ...}.
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
    uint32_t block[3] = {}, thread[3] = {}; // pipelines: `thread` is the launch index
    Range shared, params, stack;
    // Programs of the classic API read both as variables, which have an address.
    Range launchIndex, launchDimensions;
};

enum class Fault { kNone, kAddress, kAlignment, kShared };

bool enabled();

// Reports once that this process is checked; called at the first use of a device. `sunstone run`
// warns about programs that never call it, so that missing reports are not read as success.
void start();

// Checks an access, reports a fault, and returns it.
Fault examine(const devlib::CheckedAccess& access, const Scene& scene);

// "use after free: ..." with the allocation, if the address lies in freed memory that is not reused
// yet; else empty. For faults with and without the checker.
std::string describeFreed(const void* address);

// The calling thread's stack from the caller's frames up.
Range stackOfThread();

} // namespace sunstone::check
