// SPDX-License-Identifier: Apache-2.0
// Acceleration structures and graph nodes of a scene.
//
// A geometry group is a structure of triangles, one of custom primitives, or both. What is above it
// is flattened: transforms without motion become the matrices of instances. Where the graph begins
// elsewhere than at a structure of instances, a node is an instance that stands by itself.
#include "api/optix6/scene.h"

#include "bvh/motion/transforms.h"
#include "devlib/graph.h"
#include "engine/accel.h"
#include "math/matrix.h"
#include "math/product.h"

#include <algorithm>
#include <cstring>

namespace sunstone::optix6 {

namespace {

constexpr float kIdentity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

bool isIdentity(const float m[12]) {
    return std::equal(m, m + 12, kIdentity);
}

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

// Where a list of `count` items lies in a buffer; throws where it does not.
const uint8_t* place(const Ref<Buffer>& ref, const char* what, uint64_t offset, uint64_t stride,
                     uint64_t itemBytes, uint64_t count) {
    const std::shared_ptr<Buffer> buffer = ref.lock();
    if (!buffer)
        refuse(RT_ERROR_INVALID_VALUE, "geometry triangles without a buffer of ", what);
    buffer->validate();
    uint64_t end = 0;
    const bool fits =
        count == 0 || (!__builtin_mul_overflow(count - 1, stride, &end) &&
                       !__builtin_add_overflow(end, offset, &end) &&
                       !__builtin_add_overflow(end, itemBytes, &end) && end <= buffer->bytes());
    if (!fits)
        refuse(RT_ERROR_INVALID_VALUE, "the buffer of ", what, " has ", buffer->bytes(),
               " bytes, but the geometry triangles need ", end);
    return buffer->data() ? buffer->data() + offset : nullptr;
}

unsigned entriesOf(const GeometryInstance& instance) {
    return std::max<unsigned>(1, unsigned(instance.materials.size()));
}

bvh::TriangleInput triangleInput(engine::AccelInputs& inputs, GeometryTriangles& t) {
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
        keys.push_back(place(t.vertices[many ? step : 0], "vertices",
                             t.vertexByteOffset + (many ? 0 : step * t.vertexMotionStride), stride,
                             vertexBytes, t.vertexCount));
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
        in.indices =
            place(t.indices, "indices", t.indexByteOffset, indexStride, indexBytes, t.primitives);
    }
    if (t.hasTransform) {
        t.sharedTransform = SharedMemory(t.context()->engine->backend, sizeof t.transform);
        std::memcpy(t.sharedTransform.get(), t.transform.data(), sizeof t.transform);
        in.preTransform = static_cast<const float*>(t.sharedTransform.get());
    }
    std::vector<unsigned> flags(t.materialFlags.begin(), t.materialFlags.end());
    in.sbt.flags = inputs.keepFlags(flags.data(), flags.size());
    in.sbt.numSbtRecords = uint32_t(flags.size());
    in.sbt.primitiveIndexOffset = t.indexOffset;
    if (t.hasMaterialIndices && flags.size() > 1) {
        const unsigned bytes = bytesOf(t.materialFormat);
        const RTsize materialStride = t.materialStride ? t.materialStride : bytes;
        in.sbt.indexOffsets = place(t.materialIndices, "material indices", t.materialByteOffset,
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

Acceleration* accelerationOf(Node& node) {
    return node.kind == Kind::kGeometryGroup
               ? static_cast<GeometryGroup&>(node).acceleration.lock().get()
           : node.kind == Kind::kGroup ? static_cast<Group&>(node).acceleration.lock().get()
                                       : nullptr;
}

} // namespace

// Structures and nodes, children before parents.
void Scene::buildStructures() {
    settled_.clear();
    for (const std::shared_ptr<Node>& node : order_)
        if (Acceleration* acceleration = accelerationOf(*node); acceleration && acceleration->dirty)
            ++acceleration->version;
    for (const std::shared_ptr<Node>& node : order_) {
        if (node->kind == Kind::kGeometryGroup)
            buildGeometry(static_cast<GeometryGroup&>(*node));
        if (node->kind == Kind::kGroup)
            buildGroup(static_cast<Group&>(*node));
        if (node->kind == Kind::kSelector)
            makeVisitNode(static_cast<Selector&>(*node));
        makeNode(*node);
    }
    for (const std::shared_ptr<Node>& node : order_)
        if (Acceleration* acceleration = accelerationOf(*node))
            acceleration->dirty = false;
}

void Scene::build(SharedMemory& memory, uint64_t& handle, engine::AccelInputs inputs,
                  const bvh::MotionOptions& motion) {
    bvh::BuildOptions options;
    options.preferFastTrace = true;
    options.motion = motion;
    auto shared = std::make_shared<const engine::AccelInputs>(std::move(inputs));
    const bvh::MemoryUsage usage = engine::accelMemory(*context_.engine, *shared, options);
    SharedMemory output(context_.engine->backend, usage.output),
        temp(context_.engine->backend, usage.temp);
    engine::AccelBuild request;
    request.inputs = shared;
    request.options = options;
    request.temp = temp.get();
    request.tempSize = temp.size();
    request.output = output.get();
    request.outputSize = output.size();
    const uint64_t built = engine::buildAccel(context_.engine, std::move(request));
    context_.engine->device->synchronize(nullptr);
    memory = std::move(output);
    handle = built;
}

SharedVector<float> Scene::boxesOf(const GeometryInstance& instance, const Geometry& geometry,
                                   unsigned step) {
    SharedVector<float> boxes(size_t(6) * geometry.primitives, allocator<float>());
    engine::BoundsRequest request;
    request.pipeline = pipeline_;
    request.record = uint64_t(&bounds_[boundsOf_.at(&instance)]);
    request.count = geometry.primitives;
    request.firstPrimitive = geometry.indexOffset;
    request.motionStep = step;
    request.boxes = boxes.data();
    request.params = &tables().launch;
    request.paramsSize = sizeof(devlib::ClassicLaunch);
    engine::launchBounds(context_.engine, request);
    context_.engine->device->synchronize(nullptr);
    return boxes;
}

bvh::CustomInput Scene::customOf(engine::AccelInputs& inputs, const GeometryInstance& instance,
                                 const Geometry& geometry) {
    bvh::CustomInput in;
    std::vector<const void*> keys;
    for (unsigned step = 0; step < geometry.motion.steps; ++step)
        keys.push_back(boxes_.emplace_back(boxesOf(instance, geometry, step)).data());
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

// The order of hit entries is that of bindHits: triangles, then custom primitives.
void Scene::buildGeometry(GeometryGroup& group) {
    Acceleration& acceleration = *group.acceleration.lock();
    std::vector<unsigned> layout;
    for (const Ref<GeometryInstance>& instance : group.instances)
        layout.push_back(entriesOf(*instance.lock()));
    const bool fits = acceleration.layout == layout;
    // Another group has it: handles of that group's nodes name the structure already.
    if (!settled_.insert(&acceleration).second) {
        if (!fits)
            refuse(RT_ERROR_INVALID_VALUE,
                   "geometry groups with different geometry share acceleration ",
                   acceleration.handle());
        return;
    }
    if (!acceleration.dirty && fits)
        return;
    engine::AccelInputs triangles, customs;
    bvh::MotionOptions motions[2];
    boxes_.clear();
    const auto agree = [&](bvh::MotionOptions& all, bool isFirst, const Motion& motion) {
        const bvh::MotionOptions own = optionsOf(motion);
        if (!isFirst && !sameMotion(all, own))
            refuse(RT_ERROR_NOT_SUPPORTED, "geometry with different motion steps or ranges in one "
                                           "geometry group is not supported yet");
        all = own;
    };
    for (const Ref<GeometryInstance>& ref : group.instances) {
        const std::shared_ptr<GeometryInstance> instance = ref.lock();
        if (const std::shared_ptr<GeometryTriangles> mesh = instance->triangles.lock()) {
            agree(motions[0], triangles.triangles.empty(), mesh->motion);
            triangles.triangles.push_back(triangleInput(triangles, *mesh));
        } else if (const std::shared_ptr<Geometry> geometry = instance->geometry.lock()) {
            agree(motions[1], customs.customs.empty(), geometry->motion);
            customs.customs.push_back(customOf(customs, *instance, *geometry));
        }
    }
    acceleration.triangles = {};
    acceleration.customs = {};
    if (!triangles.triangles.empty())
        build(acceleration.triangles.memory, acceleration.triangles.handle, std::move(triangles),
              motions[0]);
    if (!customs.customs.empty())
        build(acceleration.customs.memory, acceleration.customs.handle, std::move(customs),
              motions[1]);
    acceleration.layout = std::move(layout);
    boxes_.clear();
}

void Scene::buildInstances(SharedMemory& memory, uint64_t& handle,
                           const std::vector<Child>& children) {
    SharedVector<bvh::InstanceDesc> descriptions(allocator<bvh::InstanceDesc>());
    for (const Child& child : children)
        descriptions.push_back(child.instance);
    engine::AccelInputs inputs;
    inputs.instances = std::make_unique<bvh::InstanceInput>();
    inputs.instances->instances = descriptions.data();
    inputs.instances->numInstances = uint32_t(descriptions.size());
    build(memory, handle, std::move(inputs), {});
    showChildren(memory, children);
}

// Writes the children into the records of a structure that may have been built of others.
void Scene::showChildren(const SharedMemory& memory, const std::vector<Child>& children) {
    const auto& header = *static_cast<const bvh::BlockHeader*>(memory.get());
    auto* record = reinterpret_cast<devlib::InstanceRecord*>(static_cast<uint8_t*>(memory.get()) +
                                                             header.instancesOffset);
    for (uint32_t i = 0; i < header.numPrimitives; ++i, ++record) {
        if (i >= children.size()) {
            record->visibilityMask = 0;
            continue;
        }
        const Child& child = children[i];
        record->child = child.handle;
        record->sbtOffset = child.instance.sbtOffset;
        record->visibilityMask = child.handle ? child.instance.visibilityMask : 0;
        record->flags = child.instance.flags;
        std::copy_n(child.instance.transform, 12, record->objectToWorld);
        math::invert(record->objectToWorld, record->worldToObject);
    }
}

// A structure that is not dirty keeps its boxes, and its instances follow the graph.
void Scene::buildGroup(Group& group) {
    const std::shared_ptr<Acceleration> acceleration = group.acceleration.lock();
    std::vector<Child> children;
    for (const Ref<Node>& slot : group.slots)
        for (const Child& child : childrenOf(*slot.lock()))
            children.push_back(child);
    Acceleration::Built& built = group.built;
    if (built.handle != 0 && group.builtFor.lock() == acceleration &&
        group.builtVersion == acceleration->version)
        return showChildren(built.memory, children);
    buildInstances(built.memory, built.handle, children);
    group.builtFor = acceleration;
    group.builtVersion = acceleration->version;
}

// What a node is in the structure of its parent.
std::vector<Scene::Child> Scene::childrenOf(Node& node) {
    std::vector<Child> children;
    const auto add = [&](uint64_t handle, uint32_t mask, uint32_t flags, uint32_t entry) {
        if (handle)
            children.push_back({instanceOf(handle, mask, flags, entry), handle});
    };
    if (node.kind == Kind::kGeometryGroup) {
        auto& group = static_cast<GeometryGroup&>(node);
        const Acceleration& acceleration = *group.acceleration.lock();
        uint32_t triangleEntries = 0;
        for (const Ref<GeometryInstance>& ref : group.instances)
            if (const auto instance = ref.lock(); !instance->triangles.expired())
                triangleEntries += entriesOf(*instance);
        add(acceleration.triangles.handle, group.mask, group.flags, group.firstEntry);
        add(acceleration.customs.handle, group.mask, group.flags,
            group.firstEntry + triangleEntries);
    } else if (node.kind == Kind::kGroup) {
        auto& group = static_cast<Group&>(node);
        add(group.built.handle, group.mask, 0, 0);
    } else if (node.kind == Kind::kSelector) {
        auto& selector = static_cast<Selector&>(node);
        if (selector.boundsHandle)
            children.push_back({instanceOf(selector.boundsHandle, 0xFF, 0, 0),
                                devlib::makeHandle(selector.nodeMemory.get(), devlib::kTagVisit)});
    } else {
        auto& transform = static_cast<Transform&>(node);
        children = childrenOf(*transform.child.lock());
        if (!transform.keys.empty()) {
            children.clear();
            add(transform.nodeHandle, 0xFF, 0, 0);
            return children;
        }
        for (Child& child : children)
            math::multiply(transform.matrix.data(), child.instance.transform,
                           child.instance.transform);
    }
    return children;
}

// The node of a selector. Its children are nodes of their own, which the visit program enters by
// number. A structure of all of them is built for its bounds alone.
void Scene::makeVisitNode(Selector& selector) {
    std::vector<Child> all;
    const size_t count = selector.slots.size();
    selector.childHandles =
        SharedMemory(context_.engine->backend, std::max<size_t>(1, count) * sizeof(uint64_t));
    auto* handle = static_cast<uint64_t*>(selector.childHandles.get());
    for (const Ref<Node>& slot : selector.slots) {
        Node& node = *slot.lock();
        *handle++ = node.nodeHandle;
        for (const Child& child : childrenOf(node))
            all.push_back(child);
    }
    selector.boundsHandle = 0;
    if (!all.empty())
        buildInstances(selector.childMemory, selector.boundsHandle, all);
    if (selector.nodeMemory.size() < sizeof(devlib::VisitNode))
        selector.nodeMemory = SharedMemory(context_.engine->backend, sizeof(devlib::VisitNode));
    auto& node = *static_cast<devlib::VisitNode*>(selector.nodeMemory.get());
    node.record = uint64_t(&visits_[visitOf_.at(&selector)]);
    node.children = static_cast<const uint64_t*>(selector.childHandles.get());
    node.count = uint32_t(count);
}

// Motion keys as a node above a structure of instances, which bounds children of every kind.
void Scene::makeMotionTransform(Transform& transform, uint64_t child) {
    const bvh::MotionOptions motion = optionsOf(transform.motion);
    const bool isSrt = transform.keyType == RT_MOTIONKEYTYPE_SRT_FLOAT16;
    const size_t header = offsetof(bvh::MatrixMotionTransform, matrices);
    static_assert(offsetof(bvh::MatrixMotionTransform, matrices) ==
                  offsetof(bvh::SrtMotionTransform, keys));
    const size_t keyBytes = transform.keys.size() * sizeof(float);
    transform.nodeMemory = SharedMemory(
        context_.engine->backend, std::max(header + keyBytes, sizeof(bvh::SrtMotionTransform)));
    auto& node = *static_cast<bvh::MatrixMotionTransform*>(transform.nodeMemory.get());
    node.child = child;
    // An empty range has one moment, that of the first key.
    const bool isMoment = motion.begin == motion.end;
    node.motion = {uint16_t(isMoment ? 1 : motion.keys), uint16_t(motion.flags), motion.begin,
                   motion.end};
    std::memcpy(static_cast<uint8_t*>(transform.nodeMemory.get()) + header, transform.keys.data(),
                keyBytes);
    transform.nodeHandle =
        devlib::makeHandle(&node, isSrt ? devlib::kTagSrtMotion : devlib::kTagMatrixMotion);
    context_.engine->backend->noteTransform(transform.nodeHandle);
}

// Whether rays may enter what the instance refers to in place of the instance.
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
        buildInstances(node.childMemory, only.handle, children);
        only.instance = instanceOf(only.handle, 0xFF, 0, 0);
    }
    if (moves)
        return makeMotionTransform(*transform, only.handle);
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
