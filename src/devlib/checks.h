// SPDX-License-Identifier: Apache-2.0
// Checks of trace calls, callables, getters and payload types for pipelines with debug exceptions:
// usage that the manual calls undefined ends the launch index through LaunchState::raise. The
// checks of traversal itself are in trace_body.h (kChecked).
#pragma once

#include "devlib/abi.h"

namespace sunstone::bvh {
struct BlockHeader;
}

namespace sunstone::devlib {

// Raises if the stack is exhausted, with any exception flags: the launch decides how to end.
void checkStack(RayState* state);

// Raises the exception that prevents the call of a callable; see LaunchState::callable.
void checkCallable(RayState* state, uint32_t sbtIndex, uint32_t call);

void checkAccess(RayState* state, uint32_t kind, uint64_t handle, uint32_t first, uint32_t second);
void checkPayload(RayState* state, uint32_t type);

// The arguments of optixTrace: floats must be finite, flags must not exclude each other.
void checkRay(RayState* state);
// Whether the group's intersection fits the primitives of the structure (null: any fits): built-in
// for curves and spheres, any for triangles, the application's for others.
bool fitsBuiltin(const GroupEntry& group, const bvh::BlockHeader* block, uint32_t sbtGasIndex);

} // namespace sunstone::devlib
