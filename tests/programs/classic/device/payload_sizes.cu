// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optix_math.h>

#include "payload_sizes.h"

using namespace optix;

rtBuffer<int> result;
rtDeclareVariable(rtObject, scene, , );
rtDeclareVariable(unsigned int, place, rtLaunchIndex, );

// The program of each size, as the closest-hit and any-hit programs of a ray type of its own.
#define PROGRAMS(size)                                                                             \
    rtDeclareVariable(Bytes<size>, payload##size, rtPayload, );                                    \
    RT_PROGRAM void closest##size() {                                                              \
        shuffle(payload##size);                                                                    \
    }                                                                                              \
    RT_PROGRAM void any##size() {                                                                  \
        payload##size.bytes[size - 1] += 5;                                                        \
    }
SIZES(PROGRAMS)

static __device__ Ray down(unsigned int type) {
    return Ray(make_float3(0.2f, 0.2f, 1.0f), make_float3(0, 0, -1), type, 0.0f);
}

template <int size>
static __device__ int shoot(unsigned int type, int seed) {
    Bytes<size> bytes;
    fill(bytes, seed);
    rtTrace(scene, down(type), bytes);
    return sum(bytes);
}

RT_PROGRAM void all_sizes() {
    const int seed = int(place);
    int total = 0;
    unsigned int type = 0;
#define SHOOT(size) total = total * 17 + shoot<size>(type++, seed + size);
    SIZES(SHOOT)
    result[place] = total;
}

// Rays that trace rays, to a depth that the payload has or without an end.
struct Depth {
    int depth, last;
    float ballast[8];
};
rtDeclareVariable(Depth, depth, rtPayload, );
rtDeclareVariable(int, endless, , ); // every endless-th launch index has no last depth; 0: none

RT_PROGRAM void deeper() {
    Depth next = depth;
    ++next.depth;
    if (next.depth < next.last)
        rtTrace(scene, down(kDepthType), next);
    depth.depth = next.ballast[3] == depth.ballast[3] ? next.depth : -1;
}

RT_PROGRAM void recursion() {
    Depth first;
    first.depth = 0;
    first.last = endless && place % endless == 0 ? 1 << 30 : 1 + place % 20;
    for (int i = 0; i < 8; ++i)
        first.ballast[i] = float(place);
    rtTrace(scene, down(kDepthType), first);
    result[place] = first.depth;
}

RT_PROGRAM void report() {
    result[place] = -int(rtGetExceptionCode());
}
