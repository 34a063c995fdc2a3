// SPDX-License-Identifier: Apache-2.0
// See bptc.h. A block names a mode in its first bits. Then it has a partition of its 16 texels into
// subsets, end points for each subset, and for each texel the index of a point between these. The
// first texel of a subset, its anchor, has one index bit less: its highest is 0. Source: the
// Khronos Data Format Specification, chapter "BPTC Compressed Texture Image Formats".
#include "texture/bptc.h"

#include "texture/fetch.h"

#include <cstring>
#include <string_view>
#include <utility>

namespace sunstone::texture {

namespace {

// Bit t: the subset of texel t of two.
constexpr uint16_t kTwo[64] = {
    0xCCCC, 0x8888, 0xEEEE, 0xECC8, 0xC880, 0xFEEC, 0xFEC8, 0xEC80, 0xC800, 0xFFEC, 0xFE80,
    0xE800, 0xFFE8, 0xFF00, 0xFFF0, 0xF000, 0xF710, 0x008E, 0x7100, 0x08CE, 0x008C, 0x7310,
    0x3100, 0x8CCE, 0x088C, 0x3110, 0x6666, 0x366C, 0x17E8, 0x0FF0, 0x718E, 0x399C, 0xAAAA,
    0xF0F0, 0x5A5A, 0x33CC, 0x3C3C, 0x55AA, 0x9696, 0xA55A, 0x73CE, 0x13C8, 0x324C, 0x3BDC,
    0x6996, 0xC33C, 0x9966, 0x0660, 0x0272, 0x04E4, 0x4E40, 0x2720, 0xC936, 0x936C, 0x39C6,
    0x639C, 0x9336, 0x9CC6, 0x817E, 0xE718, 0xCCF0, 0x0FCC, 0x7744, 0xEE22};
// Two bits per texel: its subset of three.
constexpr uint32_t kThree[64] = {
    0xAA685050, 0x6A5A5040, 0x5A5A4200, 0x5450A0A8, 0xA5A50000, 0xA0A05050, 0x5555A0A0, 0x5A5A5050,
    0xAA550000, 0xAA555500, 0xAAAA5500, 0x90909090, 0x94949494, 0xA4A4A4A4, 0xA9A59450, 0x2A0A4250,
    0xA5945040, 0x0A425054, 0xA5A5A500, 0x55A0A0A0, 0xA8A85454, 0x6A6A4040, 0xA4A45000, 0x1A1A0500,
    0x0050A4A4, 0xAAA59090, 0x14696914, 0x69691400, 0xA08585A0, 0xAA821414, 0x50A4A450, 0x6A5A0200,
    0xA9A58000, 0x5090A0A8, 0xA8A09050, 0x24242424, 0x00AA5500, 0x24924924, 0x24499224, 0x50A50A50,
    0x500AA550, 0xAAAA4444, 0x66660000, 0xA5A0A5A0, 0x50A050A0, 0x69286928, 0x44AAAA44, 0x66666600,
    0xAA444444, 0x54A854A8, 0x95809580, 0x96969600, 0xA85454A8, 0x80959580, 0xAA141414, 0x96960000,
    0xAAAA1414, 0xA05050A0, 0xA0A5A5A0, 0x96000000, 0x40804080, 0xA9A8A9A8, 0xAAAAAA44, 0x2A4A5254};
// Anchors of the second subset of two, and of the second and third of three.
constexpr uint8_t kAnchorOfTwo[64] = {
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2,  8, 2, 2, 8,
    8,  15, 2,  8,  2,  2,  8,  8,  2,  2,  15, 15, 6,  8,  2,  8,  15, 15, 2, 8, 2, 2,
    2,  15, 15, 6,  6,  2,  6,  8,  15, 15, 2,  2,  15, 15, 15, 15, 15, 2,  2, 15};
constexpr uint8_t kSecondOfThree[64] = {
    3,  3,  15, 15, 8, 3,  15, 15, 8,  8,  6, 6,  6, 5,  3, 3,  3,  3,  8,  15, 3,  3,
    6,  10, 5,  8,  8, 6,  8,  5,  15, 15, 8, 15, 3, 5,  6, 10, 8,  15, 15, 3,  15, 5,
    15, 15, 15, 15, 3, 15, 5,  5,  5,  8,  5, 10, 5, 10, 8, 13, 15, 12, 3,  3};
constexpr uint8_t kThirdOfThree[64] = {
    15, 8, 8, 3,  15, 15, 3,  8,  15, 15, 15, 15, 15, 15, 15, 8,  15, 8,  15, 3,  15, 8,
    15, 8, 3, 15, 6,  10, 15, 15, 10, 8,  15, 3,  15, 10, 10, 8,  9,  10, 6,  15, 8,  15,
    3,  6, 6, 8,  15, 3,  15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 3,  15, 15, 8};

// Weights of the points between two ends, in 1/64, by bits of the index.
unsigned weightOf(unsigned index, unsigned bits) {
    static constexpr uint8_t kWeights2[4] = {0, 21, 43, 64};
    static constexpr uint8_t kWeights3[8] = {0, 9, 18, 27, 37, 46, 55, 64};
    static constexpr uint8_t kWeights4[16] = {0,  4,  9,  13, 17, 21, 26, 30,
                                              34, 38, 43, 47, 51, 55, 60, 64};
    return bits == 2 ? kWeights2[index] : bits == 3 ? kWeights3[index] : kWeights4[index];
}

// The bits of a block, from the lowest on.
class Bits {
public:
    explicit Bits(const uint8_t* block) { std::memcpy(words_, block, 16); }
    unsigned take(unsigned count) {
        unsigned value = 0;
        for (unsigned i = 0; i < count; ++i, ++at_)
            value |= unsigned(words_[at_ >> 6] >> (at_ & 63) & 1) << i;
        return value;
    }
    void skip(unsigned count) { at_ += count; }

private:
    uint64_t words_[2];
    unsigned at_ = 0;
};

unsigned subsetOf(unsigned subsets, unsigned partition, unsigned texel) {
    if (subsets == 2)
        return kTwo[partition] >> texel & 1;
    return subsets == 3 ? kThree[partition] >> (2 * texel) & 3 : 0;
}

bool isAnchor(unsigned subsets, unsigned partition, unsigned texel) {
    return texel == 0 || (subsets == 2 && texel == kAnchorOfTwo[partition]) ||
           (subsets == 3 &&
            (texel == kSecondOfThree[partition] || texel == kThirdOfThree[partition]));
}

// The index of one texel; `bits` is positioned at the first index.
unsigned indexOf(Bits bits, unsigned subsets, unsigned partition, unsigned texel, unsigned width) {
    for (unsigned i = 0; i < texel; ++i)
        bits.skip(width - isAnchor(subsets, partition, i));
    return bits.take(width - isAnchor(subsets, partition, texel));
}

// ---- BC7 ---------------------------------------------------------------------------------------
struct Mode7 {
    uint8_t subsets, partitionBits, rotationBits, selectionBits, colorBits, alphaBits;
    uint8_t ownParity, sharedParity; // lowest bits: one per end point, or one per subset
    uint8_t indexBits, secondBits;
};
constexpr Mode7 kModes7[8] = {{3, 4, 0, 0, 4, 0, 1, 0, 3, 0}, {2, 6, 0, 0, 6, 0, 0, 1, 3, 0},
                              {3, 6, 0, 0, 5, 0, 0, 0, 2, 0}, {2, 6, 0, 0, 7, 0, 1, 0, 2, 0},
                              {1, 0, 2, 1, 5, 6, 0, 0, 2, 3}, {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
                              {1, 0, 0, 0, 7, 7, 1, 0, 4, 0}, {2, 6, 0, 0, 5, 5, 1, 0, 2, 0}};

unsigned widen(unsigned value, unsigned bits) {
    value <<= 8 - bits;
    return value | value >> bits;
}

unsigned between(unsigned a, unsigned b, unsigned weight) {
    return (a * (64 - weight) + b * weight + 32) >> 6;
}

// ---- BC6H --------------------------------------------------------------------------------------
// The positions of the end points' bits, after the mode's bits: a letter r g b for the channel, a
// letter w x y z for the end point, and its bits, "4-0" from the lowest stored to the highest
// ("10-15": stored from bit 15 down).
struct Mode6 {
    uint8_t number, modeBits;
    bool transformed; // x y z are differences from w
    uint8_t subsets, baseBits, redBits, greenBits, blueBits;
    std::string_view layout;
};
constexpr Mode6 kModes6[14] = {
    {0x00, 2, true, 2, 10, 5, 5, 5,
     "gy4 by4 bz4 rw9-0 gw9-0 bw9-0 rx4-0 gz4 gy3-0 gx4-0 bz0 gz3-0 bx4-0 bz1 by3-0 ry4-0 bz2 "
     "rz4-0 bz3"},
    {0x01, 2, true, 2, 7, 6, 6, 6,
     "gy5 gz4 gz5 rw6-0 bz0 bz1 by4 gw6-0 by5 bz2 gy4 bw6-0 bz3 bz5 bz4 rx5-0 gy3-0 gx5-0 gz3-0 "
     "bx5-0 by3-0 ry5-0 rz5-0"},
    {0x02, 5, true, 2, 11, 5, 4, 4,
     "rw9-0 gw9-0 bw9-0 rx4-0 rw10 gy3-0 gx3-0 gw10 bz0 gz3-0 bx3-0 bw10 bz1 by3-0 ry4-0 bz2 rz4-0 "
     "bz3"},
    {0x06, 5, true, 2, 11, 4, 5, 4,
     "rw9-0 gw9-0 bw9-0 rx3-0 rw10 gz4 gy3-0 gx4-0 gw10 gz3-0 bx3-0 bw10 bz1 by3-0 ry3-0 bz0 bz2 "
     "rz3-0 gy4 bz3"},
    {0x0a, 5, true, 2, 11, 4, 4, 5,
     "rw9-0 gw9-0 bw9-0 rx3-0 rw10 by4 gy3-0 gx3-0 gw10 bz0 gz3-0 bx4-0 bw10 by3-0 ry3-0 bz1 bz2 "
     "rz3-0 bz4 bz3"},
    {0x0e, 5, true, 2, 9, 5, 5, 5,
     "rw8-0 by4 gw8-0 gy4 bw8-0 bz4 rx4-0 gz4 gy3-0 gx4-0 bz0 gz3-0 bx4-0 bz1 by3-0 ry4-0 bz2 "
     "rz4-0 bz3"},
    {0x12, 5, true, 2, 8, 6, 5, 5,
     "rw7-0 gz4 by4 gw7-0 bz2 gy4 bw7-0 bz3 bz4 rx5-0 gy3-0 gx4-0 bz0 gz3-0 bx4-0 bz1 by3-0 ry5-0 "
     "rz5-0"},
    {0x16, 5, true, 2, 8, 5, 6, 5,
     "rw7-0 bz0 by4 gw7-0 gy5 gy4 bw7-0 gz5 bz4 rx4-0 gz4 gy3-0 gx5-0 gz3-0 bx4-0 bz1 by3-0 ry4-0 "
     "bz2 rz4-0 bz3"},
    {0x1a, 5, true, 2, 8, 5, 5, 6,
     "rw7-0 bz1 by4 gw7-0 by5 gy4 bw7-0 bz5 bz4 rx4-0 gz4 gy3-0 gx4-0 bz0 gz3-0 bx5-0 by3-0 ry4-0 "
     "bz2 rz4-0 bz3"},
    {0x1e, 5, false, 2, 6, 6, 6, 6,
     "rw5-0 gz4 bz0 bz1 by4 gw5-0 gy5 by5 bz2 gy4 bw5-0 gz5 bz3 bz5 bz4 rx5-0 gy3-0 gx5-0 gz3-0 "
     "bx5-0 by3-0 ry5-0 rz5-0"},
    {0x03, 5, false, 1, 10, 10, 10, 10, "rw9-0 gw9-0 bw9-0 rx9-0 gx9-0 bx9-0"},
    {0x07, 5, true, 1, 11, 9, 9, 9, "rw9-0 gw9-0 bw9-0 rx8-0 rw10 gx8-0 gw10 bx8-0 bw10"},
    {0x0b, 5, true, 1, 12, 8, 8, 8, "rw9-0 gw9-0 bw9-0 rx7-0 rw10-11 gx7-0 gw10-11 bx7-0 bw10-11"},
    {0x0f, 5, true, 1, 16, 4, 4, 4, "rw9-0 gw9-0 bw9-0 rx3-0 rw10-15 gx3-0 gw10-15 bx3-0 bw10-15"},
};

struct Ends6 {
    int values[4][3] = {}; // w x y z, by channel
};

unsigned numberAt(std::string_view text, size_t& at) {
    unsigned number = 0;
    while (at < text.size() && text[at] >= '0' && text[at] <= '9')
        number = number * 10 + unsigned(text[at++] - '0');
    return number;
}

Ends6 readEnds(const Mode6& mode, Bits& bits) {
    Ends6 ends;
    const std::string_view layout = mode.layout;
    for (size_t at = 0; at < layout.size(); ++at) {
        const unsigned channel = layout[at] == 'r' ? 0 : layout[at] == 'g' ? 1 : 2;
        int& value = ends.values[unsigned(layout[at + 1] - 'w')][channel];
        at += 2;
        const unsigned first = numberAt(layout, at);
        unsigned last = first;
        if (at < layout.size() && layout[at] == '-')
            last = numberAt(layout, ++at);
        if (first >= last) { // stored from the lowest bit
            value |= int(bits.take(first - last + 1) << last);
            continue;
        }
        for (unsigned bit = last + 1; bit-- > first;)
            value |= int(bits.take(1) << bit);
    }
    return ends;
}

int extendSign(int value, unsigned bits) {
    const int sign = 1 << (bits - 1);
    return ((value & ((1 << bits) - 1)) ^ sign) - sign;
}

// Expands to 16 bits.
int unquantize(int value, unsigned bits, bool isSigned) {
    if (!isSigned) {
        if (bits >= 15 || value == 0)
            return value;
        return value == (1 << bits) - 1 ? 0xffff : ((value << 16) + 0x8000) >> bits;
    }
    if (bits >= 16)
        return value;
    const bool negative = value < 0;
    const int magnitude = negative ? -value : value;
    int result = 0;
    if (magnitude >= (1 << (bits - 1)) - 1)
        result = 0x7fff;
    else if (magnitude != 0)
        result = ((magnitude << 15) + 0x4000) >> (bits - 1);
    return negative ? -result : result;
}

// Scales to the bits of a half, which is finite.
uint16_t finish(int value, bool isSigned) {
    if (!isSigned)
        return uint16_t(value * 31 >> 6);
    return value < 0 ? uint16_t(0x8000 | (-value * 31 >> 5)) : uint16_t(value * 31 >> 5);
}

void completeEnds(const Mode6& mode, bool isSigned, Ends6& ends) {
    const unsigned deltaBits[3] = {mode.redBits, mode.greenBits, mode.blueBits};
    for (unsigned channel = 0; channel < 3; ++channel) {
        int& base = ends.values[0][channel];
        if (isSigned)
            base = extendSign(base, mode.baseBits);
        for (unsigned end = 1; end < 2u * mode.subsets; ++end) {
            int& value = ends.values[end][channel];
            if (isSigned || mode.transformed)
                value = extendSign(value, deltaBits[channel]);
            if (!mode.transformed)
                continue;
            value = (value + base) & ((1 << mode.baseBits) - 1);
            if (isSigned)
                value = extendSign(value, mode.baseBits);
        }
    }
}

} // namespace

void decodeBc7(const uint8_t* block, unsigned texel, float color[4]) {
    color[0] = color[1] = color[2] = color[3] = 0;
    unsigned number = 0;
    while (number < 8 && !(block[0] >> number & 1))
        ++number;
    if (number == 8) // reserved
        return;
    const Mode7& mode = kModes7[number];
    Bits bits(block);
    bits.skip(number + 1);
    const unsigned partition = bits.take(mode.partitionBits);
    const unsigned rotation = bits.take(mode.rotationBits);
    const bool swapped = bits.take(mode.selectionBits);
    const unsigned ends = 2u * mode.subsets;
    unsigned points[6][4];
    for (unsigned channel = 0; channel < 4; ++channel)
        for (unsigned end = 0; end < ends; ++end)
            points[end][channel] = bits.take(channel < 3 ? mode.colorBits : mode.alphaBits);
    unsigned colorBits = mode.colorBits, alphaBits = mode.alphaBits;
    if (mode.ownParity || mode.sharedParity) {
        unsigned parity = 0;
        for (unsigned end = 0; end < ends; ++end) {
            if (mode.ownParity || end % 2 == 0)
                parity = bits.take(1);
            for (unsigned& value : points[end])
                value = value << 1 | parity;
        }
        ++colorBits;
        alphaBits += alphaBits ? 1 : 0;
    }
    const unsigned subset = subsetOf(mode.subsets, partition, texel);
    unsigned colorWidth = mode.indexBits, alphaWidth = mode.secondBits;
    unsigned colorIndex = indexOf(bits, mode.subsets, partition, texel, colorWidth);
    unsigned alphaIndex = colorIndex;
    if (mode.secondBits) {
        bits.skip(16u * mode.indexBits - mode.subsets);
        alphaIndex = indexOf(bits, 1, 0, texel, alphaWidth);
        if (swapped) {
            std::swap(colorIndex, alphaIndex);
            std::swap(colorWidth, alphaWidth);
        }
    } else {
        alphaWidth = colorWidth;
    }
    unsigned result[4];
    for (unsigned channel = 0; channel < 4; ++channel) {
        const bool alpha = channel == 3;
        const unsigned width = alpha ? alphaBits : colorBits;
        if (width == 0) {
            result[channel] = 255;
            continue;
        }
        const unsigned a = widen(points[2 * subset][channel], width);
        const unsigned b = widen(points[2 * subset + 1][channel], width);
        result[channel] = between(
            a, b, alpha ? weightOf(alphaIndex, alphaWidth) : weightOf(colorIndex, colorWidth));
    }
    if (rotation)
        std::swap(result[3], result[rotation - 1]);
    for (unsigned channel = 0; channel < 4; ++channel)
        color[channel] = float(result[channel]) / 255.0f;
}

void decodeBc6(const uint8_t* block, unsigned texel, bool isSigned, float color[4]) {
    color[0] = color[1] = color[2] = 0;
    color[3] = 1;
    const unsigned number = (block[0] & 2) ? block[0] & 31u : block[0] & 3u;
    const Mode6* mode = nullptr;
    for (const Mode6& candidate : kModes6)
        if (candidate.number == number)
            mode = &candidate;
    if (!mode) // reserved
        return;
    Bits bits(block);
    bits.skip(mode->modeBits);
    Ends6 ends = readEnds(*mode, bits);
    completeEnds(*mode, isSigned, ends);
    const unsigned partition = mode->subsets == 2 ? bits.take(5) : 0;
    const unsigned subset = subsetOf(mode->subsets, partition, texel);
    const unsigned width = mode->subsets == 2 ? 3 : 4;
    const auto weight = int(weightOf(indexOf(bits, mode->subsets, partition, texel, width), width));
    for (unsigned channel = 0; channel < 3; ++channel) {
        const int a = unquantize(ends.values[2 * subset][channel], mode->baseBits, isSigned);
        const int b = unquantize(ends.values[2 * subset + 1][channel], mode->baseBits, isSigned);
        color[channel] = halfToFloat(finish((a * (64 - weight) + b * weight + 32) >> 6, isSigned));
    }
}

} // namespace sunstone::texture
