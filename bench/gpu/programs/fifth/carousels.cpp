// SPDX-License-Identifier: Apache-2.0
// A fair with 400 carousels: frames of triangles, strings of spheres, garlands of curves. Half of
// the carousels turn, under SRT motion transforms; device/carousels.cu.
#include "programs.h"

#include "device/carousels.h"

#include <cstring>

std::string_view bench_fifth_carousels_ptx();

namespace bench {
namespace {

// Records: of the frame's looks, of the beads', of garlands, of the meadow.
enum CarouselLook : unsigned {
    kDeck,
    kRoof,
    kGold,
    kFrameLooks,
    kBeads = kFrameLooks,
    kGarland = kBeads + 3,
    kMeadow,
    kCarouselLooks
};
constexpr unsigned kSpeeds = 6, kArms = 12, kGraphDepth = 4;
constexpr unsigned kFlags = OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE |
                            OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;

float3 onArm(float arm, float radius, float y) {
    const float turns = arm / kArms;
    const float2 c = circlePoint(turns - std::floor(turns));
    return vec(radius * c.x, y, radius * c.y);
}
// A deck, a mast, a roof, and a pole for each arm.
MaterialMesh makeFrame(unsigned sectors) {
    const auto p = [](float r, float y) { return make_float2(r, y); };
    MaterialMesh mesh;
    mesh.looks.resize(kFrameLooks);
    append(mesh, makeLathe({p(0.01f, 0), p(2.1f, 0), p(2.1f, 0.2f), p(0.01f, 0.2f)}, sectors),
           vec(1), vec(0), kDeck);
    append(mesh, makeLathe({p(2.2f, 2.15f), p(1.2f, 2.6f), p(0.3f, 3.3f), p(0.01f, 3.5f)}, sectors),
           vec(1), vec(0), kRoof);
    append(mesh, makeLathe({p(0.25f, 0.2f), p(0.2f, 1.2f), p(0.3f, 3.2f)}, sectors / 4, 8), vec(1),
           vec(0), kGold);
    const Mesh pole = makeLathe({p(0.03f, 0.2f), p(0.03f, 2.2f)}, 12);
    for (unsigned i = 0; i < kArms; ++i)
        append(mesh, pole, vec(1), onArm(float(i), 1.7f, 0), kGold);
    return mesh;
}
// Lamps around the roof, and riders of five balls.
void addBeads(unsigned count, std::vector<float4>& balls, std::vector<unsigned char>& looks) {
    const auto add = [&](float3 at, float radius, unsigned look) {
        balls.push_back(make_float4(at.x, at.y, at.z, radius));
        looks.push_back((unsigned char)look);
    };
    for (unsigned i = 0; i < count; ++i) {
        const float arm = kArms * float(i) / float(count);
        add(onArm(arm, 2.22f, 2.1f), 0.035f, 0);
        add(onArm(arm, 1.2f, 2.66f), 0.03f, 0);
    }
    for (unsigned i = 0; i < kArms; ++i) {
        const float a = float(i), y = 0.65f + 0.3f * randomOf(i, 0);
        const unsigned look = 1 + i % 2;
        add(onArm(a, 1.7f, y), 0.2f, look);
        add(onArm(a + 0.25f, 1.7f, y + 0.12f), 0.16f, look);
        add(onArm(a - 0.25f, 1.7f, y), 0.17f, look);
        add(onArm(a + 0.4f, 1.7f, y + 0.3f), 0.11f, look);
        add(onArm(a, 1.7f, y + 0.34f), 0.13f, 3 - look);
    }
}
// Control points of garlands that hang between the poles, and the first of each segment.
void addGarlands(unsigned segments, std::vector<float4>& points, std::vector<unsigned>& firsts) {
    for (unsigned i = 0; i < 2 * kArms; ++i) {
        const float y = i < kArms ? 2 : 2.12f, radius = i < kArms ? 1.7f : 2.15f;
        for (unsigned k = 0; k < segments + 2; ++k) {
            const float u = float(k) / float(segments + 1), hang = 4 * u * (1 - u);
            const float3 at = onArm(float(i) + u, radius - 0.1f * hang, y - 0.35f * hang);
            if (k < segments)
                firsts.push_back(unsigned(points.size()));
            points.push_back(make_float4(at.x, at.y, at.z, 0.03f));
        }
    }
}

class Carousels : public Renderer {
public:
    Carousels(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const OptixTraversableHandle frame =
            buildMaterials(scene_, makeFrame(settings.some(96, 16)), frame_);
        const std::vector<OptixInstance> parts = {
            instanceOf(frame, kIdentity, 0, kDeck),
            instanceOf(buildBeads(settings.some(72, 12)), kIdentity, 1, kBeads),
            instanceOf(buildGarlands(settings.some(24, 3)), kIdentity, 2, kGarland)};
        const OptixTraversableHandle carousel = scene_.buildInstances(parts);
        makeSpins(carousel);
        ground_ = uploadMesh(scene_, makeBox(vec(-400, -1, -400), vec(400, 0, 400)));
        CarouselParams& p = launch_.params;
        const auto across = unsigned(std::sqrt(settings.some(400, 9)));
        p.fair =
            scene_.buildInstances(place(carousel, scene_.build(inputOf(ground_, flags)), across));
        p.camera = makeCamera(vec(-4, 3.1f, -11.5f), vec(0, 1.2f, -1), vec(0, 1, 0), 45,
                              settings.aspect());
        p.sun = normalize(vec(-0.7f, 0.5f, -0.35f));
        p.samples = 2;
        p.bounces = 3;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_QUADRATIC_BSPLINE);
        o.usesMotionBlur = 1;
        o.numPayloadValues = 9;
        const OptixModule module = programs_.load(bench_fifth_carousels_ptx());
        const OptixModule spheres = programs_.builtin(OPTIX_PRIMITIVE_TYPE_SPHERE, kFlags);
        const OptixModule curves =
            programs_.builtin(OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE, kFlags);
        const auto raygen = programs_.raygen({module, "__raygen__fair"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto frame = programs_.hit({{module, "__closesthit__frame"}, {}, {}});
        const auto meadow = programs_.hit({{module, "__closesthit__meadow"}, {}, {}});
        const auto bead = programs_.hit({{module, "__closesthit__bead"}, {}, {spheres, nullptr}});
        const auto garland =
            programs_.hit({{module, "__closesthit__garland"}, {}, {curves, nullptr}});
        pipeline_ = programs_.link({raygen, sky, open, frame, meadow, bead, garland},
                                   {.trace = 1, .graph = kGraphDepth});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(open)});
        const MeshView mesh = viewOf(frame_);
        table_.setHits(std::vector{
            makeRecord(frame, CarouselRecord{mesh, vec(0.5f, 0.33f, 0.2f), 0, 0.05f}),
            makeRecord(frame, CarouselRecord{mesh, vec(0.75f, 0.18f, 0.15f), 0, 0}),
            makeRecord(frame, CarouselRecord{mesh, vec(0.9f, 0.7f, 0.3f), 0, 0.7f}),
            makeRecord(bead, CarouselRecord{{}, vec(1, 0.75f, 0.4f), 3, 0}),
            makeRecord(bead, CarouselRecord{{}, vec(0.85f, 0.8f, 0.75f), 0, 0.1f}),
            makeRecord(bead, CarouselRecord{{}, vec(0.2f, 0.35f, 0.65f), 0, 0.4f}),
            makeRecord(garland, CarouselRecord{{}, vec(0.2f, 0.55f, 0.3f), 0, 0}),
            makeRecord(meadow, CarouselRecord{viewOf(ground_), vec(0.2f, 0.32f, 0.12f), 0, 0})});
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    OptixTraversableHandle buildBeads(unsigned count) {
        std::vector<float4> balls;
        std::vector<unsigned char> looks;
        addBeads(count, balls, looks);
        const CUdeviceptr centers = addressOf(scene_, balls), radii = centers + 3 * sizeof(float);
        const std::vector<unsigned> flags(3, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_SPHERES;
        OptixBuildInputSphereArray& s = input.sphereArray;
        s.vertexBuffers = &centers;
        s.vertexStrideInBytes = s.radiusStrideInBytes = sizeof(float4);
        s.numVertices = unsigned(balls.size());
        s.radiusBuffers = &radii;
        s.flags = flags.data();
        s.numSbtRecords = unsigned(flags.size());
        s.sbtIndexOffsetBuffer = addressOf(scene_, looks);
        s.sbtIndexOffsetSizeInBytes = sizeof(unsigned char);
        return scene_.build(input, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    }
    OptixTraversableHandle buildGarlands(unsigned segments) {
        std::vector<float4> points;
        std::vector<unsigned> firsts;
        addGarlands(segments, points, firsts);
        const CUdeviceptr vertices = addressOf(scene_, points),
                          widths = vertices + 3 * sizeof(float);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
        OptixBuildInputCurveArray& c = input.curveArray;
        c.curveType = OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE;
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
    // Transforms that turn a carousel around its mast, by 4 to 14 degrees while the shutter is
    // open.
    void makeSpins(OptixTraversableHandle carousel) {
        constexpr size_t kStride = (sizeof(OptixSRTMotionTransform) + 63) / 64 * 64;
        std::vector<unsigned char> bytes(kSpeeds * kStride);
        for (unsigned i = 0; i < kSpeeds; ++i) {
            const float half = (i % 2 ? -1.0f : 1.0f) * kPi / 180 * (2 + float(i));
            OptixSRTMotionTransform spin = {};
            spin.child = carousel;
            spin.motionOptions = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};
            spin.srtData[0] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0};
            spin.srtData[1] = spin.srtData[0];
            spin.srtData[1].qy = std::sin(half);
            spin.srtData[1].qw = std::cos(half);
            std::memcpy(&bytes[i * kStride], &spin, sizeof(spin));
        }
        const CUdeviceptr memory = addressOf(scene_, bytes);
        for (unsigned i = 0; i < kSpeeds; ++i)
            OPTIX_CHECK(optixConvertPointerToTraversableHandle(
                scene_.context(), memory + i * kStride, OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM,
                &spins_[i]));
    }
    std::vector<OptixInstance> place(OptixTraversableHandle carousel, OptixTraversableHandle meadow,
                                     unsigned across) const {
        std::vector<OptixInstance> all = {instanceOf(meadow, kIdentity, 0, kMeadow)};
        for (unsigned i = 1; i <= across * across; ++i) {
            const float3 at = vec(6 * (float(i % across) - 0.5f * float(across)), 0,
                                  6 * (float(i / across) - 0.5f * float(across)));
            const float3 off = vec(randomOf(i, 0), 0, randomOf(i, 1));
            const Placement to = placed(at + off, 0.8f + 0.4f * randomOf(i, 2), randomOf(i, 3));
            all.push_back(instanceOf(i % 2 ? spins_[i / 2 % kSpeeds] : carousel, to.matrix, i, 0));
        }
        return all;
    }

    MeshMemory frame_, ground_;
    OptixTraversableHandle spins_[kSpeeds] = {};
    Launch<CarouselParams> launch_;
};

} // namespace

JobKind carouselsJob() {
    return fifthJob<Carousels>(
        "carousels", "spheres, curves and triangles, half of them turning, paths of 4 hits", 0.003,
        0.03);
}

} // namespace bench
