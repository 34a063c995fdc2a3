// SPDX-License-Identifier: Apache-2.0
// Particles in a flow around bodies, with short rays to find the walls; device/particles.cu.
#include "programs.h"

#include "device/particles.h"

std::string_view bench_third_particles_ptx();

namespace bench {
namespace {

constexpr unsigned kSide = 64; // of the field

class Particles : public Renderer {
public:
    Particles(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings), field_(makeField(), 4, {kSide, kSide, kSide, false}) {
        const Mesh bodies = makeBodies(settings.some(6e5, 600));
        const MeshMemory memory = uploadMesh(scene_, bodies);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        ParticleParams& p = launch_.params;
        p.walls = scene_.build(inputOf(memory, flags));
        p.mesh = viewOf(memory);
        p.field = field_.object();
        p.deposits = scene_.allocate<unsigned>(bodies.numTriangles());
        p.depositCount = bodies.numTriangles();
        p.count = settings.some(1e6, 2000);
        p.particles = scene_.allocate<Particle>(p.count);
        p.density = scene_.allocate<unsigned>(size_t(width_) * height_);
        p.width = width_;
        p.height = height_;
        p.steps = 12;
        p.timeStep = 0.012f;
        p.camera =
            makeCamera(vec(-0.6f, 1.1f, -2.6f), vec(0, 0, 0), vec(0, 1, 0), 48, settings.aspect());
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.options.numPayloadValues = 2;
        programs_.options.exceptionFlags = OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW;
        const OptixModule module = programs_.load(bench_third_particles_ptx());
        const OptixProgramGroup raygens[3] = {programs_.raygen({module, "__raygen__emit"}),
                                              programs_.raygen({module, "__raygen__advance"}),
                                              programs_.raygen({module, "__raygen__draw"})};
        const auto miss = programs_.miss({module, "__miss__free"});
        const auto hit = programs_.hit({{module, "__closesthit__wall"}, {}, {}});
        pipeline_ = programs_.link({raygens[0], raygens[1], raygens[2], miss, hit}, {});
        for (unsigned i = 0; i < 3; ++i) {
            tables_[i].setRaygen(makeRecord(raygens[i]));
            tables_[i].setMisses(std::vector{makeRecord(miss)});
            tables_[i].setHits(std::vector{makeRecord(hit)});
        }
    }
    // Starts, advances four times and draws.
    void renderFrame() override {
        const ParticleParams& p = launch_.params;
        CUDA_CHECK(cudaMemsetAsync(p.density, 0, sizeof(unsigned) * p.width * p.height, nullptr));
        CUDA_CHECK(cudaMemsetAsync(p.deposits, 0, sizeof(unsigned) * p.depositCount, nullptr));
        launch_.run(pipeline_, tables_[0], p.count);
        for (unsigned i = 0; i < 4; ++i)
            launch_.run(pipeline_, tables_[1], p.count);
        launch_.run(pipeline_, tables_[2], width_, height_);
    }

private:
    // Velocity along x, with eddies, and a potential in the fourth channel.
    static std::vector<float> makeField() {
        std::vector<float> texels;
        for (unsigned i = 0; i < kSide * kSide * kSide; ++i) {
            const auto along = [&](unsigned n) { return (float(n) + 0.5f) * 2 / kSide - 1; };
            const float x = along(i % kSide), y = along(i / kSide % kSide),
                        z = along(i / (kSide * kSide));
            const float a = 0.9f * std::sin(5 * x + 2 * z), b = 0.9f * std::sin(4 * y - 3 * x);
            texels.insert(texels.end(), {1.4f + b * std::cos(5 * z), a * std::cos(6 * y),
                                         b * std::sin(6 * y + 2 * x), a * b});
        }
        return texels;
    }
    // A channel with rods and rocks.
    static Mesh makeBodies(unsigned triangles) {
        Mesh mesh;
        append(mesh, makeBox(vec(-1.2f, -0.62f, -0.62f), vec(1.2f, 0.62f, 0.62f)), vec(1), vec(0));
        const Mesh rock = makeRock(triangles / 24);
        for (unsigned i = 0; i < 24; ++i)
            append(mesh, rock, vec(0.06f + 0.08f * randomOf(i, 0)),
                   vec(1.8f * randomOf(i, 1) - 0.8f, randomOf(i, 2) - 0.5f, randomOf(i, 3) - 0.5f));
        const Mesh rod = makeLathe({make_float2(1, -1), make_float2(1, 1)}, 48);
        for (unsigned i = 0; i < 6; ++i)
            append(mesh, rod, vec(0.05f, 0.62f, 0.05f),
                   vec(-0.6f + 0.25f * float(i), 0, i % 2 ? 0.3f : -0.25f));
        return mesh;
    }

    FloatTexture field_;
    Table tables_[3];
    Launch<ParticleParams> launch_;
};

} // namespace

JobKind particlesJob() {
    return thirdJob<Particles>("particles", "a million particles in a flow, 48 short rays for each",
                               0.005, 0.1);
}

} // namespace bench
