// SPDX-License-Identifier: Apache-2.0
// Calls that were inlined before the PTX was written, from .loc directives:
//
//   .loc FILE LINE COLUMN, function_name LABEL[+OFFSET], inlined_at FILE LINE COLUMN
//
// The label is that of the function's name in .debug_str. inlined_at is the place of the call,
// which an earlier .loc of the PTX function has named and which may be inlined itself. The parser
// checks the form of the directives and keeps only places, so this class parses the text again if
// debug information is needed. Source: PTX ISA, "Debugging Directives: .loc".
#pragma once

#include "ptx/ast.h"

#include <string_view>
#include <utility>
#include <vector>

namespace sunstone::compiler {

struct InlinedCall {
    std::string_view name; // label of the function's name; empty: missing
    uint64_t nameOffset = 0;
    ptx::SourcePosition at; // of the call
    uint32_t within = 0;    // number of the enclosing inlined call; 0: none
    uint32_t depth = 1;
};

class InlinedCalls {
public:
    InlinedCalls() = default;
    explicit InlinedCalls(const ptx::Module& module);

    // The number, from 1, of the inlined call that contains the code on a line of the PTX text; 0:
    // none.
    uint32_t at(uint32_t textLine) const;
    const InlinedCall& call(uint32_t number) const { return calls_[number - 1]; }

private:
    std::vector<InlinedCall> calls_;
    std::vector<std::pair<uint32_t, uint32_t>> lines_; // of .loc: line, number; rising
};

} // namespace sunstone::compiler
