// SPDX-License-Identifier: Apache-2.0
#include "moving_scene.h"

#include "rig.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tests::api {
namespace {

double mix(double a, double b, double x) {
    return a * (1 - x) + b * x;
}

struct GasNode : MovingNode {
    Motion motion;
    std::vector<Buffer> keys;
    Buffer indices;
    std::vector<std::vector<Vec3>> points;
    std::vector<uint32_t> corners;
    Accel accel;

    void collect(double time, const Matrix64& toWorld, unsigned instanceId,
                 std::vector<WorldTriangle>& out) const override {
        unsigned key = 0;
        double x = 0;
        if (!motion.place(time, key, x))
            return;
        const std::vector<Vec3>& a = points[key];
        const std::vector<Vec3>& b = points[std::min<size_t>(key + 1, points.size() - 1)];
        for (size_t i = 0; i < corners.size() / 3; ++i) {
            WorldTriangle t{};
            for (int k = 0; k < 3; ++k) {
                const uint32_t c = corners[3 * i + size_t(k)];
                const double p[3] = {mix(a[c].x, b[c].x, x), mix(a[c].y, b[c].y, x),
                                     mix(a[c].z, b[c].z, x)};
                toWorld.apply(p, t.v[k]);
            }
            t.primitive = unsigned(i);
            t.instanceId = instanceId;
            out.push_back(t);
        }
    }
};

// T * R * S of the reference.
Matrix64 srtMatrix(const double v[16]) {
    Matrix64 s;
    const double scale[12] = {v[0], v[1], v[2], v[3], 0, v[4], v[5], v[6], 0, 0, v[7], v[8]};
    std::copy(scale, scale + 12, s.m);
    const double n = std::sqrt(v[9] * v[9] + v[10] * v[10] + v[11] * v[11] + v[12] * v[12]);
    const double x = v[9] / n, y = v[10] / n, z = v[11] / n, w = v[12] / n;
    Matrix64 r;
    const double rotation[12] = {
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),     v[13],
        2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),     v[14],
        2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y), v[15]};
    std::copy(rotation, rotation + 12, r.m);
    return r * s;
}

struct TransformNode : MovingNode {
    Motion motion;
    Buffer memory;
    std::vector<std::vector<float>> keys; // 12 or 16 numbers each
    NodePointer child;

    void collect(double time, const Matrix64& toWorld, unsigned instanceId,
                 std::vector<WorldTriangle>& out) const override {
        unsigned key = 0;
        double x = 0;
        if (!motion.place(time, key, x))
            return;
        const std::vector<float>& a = keys[key];
        const std::vector<float>& b = keys[std::min<size_t>(key + 1, keys.size() - 1)];
        double v[16];
        for (size_t i = 0; i < a.size(); ++i)
            v[i] = mix(a[i], b[i], x);
        Matrix64 own;
        if (a.size() == 16)
            own = srtMatrix(v);
        else
            std::copy(v, v + 12, own.m);
        child->collect(time, toWorld * own, instanceId, out);
    }
};

struct InstancesNode : MovingNode {
    Motion motion;
    std::unique_ptr<InstanceList> list;
    std::vector<OptixInstance> instances;
    std::vector<NodePointer> children;
    Accel accel;

    void collect(double time, const Matrix64& toWorld, unsigned,
                 std::vector<WorldTriangle>& out) const override {
        unsigned key = 0;
        double x = 0;
        if (!motion.place(time, key, x))
            return;
        for (size_t i = 0; i < instances.size(); ++i) {
            Matrix64 own;
            std::copy(instances[i].transform, instances[i].transform + 12, own.m);
            children[i]->collect(time, toWorld * own, instances[i].instanceId, out);
        }
    }
};

} // namespace

bool Motion::place(double time, unsigned& key, double& fraction) const {
    key = 0;
    fraction = 0;
    if (keys <= 1)
        return true;
    if (((flags & OPTIX_MOTION_FLAG_START_VANISH) && time < begin) ||
        ((flags & OPTIX_MOTION_FLAG_END_VANISH) && time > end))
        return false;
    const double at = std::clamp((time - begin) / (double(end) - begin), 0.0, 1.0) * (keys - 1);
    key = std::min(unsigned(at), keys - 2u);
    fraction = at - key;
    return true;
}

Accel buildMoving(OptixDeviceContext context, const LogRecord& log,
                  const std::vector<OptixBuildInput>& inputs, const Motion& motion, unsigned flags,
                  const std::vector<OptixAccelEmitDesc>& emit) {
    OptixAccelBuildOptions options = buildOptions(flags);
    options.motionOptions = motion.options();
    return buildAccel(context, log, inputs, options, emit);
}

Matrix64 Matrix64::operator*(const Matrix64& other) const {
    Matrix64 r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) {
            r.m[4 * i + j] = j == 3 ? m[4 * i + 3] : 0;
            for (int k = 0; k < 3; ++k)
                r.m[4 * i + j] += m[4 * i + k] * other.m[4 * k + j];
        }
    return r;
}

void Matrix64::apply(const double p[3], double out[3]) const {
    for (int i = 0; i < 3; ++i)
        out[i] = m[4 * i] * p[0] + m[4 * i + 1] * p[1] + m[4 * i + 2] * p[2] + m[4 * i + 3];
}

float SceneMaker::number(float low, float high) {
    return low + (high - low) * float(random_() >> 8) * 0x1p-24f;
}

unsigned SceneMaker::below(unsigned n) {
    return unsigned(uint64_t(random_()) * n >> 32);
}

Motion SceneMaker::motion(const SceneLimits& limits, unsigned leastKeys) {
    Motion m;
    m.keys = (unsigned short)(leastKeys + below(4));
    m.flags = limits.vanish && below(4) == 0 ? (unsigned short)(below(4)) : (unsigned short)(0);
    if (below(2)) {
        m.begin = number(-1, 0.6f);
        m.end = m.begin + number(0.1f, 1.2f);
    }
    return m;
}

NodePointer SceneMaker::gas(const SceneLimits& limits) {
    auto node = std::make_shared<GasNode>();
    node->motion = motion(limits, 1);
    const unsigned count = 1 + below(limits.triangles);
    for (unsigned i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k)
            node->corners.push_back(below(3 * count));
    for (unsigned k = 0; k < node->motion.keys; ++k) {
        std::vector<Vec3> points(3 * count);
        for (size_t i = 0; i < points.size(); ++i)
            points[i] = k == 0 ? Vec3{number(-1, 1), number(-1, 1), number(-1, 1)}
                               : Vec3{node->points.back()[i].x + number(-0.5f, 0.5f),
                                      node->points.back()[i].y + number(-0.5f, 0.5f),
                                      node->points.back()[i].z + number(-0.5f, 0.5f)};
        node->points.push_back(points);
        node->keys.emplace_back(points);
    }
    node->indices = Buffer(node->corners);
    std::vector<CUdeviceptr> addresses;
    for (const Buffer& key : node->keys)
        addresses.push_back(key.address());
    const unsigned flags[1] = {0};
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    input.triangleArray.vertexBuffers = addresses.data();
    input.triangleArray.numVertices = 3 * count;
    input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    input.triangleArray.indexBuffer = node->indices.address();
    input.triangleArray.numIndexTriplets = count;
    input.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    input.triangleArray.flags = flags;
    input.triangleArray.numSbtRecords = 1;
    node->accel = buildMoving(context_, log_, {input}, node->motion, limits.buildFlags);
    node->handle = node->accel.handle;
    return node;
}

static OptixTraversableHandle convert(OptixDeviceContext context, const LogRecord& log,
                                      const Buffer& memory, OptixTraversableType type) {
    OptixTraversableHandle handle = 0;
    require(optixConvertPointerToTraversableHandle(context, memory.address(), type, &handle),
            "optixConvertPointerToTraversableHandle", log);
    return handle;
}

NodePointer SceneMaker::matrixMotion(const SceneLimits& limits, NodePointer child) {
    auto node = std::make_shared<TransformNode>();
    node->motion = motion(limits, 2);
    const unsigned keys = node->motion.keys;
    node->memory = Buffer(sizeof(OptixMatrixMotionTransform) + (keys - 2) * 12 * sizeof(float), 64);
    auto* transform = node->memory.as<OptixMatrixMotionTransform>();
    transform->child = child->handle;
    transform->motionOptions = node->motion.options();
    for (unsigned k = 0; k < keys; ++k) {
        std::vector<float> m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        for (size_t i = 0; i < 12; ++i)
            m[i] += i % 4 == 3 ? number(-1, 1) : number(-0.25f, 0.25f);
        std::copy(m.begin(), m.end(), reinterpret_cast<float*>(node->memory.as<char>() +
                                            offsetof(OptixMatrixMotionTransform, transform)) +
                      12 * k);
        node->keys.push_back(m);
    }
    node->child = std::move(child);
    node->handle =
        convert(context_, log_, node->memory, OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM);
    return node;
}

NodePointer SceneMaker::srtMotion(const SceneLimits& limits, NodePointer child) {
    auto node = std::make_shared<TransformNode>();
    node->motion = motion(limits, 2);
    const unsigned keys = node->motion.keys;
    node->memory = Buffer(sizeof(OptixSRTMotionTransform) + (keys - 2) * sizeof(OptixSRTData), 64);
    auto* transform = node->memory.as<OptixSRTMotionTransform>();
    transform->child = child->handle;
    transform->motionOptions = node->motion.options();
    // Turns of up to nearly half a circle between keys.
    float axis[3] = {number(-1, 1), number(-1, 1), number(0.2f, 1)};
    const float length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    float angle = number(-3, 3);
    for (unsigned k = 0; k < keys; ++k) {
        OptixSRTData key{};
        key.sx = number(0.6f, 1.4f);
        key.sy = number(0.6f, 1.4f);
        key.sz = number(0.6f, 1.4f);
        key.a = number(-0.2f, 0.2f);
        key.b = number(-0.2f, 0.2f);
        key.c = number(-0.2f, 0.2f);
        key.pvx = number(-0.5f, 0.5f);
        key.pvy = number(-0.5f, 0.5f);
        key.pvz = number(-0.5f, 0.5f);
        const float s = std::sin(angle / 2) / length, size = number(0.5f, 2);
        key.qx = s * axis[0] * size;
        key.qy = s * axis[1] * size;
        key.qz = s * axis[2] * size;
        key.qw = std::cos(angle / 2) * size;
        key.tx = number(-1, 1);
        key.ty = number(-1, 1);
        key.tz = number(-1, 1);
        angle += number(-2.6f, 2.6f);
        std::memcpy(node->memory.as<char>() + offsetof(OptixSRTMotionTransform, srtData) +
                        k * sizeof(key),
                    &key, sizeof(key));
        std::vector<float> numbers(16);
        std::memcpy(numbers.data(), &key, sizeof(key));
        node->keys.push_back(numbers);
    }
    node->child = std::move(child);
    node->handle =
        convert(context_, log_, node->memory, OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM);
    return node;
}

NodePointer SceneMaker::fixed(NodePointer child) {
    auto node = std::make_shared<TransformNode>();
    node->memory = Buffer(sizeof(OptixStaticTransform), 64);
    auto* transform = node->memory.as<OptixStaticTransform>();
    transform->child = child->handle;
    const Matrix m = randomAffine(random_, 1.0f), inverted = inverse(m);
    std::copy(m.begin(), m.end(), transform->transform);
    std::copy(inverted.begin(), inverted.end(), transform->invTransform);
    node->keys = {{m.begin(), m.end()}};
    node->child = std::move(child);
    node->handle = convert(context_, log_, node->memory, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM);
    return node;
}

NodePointer SceneMaker::instances(const SceneLimits& limits, std::vector<NodePointer> children) {
    auto node = std::make_shared<InstancesNode>();
    node->motion = motion(limits, 1);
    for (size_t i = 0; i < children.size(); ++i)
        node->instances.push_back(
            instanceOf(children[i]->handle, randomAffine(random_, 1.5f), below(1000)));
    node->children = std::move(children);
    node->list = std::make_unique<InstanceList>(node->instances);
    node->accel = buildMoving(context_, log_, {node->list->input}, node->motion, limits.buildFlags);
    node->handle = node->accel.handle;
    return node;
}

NodePointer SceneMaker::node(const SceneLimits& limits, unsigned depth) {
    if (depth <= 1)
        return gas(limits);
    switch (below(7)) {
    case 0:
        return fixed(node(limits, depth - 1));
    case 1:
    case 2:
        return matrixMotion(limits, node(limits, depth - 1));
    case 3:
    case 4:
        return srtMotion(limits, node(limits, depth - 1));
    default: {
        std::vector<NodePointer> children;
        const unsigned count = 1 + below(limits.instances);
        for (unsigned i = 0; i < count; ++i)
            children.push_back(i % 3 == 2 ? children.front() : node(limits, depth - 1));
        return instances(limits, std::move(children));
    }
    }
}

Nearest nearestOf(const std::vector<WorldTriangle>& triangles, const float origin[3],
                  const float direction[3]) {
    Nearest nearest{INFINITY, 0, 0, false};
    double second = INFINITY;
    for (const WorldTriangle& triangle : triangles) {
        double e1[3], e2[3], s[3];
        for (int i = 0; i < 3; ++i) {
            e1[i] = triangle.v[1][i] - triangle.v[0][i];
            e2[i] = triangle.v[2][i] - triangle.v[0][i];
            s[i] = origin[i] - triangle.v[0][i];
        }
        const auto cross = [](const auto* a, const auto* b, double* c) {
            c[0] = a[1] * b[2] - a[2] * b[1];
            c[1] = a[2] * b[0] - a[0] * b[2];
            c[2] = a[0] * b[1] - a[1] * b[0];
        };
        const auto dot = [](const auto* a, const auto* b) {
            return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        };
        double p[3], q[3], n[3];
        cross(direction, e2, p);
        cross(s, e1, q);
        cross(e1, e2, n);
        const double det = dot(e1, p);
        // For grazing rays, the rounding of vertices decides.
        const bool grazing = std::fabs(det) < 0.02 * std::sqrt(dot(n, n)) *
                                                  std::sqrt(double(dot(direction, direction)));
        if (det == 0)
            continue;
        const double u = dot(s, p) / det, v = dot(direction, q) / det, t = dot(e2, q) / det;
        const double margin = std::min({u, v, 1 - u - v});
        if (margin < -2e-3 && !grazing)
            continue;
        if (margin < -0.1)
            continue;
        if (std::fabs(t) < 1e-3 || (t > 0 && (grazing || std::fabs(margin) < 2e-3)))
            nearest.doubtful = true;
        if (t < 0 || margin < 0)
            continue;
        if (t < nearest.t) {
            second = nearest.t;
            nearest.t = t;
            nearest.primitive = triangle.primitive;
            nearest.instanceId = triangle.instanceId;
        } else {
            second = std::min(second, t);
        }
    }
    if (second - nearest.t < 1e-3 * nearest.t)
        nearest.doubtful = true;
    return nearest;
}

} // namespace tests::api
