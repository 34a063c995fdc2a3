// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/remote/scene_sender.h"

#include "api/optix6/remote/fields.h"

#include <algorithm>

namespace sunstone::optix6 {

namespace {

uint64_t numberOf(const Object& object) {
    return reinterpret_cast<uint64_t>(object.handle());
}

template <class T>
T& as(Object& object) {
    return static_cast<T&>(object);
}

// Writes the data that a copy needs to create the object, before its fields.
void writeMake(Writer& a, Object& object) {
    if (object.kind == Kind::kBuffer)
        a.all(as<Buffer>(object).description);
    if (object.kind == Kind::kProgram)
        a.all(as<Program>(object).code->module->source->digest(),
              as<Program>(object).code->function);
}

void writeFields(Writer& a, Object& object) {
    switch (object.kind) {
    case Kind::kBuffer: {
        const auto& buffer = as<Buffer>(object);
        a.all(buffer.format, buffer.view().elementBytes, buffer.dimensions, buffer.mipLevels);
        for (unsigned i = 0; i < 3; ++i)
            a.all(buffer.extent(i, 0));
        return;
    }
    case Kind::kAcceleration: {
        const auto& acceleration = as<Acceleration>(object);
        return a.all(acceleration.builder, acceleration.properties, acceleration.version);
    }
    case Kind::kTextureSampler:
        return fields(a, as<TextureSampler>(object));
    case Kind::kGeometry:
        return fields(a, as<Geometry>(object));
    case Kind::kGeometryTriangles:
        return fields(a, as<GeometryTriangles>(object));
    case Kind::kMaterial:
        return fields(a, as<Material>(object));
    case Kind::kGeometryInstance:
        return fields(a, as<GeometryInstance>(object));
    case Kind::kGeometryGroup:
        return fields(a, as<GeometryGroup>(object));
    case Kind::kGroup:
        return fields(a, as<Group>(object));
    case Kind::kSelector:
        return fields(a, as<Selector>(object));
    case Kind::kTransform:
        return fields(a, as<Transform>(object));
    default:
        return;
    }
}

bool hasScope(Kind kind) {
    return kind == Kind::kProgram || kind == Kind::kGeometry || kind == Kind::kGeometryTriangles ||
           kind == Kind::kMaterial || kind == Kind::kGeometryInstance || isNode(kind);
}

} // namespace

void SceneSender::note(const std::shared_ptr<Object>& object) {
    if (seen_.insert(numberOf(*object)).second)
        queue_.push_back(object);
}

std::string SceneSender::changes(Context& context) {
    seen_.clear();
    queue_.clear();
    Writer out;
    Writer own([this](const std::shared_ptr<Object>& object) { note(object); });
    fields(own, context);
    Sent& sent = sent_[kContextNumber];
    seen_.insert(kContextNumber);
    const bool isNew = sent.fields != own.bytes;
    Writer scope;
    writeScope(scope, kContextNumber, context, sent);
    while (!queue_.empty()) {
        const std::shared_ptr<Object> object = std::move(queue_.back());
        queue_.pop_back();
        writeObject(out, *object);
    }
    if (isNew)
        out.all(Record::kContext, sent.fields = std::move(own.bytes));
    out.bytes += scope.bytes;
    std::erase_if(sent_, [&](const auto& entry) {
        if (seen_.count(entry.first))
            return false;
        out.all(Record::kGone, entry.first);
        return true;
    });
    return std::move(out.bytes);
}

void SceneSender::writeObject(Writer& out, Object& object) {
    const uint64_t number = numberOf(object);
    Sent& sent = sent_[number];
    Writer make, own([this](const std::shared_ptr<Object>&other) { note(other); });
    writeMake(make, object);
    writeFields(own, object);
    if (object.kind == Kind::kProgram)
        writeText(out, *as<Program>(object).code);
    if (sent.version == ~uint64_t(0) || sent.fields != own.bytes) {
        out.all(Record::kObject, number, object.kind, make.bytes, own.bytes);
        sent.fields = std::move(own.bytes);
        sent.hash = 0; // a newly made buffer is empty
        if (object.kind != Kind::kBuffer)
            sent.version = 0;
    }
    if (object.kind == Kind::kBuffer)
        writeContents(out, as<Buffer>(object), sent);
    if (hasScope(object.kind))
        writeScope(out, number, static_cast<Scoped&>(object), sent);
}

void SceneSender::writeText(Writer& out, const ProgramCode& code) {
    const std::string& digest = code.module->source->digest();
    if (texts_.insert(digest).second)
        out.all(Record::kText, digest, *code.text);
}

void SceneSender::writeScope(Writer& out, uint64_t number, const Scoped& object, Sent& sent) {
    Writer own([this](const std::shared_ptr<Object>& other) { note(other); });
    own.all(uint64_t(object.scope.list().size()));
    for (const std::shared_ptr<Variable>& variable : object.scope.list())
        own.all(variable->name, variable->type, variable->bytes, variable->object);
    if (sent.scope == own.bytes)
        return;
    out.all(Record::kScope, number, own.bytes);
    sent.scope = std::move(own.bytes);
}

// Contents of output buffers and streams are not sent: only programs write the former, and streams
// belong to the host.
void SceneSender::writeContents(Writer& out, const Buffer& buffer, Sent& sent) {
    const bool isOld = sent.version == buffer.version();
    sent.version = buffer.version();
    if (buffer.stream || buffer.typeBits() == RT_BUFFER_OUTPUT || !buffer.data() ||
        (isOld && !buffer.changesUnseen()))
        return;
    std::string bytes(buffer.bytes(), '\0');
    buffer.read(bytes.data());
    const uint64_t hash = std::hash<std::string>()(bytes) | 1;
    if (hash == sent.hash)
        return;
    sent.hash = hash;
    out.all(Record::kContents, numberOf(buffer), bytes);
}

} // namespace sunstone::optix6
