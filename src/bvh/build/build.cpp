// SPDX-License-Identifier: Apache-2.0
// The stages of a CPU build: sizes, references, tree, block.
#include "bvh/build/build.h"

#include "base/error.h"
#include "base/threads/threads.h"
#include "bvh/build/build_parts.h"
#include "bvh/build/emit.h"
#include "bvh/build/leaf_writers.h"
#include "bvh/build/presplit.h"
#include "bvh/input/build_input.h"
#include "bvh/input/input_lookup.h"
#include "bvh/layout.h"
#include "bvh/micromap/micromap_binding.h"
#include "bvh/motion/motion_input.h"
#include "bvh/motion/motion_refit.h"
#include "bvh/parallel.h"
#include "bvh/refit/refit.h"
#include "bvh/shapes/shape_build.h"
#include "bvh/shapes/shape_input.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <type_traits>

namespace sunstone::bvh {
namespace {

LeafRules rulesOf(BlockType type, uint32_t keys) {
    LeafRules rules;
    rules.nodeBytes = nodeBytes(keys);
    switch (type) {
    case BlockType::kTriangles:
        rules.minCount = 2;
        rules.maxCount = 8;
        rules.bytes4 = leafBytes(sizeof(TriangleLeaf<4>), sizeof(TriangleKey<4>), keys, 64);
        rules.bytes8 = leafBytes(sizeof(TriangleLeaf<8>), sizeof(TriangleKey<8>), keys, 64);
        break;
    case BlockType::kCustom:
        rules.minCount = rules.maxCount = 1;
        rules.bytes4 = rules.bytes8 =
            leafBytes(sizeof(CustomLeaf), sizeof(CustomKey), keys, kRefUnit);
        break;
    case BlockType::kInstances:
        rules.minCount = rules.maxCount = 1;
        rules.bytes4 = rules.bytes8 = 0;
        break;
    case BlockType::kShapes: // shape_build.cpp
        break;
    }
    return rules;
}

// Properties of a build that follow from counts and options.
struct Plan {
    BlockType type; // without kMotionBit
    uint32_t keys;
    LeafRules rules;
    uint32_t numInputs = 1;
    uint32_t numPrimitives = 0;
    uint32_t numReferences = 0;    // room for them: more where triangles may be split
    bool instancesMissing = false; // size queries may omit buffers
    uint64_t inputsOffset, keyBoundsOffset = 0, tableOffset = 0, micromapsOffset = 0,
                           instancesOffset = 0, nodesOffset;
    uint64_t outputSize, referencesSize, treeOffset, tempSize;
    uint64_t instanceMotionSize = 0; // scratch at the end of temp; all that updates need

    const SbtInput& sbtOf(const BuildInputs& inputs, uint32_t i) const {
        return type == BlockType::kTriangles ? inputs.triangles[i].sbt : inputs.customs[i].sbt;
    }
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
        const int kinds =
            !inputs.triangles.empty() + !inputs.customs.empty() + (inputs.instances != nullptr);
        if (kinds != 1)
            fail(Code::kInvalidValue,
                 "a build takes triangles, custom primitives or instances: got ", kinds, " kinds");
        type = !inputs.triangles.empty() ? BlockType::kTriangles
               : !inputs.customs.empty() ? BlockType::kCustom
                                         : BlockType::kInstances;
        keys = std::max(options.motion.keys, 1u);
        rules = rulesOf(type, keys);
        if (type != BlockType::kInstances)
            numInputs = uint32_t(std::max(inputs.triangles.size(), inputs.customs.size()));
        uint64_t total = 0, sbtRecords = 0;
        for (uint32_t i = 0; i < numInputs; ++i) {
            total += countOf(inputs, i);
            if (type != BlockType::kInstances)
                sbtRecords += sbtOf(inputs, i).numSbtRecords;
            if (type != BlockType::kInstances && sbtOf(inputs, i).numSbtRecords == 0)
                fail(Code::kInvalidValue, "build input ", i, " has no SBT record");
        }
        if (sbtRecords > kSbtIndexMask + 1u)
            fail(Code::kInvalidValue, sbtRecords, " SBT records in one structure, the limit is ",
                 kSbtIndexMask + 1u);
        if (type == BlockType::kInstances && total != 0 && !inputs.instances->instances &&
            !inputs.instances->instancePointers)
            instancesMissing = true;
        if (total > kMaxPrimitives)
            fail(Code::kInvalidValue, total, " primitives in one structure, the limit is ",
                 kMaxPrimitives);
        numPrimitives = uint32_t(total);
        // Updates need one place for each primitive, because the parts of a split triangle could
        // move apart.
        if (type == BlockType::kTriangles && options.preferFastTrace && !options.allowUpdate &&
            keys == 1)
            total += maxSplits(total);
        numReferences = uint32_t(total);
        layOut(options, micromapTableSize(inputs.triangles));
    }

    void layOut(const BuildOptions& options, uint64_t micromapsSize) {
        inputsOffset = sizeof(BlockHeader);
        uint64_t offset = inputsOffset + uint64_t(numInputs) * sizeof(InputRecord);
        if (keys > 1) {
            keyBoundsOffset = offset;
            offset += uint64_t(keys) * sizeof(KeyBounds);
        }
        if (type == BlockType::kTriangles && options.allowRandomVertexAccess) {
            tableOffset = alignUp(offset, 64);
            offset = tableOffset + uint64_t(numPrimitives) * sizeof(uint32_t);
        }
        if (micromapsSize) {
            micromapsOffset = alignUp(offset, 64);
            offset = micromapsOffset + micromapsSize;
        }
        if (type == BlockType::kInstances) {
            instancesOffset = alignUp(offset, 64);
            offset = instancesOffset + uint64_t(numPrimitives) * sizeof(InstanceRecord);
        }
        nodesOffset = alignUp(offset, kNodesAlignment);
        outputSize = alignUp(nodesOffset + maxTreeBytes(numReferences, rules), kBlockAlignment);
        if (outputSize > kMaxBlockSize || (tableOffset && outputSize > kMaxBlockSize / 2))
            fail(Code::kInvalidValue, numPrimitives, " primitives need up to ", outputSize,
                 " bytes, a structure can have ", kMaxBlockSize / (tableOffset ? 2 : 1));
        referencesSize = uint64_t(numReferences) * sizeof(PrimitiveRef);
        treeOffset = alignUp((options.preferFastBuild ? 3 : 2) * referencesSize, 64);
        tempSize =
            alignUp(treeOffset + uint64_t(maxTreeNodes(numReferences, rules)) * sizeof(TreeNode),
                    kBlockAlignment);
        if (type == BlockType::kInstances && keys > 1)
            instanceMotionSize =
                alignUp(uint64_t(numPrimitives) * keys * sizeof(KeyBounds), kBlockAlignment);
        tempSize += instanceMotionSize;
    }
};

class Build {
public:
    Build(const BuildInputs& inputs, const BuildOptions& options, const Plan& plan, uint8_t* temp,
          uint8_t* output)
        : inputs_(inputs), options_(options), plan_(plan), block_(output),
          references_(reinterpret_cast<PrimitiveRef*>(temp)),
          scratch_(references_ + plan.numReferences),
          header_(*reinterpret_cast<BlockHeader*>(output)) {
        tree_.nodes = reinterpret_cast<TreeNode*>(temp + plan.treeOffset);
        tree_.capacity = maxTreeNodes(plan.numReferences, plan.rules);
        instanceMotion_.bounds =
            reinterpret_cast<KeyBounds*>(temp + plan.tempSize - plan.instanceMotionSize);
        instanceMotion_.read = false;
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
        case BlockType::kShapes: // shape_build.cpp
            break;
        }
        header_.magic = kBlockMagic;
    }

private:
    // The magic number is written last, so that an incomplete block is not valid.
    void startHeader() {
        std::memset(block_, 0, plan_.nodesOffset);
        header_.version = kBlockVersion;
        header_.type = plan_.micromapsOffset ? withMicromaps(plan_.type) : plan_.type;
        if (plan_.keys > 1)
            header_.type = withMotion(header_.type);
        header_.root = kNoNode;
        header_.usedSize = plan_.nodesOffset;
        header_.numPrimitives = plan_.numPrimitives;
        header_.numInputs = plan_.numInputs;
        header_.inputsOffset = plan_.inputsOffset;
        header_.tableOffset = plan_.tableOffset;
        header_.micromapsOffset = plan_.micromapsOffset;
        header_.instancesOffset = plan_.instancesOffset;
        header_.nodesOffset = plan_.nodesOffset;
        header_.wholeRoot = kNoNode;
        header_.options = optionBits(options_);
        header_.motionKeys = plan_.keys;
        if (plan_.keys == 1)
            return;
        header_.motionFlags = options_.motion.flags;
        header_.motionBegin = options_.motion.begin;
        header_.motionEnd = options_.motion.end;
        header_.keyBoundsOffset = plan_.keyBoundsOffset;
        auto* const keys = reinterpret_cast<KeyBounds*>(block_ + plan_.keyBoundsOffset);
        std::fill(keys, keys + plan_.keys, kNoBounds);
    }

    InputRecord* inputRecords() {
        return reinterpret_cast<InputRecord*>(block_ + plan_.inputsOffset);
    }

    // Input records and the header fields that describe them.
    template <class Input>
    void describeInputs(std::span<const Input> inputs) {
        uint32_t firstSbt = 0, firstPrimitive = 0;
        header_.geometryFlagsAnd = ~0u;
        for (uint32_t i = 0; i < plan_.numInputs; ++i) {
            const SbtInput& s = inputs[i].sbt;
            const uint32_t count = plan_.countOf(inputs_, i);
            const TriangleInput* triangles = nullptr;
            if constexpr (std::is_same_v<Input, TriangleInput>)
                triangles = &inputs[i];
            inputRecords()[i] = makeInputRecord(s, firstSbt, firstPrimitive, count, triangles);
            for (uint32_t k = 0; k < s.numSbtRecords; ++k)
                header_.geometryFlagsAnd &= s.flags ? s.flags[k] : 0;
            firstSbt += s.numSbtRecords;
            firstPrimitive += count;
        }
        header_.numSbtRecords = firstSbt;
    }

    // Makes references to the active primitives, or to all if updates are allowed; an inactive
    // primitive then has its predecessor's position. boxOf(input, primitive, lower, upper) returns
    // a primitive's exact box, or false.
    template <class BoxOf>
    uint32_t makeReferences(const BoxOf& boxOf) {
        struct Part {
            Box box;
            uint32_t count = 0, active = 0;
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
                    PrimitiveRef& r = to[begin + part.count];
                    float upper[3];
                    if (boxOf(input, uint32_t(i), r.lower, upper)) {
                        part.box.extend(
                            {{r.lower[0], r.lower[1], r.lower[2]}, {upper[0], upper[1], upper[2]}});
                        padBox(r.lower, upper);
                        for (int a = 0; a < 3; ++a)
                            r.negUpper[a] = -upper[a];
                        ++part.active;
                    } else if (!options_.allowUpdate) {
                        continue;
                    } else if (part.count > 0) {
                        r = to[begin + part.count - 1];
                    } else {
                        r = {};
                    }
                    r.primitive = uint32_t(i);
                    r.input = input;
                    ++part.count;
                }
                parts[block] = part;
            };
            parallelBlocks(count, kReferenceBlock, body);
            for (size_t block = 0; block < parts.size(); ++block) {
                const PrimitiveRef* from = to + block * kReferenceBlock;
                if (from != references_ + written)
                    std::memmove(references_ + written, from,
                                 parts[block].count * sizeof(PrimitiveRef));
                written += parts[block].count;
                header_.numActive += parts[block].active;
                all.extend(parts[block].box);
            }
            first += count;
        }
        for (int a = 0; a < 3; ++a) {
            header_.lower[a] = all.lower[a];
            header_.upper[a] = all.upper[a];
        }
        return written;
    }

    void buildAndEmit(uint32_t count, const LeafWriter& writer, const Sources& sources) {
        if (count == 0)
            return;
        if (options_.preferFastBuild)
            buildMortonTree(references_, scratch_, count, plan_.rules, tree_);
        else
            buildSahTree(references_, scratch_, count, plan_.rules, tree_);
        emitTree(tree_, plan_.rules, writer, block_, plan_.nodesOffset);
        if (options_.allowUpdate)
            header_.wholeRoot = header_.root;
        if (plan_.keys > 1) // the boxes so far are the mean boxes
            refitMotion(block_, sources, MotionReader(inputs_, plan_.keys), instanceMotion_);
        else if (options_.allowUpdate && header_.numActive < count)
            refit(block_, sources); // removes inactive primitives from the boxes
    }

    void runTriangles() {
        const Sources sources(inputs_);
        describeInputs(inputs_.triangles);
        if (plan_.micromapsOffset)
            bindMicromaps(block_, inputs_.triangles);
        uint32_t* table = nullptr;
        if (plan_.tableOffset) {
            table = reinterpret_cast<uint32_t*>(block_ + plan_.tableOffset);
            std::fill(table, table + plan_.numPrimitives, kNoSlot);
        }
        const MotionReader motion(inputs_, plan_.keys);
        const auto boxOf = [&](uint32_t input, uint32_t i, float lower[3], float upper[3]) {
            if (plan_.keys > 1)
                return motion.triangleBox(input, i, lower, upper);
            float v[9];
            if (!sources.triangles[input].read(i, v))
                return false;
            for (int a = 0; a < 3; ++a) {
                lower[a] = std::min({v[a], v[3 + a], v[6 + a]});
                upper[a] = std::max({v[a], v[3 + a], v[6 + a]});
            }
            return true;
        };
        uint32_t count = makeReferences(boxOf);
        if (plan_.numReferences > plan_.numPrimitives)
            count =
                splitLongTriangles(references_, count, sources, reinterpret_cast<float*>(scratch_));
        buildAndEmit(count, TriangleWriter(sources, inputRecords(), table, options_.allowUpdate),
                     sources);
    }

    void runCustoms() {
        const Sources sources(inputs_);
        describeInputs(inputs_.customs);
        const MotionReader motion(inputs_, plan_.keys);
        const auto boxOf = [&](uint32_t input, uint32_t i, float lower[3], float upper[3]) {
            return plan_.keys > 1 ? motion.customBox(input, i, lower, upper)
                                  : sources.customs[input].read(i, lower, upper);
        };
        const uint32_t count = makeReferences(boxOf);
        buildAndEmit(count, CustomWriter(sources), sources);
    }

    void runInstances() {
        const Sources sources(inputs_);
        const InstanceInput& input = *inputs_.instances;
        auto* const records = reinterpret_cast<InstanceRecord*>(block_ + plan_.instancesOffset);
        const OpenLevels levels = OpenLevels::of(header_.options);
        const auto boxOf = [&](uint32_t, uint32_t i, float lower[3], float upper[3]) {
            const InstanceDesc& desc = instanceAt(input, i);
            if (plan_.keys == 1)
                return describeInstance(desc, i, levels, records[i], lower, upper);
            KeyBounds* const keys = instanceMotion_.bounds + uint64_t(i) * plan_.keys;
            if (!describeMovingInstance(desc, i, levels, options_.motion, records[i], keys))
                return false;
            meanBox(keys, plan_.keys, lower, upper);
            return true;
        };
        const uint32_t count = makeReferences(boxOf);
        buildAndEmit(count, InstanceWriter(plan_.instancesOffset), sources);
    }

    const BuildInputs& inputs_;
    const BuildOptions& options_;
    const Plan& plan_;
    uint8_t* block_;
    PrimitiveRef* references_;
    PrimitiveRef* scratch_;
    BlockHeader& header_;
    InstanceMotion instanceMotion_;
    Tree tree_;
};

// Most updates need no scratch memory. They report some bytes, because a caller may be unable to
// allocate 0 bytes.
size_t updateTempSize(const Plan& plan) {
    return std::max<size_t>(plan.instanceMotionSize, kUpdateTempSize);
}

void requireInstances(const Plan& plan) {
    if (plan.instancesMissing)
        fail(Code::kInvalidValue, "instances is null, numInstances is ", plan.numPrimitives);
}

// Throws if the inputs of an update differ from those of the build in more than their buffers.
void checkInputRecords(const BuildInputs& inputs, const Plan& plan, const BlockHeader& header) {
    std::vector<InputRecord> now;
    uint32_t firstSbt = 0, firstPrimitive = 0;
    for (uint32_t i = 0; i < plan.numInputs; ++i) {
        const bool triangles = plan.type == BlockType::kTriangles;
        const SbtInput& sbt = plan.sbtOf(inputs, i);
        const uint32_t count = plan.countOf(inputs, i);
        now.push_back(makeInputRecord(sbt, firstSbt, firstPrimitive, count,
                                      triangles ? &inputs.triangles[i] : nullptr));
        firstSbt += sbt.numSbtRecords;
        firstPrimitive += count;
    }
    checkSameInputs(now, reinterpret_cast<const InputRecord*>(
                             reinterpret_cast<const uint8_t*>(&header) + header.inputsOffset));
}

const BlockHeader& checkedHeader(const void* block) {
    if (!isBlock(block))
        fail(Code::kInvalidValue, block, " is no acceleration structure");
    return *headerOf(block);
}

} // namespace

uint32_t optionBits(const BuildOptions& options) {
    return (options.allowUpdate ? kOptionUpdate : 0) |
           (options.allowCompaction ? kOptionCompaction : 0) |
           (options.preferFastTrace ? kOptionFastTrace : 0) |
           (options.preferFastBuild ? kOptionFastBuild : 0) |
           (options.allowRandomVertexAccess ? kOptionVertexAccess : 0) |
           (options.allowRandomInstanceAccess ? kOptionInstanceAccess : 0) |
           (options.allowMicromapUpdate ? kOptionMicromapUpdate : 0) |
           (options.allowDisableMicromaps ? kOptionDisableMicromaps : 0);
}

void checkBuffer(const char* name, const void* buffer, size_t size, size_t needed) {
    if (!buffer || uintptr_t(buffer) % kBlockAlignment != 0)
        fail(Code::kInvalidValue, name, " is ", buffer, ": must be a multiple of ",
             kBlockAlignment);
    if (size < needed)
        fail(Code::kInvalidValue, name, " has ", size, " bytes, the build needs ", needed);
}

MemoryUsage computeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options) {
    if (hasShapes(inputs))
        return shapeMemoryUsage(inputs, options);
    const Plan plan(inputs, options);
    MemoryUsage usage;
    usage.output = plan.outputSize;
    usage.temp = plan.tempSize;
    usage.tempUpdate = options.allowUpdate ? updateTempSize(plan) : 0;
    return usage;
}

void build(const BuildInputs& inputs, const BuildOptions& options, void* temp, size_t tempSize,
           void* output, size_t outputSize) {
    if (hasShapes(inputs))
        return buildShapes(inputs, options, temp, tempSize, output, outputSize);
    const Plan plan(inputs, options);
    requireInstances(plan);
    checkBuffer("the temporary buffer", temp, tempSize, plan.tempSize);
    checkBuffer("the output buffer", output, outputSize, plan.outputSize);
    inArena([&] {
        Build(inputs, options, plan, static_cast<uint8_t*>(temp), static_cast<uint8_t*>(output))
            .run();
    });
}

void checkSameShape(const BlockHeader& header, const BlockHeader& wanted) {
    if (!(header.options & kOptionUpdate) || !(wanted.options & kOptionUpdate))
        fail(Code::kInvalidValue, "an update needs ALLOW_UPDATE, in the build and now");
    if (header.options != wanted.options)
        fail(Code::kInvalidValue,
             "an update has other build flags than the build: ", wanted.options, ", not ",
             header.options);
    if (kindOf(header.type) != kindOf(wanted.type))
        fail(Code::kInvalidValue, "an update has another type of build inputs than the build");
    if (header.motionKeys != wanted.motionKeys)
        fail(Code::kInvalidValue, "an update has ", wanted.motionKeys,
             " motion keys, the build had ", header.motionKeys);
    if (wanted.motionKeys > 1 &&
        (header.motionFlags != wanted.motionFlags || header.motionBegin != wanted.motionBegin ||
         header.motionEnd != wanted.motionEnd))
        fail(Code::kInvalidValue, "an update has another motion range than the build");
    if (header.numInputs != wanted.numInputs || header.numPrimitives != wanted.numPrimitives)
        fail(Code::kInvalidValue, "an update has ", wanted.numInputs, " build inputs with ",
             wanted.numPrimitives, " primitives, the build had ", header.numInputs, " with ",
             header.numPrimitives);
}

void checkSameShape(const BlockHeader& header, const BuildOptions& options, BlockType type,
                    uint32_t keys, uint32_t numInputs, uint32_t numPrimitives) {
    BlockHeader wanted{};
    wanted.options = optionBits(options);
    wanted.type = type;
    wanted.motionKeys = keys;
    wanted.motionFlags = options.motion.flags;
    wanted.motionBegin = options.motion.begin;
    wanted.motionEnd = options.motion.end;
    wanted.numInputs = numInputs;
    wanted.numPrimitives = numPrimitives;
    checkSameShape(header, wanted);
}

void checkSameInputs(std::span<const InputRecord> now, const InputRecord* then) {
    for (size_t i = 0; i < now.size(); ++i) {
        const auto require = [&](const char* what, uint32_t a, uint32_t b) {
            if (a != b)
                fail(Code::kInvalidValue, "build input ", i, " of an update: ", what, " = ", a,
                     ", in the build it was ", b);
        };
        require("number of primitives", now[i].numPrimitives, then[i].numPrimitives);
        require("number of vertices", now[i].numVertices, then[i].numVertices);
        require("vertex format", now[i].formats >> 16, then[i].formats >> 16);
        require("index format", now[i].formats & 0xFFFF, then[i].formats & 0xFFFF);
        require("numSbtRecords", now[i].numSbtRecords, then[i].numSbtRecords);
        require("primitiveIndexOffset", now[i].primitiveIndexOffset, then[i].primitiveIndexOffset);
        if (now[i].flagsHash != then[i].flagsHash)
            fail(Code::kInvalidValue, "build input ", i,
                 " of an update: geometry flags are not those of the build");
    }
}

void checkUpdate(const BuildInputs& inputs, const BuildOptions& options, const void* output,
                 size_t outputSize) {
    if (hasShapes(inputs))
        return checkShapeUpdate(inputs, options, output, outputSize);
    const Plan plan(inputs, options);
    requireInstances(plan);
    if (!isBlock(output))
        fail(Code::kInvalidValue,
             "an update needs an acceleration structure in the output buffer "
             "at ",
             output);
    const BlockHeader& header = *headerOf(output);
    checkSameShape(header, options, plan.type, plan.keys, plan.numInputs, plan.numPrimitives);
    checkBuffer("the output buffer", output, outputSize, header.usedSize);
    if (plan.type != BlockType::kInstances)
        checkInputRecords(inputs, plan, header);
    checkMicromapUpdate(header, inputs.triangles);
}

void update(const BuildInputs& inputs, const BuildOptions& options, void* temp, size_t tempSize,
            void* output, size_t outputSize) {
    if (hasShapes(inputs))
        return updateShapes(inputs, options, temp, tempSize, output, outputSize);
    const Plan plan(inputs, options);
    checkBuffer("the temporary buffer", temp, tempSize, updateTempSize(plan));
    checkUpdate(inputs, options, output, outputSize);
    auto* const block = static_cast<uint8_t*>(output);
    inArena([&] {
        if (hasMicromaps(headerOf(block)->type) && options.allowMicromapUpdate)
            bindMicromaps(block, inputs.triangles);
        if (plan.keys > 1)
            refitMotion(block, Sources(inputs), MotionReader(inputs, plan.keys),
                        {static_cast<KeyBounds*>(temp), true});
        else
            refit(block, Sources(inputs));
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

Box boundsAtKey(const void* block, uint32_t key) {
    const BlockHeader& header = checkedHeader(block);
    if (!isMoving(header.type) || key >= header.motionKeys)
        return bounds(block);
    const KeyBounds& b = reinterpret_cast<const KeyBounds*>(static_cast<const uint8_t*>(block) +
                                                            header.keyBoundsOffset)[key];
    return {{b.lower[0], b.lower[1], b.lower[2]}, {b.upper[0], b.upper[1], b.upper[2]}};
}

MotionOptions motionOf(const void* block) {
    const BlockHeader& header = checkedHeader(block);
    return {header.motionKeys, header.motionFlags, header.motionBegin, header.motionEnd};
}

uint64_t traversableHandle(const void* block) {
    const bool instances = kindOf(checkedHeader(block).type) == BlockType::kInstances;
    return uint64_t(block) | (instances ? devlib::kTagIas : devlib::kTagGas);
}

bool triangleVertices(const void* block, uint32_t primitive, uint32_t sbtGasIndex,
                      float vertices[9], float time) noexcept {
    if (!isBlock(block))
        return false;
    const BlockHeader& header = *headerOf(block);
    const auto* const bytes = static_cast<const uint8_t*>(block);
    if (kindOf(header.type) != BlockType::kTriangles || !header.tableOffset)
        return false;
    const KeySegment at = keySegment(header, time);
    const InputRecord* input = inputWithSbtIndex(header, sbtGasIndex);
    const uint32_t local = input ? primitive - input->primitiveIndexOffset : 0;
    if (!input || local >= input->numPrimitives)
        return false;
    const uint32_t slot = reinterpret_cast<const uint32_t*>(
        bytes + header.tableOffset)[input->firstPrimitive + local];
    const uint32_t lanes = slot & 8 ? 8 : 4;
    const auto* leaf = reinterpret_cast<const float*>(bytes + uint64_t(slot >> 4) * 64);
    // The end of key 0 and the beginning of the later keys; see layout.h.
    const float* later =
        leaf + (lanes == 4 ? sizeof(TriangleLeaf<4>) : sizeof(TriangleLeaf<8>)) / sizeof(float);
    const float* const first = at.key == 0 ? leaf : later + (at.key - 1) * 9 * lanes;
    const float* const second = later + at.key * 9 * lanes;
    for (uint32_t k = 0; k < 9; ++k) {
        const uint32_t i = k * lanes + (slot & 7);
        vertices[k] = slot == kNoSlot         ? std::numeric_limits<float>::quiet_NaN()
                      : isMoving(header.type) ? vertexBetween(first[i], second[i], at.fraction)
                                              : leaf[i];
    }
    return true;
}

const void* instanceRecord(const void* block, uint32_t index) noexcept {
    if (!isBlock(block))
        return nullptr;
    const BlockHeader& header = *headerOf(block);
    if (kindOf(header.type) != BlockType::kInstances || index >= header.numPrimitives)
        return nullptr;
    return static_cast<const uint8_t*>(block) + header.instancesOffset +
           uint64_t(index) * sizeof(InstanceRecord);
}

} // namespace sunstone::bvh
