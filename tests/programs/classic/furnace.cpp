// SPDX-License-Identifier: Apache-2.0
// A path tracer that binds nothing: its device code finds buffers, textures and callable programs
// by ids in tables. The scene is a closed box of six walls. Every wall has a material record in a
// bindless buffer: the ids of a scattering program, of a texture for its colour, and of a buffer
// with its light. The host follows the same paths.
#include "device/furnace.h"
#include "common.h"

#include <optixu/optixu_math_namespace.h>

#include <cmath>
#include <cstring>
#include <vector>

using namespace optix;

namespace {

constexpr unsigned kWidth = 64, kHeight = 48, kTexture = 8, kDepth = 5;

// ---- the host's paths

struct Wall {
    int kind;                  // 0: diffuse, 1: mirror, 2: both by turns
    std::vector<float> texels; // kTexture x kTexture
    std::vector<float> light;  // by side of the wall: one number for each of its halves
};

struct Hit {
    float3 point, normal;
    float2 place;
    int wall;
};

float component(const float3& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

Hit hitBox(const float3& origin, const float3& way) {
    Hit hit{};
    float nearest = 1e30f;
    for (int axis = 0; axis < 3; ++axis) {
        const float d = component(way, axis);
        if (d == 0)
            continue;
        const float t = ((d > 0 ? 1.0f : -1.0f) - component(origin, axis)) / d;
        if (t < nearest) {
            nearest = t;
            hit.wall = 2 * axis + (d > 0 ? 1 : 0);
        }
    }
    hit.point = origin + nearest * way;
    const int axis = hit.wall / 2;
    const float side = hit.wall % 2 ? -1.0f : 1.0f;
    hit.normal = make_float3(axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0);
    hit.place = make_float2((component(hit.point, (axis + 1) % 3) + 1) / 2,
                            (component(hit.point, (axis + 2) % 3) + 1) / 2);
    return hit;
}

float hostPath(const std::vector<Wall>& walls, unsigned x, unsigned y) {
    float3 origin = make_float3(0.1f, 0.2f, 0.3f);
    float3 way = normalize(make_float3((float(x) + 0.5f) / kWidth * 2 - 1,
                                       (float(y) + 0.5f) / kHeight * 2 - 1, -0.7f));
    unsigned seed = y * kWidth + x;
    float weight = 1, sum = 0;
    for (unsigned depth = 0; depth < kDepth; ++depth) {
        const Hit hit = hitBox(origin, way);
        const Wall& wall = walls[size_t(hit.wall)];
        const auto texel = [](float u) { return std::min(kTexture - 1, unsigned(u * kTexture)); };
        const float albedo = wall.texels[texel(hit.place.y) * kTexture + texel(hit.place.x)];
        sum += weight * wall.light[hit.place.x < 0.5f ? 0 : 1];
        const float u = furnaceRandom(seed), v = furnaceRandom(seed);
        const bool mirrors = wall.kind == 1 || (wall.kind == 2 && u < 0.5f);
        if (mirrors)
            way = reflect(way, hit.normal);
        else
            way = furnaceScatter(hit.normal, u, v);
        weight *= albedo * (mirrors ? 0.9f : 1.0f);
        origin = hit.point * 0.999f; // away from the wall
    }
    return sum;
}

// ---- the library's

class Furnace {
public:
    Furnace() {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(1);
        context_->setRayGenerationProgram(0, program("trace_paths"));
        context_->setMaxTraceDepth(2);
        makeWalls();
        makeTables();
        makeBox();
        picture_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT, kWidth, kHeight);
        context_["picture"]->setUserData(sizeof(int), makeId(picture_));
        context_["max_depth"]->setUint(kDepth);
    }
    ~Furnace() { rtContextDestroy(context_->get()); }
    Furnace(const Furnace&) = delete;

    void check(const std::string& what) {
        context_->validate();
        context_->launch(0, kWidth, kHeight);
        const auto* pixels = static_cast<const float*>(picture_->map());
        int different = 0;
        double sum = 0, wanted = 0;
        for (unsigned y = 0; y < kHeight; ++y)
            for (unsigned x = 0; x < kWidth; ++x) {
                const float host = hostPath(walls_, x, y), ours = pixels[y * kWidth + x];
                different += std::fabs(host - ours) > 1e-3f * (1 + host);
                sum += double(ours);
                wanted += double(host);
            }
        picture_->unmap();
        // Paths that pass the edge of a texel may differ.
        require(different < int(kWidth * kHeight) / 50,
                what + ": " + std::to_string(different) + " paths differ");
        require(std::fabs(sum - wanted) < 0.01 * wanted, what + ": the sums differ");
    }
    // Other contents behind the same ids.
    void swapScattering() {
        auto* records = static_cast<MaterialRecord*>(records_->map());
        for (int i = 0; i < 6; ++i) {
            walls_[size_t(i)].kind = (walls_[size_t(i)].kind + 1) % 3;
            records[i].scatter = scatterIds_[walls_[size_t(i)].kind];
        }
        records_->unmap();
    }
    void changeTexels() {
        for (size_t wall = 0; wall < 6; ++wall) {
            auto* texels = static_cast<float*>(textures_[wall]->getBuffer()->map());
            for (size_t i = 0; i < kTexture * kTexture; ++i)
                texels[i] = walls_[wall].texels[i] = 0.9f - 0.5f * walls_[wall].texels[i];
            textures_[wall]->getBuffer()->unmap();
        }
    }
    void replaceLight() {
        // A buffer that is destroyed, and another with an id of its own.
        lights_[2]->destroy();
        walls_[2].light = {3, 5};
        lights_[2] = floats(walls_[2].light);
        auto* records = static_cast<MaterialRecord*>(records_->map());
        records[2].light = lights_[2]->getId();
        records_->unmap();
    }
    void checkIds() {
        Buffer found = context_->getBufferFromId(records_->getId());
        require(found->get() == records_->get(), "another buffer has the id");
        TextureSampler sampler = context_->getTextureSamplerFromId(textures_[1]->getId());
        require(sampler->get() == textures_[1]->get(), "another sampler has the id");
        Program callee = context_->getProgramFromId(scatterIds_[2]);
        require(callee->get() == scatter_[2]->get(), "another program has the id");
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    static const void* makeId(const Buffer& buffer) {
        static int id;
        id = buffer->getId();
        return &id;
    }
    Buffer floats(const std::vector<float>& values) {
        Buffer buffer = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, values.size());
        std::memcpy(buffer->map(), values.data(), values.size() * sizeof(float));
        buffer->unmap();
        return buffer;
    }
    void makeWalls() {
        unsigned seed = 7;
        for (int i = 0; i < 6; ++i) {
            Wall wall{i % 3, {}, {0.5f * float(i), 1}};
            for (unsigned n = 0; n < kTexture * kTexture; ++n)
                wall.texels.push_back(0.2f + 0.7f * furnaceRandom(seed));
            walls_.push_back(wall);
        }
    }
    TextureSampler texture(const std::vector<float>& texels) {
        TextureSampler sampler = context_->createTextureSampler();
        Buffer buffer =
            context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, kTexture, kTexture);
        std::memcpy(buffer->map(), texels.data(), texels.size() * sizeof(float));
        buffer->unmap();
        for (unsigned dimension = 0; dimension < 3; ++dimension)
            sampler->setWrapMode(dimension, RT_WRAP_CLAMP_TO_EDGE);
        sampler->setFilteringModes(RT_FILTER_NEAREST, RT_FILTER_NEAREST, RT_FILTER_NONE);
        sampler->setIndexingMode(RT_TEXTURE_INDEX_NORMALIZED_COORDINATES);
        sampler->setReadMode(RT_TEXTURE_READ_ELEMENT_TYPE);
        sampler->setMaxAnisotropy(1.0f);
        sampler->setMipLevelCount(1);
        sampler->setArraySize(1);
        sampler->setBuffer(0, 0, buffer);
        return sampler;
    }
    void makeTables() {
        for (const char* name : {"scatter_diffuse", "scatter_mirror", "scatter_both"}) {
            scatter_.push_back(program(name));
            scatterIds_.push_back(scatter_.back()->getId());
        }
        scatter_[2]["other"]->setProgramId(scatter_[0]); // it calls the diffuse one
        scatter_[2]["mirror"]->setProgramId(scatter_[1]);
        scatter_[1]["loss"]->setFloat(0.9f);
        records_ = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_USER, 6);
        records_->setElementSize(sizeof(MaterialRecord));
        auto* records = static_cast<MaterialRecord*>(records_->map());
        for (size_t i = 0; i < 6; ++i) {
            textures_.push_back(texture(walls_[i].texels));
            lights_.push_back(floats(walls_[i].light));
            records[i] = {scatterIds_[size_t(walls_[i].kind)], textures_[i]->getId(),
                          lights_[i]->getId(), 0};
        }
        records_->unmap();
        // A table of ids, whose first element is the records' buffer.
        Buffer directory = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_BUFFER_ID, 2);
        auto* ids = static_cast<bufferId<MaterialRecord>*>(directory->map());
        ids[0] = records_->getId();
        ids[1] = bufferId<MaterialRecord>(RT_BUFFER_ID_NULL);
        directory->unmap();
        context_["directory"]->set(directory);
    }
    void makeBox() {
        Geometry walls = context_->createGeometry();
        walls->setPrimitiveCount(6);
        walls->setBoundingBoxProgram(program("wall_bounds"));
        walls->setIntersectionProgram(program("wall_intersect"));
        Material material = context_->createMaterial();
        material->setClosestHitProgram(0, program("hit_wall"));
        GeometryInstance instance =
            context_->createGeometryInstance(walls, &material, &material + 1);
        GeometryGroup group = context_->createGeometryGroup(&instance, &instance + 1);
        group->setAcceleration(context_->createAcceleration("Bvh", "Bvh"));
        context_["top_object"]->set(group);
    }

    Context context_;
    std::vector<Wall> walls_;
    std::vector<Program> scatter_;
    std::vector<int> scatterIds_;
    std::vector<TextureSampler> textures_;
    std::vector<Buffer> lights_;
    Buffer records_, picture_;
};

} // namespace

int main() {
    return runProgram([] {
        Furnace furnace;
        furnace.check("first");
        furnace.checkIds();
        furnace.swapScattering();
        furnace.check("other scattering");
        furnace.changeTexels();
        furnace.check("other texels");
        furnace.replaceLight();
        furnace.check("another buffer");
    });
}
