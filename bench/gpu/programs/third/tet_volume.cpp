// SPDX-License-Identifier: Apache-2.0
// A volume of tetrahedra, as simulations make them; device/tet_volume.cu finds the tetrahedron of
// each sample with a ray.
#include "programs.h"

#include "device/tet_volume.h"

#include <algorithm>

std::string_view bench_third_tet_volume_ptx();

namespace bench {
namespace {

// A face with its tetrahedron, which is on the side of the normal or not.
struct Face {
    uint32_t low, middle, high; // vertices in order
    uint32_t tetrahedron;
    bool isInFront;
    bool isSameAs(const Face& o) const {
        return low == o.low && middle == o.middle && high == o.high;
    }
    bool operator<(const Face& o) const {
        return low != o.low ? low < o.low : middle != o.middle ? middle < o.middle : high < o.high;
    }
};

class TetVolume : public Renderer {
public:
    TetVolume(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const auto across = unsigned(std::cbrt(settings.some(36.0 * 36 * 36, 64)));
        makeVertices(across);
        makeTetrahedra(across);
        makeFaces();
        TetParams& p = launch_.params;
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        p.faces = scene_.build(inputOf(uploadMesh(scene_, mesh_), flags));
        p.sides = scene_.upload(sides_);
        p.tetrahedra = scene_.upload(tetrahedra_);
        p.points = scene_.upload(points_);
        p.steps = 40;
        p.camera = makeCamera(vec(-1.9f, 1.2f, -2.3f), vec(0), vec(0, 1, 0), 42, settings.aspect());
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.options.numPayloadValues = 1;
        programs_.options.pipelineLaunchParamsVariableName = "lp";
        const OptixModule module = programs_.load(bench_third_tet_volume_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__volume"});
        const auto miss = programs_.miss({module, "__miss__outside"});
        const auto hit = programs_.hit({{module, "__closesthit__face"}, {}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        table_.setHits(std::vector{makeRecord(hit)});
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    // A grid, bent into a ball, whose inner vertices are shaken.
    void makeVertices(unsigned n) {
        for (unsigned z = 0; z <= n; ++z)
            for (unsigned y = 0; y <= n; ++y)
                for (unsigned x = 0; x <= n; ++x) {
                    const auto i = unsigned(points_.size());
                    float3 p = vec(float(x), float(y), float(z)) * (2.0f / float(n)) - vec(1);
                    const float size = std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
                    if (size < 0.999f)
                        p += vec(randomOf(i, 0) - 0.5f, randomOf(i, 1) - 0.5f,
                                 randomOf(i, 2) - 0.5f) *
                             (0.5f / float(n));
                    p = p * (1 - size + size * size / std::max(length(p), 1e-6f));
                    const float value = 0.5f + 0.2f * std::sin(7 * p.x + 4 * p.y * p.z) +
                                        0.2f * std::sin(6 * p.y - 5 * p.x * p.z) +
                                        0.1f * std::sin(13 * p.z);
                    points_.push_back(make_float4(p.x, p.y, p.z, value));
                    mesh_.vertices.insert(mesh_.vertices.end(), {p.x, p.y, p.z});
                }
    }
    // Six around the diagonal of each cell.
    void makeTetrahedra(unsigned n) {
        const unsigned stride[3] = {1, n + 1, (n + 1) * (n + 1)};
        const unsigned orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                       {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
        for (unsigned cell = 0; cell < n * n * n; ++cell) {
            const unsigned first = cell % n + cell / n % n * stride[1] + cell / (n * n) * stride[2];
            for (const auto& order : orders) {
                const unsigned a = first + stride[order[0]], b = a + stride[order[1]];
                tetrahedra_.push_back(make_uint4(first, a, b, b + stride[order[2]]));
            }
        }
    }
    float3 at(uint32_t i) const { return vec(points_[i].x, points_[i].y, points_[i].z); }
    void makeFaces() {
        std::vector<Face> faces;
        for (uint32_t t = 0; t < tetrahedra_.size(); ++t) {
            const uint4 q = tetrahedra_[t];
            const uint32_t corners[4] = {q.x, q.y, q.z, q.w};
            for (unsigned opposite = 0; opposite < 4; ++opposite) {
                uint32_t c[3];
                for (unsigned k = 0, n = 0; k < 4; ++k)
                    if (k != opposite)
                        c[n++] = corners[k];
                std::sort(c, c + 3);
                const float3 normal = cross(at(c[1]) - at(c[0]), at(c[2]) - at(c[0]));
                faces.push_back(
                    {c[0], c[1], c[2], t, dot(normal, at(corners[opposite]) - at(c[0])) > 0});
            }
        }
        std::sort(faces.begin(), faces.end());
        for (size_t i = 0; i < faces.size(); ++i) {
            const Face& f = faces[i];
            if (i == 0 || !f.isSameAs(faces[i - 1])) {
                mesh_.indices.insert(mesh_.indices.end(), {f.low, f.middle, f.high});
                sides_.push_back(make_int2(-1, -1));
            }
            (f.isInFront ? sides_.back().x : sides_.back().y) = int(f.tetrahedron);
        }
    }

    Launch<TetParams> launch_;
    Mesh mesh_;
    std::vector<float4> points_;
    std::vector<uint4> tetrahedra_;
    std::vector<int2> sides_;
};

} // namespace

JobKind tetVolumeJob() {
    return thirdJob<TetVolume>(
        "tet_volume", "a ray to a face for each sample of a volume of tetrahedra", 0.002, 0.02);
}

} // namespace bench
