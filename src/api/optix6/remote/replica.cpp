// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/remote/replica.h"

#include "api/optix6/call.h"
#include "api/optix6/remote/fields.h"
#include "api/optix6/remote/scene_sender.h"
#include "api/optix6/scene.h"

#include <algorithm>

namespace sunstone::optix6 {

Replica::Replica(unsigned device) : context_(std::make_shared<Context>()) {
    context_->setDevice(int(device % deviceCount()));
    context_->scene = std::make_unique<Scene>(*context_);
}

Replica::~Replica() {
    objects_.clear();
    context_->scene = nullptr;
}

std::shared_ptr<Object> Replica::find(uint64_t number) const {
    const auto found = objects_.find(number);
    return found == objects_.end() ? nullptr : found->second;
}

// body(record, in, number): reads the rest of a record after its number.
template <class Body>
void Replica::forEachRecord(std::string_view changes, const Body& body) {
    Reader in(changes);
    while (!in.atEnd()) {
        const auto record = in.get<Record>();
        const auto number =
            record == Record::kText || record == Record::kContext ? 0 : in.get<uint64_t>();
        body(record, in, number);
    }
}

// Objects refer to later ones, so all are created before any is filled.
void Replica::apply(std::string_view changes) {
    const auto finder = [this](uint64_t number) { return find(number); };
    forEachRecord(changes, [&](Record record, Reader& in, uint64_t number) {
        if (record == Record::kText) {
            const auto digest = in.get<std::string>();
            texts_[digest] = in.get<std::string>();
        } else if (record == Record::kObject) {
            const auto kind = in.get<Kind>();
            const auto make = in.get<std::string>();
            in.get<std::string>();
            Reader from(make);
            if (!objects_.count(number))
                create(from, number, kind);
        } else if (record == Record::kScope || record == Record::kContents ||
                   record == Record::kContext) {
            in.get<std::string>();
        }
    });
    forEachRecord(changes, [&](Record record, Reader& in, uint64_t number) {
        if (record == Record::kText) {
            in.get<std::string>();
            in.get<std::string>();
            return;
        }
        if (record == Record::kGone) {
            objects_.erase(number);
            return context_->noteStructure();
        }
        if (record == Record::kObject) {
            in.get<Kind>();
            in.get<std::string>();
        }
        const auto bytes = in.get<std::string>();
        Reader from(bytes, finder);
        if (record == Record::kContext) {
            fields(from, *context_);
            return context_->noteStructure();
        }
        const auto object =
            number == kContextNumber ? std::shared_ptr<Object>(context_) : find(number);
        if (!object)
            fail(Code::kInternal, "a message between ranks names an unknown object");
        if (record == Record::kScope)
            readScope(from, static_cast<Scoped&>(*object));
        else if (record == Record::kContents)
            static_cast<Buffer&>(*object).write(bytes);
        else
            readFields(from, *object);
    });
}

void Replica::create(Reader& in, uint64_t number, Kind kind) {
    const auto made = [&]() -> std::shared_ptr<Object> {
        switch (kind) {
        case Kind::kBuffer: {
            const auto buffer = std::make_shared<Buffer>(context_, in.get<unsigned>());
            context_->allBuffers.push_back(buffer);
            return buffer;
        }
        case Kind::kProgram: {
            const auto digest = in.get<std::string>();
            const auto name = in.get<std::string>();
            return std::make_shared<Program>(context_, context_->load({texts_.at(digest)}, name));
        }
        case Kind::kTextureSampler:
            return std::make_shared<TextureSampler>(context_);
        case Kind::kGeometry:
            return std::make_shared<Geometry>(context_);
        case Kind::kGeometryTriangles:
            return std::make_shared<GeometryTriangles>(context_);
        case Kind::kMaterial:
            return std::make_shared<Material>(context_);
        case Kind::kGeometryInstance:
            return std::make_shared<GeometryInstance>(context_);
        case Kind::kAcceleration:
            return std::make_shared<Acceleration>(context_);
        case Kind::kGeometryGroup:
            return std::make_shared<GeometryGroup>(context_);
        case Kind::kGroup:
            return std::make_shared<Group>(context_);
        case Kind::kSelector:
            return std::make_shared<Selector>(context_);
        case Kind::kTransform:
            return std::make_shared<Transform>(context_);
        default:
            fail(Code::kInternal, "a message between ranks has an object of kind ", unsigned(kind));
        }
    }();
    if (isNode(kind))
        static_cast<Node&>(*made).enlist();
    objects_[number] = made;
}

void Replica::readFields(Reader& in, Object& object) {
    switch (object.kind) {
    case Kind::kBuffer:
        return readBuffer(in, static_cast<Buffer&>(object));
    case Kind::kAcceleration: {
        auto& acceleration = static_cast<Acceleration&>(object);
        in.all(acceleration.builder, acceleration.properties);
        acceleration.dirty = true; // its own version, or one of the three, has changed
        break;
    }
    case Kind::kTextureSampler:
        fields(in, static_cast<TextureSampler&>(object));
        static_cast<TextureSampler&>(object).noteChange();
        break;
    case Kind::kGeometry:
        fields(in, static_cast<Geometry&>(object));
        break;
    case Kind::kGeometryTriangles:
        fields(in, static_cast<GeometryTriangles&>(object));
        break;
    case Kind::kMaterial:
        fields(in, static_cast<Material&>(object));
        break;
    case Kind::kGeometryInstance:
        fields(in, static_cast<GeometryInstance&>(object));
        break;
    case Kind::kGeometryGroup:
        fields(in, static_cast<GeometryGroup&>(object));
        break;
    case Kind::kGroup:
        fields(in, static_cast<Group&>(object));
        break;
    case Kind::kSelector:
        fields(in, static_cast<Selector&>(object));
        break;
    case Kind::kTransform:
        fields(in, static_cast<Transform&>(object));
        break;
    default:
        break;
    }
    context_->noteStructure();
}

void Replica::readBuffer(Reader& in, Buffer& buffer) {
    const auto format = in.get<RTformat>();
    const auto elementBytes = in.get<uint32_t>();
    const auto dimensions = in.get<unsigned>();
    const auto levels = in.get<unsigned>();
    RTsize extents[3];
    for (RTsize& extent : extents)
        extent = in.get<uint64_t>();
    if (dimensions > 3)
        fail(Code::kInternal, "a message between ranks has a buffer of ", dimensions,
             " dimensions");
    if (format != RT_FORMAT_UNKNOWN)
        buffer.setFormat(format);
    if (format == RT_FORMAT_USER && elementBytes != 0)
        buffer.setElementSize(elementBytes);
    if (dimensions != 0)
        buffer.setSize(dimensions, extents);
    buffer.setMipLevels(levels);
}

void Replica::readScope(Reader& in, Scoped& object) {
    std::vector<std::shared_ptr<Variable>> list;
    bool isStructure = false;
    const auto count = in.get<uint64_t>();
    for (uint64_t i = 0; i < count; ++i) {
        const auto name = in.get<std::string>();
        const auto type = in.get<RTobjecttype>();
        const auto bytes = in.get<std::vector<uint8_t>>();
        Ref<Object> value;
        in.item(value);
        std::shared_ptr<Variable> variable = object.scope.find(name);
        const bool isValue = variable && variable->type == type && !bytes.empty() &&
                             variable->bytes.size() == bytes.size();
        if (!variable) {
            variable = std::make_shared<Variable>(context_, name);
            context_->variables.push_back(variable);
        }
        list.push_back(variable);
        if (isValue) {
            variable->set(type, bytes.data(), bytes.size());
            continue;
        }
        isStructure |= variable->type != type || variable->bytes != bytes ||
                       variable->object.lock() != value.lock();
        variable->type = type;
        variable->bytes = bytes;
        variable->object = value;
    }
    isStructure |= list.size() != object.scope.list().size();
    object.scope.assign(list);
    std::erase_if(context_->variables, [](const auto& ref) { return ref.expired(); });
    if (isStructure)
        context_->noteStructure();
}

} // namespace sunstone::optix6
