// SPDX-License-Identifier: Apache-2.0
// Rocks of forty materials under a sky and lamps; device/materials_40.cu.
#include "programs.h"

#include "device/materials_40.h"
#include "sampling.h"

#include <cmath>

std::string_view bench_second_materials_40_ptx();

namespace bench {
namespace {

constexpr unsigned kAcross = 8, kPool = 24;

struct Garden {
    Mesh mesh;
    std::vector<unsigned char> materials;
    void addQuad(float3 corner, float3 u, float3 v, unsigned material) {
        const uint32_t first = mesh.numVertices();
        for (const float3 p : {corner, corner + u, corner + u + v, corner + v})
            mesh.vertices.insert(mesh.vertices.end(), {p.x, p.y, p.z});
        for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u})
            mesh.indices.push_back(first + i);
        materials.insert(materials.end(), 2, (unsigned char)material);
    }
    void addRock(const Mesh& rock, float3 at, float size, unsigned material) {
        const uint32_t first = mesh.numVertices();
        for (size_t i = 0; i < rock.vertices.size(); i += 3)
            mesh.vertices.insert(mesh.vertices.end(), {at.x + size * rock.vertices[i],
                                                       at.y + size * rock.vertices[i + 1],
                                                       at.z + size * rock.vertices[i + 2]});
        for (const uint32_t i : rock.indices)
            mesh.indices.push_back(first + i);
        materials.insert(materials.end(), rock.numTriangles(), (unsigned char)material);
    }
};

std::vector<Light> makeLights() {
    std::vector<Light> lights;
    for (unsigned i = 0; i < 3; ++i)
        lights.push_back({kQuadLight, vec(-3.5f + 2.6f * float(i), 2.4f, -1.0f), vec(0.9f, 0, 0),
                          vec(0, 0, 0.9f), vec(9, 7.5f, 5.5f)});
    for (unsigned i = 0; i < 2; ++i)
        lights.push_back({kBallLight,
                          vec(-3 + 6 * float(i), 1.7f, -3.4f),
                          vec(0.15f, 0, 0),
                          {},
                          vec(60, 70, 90)});
    lights.push_back({kSkyLight, {}, {}, {}, {}});
    return lights;
}

Garden makeGarden(unsigned triangles, const std::vector<Light>& lights) {
    Garden garden;
    const Mesh rock = makeRock(std::max(60u, triangles / 80));
    for (unsigned i = 0; i < kAcross * kAcross; ++i)
        garden.addQuad(vec(float(i % kAcross) - 4, 0, float(i / kAcross) - 4), vec(0, 0, 1),
                       vec(1, 0, 0), (i * 7 + i / kAcross) % kMaterials);
    for (unsigned i = 0; i < 80; ++i) {
        const float size = 0.26f + 0.2f * randomOf(i, 1);
        garden.addRock(rock,
                       vec(float(i % 10) * 0.8f - 3.6f, size * 0.9f, float(i / 10) * 0.95f - 3.4f),
                       size, i % kMaterials);
    }
    for (const Light& light : lights)
        if (light.kind == kQuadLight)
            garden.addQuad(light.corner, light.u, light.v, kLightMaterial);
    return garden;
}

class Materials40 : public Application {
public:
    Materials40(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height) {
        const std::vector<Light> lights = makeLights();
        const Garden garden = makeGarden(settings.some(1.2e6, 2000), lights);
        const MeshMemory mesh = uploadMesh(scene_, garden.mesh);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        MaterialParams& p = launch_.params;
        p.scene = scene_.build(inputOf(mesh, flags));
        record_ = {reinterpret_cast<const float3*>(mesh.vertices),
                   reinterpret_cast<const uint3*>(mesh.indices), scene_.upload(garden.materials),
                   makeMaterials()};
        p.lights = scene_.upload(lights);
        p.numLights = unsigned(lights.size());
        makeSky(p.sky, settings.scale < 0.1 ? 64 : 1024);
        p.camera = makeCamera(vec(-3.1f, 2.3f, -5.6f), vec(0, 0.2f, -0.4f), vec(0, 1, 0), 48,
                              settings.aspect());
        p.samples = 2;
        p.maxDepth = 6;
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        const OptixModule module = programs_.load(bench_second_materials_40_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__paths"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto shadow = programs_.miss({module, "__miss__shadow"});
        const auto surface = programs_.hit({{module, "__closesthit__surface"}, {}, {}});
        std::vector<OptixProgramGroup> groups = {raygen, sky, shadow, surface};
        std::vector<SbtRecord<NoData>> callables;
        const auto add = [&](const std::string& name) {
            groups.push_back(programs_.direct({module, ("__direct_callable__" + name).c_str()}));
            callables.push_back(makeRecord(groups.back()));
        };
        for (const char* task : {"sample_", "evaluate_"})
            for (unsigned i = 0; i < kMaterials; ++i)
                add(task + std::to_string(i));
        for (const char* light : {"light_quad", "light_ball", "light_sky"})
            add(light);
        pipeline_ = programs_.link(groups, {.trace = 2, .directCallables = 1});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(shadow)});
        table_.setHits(std::vector{makeRecord(surface, record_)});
        table_.setCallables(callables);
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    const SurfaceMaterial* makeMaterials() {
        for (unsigned i = 0; i < kPool; ++i)
            textures_.emplace_back(spots(1000 * i, 128), 128);
        std::vector<SurfaceMaterial> materials(kMaterials);
        for (unsigned i = 0; i < kMaterials; ++i) {
            for (unsigned k = 0; k < kMaterialTextures; ++k)
                materials[i].textures[k] = textures_[(i * 5 + k * 7) % kPool].object();
            materials[i].base = colorOf(i) * 1.3f;
            materials[i].roughness = 0.15f + 0.6f * randomOf(i, 5);
        }
        return scene_.upload(materials);
    }
    // A sky with a bright sun, and the sums of its weights.
    void makeSky(SkyMap& sky, unsigned width) {
        sky.width = width;
        sky.height = width / 2;
        std::vector<float> texels, rows = {0}, columns;
        const float3 sun = normalize(vec(-0.5f, 0.7f, -0.4f));
        for (unsigned y = 0; y < sky.height; ++y) {
            const float theta = kPi * (float(y) + 0.5f) / float(sky.height);
            columns.push_back(0);
            for (unsigned x = 0; x < width; ++x) {
                const float phi = 2 * kPi * ((float(x) + 0.5f) / float(width) - 0.5f);
                const float3 d = vec(std::sin(theta) * std::cos(phi), std::cos(theta),
                                     std::sin(theta) * std::sin(phi));
                const float glow = std::pow(std::max(dot(d, sun), 0.0f), 400.0f);
                const float3 c = lerp(vec(0.5f), vec(0.3f, 0.45f, 0.8f), 0.5f + 0.5f * d.y) +
                                 vec(60, 52, 40) * glow;
                texels.insert(texels.end(), {c.x, c.y, c.z, 0});
                columns.push_back(columns.back() + (c.x + c.y + c.z) * std::sin(theta));
            }
            rows.push_back(rows.back() + columns.back());
        }
        sky.total = rows.back();
        sky.rows = scene_.upload(rows);
        sky.columns = scene_.upload(columns);
        skyTexture_.emplace_back(texels, 4, TextureShape{width, sky.height});
        sky.texture = skyTexture_.back().object();
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<MaterialParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    MeshRecord record_ = {};
    std::vector<Texture> textures_;
    std::vector<FloatTexture> skyTexture_; // one
    DeviceBuffer image_;
    unsigned width_, height_;
};

} // namespace

JobKind materials40Job() {
    return secondJob<Materials40>(
        "materials_40", "one closest-hit program, 40 materials and three lights as callables", 0.01,
        0.1);
}

} // namespace bench
