// SPDX-License-Identifier: Apache-2.0
// Block-compressed texels; here BC1 to BC5, in bptc.cpp the others. A block holds two end points per
// colour or channel and, for each of its 16 texels, an index of a point between them. Source: the
// Khronos Data Format Specification, chapters "S3TC" and "RGTC".
#include "texture/bptc.h"
#include "texture/fetch.h"

#include <cstring>

namespace sunstone::texture {

namespace {

template <class T>
T load(const uint8_t* address) {
    T value;
    std::memcpy(&value, address, sizeof value);
    return value;
}

void expand565(uint16_t packed, float color[3]) {
    color[0] = float(packed >> 11) / 31.0f;
    color[1] = float(packed >> 5 & 63) / 63.0f;
    color[2] = float(packed & 31) / 31.0f;
}

// The colour half of BC1, BC2 and BC3. Only BC1 has the mode with a transparent black.
void decodeColor(const uint8_t* block, unsigned texel, bool hasBlack, float color[4]) {
    const uint16_t first = load<uint16_t>(block), second = load<uint16_t>(block + 2);
    const unsigned index = load<uint32_t>(block + 4) >> (2 * texel) & 3;
    float a[3], b[3];
    expand565(first, a);
    expand565(second, b);
    color[3] = 1;
    const bool three = hasBlack && first <= second;
    if (three && index == 3) {
        color[0] = color[1] = color[2] = color[3] = 0;
        return;
    }
    const float weight = index == 0   ? 0.0f
                         : index == 1 ? 1.0f
                         : three      ? 0.5f
                         : index == 2 ? 1.0f / 3.0f
                                      : 2.0f / 3.0f;
    for (unsigned i = 0; i < 3; ++i)
        color[i] = a[i] * (1 - weight) + b[i] * weight;
}

// A channel of eight bytes: two ends and 16 indices of three bits.
float decodeChannel(const uint8_t* block, unsigned texel, bool isSigned) {
    uint64_t all = load<uint64_t>(block);
    const unsigned index = unsigned(all >> (16 + 3 * texel) & 7);
    float ends[2];
    bool eight = false;
    float low = 0;
    if (isSigned) {
        const auto first = int8_t(block[0]), second = int8_t(block[1]);
        eight = first > second;
        ends[0] = first <= -127 ? -1.0f : float(first) / 127.0f;
        ends[1] = second <= -127 ? -1.0f : float(second) / 127.0f;
        low = -1;
    } else {
        eight = block[0] > block[1];
        ends[0] = float(block[0]) / 255.0f;
        ends[1] = float(block[1]) / 255.0f;
    }
    if (index < 2)
        return ends[index];
    if (eight)
        return (ends[0] * float(8 - index) + ends[1] * float(index - 1)) / 7.0f;
    if (index == 6)
        return low;
    if (index == 7)
        return 1;
    return (ends[0] * float(6 - index) + ends[1] * float(index - 1)) / 5.0f;
}

} // namespace

void decodeBlock(Channel channel, const uint8_t* block, unsigned x, unsigned y, float color[4]) {
    const unsigned texel = y * 4 + x;
    color[0] = color[1] = color[2] = 0;
    color[3] = 0;
    switch (channel) {
    case Channel::kBC1:
        return decodeColor(block, texel, true, color);
    case Channel::kBC2:
        decodeColor(block + 8, texel, false, color);
        color[3] = float(block[texel / 2] >> (texel % 2 * 4) & 15) / 15.0f;
        return;
    case Channel::kBC3:
        decodeColor(block + 8, texel, false, color);
        color[3] = decodeChannel(block, texel, false);
        return;
    case Channel::kBC5U:
    case Channel::kBC5S:
        color[1] = decodeChannel(block + 8, texel, channel == Channel::kBC5S);
        [[fallthrough]];
    case Channel::kBC4U:
    case Channel::kBC4S:
        color[0] =
            decodeChannel(block, texel, channel == Channel::kBC4S || channel == Channel::kBC5S);
        return;
    case Channel::kBC6U:
    case Channel::kBC6S:
        return decodeBc6(block, texel, channel == Channel::kBC6S, color);
    case Channel::kBC7:
        return decodeBc7(block, texel, color);
    default:
        return; // no block format
    }
}

} // namespace sunstone::texture
