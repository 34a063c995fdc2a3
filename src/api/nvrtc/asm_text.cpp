// SPDX-License-Identifier: Apache-2.0
// See asm_text.h. The scanner knows as much of C++ as it needs to find the strings of asm
// statements: literals, identifiers, and lines of the preprocessor.
#include "api/nvrtc/asm_text.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <set>

namespace sunstone::nvrtc {

namespace {

bool isWord(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

bool isLetter(char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

class Scanner {
public:
    explicit Scanner(std::string_view text) : text_(text) {}

    std::string run() {
        while (at_ < text_.size())
            step();
        return std::move(out_);
    }

private:
    // The end of the literal that begins at `from`: behind its closing quote.
    size_t endOfLiteral(size_t from) const {
        const char quote = text_[from];
        size_t i = from + 1;
        for (; i < text_.size() && text_[i] != quote && text_[i] != '\n'; ++i)
            i += text_[i] == '\\' ? 1 : 0;
        return std::min(i + 1, text_.size());
    }
    // R"mark(...)mark", from its quote on.
    size_t endOfRaw(size_t from) const {
        const size_t open = text_.find('(', from);
        if (open == text_.npos)
            return text_.size();
        const std::string close = ")" + std::string(text_.substr(from + 1, open - from - 1)) + "\"";
        const size_t end = text_.find(close, open);
        return end == text_.npos ? text_.size() : end + close.size();
    }
    void copyTo(size_t end) {
        out_.append(text_.substr(at_, end - at_));
        at_ = end;
    }
    char peek(size_t i) const { return i < text_.size() ? text_[i] : '\0'; }
    size_t skipSpace(size_t i) const {
        while (i < text_.size() && std::isspace(static_cast<unsigned char>(text_[i])))
            ++i;
        return i;
    }

    void step() {
        const char c = text_[at_];
        if (c == '#' && (out_.empty() || out_.back() == '\n')) {
            copyTo(std::min(text_.find('\n', at_), text_.size()));
        } else if (c == '"' || c == '\'') {
            copyTo(endOfLiteral(at_));
        } else if (isWord(c)) {
            size_t end = at_;
            // A quote between digits separates them.
            while (isWord(peek(end)) || (isDigit(c) && peek(end) == '\'' && isWord(peek(end + 1))))
                ++end;
            const std::string_view word = text_.substr(at_, end - at_);
            const bool isAsm = word == "asm" || word == "__asm__" || word == "__asm";
            const bool isRaw = peek(end) == '"' && word.back() == 'R' && word.size() <= 3;
            copyTo(isRaw ? endOfRaw(end) : end);
            if (isAsm)
                statement();
        } else {
            copyTo(at_ + 1);
        }
    }

    // Behind the word asm: qualifiers, a parenthesis, strings, then a colon if there are operands.
    void statement() {
        size_t i = skipSpace(at_);
        while (isWord(peek(i))) {
            while (isWord(peek(i)))
                ++i;
            i = skipSpace(i);
        }
        if (peek(i) != '(')
            return;
        const size_t strings = i + 1;
        for (i = skipSpace(strings); peek(i) == '"';)
            i = skipSpace(endOfLiteral(i));
        if (peek(i) != ':')
            return;
        copyTo(strings);
        while (at_ < i)
            copyPercent();
    }

    void copyPercent() {
        const char next = peek(at_ + 1);
        if (text_[at_] != '%') {
            copyTo(at_ + 1);
            return;
        }
        const bool isPair = next == '%' || next == '{' || next == '|' || next == '}' || next == '=';
        const char behind = isLetter(next) ? peek(at_ + 2) : next; // of a modifier
        if (!isPair && !isDigit(behind) && behind != '[')
            out_ += '%';
        copyTo(at_ + (isPair ? 2 : 1));
    }

    std::string_view text_;
    size_t at_ = 0;
    std::string out_;
};

} // namespace

std::string doublePercents(std::string_view source) {
    return Scanner(source).run();
}

void doublePercentsOfFile(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    in.close();
    std::ofstream(path, std::ios::binary) << doublePercents(text);
}

std::string defineVariables(std::string ptx) {
    for (const std::string space : {".const", ".global"}) {
        const std::string declared = "\n.extern " + space + " ", defined = "\n" + space + " ";
        for (size_t at = 0; (at = ptx.find(declared, at)) != std::string::npos; ++at) {
            const size_t end = ptx.find(';', at);
            if (end != std::string::npos && ptx.compare(end - 2, 2, "[]") != 0)
                ptx.replace(at, declared.size(), defined);
        }
    }
    return ptx;
}

namespace {

bool isOfName(char c) {
    return isWord(c) || c == '$';
}

void replaceName(std::string& text, const std::string& name, const std::string& by) {
    for (size_t at = 0; (at = text.find(name, at)) != std::string::npos;) {
        const size_t end = at + name.size();
        const bool isWhole =
            (at == 0 || !isOfName(text[at - 1])) && (end == text.size() || !isOfName(text[end]));
        if (isWhole)
            text.replace(at, name.size(), by);
        at += isWhole ? by.size() : name.size();
    }
}

// Removes the line that declares an external variable; false if there is none.
bool removeExternal(std::string& ptx, const std::string& name) {
    for (size_t at = 0; (at = ptx.find("\n.extern .", at)) != std::string::npos; ++at) {
        const size_t end = ptx.find(';', at);
        if (end == std::string::npos)
            return false;
        size_t last = end; // of the name, before the sizes of an array
        if (ptx[last - 1] == ']')
            last = ptx.rfind('[', last);
        const size_t first = last - std::min(last, name.size());
        if (ptx.compare(first, name.size(), name) == 0 && !isOfName(ptx[first - 1])) {
            ptx.erase(at, end + 1 - at);
            return true;
        }
    }
    return false;
}

} // namespace

std::string referToStaticVariables(std::string ptx) {
    constexpr std::string_view kMark = "__static__";
    std::set<std::string> defined;
    for (size_t at = 0; (at = ptx.find(kMark, at)) != std::string::npos; at += kMark.size()) {
        size_t first = at, last = at + kMark.size();
        while (first > 0 && isOfName(ptx[first - 1]))
            --first;
        while (last < ptx.size() && isOfName(ptx[last]))
            ++last;
        defined.insert(ptx.substr(first, last - first));
    }
    for (const std::string& name : defined) {
        const std::string plain = name.substr(0, name.find(kMark));
        if (removeExternal(ptx, plain))
            replaceName(ptx, plain, name);
    }
    return ptx;
}

} // namespace sunstone::nvrtc
