// SPDX-License-Identifier: Apache-2.0
// Opacity micromaps: the numbering against subdivision in double precision, arrays, and the
// micromap that each triangle gets.
#include "bvh/micromap/micromap.h"

#include "base/error.h"
#include "bvh/micromap/micromap_array.h"
#include "bvh/micromap/micromap_binding.h"
#include "bvh/testing/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

namespace sunstone::bvh {
namespace {

using testing::alignedBuffer;
using testing::makeStructure;
using testing::Mesh;
using testing::Random;
using testing::Structure;

struct Point {
    double a, b, c; // barycentrics
};
Point middle(Point p, Point q) {
    return {(p.a + q.a) / 2, (p.b + q.b) / 2, (p.c + q.c) / 2};
}

// Visits the micro-triangles in the order of the curve: visit(A, B, C).
void subdivide(Point a, Point b, Point c, unsigned level,
               const std::function<void(Point, Point, Point)>& visit) {
    if (level == 0)
        return visit(a, b, c);
    const Point ab = middle(a, b), bc = middle(b, c), ac = middle(a, c);
    subdivide(a, ab, ac, level - 1, visit);
    subdivide(ac, bc, ab, level - 1, visit);
    subdivide(ab, b, bc, level - 1, visit);
    subdivide(bc, ac, c, level - 1, visit);
}

void forEachMicroTriangle(unsigned level, const std::function<void(Point, Point, Point)>& visit) {
    subdivide({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, level, visit);
}

TEST(MicroTriangles, AreNumberedAlongTheCurve) {
    for (unsigned level = 0; level <= 8; ++level) {
        Random random(1 + level);
        uint32_t expected = 0;
        forEachMicroTriangle(level, [&](Point a, Point b, Point c) {
            for (int k = 0; k < 4; ++k) {
                float x = 1 / 3.0f, y = 1 / 3.0f;
                if (k) {
                    x = random(0.05f, 0.6f);
                    y = random(0.05f, 0.35f);
                }
                const double z = 1 - x - y;
                const float u = float(a.b * z + b.b * x + c.b * y);
                const float v = float(a.c * z + b.c * x + c.c * y);
                ASSERT_EQ(microTriangleAt(u, v, level), expected)
                    << "level " << level << ", u " << u << ", v " << v;
            }
            ++expected;
        });
        EXPECT_EQ(expected, microTriangleCount(level));
    }
}

// At level 12 a micro-triangle is some thousand floats wide; the test descends to one
// micro-triangle in place of visiting all.
TEST(MicroTriangles, AreNumberedAlongTheCurveAtTheFinestLevel) {
    Random random(7);
    for (int i = 0; i < 20000; ++i) {
        Point a{1, 0, 0}, b{0, 1, 0}, c{0, 0, 1};
        uint32_t expected = 0;
        for (unsigned level = 0; level < kMaxMicromapLevel; ++level) {
            const Point ab = middle(a, b), bc = middle(b, c), ac = middle(a, c);
            const uint32_t child = random.below(4);
            const Point corners[4][3] = {{a, ab, ac}, {ac, bc, ab}, {ab, b, bc}, {bc, ac, c}};
            a = corners[child][0], b = corners[child][1], c = corners[child][2];
            expected = 4 * expected + child;
        }
        const float u = float((a.b + b.b + c.b) / 3), v = float((a.c + b.c + c.c) / 3);
        ASSERT_EQ(microTriangleAt(u, v, kMaxMicromapLevel), expected);
    }
}

// Corners, edges and points outside of the triangle.
TEST(MicroTriangles, StayInRange) {
    const float nan = std::nanf(""), inf = INFINITY;
    const float values[] = {0,     -0.0f,           0x1p-149f, 0x1p-24f, 0.25f,
                            0.5f,  0.5f + 0x1p-24f, 1.0f,      2.0f,     1 - 0x1p-24f,
                            -1.0f, 0x1p+100f,       nan,       inf,      -inf};
    for (unsigned level = 0; level <= kMaxMicromapLevel; ++level) {
        for (float u : values)
            for (float v : values)
                EXPECT_LT(microTriangleAt(u, v, level), microTriangleCount(level));
        EXPECT_EQ(microTriangleAt(0, 0, level), 0u);
        EXPECT_EQ(microTriangleAt(0, 1, level), microTriangleCount(level) - 1);
        const uint32_t atB = microTriangleAt(1, 0, level);
        EXPECT_EQ(atB, 2 * (microTriangleCount(level) - 1) / 3); // child 2 at each level
        // Points on the long edge, where u + v rounds to more than 1 or less.
        Random random(3);
        for (int i = 0; i < 1000; ++i) {
            const float u = random(0, 1);
            EXPECT_LT(microTriangleAt(u, 1 - u, level), microTriangleCount(level));
            EXPECT_LT(microTriangleAt(u, std::nextafter(1 - u, 2.0f), level),
                      microTriangleCount(level));
        }
    }
}

// ---- arrays ----

// The input of an array under construction.
struct Maps {
    std::vector<uint8_t> states;
    std::vector<MicromapDesc> descriptions;
    std::vector<MicromapHistogramEntry> histogram;

    // `at(i)` gives the state of micro-triangle i.
    void add(unsigned level, MicromapFormat format, const std::function<uint32_t(uint64_t)>& at) {
        descriptions.push_back({uint32_t(states.size()), uint16_t(level), uint16_t(format)});
        histogram.push_back({1, level, format});
        states.resize(states.size() + micromapBytes(level, format));
        uint8_t* const to = states.data() + descriptions.back().byteOffset;
        const unsigned bits = format == MicromapFormat::kTwoState ? 1 : 2;
        for (uint64_t i = 0; i < microTriangleCount(level); ++i)
            to[i * bits / 8] |= uint8_t(at(i) << (i * bits % 8));
    }
    MicromapArrayInput input() const { return {histogram, states.data(), descriptions.data(), 0}; }
};

struct Array {
    std::shared_ptr<void> memory;
    size_t size = 0;

    const void* get() const { return memory.get(); }
    const MicromapRef* refs() const {
        return reinterpret_cast<const MicromapRef*>(
            static_cast<const uint8_t*>(get()) +
            static_cast<const MicromapArrayHeader*>(get())->refsOffset);
    }
    uint32_t stateAt(uint32_t map, float u, float v) const {
        return micromapStateAt(static_cast<const uint8_t*>(get()), refs()[map], u, v);
    }
};

Array makeArray(const Maps& maps) {
    Array array;
    array.size = micromapArraySizes(maps.histogram).output;
    array.memory = alignedBuffer(array.size);
    std::memset(array.memory.get(), 0xCD, array.size);
    buildMicromapArray(maps.input(), array.memory.get(), array.size);
    return array;
}

TEST(MicromapArray, HoldsTheStatesOfAllFormatsAndLevels) {
    Maps maps;
    Random random(5);
    std::vector<std::vector<uint8_t>> expected;
    for (unsigned level = 0; level <= 6; ++level)
        for (MicromapFormat format : {MicromapFormat::kTwoState, MicromapFormat::kFourState}) {
            auto& states = expected.emplace_back();
            for (uint64_t i = 0; i < microTriangleCount(level); ++i)
                states.push_back(
                    uint8_t(random.below(format == MicromapFormat::kTwoState ? 2 : 4)));
            maps.add(level, format, [&](uint64_t i) { return states[i]; });
        }
    const Array array = makeArray(maps);
    ASSERT_TRUE(isMicromapArray(array.get()));
    for (unsigned map = 0; map < expected.size(); ++map) {
        uint32_t i = 0;
        forEachMicroTriangle(map / 2, [&](Point a, Point b, Point c) {
            ASSERT_EQ(
                array.stateAt(map, float((a.b + b.b + c.b) / 3), float((a.c + b.c + c.c) / 3)),
                expected[map][i])
                << "micromap " << map << ", micro-triangle " << i;
            ++i;
        });
    }
}

TEST(MicromapArray, KnowsWhereAllStatesAreTheSame) {
    Maps maps;
    for (uint32_t state = 0; state < 4; ++state)
        for (unsigned level : {0u, 1u, 2u, 5u})
            maps.add(level, MicromapFormat::kFourState, [=](uint64_t) { return state; });
    for (uint32_t state = 0; state < 2; ++state)
        for (unsigned level : {0u, 1u, 2u, 5u})
            maps.add(level, MicromapFormat::kTwoState, [=](uint64_t) { return state; });
    maps.states[maps.descriptions[0].byteOffset] |= 0xF0; // bits after the last state
    maps.add(2, MicromapFormat::kFourState, [](uint64_t i) { return i == 15 ? 1u : 0u; });
    const Array array = makeArray(maps);
    for (uint32_t map = 0; map < 24; ++map)
        EXPECT_EQ(array.refs()[map],
                  makeUniformRef(MicromapState(map < 16 ? map / 4 : map / 4 - 4)))
            << map;
    EXPECT_EQ(array.refs()[24] & 3, uint32_t(kRefFourState));
    EXPECT_EQ(array.stateAt(24, 0, 1), 1u);
    EXPECT_EQ(array.stateAt(24, 0, 0), 0u);
}

TEST(MicromapArray, TakesStridesSharedStatesAndAnyOrder) {
    Maps maps;
    maps.add(3, MicromapFormat::kTwoState, [](uint64_t i) { return uint32_t(i & 1); });
    struct Wide {
        MicromapDesc desc;
        uint32_t other[3];
    };
    std::vector<Wide> wide(5, Wide{maps.descriptions[0], {1, 2, 3}});
    wide[2].desc = {0, 1, 2};
    const MicromapHistogramEntry histogram[] = {{2, 3, MicromapFormat::kTwoState},
                                                {1, 1, MicromapFormat::kFourState},
                                                {0, 12, MicromapFormat::kTwoState},
                                                {2, 3, MicromapFormat::kTwoState}};
    const MicromapArrayInput input{histogram, maps.states.data(), wide.data(), sizeof(Wide)};
    EXPECT_EQ(checkMicromaps(input), 8u);
    Array array;
    array.size = micromapArraySizes(histogram).output;
    array.memory = alignedBuffer(array.size);
    buildMicromapArray(input, array.memory.get(), array.size);
    for (uint32_t map : {0u, 1u, 3u, 4u}) {
        EXPECT_EQ(array.stateAt(map, 0, 0), 0u);
        EXPECT_EQ(array.stateAt(map, 0, 1), 1u);
    }
}

void expectInvalid(const std::function<void()>& call, const char* part) {
    try {
        call();
        ADD_FAILURE() << "no error about: " << part;
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), Code::kInvalidValue);
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(MicromapArray, RefusesWhatItCannotBuild) {
    const auto sizes = [](MicromapHistogramEntry entry) {
        return [=] { micromapArraySizes({&entry, 1}); };
    };
    expectInvalid(sizes({1, 13, MicromapFormat::kTwoState}), "level 13");
    expectInvalid(sizes({1, 0, MicromapFormat(0)}), "format 0");
    expectInvalid(sizes({1, 0, MicromapFormat(3)}), "format 3");
    expectInvalid(sizes({~0u, 0, MicromapFormat::kTwoState}), "limits");
    expectInvalid(sizes({1u << 30, 12, MicromapFormat::kFourState}), "limits");
    const std::vector<MicromapHistogramEntry> many(9, {~0u, 12, MicromapFormat::kFourState});
    expectInvalid([&] { micromapArraySizes(many); }, "limits");

    Maps maps;
    maps.add(2, MicromapFormat::kTwoState, [](uint64_t) { return 1; });
    const Array array = makeArray(maps);
    const auto build = [&](const MicromapArrayInput& input, size_t size) {
        std::memset(array.memory.get(), 0, array.size);
        buildMicromapArray(input, array.memory.get(), size);
    };
    expectInvalid([&] { build(maps.input(), array.size - 1); }, "output buffer has");
    expectInvalid([&] { buildMicromapArray(maps.input(), nullptr, 1 << 20); }, "multiple of 128");
    for (MicromapDesc wrong : {MicromapDesc{0, 3, 1}, MicromapDesc{0, 2, 2}, MicromapDesc{0, 2, 0},
                               MicromapDesc{0, 65535, 65535}}) {
        MicromapArrayInput input = maps.input();
        input.descriptions = &wrong;
        expectInvalid([&] { checkMicromaps(input); }, "histogram");
        expectInvalid([&] { build(input, array.size); }, "histogram");
        EXPECT_FALSE(isMicromapArray(array.get())) << "an array after a failed build";
    }
    MicromapArrayInput input = maps.input();
    input.descriptions = nullptr;
    expectInvalid([&] { build(input, array.size); }, "without descriptions");
    // Any offset is allowed; the caller must check its range.
    MicromapDesc far{0xFFFFFFFF, 2, 1};
    input = maps.input();
    input.descriptions = &far;
    EXPECT_EQ(checkMicromaps(input), 0xFFFFFFFFull + 2);
}

TEST(MicromapArray, OfNothingIsAnArray) {
    const Array array = makeArray({});
    EXPECT_TRUE(isMicromapArray(array.get()));
    EXPECT_EQ(array.size, 128u);
}

TEST(MicromapArray, CopiesAreRecognised) {
    Maps maps;
    maps.add(4, MicromapFormat::kFourState, [](uint64_t i) { return uint32_t(i & 3); });
    const Array array = makeArray(maps);
    const RelocationInfo info = micromapRelocationInfo(array.get());
    EXPECT_TRUE(isRelocatable(info));
    EXPECT_TRUE(holdsMicromaps(info));
    EXPECT_EQ(relocatedSize(info), array.size);
    const auto copy = alignedBuffer(array.size);
    std::memcpy(copy.get(), array.get(), array.size);
    relocateMicromapArray(info, copy.get());
    std::memset(copy.get(), 0, 128);
    expectInvalid([&] { relocateMicromapArray(info, copy.get()); }, "no opacity micromap array");
    maps.add(1, MicromapFormat::kFourState, [](uint64_t i) { return uint32_t(i & 3); });
    expectInvalid([&] { relocateMicromapArray(info, makeArray(maps).memory.get()); }, "no copy");
    RelocationInfo broken = info;
    broken.words[2] += 128;
    EXPECT_FALSE(isRelocatable(broken));
    expectInvalid([&] { relocateMicromapArray(broken, copy.get()); }, "relocation info");
    const Structure structure = makeStructure(testing::cube().input());
    expectInvalid([&] { relocateMicromapArray(relocationInfo(structure.block()), copy.get()); },
                  "not that of an opacity micromap array");
    expectInvalid([&] { relocate(info, structure.memory.get(), nullptr, 0); },
                  "not that of an acceleration structure");
}

// ---- triangles and their micromaps ----

std::vector<MicromapRef> refsOf(const void* block, uint32_t input, uint32_t count) {
    const MicromapRecord& record = micromapRecords(block)[input];
    const auto* refs = reinterpret_cast<const MicromapRef*>(static_cast<const uint8_t*>(block) +
                                                            record.refsOffset);
    return record.refsOffset ? std::vector<MicromapRef>(refs, refs + count)
                             : std::vector<MicromapRef>();
}

// An array of five micromaps with states that differ.
Array fiveMaps() {
    Maps maps;
    for (unsigned level = 1; level <= 5; ++level)
        maps.add(level, MicromapFormat::kTwoState, [](uint64_t i) { return uint32_t(i & 1); });
    return makeArray(maps);
}

TEST(MicromapBinding, ReadsIndicesOfAllKinds) {
    const Array array = fiveMaps();
    const Mesh mesh = testing::cube(); // 12 triangles
    TriangleInput in = mesh.input();
    in.micromaps.indexing = MicromapIndexing::kLinear;
    in.micromaps.array = array.get();
    const MicromapRef none = makeUniformRef(kNoMicromap);
    Structure s = makeStructure(in);
    const MicromapRef* const maps = array.refs();
    EXPECT_EQ(refsOf(s.block(), 0, 6),
              (std::vector<MicromapRef>{maps[0], maps[1], maps[2], maps[3], maps[4], none}));

    const MicromapRef expected[12] = {maps[3],
                                      maps[2],
                                      makeUniformRef(kTransparent),
                                      makeUniformRef(kOpaque),
                                      makeUniformRef(kUnknownTransparent),
                                      makeUniformRef(kUnknownOpaque),
                                      none,
                                      maps[4],
                                      maps[2],
                                      none,
                                      none,
                                      maps[2]};
    in.micromaps.indexing = MicromapIndexing::kIndexed;
    in.micromaps.indexOffset = 2;
    const int32_t wide[12] = {1, 0, -1, -2, -3, -4, 3, 2, 0, INT32_MIN, INT32_MAX, 0};
    in.micromaps.indices = wide;
    in.micromaps.indexSize = 4;
    s = makeStructure(in);
    EXPECT_EQ(refsOf(s.block(), 0, 12), std::vector<MicromapRef>(expected, expected + 12));

    struct Short {
        int16_t index, other;
    };
    const Short narrow[12] = {{1, 9}, {0, 9}, {-1, 9}, {-2, 9}, {-3, 9},        {-4, 9},
                              {3, 9}, {2, 9}, {0, 9},  {-5, 9}, {INT16_MAX, 9}, {0, 9}};
    in.micromaps.indices = narrow;
    in.micromaps.indexSize = 2;
    in.micromaps.indexStride = sizeof(Short);
    s = makeStructure(in);
    EXPECT_EQ(refsOf(s.block(), 0, 12), std::vector<MicromapRef>(expected, expected + 12));
    in.micromaps.indexOffset = ~0u; // with any index out of range, without wrapping around
    s = makeStructure(in);
    EXPECT_EQ(refsOf(s.block(), 0, 12)[0], none);
}

TEST(MicromapBinding, ArraysMustBeThere) {
    const Mesh mesh = testing::cube();
    TriangleInput in = mesh.input();
    in.micromaps.indexing = MicromapIndexing::kLinear;
    const auto zeros = alignedBuffer(4096);
    std::memset(zeros.get(), 0, 4096);
    for (const void* array :
         {static_cast<const void*>(nullptr), static_cast<const void*>(zeros.get()),
          reinterpret_cast<const void*>(0x7FFFFFFFFFFFFF80ull),
          reinterpret_cast<const void*>(0x4141414141414100ull)}) {
        in.micromaps.array = array;
        expectInvalid([&] { makeStructure(in); }, "no opacity micromap array");
    }
}

void surviveCompactionUpdateAndRelocation(uint32_t motionKeys) {
    const Array first = fiveMaps();
    const Array second = fiveMaps();
    const Mesh mesh = testing::cube();
    const void* const keys[2] = {mesh.vertices.data(), mesh.vertices.data()};
    TriangleInput inputs[2] = {mesh.input(), mesh.input()};
    if (motionKeys > 1)
        inputs[0].keyVertices = inputs[1].keyVertices = keys;
    const int32_t indices[12] = {0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1};
    int32_t others[12] = {4, 3, 2, 1, 0, 4, 3, 2, 1, 0, -1, -2};
    inputs[1].micromaps = {MicromapIndexing::kIndexed, first.get(), indices, 4, 0, 0};
    BuildInputs all;
    all.triangles = inputs;
    BuildOptions options;
    options.allowUpdate = options.allowCompaction = options.allowMicromapUpdate = true;
    options.motion = {motionKeys, 0, 0, 1};
    const Structure s = makeStructure(all, options); // compacted
    EXPECT_EQ(isMoving(headerOf(s.block())->type), motionKeys > 1);
    const auto before = refsOf(s.block(), 1, 12);
    EXPECT_EQ(before[4], first.refs()[4]);
    EXPECT_TRUE(refsOf(s.block(), 0, 12).empty());

    inputs[1].micromaps.array = second.get();
    inputs[1].micromaps.indices = others;
    const auto temp = alignedBuffer(128);
    update(all, options, temp.get(), 128, s.memory.get(), s.size);
    EXPECT_EQ(micromapRecords(s.block())[1].array, uint64_t(second.get()));
    const auto after = refsOf(s.block(), 1, 12);
    EXPECT_EQ(after[0], first.refs()[4]);
    EXPECT_EQ(after[10], makeUniformRef(kTransparent));

    const RelocationInfo info = relocationInfo(s.block());
    const Array third = fiveMaps();
    const auto copy = alignedBuffer(s.size);
    std::memcpy(copy.get(), s.block(), s.size);
    const void* arrays[2] = {nullptr, third.get()};
    relocateMicromaps(info, copy.get(), arrays, 2);
    EXPECT_EQ(micromapRecords(copy.get())[1].array, uint64_t(third.get()));
    arrays[1] = nullptr;
    relocateMicromaps(info, copy.get(), arrays, 2);
    EXPECT_EQ(micromapRecords(copy.get())[1].array, uint64_t(third.get()));
    expectInvalid([&] { relocateMicromaps(info, copy.get(), arrays, 1); }, "2 build inputs");
    arrays[0] = third.get();
    expectInvalid([&] { relocateMicromaps(info, copy.get(), arrays, 2); }, "no opacity micromaps");
    const Array small = makeArray({});
    arrays[0] = nullptr;
    arrays[1] = small.get();
    expectInvalid([&] { relocateMicromaps(info, copy.get(), arrays, 2); }, "no copy");
    arrays[1] = copy.get();
    expectInvalid([&] { relocateMicromaps(info, copy.get(), arrays, 2); }, "no opacity micromap");
}

TEST(MicromapBinding, SurvivesCompactionUpdateAndRelocation) {
    surviveCompactionUpdateAndRelocation(1);
}

TEST(MicromapBinding, SurvivesThemWithMotionKeysToo) {
    surviveCompactionUpdateAndRelocation(2);
}

TEST(MicromapBinding, UpdatesKeepToWhatTheBuildAllows) {
    const Array first = fiveMaps();
    const Array second = fiveMaps();
    const Mesh mesh = testing::cube();
    TriangleInput in = mesh.input();
    in.micromaps.indexing = MicromapIndexing::kLinear;
    in.micromaps.array = first.get();
    BuildInputs all;
    all.triangles = {&in, 1};
    BuildOptions options;
    options.allowUpdate = true;
    const Structure s = makeStructure(all, options);
    const auto temp = alignedBuffer(128);
    const auto refit = [&] { update(all, options, temp.get(), 128, s.memory.get(), s.size); };
    refit();
    in.micromaps.array = second.get();
    expectInvalid(refit, "ALLOW_OPACITY_MICROMAP_UPDATE");
    options.allowMicromapUpdate = true;
    expectInvalid(refit, "other build flags");
    options.allowMicromapUpdate = false;
    in.micromaps = {};
    expectInvalid(refit, "indexing mode 0, the build had 1");
}

} // namespace
} // namespace sunstone::bvh
