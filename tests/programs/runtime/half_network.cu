// SPDX-License-Identifier: Apache-2.0
// A small neural network in half precision and in bfloat16: pairs of values, fused multiply-adds,
// conversions with rounding modes, comparisons and atomic additions, against the host in float with
// the rounding of each format.
#include "device.h"

#include <cuda_bf16.h>
#include <cuda_fp16.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

constexpr int kInputs = 64, kHidden = 32, kOutputs = 8, kBatch = 48;

// What the templates need to know of a format.
template <class T>
struct Format;
template <>
struct Format<__half> {
    using Pair = __half2;
    static __device__ Pair pair(float a, float b) { return __floats2half2_rn(a, b); }
    static __device__ __half from(float x) { return __float2half_rn(x); }
    static __device__ float to(__half x) { return __half2float(x); }
    static __device__ float low(Pair p) { return __low2float(p); }
    static __device__ float high(Pair p) { return __high2float(p); }
};
template <>
struct Format<__nv_bfloat16> {
    using Pair = __nv_bfloat162;
    static __device__ Pair pair(float a, float b) { return __floats2bfloat162_rn(a, b); }
    static __device__ __nv_bfloat16 from(float x) { return __float2bfloat16_rn(x); }
    static __device__ float to(__nv_bfloat16 x) { return __bfloat162float(x); }
    static __device__ float low(Pair p) { return __low2float(p); }
    static __device__ float high(Pair p) { return __high2float(p); }
};

template <class T>
__global__ void convert(const float* from, T* to, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        to[i] = Format<T>::from(from[i]);
}

// One block for each row of the batch, one thread for each neuron; pairs of inputs, sums in pairs.
template <class T, int kIn, int kOut, bool kRelu>
__global__ void layer(const T* __restrict__ in, const T* __restrict__ weights,
                      T* __restrict__ out) {
    using Pair = typename Format<T>::Pair;
    __shared__ __align__(8) T row[kIn];
    for (int i = threadIdx.x; i < kIn; i += blockDim.x)
        row[i] = in[blockIdx.x * kIn + i];
    __syncthreads();
    if (threadIdx.x >= kOut)
        return;
    const Pair* a = reinterpret_cast<const Pair*>(row);
    const Pair* w = reinterpret_cast<const Pair*>(weights + threadIdx.x * kIn);
    Pair sum = Format<T>::pair(0, 0);
    for (int i = 0; i < kIn / 2; ++i)
        sum = __hfma2(a[i], w[i], sum);
    T value = __hadd(sum.x, sum.y);
    if (kRelu && __hlt(value, Format<T>::from(0)))
        value = Format<T>::from(0);
    out[blockIdx.x * kOut + threadIdx.x] = value;
}

template <class T>
__global__ void extremes(const T* values, int n, float* out) {
    float low = 1e30f, high = -1e30f;
    int nans = 0;
    for (int i = threadIdx.x; i < n; i += 32) {
        low = fminf(low, Format<T>::to(values[i]));
        high = fmaxf(high, Format<T>::to(values[i]));
        nans += __hisnan(values[i]);
    }
    for (int step = 16; step; step >>= 1) {
        low = fminf(low, __shfl_xor_sync(~0u, low, step));
        high = fmaxf(high, __shfl_xor_sync(~0u, high, step));
        nans += __shfl_xor_sync(~0u, nans, step);
    }
    if (threadIdx.x == 0) {
        out[0] = low;
        out[1] = high;
        out[2] = float(nans);
    }
}

// Rounds to a number of bits after the first, in the range of normal numbers.
static float rounded(float x, int bits) {
    if (x == 0)
        return 0;
    int exponent;
    std::frexp(x, &exponent);
    const double unit = std::ldexp(1.0, exponent - 1 - bits);
    return float(std::nearbyint(double(x) / unit) * unit);
}

struct Host {
    int bits;
    // The order of the device: even and odd inputs apart, one rounding for each step.
    std::vector<float> layer(const std::vector<float>& in, const std::vector<float>& w, int kIn,
                             int kOut, bool relu) const {
        std::vector<float> out;
        for (int b = 0; b < kBatch; ++b)
            for (int o = 0; o < kOut; ++o) {
                float sum[2] = {0, 0};
                for (int i = 0; i < kIn; ++i)
                    sum[i % 2] =
                        rounded(float(double(in[b * kIn + i]) * w[o * kIn + i] + sum[i % 2]), bits);
                const float value = rounded(sum[0] + sum[1], bits);
                out.push_back(relu && value < 0 ? 0 : value);
            }
        return out;
    }
};

template <class T>
T* allocate(int n) {
    T* memory;
    CUDA(cudaMalloc(&memory, n * sizeof(T)));
    return memory;
}

template <class T>
static int run(int bits, const char* name) {
    std::vector<float> in(kBatch * kInputs), first(kHidden * kInputs), second(kOutputs * kHidden);
    unsigned state = 1;
    for (auto* list : {&in, &first, &second})
        for (float& x : *list) {
            state = state * 1103515245u + 12345u;
            x = rounded((int(state >> 16) % 2001 - 1000) * 1e-3f, bits);
        }
    float* staging = allocate<float>(kBatch * kInputs);
    const auto upload = [&](const std::vector<float>& list) {
        T* to = allocate<T>(int(list.size()));
        CUDA(cudaMemcpy(staging, list.data(), list.size() * 4, cudaMemcpyHostToDevice));
        convert<T><<<(int(list.size()) + 127) / 128, 128>>>(staging, to, int(list.size()));
        return to;
    };
    const T *a = upload(in), *w1 = upload(first), *w2 = upload(second);
    T *hidden = allocate<T>(kBatch * kHidden), *out = allocate<T>(kBatch * kOutputs);
    layer<T, kInputs, kHidden, true><<<kBatch, 64>>>(a, w1, hidden);
    layer<T, kHidden, kOutputs, false><<<kBatch, 32>>>(hidden, w2, out);
    float* bounds = allocate<float>(3);
    extremes<T><<<1, 32>>>(out, kBatch * kOutputs, bounds);

    const Host host = {bits};
    const auto right =
        host.layer(host.layer(in, first, kInputs, kHidden, true), second, kHidden, kOutputs, false);
    std::vector<uint16_t> seen(kBatch * kOutputs);
    CUDA(cudaMemcpy(seen.data(), out, seen.size() * 2, cudaMemcpyDeviceToHost));
    int wrong = 0;
    float low = 1e30f, high = -1e30f;
    for (size_t i = 0; i < seen.size(); ++i) {
        float value;
        if (bits == 7) {
            const uint32_t wide = uint32_t(seen[i]) << 16;
            std::memcpy(&value, &wide, 4);
        } else {
            const int exponent = seen[i] >> 10 & 31, mantissa = seen[i] & 1023;
            value = float(exponent ? std::ldexp(1024 + mantissa, exponent - 25)
                                   : std::ldexp(mantissa, -24));
            value = seen[i] & 0x8000 ? -value : value;
        }
        // Subnormal steps of half precision round elsewhere than `rounded` does.
        wrong +=
            std::fabs(value - right[i]) > 2e-3f * std::fabs(right[i]) + (bits == 7 ? 2e-2f : 2e-3f);
        low = std::fmin(low, value);
        high = std::fmax(high, value);
    }
    float limits[3];
    CUDA(cudaMemcpy(limits, bounds, sizeof limits, cudaMemcpyDeviceToHost));
    wrong += limits[0] != low || limits[1] != high || limits[2] != 0;
    std::printf("%s: %d wrong\n", name, wrong);
    return wrong;
}

int main() {
    const int wrong = run<__half>(10, "half") + run<__nv_bfloat16>(7, "bfloat16");
    return finish(wrong == 0);
}
