// SPDX-License-Identifier: Apache-2.0
// Looks before the leap: whether memory can be read.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone {

// Whether [address, address + size) is mapped and readable. Never faults; costs a system call.
bool isReadable(const void* address, size_t size);

// Answers may be remembered by a thread while one piece of work lasts (a build, a launch): what could
// be read before it may be gone. Each piece begins a new epoch; work that runs meanwhile only asks
// anew.
void beginReadableEpoch();
uint64_t readableEpoch();

// The same for things that tend to lie side by side: remembers the page of the last answer.
bool isReadableNearby(const void* address, size_t size);

} // namespace sunstone
