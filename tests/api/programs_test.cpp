// SPDX-License-Identifier: Apache-2.0
// Features of each kind of program: payload, attributes, recursion, callables, intersection.
#include "device/callables.h"
#include "device/probe.h"
#include "rig.h"
#include "scene.h"

#include <cmath>

namespace tests::api {
namespace {

class Programs : public DeviceTest {
protected:
    // A large triangle facing -z at height z.
    static std::unique_ptr<TriangleMesh> wall(float z) {
        return std::make_unique<TriangleMesh>(
            std::vector<Vec3>{{-50, -50, z}, {50, -50, z}, {0, 80, z}},
            std::vector<uint32_t>{0, 1, 2});
    }
};

// ---- Payload -------------------------------------------------------------------------------------

struct PayloadParams {
    unsigned long long handle;
    unsigned* words;
    float directionZ;
};

TEST_P(Programs, PayloadOfEverySize) {
    auto mesh = wall(1);
    Accel accel = buildAccel(context_, log_, {mesh->input});
    std::string ptx = program("payload");
    for (unsigned n = 0; n <= 32; ++n) {
        SCOPED_TRACE(n);
        std::string name = "payload_" + std::to_string(n);
        Rig r(context_, log_, ptx, compileOptions(32));
        r.raygenRecord(r.raygen(("__raygen__" + name).c_str()));
        r.missRecord(r.miss(("__miss__" + name).c_str()));
        r.hitRecord(r.hit(("__closesthit__" + name).c_str()));
        r.link();
        for (bool hit : {true, false}) {
            constexpr unsigned kIndices = 5;
            Buffer words(32 * kIndices * 4);
            for (unsigned i = 0; i < 32 * kIndices; ++i)
                words.as<unsigned>()[i] = 0x9E3779B9u * i;
            r.run(PayloadParams{accel.handle, words.as<unsigned>(), hit ? 1.0f : -1.0f}, kIndices);
            for (unsigned i = 0; i < 32 * kIndices; ++i) {
                unsigned word = i % 32, before = 0x9E3779B9u * i;
                unsigned expected = word < n ? before * (hit ? 3 : 5) + word : before;
                ASSERT_EQ(expected, words.as<unsigned>()[i]) << "word " << word;
            }
        }
    }
}

TEST_P(Programs, PayloadOfExactlyTheModulesSize) {
    // With numPayloadValues below 32, programs that use more are refused.
    std::string ptx = program("payload");
    OptixModuleCompileOptions moduleOptions{};
    OptixPipelineCompileOptions options = compileOptions(31);
    OptixModule module = nullptr;
    EXPECT_EQ(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS,
              optixModuleCreateFromPTX(context_, &moduleOptions, &options, ptx.data(), ptx.size(),
                                       nullptr, nullptr, &module));
}

// ---- Attributes ----------------------------------------------------------------------------------

struct AttributeParams {
    unsigned long long handle;
    unsigned* seen;
};

TEST_P(Programs, AttributesOfEveryCount) {
    CustomBoxes boxes({{-1, -1, -1, 1, 1, 1}});
    Accel accel = buildAccel(context_, log_, {boxes.input});
    OptixPipelineCompileOptions options = compileOptions(0);
    options.numAttributeValues = 8;
    auto r = rig("attributes", options);
    r->raygenRecord(r->raygen("__raygen__attributes"));
    r->missRecord(r->miss("__miss__attributes"));
    for (int n = 0; n <= 8; ++n)
        r->hitRecord(r->hit("__closesthit__attributes", "__anyhit__attributes",
                            ("__intersection__attributes_" + std::to_string(n)).c_str()));
    r->link();
    Buffer seen(9 * 32 * 4);
    r->run(AttributeParams{accel.handle, seen.as<unsigned>()}, 9);
    float distance = 4.5f;
    unsigned bits;
    std::memcpy(&bits, &distance, 4);
    for (unsigned n = 0; n <= 8; ++n) {
        SCOPED_TRACE(n);
        const unsigned* s = seen.as<unsigned>() + 32 * n;
        for (unsigned k = 0; k < 8; ++k) {
            unsigned expected = k < n ? 1000 * n + k + 1 : 0;
            EXPECT_EQ(expected, s[k]) << "any-hit, attribute " << k;
            EXPECT_EQ(expected, s[8 + k]) << "closest-hit, attribute " << k;
        }
        EXPECT_EQ(10 + n, s[16]);
        EXPECT_EQ(10 + n, s[17]);
        EXPECT_EQ(bits, s[18]);
        EXPECT_EQ(bits, s[19]);
        EXPECT_EQ(1u, s[30]) << "accepted";
        EXPECT_EQ(0u, s[31]) << "missed";
    }
}

// ---- Recursion -----------------------------------------------------------------------------------

struct RecursionParams {
    unsigned long long handle;
    unsigned long long* results;
    unsigned depth, missTraces;
    const unsigned* table = nullptr;
};

// The result of level `level` (1 is the first trace), folded like the programs do.
std::pair<uint64_t, uint64_t> recursionExpected(unsigned level, unsigned depth, bool hit) {
    if (hit && level < depth) {
        auto [value, count] = recursionExpected(level + 1, depth, true);
        return {value * 3 + level, count + 1};
    }
    if (hit)
        return {level, 1};
    return {7, 1};
}

TEST_P(Programs, RecursionToEveryDepth) {
    auto low = wall(0), high = wall(1);
    Accel accel = buildAccel(context_, log_, {low->input, high->input});
    for (unsigned depth : {1u, 2u, 3u, 7u, 20u, 31u}) {
        SCOPED_TRACE(depth);
        auto r = rig("recursion", compileOptions(3));
        r->raygenRecord(r->raygen("__raygen__recursion"));
        r->missRecord(r->miss("__miss__recursion"));
        r->hitRecord(r->hit("__closesthit__recursion"));
        r->hitRecord(r->hit("__closesthit__recursion"));
        r->link(depth);
        constexpr unsigned kIndices = 600;
        Buffer results(kIndices * 16);
        for (unsigned missTraces : {0u, 1u}) {
            r->run(RecursionParams{accel.handle, results.as<unsigned long long>(), depth,
                                   missTraces},
                   kIndices);
            for (unsigned i = 0; i < kIndices; ++i) {
                // A miss that traces on turns into the chain of hits one level further down.
                std::pair<uint64_t, uint64_t> expected;
                if (i % 2 == 0)
                    expected = recursionExpected(1, depth, true);
                else if (missTraces && 1 < depth) {
                    expected = recursionExpected(2, depth, true);
                    expected = {expected.first * 3 + 1, expected.second + 1};
                } else
                    expected = {7, 1};
                ASSERT_EQ(expected.first, results.as<uint64_t>()[2 * i]) << i;
                ASSERT_EQ(expected.second, results.as<uint64_t>()[2 * i + 1]) << i;
            }
        }
    }
}

// On a GPU the stack must have room for the spills of the driver's compiler, at every depth. With
// stack overflow exceptions programs call each other there; without them, programs are cut at their
// traces.
TEST_P(Programs, RecursionKeepsMuch) {
    constexpr unsigned kDepth = 31, kKept = 96, kIndices = 500;
    auto low = wall(0), high = wall(1);
    Accel accel = buildAccel(context_, log_, {low->input, high->input});
    std::vector<unsigned> table(1024);
    for (unsigned i = 0; i < table.size(); ++i)
        table[i] = (i * 2654435761u) >> 7;
    Buffer deviceTable(table), results(kIndices * 16);
    const auto expected = [&](unsigned index) {
        uint32_t count = 1;
        for (unsigned level = kDepth - 1; level > 0; --level) {
            uint32_t sum = 0;
            for (unsigned i = 0; i < kKept; ++i)
                sum = sum * 3 + table[(i * 37 + level * 5 + index) & 1023];
            count = (count + 1) * 7 + sum;
        }
        return count;
    };
    for (unsigned flags :
         {unsigned(OPTIX_EXCEPTION_FLAG_NONE), unsigned(OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW)}) {
        SCOPED_TRACE(flags);
        OptixPipelineCompileOptions options = compileOptions(3);
        options.exceptionFlags = flags;
        auto r = rig("recursion", options);
        r->raygenRecord(r->raygen("__raygen__recursion"));
        r->missRecord(r->miss("__miss__recursion"));
        r->hitRecord(r->hit("__closesthit__keeper"));
        r->hitRecord(r->hit("__closesthit__keeper"));
        r->link(kDepth);
        r->run(RecursionParams{accel.handle, results.as<unsigned long long>(), kDepth, 0,
                               deviceTable.as<unsigned>()},
               kIndices);
        for (unsigned i = 0; i < kIndices; i += 2) // odd ones miss
            ASSERT_EQ(expected(i), results.as<uint64_t>()[2 * i + 1]) << i;
    }
}

// On a GPU, lanes that an exception ends must release the memory that their warp has claimed for
// deep rays, because later launches would wait for it forever. With motion, warps meet in each
// traversal step, and must not wait for lanes that have ended.
TEST_P(Programs, ExceptionsEndDeepRecursion) {
    constexpr unsigned kDepth = 12, kIndices = 1000, kLaunches = 8;
    auto low = wall(0), high = wall(1);
    Accel accel = buildAccel(context_, log_, {low->input, high->input});
    for (const bool moves : {false, true}) {
        SCOPED_TRACE(moves ? "motion" : "no motion");
        OptixPipelineCompileOptions options = compileOptions(3);
        options.exceptionFlags = OPTIX_EXCEPTION_FLAG_USER;
        options.usesMotionBlur = moves;
        auto r = rig("recursion", options);
        r->raygenRecord(r->raygen("__raygen__recursion"));
        r->missRecord(r->miss("__miss__recursion"));
        r->hitRecord(r->hit("__closesthit__thrower"));
        r->hitRecord(r->hit("__closesthit__thrower"));
        r->link(kDepth);
        for (unsigned launch = 0; launch < kLaunches; ++launch) {
            Buffer results(kIndices * 16);
            r->run(RecursionParams{accel.handle, results.as<unsigned long long>(), kDepth, 0},
                   kIndices);
            for (unsigned i = 0; i < kIndices; i += 2) { // odd ones miss
                const uint64_t count = i % 8 != 0 || i % 512 == 0 ? kDepth : 0;
                ASSERT_EQ(count, results.as<uint64_t>()[2 * i + 1]) << i;
            }
        }
    }
}

TEST_P(Programs, RecursionBeyondTheLimitEnds) {
    // Traces deeper than maxTraceDepth are undefined; in Sunstone the trace returns, no program
    // runs, and the log has an error.
    log_.expect("optixTrace was called below maxTraceDepth = 4");
    auto low = wall(0), high = wall(1);
    Accel accel = buildAccel(context_, log_, {low->input, high->input});
    auto r = rig("recursion", compileOptions(3));
    r->raygenRecord(r->raygen("__raygen__recursion"));
    r->missRecord(r->miss("__miss__recursion"));
    r->hitRecord(r->hit("__closesthit__recursion"));
    r->link(4);
    Buffer results(32);
    r->run(RecursionParams{accel.handle, results.as<unsigned long long>(), 1000000, 1}, 2);
    EXPECT_EQ(4u, results.as<uint64_t>()[1]) << "as many levels as allowed";
}

// ---- Callables -----------------------------------------------------------------------------------

TEST_P(Programs, DirectCallables) {
    CustomBoxes boxes({{-1, -1, 0, 1, 1, 1}});
    Accel accel = buildAccel(context_, log_, {boxes.input});
    auto r = rig("callables", compileOptions(0));
    r->raygenRecord(r->raygen("__raygen__callables"), 901u);
    r->missRecord(r->miss("__miss__callables"), 902u);
    r->hitRecord(r->hit("__closesthit__callables", "__anyhit__callables",
                        "__intersection__callables"),
                 903u);
    unsigned value = 1;
    for (const char* name : {"add", "mixed", "swap", "large", "store", "launch", "wide", "nested",
                             "outer", "subtract"})
        r->callableRecord(r->callables((std::string("__direct_callable__") + name).c_str()),
                          value++);
    r->link();
    constexpr unsigned kIndices = 700;
    Buffer results(kIndices * sizeof(CallableResult));
    r->run(CallableParams{results.as<CallableResult>(), accel.handle}, kIndices);
    for (unsigned i = 0; i < kIndices; ++i) {
        SCOPED_TRACE(i);
        const CallableResult& c = results.as<CallableResult>()[i];
        ASSERT_EQ(i + 0xFFFFFFF0u, c.sum);
        ASSERT_EQ(0.5f - 3 + 2.25f + float(1 << 20) - 7 + 5 + (i & 1 ? 0.5f : 0.25f), c.mixed);
        ASSERT_EQ(100.0f, c.pair.first);
        ASSERT_EQ(float(i) + 1, c.pair.second);
        for (unsigned k = 0; k < 12; ++k)
            ASSERT_EQ((i + 11 - k) * 3, c.large.words[k]) << k;
        ASSERT_EQ(0.625, c.large.sum);
        ASSERT_EQ(i + 5, c.stored) << "its record holds 5";
        ASSERT_EQ(i * 10 + kIndices + 6000, c.launch);
        ASSERT_EQ(1.5 * i, c.wide);
        ASSERT_EQ(42 + i % 5, c.nested);
        ASSERT_EQ(9 * 1000000 + i * 10 + kIndices + 6000, c.outer);
        ASSERT_EQ(i % 2 ? 50 + i : 50 - i, c.varying);
        ASSERT_EQ(901u, c.raygenRecord);
        bool hit = i % 2;
        unsigned expected[4] = {hit ? 0 + i : 0, hit ? 0 : 100 + i, hit ? 200 + i : 0,
                                hit ? 300 + i : 0};
        unsigned records[4] = {hit ? 903u : 0, hit ? 0 : 902u, hit ? 903u : 0, hit ? 903u : 0};
        for (unsigned k = 0; k < 4; ++k) {
            ASSERT_EQ(expected[k], c.from[k]) << k;
            ASSERT_EQ(records[k], c.recordFrom[k]) << k;
        }
    }
}

// ---- Intersection programs -----------------------------------------------------------------------

class Spheres : public Programs {
protected:
    // Spheres of radius 1 at x = 4 i, any-hit rule and far report as given.
    void makeScene(unsigned count, unsigned rule, unsigned both, const char* anyHit) {
        std::vector<OptixAabb> boxes;
        std::vector<float> spheres;
        for (unsigned i = 0; i < count; ++i) {
            float x = 4.0f * float(i);
            boxes.push_back({x - 1, -1, -1, x + 1, 1, 1});
            spheres.insert(spheres.end(), {x, 0, 0, 1});
        }
        boxes_ = std::make_unique<CustomBoxes>(boxes);
        boxes_->input.customPrimitiveArray.primitiveIndexOffset = 40;
        spheres_ = Buffer(spheres);
        gas_ = buildAccel(context_, log_, {boxes_->input});
        rig_ = rig("probe", compileOptions(4));
        rig_->raygenRecord(rig_->raygen("__raygen__probe"));
        rig_->missRecord(rig_->miss("__miss__probe"), ProbeData{});
        rig_->hitRecord(rig_->hit("__closesthit__probe", anyHit, "__intersection__probe"),
                        ProbeData{1234, rule, spheres_.as<float>(), 40, both});
        rig_->link();
    }
    ProbeResult trace(Vec3 origin, Vec3 direction, float tmin, float tmax, unsigned flags = 0,
                      OptixTraversableHandle handle = 0) {
        ProbeRay ray{{origin.x, origin.y, origin.z}, tmin, {direction.x, direction.y, direction.z},
                     tmax, 0, 255, flags, 0, 0, 0, handle ? handle : gas_.handle};
        Buffer in(sizeof(ray));
        std::memcpy(in.as<void>(), &ray, sizeof(ray));
        Buffer out(sizeof(ProbeResult));
        rig_->run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, 1);
        return *out.as<ProbeResult>();
    }
    std::unique_ptr<CustomBoxes> boxes_;
    Buffer spheres_;
    Accel gas_;
    std::unique_ptr<Rig> rig_;
};

TEST_P(Spheres, ReportsShrinkTheInterval) {
    makeScene(3, kProbeAccept, 1, "__anyhit__probe");
    ProbeResult r = trace({-10, 0, 0}, {2, 0, 0}, 0, 100);
    ASSERT_EQ(1u, r.closestHits);
    EXPECT_NEAR(4.5f, r.closestHit.tmax, 1e-5f) << "in units of the direction's length";
    EXPECT_EQ(40u, r.closestHit.primitive);
    EXPECT_EQ(1u, r.closestHit.hitKind);
    EXPECT_EQ(11u, r.closestHit.attributes[0]);
    EXPECT_EQ(12u, r.closestHit.attributes[1]);
    EXPECT_EQ(unsigned(OPTIX_PRIMITIVE_TYPE_CUSTOM), r.closestHit.primitiveType);
    EXPECT_EQ(0u, r.closestHit.isTriangle + r.closestHit.isTriangleFront + r.closestHit.isTriangleBack);
    EXPECT_EQ(1234u, r.closestHit.sbtValue);
    EXPECT_EQ(0u, r.misses);
    for (unsigned i = 0; i < r.intersections && i < kProbeRuns; ++i) {
        if (r.intersection[i].primitive != 40)
            continue;
        EXPECT_NEAR(4.5f, r.intersection[i].tmax, 1e-5f) << "after the report";
        EXPECT_EQ(2u, r.reports / r.intersections);
    }
    EXPECT_EQ(100u + 1000 * r.intersections, r.payload[0]);
}

TEST_P(Spheres, ReportsOutsideTheIntervalAreRefused) {
    makeScene(1, kProbeAccept, 1, "__anyhit__probe");
    ProbeResult inside = trace({0, 0, 0}, {1, 0, 0}, 0, 100);
    ASSERT_EQ(1u, inside.closestHits);
    EXPECT_EQ(2u, inside.reports);
    EXPECT_EQ(1u, inside.accepted) << "the near crossing lies behind tmin";
    EXPECT_EQ(1u, inside.anyHits) << "no any-hit call for a refused report";
    EXPECT_EQ(2u, inside.closestHit.hitKind);
    EXPECT_EQ(21u, inside.closestHit.attributes[0]);
    EXPECT_NEAR(1.0f, inside.closestHit.tmax, 1e-6f);
    ProbeResult shortRay = trace({-3, 0, 0}, {1, 0, 0}, 0, 1.5f);
    EXPECT_EQ(0u, shortRay.closestHits);
    EXPECT_EQ(1u, shortRay.misses);
    EXPECT_EQ(1.5f, shortRay.miss.tmax);
    ProbeResult between = trace({-3, 0, 0}, {1, 0, 0}, 2.5f, 3.5f);
    EXPECT_EQ(0u, between.closestHits);
    EXPECT_EQ(0u, between.accepted);
}

TEST_P(Spheres, IgnoredReportsChangeNothing) {
    makeScene(2, kProbeIgnore, 1, "__anyhit__probe");
    ProbeResult r = trace({-3, 0, 0}, {1, 0, 0}, 0, 100);
    EXPECT_EQ(0u, r.closestHits);
    EXPECT_EQ(1u, r.misses);
    EXPECT_EQ(0u, r.accepted);
    EXPECT_EQ(4u, r.reports);
    EXPECT_EQ(4u, r.anyHits);
    EXPECT_EQ(100.0f, r.miss.tmax);
    EXPECT_EQ(204u, r.payload[1]) << "payload written before ignoring stays";
    for (unsigned i = 0; i < 2; ++i)
        EXPECT_EQ(100.0f, r.intersection[i].tmax);
}

TEST_P(Spheres, TerminateDoesNotReturnToTheIntersectionProgram) {
    makeScene(3, kProbeTerminate, 1, "__anyhit__probe");
    ProbeResult r = trace({-3, 0, 0}, {1, 0, 0}, 0, 100);
    EXPECT_EQ(1u, r.closestHits);
    EXPECT_EQ(0u, r.misses);
    EXPECT_EQ(1u, r.anyHits);
    EXPECT_EQ(1u, r.reports) << "the program ended at its first report";
    EXPECT_EQ(0u, r.accepted);
    EXPECT_EQ(100u, r.payload[0]) << "what stands after the report does not run";
    EXPECT_EQ(r.anyHit[0].primitive, r.closestHit.primitive);
}

TEST_P(Spheres, WithoutAnyHitProgram) {
    makeScene(2, kProbeIgnore, 0, nullptr);
    ProbeResult r = trace({-3, 0, 0}, {1, 0, 0}, 0, 100);
    EXPECT_EQ(0u, r.anyHits);
    EXPECT_EQ(1u, r.closestHits);
    EXPECT_NEAR(2.0f, r.closestHit.tmax, 1e-5f);
    // Terminating on the first hit ends the intersection program as well.
    r = trace({-3, 0, 0}, {1, 0, 0}, 0, 100, OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT);
    EXPECT_EQ(1u, r.closestHits);
    EXPECT_EQ(1u, r.reports);
}

TEST_P(Spheres, AnyHitFlags) {
    makeScene(1, kProbeIgnore, 0, "__anyhit__probe");
    EXPECT_EQ(1u, trace({-3, 0, 0}, {1, 0, 0}, 0, 100, OPTIX_RAY_FLAG_DISABLE_ANYHIT).closestHits);
    EXPECT_EQ(0u, trace({-3, 0, 0}, {1, 0, 0}, 0, 100, OPTIX_RAY_FLAG_ENFORCE_ANYHIT).closestHits);
    EXPECT_EQ(1u, trace({-3, 0, 0}, {1, 0, 0}, 0, 100, OPTIX_RAY_FLAG_CULL_ENFORCED_ANYHIT).misses);
    // Face culling applies only to triangles.
    ProbeResult r = trace({-3, 0, 0}, {1, 0, 0}, 0, 100,
                          OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES);
    EXPECT_EQ(1u, r.closestHits);
}

TEST_P(Spheres, UnderAnInstance) {
    makeScene(1, kProbeAccept, 0, "__anyhit__probe");
    // Twice as large, moved to (10, 0, 0).
    Matrix m{2, 0, 0, 10, 0, 2, 0, 0, 0, 0, 2, 0};
    InstanceList list({instanceOf(gas_.handle, m, 99)});
    Accel top = buildAccel(context_, log_, {list.input});
    ProbeResult r = trace({0, 0, 0}, {1, 0, 0}, 0, 100, 0, top.handle);
    ASSERT_EQ(1u, r.closestHits);
    EXPECT_NEAR(8.0f, r.closestHit.tmax, 1e-4f);
    ASSERT_GE(r.intersections, 1u);
    const ProbeSeen& s = r.intersection[0];
    EXPECT_NEAR(-5.0f, s.objectOrigin[0], 1e-5f);
    EXPECT_NEAR(0.5f, s.objectDirection[0], 1e-6f) << "not made a unit vector";
    EXPECT_EQ(0.0f, s.worldOrigin[0]);
    EXPECT_EQ(1.0f, s.worldDirection[0]);
    EXPECT_EQ(99u, s.instanceId);
    EXPECT_EQ(1u, s.transformCount);
    EXPECT_EQ(gas_.handle, s.gas);
    EXPECT_EQ(99u, r.closestHit.instanceId);
}

TEST_P(Spheres, WithoutIntersectionProgramNothingIsHit) {
    makeScene(1, kProbeAccept, 0, "__anyhit__probe");
    auto other = rig("probe", compileOptions(4));
    other->raygenRecord(other->raygen("__raygen__probe"));
    other->missRecord(other->miss("__miss__probe"), ProbeData{});
    other->hitRecord(other->hit("__closesthit__probe", "__anyhit__probe"), ProbeData{});
    other->link();
    rig_ = std::move(other);
    ProbeResult r = trace({-3, 0, 0}, {1, 0, 0}, 0, 100);
    EXPECT_EQ(0u, r.closestHits + r.anyHits);
    EXPECT_EQ(1u, r.misses);
}

// Optimisation and debug levels change speed, not results.
TEST_P(Programs, EveryOptimisationLevel) {
    auto low = wall(0), high = wall(1);
    Accel accel = buildAccel(context_, log_, {low->input, high->input});
    for (unsigned level : {0x2340u, 0x2341u, 0x2342u, 0x2343u}) {
        SCOPED_TRACE(level);
        Rig r(context_, log_, program("recursion"), compileOptions(3),
              OptixCompileOptimizationLevel(level));
        r.raygenRecord(r.raygen("__raygen__recursion"));
        r.missRecord(r.miss("__miss__recursion"));
        r.hitRecord(r.hit("__closesthit__recursion"));
        r.hitRecord(r.hit("__closesthit__recursion"));
        r.link(9);
        Buffer results(16);
        r.run(RecursionParams{accel.handle, results.as<unsigned long long>(), 9, 0}, 1);
        EXPECT_EQ(recursionExpected(1, 9, true).first, results.as<uint64_t>()[0]);
    }
}

INSTANTIATE_DEVICE_TEST(Programs);
INSTANTIATE_DEVICE_TEST(Spheres);

} // namespace
} // namespace tests::api
