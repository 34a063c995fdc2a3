// SPDX-License-Identifier: Apache-2.0
// Curves and spheres: their first step, in place of sunstone_references, and their records. The
// rules for active primitives, boxes and pieces are those of the CPU (bvh/shapes/shape_geometry.h).
// Each segment has references for the largest possible number of pieces; the unused ones are
// inactive.
#pragma once

#include "bvh/gpu/build/references.h"
#include "bvh/shapes/shape_geometry.h"

namespace sunstone::bvh::gpu {

SUNSTONE_INLINE bool firstVertex(const DeviceInput& input, uint32_t segment, uint32_t& first) {
    if (!input.indices)
        return false;
    first = *at<const uint32_t>(input.indices + uint64_t(segment) * input.indexStride);
    return true;
}

SUNSTONE_INLINE void readPoint(const DeviceInput& input, uint32_t vertex, float to[4]) {
    const float* const from = at<const float>(input.data + uint64_t(vertex) * input.stride);
    for (int i = 0; i < 3; ++i)
        to[i] = from[i];
    to[3] = *at<const float>(input.radii + uint64_t(vertex) * input.radiusStride);
}

// Reads the control points of a segment, or a centre and radius. NaN, and false, if an index is
// invalid.
SUNSTONE_INLINE bool readShape(const BuildJob& job, const DeviceInput& input, uint32_t local,
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

// A strand continues if the next segment begins one vertex later.
SUNSTONE_INLINE uint32_t capFlags(const DeviceInput& input, uint32_t numSegments,
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

SUNSTONE_INLINE Bounds boxOfPiece(const ShapePoints& points, uint32_t word) {
    Bounds box;
    shapeBox(points, word, box.lower, box.upper);
    return box;
}

// Stores the boxes and words of all references of a primitive; returns the number of active ones.
// boxOf(word) is the box of a piece.
template <class BoxOf>
SUNSTONE_INLINE uint32_t referToPieces(const BuildJob& job, uint32_t primitive, bool active,
                                       const ShapePoints& at0, bool split, const BoxOf& boxOf) {
    uint32_t pieces = 1;
    if (active && split) {
        PieceBoxes boxes;
        boxesOfPieces(at0, 1, boxes);
        pieces = worthwhilePieces(at0, job.pieces, boxes);
    }
    for (uint32_t k = 0; k < job.pieces; ++k) {
        const uint32_t reference =
            k == 0 ? primitive : job.numPrimitives + primitive * (job.pieces - 1) + k - 1;
        const uint32_t word = pieceWord(primitive, pieces + k);
        const bool used = active && k < pieces;
        storeBox(job, reference, used, used ? boxOf(word) : emptyBounds());
        if (job.shape != kSphereShape)
            at<uint32_t>(job.origins)[reference] = word;
    }
    return active ? pieces : 0;
}

// The word for a whole primitive: a sphere, or a curve in one piece (bvh/shapes/curves.h).
SUNSTONE_INLINE uint32_t wholeShape(const BuildJob& job, uint32_t primitive) {
    return job.shape == kSphereShape ? primitive : pieceWord(primitive, 1);
}
SUNSTONE_INLINE uint32_t wordOfReference(const BuildJob& job, uint32_t reference) {
    return job.shape == kSphereShape ? reference : at<const uint32_t>(job.origins)[reference];
}

// Reads the primitive at the key of `input`, and stores it in the array of points, if any. False if
// it is inactive, else `exact` is the box of the whole primitive.
SUNSTONE_INLINE bool readIntoPoints(const BuildJob& job, uint32_t primitive, uint32_t key,
                                    uint32_t local, const DeviceInput& input, float points[16],
                                    Bounds& exact) {
    const bool there = readShape(job, input, local, points);
    const uint32_t floats = shapeFloats(job.shape);
    if (job.points)
        for (uint32_t k = 0; k < floats; ++k)
            at<float>(job.points)[(uint64_t(primitive) * job.motionKeys + key) * floats + k] =
                points[k];
    const bool active = there && isActiveShape(job.shape, points);
    if (active)
        exact = boxOfPiece({job.shape, points}, pieceWord(primitive, 1));
    return active;
}

// The fields of a record besides its points, and the primitive's input.
struct ShapePlace {
    const DeviceInput* input;
    uint32_t primitive, local, reported, sbt, capFlags;
};
SUNSTONE_INLINE ShapePlace placeOfShape(const BuildJob& job, uint32_t word) {
    const uint32_t primitive = job.shape == kSphereShape ? word : segmentOf(word);
    const uint32_t i = inputOfPrimitive(job, primitive);
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[i];
    const InputRecord& record = at<const InputRecord>(job.inputRecords)[i];
    const uint32_t local = primitive - record.firstPrimitive;
    return {&input,
            primitive,
            local,
            local + record.primitiveIndexOffset,
            sbtWord(input, record, local),
            capFlags(input, record.numPrimitives, local)};
}
SUNSTONE_INLINE void storeSphere(U4* to, const float point[4], const ShapePlace& from) {
    to[0] = U4{bitsOf(point[0]), bitsOf(point[1]), bitsOf(point[2]), bitsOf(point[3])};
    to[1] = U4{from.reported, from.sbt, 0, 0};
}
SUNSTONE_INLINE void storeCurve(U4* to, const float rows[8], uint32_t word, const ShapePlace& from,
                                uint32_t flags) {
    to[0] = U4{bitsOf(rows[0]), bitsOf(rows[1]), bitsOf(rows[2]), bitsOf(rows[3])};
    to[1] = U4{bitsOf(rows[4]), bitsOf(rows[5]), bitsOf(rows[6]), bitsOf(rows[7])};
    to[2] = U4{word, from.reported, from.sbt, from.capFlags | flags};
}

// As readIntoPoints; also writes the record, which describes only the piece.
SUNSTONE_INLINE bool writeShapeRecord(const BuildJob& job, uint32_t place, uint32_t word,
                                      Bounds& exact) {
    const ShapePlace from = placeOfShape(job, word);
    float points[16];
    const bool active =
        readIntoPoints(job, from.primitive, 0, from.local, *from.input, points, exact);
    U4* const to = at<U4>(recordAt(job, place, 0));
    if (job.shape == kSphereShape) {
        storeSphere(to, points, from);
        return active;
    }
    const ShapePoints shape = {job.shape, points};
    float rows[8] = {};
    shapeLane(job.shape, points, word, false, rows);
    storeCurve(to, rows, word, from, isBentPiece(shape, word) ? kCurveBent : 0u);
    return active;
}

// Adds the results to the counters; numFurther: references that are not the first of a primitive.
SUNSTONE_INLINE void countPieces(const BuildJob& job, const Bounds& found, uint32_t numActive,
                                 uint32_t numFurther) {
    addToCounters(job, found, numActive);
    Counters& counters = countersOf(job);
    if (numFurther)
        atomicAdd(&counters.numTreeReferences, numFurther);
    if (globalThread() == 0) {
        counters.numReferences = job.maxReferences;
        if (job.keepInactive) // they are whole
            counters.numTreeReferences = job.numPrimitives;
    }
}

SUNSTONE_INLINE bool maySplit(const ShapePlace& from) {
    return !(from.sbt >> kGeometryFlagShift & kGeometryRequireSingleAnyHit);
}

SUNSTONE_KERNEL sunstone_shapes(BuildJob job) {
    Bounds found = emptyBounds();
    uint32_t numActive = 0, numFurther = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        const ShapePlace from = placeOfShape(job, wholeShape(job, i));
        float points[16];
        Bounds box = emptyBounds();
        const bool active = readIntoPoints(job, i, 0, from.local, *from.input, points, box);
        const ShapePoints shape = {job.shape, points};
        const uint32_t pieces =
            referToPieces(job, i, active, shape, maySplit(from),
                          [&](uint32_t word) { return boxOfPiece(shape, word); });
        if (active) {
            found = unite(found, box);
            ++numActive;
            numFurther += pieces - 1;
        }
    }
    countPieces(job, found, numActive, numFurther);
}

} // namespace sunstone::bvh::gpu
