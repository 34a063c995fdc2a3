// SPDX-License-Identifier: Apache-2.0
// How programs and their data are found. One set of functions for CPUs and GPUs.
//
// A record is an SbtHeader, which names a program group, followed by the programs' data. The API
// generation defines the position of the record of a hit, a miss or a callable: the trace run-time
// asks a Records type, its template parameter, for addresses. SbtRecords is that of OptiX 7,
// ClassicRecords that of the classic API. A missing record has the address 0.
#pragma once

#include "base/inline.h"
#include "devlib/abi.h"
#include "devlib/classic.h"

namespace sunstone::devlib {

constexpr uint32_t kNoGroup = ~0u;

// The program that a record must name. Launches log records that are missing or wrong.
enum class NeededProgram : uint32_t { kHit = 1, kMiss, kDirectCallable, kContinuationCallable };

// The program in the upper half, the index of its record in the lower.
SUNSTONE_INLINE uint64_t recordNote(NeededProgram program, uint64_t index) {
    return uint64_t(program) << 32 | uint32_t(index);
}

// Address of a record in a table, or 0 for an index beyond the table.
SUNSTONE_INLINE uint64_t recordAt(uint64_t base, uint32_t stride, uint32_t count, uint64_t index) {
    return base == 0 || index >= count ? 0 : base + index * stride;
}

SUNSTONE_INLINE const void* dataOf(uint64_t record) {
    return record ? reinterpret_cast<const void*>(record + sizeof(SbtHeader)) : nullptr;
}

// A record's group, counted from the pipeline's first, if its header has that kind; else kNoGroup.
// Groups of other pipelines give numbers that the pipeline does not have.
SUNSTONE_INLINE uint32_t groupOf(const LaunchState& launch, uint64_t record, GroupKind kind) {
    const SbtHeader& header = *reinterpret_cast<const SbtHeader*>(record);
    return header.magic == kSbtMagic && header.kind == kind ? header.group - launch.firstGroup
                                                            : kNoGroup;
}

// The records of OptiX 7: the caller's shader binding table. Source: OptiX Programming Guide 7.4,
// "Shader binding table"; the API reference names the fields (section 5.32).
struct SbtRecords {
    static constexpr bool kVisits = false;            // graphs may hold VisitNodes, and instances
                                                      // outside of structures
    static constexpr bool kAttributeBlocks = false;   // RayState::attributeBlocks
    static constexpr bool kMaterials = false;         // reports choose a record among the input's
    static constexpr bool kAttributePrograms = false; // of triangles
    static constexpr bool kOwnHandles = false;        // rays have handles of the shell alone
    static constexpr bool kOwnRecords = false;        // the shell fills the records
    static constexpr unsigned kAttributeWords = kMaxAttributeWords; // of a hit, beside the blocks

    // The index of a hit's record, also for messages.
    SUNSTONE_INLINE_MEMBER static uint64_t hitIndex(const RayState& ray, uint32_t sbtGasIndex,
                                                    uint32_t instanceSbtOffset) {
        return uint64_t(instanceSbtOffset) + uint64_t(sbtGasIndex) * (ray.sbtStride & 0xFF) +
               (ray.sbtOffset & 0xFF);
    }
    SUNSTONE_INLINE_MEMBER static uint64_t hit(const RayState& ray, uint32_t sbtGasIndex,
                                               uint32_t instanceSbtOffset) {
        const SbtView& sbt = ray.launch->sbt;
        return recordAt(sbt.hitBase, sbt.hitStride, sbt.hitCount,
                        hitIndex(ray, sbtGasIndex, instanceSbtOffset));
    }
    SUNSTONE_INLINE_MEMBER static uint64_t miss(const RayState& ray) {
        const SbtView& sbt = ray.launch->sbt;
        return recordAt(sbt.missBase, sbt.missStride, sbt.missCount, ray.missIndex);
    }
    SUNSTONE_INLINE_MEMBER static uint64_t callable(const LaunchState& launch, uint32_t index) {
        const SbtView& sbt = launch.sbt;
        return recordAt(sbt.callableBase, sbt.callableStride, sbt.callableCount, index);
    }

    // For code that is no template: see ClassicRecords.
    SUNSTONE_INLINE_MEMBER static int32_t callableFault(const LaunchState&) { return 0; }
    SUNSTONE_INLINE_MEMBER static bool hasMaterial(const RayState&, uint32_t) { return true; }
    SUNSTONE_INLINE_MEMBER static int32_t materialFault(const RayState&) { return 0; }
    SUNSTONE_INLINE_MEMBER static void setTriangleAttributes(RayState&) {}
    SUNSTONE_INLINE_MEMBER static bool readsAttributes(const RayState&, uint32_t) { return false; }
};

// The records of the classic API are a table that its shell makes. Each geometry group has entries
// from InstanceRecord::sbtOffset on: an entry for each material of each of its instances, and in an
// entry a record for each ray type.
struct ClassicRecords {
    static constexpr bool kVisits = true;
    static constexpr bool kAttributeBlocks = true;
    static constexpr bool kMaterials = true;
    static constexpr bool kAttributePrograms = true;
    static constexpr bool kOwnHandles = true;
    static constexpr bool kOwnRecords = true;
    static constexpr unsigned kAttributeWords = 2; // barycentrics

    SUNSTONE_INLINE_MEMBER static uint64_t hitIndex(const RayState& ray, uint32_t sbtGasIndex,
                                                    uint32_t instanceSbtOffset) {
        return (uint64_t(instanceSbtOffset) + sbtGasIndex) * ray.sbtStride + ray.sbtOffset;
    }
    SUNSTONE_INLINE_MEMBER static uint64_t hit(const RayState& ray, uint32_t sbtGasIndex,
                                               uint32_t instanceSbtOffset) {
        const SbtView& sbt = ray.launch->sbt;
        return recordAt(sbt.hitBase, sizeof(ClassicRecord), sbt.hitCount,
                        hitIndex(ray, sbtGasIndex, instanceSbtOffset));
    }
    SUNSTONE_INLINE_MEMBER static uint64_t miss(const RayState& ray) {
        const SbtView& sbt = ray.launch->sbt;
        return recordAt(sbt.missBase, sizeof(ClassicRecord), sbt.missCount, ray.missIndex);
    }
    SUNSTONE_INLINE_MEMBER static uint64_t callable(const LaunchState& launch, uint32_t index) {
        return SbtRecords::callable(launch, index);
    }
    // The code of the exception for a call of an invalid program id; 0 if it is disabled.
    SUNSTONE_INLINE_MEMBER static int32_t callableFault(const LaunchState& launch) {
        const auto* params = static_cast<const ClassicLaunch*>(launch.params);
        return params->exceptions & kClassicProgramId ? kCodeProgramId : 0;
    }
    // Whether the geometry instance of a candidate's record has this material.
    SUNSTONE_INLINE_MEMBER static bool hasMaterial(const RayState& ray, uint32_t material) {
        const auto* record = static_cast<const ClassicRecord*>(ray.hit.record);
        return record && material < record->header.pad[kWordMaterials];
    }
    // The code of the exception for a missing material; 0 if it is disabled.
    SUNSTONE_INLINE_MEMBER static int32_t materialFault(const RayState& ray) {
        const auto* launch = static_cast<const ClassicLaunch*>(ray.launch->params);
        return launch->exceptions & kClassicIndex ? kCodeIndex : 0;
    }
    // Whether a program of the hit's record reads attributes.
    SUNSTONE_INLINE_MEMBER static bool readsAttributes(const RayState& ray, uint32_t reader) {
        const auto* record = static_cast<const ClassicRecord*>(ray.hit.record);
        return record && (record->header.pad[kWordReaders] & reader);
    }
    // Sets the attributes of a triangle, before an attribute program adds to them.
    SUNSTONE_INLINE_MEMBER static void setTriangleAttributes(RayState& ray) {
        auto* block = static_cast<char*>(ray.attributeBlocks[0]);
        const auto* record = static_cast<const ClassicRecord*>(ray.hit.record);
        auto* pair = reinterpret_cast<uint32_t*>(block + kBarycentricsOffset);
        pair[0] = ray.hit.attributes[0];
        pair[1] = ray.hit.attributes[1];
        *reinterpret_cast<uint32_t*>(block + kInstanceIdOffset) =
            record ? record->header.pad[kWordChild] : 0;
    }
};

// Precedes a bounds program: its primitive is the launch index.
SUNSTONE_INLINE void prepareBounds(RayState& root) {
    const uint32_t index = root.thread->index[0];
    root.hit.primitive = root.launch->firstPrimitive + index;
    root.hit.instanceIndex = root.launch->motionStep;
    root.payloadMemory = root.launch->boxes + size_t(6) * index;
}

// On CPUs: a record with its entry in the pipeline's table.
struct ResolvedRecord {
    const void* record = nullptr;      // null: no such record
    const GroupEntry* group = nullptr; // null: no group of the right kind in it
};

SUNSTONE_INLINE ResolvedRecord resolve(const LaunchState& launch, uint64_t record, GroupKind kind) {
    ResolvedRecord r;
    if (record == 0)
        return r;
    r.record = reinterpret_cast<const void*>(record);
    const uint32_t group = groupOf(launch, record, kind);
    if (group < launch.groupCount)
        r.group = &launch.groups[group];
    return r;
}

} // namespace sunstone::devlib
