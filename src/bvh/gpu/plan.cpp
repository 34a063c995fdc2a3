// SPDX-License-Identifier: Apache-2.0
#include "bvh/gpu/plan.h"

#include "base/error.h"
#include "bvh/build_input.h"
#include "bvh/presplit.h"

#include <algorithm>
#include <new>

namespace sunstone::bvh::gpu {
namespace {

// Device code and host code agree on this.
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

void requireSupported(const BuildInputs& inputs, const BuildOptions& options) {
    if (!inputs.curves.empty() || !inputs.spheres.empty())
        fail(Code::kNotSupported, "curves and spheres on a GPU are not available yet");
    if (options.motion.keys > 1)
        fail(Code::kNotSupported, "motion keys on a GPU are not available yet");
    for (const TriangleInput& t : inputs.triangles)
        if (t.micromaps.indexing != MicromapIndexing::kNone)
            fail(Code::kNotSupported, "opacity micromaps on a GPU are not available yet");
}

DeviceInput describe(const TriangleInput& in) {
    DeviceInput d{};
    d.data = addressOf(in.vertices);
    d.indices = addressOf(in.indices);
    d.preTransform = addressOf(in.preTransform);
    d.vertexFormat = uint32_t(in.vertexFormat);
    d.indexFormat = uint32_t(in.indexFormat);
    d.stride = in.vertexStride ? in.vertexStride : vertexSize(in.vertexFormat);
    d.indexStride = in.indexStride                            ? in.indexStride
                    : in.indexFormat == IndexFormat::kUshort3 ? 6
                                                              : 12;
    // Without vertices or indices every triangle is inactive.
    const bool missing = !in.vertices || (in.indexFormat != IndexFormat::kNone && !in.indices);
    d.numVertices = missing ? 0 : in.numVertices;
    return d;
}

DeviceInput describe(const CustomInput& in) {
    DeviceInput d{};
    d.data = addressOf(in.aabbs);
    d.stride = in.stride ? in.stride : 24;
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

} // namespace

Plan::Plan(const BuildInputs& in, const BuildOptions& options) {
    requireSupported(in, options);
    const int kinds = !in.triangles.empty() + !in.customs.empty() + (in.instances != nullptr);
    if (kinds != 1)
        fail(Code::kInvalidValue, "a build takes triangles, custom primitives or instances: got ",
             kinds, " kinds");
    type = !in.triangles.empty() ? BlockType::kTriangles
           : !in.customs.empty() ? BlockType::kCustom
                                 : BlockType::kInstances;
    if (type != BlockType::kInstances)
        numInputs = uint32_t(std::max(in.triangles.size(), in.customs.size()));
    count(in);
    countReferences(options);
    layOutOutput(options);
    layOutTemp();
}

const SbtInput& Plan::sbtOf(const BuildInputs& in, uint32_t i) const {
    return type == BlockType::kTriangles ? in.triangles[i].sbt : in.customs[i].sbt;
}

uint32_t Plan::countOf(const BuildInputs& in, uint32_t i) const {
    return type == BlockType::kTriangles ? triangleCount(in.triangles[i])
           : type == BlockType::kCustom  ? in.customs[i].numPrimitives
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
    // References have 30 bits, and all ones mean none.
    if (total >= kMaxPrimitives)
        fail(Code::kInvalidValue, total, " primitives in one structure, the limit is ",
             kMaxPrimitives - 1);
    numPrimitives = uint32_t(total);
    numSbtRecords = uint32_t(sbtRecords);
}

void Plan::countReferences(const BuildOptions& options) {
    // Updates need one place for each primitive; parts of a triangle may move apart.
    uint64_t total = numPrimitives;
    if (type == BlockType::kTriangles && options.preferFastTrace && !options.allowUpdate)
        total += maxSplits(total);
    if (total >= kMaxPrimitives)
        total = kMaxPrimitives - 1;
    maxReferences = uint32_t(total);
    tiles = (maxReferences + kSortTile - 1) / kSortTile;
    // A node whose primitives do not fit into its slots has eight children. By induction there
    // are no more than (2 n - 1) / 7 nodes where an inner child has four primitives or more, (4
    // n - 1) / 7 where it has two or more.
    const uint64_t least = type == BlockType::kTriangles ? 2 : 4;
    maxWide = uint32_t(least * total / 7 + 1);
}

void Plan::layOutOutput(const BuildOptions& options) {
    uint64_t offset = sizeof(BlockHeader) + uint64_t(numInputs) * sizeof(InputRecord);
    if (type == BlockType::kTriangles && options.allowRandomVertexAccess) {
        table = alignUp(offset, 64);
        offset = table + uint64_t(numPrimitives) * sizeof(uint32_t);
    }
    if (type == BlockType::kInstances) {
        instances = alignUp(offset, 64);
        offset = instances + uint64_t(numPrimitives) * sizeof(InstanceData);
    }
    const uint64_t record = type == BlockType::kTriangles ? sizeof(TriangleRecord)
                            : type == BlockType::kCustom  ? sizeof(CustomLeaf)
                                                          : sizeof(uint32_t);
    records = alignUp(offset, 128);
    nodes = alignUp(records + maxReferences * record, 128);
    outputSize = alignUp(nodes + uint64_t(maxWide) * sizeof(WideNode), kBlockAlignment);
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
    inputs = place(numInputs * sizeof(DeviceInput) + numSbtRecords);
    flags = inputs + numInputs * sizeof(DeviceInput);
    counters = place(sizeof(Counters)); // and what is zeroed with them
    tileStates = place(uint64_t(kSortPasses) * tiles * kSortDigits * 4);
    parents = place(n * 4); // and what is set to ones with them
    tasks = place(uint64_t(maxWide) * 8);
    boxes = place(n * sizeof(PrimitiveBox));
    // What is read while records are written must not lie where they go.
    origins = {place((n - numPrimitives) * 4), false};
    values[1] = {place(n * 4), false};
    keys[0] = {place(n * 8), false};
    binary = placeAnywhere(n * sizeof(BinaryNode));
    keys[1] = placeAnywhere(n * 8);
    values[0] = placeAnywhere(n * 4);
    costs = keys[1];   // free after the sort
    order = values[1]; // and this after the tree
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
    inputs = place(plan.numInputs * sizeof(DeviceInput) + plan.numSbtRecords);
    flags = inputs + plan.numInputs * sizeof(DeviceInput);
    counters = place(kUpdateCounters); // and what is zeroed with them
    arrivals = place(nodes * 4);
    expected = place(sizeof(BlockHeader) + plan.numInputs * sizeof(InputRecord));
    parents = place(nodes * 4);
    nodeBoxes = place(nodes * sizeof(PrimitiveBox));
    if (plan.type == BlockType::kInstances) // their records do not tell their boxes
        boxes = place(uint64_t(plan.numPrimitives) * sizeof(PrimitiveBox));
    tempSize = offset;
}

static void startHeader(BlockHeader& header, const BuildOptions& options, const Plan& plan) {
    header.version = kBlockVersion; // the magic number comes last, on the device
    header.type = plan.type;
    header.root = header.wholeRoot = kNoNode;
    header.numPrimitives = plan.numPrimitives;
    header.numInputs = plan.numInputs;
    header.geometryFlagsAnd = ~0u;
    header.inputsOffset = sizeof(BlockHeader);
    header.tableOffset = plan.table;
    header.instancesOffset = plan.instances;
    header.recordsOffset = plan.records;
    header.nodesOffset = plan.nodes;
    header.options = optionBits(options);
    header.motionKeys = 1;
}

Uploads::Uploads(const BuildInputs& in, const BuildOptions& options, const Plan& plan,
                 uint64_t flagsBase)
    : output(sizeof(BlockHeader) + plan.numInputs * sizeof(InputRecord)),
      temp(plan.numInputs * sizeof(DeviceInput) + plan.numSbtRecords) {
    auto& header = *new (output.data()) BlockHeader{};
    auto* const records = reinterpret_cast<InputRecord*>(output.data() + sizeof(BlockHeader));
    auto* const inputs = reinterpret_cast<DeviceInput*>(temp.data());
    uint8_t* flags = temp.data() + plan.numInputs * sizeof(DeviceInput);
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
        const bool triangles = plan.type == BlockType::kTriangles;
        const SbtInput& sbt = plan.sbtOf(in, i);
        inputs[i] = triangles ? describe(in.triangles[i]) : describe(in.customs[i]);
        inputs[i].sbtOffsets = addressOf(sbt.indexOffsets);
        inputs[i].sbtOffsetSize = sbt.indexOffsetSize;
        inputs[i].sbtOffsetStride =
            sbt.indexOffsetStride ? sbt.indexOffsetStride : sbt.indexOffsetSize;
        inputs[i].flags = flagsBase + firstSbt;
        for (uint32_t k = 0; k < sbt.numSbtRecords; ++k) {
            const uint32_t word = sbt.flags ? sbt.flags[k] : 0;
            flags[firstSbt + k] = uint8_t(word);
            header.geometryFlagsAnd &= word;
        }
        records[i] = makeInputRecord(sbt, firstSbt, firstPrimitive, count,
                                     triangles ? &in.triangles[i] : nullptr);
        firstSbt += sbt.numSbtRecords;
        firstPrimitive += count;
    }
    header.numSbtRecords = firstSbt;
}

} // namespace sunstone::bvh::gpu
