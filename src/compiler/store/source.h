// SPDX-License-Identifier: Apache-2.0
// The text of a module. Its digest stands for it in the keys of what is kept of it; its tree is made
// when somebody needs it, which is nobody where everything asked of the module was kept.
#pragma once

#include "ptx/ast.h"

#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace sunstone::compiler {

// Any thread may call.
class Source {
public:
    // Of a text that is known to be right, up to its first NUL.
    explicit Source(std::string_view text);
    // Of one that has been parsed.
    explicit Source(std::shared_ptr<const ptx::Module> tree);
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;

    // 16 bytes.
    const std::string& digest() const { return digest_; }
    // Parses at the first call. Throws Error(kInvalidPtx) where the text is not right after all.
    const ptx::Module& tree() const;
    // Whether it has been made; not while another thread may be making it.
    bool isParsed() const { return tree_ != nullptr; }

private:
    std::string digest_;
    mutable std::once_flag parsed_;
    mutable std::string text_; // until it is parsed
    mutable std::shared_ptr<const ptx::Module> tree_;
};

} // namespace sunstone::compiler
