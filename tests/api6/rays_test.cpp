// SPDX-License-Identifier: Apache-2.0
// Rays: custom geometry with its programs, triangles, materials, any-hit control, groups,
// transforms, masks, dirty and stale acceleration structures.
#include "rays.h"

namespace sunstone::api6 {
namespace {

TEST_F(Rays, HitCustomGeometryOrMiss) {
    RTgeometrygroup top = group({instance(squares(3), {material("hit_mark")})});
    std::vector<float> r = shoot(top);
    EXPECT_EQ(r[0], 1);
    EXPECT_EQ(r[2], 0.5f) << "the attribute of the nearest primitive";
    EXPECT_EQ(r[3], 5) << "the distance";
    ok(rtVariableSet1f(variable("step"), 2));
    r = shoot(top, 2);
    EXPECT_EQ(r[4], -2);
    EXPECT_EQ(r[7], 100) << "tmax of the ray";
}

TEST_F(Rays, PrimitiveIndexOffsetsReachAllPrograms) {
    RTgeometry geometry = squares(2);
    ok(rtGeometrySetPrimitiveIndexOffset(geometry, 2));
    const std::vector<float> r = shoot(group({instance(geometry, {material("hit_mark")})}));
    EXPECT_EQ(r[2], 2.5f);
    EXPECT_EQ(r[3], 7);
}

TEST_F(Rays, HitProgramsLookIntoInstanceThenMaterialThenContext) {
    RTmaterial shared = material("hit_mark");
    RTgeometryinstance one = instance(squares(1), {shared});
    RTgeometrygroup top = group({one});
    EXPECT_EQ(shoot(top)[0], 1);
    setFloat(shared, rtMaterialDeclareVariable, "mark", 2);
    EXPECT_EQ(shoot(top)[0], 2);
    setFloat(one, rtGeometryInstanceDeclareVariable, "mark", 3);
    EXPECT_EQ(shoot(top)[0], 3);
    // The geometry's scope is that of its own programs.
    RTgeometry other = squares(1);
    setFloat(other, rtGeometryDeclareVariable, "mark", 4);
    setFloat(other, rtGeometryDeclareVariable, "height", 6);
    const std::vector<float> r = shoot(group({instance(other, {shared})}));
    EXPECT_EQ(r[0], 2);
    EXPECT_EQ(r[3], 4);
}

TEST_F(Rays, ReportsChooseTheMaterial) {
    RTmaterial first = material("hit_mark", "ignore_any"), second = material("hit_mark");
    setFloat(first, rtMaterialDeclareVariable, "mark", 10);
    setFloat(second, rtMaterialDeclareVariable, "mark", 20);
    ok(rtVariableSet1i(variable("materials"), 2));
    std::vector<float> r = shoot(group({instance(squares(2), {first, second})}));
    EXPECT_EQ(r[0], 20) << "the first material's any-hit program ignores the nearer one";
    EXPECT_EQ(r[1], 1);
    EXPECT_EQ(r[2], 1.5f);
    // A material that the instance lacks: no hit, or an exception.
    r = shoot(group({instance(squares(2), {second})}));
    EXPECT_EQ(r[2], 0.5f);
    ok(rtVariableSet1i(variable("materials"), 100));
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_INDEX_OUT_OF_BOUNDS, 1));
    ok(rtContextSetExceptionProgram(context_, 0, program("note_exception")));
    RTgeometry far = squares(2);
    ok(rtGeometrySetPrimitiveIndexOffset(far, 3));
    EXPECT_EQ(shoot(group({instance(far, {second})}))[1], RT_EXCEPTION_INDEX_OUT_OF_BOUNDS);
}

TEST_F(Rays, AnyHitProgramsIgnoreAndTerminate) {
    EXPECT_EQ(shoot(group({instance(squares(3), {material("hit_mark", "count_any")})}))[0], 1);
    std::vector<float> r =
        shoot(group({instance(squares(3), {material("hit_mark", "ignore_any")})}));
    EXPECT_EQ(r[0], -2);
    EXPECT_EQ(r[1], 3);
    r = shoot(group({instance(squares(3), {material("hit_mark", "terminate_any")})}));
    EXPECT_EQ(r[0], 1) << "the hit is kept";
    EXPECT_EQ(r[1], 1) << "nothing behind rtTerminateRay runs";
    ok(rtVariableSet1ui(variable("flags"), RT_RAY_FLAG_DISABLE_ANYHIT));
    EXPECT_EQ(shoot(group({instance(squares(3), {material("hit_mark", "ignore_any")})}))[1], 0);
}

TEST_F(Rays, OneFunctionMayBeProgramsOfSeveralKinds) {
    ok(rtContextSetMissProgram(context_, 0, program("count_any")));
    ok(rtVariableSet1f(variable("step"), 2));
    const auto shootMoved = [&](const char* closest) {
        RTgeometryinstance square = instance(squares(1), {material(closest, "count_any")});
        return shoot(moved(group({square}), 0.125f), 2);
    };
    std::vector<float> r = shootMoved("count_any");
    EXPECT_EQ(r[1], 2) << "any hit and closest hit";
    EXPECT_EQ(r[3], 0.25f) << "the origin in world space";
    EXPECT_EQ(r[5], 1) << "miss";
    EXPECT_EQ(r[7], 2.25f);
    r = shootMoved(nullptr);
    EXPECT_EQ(r[1], 1);
    EXPECT_EQ(r[3], 0.125f) << "the origin in object space";
}

TEST_F(Rays, AttributesOfTheAcceptedHitSurvive) {
    const std::vector<float> r =
        shoot(group({instance(squares(1, "two_hits"), {material("hit_mark")})}));
    EXPECT_EQ(r[2], 5);
    EXPECT_EQ(r[3], 5);
}

TEST_F(Rays, AttributesOfTheNearestOfManyReports) {
    for (int hits = 1; hits <= 4; ++hits) {
        ok(rtVariableSet1i(variable("hits"), hits));
        const std::vector<float> r =
            shoot(group({instance(squares(1, "many_hits"), {material("hit_mark")})}));
        EXPECT_EQ(r[2], hits);
        EXPECT_EQ(r[3], 9 - hits);
    }
}

TEST_F(Rays, RayTypesHaveProgramsOfTheirOwn) {
    RTmaterial both = material("hit_mark");
    ok(rtMaterialSetClosestHitProgram(both, 1, program("hit_world")));
    RTgeometrygroup top = group({instance(squares(1), {both})});
    EXPECT_EQ(shoot(top)[0], 1);
    ok(rtVariableSet1ui(variable("ray_type"), 1));
    EXPECT_EQ(shoot(top)[0], 0);
    ok(rtVariableSet1ui(variable("ray_type"), 7));
    EXPECT_EQ(shoot(top)[0], -1) << "no such type: nothing runs";
}

TEST_F(Rays, TrianglesHaveBarycentricsFacesAndInstanceNumbers) {
    RTmaterial plain = material("hit_triangle");
    std::vector<float> r =
        shoot(group({instance(triangle(1), {plain}), instance(triangle(5), {plain})}));
    EXPECT_EQ(r[0], 10) << "the second child";
    EXPECT_EQ(r[1], 1 + 2) << "counter-clockwise is the front";
    EXPECT_FLOAT_EQ(r[2], 0.25f);
    EXPECT_FLOAT_EQ(r[3], 0.25f);
    r = shoot(group({instance(triangle(1, true), {plain})}));
    EXPECT_EQ(r[1], 1 + 4);
    ok(rtVariableSet1ui(variable("flags"), RT_RAY_FLAG_CULL_BACK_FACING_TRIANGLES));
    EXPECT_EQ(shoot(group({instance(triangle(1, true), {plain})}))[0], -2);
}

TEST_F(Rays, AttributeProgramsOfTriangles) {
    RTgeometrytriangles mesh = triangle(1);
    ok(rtGeometryTrianglesSetAttributeProgram(mesh, program("attribute_tag")));
    EXPECT_FLOAT_EQ(shoot(group({instance(mesh, {material("hit_tag")})}))[0], 100.25f);
}

// Their values are undefined.
TEST_F(Rays, AttributesThatNoProgramSetsAreReported) {
    std::string reports;
    ok(rtContextSetUsageReportCallback(
        context_,
        [](int, const char*, const char* text, void* all) {
            *static_cast<std::string*>(all) += text;
        },
        1, &reports));
    shoot(group({instance(triangle(1), {material("hit_tag")})}));
    EXPECT_NE(reports.find("program \"hit_tag\" reads attribute \"tag\" with 4 bytes, but the "
                           "triangles have no attribute program"),
              std::string::npos)
        << reports;
    reports.clear();
    shoot(group({instance(triangle(1), {material("hit_triangle")})}));
    EXPECT_EQ(reports, "") << "built-in attributes need no program";
    shoot(group({instance(squares(1), {material("hit_tag")})}));
    EXPECT_NE(reports.find("\"tag\" with 4 bytes, which program \""), std::string::npos) << reports;
    EXPECT_NE(reports.find("\" does not set; its value is undefined"), std::string::npos)
        << reports;
    ok(rtContextSetUsageReportCallback(context_, nullptr, 0, nullptr));
}

TEST_F(Rays, TrianglesAndCustomGeometryInOneGroup) {
    RTmaterial custom = material("hit_mark"), mesh = material("hit_triangle");
    RTgeometrygroup both = group({instance(squares(1), {custom}), instance(triangle(6), {mesh})});
    EXPECT_EQ(shoot(both)[0], 10);
    RTgeometrygroup other = group({instance(squares(1), {custom}), instance(triangle(4), {mesh})});
    EXPECT_EQ(shoot(other)[0], 1);
}

TEST_F(Rays, TransformsMoveRaysAndAreVisible) {
    RTgeometrygroup square = group({instance(squares(1), {material("hit_world", "count_any")})});
    ok(rtVariableSet1f(variable("step"), 3));
    // Directly, below a group, and two above one another.
    for (const RTobject top : {RTobject(moved(square, 3)), RTobject(groupOf({moved(square, 3)})),
                               RTobject(groupOf({moved(groupOf({moved(square, 1)}), 2)}))}) {
        const std::vector<float> r = shoot(top, 2);
        EXPECT_EQ(r[0], -2);
        EXPECT_EQ(r[4], 3) << "origin of object space";
        EXPECT_EQ(r[6], -3) << "world to object";
        EXPECT_EQ(r[5], 1);
        EXPECT_EQ(r[7], 3.25f) << "the ray of closest-hit programs is in world space";
    }
}

TEST_F(Rays, InstancesOfOneGroupHaveTheirOwnMaterials) {
    // One acceleration structure for two groups with equal geometry.
    RTgeometry shape = squares(1);
    RTmaterial a = material("hit_mark"), b = material("hit_mark");
    setFloat(a, rtMaterialDeclareVariable, "mark", 11);
    setFloat(b, rtMaterialDeclareVariable, "mark", 12);
    RTgeometrygroup first = group({instance(shape, {a})}), second = group({instance(shape, {b})});
    RTacceleration shared = nullptr;
    ok(rtGeometryGroupGetAcceleration(first, &shared));
    ok(rtGeometryGroupSetAcceleration(second, shared));
    ok(rtVariableSet1f(variable("step"), 2));
    const std::vector<float> r = shoot(groupOf({first, moved(second, 2)}), 2);
    EXPECT_EQ(r[0], 11);
    EXPECT_EQ(r[4], 12);
}

TEST_F(Rays, GroupsThatShareAnAccelerationHaveTheirOwnChildren) {
    RTmaterial a = material("hit_mark"), b = material("hit_mark");
    setFloat(a, rtMaterialDeclareVariable, "mark", 11);
    setFloat(b, rtMaterialDeclareVariable, "mark", 12);
    RTgroup first = groupOf({group({instance(squares(1), {a})})});
    RTgroup second = groupOf({group({instance(squares(1), {b})})});
    RTacceleration shared = nullptr;
    ok(rtGroupGetAcceleration(first, &shared));
    ok(rtGroupSetAcceleration(second, shared));
    ok(rtVariableSet1f(variable("step"), 2));
    RTgroup top = groupOf({first, moved(second, 2)});
    for (int i = 0; i < 2; ++i) {
        const std::vector<float> r = shoot(top, 2);
        EXPECT_EQ(r[0], 11);
        EXPECT_EQ(r[4], 12);
        ok(rtAccelerationMarkDirty(shared));
    }
    // A group that was not in the graph when the other was rebuilt.
    shoot(first);
    EXPECT_EQ(shoot(top, 2)[4], 12);
}

TEST_F(Rays, GeometryGroupsWithDifferentGeometryCannotShareAnAcceleration) {
    RTmaterial paint = material("hit_mark");
    RTgeometrygroup one = group({instance(squares(1), {paint})});
    RTgeometrygroup two = group({instance(squares(1), {paint}), instance(squares(2), {paint})});
    RTacceleration shared = nullptr;
    ok(rtGeometryGroupGetAcceleration(one, &shared));
    ok(rtGeometryGroupSetAcceleration(two, shared));
    ok(rtVariableSetObject(variable("top_object"), groupOf({one, two})));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "share acceleration");
    EXPECT_EQ(shoot(one)[0], 1);
}

TEST_F(Rays, MasksAreTestedAtEveryGroup) {
    RTgeometrygroup square = group({instance(squares(1), {material("hit_mark")})});
    RTgroup top = groupOf({square});
    ok(rtVariableSet1ui(variable("mask"), 2));
    EXPECT_EQ(shoot(top)[0], 1);
    ok(rtGeometryGroupSetVisibilityMask(square, 1));
    EXPECT_EQ(shoot(top)[0], -2) << "without a new structure";
    EXPECT_EQ(shoot(square)[0], -2);
    ok(rtGeometryGroupSetVisibilityMask(square, 3));
    EXPECT_EQ(shoot(top)[0], 1);
    ok(rtGroupSetVisibilityMask(top, 4));
    EXPECT_EQ(shoot(top)[0], -2);
}

TEST_F(Rays, StructuresAreBuiltWhenDirtyAlone) {
    RTgeometry shape = squares(1);
    RTgeometrygroup top = group({instance(shape, {material("hit_mark")})});
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(top, &built));
    int dirty = 0;
    ok(rtAccelerationIsDirty(built, &dirty));
    EXPECT_EQ(dirty, 1);
    EXPECT_EQ(shoot(top)[3], 5);
    ok(rtAccelerationIsDirty(built, &dirty));
    EXPECT_EQ(dirty, 0);
    ok(rtVariableSet1f(variable("height"), 8)); // the box stays where it was
    EXPECT_EQ(shoot(top)[0], 1) << "this ray still passes the box";
    ok(rtGeometrySetPrimitiveCount(shape, 3));
    ok(rtVariableSet1f(variable("height"), 5));
    EXPECT_EQ(shoot(top)[3], 5);
    ok(rtVariableSet1f(variable("height"), 8));
    ok(rtAccelerationMarkDirty(built));
    EXPECT_EQ(shoot(top)[3], 2);
}

TEST_F(Rays, AChildThatWasBuiltAnewIsFoundByItsParent) {
    RTgeometrygroup square = group({instance(squares(1), {material("hit_mark")})});
    RTgroup top = groupOf({square});
    EXPECT_EQ(shoot(top)[0], 1);
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(square, &built));
    for (int i = 0; i < 3; ++i) {
        ok(rtAccelerationMarkDirty(built)); // of the child alone
        EXPECT_EQ(shoot(top)[0], 1);
    }
    // Fewer children than the parent's structure has.
    ok(rtGroupSetChildCount(top, 0));
    EXPECT_EQ(shoot(top)[0], -2);
}

TEST_F(Rays, IncompleteGraphsAreNamed) {
    RTgeometrygroup top = group({instance(squares(1), {material("hit_mark")})});
    ok(rtVariableSetObject(variable("top_object"), top));
    RTgeometrygroup bare = nullptr;
    ok(rtGeometryGroupCreate(context_, &bare));
    ok(rtVariableSetObject(variable("top_object"), bare));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "has no acceleration");
    fails(RT_ERROR_INVALID_VALUE, rtGeometryGroupValidate(bare), "has no acceleration");
    ok(rtGeometryGroupSetAcceleration(bare, acceleration()));
    EXPECT_EQ(shoot(bare)[0], -2) << "an empty group is never hit";
    ok(rtGeometryGroupSetChildCount(bare, 1));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "child 0");
    RTgeometryinstance hollow = nullptr;
    ok(rtGeometryInstanceCreate(context_, &hollow));
    ok(rtGeometryGroupSetChild(bare, 0, hollow));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "no geometry");
    RTgroup a = groupOf({}), b = groupOf({a});
    ok(rtGroupSetChildCount(a, 1));
    ok(rtGroupSetChild(a, 0, b));
    ok(rtVariableSetObject(variable("top_object"), a));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "below itself");
    EXPECT_EQ(shoot(top)[0], 1) << "the context works on";
}

TEST_F(Rays, FunctionsThatAreNotAllowedAreReportedWithTheProgram) {
    RTgeometrygroup top = group({instance(squares(1), {material("ignore_any")})});
    ok(rtVariableSetObject(variable("top_object"), top));
    fails(RT_ERROR_INVALID_SOURCE, rtContextLaunch1D(context_, 0, 1),
          "cannot be used in closest-hit program \"ignore_any\"");
}

TEST_F(Rays, DestroyedObjectsAreUnset) {
    RTmaterial paint = material("hit_mark");
    RTgeometryinstance square = instance(squares(1), {paint});
    RTgeometrygroup top = group({square});
    EXPECT_EQ(shoot(top)[0], 1);
    ok(rtMaterialDestroy(paint));
    fails(RT_ERROR_INVALID_VALUE, rtMaterialDestroy(paint));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "material 0");
    ok(rtGeometryInstanceSetMaterial(square, 0, material("hit_mark")));
    EXPECT_EQ(shoot(top)[0], 1);
    ok(rtGeometryGroupDestroy(top));
    fails(RT_ERROR_VARIABLE_NOT_FOUND, rtContextLaunch1D(context_, 0, 1), "top_object");
}

class Selectors : public Rays {
protected:
    void SetUp() override {
        Rays::SetUp();
        ok(rtVariableSet1i(variable("chosen"), 0));
    }
    RTgeometrygroup square(float mark, float height, const char* any = nullptr) {
        RTmaterial paint = material("hit_mark", any);
        setFloat(paint, rtMaterialDeclareVariable, "mark", mark);
        RTgeometry shape = squares(1);
        setFloat(shape, rtGeometryDeclareVariable, "height", height);
        return group({instance(shape, {paint})});
    }
    RTselector selector(const std::vector<RTobject>& children, const char* visit = "visit_chosen") {
        RTselector made = nullptr;
        ok(rtSelectorCreate(context_, &made));
        ok(rtSelectorSetVisitProgram(made, program(visit)));
        ok(rtSelectorSetChildCount(made, unsigned(children.size())));
        for (unsigned i = 0; i < children.size(); ++i)
            ok(rtSelectorSetChild(made, i, children[i]));
        return made;
    }
    void choose(int child) { ok(rtVariableSet1i(variable("chosen"), child)); }
};

TEST_F(Selectors, ProgramsChooseAmongChildren) {
    RTselector both = selector({square(1, 5), square(2, 6)});
    for (const RTobject top : {RTobject(both), RTobject(groupOf({both})),
                               RTobject(groupOf({moved(both, 0)})), RTobject(moved(both, 0))}) {
        choose(0);
        EXPECT_EQ(shoot(top)[0], 1);
        choose(1);
        EXPECT_EQ(shoot(top)[0], 2);
        EXPECT_EQ(results()[3], 4);
        choose(-1);
        EXPECT_EQ(shoot(top)[0], 2) << "the nearer hit of both";
    }
}

TEST_F(Selectors, ProgramsSeeTheDistanceOfTheHit) {
    const RTgeometrygroup far = square(1, 5), near = square(2, 6);
    EXPECT_EQ(shoot(selector({far, near}, "visit_until_hit"))[0], 1);
    EXPECT_EQ(shoot(selector({moved(far, 3), near}, "visit_until_hit"))[0], 2);
}

TEST_F(Selectors, ChildrenMayShareAnAcceleration) {
    RTgeometrygroup one = square(1, 5), two = square(2, 5);
    RTacceleration shared = nullptr;
    ok(rtGeometryGroupGetAcceleration(one, &shared));
    ok(rtGeometryGroupSetAcceleration(two, shared));
    RTselector both = selector({one, two});
    for (int i = 0; i < 4; ++i) {
        choose(i % 2);
        EXPECT_EQ(shoot(both)[0], float(1 + i % 2));
        ok(rtAccelerationMarkDirty(shared));
    }
}

TEST_F(Selectors, NestBelowTransformsAndReadTheirOwnVariables) {
    RTselector inner = selector({square(1, 5), square(2, 6)});
    RTselector outer = selector({square(3, 7), moved(inner, 3)});
    for (const auto& [node, child] : {std::pair(inner, 0), std::pair(outer, 1)}) {
        RTvariable made = nullptr;
        ok(rtSelectorDeclareVariable(node, "chosen", &made));
        ok(rtVariableSet1i(made, child));
    }
    ok(rtVariableSet1f(variable("step"), 3));
    const std::vector<float> r = shoot(groupOf({outer}), 2);
    EXPECT_EQ(r[0], -2);
    EXPECT_EQ(r[4], 1);
}

// On GPUs up to four visit programs nest.
TEST_F(Selectors, ManyNest) {
    RTobject top = square(1, 5);
    for (int depth = 1; depth <= 6; ++depth) {
        top = selector({top});
        if (depth <= 4 || !runsOnGpu()) {
            EXPECT_EQ(shoot(top)[0], 1) << depth;
            continue;
        }
        ok(rtVariableSetObject(variable("top_object"), top));
        fails(RT_ERROR_LAUNCH_FAILED, rtContextLaunch1D(context_, 0, 1),
              "more than 4 visit programs");
    }
}

TEST_F(Selectors, TerminatedRaysEndTheVisit) {
    choose(-1);
    const std::vector<float> r =
        shoot(selector({square(1, 5, "terminate_any"), square(2, 6, "terminate_any")}));
    EXPECT_EQ(r[0], 1) << "the second child is nearer, but never entered";
    EXPECT_EQ(r[1], 1);
}

TEST_F(Selectors, ChildrenThatDoNotExistAreAnException) {
    RTselector one = selector({square(1, 5)});
    choose(7);
    EXPECT_EQ(shoot(one)[0], -2);
    ok(rtContextSetExceptionProgram(context_, 0, program("note_exception")));
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_INDEX_OUT_OF_BOUNDS, 1));
    EXPECT_EQ(shoot(one)[1], RT_EXCEPTION_INDEX_OUT_OF_BOUNDS);
    choose(0);
    EXPECT_EQ(shoot(one)[0], 1);
}

TEST_F(Selectors, IncompleteSelectorsAreNamed) {
    RTselector bare = nullptr;
    ok(rtSelectorCreate(context_, &bare));
    ok(rtVariableSetObject(variable("top_object"), bare));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "no visit program");
    fails(RT_ERROR_TYPE_MISMATCH, rtSelectorSetVisitProgram(bare, program("square_hit")));
    ok(rtSelectorSetVisitProgram(bare, program("visit_chosen")));
    EXPECT_EQ(shoot(bare)[0], -2) << "a selector without children is never hit";
    ok(rtSelectorSetChildCount(bare, 1));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "child 0");
}

class MotionTransforms : public Rays {
protected:
    void SetUp() override {
        Rays::SetUp();
        setEntry("shoot_at");
        ok(rtVariableSet1f(variable("step"), 1));
        square_ = group({instance(squares(1), {material("hit_world")})});
    }
    // From x = 0 to x = 4.
    RTtransform moving(RTmotionkeytype type) {
        RTtransform made = moved(square_, 100); // the keys replace the matrix
        const float matrices[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0,
                                    1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0};
        const float parts[32] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,
                                 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 4, 0, 0};
        const bool isSrt = type == RT_MOTIONKEYTYPE_SRT_FLOAT16;
        ok(rtTransformSetMotionKeys(made, 2, type, isSrt ? parts : matrices));
        return made;
    }
    // The number of the ray, among those at x = 0.25, 1.25 and so on, that hits the object; -1:
    // none.
    int column(RTobject top, float time) {
        ok(rtVariableSet1f(variable("ray_time"), time));
        const std::vector<float> r = shoot(top, 8);
        for (int i = 0; i < 8; ++i)
            if (r[size_t(4 * i)] != -2) {
                EXPECT_EQ(r[size_t(4 * i)], float(i)) << "rtTransformPoint";
                EXPECT_EQ(r[size_t(4 * i + 2)], float(-i)) << "rtGetTransform";
                return i;
            }
        return -1;
    }
    RTgeometrygroup square_ = nullptr;
};

TEST_F(MotionTransforms, KeysAreInterpolatedAtTheTimeOfTheRay) {
    for (const RTmotionkeytype type :
         {RT_MOTIONKEYTYPE_MATRIX_FLOAT12, RT_MOTIONKEYTYPE_SRT_FLOAT16}) {
        RTtransform node = moving(type);
        for (const RTobject top : {RTobject(node), RTobject(groupOf({node}))})
            for (int x : {0, 1, 2, 4})
                EXPECT_EQ(column(top, float(x) / 4), x);
        EXPECT_EQ(column(moved(node, 2), 0.5f), 4) << "below a transform without motion";
    }
}

TEST_F(MotionTransforms, RangesAndBordersTakeEffectAtTheNextLaunch) {
    RTtransform node = moving(RT_MOTIONKEYTYPE_MATRIX_FLOAT12);
    RTgroup top = groupOf({node});
    EXPECT_EQ(column(top, 2), 4) << "borders clamp";
    ok(rtTransformSetMotionRange(node, 1, 3));
    EXPECT_EQ(column(top, 2), 2);
    ok(rtTransformSetMotionBorderMode(node, RT_MOTIONBORDERMODE_VANISH, RT_MOTIONBORDERMODE_CLAMP));
    EXPECT_EQ(column(top, 0.5f), -1);
    EXPECT_EQ(column(top, 3.5f), 4);
    ok(rtTransformSetMotionBorderMode(node, RT_MOTIONBORDERMODE_CLAMP, RT_MOTIONBORDERMODE_VANISH));
    EXPECT_EQ(column(top, 0.5f), 0);
    EXPECT_EQ(column(top, 3.5f), -1);
}

TEST_F(MotionTransforms, OneKeyIsTheMatrix) {
    RTtransform node = moving(RT_MOTIONKEYTYPE_SRT_FLOAT16);
    const float key[16] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 3, 0, 0};
    ok(rtTransformSetMotionKeys(node, 1, RT_MOTIONKEYTYPE_SRT_FLOAT16, key));
    float matrix[16], inverse[16];
    ok(rtTransformGetMatrix(node, 0, matrix, inverse));
    EXPECT_EQ(matrix[3], 3);
    EXPECT_EQ(inverse[3], -3);
    RTmotionkeytype type = RT_MOTIONKEYTYPE_SRT_FLOAT16;
    ok(rtTransformGetMotionKeyType(node, &type));
    EXPECT_EQ(type, RT_MOTIONKEYTYPE_NONE);
    EXPECT_EQ(column(node, 0.5f), 3);
}

} // namespace
} // namespace sunstone::api6
