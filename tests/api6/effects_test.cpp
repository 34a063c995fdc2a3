// SPDX-License-Identifier: Apache-2.0
// Effects of functions that other files do not test: a function without effect fails a test here.
// tests/coverage/classic checks this for all functions.
#include "rays.h"

#include "optix_cuda_interop.h"

#include <array>
#include <cstdio>
#include <unistd.h>

namespace sunstone::api6 {
namespace {

class Effects : public Rays {};

TEST_F(Effects, OfIndicesAndMaterialsOfTriangles) {
    RTgeometrytriangles mesh = nullptr;
    ok(rtGeometryTrianglesCreate(context_, &mesh));
    ok(rtGeometryTrianglesSetPrimitiveCount(mesh, 2));
    const std::vector<float> corners = {0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
    ok(rtGeometryTrianglesSetVertices(mesh, 4, filled(RT_FORMAT_FLOAT, corners), 0, 12,
                                      RT_FORMAT_FLOAT3));
    const std::vector<unsigned> indices = {~0u, 1, 3, 2, 0, 1, 2};
    ok(rtGeometryTrianglesSetTriangleIndices(mesh, filled(RT_FORMAT_UNSIGNED_INT, indices), 4, 12,
                                             RT_FORMAT_UNSIGNED_INT3));
    ok(rtGeometryTrianglesSetMaterialCount(mesh, 2));
    const std::vector<unsigned char> choice = {9, 1, 0};
    ok(rtGeometryTrianglesSetMaterialIndices(mesh, filled(RT_FORMAT_UNSIGNED_BYTE, choice), 1, 1,
                                             RT_FORMAT_UNSIGNED_BYTE));
    RTmaterial first = material("hit_triangle"), second = material("hit_head");
    setFloat(second, rtMaterialDeclareVariable, "mark", 20);
    RTgeometrygroup top = group({instance(mesh, {first, second})});
    EXPECT_EQ(shoot(top)[0], 1) << "the second triangle has the first material";
    const float far[3] = {0.75f, 0.75f, 10};
    ok(rtVariableSet3fv(variable("ray_origin"), far));
    EXPECT_EQ(shoot(top)[0], 20) << "the first triangle has the second material";
    // Without indices again: a list of corners.
    ok(rtGeometryTrianglesSetTriangleIndices(mesh, nullptr, 0, 0, RT_FORMAT_UNSIGNED_INT3));
    fails(RT_ERROR_INVALID_VALUE, rtGeometryTrianglesValidate(mesh), "4 vertices");
}

TEST_F(Effects, OfGettersOfTheGraph) {
    RTgeometry shape = squares(1);
    RTmaterial paint = material("hit_mark", "count_any");
    RTgeometryinstance custom = instance(shape, {paint}), mesh = instance(triangle(1), {paint});
    RTgeometrygroup leaf = group({custom, mesh});
    unsigned count = 0;
    ok(rtGeometryGroupGetChildCount(leaf, &count));
    EXPECT_EQ(count, 2u);
    RTgeometryinstance child = nullptr;
    ok(rtGeometryGroupGetChild(leaf, 1, &child));
    EXPECT_EQ(child, mesh);
    RTgeometry geometry = nullptr;
    ok(rtGeometryInstanceGetGeometry(custom, &geometry));
    EXPECT_EQ(geometry, shape);
    RTgeometrytriangles triangles = triangle(2), found = nullptr;
    ok(rtGeometryInstanceSetGeometryTriangles(mesh, triangles));
    ok(rtGeometryInstanceGetGeometryTriangles(mesh, &found));
    EXPECT_EQ(found, triangles);
    RTprogram closest = program("hit_tag"), any = program("ignore_any"), kept = nullptr;
    ok(rtMaterialSetClosestHitProgram(paint, 1, closest));
    ok(rtMaterialSetAnyHitProgram(paint, 1, any));
    ok(rtMaterialGetClosestHitProgram(paint, 1, &kept));
    EXPECT_EQ(kept, closest);
    ok(rtMaterialGetAnyHitProgram(paint, 1, &kept));
    EXPECT_EQ(kept, any);
    RTobjecttype type = RT_OBJECTTYPE_UNKNOWN;
    ok(rtTransformGetChildType(moved(groupOf({leaf}), 1), &type));
    EXPECT_EQ(type, RT_OBJECTTYPE_GROUP);
}

TEST_F(Effects, OfMotionKeys) {
    RTtransform node = moved(group({instance(squares(1), {material("hit_world")})}), 0);
    std::array<float, 24> matrices{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0,
                                   1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0},
        found{};
    ok(rtTransformSetMotionKeys(node, 2, RT_MOTIONKEYTYPE_MATRIX_FLOAT12, matrices.data()));
    unsigned count = 0;
    RTmotionkeytype type = RT_MOTIONKEYTYPE_NONE;
    ok(rtTransformGetMotionKeyCount(node, &count));
    EXPECT_EQ(count, 2u);
    ok(rtTransformGetMotionKeyType(node, &type));
    EXPECT_EQ(type, RT_MOTIONKEYTYPE_MATRIX_FLOAT12);
    ok(rtTransformGetMotionKeys(node, found.data()));
    EXPECT_EQ(found, matrices);
    setEntry("shoot_at");
    ok(rtVariableSet1f(variable("ray_time"), 0.5f));
    const float from[3] = {2.5f, 0.5f, 10};
    ok(rtVariableSet3fv(variable("ray_origin"), from));
    EXPECT_EQ(shoot(node)[0], 2);
}

TEST_F(Effects, OfGettersOfContexts) {
    unsigned before = 0, after = 0;
    ok(rtContextGetVariableCount(context_, &before));
    ASSERT_GT(before, 0u);
    RTvariable made = nullptr, found = nullptr;
    ok(rtContextDeclareVariable(context_, "another", &made));
    ok(rtContextGetVariableCount(context_, &after));
    EXPECT_EQ(after, before + 1);
    ok(rtContextGetVariable(context_, before, &found));
    EXPECT_EQ(found, made);
    ok(rtContextRemoveVariable(context_, made));
    fails(RT_ERROR_INVALID_VALUE, rtContextGetVariable(context_, before, &found), "variables");
    int id = 0;
    ok(rtBufferGetId(result_, &id));
    RTbuffer buffer = nullptr;
    ok(rtContextGetBufferFromId(context_, id, &buffer));
    EXPECT_EQ(buffer, result_);
    RTprogram handler = program("note_exception"), kept = nullptr;
    ok(rtContextSetExceptionProgram(context_, 0, handler));
    ok(rtContextGetExceptionProgram(context_, 0, &kept));
    EXPECT_EQ(kept, handler);
}

TEST_F(Effects, OfLaunchesOfThreeDimensions) {
    RTbuffer places = buffer(RT_BUFFER_OUTPUT, RT_FORMAT_UNSIGNED_INT3, 1);
    ok(rtBufferSetSize3D(places, 4, 3, 2));
    ok(rtVariableSetObject(variable("places"), places));
    setEntry("write_place");
    ok(rtContextLaunch3D(context_, 0, 4, 3, 2));
    void* data = nullptr;
    ok(rtBufferMap(places, &data));
    const auto* place = static_cast<const unsigned*>(data);
    for (unsigned z = 0, i = 0; z < 2; ++z)
        for (unsigned y = 0; y < 3; ++y)
            for (unsigned x = 0; x < 4; ++x, i += 3) {
                EXPECT_EQ(place[i], x + 10 * 4) << i;
                EXPECT_EQ(place[i + 1], y + 10 * 3) << i;
                EXPECT_EQ(place[i + 2], z + 10 * 2) << i;
            }
    ok(rtBufferUnmap(places));
}

TEST_F(Effects, OfFilesOfPrograms) {
    const std::string path = testing::TempDir() + "programs_" + std::to_string(getpid()) + ".ptx";
    std::ofstream(path) << ptx();
    RTprogram made = nullptr;
    ok(rtVariableSet1f(variable("scoped"), 3));
    ok(rtProgramCreateFromPTXFile(context_, path.c_str(), "write_scoped", &made));
    ok(rtContextSetRayGenerationProgram(context_, 0, made));
    ok(rtContextLaunch1D(context_, 0, 1));
    EXPECT_EQ(results()[0], 3);
    const char* paths[] = {path.c_str()};
    ok(rtProgramCreateFromPTXFiles(context_, 1, paths, "write_other", &made));
    ok(rtContextSetRayGenerationProgram(context_, 0, made));
    ok(rtContextLaunch1D(context_, 0, 1));
    EXPECT_EQ(results()[0], 6);
    std::remove(path.c_str());
}

TEST_F(Effects, OfBuffersForCuda) {
    RTbuffer own = nullptr, lender = filled<float>(RT_FORMAT_FLOAT, std::vector<float>(64, 7));
    ok(rtBufferCreateForCUDA(context_, RT_BUFFER_INPUT_OUTPUT, &own));
    ok(rtBufferSetFormat(own, RT_FORMAT_FLOAT));
    ok(rtBufferSetSize1D(own, 64));
    ok(rtVariableSetObject(variable("result"), own));
    ok(rtVariableSet1f(variable("scoped"), 3));
    void* memory = nullptr;
    ok(rtBufferGetDevicePointer(lender, 0, &memory));
    ok(rtBufferSetDevicePointer(own, 0, memory));
    void* kept = nullptr;
    ok(rtBufferGetDevicePointer(own, 0, &kept));
    EXPECT_EQ(kept, memory);
    launch("write_scoped", 2);
    void* data = nullptr;
    ok(rtBufferMap(lender, &data));
    EXPECT_EQ(static_cast<const float*>(data)[1], 3) << "launches write to the lent memory";
    EXPECT_EQ(static_cast<const float*>(data)[2], 7);
    ok(rtBufferUnmap(lender));
}

// A larger buffer does not fit into the memory that the application gave for a smaller one.
TEST_F(Effects, OfSizesOfBuffersInMemoryOfTheApplication) {
    RTbuffer lender = filled<float>(RT_FORMAT_FLOAT, std::vector<float>(64, 7));
    RTbuffer own = buffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT, 32);
    void *memory = nullptr, *kept = nullptr;
    ok(rtBufferGetDevicePointer(lender, 0, &memory));
    ok(rtBufferSetDevicePointer(own, 0, memory));
    ok(rtBufferSetSize1D(own, 64));
    ok(rtBufferGetDevicePointer(own, 0, &kept));
    EXPECT_EQ(kept, memory) << "it is in accessible memory";
    ok(rtBufferSetSize1D(own, size_t(1) << 24));
    ok(rtBufferGetDevicePointer(own, 0, &kept));
    EXPECT_NE(kept, memory);
    ok(rtBufferSetSize1D(own, 64));
    ok(rtBufferSetDevicePointer(own, 0, memory));
    ok(rtBufferGetDevicePointer(own, 0, &kept));
    EXPECT_EQ(kept, memory);
}

TEST_F(Effects, OfSizesOfBuffers) {
    RTbuffer made = buffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, 12);
    ok(rtBufferSetMipLevelCount(made, 3));
    RTsize level = 0, sizes[3] = {};
    ok(rtBufferGetMipLevelSize1D(made, 1, &level));
    EXPECT_EQ(level, 6u);
    RTbuffer volume = buffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, 1);
    ok(rtBufferSetSize3D(volume, 5, 6, 7));
    ok(rtBufferGetSizev(volume, 3, sizes));
    EXPECT_EQ(sizes[0] + 10 * sizes[1] + 100 * sizes[2], 5u + 60 + 700);
}

TEST_F(Effects, OfGettersOfTextureSamplers) {
    RTtexturesampler made = nullptr;
    ok(rtTextureSamplerCreate(context_, &made));
    unsigned count = 0;
    ok(rtTextureSamplerGetArraySize(made, &count));
    EXPECT_EQ(count, 1u);
    RTcontext owner = nullptr;
    ok(rtTextureSamplerGetContext(made, &owner));
    EXPECT_EQ(owner, context_);
}

} // namespace
} // namespace sunstone::api6
