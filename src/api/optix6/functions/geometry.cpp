// SPDX-License-Identifier: Apache-2.0
// Entry points of geometry (section 5.10).
#include "api/optix6/call.h"
#include "api/optix6/setters.h"

using namespace sunstone;
using namespace sunstone::optix6;

SUNSTONE_API RTresult rtGeometryCreate(RTcontext context, RTgeometry* geometry) {
    return create<Geometry>(__func__, context, "geometry", geometry);
}
SUNSTONE_API RTresult rtGeometryDestroy(RTgeometry geometry) {
    return destroy<Geometry>(__func__, geometry, "geometry");
}
SUNSTONE_API RTresult rtGeometryValidate(RTgeometry geometry) {
    return call<Geometry>(__func__, geometry, "geometry",
                          [](Geometry& object) { object.validate(); });
}
SUNSTONE_API RTresult rtGeometryGetContext(RTgeometry geometry, RTcontext* context) {
    return getContext<Geometry>(__func__, geometry, "geometry", context);
}
SUNSTONE_API RTresult rtGeometrySetPrimitiveCount(RTgeometry geometry, unsigned value) {
    return call<Geometry>(__func__, geometry, "geometry",
                          [&](Geometry& object) { object.primitives = value; });
}
SUNSTONE_API RTresult rtGeometryGetPrimitiveCount(RTgeometry geometry, unsigned* value) {
    return call<Geometry>(__func__, geometry, "geometry", [&](Geometry& object) {
        store(value, "primitiveCount", object.primitives);
    });
}
SUNSTONE_API RTresult rtGeometrySetPrimitiveIndexOffset(RTgeometry geometry, unsigned value) {
    return call<Geometry>(__func__, geometry, "geometry",
                          [&](Geometry& object) { object.indexOffset = value; });
}
SUNSTONE_API RTresult rtGeometryGetPrimitiveIndexOffset(RTgeometry geometry, unsigned* value) {
    return call<Geometry>(__func__, geometry, "geometry", [&](Geometry& object) {
        store(value, "indexOffset", object.indexOffset);
    });
}
SUNSTONE_API RTresult rtGeometrySetMotionSteps(RTgeometry geometry, unsigned n) {
    return call<Geometry>(__func__, geometry, "geometry", [&](auto& object) {
        if (n == 0 || n > kMostMotionSteps)
            refuse(RT_ERROR_INVALID_VALUE, "n = ", n, " is outside 1..", kMostMotionSteps);
        object.motion.steps = n;
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryGetMotionSteps(RTgeometry geometry, unsigned* n) {
    return call<Geometry>(__func__, geometry, "geometry",
                          [&](auto& object) { store(n, "n", object.motion.steps); });
}
SUNSTONE_API RTresult rtGeometrySetMotionRange(RTgeometry geometry, float begin, float end) {
    return call<Geometry>(__func__, geometry, "geometry", [&](auto& object) {
        setMotionRange(object.motion, begin, end);
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryGetMotionRange(RTgeometry geometry, float* begin, float* end) {
    return call<Geometry>(__func__, geometry, "geometry", [&](auto& object) {
        requireNonNull(begin, "timeBegin");
        store(end, "timeEnd", object.motion.end);
        *begin = object.motion.begin;
    });
}
SUNSTONE_API RTresult rtGeometrySetMotionBorderMode(RTgeometry geometry, RTmotionbordermode begin,
                                                    RTmotionbordermode end) {
    return call<Geometry>(__func__, geometry, "geometry", [&](auto& object) {
        setMotionBorders(object.motion, begin, end);
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryGetMotionBorderMode(RTgeometry geometry, RTmotionbordermode* begin,
                                                    RTmotionbordermode* end) {
    return call<Geometry>(__func__, geometry, "geometry", [&](auto& object) {
        requireNonNull(begin, "beginMode");
        store(end, "endMode", object.motion.endMode);
        *begin = object.motion.beginMode;
    });
}
SUNSTONE_API RTresult rtGeometrySetBoundingBoxProgram(RTgeometry geometry, RTprogram handle) {
    return call<Geometry>(__func__, geometry, "geometry", [&](Geometry& object) {
        setProgram(object, object.bounds, handle, compiler::ProgramKind::kBounds);
    });
}
SUNSTONE_API RTresult rtGeometryGetBoundingBoxProgram(RTgeometry geometry, RTprogram* program) {
    return call<Geometry>(__func__, geometry, "geometry", [&](Geometry& object) {
        store(program, "program", static_cast<RTprogram>(handleOf(object.bounds)));
    });
}
SUNSTONE_API RTresult rtGeometrySetIntersectionProgram(RTgeometry geometry, RTprogram handle) {
    return call<Geometry>(__func__, geometry, "geometry", [&](Geometry& object) {
        setProgram(object, object.intersection, handle, compiler::ProgramKind::kIntersection);
    });
}
SUNSTONE_API RTresult rtGeometryGetIntersectionProgram(RTgeometry geometry, RTprogram* program) {
    return call<Geometry>(__func__, geometry, "geometry", [&](Geometry& object) {
        store(program, "program", static_cast<RTprogram>(handleOf(object.intersection)));
    });
}
SUNSTONE_API RTresult rtGeometrySetFlags(RTgeometry geometry, RTgeometryflags value) {
    return call<Geometry>(__func__, geometry, "geometry", [&](Geometry& object) {
        if (unsigned(value) > 3)
            refuse(RT_ERROR_INVALID_VALUE, "flags = ", unsigned(value), " has unknown bits");
        object.flags = value;
    });
}
SUNSTONE_API RTresult rtGeometryGetFlags(RTgeometry geometry, RTgeometryflags* value) {
    return call<Geometry>(__func__, geometry, "geometry",
                          [&](Geometry& object) { store(value, "flags", object.flags); });
}

// Without effect, as in the manual.
SUNSTONE_API RTresult rtGeometryMarkDirty(RTgeometry geometry) {
    return call<Geometry>(__func__, geometry, "geometry", [](Geometry&) {});
}
SUNSTONE_API RTresult rtGeometryIsDirty(RTgeometry geometry, int* dirty) {
    return call<Geometry>(__func__, geometry, "geometry",
                          [&](Geometry&) { store(dirty, "dirty", 0); });
}
