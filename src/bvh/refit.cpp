// SPDX-License-Identifier: Apache-2.0
#include "bvh/refit.h"

#include "bvh/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sunstone::bvh {
namespace {

// Subtrees of fewer bytes are one task.
constexpr uint64_t kTaskBytes = 1u << 18;
constexpr float kInf = std::numeric_limits<float>::infinity();

// What is below a place in the tree. Boxes grow by minimum and maximum alone, so that the order in
// which threads finish does not matter.
struct Extent {
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
    void add(const Extent& e) {
        for (int a = 0; a < 3; ++a) {
            lower[a] = std::min(lower[a], e.lower[a]);
            upper[a] = std::max(upper[a], e.upper[a]);
            exactLower[a] = std::min(exactLower[a], e.exactLower[a]);
            exactUpper[a] = std::max(exactUpper[a], e.exactUpper[a]);
        }
        active += e.active;
    }
};

// Boxes of up to N triangles, with the rules of TriangleReader::read for which are active.
template <unsigned N>
struct LaneBoxes {
    float lower[3][N], upper[3][N], padding[N];
    int32_t active[N];

    explicit LaneBoxes(const float* vertices) {
        for (unsigned lane = 0; lane < N; ++lane)
            active[lane] = 1;
        for (unsigned i = 0; i < 9; ++i)
            for (unsigned lane = 0; lane < N; ++lane)
                active[lane] &= std::fabs(vertices[i * N + lane]) <= kMaxCoordinate;
        checkArea(vertices);
        for (unsigned a = 0; a < 3; ++a)
            for (unsigned lane = 0; lane < N; ++lane) {
                const float x = vertices[a * N + lane], y = vertices[(3 + a) * N + lane],
                            z = vertices[(6 + a) * N + lane];
                const float low = least(least(x, y), z), high = most(most(x, y), z);
                lower[a][lane] = active[lane] ? low : kInf;
                upper[a][lane] = active[lane] ? high : -kInf;
            }
        for (unsigned lane = 0; lane < N; ++lane)
            padding[lane] = boxPadding(
                most(most(upper[0][lane] - lower[0][lane], upper[1][lane] - lower[1][lane]),
                     upper[2][lane] - lower[2][lane]));
    }

    Extent extent() const {
        Extent e;
        for (unsigned lane = 0; lane < N; ++lane)
            e.active += uint32_t(active[lane]);
        for (unsigned a = 0; a < 3; ++a)
            for (unsigned lane = 0; lane < N; ++lane) {
                // -inf is the padding of an empty box, which stays empty.
                e.lower[a] = least(lower[a][lane] - padding[lane], e.lower[a]);
                e.upper[a] = most(upper[a][lane] + padding[lane], e.upper[a]);
                e.exactLower[a] = least(lower[a][lane], e.exactLower[a]);
                e.exactUpper[a] = most(upper[a][lane], e.exactUpper[a]);
            }
        return e;
    }

private:
    static float least(float a, float b) { return a < b ? a : b; }
    static float most(float a, float b) { return a > b ? a : b; }

    // In double precision differences and products of floats are exact or nearly so.
    void checkArea(const float* vertices) {
        double e[2][3][N];
        for (unsigned a = 0; a < 3; ++a)
            for (unsigned lane = 0; lane < N; ++lane) {
                const double first = vertices[a * N + lane];
                e[0][a][lane] = vertices[(3 + a) * N + lane] - first;
                e[1][a][lane] = vertices[(6 + a) * N + lane] - first;
            }
        for (unsigned lane = 0; lane < N; ++lane) {
            const auto product = [&](unsigned i, unsigned j) {
                return e[0][i][lane] * e[1][j][lane];
            };
            active[lane] &= int(product(1, 2) != product(2, 1)) |
                            int(product(2, 0) != product(0, 2)) |
                            int(product(0, 1) != product(1, 0));
        }
    }
};

class Refit {
public:
    Refit(uint8_t* block, const Sources& sources)
        : block_(block), header_(*reinterpret_cast<BlockHeader*>(block)), sources_(sources),
          inputs_(reinterpret_cast<const InputRecord*>(block + header_.inputsOffset)) {}

    void run() {
        Extent all;
        if (header_.wholeRoot != kNoNode)
            all = refitRef(header_.wholeRoot, header_.usedSize);
        header_.root = all.active ? header_.wholeRoot : kNoNode;
        header_.numActive = all.active;
        std::copy(all.exactLower, all.exactLower + 3, header_.lower);
        std::copy(all.exactUpper, all.exactUpper + 3, header_.upper);
    }

private:
    // What the reference leads to; an inner node's subtree ends at `end`.
    Extent refitRef(NodeRef ref, uint64_t end) const {
        const uint64_t offset = offsetOf(ref);
        if ((ref & kNodeTagMask) == kInner)
            return refitNode(offset, end);
        switch (header_.type) {
        case BlockType::kTriangles:
            return (ref & kNodeTagMask) == kLeaf
                       ? refitTriangles(*reinterpret_cast<TriangleLeaf<4>*>(block_ + offset))
                       : refitTriangles(*reinterpret_cast<TriangleLeaf<8>*>(block_ + offset));
        case BlockType::kCustom:
            return refitCustom(*reinterpret_cast<CustomLeaf*>(block_ + offset));
        default:
            return refitInstance(*reinterpret_cast<InstanceData*>(block_ + offset));
        }
    }

    // Subtrees of inner children lie one behind the other, in the order of the children.
    Extent refitNode(uint64_t offset, uint64_t end) const {
        Node& node = *reinterpret_cast<Node*>(block_ + offset);
        const uint32_t count = node.numChildren;
        uint64_t ends[8] = {};
        uint64_t next = end;
        for (uint32_t i = count; i-- > 0;) {
            ends[i] = next;
            if ((node.children[i] & kNodeTagMask) == kInner)
                next = offsetOf(node.children[i]);
        }
        if (header_.type == BlockType::kTriangles)
            prefetchTriangles(node);
        Extent children[8];
        auto body = [&](size_t begin, size_t stop, size_t) {
            for (size_t i = begin; i < stop; ++i)
                children[i] = refitRef(node.children[i], ends[i]);
        };
        if (end - offset < kTaskBytes)
            body(0, count, 0);
        else
            parallelBlocks(count, 1, body);
        Extent all;
        for (uint32_t i = 0; i < count; ++i) {
            for (int a = 0; a < 3; ++a) {
                node.planes[2 * a][i] = children[i].lower[a];
                node.planes[2 * a + 1][i] = children[i].upper[a];
            }
            all.add(children[i]);
        }
        return all;
    }

    // What the leaves of a node will read is scattered over the input buffers: first asks for all
    // indices, then for all vertices.
    void prefetchTriangles(const Node& node) const {
        for (int step = 0; step < 2; ++step)
            for (uint32_t i = 0; i < node.numChildren; ++i) {
                const NodeRef ref = node.children[i];
                const uint8_t* leaf = block_ + offsetOf(ref);
                if ((ref & kNodeTagMask) == kLeaf)
                    prefetchLeaf(*reinterpret_cast<const TriangleLeaf<4>*>(leaf), step);
                else if ((ref & kNodeTagMask) == kWideLeaf)
                    prefetchLeaf(*reinterpret_cast<const TriangleLeaf<8>*>(leaf), step);
            }
    }
    template <unsigned N>
    void prefetchLeaf(const TriangleLeaf<N>& leaf, int step) const {
        for (uint32_t lane = 0; lane < std::min(leaf.count, N); ++lane) {
            const uint32_t input = inputOf(leaf.sbt[lane]);
            const uint32_t primitive = leaf.primitive[lane] - inputs_[input].primitiveIndexOffset;
            const TriangleReader& reader = sources_.triangles[input];
            step == 0 ? reader.prefetchIndices(primitive) : reader.prefetchVertices(primitive);
        }
    }

    uint32_t inputOf(uint32_t sbtWord) const {
        if (header_.numInputs == 1)
            return 0;
        const uint32_t index = sbtWord & kSbtIndexMask;
        const InputRecord* after = std::upper_bound(
            inputs_, inputs_ + header_.numInputs, index,
            [](uint32_t value, const InputRecord& input) { return value < input.firstSbtIndex; });
        return uint32_t(after - inputs_) - 1;
    }

    // Reads the lanes one by one, then judges and measures them side by side.
    template <unsigned N>
    Extent refitTriangles(TriangleLeaf<N>& leaf) const {
        const uint32_t count = std::min(leaf.count, N);
        for (uint32_t lane = 0; lane < count; ++lane) {
            const uint32_t input = inputOf(leaf.sbt[lane]);
            const uint32_t primitive = leaf.primitive[lane] - inputs_[input].primitiveIndexOffset;
            if (sources_.sbt[input].varies())
                leaf.sbt[lane] = sources_.sbt[input].sbtWord(primitive);
            float v[9];
            if (!sources_.triangles[input].readUnchecked(primitive, v))
                v[0] = std::numeric_limits<float>::quiet_NaN();
            for (uint32_t i = 0; i < 9; ++i)
                leaf.vertices[i * N + lane] = v[i];
        }
        LaneBoxes<N> boxes(leaf.vertices);
        const Extent extent = boxes.extent();
        if (extent.active < count)
            for (uint32_t lane = 0; lane < count; ++lane)
                for (uint32_t i = 0; i < 9 && !boxes.active[lane]; ++i)
                    leaf.vertices[i * N + lane] = std::numeric_limits<float>::quiet_NaN();
        return extent;
    }

    Extent refitCustom(CustomLeaf& leaf) const {
        Extent extent;
        const uint32_t input = inputOf(leaf.sbt);
        const uint32_t primitive = leaf.primitive - inputs_[input].primitiveIndexOffset;
        leaf.sbt = sources_.sbt[input].sbtWord(primitive);
        if (sources_.customs[input].read(primitive, leaf.lower, leaf.upper)) {
            extent.add(leaf.lower, leaf.upper);
        } else {
            std::fill(leaf.lower, leaf.lower + 3, kInf);
            std::fill(leaf.upper, leaf.upper + 3, -kInf);
        }
        return extent;
    }

    Extent refitInstance(InstanceData& record) const {
        Extent extent;
        float lower[3], upper[3];
        const uint32_t index = record.index;
        if (describeInstance(instanceAt(*sources_.instances, index), index, record, lower, upper))
            extent.add(lower, upper);
        return extent;
    }

    uint8_t* block_;
    BlockHeader& header_;
    const Sources& sources_;
    const InputRecord* inputs_;
};

} // namespace

Sources::Sources(const BuildInputs& inputs) : instances(inputs.instances) {
    uint32_t firstSbt = 0;
    const auto addSbt = [&](const SbtInput& input) {
        sbt.emplace_back(input, firstSbt);
        firstSbt += input.numSbtRecords;
    };
    for (const TriangleInput& input : inputs.triangles) {
        triangles.emplace_back(input);
        addSbt(input.sbt);
    }
    for (const CustomInput& input : inputs.customs) {
        customs.emplace_back(input);
        addSbt(input.sbt);
    }
}

void refit(uint8_t* block, const Sources& sources) {
    Refit(block, sources).run();
}

} // namespace sunstone::bvh
