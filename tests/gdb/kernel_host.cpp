// SPDX-License-Identifier: Apache-2.0
// Launches the kernel `accumulate` of the PTX file that the argument names, for one thread, and
// prints the result. Runs under gdb: see check.cmake.
#include <cuda.h>

#include <cstdio>
#include <cstdlib>

static void check(CUresult result, const char* what) {
    if (result == CUDA_SUCCESS)
        return;
    std::fprintf(stderr, "%s: %d\n", what, int(result));
    std::exit(1);
}

int main(int argc, char** argv) {
    check(cuInit(0), "cuInit");
    CUcontext context = nullptr;
    check(cuDevicePrimaryCtxRetain(&context, 0), "context");
    check(cuCtxSetCurrent(context), "current");
    CUmodule module = nullptr;
    CUfunction kernel = nullptr;
    check(cuModuleLoad(&module, argc > 1 ? argv[1] : ""), "module");
    check(cuModuleGetFunction(&kernel, module, "accumulate"), "function");
    CUdeviceptr out = 0;
    check(cuMemAlloc(&out, sizeof(int)), "memory");
    int count = 3, result = 0;
    void* params[] = {&out, &count};
    check(cuLaunchKernel(kernel, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr), "launch");
    check(cuMemcpyDtoH(&result, out, sizeof result), "copy");
    std::printf("result %d\n", result);
    return 0;
}
