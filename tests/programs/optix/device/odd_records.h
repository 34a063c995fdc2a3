// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Params {
    unsigned* seen; // two words for each ray
    OptixTraversableHandle scene;
    unsigned rows;
};
struct RaygenData {
    float height;
    unsigned rayTypes;
    unsigned char padding[7];
    unsigned char tag;
};
struct Colour { // behind a pointer in the record
    unsigned words[3];
};
struct HitData {
    const Colour* colour;
    unsigned short id;
    unsigned char type;
    char name[21];
};
struct MissData {
    unsigned long long code;
};
