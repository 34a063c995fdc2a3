// SPDX-License-Identifier: Apache-2.0
// A build reads all points into the block, makes references to pieces (curves.h), lets the tree
// builders order them and writes leaves. Boxes of later motion keys, and all boxes after an update,
// come from one pass over the finished tree (Fit).
#include "bvh/shapes/shape_build.h"

#include "base/error.h"
#include "base/threads/threads.h"
#include "bvh/build/build_parts.h"
#include "bvh/build/emit.h"
#include "bvh/input/build_input.h"
#include "bvh/parallel.h"
#include "bvh/shapes/shape_geometry.h"
#include "bvh/shapes/shape_input.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

namespace sunstone::bvh {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr uint64_t kTaskBytes = 1u << 18;
constexpr uint32_t kUnusedLane = ~0u;
static_assert(kUnusedLane == kNoPiece && kUnusedLane == kNoSphere);

struct ShapePlan {
    uint32_t shape, keys, numInputs, numPrimitives = 0, pieces, numReferences;
    LeafRules rules;
    uint64_t inputsOffset, keyBoundsOffset = 0, pointsOffset, recordsOffset, nodesOffset;
    uint64_t outputSize, treeOffset, tempSize;

    ShapePlan(const BuildInputs& inputs, const BuildOptions& options)
        : shape(shapeOf(inputs)), keys(std::max(options.motion.keys, 1u)),
          numInputs(numShapeInputs(inputs)), pieces(maxPieces(shape, options)) {
        requireOneShape(inputs);
        count(inputs);
        rules.minCount = 2;
        rules.maxCount = 8;
        rules.cost4 = 1.5f;
        rules.cost8 = 2.0f;
        rules.nodeBytes = nodeBytes(keys);
        rules.bytes4 = shapeLeafBytes(shape, 4, keys);
        rules.bytes8 = shapeLeafBytes(shape, 8, keys);
        layOut(options);
    }

private:
    void count(const BuildInputs& inputs) {
        uint64_t total = 0, sbtRecords = 0;
        for (uint32_t i = 0; i < numInputs; ++i) {
            total += shapeCount(inputs, i);
            sbtRecords += shapeSbt(inputs, i).numSbtRecords;
            if (shapeSbt(inputs, i).numSbtRecords == 0)
                fail(Code::kInvalidValue, "build input ", i, " has no SBT record");
        }
        if (sbtRecords > kSbtIndexMask + 1u)
            fail(Code::kInvalidValue, sbtRecords, " SBT records in one structure, the limit is ",
                 kSbtIndexMask + 1u);
        const uint64_t limit = isCurveBasis(shape) ? kMaxCurveSegments - 1 : kMaxPrimitives;
        if (total > limit)
            fail(Code::kInvalidValue, total, " primitives in one structure, the limit is ", limit);
        if (total * keys > kMaxPrimitives)
            fail(Code::kInvalidValue, total, " primitives with ", keys,
                 " motion keys in one structure, the limit is ", kMaxPrimitives, " together");
        numPrimitives = uint32_t(total);
        numReferences = numPrimitives * pieces;
        if (uint64_t(numPrimitives) * pieces > kMaxPrimitives) {
            pieces = 1;
            numReferences = numPrimitives;
        }
    }

    void layOut(const BuildOptions& options) {
        inputsOffset = sizeof(BlockHeader);
        uint64_t offset = inputsOffset + uint64_t(numInputs) * sizeof(InputRecord);
        if (keys > 1) {
            keyBoundsOffset = alignUp(offset, 64);
            offset = keyBoundsOffset + uint64_t(keys) * sizeof(KeyBounds);
        }
        pointsOffset = alignUp(offset, 64);
        recordsOffset = pointsOffset + uint64_t(numPrimitives) * keys * shapeFloats(shape) * 4;
        offset = recordsOffset + uint64_t(numPrimitives) * sizeof(ShapeRecord);
        nodesOffset = alignUp(offset, kNodesAlignment);
        outputSize = alignUp(nodesOffset + maxTreeBytes(numReferences, rules), kBlockAlignment);
        if (outputSize > kMaxBlockSize)
            fail(Code::kInvalidValue, numPrimitives, " primitives need up to ", outputSize,
                 " bytes, a structure can have ", kMaxBlockSize);
        const uint64_t references = uint64_t(numReferences) * sizeof(PrimitiveRef);
        treeOffset = alignUp((options.preferFastBuild ? 3 : 2) * references, 64);
        tempSize =
            alignUp(treeOffset + uint64_t(maxTreeNodes(numReferences, rules)) * sizeof(TreeNode),
                    kBlockAlignment);
    }
};

// Writes leaves from the arrays of the block.
class ShapeWriter final : public LeafWriter {
public:
    explicit ShapeWriter(const ShapeStore& store) : store_(store), rows_(shapeRows(store.shape)) {}

    NodeRef write(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                  uint32_t count) const override {
        const uint32_t lanes = count <= 4 ? 4 : 8;
        uint8_t* const leaf = block + offset;
        std::memset(leaf, 0, shapeLeafBytes(store_.shape, lanes, store_.keys));
        auto* const words = reinterpret_cast<uint32_t*>(leaf);
        for (uint32_t lane = 0; lane < lanes; ++lane)
            words[lane] = lane < count ? references[lane].primitive : kUnusedLane;
        fill(leaf, lanes);
        return makeRef(offset, count <= 4 ? kLeaf : kWideLeaf);
    }

    void prefetch(const PrimitiveRef* references, uint32_t count, int round) const override {
        for (uint32_t i = 0; i < count && round == 0; ++i) {
            const uint32_t number = numberOf(references[i].primitive);
            const float* const points = store_.pointsOf(number, 0);
            __builtin_prefetch(points);
            __builtin_prefetch(points + shapeFloats(store_.shape) - 1);
            __builtin_prefetch(store_.records + number);
        }
    }

    // Computes the other rows from the pieces in row 0.
    void fill(uint8_t* leaf, uint32_t lanes) const {
        const auto* const words = reinterpret_cast<const uint32_t*>(leaf);
        float* rows = reinterpret_cast<float*>(leaf) + lanes;
        for (uint32_t key = 0; key < store_.keys; ++key, rows += (rows_ - 1) * lanes)
            for (uint32_t lane = 0; lane < lanes; ++lane) {
                float values[kLinearRows];
                std::fill(std::begin(values), std::end(values),
                          std::numeric_limits<float>::quiet_NaN());
                const uint32_t number = numberOf(words[lane]);
                if (words[lane] != kUnusedLane && store_.active(number))
                    shapeLane(store_.shape, store_.pointsOf(number, key), words[lane],
                              store_.keys > 1, values);
                for (uint32_t row = 0; row + 1 < rows_; ++row)
                    rows[row * lanes + lane] = values[row];
            }
    }

    uint32_t numberOf(uint32_t word) const {
        return isCurveBasis(store_.shape) ? segmentOf(word) : word;
    }

private:
    const ShapeStore& store_;
    uint32_t rows_;
};

// Boxes at all keys above the leaves of a tree, from the leaves up.
class Fit {
public:
    Fit(uint8_t* block, const ShapeStore& store, bool rewriteLeaves)
        : block_(block), header_(*reinterpret_cast<BlockHeader*>(block)), store_(store),
          writer_(store), rewriteLeaves_(rewriteLeaves) {}

    // Returns whether any primitive below `root` is active.
    bool run(NodeRef root) {
        std::vector<Box> boxes(store_.keys);
        fit(root, header_.usedSize, boxes.data());
        return !boxes[0].empty();
    }

private:
    void fit(NodeRef ref, uint64_t end, Box* boxes) const {
        if ((ref & kNodeTagMask) == kInner)
            fitNode(offsetOf(ref), end, boxes);
        else
            fitLeaf(block_ + offsetOf(ref), (ref & kNodeTagMask) == kLeaf ? 4 : 8, boxes);
    }

    void fitLeaf(uint8_t* leaf, uint32_t lanes, Box* boxes) const {
        if (rewriteLeaves_)
            writer_.fill(leaf, lanes);
        const auto* const words = reinterpret_cast<const uint32_t*>(leaf);
        for (uint32_t lane = 0; lane < lanes; ++lane) {
            const uint32_t number = writer_.numberOf(words[lane]);
            if (words[lane] == kUnusedLane || !store_.active(number))
                continue;
            for (uint32_t key = 0; key < store_.keys; ++key) {
                float lower[3], upper[3];
                shapeBox({store_.shape, store_.pointsOf(number, key)}, words[lane], lower, upper);
                padBox(lower, upper);
                boxes[key].extend({{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}});
            }
        }
    }

    // Subtrees of inner children are contiguous, in the order of the children.
    void fitNode(uint64_t offset, uint64_t end, Box* boxes) const {
        Node& node = *reinterpret_cast<Node*>(block_ + offset);
        const uint32_t count = node.numChildren;
        uint64_t ends[8] = {}, next = end;
        for (uint32_t i = count; i-- > 0;) {
            ends[i] = next;
            if ((node.children[i] & kNodeTagMask) == kInner)
                next = offsetOf(node.children[i]);
        }
        std::vector<Box> below(size_t(count) * store_.keys);
        auto body = [&](size_t begin, size_t stop, size_t) {
            for (size_t i = begin; i < stop; ++i)
                fit(node.children[i], ends[i], below.data() + i * store_.keys);
        };
        if (end - offset < kTaskBytes)
            body(0, count, 0);
        else
            parallelBlocks(count, 1, body);
        for (uint32_t key = 0; key < store_.keys; ++key) {
            float(*planes)[8] = keyPlanes(block_ + offset, key);
            for (uint32_t i = 0; i < 8; ++i)
                setPlanes(planes, i, i < count ? below[size_t(i) * store_.keys + key] : Box{});
            for (uint32_t i = 0; i < count; ++i)
                boxes[key].extend(below[size_t(i) * store_.keys + key]);
        }
    }

    void setPlanes(float (*planes)[8], uint32_t child, const Box& box) const {
        // Infinite planes cannot be interpolated (layout.h).
        const float none = store_.keys > 1 ? kFar : kInf;
        for (int a = 0; a < 3; ++a) {
            planes[2 * a][child] = box.empty() ? none : box.lower[a];
            planes[2 * a + 1][child] = box.empty() ? -none : box.upper[a];
        }
    }

    uint8_t* block_;
    BlockHeader& header_;
    const ShapeStore& store_;
    ShapeWriter writer_;
    bool rewriteLeaves_;
};

// Chooses the pieces of a segment, and determines whether some of them bend.
class Splitter {
public:
    Splitter(const ShapeStore& store, uint32_t limit, bool always)
        : store_(store), limit_(limit), always_(always) {}

    // Number of pieces, a power of two. `boxes`, at the first key, has the box of the whole and
    // receives those of the pieces.
    uint32_t pieces(uint32_t number, const ShapePoints& at, PieceBoxes& boxes) const {
        if (!always_)
            return worthwhilePieces(at, most(number), boxes);
        if (most(number) > 1)
            boxesOfPieces(at, most(number), boxes);
        return most(number);
    }
    uint32_t most(uint32_t number) const {
        const uint32_t flags = store_.records[number].sbt >> kGeometryFlagShift;
        return isCurveBasis(store_.shape) && !(flags & kGeometryRequireSingleAnyHit) ? limit_ : 1;
    }

    bool bends(const ShapePoints& at, uint32_t pieces) const {
        // Between keys a curve may take any form.
        if (store_.keys > 1)
            return isCurveBasis(store_.shape);
        return anyBends(at, pieces);
    }

private:
    const ShapeStore& store_;
    uint32_t limit_;
    bool always_;
};

// Sets kCurveBent for structures that may be updated, in which all segments have the same pieces.
void markBends(const ShapeStore& store, uint32_t count, uint32_t limit) {
    const Splitter splitter(store, limit, true);
    auto body = [&](size_t begin, size_t end, size_t) {
        for (size_t i = begin; i < end; ++i)
            if (const uint32_t number = uint32_t(i);
                store.active(number) &&
                splitter.bends({store.shape, store.pointsOf(number, 0)}, splitter.most(number)))
                store.records[number].flags |= kCurveBent;
    };
    if (isCurveBasis(store.shape))
        parallelBlocks(count, kReferenceBlock, body);
}

// Bounds at each key and over all, and the number of active primitives. Blocks of primitives are
// measured in parallel.
class Measure {
public:
    Measure(uint32_t numPrimitives, uint32_t keys)
        : keys_(keys), blocks_((numPrimitives + kReferenceBlock - 1) / kReferenceBlock),
          boxes_(blocks_ * keys), active_(blocks_) {}

    // An active primitive at its first key.
    void begin(size_t block, const PieceBoxes& whole) {
        ++active_[block];
        add(block, 0, whole);
    }
    void add(size_t block, uint32_t key, const PieceBoxes& whole) {
        const auto& [lower, upper] = whole.of[0];
        boxes_[block * keys_ + key].extend(
            {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}});
    }

    void store(uint8_t* block) const {
        BlockHeader& header = *reinterpret_cast<BlockHeader*>(block);
        Box all;
        for (uint32_t key = 0; key < keys_; ++key) {
            Box box;
            for (size_t part = 0; part < blocks_; ++part)
                box.extend(boxes_[part * keys_ + key]);
            all.extend(box);
            if (!header.keyBoundsOffset)
                continue;
            auto* bounds = reinterpret_cast<KeyBounds*>(block + header.keyBoundsOffset) + key;
            store(box, bounds->lower, bounds->upper);
        }
        header.numActive = std::accumulate(active_.begin(), active_.end(), 0u);
        store(all, header.lower, header.upper);
    }

private:
    static void store(const Box& box, float lower[3], float upper[3]) {
        for (int a = 0; a < 3; ++a) {
            lower[a] = box.lower[a];
            upper[a] = box.upper[a];
        }
    }

    uint32_t keys_;
    size_t blocks_;
    std::vector<Box> boxes_;
    std::vector<uint32_t> active_;
};

void measure(uint8_t* block, const ShapeStore& store) {
    const uint32_t count = reinterpret_cast<BlockHeader*>(block)->numPrimitives;
    Measure found(count, store.keys);
    auto body = [&](size_t begin, size_t end, size_t part) {
        for (size_t i = begin; i < end; ++i)
            for (uint32_t key = 0; key < store.keys && store.active(uint32_t(i)); ++key) {
                PieceBoxes whole;
                boxesOfPieces({store.shape, store.pointsOf(uint32_t(i), key)}, 1, whole);
                key == 0 ? found.begin(part, whole) : found.add(part, key, whole);
            }
    };
    parallelBlocks(count, kReferenceBlock, body);
    found.store(block);
}

class ShapeBuild {
public:
    ShapeBuild(const BuildInputs& inputs, const BuildOptions& options, const ShapePlan& plan,
               uint8_t* temp, uint8_t* output)
        : inputs_(inputs), options_(options), plan_(plan), block_(output),
          references_(reinterpret_cast<PrimitiveRef*>(temp)),
          header_(*reinterpret_cast<BlockHeader*>(output)) {
        tree_.nodes = reinterpret_cast<TreeNode*>(temp + plan.treeOffset);
        tree_.capacity = maxTreeNodes(plan.numReferences, plan.rules);
    }

    void run() {
        startHeader();
        describeInputs();
        const ShapeStore store(block_);
        store.read(inputs_);
        const uint32_t count = makeReferences(store);
        if (count > 0)
            makeTree(store, count);
        header_.magic = kBlockMagic; // last: an incomplete block is not valid
    }

private:
    void startHeader() {
        std::memset(block_, 0, plan_.pointsOffset);
        header_.version = kBlockVersion;
        header_.type = plan_.keys > 1 ? withMotion(BlockType::kShapes) : BlockType::kShapes;
        header_.shape = uint16_t(plan_.shape);
        header_.root = header_.wholeRoot = kNoNode;
        header_.usedSize = plan_.nodesOffset;
        header_.numPrimitives = plan_.numPrimitives;
        header_.numInputs = plan_.numInputs;
        header_.inputsOffset = plan_.inputsOffset;
        header_.keyBoundsOffset = plan_.keyBoundsOffset;
        header_.pointsOffset = plan_.pointsOffset;
        header_.recordsOffset = plan_.recordsOffset;
        header_.nodesOffset = plan_.nodesOffset;
        header_.options = optionBits(options_);
        header_.motionKeys = plan_.keys;
        if (plan_.keys > 1) {
            header_.motionFlags = options_.motion.flags;
            header_.motionBegin = options_.motion.begin;
            header_.motionEnd = options_.motion.end;
        }
        // Bytes between the arrays and the nodes.
        const uint64_t end = plan_.recordsOffset + plan_.numPrimitives * sizeof(ShapeRecord);
        std::memset(block_ + end, 0, plan_.nodesOffset - end);
    }

    void describeInputs() {
        auto* records = reinterpret_cast<InputRecord*>(block_ + plan_.inputsOffset);
        uint32_t firstSbt = 0, firstPrimitive = 0;
        header_.geometryFlagsAnd = ~0u;
        for (uint32_t i = 0; i < plan_.numInputs; ++i) {
            const SbtInput& sbt = shapeSbt(inputs_, i);
            records[i] = shapeInputRecord(inputs_, i, firstSbt, firstPrimitive);
            for (uint32_t k = 0; k < sbt.numSbtRecords; ++k)
                header_.geometryFlagsAnd &= sbt.flags ? sbt.flags[k] : 0;
            firstSbt += sbt.numSbtRecords;
            firstPrimitive += shapeCount(inputs_, i);
        }
        header_.numSbtRecords = firstSbt;
    }

    // Makes references to the pieces of active primitives, or of all primitives if updates are
    // allowed. The boxes of inactive primitives are then meaningless until Fit replaces them.
    uint32_t makeReferences(const ShapeStore& store) {
        const Splitter splitter(store, plan_.pieces, options_.allowUpdate);
        const uint32_t count = plan_.numPrimitives;
        std::vector<uint32_t> made((count + kReferenceBlock - 1) / kReferenceBlock);
        Measure found(count, plan_.keys);
        auto body = [&](size_t begin, size_t end, size_t block) {
            PrimitiveRef* const first = references_ + begin * plan_.pieces;
            PrimitiveRef* to = first;
            for (size_t i = begin; i < end; ++i)
                if (store.active(uint32_t(i)))
                    to = referTo(store, uint32_t(i), splitter, found, block, to);
                else if (options_.allowUpdate)
                    to = referToInactive(uint32_t(i), splitter.most(uint32_t(i)), to);
            made[block] = uint32_t(to - first);
        };
        parallelBlocks(count, kReferenceBlock, body);
        found.store(block_);
        uint32_t written = 0;
        for (size_t block = 0; block < made.size(); ++block) {
            const PrimitiveRef* from = references_ + block * kReferenceBlock * plan_.pieces;
            if (from != references_ + written)
                std::memmove(references_ + written, from, made[block] * sizeof(PrimitiveRef));
            written += made[block];
        }
        return written;
    }

    uint32_t wordOf(uint32_t number, uint32_t place) const {
        return isCurveBasis(plan_.shape) ? pieceWord(number, place) : number;
    }

    // Writes references to the pieces of an active primitive; returns their end.
    PrimitiveRef* referTo(const ShapeStore& store, uint32_t number, const Splitter& splitter,
                          Measure& found, size_t block, PrimitiveRef* to) const {
        const ShapePoints at(store.shape, store.pointsOf(number, 0));
        PieceBoxes boxes;
        boxesOfPieces(at, 1, boxes);
        found.begin(block, boxes);
        const uint32_t pieces = splitter.pieces(number, at, boxes);
        if (splitter.bends(at, pieces))
            store.records[number].flags |= kCurveBent;
        for (uint32_t key = 1; key < plan_.keys; ++key) {
            const ShapePoints then(store.shape, store.pointsOf(number, key));
            PieceBoxes later;
            boxesOfPieces(then, 1, later);
            found.add(block, key, later);
            if (pieces > 1)
                boxesOfPieces(then, pieces, later);
            for (uint32_t i = 0; i < pieces; ++i)
                for (int a = 0; a < 3; ++a) {
                    auto& [lower, upper] = boxes.of[i];
                    lower[a] = std::min(lower[a], later.of[i].lower[a]);
                    upper[a] = std::max(upper[a], later.of[i].upper[a]);
                }
        }
        for (uint32_t i = 0; i < pieces; ++i, ++to) {
            auto& [lower, upper] = boxes.of[i];
            padBox(lower, upper);
            *to = {};
            to->primitive = wordOf(number, pieces + i);
            for (int a = 0; a < 3; ++a) {
                to->lower[a] = lower[a];
                to->negUpper[a] = -upper[a];
            }
        }
        return to;
    }

    PrimitiveRef* referToInactive(uint32_t number, uint32_t pieces, PrimitiveRef* to) const {
        for (uint32_t i = 0; i < pieces; ++i, ++to) {
            *to = {};
            to->primitive = wordOf(number, pieces + i);
        }
        return to;
    }

    void makeTree(const ShapeStore& store, uint32_t count) {
        PrimitiveRef* const scratch = references_ + plan_.numReferences;
        if (options_.preferFastBuild)
            buildMortonTree(references_, scratch, count, plan_.rules, tree_);
        else
            buildSahTree(references_, scratch, count, plan_.rules, tree_);
        emitTree(tree_, plan_.rules, ShapeWriter(store), block_, plan_.nodesOffset);
        bool active = true;
        if (plan_.keys > 1 || header_.numActive < plan_.numPrimitives)
            active = Fit(block_, store, false).run(header_.root);
        if (options_.allowUpdate)
            header_.wholeRoot = header_.root;
        if (!active)
            header_.root = kNoNode;
    }

    const BuildInputs& inputs_;
    const BuildOptions& options_;
    const ShapePlan& plan_;
    uint8_t* block_;
    PrimitiveRef* references_;
    BlockHeader& header_;
    Tree tree_;
};

// Throws if the inputs of an update differ from those of the build in more than their buffers.
void checkSameInputs(const BuildInputs& inputs, const BlockHeader& header) {
    const auto* records = reinterpret_cast<const InputRecord*>(
        reinterpret_cast<const uint8_t*>(&header) + header.inputsOffset);
    uint32_t firstSbt = 0, firstPrimitive = 0;
    for (uint32_t i = 0; i < header.numInputs; ++i) {
        const InputRecord now = shapeInputRecord(inputs, i, firstSbt, firstPrimitive);
        if (std::memcmp(&now, &records[i], sizeof now) != 0)
            fail(Code::kInvalidValue, "build input ", i,
                 " of an update differs from the build's in numbers of primitives, vertices or "
                 "SBT records, in type, end caps, geometry flags or primitive index offset");
        firstSbt += shapeSbt(inputs, i).numSbtRecords;
        firstPrimitive += shapeCount(inputs, i);
    }
}

} // namespace

MemoryUsage shapeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options) {
    const ShapePlan plan(inputs, options);
    return {plan.outputSize, plan.tempSize, options.allowUpdate ? kUpdateTempSize : 0};
}

void buildShapes(const BuildInputs& inputs, const BuildOptions& options, void* temp,
                 size_t tempSize, void* output, size_t outputSize) {
    const ShapePlan plan(inputs, options);
    checkBuffer("the temporary buffer", temp, tempSize, plan.tempSize);
    checkBuffer("the output buffer", output, outputSize, plan.outputSize);
    inArena([&] {
        ShapeBuild(inputs, options, plan, static_cast<uint8_t*>(temp),
                   static_cast<uint8_t*>(output))
            .run();
    });
}

void checkShapeUpdate(const BuildInputs& inputs, const BuildOptions& options, const void* output,
                      size_t outputSize) {
    const ShapePlan plan(inputs, options);
    if (!isBlock(output))
        fail(Code::kInvalidValue,
             "an update needs an acceleration structure in the output buffer at ", output);
    const BlockHeader& header = *headerOf(output);
    checkSameShape(header, options, BlockType::kShapes, plan.keys, plan.numInputs,
                   plan.numPrimitives);
    if (header.shape != plan.shape)
        fail(Code::kInvalidValue, "an update has another type of build inputs than the build");
    checkBuffer("the output buffer", output, outputSize, header.usedSize);
    checkSameInputs(inputs, header);
}

void updateShapes(const BuildInputs& inputs, const BuildOptions& options, void* temp,
                  size_t tempSize, void* output, size_t outputSize) {
    checkBuffer("the temporary buffer", temp, tempSize, kUpdateTempSize);
    checkShapeUpdate(inputs, options, output, outputSize);
    inArena([&] {
        auto* const block = static_cast<uint8_t*>(output);
        BlockHeader& header = *reinterpret_cast<BlockHeader*>(block);
        const ShapeStore store(block);
        store.read(inputs);
        markBends(store, header.numPrimitives, ShapePlan(inputs, options).pieces);
        measure(block, store);
        header.root = kNoNode;
        if (header.wholeRoot != kNoNode && Fit(block, store, true).run(header.wholeRoot))
            header.root = header.wholeRoot;
    });
}

} // namespace sunstone::bvh
