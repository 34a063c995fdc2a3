// SPDX-License-Identifier: Apache-2.0
// A risk engine: closed formulas for half of the options and Monte Carlo with antithetic paths for
// the other, on streams with events between them, pinned buffers and results summed by block;
// checked against the closed formula on the host.
#include "device.h"

#include <cmath>

struct Option {
    float spot, strike, years, rate, volatility;
};
constexpr int kOptions = 24, kPaths = 8192, kThreads = 128;

__host__ __device__ inline float normalCdf(float x) {
    return 0.5f * erfcf(-x * 0.70710678f);
}
__host__ __device__ inline float blackScholes(const Option& o) {
    const float root = o.volatility * sqrtf(o.years);
    const float d1 =
        (logf(o.spot / o.strike) + (o.rate + 0.5f * o.volatility * o.volatility) * o.years) / root;
    return o.spot * normalCdf(d1) - o.strike * expf(-o.rate * o.years) * normalCdf(d1 - root);
}

__global__ void closedForm(const Option* options, float* prices, int count) {
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < count; i += blockDim.x * gridDim.x)
        prices[i] = blackScholes(options[i]);
}

struct Random {
    unsigned x, y, z, w;
    __device__ explicit Random(unsigned seed)
        : x(seed * 747796405u + 1), y(362436069u), z(521288629u), w(88675123u) {
        for (int i = 0; i < 8; ++i)
            next();
    }
    __device__ unsigned next() {
        const unsigned t = x ^ (x << 11);
        x = y, y = z, z = w;
        return w = w ^ (w >> 19) ^ t ^ (t >> 8);
    }
    __device__ float2 normals() {
        const float u = (next() >> 8) * (1.0f / 16777216.0f) + 1e-9f,
                    v = (next() >> 8) * (1.0f / 16777216.0f);
        float s, c;
        sincospif(2.0f * v, &s, &c);
        const float r = sqrtf(-2.0f * __logf(u));
        return make_float2(r * c, r * s);
    }
};

__global__ void simulate(const Option* options, double* sums) {
    __shared__ double partial[kThreads];
    const Option o = options[blockIdx.y];
    const float drift = (o.rate - 0.5f * o.volatility * o.volatility) * o.years;
    const float spread = o.volatility * sqrtf(o.years);
    Random random(blockIdx.y * 65536u + blockIdx.x * blockDim.x + threadIdx.x);
    double sum = 0;
    for (int i = 0; i < kPaths / int(gridDim.x * blockDim.x); ++i) {
        const float2 n = random.normals();
        const float values[4] = {n.x, -n.x, n.y, -n.y};
        for (float value : values)
            sum += fmaxf(o.spot * __expf(drift + spread * value) - o.strike, 0.0f);
    }
    partial[threadIdx.x] = sum;
    for (unsigned half = kThreads / 2; half > 0; half >>= 1) {
        __syncthreads();
        if (threadIdx.x < half)
            partial[threadIdx.x] += partial[threadIdx.x + half];
    }
    if (threadIdx.x == 0)
        atomicAdd(&sums[blockIdx.y], partial[0]);
}

int main() {
    Option *options, *deviceOptions;
    float* prices;
    double *sums, *deviceSums;
    float* devicePrices;
    CUDA(cudaMallocHost((void**)&options, kOptions * sizeof(Option)));
    CUDA(cudaHostAlloc((void**)&prices, kOptions * sizeof(float), cudaHostAllocDefault));
    CUDA(cudaMallocHost((void**)&sums, kOptions * sizeof(double)));
    CUDA(cudaMalloc((void**)&deviceOptions, kOptions * sizeof(Option)));
    CUDA(cudaMalloc((void**)&devicePrices, kOptions * sizeof(float)));
    CUDA(cudaMalloc((void**)&deviceSums, kOptions * sizeof(double)));
    for (int i = 0; i < kOptions; ++i)
        options[i] = {100.0f, 70.0f + 3.0f * float(i), 0.25f + 0.1f * float(i % 7), 0.02f,
                      0.15f + 0.01f * float(i % 11)};
    cudaStream_t one, two;
    cudaEvent_t uploaded, begin, end;
    CUDA(cudaStreamCreate(&one));
    CUDA(cudaStreamCreateWithFlags(&two, cudaStreamNonBlocking));
    CUDA(cudaEventCreateWithFlags(&uploaded, cudaEventDisableTiming));
    CUDA(cudaEventCreate(&begin));
    CUDA(cudaEventCreate(&end));
    CUDA(cudaMemcpyAsync(deviceOptions, options, kOptions * sizeof(Option), cudaMemcpyHostToDevice,
                         one));
    CUDA(cudaEventRecord(uploaded, one));
    CUDA(cudaStreamWaitEvent(two, uploaded, 0));
    closedForm<<<1, 32, 0, one>>>(deviceOptions, devicePrices, kOptions);
    CUDA(cudaEventRecord(begin, two));
    CUDA(cudaMemsetAsync(deviceSums, 0, kOptions * sizeof(double), two));
    simulate<<<dim3(2, kOptions), kThreads, 0, two>>>(deviceOptions, deviceSums);
    CUDA(cudaEventRecord(end, two));
    CUDA(cudaMemcpyAsync(prices, devicePrices, kOptions * sizeof(float), cudaMemcpyDeviceToHost,
                         one));
    CUDA(cudaMemcpyAsync(sums, deviceSums, kOptions * sizeof(double), cudaMemcpyDeviceToHost, two));
    CUDA(cudaStreamSynchronize(one));
    CUDA(cudaStreamSynchronize(two));
    float milliseconds = -1;
    CUDA(cudaEventElapsedTime(&milliseconds, begin, end));
    int wrong = milliseconds < 0;
    for (int i = 0; i < kOptions; ++i) {
        const float expected = blackScholes(options[i]);
        const double simulated =
            sums[i] / (4.0 * kPaths) * std::exp(-options[i].rate * options[i].years);
        wrong += std::fabs(prices[i] - expected) > 1e-4f * (1 + expected);
        wrong += std::fabs(simulated - expected) > 0.25 + 0.02 * expected;
    }
    std::printf("%d wrong\n", wrong);
    CUDA(cudaFreeHost(options));
    CUDA(cudaFreeHost(prices));
    CUDA(cudaFreeHost(sums));
    CUDA(cudaStreamDestroy(one));
    CUDA(cudaStreamDestroy(two));
    return finish(wrong == 0);
}
