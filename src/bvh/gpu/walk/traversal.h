// SPDX-License-Identifier: Apache-2.0
// The traversal loop on GPUs, a template over the handling of primitives. It compiles as CUDA, as
// freestanding C++ for nvptx64 and for the CPU, and is meant to be inlined into the caller: all
// state of a ray is in registers but for the stack, an array of the caller.
//
//   struct Programs {
//       // The kinds that rays may meet; code for others compiles away.
//       static constexpr bool kTriangles, kCustoms, kInstances, kMotion;
//       static constexpr unsigned kLevels; // instances and transforms on a path
//       // A candidate at tmin <= t <= ray.tmax. It counts by setting ray.tmax = hit.t; of equal t
//       // the lower primitive should win (the CPU's rule). `primitive`, `sbt`: of TriangleRecord.
//       Visit triangle(Ray& ray, const TriangleHit& hit, uint32_t primitive, uint32_t sbt);
//       Visit custom(Ray& ray, uint32_t primitive, uint32_t sbt); // runs an intersection program
//       static uint32_t shapes(); // ShapeBits of the curves and spheres that may be met
//       bool meets(uint32_t shape) const; // one of these, in this launch
//       Visit shape(Ray& ray, const ShapeHit& hit); // as triangle()
//       // Before the child of an instance or of a transform in the caller's memory (its handle,
//       // tag included) is entered: false skips it. Transforms fill world-to-object of this level.
//       bool enterInstance(Ray& ray, const InstanceRecord& instance, uint64_t& child);
//       bool enterTransform(Ray& ray, uint64_t handle, uint64_t& child, float worldToObject[12]);
//       // Leaves the level entered last; ray.origin and direction are those of the outer space
//       // again. With kMotion an instance and the transforms below it at once: `count` of them.
//       void leave(Ray& ray);
//       void leave(Ray& ray, uint32_t count);
//       static uint32_t lanes(); // of the warp that run this together
//       bool mayReorder() const; // programs see the same in any order of primitives
//       // With kInstances: whether a lane that wants to enter an instance may do so now.
//       static bool mayEnter(bool wants);
//       // With kInstances and kCustoms: whether a lane with a custom primitive may test it now. If
//       // each lane wants to enter an instance or to test a custom primitive, one of the two
//       // functions must let some lanes go on.
//       bool mayIntersect(bool wants) const;
//       // With curves: whether a lane that wants to test a piece of one may do so now.
//       bool mayTest(bool wants);
//       bool waitsLong(); // with pieces of curves: lanes test one primitive in a step
//       static bool any(bool value); // with that and kMotion: for any lane that runs this together
//       bool nearestFirst() const; // whether the nearest hit is wanted, not any hit
//       float time() const;  // with kMotion
//       static bool meetsKeys(); // with kMotion: structures with motion keys may be met
//       void refuseMotion(); // without kMotion: met motion; if it returns, it is skipped
//       // With kInstances: more levels than kLevels, to which the handle leads, or than the stack
//       // can hold; if they return, the child is skipped.
//       void refuseLevel(uint64_t handle);
//       void refuseStack();
//       // Optional: whether the ray has ended while a handle was entered, which enterTransform()
//       // then refuses. Handles may then be of instances outside structures, and of VisitNodes.
//       bool endsInVisits() const;
//   };
//
//   Traversal<Programs> traversal;
//   U2 stack[Traversal<Programs>::kStackSize];
//   Traversal<Programs>::Level levels[Programs::kLevels + 1];
//   if (traversal.start(programs, ray, handle, levels))
//       traversal.run(programs, ray, stack, levels, RunToEnd());
//
// Handles must point to readable memory (known_handles.h); its contents are checked.
#pragma once

#include "base/inline.h"
#include "bvh/gpu/build/shared_records.h"
#include "bvh/gpu/walk/motion_traversal.h"
#include "bvh/gpu/walk/ray_shapes.h"
#include "bvh/gpu/walk/ray_triangle.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

enum class Visit : uint32_t { kContinue, kEnd };

// Bases for Programs without curves and spheres, without motion, or that run alone.
struct NoShapes {
    static SUNSTONE_INLINE_MEMBER uint32_t shapes() { return 0; }
    SUNSTONE_INLINE_MEMBER bool meets(uint32_t) const { return false; }
    SUNSTONE_INLINE_MEMBER Visit shape(Ray&, const ShapeHit&) { return Visit::kContinue; }
};
struct NoMotion {
    static constexpr bool kMotion = false;
    static SUNSTONE_INLINE_MEMBER bool meetsKeys() { return false; }
    SUNSTONE_INLINE_MEMBER float time() const { return 0; }
    SUNSTONE_INLINE_MEMBER void refuseMotion() {}
};
struct OneLane {
    static SUNSTONE_INLINE_MEMBER uint32_t lanes() { return 1; }
    static SUNSTONE_INLINE_MEMBER bool mayReorder() { return false; }
    static SUNSTONE_INLINE_MEMBER bool mayEnter(bool wants) { return wants; }
    static SUNSTONE_INLINE_MEMBER bool mayTest(bool wants) { return wants; }
    static SUNSTONE_INLINE_MEMBER bool waitsLong() { return false; }
    static SUNSTONE_INLINE_MEMBER bool mayIntersect(bool wants) { return wants; }
    static SUNSTONE_INLINE_MEMBER bool any(bool value) { return value; }
};
// Base for graphs whose depth is known to fit.
struct NoDeepGraphs {
    SUNSTONE_INLINE_MEMBER void refuseLevel(uint64_t) {}
    SUNSTONE_INLINE_MEMBER void refuseStack() {}
};

SUNSTONE_INLINE void transformRay(const float m[12], const float origin[3],
                                  const float direction[3], Ray& to) {
    for (int i = 0; i < 3; ++i) {
        const float *row = m + 4 * i, *o = origin, *d = direction;
        to.origin[i] =
            add(add(add(mul(row[0], o[0]), mul(row[1], o[1])), mul(row[2], o[2])), row[3]);
        to.direction[i] = add(add(mul(row[0], d[0]), mul(row[1], d[1])), mul(row[2], d[2]));
    }
}

// A policy for the end of run(), here only at the end of the traversal.
struct RunToEnd {
    SUNSTONE_INLINE_MEMBER bool stop() const { return false; }
};

// The state to restore when an instance or transform is left, in units of one memory access.
struct OnlyLevel {
    U4 origin;      // and the first reciprocal
    U4 direction;   // and the second
    U4 box;         // the third; slack, octant and one
    U4 places;      // of nodes and records
    uint64_t block; // 0 above a transform
};
struct MovingLevel : OnlyLevel {
    U4 motion; // of the MotionPlace all but the number of keys
    uint32_t keys;
    uint32_t around; // see Levels
};
// With many levels, memory limits the traversal, so a level stores only the ray and the block.
// Everything else is recomputed from the block's header.
struct Level {
    U4 origin;    // and the low word of the block
    U4 direction; // and the high word
};

// A traversal's data about levels.
template <bool kMotion, unsigned kLevels>
struct Levels {
    using Level = gpu::Level;
};
template <>
struct Levels<false, 1> {
    using Level = OnlyLevel;
};
template <unsigned kLevels>
struct Levels<true, kLevels> {
    using Level = MovingLevel;
    uint32_t around; // the level of the outer space
};

SUNSTONE_INLINE U4 withFloats(const float v[3], float w) {
    return {bitsOf(v[0]), bitsOf(v[1]), bitsOf(v[2]), bitsOf(w)};
}
SUNSTONE_INLINE void toFloats(U4 from, float v[3]) {
    v[0] = floatOf(from.x), v[1] = floatOf(from.y), v[2] = floatOf(from.z);
}
SUNSTONE_INLINE uint64_t wordsOf(uint32_t low, uint32_t high) {
    return uint64_t(high) << 32 | low;
}

template <class Programs>
struct Traversal : Levels<Programs::kMotion, Programs::kLevels> {
    // The stack has room for kDeepLevels structures of the largest depth. Graphs with more levels
    // use the room that shallower structures leave; a child without room is skipped (refuseStack).
    // An entry is a group, or 0, 0 at the end of a space.
    static constexpr unsigned kDeepLevels = Programs::kLevels < 15 ? Programs::kLevels : 15;
    static constexpr unsigned kStackSize =
        (Programs::kInstances ? kWaitingChildren + 8 : kWaitingLeaves) +
        kStackEntries * (kDeepLevels + 1);
    // Levels have only the ray and its block.
    static constexpr bool kKeepsRays = Programs::kLevels > 1 && !Programs::kMotion;
    // Instances are entered only from the ray's first space, which is therefore stored once.
    static constexpr bool kKeepsSpace = Programs::kLevels == 1 && !Programs::kMotion;
    // Otherwise the space of a structure of instances is stored when the structure is entered, not
    // for each of its instances. With motion, transforms have no levels.
    using Level = typename Levels<Programs::kMotion, Programs::kLevels>::Level;

    Group inner, leaf;
    uint32_t top;
    uint32_t depth;
    const BlockHeader* block;
    BlockType kind; // of the block, cached for primitives
    uint32_t shape; // of a block of curves or spheres
    const U4* nodes;
    const uint8_t* records;
    BoxRay box;
    Shear shear;
    lane::RaySpace space; // in structures of curves and spheres
    uint32_t piece;       // of a curve, to be tested: the ray meets its capsule; or kNoPiece
    MotionPlace motion;   // with kMotion

    // Starts at a handle (with its tag). False: nothing to visit.
    SUNSTONE_INLINE_MEMBER bool start(Programs& programs, Ray& ray, uint64_t handle,
                                      Level* levels) {
        inner = leaf = {0, 0};
        top = depth = 0;
        piece = kNoPiece;
        block = nullptr;
        if constexpr (Programs::kMotion) {
            this->around = 0;
            if constexpr (Programs::kLevels > 1) { // the end of the range of isInside()
                levels[0].block = 0;
                levels[0].around = 0;
            }
        }
        if constexpr (Programs::kInstances)
            if (isTransform(handle)) {
                float worldToObject[12];
                if (!openTransform(programs, ray, worldToObject, handle, levels, 0) ||
                    !moveDown(programs, ray, worldToObject, handle, levels, 0))
                    return false;
            }
        if (!enterBlock(programs, ray, handle, levels, 0))
            return false;
        if constexpr (kKeepsSpace)
            saveSpace(ray, levels[depth]);
        return true;
    }

    // Visits until the end (true), or until Policy::stop() returns true after a step (false).
    template <class Policy>
    SUNSTONE_INLINE_MEMBER bool run(Programs& programs, Ray& ray, U2* stack, Level* levels,
                                    Policy policy) {
        for (;;) {
            if (step(programs, ray, stack, levels))
                return true;
            if (policy.stop())
                return false;
        }
    }

    // Visits a node, or the rest of a leaf, and primitives found there. True at the end.
    SUNSTONE_INLINE_MEMBER bool step(Programs& programs, Ray& ray, U2* stack, Level* levels) {
        bool end = false;
        if (meetsPieces() && finishPiece(programs, ray, stack, end))
            return end;
        if constexpr (Programs::kInstances)
            return stepInGraph(programs, ray, stack, levels);
        if (meetsPieces())
            return stepInCurves(programs, ray, stack);
        if (leaf.bits == 0)
            openNext(programs, ray, stack);
        // If nearly all lanes of the warp have finished their leaves, they go on to their next
        // nodes, and the rest of a leaf waits: on the stack, or with its lane if programs could
        // notice another order of primitives. Leaves have 1 to 24 primitives; without this rule,
        // tests of long thin triangles ran for 3.5 of 32 lanes.
        const uint32_t few = (5 * Programs::lanes() + 8) / 16;
        while (leaf.bits != 0) {
            if (visitNext(programs, ray))
                return true;
            if (leaf.bits == 0 || Programs::lanes() >= few)
                continue;
            if (!programs.mayReorder() || top >= kWaitingLeaves)
                break;
            push(stack, leaf);
            leaf.bits = 0;
        }
        // This has no branch, because compilers turn a branch here into a loop of the lanes that
        // need no other group, and lanes that take a group from the stack then wait for the end of
        // that loop.
        const bool empty = inner.bits <= 0x00FFFFFFu && leaf.bits == 0;
        if (empty && top == 0)
            return true;
        top -= empty;
        const U2 entry = stack[top]; // the stack always has room
        inner.base = empty ? entry.x : inner.base;
        inner.bits = empty ? entry.y : inner.bits;
        return false;
    }

private:
    // Testing a piece of a curve takes longer than a node, and few lanes reach a piece at the same
    // time. The other lanes therefore continue until enough lanes have a piece.
    static SUNSTONE_INLINE_MEMBER bool meetsPieces() { return Programs::shapes() & kMeetsCurves; }

    // Whether structures may have motion keys.
    static SUNSTONE_INLINE_MEMBER bool hasKeys() {
        return Programs::kMotion && Programs::meetsKeys();
    }
    SUNSTONE_INLINE_MEMBER MotionPlace place() const {
        return hasKeys() ? motion : MotionPlace{1, 0, 1, 0, 0};
    }
    // The index of a primitive's record for the present key.
    SUNSTONE_INLINE_MEMBER uint64_t placeOf(uint32_t record) const {
        return hasKeys() ? uint64_t(record) * motion.keys : record;
    }

    SUNSTONE_INLINE_MEMBER const U4* curveAt(uint32_t record) const {
        return reinterpret_cast<const U4*>(records + placeOf(record) * sizeof(CurveRecord));
    }

    // True if the step is over; `end`: so is the traversal.
    SUNSTONE_INLINE_MEMBER bool finishPiece(Programs& programs, Ray& ray, const U2* stack,
                                            bool& end) {
        if (programs.mayTest(piece != kNoPiece)) {
            ShapeHit hit;
            const U4* const curve = curveAt(piece);
            piece = kNoPiece;
            end = testCurve<Programs::kMotion>(Programs::shapes(), block, shape, curve, place(),
                                               space, ray.tmax, hit) &&
                  programs.shape(ray, hit) == Visit::kEnd;
            if (!end && leaf.bits == 0)
                end = pop(ray, stack);
            return true;
        }
        return piece != kNoPiece;
    }

    SUNSTONE_INLINE_MEMBER bool stepInCurves(Programs& programs, Ray& ray, U2* stack) {
        if (leaf.bits == 0)
            openNext(programs, ray, stack);
        while (leaf.bits != 0 && piece == kNoPiece)
            if (visitNext(programs, ray))
                return true;
        return piece == kNoPiece && pop(ray, stack);
    }

    static constexpr uint32_t kVisits = 2;

    // With instances, lanes of a warp have different kinds of work at the same time: lanes with
    // many primitives leave some for the next step, while other lanes visit nodes.
    SUNSTONE_INLINE_MEMBER bool stepInGraph(Programs& programs, Ray& ray, U2* stack,
                                            Level* levels) {
        if ((inner.bits | leaf.bits) == 0) {
            leaveSpace(programs, ray, levels);
            if (pop(ray, stack))
                return true;
            if (Programs::kLevels > 1 && (inner.bits | leaf.bits) == 0)
                return false; // next the space is left
        }
        if (Programs::mayEnter(leaf.bits != 0 && kind == BlockType::kInstances)) {
            const uint32_t place = nextPlace();
            leaf.bits &= ~(1u << place);
            visitInstance(programs, ray, leaf.base + place, stack, levels);
            if constexpr (requires { programs.endsInVisits(); })
                if (programs.endsInVisits())
                    return true;
        }
        if (leaf.bits == 0)
            openNext(programs, ray, stack);
        const uint32_t visits = programs.waitsLong() ? 1 : kVisits;
        const bool waits = waitsWithCustom(programs);
        if (kind != BlockType::kInstances && !waits)
            for (uint32_t i = 0; leaf.bits != 0 && i < visits; ++i) {
                if (visitNext(programs, ray))
                    return true;
                if (meetsPieces() && piece != kNoPiece)
                    return false;
            }
        return pop(ray, stack);
    }

    // Intersection programs take longer than a node, and few lanes reach one at the same time.
    SUNSTONE_INLINE_MEMBER bool waitsWithCustom(const Programs& programs) const {
        if constexpr (!Programs::kCustoms)
            return false;
        const bool wants = leaf.bits != 0 && kind == BlockType::kCustom;
        const bool may = programs.mayIntersect(wants); // all lanes vote
        return wants && !may;
    }

    SUNSTONE_INLINE_MEMBER bool visitNext(Programs& programs, Ray& ray) {
        const uint32_t place = uint32_t(__builtin_ctz(leaf.bits));
        leaf.bits &= leaf.bits - 1;
        return visit(programs, ray, leaf.base + place);
    }

    // Takes the next group from the stack if the present one is empty; true at the end.
    SUNSTONE_INLINE_MEMBER bool pop(const Ray& ray, const U2* stack) {
        bool search = inner.bits <= 0x00FFFFFFu && leaf.bits == 0, end = false;
        while (search) {
            end = top == 0;
            search = false;
            if (!end) {
                const U2 entry = stack[--top];
                if (!isChild(entry)) {
                    inner = {entry.x, entry.y};
                } else if (floatOf(entry.y & ~7u) <= ray.tmax) {
                    take(entry);
                } else {
                    top -= entry.x >> 28 & 7u;
                    search = true;
                }
            }
        }
        return end;
    }

    // Children of nodes of instances are visited nearest first, because nodes overlap and instances
    // behind a hit need not be entered. Each waiting child is a stack entry: index | number of
    // farther ones of the node below it << 28 | 1 << 31; distance, lowest bit set for an instance.
    static SUNSTONE_INLINE_MEMBER bool isChild(U2 entry) { return entry.x >> 31; }
    SUNSTONE_INLINE_MEMBER void take(U2 entry) {
        const uint32_t index = entry.x & 0x0FFFFFFFu;
        const bool instance = entry.y & 1u;
        inner = {index, instance ? 0u : 1u << 24}; // a group of one
        leaf = {index, instance ? 1u : 0u};
    }
    SUNSTONE_INLINE_MEMBER void takeNearest(Distances<true>& distances, U2* stack) {
        distances.sort();
        const uint32_t innerMask = inner.bits & 0xFFu, childBase = inner.base,
                       primitiveBase = leaf.base;
        const auto entryOf = [&](uint32_t i, uint32_t farther) {
            const uint32_t key = distances.keys[i], slot = key & 7u;
            const bool isInner = innerMask >> slot & 1u;
            const uint32_t before = uint32_t(__builtin_popcount(innerMask & ~(~0u << slot)));
            const uint32_t place = permute(distances.metas[0], distances.metas[1], slot) & 31u;
            return U2{(isInner ? childBase + before : primitiveBase + place) | farther << 28 |
                          1u << 31,
                      (key & ~7u) | (isInner ? 0u : 1u)};
        };
        uint32_t farther = 0;
#pragma unroll
        for (uint32_t i = 7; i > 0; --i)
            if (distances.keys[i] != Distances<true>::kMissed)
                stack[top++] = entryOf(i, farther++);
        if (distances.keys[0] != Distances<true>::kMissed)
            take(entryOf(0, 0));
        else
            inner.bits = leaf.bits = 0;
    }

    // Makes the next child of the group the group, or makes a group of primitives the leaf.
    SUNSTONE_INLINE_MEMBER void openNext(const Programs& programs, const Ray& ray, U2* stack) {
        if (inner.bits <= 0x00FFFFFFu) {
            leaf = inner;
            inner.bits = 0;
            return;
        }
        const uint32_t bit = 31 - uint32_t(__builtin_clz(inner.bits));
        const uint32_t slot = slotOf(box.octant, bit - 24);
        const uint32_t child =
            inner.base + uint32_t(__builtin_popcount(inner.bits & 0xFFu & ~(~0u << slot)));
        inner.bits &= ~(1u << bit);
        if (inner.bits > 0x00FFFFFFu)
            push(stack, inner);
        test(programs, ray, child, stack);
    }

    // Primitives are listed by slot, and the highest bit of a slot is the side along z. Instances
    // behind a hit need not be entered.
    SUNSTONE_INLINE_MEMBER uint32_t nextPlace() const {
        return (box.octant & 4u) == 0 ? 31 - uint32_t(__builtin_clz(leaf.bits))
                                      : uint32_t(__builtin_ctz(leaf.bits));
    }

    SUNSTONE_INLINE_MEMBER void push(U2* stack, Group group) {
        stack[top++] = U2{group.base, group.bits};
    }

    SUNSTONE_INLINE_MEMBER void test(const Programs& programs, const Ray& ray, uint32_t child,
                                     U2* stack) {
        constexpr uint32_t kUnits = sizeof(WideNode) / 16;
        const float tmin = larger(ray.tmin, 0.0f);
        Distances<Programs::kInstances> distances;
        if (someMove())
            testMovingNode(nodes + uint64_t(child) * motion.keys * kUnits, motion, ray.origin, box,
                           tmin, ray.tmax, inner, leaf, distances);
        else
            testNode(nodes + uint64_t(child) * kUnits, ray.origin, box, tmin, ray.tmax, inner, leaf,
                     distances);
        if constexpr (Programs::kInstances)
            if (programs.nearestFirst() && kind == BlockType::kInstances && top < kWaitingChildren)
                takeNearest(distances, stack);
    }

    // Whether the nodes of any lane have motion (if all lanes are in one structure, the lane's
    // own). If some nodes have motion, all lanes run the test with motion together, in place of one
    // kind after the other.
    SUNSTONE_INLINE_MEMBER bool someMove() const {
        if (!hasKeys())
            return false;
        if constexpr (Programs::kMotion && Programs::kInstances)
            return Programs::any(motion.keys > 1);
        return motion.keys > 1;
    }

    SUNSTONE_INLINE_MEMBER void loadTriangle(uint32_t record, U4& a, U4& b, U4& c) const {
        const uint64_t place = reinterpret_cast<uint64_t>(records);
        if (areShared(place))
            record = loadConstant(sharedNumber(nodes, record));
        const auto recordAt = [&](uint64_t index) {
            return reinterpret_cast<const U4*>(withoutTag(place) + index * sizeof(TriangleRecord));
        };
        if (hasKeys() && motion.keys > 1) {
            loadMovingTriangle(recordAt(uint64_t(record) * motion.keys), motion, a, b, c);
            return;
        }
        const U4* const triangle = recordAt(record);
        a = loadConstant(triangle);
        b = loadConstant(triangle + 1);
        c = loadConstant(triangle + 2);
    }

    // The type of the current block.
    SUNSTONE_INLINE_MEMBER static BlockType kindOf(BlockType type) {
        return Programs::kMotion ? bvh::kindOf(type) : type;
    }

    SUNSTONE_INLINE_MEMBER bool visit(Programs& programs, Ray& ray, uint32_t record) {
        if (Programs::shapes() && kind == BlockType::kShapes) {
            if (isOfPieces(Programs::shapes(), shape)) {
                if (meetsCapsule<Programs::kMotion>(curveAt(record), place(), space, ray.tmax))
                    piece = record;
                return false;
            }
            ShapeHit hit;
            return testShape<Programs::kMotion>(Programs::shapes(), shape, records, record, place(),
                                                space, ray.tmax, hit) &&
                   programs.shape(ray, hit) == Visit::kEnd;
        }
        if (Programs::kTriangles && (!Programs::kCustoms || kind == BlockType::kTriangles)) {
            U4 a, b, c;
            loadTriangle(record, a, b, c);
            TriangleHit hit;
            if (!testTriangle(ray.origin, shear, a, b, c, ray.tmin, ray.tmax, hit))
                return false;
            return programs.triangle(ray, hit, a.w, b.w) == Visit::kEnd;
        }
        if constexpr (Programs::kCustoms) {
            const U4* const custom =
                reinterpret_cast<const U4*>(records + placeOf(record) * sizeof(CustomLeaf));
            const U4 a = loadConstant(custom), b = loadConstant(custom + 1);
            return programs.custom(ray, a.w, b.w) == Visit::kEnd;
        }
        return false;
    }

    SUNSTONE_INLINE_MEMBER void visitInstance(Programs& programs, Ray& ray, uint32_t record,
                                              U2* stack, Level* levels) {
        if constexpr (Programs::kInstances) {
            const uint32_t index =
                loadConstant(reinterpret_cast<const uint32_t*>(records) + record);
            const InstanceRecord& instance = reinterpret_cast<const InstanceRecord*>(
                reinterpret_cast<const uint8_t*>(block) + block->instancesOffset)[index];
            uint64_t child = 0;
            if (depth >= Programs::kLevels)
                return programs.refuseLevel(reinterpret_cast<uint64_t>(&instance) |
                                            devlib::kTagInstance);
            if (Programs::kLevels > kDeepLevels && top > kStackSize - kStackEntries - 10)
                return programs.refuseStack();
            if (!programs.enterInstance(ray, instance, child))
                return;
            if (inner.bits > 0x00FFFFFFu)
                push(stack, inner);
            if (leaf.bits != 0)
                push(stack, leaf);
            stack[top++] = U2{0, 0};
            if constexpr (Programs::kMotion)
                this->around = depth;
            ++depth;
            // If it is empty, the space is left at once.
            inner = leaf = {0, 0};
            float worldToObject[12];
            loadMatrix(instance, worldToObject);
            const uint32_t base = depth;
            if (moveDown(programs, ray, worldToObject, child, levels, base))
                enterBlock(programs, ray, child, levels, base);
        }
    }

    static SUNSTONE_INLINE_MEMBER void loadMatrix(const InstanceRecord& instance, float to[12]) {
        static_assert(offsetof(InstanceRecord, worldToObject) % 16 == 0);
        const U4* const rows = reinterpret_cast<const U4*>(instance.worldToObject);
        for (int i = 0; i < 3; ++i) {
            const U4 row = loadConstant(rows + i);
            toFloats(row, to + 4 * i);
            to[4 * i + 3] = floatOf(row.w);
        }
    }

    // Moves the ray into the inner space, and through the transforms below `handle`. False: as
    // enterBlock().
    SUNSTONE_INLINE_MEMBER bool moveDown(Programs& programs, Ray& ray, float worldToObject[12],
                                         uint64_t& handle, Level* levels, uint32_t base) {
        for (;;) {
            moveRay(worldToObject, ray);
            block = nullptr;
            if (Programs::kLevels == 1 || !isTransform(handle)) // enterBlock() refuses them
                return true;
            if (!openTransform(programs, ray, worldToObject, handle, levels, base))
                return false;
        }
    }
    static SUNSTONE_INLINE_MEMBER bool isTransform(uint64_t handle) {
        return (handle & devlib::kTagMask) >= devlib::kTagStatic;
    }
    // Replaces the handle by the child's. False: as enterBlock().
    SUNSTONE_INLINE_MEMBER bool openTransform(Programs& programs, Ray& ray, float worldToObject[12],
                                              uint64_t& handle, Level* levels, uint32_t base) {
        uint64_t child = 0;
        const bool tooDeep = depth >= Programs::kLevels;
        if (tooDeep)
            programs.refuseLevel(handle);
        if (tooDeep || !programs.enterTransform(ray, handle, child, worldToObject)) {
            leaveTo(programs, ray, levels, base);
            return false;
        }
        if constexpr (!Programs::kMotion)
            saveSpace(ray, levels[depth]);
        ++depth;
        handle = child;
        return true;
    }

    static SUNSTONE_INLINE_MEMBER void moveRay(const float worldToObject[12], Ray& ray) {
        float origin[3], direction[3];
        for (int i = 0; i < 3; ++i) {
            origin[i] = ray.origin[i];
            direction[i] = ray.direction[i];
        }
        transformRay(worldToObject, origin, direction, ray);
    }

    SUNSTONE_INLINE_MEMBER void saveSpace(const Ray& ray, Level& level) const {
        if constexpr (kKeepsRays) {
            const uint64_t at = reinterpret_cast<uint64_t>(block);
            level.origin = withFloats(ray.origin, floatOf(uint32_t(at)));
            level.direction = withFloats(ray.direction, floatOf(uint32_t(at >> 32)));
        } else {
            saveAll(ray, level);
        }
    }

    SUNSTONE_INLINE_MEMBER void saveAll(const Ray& ray, Level& level) const {
        level.origin = withFloats(ray.origin, box.inverse[0]);
        level.direction = withFloats(ray.direction, box.inverse[1]);
        level.box = {bitsOf(box.inverse[2]), bitsOf(box.slack), box.octant, bitsOf(box.one)};
        const uint64_t n = reinterpret_cast<uint64_t>(nodes),
                       r = reinterpret_cast<uint64_t>(records);
        level.places = {uint32_t(n), uint32_t(n >> 32), uint32_t(r), uint32_t(r >> 32)};
        level.block = reinterpret_cast<uint64_t>(block);
        if constexpr (Programs::kMotion) {
            if (hasKeys()) {
                level.motion = {motion.key, bitsOf(motion.first), bitsOf(motion.second),
                                bitsOf(motion.slack)};
                level.keys = motion.keys;
            }
            level.around = this->around;
        }
    }

    SUNSTONE_INLINE_MEMBER void leaveSpace(Programs& programs, Ray& ray, Level* levels) {
        // Returns to the outer block and leaves the transforms in between.
        if constexpr (Programs::kInstances && Programs::kMotion) {
            programs.leave(ray, depth - this->around);
            depth = this->around;
            restoreSpace(programs, ray, levels[depth]);
        } else if constexpr (Programs::kInstances) {
            do
                programs.leave(ray);
            while (blockOf(levels[--depth]) == 0);
            restoreSpace(programs, ray, levels[depth]);
        }
    }

    static SUNSTONE_INLINE_MEMBER uint64_t blockOf(const Level& level) {
        if constexpr (kKeepsRays)
            return wordsOf(level.origin.w, level.direction.w);
        else
            return level.block;
    }

    // The outer space is always that of a structure of instances.
    SUNSTONE_INLINE_MEMBER void restoreSpace(const Programs& programs, Ray& ray,
                                             const Level& level) {
        toFloats(level.origin, ray.origin);
        toFloats(level.direction, ray.direction);
        block = reinterpret_cast<const BlockHeader*>(blockOf(level));
        if constexpr (kKeepsRays)
            open(programs, ray, BlockType::kInstances, Header(block));
        else
            restoreAll(level);
    }

    SUNSTONE_INLINE_MEMBER void restoreAll(const Level& level) {
        if constexpr (Programs::kMotion) {
            if (hasKeys())
                motion = {level.keys, level.motion.x, floatOf(level.motion.y),
                          floatOf(level.motion.z), floatOf(level.motion.w)};
            this->around = level.around;
        }
        kind = BlockType::kInstances;
        box.inverse[0] = floatOf(level.origin.w);
        box.inverse[1] = floatOf(level.direction.w);
        box.inverse[2] = floatOf(level.box.x);
        box.slack = floatOf(level.box.y);
        box.octant = level.box.z;
        box.one = floatOf(level.box.w);
        nodes = reinterpret_cast<const U4*>(wordsOf(level.places.x, level.places.y));
        records = reinterpret_cast<const uint8_t*>(wordsOf(level.places.z, level.places.w));
    }

    // The fields of a block's header that entering the block needs.
    struct Header {
        U4 first, places, last;

        explicit SUNSTONE_INLINE_MEMBER Header(const BlockHeader* header) {
            const U4* const words = reinterpret_cast<const U4*>(header);
            first = loadConstant(words);
            places = loadConstant(words + offsetof(BlockHeader, instancesOffset) / 16);
            last = loadConstant(words + offsetof(BlockHeader, recordsOffset) / 16);
        }
        SUNSTONE_INLINE_MEMBER uint64_t nodesOffset() const { return wordsOf(places.z, places.w); }
        SUNSTONE_INLINE_MEMBER uint64_t recordsOffset() const {
            return wordsOf(last.x, last.y) + (last.z >> 16);
        }
        SUNSTONE_INLINE_MEMBER uint32_t shape() const { return last.z & 0xffff; }
        SUNSTONE_INLINE_MEMBER float size() const { return floatOf(last.w); } // see makeBoxRay()
    };

    // Enters the space of `block`.
    SUNSTONE_INLINE_MEMBER void open(const Programs& programs, const Ray& ray, BlockType type,
                                     const Header& header) {
        kind = kindOf(type);
        shape = header.shape();
        const uint8_t* const bytes = reinterpret_cast<const uint8_t*>(block);
        nodes = reinterpret_cast<const U4*>(bytes + header.nodesOffset());
        records = bytes + header.recordsOffset();
        if (hasKeys()) {
            motion = placeIn(*block, programs.time(), ray.origin);
            if (motion.keys > 1) {
                nodes += motion.key * (sizeof(WideNode) / 16);
                if (kind != BlockType::kInstances)
                    records += motion.key * recordSize(kind, block->shape, 1);
            }
        }
        box = makeBoxRay(ray.direction, header.size());
        if (Programs::kTriangles && (!Programs::kInstances || kind == BlockType::kTriangles))
            shear = makeShear(ray.direction);
    }

    // Makes the root of the block the group to visit. False: nothing to visit; levels above `base`
    // have been left again, with motion by leaveSpace().
    SUNSTONE_INLINE_MEMBER bool enterBlock(Programs& programs, Ray& ray, uint64_t handle,
                                           Level* levels, uint32_t base) {
        const uint64_t tag = handle & devlib::kTagMask;
        const BlockHeader* const header =
            reinterpret_cast<const BlockHeader*>(handle & ~uint64_t(devlib::kTagMask));
        if constexpr (Programs::kInstances && Programs::kLevels == 1)
            if (isTransform(handle))
                programs.refuseLevel(handle);
        if (!header ||
            !(tag == devlib::kTagGas || (Programs::kInstances && tag == devlib::kTagIas)) ||
            (tag == devlib::kTagIas && isInside(header, levels))) {
            leaveTo(programs, ray, levels, base);
            return false;
        }
        const Header fields(header);
        const U4 first = fields.first;
        const BlockType type = BlockType(first.z);
        const bool wanted = first.x == kGpuBlockMagic && first.w != kNoNode &&
                            fits(programs, type, fields.shape()) && isRay(ray) &&
                            isThere(programs, *header) && enterShapes(type, ray);
        if (!wanted) {
            if constexpr (!Programs::kMotion)
                if (first.x == kGpuBlockMagic && isMoving(type))
                    programs.refuseMotion();
            leaveTo(programs, ray, levels, base);
            return false;
        }
        block = header;
        open(programs, ray, type, fields);
        if constexpr (Programs::kInstances && !kKeepsSpace)
            if (kind == BlockType::kInstances)
                saveSpace(ray, levels[depth]);
        // The root is slot 0 of a group of one.
        inner = {0, 1u << (24 + rankOf(box.octant, 0)) | 1u};
        return true;
    }
    static_assert(offsetof(BlockHeader, magic) == 0 && offsetof(BlockHeader, type) == 8 &&
                  offsetof(BlockHeader, root) == 12 &&
                  offsetof(BlockHeader, instancesOffset) % 16 == 0 &&
                  offsetof(BlockHeader, nodesOffset) ==
                      offsetof(BlockHeader, instancesOffset) + 8 &&
                  offsetof(BlockHeader, recordsOffset) % 16 == 0 &&
                  offsetof(BlockHeader, shape) == offsetof(BlockHeader, recordsOffset) + 8 &&
                  offsetof(BlockHeader, sharesRecords) == offsetof(BlockHeader, shape) + 2 &&
                  offsetof(BlockHeader, largestCoordinate) == offsetof(BlockHeader, shape) + 4);

    // A graph with a cycle, which updates can make, would be traversed along all paths up to the
    // largest depth. Instances of a structure within itself are therefore never hit.
    SUNSTONE_INLINE_MEMBER bool isInside(const BlockHeader* header, const Level* levels) const {
        const uint64_t address = reinterpret_cast<uint64_t>(header);
        bool found = false;
        if constexpr (Programs::kLevels > 1 && Programs::kMotion) {
            uint32_t i = this->around;
            found = levels[i].block == address;
            while (i != 0) {
                i = levels[i].around;
                found |= levels[i].block == address;
            }
        } else if constexpr (Programs::kLevels > 1) {
            bool maybe = false; // tests one word, because memory limits the traversal
#pragma clang loop unroll(disable)
            for (uint32_t i = 0; i < depth; ++i)
                maybe |= levels[i].origin.w == uint32_t(address);
#pragma clang loop unroll(disable)
            for (uint32_t i = 0; maybe && i < depth; ++i)
                found |= blockOf(levels[i]) == address;
        }
        return found;
    }

    SUNSTONE_INLINE_MEMBER void leaveTo(Programs& programs, Ray& ray, Level* levels,
                                        uint32_t base) {
        if constexpr (Programs::kInstances && !Programs::kMotion)
            while (depth > base) {
                const Level& level = levels[--depth];
                toFloats(level.origin, ray.origin);
                toFloats(level.direction, ray.direction);
                programs.leave(ray);
            }
    }

    // False if a ray's direction is too long for the tests of shapes.
    SUNSTONE_INLINE_MEMBER bool enterShapes(BlockType type, const Ray& ray) {
        return !Programs::shapes() || kindOf(type) != BlockType::kShapes ||
               lane::setupRaySpace(space, ray.origin, ray.direction, ray.tmin);
    }

    SUNSTONE_INLINE_MEMBER static bool isThere(const Programs& programs,
                                               const BlockHeader& header) {
        return !hasKeys() || !isGone(header, programs.time());
    }

    static SUNSTONE_INLINE_MEMBER bool fits(const Programs& programs, BlockType withBits,
                                            uint32_t shape) {
        const BlockType type = hasKeys() ? kindOf(withBits) : withBits;
        return (Programs::shapes() && type == BlockType::kShapes && programs.meets(shape)) ||
               (Programs::kTriangles && type == BlockType::kTriangles) ||
               (Programs::kCustoms && type == BlockType::kCustom) ||
               (Programs::kInstances && type == BlockType::kInstances);
    }
};

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
