// SPDX-License-Identifier: Apache-2.0
// The kernel of a GPU pipeline on the CPU device, which runs PTX too: launch indices, records and
// the launch's report. This tests the code for GPUs without a GPU.
#include "bvh/micromap/micromap_array.h"
#include "bvh/micromap/micromap_lookup.h"
#include "bvh/shapes/shapes.h"
#include "bvh/walk/kernels.h"
#include "devlib/flags.h"
#include "gpu/kernel.h"
#include "gpu/rays.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <sstream>
#include <vector>

namespace sunstone {
namespace {

using namespace gpu_tests;

// Launches with one record, for ray generation; params is one address.
devlib::LaunchReport launch(const Kernel& kernel, const Record& raygenRecord, void* output,
                            uint32_t width, uint32_t height, uint32_t depth) {
    Buffer record(sizeof(Record)), params(16, 0);
    std::memcpy(record.data(), &raygenRecord, sizeof(Record));
    std::memcpy(params.data(), &output, sizeof(output));
    devlib::LaunchBlock block{};
    block.launch.params = params.data();
    block.launch.sbt.entryRecord = record.address();
    return kernel.launch(block, width, height, depth);
}

// Adds 1 plus 16 times the record's first word to the word of each launch index.
const char* const kCount = R"(
    call (%r1), _optix_get_launch_index_x, ();
    call (%r2), _optix_get_launch_index_y, ();
    call (%r3), _optix_get_launch_index_z, ();
    call (%r4), _optix_get_launch_dimension_x, ();
    call (%r5), _optix_get_launch_dimension_y, ();
    mad.lo.u32 %r6, %r3, %r5, %r2;
    mad.lo.u32 %r6, %r6, %r4, %r1;
    mul.wide.u32 %rd2, %r6, 4;
    add.s64 %rd3, %rd1, %rd2;
    call (%rd4), _optix_get_sbt_data_ptr_64, ();
    ld.u32 %r7, [%rd4];
    shl.b32 %r7, %r7, 4;
    add.u32 %r7, %r7, 1;
    atom.global.add.u32 %r1, [%rd3], %r7;
)";

TEST(GpuRun, EveryLaunchIndexRunsOnce) {
    Record record = recordOf(kFirstGroup, devlib::kGroupRaygen);
    record.data[0] = 3;
    const Kernel kernel(raygen(kCount));
    const uint32_t sizes[][3] = {{1, 1, 1}, {100, 1, 1}, {13, 7, 1}, {64, 4, 3}, {5, 1, 9}};
    for (const auto& size : sizes) {
        const uint32_t count = size[0] * size[1] * size[2];
        Buffer output(count * 4 + 64, 0);
        const devlib::LaunchReport report =
            launch(kernel, record, output.data(), size[0], size[1], size[2]);
        EXPECT_EQ(report.fatal, devlib::kNoReport);
        EXPECT_EQ(report.unseen, devlib::kNoReport);
        const auto* words = static_cast<const uint32_t*>(output.data());
        for (uint32_t i = 0; i < count; ++i)
            ASSERT_EQ(words[i], 49u)
                << i << " of " << size[0] << " x " << size[1] << " x " << size[2];
        EXPECT_EQ(words[count], 0u);
    }
}

TEST(GpuRun, FunctionsDeclaredInBodies) {
    const std::string body = R"(
    { .func (.reg .b32 r) tripled(.param .b32 a);
      call.uni (%r2), tripled, (%r1); }
    st.global.u32 [%rd1], %r2;
)";
    const Kernel kernel(raygen(body) + ".func (.reg .b32 r) tripled(.param .b32 a)\n{\n"
                                       "ld.param.u32 r, [a];\nmul.lo.u32 r, r, 3;\nret;\n}\n");
    Buffer output(16, 0);
    static_cast<uint32_t*>(output.data())[1] = 14;
    const auto report =
        launch(kernel, recordOf(kFirstGroup, devlib::kGroupRaygen), output.data(), 1, 1, 1);
    EXPECT_EQ(report.fatal, devlib::kNoReport);
    EXPECT_EQ(*static_cast<const uint32_t*>(output.data()), 42u);
}

TEST(GpuRun, RecordsOfOtherGroupsAreReported) {
    Buffer output(256, 0);
    const Kernel kernel(raygen(kCount));
    const auto failureOf = [&](const Record& record) {
        return launch(kernel, record, output.data(), 4, 4, 1).fatal;
    };
    const uint64_t wanted = uint32_t(devlib::kFatalRaygenRecord); // at index 0
    EXPECT_EQ(failureOf(recordOf(kFirstGroup - 1, devlib::kGroupRaygen)), wanted);
    EXPECT_EQ(failureOf(recordOf(kFirstGroup + 1, devlib::kGroupRaygen)), wanted);
    EXPECT_EQ(failureOf(recordOf(kFirstGroup, devlib::kGroupMiss)), wanted);
    EXPECT_EQ(failureOf(Record()), wanted);
    EXPECT_EQ(*static_cast<const uint32_t*>(output.data()), 0u);
}

TEST(GpuRun, ExceptionsNobodySeesAreReported) {
    Buffer output(256, 0);
    const Kernel throws(raygen(R"(
    mov.u32 %r2, 77;
    call _optix_throw_exception_0, (%r2);
)"));
    const Record record = recordOf(kFirstGroup, devlib::kGroupRaygen);
    const devlib::LaunchReport report = launch(throws, record, output.data(), 9, 2, 1);
    EXPECT_EQ(report.unseen, 77u); // of launch index 0
    EXPECT_EQ(report.fatal, devlib::kNoReport);
    const devlib::LaunchReport trapped =
        launch(Kernel(raygen("    trap;\n")), record, output.data(), 2, 1, 1);
    EXPECT_EQ(trapped.fatal, uint64_t(uint32_t(devlib::kExceptionTrap)));
}

// Rays from all around a rough sphere.
std::vector<TestRay> raysAround(uint32_t count) {
    std::vector<TestRay> rays;
    uint32_t state = 1;
    const auto number = [&] {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) * 0x1p-23f - 1;
    };
    for (uint32_t i = 0; i < count; ++i) {
        TestRay ray{{number() * 4, number() * 4, number() * 4}, 0, {}, 1e16f};
        for (int k = 0; k < 3; ++k)
            ray.direction[k] = number() * 0.8f - ray.origin[k];
        rays.push_back(ray);
    }
    return rays;
}

std::vector<TestHit> trace(const Kernel& kernel, uint64_t handle, const std::vector<TestRay>& rays,
                           unsigned flags) {
    const auto count = uint32_t(rays.size());
    Buffer rayMemory(count * sizeof(TestRay)), hits(count * sizeof(TestHit)),
        params(sizeof(TestParams)), records(3 * sizeof(Record));
    std::memcpy(rayMemory.data(), rays.data(), rayMemory.size());
    const TestParams values = {static_cast<const TestRay*>(rayMemory.data()),
                               static_cast<TestHit*>(hits.data()), handle, flags};
    std::memcpy(params.data(), &values, sizeof(values));
    // The programs' numbers are their places in the file.
    const Record all[] = {recordOf(kFirstGroup, devlib::kGroupRaygen),
                          recordOf(kFirstGroup + 1, devlib::kGroupMiss),
                          recordOf(kFirstGroup + 2, devlib::kGroupHit)};
    std::memcpy(records.data(), all, sizeof(all));
    devlib::LaunchBlock block{};
    block.launch.params = params.data();
    devlib::SbtView& sbt = block.launch.sbt;
    sbt.entryRecord = records.address();
    sbt.missBase = sbt.entryRecord + sizeof(Record);
    sbt.hitBase = sbt.missBase + sizeof(Record);
    sbt.missStride = sbt.hitStride = sizeof(Record);
    sbt.missCount = sbt.hitCount = 1;
    const devlib::LaunchReport report = kernel.launch(block, count);
    EXPECT_EQ(report.fatal, devlib::kNoReport);
    const auto* found = static_cast<const TestHit*>(hits.data());
    return {found, found + count};
}

std::string raysModule() {
    std::ifstream file(TEST_RAYS_PTX);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

// The any-hit program ignores odd numbers.
void expectFiltered(const Kernel& kernel, uint64_t handle, const std::vector<TestRay>& rays,
                    const std::vector<TestHit>& hits) {
    const std::vector<TestHit> filtered = trace(kernel, handle, rays, 0);
    for (size_t i = 0; i < rays.size(); ++i) {
        if (filtered[i].primitive != ~0u)
            ASSERT_EQ(filtered[i].primitive % 2, 0u) << i;
        if (hits[i].primitive % 2 == 0)
            ASSERT_EQ(filtered[i].primitive, hits[i].primitive) << i;
        if (hits[i].primitive != ~0u)
            ASSERT_GT(filtered[i].asked, 0u) << i;
    }
}

TEST(GpuRun, TracesFindWhatTheTraversalFinds) {
    Options options;
    options.oneHitGroup = true;
    const Kernel kernel(raysModule(), options);
    const bvh::testing::Mesh mesh = bvh::testing::roughSphere(4, 7);
    const bvh::gpu::testing::GpuStructure structure =
        bvh::gpu::testing::buildOnDevice(mesh.input());
    const std::vector<TestRay> rays = raysAround(3000);

    constexpr unsigned kDisableAnyHit = 1;
    size_t count = 0;
    std::vector<TestHit> hits = trace(kernel, structure.handle(), rays, kDisableAnyHit);
    for (size_t i = 0; i < rays.size(); ++i) {
        bvh::QueryRay query{};
        for (int k = 0; k < 3; ++k) {
            query.origin[k] = rays[i].origin[k];
            query.direction[k] = rays[i].direction[k];
        }
        query.tmin = rays[i].tmin;
        query.tmax = rays[i].tmax;
        bvh::QueryHit wanted{};
        const bool found = bvh::gpu::testing::nearest(structure.handle(), query, wanted);
        count += found;
        ASSERT_EQ(hits[i].primitive, found ? wanted.primitive : ~0u) << i;
        ASSERT_EQ(hits[i].t, found ? wanted.t : rays[i].tmax) << i;
        ASSERT_EQ(hits[i].asked, 0u);
        if (found) {
            ASSERT_EQ(hits[i].u, wanted.u) << i;
            ASSERT_EQ(hits[i].v, wanted.v) << i;
        }
    }
    EXPECT_GT(count, rays.size() / 4);

    expectFiltered(kernel, structure.handle(), rays, hits);
}

// Rays at curves or spheres, compared with the kernels for the CPU.
void expectShapes(const Kernel& kernel, const bvh::BuildInputs& inputs, bool curves) {
    const bvh::testing::Structure cpu = bvh::testing::makeStructure(inputs);
    const bvh::gpu::testing::GpuStructure structure = bvh::gpu::testing::buildOnDevice(inputs);
    const std::vector<TestRay> rays = raysAround(1500);
    constexpr unsigned kDisableAnyHit = 1;
    const std::vector<TestHit> hits = trace(kernel, structure.handle(), rays, kDisableAnyHit);
    size_t count = 0, other = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        bvh::ShapeRay query{};
        for (int k = 0; k < 3; ++k) {
            query.origin[k] = rays[i].origin[k];
            query.direction[k] = rays[i].direction[k];
        }
        query.tmax = rays[i].tmax;
        bvh::ShapeHit wanted{};
        const bool found = bvh::shapeKernels(bvh::chosenIsa()).closest(cpu.block(), query, wanted);
        if (found != (hits[i].primitive != ~0u)) {
            ++other; // a ray that grazes
            continue;
        }
        count += found;
        if (!found)
            continue;
        ASSERT_NEAR(hits[i].t, wanted.t, 1e-4f * wanted.t) << i;
        other += hits[i].primitive != wanted.primitive;
        if (curves && hits[i].primitive == wanted.primitive)
            ASSERT_NEAR(hits[i].u, wanted.u, 1e-3f) << i;
        ASSERT_EQ(hits[i].asked, 0u);
    }
    EXPECT_GT(count, rays.size() / 10);
    EXPECT_LE(other, count / 20); // where segments join
    expectFiltered(kernel, structure.handle(), rays, hits);
}

// Triangles apart from one another in a plane, and an array of opacity micromaps of four states.
struct Cutouts {
    static constexpr uint32_t kSide = 8, kCount = kSide * kSide;
    std::vector<float> vertices;
    std::vector<bvh::MicromapDesc> descriptions;
    std::vector<uint8_t> states;
    std::vector<bvh::MicromapHistogramEntry> histogram = {
        {kCount, 3, bvh::MicromapFormat::kFourState}};
    uint32_t flags = 0;

    Cutouts() {
        for (uint32_t i = 0; i < kCount; ++i) {
            const float x = float(i % kSide), y = float(i / kSide);
            vertices.insert(vertices.end(), {x, y, 0, x + 0.9f, y, 0, x, y + 0.9f, 0});
            descriptions.push_back({16 * i, 3, uint16_t(bvh::MicromapFormat::kFourState)});
            for (uint32_t k = 0; k < 16; ++k)
                states.push_back(uint8_t(i * 37 + k * 101));
        }
    }
    bvh::MicromapArrayInput input() const {
        return {histogram, states.data(), descriptions.data(), 0};
    }
};

// The expected result of a ray down on the plane: from the triangle that it meets and the state
// there.
TestHit throughCutouts(uint64_t handle, const TestRay& ray, unsigned flags) {
    bvh::QueryRay query{};
    for (int k = 0; k < 3; ++k) {
        query.origin[k] = ray.origin[k];
        query.direction[k] = ray.direction[k];
    }
    query.tmax = ray.tmax;
    const TestHit miss = {ray.tmax, 0, 0, ~0u, 0};
    bvh::QueryHit hit{};
    if (!bvh::gpu::testing::nearest(handle, query, hit))
        return miss;
    const auto* const block = reinterpret_cast<const bvh::BlockHeader*>(handle & ~uint64_t(63));
    uint32_t state =
        bvh::gpu::lane::MicromapLookup(block).stateAt(hit.primitive, hit.sbt, hit.u, hit.v);
    if (flags & devlib::kRayForceMicromap2State)
        state &= 1;
    if (state == bvh::kTransparent)
        return miss;
    const bool asks = state != bvh::kOpaque && !(flags & devlib::kRayDisableAnyHit);
    if (asks && hit.primitive % 2)
        return {miss.t, 0, 0, ~0u, 1};
    return {hit.t, hit.u, hit.v, hit.primitive, asks};
}

TEST(GpuRun, OpacityMicromaps) {
    Options options;
    options.oneHitGroup = options.micromaps = true;
    const Kernel kernel(raysModule(), options);
    const Cutouts cutouts;
    Buffer array(bvh::micromapArraySizes(cutouts.histogram).output);
    Device::get().builder().buildMicromapArray(nullptr, cutouts.input(), cutouts.states.size(),
                                               array.address(), array.size());
    bvh::TriangleInput in;
    in.vertices = cutouts.vertices.data();
    in.numVertices = 3 * Cutouts::kCount;
    in.numTriangles = Cutouts::kCount;
    in.micromaps = {bvh::MicromapIndexing::kLinear, array.data()};
    in.sbt.flags = &cutouts.flags;
    const bvh::gpu::testing::GpuStructure structure = bvh::gpu::testing::buildOnDevice(in);
    std::vector<TestRay> rays;
    for (uint32_t i = 0; i < 2000; ++i)
        rays.push_back({{float(i % 50) * 0.163f, float(i / 50) * 0.207f, 2}, 0, {0, 0, -1}, 1e16f});
    for (const unsigned flags :
         {0u, unsigned(devlib::kRayDisableAnyHit), unsigned(devlib::kRayForceMicromap2State)}) {
        SCOPED_TRACE(flags);
        const std::vector<TestHit> hits = trace(kernel, structure.handle(), rays, flags);
        uint32_t asked = 0, found = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            const TestHit wanted = throughCutouts(structure.handle(), rays[i], flags);
            ASSERT_EQ(hits[i].primitive, wanted.primitive) << i;
            ASSERT_EQ(hits[i].asked, wanted.asked) << i;
            ASSERT_EQ(hits[i].t, wanted.t) << i;
            asked += wanted.asked;
            found += wanted.primitive != ~0u;
        }
        EXPECT_GT(found, 150u);
        EXPECT_EQ(asked == 0, flags != 0);
    }
    // A pipeline without the option does not read micromaps.
    Options blind;
    blind.oneHitGroup = true;
    const Kernel other(raysModule(), blind);
    const std::vector<TestHit> hits =
        trace(other, structure.handle(), rays, devlib::kRayDisableAnyHit);
    for (size_t i = 0; i < rays.size(); ++i) {
        bvh::QueryHit hit{};
        const TestRay& r = rays[i];
        const bool found = bvh::gpu::testing::nearest(
            structure.handle(), {{r.origin[0], r.origin[1], 2}, 0, {0, 0, -1}, r.tmax}, hit);
        ASSERT_EQ(hits[i].primitive, found ? hit.primitive : ~0u) << i;
    }
}

// Centres or control points, and radii.
struct Points {
    std::vector<float> places, radii;
    std::vector<uint32_t> indices;
    uint32_t flags = 0;

    explicit Points(uint32_t count) {
        uint32_t state = 7;
        const auto number = [&] {
            state = state * 1664525u + 1013904223u;
            return float(state >> 8) * 0x1p-23f - 1;
        };
        for (uint32_t i = 0; i < count; ++i) {
            for (int k = 0; k < 3; ++k)
                places.push_back(number() * 0.8f);
            radii.push_back(0.05f + 0.02f * number());
            indices.push_back(i);
        }
    }
};

TEST(GpuRun, Spheres) {
    Options options;
    options.oneHitGroup = true;
    options.shapes = bvh::gpu::kMeetsSpheres;
    const Kernel kernel(raysModule(), options);
    const Points points(200);
    bvh::SphereInput in;
    in.centres = points.places.data();
    in.radii = points.radii.data();
    in.numSpheres = 200;
    in.sbt.flags = &points.flags;
    bvh::BuildInputs inputs;
    inputs.spheres = {&in, 1};
    expectShapes(kernel, inputs, false);
    // A pipeline whose flags lack these primitives does not hit them.
    Options none;
    none.oneHitGroup = true;
    const Kernel other(raysModule(), none);
    const bvh::gpu::testing::GpuStructure structure = bvh::gpu::testing::buildOnDevice(inputs);
    for (const TestHit& hit : trace(other, structure.handle(), raysAround(200), 0))
        EXPECT_EQ(hit.primitive, ~0u);
}

TEST(GpuRun, Curves) {
    Options options;
    options.oneHitGroup = true;
    options.shapes = bvh::gpu::kMeetsLinear | bvh::gpu::kMeetsCurves;
    const Kernel kernel(raysModule(), options);
    const Points points(60);
    for (const uint32_t basis : {0x2501u, 0x2502u, 0x2503u, 0x2504u}) {
        SCOPED_TRACE(basis);
        bvh::CurveInput in;
        in.basis = basis;
        in.vertices = points.places.data();
        in.radii = points.radii.data();
        in.numVertices = 60;
        in.indices = points.indices.data();
        in.numSegments = 50;
        in.sbt.flags = &points.flags;
        bvh::BuildInputs inputs;
        inputs.curves = {&in, 1};
        expectShapes(kernel, inputs, true);
    }
}

} // namespace
} // namespace sunstone
