// SPDX-License-Identifier: Apache-2.0
// Functions that compiled device code calls to read textures and to address the texels of surfaces.
// One parameter of each call encodes the form of the instruction. No function throws.
#pragma once

#include <cstdint>

namespace sunstone::texture {

enum Geometry : uint32_t { k1D, k2D, k3D, k1DArray, k2DArray, kCube, kCubeArray };

// Bits of the form of a sampling call.
constexpr uint32_t kGeometryMask = 7;
constexpr uint32_t kIntegerCoordinates = 1 << 3; // texel numbers, s32
constexpr uint32_t kWithLevel = 1 << 4;
constexpr uint32_t kWithGradient = 1 << 5;
constexpr uint32_t kGather = 1 << 6; // one channel of the four texels of a footprint
constexpr uint32_t kGatherShift = 7; // which channel: two bits

// Operands of a sampling call, as 32-bit words.
struct SampleOperands {
    uint32_t position[3]; // float, or s32 with kIntegerCoordinates
    uint32_t layer;
    float level;
    float dx[3], dy[3]; // change of the position, with kWithGradient
};

// Four words: floats, or integers where the texture holds integers and is not read as float.
void sample(uint64_t handle, uint32_t form, const SampleOperands* operands, uint32_t result[4]);

// The start of a texture's texels if they are memory of the application. Null for textures of
// arrays, whose memory the texture keeps alive, and for handles that are not textures.
const void* linearMemory(uint64_t handle);

// optixTexFootprint2D and its variants: the groups of texels that the sampling call reads
// (footprint.cpp). info: the tile size in bits 20-23 and 16-19. *singleLevel: whether the call
// reads one level only; if not, `coarse` selects the level. A handle that is not a texture of
// images gives an empty mask.
void footprint(uint64_t handle, uint32_t info, uint32_t form, const SampleOperands* operands,
               uint32_t coarse, uint32_t* singleLevel, uint32_t result[4]);

// txq. The result for an unknown handle is 0.
enum Query : uint32_t {
    kQueryWidth,
    kQueryHeight,
    kQueryDepth,
    kQueryArraySize,
    kQueryLevels,
    kQueryChannelType,
    kQueryChannelOrder,
    kQueryNormalized,
    kQuerySamples,
    kQueryFilter,
    kQueryAddress0,
    kQueryAddress1,
    kQueryAddress2,
};
uint32_t queryTexture(uint64_t handle, uint32_t query, uint32_t level);
uint32_t querySurface(uint64_t handle, uint32_t query);

// The form of an access to a surface: the geometry and these bits.
constexpr uint32_t kBytesShift = 3;     // bytes of the access, five bits
constexpr uint32_t kClamp = 1 << 8;     // coordinates outside are clamped
constexpr uint32_t kFormatted = 1 << 9; // x counts texels, not bytes
// The address of a texel; null outside, and if the handle is not a surface.
void* surfaceAddress(uint64_t handle, uint32_t form, int32_t x, int32_t y, int32_t z,
                     uint32_t layer);

// Formatted access (suld.p, sust.p): converts four words to and from the texel's format.
void loadTexel(uint64_t handle, const void* texel, uint32_t values[4]);
void storeTexel(uint64_t handle, void* texel, const uint32_t values[4], uint32_t count);

// Formatted reduction (sured.p) of the word or double word that contains the texel.
enum class Reduction : uint32_t { kAdd, kMinimum, kMaximum, kAnd, kOr };
void reduceTexel(uint64_t handle, void* texel, uint32_t reduction, uint32_t bytes, uint64_t value);

} // namespace sunstone::texture
