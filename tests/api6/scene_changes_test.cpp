// SPDX-License-Identifier: Apache-2.0
// Changes of a scene between launches: updated structures must give the hits of new ones, and
// structures that are not dirty must not change.
#include "rays.h"

#include <algorithm>
#include <chrono>
#include <cmath>
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
    RTresult launchOn(RTobject top) {
        ok(rtVariableSetObject(variable("top_object"), top));
        return rtContextLaunch1D(context_, 0, 1);
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

// The list of a ray has room for 30 instances and transforms.
TEST_F(SceneChanges, GraphsThatAreTooDeepAreRefused) {
    RTobject node = square_;
    for (int i = 0; i < 30; ++i) // the first of the groups needs no instance
        node = groupOf({moved(node, 0.25f)});
    EXPECT_EQ(at(node, 7.5f, 0), 7.5f);
    node = groupOf({node});
    fails(RT_ERROR_INVALID_VALUE, launchOn(node), "has 31 levels, but the limit is 30");
    RTtransform top = moved(square_, 0);
    for (int i = 0; i < 1000; ++i) // transforms without motion are one matrix
        top = moved(top, 0.25f);
    EXPECT_EQ(at(top, 250, 0), 250);
}

TEST_F(SceneChanges, MotionsThatAreTooDeepAreRefused) {
    const float keys[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const auto chain = [&](int count, bool withGroups) {
        RTobject node = square_;
        for (int i = 0; i < count; ++i) {
            const RTtransform moving = moved(withGroups ? groupOf({node}) : node, 0);
            ok(rtTransformSetMotionKeys(moving, 2, RT_MOTIONKEYTYPE_MATRIX_FLOAT12, keys));
            node = moving;
        }
        return node;
    };
    for (const bool withGroups : {false, true}) {
        EXPECT_EQ(at(chain(15 - withGroups, withGroups), 0, 0), 0) << withGroups;
        fails(RT_ERROR_INVALID_VALUE, launchOn(chain(16, withGroups)), "but the limit is 30");
    }
}

// Programs return boxes for planes that exceed the builders' number range.
TEST_F(SceneChanges, BoxesWithoutAnEnd) {
    RTgeometry endless = squares(1);
    ok(rtGeometrySetBoundingBoxProgram(endless, program("endless_bounds")));
    ok(rtVariableSet1f(variable("height"), 5e-4f));
    ok(rtVariableSet1f(variable("mark"), 1));
    const RTgeometrygroup leaf = group({instance(endless, {material("hit_mark")})});
    const auto scaled = [&](RTobject child, float scale) {
        const float matrix[16] = {scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, 1};
        const RTtransform made = moved(child, 0);
        ok(rtTransformSetMatrix(made, 0, matrix, nullptr));
        return made;
    };
    const RTgroup inner = groupOf({scaled(leaf, 1e4f)});
    const float keys[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const RTtransform moving = moved(inner, 0);
    ok(rtTransformSetMotionKeys(moving, 2, RT_MOTIONKEYTYPE_MATRIX_FLOAT12, keys));
    const RTgroup outer = groupOf({scaled(inner, 1e4f)}), above = groupOf({moving});
    const auto hits = [&](RTobject top) {
        for (const RTacceleration each : {accelerationOf(leaf), accelerationOf(inner),
                                          accelerationOf(outer), accelerationOf(above)})
            ok(rtAccelerationMarkDirty(each));
        return at(top, 0, 0) == 1;
    };
    for (const float extent : {1e30f, 3e38f, INFINITY}) {
        ok(rtVariableSet1f(variable("extent"), extent));
        for (const char* refits : {"0", "1", "1"}) {
            ok(rtAccelerationSetProperty(accelerationOf(inner), "refit", refits));
            EXPECT_TRUE(hits(inner)) << extent;
            EXPECT_TRUE(hits(above)) << extent;
        }
        ok(rtVariableSet1f(variable("height"), 5e-8f));
        EXPECT_TRUE(hits(outer)) << extent;
        ok(rtVariableSet1f(variable("height"), 5e-4f));
    }
    for (const float extent : {-1.0f, -INFINITY, NAN}) {
        ok(rtVariableSet1f(variable("extent"), extent));
        EXPECT_FALSE(hits(inner)) << extent;
    }
}

// Changes that no program can see leave the scene as it is.
TEST_F(SceneChanges, OfUnusedObjects) {
    int scenes = 0;
    ok(rtContextSetUsageReportCallback(
        context_,
        [](int, const char* tag, const char*, void* data) {
            *static_cast<int*>(data) += std::string(tag) == "SCENE STAT";
        },
        2, &scenes));
    const RTgroup top = row(4);
    const auto scenesOf = [&](auto change) {
        EXPECT_EQ(at(top, 2, 0), 2);
        scenes = 0;
        change();
        EXPECT_EQ(at(top, 2, 0), 2);
        return scenes;
    };
    RTbuffer unused = buffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, 4);
    RTmaterial paint = material("hit_head");
    RTprogram idle = program("hit_mark");
    int id = 0;
    EXPECT_EQ(scenesOf([&] { ok(rtBufferGetId(unused, &id)); }), 0);
    EXPECT_EQ(scenesOf([&] { ok(rtBufferDestroy(unused)); }), 0);
    EXPECT_EQ(scenesOf([&] {
                  setFloat(paint, rtMaterialDeclareVariable, "mark", 1);
                  ok(rtMaterialSetAnyHitProgram(paint, 0, idle));
                  instance(squares(1), {paint});
              }),
              0);
    EXPECT_EQ(scenesOf([&] { ok(rtProgramDestroy(idle)); }), 0);
    EXPECT_EQ(scenesOf([&] { ok(rtMaterialDestroy(paint)); }), 0);
    EXPECT_EQ(scenesOf([&] { ok(rtVariableSet1f(variable("nobody_reads"), 1)); }), 0);
    const RTgroup hidden = groupOf({});
    RTtexturesampler sampler = nullptr;
    ok(rtTextureSamplerCreate(context_, &sampler));
    for (const RTobject value : {RTobject(hidden), RTobject(sampler)}) {
        RTvariable unread = nullptr;
        EXPECT_EQ(scenesOf([&] {
                      ok(rtContextDeclareVariable(context_, "unread", &unread));
                      ok(rtVariableSetObject(unread, value));
                  }),
                  0);
        EXPECT_EQ(scenesOf([&] { ok(rtContextRemoveVariable(context_, unread)); }), 0);
    }
    idle = program("multiply");
    EXPECT_EQ(scenesOf([&] { ok(rtProgramGetId(idle, &id)); }), 1) << "it gets a record";
    EXPECT_EQ(scenesOf([&] { ok(rtProgramDestroy(idle)); }), 1);
    EXPECT_EQ(scenesOf([&] { ok(rtGroupSetChild(top, 3, square_)); }), 1);
}

// A launch after no change takes as long with many buffers that have ids as with few.
TEST_F(SceneChanges, UnchangedBuffersCostALaunchNothing) {
    const RTgroup top = row(1);
    const auto quickest = [&] {
        double best = 1e9;
        for (unsigned i = 0; i < 50; ++i) {
            const auto start = std::chrono::steady_clock::now();
            EXPECT_EQ(launchOn(top), RT_SUCCESS);
            const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
            best = std::min(best, time.count());
        }
        return best;
    };
    ok(rtVariableSet3f(variable("ray_origin"), 0.5f, 0.5f, 10));
    const double few = quickest();
    for (unsigned i = 0; i < 20000; ++i) {
        int id = 0;
        ok(rtBufferGetId(buffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, 1), &id));
    }
    EXPECT_LT(quickest(), 5 * few);
}

// Level 1 has errors, level 2 adds created objects, level 3 adds each launch.
TEST_F(SceneChanges, UsageReportsHaveStatistics) {
    std::vector<std::pair<int, std::string>> texts;
    const auto callback = [](int level, const char* tag, const char* text, void* data) {
        static_cast<std::vector<std::pair<int, std::string>>*>(data)->emplace_back(
            level, std::string(tag) + " " + text);
    };
    const auto has = [&](int level, const char* part) {
        return std::any_of(texts.begin(), texts.end(), [&](const auto& each) {
            return each.first == level && each.second.find(part) != std::string::npos;
        });
    };
    ok(rtVariableSet3f(variable("ray_origin"), 0.25f, 0.25f, 10));
    const RTgeometrygroup top = group({instance(triangle(1), {material("hit_head")}),
                                       instance(squares(3), {material("hit_head")})});
    const RTgroup above = groupOf({top});
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(top, &built));
    for (int verbosity : {1, 2, 3}) {
        ok(rtContextSetUsageReportCallback(context_, callback, verbosity, &texts));
        ok(rtAccelerationMarkDirty(built));
        ok(rtMaterialSetClosestHitProgram(material("hit_head"), 0, program("hit_mark")));
        texts.clear();
        ok(rtContextSetEntryPointCount(context_, 1)); // the scene is made again
        shoot(above, 7);
        EXPECT_EQ(texts.empty(), verbosity == 1);
        EXPECT_EQ(has(2, "SCENE STAT 2 nodes, "), verbosity >= 2);
        EXPECT_EQ(has(2, "a build of 1 triangles and "), verbosity >= 2);
        EXPECT_EQ(has(2, "a build of 3 custom primitives and "), verbosity >= 2);
        EXPECT_EQ(has(3, "LAUNCH entry point 0 with 7 by 1 by 1 launch indices in "),
                  verbosity == 3);
        texts.clear();
        shoot(above, 7);
        EXPECT_EQ(texts.size(), verbosity == 3 ? 1u : 0u);
        fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 9, 1));
        EXPECT_TRUE(has(1, "ERROR "));
    }
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
