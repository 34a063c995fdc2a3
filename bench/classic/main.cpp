// SPDX-License-Identifier: Apache-2.0
// Compares one path tracer through the classic API and through OptiX 7, in one process with
// alternating launches; then measures the costs of changes in a classic scene. On a machine with a
// GPU both run on it.
//   bench_classic [--quick | --changes]     small scenes; changes alone
// The best of several launches counts.
#include "../scenes.h"
#include "twins.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace twin {

std::string readDeviceCode(const char* path) {
    namespace fs = std::filesystem;
    const fs::path beside =
        fs::read_symlink("/proc/self/exe").parent_path() / fs::path(path).filename();
    std::ifstream file(fs::exists(beside) ? beside : fs::path(path));
    return std::string(std::istreambuf_iterator<char>(file), {});
}

} // namespace twin

namespace {

using namespace twin;

constexpr std::array<float, 12> kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

Camera cameraOf(const bench::Mesh& mesh) {
    Camera c{};
    float forward[3], length = 0;
    for (int i = 0; i < 3; ++i) {
        forward[i] = mesh.target[i] - mesh.eye[i];
        length += forward[i] * forward[i];
    }
    length = std::sqrt(length);
    for (int i = 0; i < 3; ++i) {
        c.eye[i] = mesh.eye[i];
        c.forward[i] = forward[i] / length;
    }
    const float side = std::sqrt(c.forward[0] * c.forward[0] + c.forward[2] * c.forward[2]);
    const float right[3] = {-c.forward[2] / side, 0, c.forward[0] / side};
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        c.right[i] = right[i] * 0.6f;
        c.up[i] = (right[j] * c.forward[k] - right[k] * c.forward[j]) * 0.5f;
    }
    return c;
}

Scene meshScene(bench::SceneKind kind, unsigned triangles) {
    const bench::Mesh mesh = bench::makeScene(kind, triangles);
    return {mesh.name, mesh.vertices, mesh.indices, {}, {kIdentity}, cameraOf(mesh)};
}

// A cube of copies of a mesh.
Scene instancedScene(unsigned copies) {
    const bench::Mesh mesh = bench::makeScene(bench::SceneKind::kSpheres, 20000);
    Scene scene{mesh.name + ", instances", mesh.vertices, mesh.indices, {}, {}, cameraOf(mesh)};
    const unsigned edge = unsigned(std::ceil(std::cbrt(double(copies))));
    float reach = 0;
    for (const float v : mesh.vertices)
        reach = std::max(reach, std::fabs(v));
    for (unsigned i = 0; i < copies; ++i) {
        std::array<float, 12> m{};
        const float scale = 1.0f / float(edge);
        m[0] = m[5] = m[10] = scale;
        m[3] = (2 * float(i % edge) + 1 - float(edge)) * scale * reach;
        m[7] = (2 * float(i / edge % edge) + 1 - float(edge)) * scale * reach;
        m[11] = (2 * float(i / edge / edge) + 1 - float(edge)) * scale * reach;
        scene.instances.push_back(m);
    }
    return scene;
}

Scene sphereScene(unsigned count) {
    const bench::Mesh mesh = bench::makeScene(bench::SceneKind::kTerrain, count * 2);
    Scene scene{"custom spheres", {}, {}, {}, {kIdentity}, cameraOf(mesh)};
    const float radius = mesh.aoRadius * 0.1f;
    for (size_t i = 0; i + 2 < mesh.vertices.size(); i += 3) {
        scene.spheres.insert(scene.spheres.end(), &mesh.vertices[i], &mesh.vertices[i] + 3);
        scene.spheres.push_back(radius);
    }
    return scene;
}

double seconds(Renderer& renderer) {
    const auto begin = std::chrono::steady_clock::now();
    renderer.launch();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// The number of pixels that differ between two pictures.
size_t differences(const std::vector<float>& a, const std::vector<float>& b) {
    size_t count = 0;
    for (size_t i = 0; i < a.size(); i += 4)
        count += std::memcmp(&a[i], &b[i], 16) != 0;
    return count;
}

void compare(const Scene& scene, bool quick) {
    const unsigned width = quick ? 320 : 1280, height = quick ? 180 : 720, samples = quick ? 2 : 8;
    const auto classic = makeClassic(scene, width, height, samples);
    const auto optix7 = makeOptix7(scene, width, height, samples);
    double first = seconds(*classic), best6 = 1e9, best7 = seconds(*optix7);
    best7 = 1e9;
    for (int i = 0; i < (quick ? 3 : 7); ++i) {
        best6 = std::min(best6, seconds(*classic));
        best7 = std::min(best7, seconds(*optix7));
    }
    const size_t other = differences(classic->picture(), optix7->picture());
    std::printf("%-28s %9.2f %9.2f %7.2f   %zu of %u pixels, first launch %.0f ms\n",
                scene.name.c_str(), best6 * 1e3, best7 * 1e3, best7 / best6, other, width * height,
                first * 1e3);
    std::fflush(stdout);
}

void compareAll(bool quick) {
    std::printf("%-28s %9s %9s %7s   %s\n", "path tracer", "classic", "OptiX 7", "speed",
                "pictures differ in");
    compare(meshScene(bench::SceneKind::kTerrain, quick ? 20000 : 500000), quick);
    compare(meshScene(bench::SceneKind::kSoup, quick ? 20000 : 200000), quick);
    compare(sphereScene(quick ? 5000 : 100000), quick);
    compare(instancedScene(quick ? 64 : 1000), quick);
}

} // namespace

int main(int argc, char** argv) {
    const auto given = [&](const char* option) {
        return argc > 1 && std::strcmp(argv[1], option) == 0;
    };
    const bool quick = given("--quick"), changes = given("--changes");
    if (argc > 1 && !quick && !changes) {
        std::printf("usage: bench_classic [--quick | --changes]\n");
        return std::strcmp(argv[1], "--help") == 0 ? 0 : 2;
    }
    try {
        if (!changes)
            compareAll(quick);
        const ClassicTimes times = timeClassic(instancedScene(quick ? 1000 : 10000));
        std::printf("\n1460 programs of 5 names: %.1f ms\n"
                    "launch of 8 x 8: %.3f ms; after a change of a transform %.3f ms, of a "
                    "material's variable %.3f ms\n"
                    "100 programs of as many texts without caches: %.0f ms; the first launch with "
                    "them %.0f ms\n",
                    times.createPrograms, times.smallLaunch, times.moveInstance, times.setVariable,
                    times.createMany, times.firstLaunch);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_classic: %s\n", error.what());
        return 1;
    }
    return 0;
}
