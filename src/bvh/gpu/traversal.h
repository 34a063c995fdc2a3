// SPDX-License-Identifier: Apache-2.0
// The traversal loop on GPUs, a template over what happens at primitives. It compiles as CUDA, as
// freestanding C++ for nvptx64 and for the CPU, and is meant to be inlined into the caller: all
// state of a ray is in registers but for the stack, an array of the caller.
//
//   struct Programs {
//       // What may be met; the rest compiles away.
//       static constexpr bool kTriangles, kCustoms, kInstances, kMotion;
//       static constexpr unsigned kLevels; // instances and transforms on a path
//       // A candidate at tmin <= t <= ray.tmax. It counts by setting ray.tmax = hit.t; of equal t
//       // the lower primitive should win (the CPU's rule). `primitive`, `sbt`: of TriangleRecord.
//       Visit triangle(Ray& ray, const TriangleHit& hit, uint32_t primitive, uint32_t sbt);
//       Visit custom(Ray& ray, uint32_t primitive, uint32_t sbt); // runs an intersection program
//       static uint32_t shapes(); // ShapeBits of the curves and spheres that may be met
//       Visit shape(Ray& ray, const ShapeHit& hit); // as triangle()
//       // Before the child of an instance or of a transform in the caller's memory (its handle,
//       // tag included) is entered: false skips it, else fills world-to-object of this level.
//       bool enterInstance(Ray& ray, const InstanceData& instance, float worldToObject[12]);
//       bool enterTransform(Ray& ray, uint64_t handle, uint64_t& child, float worldToObject[12]);
//       // What was entered last; ray.origin and direction are those of the outer space again.
//       void leave(Ray& ray);
//       static uint32_t lanes(); // of the warp, that run this together
//       float time() const;  // with kMotion
//       void refuseMotion(); // without: there is some; may return, and nothing is there
//   };
//
//   Traversal<Programs> traversal;
//   U2 stack[Traversal<Programs>::kStackSize];
//   Level levels[Programs::kLevels + 1];
//   if (traversal.start(programs, ray, handle, levels))
//       traversal.run(programs, ray, stack, levels, RunToEnd());
//
// Handles must lead to structures: what they hold is looked at, but whether there is memory at all
// cannot be asked on a GPU.
#pragma once

#include "bvh/gpu/motion_traversal.h"
#include "bvh/gpu/shape_tests.h"
#include "bvh/gpu/triangle.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

#define SUNSTONE_GPU_MEMBER __attribute__((always_inline))

enum class Visit : uint32_t { kContinue, kEnd };

// What programs inherit that meet no curves and spheres, nothing that moves, or run alone.
struct NoShapes {
    static SUNSTONE_GPU_MEMBER uint32_t shapes() { return 0; }
    SUNSTONE_GPU_MEMBER Visit shape(Ray&, const ShapeHit&) { return Visit::kContinue; }
};
struct NoMotion {
    static constexpr bool kMotion = false;
    SUNSTONE_GPU_MEMBER void refuseMotion() {}
};
struct OneLane {
    static SUNSTONE_GPU_MEMBER uint32_t lanes() { return 1; }
};

SUNSTONE_GPU_INLINE void transformRay(const float m[12], const float origin[3],
                                      const float direction[3], Ray& to) {
    for (int i = 0; i < 3; ++i) {
        const float *row = m + 4 * i, *o = origin, *d = direction;
        to.origin[i] =
            add(add(add(mul(row[0], o[0]), mul(row[1], o[1])), mul(row[2], o[2])), row[3]);
        to.direction[i] = add(add(mul(row[0], d[0]), mul(row[1], d[1])), mul(row[2], d[2]));
    }
}

// When a walk over the tree stops to let others join.
struct RunToEnd {
    __attribute__((always_inline)) bool stop() const { return false; }
};

// What to come back to when an instance or transform is left; block: 0 above a transform.
struct Level {
    float origin[3], direction[3];
    uint64_t block;
};

template <class Programs>
struct Traversal {
    // Entries a stack needs; one of its entries is a group, or 0, 0 where a space ends.
    static constexpr unsigned kStackSize = kWaitingLeaves + kStackEntries * (Programs::kLevels + 1);

    Group inner, leaf;
    uint32_t top;
    uint32_t depth;
    const BlockHeader* block;
    BlockType kind; // of the block, so that primitives need not look
    const U4* nodes;
    const uint8_t* records;
    BoxRay box;
    Shear shear;
    lane::RaySpace space; // in structures of curves and spheres
    MotionPlace motion;   // with kMotion

    // Begins at a handle (with its tag). False: there is nothing to visit.
    __attribute__((always_inline)) bool start(Programs& programs, Ray& ray, uint64_t handle,
                                              Level* levels) {
        inner = leaf = {0, 0};
        top = depth = 0;
        block = nullptr;
        return enter(programs, ray, handle, levels, 0);
    }

    // Visits until the end (true), or until Policy::stop() says so after a step (false).
    template <class Policy>
    __attribute__((always_inline)) bool run(Programs& programs, Ray& ray, U2* stack, Level* levels,
                                            Policy policy) {
        for (;;) {
            if (step(programs, ray, stack, levels))
                return true;
            if (policy.stop())
                return false;
        }
    }

    // Visits one node, or what is left of a leaf, and the primitives found there. True at the end.
    __attribute__((always_inline)) bool step(Programs& programs, Ray& ray, U2* stack,
                                             Level* levels) {
        if (inner.bits > 0x00FFFFFFu) {
            const uint32_t bit = 31 - uint32_t(__builtin_clz(inner.bits));
            const uint32_t slot = (bit - 24) ^ (box.octant & 7u);
            const uint32_t child =
                inner.base + uint32_t(__builtin_popcount(inner.bits & 0xFFu & ~(~0u << slot)));
            inner.bits &= ~(1u << bit);
            if (inner.bits > 0x00FFFFFFu)
                push(stack, inner);
            test(ray, child);
        } else {
            leaf = inner;
            inner.bits = 0;
        }
        const uint32_t few = (5 * Programs::lanes() + 8) / 16;
        while (leaf.bits != 0) {
            const uint32_t place = nextPlace();
            leaf.bits &= ~(1u << place);
            if (visit(programs, ray, leaf.base + place, stack, levels))
                return true;
            if (leaf.bits != 0 && mayWait() && Programs::lanes() < few) {
                push(stack, leaf);
                leaf.bits = 0;
            }
        }
        while (inner.bits <= 0x00FFFFFFu) {
            if (top == 0)
                return true;
            const U2 entry = stack[--top];
            inner = {entry.x, entry.y};
            if (!Programs::kInstances || entry.y != 0)
                break;
            leaveSpace(programs, ray, levels);
        }
        return false;
    }

private:
    // What is left of a leaf waits on the stack where nearly all lanes of the warp are through with
    // theirs, so that they need not wait. Leaves have 1 to 24 primitives; without this, on long
    // thin triangles, tests ran for 3.5 of 32 lanes.
    __attribute__((always_inline)) bool mayWait() const {
        return top < kWaitingLeaves && !(Programs::kInstances && kind == BlockType::kInstances);
    }

    // Primitives are listed by slot, and the highest bit of a slot is the side along z. What is
    // behind an instance that is hit need not be entered.
    __attribute__((always_inline)) uint32_t nextPlace() const {
        const bool last =
            Programs::kInstances && kind == BlockType::kInstances && (box.octant & 4u) == 0;
        return last ? 31 - uint32_t(__builtin_clz(leaf.bits)) : uint32_t(__builtin_ctz(leaf.bits));
    }

    __attribute__((always_inline)) void push(U2* stack, Group group) {
        stack[top++] = U2{group.base, group.bits};
    }

    __attribute__((always_inline)) void test(const Ray& ray, uint32_t child) {
        constexpr uint32_t kUnits = sizeof(WideNode) / 16;
        const float tmin = larger(ray.tmin, 0.0f);
        if (Programs::kMotion && motion.keys > 1)
            testMovingNode(nodes + uint64_t(child) * motion.keys * kUnits, motion, ray.origin, box,
                           tmin, ray.tmax, inner, leaf);
        else
            testNode(nodes + uint64_t(child) * kUnits, ray.origin, box, tmin, ray.tmax, inner,
                     leaf);
    }

    __attribute__((always_inline)) void loadTriangle(uint32_t record, U4& a, U4& b, U4& c) const {
        const auto recordAt = [&](uint64_t index) {
            return reinterpret_cast<const U4*>(records + index * sizeof(TriangleRecord));
        };
        if (Programs::kMotion && motion.keys > 1) {
            loadMovingTriangle(recordAt(uint64_t(record) * motion.keys), motion, a, b, c);
            return;
        }
        const U4* const triangle = recordAt(record);
        a = loadConstant(triangle);
        b = loadConstant(triangle + 1);
        c = loadConstant(triangle + 2);
    }

    // Of the block that is walked.
    __attribute__((always_inline)) static BlockType kindOf(BlockType type) {
        return Programs::kMotion ? bvh::kindOf(type) : type;
    }

    __attribute__((always_inline)) bool visit(Programs& programs, Ray& ray, uint32_t record,
                                              U2* stack, Level* levels) {
        if (Programs::kInstances && kind == BlockType::kInstances) {
            visitInstance(programs, ray, record, stack, levels);
            return false;
        }
        if (Programs::shapes() && kind == BlockType::kShapes) {
            ShapeHit hit;
            return testShape<Programs::kMotion>(Programs::shapes(), block, records, record, motion,
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
            const uint64_t index = Programs::kMotion ? uint64_t(record) * motion.keys : record;
            const U4* const custom =
                reinterpret_cast<const U4*>(records + index * sizeof(CustomLeaf));
            const U4 a = loadConstant(custom), b = loadConstant(custom + 1);
            return programs.custom(ray, a.w, b.w) == Visit::kEnd;
        }
        return false;
    }

    __attribute__((always_inline)) void visitInstance(Programs& programs, Ray& ray, uint32_t record,
                                                      U2* stack, Level* levels) {
        if constexpr (Programs::kInstances) {
            const uint32_t index = reinterpret_cast<const uint32_t*>(records)[record];
            const InstanceData& instance = reinterpret_cast<const InstanceData*>(
                reinterpret_cast<const uint8_t*>(block) + block->instancesOffset)[index];
            float worldToObject[12];
            if (depth >= Programs::kLevels || !programs.enterInstance(ray, instance, worldToObject))
                return;
            const uint32_t before = top;
            const Group inner0 = inner, leaf0 = leaf;
            if (inner.bits > 0x00FFFFFFu)
                push(stack, inner);
            if (leaf.bits != 0)
                push(stack, leaf);
            stack[top++] = U2{0, 0};
            saveSpace(ray, levels);
            transformRay(worldToObject, levels[depth - 1].origin, levels[depth - 1].direction, ray);
            inner = leaf = {0, 0};
            block = nullptr;
            if (enter(programs, ray, instance.child, levels, depth))
                return;
            // Nothing there.
            inner = inner0, leaf = leaf0;
            top = before;
            restoreSpace(programs, ray, levels);
        }
    }

    __attribute__((always_inline)) void saveSpace(const Ray& ray, Level* levels) {
        Level& level = levels[depth++];
        for (int i = 0; i < 3; ++i) {
            level.origin[i] = ray.origin[i];
            level.direction[i] = ray.direction[i];
        }
        level.block = reinterpret_cast<uint64_t>(block);
    }

    __attribute__((always_inline)) void leaveSpace(Programs& programs, Ray& ray, Level* levels) {
        if constexpr (Programs::kInstances)
            restoreSpace(programs, ray, levels);
    }

    // Back to the block around, through transforms that stood between.
    __attribute__((always_inline)) void restoreSpace(Programs& programs, Ray& ray, Level* levels) {
        uint64_t outer;
        do {
            const Level& level = levels[--depth];
            for (int i = 0; i < 3; ++i) {
                ray.origin[i] = level.origin[i];
                ray.direction[i] = level.direction[i];
            }
            outer = level.block;
            programs.leave(ray);
        } while (outer == 0);
        open(programs, ray, reinterpret_cast<const BlockHeader*>(outer));
    }

    __attribute__((always_inline)) void open(const Programs& programs, const Ray& ray,
                                             const BlockHeader* header) {
        block = header;
        kind = kindOf(header->type);
        const uint8_t* const bytes = reinterpret_cast<const uint8_t*>(header);
        nodes = reinterpret_cast<const U4*>(bytes + header->nodesOffset);
        records = bytes + header->recordsOffset;
        if constexpr (Programs::kMotion) {
            motion = placeIn(*header, programs.time(), ray.origin);
            if (motion.keys > 1) {
                nodes += motion.key * (sizeof(WideNode) / 16);
                if (kind != BlockType::kInstances)
                    records += motion.key * recordSize(kind, header->shape, 1);
            }
        }
        box = makeBoxRay(ray.direction, floatOf(header->root));
        if constexpr (Programs::kTriangles)
            shear = makeShear(ray.direction);
    }

    // Follows the handle through transforms to a block, whose root becomes the group to visit.
    // False: there is nothing to visit; levels above `base` have been left again.
    __attribute__((always_inline)) bool enter(Programs& programs, Ray& ray, uint64_t handle,
                                              Level* levels, uint32_t base) {
        if constexpr (Programs::kInstances)
            while ((handle & kTraversableTagMask) >= kStaticTransformTag) {
                float worldToObject[12];
                uint64_t child = 0;
                if (depth >= Programs::kLevels ||
                    !programs.enterTransform(ray, handle, child, worldToObject)) {
                    leaveTo(programs, ray, levels, base);
                    return false;
                }
                saveSpace(ray, levels);
                transformRay(worldToObject, levels[depth - 1].origin, levels[depth - 1].direction,
                             ray);
                handle = child;
            }
        const uint64_t tag = handle & kTraversableTagMask;
        const BlockHeader* const header =
            reinterpret_cast<const BlockHeader*>(handle & ~uint64_t(kTraversableTagMask));
        const bool wanted = (tag == kGasTag || (Programs::kInstances && tag == kIasTag)) &&
                            header && header->magic == kGpuBlockMagic && header->root != kNoNode &&
                            fits(*header) && isRay(ray) && isThere(programs, *header) &&
                            enterShapes(*header, ray);
        if (!wanted) {
            if constexpr (!Programs::kMotion)
                if (header && header->magic == kGpuBlockMagic && isMoving(header->type))
                    programs.refuseMotion();
            leaveTo(programs, ray, levels, base);
            return false;
        }
        open(programs, ray, header);
        // The root stands in slot 0 of a group of one.
        inner = {0, 1u << (24 + (box.octant & 7u)) | 1u};
        return true;
    }

    __attribute__((always_inline)) void leaveTo(Programs& programs, Ray& ray, Level* levels,
                                                uint32_t base) {
        if constexpr (Programs::kInstances)
            while (depth > base) {
                const Level& level = levels[--depth];
                for (int i = 0; i < 3; ++i) {
                    ray.origin[i] = level.origin[i];
                    ray.direction[i] = level.direction[i];
                }
                programs.leave(ray);
            }
    }

    // False where a ray is too fast for the tests of shapes.
    __attribute__((always_inline)) bool enterShapes(const BlockHeader& header, const Ray& ray) {
        return !Programs::shapes() || kindOf(header.type) != BlockType::kShapes ||
               lane::setupRaySpace(space, ray.origin, ray.direction, ray.tmin);
    }

    __attribute__((always_inline)) static bool isThere(const Programs& programs,
                                                       const BlockHeader& header) {
        if constexpr (Programs::kMotion)
            return !isGone(header, programs.time());
        return true;
    }

    static __attribute__((always_inline)) bool fits(const BlockHeader& header) {
        const BlockType type = kindOf(header.type);
        return (Programs::shapes() && type == BlockType::kShapes &&
                meetsShape(Programs::shapes(), header.shape)) ||
               (Programs::kTriangles && type == BlockType::kTriangles) ||
               (Programs::kCustoms && type == BlockType::kCustom) ||
               (Programs::kInstances && type == BlockType::kInstances);
    }
};

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
