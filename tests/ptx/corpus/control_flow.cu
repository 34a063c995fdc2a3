// SPDX-License-Identifier: Apache-2.0
// Switches, loops, early returns, recursion, calls through pointers, local arrays.
typedef int (*Operation)(int, int);

__device__ __noinline__ int addBoth(int a, int b) { return a + b; }
__device__ __noinline__ int mulBoth(int a, int b) { return a * b; }
__device__ Operation operations[2] = {addBoth, mulBoth};

struct Pair {
    double first;
    int second[3];
};

__device__ __noinline__ Pair makePair(int n) {
    Pair pair;
    pair.first = n * 0.5;
    for (int i = 0; i < 3; ++i)
        pair.second[i] = n + i;
    return pair;
}

__device__ int fibonacci(int n) { return n < 2 ? n : fibonacci(n - 1) + fibonacci(n - 2); }

extern "C" __global__ void __launch_bounds__(128, 4) branches(int* out, int selector, int count) {
    int table[16];
    for (int i = 0; i < 16; ++i)
        table[i] = i * selector;
    int result = 0;
    switch (selector) {
    case 0: result = table[count & 15]; break;
    case 1: result = fibonacci(count); break;
    case 2: result = makePair(count).second[count % 3]; break;
    case 3: result = operations[count & 1](selector, count); break;
    case 4: result = 17; break;
    case 5: result = count << 3; break;
    case 6: result = count >> 3; break;
    case 7: return;
    default: result = -1;
    }
    for (int i = 0; i < count; ++i) {
        if (table[i & 15] == result)
            continue;
        result += table[(i * result) & 15];
        if (result > 100000)
            break;
    }
    out[threadIdx.x] = result;
}
