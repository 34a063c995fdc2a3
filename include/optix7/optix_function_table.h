// SPDX-License-Identifier: Apache-2.0
// The table through which applications call the library: one pointer for each host function, in the
// order of ABI 55 (7.4) or 68 (7.6). Positions are binary interface: clients fill the table with
// optixQueryFunctionTable, and some use slot numbers. Source: OptiX API reference 7.4, sections
// 3.13, 5.18, 6.10.
#ifndef SUNSTONE_OPTIX7_OPTIX_FUNCTION_TABLE_H
#define SUNSTONE_OPTIX7_OPTIX_FUNCTION_TABLE_H

/** Number of this table layout and of the struct layouts of optix_7_types.h. */
#define OPTIX_ABI_VERSION 55

#include "optix_host.h"

#if SUNSTONE_OPTIX_API >= 70600
#undef OPTIX_ABI_VERSION
#define OPTIX_ABI_VERSION 68
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Filled by optixInit; optix_7_host.h describes the functions. */
typedef struct OptixFunctionTable {
    /* Error handling: slots 0 to 1 */
    const char* (*optixGetErrorName)(OptixResult result);
    const char* (*optixGetErrorString)(OptixResult result);

    /* Device context: slots 2 to 11 */
    OptixResult (*optixDeviceContextCreate)(CUcontext fromContext,
                                            const OptixDeviceContextOptions* options,
                                            OptixDeviceContext* context);
    OptixResult (*optixDeviceContextDestroy)(OptixDeviceContext context);
    OptixResult (*optixDeviceContextGetProperty)(OptixDeviceContext context,
                                                 OptixDeviceProperty property, void* value,
                                                 size_t sizeInBytes);
    OptixResult (*optixDeviceContextSetLogCallback)(OptixDeviceContext context,
                                                    OptixLogCallback callbackFunction,
                                                    void* callbackData, unsigned int callbackLevel);
    OptixResult (*optixDeviceContextSetCacheEnabled)(OptixDeviceContext context, int enabled);
    OptixResult (*optixDeviceContextSetCacheLocation)(OptixDeviceContext context,
                                                      const char* location);
    OptixResult (*optixDeviceContextSetCacheDatabaseSizes)(OptixDeviceContext context,
                                                           size_t lowWaterMark,
                                                           size_t highWaterMark);
    OptixResult (*optixDeviceContextGetCacheEnabled)(OptixDeviceContext context, int* enabled);
    OptixResult (*optixDeviceContextGetCacheLocation)(OptixDeviceContext context, char* location,
                                                      size_t locationSize);
    OptixResult (*optixDeviceContextGetCacheDatabaseSizes)(OptixDeviceContext context,
                                                           size_t* lowWaterMark,
                                                           size_t* highWaterMark);

    /* Modules, tasks: slots 12 to 17 */
    OptixResult (*optixModuleCreateFromPTX)(
        OptixDeviceContext context, const OptixModuleCompileOptions* moduleCompileOptions,
        const OptixPipelineCompileOptions* pipelineCompileOptions, const char* PTX, size_t PTXsize,
        char* logString, size_t* logStringSize, OptixModule* module);
    OptixResult (*optixModuleCreateFromPTXWithTasks)(
        OptixDeviceContext context, const OptixModuleCompileOptions* moduleCompileOptions,
        const OptixPipelineCompileOptions* pipelineCompileOptions, const char* PTX, size_t PTXsize,
        char* logString, size_t* logStringSize, OptixModule* module, OptixTask* firstTask);
    OptixResult (*optixModuleGetCompilationState)(OptixModule module,
                                                  OptixModuleCompileState* state);
    OptixResult (*optixModuleDestroy)(OptixModule module);
    OptixResult (*optixBuiltinISModuleGet)(
        OptixDeviceContext context, const OptixModuleCompileOptions* moduleCompileOptions,
        const OptixPipelineCompileOptions* pipelineCompileOptions,
        const OptixBuiltinISOptions* builtinISOptions, OptixModule* builtinModule);
    OptixResult (*optixTaskExecute)(OptixTask task, OptixTask* additionalTasks,
                                    unsigned int maxNumAdditionalTasks,
                                    unsigned int* numAdditionalTasksCreated);

    /* Program groups: slots 18 to 20 */
    OptixResult (*optixProgramGroupCreate)(OptixDeviceContext context,
                                           const OptixProgramGroupDesc* programDescriptions,
                                           unsigned int numProgramGroups,
                                           const OptixProgramGroupOptions* options, char* logString,
                                           size_t* logStringSize, OptixProgramGroup* programGroups);
    OptixResult (*optixProgramGroupDestroy)(OptixProgramGroup programGroup);
    OptixResult (*optixProgramGroupGetStackSize)(OptixProgramGroup programGroup,
                                                 OptixStackSizes* stackSizes);

    /* Pipelines: slots 21 to 23 */
    OptixResult (*optixPipelineCreate)(OptixDeviceContext context,
                                       const OptixPipelineCompileOptions* pipelineCompileOptions,
                                       const OptixPipelineLinkOptions* pipelineLinkOptions,
                                       const OptixProgramGroup* programGroups,
                                       unsigned int numProgramGroups, char* logString,
                                       size_t* logStringSize, OptixPipeline* pipeline);
    OptixResult (*optixPipelineDestroy)(OptixPipeline pipeline);
    OptixResult (*optixPipelineSetStackSize)(OptixPipeline pipeline,
                                             unsigned int directCallableStackSizeFromTraversal,
                                             unsigned int directCallableStackSizeFromState,
                                             unsigned int continuationStackSize,
                                             unsigned int maxTraversableGraphDepth);

    /* Acceleration structures: slots 24 to 32 */
    OptixResult (*optixAccelComputeMemoryUsage)(OptixDeviceContext context,
                                                const OptixAccelBuildOptions* accelOptions,
                                                const OptixBuildInput* buildInputs,
                                                unsigned int numBuildInputs,
                                                OptixAccelBufferSizes* bufferSizes);
    OptixResult (*optixAccelBuild)(OptixDeviceContext context, CUstream stream,
                                   const OptixAccelBuildOptions* accelOptions,
                                   const OptixBuildInput* buildInputs, unsigned int numBuildInputs,
                                   CUdeviceptr tempBuffer, size_t tempBufferSizeInBytes,
                                   CUdeviceptr outputBuffer, size_t outputBufferSizeInBytes,
                                   OptixTraversableHandle* outputHandle,
                                   const OptixAccelEmitDesc* emittedProperties,
                                   unsigned int numEmittedProperties);
#if SUNSTONE_OPTIX_API >= 70600
    OptixResult (*optixAccelGetRelocationInfo)(OptixDeviceContext context,
                                               OptixTraversableHandle handle,
                                               OptixRelocationInfo* info);
    OptixResult (*optixCheckRelocationCompatibility)(OptixDeviceContext context,
                                                     const OptixRelocationInfo* info,
                                                     int* compatible);
    OptixResult (*optixAccelRelocate)(OptixDeviceContext context, CUstream stream,
                                      const OptixRelocationInfo* info,
                                      const OptixRelocateInput* relocateInputs,
                                      size_t numRelocateInputs, CUdeviceptr targetAccel,
                                      size_t targetAccelSizeInBytes,
                                      OptixTraversableHandle* targetHandle);
#else
    OptixResult (*optixAccelGetRelocationInfo)(OptixDeviceContext context,
                                               OptixTraversableHandle handle,
                                               OptixAccelRelocationInfo* info);
    OptixResult (*optixAccelCheckRelocationCompatibility)(OptixDeviceContext context,
                                                          const OptixAccelRelocationInfo* info,
                                                          int* compatible);
    OptixResult (*optixAccelRelocate)(OptixDeviceContext context, CUstream stream,
                                      const OptixAccelRelocationInfo* info,
                                      CUdeviceptr instanceTraversableHandles,
                                      size_t numInstanceTraversableHandles, CUdeviceptr targetAccel,
                                      size_t targetAccelSizeInBytes,
                                      OptixTraversableHandle* targetHandle);
#endif
    OptixResult (*optixAccelCompact)(OptixDeviceContext context, CUstream stream,
                                     OptixTraversableHandle inputHandle, CUdeviceptr outputBuffer,
                                     size_t outputBufferSizeInBytes,
                                     OptixTraversableHandle* outputHandle);
    OptixResult (*optixConvertPointerToTraversableHandle)(
        OptixDeviceContext onDevice, CUdeviceptr pointer, OptixTraversableType traversableType,
        OptixTraversableHandle* traversableHandle);
#if SUNSTONE_OPTIX_API >= 70600
    /* ABI 68: slots 31 to 34; the numbers below grow by 4 */
    OptixResult (*optixOpacityMicromapArrayComputeMemoryUsage)(
        OptixDeviceContext context, const OptixOpacityMicromapArrayBuildInput* buildInput,
        OptixMicromapBufferSizes* bufferSizes);
    OptixResult (*optixOpacityMicromapArrayBuild)(
        OptixDeviceContext context, CUstream stream,
        const OptixOpacityMicromapArrayBuildInput* buildInput, const OptixMicromapBuffers* buffers);
    OptixResult (*optixOpacityMicromapArrayGetRelocationInfo)(OptixDeviceContext context,
                                                              CUdeviceptr opacityMicromapArray,
                                                              OptixRelocationInfo* info);
    OptixResult (*optixOpacityMicromapArrayRelocate)(OptixDeviceContext context, CUstream stream,
                                                     const OptixRelocationInfo* info,
                                                     CUdeviceptr targetOpacityMicromapArray,
                                                     size_t targetOpacityMicromapArraySizeInBytes);
#endif
    void (*reserved1)(void); /**< never null, does nothing */
    void (*reserved2)(void); /**< never null, does nothing */

    /* Launch: slots 33 to 34 */
    OptixResult (*optixSbtRecordPackHeader)(OptixProgramGroup programGroup,
                                            void* sbtRecordHeaderHostPointer);
    OptixResult (*optixLaunch)(OptixPipeline pipeline, CUstream stream, CUdeviceptr pipelineParams,
                               size_t pipelineParamsSize, const OptixShaderBindingTable* sbt,
                               unsigned int width, unsigned int height, unsigned int depth);

    /* Denoiser: slots 35 to 42 */
    OptixResult (*optixDenoiserCreate)(OptixDeviceContext context, OptixDenoiserModelKind modelKind,
                                       const OptixDenoiserOptions* options,
                                       OptixDenoiser* denoiser);
    OptixResult (*optixDenoiserDestroy)(OptixDenoiser denoiser);
    OptixResult (*optixDenoiserComputeMemoryResources)(const OptixDenoiser denoiser,
                                                       unsigned int outputWidth,
                                                       unsigned int outputHeight,
                                                       OptixDenoiserSizes* returnSizes);
    OptixResult (*optixDenoiserSetup)(OptixDenoiser denoiser, CUstream stream,
                                      unsigned int inputWidth, unsigned int inputHeight,
                                      CUdeviceptr denoiserState, size_t denoiserStateSizeInBytes,
                                      CUdeviceptr scratch, size_t scratchSizeInBytes);
    OptixResult (*optixDenoiserInvoke)(OptixDenoiser denoiser, CUstream stream,
                                       const OptixDenoiserParams* params, CUdeviceptr denoiserState,
                                       size_t denoiserStateSizeInBytes,
                                       const OptixDenoiserGuideLayer* guideLayer,
                                       const OptixDenoiserLayer* layers, unsigned int numLayers,
                                       unsigned int inputOffsetX, unsigned int inputOffsetY,
                                       CUdeviceptr scratch, size_t scratchSizeInBytes);
    OptixResult (*optixDenoiserComputeIntensity)(OptixDenoiser denoiser, CUstream stream,
                                                 const OptixImage2D* inputImage,
                                                 CUdeviceptr outputIntensity, CUdeviceptr scratch,
                                                 size_t scratchSizeInBytes);
    OptixResult (*optixDenoiserComputeAverageColor)(OptixDenoiser denoiser, CUstream stream,
                                                    const OptixImage2D* inputImage,
                                                    CUdeviceptr outputAverageColor,
                                                    CUdeviceptr scratch, size_t scratchSizeInBytes);
    OptixResult (*optixDenoiserCreateWithUserModel)(OptixDeviceContext context,
                                                    const void* userData,
                                                    size_t userDataSizeInBytes,
                                                    OptixDenoiser* denoiser);
} OptixFunctionTable;

#ifdef __cplusplus
}
#endif

#endif
