// SPDX-License-Identifier: Apache-2.0
// What the host and the device code of material_library share.
#pragma once

// A record of 44 bytes: its size is no power of two, and its members need no more than 4.
struct Light {
    float direction[3];
    float color[3];
    int falloff[2]; // ids of callable programs, added up
    int curve;      // id of a buffer of floats
    unsigned count; // of the curve's elements
    float weight;
};

struct Swatch {
    unsigned char rgba[4];
    short gloss;
    unsigned char flags[3];
};
