// SPDX-License-Identifier: Apache-2.0
// Getters that read acceleration structures. Missing data gives NaN or the null handle.
#pragma once

#include "bvh/gpu/build/shared_records.h"
#include "bvh/gpu/layout.h"
#include "bvh/gpu/motion.h"
#include "bvh/shapes/curves.h"
#include "devlib/gpu/programs.h"

namespace sunstone::devlib::gpu {

// The block of a valid handle, or null.
SUNSTONE_INLINE const bvh::BlockHeader* blockOf(uint64_t handle, HandleTag tag) {
    const auto* header = reinterpret_cast<const bvh::BlockHeader*>(addressOf(handle));
    return tagOf(handle) == tag && header && header->magic == bvh::gpu::kGpuBlockMagic ? header
                                                                                       : nullptr;
}

// The block of an arbitrary number if that is a valid handle, or null.
SUNSTONE_INLINE const bvh::BlockHeader* blockOf(const LaunchState* launch, uint64_t handle,
                                                HandleTag tag) {
    return isKnown(launch, handle) ? blockOf(handle, tag) : nullptr;
}

extern "C" void sunstone_gpu_gasMotion(const LaunchState* launch, uint64_t gas, GasMotion* motion) {
    const bvh::BlockHeader* const block = blockOf(launch, gas, kTagGas);
    *motion = {1, 0, 0};
    if (block)
        *motion = {block->motionKeys, block->motionBegin, block->motionEnd};
}

// The number of a primitive in the structure, counted over all inputs, or kNoSlot.
SUNSTONE_INLINE uint32_t numberOf(const bvh::BlockHeader* block, uint32_t primitive,
                                  uint32_t sbtGasIndex) {
    const auto* const inputs = reinterpret_cast<const bvh::InputRecord*>(
        reinterpret_cast<const uint8_t*>(block) + block->inputsOffset);
    for (uint32_t i = 0; i < block->numInputs; ++i) {
        const bvh::InputRecord& input = inputs[i];
        if (sbtGasIndex - input.firstSbtIndex >= input.numSbtRecords)
            continue;
        const uint32_t local = primitive - input.primitiveIndexOffset;
        return local < input.numPrimitives ? input.firstPrimitive + local : bvh::kNoSlot;
    }
    return bvh::kNoSlot;
}

// The record, at the first key, of a triangle in the structure's table, or null.
SUNSTONE_INLINE const float* triangleRecord(const bvh::BlockHeader* block, uint32_t primitive,
                                            uint32_t sbtGasIndex) {
    if (!block || bvh::kindOf(block->type) != bvh::BlockType::kTriangles || block->tableOffset == 0)
        return nullptr;
    const uint32_t number = numberOf(block, primitive, sbtGasIndex);
    if (number == bvh::kNoSlot)
        return nullptr;
    const auto* const bytes = reinterpret_cast<const uint8_t*>(block);
    const uint32_t record = reinterpret_cast<const uint32_t*>(bytes + block->tableOffset)[number];
    if (record == bvh::kNoSlot)
        return nullptr;
    return reinterpret_cast<const float*>(bytes + block->recordsOffset +
                                          uint64_t(record) * block->motionKeys *
                                              sizeof(bvh::gpu::TriangleRecord));
}

extern "C" void sunstone_gpu_triangleVertices(const LaunchState* launch, uint64_t gas,
                                              uint32_t primitive, uint32_t sbtGasIndex, float time,
                                              float* vertices) {
    const bvh::BlockHeader* const block = blockOf(launch, gas, kTagGas);
    const float* const record = triangleRecord(block, primitive, sbtGasIndex);
    if (!record) {
        for (uint32_t i = 0; i < 9; ++i)
            vertices[i] = __builtin_nanf("");
        return;
    }
    constexpr uint32_t kNext = sizeof(bvh::gpu::TriangleRecord) / sizeof(float);
    const bool moves = bvh::isMoving(block->type);
    const bvh::KeySegment at = moves ? bvh::keySegment(*block, time) : bvh::KeySegment{0, 0.0f};
    const float* const first = record + at.key * kNext;
    for (uint32_t i = 0; i < 9; ++i) {
        const uint32_t place = i / 3 * 4 + i % 3;
        vertices[i] = moves ? bvh::gpu::mixVertex(first[place], first[kNext + place], at.fraction)
                            : first[place];
    }
}

// Control points of a curve's segment, or centre and radius of a sphere.
extern "C" void sunstone_gpu_shapePoints(const LaunchState* launch, uint64_t gas, uint32_t shape,
                                         uint32_t primitive, uint32_t sbtGasIndex, float time,
                                         float* points) {
    const uint32_t count =
        bvh::isCurveBasis(shape) ? bvh::curvePointFloats(bvh::CurveBasis(shape), 1) : 4;
    const bvh::BlockHeader* const block = blockOf(launch, gas, kTagGas);
    const bool open = block && bvh::kindOf(block->type) == bvh::BlockType::kShapes &&
                      block->shape == shape && (block->options & bvh::kOptionVertexAccess);
    const uint32_t number = open ? numberOf(block, primitive, sbtGasIndex) : bvh::kNoSlot;
    if (number == bvh::kNoSlot) {
        for (uint32_t i = 0; i < count; ++i)
            points[i] = __builtin_nanf("");
        return;
    }
    const bool moves = bvh::isMoving(block->type);
    const bvh::KeySegment at = moves ? bvh::keySegment(*block, time) : bvh::KeySegment{0, 0.0f};
    const float* const first = reinterpret_cast<const float*>(
                                   reinterpret_cast<const uint8_t*>(block) + block->pointsOffset) +
                               (uint64_t(number) * block->motionKeys + at.key) * count;
    for (uint32_t i = 0; i < count; ++i)
        points[i] = moves ? bvh::gpu::mixPoint(first[i], first[count + i], at.fraction) : first[i];
}

extern "C" uint64_t sunstone_gpu_instanceHandle(const LaunchState* launch, uint64_t ias,
                                                uint32_t index) {
    const bvh::BlockHeader* const block = blockOf(launch, ias, kTagIas);
    if (!block || !(block->options & bvh::kOptionInstanceAccess) || index >= block->numPrimitives)
        return 0;
    return makeHandle(reinterpret_cast<const uint8_t*>(block) + block->instancesOffset +
                          uint64_t(index) * sizeof(bvh::InstanceRecord),
                      kTagInstance);
}

} // namespace sunstone::devlib::gpu
