// SPDX-License-Identifier: Apache-2.0
// Variables without their entry points.
#include "api/optix6/variable.h"

#include "api/optix6/scene.h"

#include <algorithm>
#include <cstring>

namespace sunstone::optix6 {

RTobjecttype typeOf(const Object& object) {
    switch (object.kind) {
    case Kind::kGroup:
        return RT_OBJECTTYPE_GROUP;
    case Kind::kGeometryGroup:
        return RT_OBJECTTYPE_GEOMETRY_GROUP;
    case Kind::kTransform:
        return RT_OBJECTTYPE_TRANSFORM;
    case Kind::kSelector:
        return RT_OBJECTTYPE_SELECTOR;
    case Kind::kGeometryInstance:
        return RT_OBJECTTYPE_GEOMETRY_INSTANCE;
    case Kind::kBuffer:
        return RT_OBJECTTYPE_BUFFER;
    case Kind::kTextureSampler:
        return RT_OBJECTTYPE_TEXTURE_SAMPLER;
    case Kind::kProgram:
        return RT_OBJECTTYPE_PROGRAM;
    case Kind::kCommandList:
        return RT_OBJECTTYPE_COMMANDLIST;
    case Kind::kPostProcessingStage:
        return RT_OBJECTTYPE_POSTPROCESSINGSTAGE;
    default:
        return RT_OBJECTTYPE_UNKNOWN;
    }
}

bool isNode(Kind kind) {
    return kind == Kind::kGroup || kind == Kind::kGeometryGroup || kind == Kind::kTransform ||
           kind == Kind::kSelector;
}

namespace {

bool isNodeType(RTobjecttype type) {
    return type >= RT_OBJECTTYPE_GROUP && type <= RT_OBJECTTYPE_SELECTOR;
}

} // namespace

void Variable::set(RTobjecttype wanted, const void* data, size_t size) {
    const std::shared_ptr<Context> owner = context();
    if (type != RT_OBJECTTYPE_UNKNOWN && (type != wanted || bytes.size() != size))
        refuse(RT_ERROR_TYPE_MISMATCH, "variable \"", name,
               "\" has a value of another type or size");
    const bool isNew = type == RT_OBJECTTYPE_UNKNOWN;
    type = wanted;
    bytes.assign(static_cast<const uint8_t*>(data), static_cast<const uint8_t*>(data) + size);
    if (isNew && isSeen())
        owner->noteStructure();
    writeUsers();
}

bool Variable::isRead() const {
    return !scoped_ || context()->isRead(name);
}

// The scene searches the variables of all objects for nodes and samplers.
bool Variable::isSeen() const {
    const std::shared_ptr<Object> value = object.lock();
    const bool isSearched =
        !scoped_ || (value && (isNode(value->kind) || value->kind == Kind::kTextureSampler));
    return (isSearched || scoped_->isInScene) && isRead();
}

void Variable::releaseBuffer() {
    if (const auto known = object.lock(); known && known->kind == Kind::kBuffer)
        static_cast<Buffer&>(*known).removeHolder(*this);
}

void Variable::writeUsers() const {
    for (const User& user : users)
        user.block->write(user.index);
}

void Variable::set(const std::shared_ptr<Object>& value) {
    const RTobjecttype wanted = typeOf(*value);
    const bool fits =
        type == RT_OBJECTTYPE_UNKNOWN || type == wanted || (isNodeType(type) && isNodeType(wanted));
    if (!fits)
        refuse(RT_ERROR_TYPE_MISMATCH, "variable \"", name, "\" has a value of another type");
    if (value->kind != Kind::kBuffer && object.lock() == value)
        return;
    // Replacing a buffer by one of the same shape changes nothing else. A buffer that only OpenGL
    // may use is found when scopes are searched.
    bool isStructure = true;
    if (value->kind == Kind::kBuffer) {
        const auto& buffer = static_cast<const Buffer&>(*value);
        const std::shared_ptr<Object> known = object.lock();
        isStructure = !known || !buffer.isRegistered() ||
                      !buffer.hasShapeOf(static_cast<const Buffer&>(*known));
    }
    const bool wasSeen = isSeen();
    releaseBuffer();
    type = wanted;
    object = value;
    if (value->kind == Kind::kBuffer)
        static_cast<Buffer&>(*value).addHolder(*this);
    if (isStructure && (wasSeen || isSeen()))
        return context()->noteStructure();
    writeUsers();
}

void Variable::get(RTobjecttype wanted, void* data, size_t size) const {
    if (type != wanted || bytes.size() != size)
        refuse(RT_ERROR_TYPE_MISMATCH, "variable \"", name,
               type == RT_OBJECTTYPE_UNKNOWN ? "\" has no value"
                                             : "\" has a value of another type");
    std::memcpy(data, bytes.data(), size);
}

std::shared_ptr<Variable> Scope::find(const std::string& name) const {
    if (byName_) {
        const auto found = byName_->find(name);
        return found == byName_->end() ? nullptr : found->second;
    }
    for (const std::shared_ptr<Variable>& variable : list_)
        if (variable->name == name)
            return variable;
    return nullptr;
}

void Scope::add(const std::shared_ptr<Variable>& variable) {
    constexpr size_t kFew = 16;
    list_.push_back(variable);
    if (byName_) {
        byName_->emplace(variable->name, variable);
    } else if (list_.size() > kFew) {
        byName_ = std::make_unique<Table>();
        for (const std::shared_ptr<Variable>& each : list_)
            byName_->emplace(each->name, each);
    }
}

bool Scope::remove(const std::shared_ptr<Variable>& variable) {
    const auto found = std::find(list_.begin(), list_.end(), variable);
    if (found == list_.end())
        return false;
    list_.erase(found);
    if (byName_)
        byName_->erase(variable->name);
    return true;
}

void Scope::assign(const std::vector<std::shared_ptr<Variable>>& list) {
    list_.clear();
    byName_ = nullptr;
    for (const std::shared_ptr<Variable>& variable : list)
        add(variable);
}

bool isVariableName(const std::string& name) {
    bool atStart = true;
    for (size_t i = 0; i < name.size(); ++i) {
        const char c = name[i];
        if (c == ':' && !atStart && i + 1 < name.size() && name[i + 1] == ':') {
            ++i;
            atStart = true;
            continue;
        }
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
        if (!letter && (atStart || c < '0' || c > '9'))
            return false;
        atStart = false;
    }
    return !atStart;
}

} // namespace sunstone::optix6
