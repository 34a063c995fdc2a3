// SPDX-License-Identifier: Apache-2.0
// Data that the hosts and the device code of both path tracers share.
#pragma once

namespace twin {

constexpr unsigned kSegments = 5;
constexpr float kEpsilon = 1e-3f, kFar = 1e30f;
enum RayType { kPathRay, kShadowRay, kRayTypes };

struct Camera {
    float eye[3], forward[3], right[3], up[3];
};

// Launch parameters of the OptiX 7 program.
struct Params {
    unsigned long long traversable;
    float* picture; // four floats a pixel
    unsigned samples;
    Camera camera;
};

// Data of a hit record of the OptiX 7 program.
struct HitData {
    const float* vertices; // of meshes
    const unsigned* indices;
    const float* spheres; // centre and radius
    float albedo[3];
};

} // namespace twin
