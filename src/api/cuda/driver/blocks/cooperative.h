// SPDX-License-Identifier: Apache-2.0
// Cooperative launches: all blocks of the grid are resident, so they may wait for one another. See
// cooperative.cpp.
#pragma once

#include "api/cuda/driver/blocks/block.h"

namespace sunstone::api::cuda {

// Runs the launch, which holds its failures afterwards. Throws kOutOfMemory.
void runCooperative(Launch& launch);

} // namespace sunstone::api::cuda
