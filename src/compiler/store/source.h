// SPDX-License-Identifier: Apache-2.0
// The text of a module. Its digest stands for it in the keys of stored results. The tree is made at
// first use; it is never made if all results are in the store.
#pragma once

#include "ptx/ast.h"

#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace sunstone::compiler {

// Thread-safe.
class Source {
public:
    // For a text known to be valid, up to its first NUL.
    explicit Source(std::string_view text);
    // For a text that has been parsed.
    explicit Source(std::shared_ptr<const ptx::Module> tree);
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;

    // 16 bytes.
    const std::string& digest() const { return digest_; }
    // Parses at the first call. Throws Error(kInvalidPtx) if the text is invalid after all.
    const ptx::Module& tree() const;
    // Whether the tree has been made. Not safe while another thread may be making it.
    bool isParsed() const { return tree_ != nullptr; }

private:
    std::string digest_;
    mutable std::once_flag parsed_;
    mutable std::string text_; // empty after parsing
    mutable std::shared_ptr<const ptx::Module> tree_;
};

} // namespace sunstone::compiler
