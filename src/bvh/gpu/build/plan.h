// SPDX-License-Identifier: Apache-2.0
// The host's plan of a build: counts, places in the caller's buffers, and the bytes that kernels
// read there. A new kind of primitives adds its counts, the size of its records and the description
// of its inputs here.
#pragma once

#include "bvh/build/build_parts.h"
#include "bvh/gpu/build/job.h"

#include <cstdint>
#include <vector>

namespace sunstone::bvh::gpu {

inline uint64_t addressOf(const void* pointer) {
    return reinterpret_cast<uint64_t>(pointer);
}

struct Plan {
    BlockType type;
    uint32_t numInputs = 1, numPrimitives = 0, maxReferences, maxWide, tiles;
    uint32_t numSbtRecords = 0;
    MotionOptions motion;           // keys: 1 without
    uint32_t shape = 0, pieces = 1; // of curves and spheres: as in BuildJob
    // Of the output.
    uint64_t table = 0, micromaps = 0, instances = 0, keyBounds = 0, points = 0, records, nodes,
        outputSize;
    // Places of scratch data: in the temp buffer, or in the part of the output buffer where records
    // follow later.
    struct Place {
        uint64_t offset = 0;
        bool inOutput = false;
    };
    uint64_t inputs, counters, tileStates, tasks, boxes, tempSize;
    uint64_t keyWords, arrivals, keyBoxes, nodeBoxes; // with motion
    // Offsets in Uploads::temp, from `inputs`.
    uint64_t keyData, flags, uploadSize;
    Place parents, origins, keys[2], values[2], binary, savings, order;
    uint64_t links, newNodes, newOrder;
    Gap gaps[kMaxGaps] = {};

    // Throws Error(kInvalidValue) as Builder::computeMemoryUsage does.
    Plan(const BuildInputs& in, const BuildOptions& options);

    const SbtInput& sbtOf(const BuildInputs& in, uint32_t i) const;
    uint32_t countOf(const BuildInputs& in, uint32_t i) const;
    // Whether triangles may have several references.
    bool maySplit() const {
        return type == BlockType::kTriangles && maxReferences > numPrimitives;
    }

private:
    uint64_t micromapTable = 0; // bytes
    void count(const BuildInputs& in);
    void countReferences(const BuildOptions& options);
    void layOutOutput(const BuildOptions& options);
    void layOutTemp();
};

// Scratch of an update, all of it in the temp buffer.
struct UpdatePlan {
    uint64_t inputs, counters, arrivals, keyWords, expected, parents, nodeBoxes,
        boxes = 0, keyBoxes = 0, tempSize;

    explicit UpdatePlan(const Plan& plan);
};

// The bytes that the host writes into the buffers before kernels run. Into the output: the header
// and the records of the inputs and of their micromaps (an update compares them with the present
// ones). Into the temp buffer, at the address `base`: DeviceInput[], addresses of the data at
// motion keys, and geometry flags.
struct Uploads {
    std::vector<uint8_t> output, temp;
    std::vector<MicromapRecord> micromaps; // for Plan::micromaps

    Uploads(const BuildInputs& in, const BuildOptions& options, const Plan& plan, uint64_t base);
};

} // namespace sunstone::bvh::gpu
