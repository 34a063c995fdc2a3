// SPDX-License-Identifier: Apache-2.0
// Sampling against a reference written from the definition: coordinates in long double, one texel
// at a time. Recordings of a GPU are in tests/cuda/apps.
#include "texture/device_functions.h"
#include "texture/fetch.h"
#include "texture/texture.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>

namespace sunstone::texture {
namespace {

struct Sampled {
    float v[4];
};

Sampled sampleAt(uint64_t handle, uint32_t form, float x, float y = 0, float z = 0,
                 uint32_t layer = 0, float level = 0) {
    SampleOperands operands{};
    operands.position[0] = std::bit_cast<uint32_t>(x);
    operands.position[1] = std::bit_cast<uint32_t>(y);
    operands.position[2] = std::bit_cast<uint32_t>(z);
    operands.layer = layer;
    operands.level = level;
    operands.dx[0] = z;
    operands.dy[1] = level;
    Sampled result;
    uint32_t words[4];
    sample(handle, form, &operands, words);
    std::memcpy(result.v, words, sizeof words);
    return result;
}

std::shared_ptr<Array> makeFloats(Shape shape, unsigned seed) {
    auto array = std::make_shared<Array>(Format{Channel::kF32, 1}, shape);
    auto* texels = reinterpret_cast<float*>(array->data());
    for (size_t i = 0; i < array->bytes() / 4; ++i)
        texels[i] = float((i * 37 + seed * 11) % 101);
    return array;
}

std::unique_ptr<Texture> textureOf(const std::shared_ptr<Array>& array) {
    auto texture = std::make_unique<Texture>();
    texture->format = array->format();
    texture->images[0] = array->image();
    texture->layered = array->shape().layered;
    texture->cube = array->shape().cube;
    texture->is3D = array->shape().depth && !texture->layered && !texture->cube;
    texture->arrays = {array};
    return texture;
}

// The number of the texel that an address mode gives for texel i; -1: border.
long texelOf(Address mode, bool normalized, long i, long size) {
    if (!normalized && (mode == Address::kWrap || mode == Address::kMirror))
        mode = Address::kClamp;
    switch (mode) {
    case Address::kWrap:
        return ((i % size) + size) % size;
    case Address::kMirror: {
        const long period = ((i % (2 * size)) + 2 * size) % (2 * size);
        return period < size ? period : 2 * size - 1 - period;
    }
    case Address::kBorder:
        return i < 0 || i >= size ? -1 : i;
    default:
        return std::min(std::max(i, 0L), size - 1);
    }
}

TEST(Sample, EveryModeAgainstTheDefinition) {
    constexpr long kWidth = 5, kHeight = 7;
    const auto array = makeFloats({uint32_t(kWidth), uint32_t(kHeight)}, 1);
    const auto* texels = reinterpret_cast<const float*>(array->data());
    const unsigned seed = 20240611;
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> position(-2.5f, 3.5f);
    for (int mode = 0; mode < 4; ++mode)
        for (const bool linear : {false, true})
            for (const bool normalized : {false, true}) {
                auto texture = textureOf(array);
                texture->address[0] = texture->address[1] = Address(mode);
                texture->linear = linear;
                texture->normalizedCoordinates = normalized;
                texture->border[0] = 0.25f;
                const uint64_t handle = add(std::move(texture));
                const auto at = [&](long i, long j) {
                    const long x = texelOf(Address(mode), normalized, i, kWidth);
                    const long y = texelOf(Address(mode), normalized, j, kHeight);
                    return x < 0 || y < 0 ? 0.25 : double(texels[y * kWidth + x]);
                };
                for (int n = 0; n < 300; ++n) {
                    const float x = position(random) * (normalized ? 1 : kWidth);
                    const float y = position(random) * (normalized ? 1 : kHeight);
                    const double u = double(x) * (normalized ? kWidth : 1) - (linear ? 0.5 : 0);
                    const double v = double(y) * (normalized ? kHeight : 1) - (linear ? 0.5 : 0);
                    const long i = long(std::floor(u)), j = long(std::floor(v));
                    double want = at(i, j);
                    if (linear) {
                        const double a = u - double(i), b = v - double(j);
                        want = (1 - a) * (1 - b) * at(i, j) + a * (1 - b) * at(i + 1, j) +
                               (1 - a) * b * at(i, j + 1) + a * b * at(i + 1, j + 1);
                    }
                    // Weights have eight bits: two of them are off by half a unit each.
                    const double tolerance = linear ? 101.0 * 2 / 256 : 0;
                    EXPECT_NEAR(sampleAt(handle, k2D, x, y).v[0], want, tolerance)
                        << "mode " << mode << " linear " << linear << " normalized " << normalized
                        << " at " << x << ", " << y << ", seed " << seed;
                }
                EXPECT_TRUE(removeTexture(handle));
            }
}

TEST(Sample, WeightsAreRoundedTo256ths) {
    const auto array = std::make_shared<Array>(Format{Channel::kF32, 1}, Shape{2});
    const float texels[2] = {0, 1};
    std::memcpy(array->data(), texels, sizeof texels);
    auto texture = textureOf(array);
    texture->linear = true;
    texture->address[0] = Address::kClamp;
    const uint64_t handle = add(std::move(texture));
    for (int k = 0; k <= 2048; ++k)
        EXPECT_EQ(sampleAt(handle, k1D, 0.5f + float(k) / 2048).v[0],
                  float(std::floor(k / 8.0 + 0.5) / 256))
            << k;
    removeTexture(handle);
}

TEST(Sample, VolumesAndLayers) {
    const auto volume = makeFloats({3, 4, 5}, 2);
    const auto layers = makeFloats({3, 4, 5, true}, 2);
    const auto* texels = reinterpret_cast<const float*>(volume->data());
    auto texture = textureOf(volume);
    texture->linear = true;
    for (Address& address : texture->address)
        address = Address::kClamp;
    const uint64_t three = add(std::move(texture)), layered = add(textureOf(layers));
    for (uint32_t z = 0; z < 5; ++z)
        for (uint32_t y = 0; y < 4; ++y)
            for (uint32_t x = 0; x < 3; ++x) {
                const float want = texels[(z * 4 + y) * 3 + x];
                const float fx = float(x) + 0.5f, fy = float(y) + 0.5f;
                EXPECT_EQ(sampleAt(three, k3D, fx, fy, float(z) + 0.5f).v[0], want);
                EXPECT_EQ(sampleAt(layered, k2DArray, fx, fy, 0, z).v[0], want);
            }
    const float middle = sampleAt(three, k3D, 1, 1, 1).v[0];
    float mean = 0;
    for (int corner = 0; corner < 8; ++corner)
        mean += texels[((corner >> 2) * 4 + (corner >> 1 & 1)) * 3 + (corner & 1)] / 8;
    EXPECT_FLOAT_EQ(middle, mean);
    EXPECT_EQ(sampleAt(layered, k2DArray, 0.5f, 0.5f, 0, 99).v[0], texels[4 * 12]);
    removeTexture(three);
    removeTexture(layered);
}

// The weights of the eight texels have the sum 1 in all places.
TEST(Sample, ConstantVolumesReadTheConstant) {
    auto volume = std::make_shared<Array>(Format{Channel::kF32, 1}, Shape{4, 4, 4});
    std::fill_n(reinterpret_cast<float*>(volume->data()), volume->bytes() / 4, 1.0f);
    auto texture = textureOf(volume);
    texture->linear = true;
    const uint64_t handle = add(std::move(texture));
    const auto place = [](uint32_t fraction) { return 1.5f + float(fraction) / 256; };
    EXPECT_EQ(sampleAt(handle, k3D, place(250), place(236), place(16)).v[0], 1.0f);
    for (uint32_t x = 0; x < 256; x += 3)
        for (uint32_t y = 0; y < 256; y += 5)
            for (uint32_t z = 0; z < 256; z += 2)
                ASSERT_EQ(sampleAt(handle, k3D, place(x), place(y), place(z)).v[0], 1.0f)
                    << x << " " << y << " " << z;
    removeTexture(handle);
}

TEST(Sample, Levels) {
    auto texture = std::make_unique<Texture>();
    for (unsigned level = 0; level < 3; ++level) {
        const auto array =
            std::make_shared<Array>(Format{Channel::kF32, 1}, shapeOfLevel({4, 4}, level));
        auto* texels = reinterpret_cast<float*>(array->data());
        std::fill(texels, texels + array->bytes() / 4, float(level * 10));
        texture->images[level] = array->image();
        texture->arrays.push_back(array);
    }
    texture->format = {Channel::kF32, 1};
    texture->levels = 3;
    texture->linearLevels = texture->normalizedCoordinates = true;
    texture->maxLevel = 1.75f;
    texture->minLevel = 0.25f;
    texture->levelBias = 0.5f;
    const uint64_t handle = add(std::move(texture));
    const auto level = [&](float l) {
        return sampleAt(handle, k2D | kWithLevel, 0.5f, 0.5f, 0, 0, l).v[0];
    };
    EXPECT_FLOAT_EQ(level(-5), 2.5f);
    EXPECT_FLOAT_EQ(level(0.25f), 7.5f);
    EXPECT_FLOAT_EQ(level(9), 17.5f);
    EXPECT_FLOAT_EQ(level(NAN), 2.5f);
    removeTexture(handle);
}

TEST(Sample, HandlesThatAreNotAlive) {
    for (const uint64_t handle : {uint64_t(0), uint64_t(1) << 40, ~uint64_t(0), uint64_t(12345)})
        EXPECT_EQ(sampleAt(handle, k2D, 0.5f, 0.5f).v[0], 0);
    auto array = makeFloats({4, 4}, 3);
    const uint64_t old = add(textureOf(array));
    EXPECT_TRUE(removeTexture(old));
    EXPECT_FALSE(removeTexture(old));
    const uint64_t fresh = add(textureOf(array));
    EXPECT_NE(old, fresh);
    EXPECT_EQ(sampleAt(old, k2D, 0.5f, 0.5f).v[0], 0);
    EXPECT_FALSE(removeSurface(fresh));
    EXPECT_EQ(surfaceAddress(fresh, k2D | 4 << kBytesShift, 0, 0, 0, 0), nullptr);
    removeTexture(fresh);
}

TEST(Sample, ExtremeCoordinates) {
    const auto array = makeFloats({5, 7}, 4);
    for (int mode = 0; mode < 4; ++mode)
        for (const bool linear : {false, true})
            for (const bool normalized : {false, true}) {
                auto texture = textureOf(array);
                texture->address[0] = texture->address[1] = Address(mode);
                texture->linear = linear;
                texture->normalizedCoordinates = normalized;
                texture->anisotropy = 8;
                texture->minLevel = mode == 1 ? NAN : 0;
                texture->maxLevel = mode == 2 ? NAN : 1;
                const uint64_t handle = add(std::move(texture));
                for (const float c : {0.0f, -0.0f, 1.0f, -1.0f, 1e-45f, -1e-45f, 1e30f, -1e30f,
                                      INFINITY, -INFINITY, NAN, 0.99999994f, -1e-9f})
                    for (const uint32_t form :
                         {uint32_t(k1D), uint32_t(k2D), uint32_t(k3D), uint32_t(kCube),
                          uint32_t(kCubeArray), uint32_t(k2DArray), k2D | kGather,
                          k2D | kWithGradient, k2D | kIntegerCoordinates}) {
                        const float value = sampleAt(handle, form, c, -c, c, ~0u, c).v[0];
                        EXPECT_TRUE(value >= 0 && value <= 101) << value << " at " << c;
                    }
                removeTexture(handle);
            }
}

TEST(Sample, DirectionsThatAreNone) {
    auto array = makeFloats({4, 4, 6, false, true}, 5);
    for (const bool seamless : {false, true}) {
        auto texture = textureOf(array);
        texture->linear = texture->normalizedCoordinates = true;
        texture->seamless = seamless;
        const uint64_t handle = add(std::move(texture));
        for (const float x : {0.0f, 1.0f, -1.0f, INFINITY, NAN, 1e30f, 1e-45f})
            for (const float y : {0.0f, 1.0f, -INFINITY, NAN})
                for (const float z : {0.0f, -1.0f, INFINITY, NAN}) {
                    const float value = sampleAt(handle, kCube, x, y, z).v[0];
                    EXPECT_TRUE(value >= 0 && value <= 101) << x << " " << y << " " << z;
                }
        removeTexture(handle);
    }
}

TEST(Fetch, HalfFloatsBothWays) {
    for (uint32_t half = 0; half < 65536; ++half) {
        const float value = halfToFloat(uint16_t(half));
        if (std::isnan(value))
            EXPECT_TRUE(std::isnan(halfToFloat(floatToHalf(value))));
        else
            EXPECT_EQ(floatToHalf(value), half);
    }
    EXPECT_EQ(floatToHalf(65519.0f), 0x7BFF);
    EXPECT_EQ(floatToHalf(65520.0f), 0x7C00);
}

TEST(Fetch, Blocks) {
    // Ends: red 31 and blue 31; indices 0, 1, 2, 3 in the first row.
    const uint8_t bc1[8] = {0x00, 0xF8, 0x1F, 0x00, 0xE4, 0, 0, 0};
    const float want[4][2] = {{1, 0}, {0, 1}, {2.0f / 3, 1.0f / 3}, {1.0f / 3, 2.0f / 3}};
    for (unsigned x = 0; x < 4; ++x) {
        float color[4];
        decodeBlock(Channel::kBC1, bc1, x, 0, color);
        EXPECT_FLOAT_EQ(color[0], want[x][0]);
        EXPECT_FLOAT_EQ(color[2], want[x][1]);
        EXPECT_EQ(color[3], 1);
    }
    // The other order of ends: a mean and a transparent black.
    const uint8_t black[8] = {0x1F, 0x00, 0x00, 0xF8, 0xE4, 0, 0, 0};
    float color[4];
    decodeBlock(Channel::kBC1, black, 2, 0, color);
    EXPECT_FLOAT_EQ(color[0], 127 / 255.0f);
    decodeBlock(Channel::kBC1, black, 3, 0, color);
    EXPECT_EQ(color[3], 0);
    // Ends 255 and 0, indices 0 to 7 from the first texel on.
    const uint8_t bc4[8] = {255, 0, 0x88, 0xC6, 0xFA, 0, 0, 0};
    const float ramp[8] = {257, 0, 221, 185, 144, 113, 72, 36}; // sevenths as GPUs have them
    const int alpha[8] = {255, 0, 219, 183, 144, 111, 72, 36};
    uint8_t bc3[16] = {};
    std::memcpy(bc3, bc4, sizeof bc4);
    for (unsigned i = 0; i < 8; ++i) {
        decodeBlock(Channel::kBC4U, bc4, i % 4, i / 4, color);
        EXPECT_FLOAT_EQ(color[0], ramp[i] / 257) << i;
        decodeBlock(Channel::kBC3, bc3, i % 4, i / 4, color);
        EXPECT_EQ(color[3], float(alpha[i]) / 255) << i;
    }
}

TEST(Sample, NormalizedPositionsAreCutTo23Bits) {
    auto texture = textureOf(makeFloats({6, 1, 0}, 1));
    texture->normalizedCoordinates = true;
    const uint64_t handle = add(std::move(texture));
    // A third as a float is more than a third, but not in 23 bits.
    const float below = sampleAt(handle, k2D, 0.3f, 0.5f).v[0];
    const float above = sampleAt(handle, k2D, 0.34f, 0.5f).v[0];
    EXPECT_NE(below, above);
    EXPECT_EQ(sampleAt(handle, k2D, 1 / 3.0f, 0.5f).v[0], below);
    EXPECT_EQ(sampleAt(handle, k2D, 0.5f, 0.5f).v[0], sampleAt(handle, k2D, 0.51f, 0.5f).v[0]);
    removeTexture(handle);
}

TEST(Fetch, FormattedStoresSaturate) {
    const uint32_t words[4] = {300, 0xFFFFFFFF, 5, 1};
    uint8_t bytes[4];
    storeWords({Channel::kU8, 4}, bytes, words);
    EXPECT_EQ(bytes[0], 255);
    EXPECT_EQ(bytes[1], 255);
    EXPECT_EQ(bytes[2], 5);
    int8_t signs[4];
    storeWords({Channel::kS8, 4}, reinterpret_cast<uint8_t*>(signs), words);
    EXPECT_EQ(signs[0], 127);
    EXPECT_EQ(signs[1], -1);
    // A float between two halves is cut towards zero; there is no infinity.
    const float floats[2] = {1 + 0x1.8p-10f, -1e6f};
    uint32_t raw[2];
    std::memcpy(raw, floats, sizeof raw);
    uint16_t halves[2];
    storeWords({Channel::kF16, 2}, reinterpret_cast<uint8_t*>(halves), raw);
    EXPECT_EQ(halves[0], 0x3C01);
    EXPECT_EQ(halves[1], 0xFBFF);
}

TEST(Surface, PlacesAndBounds) {
    auto surface = std::make_unique<Surface>();
    surface->array = std::make_shared<Array>(Format{Channel::kU8, 4}, Shape{6, 5, 3, true});
    uint8_t* base = surface->array->data();
    const uint64_t handle = add(std::move(surface));
    const uint32_t word = k2DArray | 4 << kBytesShift;
    EXPECT_EQ(surfaceAddress(handle, word, 8, 2, 0, 1), base + 120 + 48 + 8);
    EXPECT_EQ(surfaceAddress(handle, word, 24, 0, 0, 0), nullptr);
    EXPECT_EQ(surfaceAddress(handle, word, -4, 0, 0, 0), nullptr);
    EXPECT_EQ(surfaceAddress(handle, word, 22, 0, 0, 0), nullptr);
    EXPECT_EQ(surfaceAddress(handle, word, 0, 5, 0, 0), nullptr);
    EXPECT_EQ(surfaceAddress(handle, word, 0, 0, 0, 3), nullptr);
    EXPECT_EQ(surfaceAddress(handle, word | kClamp, 1000, -7, 0, 9), base + 240 + 20);
    EXPECT_EQ(surfaceAddress(handle, word | kFormatted, 5, 0, 0, 0), base + 20);
    EXPECT_TRUE(removeSurface(handle));
}

} // namespace
} // namespace sunstone::texture
