// SPDX-License-Identifier: Apache-2.0
// Footprints against the sampler itself: a group of texels belongs to the mask if the sample
// changes with it.
#include "texture/device_functions.h"
#include "texture/footprint_of_size.h"
#include "texture/texture.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <random>
#include <set>

namespace sunstone::texture {
namespace {

struct Decoded {
    std::set<std::pair<int, int>> groups; // column, row
    unsigned level, granularity;
};

// Decodes as the manual defines, with groups beyond the left edge taken from the right.
Decoded decode(const uint32_t words[4], int columns, int rows) {
    Decoded result;
    const uint64_t mask = uint64_t(words[1]) << 32 | words[0];
    const int tileX = int(words[3] & 0xFFF), tileY = int(words[2] & 0xFFF);
    const int dx = int(words[2] >> 16 & 7), dy = int(words[2] >> 19 & 7);
    for (int bit = 0; bit < 64; ++bit)
        if (mask >> bit & 1) {
            const int x = bit % 8, y = bit / 8;
            const int column = tileX * 8 + x - (x >= 8 - dx ? 8 : 0);
            const int row = tileY * 8 + y - (y >= 8 - dy ? 8 : 0);
            result.groups.insert({(column + columns) % columns, (row + rows) % rows});
        }
    result.level = words[3] >> 12 & 15;
    result.granularity = words[2] >> 24 & 15;
    return result;
}

// A float texture with a chain of levels, all zero.
struct Levels {
    Levels(uint32_t width, uint32_t height, unsigned levels) {
        auto made = std::make_unique<Texture>();
        texture = made.get();
        texture->format = {Channel::kF32, 1};
        texture->levels = levels;
        for (unsigned k = 0; k < levels; ++k) {
            auto array = std::make_shared<Array>(Format{Channel::kF32, 1},
                                                 Shape{std::max(1u, width >> k), std::max(1u, height >> k)});
            std::memset(array->data(), 0, array->bytes());
            texture->images[k] = array->image();
            texture->arrays.push_back(array);
        }
        texture->linear = texture->linearLevels = texture->normalizedCoordinates = true;
        texture->maxLevel = float(levels - 1);
        handle = add(std::move(made));
    }
    ~Levels() { removeTexture(handle); }
    Texture* texture;
    uint64_t handle;
};

float sampled(uint64_t handle, uint32_t form, const SampleOperands& operands) {
    uint32_t words[4];
    sample(handle, form, &operands, words);
    return std::bit_cast<float>(words[0]);
}

// Groups of one level that the sample depends on.
std::set<std::pair<int, int>> dependsOn(const Levels& levels, unsigned level, uint32_t form,
                                        const SampleOperands& operands, int side) {
    std::set<std::pair<int, int>> groups;
    const Image& image = levels.texture->images[level];
    const auto fill = [&](int column, int row, float value) {
        for (uint32_t y = uint32_t(row * side); y < std::min(image.height, uint32_t((row + 1) * side)); ++y)
            for (uint32_t x = uint32_t(column * side);
                 x < std::min(image.width, uint32_t((column + 1) * side)); ++x)
                std::memcpy(const_cast<uint8_t*>(image.data) + y * image.rowPitch + 4 * x, &value, 4);
    };
    for (int row = 0; row * side < int(image.height); ++row)
        for (int column = 0; column * side < int(image.width); ++column) {
            fill(column, row, 1e6f);
            if (sampled(levels.handle, form, operands) != 0)
                groups.insert({column, row});
            fill(column, row, 0);
        }
    return groups;
}

constexpr uint32_t kTiles8 = 3u << 20 | 3u << 16; // 8 x 8 texels

TEST(Footprint, HoldsWhatTheSampleDependsOn) {
    constexpr unsigned kSeed = 12;
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<float> position(-0.2f, 1.2f), change(-0.1f, 0.1f), level(0, 3);
    for (Address address : {Address::kWrap, Address::kClamp, Address::kMirror, Address::kBorder}) {
        Levels levels(96, 64, 4);
        levels.texture->address[0] = levels.texture->address[1] = address;
        levels.texture->anisotropy = 8;
        for (int i = 0; i < 30; ++i) {
            SampleOperands operands{};
            operands.position[0] = std::bit_cast<uint32_t>(position(random));
            operands.position[1] = std::bit_cast<uint32_t>(position(random));
            const uint32_t forms[] = {k2D, k2D | kWithLevel, k2D | kWithGradient};
            const uint32_t form = forms[i % 3];
            operands.level = level(random);
            for (int k = 0; k < 2; ++k) {
                operands.dx[k] = change(random);
                operands.dy[k] = change(random) * 0.1f;
            }
            std::set<unsigned> seen;
            for (uint32_t coarse : {0u, 1u}) {
                SCOPED_TRACE(testing::Message() << "seed " << kSeed << " address " << int(address)
                                                << " case " << i << " coarse " << coarse);
                uint32_t single = 7, words[4];
                footprint(levels.handle, kTiles8, form, &operands, coarse, &single, words);
                const unsigned at = words[3] >> 12 & 15;
                const Image& image = levels.texture->images[at];
                const int columns = int(image.width + 7) / 8, rows = int(image.height + 7) / 8;
                const Decoded result = decode(words, columns, rows);
                ASSERT_EQ(0u, result.granularity);
                ASSERT_EQ(dependsOn(levels, at, form, operands, 8), result.groups);
                seen.insert(at);
                ASSERT_LE(single, 1u);
                if (coarse) {
                    ASSERT_EQ(single ? 1u : 2u, seen.size());
                }
            }
        }
    }
}

// Texels at both edges of an image with many groups: the mask wraps if the image does, otherwise
// groups are larger.
TEST(Footprint, EdgesAndGranularity) {
    Levels levels(1024, 1024, 1);
    SampleOperands operands{};
    operands.position[1] = std::bit_cast<uint32_t>(0.5f);
    uint32_t single, words[4];
    footprint(levels.handle, kTiles8, k2D, &operands, 0, &single, words);
    EXPECT_EQ(1u, single);
    EXPECT_EQ(7u, words[2] >> 16 & 7); // columns left of the edge, of which one is used
    EXPECT_EQ(0u, words[3] & 0xFFF);
    EXPECT_EQ((std::set<std::pair<int, int>>{{0, 63}, {127, 63}, {0, 64}, {127, 64}}),
              decode(words, 128, 128).groups);
    // 90 texels in a row need more than eight groups of 8.
    levels.texture->anisotropy = 16;
    operands.dx[0] = 90.0f / 1024;
    operands.position[0] = std::bit_cast<uint32_t>(0.4f);
    footprint(levels.handle, kTiles8, k2D | kWithGradient, &operands, 0, &single, words);
    EXPECT_EQ(6u, words[2] >> 24 & 15); // 16 x 8
    EXPECT_NE(0u, words[0] | words[1]);
}

// The result of GPUs, computed from the size alone.
TEST(Footprint, OfTheSizeIsThatOfTheTexture) {
    constexpr unsigned kSeed = 5;
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<float> position(-1.2f, 2.2f), change(-0.2f, 0.2f), level(-1, 6);
    const Address addresses[] = {Address::kWrap, Address::kClamp, Address::kMirror, Address::kBorder};
    constexpr uint32_t kSizes[][2] = {{256, 64}, {100, 37}, {1, 9}, {1024, 1024}};
    for (const auto& size : kSizes)
        for (int i = 0; i < 1500; ++i) {
            const unsigned count = 1 + random() % 5, x = random() % 4, y = random() % 4;
            Levels levels(size[0], size[1], count);
            Texture& texture = *levels.texture;
            texture.address[0] = addresses[x];
            texture.address[1] = addresses[y];
            texture.anisotropy = 1 + random() % 16;
            texture.linearLevels = random() % 2;
            texture.normalizedCoordinates = random() % 8 != 0;
            const uint32_t info = count << 24 | random() % 10 << 20 | random() % 10 << 16 | x << 8 |
                                  y << 6 | uint32_t(texture.linearLevels) << 5 | texture.anisotropy;
            const float scale = texture.normalizedCoordinates ? 1 : 100;
            SampleOperands operands{};
            for (int k = 0; k < 2; ++k) {
                operands.position[k] = std::bit_cast<uint32_t>(position(random) * scale);
                operands.dx[k] = change(random) * scale;
                operands.dy[k] = change(random) * scale * 0.1f;
            }
            operands.level = level(random);
            const uint32_t forms[] = {k2D, k2D | kWithLevel, k2D | kWithGradient};
            const uint32_t form = forms[i % 3], coarse = random() % 2;
            uint32_t single = 7, words[4], singleOfSize = 8, ofSize[4];
            footprint(levels.handle, info, form, &operands, coarse, &single, words);
            footprintOfSize(size[0], size[1], texture.normalizedCoordinates, info, form, &operands,
                            coarse, &singleOfSize, ofSize);
            ASSERT_TRUE(std::equal(words, words + 4, ofSize) && single == singleOfSize)
                << "seed " << kSeed << ", " << size[0] << " x " << size[1] << ", case " << i;
        }
}

TEST(Footprint, NoTexture) {
    SampleOperands operands{};
    for (uint64_t handle : {uint64_t(0), uint64_t(12345), ~uint64_t(0)}) {
        uint32_t single = 7, words[4] = {1, 2, 3, 4};
        footprint(handle, ~0u, k2D, &operands, 1, &single, words);
        EXPECT_EQ(1u, single);
        EXPECT_EQ(0u, words[0] | words[1] | words[2] | words[3]);
        footprint(handle, 0, k2D, &operands, 1, nullptr, words);
    }
}

} // namespace
} // namespace sunstone::texture
