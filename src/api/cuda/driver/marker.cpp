// SPDX-License-Identifier: Apache-2.0
// A symbol by which the OptiX shell tells this libcuda from a GPU driver's.

extern "C" __attribute__((visibility("default"))) int sunstone_cuda_is_cpu_device() {
    return 1;
}
