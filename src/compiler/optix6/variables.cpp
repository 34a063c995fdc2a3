// SPDX-License-Identifier: Apache-2.0
#include "compiler/optix6/variables.h"

#include "devlib/classic.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

namespace sunstone::compiler::optix6 {

namespace {

// The parts of a nested name in C++'s mangling, <length><identifier>...; empty if it has parts of
// another form.
std::vector<std::string_view> partsOf(std::string_view text) {
    std::vector<std::string_view> parts;
    while (!text.empty() && text[0] >= '0' && text[0] <= '9') {
        size_t digits = 0, length = 0;
        while (digits < text.size() && digits < 6 && text[digits] >= '0' && text[digits] <= '9')
            length = length * 10 + size_t(text[digits++] - '0');
        if (length == 0 || length > text.size() - digits)
            return {};
        parts.push_back(text.substr(digits, length));
        text.remove_prefix(digits + length);
    }
    return parts;
}

// The names of the namespaces and of the thing itself: {"space", "color"}.
std::vector<std::string_view> scopesOf(std::string_view symbol) {
    std::vector<std::string_view> parts;
    if (symbol.starts_with("_ZN"))
        parts = partsOf(symbol.substr(3));
    else if (symbol.starts_with("_Z"))
        parts = partsOf(symbol.substr(2));
    // Without a namespace the types of parameters follow: _Z3sum6float3.
    if (!symbol.starts_with("_ZN") && parts.size() > 1)
        parts.resize(1);
    if (parts.empty())
        parts = {symbol};
    return parts;
}

std::string join(const std::vector<std::string_view>& parts) {
    std::string text;
    for (const std::string_view part : parts) {
        if (!text.empty())
            text += "::";
        text += part;
    }
    return text;
}

// The variable in namespace `kind` that describes another variable.
const ptx::Variable* companion(const ptx::Module& module, std::string_view symbol,
                               std::string_view kind) {
    std::vector<std::string_view> parts = scopesOf(symbol);
    parts.insert(parts.end() - 1, kind);
    std::string name = "_ZN";
    for (const std::string_view part : parts)
        name += std::to_string(part.size()) + std::string(part);
    return module.findVariable(name + "E");
}

std::string textOf(const ptx::Variable* variable) {
    if (!variable || variable->initializer.empty())
        return {};
    const auto* begin = reinterpret_cast<const char*>(variable->initializer.data());
    return std::string(begin, strnlen(begin, variable->initializer.size()));
}

uint32_t wordOf(const ptx::Variable* variable, size_t offset, uint32_t otherwise) {
    uint32_t word = 0;
    if (!variable)
        return otherwise;
    if (offset < variable->initializer.size())
        std::memcpy(&word, variable->initializer.data() + offset,
                    std::min<size_t>(4, variable->initializer.size() - offset));
    return word;
}

VariableUse useOf(const std::string& semantic, std::string& attribute) {
    constexpr std::string_view kAttribute = "attribute ";
    static constexpr std::pair<const char*, VariableUse> kSemantics[] = {
        {"", VariableUse::kValue},
        {"rtLaunchIndex", VariableUse::kLaunchIndex},
        {"rtLaunchDim", VariableUse::kLaunchDim},
        {"rtCurrentRay", VariableUse::kRay},
        {"rtIntersectionDistance", VariableUse::kDistance},
        {"rtRayPayload", VariableUse::kPayload},
        {"rtPayload", VariableUse::kPayload}, // as programs before release 6 have it
        {"rtCurrentTime", VariableUse::kTime},
        {"rtSubframeIndex", VariableUse::kSubframe},
    };
    for (const auto& [name, use] : kSemantics)
        if (semantic == name)
            return use;
    if (semantic.starts_with(kAttribute)) {
        attribute = semantic.substr(kAttribute.size());
        attribute.erase(0, attribute.find_first_not_of(' '));
        return VariableUse::kAttribute;
    }
    return VariableUse::kValue;
}

// Compilers name string literals with a '$'; an empty string has the type of a buffer.
bool looksLikeBuffer(const ptx::Variable& variable) {
    return variable.name.find('$') == std::string_view::npos &&
           variable.space == ptx::Space::kGlobal && variable.isArray && variable.size == 1 &&
           variable.type == ptx::Type::kB8 && !variable.hasInitializer;
}

// The type `texture` of internal/optix_texture_references.h.
bool looksLikeTexture(const ptx::Variable& variable) {
    return variable.isArray && variable.size == 128 && variable.alignment == 128 &&
           variable.type == ptx::Type::kB8 && !variable.hasInitializer;
}

// The names of functions and variables in a function's body.
class Names {
public:
    explicit Names(std::set<std::string_view>& names) : names_(names) {}
    void add(const ptx::Operand& operand) {
        if (operand.kind == ptx::OperandKind::kSymbol || operand.kind == ptx::OperandKind::kAddress)
            if (!operand.name.empty())
                names_.insert(operand.name);
        for (const ptx::Operand& element : operand.elements)
            add(element);
    }
    void add(const ptx::Function& function) {
        for (const ptx::Statement& statement : function.body) {
            add(statement.instruction.target);
            for (const auto* list :
                 {&statement.instruction.operands, &statement.instruction.results,
                  &statement.instruction.arguments})
                for (const ptx::Operand& operand : *list)
                    add(operand);
        }
        for (const ptx::CallTargets& targets : function.callTargets)
            names_.insert(targets.functions.begin(), targets.functions.end());
    }

private:
    std::set<std::string_view>& names_;
};

// The values of registers that are written once, with a number or the address of a variable.
class Constants {
public:
    explicit Constants(const ptx::Function& function) {
        for (const ptx::Statement& statement : function.body) {
            const ptx::Instruction& instruction = statement.instruction;
            for (const ptx::Operand& result : instruction.results)
                define(result, nullptr);
            if (!instruction.operands.empty())
                define(instruction.operands[0], &instruction);
        }
    }
    // The operand's number or variable; null if it is neither.
    const ptx::Operand* find(const ptx::Operand& operand, unsigned depth = 0) const {
        if (operand.kind == ptx::OperandKind::kInteger ||
            (operand.kind == ptx::OperandKind::kSymbol && operand.offset == 0))
            return &operand;
        const auto found = definitions_.find(operand.index);
        if (operand.kind != ptx::OperandKind::kRegister || found == definitions_.end() ||
            !found->second || depth > 8)
            return nullptr;
        return find(found->second->operands[1], depth + 1);
    }

private:
    void define(const ptx::Operand& operand, const ptx::Instruction* instruction) {
        for (const ptx::Operand& element : operand.elements)
            define(element, nullptr);
        if (operand.kind != ptx::OperandKind::kRegister)
            return;
        const bool copies = instruction && instruction->operands.size() == 2 &&
                            (instruction->opcode == "mov" || instruction->opcode == "cvta");
        const auto [place, isNew] =
            definitions_.try_emplace(operand.index, copies ? instruction : nullptr);
        if (!isNew)
            place->second = nullptr;
    }
    std::map<uint32_t, const ptx::Instruction*> definitions_; // null: several, or of other kinds
};

// Records how a function accesses buffers: the dimensions and the element size of its calls. If
// accesses of a buffer differ, records nothing.
void noteAccesses(const ptx::Function& function, std::vector<DeviceVariable>& variables) {
    const Constants constants(function);
    const auto note = [](uint32_t& known, const ptx::Operand* number) {
        constexpr uint32_t kDifferent = ~0u;
        const uint32_t value = number && number->kind == ptx::OperandKind::kInteger
                                   ? uint32_t(number->integer)
                                   : kDifferent;
        known = known == 0 || known == value ? value : kDifferent;
    };
    for (const ptx::Statement& statement : function.body) {
        const ptx::Instruction& call = statement.instruction;
        if (call.target.name != "_rt_buffer_get_64" || call.arguments.size() < 3)
            continue;
        const ptx::Operand* buffer = constants.find(call.arguments[0]);
        for (DeviceVariable& variable : variables)
            if (buffer && variable.symbol == buffer->name && variable.use == VariableUse::kBuffer) {
                note(variable.dimensions, constants.find(call.arguments[1]));
                note(variable.elementBytes, constants.find(call.arguments[2]));
            }
    }
}

// The definition of a function that is visible from `from`.
std::pair<const ptx::Module*, const ptx::Function*>
findFunction(const std::vector<const ptx::Module*>& modules, const ptx::Module* from,
             std::string_view name) {
    if (const ptx::Function* own = from->findFunction(name); own && own->hasBody)
        return {from, own};
    for (const ptx::Module* module : modules)
        if (const ptx::Function* other = module->findFunction(name); other && other->hasBody)
            return {module, other};
    return {nullptr, nullptr};
}

const ptx::Variable* findVariable(const std::vector<const ptx::Module*>& modules,
                                  const ptx::Module*& from, std::string_view name) {
    const ptx::Variable* own = from->findVariable(name);
    if (!own || own->linkage != ptx::Linkage::kExtern)
        return own;
    for (const ptx::Module* module : modules)
        if (const ptx::Variable* other = module->findVariable(name);
            other && other->linkage != ptx::Linkage::kExtern) {
            from = module;
            return other;
        }
    return own;
}

uint32_t slotAlignment(const DeviceVariable& variable) {
    return variable.use == VariableUse::kValue
               ? std::clamp(variable.declaration->alignment, 4u, 16u)
           : variable.use == VariableUse::kBuffer ? uint32_t(alignof(devlib::BufferView))
                                                  : 8;
}

uint32_t slotBytes(const DeviceVariable& variable) {
    return variable.use == VariableUse::kValue    ? std::max(variable.bytes, 4u)
           : variable.use == VariableUse::kBuffer ? uint32_t(sizeof(devlib::BufferView))
                                                  : 8;
}

} // namespace

std::string sourceName(std::string_view symbol) {
    return join(scopesOf(symbol));
}

DeviceVariable describe(const ptx::Module& module, const ptx::Variable& variable) {
    DeviceVariable result;
    result.symbol = variable.name;
    result.declaration = &variable;
    result.bytes = uint32_t(variable.size);
    if (variable.space != ptx::Space::kGlobal)
        return result;
    result.name = sourceName(variable.name);
    result.annotation = textOf(companion(module, variable.name, "rti_internal_annotation"));
    if (variable.type == ptx::Type::kTexref) {
        result.use = VariableUse::kTexture;
        return result;
    }
    const ptx::Variable* info = companion(module, variable.name, "rti_internal_typeinfo");
    if (!info) {
        if (looksLikeBuffer(variable))
            result.use = VariableUse::kBuffer;
        else if (looksLikeTexture(variable))
            result.use = VariableUse::kTexture;
        return result;
    }
    result.typeName = textOf(companion(module, variable.name, "rti_internal_typename"));
    result.typeEnum =
        wordOf(companion(module, variable.name, "rti_internal_typeenum"), 0, kTypePlain);
    result.use =
        useOf(textOf(companion(module, variable.name, "rti_internal_semantic")), result.attribute);
    return result;
}

const DeviceVariable* ProgramVariables::find(std::string_view symbol) const {
    for (const DeviceVariable& variable : list)
        if (variable.symbol == symbol)
            return &variable;
    return nullptr;
}

bool ProgramVariables::readsAttributes() const {
    return std::any_of(list.begin(), list.end(), [](const DeviceVariable& variable) {
        return variable.use == VariableUse::kAttribute;
    });
}

namespace {

using CallGraph = std::map<const ptx::Function*, std::set<const ptx::Function*>>;

bool reaches(const CallGraph& calls, const ptx::Function* from, const ptx::Function* to) {
    std::set<const ptx::Function*> seen;
    std::vector<const ptx::Function*> queue = {from};
    while (!queue.empty()) {
        const auto callees = calls.find(queue.back());
        queue.pop_back();
        if (callees == calls.end())
            continue;
        for (const ptx::Function* callee : callees->second) {
            if (callee == to)
                return true;
            if (seen.insert(callee).second)
                queue.push_back(callee);
        }
    }
    return false;
}

} // namespace

ProgramVariables variablesOf(const std::vector<const ptx::Module*>& modules,
                             std::string_view function) {
    ProgramVariables result;
    std::set<const ptx::Function*> seen;
    std::vector<std::pair<const ptx::Module*, const ptx::Function*>> queue;
    CallGraph calls;
    const auto visit = [&](const ptx::Module* from, std::string_view name) {
        const auto [module, body] = findFunction(modules, from, name);
        if (body && seen.insert(body).second)
            queue.emplace_back(module, body);
        const ptx::Variable* variable = body ? nullptr : findVariable(modules, from, name);
        if (!variable || result.find(name))
            return;
        DeviceVariable described = describe(*from, *variable);
        if (described.use != VariableUse::kNone)
            result.list.push_back(std::move(described));
    };
    visit(modules.front(), function);
    while (!queue.empty()) {
        const auto [module, body] = queue.back();
        queue.pop_back();
        std::set<std::string_view> names;
        Names(names).add(*body);
        for (const std::string_view name : names) {
            if (const ptx::Function* callee = findFunction(modules, module, name).second)
                calls[body].insert(callee);
            result.callsPrograms |= name.starts_with("_rt_callable_program");
            visit(module, name);
        }
    }
    for (const ptx::Function* each : seen) {
        noteAccesses(*each, result.list);
        result.recurses = result.recurses || reaches(calls, each, each);
    }
    for (DeviceVariable& variable : result.list)
        for (uint32_t* number : {&variable.dimensions, &variable.elementBytes})
            *number = *number == ~0u ? 0 : *number;
    std::sort(result.list.begin(), result.list.end(),
              [](const auto& a, const auto& b) { return a.symbol < b.symbol; });
    for (DeviceVariable& variable : result.list) {
        if (!variable.isScoped())
            continue;
        const uint32_t alignment = slotAlignment(variable);
        variable.slot = (result.blockBytes + alignment - 1) / alignment * alignment;
        result.blockBytes = variable.slot + slotBytes(variable);
    }
    return result;
}

std::vector<AttributeDeclaration> attributesOf(const ptx::Module& module) {
    std::vector<AttributeDeclaration> result;
    for (const ptx::Variable& variable : module.variables) {
        DeviceVariable described = describe(module, variable);
        if (described.use == VariableUse::kAttribute)
            result.push_back({std::move(described.attribute), described.bytes});
    }
    return result;
}

} // namespace sunstone::compiler::optix6
