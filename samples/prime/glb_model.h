// SPDX-License-Identifier: Apache-2.0
// The triangles of a binary glTF file, in world space.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

struct Vec {
    float x, y, z;
};
inline Vec operator+(Vec a, Vec b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator-(Vec a, Vec b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec operator*(float s, Vec a) {
    return {s * a.x, s * a.y, s * a.z};
}
float dot(Vec a, Vec b);
Vec cross(Vec a, Vec b);
Vec normalize(Vec a); // zero stays zero

struct Triangle {
    int32_t a, b, c;
};

struct GlbModel {
    std::vector<Vec> vertices, normals;
    std::vector<Triangle> triangles;
    Vec lower, upper;
};

// Throws std::runtime_error with the cause.
GlbModel readGlb(const std::string& path);
