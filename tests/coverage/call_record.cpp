// SPDX-License-Identifier: Apache-2.0
#include "call_record.h"

#include "optix.h"
#include "optix_stubs.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <type_traits>
#include <utility>

namespace tests {

namespace {

// The contents of a handle: the source files of the programs in it.
using Sources = std::set<std::string>;

struct Record {
    std::mutex mutex;
    std::set<std::pair<std::string, int>> calls; // of the running test
    Sources launched;                            // in the running test
    std::map<std::string, std::string> sourceOfPtx;
    std::map<const void*, Sources> sourcesOf; // modules, groups, pipelines
    OptixFunctionTable real{};
};

Record& record() {
    static Record instance;
    return instance;
}

void noteCall(const char* function, int result) {
    std::lock_guard lock(record().mutex);
    record().calls.emplace(function, result);
}

// Adds the sources of a part (a module of a group, a group of a pipeline) to those of the whole.
void join(const void* whole, const void* part) {
    auto found = record().sourcesOf.find(part);
    if (part && found != record().sourcesOf.end()) {
        Sources sources = found->second;
        record().sourcesOf[whole].insert(sources.begin(), sources.end());
    }
}

void noteModule(const char* ptx, size_t size, OptixModule module) {
    std::lock_guard lock(record().mutex);
    record().sourcesOf.erase(module);
    auto found = record().sourceOfPtx.find(std::string(ptx, size));
    if (found != record().sourceOfPtx.end())
        record().sourcesOf[module] = {found->second};
}

void noteGroups(const OptixProgramGroupDesc* descs, unsigned count, OptixProgramGroup* groups) {
    std::lock_guard lock(record().mutex);
    for (unsigned i = 0; i < count; ++i) {
        const OptixProgramGroupDesc& d = descs[i];
        record().sourcesOf.erase(groups[i]);
        switch (d.kind) {
        case OPTIX_PROGRAM_GROUP_KIND_HITGROUP:
            join(groups[i], d.hitgroup.moduleCH);
            join(groups[i], d.hitgroup.moduleAH);
            join(groups[i], d.hitgroup.moduleIS);
            break;
        case OPTIX_PROGRAM_GROUP_KIND_CALLABLES:
            join(groups[i], d.callables.moduleDC);
            join(groups[i], d.callables.moduleCC);
            break;
        default:
            join(groups[i], d.raygen.module); // miss and exception have the same place
        }
    }
}

void notePipeline(const OptixProgramGroup* groups, unsigned count, OptixPipeline pipeline) {
    std::lock_guard lock(record().mutex);
    record().sourcesOf.erase(pipeline);
    for (unsigned i = 0; i < count; ++i)
        join(pipeline, groups[i]);
}

void noteLaunch(OptixPipeline pipeline) {
    std::lock_guard lock(record().mutex);
    const Sources& sources = record().sourcesOf[pipeline];
    record().launched.insert(sources.begin(), sources.end());
}

// One recording function for each slot of the table.
template <auto Slot, class Function>
struct Recorder;
template <auto Slot, class Result, class... Arguments>
struct Recorder<Slot, Result (*)(Arguments...)> {
    static inline const char* name = nullptr;
    static Result call(Arguments... arguments) {
        Result result = (record().real.*Slot)(arguments...);
        if constexpr (std::is_same_v<Result, OptixResult>) {
            noteCall(name, int(result));
            if (result == OPTIX_SUCCESS)
                follow(arguments...);
        } else {
            noteCall(name, 0);
        }
        return result;
    }

private:
    static void follow(Arguments... arguments) {
        [[maybe_unused]] auto values = std::forward_as_tuple(arguments...);
        if constexpr (same<&OptixFunctionTable::optixModuleCreateFromPTX>())
            noteModule(std::get<3>(values), std::get<4>(values), *std::get<7>(values));
        if constexpr (same<&OptixFunctionTable::optixModuleCreateFromPTXWithTasks>())
            noteModule(std::get<3>(values), std::get<4>(values), *std::get<7>(values));
        if constexpr (same<&OptixFunctionTable::optixProgramGroupCreate>())
            noteGroups(std::get<1>(values), std::get<2>(values), std::get<6>(values));
        if constexpr (same<&OptixFunctionTable::optixPipelineCreate>())
            notePipeline(std::get<3>(values), std::get<4>(values), *std::get<7>(values));
        if constexpr (same<&OptixFunctionTable::optixLaunch>())
            noteLaunch(std::get<0>(values));
    }
    template <auto Other>
    static constexpr bool same() {
        if constexpr (std::is_same_v<decltype(Slot), decltype(Other)>)
            return Slot == Other;
        else
            return false;
    }
};

template <auto Slot>
void put(const char* name) {
    using Function = std::remove_reference_t<decltype(std::declval<OptixFunctionTable>().*Slot)>;
    using Wrapper = Recorder<Slot, Function>;
    Wrapper::name = name;
    if (g_optixFunctionTable.*Slot == Wrapper::call || !(g_optixFunctionTable.*Slot))
        return;
    record().real.*Slot = g_optixFunctionTable.*Slot;
    g_optixFunctionTable.*Slot = Wrapper::call;
}

std::string fromTests(const std::string& path) {
    size_t at = path.rfind("tests/");
    return at == std::string::npos ? path : path.substr(at);
}

// Writes the file of a test when it passes, and clears the record for the next test.
class Writer : public testing::EmptyTestEventListener {
public:
    explicit Writer(std::string folder) : folder_(std::move(folder)) {}

private:
    void OnTestStart(const testing::TestInfo&) override {
        std::lock_guard lock(record().mutex);
        record().calls.clear();
        record().launched.clear();
    }
    void OnTestEnd(const testing::TestInfo& test) override {
        if (!test.result()->Passed())
            return;
        std::string name = std::string(test.test_suite_name()) + "." + test.name();
        for (char& c : name)
            if (c == '/')
                c = '_';
        std::lock_guard lock(record().mutex);
        std::ofstream file(folder_ + "/" + name);
        file << "source " << fromTests(test.file()) << "\n";
        for (const auto& [function, result] : record().calls)
            file << "call " << function << " " << result << "\n";
        for (const std::string& source : record().launched)
            file << "launched " << source << "\n";
        if (!file.flush())
            ADD_FAILURE() << "cannot write " << folder_ << "/" << name;
    }
    std::string folder_;
};

// Runs before main, because the listener must exist when the first test starts.
const bool gIsRecording = [] {
    const char* folder = std::getenv("SUNSTONE_CALL_RECORD");
    if (!folder || !*folder)
        return false;
    testing::UnitTest::GetInstance()->listeners().Append(new Writer(folder));
    return true;
}();

} // namespace

void recordProgram(const std::string& ptx, const std::string& sourceFile) {
    if (!gIsRecording)
        return;
    std::lock_guard lock(record().mutex);
    record().sourceOfPtx[ptx] = sourceFile;
}

void recordCalls() {
    if (!gIsRecording)
        return;
#define PUT(name) put<&OptixFunctionTable::name>(#name)
    PUT(optixGetErrorName);
    PUT(optixGetErrorString);
    PUT(optixDeviceContextCreate);
    PUT(optixDeviceContextDestroy);
    PUT(optixDeviceContextGetProperty);
    PUT(optixDeviceContextSetLogCallback);
    PUT(optixDeviceContextSetCacheEnabled);
    PUT(optixDeviceContextSetCacheLocation);
    PUT(optixDeviceContextSetCacheDatabaseSizes);
    PUT(optixDeviceContextGetCacheEnabled);
    PUT(optixDeviceContextGetCacheLocation);
    PUT(optixDeviceContextGetCacheDatabaseSizes);
    PUT(optixModuleCreateFromPTX);
    PUT(optixModuleCreateFromPTXWithTasks);
    PUT(optixModuleGetCompilationState);
    PUT(optixModuleDestroy);
    PUT(optixBuiltinISModuleGet);
    PUT(optixTaskExecute);
    PUT(optixProgramGroupCreate);
    PUT(optixProgramGroupDestroy);
    PUT(optixProgramGroupGetStackSize);
    PUT(optixPipelineCreate);
    PUT(optixPipelineDestroy);
    PUT(optixPipelineSetStackSize);
    PUT(optixAccelComputeMemoryUsage);
    PUT(optixAccelBuild);
    PUT(optixAccelGetRelocationInfo);
#if OPTIX_VERSION >= 70600
    PUT(optixCheckRelocationCompatibility);
    PUT(optixOpacityMicromapArrayComputeMemoryUsage);
    PUT(optixOpacityMicromapArrayBuild);
    PUT(optixOpacityMicromapArrayGetRelocationInfo);
    PUT(optixOpacityMicromapArrayRelocate);
#else
    PUT(optixAccelCheckRelocationCompatibility);
#endif
    PUT(optixAccelRelocate);
    PUT(optixAccelCompact);
    PUT(optixConvertPointerToTraversableHandle);
    PUT(optixSbtRecordPackHeader);
    PUT(optixLaunch);
    PUT(optixDenoiserCreate);
    PUT(optixDenoiserDestroy);
    PUT(optixDenoiserComputeMemoryResources);
    PUT(optixDenoiserSetup);
    PUT(optixDenoiserInvoke);
    PUT(optixDenoiserComputeIntensity);
    PUT(optixDenoiserComputeAverageColor);
    PUT(optixDenoiserCreateWithUserModel);
#undef PUT
}

} // namespace tests
