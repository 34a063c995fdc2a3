// SPDX-License-Identifier: Apache-2.0
// A renderer as tutorials write it: its device code is a string that NVRTC compiles when the
// program starts, with a header of its own that the string includes. A Whitted scene of spheres and
// a floor, with recursion for mirrors and rays for shadows, is compared with the same computation
// on the host.
#include <cuda_runtime.h>
#include <nvrtc.h>
#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#define CHECK(call)                                                                                \
    do {                                                                                           \
        const int code_ = int(call);                                                               \
        if (code_ != 0) {                                                                          \
            std::fprintf(stderr, "%s:%d: %s returned %d\n", __FILE__, __LINE__, #call, code_);     \
            std::exit(2);                                                                          \
        }                                                                                          \
    } while (0)

// Read by both sides.
#define SCENE_TEXT(...)                                                                            \
    static const char kSceneText[] = #__VA_ARGS__;                                                 \
    __VA_ARGS__
SCENE_TEXT(
    struct Sphere {
        float x, y, z, radius;
        float mirror;
        float colour;
    };
    struct LaunchParams {
        unsigned long long scene;
        const Sphere* spheres;
        float* image;
        int width;
        int height;
        int depth;
    };)

static const char kDeviceText[] = R"CODE(
#include <optix.h>
#include <optix_device.h>
#include "scene.h"

extern "C" { __constant__ LaunchParams params; }

namespace {
template <class T> __device__ T lerp(T a, T b, float t) { return a + (b - a) * t; }
inline __device__ float3 operator*(float s, const float3& v) { return make_float3(s * v.x, s * v.y, s * v.z); }
inline __device__ float3 operator+(const float3& a, const float3& b) { return make_float3(a.x + b.x, a.y + b.y, a.z + b.z); }
inline __device__ float3 operator-(const float3& a, const float3& b) { return make_float3(a.x - b.x, a.y - b.y, a.z - b.z); }
inline __device__ float dot(const float3& a, const float3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline __device__ float3 normalize(const float3& v) { return (1.0f / sqrtf(dot(v, v))) * v; }
enum RayType { RADIANCE, OCCLUSION, RAY_TYPES };
struct Payload { float value; int depth; };
__device__ float radiance(float3 from, float3 way, int depth) {
    unsigned int value = 0, level = depth;
    optixTrace((OptixTraversableHandle)params.scene, from, way, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, RADIANCE, RAY_TYPES, RADIANCE, value, level);
    return __uint_as_float(value);
}
__device__ bool occluded(float3 from, float3 way) {
    unsigned int hit = 1, unused = 0;
    optixTrace((OptixTraversableHandle)params.scene, from, way, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_ANYHIT |
               OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, OCCLUSION, RAY_TYPES, OCCLUSION, hit, unused);
    return hit != 0;
}
}

extern "C" __global__ void __raygen__camera() {
    const uint3 idx = optixGetLaunchIndex();
    const float u = 2.0f * (float(idx.x) + 0.5f) / params.width - 1.0f;
    const float v = 2.0f * (float(idx.y) + 0.5f) / params.height - 1.0f;
    params.image[idx.y * params.width + idx.x] =
        radiance(make_float3(0, 1, 6), normalize(make_float3(u, v * 0.75f, -1.5f)), 0);
}
extern "C" __global__ void __miss__sky() {
    const float3 way = optixGetWorldRayDirection();
    optixSetPayload_0(__float_as_uint(lerp(0.2f, 1.0f, 0.5f + 0.5f * way.y)));
}
extern "C" __global__ void __miss__light() { optixSetPayload_0(0); }
extern "C" __global__ void __intersection__sphere() {
    const Sphere& s = params.spheres[optixGetPrimitiveIndex()];
    const float3 o = optixGetWorldRayOrigin() - make_float3(s.x, s.y, s.z), d = optixGetWorldRayDirection();
    const float b = dot(o, d), c = dot(o, o) - s.radius * s.radius, disc = b * b - c;
    if (disc < 0.0f) return;
    const float root = sqrtf(disc);
    if (!optixReportIntersection(-b - root, 0)) optixReportIntersection(-b + root, 1);
}
extern "C" __global__ void __closesthit__phong() {
    const Sphere& s = params.spheres[optixGetPrimitiveIndex()];
    const float3 d = optixGetWorldRayDirection(), p = optixGetWorldRayOrigin() + optixGetRayTmax() * d;
    const float3 n = (1.0f / s.radius) * (p - make_float3(s.x, s.y, s.z)), light = normalize(make_float3(2, 5, 3));
    const float facing = fmaxf(0.0f, dot(n, light));
    float value = s.colour * (0.1f + (facing > 0.0f && !occluded(p, light) ? 0.9f * facing : 0.0f));
    const int depth = (int)optixGetPayload_1();
    if (s.mirror > 0.0f && depth + 1 < params.depth)
        value = lerp(value, radiance(p, d - 2.0f * dot(d, n) * n, depth + 1), s.mirror);
    optixSetPayload_0(__float_as_uint(value));
}
)CODE";

// The host's version.
struct V {
    double x, y, z;
};
static V operator+(V a, V b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
static V operator-(V a, V b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
static V operator*(double s, V v) {
    return {s * v.x, s * v.y, s * v.z};
}
static double dot(V a, V b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static V normalize(V v) {
    return (1 / std::sqrt(dot(v, v))) * v;
}

static const std::vector<Sphere> kSpheres = {{0, -1000, 0, 1000, 0.2f, 0.6f},
                                             {-1.5f, 1, 0, 1, 0.8f, 0.9f},
                                             {1.2f, 0.8f, 0.7f, 0.8f, 0, 0.7f},
                                             {0.2f, 0.4f, 2, 0.4f, 0.5f, 0.5f},
                                             {0, 2.5f, -3, 1.5f, 0.9f, 0.8f}};

static int nearest(V o, V d, double& t) {
    int found = -1;
    t = 1e16;
    for (size_t i = 0; i < kSpheres.size(); ++i) {
        const Sphere& s = kSpheres[i];
        const V from = o - V{s.x, s.y, s.z};
        const double b = dot(from, d), disc = b * b - dot(from, from) + double(s.radius) * s.radius;
        for (const double hit : {-b - std::sqrt(disc), -b + std::sqrt(disc)})
            if (disc >= 0 && hit > 1e-3 && hit < t) {
                t = hit;
                found = int(i);
            }
    }
    return found;
}

static double radiance(V o, V d, int depth, int most) {
    double t = 0, unused = 0;
    const int hit = nearest(o, d, t);
    if (hit < 0)
        return 0.2 + 0.8 * (0.5 + 0.5 * d.y);
    const Sphere& s = kSpheres[hit];
    const V p = o + t * d, n = (1.0 / s.radius) * (p - V{s.x, s.y, s.z}),
            light = normalize({2, 5, 3});
    const double facing = std::max(0.0, dot(n, light));
    double value =
        s.colour * (0.1 + (facing > 0 && nearest(p, light, unused) < 0 ? 0.9 * facing : 0));
    if (s.mirror > 0 && depth + 1 < most)
        value += (radiance(p, d - 2 * dot(d, n) * n, depth + 1, most) - value) * s.mirror;
    return value;
}

class Renderer {
public:
    Renderer(int width, int height, int depth) {
        params_.width = width;
        params_.height = height;
        params_.depth = depth;
        CHECK(cudaFree(nullptr));
        CHECK(optixInit());
        CHECK(optixDeviceContextCreate(nullptr, nullptr, &context_));
        makePipeline(compile());
        makeScene();
        makeTable();
        CHECK(cudaMalloc(reinterpret_cast<void**>(&params_.image),
                         size_t(width) * height * sizeof(float)));
    }
    std::vector<float> render() {
        const CUdeviceptr params = upload(&params_, sizeof params_);
        CHECK(optixLaunch(pipeline_, nullptr, params, sizeof params_, &table_,
                          unsigned(params_.width), unsigned(params_.height), 1));
        CHECK(cudaDeviceSynchronize());
        std::vector<float> image(size_t(params_.width) * params_.height);
        CHECK(cudaMemcpy(image.data(), params_.image, image.size() * sizeof(float),
                         cudaMemcpyDeviceToHost));
        return image;
    }

private:
    static CUdeviceptr upload(const void* data, size_t bytes) {
        void* memory = nullptr;
        CHECK(cudaMalloc(&memory, bytes));
        CHECK(cudaMemcpy(memory, data, bytes, cudaMemcpyHostToDevice));
        return reinterpret_cast<CUdeviceptr>(memory);
    }

    static std::string compile() {
        const char *texts[] = {kSceneText}, *names[] = {"scene.h"};
        nvrtcProgram program = nullptr;
        CHECK(nvrtcCreateProgram(&program, kDeviceText, "renderer.cu", 1, texts, names));
        const std::vector<const char*> options = {
            INCLUDE_FOLDERS, "-std=c++14",      "-arch=compute_60", "-use_fast_math",
            "-lineinfo",     "-default-device", "-rdc=true"};
        const nvrtcResult result =
            nvrtcCompileProgram(program, int(options.size()), options.data());
        size_t size = 0;
        CHECK(nvrtcGetProgramLogSize(program, &size));
        std::string log(size, '\0');
        CHECK(nvrtcGetProgramLog(program, &log[0]));
        if (result != NVRTC_SUCCESS)
            std::fprintf(stderr, "%s\n", log.c_str());
        CHECK(result);
        CHECK(nvrtcGetPTXSize(program, &size));
        std::string ptx(size, '\0');
        CHECK(nvrtcGetPTX(program, &ptx[0]));
        CHECK(nvrtcDestroyProgram(&program));
        return ptx;
    }

    void makePipeline(const std::string& ptx) {
        OptixModuleCompileOptions moduleOptions = {};
        moduleOptions.maxRegisterCount = OPTIX_COMPILE_DEFAULT_MAX_REGISTER_COUNT;
        OptixPipelineCompileOptions options = {};
        options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
        options.numPayloadValues = 2;
        options.numAttributeValues = 2;
        options.exceptionFlags = OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW;
        options.pipelineLaunchParamsVariableName = "params";
        OptixModule module = nullptr;
        char log[4096];
        size_t logSize = sizeof log;
        CHECK(optixModuleCreateFromPTX(context_, &moduleOptions, &options, ptx.c_str(), ptx.size(),
                                       log, &logSize, &module));
        OptixProgramGroupDesc descs[5] = {};
        descs[0].kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
        descs[0].raygen = {module, "__raygen__camera"};
        descs[1].kind = descs[2].kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
        descs[1].miss = {module, "__miss__sky"};
        descs[2].miss = {module, "__miss__light"};
        descs[3].kind = descs[4].kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        descs[3].hitgroup.moduleCH = descs[3].hitgroup.moduleIS = descs[4].hitgroup.moduleIS =
            module;
        descs[3].hitgroup.entryFunctionNameCH = "__closesthit__phong";
        descs[3].hitgroup.entryFunctionNameIS = "__intersection__sphere";
        descs[4].hitgroup.entryFunctionNameIS = "__intersection__sphere";
        OptixProgramGroupOptions groupOptions = {};
        logSize = sizeof log;
        CHECK(optixProgramGroupCreate(context_, descs, 5, &groupOptions, log, &logSize, groups_));
        OptixPipelineLinkOptions link = {};
        link.maxTraceDepth = unsigned(params_.depth) + 1;
        link.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_FULL;
        logSize = sizeof log;
        CHECK(
            optixPipelineCreate(context_, &options, &link, groups_, 5, log, &logSize, &pipeline_));
    }

    void makeScene() {
        std::vector<OptixAabb> boxes;
        for (const Sphere& s : kSpheres)
            boxes.push_back({s.x - s.radius, s.y - s.radius, s.z - s.radius, s.x + s.radius,
                             s.y + s.radius, s.z + s.radius});
        const CUdeviceptr address = upload(boxes.data(), boxes.size() * sizeof boxes[0]);
        const unsigned flags[] = {OPTIX_GEOMETRY_FLAG_NONE};
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        input.customPrimitiveArray.aabbBuffers = &address;
        input.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
        input.customPrimitiveArray.flags = flags;
        input.customPrimitiveArray.numSbtRecords = 1;
        OptixAccelBuildOptions options = {};
        options.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
        options.operation = OPTIX_BUILD_OPERATION_BUILD;
        OptixAccelBufferSizes sizes = {};
        CHECK(optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
        void *temporary = nullptr, *output = nullptr;
        CHECK(cudaMalloc(&temporary, sizes.tempSizeInBytes));
        CHECK(cudaMalloc(&output, sizes.outputSizeInBytes));
        OptixTraversableHandle handle = 0;
        CHECK(optixAccelBuild(context_, nullptr, &options, &input, 1, CUdeviceptr(temporary),
                              sizes.tempSizeInBytes, CUdeviceptr(output), sizes.outputSizeInBytes,
                              &handle, nullptr, 0));
        CHECK(cudaFree(temporary));
        params_.scene = handle;
        params_.spheres = reinterpret_cast<const Sphere*>(
            upload(kSpheres.data(), kSpheres.size() * sizeof(Sphere)));
    }

    void makeTable() {
        struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) Empty {
            char header[OPTIX_SBT_RECORD_HEADER_SIZE];
        } records[5];
        for (int i = 0; i < 5; ++i)
            CHECK(optixSbtRecordPackHeader(groups_[i], &records[i]));
        table_.raygenRecord = upload(&records[0], sizeof(Empty));
        table_.missRecordBase = upload(&records[1], 2 * sizeof(Empty));
        table_.hitgroupRecordBase = upload(&records[3], 2 * sizeof(Empty));
        table_.missRecordStrideInBytes = table_.hitgroupRecordStrideInBytes = sizeof(Empty);
        table_.missRecordCount = table_.hitgroupRecordCount = 2;
    }

    LaunchParams params_ = {};
    OptixDeviceContext context_ = nullptr;
    OptixProgramGroup groups_[5] = {};
    OptixPipeline pipeline_ = nullptr;
    OptixShaderBindingTable table_ = {};
};

int main() {
    constexpr int kWidth = 64, kHeight = 48, kDepth = 4;
    Renderer renderer(kWidth, kHeight, kDepth);
    const std::vector<float> image = renderer.render();
    int different = 0;
    double mean = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const V way =
                normalize({2 * (x + .5) / kWidth - 1, 0.75 * (2 * (y + .5) / kHeight - 1), -1.5});
            const double difference =
                std::fabs(image[y * kWidth + x] - radiance({0, 1, 6}, way, 0, kDepth));
            different += difference > 0.02;
            mean += difference / (kWidth * kHeight);
        }
    // Edges of shadows and of mirrored balls may fall on either side.
    std::printf("%d pixels differ, %.4f on average\n", different, mean);
    const bool right = different < kWidth * kHeight / 50 && mean < 0.005;
    std::printf(right ? "ok\n" : "wrong\n");
    return right ? 0 : 1;
}
