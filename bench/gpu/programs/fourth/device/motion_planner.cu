// SPDX-License-Identifier: Apache-2.0
// Configurations of a robot's arm against a workshop: a ray along each edge of a link counts
// contacts with hard obstacles and ends at the fourth; short rays around the hand find the
// clearance. Payload: contacts or distance.
#include "motion_planner.h"
#include "tools.h"

extern "C" {
__constant__ PlannerParams params;
}

constexpr unsigned kManyContacts = 4, kEdges = 6, kFeelers = 14;

extern "C" __global__ void __anyhit__contact() {
    if (reinterpret_cast<const ObstacleRecord*>(optixGetSbtDataPointer())->isSoft) {
        optixIgnoreIntersection();
        return;
    }
    const unsigned contacts = optixGetPayload_0() + 1;
    optixSetPayload_0(contacts);
    if (contacts >= kManyContacts)
        optixTerminateRay();
    else
        optixIgnoreIntersection();
}
extern "C" __global__ void __closesthit__distance() {
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
}

DEVICE unsigned countContacts(float3 from, float3 to) {
    const float3 line = to - from;
    const float distance = length(line);
    unsigned contacts = 0;
    optixTrace(params.workshop, from, line / distance, 0.0f, distance, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 0, 2, 0, contacts);
    return contacts;
}
DEVICE float findClearance(float3 hand) {
    float nearest = params.reach;
    for (unsigned i = 0; i < kFeelers; ++i) {
        const float y = 1.0f - 2.0f * (i + 0.5f) / kFeelers, level = sqrtf(1.0f - y * y);
        const float turns = 0.381966f * i;
        const float2 c = circlePoint(turns - floorf(turns));
        unsigned distance = __float_as_uint(nearest);
        optixTrace(params.workshop, hand, vec(level * c.x, y, level * c.y), 0.0f, nearest, 0.0f,
                   OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 1, 2, 0, distance);
        nearest = __uint_as_float(distance);
    }
    return nearest;
}

// A position with axes.
struct Frame {
    float3 at, x, y, z;

    __forceinline__ __device__ void turn(float turns, bool isAroundY) {
        const float2 c = circlePoint(turns - floorf(turns));
        const float3 other = isAroundY ? z : y;
        const float3 first = x * c.x + other * c.y, second = other * c.x - x * c.y;
        x = first;
        (isAroundY ? z : y) = second;
    }
    __forceinline__ __device__ float3 corner(unsigned i, float width, float along) const {
        return at + x * along + y * (i & 1 ? width : -width) + z * (i & 2 ? width : -width);
    }
};

// The four edges of a link and two diagonals.
DEVICE unsigned countLinkContacts(const Frame& frame, const ArmLink& link) {
    unsigned contacts = 0;
    for (unsigned i = 0; i < kEdges; ++i) {
        const unsigned end = i < 4 ? i : 3 - (i - 4);
        contacts += countContacts(frame.corner(i % 4, link.width, 0.0f),
                                  frame.corner(end, link.width, link.length));
    }
    return contacts;
}

extern "C" __global__ void __raygen__configurations() {
    const unsigned i = optixGetLaunchIndex().x;
    const float first = (i % params.across + 0.5f) / params.across;
    const float second = static_cast<float>(i / params.across) / params.across;
    const float2 c = circlePoint(first);
    Frame frame = {params.base, vec(0.0f, 1.0f, 0.0f), vec(c.x, 0.0f, c.y), vec(c.y, 0.0f, -c.x)};
    ArmResult result = {kJoints, 0, 0.0f};
    for (unsigned joint = 0; joint < kJoints && result.firstLink == kJoints; ++joint) {
        const float varied = joint == 1 ? 0.4f * second - 0.2f : joint == 3 ? 0.25f * second : 0.0f;
        frame.turn(params.angles[joint] + varied, joint % 2 == 0);
        const ArmLink link = params.links[joint];
        result.contacts += countLinkContacts(frame, link);
        if (result.contacts > 0)
            result.firstLink = joint;
        frame.at += frame.x * link.length;
    }
    if (result.firstLink == kJoints)
        result.clearance = findClearance(frame.at);
    params.results[i] = result;
}

extern "C" __global__ void __raygen__map() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned x = index.x * params.across / params.width,
                   y = index.y * params.across / params.height;
    const ArmResult r = params.results[y * params.across + x];
    const float free = r.clearance / params.reach;
    const float2 hue = circlePoint(static_cast<float>(r.firstLink) / kJoints * 0.9f);
    const float3 hit = vec(0.55f + 0.4f * hue.x, 0.45f + 0.4f * hue.y, 0.5f - 0.4f * hue.x) /
                       (1.0f + 0.1f * r.contacts);
    params.image[index.y * params.width + index.x] = withWeight(
        r.firstLink == kJoints ? vec(0.35f + 0.6f * free) : hit, static_cast<float>(r.contacts));
}
