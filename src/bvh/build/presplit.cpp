// SPDX-License-Identifier: Apache-2.0
#include "bvh/build/presplit.h"

#include "bvh/build/split_measure.h"
#include "bvh/parallel.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sunstone::bvh {
namespace {

constexpr size_t kBlock = 1u << 13;

struct Piece {
    float lower[3], upper[3];

    int longestAxis() const {
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            if (upper[a] - lower[a] > upper[axis] - lower[axis])
                axis = a;
        return axis;
    }
    float length() const {
        const int axis = longestAxis();
        return upper[axis] - lower[axis];
    }
};

// Splits one triangle's box.
class Splitter {
public:
    // `pad`: the margin of a part's box: the padding of whole triangles' boxes plus the rounding
    // here.
    Splitter(const float vertices[9], float pad) : v_(vertices), pad_(pad) {}

    // Writes `splits` + 1 pieces.
    void split(const Piece& piece, uint32_t splits, Piece*& out) const {
        if (splits == 0) {
            *out++ = piece;
            return;
        }
        const int axis = piece.longestAxis();
        const double plane = 0.5 * (double(piece.lower[axis]) + piece.upper[axis]);
        const Piece left = side(piece, axis, plane, true), right = side(piece, axis, plane, false);
        const float a = left.length(), b = right.length();
        const float share = a + b > 0 ? a / (a + b) : 0.5f;
        const uint32_t rest = splits - 1;
        const uint32_t first = std::min(rest, uint32_t(share * float(rest) + 0.5f));
        split(left, first, out);
        split(right, rest - first, out);
    }

private:
    // Box of the triangle's part on one side of the plane, inside `piece`.
    Piece side(const Piece& piece, int axis, double plane, bool low) const {
        double lower[3] = {1e300, 1e300, 1e300}, upper[3] = {-1e300, -1e300, -1e300};
        const auto add = [&](const double p[3]) {
            for (int a = 0; a < 3; ++a) {
                lower[a] = std::min(lower[a], p[a]);
                upper[a] = std::max(upper[a], p[a]);
            }
        };
        for (int i = 0; i < 3; ++i) {
            const float *p = v_ + 3 * i, *q = v_ + 3 * ((i + 1) % 3);
            const double from[3] = {p[0], p[1], p[2]};
            if (low ? p[axis] <= plane : p[axis] >= plane)
                add(from);
            if ((p[axis] < plane) == (q[axis] < plane))
                continue;
            const double t = (plane - p[axis]) / (double(q[axis]) - p[axis]);
            double at[3];
            for (int a = 0; a < 3; ++a)
                at[a] = from[a] + t * (q[a] - from[a]);
            at[axis] = plane;
            add(at);
        }
        Piece result = piece;
        (low ? result.upper : result.lower)[axis] = float(plane) + (low ? pad_ : -pad_);
        for (int a = 0; a < 3; ++a) {
            const float l = std::max(result.lower[a], float(lower[a]) - pad_);
            const float u = std::min(result.upper[a], float(upper[a]) + pad_);
            if (l <= u) { // else no part of the triangle is here; any box will do
                result.lower[a] = l;
                result.upper[a] = u;
            }
        }
        return result;
    }

    const float* v_;
    float pad_;
};

struct Shape {
    float vertices[9];
    float size;      // longest edge of the box
    double priority; // 0: not worth splitting
    uint32_t limit;
};

Shape shapeOf(const PrimitiveRef& ref, const Sources& sources) {
    Shape s{};
    if (!sources.triangles[ref.input].read(ref.primitive, s.vertices) ||
        (sources.sbt[ref.input].sbtWord(ref.primitive) >> kGeometryFlagShift &
         kGeometryRequireSingleAnyHit))
        return s;
    for (int a = 0; a < 3; ++a) {
        const float* v = s.vertices + a;
        s.size = std::max(s.size, std::max({v[0], v[3], v[6]}) - std::min({v[0], v[3], v[6]}));
    }
    const SplitMeasure measure = splitMeasure(s.vertices);
    if (!isWorthSplitting(measure))
        return s;
    s.priority = std::cbrt(measure.box - measure.need);
    s.limit = splitLimit(measure);
    return s;
}

uint32_t splitsOf(float priority, double factor, uint32_t limit) {
    return uint32_t(std::min(double(priority) * factor, double(limit)));
}

} // namespace

uint32_t splitLongTriangles(PrimitiveRef* references, uint32_t count, const Sources& sources,
                            float* spare) {
    const uint64_t budget = maxSplits(count);
    const size_t blocks = (count + kBlock - 1) / kBlock;
    std::vector<float> most(blocks);
    auto measure = [&](size_t begin, size_t end, size_t block) {
        for (size_t i = begin; i < end; ++i) {
            spare[i] = float(shapeOf(references[i], sources).priority);
            most[block] = std::max(most[block], spare[i]);
        }
    };
    parallelBlocks(count, kBlock, measure);
    const float largest = blocks ? *std::max_element(most.begin(), most.end()) : 0;
    if (!(largest > 0) || !std::isfinite(largest))
        return count;
    // The largest factor that keeps the sum of splits within the budget. Limits of single triangles
    // are ignored: they only reduce the number.
    std::vector<uint64_t> sums(blocks);
    const auto total = [&](double factor) {
        auto body = [&](size_t begin, size_t end, size_t block) {
            uint64_t sum = 0;
            for (size_t i = begin; i < end; ++i)
                sum += splitsOf(spare[i], factor, kMostSplits);
            sums[block] = sum;
        };
        parallelBlocks(count, kBlock, body);
        uint64_t sum = 0;
        for (uint64_t s : sums)
            sum += s;
        return sum;
    };
    double low = 0, high = double(kMostSplits) / largest;
    while (total(high) <= budget && high < 1e30 / largest)
        low = high, high *= 4;
    for (int i = 0; i < 12; ++i) {
        const double middle = 0.5 * (low + high);
        (total(middle) <= budget ? low : high) = middle;
    }
    total(low);
    uint64_t at = count;
    std::vector<uint64_t> starts(blocks);
    for (size_t b = 0; b < blocks; ++b) {
        starts[b] = at;
        at += sums[b];
    }
    std::vector<uint32_t> added(blocks);
    auto divide = [&](size_t begin, size_t end, size_t block) {
        PrimitiveRef* to = references + starts[block];
        for (size_t i = begin; i < end; ++i) {
            if (splitsOf(spare[i], low, kMostSplits) == 0)
                continue;
            PrimitiveRef& ref = references[i];
            const Shape shape = shapeOf(ref, sources);
            const uint32_t splits = splitsOf(spare[i], low, shape.limit);
            Piece whole, pieces[kMostSplits + 1], *out = pieces;
            for (int a = 0; a < 3; ++a) {
                whole.lower[a] = ref.lower[a];
                whole.upper[a] = -ref.negUpper[a];
            }
            Splitter(shape.vertices, 2 * boxPadding(shape.size)).split(whole, splits, out);
            for (uint32_t k = 0; k <= splits; ++k) {
                PrimitiveRef& part = k == 0 ? ref : *to++;
                part.primitive = ref.primitive;
                part.input = k == 0 ? ref.input : ref.input | kDuplicate;
                for (int a = 0; a < 3; ++a) {
                    part.lower[a] = pieces[k].lower[a];
                    part.negUpper[a] = -pieces[k].upper[a];
                }
            }
        }
        added[block] = uint32_t(to - (references + starts[block]));
    };
    parallelBlocks(count, kBlock, divide);
    uint64_t end = count;
    for (size_t b = 0; b < blocks; ++b) {
        std::copy(references + starts[b], references + starts[b] + added[b], references + end);
        end += added[b];
    }
    return uint32_t(end);
}

} // namespace sunstone::bvh
