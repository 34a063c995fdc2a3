// SPDX-License-Identifier: Apache-2.0
// The helper functions of the device headers, and symbols that no other test names: every accepted
// value of the compile options, and the alignments that the headers define.
#include "device/helpers.h"
#include "rig.h"
#include "scene.h"

#include <cmath>

namespace tests::api {
namespace {

class Helpers : public DeviceTest {
protected:
    // A triangle under a static transform under an instance.
    void makeScene() {
        mesh_ = std::make_unique<TriangleMesh>(
            std::vector<Vec3>{{-50, -50, 1}, {50, -50, 1}, {0, 80, 1}},
            std::vector<uint32_t>{0, 1, 2});
        gas_ = buildAccel(context_, log_, {mesh_->input});
        transform_ = Buffer(sizeof(OptixStaticTransform), OPTIX_TRANSFORM_BYTE_ALIGNMENT);
        auto& t = *transform_.as<OptixStaticTransform>();
        t.child = gas_.handle;
        t.pad[0] = 4711;
        std::copy(inner_.begin(), inner_.end(), t.transform);
        Matrix back = inverse(inner_);
        std::copy(back.begin(), back.end(), t.invTransform);
        OptixTraversableHandle handle = 0;
        require(optixConvertPointerToTraversableHandle(context_, transform_.address(),
                                                       OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM,
                                                       &handle),
                "optixConvertPointerToTraversableHandle", log_);
        OptixInstance instance = instanceOf(handle, outer_, 77);
        instance.flags = OPTIX_INSTANCE_FLAG_NONE;
        instances_ = std::make_unique<InstanceList>(std::vector<OptixInstance>{instance});
        ias_ = buildAccel(context_, log_, {instances_->input});
    }
    HelperResult run(bool dump = false) {
        auto r = rig("helpers", compileOptions(0));
        r->raygenRecord(r->raygen("__raygen__helpers"));
        r->missRecord(r->miss("__miss__helpers"));
        r->hitRecord(r->hit("__closesthit__helpers"));
        r->link();
        require(optixPipelineSetStackSize(r->pipeline(), 0, 0, 2000, 3),
                "optixPipelineSetStackSize", log_);
        Buffer out(sizeof(HelperResult));
        Buffer aligned(std::vector<float>{1.0f, 2.0f, 4.0f, 8.0f}, 16);
        r->run(HelperParams{out.as<HelperResult>(), ias_.handle, aligned.as<float>(), dump}, 1);
        return *out.as<HelperResult>();
    }
    static void expectNear(Vec3 expected, const float* given, const char* what) {
        EXPECT_NEAR(expected.x, given[0], 1e-4f) << what;
        EXPECT_NEAR(expected.y, given[1], 1e-4f) << what;
        EXPECT_NEAR(expected.z, given[2], 1e-4f) << what;
    }

    const Matrix outer_ = {0, -2, 0, 0.5f, 1, 0, 0, -0.25f, 0, 0, 1, 1};
    const Matrix inner_ = {1, 0.5f, 0, 0, 0, 1, 0, 0, 0, 0, 3, 0.5f};
    std::unique_ptr<TriangleMesh> mesh_;
    std::unique_ptr<InstanceList> instances_;
    Accel gas_, ias_;
    Buffer transform_;
};

TEST_P(Helpers, TransformsAgreeWithTheHost) {
    makeScene();
    HelperResult r = run();
    ASSERT_EQ(1u, r.hits);
    EXPECT_EQ(unsigned(OPTIX_HIT_KIND_TRIANGLE_BACK_FACE), r.hitKind);
    EXPECT_EQ(unsigned(OPTIX_TRANSFORM_TYPE_NONE), r.typeOfNothing);
    EXPECT_EQ(4711u, r.staticChild);
    const Vec3 v{1, 2, 3};
    Vec3 point = transformPoint(outer_, transformPoint(inner_, v));
    Vec3 vector = transformVector(outer_, transformVector(inner_, v));
    // Normals transform by the transposed inverse.
    Matrix back = inverse(outer_), more = inverse(inner_);
    auto transposed = [](const Matrix& m, Vec3 n) {
        return Vec3{m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
                    m[2] * n.x + m[6] * n.y + m[10] * n.z};
    };
    Vec3 normal = transposed(back, transposed(more, v));
    expectNear(point, r.point, "point");
    expectNear(vector, r.vector, "vector");
    expectNear(normal, r.normal, "normal");
    expectNear(v, r.back, "normal back to object space");
    expectNear(point, r.byMatrix, "point by matrix");
    expectNear(vector, r.byMatrix + 3, "vector by matrix");
    expectNear(normal, r.byMatrix + 6, "normal by matrix");
    // The inverse of the matrix to object space transforms back.
    Vec3 byInverse = {r.inverse[0] * v.x + r.inverse[1] * v.y + r.inverse[2] * v.z + r.inverse[3],
                      r.inverse[4] * v.x + r.inverse[5] * v.y + r.inverse[6] * v.z + r.inverse[7],
                      r.inverse[8] * v.x + r.inverse[9] * v.y + r.inverse[10] * v.z +
                          r.inverse[11]};
    expectNear(point, &byInverse.x, "inverse");
    for (int c = 0; c < 4; ++c) {
        float expected =
            r.inverse[c] * 1 + r.inverse[4 + c] * 2 + r.inverse[8 + c] * 3 + (c == 3 ? 4 : 0);
        EXPECT_NEAR(expected, r.product[c], 1e-4f) << "row times matrix, column " << c;
        EXPECT_EQ(3.0f * float(c + 1), r.sum[c]);
        float expectedWord = float(1 << c);
        unsigned bits;
        std::memcpy(&bits, &expectedWord, 4);
        EXPECT_EQ(bits, r.ldg[c]);
    }
    EXPECT_LE(r.undefined, 1u);
}

TEST_P(Helpers, DumpsPrintEveryTransform) {
    makeScene();
    testing::internal::CaptureStdout();
    HelperResult r = run(true);
    std::fflush(stdout);
    std::string text = testing::internal::GetCapturedStdout();
    ASSERT_EQ(1u, r.hits);
    EXPECT_NE(std::string::npos, text.find("object to world")) << text;
    EXPECT_NE(std::string::npos, text.find("world to object")) << text;
    // The instance's translation and the static transform's.
    EXPECT_NE(std::string::npos, text.find("-0.25")) << text;
    EXPECT_NE(std::string::npos, text.find("0 0 3 0.5")) << text;
}

INSTANTIATE_DEVICE_TEST(Helpers);

// ---- Options ------------------------------------------------------------------------------------

class Options : public ApiTest {};

const std::string kMiss = ptxModule(".visible .entry __miss__nothing() { ret; }");

TEST_F(Options, EveryLevelCompilesAndLinks) {
    for (auto optimization :
         {OPTIX_COMPILE_OPTIMIZATION_DEFAULT, OPTIX_COMPILE_OPTIMIZATION_LEVEL_0,
          OPTIX_COMPILE_OPTIMIZATION_LEVEL_1, OPTIX_COMPILE_OPTIMIZATION_LEVEL_2,
          OPTIX_COMPILE_OPTIMIZATION_LEVEL_3})
        for (auto debug : {OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT, OPTIX_COMPILE_DEBUG_LEVEL_NONE,
                           OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL, OPTIX_COMPILE_DEBUG_LEVEL_MODERATE,
                           OPTIX_COMPILE_DEBUG_LEVEL_FULL}) {
            SCOPED_TRACE(std::to_string(optimization) + " " + std::to_string(debug));
            OptixModuleCompileOptions options{};
            options.maxRegisterCount = OPTIX_COMPILE_DEFAULT_MAX_REGISTER_COUNT;
            options.optLevel = optimization;
            options.debugLevel = debug;
            OptixPipelineCompileOptions pipelineOptions = compileOptions();
            pipelineOptions.pipelineLaunchParamsVariableName = nullptr;
            OptixModule module = nullptr;
            ASSERT_OK(optixModuleCreateFromPTX(context_, &options, &pipelineOptions, kMiss.data(),
                                               kMiss.size(), nullptr, nullptr, &module));
            OptixProgramGroupDesc desc{};
            desc.kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
            desc.flags = OPTIX_PROGRAM_GROUP_FLAGS_NONE;
            desc.miss = {module, "__miss__nothing"};
            OptixProgramGroupOptions groupOptions{};
            OptixProgramGroup group = nullptr;
            ASSERT_OK(optixProgramGroupCreate(context_, &desc, 1, &groupOptions, nullptr, nullptr,
                                              &group));
            OptixPipelineLinkOptions link{1, debug};
            OptixPipeline pipeline = nullptr;
            ASSERT_OK(optixPipelineCreate(context_, &pipelineOptions, &link, &group, 1, nullptr,
                                          nullptr, &pipeline));
            EXPECT_OK(optixPipelineDestroy(pipeline));
            EXPECT_OK(optixProgramGroupDestroy(group));
            EXPECT_OK(optixModuleDestroy(module));
        }
}

TEST_F(Options, VertexFormatNoneNeedsNoVertices) {
    TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
    OptixBuildInputTriangleArray& triangles = mesh.input.triangleArray;
    triangles.vertexFormat = OPTIX_VERTEX_FORMAT_NONE;
    OptixAccelBuildOptions options = buildOptions();
    OptixAccelBufferSizes sizes{};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelComputeMemoryUsage", "vertexFormat",
                    optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
    triangles.vertexBuffers = nullptr;
    triangles.numVertices = 0;
    triangles.indexFormat = OPTIX_INDICES_FORMAT_NONE;
    triangles.indexBuffer = 0;
    triangles.numIndexTriplets = 0;
    EXPECT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
}

// Addresses with the alignment of the headers work; addresses with half of it do not.
TEST_F(Options, AlignmentsAreThoseOfTheHeaders) {
    TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
    Accel gas = buildAccel(context_, log_, {mesh.input});
    auto build = [&](OptixBuildInput input, CUdeviceptr output, const char* mention) {
        OptixAccelBuildOptions options = buildOptions();
        Buffer temp(1 << 16);
        OptixTraversableHandle handle = 0;
        OptixResult result = optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(),
                                             temp.size(), output, 1 << 16, &handle, nullptr, 0);
        waitForDevice();
        if (mention)
            expectRejected(OPTIX_ERROR_INVALID_VALUE, result, "optixAccelBuild", mention);
        else
            EXPECT_EQ(OPTIX_SUCCESS, result) << log_.all();
        log_.clear();
    };
    Buffer room((1 << 16) + 256, 2 * OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT);
    CUdeviceptr output = room.address() + OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT;
    build(mesh.input, output, nullptr);
    build(mesh.input, output + OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT / 2, "outputBuffer");

    Buffer matrices(200, 2 * OPTIX_GEOMETRY_TRANSFORM_BYTE_ALIGNMENT);
    mesh.input.triangleArray.transformFormat = OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12;
    mesh.input.triangleArray.preTransform =
        matrices.address() + OPTIX_GEOMETRY_TRANSFORM_BYTE_ALIGNMENT;
    build(mesh.input, output, nullptr);
    mesh.input.triangleArray.preTransform += OPTIX_GEOMETRY_TRANSFORM_BYTE_ALIGNMENT / 2;
    build(mesh.input, output, "preTransform");

    Buffer instances(300, 2 * OPTIX_INSTANCE_BYTE_ALIGNMENT);
    OptixBuildInput list{};
    list.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    list.instanceArray.numInstances = 1;
    list.instanceArray.instances = instances.address() + OPTIX_INSTANCE_BYTE_ALIGNMENT;
    build(list, output, nullptr);
    list.instanceArray.instances += OPTIX_INSTANCE_BYTE_ALIGNMENT / 2;
    build(list, output, "instances");

    CustomBoxes boxes({{0, 0, 0, 1, 1, 1}});
    Buffer boxMemory(100, 2 * OPTIX_AABB_BUFFER_BYTE_ALIGNMENT);
    CUdeviceptr at = boxMemory.address() + OPTIX_AABB_BUFFER_BYTE_ALIGNMENT;
    boxes.input.customPrimitiveArray.aabbBuffers = &at;
    build(boxes.input, output, nullptr);
    at += OPTIX_AABB_BUFFER_BYTE_ALIGNMENT / 2;
    build(boxes.input, output, "aabbBuffers");

    Buffer transforms(400, 2 * OPTIX_TRANSFORM_BYTE_ALIGNMENT);
    OptixTraversableHandle handle = 0;
    auto convert = [&](CUdeviceptr pointer) {
        return optixConvertPointerToTraversableHandle(
            context_, pointer, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, &handle);
    };
    auto* transform = reinterpret_cast<OptixStaticTransform*>(transforms.address() +
                                                              OPTIX_TRANSFORM_BYTE_ALIGNMENT);
    transform->child = gas.handle;
    EXPECT_OK(convert(CUdeviceptr(uintptr_t(transform))));
    EXPECT_REJECTED(
        OPTIX_ERROR_INVALID_VALUE, "optixConvertPointerToTraversableHandle", "pointer",
        convert(CUdeviceptr(uintptr_t(transform)) + OPTIX_TRANSFORM_BYTE_ALIGNMENT / 2));
}

TEST_F(Options, BoundsOfBoxes) {
    OptixAabb box{};
    box.minX = -1;
    box.minY = -2;
    box.minZ = -3;
    box.maxX = 4;
    box.maxY = 5;
    box.maxZ = 6;
    CustomBoxes boxes({box, {0, 0, 0, 1, 7, 1}});
    Buffer bounds(sizeof(OptixAabb), 8);
    buildAccel(context_, log_, {boxes.input}, 0, {{bounds.address(), OPTIX_PROPERTY_TYPE_AABBS}});
    const OptixAabb& all = *bounds.as<OptixAabb>();
    EXPECT_EQ(-1, all.minX);
    EXPECT_EQ(-2, all.minY);
    EXPECT_EQ(-3, all.minZ);
    EXPECT_EQ(4, all.maxX);
    EXPECT_EQ(7, all.maxY);
    EXPECT_EQ(6, all.maxZ);
}

TEST_F(Options, DenoiserGuidesByName) {
    OptixDenoiserOptions options{};
    options.guideAlbedo = 1;
    options.guideNormal = 1;
    OptixDenoiser denoiser = nullptr;
    ASSERT_OK(optixDenoiserCreate(context_, OPTIX_DENOISER_MODEL_KIND_HDR, &options, &denoiser));
    EXPECT_OK(optixDenoiserDestroy(denoiser));
}

TEST_F(Options, SingleLevelInstancing) {
    OptixPipelineCompileOptions options = compileOptions();
    options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
    options.pipelineLaunchParamsVariableName = nullptr;
    OptixModuleCompileOptions moduleOptions{};
    OptixModule module = nullptr;
    ASSERT_OK(optixModuleCreateFromPTX(context_, &moduleOptions, &options, kMiss.data(),
                                       kMiss.size(), nullptr, nullptr, &module));
    EXPECT_OK(optixModuleDestroy(module));
}

} // namespace
} // namespace tests::api
