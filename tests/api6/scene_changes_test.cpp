// SPDX-License-Identifier: Apache-2.0
// Changes of a scene between launches: structures that are brought up to date must answer as new
// ones do, and what is not dirty must stay as it was.
#include "rays.h"

#include <random>

namespace sunstone::api6 {
namespace {

class SceneChanges : public Rays {
protected:
    void SetUp() override {
        Rays::SetUp();
        square_ = group({instance(squares(1), {material("hit_world")})});
    }
    // Copies of the square at x = 2 i.
    RTgroup row(unsigned count) {
        std::vector<RTobject> children;
        for (unsigned i = 0; i < count; ++i) {
            places_.push_back({2 * float(i), 0});
            transforms_.push_back(moved(square_, places_.back().first));
            children.push_back(transforms_.back());
        }
        return groupOf(children);
    }
    static void move(RTtransform transform, float x, float y) {
        const float matrix[16] = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, 0, 0, 0, 0, 1};
        EXPECT_EQ(rtTransformSetMatrix(transform, 0, matrix, nullptr), RT_SUCCESS);
    }
    void move(unsigned i, float x, float y) {
        places_[i] = {x, y};
        move(transforms_[i], x, y);
    }
    template <class Get, class Node>
    RTacceleration accelerationOf(Get get, Node node) {
        RTacceleration found = nullptr;
        ok(get(node, &found));
        return found;
    }
    RTacceleration accelerationOf(RTgroup node) {
        return accelerationOf(rtGroupGetAcceleration, node);
    }
    RTacceleration accelerationOf(RTgeometrygroup node) {
        return accelerationOf(rtGeometryGroupGetAcceleration, node);
    }
    // The result of a ray to the middle of the square at a place: its x, or -2.
    float at(RTobject top, float x, float y) {
        ok(rtVariableSet3f(variable("ray_origin"), x + 0.5f, y + 0.5f, 10));
        return shoot(top)[0];
    }
    void expectAll(RTobject top, const char* when) {
        for (size_t i = 0; i < places_.size(); i += 7)
            EXPECT_EQ(at(top, places_[i].first, places_[i].second), places_[i].first)
                << when << ", square " << i;
    }

    RTgeometrygroup square_ = nullptr;
    std::vector<RTtransform> transforms_;
    std::vector<std::pair<float, float>> places_;
};

TEST_F(SceneChanges, AFewOfManyTransforms) {
    const RTgroup top = row(300);
    expectAll(top, "at first");
    std::mt19937 random(5);
    for (int round = 0; round < 40; ++round) {
        const unsigned moves = 1 + unsigned(random() % 3);
        std::vector<std::pair<unsigned, std::pair<float, float>>> before;
        for (unsigned k = 0; k < moves; ++k) {
            const unsigned i = unsigned(random() % 300);
            before.emplace_back(i, places_[i]);
            move(i, 2 * float(i) + 1000 * float(round % 3), 10 + 4 * float(round));
        }
        ok(rtAccelerationMarkDirty(accelerationOf(top)));
        for (const auto& [i, place] : before) {
            EXPECT_EQ(at(top, places_[i].first, places_[i].second), places_[i].first) << round;
            EXPECT_EQ(at(top, place.first, place.second), -2) << round;
        }
    }
    expectAll(top, "at last");
}

TEST_F(SceneChanges, AllTransforms) {
    const RTgroup top = row(100);
    expectAll(top, "at first");
    for (const char* refits : {"0", "1"}) {
        ok(rtAccelerationSetProperty(accelerationOf(top), "refit", refits));
        for (unsigned i = 0; i < 100; ++i)
            move(i, places_[i].first + 3, places_[i].second + 50);
        ok(rtAccelerationMarkDirty(accelerationOf(top)));
        expectAll(top, refits);
        EXPECT_EQ(at(top, 0, 0), -2);
    }
}

TEST_F(SceneChanges, WithoutADirtyStructureBoxesStayAndRecordsFollow) {
    const RTgroup top = row(10);
    EXPECT_EQ(at(top, 4, 0), 4);
    move(2, 4, 0.25f); // the ray still meets the box
    EXPECT_EQ(at(top, 4, 0), 4);
    move(2, 400, 0);
    EXPECT_EQ(at(top, 400, 0), -2) << "the box is where it was";
    EXPECT_EQ(at(top, 4, 0), -2);
    ok(rtAccelerationMarkDirty(accelerationOf(top)));
    EXPECT_EQ(at(top, 400, 0), 400) << "a move from before is not lost";
}

TEST_F(SceneChanges, RiseThroughNestedGroups) {
    const RTgroup inner = row(20);
    const RTtransform between = moved(inner, 0, 100);
    const RTgroup outer = groupOf({between, square_});
    EXPECT_EQ(at(outer, 6, 100), 6);
    move(3, 600, 5);
    ok(rtAccelerationMarkDirty(accelerationOf(inner)));
    EXPECT_EQ(at(outer, 600, 105), -2) << "the outer box is where it was";
    EXPECT_EQ(at(inner, 600, 5), 600);
    ok(rtAccelerationMarkDirty(accelerationOf(outer)));
    EXPECT_EQ(at(outer, 600, 105), 600);
    EXPECT_EQ(at(outer, 6, 100), -2);
    move(between, 0, 200);
    ok(rtAccelerationMarkDirty(accelerationOf(outer)));
    EXPECT_EQ(at(outer, 600, 205), 600);
    EXPECT_EQ(at(outer, 0, 0), 0) << "the square that stands by itself";
}

// One child gets more geometry, so that the records of hit programs of all others move.
TEST_F(SceneChanges, RecordsOfChildrenThatStay) {
    const auto marked = [&](float mark) {
        const RTgeometryinstance made = instance(squares(1), {material("hit_mark")});
        setFloat(made, rtGeometryInstanceDeclareVariable, "mark", mark);
        return made;
    };
    std::vector<RTobject> children;
    std::vector<RTgeometrygroup> leaves;
    for (int i = 0; i < 12; ++i) {
        leaves.push_back(group({marked(float(i + 1))}));
        children.push_back(moved(leaves.back(), 2 * float(i)));
    }
    const RTgroup top = groupOf(children);
    EXPECT_EQ(at(top, 6, 0), 4);
    for (unsigned count = 2; count < 5; ++count) {
        ok(rtGeometryGroupSetChildCount(leaves[0], count));
        ok(rtGeometryGroupSetChild(leaves[0], count - 1, marked(1)));
        ok(rtAccelerationMarkDirty(accelerationOf(leaves[0])));
        ok(rtAccelerationMarkDirty(accelerationOf(top)));
        for (int i = 0; i < 12; ++i)
            EXPECT_EQ(at(top, 2 * float(i), 0), float(i + 1)) << count;
    }
}

TEST_F(SceneChanges, GeometryThatAllInstancesShare) {
    const RTgroup top = row(50);
    const RTacceleration below = accelerationOf(square_), above = accelerationOf(top);
    for (const char* refits : {"0", "1", "1", "0"}) {
        ok(rtAccelerationSetProperty(below, "refit", refits));
        for (const float height : {6.0f, -300.0f}) {
            ok(rtVariableSet1f(variable("height"), height));
            ok(rtAccelerationMarkDirty(below));
            ok(rtAccelerationMarkDirty(above));
            if (height < 0)
                EXPECT_EQ(at(top, 8, 0), -2) << "behind the end of the ray";
            else
                expectAll(top, refits);
        }
    }
}

TEST_F(SceneChanges, ARefitWithOtherCountsIsABuild) {
    RTgeometry shape = squares(3);
    RTgeometrygroup top = group({instance(shape, {material("hit_mark")})});
    const RTacceleration built = accelerationOf(top);
    ok(rtAccelerationSetProperty(built, "refit", "1"));
    EXPECT_EQ(shoot(top)[3], 5);
    for (const unsigned count : {3u, 1u, 5u}) {
        ok(rtGeometrySetPrimitiveCount(shape, count));
        ok(rtVariableSet1f(variable("height"), float(count)));
        ok(rtAccelerationMarkDirty(built));
        EXPECT_EQ(shoot(top)[3], 10 - float(count));
    }
    ok(rtGeometrySetPrimitiveCount(shape, 0));
    ok(rtAccelerationMarkDirty(built));
    EXPECT_EQ(shoot(top)[0], -2);
}

TEST_F(SceneChanges, NodesThatRaysStartAt) {
    const RTtransform outer = moved(moved(square_, 10), 0, 50);
    EXPECT_EQ(at(outer, 10, 50), 10);
    move(outer, 0, 70);
    EXPECT_EQ(at(outer, 10, 70), 10);
    EXPECT_EQ(at(outer, 10, 50), -2);
    RTtransform inner = nullptr;
    ok(rtTransformGetChild(outer, reinterpret_cast<RTobject*>(&inner)));
    move(inner, 20, 0);
    EXPECT_EQ(at(outer, 20, 70), 20);
}

TEST_F(SceneChanges, ChildrenThatMoveBelowMotionAndSelectors) {
    const RTtransform still = moved(square_, 4);
    RTtransform moving = moved(still, 0);
    const float keys[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 8, 0, 0, 1, 0};
    ok(rtTransformSetMotionKeys(moving, 2, RT_MOTIONKEYTYPE_MATRIX_FLOAT12, keys));
    RTselector chooser = nullptr;
    ok(rtSelectorCreate(context_, &chooser));
    ok(rtSelectorSetVisitProgram(chooser, program("visit_chosen")));
    ok(rtVariableSet1i(variable("chosen"), 0));
    ok(rtSelectorSetChildCount(chooser, 1));
    ok(rtSelectorSetChild(chooser, 0, still));
    const RTgroup top = groupOf({moving, moved(chooser, 0, 30)});
    EXPECT_EQ(at(top, 4, 0), 4);
    EXPECT_EQ(at(top, 4, 30), 4);
    move(still, 90, 0);
    ok(rtAccelerationMarkDirty(accelerationOf(top)));
    EXPECT_EQ(at(top, 90, 0), 90) << "below keys";
    EXPECT_EQ(at(top, 90, 30), 90) << "below a selector";
    EXPECT_EQ(at(top, 4, 0), -2);
}

TEST_F(SceneChanges, ChildrenComeAndGo) {
    const RTgroup top = row(40);
    const RTacceleration above = accelerationOf(top);
    expectAll(top, "at first");
    ok(rtGroupSetChildCount(top, 10));
    EXPECT_EQ(at(top, 60, 0), -2);
    ok(rtGroupSetChildCount(top, 40));
    for (unsigned i = 10; i < 40; ++i) {
        move(i, places_[i].first, 20);
        ok(rtGroupSetChild(top, i, transforms_[i]));
    }
    ok(rtAccelerationMarkDirty(above));
    expectAll(top, "again");
    ok(rtGroupSetChild(top, 7, transforms_[14])); // one node twice
    ok(rtAccelerationMarkDirty(above));
    EXPECT_EQ(at(top, 14, 0), -2);
    EXPECT_EQ(at(top, 28, 20), 28);
    move(14, 500, 0);
    ok(rtAccelerationMarkDirty(above));
    EXPECT_EQ(at(top, 500, 0), 500);
    EXPECT_EQ(at(top, 28, 20), -2);
}

class MotionOfGeometry : public SceneChanges {
protected:
    void SetUp() override {
        SceneChanges::SetUp();
        setEntry("shoot_at");
    }
    // A square that is at (0, y) when its motion begins and at (distance, y) when it ends.
    RTgeometry movingSquare(unsigned steps, float begin, float end, float distance, float y) {
        RTgeometry made = nullptr;
        ok(rtGeometryCreate(context_, &made));
        ok(rtGeometrySetPrimitiveCount(made, 1));
        ok(rtGeometrySetBoundingBoxProgram(made, program("moving_bounds")));
        ok(rtGeometrySetIntersectionProgram(made, program("moving_hit")));
        ok(rtGeometrySetMotionSteps(made, steps));
        ok(rtGeometrySetMotionRange(made, begin, end));
        setFloat(made, rtGeometryDeclareVariable, "motion_begin", begin);
        setFloat(made, rtGeometryDeclareVariable, "motion_end", end);
        setFloat(made, rtGeometryDeclareVariable, "last_step", float(steps - 1));
        setFloat(made, rtGeometryDeclareVariable, "travel", distance);
        setFloat(made, rtGeometryDeclareVariable, "lane", y);
        return made;
    }
    // A triangle that moves in the same way.
    RTgeometrytriangles movingTriangle(float begin, float end, float distance, float y) {
        RTgeometrytriangles made = nullptr;
        ok(rtGeometryTrianglesCreate(context_, &made));
        ok(rtGeometryTrianglesSetPrimitiveCount(made, 1));
        std::vector<float> corners;
        for (const float x : {0.0f, distance})
            corners.insert(corners.end(), {x, y, 5, x + 1, y, 5, x, y + 1, 5});
        ok(rtGeometryTrianglesSetMotionSteps(made, 2));
        ok(rtGeometryTrianglesSetMotionVertices(made, 3, filled(RT_FORMAT_FLOAT, corners), 0, 12,
                                                36, RT_FORMAT_FLOAT3));
        ok(rtGeometryTrianglesSetMotionRange(made, begin, end));
        return made;
    }
    RTmaterial marked(float mark) {
        RTmaterial made = material("hit_mark");
        setFloat(made, rtMaterialDeclareVariable, "mark", mark);
        return made;
    }
    float markAt(RTobject top, float time, float x, float y) {
        ok(rtVariableSet1f(variable("ray_time"), time));
        ok(rtVariableSet3f(variable("ray_origin"), x + 0.25f, y + 0.25f, 10));
        return shoot(top)[0];
    }
};

TEST_F(MotionOfGeometry, OfDifferentStepsAndRangesInOneGroup) {
    RTgeometry still = squares(1);
    setFloat(still, rtGeometryDeclareVariable, "height", 5);
    RTgeometrygroup group6 = group({instance(movingSquare(2, 0, 1, 8, 10), {marked(1)}),
                                    instance(movingTriangle(0, 1, 8, 20), {marked(2)}),
                                    instance(movingSquare(3, 0, 4, 8, 30), {marked(3)}),
                                    instance(triangle(5), {marked(4)}),
                                    instance(movingTriangle(0, 4, 8, 40), {marked(5)}),
                                    instance(movingSquare(2, 0, 1, 4, 50), {marked(6)})});
    for (const RTobject top :
         {RTobject(group6), RTobject(groupOf({group6})), RTobject(groupOf({moved(group6, 0)}))}) {
        EXPECT_EQ(markAt(top, 0.5f, 4, 10), 1);
        EXPECT_EQ(markAt(top, 0.5f, 4, 20), 2);
        EXPECT_EQ(markAt(top, 0.5f, 1, 30), 3);
        EXPECT_EQ(markAt(top, 2, 4, 30), 3);
        EXPECT_EQ(markAt(top, 2, 0, 0), 4);
        EXPECT_EQ(markAt(top, 2, 4, 40), 5);
        EXPECT_EQ(markAt(top, 0.5f, 2, 50), 6);
        EXPECT_EQ(markAt(top, 2, 8, 20), 2) << "its range is over";
        EXPECT_EQ(markAt(top, 2, 4, 20), -2);
    }
}

TEST_F(MotionOfGeometry, ARangeThatChangesIsAnotherStructure) {
    RTgeometrytriangles shape = movingTriangle(0, 1, 8, 0);
    RTgeometrygroup top =
        group({instance(shape, {marked(1)}), instance(movingTriangle(0, 1, 8, 10), {marked(2)})});
    EXPECT_EQ(markAt(top, 0.5f, 4, 0), 1);
    ok(rtGeometryTrianglesSetMotionRange(shape, 0, 2));
    ok(rtAccelerationMarkDirty(accelerationOf(top)));
    EXPECT_EQ(markAt(top, 1, 4, 0), 1);
    EXPECT_EQ(markAt(top, 0.5f, 4, 10), 2);
    ok(rtGeometryTrianglesSetMotionBorderMode(shape, RT_MOTIONBORDERMODE_CLAMP,
                                              RT_MOTIONBORDERMODE_VANISH));
    ok(rtAccelerationMarkDirty(accelerationOf(top)));
    EXPECT_EQ(markAt(top, 3, 8, 0), -2);
    EXPECT_EQ(markAt(top, 3, 8, 10), 2);
}

} // namespace
} // namespace sunstone::api6
