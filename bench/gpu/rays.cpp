// SPDX-License-Identifier: Apache-2.0
// Builds and rays of one scene. Secondary rays start at the first library's hits, so that both
// libraries trace the same rays.
#include "benches.h"
#include "judge.h"
#include "world.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <tuple>

namespace bench {
namespace {

std::vector<float> timesOf(size_t count) {
    std::vector<float> times(count);
    for (size_t i = 0; i < count; ++i)
        times[i] = timeOf(i);
    return times;
}

class WorldBench {
public:
    WorldBench(OptixDeviceContext context, const World& world, const Settings& settings,
               Measurements& measurements)
        : context_(context), world_(world), settings_(settings), measurements_(measurements),
          device_(context, world) {}

    void builds() {
        const double count = world_.count();
        const bool triangles =
            world_.kind == WorldKind::kTriangles || world_.kind == WorldKind::kLeaves;
        constexpr unsigned kCompact = OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
        for (const auto& [flags, name] :
             {std::pair{unsigned(OPTIX_BUILD_FLAG_NONE), "default"},
              std::pair{unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_BUILD), "fast build"},
              std::pair{unsigned(OPTIX_BUILD_FLAG_PREFER_FAST_TRACE), "fast trace"}}) {
            const Built built = device_.build(flags | kCompact, 5);
            const std::string what = name;
            measurements_.add(world_.name, "build, " + what, built.milliseconds, "ms");
            const char* unit = triangles ? "B/triangle" : "B/primitive";
            measurements_.add(world_.name, "temp, " + what,
                              double(built.sizes.tempSizeInBytes) / count, unit);
            if (flags == OPTIX_BUILD_FLAG_PREFER_FAST_BUILD)
                continue;
            const std::string compacted =
                flags == OPTIX_BUILD_FLAG_NONE ? "compacted" : "compacted, " + what;
            measurements_.add(world_.name, compacted, double(built.compactedSize) / count, unit);
            if (!triangles)
                continue;
            const Built vertices =
                device_.build(flags | kCompact | OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS, 1);
            measurements_.add(world_.name, compacted + ", random access",
                              double(vertices.compactedSize) / count, unit);
        }
        measurements_.add(world_.name, "update", device_.update(kCompact, 5), "ms");
    }

    void rays() {
        Tracer tracer(context_, world_.kind);
        const Built built = device_.build(world_.buildFlags | OPTIX_BUILD_FLAG_ALLOW_COMPACTION, 1);
        const std::vector<Ray> primary =
            primaryRays(world_.mesh, settings_.width, settings_.height);
        const std::vector<float> times = timesOf(primary.size());
        const std::vector<GpuHit> first =
            trace(tracer, built, RayQuery::kClosest, primary, times, "primary");
        std::vector<Surfel> points(primary.size());
        for (size_t i = 0; i < points.size(); ++i)
            points[i] = world_.surfel(primary[i], first[i], times[i]);
        // A ray from a hit has the time of the hit's ray.
        std::vector<float> later;
        for (size_t i = 0; i < points.size(); ++i)
            if (points[i].hit)
                later.push_back(times[i]);
        for (const auto& [kind, query, name] :
             {std::tuple{RayKind::kShadow, RayQuery::kAny, "shadow"},
              std::tuple{RayKind::kAmbientOcclusion, RayQuery::kAny, "AO"},
              std::tuple{RayKind::kDiffuse, RayQuery::kClosest, "diffuse"}})
            trace(tracer, built, query, secondaryRays(primary, points, world_.mesh.aoRadius, kind),
                  later, name);
    }

private:
    // Returns the first library's hits.
    std::vector<GpuHit> trace(Tracer& tracer, const Built& built, RayQuery query,
                              const std::vector<Ray>& rays, const std::vector<float>& times,
                              const char* what) {
        static_assert(sizeof(Ray) == sizeof(GpuRay));
        if (rays.empty())
            throw std::runtime_error(world_.name + ": no rays of kind " + what);
        DeviceBuffer deviceRays, deviceTimes, deviceHits(rays.size() * sizeof(GpuHit));
        deviceRays.upload(rays);
        deviceTimes.upload(times);
        CUDA_CHECK(cudaMemset(deviceHits.data(), 0, deviceHits.size()));
        tracer.prepare({deviceRays.as<GpuRay>(), deviceHits.as<GpuHit>(), built.handle,
                        device_.spheres().as<float>(), deviceTimes.as<float>()});
        tracer.queue(query, rays.size());
        CUDA_CHECK(cudaDeviceSynchronize());
        const double ms =
            fastest(int(settings_.repeats), [&] { tracer.queue(query, rays.size()); });
        std::vector<GpuHit> hits = deviceHits.download<GpuHit>();
        measurements_.add(world_.name, what, double(rays.size()) / ms * 1e-3, "Mrays/s");
        std::vector<GpuHit> known(hits.size());
        if (!exchange(settings_, world_.name + "." + what, hits.data(),
                      hits.size() * sizeof(GpuHit), known.data()))
            return hits;
        const nlohmann::json counts = compareHits(world_, rays, query, hits, known);
        if (!counts.is_null())
            measurements_.addDifferences(world_.name, what, counts);
        return known;
    }

    OptixDeviceContext context_;
    const World& world_;
    const Settings& settings_;
    Measurements& measurements_;
    DeviceWorld device_;
};

} // namespace

bool exchange(const Settings& settings, const std::string& name, void* mine, size_t size,
              void* theirs) {
    std::string path = settings.hits + "." + name;
    std::replace(path.begin(), path.end(), ' ', '_');
    std::ifstream earlier(path, std::ios::binary);
    if (earlier) {
        if (!earlier.read(static_cast<char*>(theirs), std::streamsize(size)))
            throw std::runtime_error(path + " is of another size than this run's results");
        return true;
    }
    std::ofstream file(path, std::ios::binary);
    file.write(static_cast<const char*>(mine), std::streamsize(size));
    if (!file)
        throw std::runtime_error("cannot write " + path);
    return false;
}

void benchWorld(OptixDeviceContext context, const std::string& name, const Settings& settings,
                Measurements& measurements) {
    const World world = makeWorld(name, settings.scale);
    WorldBench bench(context, world, settings, measurements);
    if (world.buildFlags == 0) // otherwise equal to the default
        bench.builds();
    bench.rays();
}

} // namespace bench
