// SPDX-License-Identifier: Apache-2.0
// A name by which the OptiX shell recognises this libcuda among all that a process may have loaded.

extern "C" __attribute__((visibility("default"))) int sunstone_cuda_is_cpu_device() {
    return 1;
}
