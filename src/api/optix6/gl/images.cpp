// SPDX-License-Identifier: Apache-2.0
// Images: textures and renderbuffers. Their texels go into a buffer that the sampler owns.
#include "api/optix6/gl/share.h"

#include <algorithm>
#include <cstring>

namespace sunstone::optix6::gl {

namespace {

struct Target {
    unsigned target, binding;
};
// By RTgltarget.
constexpr Target kTargets[] = {{0x0DE1, 0x8069},  // 2D
                               {0x84F5, 0x84F6},  // rectangle
                               {0x806F, 0x806A},  // 3D
                               {0x8D41, 0x8CA7},  // renderbuffer
                               {0x0DE0, 0x8068},  // 1D
                               {0x8C18, 0x8C1C},  // 1D array
                               {0x8C1A, 0x8C1D},  // 2D array
                               {0x8513, 0x8514},  // cube map
                               {0x9009, 0x900A}}; // array of cube maps
constexpr unsigned kCubeFace0 = 0x8515;
constexpr unsigned kWidth = 0x1000, kHeight = 0x1001, kInternalFormat = 0x1003, kDepth = 0x8071,
                   kRedSize = 0x805C, kAlphaSize = 0x805F;
constexpr unsigned kRenderbufferWidth = 0x8D42, kRenderbufferHeight = 0x8D43,
                   kRenderbufferFormat = 0x8D44, kRenderbufferSamples = 0x8CAB,
                   kRenderbufferRedSize = 0x8D50, kRenderbufferAlphaSize = 0x8D53;

// The formats of section 5.38.
struct Format {
    unsigned internal;
    RTformat format;
    unsigned glFormat, glType;
};
constexpr unsigned kRed = 0x1903, kRg = 0x8227, kRgba = 0x1908, kRedInteger = 0x8D94,
                   kRgInteger = 0x8228, kRgbaInteger = 0x8D99;
constexpr unsigned kByte = 0x1400, kUnsignedByte = 0x1401, kShort = 0x1402, kUnsignedShort = 0x1403,
                   kInt = 0x1404, kUnsignedInt = 0x1405, kFloat = 0x1406;
constexpr unsigned kRgba8 = 0x8058, kRgba16 = 0x805B;
constexpr Format kFormats[] = {{0x8231, RT_FORMAT_BYTE, kRedInteger, kByte},
                               {0x8232, RT_FORMAT_UNSIGNED_BYTE, kRedInteger, kUnsignedByte},
                               {0x8237, RT_FORMAT_BYTE2, kRgInteger, kByte},
                               {0x8238, RT_FORMAT_UNSIGNED_BYTE2, kRgInteger, kUnsignedByte},
                               {kRgba8, RT_FORMAT_UNSIGNED_BYTE4, kRgba, kUnsignedByte},
                               {0x8D8E, RT_FORMAT_BYTE4, kRgbaInteger, kByte},
                               {0x8D7C, RT_FORMAT_UNSIGNED_BYTE4, kRgbaInteger, kUnsignedByte},
                               {0x8233, RT_FORMAT_SHORT, kRedInteger, kShort},
                               {0x8234, RT_FORMAT_UNSIGNED_SHORT, kRedInteger, kUnsignedShort},
                               {0x8239, RT_FORMAT_SHORT2, kRgInteger, kShort},
                               {0x823A, RT_FORMAT_UNSIGNED_SHORT2, kRgInteger, kUnsignedShort},
                               {kRgba16, RT_FORMAT_UNSIGNED_SHORT4, kRgba, kUnsignedShort},
                               {0x8D88, RT_FORMAT_SHORT4, kRgbaInteger, kShort},
                               {0x8D76, RT_FORMAT_UNSIGNED_SHORT4, kRgbaInteger, kUnsignedShort},
                               {0x8235, RT_FORMAT_INT, kRedInteger, kInt},
                               {0x8236, RT_FORMAT_UNSIGNED_INT, kRedInteger, kUnsignedInt},
                               {0x823B, RT_FORMAT_INT2, kRgInteger, kInt},
                               {0x823C, RT_FORMAT_UNSIGNED_INT2, kRgInteger, kUnsignedInt},
                               {0x8D82, RT_FORMAT_INT4, kRgbaInteger, kInt},
                               {0x8D70, RT_FORMAT_UNSIGNED_INT4, kRgbaInteger, kUnsignedInt},
                               {0x822E, RT_FORMAT_FLOAT, kRed, kFloat},
                               {0x8230, RT_FORMAT_FLOAT2, kRg, kFloat},
                               {0x8814, RT_FORMAT_FLOAT4, kRgba, kFloat}};

const Format& formatOf(unsigned internal, int redBits, int alphaBits) {
    if (internal == kRgba || internal == 4) // no size: OpenGL selected one
        internal = redBits == 8 && alphaBits == 8     ? kRgba8
                   : redBits == 16 && alphaBits == 16 ? kRgba16
                                                      : internal;
    for (const Format& format : kFormats)
        if (format.internal == internal)
            return format;
    refuse(RT_ERROR_INVALID_VALUE, "the image of OpenGL has the internal format ", internal,
           ", which interoperation does not support (section 5.38 of the API reference)");
}

// The packing of pixels in host memory during its lifetime: without gaps.
class Packing {
public:
    explicit Packing(const Functions& gl) : gl_(gl) {
        for (size_t i = 0; i < std::size(kNames); ++i) {
            before_[i] = gl.integer(kNames[i]);
            gl.PixelStorei(kNames[i], kNames[i] == kAlignment ? 1 : 0);
        }
        if (gl.version >= 21) {
            buffer_ = unsigned(gl.integer(kPixelPackBufferBinding));
            gl.BindBuffer(kPixelPackBuffer, 0);
        }
    }
    ~Packing() {
        for (size_t i = 0; i < std::size(kNames); ++i)
            gl_.PixelStorei(kNames[i], before_[i]);
        if (gl_.version >= 21)
            gl_.BindBuffer(kPixelPackBuffer, buffer_);
    }
    Packing(const Packing&) = delete;

private:
    static constexpr unsigned kAlignment = 0x0D05;
    // Swapped bytes, row length, skipped rows, pixels and images, image height.
    static constexpr unsigned kNames[] = {0x0D00, 0x0D02, 0x0D03,    0x0D04,
                                          0x806B, 0x806C, kAlignment};
    const Functions& gl_;
    int before_[std::size(kNames)];
    unsigned buffer_ = 0;
};

struct Shape {
    const Format* format = nullptr;
    unsigned dimensions = 2;
    RTsize sizes[3] = {1, 1, 1};
    unsigned levels = 1;
};

// Gives the texels' buffer this shape. New memory needs a new texture.
void setShape(TextureSampler& sampler, const Shape& shape) {
    Buffer& texels = *sampler.gl->texels;
    bool isEqual = texels.data() && texels.format == shape.format->format &&
                   texels.mipLevels == shape.levels && texels.dimensions == shape.dimensions;
    for (unsigned i = 0; i < shape.dimensions; ++i)
        isEqual = isEqual && texels.extent(i, 0) == shape.sizes[i];
    if (isEqual)
        return;
    texels.setMipLevels(1);
    texels.setFormat(shape.format->format);
    texels.setSize(shape.dimensions, shape.sizes);
    texels.setMipLevels(shape.levels);
    sampler.noteChange();
}

// Stores the texels; the texture is made again only if they have changed.
void store(Buffer& texels, const std::vector<uint8_t>& bytes) {
    if (std::memcmp(texels.data(), bytes.data(), bytes.size()) == 0)
        return;
    std::memcpy(texels.data(), bytes.data(), bytes.size());
    texels.noteChange();
}

void requireSize(const Shape& shape) {
    if (shape.sizes[0] == 0 || shape.sizes[1] == 0 || shape.sizes[2] == 0)
        refuse(RT_ERROR_MEMORY_ALLOCATION_FAILED, "the image of OpenGL has the size 0");
}

// ---- Textures ----------------------------------------------------------------------------------

class Texture {
public:
    Texture(const Functions& gl, unsigned id, RTgltarget kind)
        : gl_(gl), kind_(kind), target_(kTargets[kind]) {
        if (!gl.IsTexture(id))
            refuse(RT_ERROR_INVALID_VALUE, "glId = ", id,
                   " is not a texture of the current OpenGL context");
        before_ = unsigned(gl.integer(target_.binding));
        gl.BindTexture(target_.target, id);
        if (unsigned(gl.integer(target_.binding)) != id) {
            gl.GetError(); // of the binding
            refuse(RT_ERROR_INVALID_VALUE, "glId = ", id, " is a texture of another target than ",
                   unsigned(kind));
        }
    }
    ~Texture() { gl_.BindTexture(target_.target, before_); }
    Texture(const Texture&) = delete;

    Shape shape(bool wantsLevels) const {
        Shape shape;
        sizesAt(0, shape);
        requireSize(shape);
        shape.format = &formatOf(unsigned(parameter(0, kInternalFormat)), parameter(0, kRedSize),
                                 parameter(0, kAlphaSize));
        if (wantsLevels && kind_ != RT_TARGET_GL_TEXTURE_RECTANGLE)
            while (hasLevel(shape, shape.levels))
                ++shape.levels;
        return shape;
    }

    void read(const Shape& shape, const Buffer& texels, std::vector<uint8_t>& bytes) const {
        for (unsigned level = 0; level < shape.levels; ++level) {
            uint8_t* const place = bytes.data() + texels.levelOffset(level);
            const Format& format = *shape.format;
            if (kind_ != RT_TARGET_GL_TEXTURE_CUBE_MAP) {
                gl_.GetTexImage(target_.target, int(level), format.glFormat, format.glType, place);
                continue;
            }
            const size_t face =
                texels.extent(0, level) * texels.extent(1, level) * bytesOf(format.format);
            for (unsigned i = 0; i < 6; ++i)
                gl_.GetTexImage(kCubeFace0 + i, int(level), format.glFormat, format.glType,
                                place + i * face);
        }
    }

private:
    int parameter(unsigned level, unsigned name) const {
        const bool isCube = kind_ == RT_TARGET_GL_TEXTURE_CUBE_MAP;
        int value = 0;
        gl_.GetTexLevelParameteriv(isCube ? kCubeFace0 : target_.target, int(level), name, &value);
        return value;
    }
    void sizesAt(unsigned level, Shape& shape) const {
        const auto width = RTsize(parameter(level, kWidth)),
                   height = RTsize(parameter(level, kHeight)),
                   depth = RTsize(parameter(level, kDepth));
        RTsize sizes[3] = {width, height, depth};
        shape.dimensions = 3;
        switch (kind_) {
        case RT_TARGET_GL_TEXTURE_1D:
            shape.dimensions = 1;
            sizes[1] = sizes[2] = 1;
            break;
        case RT_TARGET_GL_TEXTURE_1D_ARRAY:
            sizes[2] = height;
            sizes[1] = 1;
            break;
        case RT_TARGET_GL_TEXTURE_CUBE_MAP:
            sizes[2] = width == 0 ? 0 : 6;
            break;
        case RT_TARGET_GL_TEXTURE_2D:
        case RT_TARGET_GL_TEXTURE_RECTANGLE:
            shape.dimensions = 2;
            sizes[2] = 1;
            break;
        default:
            break;
        }
        std::copy_n(sizes, 3, shape.sizes);
    }
    // Of the chain that begins with level 0.
    bool hasLevel(const Shape& first, unsigned level) const {
        const bool shrinksDepth = kind_ == RT_TARGET_GL_TEXTURE_3D;
        const RTsize largest =
            std::max({first.sizes[0], first.sizes[1], shrinksDepth ? first.sizes[2] : RTsize(1)});
        if (largest >> level == 0)
            return false;
        Shape there;
        sizesAt(level, there);
        for (unsigned i = 0; i < 3; ++i) {
            const bool shrinks = i < 2 || shrinksDepth;
            if (there.sizes[i] !=
                (shrinks ? std::max<RTsize>(1, first.sizes[i] >> level) : first.sizes[i]))
                return false;
        }
        return parameter(level, kInternalFormat) == parameter(0, kInternalFormat);
    }

    const Functions& gl_;
    const RTgltarget kind_;
    const Target target_;
    unsigned before_ = 0;
};

void fetchTexture(const Functions& gl, TextureSampler& sampler) {
    const Texture texture(gl, sampler.gl->id, sampler.gl->target);
    const Shape shape = texture.shape(sampler.mipFilter != RT_FILTER_NONE);
    setShape(sampler, shape);
    Buffer& texels = *sampler.gl->texels;
    std::vector<uint8_t> bytes(texels.bytes());
    const Packing packing(gl);
    texture.read(shape, texels, bytes);
    store(texels, bytes);
}

// ---- Renderbuffers -----------------------------------------------------------------------------

class Renderbuffer {
public:
    Renderbuffer(const Functions& gl, unsigned id) : gl_(gl), id_(id) {
        if (!gl.IsRenderbuffer || !gl.GenFramebuffers || !gl.ReadPixels)
            refuse(RT_ERROR_NOT_SUPPORTED, "the current OpenGL context has no renderbuffers");
        if (!gl.IsRenderbuffer(id))
            refuse(RT_ERROR_INVALID_VALUE, "glId = ", id,
                   " is not a renderbuffer of the current OpenGL context");
        before_ = unsigned(gl.integer(kTargets[RT_TARGET_GL_RENDER_BUFFER].binding));
        gl.BindRenderbuffer(kRenderbuffer, id);
    }
    ~Renderbuffer() { gl_.BindRenderbuffer(kRenderbuffer, before_); }
    Renderbuffer(const Renderbuffer&) = delete;

    Shape shape() const {
        if (parameter(kRenderbufferSamples) > 1)
            refuse(RT_ERROR_INVALID_VALUE, "glId = ", id_, " has several samples for each pixel");
        Shape shape;
        shape.sizes[0] = RTsize(parameter(kRenderbufferWidth));
        shape.sizes[1] = RTsize(parameter(kRenderbufferHeight));
        requireSize(shape);
        shape.format =
            &formatOf(unsigned(parameter(kRenderbufferFormat)), parameter(kRenderbufferRedSize),
                      parameter(kRenderbufferAlphaSize));
        return shape;
    }

    void read(const Shape& shape, std::vector<uint8_t>& bytes) const {
        const auto before = unsigned(gl_.integer(kReadFramebufferBinding));
        unsigned framebuffer = 0;
        gl_.GenFramebuffers(1, &framebuffer);
        gl_.BindFramebuffer(kReadFramebuffer, framebuffer);
        gl_.FramebufferRenderbuffer(kReadFramebuffer, kColorAttachment0, kRenderbuffer, id_);
        const bool isComplete =
            gl_.CheckFramebufferStatus(kReadFramebuffer) == kFramebufferComplete;
        if (isComplete) {
            gl_.ReadBuffer(kColorAttachment0);
            gl_.ReadPixels(0, 0, int(shape.sizes[0]), int(shape.sizes[1]), shape.format->glFormat,
                           shape.format->glType, bytes.data());
        }
        gl_.BindFramebuffer(kReadFramebuffer, before);
        gl_.DeleteFramebuffers(1, &framebuffer);
        if (!isComplete)
            refuse(RT_ERROR_INVALID_VALUE, "glId = ", id_, " is not a renderbuffer of colours");
    }

private:
    int parameter(unsigned name) const {
        int value = 0;
        gl_.GetRenderbufferParameteriv(kRenderbuffer, name, &value);
        return value;
    }

    const Functions& gl_;
    const unsigned id_;
    unsigned before_ = 0;
};

void fetchRenderbuffer(const Functions& gl, TextureSampler& sampler) {
    const Renderbuffer renderbuffer(gl, sampler.gl->id);
    const Shape shape = renderbuffer.shape();
    setShape(sampler, shape);
    Buffer& texels = *sampler.gl->texels;
    std::vector<uint8_t> bytes(texels.bytes());
    const Packing packing(gl);
    renderbuffer.read(shape, bytes);
    store(texels, bytes);
}

} // namespace

void fetch(TextureSampler& sampler) {
    fetch(current(), sampler);
}

void fetch(const Functions& gl, TextureSampler& sampler) {
    if (sampler.gl->target == RT_TARGET_GL_RENDER_BUFFER)
        fetchRenderbuffer(gl, sampler);
    else
        fetchTexture(gl, sampler);
}

} // namespace sunstone::optix6::gl
