// SPDX-License-Identifier: Apache-2.0
#include "optix_setup.h"

#include <optix_stack_size.h>

#include <cstdio>

namespace {

void printLog(unsigned level, const char* tag, const char* message, void*) {
    std::fprintf(stderr, "[%u][%s] %s\n", level, tag, message);
}

} // namespace

OptixDeviceContext createContext() {
    CUDA_CHECK(cudaFree(nullptr)); // makes the device's CUDA context current
    OPTIX_CHECK(optixInit());
    OptixDeviceContextOptions options = {};
    options.logCallbackFunction = printLog;
    options.logCallbackLevel = 3; // fatal, error, warning
    OptixDeviceContext context = nullptr;
    OPTIX_CHECK(optixDeviceContextCreate(nullptr, &options, &context));
    return context;
}

Program::Program(OptixDeviceContext context, std::string_view ptx, unsigned payloadValues,
                 unsigned attributeValues, unsigned primitiveTypeFlags, const char* launchParams,
                 unsigned graphFlags, bool opacityMicromaps, bool motionBlur)
    : context_(context) {
    moduleOptions_.optLevel = OPTIX_COMPILE_OPTIMIZATION_DEFAULT;
    moduleOptions_.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL;
    options_.traversableGraphFlags = graphFlags;
    options_.usesMotionBlur = motionBlur;
    options_.numPayloadValues = int(payloadValues);
    options_.numAttributeValues = int(attributeValues);
    options_.exceptionFlags = OPTIX_EXCEPTION_FLAG_NONE;
    options_.pipelineLaunchParamsVariableName = launchParams;
    options_.usesPrimitiveTypeFlags = primitiveTypeFlags;
#if OPTIX_VERSION >= 70600
    options_.allowOpacityMicromaps = opacityMicromaps;
#else
    if (opacityMicromaps)
        throw std::runtime_error("opacity micromaps need a program built for OptiX 7.6");
#endif
    OPTIX_CHECK(optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, ptx.data(),
                                         ptx.size(), nullptr, nullptr, &module_));
}

Program::~Program() {
    if (pipeline_)
        optixPipelineDestroy(pipeline_);
    for (OptixProgramGroup group : groups_)
        optixProgramGroupDestroy(group);
    for (OptixModule module : builtinModules_)
        optixModuleDestroy(module);
    optixModuleDestroy(module_);
}

OptixProgramGroup Program::add(const OptixProgramGroupDesc& description) {
    OptixProgramGroupOptions options = {};
    OptixProgramGroup group = nullptr;
    OPTIX_CHECK(
        optixProgramGroupCreate(context_, &description, 1, &options, nullptr, nullptr, &group));
    groups_.push_back(group);
    return group;
}

OptixProgramGroup Program::addRaygen(const char* function) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    description.raygen.module = module_;
    description.raygen.entryFunctionName = function;
    return add(description);
}

OptixProgramGroup Program::addMiss(const char* function) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
    description.miss.module = module_;
    description.miss.entryFunctionName = function;
    return add(description);
}

OptixProgramGroup Program::addHitgroup(const char* closestHit, const char* anyHit,
                                       const char* intersection) {
    return addHitgroup(closestHit, anyHit, intersection ? module_ : nullptr, intersection);
}

OptixProgramGroup Program::addBuiltinHitgroup(const char* closestHit, const char* anyHit,
                                              OptixPrimitiveType type) {
    OptixBuiltinISOptions builtin = {};
    builtin.builtinISModuleType = type;
    builtin.usesMotionBlur = options_.usesMotionBlur;
    OptixModule module = nullptr;
    OPTIX_CHECK(optixBuiltinISModuleGet(context_, &moduleOptions_, &options_, &builtin, &module));
    builtinModules_.push_back(module);
    return addHitgroup(closestHit, anyHit, module, nullptr);
}

OptixProgramGroup Program::addHitgroup(const char* closestHit, const char* anyHit,
                                       OptixModule intersectionModule, const char* intersection) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
    description.hitgroup.moduleCH = closestHit ? module_ : nullptr;
    description.hitgroup.entryFunctionNameCH = closestHit;
    description.hitgroup.moduleAH = anyHit ? module_ : nullptr;
    description.hitgroup.entryFunctionNameAH = anyHit;
    description.hitgroup.moduleIS = intersectionModule;
    description.hitgroup.entryFunctionNameIS = intersection;
    return add(description);
}

OptixProgramGroup Program::addCallables(const char* direct, const char* continuation) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
    description.callables.moduleDC = direct ? module_ : nullptr;
    description.callables.entryFunctionNameDC = direct;
    description.callables.moduleCC = continuation ? module_ : nullptr;
    description.callables.entryFunctionNameCC = continuation;
    hasCallables_ = true;
    return add(description);
}

OptixPipeline Program::link(unsigned maxTraceDepth, unsigned maxGraphDepth) {
    OptixPipelineLinkOptions linkOptions = {};
    linkOptions.maxTraceDepth = maxTraceDepth;
    linkOptions.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL;
    OPTIX_CHECK(optixPipelineCreate(context_, &options_, &linkOptions, groups_.data(),
                                    unsigned(groups_.size()), nullptr, nullptr, &pipeline_));

    OptixStackSizes sizes = {};
    for (OptixProgramGroup group : groups_)
        OPTIX_CHECK(optixUtilAccumulateStackSizes(group, &sizes));
    unsigned fromTraversal = 0, fromState = 0, continuation = 0;
    unsigned callableDepth = hasCallables_ ? 1 : 0;
    OPTIX_CHECK(optixUtilComputeStackSizes(&sizes, maxTraceDepth, callableDepth, callableDepth,
                                           &fromTraversal, &fromState, &continuation));
    OPTIX_CHECK(optixPipelineSetStackSize(pipeline_, fromTraversal, fromState, continuation,
                                          maxGraphDepth));
    return pipeline_;
}

Accel buildAccel(OptixDeviceContext context, const OptixBuildInput& input,
                 const OptixMotionOptions& motion, unsigned flags) {
    OptixAccelBuildOptions options = {};
    options.buildFlags = OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE |
                         flags;
    options.operation = OPTIX_BUILD_OPERATION_BUILD;
    options.motionOptions = motion;
    OptixAccelBufferSizes sizes = {};
    OPTIX_CHECK(optixAccelComputeMemoryUsage(context, &options, &input, 1, &sizes));

    DeviceBuffer temporary(sizes.tempSizeInBytes);
    DeviceBuffer output(sizes.outputSizeInBytes);
    DeviceBuffer compactedSize(sizeof(uint64_t));
    OptixAccelEmitDesc emit = {};
    emit.result = compactedSize.address();
    emit.type = OPTIX_PROPERTY_TYPE_COMPACTED_SIZE;
    OptixTraversableHandle handle = 0;
    OPTIX_CHECK(optixAccelBuild(context, nullptr, &options, &input, 1, temporary.address(),
                                temporary.size(), output.address(), output.size(), &handle, &emit,
                                1));
    CUDA_CHECK(cudaDeviceSynchronize());

    Accel accel;
    size_t smaller = size_t(compactedSize.download<uint64_t>()[0]);
    if (smaller < output.size()) {
        accel.memory.allocate(smaller);
        OPTIX_CHECK(optixAccelCompact(context, nullptr, handle, accel.memory.address(),
                                      accel.memory.size(), &accel.handle));
        CUDA_CHECK(cudaDeviceSynchronize());
    } else {
        accel.handle = handle;
        accel.memory = std::move(output);
    }
    return accel;
}

Accel buildInstances(OptixDeviceContext context, const std::vector<OptixInstance>& instances,
                     const OptixMotionOptions& motion) {
    DeviceBuffer deviceInstances;
    deviceInstances.upload(instances);
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input.instanceArray.instances = deviceInstances.address();
    input.instanceArray.numInstances = unsigned(instances.size());
    return buildAccel(context, input, motion);
}
