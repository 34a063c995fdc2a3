// SPDX-License-Identifier: Apache-2.0
// The data that the host and the kernel of a launch on a GPU exchange. Lies in device memory, one
// block for each launch in flight; the launch parameters follow it.
#pragma once

#include "devlib/abi.h"

#include <cstddef>

namespace sunstone::devlib {

// Launch index (linear, so that the lowest one wins) in the upper, code in the lower half; all
// ones: nothing happened.
constexpr uint64_t kNoReport = ~uint64_t(0);

// The message of the first launch index that fails an assertion or traps. The report holds the
// texts themselves, because the module that contains them may be unloaded when the host reads the
// report.
struct LaunchSaying {
    static constexpr unsigned kTexts = 3, kBytes = 192;

    uint64_t by; // the launch index (linear) plus one; 0: none
    uint32_t line;
    int32_t code; // as in LaunchReport::fatal
    // Assertion: condition, file and function. Trap: its place.
    char texts[kTexts][kBytes];
};

// Rays that have ended in warps that take launch indices, and the time that these warps ran, in
// units of 256 clock cycles.
struct WarpPace {
    uint64_t rays, time;
};
constexpr unsigned kPatienceWays = 4;

struct LaunchReport {
    uint64_t raised;  // exception of the run-time
    uint64_t unseen;  // exception without an exception program
    uint64_t fatal;   // trap, stack overflow, or a fault of FatalCode: the launch failed
    uint32_t wideSbt; // as in LaunchNotes
    uint32_t deepGraph, deepTrace, outsideFlags, motion; // as in LaunchNotes
    uint64_t record;                                     // as in LaunchNotes
    uint64_t unknown; // an invalid handle that a ray was given or met; or 0
    uint64_t usual; // a handle that rays are given, other than LaunchConstants::usual; or 0
    // With debug exceptions: the details of their getters, word by word in the lower halves
    // (ReportWord). The upper halves have the launch index, which tells whether words belong
    // together.
    static constexpr unsigned kWords = 12;
    uint64_t raisedDetails[kWords], unseenDetails[kWords];
    WarpPace paces[kPatienceWays]; // by patience, if LaunchWork::isMeasured
    LaunchSaying saying;
};

// Layout of the details. An invalid ray uses all nine words from 0 on, other exceptions the words
// below. Addresses are those of texts in the pipeline's module.
enum ReportWord : unsigned {
    kWordTraversable = 0, // 2 words
    kWordSbtOffset = 2,
    kWordExpected = 3, // then passed, index
    kWordName = 6,     // address, 2 words
    kWordLine = 9,     // address, 2 words
    kWordCode = 11,
};

inline LaunchReport emptyReport() {
    LaunchReport report;
    report.raised = report.unseen = report.fatal = kNoReport;
    report.wideSbt = report.deepGraph = report.deepTrace = report.outsideFlags = report.motion = 0;
    report.record = report.unknown = report.usual = 0;
    for (unsigned i = 0; i < LaunchReport::kWords; ++i)
        report.raisedDetails[i] = report.unseenDetails[i] = kNoReport;
    for (WarpPace& pace : report.paces)
        pace = {};
    report.saying = {};
    return report;
}

// Fatal codes of the launch itself, beside ExceptionCode.
enum FatalCode : int32_t {
    kFatalRaygenRecord = -1000,    // holds no ray generation group of the pipeline
    kFatalExceptionRecord = -1001, // holds no exception group of the pipeline
    kFatalGraphTooDeep = -1002,    // the structures on a path are too deep in total
    kFatalAssertion = -1003,       // a failed assertion
    kFatalVisits = -1004,          // more nested visit programs than kMostNestedVisits
};

// Spaces on a path, without the world's: those of the deepest graph that the property
// LIMIT_MAX_TRAVERSABLE_GRAPH_DEPTH allows.
constexpr unsigned kMaxGpuGraphDepth = kMaxGraphDepth - 1;

// The most visit programs that may be nested on a path through the graph.
constexpr unsigned kMostNestedVisits = 4;

// Memory that warps claim for the states of their rays (devlib/gpu/lane_memory.h).
struct LaneMemory {
    uint64_t slots;     // address of the first slot
    uint64_t freeSlots; // address of the bit set of free slots
    uint32_t words;     // of the bit set
    uint32_t slotBytes;
    // In code for many pipelines: bytes of a frame, a multiple of 64. Other code knows its layout.
    uint64_t frameBytes;
};

// A lane's part of a slot in code for many pipelines: states, then frames, of the depths from
// `near` on. Programs have depths 0 to maxTraceDepth; a ray beyond it needs a state, too.
struct FarLayout {
    constexpr FarLayout(uint32_t maxTraceDepth, uint32_t near, uint64_t frameBytes)
        : stateBytes(uint64_t(maxTraceDepth + 2 - near) * sizeof(RayState)),
          bytes(stateBytes + uint64_t(maxTraceDepth + 1 - near) * frameBytes) {}
    uint64_t stateBytes, bytes;
};

// Launch indices of a kernel whose warps take them (devlib/gpu/loop.h), as numbers from 0 in the
// order of tiles of 32 (see kGpuTileWidth).
struct LaunchWork {
    uint64_t next;  // the first that no warp has taken
    uint64_t count; // of all tiles, including indices beyond the edges
    // The cost of idle lanes that a warp accepts before it refills them, in steps of lanes through
    // nodes. Blocks use the values in turn.
    uint32_t patience[kPatienceWays];
    uint32_t isMeasured; // warps report their pace
    uint32_t blockSize;  // for the host: which size of blocks
    LaneMemory laneMemory;
};

// The fastest patience depends on programs and scene (engine/gpu/patience.h): refilling idle lanes
// early is better if the lengths of rays vary widely, waiting for the rays of all lanes is better
// if programs between rays are long. With kTilePatience lanes also wait with new launch indices
// until all of them need one, so that neighbours stay together. With kDepthPatience lanes whose ray
// is less deep than that of another lane of the warp wait, too: programs after a trace run for the
// lanes that trace there and for those that do not, in step.
constexpr uint32_t kShortPatience = 128;
constexpr uint32_t kLongPatience = 0x0FFFFFFD; // kernels may take a multiple
constexpr uint32_t kTilePatience = 0x0FFFFFFE;
constexpr uint32_t kDepthPatience = 0x0FFFFFFF;
// Added to a patience: the warps of a block wait for each other before they run programs. Programs
// that exceed the instruction cache are then loaded for all of them together.
constexpr uint32_t kWithBlock = 1u << 31;

struct LaunchBlock {
    LaunchState launch;
    LaunchConstants constants;
    LaunchReport report;
    // With stack overflow exceptions: bytes of stack for a launch index.
    uint32_t stackBytes;
    uint32_t pad;
    LaunchWork work;
};
static_assert(offsetof(LaunchBlock, constants) == sizeof(LaunchState));

// Traversables that optixTrace may receive. kGraphShallow: of any kind, but at most two on a path.
enum GraphKind : uint32_t {
    kGraphGas = 0,
    kGraphSingleLevel = 1,
    kGraphAny = 2,
    kGraphShallow = 3,
};
constexpr unsigned kGraphKinds = 4;

// Motion that rays may meet. kMotionTransforms: no structure has motion keys.
enum MotionKind : uint32_t { kMotionNone, kMotionTransforms, kMotionAll };

// Constant of the run-time in code that serves many pipelines: the launch has the pipeline's value.
constexpr uint32_t kGpuFactOfLaunch = 1u << 31;

// Threads of a block, and the shape of a warp's tile of launch indices; launches of height 1 have
// their indices in a row.
constexpr unsigned kGpuBlockThreads = 64;
// The same where the warps of a block walk in step (devlib/gpu/nested.h).
constexpr unsigned kGpuStepBlockThreads = 256;
constexpr unsigned kGpuTileWidth = 8, kGpuTileHeight = 4;
constexpr unsigned kGpuTile = kGpuTileWidth * kGpuTileHeight;

// Tiles of a launch of these dimensions.
constexpr uint64_t gpuTiles(const uint32_t size[3]) {
    if (size[1] == 1)
        return (uint64_t(size[0]) * size[2] + kGpuTile - 1) / kGpuTile;
    return uint64_t((size[0] + kGpuTileWidth - 1) / kGpuTileWidth) *
           ((size[1] + kGpuTileHeight - 1) / kGpuTileHeight) * size[2];
}

} // namespace sunstone::devlib
