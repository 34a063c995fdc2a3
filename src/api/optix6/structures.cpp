// SPDX-License-Identifier: Apache-2.0
// Acceleration structures and graph nodes of a scene.
//
// A geometry group is a structure of triangles, one of custom primitives, or both. The nodes above
// it are flattened: transforms without motion become the matrices of instances. A node at which
// rays start without a plain structure of instances is an instance that no structure holds.
#include "api/optix6/scene.h"

#include "api/optix6/report.h"
#include "bvh/motion/transforms.h"
#include "devlib/graph.h"
#include "engine/accel.h"
#include "math/matrix.h"
#include "math/product.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <set>

namespace sunstone::optix6 {

namespace {

constexpr float kIdentity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

bool isIdentity(const float m[12]) {
    return std::equal(m, m + 12, kIdentity);
}

// The address of a list of `count` items in a buffer of the triangles; throws if the list does not
// fit.
const uint8_t* place(const GeometryTriangles& t, const Ref<Buffer>& ref, const char* what,
                     uint64_t offset, uint64_t stride, uint64_t itemBytes, uint64_t count) {
    const std::shared_ptr<Buffer> buffer = ref.lock();
    if (!buffer)
        refuse(RT_ERROR_INVALID_VALUE, "geometry triangles ", t.handle(), " have no buffer of ",
               what);
    buffer->validate();
    uint64_t end = 0;
    const bool fits =
        count == 0 || (!__builtin_mul_overflow(count - 1, stride, &end) &&
                       !__builtin_add_overflow(end, offset, &end) &&
                       !__builtin_add_overflow(end, itemBytes, &end) && end <= buffer->bytes());
    if (!fits)
        refuse(RT_ERROR_INVALID_VALUE, "the buffer of ", what, ", ", buffer->handle(), ", has ",
               buffer->bytes(), " bytes, but geometry triangles ", t.handle(), " need ", end);
    return buffer->data() ? buffer->data() + offset : nullptr;
}

// Offset of a motion step's vertices in a buffer that holds all steps.
uint64_t stepOffset(const GeometryTriangles& t, unsigned step) {
    uint64_t offset = 0;
    if (__builtin_mul_overflow(uint64_t(step), t.vertexMotionStride, &offset) ||
        __builtin_add_overflow(offset, t.vertexByteOffset, &offset))
        refuse(RT_ERROR_INVALID_VALUE, "vertexBufferMotionByteStride = ", t.vertexMotionStride,
               " puts motion step ", step, " outside of the vertex buffer");
    return offset;
}

unsigned entriesOf(const GeometryInstance& instance) {
    return std::max<unsigned>(1, unsigned(instance.materials.size()));
}

// Several instances of a group may use the mesh, each with an input of its own: `kept` keeps the
// data of the input until the build has ended.
bvh::TriangleInput triangleInput(engine::AccelInputs& inputs, const GeometryTriangles& t,
                                 std::vector<SharedVector<float>>& kept) {
    bvh::TriangleInput in;
    const unsigned vertexBytes = bytesOf(t.vertexFormat);
    const RTsize stride = t.vertexStride ? t.vertexStride : vertexBytes;
    in.vertexFormat = t.vertexFormat == RT_FORMAT_FLOAT3   ? bvh::VertexFormat::kFloat3
                      : t.vertexFormat == RT_FORMAT_FLOAT2 ? bvh::VertexFormat::kFloat2
                      : t.vertexFormat == RT_FORMAT_HALF3  ? bvh::VertexFormat::kHalf3
                                                           : bvh::VertexFormat::kHalf2;
    in.vertexStride = uint32_t(stride);
    in.numVertices = t.vertexCount;
    std::vector<const void*> keys;
    for (unsigned step = 0; step < t.motion.steps; ++step) {
        const bool many = t.vertices.size() > 1;
        keys.push_back(place(t, t.vertices[many ? step : 0], "vertices",
                             many ? t.vertexByteOffset : stepOffset(t, step), stride, vertexBytes,
                             t.vertexCount));
    }
    in.vertices = keys[0];
    if (t.motion.steps > 1)
        in.keyVertices = inputs.keepKeys(std::move(keys));
    in.numTriangles = t.primitives;
    if (t.hasIndices) {
        const bool wide = t.indexFormat == RT_FORMAT_UNSIGNED_INT3;
        const unsigned indexBytes = wide ? 12 : 6;
        const RTsize indexStride = t.indexStride ? t.indexStride : indexBytes;
        in.indexFormat = wide ? bvh::IndexFormat::kUint3 : bvh::IndexFormat::kUshort3;
        in.indexStride = uint32_t(indexStride);
        in.indices = place(t, t.indices, "indices", t.indexByteOffset, indexStride, indexBytes,
                           t.primitives);
    }
    if (t.hasTransform) {
        const SharedAllocator<float> allocator(t.context()->engine->backend);
        in.preTransform =
            kept.emplace_back(t.transform.begin(), t.transform.end(), allocator).data();
    }
    std::vector<unsigned> flags(t.materialFlags.begin(), t.materialFlags.end());
    in.sbt.flags = inputs.keepFlags(flags.data(), flags.size());
    in.sbt.numSbtRecords = uint32_t(flags.size());
    in.sbt.primitiveIndexOffset = t.indexOffset;
    if (t.hasMaterialIndices && flags.size() > 1) {
        const unsigned bytes = bytesOf(t.materialFormat);
        const RTsize materialStride = t.materialStride ? t.materialStride : bytes;
        in.sbt.indexOffsets = place(t, t.materialIndices, "material indices", t.materialByteOffset,
                                    materialStride, bytes, t.primitives);
        in.sbt.indexOffsetSize = bytes;
        in.sbt.indexOffsetStride = uint32_t(materialStride);
    }
    return in;
}

bvh::InstanceDesc instanceOf(uint64_t handle, uint32_t mask, uint32_t flags, uint32_t firstEntry) {
    bvh::InstanceDesc desc{};
    std::copy_n(kIdentity, 12, desc.transform);
    desc.sbtOffset = firstEntry;
    desc.visibilityMask = mask & 0xFF;
    desc.flags = flags;
    desc.traversableHandle = handle;
    return desc;
}

// The properties of inputs that updates must not change (bvh::checkUpdate).
std::vector<uint64_t> shapeOf(const engine::AccelInputs& inputs) {
    std::vector<uint64_t> shape;
    const auto addSbt = [&](const bvh::SbtInput& sbt) {
        shape.insert(shape.end(), {sbt.numSbtRecords, sbt.primitiveIndexOffset, sbt.indexOffsetSize,
                                   sbt.indexOffsets != nullptr});
        shape.insert(shape.end(), sbt.flags, sbt.flags + sbt.numSbtRecords);
    };
    for (const bvh::TriangleInput& in : inputs.triangles) {
        shape.insert(shape.end(), {in.numTriangles, in.numVertices, uint64_t(in.vertexFormat),
                                   uint64_t(in.indexFormat)});
        addSbt(in.sbt);
    }
    for (const bvh::CustomInput& in : inputs.customs) {
        shape.push_back(in.numPrimitives);
        addSbt(in.sbt);
    }
    return shape;
}

// The sets of a group and their geometry; records and structures must have the same.
std::vector<uint64_t> layoutOf(const GeometryGroup& group) {
    std::vector<uint64_t> layout;
    for (const GeometrySet& set : group.sets) {
        const bvh::MotionOptions& motion = set.motion;
        layout.insert(layout.end(),
                      {set.isMesh, motion.keys, motion.flags, std::bit_cast<uint32_t>(motion.begin),
                       std::bit_cast<uint32_t>(motion.end), set.instances.size()});
        for (const size_t child : set.instances)
            layout.insert(layout.end(), {child, entriesOf(*group.instances[child].lock())});
    }
    return layout;
}

} // namespace

bvh::MotionOptions optionsOf(const Motion& motion) {
    bvh::MotionOptions options;
    options.keys = std::max(1u, motion.steps);
    options.begin = motion.begin;
    options.end = motion.end;
    options.flags = (motion.beginMode == RT_MOTIONBORDERMODE_VANISH ? 1u : 0u) |
                    (motion.endMode == RT_MOTIONBORDERMODE_VANISH ? 2u : 0u);
    return options;
}

bool sameMotion(const bvh::MotionOptions& a, const bvh::MotionOptions& b) {
    return a.keys == b.keys &&
           (a.keys == 1 || (a.begin == b.begin && a.end == b.end && a.flags == b.flags));
}

Acceleration* accelerationOf(Node& node) {
    return node.kind == Kind::kGeometryGroup
               ? static_cast<GeometryGroup&>(node).acceleration.lock().get()
           : node.kind == Kind::kGroup ? static_cast<Group&>(node).acceleration.lock().get()
                                       : nullptr;
}

// All structures and nodes, children before parents.
void Scene::buildStructures() {
    settled_.clear();
    for (const std::shared_ptr<Node>& node : order_)
        if (Acceleration* acceleration = accelerationOf(*node); acceleration && acceleration->dirty)
            ++acceleration->version;
    for (const std::shared_ptr<Node>& node : order_)
        refresh(*node, nullptr);
    for (const std::shared_ptr<Node>& node : order_)
        if (Acceleration* acceleration = accelerationOf(*node))
            acceleration->dirty = false;
}

// Updates the nodes that have moved or become dirty since the last launch, and the nodes above
// them. The graph is unchanged.
void Scene::followChanges() {
    settled_.clear();
    std::map<uint32_t, std::vector<uint32_t>> waiting; // changed slots of nodes, by place
    for (const Ref<Node>& ref : context_.movedNodes)
        if (const std::shared_ptr<Node> node = ref.lock();
            node && node->place < order_.size() && order_[node->place] == node)
            waiting[node->place];
    std::set<Acceleration*> dirty;
    for (const Ref<Acceleration>& ref : context_.dirtyAccelerations)
        if (const std::shared_ptr<Acceleration> acceleration = ref.lock();
            acceleration && acceleration->dirty)
            for (const uint32_t place : acceleration->owners)
                if (place < order_.size() && accelerationOf(*order_[place]) == acceleration.get()) {
                    waiting[place];
                    dirty.insert(acceleration.get());
                }
    for (Acceleration* acceleration : dirty)
        ++acceleration->version;
    while (!waiting.empty()) {
        const auto first = waiting.extract(waiting.begin());
        Node& node = *order_[first.key()];
        const bool isSeenAbove = refresh(node, &first.mapped());
        if (nodesCopy_[node.id] != node.nodeHandle)
            nodesCopy_[node.id] = nodes_[node.id] = node.nodeHandle;
        if (isSeenAbove || node.hasMoved)
            for (const auto& [parent, slot] : node.parents)
                waiting[parent->place].push_back(slot);
    }
    for (Acceleration* acceleration : dirty)
        acceleration->dirty = false;
}

void Scene::clearChanges() {
    for (const Ref<Node>& ref : context_.movedNodes)
        if (const std::shared_ptr<Node> node = ref.lock())
            node->hasMoved = false;
    context_.movedNodes.clear();
    context_.dirtyAccelerations.clear();
}

// Updates a node whose children are up to date. `slots`: changed slots; null: all may have changed.
// Returns whether parents must be updated.
bool Scene::refresh(Node& node, const std::vector<uint32_t>* slots) {
    bool isSeenAbove = true;
    if (node.kind == Kind::kGeometryGroup)
        buildGeometry(static_cast<GeometryGroup&>(node));
    if (node.kind == Kind::kSelector)
        makeVisitNode(static_cast<Selector&>(node));
    if (node.kind == Kind::kGroup) {
        auto& group = static_cast<Group&>(node);
        const uint64_t before = group.built ? group.built->version() : 0;
        buildGroup(group, slots);
        isSeenAbove = group.built->version() != before;
    }
    makeNode(node);
    return isSeenAbove;
}

void Scene::build(Acceleration::Built& built, std::shared_ptr<const engine::AccelInputs> inputs,
                  const bvh::BuildOptions& options, bool isUpdate) {
    const bvh::MemoryUsage usage = engine::accelMemory(*context_.engine, *inputs, options);
    const std::shared_ptr<engine::Backend>& backend = context_.engine->backend;
    engine::AccelBuild request;
    request.inputs = std::move(inputs);
    request.options = options;
    request.update = isUpdate;
    SharedMemory temp;
    if (isUpdate) {
        if (built.scratch.size() < usage.tempUpdate)
            built.scratch = SharedMemory(backend, usage.tempUpdate);
    } else {
        built.handle = 0;
        built.memory = SharedMemory(backend, usage.output);
        temp = SharedMemory(backend, usage.temp);
    }
    const SharedMemory& scratch = isUpdate ? built.scratch : temp;
    request.temp = scratch.get();
    request.tempSize = scratch.size();
    request.output = built.memory.get();
    request.outputSize = built.memory.size();
    const uint64_t handle = engine::buildAccel(context_.engine, std::move(request));
    context_.engine->device->synchronize(nullptr);
    built.handle = handle;
}

SharedVector<float> Scene::boxesOf(const GeometryInstance& instance, const Geometry& geometry,
                                   unsigned step) {
    SharedVector<float> boxes(size_t(6) * std::max(1u, geometry.primitives), allocator<float>());
    if (geometry.primitives == 0)
        return boxes;
    engine::BoundsRequest request;
    request.pipeline = pipeline_;
    request.sbt = table();
    request.sbt.entryRecord = uint64_t(&bounds_[boundsOf_.at(&instance)]);
    request.count = geometry.primitives;
    request.firstPrimitive = geometry.indexOffset;
    request.motionStep = step;
    request.boxes = boxes.data();
    request.params = &tables().launch;
    request.paramsSize = sizeof(devlib::ClassicLaunch);
    engine::launchBounds(context_.engine, request); // the build follows it
    return boxes;
}

bvh::CustomInput Scene::customOf(engine::AccelInputs& inputs, const GeometryInstance& instance,
                                 const Geometry& geometry) {
    bvh::CustomInput in;
    std::vector<const void*> keys;
    for (unsigned step = 0; step < geometry.motion.steps; ++step)
        keys.push_back(kept_.emplace_back(boxesOf(instance, geometry, step)).data());
    in.aabbs = keys[0];
    if (geometry.motion.steps > 1)
        in.keyAabbs = inputs.keepKeys(std::move(keys));
    in.numPrimitives = geometry.primitives;
    const std::vector<unsigned> flags(entriesOf(instance), geometry.flags);
    in.sbt.flags = inputs.keepFlags(flags.data(), flags.size());
    in.sbt.numSbtRecords = uint32_t(flags.size());
    in.sbt.primitiveIndexOffset = geometry.indexOffset;
    return in;
}

void Scene::buildGeometry(GeometryGroup& group) {
    Acceleration& acceleration = *group.acceleration.lock();
    std::vector<uint64_t> layout = layoutOf(group);
    const bool fits = acceleration.layout == layout;
    // Another group shares it: handles of that group's nodes refer to the structure already.
    if (!settled_.insert(&acceleration).second) {
        if (!fits)
            refuse(RT_ERROR_INVALID_VALUE,
                   "geometry groups with different geometry share acceleration ",
                   acceleration.handle());
        return;
    }
    if (!acceleration.dirty && fits)
        return;
    for (const Ref<GeometryInstance>& instance : group.instances)
        instance.lock()->validate();
    if (!fits)
        acceleration.sets.clear();
    acceleration.layout.clear();
    acceleration.sets.resize(group.sets.size());
    for (size_t i = 0; i < group.sets.size(); ++i)
        buildSet(acceleration, acceleration.sets[i], group, group.sets[i]);
    acceleration.layout = std::move(layout);
    acceleration.boundsVersion = ++context_.lastVersion;
}

// An update keeps the tree. It needs inputs of the same shape and a tree that allows updates.
void Scene::buildSet(Acceleration& acceleration, Acceleration::Built& built,
                     const GeometryGroup& group, const GeometrySet& set) {
    const TimedReport timed(context_);
    engine::AccelInputs inputs;
    uint64_t primitives = 0;
    kept_.clear();
    for (const size_t child : set.instances) {
        const std::shared_ptr<GeometryInstance> instance = group.instances[child].lock();
        if (set.isMesh)
            inputs.triangles.push_back(triangleInput(inputs, *instance->triangles.lock(), kept_));
        else
            inputs.customs.push_back(customOf(inputs, *instance, *instance->geometry.lock()));
    }
    for (const bvh::TriangleInput& each : inputs.triangles)
        primitives += each.numTriangles;
    for (const bvh::CustomInput& each : inputs.customs)
        primitives += each.numPrimitives;
    bvh::BuildOptions options;
    options.preferFastTrace = true;
    options.motion = set.motion;
    options.allowUpdate = acceleration.refits();
    std::vector<uint64_t> shape = shapeOf(inputs);
    const bool isUpdate = options.allowUpdate && built.handle != 0 && built.shape == shape;
    built.shape.clear();
    build(built, std::make_shared<const engine::AccelInputs>(std::move(inputs)), options, isUpdate);
    if (options.allowUpdate)
        built.shape = std::move(shape);
    kept_.clear();
    timed.tell(isUpdate ? kReportLaunches : kReportStatistics, "ACCEL", "geometry group ",
               group.handle(), ": ", isUpdate ? "an update of " : "a build of ", primitives,
               set.isMesh ? " triangles" : " custom primitives", " and ", built.memory.size(),
               " bytes");
}

InstanceStructure& Scene::structure(std::unique_ptr<InstanceStructure>& slot) const {
    if (!slot)
        slot = std::make_unique<InstanceStructure>(context_.engine->backend);
    return *slot;
}

// A structure that is not dirty keeps its boxes, and its instances follow the graph.
void Scene::buildGroup(Group& group, const std::vector<uint32_t>* slots) {
    const std::shared_ptr<Acceleration> acceleration = group.acceleration.lock();
    InstanceStructure& built = structure(group.built);
    if (slots && group.firstChild.size() == group.slots.size() + 1)
        showSlots(group, *slots);
    else
        showAll(group);
    const bool isCurrent = built.handle() != 0 && group.builtFor.lock() == acceleration &&
                           group.builtVersion == acceleration->version;
    if (isCurrent)
        return;
    built.update(context_, acceleration->refits());
    group.builtFor = acceleration;
    group.builtVersion = acceleration->version;
}

void Scene::showAll(Group& group) {
    std::vector<Child> children;
    group.firstChild.clear();
    for (const Ref<Node>& slot : group.slots) {
        group.firstChild.push_back(children.size());
        for (const Child& child : childrenOf(*slot.lock()))
            children.push_back(child);
    }
    group.firstChild.push_back(children.size());
    group.built->show(children);
}

void Scene::showSlots(Group& group, const std::vector<uint32_t>& slots) {
    for (const uint32_t slot : slots) {
        const std::vector<Child> children = childrenOf(*group.slots[slot].lock());
        const size_t first = group.firstChild[slot];
        if (first + children.size() != group.firstChild[slot + 1])
            return showAll(group);
        group.built->show(first, children);
    }
}

// The instances of a node in the structure of its parent.
std::vector<Child> Scene::childrenOf(Node& node) {
    std::vector<Child> children;
    const auto add = [&](uint64_t handle, uint64_t version, uint32_t mask, uint32_t flags,
                         uint32_t entry) {
        if (handle)
            children.push_back({instanceOf(handle, mask, flags, entry), handle, version});
    };
    if (node.kind == Kind::kGeometryGroup) {
        auto& group = static_cast<GeometryGroup&>(node);
        const Acceleration& acceleration = *group.acceleration.lock();
        for (size_t i = 0; i < group.sets.size(); ++i)
            add(acceleration.sets[i].handle, acceleration.boundsVersion, group.mask, group.flags,
                group.sets[i].firstEntry);
    } else if (node.kind == Kind::kGroup) {
        auto& group = static_cast<Group&>(node);
        add(group.built->handle(), group.built->version(), group.mask, 0, 0);
    } else if (node.kind == Kind::kSelector) {
        auto& selector = static_cast<Selector&>(node);
        if (selector.bounds && selector.bounds->handle())
            children.push_back({instanceOf(selector.bounds->handle(), 0xFF, 0, 0),
                                devlib::makeHandle(selector.nodeMemory.get(), devlib::kTagVisit),
                                selector.bounds->version()});
    } else {
        auto& transform = static_cast<Transform&>(node);
        if (!transform.keys.empty()) {
            add(transform.nodeHandle, transform.motionVersion, 0xFF, 0, 0);
            return children;
        }
        children = childrenOf(*transform.child.lock());
        for (Child& child : children)
            math::multiply(transform.matrix.data(), child.instance.transform,
                           child.instance.transform);
    }
    return children;
}

// Makes the node of a selector. Its children are nodes of their own, which the visit program enters
// by number. The structure of all children only provides the bounds.
void Scene::makeVisitNode(Selector& selector) {
    std::vector<Child> all;
    const size_t count = selector.slots.size();
    const size_t bytes = std::max<size_t>(1, count) * sizeof(uint64_t);
    if (selector.childHandles.size() < bytes)
        selector.childHandles = SharedMemory(context_.engine->backend, bytes);
    auto* handle = static_cast<uint64_t*>(selector.childHandles.get());
    for (const Ref<Node>& slot : selector.slots) {
        Node& node = *slot.lock();
        *handle++ = node.nodeHandle;
        for (const Child& child : childrenOf(node))
            all.push_back(child);
    }
    if (all.empty()) {
        selector.bounds.reset();
    } else {
        structure(selector.bounds).show(all);
        selector.bounds->update(context_, false);
    }
    if (selector.nodeMemory.size() < sizeof(devlib::VisitNode))
        selector.nodeMemory = SharedMemory(context_.engine->backend, sizeof(devlib::VisitNode));
    auto& node = *static_cast<devlib::VisitNode*>(selector.nodeMemory.get());
    node.record = uint64_t(&visits_[visitOf_.at(&selector)]);
    node.children = static_cast<const uint64_t*>(selector.childHandles.get());
    node.count = uint32_t(count);
}

// Makes a node with motion keys above a structure of instances, which bounds children of any kind.
void Scene::makeMotionTransform(Transform& transform, const Child& child) {
    const bvh::MotionOptions motion = optionsOf(transform.motion);
    const bool isSrt = transform.keyType == RT_MOTIONKEYTYPE_SRT_FLOAT16;
    const size_t header = offsetof(bvh::MatrixMotionTransform, matrices);
    static_assert(offsetof(bvh::MatrixMotionTransform, matrices) ==
                  offsetof(bvh::SrtMotionTransform, keys));
    const size_t keyBytes = transform.keys.size() * sizeof(float);
    const size_t bytes = std::max(header + keyBytes, sizeof(bvh::SrtMotionTransform));
    std::vector<uint64_t> image(bytes / sizeof(uint64_t) + 1);
    auto& node = *reinterpret_cast<bvh::MatrixMotionTransform*>(image.data());
    node.child = child.handle;
    // An empty range has only one moment, that of the first key.
    const bool isMoment = motion.begin == motion.end;
    node.motion = {uint16_t(isMoment ? 1 : motion.keys), uint16_t(motion.flags), motion.begin,
                   motion.end};
    std::memcpy(reinterpret_cast<uint8_t*>(image.data()) + header, transform.keys.data(), keyBytes);
    if (transform.nodeMemory.size() < bytes)
        transform.nodeMemory = SharedMemory(context_.engine->backend, bytes);
    void* const memory = transform.nodeMemory.get();
    transform.nodeHandle =
        devlib::makeHandle(memory, isSrt ? devlib::kTagSrtMotion : devlib::kTagMatrixMotion);
    if (transform.childVersion == child.version && std::memcmp(memory, image.data(), bytes) == 0)
        return;
    std::memcpy(memory, image.data(), bytes);
    transform.childVersion = child.version;
    transform.motionVersion = ++context_.lastVersion;
    context_.engine->backend->noteTransform(transform.nodeHandle);
}

// Whether rays may enter the instance's traversable instead of the instance.
bool Scene::isPlain(const Child& child) {
    const bvh::InstanceDesc& desc = child.instance;
    return isIdentity(desc.transform) && desc.visibilityMask == 0xFF && desc.flags == 0 &&
           desc.sbtOffset == 0;
}

void Scene::makeNode(Node& node) {
    auto* const transform =
        node.kind == Kind::kTransform ? static_cast<Transform*>(&node) : nullptr;
    const bool moves = transform && !transform->keys.empty();
    node.nodeHandle = 0;
    const std::vector<Child> children = childrenOf(moves ? *transform->child.lock() : node);
    if (children.empty())
        return;
    Child only = children[0];
    const bool isStructure = isPlain(only) && devlib::tagOf(only.handle) == devlib::kTagIas;
    if (children.size() > 1 || (moves && !isStructure)) {
        structure(node.several).show(children);
        node.several->update(context_, false);
        const uint64_t handle = node.several->handle();
        only = {instanceOf(handle, 0xFF, 0, 0), handle, node.several->version()};
    }
    if (moves)
        return makeMotionTransform(*transform, only);
    const devlib::HandleTag tag = devlib::tagOf(only.handle);
    if (isPlain(only) && (tag == devlib::kTagIas || tag == devlib::kTagVisit)) {
        node.nodeHandle = only.handle;
        return;
    }
    if (node.nodeMemory.size() < sizeof(devlib::InstanceRecord))
        node.nodeMemory = SharedMemory(context_.engine->backend, sizeof(devlib::InstanceRecord));
    auto& record = *static_cast<devlib::InstanceRecord*>(node.nodeMemory.get());
    std::copy_n(only.instance.transform, 12, record.objectToWorld);
    math::invert(record.objectToWorld, record.worldToObject);
    record.child = only.handle;
    record.sbtOffset = only.instance.sbtOffset;
    record.visibilityMask = only.instance.visibilityMask;
    record.flags = only.instance.flags;
    node.nodeHandle = devlib::makeHandle(&record, devlib::kTagInstance);
}

} // namespace sunstone::optix6
