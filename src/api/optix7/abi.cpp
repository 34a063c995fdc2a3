// SPDX-License-Identifier: Apache-2.0
// See abi.h.
#include "api/optix7/abi.h"

namespace sunstone::optix7 {

const char* releaseOf(Abi abi) {
    switch (abi) {
    case kAbi70:
        return "7.0";
    case kAbi71:
        return "7.1";
    case kAbi72:
        return "7.2";
    case kAbi73:
        return "7.3";
    case kAbi74:
        return "7.4";
    case kAbi75:
        return "7.5";
    case kAbi76:
        return "7.6";
    }
    return "unknown";
}

unsigned knownBuildFlags(Abi abi) {
    unsigned flags = OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_COMPACTION |
                     OPTIX_BUILD_FLAG_PREFER_FAST_TRACE | OPTIX_BUILD_FLAG_PREFER_FAST_BUILD |
                     OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
    if (abi >= kAbi73)
        flags |= OPTIX_BUILD_FLAG_ALLOW_RANDOM_INSTANCE_ACCESS;
    if (abi >= kAbi76)
        flags |= OPTIX_BUILD_FLAG_ALLOW_OPACITY_MICROMAP_UPDATE |
                 OPTIX_BUILD_FLAG_ALLOW_DISABLE_OPACITY_MICROMAPS;
    return flags;
}

unsigned knownGeometryFlags(Abi abi) {
    unsigned flags =
        OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT | OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
    if (abi >= kAbi75)
        flags |= OPTIX_GEOMETRY_FLAG_DISABLE_TRIANGLE_FACE_CULLING;
    return flags;
}

unsigned knownPrimitiveTypeFlags(Abi abi) {
    unsigned flags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM) |
                     OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_QUADRATIC_BSPLINE |
                     OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE |
                     OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR |
                     unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
    if (abi >= kAbi74)
        flags |= OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CATMULLROM;
    if (abi >= kAbi75)
        flags |= OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE;
    return flags;
}

unsigned knownInstanceFlags(Abi abi) {
    unsigned flags = OPTIX_INSTANCE_FLAG_DISABLE_TRIANGLE_FACE_CULLING |
                     OPTIX_INSTANCE_FLAG_FLIP_TRIANGLE_FACING | OPTIX_INSTANCE_FLAG_DISABLE_ANYHIT |
                     OPTIX_INSTANCE_FLAG_ENFORCE_ANYHIT;
    if (abi < kAbi74)
        flags |= kInstanceFlagDisableTransform;
    if (abi >= kAbi76)
        flags |= OPTIX_INSTANCE_FLAG_FORCE_OPACITY_MICROMAP_2_STATE |
                 OPTIX_INSTANCE_FLAG_DISABLE_OPACITY_MICROMAPS;
    return flags;
}

OptixCompileOptimizationLevel optLevelOf70(int level) {
    constexpr OptixCompileOptimizationLevel kLevels[] = {
        OPTIX_COMPILE_OPTIMIZATION_LEVEL_0, OPTIX_COMPILE_OPTIMIZATION_LEVEL_1,
        OPTIX_COMPILE_OPTIMIZATION_LEVEL_2, OPTIX_COMPILE_OPTIMIZATION_LEVEL_3};
    return level >= 0 && level < 4 ? kLevels[level] : OptixCompileOptimizationLevel(-1);
}

OptixCompileDebugLevel debugLevelOf70(int level) {
    constexpr OptixCompileDebugLevel kLevels[] = {OPTIX_COMPILE_DEBUG_LEVEL_NONE,
                                                  OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL,
                                                  OPTIX_COMPILE_DEBUG_LEVEL_FULL};
    return level >= 0 && level < 3 ? kLevels[level] : OptixCompileDebugLevel(-1);
}

} // namespace sunstone::optix7
