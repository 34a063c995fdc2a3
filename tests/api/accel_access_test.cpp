// SPDX-License-Identifier: Apache-2.0
// Access to structures: relocation, handles of transforms, random access to triangles and
// instances, and traces through invalid handles.
#include "device/random_access.h"
#include "device_memory.h"
#include "rig.h"
#include "scene.h"

#include <sys/mman.h>

#include <cmath>

namespace tests::api {
namespace {

class AccelAccess : public DeviceTest {
protected:
    void SetUp() override {
        DeviceTest::SetUp();
        rig_ = rig("random_access", compileOptions(1));
        rig_->raygenRecord(rig_->raygen("__raygen__access"));
        rig_->missRecord(rig_->miss("__miss__access"));
        const size_t group = rig_->hit("__closesthit__access");
        for (int i = 0; i < 4; ++i)
            rig_->hitRecord(group);
        rig_->link();
    }
    void TearDown() override {
        rig_.reset();
        DeviceTest::TearDown();
    }
    std::vector<AccessResult> run(AccessParams params, unsigned count) {
        Buffer out(count * sizeof(AccessResult));
        params.results = out.as<AccessResult>();
        rig_->run(params, count);
        return {out.as<AccessResult>(), out.as<AccessResult>() + count};
    }
    // 1: missed, 2: hit.
    unsigned trace(OptixTraversableHandle handle) {
        return run({0, 0, handle, 0, 0, nullptr}, 1)[0].missed;
    }

    std::unique_ptr<Rig> rig_;
};

constexpr unsigned kVertices = OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
constexpr unsigned kInstances = OPTIX_BUILD_FLAG_ALLOW_RANDOM_INSTANCE_ACCESS;

const std::vector<Vec3> kTwoTriangles = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0},
                                         {4, 4, 1},   {5, 4, 1},  {4, 5, 1}};

TEST_P(AccelAccess, VertexDataOfTriangles) {
    TriangleMesh first(kTwoTriangles, {0, 1, 2, 3, 4, 5}, {0, 0});
    TriangleMesh second(kTwoTriangles, {3, 4, 5, 0, 0, 1, 2, 1, 0});
    second.input.triangleArray.primitiveIndexOffset = 10;
    for (unsigned flags : {0u, unsigned(OPTIX_BUILD_FLAG_ALLOW_UPDATE),
                           unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_TRACE)}) {
        const Accel gas =
            buildAccel(context_, log_, {first.input, second.input}, kVertices | flags);
        std::vector<AccessResult> seen = run({gas.handle, 0, 0, 0, 1, nullptr}, 3);
        for (unsigned i = 0; i < 2; ++i)
            EXPECT_EQ(0, std::memcmp(seen[i].vertices, &kTwoTriangles[3 * i], 36)) << i;
        EXPECT_TRUE(std::isnan(seen[2].vertices[0])); // no such primitive
        seen = run({gas.handle, 0, 0, 10, 2, nullptr}, 3);
        EXPECT_EQ(0, std::memcmp(seen[0].vertices, &kTwoTriangles[3], 36));
        for (float v : seen[1].vertices)
            EXPECT_TRUE(std::isnan(v)); // degenerate
        EXPECT_EQ(kTwoTriangles[2].y, seen[2].vertices[1]);
    }
    // Long thin triangles, to which several leaves refer.
    std::vector<Vec3> corners;
    std::vector<uint32_t> indices;
    for (uint32_t i = 0; i < 600; ++i) {
        const float angle = float(i) * 0.37f, x = std::cos(angle), y = std::sin(angle),
                    z = float(i % 29);
        corners.insert(corners.end(), {{-x, -y, z}, {x, y, z + 1.5f}, {x, y + 0.002f, z + 1.5f}});
        indices.insert(indices.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    }
    TriangleMesh needles(corners, indices);
    needles.input.triangleArray.primitiveIndexOffset = 100;
    const Accel gas = buildAccel(context_, log_, {first.input, needles.input},
                                 kVertices | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE);
    for (uint32_t i : {0u, 77u, 599u}) {
        const AccessResult seen = run({gas.handle, 0, 0, 100 + i, 2, nullptr}, 1)[0];
        EXPECT_EQ(0, std::memcmp(seen.vertices, &corners[3 * i], 36)) << i;
    }
    const Accel without = buildAccel(context_, log_, {first.input});
    for (OptixTraversableHandle bad :
         {without.handle, OptixTraversableHandle(0), OptixTraversableHandle(0x12345681)})
        EXPECT_TRUE(std::isnan(run({bad, 0, 0, 0, 0, nullptr}, 1)[0].vertices[4]));
}

TEST_P(AccelAccess, InstancesOfAStructure) {
    TriangleMesh mesh(kTwoTriangles, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    std::vector<OptixInstance> list;
    for (unsigned i = 0; i < 5; ++i)
        list.push_back(instanceOf(gas.handle, translation(float(i), 0, 0), 70 + i));
    InstanceList top(list);
    const Accel ias = buildAccel(context_, log_, {top.input}, kInstances);
    const std::vector<AccessResult> seen = run({0, ias.handle, ias.handle, 0, 0, nullptr}, 6);
    for (unsigned i = 0; i < 5; ++i) {
        EXPECT_EQ(70 + i, seen[i].id);
        EXPECT_EQ(gas.handle, seen[i].child);
        EXPECT_EQ(2u, seen[i].missed);
    }
    EXPECT_EQ(0u, seen[5].instance);
    const Accel without = buildAccel(context_, log_, {top.input});
    for (OptixTraversableHandle bad :
         {without.handle, gas.handle, OptixTraversableHandle(0x12345682)})
        EXPECT_EQ(0u, run({0, bad, 0, 0, 0, nullptr}, 1)[0].instance);
}

TEST_P(AccelAccess, TransformsBecomeTraversables) {
    TriangleMesh mesh(kTwoTriangles, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    Buffer memory(512, 64);
    auto* transform = memory.as<OptixStaticTransform>();
    transform->child = gas.handle;
    for (bool away : {false, true}) {
        const Matrix m = translation(away ? 7.0f : 0.05f, 0, 2), inverted = inverse(m);
        std::copy(m.begin(), m.end(), transform->transform);
        std::copy(inverted.begin(), inverted.end(), transform->invTransform);
        OptixTraversableHandle handle = 0;
        ASSERT_OK(optixConvertPointerToTraversableHandle(
            context_, memory.address(), OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, &handle));
        EXPECT_EQ(away ? 1u : 2u, trace(handle));
        InstanceList top({instanceOf(handle, identity())});
        EXPECT_EQ(away ? 1u : 2u, trace(buildAccel(context_, log_, {top.input}).handle));
    }
    const auto refuse = [&](CUdeviceptr pointer, unsigned type, const char* mention) {
        OptixTraversableHandle handle = 0;
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixConvertPointerToTraversableHandle",
                        mention,
                        optixConvertPointerToTraversableHandle(
                            context_, pointer, OptixTraversableType(type), &handle));
        EXPECT_EQ(0u, handle);
    };
    refuse(0, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, "pointer");
    refuse(memory.address() + 16, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, "64");
    refuse(memory.address(), 7, "traversableType");
    EXPECT_REJECTED(
        OPTIX_ERROR_INVALID_VALUE, "optixConvertPointerToTraversableHandle", "traversableHandle",
        optixConvertPointerToTraversableHandle(context_, memory.address(),
                                               OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, nullptr));
}

TEST_P(AccelAccess, CopiesAreRelocated) {
    TriangleMesh mesh(kTwoTriangles, {0, 1, 2});
    auto gas = std::make_unique<Accel>(buildAccel(context_, log_, {mesh.input}));
    InstanceList top({instanceOf(gas->handle, translation(0.05f, 0, 0), 3)});
    auto ias = std::make_unique<Accel>(buildAccel(context_, log_, {top.input}));
    OptixAccelRelocationInfo gasInfo{}, iasInfo{};
    ASSERT_OK(optixAccelGetRelocationInfo(context_, gas->handle, &gasInfo));
    ASSERT_OK(optixAccelGetRelocationInfo(context_, ias->handle, &iasInfo));
    int compatible = 0;
    ASSERT_OK(optixAccelCheckRelocationCompatibility(context_, &gasInfo, &compatible));
    EXPECT_EQ(1, compatible);
    Buffer newGas(gas->memory.size()), newIas(ias->memory.size());
    std::memcpy(newGas.as<void>(), gas->memory.as<void>(), newGas.size());
    std::memcpy(newIas.as<void>(), ias->memory.as<void>(), newIas.size());
    const OptixTraversableHandle oldIas = ias->handle;
    OptixTraversableHandle handle = 0, parent = 0;
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &gasInfo, 0, 0, newGas.address(), newGas.size(),
                                 &handle));
    Buffer children(std::vector<OptixTraversableHandle>{handle});
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &iasInfo, 0, 0, newIas.address(), newIas.size(),
                                 &parent));
    EXPECT_EQ(2u, trace(parent)); // with the old child
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &iasInfo, children.address(), 1,
                                 newIas.address(), newIas.size(), &parent));
    waitForDevice();
    EXPECT_NE(oldIas, parent);
    std::memset(gas->memory.as<void>(), 0xA5, gas->memory.size());
    std::memset(ias->memory.as<void>(), 0xA5, ias->memory.size());
    ias.reset();
    gas.reset();
    EXPECT_EQ(2u, trace(handle));
    EXPECT_EQ(2u, trace(parent));
    // No ray enters a null child, even if the instance had another child before.
    const Buffer none(std::vector<OptixTraversableHandle>{0});
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &iasInfo, none.address(), 1, newIas.address(),
                                 newIas.size(), &parent));
    waitForDevice();
    EXPECT_EQ(1u, trace(parent));
}

TEST_P(AccelAccess, RelocationRefusesWhatIsNoCopy) {
    TriangleMesh mesh(kTwoTriangles, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    OptixAccelRelocationInfo info{}, garbage{{1, 2, 3, 4}};
    const char* const kGet = "optixAccelGetRelocationInfo";
    for (OptixTraversableHandle bad :
         {OptixTraversableHandle(0), OptixTraversableHandle(1), gas.handle + 1, gas.handle - 1,
          OptixTraversableHandle(0x12345681)})
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kGet, "handle",
                        optixAccelGetRelocationInfo(context_, bad, &info));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kGet, "info",
                    optixAccelGetRelocationInfo(context_, gas.handle, nullptr));
    log_.clear();
    ASSERT_OK(optixAccelGetRelocationInfo(context_, gas.handle, &info));
    int compatible = 9;
    EXPECT_OK(optixAccelCheckRelocationCompatibility(context_, &garbage, &compatible));
    EXPECT_EQ(0, compatible);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelCheckRelocationCompatibility",
                    "compatible", optixAccelCheckRelocationCompatibility(context_, &info, nullptr));
    Buffer target(gas.memory.size()), handles(16);
    OptixTraversableHandle handle = 0;
    const auto refuse = [&](const char* mention, const OptixAccelRelocationInfo* from,
                            CUdeviceptr children, size_t count, CUdeviceptr to, size_t size) {
        EXPECT_REJECTED(
            OPTIX_ERROR_INVALID_VALUE, "optixAccelRelocate", mention,
            optixAccelRelocate(context_, nullptr, from, children, count, to, size, &handle));
    };
    refuse("info", nullptr, 0, 0, target.address(), target.size());
    refuse("info", &garbage, 0, 0, target.address(), target.size());
    refuse("targetAccel", &info, 0, 0, 0, target.size());
    refuse("targetAccel", &info, 0, 0, target.address() + 64, target.size() - 64);
    refuse("targetAccelSizeInBytes", &info, 0, 0, target.address(), 128);
    refuse("numInstanceTraversableHandles", &info, handles.address(), 1, target.address(),
           target.size());
    EXPECT_EQ(0u, handle);
}

// Handles of all tags into unmapped memory, unreadable memory, and memory with other contents:
// misses.
TEST_P(AccelAccess, GarbageTraversablesMiss) {
    // The addresses are far from usual allocations, because another test may have had a transform
    // there, and a buffer of this test may get unmapped memory.
    const auto map = [](size_t place, int access) {
        void* const hint = reinterpret_cast<void*>(0x3f0000000000 + place * 0x100000);
        return mmap(hint, 8192, access, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    };
    void* const mapped = map(0, PROT_READ | PROT_WRITE);
    void* const closed = map(1, PROT_NONE);
    void* const gone = map(2, PROT_READ);
    for (void* each : {mapped, closed, gone})
        ASSERT_NE(MAP_FAILED, each);
    munmap(gone, 8192);
    for (unsigned long long address :
         {0ull, 4096ull, (unsigned long long)mapped, (unsigned long long)gone,
          (unsigned long long)closed, 0x7ffffffff000ull, 0x800000000000ull, ~0ull})
        for (unsigned tag = 0; tag < 64; ++tag)
            EXPECT_EQ(1u, trace((address & ~63ull) | tag)) << address << " " << tag;
    // The same below a static transform and an instance.
    Buffer memory(sizeof(OptixStaticTransform), 64);
    memory.as<OptixStaticTransform>()->child = (unsigned long long)gone | 1;
    OptixTraversableHandle handle = 0;
    ASSERT_OK(optixConvertPointerToTraversableHandle(
        context_, memory.address(), OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, &handle));
    EXPECT_EQ(1u, trace(handle));
    memory.as<OptixStaticTransform>()->child = handle; // a loop
    EXPECT_EQ(1u, trace(handle));
    InstanceList top({instanceOf((unsigned long long)gone | 1, identity()),
                      instanceOf(handle, identity()), instanceOf(0x1001, identity())});
    EXPECT_EQ(1u, trace(buildAccel(context_, log_, {top.input}).handle));
    munmap(mapped, 8192);
    munmap(closed, 8192);
    buildAccel(context_, log_, {top.input}); // reports the build before
    EXPECT_NE(std::string::npos, log_.all().find("never hit")) << log_.all();
    log_.clear();
    EXPECT_EQ(1u, trace(0));
    EXPECT_EQ(std::string::npos, log_.all().find("traversable")) << log_.all();
    EXPECT_EQ(1u, trace(0x1001));
    EXPECT_NE(std::string::npos, log_.all().find("the handle 0x1001, which is no traversable"))
        << log_.all();
}

// Launches always check the structure that rays of the last launches used, and with debug
// exceptions all structures.
TEST_P(AccelAccess, FreedStructuresMiss) {
    if (!onGpu())
        GTEST_SKIP() << "only a GPU's driver says which memory was freed";
    TriangleMesh mesh(kTwoTriangles, {0, 1, 2});
    OptixTraversableHandle handle = 0;
    size_t bytes = 0;
    {
        const Accel gas = buildAccel(context_, log_, {mesh.input});
        handle = gas.handle;
        bytes = gas.memory.size();
        for (unsigned i = 0; i < 3; ++i)
            EXPECT_EQ(2u, trace(handle));
    }
    EXPECT_EQ(1u, trace(handle));
    // The memory is reused.
    std::vector<Buffer> others;
    bool isThereAgain = false;
    for (unsigned i = 0; i < 8; ++i) {
        others.emplace_back(std::vector<uint8_t>(bytes, 0xA5), 128);
        isThereAgain |= others.back().address() / 128 == handle / 128;
    }
    EXPECT_EQ(1u, trace(handle)) << isThereAgain;
    others.clear();
    const Accel again = buildAccel(context_, log_, {mesh.input}); // there again, perhaps
    EXPECT_EQ(2u, trace(again.handle));
}

// A transform's memory may be freed and later hold another transform with the same handle.
TEST_P(AccelAccess, FreedTransformsMiss) {
    if (!onGpu())
        GTEST_SKIP() << "only a GPU's driver says which memory was freed";
    TriangleMesh mesh(kTwoTriangles, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    OptixTraversableHandle handle = 0;
    const auto make = [&] {
        auto memory = std::make_unique<Buffer>(512, 64);
        const Matrix one = identity();
        auto* transform = memory->as<OptixStaticTransform>();
        transform->child = gas.handle;
        std::copy(one.begin(), one.end(), transform->transform);
        std::copy(one.begin(), one.end(), transform->invTransform);
        EXPECT_OK(optixConvertPointerToTraversableHandle(
            context_, memory->address(), OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, &handle));
        return memory;
    };
    for (unsigned i = 0; i < 3; ++i) {
        const auto transform = make();
        EXPECT_EQ(2u, trace(handle));
    }
    EXPECT_EQ(1u, trace(handle));
}

INSTANTIATE_DEVICE_TEST(AccelAccess);

} // namespace
} // namespace tests::api
