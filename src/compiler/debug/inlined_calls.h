// SPDX-License-Identifier: Apache-2.0
// Calls that the compiler which wrote the PTX replaced by the function's code, as .loc directives tell:
//
//   .loc FILE LINE COLUMN, function_name LABEL[+OFFSET], inlined_at FILE LINE COLUMN
//
// The label is that of the function's name in .debug_str; inlined_at is where the call was, a place
// that an earlier .loc of the PTX function has named and that may be inlined itself. The parser
// checks the form of the directives and keeps places only, so this reads the text once more, for
// those who want debug information.
// Source: PTX ISA, "Debugging Directives: .loc".
#pragma once

#include "ptx/ast.h"

#include <string_view>
#include <utility>
#include <vector>

namespace sunstone::compiler {

struct InlinedCall {
    std::string_view name; // label of the function's name; empty: not given
    uint64_t nameOffset = 0;
    ptx::SourcePosition at; // of the call
    uint32_t within = 0;    // number of the inlined call that has this place; 0: none
    uint32_t depth = 1;
};

class InlinedCalls {
public:
    InlinedCalls() = default;
    explicit InlinedCalls(const ptx::Module& module);

    // Number, from 1, of the call that the code on a line of the PTX text is of; 0: of none.
    uint32_t at(uint32_t textLine) const;
    const InlinedCall& call(uint32_t number) const { return calls_[number - 1]; }

private:
    std::vector<InlinedCall> calls_;
    std::vector<std::pair<uint32_t, uint32_t>> lines_; // of .loc: line, number; rising
};

} // namespace sunstone::compiler
