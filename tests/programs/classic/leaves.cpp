// SPDX-License-Identifier: Apache-2.0
// Trees of leaves cut out of triangles by a texture's alpha: any-hit programs ignore and terminate.
// Four trees are instances of one mesh, with materials that share programs and differ in a
// variable; the ground is custom geometry. Group masks and ray flags vary.
#include "common.h"

#include <optixu/optixu_math_namespace.h>
#include <optixu/optixu_matrix_namespace.h>

#include <cmath>
#include <vector>

using namespace optix;

namespace {

constexpr unsigned kSize = 64, kTexels = 4;
constexpr float kExtent = 8, kStep = 2 * kExtent / kSize;
constexpr int kTrees = 4, kLeaves = 3;
const float3 kPlaces[kTrees] = {make_float3(-4, 0, -4), make_float3(4, 0, -4),
                                make_float3(-4, 0, 4), make_float3(3.3f, 1.5f, 3.3f)};

// The alpha of a place of a leaf; leaves are squares of 4 x 4 texels, turned by their height.
float alphaOf(int leaf, float u, float v) {
    if (leaf % 2)
        std::swap(u, v);
    const int x = int(u * kTexels), y = int(v * kTexels);
    return (x + 2 * y) % 3 == 0 ? 1.0f : (x + y) % 2 ? 0.25f : 0.0f;
}

struct Answer {
    float distance = 10;
    int tree = 99, crossed = 0;
    float light = 1;
};

// Rays down from a height of 10: leaf k of a tree is at k + 1 above its place.
Answer trace(float x, float z, const std::vector<bool>& visible, bool noAnyHit) {
    Answer answer;
    bool ended = false;
    for (float height = 10; height > 0; height -= 0.25f)
        for (int tree = 0; tree < kTrees; ++tree)
            for (int leaf = 0; leaf < kLeaves; ++leaf) {
                if (!visible[size_t(tree)] ||
                    std::fabs(kPlaces[tree].y + float(leaf + 1) - height) > 0.01f)
                    continue;
                const float u = (x - kPlaces[tree].x + 2) / 4, v = (z - kPlaces[tree].z + 2) / 4;
                if (u < 0 || u >= 1 || v < 0 || v >= 1)
                    continue;
                const float alpha = alphaOf(leaf, u, v);
                if (!noAnyHit)
                    answer.light *= 1 - alpha;
                if (ended)
                    continue;
                if (alpha < 0.5f && !noAnyHit) {
                    ++answer.crossed;
                    continue;
                }
                answer.tree = tree;
                answer.distance = 10 - height;
                ended = true;
            }
    if (answer.light < 0.01f)
        answer.light = 0;
    return answer;
}

class Forest {
public:
    Forest() {
        context_ = Context::create();
        context_->setRayTypeCount(2);
        context_->setEntryPointCount(1);
        context_->setRayGenerationProgram(0, program("look_down"));
        context_["step"]->setFloat(kStep);
        context_["extent"]->setFloat(kExtent - 0.01f);
        image_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, kSize, kSize);
        context_["image"]->set(image_);
        makeTexture();
        makeMesh();
        makeForest();
    }
    ~Forest() { context_->destroy(); }
    Forest(const Forest&) = delete;

    void check(const std::string& what, const std::vector<bool>& visible, unsigned mask = 255,
               unsigned flags = 0) {
        context_["mask"]->setUint(mask);
        context_["flags"]->setUint(flags);
        context_->launch(0, kSize, kSize);
        const auto* data = static_cast<const float4*>(image_->map());
        const std::vector<float4> pixels(data, data + kSize * kSize);
        image_->unmap();
        for (unsigned i = 0; i < kSize * kSize; ++i) {
            const float x = float(i % kSize) * kStep - kExtent + 0.01f,
                        z = float(i / kSize) * kStep - kExtent + 0.01f;
            const Answer wanted = trace(x, z, visible, flags & RT_RAY_FLAG_DISABLE_ANYHIT);
            const float4 seen = pixels[i];
            const bool same = std::fabs(seen.x - wanted.distance) < 1e-3f &&
                              int(seen.y) == wanted.tree &&
                              std::fabs(seen.w - wanted.light) < 1e-2f;
            // The library may call any-hit programs for holes behind the hit.
            require(same && int(seen.z) >= wanted.crossed,
                    what + ": pixel " + std::to_string(i) + " has tree " + std::to_string(seen.y) +
                        " at " + std::to_string(seen.x) + ", light " + std::to_string(seen.w) +
                        "; wanted " + std::to_string(wanted.tree) + " at " +
                        std::to_string(wanted.distance) + ", light " +
                        std::to_string(wanted.light));
        }
    }
    void hide(int tree, bool hide) { groups_[size_t(tree)]->setVisibilityMask(hide ? 2 : 255); }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    template <class T>
    Buffer upload(RTformat format, const std::vector<T>& values) {
        Buffer buffer = context_->createBuffer(RT_BUFFER_INPUT, format, values.size());
        std::copy(values.begin(), values.end(), static_cast<T*>(buffer->map()));
        buffer->unmap();
        return buffer;
    }
    void makeTexture() {
        Buffer texels = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT4, kTexels, kTexels);
        auto* to = static_cast<float4*>(texels->map());
        for (unsigned y = 0; y < kTexels; ++y)
            for (unsigned x = 0; x < kTexels; ++x)
                *to++ = make_float4(
                    1, 1, 1, alphaOf(0, (float(x) + 0.5f) / kTexels, (float(y) + 0.5f) / kTexels));
        texels->unmap();
        TextureSampler sampler = context_->createTextureSampler();
        sampler->setBuffer(texels);
        sampler->setFilteringModes(RT_FILTER_NEAREST, RT_FILTER_NEAREST, RT_FILTER_NONE);
        sampler->setReadMode(RT_TEXTURE_READ_ELEMENT_TYPE);
        sampler->setWrapMode(0, RT_WRAP_CLAMP_TO_EDGE);
        sampler->setWrapMode(1, RT_WRAP_CLAMP_TO_EDGE);
        context_["leaf_texture"]->setTextureSampler(sampler);
    }
    void makeMesh() {
        std::vector<float3> vertices;
        std::vector<float2> places;
        std::vector<int3> triangles;
        for (int leaf = 0; leaf < kLeaves; ++leaf) {
            const int first = 4 * leaf;
            for (int corner = 0; corner < 4; ++corner) {
                const float u = float(corner & 1), v = float(corner >> 1);
                vertices.push_back(make_float3(4 * u - 2, float(leaf + 1), 4 * v - 2));
                places.push_back(leaf % 2 ? make_float2(v, u) : make_float2(u, v));
            }
            triangles.push_back(make_int3(first, first + 1, first + 2));
            triangles.push_back(make_int3(first + 3, first + 2, first + 1));
        }
        mesh_ = context_->createGeometryTriangles();
        mesh_->setPrimitiveCount(unsigned(triangles.size()));
        Buffer indices = upload(RT_FORMAT_INT3, triangles);
        mesh_->setTriangleIndices(indices, RT_FORMAT_UNSIGNED_INT3);
        mesh_->setVertices(unsigned(vertices.size()), upload(RT_FORMAT_FLOAT3, vertices),
                           RT_FORMAT_FLOAT3);
        mesh_->setAttributeProgram(program("leaf_attributes"));
        mesh_["index_buffer"]->set(indices);
        mesh_["texcoord_buffer"]->set(upload(RT_FORMAT_FLOAT2, places));
    }
    void makeForest() {
        const Program anyHit = program("leaf_any_hit"), shadow = program("leaf_shadow"),
                      closest = program("leaf_closest");
        Group forest = context_->createGroup();
        forest->setAcceleration(context_->createAcceleration("Trbvh"));
        Acceleration shared = context_->createAcceleration("Trbvh");
        for (int tree = 0; tree < kTrees; ++tree) {
            Material material = context_->createMaterial();
            material->setAnyHitProgram(0, anyHit);
            material->setAnyHitProgram(1, shadow);
            material->setClosestHitProgram(0, closest);
            material["tree"]->setInt(tree);
            GeometryGroup group = context_->createGeometryGroup();
            group->addChild(context_->createGeometryInstance(mesh_, material));
            group->setAcceleration(shared);
            Transform transform = context_->createTransform();
            transform->setChild(group);
            transform->setMatrix(false, Matrix4x4::translate(kPlaces[tree]).getData(), nullptr);
            forest->addChild(transform);
            groups_.push_back(group);
        }
        Geometry ground = context_->createGeometry();
        ground->setPrimitiveCount(1);
        ground->setBoundingBoxProgram(program("ground_bounds"));
        ground->setIntersectionProgram(program("ground"));
        Material soil = context_->createMaterial();
        soil->setClosestHitProgram(0, program("ground_closest"));
        GeometryGroup group = context_->createGeometryGroup();
        group->addChild(context_->createGeometryInstance(ground, &soil, &soil + 1));
        group->setAcceleration(context_->createAcceleration("NoAccel"));
        forest->addChild(group);
        context_["forest"]->set(forest);
    }

    Context context_;
    Buffer image_;
    GeometryTriangles mesh_;
    std::vector<GeometryGroup> groups_;
};

void run() {
    Forest forest;
    const std::vector<bool> all(kTrees, true);
    forest.check("all trees", all);
    forest.check("without any-hit programs", all, 255, RT_RAY_FLAG_DISABLE_ANYHIT);
    std::vector<bool> some = all;
    some[1] = some[3] = false;
    forest.hide(1, true);
    forest.hide(3, true);
    forest.check("two trees", some, 1);
    forest.check("two trees that the mask shows", all, 3);
    forest.hide(1, false);
    some[1] = true;
    forest.check("three trees", some, 1);
}

} // namespace

int main() {
    return runProgram(run);
}
