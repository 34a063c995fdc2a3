// SPDX-License-Identifier: Apache-2.0
// Texture and surface objects and the table of their handles. A handle is a number, looked up at
// every use by device code, so stale and invalid handles read as zero. Objects share their arrays'
// memory: destroying an array before its textures is safe. The application must not destroy an
// object while a program uses it; the API shells wait for queued work first. Read next:
// device_functions.h, sample.cpp.
#pragma once

#include "texture/array.h"

namespace sunstone::texture {

enum class Address : uint8_t { kWrap, kClamp, kMirror, kBorder };

constexpr unsigned kMaxLevels = 32;

struct SampleOperands;
struct Texture;

// Sampling by functions of the format's own; see quick.h. `add` fills it in.
struct QuickSampling {
    // Samples one level. False: nothing is written, and the generic code must handle the call.
    bool (*image)(const Texture& texture, const Image& image, unsigned dimensions, double x,
                  double y, double z, uint32_t slice, uint32_t result[4]) = nullptr;
    // A sampling call whose form has none of `otherForms`, which need more than one sample of the
    // first level.
    void (*call)(const Texture& texture, uint32_t form, const SampleOperands& operands,
                 uint32_t result[4]) = nullptr;
    uint32_t otherForms = ~0u;
    const float* fromSrgb = nullptr; // a number for each of 256 values
};

struct Texture {
    Format format;
    QuickSampling quick;
    unsigned levels = 1;
    Image images[kMaxLevels];
    bool layered = false;
    bool cube = false;
    bool is3D = false;
    bool hasLines = false; // layers of one dimension: GPUs need this; on CPUs each call states it
    bool linearMemory = false; // indexed by integers alone
    Address address[3] = {Address::kWrap, Address::kWrap, Address::kWrap};
    bool linear = false;       // filter between texels
    bool linearLevels = false; // filter between levels
    bool normalizedCoordinates = false;
    bool asFloat = false; // integers read as numbers in [0, 1] or [-1, 1]
    bool srgb = false;
    bool seamless = false; // filters reach over the edges of cube faces
    float levelBias = 0, minLevel = 0, maxLevel = 0;
    unsigned anisotropy = 1;
    float border[4] = {};

    std::vector<std::shared_ptr<Array>> arrays; // keeps images alive
};

struct Surface {
    std::shared_ptr<Array> array;
};

// Registers an object; never 0.
uint64_t add(std::unique_ptr<Texture> texture);
uint64_t add(std::unique_ptr<Surface> surface);
// The live object of a handle, or null. Takes a few loads.
const Texture* findTexture(uint64_t handle);
const Surface* findSurface(uint64_t handle);
// False if the handle is not live.
bool removeTexture(uint64_t handle);
bool removeSurface(uint64_t handle);

} // namespace sunstone::texture
