// SPDX-License-Identifier: Apache-2.0
#include "scene.h"

#include "rig.h"

#include <algorithm>
#include <cmath>

namespace tests::api {

Matrix identity() {
    return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
}

Matrix translation(float x, float y, float z) {
    return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z};
}

Matrix randomAffine(std::mt19937& random, float spread) {
    std::uniform_real_distribution<float> unit(-1, 1);
    Matrix m{};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            m[size_t(i * 4 + j)] = 0.3f * unit(random) + (i == j ? (unit(random) < 0 ? -1 : 1) : 0);
        m[size_t(i * 4 + 3)] = spread * unit(random);
    }
    return m;
}

Vec3 transformVector(const Matrix& m, Vec3 v) {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

Vec3 transformPoint(const Matrix& m, Vec3 p) {
    Vec3 r = transformVector(m, p);
    return {r.x + m[3], r.y + m[7], r.z + m[11]};
}

Matrix inverse(const Matrix& m) {
    double a[9] = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    double c[9] = {a[4] * a[8] - a[5] * a[7], a[2] * a[7] - a[1] * a[8], a[1] * a[5] - a[2] * a[4],
                   a[5] * a[6] - a[3] * a[8], a[0] * a[8] - a[2] * a[6], a[2] * a[3] - a[0] * a[5],
                   a[3] * a[7] - a[4] * a[6], a[1] * a[6] - a[0] * a[7], a[0] * a[4] - a[1] * a[3]};
    double det = a[0] * c[0] + a[1] * c[3] + a[2] * c[6];
    Matrix r{};
    for (size_t i = 0; i < 3; ++i) {
        double shift = 0;
        for (size_t j = 0; j < 3; ++j) {
            r[i * 4 + j] = float(c[i * 3 + j] / det);
            shift -= c[i * 3 + j] / det * m[j * 4 + 3];
        }
        r[i * 4 + 3] = float(shift);
    }
    return r;
}

OptixAccelBuildOptions buildOptions(unsigned flags) {
    OptixAccelBuildOptions options{};
    options.buildFlags = flags;
    options.operation = OPTIX_BUILD_OPERATION_BUILD;
    return options;
}

Accel buildAccel(OptixDeviceContext context, const LogRecord& log,
                 const std::vector<OptixBuildInput>& inputs, unsigned flags,
                 const std::vector<OptixAccelEmitDesc>& emit) {
    return buildAccel(context, log, inputs, buildOptions(flags), emit);
}

Accel buildAccel(OptixDeviceContext context, const LogRecord& log,
                 const std::vector<OptixBuildInput>& inputs, const OptixAccelBuildOptions& options,
                 const std::vector<OptixAccelEmitDesc>& emit) {
    OptixAccelBufferSizes sizes{};
    require(optixAccelComputeMemoryUsage(context, &options, inputs.data(), unsigned(inputs.size()),
                                         &sizes),
            "optixAccelComputeMemoryUsage", log);
    Accel accel;
    accel.memory = Buffer(sizes.outputSizeInBytes);
    accel.memory.fill(0xCD);
    Buffer temp(sizes.tempSizeInBytes);
    temp.fill(0xCD);
    require(optixAccelBuild(context, nullptr, &options, inputs.data(), unsigned(inputs.size()),
                            temp.address(), temp.size(), accel.memory.address(),
                            accel.memory.size(), &accel.handle, emit.empty() ? nullptr : emit.data(),
                            unsigned(emit.size())),
            "optixAccelBuild", log);
    waitForDevice();
    if (log.hasUnexpectedError())
        throw std::runtime_error("errors in the log:\n" + log.all());
    temp.fill(0xEE);
    return accel;
}

TriangleMesh::TriangleMesh(const std::vector<Vec3>& vertexList,
                           const std::vector<uint32_t>& indexList,
                           std::vector<unsigned> geometryFlags)
    : points(vertexList), corners(indexList), flags(std::move(geometryFlags)),
      vertices(vertexList), indices(indexList), vertexAddress(vertices.address()) {
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& array = input.triangleArray;
    array.vertexBuffers = &vertexAddress;
    array.numVertices = unsigned(points.size());
    array.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    array.indexBuffer = indices.address();
    array.numIndexTriplets = unsigned(corners.size() / 3);
    array.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    array.flags = flags.data();
    array.numSbtRecords = unsigned(flags.size());
}

void TriangleMesh::setSbtIndices(const std::vector<uint32_t>& perTriangle) {
    sbtIndices = perTriangle;
    sbt = Buffer(perTriangle);
    input.triangleArray.sbtIndexOffsetBuffer = sbt.address();
    input.triangleArray.sbtIndexOffsetSizeInBytes = 4;
}

CustomBoxes::CustomBoxes(const std::vector<OptixAabb>& boxes, std::vector<unsigned> geometryFlags)
    : flags(std::move(geometryFlags)), memory(boxes), address(memory.address()) {
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input.customPrimitiveArray.aabbBuffers = &address;
    input.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
    input.customPrimitiveArray.flags = flags.data();
    input.customPrimitiveArray.numSbtRecords = unsigned(flags.size());
}

InstanceList::InstanceList(const std::vector<OptixInstance>& list) : memory(list) {
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input.instanceArray.instances = memory.address();
    input.instanceArray.numInstances = unsigned(list.size());
}

OptixInstance instanceOf(OptixTraversableHandle child, const Matrix& transform, unsigned id,
                         unsigned sbtOffset, unsigned mask, unsigned flags) {
    OptixInstance instance{};
    std::copy(transform.begin(), transform.end(), instance.transform);
    instance.instanceId = id;
    instance.sbtOffset = sbtOffset;
    instance.visibilityMask = mask;
    instance.flags = flags;
    instance.traversableHandle = child;
    return instance;
}

namespace {

struct Double3 {
    double x, y, z;
};
Double3 wide(Vec3 v) {
    return {v.x, v.y, v.z};
}
Double3 operator-(Double3 a, Double3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
double dot(Double3 a, Double3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Double3 cross(Double3 a, Double3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Double3 apply(const Matrix& m, Double3 p, double w) {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3] * w,
            m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7] * w,
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11] * w};
}

// Whether any-hit programs may run, resolved from ray, instance and geometry flags in this order;
// false in `visible` if a cull flag of the ray drops the primitive.
bool anyHitEnabled(unsigned ray, unsigned instance, unsigned geometry, bool& visible) {
    bool enabled = !(geometry & OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
    if (instance & OPTIX_INSTANCE_FLAG_DISABLE_ANYHIT)
        enabled = false;
    if (instance & OPTIX_INSTANCE_FLAG_ENFORCE_ANYHIT)
        enabled = true;
    visible = !((ray & OPTIX_RAY_FLAG_CULL_DISABLED_ANYHIT) && !enabled) &&
              !((ray & OPTIX_RAY_FLAG_CULL_ENFORCED_ANYHIT) && enabled);
    if (ray & OPTIX_RAY_FLAG_DISABLE_ANYHIT)
        enabled = false;
    if (ray & OPTIX_RAY_FLAG_ENFORCE_ANYHIT)
        enabled = true;
    return enabled;
}

// Crosses the triangle's plane inside the triangle. `edge` is the distance from the nearest edge
// in barycentric units, also for crossings slightly outside.
bool intersect(const ReferenceTriangle& triangle, const Matrix& worldToObject, const Ray& ray,
               Crossing& out, double& edge) {
    Double3 origin = apply(worldToObject, wide(ray.origin), 1);
    Double3 direction = apply(worldToObject, wide(ray.direction), 0);
    Double3 a = wide(triangle.v[0]);
    Double3 e1 = wide(triangle.v[1]) - a, e2 = wide(triangle.v[2]) - a;
    Double3 p = cross(direction, e2);
    double det = dot(e1, p);
    if (det == 0 || !std::isfinite(det))
        return false;
    Double3 s = origin - a;
    Double3 q = cross(s, e1);
    out.u = dot(s, p) / det;
    out.v = dot(direction, q) / det;
    out.t = dot(e2, q) / det;
    out.back = det < 0; // the normal e1 x e2 points along the ray
    double inside = std::min({out.u, out.v, 1 - out.u - out.v});
    edge = std::abs(inside);
    return inside >= 0;
}

} // namespace

std::vector<Crossing> crossings(const std::vector<ReferenceInstance>& scene, const Ray& ray,
                                bool& ambiguous) {
    constexpr double kClose = 1e-4;
    std::vector<Crossing> found;
    ambiguous = false;
    for (size_t i = 0; i < scene.size(); ++i) {
        const OptixInstance& instance = scene[i].instance;
        if ((instance.visibilityMask & ray.mask & 255) == 0)
            continue;
        Matrix toWorld;
        std::copy_n(instance.transform, 12, toWorld.begin());
        Matrix toObject = inverse(toWorld);
        for (const ReferenceTriangle& triangle : *scene[i].gas) {
            Crossing c{};
            double edge = 1;
            bool inside = intersect(triangle, toObject, ray, c, edge);
            if (edge < kClose && c.t > ray.tmin - kClose && c.t < ray.tmax + kClose)
                ambiguous = true;
            if (!inside)
                continue;
            if (std::abs(c.t - ray.tmin) < kClose || std::abs(c.t - ray.tmax) < kClose)
                ambiguous = true;
            if (c.t < ray.tmin || c.t > ray.tmax)
                continue;
            if (instance.flags & OPTIX_INSTANCE_FLAG_FLIP_TRIANGLE_FACING)
                c.back = !c.back;
            if (!(instance.flags & OPTIX_INSTANCE_FLAG_DISABLE_TRIANGLE_FACE_CULLING)) {
                if (c.back && (ray.flags & OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES))
                    continue;
                if (!c.back && (ray.flags & OPTIX_RAY_FLAG_CULL_FRONT_FACING_TRIANGLES))
                    continue;
            }
            bool visible = true;
            c.anyHitEnabled =
                anyHitEnabled(ray.flags, instance.flags, triangle.geometryFlags, visible);
            if (!visible)
                continue;
            c.primitive = triangle.primitive;
            c.sbtGasIndex = triangle.sbtGasIndex;
            c.instance = unsigned(i);
            found.push_back(c);
        }
    }
    std::sort(found.begin(), found.end(),
              [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
    for (size_t i = 1; i < found.size(); ++i)
        if (found[i].t - found[i - 1].t < kClose)
            ambiguous = true;
    return found;
}

std::vector<ReferenceTriangle> referenceOf(const std::vector<const TriangleMesh*>& meshes) {
    std::vector<ReferenceTriangle> all;
    unsigned sbtBase = 0;
    for (const TriangleMesh* mesh : meshes) {
        for (size_t i = 0; i < mesh->corners.size() / 3; ++i) {
            ReferenceTriangle triangle;
            for (size_t k = 0; k < 3; ++k)
                triangle.v[k] = mesh->points[mesh->corners[i * 3 + k]];
            triangle.primitive = unsigned(i) + mesh->input.triangleArray.primitiveIndexOffset;
            unsigned local = mesh->sbtIndices.empty() ? 0 : mesh->sbtIndices[i];
            triangle.sbtGasIndex = sbtBase + local;
            triangle.geometryFlags = mesh->flags[local];
            all.push_back(triangle);
        }
        sbtBase += unsigned(mesh->flags.size());
    }
    return all;
}

ReferenceInstance bare(const std::vector<ReferenceTriangle>& gas) {
    return {instanceOf(0, identity(), ~0u), &gas};
}

} // namespace tests::api
