// SPDX-License-Identifier: Apache-2.0
// OptiX 7.4 host functions. Applications call them through optix_stubs.h, which loads the library.
// optix_7_types.h has the structs. Source: OptiX API reference 7.4, sections 3.2 to 3.11; each
// comment ends with its section.
//
// Rules for all functions: any result except OPTIX_SUCCESS is an error and logs a line with
// parameter, value and rule. Functions are thread-safe, except that an object must not be destroyed
// while in use. Work is queued on the given stream, whose CUDA context must be current; handles and
// sizes are returned at once. OPTIX_ERROR_INVALID_VALUE: a required pointer is null, a number is
// out of range, or an address is misaligned. OPTIX_ERROR_INVALID_DEVICE_CONTEXT: the context is not
// live.
//
// "Log string" below: logString (optional) receives the compiler's messages for this call, which
// also go to the context's log callback. logStringSize (optional): in, capacity in bytes; out,
// length of the whole text with its terminating zero, which may exceed the capacity; the text is
// then truncated.
#ifndef SUNSTONE_OPTIX7_OPTIX_7_HOST_H
#define SUNSTONE_OPTIX7_OPTIX_7_HOST_H

#include "optix_7_types.h"

#if !defined(OPTIX_DONT_INCLUDE_CUDA)
#include <cuda.h> /* CUcontext, CUstream; define the macro and the types to use another header */
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Errors ---- */

/** Spelling of the enumerator, or "Unrecognized OptixResult code". Never null. [3.3.2.1] */
const char* optixGetErrorName(OptixResult result);
/** Short description, or "Unrecognized OptixResult code". Never null. [3.3.2.2] */
const char* optixGetErrorString(OptixResult result);

/* ---- Device context ---- */

/** Creates a context on the device of fromContext; 0 means the calling thread's CUDA context.
    options: null for all zero.
    OPTIX_ERROR_CUDA_NOT_INITIALIZED: fromContext is 0 and no context is current.
    OPTIX_ERROR_CUDA_ERROR, OPTIX_ERROR_HOST_OUT_OF_MEMORY, OPTIX_ERROR_INTERNAL_ERROR. [3.4.2.1] */
OptixResult optixDeviceContextCreate(CUcontext fromContext,
                                     const OptixDeviceContextOptions* options,
                                     OptixDeviceContext* context);
/** Waits for pending launches, then destroys the context and all objects created from it. Other
    threads must not use it. [3.4.2.2] */
OptixResult optixDeviceContextDestroy(OptixDeviceContext context);
/** Writes a property to value; sizeInBytes is that of value, 4 for all properties. [3.4.2.6] */
OptixResult optixDeviceContextGetProperty(OptixDeviceContext context, OptixDeviceProperty property,
                                          void* value, size_t sizeInBytes);
/** Sets the receiver of log messages up to callbackLevel; a null function or level 0: no messages.
    Function and data change together, the level separately. [3.4.2.10] */
OptixResult optixDeviceContextSetLogCallback(OptixDeviceContext context,
                                             OptixLogCallback callbackFunction, void* callbackData,
                                             unsigned int callbackLevel);
/** Turns the disk cache on (1) or off (0). OPTIX_ERROR_DISK_CACHE_*: it cannot be opened. The
    environment variable OPTIX_CACHE_MAXSIZE=0 turns it off regardless of this setting. [3.4.2.8] */
OptixResult optixDeviceContextSetCacheEnabled(OptixDeviceContext context, int enabled);
/** Sets the folder of the disk cache, which is created if missing and must serve no other purpose.
    OPTIX_ERROR_DISK_CACHE_*: the folder is unusable, and the cache is off; if the cache was off
    already, the error occurs when it is turned on. OPTIX_CACHE_PATH takes precedence. [3.4.2.9] */
OptixResult optixDeviceContextSetCacheLocation(OptixDeviceContext context, const char* location);
/** Sets the limits of the disk cache in bytes: if an entry would raise its size above
    highWaterMark, old entries are removed until the size with the new entry is at most
    lowWaterMark. 0 for either: no limit. OPTIX_ERROR_INVALID_VALUE: both non-zero and high below
    low. OPTIX_CACHE_MAXSIZE takes precedence; the low mark is then half of it. [3.4.2.7] */
OptixResult optixDeviceContextSetCacheDatabaseSizes(OptixDeviceContext context, size_t lowWaterMark,
                                                    size_t highWaterMark);
/** Returns whether the disk cache is on (1) or off (0). [3.4.2.4] */
OptixResult optixDeviceContextGetCacheEnabled(OptixDeviceContext context, int* enabled);
/** Writes the folder of the disk cache to location (locationSize bytes); an empty string if
    OPTIX_CACHE_MAXSIZE=0. OPTIX_ERROR_INVALID_VALUE: too small. [3.4.2.5] */
OptixResult optixDeviceContextGetCacheLocation(OptixDeviceContext context, char* location,
                                               size_t locationSize);
/** Returns the limits of the disk cache in bytes; 0 and 0 if OPTIX_CACHE_MAXSIZE=0. [3.4.2.3] */
OptixResult optixDeviceContextGetCacheDatabaseSizes(OptixDeviceContext context,
                                                    size_t* lowWaterMark, size_t* highWaterMark);

/* ---- Pipelines ---- */

/** Links program groups into a pipeline. pipelineCompileOptions: as for all its modules.
    OPTIX_ERROR_INVALID_VALUE: also for bound values that contradict each other;
    OPTIX_ERROR_PIPELINE_LINK_ERROR: symbols missing or defined twice, or options differ;
    OPTIX_ERROR_PIPELINE_OUT_OF_CONSTANT_MEMORY. Log string: see above. [3.5.2.1] */
OptixResult optixPipelineCreate(OptixDeviceContext context,
                                const OptixPipelineCompileOptions* pipelineCompileOptions,
                                const OptixPipelineLinkOptions* pipelineLinkOptions,
                                const OptixProgramGroup* programGroups,
                                unsigned int numProgramGroups, char* logString,
                                size_t* logStringSize, OptixPipeline* pipeline);
/** Destroys a pipeline that no other thread is using. [3.5.2.2] */
OptixResult optixPipelineDestroy(OptixPipeline pipeline);
/** Sets stack sizes in bytes: for direct callables called from intersection and any-hit programs
    (FromTraversal), for those called from ray generation, miss and closest-hit programs
    (FromState), and for everything else. optix_stack_size.h computes them.
    maxTraversableGraphDepth: the most traversables on a path; each structure and each transform
    counts as one. Default: sizes for call trees of depth 2 without motion transforms.
    [3.5.2.3] */
OptixResult optixPipelineSetStackSize(OptixPipeline pipeline,
                                      unsigned int directCallableStackSizeFromTraversal,
                                      unsigned int directCallableStackSizeFromState,
                                      unsigned int continuationStackSize,
                                      unsigned int maxTraversableGraphDepth);

/* ---- Modules and tasks ---- */

/** Compiles PTX text, up to PTXsize bytes or the first zero byte. Log string: see above.
    OPTIX_ERROR_INVALID_VALUE: null arguments, invalid options or bound values;
    OPTIX_ERROR_INVALID_PTX: invalid text; OPTIX_ERROR_INVALID_FUNCTION_USE and the related codes:
    misuse of device functions; OPTIX_ERROR_INTERNAL_COMPILER_ERROR. [3.6.2.2] */
OptixResult optixModuleCreateFromPTX(OptixDeviceContext context,
                                     const OptixModuleCompileOptions* moduleCompileOptions,
                                     const OptixPipelineCompileOptions* pipelineCompileOptions,
                                     const char* PTX, size_t PTXsize, char* logString,
                                     size_t* logStringSize, OptixModule* module);
/** Like optixModuleCreateFromPTX, but returns a task; optixTaskExecute does the work. Text and log
    string must live until the module is COMPLETED or FAILED. [3.6.2.3] */
OptixResult optixModuleCreateFromPTXWithTasks(
    OptixDeviceContext context, const OptixModuleCompileOptions* moduleCompileOptions,
    const OptixPipelineCompileOptions* pipelineCompileOptions, const char* PTX, size_t PTXsize,
    char* logString, size_t* logStringSize, OptixModule* module, OptixTask* firstTask);
/** Returns the state of a module compiled with tasks; callable from any thread. [3.6.2.5] */
OptixResult optixModuleGetCompilationState(OptixModule module, OptixModuleCompileState* state);
/** Destroys a module that no program group uses.
    OPTIX_ERROR_ILLEGAL_DURING_TASK_EXECUTE: one of its tasks is running. [3.6.2.4] */
OptixResult optixModuleDestroy(OptixModule module);
/** Returns the module with the intersection program of a built-in primitive, for
    OptixProgramGroupHitgroup::moduleIS with a null name. [3.6.2.1] */
OptixResult optixBuiltinISModuleGet(OptixDeviceContext context,
                                    const OptixModuleCompileOptions* moduleCompileOptions,
                                    const OptixPipelineCompileOptions* pipelineCompileOptions,
                                    const OptixBuiltinISOptions* builtinISOptions,
                                    OptixModule* builtinModule);
/** Runs a task, on any thread and in any order. It may create further tasks: up to
    maxNumAdditionalTasks in additionalTasks, their number in numAdditionalTasksCreated.
    [3.7.2.1] */
OptixResult optixTaskExecute(OptixTask task, OptixTask* additionalTasks,
                             unsigned int maxNumAdditionalTasks,
                             unsigned int* numAdditionalTasksCreated);

/* ---- Program groups ---- */

/** Returns the stack sizes in bytes of the programs of a group; 0 for absent ones. [3.8.2.3] */
OptixResult optixProgramGroupGetStackSize(OptixProgramGroup programGroup,
                                          OptixStackSizes* stackSizes);
/** Creates numProgramGroups groups from as many descriptions. options: null for all zero. Log
    string: see above. OPTIX_ERROR_INVALID_VALUE: also if a name is missing in its module or lacks
    the prefix of its kind; OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH,
    OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED: see OptixProgramGroupOptions. [3.8.2.1] */
OptixResult optixProgramGroupCreate(OptixDeviceContext context,
                                    const OptixProgramGroupDesc* programDescriptions,
                                    unsigned int numProgramGroups,
                                    const OptixProgramGroupOptions* options, char* logString,
                                    size_t* logStringSize, OptixProgramGroup* programGroups);
/** Destroys a group that no other thread is using. [3.8.2.2] */
OptixResult optixProgramGroupDestroy(OptixProgramGroup programGroup);

/* ---- Launch ---- */

/** Runs the ray generation program width * height * depth times (at most 2^30, no size 0).
    pipelineParams: device address of pipelineParamsSize bytes, copied in stream order into the
    launch parameter variable; ignored if no module has it; OPTIX_ERROR_INVALID_VALUE if larger than
    the variable. sbt: in host memory, its records in device memory. Launches of one pipeline must
    not overlap. [3.9.2.1] */
OptixResult optixLaunch(OptixPipeline pipeline, CUstream stream, CUdeviceptr pipelineParams,
                        size_t pipelineParamsSize, const OptixShaderBindingTable* sbt,
                        unsigned int width, unsigned int height, unsigned int depth);
/** Writes the OPTIX_SBT_RECORD_HEADER_SIZE bytes at the start of a record, on the host; they may be
    copied freely and used with every pipeline that contains the group. [3.9.2.2] */
OptixResult optixSbtRecordPackHeader(OptixProgramGroup programGroup,
                                     void* sbtRecordHeaderHostPointer);

/* ---- Acceleration structures ---- */

/** Computes buffer sizes for a build of inputs of this shape; reads host memory only.
    numBuildInputs: at least 1. [3.10.2.4] */
OptixResult optixAccelComputeMemoryUsage(OptixDeviceContext context,
                                         const OptixAccelBuildOptions* accelOptions,
                                         const OptixBuildInput* buildInputs,
                                         unsigned int numBuildInputs,
                                         OptixAccelBufferSizes* bufferSizes);
/** Builds or updates a structure in outputBuffer, where it stays; tempBuffer and the inputs may be
    freed when the stream is done. Both buffers have alignment OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT and
    at least the sizes of optixAccelComputeMemoryUsage. numBuildInputs: at least 1, for instances
    exactly 1. emittedProperties: numEmittedProperties elements, may be 0. [3.10.2.1] */
OptixResult optixAccelBuild(OptixDeviceContext context, CUstream stream,
                            const OptixAccelBuildOptions* accelOptions,
                            const OptixBuildInput* buildInputs, unsigned int numBuildInputs,
                            CUdeviceptr tempBuffer, size_t tempBufferSizeInBytes,
                            CUdeviceptr outputBuffer, size_t outputBufferSizeInBytes,
                            OptixTraversableHandle* outputHandle,
                            const OptixAccelEmitDesc* emittedProperties,
                            unsigned int numEmittedProperties);
/** Returns the information needed to relocate a structure or its copies. OPTIX_ERROR_INVALID_VALUE:
    handle is not from a build. [3.10.2.5] */
#if SUNSTONE_OPTIX_API >= 70600
OptixResult optixAccelGetRelocationInfo(OptixDeviceContext context, OptixTraversableHandle handle,
                                        OptixRelocationInfo* info);
/** Sets compatible to 1 if a structure or micromap array described by info can be used on the
    context's device, else to 0. A device is compatible with itself. [7.6] */
OptixResult optixCheckRelocationCompatibility(OptixDeviceContext context,
                                              const OptixRelocationInfo* info, int* compatible);
/** Makes a copy usable at its new address: targetAccel holds all targetAccelSizeInBytes bytes of
    the original, with alignment OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT; the original may have been
    freed. relocateInputs: in host memory, one for each build input of the original, with the new
    addresses of child traversables or micromap arrays; null and 0 keep the old ones. Boxes are not
    recomputed. [7.6] */
OptixResult optixAccelRelocate(OptixDeviceContext context, CUstream stream,
                               const OptixRelocationInfo* info,
                               const OptixRelocateInput* relocateInputs, size_t numRelocateInputs,
                               CUdeviceptr targetAccel, size_t targetAccelSizeInBytes,
                               OptixTraversableHandle* targetHandle);
#else
OptixResult optixAccelGetRelocationInfo(OptixDeviceContext context, OptixTraversableHandle handle,
                                        OptixAccelRelocationInfo* info);
/** Sets compatible to 1 if a structure described by info can be used on the context's device, else
    to 0. A device is compatible with itself. [3.10.2.2] */
OptixResult optixAccelCheckRelocationCompatibility(OptixDeviceContext context,
                                                   const OptixAccelRelocationInfo* info,
                                                   int* compatible);
/** Makes a copy usable at its new address: targetAccel holds all targetAccelSizeInBytes bytes of
    the original, with alignment OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT; the original may have been
    freed. Instance structures: instanceTraversableHandles is a device array of new child handles,
    one per instance; 0 and 0 keep the old ones. Boxes are not recomputed. [3.10.2.6] */
OptixResult optixAccelRelocate(OptixDeviceContext context, CUstream stream,
                               const OptixAccelRelocationInfo* info,
                               CUdeviceptr instanceTraversableHandles,
                               size_t numInstanceTraversableHandles, CUdeviceptr targetAccel,
                               size_t targetAccelSizeInBytes, OptixTraversableHandle* targetHandle);
#endif
/** Copies a structure built with ALLOW_COMPACTION into a smaller buffer: outputBuffer has alignment
    OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT, at least the emitted COMPACTED_SIZE bytes, and no overlap
    with the source, which may be freed when the stream is done. [3.10.2.3] */
OptixResult optixAccelCompact(OptixDeviceContext context, CUstream stream,
                              OptixTraversableHandle inputHandle, CUdeviceptr outputBuffer,
                              size_t outputBufferSizeInBytes, OptixTraversableHandle* outputHandle);
/** Creates a handle (in host memory) of a transform in device memory with alignment
    OPTIX_TRANSFORM_BYTE_ALIGNMENT. [3.10.2.7] */
OptixResult optixConvertPointerToTraversableHandle(OptixDeviceContext onDevice, CUdeviceptr pointer,
                                                   OptixTraversableType traversableType,
                                                   OptixTraversableHandle* traversableHandle);

#if SUNSTONE_OPTIX_API >= 70600
/* ---- Opacity micromaps ---- */

/** Computes buffer sizes for a build of a micromap array; reads the histogram only. [7.6] */
OptixResult
optixOpacityMicromapArrayComputeMemoryUsage(OptixDeviceContext context,
                                            const OptixOpacityMicromapArrayBuildInput* buildInput,
                                            OptixMicromapBufferSizes* bufferSizes);
/** Builds a micromap array in buffers->output, where it stays; temp and the input may be freed when
    the stream is done. [7.6] */
OptixResult optixOpacityMicromapArrayBuild(OptixDeviceContext context, CUstream stream,
                                           const OptixOpacityMicromapArrayBuildInput* buildInput,
                                           const OptixMicromapBuffers* buffers);
/** Returns the information needed to relocate a micromap array or its copies. [7.6] */
OptixResult optixOpacityMicromapArrayGetRelocationInfo(OptixDeviceContext context,
                                                       CUdeviceptr opacityMicromapArray,
                                                       OptixRelocationInfo* info);
/** Makes a copy usable at its new address, with alignment
    OPTIX_OPACITY_MICROMAP_ARRAY_BUFFER_BYTE_ALIGNMENT and the size of the original, which may have
    been freed. Structures refer to the original's address until they are updated or relocated.
    [7.6] */
OptixResult optixOpacityMicromapArrayRelocate(OptixDeviceContext context, CUstream stream,
                                              const OptixRelocationInfo* info,
                                              CUdeviceptr targetOpacityMicromapArray,
                                              size_t targetOpacityMicromapArraySizeInBytes);
#endif

/* ---- Denoiser ---- */

/** Creates a denoiser with a built-in model. [3.11.2.4] */
OptixResult optixDenoiserCreate(OptixDeviceContext context, OptixDenoiserModelKind modelKind,
                                const OptixDenoiserOptions* options, OptixDenoiser* denoiser);
/** Creates a denoiser with the model in userData, which is read only during the call; the model
    determines kind and guide images. OPTIX_ERROR_INVALID_FILE_FORMAT: not a model. [3.11.2.5] */
OptixResult optixDenoiserCreateWithUserModel(OptixDeviceContext context, const void* userData,
                                             size_t userDataSizeInBytes, OptixDenoiser* denoiser);
/** Destroys a denoiser and its host memory. [3.11.2.6] */
OptixResult optixDenoiserDestroy(OptixDenoiser denoiser);
/** Returns the memory sizes of a denoiser, in bytes, for images of outputWidth * outputHeight
    pixels; tiles without their overlap. [3.11.2.3] */
OptixResult optixDenoiserComputeMemoryResources(const OptixDenoiser denoiser,
                                                unsigned int outputWidth, unsigned int outputHeight,
                                                OptixDenoiserSizes* returnSizes);
/** Initialises the state memory. inputWidth, inputHeight: largest input image, tiles with overlap
   on both sides. [3.11.2.8] */
OptixResult optixDenoiserSetup(OptixDenoiser denoiser, CUstream stream, unsigned int inputWidth,
                               unsigned int inputHeight, CUdeviceptr denoiserState,
                               size_t denoiserStateSizeInBytes, CUdeviceptr scratch,
                               size_t scratchSizeInBytes);
/** Denoises numLayers images. layers[0] is the beauty image, the others are for AOV models only.
    guideLayer: required; images not enabled at creation are ignored; temporal models need flow.
    inputOffsetX, inputOffsetY: first pixel of a tile without its overlap; 0 for whole images and at
    image borders. The state must persist between calls, scratch only until the stream is done.
    OPTIX_ERROR_DENOISER_NOT_INITIALIZED: optixDenoiserSetup has not been called. [3.11.2.7] */
OptixResult optixDenoiserInvoke(OptixDenoiser denoiser, CUstream stream,
                                const OptixDenoiserParams* params, CUdeviceptr denoiserState,
                                size_t denoiserStateSizeInBytes,
                                const OptixDenoiserGuideLayer* guideLayer,
                                const OptixDenoiserLayer* layers, unsigned int numLayers,
                                unsigned int inputOffsetX, unsigned int inputOffsetY,
                                CUdeviceptr scratch, size_t scratchSizeInBytes);
/** Computes the factor that scales an image to middle grey: 0.18 / exp(mean of log(luminance)),
    over the pixels whose luminance 0.212586 r + 0.715170 g + 0.072200 b exceeds 1e-8.
    outputIntensity: one float in device memory. Image: 3 or 4 floats or halves per pixel. scratch:
    at least 4 * (2 + width * height) bytes (7.6: the size from
    optixDenoiserComputeMemoryResources). [3.11.2.2] */
OptixResult optixDenoiserComputeIntensity(OptixDenoiser denoiser, CUstream stream,
                                          const OptixImage2D* inputImage,
                                          CUdeviceptr outputIntensity, CUdeviceptr scratch,
                                          size_t scratchSizeInBytes);
/** Computes the mean logarithm of each colour channel. outputAverageColor: three floats in device
    memory. Image as above. scratch: at least 4 * (3 + 3 * width * height) bytes (7.6: the size from
    optixDenoiserComputeMemoryResources). [3.11.2.1] */
OptixResult optixDenoiserComputeAverageColor(OptixDenoiser denoiser, CUstream stream,
                                             const OptixImage2D* inputImage,
                                             CUdeviceptr outputAverageColor, CUdeviceptr scratch,
                                             size_t scratchSizeInBytes);

#ifdef __cplusplus
}
#endif

#endif
