// SPDX-License-Identifier: Apache-2.0
// Smooth bodies of bicubic patches, which are custom primitives; device/bezier_patches.cu.
#include "programs.h"

#include "device/bezier_patches.h"

#include <functional>

std::string_view bench_fourth_bezier_patches_ptx();

namespace bench {
namespace {

constexpr unsigned kBodies = 4;
using Surface2 = std::function<float3(float, float)>;

// A point on a closed curve and a ring around it.
float3 tubeAt(const std::function<float3(float)>& curve, float u, float v, float radius) {
    const float3 at = curve(u), ahead = curve(u + 1e-3f);
    const float3 along = normalize(ahead - at), side = normalize(cross(along, vec(0.1f, 1, 0.05f)));
    const float2 c = circlePoint(v - std::floor(v));
    return at + (side * c.x + cross(along, side) * c.y) * radius;
}
float3 knotAt(float u) {
    const float a = 2 * kPi * u;
    return vec(std::sin(a) + 2 * std::sin(2 * a), std::sin(3 * a),
               std::cos(a) - 2 * std::cos(2 * a)) *
           0.33f;
}
float3 bodyAt(unsigned body, float u, float v) {
    const float2 c = circlePoint(u - std::floor(u));
    const float fold = 2 * kPi * u;
    switch (body) {
    case 0: // a ring with waves
        return tubeAt(
            [](float x) { return vec(std::cos(2 * kPi * x), 0, std::sin(2 * kPi * x)) * 0.75f; }, u,
            v, 0.22f + 0.05f * std::sin(7 * fold));
    case 1:
        return tubeAt(knotAt, u, v, 0.17f);
    case 2: { // a vase, whose v ends at its rim
        const float r = 0.35f + 0.25f * std::sin(5.5f * v + 0.4f) + 0.03f * std::cos(9 * fold);
        return vec(r * c.x, 2 * v - 1, r * c.y);
    }
    default: { // a shell, whose ends meet in points
        const float r =
            std::sin(kPi * (0.002f + 0.996f * v)) * (0.8f + 0.12f * std::cos(6 * fold + 8 * v));
        return vec(r * c.x, -0.9f * std::cos(kPi * v), r * c.y);
    }
    }
}

// Patches that have the positions and slopes of a surface at their corners.
std::vector<BezierPatch> fit(const Surface2& surface, unsigned columns, unsigned rows) {
    std::vector<BezierPatch> patches;
    constexpr float kStep = 1e-3f;
    for (unsigned i = 0; i < columns * rows; ++i) {
        BezierPatch patch;
        for (unsigned corner = 0; corner < 4; ++corner) {
            const unsigned right = corner & 1, top = corner >> 1;
            const float u = float(i % columns + right) / float(columns),
                        v = float(i / columns + top) / float(rows);
            const float3 at = surface(u, v);
            const float3 alongU =
                (surface(u + kStep, v) - surface(u - kStep, v)) * (0.5f / kStep / float(columns));
            const float3 alongV =
                (surface(u, v + kStep) - surface(u, v - kStep)) * (0.5f / kStep / float(rows));
            const float3 du = alongU * (right ? -1.0f / 3 : 1.0f / 3),
                         dv = alongV * (top ? -1.0f / 3 : 1.0f / 3);
            const auto put = [&](unsigned inU, unsigned inV, float3 p) {
                patch.points[4 * (top ? 3 - inV : inV) + (right ? 3 - inU : inU)] = p;
            };
            put(0, 0, at);
            put(1, 0, at + du);
            put(0, 1, at + dv);
            put(1, 1, at + du + dv);
        }
        patches.push_back(patch);
    }
    return patches;
}
OptixAabb boundsOf(const BezierPatch& patch) {
    OptixAabb box = {1e30f, 1e30f, 1e30f, -1e30f, -1e30f, -1e30f};
    for (const float3 p : patch.points) {
        box = {std::min(box.minX, p.x), std::min(box.minY, p.y), std::min(box.minZ, p.z),
               std::max(box.maxX, p.x), std::max(box.maxY, p.y), std::max(box.maxZ, p.z)};
    }
    return box;
}

class BezierPatches : public Renderer {
public:
    BezierPatches(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const float detail = std::sqrt(settings.some(1000, 60) / 1000.0f);
        for (unsigned i = 0; i < kBodies; ++i) {
            const std::vector<BezierPatch> patches =
                fit([i](float u, float v) { return bodyAt(i, u, v); }, unsigned(64 * detail),
                    unsigned(24 * detail));
            std::vector<OptixAabb> boxes;
            for (const BezierPatch& patch : patches)
                boxes.push_back(boundsOf(patch));
            bodies_[i] = scene_.buildBoxes(boxes, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
            records_[i].patches = scene_.upload(patches);
        }
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const MeshMemory ground = uploadMesh(scene_, makeBox(vec(-90, -2, -90), vec(90, 0, 90)));
        std::vector<OptixInstance> all = {
            instanceOf(scene_.build(inputOf(ground, flags)), kIdentity, 0, kBodies)};
        const unsigned count = settings.some(400, 16);
        for (unsigned i = 1; i <= count; ++i) {
            const float2 c = circlePoint(float(i) * 0.381966f - std::floor(float(i) * 0.381966f));
            const float r = 1.15f * std::sqrt(float(i));
            const Placement to =
                placed(vec(r * c.x, 1.05f, r * c.y), 0.75f + 0.3f * randomOf(i, 0), randomOf(i, 1));
            all.push_back(instanceOf(bodies_[i % kBodies], to.matrix, i, i % kBodies));
        }
        BezierParams& p = launch_.params;
        p.gallery = scene_.buildInstances(all);
        p.camera =
            makeCamera(vec(-4, 6.5f, -13), vec(0, 0, -3), vec(0, 1, 0), 45, settings.aspect());
        p.sun = normalize(vec(-0.6f, 0.7f, -0.35f));
        p.samples = 1;
        p.openRays = 2;
        p.reach = 3;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        o.numPayloadValues = 5;
        const OptixModule module = programs_.load(bench_fourth_bezier_patches_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__gallery"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto patch =
            programs_.hit({{module, "__closesthit__patch"}, {}, {module, "__intersection__patch"}});
        const auto floor = programs_.hit({{module, "__closesthit__floor"}, {}, {}});
        const OptixProgramGroup shadings[kPatchShadings] = {
            programs_.continuation({module, "__continuation_callable__ceramic"}),
            programs_.continuation({module, "__continuation_callable__chrome"}),
            programs_.continuation({module, "__continuation_callable__velvet"})};
        pipeline_ =
            programs_.link({raygen, sky, open, patch, floor, shadings[0], shadings[1], shadings[2]},
                           {.trace = 1, .graph = 2, .continuationCallables = 1});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(open)});
        std::vector<SbtRecord<BezierRecord>> records;
        for (const BezierRecord& r : records_)
            records.push_back(makeRecord(r.patches ? patch : floor, r));
        table_.setHits(records);
        table_.setCallables(
            std::vector{makeRecord(shadings[0]), makeRecord(shadings[1]), makeRecord(shadings[2])});
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    OptixTraversableHandle bodies_[kBodies] = {};
    BezierRecord records_[kBodies + 1] = {};
    Launch<BezierParams> launch_;
};

} // namespace

JobKind bezierPatchesJob() {
    return fourthJob<BezierPatches>("bezier_patches",
                                    "bicubic patches by Newton's iteration, continuation callables",
                                    0.005, 0.05);
}

} // namespace bench
