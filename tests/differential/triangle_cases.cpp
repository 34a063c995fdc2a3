// SPDX-License-Identifier: Apache-2.0
// Triangles and custom primitives in one geometry structure.
#include "lab.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace differential {
namespace {

Pipeline plain(const char* anyHit = nullptr, unsigned rule = kAccept, unsigned records = 1) {
    Pipeline pipeline;
    for (unsigned i = 0; i < records; ++i) {
        HitRecord hit;
        hit.anyHit = anyHit;
        hit.data = {100 + i, rule, nullptr};
        pipeline.hits.push_back(hit);
    }
    return pipeline;
}

void traceMesh(const Lab& lab, Answer& answer, const Mesh& mesh, const Pipeline& pipeline,
               const std::vector<TestRay>& rays) {
    const Accel accel = lab.triangles(mesh);
    answer.seen = lab.trace(pipeline, rays, accel.handle);
}

void random(const Lab& lab, Answer& answer) {
    traceMesh(lab, answer, randomTriangles(300, 0.4f, 1), plain(), randomRays(400, 3, 2));
}

void culling(const Lab& lab, Answer& answer) {
    std::vector<TestRay> rays = randomRays(400, 3, 3);
    for (size_t i = 0; i < rays.size(); ++i)
        rays[i].flags = i % 2 ? OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES
                              : OPTIX_RAY_FLAG_CULL_FRONT_FACING_TRIANGLES;
    Mesh mesh = randomTriangles(300, 0.4f, 4);
    mesh.flags = {OPTIX_GEOMETRY_FLAG_NONE, OPTIX_GEOMETRY_FLAG_DISABLE_TRIANGLE_FACE_CULLING};
    for (unsigned i = 0; i < 300; ++i)
        mesh.sbt.push_back(i / 7 % 2);
    traceMesh(lab, answer, mesh, plain(nullptr, kAccept, 2), rays);
}

// Every combination of geometry flags, ray flags about any-hit programs and rules of those.
void anyHit(const Lab& lab, Answer& answer, Rule rule) {
    const unsigned flags[] = {OPTIX_RAY_FLAG_NONE,
                              OPTIX_RAY_FLAG_DISABLE_ANYHIT,
                              OPTIX_RAY_FLAG_ENFORCE_ANYHIT,
                              OPTIX_RAY_FLAG_CULL_DISABLED_ANYHIT,
                              OPTIX_RAY_FLAG_CULL_ENFORCED_ANYHIT,
                              OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
                              OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT | OPTIX_RAY_FLAG_DISABLE_ANYHIT,
                              OPTIX_RAY_FLAG_ENFORCE_ANYHIT |
                                  OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES};
    std::vector<TestRay> rays = randomRays(400, 3, 5 + rule);
    for (size_t i = 0; i < rays.size(); ++i)
        rays[i].flags = flags[i / 3 % 8];
    Mesh mesh = randomTriangles(300, 0.4f, 6);
    mesh.flags = {OPTIX_GEOMETRY_FLAG_NONE, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT,
                  OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL};
    for (unsigned i = 0; i < 300; ++i)
        mesh.sbt.push_back(i / 5 % 3);
    traceMesh(lab, answer, mesh, plain("__anyhit__rule", rule, 3), rays);
}

// The library may choose which hit ends such a ray, but not whether there is a hit.
void firstHit(const Lab& lab, Answer& answer) {
    std::vector<TestRay> rays = randomRays(400, 3, 7);
    for (TestRay& ray : rays)
        ray.flags = OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_ANYHIT;
    traceMesh(lab, answer, randomTriangles(300, 0.4f, 8), plain(), rays);
    for (Seen& s : answer.seen) {
        const unsigned outcome = s.outcome;
        s = {};
        s.outcome = outcome;
    }
}

void sbtOffsets(const Lab& lab, Answer& answer) {
    std::vector<TestRay> rays = randomRays(300, 3, 9);
    for (size_t i = 0; i < rays.size(); ++i) {
        rays[i].sbtOffset = unsigned(i % 3);
        rays[i].sbtStride = unsigned(i / 3 % 3);
    }
    Mesh mesh = randomTriangles(300, 0.4f, 10);
    mesh.flags.assign(3, OPTIX_GEOMETRY_FLAG_NONE);
    for (unsigned i = 0; i < 300; ++i)
        mesh.sbt.push_back(i / 5 % 3);
    traceMesh(lab, answer, mesh, plain(nullptr, kAccept, 12), rays);
}

// Rays at vertices and edges of a closed surface: each must hit.
void edges(const Lab& lab, Answer& answer) {
    const Mesh mesh = roughSphere(8, 11);
    Random random(12);
    std::vector<TestRay> rays;
    for (unsigned i = 0; i < 600; ++i) {
        const size_t triangle = random.next() % (mesh.indices.size() / 3);
        const float* a = &mesh.vertices[3 * mesh.indices[3 * triangle + i % 3]];
        const float* b = &mesh.vertices[3 * mesh.indices[3 * triangle + (i + 1) % 3]];
        const float weight = i % 4 == 0 ? 0.0f : random.unit();
        float origin[3], direction[3];
        for (int k = 0; k < 3; ++k) {
            origin[k] = 3 * random.symmetric();
            direction[k] = a[k] + weight * (b[k] - a[k]) - origin[k];
        }
        if (i % 5 == 0) // along an axis, exactly
            for (int k = 0; k < 3; ++k) {
                origin[k] = k == int(i / 5 % 3) ? -4.0f : a[k];
                direction[k] = k == int(i / 5 % 3) ? 1.0f : 0.0f;
            }
        rays.push_back(makeRay(origin, direction));
    }
    traceMesh(lab, answer, mesh, plain(), rays);
}

// Rays nearly in the plane of the triangle that they are aimed at.
void grazing(const Lab& lab, Answer& answer) {
    const Mesh mesh = randomTriangles(100, 0.5f, 13);
    Random random(14);
    std::vector<TestRay> rays;
    for (unsigned i = 0; i < 400; ++i) {
        const float* v = &mesh.vertices[9 * (i % 100)];
        const float u = 0.1f + 0.4f * random.unit(), w = 0.1f + 0.4f * random.unit();
        const float lift = i % 4 == 0 ? 0.0f : 1e-3f * random.symmetric();
        float origin[3], direction[3];
        for (int k = 0; k < 3; ++k) {
            const float target = v[k] + u * (v[3 + k] - v[k]) + w * (v[6 + k] - v[k]);
            direction[k] = v[3 + k] - v[k] + 0.3f * (v[6 + k] - v[k]) + lift * random.symmetric();
            origin[k] = target - 3 * direction[k];
        }
        rays.push_back(makeRay(origin, direction));
    }
    traceMesh(lab, answer, mesh, plain(), rays);
}

void longThin(const Lab& lab, Answer& answer) {
    Mesh mesh = randomTriangles(400, 0.0f, 15);
    Random random(16);
    for (size_t i = 0; i < 400; ++i)
        for (int k = 0; k < 3; ++k) {
            const float along = random.symmetric();
            mesh.vertices[9 * i + size_t(k)] -= along;
            mesh.vertices[9 * i + 3 + size_t(k)] += along;
            mesh.vertices[9 * i + 6 + size_t(k)] += 0.02f * random.symmetric();
        }
    traceMesh(lab, answer, mesh, plain(), randomRays(600, 3, 17));
}

// Every triangle three times, each with a separate record.
void coincident(const Lab& lab, Answer& answer) {
    Mesh mesh = randomTriangles(100, 0.4f, 18);
    const std::vector<uint32_t> once = mesh.indices;
    for (int copy = 0; copy < 2; ++copy)
        mesh.indices.insert(mesh.indices.end(), once.begin(), once.end());
    traceMesh(lab, answer, mesh, plain(), randomRays(300, 3, 19));
}

void degenerate(const Lab& lab, Answer& answer) {
    Mesh mesh = randomTriangles(200, 0.4f, 20);
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (size_t i = 0; i < 200; ++i) {
        float* v = &mesh.vertices[9 * i];
        if (i % 5 == 0)
            std::copy(v, v + 3, v + 3); // a line
        if (i % 5 == 1)
            v[i % 9] = kNan;
        if (i % 5 == 2) // a point
            std::copy(v, v + 3, std::copy(v, v + 3, v + 3));
    }
    traceMesh(lab, answer, mesh, plain(), randomRays(300, 3, 21));
}

// Directions and intervals at the limits that the manual defines.
void oddRays(const Lab& lab, Answer& answer) {
    std::vector<TestRay> rays = randomRays(300, 3, 22);
    for (size_t i = 0; i < rays.size(); ++i) {
        TestRay& ray = rays[i];
        const float scale = i % 6 == 0 ? 1e10f : i % 6 == 1 ? 1e-10f : 1.0f;
        for (float& d : ray.direction)
            d *= scale;
        if (i % 6 < 2) {
            ray.tmin = 0;
            ray.tmax = 1e30f;
        }
        if (i % 6 == 2)
            ray.direction[i / 6 % 3] = 0;
        if (i % 6 == 3) {
            ray.direction[i / 6 % 3] = 0;
            ray.direction[(i / 6 + 1) % 3] = -0.0f;
        }
        if (i % 6 == 4)
            ray.tmax = ray.tmin;
    }
    traceMesh(lab, answer, randomTriangles(300, 0.4f, 23), plain(), rays);
}

std::vector<float> randomSpheres(unsigned count, uint64_t seed) {
    Random random(seed);
    std::vector<float> spheres;
    for (unsigned i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k)
            spheres.push_back(random.symmetric());
        spheres.push_back(0.05f + 0.15f * random.unit());
    }
    return spheres;
}

void custom(const Lab& lab, Answer& answer, Rule rule) {
    const std::vector<float> spheres = randomSpheres(200, 24);
    DeviceBuffer deviceSpheres;
    deviceSpheres.upload(spheres);
    const Accel accel = lab.boxes(spheres, OPTIX_GEOMETRY_FLAG_NONE);
    Pipeline pipeline;
    pipeline.primitiveTypes = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
    HitRecord hit;
    hit.closestHit = "__closesthit__seen";
    hit.anyHit = rule == kAccept ? nullptr : "__anyhit__rule";
    hit.intersection = "__intersection__sphere";
    hit.data = {100, rule, deviceSpheres.as<float>()};
    pipeline.hits = {hit};
    answer.seen = lab.trace(pipeline, randomRays(400, 3, 25), accel.handle);
}

} // namespace

std::vector<Case> triangleCases() {
    const auto rule = [](auto function, Rule value) {
        return [=](const Lab& lab, Answer& answer) { function(lab, answer, value); };
    };
    return {{"triangles.random", random},
            {"triangles.culling", culling},
            {"triangles.any_hit_accepts", rule(anyHit, kAccept)},
            {"triangles.any_hit_ignores_odd", rule(anyHit, kIgnoreOdd)},
            {"triangles.any_hit_cuts_out", rule(anyHit, kIgnorePattern)},
            {"triangles.any_hit_ignores_all", rule(anyHit, kIgnoreAll)},
            {"triangles.first_hit", firstHit},
            {"triangles.sbt_offsets", sbtOffsets},
            {"triangles.edges", edges},
            {"triangles.grazing", grazing},
            {"triangles.long_thin", longThin},
            {"triangles.coincident", coincident},
            {"triangles.degenerate", degenerate},
            {"triangles.odd_rays", oddRays},
            {"custom.spheres", rule(custom, kAccept)},
            {"custom.any_hit_ignores_odd", rule(custom, kIgnoreOdd)}};
}

} // namespace differential
