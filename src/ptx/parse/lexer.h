// SPDX-License-Identifier: Apache-2.0
// PTX text to tokens, one at a time. A dot starts a word (".global", ".v4", ".L2::128B"), so
// "ld.global.u32" is an identifier and two dot words. Comments and white space are dropped.
#pragma once

#include "ptx/ast.h"
#include "ptx/diagnostics.h"

#include <string_view>

namespace sunstone::ptx {

enum class TokenKind : uint8_t {
    kEnd,
    kIdentifier, // text; also %r1, $L1, _
    kDotWord,    // text without the dot
    kInteger,    // bits
    kFloat32,    // bits of a 0f... literal
    kFloat64,    // bits of a 0d... or decimal literal
    kString,     // text without the quotes, escapes as written
    kPunctuation,
};

struct Token {
    TokenKind kind = TokenKind::kEnd;
    char punctuation = 0; // kPunctuation
    bool spaceBefore = false;
    std::string_view text; // the token as written (kDotWord, kString: its inside)
    uint64_t bits = 0;
    Location location;

    bool is(char c) const { return kind == TokenKind::kPunctuation && punctuation == c; }
    bool isDot(std::string_view word) const { return kind == TokenKind::kDotWord && text == word; }
    const char* end() const { return text.data() + text.size(); }
};

class Lexer {
public:
    Lexer(std::string_view text, Diagnostics& diagnostics);

    // The next token. A byte that cannot be PTX is reported and ends the text.
    Token next();
    // Rereads as a number ".5", which next() returned as a dot word.
    Token numberAt(const Token& dotWord);
    // Goes back to `token`, a recent result of next(): the following next() returns it again.
    void rewind(const Token& token);

private:
    bool skipSpace();
    void skipLine();
    Token number(Token token);
    Token string(Token token);
    Token hexFloat(Token token, unsigned digits, TokenKind kind);
    Token decimalFloat(Token token);
    Token stop(Location location, std::string text);
    Location here(const char* at) const;

    const char* at_;
    const char* end_;
    const char* lineStart_;
    uint32_t line_ = 1;
    Diagnostics& diagnostics_;
};

} // namespace sunstone::ptx
