// SPDX-License-Identifier: Apache-2.0
// Calls the runtime's names in a library that exports them.
#include <stdio.h>

int cudaMalloc(void), __cudaRegisterFatBinary(void), __cudaUnregisterFatBinary(void);

int main(void) {
    printf("%d %d %d\n", cudaMalloc(), __cudaRegisterFatBinary(), __cudaUnregisterFatBinary());
    return 0;
}
