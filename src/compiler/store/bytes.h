// SPDX-License-Identifier: Apache-2.0
// Serialises numbers and texts, and reads them back from possibly damaged bytes.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace sunstone::compiler {

class ByteWriter {
public:
    void number(uint32_t value) { text_.append(reinterpret_cast<const char*>(&value), 4); }
    void text(std::string_view value) {
        number(uint32_t(value.size()));
        text_.append(value);
    }
    void wide(uint64_t value) {
        number(uint32_t(value));
        number(uint32_t(value >> 32));
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

// Reads the output of ByteWriter; after the first fault every read returns zeros or empty texts.
class ByteReader {
public:
    explicit ByteReader(std::string_view text) : rest_(text) {}
    uint32_t number() {
        uint32_t value = 0;
        if (!need(4))
            return 0;
        std::memcpy(&value, rest_.data(), 4);
        rest_.remove_prefix(4);
        return value;
    }
    uint64_t wide() {
        const uint64_t low = number();
        return low | uint64_t(number()) << 32;
    }
    std::string text() {
        const uint32_t size = number();
        if (!need(size))
            return {};
        std::string value(rest_.substr(0, size));
        rest_.remove_prefix(size);
        return value;
    }
    bool good() const { return good_; }
    bool finished() const { return good_ && rest_.empty(); }

private:
    bool need(size_t size) {
        good_ = good_ && rest_.size() >= size;
        return good_;
    }
    std::string_view rest_;
    bool good_ = true;
};

} // namespace sunstone::compiler
