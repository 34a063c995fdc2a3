// SPDX-License-Identifier: Apache-2.0
// Rules about whole graphs and operations on structures: graph flags, depth, loops, build flags and
// their effects, updates of all kinds, other contexts.
#include "device/probe.h"
#include "device_memory.h"
#include "rig.h"
#include "scene.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace tests::api {
namespace {

constexpr unsigned kUpdate = OPTIX_BUILD_FLAG_ALLOW_UPDATE;
constexpr unsigned kCompaction = OPTIX_BUILD_FLAG_ALLOW_COMPACTION;

// The hit, in one word.
unsigned codeOf(const ProbeSeen& seen) {
    return seen.primitive * 64 + seen.instanceId % 64;
}

class AccelRules : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        rig_ = makeRig(context_, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY);
    }
    void TearDown() override {
        rig_.reset();
        ApiTest::TearDown();
    }

    std::unique_ptr<Rig> makeRig(OptixDeviceContext context, unsigned graphFlags) {
        OptixPipelineCompileOptions options = compileOptions(4);
        options.traversableGraphFlags = graphFlags;
        auto rig = std::make_unique<Rig>(context, log_, compiledPtx("probe", "clang"), options);
        rig->raygenRecord(rig->raygen("__raygen__probe"));
        rig->missRecord(rig->miss("__miss__probe"), ProbeData{});
        const size_t group = rig->hit("__closesthit__probe", nullptr, "__intersection__probe");
        for (unsigned i = 0; i < 4; ++i)
            rig->hitRecord(group, ProbeData{i, 0, nullptr, 0, 0});
        rig->link();
        return rig;
    }

    // Hits of a grid of rays along z: primitive and instance id of each hit, ~0u without.
    std::vector<unsigned> see(Rig& rig, OptixTraversableHandle handle, unsigned mask = 255) {
        std::vector<ProbeRay> list;
        for (unsigned i = 0; i < 400; ++i) {
            const float x = (float(i % 20) + 0.37f) / 5 - 2, y = (float(i / 20) + 0.41f) / 5 - 2;
            list.push_back({{x, y, -50}, 0, {0, 0, 1}, 1000, 0, mask, 0, 0, 1, 0, handle});
        }
        Buffer in(list), out(list.size() * sizeof(ProbeResult));
        rig.run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, unsigned(list.size()));
        std::vector<unsigned> seen;
        for (size_t i = 0; i < list.size(); ++i) {
            const ProbeResult& r = out.as<ProbeResult>()[i];
            EXPECT_EQ(1u, r.closestHits + r.misses);
            seen.push_back(r.closestHits ? codeOf(r.closestHit) : ~0u);
        }
        return seen;
    }
    std::vector<unsigned> see(OptixTraversableHandle handle) { return see(*rig_, handle); }
    static size_t hits(const std::vector<unsigned>& seen) {
        return seen.size() - size_t(std::count(seen.begin(), seen.end(), ~0u));
    }

    OptixResult update(const std::vector<OptixBuildInput>& inputs, Accel& accel,
                       unsigned flags = kUpdate) {
        OptixAccelBuildOptions options = buildOptions(flags);
        OptixAccelBufferSizes sizes{};
        EXPECT_OK(optixAccelComputeMemoryUsage(context_, &options, inputs.data(),
                                               unsigned(inputs.size()), &sizes));
        Buffer temp(sizes.tempUpdateSizeInBytes);
        options.operation = OPTIX_BUILD_OPERATION_UPDATE;
        OptixTraversableHandle handle = 0;
        const OptixResult result = optixAccelBuild(
            context_, nullptr, &options, inputs.data(), unsigned(inputs.size()), temp.address(),
            temp.size(), accel.memory.address(), accel.memory.size(), &handle, nullptr, 0);
        waitForDevice();
        if (result == OPTIX_SUCCESS) {
            EXPECT_EQ(accel.handle, handle);
        }
        return result;
    }

    // A copy of a structure made to be compacted, in memory of just its size.
    Accel compacted(const std::vector<OptixBuildInput>& inputs, unsigned flags) {
        Buffer size(8);
        const Accel from = buildAccel(context_, log_, inputs, flags | kCompaction,
                                      {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
        Accel to;
        to.memory = Buffer(*size.as<uint64_t>());
        EXPECT_OK(optixAccelCompact(context_, nullptr, from.handle, to.memory.address(),
                                    to.memory.size(), &to.handle));
        waitForDevice();
        return to;
    }

    std::unique_ptr<Rig> rig_;
};

std::vector<Vec3> cloud(unsigned triangles, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> at(-2, 2), to(-0.4f, 0.4f);
    std::vector<Vec3> vertices;
    for (unsigned i = 0; i < triangles; ++i) {
        const Vec3 c{at(random), at(random), at(random)};
        for (int k = 0; k < 3; ++k)
            vertices.push_back({c.x + to(random), c.y + to(random), c.z + to(random)});
    }
    return vertices;
}

std::vector<uint32_t> ascending(unsigned count) {
    std::vector<uint32_t> indices(count);
    for (unsigned i = 0; i < count; ++i)
        indices[i] = i;
    return indices;
}

TriangleMesh cloudMesh(unsigned triangles, unsigned seed) {
    return {cloud(triangles, seed), ascending(3 * triangles)};
}

void refill(TriangleMesh& mesh, const std::vector<Vec3>& vertices) {
    std::memcpy(mesh.vertices.as<void>(), vertices.data(), vertices.size() * sizeof(Vec3));
}

// Graph flags of a pipeline declare the graphs that rays traverse. With SINGLE_GAS alone, rays miss
// all other objects; with SINGLE_LEVEL_INSTANCING they miss objects below a second instance or
// transform. The log notes this. A geometry structure traced directly is always hit.
TEST_F(AccelRules, GraphFlags) {
    const TriangleMesh mesh = cloudMesh(200, 1);
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    const InstanceList one({instanceOf(gas.handle, identity(), 7)});
    const Accel ias = buildAccel(context_, log_, {one.input});
    const InstanceList two({instanceOf(ias.handle, identity(), 9)});
    const Accel nested = buildAccel(context_, log_, {two.input});
    const size_t all = hits(see(gas.handle));
    EXPECT_GT(all, 100u);
    const unsigned kGas = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS,
                   kInstancing = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
    for (unsigned flags : {0u, kGas, kInstancing, kGas | kInstancing}) {
        SCOPED_TRACE(flags);
        const std::unique_ptr<Rig> rig = makeRig(context_, flags);
        const auto expect = [&](bool isHit, OptixTraversableHandle handle) {
            log_.clear();
            EXPECT_EQ(isHit ? all : 0, hits(see(*rig, handle)));
            EXPECT_EQ(isHit, log_.all().find("traversableGraphFlags") == std::string::npos)
                << log_.all();
        };
        expect(true, gas.handle);
        expect(flags != kGas, ias.handle);
        expect(flags == 0, nested.handle);
    }
}

// Hits up to the number of levels in the device property, and misses beyond.
TEST_F(AccelRules, GraphsOfAllDepths) {
    unsigned limit = 0;
    ASSERT_OK(optixDeviceContextGetProperty(
        context_, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRAVERSABLE_GRAPH_DEPTH, &limit, sizeof(limit)));
    ASSERT_EQ(31u, limit);
    const TriangleMesh mesh = cloudMesh(200, 2);
    std::vector<Accel> chain;
    chain.push_back(buildAccel(context_, log_, {mesh.input}));
    const std::vector<unsigned> expected = see(chain[0].handle);
    for (unsigned depth = 2; depth < 40; ++depth) { // structures on the path
        const float step = depth % 2 ? 0.125f : -0.125f;
        const InstanceList list({instanceOf(chain.back().handle, translation(step, 0, 0), depth)});
        chain.push_back(buildAccel(context_, log_, {list.input}));
        if (depth > limit + 1)
            EXPECT_EQ(0u, hits(see(chain.back().handle))) << depth;
        else if (depth <= limit && depth % 2)
            EXPECT_EQ(hits(expected), hits(see(chain.back().handle))) << depth;
        else if (depth <= limit)
            EXPECT_GT(hits(see(chain.back().handle)), 50u) << depth;
    }
}

// With thousands of handles, each handle is found and neighbouring addresses are not: GPUs look
// handles up.
TEST_F(AccelRules, ManyStructures) {
    constexpr unsigned kCount = 1500;
    const TriangleMesh mesh({{-2, -2, 0}, {2, -2, 0}, {0, 2, 0}}, {0, 1, 2});
    OptixAccelBuildOptions options = buildOptions(0);
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
    const size_t step = (sizes.outputSizeInBytes + 255) / 256 * 256;
    Buffer temp(sizes.tempSizeInBytes), memory(kCount * step);
    std::vector<ProbeRay> list;
    for (unsigned i = 0; i < kCount; ++i) {
        OptixTraversableHandle handle = 0;
        ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &mesh.input, 1, temp.address(),
                                  temp.size(), memory.address() + i * step, step, &handle, nullptr,
                                  0));
        for (OptixTraversableHandle each : {handle, handle + 128})
            list.push_back({{0, 0, -1}, 0, {0, 0, 1}, 10, 0, 255, 0, 0, 1, 0, each});
    }
    for (unsigned round = 0; round < 2; ++round) {
        Buffer in(list), out(list.size() * sizeof(ProbeResult));
        rig_->run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, unsigned(list.size()));
        for (size_t i = 0; i < list.size(); ++i)
            ASSERT_EQ(i % 2 == 0 ? 1u : 0u, out.as<ProbeResult>()[i].closestHits) << i;
    }
}

// Updates can create a cycle; rays do not follow it, for any number of paths.
TEST_F(AccelRules, StructuresWithinThemselves) {
    const TriangleMesh mesh = cloudMesh(200, 3);
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    std::vector<OptixInstance> list(12, instanceOf(gas.handle, identity(), 1));
    const InstanceList instances(list);
    Accel ias = buildAccel(context_, log_, {instances.input}, kUpdate);
    const std::vector<unsigned> expected = see(ias.handle);
    for (unsigned i = 1; i < 12; ++i)
        instances.memory.as<OptixInstance>()[i].traversableHandle = ias.handle;
    ASSERT_OK(update({instances.input}, ias));
    EXPECT_EQ(expected, see(ias.handle));
    // Two structures, each within the other.
    InstanceList other(list);
    Accel partner = buildAccel(context_, log_, {other.input}, kUpdate);
    for (unsigned i = 1; i < 12; ++i) {
        instances.memory.as<OptixInstance>()[i].traversableHandle = partner.handle;
        other.memory.as<OptixInstance>()[i].traversableHandle = ias.handle;
    }
    ASSERT_OK(update({instances.input}, ias));
    ASSERT_OK(update({other.input}, partner));
    EXPECT_EQ(expected, see(ias.handle));
    EXPECT_EQ(expected, see(partner.handle));
}

double processorSeconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

TEST_F(AccelRules, BuildFlagsHaveEffects) {
    const TriangleMesh mesh = cloudMesh(150000, 4);
    const auto sizes = [&](unsigned flags) {
        OptixAccelBuildOptions options = buildOptions(flags);
        OptixAccelBufferSizes s{};
        EXPECT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &s));
        return s;
    };
    const OptixAccelBufferSizes plain = sizes(0);
    EXPECT_EQ(0u, plain.tempUpdateSizeInBytes);
    EXPECT_GT(sizes(kUpdate).tempUpdateSizeInBytes, 0u);
    EXPECT_GT(sizes(OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS).outputSizeInBytes,
              plain.outputSizeInBytes); // the table of triangles
    EXPECT_GT(sizes(OPTIX_BUILD_FLAG_PREFER_FAST_TRACE).outputSizeInBytes,
              plain.outputSizeInBytes); // room for split triangles
    const auto buildSeconds = [&](unsigned flags) {
        const OptixAccelBuildOptions options = buildOptions(flags);
        const OptixAccelBufferSizes s = sizes(flags);
        const Buffer temp(s.tempSizeInBytes), output(s.outputSizeInBytes);
        OptixTraversableHandle handle = 0;
        double best = 1e9;
        for (int i = 0; i < 5; ++i) {
            const double start = processorSeconds();
            EXPECT_OK(optixAccelBuild(context_, nullptr, &options, &mesh.input, 1, temp.address(),
                                      temp.size(), output.address(), output.size(), &handle,
                                      nullptr, 0));
            waitForDevice();
            best = std::min(best, processorSeconds() - start);
        }
        return best;
    };
    // On a busy machine, waiting threads add to the processor time, so the measurement is repeated.
    // The host's work while a GPU builds is not measured.
    bool isFaster = onGpu();
    for (int attempt = 0; attempt < 5 && !isFaster; ++attempt)
        isFaster = buildSeconds(OPTIX_BUILD_FLAG_PREFER_FAST_BUILD) < 0.8 * buildSeconds(0);
    EXPECT_TRUE(isFaster);
    // With all flags, rays get the same hits.
    const TriangleMesh small = cloudMesh(2000, 4);
    const std::vector<unsigned> expected = see(buildAccel(context_, log_, {small.input}).handle);
    EXPECT_GT(hits(expected), 380u);
    for (unsigned flags = 1; flags < 64; ++flags)
        if ((flags & 12) != 12) {
            EXPECT_EQ(expected, see(buildAccel(context_, log_, {small.input}, flags).handle))
                << flags;
            EXPECT_EQ((flags & kUpdate) != 0, sizes(flags).tempUpdateSizeInBytes != 0);
        }
}

// An update starts from the tree of the build, so updates in between have no effect.
TEST_F(AccelRules, ManyUpdatesAreOneUpdate) {
    TriangleMesh mesh = cloudMesh(3000, 5), same = cloudMesh(3000, 5);
    Accel often = buildAccel(context_, log_, {mesh.input}, kUpdate);
    Accel once = buildAccel(context_, log_, {same.input}, kUpdate);
    for (unsigned step = 0; step < 30; ++step) {
        std::vector<Vec3> moved = cloud(3000, 100 + step);
        if (step % 3 == 1) // some or all triangles inactive on the way
            for (size_t i = 0; i < moved.size(); i += step % 2 ? 7 : 1)
                moved[i].y = std::nanf("");
        refill(mesh, moved);
        ASSERT_OK(update({mesh.input}, often));
    }
    const std::vector<Vec3> end = cloud(3000, 77);
    refill(mesh, end);
    refill(same, end);
    ASSERT_OK(update({mesh.input}, often));
    ASSERT_OK(update({same.input}, once));
    EXPECT_EQ(see(once.handle), see(often.handle));
    OptixAccelRelocationInfo info{};
    ASSERT_OK(optixAccelGetRelocationInfo(context_, once.handle, &info));
    if (!onGpu()) // two builds there number their nodes in the order of their threads
        EXPECT_EQ(0,
                  std::memcmp(once.memory.as<void>(), often.memory.as<void>(), once.memory.size()));
}

TEST_F(AccelRules, InstancePointersAreUpdatedToo) {
    const TriangleMesh mesh = cloudMesh(50, 6);
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    std::vector<OptixInstance> list;
    for (unsigned i = 0; i < 9; ++i)
        list.push_back(instanceOf(gas.handle, translation(0.3f * float(i) - 1, 0, 0), i));
    const InstanceList first(list);
    for (OptixInstance& instance : list)
        instance.transform[7] += 0.5f;
    const InstanceList second(list);
    const auto pointersTo = [](const InstanceList& instances) {
        std::vector<CUdeviceptr> out;
        for (unsigned i = 0; i < 9; ++i)
            out.push_back(instances.memory.address() + i * sizeof(OptixInstance));
        return out;
    };
    const Buffer pointers(pointersTo(first));
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS;
    input.instanceArray.instances = pointers.address();
    input.instanceArray.numInstances = 9;
    Accel ias = buildAccel(context_, log_, {input}, kUpdate);
    Accel small = compacted({input}, kUpdate);
    const std::vector<unsigned> before = see(buildAccel(context_, log_, {first.input}).handle);
    const std::vector<unsigned> after = see(buildAccel(context_, log_, {second.input}).handle);
    EXPECT_NE(before, after);
    EXPECT_EQ(before, see(ias.handle));
    EXPECT_EQ(before, see(small.handle));
    const std::vector<CUdeviceptr> moved = pointersTo(second);
    std::memcpy(pointers.as<void>(), moved.data(), moved.size() * sizeof(moved[0]));
    ASSERT_OK(update({input}, ias));
    ASSERT_OK(update({input}, small, kUpdate | kCompaction));
    EXPECT_EQ(after, see(ias.handle));
    EXPECT_EQ(after, see(small.handle));
    // Counts are those of the build.
    input.instanceArray.numInstances = 8;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "primitives",
                    update({input}, ias));
}

TEST_F(AccelRules, CountsOfBoxesAndInputsMayNotChange) {
    CustomBoxes boxes(std::vector<OptixAabb>(5, OptixAabb{0, 0, 0, 1, 1, 1}));
    Accel customs = buildAccel(context_, log_, {boxes.input, boxes.input}, kUpdate);
    EXPECT_OK(update({boxes.input, boxes.input}, customs));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "build inputs",
                    update({boxes.input}, customs));
    OptixBuildInput fewer = boxes.input;
    fewer.customPrimitiveArray.numPrimitives = 4;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "primitives",
                    update({fewer, boxes.input}, customs));
    CustomBoxes six(std::vector<OptixAabb>(6, OptixAabb{0, 0, 0, 1, 1, 1}));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "primitives",
                    update({fewer, six.input}, customs));
    OptixBuildInput shifted = boxes.input;
    shifted.customPrimitiveArray.primitiveIndexOffset = 3;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "primitiveIndexOffset = 3",
                    update({boxes.input, shifted}, customs));
    EXPECT_OK(update({boxes.input, boxes.input}, customs));
}

// A relocated copy is a full structure, also in another context: it can be updated, compacted and
// instanced after the original and its context are destroyed.
TEST_F(AccelRules, CopiesLiveOnInAnotherContext) {
    TriangleMesh mesh = cloudMesh(300, 8);
    const unsigned flags = kUpdate | kCompaction;
    const std::vector<Vec3> moved = cloud(300, 9);
    Accel copy;
    std::vector<unsigned> before;
    {
        OptixDeviceContext first = nullptr;
        OptixDeviceContextOptions options{};
        ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &first));
        Accel original = buildAccel(first, log_, {mesh.input}, flags);
        {
            const std::unique_ptr<Rig> rig =
                makeRig(first, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
            before = see(*rig, original.handle);
        }
        OptixAccelRelocationInfo info{};
        ASSERT_OK(optixAccelGetRelocationInfo(first, original.handle, &info));
        copy.memory = Buffer(original.memory.size());
        std::memcpy(copy.memory.as<void>(), original.memory.as<void>(), original.memory.size());
        original.memory.fill(0xA5);
        ASSERT_OK(optixDeviceContextDestroy(first));
        int compatible = 0;
        ASSERT_OK(optixAccelCheckRelocationCompatibility(context_, &info, &compatible));
        ASSERT_EQ(1, compatible);
        ASSERT_OK(optixAccelRelocate(context_, nullptr, &info, 0, 0, copy.memory.address(),
                                     copy.memory.size(), &copy.handle));
    }
    EXPECT_EQ(before, see(copy.handle));
    EXPECT_GT(hits(before), 150u);
    refill(mesh, moved);
    ASSERT_OK(update({mesh.input}, copy, flags));
    const std::vector<unsigned> after = see(buildAccel(context_, log_, {mesh.input}).handle);
    EXPECT_EQ(after, see(copy.handle));
    Accel small;
    small.memory = Buffer(copy.memory.size());
    ASSERT_OK(optixAccelCompact(context_, nullptr, copy.handle, small.memory.address(),
                                small.memory.size(), &small.handle));
    const InstanceList list({instanceOf(small.handle, identity())});
    EXPECT_EQ(hits(after), hits(see(buildAccel(context_, log_, {list.input}).handle)));
}

// Geometry of any size: a scene and its rays, scaled by a power of two, give the same hits.
TEST_F(AccelRules, TinyAndHugeGeometry) {
    const std::vector<Vec3> vertices = cloud(200, 10);
    const TriangleMesh plain(vertices, ascending(600));
    const Accel judge = buildAccel(context_, log_, {plain.input});
    const std::vector<unsigned> expected = see(judge.handle);
    for (int exponent : {-50, -40, -20, 20, 40, 55}) {
        const float s = std::ldexp(1.0f, exponent);
        std::vector<Vec3> scaled = vertices;
        for (Vec3& v : scaled)
            v = {v.x * s, v.y * s, v.z * s};
        const TriangleMesh mesh(scaled, ascending(600));
        const Accel gas = buildAccel(context_, log_, {mesh.input});
        std::vector<ProbeRay> list;
        for (unsigned i = 0; i < 400; ++i) {
            const float x = (float(i % 20) + 0.37f) / 5 - 2, y = (float(i / 20) + 0.41f) / 5 - 2;
            list.push_back(
                {{x * s, y * s, -50 * s}, 0, {0, 0, 1}, 1000 * s, 0, 255, 0, 0, 1, 0, gas.handle});
        }
        const Buffer in(list), out(list.size() * sizeof(ProbeResult));
        rig_->run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, 400);
        for (unsigned i = 0; i < 400; ++i) {
            const ProbeResult& r = out.as<ProbeResult>()[i];
            ASSERT_EQ(expected[i] != ~0u, r.closestHits == 1) << exponent << " " << i;
            if (r.closestHits)
                EXPECT_EQ(expected[i], codeOf(r.closestHit));
        }
        // The same through an instance that scales a structure of ordinary size.
        Matrix m = identity();
        m[0] = m[5] = m[10] = s;
        const InstanceList top({instanceOf(judge.handle, m, 5)});
        const Accel ias = buildAccel(context_, log_, {top.input});
        for (ProbeRay& ray : list)
            ray.handle = ias.handle;
        std::memcpy(in.as<void>(), list.data(), list.size() * sizeof(ProbeRay));
        out.fill(0);
        rig_->run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, 400);
        for (unsigned i = 0; i < 400; ++i)
            EXPECT_EQ(expected[i] != ~0u, out.as<ProbeResult>()[i].closestHits == 1)
                << exponent << " " << i;
    }
}

// Inputs of all sizes, none included, in one structure.
TEST_F(AccelRules, InputsOfMixedSizes) {
    std::mt19937 random(11);
    std::vector<std::unique_ptr<TriangleMesh>> meshes;
    std::vector<OptixBuildInput> inputs;
    std::vector<Vec3> all;
    unsigned total = 0;
    for (unsigned i = 0; i < 60; ++i) {
        const unsigned count = i % 4 == 0 ? 0 : i % 7 == 0 ? 1 : random() % 20;
        const std::vector<Vec3> vertices = cloud(count, 500 + i);
        all.insert(all.end(), vertices.begin(), vertices.end());
        meshes.push_back(std::make_unique<TriangleMesh>(vertices, ascending(3 * count)));
        meshes.back()->input.triangleArray.primitiveIndexOffset = total;
        inputs.push_back(meshes.back()->input);
        total += count;
    }
    const TriangleMesh whole(all, ascending(3 * total));
    const std::vector<unsigned> expected = see(buildAccel(context_, log_, {whole.input}).handle);
    for (unsigned flags : {0u, kUpdate, unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_BUILD),
                           unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_TRACE)}) {
        std::vector<ProbeRay> list;
        Accel gas = buildAccel(context_, log_, inputs, flags);
        if (flags == kUpdate)
            ASSERT_OK(update(inputs, gas));
        for (unsigned i = 0; i < 400; ++i) {
            const float x = (float(i % 20) + 0.37f) / 5 - 2, y = (float(i / 20) + 0.41f) / 5 - 2;
            // Stride 0: all geometry uses the first record.
            list.push_back({{x, y, -50}, 0, {0, 0, 1}, 1000, 0, 255, 0, 0, 0, 0, gas.handle});
        }
        const Buffer in(list), out(list.size() * sizeof(ProbeResult));
        rig_->run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, 400);
        for (unsigned i = 0; i < 400; ++i) {
            const ProbeSeen& s = out.as<ProbeResult>()[i].closestHit;
            EXPECT_EQ(expected[i] != ~0u, out.as<ProbeResult>()[i].closestHits == 1) << i;
            if (expected[i] == ~0u)
                continue;
            EXPECT_EQ(expected[i], codeOf(s));
            const auto& mine = inputs[s.sbtGasIndex].triangleArray;
            EXPECT_GE(s.primitive, mine.primitiveIndexOffset);
            EXPECT_LT(s.primitive, mine.primitiveIndexOffset + mine.numIndexTriplets);
        }
    }
}

} // namespace
} // namespace tests::api
