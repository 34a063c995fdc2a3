// SPDX-License-Identifier: Apache-2.0
// Curves and spheres: their first step, in place of sunstone_references, and their records. Which
// are active, their boxes and their pieces are as on the CPU (bvh/shape_geometry.h). All pieces
// that a segment may have are references; those that it has not are inactive.
#pragma once

#include "bvh/gpu/references.h"
#include "bvh/shape_geometry.h"

namespace sunstone::bvh::gpu {

SUNSTONE_BUILDER bool firstVertex(const DeviceInput& input, uint32_t segment, uint32_t& first) {
    if (!input.indices)
        return false;
    first = *at<const uint32_t>(input.indices + uint64_t(segment) * input.indexStride);
    return true;
}

SUNSTONE_BUILDER void readPoint(const DeviceInput& input, uint32_t vertex, float to[4]) {
    const float* const from = at<const float>(input.data + uint64_t(vertex) * input.stride);
    for (int i = 0; i < 3; ++i)
        to[i] = from[i];
    to[3] = *at<const float>(input.radii + uint64_t(vertex) * input.radiusStride);
}

// Control points of a segment, or centre and radius; NaN, and false, where there are none.
SUNSTONE_BUILDER bool readShape(const BuildJob& job, const DeviceInput& input, uint32_t local,
                                float points[16]) {
    const uint32_t degree = isCurveBasis(job.shape) ? degreeOf(CurveBasis(job.shape)) : 0;
    uint32_t first = local;
    const bool there =
        input.data && input.radii &&
        (job.shape == kSphereShape ||
         (firstVertex(input, local, first) && uint64_t(first) + degree < input.numVertices));
    for (uint32_t i = 0; i <= 3; ++i)
        if (i <= degree && there)
            readPoint(input, first + i, points + 4 * i);
        else
            for (int a = 0; a < 4; ++a)
                points[4 * i + a] = __builtin_nanf("");
    return there;
}

// A strand goes on where the next segment begins one vertex later.
SUNSTONE_BUILDER uint32_t capFlags(const DeviceInput& input, uint32_t numSegments,
                                   uint32_t segment) {
    uint32_t here, other, flags = 0;
    if (!input.caps || !firstVertex(input, segment, here))
        return 0;
    if (segment == 0 || !firstVertex(input, segment - 1, other) || other + 1 != here)
        flags |= kCurveCapBegin;
    if (segment + 1 >= numSegments || !firstVertex(input, segment + 1, other) || other != here + 1)
        flags |= kCurveCapEnd;
    return flags;
}

// Boxes and words of all references of a primitive; the number of those that are active.
SUNSTONE_BUILDER uint32_t referToPieces(const BuildJob& job, uint32_t primitive, bool active,
                                        const ShapePoints& at0, bool split) {
    const uint32_t pieces = active && split ? worthwhilePieces(at0, job.pieces) : 1;
    for (uint32_t k = 0; k < job.pieces; ++k) {
        const uint32_t reference =
            k == 0 ? primitive : job.numPrimitives + primitive * (job.pieces - 1) + k - 1;
        const uint32_t word = pieceWord(primitive, pieces + k);
        Bounds box = emptyBounds();
        const bool used = active && k < pieces;
        if (used)
            shapeBox(at0, word, box.lower, box.upper);
        storeBox(job, reference, used, box);
        if (job.shape != kSphereShape)
            at<uint32_t>(job.origins)[reference] = word;
    }
    return active ? pieces : 0;
}

// What names a sphere, or a piece of a curve (bvh/curves.h).
SUNSTONE_BUILDER uint32_t wholeShape(const BuildJob& job, uint32_t primitive) {
    return job.shape == kSphereShape ? primitive : pieceWord(primitive, 1);
}
SUNSTONE_BUILDER uint32_t wordOfReference(const BuildJob& job, uint32_t reference) {
    return job.shape == kSphereShape ? reference : at<const uint32_t>(job.origins)[reference];
}

// The primitive as it is now, into the array of points, too, if there is one. False if it is
// inactive, else `exact` is the box of the whole primitive.
SUNSTONE_BUILDER bool readIntoPoints(const BuildJob& job, uint32_t primitive, uint32_t local,
                                     const DeviceInput& input, float points[16], Bounds& exact) {
    const bool there = readShape(job, input, local, points);
    const uint32_t floats = shapeFloats(job.shape);
    if (job.points)
        for (uint32_t k = 0; k < floats; ++k)
            at<float>(job.points)[uint64_t(primitive) * floats + k] = points[k];
    const ShapePoints shape = {job.shape, points};
    const bool active = there && isActiveShape(shape);
    if (active)
        shapeBox(shape, pieceWord(primitive, 1), exact.lower, exact.upper);
    return active;
}

// As readIntoPoints; the record tells of the piece alone.
SUNSTONE_BUILDER bool writeShapeRecord(const BuildJob& job, uint32_t place, uint32_t word,
                                       Bounds& exact) {
    const bool sphere = job.shape == kSphereShape;
    const uint32_t primitive = sphere ? word : segmentOf(word);
    const uint32_t i = inputOfPrimitive(job, primitive);
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[i];
    const InputRecord& record = at<const InputRecord>(job.inputRecords)[i];
    const uint32_t local = primitive - record.firstPrimitive;
    const uint32_t reported = local + record.primitiveIndexOffset;
    const uint32_t sbt = sbtWord(input, record, local);
    float points[16];
    const bool active = readIntoPoints(job, primitive, local, input, points, exact);
    if (sphere) {
        U4* const to = at<U4>(job.records + uint64_t(place) * sizeof(SphereRecord));
        to[0] = U4{bitsOf(points[0]), bitsOf(points[1]), bitsOf(points[2]), bitsOf(points[3])};
        to[1] = U4{reported, sbt, 0, 0};
        return active;
    }
    const ShapePoints shape = {job.shape, points};
    float rows[8] = {};
    shapeLane(shape, word, false, rows);
    uint32_t flags = capFlags(input, record.numPrimitives, local);
    if (isBentPiece(shape, word))
        flags |= kCurveBent;
    U4* const to = at<U4>(job.records + uint64_t(place) * sizeof(CurveRecord));
    to[0] = U4{bitsOf(rows[0]), bitsOf(rows[1]), bitsOf(rows[2]), bitsOf(rows[3])};
    to[1] = U4{bitsOf(rows[4]), bitsOf(rows[5]), bitsOf(rows[6]), bitsOf(rows[7])};
    to[2] = U4{word, reported, sbt, flags};
    return active;
}

SUNSTONE_KERNEL sunstone_shapes(BuildJob job) {
    Bounds found = emptyBounds();
    uint32_t numActive = 0, numFurther = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        const uint32_t n = inputOfPrimitive(job, i);
        const DeviceInput& input = at<const DeviceInput>(job.inputs)[n];
        const InputRecord& record = at<const InputRecord>(job.inputRecords)[n];
        const uint32_t local = i - record.firstPrimitive;
        float points[16];
        Bounds box = emptyBounds();
        const bool active = readIntoPoints(job, i, local, input, points, box);
        const uint32_t flags = sbtWord(input, record, local) >> kGeometryFlagShift;
        const uint32_t pieces = referToPieces(job, i, active, {job.shape, points},
                                              !(flags & kGeometryRequireSingleAnyHit));
        if (active) {
            found = unite(found, box);
            ++numActive;
            numFurther += pieces - 1;
        }
    }
    addToCounters(job, found, numActive);
    Counters& counters = countersOf(job);
    if (numFurther)
        atomicAdd(&counters.numTreeReferences, numFurther);
    if (globalThread() == 0) {
        counters.numReferences = job.maxReferences;
        if (job.keepInactive) // they are not split
            counters.numTreeReferences = job.numPrimitives;
    }
}

} // namespace sunstone::bvh::gpu
