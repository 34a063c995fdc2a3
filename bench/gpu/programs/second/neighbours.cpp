// SPDX-License-Identifier: Apache-2.0
// A search for the nearest points of a scan; device/neighbours.cu.
#include "programs.h"

#include "device/neighbours.h"
#include "sampling.h"

#include <cmath>

std::string_view bench_second_neighbours_ptx();

namespace bench {
namespace {

// Points of a scan: dense on a surface of waves, thin above it.
std::vector<float3> makeScan(unsigned count, unsigned seed) {
    std::vector<float3> points(count);
    for (unsigned i = 0; i < count; ++i) {
        const unsigned n = seed + i;
        const float x = randomOf(n, 0), z = randomOf(n, 1);
        const float2 a = circlePoint(x), b = circlePoint(z);
        const float above = randomOf(n, 2);
        points[i] = vec(2 * x - 1, 0.15f * a.y * b.x + 0.3f * std::pow(above, 8.0f), 2 * z - 1);
    }
    return points;
}

class Neighbours : public Application {
public:
    Neighbours(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), count_(settings.some(1.5e6, 300)) {
        const unsigned numPoints = settings.some(1e6, 200);
        const std::vector<float3> points = makeScan(numPoints, 0);
        NeighbourParams& p = launch_.params;
        p.radius = 2.4f * std::sqrt(4.0f / float(numPoints));
        std::vector<OptixAabb> boxes;
        boxes.reserve(numPoints);
        const float r = p.radius;
        for (const float3 at : points)
            boxes.push_back({at.x - r, at.y - r, at.z - r, at.x + r, at.y + r, at.z + r});
        p.index = scene_.buildBoxes(boxes, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        p.points = scene_.upload(points);
        p.queries = scene_.upload(makeScan(count_, numPoints));
        p.numQueries = count_;
        p.neighbours = scene_.allocate<unsigned>(size_t(count_) * kNeighbours);
        summary_.allocate(sizeof(float4) * count_);
        p.summary = summary_.as<float4>();
    }
    void compile() override {
        programs_.options.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        programs_.options.numAttributeValues = 0;
        const OptixModule module = programs_.load(bench_second_neighbours_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__query"});
        const auto miss = programs_.miss({});
        const auto hit = programs_.hit({{}, {}, {module, "__intersection__point"}});
        pipeline_ = programs_.link({raygen, miss, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        table_.setHits(std::vector{makeRecord(hit)});
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, count_); }
    std::vector<float> picture() override { return summary_.download<float>(); }

private:
    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<NeighbourParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer summary_;
    unsigned count_;
};

} // namespace

JobKind neighboursJob() {
    return secondJob<Neighbours>("neighbours",
                                 "the eight nearest of a million points, by intersection programs",
                                 1e-5, 1e-4);
}

} // namespace bench
