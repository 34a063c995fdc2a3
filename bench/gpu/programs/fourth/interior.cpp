// SPDX-License-Identifier: Apache-2.0
// A room with furniture, a mesh curtain and blinds, lit through its windows by a picture of the
// surroundings; device/interior.cu.
#include "programs.h"

#include "device/interior.h"

std::string_view bench_fourth_interior_ptx();

namespace bench {
namespace {

constexpr unsigned kTextureSide = 256, kWidth = 512, kHeight = 256; // of the surroundings

// Height differences of rounded grains, as a normal map.
std::vector<unsigned char> grains(unsigned seed) {
    std::vector<unsigned char> texels;
    for (unsigned i = 0; i < kTextureSide * kTextureSide; ++i) {
        const auto x = float(i % kTextureSide), y = float(i / kTextureSide);
        const float turns = 2 * kPi / 64, phase = 6 * randomOf(seed, 0);
        const float a = std::cos(turns * (3 * x + y) + phase) + 0.5f * std::cos(turns * 11 * x);
        const float b = std::cos(turns * (3 * y - x) + phase) + 0.5f * std::cos(turns * 9 * y);
        texels.insert(texels.end(),
                      {(unsigned char)(127 + 30 * a), (unsigned char)(127 + 30 * b), 255, 255});
    }
    return texels;
}

float3 skyAt(float u, float v) {
    const float height = std::cos(kPi * v);
    const float2 c = circlePoint(u);
    const float level = std::sin(kPi * v);
    const float sun = std::max(
        0.0f, dot(vec(level * c.x, height, level * c.y), normalize(vec(-0.35f, 0.55f, -0.75f))));
    const float cloud = std::max(0.0f, std::sin(25 * u + 9 * v) * std::sin(31 * v + 6 * c.x));
    const float3 sky =
        lerp(vec(1.1f, 1.15f, 1.2f), vec(0.35f, 0.6f, 1.2f), height) + vec(0.9f) * (cloud * cloud);
    return (height > 0 ? sky * 2.5f : vec(0.3f, 0.34f, 0.2f)) +
           vec(1500, 1300, 950) * std::pow(sun, 1500.0f);
}

// The surroundings and their distributions.
struct Sky {
    std::vector<float> radiance, rows, columns;

    Sky() {
        float total = 0;
        for (unsigned y = 0; y < kHeight; ++y) {
            float row = 0;
            const float v = (float(y) + 0.5f) / kHeight;
            for (unsigned x = 0; x < kWidth; ++x) {
                const float3 c = skyAt((float(x) + 0.5f) / kWidth, v);
                const float weight = (c.x + c.y + c.z) * std::sin(kPi * v);
                radiance.insert(radiance.end(), {c.x, c.y, c.z, weight});
                columns.push_back(row += weight);
            }
            for (unsigned x = 0; x < kWidth; ++x)
                columns[y * kWidth + x] /= row;
            rows.push_back(total += row);
        }
        for (float& row : rows)
            row /= total;
        for (size_t i = 3; i < radiance.size(); i += 4)
            radiance[i] *= kWidth * kHeight / total;
    }
};

class Interior : public Renderer {
public:
    Interior(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        furnish(settings);
        InteriorParams& p = launch_.params;
        p.room = buildMaterials(scene_, mesh_, memory_);
        const Sky sky;
        const TextureShape shape = {kWidth, kHeight, 0, false};
        tables_.emplace_back(sky.radiance, 4, shape);
        tables_.emplace_back(sky.rows, 1, TextureShape{kHeight, 1, 0, false});
        tables_.emplace_back(sky.columns, 1, shape);
        p.outside = {tables_[0].object(), tables_[1].object(), tables_[2].object(), kWidth,
                     kHeight};
        for (unsigned i = 0; i < 3; ++i) {
            albedos_.emplace_back(spots(40 + i, kTextureSide), kTextureSide);
            bumps_.emplace_back(grains(i), kTextureSide);
        }
        p.camera = makeCamera(vec(3.6f, 1.7f, 2.8f), vec(-1.2f, 0.9f, -1.2f), vec(0, 1, 0), 56,
                              settings.aspect());
        p.samples = 4;
        p.maxBounces = 5;
        p.image = allocatePicture();
    }
    void compile() override {
        const OptixModule module = programs_.load(bench_fourth_interior_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__interior"});
        const auto outside = programs_.miss({module, "__miss__outside"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto hit = programs_.hit({{module, "__closesthit__surface"}, {}, {}});
        pipeline_ = programs_.link({raygen, outside, open, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(outside), makeRecord(open)});
        std::vector<SbtRecord<InteriorRecord>> records;
        for (unsigned i = 0; i < kMaterials; ++i)
            records.push_back(makeRecord(hit, recordOf(i)));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    enum Material : unsigned {
        kPlaster,
        kParquet,
        kWood,
        kCloth,
        kBrass,
        kSteel,
        kLacquer,
        kCeramic,
        kLeather,
        kCurtain,
        kMaterials
    };

    InteriorRecord recordOf(unsigned i) const {
        static constexpr Principled kLooks[kMaterials] = {
            {{0.8f, 0.78f, 0.74f}, 0, 0.9f, 0.3f, 0, 0, 0},
            {{0.75f, 0.5f, 0.3f}, 0, 0.4f, 0.5f, 0, 0.6f, 0.8f},
            {{0.6f, 0.38f, 0.22f}, 0, 0.5f, 0.5f, 0, 0.2f, 0.5f},
            {{0.3f, 0.4f, 0.65f}, 0, 0.95f, 0.2f, 0.8f, 0, 0},
            {{0.95f, 0.75f, 0.35f}, 1, 0.25f, 0.5f, 0, 0, 0},
            {{0.8f, 0.82f, 0.85f}, 1, 0.15f, 0.5f, 0, 0, 0},
            {{0.6f, 0.05f, 0.06f}, 0, 0.5f, 0.5f, 0, 1, 0.95f},
            {{0.85f, 0.87f, 0.9f}, 0, 0.2f, 0.8f, 0, 0.5f, 0.9f},
            {{0.25f, 0.14f, 0.09f}, 0, 0.55f, 0.5f, 0.2f, 0, 0},
            {{0.75f, 0.7f, 0.55f}, 0, 0.9f, 0.2f, 0.5f, 0, 0}};
        const bool isPlain = i == kBrass || i == kSteel || i == kLacquer || i == kCeramic;
        return {viewOf(memory_), kLooks[i], isPlain ? 0 : albedos_[i % 3].object(),
                isPlain ? 0 : bumps_[i % 3].object(), i == kPlaster ? 0.3f : 1.1f};
    }
    void addBox(float3 low, float3 high, Material material) {
        append(mesh_, makeBox(low, high), vec(1), vec(0), material);
    }
    // A room of 9 x 3 x 7 with a wall of glass at z = -3.5 and an opening in the ceiling.
    void buildWalls() {
        addBox(vec(-4.5f, -0.2f, -3.5f), vec(4.5f, 0, 3.5f), kParquet);
        addBox(vec(-4.5f, 3, -0.5f), vec(4.5f, 3.2f, 3.5f), kPlaster);
        for (const float x : {-4.5f, 1.0f})
            addBox(vec(x, 3, -3.5f), vec(x + 3.5f, 3.2f, -0.5f), kPlaster);
        addBox(vec(-4.7f, 0, -3.5f), vec(-4.5f, 3, 3.5f), kPlaster);
        addBox(vec(4.5f, 0, -3.5f), vec(4.7f, 3, 3.5f), kPlaster);
        addBox(vec(-4.5f, 0, 3.5f), vec(4.5f, 3, 3.7f), kPlaster);
        for (unsigned i = 0; i < 7; ++i)
            addBox(vec(-4.5f + 1.48f * float(i), 0, -3.6f),
                   vec(-4.38f + 1.48f * float(i), 3, -3.5f), kWood);
        for (unsigned i = 0; i < 36; ++i) { // blinds
            const float y = 0.75f + 0.05f * float(i);
            append(mesh_,
                   makeSheet(1, 1,
                             [&](float u, float v) {
                                 return vec(0.6f + 2.7f * u, y + 0.02f * v, -3.45f + 0.03f * v);
                             }),
                   vec(1), vec(0), kSteel);
        }
    }
    void furnish(const JobSettings& settings) {
        mesh_.looks.resize(kMaterials);
        buildWalls();
        addTable(vec(-1.2f, 0, -1.2f));
        addBox(vec(-4.4f, 0, -1.5f), vec(-3.5f, 0.45f, 1.8f), kLeather);
        addBox(vec(-4.4f, 0.45f, -1.5f), vec(-4.1f, 0.95f, 1.8f), kLeather);
        for (unsigned shelf = 0; shelf < 4; ++shelf)
            addBox(vec(-3.6f, 0.3f + 0.6f * float(shelf), 3.1f),
                   vec(1, 0.34f + 0.6f * float(shelf), 3.5f), kWood);
        const Mesh rock = makeRock(settings.some(1.2e5, 80));
        append(mesh_, rock, vec(0.28f), vec(-1.8f, 1.05f, -1.3f), kBrass);
        append(mesh_, rock, vec(0.2f, 0.3f, 0.2f), vec(-0.6f, 1.05f, -1.0f), kLacquer);
        append(mesh_, rock, vec(0.45f, 0.6f, 0.45f), vec(2.2f, 0.55f, -2.2f), kCeramic);
        addVases(settings);
        const auto fine = settings.some(700, 12);
        append(mesh_,
               makeSheet(fine, fine / 2,
                         [](float u, float v) {
                             const float wave = std::sin(300 * u) * std::sin(200 * v);
                             return vec(4 * u - 3.2f, 0.015f + 0.008f * wave, 2.6f * v - 0.4f);
                         }),
               vec(1), vec(0), kCloth);
        append(mesh_,
               makeSheet(fine, fine / 4,
                         [](float u, float v) {
                             return vec(-3.3f + 1.1f * u, 0.3f + 2.5f * v,
                                        -3.3f + 0.06f * std::sin(45 * u + 2 * v));
                         }),
               vec(1), vec(0), kCurtain);
    }
    void addTable(float3 at) {
        addBox(at + vec(-1.2f, 0.7f, -0.6f), at + vec(1.2f, 0.76f, 0.6f), kWood);
        for (const float x : {-1.1f, 1.05f})
            for (const float z : {-0.5f, 0.45f})
                addBox(at + vec(x, 0, z), at + vec(x + 0.06f, 0.7f, z + 0.06f), kSteel);
    }
    // On the table, the floor and the shelves.
    void addVases(const JobSettings& settings) {
        std::vector<float2> profile;
        const unsigned rings = settings.some(90, 10);
        for (unsigned i = 0; i <= rings; ++i) {
            const float y = float(i) / float(rings);
            profile.push_back(
                make_float2(0.3f + 0.2f * std::sin(5 * y) + 0.01f * std::sin(80 * y), y));
        }
        const Mesh vase = makeLathe(profile, settings.some(180, 16));
        append(mesh_, vase, vec(0.9f, 1.1f, 0.9f), vec(3.2f, 0, -1), kCeramic);
        append(mesh_, vase, vec(0.3f, 0.35f, 0.3f), vec(-1.2f, 0.76f, -1.4f), kSteel);
        for (unsigned i = 0; i < 16; ++i) {
            const float size = 0.2f + 0.15f * randomOf(i, 0);
            append(mesh_, vase, vec(size),
                   vec(-3.2f + float(i % 4) * 1.15f, 0.34f + 0.6f * float(i / 4), 3.3f),
                   kBrass + i % 4);
        }
    }

    MaterialMesh mesh_;
    MeshMemory memory_;
    std::vector<FloatTexture> tables_;
    std::vector<Texture> albedos_, bumps_;
    Launch<InteriorParams> launch_;
};

} // namespace

JobKind interiorJob() {
    return fourthJob<Interior>(
        "interior", "a room of principled materials, lit from outside by importance sampling", 0.01,
        0.1);
}

} // namespace bench
