// SPDX-License-Identifier: Apache-2.0
// A pipeline with its shader binding table, made from the programs of one module, for tests that
// run device code. If a call that is not under test fails, helpers throw std::runtime_error with
// the log.
#pragma once

#include "fixture.h"

#include <memory>

namespace tests::api {

// Throws with `what` and the log unless result is OPTIX_SUCCESS.
void require(OptixResult result, const char* what, const LogRecord& log);

// Waits for all queued work only with calls of this API: destroying a context waits.
void waitForDevice();

// The state behind a test's records: module, groups, pipeline, record data. Records keep the order
// in which they are added.
class Rig {
public:
    Rig(OptixDeviceContext context, const LogRecord& log, const std::string& ptx,
        const OptixPipelineCompileOptions& options,
        OptixCompileOptimizationLevel level = OPTIX_COMPILE_OPTIMIZATION_DEFAULT);
    ~Rig();
    // For objects that their context has destroyed.
    void forget();
    Rig(const Rig&) = delete;

    // Groups; a null name means no program. The result numbers the group.
    size_t raygen(const char* name);
    size_t miss(const char* name);
    size_t hit(const char* closestHit, const char* anyHit = nullptr,
               const char* intersection = nullptr);
    size_t callables(const char* direct, const char* continuation = nullptr);
    size_t add(const OptixProgramGroupDesc& desc);

    void link(unsigned maxTraceDepth = 1);
    OptixResult tryLink(unsigned maxTraceDepth, unsigned debugLevel = 0);

    // Records, with user data after the header.
    template <class T>
    void raygenRecord(size_t group, const T& data) {
        raygen_ = {record(group, &data, sizeof(data))};
    }
    void raygenRecord(size_t group) { raygen_ = {record(group, nullptr, 0)}; }
    template <class T>
    void missRecord(size_t group, const T& data) {
        miss_.push_back(record(group, &data, sizeof(data)));
    }
    void missRecord(size_t group) { miss_.push_back(record(group, nullptr, 0)); }
    template <class T>
    void hitRecord(size_t group, const T& data) {
        hit_.push_back(record(group, &data, sizeof(data)));
    }
    void hitRecord(size_t group) { hit_.push_back(record(group, nullptr, 0)); }
    template <class T>
    void callableRecord(size_t group, const T& data) {
        callables_.push_back(record(group, &data, sizeof(data)));
    }
    void callableRecord(size_t group) { callables_.push_back(record(group, nullptr, 0)); }

    // Packs the records into device memory and describes them. Valid until the next call.
    OptixShaderBindingTable table();

    // Launches with a copy of `params`, waits, and throws on any error.
    template <class T>
    void run(const T& params, unsigned width, unsigned height = 1, unsigned depth = 1) {
        runBytes(&params, sizeof(params), width, height, depth);
    }
    void runBytes(const void* params, size_t size, unsigned width, unsigned height, unsigned depth);

    OptixModule module() const { return module_; }
    OptixPipeline pipeline() const { return pipeline_; }
    OptixProgramGroup group(size_t number) const { return groups_[number]; }

private:
    using Record = std::vector<char>;
    Record record(size_t group, const void* data, size_t size);
    static void pack(const std::vector<Record>& records, Buffer& memory, unsigned& stride);

    OptixDeviceContext context_;
    const LogRecord& log_;
    OptixPipelineCompileOptions options_;
    OptixModule module_ = nullptr;
    std::vector<OptixProgramGroup> groups_;
    OptixPipeline pipeline_ = nullptr;
    std::vector<Record> raygen_, miss_, hit_, callables_;
    Buffer raygenMemory_, missMemory_, hitMemory_, callableMemory_;
};

// Tests that run a device program once for each tool that compiled it.
class DeviceTest : public ApiTest, public testing::WithParamInterface<std::string> {
protected:
    std::string program(const char* name) { return compiledPtx(name, GetParam()); }
    std::unique_ptr<Rig> rig(const char* name, const OptixPipelineCompileOptions& options) {
        return std::make_unique<Rig>(context_, log_, program(name), options);
    }
};

#define INSTANTIATE_DEVICE_TEST(suite)                                                             \
    INSTANTIATE_TEST_SUITE_P(Compiler, suite, testing::ValuesIn(toolchains()),                     \
                             [](const auto& info) { return info.param; })

} // namespace tests::api
