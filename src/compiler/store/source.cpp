// SPDX-License-Identifier: Apache-2.0
// See source.h.
#include "compiler/store/source.h"

#include "base/error.h"
#include "compiler/store/digest.h"
#include "ptx/parse/parser.h"

namespace sunstone::compiler {

namespace {

std::string digestOf(std::string_view text) {
    Digest digest;
    digest.add(text);
    return digest.take();
}

} // namespace

Source::Source(std::string_view text) : text_(text.substr(0, text.find('\0'))) {
    digest_ = digestOf(text_);
}

Source::Source(std::shared_ptr<const ptx::Module> tree)
    : digest_(digestOf(tree->text)), tree_(std::move(tree)) {}

const ptx::Module& Source::tree() const {
    std::call_once(parsed_, [&] {
        if (tree_)
            return;
        ptx::Diagnostics diagnostics;
        tree_ = ptx::parse(text_, diagnostics);
        if (!tree_)
            fail(sunstone::Code::kInvalidPtx, diagnostics.format());
        std::string().swap(text_); // the tree has a copy
    });
    return *tree_;
}

} // namespace sunstone::compiler
