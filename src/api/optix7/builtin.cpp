// SPDX-License-Identifier: Apache-2.0
// Modules of built-in intersection (OptiX 7.4, sections 3.6.2.1 and 5.11). They have no code:
// traversal itself tests curves, spheres and triangles, by the type of the structure. This file
// checks their options, and creates the modules that hit groups name.
#include "api/optix7/build_inputs.h"
#include "api/optix7/entry_points.h"
#include "api/optix7/options.h"
#include "engine/builtin_options.h"

namespace sunstone::optix7 {
namespace {

// The bit of usesPrimitiveTypeFlags for a type with a built-in intersection; 0 for others.
unsigned primitiveTypeFlag(OptixPrimitiveType type) {
    switch (type) {
    case OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE:
        return OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_QUADRATIC_BSPLINE;
    case OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE:
        return OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE;
    case OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR: return OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR;
    case OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM: return OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CATMULLROM;
    case OPTIX_PRIMITIVE_TYPE_SPHERE: return OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE;
    case OPTIX_PRIMITIVE_TYPE_TRIANGLE: return unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
    default: return 0;
    }
}

bool takesEndcaps(OptixPrimitiveType type) {
    return type >= OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE &&
           type <= OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM &&
           type != OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR;
}

void checkOptions(const OptixBuiltinISOptions& options, const CompileOptions& pipeline,
                  const ApiCall& call) {
    const Abi abi = call.context.abi;
    const OptixPrimitiveType type = options.builtinISModuleType;
    const unsigned flag = primitiveTypeFlag(type);
    if (type == OPTIX_PRIMITIVE_TYPE_CUSTOM)
        fail(Code::kInvalidValue, "builtinISOptions->builtinISModuleType is CUSTOM, which has no "
             "built-in intersection");
    if (!(flag & knownPrimitiveTypeFlags(abi)))
        fail(Code::kInvalidValue, "builtinISOptions->builtinISModuleType = ", unsigned(type),
             " is no primitive type of OptiX ", releaseOf(abi));
    if (!(unsigned(pipeline.values.usesPrimitiveTypeFlags) & flag))
        fail(Code::kInvalidValue, "pipelineCompileOptions->usesPrimitiveTypeFlags = ",
             unsigned(pipeline.values.usesPrimitiveTypeFlags),
             " lacks the type of builtinISOptions->builtinISModuleType = ", unsigned(type));
    if (options.buildFlags & ~knownBuildFlags(abi))
        fail(Code::kInvalidValue, "builtinISOptions->buildFlags = ", options.buildFlags,
             " has unknown bits");
    if (withOnePreference(options.buildFlags) != options.buildFlags)
        tolerate(call, "both are ignored", "builtinISOptions->buildFlags = ", options.buildFlags,
                 " has both PREFER_FAST_TRACE and PREFER_FAST_BUILD");
    if (options.curveEndcapFlags & ~unsigned(OPTIX_CURVE_ENDCAP_ON))
        fail(Code::kInvalidValue, "builtinISOptions->curveEndcapFlags = ", options.curveEndcapFlags,
             " has unknown bits");
    if (options.curveEndcapFlags != 0 && !takesEndcaps(type))
        tolerate(call, "it is ignored",
                 "builtinISOptions->curveEndcapFlags = ", options.curveEndcapFlags,
                 ": only quadratic and cubic curves have flat end caps");
}

uint32_t builtinOf(const OptixBuiltinISOptions& options) {
    engine::BuiltinOptions asked;
    asked.primitive = options.builtinISModuleType;
    const OptixPrimitiveType type = options.builtinISModuleType;
    asked.endcaps = takesEndcaps(type) && (options.curveEndcapFlags & OPTIX_CURVE_ENDCAP_ON);
    asked.motion = options.usesMotionBlur != 0;
    const unsigned flags = withOnePreference(options.buildFlags);
    asked.fastTrace = flags & OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
    asked.fastBuild = flags & OPTIX_BUILD_FLAG_PREFER_FAST_BUILD;
    return engine::packBuiltin(asked);
}

} // namespace

OptixResult builtinISModuleGet(OptixDeviceContext context,
                               const OptixModuleCompileOptions* moduleOptions,
                               const OptixPipelineCompileOptions* pipelineOptions,
                               const OptixBuiltinISOptions* builtinOptions, OptixModule* module) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixBuiltinISModuleGet", [&] {
        contextOf(context);
        requireNonNull(module, "builtinModule");
        *module = nullptr;
        requireNonNull(moduleOptions, "moduleCompileOptions");
        requireNonNull(builtinOptions, "builtinISOptions");
        const ApiCall call{*owner, "optixBuiltinISModuleGet"};
        checkCompileLevels(*moduleOptions, call);
        auto object = std::make_shared<ModuleObject>();
        object->context = owner;
        object->options = checkCompileOptions(pipelineOptions, owner->abi);
        checkOptions(*builtinOptions, object->options, call);
        object->builtinPrimitive = builtinOf(*builtinOptions);
        *module = static_cast<OptixModule>(modules().add(object));
    });
}

} // namespace sunstone::optix7
