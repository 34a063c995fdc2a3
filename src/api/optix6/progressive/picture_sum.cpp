// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/progressive/picture_sum.h"

#include "base/threads/threads.h"

#include <algorithm>
#include <cmath>

namespace sunstone::optix6 {

namespace {

constexpr size_t kGrain = 1 << 14; // pixels

} // namespace

// Computes one power for each byte instead of each pixel. A cell gives the start of the search.
ToneMap::ToneMap(float gamma) {
    limits_[0] = 0;
    for (unsigned byte = 1; byte < 256; ++byte)
        limits_[byte] = std::pow((byte - 0.5) / 255.0, double(gamma));
    unsigned byte = 0;
    for (unsigned cell = 0; cell <= kCells; ++cell) {
        while (byte < 255 && limits_[byte + 1] <= double(cell) / kCells)
            ++byte;
        start_[cell] = uint8_t(byte);
    }
}

uint8_t ToneMap::byteOf(double value) const {
    if (!(value > 0.0)) // also NaN
        return 0;
    const double clamped = std::min(value, 1.0);
    unsigned byte = start_[unsigned(clamped * kCells)];
    while (byte < 255 && limits_[byte + 1] <= clamped)
        ++byte;
    return uint8_t(byte);
}

void PictureSum::add(const float* pixels, unsigned components) {
    parallelFor(values_.size() / 3, kGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            for (unsigned c = 0; c < 3; ++c)
                values_[3 * i + c] += double(pixels[components * i + c]);
    });
    ++count_;
}

void PictureSum::addSum(const float* sum, unsigned count) {
    parallelFor(values_.size(), 3 * kGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            values_[i] += double(sum[i]);
    });
    count_ += count;
}

void PictureSum::clear() {
    std::fill(values_.begin(), values_.end(), 0.0);
    count_ = 0;
}

std::vector<uint8_t> PictureSum::toneMapped(const ToneMap& map) const {
    const size_t pixels = values_.size() / 3;
    std::vector<uint8_t> bytes(4 * pixels);
    const double share = count_ ? 1.0 / count_ : 0.0;
    parallelFor(pixels, kGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            for (unsigned c = 0; c < 3; ++c)
                bytes[4 * i + c] = map.byteOf(values_[3 * i + c] * share);
            bytes[4 * i + 3] = 255;
        }
    });
    return bytes;
}

} // namespace sunstone::optix6
