// SPDX-License-Identifier: Apache-2.0
// cuGetProcAddress: finds exported functions by their plain names, in the form for the caller's
// CUDA version. Also exports the unsuffixed names that drivers have beside the current ones.
#include "api/cuda/driver/entry_point_versions.h"
#include "api/cuda/driver/shell.h"

#include "base/log.h"

#include <dlfcn.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
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

struct Form {
    int since;
    const char* suffix;
};
const std::map<std::string_view, std::vector<Form>>& forms() {
    static const auto* table = [] {
        auto* made = new std::map<std::string_view, std::vector<Form>>;
        for (const EntryPoints& row : kEntryPoints)
            for (std::string_view names = row.names; !names.empty();) {
                const size_t end = std::min(names.find(' '), names.size());
                (*made)[names.substr(0, end)].push_back({row.since, row.form});
                names.remove_prefix(std::min(end + 1, names.size()));
            }
        return made;
    }();
    return *table;
}

struct Found {
    void* function = nullptr;
    CUdriverProcAddressQueryResult status = CU_GET_PROC_ADDRESS_SYMBOL_NOT_FOUND;
};

// The form of a function for a caller of this version. Functions on a default stream have another
// form for the per-thread default stream, since version 7.0.
Found lookUp(const std::string& symbol, int version, bool perThread) {
    constexpr int kPerThreadSince = 7000;
    const auto named = forms().find(symbol);
    if (named == forms().end())
        return {};
    const auto formAt = [&](int asked) {
        const Form* newest = nullptr;
        for (const Form& form : named->second)
            newest = form.since <= asked ? &form : newest;
        return newest;
    };
    const auto ofThread = [&](const Form& form) -> void* {
        if (symbol == "cuGetProcAddress") // its own flags say which
            return nullptr;
        for (const char* stream : {"_ptsz", "_ptds"})
            if (void* found = dlsym(ownLibrary(), (symbol + form.suffix + stream).c_str()))
                return found;
        return nullptr;
    };
    if (perThread && ofThread(named->second.back())) {
        const Form* form = version < kPerThreadSince ? nullptr : formAt(version);
        return form ? Found{ofThread(*form), CU_GET_PROC_ADDRESS_SUCCESS}
                    : Found{nullptr, CU_GET_PROC_ADDRESS_VERSION_NOT_SUFFICIENT};
    }
    const Form* form = formAt(version);
    return form ? Found{dlsym(ownLibrary(), (symbol + form->suffix).c_str()),
                        CU_GET_PROC_ADDRESS_SUCCESS}
                : Found{nullptr, CU_GET_PROC_ADDRESS_VERSION_NOT_SUFFICIENT};
}

CUresult procAddress(const char* symbol, void** function, int version, cuuint64_t flags,
                     CUdriverProcAddressQueryResult* status) {
    constexpr int kNewest = -1;
    return guarded("cuGetProcAddress", Needs::kNothing, [&] {
        require(symbol && function, "symbol or function is null");
        require((flags & ~cuuint64_t(CU_GET_PROC_ADDRESS_LEGACY_STREAM |
                                     CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM)) == 0,
                "unknown flags");
        if (version > kDriverVersion)
            refuse(CUDA_ERROR_INVALID_VALUE, "version ", version, " is newer than the driver's, ",
                   kDriverVersion);
        const Found found = lookUp(symbol, version == kNewest ? kDriverVersion : version,
                                   flags & CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM);
        *function = found.function;
        if (status)
            *status = found.status;
        if (found.function)
            return CUDA_SUCCESS;
        logOnce(LogLevel::kWarning, "cuda",
                message("cuGetProcAddress: no function ", symbol, " of version ", version));
        return status ? CUDA_SUCCESS : CUDA_ERROR_NOT_FOUND;
    });
}

} // namespace

SUNSTONE_EXPORT CUresult cuGetProcAddress(const char* symbol, void** function, int cudaVersion,
                                          cuuint64_t flags,
                                          CUdriverProcAddressQueryResult* status) {
    return procAddress(symbol, function, cudaVersion, flags, status);
}
// For callers compiled with the per-thread default stream.
SUNSTONE_EXPORT CUresult cuGetProcAddress_v2_ptsz(const char* symbol, void** function,
                                                  int cudaVersion, cuuint64_t flags,
                                                  CUdriverProcAddressQueryResult* status) {
    if (flags == CU_GET_PROC_ADDRESS_DEFAULT)
        flags = CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM;
    return procAddress(symbol, function, cudaVersion, flags, status);
}

// The first form of cuGetProcAddress has no status; the other functions here have the parameters of
// their successors.
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
