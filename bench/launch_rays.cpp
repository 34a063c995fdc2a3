// SPDX-License-Identifier: Apache-2.0
// Rays per second through the whole optixLaunch path (compiled ray generation program, trace,
// closest-hit and miss programs) against Embree's single-ray kernels on identical ray arrays, in
// one process, all threads on both sides; and acceleration-structure builds through optixAccelBuild
// against Embree's medium quality.
//   bench_launch [--quick] [--scene N] [--json] [--processors] [--rays primary|shadow|AO|diffuse]
//                [--rounds N]
// Runs alternate between the two; the best of several counts. --processors: compares processor time
// of all threads, for machines that are not idle.
#include "embree_rays.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace bench;

struct Row {
    std::string scene, what;
    double ours, embree; // rays per second, or seconds of a build
    double difference;   // share of rays whose hit differs
};

struct Options {
    bool quick = false, json = false, processors = false;
    int scene = -1, rounds = 0; // 0: the usual number
    std::string rays;           // empty: all
};

class Bench {
public:
    explicit Bench(const Options& options)
        : options_(options), time_(options.processors ? processSeconds : seconds),
          device_(rtcNewDevice(nullptr)) {}
    ~Bench() { rtcReleaseDevice(device_); }

    void scene(bench::SceneKind kind, uint32_t triangles) {
        std::fprintf(stderr, "scene of %u triangles\n", triangles);
        const Mesh mesh = bench::makeScene(kind, triangles);
        Structure structure(optix_, mesh);
        RTCScene peer = nullptr;
        double ours = 1e30, embree = 1e30;
        for (int i = 0; i < (options_.quick ? 2 : 4); ++i) {
            ours = std::min(ours, time_([&] { structure.build(); }));
            if (peer)
                rtcReleaseScene(peer);
            peer = embreeScene(device_, mesh);
            embree = std::min(embree, time_([&] { rtcCommitScene(peer); }));
        }
        add({mesh.name, "build", ours, embree, 0});

        const std::vector<Ray> primary =
            bench::primaryRays(mesh, options_.quick ? 640 : 1920, options_.quick ? 360 : 1080);
        std::vector<BenchHit> first(primary.size());
        rays(mesh, structure, peer, Optix::kClosest, primary, "primary", &first);
        std::vector<bench::SurfacePoint> points(primary.size());
        for (size_t i = 0; i < points.size(); ++i)
            points[i] = {first[i].primitive != ~0u, first[i].t, first[i].primitive};
        const auto secondary = [&](bench::RayKind kind) {
            return bench::secondaryRays(mesh, primary, points, kind);
        };
        rays(mesh, structure, peer, Optix::kAny, secondary(bench::RayKind::kShadow), "shadow");
        rays(mesh, structure, peer, Optix::kAny, secondary(bench::RayKind::kAmbientOcclusion),
             "AO");
        rays(mesh, structure, peer, Optix::kClosest, secondary(bench::RayKind::kDiffuse),
             "diffuse");
        rtcReleaseScene(peer);
    }

    const std::vector<Row>& rows() const { return rows_; }

private:
    void rays(const Mesh& mesh, const Structure& structure, RTCScene peer, Optix::Kind kind,
              const std::vector<Ray>& rays, const char* what,
              std::vector<BenchHit>* keep = nullptr) {
        Buffer deviceRays(rays), deviceHits(rays.size() * sizeof(BenchHit));
        std::vector<BenchHit> theirs(rays.size());
        optix_.prepare(deviceRays, deviceHits, structure.handle);
        double ours = 1e30, embree = 1e30;
        const bool isAsked = options_.rays.empty() || options_.rays == what;
        const int rounds = !isAsked          ? 1
                           : options_.rounds ? options_.rounds
                           : options_.quick  ? 3
                                             : 7;
        for (int i = 0; i < rounds; ++i) {
            ours = std::min(ours, time_([&] { optix_.launch(kind, rays.size()); }));
            embree = std::min(embree, time_([&] { traceEmbree(peer, kind, rays, theirs); }));
        }
        const std::vector<BenchHit> hits = deviceHits.read<BenchHit>(rays.size());
        size_t different = 0;
        for (size_t i = 0; i < hits.size(); ++i)
            different += kind == Optix::kClosest
                             ? (hits[i].primitive == ~0u) != (theirs[i].primitive == ~0u)
                             : hits[i].primitive != theirs[i].primitive;
        if (isAsked)
            add({mesh.name, what, double(rays.size()) / ours, double(rays.size()) / embree,
                 double(different) / double(rays.size())});
        if (keep)
            *keep = hits;
    }

    void add(Row row) {
        const bool build = row.what == "build";
        const double scale = build ? 1e3 : 1e-6;
        std::fprintf(
            stderr, "  %-8s ours %9.2f  Embree %9.2f %s  ratio %.2f  hits that differ %.5f%%\n",
            row.what.c_str(), row.ours * scale, row.embree * scale, build ? "ms" : "Mrays/s",
            build ? row.embree / row.ours : row.ours / row.embree, row.difference * 100);
        rows_.push_back(std::move(row));
    }

    const Options options_;
    double (*const time_)(const std::function<void()>&);
    Optix optix_;
    RTCDevice device_;
    std::vector<Row> rows_;
};

void printTable(const std::vector<Row>& rows) {
    std::printf("| scene | rays | Sunstone | Embree | ratio | hits that differ |\n"
                "|---|---|---|---|---|---|\n");
    for (const Row& r : rows) {
        const bool build = r.what == "build";
        std::printf("| %s | %s | %.2f %s | %.2f | %.2f | %.5f%% |\n", r.scene.c_str(),
                    r.what.c_str(), build ? r.ours * 1e3 : r.ours * 1e-6, build ? "ms" : "Mrays/s",
                    build ? r.embree * 1e3 : r.embree * 1e-6,
                    build ? r.embree / r.ours : r.ours / r.embree, r.difference * 100);
    }
}

void printJson(const std::vector<Row>& rows) {
    std::printf("[");
    for (size_t i = 0; i < rows.size(); ++i)
        std::printf("%s\n  {\"scene\": \"%s\", \"what\": \"%s\", \"ours\": %g, \"embree\": %g, "
                    "\"difference\": %g}",
                    i ? "," : "", rows[i].scene.c_str(), rows[i].what.c_str(), rows[i].ours,
                    rows[i].embree, rows[i].difference);
    std::printf("\n]\n");
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const bool hasValue = i + 1 < argc;
        if (word == "--quick") {
            options.quick = true;
        } else if (word == "--json") {
            options.json = true;
        } else if (word == "--processors") {
            options.processors = true;
        } else if (word == "--scene" && hasValue) {
            options.scene = std::atoi(argv[++i]);
        } else if (word == "--rays" && hasValue) {
            options.rays = argv[++i];
        } else if (word == "--rounds" && hasValue) {
            options.rounds = std::atoi(argv[++i]);
        } else {
            std::fprintf(stderr, "usage: bench_launch [--quick] [--json] [--processors] "
                                 "[--scene 0-6] [--rays primary|shadow|AO|diffuse] [--rounds N]\n");
            return word == "--help" ? 0 : 2;
        }
    }
    const struct {
        bench::SceneKind kind;
        uint32_t triangles;
    } scenes[] = {{bench::SceneKind::kTerrain, 2000000},     {bench::SceneKind::kSoup, 1000000},
                  {bench::SceneKind::kLongThin, 1000000},    {bench::SceneKind::kSpheres, 10000000},
                  {bench::SceneKind::kOverlapping, 1000000}, {bench::SceneKind::kInterior, 1000000},
                  {bench::SceneKind::kLeaves, 1000000}};
    Bench run(options);
    for (int i = 0; i < 7; ++i)
        if (options.scene < 0 || options.scene == i)
            run.scene(scenes[i].kind, scenes[i].triangles);
    options.json ? printJson(run.rows()) : printTable(run.rows());
}
