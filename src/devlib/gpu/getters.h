// SPDX-License-Identifier: Apache-2.0
// Getters that look into acceleration structures.
#pragma once

#include "devlib/gpu/programs.h"

namespace sunstone::devlib::gpu {

// Structures with motion cannot be built for GPUs yet: all stand still.
extern "C" void sunstone_gpu_gasMotion(uint64_t, GasMotion* motion) {
    *motion = {1, 0, 0};
}

} // namespace sunstone::devlib::gpu
