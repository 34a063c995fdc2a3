// SPDX-License-Identifier: Apache-2.0
// Looks before the leap: whether memory can be read.
#pragma once

#include <cstddef>

namespace sunstone {

// Whether [address, address + size) is mapped and readable. Never faults; costs a system call.
bool isReadable(const void* address, size_t size);

} // namespace sunstone
