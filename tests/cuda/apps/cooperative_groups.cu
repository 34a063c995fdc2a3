// SPDX-License-Identifier: Apache-2.0
// The toolkit's cooperative groups: blocks, tiles, coalesced threads, labelled groups, the grid.
#include <cooperative_groups.h>
#include <cooperative_groups/memcpy_async.h>
#include <cooperative_groups/reduce.h>
#include <cooperative_groups/scan.h>
#include <cuda_runtime.h>

#include <utility>

#include "check.h"

namespace cg = cooperative_groups;

template <int kSize>
__global__ void tiles(int* out) {
    const cg::thread_block block = cg::this_thread_block();
    const auto tile = cg::tiled_partition<kSize>(block);
    const int value = int(block.thread_rank()) * 3 + 1;
    const int sum = cg::reduce(tile, value, cg::plus<int>());
    const int largest = cg::reduce(tile, value, cg::greater<int>());
    const int before = cg::exclusive_scan(tile, value);
    const int next = tile.shfl_down(value, 1);
    const unsigned votes = tile.ballot(value % 2);
    block.sync();
    out[block.thread_rank()] = sum * 31 + largest * 17 + before * 5 + next + int(votes) +
                               int(tile.meta_group_rank()) * 1000 + tile.all(value > 0);
}

// Threads that took the same branch, adding with one atomic for all.
__global__ void coalesced(int* counters, int* ranks) {
    const int t = threadIdx.x;
    if (t % 3 == 0) {
        const cg::coalesced_group group = cg::coalesced_threads();
        int first, again; // set by one thread, which the others read
        if (group.thread_rank() == 0) {
            first = atomicAdd(&counters[0], int(group.size()));
            again = atomicAdd(&counters[3], 1);
        }
        first = group.shfl(first, 0);
        again = __shfl_sync(__activemask(), again, 0);
        ranks[t] = int(group.thread_rank()) + (first + again) * 0;
    } else {
        ranks[t] = -1;
    }
    const cg::thread_block_tile<32> warp = cg::tiled_partition<32>(cg::this_thread_block());
    const auto same = cg::labeled_partition(warp, t % 5);
    atomicMax(&counters[1], int(same.size()));
    atomicAdd(&counters[2], cg::reduce(same, 1, cg::plus<int>()));
}

// A function for groups of any kind.
__device__ int sumOf(const cg::thread_group& group, int* scratch, int value) {
    for (int step = int(group.size()) / 2; step > 0; step /= 2) {
        scratch[group.thread_rank()] = value;
        group.sync();
        if (int(group.thread_rank()) < step)
            value += scratch[int(group.thread_rank()) + step];
        group.sync();
    }
    return value;
}

__global__ void anyGroup(const int* in, int* out, int* counter) {
    __shared__ int scratch[128], copied[128];
    const cg::thread_block block = cg::this_thread_block();
    cg::memcpy_async(block, copied, 128, in, 64);
    cg::wait(block);
    const int t = int(block.thread_rank()), value = copied[t % 64];
    const int ofBlock = sumOf(block, scratch, value);
    const cg::thread_group warp = cg::tiled_partition(block, 32);
    const cg::thread_group few = cg::tiled_partition(warp, 8);
    const int ofWarp = sumOf(warp, scratch + t / 32 * 32, value);
    const int ofFew = sumOf(few, scratch + t / 8 * 8, value);
    auto token = block.barrier_arrive();
    block.barrier_wait(std::move(token));
    if (t == 0)
        out[0] = ofBlock;
    if (t % 32 == 0)
        out[1 + t / 32] = ofWarp;
    if (t % 8 == 0)
        out[5 + t / 8] = ofFew;
    const cg::coalesced_group all = cg::coalesced_threads();
    out[32 + t] = cg::invoke_one_broadcast(all, [&] { return atomicAdd(counter, 1); }) * 0 +
                  int(all.size());
}

__global__ void wholeGrid(int* a, int* b, int n) {
    const cg::grid_group grid = cg::this_grid();
    const int i = int(grid.thread_rank());
    a[i] = i;
    for (int round = 0; round < 20; ++round) {
        grid.sync();
        const int value = (round % 2 ? b : a)[(i + 41) % n];
        (round % 2 ? a : b)[i] = value + 1;
    }
    grid.sync();
    if (i == n - 1)
        b[0] = grid.is_valid() ? int(grid.num_blocks() * 100 + grid.block_rank()) : -1;
}

static unsigned digest(const int* values, int n) {
    unsigned result = 2166136261u;
    for (int i = 0; i < n; ++i)
        result = (result ^ unsigned(values[i])) * 16777619u;
    return result;
}

int main() {
    int *a, *b;
    CHECK(cudaMallocManaged(&a, 4096 * sizeof(int)));
    CHECK(cudaMallocManaged(&b, 4096 * sizeof(int)));
    tiles<4><<<1, 96>>>(a);
    CHECK(cudaDeviceSynchronize());
    std::printf("tiles of 4: %08x\n", digest(a, 96));
    tiles<16><<<1, 96>>>(a);
    CHECK(cudaDeviceSynchronize());
    std::printf("tiles of 16: %08x\n", digest(a, 96));
    tiles<32><<<1, 96>>>(a);
    CHECK(cudaDeviceSynchronize());
    std::printf("tiles of 32: %08x\n", digest(a, 96));

    CHECK(cudaMemset(b, 0, 64));
    coalesced<<<1, 64>>>(b, a);
    CHECK(cudaDeviceSynchronize());
    std::printf("coalesced: %d threads, ranks", b[0]);
    for (int t = 0; t < 64; t += 3)
        std::printf(" %d", a[t]);
    std::printf("; labelled: largest %d, sum %d; adds %d\n", b[1], b[2], b[3]);

    for (int i = 0; i < 64; ++i)
        a[i] = i * i;
    CHECK(cudaMemset(b, 0, 4096 * sizeof(int)));
    anyGroup<<<1, 128>>>(a, b, b + 1000);
    CHECK(cudaDeviceSynchronize());
    std::printf("any group: block %d, warps %d %d, eight threads %d %d; calls %d of %d\n", b[0], b[1],
                b[2], b[5], b[12], b[1000], b[32]);

    const int blocks = 8, threads = 128;
    int n = blocks * threads;
    void* args[] = {&a, &b, &n};
    CHECK(cudaLaunchCooperativeKernel((const void*)wholeGrid, dim3(blocks), dim3(threads), args, 0,
                                      nullptr));
    CHECK(cudaDeviceSynchronize());
    int wrong = 0;
    for (int i = 0; i < n; ++i)
        wrong += a[i] != (i + 20 * 41) % n + 20;
    std::printf("grid: %d of %d wrong, %d\n", wrong, n, b[0]);
    return 0;
}
