// SPDX-License-Identifier: Apache-2.0
// Conformance vectors of textures and surfaces: the objects, their contents, and the reads. A case
// is one object and one PTX instruction; its vectors are coordinates, levels and gradients.
// texture_run.cpp makes the objects and kernels.
#pragma once

#include <cuda.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace conformance {

constexpr unsigned kTextureVectors = 192;

struct TextureFormat {
    const char* name;
    unsigned value;    // CUarray_format
    unsigned channels; // as the driver counts them
    // u s: integers, n m: unsigned and signed fractions, h f: floats, b: 4 x 4 blocks
    char kind;
    unsigned bytes; // of a texel, or of a block
};

struct TextureCase {
    std::string name;
    TextureFormat format;
    unsigned width = 16, height = 0, depth = 0, levels = 1, arrayFlags = 0;
    CUDA_TEXTURE_DESC sampling = {};
    // The instruction ("tex.level.2d.v4.f32.f32", "tld4.r.2d.v4.f32.f32", "suld.b.2d.v4.b32.clamp",
    // "txq.width.b32"); a store is followed by a load of the stored data.
    std::string access;
    double bound = 0; // how far floats may be apart; 0: bit by bit
    // Of all words, this share may be further apart: up to this much.
    double share = 0, most = 0;
    bool isSurface() const { return access.starts_with("su"); }
    bool has(const char* part) const { return access.find(part) != std::string::npos; }
};

// The operands of one vector, as 32-bit words: three coordinates, layer, level, two gradients of
// three, one spare.
constexpr unsigned kTextureWords = 12;
using TextureVector = std::array<uint32_t, kTextureWords>;

const std::vector<TextureCase>& allTextureCases();
TextureVector textureVector(const TextureCase& test, unsigned index);
// The bytes of one level of the array.
std::vector<uint8_t> textureContent(const TextureCase& test, unsigned level);
// The kernel that runs the instruction on each vector: (handle, vectors, results of four words).
std::string textureKernel(const TextureCase& test);

} // namespace conformance
