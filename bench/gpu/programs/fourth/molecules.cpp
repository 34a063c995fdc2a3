// SPDX-License-Identifier: Apache-2.0
// A cell full of molecules: chains of atoms, which are OptiX's spheres, some as sticks, which are
// linear curves; device/molecules.cu.
#include "programs.h"

#include "device/molecules.h"

std::string_view bench_fourth_molecules_ptx();

namespace bench {
namespace {

constexpr unsigned kProteins = 6, kSticks = 2, kFolds = kProteins + kSticks;

// A walk that stays within a ball, as centres of atoms.
std::vector<float3> foldChain(unsigned seed, unsigned atoms, float radius) {
    std::vector<float3> points;
    float3 at = vec(0), heading = vec(1, 0, 0);
    for (unsigned i = 0; i < atoms; ++i) {
        const unsigned number = seed * 1000003 + i;
        const float y = 2 * randomOf(number, 0) - 1, level = std::sqrt(1 - y * y);
        const float2 c = circlePoint(randomOf(number, 1));
        heading = normalize(heading * 0.6f + vec(level * c.x, y, level * c.y) * 0.8f -
                            at * (0.35f * dot(at, at) / (radius * radius * radius)));
        at += heading * 0.15f;
        points.push_back(at);
    }
    return points;
}

class Molecules : public Renderer {
public:
    Molecules(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const unsigned atoms = settings.some(40000, 120);
        for (unsigned i = 0; i < kFolds; ++i) {
            radii_[i] = 0.12f * std::cbrt(float(atoms)) * (0.7f + 0.3f * randomOf(i, 3));
            const std::vector<float3> chain = foldChain(i, atoms, radii_[i]);
            folds_[i] = i < kProteins ? buildSpheres(chain) : buildSticks(chain);
        }
        MoleculeParams& p = launch_.params;
        const unsigned count = settings.some(600, 24);
        const float side = 3.2f * radii_[0] * std::cbrt(float(count));
        p.cell = scene_.buildInstances(crowd(count, side));
        p.camera = makeCamera(vec(0, 0.1f, -0.85f) * side, vec(0.05f, -0.05f, 0) * side,
                              vec(0, 1, 0), 48, settings.aspect());
        p.sun = normalize(vec(-0.5f, 0.7f, -0.6f));
        p.reach = 0.5f * radii_[0];
        p.fogStart = 0.5f * side;
        p.openRays = 4;
        p.contourRays = 8;
        p.contourWidth = 1.5f;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR);
        o.numPayloadValues = 10;
        o.numAttributeValues = 1;
        const OptixModule module = programs_.load(bench_fourth_molecules_ptx());
        const OptixModule spheres = programs_.builtin(OPTIX_PRIMITIVE_TYPE_SPHERE, kFlags);
        const OptixModule sticks = programs_.builtin(OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, kFlags);
        const auto raygen = programs_.raygen({module, "__raygen__cell"});
        const auto none = programs_.miss({module, "__miss__none"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto atom = programs_.hit({{module, "__closesthit__atom"}, {}, {spheres, nullptr}});
        const auto stick = programs_.hit({{module, "__closesthit__stick"}, {}, {sticks, nullptr}});
        const OptixProgramGroup colors[kColorings] = {
            programs_.direct({module, "__direct_callable__element"}),
            programs_.direct({module, "__direct_callable__chain"}),
            programs_.direct({module, "__direct_callable__charge"})};
        pipeline_ =
            programs_.link({raygen, none, open, atom, stick, colors[0], colors[1], colors[2]},
                           {.trace = 1, .graph = 2, .directCallables = 1});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(none), makeRecord(open)});
        const float3 elements[kElements] = {vec(0.45f), vec(0.9f), vec(0.85f, 0.2f, 0.15f),
                                            vec(0.2f, 0.3f, 0.9f), vec(0.95f, 0.8f, 0.25f)};
        std::vector<SbtRecord<MoleculeRecord>> records;
        for (const float3 color : elements)
            records.push_back(makeRecord(atom, MoleculeRecord{color, 0.35f}));
        records.push_back(makeRecord(stick, MoleculeRecord{vec(0.7f, 0.75f, 0.6f), 0.15f}));
        table_.setHits(records);
        table_.setCallables(
            std::vector{makeRecord(colors[0]), makeRecord(colors[1]), makeRecord(colors[2])});
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    static constexpr unsigned kFlags = OPTIX_BUILD_FLAG_ALLOW_COMPACTION |
                                       OPTIX_BUILD_FLAG_PREFER_FAST_TRACE |
                                       OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;

    // Each element has a record and a radius.
    OptixTraversableHandle buildSpheres(const std::vector<float3>& chain) {
        static constexpr float kRadii[kElements] = {0.17f, 0.11f, 0.15f, 0.155f, 0.19f};
        std::vector<float4> balls;
        std::vector<uint8_t> elements;
        for (size_t i = 0; i < chain.size(); ++i) {
            const unsigned element = hashPcg(unsigned(i)) % kElements;
            elements.push_back(uint8_t(element));
            balls.push_back(make_float4(chain[i].x, chain[i].y, chain[i].z, kRadii[element]));
        }
        const CUdeviceptr centers = addressOf(scene_, balls), radii = centers + 3 * sizeof(float);
        const std::vector<unsigned> flags(kElements, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_SPHERES;
        OptixBuildInputSphereArray& s = input.sphereArray;
        s.vertexBuffers = &centers;
        s.vertexStrideInBytes = s.radiusStrideInBytes = sizeof(float4);
        s.numVertices = unsigned(balls.size());
        s.radiusBuffers = &radii;
        s.flags = flags.data();
        s.numSbtRecords = kElements;
        s.sbtIndexOffsetBuffer = addressOf(scene_, elements);
        s.sbtIndexOffsetSizeInBytes = sizeof(uint8_t);
        return scene_.build(input, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    }
    OptixTraversableHandle buildSticks(const std::vector<float3>& chain) {
        std::vector<float4> points;
        std::vector<unsigned> firsts;
        for (const float3 p : chain) {
            firsts.push_back(unsigned(points.size()));
            points.push_back(make_float4(p.x, p.y, p.z, 0.045f));
        }
        firsts.pop_back();
        const CUdeviceptr vertices = addressOf(scene_, points),
                          widths = vertices + 3 * sizeof(float);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
        OptixBuildInputCurveArray& c = input.curveArray;
        c.curveType = OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR;
        c.vertexBuffers = &vertices;
        c.vertexStrideInBytes = c.widthStrideInBytes = sizeof(float4);
        c.numVertices = unsigned(points.size());
        c.widthBuffers = &widths;
        c.indexBuffer = addressOf(scene_, firsts);
        c.indexStrideInBytes = sizeof(unsigned);
        c.numPrimitives = unsigned(firsts.size());
        c.flag = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        return scene_.build(input, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    }
    std::vector<OptixInstance> crowd(unsigned count, float side) const {
        std::vector<OptixInstance> all;
        for (unsigned i = 0; i < count; ++i) {
            const unsigned fold = i % kFolds;
            const float3 at =
                vec(randomOf(i, 0) - 0.5f, randomOf(i, 1) - 0.5f, randomOf(i, 2) - 0.5f) * side;
            const Placement to = placed(at, 0.8f + 0.5f * randomOf(i, 3), randomOf(i, 4));
            all.push_back(instanceOf(folds_[fold], to.matrix, i, fold < kProteins ? 0 : kElements));
        }
        return all;
    }

    float radii_[kFolds] = {};
    OptixTraversableHandle folds_[kFolds] = {};
    Launch<MoleculeParams> launch_;
};

} // namespace

JobKind moleculesJob() {
    return fourthJob<Molecules>(
        "molecules", "spheres and linear curves of molecules, with contours", 0.002, 0.02);
}

} // namespace bench
