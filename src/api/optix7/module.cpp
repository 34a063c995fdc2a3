// SPDX-License-Identifier: Apache-2.0
// Modules (OptiX 7.4, section 3.6) and the options they share with pipelines.
#include "api/optix7/entry_points.h"
#include "api/optix7/options.h"

#include <algorithm>
#include <vector>

namespace sunstone::optix7 {
namespace {

compiler::OptLevel optLevelOf(OptixCompileOptimizationLevel level, Abi abi) {
    switch (abi < kAbi71 ? optLevelOf70(level) : level) {
    case OPTIX_COMPILE_OPTIMIZATION_LEVEL_0: return compiler::OptLevel::k0;
    case OPTIX_COMPILE_OPTIMIZATION_LEVEL_1: return compiler::OptLevel::k1;
    case OPTIX_COMPILE_OPTIMIZATION_LEVEL_2: return compiler::OptLevel::k2;
    case OPTIX_COMPILE_OPTIMIZATION_DEFAULT:
    case OPTIX_COMPILE_OPTIMIZATION_LEVEL_3: return compiler::OptLevel::k3;
    }
    fail(Code::kInvalidValue, "moduleCompileOptions->optLevel = ", unsigned(level), " is unknown");
}

compiler::DebugLevel debugLevelOf(OptixCompileDebugLevel level, const char* parameter, Abi abi) {
    switch (abi < kAbi71 ? debugLevelOf70(level) : level) {
    case OPTIX_COMPILE_DEBUG_LEVEL_NONE: return compiler::DebugLevel::kNone;
    case OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT:
    case OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL: return compiler::DebugLevel::kMinimal;
    case OPTIX_COMPILE_DEBUG_LEVEL_MODERATE:
        if (abi >= kAbi74)
            return compiler::DebugLevel::kModerate;
        break;
    case OPTIX_COMPILE_DEBUG_LEVEL_FULL: return compiler::DebugLevel::kFull;
    }
    fail(Code::kInvalidValue, parameter, "->debugLevel = ", unsigned(level), " is unknown");
}

// Bound values promise what the launch parameters will hold. Loads keep reading memory, which the
// manual allows; the entries are checked all the same.
void checkBoundValues(const OptixModuleCompileOptions& options, uint64_t paramsSize) {
    if (options.numBoundValues == 0)
        return;
    requireNonNull(options.boundValues, "moduleCompileOptions->boundValues");
    std::vector<std::pair<uint64_t, uint64_t>> ranges;
    for (unsigned i = 0; i < options.numBoundValues; ++i) {
        const OptixModuleCompileBoundValueEntry& entry = options.boundValues[i];
        if (entry.sizeInBytes == 0 || !entry.boundValuePtr)
            fail(Code::kInvalidValue, "boundValues[", i, "] has size ", entry.sizeInBytes,
                 " and pointer ", entry.boundValuePtr, "; both must be non-zero");
        uint64_t begin = entry.pipelineParamOffsetInBytes;
        if (paramsSize != 0 && (begin > paramsSize || entry.sizeInBytes > paramsSize - begin))
            fail(Code::kInvalidValue, "boundValues[", i, "] covers bytes ", begin, " to ",
                 begin + entry.sizeInBytes, " of a launch parameter variable of ", paramsSize);
        ranges.push_back({begin, begin + entry.sizeInBytes});
    }
    std::sort(ranges.begin(), ranges.end());
    for (size_t i = 1; i < ranges.size(); ++i)
        if (ranges[i].first < ranges[i - 1].second)
            fail(Code::kInvalidValue, "bound values overlap at byte ", ranges[i].first,
                 " of the launch parameters");
}

void checkModuleOptions(const OptixModuleCompileOptions& options) {
    if (options.maxRegisterCount < 0)
        fail(Code::kInvalidValue, "moduleCompileOptions->maxRegisterCount = ",
             options.maxRegisterCount, " is negative");
    if (options.numPayloadTypes != 0)
        fail(Code::kNotSupported, "moduleCompileOptions->numPayloadTypes = ",
             options.numPayloadTypes, ": payload types are not available yet");
}

} // namespace

CompileOptions checkCompileOptions(const OptixPipelineCompileOptions* options, Abi abi) {
    requireNonNull(options, "pipelineCompileOptions");
    const char* where = "pipelineCompileOptions->";
    constexpr unsigned kGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS |
                                     OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
    if (options->traversableGraphFlags & ~kGraphFlags)
        fail(Code::kInvalidValue, where, "traversableGraphFlags = ", options->traversableGraphFlags,
             " has unknown bits");
    if (options->numPayloadValues < 0 || options->numPayloadValues > Limits::payloadValues(abi))
        fail(Code::kInvalidValue, where, "numPayloadValues = ", options->numPayloadValues,
             " is outside 0..", Limits::payloadValues(abi));
    if (options->numAttributeValues < 0 || options->numAttributeValues > 8)
        fail(Code::kInvalidValue, where, "numAttributeValues = ", options->numAttributeValues,
             " is outside 0..8");
    constexpr unsigned kExceptionFlags = 15;
    if (options->exceptionFlags & ~kExceptionFlags)
        fail(Code::kInvalidValue, where, "exceptionFlags = ", options->exceptionFlags,
             " has unknown bits");
    if (unsigned(options->usesPrimitiveTypeFlags) & ~knownPrimitiveTypeFlags(abi))
        fail(Code::kInvalidValue, where, "usesPrimitiveTypeFlags = ",
             unsigned(options->usesPrimitiveTypeFlags), " has unknown bits");
    CompileOptions kept;
    kept.values = *options;
    kept.values.pipelineLaunchParamsVariableName = nullptr;
    kept.values.numAttributeValues = std::max(2, int(options->numAttributeValues));
    // One form for what means the same, so that equal options compare equal.
    kept.values.usesMotionBlur = options->usesMotionBlur != 0;
    kept.values.allowOpacityMicromaps = options->allowOpacityMicromaps != 0;
    if (options->allowOpacityMicromaps)
        fail(Code::kNotSupported, where, "allowOpacityMicromaps = ",
             options->allowOpacityMicromaps, ": opacity micromaps are not available yet");
    if (options->usesPrimitiveTypeFlags == 0)
        kept.values.usesPrimitiveTypeFlags =
            unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM) | unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
    if (options->pipelineLaunchParamsVariableName)
        kept.launchParams = options->pipelineLaunchParamsVariableName;
    return kept;
}

void checkDebugLevel(OptixCompileDebugLevel level, const char* parameter, Abi abi) {
    debugLevelOf(level, parameter, abi);
}

OptixResult moduleCreateFromPTX(OptixDeviceContext context,
                                const OptixModuleCompileOptions* moduleOptions,
                                const OptixPipelineCompileOptions* pipelineOptions,
                                const char* ptx, size_t ptxSize, char* logString,
                                size_t* logStringSize, OptixModule* module) {
    std::string feedback;
    std::shared_ptr<DeviceContext> owner = peek(context);
    OptixResult result = guarded(owner, "optixModuleCreateFromPTX", [&] {
        contextOf(context);
        requireNonNull(module, "module");
        *module = nullptr;
        requireNonNull(moduleOptions, "moduleCompileOptions");
        requireNonNull(ptx, "PTX");
        CompileOptions options = checkCompileOptions(pipelineOptions, owner->abi);
        checkModuleOptions(*moduleOptions);
        compiler::OptLevel optLevel = optLevelOf(moduleOptions->optLevel, owner->abi);
        compiler::DebugLevel debugLevel =
            debugLevelOf(moduleOptions->debugLevel, "moduleCompileOptions", owner->abi);

        auto object = std::make_shared<ModuleObject>();
        object->context = owner;
        object->options = options;
        object->module = engine::createModule(std::string_view(ptx, ptxSize), options.rules(),
                                              optLevel, debugLevel, feedback);
        checkBoundValues(*moduleOptions, object->module->summary.launchParamsSize);
        *module = static_cast<OptixModule>(modules().add(object));
        owner->log(LogLevel::kInfo, "COMPILER",
                   message("module with ", object->module->summary.programs.size(), " programs"));
    }, &feedback);
    writeLogString(feedback, logString, logStringSize);
    return result;
}

OptixResult moduleDestroy(OptixModule module) {
    std::shared_ptr<ModuleObject> object = modules().find(module);
    return guarded(object ? object->context : nullptr, "optixModuleDestroy", [&] {
        moduleOf(module, "module");
        modules().remove(module);
    });
}

} // namespace sunstone::optix7
