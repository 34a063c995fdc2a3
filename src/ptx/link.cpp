// SPDX-License-Identifier: Apache-2.0
#include "ptx/link.h"

#include "base/error.h"
#include "ptx/printer.h"

#include <algorithm>

namespace sunstone::ptx {

namespace {

bool isDefined(const Variable& variable) {
    return variable.linkage != Linkage::kExtern;
}

bool isSame(const Variable& a, const Variable& b) {
    return a.space == b.space && a.size == b.size && a.type == b.type &&
           a.initializer == b.initializer && a.relocations.empty() && b.relocations.empty();
}

// The text of one function, for comparison.
std::string textOf(const Function& function) {
    Module alone;
    alone.functions.push_back(function);
    return print(alone);
}

class Linker {
public:
    Linker(std::span<const Module* const> modules, const IsShared& isShared)
        : modules_(modules), isShared_(isShared) {}

    std::string run() {
        const Module& first = *modules_.front();
        merged_.target = first.target;
        merged_.targetOptions = first.targetOptions;
        merged_.addressSize = first.addressSize;
        merged_.files = {""};
        for (const Module* module : modules_)
            add(*module);
        return print(merged_);
    }

private:
    using Names = std::unordered_map<std::string_view, std::string_view>;

    void add(const Module& module) {
        if (std::pair(module.versionMajor, module.versionMinor) >
            std::pair(merged_.versionMajor, merged_.versionMinor)) {
            merged_.versionMajor = module.versionMajor;
            merged_.versionMinor = module.versionMinor;
        }
        renamed_.clear();
        chooseNames(module);
        for (const Variable& variable : module.variables)
            addVariable(variable);
        fileBase_ = uint32_t(merged_.files.size()) - 1;
        for (size_t i = 1; i < module.files.size(); ++i)
            merged_.files.push_back(module.files[i]);
        for (const Function& function : module.functions)
            addFunction(function);
        for (const auto& [name, target] : module.aliases)
            merged_.aliases.emplace_back(nameOf(name), nameOf(target));
    }

    // Gives internal symbols new names if their names are taken.
    void chooseNames(const Module& module) {
        const auto choose = [&](std::string_view name) {
            if (!isTaken(name))
                return;
            std::string fresh;
            for (unsigned i = 2; fresh.empty() || isTaken(fresh); ++i)
                fresh = std::string(name) + "$" + std::to_string(i);
            renamed_[name] =
                *merged_.generated.emplace_back(std::make_unique<std::string>(std::move(fresh)));
        };
        for (const Variable& variable : module.variables)
            if (variable.linkage == Linkage::kInternal && !isShared_(module, variable))
                choose(variable.name);
        for (const Function& function : module.functions)
            if (function.linkage == Linkage::kInternal && !function.isEntry && function.hasBody)
                choose(function.name);
    }
    bool isTaken(std::string_view name) const {
        return variables_.count(name) || functions_.count(name);
    }
    std::string_view nameOf(std::string_view name) const {
        const auto found = renamed_.find(name);
        return found == renamed_.end() ? name : found->second;
    }

    void addVariable(Variable variable) {
        variable.name = nameOf(variable.name);
        for (Relocation& relocation : variable.relocations)
            relocation.symbol = nameOf(relocation.symbol);
        const auto [place, isNew] = variables_.try_emplace(variable.name, merged_.variables.size());
        if (isNew) {
            merged_.variables.push_back(std::move(variable));
            return;
        }
        Variable& known = merged_.variables[place->second];
        if (!isDefined(variable))
            return;
        if (!isDefined(known))
            known = std::move(variable);
        else if (!isSame(known, variable) && variable.linkage != Linkage::kWeak &&
                 variable.linkage != Linkage::kCommon)
            fail(Code::kInvalidValue, "variable \"", variable.name,
                 "\" is defined in two of the texts");
    }

    void addFunction(Function function) {
        rename(function);
        if (!function.hasBody) {
            // A declaration takes the linkage of another module's function of this name.
            const auto found = functions_.find(function.name);
            if (found != functions_.end() &&
                merged_.functions[found->second].linkage != Linkage::kExtern)
                function.linkage = merged_.functions[found->second].linkage;
            functions_.try_emplace(function.name, merged_.functions.size());
            merged_.functions.push_back(std::move(function));
            return;
        }
        const auto known = bodies_.find(function.name);
        if (known != bodies_.end()) {
            if (function.linkage != Linkage::kWeak &&
                textOf(merged_.functions[known->second]) != textOf(function))
                fail(Code::kInvalidValue, "function \"", function.name,
                     "\" is defined in two of the texts");
            return;
        }
        for (Function& other : merged_.functions)
            if (other.name == function.name)
                other.linkage = function.linkage;
        functions_[function.name] = bodies_[function.name] = merged_.functions.size();
        merged_.functions.push_back(std::move(function));
    }

    void rename(Function& function) {
        function.name = nameOf(function.name);
        for (Statement& statement : function.body) {
            Instruction& instruction = statement.instruction;
            if (instruction.source.file != 0)
                instruction.source.file += fileBase_;
            rename(instruction.target);
            for (auto* list : {&instruction.operands, &instruction.results, &instruction.arguments})
                for (Operand& operand : *list)
                    rename(operand);
        }
        for (Variable& variable : function.variables)
            for (Relocation& relocation : variable.relocations)
                relocation.symbol = nameOf(relocation.symbol);
        for (CallTargets& targets : function.callTargets)
            for (std::string_view& name : targets.functions)
                name = nameOf(name);
    }
    void rename(Operand& operand) {
        if (operand.kind == OperandKind::kSymbol || operand.kind == OperandKind::kAddress)
            operand.name = nameOf(operand.name);
        for (Operand& element : operand.elements)
            rename(element);
    }

    const std::span<const Module* const> modules_;
    const IsShared& isShared_;
    Module merged_;
    Names renamed_; // of the module that is added
    std::unordered_map<std::string_view, size_t> variables_, functions_, bodies_;
    uint32_t fileBase_ = 0;
};

} // namespace

std::string link(std::span<const Module* const> modules, const IsShared& isShared) {
    return Linker(modules, isShared).run();
}

} // namespace sunstone::ptx
