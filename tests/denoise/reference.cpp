// SPDX-License-Identifier: Apache-2.0
#include "reference.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace hard {

const std::array<const char*, kClassCount> kClassNames = {"all",   "dark",     "bright",
                                                          "edges", "textures", "near lamps"};

namespace {

using sunstone::denoise::floatToHalf;
using sunstone::denoise::halfToFloat;

constexpr size_t kPixelBytes = 7;

float light(const float* pixel) {
    return 0.25f * pixel[0] + 0.5f * pixel[1] + 0.25f * pixel[2];
}
float largest(const float* pixel) {
    return std::max({pixel[0], pixel[1], pixel[2]});
}
float distance(const float* a, const float* b) {
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

class Classifier {
public:
    explicit Classifier(const Rendering& r) : r_(r) {}

    uint8_t of(uint32_t x, uint32_t y) const {
        const float *color = r_.color.at(x, y), *albedo = r_.albedo.at(x, y);
        unsigned bits = 1u << unsigned(Class::kAll);
        const auto add = [&](bool holds, Class which) {
            bits |= unsigned(holds) << unsigned(which);
        };
        add((largest(albedo) < 0.2f && light(color) < 0.15f) || light(color) < 0.05f, Class::kDark);
        add(light(color) > 0.7f, Class::kBright);
        add(anyWithin(x, y, 1, [&](uint32_t i, uint32_t j) { return isEdge(x, y, i, j); }),
            Class::kEdges);
        add(anyWithin(x, y, 1, [&](uint32_t i, uint32_t j) { return isTexture(x, y, i, j); }),
            Class::kTextures);
        add(light(color) < 1 &&
                anyWithin(x, y, 12,
                          [&](uint32_t i, uint32_t j) { return light(r_.color.at(i, j)) > 4; }),
            Class::kNearLamps);
        return uint8_t(bits);
    }

private:
    template <class Holds>
    bool anyWithin(uint32_t x, uint32_t y, int reach, Holds holds) const {
        for (int dy = -reach; dy <= reach; ++dy)
            for (int dx = -reach; dx <= reach; ++dx) {
                const int i = int(x) + dx, j = int(y) + dy;
                if (i >= 0 && j >= 0 && i < int(r_.color.width) && j < int(r_.color.height) &&
                    holds(uint32_t(i), uint32_t(j)))
                    return true;
            }
        return false;
    }
    bool isEdge(uint32_t x, uint32_t y, uint32_t i, uint32_t j) const {
        return distance(r_.albedo.at(x, y), r_.albedo.at(i, j)) > 0.3f ||
               distance(r_.normal.at(x, y), r_.normal.at(i, j)) > 0.6f;
    }
    // Steps of the reflectance on one surface, or of the light where that is 0.
    bool isTexture(uint32_t x, uint32_t y, uint32_t i, uint32_t j) const {
        if (distance(r_.normal.at(x, y), r_.normal.at(i, j)) > 0.3f)
            return false;
        float a = light(r_.albedo.at(x, y)), b = light(r_.albedo.at(i, j));
        if (std::max(a, b) < 0.005f) {
            a = light(r_.color.at(x, y));
            b = light(r_.color.at(i, j));
        }
        return std::max(a, b) > 0.005f && std::abs(a - b) > 0.2f * std::max(a, b);
    }

    const Rendering& r_;
};

} // namespace

Reference renderReference(const Scene& scene, uint32_t samples) {
    const Rendering r = render(scene, kWidth, kHeight, samples, 7777);
    Reference reference{r.color, std::vector<uint8_t>(size_t(kWidth) * kHeight)};
    const Classifier classifier(r);
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x)
            reference.classes[size_t(y) * kWidth + x] = classifier.of(x, y);
    return reference;
}

void saveReference(const Reference& reference, const std::string& path) {
    std::vector<char> bytes;
    for (size_t i = 0; i < reference.classes.size(); ++i) {
        for (size_t c = 0; c < 3; ++c) {
            const uint16_t half = floatToHalf(reference.color.values[4 * i + c]);
            bytes.push_back(char(half & 255));
            bytes.push_back(char(half >> 8));
        }
        bytes.push_back(char(reference.classes[i]));
    }
    std::ofstream file(path, std::ios::binary);
    if (!file.write(bytes.data(), std::streamsize(bytes.size())).flush())
        throw std::runtime_error("cannot write " + path);
}

Reference loadReference(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const size_t pixels = size_t(kWidth) * kHeight;
    if (bytes.size() != pixels * kPixelBytes)
        throw std::runtime_error(path + " has " + std::to_string(bytes.size()) +
                                 " bytes in place of " + std::to_string(pixels * kPixelBytes));
    Reference reference{Picture(kWidth, kHeight), std::vector<uint8_t>(pixels)};
    for (size_t i = 0; i < pixels; ++i) {
        const auto* at = reinterpret_cast<const uint8_t*>(bytes.data()) + i * kPixelBytes;
        for (size_t c = 0; c < 3; ++c)
            reference.color.values[4 * i + c] =
                halfToFloat(uint16_t(at[2 * c] | (at[2 * c + 1] << 8)));
        reference.classes[i] = at[6];
    }
    return reference;
}

} // namespace hard
