// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of motion_planner.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

constexpr unsigned kJoints = 6;

// Links turn in turn around the y axis of the link before and around its z axis.
struct ArmLink {
    float length, width;
};

// What a configuration of the arm meets.
struct ArmResult {
    unsigned firstLink; // that touches an obstacle; kJoints: none
    unsigned contacts;
    float clearance; // of the hand
};

struct PlannerParams {
    float4* image;
    ArmResult* results; // of configurations: joints vary along the sides of a square
    OptixTraversableHandle workshop;
    ArmLink links[kJoints];
    float angles[kJoints]; // in turns
    float3 base;
    unsigned across, width, height;
    float reach; // of the rays for the clearance
};

struct ObstacleRecord {
    unsigned isSoft; // curtains: the arm may touch them
};
