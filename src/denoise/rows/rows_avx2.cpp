// SPDX-License-Identifier: Apache-2.0
// The row kernels for AVX2 (flags in the build files).
#include "denoise/rows/rows_kernels.h"

namespace sunstone::denoise {

const RowKernels& avx2RowKernels() {
    return kKernels;
}

} // namespace sunstone::denoise
