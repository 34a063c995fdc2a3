// SPDX-License-Identifier: Apache-2.0
// Leaves in a refit: reads the primitives of a leaf again, by the rules of TriangleReader::read for
// active ones, and returns the leaf's bounds. Four triangles are read, checked and bounded in one
// vector.
#pragma once

#include "bvh/refit/refit.h"

#include <emmintrin.h>

#include <algorithm>
#include <bit>
#include <limits>

namespace sunstone::bvh {

// A box, the upper corner beside the lower. The fourth words are undefined.
struct LaneBox {
    __m128 lower = _mm_set1_ps(std::numeric_limits<float>::infinity());
    __m128 upper = _mm_set1_ps(-std::numeric_limits<float>::infinity());

    void add(const LaneBox& b) {
        lower = _mm_min_ps(b.lower, lower);
        upper = _mm_max_ps(b.upper, upper);
    }
    void add(const float low[3], const float high[3]) {
        add({_mm_setr_ps(low[0], low[1], low[2], 0), _mm_setr_ps(high[0], high[1], high[2], 0)});
    }
};

// Bounds and contents below a place in the tree. Boxes are only minima and maxima, so the order in
// which threads finish does not matter.
struct Extent {
    LaneBox padded; // as nodes hold it
    LaneBox exact;
    uint32_t active = 0;

    void add(const Extent& e) {
        padded.add(e.padded);
        exact.add(e.exact);
        active += e.active;
    }
    void addPrimitive(const float low[3], const float high[3]) {
        float padLow[3], padHigh[3];
        for (int a = 0; a < 3; ++a) {
            padLow[a] = low[a];
            padHigh[a] = high[a];
        }
        padBox(padLow, padHigh);
        padded.add(padLow, padHigh);
        exact.add(low, high);
        ++active;
    }
};

// The minimum (maximum) over the four lanes of x, y and z, in one vector.
inline __m128 leastOfLanes(__m128 x, __m128 y, __m128 z) {
    __m128 w = z;
    _MM_TRANSPOSE4_PS(x, y, z, w);
    return _mm_min_ps(_mm_min_ps(x, y), _mm_min_ps(z, w));
}
inline __m128 mostOfLanes(__m128 x, __m128 y, __m128 z) {
    __m128 w = z;
    _MM_TRANSPOSE4_PS(x, y, z, w);
    return _mm_max_ps(_mm_max_ps(x, y), _mm_max_ps(z, w));
}

class LeafRefit {
public:
    LeafRefit(uint8_t* block, const Sources& sources)
        : block_(block), header_(*headerOf(block)), sources_(sources),
          inputs_(reinterpret_cast<const InputRecord*>(block + header_.inputsOffset)) {}

    // Bytes of a leaf after its node.
    uint64_t bytes(NodeRef ref) const {
        switch (kindOf(header_.type)) {
        case BlockType::kTriangles:
            return isWide(ref) ? sizeof(TriangleLeaf<8>) : sizeof(TriangleLeaf<4>);
        case BlockType::kCustom:
            return sizeof(CustomLeaf);
        default:
            return 0;
        }
    }

    Extent refit(NodeRef ref) const {
        uint8_t* const leaf = block_ + offsetOf(ref);
        switch (kindOf(header_.type)) {
        case BlockType::kTriangles:
            return isWide(ref) ? refitTriangles(*reinterpret_cast<TriangleLeaf<8>*>(leaf))
                               : refitTriangles(*reinterpret_cast<TriangleLeaf<4>*>(leaf));
        case BlockType::kCustom:
            return refitCustom(*reinterpret_cast<CustomLeaf*>(leaf));
        default:
            return refitInstance(*reinterpret_cast<InstanceRecord*>(leaf));
        }
    }

    // The data of leaves is scattered over the input buffers, so indices are prefetched early, and
    // vertices after the indices have arrived.
    void prefetchIndices(NodeRef ref) const {
        forLanes(ref, [](const TriangleReader& r, uint32_t i) { r.prefetchIndices(i); });
    }
    void prefetchVertices(NodeRef ref) const {
        forLanes(ref, [](const TriangleReader& r, uint32_t i) { r.prefetchVertices(i); });
    }

private:
    // Four triangles, one in each lane.
    struct Lanes {
        __m128 v[3][3]; // [vertex][axis]

        template <unsigned N>
        void store(TriangleLeaf<N>& leaf, uint32_t first) const {
            for (uint32_t i = 0; i < 9; ++i)
                _mm_store_ps(leaf.vertices + i * N + first, v[i / 3][i % 3]);
        }
        void keep(__m128 lanes) {
            const __m128 nan = _mm_set1_ps(std::numeric_limits<float>::quiet_NaN());
            for (auto& vertex : v)
                for (__m128& x : vertex)
                    x = choose(lanes, x, nan);
        }
    };

    static bool isWide(NodeRef ref) { return (ref & kNodeTagMask) == kWideLeaf; }
    static __m128 choose(__m128 mask, __m128 yes, __m128 no) {
        return _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no));
    }

    // Lanes whose vertices make an active triangle.
    static __m128 activeLanes(const Lanes& t) {
        const __m128 sign = _mm_set1_ps(-0.0f), most = _mm_set1_ps(kMaxCoordinate);
        __m128 good = _mm_cmpeq_ps(sign, sign);
        for (const auto& vertex : t.v)
            for (const __m128 x : vertex)
                good = _mm_and_ps(good, _mm_cmple_ps(_mm_andnot_ps(sign, x), most));
        const __m128d low = haveArea(t, [](__m128 x) { return _mm_cvtps_pd(x); });
        const __m128d high =
            haveArea(t, [](__m128 x) { return _mm_cvtps_pd(_mm_movehl_ps(x, x)); });
        return _mm_and_ps(good, _mm_shuffle_ps(_mm_castpd_ps(low), _mm_castpd_ps(high), 0x88));
    }

    // Uses double precision, in which differences and products of floats are exact or nearly exact.
    template <class Half>
    static __m128d haveArea(const Lanes& t, const Half& half) {
        __m128d e[2][3];
        for (int a = 0; a < 3; ++a) {
            const __m128d first = half(t.v[0][a]);
            e[0][a] = _mm_sub_pd(half(t.v[1][a]), first);
            e[1][a] = _mm_sub_pd(half(t.v[2][a]), first);
        }
        const auto differ = [&](int i, int j) {
            return _mm_cmpneq_pd(_mm_mul_pd(e[0][i], e[1][j]), _mm_mul_pd(e[0][j], e[1][i]));
        };
        return _mm_or_pd(differ(1, 2), _mm_or_pd(differ(2, 0), differ(0, 1)));
    }

    // Boxes of the lanes in `good`.
    static Extent measure(const Lanes& t, __m128 good) {
        const __m128 inf = _mm_set1_ps(std::numeric_limits<float>::infinity());
        const __m128 minusInf = _mm_set1_ps(-std::numeric_limits<float>::infinity());
        __m128 low[3], high[3], size = _mm_setzero_ps();
        for (int a = 0; a < 3; ++a) {
            low[a] = _mm_min_ps(_mm_min_ps(t.v[0][a], t.v[1][a]), t.v[2][a]);
            high[a] = _mm_max_ps(_mm_max_ps(t.v[0][a], t.v[1][a]), t.v[2][a]);
            size = _mm_max_ps(size, _mm_sub_ps(high[a], low[a]));
            low[a] = choose(good, low[a], inf);
            high[a] = choose(good, high[a], minusInf);
        }
        const __m128 padding = _mm_and_ps(good, _mm_mul_ps(size, _mm_set1_ps(boxPadding(1))));
        Extent e;
        e.exact = {leastOfLanes(low[0], low[1], low[2]), mostOfLanes(high[0], high[1], high[2])};
        for (int a = 0; a < 3; ++a) {
            low[a] = _mm_sub_ps(low[a], padding);
            high[a] = _mm_add_ps(high[a], padding);
        }
        e.padded = {leastOfLanes(low[0], low[1], low[2]), mostOfLanes(high[0], high[1], high[2])};
        e.active = uint32_t(std::popcount(unsigned(_mm_movemask_ps(good))));
        return e;
    }

    uint32_t inputOf(uint32_t sbtWord) const { return bvh::inputOf(header_, inputs_, sbtWord); }

    template <class Work>
    void forLanes(NodeRef ref, const Work& work) const {
        if (kindOf(header_.type) != BlockType::kTriangles)
            return;
        const uint8_t* leaf = block_ + offsetOf(ref);
        if (isWide(ref))
            forLanes(*reinterpret_cast<const TriangleLeaf<8>*>(leaf), work);
        else
            forLanes(*reinterpret_cast<const TriangleLeaf<4>*>(leaf), work);
    }
    template <unsigned N, class Work>
    void forLanes(const TriangleLeaf<N>& leaf, const Work& work) const {
        for (uint32_t lane = 0; lane < std::min(leaf.count, N); ++lane) {
            const uint32_t input = inputOf(leaf.sbt[lane]);
            work(sources_.triangles[input],
                 leaf.primitive[lane] - inputs_[input].primitiveIndexOffset);
        }
    }

    // Reads a triangle into three rows; NaN if there is none.
    void readRows(uint32_t input, uint32_t primitive, __m128 rows[3]) const {
        const TriangleReader& reader = sources_.triangles[input];
        const uint8_t* address[3];
        if (reader.locate(primitive, address)) {
            for (int i = 0; i < 3; ++i) {
                const auto* p = reinterpret_cast<const float*>(address[i]);
                rows[i] = _mm_castpd_ps(_mm_load_sd(reinterpret_cast<const double*>(p)));
                rows[i] = _mm_movelh_ps(rows[i], _mm_load_ss(p + 2));
            }
            return;
        }
        float v[9];
        if (!reader.readUnchecked(primitive, v))
            std::fill(v, v + 9, std::numeric_limits<float>::quiet_NaN());
        for (int i = 0; i < 3; ++i)
            rows[i] = _mm_setr_ps(v[3 * i], v[3 * i + 1], v[3 * i + 2], 0);
    }

    template <unsigned N>
    Extent refitTriangles(TriangleLeaf<N>& leaf) const {
        const uint32_t count = std::min(leaf.count, N);
        Extent all;
        for (uint32_t first = 0; first < count; first += 4) {
            const __m128 nan = _mm_set1_ps(std::numeric_limits<float>::quiet_NaN());
            __m128 rows[4][3] = {
                {nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}};
            const uint32_t used = std::min(count - first, 4u);
            for (uint32_t i = 0; i < used; ++i) {
                const uint32_t lane = first + i, input = inputOf(leaf.sbt[lane]);
                const uint32_t primitive =
                    leaf.primitive[lane] - inputs_[input].primitiveIndexOffset;
                if (sources_.sbt[input].varies())
                    leaf.sbt[lane] = sources_.sbt[input].sbtWord(primitive);
                readRows(input, primitive, rows[i]);
            }
            Lanes lanes;
            for (int i = 0; i < 3; ++i) {
                __m128 x = rows[0][i], y = rows[1][i], z = rows[2][i], w = rows[3][i];
                _MM_TRANSPOSE4_PS(x, y, z, w);
                lanes.v[i][0] = x, lanes.v[i][1] = y, lanes.v[i][2] = z;
            }
            const __m128 good = activeLanes(lanes);
            if (_mm_movemask_ps(good) != 15)
                lanes.keep(good);
            lanes.store(leaf, first);
            all.add(measure(lanes, good));
        }
        return all;
    }

    Extent refitCustom(CustomLeaf& leaf) const {
        Extent extent;
        const uint32_t input = inputOf(leaf.sbt);
        const uint32_t primitive = leaf.primitive - inputs_[input].primitiveIndexOffset;
        leaf.sbt = sources_.sbt[input].sbtWord(primitive);
        if (sources_.customs[input].read(primitive, leaf.lower, leaf.upper)) {
            extent.addPrimitive(leaf.lower, leaf.upper);
        } else {
            std::fill(leaf.lower, leaf.lower + 3, std::numeric_limits<float>::infinity());
            std::fill(leaf.upper, leaf.upper + 3, -std::numeric_limits<float>::infinity());
        }
        return extent;
    }

    Extent refitInstance(InstanceRecord& record) const {
        Extent extent;
        float lower[3], upper[3];
        const uint32_t index = record.index;
        if (describeInstance(instanceAt(*sources_.instances, index), index,
                             OpenLevels::of(header_.options), record, lower, upper))
            extent.addPrimitive(lower, upper);
        return extent;
    }

    uint8_t* block_;
    const BlockHeader& header_;
    const Sources& sources_;
    const InputRecord* inputs_;
};

} // namespace sunstone::bvh
