// SPDX-License-Identifier: Apache-2.0
#include "judge.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bench {
namespace {

using Real = __float128;

template <class T>
struct V3 {
    T x, y, z;
};
template <class T>
V3<T> cross(V3<T> a, V3<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T dot(V3<T> a, V3<T> b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// A triangle's corners as seen from the ray's origin.
template <class T>
struct Corners {
    V3<T> a, b, c;
};

template <class T>
Corners<T> cornersOf(const Mesh& mesh, const Ray& ray, uint32_t triangle) {
    const uint32_t* index = &mesh.indices[3 * size_t(triangle)];
    const auto corner = [&](int k) {
        const float* v = &mesh.vertices[3 * size_t(index[k])];
        return V3<T>{T(v[0]) - T(ray.origin[0]), T(v[1]) - T(ray.origin[1]),
                     T(v[2]) - T(ray.origin[2])};
    };
    return {corner(0), corner(1), corner(2)};
}

template <class T>
T distanceOf(const Corners<T>& k, V3<T> direction) {
    const V3<T> p = {k.b.x - k.a.x, k.b.y - k.a.y, k.b.z - k.a.z};
    const V3<T> q = {k.c.x - k.a.x, k.c.y - k.a.y, k.c.z - k.a.z};
    const V3<T> normal = cross(p, q);
    return dot(normal, k.a) / dot(normal, direction);
}

template <class T>
V3<T> directionOf(const Ray& ray) {
    return {T(ray.direction[0]), T(ray.direction[1]), T(ray.direction[2])};
}

// Whether the ray may meet the triangle, decided in double precision.
bool mayHit(const Corners<double>& k, V3<double> d) {
    const double u = dot(d, cross(k.b, k.c)), v = dot(d, cross(k.c, k.a)),
                 w = dot(d, cross(k.a, k.b));
    const double slack = 1e-10 * (std::abs(u) + std::abs(v) + std::abs(w)) + 1e-30;
    return std::min({u, v, w}) >= -slack || std::max({u, v, w}) <= slack;
}

// The exact distance, edges included; infinity: no hit.
double exactHit(const Mesh& mesh, const Ray& ray, uint32_t triangle) {
    const auto k = cornersOf<Real>(mesh, ray, triangle);
    const auto d = directionOf<Real>(ray);
    const Real u = dot(d, cross(k.b, k.c)), v = dot(d, cross(k.c, k.a)),
               w = dot(d, cross(k.a, k.b));
    const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    const double t = inside && u + v + w != 0 ? double(distanceOf(k, d)) : NAN;
    return t >= double(ray.tmin) && t <= double(ray.tmax) ? t
                                                          : std::numeric_limits<double>::infinity();
}

// The nearest hit among all triangles; infinity: none.
double exactNearest(const Mesh& mesh, const Ray& ray) {
    tbb::enumerable_thread_specific<double> nearest(std::numeric_limits<double>::infinity());
    const auto d = directionOf<double>(ray);
    tbb::parallel_for(0u, mesh.numTriangles(), [&](uint32_t i) {
        if (mayHit(cornersOf<double>(mesh, ray, i), d))
            nearest.local() = std::min(nearest.local(), exactHit(mesh, ray, i));
    });
    double result = std::numeric_limits<double>::infinity();
    for (const double t : nearest)
        result = std::min(result, t);
    return result;
}

bool isHit(RayQuery query, const GpuHit& hit) {
    return query == RayQuery::kAny ? hit.primitive == 1 : hit.primitive != ~0u;
}

bool isRight(RayQuery query, const GpuHit& hit, double exact) {
    const bool found = isHit(query, hit);
    return found == std::isfinite(exact) &&
           (!found || query == RayQuery::kAny || std::abs(hit.t - exact) <= 1e-5 * exact);
}

// Sums over rays whose hits differ.
struct Tally {
    size_t found = 0, primitive = 0, distance = 0;
    size_t judged = 0, oursRight = 0, referenceRight = 0;
    size_t nearerOurs = 0, nearerReference = 0;
    double worstOurs = 0, worstReference = 0;
    bool judges = false;

    // Null if all hits are equal.
    nlohmann::json counts(size_t rays) const {
        if (found + primitive + distance == 0)
            return nullptr;
        nlohmann::json out = {{"rays", rays},
                              {"hit or not", found},
                              {"primitive", primitive},
                              {"distance by 1e-4, same primitive", distance}};
        if (judged > 0)
            out.update({{"judged exactly", judged},
                        {"Sunstone right", oursRight},
                        {"reference right", referenceRight}});
        if (nearerOurs + nearerReference > 0)
            out.update({{"distances: Sunstone nearer", nearerOurs},
                        {"reference nearer", nearerReference},
                        {"Sunstone's largest relative error", worstOurs},
                        {"reference's largest", worstReference}});
        return out;
    }
};

void judgeDistance(const World& world, const Ray& ray, const GpuHit& ours, const GpuHit& reference,
                   Tally& tally) {
    const double exact = planeDistance(world, ray, ours);
    const double a = std::abs(ours.t - exact), b = std::abs(reference.t - exact);
    tally.nearerOurs += a < b;
    tally.nearerReference += b < a;
    tally.worstOurs = std::max(tally.worstOurs, a / std::abs(exact));
    tally.worstReference = std::max(tally.worstReference, b / std::abs(exact));
}

} // namespace

double planeDistance(const World& world, const Ray& ray, const GpuHit& hit) {
    if (world.kind != WorldKind::kInstances)
        return double(
            distanceOf(cornersOf<Real>(world.mesh, ray, hit.primitive), directionOf<Real>(ray)));
    // Corners in the world, seen from the ray's origin.
    const float* m = &world.matrices[12 * size_t(hit.instance)];
    const uint32_t* index = &world.mesh.indices[3 * size_t(hit.primitive)];
    const auto corner = [&](int k) {
        const float* v = &world.mesh.vertices[3 * size_t(index[k])];
        const auto row = [&](int r) {
            return Real(m[4 * r]) * Real(v[0]) + Real(m[4 * r + 1]) * Real(v[1]) +
                   Real(m[4 * r + 2]) * Real(v[2]) + Real(m[4 * r + 3]) - Real(ray.origin[r]);
        };
        return V3<Real>{row(0), row(1), row(2)};
    };
    return double(
        distanceOf(Corners<Real>{corner(0), corner(1), corner(2)}, directionOf<Real>(ray)));
}

nlohmann::json compareHits(const World& world, const std::vector<Ray>& rays, RayQuery query,
                           const std::vector<GpuHit>& ours, const std::vector<GpuHit>& reference) {
    constexpr size_t kMostJudged = 32; // each tests all triangles
    Tally tally;
    tally.judges = world.kind == WorldKind::kTriangles;
    for (size_t i = 0; i < rays.size(); ++i) {
        const GpuHit &a = ours[i], &b = reference[i];
        const bool found = isHit(query, a);
        if (found == isHit(query, b) && (query == RayQuery::kAny || !found))
            continue;
        bool other = found != isHit(query, b);
        tally.found += other;
        if (!other && (a.primitive != b.primitive ||
                       (world.kind == WorldKind::kInstances && a.instance != b.instance))) {
            other = true;
            ++tally.primitive;
        } else if (!other && std::abs(a.t - b.t) > 1e-4f * std::abs(b.t)) {
            ++tally.distance;
            if (tally.judges || world.kind == WorldKind::kInstances)
                judgeDistance(world, rays[i], a, b, tally);
        }
        if (other && tally.judges && tally.judged < kMostJudged) {
            const double exact = exactNearest(world.mesh, rays[i]);
            ++tally.judged;
            tally.oursRight += isRight(query, a, exact);
            tally.referenceRight += isRight(query, b, exact);
        }
    }
    return tally.counts(rays.size());
}

} // namespace bench
