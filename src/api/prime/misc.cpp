// SPDX-License-Identifier: Apache-2.0
// Miscellaneous functions (OptiX 6.0, module 5.35).
#include "api/prime/cuda_library.h"
#include "api/prime/shell.h"

#include <sys/mman.h>

#include <map>

namespace sunstone::prime {
namespace {

struct LockedBuffer {
    size_t size;
    bool isRegistered; // with CUDA; else by mlock
};

struct LockedBuffers {
    std::mutex mutex;
    std::map<void*, LockedBuffer> all;
};

LockedBuffers& lockedBuffers() {
    static auto* const buffers = new LockedBuffers;
    return *buffers;
}

const char* textOf(RTPresult code) {
    switch (code) {
    case RTP_SUCCESS:
        return "Success";
    case RTP_ERROR_INVALID_VALUE:
        return "Invalid value";
    case RTP_ERROR_OUT_OF_MEMORY:
        return "Out of memory";
    case RTP_ERROR_INVALID_HANDLE:
        return "Invalid handle";
    case RTP_ERROR_NOT_SUPPORTED:
        return "Not supported";
    case RTP_ERROR_OBJECT_CREATION_FAILED:
        return "Object creation failed";
    case RTP_ERROR_MEMORY_ALLOCATION_FAILED:
        return "Memory allocation failed";
    case RTP_ERROR_INVALID_CONTEXT:
        return "Invalid context";
    case RTP_ERROR_VALIDATION_ERROR:
        return "Validation error";
    case RTP_ERROR_INVALID_OPERATION:
        return "Invalid operation";
    case RTP_ERROR_UNKNOWN:
        return "Unknown error";
    }
    return "Unrecognized error code";
}

} // namespace

extern "C" RTPresult RTPAPI rtpHostBufferLock(void* buffer, RTPsize size) {
    return guarded(nullptr, "rtpHostBufferLock", [&] {
        requireNonNull(buffer, "buffer");
        if (size == 0)
            fail(Code::kInvalidValue, "size is 0");
        if (!engine::isHostReadable(buffer, size))
            fail(Code::kInvalidValue, "the ", size, " bytes at ", buffer,
                 " are not all memory of the host");
        LockedBuffers& buffers = lockedBuffers();
        std::lock_guard lock(buffers.mutex);
        if (buffers.all.count(buffer))
            fail(Code::kInvalidValue, "buffer = ", buffer, " is locked already");
        const CudaFunctions* const cu = loadedCuda();
        const bool registered =
            cu && currentCudaDevice() >= 0 &&
            cu->memHostRegister(buffer, size, CU_MEMHOSTREGISTER_PORTABLE) == CUDA_SUCCESS;
        // Locking only makes transfers faster, so a limit of the system is no error.
        if (!registered && mlock(buffer, size) != 0)
            log(LogLevel::kInfo, "prime", message("the system does not lock ", size, " bytes"));
        buffers.all[buffer] = {size, registered};
    });
}

extern "C" RTPresult RTPAPI rtpHostBufferUnlock(void* buffer) {
    return guarded(nullptr, "rtpHostBufferUnlock", [&] {
        requireNonNull(buffer, "buffer");
        LockedBuffers& buffers = lockedBuffers();
        std::lock_guard lock(buffers.mutex);
        const auto found = buffers.all.find(buffer);
        if (found == buffers.all.end())
            fail(Code::kInvalidValue, "buffer = ", buffer, " is not locked");
        const LockedBuffer locked = found->second;
        buffers.all.erase(found);
        if (locked.isRegistered)
            check(cuda().memHostUnregister(buffer), "cuMemHostUnregister");
        else
            munlock(buffer, locked.size);
    });
}

extern "C" RTPresult RTPAPI rtpGetErrorString(RTPresult errorCode, const char** errorString) {
    return guarded(nullptr, "rtpGetErrorString", [&] {
        requireNonNull(errorString, "errorString");
        *errorString = textOf(errorCode);
    });
}

extern "C" RTPresult RTPAPI rtpGetVersion(unsigned* version) {
    return guarded(nullptr, "rtpGetVersion", [&] {
        requireNonNull(version, "version");
        *version = OPTIX_PRIME_VERSION;
    });
}

extern "C" RTPresult RTPAPI rtpGetVersionString(const char** versionString) {
    return guarded(nullptr, "rtpGetVersionString", [&] {
        requireNonNull(versionString, "versionString");
        *versionString = "OptiX Prime 6.0.0 (Sunstone)";
    });
}

} // namespace sunstone::prime
