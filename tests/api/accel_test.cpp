// SPDX-License-Identifier: Apache-2.0
// Contents of acceleration structures, tested by rays: vertex and index formats, strides,
// transforms, empty and faulty primitives, emitted properties, compaction, memory sizes.
#include "device/probe.h"
#include "rig.h"
#include "scene.h"

#include <cmath>
#include <limits>
#include <numeric>

namespace tests::api {
namespace {

class AccelTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        rig_ = std::make_unique<Rig>(context_, log_, compiledPtx("probe", "clang"),
                                     compileOptions(4));
        rig_->raygenRecord(rig_->raygen("__raygen__probe"));
        rig_->missRecord(rig_->miss("__miss__probe"), ProbeData{});
        size_t group = rig_->hit("__closesthit__probe", nullptr, "__intersection__probe");
        spheres_ = Buffer(std::vector<float>(4 * 64, 0));
        for (unsigned i = 0; i < 8; ++i)
            rig_->hitRecord(group, ProbeData{i, 0, spheres_.as<float>(), 0, 0});
        rig_->link();
    }
    void TearDown() override {
        rig_.reset();
        ApiTest::TearDown();
    }

    std::vector<ProbeResult> trace(const std::vector<Ray>& rays, OptixTraversableHandle handle) {
        std::vector<ProbeRay> list;
        for (const Ray& ray : rays)
            list.push_back({{ray.origin.x, ray.origin.y, ray.origin.z}, ray.tmin,
                            {ray.direction.x, ray.direction.y, ray.direction.z}, ray.tmax, 0,
                            ray.mask, ray.flags, 0, 1, 0, handle});
        Buffer in(list), out(list.size() * sizeof(ProbeResult));
        rig_->run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, unsigned(list.size()));
        return {out.as<ProbeResult>(), out.as<ProbeResult>() + list.size()};
    }

    // Rays from a grid at z = -5 along z.
    static std::vector<Ray> grid(float low, float high, unsigned side) {
        std::vector<Ray> rays;
        for (unsigned y = 0; y < side; ++y)
            for (unsigned x = 0; x < side; ++x) {
                Ray ray;
                float step = (high - low) / float(side);
                ray.origin = {low + (float(x) + 0.37f) * step, low + (float(y) + 0.41f) * step, -5};
                ray.direction = {0, 0, 1};
                rays.push_back(ray);
            }
        return rays;
    }

    void expectSameHits(const std::vector<ProbeResult>& a, const std::vector<ProbeResult>& b) {
        ASSERT_EQ(a.size(), b.size());
        for (size_t i = 0; i < a.size(); ++i)
            ASSERT_EQ(0, std::memcmp(&a[i].closestHit, &b[i].closestHit, offsetof(ProbeSeen, gas)))
                << "ray " << i;
    }

    // Rays against the brute force of scene.h.
    size_t compare(const std::vector<ReferenceTriangle>& gas, const std::vector<Ray>& rays,
                   OptixTraversableHandle handle, double tolerance = 1e-4) {
        std::vector<ProbeResult> results = trace(rays, handle);
        size_t hits = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            bool ambiguous = false;
            std::vector<Crossing> all = crossings({bare(gas)}, rays[i], ambiguous);
            if (ambiguous)
                continue;
            EXPECT_EQ(all.empty() ? 0u : 1u, results[i].closestHits) << "ray " << i;
            if (all.empty() || results[i].closestHits == 0)
                continue;
            ++hits;
            EXPECT_EQ(all[0].primitive, results[i].closestHit.primitive) << "ray " << i;
            EXPECT_NEAR(all[0].t, results[i].closestHit.tmax, tolerance) << "ray " << i;
        }
        return hits;
    }

    OptixAccelBufferSizes usage(const std::vector<OptixBuildInput>& inputs, unsigned flags = 0) {
        OptixAccelBuildOptions options = buildOptions(flags);
        OptixAccelBufferSizes sizes{};
        EXPECT_OK(optixAccelComputeMemoryUsage(context_, &options, inputs.data(),
                                               unsigned(inputs.size()), &sizes));
        return sizes;
    }

    std::unique_ptr<Rig> rig_;
    Buffer spheres_;
};

// A bumpy square of side * side * 2 triangles over [-1, 1]^2; heights are multiples of 1 / 64, so
// that halves represent them.
std::unique_ptr<TriangleMesh> terrain(unsigned side, float scale = 1) {
    std::vector<Vec3> vertices;
    std::vector<uint32_t> indices;
    for (unsigned y = 0; y <= side; ++y)
        for (unsigned x = 0; x <= side; ++x) {
            auto at = [&](unsigned i) {
                return scale * std::round((2 * float(i) / float(side) - 1) * 256) / 256;
            };
            vertices.push_back({at(x), at(y), scale * float((x * 7 + y * 13) % 16) / 64});
        }
    for (unsigned y = 0; y < side; ++y)
        for (unsigned x = 0; x < side; ++x) {
            uint32_t a = y * (side + 1) + x, b = a + 1, c = a + side + 1, d = c + 1;
            for (uint32_t i : {a, b, c, c, b, d})
                indices.push_back(i);
        }
    return std::make_unique<TriangleMesh>(vertices, indices);
}

// ---- Memory --------------------------------------------------------------------------------------

TEST_F(AccelTest, MoreNeverNeedsLess) {
    auto mesh = terrain(2);
    CustomBoxes boxes({{0, 0, 0, 1, 1, 1}});
    InstanceList instances({instanceOf(0, identity())});
    for (unsigned flags : {0u, 2u, 4u, 8u, 16u, 1u}) {
        OptixAccelBufferSizes last[3] = {};
        for (unsigned count : {0u, 1u, 2u, 3u, 7u, 8u, 9u, 100u, 101u, 1000u, 65536u, 1000000u,
                               50000000u}) {
            mesh->input.triangleArray.numIndexTriplets = count;
            boxes.input.customPrimitiveArray.numPrimitives = count;
            instances.input.instanceArray.numInstances = count;
            unsigned k = 0;
            for (const OptixBuildInput& input : {mesh->input, boxes.input, instances.input}) {
                OptixAccelBufferSizes sizes = usage({input}, flags);
                EXPECT_GE(sizes.outputSizeInBytes, last[k].outputSizeInBytes) << count;
                EXPECT_GE(sizes.tempSizeInBytes, last[k].tempSizeInBytes) << count;
                EXPECT_GT(sizes.outputSizeInBytes, 0u);
                EXPECT_LT(sizes.outputSizeInBytes, 4096 + size_t(count) * 1024);
                if (!(flags & OPTIX_BUILD_FLAG_ALLOW_UPDATE))
                    EXPECT_EQ(0u, sizes.tempUpdateSizeInBytes);
                last[k++] = sizes;
            }
        }
    }
}

TEST_F(AccelTest, SizesDependOnShapeOnly) {
    auto mesh = terrain(8);
    OptixAccelBufferSizes before = usage({mesh->input});
    OptixBuildInput input = mesh->input;
    CUdeviceptr wild[] = {0x123456789};
    input.triangleArray.vertexBuffers = wild;
    input.triangleArray.indexBuffer = 4;
    OptixAccelBufferSizes after = usage({input});
    EXPECT_EQ(0, std::memcmp(&before, &after, sizeof(before)));
    input.triangleArray.vertexBuffers = nullptr;
    input.triangleArray.indexBuffer = 0;
    after = usage({input});
    EXPECT_EQ(0, std::memcmp(&before, &after, sizeof(before)));
}

// Builds and compactions of equal inputs give equal bytes.
TEST_F(AccelTest, BuildsAreReproducible) {
    auto expectReproducible = [&](const OptixBuildInput& input, unsigned flags, unsigned keys = 1) {
        OptixAccelBuildOptions options = buildOptions(flags | OPTIX_BUILD_FLAG_ALLOW_COMPACTION);
        options.motionOptions = {static_cast<unsigned short>(keys), 0, 0, 1};
        Accel accels[2];
        Buffer copies[2];
        for (int i = 0; i < 2; ++i) {
            Buffer size(8);
            accels[i] = buildAccel(context_, log_, {input}, options,
                                   {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
            copies[i] = Buffer(*size.as<uint64_t>());
            copies[i].fill(i);
            OptixTraversableHandle handle = 0;
            ASSERT_OK(optixAccelCompact(context_, nullptr, accels[i].handle, copies[i].address(),
                                        copies[i].size(), &handle));
            waitForDevice();
        }
        // Both were over bytes of one value.
        ASSERT_EQ(accels[0].memory.size(), accels[1].memory.size());
        EXPECT_EQ(0, std::memcmp(accels[0].memory.as<char>(), accels[1].memory.as<char>(),
                                 accels[0].memory.size()));
        ASSERT_EQ(copies[0].size(), copies[1].size());
        EXPECT_EQ(0, std::memcmp(copies[0].as<char>(), copies[1].as<char>(), copies[0].size()));
    };
    auto mesh = terrain(40);
    for (unsigned flags : {0u, unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_BUILD),
                           unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_TRACE),
                           unsigned(OPTIX_BUILD_FLAG_ALLOW_UPDATE),
                           unsigned(OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS)}) {
        SCOPED_TRACE(flags);
        expectReproducible(mesh->input, flags);
    }
    CUdeviceptr keys[] = {mesh->vertexAddress, mesh->vertexAddress};
    OptixBuildInput moving = mesh->input;
    moving.triangleArray.vertexBuffers = keys;
    expectReproducible(moving, 0, 2);

    std::mt19937 random(3);
    Accel gas = buildAccel(context_, log_, {mesh->input});
    std::vector<OptixInstance> instances;
    std::vector<OptixAabb> boxes;
    std::vector<Vec3> centres;
    for (unsigned i = 0; i < 1000; ++i) {
        Matrix m = randomAffine(random, 30);
        instances.push_back(instanceOf(gas.handle, m, i));
        boxes.push_back({m[3], m[7], m[11], m[3] + 1, m[7] + 2, m[11] + 3});
        centres.push_back({m[3], m[7], m[11]});
    }
    expectReproducible(InstanceList(instances).input, 0);
    expectReproducible(CustomBoxes(boxes).input, 0);
    // Segments between places that follow one another.
    std::vector<uint32_t> first(centres.size() - 1);
    std::iota(first.begin(), first.end(), 0u);
    Buffer points(centres), widths(std::vector<float>(centres.size(), 0.5f)), indices(first);
    CUdeviceptr pointAddress = points.address(), widthAddress = widths.address();
    OptixBuildInput curves{};
    curves.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
    curves.curveArray.curveType = OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR;
    curves.curveArray.numPrimitives = unsigned(first.size());
    curves.curveArray.vertexBuffers = &pointAddress;
    curves.curveArray.numVertices = unsigned(centres.size());
    curves.curveArray.widthBuffers = &widthAddress;
    curves.curveArray.indexBuffer = indices.address();
    expectReproducible(curves, OPTIX_BUILD_FLAG_PREFER_FAST_TRACE);
}

// ---- Triangle formats ----------------------------------------------------------------------------

uint16_t halfOf(float value) { // exact for terrain()
    uint32_t bits;
    std::memcpy(&bits, &value, 4);
    if ((bits & 0x7FFFFFFF) == 0)
        return uint16_t(bits >> 16);
    int exponent = int(bits >> 23 & 255) - 127 + 15;
    return uint16_t((bits >> 16 & 0x8000) | unsigned(exponent) << 10 | (bits >> 13 & 0x3FF));
}

int16_t snormOf(float value) {
    return int16_t(std::lround(value * 32767));
}

TEST_F(AccelTest, VertexFormatsAndStrides) {
    auto mesh = terrain(12);
    std::vector<Ray> rays = grid(-0.99f, 0.99f, 40);
    struct {
        OptixVertexFormat format;
        unsigned components, bytes;
    } const formats[] = {{OPTIX_VERTEX_FORMAT_FLOAT3, 3, 4},    {OPTIX_VERTEX_FORMAT_FLOAT2, 2, 4},
                         {OPTIX_VERTEX_FORMAT_HALF3, 3, 2},     {OPTIX_VERTEX_FORMAT_HALF2, 2, 2},
                         {OPTIX_VERTEX_FORMAT_SNORM16_3, 3, 2}, {OPTIX_VERTEX_FORMAT_SNORM16_2, 2, 2}};
    for (const auto& f : formats)
        for (unsigned extra : {~0u, 0u, f.bytes, 5 * f.bytes}) { // ~0: stride 0, packed
            SCOPED_TRACE(std::to_string(f.format) + " " + std::to_string(extra));
            unsigned size = f.components * f.bytes;
            unsigned stride = size + (extra == ~0u ? 0 : extra);
            std::vector<ReferenceTriangle> reference = referenceOf({mesh.get()});
            // The buffer ends with the last component.
            Buffer vertices(stride * (mesh->points.size() - 1) + size, 16);
            vertices.fill(0x5A);
            for (size_t i = 0; i < mesh->points.size(); ++i)
                for (unsigned k = 0; k < f.components; ++k) {
                    float value = (&mesh->points[i].x)[k];
                    char* to = vertices.as<char>() + i * stride + k * f.bytes;
                    uint16_t half = f.format == OPTIX_VERTEX_FORMAT_HALF3 ||
                                            f.format == OPTIX_VERTEX_FORMAT_HALF2
                                        ? halfOf(value)
                                        : uint16_t(snormOf(value));
                    if (f.bytes == 4)
                        std::memcpy(to, &value, 4);
                    else
                        std::memcpy(to, &half, 2);
                }
            if (f.components == 2)
                for (ReferenceTriangle& triangle : reference)
                    for (Vec3& v : triangle.v)
                        v.z = 0;
            OptixBuildInput input = mesh->input;
            CUdeviceptr address = vertices.address();
            input.triangleArray.vertexBuffers = &address;
            input.triangleArray.vertexFormat = f.format;
            input.triangleArray.vertexStrideInBytes = extra == ~0u ? 0 : stride;
            Accel accel = buildAccel(context_, log_, {input});
            vertices.fill(0); // the structure is self-contained
            EXPECT_GT(compare(reference, rays, accel.handle, 1e-3), 1000u);
        }
}

TEST_F(AccelTest, SnormIsClamped) {
    // -32768 means -1, like -32767.
    auto hitX = [&](int16_t lowest) {
        std::vector<int16_t> vertices{lowest, -32767, 0, lowest, 32767, 0, 32767, 0, 0};
        Buffer memory(vertices);
        CUdeviceptr address = memory.address();
        TriangleMesh mesh({{0, 0, 0}}, {0, 1, 2});
        mesh.input.triangleArray.vertexBuffers = &address;
        mesh.input.triangleArray.numVertices = 3;
        mesh.input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_SNORM16_3;
        Buffer box(24);
        buildAccel(context_, log_, {mesh.input}, 0, {{box.address(), OPTIX_PROPERTY_TYPE_AABBS}});
        return box.as<float>()[0];
    };
    EXPECT_EQ(-1.0f, hitX(-32767));
    EXPECT_EQ(-1.0f, hitX(-32768));
}

TEST_F(AccelTest, IndexFormatsAndStrides) {
    auto mesh = terrain(12);
    std::vector<Ray> rays = grid(-0.99f, 0.99f, 30);
    std::vector<ProbeResult> expected =
        trace(rays, buildAccel(context_, log_, {mesh->input}).handle);
    size_t count = mesh->corners.size() / 3;
    for (unsigned bytes : {2u, 4u})
        for (unsigned extra : {~0u, 0u, bytes, 4 * bytes}) {
            SCOPED_TRACE(std::to_string(bytes) + " " + std::to_string(extra));
            unsigned stride = 3 * bytes + (extra == ~0u ? 0 : extra);
            Buffer indices(stride * (count - 1) + 3 * bytes, 16);
            indices.fill(0x7F);
            for (size_t i = 0; i < count * 3; ++i) {
                char* to = indices.as<char>() + i / 3 * stride + i % 3 * bytes;
                std::memcpy(to, &mesh->corners[i], bytes); // little endian
            }
            OptixBuildInput input = mesh->input;
            input.triangleArray.indexBuffer = indices.address();
            input.triangleArray.indexFormat = bytes == 2 ? OPTIX_INDICES_FORMAT_UNSIGNED_SHORT3
                                                         : OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
            input.triangleArray.indexStrideInBytes = extra == ~0u ? 0 : stride;
            expectSameHits(expected,
                           trace(rays, buildAccel(context_, log_, {input}).handle));
        }
    // The same triangles without indices.
    std::vector<Vec3> soup;
    for (uint32_t corner : mesh->corners)
        soup.push_back(mesh->points[corner]);
    TriangleMesh flat(soup, {});
    flat.input.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_NONE;
    flat.input.triangleArray.indexBuffer = 0;
    expectSameHits(expected, trace(rays, buildAccel(context_, log_, {flat.input}).handle));
}

TEST_F(AccelTest, PreTransform) {
    auto mesh = terrain(10);
    std::mt19937 random(5);
    Matrix m = randomAffine(random, 0.5f);
    Buffer matrix(std::vector<float>(m.begin(), m.end()), 16);
    OptixBuildInput input = mesh->input;
    input.triangleArray.preTransform = matrix.address();
    input.triangleArray.transformFormat = OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12;
    Accel accel = buildAccel(context_, log_, {input});
    matrix.fill(0);
    std::vector<ReferenceTriangle> reference = referenceOf({mesh.get()});
    for (ReferenceTriangle& triangle : reference)
        for (Vec3& v : triangle.v)
            v = transformPoint(m, v);
    EXPECT_GT(compare(reference, grid(-1.5f, 1.5f, 50), accel.handle, 1e-3), 200u);
}

TEST_F(AccelTest, SbtIndexBuffers) {
    auto mesh = terrain(6);
    mesh->flags.assign(5, 0);
    mesh->input.triangleArray.flags = mesh->flags.data();
    mesh->input.triangleArray.numSbtRecords = 5;
    size_t count = mesh->corners.size() / 3;
    std::vector<Ray> rays = grid(-0.99f, 0.99f, 20);
    for (unsigned size : {1u, 2u, 4u})
        for (unsigned stride : {0u, size, 3 * size}) {
            unsigned step = stride ? stride : size;
            Buffer offsets(step * (count - 1) + size, 8);
            offsets.fill(0xFF);
            for (size_t i = 0; i < count; ++i) {
                uint32_t value = uint32_t(i * 7 % 5);
                std::memcpy(offsets.as<char>() + i * step, &value, size);
            }
            OptixBuildInput input = mesh->input;
            input.triangleArray.sbtIndexOffsetBuffer = offsets.address();
            input.triangleArray.sbtIndexOffsetSizeInBytes = size;
            input.triangleArray.sbtIndexOffsetStrideInBytes = stride;
            // The second input's records follow the five of the first.
            TriangleMesh floor({{-9, -9, 7}, {9, -9, 7}, {0, 9, 7}}, {0, 1, 2});
            Accel accel = buildAccel(context_, log_, {input, floor.input});
            size_t onTerrain = 0, onFloor = 0;
            for (const ProbeResult& r : trace(rays, accel.handle)) {
                ASSERT_EQ(1u, r.closestHits);
                bool isFloor = r.closestHit.tmax > 11;
                unsigned expected = isFloor ? 5 : r.closestHit.primitive * 7 % 5;
                EXPECT_EQ(expected, r.closestHit.sbtGasIndex);
                EXPECT_EQ(expected, r.closestHit.sbtValue) << "record picked by it";
                ++(isFloor ? onFloor : onTerrain);
            }
            EXPECT_GT(onTerrain, 300u);
            for (const ProbeResult& r : trace(grid(2, 2.5f, 3), accel.handle))
                onFloor += r.closestHits == 1 && r.closestHit.sbtGasIndex == 5;
            EXPECT_GT(onFloor, 0u);
        }
}

// ---- Primitives that cannot be hit ---------------------------------------------------------------

TEST_F(AccelTest, ZeroPrimitives) {
    Buffer box(24), size(8);
    auto mesh = terrain(1);
    CustomBoxes boxes({{0, 0, 0, 1, 1, 1}});
    InstanceList instances({instanceOf(0, identity())});
    mesh->input.triangleArray.numIndexTriplets = 0;
    boxes.input.customPrimitiveArray.numPrimitives = 0;
    instances.input.instanceArray.numInstances = 0;
    OptixBuildInput noVertices = mesh->input;
    noVertices.triangleArray = {};
    noVertices.triangleArray.flags = mesh->flags.data();
    noVertices.triangleArray.numSbtRecords = 1;
    OptixBuildInput noInstances = instances.input;
    noInstances.instanceArray = {};
    for (const OptixBuildInput& input :
         {mesh->input, noVertices, boxes.input, instances.input, noInstances}) {
        Accel accel = buildAccel(context_, log_, {input}, OPTIX_BUILD_FLAG_ALLOW_COMPACTION,
                                 {{box.address(), OPTIX_PROPERTY_TYPE_AABBS},
                                  {size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
        EXPECT_NE(0u, accel.handle);
        EXPECT_LE(*size.as<uint64_t>(), accel.memory.size());
        for (const ProbeResult& r : trace(grid(-1, 1, 4), accel.handle)) {
            EXPECT_EQ(0u, r.closestHits);
            EXPECT_EQ(1u, r.misses);
        }
    }
    // One empty input among others.
    auto good = terrain(4);
    Accel accel = buildAccel(context_, log_, {mesh->input, good->input, noVertices});
    EXPECT_GT(compare(referenceOf({good.get()}), grid(-1, 1, 20), accel.handle), 100u);
}

TEST_F(AccelTest, FaultyTrianglesAreNeverHit) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    auto good = terrain(6);
    std::vector<Vec3> points = good->points;
    uint32_t base = uint32_t(points.size());
    for (Vec3 v : {Vec3{nan, 0, -1}, Vec3{inf, 0, -1}, Vec3{0, -inf, -1}, Vec3{0, 0, nan},
                   Vec3{-1, -1, -1}, Vec3{1, -1, -1}, Vec3{0, 0, -1}, Vec3{3e38f, 3e38f, -3e38f}})
        points.push_back(v);
    std::vector<uint32_t> corners = good->corners;
    std::vector<uint32_t> faulty;
    for (uint32_t bad = base; bad < base + 4; ++bad)
        for (uint32_t k = 0; k < 3; ++k) { // the bad vertex at each place
            uint32_t three[3] = {base + 4, base + 5, base + 6};
            three[k] = bad;
            faulty.insert(faulty.end(), three, three + 3);
        }
    for (uint32_t i : {base + 4, base + 4, base + 4,   // a point
                       base + 4, base + 5, base + 4,   // a line
                       0u, 1u, 100000u,                // an index beyond the vertices
                       0xFFFFFFFFu, 0u, 1u})
        faulty.push_back(i);
    corners.insert(corners.begin(), faulty.begin(), faulty.end());
    TriangleMesh mesh(points, corners);
    Buffer box(24);
    for (unsigned flags : {0u, unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_BUILD),
                           unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_TRACE)}) {
        Accel accel = buildAccel(context_, log_, {mesh.input}, flags,
                                 {{box.address(), OPTIX_PROPERTY_TYPE_AABBS}});
        std::vector<ReferenceTriangle> reference = referenceOf({good.get()});
        for (ReferenceTriangle& triangle : reference)
            triangle.primitive += unsigned(faulty.size() / 3);
        EXPECT_GT(compare(reference, grid(-0.99f, 0.99f, 40), accel.handle), 1000u);
        for (unsigned i = 0; i < 6; ++i)
            EXPECT_TRUE(std::isfinite(box.as<float>()[i])) << i;
    }
    // Only faulty ones.
    TriangleMesh bad(points, faulty);
    Accel accel = buildAccel(context_, log_, {bad.input});
    for (const ProbeResult& r : trace(grid(-1, 1, 10), accel.handle))
        EXPECT_EQ(1u, r.misses);
}

TEST_F(AccelTest, FaultyBoxesAreNeverEntered) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    float* spheres = spheres_.as<float>();
    spheres[4 * 5 + 3] = 0.5f; // primitive 5: a sphere about the origin
    std::vector<OptixAabb> list{{1, 1, 1, -1, -1, -1},     {nan, 0, 0, 1, 1, 1},
                                {0, 0, 0, 1, nan, 1},      {0, 2, 0, 1, 1, 1},
                                {inf, inf, inf, 1, 1, 1},  {-0.5f, -0.5f, -0.5f, 0.5f, 0.5f, 0.5f},
                                {1, 1, 1, -inf, -inf, -inf}};
    CustomBoxes boxes(list);
    Accel accel = buildAccel(context_, log_, {boxes.input});
    size_t hits = 0;
    for (const ProbeResult& r : trace(grid(-1, 1, 20), accel.handle)) {
        for (unsigned i = 0; i < r.intersections && i < kProbeRuns; ++i)
            EXPECT_EQ(5u, r.intersection[i].primitive);
        hits += r.closestHits;
    }
    EXPECT_GT(hits, 30u);
}

TEST_F(AccelTest, FaultyInstancesAreNeverHit) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    auto mesh = terrain(6);
    Accel gas = buildAccel(context_, log_, {mesh->input});
    auto empty = terrain(1);
    empty->input.triangleArray.numIndexTriplets = 0;
    Accel nothing = buildAccel(context_, log_, {empty->input});
    Matrix singular{}, bad = identity(), infinite = identity();
    bad[5] = nan;
    infinite[3] = inf;
    InstanceList list({instanceOf(0, identity(), 1), instanceOf(gas.handle, bad, 2),
                       instanceOf(gas.handle, singular, 3), instanceOf(gas.handle, infinite, 4),
                       instanceOf(nothing.handle, identity(), 5),
                       instanceOf(gas.handle, translation(0, 0, 1), 6)});
    Buffer box(24);
    Accel top = buildAccel(context_, log_, {list.input}, 0,
                           {{box.address(), OPTIX_PROPERTY_TYPE_AABBS}});
    size_t hits = 0;
    for (const ProbeResult& r : trace(grid(-0.99f, 0.99f, 20), top.handle)) {
        if (r.closestHits == 0)
            continue;
        ++hits;
        EXPECT_EQ(6u, r.closestHit.instanceId);
        EXPECT_EQ(5u, r.closestHit.instanceIndex);
    }
    EXPECT_GT(hits, 300u);
    for (unsigned i = 0; i < 6; ++i)
        EXPECT_TRUE(std::isfinite(box.as<float>()[i])) << i;
}

// ---- Instances -----------------------------------------------------------------------------------

TEST_F(AccelTest, InstancePointers) {
    auto mesh = terrain(6);
    Accel gas = buildAccel(context_, log_, {mesh->input});
    std::vector<OptixInstance> instances;
    for (unsigned i = 0; i < 5; ++i)
        instances.push_back(instanceOf(gas.handle, translation(0, 0, float(5 - i)), 100 + i));
    InstanceList list(instances);
    Buffer scattered(5 * 96, 16); // 16-byte aligned records at an odd distance
    std::vector<uint64_t> pointers;
    for (unsigned i = 0; i < 5; ++i) {
        unsigned place = (i * 2) % 5;
        std::memcpy(scattered.as<char>() + place * 96, &instances[i], sizeof(OptixInstance));
        pointers.push_back(scattered.address() + place * 96);
    }
    Buffer memory(pointers);
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS;
    input.instanceArray.instances = memory.address();
    input.instanceArray.numInstances = 5;
    Accel byPointer = buildAccel(context_, log_, {input});
    Accel byArray = buildAccel(context_, log_, {list.input});
    scattered.fill(0);
    memory.fill(0);
    list.memory.fill(0);
    std::vector<Ray> rays = grid(-0.99f, 0.99f, 20);
    std::vector<ProbeResult> a = trace(rays, byPointer.handle), b = trace(rays, byArray.handle);
    expectSameHits(b, a);
    EXPECT_EQ(104u, a[55].closestHit.instanceId);
    EXPECT_EQ(4u, a[55].closestHit.instanceIndex);
}

TEST_F(AccelTest, NullAndMisalignedInstancePointers) {
    // Contents of device memory are not arguments of the call, but invalid contents must not crash.
    auto mesh = terrain(2);
    Accel gas = buildAccel(context_, log_, {mesh->input});
    InstanceList list({instanceOf(gas.handle, identity(), 7)});
    Buffer memory(std::vector<uint64_t>{0, list.memory.address()});
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS;
    input.instanceArray.instances = memory.address();
    input.instanceArray.numInstances = 2;
    Accel top = buildAccel(context_, log_, {input});
    size_t hits = 0;
    for (const ProbeResult& r : trace(grid(-0.99f, 0.99f, 10), top.handle))
        if (r.closestHits) {
            ++hits;
            EXPECT_EQ(7u, r.closestHit.instanceId);
            EXPECT_EQ(1u, r.closestHit.instanceIndex);
        }
    EXPECT_GT(hits, 50u);
}

TEST_F(AccelTest, LimitsOfInstanceFields) {
    auto mesh = terrain(2);
    Accel gas = buildAccel(context_, log_, {mesh->input});
    unsigned id = (1u << 28) - 1;
    InstanceList list({instanceOf(gas.handle, identity(), id, 0, 255, 0)});
    Accel top = buildAccel(context_, log_, {list.input});
    ProbeResult r = trace(grid(-0.5f, 0.5f, 1), top.handle)[0];
    ASSERT_EQ(1u, r.closestHits);
    EXPECT_EQ(id, r.closestHit.instanceId);
    InstanceList far({instanceOf(gas.handle, identity(), 0, (1u << 28) - 1)});
    top = buildAccel(context_, log_, {far.input});
    log_.expect("needs hit group record 268435455");
    r = trace(grid(-0.5f, 0.5f, 1), top.handle)[0];
    EXPECT_EQ(0u, r.closestHits + r.misses) << "a hit whose record does not exist";
}

// ---- Emitted properties --------------------------------------------------------------------------

// The application must keep the limits of instances in device memory; validation mode checks them.
TEST_F(AccelTest, ValidationModeChecksInstances) {
    OptixDeviceContextOptions options{};
    options.logCallbackFunction = LogRecord::callback;
    options.logCallbackData = &log_;
    options.logCallbackLevel = 4;
    options.validationMode = OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
    OptixDeviceContext validating = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &validating));
    auto mesh = terrain(2);
    const Accel gas = buildAccel(context_, log_, {mesh->input});
    const InstanceList inner({instanceOf(gas.handle, identity())});
    const Accel ias = buildAccel(context_, log_, {inner.input});
    const OptixInstance good = instanceOf(gas.handle, identity(), (1u << 28) - 1, (1u << 28) - 1);
    const struct {
        const char* mention;
        OptixInstance instance;
    } cases[] = {
        {nullptr, good},
        {"instanceId = 268435456", instanceOf(gas.handle, identity(), 1u << 28)},
        {"sbtOffset = 268435456", instanceOf(gas.handle, identity(), 0, 1u << 28)},
        {"visibilityMask = 256", instanceOf(gas.handle, identity(), 0, 0, 256)},
        {"flags = 64", instanceOf(gas.handle, identity(), 0, 0, 255, 64)},
        {"ENFORCE_ANYHIT", instanceOf(gas.handle, identity(), 0, 0, 255, 12)},
        {"must be 0", instanceOf(ias.handle, identity(), 0, 1)},
    };
    for (const auto& c : cases) {
        InstanceList list({good, c.instance});
        for (OptixDeviceContext context : {context_, validating}) {
            log_.clear();
            buildAccel(context, log_, {list.input});
            const std::string text = log_.all();
            const bool isTold = c.mention && context == validating;
            EXPECT_EQ(isTold, text.find("instances[1]: ") != std::string::npos) << text;
            if (isTold)
                EXPECT_NE(std::string::npos, text.find(c.mention)) << text;
        }
    }
    ASSERT_OK(optixDeviceContextDestroy(validating));
}

TEST_F(AccelTest, EmittedBounds) {
    TriangleMesh mesh({{-1, 2, 3}, {4, -5, 6}, {0, 0, -7}, {100, 100, 100}}, {0, 1, 2});
    Buffer box(24);
    std::vector<OptixAccelEmitDesc> emit{{box.address(), OPTIX_PROPERTY_TYPE_AABBS}};
    Accel gas = buildAccel(context_, log_, {mesh.input}, 0, emit);
    float expected[6] = {-1, -5, -7, 4, 2, 6};
    EXPECT_EQ(0, std::memcmp(expected, box.as<void>(), 24)) << "vertices not used do not count";
    CustomBoxes boxes({{1, 2, 3, 4, 5, 6}, {-1, 3, 3, 2, 9, 4}});
    buildAccel(context_, log_, {boxes.input}, 0, emit);
    float customs[6] = {-1, 2, 3, 4, 9, 6};
    EXPECT_EQ(0, std::memcmp(customs, box.as<void>(), 24));
    InstanceList list({instanceOf(gas.handle, translation(10, 0, 0)),
                       instanceOf(gas.handle, {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0})});
    buildAccel(context_, log_, {list.input}, 0, emit);
    float both[6] = {-2, -10, -14, 14, 4, 12};
    for (unsigned i = 0; i < 6; ++i)
        EXPECT_NEAR(both[i], box.as<float>()[i], 1e-4f) << i;
}

// ---- Compaction ----------------------------------------------------------------------------------

class Compaction : public AccelTest {
protected:
    void judge(const std::vector<OptixBuildInput>& inputs, const std::vector<Ray>& rays,
               bool mustShrink, unsigned flags = 0) {
        Buffer size(8);
        Accel source =
            buildAccel(context_, log_, inputs, flags | OPTIX_BUILD_FLAG_ALLOW_COMPACTION,
                       {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
        uint64_t compacted = *size.as<uint64_t>();
        ASSERT_GT(compacted, 0u);
        ASSERT_LE(compacted, source.memory.size());
        if (mustShrink)
            EXPECT_LT(compacted, source.memory.size() * 9 / 10)
                << "of " << source.memory.size() << " bytes";
        std::vector<ProbeResult> before = trace(rays, source.handle);
        Buffer target(compacted);
        target.fill(0xCD);
        OptixTraversableHandle handle = 0;
        ASSERT_OK(optixAccelCompact(context_, nullptr, source.handle, target.address(), compacted,
                                    &handle));
        waitForDevice();
        ASSERT_NE(source.handle, handle);
        expectSameHits(before, trace(rays, source.handle)); // the source is unchanged
        source.memory.fill(0xEE);
        source = {};
        expectSameHits(before, trace(rays, handle));
    }
};

TEST_F(Compaction, Triangles) {
    auto mesh = terrain(60);
    judge({mesh->input}, grid(-0.99f, 0.99f, 40), true);
    judge({mesh->input}, grid(-0.99f, 0.99f, 40), true, OPTIX_BUILD_FLAG_PREFER_FAST_BUILD);
    auto small = terrain(1);
    judge({small->input}, grid(-0.99f, 0.99f, 10), false);
    judge({small->input, mesh->input}, grid(-0.99f, 0.99f, 10), true,
          OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
}

TEST_F(Compaction, CustomPrimitives) {
    std::vector<OptixAabb> list;
    float* spheres = spheres_.as<float>();
    for (unsigned i = 0; i < 64; ++i) {
        float x = float(i % 8) / 4 - 0.9f, y = float(i / 8) / 4 - 0.9f;
        float sphere[4] = {x, y, 0, 0.1f};
        std::memcpy(spheres + 4 * i, sphere, 16);
        list.push_back({x - 0.1f, y - 0.1f, -0.1f, x + 0.1f, y + 0.1f, 0.1f});
    }
    CustomBoxes boxes(list);
    judge({boxes.input}, grid(-1, 1, 40), false);
}

TEST_F(Compaction, Instances) {
    auto mesh = terrain(6);
    Accel gas = buildAccel(context_, log_, {mesh->input});
    std::vector<OptixInstance> instances;
    std::mt19937 random(3);
    for (unsigned i = 0; i < 300; ++i)
        instances.push_back(instanceOf(gas.handle, randomAffine(random, 3), i, 0, 255, 0));
    InstanceList list(instances);
    judge({list.input}, grid(-3, 3, 40), false);
}

TEST_F(Compaction, OfACompactedStructure) {
    auto mesh = terrain(20);
    Buffer size(8);
    Accel source = buildAccel(context_, log_, {mesh->input}, OPTIX_BUILD_FLAG_ALLOW_COMPACTION,
                              {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
    std::vector<Ray> rays = grid(-0.99f, 0.99f, 20);
    std::vector<ProbeResult> before = trace(rays, source.handle);
    size_t bytes = *size.as<uint64_t>();
    Buffer first(bytes), second(bytes);
    OptixTraversableHandle a = 0, b = 0;
    ASSERT_OK(optixAccelCompact(context_, nullptr, source.handle, first.address(), bytes, &a));
    ASSERT_OK(optixAccelCompact(context_, nullptr, a, second.address(), bytes, &b));
    waitForDevice();
    source = {};
    first = Buffer();
    expectSameHits(before, trace(rays, b));
}

// Structures contain only offsets, so a copy of the bytes works at its new place, with the old
// handle's tag.
TEST_F(AccelTest, InputsMayGoAfterTheBuild) {
    std::vector<Ray> rays = grid(-0.99f, 0.99f, 30);
    std::vector<ProbeResult> before;
    Accel accel;
    {
        auto mesh = terrain(30);
        accel = buildAccel(context_, log_, {mesh->input});
        before = trace(rays, accel.handle);
        mesh->vertices.fill(0xEE);
        mesh->indices.fill(0xEE);
    }
    expectSameHits(before, trace(rays, accel.handle));
}

TEST_F(AccelTest, ManyBuildsIntoOneBuffer) {
    auto small = terrain(3), large = terrain(30);
    OptixAccelBufferSizes sizes = usage({large->input});
    Buffer temp(sizes.tempSizeInBytes), output(sizes.outputSizeInBytes);
    OptixAccelBuildOptions options = buildOptions();
    std::vector<Ray> rays = grid(-0.99f, 0.99f, 20);
    OptixTraversableHandle first = 0;
    for (int i = 0; i < 6; ++i) {
        const TriangleMesh& mesh = i % 2 ? *small : *large;
        OptixTraversableHandle handle = 0;
        ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &mesh.input, 1, temp.address(),
                                  temp.size(), output.address(), output.size(), &handle, nullptr, 0));
        if (first == 0)
            first = handle;
        EXPECT_EQ(first, handle) << "a handle depends on buffer and kind only";
        EXPECT_GT(compare(referenceOf({&mesh}), rays, handle), 200u);
    }
}

} // namespace
} // namespace tests::api
