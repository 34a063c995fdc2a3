// SPDX-License-Identifier: Apache-2.0
#include "releases.h"

#include <algorithm>
#include <stdexcept>

namespace tests::abi {
namespace {

void insertAfter(std::vector<std::string>& slots, const std::string& place,
                 const std::vector<std::string>& names) {
    const auto found = std::find(slots.begin(), slots.end(), place);
    if (found == slots.end())
        throw std::logic_error("no slot " + place);
    slots.insert(found + 1, names.begin(), names.end());
}

void rename(std::vector<std::string>& slots, const std::string& from, const std::string& to) {
    const auto found = std::find(slots.begin(), slots.end(), from);
    if (found == slots.end())
        throw std::logic_error("no slot " + from);
    *found = to;
}

} // namespace

std::vector<std::string> slotsOf(int abi) {
    std::vector<std::string> slots = {"GetErrorName",
                                      "GetErrorString",
                                      "DeviceContextCreate",
                                      "DeviceContextDestroy",
                                      "DeviceContextGetProperty",
                                      "DeviceContextSetLogCallback",
                                      "DeviceContextSetCacheEnabled",
                                      "DeviceContextSetCacheLocation",
                                      "DeviceContextSetCacheDatabaseSizes",
                                      "DeviceContextGetCacheEnabled",
                                      "DeviceContextGetCacheLocation",
                                      "DeviceContextGetCacheDatabaseSizes",
                                      "ModuleCreateFromPTX",
                                      "ModuleDestroy",
                                      "ProgramGroupCreate",
                                      "ProgramGroupDestroy",
                                      "ProgramGroupGetStackSize",
                                      "PipelineCreate",
                                      "PipelineDestroy",
                                      "PipelineSetStackSize",
                                      "AccelComputeMemoryUsage",
                                      "AccelBuild",
                                      "AccelGetRelocationInfo",
                                      "AccelCheckRelocationCompatibility",
                                      "AccelRelocate",
                                      "AccelCompact",
                                      "ConvertPointerToTraversableHandle",
                                      "SbtRecordPackHeader",
                                      "Launch",
                                      "DenoiserCreate",
                                      "DenoiserDestroy",
                                      "DenoiserComputeMemoryResources",
                                      "DenoiserSetup",
                                      "DenoiserInvoke",
                                      "DenoiserSetModel",
                                      "DenoiserComputeIntensity"};
    if (abi >= 36)
        insertAfter(slots, "ModuleDestroy", {"BuiltinISModuleGet"});
    if (abi >= 41)
        slots.push_back("DenoiserComputeAverageColor");
    if (abi >= 47) {
        std::erase(slots, "DenoiserSetModel");
        slots.push_back("DenoiserCreateWithUserModel");
    }
    if (abi >= 55) {
        insertAfter(slots, "ModuleCreateFromPTX",
                    {"ModuleCreateFromPTXWithTasks", "ModuleGetCompilationState"});
        insertAfter(slots, "BuiltinISModuleGet", {"TaskExecute"});
        insertAfter(slots, "ConvertPointerToTraversableHandle", {"reserved1", "reserved2"});
    }
    if (abi >= 68) {
        rename(slots, "AccelCheckRelocationCompatibility", "CheckRelocationCompatibility");
        insertAfter(slots, "ConvertPointerToTraversableHandle",
                    {"OpacityMicromapArrayComputeMemoryUsage", "OpacityMicromapArrayBuild",
                     "OpacityMicromapArrayGetRelocationInfo", "OpacityMicromapArrayRelocate"});
    }
    return slots;
}

} // namespace tests::abi
