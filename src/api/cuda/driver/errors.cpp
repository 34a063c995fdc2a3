// SPDX-License-Identifier: Apache-2.0
// Names and descriptions of CUresult values.
#include "api/cuda/driver/shell.h"

#include <algorithm>
#include <iterator>

namespace sunstone::api::cuda {

namespace {

struct Entry {
    CUresult result;
    const char* name;
    const char* text;
};

#define ENTRY(name, text)                                                                          \
    { name, #name, text }
// Ascending.
constexpr Entry kEntries[] = {
    ENTRY(CUDA_SUCCESS, "no error"),
    ENTRY(CUDA_ERROR_INVALID_VALUE, "invalid argument"),
    ENTRY(CUDA_ERROR_OUT_OF_MEMORY, "out of memory"),
    ENTRY(CUDA_ERROR_NOT_INITIALIZED, "initialization error"),
    ENTRY(CUDA_ERROR_DEINITIALIZED, "driver shutting down"),
    ENTRY(CUDA_ERROR_PROFILER_DISABLED, "profiler disabled while using external profiling tool"),
    ENTRY(CUDA_ERROR_STUB_LIBRARY, "the library is a stub"),
    ENTRY(CUDA_ERROR_DEVICE_UNAVAILABLE, "the device is busy or unavailable"),
    ENTRY(CUDA_ERROR_NO_DEVICE, "no CUDA-capable device is detected"),
    ENTRY(CUDA_ERROR_INVALID_DEVICE, "invalid device ordinal"),
    ENTRY(CUDA_ERROR_DEVICE_NOT_LICENSED, "the device is not licensed"),
    ENTRY(CUDA_ERROR_INVALID_IMAGE, "device kernel image is invalid"),
    ENTRY(CUDA_ERROR_INVALID_CONTEXT, "invalid device context"),
    ENTRY(CUDA_ERROR_CONTEXT_ALREADY_CURRENT, "the context is already current"),
    ENTRY(CUDA_ERROR_MAP_FAILED, "mapping of buffer object failed"),
    ENTRY(CUDA_ERROR_UNMAP_FAILED, "unmapping of buffer object failed"),
    ENTRY(CUDA_ERROR_ARRAY_IS_MAPPED, "array is mapped"),
    ENTRY(CUDA_ERROR_ALREADY_MAPPED, "resource already mapped"),
    ENTRY(CUDA_ERROR_NO_BINARY_FOR_GPU, "no kernel image is available for execution on the device"),
    ENTRY(CUDA_ERROR_ALREADY_ACQUIRED, "resource already acquired"),
    ENTRY(CUDA_ERROR_NOT_MAPPED, "resource not mapped"),
    ENTRY(CUDA_ERROR_NOT_MAPPED_AS_ARRAY, "resource not mapped as array"),
    ENTRY(CUDA_ERROR_NOT_MAPPED_AS_POINTER, "resource not mapped as pointer"),
    ENTRY(CUDA_ERROR_ECC_UNCORRECTABLE, "uncorrectable memory error"),
    ENTRY(CUDA_ERROR_UNSUPPORTED_LIMIT, "limit is not supported on this device"),
    ENTRY(CUDA_ERROR_CONTEXT_ALREADY_IN_USE, "the context is in use by another thread"),
    ENTRY(CUDA_ERROR_PEER_ACCESS_UNSUPPORTED,
          "peer access is not supported between these two devices"),
    ENTRY(CUDA_ERROR_INVALID_PTX, "a PTX compilation failed"),
    ENTRY(CUDA_ERROR_INVALID_GRAPHICS_CONTEXT, "invalid graphics context"),
    ENTRY(CUDA_ERROR_NVLINK_UNCORRECTABLE, "uncorrectable link error"),
    ENTRY(CUDA_ERROR_JIT_COMPILER_NOT_FOUND, "PTX compiler not found"),
    ENTRY(CUDA_ERROR_UNSUPPORTED_PTX_VERSION, "the PTX version is not supported"),
    ENTRY(CUDA_ERROR_JIT_COMPILATION_DISABLED, "PTX compilation is disabled"),
    ENTRY(CUDA_ERROR_UNSUPPORTED_EXEC_AFFINITY, "execution affinity is not supported"),
    ENTRY(CUDA_ERROR_UNSUPPORTED_DEVSIDE_SYNC, "device-side synchronization is not supported"),
    ENTRY(CUDA_ERROR_CONTAINED, "a contained error occurred"),
    ENTRY(CUDA_ERROR_INVALID_SOURCE, "device kernel source is invalid"),
    ENTRY(CUDA_ERROR_FILE_NOT_FOUND, "file not found"),
    ENTRY(CUDA_ERROR_SHARED_OBJECT_SYMBOL_NOT_FOUND, "shared object symbol not found"),
    ENTRY(CUDA_ERROR_SHARED_OBJECT_INIT_FAILED, "shared object initialization failed"),
    ENTRY(CUDA_ERROR_OPERATING_SYSTEM, "an operating system call failed"),
    ENTRY(CUDA_ERROR_INVALID_HANDLE, "invalid resource handle"),
    ENTRY(CUDA_ERROR_ILLEGAL_STATE, "the operation is not permitted in the present state"),
    ENTRY(CUDA_ERROR_LOSSY_QUERY, "the query would lose information"),
    ENTRY(CUDA_ERROR_NOT_FOUND, "named symbol not found"),
    ENTRY(CUDA_ERROR_NOT_READY, "device not ready"),
    ENTRY(CUDA_ERROR_ILLEGAL_ADDRESS, "an illegal memory access was encountered"),
    ENTRY(CUDA_ERROR_LAUNCH_OUT_OF_RESOURCES, "too many resources requested for launch"),
    ENTRY(CUDA_ERROR_LAUNCH_TIMEOUT, "the launch timed out and was terminated"),
    ENTRY(CUDA_ERROR_LAUNCH_INCOMPATIBLE_TEXTURING, "launch uses incompatible texturing mode"),
    ENTRY(CUDA_ERROR_PEER_ACCESS_ALREADY_ENABLED, "peer access is already enabled"),
    ENTRY(CUDA_ERROR_PEER_ACCESS_NOT_ENABLED, "peer access has not been enabled"),
    ENTRY(CUDA_ERROR_PRIMARY_CONTEXT_ACTIVE, "the primary context is already active"),
    ENTRY(CUDA_ERROR_CONTEXT_IS_DESTROYED, "the context has been destroyed"),
    ENTRY(CUDA_ERROR_ASSERT, "device-side assert triggered"),
    ENTRY(CUDA_ERROR_TOO_MANY_PEERS, "too many peers"),
    ENTRY(CUDA_ERROR_HOST_MEMORY_ALREADY_REGISTERED,
          "part or all of the memory range is already registered"),
    ENTRY(CUDA_ERROR_HOST_MEMORY_NOT_REGISTERED, "the pointer is not part of registered memory"),
    ENTRY(CUDA_ERROR_HARDWARE_STACK_ERROR, "hardware stack error"),
    ENTRY(CUDA_ERROR_ILLEGAL_INSTRUCTION, "an illegal instruction was encountered"),
    ENTRY(CUDA_ERROR_MISALIGNED_ADDRESS, "misaligned address"),
    ENTRY(CUDA_ERROR_INVALID_ADDRESS_SPACE, "operation not supported on this address space"),
    ENTRY(CUDA_ERROR_INVALID_PC, "invalid program counter"),
    ENTRY(CUDA_ERROR_LAUNCH_FAILED, "the kernel failed"),
    ENTRY(CUDA_ERROR_COOPERATIVE_LAUNCH_TOO_LARGE, "too many blocks in cooperative launch"),
    ENTRY(CUDA_ERROR_TENSOR_MEMORY_LEAK, "tensor memory was not released"),
    ENTRY(CUDA_ERROR_NOT_PERMITTED, "operation not permitted"),
    ENTRY(CUDA_ERROR_NOT_SUPPORTED, "operation not supported"),
    ENTRY(CUDA_ERROR_SYSTEM_NOT_READY, "the system is not ready"),
    ENTRY(CUDA_ERROR_SYSTEM_DRIVER_MISMATCH, "the driver does not match the system"),
    ENTRY(CUDA_ERROR_COMPAT_NOT_SUPPORTED_ON_DEVICE,
          "the driver's compatibility mode does not cover this device"),
    ENTRY(CUDA_ERROR_MPS_CONNECTION_FAILED, "connection to the multi-process service failed"),
    ENTRY(CUDA_ERROR_MPS_RPC_FAILURE, "a call to the multi-process service failed"),
    ENTRY(CUDA_ERROR_MPS_SERVER_NOT_READY, "the multi-process service is not ready"),
    ENTRY(CUDA_ERROR_MPS_MAX_CLIENTS_REACHED,
          "the multi-process service has no room for another client"),
    ENTRY(CUDA_ERROR_MPS_MAX_CONNECTIONS_REACHED,
          "the multi-process service has no room for another connection"),
    ENTRY(CUDA_ERROR_MPS_CLIENT_TERMINATED,
          "the client was terminated by the multi-process service"),
    ENTRY(CUDA_ERROR_CDP_NOT_SUPPORTED, "launches from the device are not supported"),
    ENTRY(CUDA_ERROR_CDP_VERSION_MISMATCH, "launches from the device do not match the driver"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_UNSUPPORTED,
          "operation not permitted when stream is capturing"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_INVALIDATED, "the capture was invalidated by an earlier error"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_MERGE, "the operation would merge two captures"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_UNMATCHED, "the capture was not begun in this stream"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_UNJOINED, "the capture has work that was not joined"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_ISOLATION, "the capture would depend on work outside it"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_IMPLICIT,
          "the operation would depend implicitly on a capturing stream"),
    ENTRY(CUDA_ERROR_CAPTURED_EVENT, "operation not permitted on an event of a capturing stream"),
    ENTRY(CUDA_ERROR_STREAM_CAPTURE_WRONG_THREAD, "the capture belongs to another thread"),
    ENTRY(CUDA_ERROR_TIMEOUT, "wait timed out"),
    ENTRY(CUDA_ERROR_GRAPH_EXEC_UPDATE_FAILURE, "the graph update is not possible"),
    ENTRY(CUDA_ERROR_EXTERNAL_DEVICE, "an error occurred outside the device"),
    ENTRY(CUDA_ERROR_INVALID_CLUSTER_SIZE, "the cluster size is invalid"),
    ENTRY(CUDA_ERROR_FUNCTION_NOT_LOADED, "the function is not loaded"),
    ENTRY(CUDA_ERROR_INVALID_RESOURCE_TYPE, "invalid resource type"),
    ENTRY(CUDA_ERROR_INVALID_RESOURCE_CONFIGURATION, "invalid resource configuration"),
    ENTRY(CUDA_ERROR_UNKNOWN, "unknown error"),
};
#undef ENTRY

const Entry* entryOf(CUresult result) {
    auto found = std::lower_bound(std::begin(kEntries), std::end(kEntries), result,
                                  [](const Entry& e, CUresult r) { return e.result < r; });
    return found != std::end(kEntries) && found->result == result ? found : nullptr;
}

} // namespace

const char* nameOf(CUresult result) {
    const Entry* entry = entryOf(result);
    return entry ? entry->name : nullptr;
}

const char* textOf(CUresult result) {
    const Entry* entry = entryOf(result);
    return entry ? entry->text : nullptr;
}

} // namespace sunstone::api::cuda
