// SPDX-License-Identifier: Apache-2.0
// See debug_info.h.
#include "compiler/debug/debug_info.h"

#include <llvm/BinaryFormat/Dwarf.h>
#include <llvm/Demangle/Demangle.h>
#include <llvm/Support/Path.h>

#include <algorithm>
#include <cstdlib>

namespace sunstone::compiler {

namespace {

constexpr unsigned kDwarfVersion = 4;

llvm::StringRef toRef(std::string_view text) {
    return {text.data(), text.size()};
}

// "outer" of _ZN12_GLOBAL__N_15outerEj; an unmangled name is returned unchanged.
std::string baseName(const std::string& symbol) {
    llvm::ItaniumPartialDemangler demangler;
    if (demangler.partialDemangle(symbol.c_str()) || !demangler.isFunction())
        return symbol;
    size_t size = 0;
    char* text = demangler.getFunctionBaseName(nullptr, &size);
    std::string name = text ? text : symbol;
    std::free(text);
    return name;
}

} // namespace

// ---- modules, files, types --------------------------------------------------------------------

DebugInfo::DebugInfo(Unit& unit) : unit_(unit), builder_(unit.module()) {
    unit.module().addModuleFlag(llvm::Module::Warning, "Debug Info Version",
                                llvm::DEBUG_METADATA_VERSION);
    unit.module().addModuleFlag(llvm::Module::Max, "Dwarf Version", kDwarfVersion);
}

llvm::DIFile* DebugInfo::file(const ptx::Module& module, uint32_t number) {
    llvm::DIFile*& entry = modules_[&module].files[number];
    if (!entry) {
        const std::string path = number < module.files.size() ? module.files[number] : "";
        entry = builder_.createFile(path.empty() ? "ptx" : llvm::sys::path::filename(path),
                                    llvm::sys::path::parent_path(path));
    }
    return entry;
}

const DwarfInfo& DebugInfo::dwarf(const ptx::Module& module) {
    std::optional<DwarfInfo>& entry = modules_[&module].dwarf;
    if (!entry)
        entry = unit_.debugLevel(module) == DebugLevel::kFull ? readDwarf(module) : DwarfInfo{};
    return *entry;
}

const DwarfFunction* DebugInfo::variablesOf(const ptx::Module& module,
                                            const ptx::Function& source) {
    const auto& functions = dwarf(module).functions;
    const auto found = functions.find(std::string(source.name));
    return found == functions.end() ? nullptr : &found->second;
}

const InlinedCalls& DebugInfo::inlinedCalls(const ptx::Module& module) {
    std::optional<InlinedCalls>& entry = modules_[&module].calls;
    if (!entry)
        entry.emplace(module);
    return *entry;
}

llvm::DISubprogram* DebugInfo::describe(const ptx::Module& module, const ptx::Function& source) {
    if (!unit_.hasLineInfo(module))
        return nullptr;
    const ptx::SourcePosition* first = nullptr;
    for (const ptx::Statement& statement : source.body)
        if (statement.kind == ptx::StatementKind::kInstruction &&
            statement.instruction.source.line != 0) {
            first = &statement.instruction.source;
            // From inlined code, go to the place of the call in the function itself.
            const InlinedCalls& calls = inlinedCalls(module);
            for (uint32_t call = calls.at(statement.instruction.location.line); call != 0;
                 call = calls.call(call).within)
                first = &calls.call(call).at;
            break;
        }
    if (!first)
        return nullptr;
    const DwarfFunction* dwarf = variablesOf(module, source);
    const uint32_t line = dwarf && dwarf->line ? dwarf->line : first->line;
    if (!compileUnit_) // one for all modules: a builder has only one
        compileUnit_ = builder_.createCompileUnit(
            llvm::dwarf::DW_LANG_C_plus_plus_14, file(module, first->file), "sunstone", false, "",
            0, "",
            unit_.debugLevel(module) == DebugLevel::kFull ? llvm::DICompileUnit::FullDebug
                                                          : llvm::DICompileUnit::LineTablesOnly);
    llvm::DIFile* place = file(module, dwarf && dwarf->file ? dwarf->file : first->file);
    const std::string name = dwarf ? dwarf->name : std::string(source.name);
    return builder_.createFunction(place, name, toRef(source.name), place, line,
                                   builder_.createSubroutineType(builder_.getOrCreateTypeArray({})),
                                   line, llvm::DINode::FlagPrototyped,
                                   llvm::DISubprogram::SPFlagDefinition);
}

void DebugInfo::describeLaunchParams(const ptx::Module& module, llvm::DISubprogram* function) {
    const auto& globals = dwarf(module).globals;
    const auto found = globals.find(unit_.rules().launchParams);
    if (found == globals.end() || launchParams_.count(function) != 0)
        return;
    if (llvm::DIType* kind = type(module, found->second.type))
        launchParams_[function] = builder_.createAutoVariable(
            function, found->second.name, function->getFile(), function->getLine(), kind, true);
}

llvm::DISubprogram* DebugInfo::inlinedFunction(const ptx::Module& module, const std::string& name,
                                               uint32_t file, uint32_t line, uint32_t origin) {
    llvm::DISubprogram*& function = modules_[&module].inlined[{name, file, origin}];
    if (!function) {
        llvm::DIFile* place = this->file(module, file);
        function = builder_.createFunction(
            place, name, {}, place, line,
            builder_.createSubroutineType(builder_.getOrCreateTypeArray({})), line,
            llvm::DINode::FlagPrototyped, llvm::DISubprogram::SPFlagDefinition);
        describeLaunchParams(module, function);
    }
    return function;
}

DebugInfo::InlinedScope DebugInfo::inlinedScope(const ptx::Module& module, uint32_t number,
                                                const ptx::SourcePosition& within,
                                                llvm::DISubprogram* function) {
    InlinedScope& scope = inlinedScopes_[{function, number}];
    if (scope.function)
        return scope;
    const InlinedCall& call = inlinedCalls(module).call(number);
    ModuleInfo& own = modules_[&module];
    const auto [name, isNew] = own.inlinedNames.try_emplace(number);
    if (isNew) {
        const std::string symbol = debugString(module, call.name, call.nameOffset);
        name->second = symbol.empty() ? "inlined function" : baseName(symbol);
    }
    scope.function = inlinedFunction(module, name->second, within.file, within.line, 0);
    llvm::DILocalScope* outer = function;
    llvm::DILocation* outerAt = nullptr;
    if (call.within) {
        const InlinedScope around = inlinedScope(module, call.within, call.at, function);
        outer = around.function;
        outerAt = around.at;
    }
    if (llvm::DIFile* file = this->file(module, call.at.file); file != outer->getFile())
        outer = builder_.createLexicalBlockFile(outer, file);
    scope.at = llvm::DILocation::getDistinct(function->getContext(), call.at.line, call.at.column,
                                             outer, outerAt);
    return scope;
}

llvm::DIType* DebugInfo::type(const ptx::Module& module, uint32_t key) {
    ModuleInfo& own = modules_[&module];
    const auto known = own.types.find(key);
    if (known != own.types.end())
        return known->second;
    const auto& types = dwarf(module).types;
    const auto found = types.find(key);
    if (key == 0 || found == types.end())
        return nullptr;
    own.types[key] = nullptr; // a type that refers to itself through aliases is void
    llvm::DIType* made = makeType(module, key, found->second);
    own.types[key] = made;
    return made;
}

llvm::DIType* DebugInfo::makeType(const ptx::Module& module, uint32_t key, const DwarfType& type) {
    using Kind = DwarfType::Kind;
    const auto other = [&](uint32_t of) { return this->type(module, of); };
    const auto sizeOf = [](llvm::DIType* of) { return of ? of->getSizeInBits() : 0; };
    llvm::DIFile* place = file(module, 1);
    switch (type.kind) {
    case Kind::kBase:
        return builder_.createBasicType(type.name, type.size * 8, type.encoding);
    case Kind::kPointer:
        return builder_.createPointerType(other(type.of), 64);
    case Kind::kReference:
        return builder_.createReferenceType(llvm::dwarf::DW_TAG_reference_type, other(type.of), 64);
    case Kind::kConst:
        return builder_.createQualifiedType(llvm::dwarf::DW_TAG_const_type, other(type.of));
    case Kind::kVolatile:
        return builder_.createQualifiedType(llvm::dwarf::DW_TAG_volatile_type, other(type.of));
    case Kind::kTypedef:
        return builder_.createTypedef(other(type.of), type.name, place, 0, place);
    case Kind::kArray: {
        llvm::DIType* element = other(type.of);
        const uint64_t bits = type.count * sizeOf(element);
        return builder_.createArrayType(
            bits, 0, element,
            builder_.getOrCreateArray({builder_.getOrCreateSubrange(0, int64_t(type.count))}));
    }
    case Kind::kEnum: {
        llvm::SmallVector<llvm::Metadata*> values;
        for (const auto& [name, value] : type.enumerators)
            values.push_back(builder_.createEnumerator(name, uint64_t(value)));
        return builder_.createEnumerationType(place, type.name, place, 0, type.size * 8, 0,
                                              builder_.getOrCreateArray(values), nullptr);
    }
    case Kind::kStruct: {
        llvm::DICompositeType* made = builder_.createStructType(
            place, type.name, place, 0, type.size * 8, 0, llvm::DINode::FlagZero, nullptr, {});
        modules_[&module].types[key] = made; // members may point to it
        llvm::SmallVector<llvm::Metadata*> members;
        for (const DwarfType::Member& member : type.members) {
            llvm::DIType* of = other(member.type);
            members.push_back(builder_.createMemberType(made, member.name, place, 0, sizeOf(of), 0,
                                                        member.offset * 8, llvm::DINode::FlagZero,
                                                        of));
        }
        builder_.replaceArrays(made, builder_.getOrCreateArray(members));
        return made;
    }
    case Kind::kNone:
        break;
    }
    return nullptr;
}

void DebugInfo::finish() {
    builder_.finalize();
}

// ---- functions --------------------------------------------------------------------------------

FunctionDebug::FunctionDebug(DebugInfo& info, const ptx::Module& module,
                             const ptx::Function& source, llvm::Function& function)
    : info_(info), module_(module) {
    subprogram_ = info.describe(module, source);
    if (!subprogram_)
        return;
    function.setSubprogram(subprogram_);
    open_.push_back({subprogram_});
    const DwarfFunction* dwarf = info.variablesOf(module, source);
    if (!dwarf)
        return;
    info.describeLaunchParams(module, subprogram_);
    for (uint32_t i = 0; i < source.registers.size(); ++i) {
        const ptx::Register& reg = source.registers[i];
        const std::string number = reg.number == ~0u ? "" : std::to_string(reg.number);
        if (reg.vector <= 1)
            registers_[std::string(reg.name) + number] = i;
    }
    unsigned parameters = 0;
    addScope(dwarf->scope, {subprogram_}, parameters);
}

void FunctionDebug::addVariable(const DwarfVariable& from, Scope parent, unsigned& parameters) {
    llvm::DIFile* file = info_.file(module_, from.file);
    llvm::DIType* type = info_.type(module_, from.type);
    if (!type)
        return;
    const auto create = [&] {
        return from.isParameter
                   ? info_.builder().createParameterVariable(parent.scope, from.name, ++parameters,
                                                             file, from.line, type, true)
                   : info_.builder().createAutoVariable(parent.scope, from.name, file, from.line,
                                                        type, true);
    };
    Variable made;
    if (auto* function = llvm::dyn_cast<llvm::DISubprogram>(parent.scope);
        function && parent.inlinedAt) {
        llvm::DILocalVariable*& known = info_.inlinedVariable(function, from);
        if (!known)
            known = create();
        made.variable = known;
    } else {
        made.variable = create();
    }
    made.location = llvm::DILocation::get(parent.scope->getContext(), from.line, 0, parent.scope,
                                          parent.inlinedAt);
    for (const DwarfPlace& place : from.places) {
        const auto reg = registers_.find(place.name);
        if (place.isRegister && reg == registers_.end())
            continue;
        made.places.push_back({&place, place.isRegister ? reg->second : ~0u,
                               place.isRegister && place.begin.empty()});
    }
    if (!made.places.empty())
        variables_.push_back(std::move(made));
}

FunctionDebug::Scope FunctionDebug::enterInlined(const DwarfInlined& inlined, Scope parent) {
    llvm::LLVMContext& context = parent.scope->getContext();
    if (inlined.callFile != 0)
        if (llvm::DIFile* file = info_.file(module_, inlined.callFile);
            file != parent.scope->getFile())
            parent.scope = info_.builder().createLexicalBlockFile(parent.scope, file);
    return {
        info_.inlinedFunction(module_, inlined.name, inlined.file, inlined.line, inlined.origin),
        llvm::DILocation::getDistinct(context, inlined.callLine, inlined.callColumn, parent.scope,
                                      parent.inlinedAt)};
}

void FunctionDebug::addScope(const DwarfScope& scope, Scope parent, unsigned& parameters) {
    for (const DwarfVariable& variable : scope.variables)
        addVariable(variable, parent, parameters);
    for (const DwarfScope& inner : scope.scopes) {
        Scope entered = parent;
        unsigned* counted = &parameters;
        if (inner.inlined) {
            entered = enterInlined(*inner.inlined, parent);
            counted = &info_.inlinedParameters(entered.scope->getSubprogram());
        } else {
            const DwarfVariable* first = inner.variables.empty() ? nullptr : &inner.variables[0];
            const uint32_t line = first ? first->line : parent.scope->getSubprogram()->getLine();
            llvm::DIFile* file =
                first && first->file ? info_.file(module_, first->file) : parent.scope->getFile();
            entered.scope = info_.builder().createLexicalBlock(parent.scope, file, line, 0);
        }
        for (const auto& [begin, end] : inner.ranges) {
            begins_[begin].push_back(entered);
            ends_[end].push_back(entered);
        }
        addScope(inner, entered, *counted);
    }
}

void FunctionDebug::setLocation(llvm::IRBuilder<>& builder, const ptx::SourcePosition& source,
                                uint32_t textLine) {
    if (!subprogram_)
        return;
    Scope in = open_.back();
    const uint32_t call =
        source.line != 0 && !in.inlinedAt ? info_.inlinedCalls(module_).at(textLine) : 0;
    if (call != 0) {
        const DebugInfo::InlinedScope inlined =
            info_.inlinedScope(module_, call, source, subprogram_);
        in = {inlined.function, inlined.at};
    }
    const uint32_t line = source.line ? source.line : in.scope->getSubprogram()->getLine();
    if (source.line != 0 && source.file != 0) {
        // Code of another file, inlined before the PTX was written.
        llvm::DIFile* file = info_.file(module_, source.file);
        if (file != in.scope->getFile())
            in.scope = info_.builder().createLexicalBlockFile(in.scope, file);
    }
    builder.SetCurrentDebugLocation(llvm::DILocation::get(subprogram_->getContext(), line,
                                                          source.column, in.scope, in.inlinedAt));
}

void FunctionDebug::atMemory(std::string_view name, llvm::Value* memory, llvm::BasicBlock* block) {
    for (const Variable& variable : variables_)
        for (const Place& place : variable.places) {
            if (place.dwarf->isRegister || place.dwarf->name != name)
                continue;
            llvm::SmallVector<uint64_t, 2> steps;
            if (place.dwarf->offset != 0)
                steps = {llvm::dwarf::DW_OP_plus_uconst, place.dwarf->offset};
            info_.builder().insertDeclare(memory, variable.variable,
                                          info_.builder().createExpression(steps),
                                          variable.location, block);
            break; // a place in memory holds for the whole scope
        }
}

std::vector<uint32_t> FunctionDebug::atLabel(std::string_view label) {
    std::vector<uint32_t> registers;
    if (!subprogram_)
        return registers;
    if (const auto found = ends_.find(label); found != ends_.end())
        for (const Scope& scope : found->second)
            std::erase(open_, scope);
    if (const auto found = begins_.find(label); found != begins_.end())
        open_.insert(open_.end(), found->second.begin(), found->second.end());
    for (Variable& variable : variables_)
        for (Place& place : variable.places) {
            if (!place.dwarf->isRegister || place.dwarf->begin.empty())
                continue;
            if (place.dwarf->end == label)
                place.active = false;
            if (place.dwarf->begin == label) {
                place.active = true;
                registers.push_back(place.reg);
            }
        }
    return registers;
}

void FunctionDebug::atValue(llvm::IRBuilder<>& builder, uint32_t reg, llvm::Value* value) {
    for (const Variable& variable : variables_)
        for (const Place& place : variable.places)
            if (place.active && place.reg == reg)
                info_.builder().insertDbgValueIntrinsic(
                    value, variable.variable, info_.builder().createExpression(), variable.location,
                    builder.GetInsertBlock());
}

} // namespace sunstone::compiler
