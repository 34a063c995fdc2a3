// SPDX-License-Identifier: Apache-2.0
// A camera for batches of rays, and pictures from their colours.
#pragma once

#include "glb_model.h"
#include "png_image.h"

#include <algorithm>
#include <cmath>

// RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION.
struct PrimeRay {
    Vec origin, direction;
};
// RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V.
struct PrimeHit {
    float t;
    int32_t triangle, instance;
    float u, v;
};

// Rays of a picture, a row after the other. The camera looks at a box from a direction, which
// points to the camera, so that the box fills the picture.
inline std::vector<PrimeRay> cameraRays(Vec lower, Vec upper, Vec from, unsigned width,
                                        unsigned height) {
    const Vec centre = 0.5f * (lower + upper), half = 0.5f * (upper - lower);
    const float radius = std::sqrt(dot(half, half));
    const Vec back = normalize(from), right = normalize(cross({0, 1, 0}, back)),
              up = cross(back, right);
    constexpr float kTangent = 0.35f; // of half the field of view
    const Vec eye = centre + (0.68f * radius / kTangent) * back;
    std::vector<PrimeRay> rays;
    for (unsigned y = 0; y < height; ++y)
        for (unsigned x = 0; x < width; ++x) {
            const float aspect = float(width) / float(height);
            const float sx = (2 * (float(x) + 0.5f) / float(width) - 1) * kTangent * aspect;
            const float sy = (1 - 2 * (float(y) + 0.5f) / float(height)) * kTangent;
            rays.push_back({eye, normalize(sx * right + sy * up - back)});
        }
    return rays;
}

inline void writePicture(const std::string& path, unsigned width, unsigned height,
                         const std::vector<Vec>& colors) {
    std::vector<float> linear;
    for (const Vec& c : colors)
        linear.insert(linear.end(), {c.x, c.y, c.z, 1});
    writePng(path, width, height, toSrgb(linear, false));
}
