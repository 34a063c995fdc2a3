// SPDX-License-Identifier: Apache-2.0
// A yard with 20,000 instances of small assemblies of balls, discs, boxes and rods, which are
// custom primitives; device/assemblies.cu.
#include "programs.h"

#include "device/assemblies.h"

std::string_view bench_fifth_assemblies_ptx();

namespace bench {
namespace {

constexpr unsigned kAssemblies = 6, kGround = kAssemblies;

// Parts of one structure with their bounds and kinds.
struct PartList {
    std::vector<AssemblyPart> parts;
    std::vector<OptixAabb> boxes;
    std::vector<unsigned char> kinds;

    void ball(float3 at, float radius, float3 color) {
        add(kBallPart, {at, vec(0), radius, 0, color}, vec(radius));
    }
    void disc(float3 at, float3 axis, float radius, float3 color) {
        add(kDiscPart, {at, axis, radius, 0, color}, around(axis, radius) + vec(1e-4f));
    }
    void box(float3 at, float3 extent, float3 color) {
        add(kBoxPart, {at, extent, 0, 0, color}, extent);
    }
    void rod(float3 from, float3 to, float radius, float3 color) {
        const float3 axis = normalize(to - from);
        const float half = 0.5f * length(to - from);
        const float3 ends = vec(std::fabs(axis.x), std::fabs(axis.y), std::fabs(axis.z)) * half;
        add(kRodPart, {(from + to) * 0.5f, axis, radius, half, color}, ends + around(axis, radius));
    }

private:
    // Half sides of the bounds of a circle.
    static float3 around(float3 axis, float radius) {
        return vec(std::sqrt(std::max(0.0f, 1 - axis.x * axis.x)),
                   std::sqrt(std::max(0.0f, 1 - axis.y * axis.y)),
                   std::sqrt(std::max(0.0f, 1 - axis.z * axis.z))) *
               radius;
    }
    void add(PartKind kind, const AssemblyPart& part, float3 half) {
        const float3 low = part.at - half, high = part.at + half;
        parts.push_back(part);
        boxes.push_back({low.x, low.y, low.z, high.x, high.y, high.z});
        kinds.push_back(kind);
    }
};

float3 onCircle(unsigned i, unsigned count, float radius, float y) {
    const float2 c = circlePoint(float(i) / float(count));
    return vec(radius * c.x, y, radius * c.y);
}
const float3 kUp = vec(0, 1, 0), kSteel = vec(0.6f, 0.62f, 0.65f), kWood = vec(0.6f, 0.42f, 0.25f),
             kRed = vec(0.75f, 0.2f, 0.15f), kYellow = vec(0.85f, 0.7f, 0.2f),
             kBlue = vec(0.2f, 0.35f, 0.7f), kWhite = vec(0.85f);

void addTable(PartList& list) {
    list.box(vec(0, 0.9f, 0), vec(0.8f, 0.05f, 0.6f), kWood);
    for (unsigned i = 0; i < 4; ++i) {
        const float3 leg = vec(i & 1 ? 0.7f : -0.7f, 0, i & 2 ? 0.5f : -0.5f);
        list.rod(leg, leg + vec(0, 0.9f, 0), 0.05f, kSteel);
    }
    for (unsigned i = 0; i < 6; ++i)
        list.ball(vec(1.1f * randomOf(i, 0) - 0.55f, 1.05f, 0.8f * randomOf(i, 1) - 0.4f), 0.1f,
                  colorOf(i));
}
void addJack(PartList& list) {
    list.ball(vec(0, 1, 0), 0.3f, kBlue);
    for (unsigned i = 0; i < 6; ++i) {
        const float side = i & 1 ? 0.8f : -0.8f;
        const float3 end = vec(i < 2 ? side : 0, i / 2 == 1 ? side : 0, i > 3 ? side : 0);
        list.rod(vec(0, 1, 0), vec(0, 1, 0) + end, 0.07f, kSteel);
        list.ball(vec(0, 1, 0) + end, 0.17f, kYellow);
    }
}
void addParasol(PartList& list) {
    list.rod(vec(0), vec(0, 1.9f, 0), 0.04f, kWhite);
    list.disc(vec(0, 0.02f, 0), kUp, 0.35f, kSteel);
    for (unsigned i = 0; i < 8; ++i) {
        const float3 out = onCircle(i, 8, 0.55f, 0);
        list.disc(vec(0, 1.7f, 0) + out, normalize(out + vec(0, 1.3f, 0)), 0.36f,
                  i % 2 ? kRed : kWhite);
    }
    list.ball(vec(0, 1.95f, 0), 0.08f, kRed);
}
void addTower(PartList& list) {
    for (unsigned i = 0; i < 5; ++i) {
        const float half = 0.55f - 0.08f * float(i), y = 0.2f + 0.4f * float(i);
        list.box(vec(0, y, 0), vec(half, 0.13f, half), colorOf(20 + i));
        for (unsigned k = 0; k < 4; ++k)
            list.rod(onCircle(k, 4, half, y + 0.13f), onCircle(k, 4, half, y + 0.27f), 0.04f,
                     kSteel);
    }
    list.ball(vec(0, 2.25f, 0), 0.2f, kYellow);
}
void addWheel(PartList& list) {
    const auto turn = [](float3 p) { return vec(p.x, p.z + 1, p.y); };
    for (unsigned i = 0; i < 12; ++i) {
        const float3 rim = turn(onCircle(i, 12, 0.9f, 0));
        list.rod(vec(0, 1, 0), rim, 0.03f, kSteel);
        list.rod(rim, turn(onCircle(i + 1 == 12 ? 0 : i + 1, 12, 0.9f, 0)), 0.06f, kRed);
        list.ball(rim, 0.1f, kBlue);
    }
    for (const float z : {-0.12f, 0.12f})
        list.disc(vec(0, 1, z), vec(0, 0, 1), 0.3f, kYellow);
    list.box(vec(0, 0.05f, 0), vec(0.5f, 0.05f, 0.25f), kWood);
}
void addAbacus(PartList& list) {
    for (const float x : {-0.9f, 0.9f})
        list.box(vec(x, 0.8f, 0), vec(0.06f, 0.8f, 0.12f), kWood);
    for (unsigned row = 0; row < 4; ++row) {
        const float y = 0.3f + 0.35f * float(row);
        list.rod(vec(-0.9f, y, 0), vec(0.9f, y, 0), 0.02f, kSteel);
        for (unsigned i = 0; i < 6; ++i)
            list.ball(vec(-0.7f + 0.2f * float(i) + (i > row ? 0.4f : 0), y, 0), 0.11f,
                      colorOf(40 + row));
    }
}

class Assemblies : public Renderer {
public:
    Assemblies(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        static constexpr void (*kMakers[kAssemblies])(PartList&) = {addTable, addJack,  addParasol,
                                                                    addTower, addWheel, addAbacus};
        for (unsigned i = 0; i < kAssemblies; ++i) {
            PartList list;
            kMakers[i](list);
            build(i, list);
        }
        PartList ground;
        ground.disc(vec(0), kUp, 400, vec(0.42f, 0.45f, 0.36f));
        build(kGround, ground);
        AssemblyParams& p = launch_.params;
        const auto across = unsigned(std::sqrt(settings.some(20000, 100)));
        p.yard = scene_.buildInstances(place(across));
        p.camera = makeCamera(vec(-4, 5, -12), vec(0, 0.5f, -2), kUp, 45, settings.aspect());
        p.sun = normalize(vec(-0.6f, 0.6f, -0.35f));
        p.reach = 3;
        p.samples = 1;
        p.openRays = 6;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        o.numPayloadValues = 7;
        o.numAttributeValues = 3;
        const OptixModule module = programs_.load(bench_fifth_assemblies_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__yard"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto open = programs_.miss({module, "__miss__open"});
        OptixProgramGroup kinds[kPartKinds];
        static constexpr const char* kNames[kPartKinds] = {
            "__intersection__ball", "__intersection__disc", "__intersection__box",
            "__intersection__rod"};
        for (unsigned i = 0; i < kPartKinds; ++i)
            kinds[i] = programs_.hit({{module, "__closesthit__part"}, {}, {module, kNames[i]}});
        pipeline_ = programs_.link({raygen, sky, open, kinds[0], kinds[1], kinds[2], kinds[3]},
                                   {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(open)});
        std::vector<SbtRecord<AssemblyRecord>> records;
        for (const AssemblyRecord& r : records_)
            for (const OptixProgramGroup kind : kinds)
                records.push_back(makeRecord(kind, r));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    // One structure with a record for each kind of parts.
    void build(unsigned number, const PartList& list) {
        records_[number].parts = scene_.upload(list.parts);
        const CUdeviceptr boxes = addressOf(scene_, list.boxes);
        const std::vector<unsigned> flags(kPartKinds, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        OptixBuildInputCustomPrimitiveArray& c = input.customPrimitiveArray;
        c.aabbBuffers = &boxes;
        c.numPrimitives = unsigned(list.boxes.size());
        c.flags = flags.data();
        c.numSbtRecords = kPartKinds;
        c.sbtIndexOffsetBuffer = addressOf(scene_, list.kinds);
        c.sbtIndexOffsetSizeInBytes = sizeof(unsigned char);
        structures_[number] = scene_.build(input);
    }
    std::vector<OptixInstance> place(unsigned across) const {
        std::vector<OptixInstance> all = {
            instanceOf(structures_[kGround], kIdentity, 0, kGround * kPartKinds)};
        for (unsigned i = 1; i <= across * across; ++i) {
            const float x = 2.5f * (float(i % across) + 0.6f * randomOf(i, 0)) -
                            1.25f * float(across),
                        z = 2.5f * (float(i / across) + 0.6f * randomOf(i, 1)) -
                            1.25f * float(across);
            const auto number = unsigned(kAssemblies * randomOf(i, 2));
            const Placement to = placed(vec(x, 0, z), 0.7f + 0.6f * randomOf(i, 3), randomOf(i, 4));
            all.push_back(instanceOf(structures_[number], to.matrix, i, number * kPartKinds));
        }
        return all;
    }

    OptixTraversableHandle structures_[kAssemblies + 1] = {};
    AssemblyRecord records_[kAssemblies + 1] = {};
    Launch<AssemblyParams> launch_;
};

} // namespace

JobKind assembliesJob() {
    return fifthJob<Assemblies>("assemblies", "20,000 instances of short intersection programs",
                                0.002, 0.02);
}

} // namespace bench
