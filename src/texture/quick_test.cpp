// SPDX-License-Identifier: Apache-2.0
// Quick functions against the generic code, bit for bit: formats, filters, address modes, kinds of
// coordinates, shapes and forms of calls.
#include "texture/quick.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>

namespace sunstone::texture {
namespace {

constexpr Channel kChannels[] = {Channel::kU8,  Channel::kU16, Channel::kU32, Channel::kS8,
                                 Channel::kS16, Channel::kS32, Channel::kF16, Channel::kF32};
constexpr float kSpecial[] = {0.0f,   -0.0f,    1.0f,      -1.0f, 1e-45f,      -1e-45f, 1e30f,
                              -1e30f, INFINITY, -INFINITY, NAN,   0.99999994f, -1e-9f,  1 / 3.0f,
                              0.5f,   1e12f,    -6e11f,    8.5f,  1023.5f};

struct Images {
    const char* name;
    Shape shape;
    unsigned levels;
};
constexpr Images kImages[] = {
    {"line", {13}, 1},
    {"image", {5, 7}, 1},
    {"levels", {16, 8}, 4},
    {"volume", {5, 6, 7}, 1},
    {"levels of a volume", {8, 8, 4}, 3},
    {"layers", {5, 7, 3, true}, 1},
    {"layers of lines", {9, 0, 4, true}, 1},
    {"cube", {6, 6, 6, false, true}, 1},
    {"cubes", {4, 4, 12, true, true}, 2},
};

// A texture of random bytes; `special` floats and halves are infinite or NaN now and then.
std::unique_ptr<Texture> randomTexture(const Images& images, Format format, bool special,
                                       std::mt19937& random) {
    auto texture = std::make_unique<Texture>();
    texture->format = format;
    texture->levels = images.levels;
    for (unsigned level = 0; level < images.levels; ++level) {
        const auto array = std::make_shared<Array>(format, shapeOfLevel(images.shape, level));
        for (size_t i = 0; i < array->bytes(); ++i)
            array->data()[i] = uint8_t(random());
        if (format.channel == Channel::kF32 && !special)
            for (size_t i = 0; i < array->bytes() / 4; ++i)
                reinterpret_cast<float*>(array->data())[i] = float(int32_t(random())) * 0x1p-20f;
        if (format.channel == Channel::kF16 && !special)
            for (size_t i = 0; i < array->bytes() / 2; ++i)
                reinterpret_cast<uint16_t*>(array->data())[i] &= 0xBFFF;
        texture->images[level] = array->image();
        texture->arrays.push_back(array);
    }
    const Shape& shape = images.shape;
    texture->layered = shape.layered;
    texture->cube = shape.cube;
    texture->is3D = shape.depth && !shape.layered && !shape.cube;
    for (float& border : texture->border)
        border = float(random() % 64) / 48 - 0.25f;
    return texture;
}

class Positions {
public:
    Positions(std::mt19937& random, bool normalized) : random_(random), normalized_(normalized) {}
    float next() {
        const uint32_t kind = random_() % 16;
        if (kind == 0)
            return kSpecial[random_() % std::size(kSpecial)];
        const float wide = std::uniform_real_distribution<float>(-2.5f, 3.5f)(random_);
        if (kind < 4) // texel edges, middles and their neighbours
            return std::nextafter(std::round(wide * 32) / (normalized_ ? 32 : 2),
                                  kind == 1   ? INFINITY
                                  : kind == 2 ? -INFINITY
                                              : 0.0f);
        return wide * (normalized_ ? 1 : 9);
    }

private:
    std::mt19937& random_;
    bool normalized_;
};

// All NaN are equal.
bool sameWords(const uint32_t a[4], const uint32_t b[4]) {
    for (unsigned k = 0; k < 4; ++k)
        if (a[k] != b[k] &&
            !(std::isnan(std::bit_cast<float>(a[k])) && std::isnan(std::bit_cast<float>(b[k]))))
            return false;
    return true;
}

void compare(uint64_t handle, unsigned count, bool normalized, std::mt19937& random,
             const std::string& what) {
    constexpr uint32_t kForms[] = {k1D,
                                   k2D,
                                   k3D,
                                   k1DArray,
                                   k2DArray,
                                   kCube,
                                   kCubeArray,
                                   k2D | kWithLevel,
                                   k3D | kWithLevel,
                                   k2DArray | kWithGradient,
                                   k2D | kWithGradient,
                                   kCube | kWithLevel,
                                   k2D | kIntegerCoordinates,
                                   k2D | kGather | 1 << kGatherShift};
    Positions positions(random, normalized);
    for (unsigned n = 0; n < count; ++n) {
        SampleOperands operands{};
        for (uint32_t& position : operands.position)
            position = std::bit_cast<uint32_t>(positions.next());
        operands.layer = random() % 5;
        operands.level = std::uniform_real_distribution<float>(-1, 4)(random);
        for (unsigned k = 0; k < 3; ++k) {
            operands.dx[k] = positions.next() * 0.2f;
            operands.dy[k] = positions.next() * 0.2f;
        }
        const uint32_t form = kForms[random() % std::size(kForms)];
        uint32_t got[4], want[4];
        sample(handle, form, &operands, got);
        sampleSlowly(*findTexture(handle), form, operands, false, want);
        ASSERT_TRUE(sameWords(got, want))
            << what << " form " << form << " at " << std::bit_cast<float>(operands.position[0])
            << ", " << std::bit_cast<float>(operands.position[1]) << ", "
            << std::bit_cast<float>(operands.position[2]) << ": " << std::hex << got[0] << " "
            << got[1] << " " << got[2] << " " << got[3] << " in place of " << want[0] << " "
            << want[1] << " " << want[2] << " " << want[3];
    }
}

// Compares all settings of a texture of one format, in random order.
void compareFormat(const Images& images, Format format, std::mt19937& random) {
    for (unsigned bits = 0; bits < 128; ++bits) {
        auto texture = randomTexture(images, format, bits & 64, random);
        texture->linear = bits & 1;
        texture->normalizedCoordinates = bits & 2;
        texture->asFloat = bits & 4;
        texture->srgb = bits & 8;
        texture->linearLevels = bits & 16;
        texture->seamless = bits & 32;
        texture->maxLevel = float(images.levels);
        texture->anisotropy = random() % 2 ? 1 : 4;
        for (Address& address : texture->address)
            address = Address(random() % 4);
        const bool normalized = texture->normalizedCoordinates;
        const std::string what = std::string(images.name) + ", channel " +
                                 std::to_string(int(format.channel)) + " x " +
                                 std::to_string(format.channels) + ", bits " + std::to_string(bits);
        const uint64_t handle = add(std::move(texture));
        ASSERT_NO_FATAL_FAILURE(compare(handle, 20, normalized, random, what));
        EXPECT_TRUE(removeTexture(handle));
    }
}

TEST(Quick, EveryFormatAndShapeAgainstTheGenericCode) {
    const unsigned seed = 20261126;
    std::mt19937 random(seed);
    for (const Images& images : kImages)
        for (const Channel channel : kChannels)
            for (const uint8_t channels : {uint8_t(1), uint8_t(2), uint8_t(4)})
                for (const bool normalized : {false, true}) {
                    const Format format{channel, channels, normalized, random() % 4 == 0};
                    ASSERT_NO_FATAL_FAILURE(compareFormat(images, format, random))
                        << "seed " << seed;
                }
}

// Every value of a channel, at the centre of its texel.
TEST(Quick, EveryValueOfAChannel) {
    for (const Channel channel :
         {Channel::kU8, Channel::kS8, Channel::kU16, Channel::kS16, Channel::kF16})
        for (const unsigned bits : {0u, 1u, 2u, 3u}) {
            const Format format{channel, 1};
            const uint32_t count = format.channelBytes() == 1 ? 256 : 65536;
            const auto array = std::make_shared<Array>(format, Shape{count});
            for (uint32_t i = 0; i < count; ++i)
                std::memcpy(array->data() + i * format.channelBytes(), &i, format.channelBytes());
            auto texture = std::make_unique<Texture>();
            texture->format = format;
            texture->images[0] = array->image();
            texture->arrays = {array};
            texture->asFloat = true;
            texture->linear = bits & 1;
            texture->srgb = bits & 2;
            texture->address[0] = Address::kClamp;
            const uint64_t handle = add(std::move(texture));
            for (uint32_t i = 0; i < count; ++i) {
                SampleOperands operands{};
                operands.position[0] = std::bit_cast<uint32_t>(float(i) + 0.5f);
                uint32_t got[4], want[4];
                sample(handle, k1D, &operands, got);
                sampleSlowly(*findTexture(handle), k1D, operands, false, want);
                ASSERT_TRUE(sameWords(got, want)) << int(channel) << " " << i;
                ASSERT_TRUE(bits & 1 || got[0] == want[0]) << int(channel) << " " << i;
            }
            removeTexture(handle);
        }
}

TEST(Quick, LargeImagesAndFarPositions) {
    std::mt19937 random(7);
    for (const Shape shape : {Shape{1, 1}, Shape{131072}, Shape{65536, 3}, Shape{1023, 1025}})
        for (unsigned bits = 0; bits < 32; ++bits) {
            auto texture = randomTexture({"", shape, 1}, {Channel::kU8, 1}, false, random);
            texture->asFloat = true;
            texture->linear = bits & 1;
            texture->normalizedCoordinates = bits & 2;
            texture->address[0] = texture->address[1] = Address(bits >> 2 & 3);
            const float scale = bits & 16 ? 3000 : bits & 2 ? 1 : 65536;
            const uint64_t handle = add(std::move(texture));
            for (unsigned n = 0; n < 8000; ++n) {
                SampleOperands operands{};
                for (unsigned k = 0; k < 2; ++k)
                    operands.position[k] = std::bit_cast<uint32_t>(
                        std::uniform_real_distribution<float>(-scale, 2 * scale)(random));
                uint32_t got[4], want[4];
                sample(handle, k2D, &operands, got);
                sampleSlowly(*findTexture(handle), k2D, operands, false, want);
                ASSERT_TRUE(sameWords(got, want)) << shape.width << " bits " << bits;
            }
            removeTexture(handle);
        }
}

TEST(Quick, FormatsThatHaveAFunction) {
    for (const Channel channel : kChannels)
        for (const uint8_t channels : {uint8_t(1), uint8_t(2), uint8_t(4)})
            EXPECT_NE(quickFunctions({channel, channels}, false, false, false).call, nullptr);
    EXPECT_EQ(quickFunctions({Channel::kBC7, 4}, true, true, false).call, nullptr);
}

} // namespace
} // namespace sunstone::texture
