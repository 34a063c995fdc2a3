// SPDX-License-Identifier: Apache-2.0
// Checks whether memory can be read before it is accessed.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone {

// Whether [address, address + size) is mapped and readable. Never faults; costs a system call.
bool isReadable(const void* address, size_t size);

// Starts a new epoch, in which no page is remembered, because memory may have been unmapped since
// the last one. Call it at the start of each piece of work (a build, a launch).
void beginReadableEpoch();
uint64_t readableEpoch();

// Like isReadable, for many addresses on few pages: pages that some thread found readable in the
// present epoch are remembered.
bool isReadableNearby(const void* address, size_t size);

// Remembers the pages of these addresses that are readable, for isReadableNearby. One system call
// looks at many pages, so this is faster if most addresses lie on pages of their own.
void rememberReadable(const uint64_t* addresses, size_t count);

} // namespace sunstone
