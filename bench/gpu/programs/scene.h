// SPDX-License-Identifier: Apache-2.0
// Scenes of bench_programs: meshes with materials, and their structures in a job.
#pragma once

#include "job.h"

#include "../../scenes.h"

#include <span>

namespace bench {

// A mesh whose triangles have materials; the look of a record follows from its number.
struct MaterialMesh {
    std::vector<float> vertices;
    std::vector<uint32_t> indices;
    std::vector<uint8_t> materials;
    std::vector<Look> looks; // without addresses
};

// A closed room with a lamp under its ceiling and 75 rocks of the materials. `colors`: the number
// of colours of rocks and walls; 0: matt walls, and matt, mirror, glass and glossy rocks.
// `isMirror`: mirror walls.
MaterialMesh makeRoom(unsigned triangles, unsigned colors, bool isMirror = false);

// Lamp, camera and offsets for the room.
void lightRoom(Job& job, const JobSettings& settings);
// Sun, sky and the camera of a generated mesh.
void lightOutside(Job& job, const Mesh& mesh, const JobSettings& settings);

// Uploads a mesh, builds its structure, stores the handle in the job's launch parameters, and adds
// `recordsPerMaterial` records for each material, in the order of hit groups.
void addRoom(OptixDeviceContext context, Job& job, const MaterialMesh& mesh,
             unsigned recordsPerMaterial);

struct Triangles {
    CUdeviceptr vertices[2]; // the second at the last motion key, or 0
    unsigned vertexCount;
    const uint32_t* indices;
    unsigned triangleCount;
};
Triangles uploadTriangles(Job& job, const Mesh& mesh, const std::vector<float>* later = nullptr);
// A build input that refers to the triangles; `flags` is one record's.
OptixBuildInput inputOf(const Triangles& triangles, const unsigned& flags);
Look materialOf(const Triangles& triangles, float3 color);
// A structure of triangles with one record.
OptixTraversableHandle addMesh(OptixDeviceContext context, Job& job, const Triangles& triangles,
                               unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
// Boxes around items.
OptixTraversableHandle addItems(OptixDeviceContext context, Job& job, std::span<const Item> items,
                                unsigned flags);

// Instances of a rock under motion transforms; `keys`: of the structure of instances. Sets light,
// camera and picture.
void addMovingRocks(OptixDeviceContext context, Job& job, const JobSettings& settings,
                    unsigned count, const OptixMotionOptions& keys);

float3 colorOf(unsigned number);
// A number in [0, 1) for a place in a stream.
float randomOf(unsigned number, unsigned stream);

} // namespace bench
