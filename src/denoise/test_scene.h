// SPDX-License-Identifier: Apache-2.0
// Tests only: a small path tracer over spheres on a textured floor. Its image at many samples is
// the reference for a denoised image of few samples.
#pragma once

#include "denoise/image.h"

#include "base/threads/threads.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace sunstone::denoise::test {

struct Vec {
    float x = 0, y = 0, z = 0;
    Vec operator+(Vec o) const { return {x + o.x, y + o.y, z + o.z}; }
    Vec operator-(Vec o) const { return {x - o.x, y - o.y, z - o.z}; }
    Vec operator*(float s) const { return {x * s, y * s, z * s}; }
    Vec operator*(Vec o) const { return {x * o.x, y * o.y, z * o.z}; }
};
inline float dot(Vec a, Vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec unit(Vec a) {
    return a * (1.0f / std::sqrt(dot(a, a)));
}

// Four floats a pixel.
struct Picture {
    uint32_t width = 0, height = 0;
    std::vector<float> values;

    Picture() = default;
    Picture(uint32_t w, uint32_t h) : width(w), height(h), values(size_t(w) * h * 4, 0.0f) {
        for (size_t i = 3; i < values.size(); i += 4)
            values[i] = 1.0f;
    }
    float* at(uint32_t x, uint32_t y) { return &values[(size_t(y) * width + x) * 4]; }
    const float* at(uint32_t x, uint32_t y) const { return &values[(size_t(y) * width + x) * 4]; }
    Image image() {
        return {reinterpret_cast<uint8_t*>(values.data()),
                width,
                height,
                size_t(width) * 16,
                16,
                Format::kFloat4};
    }
    Image part(uint32_t x, uint32_t y, uint32_t w, uint32_t h) {
        Image whole = image();
        whole.data = whole.pixel(x, y);
        whole.width = w;
        whole.height = h;
        return whole;
    }
};

struct Rendering {
    Picture color, albedo, normal;
};

class Tracer {
public:
    Rendering render(uint32_t width, uint32_t height, uint32_t samples, uint32_t seed) const {
        Rendering result{Picture(width, height), Picture(width, height), Picture(width, height)};
        parallelFor(height, 1, [&](size_t begin, size_t end) {
            for (size_t y = begin; y < end; ++y)
                for (uint32_t x = 0; x < width; ++x)
                    renderPixel(result, x, uint32_t(y), samples, seed);
        });
        return result;
    }

private:
    struct Random {
        uint64_t state;
        float next() {
            state = state * 6364136223846793005ull + 1442695040888963407ull;
            uint32_t bits = uint32_t(((state >> 18) ^ state) >> 27);
            uint32_t turn = uint32_t(state >> 59);
            bits = (bits >> turn) | (bits << ((32 - turn) & 31));
            return float(bits >> 8) * 0x1p-24f;
        }
    };
    struct Sphere {
        Vec center;
        float radius;
        Vec color;
        float emission;
    };
    struct Hit {
        float t = 1e30f;
        Vec normal, color;
        float emission = 0;
    };

    static constexpr float kLampEmission = 14.0f;

    static Vec floorColor(Vec p) {
        bool odd = (int(std::floor(p.x)) + int(std::floor(p.z))) & 1;
        float grain = 0.9f + 0.1f * std::sin(p.x * 20) * std::sin(p.z * 20);
        Vec checks = (odd ? Vec{0.7f, 0.25f, 0.2f} : Vec{0.75f, 0.75f, 0.7f}) * grain;
        // Checks finer than pixels would add noise.
        float far = std::clamp((-p.z - 1.0f) * 0.3f, 0.0f, 1.0f);
        return checks * (1 - far) + Vec{0.72f, 0.5f, 0.45f} * far;
    }

    static Hit trace(Vec origin, Vec direction) {
        static const Sphere spheres[] = {
            {{-0.9f, 0.6f, 0}, 0.6f, {0.2f, 0.4f, 0.8f}, 0},
            {{0.6f, 0.45f, 0.5f}, 0.45f, {0.8f, 0.7f, 0.2f}, 0},
            {{0.5f, 0.9f, -1.2f}, 0.9f, {0.7f, 0.7f, 0.7f}, 0},
            {{-0.1f, 0.2f, 1.1f}, 0.2f, {0.3f, 0.8f, 0.4f}, 0},
            {{1.2f, 3.2f, 1.5f}, 0.6f, {0, 0, 0}, kLampEmission},
        };
        Hit hit;
        if (direction.y < 0) {
            float t = -origin.y / direction.y;
            if (t > 1e-4f) {
                hit.t = t;
                hit.normal = {0, 1, 0};
                hit.color = floorColor(origin + direction * t);
            }
        }
        for (const Sphere& s : spheres) {
            Vec to = origin - s.center;
            float b = dot(to, direction), c = dot(to, to) - s.radius * s.radius;
            float root = b * b - c;
            if (root <= 0)
                continue;
            float t = -b - std::sqrt(root);
            if (t < 1e-4f || t >= hit.t)
                continue;
            hit.t = t;
            hit.normal = unit(origin + direction * t - s.center);
            hit.color = s.color;
            hit.emission = s.emission;
        }
        return hit;
    }

    static Vec bounce(Vec normal, Random& random) {
        float z = 1 - 2 * random.next(), turn = 6.2831853f * random.next();
        float r = std::sqrt(std::max(0.0f, 1 - z * z));
        Vec sphere{r * std::cos(turn), r * std::sin(turn), z};
        return unit(normal * 1.0001f + sphere);
    }

    // Light of the lamp that a white diffuse surface reflects, from one direction into its cone.
    static float direct(Vec origin, Vec normal, Random& random) {
        constexpr Vec kLamp{1.2f, 3.2f, 1.5f};
        Vec to = kLamp - origin;
        float square = dot(to, to), cosMax = std::sqrt(std::max(0.0f, 1 - 0.36f / square));
        Vec axis = unit(to);
        Vec side =
            unit(std::abs(axis.x) < 0.7f ? Vec{0, axis.z, -axis.y} : Vec{axis.z, 0, -axis.x});
        Vec up{axis.y * side.z - axis.z * side.y, axis.z * side.x - axis.x * side.z,
               axis.x * side.y - axis.y * side.x};
        float c = 1 - random.next() * (1 - cosMax), s = std::sqrt(std::max(0.0f, 1 - c * c));
        float turn = 6.2831853f * random.next();
        Vec direction = axis * c + side * (s * std::cos(turn)) + up * (s * std::sin(turn));
        float cosine = dot(direction, normal);
        if (cosine <= 0 || trace(origin, direction).emission <= 0)
            return 0;
        return kLampEmission * 2 * (1 - cosMax) * cosine;
    }

    static void renderPixel(Rendering& result, uint32_t x, uint32_t y, uint32_t samples,
                            uint32_t seed) {
        uint32_t width = result.color.width, height = result.color.height;
        Random random{(uint64_t(seed) << 40) + uint64_t(y) * width + x};
        for (int i = 0; i < 4; ++i) // neighbouring seeds give unlike numbers only after a while
            random.state = (random.state ^ (random.state >> 29)) * 0xbf58476d1ce4e5b9ull + 1;
        Vec color, albedo, normal;
        for (uint32_t s = 0; s < samples; ++s) {
            float u = (float(x) + random.next() - 0.5f * float(width)) / float(height);
            float v = (0.5f * float(height) - float(y) - random.next()) / float(height);
            Vec origin{0, 1.3f, 4};
            Vec direction = unit({u, v - 0.15f, -1.2f});
            Vec weight{1, 1, 1};
            for (int depth = 0; depth < 4; ++depth) {
                Hit hit = trace(origin, direction);
                if (hit.t > 1e29f) {
                    color = color + weight * (Vec{0.35f, 0.45f, 0.6f} * (depth ? 0.6f : 1.0f));
                    break;
                }
                if (depth == 0) {
                    albedo = albedo + hit.color;
                    normal = normal + hit.normal;
                }
                if (hit.emission > 0) {
                    if (depth == 0) // later ones are counted by direct()
                        color = color + weight * hit.emission;
                    break;
                }
                weight = weight * hit.color;
                origin = origin + direction * hit.t + hit.normal * 1e-3f;
                color = color + weight * direct(origin, hit.normal, random);
                direction = bounce(hit.normal, random);
            }
        }
        float each = 1.0f / float(samples);
        put(result.color.at(x, y), color * each);
        put(result.albedo.at(x, y), albedo * each);
        put(result.normal.at(x, y), normal * each);
    }
    static void put(float* pixel, Vec v) {
        pixel[0] = v.x;
        pixel[1] = v.y;
        pixel[2] = v.z;
    }
};

// For the images as a screen shows them: clipped at 1, gamma 2.2.
inline double psnr(const Picture& a, const Picture& b) {
    double sum = 0;
    size_t count = 0;
    auto shown = [](float v) { return std::pow(std::clamp(double(v), 0.0, 1.0), 1 / 2.2); };
    for (size_t i = 0; i < a.values.size(); ++i) {
        if (i % 4 == 3)
            continue;
        double d = shown(a.values[i]) - shown(b.values[i]);
        sum += d * d;
        ++count;
    }
    return sum == 0 ? 200.0 : 10 * std::log10(double(count) / sum);
}

} // namespace sunstone::denoise::test
