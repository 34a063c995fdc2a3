// SPDX-License-Identifier: Apache-2.0
// The argument of all builder kernels. A job has places in the caller's temp and output buffers,
// all known on the host before the build. Counts that depend on data are in Counters, on the
// device.
#pragma once

#include "bvh/gpu/layout.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kSortThreads = 256;
constexpr uint32_t kSortItems = 8;
constexpr uint32_t kSortTile = kSortThreads * kSortItems;
constexpr uint32_t kSortDigits = 256;
constexpr uint32_t kSortPasses = 6;

// Limits of builds by one block (small.h), and its threads: above so many references, many blocks
// are faster (docs/notes/builders-gpu.md has figures). Clustering takes one block longer than the
// radix tree, so its limit is lower; the limit of nodes is an estimate.
constexpr uint32_t kSmallMost = 2048, kSmallMostClustered = 1024, kSmallMostNodes = 640;
constexpr uint32_t kSmallThreads = 512;
// The shared memory that all of a job's scratch takes.
constexpr uint64_t smallTreeBytes(uint64_t references, uint64_t nodes) {
    constexpr uint64_t kArrays = 9, kReference = 84, kNode = 12, kRounding = 15;
    return references * kReference + nodes * kNode + kArrays * kRounding;
}

// Bits of a Morton code for each axis.
constexpr uint32_t kAxisBits = 16;

// A reference in the binary tree: the number of primitives below (1 to 3; 0: more) and the number
// of the primitive, if there is one, or of the node.
constexpr uint32_t kRefCountShift = 30;
constexpr uint32_t kRefIndexMask = (1u << kRefCountShift) - 1;
constexpr uint32_t kNoRef = ~0u;

struct BinaryNode {
    float lower[3];
    uint32_t left;
    float upper[3];
    uint32_t right;
};
static_assert(sizeof(BinaryNode) == 32);

struct PrimitiveBox {
    float lower[3], upper[3];
};

// One build input as kernels see it; addresses are of the device.
struct DeviceInput {
    uint64_t data; // vertices, boxes, InstanceDesc or their addresses
    uint64_t indices;
    uint64_t preTransform; // 12 floats, or 0
    uint64_t sbtOffsets;
    uint64_t flags;   // of geometry, one byte for each SBT record
    uint64_t keyData; // with motion: addresses of the data at each key; `data` is that of the first
    uint64_t keyRadii; // the same of `radii`
    uint32_t vertexFormat, indexFormat;
    uint32_t stride, indexStride;
    uint32_t numVertices;
    uint32_t sbtOffsetSize, sbtOffsetStride;
    uint32_t knownFlags, identityFlag; // of instances
    uint32_t areAddresses;             // data: addresses of instances
    uint32_t radiusStride;             // of curves and spheres; 0: one radius for all
    uint64_t radii;
    uint32_t caps; // flat discs at the ends of strands
    // Opacity micromaps as in MicromapInput: the array, and indices for each triangle.
    uint32_t micromapIndexing;
    uint64_t micromaps, micromapIndices;
    uint32_t micromapIndexSize, micromapIndexStride, micromapIndexOffset;
    uint32_t mayChangeMicromaps; // an update
};

// Bins of the priorities by which triangles are split: exponent and three bits of mantissa.
constexpr uint32_t kSplitBins = 2048;
// The number of factors tried for the number of splits.
constexpr uint32_t kSplitFactors = 33;

// Failures that kernels report to the host in a BuildReport, in this order: an internal error (the
// structure has no magic number); an update of a structure built from inputs of another shape; a
// relocation of memory that is not a copy (the memory stays unchanged, as do micromaps whose new
// array is not a copy of theirs); invalid opacity micromaps (no structure or array is made);
// invalid children of instances.
enum BuildFailure : uint32_t {
    kNoFailure,
    kTreeBroken,
    kNotThatStructure,
    kNoCopy,
    kNoChild,
    kNoMicromapArray,
    kMicromapsDoNotFit,
    kNoMicromapCopy,
    kNotCompacted,
    kUnknownChild,
};

// The argument of sunstone_relocate: addresses, and the header fields that a copy must have.
struct RelocateJob {
    uint64_t block, report;
    uint64_t children; // handles for the instances
    uint64_t known;    // valid handles, see known_handles.h
    uint64_t usedSize;
    uint32_t numChildren; // 0: they keep theirs
    uint32_t version;
    uint32_t numPrimitives;
    BlockType type;
};

// A ring of failures in host memory that kernels write.
struct BuildReport {
    struct Entry {
        uint64_t block;
        uint32_t failure;
        uint32_t number; // counted from 1; written last
    };
    static constexpr uint32_t kEntries = 16;
    uint32_t count;
    uint32_t pad[3];
    Entry entries[kEntries];
};

// Zeroed before the build.
struct Counters {
    uint32_t numActive;
    uint32_t nextNode;          // binary nodes given out
    uint32_t lower[3];          // of the active primitives: maxima of ~orderedBits
    uint32_t upper[3];          // maxima of orderedBits
    uint64_t allocated;         // wide nodes given out, and above 32 bits primitive records
    uint32_t nextTask;          // taken wide nodes
    uint32_t depth;             // of the wide tree
    uint32_t root;              // reference plus 1
    uint32_t tooDeep;           // the clustered tree is too deep; a second tree replaces it
    uint32_t finished;          // wide nodes written
    uint32_t failure;           // BuildFailure
    uint32_t numReferences;     // primitives, and further parts of those that were split
    uint32_t numTreeReferences; // the part of them that the tree holds
    float splitFactor;
    uint32_t leftInstances;   // some are left to the motion kernel (instances.h)
    uint32_t unknownChildren; // one has been reported to the host
    uint32_t sharesRecords;   // leaves share triangles, see shared_records.h
    uint32_t pad3[2];
    // Updates do not use the following members.
    uint32_t sortTickets[kSortPasses];
    uint32_t retryTurns[2][2]; // parts of each step of sunstone_retry: taken up, done
    uint32_t pad2[2];
    unsigned long long boxAreas, splitAreas; // of all triangles, and the part to be split
    unsigned long long splitBudget;
    unsigned long long splitTotals[kSplitFactors]; // splits by factors that grow
    union {
        uint32_t histograms[kSortPasses][kSortDigits];
        uint32_t splitBins[kSplitBins]; // before: how many triangles have a priority
    };
};
constexpr uint64_t kUpdateCounters = __builtin_offsetof(Counters, sortTickets);

// The kind of binary tree and the rule by which its nodes are opened. PREFER_FAST_BUILD uses the
// radix tree of the Morton codes unchanged and opens the largest nodes. With hostile input both
// kinds may be too deep for traversal. Only then sunstone_retry makes the radix tree (48 bits of
// code and 30 of the place) and opens it level by level: a level of wide nodes takes at least three
// of its levels, so the depth is at most 26.
enum TreeMode : uint32_t { kClustered, kRadix, kRadixByLevel };

// Bytes between parts of the output, which are aligned to 128 or less.
struct Gap {
    uint64_t offset, size;
};
constexpr uint32_t kMaxGaps = 6;

struct BuildJob {
    uint64_t report; // BuildReport
    uint64_t known;  // the valid handles, see known_handles.h
    uint64_t output, compacted;
    uint64_t inputRecords, table, instances, records, nodes; // in the output; table: or 0
    uint64_t inputs;                                         // DeviceInput[]
    uint64_t counters;
    uint64_t boxes; // PrimitiveBox of each reference
    // The primitive of each further reference, after those of whole primitives; for curves the
    // piece of each reference.
    uint64_t origins;
    uint64_t keys[2]; // 64 bits each
    uint64_t values[2];
    uint64_t tileStates; // of the sort
    uint64_t binary;     // BinaryNode[]
    uint64_t savings;    // of each binary node, see costs.h
    uint64_t parents;    // one word for each reference, ~0; of updates: of each wide node
    uint64_t tasks;      // for each wide node its reference, and above 32 bits its depth; ~0
    uint64_t order;      // reference of each primitive record
    // For arrange.h: each wide node's parent; then the nodes, at the first key, and `order`, both
    // in places that depend only on the tree.
    uint64_t links, newNodes, newOrder;
    // For updates: the required header and input records, and their bytes.
    uint64_t expected, outputSize;
    uint64_t nodeBoxes; // PrimitiveBox of each wide node, with motion at each key
    uint64_t arrivals;  // children of each wide node that are done
    uint32_t numInputs, numPrimitives, maxReferences, maxWide;
    BlockType type;
    uint32_t keepInactive; // inactive primitives are in the tree, as an update may change that
    float primitiveCost;   // cost of a test, relative to a step into a node
    // Curves and spheres. A segment has up to `pieces` references: one for the whole segment and
    // further ones, which follow those of all segments.
    uint64_t points; // in the output, or 0
    uint32_t shape, pieces;
    Gap gaps[kMaxGaps]; // of the output
    // With motion (motionKeys > 1).
    uint32_t motionKeys = 1;
    float motionBegin, motionEnd;
    uint64_t keyBoxes;  // KeyBounds of each instance at each key; behind them those for nodes
    uint64_t keyWords;  // bounds at each key, see sunstone_key_bounds
    uint64_t keyBounds; // KeyBounds of each key, in the output
};

// The argument of sunstone_begin.
struct BeginJob {
    struct Part {
        uint64_t to, words;
    };
    struct Fill {
        uint64_t to, words;
        uint32_t word;
    };
    static constexpr uint32_t kMostWords = 960;
    Part parts[2];
    Fill fills[4];
    uint32_t words[kMostWords]; // of the parts, one after the other
};
static_assert(sizeof(BeginJob) <= 4096); // a kernel's arguments

// An array of opacity micromaps: the places of its parts (MicromapArrayLayout) and its input.
constexpr uint32_t kMicromapLevels = 13;
struct MicromapJob {
    uint64_t report; // BuildReport
    uint64_t output;
    uint64_t states, statesSize; // as far as there is memory
    uint64_t descriptions;       // MicromapDesc
    uint64_t refsOffset, dataOffset, usedSize;
    uint32_t descriptionStride, numMicromaps;
    uint32_t counts[2 * kMicromapLevels]; // of the histogram, by level; four-state ones behind
};

} // namespace sunstone::bvh::gpu
