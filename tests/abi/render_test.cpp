// SPDX-License-Identifier: Apache-2.0
// One image through the table of each ABI, equal word for word; clients of several ABIs at once.
#include "scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <thread>

namespace tests::abi {
namespace {

template <class R>
class EachRelease : public testing::Test {};
using Releases =
    testing::Types<Release70, Release71, Release72, Release73, Release74, Release75, Release76>;
TYPED_TEST_SUITE(EachRelease, Releases);

const Image& expected() {
    static const Image image = Client<Release74>().render(64, 48);
    return image;
}

// The scene as triangles in world space.
struct Triangle {
    double v[3][3];
    uint32_t word; // added by a hit to its second barycentric
};

std::vector<Triangle> triangles() {
    const double corners[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const int indices[2][3] = {{0, 1, 2}, {1, 3, 2}};
    const double matrices[2][12] = {{0.5, 0, 0, 0, 0, 0.9, 0, 0.05, 0, 0, 1, 0},
                                    {0.4, 0.1, 0, 0.5, 0, 0.5, 0, 0.3, 0, 0, 1, 1}};
    std::vector<Triangle> all;
    for (uint32_t instance = 0; instance < 2; ++instance)
        for (uint32_t input = 0; input < 2; ++input) {
            Triangle t{};
            for (int k = 0; k < 3; ++k) {
                const double* corner = corners[indices[input][k]];
                const double p[4] = {corner[0] + 0.25 * input, corner[1], 0.5 * input, 1};
                for (int row = 0; row < 3; ++row)
                    for (int c = 0; c < 4; ++c)
                        t.v[k][row] += matrices[instance][4 * row + c] * p[c];
            }
            t.word =
                10 * input * 1000003u + (5 + instance) * 7919u + 31 * (2 + 2 * instance + input);
            all.push_back(t);
        }
    return all;
}

struct Hit {
    double z = 1e30, u = 0, v = 0, edge = 0; // edge: how far inside the triangle
    uint32_t word = 0;
};

// All triangles lie in planes of constant z.
Hit shoot(const std::vector<Triangle>& all, double x, double y) {
    Hit best;
    for (const Triangle& t : all) {
        const double z = t.v[0][2], px = x + 0.1 * (z + 2), py = y;
        const double ax = t.v[1][0] - t.v[0][0], ay = t.v[1][1] - t.v[0][1];
        const double bx = t.v[2][0] - t.v[0][0], by = t.v[2][1] - t.v[0][1];
        const double det = ax * by - ay * bx, qx = px - t.v[0][0], qy = py - t.v[0][1];
        const double u = (qx * by - qy * bx) / det, v = (ax * qy - ay * qx) / det;
        const double edge = std::min({u, v, 1 - u - v});
        if (std::abs(edge) < 1e-4)
            return {z, u, v, edge, 0}; // too near to an edge to decide
        if (edge > 0 && z < best.z)
            best = {z, u, v, edge, t.word};
    }
    return best;
}

TEST(Picture, ShowsTheScene) {
    const Image& image = expected();
    const std::vector<Triangle> all = triangles();
    std::set<uint32_t> seen;
    for (unsigned y = 0; y < image.height; ++y)
        for (unsigned x = 0; x < image.width; ++x) {
            const Hit hit = shoot(all, (x + 0.5) / image.width, (y + 0.5) / image.height);
            if (std::abs(hit.edge) < 1e-4 && hit.z < 1e30)
                continue;
            const uint32_t* words = &image.words[2 * (y * image.width + x)];
            seen.insert(hit.word);
            if (hit.z == 1e30) {
                EXPECT_EQ(12345u, words[0]);
                EXPECT_EQ(78u, words[1]) << "the miss program does not write it";
                continue;
            }
            EXPECT_NEAR(hit.u, std::bit_cast<float>(words[0] - 77), 1e-5) << x << ", " << y;
            EXPECT_NEAR(hit.v, std::bit_cast<float>(words[1] - hit.word), 1e-5) << x << ", " << y;
        }
    EXPECT_EQ(5u, seen.size()) << "four triangles and what is beside them";
}

TYPED_TEST(EachRelease, RendersTheSamePicture) {
    Client<TypeParam> client;
    EXPECT_TRUE(client.render(64, 48) == expected());
}

// In 7.0 the rays of a pipeline may have times although its modules were created without motion.
TEST(Picture, MotionOfOnePipeline) {
    const Image image =
        Client<Release70>().render(64, 48, {.showTime = true, .overrideMotionBlur = true});
    EXPECT_EQ(0.5f, std::bit_cast<float>(image.words[0])) << "the first pixel is a miss";
}

// Members and flags added in 7.5 and 7.6 have an effect.
TEST(Picture, InstancesApart) {
    Client<Release76> client;
    EXPECT_TRUE(client.render(64, 48, {.instanceStride = 80}) == expected());
    EXPECT_TRUE(client.render(64, 48, {.instanceStride = 112}) == expected());
}

template <class R>
size_t missesOf(const Variant& variant) {
    const Image image = Client<R>().render(64, 48, variant);
    size_t misses = 0;
    for (size_t i = 0; i < image.words.size(); i += 2)
        misses += image.words[i] == 12345;
    return misses;
}

TEST(Picture, FaceCullingPerGeometry) {
    constexpr unsigned kCullBack = 16, kCullFront = 32, kNeverCulled = 4, kPixels = 64 * 48;
    const size_t front = missesOf<Release76>({.rayFlags = kCullFront});
    const size_t back = missesOf<Release76>({.rayFlags = kCullBack});
    EXPECT_EQ(kPixels, std::max(front, back)) << "all triangles face the same way";
    const size_t none = missesOf<Release76>({});
    EXPECT_EQ(none, std::min(front, back));
    EXPECT_LT(none, kPixels);
    for (unsigned flags : {kCullBack, kCullFront}) {
        EXPECT_EQ(none, missesOf<Release75>({.rayFlags = flags, .geometryFlags = kNeverCulled}));
        EXPECT_EQ(none, missesOf<Release76>({.rayFlags = flags, .geometryFlags = kNeverCulled}));
    }
}

template <class R>
void renderOften(bool& same) {
    Client<R> client;
    same = true;
    for (int i = 0; i < 3; ++i)
        same = same && client.render(64, 48) == expected();
}

TEST(Picture, ClientsOfAllReleasesAtOnce) {
    expected();
    bool same[7] = {};
    std::thread threads[] = {std::thread(renderOften<Release70>, std::ref(same[0])),
                             std::thread(renderOften<Release71>, std::ref(same[1])),
                             std::thread(renderOften<Release72>, std::ref(same[2])),
                             std::thread(renderOften<Release73>, std::ref(same[3])),
                             std::thread(renderOften<Release74>, std::ref(same[4])),
                             std::thread(renderOften<Release75>, std::ref(same[5])),
                             std::thread(renderOften<Release76>, std::ref(same[6]))};
    for (std::thread& thread : threads)
        thread.join();
    for (bool one : same)
        EXPECT_TRUE(one);
}

} // namespace
} // namespace tests::abi
