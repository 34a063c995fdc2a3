// SPDX-License-Identifier: Apache-2.0
// Acceleration structures in stream order: the call copies the caller's description; the caller's
// buffers are read and written when the stream reaches it.
#pragma once

#include "bvh/build/build.h"
#include "bvh/relocate.h"
#include "engine/context.h"
#include "engine/instance_rules.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sunstone::engine {

// Inputs of a build, with copies of all data that lies in host memory of the caller.
struct AccelInputs {
    std::vector<bvh::TriangleInput> triangles;
    std::vector<bvh::CustomInput> customs;
    std::vector<bvh::CurveInput> curves;
    std::vector<bvh::SphereInput> spheres;
    std::unique_ptr<bvh::InstanceInput> instances;
    std::vector<std::vector<uint32_t>> flags; // owned copies that the inputs point to
    std::vector<std::vector<const void*>> keys; // owned copies of buffers for motion keys

    // The view that the builders take. Valid while this object lives and is not moved.
    bvh::BuildInputs view() const;
    // Keeps a copy of flag words and returns its address.
    const uint32_t* keepFlags(const unsigned* words, size_t count);
    // Keeps the addresses of one buffer for each motion key.
    const void* const* keepKeys(std::vector<const void*> buffers);
};

struct AccelEmit {
    enum Kind { kCompactedSize, kBounds } kind = kCompactedSize;
    void* destination = nullptr;
};

struct AccelBuild {
    std::shared_ptr<const AccelInputs> inputs;
    bvh::BuildOptions options;
    void* temp = nullptr;
    size_t tempSize = 0;
    void* output = nullptr;
    size_t outputSize = 0;
    std::vector<AccelEmit> emit;
    void* stream = nullptr;
    bool update = false; // refit the structure that is in `output`
    std::optional<InstanceRules> rules; // instances that break them are logged
};

// Sizes of the buffers that a build of these inputs takes.
bvh::MemoryUsage accelMemory(const Context& context, const AccelInputs& inputs,
                             const bvh::BuildOptions& options);

// Queues the build and returns the future handle of the structure. An update first waits for the
// stream, to check that the structure in `output` was built from inputs of the same shape.
uint64_t buildAccel(const std::shared_ptr<Context>& context, AccelBuild request);

// Waits for the stream, checks that `handle` is a structure that may be compacted into
// `destination`, queues the copy and returns the new handle.
uint64_t compactAccel(const std::shared_ptr<Context>& context, void* stream, uint64_t handle,
                      void* destination, size_t destinationSize);

// For the back ends: calls tolerate() for a structure that was built without ALLOW_COMPACTION.
void tolerateCompaction(const Context& context, uint64_t handle);

// Whether the info is from a structure in the format of this context's device, or of an array of
// micromaps.
bool isRelocatable(const Context& context, const bvh::RelocationInfo& info);

// The relocation info of the structure for relocateAccel; waits for all streams.
bvh::RelocationInfo relocationInfo(const std::shared_ptr<Context>& context, uint64_t handle);

// Queues the relocation of the copy at `block` and returns its handle. `children`: see
// bvh::relocate; read when the stream reaches it. `arrays`: see bvh::relocateMicromaps; empty: all
// build inputs keep theirs.
uint64_t relocateAccel(const std::shared_ptr<Context>& context, void* stream,
                       const bvh::RelocationInfo& info, void* block, const uint64_t* children,
                       size_t count, std::vector<const void*> arrays);

// The handle of a transform in device memory.
enum class TransformType { kStatic, kMatrixMotion, kSrtMotion };
uint64_t transformHandle(const void* transform, TransformType type);

} // namespace sunstone::engine
