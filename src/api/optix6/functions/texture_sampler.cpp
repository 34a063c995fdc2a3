// SPDX-License-Identifier: Apache-2.0
// Entry points of texture samplers (section 5.15).
#include "api/optix6/call.h"

#include <algorithm>

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

template <class Body>
RTresult change(const char* function, RTtexturesampler sampler, const Body& body) {
    return call<TextureSampler>(function, sampler, "texturesampler", [&](TextureSampler& object) {
        body(object);
        object.noteChange();
    });
}

void requireOwnBuffer(const TextureSampler& sampler) {
    if (sampler.gl)
        refuse(RT_ERROR_INVALID_VALUE, "the texels are those of OpenGL image ", sampler.gl->id,
               ": the texture sampler has no buffer");
}

void requireBelow(unsigned value, unsigned end, const char* name) {
    if (value >= end)
        refuse(RT_ERROR_INVALID_VALUE, name, " = ", value, " is outside 0..", end - 1);
}

} // namespace

SUNSTONE_API RTresult rtTextureSamplerCreate(RTcontext context, RTtexturesampler* sampler) {
    return create<TextureSampler>(__func__, context, "texturesampler", sampler);
}
SUNSTONE_API RTresult rtTextureSamplerDestroy(RTtexturesampler sampler) {
    return destroy<TextureSampler>(__func__, sampler, "texturesampler");
}
SUNSTONE_API RTresult rtTextureSamplerValidate(RTtexturesampler sampler) {
    return call<TextureSampler>(__func__, sampler, "texturesampler",
                                [](TextureSampler& object) { object.validate(); });
}
SUNSTONE_API RTresult rtTextureSamplerGetContext(RTtexturesampler sampler, RTcontext* context) {
    return getContext<TextureSampler>(__func__, sampler, "texturesampler", context);
}
SUNSTONE_API RTresult rtTextureSamplerSetWrapMode(RTtexturesampler sampler, unsigned dimension,
                                                  RTwrapmode mode) {
    return change(__func__, sampler, [&](TextureSampler& object) {
        requireBelow(dimension, 3, "dimension");
        requireBelow(unsigned(mode), 4, "wrapmode");
        object.wrap[dimension] = mode;
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetWrapMode(RTtexturesampler sampler, unsigned dimension,
                                                  RTwrapmode* mode) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        requireBelow(dimension, 3, "dimension");
        store(mode, "wrapmode", object.wrap[dimension]);
    });
}
SUNSTONE_API RTresult rtTextureSamplerSetFilteringModes(RTtexturesampler sampler,
                                                        RTfiltermode minify, RTfiltermode magnify,
                                                        RTfiltermode mip) {
    return change(__func__, sampler, [&](TextureSampler& object) {
        requireBelow(unsigned(minify), 2, "minification");
        requireBelow(unsigned(magnify), 2, "magnification");
        requireBelow(unsigned(mip), 3, "mipmapping");
        object.minFilter = minify;
        object.magFilter = magnify;
        object.mipFilter = mip;
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetFilteringModes(RTtexturesampler sampler,
                                                        RTfiltermode* minify, RTfiltermode* magnify,
                                                        RTfiltermode* mip) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        requireNonNull(minify, "minification");
        requireNonNull(magnify, "magnification");
        store(mip, "mipmapping", object.mipFilter);
        *minify = object.minFilter;
        *magnify = object.magFilter;
    });
}
SUNSTONE_API RTresult rtTextureSamplerSetMaxAnisotropy(RTtexturesampler sampler, float value) {
    return change(__func__, sampler, [&](TextureSampler& object) {
        value = value >= 1 ? std::min(value, 16.0f) : 1.0f;
        object.anisotropy = value;
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetMaxAnisotropy(RTtexturesampler sampler, float* value) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        store(value, "value", object.anisotropy);
    });
}
SUNSTONE_API RTresult rtTextureSamplerSetMipLevelBias(RTtexturesampler sampler, float value) {
    return change(__func__, sampler, [&](TextureSampler& object) { object.levelBias = value; });
}
SUNSTONE_API RTresult rtTextureSamplerGetMipLevelBias(RTtexturesampler sampler, float* value) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        store(value, "value", object.levelBias);
    });
}
SUNSTONE_API RTresult rtTextureSamplerSetMipLevelClamp(RTtexturesampler sampler, float least,
                                                       float most) {
    return change(__func__, sampler, [&](TextureSampler& object) {
        object.levelMin = least;
        object.levelMax = most;
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetMipLevelClamp(RTtexturesampler sampler, float* least,
                                                       float* most) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        requireNonNull(least, "minLevel");
        store(most, "maxLevel", object.levelMax);
        *least = object.levelMin;
    });
}
SUNSTONE_API RTresult rtTextureSamplerSetReadMode(RTtexturesampler sampler,
                                                  RTtexturereadmode value) {
    return change(__func__, sampler, [&](TextureSampler& object) {
        requireBelow(unsigned(value), 4, "readmode");
        object.readMode = value;
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetReadMode(RTtexturesampler sampler,
                                                  RTtexturereadmode* value) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        store(value, "readmode", object.readMode);
    });
}
SUNSTONE_API RTresult rtTextureSamplerSetIndexingMode(RTtexturesampler sampler,
                                                      RTtextureindexmode value) {
    return change(__func__, sampler, [&](TextureSampler& object) {
        requireBelow(unsigned(value), 2, "indexmode");
        object.indexMode = value;
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetIndexingMode(RTtexturesampler sampler,
                                                      RTtextureindexmode* value) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        store(value, "indexmode", object.indexMode);
    });
}

// Array slices and levels belong to the buffer; the two numbers are left from earlier releases.
SUNSTONE_API RTresult rtTextureSamplerSetBuffer(RTtexturesampler sampler, unsigned slice,
                                                unsigned level, RTbuffer buffer) {
    return change(__func__, sampler, [&](TextureSampler& object) {
        requireBelow(slice, 1, "deprecated0");
        requireBelow(level, 1, "deprecated1");
        requireOwnBuffer(object);
        const auto source = requireOf<Buffer>(*object.context(), buffer, "buffer");
        source->isUsedByObjects = true;
        object.buffer = source;
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetBuffer(RTtexturesampler sampler, unsigned slice,
                                                unsigned level, RTbuffer* buffer) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        requireBelow(slice, 1, "deprecated0");
        requireBelow(level, 1, "deprecated1");
        requireOwnBuffer(object);
        store(buffer, "buffer", static_cast<RTbuffer>(handleOf(object.buffer)));
    });
}
SUNSTONE_API RTresult rtTextureSamplerGetId(RTtexturesampler sampler, int* id) {
    return call<TextureSampler>(__func__, sampler, "texturesampler", [&](TextureSampler& object) {
        requireNonNull(id, "textureId");
        *id = object.context()->idOf(object);
    });
}

namespace {

RTresult setOne(const char* function, RTtexturesampler sampler, unsigned count) {
    return call<TextureSampler>(function, sampler, "texturesampler", [&](TextureSampler&) {
        if (count != 1)
            refuse(RT_ERROR_INVALID_VALUE, "the count = ", count,
                   ": layers and levels are those of the buffer");
    });
}
RTresult getOne(const char* function, RTtexturesampler sampler, unsigned* count) {
    return call<TextureSampler>(function, sampler, "texturesampler",
                                [&](TextureSampler&) { store(count, "the count", 1u); });
}

} // namespace

SUNSTONE_API RTresult rtTextureSamplerSetMipLevelCount(RTtexturesampler sampler, unsigned count) {
    return setOne(__func__, sampler, count);
}
SUNSTONE_API RTresult rtTextureSamplerGetMipLevelCount(RTtexturesampler sampler, unsigned* count) {
    return getOne(__func__, sampler, count);
}
SUNSTONE_API RTresult rtTextureSamplerSetArraySize(RTtexturesampler sampler, unsigned count) {
    return setOne(__func__, sampler, count);
}
SUNSTONE_API RTresult rtTextureSamplerGetArraySize(RTtexturesampler sampler, unsigned* count) {
    return getOne(__func__, sampler, count);
}
