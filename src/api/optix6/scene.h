// SPDX-License-Identifier: Apache-2.0
// The data that a launch needs from a context's objects: a pipeline of all programs in use, records
// and blocks of variables, acceleration structures, tables of ids.
//
// Setting a variable writes its value into a block. All other changes wait for the next launch: it
// builds dirty structures, adapts the records to the graph, and changes the pipeline if a program
// is new. All data that programs read is in memory that they share with the host.
#pragma once

#include "api/optix6/context.h"
#include "engine/accel.h"
#include "engine/launch.h"

#include <set>
#include <utility>

namespace sunstone::optix6 {

// The values of a program's variables in one set of scopes. Programs with equal variables in all
// scopes share a block.
struct Block {
    std::shared_ptr<const ProgramCode> code;
    std::vector<std::shared_ptr<Variable>> found; // by variable of the code; null: its initialiser
    uint8_t* memory = nullptr;                    // of the scene's pool
    void write(uint32_t index);
    uint8_t* slot(uint32_t index) const { return memory + code->variables.list[index].slot; }
};

// The acceleration of the node's geometry or children; null if it has none.
Acceleration* accelerationOf(Node& node);

bvh::MotionOptions optionsOf(const Motion& motion);
bool sameMotion(const bvh::MotionOptions& a, const bvh::MotionOptions& b);

class Scene {
public:
    explicit Scene(Context& context);

    // Updates the scene. Throws Failure: the context's objects are incomplete, or a program's
    // variable is missing; the next call then rebuilds the scene.
    void update();
    void launch(unsigned entryPoint, uint32_t width, uint32_t height, uint32_t depth);
    // A launch of the scene in the state of the last update(); valid until the next change. Throws
    // Failure: the entry point has no program.
    engine::LaunchRequest request(unsigned entryPoint, uint32_t width, uint32_t height,
                                  uint32_t depth) const;
    // Runs the launch to its end. `subframe`: the value of rtSubframeIndex.
    void run(const engine::LaunchRequest& request, uint32_t subframe);
    // Throws Failure if the node, or an object below it, is incomplete.
    void validate(Node& node);

private:
    using Scopes = std::vector<const Scope*>;
    using GroupKey =
        std::pair<devlib::GroupKind, std::array<const ProgramCode*, devlib::kRoleCount>>;
    struct RoleProgram {
        devlib::Role role;
        const Program* program; // null: none
        compiler::ProgramKind kind;
    };

    template <class T>
    SharedAllocator<T> allocator() const {
        return SharedAllocator<T>(context_.engine->backend);
    }

    // scene.cpp
    void collectNodes();
    void linkNodes();
    void checkDepth() const;
    void visitNode(const std::shared_ptr<Node>& node, std::vector<const Node*>& path);
    void bind();
    void bindEntries();
    void collectSamplers();
    void bindHits(GeometryGroup& group);
    void bindInstance(const GeometryInstance& instance, size_t number);
    void remarkOnAttributes(const Program& reader, const Program* setter);
    devlib::ClassicRecord hitRecord(const GeometryInstance& instance, const Scope& shape,
                                    const Material* material, unsigned rayType);
    void bindVisit(const Selector& selector);
    void updateTextures();
    void fillTables();
    void fillIds();
    void fillNodes();
    bool hasMotion() const;
    bool hasOneLevel() const;
    void makePipeline();
    void reserveStack();
    compiler::PipelineRules rules() const;

    // binding.cpp
    devlib::SbtView table() const;
    static Scopes withOwn(const Program& program, Scopes scopes);
    const void* block(const Program& program, Scopes scopes);
    std::shared_ptr<Variable> resolve(const compiler::optix6::DeviceVariable& wanted,
                                      const ProgramCode& code, const Scopes& scopes) const;
    int boundCallable(const Program& program, Scopes scopes);
    devlib::ClassicRecord record(devlib::GroupKind kind, const std::vector<RoleProgram>& programs);

    // structures.cpp
    void buildStructures();
    void followChanges();
    void clearChanges();
    bool refresh(Node& node, const std::vector<uint32_t>* slots);
    void buildGeometry(GeometryGroup& group);
    void buildSet(Acceleration& acceleration, Acceleration::Built& built,
                  const GeometryGroup& group, const GeometrySet& set);
    void buildGroup(Group& group, const std::vector<uint32_t>* slots);
    void showAll(Group& group);
    void showSlots(Group& group, const std::vector<uint32_t>& slots);
    void makeNode(Node& node);
    void makeMotionTransform(Transform& transform, const Child& child);
    static bool isPlain(const Child& child);
    void makeVisitNode(Selector& selector);
    static std::vector<Child> childrenOf(Node& node);
    void build(Acceleration::Built& built, std::shared_ptr<const engine::AccelInputs> inputs,
               const bvh::BuildOptions& options, bool isUpdate);
    InstanceStructure& structure(std::unique_ptr<InstanceStructure>& slot) const;
    bvh::CustomInput customOf(engine::AccelInputs& inputs, const GeometryInstance& instance,
                              const Geometry& geometry);
    SharedVector<float> boxesOf(const GeometryInstance& instance, const Geometry& geometry,
                                unsigned step);

    Context& context_;
    std::vector<std::shared_ptr<Node>> order_; // children before parents
    std::set<const Acceleration*> settled_;    // of geometry groups that this update has visited
    std::set<const Node*> seen_;
    bool hasMotion_ = false, hasOneLevel_ = false; // of the graph
    // Variables with samplers.
    std::vector<std::pair<std::shared_ptr<Variable>, Ref<TextureSampler>>> samplers_;
    SharedPool blockMemory_;
    std::map<std::pair<const ProgramCode*, std::vector<Variable*>>, std::unique_ptr<Block>> blocks_;
    // Numbers of the programs of variables, by the scopes in which they search.
    std::map<std::pair<const Program*, Scopes>, int> boundCallables_;
    // Pairs of programs that remarkOnAttributes has compared.
    std::set<std::pair<const ProgramCode*, const ProgramCode*>> remarked_;
    bool bindsCycle_ = false; // a program calls itself through variables
    // Of the bound programs that are being numbered: length of the chain; numbers given before it.
    size_t boundDepth_ = 0, boundBefore_ = 0;
    struct BoundGroup {
        std::shared_ptr<engine::ProgramGroup> group;
        std::vector<std::shared_ptr<const ProgramCode>> codes; // their addresses are in the key
        uint32_t bind = 0, pipeline = 0;                       // numbers of the last users
    };
    std::map<GroupKey, BoundGroup> groups_;
    uint32_t bind_ = 0, pipelines_ = 0; // numbers of the latest ones
    bool isBroken_ = false;             // the last attempt to make a pipeline failed
    std::set<uint32_t> compiled_;       // numbers of groups in the pipeline
    bool needsPipeline_ = true;
    std::shared_ptr<engine::Pipeline> pipeline_;
    compiler::PipelineRules rules_;
    using Records = SharedVector<devlib::ClassicRecord>;
    Records rayGeneration_, exception_, misses_, hits_, callables_, bounds_, visits_;
    std::map<const GeometryInstance*, size_t> boundsOf_; // places in bounds_
    std::map<const Node*, size_t> visitOf_;              // of selectors, in visits_
    // Boxes and transforms for the inputs of the structure under construction.
    std::vector<SharedVector<float>> kept_;
    SharedVector<uint64_t> nodes_, textures_;
    SharedVector<const devlib::BufferView*> views_;
    // Copies for comparison.
    std::vector<uint64_t> nodesCopy_, texturesCopy_;
    std::vector<const devlib::BufferView*> viewsCopy_;
    devlib::ClassicLaunch launchCopy_{};
    std::set<const Object*> newTextures_; // that blocks must refer to
    SharedMemory shared_;                 // Tables
    struct Tables {
        devlib::ClassicLaunch launch;
        devlib::BufferView emptyView;
    };
    Tables& tables() const { return *static_cast<Tables*>(shared_.get()); }
};

} // namespace sunstone::optix6
