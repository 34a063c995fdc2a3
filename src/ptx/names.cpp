// SPDX-License-Identifier: Apache-2.0
// The table of names. See names.h.
#include "ptx/names.h"

#include <cstring>

namespace sunstone::ptx {
namespace {

constexpr uint64_t kMultiplier = 0x9E3779B97F4A7C15ull;

uint64_t mix(uint64_t hash, uint64_t word) {
    hash = (hash ^ word) * kMultiplier;
    return hash ^ (hash >> 29);
}

uint64_t hashOf(std::string_view text) {
    uint64_t hash = text.size() * kMultiplier;
    size_t i = 0;
    for (; i + 8 <= text.size(); i += 8) {
        uint64_t word;
        std::memcpy(&word, text.data() + i, 8);
        hash = mix(hash, word);
    }
    uint64_t word = 0;
    if (i != text.size())
        std::memcpy(&word, text.data() + i, text.size() - i);
    return mix(mix(hash, word), hash >> 32);
}

} // namespace

NameId Names::intern(std::string_view text) {
    const uint64_t hash = hashOf(text);
    for (size_t slot = hash & (slots_.size() - 1);; slot = (slot + 1) & (slots_.size() - 1)) {
        const NameId name = slots_[slot];
        if (name == kEmpty) {
            const NameId added = static_cast<NameId>(texts_.size());
            slots_[slot] = added;
            texts_.push_back(text);
            hashes_.push_back(hash);
            if (texts_.size() * 2 > slots_.size())
                grow();
            return added;
        }
        if (hashes_[name] == hash && texts_[name] == text)
            return name;
    }
}

void Names::grow() {
    slots_.assign(slots_.size() * 2, kEmpty);
    for (NameId name = 0; name < texts_.size(); ++name) {
        size_t slot = hashes_[name] & (slots_.size() - 1);
        while (slots_[slot] != kEmpty)
            slot = (slot + 1) & (slots_.size() - 1);
        slots_[slot] = name;
    }
}

} // namespace sunstone::ptx
