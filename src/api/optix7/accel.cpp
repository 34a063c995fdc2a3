// SPDX-License-Identifier: Apache-2.0
// Acceleration structures (OptiX 7.4, section 3.10).
#include "api/optix7/build_inputs.h"
#include "api/optix7/entry_points.h"
#include "bvh/layout.h"

#include <algorithm>

namespace sunstone::optix7 {
namespace {

void checkAccelBuffer(device::Device& device, const char* name, CUdeviceptr buffer, size_t size,
                      size_t needed) {
    if (size < needed)
        fail(Code::kInvalidValue, name, "SizeInBytes = ", size, ", but ", needed,
             " bytes are needed");
    if (needed == 0)
        return;
    if (buffer == 0)
        fail(Code::kInvalidValue, name, " is 0");
    if (buffer % OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT != 0)
        fail(Code::kInvalidValue, name, " = ", reinterpret_cast<void*>(buffer),
             " is not a multiple of ", unsigned(OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT));
    if (!device.isAccessible(reinterpret_cast<void*>(buffer), size))
        fail(Code::kInvalidValue, name, " = ", reinterpret_cast<void*>(buffer), " with ", size,
             " bytes is not device memory");
}

std::vector<engine::AccelEmit> checkEmits(device::Device& device, const OptixAccelEmitDesc* descs,
                                          unsigned count, const bvh::BuildOptions& options) {
    std::vector<engine::AccelEmit> emits;
    if (count != 0)
        requireNonNull(descs, "emittedProperties");
    for (unsigned i = 0; i < count; ++i) {
        engine::AccelEmit emit;
        size_t size = 0;
        switch (descs[i].type) {
        case OPTIX_PROPERTY_TYPE_COMPACTED_SIZE:
            if (!options.allowCompaction)
                fail(Code::kInvalidValue, "emittedProperties[", i, "].type is COMPACTED_SIZE, but "
                     "accelOptions->buildFlags lacks ALLOW_COMPACTION");
            emit.kind = engine::AccelEmit::kCompactedSize;
            size = sizeof(uint64_t);
            break;
        case OPTIX_PROPERTY_TYPE_AABBS:
            emit.kind = engine::AccelEmit::kBounds;
            size = sizeof(OptixAabb) * options.motion.keys;
            break;
        default:
            fail(Code::kInvalidValue, "emittedProperties[", i, "].type = ",
                 unsigned(descs[i].type), " is unknown");
        }
        unsigned alignment = emit.kind == engine::AccelEmit::kCompactedSize ? 8 : 4;
        void* destination = reinterpret_cast<void*>(descs[i].result);
        if (!destination || descs[i].result % alignment != 0 ||
            !device.isAccessible(destination, size))
            fail(Code::kInvalidValue, "emittedProperties[", i, "].result = ", destination,
                 " is not device memory of ", size, " bytes aligned to ", alignment);
        emit.destination = destination;
        emits.push_back(emit);
    }
    return emits;
}

} // namespace

OptixResult accelComputeMemoryUsage(OptixDeviceContext context,
                                    const OptixAccelBuildOptions* accelOptions,
                                    BuildInputs buildInputs, unsigned numBuildInputs,
                                    OptixAccelBufferSizes* bufferSizes) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelComputeMemoryUsage", [&] {
        contextOf(context);
        const ApiCall call{*owner, "optixAccelComputeMemoryUsage"};
        bvh::BuildOptions options = checkBuildOptions(accelOptions, call);
        auto inputs = checkBuildInputs(buildInputs, numBuildInputs, options.motion.keys,
                                       InputCheck::kShape, call);
        requireNonNull(bufferSizes, "bufferSizes");
        bvh::MemoryUsage usage = engine::accelMemory(*owner->engine, *inputs, options);
        bufferSizes->outputSizeInBytes = usage.output;
        bufferSizes->tempSizeInBytes = usage.temp;
        bufferSizes->tempUpdateSizeInBytes = usage.tempUpdate;
    });
}

OptixResult accelBuild(OptixDeviceContext context, CUstream stream,
                       const OptixAccelBuildOptions* accelOptions,
                       BuildInputs buildInputs, unsigned numBuildInputs, CUdeviceptr tempBuffer,
                       size_t tempBufferSize, CUdeviceptr outputBuffer, size_t outputBufferSize,
                       OptixTraversableHandle* outputHandle,
                       const OptixAccelEmitDesc* emittedProperties, unsigned numEmitted) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelBuild", [&] {
        contextOf(context);
        device::Device& device = *owner->engine->device;
        engine::AccelBuild request;
        const ApiCall call{*owner, "optixAccelBuild"};
        request.options = checkBuildOptions(accelOptions, call);
        request.update = accelOptions->operation == OPTIX_BUILD_OPERATION_UPDATE;
        if (request.update && !request.options.allowUpdate)
            fail(Code::kInvalidValue, "accelOptions->operation is UPDATE, but buildFlags lacks "
                 "ALLOW_UPDATE");
        requireNonNull(outputHandle, "outputHandle");
        request.inputs = checkBuildInputs(buildInputs, numBuildInputs, request.options.motion.keys,
                                          InputCheck::kBuffers, call);
        bvh::MemoryUsage usage =
            engine::accelMemory(*owner->engine, *request.inputs, request.options);
        checkAccelBuffer(device, "tempBuffer", tempBuffer, tempBufferSize,
                         request.update ? usage.tempUpdate : usage.temp);
        // The buffer of an update may be smaller than that of a build, after compaction.
        checkAccelBuffer(device, "outputBuffer", outputBuffer, outputBufferSize,
                         request.update ? sizeof(bvh::BlockHeader) : usage.output);
        request.emit = checkEmits(device, emittedProperties, numEmitted, request.options);
        request.temp = reinterpret_cast<void*>(tempBuffer);
        request.tempSize = tempBufferSize;
        request.output = reinterpret_cast<void*>(outputBuffer);
        request.outputSize = outputBufferSize;
        request.stream = stream;
        if (owner->engine->validation) {
            const Abi abi = buildInputs.abi();
            request.rules = {Limits::instanceId(abi), Limits::sbtOffset(abi),
                             Limits::kVisibilityMaskBits, knownInstanceFlags(abi)};
        }
        *outputHandle = engine::buildAccel(owner->engine, std::move(request));
    });
}

OptixResult accelCompact(OptixDeviceContext context, CUstream stream,
                         OptixTraversableHandle inputHandle, CUdeviceptr outputBuffer,
                         size_t outputBufferSize, OptixTraversableHandle* outputHandle) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelCompact", [&] {
        contextOf(context);
        requireNonNull(outputHandle, "outputHandle");
        if (inputHandle == 0)
            fail(Code::kInvalidValue, "inputHandle is 0");
        checkAccelBuffer(*owner->engine->device, "outputBuffer", outputBuffer, outputBufferSize, 1);
        *outputHandle = engine::compactAccel(owner->engine, stream, inputHandle,
                                             reinterpret_cast<void*>(outputBuffer),
                                             outputBufferSize);
    });
}

} // namespace sunstone::optix7
