// SPDX-License-Identifier: Apache-2.0
// First step of a build of instances: their records and boxes, with motion keys a box for each key.
// Bounds of moving objects take many registers. In structures without motion keys, a first kernel
// therefore leaves instances above transforms to a second one. Structures with motion keys have
// another kernel, because it takes a GPU's compiler five times as long.
#pragma once

#include "bvh/gpu/build/motion_references.h"
#include "bvh/gpu/known_handles.h"
#include "bvh/motion/instance_poses.h"

namespace sunstone::bvh::gpu {

// Transforms bounds, with the CPU's margin for the rounding of transformed rays.
SUNSTONE_INLINE Bounds transformBounds(const float m[12], const Bounds& b) {
    Bounds r;
    for (int i = 0; i < 3; ++i) {
        double low = m[4 * i + 3], high = low, size = low < 0 ? -low : low;
        for (int j = 0; j < 3; ++j) {
            const double p = double(m[4 * i + j]) * b.lower[j],
                         q = double(m[4 * i + j]) * b.upper[j];
            low += p < q ? p : q;
            high += p < q ? q : p;
            const double x = p < 0 ? -p : p, y = q < 0 ? -q : q;
            size += x < y ? y : x;
        }
        const double margin = size * 0x1p-20;
        r.lower[i] = float(low - margin);
        r.upper[i] = float(high + margin);
    }
    return r;
}

// ---- tight boxes ------------------------------------------------------------------------------
//
// The box around a rotated box is up to five times as large as the geometry needs, and each
// instance that a ray enters without a hit costs time. The code therefore rotates the boxes of
// nodes two levels below the child's root: up to 64 boxes, which are equal for all instances of a
// child and read from the caches.

// A box as its centre and half size.
struct Part {
    float centre[3], half[3];
};
SUNSTONE_INLINE Part partOf(const float lower[3], const float upper[3]) {
    Part p;
    for (int a = 0; a < 3; ++a) {
        p.centre[a] = mul(0.5f, lower[a]) + mul(0.5f, upper[a]);
        p.half[a] = mul(0.5f, upper[a]) - mul(0.5f, lower[a]);
    }
    return p;
}

// Adds a transformed box.
SUNSTONE_INLINE void addSeen(const float m[12], const Part& part, Bounds& sum) {
#pragma unroll
    for (int i = 0; i < 3; ++i) {
        float centre = m[4 * i + 3], half = 0;
#pragma unroll
        for (int j = 0; j < 3; ++j) {
            centre = fused(m[4 * i + j], part.centre[j], centre);
            half = fused(magnitude(m[4 * i + j]), part.half[j], half);
        }
        sum.lower[i] = smaller(sum.lower[i], sub(centre, half));
        sum.upper[i] = larger(sum.upper[i], add(centre, half));
    }
}

// A node in its memory layout, so that its boxes take five loads in place of one per byte.
struct NodeWords {
    U4 head, children, planes[3];
};
SUNSTONE_INLINE NodeWords loadWords(const WideNode* node) {
    const U4* const words = reinterpret_cast<const U4*>(node);
    return {words[0], words[1], {words[2], words[3], words[4]}};
}
SUNSTONE_INLINE uint32_t wordAt(U4 words, uint32_t i) {
    return i == 0 ? words.x : i == 1 ? words.y : i == 2 ? words.z : words.w;
}
SUNSTONE_INLINE uint32_t planeOf(const NodeWords& node, uint32_t row, uint32_t slot) {
    const uint32_t word = 2 * row + slot / 4;
    return wordAt(node.planes[word / 4], word % 4) >> 8 * (slot % 4) & 0xFFu;
}
SUNSTONE_INLINE uint32_t metaOf(const NodeWords& node, uint32_t slot) {
    return (slot < 4 ? node.children.z : node.children.w) >> 8 * (slot % 4) & 0xFFu;
}
// Converts a byte exactly.
SUNSTONE_INLINE float smallFloat(uint32_t byte) {
    return sub(floatOf(0x4B000000u | byte), 0x1p23f);
}

// The box of a slot; false if it is unused or holds no active primitive.
SUNSTONE_INLINE bool slotBox(const NodeWords& node, uint32_t slot, float lower[3], float upper[3]) {
    bool used = metaOf(node, slot) >> 5 != 0;
#pragma unroll
    for (uint32_t a = 0; a < 3; ++a) {
        const uint32_t low = planeOf(node, a, slot), high = planeOf(node, 3 + a, slot);
        used = used && low <= high;
        const float step = floatOf((node.head.w >> 8 * a & 0xFFu) << 23),
                    origin = floatOf(wordAt(node.head, a));
        lower[a] = add(origin, mul(step, smallFloat(low)));
        upper[a] = add(origin, mul(step, smallFloat(high)));
    }
    return used;
}

// Calls visit(lower, upper) for boxes that cover a structure without motion: those of nodes two
// levels below its root. kUnroll: 1 if the visit is too much code to repeat for each slot.
template <int kUnroll, class Visit>
SUNSTONE_INLINE void forEachPart(const BlockHeader& header, const Visit& visit) {
    const WideNode* const nodes = reinterpret_cast<const WideNode*>(
        reinterpret_cast<const uint8_t*>(&header) + header.nodesOffset);
    const NodeWords root = loadWords(nodes);
    uint32_t child = root.children.x;
    for (uint32_t slot = 0; slot < kSlots; ++slot) {
        float lower[3], upper[3];
        const bool inner = root.head.w >> (24 + slot) & 1u,
                   used = slotBox(root, slot, lower, upper);
        if (inner && used) {
            const NodeWords node = loadWords(nodes + child);
#pragma unroll kUnroll
            for (uint32_t below = 0; below < kSlots; ++below)
                if (slotBox(node, below, lower, upper))
                    visit(lower, upper);
        } else if (used) {
            visit(lower, upper);
        }
        child += inner;
    }
}

SUNSTONE_INLINE bool turns(const float m[12]) {
    for (int i = 0; i < 3; ++i)
        if ((m[4 * i] != 0) + (m[4 * i + 1] != 0) + (m[4 * i + 2] != 0) > 1)
            return true;
    return false;
}

// Instances of one structure tend to be consecutive, so a block caches the parts of its first
// instance's structure.
struct SharedParts {
    uint64_t structure; // its handle; 0: none
    uint32_t count, pad;
    U4 parts[kSlots * kSlots][2]; // centre and half size, two words unused
};
SUNSTONE_INLINE void storePart(const Part& p, U4 to[2]) {
    to[0] = U4{bitsOf(p.centre[0]), bitsOf(p.centre[1]), bitsOf(p.centre[2]), bitsOf(p.half[0])};
    to[1] = U4{bitsOf(p.half[1]), bitsOf(p.half[2]), 0, 0};
}
SUNSTONE_INLINE Part loadPart(const U4 from[2]) {
    const U4 a = from[0], b = from[1];
    return {{floatOf(a.x), floatOf(a.y), floatOf(a.z)}, {floatOf(a.w), floatOf(b.x), floatOf(b.y)}};
}

// All threads of a block must call; the block has at least as many threads as parts.
SUNSTONE_INLINE void shareParts(uint64_t known, uint64_t handle, SharedParts& shared) {
    if (threadIdx.x == 0) {
        const uint64_t tag = handle & devlib::kTagMask;
        shared.structure = 0;
        shared.count = 0;
        if ((tag == devlib::kTagGas || tag == devlib::kTagIas) && handle > devlib::kTagMask &&
            isKnownHandle(knownNow(known), handle)) {
            const BlockHeader& header = *at<const BlockHeader>(handle & ~devlib::kTagMask);
            if (header.magic == kGpuBlockMagic && header.root != kNoNode && !isMoving(header.type))
                shared.structure = handle;
        }
    }
    __syncthreads();
    if (shared.structure && threadIdx.x < kSlots * kSlots) {
        const BlockHeader& header = *at<const BlockHeader>(handle & ~devlib::kTagMask);
        const WideNode* const nodes =
            at<const WideNode>((handle & ~devlib::kTagMask) + header.nodesOffset);
        const uint32_t slot = threadIdx.x / kSlots, below = threadIdx.x % kSlots;
        const NodeWords root = loadWords(nodes);
        const uint32_t mask = root.head.w >> 24;
        float lower[3], upper[3];
        bool used = slotBox(root, slot, lower, upper);
        if (used && (mask >> slot & 1u))
            used = slotBox(
                loadWords(nodes + root.children.x + uint32_t(__popc(mask & lanesBelow(slot)))),
                below, lower, upper);
        else
            used = used && below == 0;
        if (used)
            storePart(partOf(lower, upper), shared.parts[atomicAdd(&shared.count, 1u)]);
    }
    __syncthreads();
}

// Shrinks `box` to the union of transformed nodes, with a margin.
SUNSTONE_INLINE void shrink(Bounds& box, const Bounds& sum, const float margin[3]) {
    for (int i = 0; i < 3; ++i) {
        const float low = sub(sum.lower[i], margin[i]), high = add(sum.upper[i], margin[i]);
        if (!(low <= high)) // overflow
            continue;
        box.lower[i] = larger(box.lower[i], low);
        box.upper[i] = smaller(box.upper[i], high);
    }
}

// Shrinks `box`, which contains the transformed structure, to the union of its transformed nodes.
// An additional margin over transformBounds() covers the rounding of their sums.
template <int kUnroll>
SUNSTONE_INLINE void tighten(const float m[12], uint64_t handle, const SharedParts* shared,
                             Bounds& box) {
    const BlockHeader& header = *at<const BlockHeader>(handle & ~devlib::kTagMask);
    if (isMoving(header.type) || !turns(m))
        return;
    Bounds sum = emptyBounds();
    if (shared && shared->structure == handle)
        for (uint32_t i = 0; i < shared->count; ++i)
            addSeen(m, loadPart(shared->parts[i]), sum);
    else
        forEachPart<kUnroll>(header, [&](const float lower[3], const float upper[3]) {
            addSeen(m, partOf(lower, upper), sum);
        });
    float margin[3];
    for (int i = 0; i < 3; ++i) {
        float size = magnitude(m[4 * i + 3]);
        for (int j = 0; j < 3; ++j)
            size = add(size, mul(magnitude(m[4 * i + j]),
                                 larger(magnitude(header.lower[j]), magnitude(header.upper[j]))));
        margin[i] = mul(size, 0x1p-19f);
    }
    shrink(box, sum, margin);
}

// As tighten(), for a structure below transforms that childBounds() has checked.
SUNSTONE_INLINE void tightenMoving(const float m[12], uint64_t child, Bounds& box) {
    const moving::Poses poses(m, child);
    const uint64_t structure = poses.structure();
    if (structure == 0)
        return;
    const BlockHeader& header = *at<const BlockHeader>(structure & ~devlib::kTagMask);
    if (isMoving(header.type))
        return;
    Bounds sum = emptyBounds();
    float margin[3];
    const bool known = poses.forEach(header.lower, header.upper, margin, [&](const float pose[12]) {
        forEachPart<1>(header, [&](const float lower[3], const float upper[3]) {
            addSeen(pose, partOf(lower, upper), sum);
        });
    });
    if (known)
        shrink(box, sum, margin);
}

// The most transforms in a row; equals the limit of traversal (devlib/gpu/launch_block.h).
constexpr uint32_t kMaxChain = 30;

enum class Child : uint32_t { kNothing, kSomething, kLater };

// Whether a child may be read. Reports the first child that may not to the host.
SUNSTONE_INLINE bool leadsSomewhere(const BuildJob& job, uint64_t handle) {
    if (isKnownHandle(knownNow(job.known), handle))
        return true;
    if (handle != 0 && atomicExch(&countersOf(job).unknownChildren, 1u) == 0)
        reportFailure(job.report, job.output, kUnknownChild);
    return false;
}

// Bounds, at all times, of an instance's child. Without kMotion, children behind transforms are
// left to a later kernel.
template <bool kMotion>
SUNSTONE_INLINE Child childBounds(const BuildJob& job, uint64_t handle, const SharedParts* shared,
                                  Bounds& box) {
    uint64_t chain[kMaxChain];
    uint32_t length = 0;
    if (!(shared && shared->structure == handle) && !leadsSomewhere(job, handle))
        return Child::kNothing;
    while (isTransformTag(handle & devlib::kTagMask) && length < kMaxChain) {
        if (handle <= devlib::kTagMask)
            return Child::kNothing;
        if (!kMotion)
            return Child::kLater;
        chain[length++] = handle;
        handle = childOf(handle);
        if (!leadsSomewhere(job, handle))
            return Child::kNothing;
    }
    const uint64_t tag = handle & devlib::kTagMask;
    if ((tag != devlib::kTagGas && tag != devlib::kTagIas) || handle <= devlib::kTagMask)
        return Child::kNothing;
    const BlockHeader& header = *at<const BlockHeader>(handle & ~devlib::kTagMask);
    if (header.magic != kGpuBlockMagic || header.root == kNoNode)
        return Child::kNothing;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = header.lower[a];
        box.upper[a] = header.upper[a];
    }
    while (kMotion && length-- > 0) {
        const uint64_t transform = chain[length];
        if ((transform & devlib::kTagMask) == devlib::kTagStatic) {
            box = transformBounds(
                at<const StaticTransform>(transform & ~devlib::kTagMask)->transform, box);
        } else {
            const KeyBounds all = moving::atAllTimes(transform, box.lower, box.upper);
            for (int a = 0; a < 3; ++a) {
                box.lower[a] = all.lower[a];
                box.upper[a] = all.upper[a];
            }
        }
    }
    return Child::kSomething;
}

SUNSTONE_INLINE bool isUsable(const Bounds& box) {
    bool good = true;
    for (int a = 0; a < 3; ++a)
        good = good && isUsable(box.lower[a]) && isUsable(box.upper[a]) &&
               box.lower[a] <= box.upper[a];
    return good;
}

// Clamps a box to the range of finite coordinates; false if nothing remains, or a plane is NaN.
SUNSTONE_INLINE bool endBox(Bounds& box) {
    bool good = true;
    for (int a = 0; a < 3; ++a) {
        if (box.lower[a] < -kLargestCoordinate)
            box.lower[a] = -kLargestCoordinate;
        if (box.upper[a] > kLargestCoordinate)
            box.upper[a] = kLargestCoordinate;
        good = good && box.lower[a] <= box.upper[a];
    }
    return good;
}

// Values of the member `pad` of an instance's record, between the two kernels.
constexpr uint32_t kLeftForLater = 1;

// The caller's description of an instance: its address, or 0 if invalid.
SUNSTONE_INLINE uint64_t addressOfInstance(const BuildJob& job, uint32_t index) {
    const DeviceInput& input = *at<const DeviceInput>(job.inputs);
    const uint64_t address = input.areAddresses
                                 ? *at<const uint64_t>(input.data + 8 * uint64_t(index))
                                 : input.data + uint64_t(index) * input.stride;
    return address % 16 == 0 ? address : 0;
}
SUNSTONE_INLINE void shareParts(const BuildJob& job, uint32_t index, SharedParts& shared) {
    const uint64_t address = addressOfInstance(job, index);
    shareParts(job.known, address ? at<const InstanceDesc>(address)->traversableHandle : 0, shared);
}

SUNSTONE_INLINE void storeRows(const float m[12], U4 to[3]) {
    for (int i = 0; i < 3; ++i)
        to[i] =
            U4{bitsOf(m[4 * i]), bitsOf(m[4 * i + 1]), bitsOf(m[4 * i + 2]), bitsOf(m[4 * i + 3])};
}

// Writes the record of an instance; false if it is inactive or left for later, else its box, at all
// times.
template <bool kMotion>
SUNSTONE_INLINE bool describeInstance(const BuildJob& job, uint32_t index,
                                      const SharedParts* shared, Bounds& box) {
    const DeviceInput& input = *at<const DeviceInput>(job.inputs);
    const uint64_t address = addressOfInstance(job, index);
    InstanceRecord& to = at<InstanceRecord>(job.instances)[index];
    if (address == 0) {
        to = {};
        to.index = index;
        return false;
    }
    // In units of 16 bytes, because records are contiguous.
    const U4* const from = at<const U4>(address);
    const U4 words = from[3], handle = from[4];
    const uint64_t child = uint64_t(handle.y) << 32 | handle.x;
    const uint32_t mask = words.z, flags = words.w;
    float m[12], inverse[12];
#pragma unroll
    for (int i = 0; i < 3; ++i)
#pragma unroll
        for (int j = 0; j < 4; ++j)
            m[4 * i + j] = flags & input.identityFlag ? (i == j ? 1.0f : 0.0f)
                                                      : floatOf(wordAt(from[i], uint32_t(j)));
    const bool invertible = math::invert(m, inverse);
    U4* const rows = reinterpret_cast<U4*>(&to);
    storeRows(m, rows);
    storeRows(inverse, rows + 3);
    rows[6] = U4{handle.x, handle.y, words.x, words.y};
    rows[7] = U4{mask, flags & input.knownFlags & ~input.identityFlag, index, 0};
    if (!invertible || (mask & 0xFF) == 0)
        return false;
    const Child found = childBounds<kMotion>(job, child, shared, box);
    if (found == Child::kLater)
        to.pad = kLeftForLater;
    if (found != Child::kSomething)
        return false;
    box = transformBounds(m, box);
    const uint64_t tag = child & devlib::kTagMask;
    if (tag == devlib::kTagGas || tag == devlib::kTagIas)
        tighten<kMotion ? 1 : int(kSlots)>(m, child, shared, box);
    else if constexpr (kMotion)
        tightenMoving(m, child, box);
    return endBox(box);
}

// Boxes of an instance at the keys, unpadded; empty if the instance is inactive.
SUNSTONE_INLINE KeyBounds* keyBoxesOf(const BuildJob& job, uint32_t index) {
    return at<KeyBounds>(job.keyBoxes) + uint64_t(index) * job.motionKeys;
}
SUNSTONE_INLINE Bounds boundsOf(const KeyBounds& from) {
    Bounds box;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = from.lower[a];
        box.upper[a] = from.upper[a];
    }
    return box;
}

// An instance's boxes in nodes: the boxes of keyBoxesOf(), or tighter ones, which do not affect
// emitted bounds.
SUNSTONE_INLINE KeyBounds* tightBoxesOf(const BuildJob& job, uint32_t index) {
    return keyBoxesOf(job, job.numPrimitives + index);
}

// The parts of an instance's bounds (moving::describeParts): the parts of a structure without
// motion, or the whole structure. One type for both, so that the code is compiled once.
struct InstanceParts {
    const BlockHeader* structure; // null: all at once

    template <class Add>
    __device__ void operator()(const Add& add) const {
        if (!structure)
            return add(nullptr);
        forEachPart<1>(*structure, [&](const float lower[3], const float upper[3]) {
            const LinearBounds part = moving::standing(lower, upper);
            add(&part);
        });
    }
};
SUNSTONE_INLINE void describeMoving(const BuildJob& job, const InstanceRecord& record,
                                    const BlockHeader* parts, KeyBounds* keys) {
    moving::describeParts(record, {job.motionKeys, job.motionBegin, job.motionEnd}, keys,
                          InstanceParts{parts});
}

// Tightens the boxes of motion transforms above a structure without motion to the united bounds of
// its parts. Boxes that are valid between keys cannot be intersected at the keys, so the tighter of
// the two sets is taken whole.
SUNSTONE_INLINE void tightenAtKeys(const BuildJob& job, uint32_t index) {
    const KeyBounds* const keys = keyBoxesOf(job, index);
    KeyBounds* const tight = tightBoxesOf(job, index);
    const InstanceRecord& record = at<InstanceRecord>(job.instances)[index];
    uint64_t handle = record.child;
    while (isTransformTag(handle & devlib::kTagMask)) // childBounds() has checked the chain
        handle = childOf(handle);
    const BlockHeader& header = *at<const BlockHeader>(handle & ~devlib::kTagMask);
    float area = 0, tightArea = __builtin_inff();
    if (!isMoving(header.type) && moving::moves(record.child)) {
        describeMoving(job, record, &header, tight);
        tightArea = 0;
    }
    bool usable = true;
    for (uint32_t k = 0; k < job.motionKeys; ++k) {
        area = add(area, halfArea(boundsOf(keys[k])));
        tightArea = add(tightArea, halfArea(boundsOf(tight[k])));
        usable = usable && isUsable(boundsOf(tight[k]));
    }
    if (!usable || !(tightArea < area))
        for (uint32_t k = 0; k < job.motionKeys; ++k)
            tight[k] = keys[k];
}

// Fills the boxes at the keys, which also contain the instance between the keys
// (bvh/motion/motion_bounds.h), and sums up the boxes for nodes. `box` is the box for all times.
SUNSTONE_INLINE bool describeAtKeys(const BuildJob& job, uint32_t index, const Bounds& box,
                                    Bounds& exact, KeySum& sum) {
    KeyBounds* const keys = keyBoxesOf(job, index);
    const InstanceRecord& record = at<InstanceRecord>(job.instances)[index];
    if (moving::moves(record.child)) {
        describeMoving(job, record, nullptr, keys);
    } else {
        for (uint32_t k = 0; k < job.motionKeys; ++k)
            for (int a = 0; a < 3; ++a) {
                keys[k].lower[a] = box.lower[a];
                keys[k].upper[a] = box.upper[a];
            }
    }
    bool active = true;
    for (uint32_t k = 0; k < job.motionKeys; ++k) {
        Bounds atKey = boundsOf(keys[k]);
        active = active && endBox(atKey);
        for (int a = 0; a < 3; ++a) {
            keys[k].lower[a] = atKey.lower[a];
            keys[k].upper[a] = atKey.upper[a];
        }
        exact = unite(exact, atKey);
    }
    if (!active)
        return false;
    tightenAtKeys(job, index);
    for (uint32_t k = 0; k < job.motionKeys; ++k)
        addKey(sum, boundsOf(tightBoxesOf(job, index)[k]));
    return true;
}

// The instances that a kernel reads: in a structure without motion keys, those without (kStill) or
// with (kMotion) motion transforms; in a structure with motion keys, all (kKeys).
enum class Way { kStill, kMotion, kKeys };

// Reads an instance: its record and boxes. False if it is inactive or left for later, else `exact`
// are its bounds at all times.
template <Way kWay>
SUNSTONE_INLINE bool readInstance(const BuildJob& job, uint32_t index, const SharedParts* shared,
                                  Bounds& exact) {
    exact = emptyBounds();
    bool active = describeInstance < kWay != Way::kStill > (job, index, shared, exact);
    if (kWay == Way::kStill && at<const InstanceRecord>(job.instances)[index].pad == kLeftForLater)
        countersOf(job).leftInstances = 1;
    Bounds box = exact;
    if constexpr (kWay == Way::kKeys) {
        KeySum sum = noKeys();
        Bounds all = emptyBounds();
        active = active && describeAtKeys(job, index, exact, all, sum);
        for (uint32_t k = 0; k < job.motionKeys && !active; ++k)
            keyBoxesOf(job, index)[k] = tightBoxesOf(job, index)[k] = kNoBounds;
        exact = all;
        box = meanOf(sum, job.motionKeys);
    }
    storeBox(job, index, active, box);
    return active;
}

constexpr uint32_t kInstanceThreads = 128;

// For builds and updates. In an update the records of instances are those in the structure, and
// nodes get their parents.
SUNSTONE_INLINE bool mayReadInstances(BuildJob& job) {
    if (countersOf(job).failure)
        return false;
    if (job.expected) {
        job = inStructure(job);
        linkNodes(job);
    }
    return true;
}

SUNSTONE_KERNEL __launch_bounds__(kInstanceThreads, 6) sunstone_instances(BuildJob job) {
    __shared__ SharedParts shared;
    if (!mayReadInstances(job))
        return;
    shareParts(job, blockIdx.x * blockDim.x, shared);
    Bounds found = emptyBounds();
    uint32_t numActive = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        Bounds exact;
        if (readInstance<Way::kStill>(job, i, &shared, exact)) {
            found = unite(found, exact);
            ++numActive;
        }
    }
    countReferences(job, found, numActive);
}

template <Way kWay>
SUNSTONE_INLINE void readMovingInstances(BuildJob& job) {
    if (!mayReadInstances(job))
        return;
    Bounds found = emptyBounds();
    uint32_t numActive = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        Bounds exact;
        const bool isOurs =
            kWay == Way::kKeys || at<const InstanceRecord>(job.instances)[i].pad == kLeftForLater;
        if (isOurs && readInstance<kWay>(job, i, nullptr, exact)) {
            found = unite(found, exact);
            ++numActive;
        }
    }
    countReferences(job, found, numActive);
}

// Reads the instances that sunstone_instances leaves for later.
SUNSTONE_KERNEL sunstone_left_instances(BuildJob job) {
    if (countersOf(job).leftInstances)
        readMovingInstances<Way::kMotion>(job);
}

SUNSTONE_KERNEL sunstone_moving_instances(BuildJob job) {
    readMovingInstances<Way::kKeys>(job);
}

} // namespace sunstone::bvh::gpu
