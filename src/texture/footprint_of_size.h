// SPDX-License-Identifier: Apache-2.0
// Texture footprints without access to the texture, as on a GPU: from its size, the texture info
// and the sampling call. Results have the form of footprint.cpp. Unknown properties get the common
// values: texels are filtered, levels have no bias and are not clamped. Freestanding, as it is also
// compiled for GPUs. Source: OptiX API reference 7.4, section 3.1.2.151.
#pragma once

#include "texture/device_functions.h"

namespace sunstone::texture {

namespace sized {

// Values of CUaddress_mode.
enum Wrap : uint32_t { kRepeat, kClampToEdge, kMirrored, kBorder };

struct Sampler {
    uint32_t size[2]; // of level 0
    uint32_t wrap[2];
    uint32_t levels, anisotropy;
    bool linearLevels, isNormalized;
};

constexpr int kMostTexels = 64; // four of each of 16 probes

struct Texels {
    int x[kMostTexels], y[kMostTexels];
    int count = 0;
};

// log2 of width and height of the groups, by number; 0 for a number without a size.
inline uint32_t groupSize(uint32_t number, uint32_t axis) {
    constexpr uint64_t kWidths = 0x8877600044332210, kHeights = 0x8776600043322110;
    return uint32_t((axis ? kHeights : kWidths) >> (4 * number)) & 15;
}

inline int resolve(uint32_t wrap, int i, int size) {
    if (i >= 0 && i < size)
        return i;
    if (wrap == kRepeat)
        return i < 0 ? i + size : i - size; // at most one beyond
    if (wrap == kBorder)
        return -1;
    if (wrap == kMirrored) {
        const int period = 2 * size;
        i = (i % period + period) % period;
        return i < size ? i : period - 1 - i;
    }
    return i < 0 ? 0 : size - 1;
}

// The position along an axis in units of 1/256 of a texel, of the first of two texels.
inline int place(uint32_t wrap, double x, int size, bool isNormalized) {
    if (!(x == x))
        x = 0;
    if (isNormalized)
        x = __builtin_floor(x * 0x1p23) * 0x1p-23;
    const bool isInfinite = __builtin_fabs(x) > 1e300;
    double u;
    if (wrap == kRepeat)
        u = isInfinite ? 0 : (x - __builtin_floor(x)) * size;
    else if (wrap == kMirrored)
        u = isInfinite ? 0 : (x - 2 * __builtin_floor(x / 2)) * size;
    else
        u = __builtin_fmin(__builtin_fmax(isNormalized ? x * size : x, -4.0), double(size) + 4);
    return int(__builtin_floor(u * 256 - 128 + 0.5));
}

// The texels of a probe with a weight above 0.
inline void addProbe(const Sampler& sampler, uint32_t level, const double position[2],
                              Texels& texels) {
    int at[2][2];
    uint32_t weight[2];
    for (uint32_t axis = 0; axis < 2; ++axis) {
        const uint32_t size = sampler.size[axis] >> level;
        const int count = size ? int(size) : 1;
        const int fixed = place(sampler.wrap[axis], position[axis], count, sampler.isNormalized);
        weight[axis] = uint32_t(fixed & 255);
        at[axis][0] = resolve(sampler.wrap[axis], fixed >> 8, count);
        at[axis][1] = resolve(sampler.wrap[axis], (fixed >> 8) + 1, count);
    }
    // Rounds the products as texture/sample.cpp does.
    const uint32_t x = weight[0], y = weight[1];
    uint32_t both = (x * y + 128) >> 8, below = y;
    if (both > below)
        both = below;
    below -= both;
    const uint32_t right = x > both ? x - both : 0;
    const uint32_t first = 256 - x > below ? 256 - x - below : 0;
    const uint32_t weights[4] = {first, right, below, both};
    for (uint32_t corner = 0; corner < 4; ++corner) {
        const int column = at[0][corner & 1], row = at[1][corner >> 1];
        if (weights[corner] && column >= 0 && row >= 0 && texels.count < kMostTexels) {
            texels.x[texels.count] = column;
            texels.y[texels.count++] = row;
        }
    }
}

// Eight groups along one axis; see Window of texture/footprint.cpp.
struct Window {
    int first, count;
    bool fits;
    uint32_t tile() const { return first > 0 ? uint32_t(first + 7) / 8 : 0; }
    uint32_t rotation() const { return uint32_t(int(tile()) * 8 - first); }
    uint32_t bit(int group) const {
        const int at = group - first < 8 ? group : group - count;
        return uint32_t(at - int(tile()) * 8) & 7;
    }
};

inline Window windowOf(const int* texels, int texelCount, uint32_t shift, int size,
                                bool wraps) {
    int least = 0x7fffffff, last = 0;
    for (int i = 0; i < texelCount; ++i) {
        const int group = texels[i] >> shift;
        least = group < least ? group : least;
        last = group > last ? group : last;
    }
    Window window{least, ((size - 1) >> shift) + 1, false};
    window.first = least / 8 == last / 8 ? least / 8 * 8 : last - 7;
    window.fits = last - least < 8;
    if (window.fits || !wraps)
        return window;
    // Groups right of the widest gap, the leftmost of several, move to the other side.
    int widest = 0, left = least, right = least;
    for (int i = 0; i < texelCount; ++i) {
        const int group = texels[i] >> shift;
        int next = 0x7fffffff;
        for (int k = 0; k < texelCount; ++k) {
            const int other = texels[k] >> shift;
            next = other > group && other < next ? other : next;
        }
        if (next != 0x7fffffff && (next - group > widest || (next - group == widest && group < left))) {
            widest = next - group;
            left = group;
            right = next;
        }
    }
    const int beyond = right - window.count;
    if (left - beyond < 8) {
        window.first = left - 7;
        window.fits = true;
    }
    return window;
}

inline float logarithm(float value) { // base 2
#ifdef __NVPTX__
    float result;
    asm("lg2.approx.f32 %0, %1;" : "=f"(result) : "f"(value));
    return result;
#else
    return __builtin_log2f(value);
#endif
}

inline Sampler samplerOf(uint32_t width, uint32_t height, bool isNormalized, uint32_t info) {
    Sampler sampler;
    sampler.size[0] = width;
    sampler.size[1] = height;
    sampler.isNormalized = isNormalized;
    sampler.levels = info >> 24 & 31 ? info >> 24 & 31 : 1;
    sampler.anisotropy = info & 31 ? (info & 31) > 16 ? 16 : info & 31 : 1;
    sampler.linearLevels = info >> 5 & 1;
    for (uint32_t axis = 0; axis < 2; ++axis) {
        const uint32_t wanted = axis ? info >> 6 & 3 : info >> 8 & 3;
        sampler.wrap[axis] = !sampler.isNormalized && (wanted == kRepeat || wanted == kMirrored)
                                 ? uint32_t(kClampToEdge)
                                 : wanted;
    }
    return sampler;
}

// The level, and the line of probes along the longer change.
struct Line {
    float level;
    uint32_t probes;
    const float* along;
};

inline Line lineOf(const Sampler& sampler, uint32_t form, const SampleOperands& operands) {
    Line line{form & kWithLevel ? operands.level : 0.0f, 1, operands.dx};
    if (form & kWithGradient) {
        float lengths[2];
        for (uint32_t k = 0; k < 2; ++k) {
            const float* change = k ? operands.dy : operands.dx;
            const double x = change[0] * (sampler.isNormalized ? double(sampler.size[0]) : 1.0);
            const double y = change[1] * (sampler.isNormalized ? double(sampler.size[1]) : 1.0);
            lengths[k] = float(__builtin_sqrt(x * x + y * y));
        }
        line.along = lengths[0] >= lengths[1] ? operands.dx : operands.dy;
        const float major = lengths[0] >= lengths[1] ? lengths[0] : lengths[1];
        float least = lengths[0] >= lengths[1] ? lengths[1] : lengths[0];
        if (sampler.anisotropy > 1 && major > 1 && major < 3.4e38f) {
            least = __builtin_fmaxf(__builtin_fmaxf(least, 1.0f), major / float(sampler.anisotropy));
            const float ratio = __builtin_ceilf(major / least);
            line.probes = ratio < float(sampler.anisotropy) ? uint32_t(ratio) : sampler.anisotropy;
        }
        line.level = -100;
        if (major > 0)
            line.level = logarithm(major / float(line.probes));
    }
    const float highest = float(sampler.levels - 1);
    line.level = line.level >= 0 ? line.level : 0;
    line.level = line.level < highest ? line.level : highest;
    return line;
}

// Replaces the texels by those that the probes read on a level. False if there are none.
inline bool gather(const Sampler& sampler, const Line& line, const SampleOperands& operands,
                   uint32_t level, Texels& texels) {
    const auto position = [&](uint32_t k, uint32_t probe) {
        float center;
        __builtin_memcpy(&center, &operands.position[k], sizeof center);
        const double at = (probe + 0.5) / line.probes - 0.5;
        return double(center) + (line.probes > 1 ? at * double(line.along[k]) : 0);
    };
    texels.count = 0;
    for (uint32_t i = 0; i < line.probes; ++i) {
        const double at[2] = {position(0, i), position(1, i)};
        addProbe(sampler, level, at, texels);
    }
    return texels.count != 0;
}

// The requested one of the two levels that a call may read, with its texels.
struct Chosen {
    uint32_t level;
    bool isSingle;
};

inline Chosen choose(const Sampler& sampler, const Line& line, const SampleOperands& operands,
                     bool coarse, Texels& texels) {
    uint32_t fine = uint32_t(line.level + 0.5f), other = fine;
    if (sampler.linearLevels) {
        const uint32_t fixed = uint32_t(line.level * 256);
        fine = fixed >> 8;
        other = fixed & 255 ? fine + 1 : fine;
    }
    // A level of which the call reads only the border does not count.
    const bool readsFine = gather(sampler, line, operands, fine, texels);
    const bool readsOther = other != fine && gather(sampler, line, operands, other, texels);
    const uint32_t chosen = readsOther && (coarse || !readsFine) ? other : fine;
    if (other != fine && chosen == fine)
        gather(sampler, line, operands, fine, texels);
    return {chosen, !(readsFine && readsOther)};
}

// The number of the smallest groups of at least the requested size.
inline uint32_t requestedSize(uint32_t info) {
    const uint32_t tileWidth = info >> 20 & 15, tileHeight = info >> 16 & 15;
    uint32_t requested = 1;
    while (requested < 15 && (!groupSize(requested, 0) || groupSize(requested, 0) < tileWidth ||
                              groupSize(requested, 1) < tileHeight))
        ++requested;
    return requested;
}

// False if groups of this number do not cover the texels in one tile.
inline bool writeTile(const Sampler& sampler, const Texels& texels, uint32_t level, uint32_t number,
                      uint32_t requested, uint32_t result[4]) {
    const uint32_t sizeX = sampler.size[0] >> level, sizeY = sampler.size[1] >> level;
    const uint32_t shiftX = groupSize(number, 0), shiftY = groupSize(number, 1);
    if (!shiftX)
        return false;
    const Window x = windowOf(texels.x, texels.count, shiftX, sizeX ? int(sizeX) : 1,
                              sampler.wrap[0] == kRepeat);
    const Window y = windowOf(texels.y, texels.count, shiftY, sizeY ? int(sizeY) : 1,
                              sampler.wrap[1] == kRepeat);
    if (!x.fits || !y.fits)
        return false;
    uint64_t mask = 0;
    for (int i = 0; i < texels.count; ++i)
        mask |= uint64_t(1) << (x.bit(texels.x[i] >> shiftX) + 8 * y.bit(texels.y[i] >> shiftY));
    result[0] = uint32_t(mask);
    result[1] = uint32_t(mask >> 32);
    result[2] = (y.tile() & 0xFFF) | x.rotation() << 16 | y.rotation() << 19 |
                (number == requested ? 0 : number) << 24;
    result[3] = (x.tile() & 0xFFF) | (level & 15) << 12;
    return true;
}

} // namespace sized

// Like footprint(). `width` and `height` are those of level 0.
inline void footprintOfSize(uint32_t width, uint32_t height, bool isNormalized, uint32_t info,
                            uint32_t form, const SampleOperands* operands, uint32_t coarse,
                            uint32_t* singleLevel, uint32_t result[4]) {
    using namespace sized;
    if (singleLevel)
        *singleLevel = 1;
    result[0] = result[1] = result[2] = result[3] = 0;
    if (width == 0 || height == 0)
        return;
    const Sampler sampler = samplerOf(width, height, isNormalized, info);
    const Line line = lineOf(sampler, form, *operands);
    Texels texels;
    const Chosen chosen = choose(sampler, line, *operands, coarse != 0, texels);
    if (singleLevel)
        *singleLevel = chosen.isSingle;
    if (texels.count == 0)
        return;
    // The size of the tile, or the next larger one that holds the texels.
    const uint32_t requested = requestedSize(info);
    for (uint32_t number = requested; number < 16; ++number)
        if (writeTile(sampler, texels, chosen.level, number, requested, result))
            return;
}

} // namespace sunstone::texture
