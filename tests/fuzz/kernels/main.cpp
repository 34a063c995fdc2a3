// SPDX-License-Identifier: Apache-2.0
// Runs random kernels a warp at a time and thread by thread, with equal results. A kernel is
// determined by its number: `fuzz_kernels --input NUMBER` repeats one, --print prints it.
//   fuzz_kernels [--seconds N] [--start N] [--input N] [--print]
#include "../last_words.h"
#include "../options.h"
#include "random_kernel.h"

#include <cuda.h>

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using Words = std::vector<uint32_t>;

std::atomic<unsigned long> gInput{0};

void tellWhere() {
    char text[100];
    const int size = std::snprintf(text, sizeof text, "\nfuzz_kernels: repeat with --input %lu\n",
                                   gInput.load());
    if (write(STDERR_FILENO, text, size_t(size)) < 0)
        _exit(3);
}

void require(CUresult result, const char* what) {
    if (result == CUDA_SUCCESS)
        return;
    std::fprintf(stderr, "%s: error %d\n", what, int(result));
    std::abort();
}

// Runs the kernel and returns all memory that it can write.
Words run(CUfunction kernel, unsigned blocks, unsigned threads, const char* way) {
    setenv("SUNSTONE_KERNELS", way, 1); // read at the first launch, which compiles, and at each one
    uint32_t n = blocks * threads;
    Words in(fuzz::kInputWords + 4), made(n * (1 + fuzz::kPlanes) + fuzz::kSums);
    uint32_t state = 2463534242u;
    for (uint32_t& word : in) {
        state = state * 1664525 + 1013904223;
        word = state >> 20;
    }
    const uint32_t* from = in.data();
    uint32_t* out = made.data();
    uint32_t* planes = out + n;
    uint32_t* sums = planes + n * fuzz::kPlanes;
    void* params[] = {&from, &out, &planes, &sums, &n};
    require(cuLaunchKernel(kernel, blocks, 1, 1, threads, 1, 1, 0, nullptr, params, nullptr),
            "launch");
    require(cuCtxSynchronize(), way);
    return made;
}

void compare(const Words& expected, const Words& seen, unsigned threads, const char* way) {
    for (size_t i = 0; i < seen.size(); ++i) {
        if (seen[i] == expected[i])
            continue;
        std::fprintf(stderr, "in blocks of %u threads word %zu is %u (%s), thread by thread %u\n",
                     threads, i, seen[i], way, expected[i]);
        std::abort();
    }
}

void tryKernel(unsigned long number, bool print) {
    gInput = number;
    alarm(120); // no kernel takes that long
    const std::string text = fuzz::RandomKernel(number).write();
    if (print)
        std::fputs(text.c_str(), stdout);
    // A module for each way, because a kernel is compiled only once.
    CUmodule modules[2] = {};
    CUfunction kernels[2] = {};
    for (int i = 0; i < 2; ++i) {
        require(cuModuleLoadData(&modules[i], text.c_str()), "the kernel's text");
        require(cuModuleGetFunction(&kernels[i], modules[i], "kernel"), "the kernel");
    }
    struct Shape {
        unsigned blocks, threads;
    };
    for (const Shape shape : {Shape{2, 96}, Shape{3, 45}, Shape{1, 256}}) {
        const Words expected = run(kernels[0], shape.blocks, shape.threads, "single");
        compare(expected, run(kernels[0], shape.blocks, shape.threads, "lockstep"), shape.threads,
                "lockstep");
        compare(expected, run(kernels[1], shape.blocks, shape.threads, "runs"), shape.threads,
                "runs");
    }
    for (CUmodule module : modules)
        require(cuModuleUnload(module), "unload");
    alarm(0);
}

} // namespace

int main(int argc, char** argv) {
    const char* const usage = "fuzz_kernels [--seconds N] [--start N] [--input N] [--print]";
    uint64_t seconds = 10, start = 1, input = 0;
    std::vector<std::string> rest;
    fuzz::readOptions(argc, argv, usage,
                      {{"--seconds", &seconds}, {"--start", &start}, {"--input", &input}}, &rest);
    const bool print = !rest.empty();
    if (print && rest != std::vector<std::string>{"--print"}) {
        std::fprintf(stderr, "usage: %s\n", usage);
        return 2;
    }
    fuzz::setLastWords(tellWhere, SIGALRM);
    setenv("OPTIX_CACHE_MAXSIZE", "0", 1);
    CUcontext context = nullptr;
    require(cuInit(0), "start");
    require(cuDevicePrimaryCtxRetain(&context, 0), "context");
    require(cuCtxSetCurrent(context), "context");
    unsigned long count = 0;
    if (input) {
        tryKernel(input, print);
        ++count;
    } else {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
        for (; std::chrono::steady_clock::now() < end; ++count)
            tryKernel(start + count, print);
    }
    std::printf("%lu kernels left the same a warp at a time and thread by thread\n", count);
    return 0;
}
