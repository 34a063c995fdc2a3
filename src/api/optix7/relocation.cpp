// SPDX-License-Identifier: Apache-2.0
// Relocation of acceleration structures and handles of transforms (OptiX 7.4, sections 3.10.2.2 and
// 3.10.2.5 to 3.10.2.7; OptiX 7.6, optixAccelRelocate and optixCheckRelocationCompatibility).
#include "api/optix7/entry_points.h"
#include "api/optix7/relocation.h"
#include "engine/accel.h"
#include "engine/micromap.h"

#include <algorithm>

namespace sunstone::optix7 {
namespace {

// New handles for the instances of a structure, or new arrays for its build inputs; empty: both
// stay unchanged.
struct Children {
    CUdeviceptr handles = 0;
    size_t count = 0;
    std::vector<const void*> arrays;
};

// `handlesName` and `countName` are the parameters' names for messages.
void checkChildren(device::Device& device, const bvh::RelocationInfo& info, const Children& children,
                   const char* handlesName, const char* countName) {
    if (children.handles == 0 && children.count == 0)
        return;
    const size_t expected = bvh::holdsInstances(info) ? bvh::relocatedPrimitives(info) : 0;
    if (children.count != expected)
        fail(Code::kInvalidValue, countName, " = ", children.count, ", but there are ", expected,
             " instances");
    requireDeviceMemory(device, handlesName, children.handles,
                        children.count * sizeof(OptixTraversableHandle),
                        sizeof(OptixTraversableHandle));
}

// The relocated micromap arrays of a triangle structure, null for an input that keeps its array;
// empty if all do.
std::vector<const void*> arraysOf(device::Device& device, const OptixRelocateInput* inputs,
                                  size_t count) {
    std::vector<const void*> arrays(count);
    for (size_t i = 0; i < count; ++i) {
        if (inputs[i].type != OPTIX_BUILD_INPUT_TYPE_TRIANGLES)
            continue;
        const CUdeviceptr array = inputs[i].triangleArray.opacityMicromap.opacityMicromapArray;
        if (array == 0)
            continue;
        requireDeviceMemory(
            device,
            message("relocateInputs[", i, "].triangleArray.opacityMicromap.opacityMicromapArray")
                .c_str(),
            array, sizeof(bvh::MicromapArrayHeader),
            OPTIX_OPACITY_MICROMAP_ARRAY_BUFFER_BYTE_ALIGNMENT);
        arrays[i] = reinterpret_cast<const void*>(array);
    }
    const bool any = std::any_of(arrays.begin(), arrays.end(), [](const void* a) { return a; });
    return any ? arrays : std::vector<const void*>();
}

// Checks the inputs of 7.6, one for each build input of the structure.
Children childrenOf(device::Device& device, const bvh::RelocationInfo& info,
                    const OptixRelocateInput* inputs, size_t count) {
    if (!inputs && count == 0)
        return {};
    requireNonNull(inputs, "relocateInputs");
    if (bvh::holdsInstances(info)) {
        if (count != 1)
            fail(Code::kInvalidValue, "numRelocateInputs = ", count,
                 ", but an instance structure has one build input");
        if (inputs[0].type != OPTIX_BUILD_INPUT_TYPE_INSTANCES &&
            inputs[0].type != OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS)
            fail(Code::kInvalidValue, "relocateInputs[0].type = ", unsigned(inputs[0].type),
                 ", but the structure was built of instances");
        const OptixRelocateInputInstanceArray& array = inputs[0].instanceArray;
        if (array.traversableHandles == 0)
            return {};
        return {array.traversableHandles, array.numInstances, {}};
    }
    if (!bvh::hasInputs(info, count))
        fail(Code::kInvalidValue, "numRelocateInputs = ", count,
             ", but the structure was built of another number of build inputs");
    for (size_t i = 0; i < count; ++i) {
        if (inputs[i].type == OPTIX_BUILD_INPUT_TYPE_INSTANCES ||
            inputs[i].type == OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS)
            fail(Code::kInvalidValue, "relocateInputs[", i,
                 "].type is INSTANCES, but the structure was built of geometry");
    }
    return {0, 0, arraysOf(device, inputs, count)};
}

// Checks and queues the relocation; `children` returns the new handles after the info has been
// checked.
template <class FindChildren>
OptixTraversableHandle relocate(DeviceContext& owner, CUstream stream,
                                const OptixRelocationInfo* info, CUdeviceptr targetAccel,
                                size_t targetAccelSizeInBytes, FindChildren findChildren) {
    device::Device& device = *owner.engine->device;
    requireNonNull(info, "info");
    const bvh::RelocationInfo translated = translate(*info);
    if (!engine::isRelocatable(*owner.engine, translated) || bvh::holdsMicromaps(translated))
        fail(Code::kInvalidValue, "info was not filled by optixAccelGetRelocationInfo of a "
                                  "compatible version");
    const uint64_t size = bvh::relocatedSize(translated);
    if (targetAccelSizeInBytes < size)
        fail(Code::kInvalidValue, "targetAccelSizeInBytes = ", targetAccelSizeInBytes,
             " is less than the ", size, " bytes of the structure");
    requireDeviceMemory(device, "targetAccel", targetAccel, targetAccelSizeInBytes,
                        OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT);
    Children children = findChildren(device, translated);
    return engine::relocateAccel(owner.engine, stream, translated,
                                 reinterpret_cast<void*>(targetAccel),
                                 reinterpret_cast<const uint64_t*>(children.handles),
                                 children.count, std::move(children.arrays));
}

} // namespace

OptixResult accelGetRelocationInfo(OptixDeviceContext context, OptixTraversableHandle handle,
                                   OptixRelocationInfo* info) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelGetRelocationInfo", [&] {
        contextOf(context);
        requireNonNull(info, "info");
        const bvh::RelocationInfo found = engine::relocationInfo(owner->engine, handle);
        std::memcpy(info, &found, sizeof(found));
    });
}

OptixResult checkRelocationCompatibility(OptixDeviceContext context,
                                         const OptixRelocationInfo* info, int* compatible) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    const char* name = owner && owner->abi < kAbi76 ? "optixAccelCheckRelocationCompatibility"
                                                    : "optixCheckRelocationCompatibility";
    return guarded(owner, name, [&] {
        contextOf(context);
        requireNonNull(info, "info");
        requireNonNull(compatible, "compatible");
        *compatible = engine::isRelocatable(*owner->engine, translate(*info));
    });
}

OptixResult accelRelocate(OptixDeviceContext context, CUstream stream,
                          const OptixRelocationInfo* info, const OptixRelocateInput* relocateInputs,
                          size_t numRelocateInputs, CUdeviceptr targetAccel,
                          size_t targetAccelSizeInBytes, OptixTraversableHandle* targetHandle) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelRelocate", [&] {
        contextOf(context);
        requireNonNull(targetHandle, "targetHandle");
        *targetHandle = relocate(
            *owner, stream, info, targetAccel, targetAccelSizeInBytes,
            [&](device::Device& device, const bvh::RelocationInfo& translated) {
                Children children = childrenOf(device, translated, relocateInputs, numRelocateInputs);
                checkChildren(device, translated, children,
                              "relocateInputs[0].instanceArray.traversableHandles",
                              "relocateInputs[0].instanceArray.numInstances");
                return children;
            });
    });
}

OptixResult accelRelocateChildren(OptixDeviceContext context, CUstream stream,
                                  const OptixRelocationInfo* info,
                                  CUdeviceptr instanceTraversableHandles,
                                  size_t numInstanceTraversableHandles, CUdeviceptr targetAccel,
                                  size_t targetAccelSizeInBytes,
                                  OptixTraversableHandle* targetHandle) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelRelocate", [&] {
        contextOf(context);
        requireNonNull(targetHandle, "targetHandle");
        *targetHandle = relocate(
            *owner, stream, info, targetAccel, targetAccelSizeInBytes,
            [&](device::Device& device, const bvh::RelocationInfo& translated) {
                Children children{instanceTraversableHandles, numInstanceTraversableHandles, {}};
                checkChildren(device, translated, children, "instanceTraversableHandles",
                              "numInstanceTraversableHandles");
                return children;
            });
    });
}

OptixResult convertPointerToTraversableHandle(OptixDeviceContext onDevice, CUdeviceptr pointer,
                                              OptixTraversableType traversableType,
                                              OptixTraversableHandle* traversableHandle) {
    std::shared_ptr<DeviceContext> owner = peek(onDevice);
    return guarded(owner, "optixConvertPointerToTraversableHandle", [&] {
        contextOf(onDevice);
        requireNonNull(traversableHandle, "traversableHandle");
        engine::TransformType type{};
        size_t size = 0;
        switch (traversableType) {
        case OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM:
            type = engine::TransformType::kStatic;
            size = sizeof(OptixStaticTransform);
            break;
        case OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM:
            type = engine::TransformType::kMatrixMotion;
            size = sizeof(OptixMatrixMotionTransform);
            break;
        case OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM:
            type = engine::TransformType::kSrtMotion;
            size = sizeof(OptixSRTMotionTransform);
            break;
        default:
            fail(Code::kInvalidValue, "traversableType = ", unsigned(traversableType),
                 " is unknown");
        }
        requireDeviceMemory(*owner->engine->device, "pointer", pointer, size,
                            OPTIX_TRANSFORM_BYTE_ALIGNMENT);
        *traversableHandle = engine::transformHandle(reinterpret_cast<const void*>(pointer), type);
        owner->engine->backend->noteTransform(*traversableHandle);
    });
}

} // namespace sunstone::optix7
