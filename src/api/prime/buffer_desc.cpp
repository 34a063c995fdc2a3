// SPDX-License-Identifier: Apache-2.0
// Buffer descriptors (OptiX 6.0, module 5.32).
#include "api/prime/cuda_library.h"
#include "api/prime/shell.h"

#include <algorithm>
#include <iterator>

namespace sunstone::prime {
namespace {

struct FormatRow {
    RTPbufferformat format;
    const char* name;
    uint32_t bytes; // of an element; 0: a bit
    bool strides;   // whether a stride may be set
};

#define ROW(format, bytes, strides) {format, #format, bytes, strides}
constexpr FormatRow kFormats[] = {
    ROW(RTP_BUFFER_FORMAT_INDICES_INT3, 12, false),
    ROW(RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT, 16, false),
    ROW(RTP_BUFFER_FORMAT_VERTEX_FLOAT3, 12, true),
    ROW(RTP_BUFFER_FORMAT_VERTEX_FLOAT4, 16, true),
    ROW(RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION, 24, false),
    ROW(RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, 32, false),
    ROW(RTP_BUFFER_FORMAT_RAY_ORIGIN_MASK_DIRECTION_TMAX, 32, false),
    ROW(RTP_BUFFER_FORMAT_HIT_BITMASK, 0, false),
    ROW(RTP_BUFFER_FORMAT_HIT_T, 4, false),
    ROW(RTP_BUFFER_FORMAT_HIT_T_TRIID, 8, false),
    ROW(RTP_BUFFER_FORMAT_HIT_T_TRIID_U_V, 16, false),
    ROW(RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID, 12, false),
    ROW(RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, 20, false),
    ROW(RTP_BUFFER_FORMAT_INSTANCE_MODEL, sizeof(RTPmodel), false),
    ROW(RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4, 64, true),
    ROW(RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, 48, true),
};
#undef ROW

const FormatRow* find(RTPbufferformat format) {
    const auto* const row = std::find_if(std::begin(kFormats), std::end(kFormats),
                                         [&](const FormatRow& r) { return r.format == format; });
    return row == std::end(kFormats) ? nullptr : row;
}

void checkStride(const BufferDesc& desc, unsigned stride) {
    const FormatRow& row = *find(desc.format);
    if (stride == 0)
        return;
    if (!row.strides)
        fail(Code::kInvalidValue, "strideBytes = ", stride, ": elements of ", row.name,
             " are contiguous");
    if (stride < row.bytes)
        fail(Code::kInvalidValue, "strideBytes = ", stride, " is less than the ", row.bytes,
             " bytes of an element of ", row.name);
    const bool transforms = desc.format == RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4 ||
                            desc.format == RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3;
    const unsigned unit = transforms ? 16 : 4;
    if (stride % unit != 0)
        fail(Code::kInvalidValue, "strideBytes = ", stride, " of ", row.name,
             " is not a multiple of ", unit);
}

void requireInAddressSpace(uint64_t end, uint32_t strideBytes) {
    constexpr uint64_t kMost = uint64_t(1) << 47;
    if (end > kMost / std::max(strideBytes, 1u))
        fail(Code::kInvalidValue, "end = ", end, " elements of ", strideBytes,
             " bytes is beyond the address space");
}

} // namespace

uint32_t BufferDesc::elementBytes() const {
    return find(format)->bytes;
}

const char* formatName(RTPbufferformat format) {
    return find(format)->name;
}

BufferDesc usableDesc(const Context& context, RTPbufferdesc handle, const char* parameter,
                      std::initializer_list<RTPbufferformat> formats) {
    const BufferDesc desc = *descOf(handle, parameter);
    if (desc.context.get() != &context)
        fail(Code::kInvalidValue, parameter, " belongs to another context");
    if (std::find(formats.begin(), formats.end(), desc.format) == formats.end()) {
        std::string wanted;
        for (const RTPbufferformat format : formats)
            wanted += std::string(wanted.empty() ? "" : ", ") + formatName(format);
        fail(Code::kInvalidValue, parameter, " has format ", formatName(desc.format),
             ", but must have one of ", wanted);
    }
    if (!desc.hasRange)
        fail(Code::kInvalidValue, parameter,
             " has no range: call rtpBufferDescSetRange, as the size of a buffer is unknown");
    return desc;
}

void requireMemory(const Context& context, const BufferDesc& desc, const char* parameter,
                   uint64_t bytes, bool written) {
    if (bytes == 0)
        return;
    void* const address = desc.first();
    if (desc.type == RTP_BUFFER_TYPE_HOST) {
        const bool usable = written ? engine::isHostWritable(address, bytes)
                                    : engine::isHostReadable(address, bytes);
        if (!usable)
            fail(Code::kInvalidValue, parameter, ": the range of ", bytes, " bytes at ", address,
                 " is not all memory that the host can ", written ? "write" : "read");
        return;
    }
    uint64_t available = 0;
    if (!isCudaMemory(address, available))
        fail(Code::kInvalidValue, parameter, ": ", address,
             " is no address of CUDA memory, as RTP_BUFFER_TYPE_CUDA_LINEAR says");
    if (available < bytes ||
        (context.device->usesCpuLayout() && !context.device->isDeviceMemory(address, bytes)))
        fail(Code::kInvalidValue, parameter, ": the range of ", bytes, " bytes at ", address,
             " is not within one allocation, which ends after ", available, " bytes");
    if (desc.cudaDevice != context.cudaDevice && context.type == RTP_CONTEXT_TYPE_CUDA)
        fail(Code::kNotSupported, parameter, " is on CUDA device ", desc.cudaDevice,
             ", but the context's device is ", context.cudaDevice);
    if (context.type == RTP_CONTEXT_TYPE_CPU &&
        device::cuda::loadedDriver() == device::cuda::LoadedDriver::kGpu)
        fail(Code::kNotSupported, parameter,
             ": a context of the CPU cannot use the memory of a GPU");
}

extern "C" RTPresult RTPAPI rtpBufferDescCreate(RTPcontext context, RTPbufferformat format,
                                                RTPbuffertype type, void* buffer,
                                                RTPbufferdesc* desc) {
    return guarded(contexts().find(context), "rtpBufferDescCreate", [&] {
        auto object = std::make_shared<BufferDesc>();
        object->context = contextOf(context);
        requireNonNull(desc, "desc");
        if (!find(format))
            fail(Code::kInvalidValue, "format = 0x", std::hex, unsigned(format), " is unknown");
        if (type != RTP_BUFFER_TYPE_HOST && type != RTP_BUFFER_TYPE_CUDA_LINEAR)
            fail(Code::kInvalidValue, "type = 0x", std::hex, unsigned(type),
                 " is neither RTP_BUFFER_TYPE_HOST nor RTP_BUFFER_TYPE_CUDA_LINEAR");
        // Null is the address of empty arrays.
        if (uintptr_t(buffer) % (format == RTP_BUFFER_FORMAT_HIT_BITMASK ? 1 : 4) != 0)
            fail(Code::kInvalidValue, "buffer = ", buffer, " is not aligned to 4 bytes");
        if (type == RTP_BUFFER_TYPE_CUDA_LINEAR && !loadedCuda())
            fail(Code::kNotSupported,
                 "type is RTP_BUFFER_TYPE_CUDA_LINEAR, but the process has no CUDA driver");
        object->format = format;
        object->type = type;
        object->buffer = buffer;
        if (type == RTP_BUFFER_TYPE_CUDA_LINEAR) {
            object->cudaDevice = currentCudaDevice();
            if (object->cudaDevice < 0)
                object->cudaDevice = object->context->cudaDevice;
        }
        *desc = static_cast<RTPbufferdesc>(descs().add(object));
    });
}

extern "C" RTPresult RTPAPI rtpBufferDescGetContext(RTPbufferdesc desc, RTPcontext* context) {
    return guarded(peekContext(descs(), desc), "rtpBufferDescGetContext",
                   [&] { giveContext(*descOf(desc, "desc"), context); });
}

extern "C" RTPresult RTPAPI rtpBufferDescSetRange(RTPbufferdesc desc, RTPsize begin, RTPsize end) {
    return guarded(peekContext(descs(), desc), "rtpBufferDescSetRange", [&] {
        const auto object = descOf(desc, "desc");
        if (begin > end)
            fail(Code::kInvalidValue, "begin = ", begin, " is behind end = ", end);
        std::lock_guard lock(object->context->mutex);
        requireInAddressSpace(end, object->strideBytes());
        object->hasRange = true;
        object->begin = begin;
        object->end = end;
    });
}

extern "C" RTPresult RTPAPI rtpBufferDescSetStride(RTPbufferdesc desc, unsigned strideBytes) {
    return guarded(peekContext(descs(), desc), "rtpBufferDescSetStride", [&] {
        const auto object = descOf(desc, "desc");
        checkStride(*object, strideBytes);
        std::lock_guard lock(object->context->mutex);
        requireInAddressSpace(object->end, strideBytes);
        object->stride = strideBytes;
    });
}

extern "C" RTPresult RTPAPI rtpBufferDescSetCudaDeviceNumber(RTPbufferdesc desc,
                                                             unsigned deviceNumber) {
    return guarded(peekContext(descs(), desc), "rtpBufferDescSetCudaDeviceNumber", [&] {
        const auto object = descOf(desc, "desc");
        if (object->type != RTP_BUFFER_TYPE_CUDA_LINEAR)
            fail(Code::kInvalidValue, "the buffer is not of type RTP_BUFFER_TYPE_CUDA_LINEAR");
        const std::vector<int> devices = cudaDevices();
        if (std::find(devices.begin(), devices.end(), int(deviceNumber)) == devices.end())
            fail(Code::kInvalidValue, "deviceNumber = ", deviceNumber, " is no CUDA device");
        std::lock_guard lock(object->context->mutex);
        object->cudaDevice = int(deviceNumber);
    });
}

extern "C" RTPresult RTPAPI rtpBufferDescDestroy(RTPbufferdesc desc) {
    return guarded(peekContext(descs(), desc), "rtpBufferDescDestroy", [&] {
        descOf(desc, "desc");
        descs().remove(desc);
    });
}

} // namespace sunstone::prime
