// SPDX-License-Identifier: Apache-2.0
// An island of a million triangles in one structure, with a callable for each cover of the ground;
// device/landscape.cu.
#include "programs.h"

#include "device/landscape.h"

std::string_view bench_fifth_landscape_ptx();

namespace bench {
namespace {

constexpr float kSide = 60;

// Smooth noise in [0, 1) over a grid of random numbers.
float noiseAt(float x, float z, unsigned stream) {
    const float cellX = std::floor(x), cellZ = std::floor(z), fx = x - cellX, fz = z - cellZ;
    const auto corner = [&](unsigned right, unsigned top) {
        return randomOf(
            (unsigned(int(cellX)) + right) * 7919 + (unsigned(int(cellZ)) + top) * 104729, stream);
    };
    const float u = fx * fx * (3 - 2 * fx), v = fz * fz * (3 - 2 * fz);
    const float low = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * u;
    const float high = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * u;
    return low + (high - low) * v;
}
// Ridges on an island; the sea is at 0.
float3 groundAt(float u, float v) {
    const float x = kSide * (u - 0.5f), z = kSide * (v - 0.5f);
    const float x2 = 0.8f * x + 0.6f * z, z2 = 0.8f * z - 0.6f * x;
    float height = 0, size = 1, scale = 0.09f;
    for (unsigned octave = 0; octave < 8; ++octave) {
        const float n = octave % 2 ? noiseAt(x * scale, z * scale, octave)
                                   : noiseAt(x2 * scale, z2 * scale, octave);
        height += size * (octave < 4 ? 1 - std::fabs(2 * n - 1) : n);
        size *= 0.46f;
        scale *= 2.03f;
    }
    const float far = (x * x + z * z) / (0.25f * kSide * kSide);
    const float island = 9 * (height - 0.55f) * std::max(0.0f, 1 - far) - 2.5f;
    return vec(x, std::max(island, 0.0f), z);
}

class Landscape : public Renderer {
public:
    Landscape(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const auto cells = unsigned(std::sqrt(settings.some(500000, 400)));
        const Mesh mesh = makeSheet(cells, cells, groundAt);
        const MeshMemory memory = uploadMesh(scene_, mesh);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        record_ = {viewOf(memory), scene_.upload(smoothNormals(mesh))};
        LandscapeParams& p = launch_.params;
        p.land = scene_.build(inputOf(memory, flags));
        p.camera = makeCamera(vec(-9, 7.5f, -28), vec(0.5f, 1.5f, -4), vec(0, 1, 0), 42,
                              settings.aspect());
        p.sun = normalize(vec(-0.75f, 0.42f, 0.1f));
        p.samples = 2;
        p.bounces = 3;
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.options.numPayloadValues = 4;
        static constexpr const char* kNames[kCovers] = {
            "__continuation_callable__water", "__continuation_callable__sand",
            "__continuation_callable__grass", "__continuation_callable__rock",
            "__continuation_callable__snow"};
        const OptixModule module = programs_.load(bench_fifth_landscape_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__landscape"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto hit = programs_.hit({{module, "__closesthit__land"}, {}, {}});
        std::vector<OptixProgramGroup> groups = {raygen, sky, open, hit};
        std::vector<SbtRecord<NoData>> callables;
        for (const char* name : kNames) {
            groups.push_back(programs_.continuation({module, name}));
            callables.push_back(makeRecord(groups.back()));
        }
        pipeline_ = programs_.link(groups, {.trace = 1, .continuationCallables = 1});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(open)});
        table_.setHits(std::vector{makeRecord(hit, record_)});
        table_.setCallables(callables);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    LandscapeRecord record_ = {};
    Launch<LandscapeParams> launch_;
};

} // namespace

JobKind landscapeJob() {
    return fifthJob<Landscape>("landscape",
                               "a million triangles, paths whose callables trace up to four rays",
                               0.003, 0.03);
}

} // namespace bench
