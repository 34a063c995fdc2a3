// SPDX-License-Identifier: Apache-2.0
// Nodes of the scene graph without their entry points.
#include "api/optix6/context.h"

#include <cstdlib>

namespace sunstone::optix6 {

Node::Node(Kind kind, const std::shared_ptr<Context>& context)
    : Scoped(kind, context), id(context->nodes.reserve()) {}

void Node::enlist() {
    context()->nodes.set(id, std::static_pointer_cast<Node>(shared_from_this()));
}

void Node::noteMoved() {
    const std::shared_ptr<Context> owner = context();
    if (hasMoved || !owner)
        return;
    hasMoved = true;
    owner->movedNodes.push_back(std::static_pointer_cast<Node>(shared_from_this()));
}

void Acceleration::markDirty() {
    dirty = true;
    if (const std::shared_ptr<Context> owner = context())
        owner->dirtyAccelerations.push_back(
            std::static_pointer_cast<Acceleration>(shared_from_this()));
}

bool Acceleration::refits() const {
    const auto set = properties.find("refit");
    return set != properties.end() && std::atoi(set->second.c_str()) != 0;
}

std::vector<std::shared_ptr<Object>> GeometryGroup::children() const {
    std::vector<std::shared_ptr<Object>> list;
    for (const Ref<GeometryInstance>& instance : instances)
        if (std::shared_ptr<Object> child = instance.lock())
            list.push_back(std::move(child));
    return list;
}

std::vector<std::shared_ptr<Object>> ParentNode::children() const {
    std::vector<std::shared_ptr<Object>> list;
    for (const Ref<Node>& slot : slots)
        if (std::shared_ptr<Object> child = slot.lock())
            list.push_back(std::move(child));
    return list;
}

std::vector<std::shared_ptr<Object>> Transform::children() const {
    std::shared_ptr<Object> only = child.lock();
    return only ? std::vector{only} : std::vector<std::shared_ptr<Object>>{};
}

} // namespace sunstone::optix6
