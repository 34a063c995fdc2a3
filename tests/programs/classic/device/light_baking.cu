// SPDX-License-Identifier: Apache-2.0
#include <optix_world.h>

#include "light_baking.h"

using namespace optix;

rtDeclareVariable(unsigned, launch_index, rtLaunchIndex, );
rtDeclareVariable(unsigned, launch_dim, rtLaunchDim, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(rtObject, blockers, , );
rtDeclareVariable(unsigned, first, , "of the batch");
rtDeclareVariable(unsigned, rays, , );
rtDeclareVariable(float, far_away, , );
rtBuffer<BakePoint> points;
rtBuffer<BakeBall> balls;
rtBuffer<float> means;

struct Blocked {
    int hits;
};
rtDeclareVariable(Blocked, blocked, rtPayload, );

// Bits in the opposite order, as a number from 0 to 1.
static __device__ float reversed(unsigned bits) {
    bits = __brev(bits);
    return (bits >> 8) * (1.0f / 16777216.0f);
}

RT_PROGRAM void bake() {
    BakePoint& point = points[first + launch_index];
    const Onb frame(point.normal);
    Blocked all;
    all.hits = 0;
    for (unsigned i = 0; i < rays; ++i) {
        float3 way;
        cosine_sample_hemisphere((i + 0.5f) / rays, reversed(i), way);
        frame.inverse_transform(way);
        rtTrace(blockers, make_Ray(point.position, way, 0, 1e-3f, far_away), all, RT_VISIBILITY_ALL,
                RT_RAY_FLAG_TERMINATE_ON_FIRST_HIT);
    }
    point.hits = all.hits;
    point.open = 1.0f - float(all.hits) / rays;
}

RT_PROGRAM void count_hit() {
    blocked.hits++;
    rtTerminateRay();
}

RT_PROGRAM void mean() {
    float sum = 0.0f;
    for (unsigned i = 0; i < points.size(); ++i)
        sum += points[i].open;
    means[0] = sum / points.size();
}

RT_PROGRAM void ball_intersect(int index) {
    const BakeBall ball = balls[index];
    const float3 from = ray.origin - ball.center;
    const float b = dot(from, ray.direction), c = dot(from, from) - ball.radius * ball.radius;
    const float root = b * b - c;
    if (root > 0.0f && rtPotentialIntersection(-b - sqrtf(root)))
        rtReportIntersection(0);
}
RT_PROGRAM void ball_bounds(int index, float result[6]) {
    Aabb& box = *(Aabb*)result;
    box.set(balls[index].center - balls[index].radius, balls[index].center + balls[index].radius);
}
