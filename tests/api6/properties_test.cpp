// SPDX-License-Identifier: Apache-2.0
// Properties of objects: each set value is read back, and values that the manual excludes are
// refused without effect.
#include "rays.h"

#include <array>
#include <cmath>

namespace sunstone::api6 {
namespace {

class Properties : public Rays {
protected:
    // Sets each valid value and reads it back; then sets each invalid value, which must not change
    // the last valid one.
    template <class Object, class Value, class Given>
    void roundTrip(Object object, RTresult (*set)(Object, Given), RTresult (*get)(Object, Value*),
                   std::vector<Given> good, std::vector<Given> bad = {}) {
        Value value{};
        for (const Given each : good) {
            ok(set(object, each));
            ok(get(object, &value));
            EXPECT_EQ(value, Value(each));
        }
        for (const Given each : bad) {
            fails(RT_ERROR_INVALID_VALUE, set(object, each));
            ok(get(object, &value));
            EXPECT_EQ(value, Value(good.back()));
        }
    }
    template <class Object>
    void motion(Object object, RTresult (*setSteps)(Object, unsigned),
                RTresult (*getSteps)(Object, unsigned*), RTresult (*setRange)(Object, float, float),
                RTresult (*getRange)(Object, float*, float*),
                RTresult (*setBorders)(Object, RTmotionbordermode, RTmotionbordermode),
                RTresult (*getBorders)(Object, RTmotionbordermode*, RTmotionbordermode*)) {
        float begin = -1, end = -1;
        ok(getRange(object, &begin, &end));
        EXPECT_EQ(begin, 0);
        EXPECT_EQ(end, 1);
        if (setSteps)
            roundTrip(object, setSteps, getSteps, {1u, 2u, 7u}, {0u, 0x10000u});
        ok(setRange(object, -2, 3));
        for (const auto& [from, to] :
             {std::pair(4.0f, 3.0f), std::pair(NAN, 1.0f), std::pair(0.0f, INFINITY)})
            fails(RT_ERROR_INVALID_VALUE, setRange(object, from, to), "range");
        ok(getRange(object, &begin, &end));
        EXPECT_EQ(begin, -2);
        EXPECT_EQ(end, 3);
        RTmotionbordermode first{}, last{};
        ok(setBorders(object, RT_MOTIONBORDERMODE_VANISH, RT_MOTIONBORDERMODE_CLAMP));
        fails(RT_ERROR_INVALID_VALUE,
              setBorders(object, RTmotionbordermode(7), RT_MOTIONBORDERMODE_CLAMP), "mode 7");
        ok(getBorders(object, &first, &last));
        EXPECT_EQ(first, RT_MOTIONBORDERMODE_VANISH);
        EXPECT_EQ(last, RT_MOTIONBORDERMODE_CLAMP);
    }
    // An object's context, its variables and its end.
    template <class Object>
    void life(Object object, RTresult (*getContext)(Object, RTcontext*),
              RTresult (*destroy)(Object)) {
        RTcontext owner = nullptr;
        ok(getContext(object, &owner));
        EXPECT_EQ(owner, context_);
        ok(destroy(object));
        fails(RT_ERROR_INVALID_VALUE, getContext(object, &owner));
        if (last_)
            expectLastVariableIsGone();
    }
    template <class Object>
    void scope(Object object, RTresult (*declare)(Object, const char*, RTvariable*),
               RTresult (*query)(Object, const char*, RTvariable*),
               RTresult (*remove)(Object, RTvariable), RTresult (*count)(Object, unsigned*),
               RTresult (*at)(Object, unsigned, RTvariable*), RTresult outside) {
        unsigned before = 0, after = 0;
        ok(count(object, &before));
        RTvariable made = nullptr, found = nullptr;
        ok(declare(object, "some::name", &made));
        fails(RT_ERROR_VARIABLE_REDECLARED, declare(object, "some::name", &found), "some::name");
        EXPECT_EQ(found, nullptr);
        fails(RT_ERROR_ILLEGAL_SYMBOL, declare(object, "0bad", &found), "0bad");
        ok(query(object, "some::name", &found));
        EXPECT_EQ(found, made);
        ok(query(object, "nothing", &found));
        EXPECT_EQ(found, nullptr);
        ok(count(object, &after));
        EXPECT_EQ(after, before + 1);
        ok(at(object, before, &found));
        EXPECT_EQ(found, made);
        fails(outside, at(object, after, &found));
        EXPECT_EQ(found, nullptr);
        RTvariable other = nullptr;
        RTmaterial stranger = nullptr;
        ok(rtMaterialCreate(context_, &stranger));
        ok(rtMaterialDeclareVariable(stranger, "x", &other));
        fails(RT_ERROR_VARIABLE_NOT_FOUND, remove(object, other), "\"x\"");
        ok(remove(object, made));
        fails(RT_ERROR_INVALID_VALUE, remove(object, made));
        ok(count(object, &after));
        EXPECT_EQ(after, before);
        ok(declare(object, "last", &last_));
    }
    // The last variable that scope() has left; its object is destroyed.
    void expectLastVariableIsGone() {
        const char* name = nullptr;
        fails(RT_ERROR_INVALID_VALUE, rtVariableGetName(last_, &name), "not a live object");
        fails(RT_ERROR_INVALID_VALUE, rtVariableSet1f(last_, 1));
        last_ = nullptr;
    }
    RTvariable last_ = nullptr;
};

TEST_F(Properties, OfGeometry) {
    RTgeometry object = squares(1);
    roundTrip<RTgeometry, unsigned, unsigned>(object, rtGeometrySetPrimitiveCount,
                                              rtGeometryGetPrimitiveCount, {0, 5, ~0u});
    roundTrip<RTgeometry, unsigned, unsigned>(object, rtGeometrySetPrimitiveIndexOffset,
                                              rtGeometryGetPrimitiveIndexOffset, {7, ~0u});
    roundTrip(object, rtGeometrySetFlags, rtGeometryGetFlags,
              {RT_GEOMETRY_FLAG_NO_SPLITTING, RT_GEOMETRY_FLAG_DISABLE_ANYHIT},
              {RTgeometryflags(4)});
    motion(object, rtGeometrySetMotionSteps, rtGeometryGetMotionSteps, rtGeometrySetMotionRange,
           rtGeometryGetMotionRange, rtGeometrySetMotionBorderMode, rtGeometryGetMotionBorderMode);
    fails(RT_ERROR_INVALID_VALUE, rtGeometryValidate(object), "takes none");
    ok(rtGeometrySetMotionSteps(object, 1));
    ok(rtGeometryValidate(object));
    RTprogram bounds = nullptr, intersection = nullptr;
    ok(rtGeometryGetBoundingBoxProgram(object, &bounds));
    ok(rtGeometryGetIntersectionProgram(object, &intersection));
    fails(RT_ERROR_TYPE_MISMATCH, rtGeometrySetBoundingBoxProgram(object, intersection));
    fails(RT_ERROR_TYPE_MISMATCH, rtGeometrySetIntersectionProgram(object, bounds));
    RTprogram kept = nullptr;
    ok(rtGeometryGetBoundingBoxProgram(object, &kept));
    EXPECT_EQ(kept, bounds);
    int dirty = 1;
    ok(rtGeometryMarkDirty(object));
    ok(rtGeometryIsDirty(object, &dirty));
    EXPECT_EQ(dirty, 0);
    ok(rtProgramDestroy(bounds));
    fails(RT_ERROR_INVALID_VALUE, rtGeometryValidate(object), "bounding box");
    scope(object, rtGeometryDeclareVariable, rtGeometryQueryVariable, rtGeometryRemoveVariable,
          rtGeometryGetVariableCount, rtGeometryGetVariable, RT_ERROR_VARIABLE_NOT_FOUND);
    life(object, rtGeometryGetContext, rtGeometryDestroy);
}

TEST_F(Properties, OfGeometryTriangles) {
    RTgeometrytriangles object = triangle(1);
    ok(rtGeometryTrianglesValidate(object));
    roundTrip<RTgeometrytriangles, unsigned, unsigned>(
        object, rtGeometryTrianglesSetPrimitiveCount, rtGeometryTrianglesGetPrimitiveCount, {3, 0});
    roundTrip<RTgeometrytriangles, unsigned, unsigned>(
        object, rtGeometryTrianglesSetPrimitiveIndexOffset,
        rtGeometryTrianglesGetPrimitiveIndexOffset, {7, ~0u});
    fails(RT_ERROR_INVALID_VALUE, rtGeometryTrianglesValidate(object), "0 triangles");
    motion(object, rtGeometryTrianglesSetMotionSteps, rtGeometryTrianglesGetMotionSteps,
           rtGeometryTrianglesSetMotionRange, rtGeometryTrianglesGetMotionRange,
           rtGeometryTrianglesSetMotionBorderMode, rtGeometryTrianglesGetMotionBorderMode);
    roundTrip<RTgeometrytriangles, unsigned, unsigned>(object, rtGeometryTrianglesSetMaterialCount,
                                                       rtGeometryTrianglesGetMaterialCount, {3, 2},
                                                       {0, ~0u});
    RTgeometryflags flags{};
    ok(rtGeometryTrianglesSetFlagsPerMaterial(object, 1, RT_GEOMETRY_FLAG_DISABLE_ANYHIT));
    fails(RT_ERROR_INVALID_VALUE,
          rtGeometryTrianglesSetFlagsPerMaterial(object, 1, RTgeometryflags(4)));
    fails(RT_ERROR_INVALID_VALUE,
          rtGeometryTrianglesSetFlagsPerMaterial(object, 2, RT_GEOMETRY_FLAG_NONE), "2 of 2");
    fails(RT_ERROR_INVALID_VALUE, rtGeometryTrianglesGetFlagsPerMaterial(object, 2, &flags));
    ok(rtGeometryTrianglesGetFlagsPerMaterial(object, 1, &flags));
    EXPECT_EQ(flags, RT_GEOMETRY_FLAG_DISABLE_ANYHIT);
    ok(rtGeometryTrianglesSetBuildFlags(object, RT_GEOMETRY_BUILD_FLAG_RELEASE_BUFFERS));
    fails(RT_ERROR_INVALID_VALUE,
          rtGeometryTrianglesSetBuildFlags(object, RTgeometrybuildflags(1)));
    std::array<float, 12> matrix{}, given{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    ok(rtGeometryTrianglesSetPreTransformMatrix(object, 0, given.data()));
    ok(rtGeometryTrianglesGetPreTransformMatrix(object, 1, matrix.data()));
    EXPECT_EQ(matrix[1], 5);
    ok(rtGeometryTrianglesGetPreTransformMatrix(object, 0, matrix.data()));
    EXPECT_EQ(matrix, given);
    RTprogram attributes = program("attribute_tag"), kept = nullptr;
    ok(rtGeometryTrianglesSetAttributeProgram(object, attributes));
    fails(RT_ERROR_TYPE_MISMATCH,
          rtGeometryTrianglesSetAttributeProgram(object, program("square_bounds")));
    ok(rtGeometryTrianglesGetAttributeProgram(object, &kept));
    EXPECT_EQ(kept, attributes);
    scope(object, rtGeometryTrianglesDeclareVariable, rtGeometryTrianglesQueryVariable,
          rtGeometryTrianglesRemoveVariable, rtGeometryTrianglesGetVariableCount,
          rtGeometryTrianglesGetVariable, RT_ERROR_INVALID_VALUE);
    life(object, rtGeometryTrianglesGetContext, rtGeometryTrianglesDestroy);
}

TEST_F(Properties, OfBuffersOfTriangles) {
    RTgeometrytriangles object = triangle(1);
    RTbuffer list = filled<float>(RT_FORMAT_FLOAT, std::vector<float>(90));
    const RTformat good = RT_FORMAT_FLOAT3, wrong = RT_FORMAT_INT3;
    fails(RT_ERROR_INVALID_VALUE, rtGeometryTrianglesSetVertices(object, 3, list, 0, 12, wrong),
          "vertexFormat = RT_FORMAT_INT3 is not one of RT_FORMAT_FLOAT3, RT_FORMAT_FLOAT2");
    fails(RT_ERROR_INVALID_VALUE, rtGeometryTrianglesSetVertices(object, 3, list, 0, 4, good));
    fails(RT_ERROR_INVALID_VALUE,
          rtGeometryTrianglesSetMotionVertices(object, 3, list, 0, 12, 36, wrong));
    RTbuffer several[2] = {list, list};
    ok(rtGeometryTrianglesSetMotionVerticesMultiBuffer(object, 3, several, 2, 0, 12, good));
    fails(RT_ERROR_INVALID_VALUE, rtGeometryTrianglesValidate(object), "2 vertex buffers");
    ok(rtGeometryTrianglesSetMotionSteps(object, 2));
    ok(rtGeometryTrianglesValidate(object));
    fails(RT_ERROR_INVALID_VALUE,
          rtGeometryTrianglesSetMotionVerticesMultiBuffer(object, 3, several, 0, 0, 12, good));
    several[1] = nullptr;
    fails(RT_ERROR_INVALID_VALUE,
          rtGeometryTrianglesSetMotionVerticesMultiBuffer(object, 3, several, 2, 0, 12, good));
    fails(RT_ERROR_INVALID_VALUE, rtGeometryTrianglesSetTriangleIndices(object, list, 0, 12, good),
          "triIndicesFormat");
    fails(RT_ERROR_INVALID_VALUE,
          rtGeometryTrianglesSetMaterialIndices(object, list, 0, 4, RT_FORMAT_FLOAT));
    ok(rtGeometryTrianglesSetMaterialIndices(object, list, 0, 4, RT_FORMAT_UNSIGNED_INT));
    // Fewer buffers than steps, after the launch that knew more.
    RTgeometrygroup top = group({instance(object, {material("hit_mark")})});
    shoot(top);
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(top, &built));
    RTbuffer three[3] = {list, list, list};
    ok(rtGeometryTrianglesSetMotionVerticesMultiBuffer(object, 3, three, 3, 0, 12, good));
    ok(rtAccelerationMarkDirty(built));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "3 vertex buffers");
    // The begin of the third step would wrap around to that of the first.
    ok(rtGeometryTrianglesSetMotionSteps(object, 3));
    ok(rtGeometryTrianglesSetMotionVertices(object, 3, list, 36, 12, RTsize(1) << 63, good));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "vertices");
    ok(rtGeometryTrianglesSetMotionVertices(object, 3, list, 36, 12, ~RTsize(11), good));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "motion step 1");
}

TEST_F(Properties, OfInstancesAndMaterials) {
    RTmaterial paint = material("hit_mark", "count_any");
    RTgeometryinstance object = instance(squares(1), {paint});
    RTgeometry shape = nullptr;
    RTgeometrytriangles mesh = nullptr;
    ok(rtGeometryInstanceGetGeometry(object, &shape));
    fails(RT_ERROR_INVALID_VALUE, rtGeometryInstanceGetGeometryTriangles(object, &mesh));
    EXPECT_EQ(mesh, nullptr);
    ok(rtGeometryInstanceSetGeometryTriangles(object, triangle(1)));
    fails(RT_ERROR_INVALID_VALUE, rtGeometryInstanceGetGeometry(object, &shape));
    EXPECT_EQ(shape, nullptr);
    ok(rtGeometryInstanceValidate(object));
    roundTrip<RTgeometryinstance, unsigned, unsigned>(object, rtGeometryInstanceSetMaterialCount,
                                                      rtGeometryInstanceGetMaterialCount, {0, 2},
                                                      {~0u});
    RTmaterial kept = paint;
    ok(rtGeometryInstanceGetMaterial(object, 1, &kept));
    EXPECT_EQ(kept, nullptr);
    fails(RT_ERROR_INVALID_VALUE, rtGeometryInstanceValidate(object), "material");
    fails(RT_ERROR_INVALID_VALUE, rtGeometryInstanceSetMaterial(object, 2, paint), "2 of 2");
    fails(RT_ERROR_INVALID_VALUE, rtGeometryInstanceGetMaterial(object, 2, &kept));
    scope(object, rtGeometryInstanceDeclareVariable, rtGeometryInstanceQueryVariable,
          rtGeometryInstanceRemoveVariable, rtGeometryInstanceGetVariableCount,
          rtGeometryInstanceGetVariable, RT_ERROR_VARIABLE_NOT_FOUND);
    life(object, rtGeometryInstanceGetContext, rtGeometryInstanceDestroy);
    RTprogram closest = nullptr, any = nullptr;
    ok(rtMaterialGetClosestHitProgram(paint, 0, &closest));
    ok(rtMaterialGetAnyHitProgram(paint, 0, &any));
    EXPECT_NE(closest, any);
    ok(rtMaterialGetAnyHitProgram(paint, 1, &any));
    EXPECT_EQ(any, nullptr);
    fails(RT_ERROR_INVALID_VALUE, rtMaterialGetAnyHitProgram(paint, 2, &any), "2 of 2");
    fails(RT_ERROR_INVALID_VALUE, rtMaterialSetClosestHitProgram(paint, 2, closest));
    fails(RT_ERROR_TYPE_MISMATCH, rtMaterialSetAnyHitProgram(paint, 0, program("square_hit")));
    fails(RT_ERROR_TYPE_MISMATCH, rtMaterialSetClosestHitProgram(paint, 0, program("multiply")));
    ok(rtMaterialValidate(paint));
    scope(paint, rtMaterialDeclareVariable, rtMaterialQueryVariable, rtMaterialRemoveVariable,
          rtMaterialGetVariableCount, rtMaterialGetVariable, RT_ERROR_VARIABLE_NOT_FOUND);
    life(paint, rtMaterialGetContext, rtMaterialDestroy);
}

TEST_F(Properties, OfNodes) {
    RTgeometrygroup leaf = group({instance(squares(1), {material("hit_mark")})});
    RTgroup top = groupOf({leaf});
    roundTrip<RTgroup, RTvisibilitymask, RTvisibilitymask>(
        top, rtGroupSetVisibilityMask, rtGroupGetVisibilityMask, {0, 255}, {256});
    roundTrip<RTgeometrygroup, RTvisibilitymask, RTvisibilitymask>(
        leaf, rtGeometryGroupSetVisibilityMask, rtGeometryGroupGetVisibilityMask, {0, 255}, {256});
    roundTrip(leaf, rtGeometryGroupSetFlags, rtGeometryGroupGetFlags,
              {RT_INSTANCE_FLAG_DISABLE_ANYHIT, RT_INSTANCE_FLAG_NONE},
              {RTinstanceflags(16),
               RTinstanceflags(RT_INSTANCE_FLAG_DISABLE_ANYHIT | RT_INSTANCE_FLAG_ENFORCE_ANYHIT)});
    unsigned count = 0;
    ok(rtGroupGetChildCount(top, &count));
    EXPECT_EQ(count, 1u);
    ok(rtGeometryGroupGetChildCount(leaf, &count));
    EXPECT_EQ(count, 1u);
    RTobject child = nullptr;
    RTobjecttype type{};
    ok(rtGroupGetChild(top, 0, &child));
    EXPECT_EQ(child, leaf);
    ok(rtGroupGetChildType(top, 0, &type));
    EXPECT_EQ(type, RT_OBJECTTYPE_GEOMETRY_GROUP);
    fails(RT_ERROR_INVALID_VALUE, rtGroupGetChild(top, 1, &child), "1 of 1");
    fails(RT_ERROR_INVALID_VALUE, rtGroupGetChildType(top, 1, &type));
    fails(RT_ERROR_INVALID_VALUE, rtGroupSetChild(top, 0, squares(1)), "geometry");
    RTgeometryinstance inside = nullptr;
    ok(rtGeometryGroupGetChild(leaf, 0, &inside));
    fails(RT_ERROR_INVALID_VALUE, rtGeometryGroupGetChild(leaf, 1, &inside));
    fails(RT_ERROR_INVALID_VALUE, rtGroupSetChildCount(top, ~0u));
    ok(rtGroupValidate(top));
    ok(rtGroupSetChildCount(top, 2));
    fails(RT_ERROR_INVALID_VALUE, rtGroupValidate(top), "child 1");
    ok(rtGroupGetChild(top, 1, &child));
    EXPECT_EQ(child, nullptr);
    RTtransform between = moved(leaf, 1);
    ok(rtTransformValidate(between));
    ok(rtTransformGetChild(between, &child));
    EXPECT_EQ(child, leaf);
    ok(rtTransformGetChildType(between, &type));
    EXPECT_EQ(type, RT_OBJECTTYPE_GEOMETRY_GROUP);
    motion<RTtransform>(between, nullptr, nullptr, rtTransformSetMotionRange,
                        rtTransformGetMotionRange, rtTransformSetMotionBorderMode,
                        rtTransformGetMotionBorderMode);
    const float flat[16] = {};
    fails(RT_ERROR_INVALID_VALUE, rtTransformSetMatrix(between, 0, flat, nullptr), "inverse");
    fails(RT_ERROR_INVALID_VALUE,
          rtTransformSetMotionKeys(between, 0, RT_MOTIONKEYTYPE_SRT_FLOAT16, flat));
    fails(RT_ERROR_INVALID_VALUE,
          rtTransformSetMotionKeys(between, 1, RT_MOTIONKEYTYPE_NONE, flat));
    life(between, rtTransformGetContext, rtTransformDestroy);
    life(top, rtGroupGetContext, rtGroupDestroy);
    life(leaf, rtGeometryGroupGetContext, rtGeometryGroupDestroy);
}

TEST_F(Properties, OfSelectors) {
    RTselector object = nullptr;
    ok(rtSelectorCreate(context_, &object));
    RTprogram visit = program("visit_chosen"), kept = nullptr;
    ok(rtSelectorSetVisitProgram(object, visit));
    ok(rtSelectorGetVisitProgram(object, &kept));
    EXPECT_EQ(kept, visit);
    roundTrip<RTselector, unsigned, unsigned>(object, rtSelectorSetChildCount,
                                              rtSelectorGetChildCount, {2, 1}, {~0u});
    RTobject child = this;
    RTobjecttype type{};
    ok(rtSelectorGetChild(object, 0, &child));
    EXPECT_EQ(child, nullptr);
    fails(RT_ERROR_INVALID_VALUE, rtSelectorValidate(object), "child 0");
    RTgeometrygroup leaf = group({instance(squares(1), {material("hit_mark")})});
    ok(rtSelectorSetChild(object, 0, leaf));
    ok(rtSelectorGetChildType(object, 0, &type));
    EXPECT_EQ(type, RT_OBJECTTYPE_GEOMETRY_GROUP);
    ok(rtSelectorValidate(object));
    fails(RT_ERROR_INVALID_VALUE, rtSelectorSetChild(object, 1, leaf), "1 of 1");
    fails(RT_ERROR_INVALID_VALUE, rtSelectorGetChildType(object, 1, &type));
    scope(object, rtSelectorDeclareVariable, rtSelectorQueryVariable, rtSelectorRemoveVariable,
          rtSelectorGetVariableCount, rtSelectorGetVariable, RT_ERROR_INVALID_VALUE);
    life(object, rtSelectorGetContext, rtSelectorDestroy);
}

TEST_F(Properties, OfAccelerations) {
    RTacceleration object = nullptr;
    ok(rtAccelerationCreate(context_, &object));
    fails(RT_ERROR_INVALID_VALUE, rtAccelerationValidate(object), "no builder");
    const char* text = nullptr;
    for (const auto& [given, kept] :
         {std::pair("NoAccel", "NoAccel"), std::pair("Bvh", "Bvh"), std::pair("Sbvh", "Sbvh"),
          std::pair("Lbvh", "Trbvh"), std::pair("MedianBvh", "Trbvh"),
          std::pair("TriangleKdTree", "Trbvh"), std::pair("Trbvh", "Trbvh")}) {
        ok(rtAccelerationSetBuilder(object, given));
        ok(rtAccelerationGetBuilder(object, &text));
        EXPECT_STREQ(text, kept);
    }
    fails(RT_ERROR_INVALID_VALUE, rtAccelerationSetBuilder(object, "Best"), "Best");
    ok(rtAccelerationValidate(object));
    ok(rtAccelerationGetProperty(object, "refit", &text));
    EXPECT_STREQ(text, "0");
    ok(rtAccelerationSetProperty(object, "refit", "1"));
    ok(rtAccelerationSetProperty(object, "anything", "some text"));
    ok(rtAccelerationGetProperty(object, "refit", &text));
    EXPECT_STREQ(text, "1");
    ok(rtAccelerationGetProperty(object, "anything", &text));
    EXPECT_STREQ(text, "some text");
    ok(rtAccelerationGetProperty(object, "unknown", &text));
    EXPECT_STREQ(text, "");
    RTsize size = 0;
    fails(RT_ERROR_NOT_SUPPORTED, rtAccelerationGetDataSize(object, &size));
    fails(RT_ERROR_NOT_SUPPORTED, rtAccelerationGetData(object, &size));
    fails(RT_ERROR_NOT_SUPPORTED, rtAccelerationSetData(object, &size, 8));
    ok(rtAccelerationSetTraverser(object, "Bvh"));
    text = nullptr;
    ok(rtAccelerationGetTraverser(object, &text));
    EXPECT_STREQ(text, "");
    life(object, rtAccelerationGetContext, rtAccelerationDestroy);
}

TEST_F(Properties, OfPrograms) {
    RTprogram object = program("write_scoped");
    ok(rtProgramValidate(object));
    int id = 0;
    ok(rtProgramGetId(program("multiply"), &id));
    RTprogram found = nullptr;
    ok(rtContextGetProgramFromId(context_, id, &found));
    EXPECT_NE(found, nullptr);
    fails(RT_ERROR_INVALID_VALUE, rtContextGetProgramFromId(context_, id + 5, &found));
    EXPECT_EQ(found, nullptr);
    fails(RT_ERROR_INVALID_VALUE, rtContextGetBufferFromId(context_, 0, nullptr));
    ok(rtProgramCallsiteSetPotentialCallees(object, "site", &id, 1));
    id += 5;
    fails(RT_ERROR_INVALID_VALUE, rtProgramCallsiteSetPotentialCallees(object, "site", &id, 1));
    fails(RT_ERROR_INVALID_VALUE, rtProgramCallsiteSetPotentialCallees(object, "site", &id, -1));
    fails(RT_ERROR_FILE_NOT_FOUND,
          rtProgramCreateFromPTXFile(context_, "/nothing/there.ptx", "p", &found), "there.ptx");
    const char* names[] = {"/nothing/there.ptx"};
    fails(RT_ERROR_FILE_NOT_FOUND, rtProgramCreateFromPTXFiles(context_, 1, names, "p", &found));
    fails(RT_ERROR_FILE_NOT_FOUND, rtProgramCreateFromPTXFile(context_, "/tmp", "p", &found),
          "/tmp");
    fails(RT_ERROR_INVALID_VALUE, rtProgramCreateFromPTXFiles(context_, 0, names, "p", &found),
          "n = 0: filenames is an empty list");
    fails(RT_ERROR_INVALID_VALUE, rtProgramCreateFromPTXFile(context_, nullptr, "p", &found),
          "filename is null");
    fails(RT_ERROR_INVALID_VALUE, rtProgramCreateFromPTXString(context_, nullptr, "p", &found),
          "ptx is null");
    fails(RT_ERROR_INVALID_VALUE, rtProgramCreateFromPTXStrings(context_, 1, nullptr, "p", &found),
          "ptxStrings is null");
    const char* texts[] = {ptx().c_str(), nullptr};
    fails(RT_ERROR_INVALID_VALUE, rtProgramCreateFromPTXStrings(context_, 2, texts, "p", &found),
          "ptxStrings[1] is null");
    fails(RT_ERROR_INVALID_SOURCE,
          rtProgramCreateFromPTXString(context_, ptx().c_str(), "nothing", &found),
          "no function \"nothing\" in the PTX, which has \"");
    fails(RT_ERROR_INVALID_SOURCE,
          rtProgramCreateFromPTXString(context_, ptx().c_str(), "Write_Scoped", &found),
          "which has \"write_scoped\"");
    fails(RT_ERROR_INVALID_SOURCE, rtProgramCreateFromPTXString(context_, "hello", "p", &found));
    scope(object, rtProgramDeclareVariable, rtProgramQueryVariable, rtProgramRemoveVariable,
          rtProgramGetVariableCount, rtProgramGetVariable, RT_ERROR_VARIABLE_NOT_FOUND);
    life(object, rtProgramGetContext, rtProgramDestroy);
}

} // namespace
} // namespace sunstone::api6
