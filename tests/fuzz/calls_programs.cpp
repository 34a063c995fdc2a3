// SPDX-License-Identifier: Apache-2.0
// Fuzzing of modules, tasks, program groups and pipelines. Options repeat often, so that some
// modules and pipelines fit together.
#include "programs.h"
#include "ptx_changes.h"
#include "world.h"

#include <cstddef>

namespace fuzz {
namespace {

// The few lines that many calls give to their log string.
struct LogString {
    char text[200] = {};
    size_t size;
    explicit LogString(World& w) : size(w.oneOf<size_t>({sizeof(text), 0, 1, 7})) {}
    bool isRight() const { return std::memchr(text, 0, sizeof(text)) != nullptr; }
};

OptixPipelineCompileOptions compileOptions(World& w) {
    OptixPipelineCompileOptions options{};
    options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    options.numPayloadValues = 2;
    options.numAttributeValues = 2;
    options.exceptionFlags = OPTIX_EXCEPTION_FLAG_USER;
    options.pipelineLaunchParamsVariableName = "params";
    options.usesPrimitiveTypeFlags = 0x1Fu | 1u << 31; // all of 7.4
#if FUZZ_76
    options.usesPrimitiveTypeFlags |= unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE);
    options.allowOpacityMicromaps = 1;
#endif
    if (w.chance(93))
        return options;
    options.usesMotionBlur = int(w.chance(50) ? 1 : w.any32());
    options.traversableGraphFlags = w.chance(70) ? w.below(4) : w.any32();
    options.numPayloadValues = int(w.chance(80) ? w.below(34) : w.any32());
    options.numAttributeValues = int(w.chance(80) ? w.below(10) : w.any32());
    options.exceptionFlags = w.chance(80) ? w.below(16) : w.any32();
    options.pipelineLaunchParamsVariableName =
        w.oneOf<const char*>({"params", nullptr, "", "other"});
    options.usesPrimitiveTypeFlags = w.chance(80) ? w.below(64) : w.any32();
#if FUZZ_76
    options.allowOpacityMicromaps = int(w.chance(80) ? w.below(2) : w.any32());
#endif
    return options;
}

// PTX: correct, shortened, or with a few bytes changed.
std::string ptx(World& w) {
    std::string text = programs();
    if (w.chance(12))
        text.resize(w.below(uint32_t(text.size())));
    if (w.chance(12) && !text.empty())
        w.garble(text.data(), text.size());
    if (w.chance(2))
        text = std::string(w.below(50), char(w.below(256)));
    return text;
}

void createModule(World& w) {
    if (w.modules.live.size() > 6)
        return;
    OptixModuleCompileOptions options{};
    options.optLevel = OPTIX_COMPILE_OPTIMIZATION_LEVEL_0; // compiles fast
    if (w.chance(20)) {
        options.maxRegisterCount = int(w.any32());
        options.optLevel =
            w.enumerator({OPTIX_COMPILE_OPTIMIZATION_DEFAULT, OPTIX_COMPILE_OPTIMIZATION_LEVEL_1,
                          OPTIX_COMPILE_OPTIMIZATION_LEVEL_2, OPTIX_COMPILE_OPTIMIZATION_LEVEL_3});
        options.debugLevel =
            w.enumerator({OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT, OPTIX_COMPILE_DEBUG_LEVEL_NONE,
                          OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL, OPTIX_COMPILE_DEBUG_LEVEL_MODERATE,
                          OPTIX_COMPILE_DEBUG_LEVEL_FULL});
    }
    unsigned word = 3;
    OptixModuleCompileBoundValueEntry bound[2] = {};
    for (auto& entry : bound) {
        entry.pipelineParamOffsetInBytes = w.chance(70) ? offsetof(FuzzParams, mask) : w.anySize();
        entry.sizeInBytes = w.chance(70) ? sizeof(word) : w.below(sizeof(word) + 1);
        entry.boundValuePtr = w.chance(90) ? &word : nullptr;
    }
    if (w.chance(6)) {
        options.boundValues = w.chance(90) ? bound : nullptr;
        options.numBoundValues = 1 + w.below(2);
    }
    unsigned semantics[40];
    OptixPayloadType types[3] = {};
    for (unsigned& s : semantics)
        s = w.chance(80) ? 0xA | w.below(4096) : w.any32();
    for (OptixPayloadType& type : types) {
        type.numPayloadValues = w.below(40);
        type.payloadSemantics = w.chance(92) ? semantics : nullptr;
    }
    if (w.chance(6)) {
        options.numPayloadTypes = 1 + w.below(3);
        options.payloadTypes = w.chance(90) ? types : nullptr;
    }
    OptixPipelineCompileOptions pipeline = compileOptions(w);
    std::string text = ptx(w);
    LogString log(w);
    OptixModule module = nullptr;
    auto* usedOptions = w.chance(97) ? &options : nullptr;
    auto* usedPipeline = w.chance(97) ? &pipeline : nullptr;
    const char* source = w.chance(97) ? text.c_str() : nullptr;
    size_t size = w.chance(90) ? text.size() : w.below(uint32_t(text.size() + 1));
    OptixModule* result = w.chance(97) ? &module : nullptr;
    if (w.chance(85)) {
        OptixResult code =
            optixModuleCreateFromPTX(w.context(), usedOptions, usedPipeline, source, size, log.text,
                                     w.chance(80) ? &log.size : nullptr, result);
        if (code == OPTIX_SUCCESS)
            w.modules.live.push_back(module);
        w.done("optixModuleCreateFromPTX", code);
    } else {
        // Tasks run in any order, some never.
        OptixTask task = nullptr;
        OptixResult code = optixModuleCreateFromPTXWithTasks(
            w.context(), usedOptions, usedPipeline, source, size, log.text,
            w.chance(80) ? &log.size : nullptr, result, w.chance(97) ? &task : nullptr);
        if (code == OPTIX_SUCCESS)
            w.modules.live.push_back(module);
        w.done("optixModuleCreateFromPTXWithTasks", code);
        std::vector<OptixTask> tasks;
        if (code == OPTIX_SUCCESS)
            tasks.push_back(task);
        while (!tasks.empty() && w.chance(95)) {
            size_t at = w.below(uint32_t(tasks.size()));
            OptixTask next = tasks[at], more[4] = {};
            unsigned count = 0;
            tasks.erase(tasks.begin() + long(at));
            w.done("optixTaskExecute", optixTaskExecute(next, more, w.below(5), &count));
            tasks.insert(tasks.end(), more, more + std::min(count, 4u));
        }
    }
    if (!log.isRight())
        w.done("a log string without end", OptixResult(-1));
}
const Call kCreateModule{"optixModuleCreateFromPTX", 8, createModule};

// Programs with some words replaced, compiled completely, but not launched: they could write
// anywhere.
void compileChanged(World& w) {
    static const Tokens seed = tokensOf(programs());
    const auto below = [&w](size_t limit) { return size_t(w.below(uint32_t(limit))); };
    const std::string text = textOf(PtxChanges({seed}, below).changed(seed));
    const OptixDeviceContext context = w.context();
    OptixModuleCompileOptions options{};
    options.optLevel = w.chance(70) ? OPTIX_COMPILE_OPTIMIZATION_LEVEL_0
                                    : OPTIX_COMPILE_OPTIMIZATION_LEVEL_3;
    const OptixPipelineCompileOptions pipelineOptions = compileOptions(w);
    OptixModule module = nullptr;
    const OptixResult result =
        optixModuleCreateFromPTX(context, &options, &pipelineOptions, text.c_str(), text.size(),
                                 nullptr, nullptr, &module);
    w.done("optixModuleCreateFromPTX", result);
    if (result != OPTIX_SUCCESS)
        return;
    std::vector<OptixProgramGroup> groups;
    const auto add = [&](auto describe) {
        OptixProgramGroupDesc d{};
        describe(d);
        const OptixProgramGroupOptions none{};
        OptixProgramGroup group = nullptr;
        const OptixResult added =
            optixProgramGroupCreate(context, &d, 1, &none, nullptr, nullptr, &group);
        w.done("optixProgramGroupCreate", added);
        if (added == OPTIX_SUCCESS)
            groups.push_back(group);
    };
    for (const char* name : {"__raygen__trace", "__raygen__call", "__raygen__throw"})
        add([&](OptixProgramGroupDesc& d) {
            d.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
            d.raygen = {module, name};
        });
    add([&](OptixProgramGroupDesc& d) {
        d.kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
        d.miss = {module, "__miss__note"};
    });
    add([&](OptixProgramGroupDesc& d) {
        d.kind = OPTIX_PROGRAM_GROUP_KIND_EXCEPTION;
        d.exception = {module, "__exception__note"};
    });
    add([&](OptixProgramGroupDesc& d) {
        d.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        d.hitgroup = {module, "__closesthit__note", module, "__anyhit__note", module,
                      "__intersection__note"};
    });
    add([&](OptixProgramGroupDesc& d) {
        d.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
        d.callables = {module, "__direct_callable__add", module, "__continuation_callable__add"};
    });
    if (!groups.empty()) {
        const OptixPipelineLinkOptions link{2, OPTIX_COMPILE_DEBUG_LEVEL_NONE};
        OptixPipeline pipeline = nullptr;
        const OptixResult made =
            optixPipelineCreate(context, &pipelineOptions, &link, groups.data(),
                                unsigned(groups.size()), nullptr, nullptr, &pipeline);
        w.done("optixPipelineCreate", made);
        if (made == OPTIX_SUCCESS)
            w.done("optixPipelineDestroy", optixPipelineDestroy(pipeline));
    }
    for (OptixProgramGroup group : groups)
        w.done("optixProgramGroupDestroy", optixProgramGroupDestroy(group));
    w.done("optixModuleDestroy", optixModuleDestroy(module));
}
const Call kCompileChanged{"optixPipelineCreate (changed programs)", 2, compileChanged};

void moduleState(World& w) {
    OptixModuleCompileState state{};
    w.done("optixModuleGetCompilationState",
           optixModuleGetCompilationState(w.pick(w.modules), w.chance(90) ? &state : nullptr));
    OptixTask more[2] = {};
    unsigned count = 0;
    w.done("optixTaskExecute", optixTaskExecute(OptixTask(w.anySize()), more, w.below(3), &count));
}
const Call kModuleState{"optixModuleGetCompilationState", 1, moduleState};

void builtinModule(World& w) {
    if (w.builtins.live.size() > 3)
        return;
    OptixModuleCompileOptions options{};
    if (w.chance(5))
        options.optLevel = OptixCompileOptimizationLevel(w.any32());
    const OptixPipelineCompileOptions pipeline = compileOptions(w);
    OptixBuiltinISOptions builtin{};
    builtin.builtinISModuleType = w.enumerator({
        OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE,
            OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM,
#if FUZZ_76
            OPTIX_PRIMITIVE_TYPE_SPHERE,
#endif
            OPTIX_PRIMITIVE_TYPE_TRIANGLE, OPTIX_PRIMITIVE_TYPE_CUSTOM
    });
    builtin.usesMotionBlur = int(w.chance(90) ? w.below(2) : w.any32());
    builtin.buildFlags = w.chance(60) ? 0 : w.chance(90) ? w.below(64) : w.any32();
    builtin.curveEndcapFlags = w.chance(80) ? 0 : w.chance(90) ? 1 : w.any32();
    OptixModule module = nullptr;
    const OptixResult result = optixBuiltinISModuleGet(
        w.context(), w.chance(97) ? &options : nullptr, w.chance(97) ? &pipeline : nullptr,
        w.chance(97) ? &builtin : nullptr, w.chance(97) ? &module : nullptr);
    if (result == OPTIX_SUCCESS)
        w.builtins.live.push_back(module);
    w.done("optixBuiltinISModuleGet", result);
}
const Call kBuiltinModule{"optixBuiltinISModuleGet", 3, builtinModule};

void destroyModule(World& w) {
    Handles<OptixModule>& kind = w.chance(80) ? w.modules : w.builtins;
    OptixModule module = w.pick(kind);
    OptixResult result = optixModuleDestroy(module);
    if (result == OPTIX_SUCCESS)
        kind.died(module);
    w.done("optixModuleDestroy", result);
}
const Call kDestroyModule{"optixModuleDestroy", 1, destroyModule};

const char* entry(World& w, const char* right) {
    return w.chance(93) ? right
                        : w.oneOf<const char*>({nullptr, "", "__raygen__trace", "__miss__note",
                                                "__nothing", "__closesthit__note", "params"});
}

OptixProgramGroupDesc groupDesc(World& w) {
    OptixProgramGroupDesc d{};
    OptixModule module = w.pick(w.chance(97) ? w.modules : w.builtins);
    d.kind = w.enumerator({OPTIX_PROGRAM_GROUP_KIND_RAYGEN, OPTIX_PROGRAM_GROUP_KIND_MISS,
                           OPTIX_PROGRAM_GROUP_KIND_EXCEPTION, OPTIX_PROGRAM_GROUP_KIND_HITGROUP,
                           OPTIX_PROGRAM_GROUP_KIND_CALLABLES});
    if (w.chance(3))
        d.flags = w.any32();
    switch (d.kind) {
    case OPTIX_PROGRAM_GROUP_KIND_RAYGEN:
        d.raygen = {module, entry(w, w.oneOf({"__raygen__trace", "__raygen__trace",
                                              "__raygen__call", "__raygen__throw"}))};
        break;
    case OPTIX_PROGRAM_GROUP_KIND_MISS:
        d.miss = {module, entry(w, "__miss__note")};
        break;
    case OPTIX_PROGRAM_GROUP_KIND_EXCEPTION:
        d.exception = {module, entry(w, "__exception__note")};
        break;
    case OPTIX_PROGRAM_GROUP_KIND_HITGROUP:
        if (w.chance(80))
            d.hitgroup.moduleCH = module,
            d.hitgroup.entryFunctionNameCH = entry(w, "__closesthit__note");
        if (w.chance(50))
            d.hitgroup.moduleAH = module,
            d.hitgroup.entryFunctionNameAH = entry(w, "__anyhit__note");
        if (!w.builtins.live.empty() && w.chance(40)) {
            d.hitgroup.moduleIS = w.pick(w.builtins);
            d.hitgroup.entryFunctionNameIS = w.chance(95) ? nullptr : "__intersection__note";
        } else if (w.chance(50)) {
            d.hitgroup.moduleIS = w.chance(80) ? module : w.pick(w.modules);
            d.hitgroup.entryFunctionNameIS = entry(w, "__intersection__note");
        }
        break;
    default:
        if (w.chance(80))
            d.callables.moduleDC = module,
            d.callables.entryFunctionNameDC = entry(w, "__direct_callable__add");
        if (w.chance(80))
            d.callables.moduleCC = module,
            d.callables.entryFunctionNameCC = entry(w, "__continuation_callable__add");
    }
    return d;
}

void createGroups(World& w) {
    unsigned count = 1 + w.below(3);
    std::vector<OptixProgramGroupDesc> descs;
    for (unsigned i = 0; i < count; ++i)
        descs.push_back(groupDesc(w));
    unsigned semantics[2] = {w.any32(), 0xAAA};
    OptixPayloadType type{w.below(3), semantics};
    OptixProgramGroupOptions options{w.chance(95) ? nullptr : &type};
    std::vector<OptixProgramGroup> groups(count);
    LogString log(w);
    OptixResult result = optixProgramGroupCreate(
        w.context(), w.chance(97) ? descs.data() : nullptr, w.chance(97) ? count : 0,
        w.chance(97) ? &options : nullptr, log.text, w.chance(80) ? &log.size : nullptr,
        w.chance(97) ? groups.data() : nullptr);
    if (result == OPTIX_SUCCESS)
        for (unsigned i = 0; i < count; ++i)
            if (groups[i]) {
                w.groups.live.push_back(groups[i]);
                w.kindOf[groups[i]] = descs[i].kind;
            }
    w.done(log.isRight() ? "optixProgramGroupCreate" : "a log string without end",
           log.isRight() ? result : OptixResult(-1));
}
const Call kCreateGroups{"optixProgramGroupCreate", 14, createGroups};

void destroyGroup(World& w) {
    OptixProgramGroup group = w.pick(w.groups);
    OptixResult result = optixProgramGroupDestroy(group);
    if (result == OPTIX_SUCCESS)
        w.groups.died(group);
    w.done("optixProgramGroupDestroy", result);
}
const Call kDestroyGroup{"optixProgramGroupDestroy", 1, destroyGroup};

void stackSize(World& w) {
    OptixStackSizes sizes{};
    w.done("optixProgramGroupGetStackSize",
           optixProgramGroupGetStackSize(w.pick(w.groups), w.chance(95) ? &sizes : nullptr));
}
const Call kStackSize{"optixProgramGroupGetStackSize", 1, stackSize};

void createPipeline(World& w) {
    if (w.groups.live.empty() && w.chance(90))
        return;
    OptixPipelineCompileOptions options = compileOptions(w);
    OptixPipelineLinkOptions link{};
    link.maxTraceDepth = w.chance(85) ? w.below(4) : w.any32();
    link.debugLevel =
        w.enumerator({OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT, OPTIX_COMPILE_DEBUG_LEVEL_NONE});
    std::vector<OptixProgramGroup> groups;
    if (w.chance(80))
        groups = w.groups.live;
    else
        for (unsigned i = 0, count = w.below(6); i < count; ++i)
            groups.push_back(w.pick(w.groups));
    LogString log(w);
    OptixPipeline pipeline = nullptr;
    OptixResult result = optixPipelineCreate(
        w.context(), w.chance(97) ? &options : nullptr, w.chance(97) ? &link : nullptr,
        w.chance(97) ? groups.data() : nullptr, unsigned(groups.size()), log.text,
        w.chance(80) ? &log.size : nullptr, w.chance(97) ? &pipeline : nullptr);
    if (result == OPTIX_SUCCESS)
        w.pipelines.live.push_back(pipeline);
    w.done(log.isRight() ? "optixPipelineCreate" : "a log string without end",
           log.isRight() ? result : OptixResult(-1), std::to_string(groups.size()) + " groups");
}
const Call kCreatePipeline{"optixPipelineCreate", 5, createPipeline};

void destroyPipeline(World& w) {
    OptixPipeline pipeline = w.pick(w.pipelines);
    OptixResult result = optixPipelineDestroy(pipeline);
    if (result == OPTIX_SUCCESS)
        w.pipelines.died(pipeline);
    w.done("optixPipelineDestroy", result);
}
const Call kDestroyPipeline{"optixPipelineDestroy", 1, destroyPipeline};

void setStackSize(World& w) {
    w.done("optixPipelineSetStackSize",
           optixPipelineSetStackSize(w.pick(w.pipelines), w.any32(), w.any32(), w.any32(),
                                     w.chance(80) ? w.below(6) : w.any32()));
}
const Call kSetStackSize{"optixPipelineSetStackSize", 1, setStackSize};

// Launches with a table whose records are from groups of the pipeline, from other groups, or unset.
void launch(World& w) {
    if (w.pipelines.live.empty() && w.chance(90))
        return;
    constexpr unsigned kStride = OPTIX_SBT_RECORD_HEADER_SIZE + 16;
    auto pack = [&](OptixProgramGroupKind kind, unsigned count) -> CUdeviceptr {
        Handles<OptixProgramGroup> fitting;
        for (OptixProgramGroup group : w.groups.live)
            if (w.kindOf[group] == kind || w.chance(3))
                fitting.live.push_back(group);
        CUdeviceptr at = w.memory(size_t(count) * kStride, OPTIX_SBT_RECORD_ALIGNMENT);
        for (unsigned i = 0; i < count; ++i) {
            auto* record = reinterpret_cast<char*>(at) + size_t(i) * kStride;
            if (!w.groups.live.empty() && w.chance(90))
                w.done("optixSbtRecordPackHeader",
                       optixSbtRecordPackHeader(w.pick(w.groups), record));
            if (w.chance(4))
                w.garble(record, kStride);
        }
        return w.chance(95) ? at : w.address(size_t(count) * kStride, OPTIX_SBT_RECORD_ALIGNMENT);
    };
    OptixShaderBindingTable sbt{};
    sbt.raygenRecord = pack(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, 1);
    sbt.exceptionRecord = w.chance(30) ? pack(OPTIX_PROGRAM_GROUP_KIND_EXCEPTION, 1) : 0;
    sbt.missRecordBase = pack(OPTIX_PROGRAM_GROUP_KIND_MISS, 2);
    sbt.missRecordCount = w.nearly(2);
    sbt.missRecordStrideInBytes = w.nearly(kStride);
    sbt.hitgroupRecordBase = pack(OPTIX_PROGRAM_GROUP_KIND_HITGROUP, 6);
    sbt.hitgroupRecordCount = w.nearly(6);
    sbt.hitgroupRecordStrideInBytes = w.nearly(kStride);
    if (w.chance(60)) {
        sbt.callablesRecordBase = pack(OPTIX_PROGRAM_GROUP_KIND_CALLABLES, 4);
        sbt.callablesRecordCount = w.nearly(4);
        sbt.callablesRecordStrideInBytes = w.nearly(kStride);
    }
    unsigned width = w.chance(95) ? 1 + w.below(40) : w.any32();
    unsigned height = w.chance(95) ? 1 + w.below(4) : w.any32();
    unsigned depth = w.chance(95) ? 1 : w.below(3);
    if (uint64_t(width) * height * depth > 100000 &&
        uint64_t(width) * height * depth < (1ull << 31))
        width = height = 1; // legal, but slow
    FuzzParams params{};
    params.count = w.below(300);
    params.answers =
        w.chance(95) ? reinterpret_cast<unsigned*>(w.memory(params.count * 4 + 4, 4)) : nullptr;
    params.rayFlags = w.chance(70) ? 0 : w.chance(70) ? w.below(2048) : w.any32();
    params.handle = w.traversable();
    for (int i = 0; i < 3; ++i) {
        params.origin[i] = w.anyFloat();
        params.direction[i] = w.anyFloat();
    }
    params.tmin = w.chance(80) ? 0.0f : w.anyFloat();
    params.tmax = w.chance(80) ? 1e16f : w.anyFloat();
    params.time = w.chance(80) ? 0.5f : w.anyFloat();
    params.sbtOffset = w.chance(85) ? w.below(2) : w.any32();
    params.sbtStride = w.chance(85) ? w.below(2) : w.any32();
    params.missIndex = w.chance(85) ? w.below(2) : w.any32();
    params.callable = w.chance(85) ? w.below(4) : w.any32();
    params.mask = w.chance(85) ? 255 : w.any32();
    CUdeviceptr at = w.upload(std::vector<FuzzParams>{params});
    size_t size = w.chance(93)   ? sizeof(params)
                  : w.chance(50) ? w.below(sizeof(params))
                                 : w.anySize();
    w.done("optixLaunch", optixLaunch(w.pick(w.pipelines), w.stream(),
                                      w.chance(97) ? at : w.address(sizeof(params)), size,
                                      w.chance(98) ? &sbt : nullptr, width, height, depth));
}
const Call kLaunch{"optixLaunch", 14, launch};

void packHeader(World& w) {
    alignas(16) char record[OPTIX_SBT_RECORD_HEADER_SIZE];
    w.done("optixSbtRecordPackHeader",
           optixSbtRecordPackHeader(w.pick(w.groups), w.chance(90) ? record : nullptr));
}
const Call kPackHeader{"optixSbtRecordPackHeader", 1, packHeader};

} // namespace
} // namespace fuzz
