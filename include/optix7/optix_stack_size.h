// SPDX-License-Identifier: Apache-2.0
// Computes the arguments of optixPipelineSetStackSize from the stack sizes of program groups. Needs
// the stubs or another definition of optixProgramGroupGetStackSize. Source: OptiX API reference
// 7.4, sections 3.14.2.4 to 3.14.2.8, 6.13; the formulas are those of the programming guide.
//
// Words: css, continuation stack of a program in bytes; dss, direct stack in bytes; RG ray
// generation, MS miss, CH closest-hit, AH any-hit, IS intersection, CC continuation callable, DC
// direct callable. A state is the larger of CH and MS, plus the tree of CC below it. Each trace
// needs a state; the innermost one may instead need IS plus AH. All sizes are bytes; result
// pointers may be null.
#ifndef SUNSTONE_OPTIX7_OPTIX_STACK_SIZE_H
#define SUNSTONE_OPTIX7_OPTIX_STACK_SIZE_H

#include "optix_host.h"

#if defined(__cplusplus)
#define OPTIX_UTIL_INLINE inline
#else
#define OPTIX_UTIL_INLINE static inline
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Raises each member of stackSizes to the needs of programGroup; initialise all members to 0.
    OPTIX_ERROR_INVALID_VALUE: null arguments. [3.14.2.4] */
OPTIX_UTIL_INLINE OptixResult optixUtilAccumulateStackSizes(OptixProgramGroup programGroup,
                                                            OptixStackSizes* stackSizes) {
    OptixStackSizes group;
    OptixResult result;
    if (!stackSizes)
        return OPTIX_ERROR_INVALID_VALUE;
    result = optixProgramGroupGetStackSize(programGroup, &group);
    if (result != OPTIX_SUCCESS)
        return result;
#define OPTIX_UTIL_RAISE(member)                                                                   \
    if (stackSizes->member < group.member)                                                         \
    stackSizes->member = group.member
    OPTIX_UTIL_RAISE(cssRG);
    OPTIX_UTIL_RAISE(cssMS);
    OPTIX_UTIL_RAISE(cssCH);
    OPTIX_UTIL_RAISE(cssAH);
    OPTIX_UTIL_RAISE(cssIS);
    OPTIX_UTIL_RAISE(cssCC);
    OPTIX_UTIL_RAISE(dssDC);
#undef OPTIX_UTIL_RAISE
    return OPTIX_SUCCESS;
}

/** Sizes for call trees whose continuation callables need cssCCTree bytes in all; direct callables
    nest maxDCDepth deep. OPTIX_ERROR_INVALID_VALUE: stackSizes is null. [3.14.2.6] */
OPTIX_UTIL_INLINE OptixResult optixUtilComputeStackSizesCssCCTree(
    const OptixStackSizes* stackSizes, unsigned int cssCCTree, unsigned int maxTraceDepth,
    unsigned int maxDCDepth, unsigned int* directCallableStackSizeFromTraversal,
    unsigned int* directCallableStackSizeFromState, unsigned int* continuationStackSize) {
    unsigned int state, innermost;
    if (!stackSizes)
        return OPTIX_ERROR_INVALID_VALUE;
    state =
        (stackSizes->cssCH > stackSizes->cssMS ? stackSizes->cssCH : stackSizes->cssMS) + cssCCTree;
    innermost = stackSizes->cssIS + stackSizes->cssAH;
    if (innermost < state)
        innermost = state;
    if (directCallableStackSizeFromTraversal)
        *directCallableStackSizeFromTraversal = maxDCDepth * stackSizes->dssDC;
    if (directCallableStackSizeFromState)
        *directCallableStackSizeFromState = maxDCDepth * stackSizes->dssDC;
    if (continuationStackSize)
        *continuationStackSize = stackSizes->cssRG + cssCCTree +
                                 (maxTraceDepth ? (maxTraceDepth - 1) * state + innermost : 0);
    return OPTIX_SUCCESS;
}

/** Sizes for continuation callables maxCCDepth and direct callables maxDCDepth deep.
    OPTIX_ERROR_INVALID_VALUE: stackSizes is null. [3.14.2.5] */
OPTIX_UTIL_INLINE OptixResult optixUtilComputeStackSizes(
    const OptixStackSizes* stackSizes, unsigned int maxTraceDepth, unsigned int maxCCDepth,
    unsigned int maxDCDepth, unsigned int* directCallableStackSizeFromTraversal,
    unsigned int* directCallableStackSizeFromState, unsigned int* continuationStackSize) {
    if (!stackSizes)
        return OPTIX_ERROR_INVALID_VALUE;
    return optixUtilComputeStackSizesCssCCTree(
        stackSizes, maxCCDepth * stackSizes->cssCC, maxTraceDepth, maxDCDepth,
        directCallableStackSizeFromTraversal, directCallableStackSizeFromState,
        continuationStackSize);
}

/** Like optixUtilComputeStackSizes, with separate sizes for direct callables called FromTraversal
    (in IS and AH) and FromState (in RG, MS and CH); stackSizes->dssDC is not used.
    OPTIX_ERROR_INVALID_VALUE: stackSizes is null. [3.14.2.7] */
OPTIX_UTIL_INLINE OptixResult optixUtilComputeStackSizesDCSplit(
    const OptixStackSizes* stackSizes, unsigned int dssDCFromTraversal, unsigned int dssDCFromState,
    unsigned int maxTraceDepth, unsigned int maxCCDepth, unsigned int maxDCDepthFromTraversal,
    unsigned int maxDCDepthFromState, unsigned int* directCallableStackSizeFromTraversal,
    unsigned int* directCallableStackSizeFromState, unsigned int* continuationStackSize) {
    if (!stackSizes)
        return OPTIX_ERROR_INVALID_VALUE;
    if (directCallableStackSizeFromTraversal)
        *directCallableStackSizeFromTraversal = maxDCDepthFromTraversal * dssDCFromTraversal;
    if (directCallableStackSizeFromState)
        *directCallableStackSizeFromState = maxDCDepthFromState * dssDCFromState;
    return optixUtilComputeStackSizesCssCCTree(stackSizes, maxCCDepth * stackSizes->cssCC,
                                               maxTraceDepth, 0, NULL, NULL, continuationStackSize);
}

/** Sizes for a path tracer of two ray types without AH, IS and callables: RG traces rays that end
    in MS1 or one of the CH1; a CH1 may trace shadow rays that end in MS2 or one of the CH2. MS2 may
    be null and CH2 empty. OPTIX_ERROR_INVALID_VALUE: an array is null but its count is not 0.
    [3.14.2.8] */
OPTIX_UTIL_INLINE OptixResult optixUtilComputeStackSizesSimplePathTracer(
    OptixProgramGroup programGroupRG, OptixProgramGroup programGroupMS1,
    const OptixProgramGroup* programGroupCH1, unsigned int programGroupCH1Count,
    OptixProgramGroup programGroupMS2, const OptixProgramGroup* programGroupCH2,
    unsigned int programGroupCH2Count, unsigned int* directCallableStackSizeFromTraversal,
    unsigned int* directCallableStackSizeFromState, unsigned int* continuationStackSize) {
    OptixStackSizes camera = {0, 0, 0, 0, 0, 0, 0}; /* RG, MS1, CH1 */
    OptixStackSizes shadow = {0, 0, 0, 0, 0, 0, 0}; /* MS2, CH2 */
    OptixResult result;
    unsigned int i, size;
    if ((programGroupCH1Count && !programGroupCH1) || (programGroupCH2Count && !programGroupCH2))
        return OPTIX_ERROR_INVALID_VALUE;
    result = optixUtilAccumulateStackSizes(programGroupRG, &camera);
    if (result == OPTIX_SUCCESS)
        result = optixUtilAccumulateStackSizes(programGroupMS1, &camera);
    for (i = 0; i < programGroupCH1Count && result == OPTIX_SUCCESS; ++i)
        result = optixUtilAccumulateStackSizes(programGroupCH1[i], &camera);
    if (programGroupMS2 && result == OPTIX_SUCCESS)
        result = optixUtilAccumulateStackSizes(programGroupMS2, &shadow);
    for (i = 0; i < programGroupCH2Count && result == OPTIX_SUCCESS; ++i)
        result = optixUtilAccumulateStackSizes(programGroupCH2[i], &shadow);
    if (result != OPTIX_SUCCESS)
        return result;
    size = camera.cssCH + (shadow.cssMS > shadow.cssCH ? shadow.cssMS : shadow.cssCH);
    if (size < camera.cssMS)
        size = camera.cssMS;
    if (directCallableStackSizeFromTraversal)
        *directCallableStackSizeFromTraversal = 0;
    if (directCallableStackSizeFromState)
        *directCallableStackSizeFromState = 0;
    if (continuationStackSize)
        *continuationStackSize = camera.cssRG + size;
    return OPTIX_SUCCESS;
}

#ifdef __cplusplus
}
#endif

#undef OPTIX_UTIL_INLINE

#endif
