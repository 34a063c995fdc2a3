// SPDX-License-Identifier: Apache-2.0
// Asynchronous copies into shared memory and barrier objects, as the toolkit's headers make them
// for compute capability 8.0 and later.
#include <cooperative_groups.h>
#include <cuda/atomic>
#include <cuda/barrier>
#include <cuda/pipeline>
#include <cuda_pipeline_primitives.h>
#include <cuda_runtime.h>

#include "check.h"

namespace cg = cooperative_groups;

using BlockBarrier = cuda::barrier<cuda::thread_scope_block>;

__global__ void reverse(const int* in, int* out) {
    __shared__ BlockBarrier barrier;
    __shared__ int buffer[256];
    const auto block = cg::this_thread_block();
    if (block.thread_rank() == 0)
        init(&barrier, block.size());
    block.sync();
    cuda::memcpy_async(block, buffer, in, sizeof buffer, barrier);
    barrier.arrive_and_wait();
    out[block.thread_rank()] = buffer[255 - block.thread_rank()];
}

// Half of the threads produce, the other half consume, synchronised by two barriers a buffer.
__global__ void producers(const int* in, int* out, int steps) {
    __shared__ BlockBarrier full[2], empty[2];
    __shared__ int buffer[2][64];
    const auto block = cg::this_thread_block();
    const int half = int(block.size()) / 2, rank = int(block.thread_rank());
    if (rank < 4)
        init(rank < 2 ? &full[rank] : &empty[rank - 2], block.size());
    block.sync();
    if (rank < half) {
        for (int step = 0; step < steps; ++step) {
            empty[step % 2].arrive_and_wait();
            buffer[step % 2][rank] = in[step * half + rank] * 2;
            (void)full[step % 2].arrive();
        }
    } else {
        (void)empty[0].arrive();
        (void)empty[1].arrive();
        int sum = 0;
        for (int step = 0; step < steps; ++step) {
            full[step % 2].arrive_and_wait();
            sum += buffer[step % 2][half - 1 - (rank - half)];
            (void)empty[step % 2].arrive();
        }
        out[rank - half] = sum;
    }
}

__global__ void pipelined(const int* in, int* out) {
    constexpr int kStages = 2, kSteps = 4, kThreads = 128;
    __shared__ int buffer[kStages][kThreads];
    __shared__ cuda::pipeline_shared_state<cuda::thread_scope_block, kStages> state;
    const auto block = cg::this_thread_block();
    auto pipe = cuda::make_pipeline(block, &state);
    int sum = 0;
    for (int step = 0, fetched = 0; step < kSteps; ++step) {
        for (; fetched < kSteps && fetched < step + kStages; ++fetched) {
            pipe.producer_acquire();
            cuda::memcpy_async(block, buffer[fetched % kStages], in + fetched * kThreads,
                               cuda::aligned_size_t<16>(sizeof buffer[0]), pipe);
            pipe.producer_commit();
        }
        pipe.consumer_wait();
        sum += buffer[step % kStages][block.thread_rank()] * (step + 1);
        pipe.consumer_release();
    }
    out[block.thread_rank()] = sum;
}

// The last bytes of a copy may be zeros instead.
__global__ void padded(const char* in, int count, int4* out) {
    __shared__ int4 buffer[32];
    const int begin = int(threadIdx.x) * 16;
    const int there = min(max(count - begin, 0), 16);
    __pipeline_memcpy_async(&buffer[threadIdx.x], in + (there ? begin : 0), 16, 16 - there);
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncthreads();
    out[threadIdx.x] = buffer[31 - threadIdx.x];
}

// Threads that leave are no longer waited for.
__global__ void leaving(int* out) {
    __shared__ BlockBarrier barrier;
    __shared__ int count;
    if (threadIdx.x == 0) {
        init(&barrier, blockDim.x);
        count = 0;
    }
    __syncthreads();
    for (int round = 0; round < 5; ++round) {
        atomicAdd(&count, 1);
        if (int(threadIdx.x) >= 80 - 16 * round) {
            barrier.arrive_and_drop();
            return;
        }
        barrier.arrive_and_wait();
        if (threadIdx.x == 0)
            out[round] = count;
        barrier.arrive_and_wait();
    }
}

__global__ void counted(cuda::atomic<int, cuda::thread_scope_device>* count, int* slots) {
    slots[count->fetch_add(1, cuda::memory_order_relaxed)] = 1;
    cuda::atomic_ref<int, cuda::thread_scope_device>(slots[0]).fetch_max(int(threadIdx.x));
}

static long total(const int* values, int count) {
    long sum = 0;
    for (int i = 0; i < count; ++i)
        sum += long(values[i]) * (i + 1);
    return sum;
}

int main() {
    int *in, *out;
    CHECK(cudaMallocManaged(&in, 4096));
    CHECK(cudaMallocManaged(&out, 4096));
    for (int i = 0; i < 1024; ++i)
        in[i] = i * 7 % 1000;
    const auto finish = [&](const char* what, int count) {
        CHECK(cudaGetLastError());
        CHECK(cudaDeviceSynchronize());
        std::printf("%s: %ld\n", what, total(out, count));
        CHECK(cudaMemset(out, 0, 4096));
    };
    reverse<<<1, 256>>>(in, out);
    finish("reverse", 256);
    producers<<<1, 128>>>(in, out, 16);
    finish("producers", 64);
    pipelined<<<1, 128>>>(in, out);
    finish("pipelined", 128);
    padded<<<1, 32>>>(reinterpret_cast<const char*>(in), 205, reinterpret_cast<int4*>(out));
    finish("padded", 128);
    leaving<<<1, 96>>>(out);
    finish("leaving", 5);
    cuda::atomic<int, cuda::thread_scope_device>* count;
    CHECK(cudaMallocManaged(&count, sizeof *count));
    count->store(0);
    counted<<<2, 256>>>(count, out);
    finish("counted", 512);
    std::printf("count: %d\n", count->load());
    return 0;
}
