// SPDX-License-Identifier: Apache-2.0
// The memory format of acceleration structures on GPUs. As on the CPU (bvh/layout.h, whose header
// and records it shares) a structure is one block without pointers inside:
//
//   BlockHeader | InputRecord[] | primitive table | InstanceRecord[] | points | primitive records
//   | WideNode[]
//
// A node has up to eight children. Their boxes are stored in 8 bits for each plane, on a grid that
// spans the node: plane = origin + byte * 2^exponent, rounded outwards (Ylitie, Karras and Laine,
// "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, also the
// source of the encoding of children). Children that are nodes follow one another from childBase,
// in the order of their slots; primitives of children that are leaves are a run of records from
// primitiveBase. A child takes, as far as possible, the slot whose bits (x, y, z) give its side of
// the node, so that the slots in the order of a ray's octant are nearly sorted.
//
// meta of a slot: 0, empty; inner child: 1 << 5 | 24 + slot; leaf: ones for each of its 1 to 3
// primitives << 5 | place of the first among the node's primitives (0..23).
//
// A structure that may be updated holds its inactive primitives, too. Triangles then have NaN
// vertices, custom primitives crossed boxes; the meta of a leaf of one inactive custom primitive or
// instance is its place plus 1, without the one, so that no ray comes there. Boxes of children
// without active primitives have crossed planes, and wholeRoot says whether the structure has a
// tree.
//
// Records: triangles, TriangleRecord; custom primitives, CustomLeaf; spheres, SphereRecord; pieces
// of curves (bvh/shapes/curves.h), CurveRecord; instances, uint32_t, the index of the instance.
// Points: float4[degree + 1] of each segment, if its test needs them (any basis but linear) or with
// random access; float4 of each sphere with random access.
//
// The root is node 0; numNodes is 0 if the structure is empty. Header fields with another meaning
// than on the CPU: recordsOffset, the primitive records; numLeaves, the number of records, or of
// references to them (sharesRecords); tableOffset, the record of each triangle (kNoSlot: inactive);
// usedSize, the size of a compacted copy.
//
// With motion keys (kMotionBit in the type) a node is a WideNode for each key, one behind the other
// and alike but for their boxes, and the record of a primitive is one for each key; points are
// stored by primitive, at each key in turn. Inactive curves and spheres have NaN in their records;
// radii of spheres and linear segments may be negative there. At keyBoundsOffset, behind the
// InstanceRecord, are KeyBounds of each key.
#pragma once

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

#include "bvh/layout.h"
#include "bvh/shapes/spheres.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kGpuBlockMagic = 0x47564253u;

struct alignas(16) WideNode {
    float origin[3];
    uint8_t exponents[3]; // biased as in a float: 2^(e - 127)
    uint8_t innerMask;    // slots whose child is a node
    uint32_t childBase;
    uint32_t primitiveBase;
    uint8_t meta[8];
    uint8_t planes[6][8]; // lower x, y, z, upper x, y, z
};
static_assert(sizeof(WideNode) == 80);

struct alignas(16) TriangleRecord {
    float v0[3];
    uint32_t primitive; // with primitiveIndexOffset
    float v1[3];
    uint32_t sbt; // index and geometry flags, see bvh/layout.h
    float v2[3];
    uint32_t pad;
};
static_assert(sizeof(TriangleRecord) == 48);

struct alignas(16) SphereRecord {
    float x, y, z, radius;
    uint32_t primitive; // with primitiveIndexOffset
    uint32_t sbt;
    uint32_t pad[2];
};
static_assert(sizeof(SphereRecord) == 32);

struct alignas(16) CurveRecord {
    float capsule[8]; // rows of bvh/shapes/curves.h: the ends of the chord; radius, or radii of the
                      // ends
    uint32_t word;    // piece of a segment
    uint32_t primitive;
    uint32_t sbt;
    uint32_t flags; // ShapeFlag
};
static_assert(sizeof(CurveRecord) == 48);

// The built-in shapes that a traversal can meet; code for other shapes compiles away.
enum ShapeBit : uint32_t {
    kMeetsSpheres = 1,
    kMeetsLinear = 2,
    kMeetsCurves = 4, // with a bit for each basis
    kMeetsQuadratic = 8,
    kMeetsCubic = 16,
    kMeetsCatmullRom = 32,
};

// OptixPrimitiveTypeFlags as ShapeBits: type n of the numbers 0x2500 + n has bit n.
constexpr uint32_t shapeBitsOf(uint32_t primitiveTypeFlags) {
    const uint32_t curves = (primitiveTypeFlags & 1u << 1 ? kMeetsQuadratic : 0u) |
                            (primitiveTypeFlags & 1u << 2 ? kMeetsCubic : 0u) |
                            (primitiveTypeFlags & 1u << 4 ? kMeetsCatmullRom : 0u);
    return (primitiveTypeFlags & 1u << 6 ? kMeetsSpheres : 0u) |
           (primitiveTypeFlags & 1u << 3 ? kMeetsLinear : 0u) |
           (curves ? curves | kMeetsCurves : 0u);
}
constexpr uint32_t kMaxLeafPrimitives = 3;

// Bytes of a node, and of a primitive's record, at all keys.
constexpr uint64_t nodeSize(uint32_t keys) {
    return uint64_t(keys) * sizeof(WideNode);
}
constexpr uint64_t recordSize(BlockType kind, uint32_t shape, uint32_t keys) {
    switch (kind) {
    case BlockType::kTriangles:
        return uint64_t(keys) * sizeof(TriangleRecord);
    case BlockType::kCustom:
        return uint64_t(keys) * sizeof(CustomLeaf);
    case BlockType::kShapes:
        return uint64_t(keys) *
               (shape == kSphereShape ? sizeof(SphereRecord) : sizeof(CurveRecord));
    default:
        return sizeof(uint32_t);
    }
}

// The longest path from the root, in nodes; builders ensure this limit.
constexpr unsigned kMaxWideDepth = 30;
// The most groups of children that wait during traversal of one structure: one for each level, and
// two when an instance is entered.
constexpr unsigned kStackEntries = kMaxWideDepth + 2;
// In addition, primitives wait on the stack while fewer than this number wait.
constexpr unsigned kWaitingLeaves = 16;
// Likewise single children of nodes of instances, while fewer than this number wait.
constexpr unsigned kWaitingChildren = 48;

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
