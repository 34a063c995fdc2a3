// SPDX-License-Identifier: Apache-2.0
// The memory format of acceleration structures.
//
// A structure is one block of bytes without pointers: places inside it are offsets from its start,
// so copying the block moves it (relocation patches nothing). The exceptions are the child handle
// in an instance record and the address of an opacity micromap array; the caller supplies both.
//
//   BlockHeader | InputRecord[] | primitive table | MicromapRecord[], MicromapRef[] |
//   InstanceRecord[] | nodes and leaves, depth first
//
// Counts determine the size of everything before the nodes. The part that depends on data comes
// last, so that compaction is a copy of the first `usedSize` bytes.
//
// Nodes are eight wide with full-precision boxes. A child is a NodeRef: a place in 32-byte units
// and a tag. The meaning of a leaf tag depends on the type of the block:
//   triangles   kLeaf: TriangleLeaf<4>, kWideLeaf: TriangleLeaf<8>
//   custom      kLeaf: CustomLeaf, one primitive
//   instances   kLeaf: InstanceRecord, one instance
//   shapes      kLeaf, kWideLeaf: 4 or 8 pieces of curves or spheres, see curves.h and spheres.h
// A structure that may be updated holds its inactive primitives too, with empty boxes above them,
// because an update may make them active; `root` is then kNoNode while none is.
//
// Motion. A structure with several motion keys has kMotionBit in its type. One tree serves all
// keys:
//   nodes    Node with the planes of key 0, then KeyPlanes of the later keys
//   leaves   as without motion with the data of key 0, then the same numbers of the later keys
//            (TriangleKey: 9 * N floats, CustomKey: 6 floats); the whole rounded up to 64 bytes (32
//            for custom primitives); leaves of instances hold no keys
//   header   KeyBounds of each key at keyBoundsOffset
// The boxes at a time are those of the two keys around it, interpolated (motion.h: KeySegment);
// because vertices move linearly between keys, boxes contain their primitives at all times. Unused
// children and those without active primitives have the box (kFar, -kFar): infinite planes times a
// weight of zero would be NaN. A program that reads only Node and the leaves' first parts sees key
// 0.
//
// Boxes in nodes are padded (padBox in build_input.h); with the margins that traversal takes
// (ray_setup.h) no ray that the primitive test accepts is culled.
#pragma once

#include "devlib/graph.h"

#include <cstddef>
#include <cstdint>

namespace sunstone::bvh {

constexpr uint32_t kBlockMagic = 0x48564253u;
constexpr uint32_t kBlockVersion = 2;

enum class BlockType : uint32_t { kTriangles = 1, kCustom = 2, kInstances = 3, kShapes = 4 };
// Bit of BlockHeader::type for structures with motion keys, so that code for structures without
// motion refuses the type by its usual comparison.
constexpr uint32_t kMotionBit = 0x100;
// Bit of BlockHeader::type for triangles with opacity micromaps.
constexpr uint32_t kMicromapBit = 0x200;
inline BlockType kindOf(BlockType type) {
    return BlockType(uint32_t(type) & ~(kMotionBit | kMicromapBit));
}
inline BlockType withMotion(BlockType kind) {
    return BlockType(uint32_t(kind) | kMotionBit);
}
inline BlockType withMicromaps(BlockType kind) {
    return BlockType(uint32_t(kind) | kMicromapBit);
}
inline bool hasMicromaps(BlockType type) {
    return uint32_t(type) & kMicromapBit;
}
inline bool isMoving(BlockType type) {
    return uint32_t(type) & kMotionBit;
}

using devlib::InstanceRecord;

using NodeRef = uint32_t;
enum NodeTag : uint32_t { kInner = 0, kLeaf = 1, kWideLeaf = 2, kNodeTagMask = 3 };
constexpr uint32_t kRefUnit = 32;
constexpr NodeRef kNoNode = ~0u;
constexpr uint64_t kMaxBlockSize = uint64_t(kRefUnit) << 30;

inline NodeRef makeRef(uint64_t offset, uint32_t tag) {
    return NodeRef(offset / kRefUnit) << 2 | tag;
}
inline uint64_t offsetOf(NodeRef ref) {
    return uint64_t(ref & ~uint32_t(kNodeTagMask)) * (kRefUnit / 4);
}

// The longest path from the root, in nodes; builders ensure this limit.
constexpr unsigned kMaxDepth = 48;
// Entries of a traversal stack: seven siblings on each level, and the eight children of the last
// node.
constexpr unsigned kStackSize = 7 * kMaxDepth + 9;

struct alignas(64) BlockHeader {
    uint32_t magic;
    uint32_t version;
    BlockType type;         // with kMotionBit if motionKeys > 1, and kMicromapBit
    NodeRef root;           // kNoNode: empty
    uint64_t usedSize;      // bytes of the block in use
    uint32_t numPrimitives; // as in the inputs, inactive ones included
    uint32_t numActive;
    float lower[3]; // exact bounds of the active primitives, at all times
    uint32_t numInputs;
    float upper[3];
    uint32_t numSbtRecords;
    // Second cache line: fields for building and queries.
    uint64_t inputsOffset;
    uint64_t tableOffset;     // uint32_t per primitive, 0: no random vertex access
    uint64_t instancesOffset; // 0: none
    uint64_t nodesOffset;
    uint32_t numNodes;
    uint32_t numLeaves;
    uint32_t options;          // OptionBit
    uint32_t geometryFlagsAnd; // geometry flags all primitives have
    // Motion: number of keys (1: none), flags and time range as given.
    uint32_t motionKeys;
    uint32_t motionFlags; // MotionFlag
    float motionBegin;
    float motionEnd;
    NodeRef wholeRoot; // kOptionUpdate: root of the tree of all primitives, the inactive included
    uint32_t treeTooDeep;     // GPUs: of the clustered tree; the builder makes a second one
    uint64_t keyBoundsOffset; // KeyBounds of each key; 0 without motion
    uint64_t micromapsOffset; // MicromapRecord of each input; 0 without kMicromapBit
    // Curves and spheres (kShapes): see curves.h and spheres.h.
    uint64_t pointsOffset;   // control points or centres, with radii
    uint64_t recordsOffset;  // ShapeRecord of each primitive
    uint16_t shape;          // number of the OptixPrimitiveType
    uint16_t sharesRecords;  // GPUs: kSharedTag or 0, see shared_records.h
    float largestCoordinate; // GPUs: the largest magnitude in lower and upper
};
static_assert(sizeof(BlockHeader) == 192);

// Features that take rays off the common path.
enum TraitBit : uint32_t { kTraitMicromaps = 1 };
constexpr uint64_t kNodesAlignment = 256;

enum OptionBit : uint32_t {
    kOptionUpdate = 1,
    kOptionCompaction = 2,
    kOptionFastTrace = 4,
    kOptionFastBuild = 8,
    kOptionVertexAccess = 16,
    kOptionInstanceAccess = 32,
    kOptionMicromapUpdate = 64,
    kOptionDisableMicromaps = 128,
};

// One build input: its ranges of SBT indices and primitive indices.
struct InputRecord {
    uint32_t firstSbtIndex;
    uint32_t numSbtRecords;
    uint32_t firstPrimitive; // position of its first primitive in the primitive table
    uint32_t numPrimitives;
    uint32_t primitiveIndexOffset;
    // Fields that must be equal in an update.
    uint32_t formats; // of vertices (upper half) and indices
    uint32_t numVertices;
    uint32_t flagsHash; // of the geometry flags
};
static_assert(sizeof(InputRecord) == 32);

// The opacity micromaps of one build input.
struct MicromapRecord {
    uint64_t array;      // address of the array; 0: none
    uint64_t refsOffset; // a MicromapRef (micromap.h) for each primitive; 0: the input has none
    uint64_t arraySize;  // identifies a copy of the array
    uint32_t numMicromaps;
    uint32_t indexing;
};
static_assert(sizeof(MicromapRecord) == 32);

// Bytes of the planes of one kind. The lower planes of an axis are at an even multiple, the upper
// planes after them, so that this bit of an offset distinguishes the two.
constexpr uint32_t kPlanesSize = 32;

// Boxes of eight children, with planes of one kind contiguous. Unused children come last and have
// the empty box (+inf, -inf), which no ray hits.
struct alignas(64) Node {
    float planes[6][8]; // lower x, upper x, lower y, upper y, lower z, upper z
    NodeRef children[8];
    uint32_t numChildren;
    uint32_t pad[7];
};
static_assert(sizeof(Node) == 256 && sizeof(Node::planes[0]) == kPlanesSize);

// Values of OptixMotionFlags: outside the time range the structure is empty.
enum MotionFlag : uint32_t { kStartVanish = 1, kEndVanish = 2 };

// Planes of a box that no ray meets, in structures with motion.
constexpr float kFar = 1e38f;

// Exact bounds of the active primitives at a motion key.
struct KeyBounds {
    float lower[3], upper[3];
};
constexpr KeyBounds kNoBounds = {{__builtin_inff(), __builtin_inff(), __builtin_inff()},
                                 {-__builtin_inff(), -__builtin_inff(), -__builtin_inff()}};

// A node's planes at a motion key after the first.
struct alignas(64) KeyPlanes {
    float planes[6][8];
};
static_assert(sizeof(KeyPlanes) == 192);

// Bytes of a node with its planes at all keys.
inline uint32_t nodeBytes(uint32_t keys) {
    return uint32_t(sizeof(Node) + (keys - 1) * sizeof(KeyPlanes));
}
// The planes of a key in such a node.
inline float (*keyPlanes(uint8_t* node, uint32_t key))[8] {
    return key == 0 ? reinterpret_cast<Node*>(node)->planes
                    : reinterpret_cast<KeyPlanes*>(node + sizeof(Node))[key - 1].planes;
}

// SBT index (24 bits) and geometry flags (8 bits) of a primitive in one word.
constexpr uint32_t kSbtIndexMask = 0xFFFFFFu;
constexpr uint32_t kGeometryFlagShift = 24;
enum GeometryFlag : uint32_t { // numbers of OptixGeometryFlags
    kGeometryDisableAnyHit = 1,
    kGeometryRequireSingleAnyHit = 2,
    kGeometryDisableFaceCulling = 4,
};

// Up to N triangles. Unused lanes have NaN vertices.
template <unsigned N>
struct alignas(64) TriangleLeaf {
    float vertices[9 * N]; // [vertex][axis][lane]
    uint32_t primitive[N]; // with primitiveIndexOffset
    uint32_t sbt[N];
    uint32_t count;
    uint32_t pad[3 + (N == 8 ? 4 : 0)];
};
static_assert(sizeof(TriangleLeaf<4>) == 192);
static_assert(sizeof(TriangleLeaf<8>) == 384);

// Vertices of a leaf's triangles at a motion key after the first; follows the leaf.
template <unsigned N>
struct TriangleKey {
    float vertices[9 * N];
};

// Box of a custom primitive at a motion key after the first; follows the leaf.
struct CustomKey {
    float lower[3], upper[3];
};

// Bytes of a leaf with its data at all keys, rounded up to a multiple of `unit`.
inline uint32_t leafBytes(uint32_t leaf, uint32_t key, uint32_t keys, uint32_t unit) {
    return (leaf + (keys - 1) * key + unit - 1) / unit * unit;
}

// The values that a curve's segment or a sphere reports.
struct ShapeRecord {
    uint32_t primitive; // with primitiveIndexOffset
    uint32_t sbt;       // as in leaves of triangles
    uint32_t flags;     // ShapeFlag
};
static_assert(sizeof(ShapeRecord) == 12);

enum ShapeFlag : uint32_t {
    kShapeInactive = 1,
    kCurveCapBegin = 2, // a disc closes u = 0
    kCurveCapEnd = 4,
    kCurveBent = 8, // the direction changes much within an eighth of a piece
};

struct CustomLeaf {
    float lower[3];
    uint32_t primitive;
    float upper[3];
    uint32_t sbt;
};
static_assert(sizeof(CustomLeaf) == 32);

// The target of a static transform's handle (OptixStaticTransform).
struct StaticTransform {
    uint64_t child;
    uint32_t pad[2];
    float transform[12];
    float inverse[12];
};
static_assert(sizeof(StaticTransform) == 112);

// Entries of the primitive table: where a triangle is, or kNoSlot if it is inactive.
constexpr uint32_t kNoSlot = ~0u;
inline uint32_t makeSlot(uint64_t leafOffset, bool wide, uint32_t lane) {
    return uint32_t(leafOffset / 64) << 4 | uint32_t(wide) << 3 | lane;
}

inline const BlockHeader* headerOf(const void* block) {
    return static_cast<const BlockHeader*>(block);
}
inline bool looksLikeBlock(const BlockHeader* header) {
    return header->magic == kBlockMagic && header->version == kBlockVersion;
}

} // namespace sunstone::bvh
