// SPDX-License-Identifier: Apache-2.0
// Puts a build together: sizes, references, tree, block.
#include "bvh/build.h"

#include "base/error.h"
#include "base/threads.h"
#include "bvh/build_input.h"
#include "bvh/emit.h"
#include "bvh/layout.h"
#include "bvh/parallel.h"
#include "math/affine.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace sunstone::bvh {
namespace {

constexpr uint32_t kMaxPrimitives = 1u << 30;
constexpr size_t kReferenceBlock = 1u << 14;

uint64_t alignUp(uint64_t value, uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

LeafRules rulesOf(BlockType type) {
    LeafRules rules;
    switch (type) {
    case BlockType::kTriangles:
        rules.minCount = 2;
        rules.maxCount = 8;
        rules.bytes4 = sizeof(TriangleLeaf<4>);
        rules.bytes8 = sizeof(TriangleLeaf<8>);
        break;
    case BlockType::kCustom:
        rules.minCount = rules.maxCount = 1;
        rules.bytes4 = rules.bytes8 = sizeof(CustomLeaf);
        break;
    case BlockType::kInstances:
        rules.minCount = rules.maxCount = 1;
        rules.bytes4 = rules.bytes8 = 0;
        break;
    }
    return rules;
}

// What counts and options say about a build.
struct Plan {
    BlockType type;
    LeafRules rules;
    uint32_t numInputs = 1;
    uint32_t numPrimitives = 0;
    uint64_t inputsOffset, tableOffset = 0, instancesOffset = 0, nodesOffset;
    uint64_t outputSize, referencesSize, treeOffset, tempSize;

    uint32_t countOf(const BuildInputs& inputs, uint32_t i) const {
        switch (type) {
        case BlockType::kTriangles:
            return triangleCount(inputs.triangles[i]);
        case BlockType::kCustom:
            return inputs.customs[i].numPrimitives;
        default:
            return inputs.instances->numInstances;
        }
    }

    Plan(const BuildInputs& inputs, const BuildOptions& options) {
        const int kinds = !inputs.triangles.empty() + !inputs.customs.empty() +
                          (inputs.instances != nullptr);
        if (kinds != 1)
            fail(Code::kInvalidValue,
                 "a build takes triangles, custom primitives or instances: got ", kinds, " kinds");
        type = !inputs.triangles.empty() ? BlockType::kTriangles
               : !inputs.customs.empty() ? BlockType::kCustom
                                         : BlockType::kInstances;
        rules = rulesOf(type);
        if (type != BlockType::kInstances)
            numInputs = uint32_t(std::max(inputs.triangles.size(), inputs.customs.size()));
        uint64_t total = 0;
        for (uint32_t i = 0; i < numInputs; ++i)
            total += countOf(inputs, i);
        if (total > kMaxPrimitives)
            fail(Code::kInvalidValue, total, " primitives in one structure, the limit is ",
                 kMaxPrimitives);
        numPrimitives = uint32_t(total);
        layOut(options);
    }

    void layOut(const BuildOptions& options) {
        inputsOffset = sizeof(BlockHeader);
        uint64_t offset = inputsOffset + uint64_t(numInputs) * sizeof(InputRecord);
        if (type == BlockType::kTriangles && options.allowRandomVertexAccess) {
            tableOffset = alignUp(offset, 64);
            offset = tableOffset + uint64_t(numPrimitives) * sizeof(uint32_t);
        }
        if (type == BlockType::kInstances) {
            instancesOffset = alignUp(offset, 64);
            offset = instancesOffset + uint64_t(numPrimitives) * sizeof(InstanceData);
        }
        nodesOffset = alignUp(offset, kNodesAlignment);
        outputSize = alignUp(nodesOffset + maxTreeBytes(numPrimitives, rules), kBlockAlignment);
        if (outputSize > kMaxBlockSize || (tableOffset && outputSize > kMaxBlockSize / 2))
            fail(Code::kInvalidValue, numPrimitives, " primitives need up to ", outputSize,
                 " bytes, a structure can have ", kMaxBlockSize / (tableOffset ? 2 : 1));
        referencesSize = uint64_t(numPrimitives) * sizeof(PrimitiveRef);
        treeOffset = alignUp((options.preferFastBuild ? 3 : 2) * referencesSize, 64);
        tempSize = alignUp(treeOffset + uint64_t(maxTreeNodes(numPrimitives, rules)) *
                                            sizeof(TreeNode),
                           kBlockAlignment);
    }
};

class TriangleWriter final : public LeafWriter {
public:
    TriangleWriter(const std::vector<TriangleReader>& readers, const std::vector<SbtReader>& sbt,
                   const InputRecord* inputs, uint32_t* table)
        : readers_(readers), sbt_(sbt), inputs_(inputs), table_(table) {}

    NodeRef write(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                  uint32_t count) const override {
        if (count <= 4) {
            fillLeaf<4>(block, offset, references, count);
            return makeRef(offset, kLeaf);
        }
        fillLeaf<8>(block, offset, references, count);
        return makeRef(offset, kWideLeaf);
    }

private:
    template <unsigned N>
    void fillLeaf(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                  uint32_t count) const {
        auto& leaf = *reinterpret_cast<TriangleLeaf<N>*>(block + offset);
        for (uint32_t lane = 0; lane < N; ++lane) {
            float v[9];
            if (lane < count) {
                const PrimitiveRef& r = references[lane];
                readers_[r.input].readActive(r.primitive, v);
                leaf.primitive[lane] = sbt_[r.input].primitiveIndex(r.primitive);
                leaf.sbt[lane] = sbt_[r.input].sbtWord(r.primitive);
                if (table_)
                    table_[inputs_[r.input].firstPrimitive + r.primitive] =
                        makeSlot(offset, N == 8, lane);
            } else {
                std::fill(v, v + 9, std::numeric_limits<float>::quiet_NaN());
                leaf.primitive[lane] = ~0u;
                leaf.sbt[lane] = 0;
            }
            for (int i = 0; i < 9; ++i)
                leaf.vertices[i * int(N) + int(lane)] = v[i];
        }
        leaf.count = count;
        std::fill(std::begin(leaf.pad), std::end(leaf.pad), 0u);
    }

    const std::vector<TriangleReader>& readers_;
    const std::vector<SbtReader>& sbt_;
    const InputRecord* inputs_;
    uint32_t* table_;
};

class CustomWriter final : public LeafWriter {
public:
    CustomWriter(const std::vector<CustomReader>& readers, const std::vector<SbtReader>& sbt)
        : readers_(readers), sbt_(sbt) {}

    NodeRef write(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                  uint32_t) const override {
        auto& leaf = *reinterpret_cast<CustomLeaf*>(block + offset);
        const PrimitiveRef& r = *references;
        readers_[r.input].read(r.primitive, leaf.lower, leaf.upper);
        leaf.primitive = sbt_[r.input].primitiveIndex(r.primitive);
        leaf.sbt = sbt_[r.input].sbtWord(r.primitive);
        return makeRef(offset, kLeaf);
    }

private:
    const std::vector<CustomReader>& readers_;
    const std::vector<SbtReader>& sbt_;
};

class InstanceWriter final : public LeafWriter {
public:
    explicit InstanceWriter(uint64_t instancesOffset) : instancesOffset_(instancesOffset) {}

    NodeRef write(uint8_t*, uint64_t, const PrimitiveRef* references, uint32_t) const override {
        return makeRef(instancesOffset_ + references->primitive * sizeof(InstanceData), kLeaf);
    }

private:
    uint64_t instancesOffset_;
};

class Build {
public:
    Build(const BuildInputs& inputs, const BuildOptions& options, const Plan& plan, uint8_t* temp,
          uint8_t* output)
        : inputs_(inputs), options_(options), plan_(plan), block_(output),
          references_(reinterpret_cast<PrimitiveRef*>(temp)),
          scratch_(references_ + plan.numPrimitives),
          header_(*reinterpret_cast<BlockHeader*>(output)) {
        tree_.nodes = reinterpret_cast<TreeNode*>(temp + plan.treeOffset);
        tree_.capacity = maxTreeNodes(plan.numPrimitives, plan.rules);
    }

    void run() {
        startHeader();
        switch (plan_.type) {
        case BlockType::kTriangles:
            runTriangles();
            break;
        case BlockType::kCustom:
            runCustoms();
            break;
        case BlockType::kInstances:
            runInstances();
            break;
        }
        header_.magic = kBlockMagic;
    }

private:
    // The magic number comes last: a block is one only when it is complete.
    void startHeader() {
        std::memset(block_, 0, plan_.nodesOffset);
        header_.version = kBlockVersion;
        header_.type = plan_.type;
        header_.root = kNoNode;
        header_.usedSize = plan_.nodesOffset;
        header_.numPrimitives = plan_.numPrimitives;
        header_.numInputs = plan_.numInputs;
        header_.inputsOffset = plan_.inputsOffset;
        header_.tableOffset = plan_.tableOffset;
        header_.instancesOffset = plan_.instancesOffset;
        header_.nodesOffset = plan_.nodesOffset;
        header_.options = (options_.allowUpdate ? kOptionUpdate : 0) |
                          (options_.allowCompaction ? kOptionCompaction : 0) |
                          (options_.preferFastTrace ? kOptionFastTrace : 0) |
                          (options_.preferFastBuild ? kOptionFastBuild : 0) |
                          (options_.allowRandomVertexAccess ? kOptionVertexAccess : 0) |
                          (options_.allowRandomInstanceAccess ? kOptionInstanceAccess : 0);
        header_.motionKeys = 1;
    }

    InputRecord* inputRecords() {
        return reinterpret_cast<InputRecord*>(block_ + plan_.inputsOffset);
    }

    // Input records and SBT readers; returns nothing the block does not hold.
    template <class Input>
    void describeInputs(std::span<const Input> inputs, std::vector<SbtReader>& sbt) {
        uint32_t firstSbt = 0, firstPrimitive = 0;
        header_.geometryFlagsAnd = ~0u;
        for (uint32_t i = 0; i < plan_.numInputs; ++i) {
            const SbtInput& s = inputs[i].sbt;
            const uint32_t count = plan_.countOf(inputs_, i);
            inputRecords()[i] = {firstSbt, s.numSbtRecords,        firstPrimitive,
                                 count,    s.primitiveIndexOffset, {}};
            sbt.emplace_back(s, firstSbt);
            for (uint32_t k = 0; k < s.numSbtRecords; ++k)
                header_.geometryFlagsAnd &= s.flags ? s.flags[k] : 0;
            firstSbt += s.numSbtRecords;
            firstPrimitive += count;
        }
        header_.numSbtRecords = firstSbt;
    }

    // Makes references of the active primitives; box(input, primitive, lower, upper) gives a
    // primitive's exact box, or false.
    template <class BoxOf>
    uint32_t makeReferences(const BoxOf& boxOf) {
        struct Part {
            Box box;
            uint32_t active = 0;
        };
        uint32_t written = 0;
        Box all;
        uint32_t first = 0;
        for (uint32_t input = 0; input < plan_.numInputs; ++input) {
            const uint32_t count = plan_.countOf(inputs_, input);
            std::vector<Part> parts((count + kReferenceBlock - 1) / kReferenceBlock);
            PrimitiveRef* const to = references_ + first;
            auto body = [&](size_t begin, size_t end, size_t block) {
                Part part;
                for (size_t i = begin; i < end; ++i) {
                    PrimitiveRef& r = to[begin + part.active];
                    float upper[3];
                    if (!boxOf(input, uint32_t(i), r.lower, upper))
                        continue;
                    part.box.extend({{r.lower[0], r.lower[1], r.lower[2]},
                                     {upper[0], upper[1], upper[2]}});
                    padBox(r.lower, upper);
                    for (int a = 0; a < 3; ++a)
                        r.negUpper[a] = -upper[a];
                    r.primitive = uint32_t(i);
                    r.input = input;
                    ++part.active;
                }
                parts[block] = part;
            };
            parallelBlocks(count, kReferenceBlock, body);
            for (size_t block = 0; block < parts.size(); ++block) {
                const PrimitiveRef* from = to + block * kReferenceBlock;
                if (from != references_ + written)
                    std::memmove(references_ + written, from,
                                 parts[block].active * sizeof(PrimitiveRef));
                written += parts[block].active;
                all.extend(parts[block].box);
            }
            first += count;
        }
        header_.numActive = written;
        for (int a = 0; a < 3; ++a) {
            header_.lower[a] = all.lower[a];
            header_.upper[a] = all.upper[a];
        }
        return written;
    }

    void buildAndEmit(uint32_t active, const LeafWriter& writer) {
        if (active == 0)
            return;
        if (options_.preferFastBuild)
            buildMortonTree(references_, scratch_, active, plan_.rules, tree_);
        else
            buildSahTree(references_, scratch_, active, plan_.rules, tree_);
        emitTree(tree_, plan_.rules, writer, block_, plan_.nodesOffset);
    }

    void runTriangles() {
        std::vector<SbtReader> sbt;
        std::vector<TriangleReader> readers;
        describeInputs(inputs_.triangles, sbt);
        for (const TriangleInput& input : inputs_.triangles)
            readers.emplace_back(input);
        uint32_t* table = nullptr;
        if (plan_.tableOffset) {
            table = reinterpret_cast<uint32_t*>(block_ + plan_.tableOffset);
            std::fill(table, table + plan_.numPrimitives, kNoSlot);
        }
        const auto boxOf = [&](uint32_t input, uint32_t i, float lower[3], float upper[3]) {
            float v[9];
            if (!readers[input].read(i, v))
                return false;
            for (int a = 0; a < 3; ++a) {
                lower[a] = std::min({v[a], v[3 + a], v[6 + a]});
                upper[a] = std::max({v[a], v[3 + a], v[6 + a]});
            }
            return true;
        };
        const uint32_t active = makeReferences(boxOf);
        buildAndEmit(active, TriangleWriter(readers, sbt, inputRecords(), table));
    }

    void runCustoms() {
        std::vector<SbtReader> sbt;
        std::vector<CustomReader> readers;
        describeInputs(inputs_.customs, sbt);
        for (const CustomInput& input : inputs_.customs)
            readers.emplace_back(input);
        const auto boxOf = [&](uint32_t input, uint32_t i, float lower[3], float upper[3]) {
            return readers[input].read(i, lower, upper);
        };
        const uint32_t active = makeReferences(boxOf);
        buildAndEmit(active, CustomWriter(readers, sbt));
    }

    void runInstances() {
        const InstanceInput& input = *inputs_.instances;
        if (input.numInstances && !input.instances && !input.instancePointers)
            fail(Code::kInvalidValue, "instances is null, numInstances is ", input.numInstances);
        auto* const records =
            reinterpret_cast<InstanceData*>(block_ + plan_.instancesOffset);
        const auto boxOf = [&](uint32_t, uint32_t i, float lower[3], float upper[3]) {
            return describeInstance(instanceAt(input, i), i, records[i], lower, upper);
        };
        const uint32_t active = makeReferences(boxOf);
        buildAndEmit(active, InstanceWriter(plan_.instancesOffset));
    }

    static bool describeInstance(const InstanceDesc& from, uint32_t index, InstanceData& to,
                                 float lower[3], float upper[3]) {
        std::memcpy(to.objectToWorld, from.transform, sizeof to.objectToWorld);
        const bool invertible = math::invert(from.transform, to.worldToObject);
        to.child = from.traversableHandle;
        to.instanceId = from.instanceId;
        to.sbtOffset = from.sbtOffset;
        to.visibilityMask = from.visibilityMask;
        to.flags = from.flags;
        to.index = index;
        if (!invertible || from.traversableHandle == 0 || (from.visibilityMask & 0xFF) == 0)
            return false;
        const Box box = math::transformBox(from.transform, traversableBounds(from.traversableHandle));
        bool good = !box.empty();
        for (int a = 0; a < 3; ++a) {
            lower[a] = box.lower[a];
            upper[a] = box.upper[a];
            good = good && std::fabs(lower[a]) <= kMaxCoordinate &&
                   std::fabs(upper[a]) <= kMaxCoordinate;
        }
        return good;
    }

    const BuildInputs& inputs_;
    const BuildOptions& options_;
    const Plan& plan_;
    uint8_t* block_;
    PrimitiveRef* references_;
    PrimitiveRef* scratch_;
    BlockHeader& header_;
    Tree tree_;
};

void checkBuffer(const char* name, const void* buffer, size_t size, size_t needed) {
    if (!buffer || uintptr_t(buffer) % kBlockAlignment != 0)
        fail(Code::kInvalidValue, name, " is ", buffer, ": must be a multiple of ",
             kBlockAlignment);
    if (size < needed)
        fail(Code::kInvalidValue, name, " has ", size, " bytes, the build needs ", needed);
}

const BlockHeader& checkedHeader(const void* block) {
    if (!isBlock(block))
        fail(Code::kInvalidValue, block, " is no acceleration structure");
    return *headerOf(block);
}

} // namespace

MemoryUsage computeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options) {
    const Plan plan(inputs, options);
    MemoryUsage usage;
    usage.output = plan.outputSize;
    usage.temp = plan.tempSize;
    usage.tempUpdate = options.allowUpdate ? plan.tempSize : 0;
    return usage;
}

void build(const BuildInputs& inputs, const BuildOptions& options, void* temp, size_t tempSize,
           void* output, size_t outputSize) {
    const Plan plan(inputs, options);
    checkBuffer("the temporary buffer", temp, tempSize, plan.tempSize);
    checkBuffer("the output buffer", output, outputSize, plan.outputSize);
    inArena([&] {
        Build(inputs, options, plan, static_cast<uint8_t*>(temp), static_cast<uint8_t*>(output))
            .run();
    });
}

bool isBlock(const void* block) {
    return block && uintptr_t(block) % 64 == 0 && looksLikeBlock(headerOf(block));
}

bool allowsCompaction(const void* block) {
    return isBlock(block) && (headerOf(block)->options & kOptionCompaction) != 0;
}

uint64_t compactedSize(const void* block) {
    return checkedHeader(block).usedSize;
}

void compact(const void* source, void* destination, size_t destinationSize) {
    const BlockHeader& header = checkedHeader(source);
    checkBuffer("the output buffer", destination, destinationSize, header.usedSize);
    const auto* from = static_cast<const uint8_t*>(source);
    auto* to = static_cast<uint8_t*>(destination);
    if (from < to + header.usedSize && to < from + header.usedSize)
        fail(Code::kInvalidValue, "the compacted structure would overlap its source");
    auto copy = [&](size_t begin, size_t end, size_t) {
        std::memcpy(to + begin, from + begin, end - begin);
    };
    inArena([&] { parallelBlocks(header.usedSize, 1u << 22, copy); });
}

Box bounds(const void* block) {
    const BlockHeader& header = checkedHeader(block);
    Box box;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = header.lower[a];
        box.upper[a] = header.upper[a];
    }
    return box;
}

uint64_t traversableHandle(const void* block) {
    const bool instances = checkedHeader(block).type == BlockType::kInstances;
    return uint64_t(block) | (instances ? kIasTag : kGasTag);
}

bool triangleVertices(const void* block, uint32_t primitive, uint32_t sbtGasIndex,
                      float vertices[9]) noexcept {
    if (!isBlock(block))
        return false;
    const BlockHeader& header = *headerOf(block);
    const auto* const bytes = static_cast<const uint8_t*>(block);
    if (header.type != BlockType::kTriangles || !header.tableOffset)
        return false;
    const auto* inputs = reinterpret_cast<const InputRecord*>(bytes + header.inputsOffset);
    for (uint32_t i = 0; i < header.numInputs; ++i) {
        const InputRecord& input = inputs[i];
        if (sbtGasIndex - input.firstSbtIndex >= input.numSbtRecords)
            continue;
        const uint32_t local = primitive - input.primitiveIndexOffset;
        if (local >= input.numPrimitives)
            return false;
        const uint32_t slot = reinterpret_cast<const uint32_t*>(
            bytes + header.tableOffset)[input.firstPrimitive + local];
        const uint32_t lanes = slot & 8 ? 8 : 4;
        const auto* leaf = reinterpret_cast<const float*>(bytes + uint64_t(slot >> 4) * 64);
        for (uint32_t k = 0; k < 9; ++k)
            vertices[k] = slot == kNoSlot ? std::numeric_limits<float>::quiet_NaN()
                                          : leaf[k * lanes + (slot & 7)];
        return true;
    }
    return false;
}

const void* instanceRecord(const void* block, uint32_t index) noexcept {
    if (!isBlock(block))
        return nullptr;
    const BlockHeader& header = *headerOf(block);
    if (header.type != BlockType::kInstances || index >= header.numPrimitives)
        return nullptr;
    return static_cast<const uint8_t*>(block) + header.instancesOffset +
           uint64_t(index) * sizeof(InstanceData);
}

} // namespace sunstone::bvh
