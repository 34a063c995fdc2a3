// SPDX-License-Identifier: Apache-2.0
// The functions of batch.h, compiled once per instruction set.
#pragma once

#include "base/threads/worker_object.h"
#include "bvh/batch/batch.h"
#include "bvh/batch/batch_flights.h"
#include "bvh/batch/batch_visitors.h"
#include "bvh/batch/nearest_walk.h"
#include "bvh/batch/packet_walk.h"
#include "bvh/batch/stream_walk.h"

#include <algorithm>

namespace sunstone::bvh::SUNSTONE_ISA {

// The rays of some pieces, and their hits.
template <uint32_t kPieces>
struct Pieces {
    static constexpr uint32_t kRays = kPieces * uint32_t(kPieceRays);
    uint64_t first;
    uint32_t count;
    BatchRay rays[kRays];
    BatchHit hits[kRays];
};
constexpr uint32_t kGroupPieces = 8;

template <uint32_t kPieces>
SUNSTONE_INLINE void readPieces(const RayBatch& batch, uint64_t number, uint64_t endNumber,
                                Pieces<kPieces>& piece) {
    const uint64_t begin = number * kPieceRays;
    piece.first = begin < batch.firstBit ? 0 : begin - batch.firstBit;
    const uint64_t end = std::min(batch.count, endNumber * kPieceRays - batch.firstBit);
    piece.count = uint32_t(end - piece.first);
    if (batch.rayFormat == RayFormat::kOriginTminDirectionTmax) {
        const float* from = reinterpret_cast<const float*>(batch.rays) + 8 * piece.first;
        for (uint32_t i = 0; i < piece.count; ++i, from += 8) {
            __builtin_memcpy(&piece.rays[i], from, 32);
            piece.rays[i].tmin = startOf(from[3]);
            piece.rays[i].mask = ~0u;
        }
        return;
    }
    for (uint32_t i = 0; i < piece.count; ++i)
        piece.rays[i] = readRay(batch, piece.first + i);
}

template <uint32_t kPieces>
static void writeBits(const RayBatch& batch, const Pieces<kPieces>& piece) {
    auto* const bytes = reinterpret_cast<uint8_t*>(batch.hits);
    for (uint32_t i = 0; i < piece.count; ++i) {
        const uint64_t place = batch.firstBit + piece.first + i;
        const uint8_t bit = uint8_t(1u << (place & 7));
        uint8_t& byte = bytes[place >> 3];
        byte = piece.hits[i].t >= 0 ? uint8_t(byte | bit) : uint8_t(byte & ~bit);
    }
}

template <uint32_t kPieces>
SUNSTONE_INLINE void writePieces(const RayBatch& batch, const Pieces<kPieces>& piece) {
    if (batch.hitFormat == HitFormat::kBit)
        return writeBits(batch, piece);
    const RayBatch format = batch; // a copy, because hits may alias `batch`
    for (uint32_t i = 0; i < piece.count; ++i)
        writeHit(format, piece.first + i, piece.hits[i]);
}

// Traces the rays of several pieces: packets of similar rays take turns; other rays that seek the
// nearest hit go in flight.
template <class Judge, bool kMasked>
static void traceGroup(const RayBatch& batch, const BatchScene& scene, uint64_t number,
                       uint64_t endNumber) {
    // Too large for the stacks of all threads.
    auto& group = workerObject<Pieces<kGroupPieces>>();
    readPieces(batch, number, endNumber, group);
    auto& packets = workerObject<PacketWalk<Judge, kMasked>>();
    packets.enter(scene.header, scene.masksOf(0));
    const std::span<const uint16_t> others = packets.trace(group.rays, group.hits, group.count);
    if constexpr (Judge::kOrdered) {
        auto& walk = workerObject<typename BatchFlights<Judge, kMasked>::Walk>();
        BatchFlights<Judge, kMasked>(walk, scene).trace(group.rays, group.hits, others);
    } else {
        auto& stream = workerObject<StreamWalk<Judge, kMasked>>();
        stream.enter(scene.header, scene.masksOf(0));
        for (size_t i = 0; i < others.size(); i += stream.kRays) // whole pieces of the group
            stream.trace(group.rays + others[i], group.hits + others[i],
                         uint32_t(std::min<size_t>(stream.kRays, others.size() - i)));
    }
    writePieces(batch, group);
}

// Finds any hit of a piece's rays as a stream: a node is visited once for all rays that meet it.
// False if packets are faster.
template <class Judge, bool kMasked>
static bool traceStream(const RayBatch& batch, const BatchScene& scene, uint64_t number) {
    Pieces<1> piece;
    readPieces(batch, number, number + 1, piece);
    if (PacketWalk<Judge, kMasked>::isNarrow(piece.rays, piece.count))
        return false;
    auto& stream = workerObject<StreamWalk<Judge, kMasked>>();
    stream.enter(scene.header, scene.masksOf(0));
    stream.trace(piece.rays, piece.hits, piece.count);
    writePieces(batch, piece);
    return true;
}

template <class Judge, bool kMasked>
static void traceInstances(const RayBatch& batch, const BatchScene& scene, uint64_t number,
                           uint64_t endNumber) {
    auto& group = workerObject<Pieces<kGroupPieces>>();
    readPieces(batch, number, endNumber, group);
    uint16_t all[Pieces<kGroupPieces>::kRays];
    for (uint32_t i = 0; i < group.count; ++i)
        all[i] = uint16_t(i);
    auto& walk = workerObject<typename BatchFlights<Judge, kMasked>::Walk>();
    BatchFlights<Judge, kMasked>(walk, scene).trace(group.rays, group.hits, {all, group.count});
    writePieces(batch, group);
}

// Up to this number of rays, single rays are faster.
constexpr uint64_t kFewRays = 8;

template <class Judge, bool kMasked>
static void traceFew(const RayBatch& batch, const BatchScene& scene) {
    Pieces<2> rays; // rays of a bit mask may be in two pieces
    readPieces(batch, 0, pieceCount(batch), rays);
    for (uint32_t i = 0; i < rays.count; ++i) {
        const BatchRay& ray = rays.rays[i];
        rays.hits[i] = kNoBatchHit;
        if (!isRay(ray.origin, ray.direction, ray.tmin, ray.tmax))
            continue;
        RaySetup setup;
        setupRay(setup, scene.header, ray.origin, ray.direction, ray.tmin, ray.tmax);
        Judge judge(ray);
        walkOne<Judge, kMasked>(scene, ray, setup, judge);
        rays.hits[i] = judge.hit();
    }
    writePieces(batch, rays);
}

template <class Judge, bool kMasked>
static void tracePieces(const RayBatch& batch, const BatchScene& scene, uint64_t number,
                        uint64_t endNumber) {
    if (number == 0 && endNumber == pieceCount(batch) && batch.count < kFewRays)
        return traceFew<Judge, kMasked>(batch, scene);
    while (number < endNumber) {
        if (!Judge::kOrdered && !scene.instances &&
            traceStream<Judge, kMasked>(batch, scene, number)) {
            ++number;
            continue;
        }
        const uint64_t end = std::min(endNumber, number + kGroupPieces);
        if (scene.instances)
            traceInstances<Judge, kMasked>(batch, scene, number, end);
        else
            traceGroup<Judge, kMasked>(batch, scene, number, end);
        number = end;
    }
}

template <class Judge>
static void trace(const RayBatch& batch, uint64_t number, uint64_t endNumber) {
    const BatchScene scene(batch.handle, batch.masks);
    if (scene.header->root == kNoNode) {
        Pieces<1> piece;
        std::fill_n(piece.hits, piece.kRays, kNoBatchHit);
        for (; number < endNumber; ++number) {
            readPieces(batch, number, number + 1, piece);
            writePieces(batch, piece);
        }
    } else if (batch.masks) {
        tracePieces<Judge, true>(batch, scene, number, endNumber);
    } else {
        tracePieces<Judge, false>(batch, scene, number, endNumber);
    }
}

// Lists every candidate. A triangle with several references (build/presplit.h) is listed once for
// each reference.
struct ListJudge {
    static constexpr bool kOrdered = false;
    float tmax;
    std::vector<ListedHit>* hits;
    uint64_t ray;
    uint32_t instance = ~0u;
    bool found = false;

    bool take(float t, float v, float w, float det, uint32_t triangle, uint32_t) {
        hits->push_back({ray, {t, triangle, instance == ~0u ? 0u : instance, v / det, w / det}});
        return false;
    }
};

// Sorts the hits of one ray, from index `first` on, and removes duplicates: all references to a
// triangle give the same hit.
static void sortListed(std::vector<ListedHit>& hits, size_t first) {
    const auto begin = hits.begin() + ptrdiff_t(first);
    std::sort(begin, hits.end(), [](const ListedHit& a, const ListedHit& b) {
        if (a.hit.t != b.hit.t)
            return a.hit.t < b.hit.t;
        return a.hit.instance != b.hit.instance ? a.hit.instance < b.hit.instance
                                                : a.hit.triangle < b.hit.triangle;
    });
    const auto end = std::unique(begin, hits.end(), [](const ListedHit& a, const ListedHit& b) {
        return a.hit.t == b.hit.t && a.hit.instance == b.hit.instance &&
               a.hit.triangle == b.hit.triangle;
    });
    hits.erase(end, hits.end());
}

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
        sortListed(hits, before);
    }
}

static constexpr BatchKernels kBatch = {trace<ClosestJudge>, trace<AnyJudge>, all, nearest};

} // namespace sunstone::bvh::SUNSTONE_ISA
