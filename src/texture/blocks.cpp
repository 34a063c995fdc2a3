// SPDX-License-Identifier: Apache-2.0
// Block-compressed texels: BC1 to BC5 here, the others in bptc.cpp. A block holds two end points
// per colour or channel and, for each of its 16 texels, the index of a point between them. Source:
// the Khronos Data Format Specification, chapters "S3TC" and "RGTC".
#include "texture/bptc.h"
#include "texture/fetch.h"

#include <algorithm>
#include <cstring>

namespace sunstone::texture {

namespace {

template <class T>
T load(const uint8_t* address) {
    T value;
    std::memcpy(&value, address, sizeof value);
    return value;
}

// The points between two end points as GPUs compute them, taken from a recording: red and blue are
// interpolated from five bits, green after its expansion to eight. All results have eight bits.
unsigned between5(unsigned a, unsigned b, bool middle) {
    return middle ? (a + b) * 33 / 8 : (2 * a + b) * 22 / 8;
}
unsigned between6(unsigned a, unsigned b, bool middle) {
    const int first = int(a << 2 | a >> 4), second = int(b << 2 | b >> 4);
    const int step = second - first;
    return unsigned((256 * first + step / 4 + 128 + step * (middle ? 128 : 80)) / 256);
}

// The colour half of BC1, BC2 and BC3. Only BC1 has the mode with a transparent black.
void decodeColor(const uint8_t* block, unsigned texel, bool hasBlack, float color[4]) {
    const uint16_t first = load<uint16_t>(block), second = load<uint16_t>(block + 2);
    const unsigned index = load<uint32_t>(block + 4) >> (2 * texel) & 3;
    color[3] = 1;
    const bool three = hasBlack && first <= second;
    if (three && index == 3) {
        color[0] = color[1] = color[2] = color[3] = 0;
        return;
    }
    // Each point lies closer to one end, or in the middle.
    const bool middle = three && index == 2;
    const uint16_t near = index == 0 || index == 2 ? first : second;
    const uint16_t far = near == first ? second : first;
    const auto channel = [&](unsigned shift) {
        const unsigned a = near >> shift & 31, b = far >> shift & 31;
        return index < 2 ? a << 3 | a >> 2 : between5(a, b, middle);
    };
    const unsigned a = near >> 5 & 63, b = far >> 5 & 63;
    const unsigned green = index < 2 ? a << 2 | a >> 4 : between6(a, b, middle);
    color[0] = float(channel(11)) / 255.0f;
    color[1] = float(green) / 255.0f;
    color[2] = float(channel(0)) / 255.0f;
}

// A channel of eight bytes: two ends and 16 indices of three bits.
unsigned indexOf(const uint8_t* block, unsigned texel) {
    return unsigned(load<uint64_t>(block) >> (16 + 3 * texel) & 7);
}

// Weights of the second end point by index, for eight points and for six, in units of 1/`whole`.
// GPUs use different fractions for each kind of block; these are taken from a recording.
struct Ramp {
    int whole;
    uint16_t eight[8], six[6];
};
constexpr Ramp kUnsigned = {257, {0, 257, 36, 72, 113, 144, 185, 221}, {0, 257, 48, 96, 161, 209}};
constexpr Ramp kSigned = {129, {0, 129, 18, 36, 57, 72, 93, 111}, {0, 129, 24, 48, 81, 105}};
constexpr Ramp kAlpha = {
    2048, {0, 2048, 289, 578, 892, 1156, 1470, 1759}, {0, 2048, 385, 770, 1278, 1663}};

float decodeChannel(const uint8_t* block, unsigned texel, bool isSigned) {
    const unsigned index = indexOf(block, texel);
    const int most = isSigned ? 127 : 255;
    const int ends[2] = {isSigned ? int8_t(block[0]) : block[0],
                         isSigned ? int8_t(block[1]) : block[1]};
    const bool eight = ends[0] > ends[1];
    if (!eight && index >= 6)
        return index == 7 ? 1.0f : isSigned ? -1.0f : 0.0f;
    const Ramp& ramp = isSigned ? kSigned : kUnsigned;
    const int weight = eight ? ramp.eight[index] : ramp.six[index];
    const int first = std::max(ends[0], -most), second = std::max(ends[1], -most);
    return float(double(first * (ramp.whole - weight) + second * weight) /
                 double(most * ramp.whole));
}

// The alpha of BC3: like an unsigned channel, but rounded to eight bits.
float decodeAlpha(const uint8_t* block, unsigned texel) {
    const unsigned index = indexOf(block, texel);
    const int first = block[0], second = block[1];
    if (index < 2)
        return float(block[index]) / 255.0f;
    const bool eight = first > second;
    if (!eight && index >= 6)
        return index == 7 ? 1.0f : 0.0f;
    const int weight = eight ? kAlpha.eight[index] : kAlpha.six[index];
    const int half = kAlpha.whole / 2;
    return float((first * kAlpha.whole + (second - first) * weight + half) / kAlpha.whole) / 255.0f;
}

} // namespace

void decodeBlock(Channel channel, const uint8_t* block, unsigned x, unsigned y, float color[4]) {
    const unsigned texel = y * 4 + x;
    color[0] = color[1] = color[2] = 0;
    color[3] = 1;
    switch (channel) {
    case Channel::kBC1:
        return decodeColor(block, texel, true, color);
    case Channel::kBC2:
        decodeColor(block + 8, texel, false, color);
        color[3] = float(block[texel / 2] >> (texel % 2 * 4) & 15) / 15.0f;
        return;
    case Channel::kBC3:
        decodeColor(block + 8, texel, false, color);
        color[3] = decodeAlpha(block, texel);
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
        return; // not a block format
    }
}

} // namespace sunstone::texture
