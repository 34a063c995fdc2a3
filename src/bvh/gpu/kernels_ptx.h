// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sunstone::bvh::gpu {

// The builder kernels as PTX text, compiled with the library.
const char* builderPtx();

} // namespace sunstone::bvh::gpu
