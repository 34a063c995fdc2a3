// SPDX-License-Identifier: Apache-2.0
// Surfaces: the address of a texel, formatted access, and queries about textures and surfaces.
#include "texture/device_functions.h"

#include "base/log.h"
#include "texture/fetch.h"
#include "texture/texture.h"

#include <algorithm>
#include <atomic>
#include <cstring>

namespace sunstone::texture {

namespace {

// Values of channel_data_type and channel_order, as OpenCL numbers them.
uint32_t channelType(const Format& format, bool asFloat) {
    switch (format.channel) {
    case Channel::kS8:
        return asFloat ? 0x10D0 : 0x10D7;
    case Channel::kS16:
        return asFloat ? 0x10D1 : 0x10D8;
    case Channel::kU8:
        return asFloat ? 0x10D2 : 0x10DA;
    case Channel::kU16:
        return asFloat ? 0x10D3 : 0x10DB;
    case Channel::kS32:
        return 0x10D9;
    case Channel::kU32:
        return 0x10DC;
    case Channel::kF16:
        return 0x10DD;
    case Channel::kF32:
        return 0x10DE;
    default:
        return 0x10D2;
    }
}
uint32_t channelOrder(const Format& format) {
    return format.channels == 1 ? 0x10B0 : format.channels == 2 ? 0x10B2 : 0x10B5;
}

bool clampInto(int64_t& value, int64_t count, bool clamp) {
    if (value >= 0 && value < count)
        return true;
    value = value < 0 ? 0 : count - 1;
    return clamp;
}

} // namespace

void* surfaceAddress(uint64_t handle, uint32_t form, int32_t x, int32_t y, int32_t z,
                     uint32_t layer) {
    const Surface* surface = findSurface(handle);
    if (!surface) {
        logOnce(LogLevel::kError, "texture", "a program uses a surface whose handle is not alive");
        return nullptr;
    }
    Array& array = *surface->array;
    const Shape& shape = array.shape();
    const int64_t element = array.format().elementBytes();
    const bool clamp = form & kClamp;
    const int64_t access = form & kFormatted ? element : form >> kBytesShift & 31;
    int64_t byte = form & kFormatted ? int64_t(x) * element : int64_t(x);
    int64_t row = 0, slice = 0;
    switch (form & kGeometryMask) {
    case k1D:
        break;
    case k1DArray:
        slice = layer;
        break;
    case k2D:
        row = y;
        break;
    case k3D:
        row = y;
        slice = z;
        break;
    case kCube:
        row = y;
        slice = z;
        break;
    case kCubeArray: // the face is part of the layer's number
    case k2DArray:
        row = y;
        slice = layer;
        break;
    default:
        return nullptr;
    }
    const auto rowBytes = int64_t(array.rowPitch());
    if (byte < 0 || byte + access > rowBytes) {
        if (!clamp || access > rowBytes)
            return nullptr;
        byte = byte < 0 ? 0 : rowBytes - access;
    }
    if (!clampInto(row, shape.rows(), clamp) || !clampInto(slice, shape.slices(), clamp))
        return nullptr;
    return array.data() + size_t(slice) * array.slicePitch() + size_t(row) * array.rowPitch() +
           size_t(byte);
}

void loadTexel(uint64_t handle, const void* texel, uint32_t values[4]) {
    values[0] = values[1] = values[2] = values[3] = 0;
    const Surface* surface = findSurface(handle);
    if (surface && texel)
        fetchTexel(surface->array->format(), {}, static_cast<const uint8_t*>(texel), 0, 0, 0,
                   values);
}

void storeTexel(uint64_t handle, void* texel, const uint32_t values[4], uint32_t count) {
    const Surface* surface = findSurface(handle);
    if (!surface || !texel)
        return;
    Format format = surface->array->format();
    format.channels = uint8_t(std::min<uint32_t>(format.channels, count));
    storeWords(format, static_cast<uint8_t*>(texel), values);
}

namespace {

template <class T>
void reduce(void* texel, Reduction reduction, T value) {
    // A texel between words: the word that contains it.
    std::atomic_ref<T> word(
        *reinterpret_cast<T*>(reinterpret_cast<uintptr_t>(texel) & ~uintptr_t(sizeof(T) - 1)));
    if (reduction == Reduction::kAdd) {
        word.fetch_add(value, std::memory_order_relaxed);
    } else if (reduction == Reduction::kAnd) {
        word.fetch_and(value, std::memory_order_relaxed);
    } else if (reduction == Reduction::kOr) {
        word.fetch_or(value, std::memory_order_relaxed);
    } else {
        T old = word.load(std::memory_order_relaxed);
        while ((reduction == Reduction::kMinimum ? value < old : value > old) &&
               !word.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
        }
    }
}

} // namespace

void reduceTexel(uint64_t handle, void* texel, uint32_t reduction, uint32_t bytes, uint64_t value) {
    const Surface* surface = findSurface(handle);
    if (!surface || !texel)
        return;
    const Channel channel = surface->array->format().channel;
    const bool isSigned =
        channel == Channel::kS8 || channel == Channel::kS16 || channel == Channel::kS32;
    const auto what = Reduction(reduction);
    if (bytes == 8)
        isSigned ? reduce(texel, what, int64_t(value)) : reduce(texel, what, value);
    else
        isSigned ? reduce(texel, what, int32_t(value)) : reduce(texel, what, uint32_t(value));
}

uint32_t queryTexture(uint64_t handle, uint32_t query, uint32_t level) {
    const Texture* t = findTexture(handle);
    if (!t) {
        logOnce(LogLevel::kError, "texture",
                "a program asks about a texture whose handle is not alive");
        return 0;
    }
    const Image& image = t->images[std::min(level, t->levels - 1)];
    switch (query) {
    case kQueryWidth:
        return image.width;
    case kQueryHeight:
        return image.height;
    case kQueryDepth:
        return t->is3D ? image.depth : 1;
    case kQueryArraySize:
        return t->is3D ? 0 : t->cube ? image.depth / 6 : image.depth;
    case kQueryLevels:
        return t->levels;
    case kQueryChannelType:
        return channelType(t->format, t->asFloat);
    case kQueryChannelOrder:
        return channelOrder(t->format);
    case kQueryNormalized:
        return t->normalizedCoordinates;
    case kQuerySamples:
        return 1;
    case kQueryFilter:
        return t->linear;
    case kQueryAddress0:
    case kQueryAddress1:
    case kQueryAddress2:
        return uint32_t(t->address[query - kQueryAddress0]);
    default:
        return 0;
    }
}

uint32_t querySurface(uint64_t handle, uint32_t query) {
    const Surface* surface = findSurface(handle);
    if (!surface) {
        logOnce(LogLevel::kError, "texture",
                "a program asks about a surface whose handle is not alive");
        return 0;
    }
    const Shape& shape = surface->array->shape();
    const bool sliced = shape.layered || shape.cube;
    switch (query) {
    case kQueryWidth:
        return shape.width;
    case kQueryHeight:
        return shape.rows();
    case kQueryDepth:
        return sliced ? 1 : shape.slices();
    case kQueryArraySize:
        return sliced ? shape.slices() : 1;
    case kQueryChannelType:
        return channelType(surface->array->format(), false);
    case kQueryChannelOrder:
        return channelOrder(surface->array->format());
    default:
        return 0;
    }
}

} // namespace sunstone::texture
