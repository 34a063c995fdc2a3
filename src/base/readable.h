// SPDX-License-Identifier: Apache-2.0
// Checks whether memory can be read before it is accessed.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone {

// Whether [address, address + size) is mapped and readable. Never faults; costs a system call.
bool isReadable(const void* address, size_t size);

// Starts a new epoch, which invalidates the results that threads remember, because memory may have
// been unmapped since. Call it at the start of each piece of work (a build, a launch).
void beginReadableEpoch();
uint64_t readableEpoch();

// Like isReadable, for many addresses on few pages: each thread remembers pages that it found
// readable in the present epoch.
bool isReadableNearby(const void* address, size_t size);

} // namespace sunstone
