// SPDX-License-Identifier: Apache-2.0
// OptixResult names, texts and their relation to engine codes (OptiX 7.4, section 3.3 and 4.3).
#include "api/optix7/shell.h"

namespace sunstone::optix7 {
namespace {

struct ResultInfo {
    OptixResult result;
    const char* name;
    const char* text;
    Abi first = kAbi70; // first ABI with this name
    Abi last = kNewestAbi;
};

#define ROW(code, text) {code, #code, text}
constexpr ResultInfo kResults[] = {
    ROW(OPTIX_SUCCESS, "Success"),
    ROW(OPTIX_ERROR_INVALID_VALUE, "Invalid value"),
    ROW(OPTIX_ERROR_HOST_OUT_OF_MEMORY, "Host is out of memory"),
    ROW(OPTIX_ERROR_INVALID_OPERATION, "Invalid operation"),
    ROW(OPTIX_ERROR_FILE_IO_ERROR, "File I/O error"),
    ROW(OPTIX_ERROR_INVALID_FILE_FORMAT, "Invalid file format"),
    ROW(OPTIX_ERROR_DISK_CACHE_INVALID_PATH, "Invalid path for the disk cache"),
    ROW(OPTIX_ERROR_DISK_CACHE_PERMISSION_ERROR, "No permission for the disk cache"),
    ROW(OPTIX_ERROR_DISK_CACHE_DATABASE_ERROR, "Disk cache database failed"),
    ROW(OPTIX_ERROR_DISK_CACHE_INVALID_DATA, "Disk cache holds invalid data"),
    ROW(OPTIX_ERROR_LAUNCH_FAILURE, "Launch failed"),
    ROW(OPTIX_ERROR_INVALID_DEVICE_CONTEXT, "Invalid device context"),
    ROW(OPTIX_ERROR_CUDA_NOT_INITIALIZED, "CUDA is not initialized"),
    ROW(OPTIX_ERROR_VALIDATION_FAILURE, "Validation mode found an error"),
    ROW(OPTIX_ERROR_INVALID_PTX, "Invalid PTX input"),
    ROW(OPTIX_ERROR_INVALID_LAUNCH_PARAMETER, "Invalid launch parameter variable"),
    ROW(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "Invalid payload access"),
    ROW(OPTIX_ERROR_INVALID_ATTRIBUTE_ACCESS, "Invalid attribute access"),
    ROW(OPTIX_ERROR_INVALID_FUNCTION_USE, "Device function used where it is not allowed"),
    ROW(OPTIX_ERROR_INVALID_FUNCTION_ARGUMENTS, "Invalid arguments of a device function"),
    ROW(OPTIX_ERROR_PIPELINE_OUT_OF_CONSTANT_MEMORY, "Pipeline is out of constant memory"),
    ROW(OPTIX_ERROR_PIPELINE_LINK_ERROR, "Pipeline link error"),
    ROW(OPTIX_ERROR_ILLEGAL_DURING_TASK_EXECUTE, "Illegal while a task executes"),
    ROW(OPTIX_ERROR_INTERNAL_COMPILER_ERROR, "Internal compiler error"),
    ROW(OPTIX_ERROR_DENOISER_MODEL_NOT_SET, "Denoiser model is not set"),
    ROW(OPTIX_ERROR_DENOISER_NOT_INITIALIZED, "Denoiser is not initialized"),
    {OPTIX_ERROR_NOT_COMPATIBLE, "OPTIX_ERROR_ACCEL_NOT_COMPATIBLE",
     "Acceleration structure is not compatible", kAbi70, kAbi75},
    {OPTIX_ERROR_NOT_COMPATIBLE, "OPTIX_ERROR_NOT_COMPATIBLE", "Not compatible", kAbi76},
    ROW(OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH, "Payload types do not match"),
    ROW(OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED, "Payload type could not be resolved"),
    ROW(OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID, "Payload type id is invalid"),
    ROW(OPTIX_ERROR_NOT_SUPPORTED, "Not supported"),
    ROW(OPTIX_ERROR_UNSUPPORTED_ABI_VERSION, "Unsupported ABI version"),
    ROW(OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH, "Function table has the wrong size"),
    ROW(OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS, "Invalid options of the entry function"),
    ROW(OPTIX_ERROR_LIBRARY_NOT_FOUND, "Library not found"),
    ROW(OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND, "Entry symbol not found in the library"),
    ROW(OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE, "Library could not be unloaded"),
    {OPTIX_ERROR_DEVICE_OUT_OF_MEMORY, "OPTIX_ERROR_DEVICE_OUT_OF_MEMORY",
     "Device is out of memory", kAbi75},
    ROW(OPTIX_ERROR_CUDA_ERROR, "CUDA error"),
    ROW(OPTIX_ERROR_INTERNAL_ERROR, "Internal error"),
    ROW(OPTIX_ERROR_UNKNOWN, "Unknown error"),
};
#undef ROW

const ResultInfo* find(OptixResult result, Abi abi) {
    for (const ResultInfo& info : kResults)
        if (info.result == result && info.first <= abi && abi <= info.last)
            return &info;
    return nullptr;
}

} // namespace

const char* resultName(OptixResult result, Abi abi) {
    const ResultInfo* info = find(result, abi);
    return info ? info->name : nullptr;
}

const char* resultString(OptixResult result, Abi abi) {
    const ResultInfo* info = find(result, abi);
    return info ? info->text : nullptr;
}

OptixResult resultOf(Code code) {
    switch (code) {
    case Code::kOk: return OPTIX_SUCCESS;
    case Code::kInvalidValue: return OPTIX_ERROR_INVALID_VALUE;
    case Code::kOutOfMemory: return OPTIX_ERROR_HOST_OUT_OF_MEMORY;
    case Code::kInvalidOperation: return OPTIX_ERROR_INVALID_OPERATION;
    case Code::kNotSupported: return OPTIX_ERROR_NOT_SUPPORTED;
    case Code::kInvalidPtx: return OPTIX_ERROR_INVALID_PTX;
    case Code::kInvalidLaunchParameter: return OPTIX_ERROR_INVALID_LAUNCH_PARAMETER;
    case Code::kInvalidPayloadAccess: return OPTIX_ERROR_INVALID_PAYLOAD_ACCESS;
    case Code::kInvalidAttributeAccess: return OPTIX_ERROR_INVALID_ATTRIBUTE_ACCESS;
    case Code::kInvalidFunctionUse: return OPTIX_ERROR_INVALID_FUNCTION_USE;
    case Code::kInvalidFunctionArguments: return OPTIX_ERROR_INVALID_FUNCTION_ARGUMENTS;
    case Code::kLinkError: return OPTIX_ERROR_PIPELINE_LINK_ERROR;
    case Code::kOutOfConstantMemory: return OPTIX_ERROR_PIPELINE_OUT_OF_CONSTANT_MEMORY;
    case Code::kInvalidContext: return OPTIX_ERROR_INVALID_DEVICE_CONTEXT;
    case Code::kNotInitialized: return OPTIX_ERROR_CUDA_NOT_INITIALIZED;
    case Code::kLaunchFailure: return OPTIX_ERROR_LAUNCH_FAILURE;
    case Code::kCudaError: return OPTIX_ERROR_CUDA_ERROR;
    case Code::kAccelNotCompatible: return OPTIX_ERROR_NOT_COMPATIBLE;
    case Code::kPayloadTypeMismatch: return OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH;
    case Code::kPayloadTypeResolution: return OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED;
    case Code::kPayloadTypeId: return OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID;
    case Code::kNotFound: return OPTIX_ERROR_INVALID_VALUE;
    case Code::kFileError: return OPTIX_ERROR_FILE_IO_ERROR;
    case Code::kIllegalDuringTask: return OPTIX_ERROR_ILLEGAL_DURING_TASK_EXECUTE;
    case Code::kCacheInvalidPath: return OPTIX_ERROR_DISK_CACHE_INVALID_PATH;
    case Code::kCachePermission: return OPTIX_ERROR_DISK_CACHE_PERMISSION_ERROR;
    case Code::kCacheDatabase: return OPTIX_ERROR_DISK_CACHE_DATABASE_ERROR;
    case Code::kInternal: return OPTIX_ERROR_INTERNAL_ERROR;
    }
    return OPTIX_ERROR_UNKNOWN;
}

} // namespace sunstone::optix7
