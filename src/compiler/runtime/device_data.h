// SPDX-License-Identifier: Apache-2.0
// Memory of device code that is no allocation of the API: variables of loaded code, and what
// device code allocated itself (known only while the memory checker is on). See inDeviceData.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone::compiler {

// library: what the data belongs to, for its removal.
void addLoadedData(const void* library, uint64_t begin, uint64_t bytes);
void removeLoadedData(const void* library);

void addDeviceBlock(const void* memory, size_t bytes);
bool removeDeviceBlock(const void* memory); // false if it is no such block

} // namespace sunstone::compiler
