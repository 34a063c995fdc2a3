// SPDX-License-Identifier: Apache-2.0
// Loads the library and defines the host functions as calls through g_optixFunctionTable, so that
// an application needs no link library. One source file also includes
// optix_function_table_definition.h; on Linux link with -ldl if the C library requires it. Source:
// OptiX API reference 7.4, sections 3.14.2.1 to 3.14.2.3, 6.14.
#ifndef SUNSTONE_OPTIX7_OPTIX_STUBS_H
#define SUNSTONE_OPTIX7_OPTIX_STUBS_H

#include "optix_function_table.h"

#ifdef _WIN32
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN 1
#endif
#include <windows.h>
#else
#include <dlfcn.h>
#endif
#include <stddef.h>
#include <string.h>

/* In C++ several files may define an inline function. In C the host functions are already declared
   extern, and only weak definitions may be repeated. */
#if defined(__cplusplus)
#define OPTIX_STUB_INLINE inline
#elif defined(__GNUC__)
#define OPTIX_STUB_INLINE __attribute__((weak))
#else
#error "optix_stubs.h needs a C++ compiler, or GCC or Clang for C"
#endif

/* A call before optixInit returns an error instead of jumping to address 0. */
#define OPTIX_STUB_CALL(name, arguments)                                                           \
    return g_optixFunctionTable.name ? g_optixFunctionTable.name arguments                         \
                                     : OPTIX_ERROR_INVALID_OPERATION

#ifdef __cplusplus
extern "C" {
#endif

/** The table that all functions below call through; see optix_function_table_definition.h. */
extern OptixFunctionTable g_optixFunctionTable;

#ifdef _WIN32

/** Loads a library by file name: from the usual folders, else from those of the display drivers,
    where driver packages install it. Null if it is not found. */
static void* optixLoadWindowsDllFromName(const char* optixDllName) {
    /* The class of display adapters; each adapter has a subkey 0000, 0001, ... */
    static const char classKey[] = "SYSTEM\\CurrentControlSet\\Control\\Class\\"
                                   "{4d36e968-e325-11ce-bfc1-08002be10318}";
    HKEY adapters;
    DWORD index;
    void* library = (void*)LoadLibraryA(optixDllName);
    if (library || RegOpenKeyExA(HKEY_LOCAL_MACHINE, classKey, 0, KEY_READ, &adapters) != 0)
        return library;
    for (index = 0; !library; ++index) {
        char adapter[256];
        char path[MAX_PATH];
        char* end;
        DWORD adapterSize = sizeof(adapter);
        DWORD pathSize = sizeof(path);
        LSTATUS status =
            RegEnumKeyExA(adapters, index, adapter, &adapterSize, NULL, NULL, NULL, NULL);
        if (status != 0)
            break;
        /* The OpenGL driver is in the same folder as the ray tracing one. */
        if (RegGetValueA(adapters, adapter, "OpenGLDriverName", RRF_RT_REG_SZ | RRF_RT_REG_MULTI_SZ,
                         NULL, path, &pathSize) != 0)
            continue;
        end = strrchr(path, '\\');
        if (!end || (size_t)(end - path) + 1 + strlen(optixDllName) >= sizeof(path))
            continue;
        memcpy(end + 1, optixDllName, strlen(optixDllName) + 1);
        library = (void*)LoadLibraryA(path);
    }
    RegCloseKey(adapters);
    return library;
}

/** Loads nvoptix.dll; null if it is not found. */
static void* optixLoadWindowsDll(void) {
    return optixLoadWindowsDllFromName("nvoptix.dll");
}

#endif

/** Loads the library (libnvoptix.so.1, nvoptix.dll) and fills g_optixFunctionTable. handlePtr
    (optional) receives the handle for optixUninitWithHandle, or null on failure.
    OPTIX_ERROR_LIBRARY_NOT_FOUND, OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND, or the library's error for
    the ABI of these headers, e.g. OPTIX_ERROR_UNSUPPORTED_ABI_VERSION. [3.14.2.2] */
OPTIX_STUB_INLINE OptixResult optixInitWithHandle(void** handlePtr) {
    OptixQueryFunctionTable_t* query = NULL;
    OptixResult result;
    void* handle;
    if (handlePtr)
        *handlePtr = NULL;
#ifdef _WIN32
    {
        FARPROC symbol;
        handle = optixLoadWindowsDll();
        if (!handle)
            return OPTIX_ERROR_LIBRARY_NOT_FOUND;
        symbol = GetProcAddress((HMODULE)handle, "optixQueryFunctionTable");
        memcpy(&query, &symbol, sizeof(query));
    }
#else
    {
        void* symbol;
        handle = dlopen("libnvoptix.so.1", RTLD_NOW);
        if (!handle)
            return OPTIX_ERROR_LIBRARY_NOT_FOUND;
        symbol = dlsym(handle, "optixQueryFunctionTable");
        memcpy(&query, &symbol, sizeof(query)); /* no cast from data to function pointer */
    }
#endif
    result = query ? query(OPTIX_ABI_VERSION, 0, NULL, NULL, &g_optixFunctionTable,
                           sizeof(g_optixFunctionTable))
                   : OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND;
    if (result == OPTIX_SUCCESS) {
        if (handlePtr)
            *handlePtr = handle;
        return result;
    }
    memset(&g_optixFunctionTable, 0, sizeof(g_optixFunctionTable));
#ifdef _WIN32
    FreeLibrary((HMODULE)handle);
#else
    dlclose(handle);
#endif
    return result;
}

/** optixInitWithHandle for applications that never unload the library. [3.14.2.1] */
OPTIX_STUB_INLINE OptixResult optixInit(void) {
    return optixInitWithHandle(NULL);
}

/** Unloads the library and sets the table to null. All contexts must have been destroyed.
    OPTIX_ERROR_INVALID_VALUE: handle is null; OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE. [3.14.2.3] */
OPTIX_STUB_INLINE OptixResult optixUninitWithHandle(void* handle) {
    if (!handle)
        return OPTIX_ERROR_INVALID_VALUE;
#ifdef _WIN32
    if (!FreeLibrary((HMODULE)handle))
        return OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE;
#else
    if (dlclose(handle) != 0)
        return OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE;
#endif
    memset(&g_optixFunctionTable, 0, sizeof(g_optixFunctionTable));
    return OPTIX_SUCCESS;
}

/* Error handling: these two also work without a library, for the results of optixInit itself. */

OPTIX_STUB_INLINE const char* optixGetErrorName(OptixResult result) {
    if (g_optixFunctionTable.optixGetErrorName)
        return g_optixFunctionTable.optixGetErrorName(result);
    switch ((int)result) {
    case OPTIX_SUCCESS:
        return "OPTIX_SUCCESS";
    case OPTIX_ERROR_INVALID_VALUE:
        return "OPTIX_ERROR_INVALID_VALUE";
    case OPTIX_ERROR_INVALID_OPERATION:
        return "OPTIX_ERROR_INVALID_OPERATION";
    case OPTIX_ERROR_UNSUPPORTED_ABI_VERSION:
        return "OPTIX_ERROR_UNSUPPORTED_ABI_VERSION";
    case OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH:
        return "OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH";
    case OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS:
        return "OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS";
    case OPTIX_ERROR_LIBRARY_NOT_FOUND:
        return "OPTIX_ERROR_LIBRARY_NOT_FOUND";
    case OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND:
        return "OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND";
    case OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE:
        return "OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE";
    default:
        return "Unrecognized OptixResult code";
    }
}

OPTIX_STUB_INLINE const char* optixGetErrorString(OptixResult result) {
    if (g_optixFunctionTable.optixGetErrorString)
        return g_optixFunctionTable.optixGetErrorString(result);
    switch ((int)result) {
    case OPTIX_SUCCESS:
        return "Success";
    case OPTIX_ERROR_INVALID_VALUE:
        return "Invalid value";
    case OPTIX_ERROR_INVALID_OPERATION:
        return "Invalid operation (has optixInit been called?)";
    case OPTIX_ERROR_UNSUPPORTED_ABI_VERSION:
        return "Library does not support these headers";
    case OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH:
        return "Function table size mismatch";
    case OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS:
        return "Invalid options to entry function";
    case OPTIX_ERROR_LIBRARY_NOT_FOUND:
        return "Library not found";
    case OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND:
        return "Library without optixQueryFunctionTable";
    case OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE:
        return "Library could not be unloaded";
    default:
        return "Unrecognized OptixResult code";
    }
}

/* Device context */

OPTIX_STUB_INLINE OptixResult optixDeviceContextCreate(CUcontext fromContext,
                                                       const OptixDeviceContextOptions* options,
                                                       OptixDeviceContext* context) {
    OPTIX_STUB_CALL(optixDeviceContextCreate, (fromContext, options, context));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextDestroy(OptixDeviceContext context) {
    OPTIX_STUB_CALL(optixDeviceContextDestroy, (context));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextGetProperty(OptixDeviceContext context,
                                                            OptixDeviceProperty property,
                                                            void* value, size_t sizeInBytes) {
    OPTIX_STUB_CALL(optixDeviceContextGetProperty, (context, property, value, sizeInBytes));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextSetLogCallback(OptixDeviceContext context,
                                                               OptixLogCallback callbackFunction,
                                                               void* callbackData,
                                                               unsigned int callbackLevel) {
    OPTIX_STUB_CALL(optixDeviceContextSetLogCallback,
                    (context, callbackFunction, callbackData, callbackLevel));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextSetCacheEnabled(OptixDeviceContext context,
                                                                int enabled) {
    OPTIX_STUB_CALL(optixDeviceContextSetCacheEnabled, (context, enabled));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextSetCacheLocation(OptixDeviceContext context,
                                                                 const char* location) {
    OPTIX_STUB_CALL(optixDeviceContextSetCacheLocation, (context, location));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextSetCacheDatabaseSizes(OptixDeviceContext context,
                                                                      size_t lowWaterMark,
                                                                      size_t highWaterMark) {
    OPTIX_STUB_CALL(optixDeviceContextSetCacheDatabaseSizes,
                    (context, lowWaterMark, highWaterMark));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextGetCacheEnabled(OptixDeviceContext context,
                                                                int* enabled) {
    OPTIX_STUB_CALL(optixDeviceContextGetCacheEnabled, (context, enabled));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextGetCacheLocation(OptixDeviceContext context,
                                                                 char* location,
                                                                 size_t locationSize) {
    OPTIX_STUB_CALL(optixDeviceContextGetCacheLocation, (context, location, locationSize));
}

OPTIX_STUB_INLINE OptixResult optixDeviceContextGetCacheDatabaseSizes(OptixDeviceContext context,
                                                                      size_t* lowWaterMark,
                                                                      size_t* highWaterMark) {
    OPTIX_STUB_CALL(optixDeviceContextGetCacheDatabaseSizes,
                    (context, lowWaterMark, highWaterMark));
}

/* Modules, tasks */

OPTIX_STUB_INLINE OptixResult optixModuleCreateFromPTX(
    OptixDeviceContext context, const OptixModuleCompileOptions* moduleCompileOptions,
    const OptixPipelineCompileOptions* pipelineCompileOptions, const char* PTX, size_t PTXsize,
    char* logString, size_t* logStringSize, OptixModule* module) {
    OPTIX_STUB_CALL(optixModuleCreateFromPTX,
                    (context, moduleCompileOptions, pipelineCompileOptions, PTX, PTXsize, logString,
                     logStringSize, module));
}

OPTIX_STUB_INLINE OptixResult optixModuleCreateFromPTXWithTasks(
    OptixDeviceContext context, const OptixModuleCompileOptions* moduleCompileOptions,
    const OptixPipelineCompileOptions* pipelineCompileOptions, const char* PTX, size_t PTXsize,
    char* logString, size_t* logStringSize, OptixModule* module, OptixTask* firstTask) {
    OPTIX_STUB_CALL(optixModuleCreateFromPTXWithTasks,
                    (context, moduleCompileOptions, pipelineCompileOptions, PTX, PTXsize, logString,
                     logStringSize, module, firstTask));
}

OPTIX_STUB_INLINE OptixResult optixModuleGetCompilationState(OptixModule module,
                                                             OptixModuleCompileState* state) {
    OPTIX_STUB_CALL(optixModuleGetCompilationState, (module, state));
}

OPTIX_STUB_INLINE OptixResult optixModuleDestroy(OptixModule module) {
    OPTIX_STUB_CALL(optixModuleDestroy, (module));
}

OPTIX_STUB_INLINE OptixResult optixBuiltinISModuleGet(
    OptixDeviceContext context, const OptixModuleCompileOptions* moduleCompileOptions,
    const OptixPipelineCompileOptions* pipelineCompileOptions,
    const OptixBuiltinISOptions* builtinISOptions, OptixModule* builtinModule) {
    OPTIX_STUB_CALL(optixBuiltinISModuleGet, (context, moduleCompileOptions, pipelineCompileOptions,
                                              builtinISOptions, builtinModule));
}

OPTIX_STUB_INLINE OptixResult optixTaskExecute(OptixTask task, OptixTask* additionalTasks,
                                               unsigned int maxNumAdditionalTasks,
                                               unsigned int* numAdditionalTasksCreated) {
    OPTIX_STUB_CALL(optixTaskExecute,
                    (task, additionalTasks, maxNumAdditionalTasks, numAdditionalTasksCreated));
}

/* Program groups */

OPTIX_STUB_INLINE OptixResult optixProgramGroupCreate(
    OptixDeviceContext context, const OptixProgramGroupDesc* programDescriptions,
    unsigned int numProgramGroups, const OptixProgramGroupOptions* options, char* logString,
    size_t* logStringSize, OptixProgramGroup* programGroups) {
    OPTIX_STUB_CALL(optixProgramGroupCreate, (context, programDescriptions, numProgramGroups,
                                              options, logString, logStringSize, programGroups));
}

OPTIX_STUB_INLINE OptixResult optixProgramGroupDestroy(OptixProgramGroup programGroup) {
    OPTIX_STUB_CALL(optixProgramGroupDestroy, (programGroup));
}

OPTIX_STUB_INLINE OptixResult optixProgramGroupGetStackSize(OptixProgramGroup programGroup,
                                                            OptixStackSizes* stackSizes) {
    OPTIX_STUB_CALL(optixProgramGroupGetStackSize, (programGroup, stackSizes));
}

/* Pipelines */

OPTIX_STUB_INLINE OptixResult optixPipelineCreate(
    OptixDeviceContext context, const OptixPipelineCompileOptions* pipelineCompileOptions,
    const OptixPipelineLinkOptions* pipelineLinkOptions, const OptixProgramGroup* programGroups,
    unsigned int numProgramGroups, char* logString, size_t* logStringSize,
    OptixPipeline* pipeline) {
    OPTIX_STUB_CALL(optixPipelineCreate,
                    (context, pipelineCompileOptions, pipelineLinkOptions, programGroups,
                     numProgramGroups, logString, logStringSize, pipeline));
}

OPTIX_STUB_INLINE OptixResult optixPipelineDestroy(OptixPipeline pipeline) {
    OPTIX_STUB_CALL(optixPipelineDestroy, (pipeline));
}

OPTIX_STUB_INLINE OptixResult optixPipelineSetStackSize(
    OptixPipeline pipeline, unsigned int directCallableStackSizeFromTraversal,
    unsigned int directCallableStackSizeFromState, unsigned int continuationStackSize,
    unsigned int maxTraversableGraphDepth) {
    OPTIX_STUB_CALL(optixPipelineSetStackSize, (pipeline, directCallableStackSizeFromTraversal,
                                                directCallableStackSizeFromState,
                                                continuationStackSize, maxTraversableGraphDepth));
}

/* Acceleration structures */

OPTIX_STUB_INLINE OptixResult
optixAccelComputeMemoryUsage(OptixDeviceContext context, const OptixAccelBuildOptions* accelOptions,
                             const OptixBuildInput* buildInputs, unsigned int numBuildInputs,
                             OptixAccelBufferSizes* bufferSizes) {
    OPTIX_STUB_CALL(optixAccelComputeMemoryUsage,
                    (context, accelOptions, buildInputs, numBuildInputs, bufferSizes));
}

OPTIX_STUB_INLINE OptixResult optixAccelBuild(
    OptixDeviceContext context, CUstream stream, const OptixAccelBuildOptions* accelOptions,
    const OptixBuildInput* buildInputs, unsigned int numBuildInputs, CUdeviceptr tempBuffer,
    size_t tempBufferSizeInBytes, CUdeviceptr outputBuffer, size_t outputBufferSizeInBytes,
    OptixTraversableHandle* outputHandle, const OptixAccelEmitDesc* emittedProperties,
    unsigned int numEmittedProperties) {
    OPTIX_STUB_CALL(optixAccelBuild,
                    (context, stream, accelOptions, buildInputs, numBuildInputs, tempBuffer,
                     tempBufferSizeInBytes, outputBuffer, outputBufferSizeInBytes, outputHandle,
                     emittedProperties, numEmittedProperties));
}

#if SUNSTONE_OPTIX_API >= 70600
OPTIX_STUB_INLINE OptixResult optixAccelGetRelocationInfo(OptixDeviceContext context,
                                                          OptixTraversableHandle handle,
                                                          OptixRelocationInfo* info) {
    OPTIX_STUB_CALL(optixAccelGetRelocationInfo, (context, handle, info));
}

OPTIX_STUB_INLINE OptixResult optixCheckRelocationCompatibility(OptixDeviceContext context,
                                                                const OptixRelocationInfo* info,
                                                                int* compatible) {
    OPTIX_STUB_CALL(optixCheckRelocationCompatibility, (context, info, compatible));
}

OPTIX_STUB_INLINE OptixResult optixAccelRelocate(OptixDeviceContext context, CUstream stream,
                                                 const OptixRelocationInfo* info,
                                                 const OptixRelocateInput* relocateInputs,
                                                 size_t numRelocateInputs, CUdeviceptr targetAccel,
                                                 size_t targetAccelSizeInBytes,
                                                 OptixTraversableHandle* targetHandle) {
    OPTIX_STUB_CALL(optixAccelRelocate, (context, stream, info, relocateInputs, numRelocateInputs,
                                         targetAccel, targetAccelSizeInBytes, targetHandle));
}
#else
OPTIX_STUB_INLINE OptixResult optixAccelGetRelocationInfo(OptixDeviceContext context,
                                                          OptixTraversableHandle handle,
                                                          OptixAccelRelocationInfo* info) {
    OPTIX_STUB_CALL(optixAccelGetRelocationInfo, (context, handle, info));
}

OPTIX_STUB_INLINE OptixResult optixAccelCheckRelocationCompatibility(
    OptixDeviceContext context, const OptixAccelRelocationInfo* info, int* compatible) {
    OPTIX_STUB_CALL(optixAccelCheckRelocationCompatibility, (context, info, compatible));
}

OPTIX_STUB_INLINE OptixResult optixAccelRelocate(
    OptixDeviceContext context, CUstream stream, const OptixAccelRelocationInfo* info,
    CUdeviceptr instanceTraversableHandles, size_t numInstanceTraversableHandles,
    CUdeviceptr targetAccel, size_t targetAccelSizeInBytes, OptixTraversableHandle* targetHandle) {
    OPTIX_STUB_CALL(optixAccelRelocate, (context, stream, info, instanceTraversableHandles,
                                         numInstanceTraversableHandles, targetAccel,
                                         targetAccelSizeInBytes, targetHandle));
}
#endif

OPTIX_STUB_INLINE OptixResult optixAccelCompact(OptixDeviceContext context, CUstream stream,
                                                OptixTraversableHandle inputHandle,
                                                CUdeviceptr outputBuffer,
                                                size_t outputBufferSizeInBytes,
                                                OptixTraversableHandle* outputHandle) {
    OPTIX_STUB_CALL(optixAccelCompact, (context, stream, inputHandle, outputBuffer,
                                        outputBufferSizeInBytes, outputHandle));
}

OPTIX_STUB_INLINE OptixResult optixConvertPointerToTraversableHandle(
    OptixDeviceContext onDevice, CUdeviceptr pointer, OptixTraversableType traversableType,
    OptixTraversableHandle* traversableHandle) {
    OPTIX_STUB_CALL(optixConvertPointerToTraversableHandle,
                    (onDevice, pointer, traversableType, traversableHandle));
}

#if SUNSTONE_OPTIX_API >= 70600
/* Opacity micromaps */

OPTIX_STUB_INLINE OptixResult optixOpacityMicromapArrayComputeMemoryUsage(
    OptixDeviceContext context, const OptixOpacityMicromapArrayBuildInput* buildInput,
    OptixMicromapBufferSizes* bufferSizes) {
    OPTIX_STUB_CALL(optixOpacityMicromapArrayComputeMemoryUsage,
                    (context, buildInput, bufferSizes));
}

OPTIX_STUB_INLINE OptixResult optixOpacityMicromapArrayBuild(
    OptixDeviceContext context, CUstream stream,
    const OptixOpacityMicromapArrayBuildInput* buildInput, const OptixMicromapBuffers* buffers) {
    OPTIX_STUB_CALL(optixOpacityMicromapArrayBuild, (context, stream, buildInput, buffers));
}

OPTIX_STUB_INLINE OptixResult optixOpacityMicromapArrayGetRelocationInfo(
    OptixDeviceContext context, CUdeviceptr opacityMicromapArray, OptixRelocationInfo* info) {
    OPTIX_STUB_CALL(optixOpacityMicromapArrayGetRelocationInfo,
                    (context, opacityMicromapArray, info));
}

OPTIX_STUB_INLINE OptixResult optixOpacityMicromapArrayRelocate(
    OptixDeviceContext context, CUstream stream, const OptixRelocationInfo* info,
    CUdeviceptr targetOpacityMicromapArray, size_t targetOpacityMicromapArraySizeInBytes) {
    OPTIX_STUB_CALL(
        optixOpacityMicromapArrayRelocate,
        (context, stream, info, targetOpacityMicromapArray, targetOpacityMicromapArraySizeInBytes));
}
#endif

/* Launch */

OPTIX_STUB_INLINE OptixResult optixSbtRecordPackHeader(OptixProgramGroup programGroup,
                                                       void* sbtRecordHeaderHostPointer) {
    OPTIX_STUB_CALL(optixSbtRecordPackHeader, (programGroup, sbtRecordHeaderHostPointer));
}

OPTIX_STUB_INLINE OptixResult optixLaunch(OptixPipeline pipeline, CUstream stream,
                                          CUdeviceptr pipelineParams, size_t pipelineParamsSize,
                                          const OptixShaderBindingTable* sbt, unsigned int width,
                                          unsigned int height, unsigned int depth) {
    OPTIX_STUB_CALL(optixLaunch, (pipeline, stream, pipelineParams, pipelineParamsSize, sbt, width,
                                  height, depth));
}

/* Denoiser */

OPTIX_STUB_INLINE OptixResult optixDenoiserCreate(OptixDeviceContext context,
                                                  OptixDenoiserModelKind modelKind,
                                                  const OptixDenoiserOptions* options,
                                                  OptixDenoiser* denoiser) {
    OPTIX_STUB_CALL(optixDenoiserCreate, (context, modelKind, options, denoiser));
}

OPTIX_STUB_INLINE OptixResult optixDenoiserDestroy(OptixDenoiser denoiser) {
    OPTIX_STUB_CALL(optixDenoiserDestroy, (denoiser));
}

OPTIX_STUB_INLINE OptixResult optixDenoiserComputeMemoryResources(const OptixDenoiser denoiser,
                                                                  unsigned int outputWidth,
                                                                  unsigned int outputHeight,
                                                                  OptixDenoiserSizes* returnSizes) {
    OPTIX_STUB_CALL(optixDenoiserComputeMemoryResources,
                    (denoiser, outputWidth, outputHeight, returnSizes));
}

OPTIX_STUB_INLINE OptixResult optixDenoiserSetup(OptixDenoiser denoiser, CUstream stream,
                                                 unsigned int inputWidth, unsigned int inputHeight,
                                                 CUdeviceptr denoiserState,
                                                 size_t denoiserStateSizeInBytes,
                                                 CUdeviceptr scratch, size_t scratchSizeInBytes) {
    OPTIX_STUB_CALL(optixDenoiserSetup, (denoiser, stream, inputWidth, inputHeight, denoiserState,
                                         denoiserStateSizeInBytes, scratch, scratchSizeInBytes));
}

OPTIX_STUB_INLINE OptixResult
optixDenoiserInvoke(OptixDenoiser denoiser, CUstream stream, const OptixDenoiserParams* params,
                    CUdeviceptr denoiserState, size_t denoiserStateSizeInBytes,
                    const OptixDenoiserGuideLayer* guideLayer, const OptixDenoiserLayer* layers,
                    unsigned int numLayers, unsigned int inputOffsetX, unsigned int inputOffsetY,
                    CUdeviceptr scratch, size_t scratchSizeInBytes) {
    OPTIX_STUB_CALL(optixDenoiserInvoke,
                    (denoiser, stream, params, denoiserState, denoiserStateSizeInBytes, guideLayer,
                     layers, numLayers, inputOffsetX, inputOffsetY, scratch, scratchSizeInBytes));
}

OPTIX_STUB_INLINE OptixResult optixDenoiserComputeIntensity(OptixDenoiser denoiser, CUstream stream,
                                                            const OptixImage2D* inputImage,
                                                            CUdeviceptr outputIntensity,
                                                            CUdeviceptr scratch,
                                                            size_t scratchSizeInBytes) {
    OPTIX_STUB_CALL(optixDenoiserComputeIntensity,
                    (denoiser, stream, inputImage, outputIntensity, scratch, scratchSizeInBytes));
}

OPTIX_STUB_INLINE OptixResult optixDenoiserComputeAverageColor(
    OptixDenoiser denoiser, CUstream stream, const OptixImage2D* inputImage,
    CUdeviceptr outputAverageColor, CUdeviceptr scratch, size_t scratchSizeInBytes) {
    OPTIX_STUB_CALL(
        optixDenoiserComputeAverageColor,
        (denoiser, stream, inputImage, outputAverageColor, scratch, scratchSizeInBytes));
}

OPTIX_STUB_INLINE OptixResult optixDenoiserCreateWithUserModel(OptixDeviceContext context,
                                                               const void* userData,
                                                               size_t userDataSizeInBytes,
                                                               OptixDenoiser* denoiser) {
    OPTIX_STUB_CALL(optixDenoiserCreateWithUserModel,
                    (context, userData, userDataSizeInBytes, denoiser));
}

#ifdef __cplusplus
}
#endif

#undef OPTIX_STUB_CALL
#undef OPTIX_STUB_INLINE

#endif
