// SPDX-License-Identifier: Apache-2.0
// The traversal loop on GPUs, a template over what happens at primitives. It compiles as CUDA, as
// freestanding C++ for nvptx64 and for the CPU, and is meant to be inlined into the caller: all
// state of a ray is in registers but for the stack, an array of the caller.
//
//   struct Programs {
//       static constexpr bool kTriangles, kCustoms, kInstances; // what may be met; the rest
//       compiles away static constexpr unsigned kLevels;   // spaces on a path besides the world's
//       (instances, transforms)
//       // A candidate at tmin <= t <= ray.tmax. It counts by setting ray.tmax = hit.t; of equal t
//       the
//       // lower primitive should win (the CPU's rule). `primitive` and `sbt` as in TriangleRecord.
//       Visit triangle(Ray& ray, const TriangleHit& hit, uint32_t primitive, uint32_t sbt);
//       Visit custom(Ray& ray, uint32_t primitive, uint32_t sbt);   // runs an intersection program
//       static uint32_t shapes();   // ShapeBits of the curves and spheres that may be met
//       Visit shape(Ray& ray, const ShapeHit& hit);   // as triangle()
//       // Before the child of an instance or of a transform in the caller's memory (its handle,
//       tag
//       // included) is entered: false skips it, else fills world-to-object of this level.
//       bool enterInstance(Ray& ray, const InstanceData& instance, float worldToObject[12]);
//       bool enterTransform(Ray& ray, uint64_t handle, uint64_t& child, float worldToObject[12]);
//       void leave(Ray& ray);                // what was entered last; ray.origin and direction are
//   };                                       // those of the outer space again
//
//   Traversal<Programs> traversal;
//   U2 stack[Traversal<Programs>::kStackSize];
//   Level levels[Programs::kLevels + 1];
//   if (traversal.start(programs, ray, handle, levels))
//       traversal.run(programs, ray, stack, levels, RunToEnd());
//
// Handles must lead to structures: what they hold is looked at, but whether there is memory at all
// cannot be asked on a GPU.
//
// Boxes. The triangle test accepts a ray as if vertices were displaced by up to 5 * 2^-24 times
// their distance from the ray's origin (bvh/ray_setup.h). Per node, the planes are therefore moved
// outwards by 2^-20 of the distance of the node's farthest corner, which also covers what is
// rounded here; an axis along which the direction is below 2^-24 of its longest component counts as
// that long, which moves the ray by less. Bytes become floats without a conversion: in 1 + q *
// 2^-15 they are bits 8 to 15; the one is taken off in the constant, which costs 2^-8 of a grid
// step, added to the margin.
#pragma once

#include "bvh/gpu/shape_tests.h"
#include "bvh/gpu/triangle.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

#define SUNSTONE_GPU_MEMBER __attribute__((always_inline))

enum class Visit : uint32_t { kContinue, kEnd };

// A ray in the current space; tmin and tmax are the same in all.
struct Ray {
    float origin[3], tmin;
    float direction[3], tmax;
};

// What programs inherit that meet no curves and spheres.
struct NoShapes {
    static SUNSTONE_GPU_MEMBER uint32_t shapes() { return 0; }
    SUNSTONE_GPU_MEMBER Visit shape(Ray&, const ShapeHit&) { return Visit::kContinue; }
};

// What box tests need of a ray in a space.
struct BoxRay {
    float inverse[3];
    float slack;     // how far planes move out, per distance of the node
    uint32_t octant; // slot ^ octant: order in which slots are visited, highest first; in each byte
};

SUNSTONE_GPU_INLINE bool isRay(const Ray& r) {
    const float sum = magnitude(r.origin[0]) + magnitude(r.origin[1]) + magnitude(r.origin[2]) +
                      magnitude(r.direction[0]) + magnitude(r.direction[1]) +
                      magnitude(r.direction[2]) + magnitude(r.tmin);
    const float longest = larger(larger(magnitude(r.direction[0]), magnitude(r.direction[1])),
                                 magnitude(r.direction[2]));
    return (bitsOf(sum) & 0x7F800000u) != 0x7F800000u && r.tmin <= r.tmax && longest >= 0x1p-120f;
}

SUNSTONE_GPU_INLINE BoxRay makeBoxRay(const float d[3]) {
    BoxRay box;
    const float longest = larger(larger(magnitude(d[0]), magnitude(d[1])), magnitude(d[2]));
    const float least = mul(longest, 0x1p-24f);
    // Beyond these, reciprocals are no normal numbers: every box is hit.
    const bool usual = longest >= 0x1p-100f && longest <= 0x1p100f;
    box.slack = usual ? 0x1p-20f : 0x1p127f;
    uint32_t order = 0;
    for (int i = 0; i < 3; ++i) {
        const float speed = larger(magnitude(d[i]), least);
        const float inverse = usual ? divide(1.0f, speed) : 1.0f;
        const bool down = bitsOf(d[i]) >> 31;
        box.inverse[i] = down ? -inverse : inverse;
        order |= (down ? 0u : 1u) << i;
    }
    box.octant = order * 0x01010101u;
    return box;
}

// Children, or primitives, that are to be visited. Inner: bits 24 to 31 are the children hit, by
// slot ^ octant, bits 0 to 7 the slots that are nodes. Primitives: bits 0 to 23.
struct Group {
    uint32_t base, bits;
};

SUNSTONE_GPU_INLINE int32_t orderedInt(float a) {
    return __builtin_bit_cast(int32_t, a);
}

// Tests the boxes of a node's children. tmin must not be negative.
SUNSTONE_GPU_INLINE void testNode(const U4* node, const float origin[3], const BoxRay& ray,
                                  float tmin, float tmax, Group& inner, Group& leaf) {
    const U4 head = loadConstant(node), children = loadConstant(node + 1);
    const U4 planes0 = loadConstant(node + 2), planes1 = loadConstant(node + 3),
             planes2 = loadConstant(node + 4);
    const float step[3] = {floatOf((head.w & 0xFFu) << 23), floatOf((head.w & 0xFF00u) << 15),
                           floatOf((head.w & 0xFF0000u) << 7)};
    const float from[3] = {sub(floatOf(head.x), origin[0]), sub(floatOf(head.y), origin[1]),
                           sub(floatOf(head.z), origin[2])};
    const float reach = larger(larger(fused(255.0f, step[0], magnitude(from[0])),
                                      fused(255.0f, step[1], magnitude(from[1]))),
                               fused(255.0f, step[2], magnitude(from[2])));
    const float slack = reach * ray.slack;
    float scale[3], nearC[3], farC[3];
    for (int i = 0; i < 3; ++i) {
        const float s = mul(step[i], ray.inverse[i]);
        const float margin = fused(magnitude(s), 0x1p-8f, mul(magnitude(ray.inverse[i]), slack));
        scale[i] = mul(s, 0x1p15f);
        const float middle = fused(from[i], ray.inverse[i], -scale[i]);
        nearC[i] = sub(middle, margin);
        farC[i] = add(middle, margin);
    }
    // Lower planes: planes0.xy, .zw, planes1.xy; upper: planes1.zw, planes2.xy, .zw.
    const bool downX = ray.inverse[0] < 0, downY = ray.inverse[1] < 0, downZ = ray.inverse[2] < 0;
    uint32_t hits = 0;
#pragma unroll
    for (int half = 0; half < 2; ++half) {
        const uint32_t lowX = half ? planes0.y : planes0.x, highX = half ? planes1.w : planes1.z;
        const uint32_t lowY = half ? planes0.w : planes0.z, highY = half ? planes2.y : planes2.x;
        const uint32_t lowZ = half ? planes1.y : planes1.x, highZ = half ? planes2.w : planes2.z;
        const uint32_t nearX = downX ? highX : lowX, farX = downX ? lowX : highX;
        const uint32_t nearY = downY ? highY : lowY, farY = downY ? lowY : highY;
        const uint32_t nearZ = downZ ? highZ : lowZ, farZ = downZ ? lowZ : highZ;
        const uint32_t meta = half ? children.w : children.z;
        // Inner children have both bits of 24.
        const uint32_t isInner = (meta & (meta << 1)) & 0x10101010u;
        const uint32_t innerMask = (isInner >> 4) * 0xFFu;
        const uint32_t place = (meta ^ (ray.octant & innerMask)) & 0x1F1F1F1Fu;
        const uint32_t bits = meta >> 5 & 0x07070707u;
#pragma unroll
        for (uint32_t k = 0; k < 4; ++k) {
            const uint32_t selector = 0x7604u | k << 4;
            const auto plane = [&](uint32_t bytes, float s, float c) {
                return orderedInt(fused(floatOf(permute(bytes, 0x3F800000u, selector)), s, c));
            };
            const auto most = [](int32_t a, int32_t b) { return a > b ? a : b; };
            const auto least = [](int32_t a, int32_t b) { return a < b ? a : b; };
            // As integers: right as long as one operand, here tmin, is not negative.
            const int32_t begin =
                most(most(plane(nearX, scale[0], nearC[0]), plane(nearY, scale[1], nearC[1])),
                     most(plane(nearZ, scale[2], nearC[2]), orderedInt(tmin)));
            const int32_t end =
                least(least(plane(farX, scale[0], farC[0]), plane(farY, scale[1], farC[1])),
                      least(plane(farZ, scale[2], farC[2]), orderedInt(tmax)));
            if (begin <= end)
                hits |= (bits >> 8 * k & 0xFFu) << (place >> 8 * k & 0x1Fu);
        }
    }
    inner.base = children.x;
    inner.bits = (hits & 0xFF000000u) | head.w >> 24;
    leaf.base = children.y;
    leaf.bits = hits & 0x00FFFFFFu;
}

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
    static constexpr unsigned kStackSize = kStackEntries * (Programs::kLevels + 1);

    Group inner, leaf;
    uint32_t top;
    uint32_t depth;
    const BlockHeader* block;
    const U4* nodes;
    const uint8_t* records;
    BoxRay box;
    Shear shear;
    lane::RaySpace space; // in structures of curves and spheres

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
            testNode(nodes + uint64_t(child) * (sizeof(WideNode) / 16), ray.origin, box,
                     larger(ray.tmin, 0.0f), ray.tmax, inner, leaf);
        } else {
            leaf = inner;
            inner.bits = 0;
        }
        while (leaf.bits != 0) {
            const uint32_t place = uint32_t(__builtin_ctz(leaf.bits));
            leaf.bits &= leaf.bits - 1;
            if (visit(programs, ray, leaf.base + place, stack, levels))
                return true;
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
    __attribute__((always_inline)) void push(U2* stack, Group group) {
        stack[top++] = U2{group.base, group.bits};
    }

    __attribute__((always_inline)) bool visit(Programs& programs, Ray& ray, uint32_t record,
                                              U2* stack, Level* levels) {
        if (Programs::kInstances && block->type == BlockType::kInstances) {
            visitInstance(programs, ray, record, stack, levels);
            return false;
        }
        if (Programs::shapes() && block->type == BlockType::kShapes) {
            ShapeHit hit;
            return testShape(Programs::shapes(), block, records, record, space, ray.tmax, hit) &&
                   programs.shape(ray, hit) == Visit::kEnd;
        }
        if (Programs::kTriangles && (!Programs::kCustoms || block->type == BlockType::kTriangles)) {
            const U4* const triangle =
                reinterpret_cast<const U4*>(records + uint64_t(record) * sizeof(TriangleRecord));
            const U4 a = loadConstant(triangle), b = loadConstant(triangle + 1),
                     c = loadConstant(triangle + 2);
            TriangleHit hit;
            if (!testTriangle(ray.origin, shear, a, b, c, ray.tmin, ray.tmax, hit))
                return false;
            return programs.triangle(ray, hit, a.w, b.w) == Visit::kEnd;
        }
        if constexpr (Programs::kCustoms) {
            const U4* const custom =
                reinterpret_cast<const U4*>(records + uint64_t(record) * sizeof(CustomLeaf));
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
        open(ray, reinterpret_cast<const BlockHeader*>(outer));
    }

    __attribute__((always_inline)) void open(const Ray& ray, const BlockHeader* header) {
        block = header;
        const uint8_t* const bytes = reinterpret_cast<const uint8_t*>(header);
        nodes = reinterpret_cast<const U4*>(bytes + header->nodesOffset);
        records = bytes + header->recordsOffset;
        box = makeBoxRay(ray.direction);
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
                            fits(*header) && isRay(ray) && enterShapes(*header, ray);
        if (!wanted) {
            leaveTo(programs, ray, levels, base);
            return false;
        }
        open(ray, header);
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
        return !Programs::shapes() || header.type != BlockType::kShapes ||
               lane::setupRaySpace(space, ray.origin, ray.direction, ray.tmin);
    }

    static __attribute__((always_inline)) bool fits(const BlockHeader& header) {
        const BlockType type = header.type;
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
