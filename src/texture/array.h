// SPDX-License-Identifier: Apache-2.0
// CUDA arrays as blocks of host memory: texel formats and layout. Rows are stored one after
// another, slices (of depth, layers, faces) after rows; texels have their natural size. Mip levels
// are arrays of their own. Read next: texture.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sunstone::texture {

// The storage of one channel. Block formats hold 4 x 4 texels in one block.
enum class Channel : uint8_t {
    kU8,
    kU16,
    kU32,
    kS8,
    kS16,
    kS32,
    kF16,
    kF32,
    kBC1,
    kBC2,
    kBC3,
    kBC4U,
    kBC4S,
    kBC5U,
    kBC5S,
    kBC6U,
    kBC6S,
    kBC7,
};

struct Format {
    Channel channel = Channel::kU8;
    uint8_t channels = 1;    // 1, 2 or 4; unused for block formats
    bool normalized = false; // always read as numbers in [0, 1] or [-1, 1]
    bool srgb = false;       // the first three channels are sRGB regardless of the texture

    bool isBlock() const { return channel >= Channel::kBC1; }
    bool isInteger() const { return channel < Channel::kF16; }
    unsigned channelBytes() const; // 0 for block formats
    unsigned elementBytes() const; // of a texel, or of a block
    // Texels along one edge of an element.
    unsigned edge() const { return isBlock() ? 4 : 1; }
};

struct Shape {
    uint32_t width = 0;
    uint32_t height = 0; // 0: one-dimensional
    uint32_t depth = 0;  // 0: not three-dimensional; layers or faces, according to the flags
    bool layered = false;
    bool cube = false;

    uint32_t rows() const { return height ? height : 1; }
    uint32_t slices() const { return depth ? depth : 1; }
};

// The memory of one level's texels.
struct Image {
    const uint8_t* data = nullptr;
    uint32_t width = 1, height = 1, depth = 1; // in texels; depth counts layers and faces
    size_t rowPitch = 0, slicePitch = 0;       // bytes; of a row of blocks for block formats
};

// The allocator of arrays. `allocate` returns zeros, or throws; `free` may be called from any
// thread.
struct ArrayMemory {
    void* (*allocate)(size_t bytes);
    void (*free)(void* data);
};
extern const ArrayMemory kHeapMemory;

class Array {
public:
    // Zero-filled. Throws Error(kOutOfMemory).
    Array(Format format, Shape shape, const ArrayMemory& memory = kHeapMemory);
    ~Array();
    Array(const Array&) = delete;
    Array& operator=(const Array&) = delete;

    const Format& format() const { return format_; }
    const Shape& shape() const { return shape_; }
    uint8_t* data() { return data_; }
    // Bytes of a row; rows and slices follow each other without gaps.
    size_t rowPitch() const { return rowPitch_; }
    size_t slicePitch() const { return rowPitch_ * rowCount_; }
    size_t rowCount() const { return rowCount_; } // of blocks for block formats
    size_t bytes() const { return slicePitch() * shape_.slices(); }
    Image image() const;

private:
    Format format_;
    Shape shape_;
    const ArrayMemory memory_;
    size_t rowPitch_ = 0, rowCount_ = 0;
    uint8_t* data_ = nullptr;
};

// The number of levels that an array of this shape can have, down to one texel.
unsigned mostLevels(const Shape& shape);
Shape shapeOfLevel(const Shape& shape, unsigned level);

} // namespace sunstone::texture
