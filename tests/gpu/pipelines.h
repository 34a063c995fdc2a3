// SPDX-License-Identifier: Apache-2.0
// For the tests of GPU pipelines: a pipeline of all programs of a module. Groups are numbered from
// 1.
#pragma once

#include "compiler/gpu/pipeline.h"
#include "devlib/gpu_runtime.h"
#include "engine/module.h"

#include <string>

namespace sunstone::gpu_tests {

using compiler::GpuGroup;
using compiler::ProgramKind;

struct Options {
    unsigned graphFlags = 1;  // ALLOW_SINGLE_GAS
    bool motion = false;      // usesMotionBlur
    bool oneHitGroup = false; // any-hit and closest-hit programs make one group, the closest-hit's
    compiler::GpuTarget target = {90, 80};
    uint32_t shapes = 0; // bvh::gpu::ShapeBit
    bool micromaps = false;
    unsigned maxTraceDepth = 0; // 0: not known when the pipeline is compiled
    size_t mostInlined = compiler::GpuPipelineRequest().mostInlined;
    bool ready = false; // linked with a kernel that serves many pipelines
};

inline GpuGroup groupOf(ProgramKind kind, size_t program) {
    GpuGroup group;
    group.number = uint32_t(program) + 1;
    switch (kind) {
    case ProgramKind::kMiss:
        group.kind = devlib::kGroupMiss;
        group.programs[devlib::kRoleMain] = program;
        break;
    case ProgramKind::kException:
        group.kind = devlib::kGroupException;
        group.programs[devlib::kRoleMain] = program;
        break;
    case ProgramKind::kClosestHit:
        group.kind = devlib::kGroupHit;
        group.programs[devlib::kRoleMain] = program;
        break;
    case ProgramKind::kAnyHit:
        group.kind = devlib::kGroupHit;
        group.programs[devlib::kRoleAnyHit] = program;
        break;
    case ProgramKind::kIntersection:
        group.kind = devlib::kGroupHit;
        group.programs[devlib::kRoleIntersection] = program;
        break;
    case ProgramKind::kDirectCallable:
        group.kind = devlib::kGroupCallables;
        group.programs[devlib::kRoleDirect] = program;
        break;
    case ProgramKind::kContinuationCallable:
        group.kind = devlib::kGroupCallables;
        group.programs[devlib::kRoleContinuation] = program;
        break;
    default:
        group.kind = devlib::kGroupRaygen;
        group.programs[devlib::kRoleMain] = program;
        break;
    }
    return group;
}

inline compiler::PipelineRules rulesOf(const Options& options) {
    compiler::PipelineRules rules;
    rules.launchParams = "params";
    rules.optix7.numPayloadValues = 8;
    rules.optix7.numAttributeValues = 4;
    rules.traversableGraphFlags = options.graphFlags;
    rules.motionBlur = options.motion;
    return rules;
}

// A pipeline of all programs of one module.
inline compiler::GpuPipelineRequest requestOf(std::shared_ptr<const compiler::Source> source,
                                              const compiler::ModuleSummary& summary,
                                              const Options& options) {
    compiler::GpuPipelineRequest request;
    request.pipeline.rules = rulesOf(options);
    request.runtime = devlib::gpuRuntime();
    request.target = options.target;
    request.maxTraceDepth = options.maxTraceDepth;
    request.mostInlined = options.mostInlined;
    bool anyHit = false, intersection = false, exception = false;
    for (const auto& program : summary.programs) {
        anyHit |= program.kind == ProgramKind::kAnyHit;
        intersection |= program.kind == ProgramKind::kIntersection;
        exception |= program.kind == ProgramKind::kException;
        request.groups.push_back(groupOf(program.kind, request.pipeline.programs.size()));
        compiler::ProgramRequest wanted;
        wanted.module = source;
        wanted.function = program.name;
        wanted.kind = program.kind;
        wanted.moduleRules = std::make_shared<const compiler::ModuleRules>();
        request.pipeline.programs.push_back(std::move(wanted));
    }
    if (options.oneHitGroup)
        for (GpuGroup& group : request.groups)
            for (const GpuGroup& other : request.groups)
                if (group.kind == devlib::kGroupHit && group.programs[devlib::kRoleMain] != GpuGroup::kNone &&
                    other.programs[devlib::kRoleAnyHit] != GpuGroup::kNone)
                    group.programs[devlib::kRoleAnyHit] = other.programs[devlib::kRoleAnyHit];
    const uint32_t graph = options.graphFlags == 1 ? 0 : options.graphFlags & 2 ? 1 : 2;
    request.constants = {{"sunstone_gpu_hasAnyHit", anyHit},
                         {"sunstone_gpu_hasIntersection", intersection},
                         {"sunstone_gpu_micromaps", options.micromaps},
                         {"sunstone_gpu_shapes", options.shapes},
                         {"sunstone_gpu_hasBounds", 0},
                         {"sunstone_gpu_hasException", exception},
                         {"sunstone_gpu_exceptionFlags", 0},
                         {"sunstone_gpu_graph", graph},
                         {"sunstone_gpu_motion", options.motion}};
    return request;
}

inline compiler::GpuPipelineRequest requestOf(const std::string& text, const Options& options) {
    std::string feedback;
    const auto module = engine::createModule(text, rulesOf(options), {}, compiler::OptLevel::k3,
                                             compiler::DebugLevel::kMinimal, nullptr,
                                             *engine::cpuBackend(), feedback);
    return requestOf(module->source, module->summary, options);
}

inline compiler::GpuCode compileCode(const std::string& text, const Options& options = {}) {
    return compiler::compileGpuPipeline(requestOf(text, options));
}

inline std::string compile(const std::string& text, const Options& options = {}) {
    return compileCode(text, options).ptx;
}

inline std::string raygen(const std::string& body) {
    return ".version 7.8\n.target sm_70\n.address_size 64\n"
           ".visible .const .align 8 .b8 params[16];\n"
           ".visible .entry __raygen__main()\n{\n"
           "    .reg .b32 %r<8>;\n    .reg .f32 %f<8>;\n    .reg .b64 %rd<8>;\n"
           "    .reg .pred %p<4>;\n    .reg .b16 %rs<4>;\n    .reg .b8 %b<2>;\n"
           "    ld.const.u64 %rd1, [params];\n    ld.global.f32 %f1, [%rd1];\n"
           "    ld.global.u32 %r1, [%rd1+4];\n" +
           body + "    ret;\n}\n";
}

} // namespace sunstone::gpu_tests
