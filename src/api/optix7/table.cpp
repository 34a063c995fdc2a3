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

// What every entry point that is not there yet does: says so, with its name, and fails. The first
// argument of each is a handle: if it is a live context or module, that context's log gets the line.
OptixResult refuse(const char* function, const void* handle) {
    std::string text = message(function, ": not supported by this version of Sunstone");
    std::shared_ptr<DeviceContext> context = contexts().find(handle);
    if (std::shared_ptr<ModuleObject> module = modules().find(handle))
        context = module->context;
    if (context)
        context->log(LogLevel::kError, "ERROR", text);
    else
        logOnce(LogLevel::kFatal, "optix7", text);
    return OPTIX_ERROR_NOT_SUPPORTED;
}

// A name as a template argument.
template <size_t N>
struct Name {
    char text[N];
    constexpr Name(const char (&from)[N]) { // NOLINT: implicit so that literals convert
        for (size_t i = 0; i < N; ++i)
            text[i] = from[i];
    }
};

template <class Function, Name kName>
struct Missing;
template <class First, class... Rest, Name kName>
struct Missing<OptixResult (*)(First, Rest...), kName> {
    static OptixResult call(First first, Rest...) {
        return refuse(kName.text, reinterpret_cast<const void*>(first));
    }
};

// Reserved slots have no meaning; calling one is harmless.
void reservedSlot() {
    refuse("a reserved slot of the function table", nullptr);
}

// The function of a slot, with the slot's own signature.
#define MISSING(name) slot(&Missing<decltype(OptixFunctionTable::name), #name>::call)

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
        MISSING(optixDeviceContextSetCacheEnabled),
        MISSING(optixDeviceContextSetCacheLocation),
        MISSING(optixDeviceContextSetCacheDatabaseSizes),
        MISSING(optixDeviceContextGetCacheEnabled),
        MISSING(optixDeviceContextGetCacheLocation),
        MISSING(optixDeviceContextGetCacheDatabaseSizes),
        slot(moduleCreateFromPTX),
        MISSING(optixModuleCreateFromPTXWithTasks),
        MISSING(optixModuleGetCompilationState),
        slot(moduleDestroy),
        MISSING(optixBuiltinISModuleGet),
        MISSING(optixTaskExecute),
        slot(programGroupCreate),
        slot(programGroupDestroy),
        slot(programGroupGetStackSize),
        slot(pipelineCreate),
        slot(pipelineDestroy),
        slot(pipelineSetStackSize),
        slot(accelComputeMemoryUsage),
        slot(accelBuild),
        slot(accelGetRelocationInfo),
        slot(accelCheckRelocationCompatibility),
        slot(accelRelocate),
        slot(accelCompact),
        slot(convertPointerToTraversableHandle),
        slot(reservedSlot),
        slot(reservedSlot),
        slot(sbtRecordPackHeader),
        slot(launch),
        slot(denoiserCreate),
        slot(denoiserDestroy),
        slot(denoiserComputeMemoryResources),
        slot(denoiserSetup),
        slot(denoiserInvoke),
        slot(denoiserComputeIntensity),
        slot(denoiserComputeAverageColor),
        slot(denoiserCreateWithUserModel),
    };
    std::memcpy(table, slots, sizeof(slots));
}
#undef MISSING

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
