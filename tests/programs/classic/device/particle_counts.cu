// SPDX-License-Identifier: Apache-2.0
#include <optix_world.h>

using namespace optix;

struct Particle {
    double energy;
    unsigned crossed;
};
struct Probe {
    double distance;
};

rtDeclareVariable(unsigned, launch_index, rtLaunchIndex, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(Particle, particle, rtPayload, );
rtDeclareVariable(Probe, probe, rtPayload, );
rtDeclareVariable(int, slab, attribute slab, );
rtDeclareVariable(rtObject, slabs, , );
rtDeclareVariable(unsigned, bad_every, , );
rtDeclareVariable(float, absorption, , );
rtBuffer<double, 1> sums; // of each slab; of what is left; of lost particles
rtBuffer<double, 1> totals;
rtBuffer<double, 1> distances;

RT_PROGRAM void fly() {
    Particle p;
    p.energy = 1.0 + double(launch_index % 1000) * 0.001;
    p.crossed = 0;
    // A particle with a direction that is no number, which is an invalid ray.
    const bool bad = launch_index % bad_every == bad_every - 1;
    const float3 way = make_float3(0.0f, 0.0f, bad ? __int_as_float(0x7fc00000) : 1.0f);
    const float3 from = make_float3(float(launch_index % 100), float(launch_index / 100), -1.0f);
    rtTrace(slabs, make_Ray(from, way, 0, 0.0f, RT_DEFAULT_MAX), p);
    Probe back;
    back.distance = 0.0;
    rtTrace(slabs, make_Ray(from, make_float3(0, 0, 1), 1, 0.0f, RT_DEFAULT_MAX), back);
    distances[launch_index] = back.distance;
    if (p.crossed != 5 || distances[launch_index] != 1.0)
        rtThrow(RT_EXCEPTION_USER);
    atomicAdd(&sums[5], p.energy);
}

RT_PROGRAM void lost() {
    const unsigned code = rtGetExceptionCode();
    rtPrintf("lost particle %u: code 0x%X\n", launch_index, code);
    if (code == RT_EXCEPTION_INVALID_RAY)
        atomicAdd(&sums[6], 1.0);
}

RT_PROGRAM void report() {
    totals[launch_index] = sums[launch_index];
}

// Each slab is crossed once, in any order; what a slab takes depends on how many are before it.
RT_PROGRAM void cross_slab() {
    double before = particle.energy;
    for (int i = 0; i < slab; ++i)
        before *= 1.0 - double(absorption);
    atomicAdd(&sums[slab], before * double(absorption));
    particle.crossed++;
    if (particle.crossed == 5)
        for (int i = 0; i < 5; ++i)
            particle.energy *= 1.0 - double(absorption);
    rtIgnoreIntersection();
}

RT_PROGRAM void first_slab() {
    probe.distance = double(t_hit);
}
RT_PROGRAM void no_slab() {
    probe.distance = -1.0;
}

// Planes z = 0, 1, 2 and so on.
RT_PROGRAM void slab_intersect(int primitive) {
    const float t = (float(primitive) - ray.origin.z) / ray.direction.z;
    if (rtPotentialIntersection(t)) {
        slab = primitive;
        rtReportIntersection(0);
    }
}
RT_PROGRAM void slab_bounds(int primitive, float result[6]) {
    result[0] = result[1] = -1.0f;
    result[3] = result[4] = 300.0f;
    result[2] = result[5] = float(primitive);
}
