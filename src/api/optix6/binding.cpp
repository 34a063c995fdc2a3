// SPDX-License-Identifier: Apache-2.0
// Binds programs to scopes: finds the variable that a program reads, and fills the block with the
// values.
#include "api/optix6/scene.h"

#include <algorithm>
#include <cstring>
#include <functional>

namespace sunstone::optix6 {

using compiler::ProgramKind;
using compiler::optix6::DeviceVariable;
using compiler::optix6::VariableUse;

namespace {

bool isBoundProgram(const DeviceVariable& variable) {
    return variable.typeEnum == compiler::optix6::kTypeBoundProgram;
}

// The same for a buffer. A buffer without elements fits every access.
std::string mismatch(const DeviceVariable& wanted, const Buffer& given) {
    const devlib::BufferView& view = given.view();
    if (!view.data || view.size[0] == 0)
        return {};
    if (wanted.elementBytes != 0 && wanted.elementBytes != view.elementBytes)
        return message("has elements of ", view.elementBytes, " bytes, but the program's have ",
                       wanted.elementBytes);
    if (wanted.dimensions != 0 && wanted.dimensions <= 3 && wanted.dimensions != view.dimensions)
        return message("has ", view.dimensions, " dimensions, but the program's has ",
                       wanted.dimensions);
    return {};
}

enum class Numbers { kUnknown, kFloats, kIntegers };

// By the name of the type in the program's source; typedefs stay unknown.
Numbers numbersOf(std::string_view typeName) {
    std::string_view name = typeName;
    if (name == "unsigned int" || name == "unsigned")
        return Numbers::kIntegers;
    if (!name.empty() && name.back() >= '1' && name.back() <= '4')
        name.remove_suffix(1);
    return name == "float"                   ? Numbers::kFloats
           : name == "int" || name == "uint" ? Numbers::kIntegers
                                             : Numbers::kUnknown;
}
Numbers numbersOf(RTobjecttype type) {
    switch (type) {
    case RT_OBJECTTYPE_FLOAT:
    case RT_OBJECTTYPE_FLOAT2:
    case RT_OBJECTTYPE_FLOAT3:
    case RT_OBJECTTYPE_FLOAT4:
        return Numbers::kFloats;
    case RT_OBJECTTYPE_INT:
    case RT_OBJECTTYPE_INT2:
    case RT_OBJECTTYPE_INT3:
    case RT_OBJECTTYPE_INT4:
    case RT_OBJECTTYPE_UNSIGNED_INT:
    case RT_OBJECTTYPE_UNSIGNED_INT2:
    case RT_OBJECTTYPE_UNSIGNED_INT3:
    case RT_OBJECTTYPE_UNSIGNED_INT4:
        return Numbers::kIntegers;
    default:
        return Numbers::kUnknown;
    }
}

// Why a host variable cannot be the value of a program's variable; empty if it can.
std::string mismatch(const DeviceVariable& wanted, const Variable& given) {
    const std::shared_ptr<Object> object = given.object.lock();
    const auto needs = [&](bool fits, const char* what) {
        return fits ? std::string() : message("needs a ", what);
    };
    if (wanted.use == VariableUse::kBuffer)
        return object && object->kind == Kind::kBuffer
                   ? mismatch(wanted, static_cast<const Buffer&>(*object))
                   : needs(false, "buffer");
    if (wanted.use == VariableUse::kTexture)
        return needs(object && object->kind == Kind::kTextureSampler, "texture sampler");
    if (isBoundProgram(wanted))
        return needs(object && object->kind == Kind::kProgram, "program");
    if (object)
        return isNode(object->kind) && wanted.bytes == 4
                   ? std::string()
                   : message("needs data, not a ", nameOf(object->kind),
                             object->kind == Kind::kProgram
                                 ? ": its id, from rtProgramGetId, is the value"
                                 : "");
    if (given.bytes.size() != wanted.bytes)
        return message("has ", given.bytes.size(), " bytes, but the program's has ", wanted.bytes);
    const Numbers there = numbersOf(given.type), here = numbersOf(wanted.typeName);
    if (there != here && there != Numbers::kUnknown && here != Numbers::kUnknown)
        return message("has ", here == Numbers::kFloats ? "integers" : "floats",
                       ", but the program's has the type ", wanted.typeName);
    return {};
}

bool callsBound(const Program& program) {
    const auto& list = program.code->variables.list;
    return std::any_of(list.begin(), list.end(), isBoundProgram);
}

// Variables without a value hide none.
template <class Condition>
bool anyValue(const Scope& scope, const Condition& condition) {
    return std::any_of(scope.list().begin(), scope.list().end(), [&](const auto& variable) {
        return variable->type != RT_OBJECTTYPE_UNKNOWN && condition(variable->name);
    });
}

bool hasValue(const Scope& scope, const std::string& name) {
    const std::shared_ptr<Variable> found = scope.find(name);
    return found && found->type != RT_OBJECTTYPE_UNKNOWN;
}

// One form of all lists of scopes in which each search has the same result: it lacks the scopes
// whose variables are all hidden, and scopes without common names are in order of their addresses.
std::vector<const Scope*> canonical(const std::vector<const Scope*>& scopes) {
    std::vector<const Scope*> made;
    for (const Scope* scope : scopes) {
        const bool isVisible = anyValue(*scope, [&](const std::string& name) {
            return std::none_of(made.begin(), made.end(),
                                [&](const Scope* before) { return hasValue(*before, name); });
        });
        if (!isVisible)
            continue;
        auto first = made.end(); // the scope may go before each scope from here on
        while (first != made.begin() && !anyValue(*scope, [&](const std::string& name) {
                   return hasValue(**std::prev(first), name);
               }))
            --first;
        const auto place = std::find_if(
            first, made.end(), [&](const Scope* other) { return std::less<>()(scope, other); });
        made.insert(place, scope);
    }
    return made;
}

} // namespace

std::shared_ptr<Variable> Scene::resolve(const DeviceVariable& wanted, const ProgramCode& code,
                                         const Scopes& scopes) const {
    // Variables without a value hide none: OptiXpp declares each variable that an application
    // queries.
    std::shared_ptr<Variable> found;
    for (const Scope* scope : scopes) {
        if (const auto declared = scope->find(wanted.name))
            found = declared;
        if (found && found->type != RT_OBJECTTYPE_UNKNOWN)
            break;
    }
    const bool isUnset = !found || (found->type == RT_OBJECTTYPE_UNKNOWN) ||
                         (found->bytes.empty() && found->object.expired());
    if (isUnset && wanted.declaration->hasInitializer)
        return nullptr;
    if (isUnset)
        refuse(RT_ERROR_VARIABLE_NOT_FOUND, "variable \"", wanted.name, "\" of program \"",
               code.name, "\" ", found ? "has no value" : "is declared in none of its scopes");
    const std::string problem = mismatch(wanted, *found);
    if (!problem.empty())
        refuse(RT_ERROR_TYPE_MISMATCH, "variable \"", wanted.name, "\" of program \"", code.name,
               "\" ", problem);
    if (const auto object = found->object.lock(); object && object->kind == Kind::kBuffer) {
        const auto& buffer = static_cast<const Buffer&>(*object);
        buffer.requireRegistered();
        if (const std::string what = buffer.missing(); !what.empty())
            refuse(RT_ERROR_INVALID_CONTEXT, "the buffer of variable \"", wanted.name,
                   "\" of program \"", code.name, "\" has ", what);
    }
    return found;
}

void Block::write(uint32_t index) {
    const DeviceVariable& wanted = code->variables.list[index];
    uint8_t* const place = slot(index);
    const Variable* const variable = found[index].get();
    if (!variable) { // its initialiser
        const auto& bytes = wanted.declaration->initializer;
        std::memcpy(place, bytes.data(), std::min<size_t>(bytes.size(), wanted.bytes));
        return;
    }
    const std::shared_ptr<Object> object = variable->object.lock();
    if (!object) {
        std::memcpy(place, variable->bytes.data(),
                    std::min<size_t>(variable->bytes.size(), wanted.bytes));
    } else if (object->kind == Kind::kBuffer) {
        const devlib::BufferView& view = static_cast<Buffer&>(*object).view();
        std::memcpy(place, &view, sizeof view);
    } else if (object->kind == Kind::kTextureSampler) {
        const uint64_t handle = static_cast<TextureSampler&>(*object).texture;
        std::memcpy(place, &handle, sizeof handle);
    } else if (object->kind != Kind::kProgram) {
        const uint32_t id = static_cast<Node&>(*object).id;
        std::memcpy(place, &id, sizeof id);
    }
}

// The scopes in which the program searches for its variables, for a caller with these scopes. They
// name each scope once, and no program without variables, so that programs that call each other
// have a limited number of them.
Scene::Scopes Scene::withOwn(const Program& program, Scopes scopes) {
    if (program.scope.list().empty())
        return scopes;
    std::erase(scopes, &program.scope);
    scopes.insert(scopes.begin(), &program.scope);
    return scopes;
}

// The memory of the program's block in these scopes, after its own scope.
const void* Scene::block(const Program& program, Scopes scopes) {
    program.isInScene = true;
    scopes = withOwn(program, std::move(scopes));
    const ProgramCode& code = *program.code;
    std::vector<std::shared_ptr<Variable>> found;
    std::vector<Variable*> key;
    bool bindsPrograms = false;
    for (const DeviceVariable& wanted : code.variables.list) {
        found.push_back(wanted.isScoped() ? resolve(wanted, code, scopes) : nullptr);
        key.push_back(found.back().get());
        bindsPrograms |= wanted.isScoped() && isBoundProgram(wanted);
    }
    // Bound programs see the scopes of their caller, so no other caller shares the block.
    if (bindsPrograms)
        key.push_back(reinterpret_cast<Variable*>(blocks_.size() + 1));
    std::unique_ptr<Block>& entry = blocks_[{&code, key}];
    if (entry)
        return entry->memory;
    entry = std::make_unique<Block>();
    Block& block = *entry;
    block.code = program.code;
    block.found = std::move(found);
    block.memory =
        blockMemory_.take(context_.engine->backend, std::max(64u, code.variables.blockBytes));
    for (uint32_t i = 0; i < block.found.size(); ++i) {
        const DeviceVariable& wanted = code.variables.list[i];
        if (!wanted.isScoped())
            continue;
        Variable* const variable = block.found[i].get();
        if (variable)
            variable->users.push_back({&block, i});
        if (variable && isBoundProgram(wanted)) {
            const auto callee = std::static_pointer_cast<Program>(variable->object.lock());
            const int id = boundCallable(*callee, scopes);
            std::memcpy(block.slot(i), &id, sizeof id);
        } else {
            block.write(i);
        }
    }
    return block.memory;
}

// The number by which a variable calls the program. The program's variables are searched in its own
// scope, then in those of the caller. The program may call itself through its variables, so its
// number is known before its block.
int Scene::boundCallable(const Program& program, Scopes scopes) {
    scopes = withOwn(program, std::move(scopes));
    if (callsBound(program))
        scopes = canonical(scopes);
    const auto [known, isNew] =
        boundCallables_.try_emplace({&program, scopes}, int(callables_.size()));
    const int number = known->second;
    if (!isNew) {
        bindsCycle_ |= callables_[size_t(number)].blocks[devlib::kBlockMain] == nullptr;
        return number;
    }
    // Programs that are bound to each other may search in many orders of their scopes.
    constexpr size_t kDeepest = 256, kMostOfOne = 20000;
    if (boundDepth_ == 0)
        boundBefore_ = callables_.size();
    if (boundDepth_ > kDeepest)
        refuse(RT_ERROR_INVALID_VALUE, "the chain of bound programs that call program \"",
               program.code->name, "\" is longer than ", kDeepest);
    if (callables_.size() - boundBefore_ > kMostOfOne)
        refuse(RT_ERROR_INVALID_VALUE, "program \"", program.code->name, "\" is in more than ",
               kMostOfOne, " chains of bound programs that call each other");
    checkKind(program, ProgramKind::kDirectCallable, "the bound program");
    callables_.emplace_back();
    ++boundDepth_;
    const void* const memory = block(program, scopes);
    --boundDepth_;
    devlib::ClassicRecord made = record(
        devlib::kGroupCallables, {{devlib::kRoleDirect, &program, ProgramKind::kDirectCallable}});
    made.blocks[devlib::kBlockMain] = memory;
    callables_[size_t(number)] = made;
    return number;
}

// A record of the group with these programs, without blocks.
devlib::ClassicRecord Scene::record(devlib::GroupKind kind,
                                    const std::vector<RoleProgram>& programs) {
    GroupKey key{kind, {}};
    for (const RoleProgram& each : programs)
        if (each.program) {
            key.second[each.role] = each.program->code.get();
            each.program->isInScene = true;
        }
    BoundGroup& bound = groups_[key];
    bound.bind = bind_;
    bound.pipeline = pipelines_;
    std::shared_ptr<engine::ProgramGroup>& group = bound.group;
    if (!group) {
        group = std::make_shared<engine::ProgramGroup>();
        group->number = context_.engine->nextGroup++;
        group->kind = kind;
        for (const RoleProgram& each : programs)
            if (each.program) {
                group->programs[each.role] = {each.program->code->module,
                                              each.program->code->function, each.kind, -1};
                bound.codes.push_back(each.program->code);
            }
        needsPipeline_ = true;
    }
    devlib::ClassicRecord made{};
    engine::packSbtHeader(*group, &made.header);
    return made;
}

} // namespace sunstone::optix6
