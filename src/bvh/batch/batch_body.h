// SPDX-License-Identifier: Apache-2.0
// The functions of batch.h, compiled once per instruction set.
#pragma once

#include "base/thread_object.h"
#include "bvh/batch/batch.h"
#include "bvh/batch/batch_flights.h"
#include "bvh/batch/batch_visitors.h"
#include "bvh/batch/nearest_walk.h"
#include "bvh/batch/packet_walk.h"

#include <algorithm>

namespace sunstone::bvh::SUNSTONE_ISA {

// The rays of some pieces, and their hits.
constexpr uint32_t kGroupPieces = 8;
struct Piece {
    uint64_t first;
    uint32_t count;
    BatchRay rays[kGroupPieces * kPieceRays];
    BatchHit hits[kGroupPieces * kPieceRays];
};

SUNSTONE_INLINE void readPieces(const RayBatch& batch, uint64_t number, uint64_t endNumber,
                                Piece& piece) {
    const uint64_t begin = number * kPieceRays;
    piece.first = begin < batch.firstBit ? 0 : begin - batch.firstBit;
    const uint64_t end = std::min(batch.count, endNumber * kPieceRays - batch.firstBit);
    piece.count = uint32_t(end - piece.first);
    for (uint32_t i = 0; i < piece.count; ++i)
        piece.rays[i] = readRay(batch, piece.first + i);
}

static void writeBits(const RayBatch& batch, const Piece& piece) {
    auto* const bytes = reinterpret_cast<uint8_t*>(batch.hits);
    for (uint32_t i = 0; i < piece.count; ++i) {
        const uint64_t place = batch.firstBit + piece.first + i;
        const uint8_t bit = uint8_t(1u << (place & 7));
        uint8_t& byte = bytes[place >> 3];
        byte = piece.hits[i].t >= 0 ? uint8_t(byte | bit) : uint8_t(byte & ~bit);
    }
}

SUNSTONE_INLINE void writePiece(const RayBatch& batch, const Piece& piece) {
    if (batch.hitFormat == HitFormat::kBit)
        return writeBits(batch, piece);
    for (uint32_t i = 0; i < piece.count; ++i)
        writeHit(batch, piece.first + i, piece.hits[i]);
}

template <class Judge, bool kMasked>
SUNSTONE_INLINE void traceOne(const BatchScene& scene, const BatchRay& ray, BatchHit& hit) {
    hit = kNoBatchHit;
    if (!isRay(ray.origin, ray.direction, ray.tmin, ray.tmax))
        return;
    RaySetup setup;
    setupRay(setup, scene.header, ray.origin, ray.direction, ray.tmin, ray.tmax);
    Judge judge(ray.tmax);
    walkOne<Judge, kMasked>(scene, ray, setup, judge);
    hit = judge.hit();
}

template <class Judge, bool kMasked>
static void tracePieces(const RayBatch& batch, const BatchScene& scene, uint64_t number,
                        uint64_t endNumber) {
    // Too large for the stacks of all threads.
    auto& walk = threadObject<typename BatchFlights<Judge, kMasked>::Walk>();
    auto& piece = threadObject<Piece>();
    BatchFlights<Judge, kMasked> flights(walk, scene);
    auto& packets = threadObject<PacketWalk<Judge, kMasked>>();
    packets.enter(scene.header, scene.instances ? nullptr : scene.masksOf(0));
    uint16_t all[kGroupPieces * kPieceRays];
    for (uint32_t i = 0; i < std::size(all); ++i)
        all[i] = uint16_t(i);
    for (; number < endNumber; number += kGroupPieces) {
        readPieces(batch, number, std::min(endNumber, number + kGroupPieces), piece);
        if (scene.instances) {
            flights.trace(piece.rays, piece.hits, {all, piece.count});
        } else {
            packets.trace(piece.rays, piece.hits, piece.count);
            flights.trace(piece.rays, piece.hits, packets.others());
        }
        writePiece(batch, piece);
    }
}

template <class Judge>
static void trace(const RayBatch& batch, uint64_t number, uint64_t endNumber) {
    const BatchScene scene(batch.handle, batch.masks);
    if (scene.header->root == kNoNode) {
        auto& piece = threadObject<Piece>();
        std::fill_n(piece.hits, std::size(piece.hits), kNoBatchHit);
        for (; number < endNumber; number += kGroupPieces) {
            readPieces(batch, number, std::min(endNumber, number + kGroupPieces), piece);
            writePiece(batch, piece);
        }
    } else if (batch.masks) {
        tracePieces<Judge, true>(batch, scene, number, endNumber);
    } else {
        tracePieces<Judge, false>(batch, scene, number, endNumber);
    }
}

// Lists every candidate.
struct ListJudge {
    static constexpr bool kOrdered = false;
    float tmax;
    std::vector<ListedHit>* hits;
    uint64_t ray;
    uint32_t instance = ~0u;
    bool found = false;

    bool take(float t, float v, float w, float det, uint32_t triangle) {
        hits->push_back({ray, {t, triangle, instance == ~0u ? 0u : instance, v / det, w / det}});
        return false;
    }
};

static void all(const RayBatch& batch, uint64_t first, uint64_t end, std::vector<ListedHit>& hits) {
    const BatchScene scene(batch.handle, batch.masks);
    for (uint64_t i = first; i < end && scene.header->root != kNoNode; ++i) {
        const BatchRay ray = readRay(batch, i);
        if (!isRay(ray.origin, ray.direction, ray.tmin, ray.tmax))
            continue;
        RaySetup setup;
        setupRay(setup, scene.header, ray.origin, ray.direction, ray.tmin, ray.tmax);
        ListJudge judge{ray.tmax, &hits, i};
        const size_t before = hits.size();
        walkOne<ListJudge, true>(scene, ray, setup, judge);
        std::sort(hits.begin() + ptrdiff_t(before), hits.end(),
                  [](const ListedHit& a, const ListedHit& b) {
                      if (a.hit.t != b.hit.t)
                          return a.hit.t < b.hit.t;
                      return a.hit.instance != b.hit.instance ? a.hit.instance < b.hit.instance
                                                              : a.hit.triangle < b.hit.triangle;
                  });
    }
}

static constexpr BatchKernels kBatch = {trace<ClosestJudge>, trace<AnyJudge>, all, nearest};

} // namespace sunstone::bvh::SUNSTONE_ISA
