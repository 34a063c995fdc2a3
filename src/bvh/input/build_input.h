// SPDX-License-Identifier: Apache-2.0
// Reads build inputs: decodes vertices, decides which primitives are active, and makes the
// references that tree builders order. A primitive is inactive (never hit, not in the tree) if a
// vertex index is out of range, a coordinate is NaN, infinite or beyond kMaxCoordinate, a triangle
// has no area, a box is inverted, or an instance has no child, no visible bit or no inverse. The
// box of an instance ends at kMaxCoordinate.
#pragma once

#include "bvh/build/build.h"
#include "bvh/build/instance_bounds.h"
#include "bvh/build/tree.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace sunstone::bvh {

// Larger coordinates count as infinite, because their areas and products would exceed the range of
// floats.
constexpr float kMaxCoordinate = 0x1p100f;

// Widens a box by a small part of its size, so that traversal never culls a triangle that the
// triangle test accepts (ray_setup.h).
void padBox(float lower[3], float upper[3]);

// Whether an active primitive may have this coordinate.
inline bool usable(float a) {
    return a >= -kMaxCoordinate && a <= kMaxCoordinate;
}

// Clamps a box to the range of finite coordinates; false if nothing remains, or a plane is NaN.
inline bool endBox(float lower[3], float upper[3]) {
    bool good = true;
    for (int a = 0; a < 3; ++a) {
        lower[a] = std::max(lower[a], -kMaxCoordinate);
        upper[a] = std::min(upper[a], kMaxCoordinate);
        good = good && lower[a] <= upper[a];
    }
    return good;
}

// Whether a triangle has an area.
bool hasArea(const float v[9]);

class TriangleReader {
public:
    explicit TriangleReader(const TriangleInput& input);
    uint32_t count() const { return count_; }
    // The vertices after the pre-transform; false if the triangle is inactive.
    bool read(uint32_t triangle, float vertices[9]) const;
    // The vertices of an active or inactive triangle; false if it has none.
    bool readUnchecked(uint32_t triangle, float vertices[9]) const {
        uint32_t index[3];
        if (!indices(triangle, index))
            return false;
        if (plain_)
            for (int i = 0; i < 3; ++i)
                std::memcpy(vertices + 3 * i, vertices_ + index[i] * vertexStride_, 12);
        else
            decode(index, vertices);
        return true;
    }

    // The addresses of the vertices, if they are three floats without conversion; false if the
    // triangle has none or they need decoding.
    bool locate(uint32_t triangle, const uint8_t* out[3]) const {
        uint32_t index[3];
        if (!plain_ || !indices(triangle, index))
            return false;
        for (int i = 0; i < 3; ++i)
            out[i] = vertices_ + index[i] * vertexStride_;
        return true;
    }

    void prefetchIndices(uint32_t triangle) const {
        if (indexFormat_ != IndexFormat::kNone)
            prefetchBothEnds(indices_ + triangle * indexStride_);
    }
    void prefetchVertices(uint32_t triangle) const {
        uint32_t index[3];
        if (indices(triangle, index))
            for (uint32_t i : index)
                prefetchBothEnds(vertices_ + i * vertexStride_);
    }

private:
    // A vertex of twelve bytes extends into the next cache line one time in eight; without this
    // prefetch, such accesses take half of an update's time.
    static void prefetchBothEnds(const uint8_t* address) {
        __builtin_prefetch(address);
        __builtin_prefetch(address + 11);
    }
    bool indices(uint32_t triangle, uint32_t out[3]) const {
        if (numVertices_ == 0)
            return false;
        if (indexFormat_ == IndexFormat::kUint3) {
            std::memcpy(out, indices_ + triangle * indexStride_, 12);
        } else if (indexFormat_ == IndexFormat::kUshort3) {
            uint16_t index[3];
            std::memcpy(index, indices_ + triangle * indexStride_, 6);
            for (int i = 0; i < 3; ++i)
                out[i] = index[i];
        } else {
            for (uint32_t i = 0; i < 3; ++i)
                out[i] = 3 * triangle + i;
        }
        return out[0] < numVertices_ && out[1] < numVertices_ && out[2] < numVertices_;
    }
    void decode(const uint32_t index[3], float vertices[9]) const;
    void vertex(uint32_t index, float out[3]) const;

    const uint8_t* vertices_;
    const uint8_t* indices_;
    VertexFormat vertexFormat_;
    IndexFormat indexFormat_;
    size_t vertexStride_, indexStride_;
    uint32_t numVertices_, count_;
    bool transformed_ = false;
    bool plain_; // three floats, not transformed
    float transform_[12];
};

// Number of triangles of an input: triplets, or a third of the vertices.
uint32_t triangleCount(const TriangleInput& input);

class CustomReader {
public:
    explicit CustomReader(const CustomInput& input);
    bool read(uint32_t primitive, float lower[3], float upper[3]) const;

private:
    const uint8_t* aabbs_;
    size_t stride_;
};

// Reads SBT index (GAS-wide) and geometry flags of a primitive in the form of leaves.
class SbtReader {
public:
    SbtReader(const SbtInput& input, uint32_t firstSbtIndex)
        : input_(input), firstSbtIndex_(firstSbtIndex), firstWord_(wordOf(0)) {}
    uint32_t sbtWord(uint32_t primitive) const {
        return varies() ? wordOf(localIndex(primitive)) : firstWord_;
    }
    // Whether primitives may have different words.
    bool varies() const { return input_.indexOffsets && input_.indexOffsetSize; }
    uint32_t primitiveIndex(uint32_t primitive) const {
        return primitive + input_.primitiveIndexOffset;
    }

private:
    uint32_t localIndex(uint32_t primitive) const;
    uint32_t wordOf(uint32_t localIndex) const;

    SbtInput input_;
    uint32_t firstSbtIndex_;
    uint32_t firstWord_; // of all primitives if the words do not vary
};

// The build input of a primitive, from its word in a leaf: the last input whose SBT indices begin
// at or before the primitive's.
inline uint32_t inputOf(const BlockHeader& header, const InputRecord* inputs, uint32_t sbtWord) {
    if (header.numInputs == 1)
        return 0;
    const uint32_t index = sbtWord & kSbtIndexMask;
    const InputRecord* after = std::upper_bound(
        inputs, inputs + header.numInputs, index,
        [](uint32_t value, const InputRecord& input) { return value < input.firstSbtIndex; });
    return uint32_t(after - inputs) - 1;
}

// The padding of a box on each side, if `size` is its longest edge.
inline float boxPadding(float size) {
    return size * 0x1p-21f;
}

// Remembers which children can be read, with fewer system calls than instances. Call it before the
// first instanceAt().
void lookAtChildren(const InstanceInput& input);

// The description of the i-th instance of the input.
InstanceDesc instanceAt(const InstanceInput& input, uint32_t i);

// Fills the record of an instance and its box; false if it is inactive.
bool describeInstance(const InstanceDesc& from, uint32_t index, OpenLevels levels,
                      InstanceRecord& to, float lower[3], float upper[3]);

// The record of a build input in the block.
InputRecord makeInputRecord(const SbtInput& sbt, uint32_t firstSbtIndex, uint32_t firstPrimitive,
                            uint32_t numPrimitives, const TriangleInput* triangles);

// Whether the handle points, perhaps through transforms, to an acceleration structure. Never
// faults.
bool leadsToBlock(uint64_t handle);

// Bounds of a handle's object, in its space, at all times; empty if no primitive can be hit.
Box traversableBounds(uint64_t handle);

} // namespace sunstone::bvh
