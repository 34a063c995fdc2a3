// SPDX-License-Identifier: Apache-2.0
#include "bvh/motion/motion_refit.h"

#include "bvh/motion/motion_bounds.h"
#include "bvh/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sunstone::bvh {
namespace {

// Subtrees of fewer bytes are one task.
constexpr uint64_t kTaskBytes = 1u << 18;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

// Bounds and contents below a place in the tree at one key. Boxes are only minima and maxima, so
// the order in which threads finish does not matter.
struct KeyExtent {
    float lower[3] = {kInf, kInf, kInf}; // padded, as nodes hold them
    float upper[3] = {-kInf, -kInf, -kInf};
    float exactLower[3] = {kInf, kInf, kInf};
    float exactUpper[3] = {-kInf, -kInf, -kInf};
    uint32_t active = 0;

    void add(const float low[3], const float high[3]) {
        float padLow[3], padHigh[3];
        for (int a = 0; a < 3; ++a) {
            padLow[a] = low[a];
            padHigh[a] = high[a];
        }
        padBox(padLow, padHigh);
        for (int a = 0; a < 3; ++a) {
            lower[a] = std::min(lower[a], padLow[a]);
            upper[a] = std::max(upper[a], padHigh[a]);
            exactLower[a] = std::min(exactLower[a], low[a]);
            exactUpper[a] = std::max(exactUpper[a], high[a]);
        }
        ++active;
    }
    void add(const KeyExtent& e) {
        for (int a = 0; a < 3; ++a) {
            lower[a] = std::min(lower[a], e.lower[a]);
            upper[a] = std::max(upper[a], e.upper[a]);
            exactLower[a] = std::min(exactLower[a], e.exactLower[a]);
            exactUpper[a] = std::max(exactUpper[a], e.exactUpper[a]);
        }
        active += e.active;
    }
};

class MotionRefit {
public:
    MotionRefit(uint8_t* block, const Sources& sources, const MotionReader& reader,
                const InstanceMotion& instances)
        : block_(block), header_(*reinterpret_cast<BlockHeader*>(block)), sources_(sources),
          reader_(reader), instances_(instances),
          inputs_(reinterpret_cast<const InputRecord*>(block + header_.inputsOffset)),
          keys_(header_.motionKeys) {}

    void run() {
        const NodeRef root = header_.options & kOptionUpdate ? header_.wholeRoot : header_.root;
        auto* const keyBounds = reinterpret_cast<KeyBounds*>(block_ + header_.keyBoundsOffset);
        KeyExtent all;
        for (uint32_t key = 0; key < keys_; ++key) {
            const KeyExtent extent =
                root == kNoNode ? KeyExtent{} : refitRef(root, header_.usedSize, key);
            std::copy(extent.exactLower, extent.exactLower + 3, keyBounds[key].lower);
            std::copy(extent.exactUpper, extent.exactUpper + 3, keyBounds[key].upper);
            all.add(extent);
            header_.numActive = extent.active;
        }
        header_.root = header_.numActive ? root : kNoNode;
        std::copy(all.exactLower, all.exactLower + 3, header_.lower);
        std::copy(all.exactUpper, all.exactUpper + 3, header_.upper);
    }

private:
    // Refits the subtree of the reference at a key; leaves are read at the first key. An inner
    // node's subtree ends at `end`.
    KeyExtent refitRef(NodeRef ref, uint64_t end, uint32_t key) const {
        const uint64_t offset = offsetOf(ref);
        if ((ref & kNodeTagMask) == kInner)
            return refitNode(offset, end, key);
        switch (kindOf(header_.type)) {
        case BlockType::kTriangles:
            return (ref & kNodeTagMask) == kLeaf ? refitTriangles<4>(offset, key)
                                                 : refitTriangles<8>(offset, key);
        case BlockType::kCustom:
            return refitCustom(offset, key);
        default:
            return refitInstance(offset, key);
        }
    }

    // Subtrees of inner children are contiguous, in the order of the children.
    KeyExtent refitNode(uint64_t offset, uint64_t end, uint32_t key) const {
        const Node& node = *reinterpret_cast<const Node*>(block_ + offset);
        const uint32_t count = node.numChildren;
        uint64_t ends[8] = {};
        uint64_t next = end;
        for (uint32_t i = count; i-- > 0;) {
            ends[i] = next;
            if ((node.children[i] & kNodeTagMask) == kInner)
                next = offsetOf(node.children[i]);
        }
        KeyExtent children[8];
        auto body = [&](size_t begin, size_t stop, size_t) {
            for (size_t i = begin; i < stop; ++i)
                children[i] = refitRef(node.children[i], ends[i], key);
        };
        if (end - offset < kTaskBytes)
            body(0, count, 0);
        else
            parallelBlocks(count, 1, body);
        float(*const planes)[8] = keyPlanes(block_ + offset, key);
        KeyExtent all;
        for (uint32_t i = 0; i < 8; ++i) {
            for (int a = 0; a < 3; ++a) {
                planes[2 * a][i] = children[i].active ? children[i].lower[a] : kFar;
                planes[2 * a + 1][i] = children[i].active ? children[i].upper[a] : -kFar;
            }
            all.add(children[i]);
        }
        return all;
    }

    template <unsigned N>
    KeyExtent refitTriangles(uint64_t offset, uint32_t key) const {
        auto& leaf = *reinterpret_cast<TriangleLeaf<N>*>(block_ + offset);
        const uint32_t count = std::min(leaf.count, N);
        if (key == 0) {
            for (uint32_t lane = 0; lane < N; ++lane)
                readLane(leaf, lane, lane < count);
            clearRest(&leaf, sizeof(leaf), sizeof(TriangleKey<N>), 64);
        }
        const float* v = verticesAt(leaf, key);
        KeyExtent extent;
        for (uint32_t lane = 0; lane < count; ++lane) {
            if (std::isnan(v[lane]))
                continue;
            float lower[3], upper[3];
            for (uint32_t a = 0; a < 3; ++a) {
                const float x = v[a * N + lane], y = v[(3 + a) * N + lane],
                            z = v[(6 + a) * N + lane];
                lower[a] = std::min({x, y, z});
                upper[a] = std::max({x, y, z});
            }
            extent.add(lower, upper);
        }
        return extent;
    }

    // Zeroes the bytes after the last key, so that blocks of equal inputs are equal.
    void clearRest(void* leaf, uint32_t size, uint32_t keySize, uint32_t unit) const {
        const uint32_t used = size + (keys_ - 1) * keySize;
        std::memset(static_cast<uint8_t*>(leaf) + used, 0,
                    leafBytes(size, keySize, keys_, unit) - used);
    }

    template <unsigned N>
    static float* verticesAt(TriangleLeaf<N>& leaf, uint32_t key) {
        return key == 0 ? leaf.vertices
                        : reinterpret_cast<TriangleKey<N>*>(&leaf + 1)[key - 1].vertices;
    }

    // Reads vertices at all keys; NaN at all keys if the triangle is inactive or the lane unused.
    template <unsigned N>
    void readLane(TriangleLeaf<N>& leaf, uint32_t lane, bool used) const {
        TriangleCheck check;
        if (used) {
            const uint32_t input = inputOf(header_, inputs_, leaf.sbt[lane]);
            const uint32_t primitive = leaf.primitive[lane] - inputs_[input].primitiveIndexOffset;
            if (sources_.sbt[input].varies())
                leaf.sbt[lane] = sources_.sbt[input].sbtWord(primitive);
            for (uint32_t key = 0; key < keys_; ++key) {
                float v[9];
                if (!reader_.triangles(input, key).readUnchecked(primitive, v))
                    v[0] = kNaN;
                check.add(v);
                float* const to = verticesAt(leaf, key);
                for (uint32_t i = 0; i < 9; ++i)
                    to[i * N + lane] = v[i];
            }
        }
        for (uint32_t key = 0; key < keys_ && !check.active(); ++key)
            for (uint32_t i = 0; i < 9; ++i)
                verticesAt(leaf, key)[i * N + lane] = kNaN;
    }

    KeyExtent refitCustom(uint64_t offset, uint32_t key) const {
        auto& leaf = *reinterpret_cast<CustomLeaf*>(block_ + offset);
        auto* const later = reinterpret_cast<CustomKey*>(&leaf + 1);
        if (key == 0) {
            readCustom(leaf, later);
            clearRest(&leaf, sizeof(leaf), sizeof(CustomKey), kRefUnit);
        }
        KeyExtent extent;
        const float* const lower = key == 0 ? leaf.lower : later[key - 1].lower;
        const float* const upper = key == 0 ? leaf.upper : later[key - 1].upper;
        if (lower[0] <= upper[0])
            extent.add(lower, upper);
        return extent;
    }

    // Reads boxes at all keys; empty at all keys if the primitive is inactive.
    void readCustom(CustomLeaf& leaf, CustomKey* later) const {
        const uint32_t input = inputOf(header_, inputs_, leaf.sbt);
        const uint32_t primitive = leaf.primitive - inputs_[input].primitiveIndexOffset;
        leaf.sbt = sources_.sbt[input].sbtWord(primitive);
        bool active = true;
        for (uint32_t key = 0; key < keys_ && active; ++key)
            active = reader_.customs(input, key)
                         .read(primitive, key == 0 ? leaf.lower : later[key - 1].lower,
                               key == 0 ? leaf.upper : later[key - 1].upper);
        for (uint32_t key = 0; key < keys_ && !active; ++key) {
            float* const lower = key == 0 ? leaf.lower : later[key - 1].lower;
            float* const upper = key == 0 ? leaf.upper : later[key - 1].upper;
            std::copy(kNoBounds.lower, kNoBounds.lower + 3, lower);
            std::copy(kNoBounds.upper, kNoBounds.upper + 3, upper);
        }
    }

    KeyExtent refitInstance(uint64_t offset, uint32_t key) const {
        auto& record = *reinterpret_cast<InstanceRecord*>(block_ + offset);
        KeyBounds* const keys = instances_.bounds + uint64_t(record.index) * keys_;
        if (key == 0 && instances_.read) {
            const uint32_t index = record.index;
            const MotionOptions motion{keys_, header_.motionFlags, header_.motionBegin,
                                       header_.motionEnd};
            describeMovingInstance(instanceAt(*sources_.instances, index), index,
                                   OpenLevels::of(header_.options), motion, record, keys);
        }
        KeyExtent extent;
        if (keys[key].lower[0] <= keys[key].upper[0])
            extent.add(keys[key].lower, keys[key].upper);
        return extent;
    }

    uint8_t* block_;
    BlockHeader& header_;
    const Sources& sources_;
    const MotionReader& reader_;
    const InstanceMotion& instances_;
    const InputRecord* inputs_;
    uint32_t keys_;
};

} // namespace

void refitMotion(uint8_t* block, const Sources& sources, const MotionReader& reader,
                 const InstanceMotion& instances) {
    MotionRefit(block, sources, reader, instances).run();
}

bool describeMovingInstance(const InstanceDesc& from, uint32_t index, OpenLevels levels,
                            const MotionOptions& motion, InstanceRecord& to, KeyBounds* keys) {
    float lower[3], upper[3];
    bool active = describeInstance(from, index, levels, to, lower, upper);
    if (active && !moves(to.child)) {
        for (uint32_t key = 0; key < motion.keys; ++key) {
            std::copy(lower, lower + 3, keys[key].lower);
            std::copy(upper, upper + 3, keys[key].upper);
        }
    } else if (active) {
        describeMotion(to, motion, keys);
        for (uint32_t key = 0; key < motion.keys; ++key)
            active = active && endBox(keys[key].lower, keys[key].upper);
    }
    if (!active)
        std::fill(keys, keys + motion.keys, kNoBounds);
    return active;
}

} // namespace sunstone::bvh
