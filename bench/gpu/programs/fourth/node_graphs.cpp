// SPDX-License-Identifier: Apache-2.0
// Objects whose materials are graphs of nodes, evaluated by callables that call each other;
// device/node_graphs.cu.
#include "programs.h"

#include "device/node_graphs.h"

std::string_view bench_fourth_node_graphs_ptx();

namespace bench {
namespace {

constexpr unsigned kShapes = 5, kMaterials = 24;

// Random graphs of limited depth. Each node follows its inputs.
class Graphs {
public:
    Graphs() {
        for (unsigned i = 0; i < kMaterials; ++i)
            roots[i] = {grow(4), grow(2)};
    }
    // The nodes of a material.
    struct Roots {
        unsigned albedo, gloss;
    };
    std::vector<Node> nodes;
    Roots roots[kMaterials];

private:
    float next(unsigned stream) { return randomOf(count_, stream); }
    unsigned grow(unsigned depth) {
        ++count_;
        Node node = {};
        node.color = colorOf(count_) * colorOf(count_) * 1.4f;
        node.scale = 1 + 3 * next(5);
        // The first kinds but marble have no inputs.
        static constexpr unsigned kLeaves[] = {kConstant, kPicture, kNoise, kWood, kFacing};
        static constexpr unsigned kInner[] = {kMarble,   kTiles, kSpots, kMix,
                                              kMultiply, kRamp,  kWarp};
        if (depth == 0) {
            node.kind = kLeaves[unsigned(float(std::size(kLeaves)) * next(6))];
            node.inputs[0] = count_;
        } else {
            node.kind = kInner[unsigned(float(std::size(kInner)) * next(6))];
            if (node.kind == kWarp)
                node.scale = 0.6f;
            for (unsigned& input : node.inputs)
                input = grow(depth - 1);
        }
        nodes.push_back(node);
        return unsigned(nodes.size() - 1);
    }
    unsigned count_ = 0;
};

class NodeGraphs : public Renderer {
public:
    NodeGraphs(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        makeShapes(settings);
        for (unsigned i = 0; i < 2; ++i)
            pictures_.emplace_back(spots(70 + i, 256), 256);
        GraphParams& p = launch_.params;
        p.scene = scene_.buildInstances(place(settings.some(2500, 30)));
        p.nodes = scene_.upload(graphs_.nodes);
        for (unsigned i = 0; i < 2; ++i)
            p.pictures[i] = pictures_[i].object();
        p.camera =
            makeCamera(vec(-3, 3, -9), vec(0, 0.2f, -1), vec(0, 1, 0), 40, settings.aspect());
        p.sun = normalize(vec(-0.5f, 0.7f, -0.4f));
        p.samples = 2;
        p.maxDepth = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 4;
        static constexpr const char* kNames[kNodeKinds] = {
            "constant", "picture", "noise",    "marble", "wood",   "tiles",
            "spots",    "mix",     "multiply", "ramp",   "facing", "warp"};
        const OptixModule module = programs_.load(bench_fourth_node_graphs_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__graphs"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto lit = programs_.miss({module, "__miss__lit"});
        const auto hit = programs_.hit({{module, "__closesthit__graph"}, {}, {}});
        std::vector<OptixProgramGroup> groups = {raygen, sky, lit, hit};
        std::vector<SbtRecord<NoData>> callables;
        for (const char* name : kNames) {
            groups.push_back(
                programs_.direct({module, (std::string("__direct_callable__") + name).c_str()}));
            callables.push_back(makeRecord(groups.back()));
        }
        pipeline_ = programs_.link(groups, {.trace = 4, .graph = 2, .directCallables = 5});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(lit)});
        std::vector<SbtRecord<GraphRecord>> records;
        for (const GraphRecord& r : records_)
            records.push_back(makeRecord(hit, r));
        table_.setHits(records);
        table_.setCallables(callables);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    void makeShapes(const JobSettings& settings) {
        const auto p = [](float r, float y) { return make_float2(r, y); };
        const unsigned sectors = settings.some(400, 24), flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const Mesh shapes[kShapes] = {
            makeRock(settings.some(80000, 80)), makeBox(vec(-0.8f), vec(0.8f)),
            makeLathe({p(0.001f, -1), p(0.6f, -0.9f), p(0.9f, -0.3f), p(0.5f, 0.4f), p(0.35f, 0.7f),
                       p(0.5f, 1), p(0.001f, 1)},
                      sectors),
            makeLathe({p(0.4f, -0.4f), p(1, -0.4f), p(1, 0.4f), p(0.4f, 0.4f), p(0.4f, -0.4f)},
                      sectors),
            makeBox(vec(-40, -1, -40), vec(40, 0, 40))};
        for (unsigned i = 0; i < kShapes; ++i) {
            const MeshMemory memory = uploadMesh(scene_, shapes[i]);
            children_[i] = scene_.build(inputOf(memory, flags));
            for (unsigned k = 0; k < kMaterials; ++k)
                records_.push_back(
                    {viewOf(memory), graphs_.roots[k].albedo, graphs_.roots[k].gloss});
        }
    }
    std::vector<OptixInstance> place(unsigned count) const {
        std::vector<OptixInstance> all = {
            instanceOf(children_[kShapes - 1], kIdentity, 0, (kShapes - 1) * kMaterials + 3)};
        for (unsigned i = 0; i < count; ++i) {
            const float2 c = circlePoint(randomOf(i, 0));
            const float r = 9 * std::sqrt(randomOf(i, 1)),
                        size = 0.12f + 0.5f * randomOf(i, 2) * randomOf(i, 3);
            const unsigned shape = i % (kShapes - 1),
                           material = unsigned(float(kMaterials) * randomOf(i, 4));
            const Placement to = placed(vec(r * c.x, 0.8f * size, r * c.y), size, randomOf(i, 5));
            all.push_back(
                instanceOf(children_[shape], to.matrix, i, shape * kMaterials + material));
        }
        return all;
    }

    Graphs graphs_;
    std::vector<Texture> pictures_;
    OptixTraversableHandle children_[kShapes] = {};
    std::vector<GraphRecord> records_;
    Launch<GraphParams> launch_;
};

} // namespace

JobKind nodeGraphsJob() {
    return fourthJob<NodeGraphs>(
        "node_graphs", "materials as graphs, of callables that call callables", 0.002, 0.02);
}

} // namespace bench
