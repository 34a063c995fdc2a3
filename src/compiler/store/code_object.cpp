// SPDX-License-Identifier: Apache-2.0
// See code_object.h.
#include "compiler/store/code_object.h"

#include "compiler/store/bytes.h"

namespace sunstone::compiler {

std::string VariableId::symbol() const {
    std::string text = "v." + std::to_string(module) + ".";
    if (function != kModuleScope)
        text += "f" + std::to_string(function) + ".";
    return text + std::to_string(index);
}

namespace {

constexpr uint32_t kMagic = 0x4a424f53; // "SOBJ"

} // namespace

std::string CodeObject::serialize() const {
    ByteWriter out;
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
    ByteReader in(bytes);
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
