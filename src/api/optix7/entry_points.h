// SPDX-License-Identifier: Apache-2.0
// The functions behind the function tables, by file. Signatures are those of the OptiX 7.6 API,
// except for build inputs and the leading ABI of some; adapter.h converts them to those of the
// tables.
#pragma once

#include "api/optix7/client_structs.h"

#include "optix.h"

namespace sunstone::optix7 {

// context.cpp
OptixResult deviceContextCreate(Abi, CUcontext, const OptixDeviceContextOptions*,
                                OptixDeviceContext*);
OptixResult deviceContextDestroy(OptixDeviceContext);
OptixResult deviceContextGetProperty(OptixDeviceContext, OptixDeviceProperty, void*, size_t);
OptixResult deviceContextSetLogCallback(OptixDeviceContext, OptixLogCallback, void*, unsigned);

// disk_cache.cpp
OptixResult deviceContextSetCacheEnabled(OptixDeviceContext, int);
OptixResult deviceContextSetCacheLocation(OptixDeviceContext, const char*);
OptixResult deviceContextSetCacheDatabaseSizes(OptixDeviceContext, size_t, size_t);
OptixResult deviceContextGetCacheEnabled(OptixDeviceContext, int*);
OptixResult deviceContextGetCacheLocation(OptixDeviceContext, char*, size_t);
OptixResult deviceContextGetCacheDatabaseSizes(OptixDeviceContext, size_t*, size_t*);

// module.cpp
OptixResult moduleCreateFromPTX(OptixDeviceContext, const OptixModuleCompileOptions*,
                                const OptixPipelineCompileOptions*, const char*, size_t, char*,
                                size_t*, OptixModule*);
OptixResult moduleDestroy(OptixModule);

// tasks.cpp
OptixResult moduleCreateFromPTXWithTasks(OptixDeviceContext, const OptixModuleCompileOptions*,
                                         const OptixPipelineCompileOptions*, const char*, size_t,
                                         char*, size_t*, OptixModule*, OptixTask*);
OptixResult moduleGetCompilationState(OptixModule, OptixModuleCompileState*);
OptixResult taskExecute(OptixTask, OptixTask*, unsigned, unsigned*);

// builtin.cpp
OptixResult builtinISModuleGet(OptixDeviceContext, const OptixModuleCompileOptions*,
                               const OptixPipelineCompileOptions*, const OptixBuiltinISOptions*,
                               OptixModule*);

// group.cpp
OptixResult programGroupCreate(OptixDeviceContext, const OptixProgramGroupDesc*, unsigned,
                               const OptixProgramGroupOptions*, char*, size_t*, OptixProgramGroup*);
OptixResult programGroupDestroy(OptixProgramGroup);
OptixResult programGroupGetStackSize(OptixProgramGroup, OptixStackSizes*);
OptixResult sbtRecordPackHeader(OptixProgramGroup, void*);

// pipeline.cpp
OptixResult pipelineCreate(OptixDeviceContext, const OptixPipelineCompileOptions*,
                           const OptixPipelineLinkOptions*, const OptixProgramGroup*, unsigned,
                           char*, size_t*, OptixPipeline*);
OptixResult pipelineCreate70(OptixDeviceContext, const OptixPipelineCompileOptions*,
                             const PipelineLinkOptions70*, const OptixProgramGroup*, unsigned,
                             char*, size_t*, OptixPipeline*);
OptixResult pipelineDestroy(OptixPipeline);
OptixResult pipelineSetStackSize(OptixPipeline, unsigned, unsigned, unsigned, unsigned);
OptixResult launch(OptixPipeline, CUstream, CUdeviceptr, size_t, const OptixShaderBindingTable*,
                   unsigned, unsigned, unsigned);

// accel.cpp
OptixResult accelComputeMemoryUsage(OptixDeviceContext, const OptixAccelBuildOptions*,
                                    BuildInputs, unsigned, OptixAccelBufferSizes*);
OptixResult accelBuild(OptixDeviceContext, CUstream, const OptixAccelBuildOptions*, BuildInputs,
                       unsigned, CUdeviceptr, size_t, CUdeviceptr, size_t, OptixTraversableHandle*,
                       const OptixAccelEmitDesc*, unsigned);
OptixResult accelCompact(OptixDeviceContext, CUstream, OptixTraversableHandle, CUdeviceptr, size_t,
                         OptixTraversableHandle*);

// relocation.cpp
OptixResult accelGetRelocationInfo(OptixDeviceContext, OptixTraversableHandle,
                                   OptixRelocationInfo*);
OptixResult checkRelocationCompatibility(OptixDeviceContext, const OptixRelocationInfo*, int*);
OptixResult accelRelocate(OptixDeviceContext, CUstream, const OptixRelocationInfo*,
                          const OptixRelocateInput*, size_t, CUdeviceptr, size_t,
                          OptixTraversableHandle*);
// The form until 7.5, with an array of instance handles.
OptixResult accelRelocateChildren(OptixDeviceContext, CUstream, const OptixRelocationInfo*,
                                  CUdeviceptr, size_t, CUdeviceptr, size_t,
                                  OptixTraversableHandle*);
OptixResult convertPointerToTraversableHandle(OptixDeviceContext, CUdeviceptr, OptixTraversableType,
                                              OptixTraversableHandle*);

// micromap.cpp
OptixResult opacityMicromapArrayComputeMemoryUsage(OptixDeviceContext,
                                                   const OptixOpacityMicromapArrayBuildInput*,
                                                   OptixMicromapBufferSizes*);
OptixResult opacityMicromapArrayBuild(OptixDeviceContext, CUstream,
                                      const OptixOpacityMicromapArrayBuildInput*,
                                      const OptixMicromapBuffers*);
OptixResult opacityMicromapArrayGetRelocationInfo(OptixDeviceContext, CUdeviceptr,
                                                  OptixRelocationInfo*);
OptixResult opacityMicromapArrayRelocate(OptixDeviceContext, CUstream, const OptixRelocationInfo*,
                                         CUdeviceptr, size_t);

// denoiser.cpp; the two versions of a function are those from 7.3 on and those before
OptixResult denoiserCreate(OptixDeviceContext, OptixDenoiserModelKind, const OptixDenoiserOptions*,
                           OptixDenoiser*);
OptixResult denoiserCreate70(OptixDeviceContext, const DenoiserOptions70*, OptixDenoiser*);
OptixResult denoiserSetModel(OptixDenoiser, int, const void*, size_t);
OptixResult denoiserInvoke70(OptixDenoiser, CUstream, const OptixDenoiserParams*, CUdeviceptr,
                             size_t, const OptixImage2D*, unsigned, unsigned, unsigned,
                             const OptixImage2D*, CUdeviceptr, size_t);
OptixResult denoiserCreateWithUserModel(OptixDeviceContext, const void*, size_t, OptixDenoiser*);
OptixResult denoiserDestroy(OptixDenoiser);
OptixResult denoiserComputeMemoryResources(OptixDenoiser, unsigned, unsigned, OptixDenoiserSizes*);
OptixResult denoiserSetup(OptixDenoiser, CUstream, unsigned, unsigned, CUdeviceptr, size_t,
                          CUdeviceptr, size_t);
OptixResult denoiserInvoke(OptixDenoiser, CUstream, const OptixDenoiserParams*, CUdeviceptr, size_t,
                           const OptixDenoiserGuideLayer*, const OptixDenoiserLayer*, unsigned,
                           unsigned, unsigned, CUdeviceptr, size_t);
OptixResult denoiserComputeIntensity(OptixDenoiser, CUstream, const OptixImage2D*, CUdeviceptr,
                                     CUdeviceptr, size_t);
OptixResult denoiserComputeAverageColor(OptixDenoiser, CUstream, const OptixImage2D*, CUdeviceptr,
                                        CUdeviceptr, size_t);

} // namespace sunstone::optix7
