// SPDX-License-Identifier: Apache-2.0
// Curves through the API: build inputs and their errors, built-in intersection modules, hits as
// programs see them, any-hit rules, end caps, updates, compaction, relocation.
#include "device/curves.h"
#include "moving_scene.h"
#include "rig.h"
#include "scene.h"

#include <cmath>

namespace tests::api {
namespace {

constexpr OptixPrimitiveType kTypes[] = {
    OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE,
    OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM};

unsigned degree(OptixPrimitiveType type) {
    return type == OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR               ? 1
           : type == OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE ? 2
                                                                  : 3;
}

OptixPipelineCompileOptions curveOptions(bool motion = false) {
    OptixPipelineCompileOptions options = compileOptions(0);
    options.usesMotionBlur = motion;
    options.numAttributeValues = 2;
    options.usesPrimitiveTypeFlags =
        OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR | OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_QUADRATIC_BSPLINE |
        OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE | OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CATMULLROM;
    return options;
}

// One straight strand along x from x0 on, of `count` segments of length 1, all of radius 0.25, and
// the data of its input. Must not move.
struct Strand {
    Strand(OptixPrimitiveType type, unsigned count, float y = 0, float x0 = 0) {
        const unsigned lead = type == OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE ? 0 : 1;
        for (unsigned i = 0; i < count + degree(type); ++i) {
            // A segment of a quadratic spline runs between middles of its polygon.
            float x = x0 + float(i) - (degree(type) == 1 ? 0.0f : lead ? 1.0f : 0.5f);
            points.push_back({x, y, 0});
            widths.push_back(0.25f);
        }
        for (unsigned i = 0; i < count; ++i)
            first.push_back(i);
        upload();
        OptixBuildInputCurveArray& c = input.curveArray;
        input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
        c.curveType = type;
        c.numPrimitives = count;
        c.numVertices = unsigned(points.size());
        c.vertexBuffers = &vertexAddress;
        c.widthBuffers = &widthAddress;
        c.indexBuffer = indices.address();
    }
    Strand(const Strand&) = delete;
    void upload() {
        vertices = Buffer(points);
        radii = Buffer(widths);
        indices = Buffer(first);
        vertexAddress = vertices.address();
        widthAddress = radii.address();
    }

    std::vector<Vec3> points;
    std::vector<float> widths;
    std::vector<uint32_t> first;
    Buffer vertices, radii, indices;
    CUdeviceptr vertexAddress = 0, widthAddress = 0;
    OptixBuildInput input{};
};

class CurveTest : public ApiTest {
protected:
    void prepare(OptixPrimitiveType type, bool anyHit,
                 unsigned endcaps = OPTIX_CURVE_ENDCAP_DEFAULT, bool motion = false) {
        OptixPipelineCompileOptions pipeline = curveOptions(motion || raysHaveTimes_);
        pipeline.exceptionFlags = exceptionFlags_;
        rig_ = std::make_unique<Rig>(context_, log_, compiledPtx("curves", "clang"), pipeline);
        OptixBuiltinISOptions builtin{};
        builtin.builtinISModuleType = type;
        builtin.usesMotionBlur = motion;
        builtin.curveEndcapFlags = endcaps;
        builtin.buildFlags = buildFlags_;
        OptixModuleCompileOptions module{};
        require(optixBuiltinISModuleGet(context_, &module, &pipeline, &builtin, &builtin_),
                "optixBuiltinISModuleGet", log_);
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        desc.hitgroup.moduleCH = rig_->module();
        desc.hitgroup.entryFunctionNameCH = "__closesthit__curves";
        desc.hitgroup.moduleIS = builtin_;
        if (anyHit) {
            desc.hitgroup.moduleAH = rig_->module();
            desc.hitgroup.entryFunctionNameAH = "__anyhit__curves";
        }
        rig_->raygenRecord(rig_->raygen("__raygen__curves"));
        rig_->missRecord(rig_->miss("__miss__curves"));
        const size_t group = rig_->add(desc);
        for (int i = 0; i < 4; ++i)
            rig_->hitRecord(group);
        rig_->link();
    }
    void TearDown() override {
        rig_.reset();
        if (builtin_)
            EXPECT_EQ(OPTIX_SUCCESS, optixModuleDestroy(builtin_));
        builtin_ = nullptr;
        ApiTest::TearDown();
    }

    std::vector<CurveResult> trace(const std::vector<CurveRay>& rays, OptixTraversableHandle handle,
                                   CurveRule rule = kCurveAccept, float time = 0) {
        Buffer in(rays), out(rays.size() * sizeof(CurveResult));
        rig_->run(CurveParams{handle, in.as<CurveRay>(), out.as<CurveResult>(), rule, time},
                  unsigned(rays.size()));
        return {out.as<CurveResult>(), out.as<CurveResult>() + rays.size()};
    }
    static CurveRay down(float x, float y = 0, unsigned flags = 0) {
        return {{x, y, 4}, 0, {0, 0, -1}, 1e16f, flags};
    }
    Accel build(const OptixBuildInput& input, unsigned flags = 0) {
        return buildAccel(context_, log_, {input}, flags);
    }
    void again() {
        TearDown();
        SetUp();
    }

    std::unique_ptr<Rig> rig_;
    OptixModule builtin_ = nullptr;
    unsigned exceptionFlags_ = OPTIX_EXCEPTION_FLAG_NONE;
    bool raysHaveTimes_ = false; // of the pipeline; the option of the module may differ
    unsigned buildFlags_ = 0; // of the built-in module
};

// Each segment exists eight times; traversal may meet the copies in any order.
TEST_F(CurveTest, OfEqualHitsTheLowestPrimitiveCounts) {
    constexpr unsigned kSegments = 8, kCopies = 8;
    for (OptixPrimitiveType type : kTypes) {
        SCOPED_TRACE(unsigned(type));
        prepare(type, false);
        Strand strand(type, kSegments);
        strand.first.clear();
        std::vector<unsigned> lowest(kSegments, ~0u);
        for (unsigned i = 0; i < kSegments * kCopies; ++i) {
            strand.first.push_back((i * 5 + i / kSegments * 3) % kSegments);
            lowest[strand.first[i]] = std::min(lowest[strand.first[i]], i);
        }
        strand.upload();
        strand.input.curveArray.numPrimitives = unsigned(strand.first.size());
        strand.input.curveArray.indexBuffer = strand.indices.address();
        Accel accel = build(strand.input);
        std::vector<CurveRay> rays;
        for (unsigned i = 0; i < kSegments; ++i)
            rays.push_back(down(float(i) + 0.4f));
        const std::vector<CurveResult> results = trace(rays, accel.handle);
        for (unsigned i = 0; i < kSegments; ++i) {
            ASSERT_EQ(1u, results[i].closestHits) << i;
            EXPECT_EQ(lowest[i], results[i].primitive) << i;
        }
        again();
    }
}

TEST_F(CurveTest, HitsOfAllBases) {
    for (OptixPrimitiveType type : kTypes) {
        prepare(type, true);
        Strand strand(type, 4);
        strand.input.curveArray.primitiveIndexOffset = 100;
        const Accel accel = build(strand.input, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
        std::vector<CurveRay> rays;
        for (int i = 0; i < 16; ++i)
            rays.push_back(down(0.125f + 0.25f * float(i), 0.1f));
        rays.push_back(down(0.5f, 0.26f)); // beside it
        const auto results = trace(rays, accel.handle);
        for (int i = 0; i < 16; ++i) {
            const CurveResult& r = results[size_t(i)];
            ASSERT_EQ(1u, r.closestHits) << type << " " << i;
            EXPECT_EQ(0u, r.misses);
            EXPECT_GE(r.anyHits, 1u);
            EXPECT_NEAR(4 - std::sqrt(0.25f * 0.25f - 0.01f), r.t, 1e-5f);
            EXPECT_NEAR(0.125f + 0.25f * float(i % 4), r.u, 1e-4f) << type << " " << i;
            EXPECT_EQ(100u + unsigned(i) / 4, r.primitive);
            EXPECT_EQ(unsigned(type), r.primitiveType);
            EXPECT_GE(r.hitKind, 128u);
            EXPECT_EQ(1u, r.isFront);
            EXPECT_EQ(0u, r.isBack);
            EXPECT_EQ(0u, r.isTriangle);
            EXPECT_EQ(r.anyHitT, r.t);
            EXPECT_EQ(r.anyHitU, r.u);
            for (unsigned k = 0; k <= degree(type); ++k) {
                EXPECT_EQ(strand.points[size_t(i) / 4 + k].x, r.points[4 * k]);
                EXPECT_EQ(0.25f, r.points[4 * k + 3]);
            }
        }
        EXPECT_EQ(1u, results[16].misses);
        again();
    }
}

TEST_F(CurveTest, WithoutRandomAccessGettersGiveNaN) {
    const OptixPrimitiveType type = OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE;
    prepare(type, false);
    Strand strand(type, 1);
    const Accel accel = build(strand.input);
    const auto results = trace({down(0.5f)}, accel.handle);
    ASSERT_EQ(1u, results[0].closestHits);
    for (int k = 0; k < 16; ++k)
        EXPECT_TRUE(std::isnan(results[0].points[k]));
}

TEST_F(CurveTest, EndCaps) {
    for (OptixPrimitiveType type : kTypes) {
        const bool linear = type == OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR;
        for (unsigned caps : {0u, 1u}) {
            if (linear && caps)
                continue;
            prepare(type, false, caps);
            Strand strand(type, 3);
            strand.input.curveArray.endcapFlags = caps;
            const Accel accel = build(strand.input);
            // Along the axis from both sides, off the axis, and from within.
            const auto results = trace({{{-2, 0.1f, 0}, 0, {1, 0, 0}, 1e16f, 0},
                                        {{5, 0.1f, 0}, 0, {-1, 0, 0}, 1e16f, 0},
                                        {{1.5f, 0.1f, 0}, 0, {1, 0.02f, 0}, 1e16f, 0},
                                        {{1.5f, 0, 0}, 0, {0, 1, 0}, 1e16f, 0}},
                                       accel.handle);
            const float bulge = std::sqrt(0.0625f - 0.01f);
            for (int i = 0; i < 2; ++i) {
                EXPECT_EQ(linear || caps ? 1u : 0u, results[size_t(i)].closestHits) << type;
                if (!results[size_t(i)].closestHits)
                    continue;
                EXPECT_NEAR(linear ? 2 - bulge : 2, results[size_t(i)].t, 1e-5f);
                EXPECT_EQ(float(i), results[size_t(i)].u); // exactly an end
                EXPECT_EQ(i ? 2u : 0u, results[size_t(i)].primitive);
            }
            EXPECT_EQ(1u, results[3].misses) << type << ": curves are not seen from within";
            if (!linear)
                EXPECT_EQ(1u, results[2].misses) << type;
            again();
        }
    }
}

TEST_F(CurveTest, StrandsEndWhereIndicesDoNotGoOn) {
    const OptixPrimitiveType type = OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE;
    prepare(type, false, 1);
    Strand strand(type, 4);
    // The second of four segments is missing, which leaves two strands, [0, 1] and [2, 4].
    strand.first = {0, 2, 3};
    strand.upload();
    strand.input.curveArray.numPrimitives = 3;
    strand.input.curveArray.indexBuffer = strand.indices.address();
    strand.input.curveArray.endcapFlags = 1;
    const Accel accel = build(strand.input);
    const auto results = trace({{{1.5f, 0, 0}, 0, {1, 0, 0}, 1e16f, 0},
                                {{1.5f, 0, 0}, 0, {-1, 0, 0}, 1e16f, 0},
                                {{2.5f, 0, 0}, 0, {1, 0.01f, 0}, 1.0f, 0}},
                               accel.handle);
    EXPECT_NEAR(0.5f, results[0].t, 1e-5f);
    EXPECT_EQ(0.0f, results[0].u);
    EXPECT_EQ(1u, results[0].primitive);
    EXPECT_NEAR(0.5f, results[1].t, 1e-5f);
    EXPECT_EQ(1.0f, results[1].u);
    EXPECT_EQ(0u, results[1].primitive);
    EXPECT_EQ(1u, results[2].misses); // no cap between the two
}

TEST_F(CurveTest, AnyHitRules) {
    for (OptixPrimitiveType type : kTypes) {
        prepare(type, true);
        // Three strands in a row for rays along y.
        Strand a(type, 2, 0), b(type, 2, 1), c(type, 2, 2);
        const Accel accel = buildAccel(context_, log_, {a.input, b.input, c.input});
        const CurveRay ray{{0.3f, -3, 0.05f}, 0, {0, 1, 0}, 1e16f, 0};
        const auto first = trace({ray}, accel.handle);
        EXPECT_EQ(1u, first[0].closestHits);
        EXPECT_EQ(0u, first[0].sbtGasIndex);
        const float t = first[0].t;
        const auto ignored = trace({ray}, accel.handle, kCurveIgnore);
        EXPECT_EQ(1u, ignored[0].misses);
        EXPECT_GE(ignored[0].anyHits, 3u);
        const auto ended = trace({ray}, accel.handle, kCurveTerminate);
        EXPECT_EQ(1u, ended[0].closestHits);
        EXPECT_EQ(1u, ended[0].anyHits);
        CurveRay disabled = ray, enough = ray, silent = ray, dropped = ray;
        disabled.flags = OPTIX_RAY_FLAG_DISABLE_ANYHIT;
        enough.flags = OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_ANYHIT;
        silent.flags = OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT;
        dropped.flags = OPTIX_RAY_FLAG_CULL_ENFORCED_ANYHIT;
        const auto flagged = trace({disabled, enough, silent, dropped}, accel.handle, kCurveAccept);
        EXPECT_EQ(0u, flagged[0].anyHits);
        EXPECT_EQ(t, flagged[0].t);
        EXPECT_EQ(0u, flagged[1].anyHits);
        EXPECT_EQ(1u, flagged[1].closestHits);
        EXPECT_EQ(0u, flagged[2].closestHits + flagged[2].misses);
        EXPECT_EQ(1u, flagged[3].misses);
        // Face culling applies only to triangles.
        CurveRay culled = disabled;
        culled.flags |= OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES;
        EXPECT_EQ(1u, trace({culled}, accel.handle)[0].closestHits);
        culled.flags = OPTIX_RAY_FLAG_CULL_FRONT_FACING_TRIANGLES;
        EXPECT_EQ(1u, trace({culled}, accel.handle)[0].closestHits);
        again();
    }
}

TEST_F(CurveTest, SingleAnyHitGuarantee) {
    for (OptixPrimitiveType type : kTypes) {
        prepare(type, true);
        Strand strand(type, 1);
        strand.input.curveArray.flag = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        for (unsigned flags : {0u, unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_TRACE)}) {
            const Accel accel = build(strand.input, flags);
            std::vector<CurveRay> rays;
            for (int i = 0; i < 200; ++i) // also across the places where pieces would meet
                rays.push_back({{0.005f * float(i), -2, 0.02f}, 0, {0, 1, 0}, 1e16f, 0});
            for (const CurveResult& r : trace(rays, accel.handle, kCurveIgnore))
                EXPECT_EQ(1u, r.anyHits) << type;
        }
        again();
    }
}

TEST_F(CurveTest, GeometryFlagDisablesAnyHit) {
    const OptixPrimitiveType type = OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR;
    prepare(type, true);
    Strand strand(type, 2);
    strand.input.curveArray.flag = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    const Accel accel = build(strand.input);
    CurveRay enforced = down(0.5f, 0, OPTIX_RAY_FLAG_ENFORCE_ANYHIT);
    CurveRay culled = down(0.5f, 0, OPTIX_RAY_FLAG_CULL_DISABLED_ANYHIT);
    const auto results = trace({down(0.5f), enforced, culled}, accel.handle);
    EXPECT_EQ(0u, results[0].anyHits);
    EXPECT_EQ(1u, results[0].closestHits);
    EXPECT_GE(results[1].anyHits, 1u);
    EXPECT_EQ(1u, results[2].misses);
}

TEST_F(CurveTest, StridesAndInstances) {
    for (OptixPrimitiveType type : kTypes) {
        prepare(type, false);
        Strand strand(type, 3);
        const Accel packed = build(strand.input);
        // The same in wider records.
        std::vector<float> vertices, widths;
        std::vector<uint32_t> indices;
        for (const Vec3& p : strand.points)
            vertices.insert(vertices.end(), {p.x, p.y, p.z, 7, 7});
        for (float w : strand.widths)
            widths.insert(widths.end(), {w, 9});
        for (uint32_t i : strand.first)
            indices.insert(indices.end(), {i, 77, 77});
        const Buffer a(vertices), b(widths), c(indices);
        const CUdeviceptr va = a.address(), vb = b.address();
        OptixBuildInput wide = strand.input;
        wide.curveArray.vertexBuffers = &va;
        wide.curveArray.vertexStrideInBytes = 20;
        wide.curveArray.widthBuffers = &vb;
        wide.curveArray.widthStrideInBytes = 8;
        wide.curveArray.indexBuffer = c.address();
        wide.curveArray.indexStrideInBytes = 12;
        const Accel strided = build(wide);
        InstanceList list({instanceOf(packed.handle, translation(0, 5, 0)),
                           instanceOf(strided.handle, translation(0, 10, 0))});
        const Accel scene = build(list.input);
        const auto results =
            trace({down(1.7f, 0.1f), down(1.7f, 5.1f), down(1.7f, 10.1f)}, scene.handle);
        const auto alone = trace({down(1.7f, 0.1f)}, strided.handle);
        ASSERT_EQ(1u, alone[0].closestHits);
        EXPECT_EQ(1u, results[0].misses);
        for (int i = 1; i < 3; ++i) {
            ASSERT_EQ(1u, results[size_t(i)].closestHits);
            EXPECT_NEAR(alone[0].t, results[size_t(i)].t, 1e-5f);
            EXPECT_NEAR(alone[0].u, results[size_t(i)].u, 1e-4f);
            EXPECT_EQ(1u, results[size_t(i)].primitive);
        }
        again();
    }
}

TEST_F(CurveTest, UpdateCompactRelocate) {
    for (OptixPrimitiveType type : kTypes) {
        prepare(type, false);
        Strand strand(type, 6);
        const unsigned flags = OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_COMPACTION |
                               OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
        const Buffer size(8), bounds(sizeof(OptixAabb));
        const Accel built =
            buildAccel(context_, log_, {strand.input}, flags,
                       {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE},
                        {bounds.address(), OPTIX_PROPERTY_TYPE_AABBS}});
        const OptixAabb& box = *bounds.as<OptixAabb>();
        EXPECT_NEAR(-0.25f, box.minX, 1e-4f);
        EXPECT_NEAR(6.25f, box.maxX, 1e-4f);
        EXPECT_NEAR(0.25f, box.maxZ, 1e-5f);
        Accel compacted;
        compacted.memory = Buffer(*size.as<uint64_t>());
        ASSERT_OK(optixAccelCompact(context_, nullptr, built.handle, compacted.memory.address(),
                                    compacted.memory.size(), &compacted.handle));
        waitForDevice();
        const auto before = trace({down(3.3f, 0.1f)}, compacted.handle);
        ASSERT_EQ(1u, before[0].closestHits);
        // Moved away in y, and thinner.
        for (Vec3& p : strand.points)
            p.y += 2;
        for (float& w : strand.widths)
            w = 0.125f;
        strand.upload();
        strand.input.curveArray.indexBuffer = strand.indices.address();
        OptixAccelBuildOptions options = buildOptions(flags);
        OptixAccelBufferSizes sizes{};
        ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &strand.input, 1, &sizes));
        ASSERT_GT(sizes.tempUpdateSizeInBytes, 0u);
        const Buffer temp(sizes.tempUpdateSizeInBytes);
        options.operation = OPTIX_BUILD_OPERATION_UPDATE;
        OptixTraversableHandle handle = 0;
        ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &strand.input, 1, temp.address(),
                                  temp.size(), compacted.memory.address(), compacted.memory.size(),
                                  &handle, nullptr, 0));
        EXPECT_EQ(compacted.handle, handle);
        waitForDevice();
        const auto after = trace({down(3.3f, 0.1f), down(3.3f, 2.1f), down(3.3f, 2.2f)}, handle);
        EXPECT_EQ(1u, after[0].misses);
        ASSERT_EQ(1u, after[1].closestHits);
        EXPECT_NEAR(4 - std::sqrt(0.125f * 0.125f - 0.01f), after[1].t, 1e-4f);
        EXPECT_EQ(1u, after[2].misses);
        EXPECT_EQ(0.125f, after[1].points[3]);
        // A copy elsewhere.
        OptixAccelRelocationInfo info{};
        ASSERT_OK(optixAccelGetRelocationInfo(context_, handle, &info));
        const Buffer copy(compacted.memory.size());
        std::memcpy(copy.as<char>(), compacted.memory.as<char>(), copy.size());
        OptixTraversableHandle moved = 0;
        ASSERT_OK(optixAccelRelocate(context_, nullptr, &info, 0, 0, copy.address(), copy.size(),
                                     &moved));
        waitForDevice();
        compacted.memory.fill(0xCD);
        const auto there = trace({down(3.3f, 2.1f)}, moved);
        EXPECT_EQ(after[1].t, there[0].t);
        again();
    }
}

TEST_F(CurveTest, MotionOfPointsAndWidths) {
    for (OptixPrimitiveType type : kTypes) {
        prepare(type, false, OPTIX_CURVE_ENDCAP_DEFAULT, true);
        // From y = 0 to y = 4, and twice as thick.
        Strand first(type, 4), last(type, 4, 4);
        for (float& w : last.widths)
            w = 0.5f;
        last.upload();
        const CUdeviceptr vertices[] = {first.vertexAddress, last.vertexAddress};
        const CUdeviceptr widths[] = {first.widthAddress, last.widthAddress};
        OptixBuildInput input = first.input;
        input.curveArray.vertexBuffers = vertices;
        input.curveArray.widthBuffers = widths;
        const unsigned flags = OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_COMPACTION |
                               OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
        OptixAccelBuildOptions options = buildOptions(flags);
        options.motionOptions = {2, OPTIX_MOTION_FLAG_START_VANISH, 1, 3};
        const Buffer size(8);
        const Accel built = buildAccel(context_, log_, {input}, options,
                                       {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
        const Buffer compacted(*size.as<uint64_t>());
        OptixTraversableHandle handle = 0;
        ASSERT_OK(optixAccelCompact(context_, nullptr, built.handle, compacted.address(),
                                    compacted.size(), &handle));
        waitForDevice();
        const auto expectMotion = [&](OptixTraversableHandle moving, float toY) {
            for (const float time : {1.0f, 1.5f, 2.25f, 3.0f, 9.0f}) {
                const float f = time < 3 ? (time - 1) / 2 : 1;
                const auto r =
                    trace({down(2.25f, toY * f), down(2.25f, 9)}, moving, kCurveAccept, time);
                ASSERT_EQ(1u, r[0].closestHits) << type << " " << time;
                EXPECT_NEAR(4 - 0.25f * (1 + f), r[0].t, 1e-4f) << type << " " << time;
                EXPECT_NEAR(0.25f, r[0].u, 1e-3f);
                EXPECT_EQ(2u, r[0].primitive);
                EXPECT_NEAR(toY * f, r[0].points[1], 1e-6f);
                EXPECT_NEAR(0.25f * (1 + f), r[0].points[3], 1e-6f);
                EXPECT_EQ(1u, r[1].misses);
            }
            EXPECT_EQ(1u, trace({down(2.25f)}, moving, kCurveAccept, 0.5f)[0].misses);
        };
        expectMotion(handle, 4);
        // Elsewhere in memory.
        OptixAccelRelocationInfo info{};
        ASSERT_OK(optixAccelGetRelocationInfo(context_, handle, &info));
        const Buffer copy(compacted.size());
        std::memcpy(copy.as<char>(), compacted.as<char>(), copy.size());
        OptixTraversableHandle there = 0;
        ASSERT_OK(optixAccelRelocate(context_, nullptr, &info, 0, 0, copy.address(), copy.size(),
                                     &there));
        waitForDevice();
        expectMotion(there, 4);
        // Updated, to another second key.
        Strand other(type, 4, -2);
        for (float& w : other.widths)
            w = 0.5f;
        other.upload();
        const CUdeviceptr newVertices[] = {first.vertexAddress, other.vertexAddress};
        const CUdeviceptr newWidths[] = {first.widthAddress, other.widthAddress};
        input.curveArray.vertexBuffers = newVertices;
        input.curveArray.widthBuffers = newWidths;
        OptixAccelBufferSizes sizes{};
        ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
        const Buffer temp(sizes.tempUpdateSizeInBytes);
        options.operation = OPTIX_BUILD_OPERATION_UPDATE;
        ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(),
                                  temp.size(), copy.address(), copy.size(), &there, nullptr, 0));
        waitForDevice();
        expectMotion(there, -2);
        again();
    }
}

TEST_F(CurveTest, InactiveSegmentsAndEmptyInputs) {
    const OptixPrimitiveType type = OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE;
    prepare(type, false);
    Strand strand(type, 4);
    strand.points[0].x = NAN;            // the first segment
    strand.first = {0, 1, 2, 0xFFFFFFFE}; // and the last
    strand.upload();
    strand.input.curveArray.indexBuffer = strand.indices.address();
    for (unsigned flags : {0u, 1u, 4u, 8u}) {
        const Accel accel = build(strand.input, flags);
        const auto results = trace({down(0.5f), down(1.5f), down(2.5f), down(3.5f)}, accel.handle);
        EXPECT_EQ(1u, results[0].misses);
        EXPECT_EQ(1u, results[1].closestHits);
        EXPECT_EQ(1u, results[2].closestHits);
        EXPECT_EQ(1u, results[3].misses);
    }
    OptixBuildInput none = strand.input;
    none.curveArray.numPrimitives = 0;
    const Accel empty = build(none);
    EXPECT_EQ(1u, trace({down(1.5f)}, empty.handle)[0].misses);
}

TEST_F(CurveTest, BuildInputErrors) {
    Strand strand(OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, 4);
    OptixAccelBuildOptions options = buildOptions();
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &strand.input, 1, &sizes));
    const Buffer temp(sizes.tempSizeInBytes), output(sizes.outputSizeInBytes);
    const auto rejected = [&](const char* word, auto&& change) {
        OptixBuildInput input = strand.input;
        change(input.curveArray);
        OptixTraversableHandle handle = 0;
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", word,
                        optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(),
                                        temp.size(), output.address(), output.size(), &handle,
                                        nullptr, 0));
    };
    using Array = OptixBuildInputCurveArray;
    rejected("curveType", [](Array& c) { c.curveType = OPTIX_PRIMITIVE_TYPE_CUSTOM; });
    rejected("curveType", [](Array& c) { c.curveType = OPTIX_PRIMITIVE_TYPE_TRIANGLE; });
    rejected("curveType", [](Array& c) { c.curveType = OptixPrimitiveType(0x2505); });
    rejected("endcapFlags", [](Array& c) { c.endcapFlags = 2; });
    rejected("vertexStrideInBytes", [](Array& c) { c.vertexStrideInBytes = 8; });
    rejected("vertexStrideInBytes", [](Array& c) { c.vertexStrideInBytes = 14; });
    rejected("widthStrideInBytes", [](Array& c) { c.widthStrideInBytes = 2; });
    rejected("indexStrideInBytes", [](Array& c) { c.indexStrideInBytes = 6; });
    rejected("flag", [](Array& c) { c.flag = 64; });
    rejected("vertexBuffers", [](Array& c) { c.vertexBuffers = nullptr; });
    rejected("widthBuffers", [](Array& c) { c.widthBuffers = nullptr; });
    rejected("indexBuffer", [](Array& c) { c.indexBuffer = 0; });
    rejected("indexBuffer", [](Array& c) { c.indexBuffer += 2; });
    rejected("primitiveIndexOffset", [](Array& c) { c.primitiveIndexOffset = 0xFFFFFFFEu; });
    rejected("device memory", [](Array& c) { c.numVertices = 0x70000000; });
    const CUdeviceptr odd = strand.vertexAddress + 2;
    rejected("vertexBuffers", [&](Array& c) { c.vertexBuffers = &odd; });
    // A motion key without a buffer.
    options.motionOptions = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};
    const CUdeviceptr missing[] = {strand.vertexAddress, 0};
    const CUdeviceptr present[] = {strand.vertexAddress, strand.vertexAddress};
    rejected("vertexBuffers[1]", [&](Array& c) { c.vertexBuffers = missing; });
    rejected("widthBuffers[1]", [&](Array& c) {
        c.vertexBuffers = present;
        c.widthBuffers = missing;
    });
    options.motionOptions = {};
    // Two types in one structure.
    Strand other(OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, 4);
    const OptixBuildInput both[] = {strand.input, other.input};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelComputeMemoryUsage", "one type of curves",
                    optixAccelComputeMemoryUsage(context_, &options, both, 2, &sizes));
}

TEST_F(CurveTest, MemoryUsageIsMonotone) {
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
    for (OptixPrimitiveType type : kTypes)
        for (unsigned flags : {0u, 1u, 2u, 4u, 8u, 16u}) {
            OptixAccelBufferSizes last{};
            for (unsigned count : {0u, 1u, 2u, 3u, 9u, 100u, 1000u, 65536u, 1000000u}) {
                input.curveArray.curveType = type;
                input.curveArray.numPrimitives = count;
                input.curveArray.numVertices = count + 3;
                OptixAccelBuildOptions options = buildOptions(flags);
                OptixAccelBufferSizes sizes{};
                ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
                EXPECT_GE(sizes.outputSizeInBytes, last.outputSizeInBytes);
                EXPECT_GE(sizes.tempSizeInBytes, last.tempSizeInBytes);
                last = sizes;
            }
        }
}

TEST_F(CurveTest, BuiltinModuleErrors) {
    OptixModuleCompileOptions module{};
    OptixPipelineCompileOptions pipeline = curveOptions();
    OptixBuiltinISOptions good{};
    good.builtinISModuleType = OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM;
    OptixModule out = nullptr;
    const auto rejected = [&](const char* word, auto&& change) {
        OptixBuiltinISOptions options = good;
        change(options);
        out = reinterpret_cast<OptixModule>(uintptr_t(1));
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixBuiltinISModuleGet", word,
                        optixBuiltinISModuleGet(context_, &module, &pipeline, &options, &out));
        EXPECT_EQ(nullptr, out);
    };
    using Options = OptixBuiltinISOptions;
    rejected("CUSTOM", [](Options& o) { o.builtinISModuleType = OPTIX_PRIMITIVE_TYPE_CUSTOM; });
    rejected("builtinISModuleType", [](Options& o) { o.builtinISModuleType = OptixPrimitiveType(1); });
    rejected("usesPrimitiveTypeFlags",
             [](Options& o) { o.builtinISModuleType = OPTIX_PRIMITIVE_TYPE_TRIANGLE; });
    rejected("buildFlags", [](Options& o) { o.buildFlags = 0x10000; });
    rejected("curveEndcapFlags", [](Options& o) { o.curveEndcapFlags = 2; });
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixBuiltinISModuleGet", "builtinISOptions",
                    optixBuiltinISModuleGet(context_, &module, &pipeline, nullptr, &out));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixBuiltinISModuleGet", "moduleCompileOptions",
                    optixBuiltinISModuleGet(context_, nullptr, &pipeline, &good, &out));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixBuiltinISModuleGet", "pipelineCompileOptions",
                    optixBuiltinISModuleGet(context_, &module, nullptr, &good, &out));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixBuiltinISModuleGet", "builtinModule",
                    optixBuiltinISModuleGet(context_, &module, &pipeline, &good, nullptr));
    for (void* garbage : garbageHandles())
        EXPECT_NE(OPTIX_SUCCESS,
                  optixBuiltinISModuleGet(static_cast<OptixDeviceContext>(garbage), &module,
                                          &pipeline, &good, &out));
    // All types there are, triangles too where the pipeline has them.
    pipeline.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) | 31u;
    for (unsigned type : {0x2501u, 0x2502u, 0x2503u, 0x2504u, 0x2531u}) {
        good.builtinISModuleType = OptixPrimitiveType(type);
        ASSERT_OK(optixBuiltinISModuleGet(context_, &module, &pipeline, &good, &out));
        EXPECT_OK(optixModuleDestroy(out));
    }
}

TEST_F(CurveTest, BuiltinIntersectionOfAnotherBasisIsAnException) {
    const std::string number = std::to_string(int(OPTIX_EXCEPTION_CODE_BUILTIN_IS_MISMATCH));
    exceptionFlags_ = OPTIX_EXCEPTION_FLAG_DEBUG;
    prepare(OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, false);
    Strand linear(OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, 4);
    Strand cubic(OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, 4);
    const Accel right = build(linear.input), wrong = build(cubic.input);
    log_.clear();
    EXPECT_EQ(1u, trace({down(0.5f)}, right.handle)[0].closestHits);
    EXPECT_FALSE(log_.all().find("built-in intersection") != std::string::npos);
    trace({down(0.5f)}, wrong.handle);
    EXPECT_NE(std::string::npos,
              log_.all().find("built-in intersection does not fit the structure"))
        << log_.all();
    EXPECT_NE(std::string::npos, log_.all().find(number)) << log_.all();
}

// The other OptixBuiltinISOptions: options of a module and of a structure.
struct CurveOptions {
    unsigned flags, caps;
    bool motion;
    bool operator==(const CurveOptions&) const = default;
};
struct CurveMatch {
    CurveOptions module, structure;
    bool fits;
};

class CurveMatches : public CurveTest {
protected:
    // Those with the same module are adjacent.
    void check(const std::vector<CurveMatch>& matches) {
        exceptionFlags_ = OPTIX_EXCEPTION_FLAG_DEBUG;
        constexpr OptixPrimitiveType kCubic = OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE;
        const CurveOptions* module = nullptr;
        for (const CurveMatch& match : matches) {
            SCOPED_TRACE(&match - matches.data());
            if (!module || *module != match.module) {
                if (module)
                    again();
                module = &match.module;
                buildFlags_ = module->flags;
                prepare(kCubic, false, module->caps, module->motion);
            }
            Strand strand(kCubic, 4);
            strand.input.curveArray.endcapFlags = match.structure.caps;
            const CUdeviceptr vertices[2] = {strand.vertexAddress, strand.vertexAddress};
            const CUdeviceptr widths[2] = {strand.widthAddress, strand.widthAddress};
            strand.input.curveArray.vertexBuffers = vertices;
            strand.input.curveArray.widthBuffers = widths;
            Motion motion;
            motion.keys = match.structure.motion ? 2 : 1;
            const Accel accel =
                buildMoving(context_, log_, {strand.input}, motion, match.structure.flags);
            log_.clear();
            const CurveResult result = trace({down(0.5f)}, accel.handle)[0];
            EXPECT_EQ(match.fits ? 1u : 0u, result.closestHits);
            EXPECT_EQ(match.fits, log_.all().find("does not fit the structure") == std::string::npos)
                << log_.all();
        }
    }
};

// Build preferences, if stated, must match; a module for moving curves also serves curves without
// motion.
TEST_F(CurveMatches, OtherOptionsAreAnException) {
    constexpr unsigned kTrace = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
    constexpr unsigned kBuild = OPTIX_BUILD_FLAG_PREFER_FAST_BUILD;
    constexpr unsigned kOther = OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
    check({
        {{0, 0, false}, {0, 0, false}, true},
        {{0, 0, false}, {0, 1, false}, false},
        {{0, 0, false}, {kTrace, 0, false}, true},
        {{0, 1, false}, {0, 0, false}, false},
        {{0, 1, false}, {0, 1, false}, true},
        {{kTrace, 0, false}, {kTrace | kOther, 0, false}, true},
        {{kTrace, 0, false}, {kBuild, 0, false}, false},
        {{kTrace, 0, false}, {0, 0, false}, false},
        {{kOther, 0, false}, {kBuild, 0, false}, true},
        {{0, 0, true}, {0, 0, false}, true},
        {{0, 0, true}, {0, 0, true}, true},
    });
}

// Of the module: the pipeline's rays may meet what moves.
TEST_F(CurveMatches, MotionOfOthersIsAnException) {
    raysHaveTimes_ = true;
    check({{{0, 0, false}, {0, 0, true}, false}});
}

TEST_F(CurveTest, BuiltinModulesInGroups) {
    prepare(OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, false);
    OptixProgramGroup group = nullptr;
    OptixProgramGroupOptions options{};
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
    const auto rejected = [&](const char* word) {
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixProgramGroupCreate", word,
                        optixProgramGroupCreate(context_, &desc, 1, &options, nullptr, nullptr,
                                                &group));
    };
    desc.hitgroup.moduleIS = builtin_;
    desc.hitgroup.entryFunctionNameIS = "__intersection__named";
    rejected("null entry function name");
    desc.hitgroup = {};
    desc.hitgroup.moduleCH = builtin_;
    desc.hitgroup.entryFunctionNameCH = "__closesthit__curves";
    rejected("optixBuiltinISModuleGet");
    desc.hitgroup = {};
    desc.hitgroup.moduleIS = rig_->module(); // not a built-in one
    rejected("intersection");
    // Other pipeline options than the module was made with.
    desc.hitgroup.moduleIS = builtin_;
    ASSERT_OK(optixProgramGroupCreate(context_, &desc, 1, &options, nullptr, nullptr, &group));
    OptixPipelineCompileOptions other = curveOptions();
    other.usesPrimitiveTypeFlags = OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR;
    OptixPipelineLinkOptions link{1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
    OptixPipeline pipeline = nullptr;
    EXPECT_REJECTED(OPTIX_ERROR_PIPELINE_LINK_ERROR, "optixPipelineCreate", "compile options",
                    optixPipelineCreate(context_, &other, &link, &group, 1, nullptr, nullptr,
                                        &pipeline));
    EXPECT_OK(optixProgramGroupDestroy(group));
}

} // namespace
} // namespace tests::api
