// SPDX-License-Identifier: Apache-2.0
// Data that compiled programs of the classic API share with the run-time, beside abi.h: the launch
// parameter block, which the shell fills and users never see, the records, and views of buffers.
// Plain data; the compiler takes offsetof of these structs.
#pragma once

#include "base/inline.h"
#include "devlib/abi.h"

namespace sunstone::devlib {

// A buffer as programs see it; one for each buffer of the context, at a fixed address, and copies
// in blocks of variables. GPUs load the first two members at once.
struct alignas(16) BufferView {
    uint8_t* data;
    uint64_t size[3]; // elements; 1 beyond the dimensionality
    uint32_t elementBytes;
    uint32_t dimensions; // 0: the view of all ids that are invalid
};

// Exceptions that can be enabled, beside kFlagStackOverflow, kFlagTraceDepth and kFlagUser of
// PipelineRules::exceptionFlags.
enum ClassicException : uint32_t {
    kClassicBufferIndex = 1,
    kClassicBufferId = 2,
    kClassicTextureId = 4,
    kClassicProgramId = 8,
    kClassicIndex = 16, // children of selectors, materials of reports
    kClassicInvalidRay = 32,
    kClassicPayload = 64,
    kClassicUserCode = 128, // of rtThrow
};

// Codes that exception programs see (RTexception).
enum ClassicCode : int32_t {
    kCodePayload = 0x3EB,
    kCodeUserCode = 0x3EC,
    kCodeTraceDepth = 0x3ED,
    kCodeProgramId = 0x3EE,
    kCodeTextureId = 0x3EF,
    kCodeBufferId = 0x3FA,
    kCodeIndex = 0x3FB,
    kCodeStackOverflow = 0x3FC,
    kCodeBufferIndex = 0x3FD,
    kCodeInvalidRay = 0x3FE,
    kCodeInternal = 0x3FF,
    kCodeUser = 0x400,
    kCodeUserMax = 0xFFFF,
};

// The flag of ClassicException that enables the exception `code`.
SUNSTONE_INLINE uint32_t switchOf(uint32_t code) {
    switch (code) {
    case kCodeBufferIndex:
        return kClassicBufferIndex;
    case kCodeBufferId:
        return kClassicBufferId;
    case kCodeTextureId:
        return kClassicTextureId;
    case kCodeProgramId:
        return kClassicProgramId;
    case kCodePayload:
        return kClassicPayload;
    default:
        return kClassicIndex;
    }
}

// The launch parameter block (LaunchState::params).
struct ClassicLaunch {
    const uint64_t* nodes;            // traversable handles by node id; 0 is no node
    const BufferView* const* buffers; // by buffer id
    const uint64_t* textures;         // texture handles by texture id
    uint32_t nodeCount, bufferCount, textureCount;
    uint32_t rayTypes;
    uint32_t subframe;
    uint32_t exceptions; // ClassicException
    uint32_t printEnabled;
    int32_t printIndex[3]; // of the launch index that prints; -1: any
    // The functions are for CPUs; programs on GPUs call functions of devlib/gpu/classic.h.
    //
    // The address for an element outside its buffer: zeros of the thread. Raises `code` if that
    // exception is enabled.
    void* (*outside)(RayState*, uint32_t bytes, uint32_t code);
    // Before a trace, with kClassicInvalidRay.
    void (*checkRay)(RayState*, RayState* ray);
    // The 3x4 matrix from world to the program's object space, or its inverse.
    void (*matrix)(RayState*, uint32_t toWorld, float rows[12]);
};

// Blocks with the variables of a record's programs.
enum ClassicBlock : uint32_t { kBlockMain, kBlockAnyHit, kBlockIntersection, kBlockAttribute };

// A record of any kind. Hit records store three words in the unused part of the header.
struct alignas(64) ClassicRecord {
    SbtHeader header;
    const void* blocks[4]; // by ClassicBlock
};
static_assert(sizeof(ClassicRecord) == 64);
enum ClassicHeaderWord : uint32_t {
    kWordChild,     // number of the geometry instance in its group
    kWordMaterials, // of the geometry instance
    kWordReaders,   // AttributeReader
};
// Hit programs of a record that read attributes, or call programs that may.
enum AttributeReader : uint32_t { kAnyHitReads = 1, kClosestHitReads = 2 };

// Built-in attributes of triangles, the first ones in every block.
constexpr uint32_t kBarycentricsOffset = 0, kInstanceIdOffset = 8, kFirstAttribute = 16;

// Words of RayState::payload have other uses here, as payloads are in memory.
constexpr uint32_t kWordTmax = 0;      // [trace] end of the interval of the trace call
constexpr uint32_t kWordCallables = 1; // [trace] depth of nested callables

// The functions of ClassicLaunch for the CPU.
void bindClassic(ClassicLaunch& launch);

} // namespace sunstone::devlib
