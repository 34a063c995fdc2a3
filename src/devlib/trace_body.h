// SPDX-License-Identifier: Apache-2.0
// optixTrace on the CPU, compiled once per instruction set by trace_*.cpp.
//
// A Tracer lives on the stack of one trace call. It walks the graph (instances and transforms by
// recursion, one level deep each), and at each geometry acceleration structure picks a loop:
//   - no program can run and flags drop no hit: bvh::ClosestTriangle or AnyTriangle, which keep
//     the best hit in registers;
//   - otherwise ProgramTriangles or CustomPrimitives, which show each candidate to any-hit and
//     intersection programs through RayState;
//   - MicromapTriangles where triangles have opacity micromaps.
// Structures with motion go through motion_body.h, which interpolates at the ray's time and calls
// the same visitors. The best hit is kept in the Tracer until the end, because RayState::hit is the
// candidate until then. Programs run with the RayState::tmax of the manual: the candidate's t in
// any-hit, the best t in intersection and closest-hit, the ray's own in miss.
//
// trace_checked.cpp also compiles all of this with kChecked, for pipelines with debug exceptions:
// usage that the manual calls undefined then leaves the launch index through LaunchState::raise.
// Other builds contain no checks.
//
// Records (devlib/records.h), a template parameter, defines how an API generation finds the records
// of hits and misses, and whether its graphs have visit programs and its attributes are blocks.
#pragma once

#include "bvh/micromap/micromap_lookup.h"
#include "bvh/motion/motion_traverse.h"
#include "bvh/shapes/shapes.h"
#include "bvh/walk/triangle_visitors.h"
#include "devlib/checks.h"
#include "devlib/hit_rules.h"
#include "devlib/launch_notes.h"
#include "devlib/trace.h"

#include <type_traits>
#include <utility>

#ifdef SUNSTONE_TRACE_CHECKED
#define SUNSTONE_TRACE_SPACE SUNSTONE_ISA::checked
#else
#define SUNSTONE_TRACE_SPACE SUNSTONE_ISA
#endif

namespace sunstone::devlib::SUNSTONE_TRACE_SPACE {

namespace isa = sunstone::bvh::SUNSTONE_ISA;

#ifdef SUNSTONE_TRACE_CHECKED
constexpr bool kChecked = true;
#else
constexpr bool kChecked = false;
#endif

SUNSTONE_INLINE const bvh::BlockHeader* blockOf(uint64_t handle) {
    const uint64_t address = addressOf(handle);
    // Page zero and addresses outside the user half of the address space are invalid.
    if (address - 4096 >= (1ull << 47) - 8192)
        return nullptr;
    const auto* header = reinterpret_cast<const bvh::BlockHeader*>(address);
    return bvh::looksLikeBlock(header) ? header : nullptr;
}

// Whether the handle refers to mapped memory: checked once per handle and thread.
SUNSTONE_INLINE bool isKnown(RayState* state, uint64_t handle) {
    uint64_t& known = state->thread->knownHandles[handle >> 7 & 3];
    if (__builtin_expect(known == handle, 1))
        return true;
    if (!isTraversable(handle))
        return false;
    known = handle;
    return true;
}

// Logs that no program runs at a hit or a miss, because the application's record is missing or
// wrong.
template <class Records>
SUNSTONE_INLINE void noteRecord(const LaunchState& launch, const ResolvedRecord& record,
                                NeededProgram program, uint64_t index) {
    if constexpr (!Records::kOwnRecords)
        if (__builtin_expect(!record.group, 0))
            note(launch, &LaunchNotes::record, recordNote(program, index));
}

// The sides of triangles that a ray passes, below an instance with these flags.
SUNSTONE_INLINE isa::Culling cullingOf(uint32_t rayFlags, uint32_t instanceFlags) {
    if (instanceFlags & kInstanceDisableFaceCulling)
        return {};
    const bool front = rayFlags & kRayCullFront, back = rayFlags & kRayCullBack;
    return instanceFlags & kInstanceFlipFacing ? isa::Culling{back, front}
                                               : isa::Culling{front, back};
}

SUNSTONE_INLINE void transformRay(const float m[12], const float org[3], const float dir[3],
                                  float newOrg[3], float newDir[3]) {
    for (int i = 0; i < 3; ++i) {
        const float* row = m + 4 * i;
        newOrg[i] = row[0] * org[0] + row[1] * org[1] + row[2] * org[2] + row[3];
        newDir[i] = row[0] * dir[0] + row[1] * dir[1] + row[2] * dir[2];
    }
}

template <class Records>
SUNSTONE_INLINE void setBarycentrics(uint32_t* attributes, float v, float w, float det) {
    attributes[0] = isa::bitsOf(v / det);
    attributes[1] = isa::bitsOf(w / det);
    for (unsigned i = 2; i < Records::kAttributeWords; ++i)
        attributes[i] = 0;
}

template <class Records>
class Tracer {
public:
    SUNSTONE_INLINE_MEMBER explicit Tracer(RayState* state)
        : state_(state), launch_(*state->launch), rayFlags_(state->rayFlags), tmax_(state->tmax) {}

    SUNSTONE_INLINE_MEMBER bool found() const { return found_; }

    // Walks the handle's traversable; true ends the trace.
    template <bool kInstancing>
    SUNSTONE_INLINE_MEMBER bool enter(uint64_t handle, const float org[3], const float dir[3]) {
        if constexpr (kChecked)
            checkTraversable(handle);
        if constexpr (kInstancing) {
            const uint64_t tag = tagOf(handle);
            if (tag == kTagIas)
                return enterInstances(handle, org, dir);
            if (tag == kTagStatic)
                return enterStaticTransform(handle, org, dir);
            if (tag == kTagMatrixMotion || tag == kTagSrtMotion)
                return enterMotionTransform(handle, org, dir);
            if constexpr (Records::kVisits)
                if (tag == kTagVisit)
                    return enterVisit(handle, org, dir);
            if constexpr (Records::kVisits)
                if (tag == kTagInstance)
                    return enterLoneInstance(handle, org, dir);
        }
        if (tagOf(handle) != kTagGas) {
            if (!kInstancing && handle != 0)
                excludedByFlags();
            return false;
        }
        const bvh::BlockHeader* block = blockOf(handle);
        if (!block || !isa::isRay(org, dir, state_->tmin, tmax_))
            return false;
        gas_ = handle;
        if (block->type == bvh::BlockType::kTriangles)
            return enterTriangles(block, org, dir);
        if (block->type == bvh::BlockType::kCustom)
            return enterCustoms(block, org, dir);
        if (block->type == bvh::withMicromaps(bvh::BlockType::kTriangles))
            return enterMicromaps(block, org, dir);
        if (bvh::isMoving(block->type))
            return enterMoving(block, org, dir);
        if (block->type == bvh::BlockType::kShapes)
            return enterShapes(block, org, dir);
        return false;
    }

    // Moves the best hit into the state. Returns its hit group, or null.
    SUNSTONE_INLINE_MEMBER const GroupEntry* commit() {
        Hit& hit = state_->hit;
        hit.t = tmax_;
        hit.kind = best_.kind;
        hit.primitive = best_.primitive;
        hit.sbtGasIndex = best_.sbtGasIndex;
        hit.instanceIndex = best_.instanceIndex;
        hit.instanceId = best_.instanceId;
        hit.instanceSbtOffset = best_.instanceSbtOffset;
        hit.gas = best_.gas;
        for (unsigned i = 0; i < Records::kAttributeWords; ++i)
            hit.attributes[i] = best_.attributes[i];
        hit.transformCount = best_.transformCount;
        for (uint32_t i = 0; i < best_.transformCount; ++i)
            hit.transforms[i] = bestTransforms_[i];
        state_->tmax = tmax_;
        if constexpr (Records::kAttributeBlocks)
            std::swap(state_->attributeBlocks[0], state_->attributeBlocks[1]);
        const ResolvedRecord r = hitRecord<false>(best_.sbtGasIndex, best_.instanceSbtOffset);
        noteHit(r, best_.sbtGasIndex, best_.instanceSbtOffset);
        hit.record = r.record;
        state_->sbtData = dataOf(uint64_t(r.record));
        if constexpr (Records::kAttributePrograms)
            computeAttributes(r.group, kClosestHitReads);
        return r.group;
    }

    // optixReportIntersection; `kind` is the material where Records says so.
    uint32_t report(float t, uint32_t kind) {
        if (!inInterval(*state_, t, tmax_))
            return kIgnore;
        reportCandidate<Records>(*state_, t, kind);
        if constexpr (Records::kMaterials)
            return reportMaterial(kind);
        const uint32_t result = offer(candidateGroup_, candidateAnyHit_);
        state_->tmax = tmax_;
        return result;
    }

    // Walks a child of the node whose visit program runs, in the space of that node.
    uint32_t visitChild(uint32_t index) {
        const VisitNode& node = *state_->visited;
        if (index >= node.count || !isKnown(state_, node.children[index]))
            return kAccept;
        const float* const org = visitOrigin_;
        const float* const dir = visitDirection_;
        const bool end = enter<true>(node.children[index], org, dir);
        if (end)
            return kTerminate;
        visitOrigin_ = org;
        visitDirection_ = dir;
        showNode(&node);
        return kAccept;
    }

private:
    // The values of RayState::hit but for t and the transform list.
    struct Best {
        uint32_t kind, primitive, sbtGasIndex, instanceIndex, instanceId, instanceSbtOffset;
        uint32_t transformCount;
        uint64_t gas;
        uint32_t attributes[Records::kAttributeWords];
    };

    // kWalking: of a candidate, while the walk is at its place.
    template <bool kWalking>
    SUNSTONE_INLINE_MEMBER ResolvedRecord hitRecord(uint32_t sbtGasIndex,
                                                    uint32_t instanceSbtOffset) const {
        const ResolvedRecord record =
            resolve(launch_, Records::hit(*state_, sbtGasIndex, instanceSbtOffset), kGroupHit);
        if constexpr (kChecked)
            if (!record.group) {
                if (kWalking)
                    exposePath();
                state_->hit.sbtGasIndex = sbtGasIndex;
                ExceptionInfo info{};
                info.sbtOffset =
                    uint32_t(Records::hitIndex(*state_, sbtGasIndex, instanceSbtOffset));
                launch_.raise(state_, kExceptionInvalidHitSbt, &info);
            }
        if constexpr (kChecked)
            if (!fitsBuiltin(*record.group, blockOf(kWalking ? gas_ : best_.gas), sbtGasIndex)) {
                if (kWalking)
                    exposePath();
                launch_.raise(state_, kExceptionBuiltinIsMismatch, nullptr);
            }
        return record;
    }

    SUNSTONE_INLINE_MEMBER void noteHit(const ResolvedRecord& record, uint32_t sbtGasIndex,
                                        uint32_t instanceSbtOffset) const {
        noteRecord<Records>(launch_, record, NeededProgram::kHit,
                            Records::hitIndex(*state_, sbtGasIndex, instanceSbtOffset));
    }

    // Stores the current path for an exception program.
    void exposePath() const {
        Hit& hit = state_->hit;
        hit.transformCount = transformCount_;
        for (uint32_t i = 0; i < transformCount_; ++i)
            hit.transforms[i] = transforms_[i];
    }

    // Called where the graph is deeper than declared. The manual requires an exception if
    // exceptions are enabled and leaves the rest open: otherwise the walk continues as far as
    // transform lists reach, and the log reports it. True: the walk must stop.
    [[gnu::noinline]] bool tooDeep() const {
        if ((launch_.exceptionFlags & (kFlagTraceDepth | kFlagDebug)) && launch_.raise) {
            exposePath();
            launch_.raise(state_, kExceptionTraversalDepth, nullptr);
        }
        note(launch_, &LaunchNotes::deepGraph);
        return transformCount_ + 2 > kMaxGraphDepth;
    }

    // Whether the child of an instance or transform that is entered now would be too deep. Every
    // entry of the transform list is one traversable above it.
    SUNSTONE_INLINE_MEMBER bool isDeepest() const {
        return transformCount_ + 2 > launch_.maxGraphDepth;
    }

    // Two kinds of traversables that a pipeline's options may exclude. Rays ignore them, and the
    // log reports them. Both return false: nothing ends the trace.
    bool excludedByFlags() const {
        note(launch_, &LaunchNotes::outsideFlags);
        return false;
    }
    bool excludedAsMoving() const {
        note(launch_, &LaunchNotes::motion);
        return false;
    }

    // Whether flags exclude an instance or transform below those already entered.
    SUNSTONE_INLINE_MEMBER bool flagsExcludeLevel() const {
        return __builtin_expect(transformCount_ != 0, 0) &&
               (launch_.traversableGraphFlags & kAllowSingleLevelInstancing) != 0;
    }

    // Raises the exception of a traversable that does not fit the pipeline. The null handle is
    // never hit.
    void checkTraversable(uint64_t handle) const {
        if (handle == 0)
            return;
        if (transformCount_ + 1 > launch_.maxGraphDepth)
            tooDeep();
        const int32_t code = faultOf(handle);
        if (code == 0)
            return;
        exposePath();
        ExceptionInfo info{};
        if (code == kExceptionUnsupportedPrimitive)
            info.line = state_->line;
        else
            info.traversable = handle;
        launch_.raise(state_, code, &info);
    }

    // Handles an address that is not mapped.
    void checkUnknown(uint64_t handle) const {
        if (handle == 0)
            return;
        exposePath();
        ExceptionInfo info{};
        info.traversable = handle;
        launch_.raise(state_, kExceptionInvalidTraversable, &info);
    }

    int32_t faultOf(uint64_t handle) const {
        const HandleTag tag = tagOf(handle);
        const bool isStructure = tag == kTagGas || tag == kTagIas;
        return faultOfTraversable(launch_, tag, isStructure ? blockOf(handle) : nullptr,
                                  transformCount_);
    }

    SUNSTONE_INLINE_MEMBER isa::Culling culling() const {
        return cullingOf(rayFlags_, instanceFlags_);
    }

    // Gives the candidate another record of its build input, until the report ends.
    uint32_t reportMaterial(uint32_t material) {
        if (!Records::hasMaterial(*state_, material)) {
            if (const int32_t code = Records::materialFault(*state_))
                launch_.raise(state_, code, nullptr);
            return kIgnore;
        }
        if (material == 0) { // the state already shows its record
            const uint32_t result = offer(candidateGroup_, candidateAnyHit_);
            state_->tmax = tmax_;
            return result;
        }
        Hit& hit = state_->hit;
        const uint32_t first = hit.sbtGasIndex;
        const void* const record = hit.record;
        hit.sbtGasIndex = first + material;
        const ResolvedRecord r = hitRecord<true>(hit.sbtGasIndex, instanceSbtOffset_);
        hit.record = r.record;
        state_->sbtData = dataOf(uint64_t(r.record));
        const uint32_t result = offer(r.group, candidateAnyHit_);
        hit.sbtGasIndex = first;
        hit.record = record;
        state_->sbtData = dataOf(uint64_t(record));
        state_->tmax = tmax_;
        return result;
    }

    // Computes the attributes of a triangle's hit before a program that reads them runs.
    void computeAttributes(const GroupEntry* group, uint32_t reader) {
        if (state_->hit.kind < kHitTriangleFront || !Records::readsAttributes(*state_, reader))
            return;
        Records::setTriangleAttributes(*state_);
        if (const ProgramFn program = group ? group->program(kRoleAttribute) : nullptr)
            program(state_);
    }

    // Passes the candidate in state->hit to the any-hit program and takes it unless that rejects
    // it.
    uint32_t offer(const GroupEntry* group, bool runAnyHit) {
        uint32_t result = kAccept;
        const ProgramFn anyHit = runAnyHit && group ? group->program(kRoleAnyHit) : nullptr;
        if (anyHit) {
            state_->tmax = state_->hit.t;
            if constexpr (Records::kAttributePrograms)
                computeAttributes(group, kAnyHitReads);
            result = anyHit(state_);
            if (result == kIgnore)
                return kIgnore;
        }
        found_ = true;
        tmax_ = state_->hit.t;
        keepCandidate<Records>(state_->hit, best_);
        if constexpr (Records::kAttributeBlocks)
            std::swap(state_->attributeBlocks[0], state_->attributeBlocks[1]);
        keepPath();
        ended_ = endsRay(result, rayFlags_);
        return ended_ ? kTerminate : kAccept;
    }

    SUNSTONE_INLINE_MEMBER void keepPath() {
        best_.instanceIndex = instanceIndex_;
        best_.instanceId = instanceId_;
        best_.instanceSbtOffset = instanceSbtOffset_;
        best_.gas = gas_;
        best_.transformCount = transformCount_;
        for (uint32_t i = 0; i < transformCount_; ++i)
            bestTransforms_[i] = transforms_[i];
    }

    // Stores a candidate for programs. False if flags drop it. kNeedsProgram: without any-hit
    // program, too.
    template <bool kNeedsProgram = false>
    SUNSTONE_INLINE_MEMBER bool startCandidate(uint32_t primitive, uint32_t sbtWord) {
        const bool enabled = anyHitEnabled(instanceFlags_, sbtWord);
        if (droppedByFlags(rayFlags_, enabled))
            return false;
        candidateAnyHit_ = anyHitRuns(rayFlags_, enabled);
        Hit& hit = state_->hit;
        hit.primitive = primitive;
        hit.sbtGasIndex = sbtWord & bvh::kSbtIndexMask;
        const ResolvedRecord r = hitRecord<true>(hit.sbtGasIndex, instanceSbtOffset_);
        if (kNeedsProgram || candidateAnyHit_)
            noteHit(r, hit.sbtGasIndex, instanceSbtOffset_);
        candidateGroup_ = r.group;
        hit.record = r.record;
        state_->sbtData = dataOf(uint64_t(r.record));
        return true;
    }

    // Stores the data that all candidates in a geometry acceleration structure share.
    void startPrograms(const float org[3], const float dir[3]) {
        for (int i = 0; i < 3; ++i) {
            state_->objectOrigin[i] = org[i];
            state_->objectDirection[i] = dir[i];
        }
        Hit& hit = state_->hit;
        hit.instanceIndex = instanceIndex_;
        hit.instanceId = instanceId_;
        hit.instanceSbtOffset = instanceSbtOffset_;
        hit.gas = gas_;
        hit.transformCount = transformCount_;
        for (uint32_t i = 0; i < transformCount_; ++i)
            hit.transforms[i] = transforms_[i];
        state_->traversal = this;
    }

    // Candidate triangles one by one.
    struct ProgramTriangles {
        static constexpr bool kOrdered = true;
        Tracer& tracer;
        const isa::RaySetup& setup;
        isa::Culling culling;
        float tmax;

        template <class F, class Leaf>
        SUNSTONE_INLINE_MEMBER bool visit(const Leaf& leaf) {
            constexpr unsigned N = F::kLanes;
            isa::TriangleCandidates<N> c;
            for (isa::Mask m = isa::testTriangles<N, F>(leaf, setup, tmax, c); m; m &= m - 1) {
                const unsigned i = isa::lowestBit(m);
                if (c.t[i] > tmax || culling.drops(c.det[i], leaf.sbt[i]))
                    continue;
                if (tracer.offerTriangle(c.t[i], c.v[i], c.w[i], c.det[i], leaf.primitive[i],
                                         leaf.sbt[i]) == kTerminate)
                    return true;
                tmax = tracer.tmax_;
            }
            return false;
        }
        SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, bvh::NodeRef ref) {
            return isa::visitTriangles(*this, block, ref);
        }
    };

    [[gnu::noinline]] uint32_t offerTriangle(float t, float v, float w, float det,
                                             uint32_t primitive, uint32_t sbtWord) {
        if (!startCandidate(primitive, sbtWord))
            return kIgnore;
        Hit& hit = state_->hit;
        hit.t = t;
        hit.kind = triangleKind(det, instanceFlags_);
        setBarycentrics<Records>(hit.attributes, v, w, det);
        return offer(candidateGroup_, candidateAnyHit_);
    }

    // Triangles of a structure with opacity micromaps. The state at the ray's hit replaces the
    // geometry flag DISABLE_ANYHIT; instance and ray flags apply after it.
    template <bool kAll>
    struct MicromapTriangles {
        static constexpr bool kOrdered = kAll;
        Tracer& tracer;
        const isa::RaySetup& setup;
        isa::Culling culling;
        isa::MicromapLookup micromaps;
        bool twoStates;
        float tmax;

        template <class F, class Leaf>
        SUNSTONE_INLINE_MEMBER bool visit(const Leaf& leaf) {
            constexpr unsigned N = F::kLanes;
            isa::TriangleCandidates<N> c;
            for (isa::Mask m = isa::testTriangles<N, F>(leaf, setup, tmax, c); m; m &= m - 1) {
                const unsigned i = isa::lowestBit(m);
                if (c.t[i] > tmax || culling.drops(c.det[i], leaf.sbt[i]))
                    continue;
                uint32_t sbtWord = leaf.sbt[i];
                const uint32_t state = micromaps.stateAt(leaf.primitive[i], sbtWord,
                                                         c.v[i] / c.det[i], c.w[i] / c.det[i]);
                if (!isa::throughMicromap(state, twoStates, sbtWord))
                    continue;
                if (tracer.takeTriangle(c.t[i], c.v[i], c.w[i], c.det[i], leaf.primitive[i],
                                        sbtWord) == kTerminate)
                    return true;
                tmax = tracer.tmax_;
            }
            return false;
        }

        SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, bvh::NodeRef ref) {
            return isa::visitTriangles(*this, block, ref);
        }
    };

    // Without an any-hit program there is no record to look up.
    uint32_t takeTriangle(float t, float v, float w, float det, uint32_t primitive,
                          uint32_t sbtWord) {
        const bool enabled = anyHitEnabled(instanceFlags_, sbtWord);
        if (launch_.hasAnyHit && anyHitRuns(rayFlags_, enabled))
            return offerTriangle(t, v, w, det, primitive, sbtWord);
        if (droppedByFlags(rayFlags_, enabled) ||
            losesTie(t, primitive, found_, tmax_, best_.primitive))
            return kIgnore;
        found_ = true;
        tmax_ = t;
        best_.kind = triangleKind(det, instanceFlags_);
        best_.primitive = primitive;
        best_.sbtGasIndex = sbtWord & bvh::kSbtIndexMask;
        setBarycentrics<Records>(best_.attributes, v, w, det);
        keepPath();
        ended_ = rayFlags_ & kRayTerminateOnFirstHit;
        return ended_ ? kTerminate : kAccept;
    }

    template <bool kAll>
    bool walkMicromaps(const bvh::BlockHeader* block, const isa::RaySetup& setup) {
        const bool twoStates = (rayFlags_ & kRayForceMicromap2State) ||
                               (instanceFlags_ & kInstanceForceMicromap2State);
        MicromapTriangles<kAll> visitor{*this,     setup, culling(), isa::MicromapLookup(block),
                                        twoStates, tmax_};
        isa::traverse(block, setup, visitor);
        return ended_;
    }

    [[gnu::noinline]] bool enterMicromaps(const bvh::BlockHeader* block, const float org[3],
                                          const float dir[3]) {
        if (!launch_.opacityMicromaps || (instanceFlags_ & kInstanceDisableMicromaps))
            return enterTriangles(block, org, dir);
        isa::RaySetup setup;
        isa::setupRay(setup, block, org, dir, state_->tmin, tmax_);
        startPrograms(org, dir);
        if (rayFlags_ & kRayTerminateOnFirstHit)
            return walkMicromaps<false>(block, setup);
        return walkMicromaps<true>(block, setup);
    }

    SUNSTONE_INLINE_MEMBER bool programsMayRun(const bvh::BlockHeader* block) const {
        return devlib::programsMayRun(launch_, rayFlags_, instanceFlags_, block->geometryFlagsAnd);
    }

    SUNSTONE_INLINE_MEMBER bool enterTriangles(const bvh::BlockHeader* block, const float org[3],
                                               const float dir[3]) {
        isa::RaySetup setup;
        isa::setupRay(setup, block, org, dir, state_->tmin, tmax_);
        if (programsMayRun(block))
            return walkWithPrograms(block, setup, org, dir);
        if ((rayFlags_ & kRayTerminateOnFirstHit) == 0)
            return walkClosest<true>(block, setup);
        if (rayFlags_ & kRayDisableClosestHit)
            return walkOccluded(block, setup);
        return walkClosest<false>(block, setup);
    }

    [[gnu::noinline]] bool walkWithPrograms(const bvh::BlockHeader* block,
                                            const isa::RaySetup& setup, const float org[3],
                                            const float dir[3]) {
        startPrograms(org, dir);
        ProgramTriangles visitor{*this, setup, culling(), tmax_};
        isa::traverse(block, setup, visitor);
        return ended_;
    }

    // No program sees the hit: the closest-hit program is disabled.
    [[gnu::noinline]] bool walkOccluded(const bvh::BlockHeader* block, const isa::RaySetup& setup) {
        isa::AnyTriangle visitor(setup, tmax_, culling());
        isa::traverse(block, setup, visitor);
        return takeOccluded(visitor.found);
    }
    SUNSTONE_INLINE_MEMBER bool takeOccluded(bool found) {
        found_ = found_ || found;
        ended_ = found;
        if (found) {
            best_ = {};
            best_.kind = kHitTriangleFront;
            keepPath();
        }
        return ended_;
    }

    struct FirstTriangle : isa::ClosestTriangle {
        static constexpr bool kOrdered = false;
        using ClosestTriangle::ClosestTriangle;
        template <class F, class Leaf>
        SUNSTONE_INLINE_MEMBER bool visit(const Leaf& leaf) {
            ClosestTriangle::visit<F>(leaf);
            return found;
        }
        SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, bvh::NodeRef ref) {
            return isa::visitTriangles(*this, block, ref);
        }
    };

    template <bool kAll>
    using ClosestVisitor = std::conditional_t<kAll, isa::ClosestTriangle, FirstTriangle>;

    template <bool kAll>
    [[gnu::noinline]] bool walkClosest(const bvh::BlockHeader* block, const isa::RaySetup& setup) {
        ClosestVisitor<kAll> visitor(setup, tmax_, culling());
        isa::traverse(block, setup, visitor);
        return takeClosest<kAll>(visitor);
    }
    template <bool kAll>
    SUNSTONE_INLINE_MEMBER bool takeClosest(const isa::ClosestTriangle& visitor) {
        if (!visitor.found)
            return false;
        found_ = true;
        tmax_ = visitor.tmax;
        best_.kind = triangleKind(visitor.det, instanceFlags_);
        best_.primitive = visitor.primitive;
        best_.sbtGasIndex = visitor.sbt & bvh::kSbtIndexMask;
        setBarycentrics<Records>(best_.attributes, visitor.v, visitor.w, visitor.det);
        keepPath();
        ended_ = !kAll;
        return ended_;
    }

    struct CustomPrimitives {
        static constexpr bool kOrdered = true;
        Tracer& tracer;
        float tmax;
        SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, bvh::NodeRef ref) {
            const auto* leaf = reinterpret_cast<const bvh::CustomLeaf*>(block + bvh::offsetOf(ref));
            const bool end = tracer.intersectCustom(leaf->primitive, leaf->sbt);
            tmax = tracer.tmax_;
            return end;
        }
    };

    [[gnu::noinline]] bool intersectCustom(uint32_t primitive, uint32_t sbtWord) {
        if (!startCandidate<true>(primitive, sbtWord) || !candidateGroup_ ||
            !candidateGroup_->program(kRoleIntersection))
            return false;
        state_->tmax = tmax_;
        candidateGroup_->program(kRoleIntersection)(state_);
        return ended_;
    }

    // If the structure has only one primitive, the root is its leaf, and no node above has tested
    // its box: intersection programs may rely on running only where the ray meets the box.
    static bool meetsBounds(const float lower[3], const float upper[3], const isa::RaySetup& s,
                            float tmax) {
        const auto distance = [&](int axis, float plane, float r, float c) {
            if constexpr (isa::kFusedSlab)
                return __builtin_fmaf(plane, r, c);
            else
                return (plane - s.org[axis]) * r + c;
        };
        float enter = isa::larger(s.tmin, 0.0f), leave = tmax;
        for (int i = 0; i < 3; ++i) {
            const bool backwards = s.isBackwards(i);
            const float low = lower[i], high = upper[i];
            enter = isa::larger(distance(i, backwards ? high : low, s.nearR[i], s.nearC[i]), enter);
            leave = isa::smaller(distance(i, backwards ? low : high, s.farR[i], s.farC[i]), leave);
        }
        return enter <= leave;
    }

    [[gnu::noinline]] bool enterCustoms(const bvh::BlockHeader* block, const float org[3],
                                        const float dir[3]) {
        isa::RaySetup setup;
        isa::setupRay(setup, block, org, dir, state_->tmin, tmax_);
        if ((block->root & bvh::kNodeTagMask) != bvh::kInner &&
            !meetsBounds(block->lower, block->upper, setup, tmax_))
            return false;
        startPrograms(org, dir);
        CustomPrimitives visitor{*this, tmax_};
        isa::traverse(block, setup, visitor);
        return ended_;
    }

    // Curves and spheres: bvh/shapes/shapes.h tests hits and runs no programs.
    [[gnu::noinline]] bool enterShapes(const bvh::BlockHeader* block, const float org[3],
                                       const float dir[3]) {
        const bvh::ShapeRay ray = {
            {org[0], org[1], org[2]}, state_->tmin, {dir[0], dir[1], dir[2]}, tmax_, state_->time};
        if (programsMayRun(block)) {
            startPrograms(org, dir);
            isa::kShapes.filtered(block, ray, {offerShape, this});
            return ended_;
        }
        bvh::ShapeHit hit;
        const bool first = rayFlags_ & kRayTerminateOnFirstHit;
        if (!(first ? isa::kShapes.any : isa::kShapes.closest)(block, ray, hit) ||
            losesTie(hit.t, hit.primitive, found_, tmax_, best_.primitive))
            return false;
        found_ = true;
        tmax_ = hit.t;
        best_ = {};
        best_.kind = hit.kind;
        best_.primitive = hit.primitive;
        best_.sbtGasIndex = hit.sbt & bvh::kSbtIndexMask;
        best_.attributes[0] = isa::bitsOf(hit.u);
        keepPath();
        ended_ = first;
        return ended_;
    }

    static bvh::ShapeFilter::Answer offerShape(void* context, const bvh::ShapeHit& from) {
        Tracer& tracer = *static_cast<Tracer*>(context);
        if (!tracer.startCandidate(from.primitive, from.sbt))
            return bvh::ShapeFilter::kIgnore;
        Hit& hit = tracer.state_->hit;
        hit.t = from.t;
        hit.kind = from.kind;
        hit.attributes[0] = isa::bitsOf(from.u);
        for (unsigned i = 1; i < Records::kAttributeWords; ++i)
            hit.attributes[i] = 0;
        const uint32_t result = tracer.offer(tracer.candidateGroup_, tracer.candidateAnyHit_);
        return result == kIgnore      ? bvh::ShapeFilter::kIgnore
               : result == kTerminate ? bvh::ShapeFilter::kEnd
                                      : bvh::ShapeFilter::kAccept;
    }

    struct Instances {
        static constexpr bool kOrdered = true;
        Tracer& tracer;
        const float *org, *dir;
        float tmax;
        SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, bvh::NodeRef ref) {
            const auto* record =
                reinterpret_cast<const InstanceRecord*>(block + bvh::offsetOf(ref));
            if ((record->visibilityMask & tracer.state_->visibilityMask & 0xFF) == 0)
                return false;
            const bool end = tracer.enterInstance(*record, org, dir);
            tmax = tracer.tmax_;
            return end;
        }
    };

    [[gnu::noinline]] bool enterInstances(uint64_t handle, const float org[3], const float dir[3]) {
        const bvh::BlockHeader* block = blockOf(handle);
        if (!block || !isa::isRay(org, dir, state_->tmin, tmax_))
            return false;
        if (__builtin_expect(iasCount_ != 0, 0) && isInside(handle))
            return false;
        iasPath_[iasCount_++] = handle;
        if (block->type != bvh::BlockType::kInstances) {
            enterMovingInstances(block, org, dir);
            --iasCount_;
            return ended_;
        }
        isa::RaySetup setup;
        isa::setupRay(setup, block, org, dir, state_->tmin, tmax_);
        Instances visitor{*this, org, dir, tmax_};
        isa::traverse(block, setup, visitor);
        --iasCount_;
        return ended_;
    }

    // A graph with a cycle (updates can make one) would be walked without end, despite the limit of
    // its depth: instances of a structure within itself are never hit.
    [[gnu::noinline]] bool isInside(uint64_t handle) const {
        for (uint32_t i = 0; i < iasCount_; ++i)
            if (iasPath_[i] == handle)
                return true;
        return false;
    }

    [[gnu::noinline]] bool enterInstance(const InstanceRecord& record, const float org[3],
                                         const float dir[3]) {
        if (flagsExcludeLevel())
            return excludedByFlags();
        if (isDeepest() && tooDeep())
            return false;
        float newOrg[3], newDir[3];
        transformRay(record.worldToObject, org, dir, newOrg, newDir);
        const uint32_t index = instanceIndex_, id = instanceId_, offset = instanceSbtOffset_,
                       flags = instanceFlags_;
        instanceIndex_ = record.index;
        instanceId_ = record.instanceId;
        instanceSbtOffset_ = offset + record.sbtOffset;
        instanceFlags_ = record.flags;
        transforms_[transformCount_++] = makeHandle(&record, kTagInstance);
        const bool end = enter<true>(record.child, newOrg, newDir);
        --transformCount_;
        instanceIndex_ = index;
        instanceId_ = id;
        instanceSbtOffset_ = offset;
        instanceFlags_ = flags;
        return end;
    }

    [[gnu::noinline]] bool enterStaticTransform(uint64_t handle, const float org[3],
                                                const float dir[3]) {
        if (flagsExcludeLevel())
            return excludedByFlags();
        if (isDeepest() && tooDeep())
            return false;
        if (addressOf(handle) == 0)
            return false;
        const auto* transform = reinterpret_cast<const bvh::StaticTransform*>(addressOf(handle));
        if (!isKnown(state_, transform->child)) {
            if constexpr (kChecked)
                checkUnknown(transform->child);
            note(launch_, &LaunchNotes::unknown, transform->child);
            return false;
        }
        float newOrg[3], newDir[3];
        transformRay(transform->inverse, org, dir, newOrg, newDir);
        transforms_[transformCount_++] = handle;
        const bool end = enter<true>(transform->child, newOrg, newDir);
        --transformCount_;
        return end;
    }

    // An instance that no structure holds.
    [[gnu::noinline]] bool enterLoneInstance(uint64_t handle, const float org[3],
                                             const float dir[3]) {
        const auto* record = reinterpret_cast<const InstanceRecord*>(addressOf(handle));
        if ((record->visibilityMask & state_->visibilityMask & 0xFF) == 0)
            return false;
        return enterInstance(*record, org, dir);
    }

    // The program calls visitChild for the children that it chooses.
    [[gnu::noinline]] bool enterVisit(uint64_t handle, const float org[3], const float dir[3]) {
        if (isDeepest() && tooDeep())
            return false;
        const auto* node = reinterpret_cast<const VisitNode*>(addressOf(handle));
        const ResolvedRecord r = resolve(launch_, node->record, kGroupVisit);
        if (!r.group || !r.group->program(kRoleMain))
            return false;
        visitOrigin_ = org;
        visitDirection_ = dir;
        showNode(node);
        r.group->program(kRoleMain)(state_);
        return ended_;
    }
    // Turns the state into that of the node's visit program.
    void showNode(const VisitNode* node) {
        startPrograms(visitOrigin_, visitDirection_);
        state_->visited = node;
        state_->tmax = tmax_;
        state_->sbtData = dataOf(node->record);
    }

    // motion_body.h
    [[gnu::noinline]] bool enterMoving(const bvh::BlockHeader* block, const float org[3],
                                       const float dir[3]);
    [[gnu::noinline]] bool enterMovingInstances(const bvh::BlockHeader* block, const float org[3],
                                                const float dir[3]);
    [[gnu::noinline]] bool enterMotionTransform(uint64_t handle, const float org[3],
                                                const float dir[3]);
    bool enterMovingTriangles(const isa::MovingNodes& nodes, const bvh::BlockHeader* block,
                              bvh::KeySegment at, const isa::RaySetup& setup);
    bool enterMovingCustoms(const isa::MovingNodes& nodes, const bvh::BlockHeader* block,
                            bvh::KeySegment at, const isa::RaySetup& setup);
    template <bool kAll>
    bool walkMovingMicromaps(const isa::MovingNodes& nodes, const bvh::BlockHeader* block,
                             bvh::KeySegment at, const isa::RaySetup& setup);

    RayState* const state_;
    const LaunchState& launch_;
    const uint32_t rayFlags_;
    float tmax_; // of the best hit, or the ray's
    bool found_ = false, ended_ = false;
    // Place of the walk in the graph.
    uint32_t instanceIndex_ = 0, instanceId_ = ~0u, instanceSbtOffset_ = 0, instanceFlags_ = 0;
    uint32_t transformCount_ = 0, iasCount_ = 0;
    uint64_t gas_ = 0;
    const GroupEntry* candidateGroup_ = nullptr;
    bool candidateAnyHit_ = false;
    Best best_;
    const float *visitOrigin_ = nullptr,
                *visitDirection_ = nullptr; // of the ray at state_->visited
    uint64_t transforms_[kMaxGraphDepth];
    uint64_t bestTransforms_[kMaxGraphDepth];
    uint64_t iasPath_[kMaxGraphDepth + 1]; // at least one transform is between two of them
};

} // namespace sunstone::devlib::SUNSTONE_TRACE_SPACE

#include "devlib/motion_body.h"

namespace sunstone::devlib::SUNSTONE_TRACE_SPACE {

// Turns the state into that of the miss program. Returns the program, or null.
template <class Records>
[[gnu::noinline]] static ProgramFn startMiss(RayState* state) {
    const ResolvedRecord r = resolve(*state->launch, Records::miss(*state), kGroupMiss);
    if constexpr (kChecked)
        if (!r.group) {
            state->hit.transformCount = 0;
            ExceptionInfo info{};
            info.sbtOffset = state->missIndex;
            state->launch->raise(state, kExceptionInvalidMissSbt, &info);
        }
    noteRecord<Records>(*state->launch, r, NeededProgram::kMiss, state->missIndex);
    state->hit.record = nullptr;
    state->hit.transformCount = 0;
    state->sbtData = dataOf(uint64_t(r.record));
    return r.group ? r.group->program(kRoleMain) : nullptr;
}

// Walks the graph; returns the closest-hit program to run, or null. Separate from trace(), so that
// its frame is freed before programs run, which may trace.
template <class Records, bool kInstancing>
[[gnu::noinline]] static ProgramFn findHit(RayState* state, bool& found) {
    Tracer<Records> tracer(state);
    tracer.template enter<kInstancing>(state->handle, state->worldOrigin, state->worldDirection);
    found = tracer.found();
    if (!found || (state->rayFlags & kRayDisableClosestHit))
        return nullptr;
    const GroupEntry* group = tracer.commit();
    return group ? group->program(kRoleMain) : nullptr;
}

[[gnu::noinline]] static void raiseWithoutPath(RayState* state, int32_t code,
                                               const ExceptionInfo* info = nullptr) {
    state->hit.transformCount = 0;
    if (state->launch->raise)
        state->launch->raise(state, code, info);
}

// Walks, and stores the hit or the miss in the state. Returns the program to run, or null.
template <class Records, bool kInstancing>
SUNSTONE_INLINE ProgramFn walkRay(RayState* state) {
    const LaunchState& launch = *state->launch;
    // The state is a part of the caller's frame.
    if (__builtin_expect(reinterpret_cast<uint64_t>(state) < state->thread->stackLimit, 0)) {
        raiseWithoutPath(state, kExceptionStackOverflow);
        return nullptr;
    }
    if (state->depth > launch.maxTraceDepth) {
        if (launch.exceptionFlags & kFlagTraceDepth)
            raiseWithoutPath(state, kExceptionTraceDepth);
        note(launch, &LaunchNotes::deepTrace);
        return nullptr;
    }
    if constexpr (kChecked)
        checkRay(state);
    const float tmax = state->tmax;
    bool found = false;
    if (!isKnown(state, state->handle)) {
        if constexpr (kChecked)
            if (state->handle != 0) {
                ExceptionInfo info{};
                info.traversable = state->handle;
                raiseWithoutPath(state, kExceptionInvalidTraversable, &info);
            }
        note(launch, &LaunchNotes::unknown, state->handle);
        return startMiss<Records>(state);
    }
    const ProgramFn closestHit = findHit<Records, kInstancing>(state, found);
    if (found)
        return closestHit;
    state->tmax = tmax;
    return startMiss<Records>(state);
}

template <class Records, bool kInstancing>
static void trace(RayState* state) {
    if (const ProgramFn program = walkRay<Records, kInstancing>(state))
        program(state);
}

template <class Records>
static uint32_t report(RayState* state, float t, uint32_t kind) {
    if constexpr (kChecked)
        if (kind > 127)
            state->launch->raise(state, kExceptionInvalidArgument0 - 1, nullptr);
    return static_cast<Tracer<Records>*>(state->traversal)->report(t, kind);
}

template <class Records>
static uint32_t visitChild(RayState* state, uint32_t index) {
    return static_cast<Tracer<Records>*>(state->traversal)->visitChild(index);
}

} // namespace sunstone::devlib::SUNSTONE_TRACE_SPACE
