// SPDX-License-Identifier: Apache-2.0
// Drops of metal and wax as metaballs in one structure without instances; device/metaballs.cu.
#include "programs.h"

#include "device/metaballs.h"

std::string_view bench_fifth_metaballs_ptx();

namespace bench {
namespace {

// A chain of balls that rises from the floor and leans.
MetaballDrop makeDrop(unsigned number, float3 foot) {
    MetaballDrop drop = {};
    const float size = 0.5f + 0.5f * randomOf(number, 0);
    const float2 lean = circlePoint(randomOf(number, 1));
    float3 at = foot + vec(0, 0.45f * size, 0);
    for (unsigned i = 0; i < kBlobsOfDrop; ++i) {
        const unsigned stream = 8 * number + i;
        const float2 c = circlePoint(randomOf(stream, 2));
        drop.centers[i] = at + vec(c.x, 0, c.y) * (0.2f * size);
        drop.radii[i] = size * (0.55f + 0.45f * randomOf(stream, 3));
        at += vec(0.12f * lean.x, 0.2f + 0.25f * randomOf(stream, 4), 0.12f * lean.y) * size;
    }
    drop.colors[0] = colorOf(2 * number);
    drop.colors[1] = colorOf(2 * number + 1);
    drop.mirror = number % 3 == 0 ? 0.75f : number % 3 == 1 ? 0.2f : 0.03f;
    return drop;
}
OptixAabb boundsOf(const MetaballDrop& drop) {
    OptixAabb box = {1e30f, 1e30f, 1e30f, -1e30f, -1e30f, -1e30f};
    for (unsigned i = 0; i < kBlobsOfDrop; ++i) {
        const float3 c = drop.centers[i];
        const float r = drop.radii[i];
        box = {std::min(box.minX, c.x - r), std::min(box.minY, c.y - r),
               std::min(box.minZ, c.z - r), std::max(box.maxX, c.x + r),
               std::max(box.maxY, c.y + r), std::max(box.maxZ, c.z + r)};
    }
    return box;
}

class Metaballs : public Renderer {
public:
    Metaballs(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        std::vector<MetaballDrop> drops;
        std::vector<OptixAabb> boxes;
        const unsigned count = settings.some(1500, 30);
        for (unsigned i = 0; i < count; ++i) {
            const float turns = float(i) * 0.381966f;
            const float2 c = circlePoint(turns - std::floor(turns));
            const float r = 1.1f * std::sqrt(float(i) + 0.5f);
            drops.push_back(makeDrop(i, vec(r * c.x, 0, r * c.y)));
            boxes.push_back(boundsOf(drops.back()));
        }
        record_.drops = scene_.upload(drops);
        boxes.push_back({-400, -1e-3f, -400, 400, 1e-3f, 400});
        MetaballParams& p = launch_.params;
        p.hall = build(boxes);
        p.camera =
            makeCamera(vec(-4, 4.2f, -12), vec(0.3f, 0.9f, 0), vec(0, 1, 0), 42, settings.aspect());
        p.sun = normalize(vec(-0.5f, 0.65f, -0.5f));
        p.samples = 1;
        p.maxDepth = 3;
        p.steps = 20;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        o.numPayloadValues = 4;
        const OptixModule module = programs_.load(bench_fifth_metaballs_ptx());
        const Function walk = {module, "__intersection__drop"},
                       plane = {module, "__intersection__floor"};
        const auto raygen = programs_.raygen({module, "__raygen__hall"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto open = programs_.miss({module, "__miss__open"});
        const OptixProgramGroup hits[] = {
            programs_.hit({{module, "__closesthit__drop"}, {}, walk}),
            programs_.hit({{}, {}, walk}),
            programs_.hit({{module, "__closesthit__floor"}, {}, plane}),
            programs_.hit({{}, {}, plane})};
        pipeline_ = programs_.link({raygen, sky, open, hits[0], hits[1], hits[2], hits[3]},
                                   {.trace = launch_.params.maxDepth + 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(open)});
        std::vector<SbtRecord<MetaballRecord>> records;
        for (const OptixProgramGroup hit : hits)
            records.push_back(makeRecord(hit, record_));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    // Drops have the first record, the floor, which is the last box, the second. A shadow ray has
    // the next one of both.
    OptixTraversableHandle build(const std::vector<OptixAabb>& boxes) {
        std::vector<unsigned char> records(boxes.size(), 0);
        records.back() = 1;
        const CUdeviceptr memory = addressOf(scene_, boxes);
        const unsigned flags[] = {OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT,
                                  OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT};
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        OptixBuildInputCustomPrimitiveArray& c = input.customPrimitiveArray;
        c.aabbBuffers = &memory;
        c.numPrimitives = unsigned(boxes.size());
        c.flags = flags;
        c.numSbtRecords = 2;
        c.sbtIndexOffsetBuffer = addressOf(scene_, records);
        c.sbtIndexOffsetSizeInBytes = sizeof(unsigned char);
        return scene_.build(input);
    }

    MetaballRecord record_ = {};
    Launch<MetaballParams> launch_;
};

} // namespace

JobKind metaballsJob() {
    return fifthJob<Metaballs>(
        "metaballs", "implicit surfaces without instances, recursive reflections", 0.003, 0.03);
}

} // namespace bench
