// SPDX-License-Identifier: Apache-2.0
// sunstone/rays.h: each function, wrong arguments, and device arrays of the CPU device
// (RAYS_TEST_CUDA).
#include "../prime/fixture.h"

#include "sunstone/rays.h"

#ifdef RAYS_TEST_CUDA
#include "cuda.h"
#endif

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace {

using namespace sunstone::rays;
using prime_test::randomRays;
using prime_test::soup;
using prime_test::wrongHits;

std::vector<sunstone::rays::Ray> convert(const std::vector<prime_test::Ray>& rays) {
    static_assert(sizeof(prime_test::Ray) == sizeof(SunstoneRay));
    std::vector<sunstone::rays::Ray> result(rays.size());
    std::memcpy(static_cast<void*>(result.data()), rays.data(), rays.size() * sizeof(rays[0]));
    return result;
}
std::vector<prime_test::Hit> convert(const std::vector<sunstone::rays::Hit>& hits) {
    static_assert(sizeof(prime_test::Hit) == sizeof(SunstoneHit));
    std::vector<prime_test::Hit> result(hits.size());
    std::memcpy(static_cast<void*>(result.data()), hits.data(), hits.size() * sizeof(hits[0]));
    return result;
}
SunstoneMesh meshOf(const prime_test::Mesh& mesh) {
    return {&mesh.vertices[0].x, mesh.vertices.size(), &mesh.triangles[0].x, mesh.triangles.size()};
}

TEST(Rays, ClosestAndAnyHits) {
    const prime_test::Mesh mesh = soup(300, 0.3f, 1);
    const auto rays = randomRays(1000, 2);
    const Scene scene(meshOf(mesh));
    EXPECT_EQ(wrongHits(mesh, rays, convert(scene.closest(convert(rays)))), 0u);
    EXPECT_EQ(wrongHits(mesh, rays, convert(scene.any(convert(rays))), true), 0u);
    SunstoneMesh flat = meshOf(mesh);
    flat.triangles = nullptr;
    const Scene other(flat);
    EXPECT_EQ(wrongHits(mesh, rays, convert(other.closest(convert(rays)))), 0u);
}

TEST(Rays, AllHitsBeginWithTheClosest) {
    const prime_test::Mesh mesh = soup(300, 0.6f, 1);
    const auto rays = convert(randomRays(3000, 3));
    const Scene scene(meshOf(mesh));
    std::vector<size_t> offsets;
    const std::vector<Hit> all = scene.all(rays, offsets), closest = scene.closest(rays);
    ASSERT_EQ(offsets.size(), rays.size() + 1);
    ASSERT_EQ(offsets.back(), all.size());
    EXPECT_GT(all.size(), 2 * rays.size());
    for (size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(offsets[i] == offsets[i + 1], closest[i].t < 0);
        if (closest[i].t >= 0) {
            EXPECT_EQ(std::memcmp(&all[offsets[i]], &closest[i], sizeof(Hit)), 0);
        }
        for (size_t k = offsets[i]; k + 1 < offsets[i + 1]; ++k)
            EXPECT_LE(all[k].t, all[k + 1].t);
    }
    // Without room, only the offsets are written.
    std::vector<Hit> few(10, Hit{7, 7, 7, 7, 7});
    EXPECT_EQ(sunstoneAllHits(scene.handle(), rays.data(), rays.size(), few.data(), few.size(),
                              offsets.data()),
              SUNSTONE_TOO_SMALL);
    EXPECT_EQ(offsets.back(), all.size());
    EXPECT_EQ(few[0].t, 7);
    EXPECT_EQ(sunstoneAllHits(scene.handle(), rays.data(), rays.size(), nullptr, 0, offsets.data()),
              SUNSTONE_TOO_SMALL);
}

// Structures refer to long thin triangles more than once.
TEST(Rays, AllHitsNameEachTriangleOnce) {
    const prime_test::Mesh mesh = soup(60, 8, 1);
    const auto rays = convert(randomRays(1000, 3));
    const Scene scene(meshOf(mesh));
    std::vector<size_t> offsets;
    const std::vector<Hit> all = scene.all(rays, offsets);
    size_t most = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        std::vector<int> triangles;
        for (size_t k = offsets[i]; k < offsets[i + 1]; ++k)
            triangles.push_back(all[k].triangle);
        most = std::max(most, triangles.size());
        std::sort(triangles.begin(), triangles.end());
        EXPECT_EQ(std::adjacent_find(triangles.begin(), triangles.end()), triangles.end()) << i;
    }
    EXPECT_GT(most, 5u);
    std::vector<Hit> exact(all.size());
    EXPECT_EQ(sunstoneAllHits(scene.handle(), rays.data(), rays.size(), exact.data(), exact.size(),
                              offsets.data()),
              SUNSTONE_OK);
}

TEST(Rays, NearestPoints) {
    // A square of side 2 in the plane z = 0.
    const Scene scene({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, {0, 1, 2, 0, 2, 3});
    const std::vector<Nearest> found =
        scene.nearest({0.5f, -0.5f, 3, 4, 0, 0, 4, 5, 0, 0, 0, 30}, 10);
    EXPECT_FLOAT_EQ(found[0].distance, 3);
    EXPECT_FLOAT_EQ(found[0].point[0], 0.5f);
    EXPECT_FLOAT_EQ(found[0].point[2], 0);
    EXPECT_FLOAT_EQ(found[1].distance, 3);
    EXPECT_FLOAT_EQ(found[2].distance, 5);
    EXPECT_FLOAT_EQ(found[2].point[1], 1);
    EXPECT_LT(found[3].distance, 0);
    EXPECT_EQ(found[3].triangle, -1);
}

TEST(Rays, NearestPointsOfAllSizes) {
    for (const float size : {1e-15f, 1e-12f, 1e-11f, 1e-6f, 1e6f, 3e9f, 1e12f, 1e15f, 1e18f}) {
        const Scene scene(
            {-size, -size, 5 * size, 3 * size, -size, 5 * size, -size, 3 * size, 5 * size},
            {0, 1, 2});
        const std::vector<Nearest> found =
            scene.nearest({0.125f * size, 0.25f * size, 0}, INFINITY);
        EXPECT_EQ(found[0].triangle, 0) << size;
        EXPECT_NEAR(found[0].distance / size, 5, 1e-6) << size;
        EXPECT_NEAR(found[0].point[0] / size, 0.125, 1e-6) << size;
    }
}

// Coordinates are exact, so distances have only their last rounding.
TEST(Rays, NearestPointsFarFromTheOrigin) {
    const float far = 1e6f;
    const Scene scene({far - 1, far - 1, 0, far + 3, far - 1, 0.5f, far - 1, far + 3, 0.25f},
                      {0, 1, 2});
    const std::vector<Nearest> found = scene.nearest({far + 0.5f, far + 0.25f, 2}, INFINITY);
    const double normal[3] = {-2, -1, 16};
    const double expected = (1.5 * normal[0] + 1.25 * normal[1] + 2 * normal[2]) / std::sqrt(261.0);
    EXPECT_NEAR(found[0].distance, expected, 1e-6);
}

TEST(Rays, ForkedChildrenSayWhyTheyFail) {
    const Scene scene({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2});
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        SunstoneHit hit;
        const SunstoneRay ray = {};
        const bool fails = sunstoneClosestHits(scene.handle(), &ray, 1, &hit) == SUNSTONE_FAILED;
        _exit(fails && std::strstr(sunstoneLastError(), "fork") ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
}

TEST(Rays, InstancesOutliveTheirScenes) {
    const prime_test::Mesh mesh = soup(100, 0.4f, 1);
    const float rows[12] = {0, -1, 0, 0.5f, 1, 0, 0, -0.25f, 0, 0, 2, 0};
    Scene top;
    {
        const Scene scene(meshOf(mesh));
        SunstoneInstance instance = {scene.handle(), {}};
        std::copy(rows, rows + 12, instance.transform);
        top = Scene(std::vector<SunstoneInstance>{instance});
    }
    const auto rays = randomRays(500, 4);
    EXPECT_EQ(wrongHits(prime_test::moved(mesh, rows), rays, convert(top.closest(convert(rays)))),
              0u);
    EXPECT_LT(top.nearest({0, 0, 0}, 5)[0].distance, 5);
}

TEST(Rays, WrongArguments) {
    const prime_test::Mesh mesh = soup(3, 0.4f, 1);
    const Scene scene(meshOf(mesh));
    SunstoneScene out = nullptr;
    SunstoneRay ray = {{0, 0, 0}, 0, {0, 0, 1}, 1};
    SunstoneHit hit = {7, 7, 7, 7, 7};
    size_t offsets[2];
    SunstoneNearest nearest;
    const float point[3] = {};
    EXPECT_EQ(sunstoneSceneCreate(nullptr, &out), SUNSTONE_INVALID_VALUE);
    SunstoneMesh wrong = meshOf(mesh);
    EXPECT_EQ(sunstoneSceneCreate(&wrong, nullptr), SUNSTONE_INVALID_VALUE);
    wrong.vertices = nullptr;
    EXPECT_EQ(sunstoneSceneCreate(&wrong, &out), SUNSTONE_INVALID_VALUE);
    EXPECT_NE(std::string(sunstoneLastError()).find("vertices"), std::string::npos);
    wrong = meshOf(mesh);
    wrong.triangles = nullptr;
    wrong.vertexCount = 4;
    EXPECT_EQ(sunstoneSceneCreate(&wrong, &out), SUNSTONE_INVALID_VALUE);
    wrong.vertexCount = ~size_t(0);
    EXPECT_EQ(sunstoneSceneCreate(&wrong, &out), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(out, nullptr);
    const auto dead = reinterpret_cast<SunstoneScene>(uintptr_t(0x1234));
    EXPECT_EQ(sunstoneSceneDestroy(nullptr), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneSceneDestroy(dead), SUNSTONE_INVALID_HANDLE);
    EXPECT_EQ(sunstoneClosestHits(dead, &ray, 1, &hit), SUNSTONE_INVALID_HANDLE);
    EXPECT_EQ(sunstoneAnyHits(dead, &ray, 1, &hit), SUNSTONE_INVALID_HANDLE);
    EXPECT_EQ(sunstoneAllHits(dead, &ray, 1, &hit, 1, offsets), SUNSTONE_INVALID_HANDLE);
    EXPECT_EQ(sunstoneNearestPoints(dead, point, 1, 1, &nearest), SUNSTONE_INVALID_HANDLE);
    const SunstoneScene live = scene.handle();
    EXPECT_EQ(sunstoneClosestHits(live, nullptr, 1, &hit), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneClosestHits(live, &ray, 1, nullptr), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneClosestHits(live, &ray, ~size_t(0), &hit), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneAnyHits(live, &ray, size_t(1) << 40, &hit), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneAllHits(live, &ray, 1, &hit, 1, nullptr), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneAllHits(live, &ray, 1, nullptr, 1, offsets), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneNearestPoints(live, point, 1, NAN, &nearest), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneNearestPoints(live, point, 1, -1, &nearest), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneNearestPoints(live, nullptr, 1, 1, &nearest), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneNearestPoints(live, point, 1, 1, nullptr), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(hit.t, 7);
    EXPECT_EQ(sunstoneClosestHits(live, nullptr, 0, nullptr), SUNSTONE_OK);
    SunstoneInstance instance = {nullptr, {}};
    EXPECT_EQ(sunstoneSceneCreateInstances(&instance, 1, &out), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneSceneCreateInstances(nullptr, 1, &out), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneSceneCreateInstances(&instance, 1, nullptr), SUNSTONE_INVALID_VALUE);
    instance.scene = dead;
    EXPECT_EQ(sunstoneSceneCreateInstances(&instance, 1, &out), SUNSTONE_INVALID_HANDLE);
    instance.scene = live;
    instance.transform[0] = instance.transform[5] = instance.transform[10] = 1;
    ASSERT_EQ(sunstoneSceneCreateInstances(&instance, 1, &out), SUNSTONE_OK);
    SunstoneScene nested = nullptr;
    instance.scene = out;
    EXPECT_EQ(sunstoneSceneCreateInstances(&instance, 1, &nested), SUNSTONE_INVALID_VALUE);
    EXPECT_EQ(sunstoneSceneDestroy(out), SUNSTONE_OK);
    EXPECT_EQ(sunstoneSceneDestroy(out), SUNSTONE_INVALID_HANDLE);
    const float four[] = {0, 0, 0, 1};
    EXPECT_THROW(Scene(SunstoneMesh{four, 1, nullptr, 0}), Error) << "one vertex is no triangle";
}

TEST(Rays, SceneWithoutTriangles) {
    const std::vector<float> vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const SunstoneRay ray = {{0.2f, 0.2f, 1}, 0, {0, 0, -1}, 10};
    EXPECT_LT(Scene(vertices, std::vector<int32_t>{}).closest({ray})[0].t, 0);
    EXPECT_LT(Scene(std::vector<float>{}, std::vector<int32_t>{}).closest({ray})[0].t, 0);
    EXPECT_EQ(Scene(SunstoneMesh{vertices.data(), 3, nullptr, 0}).closest({ray})[0].t, 1);
}

#ifdef RAYS_TEST_CUDA
TEST(Rays, DeviceArrays) {
    CUcontext context = nullptr;
    ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
    ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    const prime_test::Mesh mesh = soup(300, 0.3f, 1);
    const auto rays = randomRays(1000, 2);
    const auto upload = [](const void* data, size_t bytes) {
        CUdeviceptr address = 0;
        EXPECT_EQ(cuMemAlloc(&address, bytes), CUDA_SUCCESS);
        if (data) {
            EXPECT_EQ(cuMemcpyHtoD(address, data, bytes), CUDA_SUCCESS);
        }
        return address;
    };
    const CUdeviceptr vertices = upload(mesh.vertices.data(), mesh.vertices.size() * 12),
                      triangles = upload(mesh.triangles.data(), mesh.triangles.size() * 12),
                      in = upload(rays.data(), rays.size() * sizeof(SunstoneRay)),
                      out = upload(nullptr, rays.size() * sizeof(SunstoneHit));
    const SunstoneMesh onDevice = {reinterpret_cast<const float*>(vertices), mesh.vertices.size(),
                                   reinterpret_cast<const int32_t*>(triangles),
                                   mesh.triangles.size()};
    {
        const Scene scene(onDevice);
        ASSERT_EQ(sunstoneClosestHits(scene.handle(), reinterpret_cast<SunstoneRay*>(in),
                                      rays.size(), reinterpret_cast<SunstoneHit*>(out)),
                  SUNSTONE_OK)
            << sunstoneLastError();
        std::vector<prime_test::Hit> hits(rays.size());
        ASSERT_EQ(cuMemcpyDtoH(hits.data(), out, hits.size() * sizeof(hits[0])), CUDA_SUCCESS);
        EXPECT_EQ(wrongHits(mesh, rays, hits), 0u);
        // Freed ones, which the host could still read.
        const CUdeviceptr freed = upload(rays.data(), rays.size() * sizeof(SunstoneRay));
        ASSERT_EQ(cuMemFree(freed), CUDA_SUCCESS);
        EXPECT_EQ(sunstoneClosestHits(scene.handle(), reinterpret_cast<SunstoneRay*>(freed),
                                      rays.size(), reinterpret_cast<SunstoneHit*>(out)),
                  SUNSTONE_INVALID_VALUE);
        // Arrays of the host, too; and ranges beyond the allocation.
        EXPECT_EQ(wrongHits(mesh, rays, convert(scene.closest(convert(rays)))), 0u);
        EXPECT_EQ(sunstoneClosestHits(scene.handle(), reinterpret_cast<SunstoneRay*>(in),
                                      rays.size() << 12, reinterpret_cast<SunstoneHit*>(out)),
                  SUNSTONE_INVALID_VALUE);
        const Scene host(meshOf(mesh));
        EXPECT_EQ(sunstoneClosestHits(host.handle(), reinterpret_cast<SunstoneRay*>(in),
                                      rays.size(), reinterpret_cast<SunstoneHit*>(out)),
                  SUNSTONE_NOT_SUPPORTED);
    }
    for (const CUdeviceptr address : {vertices, triangles, in, out})
        cuMemFree(address);
}
#endif

} // namespace
