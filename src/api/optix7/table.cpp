// SPDX-License-Identifier: Apache-2.0
// optixQueryFunctionTable, the one exported symbol: serves the function table of ABI 55 (OptiX
// 7.4). Slots are filled by position, which is the ABI; the order is that of OptixFunctionTable.
// Source: OptiX 7.4, sections 4.1 and 6.9.
#include "api/optix7/entry_points.h"
#include "api/optix7/shell.h"

#include "optix_function_table.h"

#include <cstddef>

namespace sunstone::optix7 {
namespace {

const char* getErrorName(OptixResult result) {
    const char* name = resultName(result);
    return name ? name : "Unrecognized OptixResult code";
}

const char* getErrorString(OptixResult result) {
    const char* text = resultString(result);
    return text ? text : "Unrecognized OptixResult code";
}

// What every entry point that is not there yet does: says so, with its name, and fails.
OptixResult notSupported(const char* function, const void* handle) {
    std::string text = message(function, ": not supported by this version of Sunstone");
    if (std::shared_ptr<DeviceContext> context = contexts().find(handle))
        context->log(LogLevel::kError, "ERROR", text);
    else
        logOnce(LogLevel::kFatal, "optix7", text);
    return OPTIX_ERROR_NOT_SUPPORTED;
}

// The first argument of each such function is a context, module, task or denoiser handle; which
// one it is does not matter, since only a live context is recognised.
#define NOT_SUPPORTED(name)                                                                        \
    +[](const void* handle) -> OptixResult { return notSupported(#name, handle); }

constexpr int kAbi74 = 55;
constexpr size_t kSlots74 = 43;
static_assert(sizeof(OptixFunctionTable) == kSlots74 * sizeof(void*));

template <class Function>
void* slot(Function* function) {
    return reinterpret_cast<void*>(function);
}

void fillTable74(void** table) {
    void* const slots[kSlots74] = {
        slot(getErrorName),
        slot(getErrorString),
        slot(deviceContextCreate),
        slot(deviceContextDestroy),
        slot(deviceContextGetProperty),
        slot(deviceContextSetLogCallback),
        slot(NOT_SUPPORTED(optixDeviceContextSetCacheEnabled)),
        slot(NOT_SUPPORTED(optixDeviceContextSetCacheLocation)),
        slot(NOT_SUPPORTED(optixDeviceContextSetCacheDatabaseSizes)),
        slot(NOT_SUPPORTED(optixDeviceContextGetCacheEnabled)),
        slot(NOT_SUPPORTED(optixDeviceContextGetCacheLocation)),
        slot(NOT_SUPPORTED(optixDeviceContextGetCacheDatabaseSizes)),
        slot(moduleCreateFromPTX),
        slot(NOT_SUPPORTED(optixModuleCreateFromPTXWithTasks)),
        slot(NOT_SUPPORTED(optixModuleGetCompilationState)),
        slot(moduleDestroy),
        slot(NOT_SUPPORTED(optixBuiltinISModuleGet)),
        slot(NOT_SUPPORTED(optixTaskExecute)),
        slot(programGroupCreate),
        slot(programGroupDestroy),
        slot(programGroupGetStackSize),
        slot(pipelineCreate),
        slot(pipelineDestroy),
        slot(pipelineSetStackSize),
        slot(accelComputeMemoryUsage),
        slot(accelBuild),
        slot(NOT_SUPPORTED(optixAccelGetRelocationInfo)),
        slot(NOT_SUPPORTED(optixAccelCheckRelocationCompatibility)),
        slot(NOT_SUPPORTED(optixAccelRelocate)),
        slot(accelCompact),
        slot(NOT_SUPPORTED(optixConvertPointerToTraversableHandle)),
        slot(NOT_SUPPORTED(reserved1)),
        slot(NOT_SUPPORTED(reserved2)),
        slot(sbtRecordPackHeader),
        slot(launch),
        slot(NOT_SUPPORTED(optixDenoiserCreate)),
        slot(NOT_SUPPORTED(optixDenoiserDestroy)),
        slot(NOT_SUPPORTED(optixDenoiserComputeMemoryResources)),
        slot(NOT_SUPPORTED(optixDenoiserSetup)),
        slot(NOT_SUPPORTED(optixDenoiserInvoke)),
        slot(NOT_SUPPORTED(optixDenoiserComputeIntensity)),
        slot(NOT_SUPPORTED(optixDenoiserComputeAverageColor)),
        slot(NOT_SUPPORTED(optixDenoiserCreateWithUserModel)),
    };
    std::memcpy(table, slots, sizeof(slots));
}
#undef NOT_SUPPORTED

OptixResult fail(OptixResult result, const std::string& text) {
    log(LogLevel::kError, "optix7", message("optixQueryFunctionTable: ", text));
    return result;
}

OptixResult queryFunctionTable(int abiId, unsigned numOptions, void* table, size_t sizeOfTable) {
    if (!table)
        return fail(OPTIX_ERROR_INVALID_VALUE, "functionTable is null");
    if (numOptions != 0)
        return fail(OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS,
                    message("numOptions = ", numOptions, ", but no option is defined"));
    if (abiId != kAbi74)
        return fail(OPTIX_ERROR_UNSUPPORTED_ABI_VERSION,
                    message("abiId = ", abiId, "; this library serves ", kAbi74, " (OptiX 7.4)"));
    if (sizeOfTable != kSlots74 * sizeof(void*))
        return fail(OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH,
                    message("sizeOfTable = ", sizeOfTable, ", but ABI ", kAbi74, " has ",
                            kSlots74 * sizeof(void*), " bytes"));
    fillTable74(static_cast<void**>(table));
    return OPTIX_SUCCESS;
}

} // namespace
} // namespace sunstone::optix7

extern "C" __attribute__((visibility("default"))) OptixResult
optixQueryFunctionTable(int abiId, unsigned int numOptions, OptixQueryFunctionTableOptions*,
                        const void**, void* functionTable, size_t sizeOfTable) {
    return sunstone::optix7::queryFunctionTable(abiId, numOptions, functionTable, sizeOfTable);
}
