// SPDX-License-Identifier: Apache-2.0
// Tests only: the CPU device's libcuda (TEST_CUDA_LIBRARY) as the driver of a GPU, in this
// process's memory, with its context current.
#pragma once

#include "device/cuda/driver.h"

#include <dlfcn.h>

namespace sunstone::device::cuda {

inline const Driver& testDriver() {
    static const Driver driver = [] {
        Driver made;
        void* const library = dlopen(TEST_CUDA_LIBRARY, RTLD_NOW | RTLD_LOCAL);
        if (!library)
            fail(Code::kNotInitialized, dlerror());
#define SUNSTONE_CUDA_MEMBER(member, function)                                                     \
    made.member = reinterpret_cast<decltype(made.member)>(dlsym(library, DriverNames::member));    \
    if (!made.member)                                                                              \
        fail(Code::kNotInitialized, DriverNames::member);
        SUNSTONE_CUDA_FUNCTIONS(SUNSTONE_CUDA_MEMBER)
        SUNSTONE_CUDA_NEWER_FUNCTIONS(SUNSTONE_CUDA_MEMBER)
#undef SUNSTONE_CUDA_MEMBER
        const auto createContext = reinterpret_cast<decltype(&cuDevicePrimaryCtxRetain)>(
            dlsym(library, "cuDevicePrimaryCtxRetain"));
        const auto setContext =
            reinterpret_cast<decltype(&cuCtxSetCurrent)>(dlsym(library, "cuCtxSetCurrent"));
        CUcontext context = nullptr;
        if (made.init(0) || createContext(&context, 0) || setContext(context))
            fail(Code::kNotInitialized, "no context on the CPU device");
        return made;
    }();
    return driver;
}

} // namespace sunstone::device::cuda
