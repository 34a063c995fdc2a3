// SPDX-License-Identifier: Apache-2.0
// Changes PTX token by token, so that much of it still parses.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace fuzz {

using Tokens = std::vector<std::string>;

inline bool isWordPart(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '%' || c == '$';
}
inline bool isSpace(const std::string& token) {
    return std::isspace(static_cast<unsigned char>(token[0]));
}
inline bool isNumber(const std::string& token) {
    return std::isdigit(static_cast<unsigned char>(token[0]));
}

// Tokens are words, modifiers with their point, runs of space, and single other characters.
inline Tokens tokensOf(const std::string& text) {
    Tokens tokens;
    for (size_t begin = 0; begin < text.size();) {
        size_t end = begin + 1;
        const bool isModifier = text[begin] == '.' && end < text.size() && isWordPart(text[end]);
        if (isWordPart(text[begin]) || isModifier)
            end = size_t(std::find_if_not(text.begin() + ptrdiff_t(end), text.end(), isWordPart) -
                         text.begin());
        else if (std::isspace(static_cast<unsigned char>(text[begin])))
            while (end < text.size() && std::isspace(static_cast<unsigned char>(text[end])))
                ++end;
        tokens.push_back(text.substr(begin, end - begin));
        begin = end;
    }
    return tokens;
}
inline std::string textOf(const Tokens& tokens) {
    std::string text;
    for (const std::string& token : tokens)
        text += token;
    return text;
}

class PtxChanges {
public:
    // New words come from these texts. `below` returns random numbers below its argument.
    PtxChanges(const std::vector<Tokens>& seeds, std::function<size_t(size_t)> below)
        : below(std::move(below)) {
        for (const Tokens& tokens : seeds)
            for (const std::string& token : tokens)
                if (token[0] == '.' || isWordPart(token[0]))
                    pool_.push_back(token);
        for (const char* rare : {"0", "-1", "64", "4294967296", "0xffffffffffffffff", "0f7F800000",
                                 "0d7FF8000000000000", "%envreg1", "1000000000"})
            pool_.insert(pool_.end(), 20, rare);
    }

    Tokens changed(Tokens tokens) const {
        for (size_t edits = 1 + below(4); edits > 0; --edits) {
            size_t at = below(tokens.size());
            for (int tries = 0; tries < 50 && isSpace(tokens[at]); ++tries)
                at = below(tokens.size());
            change(tokens, at);
        }
        return tokens;
    }

private:
    void change(Tokens& tokens, size_t at) const {
        const auto place = [&](size_t index) { return tokens.begin() + ptrdiff_t(index); };
        std::string& token = tokens[at];
        const std::string other = tokens[below(tokens.size())];
        switch (below(7)) {
        case 0:
        case 1:
        case 2: // another of its kind
            for (int tries = 0; tries < 200; ++tries) {
                const std::string& found = pool_[below(pool_.size())];
                if ((found[0] == '.') == (token[0] == '.') && isNumber(found) == isNumber(token)) {
                    token = found;
                    return;
                }
            }
            return;
        case 3:
            tokens.erase(place(at));
            return;
        case 4:
            tokens.insert(place(at), other);
            return;
        case 5:
            token = other;
            return;
        default:
            break;
        }
        // Removes a statement, or copies one to another place.
        size_t begin = at, end = at;
        while (begin > 0 && tokens[begin - 1] != ";")
            --begin;
        while (end < tokens.size() && tokens[end] != ";")
            ++end;
        if (end == tokens.size())
            return;
        const Tokens statement(place(begin), place(end + 1));
        if (below(2)) {
            tokens.erase(place(begin), place(end + 1));
            return;
        }
        size_t to = below(tokens.size());
        while (to < tokens.size() && tokens[to] != ";")
            ++to;
        if (to < tokens.size())
            tokens.insert(place(to + 1), statement.begin(), statement.end());
    }

    std::function<size_t(size_t)> below;
    Tokens pool_;
};

} // namespace fuzz
