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

// What the first launch index to fail an assertion or to trap says. The report holds the texts,
// because the module that they stand in may be unloaded when the host reads the report.
struct LaunchSaying {
    static constexpr unsigned kTexts = 3, kBytes = 192;

    uint64_t by; // the launch index (linear) plus one; 0: none
    uint32_t line;
    int32_t code; // as in LaunchReport::fatal
    // Of an assertion the condition, the file and the function; of a trap its place.
    char texts[kTexts][kBytes];
};

// Rays that have ended in warps of a kernel whose warps take launch indices, and how long these
// warps ran, in units of 256 clock cycles.
struct WarpPace {
    uint64_t rays, time;
};
constexpr unsigned kPatienceWays = 3;

struct LaunchReport {
    uint64_t raised;  // exception of the run-time
    uint64_t unseen;  // exception without an exception program
    uint64_t fatal;   // trap, stack overflow, or a fault of FatalCode: the launch failed
    uint32_t wideSbt; // as in LaunchNotes
    uint32_t deepGraph, outsideFlags, motion; // the same
    uint64_t unknown; // a handle that a ray was given, or came to, and that leads nowhere; or 0
    uint64_t usual;   // one that rays are given, other than LaunchConstants::usual; or 0
    // With debug exceptions what their getters tell, word by word in the lower halves, with the
    // launch index above so that they are of the same one (ReportWord).
    static constexpr unsigned kWords = 12;
    uint64_t raisedDetails[kWords], unseenDetails[kWords];
    WarpPace paces[kPatienceWays]; // by patience, if LaunchWork::isMeasured
    LaunchSaying saying;
};

// An invalid ray takes all nine words from 0 on, other exceptions these. Addresses are of texts in
// the pipeline's module.
enum ReportWord : unsigned {
    kWordTraversable = 0, // 2
    kWordSbtOffset = 2,
    kWordExpected = 3, // then passed, index
    kWordName = 6,     // address, 2
    kWordLine = 9,     // address, 2
    kWordCode = 11,
};

inline LaunchReport emptyReport() {
    LaunchReport report;
    report.raised = report.unseen = report.fatal = kNoReport;
    report.wideSbt = report.deepGraph = report.outsideFlags = report.motion = 0;
    report.unknown = report.usual = 0;
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
    kFatalGraphTooDeep = -1002,    // the structures on a path are too deep together
    kFatalAssertion = -1003,       // a failed assertion
};

// Spaces on a path below the world's: those of the deepest graph that there may be, by the property
// LIMIT_MAX_TRAVERSABLE_GRAPH_DEPTH.
constexpr unsigned kMaxGpuGraphDepth = kMaxGraphDepth - 1;

// Visit programs that a path through the graph may meet one below the other.
constexpr unsigned kMostNestedVisits = 4;

// Memory that warps claim for the states of their rays (devlib/gpu/lane_memory.h).
struct LaneMemory {
    uint64_t slots;     // address of the first slot
    uint64_t freeSlots; // address of the set of free ones, a bit for each
    uint32_t words;     // of that set
    uint32_t slotBytes;
};

// Launch indices of a kernel whose warps take them (devlib/gpu/loop.h): numbers from 0, in the
// order of tiles of 32 (see kGpuTileWidth).
struct LaunchWork {
    uint64_t next;  // the first that no warp has taken
    uint64_t count; // of all tiles, those behind the edges too
    // What idle lanes may cost before a warp looks after them, in steps of lanes through nodes.
    // Blocks use the ways by turns.
    uint32_t patience[kPatienceWays];
    uint32_t isMeasured; // warps report their pace
    LaneMemory laneMemory;
};

// Which patience is the fastest depends on programs and scene (engine/gpu/patience.h): warps
// that look after idle lanes early gain where lengths of rays differ much, those that wait for the
// rays of all lanes where programs between rays are long. With patience for whole tiles, lanes also
// wait with new launch indices until all of them want one: neighbours then stay together.
constexpr uint32_t kShortPatience = 128;
constexpr uint32_t kLongPatience = 0x0FFFFFFE; // kernels may take a multiple
constexpr uint32_t kTilePatience = 0x0FFFFFFF;

struct LaunchBlock {
    LaunchState launch;
    LaunchConstants constants;
    LaunchReport report;
    // With stack overflow exceptions: bytes that a launch index may use.
    uint32_t stackBytes;
    uint32_t pad;
    LaunchWork work;
};
static_assert(offsetof(LaunchBlock, constants) == sizeof(LaunchState));

// Traversables that optixTrace may be given. kGraphShallow: of any kind, but at most two on a path.
enum GraphKind : uint32_t {
    kGraphGas = 0,
    kGraphSingleLevel = 1,
    kGraphAny = 2,
    kGraphShallow = 3,
};
constexpr unsigned kGraphKinds = 4;

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
