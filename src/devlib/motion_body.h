// SPDX-License-Identifier: Apache-2.0
// The parts of Tracer that deal with motion: structures with motion keys, whose primitives reach
// the visitors of trace_body.h interpolated at the ray's time, and motion transforms. Never inlined
// into the rest, so that scenes without motion do not pay for it.
#pragma once

#include "bvh/motion/transforms.h"
#include "devlib/trace_body.h"

namespace sunstone::devlib::SUNSTONE_TRACE_SPACE {

SUNSTONE_INLINE bool isGone(const bvh::BlockHeader* block, float time) {
    return bvh::hasVanished(block->motionFlags, block->motionBegin, block->motionEnd, time);
}

// A geometry acceleration structure. The ray is one (isRay).
template <class Records>
[[gnu::noinline]] inline bool Tracer<Records>::enterMoving(const bvh::BlockHeader* block, const float org[3],
                                                  const float dir[3]) {
    if (!launch_.motion)
        return excludedAsMoving();
    if (isGone(block, state_->time))
        return false;
    if (bvh::kindOf(block->type) == bvh::BlockType::kShapes)
        return enterShapes(block, org, dir);
    isa::RaySetup setup;
    isa::setupRay(setup, block, org, dir, state_->tmin, tmax_);
    const bvh::KeySegment at = bvh::keySegment(*block, state_->time);
    const isa::MovingNodes nodes(*block, setup, at);
    const bvh::BlockType kind = bvh::kindOf(block->type);
    const bool micromaps = bvh::hasMicromaps(block->type) && launch_.opacityMicromaps &&
                           !(instanceFlags_ & kInstanceDisableMicromaps);
    if (kind == bvh::BlockType::kCustom || micromaps || programsMayRun(block))
        startPrograms(org, dir);
    if (kind == bvh::BlockType::kCustom)
        return enterMovingCustoms(nodes, block, at, setup);
    if (kind != bvh::BlockType::kTriangles)
        return false;
    if (!micromaps)
        return enterMovingTriangles(nodes, block, at, setup);
    if (rayFlags_ & kRayTerminateOnFirstHit)
        return walkMovingMicromaps<false>(nodes, block, at, setup);
    return walkMovingMicromaps<true>(nodes, block, at, setup);
}

template <class Records>
inline bool Tracer<Records>::enterMovingTriangles(const isa::MovingNodes& nodes,
                                         const bvh::BlockHeader* block, bvh::KeySegment at,
                                         const isa::RaySetup& setup) {
    if (programsMayRun(block)) {
        isa::Moving<ProgramTriangles> visitor(at, *this, setup, culling(), tmax_);
        isa::traverseNodes(block, nodes, visitor);
        return ended_;
    }
    if ((rayFlags_ & kRayTerminateOnFirstHit) == 0) {
        isa::Moving<ClosestVisitor<true>> visitor(at, setup, tmax_, culling());
        isa::traverseNodes(block, nodes, visitor);
        return takeClosest<true>(visitor);
    }
    if (rayFlags_ & kRayDisableClosestHit) {
        isa::Moving<isa::AnyTriangle> visitor(at, setup, tmax_, culling());
        isa::traverseNodes(block, nodes, visitor);
        return takeOccluded(visitor.found);
    }
    isa::Moving<ClosestVisitor<false>> visitor(at, setup, tmax_, culling());
    isa::traverseNodes(block, nodes, visitor);
    return takeClosest<false>(visitor);
}

template <class Records>
template <bool kAll>
inline bool Tracer<Records>::walkMovingMicromaps(const isa::MovingNodes& nodes,
                                        const bvh::BlockHeader* block, bvh::KeySegment at,
                                        const isa::RaySetup& setup) {
    const bool twoStates =
        (rayFlags_ & kRayForceMicromap2State) || (instanceFlags_ & kInstanceForceMicromap2State);
    isa::Moving<MicromapTriangles<kAll>> visitor(at, *this, setup, culling(),
                                                 isa::MicromapLookup(block), twoStates, tmax_);
    isa::traverseNodes(block, nodes, visitor);
    return ended_;
}

template <class Records>
inline bool Tracer<Records>::enterMovingCustoms(const isa::MovingNodes& nodes, const bvh::BlockHeader* block,
                                       bvh::KeySegment at, const isa::RaySetup& setup) {
    if ((block->root & bvh::kNodeTagMask) != bvh::kInner) {
        const auto* keys = reinterpret_cast<const bvh::KeyBounds*>(
                               reinterpret_cast<const uint8_t*>(block) + block->keyBoundsOffset) +
                           at.key;
        float lower[3], upper[3];
        for (int i = 0; i < 3; ++i) {
            lower[i] = bvh::between(keys[0].lower[i], keys[1].lower[i], at.fraction);
            upper[i] = bvh::between(keys[0].upper[i], keys[1].upper[i], at.fraction);
        }
        if (!meetsBounds(lower, upper, setup, tmax_))
            return false;
    }
    CustomPrimitives visitor{*this, tmax_};
    isa::traverseNodes(block, nodes, visitor);
    return ended_;
}

// An instance acceleration structure with motion keys; other structures are never hit.
template <class Records>
[[gnu::noinline]] inline bool Tracer<Records>::enterMovingInstances(const bvh::BlockHeader* block,
                                                           const float org[3], const float dir[3]) {
    if (block->type != bvh::withMotion(bvh::BlockType::kInstances))
        return false;
    if (!launch_.motion)
        return excludedAsMoving();
    if (isGone(block, state_->time))
        return false;
    isa::RaySetup setup;
    isa::setupRay(setup, block, org, dir, state_->tmin, tmax_);
    const isa::MovingNodes nodes(*block, setup, bvh::keySegment(*block, state_->time));
    Instances visitor{*this, org, dir, tmax_};
    isa::traverseNodes(block, nodes, visitor);
    return ended_;
}

template <class Records>
[[gnu::noinline]] inline bool Tracer<Records>::enterMotionTransform(uint64_t handle, const float org[3],
                                                           const float dir[3]) {
    if (!launch_.motion)
        return excludedAsMoving();
    if (flagsExcludeLevel())
        return excludedByFlags();
    if (isDeepest() && tooDeep())
        return false;
    if (!isKnown(state_, handle))
        return false;
    const uint64_t child = bvh::childOf(handle);
    if (!isKnown(state_, child)) {
        if constexpr (kChecked)
            checkUnknown(child);
        note(launch_, &LaunchNotes::unknown, child);
        return false;
    }
    float worldToObject[12], newOrg[3], newDir[3];
    if (!bvh::worldToObjectAt(handle, state_->time, worldToObject))
        return false;
    transformRay(worldToObject, org, dir, newOrg, newDir);
    transforms_[transformCount_++] = handle;
    const bool end = enter<true>(child, newOrg, newDir);
    --transformCount_;
    return end;
}

} // namespace sunstone::devlib::SUNSTONE_TRACE_SPACE
