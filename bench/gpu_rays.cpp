// SPDX-License-Identifier: Apache-2.0
// Rays per second and build times through optixLaunch and optixAccelBuild on a GPU, by events on the
// stream. The libnvoptix that the loader finds is what is measured, so the same binary and PTX run on
// Sunstone and on another library; the second run takes the first one's hits as the places where
// secondary rays begin, and says how many of its own hits differ.
//   bench_gpu [--ptx FILE] [--scene 0-3] [--fast-trace] --hits PREFIX
#include "optix_rays.h"

#include <optix_function_table_definition.h>

#include <cmath>

namespace {

using namespace bench;

class Timer {
public:
    Timer() {
        CHECK(cudaEventCreate(&begin_));
        CHECK(cudaEventCreate(&end_));
    }
    // Milliseconds of the fastest of `runs`.
    template <class Work>
    double best(int runs, Work work) {
        double best = 1e30;
        for (int i = 0; i < runs; ++i) {
            CHECK(cudaEventRecord(begin_, nullptr));
            work();
            CHECK(cudaEventRecord(end_, nullptr));
            CHECK(cudaEventSynchronize(end_));
            float ms = 0;
            CHECK(cudaEventElapsedTime(&ms, begin_, end_));
            best = std::min(best, double(ms));
        }
        return best;
    }

private:
    cudaEvent_t begin_ = nullptr, end_ = nullptr;
};

struct Options {
    std::string ptx = BENCH_PTX, hits;
    int scene = -1;
    unsigned buildFlags = 0;
};

class Bench {
public:
    explicit Bench(const Options& options)
        : options_(options), optix_(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS,
                                    OPTIX_PRIMITIVE_TYPE_TRIANGLE, options.ptx) {}

    void scene(SceneKind kind, uint32_t triangles) {
        const Mesh mesh = makeScene(kind, triangles);
        Structure structure(optix_, mesh, options_.buildFlags);
        structure.build();
        const double ms = timer_.best(5, [&] { structure.queue(); });
        const double count = mesh.numTriangles();
        std::printf("%-10s build    %9.3f ms, compacted %.1f, output %.1f, temp %.1f B/triangle\n",
                    mesh.name.c_str(), ms, double(structure.compactedSize()) / count,
                    double(structure.sizes().outputSizeInBytes) / count,
                    double(structure.sizes().tempSizeInBytes) / count);
        const std::vector<Ray> primary = primaryRays(mesh, 1920, 1080);
        std::vector<BenchHit> first = rays(mesh, structure, Optix::kClosest, primary, "primary");
        std::vector<SurfacePoint> points(primary.size());
        for (size_t i = 0; i < points.size(); ++i)
            points[i] = {first[i].primitive != ~0u, first[i].t, first[i].primitive};
        for (const auto& [ray, query, name] :
             {std::tuple{RayKind::kShadow, Optix::kAny, "shadow"},
              std::tuple{RayKind::kAmbientOcclusion, Optix::kAny, "AO"},
              std::tuple{RayKind::kDiffuse, Optix::kClosest, "diffuse"}})
            rays(mesh, structure, query, secondaryRays(mesh, primary, points, ray), name);
    }

private:
    // Returns the hits of the first run.
    std::vector<BenchHit> rays(const Mesh& mesh, const Structure& structure, Optix::Kind kind,
                               const std::vector<Ray>& rays, const char* what) {
        Buffer deviceRays(rays), deviceHits(rays.size() * sizeof(BenchHit));
        optix_.prepare(deviceRays, deviceHits, structure.handle);
        optix_.launch(kind, rays.size());
        const double ms = timer_.best(10, [&] { optix_.queue(kind, rays.size()); });
        std::vector<BenchHit> hits = deviceHits.read<BenchHit>(rays.size());
        std::printf("%-10s %-8s %9.1f Mrays/s", mesh.name.c_str(), what,
                    double(rays.size()) / ms * 1e-3);
        const std::string path = options_.hits + "." + mesh.name + "." + what;
        std::ifstream earlier(path, std::ios::binary);
        if (earlier) {
            std::vector<BenchHit> known(rays.size());
            earlier.read(reinterpret_cast<char*>(known.data()),
                         std::streamsize(known.size() * sizeof(BenchHit)));
            compare(kind, hits, known);
            hits = std::move(known);
        } else {
            std::ofstream(path, std::ios::binary)
                .write(reinterpret_cast<const char*>(hits.data()),
                       std::streamsize(hits.size() * sizeof(BenchHit)));
        }
        std::printf("\n");
        std::fflush(stdout);
        return hits;
    }

    static void compare(Optix::Kind kind, const std::vector<BenchHit>& a,
                        const std::vector<BenchHit>& b) {
        size_t found = 0, primitive = 0, distance = 0;
        for (size_t i = 0; i < a.size(); ++i) {
            const bool hitA = kind == Optix::kAny ? a[i].primitive : a[i].primitive != ~0u;
            const bool hitB = kind == Optix::kAny ? b[i].primitive : b[i].primitive != ~0u;
            found += hitA != hitB;
            if (kind == Optix::kAny || !hitA || !hitB)
                continue;
            primitive += a[i].primitive != b[i].primitive;
            distance += std::abs(a[i].t - b[i].t) > 1e-4f * std::abs(b[i].t);
        }
        std::printf("; of %zu rays differ: hit or not %zu, triangle %zu, distance %zu", a.size(),
                    found, primitive, distance);
    }

    Options options_;
    Optix optix_;
    Timer timer_;
};

} // namespace

int main(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--ptx" && i + 1 < argc) {
            options.ptx = argv[++i];
        } else if (word == "--hits" && i + 1 < argc) {
            options.hits = argv[++i];
        } else if (word == "--scene" && i + 1 < argc) {
            options.scene = std::atoi(argv[++i]);
        } else if (word == "--fast-trace") {
            options.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
        } else {
            options.hits.clear();
            break;
        }
    }
    if (options.hits.empty()) {
        std::fprintf(stderr,
                     "usage: bench_gpu [--ptx FILE] [--scene 0-3] [--fast-trace] --hits PREFIX\n");
        return 2;
    }
    const std::pair<SceneKind, uint32_t> scenes[] = {{SceneKind::kTerrain, 2000000},
                                                     {SceneKind::kSoup, 1000000},
                                                     {SceneKind::kLongThin, 1000000},
                                                     {SceneKind::kSpheres, 10000000}};
    Bench bench(options);
    for (int i = 0; i < 4; ++i)
        if (options.scene < 0 || options.scene == i)
            bench.scene(scenes[i].first, scenes[i].second);
}
