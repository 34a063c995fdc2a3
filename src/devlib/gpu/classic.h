// SPDX-License-Identifier: Apache-2.0
// Functions that only programs of the classic API call on GPUs, by name. Their CPU counterparts are
// in ClassicLaunch (devlib/classic.cpp) and LaunchState.
#pragma once

#include "bvh/gpu/motion.h"
#include "devlib/gpu/trace.h"
#include "math/product.h"

namespace sunstone::devlib::gpu {

SUNSTONE_INLINE const ClassicLaunch& classicOf(const RayState& state) {
    return *static_cast<const ClassicLaunch*>(state.launch->params);
}

// An element is outside its buffer; returns if the exception is disabled.
extern "C" [[gnu::noinline]] void sunstone_gpu_outside(RayState* state, uint32_t code) {
    if (classicOf(*state).exceptions & switchOf(code))
        raise(state, int32_t(code));
}

extern "C" void sunstone_gpu_checkClassicRay(RayState* state, RayState* ray) {
    for (int i = 0; i < 3; ++i)
        if (!__builtin_isfinite(ray->worldOrigin[i]) || !__builtin_isfinite(ray->worldDirection[i]))
            raise(state, kCodeInvalidRay);
}

// The matrix of an entry of a transform list. `known`: of the same time.
SUNSTONE_INLINE void matrixOf(uint64_t handle, float time, walk::KnownSegment& known, bool toWorld,
                              float rows[12]) {
    const HandleTag tag = tagOf(handle);
    const float* from = nullptr;
    float inverse[12];
    if (tag == kTagInstance) {
        const auto* record = reinterpret_cast<const InstanceRecord*>(addressOf(handle));
        from = toWorld ? record->objectToWorld : record->worldToObject;
    } else if (tag == kTagStatic) {
        const auto* transform = reinterpret_cast<const bvh::StaticTransform*>(addressOf(handle));
        from = toWorld ? transform->transform : transform->inverse;
    } else {
        uint64_t child = 0;
        walk::worldToObjectOf(handle, time, known, child, inverse);
        if (toWorld)
            return void(math::invert(inverse, rows));
        from = inverse;
    }
    for (int i = 0; i < 12; ++i)
        rows[i] = from[i];
}

// The product of all transforms on the path.
[[gnu::noinline]] static void matrixOfPath(RayState* state, uint32_t toWorld, float rows[12]) {
    walk::KnownSegment known;
    matrixOf(state->hit.transforms[0], state->time, known, toWorld, rows);
    for (uint32_t i = 1; i < state->hit.transformCount && i < kMaxGraphDepth; ++i) {
        float one[12];
        matrixOf(state->hit.transforms[i], state->time, known, toWorld, one);
        if (toWorld)
            math::multiply(rows, one, rows);
        else
            math::multiply(one, rows, rows);
    }
}

// The 3x4 matrix from world to the program's object space, or its inverse. Inlined into its
// callers, so that a matrix of one instance needs no memory.
extern "C" __attribute__((always_inline)) void
sunstone_gpu_matrix(RayState* state, uint32_t toWorld, float rows[12]) {
    const uint32_t count = state->hit.transformCount;
    if (count == 0) {
        for (int i = 0; i < 12; ++i)
            rows[i] = i % 5 == 0 ? 1.0f : 0.0f;
    } else if (Candidates::hasOneLevel() && !sunstone_gpu_motion) {
        const auto* const record =
            reinterpret_cast<const InstanceRecord*>(addressOf(state->hit.transforms[0]));
        for (int i = 0; i < 12; ++i)
            rows[i] = toWorld ? record->objectToWorld[i] : record->worldToObject[i];
    } else {
        float product[12];
        matrixOfPath(state, toWorld, product);
        for (int i = 0; i < 12; ++i)
            rows[i] = product[i];
    }
}

// Walks a child of the node whose visit program runs, in the space of that node. The walk has its
// own stack and shares the path and the best hit with the walk that met the node.
template <bool kWithCustoms, bool kWithMotion>
SUNSTONE_INLINE void walkChild(RayState* state, uint64_t child) {
    using Programs = Tracer<kWithCustoms, kMaxGpuGraphDepth, kWithMotion>;
    using Walk = walk::Traversal<Programs>;
    Candidates& outer = *static_cast<Candidates*>(state->traversal);
    outer.state = state; // see sunstone_gpu_reportTo
    const VisitNode* const node = state->visited;
    Programs tracer;
    static_cast<Candidates&>(tracer) = outer;
    if constexpr (kWithMotion)
        tracer.known = {};
    walk::Ray ray;
    float origin[3], direction[3];
    for (int i = 0; i < 3; ++i) {
        ray.origin[i] = origin[i] = state->objectOrigin[i];
        ray.direction[i] = direction[i] = state->objectDirection[i];
    }
    ray.tmin = state->tmin;
    ray.tmax = state->tmax;
    Walk walker;
    walk::U2 stack[Walk::kStackSize];
    typename Walk::Level levels[kMaxGpuGraphDepth + 1];
    if (walker.start(tracer, ray, child, levels))
        walker.run(tracer, ray, stack, levels, walk::RunToEnd());
    outer.found = tracer.found;
    outer.ended = tracer.ended;
    outer.best = tracer.best;
    outer.showVisit(node, origin, direction, ray.tmax);
}

extern "C" [[gnu::noinline]] uint32_t sunstone_gpu_visitChild(RayState* state, uint32_t index) {
    const VisitNode& node = *state->visited;
    if (index >= node.count || node.children[index] == 0)
        return kAccept;
    const uint64_t child = node.children[index];
    if (sunstone_gpu_motion)
        walkChild<true, true>(state, child);
    else if (sunstone_gpu_hasIntersection)
        walkChild<true, false>(state, child);
    else
        walkChild<false, false>(state, child);
    return static_cast<Candidates*>(state->traversal)->ended ? kTerminate : kAccept;
}

} // namespace sunstone::devlib::gpu
