// SPDX-License-Identifier: Apache-2.0
// Round curves: the kernels of all instruction sets against the reference of testing/curves.h, with
// random, bent and degenerate segments and rays from all directions.
#include "bvh/layout.h"
#include "bvh/shapes/shape_geometry.h"
#include "bvh/testing/curves.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace sunstone::bvh {
namespace {

using namespace testing;

constexpr CurveBasis kBases[] = {CurveBasis::kLinear, CurveBasis::kQuadraticBSpline,
                                 CurveBasis::kCubicBSpline, CurveBasis::kCatmullRom};

// Segments that share no vertices.
struct Segments {
    CurveBasis basis;
    std::vector<float> vertices, radii;
    std::vector<uint32_t> indices;
    std::vector<Segment> segments;
    bool caps = false;
    uint32_t flags = 0;

    void add(Segment s) {
        s.basis = basis;
        s.capBegin = s.capEnd = caps;
        indices.push_back(uint32_t(radii.size()));
        for (uint32_t i = 0; i <= degreeOf(basis); ++i) {
            const auto& p = s.points[i];
            vertices.insert(vertices.end(), {p[0], p[1], p[2]});
            radii.push_back(p[3]);
        }
        // A gap, so that each segment is a separate strand.
        vertices.insert(vertices.end(), {0, 0, 0});
        radii.push_back(0);
        segments.push_back(s);
    }
    CurveInput input() const {
        CurveInput in;
        in.basis = uint32_t(basis);
        in.vertices = vertices.data();
        in.radii = radii.data();
        in.numVertices = uint32_t(radii.size());
        in.indices = indices.data();
        in.numSegments = uint32_t(indices.size());
        in.caps = caps;
        in.sbt.flags = &flags;
        return in;
    }
};

struct BuiltBlock {
    explicit BuiltBlock(const BuildInputs& inputs, const BuildOptions& options = {}) {
        const MemoryUsage usage = computeMemoryUsage(inputs, options);
        memory = alignedBuffer(usage.output);
        size = usage.output;
        const auto temp = alignedBuffer(usage.temp);
        build(inputs, options, temp.get(), usage.temp, memory.get(), usage.output);
    }
    decltype(alignedBuffer(1)) memory;
    size_t size;
    const void* block() const { return memory.get(); }
};

BuildInputs inputsOf(const CurveInput& input) {
    BuildInputs inputs;
    inputs.curves = {&input, 1};
    return inputs;
}

std::vector<Isa> allSets() {
    std::vector<Isa> sets;
    for (Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512})
        if (isaSupported(isa))
            sets.push_back(isa);
    return sets;
}

// Rays from around and within, towards points near the segment.
ShapeRay randomRay(Random& random, const Segment& s, double spread) {
    const CurvePoint target = evaluate(s, random(0, 1));
    const Vec3 aim = random.point(float(spread));
    const Vec3 from = random.point(random.below(4) == 0 ? 0.3f : 4.0f);
    const float length = random(0.3f, 3);
    Vec3 d = {float(target.position.x) + aim.x - from.x, float(target.position.y) + aim.y - from.y,
              float(target.position.z) + aim.z - from.z};
    d = d * (length / math::length(d));
    return {{from.x, from.y, from.z}, 0, {d.x, d.y, d.z}, 1e30f, 0};
}

struct Tally {
    int rays = 0, clear = 0, hits = 0, wrong = 0;
};

// Counts the rays for which the judge gives one result with both tolerances, and those for which
// the kernel disagrees.
void compare(const Segment& s, const CurveJudge& judge, const void* block, Isa isa,
             const ShapeRay& ray, double tolerance, Tally& tally) {
    ++tally.rays;
    const double thick = 2e-3;
    std::optional<JudgedHit> judged[3];
    const Lean leans[3] = {{1 - thick, 1e-3}, {1, 0}, {1 + thick, -1e-3}};
    for (int i = 0; i < 3; ++i)
        judged[i] = judge.nearest(ray, leans[i]);
    double scale = 0;
    for (int a = 0; a < 3; ++a)
        scale += ray.direction[a] * ray.direction[a];
    scale = std::sqrt(scale);
    for (int i = 0; i < 3; i += 2) {
        if (judged[i].has_value() != judged[1].has_value())
            return;
        if (judged[1] && std::fabs(judged[i]->t - judged[1]->t) * scale > tolerance)
            return;
    }
    ++tally.clear;
    tally.hits += judged[1].has_value();
    ShapeHit hit{};
    const bool found = shapeKernels(isa).closest(block, ray, hit);
    ShapeHit other{};
    const bool any = shapeKernels(isa).any(block, ray, other);
    bool good = found == judged[1].has_value() && any == found;
    if (good && found)
        good = std::fabs(hit.t - judged[1]->t) * scale <= tolerance && hit.u >= 0 && hit.u <= 1;
    // The parameter belongs to the point, except on the spheres of linear segments.
    if (good && found && !(s.basis == CurveBasis::kLinear && (hit.u == 0 || hit.u == 1)))
        good = length(evaluate(s, hit.u).position - evaluate(s, judged[1]->u).position) <=
               6 * tolerance;
    tally.wrong += !good;
    if (!good && tally.wrong <= 3 && std::getenv("SUNSTONE_TEST_VERBOSE")) {
        printf("basis %x judged %d t %.6f u %.6f, kernel %d t %.6f u %.6f\n", unsigned(s.basis),
               judged[1].has_value(), judged[1] ? judged[1]->t : 0, judged[1] ? judged[1]->u : 0,
               found, hit.t, hit.u);
        for (const auto& p : s.points)
            printf("  %.9g %.9g %.9g  %.9g\n", p[0], p[1], p[2], p[3]);
        printf("  ray %.9g %.9g %.9g  %.9g %.9g %.9g\n", ray.origin[0], ray.origin[1],
               ray.origin[2], ray.direction[0], ray.direction[1], ray.direction[2]);
    }
}

// A segment whose control points are a random walk with steps of about `step`, with random widths.
Segment wandering(Random& random, float step, float thin, float thick) {
    Segment s{};
    Vec3 p = random.point(0.5f), d = random.unit() * step;
    for (auto& c : s.points) {
        c = {p.x, p.y, p.z, random(thin, thick)};
        p = p + d + random.point(0.25f * step);
    }
    return s;
}

TEST(Curves, AgreeWithTheJudge) {
    const uint32_t seed = 71;
    for (Isa isa : allSets())
        for (CurveBasis basis : kBases)
            for (bool caps : {false, true}) {
                if (caps && basis == CurveBasis::kLinear)
                    continue;
                Random random(seed);
                Tally tally;
                for (int i = 0; i < 15; ++i) {
                    Segments one{basis};
                    one.caps = caps;
                    one.add(wandering(random, 0.5f, 0.02f, 0.08f));
                    const CurveInput in = one.input();
                    const BuiltBlock b(inputsOf(in));
                    const CurveJudge judge(one.segments[0]);
                    for (int k = 0; k < 30; ++k)
                        compare(one.segments[0], judge, b.block(), isa,
                                randomRay(random, one.segments[0], 0.1), 1e-3, tally);
                }
                EXPECT_GT(tally.clear, tally.rays * 8 / 10);
                EXPECT_GT(tally.hits, tally.rays / 5);
                EXPECT_EQ(tally.wrong, 0)
                    << isaName(isa) << " basis " << unsigned(basis) << " caps " << caps << " of "
                    << tally.clear << ", seed " << seed;
            }
}

// Two legs of length 0.5 at a distance of `gap`, about 0.04 thick, joined by a turn with a radius
// of about twice the square of the gap.
Segment hairpin(Random& random, CurveBasis basis, float gap) {
    const Vec3 base = random.point(0.5f), leg = random.unit() * 0.5f;
    Vec3 side = math::cross(leg, random.unit());
    side = side * (gap / math::length(side));
    Vec3 points[4] = {base, base + leg, base + leg + side, base + side};
    if (basis == CurveBasis::kQuadraticBSpline) {
        points[1] = base + leg + side * 0.5f;
        points[2] = base + side;
    } else if (basis == CurveBasis::kCatmullRom) {
        points[0] = base - leg;
        points[1] = base;
        points[2] = base + side;
        points[3] = base - leg + side;
    }
    Segment s{};
    for (size_t i = 0; i < 4; ++i) {
        const Vec3 p = points[i] + random.point(0.1f * gap);
        s.points[i] = {p.x, p.y, p.z, random(0.032f, 0.048f)};
    }
    return s;
}

// Turns with radii of curvature from half of the curve's radius to a thousandth of it and less.
TEST(Curves, Hairpins) {
    const uint32_t seed = 73;
    const std::vector<Isa> sets = allSets();
    const struct {
        float gap;
        int oneWrongOf;
    } kinds[] = {{0.1f, 800}, {0.05f, 800}, {0.02f, 800}, {0.003f, 150}};
    for (CurveBasis basis :
         {CurveBasis::kQuadraticBSpline, CurveBasis::kCubicBSpline, CurveBasis::kCatmullRom})
        for (const auto& kind : kinds) {
            Random random(seed);
            Tally tally;
            for (size_t i = 0; i < 40; ++i) {
                Segments one{basis};
                one.caps = i & 1;
                one.add(hairpin(random, basis, kind.gap));
                const CurveInput in = one.input();
                const BuiltBlock b(inputsOf(in));
                const CurveJudge judge(one.segments[0]);
                for (int k = 0; k < 40; ++k)
                    compare(one.segments[0], judge, b.block(), sets[i % sets.size()],
                            randomRay(random, one.segments[0], 0.05), 1e-3, tally);
            }
            if (std::getenv("SUNSTONE_TEST_VERBOSE"))
                printf("basis %x gap %g: %d rays, %d clear, %d hits, %d wrong\n", unsigned(basis),
                       double(kind.gap), tally.rays, tally.clear, tally.hits, tally.wrong);
            EXPECT_GT(tally.clear, tally.rays * 95 / 100);
            EXPECT_GT(tally.hits, tally.rays / 2);
            EXPECT_LE(tally.wrong * kind.oneWrongOf, tally.clear)
                << "basis " << unsigned(basis) << " gap " << kind.gap << ", seed " << seed;
        }
}

// Sharp turns, cusps, coincident control points, thick curves, tips of no width. Where the surface
// folds into itself the judge and the kernel may differ about a few rays.
Segment awkward(Random& random, int kind) {
    Segment s = wandering(random, 0.4f, 0.01f, 0.05f);
    auto& p = s.points;
    switch (kind) {
    case 0: // a hairpin
        p[2] = {p[0][0] + 0.03f, p[0][1], p[0][2] + 0.02f, p[2][3]};
        p[3] = {p[1][0] - 0.05f, p[1][1], p[1][2], p[3][3]};
        break;
    case 1: // coincident at the begin, as clamped strands have it
        p[1] = p[0];
        break;
    case 2:
        p[2] = p[1] = p[0];
        break;
    case 3:
        p[3] = p[2] = p[1];
        break;
    case 4: // thicker than long
        for (auto& c : p)
            c[3] *= 6;
        break;
    case 5: // a tip
        p[2][3] = p[3][3] = 0;
        p[1][3] = 0.01f;
        break;
    case 6: // straight
        for (size_t i = 1; i < 4; ++i)
            for (size_t a = 0; a < 3; ++a)
                p[i][a] = p[0][a] + float(i) * (a == 0 ? 0.4f : 0.1f);
        break;
    default: // straight and uneven
        for (size_t i = 1; i < 4; ++i)
            for (size_t a = 0; a < 3; ++a)
                p[i][a] = p[0][a] + (i < 3 ? 0.01f * float(i) : 0.6f) * (a == 1 ? 1.0f : 0.3f);
        break;
    }
    return s;
}

TEST(Curves, AwkwardSegments) {
    const uint32_t seed = 72;
    const Isa isa = chosenIsa();
    for (CurveBasis basis : kBases)
        for (int kind = 0; kind < 8; ++kind) {
            if (basis == CurveBasis::kQuadraticBSpline && kind == 2)
                continue; // no length at all
            Random random(seed);
            Tally tally;
            for (int i = 0; i < 20; ++i) {
                Segments one{basis};
                one.caps = basis != CurveBasis::kLinear && (i & 1);
                one.add(awkward(random, kind));
                const CurveInput in = one.input();
                const BuiltBlock b(inputsOf(in));
                const CurveJudge judge(one.segments[0]);
                for (int k = 0; k < 20; ++k)
                    compare(one.segments[0], judge, b.block(), isa,
                            randomRay(random, one.segments[0], 0.05), 1e-3, tally);
            }
            if (std::getenv("SUNSTONE_TEST_VERBOSE"))
                printf("basis %x kind %d: %d rays, %d clear, %d hits, %d wrong\n", unsigned(basis),
                       kind, tally.rays, tally.clear, tally.hits, tally.wrong);
            EXPECT_LE(tally.wrong * 300, tally.clear)
                << "basis " << unsigned(basis) << " kind " << kind << ", seed " << seed;
        }
}

// At all sizes, bounds of the derivatives may decide only if turnsMuch() is false.
TEST(Curves, SurelyStraightPiecesTurnLittle) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1, 1);
    uint32_t numStraight = 0, numTurning = 0;
    for (uint32_t i = 0; i < 200000; ++i) {
        const float size = std::exp2(90 * unit(random)), waves = std::exp2(6 * unit(random) - 4);
        float points[16];
        for (int k = 0; k < 4; ++k) {
            points[4 * k] = size * (float(k) + waves * unit(random));
            for (int a = 1; a < 3; ++a)
                points[4 * k + a] = size * waves * unit(random);
            points[4 * k + 3] = size * waves * unit(random);
        }
        for (const CurveBasis basis : kBases) {
            const ShapePoints shape(uint32_t(basis), points);
            const shape_math::Cubic piece = shape.piece(pieceWord(0, 1 + i % 7));
            const bool isStraight = isSurelyStraight(piece), turns = turnsMuch(piece);
            EXPECT_FALSE(isStraight && turns) << i;
            numStraight += isStraight;
            numTurning += turns;
        }
    }
    EXPECT_LT(100000u, numStraight);
    EXPECT_LT(100000u, numTurning);
    EXPECT_LT(700000u, numStraight + numTurning) << "the bounds decide most pieces";
}

} // namespace
} // namespace sunstone::bvh
