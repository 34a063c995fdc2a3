// SPDX-License-Identifier: Apache-2.0
// Driver API functions that only return CUDA_ERROR_NOT_SUPPORTED, so that programs link and start
// and fail at the call. cuda.h is not included: it would rename the functions and declare some of
// them. Callers pass arguments, which the calling convention allows a function to ignore.
#include "api/cuda/driver/unsupported_names.h"
#include "base/error.h"
#include "base/forked.h"
#include "base/log.h"

#include <dlfcn.h>
#include <string>

namespace sunstone::api::cuda {

namespace {

constexpr int kNotInitialized = 3; // CUDA_ERROR_NOT_INITIALIZED
constexpr int kNotSupported = 801; // CUDA_ERROR_NOT_SUPPORTED

int refuseWith(const std::string& cause) {
    logOnce(LogLevel::kFatal, "cuda", cause);
    return kNotSupported;
}

int refuseCall(const char* function) {
    if (refusesForkedChild())
        return kNotInitialized;
    return refuseWith(
        message(function, ": CUDA_ERROR_NOT_SUPPORTED: the function is not implemented"));
}

// The path of the loaded file that holds an address.
std::string fileOf(const void* address) {
    Dl_info info;
    return dladdr(address, &info) && info.dli_fname ? info.dli_fname : "the program";
}

// The toolkit's runtimes are the callers of this function.
int refuseTable(const void* caller) {
    if (refusesForkedChild())
        return kNotInitialized;
    const std::string own = fileOf(reinterpret_cast<const void*>(&refuseTable));
    const std::string folder = own.substr(0, own.find_last_of('/'));
    return refuseWith(message(
        "cuGetExportTable: CUDA_ERROR_NOT_SUPPORTED: ", fileOf(caller),
        " contains the toolkit's CUDA runtime, which reaches the driver through undocumented "
        "tables. `sunstone run` redirects a static runtime if the file has its symbol table. Link "
        "a "
        "stripped file again, with the shared runtime (nvcc -cudart shared; CMake: "
        "-DCMAKE_CUDA_RUNTIME_LIBRARY=Shared) or with Sunstone's archive (nvcc -L",
        folder, "; find_package(CUDAToolkit): -DCUDA_cudart_static_LIBRARY=", folder,
        "/libcudart_static.a)"));
}

} // namespace

} // namespace sunstone::api::cuda

#define SUNSTONE_REFUSE(name)                                                                      \
    extern "C" __attribute__((visibility("default"))) int name() {                                 \
        return sunstone::api::cuda::refuseCall(#name);                                             \
    }
SUNSTONE_UNSUPPORTED_FUNCTIONS(SUNSTONE_REFUSE)

extern "C" __attribute__((visibility("default"))) int cuGetExportTable() {
    return sunstone::api::cuda::refuseTable(__builtin_return_address(0));
}
