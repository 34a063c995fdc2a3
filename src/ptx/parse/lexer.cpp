// SPDX-License-Identifier: Apache-2.0
// PTX text to tokens. See lexer.h.
#include "ptx/parse/lexer.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstring>

namespace sunstone::ptx {
namespace {

enum : uint8_t { kSpace = 1, kNameStart = 2, kNamePart = 4, kDigit = 8, kHex = 16 };

constexpr std::array<uint8_t, 256> makeClasses() {
    std::array<uint8_t, 256> classes{};
    for (const unsigned char c : {' ', '\t', '\r', '\n', '\v', '\f'})
        classes[c] = kSpace;
    for (unsigned c = 'a'; c <= 'z'; ++c) {
        classes[c] = kNameStart | kNamePart | (c <= 'f' ? kHex : 0);
        classes[c - 'a' + 'A'] = classes[c];
    }
    for (unsigned c = '0'; c <= '9'; ++c)
        classes[c] = kNamePart | kDigit | kHex;
    classes['_'] = classes['$'] = kNameStart | kNamePart;
    classes['%'] = kNameStart;
    return classes;
}

constexpr std::array<uint8_t, 256> kClasses = makeClasses();

bool is(char c, uint8_t what) {
    return kClasses[static_cast<unsigned char>(c)] & what;
}

std::string byteName(unsigned char c) {
    if (c >= 32 && c < 127)
        return std::string("character '") + static_cast<char>(c) + "'";
    const char* digits = "0123456789abcdef";
    return std::string("byte 0x") + digits[c >> 4] + digits[c & 15];
}

} // namespace

Lexer::Lexer(std::string_view text, Diagnostics& diagnostics)
    : at_(text.data()), end_(text.data() + text.size()), lineStart_(text.data()),
      diagnostics_(diagnostics) {}

Location Lexer::here(const char* at) const {
    return {line_, static_cast<uint32_t>(at - lineStart_) + 1};
}

Token Lexer::stop(Location location, std::string text) {
    diagnostics_.error(location, std::move(text));
    at_ = end_;
    Token token;
    token.location = location;
    token.text = std::string_view(end_, 0);
    return token;
}

void Lexer::skipLine() {
    while (at_ != end_ && *at_ != '\n')
        ++at_;
}

void Lexer::rewind(const Token& token) {
    at_ = token.text.data();
    line_ = token.location.line;
    lineStart_ = at_ - (token.location.column - 1);
}

// Skips white space and comments; false for an unterminated block comment.
bool Lexer::skipSpace() {
    while (at_ != end_) {
        if (*at_ == '\n') {
            ++line_;
            lineStart_ = ++at_;
        } else if (is(*at_, kSpace)) {
            ++at_;
        } else if (*at_ == '/' && end_ - at_ > 1 && at_[1] == '/') {
            skipLine();
        } else if (*at_ == '/' && end_ - at_ > 1 && at_[1] == '*') {
            const Location start = here(at_);
            at_ += 2;
            for (;; ++at_) {
                if (end_ - at_ < 2) {
                    stop(start, "this comment has no end: missing '*/'");
                    return false;
                }
                if (at_[0] == '*' && at_[1] == '/')
                    break;
                if (*at_ == '\n') {
                    ++line_;
                    lineStart_ = at_ + 1;
                }
            }
            at_ += 2;
        } else if (*at_ == '@' && end_ - at_ > 6 && std::memcmp(at_, "@@DWARF", 7) == 0) {
            skipLine(); // debug information in the syntax of PTX 1.x and 2.x
        } else {
            break;
        }
    }
    return true;
}

Token Lexer::next() {
    const char* before = at_;
    Token token;
    if (!skipSpace() || at_ == end_) {
        token.location = here(at_);
        token.text = std::string_view(end_, 0);
        return token;
    }
    token.spaceBefore = at_ != before;
    token.location = here(at_);
    const char c = *at_;
    const char* start = at_;
    if (is(c, kNameStart) && (c != '%' || (end_ - at_ > 1 && is(at_[1], kNamePart)))) {
        do
            ++at_;
        while (at_ != end_ && is(*at_, kNamePart));
        token.kind = TokenKind::kIdentifier;
        token.text = std::string_view(start, at_ - start);
        return token;
    }
    if (is(c, kDigit))
        return number(token);
    if (c == '.') {
        const char* word = ++at_;
        while (at_ != end_ &&
               (is(*at_, kNamePart) ||
                (*at_ == ':' && end_ - at_ > 2 && at_[1] == ':' && is(at_[2], kNamePart) && ++at_)))
            ++at_;
        if (at_ == word)
            return stop(token.location, "a '.' without a word after it");
        token.kind = TokenKind::kDotWord;
        token.text = std::string_view(word, at_ - word);
        return token;
    }
    if (c == '"')
        return string(token);
    if (!std::strchr("{}[]()<>,;:=+-*/%&|^~!?@", c) || c == 0)
        return stop(token.location, byteName(c) + " is not part of any PTX text");
    ++at_;
    token.kind = TokenKind::kPunctuation;
    token.punctuation = c;
    token.text = std::string_view(start, 1);
    return token;
}

Token Lexer::string(Token token) {
    const char* start = ++at_;
    while (at_ != end_ && *at_ != '"' && *at_ != '\n')
        at_ += *at_ == '\\' && end_ - at_ > 1 && at_[1] != '\n' ? 2 : 1;
    if (at_ == end_ || *at_ != '"')
        return stop(token.location, "this string has no end: missing '\"'");
    token.kind = TokenKind::kString;
    token.text = std::string_view(start, at_ - start);
    ++at_;
    return token;
}

Token Lexer::hexFloat(Token token, unsigned digits, TokenKind kind) {
    const char* start = at_;
    at_ += 2;
    const char* first = at_;
    while (at_ != end_ && is(*at_, kNamePart))
        ++at_;
    token.kind = kind;
    token.text = std::string_view(start, at_ - start);
    const auto result = std::from_chars(first, at_, token.bits, 16);
    if (static_cast<unsigned>(at_ - first) != digits || result.ptr != at_)
        diagnostics_.error(token.location, "malformed number " + quoted(token.text) + ": '" +
                                               std::string(start, 2) + "' needs exactly " +
                                               std::to_string(digits) + " hexadecimal digits");
    return token;
}

Token Lexer::decimalFloat(Token token) {
    double value = 0;
    // from_chars also accepts ".5", as PTX does.
    const auto result = std::from_chars(at_, end_, value);
    token.kind = TokenKind::kFloat64;
    token.text = std::string_view(at_, result.ptr - at_);
    if (result.ec == std::errc::invalid_argument)
        return stop(token.location, "malformed number");
    if (result.ec == std::errc::result_out_of_range)
        diagnostics_.error(token.location,
                           "number " + quoted(token.text) + " is out of the range of .f64");
    at_ = result.ptr;
    token.bits = std::bit_cast<uint64_t>(value);
    return token;
}

Token Lexer::numberAt(const Token& dotWord) {
    Token token;
    token.location = dotWord.location;
    at_ = dotWord.text.data() - 1;
    return decimalFloat(token);
}

Token Lexer::number(Token token) {
    const char* start = at_;
    const char second = end_ - at_ > 1 ? at_[1] : 0;
    if (*at_ == '0' && (second == 'f' || second == 'F'))
        return hexFloat(token, 8, TokenKind::kFloat32);
    if (*at_ == '0' && (second == 'd' || second == 'D'))
        return hexFloat(token, 16, TokenKind::kFloat64);
    int base = 10;
    const char* digits = at_;
    if (*at_ == '0' && (second == 'x' || second == 'X')) {
        base = 16;
        digits = at_ + 2;
    } else if (*at_ == '0' && (second == 'b' || second == 'B')) {
        base = 2;
        digits = at_ + 2;
    } else if (*at_ == '0' && is(second, kDigit)) {
        base = 8;
    }
    at_ = digits;
    while (at_ != end_ && is(*at_, kNamePart))
        ++at_;
    if (base != 16 && base != 2) {
        const char* scan = start;
        while (scan != at_ && is(*scan, kDigit))
            ++scan;
        const bool point = scan == at_ && at_ != end_ && *at_ == '.' &&
                           !(end_ - at_ > 1 && is(at_[1], kNameStart));
        if (point || (scan != at_ && (*scan == 'e' || *scan == 'E'))) {
            at_ = start;
            return decimalFloat(token);
        }
    }
    token.kind = TokenKind::kInteger;
    token.text = std::string_view(start, at_ - start);
    const char* last = at_;
    if (last > digits && (last[-1] == 'U' || last[-1] == 'u'))
        --last;
    const auto result = std::from_chars(digits, last, token.bits, base);
    if (result.ec == std::errc::result_out_of_range)
        diagnostics_.error(token.location,
                           "number " + quoted(token.text) + " does not fit in 64 bits");
    else if (result.ec != std::errc() || result.ptr != last)
        diagnostics_.error(token.location, "malformed number " + quoted(token.text));
    return token;
}

} // namespace sunstone::ptx
