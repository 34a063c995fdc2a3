// SPDX-License-Identifier: Apache-2.0
// Traversal kernels and builders against Embree 3 on identical ray arrays, one ray at a time.
//   bench_kernels [--quick] [--scene N] [--isa avx512|avx2|baseline] [--threads] [--refit]
//                 [--fast-build | --fast-trace] [--motion] [--builds N]
// --builds: only N builds of each side, processor time.
// Runs alternate between the two; the best of several counts. Meshes and Sunstone's structure are
// in memory with huge pages, like device memory and Embree's memory. Single-thread rows are
// processor time.
#include "launch_rays.h"
#include "scenes.h"

#include "bvh/build/build.h"
#include "bvh/layout.h"
#include "bvh/walk/kernels.h"

#include <embree3/rtcore.h>
#include <sys/mman.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>

namespace {

using namespace bench;
using namespace sunstone;

double seconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Processor time of this thread, which other programs on the machine disturb less than elapsed
// time.
double threadSeconds(const std::function<void()>& work) {
    const auto now = [] {
        timespec t;
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double start = now();
    work();
    return now() - start;
}

struct Block {
    void* memory = nullptr;
    size_t capacity = 0;
    ~Block() { std::free(memory); }
    void reserve(size_t size) {
        if (capacity >= size)
            return;
        std::free(memory);
        constexpr size_t kHugePage = 1u << 21;
        const size_t padded = (size + kHugePage - 1) / kHugePage * kHugePage;
        memory = std::aligned_alloc(kHugePage, padded);
        madvise(memory, padded, MADV_HUGEPAGE);
        capacity = size;
    }
};

// A mesh in memory with huge pages, like that of the device and of Embree.
struct MeshMemory {
    Block vertices, indices;
    explicit MeshMemory(const Mesh& mesh) {
        const auto fill = [](Block& block, const auto& from) {
            const size_t size = from.size() * sizeof(from[0]);
            block.reserve(size + 16); // Embree reads 16 bytes at the last vertex
            std::memcpy(block.memory, from.data(), size);
        };
        fill(vertices, mesh.vertices);
        fill(indices, mesh.indices);
    }
};

bvh::TriangleInput inputOf(const Mesh& mesh, const MeshMemory& memory) {
    bvh::TriangleInput input;
    input.vertices = memory.vertices.memory;
    input.numVertices = mesh.numVertices();
    input.indices = memory.indices.memory;
    input.indexFormat = bvh::IndexFormat::kUint3;
    input.numTriangles = mesh.numTriangles();
    return input;
}

RTCScene embreeScene(RTCDevice device, const Mesh& mesh, const MeshMemory& memory,
                      const std::vector<float>& moved) {
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               memory.vertices.memory, 0, 12, mesh.numVertices());
    if (!moved.empty()) {
        rtcSetGeometryTimeStepCount(geometry, 2);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3,
                                   moved.data(), 0, 12, mesh.numVertices());
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               memory.indices.memory, 0, 12, mesh.numTriangles());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    return scene;
}

RTCRay embreeRay(const Ray& r, float time) {
    RTCRay ray = {};
    ray.org_x = r.origin[0], ray.org_y = r.origin[1], ray.org_z = r.origin[2];
    ray.dir_x = r.direction[0], ray.dir_y = r.direction[1], ray.dir_z = r.direction[2];
    ray.tnear = r.tmin, ray.tfar = r.tmax, ray.mask = ~0u, ray.time = time;
    return ray;
}

struct Contest {
    double ours = 0, embree = 0; // rays per second, best run
    uint64_t hitsOurs = 0, hitsEmbree = 0;
};

using RayLoop = std::function<uint64_t(size_t begin, size_t end)>;

uint64_t runLoop(const RayLoop& loop, size_t count, bool allThreads) {
    if (!allThreads)
        return loop(0, count);
    std::atomic<uint64_t> hits{0};
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, count, 4096),
        [&](const tbb::blocked_range<size_t>& range) { hits += loop(range.begin(), range.end()); });
    return hits;
}

Contest contest(const RayLoop& ours, const RayLoop& embree, size_t count, bool allThreads,
                int repeats) {
    Contest c;
    for (int i = 0; i < repeats; ++i) {
        const auto time = allThreads ? seconds : threadSeconds;
        const double a = time([&] { c.hitsOurs = runLoop(ours, count, allThreads); });
        const double b = time([&] { c.hitsEmbree = runLoop(embree, count, allThreads); });
        c.ours = std::max(c.ours, double(count) / a);
        c.embree = std::max(c.embree, double(count) / b);
    }
    return c;
}

void print(const char* scene, const char* rays, const Contest& c, bool allThreads) {
    std::printf("| %-9s | %-8s | %-4s | %7.2f | %7.2f | %5.2f | %+.4f%% |\n", scene, rays,
                allThreads ? "all" : "1", c.ours * 1e-6, c.embree * 1e-6, c.ours / c.embree,
                100.0 * (double(c.hitsOurs) - double(c.hitsEmbree)) /
                    double(std::max<uint64_t>(1, c.hitsEmbree)));
    std::fflush(stdout);
}

struct Options {
    bool quick = false, threads = false, fastBuild = false, fastTrace = false, refit = false,
         motion = false;
    int scene = -1, builds = 0;
    bvh::Isa isa = bvh::chosenIsa();
};

// Processor time of all threads.
double processSeconds(const std::function<void()>& work) {
    const auto now = [] {
        timespec t;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double start = now();
    work();
    return now() - start;
}

// Builds and updates of a structure alternate, so that other load disturbs both; the result is the
// median of the pairs' ratios.
void benchRefit(const Mesh& mesh, const bvh::BuildInputs& inputs, bvh::BuildOptions options) {
    options.allowUpdate = true;
    const bvh::MemoryUsage usage = bvh::computeMemoryUsage(inputs, options);
    Block temp, output;
    temp.reserve(usage.temp);
    output.reserve(usage.output);
    std::vector<double> builds, refits, ratios;
    for (int i = 0; i < 9; ++i) {
        builds.push_back(processSeconds([&] {
            bvh::build(inputs, options, temp.memory, temp.capacity, output.memory,
                       output.capacity);
        }));
        refits.push_back(processSeconds([&] {
            bvh::update(inputs, options, temp.memory, temp.capacity, output.memory,
                        output.capacity);
        }));
        ratios.push_back(builds.back() / refits.back());
    }
    const auto median = [](std::vector<double>& values) {
        std::sort(values.begin(), values.end());
        return values[values.size() / 2];
    };
    const double build = median(builds) * 1e3, refit = median(refits) * 1e3;
    std::printf("| %-9s | refit    | sum  | %7.1f | rebuild | %5.1f | rebuild takes %.0f ms |\n",
                mesh.name.c_str(), refit, median(ratios), build);
    std::fflush(stdout);
}

void printBuilds(const char* scene, std::vector<double> ours, std::vector<double> embree) {
    std::vector<double> ratios;
    for (size_t i = 0; i < ours.size(); ++i)
        ratios.push_back(embree[i] / ours[i]);
    for (std::vector<double>* values : {&ours, &embree, &ratios})
        std::sort(values->begin(), values->end());
    const double best = ours.front() * 1e3, peer = embree.front() * 1e3;
    std::printf("| %-9s | builds   | sum  | %7.0f | %7.0f | %5.2f | median ratio %.2f |\n", scene,
                best, peer, peer / best, ratios[ratios.size() / 2]);
    std::fflush(stdout);
}

void benchScene(RTCDevice device, SceneKind kind, uint32_t triangles, const Options& options) {
    std::fprintf(stderr, "making a scene of %u triangles\n", triangles);
    const Mesh mesh = makeScene(kind, triangles);
    const MeshMemory memory(mesh);
    const std::vector<float> moved =
        options.motion ? movedVertices(mesh) : std::vector<float>();
    const void* keys[2] = {memory.vertices.memory, moved.data()};
    bvh::TriangleInput input = inputOf(mesh, memory);
    bvh::BuildInputs inputs;
    inputs.triangles = {&input, 1};
    bvh::BuildOptions buildOptions;
    buildOptions.preferFastBuild = options.fastBuild;
    buildOptions.preferFastTrace = options.fastTrace;
    if (options.motion) {
        input.keyVertices = keys;
        buildOptions.motion = {2, 0, 0, 1};
    }
    if (options.refit) {
        benchRefit(mesh, inputs, buildOptions);
        return;
    }
    const bvh::MemoryUsage usage = bvh::computeMemoryUsage(inputs, buildOptions);
    Block temp, output;
    temp.reserve(usage.temp);
    output.reserve(usage.output);
    double ourBuild = 1e30, embreeBuild = 1e30;
    RTCScene scene = nullptr;
    std::vector<double> ourProcessors, embreeProcessors;
    const int builds = options.builds ? options.builds : options.quick ? 2 : 4;
    for (int i = 0; i < builds; ++i) {
        ourProcessors.push_back(processSeconds([&] {
            ourBuild = std::min(ourBuild, seconds([&] {
                                    bvh::build(inputs, buildOptions, temp.memory, temp.capacity,
                                               output.memory, output.capacity);
                                }));
        }));
        if (scene)
            rtcReleaseScene(scene);
        scene = embreeScene(device, mesh, memory, moved);
        embreeProcessors.push_back(processSeconds(
            [&] { embreeBuild = std::min(embreeBuild, seconds([&] { rtcCommitScene(scene); })); }));
    }
    if (options.builds) {
        printBuilds(mesh.name.c_str(), ourProcessors, embreeProcessors);
        rtcReleaseScene(scene);
        return;
    }
    const uint64_t used = bvh::compactedSize(output.memory);
    std::printf("| %-9s | build ms | all  | %7.0f | %7.0f | %5.2f | %.1f B/tri |\n",
                mesh.name.c_str(), ourBuild * 1e3, embreeBuild * 1e3, ourBuild / embreeBuild,
                double(used) / mesh.numTriangles());
    std::free(temp.memory);
    temp.memory = nullptr;
    Block compacted;
    compacted.reserve((used + 127) / 128 * 128);
    bvh::compact(output.memory, compacted.memory, compacted.capacity);

    const bvh::Kernels& kernels = bvh::kernels(options.isa);
    const void* block = compacted.memory;
    const bool motion = options.motion;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const auto closestOurs = [&](const std::vector<Ray>& rays) -> RayLoop {
        return [&rays, &kernels, block, motion](size_t begin, size_t end) {
            uint64_t hits = 0;
            for (size_t i = begin; i < end; ++i) {
                bvh::QueryRay ray;
                std::memcpy(&ray, &rays[i], sizeof ray);
                bvh::QueryHit hit;
                hits += motion ? kernels.closestAt(block, ray, timeOf(i), hit)
                               : kernels.closest(block, ray, hit);
            }
            return hits;
        };
    };
    const auto closestEmbree = [&](const std::vector<Ray>& rays) -> RayLoop {
        return [&rays, &context, scene](size_t begin, size_t end) {
            uint64_t hits = 0;
            for (size_t i = begin; i < end; ++i) {
                RTCRayHit hit;
                hit.ray = embreeRay(rays[i], timeOf(i));
                hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(scene, &context, &hit);
                hits += hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
            }
            return hits;
        };
    };
    const auto occludedOurs = [&](const std::vector<Ray>& rays) -> RayLoop {
        return [&rays, &kernels, block, motion](size_t begin, size_t end) {
            uint64_t hits = 0;
            for (size_t i = begin; i < end; ++i) {
                bvh::QueryRay ray;
                std::memcpy(&ray, &rays[i], sizeof ray);
                hits += motion ? kernels.occludedAt(block, ray, timeOf(i))
                               : kernels.occluded(block, ray);
            }
            return hits;
        };
    };
    const auto occludedEmbree = [&](const std::vector<Ray>& rays) -> RayLoop {
        return [&rays, &context, scene](size_t begin, size_t end) {
            uint64_t hits = 0;
            for (size_t i = begin; i < end; ++i) {
                RTCRay ray = embreeRay(rays[i], timeOf(i));
                rtcOccluded1(scene, &context, &ray);
                hits += ray.tfar < 0;
            }
            return hits;
        };
    };

    const uint32_t width = options.quick ? 640 : 1280, height = options.quick ? 360 : 720;
    const std::vector<Ray> primary = primaryRays(mesh, width, height);
    std::vector<SurfacePoint> points(primary.size());
    for (size_t i = 0; i < primary.size(); ++i) {
        bvh::QueryRay ray;
        std::memcpy(&ray, &primary[i], sizeof ray);
        bvh::QueryHit hit{};
        points[i].hit = motion ? kernels.closestAt(block, ray, timeOf(i), hit)
                               : kernels.closest(block, ray, hit);
        points[i].t = hit.t;
        points[i].triangle = hit.primitive;
    }
    const std::vector<Ray> shadow = secondaryRays(mesh, primary, points, RayKind::kShadow);
    const std::vector<Ray> ao = secondaryRays(mesh, primary, points, RayKind::kAmbientOcclusion);
    const std::vector<Ray> diffuse = secondaryRays(mesh, primary, points, RayKind::kDiffuse);
    const int repeats = options.quick ? 3 : 5;
    for (bool all : {false, true}) {
        if (all && !options.threads)
            break;
        const char* name = mesh.name.c_str();
        print(name, "primary",
              contest(closestOurs(primary), closestEmbree(primary), primary.size(), all, repeats),
              all);
        print(name, "shadow",
              contest(occludedOurs(shadow), occludedEmbree(shadow), shadow.size(), all, repeats),
              all);
        print(name, "AO", contest(occludedOurs(ao), occludedEmbree(ao), ao.size(), all, repeats),
              all);
        print(name, "diffuse",
              contest(closestOurs(diffuse), closestEmbree(diffuse), diffuse.size(), all, repeats),
              all);
    }
    rtcReleaseScene(scene);
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            options.quick = true;
        } else if (word == "--threads") {
            options.threads = true;
        } else if (word == "--fast-build") {
            options.fastBuild = true;
        } else if (word == "--fast-trace") {
            options.fastTrace = true;
        } else if (word == "--motion") {
            options.motion = true;
        } else if (word == "--refit") {
            options.refit = true;
        } else if (word == "--builds" && i + 1 < argc) {
            options.builds = std::atoi(argv[++i]);
        } else if (word == "--scene" && i + 1 < argc) {
            options.scene = std::atoi(argv[++i]);
        } else if (word == "--isa" && i + 1 < argc) {
            const std::string isa = argv[++i];
            options.isa = isa == "avx512" ? bvh::Isa::kAvx512
                          : isa == "avx2" ? bvh::Isa::kAvx2
                                          : bvh::Isa::kBaseline;
        } else {
            std::fprintf(stderr,
                         "bench_kernels [--quick] [--threads] [--fast-build | --fast-trace] "
                         "[--refit] [--motion] [--builds N] [--scene 0-6] "
                         "[--isa avx512|avx2|baseline]\n");
            return 1;
        }
    }
    if (!bvh::isaSupported(options.isa)) {
        std::fprintf(stderr, "this machine has no %s\n", bvh::isaName(options.isa));
        return 1;
    }
    RTCDevice device = rtcNewDevice(nullptr);
    std::printf(
        "instruction set %s; Mrays/s, one ray at a time; ratio > 1 (build ms: < 1) = "
        "ours faster\n\n| scene     | rays     | thr. | ours    | Embree  | ratio | hits |\n"
        "|---|---|---|---|---|---|---|\n",
        bvh::isaName(options.isa));
    const struct {
        SceneKind kind;
        uint32_t triangles;
    } scenes[] = {{SceneKind::kTerrain, 2000000},     {SceneKind::kSoup, 1000000},
                  {SceneKind::kLongThin, 1000000},    {SceneKind::kSpheres, 10000000},
                  {SceneKind::kOverlapping, 1000000}, {SceneKind::kInterior, 1000000},
                  {SceneKind::kLeaves, 1000000}};
    for (int i = 0; i < int(std::size(scenes)); ++i)
        if (options.scene < 0 || options.scene == i)
            benchScene(device, scenes[i].kind, scenes[i].triangles, options);
    rtcReleaseDevice(device);
}
