// SPDX-License-Identifier: Apache-2.0
// Random traversable graphs in which every part may move, and the positions of their triangles at a
// time, in double precision and by the manual.
#pragma once

#include "scene.h"

#include <memory>

namespace tests::api {

struct Motion {
    unsigned short keys = 1; // 1: none
    unsigned short flags = 0;
    float begin = 0, end = 1;

    OptixMotionOptions options() const { return {keys, flags, begin, end}; }
    // Key and fraction; false if vanished.
    bool place(double time, unsigned& key, double& fraction) const;
};

// A structure built with motion options; otherwise as buildAccel in scene.h.
Accel buildMoving(OptixDeviceContext context, const LogRecord& log,
                  const std::vector<OptixBuildInput>& inputs, const Motion& motion,
                  unsigned flags = 0, const std::vector<OptixAccelEmitDesc>& emit = {});

struct Matrix64 {
    double m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    Matrix64 operator*(const Matrix64& other) const;
    void apply(const double p[3], double out[3]) const;
};

struct WorldTriangle {
    double v[3][3];
    unsigned primitive, instanceId;
};

// A node of a graph, with the library's data and the reference's data.
class MovingNode {
public:
    virtual ~MovingNode() = default;
    // Adds the triangles at that time.
    virtual void collect(double time, const Matrix64& toWorld, unsigned instanceId,
                         std::vector<WorldTriangle>& out) const = 0;
    OptixTraversableHandle handle = 0;
};
using NodePointer = std::shared_ptr<MovingNode>;

struct SceneLimits {
    unsigned triangles = 40;
    unsigned instances = 6;
    unsigned depth = 4;
    bool vanish = true;
    unsigned buildFlags = 0;
};

class SceneMaker {
public:
    SceneMaker(OptixDeviceContext context, const LogRecord& log, uint32_t seed)
        : context_(context), log_(log), random_(seed) {}

    // A graph of random nodes, at most limits.depth of them on a path.
    NodePointer make(const SceneLimits& limits) { return node(limits, limits.depth); }

    NodePointer gas(const SceneLimits& limits);
    NodePointer matrixMotion(const SceneLimits& limits, NodePointer child);
    NodePointer srtMotion(const SceneLimits& limits, NodePointer child);
    NodePointer fixed(NodePointer child);
    NodePointer instances(const SceneLimits& limits, std::vector<NodePointer> children);

    float number(float low, float high);
    unsigned below(unsigned n);
    Motion motion(const SceneLimits& limits, unsigned leastKeys);

private:
    NodePointer node(const SceneLimits& limits, unsigned depth);

    OptixDeviceContext context_;
    const LogRecord& log_;
    std::mt19937 random_;
};

// The nearest triangle that a ray meets; t is infinite if there is none. `doubtful`: rounding may
// decide otherwise.
struct Nearest {
    double t;
    unsigned primitive, instanceId;
    bool doubtful;
};
Nearest nearestOf(const std::vector<WorldTriangle>& triangles, const float origin[3],
                  const float direction[3]);

} // namespace tests::api
