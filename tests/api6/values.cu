// SPDX-License-Identifier: Apache-2.0
// A variable of each type that rtVariableSet* sets, and programs that write their components.
#include <optix_world.h>

using namespace optix;

rtBuffer<double, 1> numbers;

#define VALUES(letters, T1, T2, T3, T4)                                                            \
    rtDeclareVariable(T1, letters##_one, , );                                                      \
    rtDeclareVariable(T2, letters##_two, , );                                                      \
    rtDeclareVariable(T3, letters##_three, , );                                                    \
    rtDeclareVariable(T4, letters##_four, , );                                                     \
    RT_PROGRAM void write_##letters() {                                                            \
        numbers[0] = double(letters##_one);                                                        \
        numbers[1] = double(letters##_two.x);                                                      \
        numbers[2] = double(letters##_two.y);                                                      \
        numbers[3] = double(letters##_three.x);                                                    \
        numbers[4] = double(letters##_three.y);                                                    \
        numbers[5] = double(letters##_three.z);                                                    \
        numbers[6] = double(letters##_four.x);                                                     \
        numbers[7] = double(letters##_four.y);                                                     \
        numbers[8] = double(letters##_four.z);                                                     \
        numbers[9] = double(letters##_four.w);                                                     \
    }
VALUES(f, float, float2, float3, float4)
VALUES(i, int, int2, int3, int4)
VALUES(ui, unsigned int, uint2, uint3, uint4)
VALUES(ll, long long, longlong2, longlong3, longlong4)
VALUES(ull, unsigned long long, ulonglong2, ulonglong3, ulonglong4)

// Rows first.
#define MATRIX(n, m)                                                                               \
    rtDeclareVariable(Matrix##n##x##m, matrix##n##x##m, , );                                       \
    RT_PROGRAM void write_##n##x##m() {                                                            \
        for (unsigned row = 0; row < n; ++row)                                                     \
            for (unsigned column = 0; column < m; ++column)                                        \
                numbers[row * m + column] = double(matrix##n##x##m[row * m + column]);             \
    }
MATRIX(2, 2)
MATRIX(2, 3)
MATRIX(2, 4)
MATRIX(3, 2)
MATRIX(3, 3)
MATRIX(3, 4)
MATRIX(4, 2)
MATRIX(4, 3)
MATRIX(4, 4)
