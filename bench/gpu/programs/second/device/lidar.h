// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of lidar.cu.
#pragma once

#include "vec.h"

#include <optix.h>

struct Echo {
    float3 point;
    float intensity;
    unsigned beam;
    unsigned object;
    unsigned number; // of the beam's echoes
    unsigned reserved;
};

struct LidarParams {
    OptixTraversableHandle world;
    Echo* echoes;
    unsigned* numEchoes;
    unsigned maxEchoes;
    float4* beams; // range of the first echo, sum of intensities, number of echoes
    float4* map;   // echoes from above: count, intensity, height
    unsigned mapSide;
    float mapReach;
    float3 scanner;
    unsigned numChannels, numColumns;
    float angle; // of the first column
    bool isVerbose;
};

struct LidarMaterial {
    float reflectivity;
    float passes; // share of the pulse that goes on behind the hit
    unsigned object;
};

struct LidarMiss {
    float limit;
};
