// SPDX-License-Identifier: Apache-2.0
// The sum of a picture's subframes, and the 8-bit picture that clients see of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sunstone::optix6 {

// Converts colours to bytes: round(255 * clamp(value, 0, 1)^(1 / gamma)).
class ToneMap {
public:
    explicit ToneMap(float gamma);
    uint8_t byteOf(double value) const;

private:
    static constexpr unsigned kCells = 1024;
    double limits_[256];        // the least value of each byte
    uint8_t start_[kCells + 1]; // the byte of each cell's least value
};

// Sums have double precision, so that their order has no visible effect in a picture of floats.
class PictureSum {
public:
    explicit PictureSum(size_t pixels) : values_(3 * pixels) {}
    // Adds a subframe. `components` of a pixel: 3, or 4 with the last one unused.
    void add(const float* pixels, unsigned components);
    // Adds the sum of `count` other subframes, with three components.
    void addSum(const float* sum, unsigned count);
    void clear();
    unsigned count() const { return count_; } // of subframes
    const std::vector<double>& values() const { return values_; }
    // Red, green, blue and an opaque alpha of each pixel's mean.
    std::vector<uint8_t> toneMapped(const ToneMap& map) const;

private:
    std::vector<double> values_;
    unsigned count_ = 0;
};

} // namespace sunstone::optix6
