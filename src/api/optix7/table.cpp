// SPDX-License-Identifier: Apache-2.0
// optixQueryFunctionTable, the only exported symbol: returns the function tables of ABIs 22 (OptiX
// 7.0) to 68 (7.6). Slots are filled by position, which is the ABI. Releases inserted and removed
// slots but never reordered them, so one list, with conditions, gives the order of all tables.
// Source: OptiX 7.4, sections 4.1 and 6.9.
#include "api/optix7/adapter.h"
#include "api/optix7/entry_points.h"
#include "api/optix7/shell.h"

#include "optix_function_table.h"

#include <algorithm>
#include <cstddef>

namespace sunstone::optix7 {
namespace {

template <Abi kAbi>
const char* getErrorName(OptixResult result) {
    const char* name = resultName(result, kAbi);
    return name ? name : "Unrecognized OptixResult code";
}

template <Abi kAbi>
const char* getErrorString(OptixResult result) {
    const char* text = resultString(result, kAbi);
    return text ? text : "Unrecognized OptixResult code";
}

// A reserved slot of the release; no header declares a function for it.
OptixResult reservedSlot() {
    if (refusesForkedChild())
        return kInForkedChild;
    logOnce(LogLevel::kFatal, "optix7",
            "the application called a reserved slot of the function table");
    return OPTIX_ERROR_NOT_SUPPORTED;
}

// Fills a table slot by slot.
class Slots {
public:
    Slots(void** table, size_t count) : next_(table), end_(table + count) {}
    template <class Function>
    void add(Function* function) {
        SUNSTONE_CHECK(next_ != end_);
        *next_++ = reinterpret_cast<void*>(function);
    }
    bool areFull() const { return next_ == end_; }

private:
    void** next_;
    void** end_;
};

// FUNCTION: one of entry_points.h, adapted to the ABI.
#define FUNCTION(name) slots.add(&Adapter<kAbi, &name>::call)

template <Abi kAbi>
void addContextSlots(Slots& slots) {
    slots.add(&getErrorName<kAbi>);
    slots.add(&getErrorString<kAbi>);
    FUNCTION(deviceContextCreate);
    FUNCTION(deviceContextDestroy);
    FUNCTION(deviceContextGetProperty);
    FUNCTION(deviceContextSetLogCallback);
    FUNCTION(deviceContextSetCacheEnabled);
    FUNCTION(deviceContextSetCacheLocation);
    FUNCTION(deviceContextSetCacheDatabaseSizes);
    FUNCTION(deviceContextGetCacheEnabled);
    FUNCTION(deviceContextGetCacheLocation);
    FUNCTION(deviceContextGetCacheDatabaseSizes);
}

template <Abi kAbi>
void addPipelineSlots(Slots& slots) {
    FUNCTION(moduleCreateFromPTX);
    if constexpr (kAbi >= kAbi74) {
        FUNCTION(moduleCreateFromPTXWithTasks);
        FUNCTION(moduleGetCompilationState);
    }
    FUNCTION(moduleDestroy);
    if constexpr (kAbi >= kAbi71)
        FUNCTION(builtinISModuleGet);
    if constexpr (kAbi >= kAbi74)
        FUNCTION(taskExecute);
    FUNCTION(programGroupCreate);
    FUNCTION(programGroupDestroy);
    FUNCTION(programGroupGetStackSize);
    if constexpr (kAbi >= kAbi71)
        FUNCTION(pipelineCreate);
    else
        FUNCTION(pipelineCreate70);
    FUNCTION(pipelineDestroy);
    FUNCTION(pipelineSetStackSize);
}

template <Abi kAbi>
void addAccelSlots(Slots& slots) {
    FUNCTION(accelComputeMemoryUsage);
    FUNCTION(accelBuild);
    FUNCTION(accelGetRelocationInfo);
    FUNCTION(checkRelocationCompatibility);
    if constexpr (kAbi >= kAbi76)
        FUNCTION(accelRelocate);
    else
        FUNCTION(accelRelocateChildren);
    FUNCTION(accelCompact);
    FUNCTION(convertPointerToTraversableHandle);
    if constexpr (kAbi >= kAbi76) {
        FUNCTION(opacityMicromapArrayComputeMemoryUsage);
        FUNCTION(opacityMicromapArrayBuild);
        FUNCTION(opacityMicromapArrayGetRelocationInfo);
        FUNCTION(opacityMicromapArrayRelocate);
    }
    if constexpr (kAbi >= kAbi74) {
        slots.add(reservedSlot);
        slots.add(reservedSlot);
    }
}

template <Abi kAbi>
void addDenoiserSlots(Slots& slots) {
    if constexpr (kAbi >= kAbi73)
        FUNCTION(denoiserCreate);
    else
        FUNCTION(denoiserCreate70);
    FUNCTION(denoiserDestroy);
    FUNCTION(denoiserComputeMemoryResources);
    FUNCTION(denoiserSetup);
    if constexpr (kAbi >= kAbi73) {
        FUNCTION(denoiserInvoke);
    } else {
        FUNCTION(denoiserInvoke70);
        FUNCTION(denoiserSetModel);
    }
    FUNCTION(denoiserComputeIntensity);
    if constexpr (kAbi >= kAbi72)
        FUNCTION(denoiserComputeAverageColor);
    if constexpr (kAbi >= kAbi73)
        FUNCTION(denoiserCreateWithUserModel);
}

template <Abi kAbi>
void addSlots(Slots& slots) {
    addContextSlots<kAbi>(slots);
    addPipelineSlots<kAbi>(slots);
    addAccelSlots<kAbi>(slots);
    FUNCTION(sbtRecordPackHeader);
    FUNCTION(launch);
    addDenoiserSlots<kAbi>(slots);
}
#undef FUNCTION

// The table of one ABI.
struct Table {
    Abi abi;
    size_t slots;
    void (*addSlots)(Slots&);
};
constexpr Table kTables[] = {
    {kAbi70, 36, addSlots<kAbi70>}, {kAbi71, 37, addSlots<kAbi71>}, {kAbi72, 38, addSlots<kAbi72>},
    {kAbi73, 38, addSlots<kAbi73>}, {kAbi74, 43, addSlots<kAbi74>}, {kAbi75, 43, addSlots<kAbi75>},
    {kAbi76, 47, addSlots<kAbi76>},
};
static_assert(sizeof(OptixFunctionTable) == 47 * sizeof(void*));

OptixResult fail(OptixResult result, const std::string& text) {
    // No device context exists whose log could report this.
    logOnce(logEnabled(LogLevel::kError, "optix7") ? LogLevel::kError : LogLevel::kFatal, "optix7",
            message("optixQueryFunctionTable: ", text));
    return result;
}

std::string servedAbis() {
    std::string text;
    for (const Table& table : kTables)
        text += message(text.empty() ? "" : ", ", int(table.abi), " (OptiX ", releaseOf(table.abi),
                        ")");
    return text;
}

OptixResult queryFunctionTable(int abiId, unsigned numOptions, void* table, size_t sizeOfTable) {
    if (!table)
        return fail(OPTIX_ERROR_INVALID_VALUE, "functionTable is null");
    if (numOptions != 0)
        return fail(OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS,
                    message("numOptions = ", numOptions, ", but no option is defined"));
    const Table* served = std::find_if(std::begin(kTables), std::end(kTables),
                                       [&](const Table& t) { return t.abi == abiId; });
    if (served == std::end(kTables))
        return fail(OPTIX_ERROR_UNSUPPORTED_ABI_VERSION,
                    message("abiId = ", abiId, "; this library serves ", servedAbis()));
    const size_t size = served->slots * sizeof(void*);
    if (sizeOfTable != size)
        return fail(OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH,
                    message("sizeOfTable = ", sizeOfTable, ", but the table of ABI ", abiId,
                            " (OptiX ", releaseOf(served->abi), ") has ", size, " bytes"));
    Slots slots(static_cast<void**>(table), served->slots);
    served->addSlots(slots);
    SUNSTONE_CHECK(slots.areFull());
    return OPTIX_SUCCESS;
}

} // namespace
} // namespace sunstone::optix7

extern "C" __attribute__((visibility("default"))) OptixResult
optixQueryFunctionTable(int abiId, unsigned int numOptions, OptixQueryFunctionTableOptions*,
                        const void**, void* functionTable, size_t sizeOfTable) {
    return sunstone::optix7::queryFunctionTable(abiId, numOptions, functionTable, sizeOfTable);
}
