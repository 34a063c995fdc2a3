// SPDX-License-Identifier: Apache-2.0
// Texture samplers without their entry points.
#include "api/optix6/texture_sampler.h"

#include "api/optix6/context.h"
#include "texture/texture.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace sunstone::optix6 {

using texture::Channel;

namespace {

// False if no texture has elements of this format.
bool textureFormat(RTformat format, texture::Format& result) {
    static constexpr struct {
        RTformat first;
        Channel channel;
    } kVectors[] = {{RT_FORMAT_FLOAT, Channel::kF32}, {RT_FORMAT_HALF, Channel::kF16},
                    {RT_FORMAT_BYTE, Channel::kS8},   {RT_FORMAT_UNSIGNED_BYTE, Channel::kU8},
                    {RT_FORMAT_SHORT, Channel::kS16}, {RT_FORMAT_UNSIGNED_SHORT, Channel::kU16},
                    {RT_FORMAT_INT, Channel::kS32},   {RT_FORMAT_UNSIGNED_INT, Channel::kU32}};
    static constexpr Channel kBlocks[] = {
        Channel::kBC1,  Channel::kBC2,  Channel::kBC3,  Channel::kBC4U, Channel::kBC4S,
        Channel::kBC5U, Channel::kBC5S, Channel::kBC6U, Channel::kBC6S, Channel::kBC7};
    for (const auto& [first, channel] : kVectors)
        for (unsigned channels = 1; channels <= 4; ++channels)
            if (unsigned(format) == unsigned(first) + channels - 1) {
                result.channel = channel;
                result.channels = uint8_t(channels);
                return true;
            }
    if (format < RT_FORMAT_UNSIGNED_BC1 || format > RT_FORMAT_UNSIGNED_BC7)
        return false;
    result.channel = kBlocks[format - RT_FORMAT_UNSIGNED_BC1];
    return true;
}

// `data`: elements of the buffer, in this format.
texture::Image imageOf(const Buffer& buffer, const uint8_t* data, const texture::Format& format,
                       unsigned level) {
    texture::Image image;
    const uint64_t width = buffer.extent(0, level), height = buffer.extent(1, level);
    image.data =
        data + buffer.levelOffset(level) / buffer.view().elementBytes * format.elementBytes();
    image.width = uint32_t(width * format.edge());
    image.height = buffer.dimensions > 1 ? uint32_t(height * format.edge()) : 1;
    image.depth = uint32_t(buffer.extent(2, level));
    image.rowPitch = width * format.elementBytes();
    image.slicePitch = image.rowPitch * height;
    return image;
}

// Whether elements need a fourth component: device textures have one, two or four.
bool expands(const texture::Format& format) {
    return !format.isBlock() && format.channels == 3;
}

// Elements of three components with a fourth, which is zero.
void expand(const Buffer& buffer, uint8_t* to) {
    const size_t from = buffer.view().elementBytes, component = from / 3;
    const uint8_t* const data = buffer.data();
    for (size_t i = 0, count = buffer.bytes() / from; i < count; ++i) {
        std::memcpy(to + i * 4 * component, data + i * from, from);
        std::memset(to + i * 4 * component + from, 0, component);
    }
}

} // namespace

TextureSampler::TextureSampler(const std::shared_ptr<Context>& context)
    : Object(kKind, context), backend_(context->engine->backend) {}

TextureSampler::~TextureSampler() {
    if (texture)
        backend_->removeTexture(texture);
    if (id != 0)
        noteIds();
}

void TextureSampler::moveTo(const std::shared_ptr<engine::Backend>& backend) {
    if (gl)
        gl->texels->moveTo(backend);
    if (texture)
        backend_->removeTexture(texture);
    texture = 0;
    expanded_ = {};
    backend_ = backend;
    noteChange();
}

void TextureSampler::validate() const {
    const std::shared_ptr<Buffer> source = buffer.lock();
    if (!source)
        refuse(RT_ERROR_INVALID_CONTEXT, "the texture sampler has no buffer");
    if (gl && !gl->isRegistered)
        refuse(RT_ERROR_INVALID_VALUE, "texture sampler ", handle(), " shares OpenGL image ",
               gl->id, ", which is not registered");
    source->validate();
    texture::Format format;
    if (!textureFormat(source->format, format))
        refuse(RT_ERROR_INVALID_CONTEXT, "no texture has elements of the buffer's format ",
               nameOf(source->format));
    constexpr uint64_t kMostTexels = std::numeric_limits<int32_t>::max(); // programs index them
    for (unsigned i = 0; i < 3; ++i)
        if (const uint64_t texels = source->extent(i, 0); texels > kMostTexels / format.edge())
            refuse(RT_ERROR_INVALID_CONTEXT, "no texture has ", texels,
                   " elements along dimension ", i);
    if (!gl && (mipFilter == RT_FILTER_NONE) != (source->mipLevels == 1))
        refuse(RT_ERROR_INVALID_CONTEXT, "the mipmapping filter does not fit a buffer with ",
               source->mipLevels, " levels");
    const bool asElements =
        readMode == RT_TEXTURE_READ_ELEMENT_TYPE || readMode == RT_TEXTURE_READ_ELEMENT_TYPE_SRGB;
    if (asElements && format.isInteger() && magFilter == RT_FILTER_LINEAR)
        refuse(RT_ERROR_INVALID_CONTEXT,
               "integers cannot be filtered: the read mode is RT_TEXTURE_READ_ELEMENT_TYPE");
}

bool TextureSampler::update(const std::string* variable) {
    const auto refuseIt = [&](RTresult result, const char* what) { // one of many of a launch
        const std::string user =
            variable ? message(" of variable \"", *variable, "\"") : message(" with id ", id);
        refuse(result, "texture sampler ", handle(), user, ": ", what);
    };
    try {
        validate();
    } catch (const Failure& failure) {
        refuseIt(failure.result, failure.what());
    }
    const std::shared_ptr<Buffer> source = buffer.lock();
    texture::Format format;
    textureFormat(source->format, format);
    const bool copies = backend_->copiesImages() || expands(format);
    const bool isCurrent = !copies || (source->version() == version_ && !source->changesUnseen());
    const std::array<uint64_t, 6> shape = {source->format,       source->extent(0, 0),
                                           source->extent(1, 0), source->extent(2, 0),
                                           source->mipLevels,    source->description};
    if (!changed_ && texture != 0 && source->data() == data_ && shape == shape_ && isCurrent)
        return false;
    if (!source->data())
        refuseIt(RT_ERROR_INVALID_CONTEXT, "the buffer has no elements");
    auto made = std::make_unique<texture::Texture>();
    const uint8_t* texels = source->data();
    SharedMemory expanded;
    if (expands(format)) {
        expanded = SharedMemory(backend_, source->bytes() / 3 * 4);
        expand(*source, static_cast<uint8_t*>(expanded.get()));
        texels = static_cast<const uint8_t*>(expanded.get());
        format.channels = 4;
    }
    made->format = format;
    made->levels = source->mipLevels;
    for (unsigned level = 0; level < made->levels; ++level)
        made->images[level] = imageOf(*source, texels, made->format, level);
    made->layered = source->description & RT_BUFFER_LAYERED;
    made->cube = source->description & RT_BUFFER_CUBEMAP;
    made->hasLines = made->layered && !made->cube && made->images[0].height == 1;
    made->is3D = source->dimensions == 3 && !made->layered && !made->cube;
    static_assert(unsigned(texture::Address::kBorder) == RT_WRAP_CLAMP_TO_BORDER);
    for (unsigned i = 0; i < 3; ++i)
        made->address[i] = texture::Address(unsigned(wrap[i]));
    made->linear = magFilter == RT_FILTER_LINEAR;
    made->linearLevels = mipFilter == RT_FILTER_LINEAR;
    made->normalizedCoordinates = indexMode == RT_TEXTURE_INDEX_NORMALIZED_COORDINATES;
    made->asFloat = readMode == RT_TEXTURE_READ_NORMALIZED_FLOAT ||
                    readMode == RT_TEXTURE_READ_NORMALIZED_FLOAT_SRGB;
    made->srgb = readMode == RT_TEXTURE_READ_ELEMENT_TYPE_SRGB ||
                 readMode == RT_TEXTURE_READ_NORMALIZED_FLOAT_SRGB;
    made->levelBias = levelBias;
    made->minLevel = levelMin;
    made->maxLevel = std::min(levelMax, float(made->levels - 1));
    made->anisotropy = unsigned(anisotropy);
    const uint64_t handle = backend_->addTexture(std::move(made));
    if (texture)
        backend_->removeTexture(texture);
    texture = handle;
    expanded_ = std::move(expanded);
    data_ = source->data();
    shape_ = shape;
    version_ = source->version();
    changed_ = false;
    return true;
}

} // namespace sunstone::optix6
