// SPDX-License-Identifier: Apache-2.0
// See array.h.
#include "texture/array.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace sunstone::texture {

namespace {

// Memory behind the texels, so that one texel can be read as a whole vector.
constexpr size_t kSlack = 64;

} // namespace

unsigned Format::channelBytes() const {
    switch (channel) {
    case Channel::kU8:
    case Channel::kS8:
        return 1;
    case Channel::kU16:
    case Channel::kS16:
    case Channel::kF16:
        return 2;
    case Channel::kU32:
    case Channel::kS32:
    case Channel::kF32:
        return 4;
    default:
        return 0;
    }
}

unsigned Format::elementBytes() const {
    switch (channel) {
    case Channel::kBC1:
    case Channel::kBC4U:
    case Channel::kBC4S:
        return 8;
    case Channel::kBC2:
    case Channel::kBC3:
    case Channel::kBC5U:
    case Channel::kBC5S:
    case Channel::kBC6U:
    case Channel::kBC6S:
    case Channel::kBC7:
        return 16;
    default:
        return channelBytes() * channels;
    }
}

const ArrayMemory kHeapMemory = {[](size_t bytes) {
                                     void* const data = std::calloc(bytes, 1);
                                     if (!data)
                                         fail(Code::kOutOfMemory, "no memory for an array of ",
                                              bytes, " bytes");
                                     return data;
                                 },
                                 std::free};

Array::Array(Format format, Shape shape, const ArrayMemory& memory)
    : format_(format), shape_(shape), memory_(memory) {
    const size_t edge = format.edge();
    rowPitch_ = (size_t(shape.width) + edge - 1) / edge * format.elementBytes();
    rowCount_ = (size_t(shape.rows()) + edge - 1) / edge;
    size_t slice = 0, total = 0;
    if (__builtin_mul_overflow(rowPitch_, rowCount_, &slice) ||
        __builtin_mul_overflow(slice, size_t(shape.slices()), &total) ||
        __builtin_add_overflow(total, kSlack, &total))
        fail(Code::kOutOfMemory, "an array of ", shape.width, " x ", shape.rows(), " x ",
             shape.slices(), " texels");
    data_ = static_cast<uint8_t*>(memory_.allocate(total));
}

Array::~Array() {
    memory_.free(data_);
}

Image Array::image() const {
    return {data_, shape_.width, shape_.rows(), shape_.slices(), rowPitch_, slicePitch()};
}

unsigned mostLevels(const Shape& shape) {
    uint32_t size = std::max(shape.width, shape.rows());
    if (!shape.layered && !shape.cube)
        size = std::max(size, shape.slices());
    return unsigned(std::bit_width(size));
}

Shape shapeOfLevel(const Shape& shape, unsigned level) {
    const auto smaller = [&](uint32_t size) { return size ? std::max(1u, size >> level) : 0; };
    Shape result = shape;
    result.width = smaller(shape.width);
    result.height = smaller(shape.height);
    if (!shape.layered && !shape.cube)
        result.depth = smaller(shape.depth);
    return result;
}

} // namespace sunstone::texture
