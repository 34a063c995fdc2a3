// SPDX-License-Identifier: Apache-2.0
// Queries for arrays of rays and points on the CPU, without programs. Structures are those of
// bvh/build/build.h: triangles, or instances of structures of triangles. Rays of a piece traverse
// together (stream_walk.h); their hits equal those of single rays.
//
// Among hits at one distance, the lowest instance and then the lowest triangle counts.
#pragma once

#include "bvh/batch/ray_batch.h"
#include "bvh/walk/kernels.h"

#include <cstdint>
#include <vector>

namespace sunstone::bvh {

// The nearest point of all triangles within a distance.
struct NearestPoint {
    float distance; // negative: none
    uint32_t triangle, instance;
    float u, v;
    float point[3];
};

// A batch is traced in pieces: piece p has the rays from 64 p - firstBit up to 64 (p + 1) -
// firstBit, so that no byte of a bit mask belongs to two pieces.
constexpr uint64_t kPieceRays = 64;
inline uint64_t pieceCount(const RayBatch& batch) {
    return (batch.firstBit + batch.count + kPieceRays - 1) / kPieceRays;
}

// One candidate of a ray in allHits().
struct ListedHit {
    uint64_t ray;
    BatchHit hit;
};

struct BatchKernels {
    // Find the nearest hit, or any hit, of the rays of these pieces.
    void (*closest)(const RayBatch& batch, uint64_t piece, uint64_t endPiece);
    void (*any)(const RayBatch& batch, uint64_t piece, uint64_t endPiece);
    // Appends all hits of these rays, ray by ray, the nearest first.
    void (*all)(const RayBatch& batch, uint64_t first, uint64_t end, std::vector<ListedHit>& hits);
    // Finds the nearest point to each of the points (3 floats) in [first, end), up to this
    // distance.
    void (*nearest)(uint64_t handle, const float* points, float farthest, NearestPoint* out,
                    uint64_t first, uint64_t end);
};

const BatchKernels& batchKernels(Isa isa);

extern const BatchKernels kBatchBaseline, kBatchAvx2, kBatchAvx512;

// Trace whole batches on the shared threads.
void traceBatch(const RayBatch& batch, bool any);

} // namespace sunstone::bvh
