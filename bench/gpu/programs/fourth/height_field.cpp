// SPDX-License-Identifier: Apache-2.0
// Mountains around lakes: tiles of a height field are custom primitives, and mirrored instances
// repeat the field; device/height_field.cu.
#include "programs.h"

#include "device/height_field.h"

std::string_view bench_fourth_height_field_ptx();

namespace bench {
namespace {

constexpr unsigned kCopies = 4; // along a side

float noiseAt(float x, float z, unsigned seed) {
    const float cellX = std::floor(x), cellZ = std::floor(z);
    const auto corner = [&](int i, int k) {
        return randomOf(unsigned(int(cellX) + i) * 4099 + unsigned(int(cellZ) + k), seed);
    };
    const float u = x - cellX, v = z - cellZ;
    const float s = u * u * (3 - 2 * u), t = v * v * (3 - 2 * v);
    return (corner(0, 0) * (1 - s) + corner(1, 0) * s) * (1 - t) +
           (corner(0, 1) * (1 - s) + corner(1, 1) * s) * t;
}
// Ridges of six octaves.
float heightOf(float x, float z) {
    float sum = 0, size = 0.5f, ridge = 1;
    for (unsigned octave = 0; octave < 6; ++octave) {
        const float fold = 1 - std::fabs(2 * noiseAt(x, z, octave) - 1);
        ridge = fold * fold * std::min(1.0f, 1.5f * ridge);
        sum += size * ridge;
        size *= 0.5f;
        x = 2.03f * x + 11.3f;
        z = 1.97f * z + 5.1f;
    }
    return sum;
}

class HeightField : public Renderer {
public:
    HeightField(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        record_.tiles = int(std::sqrt(settings.some(64 * 64, 4)));
        record_.across = record_.tiles * kTileCells + 1;
        const float size = float(record_.across - 1);
        const OptixTraversableHandle field = makeField(size);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const float whole = size * kCopies, sea = 0.045f * size;
        const Mesh water =
            makeSheet(1, 1, [&](float u, float v) { return vec(whole * v, sea, whole * u); });
        std::vector<OptixInstance> all = {
            instanceOf(scene_.build(inputOf(uploadMesh(scene_, water), flags)), kIdentity, 0, 1)};
        all[0].visibilityMask = 2;
        for (unsigned i = 0; i < kCopies * kCopies; ++i) {
            const unsigned x = i % kCopies, z = i / kCopies;
            const float m[12] = {x % 2 ? -1.0f : 1.0f,
                                 0,
                                 0,
                                 size * float(x + x % 2),
                                 0,
                                 1,
                                 0,
                                 0,
                                 0,
                                 0,
                                 z % 2 ? -1.0f : 1.0f,
                                 size * float(z + z % 2)};
            all.push_back(instanceOf(field, m, i, 0));
            all.back().visibilityMask = 1;
        }
        HeightParams& p = launch_.params;
        p.land = scene_.buildInstances(all);
        p.camera = makeCamera(vec(0.7f, 0.15f, 0.55f) * size, vec(1.8f, -0.25f, 2.1f) * size,
                              vec(0, 1, 0), 50, settings.aspect());
        p.sun = normalize(vec(0.8f, 0.42f, 0.1f));
        p.samples = 2;
        p.skyRays = 2;
        p.snowLine = 0.085f * size;
        p.haze = 0.3f / size;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        o.numPayloadValues = 5;
        const OptixModule module = programs_.load(bench_fourth_height_field_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__landscape"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto ground =
            programs_.hit({{module, "__closesthit__land"}, {}, {module, "__intersection__tile"}});
        const auto water = programs_.hit({{module, "__closesthit__water"}, {}, {}});
        pipeline_ = programs_.link({raygen, sky, open, ground, water}, {.trace = 3, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(open)});
        table_.setHits(std::vector{makeRecord(ground, record_), makeRecord(water, record_)});
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    OptixTraversableHandle makeField(float size) {
        std::vector<float> heights;
        for (int z = 0; z < record_.across; ++z)
            for (int x = 0; x < record_.across; ++x)
                heights.push_back(0.13f * size *
                                  heightOf(6 * float(x) / size, 6 * float(z) / size));
        std::vector<HeightRange> ranges;
        std::vector<OptixAabb> boxes;
        for (int i = 0; i < record_.tiles * record_.tiles; ++i) {
            const int x = i % record_.tiles * kTileCells, z = i / record_.tiles * kTileCells;
            const size_t first = ranges.size();
            addPyramid(heights, x, z, ranges);
            boxes.push_back({float(x), ranges[first].low, float(z), float(x + kTileCells),
                             ranges[first].high, float(z + kTileCells)});
        }
        record_.heights = scene_.upload(heights);
        record_.ranges = scene_.upload(ranges);
        return scene_.buildBoxes(boxes, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
    }
    // The ranges of all levels of a tile, from the cells up.
    void addPyramid(const std::vector<float>& heights, int x, int z,
                    std::vector<HeightRange>& ranges) const {
        const size_t root = ranges.size();
        ranges.resize(root + kTileNodes, {1e30f, -1e30f});
        for (int level = kTileLevels; level >= 0; --level) {
            const int side = 1 << level, first = ((1 << 2 * level) - 1) / 3,
                      below = ((4 << 2 * level) - 1) / 3;
            for (int node = 0; node < side * side; ++node) {
                HeightRange& range = ranges[root + size_t(first + node)];
                const int column = node % side, row = node / side;
                for (int k = 0; k < 4; ++k) {
                    const int cx = column + k % 2, cz = row + k / 2;
                    const float height = heights[size_t(z + cz) * record_.across + x + cx];
                    const HeightRange part =
                        level == kTileLevels
                            ? HeightRange{height, height}
                            : ranges[root + size_t(below + (row * 2 + k / 2) * 2 * side +
                                                   column * 2 + k % 2)];
                    range.low = std::min(range.low, part.low);
                    range.high = std::max(range.high, part.high);
                }
            }
        }
    }

    HeightRecord record_ = {};
    Launch<HeightParams> launch_;
};

} // namespace

JobKind heightFieldJob() {
    return fourthJob<HeightField>(
        "height_field", "tiles of a height field with pyramids, mirrored instances, water", 0.005,
        0.05);
}

} // namespace bench
