// SPDX-License-Identifier: Apache-2.0
// Sampling. Positions become texel units in double precision, which holds the products of float
// coordinates and sizes exactly. The linear filter takes the weights of CUDA devices: a position's
// fraction rounded to 1/256. The fraction between two levels is cut to 1/256. Both fractions, the
// borders and the behaviour at huge coordinates were taken from recordings of a GPU
// (tests/cuda/apps/textures.cu). Source: CUDA C++ Programming Guide, appendix "Texture Fetching".
#include "texture/device_functions.h"

#include "texture/fetch.h"
#include "texture/footprint.h"
#include "texture/quick.h"
#include "texture/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace sunstone::texture {

namespace {

// A position along one axis: texel `i` and `i + 1` with the weight of the second, in 1/256.
struct Axis {
    int64_t i = 0;
    uint32_t weight = 0;
};

// The state of one sampling call.
struct Sampler {
    const Texture& texture;
    bool integers; // results are integers: no filter
    bool filter;
    bool normalized; // of this call's coordinates
    bool byNumber;   // coordinates are texel numbers
    Reading reading;
    bool clamps = false;           // overrides the address modes
    TexelRecord* record = nullptr; // receives the texels instead of reading them
    bool quick = false;            // may use the texture's own function

    explicit Sampler(const Texture& t, bool texelNumbers) : texture(t), reading{t.asFloat, t.srgb} {
        byNumber = texelNumbers;
        integers = t.format.isInteger() && !t.asFloat && !t.format.normalized;
        filter = t.linear && !integers && !texelNumbers;
        normalized = t.normalizedCoordinates && !texelNumbers;
        reading.unclamped = filter;
    }

    Address mode(unsigned axis) const {
        if (clamps)
            return Address::kClamp;
        const Address wanted = texture.address[axis];
        if (!normalized && (wanted == Address::kWrap || wanted == Address::kMirror))
            return Address::kClamp;
        return wanted;
    }
};

// The position in texels, moved near the image so that it fits an integer.
double toTexels(const Sampler& sampler, unsigned axis, double x, uint32_t size) {
    if (std::isnan(x))
        x = 0;
    if (sampler
            .normalized) // devices cut it to 23 bits: 1/6 of six texels, as a float, is in texel 0
        x = std::floor(x * 0x1p23) * 0x1p-23;
    switch (sampler.mode(axis)) {
    case Address::kWrap:
        return std::isinf(x) ? 0 : (x - std::floor(x)) * size;
    case Address::kMirror: {
        if (std::isinf(x))
            return 0;
        return (x - 2 * std::floor(x / 2)) * size; // resolve() mirrors each texel
    }
    default: {
        const double u = sampler.normalized ? x * size : x;
        return std::clamp(u, -4.0, double(size) + 4);
    }
    }
}

Axis place(const Sampler& sampler, unsigned axis, double x, uint32_t size, bool filter) {
    const double u = toTexels(sampler, axis, x, size);
    if (!filter)
        return {int64_t(std::floor(u)), 0};
    const auto fixed = int64_t(std::floor(u * 256 - 128 + 0.5));
    return {fixed >> 8, uint32_t(fixed & 255)};
}

// The texel that the address mode selects outside the image; -1: the border.
int64_t resolve(Address mode, int64_t i, uint32_t size) {
    if (i >= 0 && i < int64_t(size))
        return i;
    switch (mode) {
    case Address::kWrap:
        return i < 0 ? (i + int64_t(size)) % int64_t(size) : i % int64_t(size);
    case Address::kBorder:
        return -1;
    case Address::kMirror: {
        const int64_t period = 2 * int64_t(size);
        i = (i % period + period) % period;
        return i < int64_t(size) ? i : period - 1 - i;
    }
    default:
        return i < 0 ? 0 : int64_t(size) - 1;
    }
}

void fetch(const Sampler& sampler, const Image& image, int64_t x, int64_t y, int64_t z,
           uint32_t words[4]) {
    if (sampler.record) {
        std::fill_n(words, 4, 0u);
        if (x >= 0 && y >= 0 && z >= 0)
            sampler.record->add(image, uint32_t(x), uint32_t(y));
        return;
    }
    if (x < 0 || y < 0 || z < 0) {
        const Texture& t = sampler.texture;
        borderTexel(t.format, sampler.reading, t.border, words);
        return;
    }
    fetchTexel(sampler.texture.format, sampler.reading, image.data + size_t(z) * image.slicePitch,
               image.rowPitch, uint32_t(x), uint32_t(y), words);
}

// Weights of the corners of a footprint, in 1/256 with the sum 256: devices round the products. Bit
// d of a corner's number selects one of the two texels along axis d.
void cornerWeights(const Axis axes[3], unsigned dimensions, uint32_t weights[8]) {
    weights[0] = 256;
    for (unsigned d = 0; d < dimensions; ++d) {
        const uint32_t half = 1u << d;
        uint32_t left = axes[d].weight;
        const auto move = [&](uint32_t corner, uint32_t wanted) {
            const uint32_t second = std::min({wanted, left, weights[corner]});
            left -= second;
            weights[corner] -= second;
            return second;
        };
        for (uint32_t corner = half; corner-- > 0;)
            weights[corner + half] = move(corner, (weights[corner] * axes[d].weight + 128) >> 8);
        // The remainder of rounding goes to the first corners that have as much.
        for (uint32_t corner = 0; corner < half && left > 0; ++corner)
            weights[corner + half] += move(corner, left);
    }
}

void addWeighted(const uint32_t words[4], float weight, float sum[4]) {
    for (unsigned k = 0; k < 4; ++k)
        sum[k] += weight * std::bit_cast<float>(words[k]);
}

// The nearest half, of two the one farther from zero; `value` is at most the largest half.
float nearestHalf(float value) {
    constexpr float kLeastNormal = 0x1p-14f, kUnit = 0x1p-24f;
    if (!std::isfinite(value))
        return value;
    if (std::fabs(value) < kLeastNormal)
        return std::copysign(std::floor(std::fabs(value) / kUnit + 0.5f) * kUnit, value);
    return std::bit_cast<float>((std::bit_cast<uint32_t>(value) + 0x1000) & ~0x1FFFu);
}

// Filtered halves are rounded to halves, and signed fractions are clamped at -1.
void finishSum(const Format& format, float sum[4]) {
    const Channel channel = format.channel;
    for (unsigned k = 0; k < 4; ++k) {
        if (channel == Channel::kF16 || channel == Channel::kBC6U || channel == Channel::kBC6S)
            sum[k] = nearestHalf(sum[k]);
        else if (channel == Channel::kS8 || channel == Channel::kS16)
            sum[k] = std::max(sum[k], -1.0f);
    }
}

// The result for a texel number outside the image: zero, or opaque black.
void noTexel(const Format& format, uint32_t result[4]) {
    std::fill_n(result, 4, 0u);
    if (format.isBlock() && format.channels < 4)
        result[3] = std::bit_cast<uint32_t>(1.0f);
}

// Filters over `dimensions` axes; axes beyond are fixed by `slice`.
void sampleImage(const Sampler& sampler, const Image& image, unsigned dimensions,
                 const double position[3], uint32_t slice, uint32_t result[4]) {
    if (sampler.quick &&
        sampler.texture.quick.image(sampler.texture, image, dimensions, position[0], position[1],
                                    position[2], slice, result))
        return;
    const uint32_t sizes[3] = {image.width, image.height, image.depth};
    Axis axes[3];
    int64_t texels[3][2] = {{0, 0}, {0, 0}, {int64_t(slice), int64_t(slice)}};
    for (unsigned d = 0; d < dimensions; ++d) {
        axes[d] = place(sampler, d, position[d], sizes[d], sampler.filter);
        texels[d][0] = resolve(sampler.mode(d), axes[d].i, sizes[d]);
        texels[d][1] = axes[d].weight ? resolve(sampler.mode(d), axes[d].i + 1, sizes[d]) : 0;
    }
    if (sampler.byNumber)
        for (unsigned d = 0; d < dimensions; ++d)
            if (texels[d][0] != axes[d].i && texels[d][0] >= 0)
                return noTexel(sampler.texture.format, result);
    if (!sampler.filter) {
        fetch(sampler, image, texels[0][0], texels[1][0], texels[2][0], result);
        return;
    }
    float sum[4] = {};
    uint32_t weights[8];
    cornerWeights(axes, dimensions, weights);
    for (unsigned corner = 0; corner < 1u << dimensions; ++corner) {
        if (weights[corner] == 0)
            continue;
        int64_t at[3] = {texels[0][0], texels[1][0], texels[2][0]};
        for (unsigned d = 0; d < dimensions; ++d)
            at[d] = texels[d][corner >> d & 1];
        uint32_t words[4];
        fetch(sampler, image, at[0], at[1], at[2], words);
        addWeighted(words, float(weights[corner]) * (1.0f / 256), sum);
    }
    finishSum(sampler.texture.format, sum);
    std::memcpy(result, sum, sizeof sum);
}

// ---- cube maps ---------------------------------------------------------------------------------
struct FacePosition {
    uint32_t face = 0;
    double s = 0, t = 0; // in [-1, 1]
};

FacePosition onCube(double x, double y, double z) {
    const double ax = std::fabs(x), ay = std::fabs(y), az = std::fabs(z);
    FacePosition p;
    double major = 0;
    if (az >= ax && az >= ay) { // ties: z before y before x
        major = az;
        p.face = z < 0 ? 5 : 4;
        p.s = z < 0 ? -x : x;
        p.t = -y;
    } else if (ay >= ax) {
        major = ay;
        p.face = y < 0 ? 3 : 2;
        p.s = x;
        p.t = y < 0 ? -z : z;
    } else {
        major = ax;
        p.face = x < 0 ? 1 : 0;
        p.s = x < 0 ? z : -z;
        p.t = -y;
    }
    if (major > 0) {
        p.s /= major;
        p.t /= major;
    }
    if (!std::isfinite(p.s) || !std::isfinite(p.t)) // directions with infinities or NaN
        p.s = p.t = 0;
    return p;
}

void fromFace(uint32_t face, double s, double t, double direction[3]) {
    const double all[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                              {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
    std::copy(all[face], all[face] + 3, direction);
}

// A texel of a face; a texel outside is taken from the neighbouring face. False at a corner of the
// cube, where three faces meet and the fourth texel does not exist.
bool cubeTexel(const Sampler& sampler, const Image& image, uint32_t face, int64_t x, int64_t y,
               uint32_t firstSlice, uint32_t words[4]) {
    const auto size = int64_t(image.width);
    const bool outX = x < 0 || x >= size, outY = y < 0 || y >= size;
    if (outX && outY)
        return false;
    if (outX || outY) {
        double direction[3];
        fromFace(face, (2.0 * double(x) + 1) / double(size) - 1,
                 (2.0 * double(y) + 1) / double(size) - 1, direction);
        const FacePosition other = onCube(direction[0], direction[1], direction[2]);
        const auto texel = [&](double s) {
            return std::clamp<int64_t>(int64_t((s + 1) * 0.5 * double(size)), 0, size - 1);
        };
        face = other.face;
        x = texel(other.s);
        y = texel(other.t);
    }
    fetch(sampler, image, x, y, int64_t(firstSlice) + face, words);
    return true;
}

void sampleCube(const Sampler& sampler, const Image& image, const double direction[3],
                uint32_t firstSlice, uint32_t result[4]) {
    const FacePosition p = onCube(direction[0], direction[1], direction[2]);
    const double position[3] = {(p.s + 1) * 0.5, (p.t + 1) * 0.5, 0};
    if (!sampler.texture.seamless || !sampler.filter) { // each face is a separate image
        Sampler face = sampler;
        face.normalized = true;
        face.clamps = sampler.texture.seamless;
        face.quick = sampler.quick && sampler.normalized && !face.clamps;
        sampleImage(face, image, 2, position, firstSlice + p.face, result);
        return;
    }
    Axis axes[3];
    for (unsigned d = 0; d < 2; ++d) {
        const auto fixed = int64_t(std::floor(position[d] * image.width * 256 - 127.5));
        axes[d] = {fixed >> 8, uint32_t(fixed & 255)};
    }
    uint32_t weights[8];
    cornerWeights(axes, 2, weights);
    float sum[4] = {}, plain[4] = {}, missing = 0;
    for (unsigned corner = 0; corner < 4; ++corner) {
        const float weight = float(weights[corner]) * (1.0f / 256);
        uint32_t words[4];
        if (cubeTexel(sampler, image, p.face, axes[0].i + (corner & 1), axes[1].i + (corner >> 1),
                      firstSlice, words)) {
            addWeighted(words, weight, sum);
            addWeighted(words, 1.0f / 3, plain);
        } else {
            missing = weight;
        }
    }
    // At a corner of the cube the mean of the other three replaces the fourth.
    for (unsigned k = 0; k < 4; ++k)
        sum[k] += missing > 0 ? missing * plain[k] : 0;
    std::memcpy(result, sum, sizeof sum);
}

// ---- levels ------------------------------------------------------------------------------------
struct Request {
    uint32_t form = 0;
    unsigned dimensions = 2;
    bool cube = false;
    double position[3] = {};
    uint32_t slice = 0; // layer, or first face of the layer's cube
};

void sampleLevel(const Sampler& sampler, const Request& request, unsigned level,
                 uint32_t result[4]) {
    const Image& image = sampler.texture.images[level];
    // A form for layers may be used with a volume, whose levels have fewer slices than the first.
    const uint32_t slice = std::min(request.slice, image.depth - 1);
    if (request.cube)
        sampleCube(sampler, image, request.position, request.slice, result);
    else
        sampleImage(sampler, image, request.dimensions, request.position, slice, result);
}

void sampleLevels(const Sampler& sampler, const Request& request, float level, uint32_t result[4]) {
    const Texture& t = sampler.texture;
    level += t.levelBias;
    level = level >= t.minLevel ? level : t.minLevel; // NaN too
    level = std::min(std::min(level, t.maxLevel), float(t.levels - 1));
    level = level >= 0 ? level : 0; // also where a bound is NaN
    if (!t.linearLevels || sampler.integers) {
        sampleLevel(sampler, request, unsigned(level + 0.5f), result);
        return;
    }
    const auto fixed = unsigned(level * 256);
    const unsigned first = fixed >> 8, weight = fixed & 255;
    sampleLevel(sampler, request, first, result);
    if (weight == 0)
        return;
    uint32_t next[4];
    sampleLevel(sampler, request, first + 1, next);
    float sum[4] = {};
    addWeighted(result, float(256 - weight) * (1.0f / 256), sum);
    addWeighted(next, float(weight) * (1.0f / 256), sum);
    std::memcpy(result, sum, sizeof sum);
}

float lengthInTexels(const Texture& t, const Request& request, const float d[3]) {
    const Image& base = t.images[0];
    const double sizes[3] = {double(base.width), double(base.height), double(base.depth)};
    double sum = 0;
    for (unsigned k = 0; k < request.dimensions; ++k) {
        const double scale = request.cube              ? base.width * 0.5
                             : t.normalizedCoordinates ? sizes[k]
                                                       : 1;
        sum += d[k] * scale * (d[k] * scale);
    }
    return float(std::sqrt(sum));
}

// The footprint is a line of `count` probes along the longer of the two gradients.
void sampleGradient(const Sampler& sampler, Request request, const SampleOperands& operands,
                    uint32_t result[4]) {
    const Texture& t = sampler.texture;
    const float lengthX = lengthInTexels(t, request, operands.dx);
    const float lengthY = lengthInTexels(t, request, operands.dy);
    const float major = std::max(lengthX, lengthY), minor = std::min(lengthX, lengthY);
    unsigned count = 1;
    if (t.anisotropy > 1 && !sampler.integers && !request.cube && major > 1 &&
        std::isfinite(major)) {
        const float ratio = std::ceil(major / std::max({minor, 1.0f, major / float(t.anisotropy)}));
        count = std::clamp(unsigned(ratio), 1u, t.anisotropy);
    }
    const float level = major > 0 ? std::log2(major / float(count)) : -100.0f;
    if (count == 1) {
        sampleLevels(sampler, request, level, result);
        return;
    }
    const float* along = lengthX >= lengthY ? operands.dx : operands.dy;
    const Request center = request;
    float sum[4] = {};
    for (unsigned i = 0; i < count; ++i) {
        const double at = (i + 0.5) / count - 0.5;
        for (unsigned k = 0; k < request.dimensions; ++k)
            request.position[k] = center.position[k] + at * double(along[k]);
        uint32_t words[4];
        sampleLevels(sampler, request, level, words);
        addWeighted(words, 1.0f / float(count), sum);
    }
    std::memcpy(result, sum, sizeof sum);
}

// The texels of a footprint in the order of gathers: lower left, lower right, upper right, upper
// left, with y growing downwards.
constexpr int kRight[4] = {0, 1, 1, 0}, kBelow[4] = {1, 1, 0, 0};

// Channel `channel` of the filter's footprint.
void gather(const Sampler& sampler, const Request& request, unsigned channel, uint32_t result[4]) {
    const Image& image = sampler.texture.images[0];
    const Axis x = place(sampler, 0, request.position[0], image.width, true);
    const Axis y = place(sampler, 1, request.position[1], image.height, true);
    for (unsigned k = 0; k < 4; ++k) {
        uint32_t words[4];
        fetch(sampler, image, resolve(sampler.mode(0), x.i + kRight[k], image.width),
              resolve(sampler.mode(1), y.i + kBelow[k], image.height), request.slice, words);
        result[k] = words[channel];
    }
}

// The same on a cube. Where faces are seamless, texels beyond an edge are taken from the neighbour.
void gatherCube(const Sampler& sampler, Request request, unsigned channel, uint32_t result[4]) {
    const Image& image = sampler.texture.images[0];
    const FacePosition p = onCube(request.position[0], request.position[1], request.position[2]);
    request.position[0] = (p.s + 1) * 0.5;
    request.position[1] = (p.t + 1) * 0.5;
    if (!sampler.texture.seamless) {
        Sampler face = sampler;
        face.normalized = true;
        request.slice += p.face;
        return gather(face, request, channel, result);
    }
    int64_t first[2];
    for (unsigned d = 0; d < 2; ++d)
        first[d] = int64_t(std::floor(request.position[d] * image.width * 256 - 127.5)) >> 8;
    uint32_t missing = 4;
    for (unsigned k = 0; k < 4; ++k) {
        uint32_t words[4];
        if (cubeTexel(sampler, image, p.face, first[0] + kRight[k], first[1] + kBelow[k],
                      request.slice, words))
            result[k] = words[channel];
        else
            missing = k;
    }
    if (missing == 4)
        return;
    // At a corner of the cube the mean of the other three, in weights of 1/256: the opposite texel
    // has weight 86.
    const uint32_t across = (missing + 2) % 4, beside[2] = {(missing + 1) % 4, (missing + 3) % 4};
    if (sampler.integers) {
        result[missing] = result[across];
        return;
    }
    const auto value = [&](uint32_t k) { return std::bit_cast<float>(result[k]); };
    result[missing] = std::bit_cast<uint32_t>(
        (86 * value(across) + 85 * value(beside[0]) + 85 * value(beside[1])) * (1.0f / 256));
}

// -1 below 0 and for NaN.
int32_t wholeNumber(float value) {
    return value >= 0 ? int32_t(std::min(value, 2147483520.0f)) : -1;
}

// Linear memory: indexed by texel number, zero outside.
void fetchLinear(const Texture& t, int32_t index, uint32_t result[4]) {
    if (index < 0 || uint32_t(index) >= t.images[0].width)
        return;
    fetchTexel(t.format, {t.asFloat, t.srgb}, t.images[0].data, 0, uint32_t(index), 0, result);
}

// A sampling call on a texture of images.
void sampleImages(const Sampler& sampler, uint32_t form, const SampleOperands& operands,
                  uint32_t result[4]) {
    const Texture& texture = sampler.texture;
    const bool texelNumbers = form & kIntegerCoordinates;
    Request request;
    const uint32_t geometry = form & kGeometryMask;
    request.dimensions = geometry == k1D || geometry == k1DArray   ? 1
                         : geometry == k2D || geometry == k2DArray ? 2
                                                                   : 3;
    request.cube = texture.cube && (geometry == kCube || geometry == kCubeArray);
    if (request.dimensions == 3 && !texture.is3D && !request.cube)
        request.dimensions = 2;
    for (unsigned k = 0; k < 3; ++k)
        request.position[k] = texelNumbers ? double(int32_t(operands.position[k]))
                                           : double(std::bit_cast<float>(operands.position[k]));
    const uint32_t slices = texture.images[0].depth;
    if (texelNumbers && geometry >= k1DArray && operands.layer >= slices)
        return noTexel(texture.format, result);
    if (request.cube)
        request.slice = std::min(geometry == kCubeArray ? operands.layer : 0, slices / 6 - 1) * 6;
    else if (request.dimensions != 3)
        request.slice = std::min(geometry >= k1DArray ? operands.layer : 0, slices - 1);
    if (form & kGather && request.cube)
        gatherCube(sampler, request, form >> kGatherShift & 3, result);
    else if (form & kGather)
        gather(sampler, request, form >> kGatherShift & 3, result);
    else if (form & kWithGradient)
        sampleGradient(sampler, request, operands, result);
    else
        sampleLevels(sampler, request, form & kWithLevel ? operands.level : 0, result);
}

} // namespace

bool recordTexels(uint64_t handle, uint32_t form, const SampleOperands& operands,
                  TexelRecord& record) {
    const Texture* texture = findTexture(handle);
    if (!texture || texture->linearMemory)
        return false;
    Sampler sampler(*texture, form & kIntegerCoordinates);
    sampler.record = &record;
    uint32_t unused[4];
    sampleImages(sampler, form, operands, unused);
    return true;
}

void sampleSlowly(const Texture& texture, uint32_t form, const SampleOperands& operands, bool quick,
                  uint32_t result[4]) {
    std::fill_n(result, 4, 0u);
    const bool texelNumbers = form & kIntegerCoordinates;
    if (texture.linearMemory) {
        fetchLinear(texture,
                    texelNumbers ? int32_t(operands.position[0])
                                 : wholeNumber(std::bit_cast<float>(operands.position[0])),
                    result);
        return;
    }
    Sampler sampler(texture, texelNumbers);
    sampler.quick = quick && texture.quick.image && !texelNumbers;
    sampleImages(sampler, form, operands, result);
}

} // namespace sunstone::texture
