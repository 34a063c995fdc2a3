// SPDX-License-Identifier: Apache-2.0
#include "bvh/gpu/build/plan.h"

#include "base/error.h"
#include "bvh/build/presplit.h"
#include "bvh/gpu/build/shared_records.h"
#include "bvh/input/build_input.h"
#include "bvh/micromap/micromap_binding.h"
#include "bvh/shapes/shape_geometry.h"
#include "bvh/shapes/shape_input.h"

#include <algorithm>
#include <new>
#include <span>

namespace sunstone::bvh::gpu {
namespace {

// Host and device code rely on these sizes.
static_assert(sizeof(BuildJob) < 4096 && sizeof(Counters) % 16 == 0);

uint32_t vertexSize(VertexFormat format) {
    switch (format) {
    case VertexFormat::kFloat3:
        return 12;
    case VertexFormat::kFloat2:
        return 8;
    case VertexFormat::kHalf3:
    case VertexFormat::kSnorm16x3:
        return 6;
    default:
        return 4;
    }
}

// Stores the addresses of an input's data at the keys. Returns the first address if all are given,
// else 0.
uint64_t addKeys(const void* const* data, std::span<uint64_t> to) {
    bool complete = data != nullptr;
    for (size_t k = 0; k < to.size(); ++k) {
        to[k] = data ? addressOf(data[k]) : 0;
        complete = complete && to[k] != 0;
    }
    return complete ? to[0] : 0;
}

// Adds the keys of curves and spheres: positions, then radii.
void addKeys(DeviceInput& d, const void* const* data, const void* const* radii,
             std::span<uint64_t> to) {
    if (to.empty())
        return;
    d.data = addKeys(data, to.first(to.size() / 2));
    d.radii = addKeys(radii, to.last(to.size() / 2));
}

// The number of addresses of an input's data at the keys; 0 without motion.
uint64_t numKeyAddresses(const Plan& plan) {
    if (plan.motion.keys == 1 || plan.type == BlockType::kInstances)
        return 0;
    return uint64_t(plan.motion.keys) * (plan.type == BlockType::kShapes ? 2 : 1);
}

DeviceInput describe(const TriangleInput& in, std::span<uint64_t> keys) {
    DeviceInput d{};
    d.data = addressOf(in.vertices);
    if (!keys.empty())
        d.data = addKeys(in.keyVertices, keys);
    d.indices = addressOf(in.indices);
    d.preTransform = addressOf(in.preTransform);
    d.vertexFormat = uint32_t(in.vertexFormat);
    d.indexFormat = uint32_t(in.indexFormat);
    d.stride = in.vertexStride ? in.vertexStride : vertexSize(in.vertexFormat);
    d.indexStride = in.indexStride                            ? in.indexStride
                    : in.indexFormat == IndexFormat::kUshort3 ? 6
                                                              : 12;
    // Without vertices or indices every triangle is inactive.
    const bool missing = !d.data || (in.indexFormat != IndexFormat::kNone && !in.indices);
    d.numVertices = missing ? 0 : in.numVertices;
    const MicromapInput& m = in.micromaps;
    d.micromapIndexing = uint32_t(m.indexing);
    d.micromaps = addressOf(m.array);
    d.micromapIndices = addressOf(m.indices);
    d.micromapIndexSize = m.indexSize;
    d.micromapIndexStride = m.indexStride ? m.indexStride : m.indexSize;
    d.micromapIndexOffset = m.indexOffset;
    return d;
}

DeviceInput describe(const CustomInput& in, std::span<uint64_t> keys) {
    DeviceInput d{};
    d.data = addressOf(in.aabbs);
    if (!keys.empty())
        d.data = addKeys(in.keyAabbs, keys);
    d.stride = in.stride ? in.stride : 24;
    return d;
}

DeviceInput describe(const CurveInput& in, std::span<uint64_t> keys) {
    DeviceInput d{};
    d.data = addressOf(in.vertices);
    d.stride = in.vertexStride ? in.vertexStride : 12;
    d.numVertices = in.numVertices;
    d.radii = addressOf(in.radii);
    d.radiusStride = in.radiusStride ? in.radiusStride : 4;
    d.indices = addressOf(in.indices);
    d.indexStride = in.indexStride ? in.indexStride : 4;
    d.caps = in.caps;
    addKeys(d, in.keyVertices, in.keyRadii, keys);
    return d;
}

DeviceInput describe(const SphereInput& in, std::span<uint64_t> keys) {
    DeviceInput d{};
    d.data = addressOf(in.centres);
    d.stride = in.centreStride ? in.centreStride : 12;
    d.radii = addressOf(in.radii);
    d.radiusStride = in.oneRadius ? 0 : in.radiusStride ? in.radiusStride : 4;
    addKeys(d, in.keyCentres, in.keyRadii, keys);
    return d;
}

DeviceInput describe(const InstanceInput& in) {
    DeviceInput d{};
    d.areAddresses = in.instances == nullptr;
    d.data = addressOf(in.instances ? in.instances : static_cast<const void*>(in.instancePointers));
    d.stride = in.stride ? in.stride : uint32_t(sizeof(InstanceDesc));
    d.knownFlags = in.knownFlags;
    d.identityFlag = in.identityFlag;
    return d;
}

// The most references that splitting may add within 100 bytes of scratch per triangle. A reference
// takes 41 bytes, a part of a triangle 4 more, and small structures have a fixed minimum. Kernels
// choose the actual number (presplit.h). The result never decreases with the number of triangles.
uint64_t splitBudget(uint64_t triangles) {
    constexpr uint64_t kSmall = 220;
    const uint64_t most = maxSplits(triangles);
    return most > kSmall ? (most - kSmall) * 6 / 5 : 0;
}

} // namespace

Plan::Plan(const BuildInputs& in, const BuildOptions& options) {
    const int kinds =
        !in.triangles.empty() + !in.customs.empty() + hasShapes(in) + (in.instances != nullptr);
    if (kinds != 1)
        fail(Code::kInvalidValue,
             "a build takes triangles, custom primitives, curves, spheres or instances: got ",
             kinds, " kinds");
    type = !in.triangles.empty() ? BlockType::kTriangles
           : !in.customs.empty() ? BlockType::kCustom
           : hasShapes(in)       ? BlockType::kShapes
                                 : BlockType::kInstances;
    if (type == BlockType::kShapes) {
        requireOneShape(in);
        numInputs = numShapeInputs(in);
        shape = shapeOf(in);
        // With updates a segment has one piece, because updated pieces could overlap.
        pieces = options.allowUpdate ? 1 : maxPieces(shape, options);
    } else if (type != BlockType::kInstances) {
        numInputs = uint32_t(std::max(in.triangles.size(), in.customs.size()));
    }
    if (options.motion.keys > 1)
        motion = options.motion;
    count(in);
    micromapTable = micromapTableSize(in.triangles);
    countReferences(options);
    layOutOutput(options);
    layOutTemp();
}

const SbtInput& Plan::sbtOf(const BuildInputs& in, uint32_t i) const {
    return type == BlockType::kTriangles ? in.triangles[i].sbt
           : type == BlockType::kCustom  ? in.customs[i].sbt
                                         : shapeSbt(in, i);
}

uint32_t Plan::countOf(const BuildInputs& in, uint32_t i) const {
    return type == BlockType::kTriangles ? triangleCount(in.triangles[i])
           : type == BlockType::kCustom  ? in.customs[i].numPrimitives
           : type == BlockType::kShapes  ? shapeCount(in, i)
                                         : in.instances->numInstances;
}

void Plan::count(const BuildInputs& in) {
    uint64_t total = 0, sbtRecords = 0;
    for (uint32_t i = 0; i < numInputs; ++i) {
        total += countOf(in, i);
        if (type == BlockType::kInstances)
            continue;
        if (sbtOf(in, i).numSbtRecords == 0)
            fail(Code::kInvalidValue, "build input ", i, " has no SBT record");
        sbtRecords += sbtOf(in, i).numSbtRecords;
    }
    if (sbtRecords > kSbtIndexMask + 1u)
        fail(Code::kInvalidValue, sbtRecords, " SBT records in one structure, the limit is ",
             kSbtIndexMask + 1u);
    if (isCurveBasis(shape) && total >= kMaxCurveSegments)
        fail(Code::kInvalidValue, total, " segments in one structure, the limit is ",
             kMaxCurveSegments - 1);
    // References have 30 bits, and all ones means none.
    if (total >= kMaxPrimitives)
        fail(Code::kInvalidValue, total, " primitives in one structure, the limit is ",
             kMaxPrimitives - 1);
    numPrimitives = uint32_t(total);
    numSbtRecords = uint32_t(sbtRecords);
}

void Plan::countReferences(const BuildOptions& options) {
    // Updates and motion need one place for each primitive, because the parts of a triangle could
    // move apart.
    uint64_t total = numPrimitives;
    if (type == BlockType::kTriangles && options.preferFastTrace && !options.allowUpdate &&
        motion.keys == 1)
        total += splitBudget(total);
    if (total * pieces >= kMaxPrimitives)
        pieces = 1;
    total *= pieces;
    if (total >= kMaxPrimitives)
        total = kMaxPrimitives - 1;
    maxReferences = uint32_t(total);
    tiles = (maxReferences + kSortTile - 1) / kSortTile;
    // A node whose primitives do not fit into its slots has eight children. By induction there are
    // at most (2 n - 1) / 7 nodes if an inner child has at least four primitives, and (4 n - 1) / 7
    // if it has at least two.
    const uint64_t least = type == BlockType::kTriangles ? 2 : 4;
    maxWide = uint32_t(least * total / 7 + 1);
}

void Plan::layOutOutput(const BuildOptions& options) {
    uint64_t offset = sizeof(BlockHeader) + uint64_t(numInputs) * sizeof(InputRecord);
    size_t numGaps = 0;
    const auto place = [&](uint64_t bytes, uint64_t alignment) {
        const uint64_t at = alignUp(offset, alignment);
        if (at != offset)
            gaps[numGaps++] = {offset, at - offset};
        offset = at + bytes;
        return at;
    };
    if (type == BlockType::kTriangles && options.allowRandomVertexAccess)
        table = place(uint64_t(numPrimitives) * sizeof(uint32_t), 64);
    if (micromapTable)
        micromaps = place(micromapTable, 64);
    if (type == BlockType::kInstances)
        instances = place(uint64_t(numPrimitives) * sizeof(InstanceRecord), 64);
    // Rays are tested against the control points of all curves but linear ones.
    const bool tested = isCurveBasis(shape) && CurveBasis(shape) != CurveBasis::kLinear;
    if (tested || (type == BlockType::kShapes && options.allowRandomVertexAccess)) {
        const uint64_t floats = uint64_t(motion.keys) * shapeFloats(shape);
        points = place(numPrimitives * floats * sizeof(float), 64);
    }
    if (motion.keys > 1)
        keyBounds = place(motion.keys * sizeof(KeyBounds), 64);
    const uint64_t record = recordSize(type, shape, motion.keys);
    uint64_t bytes = maxReferences * record;
    if (maySplit()) // few parts more, which share triangles
        bytes = std::max(bytes, numPrimitives * record + 128 + sharedNumbers(maxReferences));
    records = place(bytes, 128);
    // With this margin, data that fits among the records of n primitives also fits among the
    // records of more primitives, so that more primitives never need less scratch.
    constexpr uint64_t kRounding = 512;
    nodes = alignUp(offset + kRounding, 128);
    outputSize = alignUp(nodes + maxWide * nodeSize(motion.keys), kBlockAlignment);
}

// Records are written last; until then, their part of the output is scratch.
void Plan::layOutTemp() {
    uint64_t offset = 0, spare = records;
    const auto place = [&](uint64_t bytes) {
        const uint64_t at = offset;
        offset = alignUp(offset + bytes, 128);
        return at;
    };
    const auto placeAnywhere = [&](uint64_t bytes) {
        if (spare + bytes > nodes)
            return Place{place(bytes), false};
        const uint64_t at = spare;
        spare = alignUp(spare + bytes, 128);
        return Place{at, true};
    };
    const uint64_t n = maxReferences;
    const bool moves = motion.keys > 1;
    keyData = numInputs * sizeof(DeviceInput);
    flags = keyData;
    flags += numInputs * numKeyAddresses(*this) * sizeof(uint64_t);
    uploadSize = flags + numSbtRecords;
    inputs = place(uploadSize);
    counters = place(sizeof(Counters)); // and what is zeroed with them
    tileStates = place(uint64_t(kSortPasses) * tiles * kSortDigits * 4);
    keyWords = place(moves ? uint64_t(motion.keys) * sizeof(KeyBounds) : 0);
    arrivals = place(moves ? uint64_t(maxWide) * 4 : 0);
    tasks = place(uint64_t(maxWide) * 8); // and other data set to ones
    if (!maySplit())
        parents = {place(n * 4), false};
    // Data read while records are written must not overlap them.
    origins = {place((isCurveBasis(shape) ? n : n - numPrimitives) * 4), false};
    values[1] = {place(n * 4), false};
    boxes = place(n * sizeof(PrimitiveBox));
    keys[0] = {place(n * 8), false};
    binary = placeAnywhere(n * sizeof(BinaryNode));
    keys[1] = placeAnywhere(n * 8);
    values[0] = placeAnywhere(n * 4);
    if (maySplit())
        parents = placeAnywhere(n * 4); // set to ones separately, if not beside the tasks
    savings = keys[1];                  // free after the sort
    order = values[1];                  // and this after the tree
    // Memory that is free when the tree is collapsed: sums of the sort, the clusters' wait words or
    // the keys, and everything from the boxes on, which suffices for triangles.
    static_assert(kSortPasses * kSortDigits >= kSortTile * 4 / 7 + 2); // words of a tile
    links = tileStates;
    newOrder = (maySplit() ? keys[0] : parents).offset;
    newNodes = boxes;
    offset = std::max(offset, alignUp(newNodes + maxWide * sizeof(WideNode), 128));
    if (moves) {
        nodeBoxes = place(maxWide * uint64_t(motion.keys) * sizeof(PrimitiveBox));
        if (type == BlockType::kInstances)
            keyBoxes = place(2 * numPrimitives * uint64_t(motion.keys) * sizeof(KeyBounds));
    }
    tempSize = offset;
}

UpdatePlan::UpdatePlan(const Plan& plan) {
    uint64_t offset = 0;
    const auto place = [&](uint64_t bytes) {
        const uint64_t at = offset;
        offset = alignUp(offset + bytes, 128);
        return at;
    };
    const uint64_t nodes = plan.maxWide;
    const uint64_t keys = plan.motion.keys;
    inputs = place(plan.uploadSize);
    counters = place(kUpdateCounters); // and what is zeroed with them
    arrivals = place(nodes * 4);
    keyWords = place(keys > 1 ? keys * sizeof(KeyBounds) : 0);
    expected = place(sizeof(BlockHeader) + plan.numInputs * sizeof(InputRecord));
    parents = place(nodes * 4);
    nodeBoxes = place(nodes * keys * sizeof(PrimitiveBox));
    if (keys > 1 && plan.type == BlockType::kInstances)
        keyBoxes = place(2 * plan.numPrimitives * keys * sizeof(KeyBounds));
    if (plan.type == BlockType::kInstances) // their records do not determine their boxes
        boxes = place(uint64_t(plan.numPrimitives) * sizeof(PrimitiveBox));
    else if (keys == 1 && plan.type == BlockType::kShapes) // nor do those of curves
        boxes = place(uint64_t(plan.maxReferences) * sizeof(PrimitiveBox));
    tempSize = offset;
}

static void startHeader(BlockHeader& header, const BuildOptions& options, const Plan& plan) {
    header.version = kBlockVersion; // the magic number comes last, on the device
    header.type = plan.motion.keys > 1 ? withMotion(plan.type) : plan.type;
    header.root = header.wholeRoot = kNoNode;
    header.numPrimitives = plan.numPrimitives;
    header.numInputs = plan.numInputs;
    header.geometryFlagsAnd = ~0u;
    header.inputsOffset = sizeof(BlockHeader);
    header.tableOffset = plan.table;
    header.micromapsOffset = plan.micromaps;
    header.instancesOffset = plan.instances;
    header.recordsOffset = plan.records;
    header.pointsOffset = plan.points;
    header.shape = uint16_t(plan.shape);
    header.nodesOffset = plan.nodes;
    header.options = optionBits(options);
    header.motionKeys = plan.motion.keys;
    header.motionFlags = plan.motion.flags;
    header.motionBegin = plan.motion.begin;
    header.motionEnd = plan.motion.end;
    header.keyBoundsOffset = plan.keyBounds;
}

Uploads::Uploads(const BuildInputs& in, const BuildOptions& options, const Plan& plan,
                 uint64_t base)
    : output(sizeof(BlockHeader) + plan.numInputs * sizeof(InputRecord)), temp(plan.uploadSize) {
    auto& header = *new (output.data()) BlockHeader{};
    auto* const records = reinterpret_cast<InputRecord*>(output.data() + sizeof(BlockHeader));
    auto* const inputs = reinterpret_cast<DeviceInput*>(temp.data());
    auto* const keyData = reinterpret_cast<uint64_t*>(temp.data() + plan.keyData);
    uint8_t* const flags = temp.data() + plan.flags;
    const uint32_t keys = plan.motion.keys;
    startHeader(header, options, plan);
    uint32_t firstPrimitive = 0, firstSbt = 0;
    for (uint32_t i = 0; i < plan.numInputs; ++i) {
        const uint32_t count = plan.countOf(in, i);
        if (plan.type == BlockType::kInstances) {
            inputs[i] = describe(*in.instances);
            records[i].numPrimitives = count;
            header.geometryFlagsAnd = 0;
            break;
        }
        const SbtInput& sbt = plan.sbtOf(in, i);
        const uint64_t first = i * numKeyAddresses(plan);
        const std::span<uint64_t> addresses = {keyData + first, numKeyAddresses(plan)};
        inputs[i] = plan.type == BlockType::kTriangles ? describe(in.triangles[i], addresses)
                    : plan.type == BlockType::kCustom  ? describe(in.customs[i], addresses)
                    : isCurveBasis(plan.shape)         ? describe(in.curves[i], addresses)
                                                       : describe(in.spheres[i], addresses);
        inputs[i].mayChangeMicromaps = options.allowMicromapUpdate;
        if (keys > 1 && inputs[i].data)
            inputs[i].keyData = base + plan.keyData + first * sizeof(uint64_t);
        if (keys > 1 && inputs[i].radii)
            inputs[i].keyRadii = base + plan.keyData + (first + keys) * sizeof(uint64_t);
        inputs[i].sbtOffsets = addressOf(sbt.indexOffsets);
        inputs[i].sbtOffsetSize = sbt.indexOffsetSize;
        inputs[i].sbtOffsetStride =
            sbt.indexOffsetStride ? sbt.indexOffsetStride : sbt.indexOffsetSize;
        inputs[i].flags = base + plan.flags + firstSbt;
        for (uint32_t k = 0; k < sbt.numSbtRecords; ++k) {
            const uint32_t word = sbt.flags ? sbt.flags[k] : 0;
            flags[firstSbt + k] = uint8_t(word);
            header.geometryFlagsAnd &= word;
        }
        const bool triangles = plan.type == BlockType::kTriangles;
        records[i] = plan.type == BlockType::kShapes
                         ? shapeInputRecord(in, i, firstSbt, firstPrimitive)
                         : makeInputRecord(sbt, firstSbt, firstPrimitive, count,
                                           triangles ? &in.triangles[i] : nullptr);
        firstSbt += sbt.numSbtRecords;
        firstPrimitive += count;
    }
    header.numSbtRecords = firstSbt;
    if (!plan.micromaps)
        return;
    uint64_t refs = plan.micromaps + plan.numInputs * sizeof(MicromapRecord);
    for (const TriangleInput& input : in.triangles) {
        MicromapRecord record{};
        record.indexing = uint32_t(input.micromaps.indexing);
        if (input.micromaps.indexing != MicromapIndexing::kNone) {
            record.array = addressOf(input.micromaps.array);
            record.refsOffset = refs;
            refs += uint64_t(triangleCount(input)) * sizeof(MicromapRef);
        }
        micromaps.push_back(record);
    }
}

} // namespace sunstone::bvh::gpu
