// SPDX-License-Identifier: Apache-2.0
// A viewer of an assembly of machine parts, cut open by two planes; device/section_view.cu. Its
// pipeline is set up for anything: exceptions, any graph, deeper rays than it traces.
#include "programs.h"

#include "device/section_view.h"

std::string_view bench_third_section_view_ptx();

namespace bench {
namespace {

constexpr unsigned kShapes = 6;

// Solids with inner walls, so that cuts show their thickness.
Mesh makePart(unsigned shape, unsigned sectors) {
    const auto p = [](float r, float y) { return make_float2(r, y); };
    switch (shape) {
    case 0: // gear
        return makeLathe({p(0.3f, -0.2f), p(1, -0.2f), p(1, 0.2f), p(0.3f, 0.2f), p(0.3f, -0.2f)},
                         sectors, sectors / 6);
    case 1: // pipe with flanges
        return makeLathe({p(0.3f, -1), p(0.7f, -1), p(0.7f, -0.8f), p(0.4f, -0.75f), p(0.4f, 0.75f),
                          p(0.7f, 0.8f), p(0.7f, 1), p(0.3f, 1), p(0.3f, -1)},
                         sectors);
    case 2: { // housing
        Mesh mesh = makeBox(vec(-0.8f), vec(0.8f));
        append(mesh, makeBox(vec(-0.65f), vec(0.65f)), vec(-1, 1, 1), vec(0)); // turned inside out
        return mesh;
    }
    case 3: // bolt
        return makeLathe(
            {p(0, -1), p(0.25f, -1), p(0.25f, 0.5f), p(0.5f, 0.5f), p(0.5f, 0.9f), p(0, 0.9f)},
            sectors);
    case 4: { // bearing: rings with balls
        Mesh mesh = makeLathe(
            {p(0.8f, -0.2f), p(1, -0.2f), p(1, 0.2f), p(0.8f, 0.2f), p(0.8f, -0.2f)}, sectors);
        append(mesh, Mesh(mesh), vec(0.5f, 1, 0.5f), vec(0));
        const Mesh ball = makeRock(sectors * 8);
        for (unsigned i = 0; i < 10; ++i)
            append(
                mesh, ball, vec(0.14f),
                vec(0.65f * std::cos(0.628f * float(i)), 0, 0.65f * std::sin(0.628f * float(i))));
        return mesh;
    }
    default: // vessel
        return makeLathe({p(0, -0.9f), p(0.6f, -0.8f), p(0.8f, 0), p(0.5f, 0.7f), p(0.3f, 1),
                          p(0.25f, 1), p(0.42f, 0.66f), p(0.7f, 0), p(0.53f, -0.7f), p(0, -0.8f)},
                         sectors);
    }
}

class SectionView : public Renderer {
public:
    SectionView(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
        for (unsigned i = 0; i < kShapes; ++i) {
            const MeshMemory memory = uploadMesh(scene_, makePart(i, settings.some(360, 24)));
            parts_[i] = scene_.build(inputOf(memory, flags));
            meshes_[i] = viewOf(memory);
        }
        SectionParams& p = launch_.params;
        p.assembly = scene_.buildInstances(assemble(settings.some(900, 40)));
        p.camera =
            makeCamera(vec(-13, 10, -17), vec(0, -0.5f, 0), vec(0, 1, 0), 34, settings.aspect());
        p.planes[0] = make_float4(0, 0, -1, -1);
        p.planes[1] = make_float4(-0.8f, 0.6f, 0, 1);
        p.sun = normalize(vec(-0.4f, 0.8f, -0.6f));
        p.maxLayers = 4;
        p.image = allocatePicture();
        p.width = width_;
    }
    void compile() override {
        programs_.moduleOptions.optLevel = OPTIX_COMPILE_OPTIMIZATION_LEVEL_3;
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
        o.numPayloadValues = 8;
        o.exceptionFlags = OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW | OPTIX_EXCEPTION_FLAG_TRACE_DEPTH |
                           OPTIX_EXCEPTION_FLAG_USER;
        const OptixModule module = programs_.load(bench_third_section_view_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__view"});
        const auto miss = programs_.miss({module, "__miss__nothing"});
        const auto hit =
            programs_.hit({{module, "__closesthit__part"}, {module, "__anyhit__clip"}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {.trace = 5, .graph = 3});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        std::vector<SbtRecord<SectionRecord>> records;
        for (unsigned i = 0; i < kMaterials; ++i)
            records.push_back(makeRecord(hit, recordOf(i)));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    static constexpr unsigned kMaterials = kShapes * 16;

    // Everything that the viewer knows of a part.
    SectionRecord recordOf(unsigned i) const {
        SectionRecord r = {};
        r.mesh = meshes_[i % kShapes];
        r.color = colorOf(i);
        r.specular = 0.2f + 0.6f * randomOf(i, 5);
        r.alpha = i % 7 == 3 ? 0.35f : 1.0f;
        r.isClipped = i % 11 != 4;
        r.capColor = colorOf(i) * 0.5f + vec(0.35f, 0.1f, 0);
        r.hatchStep = 0.12f + 0.1f * randomOf(i, 6);
        r.hatchTurn = randomOf(i, 7);
        return r;
    }
    std::vector<OptixInstance> assemble(unsigned count) const {
        std::vector<OptixInstance> instances;
        for (unsigned i = 0; i < count; ++i) {
            const float r = 8 * std::cbrt(randomOf(i, 0)), y = 2 * randomOf(i, 1) - 1;
            const float2 c = circlePoint(randomOf(i, 2));
            const float level = std::sqrt(1 - y * y);
            const float3 at = vec(r * level * c.x, 0.7f * r * y, r * level * c.y);
            const Placement to = placed(at, 0.5f + 0.6f * randomOf(i, 3), randomOf(i, 4));
            const unsigned material = i % kMaterials;
            instances.push_back(instanceOf(parts_[material % kShapes], to.matrix, i + 1, material));
        }
        return instances;
    }

    Launch<SectionParams> launch_;
    OptixTraversableHandle parts_[kShapes] = {};
    MeshView meshes_[kShapes] = {};
};

} // namespace

JobKind sectionViewJob() {
    return thirdJob<SectionView>("section_view",
                                 "machine parts behind clipping planes, with outlines and glass",
                                 0.002, 0.02);
}

} // namespace bench
