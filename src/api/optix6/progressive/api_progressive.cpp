// SPDX-License-Identifier: Apache-2.0
// Entry points of progressive launches and stream buffers (sections 5.2 and 5.14).
#include "api/optix6/call.h"
#include "api/optix6/gl/share.h"

#include <cmath>
#include <cstring>

using namespace sunstone;
using namespace sunstone::optix6;

SUNSTONE_API RTresult rtContextLaunchProgressive2D(RTcontext handle, unsigned entry, RTsize width,
                                                   RTsize height, unsigned maxSubframes) {
    return callContext(
        __func__, handle,
        [&](Context& context) {
            checkLaunch(context, entry, width, height, 1);
            const Progressive::Parameters parameters{entry, uint32_t(width), uint32_t(height),
                                                     maxSubframes};
            Progressive& progressive = *context.progressive;
            if (progressive.matches(parameters))
                return;
            progressive.stop();
            checkUnmapped(context, false);
            // Here, because the launch's thread has no OpenGL context.
            const gl::Share share(context);
            context.launched = true;
            noteFailure(context, [&] { progressive.start(parameters); });
        },
        RT_ERROR_INVALID_CONTEXT, true);
}

SUNSTONE_API RTresult rtContextStopProgressive(RTcontext handle) {
    return callContext(
        __func__, handle,
        [](Context& context) {
            for (const Ref<Buffer>& ref : context.allBuffers)
                if (const auto buffer = ref.lock(); buffer && buffer->stream)
                    buffer->stream->dropUpdate();
        },
        RT_ERROR_INVALID_CONTEXT);
}

// The manual has this call as a placeholder. By our decision it lets the launch continue.
SUNSTONE_API RTresult rtContextGetRunningState(RTcontext handle, int* running) {
    return callContext(
        __func__, handle,
        [&](Context& context) {
            store(running, "running", int(context.progressive->isGenerating()));
        },
        RT_ERROR_INVALID_VALUE, true);
}

namespace {

bool isStream(const Buffer& buffer) {
    return buffer.stream != nullptr;
}

Stream& streamOf(const Buffer& buffer) {
    if (!buffer.stream)
        refuse(RT_ERROR_INVALID_VALUE, "the buffer is not of type RT_BUFFER_PROGRESSIVE_STREAM");
    return *buffer.stream;
}

} // namespace

SUNSTONE_API RTresult rtBufferGetProgressiveUpdateReady(RTbuffer buffer, int* ready,
                                                        unsigned* subframeCount,
                                                        unsigned* maxSubframes) {
    return call<Buffer>(
        __func__, buffer, "buffer",
        [&](Buffer& object) {
            requireNonNull(ready, "ready");
            *ready = 0;
            Stream& stream = streamOf(object);
            object.context()->progressive->throwFailure(false);
            Stream::Update update{};
            *ready = stream.takeUpdate(update);
            if (*ready && subframeCount)
                *subframeCount = update.subframes;
            if (*ready && maxSubframes)
                *maxSubframes = update.limit;
        },
        isStream);
}

SUNSTONE_API RTresult rtBufferBindProgressiveStream(RTbuffer stream, RTbuffer source) {
    return call<Buffer>(__func__, stream, "stream", [&](Buffer& object) {
        const auto from = requireOf<Buffer>(*object.context(), source, "source");
        checkStream(object, *from);
        object.stream->source = from;
    });
}

// ---- attributes -------------------------------------------------------------------------------

namespace {

constexpr RTsize kLongestFormat = 255;

template <class T>
T readAttribute(RTsize size, const void* p) {
    if (size != sizeof(T))
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, ", but the attribute has ", sizeof(T),
               " bytes");
    T value;
    std::memcpy(&value, p, sizeof(T));
    if (!(value > 0) || !std::isfinite(float(value)))
        refuse(RT_ERROR_INVALID_VALUE, "the attribute's value ", value, " is not above 0");
    return value;
}

template <class T>
void writeAttribute(RTsize size, void* p, T value) {
    if (size != sizeof(T))
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, ", but the attribute has ", sizeof(T),
               " bytes");
    std::memcpy(p, &value, sizeof(T));
}

std::string readFormat(RTsize size, const void* p) {
    if (size == 0 || size > kLongestFormat)
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, " is outside 1..", kLongestFormat);
    const auto* text = static_cast<const char*>(p);
    return std::string(text, strnlen(text, size));
}

void writeFormat(RTsize size, void* p, const std::string& format) {
    if (size <= format.size())
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, ", but the format's name needs ",
               format.size() + 1, " bytes");
    std::memcpy(p, format.c_str(), format.size() + 1);
}

[[noreturn]] void refuseAttribute(RTbufferattribute attribute) {
    refuse(RT_ERROR_INVALID_VALUE, "attrib = ", unsigned(attribute), " is unknown");
}

} // namespace

SUNSTONE_API RTresult rtBufferSetAttribute(RTbuffer buffer, RTbufferattribute attribute,
                                           RTsize size, const void* p) {
    return call<Buffer>(__func__, buffer, "buffer", [&](Buffer& object) {
        requireNonNull(p, "p");
        Stream& stream = streamOf(object);
        switch (attribute) {
        case RT_BUFFER_ATTRIBUTE_STREAM_FORMAT:
            stream.format = readFormat(size, p);
            return;
        case RT_BUFFER_ATTRIBUTE_STREAM_BITRATE:
            stream.bitrate = readAttribute<int>(size, p);
            return;
        case RT_BUFFER_ATTRIBUTE_STREAM_FPS:
            stream.perSecond = readAttribute<int>(size, p);
            return;
        case RT_BUFFER_ATTRIBUTE_STREAM_GAMMA:
            stream.gamma = readAttribute<float>(size, p);
            return;
        default:
            refuseAttribute(attribute);
        }
    });
}

SUNSTONE_API RTresult rtBufferGetAttribute(RTbuffer buffer, RTbufferattribute attribute,
                                           RTsize size, void* p) {
    return call<Buffer>(__func__, buffer, "buffer", [&](Buffer& object) {
        requireNonNull(p, "p");
        const Stream& stream = streamOf(object);
        switch (attribute) {
        case RT_BUFFER_ATTRIBUTE_STREAM_FORMAT:
            return writeFormat(size, p, stream.format);
        case RT_BUFFER_ATTRIBUTE_STREAM_BITRATE:
            return writeAttribute(size, p, stream.bitrate);
        case RT_BUFFER_ATTRIBUTE_STREAM_FPS:
            return writeAttribute(size, p, stream.perSecond);
        case RT_BUFFER_ATTRIBUTE_STREAM_GAMMA:
            return writeAttribute(size, p, stream.gamma);
        default:
            refuseAttribute(attribute);
        }
    });
}
