// SPDX-License-Identifier: Apache-2.0
// The OptiX shell distinguishes this libcuda from a GPU driver's by this symbol.

extern "C" __attribute__((visibility("default"))) int sunstone_cuda_is_cpu_device() {
    return 1;
}
