// SPDX-License-Identifier: Apache-2.0
// Kernels of lockstep_test.cpp: each is launched a warp at a time and thread by thread, and must
// write the same bytes. `in` has n words, `out` one for each thread.
#include <cuda_runtime.h>

#define KERNEL(name) extern "C" __global__ void name(const unsigned* in, unsigned* out, int n)

__device__ unsigned localIndex() {
    return (threadIdx.z * blockDim.y + threadIdx.y) * blockDim.x + threadIdx.x;
}
__device__ unsigned threads() {
    return blockDim.x * blockDim.y * blockDim.z;
}
__device__ unsigned blockNumber() {
    return (blockIdx.z * gridDim.y + blockIdx.y) * gridDim.x + blockIdx.x;
}
__device__ unsigned globalIndex() {
    return blockNumber() * threads() + localIndex();
}
__device__ unsigned lane() {
    return localIndex() % 32;
}
__device__ unsigned mix(unsigned x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}
constexpr unsigned kAll = 0xffffffffu;

KERNEL(rotateThroughShared) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex();
    box[i] = in[globalIndex() % n];
    __syncthreads();
    out[globalIndex()] = box[(i * 7 + 3) % threads()];
}

KERNEL(treeInShared) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex();
    box[i] = in[globalIndex() % n];
    __syncthreads();
    for (unsigned s = 512; s > 0; s /= 2) {
        if (i < s && i + s < threads())
            box[i] += box[i + s];
        __syncthreads();
    }
    out[globalIndex()] = box[i];
}

KERNEL(endBeforeTheBarrier) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex();
    box[i] = i;
    if (in[globalIndex() % n] % 3 == 0)
        return;
    __syncthreads();
    box[i] += 100;
    __syncthreads();
    out[globalIndex()] = box[i];
}

KERNEL(nestedLoops) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex();
    unsigned sum = 0;
    for (unsigned a = 0; a < 3; ++a) {
        for (unsigned b = 0; b <= a + 1; ++b) {
            box[i] = mix(sum + i + a * 10 + b);
            __syncthreads();
            sum += box[(i + a + b) % threads()];
            __syncthreads();
        }
        sum ^= a;
    }
    out[globalIndex()] = sum;
}

KERNEL(barrierInUniformBranch) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex();
    box[i] = in[globalIndex() % n];
    if (blockNumber() % 2) {
        __syncthreads();
        out[globalIndex()] = box[threads() - 1 - i];
    } else if (in[blockNumber() % n] % 2) {
        __syncthreads();
        out[globalIndex()] = box[(i + 1) % threads()];
    }
}

KERNEL(barriersThatCount) {
    const unsigned value = in[globalIndex() % n];
    unsigned sum = __syncthreads_count(value % 5 == 0);
    sum = sum * 2 + unsigned(__syncthreads_and(value % 64 != 1));
    sum = sum * 2 + unsigned(__syncthreads_or(value % 64 == 1));
    for (unsigned round = 0; __syncthreads_or(mix(value + round) % 8 != 0) && round < 5; ++round)
        sum += round;
    out[globalIndex()] = sum;
}

KERNEL(shuffles) {
    unsigned value = in[globalIndex() % n];
    value += __shfl_down_sync(kAll, value, 3);
    value ^= __shfl_up_sync(kAll, value, 5, 16);
    value += __shfl_xor_sync(kAll, value, 9);
    value ^= __shfl_sync(kAll, value, 7, 8);
    value += __shfl_sync(kAll, value, in[globalIndex() % n] % 32);
    value ^= __shfl_down_sync(kAll, value, in[blockNumber() % n] % 32, 8);
    out[globalIndex()] = value;
}

KERNEL(divergentShuffles) {
    unsigned value = in[globalIndex() % n];
    if (lane() < 16)
        value += __shfl_xor_sync(0xffff, value, 3);
    else
        value ^= __shfl_xor_sync(0xffff0000, value, 5);
    if (lane() % 2 == 0)
        value += __shfl_sync(0x55555555, value, (lane() + 2) % 32);
    out[globalIndex()] = value + __shfl_down_sync(kAll, value, 1);
}

// The same exchange from two places: the lanes wait for each other.
KERNEL(shufflesFromTwoPlaces) {
    unsigned value = in[globalIndex() % n];
    if (value % 2) {
        value += 5;
        value += __shfl_xor_sync(kAll, value, 1);
        value *= 3;
    } else {
        value ^= 9;
        value -= __shfl_xor_sync(kAll, value, 2);
    }
    out[globalIndex()] = value;
}

KERNEL(tiles) {
    unsigned value = in[globalIndex() % n];
    const unsigned mask = 0xffu << lane() / 8 * 8;
    for (unsigned d = 4; d > 0; d /= 2)
        value += __shfl_xor_sync(mask, value, d, 8);
    const unsigned ballot = __ballot_sync(mask, value % 3 == 0);
    out[globalIndex()] = value ^ ballot;
}

KERNEL(votes) {
    const unsigned value = in[globalIndex() % n];
    unsigned result = __ballot_sync(kAll, value % 3 == 0);
    result = mix(result) + unsigned(__all_sync(kAll, value % 97 != 3));
    result = mix(result) + unsigned(__any_sync(kAll, value % 97 == 3));
    if (value % 4 != 0)
        result = mix(result) + __popc(__activemask() & (1u << lane()));
    __syncwarp();
    out[globalIndex()] = result;
}

KERNEL(matches) {
    const unsigned value = in[globalIndex() % n];
    unsigned result = __match_any_sync(kAll, value % 5);
    int all = 0;
    result ^= __match_all_sync(kAll, value % 2, &all);
    out[globalIndex()] = result + unsigned(all);
}

KERNEL(differentRounds) {
    unsigned value = in[globalIndex() % n], rounds = 0;
    while (value != 1 && rounds < 300) {
        value = value % 2 ? value * 3 + 1 : value / 2;
        ++rounds;
    }
    out[globalIndex()] = rounds;
}

// Lanes leave the loop at different times; the remaining ones exchange values in it.
KERNEL(exchangesOfThoseLeft) {
    unsigned value = in[globalIndex() % n] % 20, sum = 0;
    unsigned left = __ballot_sync(kAll, value != 0);
    while (value != 0) {
        sum += __shfl_sync(left, value, __ffs(int(left)) - 1);
        --value;
        left = __ballot_sync(left, value != 0);
    }
    out[globalIndex()] = sum;
}

// Lanes reach one point in different rounds of a loop whose counter all lanes would share.
KERNEL(oneOfTheRounds) {
    const unsigned mine = in[globalIndex() % n] % 4;
    unsigned sum = 0;
    for (unsigned round = 0; round < 4; ++round) {
        if (round == mine)
            sum += __ballot_sync(kAll, round > 1) * (round + 1);
        sum = sum * 3 + round;
    }
    out[globalIndex()] = sum;
}

KERNEL(breaksAndContinues) {
    unsigned sum = 0;
    for (unsigned i = 0; i < 40; ++i) {
        const unsigned value = in[(globalIndex() + i * 13) % n];
        if (value % 7 == 0)
            continue;
        if (value % 31 == 0)
            break;
        for (unsigned k = 0; k < value % 5; ++k) {
            if ((sum ^ k) % 11 == 10)
                return;
            sum += k * value;
        }
        switch (value % 4) {
        case 0:
            sum ^= 3;
            break;
        case 1:
            sum += 77;
        case 2:
            sum *= 5;
            break;
        default:
            sum -= i;
        }
    }
    out[globalIndex()] = sum;
}

KERNEL(localMemory) {
    extern __shared__ unsigned box[];
    unsigned own[16];
    for (unsigned i = 0; i < 16; ++i)
        own[i] = mix(in[globalIndex() % n] + i);
    box[localIndex()] = own[in[globalIndex() % n] % 16];
    __syncthreads();
    unsigned sum = 0;
    for (unsigned i = 0; i < 16; ++i)
        sum = sum * 3 + own[(i * box[(localIndex() + 1) % threads()]) % 16];
    __syncthreads();
    out[globalIndex()] = sum;
}

KERNEL(numbers) {
    const unsigned i = globalIndex();
    const unsigned a = in[i % n], b = in[(i + 1) % n] | 1;
    const float x = __uint_as_float(a & 0xbfffffff), y = float(int(b)) * 1e-5f;
    float real = x * y + sqrtf(fabsf(x)) - x / y + floorf(y) + fminf(x, y);
    const double wide = double(x) * double(y) + double(a) / double(b);
    unsigned sum = a / b + a % b * 3 + unsigned(int(a) / int(b | 2)) + unsigned(int(a) % 17);
    sum += __umulhi(a, b) + __popc(a) + __clz(int(b)) + __brev(a) + unsigned((a * 1ull * b) >> 20);
    sum ^= unsigned(__double_as_longlong(wide) >> 13) ^ unsigned(int(y)) ^ unsigned(rintf(y));
    if (real == real)
        sum += __float_as_uint(real);
    const unsigned char small = (unsigned char)(a >> 3);
    const short half = short(b);
    out[i] = sum + small * unsigned(half) + unsigned(sinf(y) * 1000.0f);
}

KERNEL(bytesAndPairs) {
    const unsigned i = globalIndex();
    const unsigned char* bytes = reinterpret_cast<const unsigned char*>(in);
    const unsigned short* shorts = reinterpret_cast<const unsigned short*>(in);
    const uint2 pair = reinterpret_cast<const uint2*>(in)[i % (n / 2)];
    const unsigned long long wide = reinterpret_cast<const unsigned long long*>(in)[i % (n / 2)];
    out[i] = bytes[i % n] + shorts[(i + 3) % n] * 3 + pair.x - pair.y + unsigned(wide >> 17) +
             bytes[in[i % n] % (4 * n)];
}

KERNEL(someWrite) {
    const unsigned i = globalIndex();
    if (in[i % n] % 2)
        out[i] = i;
    if (lane() > 3 && lane() < 20)
        reinterpret_cast<unsigned char*>(out)[i * 4 + 1] = (unsigned char)(i);
    if (i % 3 == 0)
        reinterpret_cast<unsigned short*>(out)[i * 2 + 1] = (unsigned short)(in[i % n]);
}

struct Three {
    unsigned a, b, c;
};

// Indices on both sides of an address, without a sign, of elements of several sizes.
KERNEL(indirections) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex(), seed = in[globalIndex() % n];
    box[i] = 0;
    __syncthreads();
    const unsigned* middle = in + n / 2;
    const int left = -int(seed % unsigned(n / 2));
    unsigned sum = middle[left] ^ middle[int(seed >> 7) % (n / 2)];
    sum += unsigned(reinterpret_cast<const unsigned long long*>(in)[n / 4 + left / 2] >> 13);
    sum += reinterpret_cast<const unsigned char*>(middle)[left * 4 + 1];
    sum += reinterpret_cast<const Three*>(in)[seed % unsigned(n / 3)].b;
    sum += in[seed * 2654435761u % unsigned(n)];
    box[threads() - 1 - i] = sum;
    __syncthreads();
    out[globalIndex()] = box[i] + box[seed % threads()];
}

KERNEL(atomics) {
    __shared__ unsigned bins[16];
    __shared__ unsigned most;
    const unsigned i = localIndex();
    if (i < 16)
        bins[i] = 0;
    if (i == 0)
        most = 0;
    __syncthreads();
    const unsigned value = in[globalIndex() % n];
    atomicAdd(&bins[value % 16], value % 3);
    atomicMax(&most, value);
    atomicCAS(&bins[(value >> 8) % 16], 1u << 30, 5u);
    __syncthreads();
    out[globalIndex()] = bins[i % 16] + most;
}

// A lock that lanes of one warp take in turn.
KERNEL(locks) {
    __shared__ unsigned lock, count;
    if (localIndex() == 0)
        lock = count = 0;
    __syncthreads();
    bool done = in[globalIndex() % n] % 8 != 0;
    while (!done) {
        if (atomicCAS(&lock, 0u, 1u) == 0) {
            volatile unsigned* shared = &count;
            *shared = *shared + in[globalIndex() % n] % 9;
            __threadfence_block();
            atomicExch(&lock, 0u);
            done = true;
        }
    }
    __syncthreads();
    out[globalIndex()] = count;
}

// The same again and again, with all of them together in between.
KERNEL(waitsInRounds) {
    __shared__ volatile unsigned flag;
    if (localIndex() == 0)
        flag = 0;
    __syncthreads();
    unsigned sum = in[globalIndex() % n];
    for (unsigned round = 1; round <= 5; ++round) {
        if (localIndex() == 0) {
            while (flag != round) {
            }
        } else if (localIndex() == threads() - 1) {
            flag = round;
        }
        __syncthreads();
        sum = mix(sum + flag * lane());
        __syncthreads();
    }
    out[globalIndex()] = sum;
}

// The first thread of the block waits for the last one.
KERNEL(waitsForTheLast) {
    __shared__ volatile unsigned flag;
    if (localIndex() == 0)
        flag = 0;
    __syncthreads();
    if (localIndex() == threads() - 1) {
        flag = 7;
        __threadfence_block();
    }
    while (localIndex() == 0 && flag == 0) {
    }
    out[globalIndex()] = localIndex() == 0 ? flag : 1;
}

// Part of a block meets at a separate barrier.
KERNEL(namedBarriers) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex(), half = threads() / 64 * 32;
    box[i] = in[globalIndex() % n];
    if (half != 0 && i < half) {
        asm volatile("bar.sync 1, %0;" ::"r"(half) : "memory");
        const unsigned next = box[(i + 1) % half] % 2;
        asm volatile("bar.sync 1, %0;" ::"r"(half) : "memory");
        box[i] += next;
    }
    __syncthreads();
    out[globalIndex()] = box[(i + 1) % threads()] % 2;
}

// Producers arrive, consumers wait.
KERNEL(arrivals) {
    extern __shared__ unsigned box[];
    const unsigned i = localIndex(), all = threads() / 32 * 32;
    box[i] = 0;
    __syncthreads();
    if (all >= 64 && i < all) {
        if (i < 32) {
            asm volatile("bar.sync 2, %0;" ::"r"(all) : "memory");
            out[globalIndex()] = box[i + 32];
        } else {
            box[i] = in[globalIndex() % n];
            asm volatile("bar.arrive 2, %0;" ::"r"(all) : "memory");
            out[globalIndex()] = i;
        }
    }
}

__device__ __noinline__ unsigned sumOfWarp(unsigned value) {
    for (unsigned d = 16; d > 0; d /= 2)
        value += __shfl_xor_sync(kAll, value, d);
    return value;
}

KERNEL(sumsInFunctions) {
    __shared__ unsigned sums[32];
    const unsigned i = localIndex();
    const unsigned warps = (threads() + 31) / 32;
    const unsigned sum = sumOfWarp(in[globalIndex() % n]);
    if (lane() == 0)
        sums[i / 32] = sum;
    __syncthreads();
    if (i < 32) {
        const unsigned all = sumOfWarp(i < warps ? sums[i] : 0);
        if (i == 0)
            sums[0] = all;
    }
    __syncthreads();
    out[globalIndex()] = sums[0];
}

KERNEL(matrix) {
    __shared__ float a[16][17], b[16][17];
    const unsigned x = localIndex() % 16, y = localIndex() / 16 % 16;
    float sum = 0;
    for (unsigned i = localIndex(); i < 256; i += blockDim.x * blockDim.y * blockDim.z)
        a[i / 16][i % 16] = b[i / 16][i % 16] = 0; // small blocks do not fill them below
    for (unsigned tile = 0; tile < 3; ++tile) {
        __syncthreads();
        if (localIndex() < 256) {
            a[y][x] = float(in[(globalIndex() + tile * 7) % n] % 100);
            b[y][x] = float(in[(globalIndex() * 3 + tile) % n] % 100);
        }
        __syncthreads();
        for (unsigned k = 0; k < 16; ++k)
            sum += a[y][k] * b[k][x];
    }
    out[globalIndex()] = __float_as_uint(sum);
}

// Steps as wide as the grid, each on another page: warps take turns.
KERNEL(wideSteps) {
    extern __shared__ unsigned box[];
    unsigned sum = 0;
    for (unsigned i = globalIndex(); i < unsigned(n); i += 2048 + in[0] % 2)
        sum += in[i] * 3;
    box[localIndex()] = sum;
    __syncthreads();
    out[globalIndex()] = box[localIndex()] ^ box[0];
}

// Warps that jump from page to page let one another catch up; in the last steps only some lanes
// continue.
KERNEL(farSteps) {
    extern __shared__ unsigned box[];
    const unsigned own = localIndex() % 1100;
    unsigned sum = own;
    for (unsigned k = 0; k < 9; ++k) {
        unsigned i = own + k;
        for (; i < unsigned(n); i += 1100)
            sum = sum * 31 + in[i];
        sum += i;
        if (k % 4 == 3) {
            box[localIndex()] = sum;
            __syncthreads();
            sum += box[(localIndex() + 40) % threads()];
            __syncthreads();
        }
    }
    out[globalIndex()] = sum;
}

// The same with a different step for each lane, and ends that lanes reach at different times.
KERNEL(unevenSteps) {
    unsigned sum = 0;
    for (unsigned k = 0; k < 9; ++k)
        for (unsigned i = localIndex() + k; i < unsigned(n) - (in[k] & 63) * lane();
             i += 1040 + (k & 1 ? lane() / 16 * 64 : 0))
            sum = sum * 31 + in[i] + k;
    out[globalIndex()] = sum;
}

// The number of the element goes from the largest to 0 between two lanes.
extern "C" __global__ void wrappedIndices(const unsigned char* in, unsigned char* out,
                                          unsigned start) {
    const unsigned i = start + threadIdx.x;
    out[i] = (unsigned char)(in[i] + 1);
}
// From the largest to the smallest.
extern "C" __global__ void wrappedSignedIndices(const unsigned char* in, unsigned char* out,
                                                unsigned start) {
    const int i = int(start + threadIdx.x);
    out[i] = (unsigned char)(in[i] + 1);
}

// Enough products that a kernel compiled to flush subnormals runs in that mode of the processor.
KERNEL(products) {
    __shared__ unsigned total;
    const float x = __uint_as_float(in[globalIndex() % n] & 0x3fffffff), y = x * 1e-30f;
    if (localIndex() == 0)
        total = 0;
    __syncthreads();
    float a = y, b = x;
    for (int i = 0; i < 40; ++i) {
        a = a * x + y * 0.5f;
        b = b * y + a * 0.25f + x * 1e-20f;
        a = a * b - x * y + 1e-38f * x;
    }
    if (lane() < 9)
        a += __shfl_xor_sync(0x1ff, a, lane() < 8);
    atomicAdd(&total, __float_as_uint(a) + in[0] + unsigned(sinf(x)));
    __syncthreads();
    out[globalIndex()] = __float_as_uint(a * y) + __float_as_uint(b) * 3 + total;
}

// A barrier object, which counts all threads of the block; each waits for its phases.
KERNEL(barrierObjects) {
    extern __shared__ unsigned box[];
    __shared__ unsigned long long object;
    const unsigned i = localIndex(), at = unsigned(__cvta_generic_to_shared(&object));
    if (i == 0)
        asm volatile("mbarrier.init.shared.b64 [%0], %1;" ::"r"(at), "r"(threads()) : "memory");
    __syncthreads();
    unsigned sum = 0;
    for (unsigned phase = 0; phase < 3; ++phase) {
        box[i] = in[(globalIndex() + phase) % n] + sum;
        for (unsigned step = 0; step < 2; ++step) {
            unsigned long long token;
            unsigned done = 0;
            asm volatile("mbarrier.arrive.shared.b64 %0, [%1];" : "=l"(token) : "r"(at) : "memory");
            while (!done)
                asm volatile("{ .reg .pred p; mbarrier.test_wait.shared.b64 p, [%1], %2;"
                             " selp.u32 %0, 1, 0, p; }"
                             : "=r"(done)
                             : "r"(at), "l"(token)
                             : "memory");
            if (step == 0)
                sum += box[(i + 5) % threads()];
        }
    }
    out[globalIndex()] = sum;
}
