// SPDX-License-Identifier: Apache-2.0
// Curves and spheres with motion keys: as shapes.h, at every key. The rules for active primitives
// and for pieces (by the first key) are those of the CPU (bvh/shapes/shape_input.h,
// shape_build.cpp).
#pragma once

#include "bvh/gpu/build/motion_references.h"
#include "bvh/gpu/build/shapes.h"

namespace sunstone::bvh::gpu {

// Stores the points of all keys in the array of points, if any. False if the primitive is inactive
// at a key; else `all` bounds it at all keys.
SUNSTONE_INLINE bool readMovingIntoPoints(const BuildJob& job, const ShapePlace& from,
                                          Bounds& all) {
    bool active = true;
    all = emptyBounds();
    for (uint32_t key = 0; key < job.motionKeys; ++key) {
        float points[16];
        Bounds box = emptyBounds();
        if (!readIntoPoints(job, from.primitive, key, from.local, atKey(*from.input, key), points,
                            box))
            active = false;
        all = unite(all, box);
    }
    return active;
}

SUNSTONE_KERNEL sunstone_moving_shapes(BuildJob job) {
    Bounds found = emptyBounds();
    uint32_t numActive = 0, numFurther = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        const ShapePlace from = placeOfShape(job, wholeShape(job, i));
        Bounds all;
        const bool active = readMovingIntoPoints(job, from, all);
        float points[16];
        const auto meanBox = [&](uint32_t word) {
            KeySum sum = noKeys();
            for (uint32_t key = 0; key < job.motionKeys; ++key) {
                readShape(job, atKey(*from.input, key), from.local, points);
                addKey(sum, boxOfPiece({job.shape, points}, word));
            }
            return meanOf(sum, job.motionKeys);
        };
        float first[16];
        readShape(job, atKey(*from.input, 0), from.local, first);
        const uint32_t pieces =
            referToPieces(job, i, active, {job.shape, first}, maySplit(from), meanBox);
        if (active) {
            found = unite(found, all);
            ++numActive;
            numFurther += pieces - 1;
        }
    }
    countPieces(job, found, numActive, numFurther);
}

// A record's data of a piece at a key. Radii of linear segments are clamped after interpolation, as
// on the CPU.
SUNSTONE_INLINE void movingRows(const ShapePoints& shape, uint32_t word, float rows[8]) {
    shapeLane(shape.shape, shape.points, word, true, rows);
    if (CurveBasis(shape.shape) == CurveBasis::kLinear) {
        rows[6] = shape.points[3];
        rows[7] = shape.points[7];
    }
}

// As writeShapeRecord, at all keys. Between keys a curve may take any form.
SUNSTONE_INLINE bool writeMovingShapeRecord(const BuildJob& job, uint32_t place, uint32_t word,
                                            Bounds& exact) {
    const ShapePlace from = placeOfShape(job, word);
    const bool active = readMovingIntoPoints(job, from, exact);
    for (uint32_t key = 0; key < job.motionKeys; ++key) {
        float points[16], rows[8] = {};
        readShape(job, atKey(*from.input, key), from.local, points);
        if (!active)
            for (float& x : points)
                x = __builtin_nanf("");
        U4* const to = at<U4>(recordAt(job, place, key));
        if (job.shape == kSphereShape) {
            storeSphere(to, points, from);
            continue;
        }
        movingRows({job.shape, points}, word, rows);
        storeCurve(to, rows, word, from, kCurveBent);
    }
    return active;
}

// The box of a record's piece at a key, or of the whole primitive; empty if it is inactive.
SUNSTONE_INLINE Bounds boxOfMovingRecord(const BuildJob& job, uint32_t place, uint32_t key,
                                         bool whole) {
    const U4* const record = at<const U4>(recordAt(job, place, key));
    const U4 a = record[0], b = record[1];
    if (floatOf(a.x) != floatOf(a.x))
        return emptyBounds();
    float points[16] = {floatOf(a.x), floatOf(a.y), floatOf(a.z), floatOf(a.w)};
    if (job.shape == kSphereShape)
        return boxOfPiece({job.shape, points}, 0);
    const uint32_t word = record[2].x;
    if (CurveBasis(job.shape) == CurveBasis::kLinear) { // the ends, then the radii
        points[3] = floatOf(b.z);
        points[4] = floatOf(a.w);
        points[5] = floatOf(b.x);
        points[6] = floatOf(b.y);
        points[7] = floatOf(b.w);
    } else {
        const uint32_t floats = shapeFloats(job.shape);
        const uint64_t from = (uint64_t(segmentOf(word)) * job.motionKeys + key) * floats;
        for (uint32_t i = 0; i < floats; ++i)
            points[i] = at<const float>(job.points)[from + i];
    }
    return boxOfPiece({job.shape, points}, whole ? pieceWord(segmentOf(word), 1) : word);
}

} // namespace sunstone::bvh::gpu
