// SPDX-License-Identifier: Apache-2.0
// Scenes for tests: short forms of calls that make geometry, materials and nodes, and launches of
// rays that look down on them.
#pragma once

#include "support.h"

namespace sunstone::api6 {

class Rays : public Classic {
protected:
    void SetUp() override {
        Classic::SetUp();
        ok(rtVariableSet1f(variable("step"), 0));
        ok(rtVariableSet1ui(variable("ray_type"), 0));
        ok(rtVariableSet1ui(variable("flags"), 0));
        ok(rtVariableSet1f(variable("mark"), 1));
        ok(rtVariableSet1f(variable("height"), 5));
        ok(rtContextSetMissProgram(context_, 0, program("missed")));
        setEntry("shoot");
    }

    // Squares at z = height, height - 1 and so on.
    RTgeometry squares(unsigned count, const char* intersection = "square_hit") {
        RTgeometry made = nullptr;
        ok(rtGeometryCreate(context_, &made));
        ok(rtGeometrySetPrimitiveCount(made, count));
        ok(rtGeometrySetBoundingBoxProgram(made, program("square_bounds")));
        ok(rtGeometrySetIntersectionProgram(made, program(intersection)));
        return made;
    }
    RTgeometrytriangles triangle(float z, bool reversed = false) {
        RTgeometrytriangles made = nullptr;
        ok(rtGeometryTrianglesCreate(context_, &made));
        ok(rtGeometryTrianglesSetPrimitiveCount(made, 1));
        std::vector<float> corners = {0, 0, z, 1, 0, z, 0, 1, z};
        if (reversed)
            corners = {0, 0, z, 0, 1, z, 1, 0, z};
        ok(rtGeometryTrianglesSetVertices(made, 3, filled(RT_FORMAT_FLOAT, corners), 0, 0,
                                          RT_FORMAT_FLOAT3));
        return made;
    }
    RTmaterial material(const char* closest, const char* any = nullptr) {
        RTmaterial made = nullptr;
        ok(rtMaterialCreate(context_, &made));
        if (closest)
            ok(rtMaterialSetClosestHitProgram(made, 0, program(closest)));
        if (any)
            ok(rtMaterialSetAnyHitProgram(made, 0, program(any)));
        return made;
    }
    RTgeometryinstance instance(RTgeometry geometry, std::vector<RTmaterial> materials) {
        RTgeometryinstance made = nullptr;
        ok(rtGeometryInstanceCreate(context_, &made));
        ok(rtGeometryInstanceSetGeometry(made, geometry));
        setMaterials(made, materials);
        return made;
    }
    RTgeometryinstance instance(RTgeometrytriangles geometry, std::vector<RTmaterial> materials) {
        RTgeometryinstance made = nullptr;
        ok(rtGeometryInstanceCreate(context_, &made));
        ok(rtGeometryInstanceSetGeometryTriangles(made, geometry));
        setMaterials(made, materials);
        return made;
    }
    void setMaterials(RTgeometryinstance made, const std::vector<RTmaterial>& materials) {
        ok(rtGeometryInstanceSetMaterialCount(made, unsigned(materials.size())));
        for (unsigned i = 0; i < materials.size(); ++i)
            ok(rtGeometryInstanceSetMaterial(made, i, materials[i]));
    }
    RTacceleration acceleration() {
        RTacceleration made = nullptr;
        ok(rtAccelerationCreate(context_, &made));
        ok(rtAccelerationSetBuilder(made, "Trbvh"));
        return made;
    }
    RTgeometrygroup group(const std::vector<RTgeometryinstance>& children) {
        RTgeometrygroup made = nullptr;
        ok(rtGeometryGroupCreate(context_, &made));
        ok(rtGeometryGroupSetAcceleration(made, acceleration()));
        ok(rtGeometryGroupSetChildCount(made, unsigned(children.size())));
        for (unsigned i = 0; i < children.size(); ++i)
            ok(rtGeometryGroupSetChild(made, i, children[i]));
        return made;
    }
    RTgroup groupOf(const std::vector<RTobject>& children) {
        RTgroup made = nullptr;
        ok(rtGroupCreate(context_, &made));
        ok(rtGroupSetAcceleration(made, acceleration()));
        ok(rtGroupSetChildCount(made, unsigned(children.size())));
        for (unsigned i = 0; i < children.size(); ++i)
            ok(rtGroupSetChild(made, i, children[i]));
        return made;
    }
    RTtransform moved(RTobject child, float x, float y = 0, float z = 0) {
        const float matrix[16] = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1};
        RTtransform made = nullptr;
        ok(rtTransformCreate(context_, &made));
        ok(rtTransformSetMatrix(made, 0, matrix, nullptr));
        ok(rtTransformSetChild(made, child));
        return made;
    }
    template <class Handle, class Declare>
    void setFloat(Handle object, Declare declare, const char* name, float value) {
        RTvariable made = nullptr;
        ok(declare(object, name, &made));
        ok(rtVariableSet1f(made, value));
    }
    std::vector<float> shoot(RTobject top, unsigned count = 1) {
        ok(rtVariableSetObject(variable("top_object"), top));
        ok(rtContextLaunch1D(context_, 0, count));
        return results();
    }
};

} // namespace sunstone::api6
