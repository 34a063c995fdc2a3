// SPDX-License-Identifier: Apache-2.0
// Bakes ambient occlusion into the vertices of a model with OptiX Prime, then draws the model with
// it. The rays of all vertices are one batch, whose result is one bit per ray.
#include "arguments.h"
#include "picture.h"

#include "optix_prime/optix_primepp.h"

#include <cstdio>

namespace {

using namespace optix::prime;

// Points of the unit disc, evenly spread: the golden angle.
Vec hemispherePoint(unsigned i, unsigned count, float turn) {
    const float r2 = (float(i) + 0.5f) / float(count), angle = 2.3999632f * float(i) + turn;
    const float r = std::sqrt(r2);
    return {r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r2)};
}

// Rays over the hemisphere of each vertex, dense where the surface faces (cosine).
std::vector<PrimeRay> vertexRays(const GlbModel& model, unsigned samples) {
    const Vec size = model.upper - model.lower;
    const float offset = 1e-4f * std::sqrt(dot(size, size));
    std::vector<PrimeRay> rays;
    rays.reserve(model.vertices.size() * samples);
    for (size_t i = 0; i < model.vertices.size(); ++i) {
        const Vec n = model.normals[i];
        const Vec x = normalize(cross(std::fabs(n.x) < 0.7f ? Vec{1, 0, 0} : Vec{0, 1, 0}, n)),
                  y = cross(n, x);
        for (unsigned k = 0; k < samples; ++k) {
            const Vec p = hemispherePoint(k, samples, 0.61803f * float(i));
            rays.push_back(
                {model.vertices[i] + offset * n, normalize(p.x * x + p.y * y + p.z * n)});
        }
    }
    return rays;
}

// The open part of each vertex's hemisphere.
std::vector<float> bake(Model& scene, const GlbModel& model, unsigned samples) {
    std::vector<PrimeRay> rays = vertexRays(model, samples);
    std::vector<uint8_t> occluded((rays.size() + 7) / 8);
    Query query = scene->createQuery(RTP_QUERY_TYPE_ANY);
    query->setRays(rays.size(), RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION, RTP_BUFFER_TYPE_HOST,
                   rays.data());
    query->setHits(rays.size(), RTP_BUFFER_FORMAT_HIT_BITMASK, RTP_BUFFER_TYPE_HOST,
                   occluded.data());
    query->execute(RTP_QUERY_HINT_NONE);
    std::vector<float> open(model.vertices.size());
    for (size_t i = 0; i < open.size(); ++i) {
        unsigned hits = 0;
        for (size_t bit = i * samples; bit < (i + 1) * samples; ++bit)
            hits += occluded[bit / 8] >> bit % 8 & 1;
        open[i] = 1 - float(hits) / float(samples);
    }
    return open;
}

std::vector<Vec> draw(Model& scene, const GlbModel& model, const std::vector<float>& open,
                      unsigned width, unsigned height) {
    std::vector<PrimeRay> rays =
        cameraRays(model.lower, model.upper, {0.6f, 0.45f, 1}, width, height);
    std::vector<PrimeHit> hits(rays.size());
    Query query = scene->createQuery(RTP_QUERY_TYPE_CLOSEST);
    query->setRays(rays.size(), RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION, RTP_BUFFER_TYPE_HOST,
                   rays.data());
    query->setHits(hits.size(), RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, RTP_BUFFER_TYPE_HOST,
                   hits.data());
    query->execute(RTP_QUERY_HINT_NONE);
    std::vector<Vec> colors;
    for (const PrimeHit& hit : hits) {
        Vec color = {0.75f, 0.8f, 0.85f};
        if (hit.t >= 0) {
            const Triangle& t = model.triangles[size_t(hit.triangle)];
            const float value = (1 - hit.u - hit.v) * open[size_t(t.a)] +
                                hit.u * open[size_t(t.b)] + hit.v * open[size_t(t.c)];
            color = value * Vec{0.9f, 0.88f, 0.84f};
        }
        colors.push_back(color);
    }
    return colors;
}

int run(int argc, char** argv) {
    std::string path = "assets/demo.glb", output = "ambient_occlusion.png";
    unsigned width = 1024, height = 768, samples = 128;
    Arguments arguments("Bakes ambient occlusion into the vertices of a model (OptiX Prime)");
    arguments.addPositional("model.glb", path, "binary glTF file");
    arguments.add("-o,--output", output, "PNG file");
    arguments.add("--width", width, 1, 8192, "pixels");
    arguments.add("--height", height, 1, 8192, "pixels");
    arguments.add("--samples", samples, 1, 4096, "rays of a vertex");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    const GlbModel model = readGlb(path);
    Context context = Context::create(RTP_CONTEXT_TYPE_CPU);
    Model scene = context->createModel();
    scene->setTriangles(model.triangles.size(), RTP_BUFFER_TYPE_HOST, model.triangles.data(),
                        model.vertices.size(), RTP_BUFFER_TYPE_HOST, model.vertices.data());
    scene->update(RTP_MODEL_HINT_NONE);
    const std::vector<float> open = bake(scene, model, samples);
    writePicture(output, width, height, draw(scene, model, open, width, height));
    std::printf("%s: %zu triangles, %zu vertices, %u rays each\n", output.c_str(),
                model.triangles.size(), model.vertices.size(), samples);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("prime_ambient_occlusion", [&] { return run(argc, argv); });
}
