// SPDX-License-Identifier: Apache-2.0
#include "bvh/shapes/shape_input.h"

#include "base/error.h"
#include "bvh/input/build_input.h"
#include "bvh/input/input_lookup.h"
#include "bvh/motion/motion.h"
#include "bvh/parallel.h"
#include "bvh/shapes/shape_geometry.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace sunstone::bvh {
namespace {

constexpr size_t kReadBlock = 1u << 12;

// One array of floats in the caller's memory, at one motion key.
class FloatReader {
public:
    FloatReader(const void* memory, const void* const* keys, uint32_t key, size_t stride)
        : memory_(static_cast<const uint8_t*>(keys ? keys[key] : memory)), stride_(stride) {}
    explicit operator bool() const { return memory_ != nullptr; }
    void read(uint32_t index, uint32_t count, float* to) const {
        std::memcpy(to, memory_ + index * stride_, count * sizeof(float));
    }

private:
    const uint8_t* memory_;
    size_t stride_;
};

class CurveReader {
public:
    explicit CurveReader(const CurveInput& input)
        : input_(input), degree_(degreeOf(CurveBasis(input.basis))),
          indexStride_(input.indexStride ? input.indexStride : 4) {}

    // Reads control points at a key; NaN if an index is invalid.
    bool read(uint32_t segment, uint32_t key, float* points) const {
        const FloatReader vertices(input_.vertices, input_.keyVertices, key,
                                   input_.vertexStride ? input_.vertexStride : 12);
        const FloatReader radii(input_.radii, input_.keyRadii, key,
                                input_.radiusStride ? input_.radiusStride : 4);
        uint32_t first;
        if (!vertices || !radii || !index(segment, first) ||
            uint64_t(first) + degree_ >= input_.numVertices) {
            std::fill(points, points + 4 * (degree_ + 1), std::numeric_limits<float>::quiet_NaN());
            return false;
        }
        for (uint32_t i = 0; i <= degree_; ++i) {
            vertices.read(first + i, 3, points + 4 * i);
            radii.read(first + i, 1, points + 4 * i + 3);
        }
        return true;
    }

    // A strand continues if the next segment begins one vertex later.
    uint32_t capFlags(uint32_t segment) const {
        uint32_t here, other;
        if (!input_.caps || !index(segment, here))
            return 0;
        uint32_t flags = 0;
        if (segment == 0 || !index(segment - 1, other) || other + 1 != here)
            flags |= kCurveCapBegin;
        if (segment + 1 >= input_.numSegments || !index(segment + 1, other) || other != here + 1)
            flags |= kCurveCapEnd;
        return flags;
    }

private:
    bool index(uint32_t segment, uint32_t& out) const {
        if (!input_.indices)
            return false;
        std::memcpy(&out, static_cast<const uint8_t*>(input_.indices) + segment * indexStride_, 4);
        return true;
    }

    CurveInput input_;
    uint32_t degree_;
    size_t indexStride_;
};

bool readSphere(const SphereInput& input, uint32_t sphere, uint32_t key, float* point) {
    const FloatReader centres(input.centres, input.keyCentres, key,
                              input.centreStride ? input.centreStride : 12);
    const FloatReader radii(input.radii, input.keyRadii, key,
                            input.radiusStride ? input.radiusStride : 4);
    if (!centres || !radii) {
        std::fill(point, point + 4, std::numeric_limits<float>::quiet_NaN());
        return false;
    }
    centres.read(sphere, 3, point);
    radii.read(input.oneRadius ? 0 : sphere, 1, point + 3);
    return true;
}

} // namespace

uint32_t shapeOf(const BuildInputs& inputs) {
    return inputs.curves.empty() ? kSphereShape : inputs.curves[0].basis;
}

uint32_t shapeCount(const BuildInputs& inputs, uint32_t input) {
    return inputs.curves.empty() ? inputs.spheres[input].numSpheres
                                 : inputs.curves[input].numSegments;
}

const SbtInput& shapeSbt(const BuildInputs& inputs, uint32_t input) {
    return inputs.curves.empty() ? inputs.spheres[input].sbt : inputs.curves[input].sbt;
}

void requireOneShape(const BuildInputs& inputs) {
    const uint32_t shape = shapeOf(inputs);
    if (!inputs.triangles.empty() || !inputs.customs.empty() || inputs.instances ||
        (!inputs.curves.empty() && !inputs.spheres.empty()))
        fail(Code::kInvalidValue, "a build takes one kind of inputs");
    for (uint32_t i = 0; i < inputs.curves.size(); ++i) {
        if (!isCurveBasis(inputs.curves[i].basis))
            fail(Code::kInvalidValue, "build input ", i, ": ", inputs.curves[i].basis,
                 " is no type of round curves");
        if (inputs.curves[i].basis != shape)
            fail(Code::kInvalidValue, "build input ", i,
                 " has another type of curves than the first");
    }
}

uint32_t maxPieces(uint32_t shape, const BuildOptions& options) {
    if (!isCurveBasis(shape) || options.preferFastBuild)
        return 1;
    return options.preferFastTrace ? 4 : 2;
}

InputRecord shapeInputRecord(const BuildInputs& inputs, uint32_t i, uint32_t firstSbt,
                             uint32_t firstPrimitive) {
    InputRecord record = makeInputRecord(shapeSbt(inputs, i), firstSbt, firstPrimitive,
                                         shapeCount(inputs, i), nullptr);
    record.formats = shapeOf(inputs) << 1;
    if (!inputs.curves.empty()) {
        record.formats |= inputs.curves[i].caps;
        record.numVertices = inputs.curves[i].numVertices;
    } else {
        record.formats |= inputs.spheres[i].oneRadius;
    }
    return record;
}

ShapeStore::ShapeStore(void* block) {
    const BlockHeader& header = *headerOf(block);
    auto* bytes = static_cast<uint8_t*>(block);
    shape = header.shape;
    keys = header.motionKeys;
    points = reinterpret_cast<float*>(bytes + header.pointsOffset);
    records = reinterpret_cast<ShapeRecord*>(bytes + header.recordsOffset);
}

const float* ShapeStore::pointsOf(uint32_t number, uint32_t key) const {
    return points + (size_t(number) * keys + key) * shapeFloats(shape);
}

void ShapeStore::read(const BuildInputs& inputs) const {
    uint32_t first = 0, firstSbt = 0;
    const size_t floats = shapeFloats(shape);
    for (uint32_t input = 0; input < numShapeInputs(inputs); ++input) {
        const SbtInput& sbtInput = shapeSbt(inputs, input);
        const SbtReader sbt(sbtInput, firstSbt);
        const bool curves = !inputs.curves.empty();
        const CurveReader reader(curves ? inputs.curves[input] : CurveInput{});
        auto body = [&](size_t begin, size_t end, size_t) {
            for (size_t i = begin; i < end; ++i) {
                const uint32_t local = uint32_t(i);
                ShapeRecord& record = records[first + local];
                record = {sbt.primitiveIndex(local), sbt.sbtWord(local),
                          curves ? reader.capFlags(local) : 0};
                for (uint32_t key = 0; key < keys; ++key) {
                    float* to = points + (size_t(first + local) * keys + key) * floats;
                    const bool there = curves ? reader.read(local, key, to)
                                              : readSphere(inputs.spheres[input], local, key, to);
                    if (!there || !isActiveShape(shape, to))
                        record.flags |= kShapeInactive;
                }
            }
        };
        parallelBlocks(shapeCount(inputs, input), kReadBlock, body);
        first += shapeCount(inputs, input);
        firstSbt += sbtInput.numSbtRecords;
    }
}

bool shapePoints(const void* block, uint32_t shape, uint32_t primitive, uint32_t sbtGasIndex,
                 float time, float* points) noexcept {
    if (!isBlock(block))
        return false;
    const BlockHeader& header = *headerOf(block);
    if (kindOf(header.type) != BlockType::kShapes || header.shape != shape ||
        !(header.options & kOptionVertexAccess))
        return false;
    const auto* const bytes = static_cast<const uint8_t*>(block);
    const InputRecord* input = inputWithSbtIndex(header, sbtGasIndex);
    const uint32_t local = input ? primitive - input->primitiveIndexOffset : 0;
    if (!input || local >= input->numPrimitives)
        return false;
    const uint32_t floats = shapeFloats(shape);
    const KeySegment segment = keySegment(header, time);
    const auto* const from =
        reinterpret_cast<const float*>(bytes + header.pointsOffset) +
        (size_t(input->firstPrimitive + local) * header.motionKeys + segment.key) * floats;
    for (uint32_t k = 0; k < floats; ++k)
        points[k] = header.motionKeys > 1
                        ? pointBetween(from[k], from[floats + k], segment.fraction)
                        : from[k];
    return true;
}

} // namespace sunstone::bvh
