// SPDX-License-Identifier: Apache-2.0
// The row kernels for any x86-64, and the choice of an instruction set.
#include "denoise/rows/rows_kernels.h"

namespace sunstone::denoise {

const RowKernels& baseRowKernels() {
    return kKernels;
}

const RowKernels& rowKernels() {
#if defined(__x86_64__)
    static const bool hasAvx2 = __builtin_cpu_supports("avx2");
    return hasAvx2 ? avx2RowKernels() : baseRowKernels();
#else
    return baseRowKernels();
#endif
}

} // namespace sunstone::denoise
