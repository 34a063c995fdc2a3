// SPDX-License-Identifier: Apache-2.0
// Reference pictures of the hard scenes: 4,096 samples a pixel, with the classes of their pixels.
#pragma once

#include "hard_scenes.h"

#include <array>
#include <string>

namespace hard {

constexpr uint32_t kWidth = 96, kHeight = 72;

// A pixel may be in several classes.
enum class Class : unsigned { kAll, kDark, kBright, kEdges, kTextures, kNearLamps, kCount };
constexpr unsigned kClassCount = unsigned(Class::kCount);
extern const std::array<const char*, kClassCount> kClassNames;

struct Reference {
    Picture color;
    std::vector<uint8_t> classes; // a bit for each class

    bool has(size_t pixel, Class which) const { return classes[pixel] >> unsigned(which) & 1; }
};

Reference renderReference(const Scene& scene, uint32_t samples);
// The file has three halves and a byte of classes for each pixel. Both throw std::runtime_error.
void saveReference(const Reference& reference, const std::string& path);
Reference loadReference(const std::string& path);

} // namespace hard
