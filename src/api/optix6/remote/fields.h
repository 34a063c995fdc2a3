// SPDX-License-Identifier: Apache-2.0
// The fields of the classic API's objects that a copy of a scene needs: fields(archive, object).
// create() of replica.cpp has the properties that an object cannot change.
#pragma once

#include "api/optix6/context.h"
#include "api/optix6/remote/archive.h"

namespace sunstone::optix6 {

template <class A>
void fields(A& a, Motion& motion) {
    a.all(motion.steps, motion.begin, motion.end, motion.beginMode, motion.endMode);
}

template <class A>
void fields(A& a, EntryPoint& entry) {
    a.all(entry.rayGeneration, entry.exception);
}

template <class A>
void fields(A& a, Context& c) {
    auto count = uint32_t(c.entryPoints.size());
    a.all(count);
    c.entryPoints.resize(count);
    for (EntryPoint& entry : c.entryPoints)
        fields(a, entry);
    a.all(c.misses, c.stackSize, c.maxTraceDepth, c.isTraceDepthSet, c.maxCallableDepth,
          c.exceptions, c.wantsStackChecks, c.printEnabled, c.printIndex);
    // The tables of ids. Their numbers are the application's, because buffers and variables hold
    // them.
    a.all(c.buffers.list(), c.samplers.list(), c.programs.list());
}

template <class A>
void fields(A& a, TextureSampler& s) {
    a.all(s.wrap, s.minFilter, s.magFilter, s.mipFilter, s.anisotropy, s.levelMin, s.levelMax,
          s.levelBias, s.readMode, s.indexMode, s.buffer);
}

template <class A>
void fields(A& a, Geometry& g) {
    a.all(g.primitives, g.indexOffset, g.bounds, g.intersection, g.flags);
    fields(a, g.motion);
}

template <class A>
void fields(A& a, GeometryTriangles& t) {
    a.all(t.primitives, t.indexOffset, t.hasTransform, t.transform);
    a.all(t.indices, t.hasIndices, t.indexByteOffset, t.indexStride, t.indexFormat);
    a.all(t.vertices, t.vertexCount, t.vertexByteOffset, t.vertexStride, t.vertexMotionStride,
          t.vertexFormat, t.buildFlags, t.materialFlags);
    a.all(t.materialIndices, t.hasMaterialIndices, t.materialByteOffset, t.materialStride,
          t.materialFormat, t.attributes);
    fields(a, t.motion);
}

template <class A>
void fields(A& a, Material& m) {
    a.all(m.closestHit, m.anyHit);
}

template <class A>
void fields(A& a, GeometryInstance& i) {
    a.all(i.geometry, i.triangles, i.materials);
}

template <class A>
void fields(A& a, GeometryGroup& g) {
    a.all(g.instances, g.acceleration, g.mask, g.flags);
}

template <class A>
void fields(A& a, Group& g) {
    a.all(g.slots, g.acceleration, g.mask);
}

template <class A>
void fields(A& a, Selector& s) {
    a.all(s.slots, s.visit);
}

template <class A>
void fields(A& a, Transform& t) {
    a.all(t.matrix, t.inverse, t.keyType, t.keys, t.child);
    fields(a, t.motion);
}

} // namespace sunstone::optix6
