// SPDX-License-Identifier: Apache-2.0
// Where in device memory acceleration structures have been put, by any context of this process.
// Code with debug exceptions asks before it looks at a handle, because a GPU's kernel cannot find
// out whether there is memory at an address, and a fault would end the CUDA context.
#pragma once

#include <cstdint>
#include <vector>

namespace sunstone::engine {

// A structure was built, compacted or relocated to this address.
void noteGpuStructure(uint64_t address);

// The addresses whose memory is still allocated in the current CUDA context, in order.
std::vector<uint64_t> liveGpuStructures();

} // namespace sunstone::engine
