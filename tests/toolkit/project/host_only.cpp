// SPDX-License-Identifier: Apache-2.0
// Compiles a kernel at run time and launches it by the driver.
#include <cuda.h>
#include <cuda_runtime.h>
#include <nvrtc.h>

#include <cstdio>
#include <vector>

int main() {
    nvrtcProgram program;
    const char* source = "extern \"C\" __global__ void put(int* to) { *to = 1234; }";
    const char* option = "-arch=compute_75";
    if (nvrtcCreateProgram(&program, source, "put.cu", 0, nullptr, nullptr) ||
        nvrtcCompileProgram(program, 1, &option))
        return std::printf("nvrtc failed\n"), 1;
    size_t size = 0;
    nvrtcGetPTXSize(program, &size);
    std::vector<char> ptx(size);
    nvrtcGetPTX(program, ptx.data());
    nvrtcDestroyProgram(&program);
    void* memory = nullptr;
    if (cudaMalloc(&memory, 4))
        return std::printf("cudaMalloc failed\n"), 1;
    CUmodule module;
    CUfunction function;
    void* arguments[] = {&memory};
    if (cuModuleLoadData(&module, ptx.data()) || cuModuleGetFunction(&function, module, "put") ||
        cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, arguments, nullptr))
        return std::printf("the driver failed\n"), 1;
    int value = 0;
    cudaMemcpy(&value, memory, 4, cudaMemcpyDeviceToHost);
    std::printf("value %d\n", value);
    return value != 1234;
}
