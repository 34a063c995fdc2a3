// SPDX-License-Identifier: Apache-2.0
// PTX to a pipeline, as applications do it, and its shader binding table.
#include "job.h"

#include <optix_stack_size.h>

#include <chrono>
#include <cstring>

namespace bench {

JobPipeline::JobPipeline(OptixDeviceContext context, const Job& job) : context_(context) {
    const auto start = std::chrono::steady_clock::now();
    createModule(job);
    createGroups(job);
    link(job);
    compileTime_ =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    makeTable(job);
    params_.allocate(sizeof(ProgramParams));
}

JobPipeline::~JobPipeline() {
    if (pipeline_)
        optixPipelineDestroy(pipeline_);
    for (OptixProgramGroup group : groups_)
        optixProgramGroupDestroy(group);
    for (OptixModule module : builtins_)
        optixModuleDestroy(module);
    if (module_)
        optixModuleDestroy(module_);
}

void JobPipeline::createModule(const Job& job) {
    moduleOptions_.optLevel = OPTIX_COMPILE_OPTIMIZATION_DEFAULT;
    moduleOptions_.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL;
    for (const auto& semantics : job.payloadTypes)
        payloadTypes_.push_back({unsigned(semantics.size()), semantics.data()});
    moduleOptions_.numPayloadTypes = unsigned(payloadTypes_.size());
    moduleOptions_.payloadTypes = payloadTypes_.data();
    options_.usesMotionBlur = job.moves;
    options_.traversableGraphFlags = job.graph;
    options_.numPayloadValues = job.payloadTypes.empty() ? int(job.payloadValues) : 0;
    options_.numAttributeValues = int(job.attributeValues);
    options_.exceptionFlags = OPTIX_EXCEPTION_FLAG_NONE;
    options_.pipelineLaunchParamsVariableName = "params";
    options_.usesPrimitiveTypeFlags = job.primitives;
    options_.allowOpacityMicromaps = job.micromaps;
    OPTIX_CHECK(optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, job.ptx.data(),
                                         job.ptx.size(), nullptr, nullptr, &module_));
}

OptixProgramGroup JobPipeline::add(const OptixProgramGroupDesc& description, unsigned payloadType) {
    OptixProgramGroupOptions options = {};
    if (payloadType)
        options.payloadType = &payloadTypes_[payloadType - 1];
    OptixProgramGroup group = nullptr;
    OPTIX_CHECK(
        optixProgramGroupCreate(context_, &description, 1, &options, nullptr, nullptr, &group));
    groups_.push_back(group);
    return group;
}

OptixProgramGroup JobPipeline::single(OptixProgramGroupKind kind, const char* function) {
    OptixProgramGroupDesc description = {};
    description.kind = kind;
    // Ray generation and miss programs have the same place in the union.
    description.raygen = {module_, function};
    return add(description);
}

OptixModule JobPipeline::builtin(unsigned type) {
    OptixBuiltinISOptions builtin = {};
    builtin.builtinISModuleType = OptixPrimitiveType(type);
    builtin.usesMotionBlur = options_.usesMotionBlur;
    builtin.buildFlags =
        OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
    OptixModule module = nullptr;
    OPTIX_CHECK(optixBuiltinISModuleGet(context_, &moduleOptions_, &options_, &builtin, &module));
    builtins_.push_back(module);
    return module;
}

void JobPipeline::createGroups(const Job& job) {
    single(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, job.raygen);
    for (const char* miss : job.misses)
        single(OPTIX_PROGRAM_GROUP_KIND_MISS, miss);
    for (const HitGroup& hit : job.hits) {
        OptixProgramGroupDesc description = {};
        description.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        OptixProgramGroupHitgroup& h = description.hitgroup;
        h.moduleCH = hit.closestHit ? module_ : nullptr;
        h.entryFunctionNameCH = hit.closestHit;
        h.moduleAH = hit.anyHit ? module_ : nullptr;
        h.entryFunctionNameAH = hit.anyHit;
        h.moduleIS = hit.builtin ? builtin(hit.builtin) : hit.intersection ? module_ : nullptr;
        h.entryFunctionNameIS = hit.intersection;
        add(description, hit.payloadType);
    }
    for (const std::string& callable : job.callables) {
        OptixProgramGroupDesc description = {};
        description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
        description.callables.moduleDC = module_;
        description.callables.entryFunctionNameDC = callable.c_str();
        add(description);
    }
}

void JobPipeline::link(const Job& job) {
    OptixPipelineLinkOptions options = {};
    options.maxTraceDepth = job.traceDepth;
    options.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL;
    OPTIX_CHECK(optixPipelineCreate(context_, &options_, &options, groups_.data(),
                                    unsigned(groups_.size()), nullptr, nullptr, &pipeline_));
    OptixStackSizes sizes = {};
    for (OptixProgramGroup group : groups_)
        OPTIX_CHECK(optixUtilAccumulateStackSizes(group, &sizes));
    const unsigned callableDepth = job.callables.empty() ? 0 : 1;
    unsigned fromTraversal = 0, fromState = 0, continuation = 0;
    OPTIX_CHECK(optixUtilComputeStackSizes(&sizes, job.traceDepth, callableDepth, callableDepth,
                                           &fromTraversal, &fromState, &continuation));
    OPTIX_CHECK(optixPipelineSetStackSize(pipeline_, fromTraversal, fromState, continuation,
                                          job.graphDepth));
}

void JobPipeline::makeTable(const Job& job) {
    auto group = groups_.begin();
    const auto raygen = makeRecord(*group++);
    raygen_.upload(&raygen, sizeof(raygen));
    std::vector<SbtRecord<NoData>> misses, callables;
    for (size_t i = 0; i < job.misses.size(); ++i)
        misses.push_back(makeRecord(*group++));
    std::vector<SbtRecord<Look>> hits;
    for (const HitRecord& record : job.records)
        hits.push_back(makeRecord(group[record.group], record.material));
    group += long(job.hits.size());
    for (; group != groups_.end(); ++group)
        callables.push_back(makeRecord(*group));
    misses_.upload(misses);
    hits_.upload(hits);
    callables_.upload(callables);
    table_.raygenRecord = raygen_.address();
    table_.missRecordBase = misses_.address();
    table_.missRecordStrideInBytes = sizeof(misses[0]);
    table_.missRecordCount = unsigned(misses.size());
    table_.hitgroupRecordBase = hits_.address();
    table_.hitgroupRecordStrideInBytes = sizeof(hits[0]);
    table_.hitgroupRecordCount = unsigned(hits.size());
    if (callables.empty())
        return;
    table_.callablesRecordBase = callables_.address();
    table_.callablesRecordStrideInBytes = sizeof(callables[0]);
    table_.callablesRecordCount = unsigned(callables.size());
}

void JobPipeline::launch(const ProgramParams& params, unsigned width, unsigned height) {
    CUDA_CHECK(
        cudaMemcpyAsync(params_.data(), &params, sizeof(params), cudaMemcpyHostToDevice, nullptr));
    OPTIX_CHECK(optixLaunch(pipeline_, nullptr, params_.address(), sizeof(params), &table_, width,
                            height, 1));
}

} // namespace bench
