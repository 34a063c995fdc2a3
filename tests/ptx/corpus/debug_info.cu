// SPDX-License-Identifier: Apache-2.0
// A small kernel whose compiler output carries full debug information (clang -g -O0).
__attribute__((device)) __attribute__((noinline)) int scale(int value) {
    int result = value * 2;
    return result + 1;
}

extern "C" __attribute__((global)) void scaleAll(int* values, int count) {
    for (int i = 0; i < count; ++i)
        values[i] = scale(values[i]);
}
