// SPDX-License-Identifier: Apache-2.0
// Motion on GPUs: builder kernels run on the CPU device, traversal compiled for the host. The
// references are the CPU's structures, whose hits must be equal bit for bit, and a loop over all
// instances.
#include "bvh/gpu/testing/device.h"
#include "bvh/motion/motion_bounds.h"
#include "bvh/walk/kernels.h"
#include "math/affine.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;
using bvh::testing::Mesh;

constexpr float kTimes[] = {0, 1, 0.5f, 0.25f, 1.0f / 3, 0.999999f, 1e-30f, 0.77f, -2, 3};

// A soup whose vertices move independently.
struct MovingMesh {
    std::vector<Mesh> keys;
    std::vector<const void*> pointers;
    BuildOptions options;

    MovingMesh(uint32_t triangles, uint32_t count, float size, float speed, uint32_t seed) {
        keys.push_back(soup(triangles, size, seed));
        Random random(seed + 1);
        for (uint32_t k = 1; k < count; ++k) {
            keys.push_back(keys.back());
            for (Vec3& v : keys.back().vertices)
                v = v + random.point(speed);
        }
        for (const Mesh& key : keys)
            pointers.push_back(key.vertices.data());
        options.motion = {count, 0, 0, 1};
    }
    TriangleInput input() const {
        TriangleInput in = keys[0].input();
        in.keyVertices = pointers.data();
        return in;
    }
};

QueryRay randomRay(Random& random, float extent) {
    const Vec3 o = random.point(extent);
    Vec3 d = random.below(3) ? random.point(1) - o : random.unit();
    if (random.below(8) == 0)
        d = {0, 0, random.below(2) ? 1.0f : -1.0f};
    return {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
}

uint32_t expectSameHits(const void* cpu, uint64_t handle, uint32_t seed, uint32_t rays) {
    Random random(seed);
    uint32_t hits = 0;
    for (float time : kTimes)
        for (uint32_t i = 0; i < rays; ++i) {
            const QueryRay ray = randomRay(random, 2);
            QueryHit a{}, b{};
            const bool found = kernels(chosenIsa()).closestAt(cpu, ray, time, a);
            EXPECT_EQ(found, nearestAt(handle, ray, time, b)) << "ray " << i << " time " << time;
            if (!found)
                continue;
            ++hits;
            EXPECT_EQ(a.t, b.t);
            EXPECT_EQ(a.u, b.u);
            EXPECT_EQ(a.v, b.v);
            EXPECT_EQ(a.primitive, b.primitive);
            EXPECT_EQ(a.sbt, b.sbt);
            EXPECT_EQ(a.front, b.front);
            if (::testing::Test::HasFailure())
                return hits;
        }
    return hits;
}

void expectSameBounds(const BlockHeader& gpu, const BlockHeader& cpu) {
    EXPECT_EQ(gpu.type, cpu.type);
    EXPECT_EQ(gpu.numActive, cpu.numActive);
    EXPECT_EQ(gpu.motionKeys, cpu.motionKeys);
    const auto boxes = [](const BlockHeader& header) {
        return reinterpret_cast<const KeyBounds*>(reinterpret_cast<const uint8_t*>(&header) +
                                                  header.keyBoundsOffset);
    };
    for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(gpu.lower[a], cpu.lower[a]);
        EXPECT_EQ(gpu.upper[a], cpu.upper[a]);
        for (uint32_t k = 0; k < cpu.motionKeys; ++k) {
            EXPECT_EQ(boxes(gpu)[k].lower[a], boxes(cpu)[k].lower[a]) << "key " << k;
            EXPECT_EQ(boxes(gpu)[k].upper[a], boxes(cpu)[k].upper[a]) << "key " << k;
        }
    }
}

TEST(GpuMotion, TrianglesAreWhereTheCpuHasThem) {
    for (uint32_t keys : {2u, 3u, 7u})
        for (uint32_t count : {1u, 3u, 40u, 1500u}) {
            SCOPED_TRACE(std::to_string(count) + " triangles, keys " + std::to_string(keys));
            const MovingMesh mesh(count, keys, 0.15f, 0.3f, count + keys);
            const TriangleInput in = mesh.input();
            BuildOptions options = mesh.options;
            options.preferFastBuild = keys == 3;
            options.preferFastTrace = keys == 7;
            const Structure cpu = makeStructure(in, options);
            const GpuStructure gpu = buildOnDevice(in, options);
            expectSameBounds(gpu.header(), *headerOf(cpu.block()));
            const uint32_t hits = expectSameHits(cpu.block(), gpu.handle(), count + keys, 300);
            EXPECT_TRUE(count < 1500 || hits > 1000) << hits;
            ASSERT_EQ(hits, expectSameHits(cpu.block(), gpu.loose->address() | devlib::kTagGas,
                                           count + keys, 300));
        }
}

// Far from the origin, rounding errors are as large as the triangles.
TEST(GpuMotion, BoxesHoldWhatIsRounded) {
    for (float away : {1e3f, 1e5f}) {
        MovingMesh mesh(400, 2, 0.2f, 0.4f, 5);
        for (Mesh& key : mesh.keys)
            for (Vec3& v : key.vertices)
                v = v + Vec3{away, -away, away};
        const TriangleInput in = mesh.input();
        const Structure cpu = makeStructure(in, mesh.options);
        const GpuStructure gpu = buildOnDevice(in, mesh.options);
        Random random(3);
        uint32_t hits = 0;
        for (uint32_t i = 0; i < 4000; ++i) {
            QueryRay ray = randomRay(random, 2);
            const float shift[3] = {away, -away, away};
            for (int a = 0; a < 3; ++a)
                ray.origin[a] += shift[a];
            const float time = random(0, 1);
            QueryHit a{}, b{};
            const bool found = kernels(chosenIsa()).closestAt(cpu.block(), ray, time, a);
            ASSERT_EQ(found, nearestAt(gpu.handle(), ray, time, b)) << i;
            hits += found;
            if (found)
                ASSERT_EQ(a.t, b.t);
        }
        EXPECT_GT(hits, 200u);
    }
}

TEST(GpuMotion, InactiveTriangles) {
    MovingMesh mesh(200, 3, 0.3f, 0.2f, 11);
    for (uint32_t i = 0; i < 200; i += 7)
        mesh.keys[i % 3].vertices[3 * i + i % 3].y = i % 2 ? NAN : 1e38f;
    for (uint32_t i = 1; i < 200; i += 11) // an area at some key only, or between two
        for (uint32_t k = 0; k < 3; ++k) {
            Mesh& key = mesh.keys[k];
            if (i % 2 == 0 || k != 1)
                key.vertices[3 * i + 1] = key.vertices[3 * i];
        }
    const TriangleInput in = mesh.input();
    const Structure cpu = makeStructure(in, mesh.options);
    const GpuStructure gpu = buildOnDevice(in, mesh.options);
    expectSameBounds(gpu.header(), *headerOf(cpu.block()));
    EXPECT_LT(gpu.header().numActive, 200u);
    EXPECT_GT(expectSameHits(cpu.block(), gpu.handle(), 4, 300), 500u);
    for (Mesh& key : mesh.keys)
        for (Vec3& v : key.vertices)
            v.x = NAN;
    EXPECT_EQ(buildOnDevice(in, mesh.options).header().root, kNoNode);
}

TEST(GpuMotion, TimesBeforeAndAfterAndVanishing) {
    const MovingMesh mesh(60, 2, 0.5f, 0.5f, 21);
    const TriangleInput in = mesh.input();
    for (uint32_t flags : {0u, 1u, 2u, 3u}) {
        for (float end : {-0.5f, 0.75f}) {
            BuildOptions options = mesh.options;
            options.motion = {2, flags, -0.5f, end};
            const Structure cpu = makeStructure(in, options);
            const GpuStructure gpu = buildOnDevice(in, options);
            expectSameHits(cpu.block(), gpu.handle(), flags, 200);
        }
    }
    QueryHit hit;
    const QueryRay nan{{0, 0, -5}, 0, {0, 0, 1}, 1e30f};
    nearestAt(buildOnDevice(in, mesh.options).handle(), nan, NAN, hit);
}

TEST(GpuMotion, VertexFormatsAndInputs) {
    MovingMesh first(70, 2, 0.4f, 0.2f, 31), second(50, 2, 0.4f, 0.2f, 32);
    const float transform[12] = {0.9f, 0.3f, 0, 0.1f, -0.2f, 1.1f, 0.1f, 0, 0, 0.2f, 0.7f, -0.3f};
    const uint32_t flags[2] = {1, 2};
    TriangleInput inputs[2] = {first.input(), second.input()};
    inputs[1].preTransform = transform;
    inputs[1].sbt = {flags, 2, nullptr, 0, 0, 100};
    BuildInputs all;
    all.triangles = inputs;
    const Structure cpu = makeStructure(all, first.options);
    const GpuStructure gpu = buildOnDevice(all, first.options);
    expectSameBounds(gpu.header(), *headerOf(cpu.block()));
    EXPECT_GT(expectSameHits(cpu.block(), gpu.handle(), 6, 300), 500u);
}

TEST(GpuMotion, TriangleVerticesOfAllKeysAreThere) {
    const MovingMesh mesh(300, 3, 0.3f, 0.4f, 41);
    BuildOptions options = mesh.options;
    options.allowRandomVertexAccess = true;
    const GpuStructure s = buildOnDevice(mesh.input(), options);
    const auto* bytes = static_cast<const uint8_t*>(s.memory->data());
    const auto* table = reinterpret_cast<const uint32_t*>(bytes + s.header().tableOffset);
    const auto* records = reinterpret_cast<const TriangleRecord*>(bytes + s.header().recordsOffset);
    for (uint32_t i = 0; i < 300; ++i)
        for (uint32_t k = 0; k < 3; ++k) {
            const TriangleRecord& record = records[table[i] * 3 + k];
            ASSERT_EQ(record.primitive, i);
            ASSERT_EQ(std::memcmp(record.v2, &mesh.keys[k].vertices[3 * i + 2], 12), 0);
        }
}

// Boxes that rays meet at a time, by the manual.
struct BoxPrograms : NoShapes, OneLane {
    static constexpr bool kTriangles = false, kCustoms = true, kInstances = false, kMotion = true;
    static constexpr unsigned kLevels = 0;
    float rayTime = 0;
    std::vector<uint32_t> seen;
    Visit triangle(gpu::Ray&, const TriangleHit&, uint32_t, uint32_t) { return Visit::kEnd; }
    Visit custom(gpu::Ray&, uint32_t primitive, uint32_t) {
        seen.push_back(primitive);
        return Visit::kContinue;
    }
    void leave(gpu::Ray&) {}
    float time() const { return rayTime; }
    static bool meetsKeys() { return true; }
};

TEST(GpuMotion, CustomPrimitives) {
    Random random(8);
    constexpr uint32_t kCount = 300;
    std::vector<Box> keys[3];
    for (std::vector<Box>& boxes : keys)
        for (uint32_t i = 0; i < kCount; ++i) {
            const Vec3 c = random.point(1);
            boxes.push_back({c - Vec3{0.05f, 0.1f, 0.02f}, c + Vec3{0.05f, 0.1f, 0.02f}});
        }
    keys[2][17].lower.x = keys[2][17].upper.x + 1; // inverted at one key
    const void* addresses[3] = {keys[0].data(), keys[1].data(), keys[2].data()};
    CustomInput in;
    in.aabbs = addresses[0];
    in.keyAabbs = addresses;
    in.numPrimitives = kCount;
    BuildInputs inputs;
    inputs.customs = {&in, 1};
    BuildOptions options;
    options.motion = {3, 0, 0, 1};
    const GpuStructure s = buildOnDevice(inputs, options);
    expectSameBounds(s.header(), *headerOf(makeStructure(inputs, options).block()));
    EXPECT_EQ(s.header().numActive, kCount - 1);
    uint32_t shown = 0, wanted = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
        const QueryRay ray = randomRay(random, 3);
        BoxPrograms programs;
        programs.rayTime = random(-0.2f, 1.2f);
        gpu::Ray query{};
        for (int a = 0; a < 3; ++a) {
            query.origin[a] = ray.origin[a];
            query.direction[a] = ray.direction[a];
        }
        query.tmax = ray.tmax;
        Traversal<BoxPrograms> traversal;
        U2 stack[Traversal<BoxPrograms>::kStackSize];
        if (traversal.start(programs, query, s.handle(), nullptr))
            traversal.run(programs, query, stack, nullptr, RunToEnd());
        std::sort(programs.seen.begin(), programs.seen.end());
        shown += uint32_t(programs.seen.size());
        const KeySegment at = keySegment(3, 0, 1, programs.rayTime);
        for (uint32_t k = 0; k < kCount; ++k) {
            double begin = 0, end = 1e30;
            for (int a = 0; a < 3; ++a) {
                const double f = at.fraction;
                const Box &p = keys[at.key][k], &q = keys[at.key + 1][k];
                const double low = p.lower[a] * (1 - f) + q.lower[a] * f,
                             high = p.upper[a] * (1 - f) + q.upper[a] * f;
                const double x = (low - ray.origin[a]) / ray.direction[a],
                             y = (high - ray.origin[a]) / ray.direction[a];
                begin = std::max(begin, std::min(x, y));
                end = std::min(end, std::max(x, y));
            }
            if (begin <= end && k != 17) {
                ++wanted;
                ASSERT_TRUE(std::binary_search(programs.seen.begin(), programs.seen.end(), k));
            }
        }
    }
    EXPECT_GT(wanted, 500u);
    EXPECT_LT(shown, 1000u * 15); // not all of them
}

void update(const GpuStructure& structure, const BuildInputs& inputs, const BuildOptions& options) {
    const Device& device = Device::get();
    const Buffer temp(Builder::computeMemoryUsage(inputs, options).tempUpdate);
    device.builder().update(nullptr, inputs, options, temp.address(), temp.size(),
                            structure.memory->address(), structure.memory->size());
    ASSERT_EQ(device.driver().ctxSynchronize(), CUDA_SUCCESS);
    for (const std::string& failure : device.builder().takeFailures())
        ADD_FAILURE() << failure;
}

TEST(GpuMotion, UpdatesOfTriangles) {
    MovingMesh mesh(500, 3, 0.2f, 0.3f, 71);
    BuildOptions options = mesh.options;
    options.allowUpdate = options.allowCompaction = true;
    for (uint32_t i = 0; i < 500; i += 9)
        mesh.keys[1].vertices[3 * i].x = NAN;
    const TriangleInput in = mesh.input();
    BuildInputs inputs;
    inputs.triangles = {&in, 1};
    const GpuStructure s = buildOnDevice(inputs, options);
    const auto bytes = [&] {
        const auto* const first = static_cast<const uint8_t*>(s.memory->data());
        return std::vector<uint8_t>(first, first + s.memory->size());
    };
    const std::vector<uint8_t> built = bytes();
    update(s, inputs, options); // from the same: nothing changes
    EXPECT_EQ(built, bytes());
    Random random(72);
    for (uint32_t round = 0; round < 3; ++round) {
        for (uint32_t k = 0; k < 3; ++k)
            for (uint32_t i = 0; i < 500; ++i)
                for (uint32_t c = 0; c < 3; ++c) {
                    Vec3& v = mesh.keys[k].vertices[3 * i + c];
                    v = v + random.point(0.2f);
                    if (i % 7 == round) // others are active now
                        v.y = k == 2 ? INFINITY : 0;
                    else if (!std::isfinite(v.x + v.y))
                        v = random.point(1);
                }
        update(s, inputs, options);
        const Structure cpu = makeStructure(in, options);
        expectSameBounds(s.header(), *headerOf(cpu.block()));
        EXPECT_GT(expectSameHits(cpu.block(), s.handle(), round, 200), 300u);
    }
    BuildOptions other = options;
    other.motion.end = 2;
    EXPECT_THROW(update(s, inputs, other), Error);
}

// ---- instances --------------------------------------------------------------------------------

struct alignas(64) Matrices {
    uint64_t child;
    MotionRange motion;
    uint32_t pad[3];
    float keys[3][12];
};
struct alignas(64) Srts {
    uint64_t child;
    MotionRange motion;
    uint32_t pad[3];
    SrtKey keys[3];
};

void randomMatrix(Random& random, float m[12]) {
    const Vec3 p = random.point(1), x = random.point(0.3f), y = random.point(0.3f),
               z = random.point(0.3f);
    for (int a = 0; a < 3; ++a) {
        m[4 * a] = x[a];
        m[4 * a + 1] = y[a];
        m[4 * a + 2] = z[a];
        m[4 * a + 3] = p[a];
    }
}

// Finds the nearest hit in a list of instances by tracing each instance alone.
class Judge {
public:
    Judge(const std::vector<InstanceDesc>& instances, const Structure& still,
          const Structure& moving, uint64_t gpuStill)
        : instances_(instances), still_(still), moving_(moving), gpuStill_(gpuStill) {}

    float nearest(const QueryRay& ray, float time) const {
        float t = 1e30f;
        for (const InstanceDesc& instance : instances_) {
            float inverse[12];
            if (math::invert(instance.transform, inverse))
                follow(instance.traversableHandle, transformed(inverse, ray), time, t);
        }
        return t;
    }

private:
    static QueryRay transformed(const float m[12], const QueryRay& ray) {
        const Vec3 o = math::transformPoint(m, {ray.origin[0], ray.origin[1], ray.origin[2]}),
                   d = math::transformVector(
                       m, {ray.direction[0], ray.direction[1], ray.direction[2]});
        return {{o.x, o.y, o.z}, ray.tmin, {d.x, d.y, d.z}, ray.tmax};
    }
    void follow(uint64_t handle, QueryRay ray, float time, float& t) const {
        while (isTransformTag(handle & devlib::kTagMask)) {
            float inverse[12];
            if (!bvh::worldToObjectAt(handle, time, inverse))
                return;
            ray = transformed(inverse, ray);
            handle = childOf(handle);
        }
        ray.tmax = t;
        QueryHit hit{};
        const Kernels& k = kernels(chosenIsa());
        const bool found = handle == gpuStill_ ? k.closest(still_.block(), ray, hit)
                                               : k.closestAt(moving_.block(), ray, time, hit);
        if (found)
            t = hit.t;
    }

    const std::vector<InstanceDesc>& instances_;
    const Structure &still_, &moving_;
    uint64_t gpuStill_;
};

// Nodes bound the rotated structure itself, not its rotated box: rays beside it do not enter the
// instance.
TEST(GpuMotion, TurnedInstancesHaveTightBoxes) {
    struct Counting : MovingPrograms {
        uint32_t entered = 0;
        using MovingPrograms::MovingPrograms;
        bool enterInstance(gpu::Ray& ray, const InstanceRecord& i, uint64_t& child) {
            ++entered;
            return MovingPrograms::enterInstance(ray, i, child);
        }
    };
    // An octahedron of many triangles; a rotation by 45 degrees about z halves its extent along x.
    Mesh mesh;
    constexpr uint32_t kSide = 12;
    for (uint32_t octant = 0; octant < 8; ++octant)
        for (uint32_t i = 0; i < kSide; ++i)
            for (uint32_t j = 0; i + j < kSide; ++j) {
                const uint32_t first = uint32_t(mesh.vertices.size());
                for (const auto& [u, v] : {std::pair{i, j}, {i + 1, j}, {i, j + 1}}) {
                    const float x = float(u) / kSide, y = float(v) / kSide;
                    mesh.vertices.push_back({octant & 1 ? -x : x, octant & 2 ? -y : y,
                                             octant & 4 ? x + y - 1 : 1 - x - y});
                }
                mesh.triangles.push_back({first, first + 1, first + 2});
            }
    const GpuStructure child = buildOnDevice(mesh.input());
    alignas(64) MatrixMotionTransform moves{};
    moves.child = child.handle();
    moves.motion = {2, 0, 0, 1};
    for (int key = 0; key < 2; ++key)
        for (int k = 0; k < 3; ++k)
            moves.matrices[key][5 * k] = 1;
    moves.matrices[1][11] = 0.25f; // along z
    InstanceDesc instance{};
    const float c = 0.70710678f, turn[12] = {c, -c, 0, 0, c, c, 0, 0, 0, 0, 1, 0};
    std::memcpy(instance.transform, turn, sizeof turn);
    instance.visibilityMask = 255;
    instance.traversableHandle = reinterpret_cast<uint64_t>(&moves) | devlib::kTagMatrixMotion;
    InstanceInput list;
    list.instances = &instance;
    list.numInstances = 1;
    BuildInputs inputs;
    inputs.instances = &list;
    BuildOptions options;
    options.motion = {2, 0, 0, 1};
    const GpuStructure top = buildOnDevice(inputs, options);
    // It reaches 0.71; the box around the turned box 1.41.
    for (const float time : {0.0f, 0.5f, 1.0f})
        for (const float x : {0.3f, 0.6f, 1.1f, 1.2f, 1.39f}) {
            const QueryRay ray{{x, 0.001f, -5}, 0, {0, 0, 1}, 1e30f};
            Counting programs(time);
            QueryHit hit{};
            nearestBy(programs, top.handle(), ray, hit);
            EXPECT_EQ(programs.entered, x < 0.7f ? 1u : 0u) << x << " at " << time;
        }
}

// Instances with and without motion, some through motion transforms, in structures with and without
// motion keys.
TEST(GpuMotion, InstancesAndTransforms) {
    const Mesh sphere = icosphere(2);
    const MovingMesh mesh(80, 3, 0.8f, 0.5f, 51);
    const TriangleInput in = mesh.input();
    const Structure stillCpu = makeStructure(sphere.input()),
                    movingCpu = makeStructure(in, mesh.options);
    const GpuStructure still = buildOnDevice(sphere.input()),
                       moving = buildOnDevice(in, mesh.options);
    Random random(17);
    constexpr uint32_t kCount = 40;
    std::vector<Matrices> matrices(kCount);
    std::vector<Srts> srts(kCount);
    std::vector<InstanceDesc> instances(kCount);
    for (uint32_t i = 0; i < kCount; ++i) {
        const uint64_t child = i % 2 ? moving.handle() : still.handle();
        matrices[i].child = child;
        matrices[i].motion = {uint16_t(2 + i % 2), uint16_t(i % 5 == 0 ? 3 : 0), 0.1f, 0.8f};
        for (auto& key : matrices[i].keys)
            randomMatrix(random, key);
        srts[i].child = i % 3 ? child : uint64_t(&matrices[i]) | devlib::kTagMatrixMotion;
        srts[i].motion = {uint16_t(2 + i % 2), 0, -0.5f, 1.25f};
        for (SrtKey& key : srts[i].keys) {
            const Vec3 s = random.point(0.4f), t = random.point(0.7f);
            key = {1 + s.x, s.y,  s.z,           0.2f,          1 - s.y,       0.1f,          -0.3f,
                   1 + s.z, 0.1f, random(-1, 1), random(-1, 1), random(-1, 1), random(-1, 1), t.x,
                   t.y,     t.z};
        }
        randomMatrix(random, instances[i].transform);
        for (int a = 0; a < 3; ++a) // larger ones
            for (int b = 0; b < 3; ++b)
                instances[i].transform[4 * a + b] *= 2;
        instances[i].visibilityMask = 255;
        instances[i].traversableHandle = i % 4 == 0 ? child
                                         : i % 4 == 1
                                             ? uint64_t(&matrices[i]) | devlib::kTagMatrixMotion
                                             : uint64_t(&srts[i]) | devlib::kTagSrtMotion;
    }
    InstanceInput list;
    list.instances = instances.data();
    list.numInstances = kCount;
    BuildInputs inputs;
    inputs.instances = &list;
    const Judge judge(instances, stillCpu, movingCpu, still.handle());
    for (uint32_t round = 0; round < 6; ++round) {
        const uint32_t keys = round < 2 ? 1 : round < 4 ? 2 : 5;
        SCOPED_TRACE("round " + std::to_string(round));
        BuildOptions options;
        if (keys > 1)
            options.motion = {keys, 0, 0, 1};
        options.allowUpdate = options.allowCompaction = round % 2;
        const GpuStructure top = buildOnDevice(inputs, options);
        EXPECT_EQ(top.header().numActive, kCount);
        if (options.allowUpdate) { // everything moves
            for (InstanceDesc& instance : instances)
                for (int a = 0; a < 3; ++a)
                    instance.transform[4 * a + 3] *= -0.8f;
            for (Srts& srt : srts)
                for (SrtKey& key : srt.keys)
                    key.tx = -key.tx;
            update(top, inputs, options);
            EXPECT_EQ(top.header().numActive, kCount);
        }
        uint32_t hits = 0;
        for (float time : kTimes)
            for (uint32_t i = 0; i < 200; ++i) {
                const QueryRay ray = randomRay(random, 3);
                const float t = judge.nearest(ray, time);
                QueryHit hit{};
                ASSERT_EQ(nearestAt(top.handle(), ray, time, hit), t < 1e30f)
                    << "ray " << i << " time " << time << " keys " << keys;
                if (t < 1e30f) {
                    ++hits;
                    ASSERT_EQ(hit.t, t) << "ray " << i << " time " << time << " keys " << keys;
                }
                BesideMovingPrograms beside(time);
                QueryHit again{};
                ASSERT_EQ(nearestBy(beside, top.handle(), ray, again), t < 1e30f) << "ray " << i;
                ASSERT_EQ(again.t, hit.t) << "ray " << i << " time " << time << " keys " << keys;
            }
        EXPECT_GT(hits, 600u);
    }
}

// Transforms, and the bounds that kernels derive from them, equal those of the CPU.
TEST(GpuMotion, TransformsAreThoseOfTheCpu) {
    Random random(23);
    for (uint32_t i = 0; i < 300; ++i) {
        Matrices matrix{};
        Srts srt{};
        matrix.motion =
            srt.motion = {uint16_t(i % 4), uint16_t(random.below(4)), -1, i % 7 ? 2.0f : -1.0f};
        for (auto& key : matrix.keys)
            randomMatrix(random, key);
        for (SrtKey& key : srt.keys)
            for (float* number = &key.sx; number <= &key.tz; ++number)
                *number = i % 11 == 0 ? 0 : random(-1, 1);
        if (i % 13 == 0) {
            matrix.keys[i % 2][i % 12] = INFINITY;
            (&srt.keys[i % 2].sx)[i % 16] = -INFINITY;
        }
        if (i % 5 == 0) // else the second finds the place that the first has left
            srt.motion.end = 3;
        matrix.child = 64 * i;
        srt.child = matrix.child + 1;
        for (float time : {-1.0f, 0.3f, 2.0f, 5.0f, -7.0f, NAN}) {
            KnownSegment known;
            for (uint64_t handle : {uint64_t(&matrix) | devlib::kTagMatrixMotion,
                                    uint64_t(&srt) | devlib::kTagSrtMotion}) {
                float a[12] = {}, b[12] = {};
                uint64_t child = 0;
                ASSERT_EQ(bvh::worldToObjectAt(handle, time, a),
                          worldToObjectOf(handle, time, known, child, b))
                    << i;
                ASSERT_EQ(std::memcmp(a, b, sizeof a), 0) << i << " at " << time;
                ASSERT_EQ(child, childOf(handle));
            }
        }
    }
}

TEST(GpuMotion, StillPipelinesMeetNothingThatMoves) {
    const MovingMesh mesh(60, 2, 0.9f, 0.1f, 61);
    const GpuStructure s = buildOnDevice(mesh.input(), mesh.options);
    struct Refusing : NearestPrograms {
        uint32_t refused = 0;
        void refuseMotion() { ++refused; }
    } programs;
    QueryHit hit;
    EXPECT_FALSE(nearestBy(programs, s.handle(), {{0, 0, -3}, 0, {0, 0, 1}, 1e30f}, hit));
    EXPECT_EQ(programs.refused, 1u);
}

} // namespace
} // namespace sunstone::bvh::gpu
