// SPDX-License-Identifier: Apache-2.0
#include "small_tracer.h"

#include "base/threads/threads.h"

#include <algorithm>
#include <cmath>

namespace hard {
namespace {

using sunstone::denoise::test::dot;
using sunstone::denoise::test::unit;

constexpr float kTurn = 6.2831853f, kOffset = 1e-3f, kFar = 1e30f;

struct Random {
    uint64_t state;

    float next() {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        uint32_t bits = uint32_t(((state >> 18) ^ state) >> 27);
        const uint32_t turn = uint32_t(state >> 59);
        bits = (bits >> turn) | (bits << ((32 - turn) & 31));
        return float(bits >> 8) * 0x1p-24f;
    }
};

struct Hit {
    float t = kFar;
    Vec place, normal;
    const Material* material = nullptr;
    bool isLamp = false;
};

Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Two directions perpendicular to a third.
void makeBasis(Vec axis, Vec& side, Vec& up) {
    side = unit(std::abs(axis.x) < 0.7f ? Vec{0, axis.z, -axis.y} : Vec{axis.z, 0, -axis.x});
    up = cross(axis, side);
}

void hitSphere(const Sphere& sphere, bool isLamp, Vec origin, Vec direction, Hit& hit) {
    const Vec to = origin - sphere.center;
    const float b = dot(to, direction), c = dot(to, to) - sphere.radius * sphere.radius;
    const float root = b * b - c;
    if (root <= 0)
        return;
    const float t = -b - std::sqrt(root);
    if (t < 1e-4f || t >= hit.t)
        return;
    hit.t = t;
    hit.normal = (origin + direction * t - sphere.center) * (1 / sphere.radius);
    hit.material = &sphere.material;
    hit.isLamp = isLamp;
}

void hitRectangle(const Rectangle& r, Vec origin, Vec direction, Hit& hit) {
    const float o[3] = {origin.x, origin.y, origin.z},
                d[3] = {direction.x, direction.y, direction.z};
    const float t = (r.offset - o[r.axis]) / d[r.axis];
    if (!(t > 1e-4f && t < hit.t))
        return;
    const int first = r.axis == 0 ? 1 : 0, second = r.axis == 2 ? 1 : 2;
    const float u = o[first] + t * d[first], v = o[second] + t * d[second];
    if (u < r.low[0] || u > r.high[0] || v < r.low[1] || v > r.high[1])
        return;
    float n[3] = {};
    n[r.axis] = d[r.axis] > 0 ? -1.0f : 1.0f;
    hit.t = t;
    hit.normal = {n[0], n[1], n[2]};
    hit.material = &r.material;
    hit.isLamp = false;
}

Hit trace(const Scene& scene, Vec origin, Vec direction) {
    Hit hit;
    for (const Rectangle& r : scene.rectangles)
        hitRectangle(r, origin, direction, hit);
    for (const Sphere& s : scene.spheres)
        hitSphere(s, false, origin, direction, hit);
    for (const Sphere& s : scene.lamps)
        hitSphere(s, true, origin, direction, hit);
    hit.place = origin + direction * hit.t;
    return hit;
}

Vec albedoAt(const Hit& hit) {
    return hit.material->texture ? hit.material->texture(hit.place) : hit.material->albedo;
}
Vec emissionAt(const Hit& hit) {
    return hit.material->glow ? hit.material->glow(hit.place) : hit.material->emission;
}

Vec onSphere(Random& random) {
    const float z = 1 - 2 * random.next(), turn = kTurn * random.next();
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(turn), r * std::sin(turn), z};
}

// The light of one lamp that a white diffuse surface reflects, estimated by one ray into the lamp's
// cone.
Vec direct(const Scene& scene, Vec origin, Vec normal, Random& random) {
    const size_t count = scene.lamps.size();
    const size_t chosen = std::min(size_t(random.next() * float(count)), count - 1);
    const Sphere& lamp = scene.lamps[chosen];
    const Vec to = lamp.center - origin;
    const float part = lamp.radius * lamp.radius / dot(to, to);
    const float least = std::sqrt(std::max(0.0f, 1 - part));
    Vec side, up;
    const Vec axis = unit(to);
    makeBasis(axis, side, up);
    const float c = 1 - random.next() * (1 - least), s = std::sqrt(std::max(0.0f, 1 - c * c));
    const float turn = kTurn * random.next();
    const Vec direction = axis * c + side * (s * std::cos(turn)) + up * (s * std::sin(turn));
    const float cosine = dot(direction, normal);
    if (cosine <= 0 || trace(scene, origin, direction).material != &lamp.material)
        return {};
    return lamp.material.emission * (float(count) * 2 * (1 - least) * cosine);
}

struct Sample {
    Vec color, albedo, normal;
};

Sample tracePath(const Scene& scene, Vec origin, Vec direction, Random& random) {
    Sample sample;
    Vec weight{1, 1, 1};
    const bool isSampled = !scene.lightByChance && !scene.lamps.empty();
    bool countsLamps = true; // else direct() has counted them
    for (int depth = 0; depth < scene.depth; ++depth) {
        const Hit hit = trace(scene, origin, direction);
        if (!hit.material) {
            const float up = std::max(0.0f, direction.y);
            const Vec sky = scene.horizon * (1 - up) + scene.zenith * up;
            sample.color = sample.color + weight * sky;
            break;
        }
        const Vec albedo = albedoAt(hit);
        if (depth == 0) {
            sample.albedo = hit.material->isMirror ? Vec{} : albedo;
            sample.normal = hit.normal;
        }
        if (!hit.isLamp || countsLamps)
            sample.color = sample.color + weight * emissionAt(hit);
        weight = weight * albedo;
        if (std::max({weight.x, weight.y, weight.z}) <= 0)
            break;
        origin = hit.place + hit.normal * kOffset;
        if (hit.material->isMirror) {
            direction = direction - hit.normal * (2 * dot(direction, hit.normal));
            direction = unit(direction + onSphere(random) * hit.material->roughness);
            if (dot(direction, hit.normal) <= 0)
                break;
            countsLamps = true;
            continue;
        }
        if (isSampled)
            sample.color = sample.color + weight * direct(scene, origin, hit.normal, random);
        countsLamps = !isSampled;
        direction = unit(hit.normal * 1.0001f + onSphere(random));
    }
    return sample;
}

// A ray through the pixel's place (u, v), in units of the picture's height.
void aim(const Scene& scene, float u, float v, Random& random, Vec& origin, Vec& direction) {
    const Vec to = scene.target - scene.eye;
    const Vec forward = unit(to), right = unit(cross(forward, {0, 1, 0}));
    const Vec up = cross(right, forward);
    direction = forward + (right * u + up * v) * scene.fieldOfView;
    origin = scene.eye;
    if (scene.aperture > 0) {
        const float focus = std::sqrt(dot(to, to));
        const float r = scene.aperture * std::sqrt(random.next()), turn = kTurn * random.next();
        const Vec shift = right * (r * std::cos(turn)) + up * (r * std::sin(turn));
        origin = origin + shift;
        direction = direction * focus - shift;
    }
    direction = unit(direction);
}

void put(float* pixel, Vec value) {
    pixel[0] = value.x;
    pixel[1] = value.y;
    pixel[2] = value.z;
}

void renderPixel(const Scene& scene, Rendering& result, uint32_t x, uint32_t y, uint32_t samples,
                 uint32_t seed) {
    const uint32_t width = result.color.width, height = result.color.height;
    Random random{(uint64_t(seed) << 40) + uint64_t(y) * width + x};
    for (int i = 0; i < 4; ++i) // neighbouring seeds give unlike numbers only after a while
        random.state = (random.state ^ (random.state >> 29)) * 0xbf58476d1ce4e5b9ull + 1;
    Sample sum;
    for (uint32_t s = 0; s < samples; ++s) {
        const float u = (float(x) + random.next() - 0.5f * float(width)) / float(height);
        const float v = (0.5f * float(height) - float(y) - random.next()) / float(height);
        Vec origin, direction;
        aim(scene, u, v, random, origin, direction);
        const Sample sample = tracePath(scene, origin, direction, random);
        sum.color = sum.color + sample.color;
        sum.albedo = sum.albedo + sample.albedo;
        sum.normal = sum.normal + sample.normal;
    }
    const float each = 1.0f / float(samples);
    put(result.color.at(x, y), sum.color * each);
    put(result.albedo.at(x, y), sum.albedo * each);
    put(result.normal.at(x, y), sum.normal * each);
}

} // namespace

Rendering render(const Scene& scene, uint32_t width, uint32_t height, uint32_t samples,
                 uint32_t seed) {
    Rendering result{Picture(width, height), Picture(width, height), Picture(width, height)};
    sunstone::parallelFor(height, 1, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (uint32_t x = 0; x < width; ++x)
                renderPixel(scene, result, x, uint32_t(y), samples, seed);
    });
    return result;
}

} // namespace hard
