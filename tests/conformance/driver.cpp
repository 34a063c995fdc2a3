// SPDX-License-Identifier: Apache-2.0
// See driver.h.
#include "driver.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>

namespace conformance {

namespace {

template <class Signature>
void bind(const Driver& driver, Signature*& function, const char* name) {
    void* symbol = driver.find(name);
    std::memcpy(&function, &symbol, sizeof function);
}

} // namespace

void quit(int code, const std::string& text) {
    std::fprintf(stderr, "%s\n", text.c_str());
    std::fflush(stdout);
    std::exit(code);
}

void* Driver::find(const char* name) const {
    void* symbol = dlsym(library_, name);
    if (!symbol)
        quit(1, std::string("libcuda.so.1 without ") + name);
    return symbol;
}

Driver::Driver() : library_(dlopen("libcuda.so.1", RTLD_NOW)) {
    if (!library_)
        quit(1, "no libcuda.so.1");
#define TEXT(name) #name
#define X(name) bind(*this, name, TEXT(name));
    CONFORMANCE_FUNCTIONS(X)
#undef X
#undef TEXT
    if (cuInit(0) != CUDA_SUCCESS || cuDeviceGet(&device_, 0) != CUDA_SUCCESS)
        quit(1, "no CUDA device");
    CUcontext context = nullptr;
    if (cuDevicePrimaryCtxRetain(&context, device_) != CUDA_SUCCESS ||
        cuCtxSetCurrent(context) != CUDA_SUCCESS)
        quit(1, "no CUDA context");
}

CUdeviceptr Driver::allocate(size_t size) const {
    CUdeviceptr address = 0;
    if (cuMemAlloc(&address, size ? size : 1) != CUDA_SUCCESS)
        quit(1, "cuMemAlloc");
    return address;
}

void Driver::release(CUdeviceptr address) const {
    cuMemFree(address);
}

void Driver::copyIn(CUdeviceptr to, const void* from, size_t size) const {
    if (cuMemcpyHtoD(to, from, size) != CUDA_SUCCESS)
        quit(1, "cuMemcpyHtoD");
}

bool Driver::copyOut(void* to, CUdeviceptr from, size_t size) const {
    return cuMemcpyDtoH(to, from, size) == CUDA_SUCCESS;
}

void Driver::clear(CUdeviceptr address, size_t size) const {
    if (cuMemsetD8(address, 0, size) != CUDA_SUCCESS)
        quit(1, "cuMemsetD8");
}

std::string Driver::describe() const {
    char name[100] = {};
    int version = 0;
    cuDeviceGetName(name, sizeof name - 1, device_);
    cuDriverGetVersion(&version);
    return std::string(name) + ", CUDA " + std::to_string(version / 1000) + "." +
           std::to_string(version % 1000 / 10);
}

} // namespace conformance
