// SPDX-License-Identifier: Apache-2.0
// The steps that every OptiX program repeats: context, module, program groups, pipeline, records of
// the shader binding table, building acceleration structures. The sample `hello` contains the first
// steps in full; other samples use these functions.
#pragma once

#include "device_buffer.h"

#include <optix.h>

#include <cstdint>
#include <string_view>
#include <vector>

// A device context on the first CUDA device. Errors and warnings go to stderr.
OptixDeviceContext createContext();

// Owns the objects that a sample creates from one module of PTX.
class Program {
public:
    // `launchParams`: the name of the module's launch-parameter variable; `graphFlags`: the graphs
    // that rays may traverse (OptixTraversableGraphFlags); `opacityMicromaps`: structures may have
    // them (OptiX 7.6); `motionBlur`: rays have times.
    Program(OptixDeviceContext context, std::string_view ptx, unsigned payloadValues,
            unsigned attributeValues, unsigned primitiveTypeFlags,
            const char* launchParams = "params",
            unsigned graphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS,
            bool opacityMicromaps = false, bool motionBlur = false);
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    ~Program();

    OptixProgramGroup addRaygen(const char* function);
    OptixProgramGroup addMiss(const char* function);
    // Functions may be null.
    OptixProgramGroup addHitgroup(const char* closestHit, const char* anyHit,
                                  const char* intersection);
    // For primitives that OptiX intersects itself, curves for instance; functions may be null.
    OptixProgramGroup addBuiltinHitgroup(const char* closestHit, const char* anyHit,
                                         OptixPrimitiveType type);
    // One of the two may be null.
    OptixProgramGroup addCallables(const char* direct, const char* continuation);
    // Links all groups added so far; call once. Callables do not call further callables; a graph of
    // depth 1 is a single geometry structure.
    OptixPipeline link(unsigned maxTraceDepth, unsigned maxGraphDepth = 1);

private:
    OptixProgramGroup add(const OptixProgramGroupDesc& description);
    OptixProgramGroup addHitgroup(const char* closestHit, const char* anyHit,
                                  OptixModule intersectionModule, const char* intersection);

    OptixDeviceContext context_;
    OptixModuleCompileOptions moduleOptions_ = {};
    OptixPipelineCompileOptions options_ = {};
    OptixModule module_ = nullptr;
    OptixPipeline pipeline_ = nullptr;
    std::vector<OptixProgramGroup> groups_;
    std::vector<OptixModule> builtinModules_;
    bool hasCallables_ = false;
};

// The header of a record without data.
struct NoData {};

// One record of the shader binding table: the header names the program group, the data is what
// optixGetSbtDataPointer() returns in its programs.
template <class Data>
struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) SbtRecord {
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    Data data;
};
template <>
struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) SbtRecord<NoData> {
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
};

template <class Data>
SbtRecord<Data> makeRecord(OptixProgramGroup group, const Data& data) {
    SbtRecord<Data> record = {};
    OPTIX_CHECK(optixSbtRecordPackHeader(group, &record));
    record.data = data;
    return record;
}
inline SbtRecord<NoData> makeRecord(OptixProgramGroup group) {
    SbtRecord<NoData> record = {};
    OPTIX_CHECK(optixSbtRecordPackHeader(group, &record));
    return record;
}

// An acceleration structure and the memory it lives in.
struct Accel {
    OptixTraversableHandle handle = 0;
    DeviceBuffer memory;
};

// Builds and then compacts one acceleration structure. Fewer than two keys: no motion. `flags`:
// further OptixBuildFlags.
Accel buildAccel(OptixDeviceContext context, const OptixBuildInput& input,
                 const OptixMotionOptions& motion = {}, unsigned flags = 0);

// An acceleration structure over instances.
Accel buildInstances(OptixDeviceContext context, const std::vector<OptixInstance>& instances,
                     const OptixMotionOptions& motion = {});
