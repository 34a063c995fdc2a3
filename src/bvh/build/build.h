// SPDX-License-Identifier: Apache-2.0
// Builds acceleration structures from plain arrays into a buffer of the caller. The result is one
// relocatable block (layout.h): it may be copied with memcpy to any 128-byte-aligned address.
//
// All pointers are host addresses. The caller checks counts and strides by the rules of its API.
// The contents of the buffers are not trusted: an index out of range or a NaN or infinite
// coordinate makes its primitive inactive. The block does not depend on the number of threads;
// builds of the same input are equal byte for byte.
//
// Read next: layout.h for the block, sah_builder.h for the tree.
#pragma once

#include "math/box.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sunstone::bvh {

using math::Box;

enum class VertexFormat : uint32_t {
    kFloat3 = 0x2121, // 3 floats
    kFloat2 = 0x2122, // 2 floats, z = 0
    kHalf3 = 0x2123,
    kHalf2 = 0x2124,
    kSnorm16x3 = 0x2125, // max(value / 32767, -1)
    kSnorm16x2 = 0x2126,
};

enum class IndexFormat : uint32_t {
    kNone = 0, // vertices 3i, 3i+1, 3i+2
    kUshort3 = 0x2102,
    kUint3 = 0x2103,
};

// The SBT record and the index that a primitive reports, for triangles and custom primitives.
struct SbtInput {
    const uint32_t* flags = nullptr; // numSbtRecords words; null: all 0
    uint32_t numSbtRecords = 1;
    const void* indexOffsets = nullptr; // per primitive, or null: all 0
    uint32_t indexOffsetSize = 0;       // 0 (none), 1, 2 or 4 bytes
    uint32_t indexOffsetStride = 0;     // 0: packed
    uint32_t primitiveIndexOffset = 0;
};

// How triangles refer to their opacity micromap; the values of
// OptixOpacityMicromapArrayIndexingMode.
enum class MicromapIndexing : uint32_t {
    kNone = 0,    // they have none
    kLinear = 1,  // triangle i has micromap i
    kIndexed = 2, // as in an index buffer
};

// The opacity micromaps of a build input. Indices -1 to -4 mean wholly transparent, opaque,
// unknown-transparent, unknown-opaque micromaps.
struct MicromapInput {
    MicromapIndexing indexing = MicromapIndexing::kNone;
    const void* array = nullptr;   // micromap_array.h; must live as long as the structure is used
    const void* indices = nullptr; // per triangle, of kIndexed
    uint32_t indexSize = 4;        // 2 or 4 bytes
    uint32_t indexStride = 0;      // 0: packed
    uint32_t indexOffset = 0;      // added to indices that are not negative
};

struct TriangleInput {
    const void* vertices = nullptr;
    const void* const* keyVertices = nullptr; // with motion: vertices of each key, the first too
    VertexFormat vertexFormat = VertexFormat::kFloat3;
    uint32_t vertexStride = 0; // 0: packed
    uint32_t numVertices = 0;
    const void* indices = nullptr;
    IndexFormat indexFormat = IndexFormat::kNone;
    uint32_t indexStride = 0;              // bytes from triplet to triplet, 0: packed
    uint32_t numTriangles = 0;             // triplets; without indices numVertices / 3
    const float* preTransform = nullptr;   // 3x4 row-major, or null
    MicromapInput micromaps;
    SbtInput sbt;
};

struct CustomInput {
    const void* aabbs = nullptr; // 6 floats each: minX minY minZ maxX maxY maxZ
    const void* const* keyAabbs = nullptr; // with motion: boxes of each key, the first too
    uint32_t stride = 0;         // 0: 24
    uint32_t numPrimitives = 0;
    SbtInput sbt;
};

// Segments of round curves, see curves.h. All segments have one SBT record.
struct CurveInput {
    uint32_t basis = 0x2503; // CurveBasis; here linear
    const void* vertices = nullptr;           // 3 floats each
    const void* const* keyVertices = nullptr; // with motion: of each key, the first too
    uint32_t vertexStride = 0;                // 0: 12
    uint32_t numVertices = 0;
    const void* radii = nullptr; // one float for each vertex
    const void* const* keyRadii = nullptr;
    uint32_t radiusStride = 0;     // 0: 4
    const void* indices = nullptr; // of each segment's first vertex
    uint32_t indexStride = 0;      // 0: 4
    uint32_t numSegments = 0;
    bool caps = false; // flat discs at the ends of strands
    SbtInput sbt;
};

struct SphereInput {
    const void* centres = nullptr;           // 3 floats each
    const void* const* keyCentres = nullptr; // with motion: of each key, the first too
    uint32_t centreStride = 0;               // 0: 12
    uint32_t numSpheres = 0;
    const void* radii = nullptr; // one float for each sphere, or for all
    const void* const* keyRadii = nullptr;
    uint32_t radiusStride = 0; // 0: 4
    bool oneRadius = false;
    SbtInput sbt;
};

// The 80 bytes of an OptixInstance.
struct InstanceDesc {
    float transform[12]; // object to world, rows
    uint32_t instanceId;
    uint32_t sbtOffset;
    uint32_t visibilityMask;
    uint32_t flags;
    uint64_t traversableHandle; // 0: never hit
    uint32_t pad[2];
};
static_assert(sizeof(InstanceDesc) == 80);

struct InstanceInput {
    const void* instances = nullptr;             // InstanceDesc records, or
    const uint64_t* instancePointers = nullptr;  // their addresses (then `instances` is null)
    uint32_t stride = 0;                         // of `instances`, 0: 80
    uint32_t numInstances = 0;
    uint32_t knownFlags = ~0u;                   // bits of InstanceDesc::flags that count
    uint32_t identityFlag = 0;                   // an instance with it has no transform
};

// Exactly one kind is used: triangles, customs, curves (of one basis), spheres or instances.
// Several inputs of one kind become one structure. SBT indices of an input follow those of the
// previous inputs.
struct BuildInputs {
    std::span<const TriangleInput> triangles;
    std::span<const CustomInput> customs;
    std::span<const CurveInput> curves;
    std::span<const SphereInput> spheres;
    const InstanceInput* instances = nullptr;
};

// Motion keys are evenly spaced over the time range. Outside the range, the first or last key
// applies, or with the vanish flags (layout.h: MotionFlag) the structure is empty.
struct MotionOptions {
    uint32_t keys = 1; // 1: no motion, the rest is ignored
    uint32_t flags = 0;
    float begin = 0, end = 0; // begin <= end, finite
};

struct BuildOptions {
    bool allowUpdate = false;
    bool allowCompaction = false;
    bool preferFastTrace = false;
    bool preferFastBuild = false;
    bool allowRandomVertexAccess = false;
    bool allowRandomInstanceAccess = false;
    MotionOptions motion;
    bool allowMicromapUpdate = false;   // an update may give triangles other micromaps
    bool allowDisableMicromaps = false; // instances may; no cost here
};

struct MemoryUsage {
    size_t output = 0;
    size_t temp = 0;
    size_t tempUpdate = 0;
};

constexpr size_t kBlockAlignment = 128;

// Upper bounds for any data of these counts. More primitives never need less memory. Reads no
// buffer. Throws Error(kInvalidValue) if the inputs exceed the addressable size of a block.
MemoryUsage computeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options);

// Builds into `output` (128-byte aligned); `temp` is scratch (128-byte aligned). Throws
// Error(kInvalidValue) if a buffer is null, misaligned or smaller than computeMemoryUsage requires.
void build(const BuildInputs& inputs, const BuildOptions& options, void* temp, size_t tempSize,
           void* output, size_t outputSize);

// Updates the structure in `output`, built with allowUpdate (and perhaps compacted and moved
// since), to the inputs: keeps the tree, and recomputes boxes and primitives. Only contents and
// addresses of buffers may differ from the build, see checkUpdate. Inactive primitives may become
// active and vice versa. temp must have MemoryUsage::tempUpdate bytes. The result does not depend
// on the number of threads.
void update(const BuildInputs& inputs, const BuildOptions& options, void* temp, size_t tempSize,
            void* output, size_t outputSize);

// Throws Error(kInvalidValue) if update() is impossible: `output` holds no structure or one without
// allowUpdate; options, kinds, counts, formats or geometry flags differ from the build; or the
// output buffer is too small.
void checkUpdate(const BuildInputs& inputs, const BuildOptions& options, const void* output,
                 size_t outputSize);

// Whether build() made the block at this address, by its header.
bool isBlock(const void* block);

// Whether the block was built with allowCompaction.
bool allowsCompaction(const void* block);

// The functions below throw Error(kInvalidValue) for memory that is not a block.

// Used bytes of the block: the destination size for compact(). At most MemoryUsage::output.
uint64_t compactedSize(const void* block);

// Copies the block to `destination` (128-byte aligned, not overlapping, destinationSize at least
// compactedSize). The source stays unchanged.
void compact(const void* source, void* destination, size_t destinationSize);

// Bounds of the active primitives at all times; empty (lower > upper) if there are none.
Box bounds(const void* block);

// Bounds at a motion key.
Box boundsAtKey(const void* block, uint32_t key);

// The motion options of the build; keys is 1 without motion.
MotionOptions motionOf(const void* block);

// The traversable handle of the block: its address and tag (GAS or IAS).
uint64_t traversableHandle(const void* block);

// The vertices of a triangle at a time, 9 floats, after the pre-transform. `primitive` includes the
// primitive index offset; sbtGasIndex selects the build input. NaN if the triangle is inactive;
// false if the block has no random vertex access or no such triangle. Never throws.
bool triangleVertices(const void* block, uint32_t primitive, uint32_t sbtGasIndex,
                      float vertices[9], float time = 0) noexcept;

// The control points of a curve's segment, degree + 1 of x, y, z and radius, or a sphere's centre
// and radius, at a motion time; `shape` is the number of the OptixPrimitiveType. Otherwise as
// triangleVertices.
bool shapePoints(const void* block, uint32_t shape, uint32_t primitive, uint32_t sbtGasIndex,
                 float time, float* points) noexcept;

// Address of the i-th instance's record (devlib::InstanceRecord), or null. Never throws.
const void* instanceRecord(const void* block, uint32_t index) noexcept;

} // namespace sunstone::bvh
