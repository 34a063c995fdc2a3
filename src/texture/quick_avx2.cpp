// SPDX-License-Identifier: Apache-2.0
// The functions of quick.h. A texel is a vector of four channels; channels that the format lacks
// are 0. Each step has the rounding of its counterpart in sample.cpp and fetch.cpp. All helpers
// have internal linkage, so that no other file can execute AVX2 instructions through them.
#include "base/inline.h"
#include "texture/quick.h"

#include <immintrin.h>

namespace sunstone::texture {

namespace {

// The conversion of a texel.
enum class Kind : uint8_t {
    kWords, // 32-bit channels as they are
    kHalf,
    kU8,
    kS8,
    kU16,
    kS16,
    kSrgb8,
    kRawU8, // integers as integers; without a filter
    kRawS8,
    kRawU16,
    kRawS16,
};

constexpr unsigned bytesOf(Kind kind) {
    switch (kind) {
    case Kind::kWords:
        return 4;
    case Kind::kHalf:
    case Kind::kU16:
    case Kind::kS16:
    case Kind::kRawU16:
    case Kind::kRawS16:
        return 2;
    default:
        return 1;
    }
}

// ---- texels ------------------------------------------------------------------------------------
// Loads only the bytes of the texel, because linear memory may end behind it.
template <unsigned kBytes>
SUNSTONE_INLINE __m128i loadBytes(const uint8_t* texel) {
    if constexpr (kBytes == 16)
        return _mm_loadu_si128(reinterpret_cast<const __m128i*>(texel));
    else if constexpr (kBytes == 8)
        return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(texel));
    else if constexpr (kBytes == 4)
        return _mm_loadu_si32(texel);
    else if constexpr (kBytes == 2)
        return _mm_cvtsi32_si128(texel[0] | texel[1] << 8);
    else
        return _mm_cvtsi32_si128(texel[0]);
}

// Exact. Uses only integers, because a thread may flush subnormal operands of multiplications.
SUNSTONE_INLINE __m128 halvesToFloats(__m128i halves) {
    const __m128i magnitude = _mm_and_si128(halves, _mm_set1_epi32(0x7FFF));
    const __m128i sign = _mm_slli_epi32(_mm_and_si128(halves, _mm_set1_epi32(0x8000)), 16);
    const __m128i shifted = _mm_slli_epi32(magnitude, 13);
    const __m128i normal = _mm_add_epi32(shifted, _mm_set1_epi32(112 << 23));
    const __m128i special = _mm_or_si128(shifted, _mm_set1_epi32(0x7F800000));
    const __m128i small =
        _mm_castps_si128(_mm_mul_ps(_mm_cvtepi32_ps(magnitude), _mm_set1_ps(0x1p-24f)));
    __m128i value =
        _mm_blendv_epi8(normal, small, _mm_cmplt_epi32(magnitude, _mm_set1_epi32(0x400)));
    value = _mm_blendv_epi8(value, special, _mm_cmpgt_epi32(magnitude, _mm_set1_epi32(0x7BFF)));
    return _mm_castsi128_ps(_mm_or_si128(value, sign));
}

// Quotients of small integers round as in double precision, because no quotient is near the middle
// of two floats.
SUNSTONE_INLINE __m128 fractions(__m128i integers, float most) {
    return _mm_div_ps(_mm_cvtepi32_ps(integers), _mm_set1_ps(most));
}

template <unsigned kChannels>
SUNSTONE_INLINE __m128 srgbColor(const float* numbers, const uint8_t* texel) {
    if constexpr (kChannels == 1)
        return _mm_set_ps(0, 0, 0, numbers[texel[0]]);
    else if constexpr (kChannels == 2)
        return _mm_set_ps(0, 0, float(texel[1]) / 255.0f, numbers[texel[0]]);
    else
        return _mm_set_ps(float(texel[3]) / 255.0f, numbers[texel[2]], numbers[texel[1]],
                          numbers[texel[0]]);
}

template <Kind kKind, unsigned kChannels>
SUNSTONE_INLINE __m128 texelAt(const Texture& texture, const uint8_t* texel) {
    if constexpr (kKind == Kind::kSrgb8)
        return srgbColor<kChannels>(texture.quick.fromSrgb, texel);
    const __m128i all = loadBytes<bytesOf(kKind) * kChannels>(texel);
    switch (kKind) {
    case Kind::kHalf:
        return halvesToFloats(_mm_cvtepu16_epi32(all));
    case Kind::kU8:
        return fractions(_mm_cvtepu8_epi32(all), 255);
    case Kind::kS8:
        return fractions(_mm_cvtepi8_epi32(all), 127);
    case Kind::kU16:
        return fractions(_mm_cvtepu16_epi32(all), 65535);
    case Kind::kS16:
        return fractions(_mm_cvtepi16_epi32(all), 32767);
    case Kind::kRawU8:
        return _mm_castsi128_ps(_mm_cvtepu8_epi32(all));
    case Kind::kRawS8:
    case Kind::kRawS16: {
        const __m128i wide =
            kKind == Kind::kRawS8 ? _mm_cvtepi8_epi32(all) : _mm_cvtepi16_epi32(all);
        return _mm_castsi128_ps(wide);
    }
    case Kind::kRawU16:
        return _mm_castsi128_ps(_mm_cvtepu16_epi32(all));
    default:
        return _mm_castsi128_ps(all);
    }
}

// nearestHalf() of sample.cpp.
SUNSTONE_INLINE __m128 nearestHalves(__m128 value) {
    const __m128i bits = _mm_castps_si128(value);
    const __m128i magnitude = _mm_and_si128(bits, _mm_set1_epi32(0x7FFFFFFF));
    const __m128i sign = _mm_andnot_si128(_mm_set1_epi32(0x7FFFFFFF), bits);
    const __m128i normal =
        _mm_and_si128(_mm_add_epi32(bits, _mm_set1_epi32(0x1000)), _mm_set1_epi32(~0x1FFF));
    const __m128 units = _mm_add_ps(_mm_div_ps(_mm_castsi128_ps(magnitude), _mm_set1_ps(0x1p-24f)),
                                    _mm_set1_ps(0.5f));
    const __m128 small = _mm_mul_ps(_mm_floor_ps(units), _mm_set1_ps(0x1p-24f));
    __m128i result = _mm_blendv_epi8(normal, _mm_or_si128(_mm_castps_si128(small), sign),
                                     _mm_cmplt_epi32(magnitude, _mm_set1_epi32(0x38800000)));
    result = _mm_blendv_epi8(result, bits, _mm_cmpgt_epi32(magnitude, _mm_set1_epi32(0x7F7FFFFF)));
    return _mm_castsi128_ps(result);
}

// Signed fractions below -1 remain so until the sum of a filter.
template <Kind kKind>
SUNSTONE_INLINE __m128 finished(__m128 value, bool filtered) {
    if constexpr (kKind == Kind::kS8 || kKind == Kind::kS16)
        return _mm_max_ps(value, _mm_set1_ps(-1));
    if constexpr (kKind == Kind::kHalf)
        return filtered ? nearestHalves(value) : value;
    return value;
}

// ---- places ------------------------------------------------------------------------------------
struct Place {
    int64_t first = 0, second = 0; // texels
    uint32_t weight = 0;           // of the second, in 1/256
};

SUNSTONE_INLINE int64_t limited(int64_t value, int64_t least, int64_t most) {
    value = value < least ? least : value;
    return value > most ? most : value;
}

// The texel that the address mode selects near the image; -1: the border.
SUNSTONE_INLINE int64_t resolved(Address mode, bool normalized, int64_t i, int64_t size) {
    if (uint64_t(i) < uint64_t(size))
        return i;
    if (mode == Address::kBorder)
        return -1;
    if (normalized && mode == Address::kWrap)
        return i < 0 ? i + size : i - size;
    if (normalized && mode == Address::kMirror)
        return i < 0 || i >= 2 * size ? 0 : 2 * size - 1 - i;
    return i < 0 ? 0 : size - 1;
}

// A position in texels, in 1/2^23; normalized coordinates.
SUNSTONE_INLINE int64_t texelUnits(Address mode, double x, int64_t size) {
    constexpr int64_t kUnit = 1 << 23;
    const __m128d scaled = _mm_set_sd(x * 0x1p23);
    const int64_t units = _mm_cvttsd_si64(_mm_floor_sd(scaled, scaled));
    if (mode == Address::kWrap)
        return (units & (kUnit - 1)) * size;
    if (mode == Address::kMirror)
        return (units & (2 * kUnit - 1)) * size;
    // The first limits keep the product in range and lie beyond the second.
    return limited(limited(units, -1024 * kUnit, 1024 * kUnit) * size, -4 * kUnit,
                   (size + 4) * kUnit);
}

// False: the function does not cover the position.
template <bool kLinear>
SUNSTONE_INLINE bool place(const Texture& texture, unsigned axis, double x, int64_t size,
                           Place& place) {
    if (!(__builtin_fabs(x) < 0x1p39)) // also NaN
        return false;
    const Address mode = texture.address[axis];
    const bool normalized = texture.normalizedCoordinates;
    int64_t i = 0;
    if (normalized) {
        const int64_t units = texelUnits(mode, x, size);
        i = kLinear ? (2 * units - (255 << 15)) >> 16 : units >> 23;
    } else {
        double u = x < -4 ? -4 : x;
        u = u > double(size) + 4 ? double(size) + 4 : u;
        const __m128d at = _mm_set_sd(kLinear ? u * 256 - 128 + 0.5 : u);
        i = _mm_cvttsd_si64(_mm_floor_sd(at, at));
    }
    place.weight = kLinear ? uint32_t(i & 255) : 0;
    i = kLinear ? i >> 8 : i;
    place.first = resolved(mode, normalized, i, size);
    place.second = place.weight ? resolved(mode, normalized, i + 1, size) : 0;
    return place.first >= 0 && place.second >= 0;
}

// ---- filters -----------------------------------------------------------------------------------
// Weights of four texels in 1/256: see cornerWeights() of sample.cpp.
SUNSTONE_INLINE __m128i squareWeights(uint32_t a, uint32_t b) {
    const uint32_t both = (a * b + 128) >> 8;
    return _mm_set_epi32(int(both), int(b - both), int(a - both), int(256 - a - b + both));
}

// Splits the weights of a square between two slices.
SUNSTONE_INLINE void cubeWeights(__m128i square, uint32_t c, __m128i& near, __m128i& far) {
    alignas(16) uint32_t first[4], second[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(first), square);
    uint32_t left = c;
    const auto move = [&](unsigned corner, uint32_t wanted) {
        uint32_t part = wanted < left ? wanted : left;
        part = part < first[corner] ? part : first[corner];
        left -= part;
        first[corner] -= part;
        return part;
    };
    for (unsigned corner = 4; corner-- > 0;)
        second[corner] = move(corner, (first[corner] * c + 128) >> 8);
    for (unsigned corner = 0; corner < 4 && left > 0; ++corner)
        second[corner] += move(corner, left);
    near = _mm_load_si128(reinterpret_cast<const __m128i*>(first));
    far = _mm_load_si128(reinterpret_cast<const __m128i*>(second));
}

// Adds a texel. One of weight 0 adds nothing even if it is infinite or NaN.
template <Kind kKind>
SUNSTONE_INLINE __m128 added(__m128 sum, __m128 weight, __m128 texel) {
    __m128 product = _mm_mul_ps(weight, texel);
    if constexpr (kKind == Kind::kWords || kKind == Kind::kHalf)
        product = _mm_and_ps(product, _mm_cmpneq_ps(weight, _mm_setzero_ps()));
    return _mm_add_ps(sum, product);
}

template <Kind kKind, unsigned kChannels>
SUNSTONE_INLINE __m128 squareSum(const Texture& texture, const Image& image, const Place& x,
                                 const Place& y, int64_t slice, __m128i weights, __m128 sum) {
    constexpr unsigned kBytes = bytesOf(kKind) * kChannels;
    const uint8_t* const base = image.data + size_t(slice) * image.slicePitch;
    const uint8_t* const upper = base + size_t(y.first) * image.rowPitch;
    const uint8_t* const lower = base + size_t(y.second) * image.rowPitch;
    const __m128 w = _mm_mul_ps(_mm_cvtepi32_ps(weights), _mm_set1_ps(1.0f / 256));
    const auto texel = [&](const uint8_t* row, int64_t i) __attribute__((always_inline)) {
        return texelAt<kKind, kChannels>(texture, row + size_t(i) * kBytes);
    };
    sum = added<kKind>(sum, _mm_shuffle_ps(w, w, 0x00), texel(upper, x.first));
    sum = added<kKind>(sum, _mm_shuffle_ps(w, w, 0x55), texel(upper, x.second));
    sum = added<kKind>(sum, _mm_shuffle_ps(w, w, 0xAA), texel(lower, x.first));
    return added<kKind>(sum, _mm_shuffle_ps(w, w, 0xFF), texel(lower, x.second));
}

template <Kind kKind, unsigned kChannels, bool kLinear>
SUNSTONE_INLINE bool sampleFormat(const Texture& texture, const Image& image, unsigned dimensions,
                                  double atX, double atY, double atZ, uint32_t slice,
                                  uint32_t result[4]) {
    Place x, y, z;
    z.first = slice;
    if (!place<kLinear>(texture, 0, atX, image.width, x) ||
        (dimensions > 1 && !place<kLinear>(texture, 1, atY, image.height, y)) ||
        (dimensions > 2 && !place<kLinear>(texture, 2, atZ, image.depth, z)))
        return false;
    __m128 value = _mm_setzero_ps();
    if constexpr (kLinear) {
        __m128i near = squareWeights(x.weight, y.weight), far = near;
        if (z.weight)
            cubeWeights(near, z.weight, near, far);
        value = squareSum<kKind, kChannels>(texture, image, x, y, z.first, near, value);
        if (z.weight)
            value = squareSum<kKind, kChannels>(texture, image, x, y, z.second, far, value);
    } else {
        value =
            texelAt<kKind, kChannels>(texture, image.data + size_t(z.first) * image.slicePitch +
                                                   size_t(y.first) * image.rowPitch +
                                                   size_t(x.first) * (bytesOf(kKind) * kChannels));
    }
    _mm_storeu_ps(reinterpret_cast<float*>(result), finished<kKind>(value, kLinear));
    return true;
}

template <Kind kKind, unsigned kChannels, bool kLinear>
bool sampleImage(const Texture& texture, const Image& image, unsigned dimensions, double x,
                 double y, double z, uint32_t slice, uint32_t result[4]) {
    return sampleFormat<kKind, kChannels, kLinear>(texture, image, dimensions, x, y, z, slice,
                                                   result);
}

template <Kind kKind, unsigned kChannels, bool kLinear>
void sampleCall(const Texture& texture, uint32_t form, const SampleOperands& operands,
                uint32_t result[4]) {
    const uint32_t geometry = form & kGeometryMask;
    const bool direction = geometry >= kCube, depth = geometry == k3D || direction;
    const unsigned dimensions = geometry == k1D || geometry == k1DArray ? 1
                                : depth && texture.is3D                 ? 3
                                                                        : 2;
    const Image& image = texture.images[0];
    const uint32_t layer = geometry >= k1DArray ? operands.layer : 0;
    // Volatile: one load of both positions would stall until both stores of the caller are done.
    const volatile uint32_t* const words = operands.position;
    if ((direction && texture.cube) ||
        !sampleFormat<kKind, kChannels, kLinear>(
            texture, image, dimensions, __builtin_bit_cast(float, words[0]),
            __builtin_bit_cast(float, words[1]), __builtin_bit_cast(float, words[2]),
            layer < image.depth ? layer : image.depth - 1, result))
        sampleSlowly(texture, form, operands, true, result);
}

// ---- selection ---------------------------------------------------------------------------------
template <Kind kKind, unsigned kChannels, bool kLinear>
constexpr QuickFunctions kFunctions = {sampleImage<kKind, kChannels, kLinear>,
                                       sampleCall<kKind, kChannels, kLinear>};

template <Kind kKind, bool kLinear>
QuickFunctions ofChannels(unsigned channels) {
    return channels == 1   ? kFunctions<kKind, 1, kLinear>
           : channels == 2 ? kFunctions<kKind, 2, kLinear>
           : channels == 4 ? kFunctions<kKind, 4, kLinear>
                           : QuickFunctions{};
}

template <Kind kKind>
QuickFunctions ofFilter(unsigned channels, bool linear) {
    return linear ? ofChannels<kKind, true>(channels) : ofChannels<kKind, false>(channels);
}

template <Kind kNumber, Kind kInteger>
QuickFunctions ofInteger(unsigned channels, bool linear, bool asFloat) {
    return asFloat ? ofFilter<kNumber>(channels, linear) : ofChannels<kInteger, false>(channels);
}

} // namespace

QuickFunctions quickFunctions(const Format& format, bool linear, bool asFloat, bool srgb) {
    const unsigned n = format.channels;
    switch (format.channel) {
    case Channel::kU8:
        return srgb && asFloat ? ofFilter<Kind::kSrgb8>(n, linear)
                               : ofInteger<Kind::kU8, Kind::kRawU8>(n, linear, asFloat);
    case Channel::kS8:
        return ofInteger<Kind::kS8, Kind::kRawS8>(n, linear, asFloat);
    case Channel::kU16:
        return ofInteger<Kind::kU16, Kind::kRawU16>(n, linear, asFloat);
    case Channel::kS16:
        return ofInteger<Kind::kS16, Kind::kRawS16>(n, linear, asFloat);
    case Channel::kF16:
        return ofFilter<Kind::kHalf>(n, linear);
    case Channel::kU32:
    case Channel::kS32:
    case Channel::kF32:
        return ofFilter<Kind::kWords>(n, linear);
    default:
        return {};
    }
}

} // namespace sunstone::texture
