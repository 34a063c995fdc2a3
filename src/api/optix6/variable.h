// SPDX-License-Identifier: Apache-2.0
// Variables and the scopes that hold them. The first value of a variable fixes its type.
#pragma once

#include "api/optix6/object.h"

#include <memory>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace sunstone::optix6 {

struct Block;

class Variable : public Object {
public:
    static constexpr Kind kKind = Kind::kVariable;
    // `scoped`: the object that has the variable; null for a variable that the scene reads.
    Variable(const std::shared_ptr<Context>& context, std::string name_,
             const Object* scoped = nullptr)
        : Object(kKind, context), name(std::move(name_)), scoped_(scoped) {}
    ~Variable() override { releaseBuffer(); }

    // Sets plain data. Throws RT_ERROR_TYPE_MISMATCH if the variable has another type.
    void set(RTobjecttype wanted, const void* data, size_t size);
    void set(const std::shared_ptr<Object>& object);
    // Copies plain data of this type.
    void get(RTobjecttype wanted, void* data, size_t size) const;

    const std::string name;
    RTobjecttype type = RT_OBJECTTYPE_UNKNOWN;
    std::vector<uint8_t> bytes; // of plain data
    Ref<Object> object;         // of the other types
    // Copies of the value for programs, maintained by the scene.
    struct User {
        Block* block;
        uint32_t index; // of the program's variable
    };
    std::vector<User> users;
    void writeUsers() const;
    // Whether the scene may depend on the variable.
    bool isSeen() const;
    // Whether a program has a variable with this name.
    bool isRead() const;

private:
    const Object* const scoped_; // owns the variable as long as calls can refer to it
    void releaseBuffer(); // the buffer that is the value
};

RTobjecttype typeOf(const Object& object);
bool isNode(Kind kind);

class Scope {
public:
    std::shared_ptr<Variable> find(const std::string& name) const;
    const std::vector<std::shared_ptr<Variable>>& list() const { return list_; }
    void add(const std::shared_ptr<Variable>& variable);
    // False: the scope does not have the variable.
    bool remove(const std::shared_ptr<Variable>& variable);
    void assign(const std::vector<std::shared_ptr<Variable>>& list);

private:
    std::vector<std::shared_ptr<Variable>> list_;
    // Null as long as there are few variables.
    using Table = std::unordered_map<std::string_view, std::shared_ptr<Variable>>;
    std::unique_ptr<Table> byName_;
};

// An object with variables.
class Scoped : public Object {
public:
    using Object::Object;
    Scope scope;
};

// Whether a name may be that of a variable: C identifiers, joined by "::".
bool isVariableName(const std::string& name);

} // namespace sunstone::optix6
