// SPDX-License-Identifier: Apache-2.0
// Entry points of geometry instances and materials (sections 5.9 and 5.12).
#include "api/optix6/call.h"
#include "api/optix6/setters.h"

using namespace sunstone;
using namespace sunstone::optix6;

SUNSTONE_API RTresult rtGeometryInstanceCreate(RTcontext context,
                                               RTgeometryinstance* geometryinstance) {
    return create<GeometryInstance>(__func__, context, "geometryinstance", geometryinstance);
}
SUNSTONE_API RTresult rtGeometryInstanceDestroy(RTgeometryinstance geometryinstance) {
    return destroy<GeometryInstance>(__func__, geometryinstance, "geometryinstance");
}
SUNSTONE_API RTresult rtGeometryInstanceValidate(RTgeometryinstance geometryinstance) {
    return call<GeometryInstance>(__func__, geometryinstance, "geometryinstance",
                                  [](GeometryInstance& object) { object.validate(); });
}
SUNSTONE_API RTresult rtGeometryInstanceGetContext(RTgeometryinstance geometryinstance,
                                                   RTcontext* context) {
    return getContext<GeometryInstance>(__func__, geometryinstance, "geometryinstance", context);
}
SUNSTONE_API RTresult rtGeometryInstanceSetGeometry(RTgeometryinstance instance,
                                                    RTgeometry geometry) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        object.geometry = requireOf<Geometry>(*object.context(), geometry, "geometry");
        object.triangles.reset();
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryInstanceGetGeometry(RTgeometryinstance instance,
                                                    RTgeometry* geometry) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        requireNonNull(geometry, "geometry");
        *geometry = static_cast<RTgeometry>(handleOf(object.geometry));
        if (!*geometry)
            refuse(RT_ERROR_INVALID_VALUE, "the geometry instance has no geometry");
    });
}
SUNSTONE_API RTresult rtGeometryInstanceSetGeometryTriangles(
    RTgeometryinstance instance, RTgeometrytriangles geometrytriangles) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        object.triangles =
            requireOf<GeometryTriangles>(*object.context(), geometrytriangles, "geometrytriangles");
        object.geometry.reset();
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryInstanceGetGeometryTriangles(
    RTgeometryinstance instance, RTgeometrytriangles* geometrytriangles) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        requireNonNull(geometrytriangles, "geometrytriangles");
        *geometrytriangles = static_cast<RTgeometrytriangles>(handleOf(object.triangles));
        if (!*geometrytriangles)
            refuse(RT_ERROR_INVALID_VALUE, "the geometry instance has no geometry triangles");
    });
}
SUNSTONE_API RTresult rtGeometryInstanceSetMaterialCount(RTgeometryinstance instance,
                                                         unsigned count) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        constexpr unsigned kMost = 1u << 16;
        if (count > kMost)
            refuse(RT_ERROR_INVALID_VALUE, "count = ", count, " is above ", kMost);
        object.materials.resize(count);
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryInstanceGetMaterialCount(RTgeometryinstance instance,
                                                         unsigned* count) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        store(count, "count", unsigned(object.materials.size()));
    });
}

namespace {

Ref<Material>& slotOf(GeometryInstance& object, unsigned index) {
    if (index >= object.materials.size())
        refuse(RT_ERROR_INVALID_VALUE, "index = ", index, " of ", object.materials.size(),
               " materials");
    return object.materials[index];
}

} // namespace

SUNSTONE_API RTresult rtGeometryInstanceSetMaterial(RTgeometryinstance instance, unsigned index,
                                                    RTmaterial material) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        slotOf(object, index) = requireOf<Material>(*object.context(), material, "material");
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryInstanceGetMaterial(RTgeometryinstance instance, unsigned index,
                                                    RTmaterial* material) {
    return call<GeometryInstance>(__func__, instance, "geometryinstance", [&](auto& object) {
        const Ref<Material>& slot = slotOf(object, index);
        store(material, "material", static_cast<RTmaterial>(handleOf(slot)));
    });
}

// ---- materials --------------------------------------------------------------------------------

SUNSTONE_API RTresult rtMaterialCreate(RTcontext context, RTmaterial* material) {
    return create<Material>(__func__, context, "material", material);
}
SUNSTONE_API RTresult rtMaterialDestroy(RTmaterial material) {
    return destroy<Material>(__func__, material, "material");
}
SUNSTONE_API RTresult rtMaterialValidate(RTmaterial material) {
    return call<Material>(__func__, material, "material", [](Material&) {});
}
SUNSTONE_API RTresult rtMaterialGetContext(RTmaterial material, RTcontext* context) {
    return getContext<Material>(__func__, material, "material", context);
}

namespace {

void requireRayType(const Material& material, unsigned index) {
    const size_t count = material.context()->misses.size();
    if (index >= count)
        refuse(RT_ERROR_INVALID_VALUE, "rayTypeIndex = ", index, " of ", count, " ray types");
}

} // namespace

SUNSTONE_API RTresult rtMaterialSetClosestHitProgram(RTmaterial material, unsigned rayType,
                                                     RTprogram program) {
    return call<Material>(__func__, material, "material", [&](Material& object) {
        requireRayType(object, rayType);
        Ref<Program> slot;
        setProgram(object, slot, program, compiler::ProgramKind::kClosestHit);
        object.closestHit[rayType] = slot;
    });
}
SUNSTONE_API RTresult rtMaterialGetClosestHitProgram(RTmaterial material, unsigned rayType,
                                                     RTprogram* program) {
    return call<Material>(__func__, material, "material", [&](Material& object) {
        requireRayType(object, rayType);
        const auto found = object.closestHit.find(rayType);
        void* const handle = found == object.closestHit.end() ? nullptr : handleOf(found->second);
        store(program, "program", static_cast<RTprogram>(handle));
    });
}
SUNSTONE_API RTresult rtMaterialSetAnyHitProgram(RTmaterial material, unsigned rayType,
                                                 RTprogram program) {
    return call<Material>(__func__, material, "material", [&](Material& object) {
        requireRayType(object, rayType);
        Ref<Program> slot;
        setProgram(object, slot, program, compiler::ProgramKind::kAnyHit);
        object.anyHit[rayType] = slot;
    });
}
SUNSTONE_API RTresult rtMaterialGetAnyHitProgram(RTmaterial material, unsigned rayType,
                                                 RTprogram* program) {
    return call<Material>(__func__, material, "material", [&](Material& object) {
        requireRayType(object, rayType);
        const auto found = object.anyHit.find(rayType);
        void* const handle = found == object.anyHit.end() ? nullptr : handleOf(found->second);
        store(program, "program", static_cast<RTprogram>(handle));
    });
}
