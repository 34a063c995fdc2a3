// SPDX-License-Identifier: Apache-2.0
#include "bvh/input/build_input.h"

#include "base/readable.h"
#include "bvh/motion/motion_bounds.h"
#include "bvh/motion/transforms.h"
#include "bvh/parallel.h"
#include "math/affine.h"

#include <algorithm>
#include <cstring>

namespace sunstone::bvh {
namespace {

template <class T>
T readAs(const void* address) {
    T value;
    std::memcpy(&value, address, sizeof(T));
    return value;
}

float halfToFloat(uint16_t h) {
    const uint32_t sign = uint32_t(h & 0x8000u) << 16;
    const uint32_t exponent = h >> 10 & 31, mantissa = h & 0x3FFu;
    float value;
    if (exponent == 31)
        value = mantissa ? std::numeric_limits<float>::quiet_NaN()
                         : std::numeric_limits<float>::infinity();
    else if (exponent == 0)
        value = float(mantissa) * 0x1p-24f;
    else
        value = readAs<float>(
            std::initializer_list<uint32_t>{(exponent + 112) << 23 | mantissa << 13}.begin());
    return sign ? -value : value;
}

float snormToFloat(uint16_t bits) {
    return std::max(float(int16_t(bits)) / 32767.0f, -1.0f);
}

uint32_t packedVertexSize(VertexFormat format) {
    switch (format) {
    case VertexFormat::kFloat3:
        return 12;
    case VertexFormat::kFloat2:
        return 8;
    case VertexFormat::kHalf3:
    case VertexFormat::kSnorm16x3:
        return 6;
    default:
        return 4;
    }
}

} // namespace

bool hasArea(const float v[9]) {
    double e[2][3];
    for (int i = 0; i < 3; ++i) {
        e[0][i] = double(v[3 + i]) - v[i];
        e[1][i] = double(v[6 + i]) - v[i];
    }
    return e[0][1] * e[1][2] != e[0][2] * e[1][1] || e[0][2] * e[1][0] != e[0][0] * e[1][2] ||
           e[0][0] * e[1][1] != e[0][1] * e[1][0];
}

void padBox(float lower[3], float upper[3]) {
    const float size =
        boxPadding(std::max({upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]}));
    for (int i = 0; i < 3; ++i) {
        lower[i] -= size;
        upper[i] += size;
    }
}

uint32_t triangleCount(const TriangleInput& input) {
    return input.indexFormat == IndexFormat::kNone ? input.numVertices / 3 : input.numTriangles;
}

TriangleReader::TriangleReader(const TriangleInput& input)
    : vertices_(static_cast<const uint8_t*>(input.vertices)),
      indices_(static_cast<const uint8_t*>(input.indices)), vertexFormat_(input.vertexFormat),
      indexFormat_(input.indexFormat),
      vertexStride_(input.vertexStride ? input.vertexStride : packedVertexSize(input.vertexFormat)),
      indexStride_(input.indexStride                            ? input.indexStride
                   : input.indexFormat == IndexFormat::kUshort3 ? 6u
                                                                : 12u),
      numVertices_(input.vertices ? input.numVertices : 0), count_(triangleCount(input)) {
    if (indexFormat_ != IndexFormat::kNone && !indices_)
        numVertices_ = 0; // every triangle inactive
    if (input.preTransform) {
        transformed_ = true;
        std::memcpy(transform_, input.preTransform, sizeof transform_);
    }
    plain_ = vertexFormat_ == VertexFormat::kFloat3 && !transformed_;
}

void TriangleReader::vertex(uint32_t index, float out[3]) const {
    const uint8_t* const address = vertices_ + index * vertexStride_;
    uint16_t words[3] = {};
    switch (vertexFormat_) {
    case VertexFormat::kFloat3:
        std::memcpy(out, address, 12);
        return;
    case VertexFormat::kFloat2:
        std::memcpy(out, address, 8);
        out[2] = 0;
        return;
    case VertexFormat::kHalf3:
    case VertexFormat::kHalf2:
        std::memcpy(words, address, vertexFormat_ == VertexFormat::kHalf3 ? 6 : 4);
        for (int i = 0; i < 3; ++i)
            out[i] = halfToFloat(words[i]);
        return;
    case VertexFormat::kSnorm16x3:
    case VertexFormat::kSnorm16x2:
        std::memcpy(words, address, vertexFormat_ == VertexFormat::kSnorm16x3 ? 6 : 4);
        for (int i = 0; i < 3; ++i)
            out[i] = snormToFloat(words[i]);
        return;
    }
    out[0] = out[1] = out[2] = std::numeric_limits<float>::quiet_NaN();
}

void TriangleReader::decode(const uint32_t index[3], float vertices[9]) const {
    for (int i = 0; i < 3; ++i) {
        float* const v = vertices + 3 * i;
        vertex(index[i], v);
        if (transformed_) {
            const math::Vec3 p = math::transformPoint(transform_, {v[0], v[1], v[2]});
            v[0] = p.x, v[1] = p.y, v[2] = p.z;
        }
    }
}

bool TriangleReader::read(uint32_t triangle, float vertices[9]) const {
    if (!readUnchecked(triangle, vertices))
        return false;
    bool good = true;
    for (int i = 0; i < 9; ++i)
        good = good && usable(vertices[i]);
    return good && hasArea(vertices);
}

CustomReader::CustomReader(const CustomInput& input)
    : aabbs_(static_cast<const uint8_t*>(input.aabbs)), stride_(input.stride ? input.stride : 24) {}

bool CustomReader::read(uint32_t primitive, float lower[3], float upper[3]) const {
    if (!aabbs_)
        return false;
    std::memcpy(lower, aabbs_ + primitive * stride_, 12);
    std::memcpy(upper, aabbs_ + primitive * stride_ + 12, 12);
    bool good = true;
    for (int i = 0; i < 3; ++i)
        good = good && lower[i] <= upper[i] && usable(lower[i]) && usable(upper[i]);
    return good;
}

uint32_t SbtReader::localIndex(uint32_t primitive) const {
    const size_t stride =
        input_.indexOffsetStride ? input_.indexOffsetStride : input_.indexOffsetSize;
    const uint8_t* const address =
        static_cast<const uint8_t*>(input_.indexOffsets) + primitive * stride;
    return input_.indexOffsetSize == 1   ? *address
           : input_.indexOffsetSize == 2 ? readAs<uint16_t>(address)
                                         : readAs<uint32_t>(address);
}

uint32_t SbtReader::wordOf(uint32_t localIndex) const {
    // An index beyond the declared records is undefined; clamping to the last record is safe.
    localIndex = std::min(localIndex, std::max(input_.numSbtRecords, 1u) - 1);
    const uint32_t flags = input_.flags && input_.numSbtRecords ? input_.flags[localIndex] : 0;
    return ((firstSbtIndex_ + localIndex) & kSbtIndexMask) | flags << kGeometryFlagShift;
}

namespace {

InstanceDesc givenInstance(const InstanceInput& input, uint32_t i) {
    if (input.instances)
        return *reinterpret_cast<const InstanceDesc*>(
            static_cast<const uint8_t*>(input.instances) +
            size_t(i) * (input.stride ? input.stride : sizeof(InstanceDesc)));
    // A null, misaligned or unmapped address is an instance that is never hit.
    const uint64_t address = input.instancePointers[i];
    if (address == 0 || address % alignof(InstanceDesc) != 0 ||
        !isReadableNearby(reinterpret_cast<const void*>(address), sizeof(InstanceDesc)))
        return {};
    return *reinterpret_cast<const InstanceDesc*>(address);
}

} // namespace

void lookAtChildren(const InstanceInput& input) {
    constexpr size_t kBlock = 1024;
    auto body = [&](size_t begin, size_t end, size_t) {
        if (!input.instances)
            rememberReadable(input.instancePointers + begin, end - begin);
        uint64_t children[kBlock];
        for (size_t i = begin; i < end; ++i)
            children[i - begin] =
                givenInstance(input, uint32_t(i)).traversableHandle & ~devlib::kTagMask;
        rememberReadable(children, end - begin);
    };
    parallelBlocks(input.numInstances, kBlock, body);
}

InstanceDesc instanceAt(const InstanceInput& input, uint32_t i) {
    InstanceDesc instance = givenInstance(input, i);
    if (instance.flags & input.identityFlag) {
        constexpr float kIdentity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        std::memcpy(instance.transform, kIdentity, sizeof(kIdentity));
    }
    instance.flags &= input.knownFlags & ~input.identityFlag;
    return instance;
}

bool describeInstance(const InstanceDesc& from, uint32_t index, OpenLevels levels,
                      InstanceRecord& to, float lower[3], float upper[3]) {
    std::memcpy(to.objectToWorld, from.transform, sizeof to.objectToWorld);
    const bool invertible = math::invert(from.transform, to.worldToObject);
    to.child = from.traversableHandle;
    to.instanceId = from.instanceId;
    to.sbtOffset = from.sbtOffset;
    to.visibilityMask = from.visibilityMask;
    to.flags = from.flags;
    to.index = index;
    if (!invertible || from.traversableHandle == 0 || (from.visibilityMask & 0xFF) == 0)
        return false;
    const Box box = instanceBounds(from.transform, from.traversableHandle, levels);
    for (int a = 0; a < 3; ++a) {
        lower[a] = box.lower[a];
        upper[a] = box.upper[a];
    }
    return endBox(lower, upper); // an empty box has no end
}

InputRecord makeInputRecord(const SbtInput& sbt, uint32_t firstSbtIndex, uint32_t firstPrimitive,
                            uint32_t numPrimitives, const TriangleInput* triangles) {
    InputRecord record{};
    record.firstSbtIndex = firstSbtIndex;
    record.numSbtRecords = sbt.numSbtRecords;
    record.firstPrimitive = firstPrimitive;
    record.numPrimitives = numPrimitives;
    record.primitiveIndexOffset = sbt.primitiveIndexOffset;
    if (triangles) {
        record.formats = uint32_t(triangles->vertexFormat) << 16 | uint32_t(triangles->indexFormat);
        record.numVertices = triangles->numVertices;
    }
    uint32_t hash = 2166136261u; // FNV-1a, a word at a time
    for (uint32_t k = 0; k < sbt.numSbtRecords; ++k)
        hash = (hash ^ (sbt.flags ? sbt.flags[k] : 0)) * 16777619u;
    record.flagsHash = hash;
    return record;
}

bool leadsToBlock(uint64_t handle) {
    for (int i = 0; i < kMaxTransformChain; ++i) {
        const auto* address = reinterpret_cast<const void*>(handle & ~devlib::kTagMask);
        const uint64_t tag = handle & devlib::kTagMask;
        if (isTransformTag(tag)) {
            if (!isReadableTransform(handle))
                return false;
            handle = childOf(handle);
            continue;
        }
        if ((tag != devlib::kTagGas && tag != devlib::kTagIas) ||
            !isReadableNearby(address, sizeof(BlockHeader)))
            return false;
        return looksLikeBlock(headerOf(address));
    }
    return false;
}

Box traversableBounds(uint64_t handle) {
    if (!leadsToBlock(handle))
        return {};
    std::vector<uint64_t> chain;
    for (; isTransformTag(handle & devlib::kTagMask); handle = childOf(handle))
        chain.push_back(handle);
    Box box = bounds(reinterpret_cast<const void*>(handle & ~devlib::kTagMask));
    for (size_t i = chain.size(); i-- > 0;) {
        const auto* still = reinterpret_cast<const StaticTransform*>(chain[i] & ~devlib::kTagMask);
        box = (chain[i] & devlib::kTagMask) == devlib::kTagStatic
                  ? math::transformBox(still->transform, box)
                  : boundsOfMotion(chain[i], box);
    }
    return box;
}

} // namespace sunstone::bvh
