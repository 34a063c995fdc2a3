// SPDX-License-Identifier: Apache-2.0
// Launch parameters of particles.cu.
#pragma once

#include "camera.h"
#include "mesh.h"

#include <optix.h>

struct Particle {
    float3 position, velocity;
    unsigned random;
    int state; // 0: moves, 1: sticks to a wall, 2: has left
};

struct ParticleParams {
    float4* image;
    unsigned* density;  // particles in a pixel, all steps
    unsigned* deposits; // on triangles of walls
    Particle* particles;
    unsigned width, height, count, steps, depositCount;
    float timeStep;
    OptixTraversableHandle walls;
    MeshView mesh;
    cudaTextureObject_t field;
    Camera camera;
};
