// SPDX-License-Identifier: Apache-2.0
// A library whose static constructor and destructor launch kernels on new streams and wait for
// them, in dlopen and dlclose. The program's variable gWaited receives the results.
#include <cuda.h>

#include <initializer_list>

extern int gWaited[2];

namespace {

// Threads that meet: in functions that the kernel calls by address, each thread has a stack.
constexpr const char* kText = R"(
.version 7.0
.target sm_75
.address_size 64
.visible .entry straight(.param .u64 out) {
    .reg .u64 %rd1;
    .reg .u32 %r<2>;
    ld.param.u64 %rd1, [out];
    bar.sync 0;
    atom.global.add.u32 %r1, [%rd1], 1;
    ret;
}
.func meet(.param .u64 out) {
    .reg .u64 %rd1;
    .reg .u32 %r<2>;
    ld.param.u64 %rd1, [out];
    bar.sync 0;
    atom.global.add.u32 %r1, [%rd1], 100;
    ret;
}
.global .u64 functions[1] = {meet};
.visible .entry indirect(.param .u64 out) {
    .reg .u64 %rd<3>;
    ld.param.u64 %rd1, [out];
    ld.global.u64 %rd2, [functions];
    {
        .param .u64 p;
        st.param.u64 [p], %rd1;
        prototype: .callprototype _ (.param .u64 _);
        call %rd2, (p), prototype;
    }
    ret;
}
)";

// Returns the sum that 64 threads of each kernel make.
int launchAndWait() {
    CUcontext context;
    CUmodule module;
    CUdeviceptr memory;
    if (cuInit(0) != CUDA_SUCCESS || cuDevicePrimaryCtxRetain(&context, 0) != CUDA_SUCCESS ||
        cuCtxPushCurrent(context) != CUDA_SUCCESS || cuMemAlloc(&memory, 4) != CUDA_SUCCESS ||
        cuMemsetD32(memory, 0, 1) != CUDA_SUCCESS ||
        cuModuleLoadData(&module, kText) != CUDA_SUCCESS)
        return -1;
    for (const char* name : {"straight", "indirect"}) {
        CUfunction kernel;
        CUstream stream;
        void* arguments[] = {&memory};
        if (cuModuleGetFunction(&kernel, module, name) != CUDA_SUCCESS ||
            cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING) != CUDA_SUCCESS ||
            cuLaunchKernel(kernel, 1, 1, 1, 64, 1, 1, 0, stream, arguments, nullptr) !=
                CUDA_SUCCESS ||
            cuStreamSynchronize(stream) != CUDA_SUCCESS || cuStreamDestroy(stream) != CUDA_SUCCESS)
            return -2;
    }
    int sum = 0;
    if (cuMemcpyDtoH(&sum, memory, 4) != CUDA_SUCCESS || cuModuleUnload(module) != CUDA_SUCCESS ||
        cuMemFree(memory) != CUDA_SUCCESS || cuCtxPopCurrent(nullptr) != CUDA_SUCCESS ||
        cuDevicePrimaryCtxRelease(0) != CUDA_SUCCESS)
        return -3;
    return sum;
}

const struct Library {
    Library() { gWaited[0] = launchAndWait(); }
    ~Library() { gWaited[1] = launchAndWait(); }
} gLibrary;

} // namespace
