// SPDX-License-Identifier: Apache-2.0
// Effects of setters on rays and lookups that no other file tests.
#include "rays.h"

#include <array>

namespace sunstone::api6 {
namespace {

class LaunchEffects : public Rays {
protected:
    // The number of any-hit programs that run for a ray through the structure.
    float anyHitsOf(RTgeometrygroup top) { return shoot(top)[1]; }
    RTmaterial counting() { return material("hit_head", "count_any"); }
    void aimAt(float x, float y) { ok(rtVariableSet3f(variable("ray_origin"), x, y, 10)); }
};

TEST_F(LaunchEffects, OfFlagsOfGeometry) {
    RTgeometry shape = squares(1);
    RTgeometrygroup top = group({instance(shape, {material("hit_mark", "count_any")})});
    EXPECT_EQ(anyHitsOf(top), 1);
    ok(rtGeometrySetFlags(shape, RT_GEOMETRY_FLAG_DISABLE_ANYHIT));
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(top, &built));
    ok(rtAccelerationMarkDirty(built));
    EXPECT_EQ(anyHitsOf(top), 0);
}

TEST_F(LaunchEffects, OfFlagsOfMaterialsOfTriangles) {
    RTgeometrytriangles mesh = triangle(1);
    ok(rtGeometryTrianglesSetFlagsPerMaterial(mesh, 0, RT_GEOMETRY_FLAG_DISABLE_ANYHIT));
    EXPECT_EQ(anyHitsOf(group({instance(mesh, {counting()})})), 0);
    EXPECT_EQ(anyHitsOf(group({instance(triangle(1), {counting()})})), 1);
}

TEST_F(LaunchEffects, OfFlagsOfGroups) {
    RTgeometrygroup top = group({instance(triangle(1), {counting()})});
    EXPECT_EQ(anyHitsOf(top), 1);
    ok(rtGeometryGroupSetFlags(top, RT_INSTANCE_FLAG_DISABLE_ANYHIT));
    EXPECT_EQ(anyHitsOf(top), 0);
    ok(rtGeometryGroupSetFlags(top, RT_INSTANCE_FLAG_NONE));
    EXPECT_EQ(anyHitsOf(top), 1);
}

TEST_F(LaunchEffects, OfPrimitiveOffsetsOfTriangles) {
    RTgeometrytriangles mesh = triangle(1);
    ok(rtGeometryTrianglesSetPrimitiveIndexOffset(mesh, 7));
    EXPECT_EQ(shoot(group({instance(mesh, {material("hit_triangle")})}))[0], 7);
}

TEST_F(LaunchEffects, OfPreTransforms) {
    RTgeometrytriangles mesh = triangle(1);
    const std::array<float, 12> byRows = {1, 0, 0, 30, 0, 1, 0, 0, 0, 0, 1, 4};
    ok(rtGeometryTrianglesSetPreTransformMatrix(mesh, 0, byRows.data()));
    RTgeometrygroup top = group({instance(mesh, {material("hit_distance_only")})});
    EXPECT_EQ(shoot(top)[0], -2) << "the triangle is elsewhere";
    aimAt(30.25f, 0.25f);
    EXPECT_EQ(shoot(top)[3], 5) << "at z = 1 + 4";
}

// Two instances of one group have the mesh.
TEST_F(LaunchEffects, OfPreTransformsThatInstancesShare) {
    RTgeometrytriangles mesh = triangle(1);
    const std::array<float, 12> byRows = {1, 0, 0, 30, 0, 1, 0, 0, 0, 0, 1, 4};
    ok(rtGeometryTrianglesSetPreTransformMatrix(mesh, 0, byRows.data()));
    const RTmaterial counts = material(nullptr, "count_any");
    RTgeometrygroup top = group({instance(mesh, {counts}), instance(mesh, {counts})});
    aimAt(30.25f, 0.25f);
    EXPECT_EQ(anyHitsOf(top), 2);
}

TEST_F(LaunchEffects, OfVerticesInSeveralBuffers) {
    RTgeometrytriangles mesh = triangle(1);
    RTbuffer keys[2] = {filled<float>(RT_FORMAT_FLOAT, {0, 0, 5, 1, 0, 5, 0, 1, 5}),
                        filled<float>(RT_FORMAT_FLOAT, {8, 0, 5, 9, 0, 5, 8, 1, 5})};
    ok(rtGeometryTrianglesSetMotionSteps(mesh, 2));
    ok(rtGeometryTrianglesSetMotionVerticesMultiBuffer(mesh, 3, keys, 2, 0, 12, RT_FORMAT_FLOAT3));
    RTgeometrygroup top = group({instance(mesh, {material("hit_head")})});
    setEntry("shoot_at");
    for (const float time : {0.0f, 0.5f, 1.0f}) {
        ok(rtVariableSet1f(variable("ray_time"), time));
        aimAt(8 * time + 0.25f, 0.25f);
        EXPECT_EQ(shoot(top)[0], 1) << time;
        aimAt(8 * time + 2, 0.25f);
        EXPECT_EQ(shoot(top)[0], -2) << time;
    }
}

TEST_F(LaunchEffects, OfMotionBordersOfGeometry) {
    RTgeometry moving = nullptr;
    ok(rtGeometryCreate(context_, &moving));
    ok(rtGeometrySetPrimitiveCount(moving, 1));
    ok(rtGeometrySetBoundingBoxProgram(moving, program("moving_bounds")));
    ok(rtGeometrySetIntersectionProgram(moving, program("moving_hit")));
    ok(rtGeometrySetMotionSteps(moving, 2));
    ok(rtGeometrySetMotionRange(moving, 1, 2));
    for (const auto& [name, value] :
         {std::pair("motion_begin", 1.0f), std::pair("motion_end", 2.0f),
          std::pair("last_step", 1.0f), std::pair("travel", 8.0f), std::pair("lane", 0.0f)})
        setFloat(moving, rtGeometryDeclareVariable, name, value);
    RTgeometrygroup top = group({instance(moving, {material("hit_mark")})});
    RTacceleration built = nullptr;
    ok(rtGeometryGroupGetAcceleration(top, &built));
    setEntry("shoot_at");
    ok(rtVariableSet1f(variable("ray_time"), 0.5f)); // before the range
    EXPECT_EQ(shoot(top)[0], 1);
    ok(rtGeometrySetMotionBorderMode(moving, RT_MOTIONBORDERMODE_VANISH,
                                     RT_MOTIONBORDERMODE_CLAMP));
    ok(rtAccelerationMarkDirty(built));
    EXPECT_EQ(shoot(top)[0], -2);
}

TEST_F(LaunchEffects, OfSizesInAList) {
    RTbuffer picture = buffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, 1);
    const RTsize sizes[2] = {3, 2};
    ok(rtBufferSetSizev(picture, 2, sizes));
    ok(rtVariableSetObject(variable("image"), picture));
    ok(rtVariableSet1f(variable("scoped"), 5));
    setEntry("paint_image");
    ok(rtContextLaunch2D(context_, 0, 3, 2));
    void* data = nullptr;
    ok(rtBufferMap(picture, &data));
    for (int i = 0; i < 6; ++i)
        EXPECT_EQ(static_cast<const float*>(data)[4 * i + 2], 5) << i;
    ok(rtBufferUnmap(picture));
}

class Lookups : public LaunchEffects {
protected:
    void SetUp() override {
        LaunchEffects::SetUp();
        ok(rtTextureSamplerCreate(context_, &sampler_));
        ok(rtTextureSamplerSetFilteringModes(sampler_, RT_FILTER_NEAREST, RT_FILTER_NEAREST,
                                             RT_FILTER_NONE));
        int id = 0;
        ok(rtTextureSamplerGetId(sampler_, &id));
        ok(rtVariableSet1i(variable("texture_id"), id));
        ok(rtVariableSet1i(variable("gl_target"), -1)); // of two dimensions
        ok(rtVariableSet1i(variable("layer"), 0));
    }
    RTbuffer texels(unsigned width, unsigned height, unsigned levels) {
        RTbuffer made = nullptr;
        ok(rtBufferCreate(context_, RT_BUFFER_INPUT, &made));
        ok(rtBufferSetFormat(made, RT_FORMAT_FLOAT));
        ok(rtBufferSetSize2D(made, width, height));
        ok(rtBufferSetMipLevelCount(made, levels));
        ok(rtTextureSamplerSetBuffer(sampler_, 0, 0, made));
        return made;
    }
    RTtexturesampler sampler_ = nullptr;
};

TEST_F(Lookups, OutsideByEachWrapMode) {
    fill<float>(texels(4, 4, 1), {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16});
    ok(rtVariableSet3f(variable("place"), 1.375f, 1.375f, 0));
    const auto look = [&](RTwrapmode across, RTwrapmode down) {
        ok(rtTextureSamplerSetWrapMode(sampler_, 0, across));
        ok(rtTextureSamplerSetWrapMode(sampler_, 1, down));
        return launch("sample_target")[0];
    };
    EXPECT_EQ(look(RT_WRAP_REPEAT, RT_WRAP_REPEAT), 6);
    EXPECT_EQ(look(RT_WRAP_CLAMP_TO_EDGE, RT_WRAP_CLAMP_TO_EDGE), 16);
    EXPECT_EQ(look(RT_WRAP_MIRROR, RT_WRAP_MIRROR), 11);
    EXPECT_EQ(look(RT_WRAP_CLAMP_TO_BORDER, RT_WRAP_CLAMP_TO_BORDER), 0);
    EXPECT_EQ(look(RT_WRAP_REPEAT, RT_WRAP_CLAMP_TO_EDGE), 14) << "each dimension has its own";
}

TEST_F(Lookups, LevelsAreShiftedAndClamped) {
    RTbuffer levels = texels(4, 4, 3);
    for (unsigned level = 0; level < 3; ++level) {
        void* data = nullptr;
        ok(rtBufferMapEx(levels, RT_BUFFER_MAP_WRITE, level, nullptr, &data));
        std::fill_n(static_cast<float*>(data), 16 >> (2 * level), 10.0f * float(level + 1));
        ok(rtBufferUnmapEx(levels, level));
    }
    ok(rtTextureSamplerSetFilteringModes(sampler_, RT_FILTER_NEAREST, RT_FILTER_NEAREST,
                                         RT_FILTER_NEAREST));
    const auto look = [&] {
        const std::vector<float> r = launch("sample_levels");
        return std::vector<float>(r.begin(), r.begin() + 3);
    };
    EXPECT_EQ(look(), (std::vector<float>{10, 20, 30}));
    ok(rtTextureSamplerSetMipLevelBias(sampler_, 1));
    EXPECT_EQ(look(), (std::vector<float>{20, 30, 30}));
    ok(rtTextureSamplerSetMipLevelBias(sampler_, 0));
    ok(rtTextureSamplerSetMipLevelClamp(sampler_, 1, 1));
    EXPECT_EQ(look(), (std::vector<float>{20, 20, 20}));
}

} // namespace
} // namespace sunstone::api6
