// SPDX-License-Identifier: Apache-2.0
// Names and descriptions of cudaError_t values, and the last error of each thread.
#include "api/cuda/runtime/runtime.h"

namespace sunstone::cudart {

namespace {

thread_local cudaError_t lastError = cudaSuccess;

// A context keeps the error that ended device code, and every call returns it. The driver stores
// the error; this flag only records whether a call on this thread returned one, so that a query is
// useful.
thread_local bool mayHaveFailed = false;

bool isDeviceError(cudaError_t error) {
    switch (error) {
    case cudaErrorIllegalAddress:
    case cudaErrorLaunchTimeout:
    case cudaErrorAssert:
    case cudaErrorHardwareStackError:
    case cudaErrorIllegalInstruction:
    case cudaErrorMisalignedAddress:
    case cudaErrorInvalidAddressSpace:
    case cudaErrorInvalidPc:
    case cudaErrorLaunchFailure:
        return true;
    default:
        return false;
    }
}

// The error with which device code in the current context ended.
cudaError_t contextError() {
    const Driver& d = driver();
    CUcontext context = nullptr;
    if (d.status != cudaSuccess || d.cuCtxGetCurrent(&context) != CUDA_SUCCESS || !context)
        return cudaSuccess;
    size_t free = 0, total = 0; // a call without effect, which is allowed during captures
    const cudaError_t error = static_cast<cudaError_t>(d.cuMemGetInfo(&free, &total));
    return isDeviceError(error) ? error : cudaSuccess;
}

struct Entry {
    cudaError_t error;
    const char* name;
    const char* text;
};

#define ENTRY(name, text)                                                                          \
    { name, #name, text }
constexpr Entry kEntries[] = {
    ENTRY(cudaSuccess, "no error"),
    ENTRY(cudaErrorInvalidValue, "invalid argument"),
    ENTRY(cudaErrorMemoryAllocation, "out of memory"),
    ENTRY(cudaErrorInitializationError, "initialization error"),
    ENTRY(cudaErrorCudartUnloading, "driver shutting down"),
    ENTRY(cudaErrorProfilerDisabled, "profiler disabled while using external profiling tool"),
    ENTRY(cudaErrorInvalidConfiguration, "invalid configuration argument"),
    ENTRY(cudaErrorInvalidPitchValue, "invalid pitch argument"),
    ENTRY(cudaErrorInvalidSymbol, "invalid device symbol"),
    ENTRY(cudaErrorInvalidHostPointer, "invalid host pointer"),
    ENTRY(cudaErrorInvalidDevicePointer, "invalid device pointer"),
    ENTRY(cudaErrorInvalidTexture, "invalid texture reference"),
    ENTRY(cudaErrorInvalidTextureBinding, "texture is not bound to a pointer"),
    ENTRY(cudaErrorInvalidChannelDescriptor, "invalid channel descriptor"),
    ENTRY(cudaErrorInvalidMemcpyDirection, "invalid copy direction for memcpy"),
    ENTRY(cudaErrorInvalidFilterSetting, "linear filtering not supported for non-float type"),
    ENTRY(cudaErrorInvalidNormSetting,
          "read as normalized float not supported for 32-bit non float type"),
    ENTRY(cudaErrorStubLibrary, "the library is a stub"),
    ENTRY(cudaErrorInsufficientDriver,
          "CUDA driver version is insufficient for CUDA runtime version"),
    ENTRY(cudaErrorCallRequiresNewerDriver, "the call needs a newer driver"),
    ENTRY(cudaErrorInvalidSurface, "invalid surface reference"),
    ENTRY(cudaErrorDuplicateVariableName, "duplicate global variable looked up by string name"),
    ENTRY(cudaErrorDuplicateTextureName, "duplicate texture looked up by string name"),
    ENTRY(cudaErrorDuplicateSurfaceName, "duplicate surface looked up by string name"),
    ENTRY(cudaErrorDevicesUnavailable, "the device is busy or unavailable"),
    ENTRY(cudaErrorIncompatibleDriverContext, "incompatible driver context"),
    ENTRY(cudaErrorMissingConfiguration, "__global__ function call is not configured"),
    ENTRY(cudaErrorPriorLaunchFailure, "an earlier launch failed"),
    ENTRY(cudaErrorLaunchMaxDepthExceeded, "launch would exceed maximum depth of nested launches"),
    ENTRY(cudaErrorLaunchFileScopedTex, "launch of a kernel that reads a texture of its file"),
    ENTRY(cudaErrorLaunchFileScopedSurf, "launch of a kernel that reads a surface of its file"),
    ENTRY(cudaErrorSyncDepthExceeded, "synchronization would exceed maximum depth of launches"),
    ENTRY(cudaErrorLaunchPendingCountExceeded, "too many pending nested launches"),
    ENTRY(cudaErrorInvalidDeviceFunction, "invalid device function"),
    ENTRY(cudaErrorNoDevice, "no CUDA-capable device is detected"),
    ENTRY(cudaErrorInvalidDevice, "invalid device ordinal"),
    ENTRY(cudaErrorDeviceNotLicensed, "the device is not licensed"),
    ENTRY(cudaErrorSoftwareValidityNotEstablished, "the integrity check has not been completed"),
    ENTRY(cudaErrorStartupFailure, "startup failure in the runtime"),
    ENTRY(cudaErrorInvalidKernelImage, "device kernel image is invalid"),
    ENTRY(cudaErrorDeviceUninitialized, "invalid device context"),
    ENTRY(cudaErrorMapBufferObjectFailed, "mapping of buffer object failed"),
    ENTRY(cudaErrorUnmapBufferObjectFailed, "unmapping of buffer object failed"),
    ENTRY(cudaErrorArrayIsMapped, "array is mapped"),
    ENTRY(cudaErrorAlreadyMapped, "resource already mapped"),
    ENTRY(cudaErrorNoKernelImageForDevice,
          "no kernel image is available for execution on the device"),
    ENTRY(cudaErrorAlreadyAcquired, "resource already acquired"),
    ENTRY(cudaErrorNotMapped, "resource not mapped"),
    ENTRY(cudaErrorNotMappedAsArray, "resource not mapped as array"),
    ENTRY(cudaErrorNotMappedAsPointer, "resource not mapped as pointer"),
    ENTRY(cudaErrorECCUncorrectable, "uncorrectable memory error"),
    ENTRY(cudaErrorUnsupportedLimit, "limit is not supported on this device"),
    ENTRY(cudaErrorDeviceAlreadyInUse, "the context is in use by another thread"),
    ENTRY(cudaErrorPeerAccessUnsupported, "peer access is not supported between these two devices"),
    ENTRY(cudaErrorInvalidPtx, "a PTX compilation failed"),
    ENTRY(cudaErrorInvalidGraphicsContext, "invalid graphics context"),
    ENTRY(cudaErrorNvlinkUncorrectable, "uncorrectable link error"),
    ENTRY(cudaErrorJitCompilerNotFound, "PTX compiler not found"),
    ENTRY(cudaErrorUnsupportedPtxVersion, "the PTX version is not supported"),
    ENTRY(cudaErrorJitCompilationDisabled, "PTX compilation is disabled"),
    ENTRY(cudaErrorUnsupportedExecAffinity, "execution affinity is not supported"),
    ENTRY(cudaErrorUnsupportedDevSideSync, "device-side synchronization is not supported"),
    ENTRY(cudaErrorContained, "a contained error occurred"),
    ENTRY(cudaErrorInvalidSource, "device kernel source is invalid"),
    ENTRY(cudaErrorFileNotFound, "file not found"),
    ENTRY(cudaErrorSharedObjectSymbolNotFound, "shared object symbol not found"),
    ENTRY(cudaErrorSharedObjectInitFailed, "shared object initialization failed"),
    ENTRY(cudaErrorOperatingSystem, "an operating system call failed"),
    ENTRY(cudaErrorInvalidResourceHandle, "invalid resource handle"),
    ENTRY(cudaErrorIllegalState, "the operation is not permitted in the present state"),
    ENTRY(cudaErrorLossyQuery, "the query would lose information"),
    ENTRY(cudaErrorSymbolNotFound, "named symbol not found"),
    ENTRY(cudaErrorNotReady, "device not ready"),
    ENTRY(cudaErrorIllegalAddress, "an illegal memory access was encountered"),
    ENTRY(cudaErrorLaunchOutOfResources, "too many resources requested for launch"),
    ENTRY(cudaErrorLaunchTimeout, "the launch timed out and was terminated"),
    ENTRY(cudaErrorLaunchIncompatibleTexturing, "launch uses incompatible texturing mode"),
    ENTRY(cudaErrorPeerAccessAlreadyEnabled, "peer access is already enabled"),
    ENTRY(cudaErrorPeerAccessNotEnabled, "peer access has not been enabled"),
    ENTRY(cudaErrorSetOnActiveProcess, "the primary context is already active"),
    ENTRY(cudaErrorContextIsDestroyed, "the context has been destroyed"),
    ENTRY(cudaErrorAssert, "device-side assert triggered"),
    ENTRY(cudaErrorTooManyPeers, "too many peers"),
    ENTRY(cudaErrorHostMemoryAlreadyRegistered,
          "part or all of the memory range is already registered"),
    ENTRY(cudaErrorHostMemoryNotRegistered, "the pointer is not part of registered memory"),
    ENTRY(cudaErrorHardwareStackError, "hardware stack error"),
    ENTRY(cudaErrorIllegalInstruction, "an illegal instruction was encountered"),
    ENTRY(cudaErrorMisalignedAddress, "misaligned address"),
    ENTRY(cudaErrorInvalidAddressSpace, "operation not supported on this address space"),
    ENTRY(cudaErrorInvalidPc, "invalid program counter"),
    ENTRY(cudaErrorLaunchFailure, "the kernel failed"),
    ENTRY(cudaErrorCooperativeLaunchTooLarge, "too many blocks in cooperative launch"),
    ENTRY(cudaErrorTensorMemoryLeak, "tensor memory was not released"),
    ENTRY(cudaErrorNotPermitted, "operation not permitted"),
    ENTRY(cudaErrorNotSupported, "operation not supported"),
    ENTRY(cudaErrorSystemNotReady, "the system is not ready"),
    ENTRY(cudaErrorSystemDriverMismatch, "the driver does not match the system"),
    ENTRY(cudaErrorCompatNotSupportedOnDevice,
          "the driver's compatibility mode does not cover this device"),
    ENTRY(cudaErrorMpsConnectionFailed, "connection to the multi-process service failed"),
    ENTRY(cudaErrorMpsRpcFailure, "a call to the multi-process service failed"),
    ENTRY(cudaErrorMpsServerNotReady, "the multi-process service is not ready"),
    ENTRY(cudaErrorMpsMaxClientsReached,
          "the multi-process service has no room for another client"),
    ENTRY(cudaErrorMpsMaxConnectionsReached,
          "the multi-process service has no room for another connection"),
    ENTRY(cudaErrorMpsClientTerminated, "the client was terminated by the multi-process service"),
    ENTRY(cudaErrorCdpNotSupported, "launches from the device are not supported"),
    ENTRY(cudaErrorCdpVersionMismatch, "launches from the device do not match the driver"),
    ENTRY(cudaErrorStreamCaptureUnsupported, "operation not permitted when stream is capturing"),
    ENTRY(cudaErrorStreamCaptureInvalidated, "the capture was invalidated by an earlier error"),
    ENTRY(cudaErrorStreamCaptureMerge, "the operation would merge two captures"),
    ENTRY(cudaErrorStreamCaptureUnmatched, "the capture was not begun in this stream"),
    ENTRY(cudaErrorStreamCaptureUnjoined, "the capture has work that was not joined"),
    ENTRY(cudaErrorStreamCaptureIsolation, "the capture would depend on work outside it"),
    ENTRY(cudaErrorStreamCaptureImplicit,
          "the operation would depend implicitly on a capturing stream"),
    ENTRY(cudaErrorCapturedEvent, "operation not permitted on an event of a capturing stream"),
    ENTRY(cudaErrorStreamCaptureWrongThread, "the capture belongs to another thread"),
    ENTRY(cudaErrorTimeout, "wait timed out"),
    ENTRY(cudaErrorGraphExecUpdateFailure, "the graph update is not possible"),
    ENTRY(cudaErrorExternalDevice, "an error occurred outside the device"),
    ENTRY(cudaErrorInvalidClusterSize, "the cluster size is invalid"),
    ENTRY(cudaErrorFunctionNotLoaded, "the function is not loaded"),
    ENTRY(cudaErrorInvalidResourceType, "invalid resource type"),
    ENTRY(cudaErrorInvalidResourceConfiguration, "invalid resource configuration"),
    ENTRY(cudaErrorUnknown, "unknown error"),
};
#undef ENTRY

const Entry* entryOf(cudaError_t error) {
    for (const Entry& entry : kEntries)
        if (entry.error == error)
            return &entry;
    return nullptr;
}

} // namespace

cudaError_t remember(cudaError_t error) {
    // "Not ready" is not a failure. Errors kept by the context are queried from it.
    mayHaveFailed |= isDeviceError(error);
    const bool stays = isDeviceError(error) && contextError() == error;
    if (error != cudaSuccess && error != cudaErrorNotReady && !stays)
        lastError = error;
    return error;
}

void forgetLastError() {
    lastError = cudaSuccess;
}

// For unsupported.cpp, which does not include our header.
int rememberNotSupported();
int rememberNotSupported() {
    return remember(cudaErrorNotSupported);
}

cudaError_t fromDriver(CUresult result) {
    // The numbers are equal, except for codes that the runtime lacks.
    const cudaError_t error = static_cast<cudaError_t>(result);
    return entryOf(error) ? error : cudaErrorUnknown;
}

} // namespace sunstone::cudart

using namespace sunstone::cudart;

SUNSTONE_CUDART cudaError_t cudaGetLastError(void) {
    const cudaError_t error = cudaPeekAtLastError();
    lastError = cudaSuccess;
    return error;
}
SUNSTONE_CUDART cudaError_t cudaPeekAtLastError(void) {
    const cudaError_t fault = mayHaveFailed ? contextError() : cudaSuccess;
    mayHaveFailed = fault != cudaSuccess;
    return mayHaveFailed ? fault : lastError;
}

SUNSTONE_CUDART const char* cudaGetErrorName(cudaError_t error) {
    const Entry* entry = entryOf(error);
    return entry ? entry->name : "unrecognized error code";
}
SUNSTONE_CUDART const char* cudaGetErrorString(cudaError_t error) {
    const Entry* entry = entryOf(error);
    return entry ? entry->text : "unrecognized error code";
}
