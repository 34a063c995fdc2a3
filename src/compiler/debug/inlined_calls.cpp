// SPDX-License-Identifier: Apache-2.0
// See inlined_calls.h.
#include "compiler/debug/inlined_calls.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>

namespace sunstone::compiler {
namespace {

// The words of a directive, without commas.
class Words {
public:
    explicit Words(std::string_view line) : rest_(line) {}

    std::string_view next() {
        const size_t begin = rest_.find_first_not_of(" \t\r,");
        rest_.remove_prefix(std::min(begin, rest_.size()));
        const size_t end = std::min(rest_.find_first_of(" \t\r,"), rest_.size());
        const std::string_view word = rest_.substr(0, end);
        rest_.remove_prefix(end);
        return word;
    }
    uint32_t number() {
        const std::string_view word = next();
        uint32_t value = 0;
        std::from_chars(word.data(), word.data() + word.size(), value);
        return value;
    }
    ptx::SourcePosition place() {
        ptx::SourcePosition at;
        at.file = number();
        at.line = number();
        at.column = number();
        return at;
    }

private:
    std::string_view rest_;
};

using Place = std::array<uint32_t, 3>;
Place keyOf(const ptx::SourcePosition& at) {
    return {at.file, at.line, at.column};
}

constexpr uint32_t kMostDepth = 64; // deeper than any compiler inlines

} // namespace

InlinedCalls::InlinedCalls(const ptx::Module& module) {
    const std::string_view text = module.text;
    if (text.find("inlined_at") == text.npos)
        return;
    std::map<Place, uint32_t> places; // the call of each .loc directive of the function
    std::map<std::pair<std::string_view, std::array<uint64_t, 5>>, uint32_t> known;
    uint32_t number = 1;
    for (size_t at = 0; at < text.size(); ++number) {
        const size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = text.substr(at, end - at);
        at = end + 1;
        if (line.find(".entry") != line.npos || line.find(".func") != line.npos)
            places.clear();
        Words words(line);
        if (words.next() != ".loc")
            continue;
        const ptx::SourcePosition here = words.place();
        InlinedCall call;
        bool isInlined = false;
        for (std::string_view word = words.next(); !word.empty() && !isInlined;
             word = words.next()) {
            if (word == "function_name") {
                call.name = words.next();
                if (const size_t plus = call.name.find('+'); plus != call.name.npos) {
                    const std::string_view offset = call.name.substr(plus + 1);
                    std::from_chars(offset.data(), offset.data() + offset.size(), call.nameOffset);
                    call.name = call.name.substr(0, plus);
                }
            } else if (word == "inlined_at") {
                call.at = words.place();
                isInlined = true;
            }
        }
        uint32_t found = 0;
        if (isInlined) {
            if (const auto outer = places.find(keyOf(call.at)); outer != places.end())
                call.within = outer->second;
            if (call.within != 0)
                call.depth = calls_[call.within - 1].depth + 1;
            uint32_t& known_ = known[{call.name,
                                      {call.nameOffset, call.at.file, call.at.line, call.at.column,
                                       call.within}}];
            if (known_ == 0 && call.depth <= kMostDepth) {
                calls_.push_back(call);
                known_ = uint32_t(calls_.size());
            }
            found = known_ ? known_ : call.within;
        }
        places[keyOf(here)] = found;
        lines_.emplace_back(number, found);
    }
}

uint32_t InlinedCalls::at(uint32_t textLine) const {
    const auto after =
        std::upper_bound(lines_.begin(), lines_.end(), std::make_pair(textLine, ~0u));
    return after == lines_.begin() ? 0 : std::prev(after)->second;
}

} // namespace sunstone::compiler
