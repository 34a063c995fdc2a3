// SPDX-License-Identifier: Apache-2.0
// Maps names of a PTX text to small numbers, so that each name is hashed once and the parser's
// tables are indexed by number.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace sunstone::ptx {

using NameId = uint32_t;

class Names {
public:
    Names() : slots_(1024, kEmpty) {}

    // The number of `text`, which must outlive this object. A new name gets the next number.
    NameId intern(std::string_view text);
    std::string_view text(NameId name) const { return texts_[name]; }
    size_t size() const { return texts_.size(); }

private:
    static constexpr NameId kEmpty = ~0u;
    void grow();

    std::vector<NameId> slots_; // open addressing, a power of two of them
    std::vector<std::string_view> texts_;
    std::vector<uint64_t> hashes_;
};

} // namespace sunstone::ptx
