// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/process.h"

namespace sunstone::engine {

GpuProcess& gpuProcess() {
    static auto* all = new GpuProcess; // never destroyed: programs call while the process ends
    return *all;
}

} // namespace sunstone::engine
