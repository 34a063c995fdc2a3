// SPDX-License-Identifier: Apache-2.0
// A model of instances with OptiX Prime: many instances of one model of a glTF file, each with its
// own rotation, size and colour. A second query computes shadows.
#include "arguments.h"
#include "picture.h"

#include "optix_prime/optix_primepp.h"

#include <cstdio>

namespace {

using namespace optix::prime;

struct Transform {
    float rows[12];
    Vec direction(Vec d) const {
        return {rows[0] * d.x + rows[1] * d.y + rows[2] * d.z,
                rows[4] * d.x + rows[5] * d.y + rows[6] * d.z,
                rows[8] * d.x + rows[9] * d.y + rows[10] * d.z};
    }
};

// A square of models on a plane; each is turned about the vertical axis.
std::vector<Transform> arrange(const GlbModel& model, unsigned side) {
    const Vec size = model.upper - model.lower, centre = 0.5f * (model.lower + model.upper);
    const float step = 1.1f * std::max(size.x, size.z);
    std::vector<Transform> transforms;
    for (unsigned i = 0; i < side * side; ++i) {
        const float angle = 0.9f * float(i), scale = 0.7f + 0.1f * float(i * 7 % 4);
        const float c = scale * std::cos(angle), s = scale * std::sin(angle);
        const float x = step * (float(i % side) - 0.5f * float(side - 1)),
                    z = step * (float(i / side) - 0.5f * float(side - 1));
        transforms.push_back({{c, 0, s, x - c * centre.x - s * centre.z, //
                               0, scale, 0, -scale * model.lower.y,      //
                               -s, 0, c, z + s * centre.x - c * centre.z}});
    }
    return transforms;
}

// Two triangles below all others.
std::vector<Vec> groundVertices(float reach) {
    const Vec a = {-reach, 0, -reach}, b = {-reach, 0, reach}, c = {reach, 0, reach},
              d = {reach, 0, -reach};
    return {a, b, c, a, c, d};
}

template <class Hit>
std::vector<Hit> trace(Model& scene, RTPquerytype type, RTPbufferformat format,
                       std::vector<PrimeRay>& rays) {
    std::vector<Hit> hits(rays.size());
    Query query = scene->createQuery(type);
    query->setRays(rays.size(), RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION, RTP_BUFFER_TYPE_HOST,
                   rays.data());
    query->setHits(hits.size(), format, RTP_BUFFER_TYPE_HOST, hits.data());
    query->execute(RTP_QUERY_HINT_NONE);
    return hits;
}

Vec colorOf(int32_t instance) {
    const auto wave = [&](float phase) {
        return 0.55f + 0.35f * std::cos(2.4f * float(instance) + phase);
    };
    return {wave(0), wave(2.1f), wave(4.2f)};
}

std::vector<Vec> draw(Model& scene, const GlbModel& model, const std::vector<Transform>& transforms,
                      std::vector<PrimeRay>& rays) {
    const std::vector<PrimeHit> hits = trace<PrimeHit>(
        scene, RTP_QUERY_TYPE_CLOSEST, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, rays);
    const Vec light = normalize({0.5f, 0.8f, 0.3f});
    std::vector<Vec> normals(rays.size());
    std::vector<PrimeRay> shadows(rays.size(), {{0, 0, 0}, {0, 0, 0}}); // zero directions miss
    for (size_t i = 0; i < rays.size(); ++i) {
        const PrimeHit& hit = hits[i];
        if (hit.t < 0)
            continue;
        Vec n = {0, 1, 0}; // of the ground, which is the last instance
        if (size_t(hit.instance) + 1 != transforms.size()) {
            const Triangle& t = model.triangles[size_t(hit.triangle)];
            const auto normal = [&](int32_t k) { return model.normals[size_t(k)]; };
            // The transforms are rotations with one scale, so normals transform like directions.
            n = normalize(transforms[size_t(hit.instance)].direction(
                (1 - hit.u - hit.v) * normal(t.a) + hit.u * normal(t.b) + hit.v * normal(t.c)));
        }
        if (dot(n, rays[i].direction) > 0)
            n = -1.0f * n;
        normals[i] = n;
        shadows[i] = {rays[i].origin + hit.t * rays[i].direction + (1e-4f * hit.t) * n, light};
    }
    const std::vector<float> occluded =
        trace<float>(scene, RTP_QUERY_TYPE_ANY, RTP_BUFFER_FORMAT_HIT_T, shadows);
    std::vector<Vec> colors(rays.size(), {0.75f, 0.8f, 0.85f});
    for (size_t i = 0; i < rays.size(); ++i)
        if (hits[i].t >= 0) {
            const float sun = occluded[i] < 0 ? std::max(0.0f, dot(normals[i], light)) : 0.0f;
            const bool ground = size_t(hits[i].instance) + 1 == transforms.size();
            colors[i] = (0.2f + 0.1f * normals[i].y + 0.75f * sun) *
                        (ground ? Vec{0.6f, 0.6f, 0.58f} : colorOf(hits[i].instance));
        }
    return colors;
}

int run(int argc, char** argv) {
    std::string path = "assets/demo.glb", output = "prime_instances.png";
    unsigned width = 1024, height = 768, side = 5;
    Arguments arguments("Many instances of one model, with shadows (OptiX Prime)");
    arguments.addPositional("model.glb", path, "binary glTF file");
    arguments.add("-o,--output", output, "PNG file");
    arguments.add("--width", width, 1, 8192, "pixels");
    arguments.add("--height", height, 1, 8192, "pixels");
    arguments.add("--side", side, 1, 1000, "instances along each side of the square");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    const GlbModel model = readGlb(path);
    Context context = Context::create(RTP_CONTEXT_TYPE_CPU);
    Model part = context->createModel(), ground = context->createModel(),
          scene = context->createModel();
    part->setTriangles(model.triangles.size(), RTP_BUFFER_TYPE_HOST, model.triangles.data(),
                       model.vertices.size(), RTP_BUFFER_TYPE_HOST, model.vertices.data());
    part->update(RTP_MODEL_HINT_NONE);
    const float reach = 0.62f * float(side) * (model.upper.x - model.lower.x);
    const std::vector<Vec> square = groundVertices(1.1f * reach);
    ground->setTriangles(square.size() / 3, RTP_BUFFER_TYPE_HOST, square.data());
    ground->update(RTP_MODEL_HINT_NONE);
    std::vector<Transform> transforms = arrange(model, side);
    std::vector<RTPmodel> list(transforms.size(), part->getRTPmodel());
    transforms.push_back({{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
    list.push_back(ground->getRTPmodel());
    scene->setInstances(list.size(), RTP_BUFFER_TYPE_HOST, list.data(),
                        RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, RTP_BUFFER_TYPE_HOST,
                        transforms.data());
    scene->update(RTP_MODEL_HINT_NONE);
    std::vector<PrimeRay> rays = cameraRays({-reach, 0, -reach}, {reach, 0.2f * reach, reach},
                                            {0.5f, 0.7f, 1}, width, height);
    writePicture(output, width, height, draw(scene, model, transforms, rays));
    std::printf("%s: %zu instances of %zu triangles\n", output.c_str(), list.size() - 1,
                model.triangles.size());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("prime_instances", [&] { return run(argc, argv); });
}
