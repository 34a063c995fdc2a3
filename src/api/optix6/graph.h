// SPDX-License-Identifier: Apache-2.0
// The scene graph: geometry, materials, instances, groups, transforms, selectors, acceleration
// structures. Objects hold what the application sets; scene.h makes structures of it.
#pragma once

#include "api/optix6/buffer.h"
#include "api/optix6/instances.h"
#include "api/optix6/program.h"

#include <array>
#include <map>

namespace sunstone::optix6 {

struct Motion {
    unsigned steps = 1;
    float begin = 0, end = 1;
    RTmotionbordermode beginMode = RT_MOTIONBORDERMODE_CLAMP, endMode = RT_MOTIONBORDERMODE_CLAMP;
};

class Geometry : public Scoped {
public:
    static constexpr Kind kKind = Kind::kGeometry;
    explicit Geometry(const std::shared_ptr<Context>& context) : Scoped(kKind, context) {}
    void validate() const;
    unsigned primitives = 0, indexOffset = 0;
    Motion motion;
    Ref<Program> bounds, intersection;
    RTgeometryflags flags = RT_GEOMETRY_FLAG_NONE;
};

class GeometryTriangles : public Scoped {
public:
    static constexpr Kind kKind = Kind::kGeometryTriangles;
    explicit GeometryTriangles(const std::shared_ptr<Context>& context) : Scoped(kKind, context) {
        materialFlags.resize(1, RT_GEOMETRY_FLAG_NONE);
    }
    void validate() const;
    unsigned primitives = 0, indexOffset = 0;
    Motion motion;
    bool hasTransform = false;
    std::array<float, 12> transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    Ref<Buffer> indices;
    bool hasIndices = false;
    RTsize indexByteOffset = 0, indexStride = 0;
    RTformat indexFormat = RT_FORMAT_UNKNOWN;
    std::vector<Ref<Buffer>> vertices; // one, or one for each motion step
    unsigned vertexCount = 0;
    RTsize vertexByteOffset = 0, vertexStride = 0, vertexMotionStride = 0;
    RTformat vertexFormat = RT_FORMAT_UNKNOWN;
    RTgeometrybuildflags buildFlags = RT_GEOMETRY_BUILD_FLAG_NONE;
    std::vector<RTgeometryflags> materialFlags; // one for each material
    Ref<Buffer> materialIndices;
    bool hasMaterialIndices = false;
    RTsize materialByteOffset = 0, materialStride = 0;
    RTformat materialFormat = RT_FORMAT_UNKNOWN;
    Ref<Program> attributes;
};

class Material : public Scoped {
public:
    static constexpr Kind kKind = Kind::kMaterial;
    explicit Material(const std::shared_ptr<Context>& context) : Scoped(kKind, context) {}
    std::map<unsigned, Ref<Program>> closestHit, anyHit; // by ray type
};

class GeometryInstance : public Scoped {
public:
    static constexpr Kind kKind = Kind::kGeometryInstance;
    explicit GeometryInstance(const std::shared_ptr<Context>& context) : Scoped(kKind, context) {}
    void validate() const;
    Ref<Geometry> geometry;
    Ref<GeometryTriangles> triangles; // one of the two
    std::vector<Ref<Material>> materials;
};

class Acceleration : public Object {
public:
    static constexpr Kind kKind = Kind::kAcceleration;
    explicit Acceleration(const std::shared_ptr<Context>& context) : Object(kKind, context) {}
    std::string builder;
    std::map<std::string, std::string> properties;
    bool dirty = true;
    void markDirty();
    // Whether structures that are dirty are updated where they can be.
    bool refits() const;

    // What was built for geometry groups: a structure for each of their sets.
    struct Built {
        SharedMemory memory, scratch;
        uint64_t handle = 0;         // 0: nothing was built
        std::vector<uint64_t> shape; // of the inputs; empty: the structure allows no updates
    };
    std::vector<Built> sets;
    std::vector<uint64_t> layout; // of the group's sets and instances, as built
    uint64_t boundsVersion = 0;   // changes with each build or update
    unsigned version = 0;         // grows whenever a launch finds it dirty
    void drop() { sets.clear(), layout.clear(), markDirty(); }

    std::vector<uint32_t> owners; // the scene's: Node::place
};

// A node of the graph: something that rays are traced against.
class Node : public Scoped {
public:
    Node(Kind kind, const std::shared_ptr<Context>& context);
    virtual std::vector<std::shared_ptr<Object>> children() const = 0;
    const unsigned id; // what rtObject variables hold
    void enlist();     // after construction
    // Its place or another property that leaves the graph as it is has changed.
    void noteMoved();

    // Made by the scene: what rays enter, and its memory.
    uint64_t nodeHandle = 0;
    SharedMemory nodeMemory;
    std::unique_ptr<InstanceStructure> several; // where rays enter more than one child
    void dropStructures() { nodeHandle = 0, nodeMemory = {}, several = nullptr; }

    // The scene's: its number among the nodes, and which slots of which nodes hold it.
    static constexpr uint32_t kNowhere = ~0u;
    uint32_t place = kNowhere;
    unsigned levels = 0, levelsAtStart = 0; // see Scene::checkDepth
    std::vector<std::pair<Node*, uint32_t>> parents;
    bool hasMoved = false;
};

// The geometry of a group that one structure holds: of one kind, with the same motion keys.
struct GeometrySet {
    bool isMesh = false;
    bvh::MotionOptions motion;
    std::vector<size_t> instances; // by number in the group
    uint32_t firstEntry = 0;       // of the hit table
};

class GeometryGroup : public Node {
public:
    static constexpr Kind kKind = Kind::kGeometryGroup;
    explicit GeometryGroup(const std::shared_ptr<Context>& context) : Node(kKind, context) {}
    std::vector<std::shared_ptr<Object>> children() const override;
    std::vector<Ref<GeometryInstance>> instances;
    Ref<Acceleration> acceleration;
    RTvisibilitymask mask = RT_VISIBILITY_ALL;
    RTinstanceflags flags = RT_INSTANCE_FLAG_NONE;
    // Made by the scene: triangles come before custom primitives.
    std::vector<GeometrySet> sets;
};

// Nodes whose children are nodes.
class ParentNode : public Node {
public:
    using Node::Node;
    std::vector<std::shared_ptr<Object>> children() const override;
    std::vector<Ref<Node>> slots;
};

class Group : public ParentNode {
public:
    static constexpr Kind kKind = Kind::kGroup;
    explicit Group(const std::shared_ptr<Context>& context) : ParentNode(kKind, context) {}
    Ref<Acceleration> acceleration;
    RTvisibilitymask mask = RT_VISIBILITY_ALL;

    // What was built, and of which version of which acceleration. Groups that share an acceleration
    // have structures of their own, as a structure holds the places and records of the children.
    std::unique_ptr<InstanceStructure> built;
    std::vector<size_t> firstChild; // in the structure, of each slot, and the number of all
    Ref<Acceleration> builtFor;
    unsigned builtVersion = 0;
};

class Selector : public ParentNode {
public:
    static constexpr Kind kKind = Kind::kSelector;
    explicit Selector(const std::shared_ptr<Context>& context) : ParentNode(kKind, context) {}
    Ref<Program> visit;

    // Made by the scene: the children as rays enter them, and a structure with the bounds of all.
    SharedMemory childHandles; // traversable handles
    std::unique_ptr<InstanceStructure> bounds;
};

class Transform : public Node {
public:
    static constexpr Kind kKind = Kind::kTransform;
    explicit Transform(const std::shared_ptr<Context>& context) : Node(kKind, context) {}
    std::vector<std::shared_ptr<Object>> children() const override;
    std::array<float, 16> matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    std::array<float, 16> inverse = matrix;
    RTmotionkeytype keyType = RT_MOTIONKEYTYPE_NONE;
    std::vector<float> keys;
    Motion motion;
    Ref<Node> child;

    // With keys: of the child that the node has, and of the node's own bounds.
    uint64_t childVersion = 0, motionVersion = 0;
};

} // namespace sunstone::optix6
