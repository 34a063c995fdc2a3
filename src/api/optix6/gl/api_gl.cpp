// SPDX-License-Identifier: Apache-2.0
// Entry points of interoperation with OpenGL (sections 5.14, 5.15 and 5.20).
#include "api/optix6/call.h"
#include "api/optix6/gl/share.h"

#include "optix_gl_interop.h"

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

RTresult callBuffer(const char* function, RTbuffer buffer,
                    const std::function<void(Buffer&)>& body) {
    return call<Buffer>(function, buffer, "buffer", [&](Buffer& object) {
        if (object.glBuffer == 0)
            refuse(RT_ERROR_INVALID_VALUE,
                   "the buffer shares nothing with OpenGL: rtBufferCreateFromGLBO did not make it");
        if (object.isMapped())
            refuse(RT_ERROR_ALREADY_MAPPED, "the buffer is mapped");
        body(object);
    });
}

RTresult callSampler(const char* function, RTtexturesampler sampler,
                     const std::function<void(TextureSampler&)>& body) {
    return call<TextureSampler>(function, sampler, "textureSampler", [&](TextureSampler& object) {
        if (!object.gl)
            refuse(RT_ERROR_INVALID_VALUE, "the texture sampler shares nothing with OpenGL: "
                                           "rtTextureSamplerCreateFromGLImage did not make it");
        body(object);
    });
}

void requireUnregistered(bool isRegistered) {
    if (isRegistered)
        refuse(RT_ERROR_RESOURCE_ALREADY_REGISTERED, "the object of OpenGL is registered");
}
void requireRegistered(bool isRegistered) {
    if (!isRegistered)
        refuse(RT_ERROR_RESOURCE_NOT_REGISTERED, "the object of OpenGL is not registered");
}

// The target determines layers and faces.
unsigned descriptionOf(RTgltarget target) {
    switch (target) {
    case RT_TARGET_GL_TEXTURE_1D_ARRAY:
    case RT_TARGET_GL_TEXTURE_2D_ARRAY:
        return unsigned(RT_BUFFER_INPUT) | unsigned(RT_BUFFER_LAYERED);
    case RT_TARGET_GL_TEXTURE_CUBE_MAP:
        return unsigned(RT_BUFFER_INPUT) | unsigned(RT_BUFFER_CUBEMAP);
    case RT_TARGET_GL_TEXTURE_CUBE_MAP_ARRAY:
        return unsigned(RT_BUFFER_INPUT) | unsigned(RT_BUFFER_CUBEMAP) |
               unsigned(RT_BUFFER_LAYERED);
    default:
        return RT_BUFFER_INPUT;
    }
}

} // namespace

// ---- Buffers -----------------------------------------------------------------------------------

SUNSTONE_API RTresult rtBufferCreateFromGLBO(RTcontext handle, unsigned description, unsigned glId,
                                             RTbuffer* buffer) {
    return callContext(
        __func__, handle,
        [&](Context& context) {
            requireNonNull(buffer, "buffer");
            *buffer = nullptr;
            if (description != RT_BUFFER_INPUT && description != RT_BUFFER_OUTPUT &&
                description != RT_BUFFER_INPUT_OUTPUT)
                refuse(RT_ERROR_INVALID_VALUE, "bufferdesc = ", description,
                       " is none of RT_BUFFER_INPUT, OUTPUT and INPUT_OUTPUT, without flags");
            if (glId == 0)
                refuse(RT_ERROR_INVALID_VALUE, "glId = 0 is no buffer of OpenGL");
            const auto made = std::make_shared<Buffer>(context.self(), description);
            made->glBuffer = glId;
            made->isGlRegistered = true;
            gl::check(*made);
            *buffer = static_cast<RTbuffer>(objects().add(made));
            context.allBuffers.push_back(made);
            context.glBuffers.push_back(made);
        },
        RT_ERROR_INVALID_CONTEXT);
}

SUNSTONE_API RTresult rtBufferGetGLBOId(RTbuffer buffer, unsigned* glId) {
    return call<Buffer>(__func__, buffer, "buffer",
                        [&](Buffer& object) { store(glId, "glId", object.glBuffer); });
}

SUNSTONE_API RTresult rtBufferGLRegister(RTbuffer buffer) {
    return callBuffer(__func__, buffer, [](Buffer& object) {
        requireUnregistered(object.isGlRegistered);
        gl::check(object);
        object.isGlRegistered = true;
    });
}

// The next launch updates places that refer to the buffer.
SUNSTONE_API RTresult rtBufferGLUnregister(RTbuffer buffer) {
    return callBuffer(__func__, buffer, [](Buffer& object) {
        requireRegistered(object.isGlRegistered);
        object.isGlRegistered = false;
        object.context()->noteStructure();
    });
}

// ---- Images ------------------------------------------------------------------------------------

SUNSTONE_API RTresult rtTextureSamplerCreateFromGLImage(RTcontext handle, unsigned glId,
                                                        RTgltarget target,
                                                        RTtexturesampler* sampler) {
    return callContext(
        __func__, handle,
        [&](Context& context) {
            requireNonNull(sampler, "textureSampler");
            *sampler = nullptr;
            if (unsigned(target) > unsigned(RT_TARGET_GL_TEXTURE_CUBE_MAP_ARRAY))
                refuse(RT_ERROR_INVALID_VALUE, "target = ", unsigned(target), " is unknown");
            if (glId == 0)
                refuse(RT_ERROR_INVALID_VALUE, "glId = 0 is no image of OpenGL");
            const auto made = std::make_shared<TextureSampler>(context.self());
            const auto texels = std::make_shared<Buffer>(context.self(), descriptionOf(target));
            made->gl = TextureSampler::GlImage{glId, target, true, texels};
            made->buffer = texels;
            gl::fetch(*made);
            *sampler = static_cast<RTtexturesampler>(objects().add(made));
            context.glSamplers.push_back(made);
        },
        RT_ERROR_INVALID_CONTEXT);
}

SUNSTONE_API RTresult rtTextureSamplerGetGLImageId(RTtexturesampler sampler, unsigned* glId) {
    return call<TextureSampler>(__func__, sampler, "textureSampler", [&](TextureSampler& object) {
        store(glId, "glId", object.gl ? object.gl->id : 0u);
    });
}

SUNSTONE_API RTresult rtTextureSamplerGLRegister(RTtexturesampler sampler) {
    return callSampler(__func__, sampler, [](TextureSampler& object) {
        requireUnregistered(object.gl->isRegistered);
        gl::fetch(object);
        object.gl->isRegistered = true;
    });
}

SUNSTONE_API RTresult rtTextureSamplerGLUnregister(RTtexturesampler sampler) {
    return callSampler(__func__, sampler, [](TextureSampler& object) {
        requireRegistered(object.gl->isRegistered);
        object.gl->isRegistered = false;
    });
}

// ---- Devices -----------------------------------------------------------------------------------

SUNSTONE_API RTresult rtDeviceGetWGLDevice(int* device, HGPUNV gpu) {
    return guarded(nullptr, __func__, [&] {
        requireNonNull(device, "device");
        requireNonNull(gpu, "gpu");
        refuse(RT_ERROR_NOT_SUPPORTED,
               "handles of GPUs come from WGL_NV_gpu_affinity, which Windows alone has");
    });
}
