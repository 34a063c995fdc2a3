// SPDX-License-Identifier: Apache-2.0
// A whole OptiX program in the style of SDK samples: NVRTC compiles its device code at run time
// with the headers of OptiX and of CUDA. sdk_style OPTIX_INCLUDE [CUDA_INCLUDE]
#include <cuda_runtime.h>
#include <nvrtc.h>
#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#define CHECK(call)                                                                                \
    do {                                                                                           \
        if (const int code = int(call)) {                                                          \
            std::printf("%s: %d\n", #call, code);                                                  \
            std::exit(1);                                                                          \
        }                                                                                          \
    } while (0)

static const char* const kParamsHeader = R"(
struct Params { unsigned int* image; unsigned int width; };
)";

static const char* const kDeviceCode = R"(
#include <optix.h>
#include <cuda_runtime.h>
#include <vector_types.h>
#include "params.h"

extern "C" {
__constant__ Params params;
}
struct Data { unsigned int factor; };

static __forceinline__ __device__ unsigned int squared(unsigned int x) { return x * x; }

extern "C" __global__ void __raygen__squares() {
    const uint3 index = optixGetLaunchIndex();
    const Data* data = reinterpret_cast<const Data*>(optixGetSbtDataPointer());
    const unsigned int more = optixDirectCall<unsigned int, unsigned int>(0, index.x);
    params.image[index.y * params.width + index.x] = squared(index.x) * data->factor + index.y + more;
}
extern "C" __device__ unsigned int __direct_callable__more(unsigned int x) { return 1000 * x; }
extern "C" __global__ void __miss__none() {}
)";

static std::string compile(int argc, char** argv) {
    const char *text = kParamsHeader, *name = "params.h";
    nvrtcProgram program = nullptr;
    CHECK(nvrtcCreateProgram(&program, kDeviceCode, "squares.cu", 1, &text, &name));
    std::vector<std::string> words = {"-I" + std::string(argv[1])};
    if (argc > 2)
        words.push_back("-I" + std::string(argv[2]));
    for (const char* word : {"-arch", "compute_60", "-use_fast_math", "-lineinfo",
                             "-default-device", "-rdc", "true", "-D__x86_64"})
        words.push_back(word);
    std::vector<const char*> options;
    for (const std::string& word : words)
        options.push_back(word.c_str());
    const nvrtcResult result = nvrtcCompileProgram(program, int(options.size()), options.data());
    size_t size = 0;
    CHECK(nvrtcGetProgramLogSize(program, &size));
    std::string log(size, ' '), ptx;
    CHECK(nvrtcGetProgramLog(program, log.data()));
    if (size > 1)
        std::printf("%s\n", log.c_str());
    CHECK(result);
    CHECK(nvrtcGetPTXSize(program, &size));
    ptx.resize(size);
    CHECK(nvrtcGetPTX(program, ptx.data()));
    CHECK(nvrtcDestroyProgram(&program));
    return ptx;
}

struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) Record {
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    unsigned int factor;
};

template <class T>
static CUdeviceptr upload(const T& value) {
    void* memory = nullptr;
    CHECK(cudaMalloc(&memory, sizeof value));
    CHECK(cudaMemcpy(memory, &value, sizeof value, cudaMemcpyHostToDevice));
    return reinterpret_cast<CUdeviceptr>(memory);
}

static CUdeviceptr record(OptixProgramGroup group, unsigned int factor) {
    Record made = {};
    made.factor = factor;
    CHECK(optixSbtRecordPackHeader(group, &made));
    return upload(made);
}

int main(int argc, char** argv) {
    if (argc < 2)
        return 2;
    const std::string ptx = compile(argc, argv);
    CHECK(cudaFree(nullptr));
    CHECK(optixInit());
    OptixDeviceContext context = nullptr;
    CHECK(optixDeviceContextCreate(0, nullptr, &context));
    OptixModuleCompileOptions moduleOptions = {};
    OptixPipelineCompileOptions pipelineOptions = {};
    pipelineOptions.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    pipelineOptions.pipelineLaunchParamsVariableName = "params";
    OptixModule module = nullptr;
    CHECK(optixModuleCreateFromPTX(context, &moduleOptions, &pipelineOptions, ptx.c_str(),
                                   ptx.size(), nullptr, nullptr, &module));
    OptixProgramGroupDesc descs[3] = {};
    descs[0].kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    descs[0].raygen = {module, "__raygen__squares"};
    descs[1].kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
    descs[1].miss = {module, "__miss__none"};
    descs[2].kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
    descs[2].callables.moduleDC = module;
    descs[2].callables.entryFunctionNameDC = "__direct_callable__more";
    OptixProgramGroupOptions groupOptions = {};
    OptixProgramGroup groups[3] = {};
    CHECK(optixProgramGroupCreate(context, descs, 3, &groupOptions, nullptr, nullptr, groups));
    OptixPipelineLinkOptions linkOptions = {};
    linkOptions.maxTraceDepth = 1;
    OptixPipeline pipeline = nullptr;
    CHECK(optixPipelineCreate(context, &pipelineOptions, &linkOptions, groups, 3, nullptr, nullptr,
                              &pipeline));
    OptixShaderBindingTable table = {};
    table.raygenRecord = record(groups[0], 2);
    table.missRecordBase = record(groups[1], 0);
    table.callablesRecordBase = record(groups[2], 0);
    table.missRecordStrideInBytes = table.callablesRecordStrideInBytes = sizeof(Record);
    table.missRecordCount = table.callablesRecordCount = 1;

    constexpr unsigned kWidth = 8, kHeight = 3;
    struct {
        unsigned* image;
        unsigned width;
    } params = {nullptr, kWidth};
    CHECK(cudaMalloc(reinterpret_cast<void**>(&params.image), kWidth * kHeight * 4));
    CHECK(
        optixLaunch(pipeline, nullptr, upload(params), sizeof params, &table, kWidth, kHeight, 1));
    unsigned image[kWidth * kHeight] = {};
    CHECK(cudaMemcpy(image, params.image, sizeof image, cudaMemcpyDeviceToHost));
    for (unsigned y = 0; y < kHeight; ++y)
        for (unsigned x = 0; x < kWidth; ++x)
            if (image[y * kWidth + x] != 2 * x * x + y + 1000 * x)
                return std::printf("(%u, %u) is %u\n", x, y, image[y * kWidth + x]), 1;
    std::printf("all %u pixels are right\n", kWidth * kHeight);
    return 0;
}
