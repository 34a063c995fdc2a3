// SPDX-License-Identifier: Apache-2.0
// Collision queries for millions of configurations of a robot's arm; device/motion_planner.cu.
#include "programs.h"

#include "device/motion_planner.h"

std::string_view bench_fourth_motion_planner_ptx();

namespace bench {
namespace {

enum Obstacle : unsigned { kHard, kSoft, kObstacles };

// Shelves with parts, pipes, a cable net and curtains around the robot.
MaterialMesh makeWorkshop(const JobSettings& settings) {
    MaterialMesh mesh;
    mesh.looks.resize(kObstacles);
    append(mesh, makeBox(vec(-6, -0.2f, -6), vec(6, 0, 6)), vec(1), vec(0), kHard);
    const Mesh rock = makeRock(settings.some(6000, 40));
    for (unsigned i = 0; i < 90; ++i) {
        const float2 c = circlePoint(float(i % 30) / 30);
        const float level = 0.5f + 0.9f * float(i / 30);
        append(mesh, rock, vec(0.08f + 0.2f * randomOf(i, 0)),
               vec(2.6f * c.x, level + 0.2f, 2.6f * c.y), kHard);
        if (i % 3)
            append(mesh, makeBox(vec(-0.4f, -0.04f, -0.4f), vec(0.4f, 0, 0.4f)), vec(1),
                   vec(2.6f * c.x, level, 2.6f * c.y), kHard);
    }
    const Mesh pipe =
        makeLathe({make_float2(0.05f, -1), make_float2(0.05f, 1)}, settings.some(64, 12));
    for (unsigned i = 0; i < 24; ++i) {
        const float2 c = circlePoint(randomOf(i, 1));
        append(mesh, pipe, vec(1, 1.6f, 1), vec(1.5f * c.x, 1.6f, 1.5f * c.y), kHard);
    }
    const auto cells = settings.some(400, 12);
    for (unsigned i = 0; i < 3; ++i) {
        const float2 c = circlePoint(0.1f + 0.3f * float(i));
        append(mesh,
               makeSheet(cells, cells,
                         [&](float u, float v) {
                             const float r = 1.9f + 0.05f * std::sin(70 * u);
                             return vec(r * c.x - (u - 0.5f) * c.y, 0.1f + 2 * v,
                                        r * c.y + (u - 0.5f) * c.x);
                         }),
               vec(1), vec(0), kSoft);
    }
    return mesh;
}

class MotionPlanner : public Renderer {
public:
    MotionPlanner(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        PlannerParams& p = launch_.params;
        p.workshop = buildWorkshop(makeWorkshop(settings));
        p.across = unsigned(std::sqrt(settings.some(2e6, 48 * 48)));
        p.results = scene_.allocate<ArmResult>(size_t(p.across) * p.across);
        const ArmLink links[kJoints] = {{0.5f, 0.12f}, {1, 0.09f},    {0.8f, 0.07f},
                                        {0.5f, 0.05f}, {0.3f, 0.04f}, {0.25f, 0.08f}};
        const float angles[kJoints] = {0, 0.02f, 0.08f, 0.05f, 0.1f, 0.02f};
        std::copy(std::begin(links), std::end(links), p.links);
        std::copy(std::begin(angles), std::end(angles), p.angles);
        p.base = vec(0, 0.15f, 0);
        p.reach = 0.8f;
        p.width = width_;
        p.height = height_;
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.options.numPayloadValues = 1;
        programs_.options.numAttributeValues = 0;
        const OptixModule module = programs_.load(bench_fourth_motion_planner_ptx());
        const auto configurations = programs_.raygen({module, "__raygen__configurations"});
        const auto map = programs_.raygen({module, "__raygen__map"});
        const auto miss = programs_.miss({});
        // Contacts and distances; a record of each for each material.
        const OptixProgramGroup hits[] = {
            programs_.hit({{}, {module, "__anyhit__contact"}, {}}),
            programs_.hit({{module, "__closesthit__distance"}, {}, {}})};
        pipeline_ = programs_.link({configurations, map, miss, hits[0], hits[1]}, {});
        table_.setRaygen(makeRecord(configurations));
        mapTable_.setRaygen(makeRecord(map));
        std::vector<SbtRecord<ObstacleRecord>> records;
        for (unsigned i = 0; i < 2 * kObstacles; ++i)
            records.push_back(makeRecord(hits[i % 2], ObstacleRecord{i / 2}));
        for (Table* table : {&table_, &mapTable_}) {
            table->setMisses(std::vector{makeRecord(miss)});
            table->setHits(records);
        }
    }
    void renderFrame() override {
        launch_.run(pipeline_, table_, launch_.params.across * launch_.params.across);
        launch_.run(pipeline_, mapTable_, width_, height_);
    }

private:
    OptixTraversableHandle buildWorkshop(const MaterialMesh& mesh) {
        const MeshMemory memory = {
            addressOf(scene_, mesh.vertices), addressOf(scene_, mesh.indices),
            unsigned(mesh.vertices.size() / 3), unsigned(mesh.indices.size() / 3)};
        // Each contact counts once.
        const unsigned flags[kObstacles] = {OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL,
                                            OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL};
        OptixBuildInput input = inputOf(memory, flags[0]);
        input.triangleArray.numSbtRecords = kObstacles;
        input.triangleArray.sbtIndexOffsetBuffer = addressOf(scene_, mesh.materials);
        input.triangleArray.sbtIndexOffsetSizeInBytes = sizeof(uint8_t);
        return scene_.build(input);
    }

    Table mapTable_;
    Launch<PlannerParams> launch_;
};

} // namespace

JobKind motionPlannerJob() {
    return fourthJob<MotionPlanner>(
        "motion_planner", "contacts of two million configurations of a robot's arm", 0.005, 0.05);
}

} // namespace bench
