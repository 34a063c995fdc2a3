// SPDX-License-Identifier: Apache-2.0
// Relocation of acceleration structures and handles of transforms (OptiX 7.4, sections 3.10.2.2 and
// 3.10.2.5 to 3.10.2.7).
#include "api/optix7/entry_points.h"
#include "api/optix7/shell.h"
#include "engine/accel.h"

namespace sunstone::optix7 {
namespace {

static_assert(sizeof(OptixAccelRelocationInfo) == sizeof(bvh::RelocationInfo));

bvh::RelocationInfo translate(const OptixAccelRelocationInfo& info) {
    bvh::RelocationInfo out;
    std::memcpy(&out, &info, sizeof(out));
    return out;
}

void requireDeviceMemory(device::Device& device, const char* name, CUdeviceptr address, size_t size,
                         unsigned alignment) {
    void* pointer = reinterpret_cast<void*>(address);
    if (!pointer)
        fail(Code::kInvalidValue, name, " is 0");
    if (address % alignment != 0)
        fail(Code::kInvalidValue, name, " = ", pointer, " is not a multiple of ", alignment);
    if (!device.isAccessible(pointer, size))
        fail(Code::kInvalidValue, name, " = ", pointer, " with ", size,
             " bytes is not device memory");
}

// Checks the handles for the instances; returns their number.
void checkChildren(device::Device& device, const bvh::RelocationInfo& info, CUdeviceptr handles,
                   size_t count) {
    if (handles == 0 && count == 0)
        return;
    const size_t expected = bvh::holdsInstances(info) ? bvh::relocatedPrimitives(info) : 0;
    if (count != expected)
        fail(Code::kInvalidValue, "numInstanceTraversableHandles = ", count, ", but there are ",
             expected, " instances");
    requireDeviceMemory(device, "instanceTraversableHandles", handles,
                        count * sizeof(OptixTraversableHandle), sizeof(OptixTraversableHandle));
}

} // namespace

OptixResult accelGetRelocationInfo(OptixDeviceContext context, OptixTraversableHandle handle,
                                   OptixAccelRelocationInfo* info) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelGetRelocationInfo", [&] {
        contextOf(context);
        requireNonNull(info, "info");
        const bvh::RelocationInfo found = engine::relocationInfo(owner->engine, handle);
        std::memcpy(info, &found, sizeof(found));
    });
}

OptixResult accelCheckRelocationCompatibility(OptixDeviceContext context,
                                              const OptixAccelRelocationInfo* info,
                                              int* compatible) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelCheckRelocationCompatibility", [&] {
        contextOf(context);
        requireNonNull(info, "info");
        requireNonNull(compatible, "compatible");
        *compatible = bvh::isRelocatable(translate(*info));
    });
}

OptixResult accelRelocate(OptixDeviceContext context, CUstream stream,
                          const OptixAccelRelocationInfo* info,
                          CUdeviceptr instanceTraversableHandles,
                          size_t numInstanceTraversableHandles, CUdeviceptr targetAccel,
                          size_t targetAccelSizeInBytes, OptixTraversableHandle* targetHandle) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixAccelRelocate", [&] {
        contextOf(context);
        device::Device& device = *owner->engine->device;
        requireNonNull(info, "info");
        requireNonNull(targetHandle, "targetHandle");
        const bvh::RelocationInfo translated = translate(*info);
        if (!bvh::isRelocatable(translated))
            fail(Code::kInvalidValue, "info was not filled by optixAccelGetRelocationInfo of a "
                                      "compatible version");
        const uint64_t size = bvh::relocatedSize(translated);
        if (targetAccelSizeInBytes < size)
            fail(Code::kInvalidValue, "targetAccelSizeInBytes = ", targetAccelSizeInBytes,
                 " is less than the ", size, " bytes of the structure");
        requireDeviceMemory(device, "targetAccel", targetAccel, targetAccelSizeInBytes,
                            OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT);
        checkChildren(device, translated, instanceTraversableHandles,
                      numInstanceTraversableHandles);
        *targetHandle = engine::relocateAccel(
            owner->engine, stream, translated, reinterpret_cast<void*>(targetAccel),
            reinterpret_cast<const uint64_t*>(instanceTraversableHandles),
            numInstanceTraversableHandles);
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
        // Rays would miss what is behind it: better no handle than a wrong picture.
        if (type != engine::TransformType::kStatic)
            fail(Code::kNotSupported, "traversableType = ", unsigned(traversableType),
                 ": motion transforms are not available yet");
        *traversableHandle = engine::transformHandle(reinterpret_cast<const void*>(pointer), type);
    });
}

} // namespace sunstone::optix7
