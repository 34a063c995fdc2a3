// SPDX-License-Identifier: Apache-2.0
// CUDA kernels on the CPU device against the same work in C++ with oneTBB: n-body, convolution,
// reduction. The C++ is straightforward: one loop per element under parallel_for, compiled -O3 for
// this machine's processor and vectorised as far as clang does by itself, without fast-math; the
// reduction keeps 64 partial sums so that it can be vectorised. Its array is so large that both
// sides read from memory and that thread start-up does not matter. Both sides read the same device
// memory.
//
// Rounds alternate; the smallest of each counts. Times are processor time of all threads, which
// other programs on the machine disturb little; --clock compares wall-clock time.
#include "cuda_kernels.h"

#include "cuda_check.h"
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

namespace {

constexpr int kBodies = 8192, kWidth = 4096, kHeight = 2048, kValues = 1 << 26, kBlocks = 64;
bool byClock = false;

double now() {
    timespec time;
    clock_gettime(byClock ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
}

// ---- the peers --------------------------------------------------------------------------------

void nBody(const Body* bodies, Force* forces, int n) {
    tbb::parallel_for(tbb::blocked_range<int>(0, n, 64), [=](const tbb::blocked_range<int>& range) {
        for (int i = range.begin(); i < range.end(); ++i) {
            const Body own = bodies[i];
            Force force = {0, 0, 0};
            for (int j = 0; j < n; ++j) {
                const Body other = bodies[j];
                const float dx = other.x - own.x, dy = other.y - own.y, dz = other.z - own.z;
                const float square = dx * dx + dy * dy + dz * dz + kSoftening;
                const float scale = other.mass / (square * std::sqrt(square));
                force.x += dx * scale;
                force.y += dy * scale;
                force.z += dz * scale;
            }
            forces[i] = force;
        }
    });
}

void convolve(const float* in, float* out, const float* weights) {
    tbb::parallel_for(tbb::blocked_range<int>(0, kHeight, 8), [=](const auto& range) {
        for (int y = range.begin(); y < range.end(); ++y)
            for (int x = 0; x < kWidth; ++x) {
                float sum = 0;
                for (int i = -kRadius; i <= kRadius; ++i) {
                    const int at = std::clamp(x + i, 0, kWidth - 1);
                    sum += weights[i + kRadius] * in[y * kWidth + at];
                }
                out[y * kWidth + x] = sum;
            }
    });
}

float reduce(const float* in) {
    constexpr int kLanes = 64;
    return tbb::parallel_reduce(
        tbb::blocked_range<int>(0, kValues, 1 << 16), 0.0f,
        [=](const tbb::blocked_range<int>& range, float start) {
            float sums[kLanes] = {};
            int i = range.begin();
            for (; i + kLanes <= range.end(); i += kLanes)
                for (int lane = 0; lane < kLanes; ++lane)
                    sums[lane] += in[i + lane];
            for (; i < range.end(); ++i)
                sums[0] += in[i];
            float sum = start;
            for (float part : sums)
                sum += part;
            return sum;
        },
        std::plus<float>());
}

// ---- measuring --------------------------------------------------------------------------------

struct Times {
    std::vector<double> kernel, peer;
};

void report(const char* name, Times times, double error) {
    std::sort(times.kernel.begin(), times.kernel.end());
    std::sort(times.peer.begin(), times.peer.end());
    const size_t middle = times.kernel.size() / 2;
    std::printf("| %-26s | %8.1f | %8.1f | %5.2f | %4.0f %% | %4.0f %% | %.0e |\n", name,
                times.kernel[0], times.peer[0], times.peer[0] / times.kernel[0],
                (times.kernel[middle] / times.kernel[0] - 1) * 100,
                (times.peer[middle] / times.peer[0] - 1) * 100, error);
}

Times measure(unsigned rounds, const std::function<void()>& kernel,
              const std::function<void()>& peer) {
    Times times;
    for (unsigned round = 0; round <= rounds; ++round) {
        double start = now();
        kernel();
        const double ours = now() - start;
        start = now();
        peer();
        const double theirs = now() - start;
        if (round == 0)
            continue; // caches, threads
        times.kernel.push_back(ours);
        times.peer.push_back(theirs);
    }
    return times;
}

CUfunction kernelOf(CUmodule module, const char* name) {
    CUfunction function = nullptr;
    CHECK(cuModuleGetFunction(&function, module, name));
    return function;
}

void launch(CUfunction function, unsigned gridX, unsigned gridY, unsigned blockX, unsigned blockY,
            void** params) {
    CHECK(
        cuLaunchKernel(function, gridX, gridY, 1, blockX, blockY, 1, 0, nullptr, params, nullptr));
    CHECK(cuCtxSynchronize());
}

template <class T>
CUdeviceptr addressOf(std::vector<T>& values) {
    return reinterpret_cast<CUdeviceptr>(values.data()); // host memory is device memory here
}

void benchBodies(CUmodule module, unsigned rounds) {
    std::vector<Body> bodies(kBodies);
    std::vector<Force> ours(kBodies), theirs(kBodies);
    for (int i = 0; i < kBodies; ++i) {
        const float a = float(i) * 0.01f, r = 1 + float(i % 97) * 0.1f;
        bodies[size_t(i)] = {r * std::cos(a), r * std::sin(a), float(i % 13), 1.0f / kBodies};
    }
    CUdeviceptr in = addressOf(bodies), out = addressOf(ours);
    int n = kBodies;
    void* params[] = {&in, &out, &n};
    for (const char* name : {"nBodyPlain", "nBodyTiled"}) {
        CUfunction function = kernelOf(module, name);
        const Times times = measure(
            rounds, [&] { launch(function, kBodies / kTile, 1, kTile, 1, params); },
            [&] { nBody(bodies.data(), theirs.data(), kBodies); });
        double error = 0;
        for (size_t i = 0; i < ours.size(); ++i)
            error = std::max(error, double(std::fabs(ours[i].x - theirs[i].x)));
        report(name, times, error);
    }
}

void benchConvolution(CUmodule module, unsigned rounds) {
    std::vector<float> in(size_t(kWidth) * kHeight), ours(in.size()), theirs(in.size());
    for (size_t i = 0; i < in.size(); ++i)
        in[i] = float(i * 7919 % 1000) * 0.001f;
    float weights[2 * kRadius + 1];
    for (int i = -kRadius; i <= kRadius; ++i)
        weights[i + kRadius] = std::exp(-float(i * i) / 20) / 8;
    CUdeviceptr symbol = 0;
    CHECK(cuModuleGetGlobal(&symbol, nullptr, module, "weights"));
    CHECK(cuMemcpyHtoD(symbol, weights, sizeof weights));
    CUdeviceptr from = addressOf(in), to = addressOf(ours);
    int width = kWidth, height = kHeight;
    void* params[] = {&from, &to, &width, &height};
    CUfunction function = kernelOf(module, "convolve");
    const Times times = measure(
        rounds, [&] { launch(function, kWidth / 32, kHeight / 8, 32, 8, params); },
        [&] { convolve(in.data(), theirs.data(), weights); });
    double error = 0;
    for (size_t i = 0; i < ours.size(); ++i)
        error = std::max(error, double(std::fabs(ours[i] - theirs[i])));
    report("convolve", times, error);
}

void benchReduction(CUmodule module, unsigned rounds) {
    std::vector<float> partial(kBlocks);
    CUdeviceptr from = 0, to = addressOf(partial);
    CHECK(cuMemAlloc(&from, size_t(kValues) * sizeof(float)));
    auto* in = reinterpret_cast<float*>(from);
    for (size_t i = 0; i < kValues; ++i)
        in[i] = float(i % 1000) * 0.001f;
    int n = kValues;
    void* params[] = {&from, &to, &n};
    float theirs = 0;
    for (const char* name : {"reduceShared", "reduceShuffle"}) {
        CUfunction function = kernelOf(module, name);
        const Times times = measure(
            rounds, [&] { launch(function, kBlocks, 1, kTile, 1, params); },
            [&] { theirs = reduce(in); });
        double sum = 0;
        for (float part : partial)
            sum += part;
        report(name, times, std::fabs(sum - theirs) / sum);
    }
    CHECK(cuMemFree(from));
}

} // namespace

int main(int argc, char** argv) {
    unsigned rounds = 7;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--clock") == 0)
            byClock = true;
        else if (std::strcmp(argv[i], "--quick") == 0)
            rounds = 3;
        else {
            std::fprintf(stderr, "usage: %s [--quick] [--clock]\n", argv[0]);
            return 2;
        }
    }
    std::ifstream file(BENCH_PTX);
    const std::string text((std::istreambuf_iterator<char>(file)),
                           std::istreambuf_iterator<char>());
    CUcontext context = nullptr;
    CUmodule module = nullptr;
    int processors = 0;
    CHECK(cuInit(0));
    CHECK(cuDevicePrimaryCtxRetain(&context, 0));
    CHECK(cuCtxSetCurrent(context));
    CHECK(cuModuleLoadData(&module, text.c_str()));
    CHECK(cuDeviceGetAttribute(&processors, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, 0));
    std::printf(
        "%d threads, %s time in ms, best of %u; the noise is how far the median lies above\n\n",
        processors, byClock ? "clock" : "processor", rounds);
    std::printf(
        "| kernel                     |  kernel  |  C++ TBB | ratio | noise  | noise  | error |\n"
        "|----------------------------|---------:|---------:|------:|-------:|-------:|------:|\n");
    benchBodies(module, rounds);
    benchConvolution(module, rounds);
    benchReduction(module, rounds);
    return 0;
}
