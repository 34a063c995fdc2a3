// SPDX-License-Identifier: Apache-2.0
#include "bvh/batch/batch_body.h"

namespace sunstone::bvh {

const BatchKernels kBatchBaseline = SUNSTONE_ISA::kBatch;

} // namespace sunstone::bvh
