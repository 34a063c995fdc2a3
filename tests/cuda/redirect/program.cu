// SPDX-License-Identifier: Apache-2.0
// A program with a static runtime, whose plug-ins have a static runtime each: the first is linked,
// the others are opened, closed and opened again.
#include <cuda_runtime.h>

#include <cstdio>
#include <dlfcn.h>

__device__ int offset = 1;
__global__ void count(int* to) {
    to[threadIdx.x] = int(threadIdx.x) + offset;
}

extern "C" int linkedSum(int start);
// Its name begins as those of the runtime do.
extern "C" __attribute__((noinline)) int cudaOfTheProgram(int value) {
    return value + 7;
}

// Before main, as static objects of libraries do.
static int devices = [] {
    int number = 0;
    return cudaGetDeviceCount(&number) == cudaSuccess ? number : -1;
}();

static int ownSum() {
    int* memory = nullptr;
    int values[32] = {}, sum = 0;
    if (cudaMalloc(reinterpret_cast<void**>(&memory), sizeof values) != cudaSuccess)
        return -1;
    count<<<1, 32>>>(memory);
    if (cudaMemcpy(values, memory, sizeof values, cudaMemcpyDeviceToHost) != cudaSuccess)
        return -2;
    cudaFree(memory);
    for (int value : values)
        sum += value;
    return sum;
}

static int openedSum(const char* path, int start) {
    void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        std::printf("%s\n", dlerror());
        return -1;
    }
    const int sum = reinterpret_cast<int (*)(int)>(dlsym(library, "openedSum"))(start);
    dlclose(library);
    return sum;
}

int main(int argc, char** argv) {
    int version = 0;
    cudaRuntimeGetVersion(&version);
    std::printf("runtime %d, devices %d, own %d, %d\n", version / 1000, devices, ownSum(),
                cudaOfTheProgram(35));
    std::printf("linked %d\n", linkedSum(100));
    for (int repeat = 0; repeat < 3; ++repeat)
        for (int i = 1; i < argc; ++i)
            std::printf("opened %d\n", openedSum(argv[i], 1000 * i));
    return 0;
}
