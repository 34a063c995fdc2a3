// SPDX-License-Identifier: Apache-2.0
#include "lab.h"

#include <optix_stack_size.h>

#include <algorithm>
#include <cmath>

std::string_view differential_ptx(); // programs.cu, built into this program

namespace differential {
namespace {

constexpr unsigned kMisses = 2;

// A pipeline with its table, for one launch.
class Rig {
public:
    Rig(OptixDeviceContext context, const Pipeline& p) : context_(context), wanted_(p) {
        options_.usesMotionBlur = p.motion;
        options_.traversableGraphFlags = p.graphFlags;
        options_.numPayloadValues = 2;
        options_.numAttributeValues = 2;
        options_.exceptionFlags = p.exceptionFlags;
        options_.pipelineLaunchParamsVariableName = "params";
        options_.usesPrimitiveTypeFlags = p.primitiveTypes;
        options_.allowOpacityMicromaps = p.micromaps;
        moduleOptions_.optLevel = OPTIX_COMPILE_OPTIMIZATION_DEFAULT;
        moduleOptions_.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL;
        const std::string_view ptx = p.ptx.empty() ? differential_ptx() : p.ptx;
        OPTIX_CHECK(optixModuleCreateFromPTX(context, &moduleOptions_, &options_, ptx.data(),
                                             ptx.size(), nullptr, nullptr, &module_));
        addGroups();
        link();
    }
    Rig(const Rig&) = delete;
    ~Rig() {
        if (pipeline_)
            optixPipelineDestroy(pipeline_);
        for (OptixProgramGroup group : groups_)
            optixProgramGroupDestroy(group);
        for (OptixModule module : builtins_)
            optixModuleDestroy(module);
        optixModuleDestroy(module_);
    }

    void launch(const Params& params, unsigned count) {
        DeviceBuffer deviceParams;
        deviceParams.upload(&params, sizeof(params));
        OPTIX_CHECK(optixLaunch(pipeline_, nullptr, deviceParams.address(), sizeof(params), &table_,
                                count, 1, 1));
        CUDA_CHECK(cudaDeviceSynchronize());
    }

private:
    using Record = SbtRecord<RecordData>;

    OptixProgramGroup add(const OptixProgramGroupDesc& description) {
        OptixProgramGroupOptions options = {};
        OptixProgramGroup group = nullptr;
        OPTIX_CHECK(
            optixProgramGroupCreate(context_, &description, 1, &options, nullptr, nullptr, &group));
        groups_.push_back(group);
        return group;
    }
    OptixProgramGroup addSingle(OptixProgramGroupKind kind, const char* name) {
        OptixProgramGroupDesc description = {};
        description.kind = kind;
        description.raygen.module = module_; // these kinds share their place in the union
        description.raygen.entryFunctionName = name;
        return add(description);
    }
    OptixProgramGroup addHit(const HitRecord& hit) {
        OptixProgramGroupDesc description = {};
        description.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        OptixProgramGroupHitgroup& h = description.hitgroup;
        h.moduleCH = hit.closestHit ? module_ : nullptr;
        h.entryFunctionNameCH = hit.closestHit;
        h.moduleAH = hit.anyHit ? module_ : nullptr;
        h.entryFunctionNameAH = hit.anyHit;
        h.moduleIS = hit.intersection ? module_ : nullptr;
        h.entryFunctionNameIS = hit.intersection;
        if (hit.builtin != OPTIX_PRIMITIVE_TYPE_CUSTOM) {
            OptixBuiltinISOptions builtin = {};
            builtin.builtinISModuleType = hit.builtin;
            builtin.usesMotionBlur = wanted_.motion;
            OPTIX_CHECK(optixBuiltinISModuleGet(context_, &moduleOptions_, &options_, &builtin,
                                                &h.moduleIS));
            builtins_.push_back(h.moduleIS);
        }
        return add(description);
    }

    void addGroups() {
        std::vector<Record> records;
        const auto place = [&](OptixProgramGroup group, const RecordData& data) {
            records.push_back(makeRecord(group, data));
        };
        place(addSingle(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, wanted_.raygen), {});
        for (unsigned i = 0; i < kMisses; ++i)
            place(addSingle(OPTIX_PROGRAM_GROUP_KIND_MISS, "__miss__seen"), {500 + i, 0, nullptr});
        for (const HitRecord& hit : wanted_.hits)
            place(addHit(hit), hit.data);
        const size_t others = records.size();
        if (wanted_.callables)
            addCallables(place);
        if (wanted_.exceptions)
            place(addSingle(OPTIX_PROGRAM_GROUP_KIND_EXCEPTION, "__exception__seen"), {});
        records_.upload(records);
        const CUdeviceptr base = records_.address();
        table_.raygenRecord = base;
        table_.missRecordBase = base + sizeof(Record);
        table_.missRecordStrideInBytes = sizeof(Record);
        table_.missRecordCount = kMisses;
        if (!wanted_.hits.empty()) {
            table_.hitgroupRecordBase = base + (1 + kMisses) * sizeof(Record);
            table_.hitgroupRecordStrideInBytes = sizeof(Record);
            table_.hitgroupRecordCount = unsigned(wanted_.hits.size());
        }
        if (wanted_.callables) {
            table_.callablesRecordBase = base + others * sizeof(Record);
            table_.callablesRecordStrideInBytes = sizeof(Record);
            table_.callablesRecordCount = 2;
        }
        if (wanted_.exceptions)
            table_.exceptionRecord = base + (records.size() - 1) * sizeof(Record);
    }

    template <class Place>
    void addCallables(const Place& place) {
        const char* direct[] = {"__direct_callable__first", "__direct_callable__second"};
        const char* continuation[] = {"__continuation_callable__first",
                                      "__continuation_callable__second"};
        for (unsigned i = 0; i < 2; ++i) {
            OptixProgramGroupDesc description = {};
            description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
            description.callables.moduleDC = description.callables.moduleCC = module_;
            description.callables.entryFunctionNameDC = direct[i];
            description.callables.entryFunctionNameCC = continuation[i];
            place(add(description), RecordData{900 + i, 0, nullptr});
        }
    }

    void link() {
        OptixPipelineLinkOptions options = {};
        options.maxTraceDepth = wanted_.traceDepth;
        OPTIX_CHECK(optixPipelineCreate(context_, &options_, &options, groups_.data(),
                                        unsigned(groups_.size()), nullptr, nullptr, &pipeline_));
        OptixStackSizes sizes = {};
        for (OptixProgramGroup group : groups_)
            OPTIX_CHECK(optixUtilAccumulateStackSizes(group, &sizes));
        unsigned traversal = 0, state = 0, continuation = 0;
        const unsigned depth = wanted_.callables ? 1 : 0;
        OPTIX_CHECK(optixUtilComputeStackSizes(&sizes, wanted_.traceDepth, depth, depth, &traversal,
                                               &state, &continuation));
        OPTIX_CHECK(optixPipelineSetStackSize(pipeline_, traversal, state, continuation,
                                              wanted_.graphDepth));
    }

    OptixDeviceContext context_;
    const Pipeline& wanted_;
    OptixModuleCompileOptions moduleOptions_ = {};
    OptixPipelineCompileOptions options_ = {};
    OptixModule module_ = nullptr;
    std::vector<OptixModule> builtins_;
    std::vector<OptixProgramGroup> groups_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer records_;
    OptixShaderBindingTable table_ = {};
};

} // namespace

Mesh randomTriangles(unsigned count, float size, uint64_t seed) {
    Random random(seed);
    Mesh mesh;
    for (unsigned i = 0; i < count; ++i) {
        const float center[3] = {random.symmetric(), random.symmetric(), random.symmetric()};
        for (unsigned k = 0; k < 3; ++k) {
            mesh.indices.push_back(3 * i + k);
            for (const float c : center)
                mesh.vertices.push_back(c + size * random.symmetric());
        }
    }
    return mesh;
}

Mesh roughSphere(unsigned rings, uint64_t seed) {
    Random random(seed);
    Mesh mesh;
    const unsigned around = 2 * rings;
    const auto add = [&](float x, float y, float z) {
        const float r = 0.7f + 0.3f * random.unit();
        mesh.vertices.insert(mesh.vertices.end(), {r * x, r * y, r * z});
    };
    add(0, 1, 0);
    for (unsigned j = 1; j < rings; ++j)
        for (unsigned i = 0; i < around; ++i) {
            // Polynomials in place of sine and cosine: the same bits everywhere.
            const float a = 4.0f * float(i) / float(around), h = 1 - 2 * float(j) / float(rings);
            const float quarter = a - std::floor(a);
            const float c = 1 - quarter, s = quarter, n = 1 / std::sqrt(c * c + s * s);
            const float x[] = {c, -s, -c, s}, z[] = {s, c, -s, -c};
            const float r = std::sqrt(1 - h * h) * n;
            add(r * x[int(a) % 4], h, r * z[int(a) % 4]);
        }
    add(0, -1, 0);
    const uint32_t last = uint32_t(mesh.vertices.size() / 3 - 1);
    for (unsigned i = 0; i < around; ++i) {
        const uint32_t next = (i + 1) % around;
        mesh.indices.insert(mesh.indices.end(), {0, 1 + i, 1 + next});
        for (unsigned j = 0; j + 2 < rings; ++j) {
            const uint32_t a = 1 + j * around + i, b = 1 + j * around + next;
            mesh.indices.insert(mesh.indices.end(), {a, a + around, b, b, a + around, b + around});
        }
        const uint32_t base = 1 + (rings - 2) * around;
        mesh.indices.insert(mesh.indices.end(), {base + i, last, base + next});
    }
    return mesh;
}

Accel Lab::triangles(const Mesh& mesh, const OptixMotionOptions& motion) const {
    DeviceBuffer vertices, indices, sbt;
    vertices.upload(mesh.vertices);
    indices.upload(mesh.indices);
    sbt.upload(mesh.sbt);
    std::vector<CUdeviceptr> addresses;
    const size_t perKey = mesh.vertices.size() / mesh.keys;
    for (unsigned k = 0; k < mesh.keys; ++k)
        addresses.push_back(vertices.address() + k * perKey * sizeof(float));
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input.triangleArray;
    t.vertexBuffers = addresses.data();
    t.numVertices = unsigned(perKey / 3);
    t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    t.indexBuffer = indices.address();
    t.numIndexTriplets = unsigned(mesh.indices.size() / 3);
    t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    t.flags = mesh.flags.data();
    t.numSbtRecords = unsigned(mesh.flags.size());
    if (mesh.flags.size() > 1) {
        t.sbtIndexOffsetBuffer = sbt.address();
        t.sbtIndexOffsetSizeInBytes = sizeof(uint32_t);
    }
    return buildAccel(context_, input, motion, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
}

Accel Lab::instances(const std::vector<OptixInstance>& instances,
                     const OptixMotionOptions& motion) const {
    return buildInstances(context_, instances, motion);
}

Accel Lab::boxes(const std::vector<float>& spheres, unsigned flags) const {
    std::vector<OptixAabb> boxes;
    for (size_t i = 0; i + 3 < spheres.size(); i += 4) {
        const float* s = &spheres[i];
        const float r = s[3] * 1.001f;
        boxes.push_back({s[0] - r, s[1] - r, s[2] - r, s[0] + r, s[1] + r, s[2] + r});
    }
    DeviceBuffer deviceBoxes;
    deviceBoxes.upload(boxes);
    const CUdeviceptr address = deviceBoxes.address();
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input.customPrimitiveArray.aabbBuffers = &address;
    input.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
    input.customPrimitiveArray.flags = &flags;
    input.customPrimitiveArray.numSbtRecords = 1;
    return buildAccel(context_, input);
}

std::vector<Seen> Lab::trace(const Pipeline& pipeline, std::vector<TestRay> rays,
                             OptixTraversableHandle handle) const {
    for (TestRay& ray : rays)
        ray.handle = handle;
    DeviceBuffer deviceRays, deviceSeen(rays.size() * sizeof(Seen));
    deviceRays.upload(rays);
    CUDA_CHECK(cudaMemset(deviceSeen.data(), 0, deviceSeen.size()));
    Rig rig(context_, pipeline);
    rig.launch({deviceRays.as<TestRay>(), deviceSeen.as<Seen>()}, unsigned(rays.size()));
    return deviceSeen.download<Seen>();
}

TestRay makeRay(const float origin[3], const float direction[3]) {
    TestRay ray = {};
    std::copy(origin, origin + 3, ray.origin);
    std::copy(direction, direction + 3, ray.direction);
    ray.tmax = 1e16f;
    ray.mask = 255;
    ray.sbtStride = 1;
    return ray;
}

std::vector<TestRay> randomRays(size_t count, float spread, uint64_t seed) {
    Random random(seed);
    std::vector<TestRay> rays;
    for (size_t i = 0; i < count; ++i) {
        float origin[3], direction[3];
        for (int k = 0; k < 3; ++k) {
            origin[k] = spread * random.symmetric();
            direction[k] = random.symmetric() - origin[k];
        }
        TestRay ray = makeRay(origin, direction);
        if (i % 4 == 1)
            ray.tmin = 0.5f * random.unit();
        if (i % 4 == 2)
            ray.tmax = ray.tmin + 1.2f * random.unit();
        ray.missIndex = unsigned(i % 2);
        rays.push_back(ray);
    }
    return rays;
}

void randomMatrix(float matrix[12], uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < 12; ++i)
        matrix[i] = (i % 5 == 0 ? 1.0f : 0.0f) + 0.4f * random.symmetric();
    for (int i = 3; i < 12; i += 4)
        matrix[i] = 1.5f * random.symmetric();
}

OptixInstance makeInstance(OptixTraversableHandle child, uint64_t seed) {
    OptixInstance instance = {};
    randomMatrix(instance.transform, seed);
    instance.instanceId = unsigned(1000 + 7 * seed);
    instance.visibilityMask = 255;
    instance.traversableHandle = child;
    return instance;
}

const std::vector<Case>& allCases() {
    static const std::vector<Case> all = [] {
        std::vector<Case> list;
        for (auto part :
             {triangleCases, instanceCases, shapeCases, motionCases, programCases, footprintCases,
              misuseCases})
            for (Case& one : part())
                list.push_back(std::move(one));
        return list;
    }();
    return all;
}

} // namespace differential
