// SPDX-License-Identifier: Apache-2.0
// cuGetProcAddress: the exported functions by their plain names, in the form the caller's CUDA
// version expects; and the unsuffixed names drivers export beside the current ones.
#include "api/cuda/driver/shell.h"
#include "api/cuda/driver/unsupported.h"

#include "base/log.h"

#include <dlfcn.h>

#include <climits>
#include <cstring>
#include <string>
#include <vector>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

void* ownLibrary() {
    static void* const handle = [] {
        Dl_info info{};
        return dladdr(reinterpret_cast<void*>(&ownLibrary), &info) != 0
                   ? dlopen(info.dli_fname, RTLD_NOW | RTLD_NOLOAD)
                   : nullptr;
    }();
    return handle;
}

// Where the newest form is not the one that a plain name means to callers before a version.
constexpr struct {
    const char* symbol;
    int before;
    const char* form;
} kOlderForms[] = {
    {"cuCtxCreate", 13000, "_v2"},
    {"cuMemAdvise", 13000, ""},
    {"cuMemPrefetchAsync", 13000, ""},
    // Functions of their own, with another parameter.
    {"cuCtxSynchronize", INT_MAX, ""},
    {"cuCtxGetDevice", INT_MAX, ""},
};

// The newest form of a function that a caller of this version knows. What is not supported serves
// only where nothing else has the name.
void* lookUp(const std::string& symbol, int version, bool perThread) {
    std::vector<const char*> forms = {"_v4", "_v3", "_v2", ""};
    for (const auto& older : kOlderForms)
        if (symbol == older.symbol && version < older.before)
            forms = {older.form};
    void* unsupported = nullptr;
    const auto find = [&](const std::string& name) -> void* {
        void* found = dlsym(ownLibrary(), name.c_str());
        if (!found || !isUnsupported(name))
            return found;
        unsupported = unsupported ? unsupported : found;
        return nullptr;
    };
    for (const char* form : forms) {
        const std::string name = symbol + form;
        if (perThread)
            for (const char* suffix : {"_ptsz", "_ptds"})
                if (void* found = find(name + suffix))
                    return found;
        if (void* found = find(name))
            return found;
    }
    return unsupported;
}

CUresult procAddress(const char* symbol, void** function, int version, cuuint64_t flags,
                     CUdriverProcAddressQueryResult* status) {
    return guarded("cuGetProcAddress", Needs::kNothing, [&] {
        require(symbol && function, "symbol or function is null");
        require(flags <= CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM, "unknown flags");
        *function = nullptr;
        if (std::strncmp(symbol, "cu", 2) == 0)
            *function =
                lookUp(symbol, version, flags == CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM);
        if (status)
            *status =
                *function ? CU_GET_PROC_ADDRESS_SUCCESS : CU_GET_PROC_ADDRESS_SYMBOL_NOT_FOUND;
        if (*function)
            return CUDA_SUCCESS;
        logOnce(LogLevel::kWarning, "cuda", message("cuGetProcAddress: no function ", symbol));
        return status ? CUDA_SUCCESS : CUDA_ERROR_NOT_FOUND;
    });
}

} // namespace

SUNSTONE_EXPORT CUresult cuGetProcAddress(const char* symbol, void** function, int cudaVersion,
                                          cuuint64_t flags,
                                          CUdriverProcAddressQueryResult* status) {
    return procAddress(symbol, function, cudaVersion, flags, status);
}

// The first form of cuGetProcAddress has no status; the others have the parameters of their
// successors.
#undef cuGetProcAddress
SUNSTONE_EXPORT CUresult cuGetProcAddress(const char* symbol, void** function, int cudaVersion,
                                          cuuint64_t flags) {
    return procAddress(symbol, function, cudaVersion, flags, nullptr);
}

#define SUNSTONE_PLAIN(name, params, args)                                                         \
    SUNSTONE_EXPORT CUresult name params {                                                         \
        return name##_v2 args;                                                                     \
    }
#undef cuCtxDestroy
#undef cuCtxPushCurrent
#undef cuCtxPopCurrent
#undef cuStreamDestroy
#undef cuEventDestroy
#undef cuEventElapsedTime
#undef cuDevicePrimaryCtxRelease
#undef cuDevicePrimaryCtxReset
#undef cuDevicePrimaryCtxSetFlags
#undef cuDeviceGetUuid
#undef cuMemHostRegister
#undef cuLinkCreate
#undef cuLinkAddData
#undef cuLinkAddFile
SUNSTONE_PLAIN(cuCtxDestroy, (CUcontext context), (context))
SUNSTONE_PLAIN(cuCtxPushCurrent, (CUcontext context), (context))
SUNSTONE_PLAIN(cuCtxPopCurrent, (CUcontext * context), (context))
SUNSTONE_PLAIN(cuStreamDestroy, (CUstream stream), (stream))
SUNSTONE_PLAIN(cuEventDestroy, (CUevent event), (event))
SUNSTONE_PLAIN(cuEventElapsedTime, (float* milliseconds, CUevent start, CUevent end),
               (milliseconds, start, end))
SUNSTONE_PLAIN(cuDevicePrimaryCtxRelease, (CUdevice device), (device))
SUNSTONE_PLAIN(cuDevicePrimaryCtxReset, (CUdevice device), (device))
SUNSTONE_PLAIN(cuDevicePrimaryCtxSetFlags, (CUdevice device, unsigned int flags), (device, flags))
SUNSTONE_PLAIN(cuDeviceGetUuid, (CUuuid * uuid, CUdevice device), (uuid, device))
SUNSTONE_PLAIN(cuLinkCreate,
               (unsigned int count, CUjit_option* options, void** values, CUlinkState* state),
               (count, options, values, state))
SUNSTONE_PLAIN(cuLinkAddData,
               (CUlinkState state, CUjitInputType type, void* data, size_t size, const char* name,
                unsigned int count, CUjit_option* options, void** values),
               (state, type, data, size, name, count, options, values))
SUNSTONE_PLAIN(cuLinkAddFile,
               (CUlinkState state, CUjitInputType type, const char* path, unsigned int count,
                CUjit_option* options, void** values),
               (state, type, path, count, options, values))
SUNSTONE_PLAIN(cuMemHostRegister, (void* address, size_t bytes, unsigned int flags),
               (address, bytes, flags))
