// SPDX-License-Identifier: Apache-2.0
// Behaviour that existing programs rely on and the manual does not state.
#include "../main/forked_child.h"
#include "rays.h"

#include <malloc.h>

#include <algorithm>
#include <sstream>

namespace sunstone::api6 {
namespace {

class Traps : public Rays {
protected:
    void SetUp() override {
        Rays::SetUp();
        enter("note_all");
        RTvariable callee = variable("callee");
        ok(rtVariableSetObject(callee, trap("throw_in_callable")));
        ok(rtVariableSet1i(variable("throws"), 0));
    }
    RTprogram trap(const char* name) {
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXString(context_, ptx("traps.ptx").c_str(), name, &made));
        return made;
    }
    void enter(const char* name) {
        raygen_ = trap(name);
        ok(rtContextSetRayGenerationProgram(context_, 0, raygen_));
    }
    RTmaterial paint(const char* closest, const char* any) {
        RTmaterial made = nullptr;
        ok(rtMaterialCreate(context_, &made));
        if (closest)
            ok(rtMaterialSetClosestHitProgram(made, 0, trap(closest)));
        if (any)
            ok(rtMaterialSetAnyHitProgram(made, 0, trap(any)));
        return made;
    }
    RTgeometry shape(unsigned count = 2, const char* bounds = "two_bounds") {
        RTgeometry made = nullptr;
        ok(rtGeometryCreate(context_, &made));
        ok(rtGeometrySetPrimitiveCount(made, count));
        ok(rtGeometrySetBoundingBoxProgram(made, trap(bounds)));
        ok(rtGeometrySetIntersectionProgram(made, trap("two_squares")));
        return made;
    }
    RTgeometrytriangles mesh() {
        RTgeometrytriangles made = triangle(5);
        ok(rtGeometryTrianglesSetAttributeProgram(made, trap("note_attributes")));
        return made;
    }
    RTprogram raygen_ = nullptr;
};

TEST_F(Traps, LaunchesOfSizeZeroCompileAndBuild) {
    RTgeometrygroup top = group({instance(squares(2), {material("hit_mark")})});
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(top, &built));
    setEntry("shoot");
    ok(rtVariableSetObject(variable("top_object"), top));
    int dirty = 0;
    ok(rtAccelerationIsDirty(built, &dirty));
    EXPECT_EQ(dirty, 1);
    ok(rtContextLaunch2D(context_, 0, 0, 0));
    ok(rtAccelerationIsDirty(built, &dirty));
    EXPECT_EQ(dirty, 0);
    RTvariable mark = variable("mark");
    ok(rtContextRemoveVariable(context_, mark));
    fails(RT_ERROR_VARIABLE_NOT_FOUND, rtContextLaunch2D(context_, 0, 0, 0), "mark");
}

TEST_F(Traps, ThousandsOfProgramsOfOneText) {
    std::vector<RTgeometryinstance> children;
    for (int i = 0; i < 300; ++i) {
        RTmaterial each = material("hit_mark", "count_any");
        setFloat(each, rtMaterialDeclareVariable, "mark", float(i + 1));
        RTgeometry square = squares(1);
        setFloat(square, rtGeometryDeclareVariable, "height", float(i) * 0.01f);
        children.push_back(instance(square, {each}));
    }
    setEntry("shoot");
    EXPECT_EQ(shoot(group(children))[0], 300);
}

// An application that edits programs creates a new text for each change.
TEST_F(Traps, TextsOfDestroyedProgramsAreFreed) {
    if (tests::kFindsLeaks)
        GTEST_SKIP() << "the address sanitizer keeps freed memory for a while";
    const auto edit = [&](int first, int last) { // the most memory meanwhile
        size_t most = 0;
        for (int i = first; i < last; ++i) {
            const std::string text = ptx("traps.ptx") + "// edit " + std::to_string(i) + "\n";
            RTprogram made = nullptr;
            ok(rtProgramCreateFromPTXString(context_, text.c_str(), "note_all", &made));
            ok(rtProgramDestroy(made));
            most = std::max(most, mallinfo2().uordblks + mallinfo2().hblkhd);
        }
        return most;
    };
    const size_t before = edit(0, 100);
    EXPECT_LT(edit(100, 400), before + before / 2);
}

TEST_F(Traps, RaysFiftyLevelsDeep) {
    ok(rtContextSetStackSize(context_, 3000));
    RTmaterial deep = paint("deeper", nullptr);
    // On GPUs the stack has room for 16 levels, and deeper rays end without a program.
    EXPECT_EQ(shoot(group({instance(shape(), {deep, deep})}))[1], runsOnGpu() ? 16 : 50);
}

// Each program searches its own list of scopes, in order. The test fills later scopes of the list
// first.
TEST_F(Traps, ScopesOfHitProgramsAndShapes) {
    RTgeometry geometry = shape(1);
    RTmaterial each = paint("note_closest", "note_any");
    RTgeometryinstance child = instance(geometry, {each});
    RTgeometrygroup top = group({child});
    const auto expectNumbers = [&](float closest, float any, float ofShape) {
        const std::vector<float> r = shoot(top);
        EXPECT_EQ(r[1], closest);
        EXPECT_EQ(r[2], any);
        EXPECT_EQ(r[5], ofShape);
    };
    expectNumbers(0.5f, 0.5f, 0.5f); // initialisers
    ok(rtVariableSet1f(variable("number"), 1));
    expectNumbers(1, 1, 1);
    setFloat(each, rtMaterialDeclareVariable, "number", 2);
    expectNumbers(2, 2, 1);
    setFloat(geometry, rtGeometryDeclareVariable, "number", 3);
    expectNumbers(2, 2, 3);
    setFloat(child, rtGeometryInstanceDeclareVariable, "number", 4);
    expectNumbers(4, 4, 4);
    RTprogram closest = nullptr, any = nullptr, intersection = nullptr;
    ok(rtMaterialGetClosestHitProgram(each, 0, &closest));
    ok(rtMaterialGetAnyHitProgram(each, 0, &any));
    ok(rtGeometryGetIntersectionProgram(geometry, &intersection));
    setFloat(closest, rtProgramDeclareVariable, "number", 5);
    setFloat(any, rtProgramDeclareVariable, "number", 6);
    setFloat(intersection, rtProgramDeclareVariable, "number", 7);
    expectNumbers(5, 6, 7);
}

// OptiXpp declares a variable when an application only queries its value.
TEST_F(Traps, VariablesWithoutAValueHideNone) {
    RTmaterial each = paint("note_closest", "note_any");
    RTgeometryinstance child = instance(shape(1), {each});
    RTgeometrygroup top = group({child});
    ok(rtVariableSet1f(variable("number"), 1));
    RTvariable inner = nullptr;
    ok(rtGeometryInstanceDeclareVariable(child, "number", &inner));
    EXPECT_EQ(shoot(top)[1], 1);
    ok(rtVariableSet1f(inner, 2));
    EXPECT_EQ(shoot(top)[1], 2);
}

TEST_F(Traps, ScopesOfBoundsPrograms) {
    // The box must be at 0 for the ray to reach the square.
    RTgeometry geometry = shape(1, "numbered_bounds");
    RTgeometryinstance child = instance(geometry, {paint("note_closest", nullptr)});
    RTgeometrygroup top = group({child});
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(top, &built));
    ok(rtContextSetMissProgram(context_, 0, trap("note_miss")));
    const auto isReached = [&] {
        ok(rtAccelerationMarkDirty(built));
        return shoot(top)[1] >= 0;
    };
    EXPECT_FALSE(isReached()) << "the initialiser is 0.5";
    ok(rtVariableSet1f(variable("number"), 0));
    EXPECT_TRUE(isReached());
    setFloat(geometry, rtGeometryDeclareVariable, "number", 7);
    EXPECT_FALSE(isReached());
    setFloat(child, rtGeometryInstanceDeclareVariable, "number", 0);
    EXPECT_TRUE(isReached());
    RTprogram bounds = nullptr;
    ok(rtGeometryGetBoundingBoxProgram(geometry, &bounds));
    setFloat(bounds, rtProgramDeclareVariable, "number", 7);
    EXPECT_FALSE(isReached());
}

TEST_F(Traps, ScopesOfAttributePrograms) {
    RTgeometrytriangles geometry = mesh();
    RTgeometryinstance child = instance(geometry, {paint("note_closest", nullptr)});
    RTgeometrygroup top = group({child});
    ok(rtVariableSet1f(variable("number"), 1));
    EXPECT_EQ(shoot(top)[5], 1 + 25);
    setFloat(child, rtGeometryInstanceDeclareVariable, "number", 2);
    EXPECT_EQ(shoot(top)[5], 2 + 25);
    setFloat(geometry, rtGeometryTrianglesDeclareVariable, "number", 3);
    EXPECT_EQ(shoot(top)[5], 3 + 25);
    EXPECT_EQ(shoot(top)[1], 2) << "the hit program sees the instance";
    RTprogram attributes = nullptr;
    ok(rtGeometryTrianglesGetAttributeProgram(geometry, &attributes));
    setFloat(attributes, rtProgramDeclareVariable, "number", 4);
    EXPECT_EQ(shoot(top)[5], 4 + 25);
}

TEST_F(Traps, ScopesOfRayGenerationMissAndException) {
    RTgeometrygroup nothing = group({});
    RTprogram miss = trap("note_miss"), handler = trap("note_thrown");
    ok(rtContextSetMissProgram(context_, 0, miss));
    ok(rtContextSetExceptionProgram(context_, 0, handler));
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_USER, 1));
    ok(rtVariableSet1f(variable("number"), 1));
    EXPECT_EQ(shoot(nothing)[0], 1);
    EXPECT_EQ(shoot(nothing)[3], 1);
    setFloat(raygen_, rtProgramDeclareVariable, "number", 2);
    setFloat(miss, rtProgramDeclareVariable, "number", 3);
    setFloat(handler, rtProgramDeclareVariable, "number", 4);
    const std::vector<float> r = shoot(nothing);
    EXPECT_EQ(r[0], 2);
    EXPECT_EQ(r[3], 3);
    ok(rtVariableSet1i(variable("throws"), 1));
    EXPECT_EQ(shoot(nothing)[61], 4);
}

TEST_F(Traps, ALaunchWithoutAMissProgram) {
    RTcontext other = nullptr;
    std::swap(context_, other); // a context without one
    Classic::SetUp();
    ok(rtVariableSet1i(variable("throws"), 0));
    enter("note_all");
    RTgeometrygroup nothing = group({});
    EXPECT_EQ(shoot(nothing)[3], -1);
    rtContextDestroy(context_);
    context_ = other;
}

TEST_F(Traps, AnyHitProgramsSeeTheirMaterial) {
    RTmaterial first = paint("note_closest", "note_any"), second = paint(nullptr, "note_any");
    setFloat(first, rtMaterialDeclareVariable, "number", 11);
    setFloat(second, rtMaterialDeclareVariable, "number", 22);
    // Each primitive reports the material of its number.
    EXPECT_EQ(shoot(group({instance(shape(1), {first, second})}))[2], 11);
    RTgeometry far = shape(1);
    ok(rtGeometrySetPrimitiveIndexOffset(far, 1));
    EXPECT_EQ(shoot(group({instance(far, {first, second})}))[2], 22);
}

TEST_F(Traps, AttributesOfAnIgnoredHitAreGone) {
    RTmaterial kept = paint("note_closest", nullptr),
               ignored = paint(nullptr, "note_any_and_ignore");
    const std::vector<float> r = shoot(group({instance(shape(2), {kept, ignored})}));
    EXPECT_EQ(r[2], 0.5f) << "the nearer square was looked at";
    EXPECT_EQ(r[5], 0.5f) << "the tag of the farther one";
}

TEST_F(Traps, RaysAreInObjectSpaceUntilTheClosestHit) {
    RTgeometryinstance custom = instance(shape(1), {paint("note_closest", "note_any")});
    std::vector<float> r = shoot(moved(group({custom}), -0.5f));
    EXPECT_EQ(r[6], 0.75f) << "any-hit";
    EXPECT_EQ(r[7], 0.75f) << "intersection";
    EXPECT_EQ(r[8], 0.25f) << "closest-hit";
    RTgeometryinstance triangles = instance(mesh(), {paint("note_transforms", nullptr)});
    r = shoot(moved(group({triangles}), -0.125f));
    EXPECT_EQ(r[8], 0.25f);
    EXPECT_EQ(r[9], 0.5f + 25) << "the attribute program of the accepted hit";
}

TEST_F(Traps, TransformsAreRowsFirstWithTheirInverse) {
    // Turned about z, scaled and moved: the square stays below the ray.
    const float matrix[16] = {0, -2, 0, 1, 2, 0, 0, -0.5f, 0, 0, 1, 0.25f, 0, 0, 0, 1};
    const float inverse[16] = {0, 0.5f, 0, 0.25f, -0.5f, 0, 0, 0.5f, 0, 0, 1, -0.25f, 0, 0, 0, 1};
    RTtransform node = moved(group({instance(shape(1), {paint("note_transforms", nullptr)})}), 0);
    ok(rtTransformSetMatrix(node, 0, matrix, nullptr));
    const std::vector<float> r = shoot(node);
    for (size_t i = 0; i < 16; ++i) {
        EXPECT_EQ(r[16 + i], inverse[i]) << i;
        EXPECT_EQ(r[32 + i], matrix[i]) << i;
    }
}

TEST_F(Traps, ThrowReachesTheHandlerFromEveryProgram) {
    ok(rtContextSetExceptionProgram(context_, 0, trap("note_thrown")));
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_USER, 1));
    ok(rtContextSetMissProgram(context_, 0, trap("note_miss")));
    RTmaterial each = paint("note_closest", "note_any");
    RTselector selector = nullptr;
    ok(rtSelectorCreate(context_, &selector));
    ok(rtSelectorSetVisitProgram(selector, trap("visit_all")));
    ok(rtSelectorSetChildCount(selector, 1));
    ok(rtSelectorSetChild(selector, 0, group({instance(shape(1), {each})})));
    const RTobject custom = selector;
    const RTobject triangles = group({instance(mesh(), {each})});
    const RTobject nothing = group({});
    const std::pair<int, RTobject> kinds[] = {{1, custom}, {2, nothing},   {3, custom},
                                              {4, custom}, {5, custom},    {6, custom},
                                              {7, custom}, {8, triangles}, {9, custom}};
    for (const auto& [kind, top] : kinds) {
        ok(rtVariableSet1i(variable("throws"), kind));
        fill(result_, std::vector<float>(64));
        const std::vector<float> r = shoot(top);
        EXPECT_EQ(r[60], float(kind));
        EXPECT_EQ(r[0], 0) << "the ray generation program went on after kind " << kind;
    }
}

// The name of the payload in programs before release 6.
TEST_F(Traps, TheOldNameOfThePayload) {
    RTmaterial each = nullptr;
    ok(rtMaterialCreate(context_, &each));
    ok(rtMaterialSetClosestHitProgram(each, 0, trap("note_by_old_name")));
    EXPECT_EQ(shoot(group({instance(shape(1), {each})}))[1], 77);
}

TEST_F(Traps, SeveralMaterialsNeedMaterialIndices) {
    RTgeometrytriangles triangles = triangle(1);
    ok(rtGeometryTrianglesSetMaterialCount(triangles, 2));
    RTmaterial each = material("hit_head");
    RTgeometrygroup top = group({instance(triangles, {each, each})});
    ok(rtVariableSetObject(variable("top_object"), top));
    fails(RT_ERROR_INVALID_CONTEXT, rtContextValidate(context_), "material indices");
    fails(RT_ERROR_INVALID_CONTEXT, rtContextLaunch1D(context_, 0, 1), "material indices");
}

TEST_F(Traps, FaultsOfSamplersNameThem) {
    RTtexturesampler made = nullptr;
    RTbuffer empty = nullptr;
    int id = 0;
    ok(rtTextureSamplerCreate(context_, &made));
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT, &empty));
    ok(rtTextureSamplerSetBuffer(made, 0, 0, empty));
    ok(rtTextureSamplerGetId(made, &id));
    ok(rtVariableSetObject(variable("top_object"), group({})));
    std::ostringstream name;
    name << "texture sampler " << static_cast<const void*>(made) << " with id " << id
         << ": the buffer has no format";
    fails(RT_ERROR_INVALID_CONTEXT, rtContextValidate(context_), name.str());
}

// The memory checker runs this test, too.
TEST_F(Traps, VariablesAreIndexed) {
    RTgeometry geometry = shape(1);
    ok(rtGeometrySetIntersectionProgram(geometry, trap("marked_square")));
    enter("take_steps");
    std::vector<float> start(64, 0);
    start[0] = 6;
    fill(result_, start);
    EXPECT_EQ(shoot(group({instance(geometry, {paint("step_closest", nullptr)})}), 50000)[0], 3);
}

// In PTX of nvcc and clang, an empty string literal looks like a buffer.
TEST_F(Traps, TextsAreNoBuffers) {
    for (const char* name : {"_$_str", "$str$1"}) {
        const std::string text =
            ".version 6.0\n.target sm_60\n.address_size 64\n.global .align 1 .b8 " +
            std::string(name) + "[1];\n.visible .entry words()\n{\n.reg .b64 %rd<3>;\n" +
            "mov.u64 %rd1, " + name + ";\nadd.s64 %rd2, %rd1, 1;\nret;\n}\n";
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXString(context_, text.c_str(), "words", &made));
        ok(rtContextSetRayGenerationProgram(context_, 0, made));
        ok(rtContextLaunch1D(context_, 0, 1));
    }
}

// PTX as compilers write it: a structure is loaded by vectors that cross its members, symbols are
// not visible, and initialisers are shorter than what they fill.
TEST_F(Traps, VectorLoadsAcrossMembersAndShortInitialisers) {
    const auto described = [](const std::string& name, unsigned bytes) {
        const std::string mangled = std::to_string(name.size()) + name + "E";
        return ".global .align 4 .b8 _ZN21rti_internal_typeinfo" + mangled +
               "[8] = {82, 97, 121, 0, " + std::to_string(bytes) + "};\n" +
               ".global .align 1 .b8 _ZN21rti_internal_typename" + mangled + "[5] = {85};\n" +
               ".global .align 4 .u32 _ZN21rti_internal_typeenum" + mangled + " = 4919;\n" +
               ".global .align 1 .b8 _ZN21rti_internal_semantic" + mangled + "[1];\n" +
               ".global .align 1 .b8 _ZN23rti_internal_annotation" + mangled + "[1];\n";
    };
    const std::string text =
        ".version 7.8\n.target sm_52\n.address_size 64\n"
        ".global .align 1 .b8 result[1];\n"
        ".global .align 16 .b8 record[32];\n" +
        described("record", 32) + ".global .align 4 .b8 preset[12] = {0, 0, 128, 63};\n" +
        described("preset", 12) +
        ".entry _Z5crossv()\n{\n.reg .f32 %f<10>;\n.reg .b64 %rd<5>;\n.reg .b32 %r<3>;\n"
        "ld.global.v4.f32 {%f1, %f2, %f3, %f4}, [record+16];\n"
        "ld.global.v2.f32 {%f5, %f6}, [record+8];\n"
        "ld.global.f32 %f7, [preset];\nld.global.f32 %f8, [preset+8];\n"
        "add.f32 %f1, %f1, %f4;\nadd.f32 %f1, %f1, %f5;\nadd.f32 %f1, %f1, %f6;\n"
        "add.f32 %f1, %f1, %f7;\nadd.f32 %f1, %f1, %f8;\n"
        "mov.u64 %rd1, result;\nmov.u32 %r1, 1;\nmov.u32 %r2, 4;\nmov.u64 %rd2, 0;\n"
        "call (%rd3), _rt_buffer_get_64, (%rd1, %r1, %r2, %rd2, %rd2, %rd2, %rd2);\n"
        "st.f32 [%rd3], %f1;\nret;\n}\n";
    RTprogram made = nullptr;
    ok(rtProgramCreateFromPTXString(context_, text.c_str(), "cross", &made));
    const float record[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    ok(rtVariableSetUserData(variable("record"), sizeof record, record));
    ok(rtContextSetRayGenerationProgram(context_, 0, made));
    ok(rtContextLaunch1D(context_, 0, 1));
    EXPECT_EQ(results()[0], 4 + 8 + 16 + 128 + 1);
}

} // namespace
} // namespace sunstone::api6
