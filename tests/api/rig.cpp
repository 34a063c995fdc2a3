// SPDX-License-Identifier: Apache-2.0
#include "rig.h"

#include <algorithm>
#include <stdexcept>

namespace tests::api {

void require(OptixResult result, const char* what, const LogRecord& log) {
    if (result != OPTIX_SUCCESS)
        throw std::runtime_error(std::string(what) + ": " + optixGetErrorName(result) + "\n" +
                                 log.all());
}

void waitForDevice() {
    OptixDeviceContext context = nullptr;
    if (optixDeviceContextCreate(nullptr, nullptr, &context) != OPTIX_SUCCESS ||
        optixDeviceContextDestroy(context) != OPTIX_SUCCESS)
        throw std::runtime_error("cannot wait for the device");
    ApiTest::hearReports();
}

Rig::Rig(OptixDeviceContext context, const LogRecord& log, const std::string& ptx,
         const OptixPipelineCompileOptions& options, OptixCompileOptimizationLevel level)
    : context_(context), log_(log), options_(options) {
    OptixModuleCompileOptions moduleOptions{};
    moduleOptions.optLevel = level;
    require(optixModuleCreateFromPTX(context, &moduleOptions, &options_, ptx.data(), ptx.size(),
                                     nullptr, nullptr, &module_),
            "optixModuleCreateFromPTX", log);
}

Rig::~Rig() {
    if (pipeline_)
        optixPipelineDestroy(pipeline_);
    for (OptixProgramGroup group : groups_)
        optixProgramGroupDestroy(group);
    if (module_)
        optixModuleDestroy(module_);
}

void Rig::forget() {
    pipeline_ = nullptr;
    groups_.clear();
    module_ = nullptr;
}

size_t Rig::add(const OptixProgramGroupDesc& desc) {
    OptixProgramGroupOptions options{};
    OptixProgramGroup group = nullptr;
    require(optixProgramGroupCreate(context_, &desc, 1, &options, nullptr, nullptr, &group),
            "optixProgramGroupCreate", log_);
    groups_.push_back(group);
    return groups_.size() - 1;
}

size_t Rig::raygen(const char* name) {
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    desc.raygen = {module_, name};
    return add(desc);
}

size_t Rig::miss(const char* name) {
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
    desc.miss = {name ? module_ : nullptr, name};
    return add(desc);
}

size_t Rig::hit(const char* closestHit, const char* anyHit, const char* intersection) {
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
    desc.hitgroup.moduleCH = closestHit ? module_ : nullptr;
    desc.hitgroup.entryFunctionNameCH = closestHit;
    desc.hitgroup.moduleAH = anyHit ? module_ : nullptr;
    desc.hitgroup.entryFunctionNameAH = anyHit;
    desc.hitgroup.moduleIS = intersection ? module_ : nullptr;
    desc.hitgroup.entryFunctionNameIS = intersection;
    return add(desc);
}

size_t Rig::callables(const char* direct, const char* continuation) {
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
    desc.callables.moduleDC = direct ? module_ : nullptr;
    desc.callables.entryFunctionNameDC = direct;
    desc.callables.moduleCC = continuation ? module_ : nullptr;
    desc.callables.entryFunctionNameCC = continuation;
    return add(desc);
}

OptixResult Rig::tryLink(unsigned maxTraceDepth, unsigned debugLevel) {
    OptixPipelineLinkOptions link{};
    link.maxTraceDepth = maxTraceDepth;
    std::memcpy(&link.debugLevel, &debugLevel, sizeof(debugLevel));
    if (pipeline_)
        optixPipelineDestroy(pipeline_);
    pipeline_ = nullptr;
    return optixPipelineCreate(context_, &options_, &link, groups_.data(), unsigned(groups_.size()),
                               nullptr, nullptr, &pipeline_);
}

void Rig::link(unsigned maxTraceDepth) {
    require(tryLink(maxTraceDepth), "optixPipelineCreate", log_);
}

Rig::Record Rig::record(size_t group, const void* data, size_t size) {
    Record record(OPTIX_SBT_RECORD_HEADER_SIZE + size);
    require(optixSbtRecordPackHeader(groups_.at(group), record.data()), "optixSbtRecordPackHeader",
            log_);
    if (size != 0)
        std::memcpy(record.data() + OPTIX_SBT_RECORD_HEADER_SIZE, data, size);
    return record;
}

void Rig::pack(const std::vector<Record>& records, Buffer& memory, unsigned& stride) {
    size_t longest = 0;
    for (const Record& record : records)
        longest = std::max(longest, record.size());
    size_t alignment = OPTIX_SBT_RECORD_ALIGNMENT;
    stride = unsigned((longest + alignment - 1) / alignment * alignment);
    memory = Buffer(stride * records.size(), alignment);
    for (size_t i = 0; i < records.size(); ++i)
        std::memcpy(memory.as<char>() + i * stride, records[i].data(), records[i].size());
}

OptixShaderBindingTable Rig::table() {
    OptixShaderBindingTable sbt{};
    unsigned unused = 0;
    pack(raygen_, raygenMemory_, unused);
    sbt.raygenRecord = raygenMemory_.address();
    auto fill = [](const std::vector<Record>& records, Buffer& memory, CUdeviceptr& base,
                   unsigned& stride, unsigned& count) {
        if (records.empty())
            return;
        pack(records, memory, stride);
        base = memory.address();
        count = unsigned(records.size());
    };
    fill(miss_, missMemory_, sbt.missRecordBase, sbt.missRecordStrideInBytes, sbt.missRecordCount);
    fill(hit_, hitMemory_, sbt.hitgroupRecordBase, sbt.hitgroupRecordStrideInBytes,
         sbt.hitgroupRecordCount);
    fill(callables_, callableMemory_, sbt.callablesRecordBase, sbt.callablesRecordStrideInBytes,
         sbt.callablesRecordCount);
    return sbt;
}

void Rig::runBytes(const void* params, size_t size, unsigned width, unsigned height,
                   unsigned depth) {
    Buffer memory(size);
    std::memcpy(memory.as<char>(), params, size);
    OptixShaderBindingTable sbt = table();
    require(optixLaunch(pipeline_, nullptr, memory.address(), size, &sbt, width, height, depth),
            "optixLaunch", log_);
    waitForDevice();
    if (log_.hasUnexpectedError())
        throw std::runtime_error("errors in the log:\n" + log_.all());
}

} // namespace tests::api
