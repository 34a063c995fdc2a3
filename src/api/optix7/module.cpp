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

// Bound values are the client's promise about the launch parameters; code is specialised to them.
std::vector<compiler::BoundValue> boundValuesOf(const OptixModuleCompileOptions& options) {
    std::vector<compiler::BoundValue> values;
    if (options.numBoundValues == 0)
        return values;
    requireNonNull(options.boundValues, "moduleCompileOptions->boundValues");
    std::vector<std::pair<uint64_t, uint64_t>> ranges;
    for (unsigned i = 0; i < options.numBoundValues; ++i) {
        const OptixModuleCompileBoundValueEntry& entry = options.boundValues[i];
        if (entry.sizeInBytes == 0 || !entry.boundValuePtr)
            fail(Code::kInvalidValue, "boundValues[", i, "] has size ", entry.sizeInBytes,
                 " and pointer ", entry.boundValuePtr, "; both must be non-zero");
        constexpr uint64_t kConstantMemory = 64 << 10;
        const uint64_t begin = entry.pipelineParamOffsetInBytes;
        if (begin > kConstantMemory || entry.sizeInBytes > kConstantMemory - begin)
            fail(Code::kInvalidValue, "boundValues[", i, "] covers ", entry.sizeInBytes,
                 " bytes from ", begin, "; launch parameters have at most ", kConstantMemory);
        ranges.push_back({begin, begin + entry.sizeInBytes});
        const auto* bytes = static_cast<const uint8_t*>(entry.boundValuePtr);
        values.push_back({begin,
                          {bytes, bytes + entry.sizeInBytes},
                          entry.annotation ? entry.annotation : ""});
    }
    std::sort(ranges.begin(), ranges.end());
    for (size_t i = 1; i < ranges.size(); ++i)
        if (ranges[i].first < ranges[i - 1].second)
            fail(Code::kInvalidValue, "bound values overlap at byte ", ranges[i].first,
                 " of the launch parameters");
    return values;
}

std::vector<compiler::PayloadType> payloadTypesOf(const OptixModuleCompileOptions& options,
                                                  const OptixPipelineCompileOptions& pipeline) {
    std::vector<compiler::PayloadType> types;
    if (options.numPayloadTypes == 0)
        return types;
    if (options.numPayloadTypes > compiler::kMaxPayloadTypes)
        fail(Code::kInvalidValue, "moduleCompileOptions->numPayloadTypes = ",
             options.numPayloadTypes, " is above ", compiler::kMaxPayloadTypes);
    requireNonNull(options.payloadTypes, "moduleCompileOptions->payloadTypes");
    if (pipeline.numPayloadValues != 0)
        fail(Code::kInvalidValue, "pipelineCompileOptions->numPayloadValues = ",
             pipeline.numPayloadValues, ", but must be 0 for a module with payload types");
    for (unsigned i = 0; i < options.numPayloadTypes; ++i)
        types.push_back(checkPayloadType(
            options.payloadTypes[i], message("moduleCompileOptions->payloadTypes[", i, "]")));
    return types;
}

} // namespace

compiler::PayloadType checkPayloadType(const OptixPayloadType& type, const std::string& where) {
    if (type.numPayloadValues > devlib::kMaxPayloadWords)
        fail(Code::kInvalidValue, where, ".numPayloadValues = ", type.numPayloadValues,
             " is above ", devlib::kMaxPayloadWords);
    if (type.numPayloadValues != 0 && !type.payloadSemantics)
        fail(Code::kInvalidValue, where, ".payloadSemantics is null");
    compiler::PayloadType result;
    for (unsigned i = 0; i < type.numPayloadValues; ++i) {
        const unsigned word = type.payloadSemantics[i];
        constexpr unsigned kReads = 0x155, kWrites = 0x2AA;
        if (word & ~(kReads | kWrites))
            fail(Code::kInvalidValue, where, ".payloadSemantics[", i, "] = ", word,
                 " has unknown bits");
        if (!(word & kWrites) || !(word & kReads))
            fail(Code::kInvalidValue, where, ".payloadSemantics[", i, "] = ", word,
                 ": nobody may ", word & kWrites ? "read" : "write", " the word");
        result.words.push_back(word);
    }
    return result;
}

void checkCompileLevels(const OptixModuleCompileOptions& options, const ApiCall& call) {
    const Abi abi = call.context.abi;
    if (options.maxRegisterCount < 0)
        tolerate(call, "there is no limit",
                 "moduleCompileOptions->maxRegisterCount = ", options.maxRegisterCount,
                 " is negative");
    optLevelOf(options.optLevel, abi);
    debugLevelOf(options.debugLevel, "moduleCompileOptions", abi);
}

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
    // Normalises equal meanings to one value, so that equal options compare equal.
    kept.values.usesMotionBlur = options->usesMotionBlur != 0;
    kept.values.allowOpacityMicromaps = options->allowOpacityMicromaps != 0;
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

ModuleInput checkModuleInput(const ApiCall& call, const OptixModuleCompileOptions* moduleOptions,
                             const OptixPipelineCompileOptions* pipelineOptions, const char* ptx) {
    requireNonNull(moduleOptions, "moduleCompileOptions");
    requireNonNull(ptx, "PTX");
    ModuleInput input;
    const Abi abi = call.context.abi;
    input.options = checkCompileOptions(pipelineOptions, abi);
    input.rules = call.context.rulesOf(input.options);
    checkCompileLevels(*moduleOptions, call);
    input.optLevel = optLevelOf(moduleOptions->optLevel, abi);
    input.debugLevel = debugLevelOf(moduleOptions->debugLevel, "moduleCompileOptions", abi);
    input.moduleRules.boundValues = boundValuesOf(*moduleOptions);
    input.moduleRules.payloadTypes = payloadTypesOf(*moduleOptions, *pipelineOptions);
    return input;
}

std::shared_ptr<engine::Module> makeModule(const std::shared_ptr<DeviceContext>& owner,
                                           ModuleInput input, std::string_view ptx,
                                           std::string& feedback) {
    auto module = engine::createModule(ptx, input.rules, std::move(input.moduleRules),
                                       input.optLevel, input.debugLevel, owner->engine->cache,
                                       *owner->engine->backend, feedback);
    module->forCpu = owner->engine->backend->sharesMemory();
    if (!feedback.empty())
        owner->log(LogLevel::kWarning, "COMPILER",
                   feedback.substr(0, feedback.find_last_not_of('\n') + 1));
    owner->log(LogLevel::kInfo, "COMPILER",
               message("module with ", module->summary.programs.size(), " programs"));
    return module;
}

OptixResult moduleCreateFromPTX(OptixDeviceContext context,
                                const OptixModuleCompileOptions* moduleOptions,
                                const OptixPipelineCompileOptions* pipelineOptions,
                                const char* ptx, size_t ptxSize, char* logString,
                                size_t* logStringSize, OptixModule* module) {
    std::string feedback;
    std::shared_ptr<DeviceContext> owner = peek(context);
    OptixResult result = guarded(
        owner, "optixModuleCreateFromPTX",
        [&] {
            contextOf(context);
            requireNonNull(module, "module");
            *module = nullptr;
            ModuleInput input = checkModuleInput({*owner, "optixModuleCreateFromPTX"},
                                                 moduleOptions, pipelineOptions, ptx);
            auto object = std::make_shared<ModuleObject>();
            object->context = owner;
            object->options = input.options;
            object->module =
                makeModule(owner, std::move(input), std::string_view(ptx, ptxSize), feedback);
            *module = static_cast<OptixModule>(modules().add(object));
        },
        &feedback);
    writeLogString(feedback, logString, logStringSize);
    return result;
}

OptixResult moduleDestroy(OptixModule module) {
    std::shared_ptr<ModuleObject> object = modules().find(module);
    return guarded(object ? object->context : nullptr, "optixModuleDestroy", [&] {
        moduleOf(module, "module");
        if (object->tasks && object->tasks->isExecuting())
            fail(Code::kIllegalDuringTask, "module = ", static_cast<const void*>(module),
                 ": a task of it is being executed");
        const bool isUsed = object.use_count() > 2; // other than by the table and here
        if (isUsed && object->context->engine->validation)
            object->context->log(LogLevel::kWarning, "API",
                                 "optixModuleDestroy: program groups of the module are alive; they "
                                 "keep its code");
        tasks().removeIf([&](const TaskObject& task) { return task.module.lock() == object; });
        modules().remove(module);
    });
}

} // namespace sunstone::optix7
