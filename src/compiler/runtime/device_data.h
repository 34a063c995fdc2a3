// SPDX-License-Identifier: Apache-2.0
// Memory of device code that is not an allocation of the API: variables of loaded code, and memory
// that device code allocated (recorded only while the memory checker is on). See inDeviceData.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone::compiler {

// library: the owner of the data, for its removal.
void addLoadedData(const void* library, uint64_t begin, uint64_t bytes);
void removeLoadedData(const void* library);

void addDeviceBlock(const void* memory, size_t bytes);
bool removeDeviceBlock(const void* memory); // false if it is not such a block

} // namespace sunstone::compiler
