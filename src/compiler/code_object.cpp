// SPDX-License-Identifier: Apache-2.0
#include "compiler/code_object.h"

#include <cstring>

namespace sunstone::compiler {

std::string VariableId::symbol() const {
    std::string text = "v." + std::to_string(module) + ".";
    if (function != kModuleScope)
        text += "f" + std::to_string(function) + ".";
    return text + std::to_string(index);
}

namespace {

constexpr uint32_t kMagic = 0x4a424f53; // "SOBJ"

class Writer {
public:
    void number(uint32_t value) { text_.append(reinterpret_cast<const char*>(&value), 4); }
    void text(std::string_view value) {
        number(uint32_t(value.size()));
        text_.append(value);
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

// Reads what Writer wrote; after the first fault every read gives nothing.
class Reader {
public:
    explicit Reader(std::string_view text) : rest_(text) {}
    uint32_t number() {
        uint32_t value = 0;
        if (!need(4))
            return 0;
        std::memcpy(&value, rest_.data(), 4);
        rest_.remove_prefix(4);
        return value;
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

} // namespace

std::string CodeObject::serialize() const {
    Writer out;
    out.number(kMagic);
    out.text(code);
    out.number(uint32_t(stackSizes.size()));
    for (const auto& [name, size] : stackSizes) {
        out.text(name);
        out.number(size);
    }
    out.number(uint32_t(variables.size()));
    for (const VariableId& id : variables)
        for (uint32_t part : {id.module, id.function, id.index})
            out.number(part);
    out.number(stackNeed);
    out.number(uint32_t(boundLoads.size()));
    for (uint32_t count : boundLoads)
        out.number(count);
    out.number(forDebugger);
    return out.take();
}

bool CodeObject::deserialize(std::string_view bytes) {
    Reader in(bytes);
    if (in.number() != kMagic)
        return false;
    code = in.text();
    stackSizes.clear();
    variables.clear();
    for (uint32_t left = in.number(); left != 0 && in.good(); --left) {
        std::string name = in.text();
        stackSizes[std::move(name)] = in.number();
    }
    for (uint32_t left = in.number(); left != 0 && in.good(); --left) {
        VariableId id;
        id.module = in.number();
        id.function = in.number();
        id.index = in.number();
        variables.push_back(id);
    }
    stackNeed = in.number();
    boundLoads.clear();
    for (uint32_t left = in.number(); left != 0 && in.good(); --left)
        boundLoads.push_back(in.number());
    forDebugger = in.number() != 0;
    return in.finished();
}

} // namespace sunstone::compiler
