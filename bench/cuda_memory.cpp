// SPDX-License-Identifier: Apache-2.0
// Allocation and free of the CUDA driver API, for three sizes. Run it with two builds of libcuda to
// compare them (LD_LIBRARY_PATH); a round is some milliseconds, and the smallest of all rounds
// counts. Elapsed time for one allocation and its free:
//
//   pair     cuMemAlloc and cuMemFree, again and again
//   many     some hundreds of allocations, then their frees
//   used     as pair; cuMemsetD8 writes all bytes between the two
//   frame    eight allocations, a write of each, a kernel, eight frees
//   stream   cuMemAllocAsync and cuMemFreeAsync; a wait for the stream after some hundreds
#include "cuda_check.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <vector>

namespace {

const char* const kText = R"(.version 7.0
.target sm_60
.address_size 64
.visible .entry nothing() { ret; }
)";

CUfunction kernel = nullptr;
CUstream stream = nullptr;

void pairs(size_t bytes, int count, bool isUsed) {
    for (int i = 0; i < count; ++i) {
        CUdeviceptr memory = 0;
        CHECK(cuMemAlloc(&memory, bytes));
        if (isUsed)
            CHECK(cuMemsetD8(memory, 1, bytes));
        CHECK(cuMemFree(memory));
    }
}

void many(size_t bytes, int count) {
    std::vector<CUdeviceptr> all(size_t(count), 0);
    for (CUdeviceptr& memory : all)
        CHECK(cuMemAlloc(&memory, bytes));
    for (const CUdeviceptr memory : all)
        CHECK(cuMemFree(memory));
}

void frames(size_t bytes, int count) {
    constexpr int kBuffers = 8;
    for (int i = 0; i < count; i += kBuffers) {
        CUdeviceptr buffers[kBuffers];
        for (CUdeviceptr& buffer : buffers) {
            CHECK(cuMemAlloc(&buffer, bytes));
            CHECK(cuMemsetD8(buffer, 1, bytes));
        }
        CHECK(cuLaunchKernel(kernel, 1, 1, 1, 1, 1, 1, 0, stream, nullptr, nullptr));
        for (const CUdeviceptr buffer : buffers)
            CHECK(cuMemFree(buffer));
    }
}

void streamOrdered(size_t bytes, int count) {
    for (int i = 0; i < count; ++i) {
        CUdeviceptr memory = 0;
        CHECK(cuMemAllocAsync(&memory, bytes, stream));
        CHECK(cuMemFreeAsync(memory, stream));
    }
    CHECK(cuStreamSynchronize(stream));
}

// Microseconds for one allocation of a round of `count`.
double best(int rounds, int count, const std::function<void()>& round) {
    using Clock = std::chrono::steady_clock;
    double least = 1e30;
    for (int i = 0; i < rounds; ++i) {
        const Clock::time_point start = Clock::now();
        round();
        const std::chrono::duration<double, std::micro> spent = Clock::now() - start;
        least = std::min(least, spent.count() / count);
    }
    return least;
}

} // namespace

int main(int argc, char** argv) {
    const bool quick = argc == 2 && std::strcmp(argv[1], "--quick") == 0;
    if (argc > 1 && !quick) {
        std::printf("usage: bench_cuda_memory [--quick]\n");
        return std::strcmp(argv[1], "--help") == 0 ? 0 : 2;
    }
    CUcontext context = nullptr;
    CUmodule module = nullptr;
    CHECK(cuInit(0));
    CHECK(cuDevicePrimaryCtxRetain(&context, 0));
    CHECK(cuCtxSetCurrent(context));
    CHECK(cuModuleLoadData(&module, kText));
    CHECK(cuModuleGetFunction(&kernel, module, "nothing"));
    CHECK(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
    struct {
        const char* name;
        size_t bytes;
        int count, used;
    } const sizes[] = {{"256 B", 256, 800, 800},
                       {"64 KiB", 64 << 10, 800, 400},
                       {"1 MiB", 1 << 20, 400, 80},
                       {"64 MiB", 64 << 20, 40, 8}};
    const int rounds = quick ? 5 : 40;
    std::printf("microseconds    pair     many     used    frame   stream\n");
    for (const auto& [name, bytes, count, used] : sizes) {
        std::printf("%-10s", name);
        std::printf("%9.2f",
                    best(rounds, count, [&, b = bytes, n = count] { pairs(b, n, false); }));
        std::printf("%9.2f", best(rounds, count, [&, b = bytes, n = count] { many(b, n); }));
        std::printf("%9.2f", best(rounds, used, [&, b = bytes, n = used] { pairs(b, n, true); }));
        std::printf("%9.2f", best(rounds, used, [&, b = bytes, n = used] { frames(b, n); }));
        std::printf("%9.2f\n",
                    best(rounds, count, [&, b = bytes, n = count] { streamOrdered(b, n); }));
        std::fflush(stdout);
    }
    return 0;
}
