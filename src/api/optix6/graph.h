// SPDX-License-Identifier: Apache-2.0
// The scene graph: geometry, materials, instances, groups, transforms, selectors, acceleration
// structures. Objects hold the values that the application sets; scene.h builds structures from
// them.
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
    // Whether dirty structures are updated where possible.
    bool refits() const;

    // One structure of a geometry group: each of its sets has one.
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

    std::vector<uint32_t> owners; // Node::place of the owners, set by the scene
};

// A node of the graph: an object that rays can be traced against.
class Node : public Scoped {
public:
    Node(Kind kind, const std::shared_ptr<Context>& context);
    virtual std::vector<std::shared_ptr<Object>> children() const = 0;
    const unsigned id; // the value of rtObject variables
    void enlist();     // after construction
    // Notes a move, or another change that leaves the structure of the graph unchanged.
    void noteMoved();

    // Set by the scene: the traversable that rays enter, and its memory.
    uint64_t nodeHandle = 0;
    SharedMemory nodeMemory;
    std::unique_ptr<InstanceStructure> several; // if rays enter more than one child
    void dropStructures() { nodeHandle = 0, nodeMemory = {}, several = nullptr; }

    // Set by the scene: the node's index, and the slots of other nodes that hold it.
    static constexpr uint32_t kNowhere = ~0u;
    uint32_t place = kNowhere;
    unsigned levels = 0, levelsAtStart = 0; // see Scene::checkDepth
    std::vector<std::pair<Node*, uint32_t>> parents;
    bool hasMoved = false;
};

// Geometry of a group in one structure: of one kind, with the same motion keys.
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
    // Set by the scene: triangles come before custom primitives.
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

    // The structure, with the acceleration and version for which it was built. Groups that share an
    // acceleration have separate structures, because a structure holds the positions and records of
    // the children.
    std::unique_ptr<InstanceStructure> built;
    std::vector<size_t> firstChild; // of each slot in the structure, and the total number
    Ref<Acceleration> builtFor;
    unsigned builtVersion = 0;
};

class Selector : public ParentNode {
public:
    static constexpr Kind kKind = Kind::kSelector;
    explicit Selector(const std::shared_ptr<Context>& context) : ParentNode(kKind, context) {}
    Ref<Program> visit;

    // Set by the scene: the traversables of the children, and a structure with the bounds of all.
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

    // With keys: versions of the current child's bounds, and of the node's own.
    uint64_t childVersion = 0, motionVersion = 0;
};

} // namespace sunstone::optix6
