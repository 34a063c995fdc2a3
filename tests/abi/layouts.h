// SPDX-License-Identifier: Apache-2.0
// Structs of the OptiX 7 releases as their clients see them, each with its size and offsets. This
// file is independent of Sunstone's headers, which these tests do not include: the reference is the
// ABI. A struct is named after the first release that has it in this form.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tests::abi {

using DevicePointer = unsigned long long; // CUdeviceptr
using Handle = unsigned long long;        // OptixTraversableHandle

#define SIZE(type, bytes) static_assert(sizeof(type) == (bytes), #type)
#define OFFSET(type, member, bytes)                                                                \
    static_assert(offsetof(type, member) == (bytes), #type "::" #member)

// ---- Context ----

using LogCallback = void (*)(unsigned level, const char* tag, const char* message, void* data);

struct DeviceContextOptions70 {
    LogCallback logCallbackFunction;
    void* logCallbackData;
    int logCallbackLevel;
    int padding20;
};
struct DeviceContextOptions72 {
    LogCallback logCallbackFunction;
    void* logCallbackData;
    int logCallbackLevel;
    int validationMode;
};
SIZE(DeviceContextOptions70, 24);
OFFSET(DeviceContextOptions70, logCallbackLevel, 16);
SIZE(DeviceContextOptions72, 24);
OFFSET(DeviceContextOptions72, validationMode, 20);

// ---- Modules, groups, pipelines ----

struct ModuleCompileOptions70 {
    int maxRegisterCount;
    int optLevel;
    int debugLevel;
};
struct ModuleCompileOptions72 {
    int maxRegisterCount;
    int optLevel;
    int debugLevel;
    int padding12;
    const void* boundValues;
    unsigned numBoundValues;
    unsigned padding28;
};
struct ModuleCompileOptions74 {
    int maxRegisterCount;
    int optLevel;
    int debugLevel;
    int padding12;
    const void* boundValues;
    unsigned numBoundValues;
    unsigned numPayloadTypes;
    const void* payloadTypes;
};
SIZE(ModuleCompileOptions70, 12);
SIZE(ModuleCompileOptions72, 32);
OFFSET(ModuleCompileOptions72, boundValues, 16);
OFFSET(ModuleCompileOptions72, numBoundValues, 24);
SIZE(ModuleCompileOptions74, 40);
OFFSET(ModuleCompileOptions74, numPayloadTypes, 28);
OFFSET(ModuleCompileOptions74, payloadTypes, 32);

struct BoundValueEntry {
    size_t offset, size;
    const void* value;
    const char* annotation;
};
SIZE(BoundValueEntry, 32);

struct PipelineCompileOptions70 {
    int usesMotionBlur;
    unsigned traversableGraphFlags;
    int numPayloadValues;
    int numAttributeValues;
    unsigned exceptionFlags;
    unsigned padding20;
    const char* pipelineLaunchParamsVariableName;
};
struct PipelineCompileOptions71 : PipelineCompileOptions70 {
    unsigned usesPrimitiveTypeFlags;
    unsigned padding36;
};
struct PipelineCompileOptions73 : PipelineCompileOptions70 {
    unsigned usesPrimitiveTypeFlags;
    unsigned reserved;
    size_t reserved2;
};
struct PipelineCompileOptions76 : PipelineCompileOptions70 {
    unsigned usesPrimitiveTypeFlags;
    int allowOpacityMicromaps;
};
SIZE(PipelineCompileOptions70, 32);
OFFSET(PipelineCompileOptions70, numPayloadValues, 8);
OFFSET(PipelineCompileOptions70, exceptionFlags, 16);
OFFSET(PipelineCompileOptions70, pipelineLaunchParamsVariableName, 24);
SIZE(PipelineCompileOptions71, 40);
SIZE(PipelineCompileOptions73, 48);
SIZE(PipelineCompileOptions76, 40);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winvalid-offsetof"
OFFSET(PipelineCompileOptions71, usesPrimitiveTypeFlags, 32);
OFFSET(PipelineCompileOptions73, reserved, 36);
OFFSET(PipelineCompileOptions73, reserved2, 40);
OFFSET(PipelineCompileOptions76, allowOpacityMicromaps, 36);
#pragma GCC diagnostic pop

struct PipelineLinkOptions70 {
    unsigned maxTraceDepth;
    int debugLevel;
    int overrideUsesMotionBlur;
};
struct PipelineLinkOptions71 {
    unsigned maxTraceDepth;
    int debugLevel;
};
SIZE(PipelineLinkOptions70, 12);
SIZE(PipelineLinkOptions71, 8);

struct ProgramGroupOptions70 {
    int placeholder;
};
struct ProgramGroupOptions74 {
    const void* payloadType;
};
SIZE(ProgramGroupOptions70, 4);
SIZE(ProgramGroupOptions74, 8);

struct ProgramGroupDesc {
    int kind;
    unsigned flags;
    struct Program {
        void* module;
        const char* name;
    } programs[3]; // raygen, miss, exception: one; callables: DC, CC; hit group: CH, AH, IS
};
SIZE(ProgramGroupDesc, 56);
OFFSET(ProgramGroupDesc, programs, 8);

struct StackSizes {
    unsigned cssRG, cssMS, cssCH, cssAH, cssIS, cssCC, dssDC;
};
SIZE(StackSizes, 28);

struct ShaderBindingTable {
    DevicePointer raygenRecord;
    DevicePointer exceptionRecord;
    DevicePointer missRecordBase;
    unsigned missRecordStride, missRecordCount;
    DevicePointer hitgroupRecordBase;
    unsigned hitgroupRecordStride, hitgroupRecordCount;
    DevicePointer callablesRecordBase;
    unsigned callablesRecordStride, callablesRecordCount;
};
SIZE(ShaderBindingTable, 64);
OFFSET(ShaderBindingTable, hitgroupRecordBase, 32);
OFFSET(ShaderBindingTable, callablesRecordBase, 48);

struct BuiltinISOptions71 {
    int type;
    int usesMotionBlur;
};
struct BuiltinISOptions74 {
    int type;
    int usesMotionBlur;
    unsigned buildFlags;
    unsigned curveEndcapFlags;
};
SIZE(BuiltinISOptions71, 8);
SIZE(BuiltinISOptions74, 16);

// ---- Acceleration structures ----

struct TriangleArray70 {
    const DevicePointer* vertexBuffers;
    unsigned numVertices;
    int vertexFormat;
    unsigned vertexStride;
    unsigned padding20;
    DevicePointer indexBuffer;
    unsigned numIndexTriplets;
    int indexFormat;
    unsigned indexStride;
    unsigned padding44;
    DevicePointer preTransform;
    const unsigned* flags;
    unsigned numSbtRecords;
    unsigned padding68;
    DevicePointer sbtIndexOffsetBuffer;
    unsigned sbtIndexOffsetSize, sbtIndexOffsetStride;
    unsigned primitiveIndexOffset;
    int transformFormat; // from 7.1 on; padding in 7.0
};
struct OpacityMicromap {
    int indexingMode;
    DevicePointer array;
    DevicePointer indexBuffer;
    unsigned indexSize, indexStride, indexOffset, numUsageCounts;
    const void* usageCounts;
};
struct TriangleArray76 {
    TriangleArray70 common;
    OpacityMicromap micromap;
};
SIZE(TriangleArray70, 96);
OFFSET(TriangleArray70, vertexStride, 16);
OFFSET(TriangleArray70, indexBuffer, 24);
OFFSET(TriangleArray70, preTransform, 48);
OFFSET(TriangleArray70, flags, 56);
OFFSET(TriangleArray70, sbtIndexOffsetBuffer, 72);
OFFSET(TriangleArray70, primitiveIndexOffset, 88);
OFFSET(TriangleArray70, transformFormat, 92);
SIZE(OpacityMicromap, 48);
SIZE(TriangleArray76, 144);
OFFSET(TriangleArray76, micromap, 96);

struct CurveArray71 { // endcapFlags from 7.4 on; padding before
    int curveType;
    unsigned numPrimitives;
    const DevicePointer* vertexBuffers;
    unsigned numVertices, vertexStride;
    const DevicePointer* widthBuffers;
    unsigned widthStride;
    const DevicePointer* normalBuffers;
    unsigned normalStride;
    DevicePointer indexBuffer;
    unsigned indexStride, flag, primitiveIndexOffset, endcapFlags;
};
SIZE(CurveArray71, 80);
OFFSET(CurveArray71, widthBuffers, 24);
OFFSET(CurveArray71, normalBuffers, 40);
OFFSET(CurveArray71, indexBuffer, 56);
OFFSET(CurveArray71, endcapFlags, 76);

struct SphereArray75 {
    const DevicePointer* vertexBuffers;
    unsigned vertexStride, numVertices;
    const DevicePointer* radiusBuffers;
    unsigned radiusStride;
    int singleRadius;
    const unsigned* flags;
    unsigned numSbtRecords;
    DevicePointer sbtIndexOffsetBuffer;
    unsigned sbtIndexOffsetSize, sbtIndexOffsetStride, primitiveIndexOffset;
};
SIZE(SphereArray75, 72);
OFFSET(SphereArray75, radiusBuffers, 16);
OFFSET(SphereArray75, singleRadius, 28);
OFFSET(SphereArray75, flags, 32);
OFFSET(SphereArray75, sbtIndexOffsetBuffer, 48);
OFFSET(SphereArray75, primitiveIndexOffset, 64);

struct CustomPrimitiveArray {
    const DevicePointer* aabbBuffers;
    unsigned numPrimitives, stride;
    const unsigned* flags;
    unsigned numSbtRecords;
    DevicePointer sbtIndexOffsetBuffer;
    unsigned sbtIndexOffsetSize, sbtIndexOffsetStride, primitiveIndexOffset;
};
SIZE(CustomPrimitiveArray, 56);
OFFSET(CustomPrimitiveArray, flags, 16);
OFFSET(CustomPrimitiveArray, sbtIndexOffsetBuffer, 32);
OFFSET(CustomPrimitiveArray, primitiveIndexOffset, 48);

struct InstanceArray70 {
    DevicePointer instances;
    unsigned numInstances;
    unsigned padding12;
    DevicePointer aabbs;
    unsigned numAabbs;
    unsigned padding28;
};
struct InstanceArray72 {
    DevicePointer instances;
    unsigned numInstances;
    unsigned instanceStride; // from 7.6 on; padding before
};
SIZE(InstanceArray70, 32);
OFFSET(InstanceArray70, aabbs, 16);
SIZE(InstanceArray72, 16);
OFFSET(InstanceArray72, instanceStride, 12);

struct BuildInput {
    int type;
    int padding4;
    union {
        TriangleArray76 triangles;
        CurveArray71 curves;
        SphereArray75 spheres;
        CustomPrimitiveArray customs;
        InstanceArray70 instances70;
        InstanceArray72 instances72;
        char pad[1024];
    };
};
SIZE(BuildInput, 1032);
OFFSET(BuildInput, pad, 8);

struct Instance {
    float transform[12];
    unsigned instanceId, sbtOffset, visibilityMask, flags;
    Handle handle;
    unsigned pad[2];
};
SIZE(Instance, 80);
OFFSET(Instance, instanceId, 48);
OFFSET(Instance, flags, 60);
OFFSET(Instance, handle, 64);

struct AccelBuildOptions {
    unsigned buildFlags;
    int operation;
    uint16_t numKeys, motionFlags;
    float timeBegin, timeEnd;
};
SIZE(AccelBuildOptions, 20);
struct AccelBufferSizes {
    size_t output, temp, tempUpdate;
};
SIZE(AccelBufferSizes, 24);
struct AccelEmitDesc {
    DevicePointer result;
    int type;
};
SIZE(AccelEmitDesc, 16);
struct RelocationInfo {
    unsigned long long info[4];
};
SIZE(RelocationInfo, 32);
struct RelocateInput76 {
    int type;
    union {
        struct {
            unsigned numInstances;
            DevicePointer traversableHandles;
        } instances;
        struct {
            unsigned numSbtRecords;
            DevicePointer opacityMicromapArray;
        } triangles;
    };
};
SIZE(RelocateInput76, 24);
OFFSET(RelocateInput76, instances.traversableHandles, 16);

// ---- Denoiser ----

struct Image2D {
    DevicePointer data;
    unsigned width, height, rowStride, pixelStride;
    int format;
};
SIZE(Image2D, 32);
OFFSET(Image2D, format, 24);

struct DenoiserOptions70 {
    int inputKind;
    int pixelFormat;
};
struct DenoiserOptions71 {
    int inputKind;
};
struct DenoiserOptions73 {
    unsigned guideAlbedo, guideNormal;
};
SIZE(DenoiserOptions70, 8);
SIZE(DenoiserOptions71, 4);
SIZE(DenoiserOptions73, 8);

struct DenoiserParams70 {
    unsigned denoiseAlpha;
    DevicePointer hdrIntensity;
    float blendFactor;
    unsigned padding20;
};
struct DenoiserParams72 {
    unsigned denoiseAlpha;
    DevicePointer hdrIntensity;
    float blendFactor;
    unsigned padding20;
    DevicePointer hdrAverageColor;
};
struct DenoiserParams75 {
    unsigned denoiseAlpha;
    DevicePointer hdrIntensity;
    float blendFactor;
    unsigned padding20;
    DevicePointer hdrAverageColor;
    unsigned temporalModeUsePreviousLayers;
    unsigned padding36;
};
SIZE(DenoiserParams70, 24);
OFFSET(DenoiserParams70, hdrIntensity, 8);
OFFSET(DenoiserParams70, blendFactor, 16);
SIZE(DenoiserParams72, 32);
OFFSET(DenoiserParams72, hdrAverageColor, 24);
SIZE(DenoiserParams75, 40);
OFFSET(DenoiserParams75, temporalModeUsePreviousLayers, 32);

struct DenoiserSizes70 {
    size_t state, withOverlap, withoutOverlap;
    unsigned overlap;
    unsigned padding28;
};
struct DenoiserSizes75 {
    size_t state, withOverlap, withoutOverlap;
    unsigned overlap;
    unsigned padding28;
    size_t averageColor, intensity;
    unsigned internalGuideLayerPixelSize;
    unsigned padding52;
};
SIZE(DenoiserSizes70, 32);
OFFSET(DenoiserSizes70, overlap, 24);
SIZE(DenoiserSizes75, 56);
OFFSET(DenoiserSizes75, averageColor, 32);
OFFSET(DenoiserSizes75, internalGuideLayerPixelSize, 48);

struct GuideLayer73 {
    Image2D albedo, normal, flow;
};
struct GuideLayer75 {
    Image2D albedo, normal, flow, previousOutputInternal, outputInternal;
};
struct DenoiserLayer {
    Image2D input, previousOutput, output;
};
SIZE(GuideLayer73, 96);
SIZE(GuideLayer75, 160);
OFFSET(GuideLayer75, previousOutputInternal, 96);
OFFSET(GuideLayer75, outputInternal, 128);
SIZE(DenoiserLayer, 96);

#undef SIZE
#undef OFFSET

} // namespace tests::abi
