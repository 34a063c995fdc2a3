// SPDX-License-Identifier: Apache-2.0
// Writers of the leaves of triangles, custom primitives and instances.
#pragma once

#include "bvh/build/emit.h"
#include "bvh/build/presplit.h"
#include "bvh/input/build_input.h"
#include "bvh/layout.h"
#include "bvh/refit/refit.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace sunstone::bvh {

class TriangleWriter final : public LeafWriter {
public:
    // checked: references may lead to inactive triangles.
    TriangleWriter(const Sources& sources, const InputRecord* inputs, uint32_t* table, bool checked)
        : sources_(sources), inputs_(inputs), table_(table), checked_(checked) {}

    void prefetch(const PrimitiveRef* references, uint32_t count, int round) const override {
        for (uint32_t i = 0; i < count; ++i) {
            const PrimitiveRef& r = references[i];
            const TriangleReader& reader = sources_.triangles[r.input & ~kDuplicate];
            if (round == 0)
                reader.prefetchIndices(r.primitive);
            else
                reader.prefetchVertices(r.primitive);
        }
    }

    NodeRef write(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                  uint32_t count) const override {
        if (count <= 4) {
            fillLeaf<4>(block, offset, references, count);
            return makeRef(offset, kLeaf);
        }
        fillLeaf<8>(block, offset, references, count);
        return makeRef(offset, kWideLeaf);
    }

private:
    template <unsigned N>
    void fillLeaf(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                  uint32_t count) const {
        auto& leaf = *reinterpret_cast<TriangleLeaf<N>*>(block + offset);
        uint32_t used = 0;
        const PrimitiveRef* lanes[N];
        for (uint32_t i = 0; i < count; ++i) {
            const PrimitiveRef& r = references[i];
            const uint32_t input = r.input & ~kDuplicate;
            // A leaf may contain several parts of one split triangle.
            uint32_t lane = 0;
            while (lane < used && (lanes[lane]->primitive != r.primitive ||
                                   (lanes[lane]->input & ~kDuplicate) != input))
                ++lane;
            if (lane == used) {
                lanes[used++] = &r;
                fillLane(leaf, lane, input, r.primitive);
            }
            if (table_ && !(r.input & kDuplicate))
                table_[inputs_[input].firstPrimitive + r.primitive] =
                    makeSlot(offset, N == 8, lane);
        }
        for (uint32_t lane = used; lane < N; ++lane) {
            for (uint32_t i = 0; i < 9; ++i)
                leaf.vertices[i * N + lane] = std::numeric_limits<float>::quiet_NaN();
            leaf.primitive[lane] = ~0u;
            leaf.sbt[lane] = 0;
        }
        leaf.count = used;
        std::fill(std::begin(leaf.pad), std::end(leaf.pad), 0u);
    }

    template <unsigned N>
    void fillLane(TriangleLeaf<N>& leaf, uint32_t lane, uint32_t input, uint32_t primitive) const {
        float v[9];
        const TriangleReader& reader = sources_.triangles[input];
        if (!(checked_ ? reader.read(primitive, v) : reader.readUnchecked(primitive, v)))
            std::fill(v, v + 9, std::numeric_limits<float>::quiet_NaN());
        leaf.primitive[lane] = sources_.sbt[input].primitiveIndex(primitive);
        leaf.sbt[lane] = sources_.sbt[input].sbtWord(primitive);
        for (uint32_t i = 0; i < 9; ++i)
            leaf.vertices[i * N + lane] = v[i];
    }

    const Sources& sources_;
    const InputRecord* inputs_;
    uint32_t* table_;
    bool checked_;
};

class CustomWriter final : public LeafWriter {
public:
    explicit CustomWriter(const Sources& sources) : sources_(sources) {}

    NodeRef write(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                  uint32_t) const override {
        auto& leaf = *reinterpret_cast<CustomLeaf*>(block + offset);
        const PrimitiveRef& r = *references;
        if (!sources_.customs[r.input].read(r.primitive, leaf.lower, leaf.upper)) {
            std::fill(leaf.lower, leaf.lower + 3, __builtin_inff());
            std::fill(leaf.upper, leaf.upper + 3, -__builtin_inff());
        }
        leaf.primitive = sources_.sbt[r.input].primitiveIndex(r.primitive);
        leaf.sbt = sources_.sbt[r.input].sbtWord(r.primitive);
        return makeRef(offset, kLeaf);
    }

private:
    const Sources& sources_;
};

class InstanceWriter final : public LeafWriter {
public:
    explicit InstanceWriter(uint64_t instancesOffset) : instancesOffset_(instancesOffset) {}

    NodeRef write(uint8_t*, uint64_t, const PrimitiveRef* references, uint32_t) const override {
        return makeRef(instancesOffset_ + references->primitive * sizeof(InstanceRecord), kLeaf);
    }

private:
    uint64_t instancesOffset_;
};

} // namespace sunstone::bvh
