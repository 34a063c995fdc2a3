// SPDX-License-Identifier: Apache-2.0
// See device_data.h.
#include "compiler/runtime/device_data.h"

#include "compiler/compiler.h"

#include <map>
#include <mutex>
#include <shared_mutex>

namespace sunstone::compiler {

namespace {

struct Range {
    uint64_t bytes = 0;
    const void* library = nullptr; // null: a block that device code allocated
};

struct Ranges {
    std::shared_mutex mutex;
    std::map<uint64_t, Range> byBegin;
};

Ranges& ranges() {
    static auto* instance = new Ranges; // never destroyed: destructors may free code at exit
    return *instance;
}

} // namespace

void addLoadedData(const void* library, uint64_t begin, uint64_t bytes) {
    std::unique_lock lock(ranges().mutex);
    ranges().byBegin[begin] = {bytes, library};
}

void removeLoadedData(const void* library) {
    std::unique_lock lock(ranges().mutex);
    std::erase_if(ranges().byBegin,
                  [&](const auto& entry) { return entry.second.library == library; });
}

void addDeviceBlock(const void* memory, size_t bytes) {
    std::unique_lock lock(ranges().mutex);
    ranges().byBegin[reinterpret_cast<uint64_t>(memory)] = {bytes, nullptr};
}

bool removeDeviceBlock(const void* memory) {
    std::unique_lock lock(ranges().mutex);
    const auto found = ranges().byBegin.find(reinterpret_cast<uint64_t>(memory));
    if (found == ranges().byBegin.end() || found->second.library)
        return false;
    ranges().byBegin.erase(found);
    return true;
}

bool inDeviceData(const void* address, size_t bytes) {
    const auto begin = reinterpret_cast<uint64_t>(address);
    std::shared_lock lock(ranges().mutex);
    auto found = ranges().byBegin.upper_bound(begin);
    if (found == ranges().byBegin.begin())
        return false;
    --found;
    return begin - found->first <= found->second.bytes &&
           bytes <= found->second.bytes - (begin - found->first);
}

} // namespace sunstone::compiler
