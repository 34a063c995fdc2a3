// SPDX-License-Identifier: Apache-2.0
#include "scene.h"

#include "sampling.h"

#include <algorithm>
#include <cmath>

namespace bench {

float randomOf(unsigned number, unsigned stream) {
    return float(hashPcg(number * 16 + stream) >> 8) * 0x1p-24f;
}

float3 colorOf(unsigned number) {
    return vec(0.3f + 0.6f * randomOf(number, 1), 0.3f + 0.6f * randomOf(number, 2),
               0.3f + 0.6f * randomOf(number, 3));
}

namespace {

void addQuad(MaterialMesh& mesh, float3 corner, float3 u, float3 v, unsigned material) {
    const auto first = uint32_t(mesh.vertices.size() / 3);
    for (const float3 p : {corner, corner + u, corner + u + v, corner + v})
        mesh.vertices.insert(mesh.vertices.end(), {p.x, p.y, p.z});
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u})
        mesh.indices.push_back(first + i);
    mesh.materials.insert(mesh.materials.end(), {uint8_t(material), uint8_t(material)});
}

void addRock(MaterialMesh& mesh, const Mesh& rock, float3 at, float radius, unsigned material) {
    const auto first = uint32_t(mesh.vertices.size() / 3);
    for (size_t i = 0; i < rock.vertices.size(); i += 3)
        mesh.vertices.insert(mesh.vertices.end(), {at.x + radius * rock.vertices[i],
                                                   at.y + radius * rock.vertices[i + 1],
                                                   at.z + radius * rock.vertices[i + 2]});
    for (const uint32_t i : rock.indices)
        mesh.indices.push_back(first + i);
    mesh.materials.insert(mesh.materials.end(), rock.numTriangles(), uint8_t(material));
}

std::vector<Look> looksOf(unsigned colors, bool isMirror) {
    std::vector<Look> looks;
    const auto add = [&](Surface surface, float3 color, float roughness) {
        Look m = {};
        m.surface = surface;
        m.color = color;
        m.roughness = roughness;
        looks.push_back(m);
    };
    for (unsigned i = 0; i < colors; ++i) {
        add(kMatt, colorOf(i), 0.5f);
        looks.back().callable = i;
    }
    if (colors == 0) {
        add(isMirror ? kMirror : kMatt, vec(isMirror ? 0.9f : 0.75f), 0);
        add(kMatt, vec(0.75f, 0.25f, 0.2f), 0);
        add(kMatt, vec(0.25f, 0.7f, 0.3f), 0);
        add(kMirror, vec(0.9f, 0.85f, 0.7f), 0);
        add(kGlass, vec(0.97f), 0);
        add(kGlossy, vec(0.8f, 0.6f, 0.4f), 0.3f);
        add(kMatt, vec(0.3f, 0.4f, 0.8f), 0);
    }
    add(kLamp, vec(0.0f), 0);
    return looks;
}

// The room is a cube of side 2 around the origin; the lamp hangs under the middle of its ceiling.
constexpr float kLampSize = 0.7f, kLampHeight = 0.98f;

} // namespace

MaterialMesh makeRoom(unsigned triangles, unsigned colors, bool isMirror) {
    constexpr int kAcross = 5, kUp = 3;
    MaterialMesh mesh;
    mesh.looks = looksOf(colors, isMirror);
    const auto lamp = unsigned(mesh.looks.size() - 1);
    const auto wall = [&](unsigned i) { return colors ? i % colors : i % 3; };
    addQuad(mesh, vec(-1, -1, -1), vec(0, 0, 2), vec(2, 0, 0), wall(0));
    addQuad(mesh, vec(-1, 1, -1), vec(2, 0, 0), vec(0, 0, 2), wall(0));
    addQuad(mesh, vec(-1, -1, 1), vec(2, 0, 0), vec(0, 2, 0), wall(3));
    addQuad(mesh, vec(-1, -1, -1), vec(0, 2, 0), vec(0, 0, 2), wall(1));
    addQuad(mesh, vec(1, -1, -1), vec(0, 0, 2), vec(0, 2, 0), wall(2));
    addQuad(mesh, vec(-1, -1, -1), vec(2, 0, 0), vec(0, 2, 0), wall(3));
    addQuad(mesh, vec(-kLampSize / 2, kLampHeight, -kLampSize / 2), vec(kLampSize, 0, 0),
            vec(0, 0, kLampSize), lamp);
    const Mesh rock = makeRock(std::max(40u, triangles / (kAcross * kAcross * kUp)));
    unsigned number = 0;
    for (int y = 0; y < kUp; ++y)
        for (int z = 0; z < kAcross; ++z)
            for (int x = 0; x < kAcross; ++x, ++number)
                addRock(mesh, rock,
                        vec(-0.76f + 0.38f * float(x), -0.86f + 0.5f * float(y),
                            -0.4f + 0.3f * float(z)),
                        0.07f + 0.05f * randomOf(number, 0), number % lamp);
    return mesh;
}

void lightRoom(Job& job, const JobSettings& settings) {
    ProgramParams& p = job.params;
    p.camera = makeCamera(vec(0.15f, 0.25f, -0.95f), vec(0, -0.25f, 0.4f), vec(0, 1, 0), 65,
                          settings.aspect());
    p.light[0] = vec(-kLampSize / 2, kLampHeight, -kLampSize / 2);
    p.light[1] = vec(kLampSize, 0, 0);
    p.light[2] = vec(0, 0, kLampSize);
    p.emission = vec(9.0f, 8.5f, 7.5f);
    p.epsilon = 1e-4f;
    p.reach = 0.3f;
}

void lightOutside(Job& job, const Mesh& mesh, const JobSettings& settings) {
    ProgramParams& p = job.params;
    p.camera = makeCamera(vec(mesh.eye[0], mesh.eye[1], mesh.eye[2]),
                          vec(mesh.target[0], mesh.target[1], mesh.target[2]), vec(0, 1, 0),
                          mesh.fovDegrees, settings.aspect());
    p.light[0] = normalize(vec(-0.55f, 0.6f, -0.5f));
    p.emission = vec(1.6f, 1.45f, 1.2f);
    p.epsilon = 1e-3f * mesh.aoRadius;
    p.reach = mesh.aoRadius;
}

void addRoom(OptixDeviceContext context, Job& job, const MaterialMesh& mesh,
             unsigned recordsPerMaterial) {
    const float* const vertices = job.upload(mesh.vertices);
    const uint32_t* const indices = job.upload(mesh.indices);
    DeviceBuffer materials;
    materials.upload(mesh.materials);
    const std::vector<unsigned> flags(mesh.looks.size(), OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
    const auto address = reinterpret_cast<CUdeviceptr>(vertices);
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input.triangleArray;
    t.vertexBuffers = &address;
    t.numVertices = unsigned(mesh.vertices.size() / 3);
    t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    t.indexBuffer = reinterpret_cast<CUdeviceptr>(indices);
    t.numIndexTriplets = unsigned(mesh.indices.size() / 3);
    t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    t.flags = flags.data();
    t.numSbtRecords = unsigned(flags.size());
    t.sbtIndexOffsetBuffer = materials.address();
    t.sbtIndexOffsetSizeInBytes = sizeof(uint8_t);
    job.structures.push_back(buildAccel(context, input));
    job.params.scene = job.structures.back().handle;
    for (Look look : mesh.looks) {
        look.vertices = reinterpret_cast<const float3*>(vertices);
        look.triangles = reinterpret_cast<const uint3*>(indices);
        for (unsigned k = 0; k < recordsPerMaterial; ++k)
            job.records.push_back({k, look});
    }
}

Triangles uploadTriangles(Job& job, const Mesh& mesh, const std::vector<float>* later) {
    Triangles t = {};
    t.vertices[0] = reinterpret_cast<CUdeviceptr>(job.upload(mesh.vertices));
    if (later)
        t.vertices[1] = reinterpret_cast<CUdeviceptr>(job.upload(*later));
    t.vertexCount = mesh.numVertices();
    t.indices = job.upload(mesh.indices);
    t.triangleCount = mesh.numTriangles();
    return t;
}

OptixBuildInput inputOf(const Triangles& triangles, const unsigned& flags) {
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input.triangleArray;
    t.vertexBuffers = triangles.vertices;
    t.numVertices = triangles.vertexCount;
    t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    t.indexBuffer = reinterpret_cast<CUdeviceptr>(triangles.indices);
    t.numIndexTriplets = triangles.triangleCount;
    t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    t.flags = &flags;
    t.numSbtRecords = 1;
    return input;
}

Look materialOf(const Triangles& triangles, float3 color) {
    Look m = {};
    m.vertices = reinterpret_cast<const float3*>(triangles.vertices[0]);
    m.triangles = reinterpret_cast<const uint3*>(triangles.indices);
    m.color = color;
    return m;
}

OptixTraversableHandle addMesh(OptixDeviceContext context, Job& job, const Triangles& triangles,
                               unsigned flags) {
    OptixMotionOptions motion = {};
    if (triangles.vertices[1])
        motion = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};
    job.structures.push_back(buildAccel(context, inputOf(triangles, flags), motion));
    return job.structures.back().handle;
}

OptixTraversableHandle addItems(OptixDeviceContext context, Job& job, std::span<const Item> items,
                                unsigned flags) {
    std::vector<OptixAabb> boxes;
    for (const Item& i : items) {
        const float r = i.radius * 1.0001f;
        boxes.push_back({i.at.x - r, i.at.y - r, i.at.z - r, i.at.x + r, i.at.y + r, i.at.z + r});
    }
    DeviceBuffer memory;
    memory.upload(boxes);
    const CUdeviceptr address = memory.address();
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input.customPrimitiveArray.aabbBuffers = &address;
    input.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
    input.customPrimitiveArray.flags = &flags;
    input.customPrimitiveArray.numSbtRecords = 1;
    job.structures.push_back(buildAccel(context, input));
    return job.structures.back().handle;
}

} // namespace bench
