// SPDX-License-Identifier: Apache-2.0
// Contents of textures and coordinates of reads, equal on every machine. See texture_cases.h.
#include "inputs.h"
#include "textures/texture_cases.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace conformance {

namespace {

// Random numbers of one vector.
class Random {
public:
    explicit Random(uint64_t seed) : state_(scramble(seed)) {}
    uint64_t bits() { return state_ = scramble(state_); }
    double unit() { return double(bits() >> 11) * 0x1p-53; }
    double between(double low, double high) { return low + (high - low) * unit(); }
    int whole(int low, int high) { return low + int(bits() >> 33) % (high - low + 1); }

private:
    uint64_t state_;
};

constexpr float kSpecial[] = {0.0f,   -0.0f,  1e6f,    -1e6f,   INFINITY, -INFINITY,
                              1e-40f, -1e-3f, 4096.5f, -77.25f, 0.5f,     3e38f};

// A coordinate in texels.
double coordinate(Random& random, unsigned kind, unsigned size) {
    switch (kind) {
    case 3:
        return random.whole(0, int(size) - 1) + 0.5;
    case 4:
        return random.whole(0, int(size));
    case 5:
        return random.whole(-1, int(size) + 1) + (random.bits() & 1 ? 1.0 : -1.0) / 512;
    case 6:
        return random.between(-3.0 * size, 4.0 * size);
    default:
        return random.between(-0.25 * size, 1.25 * size);
    }
}

uint32_t word(float value) {
    return std::bit_cast<uint32_t>(value);
}

// A direction: anywhere, along axes, and where two faces meet.
void direction(Random& random, unsigned index, TextureVector& vector) {
    for (unsigned axis = 0; axis < 3; ++axis) {
        auto value = float(random.between(-1, 1));
        if (index % 8 == 7)
            value = float(random.whole(-1, 1));
        if (index % 8 == 6)
            value = float(random.whole(-16, 16)) / 16;
        vector[axis] = word(value);
    }
    if (index % 8 == 5) // close to an edge
        vector[1] = word(std::bit_cast<float>(vector[0]) * float(random.between(0.9, 1.1)));
}

void surfacePlace(const TextureCase& test, unsigned index, TextureVector& vector) {
    Random random(index * 77 + 5);
    const unsigned sizes[3] = {test.width, test.height ? test.height : 1,
                               test.depth ? test.depth : 1};
    if (test.access.starts_with("suld")) {
        for (unsigned axis = 0; axis < 3; ++axis)
            vector[axis] = uint32_t(random.whole(-3, int(sizes[axis]) + 2));
    } else { // no two vectors at one texel
        vector[0] = index % (test.width + 4) - 2;
        vector[1] = index / (test.width + 4) - 1;
        if (!test.height && vector[1] != 0) // rows of one-dimensional surfaces are outside
            vector[0] = 0u - 1 - index;
    }
    if (test.has(".b.")) // counts bytes
        vector[0] *= test.format.bytes;
    vector[3] = uint32_t(random.whole(0, int(sizes[2]) - 1));
    for (unsigned k = 4; k < 8; ++k) // the stored value
        vector[k] = test.has("sust.p") && (test.format.kind == 'f' || test.format.kind == 'h')
                        ? word(float(random.between(-100, 100)))
                        : uint32_t(random.bits() >> (index & 3) * 8);
}

} // namespace

TextureVector textureVector(const TextureCase& test, unsigned index) {
    TextureVector vector = {};
    if (test.isSurface()) {
        surfacePlace(test, index, vector);
        return vector;
    }
    Random random(index * 131 + 17);
    const unsigned sizes[3] = {test.width, test.height ? test.height : 1,
                               test.depth ? test.depth : 1};
    const bool normalized = test.sampling.flags & CU_TRSF_NORMALIZED_COORDINATES;
    if (test.has("cube")) {
        direction(random, index, vector);
    } else if (test.access.ends_with(".s32")) {
        for (unsigned axis = 0; axis < 3; ++axis)
            vector[axis] = uint32_t(random.whole(-2, int(sizes[axis]) + 1));
    } else {
        for (unsigned axis = 0; axis < 3; ++axis) {
            double value = coordinate(random, index % 8, sizes[axis]);
            if (normalized)
                value /= sizes[axis];
            auto single = float(value);
            if (index % 8 == 7 && random.bits() & 1)
                single = kSpecial[random.bits() % std::size(kSpecial)];
            vector[axis] = word(single);
        }
    }
    const int layers = test.has("acube") ? int(test.depth / 6) : int(sizes[2]);
    vector[3] = uint32_t(random.whole(0, layers + 1));
    const float level =
        index % 3 == 0 ? float(random.whole(-1, 5)) / 2 : float(random.between(-0.5, 4));
    vector[4] = word(level);
    for (unsigned k = 5; k < 11; ++k) {
        const double size = std::exp2(random.between(-7, 0.5));
        vector[k] = word(float(random.bits() & 1 ? size : -size));
    }
    return vector;
}

std::vector<uint8_t> textureContent(const TextureCase& test, unsigned level) {
    const auto smaller = [&](unsigned size, bool scales) {
        return !size ? 1 : scales ? std::max(1u, size >> level) : size;
    };
    const bool volume = !(test.arrayFlags & (CUDA_ARRAY3D_LAYERED | CUDA_ARRAY3D_CUBEMAP));
    size_t width = smaller(test.width, true), height = smaller(test.height, true);
    const size_t depth = smaller(test.depth, volume);
    if (test.format.kind == 'b') {
        width = (width + 3) / 4;
        height = (height + 3) / 4;
    }
    std::vector<uint8_t> bytes(width * height * depth * test.format.bytes);
    Random random(level * 1000 + test.format.value);
    if (test.format.kind == 'f' || test.format.kind == 'h') {
        const bool half = test.format.kind == 'h';
        for (size_t i = 0; i < bytes.size(); i += half ? 2 : 4) {
            const auto value = float(random.whole(-1024, 1024)) / 256; // fits a half
            uint32_t bits = word(value);
            if (half) {
                const uint32_t sign = bits >> 16 & 0x8000;
                const uint32_t magnitude = bits & 0x7fffffff;
                bits = magnitude ? sign | ((magnitude - 0x38000000) >> 13) : 0;
            }
            std::memcpy(&bytes[i], &bits, half ? 2 : 4);
        }
        return bytes;
    }
    for (uint8_t& byte : bytes)
        byte = uint8_t(random.bits() >> 40);
    if (test.format.value >= 0x9d) // BC7: each mode as often as the others
        for (size_t i = 0; i < bytes.size(); i += 16)
            bytes[i] = uint8_t((bytes[i] | 1) << (i / 16 % 8));
    return bytes;
}

} // namespace conformance
