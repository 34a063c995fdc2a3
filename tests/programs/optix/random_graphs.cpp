// SPDX-License-Identifier: Apache-2.0
// A test bench for scene graphs: random graphs of instances, static transforms, matrix and SRT
// motion in any order, above moving triangles and custom primitives. Rays of random times and masks
// are compared with a host that walks the same graph and tests every primitive in double precision.
#include "common.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>

#include "device/random_graphs.h"

namespace {

constexpr unsigned kGraphs = 40, kRays = 400, kRecords = 100;

struct Vector {
    double x, y, z;
};
Vector operator-(Vector a, Vector b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
double dot(Vector a, Vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vector cross(Vector a, Vector b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector vectorOf(float3 v) {
    return {v.x, v.y, v.z};
}
Vector mix(float3 a, float3 b, double f) {
    return {(1 - f) * a.x + f * b.x, (1 - f) * a.y + f * b.y, (1 - f) * a.z + f * b.z};
}

struct Matrix { // three rows of four
    double m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

    Vector row(int r) const { return {m[4 * r], m[4 * r + 1], m[4 * r + 2]}; }
    double determinant() const { return dot(row(0), cross(row(1), row(2))); }
    Vector direction(Vector v) const { return {dot(row(0), v), dot(row(1), v), dot(row(2), v)}; }
    Vector point(Vector p) const {
        const Vector v = direction(p);
        return {v.x + m[3], v.y + m[7], v.z + m[11]};
    }
    Vector transposed(Vector n) const {
        return {m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
                m[2] * n.x + m[6] * n.y + m[10] * n.z};
    }
    Matrix inverse() const {
        Matrix to;
        for (int c = 0; c < 3; ++c) {
            const Vector v = cross(row((c + 1) % 3), row((c + 2) % 3));
            to.m[c] = v.x / determinant();
            to.m[4 + c] = v.y / determinant();
            to.m[8 + c] = v.z / determinant();
        }
        const Vector back = to.direction({m[3], m[7], m[11]});
        to.m[3] = -back.x;
        to.m[7] = -back.y;
        to.m[11] = -back.z;
        return to;
    }
};
Matrix operator*(const Matrix& a, const Matrix& b) {
    Matrix to;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) {
            to.m[4 * r + c] = c == 3 ? a.m[4 * r + 3] : 0;
            for (int k = 0; k < 3; ++k)
                to.m[4 * r + c] += a.m[4 * r + k] * b.m[4 * k + c];
        }
    return to;
}
Matrix mix(const Matrix& a, const Matrix& b, double f) {
    Matrix to;
    for (int i = 0; i < 12; ++i)
        to.m[i] = (1 - f) * a.m[i] + f * b.m[i];
    return to;
}

Matrix mix(const OptixSRTData& a, const OptixSRTData& b, double f) {
    double v[16];
    for (int i = 0; i < 16; ++i)
        v[i] = (1 - f) * (&a.sx)[i] + f * (&b.sx)[i];
    const double length = std::sqrt(v[9] * v[9] + v[10] * v[10] + v[11] * v[11] + v[12] * v[12]);
    const double x = v[9] / length, y = v[10] / length, z = v[11] / length, w = v[12] / length;
    const Matrix scale = {{v[0], v[1], v[2], v[3], 0, v[4], v[5], v[6], 0, 0, v[7], v[8]}};
    const Matrix turn = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), v[13],
                          2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), v[14],
                          2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
                          v[15]}};
    return turn * scale;
}

std::mt19937 gRandom;
float between(double low, double high) {
    return float(std::uniform_real_distribution<double>(low, high)(gRandom));
}
int oneOf(int first, int last) {
    return std::uniform_int_distribution<int>(first, last)(gRandom);
}
float3 pointWithin(double r) {
    return {between(-r, r), between(-r, r), between(-r, r)};
}
Matrix randomMatrix() {
    Matrix to;
    do
        for (int i = 0; i < 12; ++i)
            to.m[i] = i % 4 == 3   ? between(-1.5, 1.5)
                      : i % 5 == 0 ? between(0.5, 1.5)
                                   : between(-0.5, 0.5);
    while (std::fabs(to.determinant()) < 0.2);
    return to;
}
OptixMotionOptions randomMotion(int keys) {
    OptixMotionOptions motion = {};
    motion.numKeys = (unsigned short)keys;
    motion.timeBegin = 0.1f * float(oneOf(0, 2));
    motion.timeEnd = motion.timeBegin + 0.1f * float(oneOf(3, 8));
    motion.flags = (unsigned short)std::max(0, oneOf(-4, 3));
    return motion;
}

// The digits of paths are the values of OptixTransformType.
enum Kind { kNone, kStatic, kMatrix, kSrt, kInstances, kTriangles, kSquares };

struct Node {
    Kind kind = kNone;
    OptixTraversableHandle handle = 0;
    std::vector<std::shared_ptr<Node>> children;
    std::vector<OptixInstance> instances;
    std::vector<Matrix> matrices; // of instances, keys of motion
    std::vector<OptixSRTData> srt;
    std::vector<std::vector<float3>> corners; // for each key
    unsigned split = 0;                       // triangles of the first build input; squares
    OptixMotionOptions motion = {};
    Buffer memory, source;

    // False if the node has vanished at this time; otherwise the key before it and the fraction.
    bool at(float time, size_t& key, double& fraction) const {
        key = 0;
        fraction = 0;
        if (motion.numKeys < 2)
            return true;
        if (((motion.flags & OPTIX_MOTION_FLAG_START_VANISH) && time < motion.timeBegin) ||
            ((motion.flags & OPTIX_MOTION_FLAG_END_VANISH) && time > motion.timeEnd))
            return false;
        const double last = motion.numKeys - 1;
        const double x =
            (double(time) - motion.timeBegin) / (double(motion.timeEnd) - motion.timeBegin) * last;
        key = size_t(std::clamp(x, 0.0, last - 1));
        fraction = std::clamp(x - double(key), 0.0, 1.0);
        return true;
    }
    bool vanishesAbout(float time) const {
        bool about = motion.flags && (std::fabs(time - motion.timeBegin) < 1e-5f ||
                                      std::fabs(time - motion.timeEnd) < 1e-5f);
        for (const auto& child : children)
            about = about || child->vanishesAbout(time);
        return about;
    }
};

class Maker {
public:
    explicit Maker(OptixDeviceContext context) : context_(context) {}

    std::shared_ptr<Node> make(int depth) {
        auto node = std::make_shared<Node>();
        node->kind = depth <= 1 || oneOf(0, 9) == 0 ? Kind(oneOf(kTriangles, kSquares))
                                                    : Kind(oneOf(kStatic, kInstances));
        const int count = node->kind >= kTriangles ? 0 : node->kind == kInstances ? oneOf(1, 4) : 1;
        for (int i = 0; i < count; ++i)
            node->children.push_back(make(depth - 1));
        switch (node->kind) {
        case kTriangles:
            triangles(*node);
            break;
        case kSquares:
            squares(*node);
            break;
        case kInstances:
            instances(*node);
            break;
        case kStatic:
            staticTransform(*node);
            break;
        default:
            motion(*node);
        }
        return node;
    }

private:
    void triangles(Node& node) {
        const int keys = std::max(1, oneOf(-1, 4)), count = oneOf(2, 6);
        if (keys > 1)
            node.motion = randomMotion(keys);
        node.split = unsigned(count) / 2;
        std::vector<Buffer> buffers;
        std::vector<CUdeviceptr> first, second;
        for (int k = 0; k < keys; ++k) {
            node.corners.emplace_back();
            for (int i = 0; i < 3 * count; ++i) {
                const float3 base = k ? node.corners[0][size_t(i)] : float3{};
                const float3 v = pointWithin(k ? 0.4 : 1.0);
                node.corners.back().push_back({base.x + v.x, base.y + v.y, base.z + v.z});
            }
            buffers.emplace_back(node.corners.back());
            first.push_back(buffers.back().ptr());
            second.push_back(buffers.back().ptr() + 36 * node.split);
        }
        const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
        std::vector<OptixBuildInput> inputs(2);
        for (int i = 0; i < 2; ++i) {
            auto& array = inputs[size_t(i)].triangleArray;
            inputs[size_t(i)].type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
            array.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
            array.numVertices = 3 * (i ? unsigned(count) - node.split : node.split);
            array.vertexBuffers = i ? second.data() : first.data();
            array.flags = &flags;
            array.numSbtRecords = 1;
        }
        build(node, inputs);
    }

    void squares(Node& node) {
        node.split = unsigned(oneOf(1, 3));
        std::vector<OptixAabb> boxes;
        for (unsigned i = 0; i < node.split; ++i) {
            const float z = 0.3f * float(i);
            boxes.push_back({-0.5f, -0.5f, z - 0.001f, 0.5f, 0.5f, z + 0.001f});
        }
        const Buffer buffer(boxes);
        const CUdeviceptr address = buffer.ptr();
        const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
        std::vector<OptixBuildInput> inputs(1);
        inputs[0].type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        inputs[0].customPrimitiveArray.aabbBuffers = &address;
        inputs[0].customPrimitiveArray.numPrimitives = node.split;
        inputs[0].customPrimitiveArray.flags = &flags;
        inputs[0].customPrimitiveArray.numSbtRecords = 1;
        build(node, inputs);
    }

    void instances(Node& node) {
        for (const auto& child : node.children) {
            node.matrices.push_back(randomMatrix());
            OptixInstance instance = {};
            for (int i = 0; i < 12; ++i)
                instance.transform[i] = float(node.matrices.back().m[i]);
            instance.instanceId = unsigned(oneOf(0, 1000));
            instance.sbtOffset = unsigned(oneOf(0, 7));
            instance.visibilityMask = unsigned(std::min(255, oneOf(1, 600)));
            instance.traversableHandle = child->handle;
            node.instances.push_back(instance);
        }
        node.source = Buffer(node.instances);
        std::vector<OptixBuildInput> inputs(1);
        inputs[0].type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
        inputs[0].instanceArray = {node.source.ptr(), unsigned(node.instances.size())};
        OptixMotionOptions options = {};
        options.numKeys = (unsigned short)oneOf(1, 3);
        options.timeEnd = 1.0f;
        node.handle = buildAccel(context_, inputs, node.memory, flags(), options);
    }

    void staticTransform(Node& node) {
        node.matrices = {randomMatrix()};
        const Matrix inverse = node.matrices[0].inverse();
        OptixStaticTransform transform = {};
        transform.child = node.children[0]->handle;
        for (int i = 0; i < 12; ++i) {
            transform.transform[i] = float(node.matrices[0].m[i]);
            transform.invTransform[i] = float(inverse.m[i]);
        }
        convert(node, &transform, sizeof transform, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM);
    }

    void motion(Node& node) {
        node.motion = randomMotion(oneOf(2, 4));
        std::vector<float> keys;
        for (int k = 0; k < node.motion.numKeys; ++k)
            node.kind == kMatrix ? matrixKey(node, keys) : srtKey(node, keys);
        // Both structs begin with the child and the motion options; the keys are their last member.
        const size_t begin = node.kind == kMatrix ? offsetof(OptixMatrixMotionTransform, transform)
                                                  : offsetof(OptixSRTMotionTransform, srtData);
        std::vector<char> bytes(begin + keys.size() * sizeof(float));
        std::memcpy(bytes.data(), &node.children[0]->handle, sizeof(OptixTraversableHandle));
        std::memcpy(&bytes[offsetof(OptixMatrixMotionTransform, motionOptions)], &node.motion,
                    sizeof node.motion);
        std::memcpy(&bytes[begin], keys.data(), keys.size() * sizeof(float));
        convert(node, bytes.data(), bytes.size(),
                node.kind == kMatrix ? OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM
                                     : OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM);
    }
    static void matrixKey(Node& node, std::vector<float>& keys) {
        Matrix key = node.matrices.empty() ? randomMatrix() : node.matrices[0];
        for (double& value : key.m) {
            value = float(value + between(-0.1, 0.1));
            keys.push_back(float(value));
        }
        node.matrices.push_back(key);
    }
    static void srtKey(Node& node, std::vector<float>& keys) {
        OptixSRTData key = {};
        for (float* value : {&key.sx, &key.sy, &key.sz})
            *value = between(0.7, 1.3);
        for (float* value : {&key.a, &key.b, &key.c, &key.pvx, &key.pvy, &key.pvz})
            *value = between(-0.3, 0.3);
        for (float* value : {&key.tx, &key.ty, &key.tz})
            *value = between(-1, 1);
        const float3 axis = pointWithin(0.4);
        key.qx = axis.x;
        key.qy = axis.y;
        key.qz = axis.z;
        key.qw = std::sqrt(1 - axis.x * axis.x - axis.y * axis.y - axis.z * axis.z);
        keys.insert(keys.end(), &key.sx, &key.sx + 16);
        node.srt.push_back(key);
    }

    static unsigned flags() {
        const unsigned choices[] = {OPTIX_BUILD_FLAG_NONE, OPTIX_BUILD_FLAG_PREFER_FAST_TRACE,
                                    OPTIX_BUILD_FLAG_PREFER_FAST_BUILD};
        return choices[oneOf(0, 2)] |
               unsigned(oneOf(0, 1) ? OPTIX_BUILD_FLAG_ALLOW_COMPACTION : OPTIX_BUILD_FLAG_NONE);
    }
    void build(Node& node, const std::vector<OptixBuildInput>& inputs) {
        node.handle = buildAccel(context_, inputs, node.memory, flags(), node.motion);
    }
    void convert(Node& node, const void* bytes, size_t size, OptixTraversableType type) {
        node.memory.upload(bytes, size);
        OPTIX_TRY(optixConvertPointerToTraversableHandle(context_, node.memory.ptr(), type,
                                                         &node.handle));
    }
    OptixDeviceContext context_;
};

struct Hit {
    double t, margin; // distance from the edge; small or negative: rounding decides
    unsigned primitive, record, kind;
    unsigned id = ~0u, index = 0, path = 0;
    Matrix toWorld;
};

// The place in the graph that a walk has reached.
struct Place {
    Matrix toWorld;
    unsigned offset = 0, id = ~0u, index = 0, path = 0;
};

class Walk {
public:
    Walk(const Ray& ray, const Node& root) : ray_(ray) {
        visit(root, {});
        std::sort(hits_.begin(), hits_.end(), [](const Hit& a, const Hit& b) { return a.t < b.t; });
    }
    const Hit* first() const { return hits_.empty() ? nullptr : &hits_[0]; }
    bool isClear() const {
        return hits_.empty() || (hits_[0].margin > 2e-4 && hits_[0].t > 1e-4 &&
                                 (hits_.size() == 1 || hits_[1].t > 1.001 * hits_[0].t));
    }

private:
    void visit(const Node& node, const Place& place) {
        size_t key = 0;
        double f = 0;
        if (!node.at(ray_.time, key, f))
            return;
        if (node.kind == kTriangles)
            return triangles(node, place, key, f);
        if (node.kind == kSquares)
            return squares(node, place);
        for (size_t i = 0; i < node.children.size(); ++i) {
            Place below = place;
            below.path = place.path * 8 + unsigned(node.kind);
            if (node.kind == kInstances) {
                const OptixInstance& instance = node.instances[i];
                if (!(instance.visibilityMask & ray_.mask))
                    continue;
                below.id = instance.instanceId;
                below.index = unsigned(i);
                below.offset += instance.sbtOffset;
            }
            below.toWorld =
                place.toWorld * (node.kind == kSrt ? mix(node.srt[key], node.srt[key + 1], f)
                                 : node.kind == kMatrix
                                     ? mix(node.matrices[key], node.matrices[key + 1], f)
                                     : node.matrices[i]);
            visit(*node.children[i], below);
        }
    }

    void squares(const Node& node, const Place& place) {
        const Matrix inverse = place.toWorld.inverse();
        const Vector o = inverse.point(vectorOf(ray_.origin)),
                     d = inverse.direction(vectorOf(ray_.direction));
        for (unsigned i = 0; i < node.split; ++i) {
            const double t = (0.3 * i - o.z) / d.z;
            const double margin =
                0.5 - std::max(std::fabs(o.x + t * d.x), std::fabs(o.y + t * d.y));
            add(place, t, margin, i, 0, i + 1);
        }
    }

    void triangles(const Node& node, const Place& place, size_t key, double f) {
        const Matrix inverse = place.toWorld.inverse();
        const Vector o = inverse.point(vectorOf(ray_.origin)),
                     d = inverse.direction(vectorOf(ray_.direction));
        const auto &from = node.corners[key], &to = node.corners[f > 0 ? key + 1 : key];
        for (unsigned i = 0; i < from.size() / 3; ++i) {
            const Vector a = mix(from[3 * i], to[3 * i], f),
                         e = mix(from[3 * i + 1], to[3 * i + 1], f) - a,
                         g = mix(from[3 * i + 2], to[3 * i + 2], f) - a;
            const Vector p = cross(d, g), q = cross(o - a, e);
            const double determinant = dot(e, p);
            const double u = dot(o - a, p) / determinant, v = dot(d, q) / determinant;
            double margin = std::min({u, v, 1 - u - v});
            if (std::fabs(determinant) < 0.01 * std::sqrt(dot(e, e) * dot(g, g) * dot(d, d)))
                margin = std::min(margin, 1e-5); // nearly in the plane
            const bool second = i >= node.split;
            add(place, dot(g, q) / determinant, margin, second ? i - node.split : i, second ? 2 : 0,
                determinant > 0 ? OPTIX_HIT_KIND_TRIANGLE_FRONT_FACE
                                : OPTIX_HIT_KIND_TRIANGLE_BACK_FACE);
        }
    }

    void add(const Place& place, double t, double margin, unsigned primitive, unsigned record,
             unsigned kind) {
        if (t > 0 && margin > -1e-3)
            hits_.push_back({t, margin, primitive, place.offset + record + 1, kind, place.id,
                             place.index, place.path, place.toWorld});
    }

    const Ray& ray_;
    std::vector<Hit> hits_;
};

bool isNear(float3 a, Vector b) {
    const double limit = 2e-3 * (1 + std::fabs(b.x) + std::fabs(b.y) + std::fabs(b.z));
    return std::fabs(a.x - b.x) < limit && std::fabs(a.y - b.y) < limit &&
           std::fabs(a.z - b.z) < limit;
}

bool agrees(const Ray& ray, const Answer& answer, const Hit* hit) {
    if (!hit)
        return answer.t == -1.0f;
    const Matrix inverse = hit->toWorld.inverse();
    const Vector origin = inverse.point(vectorOf(ray.origin));
    const Vector point = hit->toWorld.point({1, 2, 3});
    const bool isTriangle = hit->kind >= OPTIX_HIT_KIND_TRIANGLE_FRONT_FACE;
    return std::fabs(answer.t - hit->t) < 2e-3 * hit->t && answer.primitive == hit->primitive &&
           answer.id == hit->id && answer.index == hit->index && answer.record == hit->record &&
           answer.kind == hit->kind && answer.path == hit->path && answer.filtered > 0 &&
           isNear(answer.point, point) && isNear(answer.byHand, point) &&
           isNear(answer.normal, inverse.transposed({1, 2, 3})) && isNear(answer.origin, origin) &&
           (isTriangle || isNear(answer.tested, origin));
}

std::vector<Ray> randomRays() {
    std::vector<Ray> rays(kRays);
    for (Ray& ray : rays) {
        ray.origin = pointWithin(6);
        const float3 target = pointWithin(2);
        ray.direction = {target.x - ray.origin.x, target.y - ray.origin.y, target.z - ray.origin.z};
        ray.time = oneOf(0, 5) ? between(-0.1, 1.2) : 0.1f * float(oneOf(0, 10));
        ray.mask = unsigned(std::min(255, oneOf(1, 500)));
    }
    return rays;
}

class Bench {
public:
    Bench() : context_(makeContext()) {
        auto options = pipelineOptions(0, 3, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY);
        options.usesMotionBlur = true;
        OptixModule module = makeModule(context_, options);
        const OptixProgramGroup raygen = raygenGroup(context_, module, "__raygen__probe"),
                                miss = missGroup(context_, module, "__miss__probe"),
                                hit = hitGroup(context_, module, "__closesthit__probe",
                                               "__anyhit__probe", "__intersection__square");
        pipeline_ = makePipeline(context_, options, {raygen, miss, hit});
        OPTIX_TRY(optixPipelineSetStackSize(pipeline_, 0, 0, 4096, 20));
        std::vector<Record<unsigned>> hits;
        for (unsigned i = 0; i < kRecords; ++i)
            hits.push_back(packed(hit, i));
        hits_ = Buffer(hits);
        raygen_ = Buffer(std::vector{packed(raygen, 0u)});
        miss_ = Buffer(std::vector{packed(miss, 0u)});
        table_.raygenRecord = raygen_.ptr();
        table_.missRecordBase = miss_.ptr();
        table_.missRecordStrideInBytes = table_.hitgroupRecordStrideInBytes = sizeof hits[0];
        table_.missRecordCount = 1;
        table_.hitgroupRecordBase = hits_.ptr();
        table_.hitgroupRecordCount = kRecords;
    }

    bool run(unsigned seed) {
        gRandom.seed(seed);
        const auto root = Maker(context_).make(oneOf(1, 6));
        const std::vector<Ray> rays = randomRays();
        Buffer source(rays), target(kRays * sizeof(Answer));
        const Params params = {root->handle, source.as<Ray>(), target.as<Answer>()};
        const Buffer arguments(std::vector{params});
        OPTIX_TRY(
            optixLaunch(pipeline_, nullptr, arguments.ptr(), sizeof params, &table_, kRays, 1, 1));
        CUDA_TRY(cudaDeviceSynchronize());
        const auto answers = target.download<Answer>();
        for (unsigned i = 0; i < kRays; ++i) {
            const Walk walk(rays[i], *root);
            if (!walk.isClear() || root->vanishesAbout(rays[i].time))
                continue;
            hitCount += walk.first() != nullptr;
            if (!agrees(rays[i], answers[i], walk.first())) {
                std::printf("seed %u, ray %u: t %g, the host has %g\n", seed, i, answers[i].t,
                            walk.first() ? walk.first()->t : -1.0);
                return false;
            }
        }
        return true;
    }

    unsigned hitCount = 0;

private:
    OptixDeviceContext context_;
    OptixPipeline pipeline_ = nullptr;
    Buffer raygen_, miss_, hits_;
    OptixShaderBindingTable table_ = {};
};

bool run() {
    Bench bench;
    for (unsigned seed = 1; seed <= kGraphs; ++seed)
        if (!bench.run(seed))
            return false;
    std::printf("%u hits\n", bench.hitCount);
    return bench.hitCount > kGraphs * 10;
}

} // namespace

int main() {
    return runChecked(run);
}
