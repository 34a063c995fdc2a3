// SPDX-License-Identifier: Apache-2.0
// Pipelines and launches (OptiX 7.4, sections 3.5 and 3.9).
#include "api/optix7/entry_points.h"
#include "api/optix7/options.h"
#include "engine/launch.h"

#include <vector>

namespace sunstone::optix7 {
namespace {

// The manual permits a stride of 0 for the other tables.
constexpr const char* kCallables = "callables";

void checkRecords(const ApiCall& call, const char* what, CUdeviceptr base, unsigned stride,
                  unsigned count) {
    if (base % OPTIX_SBT_RECORD_ALIGNMENT != 0)
        fail(Code::kInvalidValue, "sbt->", what, "RecordBase = ", reinterpret_cast<void*>(base),
             " is not a multiple of ", unsigned(OPTIX_SBT_RECORD_ALIGNMENT));
    if (base == 0 && count != 0)
        fail(Code::kInvalidValue, "sbt->", what, "RecordBase is 0, but ", what, "RecordCount is ",
             count);
    if (base == 0)
        return;
    if (count == 0)
        tolerate(call, "there are no such records", "sbt->", what, "RecordBase is set, but ", what,
                 "RecordCount is 0");
    const auto wrong = [&](const auto&... reason) {
        if (count > 1)
            fail(Code::kInvalidValue, "sbt->", what, "RecordStrideInBytes = ", stride, reason...);
        tolerate(call, "the table has no second record", "sbt->", what,
                 "RecordStrideInBytes = ", stride, reason...);
    };
    if (stride == 0 && (count > 1 || what == kCallables))
        wrong(" for ", count, " records");
    else if (stride % OPTIX_SBT_RECORD_ALIGNMENT != 0)
        wrong(" is not a multiple of ", unsigned(OPTIX_SBT_RECORD_ALIGNMENT));
    else if (stride != 0 && stride < OPTIX_SBT_RECORD_HEADER_SIZE)
        wrong(" is less than the record header of ", unsigned(OPTIX_SBT_RECORD_HEADER_SIZE));
}

void checkAccessible(device::Device& device, const char* what, CUdeviceptr address, uint64_t size) {
    if (address && !device.isAccessible(reinterpret_cast<const void*>(address), size))
        fail(Code::kInvalidValue, what, " = ", reinterpret_cast<void*>(address), " with ", size,
             " bytes is not device memory");
}

devlib::SbtView checkSbt(const ApiCall& call, const OptixShaderBindingTable& sbt) {
    device::Device& device = *call.context.engine->device;
    if (sbt.raygenRecord == 0)
        fail(Code::kInvalidValue, "sbt->raygenRecord is 0");
    for (const auto& [name, record] : {std::pair("sbt->raygenRecord", sbt.raygenRecord),
                                       std::pair("sbt->exceptionRecord", sbt.exceptionRecord)})
        if (record % OPTIX_SBT_RECORD_ALIGNMENT != 0)
            fail(Code::kInvalidValue, name, " = ", reinterpret_cast<void*>(record),
                 " is not a multiple of ", unsigned(OPTIX_SBT_RECORD_ALIGNMENT));
    checkRecords(call, "miss", sbt.missRecordBase, sbt.missRecordStrideInBytes,
                 sbt.missRecordCount);
    checkRecords(call, "hitgroup", sbt.hitgroupRecordBase, sbt.hitgroupRecordStrideInBytes,
                 sbt.hitgroupRecordCount);
    checkRecords(call, kCallables, sbt.callablesRecordBase, sbt.callablesRecordStrideInBytes,
                 sbt.callablesRecordCount);
    auto bytes = [](unsigned stride, unsigned count) -> uint64_t {
        return count == 0 ? 0 : uint64_t(stride) * (count - 1) + OPTIX_SBT_RECORD_HEADER_SIZE;
    };
    constexpr uint64_t kHeader = OPTIX_SBT_RECORD_HEADER_SIZE;
    checkAccessible(device, "sbt->raygenRecord", sbt.raygenRecord, kHeader);
    checkAccessible(device, "sbt->exceptionRecord", sbt.exceptionRecord, kHeader);
    checkAccessible(device, "sbt->missRecordBase", sbt.missRecordBase,
                    bytes(sbt.missRecordStrideInBytes, sbt.missRecordCount));
    checkAccessible(device, "sbt->hitgroupRecordBase", sbt.hitgroupRecordBase,
                    bytes(sbt.hitgroupRecordStrideInBytes, sbt.hitgroupRecordCount));
    checkAccessible(device, "sbt->callablesRecordBase", sbt.callablesRecordBase,
                    bytes(sbt.callablesRecordStrideInBytes, sbt.callablesRecordCount));
    devlib::SbtView view{};
    view.entryRecord = sbt.raygenRecord;
    view.exceptionRecord = sbt.exceptionRecord;
    view.missBase = sbt.missRecordBase;
    view.missStride = sbt.missRecordStrideInBytes;
    view.missCount = sbt.missRecordCount;
    view.hitBase = sbt.hitgroupRecordBase;
    view.hitStride = sbt.hitgroupRecordStrideInBytes;
    view.hitCount = sbt.hitgroupRecordCount;
    view.callableBase = sbt.callablesRecordBase;
    view.callableStride = sbt.callablesRecordStrideInBytes;
    view.callableCount = sbt.callablesRecordCount;
    return view;
}

void checkSameOptions(const CompileOptions& wanted, const GroupObject& group, unsigned index) {
    for (const std::shared_ptr<ModuleObject>& module : group.modules)
        if (!(module->options == wanted))
            fail(Code::kLinkError, "programGroups[", index, "] uses a module made with other "
                 "pipeline compile options");
}

// Creates a pipeline; forceMotionBlur: its rays have a time even if the modules have no motion
// blur.
OptixResult makePipeline(OptixDeviceContext context,
                           const OptixPipelineCompileOptions* compileOptions,
                           const OptixPipelineLinkOptions* linkOptions, bool forceMotionBlur,
                           const OptixProgramGroup* programGroups, unsigned count, char* logString,
                           size_t* logStringSize, OptixPipeline* pipeline) {
    std::string feedback;
    std::shared_ptr<DeviceContext> owner = peek(context);
    OptixResult result = guarded(owner, "optixPipelineCreate", [&] {
        contextOf(context);
        requireNonNull(pipeline, "pipeline");
        *pipeline = nullptr;
        CompileOptions options = checkCompileOptions(compileOptions, owner->abi);
        requireNonNull(linkOptions, "pipelineLinkOptions");
        if (linkOptions->maxTraceDepth > Limits::kTraceDepth)
            fail(Code::kInvalidValue, "pipelineLinkOptions->maxTraceDepth = ",
                 linkOptions->maxTraceDepth, " is above ", Limits::kTraceDepth);
        checkDebugLevel(linkOptions->debugLevel, "pipelineLinkOptions", owner->abi);
        if (count == 0)
            fail(Code::kInvalidValue, "numProgramGroups is 0");
        requireNonNull(programGroups, "programGroups");
        std::vector<std::shared_ptr<engine::ProgramGroup>> members;
        for (unsigned i = 0; i < count; ++i) {
            std::shared_ptr<GroupObject> group =
                groupOf(programGroups[i], message("programGroups[", i, "]").c_str());
            if (group->context != owner)
                fail(Code::kInvalidValue, "programGroups[", i,
                     "] belongs to another device context");
            checkSameOptions(options, *group, i);
            members.push_back(group->group);
        }
        engine::PipelineLimits limits;
        limits.maxTraceDepth = linkOptions->maxTraceDepth;
        limits.opacityMicromaps = options.values.allowOpacityMicromaps;
        compiler::PipelineRules rules = owner->rulesOf(options);
        rules.motionBlur |= forceMotionBlur;
        auto object = std::make_shared<PipelineObject>();
        object->context = owner;
        object->pipeline =
            engine::createPipeline(*owner->engine, members, rules, limits);
        if (!object->pipeline->feedback.empty()) {
            feedback += object->pipeline->feedback;
            owner->log(LogLevel::kInfo, "COMPILER", object->pipeline->feedback);
        }
        *pipeline = static_cast<OptixPipeline>(pipelines().add(object));
    }, &feedback);
    writeLogString(feedback, logString, logStringSize);
    return result;
}

} // namespace

OptixResult pipelineCreate(OptixDeviceContext context,
                           const OptixPipelineCompileOptions* compileOptions,
                           const OptixPipelineLinkOptions* linkOptions,
                           const OptixProgramGroup* programGroups, unsigned count, char* logString,
                           size_t* logStringSize, OptixPipeline* pipeline) {
    return makePipeline(context, compileOptions, linkOptions, false, programGroups, count,
                          logString, logStringSize, pipeline);
}

OptixResult pipelineCreate70(OptixDeviceContext context,
                             const OptixPipelineCompileOptions* compileOptions,
                             const PipelineLinkOptions70* linkOptions,
                             const OptixProgramGroup* programGroups, unsigned count,
                             char* logString, size_t* logStringSize, OptixPipeline* pipeline) {
    return makePipeline(context, compileOptions, linkOptions ? &linkOptions->common : nullptr,
                          linkOptions && linkOptions->overrideUsesMotionBlur != 0, programGroups,
                          count, logString, logStringSize, pipeline);
}

OptixResult pipelineDestroy(OptixPipeline pipeline) {
    std::shared_ptr<PipelineObject> object = pipelines().find(pipeline);
    return guarded(object ? object->context : nullptr, "optixPipelineDestroy", [&] {
        pipelineOf(pipeline);
        pipelines().remove(pipeline);
        const std::shared_ptr<engine::Context> engine = object->context->engine;
        object.reset(); // waits for the pipeline's launches
        engine->backend->flush(*engine);
    });
}

OptixResult pipelineSetStackSize(OptixPipeline pipeline, unsigned directFromTraversal,
                                 unsigned directFromState, unsigned continuation,
                                 unsigned maxTraversableGraphDepth) {
    std::shared_ptr<PipelineObject> object = pipelines().find(pipeline);
    return guarded(object ? object->context : nullptr, "optixPipelineSetStackSize", [&] {
        pipelineOf(pipeline);
        if (maxTraversableGraphDepth == 0 || maxTraversableGraphDepth > Limits::kGraphDepth)
            fail(Code::kInvalidValue, "maxTraversableGraphDepth = ", maxTraversableGraphDepth,
                 " is outside 1..", Limits::kGraphDepth);
        object->pipeline->limits.update([&](engine::PipelineLimits& limits) {
            limits.directStackFromTraversal = directFromTraversal;
            limits.directStackFromState = directFromState;
            limits.continuationStack = continuation;
            limits.maxGraphDepth = maxTraversableGraphDepth;
        });
        engine::Context& engine = *object->context->engine;
        engine.backend->setStackSizes(engine, *object->pipeline);
    });
}

OptixResult launch(OptixPipeline pipeline, CUstream stream, CUdeviceptr params, size_t paramsSize,
                   const OptixShaderBindingTable* sbt, unsigned width, unsigned height,
                   unsigned depth) {
    std::shared_ptr<PipelineObject> object = pipelines().find(pipeline);
    return guarded(object ? object->context : nullptr, "optixLaunch", [&] {
        pipelineOf(pipeline);
        requireNonNull(sbt, "sbt");
        if (width == 0 || height == 0 || depth == 0)
            fail(Code::kInvalidValue, "launch dimensions ", width, " x ", height, " x ", depth,
                 " contain a zero");
        uint64_t plane = uint64_t(width) * height;
        if (plane > Limits::kLaunchIndices || plane * depth > Limits::kLaunchIndices)
            fail(Code::kInvalidValue, "launch dimensions ", width, " x ", height, " x ", depth,
                 " exceed 2^30 indices");
        device::Device& device = *object->context->engine->device;
        const void* streamContext = device.streamContext(stream);
        if (streamContext && object->context->cudaContext &&
            streamContext != object->context->cudaContext)
            fail(Code::kInvalidValue, "stream = ", static_cast<const void*>(stream),
                 " belongs to CUDA context ", streamContext,
                 ", but the pipeline's device context to ",
                 static_cast<const void*>(object->context->cudaContext));
        uint64_t variable = object->pipeline->launchParamsSize;
        if (variable != 0 && paramsSize > variable)
            fail(Code::kInvalidValue, "pipelineParamsSize = ", paramsSize, ", but the launch "
                 "parameter variable has ", variable, " bytes");
        if (variable != 0 && paramsSize != 0) {
            if (params == 0)
                fail(Code::kInvalidValue, "pipelineParams is 0, but pipelineParamsSize is ",
                     paramsSize);
            checkAccessible(device, "pipelineParams", params, paramsSize);
        }
        engine::LaunchRequest request;
        request.pipeline = object->pipeline;
        request.limits = object->pipeline->limits.get();
        request.sbt = checkSbt({*object->context, "optixLaunch"}, *sbt);
        request.params = reinterpret_cast<const void*>(params);
        request.paramsSize = paramsSize;
        request.width = width;
        request.height = height;
        request.depth = depth;
        request.stream = stream;
        request.validation = object->context->engine->validation;
        if (!object->context->engine->validation)
            return engine::launch(object->context->engine, request);
        try {
            engine::launch(object->context->engine, request);
            device.synchronize(stream);
        } catch (const Error& error) {
            if (error.code() != Code::kLaunchFailure) // e.g. the stream is not live
                throw;
            throw ResultError(OPTIX_ERROR_VALIDATION_FAILURE, error.what());
        }
    });
}

} // namespace sunstone::optix7
