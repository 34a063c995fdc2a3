// SPDX-License-Identifier: Apache-2.0
// A scene of Gaussians as reconstructions from photographs have them; device/gaussians.cu.
#include "programs.h"

#include "device/gaussians.h"
#include "sampling.h"

#include <cmath>

std::string_view bench_second_gaussians_ptx();

namespace bench {
namespace {

struct Triangles20 {
    std::vector<float3> corners;
    std::vector<uint32_t> faces;
};
// An icosahedron around a sphere of radius 1.
Triangles20 makeIcosahedron() {
    Triangles20 t;
    const float golden = 1.618034f, scale = 1 / 1.511523f; // of the sphere inside
    for (const float a : {-1.0f, 1.0f})
        for (const float b : {-golden, golden})
            for (const float3 v : {vec(0, a, b), vec(a, b, 0), vec(b, 0, a)})
                t.corners.push_back(v * scale);
    const auto isEdge = [&](size_t a, size_t b) {
        return length(t.corners[a] - t.corners[b]) < 2.1f * scale;
    };
    for (size_t a = 0; a < 12; ++a)
        for (size_t b = a + 1; b < 12; ++b)
            for (size_t c = b + 1; c < 12; ++c) {
                if (!isEdge(a, b) || !isEdge(b, c) || !isEdge(a, c))
                    continue;
                const float3 p = t.corners[a], normal = cross(t.corners[b] - p, t.corners[c] - p);
                const bool isOutward = dot(normal, p) > 0;
                t.faces.insert(t.faces.end(), {uint32_t(a), uint32_t(isOutward ? b : c),
                                               uint32_t(isOutward ? c : b)});
            }
    return t;
}

struct Placed {
    float3 at, normal, color;
    float density = 1;
};
// A point on the ground, a torus, a ball, or a cloud.
Placed place(unsigned i) {
    const float kind = randomOf(i, 0), u = randomOf(i, 1), v = randomOf(i, 2);
    const float2 a = circlePoint(u), b = circlePoint(v);
    if (kind < 0.3f) {
        const float r = 3 * std::sqrt(v);
        const bool isDark = (int(std::floor(r * a.x * 2)) + int(std::floor(r * a.y * 2))) & 1;
        return {vec(r * a.x, -0.6f, r * a.y), vec(0, 1, 0), vec(isDark ? 0.25f : 0.7f)};
    }
    if (kind < 0.6f) {
        const float r = 1.1f + 0.3f * b.x;
        return {vec(r * a.x, 0.3f * b.y, r * a.y), vec(b.x * a.x, b.y, b.x * a.y),
                vec(0.8f, 0.3f + 0.3f * b.y, 0.2f)};
    }
    const float y = 2 * v - 1, level = std::sqrt(1 - y * y);
    const float3 out = vec(level * a.x, y, level * a.y);
    if (kind < 0.8f)
        return {out * 0.5f + vec(0, 0.4f, 0), out, vec(0.2f, 0.4f + 0.3f * y, 0.8f)};
    const float far = 1.4f + randomOf(i, 3);
    return {vec(far * out.x, 0.9f + 0.4f * out.y, far * out.z), out, vec(0.9f, 0.92f, 0.95f),
            0.15f};
}

class GaussianCloud {
public:
    explicit GaussianCloud(unsigned count) {
        const float size = 0.01f * std::sqrt(3e5f / float(count));
        for (unsigned i = 0; i < count; ++i)
            add(i, size);
    }
    std::vector<Gaussian> gaussians;
    Mesh mesh;

private:
    void add(unsigned i, float size) {
        const Placed p = place(i);
        float3 x, y;
        makeBasis(p.normal, x, y);
        const float2 turn = circlePoint(randomOf(i, 4));
        const float3 axes[3] = {x * turn.x + y * turn.y, y * turn.x - x * turn.y, p.normal};
        const float s = size * (0.5f + 1.5f * randomOf(i, 5));
        const float deviations[3] = {s, s * (0.3f + 0.7f * randomOf(i, 6)), s * 0.15f};
        Gaussian g = {};
        for (unsigned k = 0; k < 3; ++k) {
            const float3 row = axes[k] / deviations[k];
            g.rows[k] = make_float4(row.x, row.y, row.z, -dot(row, p.at));
            g.tint[k] = make_float4(0.1f * randomOf(i, 7 + k), 0.15f, 0.1f * randomOf(i, 10), 0);
        }
        const float opacity = p.density * (0.2f + 0.75f * randomOf(i, 11));
        g.color = make_float4(p.color.x, p.color.y, p.color.z, opacity);
        gaussians.push_back(g);
        // Where the share falls below 0.01.
        const float reach = std::sqrt(2 * std::log(opacity / 0.01f));
        const auto first = uint32_t(mesh.vertices.size() / 3);
        for (const float3 c : shape_.corners) {
            const float3 v =
                p.at + (axes[0] * (c.x * deviations[0]) + axes[1] * (c.y * deviations[1]) +
                        axes[2] * (c.z * deviations[2])) *
                           reach;
            mesh.vertices.insert(mesh.vertices.end(), {v.x, v.y, v.z});
        }
        for (const uint32_t c : shape_.faces)
            mesh.indices.push_back(first + c);
    }
    Triangles20 shape_ = makeIcosahedron();
};

class Gaussians : public Application {
public:
    Gaussians(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height) {
        const GaussianCloud cloud(settings.some(3.2e5, 300));
        GaussianParams& p = launch_.params;
        p.gaussians = scene_.upload(cloud.gaussians);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        p.handle = scene_.build(inputOf(uploadMesh(scene_, cloud.mesh), flags));
        p.camera = makeCamera(vec(-1.6f, 1.1f, -2.4f), vec(0, 0.1f, 0), vec(0, 1, 0), 50,
                              settings.aspect());
        p.leastTransmittance = 0.03f;
        p.maxRounds = 32;
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        programs_.options.numPayloadValues = 32;
        const OptixModule module = programs_.load(bench_second_gaussians_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__gaussians"});
        const auto miss = programs_.miss({});
        const auto hit = programs_.hit({{}, {module, "__anyhit__keep"}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        table_.setHits(std::vector{makeRecord(hit)});
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<GaussianParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer image_;
    unsigned width_, height_;
};

} // namespace

JobKind gaussiansJob() {
    return secondJob<Gaussians>(
        "gaussians", "Gaussians in icosahedra, the 16 nearest in 32 payload words, in rounds",
        0.002, 0.02);
}

} // namespace bench
