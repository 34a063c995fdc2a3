// SPDX-License-Identifier: Apache-2.0
// optix_micromap.h against the look-up of traversal.
#include "bvh/micromap/micromap.h"

#include <optix.h>

#include <optix_micromap.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <utility>

namespace tests::api {
namespace {

using Corners = std::array<float2, 3>;

Corners cornersOf(unsigned index, unsigned level) {
    Corners c{};
    optixMicromapIndexToBaseBarycentrics(index, level, c[0], c[1], c[2]);
    return c;
}

void expectPlace(unsigned index, unsigned level) {
    SCOPED_TRACE(testing::Message() << index << " of level " << level);
    const Corners c = cornersOf(index, level);
    const float u = (c[0].x + c[1].x + c[2].x) / 3, v = (c[0].y + c[1].y + c[2].y) / 3;
    EXPECT_EQ(index, sunstone::bvh::microTriangleAt(u, v, level));
    const float step = 1.0f / float(1u << level);
    EXPECT_EQ(c[0].y, c[1].y);
    EXPECT_EQ(c[0].x, c[2].x);
    EXPECT_EQ(step, std::abs(c[1].x - c[0].x));
    EXPECT_EQ(c[1].x - c[0].x, c[2].y - c[0].y) << "upright, or on its head";
    for (const float2& corner : c)
        EXPECT_TRUE(corner.x >= 0 && corner.y >= 0 && corner.x + corner.y <= 1);
}

TEST(MicromapHeader, TheWholeTriangle) {
    const Corners c = cornersOf(0, 0);
    EXPECT_TRUE(c[0].x == 0 && c[0].y == 0 && c[1].x == 1 && c[1].y == 0 && c[2].x == 0 &&
                c[2].y == 1);
}

TEST(MicromapHeader, PlacesAreThoseOfTheLookUp) {
    for (unsigned level = 0; level <= 5; ++level)
        for (unsigned index = 0; index < 1u << 2 * level; ++index)
            expectPlace(index, level);
    std::mt19937 random(76);
    for (unsigned level = 6; level <= OPTIX_OPACITY_MICROMAP_MAX_SUBDIVISION_LEVEL; ++level)
        for (int i = 0; i < 200; ++i)
            expectPlace(random() & ((1u << 2 * level) - 1), level);
}

TEST(MicromapHeader, NeighboursOnTheCurveTouch) {
    const auto points = [](unsigned index) {
        std::set<std::pair<float, float>> set;
        for (const float2& corner : cornersOf(index, 4))
            set.emplace(corner.x, corner.y);
        return set;
    };
    for (unsigned index = 1; index < 256; ++index) {
        const auto before = points(index - 1), here = points(index);
        EXPECT_LE(1, std::count_if(here.begin(), here.end(),
                                   [&](const auto& p) { return before.count(p) != 0; }))
            << index;
    }
}

} // namespace
} // namespace tests::api
