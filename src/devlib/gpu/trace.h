// SPDX-License-Identifier: Apache-2.0
// optixTrace and optixReportIntersection on GPUs: the handling of primitives and instances while
// bvh/gpu/walk/traversal.h walks the tree. Rules and formulas are those of the CPU
// (devlib/trace_body.h). The best hit is kept apart until the end of traversal, because
// RayState::hit is the candidate until then. RayState::tmax is the candidate's t in any-hit, the
// best t in intersection and closest-hit, the ray's own in miss.
#pragma once

#include "bvh/gpu/walk/traversal.h"
#include "bvh/micromap/micromap_lookup.h"
#include "devlib/gpu/checks.h"

namespace sunstone::devlib::gpu {

namespace walk = sunstone::bvh::gpu;

// The part of the tracer that does not depend on the kinds of primitives and graphs. Intersection
// programs receive a pointer to it and pass it to optixReportIntersection.
struct Candidates {
    RayState* state;
    uint32_t rayFlags;
    bool found, ended;
    bool candidateAnyHit;
    float tmax; // while an intersection program runs
    uint32_t candidateGroup;
    // The index of the record that the state shows, in the current structure; kNothingShown: none
    // yet.
    uint32_t shown;
    static constexpr uint32_t kNothingShown = ~0u;
    // Place of the walk in the graph: the instance or transform entered last, or 0; with more than
    // one level the last of `transforms`. Everything else follows from their records.
    uint64_t entered;
    uint32_t transformCount;
    uint32_t visits; // visit programs that run
    // The best hit: as in RayState::hit.
    struct Best {
        uint32_t kind, primitive, sbtGasIndex;
        uint64_t entered; // with one level
        // With more levels: the first `shared` handles of its path are in `transforms`, the others
        // in `bestTransforms`. They move there when other handles replace them.
        uint32_t transformCount, shared;
        uint32_t attributes[Records::kAttributeWords];
    } best;
    uint64_t *transforms, *bestTransforms; // of the GraphPath

    SUNSTONE_INLINE_MEMBER uint64_t hitRecord(uint32_t sbtGasIndex, uint32_t offset) const {
        const uint64_t record = Records::hit(*state, sbtGasIndex, offset);
        checkRecord(state, kExceptionInvalidHitSbt, record, kGroupHit,
                    Records::hitIndex(*state, sbtGasIndex, offset));
        return record;
    }

    SUNSTONE_INLINE_MEMBER void noteHit(uint32_t group, uint32_t sbtGasIndex,
                                        uint32_t offset) const {
        noteRecord(state, group, NeededProgram::kHit,
                   Records::hitIndex(*state, sbtGasIndex, offset));
    }

    static SUNSTONE_INLINE_MEMBER bool hasOneLevel() {
        return sunstone_gpu_graph == kGraphSingleLevel || sunstone_gpu_graph == kGraphShallow;
    }

    // The data of a place that programs see.
    struct Place {
        uint32_t index = 0, id = ~0u, sbtOffset = 0;
        uint64_t gas = 0;
    };
    static SUNSTONE_INLINE_MEMBER const InstanceRecord& recordOf(uint64_t instance) {
        return *reinterpret_cast<const InstanceRecord*>(addressOf(instance));
    }
    SUNSTONE_INLINE_MEMBER uint64_t childOf(uint64_t handle) const {
        return handle == 0                     ? state->handle
               : tagOf(handle) == kTagInstance ? recordOf(handle).child
                                               : bvh::childOf(handle);
    }
    SUNSTONE_INLINE_MEMBER Place placeOf(uint64_t handle) const {
        Place place;
        if (handle != 0 && tagOf(handle) == kTagInstance) {
            const InstanceRecord& record = recordOf(handle);
            place = {record.index, record.instanceId, record.sbtOffset};
        }
        place.gas = childOf(handle);
        return place;
    }
    // The place below the path of `count` handles, which at(i) returns.
    template <class At>
    SUNSTONE_INLINE_MEMBER Place placeOfPath(uint32_t count, At at) const {
        Place place;
        uint64_t handle = 0;
#pragma clang loop unroll(disable)
        for (uint32_t i = 0; i < count; ++i) {
            handle = at(i);
            if (tagOf(handle) != kTagInstance)
                continue;
            const InstanceRecord& record = recordOf(handle);
            place.index = record.index;
            place.id = record.instanceId;
            place.sbtOffset += record.sbtOffset;
        }
        place.gas = childOf(handle);
        return place;
    }
    SUNSTONE_INLINE_MEMBER Place here() const {
        return hasOneLevel()
                   ? placeOf(entered)
                   : placeOfPath(transformCount, [this](uint32_t i) { return transforms[i]; });
    }
    SUNSTONE_INLINE_MEMBER uint64_t ofBestPath(uint32_t i) const {
        return i < best.shared ? transforms[i] : bestTransforms[i];
    }
    SUNSTONE_INLINE_MEMBER Place bestPlace() const {
        return hasOneLevel()
                   ? placeOf(best.entered)
                   : placeOfPath(best.transformCount, [this](uint32_t i) { return ofBestPath(i); });
    }
    // The flags of the innermost instance.
    SUNSTONE_INLINE_MEMBER uint32_t instanceFlags() const {
        uint64_t handle = entered;
        if (!hasOneLevel()) {
#pragma clang loop unroll(disable)
            for (uint32_t i = transformCount; i > 1 && tagOf(handle) != kTagInstance; --i)
                handle = transforms[i - 2];
        }
        return handle != 0 && tagOf(handle) == kTagInstance ? recordOf(handle).flags : 0;
    }
    // Stores the place in the state's hit.
    SUNSTONE_INLINE_MEMBER void setPlace(const Place& place) const {
        state->hit.instanceIndex = place.index;
        state->hit.instanceId = place.id;
        state->hit.instanceSbtOffset = place.sbtOffset;
        state->hit.gas = place.gas;
    }

    SUNSTONE_INLINE_MEMBER void beginPath() {
        shown = kNothingShown;
        entered = 0;
        transformCount = 0;
        visits = 0;
    }

    // Stores the current path for programs and exceptions.
    SUNSTONE_INLINE_MEMBER void showPath() const {
        if (hasOneLevel())
            return showEntered(entered);
        state->hit.transformCount = transformCount;
#pragma clang loop unroll(disable)
        for (uint32_t i = 0; i < transformCount; ++i)
            state->hit.transforms[i] = transforms[i];
    }

    SUNSTONE_INLINE_MEMBER void showEntered(uint64_t handle) const {
        state->hit.transformCount = handle != 0;
        if (handle != 0)
            state->hit.transforms[0] = handle;
    }

    SUNSTONE_INLINE_MEMBER bool isAnyHitEnabled(uint32_t sbtWord) const {
        return anyHitEnabled(instanceFlags(), sbtWord);
    }
    SUNSTONE_INLINE_MEMBER bool runsAnyHit(bool enabled) const {
        return holds(sunstone_gpu_hasAnyHit, state->launch->hasAnyHit) &&
               anyHitRuns(rayFlags, enabled);
    }
    SUNSTONE_INLINE_MEMBER bool flipped() const { return instanceFlags() & kInstanceFlipFacing; }
    SUNSTONE_INLINE_MEMBER bool culled(float det, uint32_t sbtWord) const {
        if ((rayFlags & (kRayCullFront | kRayCullBack)) == 0 ||
            (instanceFlags() & kInstanceDisableFaceCulling) ||
            (sbtWord >> bvh::kGeometryFlagShift & bvh::kGeometryDisableFaceCulling))
            return false;
        return rayFlags & ((det > 0) != flipped() ? kRayCullFront : kRayCullBack);
    }

    SUNSTONE_INLINE_MEMBER void keepPath() {
        if (hasOneLevel())
            best.entered = entered;
        else
            best.transformCount = best.shared = transformCount;
    }

    // Stores a candidate for programs. False if flags drop it. kMany: further candidates of the
    // same record are likely, because intersection programs reject most. An any-hit program often
    // ends the ray, so the comparison would cost more than it saves.
    template <bool kMany>
    SUNSTONE_INLINE_MEMBER bool startCandidate(const walk::Ray& ray, uint32_t primitive,
                                               uint32_t sbtWord) {
        const bool enabled = isAnyHitEnabled(sbtWord);
        if (droppedByFlags(rayFlags, enabled))
            return false;
        candidateAnyHit = runsAnyHit(enabled);
        state->hit.primitive = primitive;
        const uint32_t index = sbtWord & bvh::kSbtIndexMask;
        if (!kMany || shown != index)
            show(ray, index);
        return true;
    }
    // Stores the data that all candidates of a record in a space share.
    SUNSTONE_INLINE_MEMBER void show(const walk::Ray& ray, uint32_t sbtGasIndex) {
        state->hit.sbtGasIndex = shown = sbtGasIndex;
        showPath();
        const Place place = here();
        showRecord(hitRecord(sbtGasIndex, place.sbtOffset));
        noteHit(candidateGroup, sbtGasIndex, place.sbtOffset);
        checkBuiltin(state, candidateGroup, place.gas, sbtGasIndex);
        for (int i = 0; i < 3; ++i) {
            state->objectOrigin[i] = ray.origin[i];
            state->objectDirection[i] = ray.direction[i];
        }
        setPlace(place);
    }

    SUNSTONE_INLINE_MEMBER void swapAttributes() const {
        if constexpr (Records::kAttributeBlocks) {
            void* const first = state->attributeBlocks[0];
            state->attributeBlocks[0] = state->attributeBlocks[1];
            state->attributeBlocks[1] = first;
        }
    }
    // Computes the attributes of a triangle's hit before a program that reads them runs.
    SUNSTONE_INLINE_MEMBER void computeAttributes(uint32_t group, uint32_t reader) const {
        if constexpr (Records::kAttributePrograms)
            if (state->hit.kind >= kHitTriangleFront && Records::readsAttributes(*state, reader)) {
                Records::setTriangleAttributes(*state);
                sunstone_gpu_attribute(state, group);
            }
    }

    // Passes the candidate in state->hit to the any-hit program and takes it unless rejected.
    SUNSTONE_INLINE_MEMBER uint32_t offer(float& rayTmax) {
        uint32_t result = kAccept;
        if (candidateAnyHit) {
            state->tmax = state->hit.t;
            computeAttributes(candidateGroup, kAnyHitReads);
            result = sunstone_gpu_anyHit(state, candidateGroup);
            if (result == kIgnore)
                return kIgnore;
        }
        found = true;
        rayTmax = state->hit.t;
        keepCandidate<Records>(state->hit, best);
        swapAttributes();
        keepPath();
        ended = endsRay(result, rayFlags);
        return ended ? kTerminate : kAccept;
    }

    // Gives the candidate another record of its build input, until the report ends.
    SUNSTONE_INLINE_MEMBER uint32_t offerMaterial(uint32_t material) {
        if (!Records::hasMaterial(*state, material)) {
            if (const int32_t code = Records::materialFault(*state))
                raise(state, code);
            return kIgnore;
        }
        if (material == 0) // the state already shows its record
            return offer(tmax);
        Hit& hit = state->hit;
        const uint32_t first = hit.sbtGasIndex, group = candidateGroup;
        const void* const record = hit.record;
        hit.sbtGasIndex = first + material;
        showRecord(hitRecord(hit.sbtGasIndex, here().sbtOffset));
        const uint32_t result = offer(tmax);
        hit.sbtGasIndex = first;
        candidateGroup = group;
        hit.record = record;
        state->sbtData = dataOf(uint64_t(record));
        return result;
    }
    SUNSTONE_INLINE_MEMBER void showRecord(uint64_t record) {
        candidateGroup = record ? groupOf(*state->launch, record, kGroupHit) : kNoGroup;
        state->hit.record = reinterpret_cast<const void*>(record);
        state->sbtData = dataOf(record);
    }

    // Turns the state into that of a node's visit program. `origin` and `direction`: of the ray in
    // the space of the node.
    SUNSTONE_INLINE_MEMBER void showVisit(const VisitNode* node, const float origin[3],
                                          const float direction[3], float rayTmax) {
        for (int i = 0; i < 3; ++i) {
            state->objectOrigin[i] = origin[i];
            state->objectDirection[i] = direction[i];
        }
        showPath();
        setPlace(here());
        shown = kNothingShown;
        state->traversal = this;
        state->visited = node;
        state->tmax = rayTmax;
        state->sbtData = dataOf(node->record);
    }
};

// Arrays that are indexed by level. They are separate from the tracer, because LLVM keeps the
// tracer in registers only if no pointer to it escapes and all its members are accessed by name.
template <unsigned kMaxLevels>
struct GraphPath {
    uint64_t transforms[kMaxLevels + 1], best[kMaxLevels + 1];
};

// Data of a walk that depends on its ray's time.
template <bool kMotion>
struct AtTime {};
template <>
struct AtTime<true> {
    walk::KnownSegment known;
};

template <bool kWithCustoms, unsigned kMaxLevels, bool kWithMotion>
struct Tracer : Candidates, AtTime<kWithMotion> {
    static constexpr bool kTriangles = true, kCustoms = kWithCustoms, kInstances = kMaxLevels > 0,
                          kMotion = kWithMotion;
    static constexpr unsigned kLevels = kMaxLevels;

    using Path = GraphPath<kMaxLevels>;

    SUNSTONE_INLINE_MEMBER void setBarycentrics(uint32_t* attributes,
                                                const walk::TriangleHit& hit) {
        attributes[0] = walk::bitsOf(walk::divide(hit.v, hit.det));
        attributes[1] = walk::bitsOf(walk::divide(hit.w, hit.det));
        for (unsigned i = 2; i < Records::kAttributeWords; ++i)
            attributes[i] = 0;
    }
    SUNSTONE_INLINE_MEMBER uint32_t kindOf(const walk::TriangleHit& hit) const {
        return triangleKind(hit.det, instanceFlags());
    }

    // False where the triangle is transparent; else sets the geometry flag.
    SUNSTONE_INLINE_MEMBER bool throughMicromap(const walk::TriangleHit& hit, uint32_t primitive,
                                                uint32_t& sbtWord) const {
        const uint32_t flags = instanceFlags();
        const auto* const block =
            reinterpret_cast<const bvh::BlockHeader*>(addressOf(childOf(entered)));
        if ((flags & kInstanceDisableMicromaps) || block->micromapsOffset == 0)
            return true;
        const uint32_t at = walk::lane::MicromapLookup(block).stateAt(
            primitive, sbtWord, walk::divide(hit.v, hit.det), walk::divide(hit.w, hit.det));
        const bool twoStates =
            (rayFlags & kRayForceMicromap2State) || (flags & kInstanceForceMicromap2State);
        return walk::lane::throughMicromap(at, twoStates, sbtWord);
    }

    SUNSTONE_INLINE_MEMBER walk::Visit triangle(walk::Ray& ray, const walk::TriangleHit& hit,
                                                uint32_t primitive, uint32_t sbtWord) {
        if (culled(hit.det, sbtWord))
            return walk::Visit::kContinue;
        if (holds(sunstone_gpu_micromaps, state->launch->opacityMicromaps) &&
            !throughMicromap(hit, primitive, sbtWord))
            return walk::Visit::kContinue;
        const bool enabled = isAnyHitEnabled(sbtWord);
        if (runsAnyHit(enabled)) {
            if (!this->template startCandidate<false>(ray, primitive, sbtWord))
                return walk::Visit::kContinue;
            state->hit.t = hit.t;
            state->hit.kind = kindOf(hit);
            setBarycentrics(state->hit.attributes, hit);
            return offer(ray.tmax) == kTerminate ? walk::Visit::kEnd : walk::Visit::kContinue;
        }
        if (droppedByFlags(rayFlags, enabled) ||
            losesTie(hit.t, primitive, found, ray.tmax, best.primitive))
            return walk::Visit::kContinue;
        found = true;
        ray.tmax = hit.t;
        best.kind = kindOf(hit);
        best.primitive = primitive;
        best.sbtGasIndex = sbtWord & bvh::kSbtIndexMask;
        setBarycentrics(best.attributes, hit);
        keepPath();
        ended = rayFlags & kRayTerminateOnFirstHit;
        return ended ? walk::Visit::kEnd : walk::Visit::kContinue;
    }

    SUNSTONE_INLINE_MEMBER walk::Visit custom(walk::Ray& ray, uint32_t primitive,
                                              uint32_t sbtWord) {
        if (!this->template startCandidate<true>(ray, primitive, sbtWord))
            return walk::Visit::kContinue;
        tmax = ray.tmax;
        state->tmax = ray.tmax;
        sunstone_gpu_intersection(state, static_cast<Candidates*>(this), candidateGroup);
        ray.tmax = tmax;
        return ended ? walk::Visit::kEnd : walk::Visit::kContinue;
    }

    static SUNSTONE_INLINE_MEMBER uint32_t shapes() { return sunstone_gpu_shapes; }
    SUNSTONE_INLINE_MEMBER bool meets(uint32_t shape) const {
        return walk::meetsShape(sunstone_gpu_shapes & kGpuFactOfLaunch
                                    ? bvh::gpu::shapeBitsOf(state->launch->primitiveTypeFlags)
                                    : sunstone_gpu_shapes,
                                shape);
    }
    static SUNSTONE_INLINE_MEMBER uint32_t activeLanes() {
        uint32_t mask;
        asm volatile("activemask.b32 %0;" : "=r"(mask));
        return mask;
    }
    static SUNSTONE_INLINE_MEMBER uint32_t lanes() {
        return uint32_t(__builtin_popcount(activeLanes()));
    }

    // Triangles have the same nearest hit in any order, and the same answer whether there is a hit.
    SUNSTONE_INLINE_MEMBER bool mayReorder() const {
        return !kCustoms && !holds(sunstone_gpu_hasAnyHit, state->launch->hasAnyHit) &&
               (nearestFirst() || (rayFlags & kRayDisableClosestHit));
    }

    // Lanes wait with rare, long work until this part of the active lanes waits.
    static SUNSTONE_INLINE_MEMBER bool areEnough(bool wants, int part, int of) {
        const uint32_t mask = activeLanes();
        const uint32_t waiting = __nvvm_vote_ballot_sync(mask, wants);
        return wants && of * __builtin_popcount(waiting) >= part * __builtin_popcount(mask);
    }
    // Entering takes as long as a node, with motion much longer (docs/notes/programs-gpu.md). The
    // parts of these two add up to one, so that not all lanes wait.
    static SUNSTONE_INLINE_MEMBER bool mayEnter(bool wants) {
        return areEnough(wants, 1, kMotion ? 2 : 4);
    }
    // Short programs are not worth the wait, and any-hit programs end rays.
    SUNSTONE_INLINE_MEMBER bool mayIntersect(bool wants) const {
        if (!sunstone_gpu_longIntersections ||
            holds(sunstone_gpu_hasAnyHit, state->launch->hasAnyHit))
            return wants;
        return kMotion ? areEnough(wants, 1, 2) : areEnough(wants, 3, 4);
    }
    // Whether lanes wait longer with pieces of curves: with instances, few lanes are in curves at
    // the same time. Any-hit programs end rays, so with them waiting costs more than it gains.
    SUNSTONE_INLINE_MEMBER bool waitsLong() const {
        return kInstances && (shapes() & bvh::gpu::kMeetsCurves) &&
               !holds(sunstone_gpu_hasAnyHit, state->launch->hasAnyHit);
    }
    SUNSTONE_INLINE_MEMBER bool mayTest(bool wants) const {
        return areEnough(wants, 1, waitsLong() ? 1 : 2);
    }
    static SUNSTONE_INLINE_MEMBER bool any(bool value) {
        return __nvvm_vote_any_sync(activeLanes(), value);
    }
    SUNSTONE_INLINE_MEMBER bool nearestFirst() const {
        return (rayFlags & kRayTerminateOnFirstHit) == 0;
    }

    SUNSTONE_INLINE_MEMBER void setParameter(uint32_t* attributes, float u) {
        attributes[0] = walk::bitsOf(u);
        for (unsigned i = 1; i < Records::kAttributeWords; ++i)
            attributes[i] = 0;
    }

    // Curves and spheres have no faces to cull.
    SUNSTONE_INLINE_MEMBER walk::Visit shape(walk::Ray& ray, const bvh::ShapeHit& hit) {
        const bool enabled = isAnyHitEnabled(hit.sbt);
        if (runsAnyHit(enabled)) {
            if (!this->template startCandidate<false>(ray, hit.primitive, hit.sbt))
                return walk::Visit::kContinue;
            state->hit.t = hit.t;
            state->hit.kind = hit.kind;
            setParameter(state->hit.attributes, hit.u);
            return offer(ray.tmax) == kTerminate ? walk::Visit::kEnd : walk::Visit::kContinue;
        }
        if (droppedByFlags(rayFlags, enabled) ||
            losesTie(hit.t, hit.primitive, found, ray.tmax, best.primitive))
            return walk::Visit::kContinue;
        found = true;
        ray.tmax = hit.t;
        best.kind = hit.kind;
        best.primitive = hit.primitive;
        best.sbtGasIndex = hit.sbt & bvh::kSbtIndexMask;
        setParameter(best.attributes, hit.u);
        keepPath();
        ended = rayFlags & kRayTerminateOnFirstHit;
        return ended ? walk::Visit::kEnd : walk::Visit::kContinue;
    }

    SUNSTONE_INLINE_MEMBER bool enterInstance(walk::Ray&, const bvh::InstanceRecord& instance,
                                              uint64_t& child) {
        const auto* const words = reinterpret_cast<const walk::U4*>(&instance);
        const walk::U4 last =
            walk::loadConstant(words + offsetof(InstanceRecord, visibilityMask) / 16);
        if ((last.x & state->visibilityMask & 0xFF) == 0 || !hasRoom())
            return false;
        const walk::U4 from = walk::loadConstant(words + offsetof(InstanceRecord, child) / 16);
        child = walk::wordsOf(from.x, from.y);
        enterWith(makeHandle(&instance, kTagInstance), child);
        return true;
    }
    static_assert(offsetof(InstanceRecord, child) % 16 == 0 &&
                  offsetof(InstanceRecord, visibilityMask) % 16 == 0);

    SUNSTONE_INLINE_MEMBER bool enterTransform(walk::Ray& ray, uint64_t handle, uint64_t& child,
                                               float worldToObject[12]) {
        if (addressOf(handle) == 0 || !hasRoom())
            return false;
        const HandleTag tag = tagOf(handle);
        if constexpr (Records::kVisits) {
            if (sunstone_gpu_hasVisits && tag == kTagVisit) {
                enterVisit(ray, handle);
                return false;
            }
            if (tag == kTagInstance) {
                const InstanceRecord& instance = recordOf(handle);
                for (int i = 0; i < 12; ++i)
                    worldToObject[i] = instance.worldToObject[i];
                return enterInstance(ray, instance, child);
            }
        }
        if (tag == kTagStatic) {
            const auto& still = *reinterpret_cast<const bvh::StaticTransform*>(addressOf(handle));
            for (int i = 0; i < 12; ++i)
                worldToObject[i] = still.inverse[i];
        } else if constexpr (!kMotion) {
            refuseMotion();
            return false;
        } else if ((tag != kTagMatrixMotion && tag != kTagSrtMotion) ||
                   !walk::worldToObjectOf(handle, state->time, this->known, child, worldToObject)) {
            return false;
        }
        if (!kMotion || tag == kTagStatic)
            child = bvh::childOf(handle);
        if (!childLeadsSomewhere(state, child))
            return false;
        enterWith(handle, child);
        return true;
    }

    // Runs the visit program of a selector, which enters the children that it chooses.
    SUNSTONE_INLINE_MEMBER void enterVisit(walk::Ray& ray, uint64_t handle) {
        const auto* const node = reinterpret_cast<const VisitNode*>(addressOf(handle));
        if (++this->visits > kMostNestedVisits)
            endLaunch(state, kFatalVisits);
        showVisit(node, ray.origin, ray.direction, ray.tmax);
        sunstone_gpu_visit(state, groupOf(*state->launch, node->record, kGroupVisit));
        ray.tmax = state->tmax;
        --this->visits;
    }
    SUNSTONE_INLINE_MEMBER bool endsInVisits() const
        requires Records::kVisits
    {
        return sunstone_gpu_hasVisits && ended;
    }
    // The walk below a visit program has levels of its own, but shares the path.
    SUNSTONE_INLINE_MEMBER bool hasRoom() {
        if (!Records::kVisits || !sunstone_gpu_hasVisits || transformCount < kMaxLevels)
            return true;
        refuseLevel();
        return false;
    }

    SUNSTONE_INLINE_MEMBER float time() const { return state->time; }
    static SUNSTONE_INLINE_MEMBER bool meetsKeys() { return sunstone_gpu_motion == kMotionAll; }
    SUNSTONE_INLINE_MEMBER void refuseMotion() { reportOf(state).motion = 1; }

    SUNSTONE_INLINE_MEMBER void enterWith(uint64_t handle, uint64_t child) {
        this->shown = Candidates::kNothingShown;
        if (hasOneLevel()) {
            entered = handle;
            checkChild(state, child, &handle, 1);
            if (sunstone_gpu_graph == kGraphShallow)
                noteDepth(1);
            return;
        }
        keepBest();
        transforms[transformCount++] = entered = handle;
        checkChild(state, child, transforms, transformCount);
        noteDepth(transformCount);
    }
    SUNSTONE_INLINE_MEMBER void noteDepth(uint32_t above) const {
        if (above >= sunstone_gpu_maxGraphDepth(&blockOf(state->launch)))
            reportOf(state).deepGraph = 1;
    }
    // Called before another handle takes the next place of `transforms`.
    SUNSTONE_INLINE_MEMBER void keepBest() {
#pragma clang loop unroll(disable)
        for (uint32_t i = transformCount; i < best.shared; ++i)
            bestTransforms[i] = transforms[i];
        if (best.shared > transformCount)
            best.shared = transformCount;
    }

    // Reports a level below the last one, which is not walked. `handle`: of its traversable, or 0.
    SUNSTONE_INLINE_MEMBER void refuseLevel(uint64_t handle = 0) {
        LaunchReport& report = reportOf(state);
        const bool isShallow =
            sunstone_gpu_graph == kGraphShallow &&
            !(state->launch->traversableGraphFlags & kAllowSingleLevelInstancing);
        (kMaxLevels > 1 || isShallow ? report.deepGraph : report.outsideFlags) = 1;
        if (isShallow && handle != 0) {
            const uint64_t path[] = {entered, handle};
            checkChild(state, handle, path, 2);
        }
    }
    SUNSTONE_INLINE_MEMBER void refuseStack() { endLaunch(state, kFatalGraphTooDeep); }

    SUNSTONE_INLINE_MEMBER void leave(walk::Ray&, uint32_t count = 1) {
        this->shown = Candidates::kNothingShown;
        if constexpr (kMaxLevels > 1) {
            transformCount -= count;
            entered = transformCount != 0 ? transforms[transformCount - 1] : 0;
        } else { // to where the ray began
            beginPath();
        }
    }

    // Moves the best hit into the state and returns the group of its record.
    SUNSTONE_INLINE_MEMBER uint32_t commit(float t) {
        Hit& hit = state->hit;
        hit.t = t;
        hit.kind = best.kind;
        hit.primitive = best.primitive;
        hit.sbtGasIndex = best.sbtGasIndex;
        const Place place = bestPlace();
        setPlace(place);
        for (unsigned i = 0; i < Records::kAttributeWords; ++i)
            hit.attributes[i] = best.attributes[i];
        if (hasOneLevel()) {
            showEntered(best.entered);
        } else {
            hit.transformCount = best.transformCount;
#pragma clang loop unroll(disable)
            for (uint32_t i = 0; i < best.transformCount; ++i)
                hit.transforms[i] = ofBestPath(i);
        }
        state->tmax = t;
        const uint64_t record = hitRecord(best.sbtGasIndex, place.sbtOffset);
        hit.record = reinterpret_cast<const void*>(record);
        state->sbtData = dataOf(record);
        const uint32_t group = record ? groupOf(*state->launch, record, kGroupHit) : kNoGroup;
        noteHit(group, best.sbtGasIndex, place.sbtOffset);
        checkBuiltin(state, group, place.gas, best.sbtGasIndex);
        swapAttributes();
        computeAttributes(group, kClosestHitReads);
        return group;
    }
};

enum class Found : uint32_t { kNothing, kHit, kSilentHit };

// Connects the tracer to the state whose rays it traces.
template <class Programs>
SUNSTONE_INLINE void bind(RayState* state, Programs& tracer, typename Programs::Path& path) {
    tracer.state = state;
    tracer.transforms = path.transforms;
    tracer.bestTransforms = path.best;
}

// Prepares both for the ray that the state requests.
template <class Programs>
SUNSTONE_INLINE void prepare(RayState* state, Programs& tracer, walk::Ray& ray) {
    tracer.rayFlags = state->rayFlags;
    tracer.found = tracer.ended = tracer.candidateAnyHit = false;
    tracer.tmax = 0;
    tracer.candidateGroup = 0;
    tracer.beginPath();
    tracer.best.transformCount = tracer.best.shared = 0;
    if constexpr (Programs::kMotion)
        tracer.known = {};
    for (int i = 0; i < 3; ++i) {
        ray.origin[i] = state->worldOrigin[i];
        ray.direction[i] = state->worldDirection[i];
    }
    ray.tmin = state->tmin;
    ray.tmax = state->tmax;
}

// Starts the walk at the state's traversable. False: there is nothing to walk.
template <class Programs, class Walk>
SUNSTONE_INLINE bool startWalk(RayState* state, Programs& tracer, walk::Ray& ray, Walk& walker,
                               typename Walk::Level* levels) {
    if (walker.start(tracer, ray, state->handle, levels))
        return true;
    if (!Programs::kInstances && tagOf(state->handle) != kTagGas)
        tracer.refuseLevel();
    return false;
}

// The result of the walk; a hit that programs will see moves into the state.
template <class Programs>
SUNSTONE_INLINE Found conclude(Programs& tracer, const walk::Ray& ray, uint32_t& group) {
    if (!tracer.found)
        return Found::kNothing;
    if (tracer.rayFlags & kRayDisableClosestHit)
        return Found::kSilentHit;
    group = tracer.commit(ray.tmax);
    return Found::kHit;
}

template <bool kWithCustoms, unsigned kMaxLevels, bool kWithMotion>
SUNSTONE_DEVICE_PART Found walkGraph(RayState* state, uint32_t& group) {
    using Programs = Tracer<kWithCustoms, kMaxLevels, kWithMotion>;
    using Walk = walk::Traversal<Programs>;
    Programs tracer;
    typename Programs::Path path;
    walk::Ray ray;
    bind(state, tracer, path);
    prepare(state, tracer, ray);
    Walk walker;
    walk::U2 stack[Walk::kStackSize];
    typename Walk::Level levels[kMaxLevels + 1];
    if (startWalk(state, tracer, ray, walker, levels))
        walker.run(tracer, ray, stack, levels, walk::RunToEnd());
    return conclude(tracer, ray, group);
}

// The frame of the walk is freed before closest-hit and miss programs run, which may trace. One
// function serves all rays: two functions, for the nearest hit and for any hit, do not fit into a
// processor's instruction cache together (docs/notes/programs-gpu.md).
template <bool kWithCustoms, unsigned kMaxLevels, bool kWithMotion>
[[gnu::noinline]] static Found findHit(RayState* state, uint32_t& group) {
    return walkGraph<kWithCustoms, kMaxLevels, kWithMotion>(state, group);
}

// Prepares the state for the miss program and returns its group, or kNoGroup.
SUNSTONE_INLINE uint32_t prepareMiss(RayState* state) {
    state->hit.transformCount = 0;
    const uint64_t record = Records::miss(*state);
    checkRecord(state, kExceptionInvalidMissSbt, record, kGroupMiss, state->missIndex);
    state->hit.record = nullptr;
    state->sbtData = dataOf(record);
    const uint32_t group = record ? groupOf(*state->launch, record, kGroupMiss) : kNoGroup;
    noteRecord(state, group, NeededProgram::kMiss, state->missIndex);
    return group;
}

template <bool kInline, bool kWithCustoms, bool kWithMotion>
SUNSTONE_INLINE Found findInGraph(RayState* state, uint32_t& group) {
    constexpr unsigned kAny = kMaxGpuGraphDepth;
    switch (sunstone_gpu_graph) {
    case kGraphGas:
        return kInline ? walkGraph<kWithCustoms, 0, kWithMotion>(state, group)
                       : findHit<kWithCustoms, 0, kWithMotion>(state, group);
    case kGraphSingleLevel:
    case kGraphShallow:
        return kInline ? walkGraph<kWithCustoms, 1, kWithMotion>(state, group)
                       : findHit<kWithCustoms, 1, kWithMotion>(state, group);
    default:
        return kInline ? walkGraph<kWithCustoms, kAny, kWithMotion>(state, group)
                       : findHit<kWithCustoms, kAny, kWithMotion>(state, group);
    }
}

template <bool kInline>
SUNSTONE_INLINE Found find(RayState* state, uint32_t& group) {
    if (sunstone_gpu_motion)
        return sunstone_gpu_hasIntersection ? findInGraph<kInline, true, true>(state, group)
                                            : findInGraph<kInline, false, true>(state, group);
    return sunstone_gpu_hasIntersection ? findInGraph<kInline, true, false>(state, group)
                                        : findInGraph<kInline, false, false>(state, group);
}

// Runs the programs at the end of a ray. `tmax`: the ray's own.
SUNSTONE_INLINE void runPrograms(RayState* state, Found found, uint32_t group, float tmax) {
    if (found == Found::kHit) {
        sunstone_gpu_closestHit(state, group);
    } else if (found == Found::kNothing) {
        state->tmax = tmax;
        sunstone_gpu_miss(state, prepareMiss(state));
    }
}

// Whether the ray may be traced; else it ends without any program.
SUNSTONE_INLINE bool withinDepth(RayState* state) {
    if (state->depth <= state->launch->maxTraceDepth) {
        checkTrace(state);
        return true;
    }
    if (raisesDepth(*state->launch)) {
        state->hit.transformCount = 0;
        raise(state, kExceptionTraceDepth);
    }
    reportOf(state).deepTrace = 1;
    return false;
}

template <bool kInline>
SUNSTONE_INLINE void traceRay(RayState* state) {
    if (!withinDepth(state))
        return;
    const float tmax = state->tmax;
    uint32_t group = 0;
    const Found found = leadsSomewhere(state) ? find<kInline>(state, group) : Found::kNothing;
    runPrograms(state, found, group, tmax);
}

extern "C" [[gnu::noinline]] void sunstone_gpu_trace(RayState* state) {
    traceRay<false>(state);
}

// For the few traces of a ray generation program: its states and the walk stay in registers.
extern "C" __attribute__((always_inline)) void sunstone_gpu_traceInline(RayState* state) {
    traceRay<true>(state);
}

extern "C" __attribute__((always_inline)) uint32_t sunstone_gpu_reportTo(RayState* state,
                                                                         Candidates* to, float t,
                                                                         uint32_t kind) {
    checkHitKind(state, kind);
    Candidates& candidates = *to;
    // The same address, but programs promise that only their argument leads to the state
    // (Unit::declare): the candidates' changes must come from it.
    candidates.state = state;
    if (!inInterval(*state, t, candidates.tmax))
        return kIgnore;
    reportCandidate<Records>(*state, t, kind);
    const uint32_t result =
        Records::kMaterials ? candidates.offerMaterial(kind) : candidates.offer(candidates.tmax);
    state->tmax = candidates.tmax;
    return result;
}

} // namespace sunstone::devlib::gpu
