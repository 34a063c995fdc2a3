// SPDX-License-Identifier: Apache-2.0
#include "foliage.h"

#include "sampling.h"

#include <algorithm>
#include <cmath>

namespace {

class Random {
public:
    float operator()(float low, float high) {
        state_ = hashPcg(state_);
        return low + (high - low) * float(state_ >> 8) * 0x1p-24f;
    }

private:
    unsigned state_ = 1;
};

void addSquare(Foliage& foliage, float3 corner, float3 across, float3 up, float3 normal,
               Material material) {
    const unsigned first = unsigned(foliage.vertices.size());
    foliage.vertices.insert(foliage.vertices.end(),
                            {corner, corner + across, corner + across + up, corner + up});
    for (unsigned i : {0u, 1u, 2u, 0u, 2u, 3u})
        foliage.indices.push_back(first + i);
    foliage.materials.insert(foliage.materials.end(), {material, material});
    foliage.normals.push_back(normal);
}

struct Plant {
    float3 center, radii;
};
constexpr unsigned kPlants = 7;
const Plant kPlantList[kPlants] = {
    {{-4.2f, 1.4f, -1.5f}, {1.5f, 1.4f, 1.5f}}, {{-1.5f, 1.9f, 0.0f}, {1.2f, 1.9f, 1.2f}},
    {{1.4f, 1.1f, 0.8f}, {1.3f, 1.1f, 1.3f}},   {{4.1f, 2.2f, -0.8f}, {1.5f, 2.2f, 1.5f}},
    {{0.4f, 2.6f, -4.0f}, {2.4f, 2.6f, 2.0f}},  {{-6.5f, 2.5f, -5.5f}, {2.2f, 2.5f, 2.2f}},
    {{7.0f, 2.0f, -6.0f}, {2.5f, 2.0f, 2.5f}}};

void addLeaf(Foliage& foliage, const Plant& plant, Random& random) {
    float3 out;
    do
        out = vec(random(-1, 1), random(-1, 1), random(-1, 1));
    while (dot(out, out) > 1 || dot(out, out) < 0.01f);
    out = normalize(out);
    const float depth = 1 - 0.5f * random(0, 1) * random(0, 1);
    const float3 at =
        plant.center +
        vec(out.x * plant.radii.x, out.y * plant.radii.y, out.z * plant.radii.z) * depth;
    const float3 jitter = vec(random(-1, 1), random(-1, 1), random(-1, 1)) * 0.7f;
    const float3 normal = normalize(out + vec(0.0f, 0.4f, 0.0f) + jitter);
    float3 across, up;
    makeBasis(normal, across, up);
    const float2 turn = circlePoint(random(0, 1));
    const float size = random(0.4f, 0.8f);
    const float3 x = (across * turn.x + up * turn.y) * size;
    const float3 y = (up * turn.x - across * turn.y) * size;
    addSquare(foliage, at - (x + y) * 0.5f, x, y, normal, kLeaf);
}

// Whether the leaf is at (x, y), x from -1 to 1 about the middle vein, y from 0 at the stem to 1.
bool isLeaf(float x, float y) {
    const float side = std::fabs(x);
    if (y < 0.12f)
        return side < 0.045f;
    const float along = (y - 0.1f) / 0.88f;
    if (along >= 1)
        return false;
    const float lobes = 0.62f + 0.38f * std::fabs(std::sin(along * 3.14159265f * 4.5f));
    const float width = 0.92f * std::pow(std::sin(std::pow(along, 0.75f) * 3.14159265f), 0.8f);
    if (side > width * lobes)
        return false;
    // Holes eaten by insects.
    const float holes[3][3] = {{0.3f, 0.35f, 0.09f}, {-0.28f, 0.55f, 0.07f}, {0.2f, 0.68f, 0.05f}};
    for (const auto& hole : holes)
        if (std::hypot(x - hole[0], 2 * (y - hole[1])) < 2 * hole[2])
            return false;
    return true;
}

using Corner = float2; // of a micro-triangle, in coordinates of the mask

// Tests the box around the micro-triangle, so that no touched texel is omitted.
unsigned char stateOf(const Mask& mask, const Corner corners[3]) {
    const auto texel = [&](float value) {
        return unsigned(std::clamp(value * float(mask.size), 0.0f, float(mask.size - 1)));
    };
    // Rounding may move a hit slightly outside.
    const float margin = 1e-5f;
    const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
    const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    unsigned covered = 0, count = 0;
    for (unsigned y = texel(low - margin); y <= texel(high + margin); ++y)
        for (unsigned x = texel(left - margin); x <= texel(right + margin); ++x, ++count)
            covered += mask.texels[y * mask.size + x] != 0;
    if (covered == 0)
        return OPTIX_OPACITY_MICROMAP_STATE_TRANSPARENT;
    if (covered == count)
        return OPTIX_OPACITY_MICROMAP_STATE_OPAQUE;
    return 2 * covered < count ? OPTIX_OPACITY_MICROMAP_STATE_UNKNOWN_TRANSPARENT
                               : OPTIX_OPACITY_MICROMAP_STATE_UNKNOWN_OPAQUE;
}

// The order of micro-triangles: a triangle (A, B, C) is divided at the middles of its edges into
// (A, AB, AC), (AC, BC, AB), (AB, B, BC) and (BC, AC, C), and each of these again.
void addStates(const Mask& mask, Corner a, Corner b, Corner c, unsigned level,
               std::vector<unsigned char>& states) {
    const Corner corners[3] = {a, b, c};
    if (level == 0) {
        states.push_back(stateOf(mask, corners));
        return;
    }
    const auto middle = [](Corner p, Corner q) { return Corner{(p.x + q.x) / 2, (p.y + q.y) / 2}; };
    const Corner ab = middle(a, b), bc = middle(b, c), ac = middle(a, c);
    addStates(mask, a, ab, ac, level - 1, states);
    addStates(mask, ac, bc, ab, level - 1, states);
    addStates(mask, ab, b, bc, level - 1, states);
    addStates(mask, bc, ac, c, level - 1, states);
}

} // namespace

Foliage makeFoliage(unsigned leaves) {
    Foliage foliage;
    Random random;
    for (unsigned i = 0; i < leaves; ++i)
        addLeaf(foliage, kPlantList[i % kPlants], random);
    addSquare(foliage, vec(-60.0f, 0.0f, 40.0f), vec(120.0f, 0.0f, 0.0f), vec(0.0f, 0.0f, -120.0f),
              vec(0.0f, 1.0f, 0.0f), kGround);
    return foliage;
}

std::vector<unsigned char> makeLeafMask(unsigned size) {
    std::vector<unsigned char> texels;
    for (unsigned y = 0; y < size; ++y)
        for (unsigned x = 0; x < size; ++x)
            texels.push_back(
                isLeaf(2 * (float(x) + 0.5f) / float(size) - 1, (float(y) + 0.5f) / float(size))
                    ? 255
                    : 0);
    return texels;
}

std::vector<unsigned char> leafStates(const Mask& mask, unsigned triangle, unsigned level) {
    std::vector<unsigned char> states;
    const Corner barycentrics[3] = {{0, 0}, {1, 0}, {0, 1}};
    Corner c[3];
    for (int i = 0; i < 3; ++i)
        c[i] = leafCoordinates(triangle, barycentrics[i]);
    addStates(mask, c[0], c[1], c[2], level, states);
    return states;
}

std::vector<unsigned char> packStates(const std::vector<unsigned char>& states) {
    std::vector<unsigned char> bytes((states.size() + 3) / 4);
    for (size_t i = 0; i < states.size(); ++i)
        bytes[i / 4] |= (unsigned char)(states[i] << i % 4 * 2);
    return bytes;
}
