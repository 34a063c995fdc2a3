// SPDX-License-Identifier: Apache-2.0
// Programs compiled with the project's headers, run by the libnvoptix.so.1 and libcuda.so.1 that
// the process finds: Sunstone's, or those of a GPU driver. The library is the reference for the
// headers' transform arithmetic: its object-space ray must equal the world-space ray that the
// headers transform. Usage: interop PROGRAMS.ptx; prints [SKIP] where a library or a feature is
// missing.
#include "scene.h"

#include <optix.h>

#include <optix_function_table_definition.h>
#include <optix_stack_size.h>
#include <optix_stubs.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {

int gErrors = 0;

void expect(bool good, const std::string& what) {
    if (!good) {
        std::printf("  WRONG: %s\n", what.c_str());
        ++gErrors;
    }
}

[[noreturn]] void quit(int code, const std::string& text) {
    std::printf("%s\n", text.c_str());
    std::fflush(stdout);
    std::exit(code);
}

void check(OptixResult result, const char* call) {
    if (result == OPTIX_ERROR_NOT_SUPPORTED && gErrors == 0)
        quit(77, std::string("[SKIP] the rest: the library does not support ") + call);
    if (result != OPTIX_SUCCESS)
        quit(1, std::string(call) + ": " + optixGetErrorName(result));
}
#define CHECK(call) check(call, #call)

// The few functions of the CUDA driver in use.
class Cuda {
public:
    Cuda() {
        library_ = dlopen("libcuda.so.1", RTLD_NOW);
        if (!library_)
            quit(77, "[SKIP] no libcuda.so.1");
        CUdevice device;
        if (function<int(unsigned int)>("cuInit")(0) != 0 ||
            function<int(CUdevice*, int)>("cuDeviceGet")(&device, 0) != 0)
            quit(77, "[SKIP] no CUDA device");
        CUcontext context;
        expect(function<int(CUcontext*, CUdevice)>("cuDevicePrimaryCtxRetain")(&context, device) ==
                       0 &&
                   function<int(CUcontext)>("cuCtxSetCurrent")(context) == 0,
               "CUDA context");
    }
    CUdeviceptr allocate(size_t size) const {
        CUdeviceptr address = 0;
        if (function<int(CUdeviceptr*, size_t)>("cuMemAlloc_v2")(&address, size) != 0)
            quit(1, "cuMemAlloc");
        return address;
    }
    template <typename T>
    CUdeviceptr upload(const std::vector<T>& data) const {
        const CUdeviceptr address = allocate(data.size() * sizeof(T));
        copyIn(address, data.data(), data.size() * sizeof(T));
        return address;
    }
    void copyIn(CUdeviceptr to, const void* from, size_t size) const {
        if (function<int(CUdeviceptr, const void*, size_t)>("cuMemcpyHtoD_v2")(to, from, size) != 0)
            quit(1, "cuMemcpyHtoD");
    }
    void copyOut(void* to, CUdeviceptr from, size_t size) const {
        if (function<int(void*, CUdeviceptr, size_t)>("cuMemcpyDtoH_v2")(to, from, size) != 0)
            quit(1, "cuMemcpyDtoH");
    }
    void wait() const {
        const int result = function<int()>("cuCtxSynchronize")();
        if (result != 0)
            quit(1, "cuCtxSynchronize: " + std::to_string(result));
    }

private:
    template <typename Signature>
    Signature* function(const char* name) const {
        void* symbol = dlsym(library_, name);
        if (!symbol)
            quit(1, std::string("libcuda.so.1 without ") + name);
        Signature* result;
        std::memcpy(&result, &symbol, sizeof(result));
        return result;
    }
    void* library_;
};

struct Record {
    alignas(16) char header[32];
    unsigned int data[4];
};

struct World {
    Cuda cuda;
    OptixDeviceContext context = nullptr;
    OptixPipeline pipeline = nullptr;
    OptixShaderBindingTable sbt = {};
    CUdeviceptr result = 0, params = 0;
};

void log(unsigned int level, const char* tag, const char* message, void*) {
    if (level <= 3)
        std::printf("  [%u %s] %s\n", level, tag, message);
}

OptixTraversableHandle build(World& world, const OptixBuildInput& input, unsigned int flags) {
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags;
    options.operation = OPTIX_BUILD_OPERATION_BUILD;
    OptixAccelBufferSizes sizes;
    CHECK(optixAccelComputeMemoryUsage(world.context, &options, &input, 1, &sizes));
    OptixTraversableHandle handle = 0;
    const CUdeviceptr temporary = world.cuda.allocate(sizes.tempSizeInBytes + 1);
    const CUdeviceptr output = world.cuda.allocate(sizes.outputSizeInBytes);
    CHECK(optixAccelBuild(world.context, nullptr, &options, &input, 1, temporary,
                          sizes.tempSizeInBytes, output, sizes.outputSizeInBytes, &handle, nullptr,
                          0));
    world.cuda.wait();
    return handle;
}

OptixTraversableHandle buildTriangles(World& world) {
    static CUdeviceptr vertices;
    vertices = world.cuda.upload<float>({9, 9, 9, 9, 9, 9, 9, 9, 10, // one without a hit
                                         -1, -1, 0, 3, -1, 0, -1, 3, 0});
    static const unsigned int flags[1] = {OPTIX_GEOMETRY_FLAG_NONE};
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    input.triangleArray.vertexBuffers = &vertices;
    input.triangleArray.numVertices = 6;
    input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    input.triangleArray.flags = flags;
    input.triangleArray.numSbtRecords = 1;
    return build(world, input, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
}

OptixTraversableHandle buildCustom(World& world) {
    static CUdeviceptr boxes;
    boxes = world.cuda.upload<OptixAabb>({{-1, -1, -1, 1, 1, 1}});
    static const unsigned int flags[1] = {OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT};
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input.customPrimitiveArray.aabbBuffers = &boxes;
    input.customPrimitiveArray.numPrimitives = 1;
    input.customPrimitiveArray.flags = flags;
    input.customPrimitiveArray.numSbtRecords = 1;
    return build(world, input, OPTIX_BUILD_FLAG_NONE);
}

OptixTraversableHandle buildInstance(World& world, OptixTraversableHandle child,
                                     unsigned int sbtOffset) {
    const OptixInstance other = {{1, 0, 0, 500, 0, 1, 0, 0, 0, 0, 1, 0}, 1, 0, 255, 0, child, {}};
    OptixInstance instance = {{1.2f, 0.1f, 0, 0.3f, -0.2f, 0.9f, 0.1f, 0.2f, 0, 0.3f, 1.1f, -0.4f},
                              42,
                              0,
                              255,
                              0,
                              child,
                              {}};
    instance.sbtOffset = sbtOffset;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input.instanceArray.instances = world.cuda.upload<OptixInstance>({other, instance});
    input.instanceArray.numInstances = 2;
    return build(world, input, OPTIX_BUILD_FLAG_NONE);
}

template <typename T>
OptixTraversableHandle convert(World& world, const T& transform, OptixTraversableType type) {
    const CUdeviceptr address = world.cuda.upload<T>({transform});
    OptixTraversableHandle handle = 0;
    CHECK(optixConvertPointerToTraversableHandle(world.context, address, type, &handle));
    return handle;
}

// Static over matrix motion over SRT motion over child.
OptixTraversableHandle buildChain(World& world, OptixTraversableHandle child) {
    OptixSRTMotionTransform srt = {};
    srt.child = child;
    srt.motionOptions = {2, OPTIX_MOTION_FLAG_NONE, 0.0f, 1.0f};
    const float c = std::cos(0.2f), s = std::sin(0.2f);
    srt.srtData[0] = {1, 0.1f, 0, 0.1f, 1, 0.2f, 0, 1, 0.3f, 0, 0, 0, 1, 0, 0.1f, 0};
    srt.srtData[1] = {1.3f, 0, 0.1f, 0.2f, 0.8f, 0, 0.1f, 1.1f, 0, 0, s, 0, c, 0.2f, 0, 0.1f};
    OptixMatrixMotionTransform matrix = {};
    matrix.child = convert(world, srt, OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM);
    matrix.motionOptions = {2, OPTIX_MOTION_FLAG_NONE, 0.25f, 0.75f};
    const float keys[2][12] = {{1, 0, 0.1f, 0, 0, 1, 0, 0.1f, 0.2f, 0, 1, 0},
                               {0.9f, 0.2f, 0, 0.1f, 0.1f, 1.2f, 0, 0, 0, 0.1f, 0.8f, 0.3f}};
    std::memcpy(matrix.transform, keys, sizeof(keys));
    OptixStaticTransform fixed = {};
    fixed.child = convert(world, matrix, OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM);
    const float forward[12] = {2, 0, 0, 0.5f, 0, 1, 0, 0, 0, 0, 4, 1};
    const float inverse[12] = {0.5f, 0, 0, -0.25f, 0, 1, 0, 0, 0, 0, 0.25f, -0.25f};
    std::memcpy(fixed.transform, forward, sizeof(forward));
    std::memcpy(fixed.invTransform, inverse, sizeof(inverse));
    return convert(world, fixed, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM);
}

OptixProgramGroup group(World& world, const OptixProgramGroupDesc& description) {
    OptixProgramGroupOptions options = {};
    OptixProgramGroup result = nullptr;
    CHECK(optixProgramGroupCreate(world.context, &description, 1, &options, nullptr, nullptr,
                                  &result));
    return result;
}

OptixProgramGroup single(World& world, OptixProgramGroupKind kind, OptixModule module,
                         const char* name) {
    OptixProgramGroupDesc description = {};
    description.kind = kind;
    description.raygen = {module, name};
    return group(world, description);
}

CUdeviceptr records(World& world, const std::vector<OptixProgramGroup>& groups) {
    std::vector<Record> all(groups.size());
    for (size_t i = 0; i < groups.size(); ++i) {
        CHECK(optixSbtRecordPackHeader(groups[i], all[i].header));
        all[i].data[0] = 4000;
    }
    return world.cuda.upload(all);
}

void createPipeline(World& world, const std::string& ptx, bool motion) {
    OptixModuleCompileOptions moduleOptions = {};
    OptixPipelineCompileOptions options = {};
    options.usesMotionBlur = motion;
    options.numPayloadValues = 32;
    options.numAttributeValues = 8;
    options.exceptionFlags = OPTIX_EXCEPTION_FLAG_USER;
    options.pipelineLaunchParamsVariableName = "params";
    OptixModule module = nullptr;
    CHECK(optixModuleCreateFromPTX(world.context, &moduleOptions, &options, ptx.data(), ptx.size(),
                                   nullptr, nullptr, &module));
    const OptixProgramGroup rg =
        single(world, OPTIX_PROGRAM_GROUP_KIND_RAYGEN, module, "__raygen__interop");
    const OptixProgramGroup ms =
        single(world, OPTIX_PROGRAM_GROUP_KIND_MISS, module, "__miss__interop");
    const OptixProgramGroup ex =
        single(world, OPTIX_PROGRAM_GROUP_KIND_EXCEPTION, module, "__exception__interop");
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
    description.hitgroup = {module, "__closesthit__interop", module, "__anyhit__interop", nullptr,
                            nullptr};
    const OptixProgramGroup triangles = group(world, description);
    description.hitgroup = {module, "__closesthit__custom",   nullptr, nullptr,
                            module, "__intersection__interop"};
    const OptixProgramGroup custom = group(world, description);
    description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
    description.callables = {module, "__direct_callable__interop", nullptr, nullptr};
    const OptixProgramGroup callable = group(world, description);

    const std::vector<OptixProgramGroup> groups = {rg, ms, ex, triangles, custom, callable};
    OptixPipelineLinkOptions link = {1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
    CHECK(optixPipelineCreate(world.context, &options, &link, groups.data(),
                              unsigned(groups.size()), nullptr, nullptr, &world.pipeline));
    OptixStackSizes sizes = {};
    for (OptixProgramGroup g : groups)
        CHECK(optixUtilAccumulateStackSizes(g, &sizes));
    unsigned int traversal = 0, state = 0, continuation = 0;
    CHECK(optixUtilComputeStackSizes(&sizes, 1, 0, 1, &traversal, &state, &continuation));
    CHECK(optixPipelineSetStackSize(world.pipeline, traversal, state, continuation, 5));

    world.sbt = {};
    world.sbt.raygenRecord = records(world, {rg});
    world.sbt.exceptionRecord = records(world, {ex});
    world.sbt.missRecordBase = records(world, {ms});
    world.sbt.missRecordStrideInBytes = sizeof(Record);
    world.sbt.missRecordCount = 1;
    world.sbt.hitgroupRecordBase = records(world, {triangles, custom});
    world.sbt.hitgroupRecordStrideInBytes = sizeof(Record);
    world.sbt.hitgroupRecordCount = 2;
    world.sbt.callablesRecordBase = records(world, {callable});
    world.sbt.callablesRecordStrideInBytes = sizeof(Record);
    world.sbt.callablesRecordCount = 1;
}

Result launch(World& world, Params params) {
    Result result = {};
    world.cuda.copyIn(world.result, &result, sizeof(result));
    params.result = reinterpret_cast<Result*>(world.result);
    world.cuda.copyIn(world.params, &params, sizeof(params));
    CHECK(optixLaunch(world.pipeline, nullptr, world.params, sizeof(params), &world.sbt, 1, 1, 1));
    world.cuda.wait();
    world.cuda.copyOut(&result, world.result, sizeof(result));
    return result;
}

bool near(const float* a, const float* b, int count, float tolerance) {
    for (int i = 0; i < count; ++i)
        if (!(std::fabs(a[i] - b[i]) <= tolerance * (1.0f + std::fabs(b[i]))))
            return false;
    return true;
}

void apply(const float* m, const float* p, float w, float* result) {
    for (int row = 0; row < 3; ++row)
        result[row] =
            m[4 * row] * p[0] + m[4 * row + 1] * p[1] + m[4 * row + 2] * p[2] + m[4 * row + 3] * w;
}

// Conditions for every hit on the second triangle, with any transforms.
void checkHit(const Params& params, const Result& r, const std::vector<unsigned int>& types) {
    expect(r.hits == 1 && r.misses == 0, "one hit");
    expect(r.primitive == 1, "primitive index");
    expect(r.payload[0] == 101 && r.payload[7] == 114 && r.payload[31] == 262 &&
               r.payload[1] == 101 && r.payload[30] == 130,
           "payload");
    expect(r.called == 10.5f, "direct callable");
    expect(r.sbtData == 4000, "SBT data and launch size");
    expect(r.listSize == types.size() &&
               std::equal(types.begin(), types.end(), r.listTypes),
           "transform list");
    const float vertices[9] = {-1, -1, 0, 3, -1, 0, -1, 3, 0};
    expect(near(r.vertices, vertices, 9, 0.0f), "vertex data");
    expect(near(r.rayComputed, r.rayObject, 6, 1e-5f), "object-space ray");
    expect(near(r.pointBack, params.origin, 3, 1e-5f), "world to object and back");
    float world[3], object[3], expected[3], product[3];
    for (int i = 0; i < 3; ++i)
        world[i] = params.origin[i] + r.t * params.direction[i];
    apply(r.worldToObject, world, 1.0f, object);
    const float u = r.barycentrics[0], v = r.barycentrics[1];
    for (int i = 0; i < 3; ++i)
        expected[i] = (1 - u - v) * vertices[i] + u * vertices[3 + i] + v * vertices[6 + i];
    expect(near(object, expected, 3, 1e-5f), "hit point from barycentrics");
    // A normal is perpendicular to transformed edges.
    for (int edge = 1; edge <= 2; ++edge) {
        const float e[3] = {edge == 1 ? 1.0f : 0.0f, edge == 2 ? 1.0f : 0.0f, 0.0f};
        apply(r.objectToWorld, e, 0.0f, product);
        expect(std::fabs(product[0] * r.normalWorld[0] + product[1] * r.normalWorld[1] +
                         product[2] * r.normalWorld[2]) < 1e-5f,
               "normal");
    }
}

void run(World& world, const std::string& ptx) {
    Params params = {0, nullptr, {0.3f, 0.2f, 20.0f}, {0.01f, -0.02f, -1.0f}, 0.0f, kModeTriangle};
    const OptixTraversableHandle gas = buildTriangles(world);

    std::printf("geometry alone\n");
    createPipeline(world, ptx, false);
    params.handle = gas;
    Result r = launch(world, params);
    checkHit(params, r, {});
    expect(r.front == 1 && r.hitKind == OPTIX_HIT_KIND_TRIANGLE_FRONT_FACE, "front face");
    expect(r.instanceId == ~0u && r.instanceIndex == 0, "no instance");

    std::printf("miss\n");
    params.direction[2] = 1.0f;
    r = launch(world, params);
    expect(r.hits == 0 && r.misses == 1 && r.payload[7] == 107, "miss");
    params.direction[2] = -1.0f;

    std::printf("instance\n");
    params.handle = buildInstance(world, gas, 0);
    r = launch(world, params);
    checkHit(params, r, {OPTIX_TRANSFORM_TYPE_INSTANCE});
    expect(r.instanceId == 42 && r.instanceIndex == 1, "instance numbers");

    std::printf("custom primitive\n");
    params.handle = buildInstance(world, buildCustom(world), 1);
    params.mode = kModeCustom;
    r = launch(world, params);
    expect(r.hits == 1 && r.t == 1.5f && r.hitKind == 9 && r.attributes == 87654321, "attributes");

    std::printf("motion\n");
    params.mode = kModeTriangle;
    params.handle = buildInstance(world, buildChain(world, gas), 0);
    createPipeline(world, ptx, true);
    for (float time : {-1.0f, 0.0f, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 1.0f, 2.0f}) {
        params.time = time;
        checkHit(params, launch(world, params),
                 {OPTIX_TRANSFORM_TYPE_INSTANCE, OPTIX_TRANSFORM_TYPE_STATIC_TRANSFORM,
                  OPTIX_TRANSFORM_TYPE_MATRIX_MOTION_TRANSFORM,
                  OPTIX_TRANSFORM_TYPE_SRT_MOTION_TRANSFORM});
    }

    std::printf("exception\n");
    params.mode = kModeThrow;
    r = launch(world, params);
    expect(r.exceptionCode == 77 && r.exceptionDetails[0] == 1234 && r.exceptionDetails[1] == 5678,
           "user exception");
}

} // namespace

int main(int argc, char** argv) {
    setvbuf(stdout, nullptr, _IOLBF, 0); // output before a crash must not be lost
    if (argc != 2)
        return 2;
    std::ifstream file(argv[1]);
    const std::string ptx((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    World world;
    const OptixResult loaded = optixInit();
    if (loaded == OPTIX_ERROR_LIBRARY_NOT_FOUND)
        quit(77, "[SKIP] no libnvoptix.so.1");
    CHECK(loaded);
    OptixDeviceContextOptions options = {log, nullptr, 4, OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_OFF};
    CHECK(optixDeviceContextCreate(nullptr, &options, &world.context));
    unsigned int rtcore = 0;
    CHECK(optixDeviceContextGetProperty(world.context, OPTIX_DEVICE_PROPERTY_RTCORE_VERSION,
                                        &rtcore, sizeof(rtcore)));
    std::printf("RT core version %u\n", rtcore);
    world.result = world.cuda.allocate(sizeof(Result));
    world.params = world.cuda.allocate(sizeof(Params));
    run(world, ptx);
    std::printf("%d errors\n", gErrors);
    return gErrors == 0 ? 0 : 1;
}
