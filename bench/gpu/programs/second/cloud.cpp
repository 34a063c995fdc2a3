// SPDX-License-Identifier: Apache-2.0
// A cloud above a landscape; device/cloud.cu.
#include "programs.h"

#include "device/cloud.h"

#include <cmath>

std::string_view bench_second_cloud_ptx();

namespace bench {
namespace {

// Balls of differing size, eroded by waves.
std::vector<float> makeDensity(unsigned across) {
    std::vector<float> density;
    density.reserve(size_t(across) * across * across);
    for (unsigned i = 0; i < across * across * across; ++i) {
        const auto along = [&](unsigned n) { return 2 * (float(n) + 0.5f) / float(across) - 1; };
        const float3 p =
            vec(along(i % across), along(i / across % across), along(i / across / across));
        float value = 0;
        for (unsigned k = 0; k < 10; ++k) {
            const float3 at = vec(1.2f * randomOf(k, 1) - 0.6f, 0.7f * randomOf(k, 2) - 0.5f,
                                  1.2f * randomOf(k, 3) - 0.6f);
            const float r = 0.25f + 0.25f * randomOf(k, 4);
            value = std::max(value, 1 - length(p - at) / r);
        }
        const float wave = std::sin(9 * p.x + 4 * p.y) * std::sin(11 * p.y - 3 * p.z) *
                               std::sin(8 * p.z + 5 * p.x) +
                           0.5f * std::sin(23 * p.x) * std::sin(21 * p.y) * std::sin(25 * p.z);
        density.push_back(clamp01(2.5f * (value - 0.15f + 0.25f * wave)));
    }
    return density;
}

class Cloud : public Application {
public:
    Cloud(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height) {
        const unsigned across = settings.scale < 0.1 ? 24 : 128;
        textures_.emplace_back(makeDensity(across), 1, TextureShape{across, across, across, false});
        const Mesh mesh = makeScene(SceneKind::kTerrain, settings.some(1e6, 500));
        const MeshMemory memory = uploadMesh(scene_, mesh);
        record_ = {reinterpret_cast<const float3*>(memory.vertices),
                   reinterpret_cast<const uint3*>(memory.indices), vec(0.45f, 0.4f, 0.3f)};
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        CloudParams& p = launch_.params;
        p.ground = scene_.build(inputOf(memory, flags));
        p.density = textures_.back().object();
        p.low = vec(-18, 14, -18);
        p.high = vec(26, 36, 26);
        p.extinction = 2.0f;
        p.forward = 0.7f;
        p.sun = normalize(vec(-0.55f, 0.6f, 0.3f));
        p.sunlight = vec(4.5f, 4.2f, 3.6f);
        p.camera =
            makeCamera(vec(-48, 24, -48), vec(2, 19, 2), vec(0, 1, 0), 52, settings.aspect());
        p.maxEvents = 32;
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        programs_.options.numPayloadValues = 7;
        const OptixModule module = programs_.load(bench_second_cloud_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__cloud"});
        const auto far = programs_.miss({module, "__miss__far"});
        const auto sun = programs_.miss({module, "__miss__sun"});
        const auto hit = programs_.hit({{module, "__closesthit__ground"}, {}, {}});
        pipeline_ = programs_.link({raygen, far, sun, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(far), makeRecord(sun)});
        table_.setHits(std::vector{makeRecord(hit, record_)});
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<CloudParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    GroundRecord record_ = {};
    std::vector<FloatTexture> textures_;
    DeviceBuffer image_;
    unsigned width_, height_;
};

} // namespace

JobKind cloudJob() {
    return secondJob<Cloud>("cloud", "delta tracking through a 3D texture above a landscape", 0.01,
                            0.1);
}

} // namespace bench
